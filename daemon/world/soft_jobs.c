/* soft_jobs: steps of soft bodies, over as many ticks as they take. Tick thread; the pool inside of soft_step_run.
 *
 * Before a tick looks at pairs, bodies with a frame that waits are put together with those that they may meet on the
 * way; what meets nobody else is a job of its own, so that nobody waits for strangers. A job goes on for a part of the
 * tick's slice; when it is done its bodies are where their frames say, as one, and its results are this tick's. Which
 * jobs there are, what they are soft_asked and when they end follows from commands and counts, and so do all results.
 */
#include "soft_state.h"
#include "subscription.h"

#include <stdlib.h>

enum {
    PART = 4,    /* of a slice, at most */
    A_UNIT = 10, /* of soft.h, in those of a slice */
    UNITS_AT_LEAST = 100000,
    REFIT_A_VERTEX = 12 /* units, with all that goes by vertices when a step begins */
};
static const uint64_t JOB_UNITS_MOST = 100000000;    /* a second: beyond, what is left is reported as unfinished */
static const size_t CONTACTS_MOST = (size_t)1 << 22; /* kept of a step, 24 bytes each; others are counted */

double soft_separation(const subscription *i, double padding)
{
    return fmax(i->threshold + padding, 0);
}

bool soft_is_wanted(const world *w, uint32_t id, const body *a, const body *b)
{
    const subscription *i = &w->subscriptions.at[id];
    if (!i->used || i->closing || !(i->facts & (WORLD_TOUCH | WORLD_MANIFOLD | WORLD_FEATURES | WORLD_SAFE_STEP)))
        return false;
    subscription_sides sides = subscription_sides_of(w, id, a, b);
    return sides.straight || sides.turned;
}

static void free_job(soft_job *j)
{
    for (size_t i = 0; i < j->asks.count; i++) array_free(&j->asks.at[i].pairs);
    array_free(&j->asks), array_free(&j->places), array_free(&j->bodies);
    for (size_t i = 0; i < j->results.count; i++) free(j->results.at[i].contacts), free(j->results.at[i].touches);
    array_free(&j->results);
    soft_drop_frame(&j->proposal);
    soft_body_destroy(j->proposed_body);
    soft_step_destroy(j->step);
    free(j);
}

void soft_jobs_free(world *w)
{
    for (size_t i = 0; i < w->soft->jobs.count; i++) free_job(w->soft->jobs.at[i]);
    array_free(&w->soft->jobs);
}

/* The others of the job begin again. */
void soft_forget_jobs(world *w, const soft_place *gone)
{
    size_t kept = 0;
    for (size_t i = 0; i < w->soft->jobs.count; i++) {
        soft_job *j = w->soft->jobs.at[i];
        bool has = false;
        for (size_t k = 0; k < j->places.count; k++) has |= j->places.at[k] == gone;
        if (!has) {
            w->soft->jobs.at[kept++] = j;
            continue;
        }
        for (size_t k = 0; k < j->places.count && !j->proposed; k++)
            j->places.at[k]->under_way = false, j->places.at[k]->asked = true;
        free_job(j);
    }
    w->soft->jobs.count = kept;
}

bool soft_is_busy(const world *w)
{
    if (w->soft->jobs.count) return true;
    for (size_t i = 0; i < w->soft->places.count; i++) {
        const soft_place *p = w->soft->places.at[i];
        if (p && (p->next.at || p->asked || p->proposal_count)) return true;
    }
    return false;
}

size_t soft_waiting_of(const world *w, uint64_t owner)
{
    size_t waiting = 0;
    for (size_t i = 0; i < w->soft->places.count; i++) {
        const soft_place *p = w->soft->places.at[i];
        bool acts = p && (p->next.at || p->asked || p->under_way || p->proposal_count);
        waiting += acts && w->bodies.at[p->body].owner == owner;
    }
    return waiting;
}

/* ---- who is in it ---- */

static const vec3 *end_of(const soft_place *p)
{
    return p->next.at ? p->next.at : p->at;
}

typedef struct span {
    vec3 lo, hi;
} span;

