/* link_lcm: the daemon's side of the pipe to collided-lcm.
 *
 * Two threads. The tick thread publishes into `outgoing` and takes `incoming`; the watcher starts the gateway, moves
 * bytes and starts it again; when only poses have come it offers to do the tick itself (link_options.poses). `lock`
 * guards both queues and the pipe's descriptor. Both queues are bounded: what does not fit is dropped and counted,
 * poses first. */
#include "link_lcm.h"

#include "base/array.h"
#include "base/clock.h"
#include "base/log.h"
#include "gateway_process.h"
#include "gateway_words.h"
#include "incoming.h"
#include "interface.h"
#include "opened.h"
#include "pipe/pipe.h"
#include "pipe/route.h"
#include "turns.h"
#include "wake.h"

#include <arpa/inet.h>
#include <errno.h>
#include <netinet/in.h>
#include <poll.h>
#include <pthread.h>
#include <signal.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/eventfd.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <sysexits.h>

enum {
    URL_MAX = 512,
    QUEUE_BYTES = 32 << 20,      /* waiting for the tick: half a second of the fastest loopback */
    QUEUE_POSE_BYTES = 24 << 20, /* of those, open to poses and vertices: the newest of them are worth the least */
    DIRECT_BYTES = 1 << 20,      /* that a round takes as they come. Of more all wait, by client, ... */
    ROUND_BYTES = 6 << 20,       /* ... who have their turns: 100,000 poses a round, ... */
    ONE_POSE_BYTES = 12 << 20,   /* ... of whose poses so many may */
    OUT_BYTES = 8 << 20,         /* waiting for the gateway */
    OFFER_BYTES = 64 << 10,      /* poses: more are the tick thread's */
    RETRY_FIRST_MS = 50,         /* the first restart is immediate; the pause doubles ... */
    RETRY_MOST_MS = 800,         /* ... up to this: back within a second */
    RETRY_NETWORK_MS = 5000,     /* somebody has to change the network first */
    STEADY_MS = 5000,            /* having run for so long, a gateway has not died at start */
    START_MS = 10000,            /* a gateway that has not said in that time that LCM runs does not start */
    LAST_WORDS_MS = 500          /* closing: for what is still to be published */
};
static const char default_url[] = "udpm://239.255.76.67:7667";

typedef struct link_lcm {
    struct link head;
    char program[GATEWAY_PATH_MAX];
    char url[URL_MAX];
    wire_memory *memory;
    opened streams;
    pipe_buffer taken; /* the tick thread's: frames swapped out of `incoming` */
    turns waiting;     /* and those that came when a round had enough */

    pthread_t watcher;
    int poke_fd; /* wakes the watcher: there is something to send, or it is to end */
    atomic_bool closing;
    atomic_int pid;

    gateway_words words; /* the watcher's: what the gateway writes to standard error */

    pthread_mutex_t lock;
    pthread_cond_t settled; /* the first gateway is ready, or `failure` says why it is not */
    char failure[512];
    pipe_buffer incoming, outgoing;
    size_t waiting_bytes; /* of `waiting` */
    int pipe;             /* -1 = no gateway */
    bool ready;           /* it has said that LCM runs */
    bool starting;        /* the watcher's: this is the first gateway, and it must start */

    metric *messages_in, *refused, *queue_full, *queue_full_poses, *messages_out, *out_dropped, *restarts, *bad_frames;
    metric *datagrams_dropped;
} link_lcm;

static link_lcm *link_lcm_of(struct link *l)
{
    return (link_lcm *)l;
}

int link_lcm_gateway_pid(const struct link *l)
{
    return atomic_load(&((link_lcm *)l)->pid);
}

/* ---- the watcher: what comes ---- */

static bool is_pose(const pipe_frame *f)
{
    wire_kind kind = wire_lcm_kind(f->data, f->size);
    return kind == WIRE_POSE_BATCH || kind == WIRE_VERTEX_BATCH;
}

