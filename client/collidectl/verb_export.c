/* verb_export: a recording as an MCAP file. The recording is replayed by 'collided --replay', with one more client,
 * who observes the scene and subscribes to all pairs; what it is told becomes messages for Foxglove, and beside them
 * stand the recorded messages as they are. The replay goes on in steps of half a recorded second, between which the
 * numbers of new geometries are asked for: so the same recording gives the same file. */
#include "verbs.h"

#include "window/foxglove.h"
#include "window/mcap.h"
#include "window/playback.h"
#include "wire/wire_log.h"

#include <errno.h>
#include <inttypes.h>
#include <poll.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sysexits.h>
#include <unistd.h>

enum { COMPLETE_BODIES = 1000, RAW_CHANNELS = 1024 };
static const int64_t STEP_NS = 500000000, SECOND_NS = 1000000000;
static const double RATE_HZ = 30;

typedef struct raw_channel { /* of a recorded channel */
    char name[WIRE_CHANNEL_MAX];
    uint16_t number;
} raw_channel;

typedef struct exported {
    ctl *c;
    playback replay;
    mcap *file;
    mirror *mirror;
    triangles_kept kept;
    uint32_t asked; /* geometries below this have been asked for */
    uint16_t channels[FOXGLOVE_TOPICS];
    uint64_t next_event;                     /* from 1 */
    uint64_t scene, looks, posed, contacts;  /* changes that were written */
    int64_t scene_ns, posed_ns, contacts_ns; /* stamps of what was written last */
    int64_t stamp_ns;                        /* of the newest news */
    int64_t period_ns;
    bool begun; /* before, nothing is written: all geometries come first */
    wire_log_reader *log;
    wire_log_entry entry; /* the next one of the log; has_entry */
    bool has_entry;
    raw_channel raw[RAW_CHANNELS];
    size_t raw_count;
    uint64_t raw_left_out; /* records of more channels than that */
    int64_t ticks, lost;
    json_buffer json;
} exported;

/* ---- the recorded messages ---- */

static void next_entry(exported *x)
{
    char why[256];
    do x->has_entry = x->log && wire_log_next(x->log, &x->entry, NULL, why, sizeof why) == 1;
    while (x->has_entry && x->entry.kind != WIRE_LOG_MESSAGE);
}

static uint16_t raw_channel_of(exported *x, const wire_message *m)
{
    char name[WIRE_CHANNEL_MAX], topic[WIRE_CHANNEL_MAX + 32];
    wire_lcm_channel(m, name);
    for (size_t i = 0; i < x->raw_count; i++)
        if (strcmp(x->raw[i].name, name) == 0) return x->raw[i].number;
    if (x->raw_count == RAW_CHANNELS) return 0;
    snprintf(topic, sizeof topic, "/collided/raw/%s", name);
    raw_channel *r = &x->raw[x->raw_count++];
    snprintf(r->name, sizeof r->name, "%s", name);
    return r->number = mcap_add_channel(x->file, 0, topic, "lcm");
}

/* Those that came until then, so that the file is in the order of time. */
static void put_raw(exported *x, int64_t until_ns)
{
    for (; x->has_entry && 1000 * x->entry.timestamp_us <= until_ns; next_entry(x)) {
        uint16_t channel = raw_channel_of(x, &x->entry.message);
        int64_t at = 1000 * x->entry.timestamp_us;
        if (channel)
            mcap_message(x->file, channel, at, at, x->entry.data, x->entry.data_size);
        else
            x->raw_left_out++;
    }
}

/* ---- what the replay tells ---- */

static void put_json(exported *x, foxglove_topic topic, int64_t stamp_ns)
{
    mcap_message(x->file, x->channels[topic], stamp_ns, stamp_ns, x->json.at, x->json.count);
    x->json.count = 0;
}

