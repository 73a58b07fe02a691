/* Answers belong to names. The same bodies and the same steps, announced in other orders, by way of bodies that came
 * and went before, and asked for by subscriptions in another order, bring the same events, bit for bit: ids, which
 * follow from the order of announcement, only decide in which order the events of a tick are told and how contacts are
 * numbered. Many shapes are equal to others, so that nothing but their names tells which of a pair is A. */
#include "base/prng.h"
#include "scene.h"

#include "geom/compound.h"
#include "geom/hull.h"
#include "geom/mesh.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

enum { BODIES = 44, KINDS = 11, SHAPES_MAX = 3, SUBSCRIPTIONS = 9, LINE = 1400, QUERIES = 7 };
static const int64_t STEP_NS = 20000000;

/* ---- shapes: each kind is there four times, of one size ---- */

static struct {
    hull *rock;
    mesh *ridge;
    compound *rack;
} made;

static int make_shapes(void **state)
{
    (void)state;
    uint64_t r = 3;
    double points[60];
    for (int i = 0; i < 60; i++) points[i] = prng_in(&r, -0.3, 0.3);
    assert_int_equal(hull_build(points, 20, 0, &made.rock), HULL_OK);
    static const double TENT[] = {-.3, -.3, 0, .3, -.3, 0, .3, .3, 0, -.3, .3, 0, 0, 0, .4, 0, 0, .1};
    static const int32_t SIDES[] = {0, 1, 4, 1, 2, 4, 2, 3, 4, 3, 0, 4, 1, 0, 5, 2, 1, 5, 3, 2, 5, 0, 3, 5};
    assert_int_equal(mesh_build(TENT, 6, SIDES, 8, &made.ridge), MESH_OK);
    shape parts[3] = {{.type = SHAPE_BOX, .half = vec(.3, .05, .05)}, {.type = SHAPE_BOX, .half = vec(.05, .3, .05)},
        {.type = SHAPE_CAPSULE, .half = vec(0, 0, .2), .radius = .06}};
    pose locals[3] = {POSE_IDENTITY, {vec(.2, 0, .1), {1, 0, 0, 0}}, {vec(-.2, .1, 0), {1, 0, 0, 0}}};
    assert_int_equal(compound_build(parts, locals, 3, &made.rack), COMPOUND_OK);
    return 0;
}

static int drop_shapes(void **state)
{
    (void)state;
    hull_destroy(made.rock);
    mesh_destroy(made.ridge);
    compound_destroy(made.rack);
    return 0;
}

static shape shape_of(int kind)
{
    switch (kind) {
    case 0:
        return (shape){.type = SHAPE_SPHERE, .radius = 0.3};
    case 1:
        return (shape){.type = SHAPE_CAPSULE, .half = vec(0, 0, 0.25), .radius = 0.15};
    case 2:
        return (shape){.type = SHAPE_BOX, .half = vec(0.2, 0.25, 0.3)};
    case 3:
        return (shape){.type = SHAPE_CYLINDER, .half = vec(0.2, 0.2, 0.25)};
    case 4:
        return (shape){.type = SHAPE_CONE, .half = vec(0.25, 0.25, 0.25)};
    case 5:
        return (shape){.type = SHAPE_ELLIPSOID, .half = vec(0.2, 0.25, 0.35)};
    case 6:
        return (shape){.type = SHAPE_HULL, .hull = made.rock};
    case 7:
        return (shape){.type = SHAPE_MESH, .mesh = made.ridge, .hull = made.ridge->hull};
    case 8:
        return (shape){.type = SHAPE_COMPOUND, .compound = made.rack};
    case 9:
        return (shape){.type = SHAPE_BOX, .half = vec(0.2, 0.2, 0.2), .radius = 0.05};
    default:
        return (shape){.type = SHAPE_HULL, .hull = made.rock, .radius = 0.04};
    }
}

/* ---- what happens, by names ---- */

typedef struct plan { /* of a run: in which order things are announced */
    int bodies[BODIES], subscriptions[SUBSCRIPTIONS];
    bool came_before[BODIES]; /* there was another one of that name, which has gone */
} plan;

