/* Two ways for each pair of convex types: what NARROW_ENGINE_AUTO answers by formulas and special searches against the
 * general method (NARROW_ENGINE_GJK), where formulas have their seams: features of one shape set on features of the
 * other, sizes of zero, coplanar and coaxial axes, equal sizes, one centre in the other, needles and slivers, rational
 * rotations, pairs that just touch, and all of that but for a little. Beside a half-space, of which there is one
 * formula only, the second way is the oracle's separation along the normal.
 *
 * Held: the two intervals intersect, without slack; the axis is unit; the axis proves lo and the points prove hi (in
 * 113 bits, by oracle.h); what is certain is as narrow as asked, or decided; verdicts, manifolds and placed queries
 * say the same as distances; the swapped pair says the same bits. The cases that were once wrong come first. */
#include "cases.h"
#include "narrow/contact/manifold.h"
#include "oracle.h"
#include "where_they_stand.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdlib.h>

#include <cmocka.h>

#include "findings.h"

/* Of one pair of types; a comparison is of one answer of AUTO with the general one, and a case has nine. */
enum { CASES_EACH = 3400, CASES_NIGHTLY = 100 * CASES_EACH, CASES_BRIEF = CASES_EACH / 20 };

typedef struct hostile {
    shape a, b;
    pose at_a, at_b;
    unsigned hull_a, hull_b; /* of create_hulls */
    bool touching;
} hostile;

static size_t comparisons, disjoint;

/* ---- hulls ---- */

enum { HULLS = 11, FLAT = 8 };

static hull *hulls[HULLS];

/* A cube, a tetrahedron, an octahedron, a wedge, a needle, a sliver, a thin bar, and a prism of six sides; flat ones: a
 * square, a segment and a point. */
static void create_hulls(void)
{
    static const double POINTS[HULLS][12][3] = {
        {{1, 1, 1}, {-1, 1, 1}, {1, -1, 1}, {-1, -1, 1}, {1, 1, -1}, {-1, 1, -1}, {1, -1, -1}, {-1, -1, -1}},
        {{1, 1, 1}, {1, -1, -1}, {-1, 1, -1}, {-1, -1, 1}},
        {{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}},
        {{1, 1, -1}, {1, -1, -1}, {-1, 1, -1}, {-1, -1, -1}, {0, 1, 1}, {0, -1, 1}},
        {{1e-6, 0, -1}, {-1e-6, 1e-6, -1}, {-1e-6, -1e-6, -1}, {0, 0, 1}},
        {{1, 0, 0}, {0, 1, 0}, {-1, 0, 1e-6}, {0, -1, 0}},
        {{1, 1e-3, 1e-3}, {-1, 1e-3, 1e-3}, {1, -1e-3, 1e-3}, {-1, -1e-3, 1e-3}, {1, 1e-3, -1e-3}, {-1, 1e-3, -1e-3},
            {1, -1e-3, -1e-3}, {-1, -1e-3, -1e-3}},
        {{2, 0, 1}, {1, 1, 1}, {-1, 1, 1}, {-2, 0, 1}, {-1, -1, 1}, {1, -1, 1}, {2, 0, -1}, {1, 1, -1}, {-1, 1, -1},
            {-2, 0, -1}, {-1, -1, -1}, {1, -1, -1}},
        {{1, 1, 0}, {-1, 1, 0}, {-1, -1, 0}, {1, -1, 0}}, {{1, 0, 0}, {-1, 0, 0}}, {{0, 0, 0}}};
    static const size_t COUNTS[HULLS] = {8, 4, 6, 6, 4, 4, 8, 12, 4, 2, 1};
    for (int i = 0; i < HULLS; i++) {
        double points[36];
        for (size_t k = 0; k < 3 * COUNTS[i]; k++) points[k] = 0.5 * POINTS[i][k / 3][k % 3];
        if (hull_build(points, COUNTS[i], i < FLAT ? 0 : HULL_ALLOW_FLAT, &hulls[i]) != HULL_OK) abort();
    }
}

/* ---- the lattice ---- */

static uint64_t below(random_state *r, uint64_t n)
{
    return random_bits(r) % n;
}

static double one_of(random_state *r, const double *from, size_t count)
{
    return from[below(r, count)];
}

static double hostile_size(random_state *r)
{
    static const double USUAL[] = {0.5, 1, 0.25, 0.3, 0.4, 0.75, 0.1},
                        ODD[] = {0, 0, 0, 1e-6, 1e-3, 1e3, 1e6, 1e-9, 1e-170};
    return below(r, 4) ? one_of(r, USUAL, 7) : one_of(r, ODD, 9);
}

static double hostile_radius(random_state *r)
{
    static const double RADII[] = {0.05, 0.125, 0.25, 1e-6, 0.5, 1e-3};
    return one_of(r, RADII, 6);
}

