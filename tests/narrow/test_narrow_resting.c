/* Ids of contact points of what rests: a body that lies on another and trembles by 1e-9 keeps its contact points and
 * their ids, whoever is asked first.
 *
 * The rule that is held here: ids follow from the two poses alone. They name corners, edges and faces, and which of
 * them are chosen does not change as long as no two candidates are equally deep, or equally far out, to within the
 * motion. The resting poses below are such: flush faces of different sizes, off the middle and turned by an angle that
 * is no symmetry of either. That the face of one or of the other body is the reference does not enter an id. */
#include "cases.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>

#include <cmocka.h>
#include <stdlib.h>

enum { TREMBLES = 400, FOUR = 4 };

static const double TREMBLE = 1e-9;

static hull *prism; /* five-sided, 1 high */

static hull *make_prism(void)
{
    static const double RIM[5][2] = {{1, 0.1}, {0.2, 0.9}, {-0.8, 0.6}, {-0.7, -0.7}, {0.4, -0.8}};
    double points[30];
    hull *h = NULL;
    for (int i = 0; i < 10; i++)
        points[3 * i] = RIM[i % 5][0], points[3 * i + 1] = RIM[i % 5][1], points[3 * i + 2] = i < 5 ? -0.5 : 0.5;
    assert_int_equal(hull_build(points, 10, 0, &h), HULL_OK);
    return h;
}

static narrow_result ask(const shape *a, pose pa, const shape *b, pose pb)
{
    const narrow_request request = {
        .facts = NARROW_DISTANCE | NARROW_MANIFOLD, .tolerance = 1e-9, .range = INFINITY, .threshold = 1e-4};
    narrow_result r;
    narrow_query_world(a, pa, b, pb, &request, case_scratch(), &r);
    return r;
}

/* As feature ids are told of (B, A): each body has one half of the bits. */
static uint64_t turned(uint64_t feature)
{
    enum { HALF = 4 * sizeof((manifold_point *)NULL)->feature };
    return (feature & ((UINT64_C(1) << HALF) - 1)) << HALF | feature >> HALF;
}

static bool has(const manifold *m, uint64_t feature)
{
    for (uint32_t i = 0; i < m->count; i++)
        if (m->points[i].feature == feature) return true;
    return false;
}

static void tremble(const shape *upper, const shape *ground, pose at, uint32_t points)
{
    random_state random = {99};
    narrow_result first = ask(upper, at, ground, POSE_IDENTITY);
    assert_int_equal(first.manifold.count, points);
    for (int i = 0; i < TREMBLES; i++) {
        vec3 spin = vec_scale(random_direction(&random), TREMBLE);
        pose near = {vec_madd(at.p, TREMBLE, random_direction(&random)),
            quat_unit(quat_mul((quat){1, spin.x, spin.y, spin.z}, at.q))};
        narrow_result r = ask(upper, near, ground, POSE_IDENTITY), q = ask(ground, POSE_IDENTITY, upper, near);
        assert_int_equal(r.manifold.count, points);
        assert_int_equal(q.manifold.count, points);
        for (uint32_t k = 0; k < points; k++) {
            if (r.manifold.points[k].feature != first.manifold.points[k].feature)
                fail_msg("%s on %s, %g above: id %llx was %llx", shape_type_name(upper->type),
                    shape_type_name(ground->type), at.p.z, (unsigned long long)r.manifold.points[k].feature,
                    (unsigned long long)first.manifold.points[k].feature);
            assert_true(has(&q.manifold, turned(r.manifold.points[k].feature)));
        }
    }
}

static void ids_of_what_rests_do_not_flicker(void **state)
{
    (void)state;
    const quat yaw = {0.96, 0, 0, 0.28}, lying = {0.70710678118654757, 0, 0.70710678118654757, 0};
    const shape ground[] = {{.type = SHAPE_BOX, .half = {3, 2, 1}}, {.type = SHAPE_HALFSPACE}};
    const double top[] = {1, 0}, sunk[] = {1e-5, 0, -1e-5};
    for (int g = 0; g < 2; g++)
        for (int s = 0; s < 3; s++) {
            double z = top[g] + sunk[s];
            const shape box = {.type = SHAPE_BOX, .half = {0.5, 0.4, 0.3}},
                        rod = {.type = SHAPE_CAPSULE, .radius = 0.2, .half = {0, 0, 0.6}},
                        drum = {.type = SHAPE_CYLINDER, .half = {0.3, 0.3, 0.5}},
                        ball = {.type = SHAPE_SPHERE, .radius = 0.4}, stone = {.type = SHAPE_HULL, .hull = prism};
            tremble(&box, &ground[g], (pose){{0.21, 0.13, z + 0.3}, yaw}, FOUR);
            tremble(&rod, &ground[g], (pose){{0.21, 0.13, z + 0.2}, lying}, 2);
            tremble(&drum, &ground[g], (pose){{0.21, 0.13, z + 0.3}, lying}, 2);
            tremble(&ball, &ground[g], (pose){{0.21, 0.13, z + 0.4}, yaw}, 1);
            tremble(&stone, &ground[g], (pose){{0.21, 0.13, z + 0.5}, yaw}, FOUR);
        }
}

static int create(void **state)
{
    (void)state;
    prism = make_prism();
    return 0;
}

static int destroy(void **state)
{
    (void)state;
    hull_destroy(prism);
    return 0;
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(ids_of_what_rests_do_not_flicker)};
    return cmocka_run_group_tests(tests, create, destroy);
}
