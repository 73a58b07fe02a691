/* toi_lattice: the shapes, where they begin, and how they go on. */
#include "toi_lattice.h"

#include "geom/compound.h"
#include "solids.h"

#include <stdlib.h>

const char *const toi_lattice_way_names[LATTICE_WAYS] = {
    "slides", "approaches", "parts", "rests", "crosses", "turns", "orbits", "spins"};

static const double NOISE[] = {1e-15, 1e-13, 1e-11, 1e-9, 1e-7, 1e-5, 1e-3};
enum { NOISES = 7, SOLIDS = 3 };

static mesh *meshes[SOLIDS];
static compound *compounds[SOLIDS];

static mesh *mesh_of(soup s)
{
    mesh *m = soup_mesh(&s);
    soup_free(&s);
    return m;
}

/* An angle of two boxes, a dumb-bell, and a box on a cylinder. */
static void create_compounds(void)
{
    const shape box = {.type = SHAPE_BOX, .half = {1, 0.25, 0.25}}, ball = {.type = SHAPE_SPHERE, .radius = 0.5};
    const shape rod = {.type = SHAPE_CAPSULE, .radius = 0.125, .half = {0, 0, 1}};
    const shape drum = {.type = SHAPE_CYLINDER, .half = {0.5, 0.5, 0.25}};
    const quat straight = POSE_IDENTITY.q, quarter = {0.70710678118654752440, 0, 0, 0.70710678118654752440};
    const shape parts[SOLIDS][3] = {{box, box}, {rod, ball, ball}, {box, drum}};
    const pose at[SOLIDS][3] = {{{{0, 0, 0}, straight}, {{0.75, 1, 0}, quarter}},
        {{{0, 0, 0}, straight}, {{0, 0, 1}, straight}, {{0, 0, -1}, straight}},
        {{{0, 0, 0.5}, straight}, {{0, 0, 0}, straight}}};
    static const size_t COUNTS[SOLIDS] = {2, 3, 2};
    for (int i = 0; i < SOLIDS; i++)
        if (compound_build(parts[i], at[i], COUNTS[i], &compounds[i]) != COMPOUND_OK) abort();
}

void toi_lattice_create(void)
{
    cases_create();
    create_compounds();
    meshes[0] = mesh_of(soup_box(1, 0.5, 0.25, 2));
    meshes[1] = mesh_of(soup_trough());
    meshes[2] = mesh_of(soup_plane(1, 4));
}

void toi_lattice_destroy(void)
{
    for (int i = 0; i < SOLIDS; i++) compound_destroy(compounds[i]), mesh_destroy(meshes[i]);
    cases_destroy();
}

static int pick(random_state *r, int count)
{
    return (int)(random_bits(r) % (uint64_t)count);
}

static double eighths(random_state *r, int most) /* either way */
{
    return 0.125 * (pick(r, 2 * most + 1) - most);
}

static shape shape_of(random_state *r, int type)
{
    if (type < SHAPE_CONVEX_COUNT) return lattice_shape(r, (shape_type)type);
    double radius = pick(r, 4) == 0 ? 0.125 : 0;
    if (type == TOI_LATTICE_MESH) return mesh_shape(meshes[pick(r, SOLIDS)], radius);
    return (shape){.type = SHAPE_COMPOUND, .radius = radius, .compound = compounds[pick(r, SOLIDS)]};
}

static vec3 unit_axis(int k, double length)
{
    return vec(k == 0 ? length : 0, k == 1 ? length : 0, k == 2 ? length : 0);
}

static double *coordinate(vec3 *v, int k)
{
    return k == 0 ? &v->x : k == 1 ? &v->y : &v->z;
}

static double noise(random_state *r)
{
    return NOISE[pick(r, NOISES)] * (pick(r, 2) ? 1 : -1);
}

