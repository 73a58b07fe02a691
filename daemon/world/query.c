/* query: answers about bodies by name: distance, poses, why a pair is looked at. As the last tick left the world.
 * Nothing is changed and no cache is used; called by the tick thread between ticks. */
#include "cascade.h"
#include "geom/compound.h"
#include "geom/mesh.h"
#include "state.h"
#include "subscription.h"

#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>

static bool alive(const world *w, uint32_t id)
{
    return id < w->bodies.count && w->bodies.at[id].used && !w->bodies.at[id].ghost;
}

static int64_t older(int64_t a, int64_t b)
{
    return a > b ? a : b;
}

/* ---- distance ---- */

/* From the relative pose that the cascade has, in canonical order: in the frame of the first. */
static narrow_result between(const world *w, uint32_t a, uint32_t b, double tolerance, bool *in_order)
{
    const collider *x = &w->colliders.at[a], *y = &w->colliders.at[b];
    *in_order = colliders_in_order(w, x, y);
    const collider *first = *in_order ? x : y, *second = *in_order ? y : x;
    narrow_request request = {
        .facts = NARROW_DISTANCE, .tolerance = tolerance, .range = INFINITY, .engine = w->options.engine};
    pose relative = collider_settled_relative(w, first, second);
    narrow_result r;
    narrow_query(&first->shape, &second->shape, &relative, &request, NULL, w->scratch[0], &r);
    cascade_allow_for_pose(w, first, second, &relative, tolerance, &r);
    return r;
}

/* In world axes, from A to B. */
static void write_hit(const world *w, uint32_t a, uint32_t b, const narrow_result *r, bool in_order, world_hit *hit)
{
    pose first = collider_pose(w, &w->colliders.at[in_order ? a : b]);
    vec3 axis = quat_rotate(first.q, r->axis), point_1 = pose_point(first, r->point_a),
         point_2 = pose_point(first, r->point_b);
    hit->lo = r->lo;
    hit->hi = r->hi;
    hit->axis = in_order ? axis : vec_neg(axis);
    hit->point_a = in_order ? point_1 : point_2;
    hit->point_b = in_order ? point_2 : point_1;
}

void world_query_distance(const world *w, uint32_t a, uint32_t b, double tolerance, int64_t now_ns, world_hits *out)
{
    if (!alive(w, a) || !alive(w, b)) return;
    const body *x = &w->bodies.at[a], *y = &w->bodies.at[b];
    if (x->soft || y->soft) return;
    world_hit best = {.body_a = a, .body_b = b, .name_a = x->name, .shape_a = -1, .lo = INFINITY, .hi = INFINITY};
    double least_lo = INFINITY;
    for (size_t i = 0; i < x->shape_count; i++) {
        for (size_t k = 0; k < y->shape_count && world_may_go_on(out); k++) {
            bool in_order;
            narrow_result r = between(w, x->shapes[i], y->shapes[k], tolerance, &in_order);
            least_lo = fmin(least_lo, r.lo);
            if (r.hi < best.hi || (r.hi == best.hi && r.lo < best.lo))
                write_hit(w, x->shapes[i], y->shapes[k], &r, in_order, &best);
        }
    }
    best.lo = fmin(best.lo, least_lo);
    best.age_ns = older(body_age_at(x, now_ns), body_age_at(y, now_ns));
    best.stale = x->stale || y->stale;
    array_push(out, best);
}

/* ---- bodies ---- */

bool world_glance_at(const world *w, uint32_t id, world_glance *out)
{
    if (id >= w->bodies.count || !w->bodies.at[id].used || w->bodies.at[id].ghost || w->bodies.at[id].goes)
        return false;
    const body *b = &w->bodies.at[id];
    *out = (world_glance){.pose = &b->pose,
        .fixed = b->fixed,
        .stale = b->stale,
        .held = b->held,
        .pending = b->is_due,
        .swept = b->ccd != WORLD_CCD_OFF,
        .one_way = b->one_way};
    return true;
}

bool world_pattern_matches(const char *text, const char *name, const char *group)
{
    pattern p;
    pattern_init(&p, text);
    bool matches = pattern_matches(&p, name, group);
    pattern_free(&p);
    return matches;
}

void world_query_bodies(const world *w, const char *pattern_text, int64_t now_ns, world_hits *out)
{
    pattern ready;
    pattern_init(&ready, pattern_text);
    for (uint32_t id = 0; id < w->bodies.count; id++) {
        const body *b = &w->bodies.at[id];
        if (id % 256 == 0 && !world_may_go_on(out)) break;
        if (!alive(w, id) || !pattern_matches(&ready, b->name, b->group)) continue;
        if (out->most && out->count == out->most) {
            out->left_out++;
            continue;
        }
        array_push(out, ((world_hit){.body_a = id,
                            .body_b = WORLD_NONE,
                            .name_a = b->name,
                            .shape_a = -1,
                            .point_a = b->pose.p,
                            .stale = b->stale,
                            .age_ns = body_age_at(b, now_ns)}));
    }
    pattern_free(&ready);
}

/* ---- explain ---- */

typedef struct lines {
    char *text;
    size_t size;
    int length;
} lines;

static void line(lines *l, const char *format, ...) __attribute__((format(printf, 2, 3)));
static void line(lines *l, const char *format, ...)
{
    va_list args;
    va_start(args, format);
    size_t used = (size_t)l->length < l->size ? (size_t)l->length : l->size;
    l->length += vsnprintf(l->text + used, l->size - used, format, args);
    va_end(args);
}

