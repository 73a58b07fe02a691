/* What a pair with a mesh remembers of the last query changes no bit of the next answer: over smooth motions, apart and
 * in contact, beside flat and curved shapes; and so does whatever else might stand there. */
#include "narrow/narrow.h"
#include "solids.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

enum { FRAMES = 25, KINDS = 7, SHAPES = 3 };

/* A tenth of them in CI, all with COLLIDED_NIGHTLY=1 in the environment, few with COLLIDED_BRIEF=1. */
static int tracks(void)
{
    const int nightly = 100;
    return getenv("COLLIDED_NIGHTLY") ? nightly : nightly / (getenv("COLLIDED_BRIEF") ? 50 : 10);
}

static shape other_shape(dice *d, int kind, const shape *mesh)
{
    double x = dice_between(d, 0.1, 0.4), y = dice_between(d, 0.1, 0.4), z = dice_between(d, 0.1, 0.4);
    switch (kind) {
    case 0:
        return (shape){.type = SHAPE_SPHERE, .radius = x};
    case 1:
        return (shape){.type = SHAPE_CAPSULE, .radius = x, .half = {0, 0, z}};
    case 2:
        return (shape){.type = SHAPE_BOX, .half = {x, y, z}};
    case 3:
        return (shape){.type = SHAPE_CYLINDER, .half = {x, x, z}};
    case 4:
        return (shape){.type = SHAPE_ELLIPSOID, .half = {x, y, z}};
    default:
        return *mesh;
    }
}

static void hold_equal(const narrow_result *warm, const narrow_result *cold, const char *when)
{
    bool same =
        memcmp(&warm->lo, &cold->lo, sizeof warm->lo) == 0 && memcmp(&warm->hi, &cold->hi, sizeof warm->hi) == 0;
    same = same && memcmp(&warm->axis, &cold->axis, 3 * sizeof warm->axis) == 0; /* and the points behind it */
    same = same && warm->status == cold->status && warm->method == cold->method;
    same = same && warm->iterations == cold->iterations && warm->manifold.count == cold->manifold.count;
    for (uint32_t i = 0; same && i < cold->manifold.count; i++)
        same = warm->manifold.points[i].feature == cold->manifold.points[i].feature &&
               memcmp(&warm->manifold.points[i].point, &cold->manifold.points[i].point, sizeof(vec3)) == 0;
    if (!same)
        fail_msg("%s: [%.17g, %.17g] (%.17g %.17g %.17g) in %u, without [%.17g, %.17g] (%.17g %.17g %.17g) in %u", when,
            warm->lo, warm->hi, warm->axis.x, warm->axis.y, warm->axis.z, warm->iterations, cold->lo, cold->hi,
            cold->axis.x, cold->axis.y, cold->axis.z, cold->iterations);
}

typedef struct track {
    shape a, b;
    narrow_request request;
    narrow_scratch *scratch;
    narrow_cache cache, strange;
} track;

/* Warm, cold, and with two triangles that have never been near. */
static double frame(track *t, const pose *b_in_a, dice *d)
{
    narrow_result warm = {0}, cold = {0}, strange = {0};
    uint32_t most = t->b.mesh->triangle_count + 3; /* some do not exist */
    t->strange.triangle_a = (uint32_t)dice_between(d, 0, most);
    t->strange.triangle_b = (uint32_t)dice_between(d, 0, most);
    narrow_query(&t->a, &t->b, b_in_a, &t->request, NULL, t->scratch, &cold);
    narrow_query(&t->a, &t->b, b_in_a, &t->request, &t->cache, t->scratch, &warm);
    narrow_query(&t->a, &t->b, b_in_a, &t->request, &t->strange, t->scratch, &strange);
    hold_equal(&warm, &cold, "with its cache");
    hold_equal(&strange, &cold, "with a strange cache");
    return cold.lo;
}

static void a_cache_changes_nothing(void **state)
{
    (void)state;
    static const unsigned FACTS[] = {NARROW_DISTANCE, NARROW_DISTANCE | NARROW_MANIFOLD, NARROW_VERDICT};
    static const double TOLERANCES[] = {0, 1e-9, 1e-6, 1e-2};
    soup soups[SHAPES] = {soup_torus(0.8, 0.3, 24, 12), soup_box(0.9, 0.5, 0.7, 6), soup_icosphere(0.8, 3)};
    narrow_scratch *scratch = aligned_alloc(64, narrow_scratch_size());
    int apart = 0, together = 0;
    assert_non_null(scratch);
    for (int k = 0; k < KINDS * tracks(); k++) {
        dice d = {(uint64_t)k * 977 + 5};
        mesh *m = soup_mesh(&soups[k % SHAPES]);
        track t = {.b = mesh_shape(m, k % 4 == 3 ? 0.02 : 0), .scratch = scratch};
        t.a = other_shape(&d, k % KINDS, &t.b);
        t.request = (narrow_request){
            .facts = FACTS[k / 2 % 3], .tolerance = TOLERANCES[k / 3 % 4], .range = k % 5 ? INFINITY : 0.3};
        pose at = {dice_vec(&d, -1.4, 1.4), dice_quat(&d)};
        vec3 drift = dice_vec(&d, -0.03, 0.03), spin = dice_vec(&d, -0.02, 0.02);
        for (int i = 0; i < FRAMES; i++) {
            double lo = frame(&t, &at, &d);
            apart += lo > 0;
            together += lo <= 0;
            at.p = vec_add(at.p, drift);
            at.q = quat_unit(quat_mul((quat){1, spin.x, spin.y, spin.z}, at.q));
        }
        mesh_destroy(m);
    }
    for (int i = 0; i < SHAPES; i++) soup_free(&soups[i]);
    free(scratch);
    assert_true(apart > KINDS * tracks() && together > KINDS * tracks());
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(a_cache_changes_nothing)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
