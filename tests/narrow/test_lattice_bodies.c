/* Meshes, height fields and compounds on a lattice, against every convex type and against each other: parallel faces,
 * common centres and sides, exactly or but for 1e-16 to 1e-3. Each body is a union of convex parts, so what is true is
 * known of gaps, in 113 bits between polytopes; of overlaps what no translation along an axis needs; and of convex
 * bodies all that their one part has. */
#include "cases.h"
#include "fields.h"
#include "geom/compound.h"
#include "narrow/contact/manifold.h"
#include "polytope_oracle.h"
#include "solids.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdlib.h>

#include <cmocka.h>

#include "findings.h"

enum { PARTS_MAX = 32, EXACTLY_EVERY = 8, EXACTLY_PARTS = 4 };

typedef struct body {
    const char *name;
    shape it;
    int count;
    shape part[PARTS_MAX];
    pose local[PARTS_MAX];
    mesh *mesh; /* owned, as the hulls and the compound */
    compound *compound;
    hull *hull[PARTS_MAX];
} body;

static int rounds(void)
{
    return getenv("COLLIDED_NIGHTLY") ? 150 : getenv("COLLIDED_BRIEF") ? 4 : 10;
}

/* ---- bodies ---- */

enum { BODIES_MAX = 32 };
static body bodies[BODIES_MAX];
static int body_count;

static body *begin_body(const char *name)
{
    assert_true(body_count < BODIES_MAX);
    body *b = &bodies[body_count++];
    memset(b, 0, sizeof *b);
    b->name = name;
    return b;
}

static void add_part(body *b, shape s, pose at)
{
    assert_true(b->count < PARTS_MAX);
    b->part[b->count] = s;
    b->local[b->count++] = at;
}

static shape box_of(double x, double y, double z)
{
    return (shape){.type = SHAPE_BOX, .half = {x, y, z}};
}

static pose shifted(double x, double y, double z)
{
    return (pose){{x, y, z}, {1, 0, 0, 0}};
}

static void add_hull(body *b, const double *points, size_t count)
{
    hull *h;
    assert_int_equal(hull_build(points, count, 0, &h), HULL_OK);
    b->hull[b->count] = h;
    add_part(b, (shape){.type = SHAPE_HULL, .hull = h}, POSE_IDENTITY);
}

static body *mesh_body(const char *name, soup s)
{
    body *b = begin_body(name);
    b->mesh = soup_mesh(&s);
    b->it = mesh_shape(b->mesh, 0);
    soup_free(&s);
    return b;
}

static body *compound_body(const char *name, const shape *parts, const pose *locals, size_t count)
{
    body *b = begin_body(name);
    assert_int_equal(compound_build(parts, locals, count, &b->compound), COMPOUND_OK);
    b->it = (shape){.type = SHAPE_COMPOUND, .compound = b->compound};
    for (size_t i = 0; i < count; i++) add_part(b, parts[i], locals[i]);
    return b;
}

/* A prism over an outline, counter-clockwise; its caps as a fan about the first corner, about which it must be
 * star-shaped. */
static soup prism(const double (*outline)[2], int count, double half)
{
    soup s = {calloc(3 * 64, sizeof(double)), 0, calloc(3 * 128, sizeof(int32_t)), 0};
    for (int i = 0; i < 2 * count; i++) {
        double *to = s.points + 3 * s.point_count++;
        to[0] = outline[i % count][0], to[1] = outline[i % count][1], to[2] = i < count ? -half : half;
    }
    for (int i = 0; i < count; i++) {
        int j = (i + 1) % count;
        const int32_t faces[4][3] = {
            {i, j, count + j}, {i, count + j, count + i}, {0, j, i}, {count, count + i, count + j}};
        int count_here = i && j ? 4 : 2; /* no caps at the first corner */
        memcpy(s.corners + 3 * s.triangle_count, faces, (size_t)count_here * sizeof faces[0]);
        s.triangle_count += (size_t)count_here;
    }
    return s;
}

static void prism_body(const char *name, const double (*outline)[2], int count, double half)
{
    soup s = prism(outline, count, half);
    double points[3 * 64];
    size_t point_count = s.point_count;
    memcpy(points, s.points, 3 * point_count * sizeof *points);
    add_hull(mesh_body(name, s), points, point_count);
}

