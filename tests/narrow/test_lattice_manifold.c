/* Contacts of pairs on a lattice (tests/narrow/cases.h): of all convex types, at thresholds that such pairs sit on.
 * Each point is in both shapes but for rounding, no nearer along the axis than lo, told once, and the same in the other
 * order and with a cache; boxes face to face have the corners of their common rectangle. */
#include "cases.h"
#include "narrow/contact/manifold.h"
#include "oracle.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>

#include <cmocka.h>

#include "findings.h"
#include "primitive_cases.h"

typedef struct contact {
    pair x;
    uint64_t seed;
    double size, threshold;
    narrow_result r; /* in world axes with its origin at A's */
} contact;

static double reach(const shape *s)
{
    return s->type == SHAPE_HALFSPACE ? 1 : shape_reach(s);
}

static void measure_size(contact *c)
{
    const pair *x = &c->x;
    c->size = reach(&x->a) + reach(&x->b) + vec_norm(vec_sub(x->at_b.p, x->at_a.p));
}

static contact draw(int ta, int tb, int i)
{
    contact c = {
        .seed = ((uint64_t)ta << 40) + ((uint64_t)tb << 32) + (uint64_t)i + (2u << 24), .threshold = i % 2 ? 0 : 0.125};
    random_state r = {c.seed};
    pair *x = &c.x;
    x->a = lattice_shape(&r, (shape_type)ta);
    x->b = lattice_shape(&r, (shape_type)tb);
    put_in_order(x);
    lattice_poses(&r, &x->a, &x->b, &x->at_a, &x->at_b);
    measure_size(&c);
    return c;
}

static narrow_request request_of(const contact *c)
{
    return (narrow_request){.facts = NARROW_DISTANCE | NARROW_MANIFOLD,
        .tolerance = 1e-9 * c->size,
        .range = INFINITY,
        .threshold = c->threshold};
}

static void report(const contact *c, const char *kind, const manifold_point *p, double by)
{
    char text[320];
    const vec3 n = c->r.axis;
    int end =
        snprintf(text, sizeof text, "%s-%s, seed %llu: [%.17g, %.17g] by %s along (%g %g %g), %u points, off by %g",
            shape_type_name(c->x.a.type), shape_type_name(c->x.b.type), (unsigned long long)c->seed, c->r.lo, c->r.hi,
            narrow_method_name(c->r.method), n.x, n.y, n.z, c->r.manifold.count, by);
    if (p)
        snprintf(
            text + end, sizeof text - (size_t)end, "; (%g %g %g) %g", p->point.x, p->point.y, p->point.z, p->distance);
    found(kind, text);
}

static void check_point(const contact *c, const manifold_point *p, const placed *a, const placed *b)
{
    const narrow_result *r = &c->r;
    /* edges side by side touch where they are no farther aside than above each other; deepest points need not be on one
     * line along the axis */
    double slack = 2e-6 * c->size + fabs(p->distance);
    if (!vec_finite(p->point) || !isfinite(p->distance)) {
        report(c, "not a number", p, 0);
        return;
    }
    vec3 on_a = vec_madd(p->point, -0.5 * p->distance, r->axis), on_b = vec_madd(p->point, 0.5 * p->distance, r->axis);
    double out_a = (double)oracle_outside(a, on_a), out_b = (double)oracle_outside(b, on_b);
    if (!(out_a <= slack)) report(c, "a point is not on A", p, out_a);
    if (!(out_b <= slack)) report(c, "a point is not on B", p, out_b);
    /* what lies on a side to within 1e-6 is on it, of faces that lean by up to 0.01 */
    if (!(p->distance >= r->lo - 1e-8 * c->size)) report(c, "nearer than lo", p, p->distance - r->lo);
    if (!(p->distance <= c->threshold + 1e-12 * c->size) && r->manifold.count > 1)
        report(c, "farther than the threshold", p, p->distance - c->threshold);
}