/* Moves B along an axis so that the gap along it is on the lattice, most often none: to within rounding. */
static double place_along(random_state *r, int axis, toi_pair *p)
{
    narrow_request ask = {.facts = NARROW_DISTANCE, .tolerance = 0, .range = INFINITY};
    narrow_result n;
    double gap = pick(r, 2) ? p->request.threshold : p->request.threshold + eighths(r, 8);
    vec3 *at = &p->b.motion.start.p;
    for (int k = 0; k < 3; k++) { /* the distance along the axis is that of the shapes if they face each other so */
        pose pa = pose_mul(p->a.motion.start, p->a.local), pb = pose_mul(p->b.motion.start, p->b.local);
        narrow_query_world(&p->shapes[0], pa, &p->shapes[1], pb, &ask, case_scratch(), &n);
        double d = 0.5 * (n.lo + n.hi);
        if (!isfinite(d)) return 0;
        *coordinate(at, axis) += (k == 0 ? nearbyint(512 * (gap - d)) / 512 : gap - d);
    }
    if (pick(r, 3)) *coordinate(at, axis) = nearbyint(64 * *coordinate(at, axis)) / 64;
    double off = pick(r, 3) == 0 ? noise(r) : 0;
    *coordinate(at, axis) += off;
    return gap + off;
}

static vec3 eighths_vec(random_state *r, int most)
{
    vec3 v = VEC_ZERO;
    for (int k = 0; k < 3; k++) *coordinate(&v, k) = pick(r, 2) ? eighths(r, most) : 0;
    return v;
}

/* rad over the span: eighths of a turn up to so many turns. */
static double some_turns(random_state *r)
{
    static const double TURNS[] = {0.125, 0.25, 0.25, 0.5, 0.5, 1, 1, 2, 7};
    return 2 * M_PI * TURNS[pick(r, 9)] * (pick(r, 2) ? 1 : -1);
}

static vec3 own_z(const toi_mover *m)
{
    return quat_rotate(quat_mul(m->motion.start.q, m->local.q), vec(0, 0, 1));
}

static void orbit(random_state *r, int axis, toi_pair *p)
{
    vec3 turn = unit_axis(axis, some_turns(r));
    toi_mover *b = &p->b;
    pose at = pose_mul(b->motion.start, b->local),
         centre = {p->a.motion.start.p, pick(r, 2) ? b->motion.start.q : POSE_IDENTITY.q};
    if (pick(r, 3) == 0) centre.p = vec_add(centre.p, eighths_vec(r, 8));
    b->local = pose_relative(centre, at);
    b->motion.start = centre;
    b->motion.angular = turn;
    if (pick(r, 2)) return;
    pose at_a = pose_mul(p->a.motion.start, p->a.local);
    p->a.local = pose_relative(centre, at_a);
    p->a.motion.start = centre;
    p->a.motion.angular = turn;
}

/* Displacements over the span. */
static void set_off(random_state *r, toi_lattice_way way, int axis, double gap, toi_pair *p)
{
    motion *a = &p->a.motion, *b = &p->b.motion;
    int other = (axis + 1 + pick(r, 2)) % 3;
    double turns = some_turns(r);
    switch (way) {
    case LATTICE_SLIDES:
        b->linear = unit_axis(other, eighths(r, 32));
        break;
    case LATTICE_APPROACHES: {
        double sign = *coordinate(&b->start.p, axis) < *coordinate(&a->start.p, axis) ? -1 : 1;
        double by = gap - p->request.threshold;
        b->linear = unit_axis(axis, -sign * (pick(r, 2) ? by : by + fabs(eighths(r, 32))));
        break;
    }
    case LATTICE_PARTS: {
        double sign = *coordinate(&b->start.p, axis) < *coordinate(&a->start.p, axis) ? -1 : 1;
        b->linear = unit_axis(axis, sign * fabs(eighths(r, 32)));
        if (pick(r, 2)) *coordinate(&b->linear, other) = eighths(r, 16);
        break;
    }
    case LATTICE_CROSSES:
        b->linear = eighths_vec(r, 32);
        break;
    case LATTICE_TURNS:
        if (pick(r, 2)) b->linear = eighths_vec(r, 16);
        if (pick(r, 3)) b->angular = unit_axis(pick(r, 3), turns);
        if (pick(r, 3)) a->angular = unit_axis(pick(r, 3), pick(r, 2) ? turns : some_turns(r));
        break;
    case LATTICE_ORBITS:
        orbit(r, axis, p);
        break;
    case LATTICE_SPINS:
        b->angular = vec_scale(own_z(&p->b), turns);
        if (pick(r, 2)) a->angular = vec_scale(own_z(&p->a), some_turns(r));
        if (pick(r, 2)) b->linear = unit_axis(other, eighths(r, 32));
        break;
    default:
        break;
    }
    vec3 common = pick(r, 3) == 0 ? eighths_vec(r, 32) : VEC_ZERO;
    a->linear = vec_add(a->linear, common);
    b->linear = vec_add(b->linear, common);
}