/* Each half of each cell, down to the base. */
static void field_body(const char *name, const double *heights, uint32_t rows, uint32_t columns)
{
    static field f;
    f.it = (height_field){rows, columns, 0.5, 0.5, 0.25, f.heights};
    memcpy(f.heights, heights, rows * columns * sizeof *heights);
    body *b = begin_body(name);
    b->mesh = field_mesh(&f);
    b->it = mesh_shape(b->mesh, 0);
    double bottom = INFINITY;
    for (uint32_t i = 0; i < rows * columns; i++) bottom = fmin(bottom, heights[i] - 0.25);
    for (uint32_t i = 0; i < 2 * (rows - 1) * (columns - 1); i++) {
        uint32_t row = i / 2 / (columns - 1), column = i / 2 % (columns - 1);
        const uint32_t at[3][2] = {{column, row}, {column + 1, row + 1}, {column + !(i & 1), row + (i & 1)}};
        double points[18];
        for (int k = 0; k < 6; k++) {
            const uint32_t *c = at[k % 3];
            points[3 * k] = 0.5 * (c[0] - 0.5 * (columns - 1)), points[3 * k + 1] = 0.5 * (c[1] - 0.5 * (rows - 1));
            points[3 * k + 2] = k < 3 ? heights[c[1] * columns + c[0]] : bottom;
        }
        add_hull(b, points, 6);
    }
}

static void make_meshes(void)
{
    static const double HEXAGON[][2] = {{1, 0}, {0.5, 0.5}, {-0.5, 0.5}, {-1, 0}, {-0.5, -0.5}, {0.5, -0.5}},
                        WEDGE[][2] = {{0.5, -0.5}, {0.5, 0.5}, {-0.5, -0.5}},
                        ELL[][2] = {{0, 0}, {-0.5, 0}, {-0.5, -0.5}, {1, -0.5}, {1, 1}, {0, 1}};
    static const double FLAT[9] = {0}, STEPS[] = {0, 0, 0.25, 0.25, 0, 0, 0.25, 0.25, 0.5, 0.5, 0.25, 0.25},
                        RAMP[] = {0, 0.125, 0.25, 0, 0.125, 0.25, 0, 0.125, 0.25};
    double round[12][2];
    for (int i = 0; i < 12; i++) round[i][0] = 0.5 * cos(M_PI * i / 6), round[i][1] = 0.5 * sin(M_PI * i / 6);
    add_part(mesh_body("a cube", soup_box(0.5, 0.5, 0.5, 1)), box_of(0.5, 0.5, 0.5), POSE_IDENTITY);
    add_part(mesh_body("a plate in many squares", soup_box(1, 1, 0.25, 4)), box_of(1, 1, 0.25), POSE_IDENTITY);
    prism_body("a prism of six sides", HEXAGON, 6, 0.5);
    prism_body("a wedge", WEDGE, 3, 0.25);
    prism_body("a cylinder of twelve sides", round, 12, 0.75);
    body *ell = mesh_body("an L", prism(ELL, 6, 0.375));
    add_part(ell, box_of(0.75, 0.25, 0.375), shifted(0.25, -0.25, 0));
    add_part(ell, box_of(0.5, 0.75, 0.375), shifted(0.5, 0.25, 0));
    add_part(mesh_body("an open surface", soup_plane(1, 3)), box_of(1, 1, 0), POSE_IDENTITY);
    field_body("flat ground", FLAT, 3, 3);
    field_body("steps", STEPS, 3, 4);
    field_body("a ramp", RAMP, 3, 3);
}