static shape hostile_shape(random_state *r, shape_type type, unsigned *which)
{
    shape s = {.type = type};
    double x = hostile_size(r), y = hostile_size(r), z = hostile_size(r);
    bool equal = below(r, 4) == 0, rounded = below(r, 3) == 0;
    if (equal) y = z = x;
    *which = (unsigned)below(r, HULLS);
    if (type == SHAPE_HULL) s.hull = hulls[*which];
    if (type == SHAPE_BOX || type == SHAPE_ELLIPSOID) s.half = vec(x, y, z);
    if (type == SHAPE_CYLINDER || type == SHAPE_CONE) s.half = vec(x, x, z);
    if (type == SHAPE_CAPSULE) s.half = vec(0, 0, z);
    if (type == SHAPE_SPHERE || type == SHAPE_CAPSULE) s.radius = below(r, 8) ? hostile_radius(r) : 0;
    if (rounded) s.radius = hostile_radius(r);
    return s;
}

/* Turns by multiples of 45 degrees, quaternions of small whole numbers, and any. */
static quat hostile_rotation(random_state *r)
{
    static const double EIGHTH[2] = {0.92387953251128675613, 0.38268343236508977173};
    static const quat QUARTERS[] = {{1, 0, 0, 0}, {1, 1, 0, 0}, {1, 0, 1, 0}, {1, 0, 0, 1}, {0, 1, 0, 0}, {0, 0, 1, 0},
        {1, 1, 1, 1}, {1, -1, 0, 0}, {0, 1, 1, 0}};
    quat q = quat_unit(QUARTERS[below(r, 9)]);
    uint64_t kind = below(r, 8);
    if (kind < 3) return q;
    if (kind < 5) {
        double s = EIGHTH[1];
        const quat by[3] = {{EIGHTH[0], s, 0, 0}, {EIGHTH[0], 0, s, 0}, {EIGHTH[0], 0, 0, s}};
        return quat_unit(quat_mul(by[below(r, 3)], q));
    }
    if (kind == 7) return random_rotation(r);
    double w = (double)below(r, 5), x = (double)below(r, 7) - 3, y = (double)below(r, 7) - 3,
           z = (double)below(r, 7) - 3;
    q = (quat){w, x, y, z};
    return quat_norm2(q) > 0 ? quat_unit(q) : (quat){1, 0, 0, 0};
}

static double little(random_state *r)
{
    static const double NOISE[] = {1e-17, 1e-16, 1e-15, 1e-13, 1e-12, 1e-10, 1e-9, 1e-8, 1e-6, 1e-5, 1e-4, 1e-3};
    return one_of(r, NOISE, 12);
}

static quat nearly(random_state *r, quat q)
{
    vec3 turn = vec_scale(below(r, 2) ? random_direction(r) : vec(1, 0, 0), little(r));
    return quat_unit(quat_mul(q, (quat){1, turn.x, turn.y, turn.z}));
}

static double side(random_state *r)
{
    return (double)below(r, 3) - 1;
}

/* A feature of the shape, or the middle of one, in its own frame: corner, edge, face, rim, apex, centre; and sometimes
 * a half or thrice of that. */
static vec3 feature(random_state *r, const shape *s)
{
    static const double TURNS[][2] = {{1, 0}, {0, 1}, {-1, 0}, {0, -1}, {0.6, 0.8}, {-0.8, 0.6}, {0.28, -0.96}};
    static const double FAR[] = {0.5, 3, 1.5, 2};
    vec3 h = s->half, at = vec(side(r) * h.x, side(r) * h.y, side(r) * h.z);
    const double *turn = TURNS[below(r, 7)];
    bool apex = below(r, 3) == 0;
    if (s->type == SHAPE_CYLINDER || s->type == SHAPE_CONE) {
        double out = (double)below(r, 2) * h.x;
        if (s->type == SHAPE_CONE) at.z = apex ? h.z : -h.z, out = apex ? 0 : out;
        if (s->type == SHAPE_CONE && below(r, 4) == 0) at.z = 0, out = 0.5 * h.x; /* on its side */
        at = vec(turn[0] * out, turn[1] * out, at.z);
    } else if (s->type == SHAPE_HULL) {
        uint32_t i = (uint32_t)below(r, s->hull->vertex_count), k = (uint32_t)below(r, s->hull->vertex_count);
        at = vec_scale(vec_add(hull_vertex(s->hull, i), hull_vertex(s->hull, k)), 0.5);
    } else if (s->type == SHAPE_HALFSPACE) {
        at = vec(side(r), side(r), 0);
    }
    if (below(r, 6) == 0) at = vec_scale(at, one_of(r, FAR, 4));
    if (below(r, 6) == 0) at.z *= one_of(r, FAR, 4);
    return below(r, 8) ? at : VEC_ZERO;
}