static void note_drops(link_lcm *l, const pipe_frame *f)
{
    uint32_t more = 0;
    if (f->size == sizeof more) memcpy(&more, f->data, sizeof more);
    metric_count(l->datagrams_dropped, more);
    log_warning("LCM: %u datagrams were dropped: forged or damaged, or more than the kernel's buffer holds "
                "(net.core.rmem_max, recv_buf_size)",
        more);
}

/* Queues a frame for the tick, or counts it as dropped. */
static void enqueue(link_lcm *l, const pipe_frame *f)
{
    if (f->kind == PIPE_READY) {
        l->ready = true;
        gateway_words_report(&l->words);
        pthread_cond_signal(&l->settled);
        return;
    }
    if (f->kind == PIPE_DROPPED) {
        note_drops(l, f);
        return;
    }
    size_t used = pipe_used(&l->incoming) + pipe_frame_size(f->channel_length, f->size) + l->waiting_bytes;
    if (is_pose(f) && used > QUEUE_POSE_BYTES)
        metric_count(l->queue_full_poses, 1);
    else if (used > QUEUE_BYTES)
        metric_count(l->queue_full, 1);
    else
        pipe_put_frame(&l->incoming, f);
}

/* False: the gateway has gone, or does not speak in frames. */
static bool receive_frames(link_lcm *l, pipe_buffer *raw)
{
    if (pipe_read(raw, l->pipe) < 0) return false;
    const link_options *o = &l->head.options;
    pipe_frame f;
    int got;
    bool only_poses = o->poses != NULL;
    pthread_mutex_lock(&l->lock);
    bool was_empty = pipe_used(&l->incoming) == 0;
    while ((got = pipe_take(raw, &f)) == 1) {
        only_poses &= is_pose(&f);
        enqueue(l, &f);
    }
    size_t waiting = pipe_used(&l->incoming);
    pthread_mutex_unlock(&l->lock);
    bool offer = only_poses && waiting <= OFFER_BYTES;
    if (was_empty && waiting && !(offer && o->poses(o->poses_context, &l->head))) wake(o->wake_fd);
    if (got < 0) metric_count(l->bad_frames, 1);
    return got == 0;
}

/* ---- the watcher: life of the gateway ---- */

/* `rest`: there is more, when the pipe takes more. */
static bool send_frames(link_lcm *l, bool *rest)
{
    pthread_mutex_lock(&l->lock);
    bool alive = !l->ready || pipe_send(&l->outgoing, l->pipe);
    *rest = l->ready && pipe_used(&l->outgoing) > 0;
    pthread_mutex_unlock(&l->lock);
    return alive;
}

static void clear_poke(const link_lcm *l)
{
    uint64_t count;
    ssize_t n = read(l->poke_fd, &count, sizeof count);
    (void)n; /* EAGAIN: nobody poked */
}

/* Moves bytes until the gateway has gone, or the link closes. */
static void serve(link_lcm *l)
{
    pipe_buffer raw = {0};
    bool rest = false;
    struct pollfd p[] = {{.fd = l->pipe}, {.fd = l->poke_fd, .events = POLLIN}, {.fd = l->words.fd, .events = POLLIN}};
    while (!atomic_load(&l->closing)) {
        p[0].events = (short)(POLLIN | (rest ? POLLOUT : 0));
        if (poll(p, 3, -1) < 0) continue;
        if (p[1].revents) clear_poke(l);
        if (p[2].revents && !gateway_words_read(&l->words)) p[2].fd = -1;
        if (p[0].revents & ~POLLOUT && !receive_frames(l, &raw)) break;
        if (!send_frames(l, &rest)) break;
    }
    pipe_free(&raw);
}

/* The first gateway does not start: whoever opens the link waits for that, and says so. */
static void give_up(link_lcm *l, const char *how, const char *mend)
{
    pthread_mutex_lock(&l->lock);
    snprintf(l->failure, sizeof l->failure, "%s%s", how, mend);
    pthread_cond_signal(&l->settled);
    pthread_mutex_unlock(&l->lock);
}

