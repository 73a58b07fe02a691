/* fake: the transport that the session tests drive. */
#include "fake.h"

#include "cmocka_c.h"
#include "message.h"
#include "session_run.h"

#include <stdlib.h>
#include <string.h>
#include <sys/eventfd.h>
#include <unistd.h>

enum { FAKE_MAX = 65536 };

static transport_ops fake_ops;
static struct {
    transport head;
    pthread_mutex_t lock;
    fake_options options;
    int64_t client;
    wire_message *sent[FAKE_MAX];
    size_t sent_count;
    wire_message *given[TRANSPORT_ROLES][FAKE_MAX];
    size_t given_count[TRANSPORT_ROLES];
    bool handing; /* the keeper is given something */
    int fds[TRANSPORT_ROLES];
} fake = {.lock = PTHREAD_MUTEX_INITIALIZER, .fds = {-1, -1}};

static void give(const wire_message *m) /* locked */
{
    transport_role role = m->kind == WIRE_ANSWER || m->kind == WIRE_EVENT_BATCH ? TRANSPORT_STREAMS : TRANSPORT_CONTROL;
    fake.given[role][fake.given_count[role]++] = message_copy(m);
    uint64_t one = 1;
    assert_int_equal(write(fake.fds[role], &one, sizeof one), sizeof one);
}

static void ack(const wire_message *sent)
{
    const int64_t sequence = message_sequence(sent);
    const wire_message m = {.kind = WIRE_ACK, .ack = {WIRE_VERSION, fake.client, fake.options.epoch, {1, &sequence}}};
    give(&m);
}

static bool is_announcement(wire_kind kind)
{
    return kind == WIRE_CLIENT || kind == WIRE_GEOMETRY || kind == WIRE_BODY || kind == WIRE_SUBSCRIPTION;
}

static int fake_send(transport *t, const wire_message *m)
{
    (void)t;
    if (m->kind == WIRE_RECEIPT && !m->receipt.epoch) return 0; /* a word of what was published, once a second */
    pthread_mutex_lock(&fake.lock);
    assert_true(fake.sent_count < FAKE_MAX);
    fake.sent[fake.sent_count++] = message_copy(m);
    if (!fake.options.deaf && is_announcement(m->kind) && m->kind != fake.options.ignored) ack(m);
    pthread_mutex_unlock(&fake.lock);
    return 0;
}

static void fake_receive(transport *t, transport_role role, const transport_sink *sink)
{
    (void)t;
    uint64_t count;
    while (read(fake.fds[role], &count, sizeof count) > 0) continue;
    for (;;) {
        pthread_mutex_lock(&fake.lock);
        wire_message *m = fake.given_count[role] ? fake.given[role][0] : NULL;
        if (m) memmove(fake.given[role], fake.given[role] + 1, --fake.given_count[role] * sizeof m);
        if (role == TRANSPORT_CONTROL) fake.handing = m != NULL;
        pthread_mutex_unlock(&fake.lock);
        if (!m) return;
        sink->message(sink->context, m);
        free(m);
    }
}

static transport *fake_open(const transport_options *options, char *why, size_t why_size)
{
    (void)why;
    (void)why_size;
    fake.client = options->client;
    fake.head.ops = &fake_ops;
    for (int role = 0; role < TRANSPORT_ROLES; role++) fake.fds[role] = eventfd(0, EFD_NONBLOCK | EFD_CLOEXEC);
    return &fake.head;
}

static void fake_close(transport *t)
{
    (void)t;
    for (int role = 0; role < TRANSPORT_ROLES; role++) close(fake.fds[role]);
}

static void fake_flush(transport *t)
{
    (void)t;
}

static void fake_drain(transport *t, int64_t timeout_ns)
{
    (void)t;
    (void)timeout_ns;
}

static bool fake_ready(transport *t)
{
    (void)t;
    return true;
}

static int fake_fd(transport *t, transport_role role)
{
    (void)t;
    return fake.fds[role];
}

static int fake_stream_open(transport *t, const char *stream)
{
    (void)t;
    (void)stream;
    return 0;
}

static void fake_stream_close(transport *t, const char *stream)
{
    (void)t;
    (void)stream;
}