/* From the feature of one to that of the other: nothing, the radii, a little, or a way along an axis. */
static vec3 offset(random_state *r, const hostile *c)
{
    static const double WAYS[] = {1, 0.5, 0.25, 3, 0.125, 1e-3};
    vec3 axes[3] = {vec(1, 0, 0), vec(0, 1, 0), vec(0, 0, 1)}, along = axes[below(r, 3)];
    if (below(r, 4) == 0) along = random_direction(r);
    if (below(r, 4) == 0) along = vec_unit(vec(side(r), side(r), side(r)));
    double by = below(r, 2) ? 1 : -1;
    switch (below(r, 6)) {
    case 0:
        return vec_scale(along, by * (c->a.radius + c->b.radius));
    case 1:
        return vec_scale(along, by * little(r));
    case 2:
        return vec_scale(along, by * one_of(r, WAYS, 6));
    case 3:
        return vec_scale(along, by * (c->a.radius + c->b.radius + little(r)));
    default:
        return VEC_ZERO;
    }
}

static hostile draw(shape_type ta, shape_type tb, uint64_t i)
{
    random_state r = {((uint64_t)ta << 52) + ((uint64_t)tb << 48) + i};
    hostile c = {.at_a = POSE_IDENTITY, .at_b = POSE_IDENTITY};
    c.a = hostile_shape(&r, ta, &c.hull_a);
    c.b = hostile_shape(&r, tb, &c.hull_b);
    if (ta == tb && below(&r, 4) == 0) c.b = c.a, c.hull_b = c.hull_a;
    if (below(&r, 4) == 0 && ta != SHAPE_HULL && tb != SHAPE_HULL) c.b.half.z = c.a.half.z;
    if (tb == SHAPE_SPHERE || tb == SHAPE_HALFSPACE) c.b.half = VEC_ZERO;
    if (!narrow_ordered(&c.a, 0, &c.b, 1)) {
        shape a = c.a;
        unsigned hull_a = c.hull_a;
        c.a = c.b, c.hull_a = c.hull_b, c.b = a, c.hull_b = hull_a;
    }
    if (below(&r, 3) == 0) {
        c.at_a.q = hostile_rotation(&r);
        c.at_a.p = vec(side(&r), 0.3 * side(&r), 7 * side(&r));
    }
    c.at_b.q = hostile_rotation(&r);
    if (below(&r, 4) == 0) c.at_b.q = c.at_a.q;
    if (below(&r, 4) == 0) c.at_b.q = nearly(&r, c.at_b.q);
    vec3 on_a = feature(&r, &c.a), on_b = below(&r, 2) ? feature(&r, &c.b) : VEC_ZERO, by = offset(&r, &c);
    if (below(&r, 2)) by = quat_rotate(c.at_b.q, by);
    c.at_b.p = vec_sub(vec_add(pose_point(c.at_a, on_a), by), quat_rotate(c.at_b.q, on_b));
    return c;
}

/* B is moved until they touch, or but for a little: along the axis that proves how far they are from that. */
static void bring_together(hostile *c, uint64_t i)
{
    random_state r = {~i};
    narrow_request request = measure_exactly();
    narrow_result x;
    narrow_query_world(&c->a, c->at_a, &c->b, c->at_b, &request, case_scratch(), &x);
    static const double BY[] = {0, 0, 1, -1};
    c->at_b.p = vec_madd(c->at_b.p, one_of(&r, BY, 4) * little(&r) - x.lo, x.axis);
    c->touching = true;
}

/* ---- what is held ---- */

typedef struct question {
    const hostile *c;
    placed a, b;
    double size;
    const char *asked;
    bool looked;
    narrow_result last;
} question;

static void print_shape(char *text, size_t size, const char *name, const shape *s, unsigned which)
{
    snprintf(text, size, "shape %s = {.type = %d /* %s */, .radius = %a, .half = {%a, %a, %a}}; /* hull %u */\n  ",
        name, (int)s->type, shape_type_name(s->type), s->radius, s->half.x, s->half.y, s->half.z, which);
}

static void print_pose(char *text, size_t size, const char *name, pose p)
{
    snprintf(text, size, "pose %s = {{%a, %a, %a}, {%a, %a, %a, %a}};\n  ", name, p.p.x, p.p.y, p.p.z, p.q.w, p.q.x,
        p.q.y, p.q.z);
}