static void make_compounds(void)
{
    const double half_turn = 0.70710678118654752440;
    const quat quarter = {half_turn, half_turn, 0, 0};
    const shape two[] = {box_of(0.75, 0.25, 0.375), box_of(0.5, 0.75, 0.375)};
    const pose at_two[] = {shifted(0.25, -0.25, 0), shifted(0.5, 0.25, 0)};
    const shape three[] = {box_of(1, 0.5, 0.125), box_of(0.125, 0.5, 0.5), box_of(0.125, 0.5, 0.5)};
    const pose at_three[] = {POSE_IDENTITY, shifted(-0.875, 0, 0.625), shifted(0.875, 0, 0.625)};
    const shape mixed[] = {box_of(0.5, 0.5, 0.25), {.type = SHAPE_CYLINDER, .half = {0.25, 0.25, 0.5}}};
    const pose at_mixed[] = {POSE_IDENTITY, {{0, 0, 0.5}, quarter}};
    const shape apart[] = {{.type = SHAPE_SPHERE, .radius = 0.5}, box_of(0.25, 0.25, 0.25)};
    const pose at_apart[] = {shifted(-1, 0, 0), shifted(1, 0, 0)};
    compound_body("two boxes as an L", two, at_two, 2);
    compound_body("three boxes as a trough", three, at_three, 3);
    compound_body("a box and a cylinder", mixed, at_mixed, 2);
    compound_body("a ball and a box apart", apart, at_apart, 2);
}

static void free_bodies(void)
{
    for (int i = 0; i < body_count; i++) {
        mesh_destroy(bodies[i].mesh);
        compound_destroy(bodies[i].compound);
        for (int k = 0; k < PARTS_MAX; k++) hull_destroy(bodies[i].hull[k]);
    }
    body_count = 0;
}

/* ---- pairs ---- */

typedef struct lattice_case {
    const body *a, *b; /* as they were drawn: in any order */
    pose at_a, at_b;
    uint64_t seed;
    double size;
    bool both_convex, polytopes;
} lattice_case;

static void report(const lattice_case *c, const char *kind, const narrow_result *r, double by)
{
    char text[256];
    snprintf(text, sizeof text, "%s and %s, seed %llu: [%.17g, %.17g] by %s, off by %g", c->a->name, c->b->name,
        (unsigned long long)c->seed, r->lo, r->hi, narrow_method_name(r->method), by);
    found(kind, text);
}

/* For lattice_poses, which needs no more than its size. */
static shape stand_in(const body *b)
{
    bool plane = b->it.type == SHAPE_HALFSPACE;
    return (shape){.type = plane ? SHAPE_HALFSPACE : SHAPE_SPHERE, .radius = plane ? 0 : 0.75 * shape_reach(&b->it)};
}

static bool is_polytope(const body *b)
{
    for (int i = 0; i < b->count; i++)
        if (b->part[i].type > SHAPE_BOX && b->part[i].type != SHAPE_HULL) return false;
    return true;
}

static lattice_case draw(const body *a, const body *b, uint64_t seed)
{
    lattice_case c = {.a = a, .b = b, .seed = seed};
    random_state r = {seed};
    shape size_a = stand_in(a), size_b = stand_in(b);
    lattice_poses(&r, &size_a, &size_b, &c.at_a, &c.at_b);
    c.size = size_a.radius + size_b.radius + vec_norm(vec_sub(c.at_b.p, c.at_a.p));
    c.both_convex = a->count == 1 && b->count == 1;
    c.polytopes = is_polytope(a) && is_polytope(b);
    return c;
}

/* The exact pose of a part: the body's times its own. */
static placed place_part(const body *b, int i, pose at, vec3 origin)
{
    placed whole = oracle_place(&b->it, at, origin), own = oracle_place(&b->part[i], b->local[i], VEC_ZERO);
    real3 corner = oracle_point(&whole, own.p);
    placed part = {.s = &b->part[i], .p = corner};
    const placed turn = {.rx = whole.rx, .ry = whole.ry, .rz = whole.rz};
    part.rx = oracle_point(&turn, own.rx), part.ry = oracle_point(&turn, own.ry), part.rz = oracle_point(&turn, own.rz);
    return part;
}

static real height_of(const body *b, pose at, vec3 origin, real3 n)
{
    real most = -1e4000Q;
    for (int i = 0; i < b->count; i++) {
        placed part = place_part(b, i, at, origin);
        real h = oracle_height(&part, n);
        if (h > most) most = h;
    }
    return most;
}

/* Of their convex hulls along a direction: a lower bound of the signed distance. */
static double separation(const lattice_case *c, vec3 axis)
{
    real3 n = real3_of(axis), back = real3_scale(n, -1);
    real length = real_sqrt(real3_dot(n, n));
    return (double)((-height_of(c->b, c->at_b, c->at_a.p, back) - height_of(c->a, c->at_a, c->at_a.p, n)) / length);
}

