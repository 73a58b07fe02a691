/* Soft bodies in the world: what a step of frames comes to is what the engine finds when it is asked at once; contacts
 * with rigid shapes, with other soft bodies and with itself begin and end once; proposals move nothing; and all of it
 * is the same for any number of workers, with caches and without, in slices, and after a save in the middle. */
#include "scene.h"
#include "soft/soft.h"
#include "world/saved.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

enum { SIDE = 12, COUNT = SIDE * SIDE, FACES = 2 * (SIDE - 1) * (SIDE - 1), STEPS = 30 };

typedef struct scene {
    world *w;
    soft_mesh *mesh;
    uint32_t cloth, other, ball;
    int64_t now_ns, frame;
    size_t begun, ended, told, unfinished;
    uint64_t meets;
    double least_safe;
    uint64_t hash;
} scene;

static vec3 rest_of(int i)
{
    return vec(0.1 * (i % SIDE), 0.1 * (i / SIDE), 0);
}

static soft_mesh *make_mesh(void)
{
    vec3 rest[COUNT];
    uint32_t faces[FACES][3];
    soft_status status;
    for (int i = 0; i < COUNT; i++) rest[i] = rest_of(i);
    size_t n = 0;
    for (uint32_t r = 0; r + 1 < SIDE; r++)
        for (uint32_t k = 0; k + 1 < SIDE; k++) {
            uint32_t v = r * SIDE + k;
            const uint32_t two[2][3] = {{v, v + 1, v + SIDE}, {v + 1, v + SIDE + 1, v + SIDE}};
            memcpy(faces[n], two, sizeof two);
            n += 2;
        }
    const soft_mesh_def def = {.rest = rest,
        .vertex_count = COUNT,
        .triangles = (const uint32_t(*)[3])faces,
        .triangle_count = FACES,
        .ring = 1};
    soft_mesh *m = soft_mesh_create(&def, &status);
    assert_non_null(m);
    return m;
}

static uint32_t put_soft(scene *s, const char *name, vec3 at)
{
    world_shape one = {.shape = {.type = SHAPE_SOFT, .radius = 0.002, .soft = s->mesh}, .local = POSE_IDENTITY};
    return scene_body(s->w, name, one, at);
}

static void tick(scene *s)
{
    world_batches b;
    world_tick(s->w, ++s->now_ns, &b);
    const char *fault = world_validate(s->w);
    if (fault) fail_msg("%s", fault);
    s->hash = b.hash;
    for (size_t i = 0; i < b.count; i++) {
        for (size_t k = 0; k < b.at[i].count; k++) {
            s->begun += !b.at[i].snapshot && b.at[i].events[k].kind == EVENT_BEGIN;
            s->ended += b.at[i].events[k].kind == EVENT_END;
        }
        for (size_t k = 0; k < b.at[i].soft_count; k++) {
            const world_soft *t = &b.at[i].soft[k];
            s->told++;
            s->meets += t->vertex_face + t->edge_edge + t->face_shape;
            s->unfinished += t->unfinished;
            s->least_safe = fmin(s->least_safe, t->safe_lo);
            assert_int_equal(t->count + t->left_out, t->vertex_face + t->edge_edge + t->face_shape);
        }
    }
}

static void finish(scene *s)
{
    for (int i = 0; i < 1000 && world_changed(s->w); i++) tick(s);
    assert_false(world_changed(s->w));
}

static scene set_up(unsigned workers, bool caches, uint64_t slice)
{
    scene s = {.w = scene_world(workers, caches), .mesh = make_mesh(), .least_safe = 1};
    world_subscription all = scene_all(WORLD_TOUCH | WORLD_FEATURES | WORLD_SAFE_STEP, 0);
    all.soft_each = true;
    world_set_slice(s.w, slice);
    scene_subscription(s.w, &all);
    s.cloth = put_soft(&s, "cloth", vec(0, 0, 1));
    s.other = put_soft(&s, "other", vec(0.03, 0.02, 1.5));
    world_shape ball = {.shape = {.type = SHAPE_SPHERE, .radius = 0.3}, .local = POSE_IDENTITY};
    s.ball = scene_body(s.w, "ball", ball, vec(0.55, 0.55, 0.4));
    finish(&s);
    return s;
}

static void tear_down(scene *s)
{
    world_destroy(s->w);
    soft_mesh_destroy(s->mesh);
}

static world_frame_status put(scene *s, uint32_t body, const vec3 at[COUNT], world_frame_mode mode)
{
    const world_range all = {0, COUNT, at};
    const world_frame f = {.frame = ++s->frame, .mode = mode, .ranges = &all, .range_count = 1};
    return world_put_frame(s->w, body, &f);
}

