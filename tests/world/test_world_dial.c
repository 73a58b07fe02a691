/* The dial: how far a pair is looked into follows from what is asked, and from the budget of a tick. Whatever the dial
 * says, what was told last of a pair contains the truth, nothing that touches is missed, and the events are the same
 * for any number of workers, with caches and without. */
#include "base/prng.h"
#include "geom/compound.h"
#include "geom/hull.h"
#include "geom/mesh.h"
#include "scene.h"
#include "world/saved.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

enum { BODIES = 33, KINDS = 10 };
static const int64_t TICK_NS = SECOND / 100;

/* ---- a scene of all kinds of shapes ---- */

typedef struct told { /* what a subscriber knows of a pair */
    bool touches, near;
    double lo, hi;
    uint8_t achieved;
} told;

typedef struct run {
    world *w;
    uint64_t random;
    uint32_t ids[BODIES];
    shape shapes[BODIES];
    pose at[BODIES];
    compound *corner;
    hull *stone;
    mesh *dented;
    uint32_t subscription;
    world_subscription terms;
    told of[BODIES][BODIES];
    size_t undone, stopped, checked; /* told last; cumulative */
    uint64_t grant, given;           /* units a tick; in slices as large as `given` */
    uint64_t work[4000];             /* that ticks did */
    void *scratch;
    int tick;
} run;

static compound *make_corner(void)
{
    const shape parts[2] = {{.type = SHAPE_BOX, .half = {0.5, 0.1, 0.1}}, {.type = SHAPE_BOX, .half = {0.1, 0.5, 0.1}}};
    const pose locals[2] = {POSE_IDENTITY, {{-0.4, 0.4, 0}, {1, 0, 0, 0}}};
    compound *c;
    assert_int_equal(compound_build(parts, locals, 2, &c), COMPOUND_OK);
    return c;
}

static hull *make_stone(void)
{
    double points[3 * 20];
    uint64_t random = 3;
    for (int i = 0; i < 60; i++) points[i] = prng_in(&random, -0.3, 0.3);
    hull *h;
    assert_int_equal(hull_build(points, 20, 0, &h), HULL_OK);
    return h;
}

/* A cube with a dent in its top. */
static mesh *make_dented(void)
{
    static const double POINTS[27] = {-0.3, -0.3, -0.3, 0.3, -0.3, -0.3, 0.3, 0.3, -0.3, -0.3, 0.3, -0.3, -0.3, -0.3,
        0.3, 0.3, -0.3, 0.3, 0.3, 0.3, 0.3, -0.3, 0.3, 0.3, 0, 0, 0};
    static const int32_t CORNERS[42] = {0, 2, 1, 0, 3, 2, 0, 1, 5, 0, 5, 4, 1, 2, 6, 1, 6, 5, 2, 3, 7, 2, 7, 6, 3, 0, 4,
        3, 4, 7, 4, 5, 8, 5, 6, 8, 6, 7, 8, 7, 4, 8};
    mesh *m;
    assert_int_equal(mesh_build(POINTS, 9, CORNERS, 14, &m), MESH_OK);
    assert_true(m->solid);
    return m;
}

static shape make_shape(run *r, int i)
{
    static const shape_type TYPES[KINDS] = {SHAPE_SPHERE, SHAPE_CAPSULE, SHAPE_BOX, SHAPE_CYLINDER, SHAPE_CONE,
        SHAPE_ELLIPSOID, SHAPE_COMPOUND, SHAPE_BOX, SHAPE_HULL, SHAPE_MESH};
    shape s = {.type = i ? TYPES[i % KINDS] : SHAPE_HALFSPACE};
    double x = prng_in(&r->random, 0.1, 0.4), y = prng_in(&r->random, 0.1, 0.4), z = prng_in(&r->random, 0.1, 0.4);
    if (s.type == SHAPE_SPHERE || s.type == SHAPE_CAPSULE) s.radius = x;
    if (s.type == SHAPE_CAPSULE) s.half.z = z;
    if (s.type == SHAPE_BOX || s.type == SHAPE_ELLIPSOID) s.half = vec(x, y, z);
    if (s.type == SHAPE_CYLINDER || s.type == SHAPE_CONE) s.half = vec(x, x, z);
    if (s.type == SHAPE_COMPOUND) s.compound = r->corner;
    if (s.type == SHAPE_HULL) s.hull = r->stone;
    if (s.type == SHAPE_MESH) s.mesh = r->dented, s.hull = r->dented->hull;
    if (i % KINDS == 7) s.deviation = 0.01;
    return s;
}

