/* step: from the ways of bodies to contacts and the safe step, in portions of some milliseconds at most, whatever the
 * input. First the boxes are made (refit.c). Then, round by round: the caller's thread descends the trees, two nodes at
 * a time, until a round of leaf pairs is together; the workers look at these for candidates (leaves.c) and leave out
 * those that a direction proves free (sift.c) or a flat star (stars.c). What is left waits in lists, one a chunk of
 * leaf pairs, and is asked of the elementary tests, so many at a time. Where a portion ends, what it costs and when the
 * step stops follow from counts, and all that is found is put in order before it is told: so nothing depends on who did
 * what.
 *
 * Where the safe step is all that is wanted, only what comes before the earliest contact of the rounds before is looked
 * for, and the boxes are made anew for the shorter way whenever it has halved. */
#include "contacts.h"
#include "elementary.h"
#include "state.h"

#include "base/array.h"
#include "base/sort.h"

#include <stdatomic.h>
#include <stdlib.h>
#include <string.h>

enum {
    ROUND_FIRST = 32, /* leaf pairs: few at first, so that the way is soon shorter */
    ROUND_MOST = 128, /* of crumpled noise up to 1,500 candidates each: 6 MB, and some 10 ms */
    ROUND_NODES = 1 << 16,
    CHUNK = 16, /* leaf pairs whose candidates stand in one list */
    CHUNKS = ROUND_MOST / CHUNK,
    TESTS_MOST = 4096, /* of a portion: some 6 ms, if all of them meet */
    TESTS_A_CHUNK = 64,
    UNITS_LEAF_PAIR = 20, /* of some 10 ns */
    UNITS_CANDIDATE = 3,
    UNITS_TEST = 20,
    UNITS_CONTACT = 8, /* to be put in order */
    UNITS_TEST_STEP = 10,
    SPARE_CONTACTS = 1 << 15, /* beyond those that are kept, before they are sorted and cut */
};

#define HI_UNKNOWN 2.0

typedef struct node_pair {
    uint32_t a, b;
} node_pair;

typedef struct earliest { /* the contact with the least t_lo; of equals the first in canonical order */
    soft_contact contact;
    double t_lo, t_hi;
    bool any;
} earliest;

typedef struct open_candidate { /* that neither a direction nor a star proves free */
    soft_candidate candidate;
    soft_kind kind;
} open_candidate;
typedef ARRAY(open_candidate) open_candidates;

typedef struct one_worker {
    soft_lists lists;
    open_candidates *open; /* of the chunk that it looks at */
    soft_contacts found;
    soft_tally tally;
    soft_work work;
    earliest first;
    struct soft_step *step;
} one_worker;

struct soft_step {
    workers *pool;
    unsigned worker_count;
    one_worker *workers;
    soft_step_def def; /* its arrays are copies */
    ARRAY(soft_body *) bodies;
    ARRAY(soft_pair) pairs;
    ARRAY(soft_tally) tallies;
    ARRAY(size_t) stars_first; /* by body: where its stars begin */
    struct {
        _Atomic uint8_t *at;
        size_t capacity;
    } stars;
    vec3 origin;
    double share; /* of the way, which the boxes span */
    soft_refitting refitting;
    size_t refitted;              /* bodies whose boxes span that */
    uint64_t others;              /* units that boxes, and contacts that are cut off, have taken */
    size_t round, pair;           /* the pair that is looked at, or pair_count */
    open_candidates open[CHUNKS]; /* by chunk of the round's leaf pairs */
    size_t open_first[CHUNKS + 1], tested;
    bool looked; /* for the candidates of this round */
    soft_terms terms;
    elementary_terms ask;
    bool stars_apply; /* to a body with itself, at separation 0 */
    ARRAY(node_pair) stack, leaves;
    soft_contacts contacts, scratch;
    soft_work work;
    earliest first;
    bool done;
};

soft_step *soft_step_create(workers *pool)
{
    soft_step *s = base_zalloc(1, sizeof *s);
    s->pool = pool;
    s->worker_count = pool ? workers_count(pool) : 1;
    s->workers = base_zalloc(s->worker_count, sizeof *s->workers);
    return s;
}

