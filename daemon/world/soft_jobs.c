/* soft_jobs: steps of soft bodies, over as many ticks as they take. Tick thread; the pool inside of portions.
 *
 * Before a tick looks at pairs, bodies with a frame that waits are put together with those that they may meet on the
 * way; what meets nobody else is a job of its own, so that nobody waits for strangers. A job is worked off in portions
 * of some milliseconds at most; jobs take turns by what their owners have taken of late, so that one owner's crumpled
 * cloth does not keep another's calm one waiting. When a job is done its bodies are where their frames say, as one, and
 * its results are this tick's. Pairs of a soft and a rigid shape (soft_rigid.c) that a tick asks for are jobs, too, and
 * their bodies stay where they are until these are done.
 *
 * Which jobs there are, what they are asked, in what turns they go on and when they end follows from commands and
 * counts, and so do all results. */
#include "soft_state.h"
#include "subscription.h"

#include <stdlib.h>

enum {
    PART = 4,    /* of a slice, at most, before pairs are looked at, and as much when they are */
    A_UNIT = 10, /* of soft.h, in those of a slice */
    UNITS_AT_LEAST = 100000,
    REFIT_A_VERTEX = 12, /* units, with all that goes by vertices when a step begins */
    A_CHECK = 2,         /* of one subscription, about one pair */
    A_CONTACT = 8,       /* to be described */
    CHECKS_A_TICK = 300000
};
static const uint64_t JOB_UNITS_MOST = 100000000; /* a second: beyond, what is left is reported as unfinished */

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
    array_free(&j->asks), array_free(&j->places), array_free(&j->bodies), array_free(&j->acts);
    soft_rigid_drop(j->task);
    array_free(&j->besides);
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
    array_free(&w->soft->jobs), array_free(&w->soft->accounts);
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
        for (size_t k = 0; k < j->places.count && !j->stands; k++) {
            j->places.at[k]->under_way = false;
            j->places.at[k]->asked |= !j->proposed;
        }
        free_job(j);
    }
    w->soft->jobs.count = kept;
}

bool soft_is_busy(const world *w)
{
    if (w->soft->jobs.count) return true;
    for (size_t i = 0; i < w->soft->results.count; i++)
        if (!w->soft->results.at[i].is_told) return true;
    for (size_t i = 0; i < w->soft->places.count; i++) {
        const soft_place *p = w->soft->places.at[i];
        if (p && (p->next.at || p->asked || p->proposal_count)) return true;
    }
    return false;
}

static uint64_t owner_of_collider(const world *w, uint32_t id)
{
    return w->bodies.at[w->colliders.at[id].body].owner;
}

size_t soft_waiting_of(const world *w, uint64_t owner)
{
    size_t waiting = 0;
    for (size_t i = 0; i < w->soft->places.count; i++) {
        const soft_place *p = w->soft->places.at[i];
        bool acts = p && (p->next.at || p->asked || p->under_way || p->beside || p->proposal_count);
        waiting += acts && w->bodies.at[p->body].owner == owner;
    }
    for (size_t i = 0; i < w->soft->results.count; i++) /* that not everybody has been told yet */
        waiting += !w->soft->results.at[i].is_told && owner_of_collider(w, w->soft->results.at[i].a) == owner;
    return waiting;
}

/* ---- who is in it ---- */

static const soft_frame *end_of(const soft_place *p)
{
    return p->next.at ? &p->next : NULL;
}

static aabb way_box(const soft_place *p, const soft_frame *to)
{
    return to ? (aabb){vec_min(p->box.lo, to->box.lo), vec_max(p->box.hi, to->box.hi)} : p->box;
}

static bool meet(const aabb *a, const aabb *b, double within)
{
    return aabb_overlap(aabb_grow(*a, within), *b);
}

static double reach_of(const soft_place *p, const soft_place *q, const aabb *x, double separation)
{
    double within = (separation + p->half_thickness + q->half_thickness) * (1 + 0x1p-40);
    return within + 0x1p-40 * fmax(vec_max_abs(x->hi), vec_max_abs(x->lo));
}