typedef struct run {
    world *w;
    uint32_t ids[BODIES], subscription_ids[SUBSCRIPTIONS];
    int subscription_of[64]; /* by id */
    vec3 at[BODIES], velocity[BODIES], spin[BODIES];
    quat turned[BODIES];
    int64_t now_ns;
    char (*lines)[LINE]; /* of this tick */
    int64_t *contacts;   /* of each of them */
    size_t count, room;
} run;

static const char *name_of(int i)
{
    static char names[BODIES][16];
    snprintf(names[i], sizeof names[i], "b%d%s", i * 7 % BODIES, i % 3 ? "" : "_x");
    return names[i];
}

static void put(run *r, int i, bool other)
{
    world_shape shapes[SHAPES_MAX];
    size_t count = i % 5 == 0 ? 3 : 1;
    for (size_t k = 0; k < count; k++) {
        shapes[k] =
            (world_shape){.shape = shape_of((i + (other ? 1 : 0) + (k ? 2 : 0)) % KINDS), .local = POSE_IDENTITY};
        if (k) shapes[k].local.p = vec(k == 1 ? 0.5 : -0.5, 0, 0); /* the second and the third are equal, too */
    }
    filter_rule padded = {.pattern = "b1*", .padding = 0.02, .margin = 0.05};
    world_body def = {.name = name_of(i),
        .group = i % 2 ? "odd" : "even",
        .category = 1,
        .mask = UINT64_MAX,
        .fixed = i % 9 == 4,
        .one_way = i % 13 == 0,
        .ccd = i % 4 == 0   ? WORLD_CCD_FULL
               : i % 4 == 1 ? WORLD_CCD_LINEAR
                            : WORLD_CCD_OFF,
        .acceleration = i % 10 == 3 ? 0.2 : 0,
        .deadline_ns = i % 8 == 7 ? 3 * STEP_NS : 0,
        .stamp_ns = r->now_ns,
        .pose = {r->at[i], r->turned[i]},
        .shapes = shapes,
        .shape_count = count,
        .rules = &padded,
        .rule_count = i % 6 == 0};
    assert_int_equal(world_put_body(r->w, &r->ids[i], &def), WORLD_OK);
}

static const world_subscription WANTED[SUBSCRIPTIONS] = {
    {.facts = WORLD_TOUCH, .select_a = "*", .select_b = "*", .tolerance = 1e-9},
    {.facts = WORLD_TOUCH | WORLD_MANIFOLD,
        .select_a = "*",
        .select_b = "*",
        .hysteresis = 0.01,
        .relative_tolerance = 1e-6},
    {.facts = WORLD_DISTANCE, .select_a = "group:even", .select_b = "*", .range = 0.3, .tolerance = 1e-6},
    {.facts = WORLD_IMPACT, .select_a = "*", .select_b = "*", .tolerance = 1e-5},
    {.facts = WORLD_PREDICT, .select_a = "*", .select_b = "group:odd", .tolerance = 1e-4, .horizon = 0.2},
    {.facts = WORLD_TOUCH | WORLD_DISTANCE,
        .select_a = "b1*",
        .select_b = "*",
        .range = 0.2,
        .accuracy = WORLD_BY_BOXES},
    {.facts = WORLD_TOUCH, .select_a = "b2*", .select_b = "*", .accuracy = WORLD_BY_VERDICT},
    {.facts = WORLD_TOUCH, .select_a = "b2*", .select_b = "*", .accuracy = WORLD_BY_VERDICT, .hysteresis = 0.02},
    {.facts = WORLD_TOUCH | WORLD_DISTANCE,
        .select_a = "*",
        .select_b = "b3*",
        .range = 0.1,
        .tolerance = 1e-9,
        .period_ns = 50000000},
};

/* ---- what is told, as lines ---- */

static int add(char *line, int at, const char *format, ...) __attribute__((format(printf, 3, 4)));
static int add(char *line, int at, const char *format, ...)
{
    va_list args;
    va_start(args, format);
    at += vsnprintf(line + at, (size_t)(LINE - at), format, args);
    va_end(args);
    assert_true(at < LINE);
    return at;
}

