/* replay_served: the loop around ticks of a recording that somebody looks at. Main thread. */
#include "replay_served.h"

#include "base/array.h"
#include "base/clock.h"
#include "health.h"
#include "link/link_pipe.h"
#include "recordings.h"
#include "replay.h"
#include "streams.h"
#include "wire/wire_log.h"

#include <errno.h>
#include <fcntl.h>
#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sysexits.h>
#include <unistd.h>

typedef struct tick_mark {
    int64_t now_ns, monotonic_ns;
} tick_mark;

typedef enum served_state { SERVED_PAUSED, SERVED_PLAYING, SERVED_SEEKING, SERVED_ENDED } served_state;

enum { WAITING_MOST = 8 << 20, LINE_MAX_BYTES = 128 };
static const int64_t SOON_NS = 50000000;    /* a command of the client waits so long for the next recorded tick */
static const int64_t SIGN_NS = 1000000000;  /* of life, while nothing comes */
static const int64_t REPORT_NS = 100000000; /* where it is, while it goes on */

typedef struct served {
    service *service;
    const link_sink *sink;
    struct link *observer;
    ARRAY(tick_mark) marks; /* of all ticks that can be read */
    size_t next;            /* of them */
    served_state state;
    double speed;
    int64_t until_ns;          /* seeking */
    int64_t began_ns, from_ns; /* playing: since when, here and in the recording */
    int64_t sign_ns, report_ns;
    char line[LINE_MAX_BYTES];
    size_t line_size;
    unsigned commands; /* that were carried out */
    bool again;        /* a tick of the client's commands was the last one */
    bool over;         /* nobody gives commands any more */
} served;

/* ---- what is in it ---- */

static void look_through(served *v, char *why, size_t why_size)
{
    wire_log_entry e;
    wire_log_reader *r = wire_log_open(v->service->config.replay, why, why_size);
    while (r && wire_log_next(r, &e, NULL, why, why_size) == 1)
        if (e.kind == WIRE_LOG_TICK) array_push(&v->marks, ((tick_mark){e.tick.now_ns, e.tick.monotonic_ns}));
    if (r) wire_log_end(r);
}

/* ---- what it says ---- */

static void report_place(served *v)
{
    static const char *const NAMES[] = {"paused", "playing", "seeking", "ended"};
    printf("at %" PRId64 " %" PRId64 " %s %.17g\n", v->service->now_ns, v->service->tick, NAMES[v->state], v->speed);
    fflush(stdout);
    v->report_ns = clock_monotonic_ns();
}

static void enter(served *v, served_state state)
{
    v->state = v->next == v->marks.count ? SERVED_ENDED : state;
    v->began_ns = clock_monotonic_ns();
    v->from_ns = v->service->monotonic_ns;
    report_place(v);
}

/* Who is there is to know that we are, although no tick comes. */
static void give_sign(served *v)
{
    service *s = v->service;
    v->sign_ns = clock_monotonic_ns();
    s->health = WIRE_HEALTH_READY;
    health_publish(s);
    stream_beat_all(s);
    v->observer->ops->flush(v->observer);
}

/* ---- what it is told ---- */

static void obey_command(served *v, const char *line)
{
    size_t word = strcspn(line, " ");
    const char *number = line + word + (line[word] == ' ');
    char *end = NULL;
    double speed = word == 4 && strncmp(line, "play", word) == 0 && *number ? strtod(number, &end) : NAN;
    if (end && *end == '\0' && isfinite(speed) && speed >= 0) {
        v->speed = speed;
        enter(v, SERVED_PLAYING);
    } else if (strcmp(line, "step") == 0) {
        v->until_ns = INT64_MIN; /* whichever tick is next is later */
        if (v->state != SERVED_ENDED) enter(v, SERVED_SEEKING);
    } else if (strcmp(line, "pause") == 0) {
        enter(v, SERVED_PAUSED);
    } else if (word == 2 && strncmp(line, "to", word) == 0 && *number) {
        v->until_ns = strtoll(number, NULL, 10);
        enter(v, SERVED_SEEKING);
    } else {
        fprintf(stderr, "collided: replay: '%s' is no command\n", line);
    }
}

/* What came before a command on the pipe counts before it. */
static void take_commands(served *v)
{
    char text[LINE_MAX_BYTES];
    ssize_t n = read(STDIN_FILENO, text, sizeof text);
    if (n == 0 || (n < 0 && errno != EAGAIN && errno != EINTR)) v->over = true;
    for (ssize_t i = 0; i < n; i++) {
        if (text[i] != '\n') {
            if (v->line_size < sizeof v->line - 1) v->line[v->line_size++] = text[i];
            continue;
        }
        v->line[v->line_size] = '\0';
        v->line_size = 0;
        v->observer->ops->receive(v->observer, v->sink);
        obey_command(v, v->line);
        printf("done %u\n", ++v->commands);
        fflush(stdout);
    }
}

