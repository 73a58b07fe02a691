/* What is predicted in a world that slices cut: each search that a tick has no time for is made later, and tells what a
 * world tells that is not cut; until then it is pending, and no free is told. For any number of workers, and in a world
 * that was saved on the way. */
#include "geom/compound.h"
#include "geom/hull.h"
#include "scene.h"
#include "world/saved.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

enum { BODIES = 14, SUBSCRIPTIONS = 3, TOLD_MOST = 200000 };

static double draw(uint64_t *seed)
{
    *seed = *seed * 6364136223846793005u + 1442695040888963407u;
    return (double)(*seed >> 11) * 0x1p-53;
}

static vec3 somewhere(uint64_t *seed, double size)
{
    double x = draw(seed) - 0.5, y = draw(seed) - 0.5, z = draw(seed) - 0.5;
    return vec(size * x, size * y, 0.3 * size * z);
}

/* ---- what is told ---- */

typedef struct telling {
    char a[8], b[8];
    uint32_t subscription;
    int32_t shape_a, shape_b;
    uint8_t kind;
    double lo, hi;
    int64_t start_ns;
} telling;

typedef struct run {
    world *w;
    uint32_t ids[BODIES], subscriptions[SUBSCRIPTIONS];
    telling *told;
    size_t count;
    uint64_t hash;
    size_t put_off; /* ticks that left some searches */
} run;

static void hear(run *r, const world_batches *batches)
{
    for (size_t i = 0; i < batches->count; i++) {
        for (size_t k = 0; !batches->at[i].snapshot && k < batches->at[i].count; k++) {
            const world_event *e = &batches->at[i].events[k];
            if (e->kind != EVENT_PREDICTED && e->kind != EVENT_AVERTED && e->kind != EVENT_IMPACT) continue;
            assert_true(r->count < TOLD_MOST);
            telling *t = &r->told[r->count++];
            bool turned = strcmp(e->name_a, e->name_b) > 0;
            bool meets = e->kind == EVENT_IMPACT || e->kind == EVENT_PREDICTED; /* others have no times */
            *t = (telling){.subscription = batches->at[i].subscription,
                .kind = e->kind,
                .shape_a = turned ? e->shape_b : e->shape_a,
                .shape_b = turned ? e->shape_a : e->shape_b,
                .lo = meets ? e->impact.lo : 0,
                .hi = meets ? e->impact.hi : 0,
                .start_ns = meets ? e->impact.start_ns : 0};
            snprintf(t->a, sizeof t->a, "%s", turned ? e->name_b : e->name_a);
            snprintf(t->b, sizeof t->b, "%s", turned ? e->name_a : e->name_b);
        }
    }
    r->hash = batches->hash;
}

static int compare_reported(const void *x, const void *y)
{
    const telling *a = x, *b = y;
    int names = strcmp(a->a, b->a) ? strcmp(a->a, b->a) : strcmp(a->b, b->b);
    if (names) return names;
    if (a->kind != b->kind) return a->kind - b->kind;
    if (a->subscription != b->subscription) return a->subscription < b->subscription ? -1 : 1;
    if (a->shape_a != b->shape_a) return a->shape_a - b->shape_a;
    if (a->shape_b != b->shape_b) return a->shape_b - b->shape_b;
    if (a->start_ns != b->start_ns) return a->start_ns < b->start_ns ? -1 : 1;
    return (a->lo > b->lo) - (a->lo < b->lo);
}

/* In whatever order: nothing is missing, and nothing was added. */
static void expect_same(run *whole, run *cut)
{
    qsort(whole->told, whole->count, sizeof *whole->told, compare_reported);
    qsort(cut->told, cut->count, sizeof *cut->told, compare_reported);
    for (size_t i = 0; i < whole->count && i < cut->count; i++) {
        const telling *a = &whole->told[i], *b = &cut->told[i];
        if (compare_reported(a, b) || a->hi != b->hi)
            fail_msg("event %zu: %s and %s, kind %d at %.17g; cut: %s and %s, kind %d at %.17g", i, a->a, a->b, a->kind,
                a->lo, b->a, b->b, b->kind, b->lo);
    }
    assert_int_equal(whole->count, cut->count);
    whole->count = cut->count = 0;
}

/* ---- the scene ---- */

static hull *some_hull(uint64_t seed)
{
    double corners[3 * 40];
    hull *h;
    for (int i = 0; i < 3 * 40; i++) corners[i] = draw(&seed) - 0.5;
    assert_int_equal(hull_build(corners, 40, 0, &h), HULL_OK);
    return h;
}