static span span_of(const soft_place *p, const vec3 *end)
{
    span s = {p->at[0], p->at[0]};
    for (size_t i = 0; i < p->count; i++) {
        s.lo = vec_min(s.lo, vec_min(p->at[i], end[i]));
        s.hi = vec_max(s.hi, vec_max(p->at[i], end[i]));
    }
    return s;
}

static bool meet(const span *a, const span *b, double within)
{
    aabb x = aabb_grow((aabb){a->lo, a->hi}, within), y = {b->lo, b->hi};
    return aabb_overlap(x, y);
}

/* Adds the pair to what is soft_asked, for each separation that somebody wants of it. Is it wanted by anybody? */
static bool ask_pair(world *w, soft_job *j, uint32_t a, uint32_t b, const soft_place *p, const soft_place *q,
    const span *x, const span *y)
{
    const body *one = &w->bodies.at[p->body], *other = &w->bodies.at[q->body];
    bool any = false,
         in_order = p == q || colliders_in_order(w, &w->colliders.at[p->collider], &w->colliders.at[q->collider]);
    if (p != q && one->fixed && other->fixed) return false;
    pair_terms terms = pair_get_terms(w, one, other);
    for (uint32_t id = 0; terms.checked && id < w->subscriptions.count; id++) {
        if (!soft_is_wanted(w, id, one, other)) continue;
        const subscription *i = &w->subscriptions.at[id];
        double separation = soft_separation(i, terms.padding);
        double within = (separation + p->half_thickness + q->half_thickness) * (1 + 0x1p-40);
        if (p != q && !meet(x, y, within + 0x1p-40 * fmax(vec_max_abs(x->hi), vec_max_abs(x->lo)))) continue;
        any = true;
        if (!j) return true;
        soft_want want = i->accuracy == WORLD_BY_VERDICT || !(i->facts & (WORLD_FEATURES | WORLD_SAFE_STEP))
                             ? SOFT_VERDICTS
                             : SOFT_BRACKETS;
        if (!(i->facts & ~(unsigned)WORLD_SAFE_STEP)) want = SOFT_SAFE_STEP;
        size_t most = !(i->facts & WORLD_FEATURES) || !i->soft_each ? 1 : i->soft_most ? i->soft_most : CONTACTS_MOST;
        size_t k = 0;
        while (k < j->asks.count && j->asks.at[k].separation != separation) k++;
        if (k == j->asks.count)
            array_push(&j->asks, ((soft_asked){.separation = separation, .want = want, .most = most}));
        soft_asked *to = &j->asks.at[k];
        bool brackets = to->want == SOFT_BRACKETS || want == SOFT_BRACKETS || to->want != want;
        to->want = brackets ? SOFT_BRACKETS : want;
        if (most > to->most) to->most = most;
        const soft_pair pair = in_order ? (soft_pair){a, b} : (soft_pair){b, a};
        const soft_pair *last = to->pairs.count ? &to->pairs.at[to->pairs.count - 1] : NULL;
        if (!last || last->a != pair.a || last->b != pair.b) array_push(&to->pairs, pair);
    }
    return any;
}

/* Contacts of a step are limited as a whole: of a wish per pair there is room for each. */
static void finish_asks(soft_job *j)
{
    for (size_t k = 0; k < j->asks.count; k++) {
        soft_asked *a = &j->asks.at[k];
        a->most = a->most < CONTACTS_MOST / (a->pairs.count + 1) ? a->most * a->pairs.count : CONTACTS_MOST;
    }
}

soft_job *soft_job_create(world *w)
{
    soft_job *j = base_zalloc(1, sizeof *j);
    j->step = soft_step_create(w->workers);
    array_push(&w->soft->jobs, j);
    return j;
}

static soft_positions way_of(const soft_job *j, uint32_t k)
{
    const soft_place *p = j->places.at[k];
    if (j->proposed) return (soft_positions){p->at, k == 0 ? j->proposal.at : p->at};
    const vec3 *end = end_of(p);
    return (soft_positions){p->next.teleports ? end : p->at, end};
}