static int add_vec(char *line, int at, vec3 v)
{
    return add(line, at, " %a %a %a", v.x, v.y, v.z);
}

static int add_pose(char *line, int at, pose p)
{
    at = add_vec(line, at, p.p);
    return add(line, at, " %a %a %a %a", p.q.w, p.q.x, p.q.y, p.q.z);
}

static char *new_line(run *r, int64_t contact)
{
    if (r->count == r->room) {
        r->room = 2 * r->room + 256;
        r->lines = realloc(r->lines, r->room * sizeof *r->lines);
        r->contacts = realloc(r->contacts, r->room * sizeof *r->contacts);
    }
    r->contacts[r->count] = contact;
    return r->lines[r->count++];
}

static void tell(run *r, const world_batch *b, const world_event *e)
{
    char *line = new_line(r, e->contact);
    int at = add(line, 0, "%d %d kind %d cause %d achieved %d %s/%d %s/%d", r->subscription_of[b->subscription],
        b->snapshot, e->kind, e->cause, e->achieved, e->name_a, e->shape_a, e->name_b, e->shape_b);
    at = add(line, at, " %a %a", e->lo, e->hi);
    at = add_vec(line, at, e->axis);
    at = add_vec(line, at, e->point_a);
    at = add_vec(line, at, e->point_b);
    at = add(
        line, at, " %lld %lld %a %u", (long long)e->age_a_ns, (long long)e->age_b_ns, e->closing, e->manifold.count);
    for (uint32_t i = 0; i < e->manifold.count; i++) {
        const manifold_point *p = &e->manifold.points[i];
        at = add_vec(line, at, p->point);
        at = add(line, at, " %a %llx", p->distance, (unsigned long long)p->feature);
    }
    if (e->kind != EVENT_IMPACT && e->kind != EVENT_PREDICTED) return;
    at = add(line, at, " impact %a %a %lld %d", e->impact.lo, e->impact.hi, (long long)e->impact.start_ns,
        e->impact.estimated);
    at = add_pose(line, at, e->impact.pose_a);
    add_pose(line, at, e->impact.pose_b);
}

static void tell_hits(run *r, const char *what, int i, world_hits *hits)
{
    for (size_t k = 0; k < hits->count; k++) {
        const world_hit *h = &hits->at[k];
        const char *b = h->body_b == WORLD_NONE ? "" : world_body_name(r->w, h->body_b);
        char *line = new_line(r, 0);
        int at = add(line, 0, "%s %d, hit %zu: %s %s", what, i, k, world_body_name(r->w, h->body_a), b);
        at = add(line, at, " %a %a", h->lo, h->hi);
        at = add_vec(line, at, h->axis);
        at = add_vec(line, at, h->point_a);
        add_vec(line, at, h->point_b);
    }
    free(hits->at);
}

static void ask(run *r, int step)
{
    for (int n = 0; n < 12; n++) {
        int i = (step * 12 + n) % BODIES, k = (i + 1 + n * 3) % BODIES;
        world_hits hits[QUERIES] = {0};
        if (i == k) continue;
        vec3 from = vec_add(r->at[i], vec(0.01, 0.02, 4)), down = {0.01, 0, -1}, half = vec(0.3, 0.2, 0.4);
        world_query_distance(r->w, r->ids[i], r->ids[k], 1e-9, r->now_ns, &hits[0]);
        world_query_ray(r->w, from, down, 10, 1e-6, r->now_ns, &hits[1]);
        world_query_cast(r->w, (pose){from, {1, 0, 0, 0}}, half, down, 10, 1e-6, r->now_ns, &hits[2]);
        world_query_sweep(r->w, r->ids[i], vec(1, 0.2, 0.1), vec(0, 0, 1), 2, 1e-6, r->now_ns, &hits[3]);
        world_query_nearest(r->w, (pose){r->at[i], {1, 0, 0, 0}}, half, 2, 5, 1e-6, r->now_ns, &hits[4]);
        world_query_nearest_to(r->w, r->ids[i], 2, 5, 1e-6, r->now_ns, &hits[5]);
        world_query_box(r->w, (pose){r->at[i], {1, 0, 0, 0}}, half, r->now_ns, &hits[6]);
        static const char *const WHAT[QUERIES] = {"distance", "ray", "cast", "sweep", "nearest", "nearest to", "box"};
        for (int q = 0; q < QUERIES; q++) tell_hits(r, WHAT[q], i, &hits[q]);
    }
}

