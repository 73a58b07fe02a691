/* body: bodies and their shapes: put, move, remove, freshness, and their boxes in the broad phase. Tick thread. */
#include "filter.h"
#include "state.h"

#include "base/hash.h"
#include "base/sort.h"
#include "geom/bounds.h"
#include "geom/compound.h"

#include <stdlib.h>
#include <string.h>

/* ---- names ---- */

static uint64_t name_hash(const char *name)
{
    uint64_t h = hash_bytes(HASH_START, name, strlen(name));
    return h ? h : 1;
}

/* The key under which a name is stored, or the first free one after it. */
static uint64_t name_key(const world *w, const char *name, uint32_t *id)
{
    uint64_t key = name_hash(name);
    for (;; key = key + 1 ? key + 1 : 1) {
        *id = pair_map_get(&w->names, key);
        if (*id == PAIR_MAP_NONE || strcmp(w->bodies.at[*id].name, name) == 0) return key;
    }
}

uint32_t world_find_body(const world *w, const char *name)
{
    uint32_t id;
    name_key(w, name, &id);
    return id == PAIR_MAP_NONE ? WORLD_NONE : id;
}

void body_add_name(world *w, uint32_t body)
{
    uint32_t taken;
    uint64_t key = name_key(w, w->bodies.at[body].name, &taken);
    pair_map_put(&w->names, key, body);
}

/* Names that were probed on behind this one move up, so that no probe meets a hole. */
static void name_drop(world *w, const char *name)
{
    uint32_t id;
    uint64_t key = name_key(w, name, &id);
    pair_map_remove(&w->names, key);
    for (key = key + 1 ? key + 1 : 1;; key = key + 1 ? key + 1 : 1) {
        id = pair_map_remove(&w->names, key);
        if (id == PAIR_MAP_NONE) return;
        body_add_name(w, id);
    }
}

const char *world_body_name(const world *w, uint32_t id)
{
    return body_is(w, id) ? w->bodies.at[id].name : NULL;
}
pose world_body_pose(const world *w, uint32_t id)
{
    return body_is(w, id) ? w->bodies.at[id].pose : POSE_IDENTITY;
}
int64_t world_body_stamp_ns(const world *w, uint32_t id)
{
    return body_is(w, id) ? w->bodies.at[id].stamp_ns : 0;
}

world_status world_get_body(const world *w, uint32_t id, world_body *out, world_shape *shapes)
{
    if (!body_is(w, id)) return WORLD_UNKNOWN_ID;
    const body *b = &w->bodies.at[id];
    *out = (world_body){.name = b->name,
        .group = b->group,
        .fixed = b->fixed,
        .category = b->category,
        .mask = b->mask,
        .one_way = b->one_way,
        .ccd = b->ccd,
        .acceleration = b->acceleration,
        .angular_acceleration = b->angular_acceleration,
        .deadline_ns = b->deadline_ns,
        .stamp_ns = b->stamp_ns,
        .pose = b->pose,
        .shapes = shapes,
        .shape_count = b->shape_count,
        .rules = b->rules,
        .rule_count = b->rule_count};
    for (size_t i = 0; shapes && i < b->shape_count; i++) {
        const solid *s = &w->solids.at[b->shapes[i]];
        shapes[i] = (world_shape){s->shape, s->local};
    }
    return WORLD_OK;
}

/* ---- shapes ---- */

static bool is_identity(pose p)
{
    const vec3 at = p.p;
    return at.x == 0 && at.y == 0 && at.z == 0 && p.q.w == 1 && p.q.x == 0 && p.q.y == 0 && p.q.z == 0;
}

static bool same_vec(vec3 a, vec3 b)
{
    return a.x == b.x && a.y == b.y && a.z == b.z;
}

static bool same_pose(pose a, pose b)
{
    return same_vec(a.p, b.p) && a.q.w == b.q.w && a.q.x == b.q.x && a.q.y == b.q.y && a.q.z == b.q.z;
}