static void put(run *r, int i)
{
    char name[16];
    snprintf(name, sizeof name, "b%d", i);
    world_shape one = {.shape = r->shapes[i], .local = POSE_IDENTITY};
    world_body def = {.name = name,
        .group = "",
        .category = 1,
        .mask = 1,
        .fixed = i == 0,
        .pose = r->at[i],
        .shapes = &one,
        .shape_count = 1};
    r->ids[i] = WORLD_NONE;
    assert_int_equal(world_put_body(r->w, &r->ids[i], &def), WORLD_OK);
}

static void move(run *r, double step)
{
    for (int i = 1; i < BODIES; i++) {
        if (prng_bits(&r->random) % 8 == 0) continue;
        vec3 by = vec(prng_in(&r->random, -1, 1), prng_in(&r->random, -1, 1), prng_in(&r->random, -1, 1));
        vec3 to = vec_madd(r->at[i].p, step, by);
        r->at[i].p = vec_max(vec_min(to, vec(1.2, 1.2, 1.2)), vec(-1.2, -1.2, -1.2));
        quat q = r->at[i].q;
        q.x += step * by.y;
        q.z += step * by.x;
        r->at[i].q = quat_unit(q);
        bool jumps = prng_bits(&r->random) % 400 == 0;
        (jumps ? world_teleport_body : world_move_body)(r->w, r->ids[i], r->at[i], 0, NULL, NULL);
    }
}

static void begin(run *r, const world_options *options, const world_subscription *terms)
{
    *r = (run){.w = world_create(options),
        .random = 7,
        .corner = make_corner(),
        .stone = make_stone(),
        .dented = make_dented(),
        .terms = *terms,
        .scratch = aligned_alloc(64, (narrow_scratch_size() + 63) / 64 * 64)};
    for (int i = 0; i < BODIES; i++) {
        r->shapes[i] = make_shape(r, i);
        r->at[i] = POSE_IDENTITY;
        r->at[i].p = vec(prng_in(&r->random, -1, 1), prng_in(&r->random, -1, 1), prng_in(&r->random, -1, 1));
        if (i == 0) r->at[i].p = vec(0, 0, -1);
        put(r, i);
    }
    if (terms->facts) r->subscription = scene_subscription(r->w, terms);
}

static void end(run *r)
{
    world_destroy(r->w);
    compound_destroy(r->corner);
    hull_destroy(r->stone);
    mesh_destroy(r->dented);
    free(r->scratch);
}

static int number_of(const char *name)
{
    return atoi(name + 1);
}

static void learn(run *r, const world_batch *b)
{
    if (b->snapshot) return;
    r->undone = b->undone;
    for (size_t n = 0; n < b->count; n++) {
        const world_event *e = &b->events[n];
        told *t = &r->of[number_of(e->name_a)][number_of(e->name_b)];
        if (number_of(e->name_a) < number_of(e->name_b)) t = &r->of[number_of(e->name_b)][number_of(e->name_a)];
        if (e->kind == EVENT_BEGIN) t->touches = true;
        if (e->kind == EVENT_END) t->touches = false;
        if (e->kind == EVENT_NEAR) t->near = true;
        if (e->kind == EVENT_FAR) t->near = false;
        t->lo = e->lo;
        t->hi = e->hi;
        t->achieved = e->achieved;
        r->stopped += e->achieved == WORLD_STOPPED;
        assert_true(e->lo <= e->hi);
    }
}

static uint64_t tick(run *r)
{
    world_batches out;
    world_tick(r->w, ++r->tick * TICK_NS, &out);
    for (size_t i = 0; i < out.count; i++)
        if (out.at[i].subscription == r->subscription) learn(r, &out.at[i]);
    r->work[r->tick] = world_get_figures(r->w).work;
    return out.hash;
}