static void explain_subscriptions(const world *w, const body *x, const body *y, lines *l)
{
    bool any = false;
    for (uint32_t id = 0; id < w->subscriptions.count; id++) {
        const subscription *i = &w->subscriptions.at[id];
        subscription_sides sides = subscription_sides_of(w, id, x, y);
        if (!i->used || !(sides.straight || sides.turned)) continue;
        any = true;
        line(l, "wanted by subscription %u: \"%s\" against \"%s\",%s%s%s tolerance %g %s%s\n", id, i->select_a,
            i->select_b, i->facts & WORLD_TOUCH ? " touch," : "", i->facts & WORLD_MANIFOLD ? " manifold," : "",
            i->facts & WORLD_DISTANCE ? " distance," : "", i->tolerance > 0 ? i->tolerance : i->relative_tolerance,
            i->tolerance > 0 ? "m" : "of the size",
            i->accuracy == WORLD_BY_BOXES     ? ", by boxes"
            : i->accuracy == WORLD_BY_VERDICT ? ", by verdict"
                                              : "");
    }
    if (!any) line(l, "nobody is interested in it: it is not looked at\n");
}

typedef struct kind_text {
    char text[512];
} kind_text;

static kind_text kind_of(const shape *s)
{
    kind_text kind;
    const mesh *m = s->type == SHAPE_MESH ? s->mesh : NULL;
    if (m && m->rows)
        snprintf(kind.text, sizeof kind.text, "height field, %u x %u", m->rows, m->columns);
    else if (m)
        mesh_describe(m, kind.text + snprintf(kind.text, sizeof kind.text, "mesh, "), sizeof kind.text - 6);
    else if (s->type == SHAPE_COMPOUND)
        snprintf(kind.text, sizeof kind.text, "compound of %u", s->compound->child_count);
    else
        snprintf(kind.text, sizeof kind.text, "%s", shape_type_name(s->type));
    return kind;
}

static void explain_shapes(const world *w, const body *x, const body *y, world_hits *patience, lines *l)
{
    for (size_t i = 0; i < x->shape_count; i++) {
        for (size_t k = 0; k < y->shape_count; k++) {
            if (!world_may_go_on(patience)) {
                line(l, "%zu more pairs of shapes are not looked into: it took too long\n",
                    (x->shape_count - i) * y->shape_count - k);
                return;
            }
            const collider *a = &w->colliders.at[x->shapes[i]], *b = &w->colliders.at[y->shapes[k]];
            bool in_order;
            narrow_result r = between(w, x->shapes[i], y->shapes[k], 1e-9, &in_order);
            bool paired = pair_find(w, x->shapes[i], y->shapes[k]) != PAIR_MAP_NONE;
            const char *unpaired = w->figures.pairs_left_out
                                       ? "are apart, or the pair is not looked at (max_pairs, memory_limit)"
                                       : "are apart, or the pair is not looked at";
            line(l, "shape %zu (%s) and shape %zu (%s): signed distance in [%.9g, %.9g] m by %s; fat boxes %s\n", i,
                kind_of(&a->shape).text, k, kind_of(&b->shape).text, r.lo, r.hi, narrow_method_name(r.method),
                paired ? "meet" : unpaired);
        }
    }
}

int world_explain(const world *w, uint32_t a, uint32_t b, int64_t now_ns, char *text, size_t size)
{
    world_hits all = {.at = NULL};
    return world_explain_within(w, a, b, now_ns, &all, text, size);
}

int world_explain_within(
    const world *w, uint32_t a, uint32_t b, int64_t now_ns, world_hits *patience, char *text, size_t size)
{
    lines l = {text, size, 0};
    if (!alive(w, a) || !alive(w, b)) return 0;
    const body *x = &w->bodies.at[a], *y = &w->bodies.at[b];
    pair_terms terms = pair_get_terms(w, x, y);
    line(&l, "%s and %s: %s, %s\n", x->name, y->name, terms.checked ? "checked" : "not checked", terms.why);
    if (terms.rule)
        line(&l, "decided by the rule \"%s\": %s%s%s\n", terms.rule->pattern, terms.rule->allow ? "allow" : "check",
            *terms.rule->reason ? ", reason: " : "", terms.rule->reason);
    if (terms.checked && terms.looks)
        line(&l, "one way: %s looks at %s\n", terms.looks > 0 ? x->name : y->name, terms.looks > 0 ? y->name : x->name);
    if (terms.padding != 0 || terms.margin != 0)
        line(&l, "rules add %g m to the threshold and %g m to the range of every subscription\n", terms.padding,
            terms.margin);
    explain_subscriptions(w, x, y, &l);
    for (int i = 0; i < 2; i++) {
        const body *one = i ? y : x;
        if (one->stale)
            line(&l, "%s is unknown: its pose is %s\n", one->name,
                one->held ? "held, its owner is lost" : "past its deadline");
        else if (!one->fixed && one->stamp_ns)
            line(&l, "%s: pose is %.3f s old\n", one->name, (double)(now_ns - one->stamp_ns) * 1e-9);
    }
    if (x->is_due || y->is_due || x->is_parked || y->is_parked)
        line(&l,
            "pending: more pairs have changed than a tick decides; what was reported stands until it is their turn\n");
    if (x->soft || y->soft)
        line(&l, "%s is soft: what meets it on its way is told step by step\n", x->soft ? x->name : y->name);
    else
        explain_shapes(w, x, y, patience, &l);
    return l.length;
}
