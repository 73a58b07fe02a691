/* narrow_scene: random bodies, and where they are put. Ours measures where they touch; the truth comes later, from
 * elsewhere (narrow_truth.h). */
#include "narrow_scene.h"
#include "chance.h"

#include "geom/compound.h"
#include "geom/mesh.h"
#include "narrow/narrow.h"

#include <stdlib.h>
#include <string.h>

enum { FRAMES = 16 /* of a track */, MESH_RINGS = 50, MESH_SECTORS = 50 };

const narrow_pair narrow_pairs[] = {
    {"sphere-sphere", KIND_SPHERE, KIND_SPHERE, 0, false},
    {"capsule-capsule", KIND_CAPSULE, KIND_CAPSULE, 0, false},
    {"box-box", KIND_BOX, KIND_BOX, 0, false},
    {"cylinder-cylinder", KIND_CYLINDER, KIND_CYLINDER, 0, true},
    {"cone-box", KIND_BOX, KIND_CONE, 0, true},
    {"ellipsoid-ellipsoid", KIND_ELLIPSOID, KIND_ELLIPSOID, 0, true},
    {"hull16-hull16", KIND_HULL, KIND_HULL, 16, false},
    {"hull64-hull64", KIND_HULL, KIND_HULL, 64, false},
    {"hull256-hull256", KIND_HULL, KIND_HULL, 256, false},
    {"sphere-box", KIND_SPHERE, KIND_BOX, 0, false},
    {"capsule-box", KIND_CAPSULE, KIND_BOX, 0, false},
    {"cylinder-box", KIND_BOX, KIND_CYLINDER, 0, true},
    {"hull64-box", KIND_BOX, KIND_HULL, 64, false},
    {"compound10-box", KIND_BOX, KIND_COMPOUND, 0, false},
    {"compound10-compound10", KIND_COMPOUND, KIND_COMPOUND, 0, false},
    {"mesh-box", KIND_BOX, KIND_MESH, 0, false},
    {"mesh-mesh", KIND_MESH, KIND_MESH, 0, false},
};
const size_t narrow_pair_count = sizeof narrow_pairs / sizeof *narrow_pairs;
const char *const narrow_regime_names[REGIME_COUNT] = {"separated", "shallow", "deep"};

static quat turn(vec3 axis, double angle)
{
    double s = sin(angle / 2);
    return (quat){cos(angle / 2), s * axis.x, s * axis.y, s * axis.z};
}

/* ---- bodies ---- */

static void *allocate(size_t count, size_t size)
{
    void *p = calloc(count, size);
    if (!p) abort();
    return p;
}

static narrow_polytope *copy_hull(const hull *h)
{
    narrow_polytope *p = allocate(1, sizeof *p);
    *p = (narrow_polytope){.vertex_count = h->vertex_count, .face_count = h->face_count, .built = h};
    p->vertices = allocate(3 * p->vertex_count, sizeof *p->vertices);
    p->planes = allocate(4 * p->face_count, sizeof *p->planes);
    p->face_first = allocate(p->face_count + 1, sizeof *p->face_first);
    for (uint32_t i = 0; i < h->vertex_count; i++) {
        vec3 v = hull_vertex(h, i);
        p->vertices[3 * i] = v.x, p->vertices[3 * i + 1] = v.y, p->vertices[3 * i + 2] = v.z;
    }
    for (uint32_t i = 0; i < h->face_count; i++) {
        const hull_face *f = &h->faces[i];
        double plane[4] = {f->normal.x, f->normal.y, f->normal.z, f->offset};
        memcpy(&p->planes[4 * i], plane, sizeof plane);
        p->face_first[i + 1] = p->face_first[i] + f->count;
    }
    p->face_vertices = allocate(p->face_first[p->face_count], sizeof *p->face_vertices);
    for (uint32_t i = 0; i < h->face_count; i++)
        memcpy(&p->face_vertices[p->face_first[i]], &h->face_vertices[h->faces[i].first],
            h->faces[i].count * sizeof(uint32_t));
    return p;
}

static const narrow_polytope *random_polytope(chance *c, size_t points, const double half[3])
{
    double *at = allocate(3 * points, sizeof *at);
    for (size_t i = 0; i < points; i++) {
        vec3 v = chance_direction(c);
        at[3 * i] = half[0] * v.x, at[3 * i + 1] = half[1] * v.y, at[3 * i + 2] = half[2] * v.z;
    }
    hull *h;
    if (hull_build(at, points, 0, &h) != HULL_OK) abort();
    free(at);
    return copy_hull(h);
}