void soft_step_destroy(soft_step *s)
{
    if (!s) return;
    for (unsigned i = 0; i < s->worker_count; i++) array_free(&s->workers[i].found);
    for (size_t i = 0; i < CHUNKS; i++) array_free(&s->open[i]);
    free(s->workers), free(s->stars.at);
    array_free(&s->bodies), array_free(&s->pairs), array_free(&s->tallies), array_free(&s->stars_first);
    array_free(&s->stack), array_free(&s->leaves), array_free(&s->contacts), array_free(&s->scratch);
    free(s);
}

size_t soft_step_bytes(const soft_step *s)
{
    size_t bytes = sizeof *s + s->worker_count * sizeof *s->workers;
    for (unsigned i = 0; i < s->worker_count; i++) bytes += s->workers[i].found.capacity * sizeof(soft_contact);
    bytes += s->bodies.capacity * sizeof *s->bodies.at + s->pairs.capacity * sizeof *s->pairs.at;
    bytes += s->tallies.capacity * sizeof *s->tallies.at + s->stars_first.capacity * sizeof *s->stars_first.at;
    for (size_t i = 0; i < CHUNKS; i++) bytes += s->open[i].capacity * sizeof(open_candidate);
    bytes += s->stars.capacity + (s->stack.capacity + s->leaves.capacity) * sizeof(node_pair);
    return bytes + (s->contacts.capacity + s->scratch.capacity) * sizeof(soft_contact);
}

/* ---- what one pair of features comes to ---- */

static bool comes_first(const soft_contact *a, const soft_contact *b)
{
    if (a->pair != b->pair) return a->pair < b->pair;
    if (a->kind != b->kind) return a->kind < b->kind;
    return a->a != b->a ? a->a < b->a : a->b < b->b;
}

static void take_earliest(earliest *e, const earliest *other)
{
    if (!other->any) return;
    if (e->any && e->t_lo < other->t_lo) return;
    if (e->any && e->t_lo == other->t_lo && comes_first(&e->contact, &other->contact)) return;
    *e = *other;
}

static float single_below(double t)
{
    float f = (float)t;
    return (double)f > t ? nextafterf(f, -1) : f;
}

static float single_above(double t)
{
    float f = (float)t;
    return (double)f < t ? nextafterf(f, 2) : f;
}

static void tell(one_worker *w, const soft_candidate *c, soft_kind kind, const elementary_result *r)
{
    const soft_step *s = w->step;
    soft_contact contact = {.pair = (uint32_t)s->pair, .a = c->a, .b = c->b, .kind = (uint8_t)kind};
    contact.t_lo = single_below(r->t_lo), contact.t_hi = single_above(r->t_hi);
    contact.proof = r->proof == ELEMENTARY_CERTAIN  ? SOFT_CERTAIN
                    : r->proof == ELEMENTARY_WITHIN ? SOFT_WITHIN
                                                    : SOFT_UNDECIDED;
    take_earliest(&w->first, &(earliest){contact, r->t_lo, r->t_hi, true});
    if (s->def.want == SOFT_SAFE_STEP) return;
    *(kind == SOFT_EDGE_EDGE ? &w->tally.edge_edge : &w->tally.vertex_face) += 1;
    w->tally.within += contact.proof == SOFT_WITHIN;
    w->tally.undecided += contact.proof == SOFT_UNDECIDED;
    array_push(&w->found, contact);
}

static _Atomic uint8_t *stars_of(const soft_step *s) /* of the pair's body, which is with itself */
{
    return s->stars.at + s->stars_first.at[s->def.pairs[s->pair].a];
}

/* Of what rounding cannot tell from a contact a layer may prove that it is none. Where it was left out it is asked now,
 * so that the contacts are the same. (What is certain no layer disputes.) */
static bool left_out_layer_proves(const soft_step *s, const soft_candidate *c, soft_kind kind)
{
    const soft_body *a = s->terms.a, *b = s->terms.b;
    if (s->def.without & (SOFT_WITHOUT_HIERARCHY | SOFT_WITHOUT_BOXES) &&
        (kind == SOFT_FACE_VERTEX ? soft_features_apart(b, a, c, kind) : soft_features_apart(a, b, c, kind)))
        return true;
    soft_candidate one = *c;
    if (s->def.without & SOFT_WITHOUT_DIRECTIONS &&
        soft_sift(&one, 1, kind, a->ways, b->ways, s->ask.separation, s->ask.until) == 0)
        return true;
    return s->def.without & SOFT_WITHOUT_STARS && s->stars_apply &&
           soft_in_flat_star(a->mesh, a->ways, c, kind, stars_of(s));
}

