/* server: sets up the links and the world, and runs the loop: wait, take, apply, tick, publish. The tick thread is the
 * one that calls server_run. It has the lock, but for the time that it waits: then a thread of a link may stand in for
 * it, for a round with the poses that have just come there (poses_arrived). */
#include "server.h"

#include "base/ahead.h"
#include "base/clock.h"
#include "base/log.h"
#include "clients.h"
#include "commands.h"
#include "geometries.h"
#include "intake.h"
#include "link/link_open.h"
#include "link/wake.h"
#include "memory.h"
#include "models.h"
#include "notify.h"
#include "privileges.h"
#include "recordings.h"
#include "replay.h"
#include "replay_served.h"
#include "service.h"
#include "shares.h"
#include "sheet.h"
#include "standby.h"
#include "streams.h"
#include "suspect.h"
#include "vertices.h"

#include <errno.h>
#include <inttypes.h>
#include <poll.h>
#include <pthread.h>
#include <sched.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/eventfd.h>
#include <sysexits.h>
#include <unistd.h>

struct server {
    service s;
    pthread_mutex_t lock; /* guards all but what is atomic */
    _Atomic bool stop;
    _Atomic bool record_end; /* the operator asks for the end of the recording */
    _Atomic bool waiting; /* the tick thread, until wakes_ns: set under the lock, reset before it is asked for again */
    _Atomic bool missed;  /* poses came while a round was on */
    int64_t status_ns, next_status_ns, next_tick_ns; /* monotonic; status_ns: the last one */
    notify manager;
    int64_t wakes_ns;      /* monotonic */
    int64_t round_ns;      /* what rounds take: the last one, or what is left of a longer one before */
    int64_t offered_ns;    /* end of the last offer of poses, monotonic */
    unsigned close_offers; /* in a row, with no pause between them */
    int64_t ticked_ns;     /* monotonic */
    bool touches_ahead;    /* memory, by a thread of this server's */
    bool calm;             /* the last round had nothing but poses that change nothing */
};

/* ---- what the links call ---- */

static void on_message(void *context, struct link *from, const wire_message *m)
{
    intake_offer(context, from, m);
}

static void on_refused(
    void *context, struct link *from, wire_kind kind, int64_t client, int64_t sequence, const wire_refusal *why)
{
    service *s = context;
    size_t most = (size_t)s->config.max_clients;
    wire_refusal same;
    if (why->reason == WIRE_LIMIT) apply_limit(s, most, (long)most, "max_clients", &same); /* the only one of a link */
    apply_reject(s, from, kind, client, sequence, -1, why);
}

static void on_client_lost(void *context, struct link *from, int64_t client)
{
    service *s = context;
    if (!standby_takes_lost(s, from, client)) inbox_put_lost(s, from, client);
}

static void on_stream_reader(void *context, struct link *from, const char *stream)
{
    service *s = context;
    if (standby_takes_reader(s, from, stream)) return;
    standby_journal_reader(s, from, stream);
    stream_reader(s, from, stream);
}

static void on_steps_done(void *context, int64_t step)
{
    steps_began(context, step);
}

/* Of a recording that begins in the middle. What has been announced in it until here stands there for who cannot take
 * the state, which holds all of it. */
static void on_state(void *context, const uint8_t *bytes, size_t size)
{
    service *s = context;
    taken_state *t = &s->taken;
    bytes_in from = {.at = bytes, .left = size};
    *t = (taken_state){.is_there = false};
    if (!state_fits(bytes, size, t->left, sizeof t->left)) return;
    service_reset(s);
    t->is_there = state_take(s, &from, t->wrong, sizeof t->wrong);
    t->events = world_get_figures(s->world).events;
    s->state_due = s->recording != NULL;
}

static void on_build(void *context, int64_t client, int64_t hash, bool ready)
{
    geometry_report(context, client, hash, ready);
}

