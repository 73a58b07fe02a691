/* ear_dds: a participant of its own with readers of Status and Answer and a writer of Query, and DDS's built-in topics,
 * which tell of participants and endpoints also when these do not match. */
#include "ear.h"
#include "wire_dds/wire_dds.h"
#include "wire_dds/wire_dds_leave.h"
#include "wire_dds/wire_dds_qos.h"

#include <dds/dds.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { TAKE = 32, SEEN_MAX = 512, WRITERS_MAX = 32 };
#define MATCH_S 0.2 /* discovery tells of a writer, then matches it */

typedef struct seen_participant {
    dds_guid_t key;
    bool speaks; /* an endpoint of it is known */
} seen_participant;

typedef struct status_writer {
    dds_guid_t key;
    char type[64];
    double found_s;
    bool judged;
} status_writer;

typedef struct ear_dds {
    ear head;
    dds_entity_t domain, participant, status, answer, reject, query, participants, publications, subscriptions;
    dds_guid_t self;
    seen_participant seen[SEEN_MAX];
    size_t seen_count;
    status_writer writers[WRITERS_MAX];
    size_t writer_count;
    void *sample; /* of Query */
} ear_dds;

/* ---- what there is in the domain ---- */

static void note_participant(ear_dds *e, const dds_guid_t *key, bool speaks)
{
    if (memcmp(key, &e->self, sizeof *key) == 0) return;
    for (size_t i = 0; i < e->seen_count; i++) {
        if (memcmp(&e->seen[i].key, key, sizeof *key) != 0) continue;
        e->seen[i].speaks |= speaks;
        return;
    }
    if (e->seen_count < SEEN_MAX) e->seen[e->seen_count++] = (seen_participant){*key, speaks};
}

static void forget_participant(ear_dds *e, const dds_guid_t *key)
{
    for (size_t i = 0; i < e->seen_count; i++)
        if (memcmp(&e->seen[i].key, key, sizeof *key) == 0) e->seen[i--] = e->seen[--e->seen_count];
}

static void take_participants(ear_dds *e)
{
    void *samples[TAKE] = {NULL};
    dds_sample_info_t infos[TAKE];
    int n = dds_take(e->participants, samples, infos, TAKE, TAKE);
    for (int i = 0; i < n; i++) {
        const dds_builtintopic_participant_t *p = samples[i];
        if (infos[i].instance_state == DDS_IST_ALIVE)
            note_participant(e, &p->key, false);
        else
            forget_participant(e, &p->key);
    }
    if (n > 0) dds_return_loan(e->participants, samples, n);
}

static void note_status_writer(ear_dds *e, const dds_builtintopic_endpoint_t *p)
{
    char topic[WIRE_DDS_TOPIC_MAX];
    wire_dds_topic(WIRE_STATUS, topic);
    if (strcmp(p->topic_name, topic) != 0 || e->writer_count == WRITERS_MAX) return;
    status_writer *w = &e->writers[e->writer_count++];
    *w = (status_writer){.key = p->key, .found_s = ear_now_s()};
    snprintf(w->type, sizeof w->type, "%s", p->type_name);
}

static bool is_matched(const ear_dds *e, const dds_guid_t *writer)
{
    dds_instance_handle_t matched[SEEN_MAX];
    int n = dds_get_matched_publications(e->status, matched, SEEN_MAX);
    bool found = false;
    for (int i = 0; i < n && i < SEEN_MAX && !found; i++) {
        dds_builtintopic_endpoint_t *m = dds_get_matched_publication_data(e->status, matched[i]);
        found = m && memcmp(&m->key, writer, sizeof *writer) == 0;
        if (m) dds_builtintopic_free_endpoint(m);
    }
    return found;
}

/* A writer of Status that is known and does not match ours, not even a moment later, has another type or another
 * quality of service. */
static void judge_status_writers(ear_dds *e)
{
    const dds_topic_descriptor_t *ours = wire_dds_descriptor(WIRE_STATUS);
    for (size_t i = 0; i < e->writer_count; i++) {
        status_writer *w = &e->writers[i];
        if (w->judged || ear_now_s() - w->found_s < MATCH_S) continue;
        w->judged = true;
        if (is_matched(e, &w->key)) continue;
        bool same_name = strcmp(w->type, ours->m_typename) == 0;
        ear_strange(&e->head, "a daemon writes Status as type %s%s, not as our %s", w->type,
            same_name ? " by another definition" : "", ours->m_typename);
    }
}

static void take_endpoints(ear_dds *e, dds_entity_t reader)
{
    void *samples[TAKE] = {NULL};
    dds_sample_info_t infos[TAKE];
    int n = dds_take(reader, samples, infos, TAKE, TAKE);
    for (int i = 0; i < n; i++) {
        const dds_builtintopic_endpoint_t *p = samples[i];
        if (!infos[i].valid_data || infos[i].instance_state != DDS_IST_ALIVE) continue;
        note_participant(e, &p->participant_key, true);
        if (reader == e->publications) note_status_writer(e, p);
    }
    if (n > 0) dds_return_loan(reader, samples, n);
}

static void count_participants(ear_dds *e)
{
    e->head.participants = e->seen_count;
    e->head.mute_participants = 0;
    for (size_t i = 0; i < e->seen_count; i++) e->head.mute_participants += !e->seen[i].speaks;
}

/* ---- messages ---- */

