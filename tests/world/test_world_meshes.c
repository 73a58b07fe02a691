/* Meshes in a world: what is inside of a solid touches it, what is in a hollow does not, and contacts end once. */
#include "geom/mesh.h"
#include "scene.h"

#include <math.h>
#include <stdlib.h>

/* A trough along y: outer half extents (1, 1, 1), walls and floor 0.25 thick, open at +z. */
static mesh *trough(void)
{
    static const double X[8] = {-1, 1, 1, 0.75, 0.75, -0.75, -0.75, -1}, Z[8] = {-1, -1, 1, 1, -0.75, -0.75, 1, 1};
    static const int32_t CAPS[6][3] = {{0, 1, 4}, {0, 4, 5}, {1, 2, 3}, {1, 3, 4}, {0, 5, 6}, {0, 6, 7}};
    double points[48];
    int32_t corners[28 * 3], *to = corners;
    for (int i = 0; i < 16; i++) {
        points[3 * i] = X[i % 8];
        points[3 * i + 1] = i < 8 ? -1 : 1;
        points[3 * i + 2] = Z[i % 8];
    }
    for (int32_t i = 0; i < 8; i++) {
        int32_t j = (i + 1) % 8;
        const int32_t side[6] = {i, 8 + i, 8 + j, i, 8 + j, j};
        memcpy(to, side, sizeof side), to += 6;
    }
    for (int i = 0; i < 6; i++) {
        const int32_t caps[6] = {CAPS[i][0], CAPS[i][1], CAPS[i][2], 8 + CAPS[i][0], 8 + CAPS[i][2], 8 + CAPS[i][1]};
        memcpy(to, caps, sizeof caps), to += 6;
    }
    mesh *m;
    assert_int_equal(mesh_build(points, 16, corners, 28, &m), MESH_OK);
    assert_true(m->solid);
    return m;
}

static uint32_t put(world *w, const char *name, shape s, vec3 at)
{
    return scene_body(w, name, (world_shape){s, POSE_IDENTITY}, at);
}

static shape shape_of(const mesh *m)
{
    return (shape){.type = SHAPE_MESH, .hull = m->hull, .mesh = m};
}

static size_t count_events(const world_batch *b, event_kind kind)
{
    size_t n = 0;
    for (size_t i = 0; b && i < b->count; i++) n += b->events[i].kind == kind;
    return n;
}

static void a_box_in_the_hollow_of_a_trough_does_not_touch_it(void **state)
{
    (void)state;
    mesh *m = trough();
    world *w = scene_world(1, true);
    uint32_t a = put(w, "trough", shape_of(m), VEC_ZERO);
    uint32_t b = put(w, "box", (shape){.type = SHAPE_BOX, .half = {0.5, 0.5, 0.5}}, vec(0, 0, 0));
    world_subscription all = scene_all(WORLD_TOUCH, 0);
    scene_subscription(w, &all);
    assert_int_equal(count_events(scene_tick(w, 0), EVENT_BEGIN), 0);
    world_hits hits = {0};
    world_query_distance(w, a, b, 1e-9, 0, &hits);
    assert_true(hits.at[0].lo <= 0.25 && 0.25 <= hits.at[0].hi && hits.at[0].hi - hits.at[0].lo < 1e-9);
    world_move_body(w, b, (pose){{0, 0, -0.26}, {1, 0, 0, 0}}, 0, NULL, NULL);
    assert_int_equal(count_events(scene_tick(w, 0), EVENT_BEGIN), 1);
    world_move_body(w, b, (pose){{0, 0, 0.1}, {1, 0, 0, 0}}, 0, NULL, NULL);
    assert_int_equal(count_events(scene_tick(w, 0), EVENT_END), 1);
    free(hits.at);
    world_destroy(w);
    mesh_destroy(m);
}

static void a_ball_passes_through_a_solid_in_one_contact(void **state)
{
    (void)state;
    for (unsigned workers = 1; workers <= 3; workers += 2) {
        mesh *m = trough();
        world *w = scene_world(workers, true);
        put(w, "trough", shape_of(m), VEC_ZERO);
        uint32_t ball = put(w, "ball", (shape){.type = SHAPE_SPHERE, .radius = 0.02}, vec(0.875, 0, 2));
        world_subscription all = scene_all(WORLD_TOUCH | WORLD_DISTANCE | WORLD_MANIFOLD, 0);
        scene_subscription(w, &all);
        size_t begins = 0, ends = 0, touching = 0;
        for (int k = 0; k <= 400; k++) { /* down inside of the wall, nowhere near a surface for most of the way */
            world_move_body(w, ball, (pose){{0.875, 0, 2 - 0.01 * k}, {1, 0, 0, 0}}, 0, NULL, NULL);
            const world_batch *b = scene_tick(w, 0);
            begins += count_events(b, EVENT_BEGIN);
            ends += count_events(b, EVENT_END);
            bool in = fabs(2 - 0.01 * k) < 1.019;
            touching += in;
            for (size_t i = 0; in && b && i < b->count; i++)
                if (b->events[i].kind == EVENT_UPDATE) assert_true(b->events[i].hi < 0);
            if (k == 200) /* 0.125 from either side of the wall */
                assert_true(b->count > 0 && b->events[0].lo <= -0.145 && b->events[0].hi >= -0.145 - 1e-9);
        }
        assert_true(touching > 150);
        assert_int_equal(begins, 1);
        assert_int_equal(ends, 1);
        world_destroy(w);
        mesh_destroy(m);
    }
}