/* At a fixed rate a tick takes all that has come. */
static bool on_enough(void *context)
{
    const service *s = context;
    return !(s->config.rate > 0) && poses_are_enough(s);
}

static size_t on_room(void *context, const wire_pose_batch *m, uint64_t *work)
{
    service *s = context;
    return s->config.rate > 0 ? m->bodies.count : poses_room(s, m, work);
}

/* Decoding and checking, and what is done with it before the tick, take about what is charged for it, on a machine that
 * has nothing else to do. On others the clock says when it is enough; it is read once in a while. */
static const double RECEIVED_MOST_US = 5000, LOOK_EACH_US = 250;
static const int64_t RECEIVED_MOST_NS = 8000000; /* of a processor */

static bool on_much(void *context)
{
    service *s = context;
    if (s->received_us >= RECEIVED_MOST_US) return true;
    if (s->received_us < s->receive_look_us) return false;
    s->receive_look_us = s->received_us + LOOK_EACH_US;
    return s->receive_began_ns && clock_thread_ns() - s->receive_began_ns >= RECEIVED_MOST_NS;
}

static void on_status_reader(void *context, struct link *from)
{
    (void)from;
    ((service *)context)->status_asked = true;
}

static void on_lost(void *context, struct link *from, wire_kind kind, int64_t client, size_t count)
{
    unheard_lost(context, from, kind, client, count);
}

static link_sink sink_of(service *s)
{
    return (link_sink){s, on_message, on_refused, on_client_lost, on_stream_reader, on_steps_done, on_state, on_build,
        on_enough, on_room, on_much, on_status_reader, on_lost};
}

/* ---- set-up ---- */

/* Of the processors that are there, those that this process may run on. */
static unsigned worker_count(const config *c)
{
    cpu_set_t may;
    long cores = sched_getaffinity(0, sizeof may, &may) == 0 ? CPU_COUNT(&may) : sysconf(_SC_NPROCESSORS_ONLN);
    return c->workers ? (unsigned)c->workers : (unsigned)(cores < 1 ? 1 : cores > 8 ? 8 : cores);
}

static narrow_engine engine_of(const char *name)
{
    return !strcmp(name, "gjk")   ? NARROW_ENGINE_GJK
           : !strcmp(name, "ccd") ? NARROW_ENGINE_CCD
           : !strcmp(name, "mpr") ? NARROW_ENGINE_MPR
                                  : NARROW_ENGINE_AUTO;
}

static broad_kind broad_of(const char *name)
{
    broad_kind kind = BROAD_SWEEP1;
    while (kind != BROAD_AUTO && strcmp(name, broad_kind_name(kind)) != 0) kind--;
    return kind;
}

static bool poses_arrived(void *context, struct link *from);

static int open_link(server *v, const char *uri, char *why, size_t why_size)
{
    service *s = &v->s;
    link_options options = {.wake_fd = s->wake_fd,
        .poses = poses_arrived,
        .poses_context = v,
        .counters = s->metrics,
        .interface = s->config.interface,
        .security = s->config.security,
        .program = s->config.gateway,
        .max_clients = (size_t)s->config.max_clients,
        .client_share = (size_t)(s->config.max_clients * s->config.share / 100 + (s->config.max_clients == 1)),
        /* The other daemon of a pair would not be in them. */
        .rooms = !s->config.standby && !s->replaying,
        .must_start = true};
    if (s->link_count == LINKS_MAX) {
        snprintf(why, why_size, "links: more than %d", LINKS_MAX);
        return -1;
    }
    struct link *l = link_open(uri, &options, why, why_size);
    if (!l) return -1;
    s->links[s->link_count++] = l;
    return 0;
}