static void test_one(one_worker *w, const soft_candidate *c, soft_kind kind)
{
    const soft_step *s = w->step;
    const soft_way *a = s->terms.a->ways, *b = s->terms.b->ways;
    const soft_way *first = kind == SOFT_FACE_VERTEX ? b : a, *second = kind == SOFT_FACE_VERTEX ? a : b;
    vec3 start[4], end[4];
    for (int i = 0; i < 4; i++) {
        const soft_way *way = (i < (kind == SOFT_EDGE_EDGE ? 2 : 1) ? first : second) + c->vertex[i];
        start[i] = way->start, end[i] = way->end;
    }
    elementary_result r;
    (kind == SOFT_EDGE_EDGE ? elementary_edge_edge_on : elementary_vertex_face_on)(start, end, &s->ask, &r);
    w->work.tests++, w->work.steps += (uint64_t)r.steps;
    if (r.status == ELEMENTARY_FREE) return;
    if (r.proof != ELEMENTARY_CERTAIN && s->def.without && left_out_layer_proves(s, c, kind)) return;
    tell(w, c, kind, &r);
}

/* What no direction and no star proves free is put on the list of the chunk. */
static void sift_list(soft_lists *lists, soft_kind kind, void *context)
{
    one_worker *w = context;
    const soft_step *s = w->step;
    const soft_way *a = s->terms.a->ways, *b = s->terms.b->ways;
    soft_candidate *list = lists->at[kind];
    size_t count = lists->count[kind];
    lists->count[kind] = 0;
    w->work.candidates += count;
    if (!(s->def.without & SOFT_WITHOUT_DIRECTIONS)) {
        size_t left = soft_sift(list, count, kind, a, b, s->ask.separation, s->ask.until);
        w->work.by_direction += count - left;
        count = left;
    }
    _Atomic uint8_t *stars = s->stars_apply && !(s->def.without & SOFT_WITHOUT_STARS) ? stars_of(s) : NULL;
    for (size_t i = 0; i < count; i++) {
        if (stars && soft_in_flat_star(s->terms.a->mesh, a, &list[i], kind, stars))
            w->work.by_star++;
        else
            array_push(w->open, ((open_candidate){list[i], kind}));
    }
}

static void look_into(void *context, size_t begin, size_t end, unsigned worker)
{
    soft_step *s = context;
    one_worker *w = &s->workers[worker];
    for (size_t chunk = begin; chunk < end; chunk++) {
        size_t last = (chunk + 1) * CHUNK < s->leaves.count ? (chunk + 1) * CHUNK : s->leaves.count;
        w->open = &s->open[chunk];
        w->open->count = 0;
        for (size_t i = chunk * CHUNK; i < last; i++)
            soft_find_candidates(&s->terms, s->leaves.at[i].a, s->leaves.at[i].b, &w->lists);
        for (int k = 0; k < SOFT_KINDS; k++)
            if (w->lists.count[k]) sift_list(&w->lists, (soft_kind)k, w);
    }
}

static void test_some(void *context, size_t begin, size_t end, unsigned worker)
{
    soft_step *s = context;
    size_t chunk = 0;
    for (size_t i = s->tested + begin; i < s->tested + end; i++) {
        while (s->open_first[chunk + 1] <= i) chunk++;
        const open_candidate *o = &s->open[chunk].at[i - s->open_first[chunk]];
        test_one(&s->workers[worker], &o->candidate, o->kind);
    }
}

/* ---- beginning ---- */

static bool twice(soft_body *const *bodies, size_t count)
{
    uint64_t *keys = base_alloc(2 * count + 1, sizeof *keys);
    bool same = false;
    for (size_t i = 0; i < count; i++) keys[i] = (uint64_t)(uintptr_t)bodies[i];
    sort_keys(keys, keys + count, count);
    for (size_t i = 1; i < count; i++) same |= keys[i] == keys[i - 1];
    free(keys);
    return same;
}

