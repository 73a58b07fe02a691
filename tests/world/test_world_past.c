/* Impacts in a world that slices cut: what a world that is not cut tells is told as well, only later, or it is said
 * that a body may have met anything; for any number of workers, and in a world that was saved on the way. */
#include "scene.h"
#include "world/saved.h"

#include <stdio.h>
#include <stdlib.h>

enum { BODIES_MOST = 40, IMPACTS_MOST = 40000 };

static double draw(uint64_t *seed)
{
    *seed = *seed * 6364136223846793005u + 1442695040888963407u;
    return (double)(*seed >> 11) * 0x1p-53;
}

static size_t below(uint64_t *seed, size_t end)
{
    return (size_t)(draw(seed) * (double)end);
}

/* ---- what is told ---- */

typedef struct meeting {
    char a[16], b[16];
    int64_t start_ns;
    double lo;
    int64_t tick; /* in which it was told */
    bool met;     /* by one of the other list */
} meeting;

typedef struct told {
    meeting *at;
    size_t count;
} told;

static void hear(told *t, const world_batches *batches, int64_t tick)
{
    for (size_t i = 0; i < batches->count; i++) {
        for (size_t k = 0; !batches->at[i].snapshot && k < batches->at[i].count; k++) {
            const world_event *e = &batches->at[i].events[k];
            if (e->kind != EVENT_IMPACT) continue;
            assert_true(t->count < IMPACTS_MOST);
            meeting *m = &t->at[t->count++];
            *m = (meeting){.start_ns = e->impact.start_ns, .lo = e->impact.lo, .tick = tick};
            snprintf(m->a, sizeof m->a, "%s", e->name_a);
            snprintf(m->b, sizeof m->b, "%s", e->name_b);
        }
    }
}

static bool is_same(const meeting *x, const meeting *y)
{
    bool names = (!strcmp(x->a, y->a) && !strcmp(x->b, y->b)) || (!strcmp(x->a, y->b) && !strcmp(x->b, y->a));
    return names && x->start_ns == y->start_ns && x->lo == y->lo;
}

/* Was it said of one of the two that ways of it were dropped, this one perhaps among them? */
static bool is_given_up(const told *t, const meeting *m)
{
    for (size_t i = 0; i < t->count; i++) {
        const meeting *g = &t->at[i];
        bool one_of_them = !strcmp(g->a, m->a) || !strcmp(g->a, m->b);
        if (!strcmp(g->b, "*") && one_of_them && g->tick >= m->tick) return true;
    }
    return false;
}

typedef struct compared {
    size_t late, given_up, all;
} compared;

static compared compare(told *whole, told *cut)
{
    compared c = {.all = whole->count};
    for (size_t i = 0; i < whole->count; i++) {
        meeting *m = &whole->at[i];
        for (size_t k = 0; k < cut->count && !m->met; k++) {
            if (cut->at[k].met || !is_same(m, &cut->at[k])) continue;
            m->met = cut->at[k].met = true;
            c.late += cut->at[k].tick > m->tick;
        }
        c.given_up += !m->met;
        if (!m->met && !is_given_up(cut, m))
            fail_msg("%s met %s in tick %lld: nobody was told", m->a, m->b, (long long)m->tick);
    }
    for (size_t k = 0; k < cut->count; k++)
        if (!cut->at[k].met && strcmp(cut->at[k].b, "*") != 0)
            fail_msg("%s is told to meet %s, twice or never", cut->at[k].a, cut->at[k].b);
    return c;
}

/* ---- two worlds under the same commands ---- */

typedef struct plan {
    uint64_t seed;
    int bodies, ticks;
    double room, step;  /* m */
    bool stamps, jumps; /* with stamps and several poses a tick; teleports, and bodies that are put again */
    uint64_t slice;     /* units, at most */
    unsigned workers;
    int save_at;            /* the tick after which the world is saved, and goes on as what was restored; -1: never */
    bool reshapes, starves; /* bodies get other shapes; no tick but the last ones takes all */
} plan;

