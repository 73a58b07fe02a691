/* limits: what one client may have in the world, how fast it may talk, and by which link. A limit that is reached is
 * named in the Reject and in Status. Rates and memory are looked at before a message is recorded, and not in a replay:
 * what was refused live is not in the recording. Tick thread. */
#include "clients.h"
#include "commands.h"
#include "geometries.h"
#include "memory.h"
#include "shares.h"
#include "suspect.h"
#include "wire/wire_model.h"

#include <inttypes.h>
#include <stdio.h>

enum { REJECTS_REPORTED = 100 /* a second and client: a flood is not answered by a flood */ };

static const int64_t SECOND_NS = 1000000000, LEASE_MOST_NS = 3600000000000;

/* Adds to what came in this second. */
static int64_t flow_add(flow *f, int64_t now_ns, int64_t count)
{
    if (now_ns - f->began_ns >= SECOND_NS || !f->began_ns) *f = (flow){now_ns, 0};
    return f->count += count;
}

/* Over LCM nobody can be told apart: whoever names a client is taken for it. But a client of one link cannot be spoken
 * for over another. */
static bool is_by_its_link(const session *c, const struct link *from, wire_refusal *why)
{
    if (c->link == from || c->lost) return true;
    why->reason = WIRE_NOT_YOURS;
    snprintf(why->text, sizeof why->text, "client %016" PRIx64 " is here by %s, not by %s", (uint64_t)c->client,
        c->link->ops->scheme, from->ops->scheme);
    return false;
}

/* For so long a client that is gone keeps what it has. Told in the words of who says too large a number, and not as a
 * limit that is reached. */
static bool is_lease(const wire_client *m, wire_refusal *why)
{
    if (m->removed || m->lease_ns <= LEASE_MOST_NS) return true;
    why->reason = WIRE_TOO_LARGE;
    snprintf(why->text, sizeof why->text, "lease_ns: %.0f s is longer than the longest lease of an hour (3600 s)",
        1e-9 * (double)m->lease_ns);
    return false;
}

bool limits_admit(service *s, struct link *from, const wire_message *m, wire_refusal *why)
{
    int64_t client, sequence;
    int32_t object;
    wire_origin(m, &client, &sequence, &object);
    session *c = session_find(s, client);
    if (s->replaying) return true;
    if (m->kind == WIRE_CLIENT && !is_lease(&m->client, why)) return false;
    if (c && !is_by_its_link(c, from, why)) return false;
    if (suspect_refuses(s, m, why) || !memory_admit(s, from, m, why)) return false;
    if (!c) return true;
    int64_t messages = flow_add(shares_flow(s, from, client, SHARES_MESSAGES), s->monotonic_ns, 1);
    if (apply_limit(s, (size_t)messages - 1, s->config.max_client_messages, "max_client_messages", why)) return false;
    size_t more =
        m->kind == WIRE_POSE_BATCH ? m->pose_batch.bodies.count + wire_joints_poses_most(m->pose_batch.extensions) : 0;
    if (!more) return true;
    flow *all = shares_flow(s, from, client, SHARES_POSES);
    int64_t poses = flow_add(all, s->monotonic_ns, (int64_t)more);
    return !apply_limit(s, (size_t)poses - 1, s->config.max_client_poses, "max_client_poses", why);
}

/* The limits of one client that follow hold what the configuration names; 0: its participant's share, before it comes
 * here (shares.c). Those of a participant hold more clients than one, but are no part of a recording. */
bool limits_bodies(service *s, const session *c, bool is_new, wire_refusal *why)
{
    if (!s->config.max_client_bodies) return true;
    return !is_new || !apply_limit(s, c->body_count, s->config.max_client_bodies, "max_client_bodies", why);
}

bool limits_shapes(service *s, const session *c, size_t instead_of, size_t more, wire_refusal *why)
{
    size_t after = c->shape_count - instead_of + more;
    if (!s->config.max_client_shapes) return true;
    return !more || !apply_limit(s, after - 1, s->config.max_client_shapes, "max_client_shapes", why);
}

bool limits_subscriptions(service *s, const session *c, wire_refusal *why)
{
    if (!s->config.max_client_subscriptions) return true;
    return !apply_limit(s, c->subscription_count, s->config.max_client_subscriptions, "max_client_subscriptions", why);
}

bool limits_geometry(service *s, const session *c, const wire_geometry *m, wire_refusal *why)
{
    int64_t bytes = geometry_bytes(m->vertex_numbers, m->index_numbers), mib = INT64_C(1) << 20;
    int64_t after = (c ? c->geometry_bytes : 0) + bytes;
    return !apply_limit(s, (size_t)((after - 1) / mib), s->config.max_client_geometry, "max_client_geometry", why);
}

/* May this refusal be reported to its client? It is counted in any case. */
bool limits_report_reject(service *s, int64_t client)
{
    session *c = session_find(s, client);
    int64_t reported = flow_add(c ? &c->rejects : &s->rejects, s->monotonic_ns, 1);
    if (reported <= REJECTS_REPORTED) return true;
    metric_count(s->count.rejects_untold, 1);
    return false;
}
