/* The depth of overlapping meshes: against the exact depth of unions of boxes, by moves that must separate and moves
 * that must not, and where it is known. */
#include "brute.h"
#include "cad.h"
#include "narrow/narrow.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

static narrow_scratch *scratch;

static int rounds(int nightly)
{
    return getenv("COLLIDED_NIGHTLY") ? nightly : nightly / 10;
}

static narrow_result ask_depth(const shape *a, const shape *b, pose b_in_a, double tolerance)
{
    narrow_result r;
    const narrow_request q = {.facts = NARROW_DISTANCE, .tolerance = tolerance, .range = INFINITY};
    narrow_query(a, b, &b_in_a, &q, NULL, scratch, &r);
    return r;
}

static bool are_apart(const shape *a, const shape *b, pose b_in_a)
{
    narrow_result r;
    const narrow_request q = {.facts = NARROW_VERDICT, .range = INFINITY};
    narrow_query(a, b, &b_in_a, &q, NULL, scratch, &r);
    return r.lo > 0;
}

/* ---- bodies of blocks ---- */

enum { CELLS = 3 };

typedef struct blocks { /* cell (i, j, k) is between grid[0][i] and grid[0][i + 1], ... */
    double grid[3][CELLS + 1];
    bool full[CELLS][CELLS][CELLS];
} blocks;

/* Multiples of 1/64, so that all sums are exact. */
static blocks random_blocks(dice *d, double share)
{
    blocks b;
    for (int axis = 0; axis < 3; axis++) {
        b.grid[axis][0] = -(double)(int)dice_between(d, 32, 96) / 64;
        for (int i = 0; i < CELLS; i++) b.grid[axis][i + 1] = b.grid[axis][i] + (int)dice_between(d, 8, 64) / 64.0;
    }
    int count = 0;
    for (int i = 0; i < CELLS * CELLS * CELLS; i++) {
        bool full = dice_between(d, 0, 1) < share;
        b.full[i / 9][i / 3 % 3][i % 3] = full;
        count += full;
    }
    if (!count) b.full[1][1][1] = true;
    return b;
}

static bool is_full(const blocks *b, const int c[3])
{
    for (int k = 0; k < 3; k++)
        if (c[k] < 0 || c[k] >= CELLS) return false;
    return b->full[c[0]][c[1]][c[2]];
}

/* Faces between a full cell and an empty one. */
static soup soup_blocks(const blocks *b)
{
    soup s = soup_new();
    for (int i = 0; i < CELLS * CELLS * CELLS; i++) {
        int c[3] = {i / 9, i / 3 % 3, i % 3};
        if (!is_full(b, c)) continue;
        for (int side = 0; side < 6; side++) {
            int axis = side / 2, u = (axis + 1) % 3, v = (axis + 2) % 3, next[3] = {c[0], c[1], c[2]};
            int32_t at[4];
            next[axis] += side & 1 ? 1 : -1;
            if (is_full(b, next)) continue;
            for (int k = 0; k < 4; k++) {
                double p[3];
                p[axis] = b->grid[axis][c[axis] + (side & 1)];
                p[u] = b->grid[u][c[u] + (k == 1 || k == 2)];
                p[v] = b->grid[v][c[v] + (k >= 2)];
                at[k] = soup_point(&s, vec(p[0], p[1], p[2]));
            }
            if (side & 1)
                soup_quad(&s, at[0], at[1], at[2], at[3]);
            else
                soup_quad(&s, at[3], at[2], at[1], at[0]);
        }
    }
    return s;
}

/* Do they overlap with B moved so? */
static bool blocks_overlap(const blocks *a, const blocks *b, const double move[3])
{
    for (int i = 0; i < CELLS * CELLS * CELLS; i++) {
        const int p[3] = {i / 9, i / 3 % 3, i % 3};
        if (!is_full(a, p)) continue;
        for (int k = 0; k < CELLS * CELLS * CELLS; k++) {
            const int q[3] = {k / 9, k / 3 % 3, k % 3};
            bool meet = is_full(b, q);
            for (int x = 0; x < 3 && meet; x++)
                meet = a->grid[x][p[x]] < b->grid[x][q[x] + 1] + move[x] &&
                       b->grid[x][q[x]] + move[x] < a->grid[x][p[x] + 1];
            if (meet) return true;
        }
    }
    return false;
}

