/* judge: one pair, one answer, every property that a single answer must have. */
#include "judge.h"

#include <stdlib.h>

static narrow_scratch *scratch(void)
{
    static _Alignas(64) unsigned char memory[1 << 21]; /* one thread */
    if (narrow_scratch_size() > sizeof memory) abort();
    return (narrow_scratch *)(void *)memory;
}

void ask(const subject *a, const subject *b, narrow_result *result)
{
    const narrow_request request = {.facts = NARROW_DISTANCE, .range = INFINITY};
    narrow_query_world(&a->shape, a->pose, &b->shape, b->pose, &request, scratch(), result);
}

static void put(double out[3], vec3 v)
{
    out[0] = v.x, out[1] = v.y, out[2] = v.z;
}

const char *check_certificate(const subject *a, const subject *b, const narrow_result *result, double slack_m)
{
    oracle_claim claim = {.lo = result->lo, .hi = result->hi, .origin = a->exact.position};
    put(claim.axis, result->axis);
    put(claim.point_a, result->point_a);
    put(claim.point_b, result->point_b);
    return oracle_check(&a->exact, &b->exact, &claim, slack_m);
}

static bool same(vec3 a, vec3 b)
{
    return a.x == b.x && a.y == b.y && a.z == b.z;
}

static bool same_points(const subject *a, const subject *b)
{
    if (a->exact.count != b->exact.count) return false;
    for (size_t i = 0; i < a->exact.count; i++)
        if (q_norm(q_sub(a->exact.points[i], b->exact.points[i])) > 0) return false;
    return true;
}

/* The same body twice, in one place: swapping changes nothing, so nothing can turn round. */
static bool identical(const subject *a, const subject *b)
{
    return a->shape.type == b->shape.type && a->shape.radius == b->shape.radius && same(a->shape.half, b->shape.half) &&
           same(a->pose.p, b->pose.p) && a->pose.q.w == b->pose.q.w && a->pose.q.x == b->pose.q.x &&
           a->pose.q.y == b->pose.q.y && a->pose.q.z == b->pose.q.z && same_points(a, b);
}

/* (A, B) and (B, A): the same interval and the opposite axis to the bit; the points up to the change of origin. */
static const char *check_swap(const subject *a, const subject *b, const narrow_result *result, double slack_m)
{
    narrow_result swapped;
    ask(b, a, &swapped);
    if (swapped.lo != result->lo || swapped.hi != result->hi) return "swapped, the interval differs";
    if (identical(a, b)) return NULL;
    if (!same(vec_neg(swapped.axis), result->axis)) return "swapped, the axis is not the opposite";
    vec3 shift = vec_sub(b->pose.p, a->pose.p);
    vec3 da = vec_sub(vec_add(swapped.point_b, shift), result->point_a);
    vec3 db = vec_sub(vec_add(swapped.point_a, shift), result->point_b);
    if (fmax(vec_max_abs(da), vec_max_abs(db)) > slack_m) return "swapped, the points differ";
    return NULL;
}

static const char *check_again(const subject *a, const subject *b, const narrow_result *result)
{
    narrow_result again;
    ask(a, b, &again);
    bool equal = again.lo == result->lo && again.hi == result->hi && same(again.axis, result->axis) &&
                 same(again.point_a, result->point_a) && same(again.point_b, result->point_b);
    return equal ? NULL : "asked again, the answer differs";
}

/* An axis within 1e-6 rad of one that was expected. */
static bool axis_expected(const narrow_result *result, const expectation *expected)
{
    for (size_t i = 0; i < expected->normal_count; i++) {
        const double *n = expected->normals[i];
        if (vec_norm(vec_cross(result->axis, vec(n[0], n[1], n[2]))) <= 1e-6 &&
            vec_dot(result->axis, vec(n[0], n[1], n[2])) > 0)
            return true;
    }
    return expected->normal_count == 0;
}

static const char *check_expected(const narrow_result *r, const expectation *expected, double tolerance)
{
    if (expected->measured && expected->distance < r->lo - tolerance) return "lo is above the expected distance";
    if (expected->measured && expected->distance > r->hi + tolerance) return "hi is below the expected distance";
    if (expected->state == STATE_APART && r->hi <= 0) return "apart, and said to overlap";
    if (expected->state == STATE_OVERLAPPING && r->lo > 0) return "overlapping, and said to be apart";
    if (expected->state == STATE_TOUCHING && (r->lo > tolerance || r->hi < -tolerance)) return "touching, and not said";
    if (!axis_expected(r, expected)) return "the axis is not the expected one";
    return NULL;
}

static bool undecided(const narrow_result *r, expected_state state)
{
    return (state == STATE_APART && r->lo <= 0) || (state == STATE_OVERLAPPING && r->hi >= 0);
}

static bool flat_kind(const subject *s)
{
    return s->exact.core == ORACLE_POINTS || s->exact.core == ORACLE_HALFSPACE;
}

double widest_allowed(const subject *a, const subject *b, const narrow_result *result)
{
    if (flat_kind(a) && flat_kind(b)) return WIDTH_EXACT;
    return result->status == NARROW_WIDE && result->hi < 0 ? WIDTH_SAID : WIDTH_CURVED;
}

static const char *check_truth(const subject *a, const subject *b, const judgement *j)
{
    const narrow_result *r = &j->result;
    if (!(r->lo <= r->hi)) return "lo > hi, or not a number";
    if (!(r->lo <= j->truth.hi)) return "lo is above the true distance";
    if (!(r->hi >= j->truth.lo)) return "hi is below the true distance";
    if (r->hi - r->lo > widest_allowed(a, b, r) * j->size) return "the interval is too wide";
    return NULL;
}

judgement judge(const subject *a, const subject *b, const expectation *expected)
{
    judgement j = {.size = (double)oracle_size(&a->exact, &b->exact), .exact_kind = flat_kind(a) && flat_kind(b)};
    double deviation = subject_deviation(a) + subject_deviation(b);
    double tolerance = expected->tolerance + 2 * deviation;
    ask(a, b, &j.result);
    double slack_m = 1e-14 * j.size + 16 * (j.result.hi - j.result.lo);
    j.truth = oracle_distance(&a->exact, &b->exact);
    oracle_truth as_given = deviation > 0 ? oracle_distance(&a->given, &b->given) : j.truth;
    expectation told = *expected;
    /* any axis is a proof from below; the search that found it need not be believed */
    j.disproved = told.measured && oracle_separation(&a->given, &b->given, as_given.axis) > told.distance + tolerance;
    if (j.disproved) told = (expectation){.measured = false};
    j.undecided = undecided(&j.result, told.state);

    const char *faults[] = {check_truth(a, b, &j), check_expected(&j.result, &told, tolerance),
        check_certificate(a, b, &j.result, slack_m), check_swap(a, b, &j.result, slack_m),
        check_again(a, b, &j.result)};
    for (size_t i = 0; i < sizeof faults / sizeof *faults && !j.fault; i++) j.fault = faults[i];
    if (!j.fault && told.measured && q_abs(as_given.lo - told.distance) > tolerance)
        j.fault = "the oracle and the source disagree";
    if (!j.fault && j.undecided && fabs(told.distance) > WIDTH_EXACT * j.size) j.fault = "undecided";
    return j;
}
