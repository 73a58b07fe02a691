/* session_run: opening and closing a client, waiting, and what the two threads tell each other. The caller's thread,
 * unless a function says that it wants the lock. */
#include "session_run.h"

#include "allocate.h"
#include "announce.h"
#include "loop.h"
#include "message.h"

#include <errno.h>
#include <poll.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/eventfd.h>
#include <sys/random.h>
#include <time.h>
#include <unistd.h>

/* Within one line a smaller epoch is of a daemon whose standby has taken over. */
static bool is_of_another(const collided *c, int64_t epoch, int64_t now_ns)
{
    bool silent = c->over == c->epoch || now_ns - c->last_seen_ns >= SESSION_SILENCE_NS;
    if (epoch == c->over && epoch != c->epoch) return true;
    return epoch < c->epoch && (!silent || wire_same_line(epoch, c->epoch));
}

/* A restarted daemon has a greater epoch (it is the time of its start); of two on one network the one with the greater
 * epoch goes on (daemon/service/standby.c). A smaller one is followed only when ours has fallen silent, or has said
 * that it ends, so that two daemons do not make us change sides with every message. Within one line a greater one is of
 * the standby that has taken over, which knows us. */
bool session_hear(collided *c, int64_t epoch)
{
    int64_t now = session_monotonic_ns();
    bool goes_on = wire_same_line(epoch, c->epoch);
    if (is_of_another(c, epoch, now)) {
        c->counters.foreign++;
        return false;
    }
    c->last_seen_ns = now;
    if (epoch == c->epoch) return true;
    bool restarted = c->epoch != 0 && !goes_on;
    c->epoch = epoch;
    if (restarted) announce_to_new_daemon(c);
    session_wake_keeper(c);
    session_wake_caller(c);
    return true;
}

bool session_hear_status(collided *c, const wire_status *s)
{
    if (s->health == WIRE_HEALTH_STOPPING) c->over = s->epoch;
    return session_hear(c, s->epoch);
}

static void report_rejection(collided *c, const collided_rejection *why)
{
    if (!c->on_rejected) return;
    c->in_callback = true;
    c->on_rejected(c->on_rejected_context, why);
    c->in_callback = false;
    c->delivered++;
}

static void deliver_rejections(collided *c)
{
    wire_message *taken[SESSION_REJECTIONS_MAX];
    pthread_mutex_lock(&c->lock);
    size_t count = c->rejection_count;
    memcpy(taken, c->rejections, count * sizeof *taken);
    int64_t overflowed = c->rejections_overflowed;
    c->rejection_count = 0;
    c->rejections_overflowed = 0;
    pthread_mutex_unlock(&c->lock);
    for (size_t i = 0; i < count; i++) {
        const wire_reject *r = &taken[i]->reject;
        report_rejection(c, &(collided_rejection){wire_kind_name((wire_kind)r->kind), r->object,
                                wire_reason_name((wire_reason)r->reason), r->text});
        free(taken[i]);
    }
    if (!overflowed) return;
    char text[64];
    (void)snprintf(text, sizeof text, "%lld further refusals were not kept", (long long)overflowed);
    report_rejection(c, &(collided_rejection){"", COLLIDED_NONE, wire_reason_name(WIRE_LIMIT), text});
}

static void caller_message(void *context, const wire_message *m)
{
    collided *c = context;
    if (m->kind == WIRE_EVENT_BATCH) stream_receive(c, m);
    if (m->kind != WIRE_ANSWER || m->answer.client != c->id) return;
    pthread_mutex_lock(&c->lock);
    bool ours = session_hear(c, m->answer.epoch) && c->query && m->answer.sequence == c->query;
    pthread_mutex_unlock(&c->lock);
    if (ours && !c->answer) c->answer = message_copy(m); /* a repeated query is answered again: the first one counts */
}

static void caller_refused(void *context, const wire_refusal *why)
{
    collided *c = context;
    pthread_mutex_lock(&c->lock);
    c->counters.malformed++;
    pthread_mutex_unlock(&c->lock);
    (void)session_fail(c, COLLIDED_TRANSPORT, "a malformed message came: %s", why->text);
}

/* One turn: everything that has come, then whom it concerns. */
static void turn(collided *c)
{
    const transport_sink sink = {.context = c, .message = caller_message, .refused = caller_refused};
    c->link->ops->receive(c->link, TRANSPORT_STREAMS, &sink);
    deliver_rejections(c);
    subscriptions_sweep(c);
}

static void set_sleeping(collided *c, bool sleeping)
{
    if (!c->on_arrival) return;
    pthread_mutex_lock(&c->turn); /* waits for the end of what a stand-in does */
    c->sleeping = sleeping;
    pthread_mutex_unlock(&c->turn);
}

/* A thread of the transport's: receives for the caller's thread, if that sleeps, and then wakes it, since this may be
 * what it waits for. Streams are opened and closed by the caller's thread alone. */