/* The nearest point outside of a union of boxes has coordinates that are 0 or those of faces. */
static double blocks_depth(const blocks *a, const blocks *b)
{
    enum { MOST = 1 + (CELLS + 1) * (CELLS + 1) };
    double at[3][MOST], best = INFINITY;
    for (int x = 0; x < 3; x++) {
        int count = 0;
        at[x][count++] = 0;
        for (int i = 0; i <= CELLS; i++)
            for (int k = 0; k <= CELLS; k++) at[x][count++] = a->grid[x][i] - b->grid[x][k];
    }
    for (int i = 0; i < MOST; i++)
        for (int k = 0; k < MOST; k++)
            for (int l = 0; l < MOST; l++) {
                const double move[3] = {at[0][i], at[1][k], at[2][l]};
                double length2 = move[0] * move[0] + move[1] * move[1] + move[2] * move[2];
                if (length2 < best && !blocks_overlap(a, b, move)) best = length2;
            }
    return sqrt(best);
}

static void blocks_are_as_deep_as_brute_force_finds(void **state)
{
    (void)state;
    dice d = {91};
    int overlaps = 0, narrow = 0;
    for (int k = 0; k < rounds(1000); k++) {
        blocks x = random_blocks(&d, 0.3 + 0.6 * (k % 3) / 2), y = random_blocks(&d, 0.3 + 0.6 * (k % 5) / 4);
        const double still[3] = {0, 0, 0};
        soup s = soup_blocks(&x), t = soup_blocks(&y);
        mesh *m = soup_mesh(&s), *n = soup_mesh(&t);
        shape a = mesh_shape(m, 0), b = mesh_shape(n, 0);
        narrow_result r = ask_depth(&a, &b, POSE_IDENTITY, 1e-6);
        if (blocks_overlap(&x, &y, still)) {
            double depth = blocks_depth(&x, &y);
            if (!(r.lo <= -depth + 1e-12 && -depth - 1e-12 <= r.hi))
                fail_msg("%d: [%.12g, %.12g], depth %.12g", k, r.lo, r.hi, depth);
            overlaps++;
            narrow += r.hi - r.lo <= 1e-6;
            assert_true((r.hi - r.lo <= 1e-6) == (r.status == NARROW_CERTAIN));
        } else {
            assert_true(r.hi >= 0);
        }
        mesh_destroy(m);
        mesh_destroy(n);
        soup_free(&s);
        soup_free(&t);
    }
    if (overlaps < rounds(500) || narrow < 0.9 * overlaps) fail_msg("%d of %d are narrow", narrow, overlaps);
}

/* ---- machine parts ---- */

static pose moved(pose at, vec3 way)
{
    return (pose){vec_add(at.p, way), at.q};
}

enum { BRUTE_PAIRS_MAX = 4000 }; /* of triangles: it is slow */

/* The move that is named separates: all pairs of triangles, in 113 bits, and no point of either in the other. */
static void expect_separated(
    const soup *x, const soup *y, const shape *a, const shape *b, pose at, const narrow_result *r)
{
    pose there = moved(at, vec_scale(r->axis, -r->lo + 1e-12));
    bool few = x->triangle_count * y->triangle_count <= BRUTE_PAIRS_MAX;
    if (!(few ? brute_distance(x, y, &there) > 0 : are_apart(a, b, there)))
        fail_msg("still in contact after %g", -r->lo);
    vec3 of_b = pose_point(there, b->mesh->vertices[0]);
    vec3 of_a = pose_point(pose_relative(there, POSE_IDENTITY), a->mesh->vertices[0]);
    assert_false(mesh_inside(a->mesh, of_b) || mesh_inside(b->mesh, of_a));
}

