/* Meshes of several bodies and of needles: what is inside of what, in both orders, closed and open, one in another's
 * hollow; and triangles without area, which are segments and points. Against all pairs of triangles in 113 bits, and
 * winding numbers body by body; of convex bodies against the same as hulls. */
#include "brute.h"
#include "fields.h"
#include "geom/compound.h"
#include "narrow/narrow.h"
#include "toi/toi.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "findings.h"

static narrow_scratch *scratch;

static narrow_result ask(const shape *a, const shape *b, pose b_in_a, unsigned facts)
{
    const narrow_request request = {.facts = facts, .tolerance = 1e-9, .range = INFINITY};
    pose at_a = POSE_IDENTITY;
    narrow_result r;
    memset(&r, 0xa5, sizeof r);
    narrow_query_world(a, at_a, b, b_in_a, &request, scratch, &r);
    return r;
}

static void expect(const shape *a, const shape *b, pose b_in_a, double truth)
{
    narrow_result r = ask(a, b, b_in_a, NARROW_DISTANCE | NARROW_MANIFOLD);
    pose a_in_b = pose_relative(b_in_a, POSE_IDENTITY);
    narrow_result back = ask(b, a, a_in_b, NARROW_DISTANCE);
    if (!(r.lo <= truth + 1e-12 && truth - 1e-12 <= r.hi)) fail_msg("%g is not in [%.17g, %.17g]", truth, r.lo, r.hi);
    if (!(back.lo <= truth + 1e-12 && truth - 1e-12 <= back.hi))
        fail_msg("turned: %g is not in [%.17g, %.17g]", truth, back.lo, back.hi);
    assert_true(fabs(vec_norm(r.axis) - 1) < 1e-14);
    assert_true(truth > 0 || (r.hi < 0 && r.manifold.count > 0));
    if (truth < 0) { /* CCD sees it, too */
        toi_mover ma = {a, POSE_IDENTITY, {.start = POSE_IDENTITY}};
        toi_mover mb = {b, POSE_IDENTITY, {.start = b_in_a, .linear = {0.01, 0, 0}}};
        const toi_request request = {.span = 1, .tolerance = 1e-6};
        toi_result t;
        bool in_order = narrow_ordered(a, 0, b, 1);
        toi_find(in_order ? &ma : &mb, in_order ? &mb : &ma, &request, VEC_ZERO, scratch, &t);
        if (t.status != TOI_HIT || t.hi != 0) fail_msg("CCD: %s at %g", toi_status_name(t.status), t.hi);
    }
}

static void one_of_two_bodies_of_a_mesh_is_inside_of_a_solid(void **state)
{
    (void)state;
    soup pair = soup_box(0.1, 0.1, 0.1, 1), small = soup_box(0.1, 0.1, 0.1, 1), cube = soup_box(1, 1, 1, 1);
    for (size_t i = 0; i < pair.point_count; i++) pair.points[3 * i] += 5;
    soup_add(&pair, &small, VEC_ZERO);
    soup open = pair;
    mesh *mb = soup_mesh(&cube);
    for (int is_open = 0; is_open < 2; is_open++) {
        if (is_open) soup_drop(&open, 0);
        mesh *ma = soup_mesh(&open);
        shape a = mesh_shape(ma, 0), b = mesh_shape(mb, 0);
        expect(&a, &b, POSE_IDENTITY, -1.1);
        assert_int_equal(ma->solid, !is_open);
        mesh_destroy(ma);
    }
    mesh_destroy(mb);
    soup_free(&pair);
    soup_free(&small);
    soup_free(&cube);
}

/* A triangle whose corners lie on a line, and one far away; the needle is in the cube. */
static void a_needle_in_a_cube_touches_it(void **state)
{
    (void)state;
    static const double POINTS[] = {0, 0, 0, 0.5, 0, 0, 0.25, 0, 0, 5, 0, 0, 6, 0, 0, 5, 1, 0};
    static const int32_t CORNERS[] = {0, 1, 2, 3, 4, 5}, FOLDED[] = {0, 1, 1, 3, 4, 5}, POINT[] = {0, 0, 0, 3, 4, 5};
    const int32_t *const all[] = {CORNERS, FOLDED, POINT};
    const double truths[] = {-1, -1, -1};
    soup cube = soup_box(1, 1, 1, 1);
    mesh *solid = soup_mesh(&cube);
    const shape box = {.type = SHAPE_BOX, .half = {1, 1, 1}}, b = mesh_shape(solid, 0);
    for (int k = 0; k < 3; k++) {
        mesh *m;
        assert_int_equal(mesh_build(POINTS, 6, all[k], 2, &m), MESH_OK);
        shape a = mesh_shape(m, 0);
        expect(&a, &box, POSE_IDENTITY, truths[k]);
        expect(&a, &b, POSE_IDENTITY, truths[k]);
        mesh_destroy(m);
    }
    mesh_destroy(solid);
    soup_free(&cube);
}