/* Compounds of a few cylinders and balls; hulls; cylinders; two shapes. */
static void put(run *r, int i, const hull *h, vec3 at)
{
    char name[8];
    shape cylinder = {.type = SHAPE_CYLINDER, .half = {0.1, 0.1, 0.5}}, ball = {.type = SHAPE_SPHERE, .radius = 0.3};
    shape of[4] = {cylinder, ball, cylinder, ball};
    pose local[4];
    compound *c = NULL;
    for (int k = 0; k < 4; k++) local[k] = (pose){vec(0.4 * k - 0.6, 0.1 * k, 0), {1, 0, 0, 0}};
    assert_int_equal(compound_build(of, local, 4, &c), COMPOUND_OK);
    world_shape shapes[2] = {{.shape = cylinder, .local = POSE_IDENTITY}, {.shape = ball, .local = local[3]}};
    if (i % 3 == 0) shapes[0].shape = (shape){.type = SHAPE_COMPOUND, .compound = c};
    if (i % 3 == 1) shapes[0].shape = (shape){.type = SHAPE_HULL, .hull = h};
    snprintf(name, sizeof name, "b%d", i);
    world_body def = {.name = name,
        .group = "",
        .owner = (uint64_t)(i % 4),
        .category = 1,
        .mask = UINT64_MAX,
        .ccd = i % 2 ? WORLD_CCD_FULL : WORLD_CCD_OFF,
        .stamp_ns = SECOND,
        .pose = {at, {1, 0, 0, 0}},
        .shapes = shapes,
        .shape_count = i % 5 == 4 ? 2 : 1};
    assert_int_equal(world_put_body(r->w, &r->ids[i], &def), WORLD_OK);
    compound_destroy(c);
}

static run begin(unsigned workers, bool caches, const hull *h, uint64_t seed)
{
    run r = {.told = calloc(TOLD_MOST, sizeof(telling))};
    world_batches batches;
    r.w = scene_world(workers, caches);
    for (int k = 0; k < SUBSCRIPTIONS; k++) {
        world_subscription meet = {.facts = k == 1 ? WORLD_PREDICT : WORLD_PREDICT | WORLD_IMPACT,
            .select_a = "*",
            .select_b = k == 2 ? "b1*" : "*",
            .threshold = 0.01 * k,
            .tolerance = 1e-6,
            .horizon = 2 + k};
        r.subscriptions[k] = scene_subscription(r.w, &meet);
    }
    for (int i = 0; i < BODIES; i++) {
        r.ids[i] = WORLD_NONE;
        put(&r, i, h, somewhere(&seed, 9));
    }
    world_tick(r.w, SECOND, &batches);
    hear(&r, &batches);
    return r;
}

/* Some of them go elsewhere, and on at other velocities; by stamps, so that when it is looked at changes nothing. */
static void command(run *r, uint64_t seed, int64_t stamp_ns)
{
    for (int i = 0; i < BODIES; i++) {
        pose at = world_body_pose(r->w, r->ids[i]);
        double what = draw(&seed);
        vec3 by = somewhere(&seed, 2), linear = vec_sub(somewhere(&seed, 8), vec_scale(at.p, 0.5)),
             angular = somewhere(&seed, 6);
        if (what > 0.7) continue;
        at.p = vec_add(at.p, by);
        if (what < 0.1)
            world_teleport_body(r->w, r->ids[i], at, stamp_ns, &linear, &angular);
        else
            assert_int_equal(world_move_body(r->w, r->ids[i], at, stamp_ns, &linear, &angular), WORLD_OK);
    }
}

static void tick(run *r, int64_t now_ns, uint64_t slice)
{
    world_batches batches;
    world_set_slice(r->w, slice);
    world_tick(r->w, now_ns, &batches);
    const char *fault = world_validate(r->w);
    if (fault) fail_msg("%s", fault);
    hear(r, &batches);
}

/* Until nothing is left. While something is, it is said to be. */
static void settle(run *r, int64_t now_ns, uint64_t slice)
{
    for (int n = 0; world_changed(r->w); n++) {
        assert_true(n < 5000);
        tick(r, now_ns, slice);
        world_figures f = world_get_figures(r->w);
        r->put_off += f.pending_pairs > 0;
        assert_true(!world_changed(r->w) || f.pending_pairs + f.pending_bodies > 0);
    }
    assert_int_equal(world_get_figures(r->w).pending_pairs, 0);
}

static void end(run *r)
{
    world_destroy(r->w);
    free(r->told);
}

/* ---- a world that is saved lends its hull ---- */

static int64_t name_of(const void *context, const shape *s)
{
    (void)context;
    return s->hull ? 1 : 0;
}

