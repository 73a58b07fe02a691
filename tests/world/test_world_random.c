/* A world under random commands: each id begins once and ends once; contacts equal those of all pairs asked one by one;
 * whatever the sampled ways show to meet has its impact; the same events for any number of workers, with caches and
 * without. */
#include "base/prng.h"
#include "scene.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

enum { BODIES = 40, SUBSCRIPTIONS = 7, IDS_MAX = 1 << 22, OPERATIONS_A_TICK = 5, SAMPLES = 64 };
enum { IMPACTS = 4, BOUNDS = 6 }; /* the subscriptions in them */
static const int64_t TICK_NS = SECOND / 100;
static const double PADDING = 0.2, MARGIN = 0.3; /* m, of one of the rules */

typedef struct mirror { /* what a subscriber knows from events alone */
    uint8_t begun[IDS_MAX], ended[IDS_MAX], unknown[IDS_MAX];
    bool met[BODIES][BODIES]; /* in this tick, on their way */
    size_t open, impacts, predicted, averted, teleported, came_to_be_unknown, came_to_be_known;
    uint64_t story; /* hash of who began and ended what, in order, without the numbers */
} mirror;

typedef struct run {
    world *w;
    uint64_t random;
    uint32_t ids[BODIES];
    bool alive[BODIES];
    pose at[BODIES], before[BODIES]; /* now, and at the last tick */
    int64_t stamps[BODIES], now_ns;
    bool moved[BODIES], teleported[BODIES]; /* since the last tick */
    bool bent[BODIES];                      /* its way since then is none that is sampled */
    bool held[BODIES];
    world_ccd ccd[BODIES];
    shape shapes[BODIES];
    uint32_t subscriptions[SUBSCRIPTIONS];
    bool wanted[SUBSCRIPTIONS];
    bool exact; /* the subscription in bounds is left out: what they tell depends on when they were looked at */
    mirror *mirror;
} run;

static const world_subscription TERMS[SUBSCRIPTIONS] = {
    {.facts = WORLD_TOUCH, .select_a = "*", .select_b = "*", .tolerance = 1e-6},
    {.facts = WORLD_TOUCH | WORLD_MANIFOLD,
        .select_a = "b1*",
        .select_b = "*",
        .threshold = 0.05,
        .hysteresis = 0.02,
        .tolerance = 1e-6},
    {.facts = WORLD_DISTANCE, .select_a = "group:even", .select_b = "group:odd", .range = 0.5, .tolerance = 1e-4},
    {.facts = WORLD_TOUCH | WORLD_DISTANCE,
        .select_a = "*",
        .select_b = "b3*",
        .range = 0.3,
        .hysteresis = 0.01,
        .tolerance = 1e-9,
        .period_ns = SECOND / 20},
    {.facts = WORLD_IMPACT, .select_a = "*", .select_b = "*", .tolerance = 1e-6},
    {.facts = WORLD_PREDICT | WORLD_TOUCH,
        .select_a = "b2*",
        .select_b = "*",
        .tolerance = 1e-4,
        .horizon = 0.5,
        .period_ns = SECOND / 33},
    {.facts = WORLD_TOUCH | WORLD_DISTANCE,
        .select_a = "b2*",
        .select_b = "b*",
        .range = 0.2,
        .accuracy = WORLD_BY_BOXES},
};

static shape random_shape(uint64_t *r)
{
    static const shape_type TYPES[] = {SHAPE_SPHERE, SHAPE_CAPSULE, SHAPE_BOX, SHAPE_CYLINDER};
    shape s = {.type = TYPES[prng_bits(r) % 4], .radius = 0};
    if (s.type == SHAPE_SPHERE || s.type == SHAPE_CAPSULE) s.radius = prng_in(r, 0.1, 0.5);
    if (s.type == SHAPE_CAPSULE) s.half.z = prng_in(r, 0.1, 0.5);
    if (s.type == SHAPE_BOX) s.half = vec(prng_in(r, 0.1, 0.5), prng_in(r, 0.1, 0.5), prng_in(r, 0.1, 0.5));
    if (s.type == SHAPE_CYLINDER) {
        s.half.x = s.half.y = prng_in(r, 0.1, 0.5);
        s.half.z = prng_in(r, 0.1, 0.5);
    }
    return s;
}

