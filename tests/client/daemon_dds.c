/* daemon_dds: the counterpart over Cyclone DDS, by the profile that both sides share. */
#include "daemon.h"
#include "wire_dds/wire_dds.h"
#include "wire_dds/wire_dds_qos.h"

#include <dds/dds.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

enum { STREAMS_MAX = 64, TAKE = 16, STATUS_MS = 500 };
static const wire_kind incoming[] = {
    WIRE_CLIENT, WIRE_GEOMETRY, WIRE_BODY, WIRE_POSE_BATCH, WIRE_SUBSCRIPTION, WIRE_QUERY};
static const wire_kind outgoing[] = {WIRE_ACK, WIRE_ANSWER, WIRE_STATUS, WIRE_REJECT};
enum { INCOMING = sizeof incoming / sizeof incoming[0], OUTGOING = sizeof outgoing / sizeof outgoing[0] };

typedef struct dds_side {
    daemon_state *state;
    dds_entity_t participant, topics[WIRE_KIND_COUNT], ends[WIRE_KIND_COUNT];
    char *streams[STREAMS_MAX];
    dds_entity_t writers[STREAMS_MAX];
    int stream_count;
} dds_side;

static dds_entity_t stream_writer(dds_side *side, const char *stream)
{
    for (int i = 0; i < side->stream_count; i++)
        if (!strcmp(side->streams[i], stream)) return side->writers[i];
    dds_qos_t *qos = wire_dds_qos(WIRE_EVENT_BATCH, WIRE_DDS_WRITER, stream, 0);
    dds_entity_t publisher = dds_create_publisher(side->participant, qos, NULL);
    dds_entity_t writer = dds_create_writer(publisher, side->topics[WIRE_EVENT_BATCH], qos, NULL);
    dds_delete_qos(qos);
    dds_publication_matched_status_t matched = {0};
    for (int ms = 0; ms < 20000 && matched.current_count == 0; ms++) {
        (void)dds_get_publication_matched_status(writer, &matched);
        (void)usleep(1000);
    }
    side->streams[side->stream_count] = strdup(stream);
    side->writers[side->stream_count++] = writer;
    return writer;
}

static void send_dds(void *context, const wire_message *m)
{
    dds_side *side = context;
    void *sample = calloc(1, wire_dds_sample_size(m->kind));
    wire_dds_encode(m, sample);
    bool event = m->kind == WIRE_EVENT_BATCH;
    (void)dds_write(event ? stream_writer(side, m->event_batch.stream) : side->ends[m->kind], sample);
    free(sample);
}

static void take(dds_side *side, wire_kind kind)
{
    void *samples[TAKE] = {NULL};
    dds_sample_info_t infos[TAKE];
    int n = dds_take(side->ends[kind], samples, infos, TAKE, TAKE);
    for (int i = 0; i < n; i++) {
        wire_message m;
        wire_refusal why;
        if (!infos[i].valid_data) continue;
        if (wire_dds_decode(kind, samples[i], &m, &why) == WIRE_OK)
            daemon_react(side->state, &m, send_dds, side);
        else
            atomic_fetch_add(&side->state->malformed, 1);
    }
    if (n > 0) (void)dds_return_loan(side->ends[kind], samples, n);
}

static void open_end(dds_side *side, wire_kind kind, wire_dds_side end)
{
    char name[WIRE_DDS_TOPIC_MAX];
    wire_dds_topic(kind, name);
    side->topics[kind] = dds_create_topic(side->participant, wire_dds_descriptor(kind), name, NULL, NULL);
    if (kind == WIRE_EVENT_BATCH) return;
    dds_qos_t *qos = wire_dds_qos(kind, end, NULL, 0);
    if (kind == WIRE_ANSWER || kind == WIRE_REJECT || kind == WIRE_ACK) dds_qset_partition1(qos, "replies:*");
    side->ends[kind] = end == WIRE_DDS_READER ? dds_create_reader(side->participant, side->topics[kind], qos, NULL)
                                              : dds_create_writer(side->participant, side->topics[kind], qos, NULL);
    dds_delete_qos(qos);
}

void *daemon_dds(void *state)
{
    dds_side side = {.state = state};
    char config[4096];
    (void)wire_dds_config(config, sizeof config, "", WIRE_DDS_ANYBODY);
    dds_entity_t domain = dds_create_domain(7, config);
    side.participant = dds_create_participant(7, NULL, NULL);
    for (size_t i = 0; i < OUTGOING; i++) open_end(&side, outgoing[i], WIRE_DDS_WRITER);
    for (size_t i = 0; i < INCOMING; i++) open_end(&side, incoming[i], WIRE_DDS_READER);
    open_end(&side, WIRE_EVENT_BATCH, WIRE_DDS_WRITER);
    wire_message status = daemon_status();
    for (int ms = 0; !atomic_load(&side.state->stop); ms++) {
        if (ms % STATUS_MS == 0) send_dds(&side, &status);
        for (size_t i = 0; i < INCOMING; i++) take(&side, incoming[i]);
        (void)usleep(1000);
    }
    for (int i = 0; i < side.stream_count; i++) free(side.streams[i]);
    (void)dds_delete(side.participant);
    if (domain > 0) (void)dds_delete(domain);
    return NULL;
}
