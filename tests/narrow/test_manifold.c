/* Properties of contact manifolds. Axis and witnesses are given by construction (a face of A along +z, B's lowest
 * support point above or below it), so the oracle is the geometry of the case and not another narrow phase. */
#include "geom/random_shapes.h"
#include "geom/support.h"
#include "narrow/contact/manifold.h"
#include "narrow/narrow.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdlib.h>

#include <cmocka.h>

static const double PI = 3.14159265358979323846;
static const vec3 UP = {0, 0, 1};

static quat turned(vec3 about, double angle)
{
    vec3 v = vec_scale(about, sin(angle / 2));
    return (quat){cos(angle / 2), v.x, v.y, v.z};
}

static shape box_of(double x, double y, double z)
{
    return (shape){.type = SHAPE_BOX, .half = {x, y, z}};
}
static shape capsule_of(double r, double h)
{
    return (shape){.type = SHAPE_CAPSULE, .radius = r, .half = {0, 0, h}};
}
static shape cylinder_of(double r, double h)
{
    return (shape){.type = SHAPE_CYLINDER, .half = {r, r, h}};
}

/* The manifold of B over the top of A (at height `top`, facing +z): the witness is B's lowest point. */
static double build_above(const shape *a, double top, const shape *b, pose at, double threshold, manifold *out)
{
    transform t = pose_transform(at);
    vec3 low = transform_point(&t, support_core(b, mat_tmul(t.r, vec_neg(UP)), NULL));
    low.z -= b->radius;
    vec3 on_a = vec(low.x, low.y, top);
    manifold_build(a, b, &t, UP, on_a, low, threshold, out);
    return low.z - top;
}

static bool has_point(const manifold *m, vec3 p, double slack)
{
    for (uint32_t i = 0; i < m->count; i++)
        if (vec_norm(vec_sub(m->points[i].point, p)) <= slack) return true;
    return false;
}

static double deepest(const manifold *m)
{
    double least = INFINITY;
    for (uint32_t i = 0; i < m->count; i++) least = fmin(least, m->points[i].distance);
    return least;
}

static void a_box_on_a_box_touches_at_the_four_corners_of_the_smaller_face(void **state)
{
    (void)state;
    shape a = box_of(2, 3, 1), b = box_of(0.5, 0.25, 0.5);
    manifold m;
    build_above(&a, 1, &b, (pose){{0.1, 0.2, 1.49}, {1, 0, 0, 0}}, 0, &m);
    assert_int_equal(m.count, 4);
    for (int i = 0; i < 4; i++) {
        assert_true(has_point(&m, vec(0.1 + (i & 1 ? 0.5 : -0.5), 0.2 + (i & 2 ? 0.25 : -0.25), 0.995), 1e-15));
        assert_true(fabs(m.points[i].distance + 0.01) < 1e-15);
    }
}

static void a_box_overhanging_is_clipped_by_the_edge_below(void **state)
{
    (void)state;
    shape a = box_of(1, 1, 1), b = box_of(1, 0.5, 1);
    manifold m;
    build_above(&a, 1, &b, (pose){{0.75, 0, 2}, {1, 0, 0, 0}}, 0.1, &m);
    assert_int_equal(m.count, 4);
    const double x[] = {-0.25, 1};
    for (int i = 0; i < 4; i++) assert_true(has_point(&m, vec(x[i & 1], i & 2 ? 0.5 : -0.5, 1), 1e-15));
}

static void a_box_turned_by_an_eighth_keeps_four_of_the_eight_corners_of_the_octagon(void **state)
{
    (void)state;
    shape a = box_of(1, 1, 1), b = a;
    manifold m;
    build_above(&a, 1, &b, (pose){{0, 0, 2.1}, turned(UP, PI / 4)}, 0.2, &m);
    assert_int_equal(m.count, 4);
    for (uint32_t i = 0; i < 4; i++) {
        vec3 p = m.points[i].point; /* corners of the octagon: (1, sqrt 2 - 1) and its mirror images */
        assert_true(fabs(fmax(fabs(p.x), fabs(p.y)) - 1) < 1e-12);
        assert_true(fabs(fmin(fabs(p.x), fabs(p.y)) - (sqrt(2) - 1)) < 1e-12);
        assert_true(fabs(m.points[i].distance - 0.1) < 1e-12);
    }
}

