/* A translation that parts two unions. Pure; any thread.
 *
 * Each overlapping pair of convex parts is parted by going `depth` along its axis n, and by all that goes at least as
 * far along n: a plane that bounds where B may go. The shortest way beyond all planes that are known is tried, the pair
 * that overlaps most there adds its own plane, and so on, until all pairs are proven apart. So a part that is wedged
 * between two finds its way out along neither one's axis. Not always the shortest way out, because each pair had other
 * planes to choose from: but a way, and where one pair is all that overlaps, the shortest. Where that leaves the
 * bracket wider than asked and all parts are polytopes, rounded or not, the search of union_depth.h narrows it from
 * both sides.
 */
#include "compound_pair.h"
#include "narrow/math/scalar.h"

enum { PLANES_MAX = 12, ROUNDS_MAX = 16, SWEEPS_MAX = 200 };

enum { GO_ON_ROUNDS = 6, SEARCH_WORK = 100000 };

/* Axes that are nearly across the direction of travel say little about how far it must go. */
static const double LEAST_SLOPE = 0.05;

/* Beyond what is needed, in errors of a separation: that a pair is apart must still be provable there. */
static const double CLEARANCE_ERRORS = 4;

typedef struct plane {
    vec3 normal;
    double level; /* dot(normal, translation) >= level */
    uint32_t part_a, part_b;
} plane;

typedef struct planes {
    uint32_t count;
    plane at[PLANES_MAX];
} planes;

/* Where B was moved to, and which pair overlaps most there. */
typedef struct trial {
    const planes *planes;
    narrow_scratch *scratch;
    narrow_result worst; /* lo <= 0 if any pair may overlap */
    uint32_t part_a, part_b;
    bool clear;
} trial;

/* By the only plane, along whose normal B has gone just as far as it asks: parted by construction. */
static bool is_parted(const planes *p, uint32_t part_a, uint32_t part_b)
{
    return p->count == 1 && p->at[0].part_a == part_a && p->at[0].part_b == part_b;
}

static bool still_overlaps(compound_walk *w, uint32_t part_a, uint32_t part_b, void *context)
{
    trial *t = context;
    const narrow_request request = {.facts = NARROW_DISTANCE, .range = 0, .tolerance = 1e-9 * w->size * w->unit};
    narrow_result r;
    if (is_parted(t->planes, part_a, part_b)) return true;
    compound_parts_query(w, part_a, part_b, &request, t->scratch, &r);
    if (r.lo > 0 || r.lo >= t->worst.lo) return true;
    t->clear = false;
    t->worst = r;
    t->part_a = part_a;
    t->part_b = part_b;
    return true;
}

/* The shortest vector that satisfies all planes, by coordinate ascent on the dual (Hildreth, "A quadratic programming
 * procedure", 1957). What it leaves open in the last digits, the next round finds. */
static vec3 shortest(const planes *p)
{
    double weight[PLANES_MAX] = {0};
    vec3 sum = VEC_ZERO;
    for (int sweep = 0; sweep < SWEEPS_MAX; sweep++) {
        double changed = 0, largest = 0;
        for (uint32_t i = 0; i < p->count; i++) {
            double short_by = p->at[i].level - vec_dot(p->at[i].normal, sum);
            double next = max_of(weight[i] + short_by, 0), step = next - weight[i];
            weight[i] = next;
            sum = vec_madd(sum, step, p->at[i].normal);
            changed = max_of(changed, fabs(step));
            largest = max_of(largest, next);
        }
        if (changed <= 0x1p-50 * largest) break;
    }
    return sum;
}

/* Of one pair only the newest plane counts: it may have to leave by another side. */
static bool add_plane(planes *p, plane next)
{
    uint32_t place = 0;
    while (place < p->count && (p->at[place].part_a != next.part_a || p->at[place].part_b != next.part_b)) place++;
    if (place == PLANES_MAX) return false;
    p->at[place] = next;
    if (place == p->count) p->count++;
    return true;
}