static void check_points(const contact *c)
{
    const pair *x = &c->x;
    const manifold *m = &c->r.manifold;
    placed a = oracle_place(&x->a, x->at_a, x->at_a.p), b = oracle_place(&x->b, x->at_b, x->at_a.p);
    double least = INFINITY;
    if (!(fabs(vec_norm(c->r.axis) - 1) <= 1e-14)) report(c, "the axis is not unit", NULL, 0);
    if (c->r.lo > c->threshold ? m->count : m->count < 1 || m->count > MANIFOLD_POINTS_MAX)
        report(c, "a wrong number of points", NULL, 0);
    for (uint32_t i = 0; i < m->count && i < MANIFOLD_POINTS_MAX; i++) {
        check_point(c, &m->points[i], &a, &b);
        least = fmin(least, m->points[i].distance);
        for (uint32_t k = 0; k < i; k++) {
            vec3 apart = vec_sub(m->points[i].point, m->points[k].point);
            if (m->points[k].feature == m->points[i].feature) report(c, "an id is told twice", &m->points[i], 0);
            if (vec_norm(apart) <= 1e-12 * c->size) report(c, "a point is told twice", &m->points[i], 0);
        }
    }
    if (m->count && c->r.status == NARROW_CERTAIN && !(least <= c->r.hi + 2e-6 * c->size))
        report(c, "none is as deep as hi", NULL, least - c->r.hi);
}

static void check_swapped(const contact *c)
{
    const pair *x = &c->x;
    const narrow_request request = request_of(c);
    narrow_result other;
    if (memcmp(&x->at_a, &x->at_b, sizeof x->at_a) == 0 && x->a.hull) return; /* nothing tells one from the other */
    narrow_query_world(&x->b, x->at_b, &x->a, x->at_a, &request, case_scratch(), &other);
    if (other.manifold.count != c->r.manifold.count) report(c, "swapped: another number of points", NULL, 0);
    vec3 origin = vec_sub(x->at_b.p, x->at_a.p);
    for (uint32_t i = 0; i < c->r.manifold.count && i < other.manifold.count; i++) {
        const manifold_point *p = &c->r.manifold.points[i], *q = &other.manifold.points[i];
        double off = vec_norm(vec_sub(vec_add(origin, q->point), p->point));
        if (p->feature != feature_turned(q->feature)) report(c, "swapped: other ids", p, 0);
        if (p->distance != q->distance || !(off <= 1e-14 * c->size)) report(c, "swapped: elsewhere", p, off);
    }
}

static bool same_manifold(const manifold *x, const manifold *y)
{
    bool same = x->count == y->count;
    for (uint32_t i = 0; same && i < x->count; i++)
        same = memcmp(&x->points[i], &y->points[i], sizeof x->points[i]) == 0;
    return same;
}

static void check_memory(const contact *c, const contact *before)
{
    const pair *x = &c->x;
    const narrow_request request = request_of(c);
    pose is = pose_relative(x->at_a, x->at_b), was = pose_relative(before->x.at_a, before->x.at_b);
    narrow_cache cache = {.lower = 0};
    narrow_result cold, kept;
    memset(&cold, 0, sizeof cold), memset(&kept, 0, sizeof kept);
    narrow_query(&x->a, &x->b, &is, &request, NULL, case_scratch(), &cold);
    narrow_query(&x->a, &x->b, &was, &request, &cache, case_scratch(), &kept);
    for (int times = 0; times < 2; times++) {
        narrow_query(&x->a, &x->b, &is, &request, &cache, case_scratch(), &kept);
        if (!same_manifold(&cold.manifold, &kept.manifold)) report(c, "what it remembers changes it", NULL, times);
    }
}

static void points_are_where_the_shapes_touch(void **state)
{
    (void)state;
    size_t touching = 0;
    cases_create();
    for (int ta = 0; ta < SHAPE_CONVEX_COUNT; ta++)
        for (int tb = ta; tb < SHAPE_CONVEX_COUNT; tb++) {
            contact before = draw(ta, tb, -2);
            for (int i = 0, n = count_of(600); i < n; i++) {
                contact c = draw(ta, tb, i);
                const narrow_request request = request_of(&c);
                narrow_query_world(&c.x.a, c.x.at_a, &c.x.b, c.x.at_b, &request, case_scratch(), &c.r);
                if (isinf(c.r.lo)) continue; /* planes that meet: nothing separates them */
                check_points(&c);
                check_swapped(&c);
                check_memory(&c, &before);
                touching += c.r.manifold.count > 0;
                before = c;
            }
        }
    cases_destroy();
    print_message("%zu touch\n", touching);
    assert_nothing_found();
}

/* ---- face to face ---- */

static double eighths(random_state *r, int least, int most)
{
    return 0.125 * (double)(least + (int)(random_bits(r) % (uint64_t)(most - least + 1)));
}

/* Two boxes along the same axes, turned as a whole: their faces across `along` are `gap` apart and overlap; across the
 * others they are deeper. `corner`: the common rectangle's, seen from A, unturned. */