static void put(run *r, int i)
{
    char name[16];
    snprintf(name, sizeof name, "b%d", i);
    world_shape one = {.shape = r->shapes[i], .local = POSE_IDENTITY};
    filter_rule glued = {.pattern = "b7", .allow = true},
                padded = {.pattern = "b1*", .padding = PADDING, .margin = MARGIN};
    world_body def = {.name = name,
        .group = i % 2 ? "odd" : "even",
        .category = 1,
        .mask = UINT64_MAX,
        .fixed = i % 10 == 0,
        .ccd = r->ccd[i],
        .acceleration = i % 9 == 0 ? 0.1 : 0,
        .stamp_ns = r->stamps[i],
        .pose = r->alive[i] ? world_body_pose(r->w, r->ids[i]) : r->at[i],
        .shapes = &one,
        .shape_count = 1,
        .one_way = i % 13 == 0,
        .rules = i % 7 ? &padded : &glued,
        .rule_count = i % 7 == 0 || i % 5 == 0};
    if (!r->alive[i]) {
        r->ids[i] = WORLD_NONE;
        r->before[i] = r->at[i];
        r->moved[i] = r->teleported[i] = false;
    }
    assert_int_equal(world_put_body(r->w, &r->ids[i], &def), WORLD_OK);
    r->alive[i] = true;
    r->held[i] = false;
}

/* Nearly: which way round it went, a given velocity says. */
static bool is_half_a_turn(quat a, quat b)
{
    return fabs(a.w * b.w + a.x * b.x + a.y * b.y + a.z * b.z) < 0.3;
}

static void move(run *r, int i, bool teleports)
{
    uint64_t velocity = prng_bits(&r->random) % 4;
    vec3 linear = vec(prng_in(&r->random, -1, 1), prng_in(&r->random, -1, 1), prng_in(&r->random, -1, 1));
    vec3 angular = vec_scale(linear, 0.5);
    const vec3 *v = velocity ? NULL : &linear, *spin = velocity ? NULL : &angular;
    r->stamps[i] = r->now_ns;
    if (teleports)
        world_teleport_body(r->w, r->ids[i], r->at[i], r->now_ns, v, spin);
    else
        world_move_body(r->w, r->ids[i], r->at[i], r->now_ns, v, spin);
    if (teleports) r->before[i] = r->at[i];
    r->teleported[i] |= teleports;
    r->bent[i] |= r->moved[i] || (v && is_half_a_turn(r->before[i].q, r->at[i].q));
    r->moved[i] = !teleports;
    r->held[i] = false;
}

static void random_pose(run *r, int i, double step)
{
    vec3 by = vec(prng_in(&r->random, -step, step), prng_in(&r->random, -step, step), prng_in(&r->random, -step, step));
    r->at[i].p = vec_max(vec_min(vec_add(r->at[i].p, by), vec(1.5, 1.5, 1.5)), vec(-1.5, -1.5, -1.5));
    quat q = r->at[i].q;
    q.x += prng_in(&r->random, -step, step);
    q.y += prng_in(&r->random, -step, step);
    r->at[i].q = quat_unit(q);
}

static void random_command(run *r)
{
    int i = (int)(prng_bits(&r->random) % BODIES);
    bool teleports = false;
    switch (prng_bits(&r->random) % 64) {
    case 0:
        if (r->alive[i]) world_remove_body(r->w, r->ids[i], CAUSE_REMOVED);
        r->alive[i] = false;
        return;
    case 1:
        r->shapes[i] = random_shape(&r->random);
        r->ccd[i] = (world_ccd)(prng_bits(&r->random) % 3);
        put(r, i);
        return;
    case 2: {
        int k = i % SUBSCRIPTIONS;
        if (k == BOUNDS && r->exact) return;
        if (r->wanted[k])
            world_remove_subscription(r->w, r->subscriptions[k], CAUSE_SUBSCRIPTION);
        else
            r->subscriptions[k] = scene_subscription(r->w, &TERMS[k]);
        r->wanted[k] = !r->wanted[k];
        return;
    }
    case 3:
        random_pose(r, i, 3);
        teleports = true;
        break;
    case 4:
    case 5:
        random_pose(r, i, 3); /* through whatever is there */
        break;
    case 6:
        if (r->alive[i]) world_hold_body(r->w, r->ids[i]);
        r->held[i] = r->alive[i];
        return;
    default:
        random_pose(r, i, 0.02);
        break;
    }
    if (r->alive[i])
        move(r, i, teleports);
    else
        put(r, i);
}