/* All of it, so that who seeks to somewhere has the whole scene from the one message before: at most once a second. */
static void put_scene(exported *x, int64_t stamp_ns, bool now)
{
    uint64_t looks = foxglove_looks(x->mirror);
    bool changed = x->mirror->scene > x->scene || looks != x->looks;
    if (!changed || (!now && x->scene_ns && stamp_ns - x->scene_ns < SECOND_NS)) return;
    foxglove_scene(&x->json, x->mirror, &x->kept, stamp_ns);
    put_json(x, FOXGLOVE_SCENE, stamp_ns);
    x->scene = x->mirror->changes;
    x->looks = looks;
    x->scene_ns = stamp_ns;
}

/* The same holds of poses; of many bodies only once a second. */
static void put_transforms(exported *x, int64_t stamp_ns)
{
    bool all = x->mirror->live <= COMPLETE_BODIES || stamp_ns - x->posed_ns >= SECOND_NS;
    if (x->mirror->poses <= x->posed) return;
    size_t count = foxglove_transforms(&x->json, x->mirror, all ? 0 : x->posed, stamp_ns);
    if (count)
        put_json(x, FOXGLOVE_TRANSFORMS, stamp_ns);
    else
        x->json.count = 0;
    x->posed = x->mirror->changes;
    if (all) x->posed_ns = stamp_ns;
}

static void put_contacts(exported *x, int64_t stamp_ns, bool now)
{
    if (x->mirror->contacts_change <= x->contacts) return;
    if (!now && stamp_ns - x->contacts_ns < x->period_ns) return;
    foxglove_contacts(&x->json, x->mirror, stamp_ns);
    put_json(x, FOXGLOVE_CONTACTS, stamp_ns);
    foxglove_distances(&x->json, x->mirror, stamp_ns);
    put_json(x, FOXGLOVE_DISTANCES, stamp_ns);
    x->contacts = x->mirror->changes;
    x->contacts_ns = stamp_ns;
}

static void put_events(exported *x)
{
    const mirror *m = x->mirror;
    for (; x->next_event <= m->event_count; x->next_event++) {
        const mirror_event *e = &m->events[(x->next_event - 1) % MIRROR_EVENTS];
        if (m->event_count - x->next_event >= MIRROR_EVENTS) {
            x->lost++;
            continue;
        }
        foxglove_event(&x->json, m, e);
        put_json(x, FOXGLOVE_EVENTS, e->stamp_ns);
        foxglove_event_log(&x->json, m, e);
        put_json(x, FOXGLOVE_LOG, e->stamp_ns);
    }
}

static void put_news(exported *x, int64_t stamp_ns, bool now)
{
    if (stamp_ns > x->stamp_ns) x->stamp_ns = stamp_ns;
    if (!x->begun) return;
    put_raw(x, x->stamp_ns);
    put_scene(x, x->stamp_ns, now);
    put_transforms(x, x->stamp_ns);
    put_events(x);
    put_contacts(x, x->stamp_ns, now);
}

static void on_export_scene(void *context, const collided_scene *scene)
{
    exported *x = context;
    mirror_scene(x->mirror, scene);
    put_news(x, scene->stamp_ns, false);
}

/* A large batch is taken apart, so that no event falls out of the mirror before it is written. */
static void on_export_batch(void *context, const collided_batch *batch)
{
    exported *x = context;
    collided_batch part = *batch;
    for (size_t at = 0; at == 0 || at < batch->event_count; at += MIRROR_EVENTS) {
        size_t left = batch->event_count - at;
        part.events = batch->events ? batch->events + at : NULL;
        part.poses = batch->poses ? batch->poses + 2 * at : NULL;
        part.event_count = left < MIRROR_EVENTS ? left : MIRROR_EVENTS;
        if (at) part.snapshot = false; /* what came of it is not to be forgotten */
        if (at) part.lost = 0;
        mirror_batch(x->mirror, &part);
        if (x->begun) put_events(x);
    }
    if (!batch->heartbeat) put_news(x, batch->stamp_ns, false);
}