/* On the face of a box, and of one that is a mesh: at its ends, in whatever form it came. */
static void a_needle_that_lies_on_a_face_touches_at_its_ends(void **state)
{
    (void)state;
    static const double POINTS[] = {-0.5, 0, -0x1p-7, 0.5, 0, -0x1p-7, 0.25, 0, -0x1p-7, 0, 0, 7, 1, 0, 7, 0, 1, 7};
    static const int32_t CORNERS[][6] = {{0, 1, 2, 3, 4, 5}, {0, 1, 1, 3, 4, 5}, {2, 1, 0, 3, 4, 5}};
    soup cube = soup_box(1, 1, 1, 1);
    mesh *solid = soup_mesh(&cube);
    const shape box = {.type = SHAPE_BOX, .half = {1, 1, 1}}, as_mesh = mesh_shape(solid, 0);
    for (int k = 0; k < 6; k++) {
        mesh *m;
        assert_int_equal(mesh_build(POINTS, 6, CORNERS[k % 3], 2, &m), MESH_OK);
        shape a = mesh_shape(m, 0);
        const double depth = k < 3 ? 0x1p-7 : 0; /* of a needle that is inside of a mesh, only one point is told */
        const pose below = {{0, 0, depth - 1 - 0x1p-7}, {1, 0, 0, 0}};
        narrow_result r = ask(&a, k < 3 ? &box : &as_mesh, below, NARROW_DISTANCE | NARROW_MANIFOLD);
        assert_true(r.lo <= -depth + 1e-12 && r.hi >= -depth - 1e-12);
        assert_int_equal(r.manifold.count, 2);
        double x = r.manifold.points[0].point.x, y = r.manifold.points[1].point.x;
        assert_true(fabs(fmin(x, y) + 0.5) < 1e-9 && fabs(fmax(x, y) - 0.5) < 1e-9);
        for (int i = 0; i < 2; i++) assert_true(fabs(r.manifold.points[i].distance + depth) < 1e-9);
        mesh_destroy(m);
    }
    mesh_destroy(solid);
    soup_free(&cube);
}

/* ---- the class: bodies of up to three pieces on a lattice ---- */

enum { PIECES_MAX = 3, DIRECTIONS = 3, SAMPLES = 6 };
static const double SLACK = 1e-11; /* m */

typedef enum piece_kind {
    PIECE_CUBE,
    PIECE_CUBE_TURNED, /* inside out: a hollow in another */
    PIECE_TETRAHEDRON,
    PIECE_OPEN_CUBE,
    PIECE_PLANE,
    PIECE_SLIVER,
    PIECE_THREAD, /* 1e-300 wide */
    PIECE_NEEDLE,
    PIECE_SEGMENT,
    PIECE_POINT,
    PIECE_KINDS
} piece_kind;

/* What is asked about, and what it is made of. */
typedef struct thing {
    shape it;
    soup all;
    int count;
    vec3 point[PIECES_MAX]; /* of each piece */
    bool solid, sound;      /* sound: its triangles are as they were given */
    char name[128];
    mesh *mesh;
    compound *compound;
    hull *hull;
} thing;

static double lattice_of(dice *d, const double *values, int count)
{
    return values[(int)dice_between(d, 0, count - 1e-9)];
}

static vec3 lattice_point(dice *d, double step, int most)
{
    double x[3];
    for (int k = 0; k < 3; k++) x[k] = step * floor(dice_between(d, -most, most + 1));
    return vec(x[0], x[1], x[2]);
}

