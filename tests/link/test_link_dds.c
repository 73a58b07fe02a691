/* The DDS link against raw Cyclone clients in processes of their own, in a network namespace without multicast. */
#include "harness.h"
#include "link/link_dds_own.h"
#include "link/link_open.h"

#include "dds_client.h"
#include "wire/dds/wire_dds_qos.h"

#include <poll.h>
#include <pthread.h>
#include <signal.h>
#include <spawn.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/wait.h>
#include <unistd.h>

static bool isolated;

#define LOSES_ONE_OF_FIVE "<Domain><Internal><Test><XmitLossiness>200</XmitLossiness></Test></Internal></Domain>"
enum { ROUNDS_WITH_LOSS = 4 };

/* ---- client processes ---- */

typedef struct client {
    pid_t pid;
    int out; /* what it says */
} client;

static client client_start(const char *role, const char *argument)
{
    int ends[2];
    client c;
    posix_spawn_file_actions_t files;
    char *const arguments[] = {"dds_client", "client", (char *)role, (char *)argument, NULL};
    assert_int_equal(pipe(ends), 0);
    posix_spawn_file_actions_init(&files);
    posix_spawn_file_actions_adddup2(&files, ends[1], STDOUT_FILENO);
    posix_spawn_file_actions_addclose(&files, ends[0]);
    posix_spawn_file_actions_addclose(&files, ends[1]);
    assert_int_equal(posix_spawn(&c.pid, "/proc/self/exe", &files, NULL, arguments, environ), 0);
    posix_spawn_file_actions_destroy(&files);
    close(ends[1]);
    c.out = ends[0];
    return c;
}

static void client_kill(client *c)
{
    kill(c->pid, SIGKILL);
    waitpid(c->pid, NULL, 0);
    close(c->out);
}

/* The client's next line, while the link keeps receiving. */
static void client_says(client *c, rig *r, double seconds, char line[NAME_BYTES])
{
    int64_t end = clock_monotonic_ns() + (int64_t)(seconds * 1e9);
    size_t n = 0;
    struct pollfd p = {.fd = c->out, .events = POLLIN};
    while (n < NAME_BYTES - 1 && (n == 0 || line[n - 1] != '\n')) {
        rig_receive(r);
        if (poll(&p, 1, 20) == 1 && read(c->out, line + n, 1) == 1) n++;
        if (clock_monotonic_ns() > end) fail_msg("the client says nothing within %g s", seconds);
    }
    line[n - 1] = '\0';
}

static void assert_says(client *c, rig *r, double seconds, const char *expected)
{
    char line[NAME_BYTES];
    client_says(c, r, seconds, line);
    assert_string_equal(line, expected);
}

static bool says_an_earlier(wire_kind kind, const char *line)
{
    char expected[NAME_BYTES];
    for (wire_kind k = WIRE_ANSWER; k < kind; k++) {
        snprintf(expected, sizeof expected, "%s same", wire_kind_name(k));
        if (strcmp(line, expected) == 0) return true;
    }
    return false;
}

/* Published until it is said: our writer may hear of that reader after the reader heard of us, and what is not kept for
 * those who come later goes to nobody until then. What was said before may be said again, and come late. */
static void assert_passes(client *c, rig *r, wire_kind kind)
{
    char expected[NAME_BYTES], line[NAME_BYTES];
    wire_message m = sample_message(kind);
    snprintf(expected, sizeof expected, "%s same", wire_kind_name(kind));
    int64_t end = clock_monotonic_ns() + (int64_t)(RIG_PATIENCE_S * 1e9);
    struct pollfd p = {.fd = c->out, .events = POLLIN};
    do {
        rig_publish(r, &m);
        while (poll(&p, 1, 500) == 1) {
            assert_true(clock_monotonic_ns() < end);
            client_says(c, r, RIG_PATIENCE_S, line);
            if (strcmp(line, expected) == 0) return;
            if (!says_an_earlier(kind, line)) assert_string_equal(line, expected);
        }
        rig_receive(r);
    } while (clock_monotonic_ns() < end);
    fail_msg("the client does not say: %s", expected);
}

