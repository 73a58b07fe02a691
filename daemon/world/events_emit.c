/* events_emit: one event: made out of what the narrow phase found, put into a subscription's list and into the hash.
 * Tick thread. */
#include "events.h"
#include "subscription.h"

#include "base/hash.h"
#include "narrow/contact/manifold.h"

#include <string.h>

static bool has_impact(uint8_t kind)
{
    return kind == EVENT_IMPACT || kind == EVENT_PREDICTED;
}

static uint64_t hash_vec(uint64_t h, vec3 v)
{
    return hash_double(hash_double(hash_double(h, v.x), v.y), v.z);
}

static uint64_t hash_manifold(uint64_t h, const manifold *m)
{
    for (uint32_t i = 0; i < m->count; i++) {
        const manifold_point *p = &m->points[i];
        h = hash_double(hash_vec(h, p->point), p->distance);
        h = hash_bytes(h, &p->feature, sizeof p->feature);
    }
    return h;
}

static uint64_t hash_event(uint64_t h, uint32_t subscription, const world_event *e)
{
    const uint8_t what[] = {e->kind, e->cause, e->achieved};
    h = hash_half(h, subscription);
    h = hash_bytes(h, what, sizeof what);
    h = hash_word(h, (uint64_t)e->contact);
    h = hash_bytes(h, e->name_a, strlen(e->name_a));
    h = hash_bytes(h, e->name_b, strlen(e->name_b));
    h = hash_double(hash_double(h, e->lo), e->hi);
    h = hash_vec(hash_vec(hash_vec(h, e->axis), e->point_a), e->point_b);
    h = hash_double(hash_double(h, (double)e->age_a_ns), (double)e->age_b_ns);
    h = hash_manifold(hash_double(h, e->closing), &e->manifold);
    if (has_impact(e->kind)) {
        h = hash_double(hash_double(h, e->impact.lo), e->impact.hi);
        h = hash_double(h, (double)e->impact.start_ns);
    }
    return h;
}

void events_emit(world *w, uint32_t id, const world_event *e, uint8_t kind, uint8_t cause, int64_t contact)
{
    subscription *i = &w->subscriptions.at[id];
    array_reserve(&i->events, i->events.count + 1);
    world_event *mine = &i->events.at[i->events.count++];
    event_copy(mine, e, has_impact(kind));
    subscription_wake(w, id);
    mine->kind = kind;
    mine->cause = cause;
    mine->contact = contact;
    if (kind == EVENT_UNKNOWN) {
        mine->lo = -INFINITY;
        mine->hi = INFINITY;
        mine->achieved = WORLD_WIDE;
    }
    w->hash = hash_event(w->hash, id, mine);
    w->figures.events++;
}

static vec3 to_world(const collider *s, vec3 point_in_s)
{
    return pose_point(s->world, point_in_s);
}

static void swap_sides(void *a, void *b, size_t size)
{
    char kept[sizeof(pose)];
    memcpy(kept, a, size);
    memcpy(a, b, size);
    memcpy(b, kept, size);
}

static void turn_facts(world_event *e)
{
    swap_sides(&e->name_a, &e->name_b, sizeof e->name_a);
    swap_sides(&e->shape_a, &e->shape_b, sizeof e->shape_a);
    e->axis = vec_neg(e->axis);
    swap_sides(&e->point_a, &e->point_b, sizeof e->point_a);
    swap_sides(&e->age_a_ns, &e->age_b_ns, sizeof e->age_a_ns);
    swap_sides(&e->pose_a, &e->pose_b, sizeof e->pose_a);
    for (uint32_t i = 0; i < e->manifold.count; i++)
        e->manifold.points[i].feature = feature_turned(e->manifold.points[i].feature);
}

void events_turn_round(world_event *e)
{
    turn_facts(e);
    swap_sides(&e->impact.pose_a, &e->impact.pose_b, sizeof e->impact.pose_a);
}

bool events_is_turned(const world *w, const body *a, const body *b, uint32_t id, int looks)
{
    if (subscription_is_mutual(w, id)) return looks < 0;
    subscription_sides sides = subscription_sides_of(w, id, a, b);
    return sides.straight && sides.turned ? looks < 0 : sides.turned;
}

static vec3 velocity_at(const body *b, vec3 point)
{
    vec3 linear, angular;
    if (b->fixed || !b->speed) return VEC_ZERO;
    body_velocity(b, &linear, &angular);
    return vec_add(linear, vec_cross(angular, vec_sub(point, b->pose.p)));
}

void events_fill(
    const world *w, const pair *p, const narrow_result *r, uint32_t subscription, int looks, world_event *e)
{
    const collider *a = &w->colliders.at[p->a], *b = &w->colliders.at[p->b];
    const body *x = &w->bodies.at[a->body], *y = &w->bodies.at[b->body];
    __builtin_prefetch(x->name); /* for the hash */
    __builtin_prefetch(y->name);
    event_clear(e);
    e->name_a = x->name;
    e->name_b = y->name;
    e->shape_a = a->index;
    e->shape_b = b->shadow ? a->index : b->index;
    e->lo = r->lo;
    e->hi = r->hi;
    e->axis = quat_rotate(a->world.q, r->axis);
    e->point_a = to_world(a, r->point_a);
    e->point_b = to_world(a, r->point_b);
    e->age_a_ns = body_age_ns(w, x);
    e->age_b_ns = body_age_ns(w, y);
    e->pose_a = x->pose;
    e->pose_b = y->pose;
    e->manifold.count = r->manifold.count;
    for (uint32_t i = 0; i < e->manifold.count; i++) {
        e->manifold.points[i] = r->manifold.points[i];
        e->manifold.points[i].point = to_world(a, r->manifold.points[i].point);
    }
    e->closing = vec_dot(e->axis, vec_sub(velocity_at(x, e->point_a), velocity_at(y, e->point_b)));
    if (events_is_turned(w, x, y, subscription, looks)) turn_facts(e);
}
