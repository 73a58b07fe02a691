/* words: what a page is told in JSON. */
#include "json.h"
#include "web.h"

static void put_names(json *j, const char *name, const char *const *names, size_t count)
{
    json_name(j, name);
    json_raw(j, "[");
    for (size_t i = 0; i < count; i++) {
        if (i) json_raw(j, ",");
        if (names[i])
            json_text(j, names[i]);
        else
            json_raw(j, "null");
    }
    json_raw(j, "]");
}

#define NAMES(name, ...)                                                                                               \
    do {                                                                                                               \
        static const char *const all[] = {__VA_ARGS__};                                                                \
        put_names(&j, name, all, sizeof all / sizeof all[0]);                                                          \
    } while (0)

char *words_hello(const web *w)
{
    json j = {0};
    json_raw(&j, "{");
    json_name(&j, "protocol");
    json_text(&j, "collided.web.v1");
    json_name(&j, "release");
    json_text(&j, collided_version());
    json_name(&j, "connected");
    json_flag(&j, w->connected);
    json_name(&j, "epoch");
    json_whole(&j, w->epoch);
    json_name(&j, "uri");
    json_text(&j, w->options.connect);
    json_name(&j, "rate_hz");
    json_number(&j, w->options.rate_hz);
    json_name(&j, "range_m");
    json_number(&j, w->options.range_m);
    json_name(&j, "horizon_s");
    json_number(&j, w->options.horizon_s);
    json_name(&j, "control");
    json_flag(&j, false);
    json_name(&j, "recording");
    json_raw(&j, "null");
    NAMES("event_kinds", NULL, "begin", "update", "end", "near", "far", "unknown", "known", "impact", "predicted",
        "averted");
    NAMES("causes", "motion", "removed", "owner_lost", "filter", "shape", "subscription", "shutdown", "stale",
        "snapshot", "teleport");
    NAMES("achieved", "certain", "within", "wide", "stopped");
    NAMES("shape_types", "sphere", "capsule", "box", "cylinder", "cone", "ellipsoid", "half-space", "hull", "mesh",
        "height field", "compound");
    json_raw(&j, "}");
    return j.at;
}

static void put_counters(json *j, const collided_daemon_status *s)
{
    json_name(j, "counters");
    json_raw(j, "{");
    for (size_t i = 0; i < s->counter_count; i++) {
        json_name(j, s->counters[i].name);
        json_count(j, s->counters[i].value);
    }
    json_raw(j, "}");
}

static void put_server(json *j, const web *w, const viewer *v)
{
    json_name(j, "web");
    json_raw(j, "{");
    json_name(j, "observers");
    json_count(j, (int64_t)w->viewer_count);
    json_name(j, "bodies");
    json_count(j, (int64_t)w->mirror->live);
    json_name(j, "contacts");
    json_count(j, (int64_t)w->mirror->contact_count);
    json_name(j, "rate_hz");
    json_number(j, v->rate_hz);
    json_name(j, "skipped");
    json_count(j, (int64_t)v->skipped);
    json_name(j, "control_waiting");
    json_count(j, (int64_t)v->waiting);
    json_name(j, "events");
    json_count(j, (int64_t)w->mirror->event_count);
    json_name(j, "lost");
    json_count(j, (int64_t)w->mirror->lost);
    json_raw(j, "}");
}

char *words_status(web *w, const viewer *v)
{
    json j = {0};
    collided_daemon_status s;
    bool heard = collided_get_status(w->client, 0, &s) == COLLIDED_OK;
    json_raw(&j, "{");
    json_name(&j, "connected");
    json_flag(&j, heard);
    json_name(&j, "health");
    json_text(&j, heard ? s.health : "silent");
    json_name(&j, "limits");
    json_text(&j, heard ? s.limits : "no daemon is heard");
    json_name(&j, "playback");
    json_raw(&j, "null");
    put_server(&j, w, v);
    if (heard) {
        json_name(&j, "daemon");
        json_text(&j, s.daemon);
        json_name(&j, "release");
        json_text(&j, s.release);
        json_name(&j, "links");
        json_text(&j, s.links);
        json_name(&j, "epoch");
        json_whole(&j, s.epoch);
        json_name(&j, "started_ns");
        json_whole(&j, s.started_ns);
        json_name(&j, "tick");
        json_whole(&j, s.tick);
        json_name(&j, "stamp_ns");
        json_whole(&j, s.stamp_ns);
        put_counters(&j, &s);
    }
    json_raw(&j, "}");
    return j.at;
}