static bool client_is_silent(client *c, int ms)
{
    struct pollfd p = {.fd = c->out, .events = POLLIN};
    return poll(&p, 1, ms) == 0;
}

static void dds_open(rig *r)
{
    if (!isolated) skip();
    rig_open(r, "dds://0", NULL);
}

/* ---- the tests ---- */

static void each_kind_passes_both_ways_unchanged(void **state)
{
    (void)state;
    rig r;
    dds_open(&r);
    r.link->ops->stream_open(r.link, "cell", 1);
    client c = client_start("talk", NULL);
    assert_says(&c, &r, RIG_PATIENCE_S, "sent");
    for (wire_kind k = WIRE_CLIENT; k <= WIRE_QUERY; k++) { /* topics have no order among each other */
        RIG_UNTIL(&r, RIG_PATIENCE_S, r.heard.messages[k] >= 1);
        assert_int_equal(r.heard.messages[k], 1);
    }
    assert_int_equal(r.heard.differing, 0);
    assert_int_equal(r.heard.refused, 0);
    for (wire_kind k = WIRE_ANSWER; k < WIRE_KIND_COUNT; k++) assert_passes(&c, &r, k);
    client_kill(&c);
    rig_close(&r);
}

static long resident_mb(void)
{
    long pages = 0;
    FILE *f = fopen("/proc/self/statm", "r");
    assert_non_null(f);
    assert_int_equal(fscanf(f, "%*s %ld", &pages), 1); /* NOLINT(cert-err34-c): the kernel's own number */
    fclose(f);
    return pages * sysconf(_SC_PAGESIZE) / (1 << 20);
}

/* Of a client that stands still, and acknowledges nothing, as a reader that is alive may. */
static void large_answers_that_nobody_takes_are_not_all_kept(void **state)
{
    (void)state;
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__) /* half a second each, and nothing to be seen */
    enum { SENT = 20, NAME_SIZE = 240 };
#else
    enum { SENT = 300, NAME_SIZE = 240 };
#endif
    static char name[NAME_SIZE + 1];
    static const char *names[WIRE_ANSWERS_MAX];
    static double zeros[WIRE_ANSWERS_MAX];
    rig r;
    dds_open(&r);
    r.link->ops->stream_open(r.link, "cell", 1); /* the client waits for all that it reads */
    client c = client_start("talk", NULL);
    assert_says(&c, &r, RIG_PATIENCE_S, "sent");
    assert_passes(&c, &r, WIRE_ANSWER);
    memset(name, 'n', NAME_SIZE);
    for (int i = 0; i < WIRE_ANSWERS_MAX; i++) names[i] = name;
    wire_message m = sample_message(WIRE_ANSWER);
    m.answer.lo = m.answer.hi = (wire_f64s){WIRE_ANSWERS_MAX, zeros};
    m.answer.names_a = (wire_strings){WIRE_ANSWERS_MAX, names};
    kill(c.pid, SIGSTOP);
    long before = resident_mb();
    for (int i = 0; i < SENT; i++) {
        m.answer.sequence++;
        rig_publish(&r, &m);
    }
    long grown = resident_mb() - before;
    print_message("%d answers of 1 MB: %ld MiB are kept\n", SENT, grown);
#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__) /* which keep what was freed */
    assert_in_range(grown, 0, 130);
#endif
    kill(c.pid, SIGCONT);
    client_kill(&c);
    rig_close(&r);
}

static void a_stream_tells_of_each_reader_that_comes(void **state)
{
    (void)state;
    rig r;
    dds_open(&r);
    r.link->ops->stream_open(r.link, "arm", 1);
    client first = client_start("listen", "arm");
    RIG_UNTIL(&r, RIG_PATIENCE_S, r.heard.readers == 1);
    assert_string_equal(r.heard.reader, "arm");
    client second = client_start("listen", "arm");
    RIG_UNTIL(&r, RIG_PATIENCE_S, r.heard.readers == 2);
    client_kill(&first);
    rig_receive(&r);
    assert_int_equal(r.heard.readers, 2); /* one that goes is no news */
    r.link->ops->stream_open(r.link, "arm", 1);
    RIG_UNTIL(&r, 10, r.heard.readers == 3); /* opened again, it tells of who is there */
    client_kill(&second);
    rig_close(&r);
}

