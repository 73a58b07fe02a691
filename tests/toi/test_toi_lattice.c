/* The time of impact of motions as machines make them (toi_lattice.h), against samples of certified distances, refined
 * where they are least: what is called free is free, nothing touches before lo, at hi it does, gap_lo and gap_hi hold;
 * no guess changes an answer; the motion in two or three pieces, the two in the other order (where both are canonical),
 * and room for acceleration contradict nothing. What is not decided is rare and bounded.
 *
 * COLLIDED_NIGHTLY: 60 times as many pairs; COLLIDED_BRIEF: a fifth. */
#include "toi_lattice.h"
#include "toi_truth.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

enum { PAIRS_EACH = 15, SAMPLES = 40, REFINEMENTS = 20, QUERIES_MOST = 2400, STEPS_MOST = 4000 };

typedef struct tally {
    uint32_t all, count[4];
    uint32_t open;    /* undecided though no threshold below zero makes it hard */
    uint32_t clear;   /* of those and near misses: never within twice the tolerance */
    uint32_t touches; /* near misses that go deeper than that later */
} tally;

typedef struct subject {
    toi_pair pair;
    toi_lattice_way way;
    uint64_t seed;
    double rounding, least, least_at; /* the least distance that was sampled over the whole span */
    toi_result found;
} subject;

static int pairs_each(void)
{
    return getenv("COLLIDED_NIGHTLY") ? 60 * PAIRS_EACH : getenv("COLLIDED_BRIEF") ? PAIRS_EACH / 5 : PAIRS_EACH;
}

static void fail_subject(const char *why, const subject *s, const toi_result *t, double time, double by)
{
    fail_msg("%s: %s-%s %s, seed 0x%llx: %s [%.17g, %.17g] gaps %g %g, %u distances, %u steps; span %g, threshold %g, "
             "tolerance %g: at %.17g by %g",
        why, shape_type_name(s->pair.shapes[0].type), shape_type_name(s->pair.shapes[1].type),
        toi_lattice_way_names[s->way], (unsigned long long)s->seed, toi_status_name(t->status), t->lo, t->hi, t->gap_lo,
        t->gap_hi, t->queries, t->steps, s->pair.request.span, s->pair.request.threshold, s->pair.request.tolerance,
        time, by);
}

static narrow_result distance_at(const subject *s, double time)
{
    return toi_truth_at(&s->pair.a, &s->pair.b, time, 1e-12 * s->pair.size, case_scratch());
}

/* m; how much nearer than contact it comes at a time, when so much room is left for acceleration; > 0: nearer. */
static double too_near(const subject *s, double time, double wander)
{
    return s->pair.request.threshold + 0.5 * wander * time * time - s->rounding - distance_at(s, time).hi;
}

static double greatest(const subject *s, double from, double to, double wander, double *when)
{
    double best = -INFINITY, step = (to - from) / SAMPLES;
    *when = from;
    for (int k = 0; k <= SAMPLES; k++) {
        double time = k == SAMPLES ? to : from + step * k, x = too_near(s, time, wander);
        if (x > best) best = x, *when = time;
    }
    double lo = fmax(from, *when - step), hi = fmin(to, *when + step);
    for (int k = 0; k < REFINEMENTS; k++) {
        double first = lo + 0.382 * (hi - lo), then = lo + 0.618 * (hi - lo);
        double x = too_near(s, first, wander), y = too_near(s, then, wander);
        if (x > best) best = x, *when = first;
        if (y > best) best = y, *when = then;
        if (x > y)
            hi = then;
        else
            lo = first;
    }
    return best;
}

static bool turns(const toi_mover *m)
{
    return vec_norm(m->motion.angular) > 0;
}

static bool is_convex(const subject *s)
{
    return s->pair.shapes[1].type < SHAPE_CONVEX_COUNT;
}

static bool are_planes(const subject *s)
{
    return s->pair.shapes[0].type == SHAPE_HALFSPACE && s->pair.shapes[1].type == SHAPE_HALFSPACE;
}