static void rays_and_boxes_see_the_hollow(void **state)
{
    (void)state;
    mesh *m = trough();
    world *w = scene_world(1, true);
    uint32_t id = put(w, "trough", shape_of(m), VEC_ZERO);
    scene_tick(w, 0);
    world_hits hits = {0};
    world_query_ray(w, vec(0.1, 0.2, 5), vec(0, 0, -1), INFINITY, 1e-6, 0, &hits);
    assert_int_equal(hits.count, 1);
    assert_true(hits.at[0].lo <= 5.75 && 5.75 <= hits.at[0].hi + 1e-6 && hits.at[0].lo > 5.749);
    hits.count = 0;
    world_query_ray(w, vec(0.1, -5, 0.2), vec(0, 1, 0), INFINITY, 1e-6, 0, &hits); /* along the hollow */
    assert_int_equal(hits.count, 0);
    world_query_cast(w, (pose){{0, -5, 0}, {1, 0, 0, 0}}, vec(0.7, 0.1, 0.7), vec(0, 1, 0), 20, 1e-6, 0, &hits);
    assert_int_equal(hits.count, 0);
    world_query_box(w, (pose){{0, 0, 0.2}, {1, 0, 0, 0}}, vec(0.7, 0.7, 0.7), 0, &hits);
    assert_int_equal(hits.count, 0);
    world_query_box(w, (pose){{0.875, 0, 0.2}, {1, 0, 0, 0}}, vec(0.01, 0.01, 0.01), 0, &hits);
    assert_int_equal(hits.count, 1);
    assert_int_equal(hits.at[0].body_a, id);
    hits.count = 0;
    world_query_nearest(w, (pose){VEC_ZERO, {1, 0, 0, 0}}, VEC_ZERO, 10, 1, 1e-9, 0, &hits);
    assert_int_equal(hits.count, 1);
    assert_true(hits.at[0].lo <= 0.75 && hits.at[0].hi >= 0.75 && hits.at[0].hi - hits.at[0].lo < 1e-9);
    free(hits.at);
    world_destroy(w);
    mesh_destroy(m);
}

/* A tetrahedron far away, a needle, and a segment that the tetrahedron has: a body that passes through the trough's
 * wall at the needle, and is told of as what it is. */
static void a_needle_is_met_by_contacts_rays_and_casts(void **state)
{
    (void)state;
    static const double POINTS[] = {9, 0, 0, 10, 0, 0, 9, 1, 0, 9, 0, 1, -0.05, 0, 0, 0.05, 0, 0, 0.02, 0, 0};
    static const int32_t CORNERS[] = {0, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 3, 4, 6, 5, 0, 1, 1};
    mesh *m = trough(), *needle;
    assert_int_equal(mesh_build(POINTS, 7, CORNERS, 6, &needle), MESH_OK);
    world *w = scene_world(1, true);
    uint32_t a = put(w, "trough", shape_of(m), VEC_ZERO), b = put(w, "needle", shape_of(needle), vec(0.6, 0, 0.5));
    world_subscription all = scene_all(WORLD_TOUCH | WORLD_MANIFOLD, 0);
    scene_subscription(w, &all);
    assert_int_equal(count_events(scene_tick(w, 0), EVENT_BEGIN), 0);
    world_move_body(w, b, (pose){{0.875, 0, 0.5}, {1, 0, 0, 0}}, 0, NULL, NULL); /* wholly in the wall */
    const world_batch *batch = scene_tick(w, 0);
    assert_int_equal(count_events(batch, EVENT_BEGIN), 1);
    assert_true(batch->events[0].lo <= -0.125 && batch->events[0].hi < 0);
    world_move_body(w, b, (pose){{3, 0, 0.5}, {1, 0, 0, 0}}, 0, NULL, NULL);
    assert_int_equal(count_events(scene_tick(w, 0), EVENT_END), 1);
    world_hits hits = {0};
    world_query_ray(w, vec(3.01, 0, 5), vec(0, 0, -1), INFINITY, 1e-6, 0, &hits);
    assert_int_equal(hits.count, 1);
    assert_true(hits.at[0].body_a == b && hits.at[0].lo <= 4.5 && hits.at[0].lo > 4.499);
    hits.count = 0;
    world_query_box(w, (pose){{3, 0, 0.5}, {1, 0, 0, 0}}, vec(0.2, 0.2, 0.2), 0, &hits);
    assert_true(hits.count == 1 && hits.at[0].body_a == b);
    char text[2048];
    assert_true(world_explain(w, a, b, 0, text, sizeof text) > 0);
    assert_non_null(strstr(text, "mesh, a solid; left out: 1 triangle without area; kept as segments or points: 1 "));
    free(hits.at);
    world_destroy(w);
    mesh_destroy(needle);
    mesh_destroy(m);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_box_in_the_hollow_of_a_trough_does_not_touch_it),
        cmocka_unit_test(a_ball_passes_through_a_solid_in_one_contact),
        cmocka_unit_test(rays_and_boxes_see_the_hollow),
        cmocka_unit_test(a_needle_is_met_by_contacts_rays_and_casts),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
