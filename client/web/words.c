/* words: what a page is told in JSON. */
#include "web.h"
#include "window/json_buffer.h"

static void put_recording(json_buffer *j, const web *w)
{
    if (!w->options.file) {
        json_buffer_raw(j, "null");
        return;
    }
    json_buffer_raw(j, "{");
    json_buffer_name(j, "file");
    json_buffer_text(j, w->options.file);
    json_buffer_name(j, "begin_ns");
    json_buffer_whole(j, w->replay.begin_ns);
    json_buffer_name(j, "end_ns");
    json_buffer_whole(j, w->replay.end_ns);
    json_buffer_name(j, "ticks");
    json_buffer_count(j, w->replay.ticks);
    json_buffer_raw(j, "}");
}

static void put_playback(json_buffer *j, const web *w)
{
    static const char *const STATES[] = {"paused", "playing", "playing", "ended"};
    if (!w->options.file) {
        json_buffer_raw(j, "null");
        return;
    }
    json_buffer_raw(j, "{");
    json_buffer_name(j, "state");
    json_buffer_text(j, STATES[w->replay.state]);
    json_buffer_name(j, "at_ns");
    json_buffer_whole(j, w->replay.at_ns);
    json_buffer_name(j, "tick");
    json_buffer_count(j, w->replay.tick);
    json_buffer_name(j, "speed");
    json_buffer_number(j, w->replay.speed);
    json_buffer_raw(j, "}");
}

char *words_hello(const web *w)
{
    json_buffer j = {0};
    json_buffer_raw(&j, "{");
    json_buffer_name(&j, "protocol");
    json_buffer_text(&j, "collided.web.v1");
    json_buffer_name(&j, "release");
    json_buffer_text(&j, collided_version());
    json_buffer_name(&j, "connected");
    json_buffer_flag(&j, w->connected);
    json_buffer_name(&j, "epoch");
    json_buffer_whole(&j, w->epoch);
    json_buffer_name(&j, "uri");
    json_buffer_text(&j, w->options.file ? w->options.file : w->options.connect);
    json_buffer_name(&j, "rate_hz");
    json_buffer_number(&j, w->options.rate_hz);
    json_buffer_name(&j, "range_m");
    json_buffer_number(&j, w->options.range_m);
    json_buffer_name(&j, "horizon_s");
    json_buffer_number(&j, w->options.horizon_s);
    json_buffer_name(&j, "control");
    json_buffer_flag(&j, w->options.file != NULL);
    json_buffer_name(&j, "recording");
    put_recording(&j, w);
    frame_names(&j);
    json_buffer_raw(&j, "}");
    return j.at;
}

static void put_counters(json_buffer *j, const collided_daemon_status *s)
{
    json_buffer_name(j, "counters");
    json_buffer_raw(j, "{");
    for (size_t i = 0; i < s->counter_count; i++) {
        json_buffer_name(j, s->counters[i].name);
        json_buffer_count(j, s->counters[i].value);
    }
    json_buffer_raw(j, "}");
}

static void put_server(json_buffer *j, const web *w, const viewer *v)
{
    json_buffer_name(j, "web");
    json_buffer_raw(j, "{");
    json_buffer_name(j, "observers");
    json_buffer_count(j, (int64_t)w->viewer_count);
    json_buffer_name(j, "bodies");
    json_buffer_count(j, (int64_t)w->mirror->live);
    json_buffer_name(j, "contacts");
    json_buffer_count(j, (int64_t)w->mirror->contact_count);
    json_buffer_name(j, "rate_hz");
    json_buffer_number(j, v->rate_hz);
    json_buffer_name(j, "skipped");
    json_buffer_count(j, (int64_t)v->skipped);
    json_buffer_name(j, "control_waiting");
    json_buffer_count(j, (int64_t)v->waiting);
    json_buffer_name(j, "events");
    json_buffer_count(j, (int64_t)w->mirror->event_count);
    json_buffer_name(j, "lost");
    json_buffer_count(j, (int64_t)w->mirror->lost);
    json_buffer_raw(j, "}");
}

char *words_status(web *w, const viewer *v)
{
    json_buffer j = {0};
    collided_daemon_status s;
    bool heard = collided_get_status(w->client, 0, &s) == COLLIDED_OK;
    json_buffer_raw(&j, "{");
    json_buffer_name(&j, "connected");
    json_buffer_flag(&j, heard);
    json_buffer_name(&j, "health");
    json_buffer_text(&j, heard ? s.health : "silent");
    json_buffer_name(&j, "limits");
    json_buffer_text(&j, heard ? s.limits : "no daemon is heard");
    json_buffer_name(&j, "playback");
    put_playback(&j, w);
    put_server(&j, w, v);
    if (heard) {
        json_buffer_name(&j, "daemon");
        json_buffer_text(&j, s.daemon);
        json_buffer_name(&j, "release");
        json_buffer_text(&j, s.release);
        json_buffer_name(&j, "links");
        json_buffer_text(&j, s.links);
        json_buffer_name(&j, "epoch");
        json_buffer_whole(&j, s.epoch);
        json_buffer_name(&j, "started_ns");
        json_buffer_whole(&j, s.started_ns);
        json_buffer_name(&j, "tick");
        json_buffer_whole(&j, s.tick);
        json_buffer_name(&j, "stamp_ns");
        json_buffer_whole(&j, s.stamp_ns);
        put_counters(&j, &s);
    }
    json_buffer_raw(&j, "}");
    return j.at;
}