/* No shorter move does. */
static void expect_no_shorter_way(const shape *a, const shape *b, pose at, const narrow_result *r, dice *d, int count)
{
    for (int k = 0; k < count; k++) {
        vec3 way = k ? vec_unit(dice_vec(d, -1, 1)) : r->axis;
        double length = -r->hi * (k % 2 ? dice_between(d, 0.5, 1) : 1) - 1e-9;
        if (length > 0 && are_apart(a, b, moved(at, vec_scale(way, length))))
            fail_msg("[%g, %g], but %g is enough", r->lo, r->hi, length);
    }
}

/* Who asks for less gets a wider bracket of the same depth. */
static void expect_brief_agrees(const shape *a, const shape *b, pose at, const narrow_result *r)
{
    narrow_result brief;
    const narrow_request q = {
        .facts = NARROW_VERDICT | NARROW_DISTANCE, .tolerance = 1e-6, .range = INFINITY, .brief = true};
    narrow_query(a, b, &at, &q, NULL, scratch, &brief);
    if (!(brief.lo <= r->hi && r->lo <= brief.hi && brief.hi <= 1e-12))
        fail_msg("[%g, %g], in brief [%g, %g]", r->lo, r->hi, brief.lo, brief.hi);
    if (!are_apart(a, b, moved(at, vec_scale(brief.axis, -brief.lo + 1e-12)))) fail_msg("in brief: still in contact");
}

/* Curved inward and outward: pieces fill them only in part. */
static void the_bounds_of_curved_meshes_hold(void **state)
{
    (void)state;
    dice d = {96};
    int overlaps = 0;
    for (int k = 0; k < rounds(200); k++) {
        soup x = soup_torus(1, 0.4, 40, 20), y = k % 2 ? soup_torus(0.8, 0.25, 30, 15) : soup_icosphere(0.7, 2);
        mesh *m = soup_mesh(&x), *n = soup_mesh(&y);
        shape a = mesh_shape(n, 0), b = mesh_shape(m, 0), box = {.type = SHAPE_BOX, .half = {0.3, 0.5, 0.2}};
        const shape *first = k % 3 ? &a : &box;
        pose at = {dice_vec(&d, -1, 1), dice_quat(&d)};
        narrow_result r = ask_depth(first, &b, at, 1e-6);
        if (r.hi < 0) {
            if (!are_apart(first, &b, moved(at, vec_scale(r.axis, -r.lo + 1e-12)))) fail_msg("%d: in contact", k);
            expect_no_shorter_way(first, &b, at, &r, &d, 40);
            expect_brief_agrees(first, &b, at, &r);
            overlaps++;
        }
        mesh_destroy(m);
        mesh_destroy(n);
        soup_free(&x);
        soup_free(&y);
    }
    assert_true(overlaps >= rounds(80));
}

static void the_bounds_of_machine_parts_hold(void **state)
{
    (void)state;
    dice d = {92};
    int overlaps = 0, narrow = 0;
    for (int k = 0; k < rounds(1500); k++) {
        soup x = cad_solid((cad_kind)(k % CAD_KIND_COUNT), &d), y = cad_solid((cad_kind)(k / 7 % CAD_KIND_COUNT), &d);
        mesh *m = soup_mesh(&x), *n = soup_mesh(&y);
        shape a = mesh_shape(m, 0), b = mesh_shape(n, 0);
        pose at = {dice_vec(&d, -0.8, 0.8), k % 4 ? dice_quat(&d) : (quat){1, 0, 0, 0}};
        double size = shape_reach(&a) + shape_reach(&b);
        narrow_result r = ask_depth(&a, &b, at, 1e-6 * size);
        if (r.hi < 0) {
            expect_separated(&x, &y, &a, &b, at, &r);
            expect_no_shorter_way(&a, &b, at, &r, &d, 40);
            expect_brief_agrees(&a, &b, at, &r);
            overlaps++;
            narrow += r.hi - r.lo <= -0.1 * r.lo;
        }
        mesh_destroy(m);
        mesh_destroy(n);
        soup_free(&x);
        soup_free(&y);
    }
    if (overlaps < rounds(600) || narrow < 0.85 * overlaps) fail_msg("%d of %d are narrow", narrow, overlaps);
}

