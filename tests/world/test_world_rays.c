/* Rays in a world: the ordered walk and the closed forms against the general search, asked as a cast of a point, of one
 * body after the other; on hostile structure, near the origin and 1e7 m from it. And answers depend on nothing but the
 * world: not on the index, on the order in which bodies were made, or on where their fat boxes come from. */
#include "scene.h"

#include "base/prng.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

enum { BODIES = 60, RAYS = 2000 };

typedef struct thing {
    world_shape shape;
    pose at;
    char name[16];
} thing;

static const shape_type TYPES[] = {SHAPE_SPHERE, SHAPE_CAPSULE, SHAPE_BOX, SHAPE_CYLINDER, SHAPE_CONE, SHAPE_ELLIPSOID};
enum { TYPE_COUNT = sizeof TYPES / sizeof *TYPES };

static vec3 lattice(prng *r, int most)
{
    double at[3];
    for (int k = 0; k < 3; k++) at[k] = (int)prng_below(r, (uint32_t)(2 * most + 1)) - most;
    return vec(at[0], at[1], at[2]);
}

static quat draw_turn(prng *r)
{
    if (prng_below(r, 2)) return (quat){1, 0, 0, 0};
    return quat_unit((quat){prng_between(r, -1, 1), prng_between(r, -1, 1), prng_between(r, -1, 1), 0.3});
}

/* On a lattice, so that faces lie in one plane and bodies at the same distance; some flat, some off their origins. */
static void draw_things(prng *r, thing *things, vec3 offset)
{
    for (int i = 0; i < BODIES; i++) {
        thing *t = &things[i];
        *t = (thing){.shape.local = POSE_IDENTITY, .at = {vec_add(offset, lattice(r, 3)), draw_turn(r)}};
        shape *s = &t->shape.shape;
        s->type = TYPES[prng_below(r, TYPE_COUNT)];
        s->half = vec(0.5, 0.5, prng_below(r, 4) && s->type != SHAPE_BOX ? 0.75 : 0.5);
        if (s->type == SHAPE_BOX && prng_below(r, 4) == 0) s->half.z = 0;
        if (s->type == SHAPE_BOX && prng_below(r, 6) == 0) s->radius = 0.125;
        if (s->type == SHAPE_SPHERE || s->type == SHAPE_CAPSULE) s->radius = 0.5, s->half.x = s->half.y = 0;
        if (s->type == SHAPE_SPHERE) s->half.z = 0;
        if (prng_below(r, 3) == 0) t->shape.local = (pose){vec(0.25, -0.5, 0.125), draw_turn(r)};
        if (prng_below(r, 8) == 0) { /* on a long arm that is not turned */
            t->shape.local = (pose){vec(4096, -512, 0.125), draw_turn(r)};
            t->at = (pose){vec_sub(t->at.p, t->shape.local.p), {1, 0, 0, 0}};
        }
        snprintf(t->name, sizeof t->name, "b%02d", (i * 37) % BODIES);
    }
}

static uint32_t put(world *w, const thing *t)
{
    world_body def = {.name = t->name,
        .group = "",
        .category = 1,
        .mask = UINT64_MAX,
        .pose = t->at,
        .shapes = &t->shape,
        .shape_count = 1};
    uint32_t id = WORLD_NONE;
    assert_int_equal(world_put_body(w, &id, &def), WORLD_OK);
    return id;
}

typedef struct ray {
    vec3 from, direction;
    double length;
} ray;

/* Along axes and diagonals of the lattice, so through corners and along faces, from inside of bodies, too, and with no
 * length. */
static ray draw_ray(prng *r, vec3 offset)
{
    ray q = {vec_add(offset, lattice(r, 5)), lattice(r, 1), prng_below(r, 3) ? INFINITY : prng_between(r, 0, 8)};
    if (prng_below(r, 3) == 0) q.from = vec_add(q.from, vec(0.5, 0.25, 0.5));
    if (prng_below(r, 3) == 0) q.direction = vec_sub(vec_add(offset, lattice(r, 3)), q.from);
    if (prng_below(r, 10) == 0) q.length = 0;
    if (vec_norm2(q.direction) == 0) q.direction = vec(0, -1, 0);
    return q;
}

static bool ask_ray(const world *w, const ray *q, world_hit *hit)
{
    world_hits hits = {0};
    world_query_ray(w, q->from, q->direction, q->length, 0, SECOND, &hits);
    assert_true(hits.count <= 1 && !hits.gave_up);
    bool met = hits.count == 1;
    if (met) *hit = hits.at[0];
    free(hits.at);
    return met;
}

