/* A link's mouth: open; muted, as long as this daemon is the standby; held, as long as it is active and has one: what
 * it publishes goes out when the standby has the tick that it follows from, so that nobody was ever told what the
 * standby would not know. Muted and held links have tables of their own. Batches are kept for one to two leases: the
 * active one may have journalled a tick and not lived to publish it. Tick thread. */
#include "standby_parts.h"

#include "base/log.h"

#include <stdlib.h>

/* Batches, and what tells a client that it was lost: it may have nothing to say by which it would hear of it again. */
static bool is_kept(const wire_message *m)
{
    return m->kind == WIRE_EVENT_BATCH ? !m->event_batch.heartbeat
                                       : m->kind == WIRE_REJECT && m->reject.reason == WIRE_UNKNOWN_CLIENT;
}

static void keep(struct link *l, const wire_message *m)
{
    struct standby *p = ((const muted_link *)(const void *)l->ops)->owner;
    kept_batches *to = &p->batches[p->current];
    if (!is_kept(m)) return;
    if (to->bytes.count > KEPT_BATCH_BYTES || p->round_ns - to->began_ns > p->lease_ns) {
        p->current = !p->current;
        to = &p->batches[p->current];
        to->list.count = to->bytes.count = 0;
        to->began_ns = p->round_ns;
    }
    kept_batch b = {l, to->bytes.count, wire_lcm_size(m)};
    array_reserve(&to->bytes, b.offset + b.size);
    to->bytes.count += wire_lcm_encode(m, to->bytes.at + b.offset, b.size);
    array_push(&to->list, b);
}

static void no_flush(struct link *l)
{
    (void)l;
}

/* ---- held: until the standby has the tick ---- */

static void hold(struct link *l, const wire_message *m)
{
    const muted_link *at = (const muted_link *)(const void *)l->ops;
    struct standby *p = at->owner;
    held_messages *h = &p->held;
    if (h->first == h->list.count && p->had_tick >= p->journalled_tick) {
        at->own->publish(l, m);
        return;
    }
    held_message e = {l, h->bytes.count, wire_lcm_size(m), p->journalled_tick};
    array_reserve(&h->bytes, e.offset + e.size);
    h->bytes.count += wire_lcm_encode(m, h->bytes.at + e.offset, e.size);
    array_push(&h->list, e);
}

static void flush_what_goes(struct link *l)
{
    const muted_link *at = (const muted_link *)(const void *)l->ops;
    if (at->owner->held.first == at->owner->held.list.count) at->own->flush(l);
}

static void drop_held(held_messages *h)
{
    h->first = h->list.count = h->bytes.count = 0;
}

static void send_held(service *s, int64_t up_to)
{
    struct standby *p = s->standby;
    held_messages *h = &p->held;
    for (; h->first < h->list.count && h->list.at[h->first].tick <= up_to; h->first++) {
        const held_message *e = &h->list.at[h->first];
        wire_message m;
        wire_refusal why;
        wire_memory_reset(p->memory);
        if (wire_lcm_decode(h->bytes.at + e->offset, e->size, p->memory, &m, &why) != WIRE_OK)
            log_error("a held message cannot be read: %s", why.text);
        else
            p->muted[standby_place_of(s, e->link)].own->publish(e->link, &m);
    }
    if (h->first < h->list.count) return;
    drop_held(h);
    for (size_t i = 0; i < s->link_count; i++) p->muted[i].own->flush(s->links[i]);
}

void hold_release(service *s)
{
    struct standby *p = s->standby;
    if (p->mouth == MOUTH_HELD && p->held.list.count) send_held(s, p->had_tick);
}

/* ---- opening and shutting ---- */

static void set_mouth(service *s, mouth to)
{
    struct standby *p = s->standby;
    for (size_t i = 0; i < s->link_count; i++) {
        muted_link *m = &p->muted[i];
        if (p->mouth == MOUTH_OPEN) *m = (muted_link){.owner = p, .own = s->links[i]->ops, .ops = *s->links[i]->ops};
        m->ops.publish = to == MOUTH_MUTED ? keep : hold;
        m->ops.flush = to == MOUTH_MUTED ? no_flush : flush_what_goes;
        s->links[i]->ops = to == MOUTH_OPEN ? m->own : &m->ops;
    }
    p->mouth = to;
}

void mute_links(service *s)
{
    drop_held(&s->standby->held);
    set_mouth(s, MOUTH_MUTED);
}

void hold_links(service *s)
{
    struct standby *p = s->standby;
    if (p->mouth == MOUTH_HELD) return;
    set_mouth(s, MOUTH_HELD);
}

void open_links_again(service *s)
{
    struct standby *p = s->standby;
    if (p->mouth == MOUTH_OPEN) return;
    if (p->held.list.count) send_held(s, INT64_MAX);
    set_mouth(s, MOUTH_OPEN);
}

/* ---- taking over ---- */

static void publish_again(service *s, const kept_batches *k)
{
    for (size_t i = 0; i < k->list.count; i++) {
        const kept_batch *b = &k->list.at[i];
        wire_message m;
        wire_refusal why;
        wire_memory_reset(s->standby->memory);
        if (wire_lcm_decode(k->bytes.at + b->offset, b->size, s->standby->memory, &m, &why) != WIRE_OK) {
            log_error("a kept batch cannot be read: %s", why.text);
            continue;
        }
        *(m.kind == WIRE_REJECT ? &m.reject.epoch : &m.event_batch.epoch) = s->epoch;
        b->link->ops->publish(b->link, &m);
    }
}

void mute_publish_again(service *s)
{
    struct standby *p = s->standby;
    publish_again(s, &p->batches[!p->current]);
    publish_again(s, &p->batches[p->current]);
    for (int i = 0; i < 2; i++) p->batches[i].list.count = p->batches[i].bytes.count = 0;
}

void mute_free(struct standby *p)
{
    for (int i = 0; i < 2; i++) {
        array_free(&p->batches[i].list);
        array_free(&p->batches[i].bytes);
    }
    array_free(&p->held.list);
    array_free(&p->held.bytes);
}
