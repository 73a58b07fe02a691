/* The same program over both real transports, against a tiny daemon in a second process, in a network namespace. */
#include "daemon.h"

#include "cmocka_c.h"

#include <collided.h>
#include <pthread.h>
#include <signal.h>
#include <stdio.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

static bool isolated;

wire_message daemon_status(void)
{
    return (wire_message){.kind = WIRE_STATUS,
        .status = {.version = WIRE_VERSION,
            .epoch = 3,
            .health = WIRE_HEALTH_READY,
            .daemon = "tiny:1",
            .release = "0",
            .links = "test",
            .limits = ""}};
}

static void acknowledge(const wire_message *m, daemon_send *send, void *context)
{
    int64_t client, sequence;
    int32_t object;
    wire_origin(m, &client, &sequence, &object);
    const wire_message ack = {.kind = WIRE_ACK, .ack = {WIRE_VERSION, client, 3, {1, &sequence}}};
    send(context, &ack);
}

static void snapshot(const wire_subscription *subscription, daemon_send *send, void *context)
{
    const wire_message m = {.kind = WIRE_EVENT_BATCH,
        .event_batch = {.version = WIRE_VERSION,
            .client = subscription->client,
            .subscription = subscription->subscription,
            .epoch = 3,
            .batch = 1,
            .snapshot = 1,
            .parts = 1,
            .stream = subscription->stream}};
    send(context, &m);
}

static void reply(const wire_query *query, daemon_send *send, void *context)
{
    const wire_message m = {.kind = WIRE_ANSWER,
        .answer = {.version = WIRE_VERSION,
            .client = query->client,
            .sequence = query->sequence,
            .epoch = 3,
            .kind = query->kind,
            .text = "tiny"}};
    send(context, &m);
}

void daemon_react(daemon_state *d, const wire_message *m, daemon_send *send, void *context)
{
    switch (m->kind) {
    case WIRE_CLIENT:
        atomic_fetch_add(&d->clients, 1);
        atomic_fetch_add(&d->clients_left, m->client.removed);
        break;
    case WIRE_BODY:
        atomic_fetch_add(m->body.removed ? &d->removed : &d->bodies, 1);
        break;
    case WIRE_POSE_BATCH:
        atomic_fetch_add(&d->poses, (int)m->pose_batch.bodies.count);
        atomic_store(&d->last_x, m->pose_batch.positions.at[0]);
        return;
    case WIRE_QUERY:
        atomic_fetch_add(&d->queries, 1);
        reply(&m->query, send, context);
        return;
    default:
        break;
    }
    acknowledge(m, send, context);
    if (m->kind != WIRE_SUBSCRIPTION || m->subscription.removed) return;
    atomic_fetch_add(&d->subscriptions, 1);
    snapshot(&m->subscription, send, context);
}

static void note(void *context, const collided_batch *b)
{
    *(int *)context += b->snapshot && b->batch == 1 && b->lost == 0;
}

static collided_body make(collided *c, const char *name)
{
    const collided_shape ball = collided_sphere(0.1);
    collided_body_def def = collided_body_def_default();
    def.name = name;
    def.shapes = &ball;
    def.shape_count = 1;
    return collided_create_body(c, &def);
}

#define PATIENCE_S 30.0

static collided *connect_to(const char *uri, bool on_arrival)
{
    collided_def def = collided_def_default();
    def.connect_timeout_s = PATIENCE_S;
    def.lease_s = 3600; /* a machine that stands still for a moment costs no second announcement */
    def.on_arrival = on_arrival;
    collided *c = collided_connect(uri, &def);
    if (!c) fail_msg("%s", collided_connect_error());
    return c;
}

/* The daemon is another process: it counts in its own time. */
static void await(const _Atomic int *count, int least)
{
    for (int ms = 0; ms < 1000 * PATIENCE_S && atomic_load(count) < least; ms++) (void)usleep(1000);
    assert_in_range(atomic_load(count), least, INT32_MAX);
}

/* What a user does, from connecting to leaving. */
static void use_daemon(const char *uri, daemon_state *d)
{
    collided *c = connect_to(uri, false);
    collided_body body = make(c, "part");
    collided_pose pose = collided_pose_identity();
    pose.position[0] = 42.0;
    assert_int_equal(collided_move(c, body, pose), COLLIDED_OK); /* waits for the acknowledgement by itself */
    assert_int_equal(collided_sync(c, PATIENCE_S), COLLIDED_OK);
    int snapshots = 0;
    collided_subscription_def subscription = collided_subscription_def_default();
    subscription.callback = note;
    subscription.context = &snapshots;
    collided_subscription watched = collided_subscribe(c, &subscription);
    for (int i = 0; i < 10 * PATIENCE_S && !snapshots; i++) assert_int_equal(collided_poll(c, 0.1), COLLIDED_OK);
    assert_true(snapshots >= 1); /* again where the acknowledgement of the subscription was slow, and it came twice */
    collided_result answer;
    assert_int_equal(collided_query_bodies(c, "*", PATIENCE_S, &answer), COLLIDED_OK);
    assert_string_equal(answer.text, "tiny");
    collided_result_free(&answer);
    collided_daemon_status status;
    assert_int_equal(collided_get_status(c, PATIENCE_S, &status), COLLIDED_OK);
    assert_string_equal(status.daemon, "tiny:1");
    assert_int_equal(collided_unsubscribe(c, watched), COLLIDED_OK);
    assert_int_equal(collided_sync(c, PATIENCE_S), COLLIDED_OK);
    collided_close(c);
    await(&d->removed, 1); /* more than once where an acknowledgement was slow */
    await(&d->clients_left, 1);
    assert_int_equal(atomic_load(&d->poses), 1);
    assert_true(atomic_load(&d->last_x) == 42.0);
    assert_int_equal(atomic_load(&d->malformed), 0);
}

