/* verb_watch: prints the events of a subscription as they come, a line each. Runs inside collided_poll. */
#include "json.h"
#include "show.h"
#include "verbs.h"
#include "watch_soft.h"

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
    [COLLIDED_EVENT_IMPACT] = "impact",
    [COLLIDED_EVENT_PREDICTED] = "predicted",
    [COLLIDED_EVENT_AVERTED] = "averted",
};

/* Valid until the next call. */
static const char *kind_name(collided_event_kind kind)
{
    static char unknown[32]; /* of a later daemon */
    if (kind >= COLLIDED_BEGIN && kind <= COLLIDED_EVENT_AVERTED) return kinds[kind];
    snprintf(unknown, sizeof unknown, "unknown kind %d", (int)kind);
    return unknown;
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
    json_integer(j, "latest_pose_ns", b->latest_pose_ns);
    json_integer(j, "simulation_ns", b->simulation_ns);
    json_integer(j, "step", b->step);
    json_integer(j, "missing", b->missing);
    json_integer(j, "undone", b->undone);
}

static void close_line(json *j)
{
    json_close(j, '}');
    json_end_line(j);
}

static void json_pose(json *j, const char *key, const collided_pose *pose)
{
    json_open(j, key, '{');
    json_numbers(j, "position", pose->position, 3);
    json_numbers(j, "orientation", pose->orientation, 4);
    json_close(j, '}');
}

