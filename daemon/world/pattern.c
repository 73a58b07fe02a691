/* pattern: a pattern is cut at its stars; what stands before the first and behind the last has its place in the text,
 * and of what lies between each piece is looked for behind the one before it. The first place that fits is as good as
 * any: it leaves the most text for the rest. */
#include "pattern.h"

#include "base/hash.h"
#include "base/secret.h"

#include <stdlib.h>
#include <string.h>

/* ---- one pattern ---- */

static bool is_wildcard(char c)
{
    return c == '*' || c == '?';
}

static void measure(pattern *p)
{
    const char *end = p->text + p->length;
    p->head = p->tail = p->least = 0;
    p->has_star = p->has_wildcard = false;
    for (const char *c = p->text; c < end; c++) {
        p->least += *c != '*';
        p->has_star |= *c == '*';
        p->has_wildcard |= is_wildcard(*c);
    }
    while (p->head < p->length && !is_wildcard(p->text[p->head])) p->head++;
    while (p->tail < p->length && !is_wildcard(end[-1 - (ptrdiff_t)p->tail])) p->tail++;
}

void pattern_init(pattern *p, const char *text)
{
    static const char GROUP[] = "group:";
    *p = (pattern){.of_group = strncmp(text, GROUP, sizeof GROUP - 1) == 0};
    p->text = base_strdup(p->of_group ? text + sizeof GROUP - 1 : text);
    for (const char *c = p->text; *c; c++)
        if (!(c[0] == '*' && c[1] == '*')) p->text[p->length++] = *c;
    p->text[p->length] = '\0';
    measure(p);
}

void pattern_free(pattern *p)
{
    free(p->text);
    *p = (pattern){0};
}

bool pattern_same(const pattern *a, const pattern *b)
{
    return a->of_group == b->of_group && a->length == b->length && memcmp(a->text, b->text, a->length) == 0;
}

/* Is the piece, which has no stars, what stands there? */
static bool stands(const char *piece, size_t length, const char *text)
{
    for (size_t i = 0; i < length; i++)
        if (piece[i] != '?' && piece[i] != text[i]) return false;
    return true;
}

enum { SHORT_PIECE = 8, WIDEST_PIECE = 128 };

/* Shift-And (Baeza-Yates and Gonnet, A new approach to text searching, 1992): bit i of `state` is set while the last
 * i + 1 bytes of the text are the first ones of the piece. */
static const char *find_with_gaps(const char *piece, size_t length, const char *text, const char *end)
{
    uint64_t fits[256][2] = {{0}}, anything[2] = {0}, state[2] = {0};
    for (size_t i = 0; i < length; i++) {
        uint64_t bit = (uint64_t)1 << (i & 63);
        if (piece[i] == '?')
            anything[i >> 6] |= bit;
        else
            fits[(unsigned char)piece[i]][i >> 6] |= bit;
    }
    for (const char *at = text; at < end; at++) {
        const uint64_t *fit = fits[(unsigned char)*at];
        uint64_t carry = state[0] >> 63;
        state[0] = (state[0] << 1 | 1) & (fit[0] | anything[0]);
        state[1] = (state[1] << 1 | carry) & (fit[1] | anything[1]);
        if (state[(length - 1) >> 6] >> ((length - 1) & 63) & 1) return at + 1 - length;
    }
    return NULL;
}

/* The first place of the piece, or NULL. Of a short one every place is tried. No message has one that is too long. */
static const char *find_piece(const char *piece, size_t length, const char *text, const char *end)
{
    if ((size_t)(end - text) < length) return NULL;
    if (length > SHORT_PIECE && !memchr(piece, '?', length)) return memmem(text, (size_t)(end - text), piece, length);
    if (length > SHORT_PIECE && length <= WIDEST_PIECE) return find_with_gaps(piece, length, text, end);
    for (const char *at = text, *last = end - length; at <= last; at++)
        if ((*piece == *at || *piece == '?') && stands(piece + 1, length - 1, at + 1)) return at;
    return NULL;
}