static narrow_result truth_of(const run *r, int i, int k)
{
    narrow_request ask = {.facts = NARROW_DISTANCE, .tolerance = 1e-9, .range = INFINITY};
    narrow_result n;
    narrow_query_world(&r->shapes[i], r->at[i], &r->shapes[k], r->at[k], &ask, r->scratch, &n);
    return n;
}

/* Who touches is told to touch, who is near to be near, and what was told last of them holds. */
static void what_was_told_holds(run *r)
{
    for (int i = 0; i < BODIES; i++)
        for (int k = 0; k < i; k++) {
            const told *t = &r->of[i][k];
            narrow_result n = truth_of(r, i, k);
            if (r->terms.facts & WORLD_TOUCH && n.hi <= r->terms.threshold && !t->touches)
                fail_msg("tick %d: b%d and b%d touch, [%g, %g]", r->tick, i, k, n.lo, n.hi);
            if (r->terms.facts & WORLD_DISTANCE && n.hi <= r->terms.range && !t->near)
                fail_msg("tick %d: b%d and b%d are near, [%g, %g]", r->tick, i, k, n.lo, n.hi);
            if (!t->touches && !t->near) continue;
            r->checked++;
            if (n.hi < t->lo || n.lo > t->hi)
                fail_msg("tick %d: b%d and b%d: told [%g, %g], true [%g, %g]", r->tick, i, k, t->lo, t->hi, n.lo, n.hi);
        }
}

/* ---- accuracy ---- */

static const world_subscription NEAR = {
    .facts = WORLD_TOUCH | WORLD_DISTANCE, .select_a = "*", .select_b = "*", .range = 0.3, .relative_tolerance = 1e-6};

static int ticks_to_run(void)
{
    return getenv("COLLIDED_NIGHTLY") ? 3000 : getenv("COLLIDED_BRIEF") ? 40 : 200;
}

static void what_was_told_holds_at_any_accuracy(void **state)
{
    (void)state;
    static run r;
    static const struct {
        world_accuracy accuracy;
        double relative;
    } DIAL[] = {{WORLD_BY_BOXES, 0}, {WORLD_BY_TOLERANCE, 1e-3}, {WORLD_BY_TOLERANCE, 1e-9}, {WORLD_BY_VERDICT, 0}};
    world_options options = world_options_default();
    for (size_t d = 0; d < sizeof DIAL / sizeof *DIAL; d++) {
        world_subscription terms = NEAR;
        terms.accuracy = DIAL[d].accuracy;
        terms.relative_tolerance = DIAL[d].relative;
        if (terms.accuracy == WORLD_BY_VERDICT) terms.facts = WORLD_TOUCH;
        begin(&r, &options, &terms);
        for (int t = 0; t < ticks_to_run(); t++) {
            if (t) move(&r, 0.02);
            tick(&r);
            what_was_told_holds(&r);
        }
        world_figures f = world_get_figures(r.w);
        print_message("accuracy %d, %g: %zu told intervals held, %llu queries, %llu bounds, %llu stood\n",
            terms.accuracy, terms.relative_tolerance, r.checked, (unsigned long long)f.narrow_queries,
            (unsigned long long)f.stages[STAGE_BOUNDS], (unsigned long long)f.stages[STAGE_STANDING]);
        assert_true(r.checked > 1000);
        assert_int_equal(f.manifolds, 0); /* nobody asked */
        if (terms.accuracy == WORLD_BY_BOXES)
            assert_true(f.narrow_queries == 0 && f.stages[STAGE_STANDING] > f.stages[STAGE_BOUNDS]);
        end(&r);
    }
}

