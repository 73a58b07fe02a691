/* fit_link: one shape around all, else each shape by itself, else a mesh in pieces; what is cheapest by fit_cost.h. */
#include "fit_link.h"

#include "fit_cost.h"
#include "fit_excess.h"
#include "fit_truth.h"
#include "loaders/decompose/decompose.h"
#include "loaders/decompose/solid_make.h"

#include <math.h>
#include <string.h>

enum { PIECES_MAX = 16, CANDIDATES_MAX = 6 };

typedef struct choice {
    load_shape *shapes;
    size_t count;
    double excess_m, volume, ns;
} choice;

static void join(pool *p, choice *to, const choice *part)
{
    load_shape *all = pool_alloc(p, to->count + part->count, sizeof *all);
    if (to->count > 0) memcpy(all, to->shapes, to->count * sizeof *all);
    memcpy(all + to->count, part->shapes, part->count * sizeof *all);
    *to = (choice){
        all, to->count + part->count, fmax(to->excess_m, part->excess_m), to->volume + part->volume, to->ns + part->ns};
}

typedef struct simple { /* shapes around a hull that are the same for any excess, cheapest kind first */
    fit_shape all[4];
    int count;
} simple;

static bool below(collided_shape_type kind, double limit_ns)
{
    const load_shape least = {.shape.type = kind, .points.count = 4};
    return fit_cost_ns(&least) < limit_ns;
}

/* Those of the kinds that cost less than `limit_ns`. */
static void find_simple(const fit_hull *h, double limit_ns, simple *out)
{
    out->count = 0;
    if (below(COLLIDED_SPHERE, limit_ns)) fit_sphere(h, &out->all[out->count++]);
    if (below(COLLIDED_CAPSULE, limit_ns)) fit_capsule(h, &out->all[out->count++]);
    if (!below(COLLIDED_BOX, limit_ns)) return;
    fit_shape *box = &out->all[out->count];
    fit_box(h, box);
    fit_rounded_box(h, box, box + 1);
    out->count += 2;
}

/* The cheapest shape around the hull, below the limit, and of equally cheap ones that which fits best. The hull's
 * points are at most `own` outside of the link, and the link's at most `outside` of the hull. */
static bool cheapest(pool *p, const fit_hull *h, const simple *known, double own, double outside, double excess_m,
    double limit_ns, choice *out)
{
    fit_shape all[CANDIDATES_MAX], *best = NULL;
    double room = excess_m - own - outside, best_ns = limit_ns;
    int count = known->count;
    memcpy(all, known->all, sizeof known->all);
    if (below(COLLIDED_HULL, limit_ns)) {
        count += fit_rounded_hull(p, h, room - 4 * h->slack, &all[count]);
        fit_whole_hull(h, &all[count++]);
    }
    for (int i = 0; i < count; i++) {
        double ns = fit_cost_ns(&all[i].shape);
        if (!(all[i].excess_m <= room) || ns > best_ns || ns >= limit_ns) continue;
        if (best && ns == best_ns && all[i].excess_m >= best->excess_m) continue;
        best = &all[i];
        best_ns = ns;
    }
    if (!best) return false;
    load_shape *shape = pool_alloc(p, 1, sizeof *shape);
    *shape = best->shape;
    shape->shape.radius += outside;
    shape->shape.deviation = best->excess_m + own + outside;
    *out = (choice){shape, 1, shape->shape.deviation, best->volume, best_ns};
    return true;
}

/* One shape around everything. How far the hull itself reaches beyond the link is only asked where something that costs
 * less than the limit would do for the hull. */
static bool around_all(pool *p, const fit_truth *t, double excess_m, double limit_ns, choice *out)
{
    pool work = {0};
    fit_hull h;
    simple known;
    bool found = fit_hull_make(p, t->outer, t->outer_count, &h);
    if (found) {
        find_simple(&h, limit_ns, &known);
        found = cheapest(&work, &h, &known, 0, 0, excess_m, limit_ns, out);
    }
    if (found) {
        solid s;
        solid_make(&work, &t->inner, &s);
        double own = fit_excess_of_hull(&s, &h, excess_m);
        found = own < excess_m && cheapest(p, &h, &known, own, 0, excess_m, limit_ns, out);
    }
    pool_free(&work);
    return found;
}