void fake_begin(fake_options options)
{
    for (size_t i = 0; i < fake.sent_count; i++) free(fake.sent[i]);
    for (int role = 0; role < TRANSPORT_ROLES; role++) {
        for (size_t i = 0; i < fake.given_count[role]; i++) free(fake.given[role][i]);
        fake.given_count[role] = 0;
    }
    fake.sent_count = 0;
    fake.options = options;
    fake_ops = (transport_ops){.scheme = "fake",
        .repeats = options.repeats,
        .poses_max = 4,
        .open = fake_open,
        .send = fake_send,
        .flush = fake_flush,
        .drain = fake_drain,
        .ready = fake_ready,
        .fd = fake_fd,
        .receive = fake_receive,
        .stream_open = fake_stream_open,
        .stream_close = fake_stream_close,
        .close = fake_close};
}

void fake_set(fake_options options)
{
    pthread_mutex_lock(&fake.lock);
    fake.options = options;
    pthread_mutex_unlock(&fake.lock);
}

collided *fake_try(const collided_def *def, char *why, size_t why_size)
{
    return session_open(&fake_ops, "", def, why, why_size);
}

collided *fake_connect(void)
{
    collided_def def = collided_def_default();
    def.lease_s = 3600;
    def.connect_timeout_s = FAKE_PATIENCE_S;
    char why[256] = "";
    collided *c = fake_try(&def, why, sizeof why);
    if (!c) fail_msg("%s", why);
    return c;
}

static const wire_message *find(wire_kind kind, size_t n, size_t *count)
{
    const wire_message *found = NULL;
    *count = 0;
    pthread_mutex_lock(&fake.lock);
    for (size_t i = 0; i < fake.sent_count; i++)
        if (fake.sent[i]->kind == kind && (*count)++ == n) found = fake.sent[i];
    pthread_mutex_unlock(&fake.lock);
    return found;
}

size_t fake_sent(wire_kind kind)
{
    size_t count;
    (void)find(kind, 0, &count);
    return count;
}

void fake_pause(int ms)
{
    (void)usleep((useconds_t)ms * 1000);
}

void fake_settle(void)
{
    bool settled = false;
    for (int ms = 0; !settled && ms < 1000 * FAKE_PATIENCE_S; ms++) {
        if (ms) fake_pause(1);
        pthread_mutex_lock(&fake.lock);
        settled = fake.given_count[TRANSPORT_CONTROL] == 0 && !fake.handing;
        pthread_mutex_unlock(&fake.lock);
    }
    if (!settled) fail_msg("the keeper does not take what it is given");
}

const wire_message *fake_message(wire_kind kind, size_t n)
{
    size_t count = 0;
    for (int ms = 0; ms < 1000 * FAKE_PATIENCE_S; ms++) {
        const wire_message *m = find(kind, n, &count);
        if (m) return m;
        fake_pause(1);
    }
    fail_msg("%s: only %zu were sent, number %zu was waited for", wire_kind_name(kind), count, n);
    return NULL;
}

size_t fake_position(const wire_message *m)
{
    size_t i = 0;
    pthread_mutex_lock(&fake.lock);
    while (i < fake.sent_count && fake.sent[i] != m) i++;
    pthread_mutex_unlock(&fake.lock);
    return i;
}

void fake_give(const wire_message *m)
{
    pthread_mutex_lock(&fake.lock);
    give(m);
    pthread_mutex_unlock(&fake.lock);
}

void fake_ack(const wire_message *sent)
{
    pthread_mutex_lock(&fake.lock);
    ack(sent);
    pthread_mutex_unlock(&fake.lock);
}

void fake_reject(const wire_message *sent, wire_reason reason, const char *text)
{
    int64_t client, sequence;
    int32_t object;
    wire_origin(sent, &client, &sequence, &object);
    const wire_message m = {.kind = WIRE_REJECT,
        .reject = {.version = WIRE_VERSION,
            .client = client,
            .sequence = sequence,
            .epoch = fake.options.epoch,
            .kind = (uint8_t)sent->kind,
            .object = object,
            .reason = (uint8_t)reason,
            .text = text}};
    fake_give(&m);
}

static void status(int64_t epoch, uint8_t health)
{
    const char *names[] = {"ticks"};
    const int64_t values[] = {7};
    const wire_message m = {.kind = WIRE_STATUS,
        .status = {.version = WIRE_VERSION,
            .epoch = epoch,
            .health = health,
            .daemon = "fake:1",
            .release = "0",
            .links = "fake",
            .limits = "",
            .counter_names = {1, names},
            .counter_values = {1, values}}};
    fake_give(&m);
}

void fake_status(int64_t epoch)
{
    status(epoch, WIRE_HEALTH_READY);
}

void fake_end(int64_t epoch)
{
    status(epoch, WIRE_HEALTH_STOPPING);
}