/* Of the least distance: by more than the tolerance excuses. */
static bool is_clear(const subject *s)
{
    return s->least > s->pair.request.threshold + 2 * s->pair.request.tolerance + s->rounding;
}

static bool is_deep(const subject *s)
{
    return s->least < s->pair.request.threshold - 2 * s->pair.request.tolerance - s->rounding;
}

static bool finite_vec(vec3 v)
{
    return isfinite(v.x) && isfinite(v.y) && isfinite(v.z);
}

static bool has_numbers(const toi_result *t)
{
    return isfinite(t->lo) && !isnan(t->hi) && isfinite(t->gap_lo) && isfinite(t->gap_hi) && isfinite(t->closing) &&
           finite_vec(t->axis) && finite_vec(t->point_a) && finite_vec(t->point_b) && finite_vec(t->body_a.p) &&
           finite_vec(t->body_b.p) && isfinite(quat_norm2(t->body_a.q)) && isfinite(quat_norm2(t->body_b.q));
}

/* ---- the answer ---- */

static void check_hit(const subject *s)
{
    const toi_result *t = &s->found;
    if (!(0 <= t->lo && t->lo <= t->hi && t->hi <= s->pair.request.span)) fail_subject("no bracket", s, t, t->hi, 0);
    double apart = distance_at(s, t->hi).lo - s->pair.request.threshold;
    if (apart > s->rounding) fail_subject("it does not touch at hi", s, t, t->hi, apart);
    double near = t->lo > 0 ? too_near(s, t->lo, 0) : 0;
    if (near > 0) fail_subject("it touches at lo", s, t, t->lo, near);
}

static void check_gap(const subject *s)
{
    const toi_result *t = &s->found;
    narrow_result n = distance_at(s, t->lo);
    if (n.lo > t->gap_hi + s->rounding) fail_subject("farther than gap_hi", s, t, t->lo, n.lo - t->gap_hi);
    if (n.hi < t->gap_lo - s->rounding) fail_subject("nearer than gap_lo", s, t, t->lo, t->gap_lo - n.hi);
}

/* What begins in contact is a hit at 0; what does not move has the verdict of the beginning. */
static void check_beginning(const subject *s)
{
    const toi_result *t = &s->found;
    const toi_request *r = &s->pair.request;
    narrow_result n = distance_at(s, 0);
    bool in_contact = n.hi < r->threshold - 2 * s->rounding;
    bool apart = n.lo > r->threshold + 2 * r->tolerance + s->rounding;
    if (is_convex(s) && in_contact && !(t->status == TOI_HIT && t->hi == 0))
        fail_subject("it begins in contact", s, t, 0, n.hi);
    if (s->way == LATTICE_RESTS && apart && t->status != TOI_FREE) fail_subject("it stays apart", s, t, 0, n.lo);
}

static void check_answer(subject *s)
{
    const toi_result *t = &s->found;
    double span = s->pair.request.span, end = fmin(t->lo, span), then = end;
    double near = greatest(s, 0, end, 0, &s->least_at);
    if (near > 0 && s->least_at < t->lo) fail_subject("it touches before", s, t, s->least_at, near);
    double later = end < span ? greatest(s, end, span, 0, &then) : -INFINITY;
    if (later > near) s->least_at = then;
    s->least = s->pair.request.threshold - s->rounding - fmax(near, later);
    check_beginning(s);
    if (is_convex(s) && (t->queries > QUERIES_MOST || t->steps > STEPS_MOST)) fail_subject("too long", s, t, 0, 0);
    if (t->status == TOI_FREE) {
        if (!(isinf(t->lo) && isinf(t->hi))) fail_subject("free, and yet times", s, t, 0, 0);
        return;
    }
    if (!has_numbers(t)) fail_subject("not a number", s, t, 0, 0);
    if (t->status == TOI_HIT) check_hit(s);
    check_gap(s);
}

/* ---- others ---- */

static bool same(const void *a, const void *b, size_t size)
{
    return memcmp(a, b, size) == 0;
}