static bool start(link_lcm *l)
{
    pid_t pid;
    int errors = -1, fd = gateway_start(l->program, l->url, l->head.options.interface, &pid, &errors);
    if (fd < 0) {
        char how[320];
        snprintf(how, sizeof how, "%.200s: the LCM gateway does not start: %s", l->program, strerror(errno));
        if (l->starting)
            give_up(l, how, ": do: apt-get install --reinstall collided, or set gateway");
        else
            log_error("%s", how);
        return false;
    }
    gateway_words_begin(&l->words, errors, l->starting);
    pthread_mutex_lock(&l->lock);
    l->pipe = fd;
    pipe_resend(&l->outgoing);
    pthread_mutex_unlock(&l->lock);
    atomic_store(&l->pid, pid);
    return true;
}

/* In order: what waits is sent as far as time allows, then the pipe's end tells the gateway to end. */
static void last_words(link_lcm *l)
{
    int64_t until = clock_monotonic_ns() + LAST_WORDS_MS * INT64_C(1000000);
    bool rest = true;
    struct pollfd p = {.fd = l->pipe, .events = POLLOUT};
    while (send_frames(l, &rest) && rest && clock_monotonic_ns() < until) poll(&p, 1, LAST_WORDS_MS / 10);
    shutdown(l->pipe, SHUT_WR);
}

/* How many messages the gateway was to publish, and never will. */
static void discard_outgoing(link_lcm *l)
{
    pipe_frame f;
    uint64_t count = 0;
    pthread_mutex_lock(&l->lock);
    pipe_resend(&l->outgoing);
    while (pipe_take(&l->outgoing, &f) == 1) count++;
    pthread_mutex_unlock(&l->lock);
    metric_count(l->out_dropped, count);
}

/* Its end, known for some other reason than the closing of the link. The least pause before the next start. */
static int mourn(link_lcm *l, int status, const char *how)
{
    log_error("collided-lcm has ended: %s", how);
    if (!WIFEXITED(status) || WEXITSTATUS(status) != PIPE_EXIT_NETWORK) return 0;
    discard_outgoing(l); /* there may be no network for long, and old events are worse than a gap */
    return RETRY_NETWORK_MS;
}

/* 127 is the dynamic loader's word for a library that is missing. */
static void mourn_first(link_lcm *l, int status, const char *how)
{
    bool library = WIFEXITED(status) && WEXITSTATUS(status) == 127;
    char without_words[400];
    snprintf(without_words, sizeof without_words, "%.200s: the LCM gateway has ended at once: %s", l->program, how);
    give_up(l, *l->words.first ? l->words.first : without_words,
        library           ? ": do: apt-get install --reinstall liblcm1"
        : *l->words.first ? ""
                          : ": do: apt-get install --reinstall collided, or set gateway");
}

/* The least pause before the next start. */
static int end(link_lcm *l)
{
    char how[128];
    bool closing = atomic_load(&l->closing);
    pid_t pid = atomic_exchange(&l->pid, 0);
    if (closing) last_words(l);
    int status = gateway_end(pid, closing ? LAST_WORDS_MS : 0, how, sizeof how);
    gateway_words_end(&l->words);
    pthread_mutex_lock(&l->lock);
    bool failed = l->starting && !l->ready;
    close(l->pipe);
    l->pipe = -1;
    l->ready = false;
    pthread_mutex_unlock(&l->lock);
    if (failed && !closing) mourn_first(l, status, how);
    return closing || failed ? 0 : mourn(l, status, how);
}

/* The pause before the next start: none for one that had run for a while. */
static int next_pause(int pause_ms, int64_t ran_ns)
{
    if (ran_ns >= STEADY_MS * INT64_C(1000000)) return 0;
    if (pause_ms == 0) return RETRY_FIRST_MS;
    return pause_ms * 2 < RETRY_MOST_MS ? pause_ms * 2 : RETRY_MOST_MS;
}