static soft_status check_step(const soft_step_def *def)
{
    if (def->body_count > SOFT_BODIES_MAX || def->pair_count > UINT32_MAX) return SOFT_TOO_MANY;
    if (!(def->separation >= 0 && def->separation <= SOFT_FAR_M)) return SOFT_NO_NUMBER;
    for (size_t i = 0; i < def->pair_count; i++)
        if (def->pairs[i].a >= def->body_count || def->pairs[i].b >= def->body_count) return SOFT_OUT_OF_RANGE;
    return twice(def->bodies, def->body_count) ? SOFT_BODY_TWICE : SOFT_OK;
}

static void copy_definition(soft_step *s, const soft_step_def *def)
{
    s->def = *def;
    s->bodies.count = s->pairs.count = s->tallies.count = 0;
    for (size_t i = 0; i < def->body_count; i++) array_push(&s->bodies, def->bodies[i]);
    for (size_t i = 0; i < def->pair_count; i++) {
        array_push(&s->pairs, def->pairs[i]);
        array_push(&s->tallies, (soft_tally){0});
    }
    s->def.bodies = s->bodies.at, s->def.pairs = s->pairs.at;
}

static void forget_stars(soft_step *s)
{
    size_t vertices = 0;
    s->stars_first.count = 0;
    for (size_t i = 0; i < s->bodies.count; i++) {
        array_push(&s->stars_first, vertices);
        vertices += s->bodies.at[i]->mesh->vertex_count;
    }
    if (vertices > s->stars.capacity) {
        free(s->stars.at);
        s->stars.at = base_alloc(vertices, 1);
        s->stars.capacity = vertices;
    }
    for (size_t i = 0; i < vertices; i++) atomic_init(&s->stars.at[i], 0);
}

static void refit_anew(soft_step *s)
{
    s->refitted = 0;
    s->refitting = (soft_refitting){.from = 0};
}

/* A portion of it. */
static void refit_some(soft_step *s)
{
    soft_body *b = s->bodies.at[s->refitted];
    s->refitting.origin = s->origin;
    s->refitting.margin = b->half_thickness + 0.5 * s->def.separation;
    s->refitting.share = s->share;
    s->others += soft_refit(b, &s->refitting, s->pool);
    if (s->refitting.stage != SOFT_REFIT_DONE) return;
    s->refitting = (soft_refitting){.from = 0};
    s->refitted++;
}

static vec3 middle_of(const soft_step *s)
{
    if (s->bodies.count == 0) return VEC_ZERO;
    vec3 low = s->bodies.at[0]->lowest, high = s->bodies.at[0]->highest;
    for (size_t i = 1; i < s->bodies.count; i++) {
        low = vec_min(low, s->bodies.at[i]->lowest);
        high = vec_max(high, s->bodies.at[i]->highest);
    }
    return vec_scale(vec_add(low, high), 0.5);
}

static void begin_pair(soft_step *s)
{
    if (s->pair == s->pairs.count) return;
    soft_pair p = s->pairs.at[s->pair];
    s->terms = (soft_terms){s->bodies.at[p.a], s->bodies.at[p.b], p.a == p.b, s->def.without & SOFT_WITHOUT_BOXES};
    s->ask.separation = s->terms.a->half_thickness + s->terms.b->half_thickness + s->def.separation;
    s->stars_apply = s->terms.self && s->ask.separation == 0;
    array_push(&s->stack, ((node_pair){0, 0}));
}

soft_status soft_step_begin(soft_step *s, const soft_step_def *def)
{
    soft_status status = check_step(def);
    s->contacts.count = s->stack.count = s->leaves.count = s->pairs.count = s->bodies.count = 0;
    s->pair = s->round = s->tested = s->others = 0;
    memset(s->open_first, 0, sizeof s->open_first);
    s->looked = false;
    s->work = (soft_work){0}, s->first = (earliest){0};
    s->share = 1;
    s->done = false;
    if (status != SOFT_OK) return status;
    copy_definition(s, def);
    s->ask = (elementary_terms){.until = 1, .verdict = def->want == SOFT_VERDICTS};
    s->origin = middle_of(s);
    forget_stars(s);
    refit_anew(s);
    for (unsigned i = 0; i < s->worker_count; i++) {
        one_worker *w = &s->workers[i];
        w->step = s, w->lists.full = sift_list, w->lists.context = w;
        memset(w->lists.count, 0, sizeof w->lists.count);
    }
    begin_pair(s);
    return SOFT_OK;
}

/* ---- rounds ---- */