/* ---- ticks ---- */

static void after_tick(served *v)
{
    service *s = v->service;
    stream_heartbeats(s);
    backlog_watch(s);
    scene_watch(s);
    v->observer->ops->flush(v->observer);
}

/* False: there is none after all. */
static bool recorded_tick(served *v)
{
    service *s = v->service;
    wire_log_tick t;
    char why[256] = "";
    if (!replay_take(s, v->sink, &t, why, sizeof why)) {
        fprintf(stderr, "collided: %s: %s\n", s->config.replay, *why ? why : "it has become shorter");
        v->marks.count = v->next;
        return false;
    }
    service_replay_budget(s, t.budgeted, (uint64_t)t.work);
    s->slice = (uint64_t)t.slice;
    if (s->taken.stands)
        record_tick(s);
    else
        service_tick(s);
    v->next++;
    after_tick(v);
    return true;
}

/* Of the client's commands alone. What a new subscription is told comes with one more: its stream has to be opened
 * before. */
static void still_tick(served *v)
{
    v->again = v->service->inbox.commands.count != 0;
    service_tick(v->service);
    after_tick(v);
}

/* When the next recorded tick is due, monotonic; INT64_MAX: it stands still. */
static int64_t due_ns(const served *v)
{
    if (v->state == SERVED_SEEKING || (v->state == SERVED_PLAYING && v->speed == 0)) return 0;
    if (v->state != SERVED_PLAYING) return INT64_MAX;
    return v->began_ns + (int64_t)((double)(v->marks.at[v->next].monotonic_ns - v->from_ns) / v->speed);
}

static void replay_go_on(served *v)
{
    if (!recorded_tick(v) || v->next == v->marks.count)
        enter(v, SERVED_ENDED);
    else if (v->state == SERVED_SEEKING && v->marks.at[v->next].now_ns > v->until_ns)
        enter(v, SERVED_PAUSED);
    else if (clock_monotonic_ns() - v->report_ns >= REPORT_NS)
        report_place(v);
}

static void wait_until(served *v, int64_t when_ns)
{
    struct pollfd fds[LINK_PIPE_FDS + 1];
    int64_t left = when_ns - clock_monotonic_ns();
    link_pipe_poll(v->observer, fds);
    fds[LINK_PIPE_FDS] = (struct pollfd){.fd = STDIN_FILENO, .events = POLLIN};
    struct timespec timeout = {.tv_sec = left > 0 ? left / 1000000000 : 0, .tv_nsec = left > 0 ? left % 1000000000 : 0};
    (void)ppoll(fds, LINK_PIPE_FDS + 1, &timeout, NULL);
    if (fds[LINK_PIPE_FDS].revents) take_commands(v);
}

static void serve_round(served *v)
{
    service *s = v->service;
    struct pollfd command = {.fd = STDIN_FILENO, .events = POLLIN};
    if (poll(&command, 1, 0) > 0) take_commands(v);
    v->observer->ops->receive(v->observer, v->sink);
    bool full = link_pipe_waiting(v->observer) > WAITING_MOST;
    int64_t now = clock_monotonic_ns(), due = due_ns(v);
    if (v->over) return;
    if (now - v->sign_ns >= SIGN_NS && !full) give_sign(v);
    if (due <= now && !full) {
        replay_go_on(v);
        return;
    }
    if ((s->inbox.commands.count || v->again) && !full && due - now > SOON_NS) {
        still_tick(v);
        return;
    }
    v->observer->ops->flush(v->observer);
    wait_until(v, due < v->sign_ns + SIGN_NS && !full ? due : v->sign_ns + SIGN_NS);
}

/* The observer comes after the state with which a recording may begin, which replaces all clients. */
static int replay_begin(served *v)
{
    char why[256] = "";
    look_through(v, why, sizeof why);
    if (v->marks.count && recorded_tick(v)) {
        printf("recording %" PRId64 " %" PRId64 " %zu\n", v->marks.at[0].now_ns, v->marks.at[v->marks.count - 1].now_ns,
            v->marks.count);
        if (*why) printf("damaged %s\n", why);
        enter(v, SERVED_PAUSED);
        give_sign(v);
        return EX_OK;
    }
    fprintf(stderr, "collided: %s: %s\n", v->service->config.replay,
        *why ? why : "no tick is in it: record while bodies move");
    return EX_DATAERR;
}

int replay_serve(service *s, const link_sink *sink, const _Atomic bool *stop)
{
    served v = {.service = s, .sink = sink, .observer = s->links[1]};
    int status = replay_begin(&v);
    (void)fcntl(STDIN_FILENO, F_SETFL, fcntl(STDIN_FILENO, F_GETFL) | O_NONBLOCK);
    while (!status && !*stop && !v.over && !link_pipe_is_gone(v.observer)) serve_round(&v);
    array_free(&v.marks);
    return status;
}