static void pause_for(link_lcm *l, int pause_ms)
{
    struct pollfd p = {.fd = l->poke_fd, .events = POLLIN};
    int64_t until = clock_monotonic_ns() + pause_ms * INT64_C(1000000);
    int64_t left;
    while (!atomic_load(&l->closing) && (left = until - clock_monotonic_ns()) > 0) {
        poll(&p, 1, (int)(left / 1000000) + 1);
        clear_poke(l);
    }
}

static void *watch(void *context)
{
    link_lcm *l = context;
    int pause_ms = -1; /* the first death costs no pause, however early it comes */
    while (!atomic_load(&l->closing)) {
        int64_t began = clock_monotonic_ns();
        int least_ms = 0;
        if (start(l)) {
            serve(l);
            least_ms = end(l);
        }
        if (atomic_load(&l->closing) || *l->failure) break;
        l->starting = false;
        pause_ms = pause_ms < 0 ? 0 : next_pause(pause_ms, clock_monotonic_ns() - began);
        pause_for(l, pause_ms > least_ms ? pause_ms : least_ms);
        metric_count(l->restarts, 1);
    }
    return NULL;
}

/* ---- the tick thread ---- */

/* The URL for liblcm: its default if there is none, with a large buffer and ttl 0 unless told otherwise. */
static bool complete_url(const char *address, char *url, size_t size)
{
    const char *base = address[0] ? address : default_url;
    int n = snprintf(url, size, "%s%s%s%s", base, strchr(base, '?') ? "" : "?",
        strstr(base, "recv_buf_size=") ? "" : "&recv_buf_size=4194304", strstr(base, "ttl=") ? "" : "&ttl=0");
    if (n < 0 || (size_t)n >= size) return false;
    char *odd = strstr(url, "?&");
    if (odd) memmove(odd + 1, odd + 2, strlen(odd + 2) + 1);
    return true;
}

static bool leaves_machine(const char *url)
{
    const char *ttl = strstr(url, "ttl=");
    return ttl && strtol(ttl + 4, NULL, 10) != 0;
}

/* ADDRESS:PORT of a multicast group; what follows a '?' is liblcm's. */
static bool parse_group(const char *url, char group[16], unsigned *port)
{
    struct in_addr address;
    int end = 0;
    /* NOLINTNEXTLINE(cert-err34-c): five digits are no overflow */
    return sscanf(url, "udpm://%15[0-9.]:%5u%n", group, port, &end) == 2 && (!url[end] || url[end] == '?') &&
           *port > 0 && *port <= UINT16_MAX && inet_pton(AF_INET, group, &address) == 1 &&
           IN_MULTICAST(ntohl(address.s_addr));
}

/* What lcm_open needs to know, too: the whole URL and the gateway's path. */
static int check_address(const link_options *o, char url[URL_MAX], char program[GATEWAY_PATH_MAX],
    char key[LINK_KEY_MAX], char *why, size_t why_size)
{
    char group[16];
    unsigned port;
    if (!complete_url(o->address, url, URL_MAX) || !parse_group(url, group, &port))
        snprintf(why, why_size,
            "lcm://%.80s: expected lcm://udpm://ADDRESS:PORT, as in lcm://udpm://239.255.76.67:7667", o->address);
    else if (leaves_machine(url) && !o->interface[0])
        snprintf(why, why_size, "lcm://%.80s: a ttl above 0 leaves this machine: set the interface too", o->address);
    else if (!interface_is_there(o->interface, why, why_size))
        return EX_NOHOST;
    else if (!gateway_program(o->program, program, why, why_size))
        return EX_OSFILE;
    else
        return snprintf(key, LINK_KEY_MAX, "lcm %s:%u", group, port) > 0 ? EX_OK : EX_SOFTWARE;
    return EX_CONFIG;
}

static int lcm_check(const link_options *options, char key[LINK_KEY_MAX], char *why, size_t why_size)
{
    char url[URL_MAX], program[GATEWAY_PATH_MAX];
    int status = check_address(options, url, program, key, why, why_size);
    if (status == EX_OK && !route_leads_to(url, options->interface, why, why_size)) return EX_UNAVAILABLE;
    return status;
}