typedef struct run {
    world *w;
    uint32_t ids[BODIES_MOST];
    told told;
    uint64_t hash;
    uint64_t dropped;
} run;

static vec3 somewhere(uint64_t *seed, double room)
{
    double x = draw(seed), y = draw(seed), z = draw(seed);
    return vec(room * x, room * y, 0.2 * room * z);
}

static void put(run *r, int i, vec3 at, double size, bool ccd)
{
    char name[16];
    world_shape shapes[2] = {{.shape = {.type = SHAPE_BOX, .half = {size, 0.5 * size, size}}, .local = POSE_IDENTITY},
        {.shape = {.type = SHAPE_SPHERE, .radius = 0.5 * size}, .local = {{2 * size, 0, 0}, {1, 0, 0, 0}}}};
    snprintf(name, sizeof name, "b%d", i);
    world_body def = {.name = name,
        .group = "",
        .owner = (uint64_t)(i % 7 == 0),
        .category = 1,
        .mask = UINT64_MAX,
        .ccd = ccd ? WORLD_CCD_FULL : WORLD_CCD_OFF,
        .pose = {at, {1, 0, 0, 0}},
        .shapes = shapes,
        .shape_count = i % 3 ? 1 : 2};
    assert_int_equal(world_put_body(r->w, &r->ids[i], &def), WORLD_OK);
}

static void move(const plan *p, run *r, int i, uint64_t *seed, int64_t tick_ns)
{
    pose at = world_body_pose(r->w, r->ids[i]);
    size_t legs = p->stamps ? 1 + below(seed, 3) : 1;
    for (size_t k = 1; k <= legs; k++) {
        vec3 by = vec_scale(vec_sub(somewhere(seed, 2), vec(1, 1, 0.2)), p->step);
        at.p = vec_add(at.p, by);
        at.q = quat_unit((quat){at.q.w, at.q.x + draw(seed) - 0.5, at.q.y, at.q.z + draw(seed) - 0.5});
        int64_t stamp_ns = p->stamps ? tick_ns - SECOND / 4 + (int64_t)k * SECOND / 16 : 0;
        assert_int_equal(world_move_body(r->w, r->ids[i], at, stamp_ns, NULL, NULL), WORLD_OK);
    }
}

/* The same, whichever world it is. */
static void command(const plan *p, run *r, uint64_t *seed, int tick)
{
    for (int i = 0; i < p->bodies; i++) {
        double what = draw(seed);
        uint64_t own = *seed ^ (uint64_t)i * 0x9e3779b97f4a7c15u;
        if (what < 0.6) move(p, r, i, &own, (int64_t)(tick + 1) * SECOND);
        if (p->jumps && what > 0.95) {
            pose to = {somewhere(&own, p->room), {1, 0, 0, 0}};
            world_teleport_body(r->w, r->ids[i], to, 0, NULL, NULL);
        } else if (p->jumps && what > 0.92) {
            put(r, i, somewhere(&own, p->room), 1, i % 2);
        } else if (p->reshapes && what > 0.91) {
            put(r, i, somewhere(&own, p->room), 0.5 + draw(&own), i % 2);
        }
    }
}

static world *other_of(const world *w, unsigned workers)
{
    world_options o = world_options_default();
    world_lender none = {0};
    bytes_out out = {0};
    world *other;
    o.workers = workers;
    world_save(w, &none, &out);
    other = world_create(&o);
    bytes_in in = {.at = out.at, .left = out.count};
    const char *wrong = world_restore(other, &none, &in);
    if (wrong) fail_msg("%s", wrong);
    array_free(&out);
    return other;
}