static uint64_t tell(uint64_t story, const char *text)
{
    for (; *text; text++) story = (story ^ (unsigned char)*text) * UINT64_C(1099511628211);
    return story;
}

static int number_of(const char *name)
{
    return atoi(name + 1);
}

/* Unknown and known again in turns, and nothing is told of it between but its end. */
static void learn_knowledge(mirror *m, const world_event *e, bool ends)
{
    bool told = e->cause != CAUSE_SNAPSHOT;
    if (e->kind == EVENT_UNKNOWN) {
        assert_true(m->begun[e->contact] && m->unknown[e->contact] != told);
        m->unknown[e->contact] = 1;
        m->came_to_be_unknown += told;
    } else if (e->kind == EVENT_KNOWN) {
        assert_true(m->unknown[e->contact]);
        m->unknown[e->contact] = 0;
        m->came_to_be_known++;
    } else if (told && !ends) {
        assert_false(m->unknown[e->contact]);
    }
}

/* What ends for a body that is elsewhere ends for that cause, and nothing else does. */
static void learn_teleport(run *r, const world_event *e)
{
    bool teleported = r->teleported[number_of(e->name_a)] || r->teleported[number_of(e->name_b)];
    if (e->cause == CAUSE_TELEPORT) assert_true(teleported);
    if (e->cause == CAUSE_MOTION || e->cause == CAUSE_STALE) assert_false(teleported);
    r->mirror->teleported += e->cause == CAUSE_TELEPORT;
}

static void learn(run *r, const world_batch *b)
{
    mirror *m = r->mirror;
    for (size_t i = 0; i < b->count; i++) {
        const world_event *e = &b->events[i];
        if (!e->contact) { /* a whole body */
            assert_true(e->kind == EVENT_UNKNOWN || e->kind == EVENT_KNOWN);
            continue;
        }
        assert_in_range(e->contact, 1, IDS_MAX - 1);
        bool first = !m->begun[e->contact];
        bool impact = e->kind == EVENT_IMPACT;
        bool ends = e->kind == EVENT_END || e->kind == EVENT_FAR || e->kind == EVENT_AVERTED;
        assert_false(m->ended[e->contact]); /* nothing comes after the end */
        if ((e->kind == EVENT_BEGIN && e->cause != CAUSE_SNAPSHOT) || impact) assert_true(first);
        if (e->kind == EVENT_UPDATE || ends) assert_false(first);
        learn_knowledge(m, e, ends);
        if (ends) learn_teleport(r, e);
        m->open += first;
        m->begun[e->contact] = 1;
        m->ended[e->contact] = ends || impact;
        m->open -= ends || impact;
        m->predicted += first && e->kind == EVENT_PREDICTED;
        m->averted += e->kind == EVENT_AVERTED;
        m->impacts += impact;
        if (impact) m->met[number_of(e->name_a)][number_of(e->name_b)] = true;
        if (e->kind == EVENT_BEGIN || e->kind == EVENT_END || e->kind == EVENT_FAR)
            m->story = tell(tell(tell(m->story, e->name_a), e->name_b), ends ? "-" : "+");
        assert_true(e->lo <= e->hi);
    }
}

/* Has body i the rule `padded` against k? */
static bool pads(int i, int k)
{
    char name[16];
    snprintf(name, sizeof name, "%d", k);
    return i % 7 && i % 5 == 0 && name[0] == '1';
}