static void register_lcm_counters(link_lcm *l, metrics *m)
{
    l->messages_in = metrics_add(m, "lcm_messages_in", "messages of clients taken from LCM");
    l->refused = metrics_add(m, "lcm_refused", "messages from LCM that were refused: malformed or out of range");
    l->queue_full = metrics_add(m, "lcm_queue_full", "messages from LCM dropped because the tick did not take them");
    l->queue_full_poses = metrics_add(m, "lcm_queue_full_poses", "the same, poses and vertices: these go first");
    l->messages_out = metrics_add(m, "lcm_messages_out", "messages handed to the LCM gateway");
    l->out_dropped = metrics_add(m, "lcm_out_dropped", "messages dropped because the LCM gateway did not take them");
    l->restarts = metrics_add(m, "lcm_gateway_restarts", "times that collided-lcm was started again");
    l->datagrams_dropped = metrics_add(
        m, "lcm_datagrams_dropped", "datagrams to LCM's port that the kernel dropped: no LCM, or its buffer was full");
    l->bad_frames = metrics_add(m, "lcm_bad_frames", "gateways ended because they did not speak in frames");
}

static void drop_waiting(link_lcm *l)
{
    void *f;
    while ((f = turns_next(&l->waiting)) != NULL) free(f);
    turns_free(&l->waiting);
}

static void release(link_lcm *l)
{
    close(l->poke_fd);
    pthread_cond_destroy(&l->settled);
    pthread_mutex_destroy(&l->lock);
    wire_memory_destroy(l->memory);
    opened_free(&l->streams);
    drop_waiting(l);
    pipe_free(&l->taken);
    pipe_free(&l->incoming);
    pipe_free(&l->outgoing);
}

/* The watcher handles no signals: they are the main thread's. */
static int start_watcher(link_lcm *l)
{
    sigset_t all, before;
    sigfillset(&all);
    pthread_sigmask(SIG_SETMASK, &all, &before);
    int error = pthread_create(&l->watcher, NULL, watch, l);
    pthread_sigmask(SIG_SETMASK, &before, NULL);
    return error;
}

/* False: the first gateway has not started, and `why` tells of it. */
static bool await_first(link_lcm *l, char *why, size_t why_size)
{
    struct timespec until;
    clock_gettime(CLOCK_MONOTONIC, &until);
    until.tv_sec += START_MS / 1000;
    pthread_mutex_lock(&l->lock);
    int error = 0;
    while (!l->ready && !*l->failure && error == 0)
        error = pthread_cond_clockwait(&l->settled, &l->lock, CLOCK_MONOTONIC, &until);
    if (!l->ready && !*l->failure)
        snprintf(why, why_size, "lcm://%s: %.200s does not answer: is it collided-lcm of this release?",
            l->head.options.address, l->program);
    else if (!l->ready)
        snprintf(why, why_size, "lcm://%s: %s", l->head.options.address, l->failure);
    bool ready = l->ready;
    pthread_mutex_unlock(&l->lock);
    return ready;
}

static void lcm_close(struct link *head)
{
    link_lcm *l = link_lcm_of(head);
    atomic_store(&l->closing, true);
    wake(l->poke_fd);
    pthread_join(l->watcher, NULL);
    release(l);
}

static int lcm_open(struct link *head, const link_options *options, char *why, size_t why_size)
{
    link_lcm *l = link_lcm_of(head);
    char key[LINK_KEY_MAX];
    if (check_address(options, l->url, l->program, key, why, why_size) != EX_OK) return -1;
    register_lcm_counters(l, options->counters);
    l->pipe = -1;
    l->words.fd = -1;
    l->starting = options->must_start;
    l->memory = wire_memory_create();
    turns_init(&l->waiting);
    pthread_mutex_init(&l->lock, NULL);
    pthread_cond_init(&l->settled, NULL);
    l->poke_fd = eventfd(0, EFD_NONBLOCK | EFD_CLOEXEC);
    int error = l->poke_fd < 0 ? errno : start_watcher(l);
    if (error) {
        snprintf(why, why_size, "lcm: the thread that watches the gateway does not start: %s", strerror(error));
        release(l);
        return -1;
    }
    if (!options->must_start || await_first(l, why, why_size)) return 0;
    lcm_close(head);
    return -1;
}

