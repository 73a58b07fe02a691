/* contacts: what was found, in canonical order. One thread. */
#include "contacts.h"

#include "base/array.h"

#include <stdlib.h>
#include <string.h>

enum { DIGIT_BITS = 11, DIGITS = 1 << DIGIT_BITS };

typedef enum field { FIELD_B, FIELD_A, FIELD_KIND, FIELD_PAIR, FIELDS } field; /* the last decides first */

static uint32_t field_of(const soft_contact *c, field f)
{
    return f == FIELD_B ? c->b : f == FIELD_A ? c->a : f == FIELD_KIND ? c->kind : c->pair;
}

static void sort_by_digit(const soft_contact *from, soft_contact *to, size_t count, field f, unsigned shift)
{
    size_t place[DIGITS] = {0}, sum = 0;
    for (size_t i = 0; i < count; i++) place[field_of(&from[i], f) >> shift & (DIGITS - 1)]++;
    for (size_t d = 0; d < DIGITS; d++) {
        size_t n = place[d];
        place[d] = sum;
        sum += n;
    }
    for (size_t i = 0; i < count; i++) to[place[field_of(&from[i], f) >> shift & (DIGITS - 1)]++] = from[i];
}

void soft_contacts_sort(soft_contacts *c, soft_contacts *scratch)
{
    array_reserve(scratch, c->count);
    soft_contact *from = c->at, *to = scratch->at;
    for (field f = 0; f < FIELDS; f++) {
        uint32_t differing = 0;
        for (size_t i = 1; i < c->count; i++) differing |= field_of(&from[i], f) ^ field_of(&from[0], f);
        for (unsigned shift = 0; shift < 32; shift += DIGIT_BITS) {
            if (!(differing >> shift & (DIGITS - 1))) continue;
            sort_by_digit(from, to, c->count, f, shift);
            soft_contact *swapped = from;
            from = to, to = swapped;
        }
    }
    if (from != c->at && c->count) memcpy(c->at, from, c->count * sizeof *from);
}

void soft_contacts_keep(soft_contacts *c, soft_contacts *scratch, size_t most)
{
    soft_contacts_sort(c, scratch);
    if (c->count > most) c->count = most;
}