/* ---- where it is known ---- */

static void expect_depth(const shape *a, const shape *b, pose at, double depth)
{
    double size = shape_reach(a) + shape_reach(b);
    narrow_result r = ask_depth(a, b, at, 1e-6 * size);
    if (!(r.lo <= -depth + 1e-12 && -depth - 1e-12 <= r.hi && r.hi - r.lo <= 1e-6 * size))
        fail_msg("[%.12g, %.12g], depth %.12g", r.lo, r.hi, depth);
    assert_int_equal(r.status, NARROW_CERTAIN);
}

static void expect_mesh_depth(soup x, soup y, pose at, double depth)
{
    mesh *m = soup_mesh(&x), *n = soup_mesh(&y);
    shape a = mesh_shape(m, 0), b = mesh_shape(n, 0);
    expect_depth(&a, &b, at, depth);
    mesh_destroy(m);
    mesh_destroy(n);
    soup_free(&x);
    soup_free(&y);
}

static pose at_point(double x, double y, double z)
{
    return (pose){{x, y, z}, {1, 0, 0, 0}};
}

static void concentric_cubes_are_as_deep_as_they_are_wide(void **state)
{
    (void)state;
    expect_mesh_depth(soup_box(1, 1, 1, 1), soup_box(1, 1, 1, 1), POSE_IDENTITY, 2);
    expect_mesh_depth(soup_box(1, 1, 1, 4), soup_box(1, 1, 1, 3), POSE_IDENTITY, 2);
    expect_mesh_depth(soup_box(1, 1, 1, 1), soup_box(0.5, 0.5, 0.5, 1), POSE_IDENTITY, 1.5); /* one holds the other */
    expect_mesh_depth(soup_box(1, 1, 1, 2), soup_box(1, 1, 1, 1), at_point(0.25, -0.125, 0.5), 1.5);
}

static const double ELL[6][2] = {{-1, -1}, {1, -1}, {1, -0.5}, {-0.5, -0.5}, {-0.5, 1}, {-1, 1}};
static const double PROFILE_U[8][2] = {
    {-1, -1}, {1, -1}, {1, 1}, {0.75, 1}, {0.75, -0.75}, {-0.75, -0.75}, {-0.75, 1}, {-1, 1}};

/* A small cube in the corner of an L, that is in both arms: out by the inner corner. */
static void what_is_in_a_corner_leaves_it(void **state)
{
    (void)state;
    soup cube = soup_box(0.25, 0.25, 0.25, 1);
    for (int k = 0; k < 3; k++) { /* 0.05 into the floor, 0.12 into the wall: both have to be left */
        double down = k == 1 ? 0 : 0.05, aside = k == 2 ? 0 : 0.12;
        soup a = cad_extruded(ELL, NULL, 6, 1), b = soup_new();
        soup_add(&b, &cube, VEC_ZERO);
        expect_mesh_depth(a, b, at_point(-0.25 - aside - 1e-9, -0.25 - down - 1e-9, 0), hypot(aside, down) + 1e-9);
    }
    soup_free(&cube);
}

static void expect_in_profile(double wide, double x, double y, double depth)
{
    soup a = cad_extruded(PROFILE_U, NULL, 8, 2);
    expect_mesh_depth(a, soup_box(wide, 0.25, 0.25, 1), at_point(x, y, 0), depth);
}

