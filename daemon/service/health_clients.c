/* health_clients: what Status tells of each client: who it is, what it has, how old it is, and what it costs; and of
 * those that were lost. Of the first SHEET_NAMED_MAX; the others count in the sums. Tick thread. */
#include "clients.h"
#include "health.h"

#include <inttypes.h>

/* Those that have figures of their own: who is here comes before who left in order and whose bodies stay. */
typedef struct named_clients {
    const session *at[SHEET_NAMED_MAX];
    size_t count;
} named_clients;

static named_clients name_clients(const service *s)
{
    named_clients n = {.count = 0};
    for (int left = 0; left < 2; left++)
        for (size_t i = 0; i < s->sessions.count && n.count < SHEET_NAMED_MAX; i++)
            if (s->sessions.at[i]->left == left) n.at[n.count++] = s->sessions.at[i];
    return n;
}

/* One figure of each; `value` says false where a client has none. */
static void add_each(const service *s, sheet *t, const named_clients *clients, const char *prefix,
    bool (*value)(const service *s, const session *c, int64_t *out))
{
    for (size_t i = 0; i < clients->count; i++) {
        const session *c = clients->at[i];
        int64_t number;
        if (value(s, c, &number)) sheet_add_named(t, number, "%s%016" PRIx64, prefix, (uint64_t)c->client);
    }
}

static bool bodies_of(const service *s, const session *c, int64_t *out)
{
    (void)s;
    *out = (int64_t)c->body_count;
    return true;
}

static bool left_of(const service *s, const session *c, int64_t *out)
{
    (void)s;
    *out = 1;
    return c->left;
}

static bool silence_of(const service *s, const session *c, int64_t *out)
{
    *out = s->monotonic_ns > c->last_seen_ns ? s->monotonic_ns - c->last_seen_ns : 0;
    return !c->left;
}

static bool pose_age_of(const service *s, const session *c, int64_t *out)
{
    *out = s->now_ns - c->latest_pose_ns;
    return c->latest_pose_ns != 0 && !c->left;
}

static bool poses_of(const service *s, const session *c, int64_t *out)
{
    (void)s;
    *out = (int64_t)c->pose_count;
    return true;
}

static bool work_of(const service *s, const session *c, int64_t *out)
{
    (void)s;
    *out = (int64_t)c->work;
    return !c->left;
}

static bool spent_of(const service *s, const session *c, int64_t *out)
{
    (void)s;
    *out = (int64_t)(c->spent_us / 1e3);
    return !c->left;
}

static void add_names(sheet *t, const named_clients *clients)
{
    for (size_t i = 0; i < clients->count; i++) {
        const session *c = clients->at[i];
        sheet_add_named(t, 1, "client_name_%016" PRIx64 "_%s", (uint64_t)c->client, c->name);
    }
}

static bool pending_bodies_of(const service *s, const session *c, int64_t *out)
{
    (void)s;
    *out = (int64_t)c->pending_count;
    return c->pending_count != 0;
}

/* What waits for its geometry, and since when; of the first few by name. */
static void add_pending(const service *s, sheet *t)
{
    enum { NAMED = 32 };
    const builds_figures f = builds_get_figures(s->builds);
    sheet_add(t, "pending_bodies", (int64_t)s->pending.count);
    sheet_add(t, "pending_geometries", (int64_t)s->geometries_building);
    sheet_add(t, "pending_build_work", (int64_t)f.units);
    sheet_add(t, "pending_build_bytes", (int64_t)f.bytes);
    for (size_t i = 0; i < s->pending.count && i < NAMED; i++) {
        const pending_body *p = &s->pending.at[i];
        int64_t waited_ns = s->monotonic_ns - p->since_ns;
        sheet_add_named(t, waited_ns > 0 ? waited_ns : 0, "pending_body_ns_%s", p->name);
    }
}

void health_add_clients(service *s, sheet *t)
{
    const named_clients clients = name_clients(s);
    add_names(t, &clients);
    add_each(s, t, &clients, "client_bodies_", bodies_of);
    add_each(s, t, &clients, "client_silent_ns_", silence_of);
    add_each(s, t, &clients, "client_pose_age_ns_", pose_age_of);
    add_each(s, t, &clients, "client_poses_", poses_of);
    add_each(s, t, &clients, "client_work_", work_of);
    add_each(s, t, &clients, "client_left_", left_of);
    add_each(s, t, &clients, "client_spent_ms_", spent_of);
    add_each(s, t, &clients, "client_pending_", pending_bodies_of);
    add_pending(s, t);
    for (size_t i = 0; i < s->sessions.count; i++) s->sessions.at[i]->work = 0;
}

/* Whose lease ran out and whose bodies stay. Those who left in order are not missed. */
void health_add_lost(const service *s, sheet *t)
{
    size_t clients = 0, bodies = 0;
    for (size_t i = 0; i < s->sessions.count; i++) {
        const session *c = s->sessions.at[i];
        size_t left = c->lost && !c->left ? session_bodies(c) : 0;
        if (!left) continue;
        bodies += left;
        if (clients++ >= SHEET_NAMED_MAX) continue; /* counted, and told in the log */
        sheet_add_named(t, (int64_t)left, "lost_client_%016" PRIx64, (uint64_t)c->client);
    }
    sheet_add(t, "lost_clients", (int64_t)clients);
    sheet_add(t, "lost_bodies", (int64_t)bodies);
}