/* ---- its course ---- */

static void ask_geometries(exported *x)
{
    for (; x->asked < x->mirror->geometry_count; x->asked++) {
        const mirror_geometry *g = &x->mirror->geometries[x->asked];
        collided_geometry_numbers numbers = {0};
        const char *body = x->mirror->bodies[g->body].name;
        collided_status status = collided_query_geometry(
            x->c->client, body, (collided_geometry){g->hash}, x->c->options.timeout_s, &numbers);
        if (status == COLLIDED_OK)
            triangles_put(&x->kept, x->asked, &numbers);
        else
            fprintf(stderr, "collidectl: export: a geometry of '%s' is not drawn: %s\n", body,
                collided_status_text(status));
        collided_geometry_numbers_free(&numbers);
        x->scene = 0; /* it is drawn now */
    }
}

/* Until the replay rests, and all that it told has been taken: an answer comes behind all of it. */
static int take_step(exported *x)
{
    ctl *c = x->c;
    collided_result none = {0};
    while (!playback_rests(&x->replay) && !x->replay.gone) {
        struct pollfd fds[] = {
            {.fd = collided_fd(c->client), .events = POLLIN}, {.fd = x->replay.answers, .events = POLLIN}};
        (void)poll(fds, 2, 100);
        (void)collided_poll(c->client, 0);
        playback_poll(&x->replay);
        if (ctl_interrupted()) return ctl_fail(EX_TEMPFAIL, "export: interrupted");
    }
    if (x->replay.gone) return ctl_fail(EX_SOFTWARE, "export: the replay has ended too early");
    int status = ctl_check(c, collided_query_bodies(c->client, "none:", c->options.timeout_s, &none), "export");
    collided_result_free(&none);
    return status;
}

static int subscribe(exported *x)
{
    ctl *c = x->c;
    collided_def def = collided_def_default();
    def.name = "collidectl export";
    def.id = INT64_C(0x6578706f7274); /* always the same, so that the file is */
    def.lease_s = 3600;
    def.connect_timeout_s = c->options.timeout_s;
    c->client = collided_connect(playback_take_uri(&x->replay), &def);
    if (!c->client) return ctl_fail(EX_UNAVAILABLE, "export: %s", collided_connect_error());
    collided_observation_def scene = collided_observation_def_default();
    scene.rate_hz = c->options.rate_hz > 0 ? c->options.rate_hz : RATE_HZ;
    scene.callback = on_export_scene;
    scene.context = x;
    x->period_ns = (int64_t)(1e9 / scene.rate_hz);
    collided_subscription_def pairs = collided_subscription_def_default();
    pairs.facts = COLLIDED_TOUCH | COLLIDED_IMPACT | COLLIDED_PREDICT | COLLIDED_POSES;
    if (c->options.range_m > 0) pairs.facts |= COLLIDED_DISTANCE;
    pairs.range_m = c->options.range_m;
    pairs.horizon_s = c->options.horizon_s;
    pairs.callback = on_export_batch;
    pairs.context = x;
    if (collided_observe(c->client, &scene).id == COLLIDED_NONE ||
        collided_subscribe(c->client, &pairs).id == COLLIDED_NONE)
        return ctl_fail(EX_DATAERR, "export: %s", collided_error(c->client));
    return ctl_check(c, collided_sync(c->client, c->options.timeout_s), "export");
}

static void begin_file(exported *x)
{
    for (int i = 0; i < FOXGLOVE_TOPICS; i++) {
        const foxglove_channel *f = &foxglove_channels[i];
        uint16_t schema = mcap_add_schema(x->file, f->schema_name, "jsonschema", f->schema);
        x->channels[i] = mcap_add_channel(x->file, schema, f->topic, "json");
    }
    char why[256];
    x->log = wire_log_open(x->c->arguments[0], why, sizeof why);
    next_entry(x);
}