static void crossing_edges_touch_in_one_point(void **state)
{
    (void)state;
    shape a = box_of(1, 1, 1), b = a;
    transform b_in_a = pose_transform((pose){{0, 0, 2 * sqrt(2)}, {1, 0, 0, 0}});
    mat3 r = quat_matrix(turned(vec(1, 0, 0), PI / 4)), s = quat_matrix(turned(vec(0, 1, 0), PI / 4));
    /* A lies on its edge along x, B on its edge along y; told in A's frame. */
    vec3 axis = mat_tmul(r, UP);
    b_in_a.r = (mat3){mat_tmul(r, s.x), mat_tmul(r, s.y), mat_tmul(r, s.z)};
    b_in_a.t = mat_tmul(r, b_in_a.t);
    vec3 touch = mat_tmul(r, vec(0, 0, sqrt(2)));
    manifold m;
    manifold_build(&a, &b, &b_in_a, axis, touch, touch, 0.5, &m);
    assert_int_equal(m.count, 1);
    assert_true(has_point(&m, touch, 1e-12));
    assert_true(m.points[0].distance == 0);
}

static void parallel_edges_touch_along_their_common_stretch(void **state)
{
    (void)state;
    shape a = box_of(1, 1, 1), b = capsule_of(0.5, 3);
    quat tilt = turned(vec(1, 0, 0), PI / 4); /* an edge of A along x is on top */
    vec3 axis = quat_rotate(quat_conj(tilt), UP), touch = vec_scale(axis, sqrt(2));
    quat along_x = turned(vec(0, 1, 0), PI / 2);
    transform t = {quat_matrix(along_x), vec_scale(axis, sqrt(2) + 0.5)};
    manifold m;
    manifold_build(&a, &b, &t, axis, touch, touch, 0.01, &m);
    assert_int_equal(m.count, 2);
    assert_true(has_point(&m, vec_add(touch, vec(1, 0, 0)), 1e-12));
    assert_true(has_point(&m, vec_add(touch, vec(-1, 0, 0)), 1e-12));
}

static double outside_box(const shape *box, vec3 p)
{
    vec3 over = {fabs(p.x) - box->half.x, fabs(p.y) - box->half.y, fabs(p.z) - box->half.z};
    return vec_norm(vec(fmax(over.x, 0), fmax(over.y, 0), fmax(over.z, 0))) - box->radius;
}

/* Two planks that stand on edge, the one across the other at an angle of almost nothing, and that touch, sink in or are
 * a little apart: where the one edge is beside the other by more than that, there is no contact. */
static void edges_that_are_almost_parallel_touch_only_where_they_cross(void **state)
{
    (void)state;
    int stretches = 0, points = 0;
    for (int i = 0; i < 2000; i++) {
        uint64_t seed = (uint64_t)i;
        double radius = i % 4 ? 0 : 0.01, gap = pow(10, prng_in(&seed, -12, -3)) * (i % 3 - 1);
        shape a = box_of(1, 0.02, 0.02), b = box_of(0.5, 0.03, 0.03);
        a.radius = radius;
        quat lean = turned(vec(1, 0, 0), PI / 4); /* an edge of either along x is on top */
        quat turn = turned(UP, pow(10, prng_in(&seed, -9, -2.1)) * (i % 2 ? 1 : -1));
        vec3 up = quat_rotate(quat_conj(lean), UP), top = vec_scale(up, 0.02 * sqrt(2));
        pose at = {vec(0, 0, 0.05 * sqrt(2) + radius + gap), quat_mul(turn, lean)};
        vec3 along = vec_scale(quat_rotate(turn, vec(1, 0, 0)), prng_in(&seed, -0.9, 0.9));
        at.p = vec_add(at.p, along); /* the edges still cross above the middle of A's, or beyond an end of B's */
        pose in_a = {quat_rotate(quat_conj(lean), at.p), quat_mul(quat_conj(lean), at.q)};
        transform t = pose_transform(in_a);
        vec3 on_b = vec_madd(top, radius + gap, up), on_a = vec_madd(top, radius, up);
        manifold m;
        manifold_build(&a, &b, &t, up, on_a, on_b, 0.01, &m);
        stretches += m.count > 1;
        for (uint32_t k = 0; k < m.count; k++) {
            vec3 p = m.points[k].point, local = quat_rotate(quat_conj(in_a.q), vec_sub(p, in_a.p));
            double room = 2 * fabs(gap) + 4e-6; /* on either side of the flush ratio's */
            if (m.points[k].feature == feature_witness()) continue;
            if (outside_box(&a, p) > room || outside_box(&b, local) > room)
                fail_msg("%d: gap %g, out of A %g, of B %g", i, gap, outside_box(&a, p), outside_box(&b, local));
            points++;
        }
    }
    assert_true(stretches > 500 && points > 1000);
}

