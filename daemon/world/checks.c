/* checks: see checks.h. A robot is made ready once, and kept until a shape, a filter or the robot changes. */
#include "checks.h"
#include "state.h"

#include <stdio.h>
#include <stdlib.h>

typedef struct checks_key { /* what the robot was made of */
    uint64_t shapes, rulings;
    size_t joint_count;
    robot_joint joints[ROBOT_LINKS_MAX];
    uint32_t bodies[ROBOT_LINKS_MAX];
} checks_key;

struct world_checks {
    checks_key key;
    robot_tree *tree;
    check_robot *robot;
    check_scratch *scratch;
    ARRAY(uint32_t) shape_bodies; /* of each shape of the robot */
};

void checks_free(world *w)
{
    world_checks *c = w->checks;
    if (!c) return;
    check_scratch_destroy(c->scratch);
    check_robot_destroy(c->robot);
    robot_tree_destroy(c->tree);
    array_free(&c->shape_bodies);
    free(c);
    w->checks = NULL;
}

static bool same_joint(const robot_joint *a, const robot_joint *b)
{
    return a->parent == b->parent && a->type == b->type && pose_same(a->origin, b->origin) &&
           vec_equal(a->axis, b->axis) && a->lower == b->lower && a->upper == b->upper && a->mimic == b->mimic &&
           a->factor == b->factor && a->offset == b->offset;
}

static bool is_ready(const world *w, const world_check_def *def)
{
    const world_checks *c = w->checks;
    if (!c || c->key.shapes != w->shapes_edition || c->key.rulings != w->ruling ||
        c->key.joint_count != def->joint_count)
        return false;
    for (size_t i = 0; i < def->joint_count; i++)
        if (c->key.bodies[i] != def->bodies[i] || !same_joint(&c->key.joints[i], &def->joints[i])) return false;
    return true;
}

static bool are_to_keep_apart(const world *w, uint32_t a, uint32_t b)
{
    return a != WORLD_NONE && b != WORLD_NONE && pair_get_terms(w, &w->bodies.at[a], &w->bodies.at[b]).checked;
}

static const char *fault_text(check_fault fault)
{
    static const char *const texts[] = {[CHECK_FINE] = "is in order",
        [CHECK_TOO_MANY_SHAPES] = "has more than 1024 shapes",
        [CHECK_TOO_MANY_PAIRS] =
            "has more than 1024 pairs of links that are to keep apart: let a rule allow those that cannot meet",
        [CHECK_NO_SUCH_LINK] = "names a link that is not there",
        [CHECK_ENDLESS_SHAPE] = "has a half-space or a soft body as a link",
        [CHECK_TOO_LARGE] = "is larger than 1e6 m"};
    return texts[fault];
}

static bool make_ready(world *w, const world_check_def *def, char *text, size_t text_size)
{
    checks_free(w);
    robot_status status;
    check_fault fault = CHECK_FINE;
    size_t where;
    world_checks *c = base_zalloc(1, sizeof *c);
    w->checks = c;
    c->tree = robot_tree_create(def->joints, def->joint_count, &status, &where);
    if (!c->tree) {
        snprintf(text, text_size, "joint %zu %s", where, robot_status_text(status));
        checks_free(w);
        return false;
    }
    ARRAY(check_shape) shapes = {0};
    ARRAY(check_pair) pairs = {0};
    for (uint32_t i = 0; i < def->joint_count; i++) {
        const body *b = def->bodies[i] == WORLD_NONE ? NULL : &w->bodies.at[def->bodies[i]];
        if (b && b->soft) fault = CHECK_ENDLESS_SHAPE;
        for (size_t k = 0; b && k < b->shape_count; k++) {
            const collider *s = &w->colliders.at[b->shapes[k]];
            array_push(&shapes, ((check_shape){i, &s->shape, s->local}));
            array_push(&c->shape_bodies, def->bodies[i]);
        }
        for (uint32_t k = i + 1; k < def->joint_count; k++)
            if (are_to_keep_apart(w, def->bodies[i], def->bodies[k])) array_push(&pairs, ((check_pair){i, k}));
    }
    if (fault == CHECK_FINE)
        c->robot = check_robot_create(c->tree, shapes.at, shapes.count, pairs.at, pairs.count, &fault);
    array_free(&shapes);
    array_free(&pairs);
    if (!c->robot) {
        snprintf(text, text_size, "the robot %s", fault_text(fault));
        checks_free(w);
        return false;
    }
    c->scratch = check_scratch_create(c->robot);
    c->key.shapes = w->shapes_edition;
    c->key.rulings = w->ruling;
    c->key.joint_count = def->joint_count;
    for (size_t i = 0; i < def->joint_count; i++) c->key.joints[i] = def->joints[i], c->key.bodies[i] = def->bodies[i];
    return true;
}

