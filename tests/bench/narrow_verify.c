/* narrow_verify: what a client pays to check an answer. Each item's certificate is asked for, and hulls are prepared,
 * before the clock starts; timed is collided_verify or collided_verify_prepared alone, from shapes, poses and claim, as
 * a client has them. They say no distance: a certificate that is not accepted counts as failed. */
#include "narrow/narrow.h"
#include "narrow_scene.h"

#include <collided.h>

#include <stdlib.h>

typedef struct client_side {
    collided_shape shape;
    collided_pose pose;
    const double *points;
    size_t point_count;
    collided_prepared_hull *prepared;
} client_side;

typedef struct checked_item {
    client_side a, b;
    collided_certificate claim;
} checked_item;

typedef struct checked {
    size_t count;
    checked_item items[];
} checked;

static void put(vec3 v, double out[3])
{
    out[0] = v.x, out[1] = v.y, out[2] = v.z;
}

static client_side side_of(const narrow_body *body, const narrow_place *at)
{
    static const collided_shape_type TYPES[KIND_COUNT] = {COLLIDED_SPHERE, COLLIDED_CAPSULE, COLLIDED_BOX,
        COLLIDED_CYLINDER, COLLIDED_CONE, COLLIDED_ELLIPSOID, COLLIDED_HULL, COLLIDED_MESH};
    client_side s = {.shape = {.type = TYPES[body->kind], .radius = body->radius, .pose = collided_pose_identity()}};
    for (int i = 0; i < 3; i++) s.shape.half[i] = body->kind == KIND_HULL ? 0 : body->half[i];
    for (int i = 0; i < 3; i++) s.pose.position[i] = at->p[i];
    for (int i = 0; i < 4; i++) s.pose.orientation[i] = at->q[i];
    if (body->kind == KIND_HULL) s.points = body->polytope->vertices, s.point_count = body->polytope->vertex_count;
    if (s.points) s.prepared = collided_prepare_hull(s.points, s.point_count);
    return s;
}

static collided_certificate certificate_of(const narrow_item *item, double tolerance, narrow_scratch *scratch)
{
    shape a = narrow_scene_shape(item->a), b = narrow_scene_shape(item->b);
    pose at_a = narrow_scene_pose(&item->at_a), at_b = narrow_scene_pose(&item->at_b);
    narrow_request request = {.facts = NARROW_DISTANCE, .tolerance = tolerance, .range = INFINITY};
    narrow_result r;
    narrow_query_world(&a, at_a, &b, at_b, &request, scratch, &r);
    collided_certificate claim = {.lo = r.lo, .hi = r.hi};
    put(r.axis, claim.axis);
    put(vec_add(r.point_a, at_a.p), claim.point_a);
    put(vec_add(r.point_b, at_a.p), claim.point_b);
    return claim;
}

static void *create(const narrow_item *items, size_t count, const narrow_row *row)
{
    checked *own = calloc(1, sizeof *own + count * sizeof own->items[0]);
    narrow_scratch *scratch = aligned_alloc(64, narrow_scratch_size());
    if (!own || !scratch) abort();
    own->count = count;
    for (size_t i = 0; i < count; i++)
        own->items[i] = (checked_item){side_of(items[i].a, &items[i].at_a), side_of(items[i].b, &items[i].at_b),
            certificate_of(&items[i], row->tolerance, scratch)};
    free(scratch);
    return own;
}

static void destroy(void *self)
{
    checked *own = self;
    for (size_t i = 0; i < own->count; i++) {
        collided_free_prepared_hull(own->items[i].a.prepared);
        collided_free_prepared_hull(own->items[i].b.prepared);
    }
    free(own);
}

static narrow_answer answer_of(const collided_certificate *claim, collided_status status)
{
    return (narrow_answer){
        .failed = status != COLLIDED_OK, .overlap = claim->lo <= 0, .bounded = true, .lo = claim->lo, .hi = claim->hi};
}

static void query(void *self, size_t first, size_t count, narrow_answer *out)
{
    const checked_item *items = ((checked *)self)->items;
    for (size_t i = first; i < first + count; i++) {
        const client_side *a = &items[i].a, *b = &items[i].b;
        *out++ = answer_of(&items[i].claim, collided_verify(&a->shape, &a->pose, a->points, a->point_count, &b->shape,
                                                &b->pose, b->points, b->point_count, &items[i].claim));
    }
}

static void query_prepared(void *self, size_t first, size_t count, narrow_answer *out)
{
    const checked_item *items = ((checked *)self)->items;
    for (size_t i = first; i < first + count; i++) {
        const client_side *a = &items[i].a, *b = &items[i].b;
        *out++ = answer_of(&items[i].claim, collided_verify_prepared(&a->shape, &a->pose, a->prepared, &b->shape,
                                                &b->pose, b->prepared, &items[i].claim));
    }
}

static bool takes_convex(const narrow_row *row)
{
    return row->a != KIND_MESH && row->b != KIND_MESH;
}

const narrow_peer narrow_verify = {"collided_verify", "a client's check of our certificate, which it is given", true,
    takes_convex, create, query, destroy, "collided_verify"};

static bool takes_hulls(const narrow_row *row)
{
    return takes_convex(row) && (row->a == KIND_HULL || row->b == KIND_HULL);
}

const narrow_peer narrow_verify_prepared = {"collided_verify_prepared", "the same, with hulls that were prepared once",
    true, takes_hulls, create, query_prepared, destroy, "collided_verify_prepared"};
