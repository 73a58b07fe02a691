#include "toi_lattice.h"
#include "toi_truth.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

enum { SAMPLES = 64, KINDS_MAX = 4000 };
static char kinds[KINDS_MAX][96];
static int kind_counts[KINDS_MAX], kind_count;
static long total, per_way[LATTICE_WAYS][4], most_q, most_s, sumq, near_ok;

static void note(const char *why, toi_lattice_way way, const toi_pair *p, uint64_t seed, const toi_result *t, double time, double x)
{
    char k[96];
    snprintf(k, sizeof k, "%s: %s", why, toi_lattice_way_names[way]);
    int i = 0;
    for (; i < kind_count && strcmp(kinds[i], k); i++) {}
    if (i == kind_count) strcpy(kinds[kind_count++], k);
    if (kind_counts[i]++ < 6)
        printf("%-45s seed %llx %s-%s %s [%.17g, %.17g] gaps %g %g q %u s %u | span %g thr %g tol %.3g size %.3g | at %.17g: %g\n", k,
            (unsigned long long)seed, shape_type_name(p->shapes[0].type), shape_type_name(p->shapes[1].type), toi_status_name(t->status), t->lo, t->hi,
            t->gap_lo, t->gap_hi, t->queries, t->steps, p->request.span, p->request.threshold, p->request.tolerance, p->size, time, x);
}

static double gap_then(const toi_pair *p, double time, bool upper)
{
    narrow_result n = toi_truth_at(&p->a, &p->b, time, 1e-12 * p->size, case_scratch());
    return upper ? n.hi : n.lo;
}

/* least hi gap over [from, to], sampled and refined */
static double least(const toi_pair *p, double from, double to, double *when)
{
    double best = INFINITY, at = from, step = (to - from) / SAMPLES;
    for (int k = 0; k <= SAMPLES; k++) {
        double time = k == SAMPLES ? to : from + step * k, g = gap_then(p, time, true);
        if (g < best) best = g, at = time;
    }
    double lo = fmax(from, at - step), hi = fmin(to, at + step);
    for (int k = 0; k < 24; k++) {
        double x = lo + (hi - lo) * 0.382, y = lo + (hi - lo) * 0.618;
        double gx = gap_then(p, x, true), gy = gap_then(p, y, true);
        if (gx < best) best = gx, at = x;
        if (gy < best) best = gy, at = y;
        if (gx < gy) hi = y; else lo = x;
    }
    *when = at;
    return best;
}

static bool bad_numbers(const toi_result *t)
{
    if (isnan(t->lo) || isnan(t->hi) || isnan(t->gap_lo) || isnan(t->gap_hi) || isnan(t->closing)) return true;
    const vec3 v[] = {t->axis, t->point_a, t->point_b, t->body_a.p, t->body_b.p};
    for (size_t i = 0; i < 5; i++)
        if (!isfinite(v[i].x + v[i].y + v[i].z)) return true;
    return !isfinite(quat_norm2(t->body_a.q)) || !isfinite(quat_norm2(t->body_b.q));
}

static motion from_then_on(const motion *m, double time)
{
    return (motion){motion_pose(m, time), m->linear, m->angular};
}

static bool same_answer(const toi_result *x, const toi_result *y)
{
    if (x->status != y->status || memcmp(&x->lo, &y->lo, 8) || memcmp(&x->hi, &y->hi, 8)) return false;
    if (x->status == TOI_FREE) return true;
    return x->gap_lo == y->gap_lo && x->gap_hi == y->gap_hi && x->closing == y->closing && !memcmp(&x->axis, &y->axis, sizeof x->axis) &&
        !memcmp(&x->point_a, &y->point_a, sizeof x->axis) && !memcmp(&x->point_b, &y->point_b, sizeof x->axis);
}