/* First those of whose opening nobody hears: if one fails, nothing has been announced. */
static int open_links(server *v, char *why, size_t why_size)
{
    service *s = &v->s;
    for (int announced = 0; announced < 2; announced++) {
        char list[CONFIG_TEXT_MAX + 16], *rest = NULL;
        if (s->replaying)
            snprintf(list, sizeof list, "replay://%s", s->config.replay);
        else
            snprintf(list, sizeof list, "%s", s->config.links);
        for (char *uri = strtok_r(list, " ,", &rest); uri; uri = strtok_r(NULL, " ,", &rest))
            if (link_announces(uri) == announced && open_link(v, uri, why, why_size) != 0) return -1;
    }
    char observer[CONFIG_TEXT_MAX + 16];
    snprintf(observer, sizeof observer, "pipe://%s", s->config.replay_pipe);
    if (s->replaying && *s->config.replay_pipe && open_link(v, observer, why, why_size) != 0) return -1;
    if (s->link_count) return 0;
    snprintf(why, why_size, "links: none; allowed are dds://DOMAIN and lcm://...");
    return -1;
}

static void report_links(const service *s)
{
    for (size_t i = 0; i < s->link_count; i++) {
        char text[512];
        s->links[i]->ops->describe(s->links[i], text, sizeof text);
        log_notice("%s", text);
        if (*s->config.security && strcmp(s->links[i]->ops->scheme, "lcm") == 0)
            log_warning("security is set up, and LCM has none: whoever reaches it speaks for whom he likes");
    }
}

static void set_names(service *s)
{
    char host[64] = "?";
    gethostname(host, sizeof host - 1);
    if (*s->config.name)
        snprintf(s->daemon_name, sizeof s->daemon_name, "%s", s->config.name);
    else
        snprintf(s->daemon_name, sizeof s->daemon_name, "%s:%d", host, (int)getpid());
    s->started_ns = s->now_ns = clock_wall_ns();
    s->monotonic_ns = clock_monotonic_ns();
    s->epoch = wire_new_line(s->started_ns); /* later daemons have later epochs */
}

static world *make_world(const config *c)
{
    world_options options = world_options_default();
    options.workers = worker_count(c);
    options.engine = engine_of(c->engine);
    options.broad = broad_of(c->broad);
    options.caches = c->caches;
    options.margin = c->margin;
    options.max_pairs = (size_t)c->max_pairs;
    return world_create(&options);
}

static void free_clients(service *s)
{
    stream_free_all(s);
    session_free_all(s);
    world_destroy(s->world);
    pending_free_all(s);
    vertices_free_all(s);
    geometry_free_all(s);
    s->inbox.commands.count = s->inbox.bytes.count = s->inbox.poses.count = 0;
    s->reported_builds.count = 0;
}

void service_reset(service *s)
{
    free_clients(s);
    pair_map_init(&s->session_of);
    pair_map_init(&s->open_streams);
    pair_map_init(&s->ending_streams);
    pair_map_init(&s->geometry_of);
    pair_map_init(&s->geometry_whole);
    s->geometry_last = 0;
    s->world = make_world(&s->config);
    s->recorded_budget = s->hull_came = s->geometries_loose = false;
    s->lock_step = (struct lock_step){.members = 0};
    s->latest_step = (step_mark){0};
    s->simulation = (simulation_mark){0};
    s->wall_ahead_ns = s->last_batch = 0;
    s->lost_count = s->left_count = 0;
    memset(s->left_clients, 0, sizeof s->left_clients);
    s->whole = s->stepped = false;
    s->latest_pose_ns = s->measured_pose_ns = 0;
    s->tick = s->status_tick = 0;
    s->events_hash = 0;
    s->starving[0] = '\0';
}

/* Of a recording, its first entry; where it cannot be read, the link says so. */
static int take_settings(config *c, char *why, size_t why_size)
{
    char unread[256];
    wire_log_entry e;
    wire_log_reader *r = wire_log_open(c->replay, unread, sizeof unread);
    int status = 0;
    if (r && wire_log_next(r, &e, NULL, unread, sizeof unread) == 1 && e.kind == WIRE_LOG_SETTINGS)
        status = config_take_deciding(c, (const char *)e.data, e.data_size, why, why_size);
    wire_log_end(r);
    return status;
}