/* A sheet that sinks, and folds over itself along its middle. */
static void sheet(vec3 at[COUNT], int step, vec3 from, double fold)
{
    for (int i = 0; i < COUNT; i++) {
        vec3 r = rest_of(i);
        double beyond = r.x - 0.55, angle = fold * step * 0.12;
        if (angle > 3.3) angle = 3.3;
        vec3 p = beyond > 0 ? vec(0.55 + beyond * cos(angle), r.y, beyond * sin(angle)) : r;
        p.z += 1e-3 * ((i * 7919) % 17) - 0.02 * step;
        at[i] = vec_add(from, p);
    }
}

static void play(scene *s, int from, int to)
{
    vec3 at[COUNT];
    for (int step = from; step < to; step++) {
        sheet(at, step, vec(0, 0, 1), 1);
        assert_int_equal(put(s, s->cloth, at, WORLD_FRAME_MOVES), WORLD_FRAME_TAKEN);
        sheet(at, step, vec(0.03, 0.02, 1.5), step % 3);
        assert_int_equal(
            put(s, s->other, at, step % 7 == 6 ? WORLD_FRAME_TELEPORTS : WORLD_FRAME_MOVES), WORLD_FRAME_TAKEN);
        finish(s);
    }
}

static void pairs_meet_and_part(void **state)
{
    (void)state;
    scene s = set_up(1, true, UINT64_MAX);
    play(&s, 1, STEPS);
    assert_true(s.begun >= 3); /* the cloth with the ball, with the other, and one of them with itself */
    assert_true(s.meets > 0 && s.told > STEPS);
    assert_true(s.least_safe < 1);
    size_t open = s.begun - s.ended;
    world_remove_body(s.w, s.cloth, CAUSE_REMOVED);
    world_remove_body(s.w, s.other, CAUSE_REMOVED);
    world_remove_body(s.w, s.ball, CAUSE_REMOVED);
    tick(&s);
    assert_true(open > 0);
    assert_int_equal(s.begun, s.ended);
    tear_down(&s);
}

static void same_for_all(void **state)
{
    (void)state;
    scene plain = set_up(1, true, UINT64_MAX);
    play(&plain, 1, STEPS);
    for (unsigned workers = 1; workers <= 8; workers += workers < 4 ? 1 : 4)
        for (int caches = 0; caches < 2; caches++) {
            scene s = set_up(workers, caches, UINT64_MAX);
            play(&s, 1, STEPS);
            assert_int_equal(s.meets, plain.meets);
            assert_int_equal(s.hash, plain.hash);
            tear_down(&s);
        }
    tear_down(&plain);
}

/* The least slice that does anything: steps take several ticks, and what they find is the same. */
static void slices_change_no_result(void **state)
{
    (void)state;
    scene whole = set_up(2, true, UINT64_MAX), cut = set_up(2, true, 1000);
    play(&whole, 1, STEPS);
    play(&cut, 1, STEPS);
    assert_int_equal(cut.meets, whole.meets);
    assert_int_equal(cut.begun, whole.begun);
    assert_true(cut.least_safe == whole.least_safe);
    assert_int_equal(cut.unfinished, 0);
    tear_down(&whole);
    tear_down(&cut);
}

/* What the world tells of the cloth with itself is what the engine finds. */
static void counts_are_the_engines(void **state)
{
    (void)state;
    scene s = set_up(1, true, UINT64_MAX);
    vec3 from[COUNT], to[COUNT];
    uint64_t total = 0;
    soft_body *body = soft_body_create(s.mesh);
    soft_body_set_thickness(body, 0.002);
    soft_step *step = soft_step_create(NULL);
    world_remove_body(s.w, s.other, CAUSE_REMOVED);
    world_remove_body(s.w, s.ball, CAUSE_REMOVED);
    finish(&s);
    s.meets = 0;
    memcpy(from, world_soft_positions(s.w, s.cloth, NULL), sizeof from);
    for (int i = 1; i < STEPS; i++) {
        sheet(to, i, vec(0, 0, 1), 1);
        assert_int_equal(soft_body_set(body, from, to), SOFT_OK);
        const soft_pair self = {0, 0};
        const soft_step_def def = {.bodies = &body,
            .body_count = 1,
            .pairs = &self,
            .pair_count = 1,
            .want = SOFT_BRACKETS,
            .contacts_max = 1u << 20};
        assert_int_equal(soft_step_begin(step, &def), SOFT_OK);
        assert_int_equal(soft_step_run(step, 0), SOFT_OK);
        total += soft_step_tallies(step)->vertex_face + soft_step_tallies(step)->edge_edge;
        put(&s, s.cloth, to, WORLD_FRAME_MOVES);
        finish(&s);
        memcpy(from, to, sizeof from);
        assert_int_equal(s.meets, total);
    }
    assert_true(total > 0);
    soft_step_destroy(step);
    soft_body_destroy(body);
    tear_down(&s);
}

