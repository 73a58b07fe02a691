/* Clients of a daemon in this process, over a transport that loses, doubles, delays and reorders in both directions.
 * They create, change, move and remove bodies, subscribe and unsubscribe, leave and come back under the same id, and
 * give free names and streams to the next one at once. Then the network is a good one, and the daemon has to come to
 * know what they want, and nothing else; and nothing of it may have been refused. What is lost and when differs from
 * run to run. */
#include "base/log.h"
#include "base/prng.h"
#include "cmocka_c.h"
#include "link/link_memory.h"
#include "message.h"
#include "service/config.h"
#include "service/server.h"
#include "session.h"
#include "session_run.h"

#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/eventfd.h>
#include <unistd.h>

enum { CLIENTS = 2, BODIES = 8, STREAMS = 3, FLYING_MAX = 1 << 14, ROUNDS = 4, OPERATIONS = 150 };
static const double PATIENCE_S = 30;

/* ---- the network ---- */

typedef struct flying {
    int64_t due_ns;
    wire_message *message;
} flying;

typedef struct flight {
    flying at[FLYING_MAX];
    size_t count;
} flight;

typedef struct lossy {
    transport head;
    pthread_mutex_t lock;
    pthread_t pump;
    bool stop;
    memory_end *end;
    wire_memory *memory;
    uint64_t random;
    flight out, in, come[TRANSPORT_ROLES];
    int fds[TRANSPORT_ROLES];
} lossy;

static transport_ops lossy_ops;
static atomic_bool stormy;

static bool chance(lossy *l, unsigned in_a_hundred)
{
    return stormy && prng_bits(&l->random) % 100 < in_a_hundred;
}

static void put(flight *f, int64_t due_ns, wire_message *m)
{
    assert_true(f->count < FLYING_MAX);
    f->at[f->count++] = (flying){due_ns, m};
}

static void take_off(lossy *l, flight *f, const wire_message *m)
{
    int64_t now = session_monotonic_ns();
    if (chance(l, 15)) return;
    for (int copies = chance(l, 15) ? 2 : 1; copies; copies--) {
        int64_t delay_ms = chance(l, 50) ? (int64_t)(prng_bits(&l->random) % (chance(l, 5) ? 200 : 20)) : 0;
        put(f, now + delay_ms * NS_PER_MS, message_copy(m));
    }
}

static void land(lossy *l, wire_message *m)
{
    bool streams = m->kind == WIRE_ANSWER || m->kind == WIRE_EVENT_BATCH;
    transport_role role = streams ? TRANSPORT_STREAMS : TRANSPORT_CONTROL;
    uint64_t one = 1;
    put(&l->come[role], 0, m);
    assert_int_equal(write(l->fds[role], &one, sizeof one), sizeof one);
}

static void land_due(lossy *l, flight *f, int64_t now_ns)
{
    size_t left = 0;
    for (size_t i = 0; i < f->count; i++) {
        if (f->at[i].due_ns > now_ns) {
            f->at[left++] = f->at[i];
        } else if (f == &l->out) {
            memory_send(l->end, f->at[i].message);
            free(f->at[i].message);
        } else {
            land(l, f->at[i].message);
        }
    }
    f->count = left;
}

static bool pump_once(lossy *l)
{
    wire_message m;
    pthread_mutex_lock(&l->lock);
    for (; memory_receive(l->end, l->memory, &m); wire_memory_reset(l->memory)) take_off(l, &l->in, &m);
    int64_t now = session_monotonic_ns();
    land_due(l, &l->out, now);
    land_due(l, &l->in, now);
    bool stop = l->stop;
    pthread_mutex_unlock(&l->lock);
    return !stop;
}

static void *pump(void *context)
{
    while (pump_once(context)) (void)usleep(300);
    return NULL;
}

static transport *lossy_open(const transport_options *options, char *why, size_t why_size)
{
    static uint64_t seeds = 7;
    (void)options;
    (void)why;
    (void)why_size;
    lossy *l = calloc(1, sizeof *l);
    l->head.ops = &lossy_ops;
    l->random = prng_bits(&seeds);
    pthread_mutex_init(&l->lock, NULL);
    l->end = memory_connect("cell");
    l->memory = wire_memory_create();
    for (int role = 0; role < TRANSPORT_ROLES; role++) l->fds[role] = eventfd(0, EFD_NONBLOCK | EFD_CLOEXEC);
    assert_int_equal(pthread_create(&l->pump, NULL, pump, l), 0);
    return &l->head;
}

