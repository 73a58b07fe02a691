/* impact_scene: random motions, drawn again until the truth is clear. */
#include "impact_scene.h"
#include "chance.h"

#include <stdlib.h>
#include <string.h>

enum { MESHES = 6 /* pairs of bodies in a scene with meshes, used again and again */, MESH_SHARE = 16, HALVINGS = 12 };

#define ROWS(pair, linear_us, turning_us, high_us)                                                                     \
    {pair " linear", pair, {0, 0}, false, linear_us}, {pair " to 0.7 rad", pair, {0.1, 0.7}, false, turning_us},       \
        {pair " to 3 rad", pair, {0.7, 3}, false, high_us},                                                            \
    {                                                                                                                  \
        pair " grazing", pair, {0, 0.3}, true, 0                                                                       \
    }

const impact_kind impact_kinds[] = {
    ROWS("sphere-box", 0.4, 0, 0),
    ROWS("box-box", 0.9, 1.6, 2.5),
    ROWS("hull64-hull64", 0, 0, 0),
    ROWS("mesh-box", 0, 0, 0),
    {"mesh-mesh to 0.7 rad", "mesh-mesh", {0.1, 0.7}, false, 0},
    {"rods 30-60 rad/s", NULL, {3, 6}, false, 0},
    {"rods 300-600 rad/s", NULL, {30, 60}, false, 0},
};
const size_t impact_kind_count = sizeof impact_kinds / sizeof *impact_kinds;

/* ---- motions ---- */

static void put(double out[3], vec3 v)
{
    out[0] = v.x, out[1] = v.y, out[2] = v.z;
}

static vec3 got(const double v[3])
{
    return vec(v[0], v[1], v[2]);
}

static motion motion_of(const impact_motion *m)
{
    return (motion){narrow_scene_pose(&m->start), got(m->linear), got(m->angular)};
}

narrow_place impact_place(const impact_motion *m, double time)
{
    motion moving = motion_of(m);
    pose p = motion_pose(&moving, time);
    return (narrow_place){{p.p.x, p.p.y, p.p.z}, {p.q.w, p.q.x, p.q.y, p.q.z}};
}

void impact_scene_movers(const impact_item *item, shape shapes[2], toi_mover movers[2])
{
    shapes[0] = narrow_scene_shape(item->a);
    shapes[1] = narrow_scene_shape(item->b);
    bool swap = !narrow_ordered(&shapes[0], 0, &shapes[1], 1);
    movers[swap] = (toi_mover){&shapes[0], POSE_IDENTITY, motion_of(&item->move_a)};
    movers[!swap] = (toi_mover){&shapes[1], POSE_IDENTITY, motion_of(&item->move_b)};
}

static toi_truth truth_of(const impact_item *item)
{
    static narrow_scratch *scratch;
    if (!scratch) scratch = aligned_alloc(64, narrow_scratch_size());
    if (!scratch) abort();
    shape shapes[2];
    toi_mover movers[2];
    impact_scene_movers(item, shapes, movers);
    toi_truth t = toi_truth_of(&movers[0], &movers[1], item->span, scratch);
    if (t.verdict == TRUTH_HIT && t.lo == 0) t.verdict = TRUTH_UNCLEAR; /* no impact: they begin in contact */
    return t;
}

size_t impact_pieces(const impact_item *item, double angle)
{
    double most = fmax(vec_norm(got(item->move_a.angular)), vec_norm(got(item->move_b.angular))) * item->span;
    return 1 + (size_t)(most / angle);
}

static impact_motion moving(vec3 at, quat q, vec3 linear, vec3 angular)
{
    impact_motion m = {.start = {.q = {q.w, q.x, q.y, q.z}}};
    put(m.start.p, at);
    put(m.linear, linear);
    put(m.angular, angular);
    return m;
}

static double reach_of(const impact_item *item)
{
    shape a = narrow_scene_shape(item->a), b = narrow_scene_shape(item->b);
    return shape_reach(&a) + shape_reach(&b);
}

/* B flies by A, or through it, at `aside` of the pair's reach, in one second; both turn. */
static void fly(chance *c, const impact_kind *kind, double aside, impact_item *item)
{
    double reach = reach_of(item), far = chance_in(c, 1.1, 2.5) * reach;
    vec3 along = chance_direction(c), away = vec_unit(vec_cross(along, chance_direction(c))),
         common = vec_scale(chance_direction(c), 3);
    vec3 at = chance_direction(c), from = vec_madd(vec_madd(at, -far, along), aside * reach, away);
    vec3 spin_a = vec_scale(chance_direction(c), chance_in(c, kind->turn[0], kind->turn[1]));
    vec3 spin_b = vec_scale(chance_direction(c), chance_in(c, kind->turn[0], kind->turn[1]));
    vec3 linear = vec_madd(common, far + chance_in(c, 0.2, 2) * reach, along);
    item->span = 1;
    item->move_a = moving(at, chance_rotation(c), common, spin_a);
    item->move_b = moving(from, chance_rotation(c), linear, spin_b);
}