static void an_interval_is_as_narrow_as_asked_and_says_what_it_is(void **state)
{
    (void)state;
    static const double RELATIVE[] = {1e-3, 1e-6, 1e-9, 1e-12};
    static run r;
    world_options options = world_options_default();
    for (size_t d = 0; d < sizeof RELATIVE / sizeof *RELATIVE; d++) {
        world_subscription terms = NEAR;
        terms.relative_tolerance = RELATIVE[d];
        begin(&r, &options, &terms);
        tick(&r);
        size_t narrow = 0, wide = 0;
        for (int i = 1; i < BODIES; i++) {
            for (int k = 1; k < i; k++) {
                const told *t = &r.of[i][k];
                double size = shape_reach(&r.shapes[i]) + shape_reach(&r.shapes[k]);
                bool easy = i % KINDS < 6 && k % KINDS < 6; /* no compounds, no deviations */
                if (!t->near || !easy) continue;
                double limit = t->touches ? terms.threshold : terms.range;
                bool fits = t->hi - t->lo <= RELATIVE[d] * size;
                narrow += fits;
                wide += !fits;
                if (!fits) assert_int_equal(t->achieved, WORLD_WIDE);
                if (fits && t->achieved != WORLD_WIDE)
                    assert_int_equal(t->achieved, t->hi <= limit ? WORLD_CERTAIN : WORLD_WITHIN);
            }
        }
        print_message("relative %g: %zu narrow, %zu wide\n", RELATIVE[d], narrow, wide);
        assert_true(narrow > 10 * wide || RELATIVE[d] < 1e-6);
        end(&r);
    }
}

/* Two balls that touch to within an ulp or two: a verdict is certain where an interval within a tolerance is not. */
static void a_verdict_is_certain_where_an_interval_is_not(void **state)
{
    (void)state;
    static const world_accuracy ACCURACIES[2] = {WORLD_BY_VERDICT, WORLD_BY_TOLERANCE};
    for (int i = 0; i < 2; i++) {
        world *w = scene_world(1, true);
        world_subscription terms = {.facts = WORLD_TOUCH,
            .select_a = "*",
            .select_b = "*",
            .threshold = 0.25,
            .relative_tolerance = 1e-3,
            .accuracy = ACCURACIES[i]};
        scene_subscription(w, &terms);
        scene_sphere(w, "a", 0, 0.5);
        scene_sphere(w, "b", 1.2499999999, 0.5);
        const world_batch *b = scene_tick(w, 1);
        assert_true(b && b->count == 1 && b->events[0].hi <= 0.25 && b->events[0].achieved == WORLD_CERTAIN);
        world_destroy(w);
    }
}

/* ---- only what is asked ---- */

static void the_events_do_not_depend_on_workers_or_caches(void **state)
{
    (void)state;
    static run r;
    uint64_t first = 0;
    for (unsigned workers = 1; workers <= 4; workers++)
        for (int caches = 0; caches < 2; caches++) {
            world_options options = world_options_default();
            world_subscription terms = NEAR;
            options.workers = workers;
            options.caches = caches;
            terms.accuracy = WORLD_BY_BOXES;
            begin(&r, &options, &terms);
            uint64_t hash = 0;
            for (int t = 0; t < 60; t++) {
                if (t) move(&r, 0.02);
                hash = tick(&r);
            }
            end(&r);
            if (!first) first = hash;
            assert_true(hash == first);
        }
}

