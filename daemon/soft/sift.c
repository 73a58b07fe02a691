/* sift: pairs of features in fours, proven apart by one of a few directions. Any thread.
 *
 * The corners of the polygon of differences move along lines, so a direction whose product with each corner exceeds the
 * separation and the rounding at both ends of a stretch separates all along it (elementary.c). Directions may be any:
 * six diagonals of the coordinate axes (the axes themselves the boxes have tried), the polygon's middle at both ends
 * and between, its normal at both ends and between.
 *
 * Rounding, as in elementary.c: differences are off by u of themselves, those at a share of the way by 4 u of the
 * greater end, products by u, sums of three by 2 u: together below 8 u sum |d_k| max |w_k|; 16 u of it are asked, and
 * the sum of the |w_k| taken for the greatest. |w| <= 2^101 and |d| <= 2^206, so 2^-800 is far above what underflow may
 * lose. */
#include "state.h"

#include "geom/simd.h"

#define SIFT_BOUND 0x1p-49
#define SIFT_UNDERFLOW 0x1p-800

typedef struct four_polygons {
    lanes3 start[4], end[4], most;
    double separation;
} four_polygons;

LANES_INLINE lanes3 lanes3_add(lanes3 a, lanes3 b)
{
    return (lanes3){a.x + b.x, a.y + b.y, a.z + b.z};
}

/* Lanes that the direction proves apart. */
LANES_INLINE lane_mask proves(const four_polygons *p, int corners, lanes3 d)
{
    lanes need = lanes_abs(d.x) * p->most.x + lanes_abs(d.y) * p->most.y + lanes_abs(d.z) * p->most.z;
    need = need * lanes_of(SIFT_BOUND) + lanes_of(SIFT_UNDERFLOW);
    if (p->separation > 0) need += lanes_of(p->separation) * lanes_sqrt(lanes3_dot(d, d)) * lanes_of(1 + 0x1p-49);
    lane_mask above = {-1, -1, -1, -1}, below = above;
    for (int i = 0; i < corners; i++) {
        lanes start = lanes3_dot(d, p->start[i]), end = lanes3_dot(d, p->end[i]);
        above &= (start > need) & (end > need);
        below &= (start < -need) & (end < -need);
    }
    return above | below;
}

LANES_INLINE bool all_of(lane_mask m)
{
    return lanes_bits(m) == 15;
}

LANES_INLINE lane_mask proven(const four_polygons *p, int corners)
{
    lanes one = lanes_of(1), zero = lanes_of(0);
    const lanes3 *s = p->start, *e = p->end;
    lanes3 middle_start = lanes3_add(s[0], s[1]), middle_end = lanes3_add(e[0], e[1]);
    for (int i = 2; i < corners; i++)
        middle_start = lanes3_add(middle_start, s[i]), middle_end = lanes3_add(middle_end, e[i]);
    lane_mask apart = proves(p, corners, lanes3_add(middle_start, middle_end));
    if (all_of(apart)) return apart;
    int last = corners - 1;
    lanes3 normal_start = lanes3_cross(lanes3_sub(s[1], s[0]), lanes3_sub(s[last], s[0]));
    lanes3 normal_end = lanes3_cross(lanes3_sub(e[1], e[0]), lanes3_sub(e[last], e[0]));
    apart |= proves(p, corners, lanes3_add(normal_start, normal_end));
    if (all_of(apart)) return apart;
    apart |= proves(p, corners, normal_start) | proves(p, corners, normal_end);
    if (all_of(apart)) return apart;
    apart |= proves(p, corners, middle_start) | proves(p, corners, middle_end);
    if (all_of(apart)) return apart;
    apart |= proves(p, corners, (lanes3){one, one, zero}) | proves(p, corners, (lanes3){one, -one, zero});
    apart |= proves(p, corners, (lanes3){one, zero, one}) | proves(p, corners, (lanes3){one, zero, -one});
    return apart | proves(p, corners, (lanes3){zero, one, one}) | proves(p, corners, (lanes3){zero, one, -one});
}