/* Rings of points between two poles; the radius waves along both angles. */
static void bumpy_points(double *at, const double half[3])
{
    for (int ring = 0; ring <= MESH_RINGS + 1; ring++)
        for (int k = 0; k < (ring % (MESH_RINGS + 1) ? MESH_SECTORS : 1); k++) {
            double theta = M_PI * ring / (MESH_RINGS + 1), phi = 2 * M_PI * k / MESH_SECTORS;
            double r = 1 + 0.2 * sin(4 * theta) * sin(3 * phi);
            *at++ = half[0] * r * sin(theta) * cos(phi);
            *at++ = half[1] * r * sin(theta) * sin(phi);
            *at++ = half[2] * r * cos(theta);
        }
}

/* Counter-clockwise seen from outside: two a quad, one at a pole. */
static size_t bumpy_corners(int32_t *corners)
{
    int32_t *at = corners, last = 1 + MESH_RINGS * MESH_SECTORS;
    for (int ring = 0; ring <= MESH_RINGS; ring++)
        for (int k = 0; k < MESH_SECTORS; k++) {
            int next = (k + 1) % MESH_SECTORS, above = 1 + (ring - 1) * MESH_SECTORS, below = above + MESH_SECTORS;
            int32_t a = ring ? above + k : 0, b = ring ? above + next : 0;
            int32_t c = ring < MESH_RINGS ? below + k : last, d = ring < MESH_RINGS ? below + next : last;
            if (ring < MESH_RINGS) *at++ = a, *at++ = c, *at++ = d;
            if (ring) *at++ = a, *at++ = ring < MESH_RINGS ? d : c, *at++ = b;
        }
    return (size_t)(at - corners) / 3;
}

static const narrow_polytope *bumpy_mesh(const double half[3])
{
    static double points[3 * (MESH_RINGS * MESH_SECTORS + 2)];
    static int32_t corners[6 * (MESH_RINGS + 1) * MESH_SECTORS];
    narrow_polytope *p = allocate(1, sizeof *p);
    mesh *m;
    bumpy_points(points, half);
    size_t count = bumpy_corners(corners);
    if (mesh_build(points, MESH_RINGS * MESH_SECTORS + 2, corners, count, &m) != MESH_OK || !m->solid) abort();
    *p = (narrow_polytope){.vertex_count = m->vertex_count, .face_count = m->triangle_count, .built = m};
    p->vertices = allocate(3 * p->vertex_count, sizeof *p->vertices);
    p->face_first = allocate(p->face_count + 1, sizeof *p->face_first);
    p->face_vertices = allocate(3 * p->face_count, sizeof *p->face_vertices);
    for (uint32_t i = 0; i < m->vertex_count; i++) memcpy(&p->vertices[3 * i], &m->vertices[i], 3 * sizeof(double));
    for (uint32_t i = 0; i < m->triangle_count; i++) {
        p->face_first[i + 1] = 3 * i + 3;
        memcpy(&p->face_vertices[3 * i], m->triangles[i].v, sizeof m->triangles[i].v);
    }
    return p;
}

static pose random_pose(chance *c)
{
    return (pose){{chance_in(c, -1, 1), chance_in(c, -1, 1), chance_in(c, -1, 1)}, chance_rotation(c)};
}

static narrow_place place_of(pose p)
{
    return (narrow_place){{p.p.x, p.p.y, p.p.z}, {p.q.w, p.q.x, p.q.y, p.q.z}};
}

static const narrow_parts *random_parts(chance *c)
{
    narrow_parts *parts = allocate(1, sizeof *parts);
    shape shapes[NARROW_PARTS];
    pose at[NARROW_PARTS];
    compound *built;
    for (int i = 0; i < NARROW_PARTS; i++) {
        parts->body[i] = (narrow_body){.kind = KIND_BOX};
        for (int k = 0; k < 3; k++) parts->body[i].half[k] = chance_in(c, 0.1, 0.33);
        at[i] = random_pose(c);
        parts->at[i] = place_of(at[i]);
        shapes[i] = narrow_scene_shape(&parts->body[i]);
    }
    if (compound_build(shapes, at, NARROW_PARTS, &built) != COMPOUND_OK) abort();
    parts->built = built;
    return parts;
}

/* Flat along its axis, or a needle along it. */
static void make_thin(narrow_body *b, bool flat, double aspect)
{
    if (b->kind == KIND_SPHERE) return;
    if (b->kind == KIND_CAPSULE)
        b->radius /= aspect;
    else if (flat)
        b->half[2] /= aspect;
    else
        b->half[0] /= aspect, b->half[1] /= aspect;
}