static bool stand_in(void *context)
{
    collided *c = context;
    const transport_sink sink = {.context = c, .message = caller_message, .refused = caller_refused};
    if (pthread_mutex_trylock(&c->turn) != 0) return false;
    bool sleeps = c->sleeping;
    if (sleeps) c->link->ops->receive(c->link, TRANSPORT_STREAMS, &sink);
    pthread_mutex_unlock(&c->turn);
    if (sleeps) session_wake_caller(c);
    return sleeps;
}

static void caller_sleep_until(collided *c, int64_t when_ns)
{
    int64_t left = when_ns - session_monotonic_ns();
    struct timespec timeout = {.tv_sec = left > 0 ? left / NS_PER_S : 0, .tv_nsec = left > 0 ? left % NS_PER_S : 0};
    struct pollfd fds[] = {{c->link->ops->fd(c->link, TRANSPORT_STREAMS), POLLIN, 0}, {c->caller_wake, POLLIN, 0}};
    set_sleeping(c, true);
    (void)ppoll(fds, 2, &timeout, NULL); /* a signal is one more reason to look */
    set_sleeping(c, false);
    uint64_t count;
    if (fds[1].revents & POLLIN && read(c->caller_wake, &count, sizeof count) < 0)
        (void)session_fail(c, COLLIDED_TRANSPORT, "eventfd: %s", strerror(errno));
}

/* Until something has come or is due. */
void session_sleep(collided *c, int64_t deadline_ns)
{
    int64_t next = stream_next_ns(c);
    if (session_monotonic_ns() < deadline_ns) caller_sleep_until(c, next < deadline_ns ? next : deadline_ns);
}

bool session_wait(collided *c, int64_t deadline_ns, bool (*done)(const collided *c))
{
    for (;;) {
        loop_take_wakes(c);
        turn(c);
        pthread_mutex_lock(&c->lock);
        bool is_done = done(c);
        pthread_mutex_unlock(&c->lock);
        int64_t now = session_monotonic_ns();
        stream_tend(c, now); /* also for who never waits: what is due would never be asked for */
        if (!is_done && now < deadline_ns) {
            session_sleep(c, deadline_ns);
            continue;
        }
        loop_set_timer(c);
        return is_done;
    }
}

static int64_t random_id(void)
{
    int64_t id = 0;
    while (id == 0) {
        if (getrandom(&id, sizeof id, 0) != sizeof id) id = session_now_ns() ^ getpid();
        id &= INT64_MAX;
    }
    return id;
}

static wire_message *client_message(const collided *c, const char *name, uint8_t removed)
{
    const wire_message m = {.kind = WIRE_CLIENT,
        .client = {.version = WIRE_VERSION,
            .client = c->id,
            .removed = removed,
            .on_loss = (uint8_t)c->on_loss,
            .lease_ns = c->lease_ns,
            .lock_step = c->lock_step,
            .name = name}};
    return message_copy(&m);
}

static void free_client(collided *c)
{
    subscriptions_free(c);
    for (announcement *a = c->first; a; a = c->first) {
        bool is_body = a->message->kind == WIRE_BODY;
        announce_drop(c, a);
        if (is_body) table_drop(&c->bodies, ((body_record *)a)->id);
        if (is_body) body_free(c, (body_record *)a);
    }
    robots_free(c);
    bodies_free(c);
    for (geometry_record *g = c->geometries, *next; g; g = next) {
        next = g->next;
        free(g->pieces);
        free(g);
    }
    for (size_t i = 0; i < c->rejection_count; i++) free(c->rejections[i]);
    table_free(&c->bodies);
    table_free(&c->by_sequence);
    free(c->published);
    free(c->status);
    free(c->query_reject);
    free(c->answer);
    free(c->status_shown);
    free(c->status_counters);
    free(c->events);
    free(c->points);
    free(c->impacts);
    soft_gathered_free(c->soft);
    scene_room_free(c->scene);
    loop_end(c);
    if (c->keeper_wake >= 0) close(c->keeper_wake);
    if (c->caller_wake >= 0) close(c->caller_wake);
    pthread_mutex_destroy(&c->lock);
    pthread_mutex_destroy(&c->turn);
    free(c);
}

static collided *new_client(const collided_def *def)
{
    collided *c = allocate(1, sizeof *c);
    pthread_mutex_init(&c->lock, NULL);
    pthread_mutex_init(&c->turn, NULL);
    loop_begin(c);
    c->on_arrival = def->on_arrival;
    c->id = def->id ? def->id : random_id();
    c->lease_ns = session_seconds(def->lease_s);
    c->on_loss = def->on_loss;
    c->lock_step = def->lock_step;
    c->sequence = session_now_ns() / 1000;
    c->last_seen_ns = session_monotonic_ns();
    c->all_again_ns = c->last_seen_ns - NS_PER_S;
    c->keeper_wake = eventfd(0, EFD_NONBLOCK | EFD_CLOEXEC);
    c->caller_wake = eventfd(0, EFD_NONBLOCK | EFD_CLOEXEC);
    return c;
}