/* Each change counts from the next tick on. */
static void subscriptions_come_and_change_and_go_in_the_next_tick(void **state)
{
    (void)state;
    static run r;
    world_options options = world_options_default();
    world_subscription terms = {.select_a = "*"};
    begin(&r, &options, &terms); /* nobody asks */
    tick(&r);
    move(&r, 0.02);
    tick(&r);
    world_figures none = world_get_figures(r.w);
    assert_true(none.narrow_queries == 0 && none.pair_ticks == 0 && none.pairs == 0);

    terms = NEAR;
    terms.accuracy = WORLD_BY_BOXES;
    r.terms = terms;
    r.subscription = scene_subscription(r.w, &terms);
    tick(&r);
    world_figures boxes = world_get_figures(r.w);
    assert_true(boxes.stages[STAGE_BOUNDS] > 100 && boxes.narrow_queries == 0);
    what_was_told_holds(&r);

    terms.accuracy = WORLD_BY_TOLERANCE;
    assert_int_equal(world_put_subscription(r.w, &r.subscription, &terms), WORLD_OK);
    tick(&r);
    world_figures fine = world_get_figures(r.w);
    assert_true(fine.narrow_queries > 100 && fine.manifolds == 0);
    what_was_told_holds(&r);

    terms.facts |= WORLD_MANIFOLD;
    uint32_t other = scene_subscription(r.w, &terms);
    tick(&r);
    assert_true(world_get_figures(r.w).manifolds > 10);

    world_remove_subscription(r.w, other, CAUSE_SUBSCRIPTION);
    tick(&r);
    world_figures before = world_get_figures(r.w);
    move(&r, 0.02);
    tick(&r);
    assert_int_equal(world_get_figures(r.w).manifolds, before.manifolds);

    world_remove_subscription(r.w, r.subscription, CAUSE_SUBSCRIPTION);
    tick(&r);
    before = world_get_figures(r.w);
    move(&r, 0.02);
    tick(&r);
    world_figures after = world_get_figures(r.w);
    assert_true(after.narrow_queries == before.narrow_queries && after.pair_ticks == before.pair_ticks);
    end(&r);
}

static void who_asks_pays_and_shared_pairs_are_split(void **state)
{
    (void)state;
    static run r;
    world_options options = world_options_default();
    begin(&r, &options, &NEAR);
    tick(&r);
    uint64_t alone = world_subscription_work(r.w, r.subscription);
    end(&r);
    begin(&r, &options, &NEAR);
    uint32_t other = scene_subscription(r.w, &NEAR);
    world_subscription nobody = NEAR;
    nobody.select_a = "no body";
    uint32_t idle = scene_subscription(r.w, &nobody);
    tick(&r);
    uint64_t one = world_subscription_work(r.w, r.subscription), two = world_subscription_work(r.w, other);
    assert_true(alone > 10000 && one == two && one + two <= alone && one + two > alone - 1000);
    assert_int_equal(world_subscription_work(r.w, idle), 0);
    end(&r);
}

enum { MANY = 10000 };

/* 10,000 bodies on the move through each other. */
static void with_no_subscription_nothing_is_looked_at(void **state)
{
    (void)state;
    world *w = scene_world(1, true);
    static uint32_t ids[MANY];
    char name[16];
    for (int i = 0; i < MANY; i++) {
        snprintf(name, sizeof name, "b%d", i);
        ids[i] = scene_sphere(w, name, 0.4 * i, 0.5);
    }
    for (int t = 1; t <= 5; t++) {
        for (int i = 0; i < MANY; i++) scene_move(w, ids[i], 0.4 * i + 0.1 * t * (i % 3), 0);
        scene_tick(w, t);
    }
    world_figures f = world_get_figures(w);
    assert_true(f.moves == 5 * MANY && f.pairs == 0 && f.pair_ticks == 0);
    assert_true(f.narrow_queries == 0 && f.manifolds == 0 && f.sweeps == 0);
    world_subscription touches = scene_all(WORLD_TOUCH, 0);
    scene_subscription(w, &touches);
    scene_tick(w, 6);
    f = world_get_figures(w);
    assert_true(f.narrow_queries >= MANY - 1 && f.manifolds == 0);
    world_destroy(w);
}

/* ---- the budget ---- */

static uint64_t grant(void *context, uint64_t done)
{
    run *r = context;
    uint64_t more = r->given ? done + r->given : r->grant;
    return more < r->grant ? more : r->grant;
}

static uint64_t grant_as_before(void *context, uint64_t done)
{
    (void)done;
    const run *r = context;
    return r->work[r->tick];
}

static uint64_t play(run *r, const world_options *options, world_grant *by, uint64_t units, uint64_t slice, bool check)
{
    static uint64_t work[4000];
    memcpy(work, r->work, sizeof work);
    begin(r, options, &NEAR);
    memcpy(r->work, work, sizeof work);
    r->grant = units;
    r->given = slice;
    world_set_budget(r->w, by, r);
    uint64_t hash = 0;
    for (int t = 0; t < ticks_to_run(); t++) {
        if (t) move(r, 0.02);
        hash = tick(r);
        if (check) what_was_told_holds(r);
    }
    return hash;
}

