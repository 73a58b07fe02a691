/* body: the life of a body: put, held, removed, and gone. Tick thread. */
#include "match.h"
#include "state.h"

#include <stdlib.h>

/* ---- rules ---- */

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

static void copy_rules(world *w, body *b, const world_body *def)
{
    free_rules(b);
    b->rules = def->rule_count ? base_alloc(def->rule_count, sizeof *b->rules) : NULL;
    for (size_t i = 0; i < def->rule_count; i++)
        b->rules[i] = (filter_rule){.pattern = base_strdup(def->rules[i].pattern),
            .allow = def->rules[i].allow,
            .reason = base_strdup(def->rules[i].reason ? def->rules[i].reason : ""),
            .padding = def->rules[i].padding,
            .margin = def->rules[i].margin};
    b->rule_count = def->rule_count;
    rules_choose(&w->rules, &b->rule_set, b->rules, b->rule_count);
    measure_rules(b);
}

/* ---- put, hold, remove ---- */

void body_mark_dirty(world *w, uint32_t id, bool refilter)
{
    body *b = &w->bodies.at[id];
    b->refilter |= refilter;
    b->is_calm &= !refilter;
    w->changed = true;
    if (b->dirty) return;
    b->dirty = true;
    array_push(&w->dirty, id);
    w->effort += b->effort;
}

/* As array_reserve does, but each body begins a cache line. */
void body_reserve(world *w, size_t need)
{
    array_reserve_in_place(&w->bodies, need);
}

static uint32_t new_body(world *w)
{
    uint32_t id = id_pool_take(&w->body_ids);
    body_reserve(w, id + 1);
    if (id >= w->bodies.count) w->bodies.count = id + 1;
    w->bodies.at[id] = (body){.used = true, .serial = ++w->body_serial, .expiry_ns = INT64_MAX};
    w->figures.bodies++;
    return id;
}

/* Under another name it is another body: what was reported under the old one ends. So it is for a stale one that
 * changes its group: who got the report that it is unknown may not hear of it any more. */
static bool is_another(const body *b, const world_body *def)
{
    return strcmp(b->name, def->name) != 0 || (b->stale && strcmp(b->group, def->group ? def->group : "") != 0);
}

world_status world_put_body(world *w, uint32_t *id, const world_body *def)
{
    uint32_t named = world_find_body(w, def->name);
    if (named != *id && removal_hastens(w, named)) named = WORLD_NONE;
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
    bool same_name = !is_new && strcmp(b->group, def->group ? def->group : "") == 0;
    b->matched &= same_name;
    if (!same_name) b->label = b->ruling;
    body_free_group(b);
    body_set_group(b, def->group);
    w->ccds += (size_t)(def->ccd != WORLD_CCD_OFF) - (size_t)(b->ccd != WORLD_CCD_OFF);
    b->fixed = def->fixed;
    b->category = def->category;
    b->mask = def->mask;
    b->one_way = def->one_way;
    b->in_step = def->in_step;
    b->owner = def->owner;
    b->ccd = def->ccd;
    b->acceleration = def->acceleration;
    b->angular_acceleration = def->angular_acceleration;
    b->deadline_ns = def->deadline_ns;
    bool stays = !is_new && pose_same(b->pose, def->pose) && b->stamp_ns == def->stamp_ns;
    if (!stays && !is_new) past_stands(w, *id);
    body_set_pose(b, def->pose, def->stamp_ns);
    b->announced_ns = def->stamp_is_now ? def->stamp_ns : 0;
    b->held = false;
    if (!stays) { /* a definition has no velocities, and no way to where it is */
        b->speed = SPEED_NONE;
        b->moved = false;
        b->glided = 0;
        b->passed.count = 0;
        b->before = b->pose;
        b->before_ns = b->stamp_ns;
    }
    copy_rules(w, b, def);
    if (is_new || !body_same_shapes(w, b, def)) {
        past_reshape(w, *id);
        body_drop_shapes(w, b);
        body_add_shapes(w, *id, def);
    }
    match_put_body(w, *id);
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
        motion swept = motion_between(b->before, b->pose, 1e-9 * (double)stamps_between(b->before_ns, b->stamp_ns));
        *linear = swept.linear;
        *angular = swept.angular;
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
    removal_forget(w, b);
    body_drop_name(w, b->name);
    slices_forget(w, id);
    w->figures.bodies--;
    body_drop_shapes(w, b);
    w->ccds -= b->ccd != WORLD_CCD_OFF;
    past_reshape(w, id);
    b->ghost = true;
    b->ghost_cause = cause;
    leaving_ghost(w, id);
    w->figures.stale_bodies -= b->stale;
    w->changed = true;
    array_push(&w->ghosts, id);
    return WORLD_OK;
}

