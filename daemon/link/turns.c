#include "turns.h"

#include <stdlib.h>
#include <string.h>

static const int64_t A_TURN = 256 << 10; /* bytes: some 4,000 poses */

void turns_init(turns *t)
{
    *t = (turns){.count = 0};
    pair_map_init(&t->queue_of);
}

static void free_queue(turns_queue *q)
{
    array_free(&q->waits);
    array_free(&q->sizes);
}

void turns_free(turns *t)
{
    for (size_t i = 0; i < t->queues.count; i++) free_queue(&t->queues.at[i]);
    array_free(&t->queues);
    pair_map_free(&t->queue_of);
}

static turns_queue *queue_of(const turns *t, uint64_t source)
{
    uint32_t place = pair_map_get(&t->queue_of, source);
    return place == PAIR_MAP_NONE ? NULL : &t->queues.at[place];
}

static turns_queue *begin_queue(turns *t, uint64_t source)
{
    pair_map_put(&t->queue_of, source, (uint32_t)t->queues.count);
    array_push(&t->queues, ((turns_queue){.source = source, .credit = A_TURN}));
    return &t->queues.at[t->queues.count - 1];
}

void turns_put(turns *t, uint64_t source, void *message, size_t bytes)
{
    turns_queue *q = queue_of(t, source);
    if (!q) q = begin_queue(t, source);
    array_push(&q->waits, message);
    array_push(&q->sizes, bytes);
    q->bytes += bytes;
    t->bytes += bytes;
    t->count++;
}

size_t turns_bytes_of(const turns *t, uint64_t source)
{
    const turns_queue *q = queue_of(t, source);
    return q ? q->bytes : 0;
}

size_t turns_count_of(const turns *t, uint64_t source)
{
    const turns_queue *q = queue_of(t, source);
    return q ? q->waits.count - q->first : 0;
}

static void end_queue(turns *t, turns_queue *q)
{
    turns_queue *last = &t->queues.at[t->queues.count - 1];
    pair_map_remove(&t->queue_of, q->source);
    free_queue(q);
    if (q != last) {
        *q = *last;
        pair_map_put(&t->queue_of, q->source, (uint32_t)(q - t->queues.at));
    }
    t->queues.count--;
}

/* What was taken is given up in large pieces, so that a queue that is never empty does not grow without end. */
static void close_up(turns_queue *q)
{
    enum { MANY = 1024 };
    if (q->first < MANY || q->first < q->waits.count / 2) return;
    size_t left = q->waits.count - q->first;
    memmove(q->waits.at, q->waits.at + q->first, left * sizeof *q->waits.at);
    memmove(q->sizes.at, q->sizes.at + q->first, left * sizeof *q->sizes.at);
    q->waits.count = q->sizes.count = left;
    q->first = 0;
}

static void *take_first(turns *t, turns_queue *q)
{
    size_t bytes = q->sizes.at[q->first];
    void *message = q->waits.at[q->first++];
    q->credit -= (int64_t)bytes;
    q->bytes -= bytes;
    t->bytes -= bytes;
    t->count--;
    if (q->first == q->waits.count)
        end_queue(t, q);
    else
        close_up(q);
    return message;
}

/* Whose turn it is; NULL: nobody waits. */
static turns_queue *next_queue(turns *t)
{
    while (t->count) {
        if (t->turn >= t->queues.count) t->turn = 0;
        turns_queue *q = &t->queues.at[t->turn];
        if (q->credit > 0) return q;
        q->credit += A_TURN;
        t->turn++;
    }
    return NULL;
}

void *turns_next(turns *t)
{
    turns_queue *q = next_queue(t);
    return q ? take_first(t, q) : NULL;
}

void *turns_first(turns *t)
{
    const turns_queue *q = next_queue(t);
    return q ? q->waits.at[q->first] : NULL;
}

void turns_take(turns *t, size_t more)
{
    turns_queue *q = next_queue(t);
    if (!q) return;
    q->credit -= (int64_t)more;
    take_first(t, q);
}

void turns_part(turns *t, size_t bytes, size_t more)
{
    turns_queue *q = next_queue(t);
    if (!q) return;
    size_t *size = &q->sizes.at[q->first];
    if (bytes >= *size) bytes = *size ? *size - 1 : 0;
    *size -= bytes;
    q->bytes -= bytes;
    t->bytes -= bytes;
    q->credit -= (int64_t)(bytes + more);
}

void *turns_oldest_of(turns *t, uint64_t source)
{
    turns_queue *q = queue_of(t, source);
    return q ? take_first(t, q) : NULL;
}

void turns_each(const turns *t, void (*visit)(void *context, void *message), void *context)
{
    for (size_t i = 0; i < t->queues.count; i++)
        for (size_t k = t->queues.at[i].first; k < t->queues.at[i].waits.count; k++)
            visit(context, t->queues.at[i].waits.at[k]);
}

uint64_t turns_longest(const turns *t)
{
    const turns_queue *longest = NULL;
    for (size_t i = 0; i < t->queues.count; i++)
        if (!longest || t->queues.at[i].bytes > longest->bytes) longest = &t->queues.at[i];
    return longest ? longest->source : 0;
}
