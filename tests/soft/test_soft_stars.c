/* Flat stars against an adversary: fans around a vertex, closed and open, flat, folded, turning twice, saddles, that
 * flip within the step or nearly so; pushed on from those that were accepted. None that is accepted has two features
 * that meet, but where they adjoin, by the elementary tests of all pairs. 10^5 stars; COLLIDED_NIGHTLY=1: 10^6;
 * COLLIDED_BRIEF=1: 10^4. */
#include "base/prng.h"
#include "soft/elementary.h"
#include "soft/state.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>

#include <cmocka.h>

enum { AROUND_MOST = 12 };

typedef struct star { /* vertex 0 in the middle, the others around it */
    vec3 start[AROUND_MOST + 1], end[AROUND_MOST + 1];
    uint32_t triangles[AROUND_MOST][3];
    uint32_t around, count; /* vertices, triangles */
} star;

static vec3 noise(uint64_t *seed, double by)
{
    double x = prng_in(seed, -by, by), y = prng_in(seed, -by, by), z = prng_in(seed, -by, by);
    return vec(x, y, z);
}

static star draw(uint64_t *seed)
{
    star s = {.around = 3 + (uint32_t)(prng_bits(seed) % (AROUND_MOST - 2))};
    bool open = prng_bits(seed) % 3 == 0;
    s.count = open ? s.around - 1 : s.around;
    for (uint32_t i = 0; i < s.count; i++) s.triangles[i][1] = 1 + i, s.triangles[i][2] = 1 + (i + 1) % s.around;
    static const double TURNS[] = {1, 1, 1, 0.7, 2, 1.3}, NOISE[] = {0, 1e-9, 0.01, 0.1, 0.3, 0.6, 1};
    double turns = TURNS[prng_bits(seed) % 6], by = NOISE[prng_bits(seed) % 7], way = NOISE[prng_bits(seed) % 7];
    double saddle = prng_in(seed, 0, 1), phase = prng_in(seed, 0, 6);
    for (uint32_t i = 1; i <= s.around; i++) {
        double a = phase + 6.283185307179586 * turns * i / s.around;
        s.start[i] = vec_add(vec(cos(a), sin(a), saddle * cos(2 * a)), noise(seed, by));
        s.end[i] = vec_add(s.start[i], noise(seed, way));
    }
    s.start[0] = noise(seed, by), s.end[0] = vec_add(s.start[0], noise(seed, way));
    return s;
}

/* A star that was accepted, a little nearer to one that is not. */
static void push(star *s, uint64_t *seed)
{
    uint32_t i = (uint32_t)(prng_bits(seed) % (s->around + 1));
    double by = prng_in(seed, 0, 0.5);
    if (prng_bits(seed) % 2)
        s->start[i] = vec_add(s->start[i], noise(seed, by));
    else
        s->end[i] = vec_add(s->end[i], noise(seed, by));
}

static bool accepted(const star *s, const soft_mesh *m)
{
    soft_way ways[AROUND_MOST + 1];
    for (uint32_t i = 0; i <= s->around; i++) ways[i] = (soft_way){s->start[i], s->end[i]};
    return soft_star_is_flat(m, ways, 0);
}

static bool meet(const star *s, const uint32_t v[4], bool edges)
{
    vec3 start[4], end[4];
    elementary_result r;
    for (int i = 0; i < 4; i++) start[i] = s->start[v[i]], end[i] = s->end[v[i]];
    (edges ? elementary_edge_edge : elementary_vertex_face)(start, end, 0, &r);
    return r.status == ELEMENTARY_HIT && r.proof == ELEMENTARY_CERTAIN;
}

static bool has_contact(const star *s, const soft_mesh *m)
{
    uint32_t a[2], b[2];
    size_t edges = soft_mesh_edge_count(m);
    for (uint32_t i = 0; i < edges; i++)
        for (uint32_t k = i + 1; k < edges; k++) {
            soft_mesh_edge(m, i, a), soft_mesh_edge(m, k, b);
            if (a[0] == b[0] || a[0] == b[1] || a[1] == b[0] || a[1] == b[1]) continue;
            if (meet(s, (uint32_t[4]){a[0], a[1], b[0], b[1]}, true)) return true;
        }
    for (uint32_t t = 0; t < s->count; t++)
        for (uint32_t v = 1; v <= s->around; v++) {
            const uint32_t *f = s->triangles[t];
            if (v != f[1] && v != f[2] && meet(s, (uint32_t[4]){v, f[0], f[1], f[2]}, false)) return true;
        }
    return false;
}

static void accepted_stars_do_not_meet(void **state)
{
    (void)state;
    size_t most = getenv("COLLIDED_NIGHTLY") ? 1000000 : getenv("COLLIDED_BRIEF") ? 10000 : 100000;
    size_t flat = 0, refused = 0, refused_in_contact = 0;
    uint64_t seed = 11;
    for (size_t i = 0; i < most;) {
        star s = draw(&seed);
        soft_status status;
        soft_mesh_def def = {
            .rest = s.start, .vertex_count = s.around + 1, .triangles = s.triangles, .triangle_count = s.count};
        soft_mesh *m = soft_mesh_create(&def, &status);
        assert_int_equal(status, SOFT_OK);
        for (int pushes = 0; pushes < 10; pushes++, i++) {
            bool is_flat = accepted(&s, m), contact = (is_flat || i % 8 == 0) && has_contact(&s, m);
            flat += is_flat, refused += !is_flat, refused_in_contact += contact;
            if (is_flat && contact) fail_msg("star %zu: accepted, and two of its features meet", i);
            if (!is_flat) break;
            push(&s, &seed);
        }
        i++;
        soft_mesh_destroy(m);
    }
    printf(
        "%zu accepted, %zu refused, %zu of one in eight of these with a contact\n", flat, refused, refused_in_contact);
    assert_true(flat > most / 20 && refused_in_contact > most / 200);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(accepted_stars_do_not_meet)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