static void report(const question *x, const char *kind, const narrow_result *r, double by)
{
    char text[2048];
    size_t end =
        (size_t)snprintf(text, sizeof text, "%s-%s, %s: [%.17g, %.17g], axis (%g, %g, %g), %s%s by %s; off by %g\n  ",
            shape_type_name(x->c->a.type), shape_type_name(x->c->b.type), x->asked, r->lo, r->hi, r->axis.x, r->axis.y,
            r->axis.z, r->status == NARROW_CERTAIN ? "certain" : "wide", r->refined ? ", refined," : "",
            narrow_method_name(r->method), by);
    print_shape(text + end, sizeof text - end, "a", &x->c->a, x->c->hull_a), end += strlen(text + end);
    print_shape(text + end, sizeof text - end, "b", &x->c->b, x->c->hull_b), end += strlen(text + end);
    print_pose(text + end, sizeof text - end, "at_a", x->c->at_a), end += strlen(text + end);
    print_pose(text + end, sizeof text - end, "at_b", x->c->at_b);
    found(kind, text);
}

static bool is_plane(const shape *s)
{
    return s->type == SHAPE_HALFSPACE;
}

static void compare(const question *x, const narrow_result *r, const narrow_result *general, double rounded)
{
    comparisons++;
    if (r->lo <= general->hi + rounded && general->lo <= r->hi + rounded) return;
    disjoint++;
    report(x, "not what the general method finds", r, r->lo > general->hi ? r->lo - general->hi : r->hi - general->lo);
}

static bool same_answer(const narrow_result *x, const narrow_result *y)
{
    return memcmp(&x->lo, &y->lo, offsetof(narrow_result, manifold)) == 0 && x->refined == y->refined;
}

/* `rounded`: of a refined answer about a relative pose that was rounded. An answer that was looked at is not again.
 * That shapes touch is known, for a verdict, without points: these are as near as rounding has it. */
static void check_proof(question *x, const narrow_result *r, bool measured, double rounded)
{
    if (x->looked && same_answer(&x->last, r)) return;
    x->looked = true;
    x->last = *r;
    if (!(r->lo <= r->hi)) report(x, "lo above hi", r, r->lo - r->hi);
    if (!(fabs(vec_norm(r->axis) - 1) <= 16 * 0x1p-53)) {
        report(x, "the axis is not unit", r, vec_norm(r->axis) - 1);
        return;
    }
    double proved = (double)(oracle_separation(&x->a, &x->b, real3_of(r->axis)) - (real)r->lo);
    if (!(proved >= -rounded)) report(x, "the axis does not prove lo", r, proved);
    double slack = 256 * 0x1p-53 * x->size;
    if (r->refined) slack = 1e-9 * x->size; /* the points are those of doubles, drawn together */
    double out_a = (double)oracle_outside(&x->a, r->point_a), out_b = (double)oracle_outside(&x->b, r->point_b);
    if (!(out_a <= slack)) report(x, "the point of A is outside", r, out_a);
    if (!(out_b <= slack)) report(x, "the point of B is outside", r, out_b);
    real3 line = real3_sub(real3_of(r->point_b), real3_of(r->point_a));
    double length = (double)(real_sqrt(real3_dot(line, line)) - (real)r->hi), loose = (r->hi - r->lo) + 8e-9 * x->size;
    double deep = (double)real3_dot(line, real3_of(r->axis)) - r->hi;
    double apart = rounded + (measured || r->lo > 0x1p-46 * x->size ? 0x1p-100 : 0x1p-46) * x->size;
    if (r->lo > 0 && !(length <= apart)) report(x, "the points do not prove hi", r, length);
    if (r->lo <= 0 && !(deep <= loose)) report(x, "the points are not the deepest", r, deep);
}

static bool decided(const narrow_result *r, double threshold)
{
    return r->lo > threshold || r->hi <= threshold;
}

static void check_status(const question *x, const narrow_result *r, const narrow_request *request)
{
    if (r->status != NARROW_CERTAIN) return;
    double asked = (request->tolerance > 0 ? request->tolerance : 2.1e-12 * x->size) + 0x1p-50 * x->size;
    double width = r->hi - r->lo;
    bool measured = width <= asked || r->lo > request->range, verdict = request->facts & NARROW_VERDICT;
    if ((request->facts & NARROW_DISTANCE) && !measured) report(x, "certain, but wider than asked", r, width);
    if (verdict && !decided(r, request->threshold) && !(width <= asked))
        report(x, "certain, but undecided", r, request->threshold);
}

/* Of a contact: points, none of them farther apart than the axis proves, and those of features at both shapes (edges
 * that are nearly parallel may pass beside each other). */
static void check_manifold(const question *x, const narrow_result *r, double threshold)
{
    uint32_t count = r->manifold.count;
    if (count > MANIFOLD_POINTS_MAX || (count == 0 && r->lo <= threshold) || (count > 0 && r->lo > threshold))
        report(x, "points of contact, or none, against the distance", r, count);
    for (uint32_t i = 0; i < count && count <= MANIFOLD_POINTS_MAX; i++) {
        const manifold_point *m = &r->manifold.points[i];
        if (!vec_finite(m->point) || !isfinite(m->distance)) report(x, "a point of contact is no number", r, 0);
        double far = r->lo - 8e-9 * x->size - m->distance; /* faces of hulls are planes but for 1e-9 */
        if (far > 0) report(x, "a point of contact is deeper than the depth", r, far);
        if (m->feature == feature_witness()) continue;
        double room = 0.02 * x->size + fabs(m->distance);
        double aside = (double)oracle_outside(&x->a, m->point), aside_b = (double)oracle_outside(&x->b, m->point);
        if (!(fmax(aside, aside_b) <= room)) report(x, "a point of contact is off the shapes", r, fmax(aside, aside_b));
    }
}