/* ---- a run ---- */

static void tick(run *r)
{
    world_batches batches;
    r->now_ns += STEP_NS;
    r->count = 0;
    world_tick(r->w, r->now_ns, &batches);
    const char *fault = world_validate(r->w);
    if (fault) fail_msg("%s", fault);
    for (size_t i = 0; i < batches.count; i++)
        for (size_t k = 0; k < batches.at[i].count; k++) tell(r, &batches.at[i], &batches.at[i].events[k]);
}

static void begin(run *r, const plan *p)
{
    world_options o = world_options_default();
    o.broad = p->came_before[0] ? BROAD_SWEEP3 : BROAD_TREE;
    o.caches = !p->came_before[1];
    o.workers = p->came_before[2] ? 2 : 1;
    *r = (run){.w = world_create(&o), .now_ns = 1000000000};
    uint64_t random = 17;
    for (int i = 0; i < BODIES; i++) {
        r->at[i] = vec(prng_in(&random, -1.4, 1.4), prng_in(&random, -1.4, 1.4), prng_in(&random, -0.8, 0.8));
        bool lattice = i % 3 == 0; /* parallel to each other, and at rest: what several features decide alike */
        if (lattice) r->at[i] = vec(round(2 * r->at[i].x) / 2, round(2 * r->at[i].y) / 2, round(2 * r->at[i].z) / 2);
        r->turned[i] = lattice ? (quat){1, 0, 0, 0}
                               : quat_unit((quat){prng_in(&random, -1, 1), prng_in(&random, -1, 1),
                                     prng_in(&random, -1, 1), prng_in(&random, -1, 1)});
        r->velocity[i] =
            lattice ? VEC_ZERO : vec(prng_in(&random, -2, 2), prng_in(&random, -2, 2), prng_in(&random, -1, 1));
        r->spin[i] =
            lattice ? VEC_ZERO : vec(prng_in(&random, -2, 2), prng_in(&random, -2, 2), prng_in(&random, -2, 2));
        r->ids[i] = WORLD_NONE;
    }
    for (int n = 0; n < BODIES; n++) {
        int i = p->bodies[n];
        if (!p->came_before[i]) continue;
        put(r, i, true);
        if (n % 3 == 0) tick(r);
    }
    tick(r);
    for (int n = 0; n < BODIES; n++) {
        int i = p->bodies[BODIES - 1 - n];
        if (!p->came_before[i]) continue;
        assert_int_equal(world_remove_body(r->w, r->ids[i], CAUSE_REMOVED), WORLD_OK);
        r->ids[i] = WORLD_NONE;
        if (n % 4 == 0) tick(r);
    }
    r->now_ns = 2000000000;
    for (int n = 0; n < BODIES; n++) {
        put(r, p->bodies[n], false);
        if (n % 8 == 7) world_tick(r->w, r->now_ns, &(world_batches){.at = NULL});
    }
    for (int n = 0; n < SUBSCRIPTIONS; n++) {
        int i = p->subscriptions[n];
        r->subscription_ids[i] = WORLD_NONE;
        assert_int_equal(world_put_subscription(r->w, &r->subscription_ids[i], &WANTED[i]), WORLD_OK);
        r->subscription_of[r->subscription_ids[i]] = i;
    }
    tick(r);
}

