/* verb_watch: prints the events of an interest as they come, a line each. Runs inside collided_poll. */
#include "json.h"
#include "show.h"
#include "verbs.h"

#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <string.h>
#include <sysexits.h>
#include <time.h>

static const char *const kinds[] = {
    [COLLIDED_BEGIN] = "begin",
    [COLLIDED_UPDATE] = "update",
    [COLLIDED_END] = "end",
    [COLLIDED_NEAR] = "near",
    [COLLIDED_FAR] = "far",
    [COLLIDED_UNKNOWN] = "unknown",
    [COLLIDED_KNOWN] = "known",
};

static const char *kind_name(collided_event_kind kind)
{
    return kind >= COLLIDED_BEGIN && kind <= COLLIDED_KNOWN ? kinds[kind] : "?";
}

/* ---- JSON ---- */

static void open_line(json *j, const char *event, const collided_batch *b)
{
    json_open(j, NULL, '{');
    json_text(j, "event", event);
    json_text(j, "stream", b->stream);
    json_integer(j, "epoch", b->epoch);
    json_integer(j, "batch", b->batch);
    json_integer(j, "tick", b->tick);
    json_integer(j, "stamp_ns", b->stamp_ns);
    json_integer(j, "step", b->step);
}

static void close_line(json *j)
{
    json_close(j, '}');
    json_end_line(j);
}

static void json_event(json *j, const collided_batch *b, const collided_event *e)
{
    open_line(j, kind_name(e->kind), b);
    json_bool(j, "snapshot", b->snapshot);
    json_text(j, "cause", e->cause);
    json_integer(j, "contact", e->contact);
    json_text(j, "a", e->name_a);
    json_text(j, "b", e->name_b);
    json_integer(j, "shape_a", e->shape_a);
    json_integer(j, "shape_b", e->shape_b);
    json_number(j, "lo", e->lo);
    json_number(j, "hi", e->hi);
    json_numbers(j, "axis", e->axis, 3);
    json_numbers(j, "point_a", e->point_a, 3);
    json_numbers(j, "point_b", e->point_b, 3);
    json_number(j, "age_a_s", e->age_a_s);
    json_number(j, "age_b_s", e->age_b_s);
    json_open(j, "points", '[');
    for (size_t i = 0; i < e->point_count; i++) {
        json_open(j, NULL, '{');
        json_numbers(j, "point", e->points[i].point, 3);
        json_number(j, "distance", e->points[i].distance);
        json_integer(j, "feature", e->points[i].feature);
        json_close(j, '}');
    }
    json_close(j, ']');
    close_line(j);
}

static void json_batch(const collided_batch *b)
{
    json j = {.out = stdout};
    if (b->lost > 0) {
        open_line(&j, "lost", b);
        json_integer(&j, "batches", b->lost);
        close_line(&j);
    }
    if (b->snapshot) {
        open_line(&j, "snapshot", b);
        json_integer(&j, "events", (int64_t)b->event_count);
        close_line(&j);
    }
    for (size_t i = 0; i < b->event_count; i++) json_event(&j, b, &b->events[i]);
    if (b->closing) {
        open_line(&j, "closing", b);
        close_line(&j);
    }
}

/* ---- for people ---- */

static void text_time(int64_t stamp_ns, char out[16])
{
    time_t seconds = (time_t)(stamp_ns / 1000000000);
    struct tm t;
    char clock[12] = "--:--:--";
    if (localtime_r(&seconds, &t)) strftime(clock, sizeof clock, "%H:%M:%S", &t);
    snprintf(out, 16, "%s.%03d", clock, (int)(stamp_ns / 1000000 % 1000 + 1000) % 1000);
}

static void text_event(const char *when, const collided_event *e)
{
    char interval[96], age[32];
    show_interval(e->lo, e->hi, interval, sizeof interval);
    show_age(fmax(e->age_a_s, e->age_b_s), age, sizeof age);
    bool measured = e->kind != COLLIDED_UNKNOWN && e->kind != COLLIDED_FAR && e->kind != COLLIDED_END;
    printf("%s %-8s %-24s %-24s %26s  age %-7s %s\n", when, kind_name(e->kind), e->name_a, e->name_b,
        measured ? interval : "", age, e->cause);
    for (size_t i = 0; i < e->point_count; i++)
        printf("%12s %-8s point %" PRId64 " at %.6f %.6f %.6f, %.3f mm\n", "", "", e->points[i].feature,
            e->points[i].point[0], e->points[i].point[1], e->points[i].point[2], 1000 * e->points[i].distance);
}

static void text_batch(const collided_batch *b)
{
    char when[16];
    text_time(b->stamp_ns, when);
    if (b->lost > 0) printf("%s lost     %" PRId64 " batches; the whole state follows\n", when, b->lost);
    if (b->snapshot) printf("%s snapshot %zu pairs: the whole current state\n", when, b->event_count);
    for (size_t i = 0; i < b->event_count; i++) text_event(when, &b->events[i]);
    if (b->closing) printf("%s closing  the stream ends\n", when);
}

static void on_events(void *context, const collided_batch *batch)
{
    const ctl *c = context;
    if (c->options.json)
        json_batch(batch);
    else
        text_batch(batch);
    fflush(stdout);
}

int verb_watch(ctl *c)
{
    const ctl_options *o = &c->options;
    int status = ctl_connect_guest(c);
    if (status) return status;
    ctl_catch_signals();
    collided_interest_def def = collided_interest_def_default();
    def.facts = o->facts;
    def.select_a = o->select_a;
    def.select_b = o->select_b;
    def.range_m = o->facts & COLLIDED_DISTANCE ? o->range_m : 0;
    def.tolerance_m = o->tolerance_m;
    def.rate_hz = o->rate_hz;
    def.callback = on_events;
    def.context = c;
    if (collided_subscribe(c->client, &def).id == COLLIDED_NONE)
        return ctl_fail(EX_DATAERR, "watch: %s", collided_error(c->client));
    status = ctl_check(c, collided_sync(c->client, o->timeout_s), "watch");
    return status ? status : ctl_poll(c, o->seconds);
}