compound_way compound_way_out(
    compound_walk *w, const narrow_result *deepest, const uint32_t parts[2], narrow_scratch *scratch)
{
    const vec3 start = w->placed.t;
    const compound_way none = {deepest->axis, INFINITY};
    planes p = {1, {{deepest->axis, max_of(-deepest->lo, 0) * w->scale, parts[0], parts[1]}}};
    vec3 way = vec_scale(deepest->axis, p.at[0].level);
    trial t = {.clear = false};
    for (int round = 0; round < ROUNDS_MAX && !t.clear; round++) {
        if (vec_norm(way) > 4 * w->size) break; /* planes that contradict each other: there is no way beyond all */
        t = (trial){.planes = &p, .scratch = scratch, .worst = {.lo = INFINITY}, .clear = true};
        compound_walk_move(w, vec_add(start, way));
        compound_walk_run(w, 0, still_overlaps, &t);
        t.clear &= !w->cut;
        if (t.clear || w->cut) break;
        double more = (-t.worst.lo * w->scale) + CLEARANCE_ERRORS * w->error;
        plane next = {t.worst.axis, vec_dot(t.worst.axis, way) + more, t.part_a, t.part_b};
        if (!add_plane(&p, next)) break;
        way = shortest(&p);
    }
    compound_walk_move(w, start);
    if (!t.clear) return none;
    if (p.count == 1) return (compound_way){p.at[0].normal, p.at[0].level};
    return (compound_way){direction_of(way), vec_norm(way) + w->error};
}

/* ---- both sides ---- */

typedef struct way_search {
    compound_walk *w;
    narrow_scratch *scratch;
    vec3 start, direction;
    double rounding; /* the least of both sides' parts */
} way_search;

/* Where the search has come to: on from there, until all parts are proven to be apart. */
static double go_on_apart(void *context, vec3 way)
{
    way_search *q = context;
    compound_walk *w = q->w;
    const planes none = {.count = 0};
    double length = vec_norm(way) + q->rounding + CLEARANCE_ERRORS * w->error;
    if (!(vec_norm(way) > 0)) return INFINITY;
    vec3 direction = direction_of(way);
    for (int round = 0; round < GO_ON_ROUNDS && length < w->size; round++) {
        trial t = {.planes = &none, .scratch = q->scratch, .worst = {.lo = INFINITY}, .clear = true};
        compound_walk_move(w, vec_madd(q->start, length, direction));
        compound_walk_run(w, 0, still_overlaps, &t);
        if (t.clear) {
            q->direction = direction;
            return length - q->rounding;
        }
        double slope = max_of(vec_dot(t.worst.axis, direction), LEAST_SLOPE);
        length += (-t.worst.lo * w->scale + CLEARANCE_ERRORS * w->error) / slope;
    }
    return INFINITY;
}

static bool side_of_shape(
    union_side *side, const shape *s, const shape *scaled, double scale, const transform *place, double *rounding)
{
    *rounding = 0;
    if (s->type != SHAPE_COMPOUND) return s->type != SHAPE_MESH && union_side_init(side, scaled, scale, place);
    return union_side_of_children(side, s->compound, scale, place, rounding);
}

void compound_search_depth(const unit_pair *p, compound_walk *w, const shape *a, const shape *b, double asked,
    narrow_scratch *scratch, union_scratch *parts, narrow_result *out)
{
    double of_a, of_b, radius = p->radius;
    uint32_t work = effort_grant(w->effort, SEARCH_WORK, EFFORT_UNION);
    if (a->deviation + b->deviation > 0 || work == 0) return;
    if (!side_of_shape(&parts->a, a, &p->a, p->scale, NULL, &of_a)) return;
    if (!side_of_shape(&parts->b, b, &p->b, p->scale, &p->b_in_a, &of_b)) return;
    way_search q = {.w = w, .scratch = scratch, .start = w->placed.t, .rounding = radius + of_a + of_b};
    const narrow_goal goal = {.tolerance = asked * p->scale,
        .finest = asked * p->scale,
        .far = INFINITY,
        .near = -INFINITY,
        .above = -INFINITY,
        .below = INFINITY};
    double known = -out->lo * p->scale - q.rounding;
    union_bounds bounds = union_depth(parts, known, &goal, 4 * p->error, work, go_on_apart, &q);
    effort_spend(w->effort, bounds.work * (int64_t)EFFORT_UNION);
    compound_walk_move(w, q.start);
    if (bounds.length < known) {
        out->lo = -(bounds.length + q.rounding + w->error) * p->unit;
        out->axis = q.direction;
    }
    /* the ball of `least` is in the union of the differences of the cores: so is, rounded, one larger by that */
    if (bounds.least > 0) out->hi = min_of(out->hi, -(bounds.least + q.rounding - w->error) * p->unit);
}
