/* standby_announcements: what the daemons of a pair say of themselves, an announcement each, with role and epoch: what
 * is to be found among them, and in which order they stand: who stays of two that are active, who goes first of two
 * that wait. Tick thread. */
#include "standby_parts.h"

#include "base/clock.h"

#include <string.h>

static const int64_t EPOCH_MOST = INT64_MAX / 2; /* no clock shows more */

void announcement_say(service *s, peer_role role)
{
    struct standby *p = s->standby;
    p->said_ns = s->monotonic_ns;
    p->announcement.role = (uint8_t)role;
    p->announcement.epoch = role == PEER_JOINING ? 0 : s->epoch;
    p->link->ops->peers->say(p->link, &p->announcement);
}

peer_announcement *announcement_of(struct standby *p, int64_t sender)
{
    for (size_t i = 0; i < p->peers.count; i++)
        if (p->peers.at[i].sender == sender) return &p->peers.at[i];
    return NULL;
}

/* Two that began within one quantum of the clock have the same epoch. */
bool announcement_stays(int64_t epoch, int64_t sender, int64_t other_epoch, int64_t other_sender)
{
    return epoch != other_epoch ? epoch > other_epoch : sender < other_sender;
}

const peer_announcement *announcement_of_active(const struct standby *p)
{
    const peer_announcement *first = NULL;
    for (size_t i = 0; i < p->peers.count; i++) {
        const peer_announcement *c = &p->peers.at[i];
        if (!c->alive || c->role != PEER_ACTIVE || strcmp(c->release, p->announcement.release) != 0) continue;
        if (!first || announcement_stays(c->epoch, c->sender, first->epoch, first->sender)) first = c;
    }
    return first;
}

bool announcement_is_there(const struct standby *p, peer_role role)
{
    for (size_t i = 0; i < p->peers.count; i++)
        if (p->peers.at[i].alive && p->peers.at[i].role == role) return true;
    return false;
}

bool announcement_is_before_us(const struct standby *p, peer_role role)
{
    for (size_t i = 0; i < p->peers.count; i++) {
        const peer_announcement *c = &p->peers.at[i];
        if (c->alive && c->role == role && c->sender < p->announcement.sender) return true;
    }
    return false;
}

void announcements_forget_dead(struct standby *p)
{
    for (size_t i = p->peers.count; i-- > 0;)
        if (!p->peers.at[i].alive && p->peers.at[i].sender != p->active) p->peers.at[i] = p->peers.at[--p->peers.count];
}

/* Above all that we have had or heard of, although the clock may have been set back: clients that knew one of those
 * would not believe a lower one until they had heard nothing for a while. */
int64_t announcement_new_line(const service *s)
{
    int64_t by_clock = wire_new_line(clock_wall_ns());
    int64_t known = s->epoch > s->standby->seen_epoch ? s->epoch : s->standby->seen_epoch;
    int64_t above = wire_new_line(known < EPOCH_MOST ? known : 0) + (INT64_C(1) << WIRE_LINE_BITS);
    return by_clock > above ? by_clock : above;
}