static bool same_vec(vec3 x, vec3 y)
{
    return x.x == y.x && x.y == y.y && x.z == y.z;
}

/* The origins of the two answers are at different shapes, and their points are rounded there. */
static void check_swapped(const question *x, const narrow_result *r, const narrow_result *q)
{
    vec3 way = vec_sub(x->c->at_b.p, x->c->at_a.p);
    double off = fmax(vec_norm(vec_sub(vec_add(q->point_b, way), r->point_a)),
        vec_norm(vec_sub(vec_add(q->point_a, way), r->point_b)));
    if (!(off <= 1e-14 * x->size)) report(x, "the points of the swapped pair are others", r, off);
    bool same = q->lo == r->lo && q->hi == r->hi && q->status == r->status && q->method == r->method;
    if (!same || !same_vec(vec_neg(q->axis), r->axis))
        report(x, "the swapped pair says something else", r, q->lo - r->lo);
}

/* ---- what is asked ---- */

static question question_of(const hostile *c, const char *asked, pose at_a, pose at_b)
{
    question x = {
        .c = c, .asked = asked, .a = oracle_place(&c->a, at_a, at_a.p), .b = oracle_place(&c->b, at_b, at_a.p)};
    double away = vec_norm(vec_sub(at_b.p, at_a.p)),
           reach_a = is_plane(&c->a) ? away + c->a.radius : shape_reach(&c->a),
           reach_b = is_plane(&c->b) ? away + c->b.radius : shape_reach(&c->b);
    x.size = reach_a + reach_b + away;
    return x;
}

/* By the general method; or of a half-space, and what is above it, the separation along its normal. */
static narrow_result second_way(question *x, const pose *b_in_a, uint64_t i)
{
    static const double FINENESS[] = {1e-9, 1e-3, 1e-6, 1e-4, 1e-2, 1e-3, 1e-5, 1e-3}; /* by the general method dear */
    narrow_request request = {.facts = NARROW_DISTANCE,
        .tolerance = (x->c->touching ? 1e-9 : FINENESS[i % 8]) * x->size,
        .range = INFINITY,
        .engine = NARROW_ENGINE_GJK};
    const hostile *c = x->c;
    narrow_result r;
    if (!is_plane(&c->a) && !is_plane(&c->b)) {
        if (b_in_a)
            narrow_query(&c->a, &c->b, b_in_a, &request, NULL, case_scratch(), &r);
        else
            narrow_query_world(&c->a, c->at_a, &c->b, c->at_b, &request, case_scratch(), &r);
        check_proof(x, &r, true, 0);
        return r;
    }
    real3 normal = is_plane(&c->a) ? x->a.rz : real3_scale(x->b.rz, -1);
    double truth = (double)oracle_separation(&x->a, &x->b, normal);
    r = (narrow_result){.lo = truth - 0x1p-52 * fabs(truth), .hi = truth + 0x1p-52 * fabs(truth)};
    return r;
}

static const double TOLERANCES[] = {1e-9, 0, 1e-6, 1e-3, 1e-12, 0.03};

static double threshold_of(uint64_t i, const narrow_result *general)
{
    const double thresholds[] = {0, general->lo, general->hi, 0.125, general->lo - 0.01, general->hi + 0.01};
    return thresholds[i % 6];
}

/* One answer of AUTO. */
static void check_answer(
    question *x, const narrow_request *request, const narrow_result *r, const narrow_result *general, double rounded)
{
    compare(x, r, general, rounded);
    check_proof(x, r, request->facts & NARROW_DISTANCE, rounded);
    check_status(x, r, request);
    if (request->facts & NARROW_MANIFOLD) check_manifold(x, r, request->threshold);
}

/* What a pair remembers of another place changes no bit. */
static void check_cached(question *x, const pose *b_in_a, const narrow_request *request, const narrow_result *r)
{
    pose elsewhere = {vec_madd(b_in_a->p, 0.01, vec(1, 2, -3)), quat_unit(quat_mul(b_in_a->q, (quat){1, 0.01, 0, 0}))};
    narrow_cache cache = {.lower = 0};
    narrow_result kept;
    narrow_query(&x->c->a, &x->c->b, &elsewhere, request, &cache, case_scratch(), &kept);
    narrow_query(&x->c->a, &x->c->b, b_in_a, request, &cache, case_scratch(), &kept);
    if (!same_answer(r, &kept)) report(x, "what is remembered changes it", &kept, kept.lo - r->lo);
}

