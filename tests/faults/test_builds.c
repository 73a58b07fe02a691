/* While a client sends large geometry and the daemon builds it, its neighbour asks, moves, and is answered: no tick is
 * long, and what waits is named in Status. With COLLIDED_NIGHTLY=1 the largest that may be sent: ground of 1,446 x
 * 1,446 heights, two meshes of 980,000 triangles, a hull of 65,535 points that crowd together. */
#include "rig.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

typedef struct sizes {
    size_t ground, mesh, hull; /* rows; rows; points */
    double build_s;            /* at most */
} sizes;

static sizes sizes_here(void)
{
    return getenv("COLLIDED_NIGHTLY") ? (sizes){1446, 701, 65535, 280} : (sizes){160, 101, 8000, 60};
}

/* ---- the client that sends it ---- */

static double noise(size_t i)
{
    return sin(12.9898 * (double)i) * 0.5;
}

static collided_shape ground_of(collided *c, size_t rows)
{
    double *heights = calloc(rows * rows, sizeof *heights);
    for (size_t i = 0; i < rows * rows; i++) heights[i] = noise(i);
    collided_shape s = collided_height_field(collided_create_height_field(c, heights, rows, rows, 0.1, 0.1, 1));
    free(heights);
    return s;
}

/* A sheet with bumps; another one for each seed. */
static collided_shape sheet_of(collided *c, size_t rows, size_t seed)
{
    double *points = calloc(3 * rows * rows, sizeof *points);
    int32_t *triangles = calloc(6 * (rows - 1) * (rows - 1), sizeof *triangles), *to = triangles;
    for (size_t i = 0; i < rows * rows; i++) {
        points[3 * i] = 0.01 * (double)(i % rows);
        points[3 * i + 1] = 0.01 * (double)(i / rows);
        points[3 * i + 2] = 0.1 * noise(i + seed);
    }
    for (size_t y = 0; y + 1 < rows; y++)
        for (size_t x = 0; x + 1 < rows; x++) {
            int32_t at = (int32_t)(y * rows + x), up = at + (int32_t)rows;
            const int32_t both[6] = {at, at + 1, up + 1, at, up + 1, up};
            memcpy(to, both, sizeof both);
            to += 6;
        }
    collided_shape s =
        collided_mesh(collided_create_mesh(c, points, rows * rows, triangles, (size_t)(to - triangles) / 3));
    free(points);
    free(triangles);
    return s;
}

static collided_shape crowd_of(collided *c, size_t count)
{
    double *points = calloc(3 * count, sizeof *points);
    for (size_t i = 0; i < count; i++) { /* most of them in one corner of a ball */
        double turn = 2.39996 * (double)i, share = (double)i / (double)count,
               z = i % 8 ? 1 - 1e-4 * share : 1 - 2 * share;
        double r = sqrt(1 - z * z);
        points[3 * i] = r * cos(turn);
        points[3 * i + 1] = r * sin(turn);
        points[3 * i + 2] = z;
    }
    collided_shape s = collided_hull(collided_create_hull(c, points, count));
    free(points);
    return s;
}

static int send_large(const char *uri)
{
    const sizes n = sizes_here();
    collided *c = rig_connect(uri, 30, COLLIDED_REMOVE);
    collided_shape shapes[4] = {
        crowd_of(c, n.hull), sheet_of(c, n.mesh, 1), sheet_of(c, n.mesh, 2), ground_of(c, n.ground)};
    for (int i = 0; i < 4; i++) {
        char name[16];
        collided_body_def def = collided_body_def_default();
        snprintf(name, sizeof name, "large%d", i);
        def.name = name;
        def.shapes = &shapes[i];
        def.shape_count = 1;
        def.pose.position[0] = 1000.0 * (i + 1);
        collided_create_body(c, &def);
    }
    while (collided_poll(c, 0.1) >= 0) continue;
    return 0;
}

/* ---- its neighbour ---- */