/* One frame of the gateway, to the sink. True if it was a message. */
static bool hand_over_frame(link_lcm *l, const link_sink *sink, const pipe_frame *f, incoming_part *part)
{
    part->whole = true;
    part->work = 0;
    if (f->kind == PIPE_MESSAGE) return incoming_some(&l->head, sink, l->memory, f->data, f->size, part);
    pipe_refusal r = {.reason = WIRE_MALFORMED, .text = "a refusal of the gateway that cannot be read"};
    if (!pipe_get_refusal(f, &r)) metric_count(l->bad_frames, 1);
    wire_refusal why = {.reason = (wire_reason)r.reason};
    memcpy(why.text, r.text, sizeof why.text);
    sink->refused(sink->context, &l->head, (wire_kind)r.kind, r.client, r.sequence, &why);
    return false;
}

/* Who says to have sent it, which anybody may: nobody is told apart. All kinds begin alike: fingerprint, version,
 * client, big-endian. */
static uint64_t source_of(const pipe_frame *f)
{
    enum { CLIENT_AT = 12 };
    uint64_t client = 0;
    for (size_t i = CLIENT_AT; i < CLIENT_AT + 8 && f->size >= CLIENT_AT + 8; i++) client = client << 8 | f->data[i];
    return f->kind == PIPE_MESSAGE && client ? client : UINT64_MAX; /* refusals: whosever they are */
}

/* A copy of what comes behind the head of a frame. */
typedef struct frame_waiting {
    pipe_kind kind;
    uint32_t done; /* of its poses, if it has some */
    size_t size;
    uint8_t data[];
} frame_waiting;

static void put_off_frame(link_lcm *l, const pipe_frame *f, uint32_t done)
{
    uint64_t source = source_of(f);
    if (is_pose(f) && turns_bytes_of(&l->waiting, source) + f->size > ONE_POSE_BYTES) {
        metric_count(l->queue_full_poses, 1);
        return;
    }
    frame_waiting *w = base_alloc(sizeof *w + f->size, 1);
    w->kind = f->kind;
    w->done = done;
    w->size = f->size;
    memcpy(w->data, f->data, f->size);
    turns_put(&l->waiting, source, w, f->size);
}

static size_t count_one(link_lcm *l, bool was_message)
{
    metric_count(was_message ? l->messages_in : l->refused, 1);
    return was_message;
}

/* More than a round takes has come: each client has its turns, and the rest waits. */
static size_t receive_by_turns(link_lcm *l, const link_sink *sink)
{
    size_t messages = 0, bytes = 0;
    pipe_frame f;
    frame_waiting *w;
    while (pipe_take(&l->taken, &f) == 1) put_off_frame(l, &f, 0);
    while (bytes < ROUND_BYTES && !(messages && sink->enough && sink->enough(sink->context)) &&
           !(messages && link_has_much(sink)) && (w = turns_first(&l->waiting)) != NULL) {
        const pipe_frame whole = {.kind = w->kind, .data = w->data, .size = w->size};
        incoming_part part = {.done = w->done};
        bool was = hand_over_frame(l, sink, &whole, &part);
        bytes += w->size;
        if (part.whole) {
            turns_take(&l->waiting, link_bytes_of_work(part.work));
            messages += count_one(l, was);
            free(w);
        } else {
            turns_part(&l->waiting, 0, link_bytes_of_work(part.work));
            w->done = part.done;
            messages++;
        }
    }
    if (l->waiting.count) wake(l->head.options.wake_fd);
    return messages;
}

/* As it comes; where it is more than this round takes, the rest waits, and all that follows. */
static size_t receive_one(link_lcm *l, const link_sink *sink, const pipe_frame *f)
{
    incoming_part part = {.done = 0};
    bool was = hand_over_frame(l, sink, f, &part);
    if (part.whole) return count_one(l, was);
    put_off_frame(l, f, part.done);
    return 1 + receive_by_turns(l, sink);
}

