/* Discovery tells of a writer before its first message can be read, and of its end when the last may not yet be: ends
 * wait until the messages have been read. */
#include "link_dds_speakers.h"

#include "wire/dds/wire_dds_qos.h"

#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { TAKE_MAX = 64 /* one constant: a loan writes as many pointers as the largest ever asked for */ };

void speakers_init(speakers *s, size_t max_clients, size_t each)
{
    owners_init(&s->owners, max_clients ? max_clients : SIZE_MAX);
    s->owners.each = each;
    pthread_mutex_init(&s->lock, NULL);
}

bool speakers_open(speakers_ear *ear, dds_entity_t participant, unsigned room, const dds_listener_t *listener)
{
    ear->discovery = dds_create_reader(participant, DDS_BUILTIN_TOPIC_DCPSPUBLICATION, NULL, listener);
    ear->room = room;
    return ear->discovery > 0;
}

void speakers_free(speakers *s)
{
    owners_free(&s->owners);
    array_free(&s->gone);
    array_free(&s->news);
    pthread_mutex_destroy(&s->lock);
}

/* Both groups of a participant, and its room, in one number: replies + 256 events + 65,536 room. */
enum { EVENTS_FACTOR = 256, ROOM_FACTOR = 65536 };

/* The groups that its user data names. */
static int groups_of(const dds_builtintopic_endpoint_t *writer)
{
    void *data = NULL;
    size_t size = 0;
    int replies = 0, events = 0;
    if (writer->qos && dds_qget_userdata(writer->qos, &data, &size))
        wire_dds_user_data_read(data, size, &replies, &events);
    dds_free(data);
    return replies + EVENTS_FACTOR * events;
}

static void hear_of(
    speakers *s, unsigned room, const dds_builtintopic_endpoint_t *writer, const dds_sample_info_t *info)
{
    bool ours = info->valid_data && strncmp(writer->topic_name, "collided_", 9) == 0;
    bool announces = ours && strcmp(writer->topic_name, "collided_Client") == 0;
    if (ours) owners_come(&s->owners, info->instance_handle, writer->participant_instance_handle, announces);
    if (announces) owners_put_in_group(&s->owners, info->instance_handle, groups_of(writer) + ROOM_FACTOR * (int)room);
    if (info->instance_state != DDS_IST_ALIVE) array_push(&s->gone, info->instance_handle);
}

void speakers_discover(speakers *s, const speakers_ear *ear)
{
    void *samples[TAKE_MAX] = {NULL};
    dds_sample_info_t infos[TAKE_MAX];
    int n;
    do {
        n = dds_take(ear->discovery, samples, infos, TAKE_MAX, TAKE_MAX);
        for (int i = 0; i < n; i++) hear_of(s, ear->room, samples[i], &infos[i]);
        if (n > 0) dds_return_loan(ear->discovery, samples, n);
    } while (n == TAKE_MAX);
}

void speakers_heartbeat(speakers *s, const dds_liveliness_changed_status_t *news)
{
    heartbeat h = {news->last_publication_handle, news->alive_count_change > 0};
    pthread_mutex_lock(&s->lock);
    array_push(&s->news, h);
    pthread_mutex_unlock(&s->lock);
}

int64_t speakers_origin(const speakers *s, dds_instance_handle_t writer)
{
    return (int64_t)owners_participant_of(&s->owners, writer);
}

bool speakers_admit(speakers *s, const speakers_ear *ear, const wire_message *m, dds_instance_handle_t writer,
    bool *unclaimed, wire_refusal *why)
{
    int64_t client, sequence;
    int32_t object;
    wire_origin(m, &client, &sequence, &object);
    if (!owners_knows(&s->owners, writer)) speakers_discover(s, ear);
    owners_verdict verdict = owners_admit(&s->owners, writer, client, m->kind == WIRE_CLIENT);
    bool full = verdict == OWNERS_FULL || verdict == OWNERS_SHARE;
    *unclaimed = full && (m->kind == WIRE_QUERY || (m->kind == WIRE_CLIENT && !m->client.removed));
    if (*unclaimed) return true;
    why->reason = full ? WIRE_LIMIT : WIRE_NOT_YOURS;
    if (verdict == OWNERS_SHARE)
        snprintf(why->text, sizeof why->text,
            "max_clients: %zu of %zu are the share of one participant; the rest stays free for others", s->owners.each,
            s->owners.most);
    else if (full)
        snprintf(
            why->text, sizeof why->text, "max_clients = %zu is reached by those who speak over DDS", s->owners.most);
    else
        snprintf(why->text, sizeof why->text, "another participant speaks for client %016" PRIx64 ", and is alive",
            (uint64_t)client);
    return verdict == OWNERS_YES;
}

int speakers_group(const speakers *s, int64_t client)
{
    return owners_group(&s->owners, client) % EVENTS_FACTOR;
}

int speakers_events_group(const speakers *s, int64_t client)
{
    return owners_group(&s->owners, client) / EVENTS_FACTOR % EVENTS_FACTOR;
}

unsigned speakers_room(const speakers *s, int64_t client)
{
    return (unsigned)(owners_group(&s->owners, client) / ROOM_FACTOR);
}

uint64_t speakers_participant(const speakers *s, int64_t client)
{
    return owners_participant_for(&s->owners, client);
}

void speakers_release(speakers *s, int64_t client)
{
    owners_release(&s->owners, client);
}

static void take_news(speakers *s)
{
    pthread_mutex_lock(&s->lock);
    for (size_t i = 0; i < s->news.count; i++) owners_liveliness(&s->owners, s->news.at[i].writer, s->news.at[i].alive);
    s->news.count = 0;
    pthread_mutex_unlock(&s->lock);
    for (size_t i = 0; i < s->gone.count; i++) owners_go(&s->owners, s->gone.at[i]);
    s->gone.count = 0;
}

bool speakers_lost(speakers *s, int64_t *client)
{
    take_news(s);
    return owners_lost(&s->owners, client);
}