static void check(uint64_t seed, int ta, int tb)
{
    toi_pair p;
    toi_lattice_way way = toi_lattice_make(seed, ta, tb, &p);
    toi_result t = toi_pair_find(&p);
    bool planes = p.shapes[0].type == SHAPE_HALFSPACE && p.shapes[1].type == SHAPE_HALFSPACE;
    bool turning = vec_norm(p.a.motion.angular) > 0 || vec_norm(p.b.motion.angular) > 0;
    total++;
    per_way[way][t.status]++;
    sumq += t.queries;
    if (t.queries > most_q) most_q = t.queries;
    if (t.steps > most_s) most_s = t.steps;
    if (t.queries > 300 || t.steps > 2000) note("many", way, &p, seed, &t, 0, 0);
    if (planes && turning) return;
    if (planes && isinf(gap_then(&p, 0, true))) return;
    double rounding = 2e-13 * p.size, thr = p.request.threshold, span = p.request.span, tol = p.request.tolerance, when;
    if (t.status != TOI_FREE && bad_numbers(&t)) note("NaN", way, &p, seed, &t, 0, 0);
    double end = fmin(t.lo, span), min_before = least(&p, 0, end, &when), min_all = min_before;
    if (min_before <= thr - rounding && !(t.status != TOI_FREE && when >= t.lo)) note("touches before", way, &p, seed, &t, when, min_before - thr);
    if (t.status == TOI_HIT) {
        if (!(t.lo >= 0 && t.lo <= t.hi && t.hi <= span)) note("no bracket", way, &p, seed, &t, 0, 0);
        double g = gap_then(&p, t.hi, false);
        if (g > thr + rounding) note("no touch at hi", way, &p, seed, &t, t.hi, g - thr);
        double before = gap_then(&p, t.lo, true);
        if (t.lo > 0 && before < thr - rounding) note("touches at lo", way, &p, seed, &t, t.lo, before - thr);
    } else if (end < span) {
        double m = least(&p, end, span, &when);
        min_all = fmin(m, min_all);
    }
    if (t.status != TOI_FREE) {
        narrow_result n = toi_truth_at(&p.a, &p.b, t.lo, 0, case_scratch());
        if (n.lo > t.gap_hi + rounding || n.hi < t.gap_lo - rounding) note("gap", way, &p, seed, &t, t.lo, n.lo);
        if (n.lo > thr + 2 * tol + rounding) note("far at lo", way, &p, seed, &t, t.lo, n.lo - thr);
    }
    if (t.status == TOI_UNDECIDED) note(min_all < thr - 2 * tol ? "undecided, deep" : min_all > thr + 2 * tol ? "undecided, clear" : "undecided", way, &p, seed, &t, when, min_all - thr);
    if (t.status == TOI_NEAR) {
        if (min_all < thr - 2 * tol) note("near, deep", way, &p, seed, &t, when, min_all - thr);
        else if (min_all < thr - rounding) note("near, touches", way, &p, seed, &t, when, min_all - thr);
        else if (min_all > thr + tol + rounding) note("near, clear", way, &p, seed, &t, when, min_all - thr);
        else if (min_all > thr + rounding) note("near, apart", way, &p, seed, &t, when, min_all - thr);
        else near_ok++;
    }
    /* guesses */
    for (int k = 0; k < 7; k++) {
        static const vec3 G[] = {{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}};
        vec3 guess = k < 6 ? G[k] : toi_truth_at(&p.a, &p.b, 0, 1e-9 * p.size, case_scratch()).axis;
        toi_result o;
        toi_find(&p.a, &p.b, &p.request, guess, case_scratch(), &o);
        if (!same_answer(&t, &o)) { note("guess", way, &p, seed, &o, 0, 0); note("guess cold", way, &p, seed, &t, 0, 0); break; }
    }
    /* splits */
    for (int pieces = 2; pieces <= 3; pieces++) {
        toi_result o = {.status = TOI_FREE};
        double from = 0;
        for (int k = 0; k < pieces && o.status == TOI_FREE; k++) {
            from = span * k / pieces;
            toi_mover a = p.a, b = p.b;
            a.motion = from_then_on(&p.a.motion, from), b.motion = from_then_on(&p.b.motion, from);
            toi_request r = p.request;
            r.span = span * (k + 1) / pieces - from;
            toi_find(&a, &b, &r, VEC_ZERO, case_scratch(), &o);
        }
        bool agrees = o.status == t.status || (o.status != TOI_FREE && t.status != TOI_FREE);
        if (o.status == TOI_HIT && t.status == TOI_HIT) agrees = from + o.lo <= t.hi + 1e-12 * span && from + o.hi >= t.lo - 1e-12 * span;
        if (agrees) continue;
        double w, all = least(&p, 0, span, &w);
        if (fabs(all - thr) <= 2 * tol) continue;
        if (o.status == TOI_HIT && t.status == TOI_HIT && fabs(gap_then(&p, fmin(t.lo, from + o.lo), 1) - thr) <= 2 * tol && fabs(gap_then(&p, fmax(t.lo, from + o.lo), 1) - thr) <= 2 * tol) continue;
        note("split", way, &p, seed, &t, from + o.lo, all - thr);
        note("split part", way, &p, seed, &o, from, all - thr);
    }
    /* swap, where both orders are canonical */
    if (p.shapes[0].type == p.shapes[1].type && narrow_ordered(&p.shapes[1], 0, &p.shapes[0], 1)) {
        toi_result o;
        toi_find(&p.b, &p.a, &p.request, VEC_ZERO, case_scratch(), &o);
        if (o.status != t.status && fabs(min_all - thr) > 2 * tol && t.status != TOI_HIT) note("swap", way, &p, seed, &o, 0, min_all - thr);
    }
}

int main(int argc, char **argv)
{
    toi_lattice_create();
    if (argc > 3) { /* one */
        check(strtoull(argv[1], NULL, 16), atoi(argv[2]), atoi(argv[3]));
        return 0;
    }
    int each = argc > 1 ? atoi(argv[1]) : 60;
    uint64_t base = argc > 2 ? strtoull(argv[2], NULL, 16) : 0;
    for (int ta = 0; ta < TOI_LATTICE_TYPES; ta++)
        for (int tb = ta; tb < TOI_LATTICE_TYPES; tb++)
            for (int i = 0; i < each; i++) check(((uint64_t)ta << 40) + ((uint64_t)tb << 32) + base + (uint64_t)i, ta, tb);
    for (int i = 0; i < kind_count; i++) printf("%6d %s\n", kind_counts[i], kinds[i]);
    for (int w = 0; w < LATTICE_WAYS; w++)
        printf("%-12s free %ld hit %ld near %ld undecided %ld\n", toi_lattice_way_names[w], per_way[w][0], per_way[w][1], per_way[w][2], per_way[w][3]);
    printf("%ld pairs, %.2f queries, most %ld, steps most %ld; near ok %ld\n", total, (double)sumq / (double)total, most_q, most_s, near_ok);
    toi_lattice_destroy();
    return 0;
}
