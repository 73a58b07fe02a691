/* cut: candidates are planes along the axes: where an edge at which the solid is not convex begins or ends, and some at
 * even steps. Beside such an edge, not at it: then a face in the plane belongs to one part alone. */
#include "cut.h"

#include "deviate.h"
#include "vec3.h"

#include <stdlib.h>

enum { STEPS = 5, EDGES_MOST = 10, CANDIDATES_MAX = STEPS + 2 * EDGES_MOST, GLANCE_STEPS = 60 };
static const double BESIDE = 0x1p-24;   /* of the greatest coordinate */
static const double PREFERENCE = 0.002; /* what decides between cuts that are about equally good */

static int by_number(const void *left, const void *right)
{
    double a = *(const double *)left, b = *(const double *)right;
    return (a > b) - (a < b);
}

static bool meets(const piece *p, const solid_edge *e)
{
    for (int k = 0; k < 3; k++)
        if (e->hi[k] < p->lo[k] || e->lo[k] > p->hi[k]) return false;
    return true;
}

/* The places of edges along the axis, sorted, each once; evenly chosen if there are many. */
static size_t edge_places(const solid *s, const piece *p, int axis, double *out)
{
    pool work = {0};
    double *all = pool_alloc(&work, 2 * s->reflex_count, sizeof *all), apart = 16 * BESIDE * s->most;
    size_t count = 0, kept = 0;
    for (size_t i = 0; i < s->reflex_count; i++) {
        if (!meets(p, &s->reflex[i])) continue;
        all[count++] = s->reflex[i].lo[axis];
        all[count++] = s->reflex[i].hi[axis];
    }
    qsort(all, count, sizeof *all, by_number);
    for (size_t i = 0; i < count; i++) {
        bool within = all[i] > p->lo[axis] + apart && all[i] < p->hi[axis] - apart;
        if (within && (kept == 0 || all[i] > all[kept - 1] + apart)) all[kept++] = all[i];
    }
    size_t most = kept < EDGES_MOST ? kept : EDGES_MOST;
    for (size_t i = 0; i < most; i++) out[i] = all[(2 * i + 1) * kept / (2 * most)];
    pool_free(&work);
    return most;
}

static size_t candidates(const solid *s, const piece *p, int axis, double *out)
{
    double edges[EDGES_MOST];
    size_t count = edge_places(s, p, axis, edges), n = 0;
    for (size_t i = 0; i < count; i++) {
        out[n++] = edges[i] - BESIDE * s->most;
        out[n++] = edges[i] + BESIDE * s->most;
    }
    for (int i = 1; i <= STEPS; i++) out[n++] = p->lo[axis] + (p->hi[axis] - p->lo[axis]) * i / (STEPS + 1);
    return n;
}

/* A distance that occurs in it, about the farthest. */
static double misfit(const solid *s, piece *p, double floor)
{
    deviate_effort effort = {.ratio = 0.2, .floor = floor, .steps = GLANCE_STEPS};
    return deviate_find(s, p, &effort);
}

/* How far and how much the parts' hulls reach beyond the solid, against the whole's; between equals the plane that is
 * nearest to the whole's farthest point, and edges before even steps. */
static double score_of(const solid *s, const piece *from, piece *below, piece *above, int axis, double at, bool even)
{
    double floor = from->deviation / 16;
    double far = fabs(at - from->farthest[axis]) / distance3(from->lo, from->hi);
    return (misfit(s, below, floor) + misfit(s, above, floor)) / from->deviation +
           (below->volume + above->volume) / from->volume + PREFERENCE * (far + even);
}

bool cut_best(const solid *s, const piece *from, piece *below, piece *above)
{
    double best = INFINITY, places[CANDIDATES_MAX], best_place = 0;
    int best_axis = -1;
    for (int axis = 0; axis < 3; axis++) {
        size_t count = candidates(s, from, axis, places);
        for (size_t i = 0; i < count; i++) {
            bool sound = piece_cut(s, from, axis, places[i], false, below);
            if (piece_cut(s, from, axis, places[i], true, above) && sound) {
                double score = score_of(s, from, below, above, axis, places[i], i + STEPS >= count);
                if (score < best) best = score, best_axis = axis, best_place = places[i];
            }
            piece_free(below);
            piece_free(above);
        }
    }
    if (best_axis < 0) return false;
    piece_cut(s, from, best_axis, best_place, false, below);
    piece_cut(s, from, best_axis, best_place, true, above);
    return true;
}