static soup piece_of(piece_kind kind, double h)
{
    const double points[] = {-h, -h, -h, h, -h, -h, -h, h, -h, -h, -h, h}, wide = kind == PIECE_SLIVER ? 1e-9 : 1e-300;
    const double line[] = {-h, 0, 0, h, 0, 0, 0, kind <= PIECE_THREAD ? wide : 0, 0};
    static const int32_t TETRAHEDRON[] = {0, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 3}, NEEDLE[] = {0, 1, 2},
                         SEGMENT[] = {0, 1, 1}, POINT[] = {0, 0, 0};
    soup s;
    switch (kind) {
    case PIECE_TETRAHEDRON:
        return soup_from(points, 4, TETRAHEDRON, 4);
    case PIECE_PLANE:
        return soup_plane(h, 1);
    case PIECE_SLIVER:
    case PIECE_THREAD:
    case PIECE_NEEDLE:
        return soup_from(line, 3, NEEDLE, 1);
    case PIECE_SEGMENT:
        return soup_from(line, 3, SEGMENT, 1);
    case PIECE_POINT:
        return soup_from(line, 3, POINT, 1);
    default:
        s = soup_box(h, h, h, 1);
        if (kind == PIECE_OPEN_CUBE) soup_drop(&s, 3);
        for (size_t t = 0; kind == PIECE_CUBE_TURNED && t < s.triangle_count; t++) soup_turn(&s, t);
        return s;
    }
}

static void add_piece(thing *t, piece_kind kind, double h, vec3 at)
{
    static const char *const NAMES[PIECE_KINDS] = {
        "cube", "turned cube", "tetrahedron", "open cube", "plane", "sliver", "thread", "needle", "segment", "point"};
    soup s = piece_of(kind, h);
    soup_add(&t->all, &s, at);
    const double *last = s.points + 3 * (size_t)s.corners[3 * s.triangle_count - 1];
    t->point[t->count++] = vec_add(vec(last[0], last[1], last[2]), at);
    t->solid = t->solid && (kind <= PIECE_TETRAHEDRON || kind >= PIECE_THREAD);
    size_t used = strlen(t->name);
    snprintf(t->name + used, sizeof t->name - used, " %s %g at (%g %g %g)", NAMES[kind], h, at.x, at.y, at.z);
    soup_free(&s);
}

static void draw_mesh(dice *d, thing *t)
{
    static const double SIZES[] = {0.125, 0.125, 0.25, 0.5, 1, 2};
    int count = 1 + (int)dice_between(d, 0, PIECES_MAX);
    for (int i = 0; i < count; i++) {
        bool first = i == 0; /* there is always an area */
        piece_kind kind = (piece_kind)dice_between(d, 0, first ? PIECE_SLIVER : PIECE_KINDS);
        double h = lattice_of(d, SIZES, 6);
        vec3 at = dice_between(d, 0, 1) < 0.3 ? VEC_ZERO : lattice_point(d, 0.25, 8);
        add_piece(t, kind, h, at);
    }
    t->mesh = soup_mesh(&t->all);
    const mesh_findings *f = &t->mesh->found;
    t->sound = f->turned == 0 && f->repeated == 0 && f->torn_edges == 0;
    t->it = mesh_shape(t->mesh, 0);
}

static void draw_compound(dice *d, thing *t)
{
    static const double SIZES[] = {0.125, 0.25, 0.5, 1};
    shape boxes[PIECES_MAX];
    pose at[PIECES_MAX];
    int count = 2 + (int)dice_between(d, 0, PIECES_MAX - 1);
    for (int i = 0; i < count; i++) {
        double h = lattice_of(d, SIZES, 4);
        boxes[i] = (shape){.type = SHAPE_BOX, .half = {h, h, h}};
        at[i] = (pose){lattice_point(d, 0.25, 6), {1, 0, 0, 0}};
        add_piece(t, PIECE_CUBE, h, at[i].p);
    }
    assert_int_equal(compound_build(boxes, at, (size_t)count, &t->compound), COMPOUND_OK);
    t->it = (shape){.type = SHAPE_COMPOUND, .compound = t->compound};
}

static void draw_field(dice *d, thing *t)
{
    static field f;
    f.it = (height_field){3, 3, 0.5, 0.5, 0.25, f.heights};
    for (int i = 0; i < 9; i++) f.heights[i] = 0.25 * floor(dice_between(d, 0, 4));
    soup_free(&t->all);
    t->all = field_soup(&f);
    t->mesh = field_mesh(&f);
    t->it = mesh_shape(t->mesh, 0);
    t->point[t->count++] = vec(t->all.points[0], t->all.points[1], t->all.points[2]);
    snprintf(t->name, sizeof t->name, " height field");
}