/* ---- obstacles ---- */

typedef struct checks_scene {
    world *w;
    const world_check_def *def;
    ARRAY(scene_obstacle_def) defs;
    ARRAY(uint32_t) bodies; /* of each definition */
    uint32_t last;          /* whose terms these are: a body has several shapes in a row */
    uint64_t ignored[2];
    bool all_ignore;
} checks_scene;

static bool is_link(const world_check_def *def, uint32_t body)
{
    for (size_t i = 0; i < def->joint_count; i++)
        if (def->bodies[i] == body) return true;
    return false;
}

static void look_up_terms(checks_scene *s, uint32_t body)
{
    if (s->last == body) return;
    s->last = body;
    s->all_ignore = true;
    memset(s->ignored, 0, sizeof s->ignored);
    for (size_t i = 0; i < s->def->joint_count; i++) {
        if (are_to_keep_apart(s->w, s->def->bodies[i], body))
            s->all_ignore = false;
        else
            s->ignored[i >> 6] |= 1ull << (i & 63);
    }
}

static bool add_obstacle(void *context, uint32_t proxy)
{
    checks_scene *s = context;
    const collider *c = &s->w->colliders.at[proxy];
    const body *b = &s->w->bodies.at[c->body];
    if (b->ghost || b->soft || is_link(s->def, c->body)) return true; /* find_unknown looks at soft ones */
    look_up_terms(s, c->body);
    if (s->all_ignore) return true;
    pose at, local;
    collider_stand(s->w, c, &at, &local);
    scene_obstacle_def def = {.shape = &c->shape,
        .pose = pose_mul(pose_relative(s->def->base, at), local),
        .ignored = {s->ignored[0], s->ignored[1]}};
    /* Two more products of poses than the narrow phase allows for: some 40 roundoffs of the lengths that enter. */
    def.widen_m = 0x1p-47 * (vec_norm(pose_relative(s->def->base, at).p) + vec_norm(local.p));
    array_push(&s->defs, def);
    array_push(&s->bodies, c->body);
    return true;
}

/* The first body, by name, that may be anywhere; NULL: there is none. */
static const char *find_unknown(world *w, const world_check_def *def, size_t *count)
{
    const char *first = NULL;
    *count = 0;
    checks_scene s = {.w = w, .def = def, .last = WORLD_NONE};
    for (uint32_t id = 0; id < w->bodies.count; id++) {
        const body *b = &w->bodies.at[id];
        if (!b->used || b->ghost || !(b->stale || b->held || b->soft) || b->shape_count == 0 || is_link(def, id))
            continue;
        look_up_terms(&s, id);
        if (s.all_ignore) continue;
        ++*count;
        if (!first || strcmp(b->name, first) < 0) first = b->name;
    }
    return first;
}

/* ---- items ---- */

static uint32_t body_of_shape(const world_checks *c, uint32_t shape)
{
    return shape == CHECK_NOBODY ? WORLD_NONE : c->shape_bodies.at[shape];
}

