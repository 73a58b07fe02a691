/* narrow_ccd: libccd by itself, with our support points. It measures depth only; of separated pairs it knows just that
 * they are. Its EPA and portal search have no limit of iterations, so its support calls are counted: past CALLS_MAX it
 * gets points that end every loop, and the query counts as failed. */
#include "narrow_scene.h"

#include "geom/hull.h"
#include "geom/support.h"

#include <ccd/ccd.h>
#include <stdlib.h>

enum { ITERATIONS_MAX = 200, CALLS_MAX = 300 };

typedef struct ccd_state {
    long calls;
    vec3 last; /* direction of the last support query of A */
    vec3 seed; /* first direction to try; zero = the line of centres */
} ccd_state;

typedef struct ccd_body {
    shape s;
    transform at;
    vec3 centre;
    ccd_state *state;
} ccd_body;

typedef struct ccd_item {
    ccd_body a, b;
    bool begins;
} ccd_item;

typedef struct ccd_self {
    ccd_item *items;
    ccd_t options;
    ccd_state state;
    bool coherent, measures;
} ccd_self;

static vec3 from_ccd(const ccd_vec3_t *v)
{
    return vec(v->v[0], v->v[1], v->v[2]);
}

static vec3 support_point(const ccd_body *b, vec3 d)
{
    vec3 unit = vec_unit(d);
    vec3 p = transform_point(&b->at, support_core(&b->s, mat_tmul(b->at.r, unit), NULL));
    return vec_madd(p, b->s.radius, unit);
}

static void support(const void *object, const ccd_vec3_t *direction, ccd_vec3_t *out)
{
    const ccd_body *b = object;
    vec3 d = from_ccd(direction), p = b->state->calls > CALLS_MAX ? vec_scale(d, -1e3) : support_point(b, d);
    ccdVec3Set(out, p.x, p.y, p.z);
}

static void support_of_a(const void *object, const ccd_vec3_t *direction, ccd_vec3_t *out)
{
    ccd_state *state = ((const ccd_body *)object)->state;
    if (state->calls++ <= CALLS_MAX) state->last = from_ccd(direction);
    support(object, direction, out);
}

static void centre(const void *object, ccd_vec3_t *out)
{
    const ccd_body *b = object;
    ccdVec3Set(out, b->centre.x, b->centre.y, b->centre.z);
}

static void first_direction(const void *a, const void *b, ccd_vec3_t *out)
{
    const ccd_body *first = a, *second = b;
    vec3 d = first->state->seed;
    if (vec_norm2(d) == 0) d = vec_sub(second->centre, first->centre);
    if (vec_norm2(d) == 0) d = vec(1, 0, 0);
    ccdVec3Set(out, d.x, d.y, d.z);
}

static ccd_body body_of(const narrow_body *body, const narrow_place *at, ccd_state *state)
{
    ccd_body b = {.s = narrow_scene_shape(body), .at = pose_transform(narrow_scene_pose(at)), .state = state};
    b.centre = transform_point(&b.at, vec(0, 0, body->kind == KIND_CONE ? -0.5 * body->half[2] : 0));
    return b;
}

static void *create(const narrow_item *items, size_t count, const narrow_row *row)
{
    ccd_self *self = calloc(1, sizeof *self);
    ccd_item *own = calloc(count, sizeof *own);
    if (!self || !own) abort();
    self->items = own;
    self->coherent = row->coherent;
    self->measures = row->regime != REGIME_SEPARATED;
    for (size_t i = 0; i < count; i++)
        own[i] = (ccd_item){body_of(items[i].a, &items[i].at_a, &self->state),
            body_of(items[i].b, &items[i].at_b, &self->state), items[i].begins};
    CCD_INIT(&self->options);
    if (row->own > 0) self->options.epa_tolerance = self->options.mpr_tolerance = row->own;
    self->options.max_iterations = ITERATIONS_MAX;
    self->options.first_dir = first_direction;
    self->options.support1 = support_of_a;
    self->options.support2 = support;
    self->options.center1 = self->options.center2 = centre;
    return self;
}

static void *create_fine(const narrow_item *items, size_t count, const narrow_row *row)
{
    ccd_self *self = create(items, count, row);
    self->options.epa_tolerance = 1e-10;
    return self;
}

static void destroy(void *self)
{
    free(((ccd_self *)self)->items);
    free(self);
}

/* The hidden separating axis: the direction in which libccd asked last when it found a miss. */
static bool separates(const ccd_item *it, vec3 d)
{
    if (vec_norm2(d) == 0) return false;
    vec3 a = support_point(&it->a, d), b = support_point(&it->b, vec_neg(d));
    return vec_dot(d, vec_sub(b, a)) > 0;
}

typedef int measure_fn(
    const void *a, const void *b, const ccd_t *options, ccd_real_t *depth, ccd_vec3_t *dir, ccd_vec3_t *pos);
typedef int verdict_fn(const void *a, const void *b, const ccd_t *options);

static void ask(ccd_self *self, const ccd_item *it, measure_fn *measure, verdict_fn *verdict, narrow_answer *out)
{
    ccd_real_t depth = 0;
    ccd_vec3_t direction, position;
    ccd_state *state = &self->state;
    state->calls = 0;
    if (it->begins || !self->coherent) state->seed = VEC_ZERO;
    *out = (narrow_answer){0};
    if (separates(it, state->seed)) return;
    int result = self->measures ? measure(&it->a, &it->b, &self->options, &depth, &direction, &position)
                                : verdict(&it->a, &it->b, &self->options);
    bool overlap = self->measures ? result == 0 : result == 1;
    out->failed = result == -2 || state->calls > CALLS_MAX;
    out->overlap = overlap;
    out->measured = self->measures && overlap;
    out->distance = -depth;
    state->seed = overlap ? VEC_ZERO : state->last;
}

static void query_gjk(void *self, size_t first, size_t count, narrow_answer *out)
{
    ccd_self *s = self;
    for (size_t i = 0; i < count; i++) ask(s, &s->items[first + i], ccdGJKPenetration, ccdGJKIntersect, &out[i]);
}

static void query_mpr(void *self, size_t first, size_t count, narrow_answer *out)
{
    ccd_self *s = self;
    for (size_t i = 0; i < count; i++) ask(s, &s->items[first + i], ccdMPRPenetration, ccdMPRIntersect, &out[i]);
}

static bool takes_convex(const narrow_row *row)
{
    return row->a != KIND_MESH && row->b != KIND_MESH && row->b != KIND_COMPOUND;
}

static bool takes_contact(const narrow_row *row)
{
    return row->regime != REGIME_SEPARATED;
}

const narrow_peer narrow_ccd_gjk = {"ccd_gjk",
    "ccdGJKPenetration, epa_tolerance 1e-4 (default); separated: "
    "ccdGJKIntersect, the last direction first",
    false, takes_convex, create, query_gjk, destroy, "ccdGJKPenetration, ccdGJKIntersect"};
const narrow_peer narrow_ccd_gjk_fine = {"ccd_gjk_fine", "ccdGJKPenetration, epa_tolerance 1e-10", false, takes_contact,
    create_fine, query_gjk, destroy, "ccdGJKPenetration"};
const narrow_peer narrow_ccd_mpr = {"ccd_mpr",
    "ccdMPRPenetration, mpr_tolerance 1e-4 (default); separated: "
    "ccdMPRIntersect, the last direction first",
    false, takes_convex, create, query_mpr, destroy, "ccdMPRPenetration, ccdMPRIntersect"};