/* Two walls at rest between which they go to and fro. */
static void move(run *r, uint64_t *random)
{
    const double dt = 1e-9 * (double)STEP_NS;
    for (int i = 0; i < BODIES; i++) {
        if (prng_bits(random) % 6 == 0) continue; /* says nothing now */
        double *p = &r->at[i].x, *v = &r->velocity[i].x;
        for (int k = 0; k < 3; k++) {
            p[k] += v[k] * dt;
            if (fabs(p[k]) > 1.5 && p[k] * v[k] > 0) v[k] = -v[k];
        }
        quat q = r->turned[i];
        vec3 s = vec_scale(r->spin[i], 0.5 * dt);
        r->turned[i] =
            quat_unit((quat){q.w - s.x * q.x - s.y * q.y - s.z * q.z, q.x + s.x * q.w + s.y * q.z - s.z * q.y,
                q.y + s.y * q.w + s.z * q.x - s.x * q.z, q.z + s.z * q.w + s.x * q.y - s.y * q.x});
        pose to = {r->at[i], r->turned[i]};
        int64_t stamp = r->now_ns + STEP_NS / 2;
        bool given = i % 5 != 1;
        const vec3 *linear = given ? &r->velocity[i] : NULL, *spin = given ? &r->spin[i] : NULL;
        if (prng_bits(random) % 64 == 0)
            assert_int_equal(world_teleport_body(r->w, r->ids[i], to, stamp, linear, spin), WORLD_OK);
        else
            assert_int_equal(world_move_body(r->w, r->ids[i], to, stamp, linear, spin), WORLD_OK);
    }
    int i = (int)(prng_bits(random) % BODIES);
    bool other = prng_bits(random) % 2;
    if (prng_bits(random) % 2) put(r, i, other); /* perhaps with other shapes, and where it is */
    if (prng_bits(random) % 8 == 0) {
        i = (int)(prng_bits(random) % BODIES);
        world_remove_body(r->w, r->ids[i], CAUSE_REMOVED);
        r->ids[i] = WORLD_NONE;
        put(r, i, false);
    }
    if (prng_bits(random) % 8 == 0) world_hold_body(r->w, r->ids[prng_bits(random) % BODIES]);
}

/* ---- the same ---- */

static const run *sorted; /* by whom `by_line` compares */
static int by_line(const void *a, const void *b)
{
    return strcmp(sorted->lines[*(const size_t *)a], sorted->lines[*(const size_t *)b]);
}

static size_t *sort_lines(const run *r)
{
    size_t *order = malloc((r->count + 1) * sizeof *order);
    for (size_t i = 0; i < r->count; i++) order[i] = i;
    sorted = r;
    qsort(order, r->count, sizeof *order, by_line);
    return order;
}

/* Contacts have other numbers, but each one of the one run is one of the other. */
static void same(const run *a, const run *b, int64_t *number_in_b, int step)
{
    size_t *x = sort_lines(a), *y = sort_lines(b);
    for (size_t i = 0; i < a->count && i < b->count; i++)
        if (strcmp(a->lines[x[i]], b->lines[y[i]]) != 0)
            fail_msg("step %d:\n%s\nis not\n%s", step, a->lines[x[i]], b->lines[y[i]]);
    if (a->count != b->count) fail_msg("step %d: %zu lines, and %zu", step, a->count, b->count);
    for (size_t i = 0; i < a->count; i++) {
        int64_t of_a = a->contacts[x[i]], of_b = b->contacts[y[i]];
        assert_true(!of_a == !of_b && of_a < 1 << 20);
        if (of_a && !number_in_b[of_a]) number_in_b[of_a] = of_b;
        assert_true(!of_a || number_in_b[of_a] == of_b);
    }
    free(x);
    free(y);
}

static plan shuffled(uint64_t *r)
{
    plan p;
    for (int i = 0; i < BODIES; i++) p.bodies[i] = i, p.came_before[i] = prng_bits(r) % 3 == 0;
    for (int i = 0; i < SUBSCRIPTIONS; i++) p.subscriptions[i] = i;
    for (int i = BODIES - 1; i > 0; i--) {
        int k = (int)(prng_bits(r) % (uint64_t)(i + 1)), was = p.bodies[i];
        p.bodies[i] = p.bodies[k];
        p.bodies[k] = was;
    }
    for (int i = SUBSCRIPTIONS - 1; i > 0; i--) {
        int k = (int)(prng_bits(r) % (uint64_t)(i + 1)), was = p.subscriptions[i];
        p.subscriptions[i] = p.subscriptions[k];
        p.subscriptions[k] = was;
    }
    return p;
}