static bool lend(const void *context, int64_t number, shape *s)
{
    if (number == 1) s->hull = context;
    return number == 1;
}

static void save_and_restore(run *r, const hull *h, unsigned workers)
{
    world_lender lender = {.context = h, .name_of = name_of, .lend = lend};
    world_options o = world_options_default();
    bytes_out out = {0};
    o.workers = workers;
    world_save(r->w, &lender, &out);
    world_destroy(r->w);
    r->w = world_create(&o);
    bytes_in in = {.at = out.at, .left = out.count};
    const char *wrong = world_restore(r->w, &lender, &in);
    if (wrong) fail_msg("%s", wrong);
    array_free(&out);
}

/* ---- the tests ---- */

enum { ROUNDS = 6 };

static void what_is_put_off_is_predicted_later(void **state)
{
    (void)state;
    size_t told = 0, put_off = 0;
    for (uint64_t seed = 1; seed <= 20; seed++) {
        hull *h = some_hull(seed);
        run whole = begin(1, true, h, seed), cut = begin(1 + (unsigned)(seed % 3), true, h, seed);
        expect_same(&whole, &cut);
        for (int64_t round = 2; round < 2 + ROUNDS; round++) {
            command(&whole, seed * 100 + (uint64_t)round, round * SECOND);
            command(&cut, seed * 100 + (uint64_t)round, round * SECOND);
            settle(&whole, round * SECOND, UINT64_MAX);
            settle(&cut, round * SECOND, (uint64_t)1000 << seed % 8);
            told += whole.count;
            expect_same(&whole, &cut);
        }
        put_off += cut.put_off;
        end(&whole);
        end(&cut);
        hull_destroy(h);
    }
    print_message("%zu events, %zu ticks put something off\n", told, put_off);
    assert_true(told > 1000 && put_off > 1000);
}

/* Commands come before all is done: in the end, what stands is what stands in a world that is not cut. */
static void what_stands_in_the_end_is_the_same(void **state)
{
    (void)state;
    size_t stand = 0;
    for (uint64_t seed = 1; seed <= 20; seed++) {
        hull *h = some_hull(seed);
        run whole = begin(1, true, h, seed), cut = begin(1, true, h, seed);
        for (int64_t round = 2; round < 30; round++) {
            command(&whole, seed * 100 + (uint64_t)round, round * SECOND);
            command(&cut, seed * 100 + (uint64_t)round, round * SECOND);
            tick(&whole, round * SECOND, UINT64_MAX);
            tick(&cut, round * SECOND, 3000);
        }
        settle(&whole, 30 * (int64_t)SECOND, UINT64_MAX);
        settle(&cut, 30 * (int64_t)SECOND, 3000);
        world_batches batches;
        run *both[] = {&whole, &cut};
        for (int k = 0; k < 2; k++) {
            both[k]->count = 0;
            for (int i = 0; i < SUBSCRIPTIONS; i++) world_want_snapshot(both[k]->w, both[k]->subscriptions[i]);
            world_set_slice(both[k]->w, UINT64_MAX);
            world_tick(both[k]->w, 30 * (int64_t)SECOND, &batches);
            for (size_t i = 0; i < batches.count; i++) ((world_batch *)&batches.at[i])->snapshot = false;
            hear(both[k], &batches);
        }
        stand += whole.count;
        expect_same(&whole, &cut);
        end(&whole);
        end(&cut);
        hull_destroy(h);
    }
    assert_true(stand > 50);
}

static uint64_t hash_of(uint64_t seed, const hull *h, unsigned workers, bool caches, int save_at)
{
    run r = begin(workers, caches, h, seed);
    for (int t = 2; t < 40; t++) {
        if (t % 3 == 0) command(&r, seed * 100 + (uint64_t)t, t * (int64_t)SECOND);
        tick(&r, t * (int64_t)SECOND, (uint64_t)2000 << t % 6);
        if (t == save_at) save_and_restore(&r, h, workers);
    }
    uint64_t hash = r.hash;
    end(&r);
    return hash;
}

/* And one without caches: what is counted decides what is put off: so it does not depend on them. */
static void workers_and_a_saved_world_predict_the_same(void **state)
{
    (void)state;
    for (uint64_t seed = 1; seed <= 12; seed++) {
        hull *h = some_hull(seed);
        uint64_t one = hash_of(seed, h, 1, true, -1);
        assert_int_equal(one, hash_of(seed, h, 2 + (unsigned)(seed % 7), true, -1));
        assert_int_equal(one, hash_of(seed, h, 2, false, -1));
        for (int at = 3; at < 30; at += 4) assert_int_equal(one, hash_of(seed, h, 1 + (unsigned)(at % 4), true, at));
        hull_destroy(h);
    }
}