/* A point that is cast takes no closed form. */
static bool ask_general(const world *w, const ray *q, world_hit *hit)
{
    world_hits hits = {0};
    world_query_cast(w, (pose){q->from, {1, 0, 0, 0}}, VEC_ZERO, q->direction, q->length, 0, SECOND, &hits);
    bool met = hits.count == 1;
    if (met) *hit = hits.at[0];
    free(hits.at);
    return met;
}

static bool is_same(bool met, const world_hit *x, bool other_met, const world_hit *y)
{
    if (met != other_met) return false;
    return !met || (strcmp(x->name_a, y->name_a) == 0 && x->lo == y->lo && x->hi == y->hi &&
                       vec_equal(x->axis, y->axis) && vec_equal(x->point_a, y->point_a));
}

/* Of all bodies, each alone in a world of its own: both methods bracket the same length, and who has the first place
 * among all is who comes first alone. */
static void the_first_hit_is_that_of_all_bodies_one_by_one(void **state)
{
    (void)state;
    static const double offsets[] = {0, 1e7, -1e7 / 3};
    int hits = 0, ties = 0, sharper = 0;
    for (int k = 0; k < 3; k++) {
        prng r = {100 + (uint64_t)k};
        vec3 offset = vec(offsets[k], 0, -offsets[k]);
        thing things[BODIES];
        draw_things(&r, things, offset);
        world *all = scene_world(1, true), *alone[BODIES];
        for (int i = 0; i < BODIES; i++) {
            put(all, &things[i]);
            put(alone[i] = scene_world(1, true), &things[i]);
            scene_tick(alone[i], SECOND);
        }
        scene_tick(all, SECOND);
        for (int n = 0; n < RAYS; n++) {
            ray q = draw_ray(&r, offset);
            world_hit first, hit, general, best = {.lo = INFINITY};
            bool met = ask_ray(all, &q, &first);
            int equal = 0;
            for (int i = 0; i < BODIES; i++) {
                bool one = ask_ray(alone[i], &q, &hit), other = ask_general(alone[i], &q, &general);
                /* Who touches for certain is a hit by both; who is one by either has brackets that meet. */
                if (one && hit.hi < INFINITY) assert_true(other);
                if (other && general.hi < INFINITY) assert_true(one || general.hi > q.length);
                if (one && other) assert_true(hit.lo <= general.hi && general.lo <= hit.hi);
                if (one && other && hit.hi < INFINITY) sharper += hit.hi - hit.lo < general.hi - general.lo;
                if (!one || hit.lo > best.lo) continue;
                equal += hit.lo == best.lo;
                if (hit.lo < best.lo || strcmp(hit.name_a, best.name_a) < 0) best = hit;
            }
            if (met != isfinite(best.lo) || (met && !is_same(true, &first, true, &best)))
                fail_msg("offset %g, ray %d: %s at %.17g, alone %s at %.17g", offsets[k], n,
                    met ? first.name_a : "none", met ? first.lo : 0, isfinite(best.lo) ? best.name_a : "none", best.lo);
            hits += met;
            ties += equal > 0;
        }
        for (int i = 0; i < BODIES; i++) world_destroy(alone[i]);
        world_destroy(all);
    }
    print_message("%d hits, %d ties, %d sharper\n", hits, ties, sharper);
    assert_true(hits > RAYS / 2 && ties > 5 && sharper > RAYS / 2);
}

/* Made in the other order, found by other indices, and come from elsewhere in steps that leave other fat boxes. */
static world *world_of(const thing *things, broad_kind broad, bool backward, bool moved)
{
    world_options o = world_options_default();
    o.workers = 1;
    o.broad = broad;
    world *w = world_create(&o);
    uint32_t ids[BODIES];
    for (int i = 0; i < BODIES; i++) {
        thing t = things[backward ? BODIES - 1 - i : i];
        if (moved) t.at.p = vec_add(t.at.p, vec(0.04, -0.03, 0.02));
        ids[i] = put(w, &t);
    }
    scene_tick(w, SECOND);
    for (int i = 0; moved && i < BODIES; i++) {
        const thing *t = &things[backward ? BODIES - 1 - i : i];
        assert_int_equal(world_move_body(w, ids[i], t->at, 0, NULL, NULL), WORLD_OK);
    }
    scene_tick(w, SECOND);
    return w;
}