static void stay_alive(void *context)
{
    server *v = context;
    if (v->manager.period_ns) notify_alive(&v->manager, clock_monotonic_ns());
}

server *server_create(const config *given, char *why, size_t why_size)
{
    config whole = *given, *c = &whole;
    if (*c->replay && take_settings(c, why, why_size) != 0) return NULL;
    privileges_no_more();
    server *v = base_zalloc(1, sizeof *v);
    service *s = &v->s;
    pthread_mutex_init(&v->lock, NULL);
    s->config = *c;
    s->replaying = *c->replay != '\0';
    s->wake_fd = eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK);
    s->builds = builds_create(s->wake_fd, !s->replaying);
    v->touches_ahead = !s->replaying && ahead_start();
    s->on_waiting = stay_alive;
    s->on_waiting_context = v;
    s->metrics = metrics_create();
    s->inbox.memory = wire_memory_create();
    pair_map_init(&s->session_of);
    pair_map_init(&s->open_streams);
    pair_map_init(&s->ending_streams);
    pair_map_init(&s->geometry_of);
    pair_map_init(&s->geometry_whole);
    s->sheet = sheet_create();
    health_register(s);
    s->shares = shares_create();
    shares_register(s->shares, s->metrics);
    health_define(&s->measures);
    set_names(s);
    s->next_heartbeat_ns = s->next_watch_ns = INT64_MAX;
    s->world = make_world(c);
    service_set_budget(s);
    memory_open(s);
    if (c->metrics_port && !s->replaying)
        s->exporter = exporter_start((uint16_t)c->metrics_port, c->metrics_address, c->metrics_hosts, why, why_size);
    bool exports = s->exporter || !c->metrics_port || s->replaying;
    bool dropped = exports && privileges_drop(c->user, why, why_size) == 0; /* the port above may have needed them */
    if (dropped) suspect_open(s);
    /* The recording comes last: what fails before leaves no file. Nothing is taken from the links yet. */
    if (!dropped || open_links(v, why, why_size) != 0 || standby_start(s, why, why_size) != 0 ||
        (*c->record && !s->standby && record_start(s, c->record, NULL, why, why_size) != 0)) {
        server_destroy(v);
        return NULL;
    }
    return v;
}

void server_destroy(server *v)
{
    if (!v) return;
    service *s = &v->s;
    standby_free(s);
    stream_free_all(s);
    for (size_t i = 0; i < s->link_count; i++) link_close(s->links[i]);
    record_stop_now(s);
    free_clients(s);
    shares_destroy(s->shares);
    builds_destroy(s->builds);
    if (v->touches_ahead) ahead_stop();
    wire_memory_destroy(s->inbox.memory);
    if (s->backlog_memory) wire_memory_destroy(s->backlog_memory);
    array_free(&s->inbox.commands);
    array_free(&s->inbox.bytes);
    array_free(&s->inbox.poses);
    array_free(&s->shapes);
    array_free(&s->compounds);
    array_free(&s->rules);
    poses_free(s);
    models_free(s);
    free(s->part);
    exporter_stop(s->exporter);
    array_free(&s->page);
    sheet_destroy(s->sheet);
    metrics_destroy(s->metrics);
    memory_close(s);
    suspect_close(s);
    close(s->wake_fd);
    pthread_mutex_destroy(&v->lock);
    free(v);
}

/* ---- the loop ---- */

static const double OVER = 1.2; /* times its budget: a tick that takes longer is counted */

