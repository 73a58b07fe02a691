/* Covers: random points of shapes of all types are in one of the balls, and the balls are not much larger. */
#include "geom/compound.h"
#include "geom/mesh.h"
#include "geom/random_shapes.h"
#include "geom/support.h"
#include "robot/cover.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>

#include <cmocka.h>

static bool is_covered(const cover *c, vec3 p)
{
    for (size_t i = 0; i < c->count; i++)
        if (vec_norm(vec_sub(p, c->at[i].centre)) <= c->at[i].radius) return true;
    return false;
}

static vec3 shape_farthest(const shape *s, vec3 direction)
{
    uint32_t hint = 0;
    return vec_madd(support_core(s, direction, &hint), s->radius, direction);
}

/* Points between support points: all of them belong to a convex shape. */
static void points_are_covered(uint64_t *seed, const shape *s, pose at)
{
    cover c = {0};
    assert_true(cover_shape(s, at, &c));
    assert_true(c.count >= 1 && c.count <= COVER_SLABS_MAX);
    for (int i = 0; i < 200; i++) {
        vec3 a = shape_farthest(s, random_unit(seed)), b = shape_farthest(s, random_unit(seed));
        vec3 p = vec_madd(a, prng_in(seed, 0, 1), vec_sub(b, a));
        assert_true(is_covered(&c, pose_point(at, a)));
        assert_true(is_covered(&c, pose_point(at, p)));
    }
    cover_ball whole = cover_whole(c.at, c.count);
    for (size_t i = 0; i < c.count; i++)
        assert_true(vec_norm(vec_sub(whole.centre, c.at[i].centre)) + c.at[i].radius <= whole.radius * (1 + 1e-12));
    assert_true(whole.radius <= 3.5 * shape_reach(s) + 1e-12);
    array_free(&c);
}

static void test_convex(void **state)
{
    (void)state;
    uint64_t seed = 6;
    for (int round = 0; round < 4000; round++) {
        shape s = random_plain_shape(&seed, prng_bits(&seed) % 3 ? 0.2 : 5);
        hull *h = NULL;
        if (round % 4 == 0 && (h = random_hull(&seed, 4 + prng_bits(&seed) % 60, 0.3, prng_bits(&seed) % 2)))
            s = (shape){.type = SHAPE_HULL, .hull = h, .radius = prng_bits(&seed) % 2 ? 0 : 0.01};
        points_are_covered(&seed, &s, random_pose(&seed, 1));
        if (h) hull_destroy(h);
    }
}

/* A tube of a square section, open at both ends, as a solid: points of its wall are covered. */
static void test_mesh(void **state)
{
    (void)state;
    double points[16 * 3];
    int32_t corners[32 * 3];
    size_t count = 0;
    for (int i = 0; i < 16; i++) {
        double r = i % 8 < 4 ? 1 : 0.6, x = (i & 1) ^ (i >> 1 & 1) ? r : -r, y = i & 2 ? r : -r;
        points[3 * i] = x, points[3 * i + 1] = y, points[3 * i + 2] = i < 8 ? -4 : 4;
    }
    for (int i = 0; i < 4; i++) {
        int k = (i + 1) % 4;
        int faces[4][4] = {
            {i, k, 8 + k, 8 + i}, {4 + k, 4 + i, 12 + i, 12 + k}, {k, i, 4 + i, 4 + k}, {8 + i, 8 + k, 12 + k, 12 + i}};
        for (int f = 0; f < 4; f++)
            for (int t = 0; t < 2; t++) {
                corners[count++] = faces[f][0];
                corners[count++] = faces[f][1 + t];
                corners[count++] = faces[f][2 + t];
            }
    }
    mesh *m;
    assert_int_equal(mesh_build(points, 16, corners, count / 3, &m), MESH_OK);
    assert_true(m->solid);
    shape s = {.type = SHAPE_MESH, .mesh = m, .hull = m->hull};
    cover c = {0};
    assert_true(cover_shape(&s, POSE_IDENTITY, &c));
    assert_true(c.count > 1);
    uint64_t seed = 7;
    for (int i = 0; i < 2000; i++) {
        vec3 p = vec(prng_in(&seed, 0.6, 1), prng_in(&seed, -1, 1), prng_in(&seed, -4, 4));
        assert_true(is_covered(&c, i % 2 ? p : vec(p.y, -p.x, p.z)));
    }
    array_free(&c);
    mesh_destroy(m);
}

static void test_compound(void **state)
{
    (void)state;
    shape children[] = {{.type = SHAPE_SPHERE, .radius = 0.1}, {.type = SHAPE_BOX, .half = {0.1, 0.2, 0.3}}};
    pose locals[] = {{{1, 0, 0}, {1, 0, 0, 0}}, {{0, 1, 0}, {0, 1, 0, 0}}};
    compound *c;
    assert_int_equal(compound_build(children, locals, 2, &c), COMPOUND_OK);
    shape s = {.type = SHAPE_COMPOUND, .compound = c, .radius = 0.01};
    cover balls = {0};
    assert_true(cover_shape(&s, POSE_IDENTITY, &balls));
    assert_true(is_covered(&balls, vec(1.109, 0, 0)));
    assert_true(is_covered(&balls, vec(0.1, 1.2, 0.309)));
    array_free(&balls);
    compound_destroy(c);
    shape ground = {.type = SHAPE_HALFSPACE};
    assert_false(cover_shape(&ground, POSE_IDENTITY, &balls));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_convex), cmocka_unit_test(test_mesh), cmocka_unit_test(test_compound)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