static void assert_partition(const char *stream, const char *expected)
{
    char partition[WIRE_DDS_PARTITION_MAX];
    wire_dds_partition(stream, partition);
    assert_string_equal(partition, expected);
}

static void no_name_of_a_stream_is_a_wildcard_of_dds(void **state)
{
    (void)state;
    char longest[WIRE_NAME_MAX + 1];
    char partition[WIRE_DDS_PARTITION_MAX];
    assert_partition("arm.1", "stream:arm.1");
    assert_partition("a*m?,[b]%", "stream:a%2Am%3F%2C%5Bb%5D%25");
    memset(longest, '*', WIRE_NAME_MAX);
    longest[WIRE_NAME_MAX] = '\0';
    wire_dds_partition(longest, partition);
    assert_int_equal(strlen(partition), strlen("stream:") + 3 * WIRE_NAME_MAX);
}

static void streams_do_not_hear_each_other(void **state)
{
    (void)state;
    static const char *const names[3] = {"arm", "arm.1", "a:rm"};
    rig r;
    dds_open(&r);
    client c[3];
    char expected[NAME_BYTES];
    for (int i = 0; i < 3; i++) r.link->ops->stream_open(r.link, names[i], 1);
    for (int i = 0; i < 3; i++) c[i] = client_start("listen", names[i]);
    for (int i = 0; i < 3; i++) assert_says(&c[i], &r, RIG_PATIENCE_S, "matched");
    RIG_UNTIL(&r, RIG_PATIENCE_S, r.heard.readers == 3);
    for (int i = 0; i < 3; i++) {
        wire_message m = sample_events(names[i], 100 + i);
        rig_publish(&r, &m);
    }
    for (int i = 0; i < 3; i++) {
        snprintf(expected, sizeof expected, "%s batch %d", names[i], 100 + i);
        assert_says(&c[i], &r, RIG_PATIENCE_S, expected);
    }
    for (int i = 0; i < 3; i++) assert_true(client_is_silent(&c[i], 100));
    r.link->ops->stream_close(r.link, "arm.1");
    wire_message gone = sample_events("arm.1", 1);
    rig_publish(&r, &gone);
    assert_int_equal(rig_counter(&r, "dds_no_stream"), 1);
    for (int i = 0; i < 3; i++) client_kill(&c[i]);
    rig_close(&r);
}

static void hear_a_stream_that_is_closed_at_once(void)
{
    rig r;
    dds_open(&r);
    r.link->ops->stream_open(r.link, "arm", 1);
    client c = client_start("listen", "arm");
    assert_says(&c, &r, RIG_PATIENCE_S, "matched");
    RIG_UNTIL(&r, RIG_PATIENCE_S, r.heard.readers == 1);
    for (int64_t batch = 1; batch <= 20; batch++) {
        wire_message m = sample_events("arm", batch);
        r.link->ops->publish(r.link, &m);
    }
    r.link->ops->stream_close(r.link, "arm");
    for (int batch = 1; batch <= 20; batch++) {
        char expected[NAME_BYTES];
        snprintf(expected, sizeof expected, "arm batch %d", batch);
        assert_says(&c, &r, RIG_PATIENCE_S, expected);
    }
    client_kill(&c);
    rig_close(&r);
}

static void the_end_of_a_stream_arrives_though_it_is_closed_at_once(void **state)
{
    (void)state;
    hear_a_stream_that_is_closed_at_once();
}

/* One datagram of five is lost, both ways, whatever is in it. Cyclone alone repairs what it told last too late. */
static void the_end_of_a_stream_arrives_though_datagrams_are_lost(void **state)
{
    (void)state;
    setenv("CYCLONEDDS_URI", LOSES_ONE_OF_FIVE, 1);
    for (int i = 0; i < ROUNDS_WITH_LOSS; i++) hear_a_stream_that_is_closed_at_once();
}

static int forget_loss(void **state)
{
    (void)state;
    return unsetenv("CYCLONEDDS_URI");
}