static bool stack(random_state *r, contact *c, int *along, double *gap, vec3 corner[2])
{
    static const double GAPS[] = {0, 0, -0.0625, 0.0625, 0.125, -0.125};
    vec3 ha = vec(eighths(r, 1, 8), eighths(r, 1, 8), eighths(r, 1, 8));
    vec3 hb = vec(eighths(r, 1, 8), eighths(r, 1, 8), eighths(r, 1, 8)), at, lo, hi;
    double *to = &at.x;
    *along = (int)(random_bits(r) % 3);
    *gap = GAPS[random_bits(r) % 6];
    for (int k = 0; k < 3; k++) {
        double both = (&ha.x)[k] + (&hb.x)[k], side = random_bits(r) % 2 ? 1 : -1;
        to[k] = k == *along ? side * (both + *gap) : random_bits(r) % 3 ? eighths(r, -8, 8) : 0;
        (&lo.x)[k] = fmax(-(&ha.x)[k], to[k] - (&hb.x)[k]);
        (&hi.x)[k] = fmin((&ha.x)[k], to[k] + (&hb.x)[k]);
        if (k != *along && !(both - fabs(to[k]) > fmax(0, -*gap))) return false;
    }
    corner[0] = lo, corner[1] = hi;
    c->x = (pair){.a = {.type = SHAPE_BOX, .half = ha}, .b = {.type = SHAPE_BOX, .half = hb}};
    c->x.at_a = c->x.at_b = POSE_IDENTITY;
    c->x.at_b.p = at;
    measure_size(c);
    return true;
}

/* By `whole`, a quarter of a turn or so: A and B, and what is asked about them. */
static void turn_whole(contact *c, quat whole)
{
    c->x.at_a.q = c->x.at_b.q = whole;
    c->x.at_b.p = quat_rotate(whole, c->x.at_b.p);
}

static void check_corners(const contact *c, int along, double gap, const vec3 corner[2])
{
    const manifold *m = &c->r.manifold;
    if (m->count != 4) report(c, "face to face: not four points", NULL, m->count);
    int here[4] = {0};
    for (uint32_t i = 0; i < m->count; i++) {
        vec3 p = quat_rotate(quat_conj(c->x.at_a.q), m->points[i].point);
        int which = 0;
        for (int k = 0, bit = 1; k < 3; k++) {
            double v = (&p.x)[k], lo = (&corner[0].x)[k], hi = (&corner[1].x)[k];
            if (k == along) {
                if (!(fabs(v - 0.5 * (lo + hi)) <= 1e-14 * c->size)) report(c, "face to face: not between", NULL, v);
                continue;
            }
            which += fabs(v - hi) < fabs(v - lo) ? bit : 0;
            if (!(fmin(fabs(v - hi), fabs(v - lo)) <= 1e-13 * c->size))
                report(c, "face to face: no corner", &m->points[i], fmin(fabs(v - hi), fabs(v - lo)));
            bit *= 2;
        }
        here[which]++;
        if (!(fabs(m->points[i].distance - gap) <= 1e-14 * c->size))
            report(c, "face to face: another distance", &m->points[i], m->points[i].distance - gap);
    }
    for (int k = 0; k < 4 && m->count == 4; k++)
        if (here[k] != 1) report(c, "face to face: a corner twice", NULL, here[k]);
}

static void boxes_face_to_face_have_the_corners_they_share(void **state)
{
    (void)state;
    int asked = 0;
    for (int i = 0, n = count_of(10000); i < n; i++) {
        contact c = {.seed = (uint64_t)i, .threshold = 0.25};
        random_state r = {c.seed};
        vec3 corner[2];
        double gap;
        int along;
        if (!stack(&r, &c, &along, &gap, corner)) continue;
        shape ball = {.type = SHAPE_SPHERE, .radius = 1};
        pose still, turned;
        lattice_poses(&r, &ball, &ball, &still, &turned);
        turn_whole(&c, i % 3 ? turned.q : POSE_IDENTITY.q);
        const narrow_request request = request_of(&c);
        narrow_query_world(&c.x.a, c.x.at_a, &c.x.b, c.x.at_b, &request, case_scratch(), &c.r);
        check_points(&c);
        check_swapped(&c);
        check_corners(&c, along, gap, corner);
        asked++;
    }
    print_message("%d face to face\n", asked);
    assert_nothing_found();
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(points_are_where_the_shapes_touch),
        cmocka_unit_test(boxes_face_to_face_have_the_corners_they_share),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
