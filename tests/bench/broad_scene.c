/* broad_scene: the scene and its motion, in whole numbers. One thread. */
#include "broad_scene.h"
#include "base/prng.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static const double UNIT = 1.0 / 16384;                 /* m */
static const double HALF_MIN = 0.25, HALF_MAX = 1;      /* m */
static const double SPEED_MIN = 0.01, SPEED_MAX = 0.02; /* of the mean size, a tick */
enum { DENSITY_SAMPLES = 20000, SEED = 20240229 };

static void *allocate(size_t count, size_t size)
{
    void *p = calloc(count ? count : 1, size);
    if (!p) abort();
    return p;
}

/* ---- random numbers: splitmix64 (Steele, Lea and Flood 2014) ---- */

/* ---- making ---- */

static void random_direction(uint64_t *state, double d[3])
{
    double length;
    do {
        for (int k = 0; k < 3; k++) d[k] = prng_in(state, -1, 1);
        length = sqrt(d[0] * d[0] + d[1] * d[1] + d[2] * d[2]);
    } while (length > 1 || length < 0.1);
    for (int k = 0; k < 3; k++) d[k] /= length;
}

static int32_t random_half(uint64_t *state)
{
    return (int32_t)lround(exp(prng_in(state, log(HALF_MIN), log(HALF_MAX))) / UNIT);
}

static void make_body(scene_body *b, uint64_t *state)
{
    double direction[3];
    b->sphere = prng_bits(state) & 1;
    for (int k = 0; k < 3; k++) b->half[k] = b->sphere && k ? b->half[0] : random_half(state);
    double size = 2 * ((double)b->half[0] + b->half[1] + b->half[2]) / 3;
    double speed = size * prng_in(state, SPEED_MIN, SPEED_MAX);
    random_direction(state, direction);
    for (int k = 0; k < 3; k++) b->velocity[k] = (int32_t)lround(speed * direction[k]);
}

/* How many others a box meets on the average in a cube of this side, if its centre and theirs are uniform: along one
 * axis two centres are nearer than r with probability 2 r/side - (r/side)^2. Over sampled pairs of sizes. */
static double expected_neighbours(const scene *s, double side)
{
    double sum = 0;
    uint64_t state = SEED;
    for (int i = 0; i < DENSITY_SAMPLES; i++) {
        const scene_body *a = &s->bodies[prng_bits(&state) % s->count];
        const scene_body *b = &s->bodies[prng_bits(&state) % s->count];
        double probability = 1;
        for (int k = 0; k < 3; k++) {
            double r = fmin(1, (a->half[k] + b->half[k]) / side);
            probability *= 2 * r - r * r;
        }
        sum += probability;
    }
    return sum / DENSITY_SAMPLES * (double)(s->count - 1);
}

static int32_t side_for_one_neighbour(const scene *s)
{
    double lo = 1 / UNIT, hi = 900 / UNIT; /* with the largest body, below 1024 m: exact in floats */
    while (hi - lo > 1) {
        double middle = 0.5 * (lo + hi);
        *(expected_neighbours(s, middle) > 1 ? &lo : &hi) = middle;
    }
    return (int32_t)hi;
}

static void shuffle(uint32_t *order, size_t count, uint64_t *state)
{
    for (size_t i = count; i > 1; i--) {
        size_t j = prng_bits(state) % i;
        uint32_t other = order[j];
        order[j] = order[i - 1];
        order[i - 1] = other;
    }
}

scene scene_create(size_t count)
{
    uint64_t state = SEED + count;
    scene s = {count, 0, allocate(count, sizeof *s.bodies), allocate(count, sizeof *s.order)};
    for (size_t i = 0; i < count; i++) make_body(&s.bodies[i], &state);
    s.side = side_for_one_neighbour(&s);
    for (size_t i = 0; i < count; i++)
        for (int k = 0; k < 3; k++) s.bodies[i].centre[k] = (int32_t)(prng_bits(&state) % ((uint64_t)s.side + 1));
    for (size_t i = 0; i < count; i++) s.order[i] = (uint32_t)i;
    shuffle(s.order, count, &state);
    return s;
}

void scene_destroy(scene *s)
{
    free(s->bodies);
    free(s->order);
    *s = (scene){0};
}

double scene_side_m(const scene *s)
{
    return s->side * UNIT;
}

/* ---- motion ---- */

static int ascending_ids(const void *a, const void *b)
{
    uint32_t x = *(const uint32_t *)a, y = *(const uint32_t *)b;
    return (x > y) - (x < y);
}

uint32_t *scene_movers(const scene *s, double percent, size_t *count)
{
    size_t wanted = (size_t)llround(1e-2 * percent * (double)s->count);
    *count = wanted < 1 ? 1 : wanted > s->count ? s->count : wanted;
    uint32_t *ids = allocate(*count, sizeof *ids);
    memcpy(ids, s->order, *count * sizeof *ids);
    qsort(ids, *count, sizeof *ids, ascending_ids);
    return ids;
}

