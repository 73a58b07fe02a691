#include "strangers.h"

#include "rig.h"
#include "wire_dds/wire_dds.h"
#include "wire_dds/wire_dds_qos.h"
#include "wire_dds/wire_dds_security.h"

#include <dds/dds.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <unistd.h>

enum { DOMAIN = 61 };

static const double pose[7] = {0, 0, 0, 1, 0, 0, 0}, size[3] = {0.5, 0.5, 0.5}, radius[1] = {0};
static const uint8_t box[1] = {WIRE_SHAPE_BOX};
static const int64_t none[1] = {0};
static const int32_t body[1] = {3};

static wire_message message(wire_kind kind)
{
    if (kind == WIRE_CLIENT)
        return (wire_message){.kind = kind, .client = {.lease_ns = INT64_C(5000000000), .name = "stranger"}};
    if (kind == WIRE_POSE_BATCH)
        return (wire_message){
            .kind = kind, .pose_batch = {.bodies = {1, body}, .positions = {3, pose}, .orientations = {4, pose + 3}}};
    return (wire_message){.kind = kind,
        .body = {.body = body[0],
            .name = "stranger",
            .group = "",
            .category = 1,
            .mask = -1,
            .pose = {7, pose},
            .shape_types = {1, box},
            .shape_sizes = {3, size},
            .shape_radii = {1, radius},
            .shape_poses = {7, pose},
            .shape_geometries = {1, none}}};
}

static dds_entity_t open_writer(dds_entity_t participant, wire_kind kind)
{
    char name[WIRE_DDS_TOPIC_MAX];
    wire_dds_topic(kind, name);
    dds_entity_t topic = dds_create_topic(participant, wire_dds_descriptor(kind), name, NULL, NULL);
    dds_qos_t *qos = wire_dds_qos(kind, WIRE_DDS_WRITER, NULL, 0);
    dds_entity_t writer = topic > 0 ? dds_create_writer(participant, topic, qos, NULL) : topic;
    dds_delete_qos(qos);
    return writer;
}

static void write_one(dds_entity_t writer, wire_kind kind, int64_t sequence)
{
    wire_message m = message(kind);
    m.version = WIRE_VERSION;
    m.client.client = STRANGER_CLIENT;
    m.client.sequence = sequence;
    void *sample = calloc(1, wire_dds_sample_size(kind));
    wire_dds_encode(&m, sample);
    (void)dds_write(writer, sample);
    free(sample);
}

/* Its own access control, in front of Cyclone's: see lawless.c. */
static void make_lawless(dds_qos_t *qos)
{
    char *path = NULL;
    if (!dds_qget_prop(qos, "dds.sec.access.library.path", &path)) return;
    setenv("LAWFUL", path, 1);
    dds_free(path);
    dds_qset_prop(qos, "dds.sec.access.library.path", LAWLESS);
}

static dds_entity_t join(const char *security, bool lawless)
{
    char config[4096];
    wire_dds_config(config, sizeof config, "", WIRE_DDS_ANYBODY);
    if (dds_create_domain(DOMAIN, config) < 0) return -1;
    dds_qos_t *qos = wire_dds_security_qos(security);
    if (lawless) make_lawless(qos);
    dds_entity_t participant = dds_create_participant(DOMAIN, qos, NULL);
    dds_delete_qos(qos);
    return participant;
}

static uint32_t count_matches(const dds_entity_t *writers, int count)
{
    dds_publication_matched_status_t matched;
    uint32_t matches = 0;
    for (int i = 0; i < count; i++)
        if (dds_get_publication_matched_status(writers[i], &matched) == DDS_RETCODE_OK) matches += matched.total_count;
    return matches;
}

/* The lawless one is to be taken for a writer: it waits for that. */
static int write_for(const char *security, bool lawless, double seconds)
{
    static const wire_kind kinds[] = {WIRE_CLIENT, WIRE_BODY, WIRE_POSE_BATCH};
    enum { KINDS = sizeof kinds / sizeof kinds[0] };
    dds_entity_t writers[KINDS], participant = join(security, lawless);
    int64_t sequence = 0;
    if (participant <= 0) return STRANGER_NO_PARTICIPANT;
    for (int i = 0; i < KINDS; i++)
        if ((writers[i] = open_writer(participant, kinds[i])) <= 0) return STRANGER_NO_WRITER;
    double end = rig_now_s() + seconds;
    for (bool awaits = lawless; rig_now_s() < end || (awaits && rig_now_s() < end + RIG_PATIENCE_S); usleep(1000)) {
        for (int i = 0; i < KINDS; i++) write_one(writers[i], kinds[i], ++sequence);
        if (!awaits || !count_matches(writers, KINDS)) continue;
        awaits = false;
        end = rig_now_s() + seconds; /* a reader is found: from now on */
    }
    uint32_t matches = count_matches(writers, KINDS);
    if (lawless) (void)dds_wait_for_acks(writers[0], DDS_SECS((int64_t)RIG_PATIENCE_S));
    return matches ? STRANGER_MATCHED : 0;
}

int stranger_writes(const char *security, double seconds)
{
    return write_for(security, false, seconds);
}

int lawless_writes(const char *security, double seconds)
{
    return write_for(security, true, seconds);
}