static int run_replay(exported *x)
{
    int status = subscribe(x);
    if (!status) status = take_step(x);
    if (status) return status;
    ask_geometries(x);
    x->begun = true;
    put_news(x, x->replay.at_ns, true);
    for (int64_t until = x->replay.begin_ns; !status && x->replay.state != PLAYBACK_ENDED;) {
        until += STEP_NS;
        playback_seek(&x->replay, until);
        status = take_step(x);
        ask_geometries(x);
    }
    put_news(x, x->replay.at_ns, true);
    put_raw(x, INT64_MAX);
    return status;
}

static int end_file(exported *x)
{
    char ticks[32], text[256];
    snprintf(ticks, sizeof ticks, "%" PRId64, x->replay.ticks);
    snprintf(text, sizeof text, "%s", x->replay.damaged);
    const char *slash = strrchr(x->c->arguments[0], '/');
    const char *const pairs[] = {"collided", collided_version(), "recording", slash ? slash + 1 : x->c->arguments[0],
        "ticks", ticks, "damaged", text, "raw", "LCM's encoding: idl/collided.lcm"};
    mcap_metadata(x->file, "collided", pairs, sizeof pairs / sizeof pairs[0] / 2);
    uint64_t messages = mcap_message_count(x->file);
    const char *path = x->c->options.mcap;
    int failed = mcap_close(x->file);
    x->file = NULL;
    if (failed) return ctl_fail(EX_IOERR, "export: %s: %s", path, strerror(errno));
    printf("%s: %" PRIu64 " messages of %" PRId64 " ticks, %.3f s\n", path, messages, x->replay.ticks,
        1e-9 * (double)(x->replay.end_ns - x->replay.begin_ns));
    if (x->raw_left_out)
        printf("%" PRIu64 " recorded messages are left out: they have more than %d channels\n", x->raw_left_out,
            RAW_CHANNELS);
    if (!*x->replay.damaged) return 0;
    return ctl_fail(
        EX_DATAERR, "export: %s: %s: what came before it is exported", x->c->arguments[0], x->replay.damaged);
}

static void free_export(exported *x)
{
    if (x->file) mcap_abandon(x->file);
    wire_log_end(x->log);
    mirror_destroy(x->mirror);
    triangles_free_all(&x->kept);
    free(x->json.at);
    free(x);
}

int verb_export(ctl *c)
{
    const char *recording = c->arguments[0];
    char why[256];
    if (!c->options.mcap) return ctl_fail(EX_USAGE, "export: --mcap FILE names the file to write");
    if (access(recording, R_OK) != 0) return ctl_fail(EX_NOINPUT, "export: %s: %s", recording, strerror(errno));
    if (access(c->options.mcap, F_OK) == 0)
        return ctl_fail(EX_CANTCREAT, "export: %s is there already: name another file", c->options.mcap);
    ctl_catch_signals();
    exported *x = calloc(1, sizeof *x);
    if (!x) return ctl_fail(EX_OSERR, "export: no memory");
    x->c = c;
    x->next_event = 1;
    x->mirror = mirror_create();
    int status = 0;
    if (!playback_open(&x->replay, ctl_find_daemon(c), recording, (long)c->options.workers, why, sizeof why)) {
        status = playback_close(&x->replay); /* it has said why, unless we do */
        if (*why) ctl_fail(EX_OSERR, "export: %s", why);
        free_export(x);
        return status ? status : EX_SOFTWARE;
    }
    x->file = mcap_create(c->options.mcap, "collidectl");
    if (!x->file) status = ctl_fail(EX_CANTCREAT, "export: %s: %s", c->options.mcap, strerror(errno));
    if (!status) {
        begin_file(x);
        status = run_replay(x);
    }
    ctl_disconnect(c);
    (void)playback_close(&x->replay);
    if (!status) status = end_file(x);
    free_export(x);
    return status;
}