/* The most that any subscription, or rule of the bodies, asks for. */
static double widest_of(const world *w, const soft_place *p)
{
    double widest = 0;
    for (size_t i = 0; i < w->subscriptions.count; i++)
        if (w->subscriptions.at[i].used) widest = fmax(widest, w->subscriptions.at[i].threshold);
    return widest + w->bodies.at[p->body].rule_reach;
}

static soft_want want_of(const subscription *i)
{
    if (!(i->facts & ~(unsigned)WORLD_SAFE_STEP)) return SOFT_SAFE_STEP;
    bool verdict = i->accuracy == WORLD_BY_VERDICT || !(i->facts & (WORLD_FEATURES | WORLD_SAFE_STEP));
    return verdict ? SOFT_VERDICTS : SOFT_BRACKETS;
}

size_t soft_most_of(const subscription *i)
{
    return !(i->facts & WORLD_FEATURES) || !i->soft_each ? 1 : i->soft_most ? i->soft_most : SOFT_CONTACTS_MOST;
}

static void add_ask(soft_job *j, const subscription *i, double separation, soft_pair pair)
{
    soft_want want = want_of(i);
    size_t most = soft_most_of(i);
    size_t k = 0;
    while (k < j->asks.count && j->asks.at[k].separation != separation) k++;
    if (k == j->asks.count) array_push(&j->asks, ((soft_asked){.separation = separation, .want = want, .most = most}));
    soft_asked *to = &j->asks.at[k];
    bool brackets = to->want == SOFT_BRACKETS || want == SOFT_BRACKETS || to->want != want;
    to->want = brackets ? SOFT_BRACKETS : want;
    if (most > to->most) to->most = most;
    const soft_pair *last = to->pairs.count ? &to->pairs.at[to->pairs.count - 1] : NULL;
    if (!last || last->a != pair.a || last->b != pair.b) array_push(&to->pairs, pair);
}

typedef struct either { /* of a pair: its place in the job, and the box of its way */
    uint32_t at;
    const soft_place *place;
    aabb way;
} either;

/* Adds the pair to what is asked, for each separation that somebody wants of it; without a job: is it wanted by
 * anybody? *checks: how many subscriptions have been looked at. */
static bool ask_pair(const world *w, soft_job *j, const either *x, const either *y, uint64_t *checks)
{
    const soft_place *p = x->place, *q = y->place;
    const body *one = &w->bodies.at[p->body], *other = &w->bodies.at[q->body];
    bool any = false,
         in_order = p == q || colliders_in_order(w, &w->colliders.at[p->collider], &w->colliders.at[q->collider]);
    if (p != q && one->fixed && other->fixed) return false;
    pair_terms terms = pair_get_terms(w, one, other);
    for (uint32_t id = 0; terms.checked && id < w->subscriptions.count; id++, (*checks)++) {
        if (!soft_is_wanted(w, id, one, other)) continue;
        const subscription *i = &w->subscriptions.at[id];
        double separation = soft_separation(i, terms.padding);
        if (p != q && !meet(&x->way, &y->way, reach_of(p, q, &x->way, separation))) continue;
        any = true;
        if (!j) return true;
        add_ask(j, i, separation, in_order ? (soft_pair){x->at, y->at} : (soft_pair){y->at, x->at});
    }
    return any;
}

/* Contacts of a step are limited as a whole: of a wish per pair there is room for each. */
static void finish_asks(soft_job *j)
{
    for (size_t k = 0; k < j->asks.count; k++) {
        soft_asked *a = &j->asks.at[k];
        a->most = a->most < SOFT_CONTACTS_MOST / (a->pairs.count + 1) ? a->most * a->pairs.count : SOFT_CONTACTS_MOST;
    }
}

soft_job *soft_job_create(world *w)
{
    soft_job *j = base_zalloc(1, sizeof *j);
    array_push(&w->soft->jobs, j);
    return j;
}

static soft_positions way_of(const soft_job *j, uint32_t k)
{
    const soft_place *p = j->places.at[k];
    if (j->proposed) return (soft_positions){p->at, k == 0 ? j->proposal.at : p->at};
    const vec3 *end = p->next.at ? p->next.at : p->at;
    return (soft_positions){p->next.teleports ? end : p->at, end};
}

