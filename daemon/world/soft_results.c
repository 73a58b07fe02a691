/* soft_results: what steps of soft bodies came to: for the events of their pairs, and for who asks for features and
 * safe steps. Tick thread. */
#include "events.h"
#include "soft_state.h"
#include "subscription.h"

#include "base/hash.h"

#include <stdlib.h>

static bool waits(const world *w, const soft_result *r)
{
    if (r->proposed || r->only_told) return false;
    const body *x = &w->bodies.at[w->colliders.at[r->a].body], *y = &w->bodies.at[w->colliders.at[r->b].body];
    uint32_t pair = pair_find(w, r->a, r->b);
    return x->is_due || y->is_due || (pair != PAIR_MAP_NONE && pair_is_pending(w, &w->pairs.at[pair]));
}

static void note_newest(world *w, size_t i)
{
    soft_result *r = &w->soft->results.at[i];
    uint32_t newest = pair_map_get(&w->soft->result_of, r->key);
    r->older = newest == PAIR_MAP_NONE ? 0 : newest + 1;
    pair_map_put(&w->soft->result_of, r->key, (uint32_t)i);
}

void soft_result_add(world *w, const soft_result *r)
{
    array_push(&w->soft->results, *r);
    note_newest(w, w->soft->results.count - 1);
    w->soft->indexed = true;
}

/* Of one pair they stand in the order of ticks. */
static void index_results(world *w)
{
    if (!w->soft->results.count && !w->soft->indexed) return; /* nobody has been told anything */
    w->soft->indexed = w->soft->results.count > 0;
    pair_map_free(&w->soft->result_of);
    pair_map_init(&w->soft->result_of);
    for (size_t i = 0; i < w->soft->places.count; i++)
        if (w->soft->places.at[i]) w->soft->places.at[i]->untold = false;
    for (size_t i = 0; i < w->soft->results.count; i++) {
        const soft_result *r = &w->soft->results.at[i];
        note_newest(w, i);
        for (int k = 0; k < 2 && !r->is_told; k++) {
            soft_place *p = soft_place_of(w, &w->bodies.at[w->colliders.at[k ? r->b : r->a].body]);
            if (p) p->untold = true;
        }
    }
}

static soft_result *newest_result(const world *w, uint64_t key)
{
    uint32_t i = w->soft->results.count ? pair_map_get(&w->soft->result_of, key) : PAIR_MAP_NONE;
    return i == PAIR_MAP_NONE ? NULL : &w->soft->results.at[i];
}

static soft_result *older_than(const world *w, const soft_result *r)
{
    return r->older ? &w->soft->results.at[r->older - 1] : NULL;
}

/* A tick begins. */
void soft_results_clear(world *w)
{
    size_t kept = 0;
    for (size_t i = 0; i < w->soft->results.count; i++) {
        soft_result *r = &w->soft->results.at[i];
        bool ghost = w->colliders.at[r->a].ghost || w->colliders.at[r->b].ghost, pair = !ghost && waits(w, r);
        r->only_told = !pair;
        if (pair || (!ghost && !r->is_told)) {
            w->soft->results.at[kept++] = *r;
            continue;
        }
        free(r->contacts);
        free(r->touches);
    }
    w->soft->results.count = kept;
    w->soft->told.count = w->soft->batch.count = 0;
    index_results(w);
}

void soft_results_free(world *w)
{
    for (size_t i = 0; i < w->soft->results.count; i++)
        free(w->soft->results.at[i].contacts), free(w->soft->results.at[i].touches);
    pair_map_free(&w->soft->result_of);
    array_free(&w->soft->results), array_free(&w->soft->told), array_free(&w->soft->batch);
}

/* ---- where features meet ---- */

static vec3 at_time(soft_positions p, uint32_t v, double t)
{
    return vec_madd(p.from[v], t, vec_sub(p.to[v], p.from[v]));
}

