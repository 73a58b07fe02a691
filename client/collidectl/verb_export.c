/* verb_export: a recording as an MCAP file: what its rerun tells becomes messages for Foxglove, and beside them stand
 * the recorded messages as they are. */
#include "rerun.h"
#include "verbs.h"

#include "window/foxglove.h"
#include "window/mcap.h"
#include "wire/wire_log.h"

#include <errno.h>
#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sysexits.h>
#include <unistd.h>

enum { COMPLETE_BODIES = 1000, RAW_CHANNELS = 1024 };
static const int64_t SECOND_NS = 1000000000;

typedef struct raw_channel { /* of a recorded channel */
    char name[WIRE_CHANNEL_MAX];
    uint16_t number;
} raw_channel;

typedef struct exported {
    ctl *c;
    rerun run;
    mcap *file;
    triangles_kept kept;
    uint16_t channels[FOXGLOVE_TOPICS];
    uint64_t next_event;                     /* from 1 */
    uint64_t scene, looks, posed, contacts;  /* changes that were written */
    int64_t scene_ns, posed_ns, contacts_ns; /* stamps of what was written last */
    int64_t stamp_ns;                        /* of the newest news */
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
    uint64_t looks = foxglove_looks(x->run.mirror);
    bool changed = x->run.mirror->scene > x->scene || looks != x->looks;
    if (!changed || (!now && x->scene_ns && stamp_ns - x->scene_ns < SECOND_NS)) return;
    foxglove_scene(&x->json, x->run.mirror, &x->kept, stamp_ns);
    put_json(x, FOXGLOVE_SCENE, stamp_ns);
    x->scene = x->run.mirror->changes;
    x->looks = looks;
    x->scene_ns = stamp_ns;
}

/* The same holds of poses; of many bodies only once a second. */
static void put_transforms(exported *x, int64_t stamp_ns)
{
    bool all = x->run.mirror->live <= COMPLETE_BODIES || stamp_ns - x->posed_ns >= SECOND_NS;
    if (x->run.mirror->poses <= x->posed) return;
    size_t count = foxglove_transforms(&x->json, x->run.mirror, all ? 0 : x->posed, stamp_ns);
    if (count)
        put_json(x, FOXGLOVE_TRANSFORMS, stamp_ns);
    else
        x->json.count = 0;
    x->posed = x->run.mirror->changes;
    if (all) x->posed_ns = stamp_ns;
}

static void put_contacts(exported *x, int64_t stamp_ns, bool now)
{
    if (x->run.mirror->contacts_change <= x->contacts) return;
    if (!now && stamp_ns - x->contacts_ns < x->run.period_ns) return;
    foxglove_contacts(&x->json, x->run.mirror, stamp_ns);
    put_json(x, FOXGLOVE_CONTACTS, stamp_ns);
    foxglove_distances(&x->json, x->run.mirror, stamp_ns);
    put_json(x, FOXGLOVE_DISTANCES, stamp_ns);
    x->contacts = x->run.mirror->changes;
    x->contacts_ns = stamp_ns;
}

static void put_events(void *context)
{
    exported *x = context;
    const mirror *m = x->run.mirror;
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

static void put_news(void *context, int64_t stamp_ns, bool now)
{
    exported *x = context;
    if (stamp_ns > x->stamp_ns) x->stamp_ns = stamp_ns;
    put_raw(x, x->stamp_ns);
    put_scene(x, x->stamp_ns, now);
    put_transforms(x, x->stamp_ns);
    put_events(x);
    put_contacts(x, x->stamp_ns, now);
}

static void take_geometry(void *context, uint32_t number, const collided_geometry_numbers *numbers)
{
    exported *x = context;
    triangles_put(&x->kept, number, numbers);
    x->scene = 0; /* it is drawn now */
}

/* ---- its course ---- */

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

static int end_file(exported *x)
{
    char ticks[32], text[256];
    snprintf(ticks, sizeof ticks, "%" PRId64, x->run.replay.ticks);
    snprintf(text, sizeof text, "%s", x->run.replay.damaged);
    const char *slash = strrchr(x->c->arguments[0], '/');
    const char *const pairs[] = {"collided", collided_version(), "recording", slash ? slash + 1 : x->c->arguments[0],
        "ticks", ticks, "damaged", text, "raw", "LCM's encoding: idl/collided.lcm"};
    mcap_metadata(x->file, "collided", pairs, sizeof pairs / sizeof pairs[0] / 2);
    uint64_t messages = mcap_message_count(x->file);
    const char *path = x->c->options.mcap;
    int failed = mcap_close(x->file);
    x->file = NULL;
    if (failed) return ctl_fail(EX_IOERR, "export: %s: %s", path, strerror(errno));
    printf("%s: %" PRIu64 " messages of %" PRId64 " ticks, %.3f s\n", path, messages, x->run.replay.ticks,
        1e-9 * (double)(x->run.replay.end_ns - x->run.replay.begin_ns));
    if (x->raw_left_out)
        printf("%" PRIu64 " recorded messages are left out: they have more than %d channels\n", x->raw_left_out,
            RAW_CHANNELS);
    return rerun_damage(&x->run);
}

int verb_export(ctl *c)
{
    const char *path = c->options.mcap;
    if (!path) return ctl_fail(EX_USAGE, "export: --mcap FILE names the file to write");
    if (access(path, F_OK) == 0) return ctl_fail(EX_CANTCREAT, "export: %s is there already: name another file", path);
    exported *x = calloc(1, sizeof *x);
    if (!x) return ctl_fail(EX_OSERR, "export: no memory");
    x->c = c;
    x->next_event = 1;
    x->run = (rerun){
        .c = c, .verb = "export", .context = x, .geometry = take_geometry, .news = put_news, .events = put_events};
    int status = rerun_open(&x->run);
    if (!status) x->file = mcap_create(path, "collidectl");
    if (!status && !x->file) status = ctl_fail(EX_CANTCREAT, "export: %s: %s", path, strerror(errno));
    if (!status) begin_file(x);
    if (!status) status = rerun_run(&x->run);
    if (!status) put_raw(x, INT64_MAX);
    if (!status) status = end_file(x);
    if (x->file) mcap_abandon(x->file);
    rerun_close(&x->run);
    if (x->log) wire_log_end(x->log);
    triangles_free_all(&x->kept);
    free(x->json.at);
    free(x);
    return status;
}
