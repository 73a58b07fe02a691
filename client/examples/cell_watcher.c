/* cell_watcher: prints what happens in the cell: contacts of any two bodies as they begin, go on and end, and how near
 * the arm and the vehicle are, and will be. Shows three subscriptions of one client, and how intervals and ages are
 * read. One thread. */
#include "example.h"

#include <math.h>
#include <stdio.h>
#include <string.h>
#include <sysexits.h>

static const double THRESHOLD_M = 0.001;       /* nearer than this counts as touching */
static const double RANGE_M = 0.6;             /* arm and vehicle are watched from here on */
static const double HORIZON_S = 1;             /* so far ahead is predicted that they come too near */
static const double APPROACH_S = 1;            /* what was not predicted for so long is another approach */
static const int64_t NEAR_LINE_NS = 250000000; /* at most four lines a second say how near */

enum { NAME_MAX_BYTES = 128 };
typedef struct gap { /* copied: what a callback gets is valid only during the call */
    bool known;
    char a[NAME_MAX_BYTES], b[NAME_MAX_BYTES];
    double lo, hi, age_s;
} gap;

typedef struct watcher {
    const example *e;
    gap recent;  /* nearest since the last line */
    gap nearest; /* nearest of all */
    double oldest_s;
    unsigned long begins, updates, ends, nears, unknowns, lost;
    unsigned long approaches;    /* that were predicted, ... */
    double first_ahead_s;        /* ... the first one so long before */
    int64_t predicted_ns;        /* when one was last, monotonic */
    bool has_contacts, has_gaps; /* the first snapshot of each subscription came */
} watcher;

static double age_of(const collided_event *e)
{
    return fmax(e->age_a_s, e->age_b_s);
}

/* `again`: this batch repeats the whole state, since some were lost; what it says has begun may have been told. */
static bool is_repetition(watcher *w, const collided_batch *batch, bool *has_first)
{
    bool again = batch->snapshot && *has_first;
    if (batch->starved) fprintf(stderr, "cell_watcher: nothing whole has come for long: what is above is old\n");
    *has_first = *has_first || batch->snapshot;
    if (batch->lost > 0) {
        w->lost += (unsigned long)batch->lost;
        fprintf(stderr, "cell_watcher: %lld batches were lost; the whole state follows\n", (long long)batch->lost);
    }
    return again;
}

static void print_event(watcher *w, const char *what, const collided_event *e)
{
    example_line(w->e, what, e->name_a, e->name_b, e->lo, e->hi, age_of(e));
}

/* Past a body's deadline nobody knows: neither touching nor free. */
static void print_unknown(watcher *w, const collided_event *e)
{
    if (e->kind == COLLIDED_UNKNOWN) w->unknowns++;
    print_event(w, e->kind == COLLIDED_UNKNOWN ? "unknown" : "known", e);
}

static void on_contacts(void *context, const collided_batch *batch)
{
    watcher *w = context;
    bool again = is_repetition(w, batch, &w->has_contacts);
    for (size_t i = 0; i < batch->event_count; i++) {
        const collided_event *e = &batch->events[i];
        bool begins = e->kind == COLLIDED_BEGIN && !again;
        if (e->kind == COLLIDED_UNKNOWN || e->kind == COLLIDED_KNOWN) {
            print_unknown(w, e);
            continue;
        }
        if (e->kind > COLLIDED_EVENT_AVERTED) continue; /* of a later daemon */
        w->oldest_s = fmax(w->oldest_s, age_of(e));
        w->begins += begins;
        w->ends += e->kind == COLLIDED_END;
        w->updates += !begins && e->kind != COLLIDED_END;
        print_event(w, begins ? "begin" : e->kind == COLLIDED_END ? "end" : "update", e);
    }
}

/* By the upper bound: the two points that prove it are really that near. */
static void keep_nearer(gap *g, const collided_event *e)
{
    if (g->known && g->hi <= e->hi) return;
    *g = (gap){.known = true, .lo = e->lo, .hi = e->hi, .age_s = age_of(e)};
    (void)snprintf(g->a, sizeof g->a, "%s", e->name_a);
    (void)snprintf(g->b, sizeof g->b, "%s", e->name_b);
}

static void on_gaps(void *context, const collided_batch *batch)
{
    watcher *w = context;
    (void)is_repetition(w, batch, &w->has_gaps);
    for (size_t i = 0; i < batch->event_count; i++) {
        const collided_event *e = &batch->events[i];
        if (e->kind != COLLIDED_NEAR) continue; /* far ends a nearness; unknown is told by on_contacts */
        w->nears++;
        w->oldest_s = fmax(w->oldest_s, age_of(e));
        keep_nearer(&w->recent, e);
        keep_nearer(&w->nearest, e);
    }
}

/* "Contact" is here to be nearer than the protective distance. One line an approach, whichever pairs it is predicted
 * of.
 */