static void answers_depend_on_the_world_alone(void **state)
{
    (void)state;
    prng r = {7};
    thing things[BODIES];
    draw_things(&r, things, VEC_ZERO);
    /* Three in one place: of equal ones the first name is told. */
    things[1] = things[2] = things[0];
    snprintf(things[1].name, sizeof things[1].name, "a1");
    snprintf(things[2].name, sizeof things[2].name, "a0");
    world *worlds[] = {world_of(things, BROAD_TREE, false, false), world_of(things, BROAD_TREE, true, false),
        world_of(things, BROAD_SWEEP3, false, false), world_of(things, BROAD_SWEEP1, true, false),
        world_of(things, BROAD_TREE, false, true), world_of(things, BROAD_SWEEP3, true, true)};
    static const double TOLERANCES[] = {
        0, 1e-3, 0.3}; /* with coarse ones it is a hit to come near what has no formula */
    enum { WORLDS = sizeof worlds / sizeof *worlds };
    int first_names = 0;
    for (int n = 0; n < 3 * RAYS; n++) {
        ray q = draw_ray(&r, VEC_ZERO);
        world_hits first = {0};
        for (int k = 0; k < WORLDS; k++) {
            world_hits hits = {0};
            world_query_ray(worlds[k], q.from, q.direction, q.length, TOLERANCES[n % 3], SECOND, &hits);
            if (k == 0) {
                first = hits;
                continue;
            }
            bool met = first.count > 0, other = hits.count > 0;
            if (!is_same(met, first.at, other, hits.at))
                fail_msg("ray %d, world %d: %s at %.17g, not %s at %.17g", n, k, other ? hits.at[0].name_a : "none",
                    other ? hits.at[0].lo : 0, met ? first.at[0].name_a : "none", met ? first.at[0].lo : 0);
            free(hits.at);
        }
        if (first.count) {
            assert_true(strcmp(first.at[0].name_a, "a1") != 0 && strcmp(first.at[0].name_a, things[0].name) != 0);
            first_names += strcmp(first.at[0].name_a, "a0") == 0;
        }
        free(first.at);
    }
    assert_true(first_names > 0);
    for (int k = 0; k < WORLDS; k++) world_destroy(worlds[k]);
}

/* Rays at corners and along edges of a cube that stands anywhere: the same bits, as long as its position is exact. */
static void a_cube_answers_the_same_anywhere(void **state)
{
    (void)state;
    static const double offsets[] = {0, 1e7, 0x1p40};
    const world_shape cube = {.shape = {.type = SHAPE_BOX, .half = {1, 1, 1}}, .local = POSE_IDENTITY};
    static const double RAYS_AT[][6] = {{-4, 1, 1, 1, 0, 0}, {-4, 1, 0, 1, 0, 0}, {-4, -4, -4, 1, 1, 1},
        {-4, 0.5, 0.25, 1, 0, 0}, {1, 1, 9, 0, 0, -1}, {0, 0, 0, 1, 0, 0}, {1, 0, 0, 1, 0, 0},
        {-3, 1.0625, 0, 1, 0, 0}};
    for (size_t i = 0; i < sizeof RAYS_AT / sizeof *RAYS_AT; i++) {
        const double *at = RAYS_AT[i];
        world_hit hits[3];
        bool met[3];
        for (int k = 0; k < 3; k++) {
            vec3 offset = vec(offsets[k], offsets[k], 0);
            world *w = scene_world(1, true);
            scene_body(w, "cube", cube, offset);
            scene_tick(w, SECOND);
            ray q = {vec_add(offset, vec(at[0], at[1], at[2])), vec(at[3], at[4], at[5]), INFINITY};
            met[k] = ask_ray(w, &q, &hits[k]);
            world_destroy(w);
            assert_true(met[k] == met[0] && (!met[k] || (hits[k].lo == hits[0].lo && hits[k].hi == hits[0].hi)));
        }
        assert_true(met[0] == (i != 7));
        if (i == 3) assert_true(hits[0].lo <= 3 && 3 <= hits[0].hi && hits[0].hi - hits[0].lo < 1e-12);
        if (i == 5) assert_true(hits[0].lo == 0 && hits[0].hi == 0);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_first_hit_is_that_of_all_bodies_one_by_one),
        cmocka_unit_test(answers_depend_on_the_world_alone),
        cmocka_unit_test(a_cube_answers_the_same_anywhere),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