/* The least signed distance of two parts, between lo and hi. */
typedef struct bounds {
    double lo, hi;
} bounds;

static bounds nearest_parts(const lattice_case *c, bool exactly)
{
    bounds all = {INFINITY, INFINITY};
    narrow_request request = measure_exactly();
    for (int i = 0; i < c->a->count; i++)
        for (int k = 0; k < c->b->count; k++) {
            narrow_result r;
            if (exactly) {
                placed a = place_part(c->a, i, c->at_a, c->at_a.p), b = place_part(c->b, k, c->at_b, c->at_a.p);
                real truth = polytope_signed_distance(&a, &b);
                r.lo = nextafter((double)truth, -INFINITY), r.hi = nextafter((double)truth, INFINITY);
            } else {
                narrow_query_world(&c->a->part[i], pose_mul(c->at_a, c->a->local[i]), &c->b->part[k],
                    pose_mul(c->at_b, c->b->local[k]), &request, case_scratch(), &r);
                r.lo -= 1e-14 * c->size, r.hi += 1e-14 * c->size; /* the poses are rounded */
            }
            all.lo = fmin(all.lo, r.lo), all.hi = fmin(all.hi, r.hi);
        }
    return all;
}

static double outside(const body *b, pose at, vec3 origin, vec3 point)
{
    double least = INFINITY;
    for (int i = 0; i < b->count; i++) {
        placed part = place_part(b, i, at, origin);
        least = fmin(least, (double)oracle_outside(&part, point));
    }
    return least;
}

static void check_points(const lattice_case *c, const narrow_result *r)
{
    double slack = 1e-9 * c->size, line = vec_norm(vec_sub(r->point_b, r->point_a));
    if (!vec_finite(r->point_a) || !vec_finite(r->point_b)) report(c, "points are not numbers", r, 0);
    if (!(r->lo > 0)) return;
    double out_a = outside(c->a, c->at_a, c->at_a.p, r->point_a), out_b = outside(c->b, c->at_b, c->at_a.p, r->point_b);
    if (!(out_a <= slack)) report(c, "the point of A is outside", r, out_a);
    if (!(out_b <= slack)) report(c, "the point of B is outside", r, out_b);
    if (!(line <= r->hi + 0x1p-50 * c->size)) report(c, "the points do not prove hi", r, line - r->hi);
}

static void check_truth(const lattice_case *c, const narrow_result *r, double tolerance, bool exactly)
{
    bool few = c->a->count * c->b->count <= EXACTLY_PARTS || getenv("COLLIDED_NIGHTLY"); /* it is slow */
    bounds parts = nearest_parts(c, exactly && few && c->polytopes);
    if (!(r->lo <= parts.hi)) report(c, "lo above what two parts have", r, r->lo - parts.hi);
    if ((parts.lo > 0 || c->both_convex) && !(parts.lo <= r->hi)) report(c, "hi below the truth", r, r->hi - parts.lo);
    if (parts.lo > tolerance + 1e-9 * c->size && !(r->lo > 0)) report(c, "a gap is not seen", r, parts.lo);
    static const vec3 AXES[] = {{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}, {1, 1, 0}};
    bool planes = c->a->it.type == SHAPE_HALFSPACE || c->b->it.type == SHAPE_HALFSPACE;
    for (int k = 0; k < 7 && !planes; k++) {
        double by = separation(c, AXES[k]) - r->hi;
        if (by > 0x1p-52 * c->size) report(c, "a direction separates by more than hi", r, by);
    }
    if (!(r->hi - r->lo <= 1e-6 * c->size))
        if (r->lo > 0) report(c, "a wide gap", r, r->hi - r->lo);
}

/* Moved along the axis by the depth no two parts overlap, but for rounding. */
static void check_move(const lattice_case *c, const narrow_result *r)
{
    lattice_case moved = *c;
    if (r->lo > 0) return;
    moved.at_b.p = vec_madd(c->at_b.p, -r->lo, r->axis);
    bounds left = nearest_parts(&moved, false);
    if (!(left.hi >= -1e-13 * c->size)) report(c, "the move does not separate", r, left.hi);
}

static narrow_result ask(const lattice_case *c, const narrow_request *request)
{
    narrow_result r;
    memset(&r, 0xa5, sizeof r);
    narrow_query_world(&c->a->it, c->at_a, &c->b->it, c->at_b, request, case_scratch(), &r);
    return r;
}