/* Is the pair in contact for the subscription, asked alone? -1: too close to the threshold to tell. */
static int touches(const run *r, int i, int k, const world_subscription *t)
{
    bool distance = t->facts & WORLD_DISTANCE;
    double limit = distance ? t->range : t->threshold;
    if (pads(i, k) || pads(k, i)) limit += distance ? MARGIN : PADDING;
    void *scratch = aligned_alloc(64, (narrow_scratch_size() + 63) / 64 * 64);
    narrow_request ask = {.facts = NARROW_DISTANCE, .tolerance = 1e-9, .range = INFINITY};
    narrow_result n;
    narrow_query_world(&r->shapes[i], r->at[i], &r->shapes[k], r->at[k], &ask, scratch, &n);
    free(scratch);
    if (r->held[i] || r->held[k]) return -1; /* as it was told last */
    if (fabs(n.lo - limit) < t->tolerance + 1e-6) return -1;
    return n.lo <= limit;
}

static bool is_checked(const run *r, int i, int k)
{
    bool glued = (i % 7 == 0 && k == 7) || (k % 7 == 0 && i == 7);
    return r->alive[i] && r->alive[k] && !glued && !(i % 10 == 0 && k % 10 == 0);
}

static void open_contacts_equal_those_of_all_pairs(run *r)
{
    static world_batches all;
    for (int t = 0; t < 2; t++) {
        static const int WHICH[2] = {0, 2};
        int id = WHICH[t];
        if (!r->wanted[id]) continue;
        world_want_snapshot(r->w, r->subscriptions[id]);
        world_tick(r->w, r->now_ns, &all);
        size_t told = 0, least = 0, most = 0;
        for (size_t b = 0; b < all.count; b++)
            if (all.at[b].subscription == r->subscriptions[id])
                for (size_t e = 0; e < all.at[b].count; e++) {
                    const world_event *v = &all.at[b].events[e];
                    told += v->cause == CAUSE_SNAPSHOT && v->kind != EVENT_UNKNOWN; /* that comes on top */
                }
        for (int i = 0; i < BODIES; i++) {
            for (int k = 0; k < i; k++) {
                if (!is_checked(r, i, k)) continue;
                if (id == 2 && i % 2 == k % 2) continue;
                int answer = touches(r, i, k, &TERMS[id]);
                least += answer == 1;
                most += answer != 0;
            }
        }
        assert_in_range(told, least, most);
    }
}

/* ---- impacts, against ways that are sampled densely ---- */

static pose on_the_way(const run *r, int i, double share)
{
    if (!r->moved[i]) return r->at[i];
    motion way = motion_between(r->before[i], r->at[i], 1);
    if (r->ccd[i] == WORLD_CCD_LINEAR) return (pose){vec_madd(way.start.p, share, way.linear), r->at[i].q};
    return motion_pose(&way, share);
}

static narrow_result between(const run *r, int i, pose at_i, int k, pose at_k, void *scratch)
{
    narrow_request ask = {.facts = NARROW_DISTANCE, .tolerance = 1e-9, .range = INFINITY};
    narrow_result n = {
        .lo = vec_norm(vec_sub(at_i.p, at_k.p)) - shape_reach(&r->shapes[i]) - shape_reach(&r->shapes[k]),
        .hi = INFINITY};
    if (n.lo < PADDING + 0.01) narrow_query_world(&r->shapes[i], at_i, &r->shapes[k], at_k, &ask, scratch, &n);
    return n;
}

static bool meets(const run *r, int i, int k, void *scratch)
{
    double tolerance = TERMS[IMPACTS].tolerance, limit = pads(i, k) || pads(k, i) ? PADDING : 0;
    if (between(r, i, r->before[i], k, r->before[k], scratch).lo <= limit + tolerance) return false; /* told before */
    for (int s = 0; s <= SAMPLES; s++) {
        double share = (double)s / SAMPLES;
        if (between(r, i, on_the_way(r, i, share), k, on_the_way(r, k, share), scratch).hi < limit - tolerance)
            return true;
    }
    return false;
}

