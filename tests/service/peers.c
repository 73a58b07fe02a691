/* peers: a mailbox for each of the two. */
#include "peers.h"

#include "base/clock.h"
#include "service/clients.h"
#include "service/shares.h"
#include "service/standby.h"
#include "service/streams.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

enum { PAIR = 2, RECORDS_MAX = 256 };
typedef struct said {
    peer_announcement announcements[RECORDS_MAX];
    size_t announcement_count;
    struct {
        int64_t sender;
        uint8_t kind, *bytes;
        size_t size;
    } records[RECORDS_MAX];
    size_t record_count;
    bool gap; /* records were lost before these */
    bool deaf;
} said;
static struct {
    const struct link *members[PAIR];
    peer_announcement last[PAIR]; /* their own announcements */
    said to[PAIR];
    bool parted;
    size_t most;
} between;

static int member(const struct link *l)
{
    return l == between.members[1];
}

static void tell(int whom, peer_announcement announcement, bool alive)
{
    said *to = &between.to[whom];
    announcement.alive = alive;
    assert_true(to->announcement_count < RECORDS_MAX);
    to->announcements[to->announcement_count++] = announcement;
}

static int peer_join(struct link *l, int64_t lease_ns)
{
    (void)lease_ns;
    int mine = between.members[0] != NULL;
    between.members[mine] = l;
    if (between.members[!mine] && between.last[!mine].alive && !between.parted) tell(mine, between.last[!mine], true);
    return 0;
}

static void peer_say(struct link *l, const peer_announcement *announcement)
{
    int mine = member(l);
    between.last[mine] = *announcement;
    between.last[mine].alive = true;
    if (between.members[!mine] && !between.parted) tell(!mine, between.last[mine], true);
}

static bool peer_send(struct link *l, int64_t sender, uint8_t kind, const uint8_t *bytes, size_t size)
{
    said *to = &between.to[!member(l)];
    if (!between.members[!member(l)]) return true;
    bool lost = between.parted || to->deaf;
    to->gap |= lost;
    if (lost) return true;
    assert_true(to->record_count < RECORDS_MAX);
    uint8_t *copy = malloc(size + 1);
    if (size) memcpy(copy, bytes, size);
    to->records[to->record_count].sender = sender;
    to->records[to->record_count].kind = kind;
    to->records[to->record_count].bytes = copy;
    to->records[to->record_count++].size = size;
    return true;
}

static void count_bytes(const said *from)
{
    size_t bytes = 0;
    for (size_t i = 0; i < from->record_count; i++) bytes += from->records[i].size;
    if (bytes > between.most) between.most = bytes;
}

size_t peers_most(void)
{
    size_t most = between.most;
    between.most = 0;
    return most;
}

static void peer_receive(struct link *l, const peer_sink *sink)
{
    int mine = member(l);
    said from = between.to[mine];
    count_bytes(&from);
    between.to[mine] = (said){.gap = from.gap && !from.record_count, .deaf = from.deaf};
    for (size_t i = 0; i < from.announcement_count; i++) sink->announcement(sink->context, &from.announcements[i]);
    if (from.gap && from.record_count) sink->gap(sink->context, from.records[0].sender);
    for (size_t i = 0; i < from.record_count; i++) {
        sink->record(
            sink->context, from.records[i].sender, from.records[i].kind, from.records[i].bytes, from.records[i].size);
        free(from.records[i].bytes);
    }
}

static const peer_ops PEERS = {peer_join, peer_say, peer_send, peer_receive};

static void forget_what_came(int whom)
{
    for (size_t i = 0; i < between.to[whom].record_count; i++) free(between.to[whom].records[i].bytes);
    between.to[whom] = (said){.announcement_count = 0};
}

void peers_forget(void)
{
    for (int i = 0; i < PAIR; i++) forget_what_came(i);
    memset(&between, 0, sizeof between);
}

void peers_die(const struct link *l)
{
    int mine = member(l);
    between.last[mine].alive = false;
    tell(!mine, between.last[mine], false);
    forget_what_came(mine);
    between.members[mine] = NULL;
}

void peers_flicker(const struct link *l, bool alive)
{
    int mine = member(l);
    tell(!mine, between.last[mine], alive);
}

void peers_deafen(const struct link *l, bool deaf)
{
    between.to[member(l)].deaf = deaf;
}

void peers_part(bool parted)
{
    between.parted = parted;
    for (int i = 0; i < PAIR; i++)
        if (between.members[!i]) tell(i, between.last[!i], !parted);
}

void peers_pair_up(service *s, link_ops *ops)
{
    char why[256] = "";
    *ops = *s->links[0]->ops;
    ops->peers = &PEERS;
    s->links[0]->ops = ops;
    s->config.standby = true;
    if (standby_start(s, why, sizeof why) != 0) fail_msg("%s", why);
}

void peers_work(service *s)
{
    shares_release(s);
    session_check_leases(s);
    s->tick++;
    pace_begin(&s->pace, clock_monotonic_ns());
    service_tick(s);
    pace_end(&s->pace, clock_monotonic_ns(), world_get_figures(s->world).work);
    standby_after_tick(s);
    stream_heartbeats(s);
}

bool peers_have_standby(const service *s)
{
    char text[256];
    standby_describe(s, text, sizeof text);
    return strstr(text, "hot standby") != NULL;
}