static void tick(service *s, int64_t round_began)
{
    int64_t began = clock_monotonic_ns();
    uint64_t reported = metric_get(s->count.events_out);
    s->tick++;
    s->pairs_most = memory_pairs_most(s);
    pace_begin(&s->pace, began);
    service_choose_slice(s, began - round_began);
    uint64_t effort = world_effort(s->world) + s->inbox.effort;
    double commands_us = shares_expected_us(s);
    service_tick(s);
    memory_after_tick(s);
    int64_t newest = s->latest_pose_ns; /* now: commands of the tick, and steps, have poses, too */
    int64_t ended = clock_monotonic_ns(), took = ended - began;
    pace_end(&s->pace, ended, world_get_figures(s->world).work);
    service_learn_slice(s, took);
    service_learn_effort(s, effort, took - (int64_t)(1e3 * commands_us));
    if (s->config.budget_us > 0 && (double)took > OVER * 1e3 * s->config.budget_us)
        metric_count(s->count.budget_over, 1);
    if (newest != s->measured_pose_ns && metric_get(s->count.events_out) != reported) {
        int64_t latency = clock_wall_ns() - newest;
        histogram_add(&s->measures.latency, 1e-9 * (double)latency);
        quantiles_add(&s->measures.latencies, latency);
    }
    s->measured_pose_ns = newest;
    histogram_add(&s->measures.tick, 1e-9 * (double)took);
    quantiles_add(&s->measures.ticks, took);
    metric_count(s->count.busy_ns, (uint64_t)took);
    metric_set(s->count.tick_ns, (uint64_t)took);
}

/* Whatever comes, and on whichever thread: a tick is due for what waits. */
static bool commands_wait(const service *s)
{
    return s->inbox.commands.count || pending_due(s) || builds_ready(s->builds);
}

/* Poses that change nothing need no tick of their own: the first that come so long after the last tick have one, and
 * those that are left come with one that is later still. */
static const int64_t CALM_NS = 2000000, LEFT_CALM_NS = 20000000;

/* But a step is answered at once, and who records, or is one of a pair, tells of poses tick by tick. */
static bool calm_due(const server *v)
{
    const service *s = &v->s;
    if (!world_glided(s->world)) return s->stepped;
    return s->stepped || s->recording || s->standby || s->monotonic_ns - v->ticked_ns >= CALM_NS;
}

static bool due(const server *v)
{
    const service *s = &v->s;
    if (s->config.rate > 0) return s->monotonic_ns >= v->next_tick_ns;
    return world_changed(s->world) || calm_due(v) || standby_wants_tick(s) || record_wants_tick(s) ||
           commands_wait(s) || s->now_ns >= world_next_due_ns(s->world) || steps_due(s) || shares_want_tick(s);
}

static int64_t earlier(int64_t a, int64_t b)
{
    return a < b ? a : b;
}

/* When the tick thread has something to do although nothing comes, monotonic. */
static int64_t next_wake_ns(const server *v)
{
    const service *s = &v->s;
    int64_t now = clock_monotonic_ns(), next = earlier(v->next_status_ns, session_next_lease_ns(s));
    next = earlier(next, earlier(s->next_heartbeat_ns, steps_next_ns(s)));
    next = earlier(next, earlier(s->next_watch_ns, scene_next_ns(s)));
    next = earlier(next, earlier(ready_next_ns(s), earlier(shares_next_ns(s), record_next_ns(s))));
    next = earlier(next, pending_next_ns(s));
    if (s->standby) next = earlier(next, standby_next_ns(s));
    if (standby_waits(s))
        next = earlier(v->next_status_ns, standby_next_ns(s));
    else if (s->config.rate > 0)
        next = earlier(next, v->next_tick_ns);
    else if (world_changed(s->world)) /* a budget has left something, or all of it */
        return now + (world_get_figures(s->world).work || world_get_figures(s->world).pending_bodies ? 0 : 1000000);
    else if (world_next_due_ns(s->world) != INT64_MAX)
        next = earlier(next, now + world_next_due_ns(s->world) - clock_wall_ns());
    if (world_glided(s->world) && !(s->config.rate > 0) && !standby_waits(s))
        next = earlier(next, v->ticked_ns + LEFT_CALM_NS);
    return earlier(next, v->manager.next_ns);
}