static void proposals_move_nothing(void **state)
{
    (void)state;
    scene s = set_up(1, true, UINT64_MAX);
    vec3 at[COUNT], before[COUNT];
    int64_t frame;
    memcpy(before, world_soft_positions(s.w, s.cloth, NULL), sizeof before);
    sheet(at, 40, vec(0, 0, 1), 0); /* through the ball */
    size_t told = s.told;
    assert_int_equal(put(&s, s.cloth, at, WORLD_FRAME_PROPOSES), WORLD_FRAME_TAKEN);
    finish(&s);
    assert_true(s.told > told && s.least_safe < 1 && s.least_safe > 0);
    assert_int_equal(s.begun, 0);
    assert_memory_equal(before, world_soft_positions(s.w, s.cloth, &frame), sizeof before);
    assert_int_equal(frame, 0);
    tear_down(&s);
}

static void what_cannot_be_is_refused(void **state)
{
    (void)state;
    scene s = set_up(1, true, UINT64_MAX);
    vec3 at[COUNT];
    sheet(at, 1, vec(0, 0, 1), 0);
    world_range range = {COUNT - 1, 2, at};
    world_frame f = {.frame = 5, .ranges = &range, .range_count = 1};
    assert_int_equal(world_put_frame(s.w, s.cloth, &f), WORLD_FRAME_NO_VERTEX);
    assert_int_equal(world_put_frame(s.w, s.ball, &f), WORLD_FRAME_NOT_SOFT);
    range = (world_range){COUNT - 1, 1, at};
    assert_int_equal(world_put_frame(s.w, s.cloth, &f), WORLD_FRAME_TAKEN);
    assert_int_equal(world_put_frame(s.w, s.cloth, &f), WORLD_FRAME_OLD);
    f.mode = WORLD_FRAME_PROPOSES;
    for (int i = 0; i < 8; i++) assert_int_equal(world_put_frame(s.w, s.cloth, &f), WORLD_FRAME_TAKEN);
    assert_int_equal(world_put_frame(s.w, s.cloth, &f), WORLD_FRAME_CROWDED);
    f.mode = WORLD_FRAME_MOVES, f.frame = 6;
    assert_int_equal(world_put_frame(s.w, s.cloth, &f), WORLD_FRAME_TAKEN);
    finish(&s);
    assert_int_equal(world_get_figures(s.w).frames_skipped, 1);
    tear_down(&s);
}

/* ---- saved in the middle of a step ---- */

static int64_t name_of(const void *context, const shape *of)
{
    (void)context;
    return of->type == SHAPE_SOFT ? 1 : 0;
}

static bool lend(const void *context, int64_t number, shape *to)
{
    to->soft = context;
    return number == 1;
}

static void goes_on_elsewhere(void **state)
{
    (void)state;
    scene s = set_up(1, true, 1000);
    vec3 at[COUNT];
    play(&s, 1, 20);
    sheet(at, 20, vec(0, 0, 1), 1);
    put(&s, s.cloth, at, WORLD_FRAME_MOVES);
    tick(&s);
    bytes_out out = {0};
    world_save(s.w, &(world_lender){.context = s.mesh, .name_of = name_of, .lend = lend}, &out);
    scene t = {.w = scene_world(2, true), .mesh = s.mesh, .now_ns = s.now_ns, .frame = s.frame};
    t.cloth = s.cloth, t.other = s.other;
    world_set_slice(t.w, 1000);
    bytes_in in = {out.at, out.count, false};
    const char *wrong = world_restore(t.w, &(world_lender){.context = s.mesh, .name_of = name_of, .lend = lend}, &in);
    if (wrong) fail_msg("%s", wrong);
    finish(&s), finish(&t);
    play(&s, 21, STEPS), play(&t, 21, STEPS);
    assert_int_equal(s.hash, t.hash);
    array_free(&out);
    world_destroy(t.w);
    tear_down(&s);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(pairs_meet_and_part),
        cmocka_unit_test(same_for_all),
        cmocka_unit_test(slices_change_no_result),
        cmocka_unit_test(counts_are_the_engines),
        cmocka_unit_test(proposals_move_nothing),
        cmocka_unit_test(what_cannot_be_is_refused),
        cmocka_unit_test(goes_on_elsewhere),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