static void set_touch(struct soft_touch *to, vec3 normal, double u, double v)
{
    double norm = vec_norm(normal);
    vec3 n = norm > 0 ? vec_scale(normal, 1 / norm) : vec(0, 0, 1);
    to->normal[0] = (float)n.x, to->normal[1] = (float)n.y, to->normal[2] = (float)n.z;
    to->bary[0] = (float)fmin(fmax(u, 0), 1), to->bary[1] = (float)fmin(fmax(v, 0), 1);
}

/* From the vertex to the face; along the face's normal where the two are as good as in one plane. */
static void touch_vertex_face(vec3 p, const vec3 c[3], double sign, struct soft_touch *to)
{
    vec3 u = vec_sub(c[1], c[0]), v = vec_sub(c[2], c[0]), d = vec_sub(p, c[0]), n = vec_cross(u, v);
    double uu = vec_dot(u, u), uv = vec_dot(u, v), vv = vec_dot(v, v), du = vec_dot(d, u), dv = vec_dot(d, v);
    double det = uu * vv - uv * uv, x = det > 0 ? (vv * du - uv * dv) / det : 0,
           y = det > 0 ? (uu * dv - uv * du) / det : 0;
    double side = vec_dot(n, d) > 0 ? -sign : sign;
    set_touch(to, vec_scale(n, side), x, y);
}

static void touch_edges(const vec3 a[2], const vec3 b[2], struct soft_touch *to)
{
    vec3 u = vec_sub(a[1], a[0]), v = vec_sub(b[1], b[0]), d = vec_sub(b[0], a[0]), n = vec_cross(u, v);
    double uu = vec_dot(u, u), uv = vec_dot(u, v), vv = vec_dot(v, v), du = vec_dot(d, u), dv = vec_dot(d, v);
    double det = uu * vv - uv * uv, x = det > 0 ? (vv * du - uv * dv) / det : 0,
           y = det > 0 ? (uv * du - uu * dv) / det : 0;
    set_touch(to, vec_dot(n, d) < 0 ? vec_neg(n) : n, x, y);
}

void soft_find_touches(soft_result *r, const soft_mesh *a, soft_positions x, const soft_mesh *b, soft_positions y)
{
    r->touches = base_alloc(r->count + 1, sizeof *r->touches);
    for (size_t i = 0; i < r->count; i++) {
        const soft_contact *c = &r->contacts[i];
        double t = (double)c->t_lo;
        uint32_t ids[3];
        vec3 p[2], q[3];
        if (c->kind == SOFT_EDGE_EDGE) {
            soft_mesh_edge(a, c->a, ids);
            for (int k = 0; k < 2; k++) p[k] = at_time(x, ids[k], t);
            soft_mesh_edge(b, c->b, ids);
            for (int k = 0; k < 2; k++) q[k] = at_time(y, ids[k], t);
            touch_edges(p, q, &r->touches[i]);
            continue;
        }
        bool vertex_first = c->kind == SOFT_VERTEX_FACE;
        soft_mesh_triangle(vertex_first ? b : a, vertex_first ? c->b : c->a, ids);
        for (int k = 0; k < 3; k++) q[k] = at_time(vertex_first ? y : x, ids[k], t);
        p[0] = at_time(vertex_first ? x : y, vertex_first ? c->a : c->b, t);
        touch_vertex_face(p[0], q, vertex_first ? 1 : -1, &r->touches[i]);
    }
}

/* ---- for the events ---- */

static soft_result *first_of(const world *w, const pair *p)
{
    soft_result *newest = NULL;
    for (soft_result *r = newest_result(w, pair_key(p->a, p->b)); r; r = older_than(w, r))
        if (!r->proposed && !r->only_told && (!newest || r->tick > newest->tick)) newest = r;
    return newest;
}

bool soft_is_decided(const world *w, const pair *p)
{
    return first_of(w, p) != NULL;
}

static uint64_t contacts_of(const soft_result *r)
{
    return r->tally.vertex_face + r->tally.edge_edge + r->face_shape;
}