/* About the relative pose as it is rounded. */
static narrow_result check_relative(const hostile *c, uint64_t i)
{
    pose b_in_a = pose_relative(c->at_a, c->at_b);
    question x = question_of(c, "distance", POSE_IDENTITY, b_in_a);
    narrow_result general = second_way(&x, &b_in_a, i), r;
    narrow_request request = {.facts = NARROW_DISTANCE, .range = INFINITY};
    for (uint64_t k = 0; k < 2; k++) {
        request.tolerance = TOLERANCES[(i + 3 * k) % 6] * x.size;
        narrow_query(&c->a, &c->b, &b_in_a, &request, NULL, case_scratch(), &r);
        check_answer(&x, &request, &r, &general, 0);
    }
    if (i % 2) check_cached(&x, &b_in_a, &request, &r);
    x.asked = "verdict";
    for (uint64_t k = 0; k < 3; k++) {
        request.facts = (i + k) % 4 ? NARROW_VERDICT : NARROW_DISTANCE | NARROW_VERDICT;
        request.threshold = threshold_of(i / 2 + k, &general);
        narrow_query(&c->a, &c->b, &b_in_a, &request, NULL, case_scratch(), &r);
        check_answer(&x, &request, &r, &general, 0);
    }
    if (i % 8 == 0) { /* libccd, which proposes what our proof then decides */
        x.asked = "peer";
        request.facts = NARROW_DISTANCE;
        request.engine = i % 16 ? NARROW_ENGINE_CCD : NARROW_ENGINE_MPR;
        narrow_query(&c->a, &c->b, &b_in_a, &request, NULL, case_scratch(), &r);
        check_answer(&x, &request, &r, &general, 0);
        request.engine = NARROW_ENGINE_AUTO;
    }
    x.asked = "manifold";
    request.facts = i % 3 ? NARROW_MANIFOLD : NARROW_DISTANCE | NARROW_MANIFOLD;
    request.threshold = i % 2 ? 0.05 : 0;
    narrow_query(&c->a, &c->b, &b_in_a, &request, NULL, case_scratch(), &r);
    check_answer(&x, &request, &r, &general, 0);
    return general;
}

static bool is_identity(pose p)
{
    return same_vec(p.p, VEC_ZERO) && p.q.w == 1 && p.q.x == 0 && p.q.y == 0 && p.q.z == 0;
}

static bool same_place(const hostile *c)
{
    const quat *q = &c->at_a.q, *s = &c->at_b.q;
    return same_vec(c->at_a.p, c->at_b.p) && q->w == s->w && q->x == s->x && q->y == s->y && q->z == s->z;
}

/* About the poses in the world: A's may be the frame of the relative pose, of which `general` is known. */
static void check_world(const hostile *c, uint64_t i, narrow_result general)
{
    question x = question_of(c, "world", c->at_a, c->at_b);
    narrow_result r, swapped;
    if (!is_identity(c->at_a)) general = second_way(&x, NULL, i);
    narrow_request request = {.facts = NARROW_DISTANCE, .tolerance = TOLERANCES[i / 6 % 6] * x.size, .range = INFINITY};
    narrow_query_world(&c->a, c->at_a, &c->b, c->at_b, &request, case_scratch(), &r);
    check_answer(&x, &request, &r, &general, 0);
    narrow_query_world(&c->b, c->at_b, &c->a, c->at_a, &request, case_scratch(), &swapped);
    if (!same_place(c)) check_swapped(&x, &r, &swapped);

    x.asked = "placed";
    for (uint64_t k = 0; k < 2; k++) {
        if (k == 1) request.facts = NARROW_VERDICT, request.threshold = threshold_of(i / 3, &general);
        query_where_they_stand(&c->a, c->at_a, &c->b, c->at_b, &request, NULL, &r);
        double rounded = r.refined && !is_identity(c->at_a) ? 0x1p-50 * x.size : 0;
        check_answer(&x, &request, &r, &general, rounded);
    }
}

static void check_case(const hostile *c, uint64_t i)
{
    narrow_result general = check_relative(c, i);
    check_world(c, i, general);
}

/* ---- what was wrong once ---- */

enum { EACH_WAY = 144 }; /* as many kinds of requests as check_case has */

/* From either side, in many ways, and the truth is in it. */
static void check_known(hostile c, double truth, double slack)
{
    if (!narrow_ordered(&c.a, 0, &c.b, 1)) c = (hostile){.a = c.b, .b = c.a, .at_a = c.at_b, .at_b = c.at_a};
    narrow_request request = measure_exactly();
    narrow_result r;
    narrow_query_world(&c.a, c.at_a, &c.b, c.at_b, &request, case_scratch(), &r);
    if (!(fabs(r.lo - truth) <= slack && fabs(r.hi - truth) <= slack)) {
        question x = question_of(&c, "known", c.at_a, c.at_b);
        report(&x, "not the truth", &r, truth);
    }
    for (uint64_t i = 0; i < EACH_WAY; i++) check_case(&c, i);
}