static void with_a_budget_nothing_is_missed_and_what_was_told_holds(void **state)
{
    (void)state;
    static run r;
    static const uint64_t UNITS[] = {0, 3000, 30000, 60000, UINT64_MAX};
    world_options options = world_options_default();
    for (size_t i = 0; i < sizeof UNITS / sizeof *UNITS; i++) {
        play(&r, &options, grant, UNITS[i], UNITS[i] < UINT64_MAX ? 20000 : 0, true);
        world_figures f = world_get_figures(r.w);
        print_message("%llu units: %zu intervals held, %zu told as stopped, %llu ticks left something, %llu queries\n",
            (unsigned long long)UNITS[i], r.checked, r.stopped, (unsigned long long)f.undone_ticks,
            (unsigned long long)f.narrow_queries);
        assert_true(f.work <= UNITS[i]);
        assert_int_equal(f.undone, r.undone); /* of the only subscription */
        if (UNITS[i] < 60000) assert_true(f.undone > 0 && r.stopped > 0);
        if (UNITS[i] == 0) assert_true(f.unbounded > 0 && f.narrow_queries == 0);
        if (UNITS[i] == UINT64_MAX) assert_true(f.undone_ticks == 0 && r.stopped == 0);
        end(&r);
    }
}

static void a_replay_with_the_recorded_units_is_the_same(void **state)
{
    (void)state;
    static run r;
    world_options options = world_options_default();
    for (uint64_t units = 4000; units <= 64000; units *= 4) {
        options.workers = 1;
        options.caches = true;
        uint64_t hash = play(&r, &options, grant, units, 9000, false);
        end(&r);
        for (unsigned workers = 1; workers <= 8; workers++) {
            options.workers = workers;
            options.caches = workers % 2;
            assert_true(play(&r, &options, grant_as_before, 0, 0, false) == hash);
            end(&r);
        }
    }
}

static int64_t name_of(const void *context, const shape *s)
{
    (void)context;
    return s->mesh ? 2 : 1;
}

static bool lend(const void *context, int64_t number, shape *to)
{
    const run *r = context;
    to->hull = number == 2 ? r->dented->hull : r->stone;
    to->mesh = number == 2 ? r->dented : NULL;
    return number == 1 || number == 2;
}

/* As a standby gets it. */
static void be_reborn(run *r, const world_options *options, world_grant *by)
{
    const world_lender lender = {.context = r, .name_of = name_of, .lend = lend};
    bytes_out bytes = {0};
    world_save(r->w, &lender, &bytes);
    world_destroy(r->w);
    r->w = world_create(options);
    world_set_budget(r->w, by, r);
    bytes_in from = {.at = bytes.at, .left = bytes.count};
    assert_null(world_restore(r->w, &lender, &from));
    array_free(&bytes);
}

/* What was looked at last says where bounds begin, and they are told: a standby needs to know it. */
static void a_restored_world_goes_on_alike(void **state)
{
    (void)state;
    static run r;
    static uint64_t hashes[4000];
    world_options options = world_options_default();
    for (uint64_t units = 4000; units <= 64000; units *= 4) {
        begin(&r, &options, &NEAR);
        r.grant = units;
        world_set_budget(r.w, grant, &r);
        for (int t = 0; t < ticks_to_run(); t++) {
            if (t) move(&r, 0.02);
            hashes[t] = tick(&r);
        }
        end(&r);
        uint64_t work[4000];
        memcpy(work, r.work, sizeof work);
        begin(&r, &options, &NEAR);
        memcpy(r.work, work, sizeof work);
        world_set_budget(r.w, grant_as_before, &r);
        for (int t = 0; t < ticks_to_run(); t++) {
            if (t % 8 == 7) be_reborn(&r, &options, grant_as_before);
            if (t) move(&r, 0.02);
            if (tick(&r) != hashes[t]) fail_msg("with %llu units tick %d differs", (unsigned long long)units, t);
        }
        end(&r);
    }
}