static void a_capsule_lying_on_a_box_touches_in_two_points(void **state)
{
    (void)state;
    shape a = box_of(2, 2, 1), b = capsule_of(0.25, 0.75);
    manifold m;
    build_above(&a, 1, &b, (pose){{0, 0, 1.24}, turned(vec(0, 1, 0), PI / 2)}, 0, &m);
    assert_int_equal(m.count, 2);
    assert_true(has_point(&m, vec(0.75, 0, 0.995), 1e-12));
    assert_true(has_point(&m, vec(-0.75, 0, 0.995), 1e-12));
    assert_true(fabs(deepest(&m) + 0.01) < 1e-12);
    build_above(&a, 1, &b, (pose){{2, 0, 1.24}, turned(vec(0, 1, 0), PI / 2)}, 0, &m);
    assert_int_equal(m.count, 2);
    assert_true(has_point(&m, vec(2, 0, 0.995), 1e-12)); /* cut off at the edge */
}

/* Upright but for noise: its lower end alone, by one id, whichever end that is. */
static void a_capsule_standing_on_a_box_touches_in_one_point(void **state)
{
    (void)state;
    shape a = box_of(1, 1, 1), b = capsule_of(0.5, 0.25), plane = {.type = SHAPE_HALFSPACE};
    static const double LEANS[] = {0, 1e-16, 1e-13, 1e-11, 1e-8};
    for (int upside_down = 0; upside_down < 2; upside_down++)
        for (int on_plane = 0; on_plane < 2; on_plane++) {
            uint64_t feature = 0;
            for (size_t i = 0; i < sizeof LEANS / sizeof *LEANS; i++) {
                quat q = quat_unit(quat_mul(turned(vec(1, 0, 0), LEANS[i]), turned(vec(0, 1, 0), upside_down * PI)));
                double top = on_plane ? 0 : 1;
                manifold m;
                build_above(on_plane ? &plane : &a, top, &b, (pose){{0.1, 0.2, top + 0.125}, q}, 0, &m);
                assert_int_equal(m.count, 1);
                assert_true(fabs(m.points[0].distance + 0.625) < 1e-12);
                if (i) assert_int_equal(m.points[0].feature, feature);
                feature = m.points[0].feature;
            }
        }
}

static void a_cylinder_standing_on_a_box_touches_in_four_points_of_its_disc(void **state)
{
    (void)state;
    shape a = box_of(2, 2, 1), b = cylinder_of(0.5, 1);
    manifold m;
    for (int i = 0; i < 10; i++) {
        build_above(&a, 1, &b, (pose){{1.8, 0.3, 2}, turned(UP, 0.1 * i)}, 0.01, &m);
        assert_int_equal(m.count, 4);
        for (uint32_t k = 0; k < 4; k++) {
            vec3 p = m.points[k].point;
            assert_true(hypot(p.x - 1.8, p.y - 0.3) <= 0.5 + 1e-12);
            assert_true(p.x <= 2 + 1e-12);
            assert_true(fabs(m.points[k].distance) < 1e-12);
        }
    }
}

static void a_cylinder_lying_on_a_box_touches_in_two_points(void **state)
{
    (void)state;
    shape a = box_of(2, 2, 1), b = cylinder_of(0.5, 0.8);
    manifold m;
    build_above(&a, 1, &b, (pose){{0, 0, 1.5}, turned(vec(1, 0, 0), PI / 2)}, 0.01, &m);
    assert_int_equal(m.count, 2);
    assert_true(has_point(&m, vec(0, 0.8, 1), 1e-12));
    assert_true(has_point(&m, vec(0, -0.8, 1), 1e-12));
}

static void a_tilted_cylinder_touches_at_the_lowest_point_of_its_rim(void **state)
{
    (void)state;
    shape a = box_of(2, 2, 1), b = cylinder_of(0.5, 1);
    uint64_t seed = 31;
    for (int i = 0; i < 200; i++) {
        quat tilt = quat_mul(turned(UP, prng_in(&seed, 0, 6)), turned(vec(1, 0, 0), prng_in(&seed, 0.02, 0.6)));
        manifold m;
        double distance =
            build_above(&a, 1, &b, (pose){{0, 0, 2.1}, quat_mul(tilt, turned(UP, prng_in(&seed, 0, 6)))}, 1, &m);
        assert_true(m.count >= 2 && m.count <= 4);
        assert_true(fabs(deepest(&m) - distance) < 1e-6);
    }
}