static shape ball(double radius)
{
    return (shape){.type = SHAPE_SPHERE, .radius = radius};
}

static shape revolved(shape_type type, double r, double h, double rounding)
{
    return (shape){.type = type, .radius = rounding, .half = {r, r, h}};
}

static pose placed_at(double x, double y, double z)
{
    return (pose){{x, y, z}, {1, 0, 0, 0}};
}

/* No edge of a disc's profile has a line that a point of its plane is above: it was taken to be in contact. */
static void a_ball_in_the_plane_of_a_disc_is_as_far_from_it_as_its_rim(void **state)
{
    (void)state;
    for (int k = 0; k < 4; k++) {
        shape disc = revolved(k % 2 ? SHAPE_CONE : SHAPE_CYLINDER, 1, 0, k < 2 ? 0.05 : 0);
        check_known((hostile){.a = ball(0.1), .b = disc, .at_a = placed_at(3, 0, 0), .at_b = POSE_IDENTITY},
            1.9 - disc.radius, 1e-14);
        pose upright = {{0, 0, 1.25}, quat_unit((quat){1, 1, 0, 0})};
        check_known((hostile){.a = ball(0.125), .b = disc, .at_a = placed_at(-1.5, 0, 1.25), .at_b = upright},
            0.375 - disc.radius, 1e-14);
    }
    assert_nothing_found();
}

/* So are discs and rods that are so thin that the square of that is no number. */
static void a_ball_beside_what_has_next_to_no_thickness_is_apart(void **state)
{
    (void)state;
    for (int k = 0; k < 2; k++) {
        shape_type type = k ? SHAPE_CONE : SHAPE_CYLINDER;
        hostile disc = {.a = ball(0.1), .b = revolved(type, 1, 1e-170, 0), .at_a = placed_at(3, 0, 0)};
        hostile rod = {.a = ball(0.1), .b = revolved(type, 1e-170, 1, 0), .at_a = placed_at(0, 0, 3)};
        disc.at_b = rod.at_b = POSE_IDENTITY;
        check_known(disc, 1.9, 1e-14);
        check_known(rod, 1.9, 1e-14);
        rod.at_a = placed_at(0, 3, 0.5);
        check_known(rod, 2.9, 1e-14);
    }
    /* The way out of a box, by which a centre is outside of it, had no length, and was taken for a part of an axis. */
    hostile box = {.a = ball(1e-6), .b = {.type = SHAPE_BOX, .half = {1e-170, 1e-170, 1e-170}}, .at_a = POSE_IDENTITY};
    box.at_b = (pose){{-0x1.9c37a35177e3ep-564, 0x1.9c37a35177e3fp-566, -0x1.9c37a35177e3cp-566},
        {0x1.a20bd700c2c3fp-2, 0x1.a20bd700c2c3fp-1, 0, 0x1.a20bd700c2c3fp-2}};
    check_known(box, -1e-6, 1e-20);
    assert_nothing_found();
}

/* The same, of the largest ball in a cone, whose centre is in the plane of a disc that touches the cone: the depth told
 * was up to 3e-3 of the size too great. */
static void a_disc_that_touches_a_cone_is_not_in_it(void **state)
{
    (void)state;
    const hostile touching[] = {
        {.a = revolved(SHAPE_CYLINDER, 0x1.8p-1, 0, 0),
            .b = revolved(SHAPE_CONE, 0x1.8p-1, 0x1.085e166c0ab66p-8, 0),
            .at_a = POSE_IDENTITY,
            .at_b = {{-0x1.b5e23c4a52683p-1, -0x1.88e644868beecp-3, 0x1.5e61ef037ba8p-9}, {0, 1, 0, 0}}},
        {.a = revolved(SHAPE_CYLINDER, 1, 0, 0),
            .b = revolved(SHAPE_CONE, 0x1.3333333333333p-2, 1, 0),
            .at_a = POSE_IDENTITY,
            .at_b = {{-0x1.6d49d51c017f3p-1, 0x1.f05a17d1916e7p-1, -0x1.6e65e4b09e944p-2}, {0, 1, 0, 0}}},
        {.a = revolved(SHAPE_CONE, 0x1.16f3161de57aep-1, 0, 0),
            .b = revolved(SHAPE_CONE, 0x1.fe9c1290ac179p-1, 0x1.03ea91ffcfbaep-1, 0),
            .at_a = POSE_IDENTITY,
            .at_b = {{-0x1.560cbbbfbd986p-2, -0x1.62189401bb517p-1, 0x1.1f2242ad1752ap-2}, {0, 0, 1, 0}}},
    };
    for (int k = 0; k < 3; k++) check_known(touching[k], 0, 1e-13);
    assert_nothing_found();
}