/* Where a shape is when its body is there. */
static inline pose stand_on(pose body_pose, const solid *s)
{
    return s->at_origin ? body_pose : pose_mul(body_pose, s->local);
}

static bool same_shape(const solid *s, const world_shape *def)
{
    const shape *a = &s->shape, *b = &def->shape;
    bool same = a->type == b->type && a->radius == b->radius && a->deviation == b->deviation &&
                same_vec(a->half, b->half) && a->hull == b->hull && same_pose(s->local, def->local);
    return same && (a->type != SHAPE_COMPOUND || compound_equal(a->compound, b->compound));
}

static bool same_shapes(const world *w, const body *b, const world_body *def)
{
    if (b->shape_count != def->shape_count) return false;
    for (size_t i = 0; i < b->shape_count; i++)
        if (!same_shape(&w->solids.at[b->shapes[i]], &def->shapes[i])) return false;
    return true;
}

/* It and its children. */
static size_t shapes_in(const shape *s)
{
    return 1 + (s->type == SHAPE_COMPOUND ? s->compound->child_count : 0);
}

size_t world_body_shapes(const world *w, uint32_t id)
{
    size_t sum = 0;
    for (size_t i = 0; body_is(w, id) && i < w->bodies.at[id].shape_count; i++)
        sum += shapes_in(&w->solids.at[w->bodies.at[id].shapes[i]].shape);
    return sum;
}

static void drop_shapes(world *w, body *b)
{
    for (size_t i = 0; i < b->shape_count; i++) {
        solid *s = &w->solids.at[b->shapes[i]];
        s->ghost = true;
        w->figures.shapes -= shapes_in(&s->shape);
        array_push(&w->ghost_solids, b->shapes[i]);
        broad_remove(w->broad, b->shapes[i]);
    }
    free(b->shapes);
    b->shapes = NULL;
    b->shape_count = 0;
}

static void add_shapes(world *w, uint32_t id, const world_body *def)
{
    body *b = &w->bodies.at[id];
    b->shapes = base_alloc(def->shape_count ? def->shape_count : 1, sizeof *b->shapes);
    b->shape_count = def->shape_count;
    for (size_t i = 0; i < def->shape_count; i++) {
        uint32_t s = id_pool_take(&w->solid_ids);
        array_reserve(&w->solids, s + 1);
        if (s >= w->solids.count) w->solids.count = s + 1;
        const shape *given = &def->shapes[i].shape;
        compound *own = given->type == SHAPE_COMPOUND ? compound_copy(given->compound) : NULL;
        w->solids.at[s] = (solid){.shape = *given,
            .own = own,
            .local = def->shapes[i].local,
            .reach = shape_reach(given),
            .body = id,
            .index = (int32_t)i,
            .at_origin = is_identity(def->shapes[i].local),
            .used = true};
        w->solids.at[s].world = stand_on(b->pose, &w->solids.at[s]);
        w->solids.at[s].shape.compound = own;
        w->figures.shapes += shapes_in(&w->solids.at[s].shape);
        b->shapes[i] = s;
    }
}

/* ---- put, move, remove ---- */

static void free_rules(body *b)
{
    for (size_t i = 0; i < b->rule_count; i++) {
        free((char *)b->rules[i].pattern);
        free((char *)b->rules[i].reason);
    }
    free(b->rules);
    b->rules = NULL;
    b->rule_count = 0;
}

static bool same_rule(const filter_rule *a, const filter_rule *b)
{
    return a->allow == b->allow && a->padding == b->padding && a->margin == b->margin &&
           strcmp(a->pattern, b->pattern) == 0;
}

static bool same_filter(const body *b, const world_body *def)
{
    bool same = b->category == def->category && b->mask == def->mask && b->one_way == def->one_way &&
                strcmp(b->group, def->group ? def->group : "") == 0 && b->rule_count == def->rule_count;
    for (size_t i = 0; same && i < b->rule_count; i++) same = same_rule(&b->rules[i], &def->rules[i]);
    return same;
}