static void check_swapped(const lattice_case *c, const narrow_result *r, const narrow_request *request)
{
    if (c->a->it.type == c->b->it.type && memcmp(&c->at_a, &c->at_b, sizeof c->at_a) == 0) return; /* alike in all */
    const lattice_case turned = {.a = c->b, .b = c->a, .at_a = c->at_b, .at_b = c->at_a};
    narrow_result other = ask(&turned, request);
    if (other.lo != r->lo || other.hi != r->hi) report(c, "in the other order it differs", &other, other.lo - r->lo);
    if (vec_norm(vec_add(other.axis, r->axis)) != 0) report(c, "in the other order its axis differs", &other, 0);
    if (other.manifold.count != r->manifold.count) report(c, "in the other order other contacts", &other, 0);
}

static bool same_bits(const narrow_result *x, const narrow_result *y)
{
    bool same = memcmp(&x->lo, &y->lo, offsetof(narrow_result, manifold)) == 0 && x->status == y->status &&
                x->manifold.count == y->manifold.count;
    for (uint32_t i = 0; same && i < x->manifold.count; i++)
        same = memcmp(&x->manifold.points[i], &y->manifold.points[i], sizeof(manifold_point)) == 0;
    return same;
}

static void check_memory(const lattice_case *c, const lattice_case *before, const narrow_request *request)
{
    bool straight = narrow_ordered(&c->a->it, 0, &c->b->it, 1);
    const shape *a = straight ? &c->a->it : &c->b->it, *b = straight ? &c->b->it : &c->a->it;
    pose was = straight ? pose_relative(before->at_a, before->at_b) : pose_relative(before->at_b, before->at_a);
    pose is = straight ? pose_relative(c->at_a, c->at_b) : pose_relative(c->at_b, c->at_a);
    narrow_cache cache = {.lower = 0};
    narrow_result cold, kept;
    narrow_query(a, b, &is, request, NULL, case_scratch(), &cold);
    narrow_query(a, b, &was, request, &cache, case_scratch(), &kept);
    for (int times = 0; times < 2; times++) {
        narrow_query(a, b, &is, request, &cache, case_scratch(), &kept);
        if (!same_bits(&cold, &kept)) report(c, "what it remembers changes it", &kept, kept.lo - cold.lo);
    }
    narrow_cache proof = {.lower = 0};
    if (narrow_apart(a, b, &is, request->threshold, &proof) &&
        !(proof.lower > request->threshold && proof.lower <= cold.hi + 0x1p-50 * c->size))
        report(c, "apart, though they are not", &cold, proof.lower);
}

static void check_verdicts(const lattice_case *c, const narrow_result *r)
{
    static const double THRESHOLDS[] = {0, 0.125, -0.125, 0.5};
    for (int k = 0; k < 4; k++) {
        narrow_request request = {.facts = NARROW_VERDICT, .range = INFINITY, .threshold = THRESHOLDS[k]};
        narrow_result v = ask(c, &request);
        double slack = 1e-12 * c->size;
        bool decided = v.lo > request.threshold || v.hi <= request.threshold;
        if (!(v.lo <= v.hi)) report(c, "verdict: lo above hi", &v, v.lo - v.hi);
        if (!(v.lo <= r->hi && r->lo <= v.hi)) report(c, "verdict: not what is measured", &v, request.threshold);
        bool plain = r->lo > request.threshold + slack || r->hi <= request.threshold - slack;
        /* how deep bodies that are not convex are is bracketed, and for a verdict alone with less effort */
        bool honest = request.threshold < 0 && !c->both_convex && v.status == NARROW_WIDE;
        if (!decided && plain && !honest) report(c, "undecided, though it is plain", &v, request.threshold);
    }
}

static bool is_witness(uint64_t feature)
{
    return feature_kind(feature_code_a(feature)) == FEATURE_WITNESS ||
           feature_kind(feature_code_b(feature)) == FEATURE_WITNESS;
}

