/* top_sample: see top_sample.h. Figures are looked up by name, at first where they stood in the Status before. */
#include "top_sample.h"

#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* ---- copies ---- */

static void *need(void *memory)
{
    if (memory) return memory;
    fputs("collidectl: out of memory\n", stderr);
    abort();
}

static char *copy(const char *text)
{
    return need(strdup(text ? text : ""));
}

static void free_status(top_status *t)
{
    for (size_t i = 0; i < t->count; i++) free(t->names[i]);
    free(t->names);
    free(t->values);
    for (char **text = (char *[]){t->health, t->daemon, t->release, t->links, t->limits}, **end = text + 5; text < end;
         text++)
        free(*text);
    *t = (top_status){.epoch = 0};
}

static top_status copy_status(const collided_daemon_status *s)
{
    top_status t = {s->epoch, s->tick, s->stamp_ns, s->started_ns, copy(s->health), copy(s->daemon), copy(s->release),
        copy(s->links), copy(s->limits), .count = s->counter_count};
    t.names = need(calloc(t.count + 1, sizeof *t.names));
    t.values = need(calloc(t.count + 1, sizeof *t.values));
    for (size_t i = 0; i < t.count; i++) {
        t.names[i] = copy(s->counters[i].name);
        t.values[i] = s->counters[i].value;
    }
    return t;
}

bool top_sample_take(top_sample *s, const collided_daemon_status *status)
{
    if (status->epoch == s->now.epoch && status->stamp_ns == s->now.stamp_ns) return false;
    free_status(&s->before);
    if (status->epoch == s->now.epoch)
        s->before = s->now;
    else
        free_status(&s->now);
    s->now = copy_status(status);
    return true;
}

void top_sample_free(top_sample *s)
{
    free_status(&s->now);
    free_status(&s->before);
}

/* ---- figures ---- */

static int64_t value_of(const top_status *t, const char *name, size_t likely)
{
    if (likely < t->count && strcmp(t->names[likely], name) == 0) return t->values[likely];
    for (size_t i = 0; i < t->count; i++)
        if (strcmp(t->names[i], name) == 0) return t->values[i];
    return 0;
}

double top_seconds(const top_sample *s)
{
    int64_t since = s->before.epoch ? s->before.stamp_ns : s->now.started_ns;
    double seconds = 1e-9 * (double)(s->now.stamp_ns - since);
    return seconds > 1e-3 ? seconds : 1e-3;
}

int64_t top_figure(const top_sample *s, const char *name)
{
    return value_of(&s->now, name, 0);
}

static double rate_at(const top_sample *s, const char *name, int64_t now, size_t likely)
{
    int64_t more = now - value_of(&s->before, name, likely);
    return more > 0 ? (double)more / top_seconds(s) : 0;
}

double top_rate(const top_sample *s, const char *name)
{
    return rate_at(s, name, top_figure(s, name), 0);
}

double top_load(const top_sample *s)
{
    return 1e-9 * top_rate(s, "busy_ns");
}

bool top_next(const top_sample *s, const char *prefix, size_t *at, top_member *out)
{
    size_t length = strlen(prefix);
    for (; *at < s->now.count; ++*at) {
        const char *name = s->now.names[*at];
        if (strncmp(name, prefix, length) != 0) continue;
        int64_t value = s->now.values[*at];
        *out = (top_member){name + length, value, rate_at(s, name, value, *at)};
        ++*at;
        return true;
    }
    return false;
}

/* ---- drops ---- */

static bool is_drop(const char *name)
{
    static const char *const causes[] = {"rejects_untold", "late_poses", "clients_lost", "steps_missed", "dds_refused",
        "dds_foreign", "dds_write_failed", "dds_no_stream", "dds_history_full", "lcm_refused", "lcm_queue_full",
        "lcm_queue_full_poses", "lcm_out_dropped", "lcm_bad_frames", "lcm_gateway_restarts", "record_failures"};
    if (strncmp(name, "reject_", 7) == 0) return true;
    for (size_t i = 0; i < sizeof causes / sizeof *causes; i++)
        if (strcmp(name, causes[i]) == 0) return true;
    return false;
}

bool top_next_drop(const top_sample *s, size_t *at, top_drop *out)
{
    top_member m;
    while (top_next(s, "", at, &m)) {
        if (m.value == 0 || !is_drop(m.rest)) continue;
        *out = (top_drop){m.rest, m.value, m.rate};
        return true;
    }
    return false;
}

/* ---- clients and streams ---- */

static int64_t figure_of(const top_sample *s, const char *prefix, const char *whose, int64_t none)
{
    size_t at = 0;
    for (top_member m; top_next(s, prefix, &at, &m);)
        if (strcmp(m.rest, whose) == 0) return m.value;
    return none;
}

static double rate_of(const top_sample *s, const char *prefix, const char *whose)
{
    char name[256];
    snprintf(name, sizeof name, "%s%s", prefix, whose);
    return top_rate(s, name);
}

static int by_cost(int64_t work_a, int64_t work_b, double rate_a, double rate_b, const char *name_a, const char *name_b)
{
    if (work_a != work_b) return work_a < work_b ? 1 : -1;
    if (rate_a < rate_b || rate_b < rate_a) return rate_a < rate_b ? 1 : -1;
    return strcmp(name_a, name_b);
}

static int compare_clients(const void *a, const void *b)
{
    const top_client *x = a, *y = b;
    return by_cost(x->work, y->work, x->poses, y->poses, x->id, y->id);
}

static int compare_streams(const void *a, const void *b)
{
    const top_stream *x = a, *y = b;
    return by_cost(x->work, y->work, x->events, y->events, x->name, y->name);
}

size_t top_clients(const top_sample *s, top_client out[TOP_ROWS_MAX])
{
    enum { ID = 16 };
    size_t count = 0, at = 0;
    for (top_member m; count < TOP_ROWS_MAX && top_next(s, "client_name_", &at, &m);) {
        if (strlen(m.rest) < ID) continue;
        top_client *c = &out[count++];
        *c = (top_client){.name = m.rest[ID] ? m.rest + ID + 1 : ""};
        memcpy(c->id, m.rest, ID);
        c->bodies = figure_of(s, "client_bodies_", c->id, 0);
        c->work = figure_of(s, "client_work_", c->id, 0);
        c->silent_ns = figure_of(s, "client_silent_ns_", c->id, 0);
        c->pose_age_ns = figure_of(s, "client_pose_age_ns_", c->id, -1);
        c->poses = rate_of(s, "client_poses_", c->id);
    }
    qsort(out, count, sizeof *out, compare_clients);
    return count;
}

size_t top_streams(const top_sample *s, top_stream out[TOP_ROWS_MAX])
{
    size_t count = 0, at = 0;
    for (top_member m; count < TOP_ROWS_MAX && top_next(s, "events_of_", &at, &m); count++)
        out[count] = (top_stream){m.rest, figure_of(s, "work_of_", m.rest, 0), m.rate};
    qsort(out, count, sizeof *out, compare_streams);
    return count;
}