bool soft_touches(const world *w, const pair *p, double separation, const soft_result **which)
{
    *which = NULL;
    for (const soft_result *r = newest_result(w, pair_key(p->a, p->b)); r; r = older_than(w, r)) {
        bool is = !r->proposed && !r->only_told && r->separation == fmax(separation, 0);
        if (is && (!*which || r->tick > (*which)->tick)) *which = r;
    }
    return *which && (contacts_of(*which) || (*which)->unfinished || (*which)->safe_lo < 1);
}

/* How far apart they are at the end is not looked at. */
void soft_fill(const world *w, const pair *p, narrow_result *r)
{
    const soft_result *of = first_of(w, p);
    pose a = w->colliders.at[p->a].world;
    *r = (narrow_result){.lo = -INFINITY, .hi = INFINITY, .status = NARROW_WIDE, .method = NARROW_BY_CLOSED_FORM};
    for (const soft_result *i = of ? newest_result(w, of->key) : NULL; i && !of->has_first; i = older_than(w, i))
        if (i->has_first) of = i;
    if (!of || !of->has_first) return;
    r->axis = quat_rotate(quat_conj(a.q), of->first_normal);
    r->point_a = r->point_b = pose_point(pose_relative(a, POSE_IDENTITY), of->first_point);
}

/* Two whose ways' boxes have parted are in no step together: who was told that they meet is told that they do not. */
static void add_free(world *w, const pair *p, const soft_place *i, const soft_place *k)
{
    const body *x = &w->bodies.at[i->body], *y = &w->bodies.at[k->body];
    pair_terms terms = pair_kept_terms(p);
    for (uint32_t id = 0; id < w->subscriptions.count; id++) {
        const soft_result *there;
        double separation = soft_separation(&w->subscriptions.at[id], terms.padding);
        if (!soft_is_wanted(w, id, x, y)) continue;
        soft_touches(w, p, separation, &there);
        if (there) continue;
        soft_result r = {.tick = w->figures.ticks,
            .key = pair_key(p->a, p->b),
            .a = p->a,
            .b = p->b,
            .separation = separation,
            .frame_a = i->frame,
            .frame_b = k->frame,
            .safe_lo = 1,
            .safe_hi = INFINITY};
        r.contacts = base_alloc(1, sizeof *r.contacts), r.touches = base_alloc(1, sizeof *r.touches);
        soft_result_add(w, &r);
    }
}

/* Pairs of a soft and a rigid shape are found out here, where both stand as of this tick; how two soft ones stand that
 * no step of this tick was about is asked of the next, if somebody has come to ask for it. */
void soft_decide(world *w)
{
    if (!w->soft->count) return;
    for (size_t k = 0; k < w->active_pairs.count; k++) {
        pair *p = &w->pairs.at[w->active_pairs.at[k]];
        if (!pair_is_soft(w, p)) continue;
        const collider *a = &w->colliders.at[p->a], *b = &w->colliders.at[p->b];
        const body *x = &w->bodies.at[a->body], *y = &w->bodies.at[b->body];
        bool news = p->asked_epoch != w->epoch || x->stale || y->stale;
        p->asked_epoch = x->stale || y->stale ? 0 : w->epoch;
        if (collider_is_soft(a) && collider_is_soft(b)) {
            soft_place *i = soft_place_of(w, x), *j = soft_place_of(w, y);
            bool decided = soft_is_decided(w, p);
            if (!i || !j || decided) continue;
            bool went = i->way_tick == w->figures.ticks || j->way_tick == w->figures.ticks;
            if (went && pair_is_reported(p)) add_free(w, p, i, j);
            i->asked |= news && !went;
            continue;
        }
        const body *soft = collider_is_soft(a) ? x : y, *rigid = collider_is_soft(a) ? y : x;
        const soft_place *place = soft_place_of(w, soft);
        if (!place) continue;
        if (place->beside && !place->beside->fresh) { /* when that is done both are looked at again */
            p->asked_epoch = 0;
            continue;
        }
        pair_more *more = pair_more_make(w, p);
        uint64_t since = more->swept_tick > w->soft->clear_tick ? more->swept_tick : w->soft->clear_tick;
        if (news || place->way_tick > since || rigid->changed_tick > since) soft_rigid_ask(w, p, since);
        more->swept_tick = w->figures.ticks;
    }
    soft_go_beside(w);
    bool beside = false;
    for (size_t i = 0; i < w->soft->places.count; i++) beside |= w->soft->places.at[i] && w->soft->places.at[i]->beside;
    if (!beside && !w->due && !w->parked && !broad_unsearched_count(w->broad)) w->soft->clear_tick = w->figures.ticks;
}