void soft_job_place(soft_job *j)
{
    for (uint32_t i = 0; i < j->places.count; i++) {
        soft_place *p = j->places.at[i];
        soft_body *b = p->engine;
        if (j->proposed && i == 0) {
            b = j->proposed_body = soft_body_create(p->mesh);
            soft_body_set_thickness(b, p->half_thickness);
        }
        soft_positions way = way_of(j, i);
        soft_body_set(b, way.from, way.to);
        array_push(&j->bodies, b);
    }
}

/* ---- which jobs ---- */

typedef struct groups { /* of the places that have something to do, and whom they may meet */
    ARRAY(soft_place *) places;
    ARRAY(span) spans;
    ARRAY(uint32_t) leader;
    ARRAY(uint8_t) acts, waits;
} groups;

static uint32_t leader_of(groups *g, uint32_t i)
{
    while (g->leader.at[i] != i) i = g->leader.at[i] = g->leader.at[g->leader.at[i]];
    return i;
}

static void gather_places(world *w, groups *g)
{
    for (size_t i = 0; i < w->soft->places.count; i++) {
        soft_place *p = w->soft->places.at[i];
        if (!p || w->bodies.at[p->body].ghost) continue;
        array_push(&g->leader, (uint32_t)g->places.count);
        array_push(&g->places, p);
        array_push(&g->spans, span_of(p, end_of(p)));
        array_push(&g->acts, !p->under_way && (p->next.at || p->asked));
        array_push(&g->waits, p->under_way);
    }
}

static void join_groups(world *w, groups *g)
{
    for (uint32_t i = 0; i < g->places.count; i++) {
        for (uint32_t k = 0; k < g->places.count && g->acts.at[i]; k++) {
            if (k == i || (k < i && g->acts.at[k])) continue; /* it was looked at from there */
            if (!ask_pair(w, NULL, i, k, g->places.at[i], g->places.at[k], &g->spans.at[i], &g->spans.at[k])) continue;
            uint32_t x = leader_of(g, i), y = leader_of(g, k), least = x < y ? x : y, most = x < y ? y : x;
            g->leader.at[most] = least;
        }
    }
}

static void begin_group(world *w, groups *g, uint32_t leader)
{
    soft_job *j = soft_job_create(w);
    ARRAY(uint32_t) members = {0};
    for (uint32_t i = 0; i < g->places.count; i++)
        if (leader_of(g, i) == leader) array_push(&members, i);
    for (uint32_t i = 0; i < members.count; i++) {
        soft_place *p = g->places.at[members.at[i]];
        p->under_way = true;
        p->asked = false;
        array_push(&j->places, p);
        j->units += REFIT_A_VERTEX * p->count;
    }
    soft_job_place(j);
    for (uint32_t i = 0; i < members.count; i++)
        for (uint32_t k = i; k < members.count; k++) {
            uint32_t x = members.at[i], y = members.at[k];
            if (g->acts.at[x] || g->acts.at[y])
                ask_pair(w, j, i, k, g->places.at[x], g->places.at[y], &g->spans.at[x], &g->spans.at[y]);
        }
    finish_asks(j);
    array_free(&members);
}

static void begin_groups(world *w)
{
    groups g = {0};
    gather_places(w, &g);
    join_groups(w, &g);
    for (uint32_t i = 0; i < g.places.count; i++) { /* a group that touches a step under way waits for it */
        uint32_t leader = leader_of(&g, i);
        g.waits.at[leader] |= g.waits.at[i];
        g.acts.at[leader] |= (uint8_t)(g.acts.at[i] << 1);
    }
    for (uint32_t i = 0; i < g.places.count; i++)
        if (leader_of(&g, i) == i && g.acts.at[i] && !g.waits.at[i]) {
            for (uint32_t k = 0; k < g.places.count; k++) g.acts.at[k] &= 1;
            begin_group(w, &g, i);
        }
    array_free(&g.places), array_free(&g.spans), array_free(&g.leader), array_free(&g.acts), array_free(&g.waits);
}