static bool same_answer(const toi_result *x, const toi_result *y)
{
    if (x->status != y->status || !same(&x->lo, &y->lo, sizeof x->lo) || !same(&x->hi, &y->hi, sizeof x->hi))
        return false;
    if (x->status == TOI_FREE) return true;
    return x->gap_lo == y->gap_lo && x->gap_hi == y->gap_hi && x->closing == y->closing &&
           same(&x->axis, &y->axis, sizeof x->axis) && same(&x->point_a, &y->point_a, sizeof x->point_a) &&
           same(&x->point_b, &y->point_b, sizeof x->point_b);
}

static void check_guesses(const subject *s)
{
    const toi_pair *p = &s->pair;
    const vec3 guesses[] = {{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}, distance_at(s, 0).axis,
        distance_at(s, 0.5 * p->request.span).axis};
    for (size_t k = 0; k < sizeof guesses / sizeof *guesses; k++) {
        toi_result t;
        toi_find(&p->a, &p->b, &p->request, guesses[k], case_scratch(), &t);
        if (!same_answer(&t, &s->found)) fail_subject("a guess changes it", s, &t, 0, (double)k);
    }
}

/* Both proven, and not the same: only where the touch is less than the tolerance. */
static void check_agrees(const char *why, const subject *s, const toi_result *t, double from)
{
    const toi_result *whole = &s->found;
    bool proven = t->status <= TOI_HIT && whole->status <= TOI_HIT, hits = t->status == TOI_HIT;
    if (!proven || (t->status != whole->status && !is_clear(s) && !is_deep(s))) return;
    double room = 1e-12 * s->pair.request.span;
    bool apart = hits && (from + t->lo > whole->hi + room || from + t->hi < whole->lo - room);
    if (t->status != whole->status || (apart && is_deep(s) && from + t->lo > s->least_at))
        fail_subject(why, s, t, from, s->least);
}

static motion from_then_on(const motion *m, double time)
{
    return (motion){motion_pose(m, time), m->linear, m->angular};
}

static void check_pieces(const subject *s, int pieces)
{
    double span = s->pair.request.span, from = 0;
    toi_result t = {.status = TOI_FREE};
    for (int k = 0; k < pieces && t.status == TOI_FREE; k++) {
        from = span * k / pieces;
        toi_mover a = s->pair.a, b = s->pair.b;
        a.motion = from_then_on(&a.motion, from);
        b.motion = from_then_on(&b.motion, from);
        toi_request r = s->pair.request;
        r.span = span * (k + 1) / pieces - from;
        toi_find(&a, &b, &r, VEC_ZERO, case_scratch(), &t);
    }
    check_agrees("in pieces it differs", s, &t, from);
}

static void check_order(const subject *s)
{
    const toi_pair *p = &s->pair;
    toi_result t;
    if (!narrow_ordered(&p->shapes[1], 0, &p->shapes[0], 1)) return;
    toi_find(&p->b, &p->a, &p->request, VEC_ZERO, case_scratch(), &t);
    check_agrees("in the other order it differs", s, &t, 0);
}

static void check_wander(const subject *s)
{
    toi_request r = s->pair.request;
    double when;
    toi_result t;
    r.wander = 0.125 * s->pair.size / (r.span * r.span);
    toi_find(&s->pair.a, &s->pair.b, &r, VEC_ZERO, case_scratch(), &t);
    if (t.status == TOI_HIT && t.lo > 0) fail_subject("accelerated contact is never proven", s, &t, t.lo, 0);
    double end = fmin(t.lo, r.span), near = greatest(s, 0, end, r.wander, &when);
    if (near > 0 && when < t.lo) fail_subject("there is no room for acceleration", s, &t, when, near);
}

static void count_up(const subject *s, tally *c)
{
    toi_status status = s->found.status;
    bool open = status == TOI_UNDECIDED && (is_convex(s) || s->pair.request.threshold >= 0);
    c->all++;
    c->count[status]++;
    c->open += open;
    c->clear += (open || status == TOI_NEAR) && is_clear(s);
    c->touches += status == TOI_NEAR && is_deep(s);
}