static peer_body state_of(const scene_body *b)
{
    peer_body out;
    double square = 0;
    for (int k = 0; k < 3; k++) {
        out.lo[k] = (b->centre[k] - b->half[k]) * UNIT;
        out.hi[k] = (b->centre[k] + b->half[k]) * UNIT;
        out.step[k] = b->velocity[k] * UNIT;
        square += (b->half[k] * UNIT) * (b->half[k] * UNIT);
    }
    out.reach = b->sphere ? b->half[0] * UNIT : sqrt(square);
    return out;
}

static void advance(scene_body *b, int32_t side)
{
    for (int k = 0; k < 3; k++) {
        int32_t to = b->centre[k] + b->velocity[k];
        bool out = to < 0 || to > side;
        b->centre[k] = to < 0 ? -to : to > side ? 2 * side - to : to;
        if (out) b->velocity[k] = -b->velocity[k];
    }
}

void scene_advance(scene *s, const uint32_t *ids, size_t count, peer_body *out)
{
    for (size_t i = 0; i < count; i++) {
        advance(&s->bodies[ids[i]], s->side);
        out[i] = state_of(&s->bodies[ids[i]]);
    }
}

void scene_state(const scene *s, peer_body *out)
{
    for (size_t i = 0; i < s->count; i++) out[i] = state_of(&s->bodies[i]);
}

bool scene_overlap(const scene *s, uint32_t a, uint32_t b)
{
    const scene_body *p = &s->bodies[a], *q = &s->bodies[b];
    for (int k = 0; k < 3; k++)
        if (abs(p->centre[k] - q->centre[k]) > p->half[k] + q->half[k]) return false;
    return true;
}

/* ---- the truth ---- */

typedef struct key_list {
    uint64_t *at;
    size_t count, capacity;
} key_list;

static void add_key(key_list *list, uint32_t a, uint32_t b)
{
    if (list->count == list->capacity) {
        list->capacity = list->capacity ? 2 * list->capacity : 1024;
        list->at = realloc(list->at, list->capacity * sizeof *list->at);
        if (!list->at) abort();
    }
    list->at[list->count++] = a < b ? (uint64_t)a << 32 | b : (uint64_t)b << 32 | a;
}

static int ascending_keys(const void *a, const void *b)
{
    uint64_t x = *(const uint64_t *)a, y = *(const uint64_t *)b;
    return (x > y) - (x < y);
}

static void sort_unique(key_list *list)
{
    size_t kept = 0;
    if (list->count) qsort(list->at, list->count, sizeof *list->at, ascending_keys);
    for (size_t i = 0; i < list->count; i++)
        if (!kept || list->at[i] != list->at[kept - 1]) list->at[kept++] = list->at[i];
    list->count = kept;
}

truth truth_find(const scene *s, size_t watch)
{
    key_list found = {0};
    truth t = {.watched_count = watch < s->count ? watch : s->count, .watched = allocate(s->count, sizeof *t.watched)};
    for (size_t i = 0; i < t.watched_count; i++) t.watched[i * s->count / t.watched_count] = true;
    for (uint32_t a = 0; a < s->count; a++) {
        if (!t.watched[a]) continue;
        for (uint32_t b = 0; b < s->count; b++)
            if (a != b && !(t.watched[b] && b < a) && scene_overlap(s, a, b)) add_key(&found, a, b);
    }
    sort_unique(&found);
    t.pairs = found.at;
    t.count = found.count;
    return t;
}

void truth_destroy(truth *t)
{
    free(t->watched);
    free(t->pairs);
    *t = (truth){0};
}

typedef struct jury {
    const truth *truth;
    const scene *scene;
    verdict verdict;
    key_list watched; /* reported pairs of watched bodies */
} jury;

static void hear(void *context, uint32_t a, uint32_t b)
{
    jury *j = context;
    j->verdict.pairs++;
    j->verdict.overlap += scene_overlap(j->scene, a, b);
    if (j->truth->watched[a] || j->truth->watched[b]) add_key(&j->watched, a, b);
}

verdict truth_judge(const truth *t, const scene *s, const peer *p, void *world)
{
    jury j = {.truth = t, .scene = s};
    p->pairs(world, hear, &j);
    sort_unique(&j.watched);
    size_t at = 0;
    for (size_t i = 0; i < t->count; i++) {
        while (at < j.watched.count && j.watched.at[at] < t->pairs[i]) at++;
        j.verdict.missed += at == j.watched.count || j.watched.at[at] != t->pairs[i];
    }
    free(j.watched.at);
    return j.verdict;
}
