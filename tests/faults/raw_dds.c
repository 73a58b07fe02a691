/* raw_dds: polls; the topics and their quality of service are those of wire_dds. */
#include "raw_dds.h"

#include "rig.h"
#include "wire_dds/wire_dds.h"
#include "wire_dds/wire_dds_qos.h"

#include <dds/dds.h>
#include <stdio.h>
#include <stdlib.h>
#include <unistd.h>

static dds_entity_t endpoint(dds_entity_t participant, wire_kind kind, wire_dds_side side)
{
    char name[WIRE_DDS_TOPIC_MAX];
    wire_dds_topic(kind, name);
    dds_entity_t topic = dds_create_topic(participant, wire_dds_descriptor(kind), name, NULL, NULL);
    dds_qos_t *qos = wire_dds_qos(kind, side, NULL, 0);
    dds_entity_t e = side == WIRE_DDS_WRITER ? dds_create_writer(participant, topic, qos, NULL)
                                             : dds_create_reader(participant, topic, qos, NULL);
    dds_delete_qos(qos);
    if (e <= 0) fail_msg("%s: %s", name, dds_strretcode(e));
    return e;
}

static uint32_t matched(dds_entity_t e, wire_dds_side side)
{
    dds_publication_matched_status_t p = {0};
    dds_subscription_matched_status_t s = {0};
    if (side == WIRE_DDS_WRITER)
        dds_get_publication_matched_status(e, &p);
    else
        dds_get_subscription_matched_status(e, &s);
    return p.current_count + s.current_count;
}

static void await_match(dds_entity_t e, wire_dds_side side)
{
    for (int i = 0; i < 6000 && matched(e, side) == 0; i++) usleep(5000);
    assert_true(matched(e, side) > 0);
}

void raw_open(raw_dds *r)
{
    *r = (raw_dds){.participant = dds_create_participant(61, NULL, NULL)}; /* RIG_DDS */
    assert_true(r->participant > 0);
    r->reader = endpoint(r->participant, WIRE_REJECT, WIRE_DDS_READER);
    for (wire_kind k = WIRE_CLIENT; k <= WIRE_QUERY; k++) r->writers[k] = endpoint(r->participant, k, WIRE_DDS_WRITER);
    await_match(r->reader, WIRE_DDS_READER);
    for (wire_kind k = WIRE_CLIENT; k <= WIRE_QUERY; k++) await_match(r->writers[k], WIRE_DDS_WRITER);
}

void raw_close(raw_dds *r)
{
    dds_delete(r->participant);
}

/* client and sequence follow the version in every message of a client, so any of them names them all. */
int64_t raw_send(raw_dds *r, wire_message *m)
{
    return raw_send_as(r, RAW_CLIENT, m);
}

int64_t raw_send_as(raw_dds *r, int64_t client, wire_message *m)
{
    m->client.client = client;
    m->client.sequence = ++r->sequence;
    void *sample = calloc(1, wire_dds_sample_size(m->kind));
    wire_dds_encode(m, sample);
    dds_return_t wrote = dds_write(r->writers[m->kind], sample);
    free(sample);
    if (wrote != DDS_RETCODE_OK) fail_msg("%s: %s", wire_kind_name(m->kind), dds_strretcode(wrote));
    return r->sequence;
}

static bool take_reject(raw_dds *r, wire_reject *out)
{
    void *samples[1] = {NULL};
    dds_sample_info_t infos[1];
    wire_message m;
    wire_refusal why;
    if (dds_take(r->reader, samples, infos, 1, 1) != 1) return false;
    bool valid = infos[0].valid_data && wire_dds_decode(WIRE_REJECT, samples[0], &m, &why) == WIRE_OK;
    if (valid) *out = m.reject;
    dds_return_loan(r->reader, samples, 1);
    return valid;
}

wire_reason raw_rejected(raw_dds *r, int64_t sequence)
{
    wire_reject reject; /* its text is no longer there */
    for (double end = rig_now_s() + RIG_PATIENCE_S; rig_now_s() < end; usleep(1000))
        while (take_reject(r, &reject))
            if (reject.client == RAW_CLIENT && reject.sequence == sequence) return (wire_reason)reject.reason;
    fail_msg("no Reject of message %lld", (long long)sequence);
    return WIRE_OK;
}