static void descend(soft_step *s, node_pair p)
{
    const soft_node *a = &s->terms.a->mesh->nodes[p.a], *b = &s->terms.b->mesh->nodes[p.b];
    if (s->terms.self && p.a == p.b) {
        array_push(&s->stack, ((node_pair){a->left, a->right}));
        array_push(&s->stack, ((node_pair){a->right, a->right}));
        array_push(&s->stack, ((node_pair){a->left, a->left}));
    } else if (b->left == SOFT_NONE || (a->left != SOFT_NONE && a->leaves >= b->leaves)) {
        array_push(&s->stack, ((node_pair){a->right, p.b}));
        array_push(&s->stack, ((node_pair){a->left, p.b}));
    } else {
        array_push(&s->stack, ((node_pair){p.a, b->right}));
        array_push(&s->stack, ((node_pair){p.a, b->left}));
    }
}

static void gather_leaves(soft_step *s)
{
    size_t most = s->round < 2 ? (size_t)ROUND_FIRST << s->round : ROUND_MOST, nodes = 0;
    bool boxes = !(s->def.without & SOFT_WITHOUT_HIERARCHY);
    s->leaves.count = 0;
    for (; s->stack.count && s->leaves.count < most && nodes < ROUND_NODES; nodes++) {
        node_pair p = s->stack.at[--s->stack.count];
        bool same = s->terms.self && p.a == p.b;
        if (!same && boxes && soft_boxes_apart(&s->terms.a->node_boxes[p.a], &s->terms.b->node_boxes[p.b])) continue;
        bool leaf_a = s->terms.a->mesh->nodes[p.a].left == SOFT_NONE;
        if (leaf_a && s->terms.b->mesh->nodes[p.b].left == SOFT_NONE)
            array_push(&s->leaves, p);
        else
            descend(s, p);
    }
    s->work.node_pairs += nodes;
    s->work.cluster_pairs += s->leaves.count;
}

static void take_in(soft_step *s)
{
    soft_tally *tally = &s->tallies.at[s->pair];
    for (unsigned i = 0; i < s->worker_count; i++) {
        one_worker *w = &s->workers[i];
        array_reserve(&s->contacts, s->contacts.count + w->found.count);
        if (w->found.count)
            memcpy(s->contacts.at + s->contacts.count, w->found.at, w->found.count * sizeof *w->found.at);
        s->contacts.count += w->found.count;
        tally->vertex_face += w->tally.vertex_face, tally->edge_edge += w->tally.edge_edge;
        tally->within += w->tally.within, tally->undecided += w->tally.undecided;
        s->work.candidates += w->work.candidates, s->work.by_direction += w->work.by_direction;
        s->work.by_star += w->work.by_star, s->work.tests += w->work.tests, s->work.steps += w->work.steps;
        take_earliest(&s->first, &w->first);
        w->found.count = 0, w->tally = (soft_tally){0}, w->work = (soft_work){0}, w->first = (earliest){0};
    }
}

/* Far more contacts than are kept: the last ones go. */
static bool are_too_many(const soft_step *s)
{
    return s->contacts.count > s->def.contacts_max && s->contacts.count - s->def.contacts_max > SPARE_CONTACTS;
}

static void keep_contacts(soft_step *s)
{
    s->others += UNITS_CONTACT * s->contacts.count;
    soft_contacts_keep(&s->contacts, &s->scratch, s->def.contacts_max);
}

/* What may be as early as the earliest is looked for still: of equals the first in canonical order is told. */
static void shorten(soft_step *s)
{
    if (s->def.want != SOFT_SAFE_STEP || !s->first.any || (s->def.without & SOFT_WITHOUT_SHORTENING)) return;
    s->ask.until = s->first.t_lo < 1 ? nextafter(s->first.t_lo, 1) : 1;
    if (!(s->ask.until < 0.5 * s->share)) return;
    s->share = s->ask.until;
    refit_anew(s);
}

static uint64_t units_of(const soft_step *s)
{
    const soft_work *w = &s->work;
    return s->others + w->node_pairs + UNITS_LEAF_PAIR * w->cluster_pairs + UNITS_CANDIDATE * w->candidates +
           UNITS_TEST * w->tests + UNITS_TEST_STEP * w->steps;
}

static void count_left_out(soft_step *s)
{
    for (size_t i = 0; i < s->tallies.count; i++)
        s->tallies.at[i].left_out = s->tallies.at[i].vertex_face + s->tallies.at[i].edge_edge;
    for (size_t i = 0; i < s->contacts.count; i++) s->tallies.at[s->contacts.at[i].pair].left_out--;
}