/* The farthest that a rule moves a threshold or a range out: the broad phase honours it. */
static void measure_rules(body *b)
{
    b->rule_reach = 0;
    for (size_t i = 0; i < b->rule_count; i++) {
        const filter_rule *r = &b->rules[i];
        if (r->allow) continue;
        b->rule_reach = fmax(b->rule_reach, fmax(r->padding, r->margin));
    }
}

static void copy_rules(body *b, const world_body *def)
{
    free_rules(b);
    b->rules = base_alloc(def->rule_count ? def->rule_count : 1, sizeof *b->rules);
    for (size_t i = 0; i < def->rule_count; i++)
        b->rules[i] = (filter_rule){.pattern = base_strdup(def->rules[i].pattern),
            .allow = def->rules[i].allow,
            .reason = base_strdup(def->rules[i].reason ? def->rules[i].reason : ""),
            .padding = def->rules[i].padding,
            .margin = def->rules[i].margin};
    b->rule_count = def->rule_count;
    measure_rules(b);
}

void body_mark_dirty(world *w, uint32_t id, bool refilter)
{
    body *b = &w->bodies.at[id];
    b->refilter |= refilter;
    b->is_calm &= !refilter;
    w->changed = true;
    if (b->dirty) return;
    b->dirty = true;
    array_push(&w->dirty, id);
}

/* As array_reserve does, but each body begins a cache line. */
void body_reserve(world *w, size_t need)
{
    if (need <= w->bodies.capacity) return;
    size_t capacity = need < 2 * w->bodies.capacity ? 2 * w->bodies.capacity : need;
    body *grown = base_alloc_lines(capacity, sizeof *grown);
    if (w->bodies.count) memcpy(grown, w->bodies.at, w->bodies.count * sizeof *grown);
    free(w->bodies.at);
    w->bodies.at = grown;
    w->bodies.capacity = capacity;
}

static uint32_t new_body(world *w)
{
    uint32_t id = id_pool_take(&w->body_ids);
    body_reserve(w, id + 1);
    if (id >= w->bodies.count) w->bodies.count = id + 1;
    w->bodies.at[id] = (body){.used = true, .serial = ++w->body_serial, .expiry_ns = INT64_MAX};
    w->bodies.at[id].match_a = base_zalloc(w->words, sizeof(uint64_t));
    w->bodies.at[id].match_b = base_zalloc(w->words, sizeof(uint64_t));
    w->figures.bodies++;
    return id;
}

/* Under another name it is another body: what was told under the old one ends. So it is for a stale one that changes
 * its group: who was told that it is unknown may not hear of it any more. */
static bool is_another(const body *b, const world_body *def)
{
    return strcmp(b->name, def->name) != 0 || (b->stale && strcmp(b->group, def->group ? def->group : "") != 0);
}

