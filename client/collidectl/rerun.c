/* rerun: the replay's course, and what the client library tells of it. */
#include "rerun.h"

#include <errno.h>
#include <poll.h>
#include <stdio.h>
#include <string.h>
#include <sysexits.h>
#include <unistd.h>

static const int64_t STEP_NS = 500000000;
static const double RATE_HZ = 30;

static void on_rerun_scene(void *context, const collided_scene *scene)
{
    rerun *r = context;
    mirror_scene(r->mirror, scene);
    if (r->begun) r->news(r->context, scene->stamp_ns, false);
}

/* A large batch is taken apart, so that no event falls out of the mirror before it is taken. */
static void on_rerun_batch(void *context, const collided_batch *batch)
{
    rerun *r = context;
    collided_batch part = *batch;
    for (size_t at = 0; at == 0 || at < batch->event_count; at += MIRROR_EVENTS) {
        size_t left = batch->event_count - at;
        part.events = batch->events ? batch->events + at : NULL;
        part.poses = batch->poses ? batch->poses + 2 * at : NULL;
        part.event_count = left < MIRROR_EVENTS ? left : MIRROR_EVENTS;
        if (at) part.snapshot = false; /* what came of it is not to be forgotten */
        if (at) part.lost = 0;
        mirror_batch(r->mirror, &part);
        if (r->begun) r->events(r->context);
    }
    if (r->begun && !batch->heartbeat) r->news(r->context, batch->stamp_ns, false);
}

static void ask_geometries(rerun *r)
{
    for (; r->asked < r->mirror->geometry_count; r->asked++) {
        const mirror_geometry *g = &r->mirror->geometries[r->asked];
        collided_geometry_numbers numbers = {0};
        const char *body = r->mirror->bodies[g->body].name;
        collided_status status = collided_query_geometry(
            r->c->client, body, (collided_geometry){g->hash}, r->c->options.timeout_s, &numbers);
        if (status == COLLIDED_OK)
            r->geometry(r->context, r->asked, &numbers);
        else
            fprintf(stderr, "collidectl: %s: a geometry of '%s' is not drawn: %s\n", r->verb, body,
                collided_status_text(status));
        collided_geometry_numbers_free(&numbers);
    }
}

/* Until the replay rests, and all that it told has been taken: an answer comes behind all of it. */
static int take_step(rerun *r)
{
    ctl *c = r->c;
    collided_result none = {0};
    while (!playback_rests(&r->replay) && !r->replay.gone) {
        struct pollfd fds[] = {
            {.fd = collided_fd(c->client), .events = POLLIN}, {.fd = r->replay.answers, .events = POLLIN}};
        (void)poll(fds, 2, 100);
        (void)collided_poll(c->client, 0);
        playback_poll(&r->replay);
        if (ctl_interrupted()) return ctl_fail(EX_TEMPFAIL, "%s: interrupted", r->verb);
    }
    if (r->replay.gone) return ctl_fail(EX_SOFTWARE, "%s: the replay has ended too early", r->verb);
    int status = ctl_check(c, collided_query_bodies(c->client, "none:", c->options.timeout_s, &none), r->verb);
    collided_result_free(&none);
    return status;
}

static int subscribe(rerun *r)
{
    ctl *c = r->c;
    collided_def def = collided_def_default();
    def.name = r->verb;
    def.id = INT64_C(0x6578706f7274); /* always the same, so that the file is */
    def.lease_s = 3600;
    def.connect_timeout_s = c->options.timeout_s;
    c->client = collided_connect(playback_take_uri(&r->replay), &def);
    if (!c->client) return ctl_fail(EX_UNAVAILABLE, "%s: %s", r->verb, collided_connect_error());
    collided_observation_def scene = collided_observation_def_default();
    scene.rate_hz = c->options.rate_hz > 0 ? c->options.rate_hz : RATE_HZ;
    scene.callback = on_rerun_scene;
    scene.context = r;
    r->period_ns = (int64_t)(1e9 / scene.rate_hz);
    collided_subscription_def pairs = collided_subscription_def_default();
    pairs.facts = COLLIDED_TOUCH | COLLIDED_IMPACT | COLLIDED_PREDICT | COLLIDED_POSES;
    if (c->options.range_m > 0) pairs.facts |= COLLIDED_DISTANCE;
    pairs.range_m = c->options.range_m;
    pairs.horizon_s = c->options.horizon_s;
    pairs.callback = on_rerun_batch;
    pairs.context = r;
    if (collided_observe(c->client, &scene).id == COLLIDED_NONE ||
        collided_subscribe(c->client, &pairs).id == COLLIDED_NONE)
        return ctl_fail(EX_DATAERR, "%s: %s", r->verb, collided_error(c->client));
    return ctl_check(c, collided_sync(c->client, c->options.timeout_s), r->verb);
}

int rerun_run(rerun *r)
{
    int status = subscribe(r);
    if (!status) status = take_step(r);
    if (status) return status;
    ask_geometries(r);
    if (!r->mirror->stamp_ns) { /* nobody is there yet */
        r->mirror->stamp_ns = r->replay.at_ns;
        r->mirror->tick = r->replay.tick;
    }
    r->begun = true;
    r->news(r->context, r->replay.at_ns, true);
    for (int64_t until = r->replay.begin_ns; !status && r->replay.state != PLAYBACK_ENDED;) {
        until += STEP_NS;
        playback_seek(&r->replay, until);
        status = take_step(r);
        ask_geometries(r);
    }
    r->news(r->context, r->replay.at_ns, true);
    return status;
}

int rerun_open(rerun *r)
{
    const char *recording = r->c->arguments[0];
    char why[256];
    r->replay = (playback){.child = -1, .commands = -1, .answers = -1, .pipe = {-1, -1}};
    if (access(recording, R_OK) != 0) return ctl_fail(EX_NOINPUT, "%s: %s: %s", r->verb, recording, strerror(errno));
    ctl_catch_signals();
    r->mirror = mirror_create();
    if (playback_open(&r->replay, ctl_find_daemon(r->c), recording, (long)r->c->options.workers, why, sizeof why))
        return 0;
    int status = playback_close(&r->replay); /* it has said why, unless we do */
    if (*why) return ctl_fail(EX_OSERR, "%s: %s", r->verb, why);
    return status ? status : EX_SOFTWARE;
}

void rerun_close(rerun *r)
{
    ctl_disconnect(r->c);
    (void)playback_close(&r->replay);
    mirror_destroy(r->mirror);
    r->mirror = NULL;
}

int rerun_damage(const rerun *r)
{
    if (!*r->replay.damaged) return 0;
    return ctl_fail(
        EX_DATAERR, "%s: %s: %s: what came before it is in the file", r->verb, r->c->arguments[0], r->replay.damaged);
}