/* How many met: all of them were told. */
static size_t what_meets_on_its_way_is_told(const run *r)
{
    void *scratch = aligned_alloc(64, (narrow_scratch_size() + 63) / 64 * 64);
    size_t met = 0;
    for (int i = 0; i < BODIES; i++) {
        for (int k = 0; k < i; k++) {
            if (r->bent[i] || r->bent[k]) continue;
            if (!is_checked(r, i, k) || !(r->moved[i] || r->moved[k]) || !(r->ccd[i] || r->ccd[k])) continue;
            if ((r->held[i] && !r->moved[i]) || (r->held[k] && !r->moved[k])) continue;
            if (!meets(r, i, k, scratch)) continue;
            met++;
            if (!r->mirror->met[i][k] && !r->mirror->met[k][i])
                fail_msg("b%d and b%d met at %lld", i, k, (long long)r->now_ns);
        }
    }
    free(scratch);
    return met;
}

static void arrive(run *r)
{
    for (int i = 0; i < BODIES; i++) {
        r->before[i] = r->at[i];
        r->moved[i] = r->teleported[i] = r->bent[i] = false;
    }
}

typedef struct played {
    uint64_t hash, story;
} played;

static uint64_t grant_units(void *context, uint64_t done)
{
    (void)done;
    return *(uint64_t *)context;
}

static played play_run(run r, int ticks, bool check, uint64_t units)
{
    r.random = 12345;
    r.mirror = calloc(1, sizeof(mirror));
    if (units) world_set_budget(r.w, grant_units, &units);
    world_batches b = {0};
    size_t met = 0;
    for (int i = 0; i < BODIES; i++) {
        r.at[i] = POSE_IDENTITY;
        r.ccd[i] = (world_ccd)(i % 3);
        random_pose(&r, i, 1.5);
        r.shapes[i] = random_shape(&r.random);
        put(&r, i);
    }
    for (int t = 1; t <= ticks; t++) {
        r.now_ns = t * TICK_NS;
        for (int c = 0; c < OPERATIONS_A_TICK; c++) random_command(&r);
        memset(r.mirror->met, 0, sizeof r.mirror->met);
        world_tick(r.w, r.now_ns, &b);
        for (size_t i = 0; i < b.count; i++) learn(&r, &b.at[i]);
        if (check && r.wanted[IMPACTS] && t % 30 == 0) met += what_meets_on_its_way_is_told(&r);
        arrive(&r);
        if (check && t % 200 == 0) {
            assert_null(world_validate(r.w));
            open_contacts_equal_those_of_all_pairs(&r);
        }
    }
    for (int k = 0; k < SUBSCRIPTIONS; k++)
        if (r.wanted[k]) world_remove_subscription(r.w, r.subscriptions[k], CAUSE_SHUTDOWN);
    r.now_ns = (ticks + 1) * TICK_NS;
    world_tick(r.w, r.now_ns, &b);
    for (size_t i = 0; i < b.count; i++) learn(&r, &b.at[i]);
    assert_int_equal(r.mirror->open, 0); /* each begin had its end */
    assert_int_equal(world_get_figures(r.w).contacts, 0);
    assert_true(world_get_figures(r.w).events > (uint64_t)ticks / 4);
    if (check) {
        const mirror *m = r.mirror;
        size_t enough = (size_t)ticks / 200;
        assert_true(2 * met > enough && m->impacts > 4 * enough && m->teleported > enough);
        assert_true(m->predicted > enough && m->averted == m->predicted);
        assert_true(m->came_to_be_known > enough && m->came_to_be_unknown > m->came_to_be_known);
    }
    played p = {b.hash, r.mirror->story};
    world_destroy(r.w);
    free(r.mirror);
    return p;
}

/* units: a budget; 0: none. */
static played play_within(const world_options *options, int ticks, bool check, uint64_t units)
{
    return play_run((run){.w = world_create(options)}, ticks, check, units);
}

static played play_with(const world_options *options, int ticks, bool check)
{
    return play_within(options, ticks, check, 0);
}

static uint64_t play(unsigned workers, bool caches, int ticks, bool check)
{
    world_options options = world_options_default();
    options.workers = workers;
    options.caches = caches;
    return play_with(&options, ticks, check).hash;
}

/* 10^5 operations; with COLLIDED_NIGHTLY=1 in the environment 10^6, with COLLIDED_BRIEF=1 2 x 10^4. */
static void each_id_begins_once_and_ends_once(void **state)
{
    (void)state;
    int operations = getenv("COLLIDED_NIGHTLY") ? 1000000 : getenv("COLLIDED_BRIEF") ? 20000 : 100000;
    play(1, true, operations / OPERATIONS_A_TICK, true);
}