/* Bodies of parts that fly and spin, predicted for a day, all moved at once: in no tick more is done than the slice,
 * what the last batch takes beyond it, and one search at its most. Each of their pairs has its turn all the same. */
static void many_dear_searches_keep_to_the_slice(void **state)
{
    (void)state;
    enum { COMPOUNDS = 10 };
    static const uint64_t SLICE = 4000000, ONE_SEARCH = 17 * ((uint64_t)1 << 19) + 1000000;
    shape parts[10];
    pose local[10];
    compound *c;
    world *w = scene_world(1, true);
    uint32_t ids[COMPOUNDS];
    world_subscription meet = {
        .facts = WORLD_PREDICT | WORLD_IMPACT, .select_a = "*", .select_b = "*", .tolerance = 1e-3, .horizon = 86400};
    for (int k = 0; k < 10; k++) {
        parts[k] = (shape){.type = SHAPE_CYLINDER, .half = {0.05, 0.05, 0.3}};
        local[k] = (pose){vec(0.1 * k, 0.05 * (k % 3), 0), {1, 0, 0, 0}};
    }
    assert_int_equal(compound_build(parts, local, 10, &c), COMPOUND_OK);
    scene_subscription(w, &meet);
    world_batches batches;
    for (int i = 0; i < COMPOUNDS; i++) {
        char name[8];
        world_shape whole = {.shape = {.type = SHAPE_COMPOUND, .compound = c}, .local = POSE_IDENTITY};
        snprintf(name, sizeof name, "c%d", i);
        world_body def = {.name = name,
            .group = "",
            .category = 1,
            .mask = UINT64_MAX,
            .ccd = WORLD_CCD_FULL,
            .pose = {vec(2.0 * i, 0, 0), {1, 0, 0, 0}},
            .shapes = &whole,
            .shape_count = 1};
        ids[i] = WORLD_NONE;
        assert_int_equal(world_put_body(w, &ids[i], &def), WORLD_OK);
    }
    world_tick(w, 1, &batches);
    size_t most_pending = 0, told = 0;
    uint64_t most_units = 0;
    int ticks = 0;
    for (int i = 0; i < COMPOUNDS; i++)
        world_move_body(w, ids[i], (pose){vec(2.0 * i, 0, 0), {1, 0, 0, 0}}, SECOND, NULL, NULL);
    while (world_changed(w)) world_tick(w, SECOND, &batches);
    for (int i = 0; i < COMPOUNDS; i++) {
        vec3 linear = vec(i % 2 ? 1e3 : -1e3, 0, 0), angular = vec(3e4, 1e4, 0);
        world_move_body(w, ids[i], (pose){vec(2.0 * i, 0.3, 0), {1, 0, 0, 0}}, SECOND + SECOND / 50, &linear, &angular);
    }
    for (; world_changed(w); ticks++) {
        assert_true(ticks < 2000);
        world_set_slice(w, SLICE);
        world_tick(w, SECOND + SECOND / 50, &batches);
        world_figures f = world_get_figures(w);
        most_pending = f.pending_pairs > most_pending ? f.pending_pairs : most_pending;
        most_units = f.slice_units > most_units ? f.slice_units : most_units;
        told = f.predicted;
    }
    print_message("%d ticks, %zu pairs pending, %llu units at the most, %zu predicted\n", ticks, most_pending,
        (unsigned long long)most_units, told);
    assert_true(most_pending > 10 && ticks > 5);
    assert_true(most_units < SLICE + SLICE / 4 + SLICE / 2 + ONE_SEARCH);
    assert_true(told > 0);
    world_destroy(w);
    compound_destroy(c);
}

/* ---- whom others' searches keep waiting ---- */

enum { STRANGERS = 16, STRANGER = 1, NEIGHBOUR = 2 };

typedef struct flight {
    world *w;
    compound *c;
    uint32_t strangers[STRANGERS], stands, goes;
    int64_t now_ns;
} flight;

static uint32_t put_owned(world *w, const char *name, uint64_t owner, world_shape one, vec3 at)
{
    world_body def = {.name = name,
        .group = "",
        .owner = owner,
        .category = 1,
        .mask = UINT64_MAX,
        .ccd = owner == STRANGER ? WORLD_CCD_FULL : WORLD_CCD_OFF,
        .stamp_ns = SECOND,
        .pose = {at, {1, 0, 0, 0}},
        .shapes = &one,
        .shape_count = 1};
    uint32_t id = WORLD_NONE;
    assert_int_equal(world_put_body(w, &id, &def), WORLD_OK);
    return id;
}