static void draw_convex(dice *d, thing *t, bool as_hull)
{
    static const double SIZES[] = {0.125, 0.25, 0.5, 1, 2};
    double h = lattice_of(d, SIZES, 5);
    add_piece(t, as_hull ? PIECE_TETRAHEDRON : PIECE_CUBE, h, VEC_ZERO);
    t->it = (shape){.type = SHAPE_BOX, .half = {h, h, h}};
    if (!as_hull) return;
    assert_int_equal(hull_build(t->all.points, t->all.point_count, 0, &t->hull), HULL_OK);
    t->it = (shape){.type = SHAPE_HULL, .hull = t->hull};
}

static void draw(dice *d, thing *t, bool any)
{
    memset(t, 0, sizeof *t);
    t->all = soup_from(NULL, 0, NULL, 0);
    t->solid = t->sound = true;
    double kind = any ? dice_between(d, 0, 1) : 0;
    if (kind < 0.6)
        draw_mesh(d, t);
    else if (kind < 0.7)
        draw_compound(d, t);
    else if (kind < 0.8)
        draw_field(d, t);
    else
        draw_convex(d, t, kind < 0.9);
}

static void release(thing *t)
{
    soup_free(&t->all);
    mesh_destroy(t->mesh);
    compound_destroy(t->compound);
    hull_destroy(t->hull);
}

static pose draw_pose(dice *d)
{
    const double h = 0.5, r = 0.70710678118654752440;
    const quat turns[] = {{1, 0, 0, 0}, {1, 0, 0, 0}, {h, h, h, h}, {r, 0, 0, r}, {r, r, 0, 0}};
    double kind = dice_between(d, 0, 6);
    quat q = kind < 5 ? turns[(int)kind] : dice_quat(d);
    vec3 p = dice_between(d, 0, 1) < 0.3 ? VEC_ZERO : lattice_point(d, 0.125, dice_between(d, 0, 1) < 0.5 ? 4 : 12);
    return (pose){p, q};
}

/* ---- what is true ---- */

static bool is_held(const thing *a, const thing *b, pose b_in_a)
{
    pose a_in_b = pose_relative(b_in_a, POSE_IDENTITY);
    for (int i = 0; b->solid && i < a->count; i++)
        if (brute_winding(&b->all, pose_point(a_in_b, a->point[i])) != 0) return true;
    for (int i = 0; a->solid && i < b->count; i++)
        if (brute_winding(&a->all, pose_point(b_in_a, b->point[i])) != 0) return true;
    return false;
}

/* The gap, 0 where they touch or one is inside of the other. */
static double true_gap(const thing *a, const thing *b, pose b_in_a)
{
    double gap = (double)brute_distance(&a->all, &b->all, &b_in_a);
    return gap > SLACK && is_held(a, b, b_in_a) ? 0 : gap;
}

/* ---- checks ---- */

typedef struct bodies_case {
    const thing *a, *b;
    pose at; /* B's, in A's frame */
    uint64_t seed;
} bodies_case;

static void tell(const bodies_case *c, const char *kind, double lo, double hi, double by)
{
    char text[512];
    snprintf(text, sizeof text,
        "seed %llu:%s |%s | B at (%g %g %g) turned (%.17g %.17g %.17g %.17g): [%.17g, %.17g], %g",
        (unsigned long long)c->seed, c->a->name, c->b->name, c->at.p.x, c->at.p.y, c->at.p.z, c->at.q.w, c->at.q.x,
        c->at.q.y, c->at.q.z, lo, hi, by);
    found(kind, text);
}

/* Moved along the axis by the depth they are apart, but for rounding. */
static bool separates(const bodies_case *c, const narrow_result *r)
{
    for (int k = -1; k <= 1; k++) {
        pose moved = c->at;
        moved.p = vec_madd(moved.p, -r->lo + k * SLACK, r->axis);
        if (true_gap(c->a, c->b, moved) > 0) return true;
    }
    return false;
}

