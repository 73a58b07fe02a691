/* A daemon's own samples are left out by the readers (ignorelocal), so that nobody is his own peer. */
#include "link_dds_peers.h"

#include "base/log.h"

/* idlc's names */
#include <collided_peer.h>

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum {
    TAKE_MAX = 64,           /* one constant: a loan writes as many pointers as the largest ever asked for */
    PIECE_BYTES = 512 << 10, /* of a record */
    REMEMBERED = 64,         /* daemons that are gone, beside those that live */
    PIECES_KEPT = 1024       /* for a peer that is behind; what is older is lost to it */
};

void dds_peers_init(dds_peers *p, void (*wake)(void *context), void *context)
{
    *p = (dds_peers){.wake = wake, .context = context};
    pthread_mutex_init(&p->lock, NULL);
}

void dds_peers_free(dds_peers *p)
{
    for (size_t i = 0; i < p->peers.count; i++) array_free(&p->peers.at[i].assembled);
    array_free(&p->peers);
    array_free(&p->news);
    array_free(&p->writers);
    pthread_mutex_destroy(&p->lock);
}

/* ---- Cyclone's threads ---- */

static void on_peer_data(dds_entity_t reader, void *context)
{
    (void)reader;
    dds_peers *p = context;
    p->wake(p->context);
}

static void on_peer_liveliness(dds_entity_t reader, const dds_liveliness_changed_status_t status, void *context)
{
    (void)reader;
    dds_peers *p = context;
    dds_peer_news news = {status.last_publication_handle, status.alive_count_change > 0};
    pthread_mutex_lock(&p->lock);
    array_push(&p->news, news);
    pthread_mutex_unlock(&p->lock);
    p->wake(p->context);
}

/* ---- joining ---- */

static dds_entity_t open_end(
    dds_peers *p, dds_entity_t topic, bool announcements, bool writes, int64_t lease_ns, dds_listener_t *listener)
{
    dds_qos_t *q = dds_create_qos();
    dds_qset_reliability(q, DDS_RELIABILITY_RELIABLE, DDS_MSECS(100));
    dds_qset_durability(q, announcements ? DDS_DURABILITY_TRANSIENT_LOCAL : DDS_DURABILITY_VOLATILE);
    dds_qset_history(q, DDS_HISTORY_KEEP_LAST, announcements ? 1 : PIECES_KEPT);
    if (writes) dds_qset_writer_data_lifecycle(q, false);
    if (writes && announcements) dds_qset_liveliness(q, DDS_LIVELINESS_AUTOMATIC, lease_ns);
    if (!writes) dds_qset_ignorelocal(q, DDS_IGNORELOCAL_PARTICIPANT);
    dds_entity_t end = writes ? dds_create_writer(p->participant, topic, q, NULL)
                              : dds_create_reader(p->participant, topic, q, listener);
    dds_delete_qos(q);
    return end;
}

/* The writers come first: who reads an announcement can be written to. */
bool dds_peers_join(dds_peers *p, dds_entity_t participant, int64_t lease_ns)
{
    p->participant = participant;
    dds_entity_t announcements = dds_create_topic(participant, &collided_Peer_desc, "collided_Peer", NULL, NULL);
    dds_entity_t journal = dds_create_topic(participant, &collided_Journal_desc, "collided_Journal", NULL, NULL);
    dds_listener_t *listener = dds_create_listener(NULL);
    dds_lset_data_available_arg(listener, on_peer_data, p, true);
    p->journal_out = open_end(p, journal, false, true, 0, NULL);
    p->journal_in = open_end(p, journal, false, false, 0, listener);
    p->announcements_out = open_end(p, announcements, true, true, lease_ns, NULL);
    dds_lset_liveliness_changed_arg(listener, on_peer_liveliness, p, true);
    p->announcements_in = open_end(p, announcements, true, false, 0, listener);
    dds_delete_listener(listener);
    return p->journal_out > 0 && p->journal_in > 0 && p->announcements_out > 0 && p->announcements_in > 0;
}

/* ---- sending ---- */

void dds_peers_say(dds_peers *p, const peer_announcement *announcement)
{
    const collided_Peer sample = {.sender = announcement->sender,
        .epoch = announcement->epoch,
        .role = announcement->role,
        .name = (char *)(uintptr_t)announcement->name,
        .release = (char *)(uintptr_t)announcement->release};
    dds_return_t written = dds_write(p->announcements_out, &sample);
    if (written != DDS_RETCODE_OK) log_warning("DDS: Peer: %s", dds_strretcode(written));
    dds_write_flush(p->announcements_out);
}

bool dds_peers_send(dds_peers *p, int64_t sender, uint8_t kind, const uint8_t *bytes, size_t size)
{
    size_t pieces = size ? (size + PIECE_BYTES - 1) / PIECE_BYTES : 1;
    for (size_t i = 0; i < pieces; i++) {
        size_t from = i * PIECE_BYTES, length = size - from < PIECE_BYTES ? size - from : PIECE_BYTES;
        const collided_Journal sample = {.sender = sender,
            .number = ++p->number,
            .kind = kind,
            .left = (int32_t)(pieces - 1 - i),
            .bytes = {._maximum = (uint32_t)length,
                ._length = (uint32_t)length,
                ._buffer = (uint8_t *)(uintptr_t)(bytes + from)}};
        if (dds_write(p->journal_out, &sample) != DDS_RETCODE_OK) return false;
    }
    dds_write_flush(p->journal_out);
    return true;
}