/* Nothing is said of time; what arrives is in order, and the last is among it. */
static void large_batches_arrive_in_order(void **state)
{
    (void)state;
    rig r;
    dds_open(&r);
    client c = client_start("flood", NULL);
    RIG_UNTIL(&r, RIG_PATIENCE_S, r.heard.last_sequence == FLOOD_BATCHES);
    assert_int_equal(r.heard.disordered, 0);
    assert_int_equal(r.heard.refused, 0);
    assert_true(r.heard.messages[WIRE_POSE_BATCH] > FLOOD_BATCHES / 20);
    client_kill(&c);
    rig_close(&r);
}

/* The client's next line, while what it sends waits in the link. */
static void assert_says_unheard(client *c, const char *expected)
{
    char line[NAME_BYTES];
    size_t n = 0;
    struct pollfd p = {.fd = c->out, .events = POLLIN};
    while (n < NAME_BYTES - 1 && (n == 0 || line[n - 1] != '\n')) {
        if (poll(&p, 1, (int)(1000 * RIG_PATIENCE_S)) != 1) fail_msg("the client says nothing");
        n += (size_t)read(c->out, line + n, 1);
    }
    line[n - 1] = '\0';
    assert_string_equal(line, expected);
}

/* One round takes some of what waits, and of that something of everybody's. */
static void a_flood_of_poses_does_not_stand_before_those_of_others(void **state)
{
    (void)state;
    rig r;
    dds_open(&r);
    client flood = client_start("flood", NULL);
    assert_says_unheard(&flood, "sent");
    client aside = client_start("aside", NULL);
    assert_says_unheard(&aside, "sent");
    RIG_UNTIL(&r, RIG_PATIENCE_S, r.heard.disordered || r.heard.last_sequence == ASIDE_SEQUENCE);
    assert_in_range(r.heard.messages[WIRE_POSE_BATCH], 2, FLOOD_BATCHES * 4 / 5); /* it has overtaken */
    RIG_UNTIL(&r, RIG_PATIENCE_S, r.heard.last_sequence == FLOOD_BATCHES);
    assert_int_equal(r.heard.disordered, 1);
    assert_int_equal(r.heard.refused, 0);
    client_kill(&flood);
    client_kill(&aside);
    rig_close(&r);
}

typedef struct large_batch {
    rig *rig;
    size_t parts, longest, wrong, next; /* next: the body that comes next */
    size_t steps;                       /* that came as one thing */
} large_batch;

static size_t wrong_numbers(const wire_pose_batch *p)
{
    size_t wrong = 0;
    for (size_t k = 0; k < p->bodies.count; k++) {
        int32_t i = p->bodies.at[k];
        for (size_t c = 0; c < 3; c++) wrong += p->positions.at[3 * k + c] != 3.0 * i + (double)c;
        for (size_t c = 0; c < 3; c++) wrong += p->linear.at[3 * k + c] != -3.0 * i - (double)c;
        for (size_t c = 0; c < 3; c++) wrong += p->angular.at[3 * k + c] != 0.5 * i + (double)c;
        for (size_t c = 0; c < 4; c++) wrong += p->orientations.at[4 * k + c] != ((size_t)i % 4 == c);
        wrong += p->teleports.at[k] != (i % 3 == 0);
    }
    return wrong;
}

static void look_at_part(void *context, struct link *from, const wire_message *m)
{
    large_batch *l = context;
    (void)from;
    if (m->kind != WIRE_POSE_BATCH) return;
    const wire_pose_batch *p = &m->pose_batch;
    l->wrong += wrong_numbers(p);
    if (p->step) {
        l->steps += p->bodies.count == LARGE_POSES && p->sequence == LARGE_STEP;
        return;
    }
    for (size_t k = 0; k < p->bodies.count; k++) l->wrong += (size_t)p->bodies.at[k] != l->next++;
    if (p->bodies.count > l->longest) l->longest = p->bodies.count;
    l->parts++;
}

static bool is_enough(void *context)
{
    (void)context;
    return true;
}

/* A batch that would take a whole tick comes in parts, one of them in each round while the service has enough; a step
 * is one thing. */