static void write_item(
    const world_checks *c, const checks_scene *s, const check_result *r, bool unknown, world_check_item *out)
{
    *out = (world_check_item){
        r->verdict, r->first_lo, r->first_hi, r->lo, r->hi, body_of_shape(c, r->shape_a), WORLD_NONE};
    out->body_b = r->obstacle == CHECK_NOBODY ? body_of_shape(c, r->shape_b) : s->bodies.at[r->obstacle];
    if (!unknown) return;
    if (out->verdict == CHECK_FREE) out->verdict = CHECK_UNDECIDED;
    out->first_lo = 0;
    out->lo = -INFINITY;
}

static bool configurations_are_right(const world_checks *c, const world_check_def *def, char *text, size_t text_size)
{
    size_t n = robot_tree_coordinates(c->tree), count = def->items * (def->edges ? 2 : 1);
    for (size_t i = 0; i < count; i++) {
        size_t wrong = robot_tree_beyond(c->tree, def->coordinates + i * n);
        if (wrong == SIZE_MAX) continue;
        double lower, upper;
        robot_tree_limits(c->tree, wrong, &lower, &upper);
        snprintf(text, text_size, "configuration %zu: joint %zu is %.9g, and its limits are %.9g and %.9g", i,
            robot_tree_joint_of(c->tree, wrong), def->coordinates[i * n + wrong], lower, upper);
        return false;
    }
    return true;
}

static void run_items(const world_check_def *def, const world_check_patience *patience, const world_checks *c,
    const checks_scene *s, const scene *ready, bool unknown, world_check_item *out)
{
    enum { STATES_A_TIME = 16 };
    size_t n = robot_tree_coordinates(c->tree), step = def->edges ? 1 : STATES_A_TIME;
    for (size_t i = 0; i < def->items; i += step) {
        size_t count = def->items - i < step ? def->items - i : step;
        check_result results[STATES_A_TIME];
        if (i > 0 && patience->go_on && !patience->go_on(patience->context)) { /* some are done each time */
            for (; i < def->items; i++)
                out[i] = (world_check_item){.verdict = CHECK_NOT_DONE, .body_a = WORLD_NONE, .body_b = WORLD_NONE};
            return;
        }
        const double *q = def->coordinates + i * n * (def->edges ? 2 : 1);
        if (def->edges)
            check_edge(c->robot, ready, &def->request, q, q + n, c->scratch, results, NULL, NULL);
        else
            check_states(c->robot, ready, &def->request, q, count, c->scratch, results);
        for (size_t k = 0; k < count; k++) write_item(c, s, &results[k], unknown, &out[i + k]);
    }
}

bool world_check(world *w, const world_check_def *def, const world_check_patience *patience, world_check_item *out,
    char *text, size_t text_size)
{
    *text = 0;
    if (!is_ready(w, def) && !make_ready(w, def, text, text_size)) return false;
    const world_checks *c = w->checks;
    if (!configurations_are_right(c, def, text, text_size)) return false;
    double reach = check_robot_reach(c->robot) + def->request.margin_m;
    checks_scene s = {.w = w, .def = def, .last = WORLD_NONE};
    vec3 far = vec(reach, reach, reach);
    broad_query_box(w->broad, (aabb){vec_sub(def->base.p, far), vec_add(def->base.p, far)}, add_obstacle, &s);
    scene *ready = scene_create(s.defs.at, s.defs.count, reach);
    size_t unknown;
    const char *first = find_unknown(w, def, &unknown);
    if (!first && def->others_pending > 0)
        snprintf(text, text_size, "%zu bodies wait for their geometry and may be anywhere: nothing is free",
            def->others_pending);
    if (first)
        snprintf(text, text_size,
            "%zu bodies are stale, held or soft, and may be anywhere, \"%.127s\" among them: nothing is free", unknown,
            first);
    run_items(def, patience, c, &s, ready, first != NULL || def->others_pending > 0, out);
    scene_destroy(ready);
    array_free(&s.defs);
    array_free(&s.bodies);
    return true;
}