bool session_known(const collided *c)
{
    return c->client.state != ANNOUNCE_PENDING && c->link->ops->ready(c->link);
}

static const char *security_of(const collided_def *def)
{
    const char *security = def->security ? def->security : getenv("COLLIDED_SECURITY");
    return security ? security : "";
}

/* True if the daemon knows us, or need not be waited for. */
static bool meet_daemon(collided *c, const collided_def *def, int64_t until_ns, char *why, size_t why_size)
{
    if (!(def->connect_timeout_s > 0.0)) return true;
    if (!session_wait(c, until_ns, session_known)) {
        pthread_mutex_lock(&c->lock);
        if (c->refused)
            (void)snprintf(why, why_size, "the daemon refused this client: %s", c->first_refusal);
        else
            (void)snprintf(why, why_size, "no daemon answered within %g s: is collided running, on this URI?%s",
                def->connect_timeout_s,
                !c->link->ops->permits ? ""
                : *security_of(def)    ? " Of the same site?"
                                       : " If its site is closed: COLLIDED_SECURITY");
        pthread_mutex_unlock(&c->lock);
        return false;
    }
    if (c->client.state == ANNOUNCE_REFUSED) {
        (void)snprintf(why, why_size, "the daemon refused this client: %s", c->first_refusal);
        return false;
    }
    pthread_mutex_lock(&c->lock);
    c->refused = false; /* while another one still spoke under our id */
    pthread_mutex_unlock(&c->lock);
    return true;
}

collided *session_open(
    const transport_ops *ops, const char *address, const collided_def *def, char *why, size_t why_size)
{
    collided *c = new_client(def);
    if (c->keeper_wake < 0 || c->caller_wake < 0) {
        (void)snprintf(why, why_size, "eventfd: %s", strerror(errno));
        free_client(c);
        return NULL;
    }
    int64_t until_ns =
        def->connect_timeout_s > 0 ? session_monotonic_ns() + session_seconds(def->connect_timeout_s) : 0;
    const transport_options options = {.address = address,
        .interface = def->interface ? def->interface : "",
        .security = security_of(def),
        .client = c->id,
        .lease_ns = c->lease_ns,
        .until_ns = until_ns,
        .arrived = c->on_arrival ? stand_in : NULL,
        .arrived_context = c};
    c->link = ops->open(&options, why, why_size);
    if (!c->link) {
        free_client(c);
        return NULL;
    }
    c->last_seen_ns = session_monotonic_ns(); /* opening may have waited: nobody was to be heard until now */
    pthread_mutex_lock(&c->lock);
    announce(c, &c->client, client_message(c, def->name ? def->name : program_invocation_short_name, 0));
    ops->flush(c->link);
    pthread_mutex_unlock(&c->lock);
    int failed = pthread_create(&c->keeper, NULL, keeper_run, c);
    if (failed) {
        (void)snprintf(why, why_size, "pthread_create: %s", strerror(failed));
        ops->close(c->link);
        free_client(c);
        return NULL;
    }
    bool met = meet_daemon(c, def, until_ns, why, why_size);
    if (c->link->ops->joined) c->link->ops->joined(c->link);
    if (met) return c;
    collided_close(c);
    return NULL;
}

static bool nothing_pending(const collided *c)
{
    return c->pending == 0;
}

/* The last words wait for their acknowledgement as long as someone is there to give it, but not for long: the lease
 * covers the rest. */
static void say_goodbye(collided *c)
{
    const int64_t patience_ns = NS_PER_S / 2;
    bool heard = c->epoch != 0 && !session_unheard(c);
    c->link->ops->drain(c->link, heard ? patience_ns : 0);
    pthread_mutex_lock(&c->lock);
    c->on_rejected = NULL;
    if (c->on_loss != COLLIDED_KEEP) bodies_remove_all(c);
    pthread_mutex_unlock(&c->lock);
    if (heard) (void)session_wait(c, session_monotonic_ns() + patience_ns, nothing_pending);
    pthread_mutex_lock(&c->lock);
    announce(c, &c->client, client_message(c, "", 1));
    c->link->ops->flush(c->link);
    pthread_mutex_unlock(&c->lock);
    if (heard) (void)session_wait(c, session_monotonic_ns() + patience_ns, nothing_pending);
}

void collided_close(collided *c)
{
    if (!c || session_from_callback(c)) return; /* which would go on with what is freed here, or wait for itself */
    for (subscription_record *i = c->subscriptions; i; i = i->next) i->removed = true; /* no callbacks from here on */
    say_goodbye(c);
    pthread_mutex_lock(&c->lock);
    c->stopping = true;
    session_wake_keeper(c);
    pthread_mutex_unlock(&c->lock);
    pthread_join(c->keeper, NULL);
    c->link->ops->close(c->link);
    free_client(c);
}