/* A proposal moves its body alone, on a copy. */
static void begin_proposals(world *w)
{
    for (size_t i = 0; i < w->soft->places.count; i++) {
        soft_place *p = w->soft->places.at[i];
        if (!p || p->under_way || !p->proposal_count) continue;
        soft_job *j = soft_job_create(w);
        j->proposed = true;
        j->proposal = p->proposals[0];
        memmove(p->proposals, p->proposals + 1, --p->proposal_count * sizeof *p->proposals);
        span own = span_of(p, j->proposal.at);
        array_push(&j->places, p);
        ask_pair(w, j, 0, 0, p, p, &own, &own);
        for (size_t k = 0; k < w->soft->places.count; k++) {
            soft_place *q = w->soft->places.at[k];
            if (!q || q == p || q->under_way || w->bodies.at[q->body].ghost) continue;
            span others = span_of(q, q->at);
            uint32_t at = (uint32_t)j->places.count;
            if (!ask_pair(w, j, 0, at, p, q, &own, &others)) continue;
            array_push(&j->places, q);
        }
        soft_job_place(j);
        for (size_t k = 0; k < j->places.count; k++) j->places.at[k]->under_way = true;
        finish_asks(j);
    }
}

/* ---- how far they go ---- */

static int64_t frame_of(const soft_job *j, uint32_t k)
{
    const soft_place *p = j->places.at[k];
    if (j->proposed) return k == 0 ? j->proposal.frame : p->frame;
    return p->next.at ? p->next.frame : p->frame;
}

/* The safe step of one pair, from its contacts; with left out ones, that of the whole step. */
static void find_safe_step(soft_result *r, const soft_job *j, const soft_asked *a)
{
    double lo, hi;
    soft_step_safe(j->step, &lo, &hi);
    bool none = r->tally.vertex_face + r->tally.edge_edge == 0;
    if (a->want == SOFT_SAFE_STEP || a->pairs.count == 1 || r->tally.left_out || r->unfinished) {
        r->safe_lo = lo, r->safe_hi = a->pairs.count == 1 || hi == INFINITY ? hi : 2;
    } else {
        r->safe_lo = none ? 1 : 2, r->safe_hi = none ? INFINITY : 2;
    }
    for (size_t i = 0; i < r->count; i++) {
        const soft_contact *c = &r->contacts[i];
        if (r->safe_lo > (double)c->t_lo) r->safe_lo = (double)c->t_lo;
        if (c->proof == SOFT_CERTAIN && (double)c->t_hi < r->safe_hi) r->safe_hi = (double)c->t_hi;
    }
    if (r->safe_lo > 1) r->safe_lo = 0;
}

/* The first of its contacts that are kept. */
static void find_first(soft_result *r, const soft_mesh *a, soft_positions x)
{
    const soft_contact *first = NULL;
    size_t which = 0;
    for (size_t i = 0; i < r->count; i++)
        if (!first || r->contacts[i].t_lo < first->t_lo) first = &r->contacts[i], which = i;
    if (!first) return;
    uint32_t at[3] = {first->a, 0, 0};
    if (first->kind == SOFT_EDGE_EDGE) soft_mesh_edge(a, first->a, at);
    if (first->kind == SOFT_FACE_VERTEX) soft_mesh_triangle(a, first->a, at);
    const float *n = r->touches[which].normal;
    r->has_first = true;
    r->first_lo = (double)first->t_lo, r->first_hi = (double)first->t_hi;
    r->first_point = vec_madd(x.from[at[0]], r->first_lo, vec_sub(x.to[at[0]], x.from[at[0]]));
    r->first_normal = vec((double)n[0], (double)n[1], (double)n[2]);
}

void soft_take_results(soft_job *j, bool unfinished)
{
    const soft_asked *a = &j->asks.at[j->ask];
    size_t count, next = 0;
    const soft_contact *all = soft_step_contacts(j->step, &count);
    const soft_tally *tallies = soft_step_tallies(j->step);
    for (uint32_t k = 0; k < a->pairs.count; k++) {
        soft_pair of = a->pairs.at[k];
        const soft_place *p = j->places.at[of.a], *q = j->places.at[of.b];
        soft_result r = {.a = p->collider,
            .b = of.a == of.b ? p->shadow : q->collider,
            .separation = a->separation,
            .proposed = j->proposed,
            .unfinished = unfinished,
            .frame_a = frame_of(j, of.a),
            .frame_b = frame_of(j, of.b),
            .tally = tallies[k]};
        r.key = pair_key(r.a, r.b);
        size_t from = next;
        while (next < count && all[next].pair == k) next++;
        r.count = unfinished ? 0 : next - from;
        r.contacts = base_alloc(r.count + 1, sizeof *r.contacts);
        if (r.count) memcpy(r.contacts, all + from, r.count * sizeof *all);
        if (unfinished) r.tally.left_out = r.tally.vertex_face + r.tally.edge_edge;
        soft_find_touches(&r, p->mesh, way_of(j, of.a), q->mesh, way_of(j, of.b));
        find_safe_step(&r, j, a);
        find_first(&r, p->mesh, way_of(j, of.a));
        array_push(&j->results, r);
    }
}