static size_t lcm_receive(struct link *head, const link_sink *sink)
{
    link_lcm *l = link_lcm_of(head);
    opened_report(&l->streams, head, sink);
    pthread_mutex_lock(&l->lock);
    pipe_buffer swapped = l->incoming;
    l->incoming = l->taken;
    l->taken = swapped;
    l->waiting_bytes += pipe_used(&l->taken);
    pthread_mutex_unlock(&l->lock);
    size_t messages = 0;
    pipe_frame f;
    if (l->waiting.count || pipe_used(&l->taken) > DIRECT_BYTES) messages = receive_by_turns(l, sink);
    while (pipe_take(&l->taken, &f) == 1) messages += receive_one(l, sink, &f);
    pthread_mutex_lock(&l->lock);
    l->waiting_bytes = l->waiting.bytes;
    pthread_mutex_unlock(&l->lock);
    return messages;
}

/* Among what waits are commands: they are the tick thread's, and come first. */
static size_t lcm_receive_poses(struct link *head, const link_sink *sink)
{
    if (!link_lcm_of(head)->waiting.count) return lcm_receive(head, sink);
    wake(head->options.wake_fd);
    return 0;
}

static void lcm_publish(struct link *head, const wire_message *m)
{
    link_lcm *l = link_lcm_of(head);
    char channel[WIRE_CHANNEL_MAX];
    wire_lcm_channel(m, channel);
    size_t size = wire_lcm_size(m), frame = pipe_frame_size(strlen(channel), size);
    pthread_mutex_lock(&l->lock);
    bool fits = size <= PIPE_DATA_MAX && pipe_used(&l->outgoing) + frame <= OUT_BYTES;
    if (fits) wire_lcm_encode(m, pipe_put(&l->outgoing, PIPE_MESSAGE, channel, size), size);
    pthread_mutex_unlock(&l->lock);
    metric_count(fits ? l->messages_out : l->out_dropped, 1);
}

/* Sends what the pipe takes; the watcher sends the rest when it can. */
static void lcm_flush(struct link *head)
{
    link_lcm *l = link_lcm_of(head);
    pthread_mutex_lock(&l->lock);
    if (l->ready) pipe_send(&l->outgoing, l->pipe); /* a gateway that has gone is the watcher's business */
    bool rest = l->ready && pipe_used(&l->outgoing) > 0;
    pthread_mutex_unlock(&l->lock);
    if (rest) wake(l->poke_fd);
}

static void lcm_stream_open(struct link *head, const char *stream, int64_t client)
{
    (void)client;
    opened_add(&link_lcm_of(head)->streams, stream);
    wake(head->options.wake_fd);
}

static void lcm_stream_close(struct link *head, const char *stream)
{
    (void)head; /* a channel of LCM leaves nothing behind */
    (void)stream;
}

static void lcm_describe(struct link *head, char *text, size_t size)
{
    link_lcm *l = link_lcm_of(head);
    const char *interface = head->options.interface;
    pthread_mutex_lock(&l->lock);
    bool ready = l->ready;
    pthread_mutex_unlock(&l->lock);
    snprintf(text, size, "LCM %s on %s: %s%s", l->url, interface[0] ? interface : "lo",
        interface[0] ? "anyone on that network, unauthenticated" : "programs on this machine, of any user",
        ready ? "" : "; the gateway is not running");
}

const link_ops link_lcm_ops = {
    .scheme = "lcm",
    .size = sizeof(link_lcm),
    .has_liveliness = false,
    .acknowledges = true,
    .check = lcm_check,
    .open = lcm_open,
    .receive = lcm_receive,
    .receive_poses = lcm_receive_poses,
    .publish = lcm_publish,
    .flush = lcm_flush,
    .stream_open = lcm_stream_open,
    .stream_close = lcm_stream_close,
    .describe = lcm_describe,
    .close = lcm_close,
};