static void drop(flight *f)
{
    for (size_t i = 0; i < f->count; i++) free(f->at[i].message);
}

/* What is under way arrives, although its sender is gone. */
static void lossy_close(transport *t)
{
    lossy *l = (lossy *)t;
    pthread_mutex_lock(&l->lock);
    l->stop = true;
    pthread_mutex_unlock(&l->lock);
    pthread_join(l->pump, NULL);
    land_due(l, &l->out, INT64_MAX);
    drop(&l->in);
    for (int role = 0; role < TRANSPORT_ROLES; role++) drop(&l->come[role]);
    for (int role = 0; role < TRANSPORT_ROLES; role++) close(l->fds[role]);
    memory_disconnect(l->end);
    wire_memory_destroy(l->memory);
    pthread_mutex_destroy(&l->lock);
    free(l);
}

static int lossy_send(transport *t, const wire_message *m)
{
    lossy *l = (lossy *)t;
    pthread_mutex_lock(&l->lock);
    take_off(l, &l->out, m);
    pthread_mutex_unlock(&l->lock);
    return 0;
}

static void lossy_receive(transport *t, transport_role role, const transport_sink *sink)
{
    lossy *l = (lossy *)t;
    uint64_t count;
    while (read(l->fds[role], &count, sizeof count) > 0) continue;
    for (;;) {
        flight *f = &l->come[role];
        pthread_mutex_lock(&l->lock);
        wire_message *m = f->count ? f->at[0].message : NULL;
        if (m) memmove(f->at, f->at + 1, --f->count * sizeof f->at[0]);
        pthread_mutex_unlock(&l->lock);
        if (!m) return;
        sink->message(sink->context, m);
        free(m);
    }
}

static void lossy_flush(transport *t)
{
    (void)t;
}

static void lossy_drain(transport *t, int64_t timeout_ns)
{
    (void)t;
    (void)timeout_ns;
}

static bool lossy_ready(transport *t)
{
    (void)t;
    return true;
}

static int lossy_fd(transport *t, transport_role role)
{
    return ((lossy *)t)->fds[role];
}

static int lossy_stream_open(transport *t, const char *stream)
{
    (void)t;
    (void)stream;
    return 0;
}

static void lossy_stream_close(transport *t, const char *stream)
{
    (void)t;
    (void)stream;
}

static transport_ops lossy_ops = {.scheme = "lossy",
    .repeats = true,
    .poses_max = 600,
    .open = lossy_open,
    .send = lossy_send,
    .flush = lossy_flush,
    .drain = lossy_drain,
    .ready = lossy_ready,
    .fd = lossy_fd,
    .receive = lossy_receive,
    .stream_open = lossy_stream_open,
    .stream_close = lossy_stream_close,
    .close = lossy_close};

/* ---- clients, and what they want ---- */

typedef struct part {
    bool there, fixed;
    collided_body body;
    char name[16];
    double x;
} part;

typedef struct reading {
    bool wanted, heard;
    collided_subscription subscription;
    char stream[16];
    size_t contacts;
} reading;

typedef struct one {
    int number;
    collided *client;
    part parts[BODIES];
    reading readings[STREAMS];
} one;

static uint64_t fate = 1;

static unsigned draw(unsigned below)
{
    return (unsigned)(prng_bits(&fate) % below);
}

static void hear(void *context, const collided_batch *b)
{
    reading *r = context;
    if (b->snapshot) r->contacts = 0;
    r->heard |= b->snapshot;
    for (size_t i = 0; i < b->event_count; i++) {
        if (b->events[i].kind == COLLIDED_END && !r->contacts) fail_msg("%s: an end of nothing", r->stream);
        r->contacts += b->events[i].kind == COLLIDED_BEGIN;
        r->contacts -= b->events[i].kind == COLLIDED_END;
    }
}

static void refused(void *context, const collided_rejection *why)
{
    const one *o = context;
    fail_msg("client %d: %s %d: %s: %s", o->number, why->message, why->object, why->reason, why->text);
}

static void join(one *o)
{
    char why[256] = "";
    collided_def def = collided_def_default();
    def.id = 1000 + o->number;
    def.lease_s = 3600;
    def.connect_timeout_s = PATIENCE_S;
    o->client = session_open(&lossy_ops, "", &def, why, sizeof why);
    if (!o->client) fail_msg("%s", why);
    collided_on_rejected(o->client, refused, o);
}

