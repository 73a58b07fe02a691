/* A muted link has a table of its own, in which publish keeps batches and flush does nothing. Batches are kept for one
 * to two seconds: the active one may have journalled a tick and not lived to publish it. Tick thread. */
#include "standby_parts.h"

#include "base/log.h"

#include <stdlib.h>

static void keep(struct link *l, const wire_message *m)
{
    struct standby *p = ((const muted_link *)(const void *)l->ops)->owner;
    kept_batches *to = &p->batches[p->current];
    if (m->kind != WIRE_EVENT_BATCH || m->event_batch.heartbeat) return;
    if (to->bytes.count > KEPT_BATCH_BYTES || p->round_ns - to->began_ns > KEPT_BATCHES_NS) {
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

void mute_links(service *s)
{
    struct standby *p = s->standby;
    if (p->is_muted) return;
    p->is_muted = true;
    for (size_t i = 0; i < s->link_count; i++) {
        muted_link *m = &p->muted[i];
        m->owner = p;
        m->own = s->links[i]->ops;
        m->ops = *m->own;
        m->ops.publish = keep;
        m->ops.flush = no_flush;
        s->links[i]->ops = &m->ops;
    }
}

void unmute_links(service *s)
{
    struct standby *p = s->standby;
    if (!p->is_muted) return;
    p->is_muted = false;
    for (size_t i = 0; i < s->link_count; i++) s->links[i]->ops = p->muted[i].own;
}

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
        m.event_batch.epoch = s->epoch;
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
}