static void check_contacts(const lattice_case *c, const narrow_result *r, double threshold)
{
    const manifold *m = &r->manifold;
    if (r->lo > threshold ? m->count : m->count < 1 || m->count > MANIFOLD_POINTS_MAX)
        report(c, "a wrong number of contacts", r, m->count);
    for (uint32_t i = 0; i < m->count && i < MANIFOLD_POINTS_MAX; i++) {
        const manifold_point *p = &m->points[i];
        if (!vec_finite(p->point) || !isfinite(p->distance)) report(c, "a contact is not a number", r, 0);
        if (is_witness(p->feature)) continue; /* where the features do not meet: between points that are on both */
        vec3 half = vec_scale(r->axis, 0.5 * p->distance);
        double out_a = outside(c->a, c->at_a, c->at_a.p, vec_sub(p->point, half));
        double out_b = outside(c->b, c->at_b, c->at_a.p, vec_add(p->point, half));
        /* edges side by side touch where they are no farther aside than above each other */
        if (!(fmax(out_a, out_b) <= 2e-6 * c->size + fabs(p->distance)))
            report(c, "a contact is elsewhere", r, fmax(out_a, out_b));
        for (uint32_t k = 0; k < i; k++) {
            if (m->points[k].feature == p->feature &&
                vec_norm(vec_sub(m->points[k].point, p->point)) <= 1e-12 * c->size)
                report(c, "a contact is told twice", r, p->distance);
        }
    }
}

static void check(const lattice_case *c, const lattice_case *before, int i)
{
    static const double TOLERANCES[] = {1e-9, 0, 1e-6};
    const narrow_request request = {.facts = NARROW_DISTANCE | NARROW_MANIFOLD,
        .tolerance = TOLERANCES[i % 3] * c->size,
        .range = INFINITY,
        .threshold = i % 2 ? 0 : 0.125};
    narrow_result r = ask(c, &request);
    if (!(r.lo <= r.hi)) report(c, "lo above hi", &r, r.lo - r.hi);
    if (!(fabs(vec_norm(r.axis) - 1) <= 1e-14)) report(c, "the axis is not unit", &r, 0);
    check_truth(c, &r, request.tolerance, i % EXACTLY_EVERY == 0);
    check_move(c, &r);
    check_points(c, &r);
    check_contacts(c, &r, request.threshold);
    check_swapped(c, &r, &request);
    check_memory(c, before, &request);
    if (i % 2) check_verdicts(c, &r);
}

static size_t check_pairs(const body *a, const body *b, uint64_t which, int n)
{
    lattice_case before = draw(a, b, which << 32);
    for (int i = 1; i <= n; i++) {
        lattice_case c = draw(a, b, (which << 32) + (uint64_t)i);
        check(&c, &before, i);
        before = c;
    }
    return (size_t)n;
}

/* A convex type as a body of one part: another shape each time. */
static void with_convex_types(void **state)
{
    (void)state;
    size_t all = 0;
    for (int i = 0; i < body_count; i++)
        for (int type = 0; type < SHAPE_CONVEX_COUNT; type++)
            for (int k = 0; k < rounds(); k++) {
                random_state r = {((uint64_t)i << 48) + ((uint64_t)type << 40) + (uint64_t)k};
                body one = {.name = shape_type_name((shape_type)type), .count = 1, .local = {POSE_IDENTITY}};
                one.it = one.part[0] = lattice_shape(&r, (shape_type)type);
                uint64_t which = ((uint64_t)i << 24) + ((uint64_t)type << 16) + (uint64_t)k;
                all += check_pairs(k % 2 ? &one : &bodies[i], k % 2 ? &bodies[i] : &one, which, 2);
            }
    print_message("%zu pairs\n", all);
    assert_nothing_found();
}

static void with_each_other(void **state)
{
    (void)state;
    size_t all = 0;
    for (int i = 0; i < body_count; i++)
        for (int k = 0; k <= i; k++)
            all += check_pairs(&bodies[i], &bodies[k], (1u << 30) + ((uint64_t)i << 8) + (uint64_t)k, rounds());
    print_message("%zu pairs\n", all);
    assert_nothing_found();
}

static int create(void **state)
{
    (void)state;
    cases_create();
    make_meshes();
    make_compounds();
    return 0;
}

static int destroy(void **state)
{
    (void)state;
    free_bodies();
    cases_destroy();
    return 0;
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(with_convex_types), cmocka_unit_test(with_each_other)};
    return cmocka_run_group_tests(tests, create, destroy);
}
