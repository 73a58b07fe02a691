/* bounds: what can be said of a pair without a search: an interval by its boxes, one axis or two, and a support point a
 * shape. What is reported of it is wider by a slack, and then stands until one has moved by that relative to the other:
 * so long the pair costs a motion bound a tick, and nobody needs to be reported anew. Pure but for the pair's own
 * record. */
#include "cascade.h"
#include "state.h"

/* Of the pair's size: how far one may move before what was reported by bounds is looked at again. */
static const double SLACK = 0.25, SLACK_OF_BUDGET = 0.05;
static const double SLACK_OF_GAP = 0.25; /* of the lower bound: a pair that is far apart can be reported less often */

/* Of the way to the limit: how far a pair beyond it may go before it is looked at again. */
static const double NEARLY = 0.875;

/* Of a shape that is no smaller than its size: rounding of a pose, and of a few sums. */
static const double ROUNDING = 0x1p-46;

double pair_size(const collider *a, const collider *b)
{
    return (isfinite(a->reach) ? a->reach : 0) + (isfinite(b->reach) ? b->reach : 0);
}

/* Distances change by no more than the points of both shapes have moved. Half-spaces turn without bound. */
void bounds_travel(const world *w, body *b)
{
    if (!w->grant && !w->bounds_asked) return;
    b->reach = 0;
    for (size_t i = 0; i < b->shape_count; i++) {
        const collider *s = &w->colliders.at[b->shapes[i]];
        b->reach = fmax(b->reach, s->reach + vec_norm(s->local.p));
    }
    b->travelled = nextafter(b->travelled + narrow_motion_bound(&b->travelled_to, &b->pose, b->reach), INFINITY);
    b->travelled_to = b->pose;
}

static double travelled(const body *a, const body *b)
{
    return a->travelled + b->travelled;
}

/* How far, at most, since `then` was the sum: both sums and their difference are rounded. */
static double travelled_since(double now, double then)
{
    return now - then + 0x1p-50 * now;
}

/* Their motion is quicker to look at than how far they got. */
bool bounds_stand(const world *w, const pair *p)
{
    const standing *s = &pair_more_of(w, p)->standing;
    if (s->epoch != w->epoch) return false;
    const collider *a = &w->colliders.at[p->a], *b = &w->colliders.at[p->b];
    const body *x = &w->bodies.at[a->body], *y = &w->bodies.at[b->body];
    if (p->jumped || p->ruled) return false;
    for (uint32_t id = p->first_watch; id != WORLD_NONE; id = w->watches.at[id].pair_next)
        if (w->watches.at[id].unknown) return false;
    if (travelled_since(travelled(x, y), s->travelled) <= s->slack) return true;
    pose b_in_a = collider_relative(w, a, b);
    return narrow_motion_bound(&s->b_in_a, &b_in_a, b->reach) <= s->slack;
}

/* The world axis along which the boxes are farthest from each other, from A to B; NAN where they have no end. */
static double apart_by_boxes(const collider *a, const collider *b, vec3 *axis)
{
    const double up[3] = {b->box.lo.x - a->box.hi.x, b->box.lo.y - a->box.hi.y, b->box.lo.z - a->box.hi.z};
    const double down[3] = {a->box.lo.x - b->box.hi.x, a->box.lo.y - b->box.hi.y, a->box.lo.z - b->box.hi.z};
    double most = -INFINITY, n[3] = {0, 0, 0};
    int best = 0;
    bool turned = false;
    for (int i = 0; i < 3; i++) {
        bool other = down[i] > up[i];
        double apart = other ? down[i] : up[i];
        if (!(apart > most)) continue;
        most = apart;
        best = i;
        turned = other;
    }
    n[best] = turned ? -1 : 1;
    *axis = quat_rotate(quat_conj(a->world.q), vec(n[0], n[1], n[2]));
    return most;
}

static void try_axis(const collider *a, const collider *b, const pose *b_in_a, vec3 axis, narrow_result *best)
{
    narrow_result r;
    if (vec_equal(axis, VEC_ZERO)) return;
    narrow_bounds(&a->shape, &b->shape, b_in_a, axis, &r);
    double hi = fmin(best->hi, r.hi);
    vec3 point_a = best->hi <= r.hi ? best->point_a : r.point_a, point_b = best->hi <= r.hi ? best->point_b : r.point_b;
    if (r.lo > best->lo) *best = r;
    best->hi = hi;
    best->point_a = point_a;
    best->point_b = point_b;
}

/* The nearest points of the last refinement are on the surfaces still. */
static void try_points(
    const collider *a, const collider *b, const pair_more *p, const pose *b_in_a, narrow_result *best)
{
    vec3 point_b = pose_point(*b_in_a, p->near_b);
    double scale = pair_size(a, b) + vec_norm(b_in_a->p), deviation = a->shape.deviation + b->shape.deviation;
    double hi = vec_norm(vec_sub(point_b, p->near_a)) + deviation + ROUNDING * scale;
    if (!(hi < best->hi)) return;
    best->hi = hi;
    best->point_a = p->near_a;
    best->point_b = point_b;
}