static narrow_body random_body(chance *c, narrow_kind kind, size_t points, double scale, double aspect)
{
    narrow_body b = {.kind = kind};
    for (int i = 0; i < 3; i++) b.half[i] = scale * chance_in(c, 0.3, 1);
    if (kind == KIND_SPHERE || kind == KIND_CAPSULE) b.radius = scale * chance_in(c, 0.3, 1);
    if (aspect != 1) make_thin(&b, chance_in(c, 0, 1) < 0.5, aspect);
    if (kind == KIND_SPHERE) b.half[2] = 0;
    if (kind == KIND_SPHERE || kind == KIND_CAPSULE) b.half[0] = b.half[1] = 0;
    if (kind == KIND_CYLINDER || kind == KIND_CONE) b.half[1] = b.half[0];
    if (kind == KIND_HULL) b.polytope = random_polytope(c, points, b.half);
    if (kind == KIND_MESH) b.polytope = bumpy_mesh(b.half);
    if (kind == KIND_COMPOUND) b.parts = random_parts(c);
    return b;
}

shape narrow_scene_shape(const narrow_body *b)
{
    static const shape_type TYPES[KIND_COUNT] = {SHAPE_SPHERE, SHAPE_CAPSULE, SHAPE_BOX, SHAPE_CYLINDER, SHAPE_CONE,
        SHAPE_ELLIPSOID, SHAPE_HULL, SHAPE_MESH, SHAPE_COMPOUND};
    shape s = {.type = TYPES[b->kind], .radius = b->radius};
    if (b->kind == KIND_HULL)
        s.hull = b->polytope->built;
    else if (b->kind == KIND_MESH)
        s.mesh = b->polytope->built, s.hull = s.mesh->hull;
    else if (b->kind == KIND_COMPOUND)
        s.compound = b->parts->built;
    else
        s.half = vec(b->half[0], b->half[1], b->half[2]);
    return s;
}

pose narrow_scene_pose(const narrow_place *at)
{
    return (pose){{at->p[0], at->p[1], at->p[2]}, {at->q[0], at->q[1], at->q[2], at->q[3]}};
}

/* ---- places ---- */

/* How B lies to A: its orientation, the direction of its centre, and the amount by which the regime is entered. */
typedef struct lie {
    quat q;
    vec3 towards;
    double amount;
    bool by_smaller; /* the amount is relative to the smaller reach, not to their mean */
    int halvings;    /* until they touch */
} lie;

static bool are_apart(const shape *a, pose at_a, const shape *b, pose at_b)
{
    static narrow_scratch *scratch;
    if (!scratch) scratch = aligned_alloc(64, narrow_scratch_size());
    if (!scratch) abort();
    narrow_request r = {.facts = NARROW_VERDICT, .tolerance = 1e-9 * shape_reach(a), .range = INFINITY};
    narrow_result out;
    narrow_query_world(a, at_a, b, at_b, &r, scratch, &out);
    return out.lo > 0;
}

/* How far B's centre is along the direction when they touch. */
static double touching_at(const shape *a, const shape *b, const lie *l)
{
    double lo = 0, hi = 1.01 * (shape_reach(a) + shape_reach(b));
    for (int i = 0; i < l->halvings; i++) {
        double mid = 0.5 * (lo + hi);
        pose at = {vec_scale(l->towards, mid), l->q};
        if (are_apart(a, POSE_IDENTITY, b, at))
            hi = mid;
        else
            lo = mid;
    }
    return hi;
}

static pose lying(const shape *a, const shape *b, const lie *l, narrow_regime regime)
{
    double touch = touching_at(a, b, l), mean = 0.5 * (shape_reach(a) + shape_reach(b)), away = touch;
    if (l->by_smaller) mean = fmin(shape_reach(a), shape_reach(b));
    if (regime == REGIME_SEPARATED) away = touch + l->amount * mean;
    if (regime == REGIME_SHALLOW) away = touch - l->amount * mean;
    if (regime == REGIME_DEEP) away = touch * l->amount;
    return (pose){vec_scale(l->towards, away), l->q};
}

static lie random_lie(chance *c, narrow_regime regime)
{
    static const double AMOUNTS[REGIME_COUNT][2] = {{0.05, 0.5}, {0.001, 0.02}, {0.1, 0.6}};
    return (lie){
        chance_rotation(c), chance_direction(c), chance_in(c, AMOUNTS[regime][0], AMOUNTS[regime][1]), false, 40};
}

/* One track, or one item when `frames` is 1. */
static void fill_track(chance *c, const narrow_body *pair, narrow_regime regime, narrow_item *items, size_t frames)
{
    shape a = narrow_scene_shape(&pair[0]), b = narrow_scene_shape(&pair[1]);
    pose at_a = random_pose(c);
    lie l = random_lie(c, regime);
    quat spin = turn(chance_direction(c), 0.01), swing = turn(chance_direction(c), 0.005);
    for (size_t i = 0; i < frames; i++) {
        pose at_b = pose_mul(at_a, lying(&a, &b, &l, regime));
        at_b.q = quat_unit(at_b.q);
        items[i] = (narrow_item){&pair[0], &pair[1], place_of(at_a), place_of(at_b), i == 0};
        l.q = quat_unit(quat_mul(spin, l.q));
        l.towards = vec_unit(quat_rotate(swing, l.towards));
    }
}

