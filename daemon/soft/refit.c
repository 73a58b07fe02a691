/* refit: the boxes of a body's vertices, features, clusters and nodes, from its positions at the start of a way and at
 * a share of it, in portions. All workers, each its own vertices and clusters; the tree by the caller's thread.
 *
 * Rounding, u = 2^-53. A coordinate relative to the origin is off by u of itself, one at a share of the way by 4 u of
 * the greater of both ends: the margin grows by 2^-48 of the greatest. Turning to a float and taking the margin off are
 * off by 2^-24 of the float each: 2^-22 of it, and 2^-120 for the smallest, are put on top. */
#include "simd.h"
#include "state.h"

typedef struct refit {
    soft_body *body;
    vec3 origin;
    double margin, share;
    size_t from;
} refit;

static inline float rounded_down(double x)
{
    float f = (float)x;
    return f - (fabsf(f) * 0x1p-22f + 0x1p-120f);
}

static inline void put_axis(soft_box *box, int axis, double start, double end, double margin, double share)
{
    double most = fabs(start) > fabs(end) ? fabs(start) : fabs(end);
    margin += 0x1p-48 * most;
    end = start + share * (end - start);
    box->at[SOFT_LOW_START][axis] = rounded_down(start - margin);
    box->at[SOFT_LOW_END][axis] = rounded_down(end - margin);
    box->at[SOFT_HIGH_START][axis] = rounded_down(-start - margin);
    box->at[SOFT_HIGH_END][axis] = rounded_down(-end - margin);
}

static void refit_vertices(void *context, size_t begin, size_t end, unsigned worker)
{
    (void)worker;
    const refit *r = context;
    for (size_t i = r->from + begin; i < r->from + end; i++) {
        const soft_way *w = &r->body->ways[i];
        vec3 s = vec_sub(w->start, r->origin), e = vec_sub(w->end, r->origin);
        soft_box box = {0};
        put_axis(&box, 0, s.x, e.x, r->margin, r->share);
        put_axis(&box, 1, s.y, e.y, r->margin, r->share);
        put_axis(&box, 2, s.z, e.z, r->margin, r->share);
        r->body->vertex_boxes[i] = box;
    }
}

static inline soft_box common(soft_box a, const soft_box *b)
{
    for (int side = 0; side < SOFT_SIDES; side++) a.at[side] = lesser(a.at[side], b->at[side]);
    return a;
}

static inline void put_lane(soft_lanes *to, int lane, const soft_box *box)
{
    for (int side = 0; side < SOFT_SIDES; side++)
        for (int axis = 0; axis < 3; axis++) to->at[side * 3 + axis][lane] = box->at[side][axis];
}

/* The vertices of a feature: three of a face, two of an edge. */
static inline void refit_block(soft_body *b, uint32_t block, int corners, soft_box *all)
{
    const soft_block *names = &b->mesh->blocks[block];
    soft_lanes *boxes = &b->boxes[block];
    for (int lane = 0; lane < SOFT_LANES && names->id[lane] != SOFT_NONE; lane++) {
        soft_box box = b->vertex_boxes[names->vertex[0][lane]];
        for (int k = 1; k < corners; k++) box = common(box, &b->vertex_boxes[names->vertex[k][lane]]);
        put_lane(boxes, lane, &box);
        *all = common(*all, &box);
    }
}

static soft_box refit_cluster(soft_body *b, const soft_cluster *c)
{
    soft_box all = soft_box_empty();
    for (uint32_t i = 0; i < c->blocks[SOFT_FACES]; i++) refit_block(b, c->first[SOFT_FACES] + i, 3, &all);
    for (uint32_t i = 0; i < c->blocks[SOFT_EDGES]; i++) refit_block(b, c->first[SOFT_EDGES] + i, 2, &all);
    for (uint32_t i = 0; i < c->blocks[SOFT_VERTICES]; i++) refit_block(b, c->first[SOFT_VERTICES] + i, 1, &all);
    return all;
}

static void refit_leaves(void *context, size_t begin, size_t end, unsigned worker)
{
    (void)worker;
    const refit *r = context;
    soft_body *b = r->body;
    for (size_t i = r->from + begin; i < r->from + end; i++)
        if (b->mesh->nodes[i].left == SOFT_NONE)
            b->node_boxes[i] = refit_cluster(b, &b->mesh->clusters[b->mesh->nodes[i].right]);
}

/* Children come after their parent: from the last node to the first. */
static void refit_nodes(soft_body *b, size_t from, size_t count)
{
    const soft_mesh *m = b->mesh;
    for (size_t i = m->node_count - from; i-- > m->node_count - from - count;) {
        const soft_node *n = &m->nodes[i];
        if (n->left != SOFT_NONE) b->node_boxes[i] = common(b->node_boxes[n->left], &b->node_boxes[n->right]);
    }
}

uint64_t soft_refit(soft_body *b, soft_refitting *to, workers *pool)
{
    static const struct {
        size_t most, chunk;
        double units; /* each */
        workers_function *function;
    } STAGES[] = {{1 << 17, 4096, 1, refit_vertices}, {1 << 12, 256, 40, refit_leaves}, {1 << 16, 0, 1, NULL}};
    const size_t all[] = {b->mesh->vertex_count, b->mesh->node_count, b->mesh->node_count};
    size_t left = all[to->stage] - to->from, count = left < STAGES[to->stage].most ? left : STAGES[to->stage].most;
    refit r = {
        .body = b, .origin = to->origin, .margin = to->margin * (1 + 0x1p-40), .share = to->share, .from = to->from};
    uint64_t units = (uint64_t)(STAGES[to->stage].units * (double)count);
    if (to->stage == SOFT_REFIT_NODES)
        refit_nodes(b, to->from, count);
    else if (pool)
        workers_run(pool, count, STAGES[to->stage].chunk, STAGES[to->stage].function, &r);
    else
        STAGES[to->stage].function(&r, 0, count, 0);
    to->from += count;
    if (count == left) to->stage++, to->from = 0;
    return units;
}

bool soft_features_apart(const soft_body *first, const soft_body *second, const soft_candidate *c, soft_kind kind)
{
    int of_first = kind == SOFT_EDGE_EDGE ? 2 : 1;
    soft_box boxes[2] = {soft_box_empty(), soft_box_empty()};
    for (int i = 0; i < 4; i++) {
        const soft_body *b = i < of_first ? first : second;
        boxes[i >= of_first] = common(boxes[i >= of_first], &b->vertex_boxes[c->vertex[i]]);
    }
    return soft_boxes_apart(&boxes[0], &boxes[1]);
}
