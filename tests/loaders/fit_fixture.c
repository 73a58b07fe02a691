/* fit_fixture: nothing of the loaders' own arithmetic is used here. */
#include "fit_fixture.h"

#include "geom/mesh.h"

#include <math.h>
#include <stdlib.h>

size_t fit_count(size_t nightly)
{
    if (getenv("COLLIDED_NIGHTLY")) return nightly;
    return getenv("COLLIDED_BRIEF") ? nightly / 1000 + 1 : nightly / 50;
}

double drawn(prng *r, double lo, double hi)
{
    return lo + (hi - lo) * (double)(prng_next(r) >> 11) * 0x1p-53;
}

vec3 drawn_direction(prng *r)
{
    for (;;) {
        vec3 v = vec(drawn(r, -1, 1), drawn(r, -1, 1), drawn(r, -1, 1));
        double n = vec_norm2(v);
        if (n > 0.01 && n < 1) return vec_unit(v);
    }
}

pose pose_from(const collided_pose *p)
{
    return (pose){{p->position[0], p->position[1], p->position[2]},
        {p->orientation[0], p->orientation[1], p->orientation[2], p->orientation[3]}};
}

static void add_shape(solid_set *s, const load_shape *from)
{
    static const shape_type types[] = {[COLLIDED_SPHERE] = SHAPE_SPHERE,
        [COLLIDED_CAPSULE] = SHAPE_CAPSULE,
        [COLLIDED_BOX] = SHAPE_BOX,
        [COLLIDED_CYLINDER] = SHAPE_CYLINDER,
        [COLLIDED_HULL] = SHAPE_HULL,
        [COLLIDED_MESH] = SHAPE_MESH};
    const collided_shape *c = &from->shape;
    size_t i = s->count++;
    shape *to = &s->at[i];
    *to = (shape){.type = types[c->type], .radius = c->radius, .half = {c->half[0], c->half[1], c->half[2]}};
    s->local[i] = pose_from(&c->pose);
    if (c->type == COLLIDED_HULL) {
        assert_int_equal(hull_build(from->points.at, from->points.count, 0, &s->hulls[i]), HULL_OK);
        to->hull = s->hulls[i];
    } else if (c->type == COLLIDED_MESH) {
        const mesh_triangles *t = &from->triangles;
        assert_int_equal(mesh_build(t->points, t->point_count, t->corners, t->count, &s->meshes[i]), MESH_OK);
        to->mesh = s->meshes[i];
        to->hull = s->meshes[i]->hull;
    }
}

void set_make(solid_set *s, const load_shape *shapes, size_t count)
{
    *s = (solid_set){.count = 0};
    assert_in_range(count, 1, 64);
    for (size_t i = 0; i < count; i++) add_shape(s, &shapes[i]);
}

void set_free(solid_set *s)
{
    for (size_t i = 0; i < s->count; i++) {
        if (s->hulls[i]) hull_destroy(s->hulls[i]);
        if (s->meshes[i]) mesh_destroy(s->meshes[i]);
    }
}

static narrow_scratch *scratch(void)
{
    static narrow_scratch *s;
    if (!s) s = aligned_alloc(64, (narrow_scratch_size() + 63) / 64 * 64);
    return s;
}

static void ask_point(const solid_set *s, size_t i, vec3 point, narrow_result *out)
{
    const shape dot = {.type = SHAPE_SPHERE};
    const narrow_request request = {.facts = NARROW_DISTANCE, .range = INFINITY};
    narrow_query_world(&dot, (pose){point, {1, 0, 0, 0}}, &s->at[i], s->local[i], &request, scratch(), out);
}

double set_away(const solid_set *s, vec3 point)
{
    double least = INFINITY;
    for (size_t i = 0; i < s->count; i++) {
        narrow_result r;
        ask_point(s, i, point, &r);
        least = fmin(least, r.hi);
    }
    return least;
}

double set_away_at_least(const solid_set *s, vec3 point)
{
    double least = INFINITY;
    for (size_t i = 0; i < s->count; i++) {
        narrow_result r;
        ask_point(s, i, point, &r);
        least = fmin(least, r.lo);
    }
    return least;
}

vec3 set_surface_point(const solid_set *s, size_t i, prng *r)
{
    double reach = shape_reach(&s->at[i]);
    vec3 from = vec_add(s->local[i].p, vec_scale(drawn_direction(r), reach * drawn(r, 1.01, 2)));
    narrow_result nearest;
    ask_point(s, i, from, &nearest);
    return vec_add(from, nearest.point_b); /* the answer's origin is at `from` */
}

static pose product(pose outer, pose inner)
{
    return (pose){vec_add(quat_rotate(outer.q, inner.p), outer.p), quat_unit(quat_mul(outer.q, inner.q))};
}

double set_distance(const solid_set *a, pose pose_a, const solid_set *b, pose pose_b)
{
    const narrow_request request = {.facts = NARROW_DISTANCE, .range = INFINITY, .tolerance = 1e-9};
    double least = INFINITY;
    for (size_t i = 0; i < a->count; i++)
        for (size_t k = 0; k < b->count; k++) {
            narrow_result r;
            narrow_query_world(&a->at[i], product(pose_a, a->local[i]), &b->at[k], product(pose_b, b->local[k]),
                &request, scratch(), &r);
            least = fmin(least, r.hi);
        }
    return least;
}

void fixture_arm(fixture *f, robot *out)
{
    static const robot_source source = {
        .urdf = FIT_EXAMPLES "/arm.urdf", .srdf = FIT_EXAMPLES "/arm.srdf", .meshes = {.as = LOAD_MESH_SOLID}};
    if (!robot_load(out, &f->pool, &source, &f->report)) fail_msg("%s", f->report.error);
}

bool fixture_panda_solid(fixture *f, robot *out)
{
    if (!fixture_panda(f, out)) return false;
    out->source.meshes = (load_meshes){.as = LOAD_MESH_SOLID};
    return true;
}