/* Between the walls of a U, that it fits in, and that it does not. */
static void what_is_in_a_groove_leaves_it(void **state)
{
    (void)state;
    expect_in_profile(0.5, 0.3125, 0, 0.0625);   /* back from one wall */
    expect_in_profile(0.5, 0, -0.625, 0.125);    /* up from the floor */
    expect_in_profile(0.875, 0, 0.5, 0.75);      /* does not fit: up and out */
    expect_in_profile(0.3125, 0.875, 0, 0.4375); /* in a wall: inward there is room, outward is farther */
}

/* A ring about a bar that is too thick, and one about a bar that hangs aside. */
static void a_ring_about_a_bar(void **state)
{
    (void)state;
    const double outer[8][2] = {{2, 2}, {0, 2}, {-2, 2}, {-2, 0}, {-2, -2}, {0, -2}, {2, -2}, {2, 0}};
    const double inner[8][2] = {{1, 1}, {0, 1}, {-1, 1}, {-1, 0}, {-1, -1}, {0, -1}, {1, -1}, {1, 0}};
    for (int k = 0; k < 3; k++) {
        soup a = cad_extruded(outer, inner, 8, 0.5);
        double wide = k == 0 ? 0.75 : 1.25, x = k == 0 ? 0.375 : k == 1 ? 0 : 0.125;
        /* back by 0.125; across by 0.25 in the ring is as short as beyond it; out along the bar, which is 2 long */
        expect_mesh_depth(a, soup_box(wide, 0.5, 2, 1), at_point(x, 0, 0), k == 0 ? 0.125 : k == 1 ? 2.5 : 2.5);
    }
}

/* ---- relations ---- */

static void a_convex_mesh_is_its_hull(void **state)
{
    (void)state;
    dice d = {93};
    for (int k = 0; k < rounds(1000); k++) {
        static const cad_kind KINDS[3] = {CAD_BOX, CAD_CYLINDER, CAD_CONE};
        soup x = cad_solid(KINDS[k % 3], &d), y = cad_solid(KINDS[k / 3 % 3], &d);
        mesh *m = soup_mesh(&x), *n = soup_mesh(&y);
        assert_true(m->convex && n->convex && m->piece_count == 1);
        shape a = mesh_shape(m, 0), b = mesh_shape(n, 0), ha = a, hb = b;
        ha.type = hb.type = SHAPE_HULL;
        pose at = {dice_vec(&d, -0.7, 0.7), dice_quat(&d)};
        double size = shape_reach(&a) + shape_reach(&b);
        narrow_result r = ask_depth(&a, &b, at, 1e-6 * size), h = ask_depth(&ha, &hb, at, 0);
        if (h.hi < 0 && !(r.lo <= h.hi && h.lo <= r.hi && r.hi - r.lo <= 1e-6 * size))
            fail_msg("[%.12g, %.12g], of hulls [%.12g, %.12g]", r.lo, r.hi, h.lo, h.hi);
        mesh_destroy(m);
        mesh_destroy(n);
        soup_free(&x);
        soup_free(&y);
    }
}

/* Any point of a piece that is inside by more than its slack is inside of the mesh. */
static void pieces_are_inside(void **state)
{
    (void)state;
    dice d = {94};
    for (int k = 0; k < CAD_KIND_COUNT * rounds(40); k++) {
        soup s = cad_solid((cad_kind)(k % CAD_KIND_COUNT), &d);
        mesh *m = soup_mesh(&s);
        assert_true(m->solid && m->filled && m->piece_count > 0);
        for (uint32_t i = 0; i < m->piece_count; i++) {
            const hull *h = m->pieces[i].hull;
            vec3 centre = VEC_ZERO;
            assert_true(m->pieces[i].slack < 1e-8);
            for (uint32_t v = 0; v < h->vertex_count; v++)
                centre = vec_madd(centre, 1.0 / h->vertex_count, hull_vertex(h, v));
            for (uint32_t v = 0; v < h->vertex_count; v++) {
                vec3 near = vec_madd(hull_vertex(h, v), 1e-6, vec_sub(centre, hull_vertex(h, v)));
                assert_true(mesh_inside(m, near));
            }
        }
        mesh_destroy(m);
        soup_free(&s);
    }
}