/* Its last words arrive, and behind them what is still on its way. */
static void leave_and_come_back(one *o)
{
    stormy = false;
    collided_close(o->client);
    stormy = true;
    memset(o->parts, 0, sizeof o->parts);
    memset(o->readings, 0, sizeof o->readings);
    join(o);
}

/* One of three names a part, so that what has left is often followed by what has its name. */
static void put_part(one *o, int i, bool anew)
{
    part *p = &o->parts[i];
    collided_shape ball = collided_sphere(0.1 + 0.1 * draw(3));
    collided_body_def def = collided_body_def_default();
    if (anew) *p = (part){.there = true, .fixed = draw(2), .x = 10 * o->number + 0.5 * draw(16)};
    (void)snprintf(p->name, sizeof p->name, "c%d.%u", o->number, 3 * (unsigned)i + draw(3));
    def.id = i + BODIES * (int32_t)draw(3);
    def.name = p->name;
    def.motion = p->fixed ? COLLIDED_FIXED : COLLIDED_MOVING;
    def.shapes = &ball;
    def.shape_count = 1;
    def.pose.position[0] = p->x;
    if (anew)
        p->body = collided_create_body(o->client, &def);
    else
        assert_int_equal(collided_change_body(o->client, p->body, &def), COLLIDED_OK);
    assert_int_not_equal(p->body.id, COLLIDED_NONE);
}

static void move(one *o, int i, double x)
{
    part *p = &o->parts[i];
    collided_pose pose = collided_pose_identity();
    pose.position[0] = p->x = x;
    if (p->there && !p->fixed) assert_int_equal(collided_move(o->client, p->body, pose), COLLIDED_OK);
}

static void create_or_remove(one *o, int i)
{
    bool was = o->parts[i].there;
    if (was) assert_int_equal(collided_remove_body(o->client, o->parts[i].body), COLLIDED_OK);
    o->parts[i].there = false;
    if (!was || draw(2)) put_part(o, i, true);
}

static void subscribe_or_not(one *o, int k)
{
    reading *r = &o->readings[k];
    bool was = r->wanted;
    if (was) assert_int_equal(collided_unsubscribe(o->client, r->subscription), COLLIDED_OK);
    *r = (reading){.wanted = !was || draw(2)};
    (void)snprintf(r->stream, sizeof r->stream, "s%d.%d", o->number, k);
    collided_subscription_def def = collided_subscription_def_default();
    def.stream = r->stream;
    def.callback = hear;
    def.context = r;
    if (r->wanted) r->subscription = collided_subscribe(o->client, &def);
}

static void operate(one *o)
{
    int i = (int)draw(BODIES), k = (int)draw(STREAMS);
    unsigned what = draw(512);
    if (what < 1)
        leave_and_come_back(o);
    else if (what < 96)
        create_or_remove(o, i);
    else if (what < 144 && o->parts[i].there)
        put_part(o, i, false);
    else if (what < 176)
        subscribe_or_not(o, k);
    else if (what < 192)
        (void)usleep(draw(5000));
    else if (o->parts[i].there && !o->parts[i].fixed)
        move(o, i, 10 * o->number + 0.5 * draw(16));
    (void)collided_poll(o->client, 0);
}

/* ---- what the daemon knows ---- */

static bool knows_bodies(one *o)
{
    char pattern[16];
    collided_result r;
    size_t wanted = 0, found = 0;
    (void)snprintf(pattern, sizeof pattern, "c%d.*", o->number);
    assert_int_equal(collided_query_bodies(o->client, pattern, PATIENCE_S, &r), COLLIDED_OK);
    for (const part *p = o->parts; p < o->parts + BODIES; p++) {
        wanted += p->there;
        for (size_t i = 0; p->there && i < r.count; i++)
            found += strcmp(p->name, r.hits[i].name_a) == 0 && r.hits[i].point_a[0] == p->x;
    }
    bool same = found == wanted && r.count == wanted;
    collided_result_free(&r);
    return same;
}

static int64_t counter(collided *c, const char *name)
{
    collided_daemon_status s;
    if (collided_get_status(c, PATIENCE_S, &s) != COLLIDED_OK) return -1;
    for (size_t i = 0; i < s.counter_count; i++)
        if (strcmp(s.counters[i].name, name) == 0) return s.counters[i].value;
    return -1;
}

