/* deviate: branch and bound over boxes in the piece, the most promising first.
 *
 * Each box has a bound of how far its points that belong to the piece are from the solid, the least of these:
 * 1. The distance is 1-Lipschitz: that of the centre plus the box's radius; a centre that is inside by more than the
 *    radius settles the box.
 * 2. The distance from one point of the solid, the one nearest to the centre, is greatest at a corner.
 * 3. Where the solid is convex nearby: let x be in the box, y the nearest point of the solid, T the triangles that can
 *    contain y, with unit normals n. x - y = sum a n over some of T, all a >= 0. If no point of the box in the piece is
 *    higher than h above the planes of T, then |x - y|^2 = sum a (n . (x - y)) <= h sum a; and with a unit vector m and
 *    k = min m . n > 0, k sum a <= m . (x - y) <= |x - y|. So |x - y| <= h / k. Heights are bounded by the piece's
 *    planes.
 * 4. Where no triangle nearby is below the plane of one of them, T, behind which the solid is: all that is nearby and
 *    below the plane is solid, so the height above that plane bounds the distance.
 * The last two settle the large parts where hull and solid are the same but for rounding. */
#include "deviate.h"

#include "overhang.h"
#include "solid_tree.h"
#include "vec3.h"

enum { NEAR_MOST = 48, STEP_WORK = 2000 /* a place and a plane of overhang.h, of which a step takes as long */ };
static const double AGREE = 0.25; /* least k of bound 3 */

typedef struct cell {
    double centre[3], half[3];
    double bound;
} cell;

typedef struct search {
    const solid *s;
    const piece *p;
    cell *heap; /* the greatest bound first */
    size_t count;
    double best, settled; /* a distance that occurs; the greatest bound of what was laid aside */
    double farthest[3];
    double enough; /* bounds up to it need no further look */
    double rounding;
} search;

static void push(search *q, const cell *c)
{
    size_t i = q->count++;
    for (; i > 0 && q->heap[(i - 1) / 2].bound < c->bound; i = (i - 1) / 2) q->heap[i] = q->heap[(i - 1) / 2];
    q->heap[i] = *c;
}

static cell pop(search *q)
{
    cell top = q->heap[0], last = q->heap[--q->count];
    size_t i = 0;
    for (size_t child; (child = 2 * i + 1) < q->count; i = child) {
        if (child + 1 < q->count && q->heap[child + 1].bound > q->heap[child].bound) child++;
        if (q->heap[child].bound <= last.bound) break;
        q->heap[i] = q->heap[child];
    }
    q->heap[i] = last;
    return top;
}

/* Greatest normal . x over the box. */
static double box_support(const cell *c, const double normal[3])
{
    return dot3(normal, c->centre) + fabs(normal[0]) * c->half[0] + fabs(normal[1]) * c->half[1] +
           fabs(normal[2]) * c->half[2];
}

static bool in_piece(const search *q, const double x[3])
{
    for (size_t i = 0; i < q->p->plane_count; i++)
        if (dot3(q->p->planes[i].normal, x) > q->p->planes[i].offset) return false;
    return true;
}

static bool meets_piece(const search *q, const cell *c)
{
    for (size_t i = 0; i < q->p->plane_count; i++) {
        double minus[3] = {-q->p->planes[i].normal[0], -q->p->planes[i].normal[1], -q->p->planes[i].normal[2]};
        if (-box_support(c, minus) > q->p->planes[i].offset + q->rounding) return false;
    }
    return true;
}

/* No point of the box in the piece is farther than this along the normal: normal = that of a plane + a rest. */
static double support_in_piece(const search *q, const cell *c, const double normal[3])
{
    double least = box_support(c, normal);
    for (size_t i = 0; i < q->p->plane_count; i++) {
        double rest[3];
        sub3(normal, q->p->planes[i].normal, rest);
        double support = q->p->planes[i].offset + box_support(c, rest);
        least = support < least ? support : least;
    }
    return least;
}

/* No point of the box in the piece is higher above the triangle's plane. */
static double height_above(const search *q, const cell *c, const solid_triangle *t)
{
    return fmax(support_in_piece(q, c, t->normal) - dot3(t->normal, t->at[0]), 0);
}

/* Bound 3, or INFINITY where it does not apply. */
static double bound_where_convex(const search *q, const cell *c, const solid_triangle *const *near, int count)
{
    double mean[3] = {0, 0, 0}, agree = INFINITY, height = 0;
    for (int i = 0; i < count; i++) {
        if (near[i]->bent) return INFINITY;
        along3(mean, 1, near[i]->normal, mean);
    }
    double length = norm3(mean);
    for (int i = 0; i < count; i++) agree = fmin(agree, dot3(mean, near[i]->normal));
    if (!(agree >= AGREE * length) || !(length > 0)) return INFINITY;
    for (int i = 0; i < count; i++) height = fmax(height, height_above(q, c, near[i]));
    return height / AGREE;
}