static void a_large_batch_comes_in_parts_and_a_step_does_not(void **state)
{
    (void)state;
    rig r;
    dds_open(&r);
    large_batch l = {.rig = &r};
    link_sink sink = r.sink;
    sink.context = &l;
    sink.message = look_at_part;
    sink.enough = is_enough;
    client c = client_start("large", NULL);
    int64_t end = clock_monotonic_ns() + (int64_t)(RIG_PATIENCE_S * 1e9);
    while (!l.steps && clock_monotonic_ns() < end) {
        size_t before = l.parts;
        r.link->ops->receive(r.link, &sink);
        assert_true(l.parts <= before + 1);
        rig_is_woken(&r, 1);
    }
    assert_int_equal(l.steps, 1);
    assert_int_equal(l.next, LARGE_POSES);
    assert_int_equal(l.wrong, 0);
    assert_in_range(l.longest, 1, 5000);
    client_kill(&c);
    rig_close(&r);
}

/* What takes long to carry out comes in several rounds, and the loss of who sent it behind the last of it. */
static void much_comes_in_several_rounds_and_the_loss_of_its_sender_behind(void **state)
{
    (void)state;
    enum { A_TAKE = 64 };
    rig r;
    dds_open(&r);
    client c = client_start("many", NULL);
    assert_says_unheard(&c, "sent");
    client_kill(&c);
    r.sink.much = is_enough;
    int64_t end = clock_monotonic_ns() + (int64_t)(RIG_PATIENCE_S * 1e9);
    while (!r.heard.lost && clock_monotonic_ns() < end) {
        size_t before = r.heard.messages[WIRE_BODY];
        r.link->ops->receive(r.link, &r.sink);
        assert_true(r.heard.messages[WIRE_BODY] <= before + A_TAKE);
        rig_is_woken(&r, 1);
    }
    assert_int_equal(r.heard.lost, 1);
    assert_int_equal(r.heard.messages[WIRE_BODY], MANY_BODIES);
    rig_close(&r);
}

typedef struct losses {
    wire_kind kind;
    int64_t client;
    size_t count, times;
} losses;

static void on_lost(void *context, struct link *from, wire_kind kind, int64_t client, size_t count)
{
    losses *l = context;
    (void)from;
    *l = (losses){kind, client, count, l->times + 1};
}

/* What DDS says it has lost wakes the tick thread, which is told once. */
static void what_dds_has_lost_is_told(void **state)
{
    (void)state;
    rig r;
    dds_open(&r);
    losses l = {.times = 0};
    link_sink sink = {.context = &l, .lost = on_lost};
    r.link->ops->receive(r.link, &sink);
    assert_int_equal(l.times, 0);
    link_dds_note_lost(link_dds_of(r.link), WIRE_BODY, 2);
    link_dds_note_lost(link_dds_of(r.link), WIRE_BODY, 3);
    assert_true(rig_is_woken(&r, 1000));
    r.link->ops->receive(r.link, &sink);
    assert_int_equal(l.times, 1);
    assert_int_equal(l.kind, WIRE_BODY);
    assert_int_equal(l.client, 0);
    assert_int_equal(l.count, 5);
    r.link->ops->receive(r.link, &sink);
    assert_int_equal(l.times, 1);
    rig_close(&r);
}

/* ---- rounds on the thread that poses arrive on ---- */

enum { EVENTS_A_ROUND = 16 };

typedef struct arrivals {
    rig rig;
    pthread_mutex_t lock; /* the service's: of the rig, and of what follows */
    int64_t rounds, longest_ns;
} arrivals;

/* As in the service: never waits for the lock. */
static bool run_round(void *context, struct link *from)
{
    arrivals *a = context;
    if (pthread_mutex_trylock(&a->lock) != 0) return false;
    int64_t began = clock_monotonic_ns();
    from->ops->receive_poses(from, &a->rig.sink);
    wire_message m = sample_events("arm", ++a->rounds);
    for (int i = 0; i < EVENTS_A_ROUND; i++) from->ops->publish(from, &m);
    from->ops->flush(from);
    int64_t took = clock_monotonic_ns() - began;
    if (took > a->longest_ns) a->longest_ns = took;
    pthread_mutex_unlock(&a->lock);
    return true;
}

