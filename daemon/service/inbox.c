/* inbox: the commands of one tick. A network has no call order, so one is made: by (client, sequence). Poses of known
 * bodies do not wait here: the newest sequence wins, whatever order they come in. Tick thread. */
#include "service.h"

#include <stdlib.h>

void inbox_put(service *s, struct link *from, const wire_message *m)
{
    int32_t object;
    letter l = {.link = from, .kind = m->kind, .offset = s->inbox.bytes.count, .size = wire_lcm_size(m)};
    wire_origin(m, &l.client, &l.sequence, &object);
    array_reserve(&s->inbox.bytes, l.offset + l.size);
    s->inbox.bytes.count += wire_lcm_encode(m, s->inbox.bytes.at + l.offset, l.size);
    array_push(&s->inbox.letters, l);
}

static int compare(const void *a, const void *b)
{
    const letter *x = a, *y = b;
    if (x->client != y->client) return x->client < y->client ? -1 : 1;
    if (x->sequence != y->sequence) return x->sequence < y->sequence ? -1 : 1;
    return (x->offset > y->offset) - (x->offset < y->offset);
}

static bool open_letter(service *s, const letter *l, wire_message *m)
{
    wire_refusal why;
    wire_memory_reset(s->inbox.memory);
    if (wire_lcm_decode(s->inbox.bytes.at + l->offset, l->size, s->inbox.memory, m, &why) == WIRE_OK) return true;
    apply_reject(s, l->link, l->kind, l->client, l->sequence, -1, &why);
    return false;
}

/* Commands first; poses that came before their bodies after them. Queries stay until the tick is over. */
void inbox_apply(service *s)
{
    inbox *in = &s->inbox;
    wire_message m;
    if (in->letters.count) qsort(in->letters.at, in->letters.count, sizeof *in->letters.at, compare);
    for (size_t i = 0; i < in->letters.count; i++) {
        const letter *l = &in->letters.at[i];
        if (l->kind != WIRE_POSE_BATCH && l->kind != WIRE_QUERY && open_letter(s, l, &m)) apply_command(s, l->link, &m);
    }
    for (size_t i = 0; i < in->letters.count; i++) {
        const letter *l = &in->letters.at[i];
        if (l->kind == WIRE_POSE_BATCH && open_letter(s, l, &m)) apply_poses(s, l->link, &m.pose_batch, false);
    }
}

void inbox_answer(service *s)
{
    inbox *in = &s->inbox;
    wire_message m;
    for (size_t i = 0; i < in->letters.count; i++)
        if (in->letters.at[i].kind == WIRE_QUERY && open_letter(s, &in->letters.at[i], &m))
            answer_query(s, in->letters.at[i].link, &m.query);
    in->letters.count = in->bytes.count = 0;
}