static void over(double span, motion *m)
{
    m->linear = vec_scale(m->linear, 1 / span);
    m->angular = vec_scale(m->angular, 1 / span);
}

static double reach_of(const toi_mover *m)
{
    return vec_norm(m->local.p) + (m->shape->type == SHAPE_HALFSPACE ? 1 : shape_reach(m->shape));
}

toi_lattice_way toi_lattice_make(uint64_t seed, int type_a, int type_b, toi_pair *p)
{
    static const double SPANS[] = {1, 1, 0.125, 1e-6, 1e-3, 1e3}, THRESHOLDS[] = {0, 0, 0, 0, 0.125, -0.125};
    static const double TOLERANCES[] = {1e-7, 1e-7, 1e-4, 1e-9};
    random_state r = {seed};
    shape first = shape_of(&r, type_a), second = shape_of(&r, type_b);
    bool ordered = narrow_ordered(&first, 0, &second, 1);
    p->shapes[0] = ordered ? first : second;
    p->shapes[1] = ordered ? second : first;
    p->a = (toi_mover){.shape = &p->shapes[0], .local = POSE_IDENTITY};
    p->b = (toi_mover){.shape = &p->shapes[1], .local = POSE_IDENTITY};
    shape ball = {.type = SHAPE_SPHERE, .radius = 1};
    bool wide_a = p->shapes[0].type == SHAPE_HALFSPACE, wide_b = p->shapes[1].type == SHAPE_HALFSPACE;
    lattice_poses(
        &r, wide_a ? &ball : &p->shapes[0], wide_b ? &ball : &p->shapes[1], &p->a.motion.start, &p->b.motion.start);
    if (pick(&r, 4) == 0)
        p->b.local = (pose){eighths_vec(&r, 8), {0.70710678118654752440, 0.70710678118654752440, 0, 0}};
    if (pick(&r, 6) == 0) p->a.local.p = eighths_vec(&r, 8);
    p->request = (toi_request){.span = SPANS[pick(&r, 6)], .threshold = THRESHOLDS[pick(&r, 6)]};
    int axis = pick(&r, 3);
    double gap = pick(&r, 4) ? place_along(&r, axis, p) : p->request.threshold;
    toi_lattice_way way = (toi_lattice_way)pick(&r, LATTICE_WAYS);
    set_off(&r, way, axis, gap, p);
    double far = vec_norm(vec_sub(p->b.motion.start.p, p->a.motion.start.p)) + vec_norm(p->a.motion.linear) +
                 vec_norm(p->b.motion.linear);
    p->size = reach_of(&p->a) + reach_of(&p->b) + far;
    p->request.tolerance = TOLERANCES[pick(&r, 4)] * p->size;
    over(p->request.span, &p->a.motion);
    over(p->request.span, &p->b.motion);
    return way;
}
