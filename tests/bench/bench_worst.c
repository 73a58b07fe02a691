/* bench_worst: the longest that one query takes, of shapes made to take long (worst_scene.c), each of up to 100,000
 * triangles or 40,000 points; and a climb over their numbers to what takes longer. It times the entries that ship:
 * narrow_query with the requests that the world's cascade makes of a subscription in touches, distances or manifolds,
 * hull_build, and toi_find. A time is that of the thread's processor, the least of a few, so that other processes do
 * not enter it; --bodies N: sizes of N parts of 1,000; --seconds: for each case. One thread. */
#include "bench.h"
#include "worst_scene.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

enum { REPEATS = 2, GEOMETRY_KNOBS = 2, GEOMETRY_SHARE = 8 };

static const double SECONDS = 2, SECONDS_FULL = 60;

typedef struct record { /* the longest */
    double ms;
    const char *facts;
    size_t elements;
    unsigned wide, undecided; /* 1: that it was */
    double width;             /* of the interval, m */
} record;

static double now_ms(void)
{
    struct timespec t;
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
    return 1e3 * (double)t.tv_sec + 1e-6 * (double)t.tv_nsec;
}

/* ---- one query ---- */

/* As cascade.c asks of a pair: relative tolerance 1e-6; the range is that of a pair that is in an event. */
static const struct asked {
    const char *name;
    unsigned facts;
} ASKED[] = {{"verdict", NARROW_VERDICT}, {"distance", NARROW_VERDICT | NARROW_DISTANCE},
    {"manifold", NARROW_VERDICT | NARROW_DISTANCE | NARROW_MANIFOLD}};

enum { ASKED_COUNT = sizeof ASKED / sizeof *ASKED };

static record time_query(const worst_scene *s, narrow_scratch *scratch)
{
    record longest = {0};
    bool ordered = narrow_ordered(&s->a, 0, &s->b, 1);
    const shape *a = ordered ? &s->a : &s->b, *b = ordered ? &s->b : &s->a;
    pose b_in_a = pose_relative(ordered ? POSE_IDENTITY : s->b_in_a, ordered ? s->b_in_a : POSE_IDENTITY);
    for (int i = 0; i < ASKED_COUNT; i++) {
        narrow_request r = {.facts = ASKED[i].facts, .range = INFINITY};
        r.tolerance = 1e-6 * (shape_reach(a) + shape_reach(b));
        narrow_result n;
        double ms = INFINITY;
        for (int k = 0; k < REPEATS; k++) {
            narrow_cache cache = {.lower = 0};
            double start = now_ms();
            narrow_query(a, b, &b_in_a, &r, &cache, scratch, &n);
            ms = fmin(ms, now_ms() - start);
        }
        if (ms > longest.ms) longest = (record){.ms = ms, .facts = ASKED[i].name, .wide = n.status == NARROW_WIDE};
        if (longest.facts == ASKED[i].name) longest.width = n.hi - n.lo;
    }
    return longest;
}

static record time_build(const worst_scene *s)
{
    record r = {.facts = "hull"};
    hull *h = NULL;
    double start = now_ms();
    r.undecided = hull_build(s->points, s->point_count, 0, &h) != HULL_OK;
    r.ms = now_ms() - start;
    if (h) r.width = h->excess;
    hull_destroy(h);
    return r;
}

static record time_impact(const worst_scene *s, narrow_scratch *scratch)
{
    record r = {.facts = "impact"};
    toi_result t;
    double start = now_ms();
    toi_find(&s->move_a, &s->move_b, &s->request, VEC_ZERO, scratch, &t);
    r.ms = now_ms() - start;
    r.undecided = t.status == TOI_UNDECIDED;
    return r;
}

static record time_scene(const worst_case *c, const worst_scene *s, narrow_scratch *scratch)
{
    record r = c->entry == WORST_QUERY   ? time_query(s, scratch)
               : c->entry == WORST_BUILD ? time_build(s)
                                         : time_impact(s, scratch);
    r.elements = worst_elements(s);
    return r;
}