/* ---- gone ---- */

/* Bodies stay where they are in memory, so one may point into itself. */
void body_make_shapes(body *b, size_t count)
{
    b->shape_count = (uint32_t)count;
    b->only_shape = 0;
    b->shapes = count > 1 ? base_zalloc(count, sizeof *b->shapes) : &b->only_shape;
}

void body_free_shapes(body *b)
{
    if (b->shapes != &b->only_shape) free(b->shapes);
    b->shapes = NULL;
    b->shape_count = 0;
}

static char no_group[] = "";

void body_set_group(body *b, const char *group)
{
    b->group = group && *group ? base_strdup(group) : no_group;
}

void body_free_group(body *b)
{
    if (b->group != no_group) free(b->group);
    b->group = NULL;
}

static void free_body(world *w, uint32_t id)
{
    body *b = &w->bodies.at[id];
    free(b->name);
    body_free_group(b);
    match_change_class(&w->match, &b->match, 0);
    body_free_shapes(b);
    array_free(&b->passed);
    array_free(&b->past);
    free_rules(b);
    rules_choose(&w->rules, &b->rule_set, NULL, 0);
    *b = (body){.used = false};
}

/* As many as a share of the slice allows: many that had to leave may be gone at once. */
static void reap_bodies(world *w)
{
    enum { PART = 4 };
    uint64_t spent = 0, units = w->slice == UINT64_MAX ? UINT64_MAX : w->slice / PART;
    size_t i = 0;
    for (; i < w->reap.count && spent <= units; i++) {
        body *b = &w->bodies.at[w->reap.at[i]];
        if ((b->kept = b->leaving > 0)) continue;
        spent += removal_units(b);
        free_body(w, w->reap.at[i]);
        id_pool_give(&w->body_ids, w->reap.at[i]);
    }
    w->reap.count -= i;
    if (w->reap.count) memmove(w->reap.at, w->reap.at + i, w->reap.count * sizeof *w->reap.at);
    w->reaps_late = w->reap.count > 0;
}

/* Events of the last tick point to names: what was removed before it goes only now. */
void body_reap(world *w)
{
    reap_bodies(w);
    for (size_t i = 0; i < w->reap_colliders.count; i++) {
        collider *s = &w->colliders.at[w->reap_colliders.at[i]];
        if ((s->kept = broad_is_leaving(w->broad, w->reap_colliders.at[i]))) continue;
        collider_free(&w->colliders.at[w->reap_colliders.at[i]]);
        id_pool_give(&w->collider_ids, w->reap_colliders.at[i]);
    }
    w->reap_colliders.count = 0;
    for (size_t i = 0; i < w->ghosts.count; i++) array_push(&w->reap, w->ghosts.at[i]);
    for (size_t i = 0; i < w->ghost_colliders.count; i++) array_push(&w->reap_colliders, w->ghost_colliders.at[i]);
    w->ghosts.count = w->ghost_colliders.count = 0;
}

/* ---- what is asked of it ---- */

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
        .in_step = b->in_step,
        .ccd = b->ccd,
        .owner = b->owner,
        .acceleration = b->acceleration,
        .angular_acceleration = b->angular_acceleration,
        .deadline_ns = b->deadline_ns,
        .stamp_ns = b->stamp_ns,
        .stamp_is_now = b->announced_ns && b->stamp_ns == b->announced_ns,
        .pose = b->pose,
        .shapes = shapes,
        .shape_count = body_visible_shapes(b),
        .rules = b->rules,
        .rule_count = b->rule_count};
    for (size_t i = 0; shapes && i < body_visible_shapes(b); i++) {
        const collider *s = &w->colliders.at[b->shapes[i]];
        shapes[i] = (world_shape){s->shape, s->local};
    }
    return WORLD_OK;
}

/* -1 = fixed or not stamped; a stamp of the future, from a host whose clock is ahead, counts as of now. */
int64_t body_age_at(const body *b, int64_t now_ns)
{
    int64_t stamp_ns = b->dirty && b->moved ? b->before_ns : b->stamp_ns; /* of the pose that is reported */
    if (b->fixed || !stamp_ns) return -1;
    return now_ns > stamp_ns ? now_ns - stamp_ns : 0;
}

int64_t body_age_ns(const world *w, const body *b)
{
    return body_age_at(b, w->now_ns);
}