static run follow(const plan *p, bool cut)
{
    run r = {.told = {.at = calloc(IMPACTS_MOST, sizeof(meeting))}};
    world_subscription meet = {.facts = WORLD_IMPACT, .select_a = "*", .select_b = "*", .tolerance = 1e-6};
    uint64_t seed = p->seed, slices = p->seed + 1;
    world_batches batches;
    r.w = scene_world(cut ? p->workers : 1, true);
    scene_subscription(r.w, &meet);
    for (int i = 0; i < p->bodies; i++) {
        r.ids[i] = WORLD_NONE;
        put(&r, i, somewhere(&seed, p->room), 1, i % 2);
    }
    world_tick(r.w, 1, &batches);
    hear(&r.told, &batches, 0);
    for (int t = 1; t < p->ticks || world_changed(r.w); t++) {
        bool over = t >= p->ticks;
        assert_true(t < p->ticks + 2000);
        if (!over) command(p, &r, &seed, t);
        if (cut)
            world_set_slice(r.w, over                                ? 100000
                                 : (p->starves || below(&slices, 8)) ? below(&slices, p->slice)
                                                                     : UINT64_MAX);
        world_tick(r.w, (int64_t)(t + 1) * SECOND, &batches);
        const char *fault = world_validate(r.w);
        if (fault) fail_msg("%s", fault);
        hear(&r.told, &batches, t);
        r.hash = batches.hash;
        if (!cut || t != p->save_at) continue;
        world *other = other_of(r.w, p->workers);
        world_destroy(r.w);
        r.w = other;
    }
    r.dropped = world_get_figures(r.w).dropped_motions;
    world_destroy(r.w);
    return r;
}

static compared whole_and_cut(const plan *p, uint64_t *hash, uint64_t *dropped)
{
    run whole = follow(p, false), cut = follow(p, true);
    compared c = compare(&whole.told, &cut.told);
    *hash = cut.hash;
    *dropped = cut.dropped;
    free(whole.told.at);
    free(cut.told.at);
    return c;
}

static plan plan_of(uint64_t seed)
{
    return (plan){.seed = seed,
        .bodies = 12 + (int)(seed % 20),
        .ticks = 40,
        .room = 20,
        .step = 4,
        .stamps = seed % 2,
        .jumps = seed % 3 == 0,
        .slice = 20000 << seed % 3,
        .workers = 1,
        .save_at = -1};
}

/* ---- the tests ---- */

static void what_is_cut_is_told_later(void **state)
{
    (void)state;
    compared sum = {0};
    for (uint64_t seed = 1; seed <= 60; seed++) {
        uint64_t hash, dropped;
        plan p = plan_of(seed);
        compared c = whole_and_cut(&p, &hash, &dropped);
        assert_true(dropped || !c.given_up);
        sum.all += c.all;
        sum.late += c.late;
        sum.given_up += c.given_up;
    }
    print_message("%zu impacts, %zu told later, %zu given up\n", sum.all, sum.late, sum.given_up);
    assert_true(sum.late > 100);
    assert_true(sum.given_up < sum.all / 4);
}

/* So little in a tick that bodies wait for longer than their ways are kept. */
static void what_is_dropped_is_told(void **state)
{
    (void)state;
    size_t given_up = 0;
    uint64_t sum = 0;
    for (uint64_t seed = 1; seed <= 12; seed++) {
        uint64_t hash, dropped;
        plan p = plan_of(seed);
        p.bodies = BODIES_MOST;
        p.ticks = 100;
        p.slice = 600;
        p.reshapes = seed % 2;
        p.starves = seed % 3;
        given_up += whole_and_cut(&p, &hash, &dropped).given_up;
        sum += dropped;
    }
    assert_true(given_up > 0 && sum > 0);
}

static void workers_and_a_saved_world_tell_the_same(void **state)
{
    (void)state;
    for (uint64_t seed = 1; seed <= 12; seed++) {
        uint64_t one, other, dropped;
        plan p = plan_of(seed);
        whole_and_cut(&p, &one, &dropped);
        p.workers = 8;
        whole_and_cut(&p, &other, &dropped);
        assert_int_equal(one, other);
        p.workers = 1 + (unsigned)(seed % 4);
        p.save_at = 5 + (int)(seed % 30);
        whole_and_cut(&p, &other, &dropped);
        assert_int_equal(one, other);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(what_is_cut_is_told_later),
        cmocka_unit_test(what_is_dropped_is_told),
        cmocka_unit_test(workers_and_a_saved_world_tell_the_same),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
