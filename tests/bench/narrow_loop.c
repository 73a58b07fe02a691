/* narrow_loop: compounds as bodies of so many shapes are asked about: one query of our own a pair of boxes, each no
 * farther than the nearest so far. What a compound must beat. */
#include "narrow_scene.h"

#include "narrow/narrow.h"

#include <stdlib.h>

typedef struct boxes {
    size_t count;
    shape shape[NARROW_PARTS];
    pose at[NARROW_PARTS]; /* in the world: known before, as the world knows them */
} boxes;

typedef struct loop {
    boxes *bodies; /* two an item */
    double tolerance;
    narrow_scratch *scratch;
} loop;

static void take_apart(boxes *out, const narrow_body *b, const narrow_place *at)
{
    pose whole = narrow_scene_pose(at);
    out->count = b->kind == KIND_COMPOUND ? NARROW_PARTS : 1;
    for (size_t i = 0; i < out->count; i++) {
        const narrow_parts *p = b->parts;
        out->shape[i] = narrow_scene_shape(p ? &p->body[i] : b);
        out->at[i] = p ? pose_mul(whole, narrow_scene_pose(&p->at[i])) : whole;
    }
}

static void *create(const narrow_item *items, size_t count, const narrow_row *row)
{
    loop *l = calloc(1, sizeof *l);
    boxes *bodies = calloc(2 * count, sizeof *bodies);
    narrow_scratch *scratch = aligned_alloc(64, narrow_scratch_size());
    if (!l || !bodies || !scratch) abort();
    for (size_t i = 0; i < count; i++) {
        take_apart(&bodies[2 * i], items[i].a, &items[i].at_a);
        take_apart(&bodies[2 * i + 1], items[i].b, &items[i].at_b);
    }
    *l = (loop){bodies, row->tolerance, scratch};
    return l;
}

static void destroy(void *self)
{
    loop *l = self;
    free(l->bodies);
    free(l->scratch);
    free(l);
}

static void query(void *self, size_t first, size_t count, narrow_answer *out)
{
    const loop *l = self;
    for (size_t n = first; n < first + count; n++, out++) {
        const boxes *a = &l->bodies[2 * n], *b = &l->bodies[2 * n + 1];
        double lo = INFINITY, hi = INFINITY;
        for (size_t i = 0; i < a->count; i++)
            for (size_t k = 0; k < b->count; k++) {
                const narrow_request request = {.facts = NARROW_DISTANCE, .tolerance = l->tolerance, .range = hi};
                pose b_in_a = pose_relative(a->at[i], b->at[k]);
                narrow_result r;
                narrow_query(&a->shape[i], &b->shape[k], &b_in_a, &request, NULL, l->scratch, &r);
                lo = fmin(lo, r.lo);
                hi = fmin(hi, r.hi);
            }
        *out = (narrow_answer){.overlap = lo <= 0, .measured = true, .distance = 0.5 * (lo + hi)};
    }
}

static bool takes(const narrow_row *row)
{
    return row->b == KIND_COMPOUND;
}

const narrow_peer narrow_loop = {"loop_over_children",
    "collided's own query for each pair of boxes, as far as the best", false, takes, create, query, destroy,
    "narrow_query"};