static void take_messages(ear_dds *e, dds_entity_t reader, wire_kind kind)
{
    void *samples[TAKE] = {NULL};
    dds_sample_info_t infos[TAKE];
    int n = dds_take(reader, samples, infos, TAKE, TAKE);
    for (int i = 0; i < n; i++) {
        wire_message m;
        wire_refusal why;
        if (!infos[i].valid_data) continue;
        wire_reason reason = wire_dds_decode(kind, samples[i], &m, &why);
        if (reason == WIRE_OK)
            ear_message(&e->head, &m);
        else if (kind == WIRE_STATUS && reason == WIRE_WRONG_VERSION)
            ear_strange(&e->head, "a daemon speaks version %d of the wire, not our %d", m.version, WIRE_VERSION);
        else if (kind == WIRE_STATUS)
            ear_strange(&e->head, "a Status is not well-formed: %.120s", why.text);
    }
    if (n > 0) dds_return_loan(reader, samples, n);
}

static void dds_ear_poll(ear *head)
{
    ear_dds *e = (ear_dds *)head;
    take_participants(e);
    take_endpoints(e, e->publications);
    take_endpoints(e, e->subscriptions);
    judge_status_writers(e);
    count_participants(e);
    take_messages(e, e->status, WIRE_STATUS);
    take_messages(e, e->answer, WIRE_ANSWER);
    take_messages(e, e->reject, WIRE_REJECT);
}

static bool dds_ear_ready(ear *head)
{
    ear_dds *e = (ear_dds *)head;
    dds_publication_matched_status_t asks;
    dds_subscription_matched_status_t hears;
    return dds_get_publication_matched_status(e->query, &asks) == DDS_RETCODE_OK && asks.current_count > 0 &&
           dds_get_subscription_matched_status(e->answer, &hears) == DDS_RETCODE_OK && hears.current_count > 0;
}

static bool dds_ear_send(ear *head, const wire_message *query)
{
    ear_dds *e = (ear_dds *)head;
    wire_dds_encode(query, e->sample);
    return dds_write(e->query, e->sample) == DDS_RETCODE_OK;
}

/* ---- opening ---- */

static dds_entity_t endpoint(ear_dds *e, wire_kind kind, wire_dds_side side)
{
    char name[WIRE_DDS_TOPIC_MAX];
    wire_dds_topic(kind, name);
    dds_entity_t topic = dds_create_topic(e->participant, wire_dds_descriptor(kind), name, NULL, NULL);
    if (topic < 0) return topic;
    dds_qos_t *qos = wire_dds_qos(kind, side, NULL, 0);
    static const char *all_groups[] = {"", "*"}; /* refusals are overheard: see WIRE_DDS_REPLIES */
    if (kind == WIRE_REJECT) dds_qset_partition(qos, 2, all_groups);
    dds_entity_t made = side == WIRE_DDS_WRITER ? dds_create_writer(e->participant, topic, qos, NULL)
                                                : dds_create_reader(e->participant, topic, qos, NULL);
    dds_delete_qos(qos);
    return made;
}

static void on_log(void *context, const dds_log_data_t *line)
{
    (void)context;
    (void)line; /* what matters is in the findings */
}

static bool join(ear_dds *e, const ear_options *o, char *why, size_t why_size)
{
    char config[8192];
    if (!wire_dds_config(config, sizeof config, o->interface, WIRE_DDS_ANYBODY)) {
        snprintf(why, why_size, "'%s' is no interface, or CYCLONEDDS_URI is too long", o->interface);
        return false;
    }
    dds_set_log_sink(on_log, NULL);
    dds_set_trace_sink(on_log, NULL);
    e->domain = dds_create_domain(o->domain, config);
    if (e->domain > 0) e->participant = dds_create_participant(o->domain, NULL, NULL);
    if (e->domain > 0 && e->participant > 0) return dds_get_guid(e->participant, &e->self) == DDS_RETCODE_OK;
    snprintf(why, why_size, "DDS does not start in domain %u on %s", o->domain, *o->interface ? o->interface : "lo");
    return false;
}

/* Finding the firewall behind which DDS does not end is why we are here: then it is left behind. */
static bool dds_ear_close(ear *head)
{
    ear_dds *e = (ear_dds *)head;
    if (e->participant > 0) dds_delete(e->participant);
    bool left = wire_dds_leave(e->domain);
    free(e->sample);
    free(e);
    return left;
}

static const ear_ops dds_ear_ops = {
    .poll = dds_ear_poll, .send = dds_ear_send, .ready = dds_ear_ready, .close = dds_ear_close};

ear *ear_open_dds(const ear_options *options, char *why, size_t why_size)
{
    ear_dds *e = calloc(1, sizeof *e);
    if (!e || !(e->sample = calloc(1, wire_dds_sample_size(WIRE_QUERY)))) {
        snprintf(why, why_size, "out of memory");
        free(e);
        return NULL;
    }
    e->head.ops = &dds_ear_ops;
    if (join(e, options, why, why_size)) {
        e->participants = dds_create_reader(e->participant, DDS_BUILTIN_TOPIC_DCPSPARTICIPANT, NULL, NULL);
        e->status = endpoint(e, WIRE_STATUS, WIRE_DDS_READER);
        e->publications = dds_create_reader(e->participant, DDS_BUILTIN_TOPIC_DCPSPUBLICATION, NULL, NULL);
        e->subscriptions = dds_create_reader(e->participant, DDS_BUILTIN_TOPIC_DCPSSUBSCRIPTION, NULL, NULL);
        e->answer = endpoint(e, WIRE_ANSWER, WIRE_DDS_READER);
        e->reject = endpoint(e, WIRE_REJECT, WIRE_DDS_READER);
        e->query = endpoint(e, WIRE_QUERY, WIRE_DDS_WRITER);
        if (e->participants > 0 && e->status > 0 && e->publications > 0 && e->subscriptions > 0 && e->answer > 0 &&
            e->reject > 0 && e->query > 0)
            return &e->head;
        snprintf(why, why_size, "DDS makes no readers and writers in domain %u", options->domain);
    }
    dds_ear_close(&e->head);
    return NULL;
}