void soft_job_place(soft_job *j, uint32_t i)
{
    soft_place *p = j->places.at[i];
    soft_body *b = p->engine;
    if (j->proposed && i == 0) {
        b = j->proposed_body = soft_body_create(p->mesh);
        soft_body_set_thickness(b, p->half_thickness);
    }
    soft_positions way = way_of(j, i);
    j->broken |= soft_body_set(b, way.from, way.to) != SOFT_OK;
    array_push(&j->bodies, b);
}

/* ---- which jobs ---- */

typedef struct groups { /* of the places that have something to do, and whom they may meet */
    ARRAY(soft_place *) places;
    ARRAY(aabb) ways;
    ARRAY(uint32_t) leader;
    ARRAY(uint8_t) acts, waits;
    uint64_t checks;
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
        array_push(&g->ways, way_box(p, end_of(p)));
        array_push(&g->acts, !p->under_way && !p->untold && (p->next.at || p->asked));
        array_push(&g->waits, p->under_way || p->untold);
    }
}

/* Where finding out who wants a pair takes too long, it is put together, too: that costs time, and no answer. */
static bool are_together(const world *w, groups *g, uint32_t i, uint32_t k, double widest)
{
    const soft_place *p = g->places.at[i], *q = g->places.at[k];
    if (!meet(&g->ways.at[i], &g->ways.at[k], reach_of(p, q, &g->ways.at[i], widest))) return false;
    const either x = {i, p, g->ways.at[i]}, y = {k, q, g->ways.at[k]};
    return g->checks > CHECKS_A_TICK || ask_pair(w, NULL, &x, &y, &g->checks);
}

static void join_groups(const world *w, groups *g)
{
    for (uint32_t i = 0; i < g->places.count; i++) {
        if (!g->acts.at[i]) continue;
        double widest = widest_of(w, g->places.at[i]);
        for (uint32_t k = 0; k < g->places.count; k++) {
            if (k == i || (k < i && g->acts.at[k])) continue; /* it was looked at from there */
            if (!are_together(w, g, i, k, widest + w->bodies.at[g->places.at[k]->body].rule_reach)) continue;
            uint32_t x = leader_of(g, i), y = leader_of(g, k), least = x < y ? x : y, most = x < y ? y : x;
            g->leader.at[most] = least;
        }
    }
}

static void begin_group(world *w, groups *g, uint32_t leader)
{
    soft_job *j = soft_job_create(w);
    for (uint32_t i = 0; i < g->places.count; i++) {
        soft_place *p = g->places.at[i];
        if (leader_of(g, i) != leader) continue;
        array_push(&j->places, p);
        array_push(&j->acts, (uint8_t)(!p->under_way && (p->next.at || p->asked)));
        p->under_way = true;
        p->asked = false;
    }
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
        if (leader_of(&g, i) == i && g.acts.at[i] && !g.waits.at[i]) begin_group(w, &g, i);
    array_free(&g.places), array_free(&g.ways), array_free(&g.leader), array_free(&g.acts), array_free(&g.waits);
}

/* The place of every other one that somebody wants to know about, if none of them is under way: false. */
static bool gather_partners(const world *w, soft_job *j, const either *own, uint64_t *checks)
{
    const soft_place *p = own->place;
    double widest = widest_of(w, p);
    ask_pair(w, j, own, own, checks);
    for (size_t k = 0; k < w->soft->places.count; k++) {
        soft_place *q = w->soft->places.at[k];
        if (!q || q == p || w->bodies.at[q->body].ghost) continue;
        const either other = {(uint32_t)j->places.count, q, q->box};
        if (!meet(&own->way, &q->box, reach_of(p, q, &own->way, widest + w->bodies.at[q->body].rule_reach))) continue;
        if (!ask_pair(w, j, own, &other, checks)) continue;
        if (q->under_way) return false;
        array_push(&j->places, q);
    }
    return true;
}