/* Bodies of parts, in one place; far away two cubes of somebody else, who asks for their distance. The stranger asks
 * what everything will meet within a day. */
static flight take_off(void)
{
    flight f = {.w = scene_world(1, true), .now_ns = SECOND};
    world_batches batches;
    shape parts[10];
    pose local[10];
    world_shape cube = {.shape = {.type = SHAPE_BOX, .half = {0.5, 0.5, 0.5}}, .local = POSE_IDENTITY};
    for (int k = 0; k < 10; k++) {
        parts[k] = (shape){.type = SHAPE_CYLINDER, .half = {0.05, 0.05, 0.3}};
        local[k] = (pose){vec(0.1 * k, 0.05 * (k % 3), 0), {1, 0, 0, 0}};
    }
    assert_int_equal(compound_build(parts, local, 10, &f.c), COMPOUND_OK);
    world_subscription meet = {.facts = WORLD_PREDICT | WORLD_IMPACT,
        .select_a = "*",
        .select_b = "*",
        .tolerance = 1e-3,
        .horizon = 86400,
        .owner = STRANGER};
    world_subscription near = {.facts = WORLD_DISTANCE,
        .select_a = "n*",
        .select_b = "n*",
        .range = 10,
        .tolerance = 1e-6,
        .owner = NEIGHBOUR};
    scene_subscription(f.w, &meet);
    scene_subscription(f.w, &near);
    for (int i = 0; i < STRANGERS; i++) {
        char name[8];
        snprintf(name, sizeof name, "s%d", i);
        world_shape whole = {.shape = {.type = SHAPE_COMPOUND, .compound = f.c}, .local = POSE_IDENTITY};
        f.strangers[i] = put_owned(f.w, name, STRANGER, whole, vec(2.0 * i, 0, 0));
    }
    f.stands = put_owned(f.w, "n0", NEIGHBOUR, cube, vec(1e5, 0, 0));
    f.goes = put_owned(f.w, "n1", NEIGHBOUR, cube, vec(1e5 + 2, 0, 0));
    world_tick(f.w, f.now_ns, &batches);
    while (world_changed(f.w)) world_tick(f.w, f.now_ns, &batches);
    return f;
}

/* 20 ms later all strangers are elsewhere. */
static void fly(flight *f)
{
    world_batches batches;
    f->now_ns += SECOND / 50;
    for (int i = 0; i < STRANGERS; i++) {
        vec3 linear = vec(i % 2 ? 1e3 : -1e3, 0, 0), angular = vec(3e4, 1e4, 0);
        pose at = {vec(2.0 * i, 0.3 * (double)(f->now_ns / (SECOND / 50) % 20), 0), {1, 0, 0, 0}};
        world_move_body(f->w, f->strangers[i], at, f->now_ns, &linear, &angular);
    }
    world_set_slice(f->w, 2000000);
    world_tick(f->w, f->now_ns, &batches);
}

/* Whoever steps is answered when nothing of his is pending: in a few ticks, whatever strangers fly and ask for. */
static void what_strangers_ask_keeps_nobody_waiting(void **state)
{
    (void)state;
    enum { TICKS_MOST = 8, STEPS = 20 };
    flight f = take_off();
    size_t searching = 0;
    int longest = 0;
    for (int i = 0; i < 60; i++) fly(&f); /* until what their searches take is known */
    for (int step = 0; step < STEPS && longest <= TICKS_MOST; step++) {
        int ticks = 0;
        world_move_body(f.w, f.goes, (pose){vec(1e5 + 2 + 0.1 * (step % 5), 0, 0), {1, 0, 0, 0}}, f.now_ns, NULL, NULL);
        do {
            fly(&f);
            searching += world_pending_of(f.w, STRANGER) > 0;
        } while (world_pending_of(f.w, NEIGHBOUR) && ++ticks <= TICKS_MOST);
        longest = ticks > longest ? ticks : longest;
    }
    print_message("%d ticks at the most, in %zu something of the stranger was pending\n", longest, searching);
    assert_true(searching > STEPS / 2);
    assert_in_range(longest, 0, TICKS_MOST);
    world_destroy(f.w);
    compound_destroy(f.c);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(what_is_put_off_is_predicted_later),
        cmocka_unit_test(what_stands_in_the_end_is_the_same),
        cmocka_unit_test(workers_and_a_saved_world_predict_the_same),
        cmocka_unit_test(many_dear_searches_keep_to_the_slice),
        cmocka_unit_test(what_strangers_ask_keeps_nobody_waiting),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