static int ms_until(int64_t ns)
{
    int64_t ms = (ns - clock_monotonic_ns() + 999999) / 1000000;
    return ms < 0 ? 0 : ms > 1000 ? 1000 : (int)ms;
}

static void wait_for_work(server *v)
{
    struct pollfd wake = {.fd = v->s.wake_fd, .events = POLLIN};
    uint64_t count;
    v->wakes_ns = next_wake_ns(v);
    v->waiting = true;
    int timeout_ms = ms_until(v->wakes_ns);
    pthread_mutex_unlock(&v->lock);
    int come = poll(&wake, 1, timeout_ms);
    v->waiting = false; /* whoever stands in finishes his round and begins no other */
    pthread_mutex_lock(&v->lock);
    if (come > 0 && read(v->s.wake_fd, &count, sizeof count) < 0 && errno != EAGAIN)
        log_error("wake-up: %s", strerror(errno));
}

/* Both of the same moment: who is interrupted between them tries again. */
static void set_clock(server *v)
{
    int64_t before = clock_monotonic_ns();
    for (int tries = 0; tries < 4; tries++) {
        v->s.now_ns = clock_wall_ns();
        v->s.monotonic_ns = clock_monotonic_ns();
        if (v->s.monotonic_ns - before < 1000000) return;
        before = v->s.monotonic_ns;
    }
}

static void publish_status(server *v, uint8_t health)
{
    service *s = &v->s;
    s->health = health;
    health_publish(s);
    for (size_t i = 0; i < s->link_count; i++) s->links[i]->ops->flush(s->links[i]);
    v->status_ns = s->monotonic_ns;
    v->next_status_ns = s->monotonic_ns + (int64_t)(s->config.status_period * 1e9);
}

/* Who has come gets it soon; but it goes to all, so the more there are the longer do newcomers wait for each other. */
static void publish_to_newcomers_soon(server *v)
{
    enum { ALONE_MS = 50, EACH_MS = 2 };
    service *s = &v->s;
    int64_t soon_ns = v->status_ns + (ALONE_MS + EACH_MS * (int64_t)s->sessions.count) * INT64_C(1000000);
    if (s->status_asked && soon_ns < v->next_status_ns) v->next_status_ns = soon_ns;
    s->status_asked = false;
}

/* To the service manager, when it changes. */
static void report_health(const service *s)
{
    char state[HEALTH_LIMITS_MAX + 48], limits[HEALTH_LIMITS_MAX];
    health_limits(s, limits, sizeof limits);
    snprintf(state, sizeof state, *limits ? "degraded: %s" : "ready", limits);
    notify_state(state);
}

static uint8_t health_now(service *s)
{
    unheard_watch(s);
    if (!s->whole || standby_waits(s)) return WIRE_HEALTH_STARTING;
    bool degraded =
        *s->limits || *s->starving || *s->unheard || *s->samples_lost || service_is_behind(s) || suspect_count(s);
    return degraded ? WIRE_HEALTH_DEGRADED : WIRE_HEALTH_READY;
}

/* A long round is remembered for some time: those that follow are likely to be long, or some of them. */
static void tick_if_due(server *v, int64_t began_ns)
{
    service *s = &v->s;
    steps_watch(s);
    v->calm = !world_changed(s->world) && !s->inbox.commands.count;
    if (!due(v)) { /* what came may have been refused all the same */
        for (size_t i = 0; i < s->link_count; i++) s->links[i]->ops->flush(s->links[i]);
        return;
    }
    if (s->config.rate > 0) v->next_tick_ns = s->monotonic_ns + (int64_t)(1e9 / s->config.rate);
    v->ticked_ns = s->monotonic_ns;
    tick(s, began_ns);
    standby_after_tick(s);
    int64_t took = clock_monotonic_ns() - began_ns, left = v->round_ns - v->round_ns / 16;
    v->round_ns = took > left ? took : left;
}

