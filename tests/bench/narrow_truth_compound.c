/* narrow_truth_compound: each box at its exact place, and the best pair of them. */
#include "narrow_truth_compound.h"

typedef struct exact_boxes {
    size_t count;
    qvec corners[NARROW_PARTS][8];
    oracle_body at[NARROW_PARTS];
} exact_boxes;

static qmat rotation_of(const narrow_place *p)
{
    return oracle_rotation(p->q[0], p->q[1], p->q[2], p->q[3]);
}

static void put_box(exact_boxes *b, const double half[3], qmat rotation, qvec position)
{
    qvec *corner = b->corners[b->count];
    for (int i = 0; i < 8; i++)
        corner[i] = qv(i & 1 ? half[0] : -half[0], i & 2 ? half[1] : -half[1], i & 4 ? half[2] : -half[2]);
    b->at[b->count++] =
        (oracle_body){.core = ORACLE_POINTS, .points = corner, .count = 8, .rotation = rotation, .position = position};
}

static void take_apart(exact_boxes *out, const narrow_body *b, const narrow_place *at)
{
    qmat whole = rotation_of(at);
    qvec p = qv(at->p[0], at->p[1], at->p[2]);
    out->count = 0;
    if (b->kind == KIND_BOX) put_box(out, b->half, whole, p);
    for (int i = 0; b->kind == KIND_COMPOUND && i < NARROW_PARTS; i++) {
        const narrow_place *l = &b->parts->at[i];
        qmat local = rotation_of(l), r = {q_tmul(local, whole.x), q_tmul(local, whole.y), q_tmul(local, whole.z)};
        put_box(out, b->parts->body[i].half, r, q_add(p, q_mul(whole, qv(l->p[0], l->p[1], l->p[2]))));
    }
}

static quad between_centres(const oracle_body *a, const oracle_body *b)
{
    return q_norm(q_sub(b->position, a->position));
}

static quad radius_of(const oracle_body *b)
{
    return q_norm(b->points[0]);
}

/* No box is farther from another than their centres are: what a pair of bounding balls is beyond that cannot be it. */
static quad farthest_of_nearest(const exact_boxes *a, const exact_boxes *b)
{
    quad least = INFINITY;
    for (size_t i = 0; i < a->count; i++)
        for (size_t k = 0; k < b->count; k++) least = q_min(least, between_centres(&a->at[i], &b->at[k]));
    return least;
}

narrow_truth narrow_truth_of_compounds(const narrow_item *item)
{
    exact_boxes a, b;
    narrow_truth best = {.distance = INFINITY};
    take_apart(&a, item->a, &item->at_a);
    take_apart(&b, item->b, &item->at_b);
    quad most = farthest_of_nearest(&a, &b);
    for (size_t i = 0; i < a.count; i++)
        for (size_t k = 0; k < b.count; k++) {
            best.size = fmax(best.size, (double)oracle_size(&a.at[i], &b.at[k]));
            quad least = between_centres(&a.at[i], &b.at[k]) - radius_of(&a.at[i]) - radius_of(&b.at[k]);
            if (least > q_min(most, best.distance)) continue;
            oracle_truth t = oracle_distance_features(&a.at[i], &b.at[k]);
            if (!(t.lo < best.distance)) continue;
            best.distance = best.lo = t.lo;
            best.hi = t.hi;
        }
    return best;
}