world_status world_put_body(world *w, uint32_t *id, const world_body *def)
{
    uint32_t named = world_find_body(w, def->name);
    bool is_new = *id == WORLD_NONE;
    if (!is_new && !body_is(w, *id)) return WORLD_UNKNOWN_ID;
    if (named != WORLD_NONE && named != *id) return WORLD_NAME_TAKEN;
    if (!is_new && is_another(&w->bodies.at[*id], def)) {
        world_remove_body(w, *id, CAUSE_SHAPE);
        is_new = true;
    }
    if (is_new) *id = new_body(w);

    body *b = &w->bodies.at[*id];
    body_settle_shapes(w, b);
    if (is_new) {
        b->name = base_strdup(def->name);
        body_add_name(w, *id);
    } else if (!same_filter(b, def)) {
        b->ruled_tick = w->ruled_tick = w->figures.ticks + 1;
    }
    if (is_new || !same_filter(b, def) || b->fixed != def->fixed) b->ruling = ++w->ruling;
    free(b->group);
    b->group = base_strdup(def->group ? def->group : "");
    b->fixed = def->fixed;
    b->category = def->category;
    b->mask = def->mask;
    b->one_way = def->one_way;
    b->ccd = def->ccd;
    b->acceleration = def->acceleration;
    b->angular_acceleration = def->angular_acceleration;
    b->deadline_ns = def->deadline_ns;
    bool stays = !is_new && same_pose(b->pose, def->pose) && b->stamp_ns == def->stamp_ns;
    body_set_pose(b, def->pose, def->stamp_ns);
    b->held = false;
    if (!stays) { /* a definition has no velocities, and no way to where it is */
        b->speed = SPEED_NONE;
        b->moved = false;
        b->glided = 0;
        b->passed.count = 0;
        b->before = b->pose;
        b->before_ns = b->stamp_ns;
    }
    copy_rules(b, def);
    if (is_new || !same_shapes(w, b, def)) {
        drop_shapes(w, b);
        add_shapes(w, *id, def);
    }
    interest_match_body(w, *id);
    body_mark_dirty(w, *id, true);
    return WORLD_OK;
}

/* What it goes by stays as it is until its next pose, and few are asked. */
void body_velocity(const body *b, vec3 *linear, vec3 *angular)
{
    *linear = *angular = VEC_ZERO;
    if (b->speed == SPEED_GIVEN) {
        *linear = b->linear;
        *angular = b->angular;
    } else if (b->speed == SPEED_ESTIMATED) {
        motion way = motion_between(b->before, b->pose, 1e-9 * (double)stamps_between(b->before_ns, b->stamp_ns));
        *linear = way.linear;
        *angular = way.angular;
    }
}

void body_arrive(world *w, uint32_t id)
{
    body *b = &w->bodies.at[id];
    b->moved = false;
    if (!b->detours) return;
    b->detours = b->teleported = false;
    b->passed.count = 0;
}

world_status world_hold_body(world *w, uint32_t id)
{
    if (!body_is(w, id)) return WORLD_UNKNOWN_ID;
    w->bodies.at[id].held = true;
    w->bodies.at[id].is_calm = false;
    array_push(&w->held_now, id);
    w->changed = true;
    return WORLD_OK;
}

world_status world_remove_body(world *w, uint32_t id, uint8_t cause)
{
    if (!body_is(w, id)) return WORLD_UNKNOWN_ID;
    body *b = &w->bodies.at[id];
    name_drop(w, b->name);
    w->figures.bodies--;
    drop_shapes(w, b);
    b->ghost = true;
    b->ghost_cause = cause;
    w->figures.stale_bodies -= b->stale;
    w->changed = true;
    array_push(&w->ghosts, id);
    return WORLD_OK;
}

/* ---- parts of the tick ---- */

static void free_body(world *w, uint32_t id)
{
    body *b = &w->bodies.at[id];
    free(b->name);
    free(b->group);
    free(b->match_a);
    free(b->match_b);
    free(b->shapes);
    array_free(&b->passed);
    free_rules(b);
    *b = (body){.used = false};
}

void solid_free(solid *s)
{
    compound_destroy(s->own);
    *s = (solid){.used = false};
}

/* Events of the last tick point to names: what was removed before it goes only now. */
void body_reap(world *w)
{
    for (size_t i = 0; i < w->reap.count; i++) {
        free_body(w, w->reap.at[i]);
        id_pool_give(&w->body_ids, w->reap.at[i]);
    }
    for (size_t i = 0; i < w->reap_solids.count; i++) {
        solid_free(&w->solids.at[w->reap_solids.at[i]]);
        id_pool_give(&w->solid_ids, w->reap_solids.at[i]);
    }
    w->reap.count = w->reap_solids.count = 0;
    for (size_t i = 0; i < w->ghosts.count; i++) array_push(&w->reap, w->ghosts.at[i]);
    for (size_t i = 0; i < w->ghost_solids.count; i++) array_push(&w->reap_solids, w->ghost_solids.at[i]);
    w->ghosts.count = w->ghost_solids.count = 0;
}