static void spread(soft_step *s, size_t count, size_t chunk, workers_function *f)
{
    if (s->pool)
        workers_run(s->pool, count, chunk, f, s);
    else
        f(s, 0, count, 0);
}

static void look_for_candidates(soft_step *s)
{
    gather_leaves(s);
    size_t chunks = (s->leaves.count + CHUNK - 1) / CHUNK;
    spread(s, chunks, 1, look_into);
    for (size_t i = 0; i < CHUNKS; i++) s->open_first[i + 1] = s->open_first[i] + (i < chunks ? s->open[i].count : 0);
    s->tested = 0;
}

static void test_portion(soft_step *s)
{
    size_t left = s->open_first[CHUNKS] - s->tested, count = left < TESTS_MOST ? left : TESTS_MOST;
    spread(s, count, TESTS_A_CHUNK, test_some);
    s->tested += count;
}

static void do_portion(soft_step *s)
{
    if (s->refitted < s->bodies.count) {
        refit_some(s);
        return;
    }
    if (are_too_many(s)) {
        keep_contacts(s);
        return;
    }
    if (!s->looked) {
        look_for_candidates(s);
        s->looked = true;
    } else {
        test_portion(s);
    }
    take_in(s);
    if (s->tested < s->open_first[CHUNKS]) return;
    s->looked = false;
    shorten(s);
    s->round++;
    if (s->stack.count == 0) {
        s->pair++;
        begin_pair(s);
    }
}

soft_status soft_step_run(soft_step *s, uint64_t units)
{
    uint64_t before = units_of(s);
    while (s->pair < s->pairs.count) {
        if (units && units_of(s) - before >= units) return SOFT_MORE;
        do_portion(s);
    }
    if (s->done) return SOFT_OK;
    if (units && units_of(s) - before >= units) return SOFT_MORE;
    keep_contacts(s);
    count_left_out(s);
    s->done = true;
    return SOFT_OK;
}

/* ---- results ---- */

const soft_contact *soft_step_contacts(const soft_step *s, size_t *count)
{
    *count = s->contacts.count;
    return s->contacts.at;
}

const soft_tally *soft_step_tallies(const soft_step *s)
{
    return s->tallies.at;
}

soft_work soft_step_work(const soft_step *s)
{
    return s->work;
}

uint64_t soft_step_units(const soft_step *s)
{
    return units_of(s);
}

void soft_step_safe(const soft_step *s, double *lo, double *hi)
{
    *lo = !s->done ? 0 : s->first.any ? s->first.t_lo : 1;
    *hi = !s->first.any                            ? (s->done ? INFINITY : HI_UNKNOWN)
          : s->first.contact.proof == SOFT_CERTAIN ? s->first.t_hi
                                                   : HI_UNKNOWN;
}

static bool all_kept(const soft_step *s)
{
    for (size_t i = 0; i < s->tallies.count; i++)
        if (s->tallies.at[i].left_out) return false;
    return true;
}

static void take_time(float *times, const uint32_t *vertices, int count, float t)
{
    for (int i = 0; i < count; i++)
        if (t < times[vertices[i]]) times[vertices[i]] = t;
}

void soft_step_vertex_times(const soft_step *s, uint32_t body, float *out)
{
    const soft_mesh *m = s->bodies.at[body]->mesh;
    bool known = s->done && s->def.want == SOFT_BRACKETS && all_kept(s);
    for (size_t i = 0; i < m->vertex_count; i++) out[i] = known ? 1 : 0;
    for (size_t i = 0; known && i < s->contacts.count; i++) {
        const soft_contact *c = &s->contacts.at[i];
        soft_pair p = s->pairs.at[c->pair];
        for (int k = 0; k < 2; k++) {
            uint32_t id = k ? c->b : c->a;
            if ((k ? p.b : p.a) != body) continue;
            if (c->kind == SOFT_EDGE_EDGE)
                take_time(out, m->edges[id], 2, c->t_lo);
            else if ((c->kind == SOFT_VERTEX_FACE) == (k == 0))
                take_time(out, &id, 1, c->t_lo);
            else
                take_time(out, m->triangles[id], 3, c->t_lo);
        }
    }
}