static bool matches(const pattern *p, const char *text, size_t length)
{
    const char *at = p->text, *last = p->text + p->length;
    if (length < p->least || (!p->has_star && length != p->least)) return false;
    if (memcmp(at, text, p->head) != 0 || memcmp(last - p->tail, text + length - p->tail, p->tail) != 0) return false;
    if (!p->has_star) return stands(at, p->length, text);
    const char *star = memchr(at, '*', p->length), *final = memrchr(at, '*', p->length), *end = text + length;
    size_t front = (size_t)(star - at), back = (size_t)(last - final - 1);
    if (!stands(at, front, text) || !stands(final + 1, back, end - back)) return false;
    text += front;
    end -= back;
    while (star < final) {
        const char *piece = ++star;
        while (*star != '*') star++;
        size_t wide = (size_t)(star - piece);
        text = find_piece(piece, wide, text, end);
        if (!text) return false;
        text += wide;
    }
    return true;
}

bool pattern_matches(const pattern *p, const char *name, const char *group)
{
    const char *text = p->of_group ? group : name;
    return (!p->of_group || *group) && matches(p, text, strlen(text));
}

/* ---- sets ---- */

void pattern_set_init(pattern_set *s, bool few)
{
    *s = (pattern_set){.few = few};
    pair_map_init(&s->lists);
}

void pattern_set_free(pattern_set *s)
{
    for (size_t i = 0; i < s->entries.count; i++)
        if (s->entries.at[i].used) pattern_free(&s->entries.at[i].pattern);
    array_free(&s->entries);
    array_free(&s->loose);
    pair_map_free(&s->lists);
    *s = (pattern_set){.count = 0};
}

bool pattern_set_has(const pattern_set *s, uint32_t id)
{
    return id < s->entries.count && s->entries.at[id].used;
}

static uint64_t key_step(uint64_t key, char c)
{
    return (key ^ (unsigned char)c) * UINT64_C(1099511628211);
}

static uint64_t key_start(bool of_group, bool by_tail)
{
    return secret() + 2 * (uint64_t)of_group + by_tail;
}

/* 0 is no key. */
static uint64_t key_of_length(uint64_t key, size_t length)
{
    uint64_t mixed = key ^ (uint64_t)length << 56;
    return mixed ? mixed : 1;
}

/* By the longer of head and tail: fewer have it. */
static void choose_key(pattern_entry *e, bool few)
{
    const pattern *p = &e->pattern;
    e->by_tail = p->tail > p->head;
    uint32_t length = e->by_tail ? p->tail : p->head;
    e->length = (uint8_t)(length < PATTERN_KEY_MAX ? length : PATTERN_KEY_MAX);
    if (!e->length || few) return;
    uint64_t key = key_start(p->of_group, e->by_tail);
    for (uint32_t i = 0; i < e->length; i++) key = key_step(key, e->by_tail ? p->text[p->length - 1 - i] : p->text[i]);
    e->key = key_of_length(key, e->length);
}

static void link_entry(pattern_set *s, uint32_t id)
{
    pattern_entry *e = &s->entries.at[id];
    s->lengths[e->pattern.of_group][e->by_tail][e->length >> 6] |= (uint64_t)1 << (e->length & 63);
    e->next = pair_map_get(&s->lists, e->key);
    e->previous = PAIR_MAP_NONE;
    if (e->next != PAIR_MAP_NONE) s->entries.at[e->next].previous = id;
    pair_map_put(&s->lists, e->key, id);
}

static void unlink_entry(pattern_set *s, const pattern_entry *e)
{
    if (e->next != PAIR_MAP_NONE) s->entries.at[e->next].previous = e->previous;
    if (e->previous != PAIR_MAP_NONE)
        s->entries.at[e->previous].next = e->next;
    else if (e->next != PAIR_MAP_NONE)
        pair_map_put(&s->lists, e->key, e->next);
    else
        pair_map_remove(&s->lists, e->key);
}

void pattern_set_add(pattern_set *s, uint32_t id, const char *text)
{
    array_reserve(&s->entries, (size_t)id + 1);
    while (s->entries.count <= id) s->entries.at[s->entries.count++] = (pattern_entry){.used = false};
    pattern_entry *e = &s->entries.at[id];
    *e = (pattern_entry){.used = true};
    pattern_init(&e->pattern, text);
    choose_key(e, s->few);
    s->count++;
    if (e->key) {
        link_entry(s, id);
    } else {
        e->next = (uint32_t)s->loose.count;
        array_push(&s->loose, id);
    }
}