/* A tenth of the shape; what it moves, the broad phase adds ahead of it. */
double body_margin(const world *w, const solid *s)
{
    double reach = isfinite(s->reach) ? s->reach : 0;
    return w->options.margin * reach;
}

/* Dirty and calm: it went the long road because ways count, or else because it has left its room. */
static inline bool is_spared(const world *w, const body *b)
{
    return b->is_calm && !may_glide(w);
}

/* Those that come next are asked for while these are worked on; of one that is calm, no more than that is looked at. */
static inline void fetch_ahead(const world *w, size_t i)
{
    enum { CALM_AHEAD = 12, BODIES_AHEAD = 8, LISTS_AHEAD = 4, SHAPES_AHEAD = 2, LINE = 64 };
    if (i + CALM_AHEAD >= w->dirty.count) return;
    const body *b = &w->bodies.at[w->dirty.at[i + CALM_AHEAD]];
    __builtin_prefetch(&b->pose);
    __builtin_prefetch(&b->room, 1);
    b = &w->bodies.at[w->dirty.at[i + BODIES_AHEAD]];
    if (!is_spared(w, b))
        for (size_t at = offsetof(body, before); at < sizeof(body); at += LINE)
            __builtin_prefetch((const char *)b + at);
    b = &w->bodies.at[w->dirty.at[i + LISTS_AHEAD]];
    if (!is_spared(w, b)) __builtin_prefetch(b->shapes);
    b = &w->bodies.at[w->dirty.at[i + SHAPES_AHEAD]];
    if (is_spared(w, b) || !b->shape_count) return;
    const char *s = (const char *)&w->solids.at[b->shapes[0]];
    for (size_t at = 0; at < sizeof(solid); at += LINE) __builtin_prefetch(s + at);
}

/* Where the boxes of a body were put last. */
static pose settled_pose(const world *w, const body *b)
{
    bool is_newer = b->glided == w->round || (b->dirty && b->moved);
    return is_newer ? b->before : b->pose;
}

/* In a tick: what it did since the last one was nobody's business then, and is now. */
void body_account(world *w, uint32_t id)
{
    body *b = &w->bodies.at[id];
    body_settle_shapes(w, b);
    if (b->moved || b->glided != w->round - 1) return;
    b->moved = true;
    array_push(&w->glided, id);
}

pose solid_pose(const world *w, const solid *s)
{
    const body *b = &w->bodies.at[s->body];
    return b->behind ? stand_on(settled_pose(w, b), s) : s->world;
}

void solid_stand(const world *w, const solid *s, pose *body_pose, pose *local)
{
    const body *b = &w->bodies.at[s->body];
    *body_pose = settled_pose(w, b);
    *local = s->local;
    if (b->behind) return;
    pose is = stand_on(*body_pose, s);
    if (memcmp(&is, &s->world, sizeof is) == 0) return;
    *body_pose = s->world; /* it has teleported since */
    *local = POSE_IDENTITY;
}

void body_settle_shapes(world *w, body *b)
{
    if (!b->behind) return;
    b->behind = false;
    for (size_t i = 0; i < b->shape_count; i++) {
        solid *s = &w->solids.at[b->shapes[i]];
        s->world = stand_on(settled_pose(w, b), s);
        s->box = shape_bounds(&s->shape, s->world);
    }
}