static void json_impact(json *j, const collided_impact *i)
{
    json_open(j, "impact", '{');
    json_number(j, "lo_s", i->lo_s);
    json_number(j, "hi_s", i->hi_s);
    json_integer(j, "start_ns", i->start_ns);
    json_bool(j, "estimated", i->estimated);
    json_pose(j, "pose_a", &i->pose_a);
    json_pose(j, "pose_b", &i->pose_b);
    json_close(j, '}');
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
    json_text(j, "achieved", show_achieved(e->achieved));
    json_numbers(j, "axis", e->axis, 3);
    json_numbers(j, "point_a", e->point_a, 3);
    json_numbers(j, "point_b", e->point_b, 3);
    json_number(j, "age_a_s", e->age_a_s);
    json_number(j, "age_b_s", e->age_b_s);
    json_number(j, "closing_m_s", e->closing_m_s);
    if (e->impact) json_impact(j, e->impact);
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
    if (b->starved) {
        open_line(&j, "starves", b);
        close_line(&j);
    }
    if (b->snapshot) {
        open_line(&j, "snapshot", b);
        json_integer(&j, "events", (int64_t)b->event_count);
        json_integer(&j, "behind", b->behind);
        close_line(&j);
    }
    for (size_t i = 0; i < b->event_count; i++) json_event(&j, b, &b->events[i]);
    if (b->heartbeat) {
        open_line(&j, "heartbeat", b);
        json_integer(&j, "oldest_pose_ns", b->oldest_pose_ns);
        close_line(&j);
    }
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

/* Since when the time counts, how wide the bracket is, how fast they meet, and where. */
static void text_impact(const collided_event *e)
{
    const collided_impact *i = e->impact;
    char since[16], width[32] = "contact not proven";
    text_time(i->start_ns, since);
    if (isfinite(i->hi_s)) snprintf(width, sizeof width, "within %.3g s", i->hi_s - i->lo_s);
    printf("%12s %-8s after %s, %s%s; closing %.6g m/s, normal %.6f %.6f %.6f, at %.6f %.6f %.6f\n", "", "", since,
        width, i->estimated ? ", of an estimated velocity" : "", e->closing_m_s, e->axis[0], e->axis[1], e->axis[2],
        e->point_a[0], e->point_a[1], e->point_a[2]);
}

static void text_event(const char *when, const collided_event *e)
{
    char interval[96], age[32];
    if (e->impact)
        show_bracket(e->impact->lo_s, e->impact->hi_s, interval, sizeof interval);
    else
        show_interval(e->lo, e->hi, interval, sizeof interval);
    show_age(fmax(e->age_a_s, e->age_b_s), age, sizeof age);
    bool measured = e->impact || e->kind == COLLIDED_BEGIN || e->kind == COLLIDED_UPDATE || e->kind == COLLIDED_NEAR ||
                    e->kind == COLLIDED_KNOWN;
    bool doubtful = measured && e->achieved != COLLIDED_CERTAIN;
    printf("%s %-8s %-24s %-24s %26s  age %-7s %s%s%s\n", when, kind_name(e->kind), e->name_a, e->name_b,
        measured ? interval : "", age, e->cause, doubtful ? ", " : "", doubtful ? show_achieved(e->achieved) : "");
    if (e->impact) text_impact(e);
    for (size_t i = 0; i < e->point_count; i++)
        printf("%12s %-8s point %" PRId64 " at %.6f %.6f %.6f, %.3f mm\n", "", "", e->points[i].feature,
            e->points[i].point[0], e->points[i].point[1], e->points[i].point[2], 1000 * e->points[i].distance);
}

static void text_heartbeat(const char *when, const collided_batch *b)
{
    char age[32] = "-";
    if (b->oldest_pose_ns) show_age(fmax(0, 1e-9 * (double)(b->stamp_ns - b->oldest_pose_ns)), age, sizeof age);
    printf("%s alive    nothing has changed since; age of the oldest pose %s\n", when, age);
}

static void text_batch(const collided_batch *b)
{
    char when[48];
    text_time(b->stamp_ns, when);
    if (b->starved) {
        printf("the stream starves: nothing whole has come for long, and all above is old\n");
        return;
    }
    if (b->simulation_ns) snprintf(when + strlen(when), 32, " sim %.6f s", 1e-9 * (double)b->simulation_ns);
    if (b->lost > 0) printf("%s lost     %" PRId64 " batches; the whole state follows\n", when, b->lost);
    if (b->snapshot) printf("%s snapshot %zu pairs: the whole current state\n", when, b->event_count);
    for (size_t i = 0; i < b->event_count; i++) text_event(when, &b->events[i]);
    if (b->missing > 0)
        printf("%s missing  %" PRId32 " lock-step clients: step %" PRId64 " was done without them\n", when, b->missing,
            b->step);
    if (b->heartbeat) text_heartbeat(when, b);
    if (b->undone > 0) printf("%s undone   %" PRId64 " pairs are left for a later tick\n", when, b->undone);
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

static const char *const accuracies[] = {
    [COLLIDED_BY_TOLERANCE] = "tolerance", [COLLIDED_BY_BOXES] = "boxes", [COLLIDED_BY_VERDICT] = "verdict"};

static bool take_accuracy(const char *word, collided_accuracy *out)
{
    for (int i = COLLIDED_BY_TOLERANCE; i <= COLLIDED_BY_VERDICT; i++) {
        if (strcmp(word, accuracies[i]) != 0) continue;
        *out = (collided_accuracy)i;
        return true;
    }
    return false;
}

/* An option that would be ignored is refused. Times of impacts have a tolerance at any accuracy. */
static int check_tolerances(const ctl_options *o, collided_accuracy accuracy)
{
    bool tolerance = o->tolerance_m >= 0, relative = o->relative_tolerance >= 0;
    if (tolerance && relative) return ctl_fail(EX_USAGE, "watch: --tolerance and --relative: say one of them");
    if (accuracy == COLLIDED_BY_TOLERANCE || o->facts & (COLLIDED_IMPACT | COLLIDED_PREDICT)) return 0;
    if (!tolerance && !relative) return 0;
    return ctl_fail(EX_USAGE, "watch: %s says nothing under --accuracy %s, which asks for no width: leave it out",
        tolerance ? "--tolerance" : "--relative", o->accuracy);
}

int verb_watch(ctl *c)
{
    const ctl_options *o = &c->options;
    collided_accuracy accuracy;
    if (!take_accuracy(o->accuracy, &accuracy))
        return ctl_fail(EX_USAGE, "--accuracy '%s': must be boxes, tolerance or verdict", o->accuracy);
    int status = check_tolerances(o, accuracy);
    if (!status) status = ctl_connect_guest(c);
    if (status) return status;
    ctl_catch_signals();
    collided_subscription_def def = collided_subscription_def_default();
    def.facts = o->facts;
    def.select_a = o->select_a;
    def.select_b = o->select_b;
    def.range_m = o->facts & COLLIDED_DISTANCE ? o->range_m : 0;
    def.accuracy = accuracy;
    if (o->relative_tolerance >= 0) def.relative_tolerance = o->relative_tolerance;
    if (o->tolerance_m >= 0) def.relative_tolerance = 0;
    def.tolerance_m = fmax(o->tolerance_m, 0);
    def.horizon_s = o->facts & COLLIDED_PREDICT ? o->horizon_s : 0;
    def.hysteresis_m = o->hysteresis_m;
    def.rate_hz = o->rate_hz;
    def.callback = on_events;
    def.context = c;
    const collided_soft_def soft = {.callback = o->json ? watch_soft_json : watch_soft_text, .context = c};
    if (collided_subscribe_soft(c->client, &def, &soft).id == COLLIDED_NONE)
        return ctl_fail(EX_DATAERR, "watch: %s", collided_error(c->client));
    status = ctl_check(c, collided_sync(c->client, o->timeout_s), "watch");
    return status ? status : ctl_poll(c, o->seconds);
}