static bool all_above(const solid_triangle *plane, const solid_triangle *const *near, int count, double rounding)
{
    for (int i = 0; i < count; i++)
        for (int k = 0; k < 3; k++) {
            double way[3];
            sub3(near[i]->at[k], plane->at[0], way);
            if (dot3(plane->normal, way) < -rounding) return false;
        }
    return true;
}

/* Bound 4, or INFINITY. */
static double bound_beside_plane(const search *q, const cell *c, const solid_triangle *const *near, int count)
{
    double least = INFINITY;
    for (int i = 0; i < count; i++)
        if (near[i]->backed && all_above(near[i], near, count, q->rounding))
            least = fmin(least, height_above(q, c, near[i]) + q->rounding);
    return least;
}

/* Bounds 3 and 4. `reach` from the centre is where the points nearest to those of the box are. */
static double bound_by_planes(const search *q, const cell *c, double reach)
{
    const solid_triangle *near[NEAR_MOST];
    int count = solid_within(q->s, c->centre, reach, near, NEAR_MOST);
    if (count <= 0) return INFINITY;
    double bound = fmin(bound_where_convex(q, c, near, count), bound_beside_plane(q, c, near, count));
    return bound + (q->rounding + 0x1p-26 * reach) / AGREE;
}

static double corner_distance(const cell *c, const double x[3])
{
    double sum = 0;
    for (int k = 0; k < 3; k++) {
        double d = fabs(c->centre[k] - x[k]) + c->half[k];
        sum += d * d;
    }
    return sqrt(sum);
}

/* False if nothing in the box can be farther than what is settled or known. */
static bool bound_cell(search *q, cell *c)
{
    double nearest[3], radius = norm3(c->half);
    if (!meets_piece(q, c)) return false;
    double away = solid_nearest(q->s, c->centre, nearest);
    bool inside = q->s->closed && away > q->rounding && solid_side(q->s, c->centre) == SOLID_INSIDE;
    if (inside && away > radius + q->rounding) return false;
    double outside = inside ? 0 : away;
    c->bound = inside ? radius - away : fmin(away + radius, corner_distance(c, nearest));
    if (outside > q->best && in_piece(q, c->centre)) {
        q->best = outside;
        memcpy(q->farthest, c->centre, sizeof q->farthest);
    }
    if (c->bound > q->enough && c->bound > q->best && q->s->closed && away < radius)
        c->bound = fmin(c->bound, bound_by_planes(q, c, outside + 2 * radius + q->rounding));
    return true;
}

static void look_at(search *q, cell *c, const deviate_effort *effort)
{
    if (!bound_cell(q, c)) return;
    q->enough = fmax(effort->floor, q->best * (1 + effort->ratio));
    if (c->bound <= q->enough)
        q->settled = fmax(q->settled, c->bound);
    else
        push(q, c);
}

static void split_cell(search *q, const cell *c, const deviate_effort *effort)
{
    int axis = 0;
    for (int k = 1; k < 3; k++)
        if (c->half[k] > c->half[axis]) axis = k;
    for (int side = -1; side <= 1; side += 2) {
        cell part = *c;
        part.half[axis] /= 2;
        part.centre[axis] += side * part.half[axis];
        part.half[axis] += q->rounding;
        look_at(q, &part, effort);
    }
}

/* Where the solid is nearly convex, its normals say at once that the bound is good enough. */
static bool settled_by_normals(const solid *s, piece *p, const deviate_effort *effort)
{
    if (overhang_count(s->overhang) * p->plane_count > STEP_WORK * effort->steps) return false;
    double bound =
        overhang_bound(s->overhang, s, p->planes, p->plane_count, effort->floor, effort->floor, OVERHANG_WORK) +
        8 * piece_slack(s);
    if (!(bound <= effort->floor)) return false;
    p->deviation = bound;
    for (int k = 0; k < 3; k++) p->farthest[k] = (p->lo[k] + p->hi[k]) / 2;
    return true;
}

double deviate_find(const solid *s, piece *p, const deviate_effort *effort)
{
    if (!effort->places_only && settled_by_normals(s, p, effort)) return 0;
    pool work = {0};
    search q = {.s = s, .p = p, .rounding = 2 * piece_slack(s), .enough = effort->floor};
    q.heap = pool_alloc(&work, effort->steps + 2, sizeof *q.heap);
    cell whole;
    for (int k = 0; k < 3; k++) {
        whole.centre[k] = q.farthest[k] = (p->lo[k] + p->hi[k]) / 2;
        whole.half[k] = (p->hi[k] - p->lo[k]) / 2 + q.rounding;
    }
    look_at(&q, &whole, effort);
    for (size_t step = 0; step < effort->steps && q.count > 0; step++) {
        cell c = pop(&q);
        if (c.bound > q.enough)
            split_cell(&q, &c, effort);
        else
            q.settled = fmax(q.settled, c.bound);
    }
    double left = q.count > 0 ? q.heap[0].bound : 0;
    p->deviation = fmax(q.best, fmax(q.settled, left)) + 4 * q.rounding;
    memcpy(p->farthest, q.farthest, sizeof p->farthest);
    pool_free(&work);
    return q.best;
}