static void end(run *r)
{
    world_destroy(r->w);
    free(r->lines);
    free(r->contacts);
}

/* 60 steps of 5 orders; with COLLIDED_NIGHTLY=1 in the environment 400 of 10. */
static void events_belong_to_names_and_not_to_the_order_of_announcement(void **state)
{
    (void)state;
    bool nightly = getenv("COLLIDED_NIGHTLY") != NULL;
    int orders = nightly ? 10 : 5, steps = nightly ? 400 : 60;
    size_t told = 0, kinds[EVENT_AVERTED + 1] = {0};
    for (int n = 0; n < orders; n++) {
        uint64_t random = 100 + (uint64_t)n;
        plan plain, other = shuffled(&random);
        for (int i = 0; i < BODIES; i++) plain.bodies[i] = i, plain.came_before[i] = false;
        for (int i = 0; i < SUBSCRIPTIONS; i++) plain.subscriptions[i] = i;
        run a, b;
        begin(&a, &plain);
        begin(&b, &other);
        int64_t *number_in_b = calloc(1 << 20, sizeof *number_in_b);
        same(&a, &b, number_in_b, -1);
        uint64_t of_a = 5 + (uint64_t)n, of_b = of_a;
        for (int step = 0; step < steps; step++) {
            move(&a, &of_a);
            move(&b, &of_b);
            tick(&a);
            tick(&b);
            if (step % 4 == 0) ask(&a, step);
            if (step % 4 == 0) ask(&b, step);
            same(&a, &b, number_in_b, step);
            told += a.count;
            for (size_t i = 0; i < a.count; i++) {
                int kind = 0;
                if (sscanf(a.lines[i], "%*d %*d kind %d", &kind) == 1) kinds[kind]++;
            }
        }
        free(number_in_b);
        end(&a);
        end(&b);
    }
    print_message("%zu lines;", told);
    for (int k = EVENT_BEGIN; k <= EVENT_AVERTED; k++) {
        print_message(" %zu of kind %d", kinds[k], k);
        assert_true(kinds[k] > 0);
    }
    print_message("\n");
}

/* Of two who ask for a verdict, one with hysteresis: neither is told less because he asked first. */
static void how_far_a_pair_is_looked_into_depends_on_no_order_of_subscriptions(void **state)
{
    (void)state;
    world_event told[2];
    for (int turned = 0; turned < 2; turned++) {
        world *w = scene_world(1, true);
        world_subscription plain = scene_all(WORLD_TOUCH, 0), sticky = plain;
        plain.accuracy = sticky.accuracy = WORLD_BY_VERDICT;
        sticky.hysteresis = 0.02;
        scene_subscription(w, turned ? &sticky : &plain);
        scene_subscription(w, turned ? &plain : &sticky);
        world_shape stone = {.shape = shape_of(6), .local = POSE_IDENTITY}, egg = {shape_of(5), POSE_IDENTITY};
        scene_body(w, "stone", stone, vec(0, 0, 0));
        scene_body(w, "egg", egg, vec(0.2, 0.1, 0.15));
        world_batches batches;
        world_tick(w, SECOND, &batches);
        for (size_t i = 0; i < batches.count; i++)
            if (batches.at[i].count) told[turned] = batches.at[i].events[0];
        told[turned].name_a = told[turned].name_b = NULL;
        world_destroy(w);
    }
    assert_int_equal(told[0].kind, EVENT_BEGIN);
    assert_true(told[0].lo == told[1].lo && told[0].hi == told[1].hi);
    assert_memory_equal(&told[0].axis, &told[1].axis, sizeof told[0].axis);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(events_belong_to_names_and_not_to_the_order_of_announcement),
        cmocka_unit_test(how_far_a_pair_is_looked_into_depends_on_no_order_of_subscriptions),
    };
    return cmocka_run_group_tests(tests, make_shapes, drop_shapes);
}