static void put_shapes(world *w, body *b)
{
    bool sweeps = b->impacts || b->horizon > 0;
    for (size_t k = 0; k < b->shape_count; k++) {
        solid *s = &w->solids.at[b->shapes[k]];
        s->world = stand_on(b->pose, s);
        s->box = shape_bounds(&s->shape, s->world);
        aabb box = sweeps ? body_swept_bounds(w, b, s, s->box) : s->box;
        broad_put(w->broad, &(broad_move){.proxy = b->shapes[k],
                                .fixed = b->fixed,
                                .box = aabb_grow(box, b->widen),
                                .margin = body_margin(w, s),
                                .motion = body_step(b)});
        if (b->refilter) broad_refilter(w->broad, b->shapes[k]);
    }
    b->refilter = b->behind = false;
    calm_find(w, b); /* until a pair begins that it is in */
}

static void settle_body(world *w, uint32_t id)
{
    body *b = &w->bodies.at[id];
    array_push(&w->awake, id);
    b->dirty = false;
    b->moved |= b->glided == w->round - 1;
    if (b->ghost || !b->used) return;
    if (b->posed) expiry_set(w, id);
    b->posed = false;
    bounds_travel(w, b);
    put_shapes(w, b);
}

void body_settle_dirty(world *w)
{
    bool all = w->grant || w->bounds_asked; /* how far each goes is added up */
    array_reserve(&w->sort_scratch, w->dirty.count);
    sort_keys(w->dirty.at, w->sort_scratch.at, w->dirty.count);
    w->awake.count = 0;
    for (size_t i = 0; i < w->dirty.count; i++) {
        fetch_ahead(w, i);
        body *b = &w->bodies.at[w->dirty.at[i]];
        if (b->is_calm && !all && calm_holds(b, &b->pose)) {
            b->dirty = b->posed = false;
            b->behind = true;
        } else {
            settle_body(w, (uint32_t)w->dirty.at[i]);
        }
    }
}

/* -1 = fixed or not stamped; a stamp of the future, from a host whose clock is ahead, counts as of now. */
int64_t body_age_at(const body *b, int64_t now_ns)
{
    if (b->fixed || !b->stamp_ns) return -1;
    return now_ns > b->stamp_ns ? now_ns - b->stamp_ns : 0;
}

int64_t body_age_ns(const world *w, const body *b)
{
    return body_age_at(b, w->now_ns);
}

/* B's pose in A's frame, from the difference of the bodies' positions: exact where the bodies are near each other,
 * however far they are from the origin. */
static pose relative_of(pose body_a, pose local_a, pose body_b, pose local_b)
{
    pose bodies = pose_relative(body_a, body_b);
    pose b_in_body_a = pose_mul(bodies, local_b);
    pose relative = pose_relative(local_a, b_in_body_a);
    relative.q = quat_unit(relative.q);
    return relative;
}

/* Of two shapes at their bodies' origins the same numbers, without the products that change nothing. */
pose solid_relative(const world *w, const solid *a, const solid *b)
{
    if (a->at_origin && b->at_origin) {
        pose relative = pose_relative(w->bodies.at[a->body].pose, w->bodies.at[b->body].pose);
        relative.q = quat_unit(relative.q);
        return relative;
    }
    return relative_of(w->bodies.at[a->body].pose, a->local, w->bodies.at[b->body].pose, b->local);
}

pose solid_settled_relative(const world *w, const solid *a, const solid *b)
{
    pose body_a, local_a, body_b, local_b;
    solid_stand(w, a, &body_a, &local_a);
    solid_stand(w, b, &body_b, &local_b);
    return relative_of(body_a, local_a, body_b, local_b);
}

/* Two more products of poses and one more of matrices: the positions are off by some 20 roundoffs of the arms and of
 * what lies between the bodies, the directions by 8. */
double solid_relative_error(const world *w, const solid *a, const solid *b)
{
    if (a->at_origin && b->at_origin) return 0;
    vec3 between = vec_sub(w->bodies.at[b->body].pose.p, w->bodies.at[a->body].pose.p);
    return 0x1p-48 * (vec_norm(a->local.p) + vec_norm(b->local.p) + vec_norm(between)) + 0x1p-50 * pair_size(a, b);
}