static bool in_pieces(pool *p, const fit_truth *t, double excess_m, choice *out)
{
    pool work = {0};
    decomposition d;
    decompose_options o = {PIECES_MAX, excess_m / 2, "mesh"};
    load_report quiet = {0};
    bool good = decompose_mesh(&work, &t->inner, &o, &d, &quiet) && d.closed;
    *out = (choice){0};
    for (size_t i = 0; good && i < d.count; i++) {
        fit_hull h;
        choice one;
        simple known;
        double own = d.hulls[i].deviation_m;
        good = own < excess_m && fit_hull_make(p, d.hulls[i].points.at, d.hulls[i].points.count, &h);
        if (!good) break;
        find_simple(&h, INFINITY, &known);
        good = cheapest(p, &h, &known, own, d.radius, excess_m, INFINITY, &one);
        if (good) join(p, out, &one);
    }
    pool_free(&work);
    return good;
}

static bool is_simple(const load_shape *s)
{
    return s->shape.type != COLLIDED_MESH;
}

static void keep(pool *p, const load_shape *s, choice *out)
{
    load_shape *own = pool_alloc(p, 1, sizeof *own);
    *own = *s;
    *out = (choice){own, 1, 0, 0, fit_cost_ns(s)};
}

/* By itself; a mesh that no convex shape fits in pieces, if that is cheaper than the mesh. */
static fit_how one_shape(pool *p, const load_shape *s, double excess_m, choice *out)
{
    fit_truth t;
    choice other;
    fit_how how = is_simple(s) ? FIT_AS_IT_WAS : FIT_MESH;
    keep(p, s, out);
    if (!fit_truth_of(p, s, 1, &t)) return how;
    if (around_all(p, &t, excess_m, out->ns, &other)) {
        *out = other;
        return FIT_EACH;
    }
    if (how == FIT_AS_IT_WAS || !in_pieces(p, &t, excess_m, &other) || other.ns >= out->ns) return how;
    *out = other;
    return FIT_PIECES;
}

static fit_how worse(fit_how a, fit_how b)
{
    return a > b ? a : b;
}

/* Hulls around what there is, tighter than the fit where that costs little: for the proof that links never meet. */
static void find_convex(pool *p, fit_link *f)
{
    f->convex = pool_alloc(p, f->before_count + f->shape_count, sizeof *f->convex);
    for (size_t i = 0; i < f->before_count; i++) {
        const load_shape *s = &f->before[i];
        fit_truth t;
        fit_hull h;
        fit_shape few;
        load_shape *to = &f->convex[f->convex_count++];
        *to = *s;
        if (s->shape.type == COLLIDED_SPHERE || s->shape.type == COLLIDED_CAPSULE) continue;
        if (!fit_truth_of(p, s, 1, &t) || !fit_hull_make(p, t.outer, t.outer_count, &h)) {
            f->convex_count = 0; /* nothing is proven of this link */
            return;
        }
        if (!fit_rounded_hull(p, &h, 0x1p-9 * fit_hull_diagonal(&h), &few)) fit_whole_hull(&h, &few);
        *to = few.shape;
    }
    if (f->how != FIT_PIECES || f->before_count != 1) return;
    memcpy(f->convex, f->shapes, f->shape_count * sizeof *f->convex);
    f->convex_count = f->shape_count;
}

void fit_link_make(pool *p, const load_body *body, double excess_m, fit_link *out)
{
    *out = (fit_link){.name = body->name, .before = body->shapes, .before_count = body->shape_count};
    choice each = {0}, one;
    fit_truth t;
    for (size_t i = 0; i < body->shape_count; i++) {
        choice part;
        out->how = worse(out->how, one_shape(p, &body->shapes[i], excess_m, &part));
        join(p, &each, &part);
        out->ns_before += fit_cost_ns(&body->shapes[i]);
    }
    if (each.count > LOAD_SHAPES_MAX) {
        out->how = FIT_AS_IT_WAS;
        out->note = pool_format(p, "its pieces would be %zu shapes, and a body has at most %d: it stays as it was",
            each.count, LOAD_SHAPES_MAX);
        each = (choice){pool_alloc(p, body->shape_count, sizeof *each.shapes), body->shape_count, 0, 0, out->ns_before};
        memcpy(each.shapes, body->shapes, body->shape_count * sizeof *each.shapes);
    }
    bool several = body->shape_count > 1 && fit_truth_of(p, body->shapes, body->shape_count, &t);
    if (several && around_all(p, &t, excess_m, each.ns, &one)) {
        out->how = FIT_ONE;
        out->note = NULL;
        each = one;
    }
    if (out->how == FIT_EACH && body->shape_count == 1) out->how = FIT_ONE;
    if (out->how == FIT_MESH)
        out->note = "no convex shape, and no pieces, are proven to be within the excess: the mesh stays";
    out->shapes = each.shapes;
    out->shape_count = each.count;
    out->excess_m = each.excess_m;
    out->volume = each.volume;
    out->ns = each.ns;
    find_convex(p, out);
}