/* The passing by at which they just touch, halved down to; then a little to one side. */
static void graze(chance *c, const impact_kind *kind, impact_item *item)
{
    chance seed = *c;
    double lo = 0, hi = 1.1;
    for (int k = 0; k < HALVINGS; k++) {
        *c = seed;
        fly(c, kind, 0.5 * (lo + hi), item);
        *(truth_of(item).verdict == TRUTH_FREE ? &hi : &lo) = 0.5 * (lo + hi);
    }
    double off = 1e-3 * pow(10, chance_in(c, 0, 1)), side = chance_in(c, -1, 1) < 0 ? lo - off : hi + off;
    *c = seed;
    fly(c, kind, side, item);
    c->x ^= (uint64_t)(1e9 * off);
}

/* Two rods that spin, mostly across their length, for a tenth of a second, while they drift. */
static void spin(chance *c, const impact_kind *kind, impact_item *item)
{
    double span = 0.1, reach = reach_of(item);
    vec3 at = chance_direction(c), from = vec_madd(at, chance_in(c, 0.4, 1.1) * reach, chance_direction(c));
    quat qa = chance_rotation(c), qb = chance_rotation(c);
    vec3 across_a = quat_rotate(qa, vec_unit(vec(chance_in(c, -1, 1), 1, chance_in(c, -0.3, 0.3))));
    vec3 across_b = quat_rotate(qb, vec_unit(vec(chance_in(c, -1, 1), 1, chance_in(c, -0.3, 0.3))));
    item->span = span;
    item->move_a = moving(at, qa, VEC_ZERO, vec_scale(across_a, chance_in(c, kind->turn[0], kind->turn[1]) / span));
    item->move_b = moving(from, qb, vec_scale(chance_direction(c), chance_in(c, 0, 5)),
        vec_scale(across_b, chance_in(c, kind->turn[0], kind->turn[1]) / span));
}

/* ---- scenes ---- */

static void *allocate(size_t count, size_t size)
{
    void *p = calloc(count, size);
    if (!p) abort();
    return p;
}

static narrow_body random_rod(chance *c)
{
    return (narrow_body){
        .kind = KIND_BOX, .half = {chance_in(c, 0.02, 0.05), chance_in(c, 0.02, 0.05), chance_in(c, 0.5, 1)}};
}

static const narrow_pair *pair_named(const char *name)
{
    for (size_t i = 0; i < narrow_pair_count; i++)
        if (strcmp(narrow_pairs[i].name, name) == 0) return &narrow_pairs[i];
    abort();
}

static size_t make_bodies(impact_scene *s, const impact_kind *kind, chance *c)
{
    if (!kind->pair) {
        s->rods = allocate(2 * s->count, sizeof *s->rods);
        for (size_t i = 0; i < 2 * s->count; i++) s->rods[i] = random_rod(c);
        s->a = s->b = KIND_BOX;
        return s->count;
    }
    const narrow_pair *pair = pair_named(kind->pair);
    s->a = pair->a, s->b = pair->b;
    size_t count = s->count;
    if (pair->b == KIND_MESH) s->count = count > MESH_SHARE ? count / MESH_SHARE : 1, count = MESHES;
    s->bodies = narrow_scene_create(pair, REGIME_SEPARATED, false, count);
    return count;
}

impact_scene impact_scene_create(const impact_kind *kind, size_t count)
{
    chance c = {0x1417ac7 + 64 * (uint64_t)(kind - impact_kinds)};
    impact_scene s = {.count = count};
    size_t bodies = make_bodies(&s, kind, &c);
    s.items = allocate(s.count, sizeof *s.items);
    s.truths = allocate(s.count, sizeof *s.truths);
    for (size_t i = 0; i < s.count;) {
        impact_item *item = &s.items[i];
        size_t k = i % bodies;
        item->a = s.rods ? &s.rods[2 * k] : s.bodies.items[k].a;
        item->b = s.rods ? &s.rods[2 * k + 1] : s.bodies.items[k].b;
        if (s.rods)
            spin(&c, kind, item);
        else if (kind->grazing)
            graze(&c, kind, item);
        else
            fly(&c, kind, chance_in(&c, 0, 0.9), item);
        s.truths[i] = truth_of(item);
        if (s.truths[i].verdict == TRUTH_UNCLEAR) continue;
        s.hits += s.truths[i].verdict == TRUTH_HIT;
        i++;
    }
    return s;
}

void impact_scene_destroy(impact_scene *s)
{
    free(s->items);
    free(s->truths);
    free(s->rods);
    narrow_scene_destroy(&s->bodies);
}