typedef struct neighbour {
    collided *c;
    collided_body part;
    heard heard;
    double *times_s; /* of a pose, or a query, until its answer */
    size_t count, room;
    int64_t longest_tick_ns, most_pending, step, again; /* again: poses that were lost, or answered after 0.5 s */
} neighbour;

static void look(neighbour *n)
{
    int64_t tick_ns = rig_counter(n->c, "tick_most_ns"), pending = rig_counter(n->c, "pending_bodies");
    if (tick_ns > n->longest_tick_ns) n->longest_tick_ns = tick_ns;
    if (pending > n->most_pending) n->most_pending = pending;
}

static void ask(neighbour *n)
{
    collided_result result;
    double began_s = 0;
    for (int tries = 0; n->heard.step != n->step || !tries; tries++) { /* over LCM poses may be lost */
        assert_in_range(tries, 0, 60);
        began_s = rig_now_s();
        n->step++;
        n->again += tries > 0;
        rig_move(n->c, n->part, n->step % 2 ? 0.6 : 0.5, n->step);
        while (n->heard.step != n->step && rig_now_s() < began_s + 0.5) collided_poll(n->c, 0.001);
    }
    double moved_s = rig_now_s();
    assert_int_equal(collided_query_distance(n->c, "part", "table", 1e-6, RIG_PATIENCE_S, &result), COLLIDED_OK);
    if (n->count + 2 > n->room) n->times_s = realloc(n->times_s, (n->room = 2 * n->room + 64) * sizeof *n->times_s);
    n->times_s[n->count++] = moved_s - began_s;
    n->times_s[n->count++] = rig_now_s() - moved_s;
    look(n);
}

static int compare_times(const void *a, const void *b)
{
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

static void a_neighbour_is_answered_while_large_geometry_is_built(void **state)
{
    static neighbour n;
    const char *uri = *state;
    const sizes size = sizes_here();
    n = (neighbour){.c = NULL};
    pid_t daemon = rig_daemon(NULL, NULL);
    n.c = rig_connect(uri, 30, COLLIDED_REMOVE);
    rig_box(n.c, "table", 0);
    n.part = rig_box(n.c, "part", 0.5);
    rig_watch(n.c, &n.heard, "part");
    UNTIL(n.c, RIG_PATIENCE_S, n.heard.touching == 1);
    double began_s = rig_now_s();
    rig_self("large", uri, "");
    while (rig_counter(n.c, "bodies") < 6 && rig_now_s() < began_s + size.build_s) {
        ask(&n);
        collided_poll(n.c, 0.01);
    }
    double took_s = rig_now_s() - began_s;
    UNTIL(n.c, RIG_PATIENCE_S, rig_counter(n.c, "bodies") == 6);
    look(&n);
    qsort(n.times_s, n.count, sizeof *n.times_s, compare_times);
    printf("built after %.1f s; longest tick %.1f ms; %zu answers: p50 %.2f, p99 %.2f, longest %.2f ms; again %d; %ld "
           "MB\n",
        took_s, 1e-6 * (double)n.longest_tick_ns, n.count, 1e3 * n.times_s[n.count / 2],
        1e3 * n.times_s[n.count * 99 / 100], 1e3 * n.times_s[n.count - 1], (int)n.again,
        rig_resident_kb(daemon) / 1024);
    assert_true(n.most_pending > 0);
    if (strcmp(uri, RIG_DDS) == 0) assert_int_equal(n.again, 0);
    assert_true(n.longest_tick_ns < 250000000); /* 50 ms, on a machine that has nothing else to do */
    assert_int_equal(n.heard.lost, 0);
    assert_int_equal(n.heard.touching, 1);
    assert_true(rig_alive(daemon));
    free(n.times_s);
    rig_close(n.c);
}

int main(int argc, char **argv)
{
    if (argc == 4) return send_large(argv[2]);
    const struct CMUnitTest tests[] = {OVER_BOTH(a_neighbour_is_answered_while_large_geometry_is_built)};
    rig_isolate();
    return cmocka_run_group_tests(tests, NULL, NULL);
}