static void run_step(soft_job *j, uint64_t *units, soft_status *status)
{
    uint64_t before = soft_step_units(j->step);
    *status = soft_step_run(j->step, *units == UINT64_MAX ? 0 : *units);
    uint64_t spent = soft_step_units(j->step) - before;
    j->units += spent;
    if (*units != UINT64_MAX) *units = spent < *units ? *units - spent : 0;
}

soft_step_def soft_job_step(const world *w, const soft_job *j)
{
    const soft_asked *a = &j->asks.at[j->ask];
    return (soft_step_def){.bodies = j->bodies.at,
        .body_count = j->bodies.count,
        .pairs = a->pairs.at,
        .pair_count = a->pairs.count,
        .separation = a->separation,
        .want = a->want,
        .contacts_max = a->most,
        .without = w->options.caches ? 0 : SOFT_WITHOUT_DIRECTIONS | SOFT_WITHOUT_STARS};
}

/* False: the units are used up. */
static bool run_job(world *w, soft_job *j, uint64_t *units)
{
    for (; j->ask < j->asks.count; j->ask++, j->begun = false) {
        const soft_step_def def = soft_job_step(w, j);
        if (!j->begun && soft_step_begin(j->step, &def) != SOFT_OK) continue;
        j->begun = true;
        soft_status status = SOFT_MORE;
        while (status == SOFT_MORE && j->units <= JOB_UNITS_MOST) {
            if (!*units) return false;
            run_step(j, units, &status);
        }
        w->figures.soft_unfinished += status == SOFT_MORE;
        soft_take_results(j, status == SOFT_MORE);
    }
    return true;
}

static void end_job(world *w, soft_job *j)
{
    for (size_t i = 0; i < j->results.count; i++) {
        j->results.at[i].tick = w->figures.ticks;
        array_push(&w->soft->results, j->results.at[i]);
    }
    j->results.count = 0;
    for (size_t i = 0; i < j->places.count; i++) {
        soft_place *p = j->places.at[i];
        p->under_way = false;
        if (j->proposed) continue;
        if (p->next.at)
            soft_arrive(w, p);
        else
            body_mark_dirty(w, p->body, false); /* what was found is reported to its pairs */
    }
    w->figures.soft_steps++;
    if (j->proposed) soft_rigid_proposal(w, j->places.at[0], &j->proposal);
}

void soft_go_on(world *w)
{
    soft_results_clear(w);
    if (!soft_is_busy(w)) return;
    w->sliced |= w->soft->jobs.count > 0;
    uint64_t part = w->slice / PART / A_UNIT, units = part < UNITS_AT_LEAST ? UNITS_AT_LEAST : part;
    if (w->slice == UINT64_MAX) units = UINT64_MAX;
    begin_proposals(w);
    begin_groups(w);
    size_t kept = 0;
    for (size_t i = 0; i < w->soft->jobs.count; i++) {
        soft_job *j = w->soft->jobs.at[i];
        if (run_job(w, j, &units)) {
            end_job(w, j);
            free_job(j);
        } else {
            w->soft->jobs.at[kept++] = j;
        }
    }
    w->soft->jobs.count = kept;
    w->sliced |= kept > 0;
    w->figures.soft_bodies = w->soft->count;
    w->figures.soft_waiting = 0;
    for (size_t i = 0; i < w->soft->places.count; i++) {
        const soft_place *p = w->soft->places.at[i];
        w->figures.soft_waiting += p && (p->under_way || p->next.at || p->asked || p->proposal_count);
    }
}