/* The other order negates, a power of two scales, and neither changes a bit more; nor does what a pair remembers. */
static void order_scale_and_memory_change_nothing(void **state)
{
    (void)state;
    dice d = {95};
    for (int k = 0; k < rounds(400); k++) {
        soup x = cad_solid((cad_kind)(k % CAD_KIND_COUNT), &d), y = cad_solid((cad_kind)(k / 5 % CAD_KIND_COUNT), &d);
        soup big_x = soup_new(), big_y = soup_new();
        soup_add(&big_x, &x, VEC_ZERO);
        soup_add(&big_y, &y, VEC_ZERO);
        for (size_t i = 0; i < 3 * x.point_count; i++) big_x.points[i] *= 4;
        for (size_t i = 0; i < 3 * y.point_count; i++) big_y.points[i] *= 4;
        mesh *m = soup_mesh(&x), *n = soup_mesh(&y), *big_m = soup_mesh(&big_x), *big_n = soup_mesh(&big_y);
        shape a = mesh_shape(m, 0), b = mesh_shape(n, 0), big_a = mesh_shape(big_m, 0), big_b = mesh_shape(big_n, 0);
        pose at_a = {dice_vec(&d, -0.5, 0.5), dice_quat(&d)}, at_b = {dice_vec(&d, -0.5, 0.5), dice_quat(&d)};
        narrow_request q = {.facts = NARROW_DISTANCE, .tolerance = 1e-6, .range = INFINITY, .brief = k % 3 == 0};
        narrow_result r, turned, big, kept, cold;
        narrow_query_world(&a, at_a, &b, at_b, &q, scratch, &r);
        narrow_query_world(&b, at_b, &a, at_a, &q, scratch, &turned);
        assert_true(r.lo == turned.lo && r.hi == turned.hi && vec_norm(vec_add(r.axis, turned.axis)) == 0);
        pose at = pose_relative(at_a, at_b), big_at = {vec_scale(at.p, 4), at.q};
        const shape *first = narrow_ordered(&a, 0, &b, 1) ? &a : &b, *second = first == &a ? &b : &a;
        if (first == &a) {
            narrow_cache cache = {.lower = 0};
            narrow_query(first, second, &at, &q, NULL, scratch, &cold);
            for (int times = 0; times < 2; times++) {
                narrow_query(first, second, &at, &q, &cache, scratch, &kept);
                assert_true(kept.lo == cold.lo && kept.hi == cold.hi);
                assert_memory_equal(&kept.axis, &cold.axis, sizeof kept.axis);
                assert_memory_equal(&kept.point_a, &cold.point_a, 2 * sizeof kept.point_a);
            }
            q.tolerance *= 4;
            narrow_query(&big_a, &big_b, &big_at, &q, NULL, scratch, &big);
            assert_true(big.lo == 4 * cold.lo && big.hi == 4 * cold.hi);
        }
        mesh_destroy(m), mesh_destroy(n), mesh_destroy(big_m), mesh_destroy(big_n);
        soup_free(&x), soup_free(&y), soup_free(&big_x), soup_free(&big_y);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(concentric_cubes_are_as_deep_as_they_are_wide),
        cmocka_unit_test(what_is_in_a_corner_leaves_it),
        cmocka_unit_test(what_is_in_a_groove_leaves_it),
        cmocka_unit_test(a_ring_about_a_bar),
        cmocka_unit_test(a_convex_mesh_is_its_hull),
        cmocka_unit_test(pieces_are_inside),
        cmocka_unit_test(order_scale_and_memory_change_nothing),
        cmocka_unit_test(blocks_are_as_deep_as_brute_force_finds),
        cmocka_unit_test(the_bounds_of_machine_parts_hold),
        cmocka_unit_test(the_bounds_of_curved_meshes_hold),
    };
    scratch = aligned_alloc(64, narrow_scratch_size());
    int failed = cmocka_run_group_tests(tests, NULL, NULL);
    free(scratch);
    return failed;
}