static void check_distance(const bodies_case *c, dice *d)
{
    narrow_result r = ask(&c->a->it, &c->b->it, c->at, NARROW_DISTANCE | NARROW_MANIFOLD);
    double gap = true_gap(c->a, c->b, c->at);
    if (!(r.lo <= r.hi)) tell(c, "lo above hi", r.lo, r.hi, 0);
    if (!(fabs(vec_norm(r.axis) - 1) < 1e-14)) tell(c, "the axis is not unit", r.lo, r.hi, vec_norm(r.axis));
    if (!vec_finite(r.point_a) || !vec_finite(r.point_b)) tell(c, "points are no numbers", r.lo, r.hi, 0);
    if (!(r.lo <= gap + SLACK)) tell(c, "lo above the truth", r.lo, r.hi, gap);
    if (gap > SLACK && !(r.hi >= gap - SLACK)) tell(c, "hi below the truth", r.lo, r.hi, gap);
    if (gap > SLACK && !(r.hi - r.lo <= 1e-8)) tell(c, "a wide gap", r.lo, r.hi, gap);
    if (gap == 0 && r.lo > 0) tell(c, "a contact is missed", r.lo, r.hi, gap);
    if (r.lo <= 0 && r.manifold.count == 0) tell(c, "no contact point", r.lo, r.hi, gap);
    if (r.lo < 0 && !separates(c, &r)) tell(c, "the move does not separate", r.lo, r.hi, 0);
    for (int k = 0; k < DIRECTIONS && r.hi < -1e-6; k++) { /* by less nothing separates them */
        vec3 way = k ? vec_unit(dice_vec(d, -1, 1)) : r.axis;
        pose moved = c->at;
        moved.p = vec_madd(moved.p, -r.hi * (1 - 1e-6), way);
        double left = true_gap(c->a, c->b, moved);
        if (left > SLACK) tell(c, "hi below the depth", r.lo, r.hi, left);
    }
    narrow_result back = ask(&c->b->it, &c->a->it, pose_relative(c->at, POSE_IDENTITY), NARROW_DISTANCE);
    if (!(back.lo <= r.hi + SLACK && r.lo <= back.hi + SLACK)) tell(c, "in the other order", back.lo, back.hi, r.lo);
    narrow_result verdict = ask(&c->a->it, &c->b->it, c->at, NARROW_VERDICT);
    if (!(verdict.lo <= r.hi && r.lo <= verdict.hi)) tell(c, "the verdict differs", verdict.lo, verdict.hi, r.lo);
}

/* Straight, and turning for some. */
static void check_impact(const bodies_case *c, dice *d)
{
    const toi_request request = {.span = 1, .tolerance = 1e-6};
    bool turning = dice_between(d, 0, 1) < 0.3;
    vec3 angular = turning ? dice_vec(d, -1, 1) : VEC_ZERO;
    motion still = {.start = POSE_IDENTITY}, moving = {c->at, lattice_point(d, 0.25, 8), angular};
    toi_mover ma = {&c->a->it, POSE_IDENTITY, still}, mb = {&c->b->it, POSE_IDENTITY, moving};
    bool in_order = narrow_ordered(&c->a->it, 0, &c->b->it, 1);
    toi_result t;
    toi_find(in_order ? &ma : &mb, in_order ? &mb : &ma, &request, VEC_ZERO, scratch, &t);
    for (int k = 0; k <= SAMPLES; k++) {
        double time = (double)k / SAMPLES;
        if (time >= t.lo) break;
        double gap = true_gap(c->a, c->b, motion_pose(&moving, time));
        if (gap == 0) tell(c, "CCD: a contact is missed", t.lo, t.hi, time);
    }
    if (t.status != TOI_HIT) return;
    double gap = true_gap(c->a, c->b, motion_pose(&moving, t.hi));
    if (!(gap <= 1e-9)) tell(c, "CCD: no contact at hi", t.lo, t.hi, gap);
}

static bool same_bits(const narrow_result *x, const narrow_result *y)
{
    return memcmp(&x->lo, &y->lo, offsetof(narrow_result, manifold)) == 0;
}

/* What it remembers of another pose changes no bit. */
static void check_memory(const bodies_case *c, pose before)
{
    const narrow_request request = {.facts = NARROW_DISTANCE, .tolerance = 1e-9, .range = INFINITY};
    bool in_order = narrow_ordered(&c->a->it, 0, &c->b->it, 1);
    const shape *a = in_order ? &c->a->it : &c->b->it, *b = in_order ? &c->b->it : &c->a->it;
    pose was = in_order ? before : pose_relative(before, POSE_IDENTITY);
    pose is = in_order ? c->at : pose_relative(c->at, POSE_IDENTITY);
    narrow_cache cache = {.lower = 0};
    narrow_result cold, kept;
    memset(&cold, 0, sizeof cold), memset(&kept, 0, sizeof kept);
    narrow_query(a, b, &is, &request, NULL, scratch, &cold);
    narrow_query(a, b, &was, &request, &cache, scratch, &kept);
    for (int times = 0; times < 2; times++) {
        narrow_query(a, b, &is, &request, &cache, scratch, &kept);
        if (!same_bits(&cold, &kept)) tell(c, "what it remembers changes it", kept.lo, kept.hi, cold.lo);
    }
}