static bool have_all_poses(arrivals *a)
{
    pthread_mutex_lock(&a->lock);
    rig_receive(&a->rig);
    bool all = a->rig.heard.last_sequence == FLOOD_BATCHES;
    pthread_mutex_unlock(&a->lock);
    return all;
}

/* The reader of what is written there stands still, so that nothing is acknowledged, and the thread that writes is the
 * one that would process acknowledgements. A writer that keeps all would have waited after 40 kB, and failed. */
static void no_round_on_arrival_waits_for_a_reader(void **state)
{
    (void)state;
    arrivals a = {.lock = PTHREAD_MUTEX_INITIALIZER};
    dds_open(&a.rig);
    a.rig.link->ops->stream_open(a.rig.link, "arm", 1);
    client still = client_start("listen", "arm");
    assert_says(&still, &a.rig, RIG_PATIENCE_S, "matched");
    RIG_UNTIL(&a.rig, RIG_PATIENCE_S, a.rig.heard.readers == 1);
    kill(still.pid, SIGSTOP);
    a.rig.link->options.poses_context = &a;
    a.rig.link->options.poses = run_round;
    client c = client_start("flood", NULL);
    int64_t end = clock_monotonic_ns() + 60 * INT64_C(1000000000);
    while (!have_all_poses(&a) && clock_monotonic_ns() < end) rig_is_woken(&a.rig, 20);
    client_kill(&c);
    a.rig.link->options.poses = NULL;
    print_message("%lld of %d batches in %lld rounds on arrival, of at most %lld us\n",
        (long long)a.rig.heard.messages[WIRE_POSE_BATCH], FLOOD_BATCHES, (long long)a.rounds,
        (long long)a.longest_ns / 1000);
    assert_int_equal(a.rig.heard.last_sequence, FLOOD_BATCHES);
    assert_int_equal(a.rig.heard.disordered, 0);
    assert_true(a.rounds > FLOOD_BATCHES / 20); /* on a quiet machine nearly all */
    assert_int_equal(rig_counter(&a.rig, "dds_write_failed"), 0);
    client_kill(&still);
    rig_close(&a.rig);
}

static void a_killed_client_is_lost_within_its_lease_and_its_bodies_are_not_removed(void **state)
{
    (void)state;
    rig r;
    dds_open(&r);
    client c = client_start("live", NULL);
    assert_says(&c, &r, RIG_PATIENCE_S, "sent");
    RIG_UNTIL(&r, RIG_PATIENCE_S, r.heard.messages[WIRE_BODY] == 1 && r.heard.messages[WIRE_CLIENT] == 1);
    int64_t quiet = clock_monotonic_ns() + (CLIENT_LEASE_MS + 300) * INT64_C(1000000);
    while (!rig_wait(&r, quiet)) rig_receive(&r);
    assert_int_equal(r.heard.lost, 0); /* it lives, and need not say so */

    client_kill(&c);
    RIG_UNTIL(&r, RIG_PATIENCE_S, r.heard.lost > 0);
    assert_int_equal(r.heard.lost_client, CLIENT_ID);
    quiet = clock_monotonic_ns() + INT64_C(300000000);
    while (!rig_wait(&r, quiet)) rig_receive(&r);
    assert_int_equal(r.heard.lost, 1);
    assert_int_equal(r.heard.removed, 0);

    client again = client_start("live", NULL);
    RIG_UNTIL(&r, RIG_PATIENCE_S, r.heard.messages[WIRE_CLIENT] == 2 && r.heard.messages[WIRE_BODY] == 2);
    assert_int_equal(r.heard.differing, 0);
    client_kill(&again);
    rig_close(&r);
}

static void assert_removed_once(const char *role)
{
    rig r;
    dds_open(&r);
    client c = client_start(role, NULL);
    RIG_UNTIL(&r, RIG_PATIENCE_S, r.heard.removed == 1);
    client_kill(&c);
    RIG_UNTIL(&r, RIG_PATIENCE_S, r.heard.lost >= 1);
    assert_int_equal(r.heard.removed, 1);
    assert_int_equal(r.heard.refused, 0);
    rig_close(&r);
}