static void a_sphere_touches_in_one_point(void **state)
{
    (void)state;
    shape a = {.type = SHAPE_SPHERE, .radius = 0.5}, b = box_of(1, 1, 1);
    transform t = pose_transform((pose){{0, 0, 1.5}, {1, 0, 0, 0}});
    manifold m;
    manifold_build(&a, &b, &t, UP, vec(0, 0, 0.5), vec(0, 0, 0.5), 0.01, &m);
    assert_int_equal(m.count, 1);
    assert_true(has_point(&m, vec(0, 0, 0.5), 0));
}

static void a_box_on_a_halfspace_touches_in_four_points(void **state)
{
    (void)state;
    shape a = box_of(0.5, 0.6, 0.7), b = {.type = SHAPE_HALFSPACE, .radius = 0.1};
    quat upside_down = turned(vec(1, 0, 0), PI); /* the canonical order has the box first: the floor is its B, below */
    transform t = pose_transform((pose){{0, 0, 0.75}, upside_down});
    manifold m;
    manifold_build(&a, &b, &t, UP, vec(0, 0, 0.7), vec(0, 0, 0.65), 0, &m);
    assert_int_equal(m.count, 4);
    for (int i = 0; i < 4; i++) {
        assert_true(has_point(&m, vec(i & 1 ? 0.5 : -0.5, i & 2 ? 0.6 : -0.6, 0.675), 1e-12));
        assert_true(fabs(m.points[i].distance + 0.05) < 1e-12);
    }
    shape lying = capsule_of(0.3, 1), hull_floor = {.type = SHAPE_HALFSPACE};
    quat along_x = turned(vec(0, 1, 0), PI / 2);
    build_above(&hull_floor, 0, &lying, (pose){{5, 6, 0.3}, along_x}, 0.01, &m);
    assert_int_equal(m.count, 2);
    assert_true(has_point(&m, vec(6, 6, 0), 1e-12) && has_point(&m, vec(4, 6, 0), 1e-12));
}

static void rounding_moves_the_surfaces_and_not_the_points(void **state)
{
    (void)state;
    shape a = box_of(1, 1, 1), b = box_of(0.5, 0.5, 0.5);
    a.radius = 0.125;
    b.radius = 0.25;
    manifold m;
    build_above(&a, 1.125, &b, (pose){{0, 0, 1.875 - 0.0625}, {1, 0, 0, 0}}, 0, &m);
    assert_int_equal(m.count, 4);
    for (int i = 0; i < 4; i++) {
        assert_true(has_point(&m, vec(i & 1 ? 0.5 : -0.5, i & 2 ? 0.5 : -0.5, 1.125 - 0.03125), 1e-12));
        assert_true(m.points[i].distance == -0.0625);
    }
}

/* B at any attitude, its lowest point over the inside of A's face: the deepest of the points is that one, and each
 * point lies between the two features. */
static void points_lie_within_both_features_and_reach_the_witness(void **state)
{
    (void)state;
    uint64_t seed = 32;
    int several = 0;
    for (int i = 0; i < 3000; i++) {
        double size = i % 3 == 0 ? 1e-4 : 1;
        hull *h = i % 2 ? random_hull(&seed, 12, size, true) : NULL;
        shape a = box_of(3 * size, 3 * size, size),
              b = h ? (shape){.type = SHAPE_HULL, .hull = h} : box_of(0.5 * size, 0.4 * size, 0.3 * size);
        if (i % 5 == 0) b.radius = 0.1 * size;
        pose at = random_pose(&seed, size);
        if (i % 4 == 0) at.q = quat_unit((quat){1, prng_in(&seed, -1e-3, 1e-3), prng_in(&seed, -1e-3, 1e-3), 0});
        at.p.z = 2 * size;
        double threshold = 2 * size;
        manifold m;
        double distance = build_above(&a, size, &b, at, threshold, &m);
        assert_true(m.count >= 1);
        assert_true(fabs(deepest(&m) - distance) <= 1e-12 * size);
        several += m.count > 2;
        for (uint32_t k = 0; k < m.count; k++) {
            const manifold_point *p = &m.points[k];
            vec3 on_b = vec_madd(p->point, 0.5 * p->distance + b.radius, UP); /* back to B's core: inside of it */
            vec3 local = quat_rotate(quat_conj(at.q), vec_sub(on_b, at.p));
            if (h)
                for (uint32_t f = 0; f < h->face_count; f++)
                    assert_true(vec_dot(h->faces[f].normal, local) <= h->faces[f].offset + 2e-6 * size);
            else
                assert_true(fabs(local.x) <= (0.5 + 2e-6) * size && fabs(local.y) <= (0.4 + 2e-6) * size &&
                            fabs(local.z) <= (0.3 + 2e-6) * size);
            assert_true(fmax(fabs(p->point.x), fabs(p->point.y)) <= (3 + 1e-5) * size);
            assert_true(fabs(p->point.z - 0.5 * p->distance - size) <= 1e-12 * size);
            assert_true(p->distance <= threshold);
            for (uint32_t j = 0; j < k; j++) assert_true(m.points[j].feature < p->feature);
        }
        hull_destroy(h);
    }
    assert_true(several > 1000);
}