/* A proposal moves its body alone, on a copy. It waits for those that it may meet, while they are under way. */
static void begin_proposals(world *w)
{
    uint64_t checks = 0;
    for (size_t i = 0; i < w->soft->places.count && checks <= CHECKS_A_TICK; i++) {
        soft_place *p = w->soft->places.at[i];
        if (!p || p->under_way || p->untold || !p->proposal_count) continue;
        soft_job *j = soft_job_create(w);
        const either own = {0, p, way_box(p, &p->proposals[0])};
        array_push(&j->places, p);
        if (!gather_partners(w, j, &own, &checks)) {
            w->soft->jobs.count--;
            free_job(j);
            continue;
        }
        j->proposed = true;
        j->proposal = p->proposals[0];
        memmove(p->proposals, p->proposals + 1, --p->proposal_count * sizeof *p->proposals);
        for (size_t k = 0; k < j->places.count; k++) j->places.at[k]->under_way = true;
        finish_asks(j);
    }
}

/* ---- what they come to ---- */

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

static void take_pair(soft_job *j, uint32_t k, size_t *next)
{
    const soft_asked *a = &j->asks.at[j->ask];
    size_t count = 0;
    bool none = j->broken, unfinished = j->unfinished;
    const soft_contact *all = none ? NULL : soft_step_contacts(j->step, &count);
    soft_pair of = a->pairs.at[k];
    const soft_place *p = j->places.at[of.a], *q = j->places.at[of.b];
    soft_result r = {.a = p->collider,
        .b = of.a == of.b ? p->shadow : q->collider,
        .separation = a->separation,
        .proposed = j->proposed,
        .unfinished = unfinished,
        .frame_a = frame_of(j, of.a),
        .frame_b = frame_of(j, of.b)};
    if (!none) r.tally = soft_step_tallies(j->step)[k];
    r.key = pair_key(r.a, r.b);
    size_t from = *next;
    while (*next < count && all[*next].pair == k) ++*next;
    r.count = unfinished ? 0 : *next - from;
    r.contacts = base_alloc(r.count + 1, sizeof *r.contacts);
    if (r.count) memcpy(r.contacts, all + from, r.count * sizeof *all);
    if (unfinished) r.tally.left_out = r.tally.vertex_face + r.tally.edge_edge;
    soft_find_touches(&r, p->mesh, way_of(j, of.a), q->mesh, way_of(j, of.b));
    if (none)
        r.safe_lo = 0, r.safe_hi = 2;
    else
        find_safe_step(&r, j, a);
    find_first(&r, p->mesh, way_of(j, of.a));
    soft_result_hash(&r);
    array_push(&j->results, r);
}

static uint64_t take_results(soft_job *j)
{
    size_t next = 0, before = j->results.count, contacts = 0;
    for (uint32_t k = 0; k < j->asks.at[j->ask].pairs.count; k++) take_pair(j, k, &next);
    for (size_t i = before; i < j->results.count; i++) contacts += j->results.at[i].count;
    return A_CONTACT * (contacts + j->results.count - before);
}

/* ---- how far they go ---- */

/* Its layers of culling are no caches: nothing is kept from step to step. Without one of them a step would take other
 * units, and so other ticks. */
static soft_step_def terms_of_step(const soft_job *j)
{
    const soft_asked *a = &j->asks.at[j->ask];
    return (soft_step_def){.bodies = j->bodies.at,
        .body_count = j->bodies.count,
        .pairs = a->pairs.at,
        .pair_count = a->pairs.count,
        .separation = a->separation,
        .want = a->want,
        .contacts_max = a->most};
}

static uint64_t place_next(soft_job *j)
{
    uint64_t units = REFIT_A_VERTEX * j->places.at[j->placed]->count;
    soft_job_place(j, (uint32_t)j->placed);
    if (++j->placed == j->places.count) j->stage = j->acts.count ? SOFT_ASKING : SOFT_STEPPING;
    return units;
}

