/* keeper: the library's own thread. It receives acks, rejects and status, repeats what is due and sends heartbeats. It
 * holds the client's mutex except while it sleeps, and runs no callback. */
#include "announce.h"
#include "message.h"
#include "session.h"
#include "session_run.h"

#include <poll.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

/* A sequence beyond ours: an earlier process under this id counted further, since the clock that the numbers begin from
 * was set back. The daemon takes ours for copies; so we count on from there, and say everything again. */
static void count_on_from(collided *c, int64_t sequence)
{
    if (sequence > INT64_MAX / 2) return; /* no clock begins there */
    c->sequence = sequence;
    announce_all_again(c);
}

/* The daemon has heard that we are here. If it had not for a lease, it has lost us meanwhile, and its word of that was
 * lost like the others. A heartbeat comes three times a lease, so that this takes two unanswered ones at least. */
static void take_sign_of_hearing(collided *c)
{
    int64_t now = session_monotonic_ns(), since = c->acknowledged_ns;
    c->acknowledged_ns = now;
    if (c->link->ops->repeats && since && now - since > c->lease_ns - c->lease_ns / 10) c->all_again_wanted = true;
}

static void take_ack(collided *c, const wire_ack *ack)
{
    if (ack->client != c->id || !session_hear(c, ack->epoch)) return;
    for (uint32_t i = 0; i < ack->sequences.count; i++) {
        int64_t sequence = ack->sequences.at[i];
        if (sequence == c->heartbeat || announce_find(c, sequence) == &c->client) take_sign_of_hearing(c);
        if (sequence > c->sequence)
            count_on_from(c, sequence);
        else
            announce_acked(c, sequence);
    }
}

static void take_reject(collided *c, const wire_message *m)
{
    const wire_reject *why = &m->reject;
    if (why->client != c->id || !session_hear(c, why->epoch)) return;
    if (why->reason == WIRE_UNHEARD) {
        unheard_reported(c, why);
        return;
    }
    if (why->kind != WIRE_QUERY) {
        announce_rejected(c, why);
        return;
    }
    if (why->reason == WIRE_UNKNOWN_CLIENT) announce_rejected(c, why); /* we are announced again */
    if (why->sequence != c->query || c->query_reject) return;          /* of a query that is no longer waited for */
    c->query_reject = message_copy(m);
    session_wake_caller(c);
}

/* Of a pair, the daemon that we hear tells of the other one there: a standby has to hear us, too. */
static void seek_another(collided *c, const wire_status *s)
{
    if (c->status && strcmp(c->status->status.links, s->links) != 0 && c->link->ops->seek) c->link->ops->seek(c->link);
}

static int64_t counter_of(const wire_status *s, const char *name)
{
    for (size_t i = 0; i < s->counter_names.count; i++)
        if (strcmp(s->counter_names.at[i], name) == 0) return s->counter_values.at[i];
    return 0;
}

static void keeper_message(void *context, const wire_message *m)
{
    collided *c = context;
    if (m->kind == WIRE_ACK) take_ack(c, &m->ack);
    if (m->kind == WIRE_REJECT) take_reject(c, m);
    if (m->kind != WIRE_STATUS || !session_hear_status(c, &m->status)) return;
    seek_another(c, &m->status);
    bool first = !c->status || c->status->status.epoch != m->status.epoch; /* it may be waited for */
    free(c->status);
    c->status = message_copy(m);
    c->crowd = counter_of(&m->status, "clients");
    if (first) session_wake_caller(c);
}

static void keeper_refused(void *context, const wire_refusal *why)
{
    (void)why;
    ((collided *)context)->counters.malformed++;
}

/* The same words under a new sequence: a sign of life, not an announcement that waits for an answer. */
static int64_t heartbeat(collided *c, int64_t now_ns)
{
    if (!c->link->ops->repeats || c->client.message->client.removed) return INT64_MAX;
    if (now_ns < c->heartbeat_ns) return c->heartbeat_ns;
    c->heartbeat_ns = now_ns + c->lease_ns / 3;
    if (c->client.state == ANNOUNCE_ACKED) {
        wire_message m = *c->client.message;
        m.client.sequence = c->heartbeat = ++c->sequence;
        (void)session_send(c, &m);
    }
    return c->heartbeat_ns;
}