/* Nothing moves any more: tick by tick the intervals become those of a world without a budget. */
static void what_is_left_is_done_later(void **state)
{
    (void)state;
    static run r, full;
    world_options options = world_options_default();
    begin(&full, &options, &NEAR);
    tick(&full);
    begin(&r, &options, &NEAR);
    r.grant = 40000;
    world_set_budget(r.w, grant, &r);
    size_t before = SIZE_MAX;
    int ticks = 0;
    do {
        assert_true(world_changed(r.w) && ++ticks < 1000);
        tick(&r);
        what_was_told_holds(&r);
        assert_true(r.undone <= before); /* what takes more than a tick waits for some time */
        before = r.undone;
    } while (r.undone);
    assert_false(world_changed(r.w));
    assert_true(ticks > 2);
    for (int i = 0; i < BODIES; i++)
        for (int k = 0; k < i; k++) {
            const told *a = &r.of[i][k], *b = &full.of[i][k];
            assert_true(a->touches == b->touches && a->near == b->near);
            if (!a->near) continue;
            assert_true(a->lo <= b->hi && b->lo <= a->hi && a->achieved == b->achieved);
            assert_true(a->hi - a->lo <= b->hi - b->lo + 2e-6); /* a pair that was told is asked in other words */
        }
    end(&r);
    end(&full);
}

static uint64_t plenty(void *context, uint64_t done)
{
    (void)context;
    (void)done;
    return 2000000000;
}

/* A box moves away while there is no budget, and then back to where it was when there was one: it has moved. */
static void a_way_without_a_budget_is_no_way_back(void **state)
{
    (void)state;
    static const double AT[] = {1.18, 1.18, 1.05};
    world *w = scene_world(1, true);
    world_subscription near = scene_all(WORLD_DISTANCE, 0.1);
    scene_subscription(w, &near);
    world_shape cube = {.shape = {.type = SHAPE_BOX, .half = {0.5, 0.5, 0.5}}, .local = POSE_IDENTITY};
    uint32_t id[2] = {WORLD_NONE, WORLD_NONE};
    for (int i = 0; i < 2; i++) {
        world_body def = {.name = i ? "b" : "a",
            .group = "",
            .category = 1,
            .mask = 1,
            .pose = {{i * 1.05, 0, 0}, {1, 0, 0, 0}},
            .shapes = &cube,
            .shape_count = 1};
        assert_int_equal(world_put_body(w, &id[i], &def), WORLD_OK);
    }
    world_set_budget(w, plenty, NULL);
    assert_int_equal(scene_tick(w, 1)->events[0].kind, EVENT_NEAR);
    for (int tick = 0; tick < 3; tick++) {
        if (tick < 2) world_set_budget(w, tick ? plenty : NULL, NULL);
        if (tick != 1) scene_move(w, id[1], AT[tick], 0);
        if (tick == 1) world_move_body(w, id[0], (pose){{0, 0.1, 0}, {1, 0, 0, 0}}, 0, NULL, NULL);
        const world_batch *b = scene_tick(w, 2 + tick);
        if (tick == 0) assert_int_equal(b->events[0].kind, EVENT_FAR);
        if (tick == 2) assert_true(b && b->events[0].kind == EVENT_NEAR);
    }
    world_destroy(w);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(what_was_told_holds_at_any_accuracy),
        cmocka_unit_test(an_interval_is_as_narrow_as_asked_and_says_what_it_is),
        cmocka_unit_test(a_verdict_is_certain_where_an_interval_is_not),
        cmocka_unit_test(the_events_do_not_depend_on_workers_or_caches),
        cmocka_unit_test(subscriptions_come_and_change_and_go_in_the_next_tick),
        cmocka_unit_test(who_asks_pays_and_shared_pairs_are_split),
        cmocka_unit_test(with_no_subscription_nothing_is_looked_at),
        cmocka_unit_test(with_a_budget_nothing_is_missed_and_what_was_told_holds),
        cmocka_unit_test(a_replay_with_the_recorded_units_is_the_same),
        cmocka_unit_test(a_restored_world_goes_on_alike),
        cmocka_unit_test(what_is_left_is_done_later),
        cmocka_unit_test(a_way_without_a_budget_is_no_way_back),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