static void work(server *v, int64_t began_ns)
{
    service *s = &v->s;
    session_check_leases(s); /* after what has come: if this process stood still, its clients did not */
    set_clock(v);
    tick_if_due(v, began_ns);
    stream_heartbeats(s);
    backlog_watch(s);
    scene_watch(s);
    memory_trim(s);
    s->status_due |= !s->whole && ready_check(s);
}

static void raise_to(metric *m, int64_t ns)
{
    if ((uint64_t)ns > metric_get(m)) metric_set(m, (uint64_t)ns);
}

/* Whatever makes everybody wait is in here: the time, and the part of it that this thread worked. */
static void note_round(service *s, int64_t began_ns, int64_t thread_began_ns)
{
    raise_to(s->count.round_longest_ns, clock_monotonic_ns() - began_ns);
    raise_to(s->count.round_most_cpu_ns, clock_thread_ns() - thread_began_ns);
}

static void one_round(server *v, const link_sink *sink)
{
    service *s = &v->s;
    set_clock(v);
    int64_t began_ns = s->monotonic_ns;
    s->received_us = 0;
    s->receive_look_us = LOOK_EACH_US;
    s->receive_began_ns = s->replaying ? 0 : clock_thread_ns();
    /* Before poses by the new time are held against those by the old. */
    if (service_clock_back(s) && !standby_waits(s)) tick(s, s->monotonic_ns);
    for (size_t i = 0; i < s->link_count; i++) s->links[i]->ops->receive(s->links[i], sink);
    shares_release(s);
    notify_alive(&v->manager, s->monotonic_ns);
    if (!standby_round(s, sink)) work(v, began_ns);
    if (atomic_exchange(&v->record_end, false)) {
        log_notice("signal: the recording ends, if there is one");
        record_stop(s);
    }
    record_watch(s);
    publish_to_newcomers_soon(v);
    if (s->monotonic_ns < v->next_status_ns && !s->status_due) return;
    s->status_due = false;
    uint8_t before = s->health;
    publish_status(v, health_now(s));
    if (s->health != before) report_health(s);
}

/* ---- where poses arrive ---- */

/* A hand-over to the tick thread takes about as long as a small round. But a long one would keep the link's thread from
 * its packets, and poses that follow each other closely are cheaper by the batch, while the next ones are received,
 * unless they change nothing: then their numbers are in the cache here, and no tick follows. How long a round will be
 * is told by those before, and by what it takes to apply its poses. */
static const int64_t LONG_ROUND_NS = 300000, LONG_RECEIVE_NS = 75000, PAUSE_NS = 10000;
enum { CLOSE_OFFERS_MAX = 8 };

/* A thread of Cyclone's belongs to its domain: within its round it must not write to another one, whose garbage
 * collector would watch it from then on instead of its own (q_thread.h: gv is constant for internal threads). */
static bool is_only_dds(const service *s, const struct link *from)
{
    bool other = false;
    for (size_t i = 0; i < s->link_count; i++) other |= s->links[i] != from && s->links[i]->ops == from->ops;
    return !other || strcmp(from->ops->scheme, "dds") != 0;
}

/* With the lock. The files of a recording are the tick thread's, and so are a clock's ticks. */
static bool suits(server *v, const struct link *from)
{
    const service *s = &v->s;
    int64_t pause_ns = clock_monotonic_ns() - v->offered_ns;
    bool is_close = pause_ns < PAUSE_NS || pause_ns < v->round_ns;
    v->close_offers = atomic_exchange(&v->missed, false) ? CLOSE_OFFERS_MAX : is_close ? v->close_offers + 1 : 0;
    bool short_enough = v->close_offers < CLOSE_OFFERS_MAX && v->round_ns < LONG_ROUND_NS;
    return !s->standby && !s->record_next && v->waiting && (v->calm || short_enough) && !(s->config.rate > 0) &&
           !s->recording && !s->inbox.commands.count && is_only_dds(s, from);
}