static int rounds(int brief)
{
    return getenv("COLLIDED_NIGHTLY") ? 20 * brief : brief / (getenv("COLLIDED_BRIEF") ? 5 : 1);
}

/* COLLIDED_SEED: only that one. */
static void bodies_of_several_pieces_agree_with_brute_force(void **state)
{
    (void)state;
    const char *only = getenv("COLLIDED_SEED");
    uint64_t first = only ? strtoull(only, NULL, 10) : 1, count = only ? 1 : (uint64_t)rounds(300);
    size_t cases = 0, contacts = 0, held = 0;
    for (uint64_t seed = first; seed < first + count; seed++) {
        dice d = {seed * 1000003};
        thing a, b;
        bool other_first = seed % 2;
        draw(&d, other_first ? &b : &a, false);
        draw(&d, other_first ? &a : &b, true);
        pose before = draw_pose(&d);
        bodies_case c = {&a, &b, draw_pose(&d), seed};
        if (a.mesh && a.sound && a.mesh->solid != a.solid) tell(&c, "A is a solid, or is not", 0, 0, 0);
        if (b.mesh && b.sound && b.mesh->solid != b.solid) tell(&c, "B is a solid, or is not", 0, 0, 0);
        if (a.sound && b.sound) {
            check_distance(&c, &d);
            check_impact(&c, &d);
            check_memory(&c, before);
            bool crossing = brute_distance(&a.all, &b.all, &c.at) <= SLACK;
            cases++, contacts += crossing, held += !crossing && is_held(&a, &b, c.at);
        }
        release(&a);
        release(&b);
    }
    print_message("%zu cases: %zu cross, %zu hold one another\n", cases, contacts, held);
    assert_nothing_found();
}

/* Against a half-space: the lowest point of all. */
static void a_half_space_meets_the_lowest_of_all_pieces(void **state)
{
    (void)state;
    for (uint64_t seed = 1; seed <= (uint64_t)rounds(200); seed++) {
        dice d = {seed * 7919};
        thing t;
        draw(&d, &t, false);
        const shape plane = {.type = SHAPE_HALFSPACE};
        pose at = draw_pose(&d);
        thing none = {.name = " half-space"};
        bodies_case c = {&none, &t, at, seed};
        narrow_result r = ask(&plane, &t.it, at, NARROW_DISTANCE | NARROW_MANIFOLD);
        double truth = INFINITY;
        for (size_t i = 0; i < 3 * t.all.triangle_count; i++) {
            const double *p = t.all.points + 3 * (size_t)t.all.corners[i];
            truth = fmin(truth, pose_point(at, vec(p[0], p[1], p[2])).z);
        }
        if (!(r.lo <= truth + SLACK && truth - SLACK <= r.hi)) tell(&c, "not the lowest", r.lo, r.hi, truth);
        release(&t);
    }
    assert_nothing_found();
}

/* A mesh of a convex body is that body: by the engine of convex shapes alone. */
static void meshes_of_convex_bodies_are_these(void **state)
{
    (void)state;
    for (uint64_t seed = 1; seed <= (uint64_t)rounds(1500); seed++) {
        dice d = {seed * 104729};
        thing a = {.all = soup_from(NULL, 0, NULL, 0), .solid = true}, b = a;
        b.all = soup_from(NULL, 0, NULL, 0);
        draw_convex(&d, &a, seed % 2);
        draw_convex(&d, &b, seed / 2 % 2);
        mesh *ma = soup_mesh(&a.all), *mb = soup_mesh(&b.all);
        bodies_case c = {&a, &b, draw_pose(&d), seed};
        const narrow_request request = {
            .facts = NARROW_DISTANCE, .tolerance = 1e-9, .range = INFINITY, .engine = NARROW_ENGINE_GJK};
        narrow_result truth;
        narrow_query_world(&a.it, POSE_IDENTITY, &b.it, c.at, &request, scratch, &truth);
        const shape as_mesh_a = mesh_shape(ma, 0), as_mesh_b = mesh_shape(mb, 0);
        const shape *pairs[3][2] = {{&as_mesh_a, &as_mesh_b}, {&a.it, &as_mesh_b}, {&as_mesh_a, &b.it}};
        for (int k = 0; k < 3; k++) {
            narrow_result r = ask(pairs[k][0], pairs[k][1], c.at, NARROW_DISTANCE);
            if (!(r.lo <= truth.hi + SLACK && truth.lo <= r.hi + SLACK))
                tell(&c, "not the hulls'", r.lo, r.hi, truth.lo);
        }
        mesh_destroy(ma);
        mesh_destroy(mb);
        release(&a);
        release(&b);
    }
    assert_nothing_found();
}

