/* decompose: cuts the worst piece until all are good or there are twice as many as asked for, then unites the pairs
 * that fit best. One thread a pool. */
#include "decompose.h"

#include "cut.h"
#include "deviate.h"
#include "solid_make.h"
#include "vec3.h"

#include <stdio.h>

enum { SEARCH_STEPS = 1500, GLANCE_STEPS = 60, PAIR_STEPS = 400, FINAL_STEPS = 30000, SPARE = 2 };

typedef struct work {
    const solid *s;
    double target;
    piece pieces[SPARE * DECOMPOSE_PIECES_MAX + 1];
    bool whole[SPARE * DECOMPOSE_PIECES_MAX + 1]; /* it cannot be cut any further */
    size_t count;
    double cost[SPARE * DECOMPOSE_PIECES_MAX]
               [SPARE * DECOMPOSE_PIECES_MAX]; /* deviation of the two as one; [i][k], i < k */
} work;

static double estimate(const work *w, piece *p, size_t steps)
{
    deviate_effort effort = {.ratio = 0.1, .floor = w->target, .steps = steps};
    return deviate_find(w->s, p, &effort);
}

/* ---- cutting ---- */

static size_t worst(const work *w)
{
    size_t index = w->count;
    double most = w->target;
    for (size_t i = 0; i < w->count; i++)
        if (!w->whole[i] && w->pieces[i].deviation > most) index = i, most = w->pieces[i].deviation;
    return index;
}

static void cut_until(work *w, size_t most)
{
    while (w->count < most) {
        size_t i = worst(w);
        if (i == w->count) return;
        piece below, above;
        if (!cut_best(w->s, &w->pieces[i], &below, &above)) {
            w->whole[i] = true;
            continue;
        }
        estimate(w, &below, SEARCH_STEPS);
        estimate(w, &above, SEARCH_STEPS);
        piece_free(&w->pieces[i]);
        w->pieces[i] = below;
        w->pieces[w->count++] = above;
    }
}

/* ---- uniting ---- */

/* Roughly: what the search finds in a few steps; more of them where the two may be good enough as one. */
static double cost_of(const work *w, size_t i, size_t k)
{
    piece both;
    double cost = INFINITY;
    if (piece_unite(&w->pieces[i], &w->pieces[k], &both)) {
        if (estimate(w, &both, GLANCE_STEPS) <= w->target) estimate(w, &both, PAIR_STEPS);
        cost = both.deviation;
    }
    piece_free(&both);
    return cost;
}

static void unite_pieces(work *w, size_t i, size_t k)
{
    piece both;
    piece_unite(&w->pieces[i], &w->pieces[k], &both);
    estimate(w, &both, SEARCH_STEPS);
    piece_free(&w->pieces[i]);
    piece_free(&w->pieces[k]);
    size_t last = --w->count;
    w->pieces[i] = both;
    w->pieces[k] = w->pieces[last];
    for (size_t j = 0; j < last; j++) { /* the last one's costs move with it */
        if (j < k) w->cost[j][k] = w->cost[j][last];
        if (j > k) w->cost[k][j] = w->cost[j][last];
    }
    for (size_t j = 0; j < w->count; j++)
        if (j != i) w->cost[j < i ? j : i][j < i ? i : j] = cost_of(w, j < i ? j : i, j < i ? i : j);
}

/* While there are too many, or while two can be one that is good enough. */
static void unite_down(work *w, size_t most)
{
    for (size_t k = 1; k < w->count; k++)
        for (size_t i = 0; i < k; i++) w->cost[i][k] = cost_of(w, i, k);
    while (w->count > 1) {
        size_t first = 0, second = 1;
        for (size_t k = 1; k < w->count; k++)
            for (size_t i = 0; i < k; i++)
                if (w->cost[i][k] < w->cost[first][second]) first = i, second = k;
        if (w->count <= most && w->cost[first][second] > w->target) return;
        unite_pieces(w, first, second);
    }
}

/* ---- the whole ---- */

static void hand_out(pool *p, work *w, decomposition *out)
{
    deviate_effort effort = {.ratio = 0.01, .floor = DECOMPOSE_FINE_RATIO * w->s->diagonal, .steps = FINAL_STEPS};
    out->hulls = pool_alloc(p, w->count, sizeof *out->hulls);
    for (; out->count < w->count; out->count++) {
        piece *from = &w->pieces[out->count];
        deviate_find(w->s, from, &effort);
        double *points = pool_alloc(p, from->point_count, 3 * sizeof *points);
        memcpy(points, from->points, 3 * from->point_count * sizeof *points);
        out->hulls[out->count] =
            (decompose_hull){.points = {points, from->point_count}, .deviation_m = from->deviation};
        out->deviation_m = fmax(out->deviation_m, from->deviation);
    }
}

static bool decompose_solid(pool *p, work *w, const decompose_options *o, decomposition *out, load_report *r)
{
    size_t most = o->pieces_max ? o->pieces_max : DECOMPOSE_PIECES_DEFAULT;
    if (most > DECOMPOSE_PIECES_MAX) most = DECOMPOSE_PIECES_MAX;
    w->target = o->deviation_m > 0 ? o->deviation_m : DECOMPOSE_FINE_RATIO * w->s->diagonal;
    w->count = 1;
    if (!piece_of_all(w->s, &w->pieces[0])) return load_fail(r, "%s: is flat: it has no hull", o->name);
    if (w->s->closed && most > 1) {
        estimate(w, &w->pieces[0], SEARCH_STEPS);
        cut_until(w, SPARE * most);
        unite_down(w, most);
    }
    hand_out(p, w, out);
    return true;
}

bool decompose_mesh(
    pool *p, const mesh_triangles *mesh, const decompose_options *options, decomposition *out, load_report *r)
{
    *out = (decomposition){0};
    if (mesh->count > DECOMPOSE_TRIANGLES_MAX)
        return load_fail(r, "%s: has %zu triangles; at most %d can be decomposed: simplify the mesh, or load its hull",
            options->name, mesh->count, DECOMPOSE_TRIANGLES_MAX);
    pool memory = {0};
    solid s;
    solid_make(&memory, mesh, &s);
    work *w = pool_alloc(&memory, 1, sizeof *w);
    w->s = &s;
    if (!s.closed) load_warn(r, "%s: is not closed, so it has no inside to cut: it becomes one hull", options->name);
    bool ok = decompose_solid(p, w, options, out, r);
    out->closed = s.closed;
    out->united = s.united;
    out->dropped = s.dropped;
    out->radius = piece_slack(&s);
    for (size_t i = 0; i < w->count; i++) piece_free(&w->pieces[i]);
    pool_free(&memory);
    return ok;
}