narrow_scene narrow_scene_create(const narrow_pair *pair, narrow_regime regime, bool coherent, size_t count)
{
    chance c = {0x5eed + 16 * (uint64_t)(pair - narrow_pairs) + 4 * (uint64_t)regime + coherent};
    size_t frames = coherent ? FRAMES : 1, tracks = count / frames;
    narrow_scene s = {.row = {pair->a, pair->b, regime, coherent, pair->curved ? 1e-6 : 1e-9, 0}};
    s.count = tracks * frames;
    s.body_count = 2 * tracks;
    s.items = allocate(s.count, sizeof *s.items);
    s.bodies = allocate(s.body_count, sizeof *s.bodies);
    for (size_t t = 0; t < tracks; t++) {
        s.bodies[2 * t] = random_body(&c, pair->a, pair->hull_points, 1, 1);
        s.bodies[2 * t + 1] = random_body(&c, pair->b, pair->hull_points, 1, 1);
        fill_track(&c, &s.bodies[2 * t], regime, &s.items[t * frames], frames);
    }
    return s;
}

/* ---- extremes ---- */

static lie extreme_lie(chance *c, narrow_regime regime, narrow_kind first, const narrow_extreme *x)
{
    lie l = random_lie(c, regime);
    l.halvings = 64;
    l.by_smaller = x->ratio != 1;
    if (!isnan(x->amount)) l.amount = x->amount;
    if (isnan(x->tilt)) return l;
    bool by_side = first == KIND_CAPSULE; /* axes are parallel side by side, faces one above the other */
    l.q = turn(chance_direction(c), x->tilt);
    l.towards = vec_unit(by_side ? vec(1, 0.1, 0.2) : vec(0.1, 0.2, 1));
    return l;
}

static void put_far(narrow_place *at, double distance)
{
    static const double AWAY[3] = {0.48, -0.6, 0.64};
    for (int i = 0; i < 3; i++) at->p[i] += distance * AWAY[i];
}

narrow_scene narrow_scene_create_extreme(
    const narrow_pair *pair, narrow_regime regime, size_t count, const narrow_extreme *x)
{
    chance c = {0xe57 + 16 * (uint64_t)(pair - narrow_pairs) + 4 * (uint64_t)regime};
    narrow_scene s = {.row = {pair->a, pair->b, regime, false, pair->curved ? 1e-6 : 1e-9, 0}, .count = count};
    s.body_count = 2 * count;
    s.items = allocate(s.count, sizeof *s.items);
    s.bodies = allocate(s.body_count, sizeof *s.bodies);
    for (size_t i = 0; i < count; i++) {
        narrow_body *body = &s.bodies[2 * i];
        body[0] = random_body(&c, pair->a, pair->hull_points, x->scale, x->aspect);
        body[1] = random_body(&c, pair->b, pair->hull_points, x->scale / x->ratio, x->aspect);
        shape a = narrow_scene_shape(&body[0]), b = narrow_scene_shape(&body[1]);
        pose at_a = random_pose(&c);
        at_a.p = vec_scale(at_a.p, x->scale);
        if (i % 2 == 0 && !isnan(x->tilt)) at_a.q = POSE_IDENTITY.q;
        lie l = extreme_lie(&c, regime, pair->a, x);
        pose at_b = pose_mul(at_a, lying(&a, &b, &l, regime));
        at_b.q = quat_unit(at_b.q);
        s.items[i] = (narrow_item){&body[0], &body[1], place_of(at_a), place_of(at_b), true};
        put_far(&s.items[i].at_a, x->distance);
        put_far(&s.items[i].at_b, x->distance);
    }
    return s;
}

static void destroy_polytope(narrow_kind kind, narrow_polytope *p)
{
    if (kind == KIND_HULL)
        hull_destroy((hull *)(uintptr_t)p->built);
    else
        mesh_destroy((mesh *)(uintptr_t)p->built);
    free(p->vertices);
    free(p->planes);
    free(p->face_first);
    free(p->face_vertices);
    free(p);
}

static void destroy_parts(narrow_parts *p)
{
    compound_destroy((compound *)(uintptr_t)p->built);
    free(p);
}

void narrow_scene_destroy(narrow_scene *s)
{
    for (size_t i = 0; i < s->body_count; i++)
        if (s->bodies[i].parts) destroy_parts((narrow_parts *)(uintptr_t)s->bodies[i].parts);
    for (size_t i = 0; i < s->body_count; i++)
        if (s->bodies[i].polytope)
            destroy_polytope(s->bodies[i].kind, (narrow_polytope *)(uintptr_t)s->bodies[i].polytope);
    free(s->items);
    free(s->bodies);
}