/* ---- many components ---- */

enum { LOOSE = 120 };

/* Small triangles and needles about a place, none of them near the surface of the solid; the sides that are wanted. */
static soup loose_pieces(dice *d, const soup *solid, double size, bool outside, bool inside)
{
    static const int32_t SHAPES[3][3] = {{0, 1, 2}, {0, 1, 1}, {0, 0, 0}};
    soup s = soup_from(NULL, 0, NULL, 0);
    for (int count = 0; count < LOOSE;) {
        vec3 at = vec_scale(dice_vec(d, -1.4, 1.4), size);
        if (brute_point_distance(solid, at) < 0.02 * size) continue;
        bool in = brute_winding(solid, at) != 0;
        if (!(in ? inside && count == LOOSE / 2 : outside && !(inside && count == LOOSE / 2))) continue;
        double points[9];
        for (int k = 0; k < 9; k++) points[k] = dice_between(d, -0.01, 0.01) * size;
        soup one = soup_from(points, 3, SHAPES[count % 3 * (count > 0)], 1);
        soup_add(&s, &one, at);
        soup_free(&one);
        count++;
    }
    return s;
}

/* One in the midst of many, or none; in both orders, of any size, and wherever both are. */
static void one_of_many_loose_triangles_is_inside(void **state)
{
    (void)state;
    for (uint64_t seed = 1; seed <= (uint64_t)rounds(12); seed++) {
        dice d = {seed * 15485863};
        double size = seed % 3 == 0 ? 1e-6 : seed % 3 == 1 ? 1 : 1e5;
        soup solid = seed % 2 ? soup_torus(size, 0.3 * size, 12, 8) : soup_icosphere(size, 1);
        bool inside = seed / 2 % 2;
        soup loose = loose_pieces(&d, &solid, size, true, inside);
        mesh *ma = soup_mesh(&loose), *mb = soup_mesh(&solid);
        assert_int_equal(ma->component_count, LOOSE);
        assert_int_equal(mb->component_count, 1);
        const shape a = mesh_shape(ma, 0), b = mesh_shape(mb, 0);
        pose frame = {vec_scale(dice_vec(&d, -3, 3), size), dice_quat(&d)};
        const narrow_request request = {.facts = NARROW_DISTANCE, .tolerance = 1e-9 * size, .range = INFINITY};
        for (int turned = 0; turned < 2; turned++) {
            narrow_result r;
            narrow_query_world(turned ? &b : &a, frame, turned ? &a : &b, frame, &request, scratch, &r);
            if (inside ? !(r.hi < -0.01 * size) : !(r.lo > 0.005 * size))
                fail_msg("seed %llu, order %d: [%g, %g]", (unsigned long long)seed, turned, r.lo, r.hi);
        }
        mesh_destroy(ma);
        mesh_destroy(mb);
        soup_free(&solid);
        soup_free(&loose);
    }
}

static int make_scratch(void **state)
{
    (void)state;
    scratch = aligned_alloc(64, narrow_scratch_size());
    return scratch ? 0 : 1;
}

static int free_scratch(void **state)
{
    (void)state;
    free(scratch);
    return 0;
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(one_of_two_bodies_of_a_mesh_is_inside_of_a_solid),
        cmocka_unit_test(a_needle_in_a_cube_touches_it),
        cmocka_unit_test(a_needle_that_lies_on_a_face_touches_at_its_ends),
        cmocka_unit_test(bodies_of_several_pieces_agree_with_brute_force),
        cmocka_unit_test(one_of_many_loose_triangles_is_inside),
        cmocka_unit_test(a_half_space_meets_the_lowest_of_all_pieces),
        cmocka_unit_test(meshes_of_convex_bodies_are_these),
    };
    return cmocka_run_group_tests(tests, make_scratch, free_scratch);
}
