/* answers: what the narrow phase was asked in the last tick, listed and asked again, for measurements. Tick thread. */
#include "cascade.h"
#include "state.h"

size_t world_answers(const world *w)
{
    return w->open.count;
}

static const pair *active_pair_of(const world *w, size_t i)
{
    return &w->pairs.at[w->active_pairs.at[w->open.at[i]]];
}

void world_get_answer(const world *w, size_t i, world_answer *out)
{
    const pair *p = active_pair_of(w, i);
    const collider *a = &w->colliders.at[p->a], *b = &w->colliders.at[p->b];
    demand d = cascade_demand(w, p);
    *out = (world_answer){.type_a = a->shape.type,
        .type_b = b->shape.type,
        .size = pair_size(a, b),
        .limit = d.limit,
        .lo = w->results.at[i].lo,
        .hi = w->results.at[i].hi};
}

void world_ask_again(const world *w, size_t i, world_accuracy accuracy, double relative, double *lo, double *hi)
{
    const pair *p = active_pair_of(w, i);
    const collider *a = &w->colliders.at[p->a], *b = &w->colliders.at[p->b];
    demand d = cascade_demand(w, p);
    narrow_result r;
    if (accuracy == WORLD_BY_BOXES) {
        const pair fresh = {.a = p->a, .b = p->b};
        pose b_in_a = collider_relative(w, a, b);
        bounds_ask(w, &fresh, &b_in_a, d.limit, w->scratch[0], &r);
    } else {
        d.verdict_only = accuracy == WORLD_BY_VERDICT;
        d.request.tolerance = relative * pair_size(a, b);
        narrow_cache cold = {.lower = 0};
        cascade_ask(w, p, &d, &cold, w->scratch[0], &r);
    }
    *lo = r.lo;
    *hi = r.hi;
}

void world_ask_exactly(const world *w, size_t i, double *lo, double *hi)
{
    const pair *p = active_pair_of(w, i);
    const collider *a = &w->colliders.at[p->a], *b = &w->colliders.at[p->b];
    pose b_in_a = collider_relative(w, a, b);
    narrow_request request = {.facts = NARROW_DISTANCE, .tolerance = 0, .range = INFINITY};
    narrow_cache cold = {.lower = 0};
    narrow_result r;
    narrow_query(&a->shape, &b->shape, &b_in_a, &request, &cold, w->scratch[0], &r);
    *lo = r.lo;
    *hi = r.hi;
}

shape_type world_shape_type(const world *w, const char *body_name, int32_t index)
{
    uint32_t id = world_find_body(w, body_name);
    if (id == WORLD_NONE || index < 0 || (size_t)index >= w->bodies.at[id].shape_count) return SHAPE_TYPE_COUNT;
    return w->colliders.at[w->bodies.at[id].shapes[index]].shape.type;
}