/* Of a plank of almost no width, on a box or under one, beyond both of whose ends the box's face goes on: at each width
 * about where its face is just wide enough to clip the other by, contacts end where the plank ends. */
static void slivers_end_at_their_ends(void **state)
{
    (void)state;
    for (int i = 0; i < 4000; i++) {
        double width = pow(10, -9 + 5 * (i / 4) / 1000.0), turn = i % 4 < 2 ? 0 : 0.3;
        shape plank = box_of(width, 0.5, 0.5), block = box_of(1, 2, 0.5);
        bool under = i % 2;
        manifold m;
        build_above(under ? &plank : &block, 0.5, under ? &block : &plank,
            (pose){{0.1, under ? -0.2 : 0.2, 1}, turned(UP, turn)}, 1e-3, &m);
        for (uint32_t k = 0; k < m.count; k++) {
            vec3 p = under ? m.points[k].point
                           : quat_rotate(turned(UP, -turn), vec_sub(m.points[k].point, vec(0.1, 0.2, 1)));
            if (fabs(p.x) > width + 3e-6 || fabs(p.y) > 0.5 + 3e-6) fail_msg("width %g: %g, %g", width, p.x, p.y);
        }
    }
}

static void assert_same_ids(const manifold *a, const manifold *b)
{
    assert_int_equal(a->count, b->count);
    for (uint32_t i = 0; i < a->count; i++) assert_int_equal(a->points[i].feature, b->points[i].feature);
}

/* Attitudes without ties among more than four corners, among them flush edges (the last case: equal boxes stacked). */
static void ids_stay_under_tiny_motion(void **state)
{
    (void)state;
    uint64_t seed = 33;
    shape a = box_of(1, 1, 1);
    const shape upper[] = {box_of(0.5, 0.4, 0.3), capsule_of(0.2, 0.6), cylinder_of(0.4, 0.4), box_of(1, 1, 1)};
    const pose at[] = {{{0.9, 0.1, 1.3}, turned(UP, 0)}, {{0.1, 0.2, 1.2}, turned(vec(0, 1, 0), PI / 2)},
        {{0.1, 0.2, 1.4}, turned(vec(0, 1, 0), PI / 2)}, {{0, 0, 2}, {1, 0, 0, 0}}};
    for (int c = 0; c < 4; c++) {
        manifold still, moved;
        build_above(&a, 1, &upper[c], at[c], 0.01, &still);
        for (int i = 0; i < 200; i++) {
            vec3 spin = random_vec(&seed, 1e-7);
            pose near = {vec_add(at[c].p, random_vec(&seed, 1e-7)),
                quat_unit(quat_mul((quat){1, spin.x, spin.y, spin.z}, at[c].q))};
            build_above(&a, 1, &upper[c], near, 0.01, &moved);
            assert_same_ids(&still, &moved);
        }
    }
}

static void faces_of_many_corners_are_sampled_and_keep_their_depth(void **state)
{
    (void)state;
    vec3 points[400];
    for (int i = 0; i < 200; i++) {
        double angle = 2 * PI * i / 200;
        points[2 * i] = vec(cos(angle), sin(angle), 0);
        points[2 * i + 1] = vec(cos(angle), sin(angle), 1);
    }
    hull *h = NULL;
    assert_int_equal(hull_build(&points->x, 400, 0, &h), HULL_OK);
    shape a = box_of(4, 4, 1), b = {.type = SHAPE_HULL, .hull = h};
    manifold m;
    double distance = build_above(&a, 1, &b, (pose){{0, 0, 0.999}, {1, 0, 0, 0}}, 0, &m);
    assert_int_equal(m.count, 4);
    assert_true(fabs(deepest(&m) - distance) < 1e-12);
    shape both = {.type = SHAPE_HULL, .hull = h};
    build_above(&both, 1, &b, (pose){{0.5, 0, 1}, turned(UP, 0.013)}, 0.01, &m);
    assert_int_equal(m.count, 4);
    hull_destroy(h);
}