void pattern_set_remove(pattern_set *s, uint32_t id)
{
    pattern_entry *e = &s->entries.at[id];
    if (e->key) {
        unlink_entry(s, e);
    } else {
        uint32_t moved = s->loose.at[--s->loose.count];
        s->loose.at[e->next] = moved;
        s->entries.at[moved].next = e->next;
    }
    pattern_free(&e->pattern);
    e->used = false;
    if (!--s->count) memset(s->lengths, 0, sizeof s->lengths);
}

typedef struct search {
    const pattern_set *set;
    const char *name, *group;
    pattern_ids *found; /* NULL: the least one is looked for */
    uint32_t least;
    size_t tried;
} search;

static void try_one(search *f, uint32_t id)
{
    if (!f->found && id >= f->least) return;
    const pattern *p = &f->set->entries.at[id].pattern;
    f->tried += p->least || !p->has_star || p->of_group; /* "*" costs nothing */
    if (!pattern_matches(p, f->name, f->group)) return;
    if (f->found)
        array_push(f->found, id);
    else
        f->least = id;
}

static void try_lists(search *f, bool of_group, bool tail)
{
    const char *text = of_group ? f->group : f->name;
    size_t length = strlen(text), last = length < PATTERN_KEY_MAX ? length : PATTERN_KEY_MAX;
    const uint64_t *lengths = f->set->lengths[of_group][tail];
    size_t longest = lengths[1] ? 127 - (size_t)__builtin_clzll(lengths[1]) : 63 - (size_t)__builtin_clzll(lengths[0]);
    uint64_t key = key_start(of_group, tail);
    if (longest < last) last = longest;
    for (size_t i = 1; i <= last; i++) {
        key = key_step(key, tail ? text[length - i] : text[i - 1]);
        if (!(lengths[i >> 6] >> (i & 63) & 1)) continue;
        uint32_t id = pair_map_get(&f->set->lists, key_of_length(key, i));
        for (; id != PAIR_MAP_NONE; id = f->set->entries.at[id].next) {
            const pattern_entry *e = &f->set->entries.at[id]; /* keys of others may clash with theirs */
            if (e->length == i && e->by_tail == tail && e->pattern.of_group == of_group) try_one(f, id);
        }
    }
}

static void search_lists(search *f)
{
    for (int of_group = 0; of_group < 2; of_group++)
        for (int tail = 0; tail < 2; tail++)
            if (f->set->lengths[of_group][tail][0] | f->set->lengths[of_group][tail][1]) try_lists(f, of_group, tail);
    for (size_t i = 0; i < f->set->loose.count; i++) try_one(f, f->set->loose.at[i]);
}

size_t pattern_set_find(const pattern_set *s, const char *name, const char *group, pattern_ids *found)
{
    search f = {s, name, group, found, PAIR_MAP_NONE, 1};
    search_lists(&f);
    return f.tried;
}

uint32_t pattern_set_first(const pattern_set *s, const char *name, const char *group)
{
    search f = {s, name, group, NULL, PAIR_MAP_NONE, 1};
    search_lists(&f);
    return f.least;
}

typedef struct longest_lists {
    const pattern_set *of;
    uint32_t most[2][2][PATTERN_KEY_MAX + 1]; /* of group, by tail, length */
} longest_lists;

static void measure_list(void *context, uint64_t key, uint32_t first_id)
{
    (void)key;
    longest_lists *l = context;
    const pattern_entry *entries = l->of->entries.at, *first = &entries[first_id];
    uint32_t in_list = 0, *most = &l->most[first->pattern.of_group][first->by_tail][first->length];
    for (uint32_t id = first_id; id != PAIR_MAP_NONE; id = entries[id].next) in_list++;
    if (in_list > *most) *most = in_list;
}

/* A name is held against the loose ones, and of each length against one list. */
size_t pattern_set_price(const pattern_set *s)
{
    size_t price = s->loose.count + 1;
    longest_lists l = {.of = s};
    pair_map_each(&s->lists, measure_list, &l);
    for (int of_group = 0; of_group < 2; of_group++)
        for (int tail = 0; tail < 2; tail++)
            for (int length = 0; length <= PATTERN_KEY_MAX; length++) price += l.most[of_group][tail][length];
    return price;
}
