/* What the engine tells is proven by the kernel, for all convex shapes, rounded ones and compounds: by shape, which
 * share as it stands, and which when rounding is allowed for. A claim that is a little stronger is refused.
 * collided_verify, the quick checker, says the same. */
#include "cases.h"
#include "check_cases.h"
#include "client/cmocka_c.h"

#include <collided.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

static unsigned pairs_each(void)
{
    return getenv("COLLIDED_NIGHTLY") ? 12500 : getenv("COLLIDED_BRIEF") ? 10 : 120; /* 81 pairs of kinds: 10^6 */
}

static const char *const KINDS[CASE_KINDS] = {
    "sphere", "capsule", "box", "cylinder", "cone", "ellipsoid", "half-space", "hull", "compound"};

static struct tally {
    long claims, lo_exact, lo_allowed, hi_exact, hi_allowed, depths;
} tallies[CASE_KINDS];

static collided_check_status ask(
    const check_case *c, double lo, double hi, double allowed, collided_check_proven *proven)
{
    collided_check_claim claim = c->claim;
    claim.lo = lo, claim.hi = hi;
    return collided_check_distance(&c->a.shape, c->a.pose, &c->b.shape, c->b.pose, &claim, allowed, proven);
}

static void tell(const check_case *c, const char *what)
{
    collided_check_proven p;
    ask(c, c->claim.lo, c->claim.hi, 0, &p);
    fail_msg("%s: kinds %d, %d: [%.17g, %.17g], proven [%.17g, %.17g]", what, (int)c->a.shape.kind,
        (int)c->b.shape.kind, c->claim.lo, c->claim.hi, p.lo, p.hi);
}

static bool is_compound(const check_case *c)
{
    return c->a.shape.child_count || c->b.shape.child_count;
}

/* World coordinates are rounded, too. */
static double allowance(const check_case *c)
{
    double most = 0;
    for (int i = 0; i < 3; i++) most = fmax(most, fmax(fabs(c->a.pose[i]), fabs(c->b.pose[i])));
    return CHECK_ALLOWED * check_size(c) + 0x1p-49 * most;
}

/* Of a compound the axis need not prove lo: the two that are there may lie in each other's hollows. */
static void count(const check_case *c, struct tally *t)
{
    double allowed = allowance(c);
    collided_check_proven p;
    t->claims++;
    bool lo = ask(c, c->claim.lo, INFINITY, allowed, &p) == COLLIDED_CHECK_PROVEN;
    if (!lo && !is_compound(c)) tell(c, "lo is refused");
    t->lo_allowed += lo;
    t->lo_exact += ask(c, c->claim.lo, INFINITY, 0, &p) == COLLIDED_CHECK_PROVEN;
    collided_check_status hi = ask(c, -INFINITY, c->claim.hi, allowed, &p);
    if (c->claim.hi < 0) {
        if (hi != COLLIDED_CHECK_DEPTH_UNPROVEN && hi != COLLIDED_CHECK_PROVEN) tell(c, "depth");
        t->depths++;
        return;
    }
    if (hi != COLLIDED_CHECK_PROVEN) tell(c, "hi is refused");
    t->hi_allowed++;
    t->hi_exact += ask(c, -INFINITY, c->claim.hi, 0, &p) == COLLIDED_CHECK_PROVEN;
}

/* Stronger than what is true by more than what is allowed: nothing can prove it. */
static void refuse_stronger(const check_case *c)
{
    double allowed = allowance(c), more = 2 * allowed + (c->claim.hi - c->claim.lo);
    collided_check_proven p;
    if (ask(c, c->claim.lo + more, INFINITY, 0, &p) != COLLIDED_CHECK_LO_UNPROVEN) tell(c, "more than lo is accepted");
    if (c->claim.hi < 0) return;
    collided_check_status status = ask(c, -INFINITY, c->claim.hi - more, 0, &p);
    if (status != COLLIDED_CHECK_HI_UNPROVEN && status != COLLIDED_CHECK_DEPTH_UNPROVEN)
        tell(c, "less than hi is accepted");
}

/* ---- collided_verify ---- */

static void to_verify(const check_subject *from, const collided_check_shape *s, collided_shape *to)
{
    *to = (collided_shape){.type = (collided_shape_type)s->kind, .radius = s->radius, .deviation = s->deviation};
    memcpy(to->half, s->half, sizeof to->half);
    memcpy(to->pose.position, s->pose, sizeof to->pose.position);
    memcpy(to->pose.orientation, s->pose + 3, sizeof to->pose.orientation);
    (void)from;
}

static bool quick_knows(const check_subject *s)
{
    for (size_t i = 0; i < s->shape.child_count; i++)
        if (s->children[i].kind == COLLIDED_CHECK_HULL) return false;
    return true;
}