typedef struct listener {
    collided *c;
    collided_body body;
    pthread_t polls;
    int batches, elsewhere; /* of those, on another thread than the one that polls */
    collided_status published, polled;
    int32_t subscribed;
} listener;

static void answer(void *context, const collided_batch *b)
{
    listener *l = context;
    (void)b;
    const collided_subscription_def subscription = {.callback = answer};
    l->batches++;
    l->elsewhere += !pthread_equal(pthread_self(), l->polls);
    l->published = collided_move(l->c, l->body, collided_pose_identity());
    l->polled = collided_poll(l->c, 0);
    if (l->elsewhere) l->subscribed = collided_subscribe(l->c, &subscription).id;
}

/* A stream after another, until a callback has run on the thread that its batch came on. */
static void use_on_arrival(const char *uri, daemon_state *d)
{
    listener l = {.c = connect_to(uri, true), .polls = pthread_self()};
    l.body = make(l.c, "part");
    assert_int_equal(collided_sync(l.c, PATIENCE_S), COLLIDED_OK);
    for (int k = 0; k < 60 && !l.elsewhere; k++) {
        collided_subscription_def subscription = collided_subscription_def_default();
        subscription.callback = answer;
        subscription.context = &l;
        collided_subscription watched = collided_subscribe(l.c, &subscription);
        int before = l.batches;
        for (int i = 0; i < 10 * PATIENCE_S && l.batches == before; i++)
            assert_int_equal(collided_poll(l.c, 0.1), COLLIDED_OK);
        assert_true(l.batches > before);
        assert_int_equal(l.published, COLLIDED_OK);
        assert_int_equal(l.polled, COLLIDED_BAD_ARGUMENT);
        assert_int_equal(collided_unsubscribe(l.c, watched), COLLIDED_OK);
    }
    assert_true(l.elsewhere > 0);
    assert_int_equal(l.subscribed, COLLIDED_NONE);
    assert_int_equal(collided_sync(l.c, PATIENCE_S), COLLIDED_OK);
    collided_result answered;
    assert_int_equal(collided_query_bodies(l.c, "*", PATIENCE_S, &answered), COLLIDED_OK);
    collided_result_free(&answered);
    collided_close(l.c);
    await(&d->poses, l.batches);
    assert_int_equal(atomic_load(&d->poses), l.batches);
}

/* The daemon is a process of its own, as in life; the two share its counters. */
static void with_daemon(void *(*run)(void *), void (*use)(const char *uri, daemon_state *d), const char *uri)
{
    daemon_state *d = mmap(NULL, sizeof *d, PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0);
    assert_ptr_not_equal(d, MAP_FAILED);
    pid_t pid = fork();
    assert_true(pid >= 0);
    if (pid == 0) {
        prctl(PR_SET_PDEATHSIG, SIGKILL); /* a test that fails leaves nobody behind */
        run(d);
        _exit(0);
    }
    use(uri, d);
    atomic_store(&d->stop, true);
    int status = 0;
    assert_int_equal(waitpid(pid, &status, 0), pid);
    assert_int_equal(status, 0);
    (void)munmap(d, sizeof *d);
}

static void a_client_works_over_lcm(void **state)
{
    (void)state;
    if (!isolated) skip();
    with_daemon(daemon_lcm, use_daemon, "lcm://");
}

static void a_client_works_over_dds(void **state)
{
    (void)state;
    if (!isolated) skip();
    with_daemon(daemon_dds, use_daemon, "dds://7");
}

static void callbacks_may_run_where_events_arrive(void **state)
{
    (void)state;
    if (!isolated) skip();
    with_daemon(daemon_dds, use_on_arrival, "dds://7");
}

static void two_clients_share_a_domain(void **state)
{
    (void)state;
    if (!isolated) skip();
    collided_def def = collided_def_default();
    def.connect_timeout_s = 0.0;
    collided *a = collided_connect("dds://8", &def), *b = collided_connect("dds://8", &def);
    assert_non_null(a);
    assert_non_null(b);
    collided_close(a);
    assert_int_not_equal(make(b, "part").id, COLLIDED_NONE); /* the first one's leaving did not take the domain away */
    collided_close(b);
}

int main(void)
{
    (void)setvbuf(stdout, NULL, _IOLBF, 0);
    isolated = namespace_enter();
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_client_works_over_lcm),
        cmocka_unit_test(a_client_works_over_dds),
        cmocka_unit_test(callbacks_may_run_where_events_arrive),
        cmocka_unit_test(two_clients_share_a_domain),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