/* Where a corner of the box is the centre, all directions of a circle are alike: the axis told was zero. */
static void a_cylinder_about_a_corner_of_a_box_is_as_deep_as_its_radius(void **state)
{
    (void)state;
    shape box = {.type = SHAPE_BOX, .half = {0.5, 0.5, 0.5}};
    hostile c = {.a = box, .b = revolved(SHAPE_CYLINDER, 0.3, 0.4, 0), .at_a = POSE_IDENTITY};
    for (int k = 0; k < 8; k++) { /* of two corners the side of the cylinder is turned away */
        double truth = k == 2 || k == 5 ? -0.34961098046064471 : -0.3;
        c.at_b = (pose){{k & 1 ? 0.5 : -0.5, k & 2 ? 0.5 : -0.5, k & 4 ? 0.5 : -0.5}, quat_unit((quat){2, 1, 3, -3})};
        check_known(c, truth, 1e-12);
    }
    assert_nothing_found();
}

/* The way from a rim to a centre that is on it is rounding, and no normal of the rim: it proved nothing, by the length
 * of the cone. */
static void a_ball_on_a_rim_is_told_along_a_normal_of_it(void **state)
{
    (void)state;
    hostile c = {.a = ball(0.125), .b = revolved(SHAPE_CONE, 1000, 1000, 0), .at_a = POSE_IDENTITY};
    c.at_b = (pose){{0x1.e000000000008p+6, 0x1.8ffffffffffffp+9, 0x1.22p+10},
        {0x1.999999999999ap-1, -0x1.999999999999ap-2, -0x1.999999999999ap-2, -0x1.999999999999ap-3}};
    check_known(c, -0.125, 1e-11);
    assert_nothing_found();
}

/* What lies over the tip of a sliver to within the width of its other end was taken to lie over it, however far beyond
 * the tip that was: half a metre. */
static void a_needle_has_no_contact_beyond_its_tip(void **state)
{
    (void)state;
    hostile c = {.a = revolved(SHAPE_CONE, 0x1.0624dd2f1a9fcp-10, 0x1.999999999999ap-2, 0),
        .b = {.type = SHAPE_HULL, .hull = hulls[4]},
        .hull_b = 4,
        .at_a = POSE_IDENTITY,
        .at_b = {{0, 0, 0x1.3333333335663p-1}, {0, 0, 1, 0}}};
    for (uint64_t i = 0; i < EACH_WAY; i++) check_case(&c, i);
    assert_nothing_found();
}

static uint64_t cases_each(void)
{
    const char *chosen = getenv("COLLIDED_TWO_WAYS"); /* of each pair, for a longer look by hand */
    if (chosen) return strtoull(chosen, NULL, 10);
    return getenv("COLLIDED_NIGHTLY") ? CASES_NIGHTLY : getenv("COLLIDED_BRIEF") ? CASES_BRIEF : CASES_EACH;
}

static void the_two_ways_agree(shape_type ta, shape_type tb)
{
    for (uint64_t i = 0, n = cases_each(); i < n; i++) {
        hostile c = draw(ta, tb, i);
        if (i % 3 == 2) bring_together(&c, i);
        check_case(&c, i);
    }
}

static void each_pair_of_types_agrees_with_the_general_method(void **state)
{
    (void)state;
    for (int ta = 0; ta < SHAPE_CONVEX_COUNT; ta++)
        for (int tb = ta; tb < SHAPE_CONVEX_COUNT; tb++)
            if (ta != SHAPE_HALFSPACE || tb != SHAPE_HALFSPACE) the_two_ways_agree((shape_type)ta, (shape_type)tb);
    print_message("%zu comparisons, %zu disjoint\n", comparisons, disjoint);
    assert_nothing_found();
}

static int create(void **state)
{
    (void)state;
    create_hulls();
    return 0;
}

static int destroy(void **state)
{
    (void)state;
    for (int i = 0; i < HULLS; i++) hull_destroy(hulls[i]);
    return 0;
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_ball_in_the_plane_of_a_disc_is_as_far_from_it_as_its_rim),
        cmocka_unit_test(a_ball_beside_what_has_next_to_no_thickness_is_apart),
        cmocka_unit_test(a_disc_that_touches_a_cone_is_not_in_it),
        cmocka_unit_test(a_cylinder_about_a_corner_of_a_box_is_as_deep_as_its_radius),
        cmocka_unit_test(a_ball_on_a_rim_is_told_along_a_normal_of_it),
        cmocka_unit_test(a_needle_has_no_contact_beyond_its_tip),
        cmocka_unit_test(each_pair_of_types_agrees_with_the_general_method),
    };
    return cmocka_run_group_tests(tests, create, destroy);
}