/* One with all behind it. */
static uint64_t ask_next(const world *w, soft_job *j)
{
    uint64_t checks = 0;
    uint32_t i = (uint32_t)j->asking;
    const soft_place *p = j->places.at[i];
    const either x = {i, p, way_box(p, end_of(p))};
    double widest = widest_of(w, p);
    for (uint32_t k = i; k < j->places.count; k++) {
        const soft_place *q = j->places.at[k];
        const either y = {k, q, way_box(q, end_of(q))};
        double within = reach_of(p, q, &x.way, widest + w->bodies.at[q->body].rule_reach);
        if ((j->acts.at[i] || j->acts.at[k]) && (k == i || meet(&x.way, &y.way, within)))
            ask_pair(w, j, &x, &y, &checks);
    }
    if (++j->asking == j->places.count) {
        finish_asks(j);
        j->stage = SOFT_STEPPING;
    }
    return A_CHECK * checks + j->places.count;
}

/* Of a proposal also what it would meet of rigid shapes, as they stand. */
static void go_beside(world *w, soft_job *j)
{
    if (j->proposed && !j->gathered) soft_rigid_gather(w, j);
    j->gathered = true;
    j->stage = SOFT_BESIDE;
}

static uint64_t step_on(world *w, soft_job *j)
{
    if (j->ask == j->asks.count) {
        go_beside(w, j);
        return 1;
    }
    if (!j->begun) {
        const soft_step_def def = terms_of_step(j);
        uint64_t units = 0;
        if (!j->step) j->step = soft_step_create(w->workers);
        j->begun = true;
        j->unfinished = j->broken = j->broken || soft_step_begin(j->step, &def) != SOFT_OK;
        for (size_t i = 0; i < j->places.count; i++) units += j->places.at[i]->count / 4;
        if (j->broken) j->stage = SOFT_TAKING;
        return units + j->asks.at[j->ask].pairs.count;
    }
    uint64_t before = soft_step_units(j->step);
    soft_status status = soft_step_run(j->step, 1);
    uint64_t spent = soft_step_units(j->step) - before;
    j->unfinished = status == SOFT_MORE && j->units + spent > JOB_UNITS_MOST;
    if (status != SOFT_MORE || j->unfinished) j->stage = SOFT_TAKING;
    return spent;
}

static uint64_t take_on(world *w, soft_job *j)
{
    w->figures.soft_unfinished += j->unfinished;
    uint64_t units = take_results(j);
    j->ask++;
    j->begun = j->unfinished = false;
    j->stage = SOFT_STEPPING;
    return units;
}

uint64_t soft_job_portion(world *w, soft_job *j)
{
    uint64_t units = 0;
    if (j->stage > SOFT_ASKING && !j->portions++) j->units_before = j->units;
    switch (j->stage) {
    case SOFT_PLACING:
        units = place_next(j);
        break;
    case SOFT_ASKING:
        units = ask_next(w, j);
        break;
    case SOFT_STEPPING:
        units = step_on(w, j);
        break;
    case SOFT_TAKING:
        units = take_on(w, j);
        break;
    default:
        units = soft_rigid_portion(w, j, j->units > JOB_UNITS_MOST);
    }
    j->units += units;
    return units;
}

static void end_job(world *w, soft_job *j)
{
    for (size_t i = 0; i < j->results.count; i++) {
        j->results.at[i].tick = w->figures.ticks;
        soft_result_add(w, &j->results.at[i]);
    }
    j->results.count = 0;
    for (size_t i = 0; i < j->places.count; i++) {
        soft_place *p = j->places.at[i];
        if (j->stands)
            p->beside = NULL;
        else
            p->under_way = false;
        if (j->proposed) continue;
        if (p->next.at && !j->stands)
            soft_arrive(w, p);
        else if (!j->fresh)
            body_mark_dirty(w, p->body, false); /* what was found is reported to its pairs */
    }
    w->figures.soft_steps += !j->stands;
}

/* Its bodies stay where they are as long as it is found out what they meet there. */
static bool may_end(const soft_job *j)
{
    for (size_t i = 0; i < j->places.count && !j->stands; i++)
        if (j->places.at[i]->beside) return false;
    return true;
}

/* ---- turns ---- */

static uint64_t owner_of_job(const world *w, const soft_job *j)
{
    return w->bodies.at[j->places.at[0]->body].owner;
}