/* ---- for who asks for features and safe steps ---- */

static int64_t contact_id(const world *w, const soft_result *r, uint32_t subscription)
{
    uint32_t id = pair_find(w, r->a, r->b);
    if (id == PAIR_MAP_NONE) return 0;
    for (uint32_t v = w->pairs.at[id].first_watch; v != WORLD_NONE; v = w->watches.at[v].pair_next)
        if (w->watches.at[v].subscription == subscription) return w->watches.at[v].touch_id;
    return 0;
}

/* Once, for whomever it is told. */
void soft_result_hash(soft_result *r)
{
    uint64_t h = 0;
    for (size_t i = 0; i < r->count; i++) {
        const soft_contact *c = &r->contacts[i];
        uint32_t times[2];
        memcpy(&times[0], &c->t_lo, sizeof times[0]), memcpy(&times[1], &c->t_hi, sizeof times[1]);
        h = hash_word(h, (uint64_t)c->a << 32 | c->b);
        h = hash_word(h, (uint64_t)times[0] << 32 | times[1]);
        h = hash_word(h, (uint64_t)c->kind << 8 | c->proof);
    }
    r->hash = h;
}

static uint64_t hash_told(uint64_t h, const soft_told *t)
{
    const world_soft *s = &t->what;
    const soft_result *r = s->features;
    h = hash_half(h, t->subscription);
    h = hash_bytes(h, s->name_a, strlen(s->name_a));
    h = hash_bytes(h, s->name_b, strlen(s->name_b));
    const uint64_t words[] = {(uint64_t)s->contact, (uint64_t)s->frame_a, (uint64_t)s->frame_b, s->proposed,
        s->unfinished, s->vertex_face, s->edge_edge, s->face_shape, s->within, s->undecided, s->left_out};
    for (size_t i = 0; i < sizeof words / sizeof *words; i++) h = hash_word(h, words[i]);
    h = hash_double(hash_double(h, s->safe_lo), s->safe_hi);
    return s->count ? hash_word(hash_word(h, s->count), r->hash) : h;
}

static void tell_one(world *w, const soft_result *r, uint32_t id)
{
    const subscription *i = &w->subscriptions.at[id];
    const collider *a = &w->colliders.at[r->a], *b = &w->colliders.at[r->b];
    const body *x = &w->bodies.at[a->body], *y = &w->bodies.at[b->body];
    pair_terms terms = pair_get_terms(w, x, y);
    if (!(i->facts & (WORLD_FEATURES | WORLD_SAFE_STEP)) || !soft_is_wanted(w, id, x, y)) return;
    if (r->separation != soft_separation(i, terms.padding)) return;
    bool turned = events_is_turned(w, x, y, id, terms.looks);
    bool each = i->facts & WORLD_FEATURES && i->soft_each;
    size_t count = !each ? 0 : i->soft_most && i->soft_most < r->count ? i->soft_most : r->count;
    soft_told t = {.subscription = id,
        .what = {.name_a = turned ? y->name : x->name,
            .name_b = turned ? x->name : y->name,
            .shape_a = turned ? b->index : a->index,
            .shape_b = turned ? a->index : b->index,
            .contact = contact_id(w, r, id),
            .frame_a = turned ? r->frame_b : r->frame_a,
            .frame_b = turned ? r->frame_a : r->frame_b,
            .proposed = r->proposed,
            .unfinished = r->unfinished,
            .vertex_face = r->tally.vertex_face,
            .edge_edge = r->tally.edge_edge,
            .face_shape = r->face_shape,
            .within = r->tally.within,
            .undecided = r->tally.undecided,
            .left_out = each ? contacts_of(r) - count : 0,
            .safe_lo = r->safe_lo,
            .safe_hi = r->safe_hi,
            .count = count,
            .features = r,
            .turned = turned}};
    if (b->shadow) t.what.shape_b = t.what.shape_a = 0;
    array_push(&w->soft->told, t);
    subscription_wake(w, id);
}