static void find_bounds(
    const world *w, const pair *p, const pose *b_in_a, bool remembers, void *scratch, narrow_result *r)
{
    const collider *a = &w->colliders.at[p->a], *b = &w->colliders.at[p->b];
    if (a->shape.type == SHAPE_HALFSPACE || b->shape.type == SHAPE_HALFSPACE) {
        narrow_request request = {.facts = NARROW_DISTANCE, .tolerance = SLACK * pair_size(a, b), .range = INFINITY};
        narrow_query(&a->shape, &b->shape, b_in_a, &request, NULL, scratch, r);
        return;
    }
    vec3 by_boxes;
    double boxes = apart_by_boxes(a, b, &by_boxes);
    *r = (narrow_result){.lo = -INFINITY, .hi = INFINITY};
    if (remembers) try_axis(a, b, b_in_a, p->cache.axis, r);
    vec3 guess = narrow_guess_axis(&a->shape, &b->shape, b_in_a);
    if (!(r->lo > 0)) try_axis(a, b, b_in_a, guess, r);
    if (boxes > r->lo || !isfinite(r->lo)) try_axis(a, b, b_in_a, vec_unit(by_boxes), r);
    r->lo = fmax(r->lo, boxes);
    const pair_more *more = pair_more_of(w, p);
    if (remembers && more->refined) try_points(a, b, more, b_in_a, r);
}

static void stand(const world *w, pair *p, const pose *b_in_a, double slack, narrow_result *r)
{
    const body *x = &w->bodies.at[w->colliders.at[p->a].body], *y = &w->bodies.at[w->colliders.at[p->b].body];
    r->lo -= slack;
    r->hi += slack;
    pair_more_make(w, p)->standing =
        (standing){.b_in_a = *b_in_a, .slack = slack, .lo = r->lo, .travelled = travelled(x, y), .epoch = w->epoch};
}

static double pair_error(const world *w, const pair *p)
{
    return collider_relative_error(w, &w->colliders.at[p->a], &w->colliders.at[p->b]);
}

/* One that is beyond the limit stays there as long as the bounds stand. The slack that they are to be widened by. */
static double measure_bounds(
    const world *w, const pair *p, const pose *b_in_a, double limit, bool remembers, void *scratch, narrow_result *r)
{
    find_bounds(w, p, b_in_a, remembers, scratch, r);
    double moved = 2 * pair_error(w, p); /* now, and in the tick when they are found to stand still */
    r->lo -= moved;
    r->hi += moved;
    double slack = (remembers ? SLACK_OF_BUDGET : SLACK) * pair_size(&w->colliders.at[p->a], &w->colliders.at[p->b]);
    if (remembers) slack = fmax(slack, SLACK_OF_GAP * r->lo);
    if (r->lo > limit) slack = fmin(slack, NEARLY * (r->lo - limit));
    return r->lo > limit && !(r->lo - slack > limit) ? 0 : slack;
}

void bounds_find(
    const world *w, pair *p, const pose *b_in_a, double limit, bool remembers, void *scratch, narrow_result *r)
{
    stand(w, p, b_in_a, measure_bounds(w, p, b_in_a, limit, remembers, scratch, r), r);
}

void bounds_ask(const world *w, const pair *p, const pose *b_in_a, double limit, void *scratch, narrow_result *r)
{
    double slack = measure_bounds(w, p, b_in_a, limit, false, scratch, r);
    r->lo -= slack;
    r->hi += slack;
}

/* Balls about their origins, or their boxes. No points: how near they are is not known. */
void bounds_floor(const world *w, pair *p, const pose *b_in_a, narrow_result *r)
{
    const collider *a = &w->colliders.at[p->a], *b = &w->colliders.at[p->b];
    double away = vec_norm(b_in_a->p), size = a->reach + b->reach;
    vec3 axis = vec_unit(b_in_a->p), by_boxes;
    double balls = away - size - ROUNDING * (away + size) - 2 * pair_error(w, p);
    double boxes = apart_by_boxes(a, b, &by_boxes);
    if (vec_equal(axis, VEC_ZERO) || boxes > balls) axis = vec_unit(by_boxes);
    *r = (narrow_result){.lo = fmax(balls, boxes),
        .hi = INFINITY,
        .axis = axis,
        .point_b = b_in_a->p,
        .status = NARROW_WIDE,
        .method = NARROW_BY_CLOSED_FORM};
    stand(w, p, b_in_a, SLACK * pair_size(a, b), r);
    pair_more_make(w, p)->standing.floor = true;
}