static void degenerate_shapes_still_give_a_point(void **state)
{
    (void)state;
    const shape thin[] = {box_of(0, 0, 0), box_of(1, 0, 0), box_of(1, 1, 0), box_of(0, 0, 1), capsule_of(0, 0),
        cylinder_of(0, 0), cylinder_of(0, 1), cylinder_of(1, 0), {.type = SHAPE_CONE}, {.type = SHAPE_ELLIPSOID},
        {.type = SHAPE_SPHERE}};
    uint64_t seed = 34;
    manifold m;
    for (size_t i = 0; i < sizeof thin / sizeof *thin; i++)
        for (size_t j = 0; j < sizeof thin / sizeof *thin; j++)
            for (int k = 0; k < 20; k++) {
                transform t = pose_transform(k ? random_pose(&seed, 1) : POSE_IDENTITY);
                vec3 axis = k % 3 ? random_unit(&seed) : UP;
                manifold_build(&thin[i], &thin[j], &t, axis, VEC_ZERO, VEC_ZERO, 1, &m);
                assert_true(m.count >= 1 && m.count <= 4);
                for (uint32_t p = 0; p < m.count; p++) assert_true(vec_finite(m.points[p].point));
            }
}

/* Two needles that overlap: the edges that are named are parallel, but 0.3 mm from each other. */
static void edges_that_do_not_touch_have_no_contact(void **state)
{
    (void)state;
    const shape a = {.type = SHAPE_BOX, .half = {0x1p-39, 0x1p-56, 0x1p-12}},
                b = {.type = SHAPE_BOX, .half = {0x1p-19, 0x1p-2, 0x1p-32}, .radius = 0x1p-63};
    const narrow_request request = {
        .facts = NARROW_DISTANCE | NARROW_MANIFOLD, .tolerance = 1e-9, .range = INFINITY, .threshold = 0.01};
    void *scratch = aligned_alloc(64, narrow_scratch_size());
    narrow_result r;
    narrow_query_world(&a, POSE_IDENTITY, &b, POSE_IDENTITY, &request, scratch, &r);
    free(scratch);
    assert_true(r.manifold.count > 0);
    for (uint32_t i = 0; i < r.manifold.count; i++) assert_true(vec_norm(r.manifold.points[i].point) < 0x1p-18);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_box_on_a_box_touches_at_the_four_corners_of_the_smaller_face),
        cmocka_unit_test(a_box_overhanging_is_clipped_by_the_edge_below),
        cmocka_unit_test(a_box_turned_by_an_eighth_keeps_four_of_the_eight_corners_of_the_octagon),
        cmocka_unit_test(crossing_edges_touch_in_one_point),
        cmocka_unit_test(parallel_edges_touch_along_their_common_stretch),
        cmocka_unit_test(edges_that_are_almost_parallel_touch_only_where_they_cross),
        cmocka_unit_test(a_capsule_lying_on_a_box_touches_in_two_points),
        cmocka_unit_test(a_capsule_standing_on_a_box_touches_in_one_point),
        cmocka_unit_test(a_cylinder_standing_on_a_box_touches_in_four_points_of_its_disc),
        cmocka_unit_test(a_cylinder_lying_on_a_box_touches_in_two_points),
        cmocka_unit_test(a_tilted_cylinder_touches_at_the_lowest_point_of_its_rim),
        cmocka_unit_test(a_sphere_touches_in_one_point),
        cmocka_unit_test(a_box_on_a_halfspace_touches_in_four_points),
        cmocka_unit_test(rounding_moves_the_surfaces_and_not_the_points),
        cmocka_unit_test(points_lie_within_both_features_and_reach_the_witness),
        cmocka_unit_test(slivers_end_at_their_ends),
        cmocka_unit_test(ids_stay_under_tiny_motion),
        cmocka_unit_test(faces_of_many_corners_are_sampled_and_keep_their_depth),
        cmocka_unit_test(degenerate_shapes_still_give_a_point),
        cmocka_unit_test(edges_that_do_not_touch_have_no_contact),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