static collided_status quick(const check_case *c, double lo, double hi)
{
    collided_shape shapes[2], children[2][CASE_CHILDREN];
    collided_pose poses[2];
    const check_subject *both[2] = {&c->a, &c->b};
    for (int i = 0; i < 2; i++) {
        to_verify(both[i], &both[i]->shape, &shapes[i]);
        for (size_t k = 0; k < both[i]->shape.child_count; k++)
            to_verify(both[i], &both[i]->children[k], &children[i][k]);
        shapes[i].children = children[i];
        shapes[i].child_count = both[i]->shape.child_count;
        memcpy(poses[i].position, both[i]->pose, sizeof poses[i].position);
        memcpy(poses[i].orientation, both[i]->pose + 3, sizeof poses[i].orientation);
    }
    collided_certificate claim = {.lo = lo, .hi = hi};
    memcpy(claim.axis, c->claim.axis, sizeof claim.axis);
    memcpy(claim.point_a, c->claim.point_a, sizeof claim.point_a);
    memcpy(claim.point_b, c->claim.point_b, sizeof claim.point_b);
    return collided_verify(&shapes[0], &poses[0], c->a.shape.points, c->a.shape.point_count, &shapes[1], &poses[1],
        c->b.shape.points, c->b.shape.point_count, &claim);
}

/* Neither accepts what the other refutes by more than rounding. */
static long agree(const check_case *c)
{
    if (!quick_knows(&c->a) || !quick_knows(&c->b)) return 0;
    double margin = 1e-9 * (check_size(c) + fabs(c->a.pose[0]) + fabs(c->b.pose[0]));
    collided_check_proven p;
    ask(c, c->claim.lo, c->claim.hi, 0, &p);
    if (quick(c, p.lo, INFINITY) != COLLIDED_OK) tell(c, "the quick one refuses what is proven of lo");
    if (quick(c, p.lo + margin, INFINITY) == COLLIDED_OK) tell(c, "the quick one accepts more than lo");
    if (!(p.hi < INFINITY)) return 1;
    if (quick(c, -INFINITY, p.hi + margin) != COLLIDED_OK) tell(c, "the quick one refuses what is proven of hi");
    if (p.hi > margin && p.hi - margin > 0 && quick(c, -INFINITY, p.hi - margin) == COLLIDED_OK)
        tell(c, "the quick one accepts less than hi");
    return 1;
}

static void answers_of_the_engine_are_proven(void **state)
{
    (void)state;
    static check_case c;
    long agreed = 0;
    cases_create();
    for (int a = 0; a < CASE_KINDS; a++)
        for (int b = 0; b < CASE_KINDS; b++)
            for (unsigned i = 0; i < pairs_each(); i++) {
                if (a == SHAPE_HALFSPACE && b == a) continue; /* the kernel proves no lo there */
                if (!check_engine_case(a, b, i, &c)) continue;
                count(&c, &tallies[a > b ? a : b]);
                refuse_stronger(&c);
                agreed += agree(&c);
            }
    cases_destroy();
    printf("of pairs with this shape and those above it: claims; lo proven as it stands, and with 2^-38 of the size "
           "and 2^-49 of the coordinates allowed; hi likewise, of those that are not negative\n");
    for (int k = 0; k < CASE_KINDS; k++) {
        const struct tally *t = &tallies[k];
        double lo = t->claims ? 100.0 / (double)t->claims : 0;
        double hi = t->claims > t->depths ? 100.0 / (double)(t->claims - t->depths) : 0;
        printf("%-10s %8ld  lo %5.1f %% %5.1f %%  hi %5.1f %% %5.1f %%  %ld depths\n", KINDS[k], t->claims,
            lo * (double)t->lo_exact, lo * (double)t->lo_allowed, hi * (double)t->hi_exact, hi * (double)t->hi_allowed,
            t->depths);
    }
    assert_true(agreed > 1000 || pairs_each() < 100);
}

static bool has_deviation(const check_subject *s)
{
    bool has = s->shape.deviation > 0;
    for (size_t i = 0; i < s->shape.child_count; i++) has = has || s->children[i].deviation > 0;
    return has;
}

static void quick_and_kernel_agree_on_hostile_pairs(void **state)
{
    (void)state;
    static check_case c;
    long agreed = 0, apart = 0, early = 0;
    for (unsigned i = 0; i < 40 * pairs_each(); i++) {
        check_hostile_case(i, &c);
        if (!quick_knows(&c.a) || !quick_knows(&c.b)) continue;
        collided_check_proven p;
        collided_check_status status = ask(&c, -1e300, 1e300, 0, &p);
        if (status != COLLIDED_CHECK_PROVEN && status != COLLIDED_CHECK_LO_UNPROVEN)
            tell(&c, "a proper pair is refused");
        double margin = 1e-9 * (check_size(&c) + fabs(p.lo));
        for (int k = 0; k < 3; k++) margin += 1e-9 * (fabs(c.a.pose[k]) + fabs(c.b.pose[k]));
        agreed++;
        /* with deviations the quick one takes the word of whoever says that they overlap */
        if (p.hi < INFINITY && p.hi > margin && !has_deviation(&c.a) && !has_deviation(&c.b)) {
            apart++;
            early += quick(&c, -INFINITY, p.hi - margin) == COLLIDED_OK;
        }
    }
    /* of needles and plates a search may end early: what is proven is then more than it could be */
    printf("%ld pairs, %ld apart, of %ld the quick one proves less than hi\n", agreed, apart, early);
    assert_true(agreed > 100 && apart > 50 && early * 200 <= apart);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(answers_of_the_engine_are_proven), cmocka_unit_test(quick_and_kernel_agree_on_hostile_pairs)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
