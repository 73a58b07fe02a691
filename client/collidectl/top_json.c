/* top_json: the view as one JSON object a line. */
#include "top_json.h"
#include "json.h"

static void put_times_json(json *j, const top_sample *s, const char *key, const char *const names[4])
{
    static const char *const keys[4] = {"p50_ns", "p90_ns", "p99_ns", "most_ns"};
    json_open(j, key, '{');
    for (int i = 0; i < 4; i++) json_integer(j, keys[i], top_figure(s, names[i]));
    json_close(j, '}');
}

static void put_clients_json(json *j, const top_sample *s)
{
    top_client clients[TOP_ROWS_MAX];
    size_t count = top_clients(s, clients);
    json_open(j, "clients", '[');
    for (size_t i = 0; i < count; i++) {
        json_open(j, NULL, '{');
        json_text(j, "client", clients[i].id);
        json_text(j, "name", clients[i].name);
        json_integer(j, "bodies", clients[i].bodies);
        json_number(j, "poses_per_s", clients[i].poses);
        json_integer(j, "pose_age_ns", clients[i].pose_age_ns);
        json_integer(j, "silent_ns", clients[i].silent_ns);
        json_integer(j, "work", clients[i].work);
        json_close(j, '}');
    }
    json_close(j, ']');
}

static void put_streams_json(json *j, const top_sample *s)
{
    top_stream streams[TOP_ROWS_MAX];
    size_t count = top_streams(s, streams);
    json_open(j, "streams", '[');
    for (size_t i = 0; i < count; i++) {
        json_open(j, NULL, '{');
        json_text(j, "stream", streams[i].name);
        json_number(j, "events_per_s", streams[i].events);
        json_integer(j, "work", streams[i].work);
        json_close(j, '}');
    }
    json_close(j, ']');
}

static void put_figures(json *j, const top_sample *s)
{
    static const char *const figures[] = {"bodies", "stale_bodies", "lost_bodies", "shapes", "pairs", "contacts",
        "subscriptions", "geometries", "budget_ns", "work", "undone", "unbounded"};
    static const char *const latency[4] = {"latency_p50_ns", "latency_p90_ns", "latency_p99_ns", "latency_most_ns"};
    static const char *const tick[4] = {"tick_p50_ns", "tick_p90_ns", "tick_p99_ns", "tick_most_ns"};
    json_number(j, "ticks_per_s", top_rate(s, "ticks"));
    json_number(j, "load", top_load(s));
    json_number(j, "poses_per_s", top_rate(s, "moves"));
    json_number(j, "events_per_s", top_rate(s, "events_out"));
    json_number(j, "batches_per_s", top_rate(s, "batches_out"));
    put_times_json(j, s, "latency", latency);
    put_times_json(j, s, "tick_time", tick);
    for (size_t i = 0; i < sizeof figures / sizeof *figures; i++)
        json_integer(j, figures[i], top_figure(s, figures[i]));
    json_number(j, "undone_ticks_per_s", top_rate(s, "undone_ticks"));
}

void top_json(const top_sample *s, double unheard_s)
{
    json j = {.out = stdout};
    size_t at = 0;
    json_open(&j, NULL, '{');
    json_text(&j, "health", unheard_s > 0 ? "unheard" : s->now.health);
    json_number(&j, "unheard_s", unheard_s);
    json_text(&j, "daemon", s->now.daemon);
    json_text(&j, "release", s->now.release);
    json_text(&j, "limits", s->now.limits);
    json_integer(&j, "epoch", s->now.epoch);
    json_integer(&j, "tick", s->now.tick);
    json_integer(&j, "stamp_ns", s->now.stamp_ns);
    json_integer(&j, "started_ns", s->now.started_ns);
    put_figures(&j, s);
    json_open(&j, "pairs_per_s", '{');
    for (top_member m; top_next(s, "pairs_by_", &at, &m);) json_number(&j, m.rest, m.rate);
    json_close(&j, '}');
    json_open(&j, "drops", '{');
    at = 0;
    for (top_drop d; top_next_drop(s, &at, &d);) json_integer(&j, d.cause, d.total);
    json_close(&j, '}');
    put_clients_json(&j, s);
    put_streams_json(&j, s);
    json_close(&j, '}');
    json_end_line(&j);
}
