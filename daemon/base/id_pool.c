/* id_pool: a bit a taken id. One thread at a time. No word before first_word has a free bit. */
#include "id_pool.h"

#include "array.h"

#include <assert.h>
#include <stdlib.h>
#include <string.h>

enum { WORD_BITS = 64 };

void id_pool_init(id_pool *p)
{
    *p = (id_pool){0};
}

void id_pool_free(id_pool *p)
{
    free(p->words);
    *p = (id_pool){0};
}

static void append_free_words(id_pool *p)
{
    size_t old = p->word_count;
    p->words = array_grow(p->words, &p->word_count, old + 1, sizeof *p->words);
    memset(p->words + old, 0, (p->word_count - old) * sizeof *p->words);
}

uint32_t id_pool_take(id_pool *p)
{
    size_t w = p->first_word;
    while (w < p->word_count && p->words[w] == UINT64_MAX) w++;
    if (w == p->word_count) append_free_words(p);
    p->first_word = w;

    unsigned bit = (unsigned)__builtin_ctzll(~p->words[w]);
    assert(w < UINT32_MAX / WORD_BITS);
    uint32_t id = (uint32_t)(w * WORD_BITS + bit);
    p->words[w] |= UINT64_C(1) << bit;
    p->taken++;
    if (id >= p->end) p->end = id + 1;
    return id;
}

void id_pool_give(id_pool *p, uint32_t id)
{
    assert(id_pool_has(p, id));
    size_t w = id / WORD_BITS;
    p->words[w] &= ~(UINT64_C(1) << id % WORD_BITS);
    p->taken--;
    if (w < p->first_word) p->first_word = w;
}

bool id_pool_has(const id_pool *p, uint32_t id)
{
    size_t w = id / WORD_BITS;
    return w < p->word_count && p->words[w] >> id % WORD_BITS & 1;
}

uint32_t id_pool_end(const id_pool *p)
{
    size_t w = (p->end + WORD_BITS - 1) / WORD_BITS;
    while (w && !p->words[w - 1]) w--;
    return w ? (uint32_t)(w * WORD_BITS) - (uint32_t)__builtin_clzll(p->words[w - 1]) : 0;
}