/* ---- the climb ---- */

static double scatter(uint64_t *state)
{
    *state = *state * 6364136223846793005u + 1442695040888963407u;
    return (double)(*state >> 11) * 0x1p-53;
}

/* One knob elsewhere: near, or anywhere. True: the shapes have to be built again. */
static bool turn_knob(double knob[WORST_KNOBS], uint64_t *state)
{
    bool geometry = scatter(state) * GEOMETRY_SHARE < 1;
    size_t first = geometry ? 0 : GEOMETRY_KNOBS, count = geometry ? GEOMETRY_KNOBS : WORST_KNOBS - GEOMETRY_KNOBS;
    size_t k = first + (size_t)(scatter(state) * (double)count);
    double x = scatter(state), far = scatter(state);
    knob[k] = far < 0.3 ? x : fmin(fmax(knob[k] + 0.2 * (x - 0.5), 0), 1);
    return geometry;
}

static record climb(const worst_case *c, double size, double seconds, narrow_scratch *scratch, unsigned *tried)
{
    double best_knob[WORST_KNOBS], knob[WORST_KNOBS], start = now_ms();
    uint64_t state = 99;
    worst_scene s;
    memcpy(best_knob, c->start, sizeof best_knob);
    memcpy(knob, best_knob, sizeof knob);
    worst_build(c, knob, size, &s);
    record best = time_scene(c, &s, scratch);
    bool stale = false; /* the scene's shapes are not those of best_knob */
    for (*tried = 1; now_ms() - start < 1e3 * seconds; (*tried)++) {
        memcpy(knob, best_knob, sizeof knob);
        if (turn_knob(knob, &state) || stale || c->entry == WORST_BUILD) {
            worst_free(&s);
            worst_build(c, knob, size, &s);
        } else {
            worst_place(c, knob, &s);
        }
        record r = time_scene(c, &s, scratch);
        stale = !(r.ms > best.ms) && memcmp(knob, best_knob, GEOMETRY_KNOBS * sizeof *knob) != 0;
        if (!(r.ms > best.ms)) continue;
        best = r;
        memcpy(best_knob, knob, sizeof knob);
    }
    worst_free(&s);
    return best;
}

static const char *entry_name(worst_entry e)
{
    static const char *const NAMES[] = {"narrow_query", "hull_build", "toi_find"};
    return NAMES[e];
}

static void print(const bench_options *o, const worst_case *c, const record *r, unsigned tried)
{
    if (o->json)
        printf(
            "{\"bench\":\"worst\",\"case\":\"%s\",\"entry\":\"%s\",\"asked\":\"%s\",\"ms_max\":%.4g,\"elements\":%zu,"
            "\"tried\":%u,\"wide\":%u,\"undecided\":%u,\"width_m\":%.3g}\n",
            c->name, entry_name(c->entry), r->facts, r->ms, r->elements, tried, r->wide, r->undecided,
            isfinite(r->width) ? r->width : -1);
    else
        printf("%-28s %-13s %-9s %10.3f ms %9zu %5u%s%s\n", c->name, entry_name(c->entry), r->facts, r->ms, r->elements,
            tried, r->wide ? "  wide" : "", r->undecided ? "  undecided" : "");
    fflush(stdout);
}

int main(int argc, char **argv)
{
    bench_options o;
    if (!bench_parse(argc, argv, SECONDS, SECONDS_FULL, &o)) return 64;
    narrow_scratch *scratch = aligned_alloc(64, narrow_scratch_size());
    if (!scratch) return 1;
    if (!o.json) printf("%-28s %-13s %-9s %13s %9s %5s\n", "case", "entry", "asked", "longest", "elements", "tried");
    for (size_t i = 0; i < WORST_CASE_COUNT; i++) {
        unsigned tried;
        record r = climb(&WORST_CASES[i], o.bodies ? 1e-3 * (double)o.bodies : 1, o.seconds, scratch, &tried);
        print(&o, &WORST_CASES[i], &r, tried);
    }
    free(scratch);
    return 0;
}