/* ---- receiving ---- */

static dds_peer *peer_of_sender(dds_peers *p, int64_t sender)
{
    for (size_t i = 0; i < p->peers.count; i++)
        if (p->peers.at[i].announcement.sender == sender) return &p->peers.at[i];
    array_push(&p->peers, ((dds_peer){.announcement = {.sender = sender}}));
    return &p->peers.at[p->peers.count - 1];
}

/* An announcement may be read before or after news of its writer that came earlier or later: the news alone count. */
static bool is_alive(const dds_peers *p, dds_instance_handle_t writer)
{
    for (size_t i = 0; i < p->writers.count; i++)
        if (p->writers.at[i].writer == writer) return p->writers.at[i].alive;
    return true;
}

static void take_announcement(
    dds_peers *p, const collided_Peer *sample, dds_instance_handle_t writer, const peer_sink *sink)
{
    dds_peer *at = peer_of_sender(p, sample->sender);
    at->writer = writer;
    at->announcement = (peer_announcement){
        .sender = sample->sender, .epoch = sample->epoch, .role = sample->role, .alive = is_alive(p, writer)};
    snprintf(at->announcement.name, sizeof at->announcement.name, "%s", sample->name ? sample->name : "");
    snprintf(at->announcement.release, sizeof at->announcement.release, "%s", sample->release ? sample->release : "");
    peer_announcement announcement = at->announcement;
    sink->announcement(sink->context, &announcement);
}

static void take_announcements(dds_peers *p, const peer_sink *sink)
{
    void *samples[TAKE_MAX] = {NULL};
    dds_sample_info_t infos[TAKE_MAX];
    int n;
    do {
        n = dds_take(p->announcements_in, samples, infos, TAKE_MAX, TAKE_MAX);
        for (int i = 0; i < n; i++)
            if (infos[i].valid_data) take_announcement(p, samples[i], infos[i].publication_handle, sink);
        if (n > 0) dds_return_loan(p->announcements_in, samples, n);
    } while (n == TAKE_MAX);
}

static void take_piece(dds_peers *p, const collided_Journal *piece, const peer_sink *sink)
{
    dds_peer *at = peer_of_sender(p, piece->sender);
    bool gap = at->next_number && piece->number != at->next_number;
    at->next_number = piece->number + 1;
    if (gap) {
        at->assembled.count = 0;
        at->broken = true;
        sink->gap(sink->context, piece->sender);
        at = peer_of_sender(p, piece->sender);
    }
    size_t size = piece->bytes._length;
    array_reserve(&at->assembled, at->assembled.count + size + 1);
    if (size) memcpy(at->assembled.at + at->assembled.count, piece->bytes._buffer, size);
    at->assembled.count += size;
    if (piece->left > 0) return;
    bool whole = !at->broken;
    at->broken = false;
    size = at->assembled.count;
    at->assembled.count = 0;
    if (whole) sink->record(sink->context, piece->sender, piece->kind, at->assembled.at, size);
}

static void take_pieces(dds_peers *p, const peer_sink *sink)
{
    void *samples[TAKE_MAX] = {NULL};
    dds_sample_info_t infos[TAKE_MAX];
    int n;
    do {
        n = dds_take(p->journal_in, samples, infos, TAKE_MAX, TAKE_MAX);
        for (int i = 0; i < n; i++)
            if (infos[i].valid_data) take_piece(p, samples[i], sink);
        if (n > 0) dds_return_loan(p->journal_in, samples, n);
    } while (n == TAKE_MAX);
}

/* Daemons that came and went long ago. */
static void forget_dead(dds_peers *p)
{
    for (size_t i = p->peers.count; i-- > 0 && p->peers.count > REMEMBERED;) {
        if (p->peers.at[i].announcement.alive) continue;
        array_free(&p->peers.at[i].assembled);
        p->peers.at[i] = p->peers.at[--p->peers.count];
    }
    for (size_t i = p->writers.count; i-- > 0 && p->writers.count > REMEMBERED;)
        if (!p->writers.at[i].alive) p->writers.at[i] = p->writers.at[--p->writers.count];
}

static void take_peer_news(dds_peers *p, const dds_peer_news *news, const peer_sink *sink)
{
    size_t place = 0;
    while (place < p->writers.count && p->writers.at[place].writer != news->writer) place++;
    if (place == p->writers.count) array_push(&p->writers, *news);
    p->writers.at[place].alive = news->alive;
    for (size_t i = 0; i < p->peers.count; i++) {
        dds_peer *at = &p->peers.at[i];
        if (at->writer != news->writer || at->announcement.alive == news->alive) continue;
        at->announcement.alive = news->alive;
        peer_announcement announcement = at->announcement;
        sink->announcement(sink->context, &announcement);
    }
}

/* What a peer has written comes before the news of its end. */
void dds_peers_receive(dds_peers *p, const peer_sink *sink)
{
    ARRAY(dds_peer_news) news = {0};
    pthread_mutex_lock(&p->lock);
    for (size_t i = 0; i < p->news.count; i++) array_push(&news, p->news.at[i]);
    p->news.count = 0;
    pthread_mutex_unlock(&p->lock);
    take_announcements(p, sink);
    take_pieces(p, sink);
    for (size_t i = 0; i < news.count; i++) take_peer_news(p, &news.at[i], sink);
    forget_dead(p);
    array_free(&news);
}