/* A round of poses alone: it takes no command, so it opens and closes nothing, and ends no client. Poses that have to
 * wait for commands wait for the tick thread. */
static bool poses_arrived(void *context, struct link *from)
{
    server *v = context;
    service *s = &v->s;
    if (pthread_mutex_trylock(&v->lock) != 0) {
        v->missed = true;
        return false;
    }
    bool here = suits(v, from);
    if (here) {
        set_clock(v);
        here = !service_clock_back(s) && !commands_wait(s); /* a tick comes before these poses */
    }
    if (here) {
        link_sink sink = sink_of(s);
        from->ops->receive_poses(from, &sink);
        bool small = !s->inbox.commands.count && clock_monotonic_ns() - s->monotonic_ns < LONG_RECEIVE_NS &&
                     (v->round_ns < LONG_ROUND_NS || !world_changed(s->world));
        int64_t ticks = s->tick;
        s->poses_only = true;
        if (small) tick_if_due(v, s->monotonic_ns);
        s->poses_only = false;
        metric_count(s->count.ticks_on_arrival, (uint64_t)(s->tick - ticks));
        if (!small || next_wake_ns(v) < v->wakes_ns) wake(s->wake_fd);
    }
    v->offered_ns = clock_monotonic_ns();
    pthread_mutex_unlock(&v->lock);
    return here;
}

/* Every contact ends, every stream closes, and everybody is told why. No command asks for it, so a recording ends
 * before. */
static void end_in_order(server *v)
{
    service *s = &v->s;
    set_clock(v);
    notify_stopping();
    if (s->inbox.commands.count && !standby_waits(s)) tick(s, s->monotonic_ns); /* what came with the signal */
    record_stop(s);
    if (standby_hands_over(s)) return;
    publish_status(v, WIRE_HEALTH_STOPPING);
    for (uint32_t i = 0; i < s->streams.count; i++)
        if (s->streams.at[i].live && !s->streams.at[i].ending) stream_end(s, i, CAUSE_SHUTDOWN);
    do {
        set_clock(v);
        tick(s, s->monotonic_ns);
        notify_alive(&v->manager, s->monotonic_ns);
    } while (world_is_closing(s->world));
}

static void begin(server *v)
{
    service *s = &v->s;
    char state[256];
    report_links(s);
    privileges_report(s->config.user);
    service_report_broad(s);
    snprintf(state, sizeof state, "%s is ready, %u worker(s), epoch %" PRId64, s->daemon_name, worker_count(&s->config),
        s->epoch);
    log_notice("%s", state);
    ready_begin(s);
    publish_status(v, health_now(s));
    v->manager = notify_start();
    notify_ready(state);
}

int server_run(server *v)
{
    link_sink sink = sink_of(&v->s);
    if (v->s.replaying && *v->s.config.replay_pipe) return replay_serve(&v->s, &sink, &v->stop);
    if (v->s.replaying) return replay_run(&v->s, &sink, &v->stop);
    pthread_mutex_lock(&v->lock);
    begin(v);
    while (!v->stop) {
        int64_t began_ns = clock_monotonic_ns(), thread_began_ns = clock_thread_ns();
        one_round(v, &sink);
        note_round(&v->s, began_ns, thread_began_ns);
        ahead_heap();
        wait_for_work(v);
    }
    end_in_order(v);
    pthread_mutex_unlock(&v->lock);
    return EX_OK;
}

service *server_service(server *v)
{
    return &v->s;
}

link_sink server_sink(server *v)
{
    return sink_of(&v->s);
}

void server_stop(server *v)
{
    uint64_t one = 1;
    v->stop = true;
    if (write(v->s.wake_fd, &one, sizeof one) < 0) log_error("wake-up: %s", strerror(errno));
}

void server_end_recording(server *v)
{
    uint64_t one = 1;
    v->record_end = true;
    if (write(v->s.wake_fd, &one, sizeof one) < 0) log_error("wake-up: %s", strerror(errno));
}