static void on_predicted(void *context, const collided_batch *batch)
{
    watcher *w = context;
    for (size_t i = 0; i < batch->event_count; i++) {
        const collided_event *e = &batch->events[i];
        if (e->kind != COLLIDED_EVENT_PREDICTED) continue;
        double ahead_s =
            e->impact->lo_s - fmax(0, fmin(e->age_a_s, e->age_b_s)); /* its time counts from the newer pose */
        int64_t now_ns = example_now_ns();
        if (ahead_s > 0 && (w->approaches == 0 || now_ns - w->predicted_ns > (int64_t)(1e9 * APPROACH_S))) {
            if (w->approaches++ == 0) w->first_ahead_s = ahead_s;
            example_note(w->e, "predicted: %s and %s nearer than %.0f mm in %.2f s, closing at %.2f m/s%s", e->name_a,
                e->name_b, 1e3 * EXAMPLE_PROTECTIVE_M, ahead_s, e->closing_m_s,
                e->impact->estimated ? " (estimated)" : "");
        }
        w->predicted_ns = now_ns;
    }
}

static bool subscribe(collided *c, watcher *w)
{
    collided_subscription_def contacts = collided_subscription_def_default();
    contacts.threshold_m = THRESHOLD_M;
    contacts.rate_hz = 1; /* of updates; begin and end are told at once */
    contacts.callback = on_contacts;
    contacts.context = w;

    collided_subscription_def gaps = collided_subscription_def_default();
    gaps.facts = COLLIDED_DISTANCE;
    gaps.select_a = "group:arm";
    gaps.select_b = "group:vehicle";
    gaps.range_m = RANGE_M;
    gaps.tolerance_m = 1e-5;
    gaps.rate_hz = 50;
    gaps.callback = on_gaps;
    gaps.context = w;

    collided_subscription_def approaches = gaps;
    approaches.facts = COLLIDED_PREDICT;
    approaches.range_m = 0;
    approaches.threshold_m = EXAMPLE_PROTECTIVE_M;
    approaches.horizon_s = HORIZON_S;
    approaches.callback = on_predicted;

    bool asked = collided_subscribe(c, &contacts).id != COLLIDED_NONE &&
                 collided_subscribe(c, &gaps).id != COLLIDED_NONE &&
                 collided_subscribe(c, &approaches).id != COLLIDED_NONE;
    if (!asked) fprintf(stderr, "cell_watcher: %s\n", collided_error(c));
    return asked && example_ok(c, collided_sync(c, 5), "cell_watcher: subscribing");
}

static void print_recent(watcher *w)
{
    const gap *g = &w->recent;
    if (g->known) example_line(w->e, "near", g->a, g->b, g->lo, g->hi, g->age_s);
    w->recent.known = false;
}

static void json_summary(const watcher *w)
{
    const gap *g = &w->nearest;
    printf("{\"event\":\"summary\",\"link\":\"%s\",\"begins\":%lu,\"updates\":%lu,\"ends\":%lu,\"nears\":%lu,"
           "\"unknowns\":%lu,\"lost\":%lu,\"longest_age_s\":%.6f,\"approaches\":%lu,\"first_ahead_s\":%.6f,"
           "\"nearest_a\":",
        w->e->link, w->begins, w->updates, w->ends, w->nears, w->unknowns, w->lost, w->oldest_s, w->approaches,
        w->first_ahead_s);
    example_json_text(g->a);
    fputs(",\"nearest_b\":", stdout);
    example_json_text(g->b);
    fputs(",\"nearest_lo\":", stdout);
    example_json_number(g->known ? g->lo : INFINITY);
    fputs(",\"nearest_hi\":", stdout);
    example_json_number(g->known ? g->hi : INFINITY);
    puts("}");
}

static void text_summary(const watcher *w)
{
    const gap *g = &w->nearest;
    printf("summary: %lu begins, %lu ends, %lu updates, %lu distances", w->begins, w->ends, w->updates, w->nears);
    if (g->known) printf("; nearest %.3f .. %.3f mm (%s, %s)", 1e3 * g->lo, 1e3 * g->hi, g->a, g->b);
    printf("; oldest pose used %.1f ms old", 1e3 * w->oldest_s);
    if (w->approaches) printf("; %lu approaches predicted, the first %.2f s ahead", w->approaches, w->first_ahead_s);
    if (w->unknowns) printf("; %lu times unknown", w->unknowns);
    if (w->lost) printf("; %lu batches lost", w->lost);
    putchar('\n');
}

int main(int argc, char **argv)
{
    const example e = example_start(argc, argv);
    watcher w = {.e = &e};
    collided *c = example_connect(&e, NULL);
    if (!c) return EX_UNAVAILABLE;
    bool good = subscribe(c, &w), heard = true;

    while (good && example_running(&e)) {
        bool hears = example_poll_until(c, example_now_ns() + NEAR_LINE_NS) == COLLIDED_OK;
        if (heard && !hears) fprintf(stderr, "cell_watcher: the daemon is not heard; waiting for it\n");
        heard = hears;
        print_recent(&w);
    }
    if (good && e.json) json_summary(&w);
    if (good && !e.json) text_summary(&w);
    fflush(stdout);
    collided_close(c);
    return good ? EX_OK : EX_SOFTWARE;
}