/* What he has taken since he last had nothing to do. Who comes begins with what he has who has taken least. */
static soft_account *account_of(world *w, uint64_t owner)
{
    uint64_t least = UINT64_MAX;
    for (size_t i = 0; i < w->soft->accounts.count; i++) {
        if (w->soft->accounts.at[i].owner == owner) return &w->soft->accounts.at[i];
        if (w->soft->accounts.at[i].units < least) least = w->soft->accounts.at[i].units;
    }
    array_push(&w->soft->accounts, ((soft_account){owner, least == UINT64_MAX ? 0 : least}));
    return &w->soft->accounts.at[w->soft->accounts.count - 1];
}

static void close_accounts(world *w)
{
    size_t kept = 0;
    for (size_t i = 0; i < w->soft->accounts.count; i++) {
        bool has = false;
        for (size_t k = 0; k < w->soft->jobs.count && !has; k++)
            has = owner_of_job(w, w->soft->jobs.at[k]) == w->soft->accounts.at[i].owner;
        if (has) w->soft->accounts.at[kept++] = w->soft->accounts.at[i];
    }
    w->soft->accounts.count = kept;
}

/* Of the owner who has taken least, the one that has taken least itself. */
static soft_job *next_job(world *w, bool fresh)
{
    soft_job *best = NULL;
    uint64_t least = UINT64_MAX;
    for (size_t i = 0; i < w->soft->jobs.count; i++) {
        soft_job *j = w->soft->jobs.at[i];
        if (j->stage == SOFT_DONE || j->fresh != fresh) continue; /* it waits */
        uint64_t units = account_of(w, owner_of_job(w, j))->units;
        if (!best || units < least || (units == least && j->units < best->units)) best = j, least = units;
    }
    return best;
}

static void end_jobs(world *w, bool fresh)
{
    for (size_t i = 0; i < w->soft->jobs.count;) {
        soft_job *j = w->soft->jobs.at[i];
        if (j->stage != SOFT_DONE || j->fresh != fresh || !may_end(j)) {
            i++;
            continue;
        }
        end_job(w, j);
        free_job(j);
        w->soft->jobs.count--;
        memmove(w->soft->jobs.at + i, w->soft->jobs.at + i + 1, (w->soft->jobs.count - i) * sizeof j);
        i = 0; /* another one may have waited for this one */
    }
}

/* Bodies arrive before a tick looks at pairs: when it does, nothing goes on but what it has begun there. */
static void run_jobs(world *w, bool fresh)
{
    uint64_t part = w->slice / PART / A_UNIT, spent = 0;
    if (part < UNITS_AT_LEAST) part = UNITS_AT_LEAST;
    for (end_jobs(w, fresh); w->slice == UINT64_MAX || spent < part; end_jobs(w, fresh)) {
        soft_job *j = next_job(w, fresh);
        if (!j) break;
        soft_account *paid = account_of(w, owner_of_job(w, j));
        uint64_t units = soft_job_portion(w, j);
        spent += units + 1;
        paid->units += units + 1;
    }
    close_accounts(w);
    w->sliced |= w->soft->jobs.count > 0;
}

static void count_waiting(world *w)
{
    w->figures.soft_bodies = w->soft->count;
    w->figures.soft_waiting = 0;
    for (size_t i = 0; i < w->soft->places.count; i++) {
        const soft_place *p = w->soft->places.at[i];
        w->figures.soft_waiting += p && (p->under_way || p->next.at || p->asked || p->proposal_count);
    }
}

void soft_go_on(world *w)
{
    soft_results_clear(w);
    if (!soft_is_busy(w)) return;
    for (size_t i = 0; i < w->soft->jobs.count; i++) w->soft->jobs.at[i]->fresh = false;
    w->sliced |= w->soft->jobs.count > 0;
    begin_proposals(w);
    begin_groups(w);
    run_jobs(w, false);
    count_waiting(w);
}

void soft_go_beside(world *w)
{
    if (!w->soft->jobs.count) return;
    run_jobs(w, true);
    count_waiting(w);
}
