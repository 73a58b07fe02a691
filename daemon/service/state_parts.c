/* state_parts: see state_parts.h. What is borrowed does not change: of a geometry that is not whole only those pieces
 * are read that had come, and no piece is written twice. */
#include "state_parts.h"

#include "base/hash.h"

#include <stdlib.h>
#include <string.h>

static size_t bytes_of_vertices(const geometry_numbers *n)
{
    return n->vertex_numbers * sizeof *n->vertices;
}

static size_t bytes_of_numbers(const geometry_numbers *n)
{
    return bytes_of_vertices(n) + n->index_numbers * sizeof *n->indices;
}

void state_parts_borrow(state_parts *to, geometry_numbers *n, const uint8_t *has, size_t pieces)
{
    borrowed_numbers b = {.at = to->own.count, .numbers = geometry_numbers_keep(n)};
    if (has) b.has = memcpy(base_alloc(pieces, 1), has, pieces);
    array_push(&to->borrowed, b);
}

void state_parts_end(state_parts *to)
{
    to->size = to->own.count;
    for (size_t i = 0; i < to->borrowed.count; i++) to->size += bytes_of_numbers(to->borrowed.at[i].numbers);
    state_parts_rewind(to);
}

void state_parts_rewind(state_parts *from)
{
    from->read = from->next = from->read_of_own = from->read_of_next = 0;
}

/* The bytes at `offset` of its numbers, which are of one piece: as many as there are in a row. */
static size_t copy_numbers(const borrowed_numbers *b, size_t offset, uint8_t *to, size_t size)
{
    const geometry_numbers *n = b->numbers;
    size_t in_vertices = bytes_of_vertices(n);
    bool vertices = offset < in_vertices;
    size_t each = vertices ? sizeof *n->vertices : sizeof *n->indices, at = vertices ? offset : offset - in_vertices;
    size_t number = at / each + (vertices ? 0 : n->vertex_numbers), piece = number / WIRE_PIECE_MAX;
    size_t first = vertices ? 0 : n->vertex_numbers, end = (piece + 1) * WIRE_PIECE_MAX - first;
    size_t most = vertices ? n->vertex_numbers : n->index_numbers;
    size_t here = (end < most ? end : most) * each - at;
    if (size > here) size = here;
    const uint8_t *from = vertices ? (const uint8_t *)n->vertices : (const uint8_t *)n->indices;
    if (!b->has || b->has[piece])
        memcpy(to, from + at, size);
    else
        memset(to, 0, size);
    return size;
}

size_t state_parts_read(state_parts *from, uint8_t *to, size_t size)
{
    size_t done = 0;
    while (done < size && from->read < from->size) {
        const borrowed_numbers *b = from->next < from->borrowed.count ? &from->borrowed.at[from->next] : NULL;
        size_t until = b ? b->at : from->own.count, left = size - done, n;
        if (from->read_of_own < until) {
            n = until - from->read_of_own < left ? until - from->read_of_own : left;
            memcpy(to + done, from->own.at + from->read_of_own, n);
            from->read_of_own += n;
        } else if (b && from->read_of_next < bytes_of_numbers(b->numbers)) {
            n = copy_numbers(b, from->read_of_next, to + done, left);
            from->read_of_next += n;
        } else {
            from->next++;
            from->read_of_next = n = 0;
        }
        from->read += n;
        done += n;
    }
    return done;
}

uint64_t state_parts_hash(state_parts *from)
{
    enum { AT_ONCE = 1 << 16 }; /* whole words: the hash of the parts is that of the whole */
    uint8_t *some = base_alloc(AT_ONCE, 1);
    uint64_t hash = HASH_START;
    state_parts_rewind(from);
    for (size_t n; (n = state_parts_read(from, some, AT_ONCE)) > 0;) hash = hash_words(hash, some, n);
    state_parts_rewind(from);
    free(some);
    return hash;
}

void state_parts_free(state_parts *p, builds *b)
{
    for (size_t i = 0; i < p->borrowed.count; i++) {
        if (b)
            builds_free(b, p->borrowed.at[i].numbers, NULL, NULL, NULL);
        else
            geometry_numbers_release(p->borrowed.at[i].numbers);
        free(p->borrowed.at[i].has);
    }
    array_free(&p->borrowed);
    array_free(&p->own);
    *p = (state_parts){.size = 0};
}