/* A daemon tells its status once a second. Each search costs a datagram a well-known port, and a thousand clients that
 * search often leave the daemon no time to speak, nor to hear them: so they do it less and less often, and the later
 * the more of them there are, of which a status that comes late is the first sign that the machine has no time. */
static const int64_t QUIET_NS = 1200 * NS_PER_MS, SEEK_FIRST_NS = 300 * NS_PER_MS, SEEK_LAST_NS = 4 * NS_PER_S,
                     CROWD_NS = 4 * NS_PER_MS /* later for each client, */;

static int64_t later_ns(const collided *c)
{
    const int64_t most = 2000;
    return CROWD_NS * (c->crowd < 0 ? 0 : c->crowd < most ? c->crowd : most);
}

static int64_t seek(collided *c, int64_t now_ns)
{
    if (!c->link->ops->seek) return INT64_MAX;
    int64_t later = later_ns(c), quiet = QUIET_NS + later, first = SEEK_FIRST_NS + later, last = SEEK_LAST_NS + later;
    if (c->last_seen_ns && now_ns - c->last_seen_ns < quiet) {
        c->seek_ns = 0;
        c->seek_wait_ns = first;
        return c->last_seen_ns + quiet;
    }
    if (c->seek_ns && now_ns < c->seek_ns) return c->seek_ns;
    if (c->seek_ns) c->link->ops->seek(c->link);
    c->seek_wait_ns = c->seek_ns ? 2 * c->seek_wait_ns : first;
    if (c->seek_wait_ns > last) c->seek_wait_ns = last;
    return c->seek_ns = now_ns + c->seek_wait_ns;
}

/* Sleeps at most a third of the lease, so that a longer absence shows that the process stood still (SIGSTOP, swap):
 * the daemon has lost us meanwhile, and wants to be told everything again. */
static void keeper_sleep_until(collided *c, int64_t now_ns, int64_t when_ns)
{
    int64_t longest = c->lease_ns / 3;
    int64_t left = when_ns - now_ns < longest ? when_ns - now_ns : longest;
    if (left < 0) left = 0;
    struct timespec timeout = {.tv_sec = left / NS_PER_S, .tv_nsec = left % NS_PER_S};
    struct pollfd fds[] = {{c->link->ops->fd(c->link, TRANSPORT_CONTROL), POLLIN, 0}, {c->keeper_wake, POLLIN, 0}};
    (void)ppoll(fds, 2, &timeout, NULL);
    uint64_t count;
    if (fds[1].revents & POLLIN && read(c->keeper_wake, &count, sizeof count) < 0) fds[1].revents = 0;
}

void *keeper_run(void *client)
{
    collided *c = client;
    const transport_sink sink = {.context = c, .message = keeper_message, .refused = keeper_refused};
    pthread_mutex_lock(&c->lock);
    while (!c->stopping) {
        c->link->ops->receive(c->link, TRANSPORT_CONTROL, &sink);
        int64_t now = session_monotonic_ns();
        int64_t repeat = announce_tend(c, now), beat = heartbeat(c, now), word = unheard_tend(c, now);
        int64_t look = seek(c, now);
        if (beat < repeat) repeat = beat;
        if (look < repeat) repeat = look;
        c->link->ops->flush(c->link);
        pthread_mutex_unlock(&c->lock);
        if (c->link->ops->retire) c->link->ops->retire(c->link);
        keeper_sleep_until(c, now, repeat < word ? repeat : word);
        pthread_mutex_lock(&c->lock);
        if (session_monotonic_ns() - now > c->lease_ns) {
            c->counters.stalls++;
            announce_all_again(c);
        }
    }
    pthread_mutex_unlock(&c->lock);
    return NULL;
}