static void check(uint64_t seed, int type_a, int type_b, tally counts[LATTICE_WAYS])
{
    subject s = {.seed = seed};
    s.way = toi_lattice_make(seed, type_a, type_b, &s.pair);
    s.rounding = 2e-13 * s.pair.size;
    s.found = toi_pair_find(&s.pair);
    /* Two planes that turn are never decided; those that cross are as deep as you like. */
    if (are_planes(&s) && (turns(&s.pair.a) || turns(&s.pair.b) || isinf(distance_at(&s, 0).hi))) return;
    check_answer(&s);
    check_guesses(&s);
    check_pieces(&s, 2);
    check_pieces(&s, 3);
    check_order(&s);
    check_wander(&s);
    count_up(&s, &counts[s.way]);
}

static void what_machines_do_is_told_truly(void **state)
{
    (void)state;
    tally counts[LATTICE_WAYS] = {{0}}, total = {0};
    for (int ta = 0; ta < TOI_LATTICE_TYPES; ta++)
        for (int tb = ta; tb < TOI_LATTICE_TYPES; tb++)
            for (int i = 0; i < pairs_each(); i++)
                check(((uint64_t)ta << 40) + ((uint64_t)tb << 32) + (uint64_t)i, ta, tb, counts);
    for (int k = 0; k < LATTICE_WAYS; k++) {
        const tally *c = &counts[k];
        print_message("%-10s %6u pairs: %u free, %u hit, %u near, %u undecided; of these %u clear, %u near ones deep "
                      "later\n",
            toi_lattice_way_names[k], c->all, c->count[TOI_FREE], c->count[TOI_HIT], c->count[TOI_NEAR],
            c->count[TOI_UNDECIDED], c->clear, c->touches);
        assert_true(c->count[TOI_FREE] > c->all / 4 && c->count[TOI_HIT] > c->all / 10);
        total.all += c->all, total.open += c->open, total.clear += c->clear, total.touches += c->touches;
    }
    print_message("%u pairs: %u open, %u clear, %u deep\n", total.all, total.open, total.clear, total.touches);
    assert_true(total.open <= total.all / 400 + 2);
    assert_true(total.clear <= total.all / 400 + 2);
    assert_true(total.touches <= total.all / 400 + 2);
}

/* What went wrong, and how it has to end. */
static void what_was_found_stays_mended(void **state)
{
    (void)state;
    static const struct {
        const char *what;
        uint64_t seed;
        int type_a, type_b;
        toi_status status;
    } FOUND[] = {
        {"a search for depth told the gap of the time before", 0x90000522f, SHAPE_SPHERE, TOI_LATTICE_COMPOUND,
            TOI_HIT},
        {"the gap was that of two parts, others were nearer", 0x308000052d4, SHAPE_CYLINDER, TOI_LATTICE_MESH, TOI_HIT},
        {"it begins within rounding of contact and goes on", 0x70900000012, SHAPE_HULL, TOI_LATTICE_COMPOUND, TOI_HIT},
        {"it is in a solid and touches a face from inside", 0x80000518f, SHAPE_SPHERE, TOI_LATTICE_MESH, TOI_HIT},
        {"a ball that turns about another's centre", 0x532d, SHAPE_SPHERE, SHAPE_SPHERE, TOI_FREE},
        {"two that turn as one body", 0x30500005010, SHAPE_CYLINDER, SHAPE_ELLIPSOID, TOI_FREE},
    };
    tally counts[LATTICE_WAYS] = {{0}};
    for (size_t i = 0; i < sizeof FOUND / sizeof *FOUND; i++) {
        toi_pair p;
        (void)toi_lattice_make(FOUND[i].seed, FOUND[i].type_a, FOUND[i].type_b, &p);
        toi_status status = toi_pair_find(&p).status;
        if (status != FOUND[i].status)
            fail_msg("%s: %s instead of %s", FOUND[i].what, toi_status_name(status), toi_status_name(FOUND[i].status));
        check(FOUND[i].seed, FOUND[i].type_a, FOUND[i].type_b, counts);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(what_was_found_stays_mended),
        cmocka_unit_test(what_machines_do_is_told_truly),
    };
    toi_lattice_create();
    int failed = cmocka_run_group_tests(tests, NULL, NULL);
    toi_lattice_destroy();
    return failed;
}