static bool knows_all(one *all)
{
    int64_t wanted = 0, contacts = 0;
    bool same = true;
    for (one *o = all; o < all + CLIENTS; o++) {
        for (int i = 0; i < BODIES; i++) move(o, i, o->parts[i].x); /* the last one may have been lost */
        (void)collided_poll(o->client, 0.05);
        same = same && knows_bodies(o);
        for (const reading *r = o->readings; r < o->readings + STREAMS; r++) {
            wanted += r->wanted;
            contacts += (int64_t)(r->wanted ? r->contacts : 0);
            same = same && r->heard == r->wanted;
        }
    }
    return same && counter(all->client, "subscriptions") == wanted && counter(all->client, "contacts") == contacts;
}

static void *run(void *server)
{
    server_run(server);
    return NULL;
}

static pthread_t thread;

static server *start(void)
{
    char why[256] = "";
    config c;
    config_default(&c);
    c.workers = 1;
    c.status_period = 0.05;
    c.heartbeat = 0.2;
    (void)snprintf(c.links, sizeof c.links, "memory://cell");
    log_setup(LOG_ERROR, 0);
    server *s = server_create(&c, why, sizeof why);
    if (!s) fail_msg("%s", why);
    assert_int_equal(pthread_create(&thread, NULL, run, s), 0);
    return s;
}

static void stop(server *s)
{
    server_stop(s);
    pthread_join(thread, NULL);
    server_destroy(s);
}

static void a_daemon_comes_to_know_what_is_wanted(void **state)
{
    (void)state;
    server *s = start();
    static one all[CLIENTS];
    for (int k = 0; k < CLIENTS; k++) all[k].number = k;
    for (int k = 0; k < CLIENTS; k++) join(&all[k]);
    int rounds = getenv("COLLIDED_NIGHTLY") ? 20 * ROUNDS : getenv("COLLIDED_BRIEF") ? 1 : ROUNDS;
    for (int round = 0; round < rounds; round++) {
        stormy = true;
        for (int n = 0; n < OPERATIONS; n++) operate(&all[draw(CLIENTS)]);
        stormy = false;
        for (int k = 0; k < CLIENTS; k++) assert_int_equal(collided_sync(all[k].client, PATIENCE_S), COLLIDED_OK);
        int64_t until = session_monotonic_ns() + session_seconds(PATIENCE_S);
        while (!knows_all(all))
            if (session_monotonic_ns() > until) fail_msg("round %d: it does not know what is wanted", round);
    }
    for (int k = 0; k < CLIENTS; k++) collided_close(all[k].client);
    stop(s);
}

/* More contacts than go out at once, and all that is sent is in the storm: parts of the snapshot are lost, doubled and
 * out of order, and so are receipts. Meanwhile one of the bodies comes and goes. */
static void a_large_snapshot_comes_through_a_storm(void **state)
{
    (void)state;
    enum { BALLS = 80, PAIRS = BALLS * (BALLS - 1) / 2 };
    server *s = start();
    one o = {.number = 0};
    collided_body balls[BALLS];
    stormy = false;
    join(&o);
    for (int i = 0; i < BALLS; i++) {
        char name[16];
        (void)snprintf(name, sizeof name, "ball %d", i);
        collided_shape ball = collided_sphere(1);
        collided_body_def def = collided_body_def_default();
        def.name = name;
        def.shapes = &ball;
        def.shape_count = 1;
        balls[i] = collided_create_body(o.client, &def);
    }
    assert_int_equal(collided_sync(o.client, PATIENCE_S), COLLIDED_OK);
    reading *r = &o.readings[0];
    collided_subscription_def def = collided_subscription_def_default();
    def.callback = hear;
    def.context = r;
    (void)snprintf(r->stream, sizeof r->stream, "balls");
    stormy = true;
    assert_int_not_equal(collided_subscribe(o.client, &def).id, COLLIDED_NONE);
    int64_t until = session_monotonic_ns() + 2 * session_seconds(PATIENCE_S);
    size_t expected = 0;
    for (int n = 0; n < 10 || r->contacts != expected; n++) {
        collided_pose pose = collided_pose_identity();
        bool apart = n % 2 && n < 10;
        pose.position[0] = apart ? 100 : 0;
        expected = apart ? PAIRS - (BALLS - 1) : PAIRS;
        assert_int_equal(collided_move(o.client, balls[0], pose), COLLIDED_OK);
        (void)collided_poll(o.client, 0.05);
        if (session_monotonic_ns() > until) fail_msg("%zu of %d contacts are known", r->contacts, PAIRS);
    }
    stormy = false;
    collided_close(o.client);
    stop(s);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(a_daemon_comes_to_know_what_is_wanted),
        cmocka_unit_test(a_large_snapshot_comes_through_a_storm)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