static int compare_results(const void *x, const void *y)
{
    const soft_result *a = x, *b = y;
    if (a->proposed != b->proposed) return a->proposed ? 1 : -1;
    int64_t f = a->frame_a > a->frame_b ? a->frame_a : a->frame_b,
            g = b->frame_a > b->frame_b ? b->frame_a : b->frame_b;
    if (a->proposed && f != g) return f < g ? -1 : 1;
    if (a->key != b->key) return a->key < b->key ? -1 : 1;
    if (a->separation != b->separation) return a->separation < b->separation ? -1 : 1;
    return (a->tick > b->tick) - (a->tick < b->tick);
}

/* By subscriptions, in the canonical order of results. What is very much is told to some in this tick, and to the
 * others in the next ones: who asks for all features of large meshes makes nobody wait but those who ask for them, too.
 */
void soft_tell(world *w)
{
    enum { A_TICK = 1 << 17, A_LOOK = 1, A_PAIR = 32, FEATURES = 2 /* as a look */ };
    struct soft_world *s = w->soft;
    size_t spent = 0;
    uint32_t id = 0;
    if (!s->results.count) return;
    qsort(s->results.at, s->results.count, sizeof *s->results.at, compare_results);
    for (; id < w->subscriptions.count && spent < A_TICK; id++)
        for (size_t i = 0; i < s->results.count && w->subscriptions.at[id].used; i++) {
            soft_result *r = &s->results.at[i];
            size_t before = s->told.count;
            if (r->is_told || id < r->next_told) continue;
            tell_one(w, r, id);
            spent += A_LOOK;
            if (s->told.count > before) spent += A_PAIR + s->told.at[before].what.count / FEATURES;
        }
    for (size_t i = 0; i < s->results.count; i++) {
        soft_result *r = &s->results.at[i];
        r->is_told |= id >= w->subscriptions.count;
        if (id > r->next_told) r->next_told = id;
        w->sliced |= !r->is_told;
    }
    for (size_t i = 0; i < s->told.count; i++) {
        w->hash = hash_told(w->hash, &s->told.at[i]);
        array_push(&s->batch, s->told.at[i].what);
    }
}

/* What of it is this subscription's. */
size_t soft_told_to(const world *w, uint32_t subscription, const world_soft **at)
{
    const struct soft_world *s = w->soft;
    size_t first = 0, end;
    while (first < s->told.count && s->told.at[first].subscription < subscription) first++;
    for (end = first; end < s->told.count && s->told.at[end].subscription == subscription;) end++;
    *at = first < end ? s->batch.at + first : NULL;
    return end - first;
}

world_feature world_soft_feature(const world_soft *of, size_t i)
{
    const soft_result *r = of->features;
    const soft_contact *c = &r->contacts[i];
    const struct soft_touch *t = &r->touches[i];
    float sign = of->turned ? -1 : 1;
    world_feature f = {.kind = c->kind, .proof = c->proof, .a = c->a, .b = c->b, .t_lo = c->t_lo, .t_hi = c->t_hi};
    for (int k = 0; k < 3; k++) f.normal[k] = sign * t->normal[k];
    f.bary[0] = t->bary[0], f.bary[1] = t->bary[1];
    if (!of->turned || c->kind > SOFT_EDGE_EDGE) return f;
    f.a = c->b, f.b = c->a;
    if (c->kind == SOFT_EDGE_EDGE)
        f.bary[0] = t->bary[1], f.bary[1] = t->bary[0];
    else
        f.kind = c->kind == SOFT_VERTEX_FACE ? SOFT_FACE_VERTEX : SOFT_VERTEX_FACE;
    return f;
}