LANES_INLINE lanes3 side_by_side(const vec3 *a, const vec3 *b, const vec3 *c, const vec3 *d)
{
    return (lanes3){{a->x, b->x, c->x, d->x}, {a->y, b->y, c->y, d->y}, {a->z, b->z, c->z, d->z}};
}

LANES_INLINE void take_most(four_polygons *p, int corners)
{
    lanes zero = lanes_of(0);
    p->most = (lanes3){zero, zero, zero};
    for (int i = 0; i < corners; i++) {
        p->most.x += lanes_abs(p->start[i].x) + lanes_abs(p->end[i].x);
        p->most.y += lanes_abs(p->start[i].y) + lanes_abs(p->end[i].y);
        p->most.z += lanes_abs(p->start[i].z) + lanes_abs(p->end[i].z);
    }
}

/* Points of the first feature, then of the second: corners of the polygon are differences of one of each. */
LANES_INLINE lane_mask sift_four(const soft_candidate *const c[LANES], bool edges, const soft_way *first,
    const soft_way *second, double separation, double share)
{
    static const int FROM[4] = {0, 0, 1, 1}, TO[4] = {2, 3, 3, 2};
    int corners = edges ? 4 : 3;
    lanes3 start[4] = {0}, end[4] = {0};
    four_polygons p;
    p.separation = separation;
    for (int i = 0; i < 4; i++) {
        const soft_way *ways = i < (edges ? 2 : 1) ? first : second, *w[LANES];
        for (int k = 0; k < LANES; k++) w[k] = &ways[c[k]->vertex[i]];
        start[i] = side_by_side(&w[0]->start, &w[1]->start, &w[2]->start, &w[3]->start);
        end[i] = side_by_side(&w[0]->end, &w[1]->end, &w[2]->end, &w[3]->end);
    }
    for (int i = 0; i < corners; i++) {
        int from = edges ? FROM[i] : 0, to = edges ? TO[i] : 1 + i;
        p.start[i] = lanes3_sub(start[to], start[from]), p.end[i] = lanes3_sub(end[to], end[from]);
    }
    take_most(&p, corners);
    if (share < 1)
        for (int i = 0; i < corners; i++) {
            lanes3 way = lanes3_sub(p.end[i], p.start[i]);
            lanes f = lanes_of(share);
            p.end[i] = lanes3_add(p.start[i], (lanes3){f * way.x, f * way.y, f * way.z});
        }
    return proven(&p, corners);
}

LANES_INLINE size_t sift_fours(soft_candidate *list, size_t count, bool edges, const soft_way *first,
    const soft_way *second, double separation, double share)
{
    size_t kept = 0;
    for (size_t i = 0; i < count; i += LANES) {
        const soft_candidate *c[LANES];
        for (size_t lane = 0; lane < LANES; lane++) c[lane] = &list[i + lane < count ? i + lane : i];
        unsigned apart = lanes_bits(sift_four(c, edges, first, second, separation, share));
        for (size_t lane = 0; lane < LANES && i + lane < count; lane++)
            if (!(apart >> lane & 1)) list[kept++] = list[i + lane];
    }
    return kept;
}

#define SIFT_PARAMETERS                                                                                                \
    (soft_candidate * list, size_t count, const soft_way *first, const soft_way *second, double separation,            \
        double share)

LANES_TWINS(LANES_WHOLE, size_t, sift_edges, sift_fours, SIFT_PARAMETERS,
    (list, count, true, first, second, separation, share));
LANES_TWINS(LANES_WHOLE, size_t, sift_faces, sift_fours, SIFT_PARAMETERS,
    (list, count, false, first, second, separation, share));

size_t soft_sift(soft_candidate *list, size_t count, soft_kind kind, const soft_way *a, const soft_way *b,
    double separation, double share)
{
    if (kind == SOFT_EDGE_EDGE) return LANES_CHOSEN(sift_edges)(list, count, a, b, separation, share);
    const soft_way *first = kind == SOFT_FACE_VERTEX ? b : a, *second = kind == SOFT_FACE_VERTEX ? a : b;
    return LANES_CHOSEN(sift_faces)(list, count, first, second, separation, share);
}