static int rounds(int ticks)
{
    return getenv("COLLIDED_BRIEF") ? ticks / 4 : ticks;
}

static void the_events_do_not_depend_on_the_number_of_workers(void **state)
{
    (void)state;
    uint64_t one = play(1, true, rounds(1000), false);
    for (unsigned workers = 2; workers <= 8; workers++) assert_true(play(workers, true, rounds(1000), false) == one);
}

/* Each id begins once and ends once, too: play_within says so. */
static void a_budget_tells_the_same_for_any_number_of_workers_with_caches_or_without(void **state)
{
    (void)state;
    world_options options = world_options_default();
    for (uint64_t units = 1000; units <= 16000; units *= 4) {
        options.workers = 1;
        options.caches = true;
        uint64_t one = play_within(&options, rounds(1000), false, units).hash;
        for (options.workers = 2; options.workers <= 8; options.workers += 3) {
            options.caches = !options.caches;
            assert_true(play_within(&options, rounds(1000), false, units).hash == one);
        }
    }
}

static void the_events_do_not_depend_on_the_caches(void **state)
{
    (void)state;
    assert_true(play(1, true, rounds(2000), false) == play(1, false, rounds(2000), false));
}

/* With few bodies auto is a sweep; it changes in test_world_broad.c. */
static void the_events_do_not_depend_on_the_broad_phase(void **state)
{
    (void)state;
    world_options options = world_options_default();
    options.broad = BROAD_TREE;
    uint64_t tree = play_with(&options, rounds(2000), false).hash;
    static const broad_kind OTHERS[] = {BROAD_AUTO, BROAD_SWEEP3, BROAD_SWEEP1};
    for (size_t i = 0; i < sizeof OTHERS / sizeof *OTHERS; i++) {
        options.broad = OTHERS[i];
        assert_true(play_with(&options, rounds(2000), false).hash == tree);
    }
}

/* Wider boxes begin pairs earlier and end them later; what is told, and in which order, is the same. */
static void the_events_do_not_depend_on_the_margin(void **state)
{
    (void)state;
    static const double MARGINS[] = {0.1, 0.02, 0.5, 3};
    static const broad_kind KINDS[] = {BROAD_TREE, BROAD_SWEEP1, BROAD_SWEEP3, BROAD_AUTO};
    world_options options = world_options_default();
    options.margin = 0;
    uint64_t none = play_run((run){.w = world_create(&options), .exact = true}, rounds(2000), false, 0).hash;
    for (size_t i = 0; i < sizeof MARGINS / sizeof *MARGINS; i++) {
        options.margin = MARGINS[i];
        options.broad = KINDS[i];
        options.workers = (unsigned)(2 * i + 1);
        uint64_t other = play_run((run){.w = world_create(&options), .exact = true}, rounds(2000), false, 0).hash;
        if (other != none) fail_msg("margin %g tells something else than margin 0", MARGINS[i]);
    }
}

/* The engines may give other intervals within the tolerance; who touches whom, and when, is the same. */
static void every_engine_tells_the_same_story(void **state)
{
    (void)state;
    world_options options = world_options_default();
    uint64_t story = play_with(&options, 500, false).story;
    static const narrow_engine OTHERS[] = {NARROW_ENGINE_GJK, NARROW_ENGINE_CCD, NARROW_ENGINE_MPR};
    for (size_t i = 0; i < sizeof OTHERS / sizeof *OTHERS; i++) {
        options.engine = OTHERS[i];
        assert_true(play_with(&options, 500, false).story == story);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(each_id_begins_once_and_ends_once),
        cmocka_unit_test(the_events_do_not_depend_on_the_number_of_workers),
        cmocka_unit_test(a_budget_tells_the_same_for_any_number_of_workers_with_caches_or_without),
        cmocka_unit_test(the_events_do_not_depend_on_the_caches),
        cmocka_unit_test(the_events_do_not_depend_on_the_broad_phase),
        cmocka_unit_test(the_events_do_not_depend_on_the_margin),
        cmocka_unit_test(every_engine_tells_the_same_story),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