static void a_body_taken_back_is_removed_once(void **state)
{
    (void)state;
    assert_removed_once("remove");
}

static void a_body_disposed_by_its_key_is_removed_once(void **state)
{
    (void)state;
    assert_removed_once("dispose");
}

static void bad_numbers_are_refused_with_the_sender(void **state)
{
    (void)state;
    rig r;
    dds_open(&r);
    client c = client_start("bad", NULL);
    RIG_UNTIL(&r, RIG_PATIENCE_S, r.heard.refused == 1);
    assert_int_equal(r.heard.refused_kind, WIRE_POSE_BATCH);
    assert_int_equal(r.heard.why.reason, WIRE_BAD_NUMBER);
    assert_int_equal(r.heard.refused_client, CLIENT_ID);
    assert_int_equal(r.heard.refused_sequence, 12);
    assert_int_equal(rig_counter(&r, "dds_refused"), 1);
    client_kill(&c);
    rig_close(&r);
}

static void late_joiners_get_the_status(void **state)
{
    (void)state;
    rig r;
    dds_open(&r);
    wire_message m = sample_message(WIRE_STATUS);
    rig_publish(&r, &m);
    r.link->ops->stream_open(r.link, "cell", 1);
    client c = client_start("talk", NULL);
    char line[NAME_BYTES];
    client_says(&c, &r, RIG_PATIENCE_S, line);
    assert_string_equal(line, "sent");
    assert_says(&c, &r, RIG_PATIENCE_S, "Status same");
    client_kill(&c);
    rig_close(&r);
}

static void an_address_that_cannot_be_is_refused_with_the_reason(void **state)
{
    (void)state;
    static const struct {
        const char *uri, *interface, *why;
    } cases[] = {
        {"dds://231", "", "from 0 to 230"},
        {"dds://zero", "", "from 0 to 230"},
        {"dds://1", "\"/><evil/>", "no name or address"},
        {"dds://1", "nosuch0", "interface"},
    };
    if (!isolated) skip();
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        char why[512] = "";
        metrics *counters = metrics_create();
        link_options options = {.wake_fd = -1, .counters = counters, .interface = cases[i].interface};
        assert_null(link_open(cases[i].uri, &options, why, sizeof why));
        assert_non_null(strstr(why, cases[i].why));
        metrics_destroy(counters);
    }
}

int main(int argc, char **argv)
{
    if (argc > 2) return dds_client(argc, argv);
    isolated = netns_enter();
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(each_kind_passes_both_ways_unchanged),
        cmocka_unit_test(large_answers_that_nobody_takes_are_not_all_kept),
        cmocka_unit_test(a_stream_tells_of_each_reader_that_comes),
        cmocka_unit_test(no_name_of_a_stream_is_a_wildcard_of_dds),
        cmocka_unit_test(streams_do_not_hear_each_other),
        cmocka_unit_test(the_end_of_a_stream_arrives_though_it_is_closed_at_once),
        cmocka_unit_test_teardown(the_end_of_a_stream_arrives_though_datagrams_are_lost, forget_loss),
        cmocka_unit_test(large_batches_arrive_in_order),
        cmocka_unit_test(a_flood_of_poses_does_not_stand_before_those_of_others),
        cmocka_unit_test(a_large_batch_comes_in_parts_and_a_step_does_not),
        cmocka_unit_test(what_dds_has_lost_is_told),
        cmocka_unit_test(much_comes_in_several_rounds_and_the_loss_of_its_sender_behind),
        cmocka_unit_test(no_round_on_arrival_waits_for_a_reader),
        cmocka_unit_test(a_killed_client_is_lost_within_its_lease_and_its_bodies_are_not_removed),
        cmocka_unit_test(a_body_taken_back_is_removed_once),
        cmocka_unit_test(a_body_disposed_by_its_key_is_removed_once),
        cmocka_unit_test(bad_numbers_are_refused_with_the_sender),
        cmocka_unit_test(late_joiners_get_the_status),
        cmocka_unit_test(an_address_that_cannot_be_is_refused_with_the_reason),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
