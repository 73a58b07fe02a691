/* A fitted robot: each link's shapes hold it and exceed it by no more than is said, at drawn points; links that never
 * meet do not, at drawn joint values; the scene that is written loads again, as it was. The panda of the shared folder,
 * if it is there, and the project's own arm. 10^6 points a link with COLLIDED_NIGHTLY=1. */
#include "fit_fixture.h"

#include "geom/mesh.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const double EXCESS = 0.005, ROUNDING = 1e-9;

typedef struct fitted {
    fixture f;
    robot robot;
    fit_robot fit;
} fitted;

/* With sanitizers. */
static bool is_brief(void)
{
    return getenv("COLLIDED_BRIEF") != NULL;
}

static void fit(fitted *t, double excess)
{
    fit_options o = {.excess_m = excess, .boxes_max = is_brief() ? 2000 : 0};
    if (!fit_robot_make(&t->f.pool, &t->robot, &o, &t->fit, &t->f.report)) fail_msg("%s", t->f.report.error);
}

/* Of the shapes as they are: no point is farther than the excess from the link. */
static void exceeds_by_no_more(const fit_link *l, const solid_set *now, const solid_set *before, size_t count)
{
    prng r = {1};
    double most = 0;
    vec3 last = VEC_ZERO;
    for (size_t n = 0; n < count; n++) {
        vec3 x = set_surface_point(now, n % now->count, &r);
        if (n % 4 == 3 && now->count == 1) x = vec_add(x, vec_scale(vec_sub(last, x), drawn(&r, 0, 1))); /* inside */
        last = x;
        double away = set_away(before, x);
        most = fmax(most, away);
        if (away > l->excess_m + ROUNDING)
            fail_msg("%s: a point is %.9g m from the link, not %.9g", l->name, away, l->excess_m);
    }
    assert_true(now->count > 1 || l->how == FIT_AS_IT_WAS || most > 0.25 * l->excess_m); /* it means something */
}

static void holds(const fit_link *l, const solid_set *now, const solid_set *before, size_t count)
{
    prng r = {2};
    for (size_t i = 0; i < before->count; i++) {
        const mesh_triangles *t = &l->before[i].triangles;
        for (size_t k = 0; k < t->point_count; k++) {
            vec3 x = {t->points[3 * k], t->points[3 * k + 1], t->points[3 * k + 2]};
            x = vec_add(quat_rotate(before->local[i].q, x), before->local[i].p);
            if (set_away_at_least(now, x) > 0) fail_msg("%s: a corner is outside", l->name);
        }
    }
    for (size_t n = 0; n < count; n++) {
        vec3 x = set_surface_point(before, n % before->count, &r);
        if (set_away_at_least(now, x) > 1e-12) fail_msg("%s: a point of it is outside", l->name);
    }
}

static void links_are_held(const fitted *t, double excess)
{
    size_t count = getenv("COLLIDED_NIGHTLY") ? 1000000 : fit_count(400000);
    for (size_t i = 0; i < t->fit.link_count; i++) {
        const fit_link *l = &t->fit.links[i];
        solid_set now, before;
        assert_true(l->excess_m <= excess);
        set_make(&now, l->shapes, l->shape_count);
        set_make(&before, l->before, l->before_count);
        if (l->how != FIT_AS_IT_WAS) {
            exceeds_by_no_more(l, &now, &before, count);
            holds(l, &now, &before, count / 50);
        }
        set_free(&now);
        set_free(&before);
    }
}

/* ---- pairs ---- */

static void draw_values(const robot *b, prng *r, double *values)
{
    for (int i = 0; i < b->model.joint_count; i++) {
        const urdf_joint *j = &b->model.joints[i];
        double lo = j->limited ? j->lower : -4, hi = j->limited ? j->upper : 4;
        values[i] = prng_below(r, 4) == 0 ? (prng_below(r, 2) ? lo : hi) : drawn(r, lo, hi);
    }
}

static void links_never_meet(const fitted *t)
{
    const fit_robot *f = &t->fit;
    size_t count = fit_count(20000);
    double *values = calloc((size_t)t->robot.model.joint_count, sizeof *values);
    collided_pose *poses = calloc((size_t)t->robot.model.link_count, sizeof *poses);
    solid_set *sets = calloc(f->link_count, sizeof *sets);
    prng r = {3};
    for (size_t i = 0; i < f->link_count; i++) set_make(&sets[i], f->links[i].convex, f->links[i].convex_count);
    for (size_t n = 0; n < count; n++) {
        draw_values(&t->robot, &r, values);
        robot_forward(&t->robot, values, poses);
        for (size_t i = 0; i < f->pair_count; i++) {
            const fit_pair *p = &f->pairs[i];
            if (p->answer.verdict != NEVER_PROVEN) continue;
            double away = set_distance(&sets[p->a], pose_from(&poses[f->links[p->a].link]), &sets[p->b],
                pose_from(&poses[f->links[p->b].link]));
            if (away < p->answer.clearance_m - ROUNDING)
                fail_msg("%s and %s come as near as %.9g m, not %.9g", f->links[p->a].name, f->links[p->b].name, away,
                    p->answer.clearance_m);
        }
    }
    for (size_t i = 0; i < f->link_count; i++) set_free(&sets[i]);
    free(sets);
    free(poses);
    free(values);
}

static const fit_pair *find_pair(const fit_robot *f, const char *a, const char *b)
{
    for (size_t i = 0; i < f->pair_count; i++)
        if (strcmp(f->links[f->pairs[i].a].name, a) == 0 && strcmp(f->links[f->pairs[i].b].name, b) == 0)
            return &f->pairs[i];
    fail_msg("no pair %s, %s", a, b);
    return NULL;
}

/* ---- the panda ---- */

/* All that its SRDF calls "Never" is proven, but for link2 and link6: their meshes do meet, within the limits. */
static void what_the_srdf_disables_is_proven(fitted *t)
{
    for (size_t i = 0; i < t->fit.pair_count; i++) {
        const fit_pair *p = &t->fit.pairs[i];
        bool never = p->disabled && strcmp(p->disabled, "Never") == 0;
        bool known = p == find_pair(&t->fit, "panda_link2", "panda_link6");
        if (never) assert_int_equal(p->answer.verdict, known ? NEVER_MEET : NEVER_PROVEN);
    }
    const fit_pair *p = find_pair(&t->fit, "panda_link2", "panda_link6");
    double *values = pool_alloc(&t->f.pool, (size_t)t->robot.model.joint_count, sizeof *values);
    collided_pose *poses = pool_alloc(&t->f.pool, (size_t)t->robot.model.link_count, sizeof *poses);
    robot_default_values(&t->robot, values);
    if (!robot_set_list(&t->robot, p->answer.at, values, &t->f.report)) fail_msg("%s", t->f.report.error);
    robot_forward(&t->robot, values, poses);
    const fit_link *a = &t->fit.links[p->a], *b = &t->fit.links[p->b];
    solid_set meshes_a, meshes_b;
    set_make(&meshes_a, a->before, a->before_count);
    set_make(&meshes_b, b->before, b->before_count);
    assert_true(set_distance(&meshes_a, pose_from(&poses[a->link]), &meshes_b, pose_from(&poses[b->link])) < -0.001);
    set_free(&meshes_a);
    set_free(&meshes_b);
}

static void the_panda_is_fitted(void **state)
{
    (void)state;
    fitted t = {0};
    fixture_begin(&t.f);
    if (!fixture_panda_solid(&t.f, &t.robot)) skip();
    fit(&t, EXCESS);
    assert_int_equal(t.fit.link_count, 11);
    for (size_t i = 0; i < t.fit.link_count; i++) assert_int_equal(t.fit.links[i].how, FIT_ONE);
    assert_true(t.fit.ns < t.fit.ns_before / 3);
    links_are_held(&t, EXCESS);
    links_never_meet(&t);
    if (!is_brief()) what_the_srdf_disables_is_proven(&t);
    fixture_end(&t.f);
}

/* ---- the arm ---- */

static void the_arm_is_fitted(void **state)
{
    (void)state;
    fitted t = {0};
    fixture_begin(&t.f);
    fixture_arm(&t.f, &t.robot);
    fit(&t, EXCESS);
    links_are_held(&t, EXCESS);
    links_never_meet(&t);
    assert_int_equal(find_pair(&t.fit, "wrist_2_link", "tool_link")->answer.verdict, NEVER_PROVEN);
    assert_int_equal(find_pair(&t.fit, "base_link", "tool_link")->answer.verdict, NEVER_MEET);
    fixture_end(&t.f);
}

/* Whatever the excess, it is kept; a large one makes everything simple. */
static void any_excess_is_kept(void **state)
{
    (void)state;
    static const double excesses[] = {1e-6, 0.3};
    for (int i = 0; i < 2; i++) {
        fitted t = {0};
        fixture_begin(&t.f);
        fixture_arm(&t.f, &t.robot);
        fit_options o = {.excess_m = excesses[i], .boxes_max = 50};
        assert_true(fit_robot_make(&t.f.pool, &t.robot, &o, &t.fit, &t.f.report));
        for (size_t k = 0; k < t.fit.link_count; k++) {
            const fit_link *l = &t.fit.links[k];
            assert_true(l->excess_m <= excesses[i] && l->ns <= l->ns_before);
            if (i == 1) assert_int_equal(l->shape_count, 1);
        }
        fixture_end(&t.f);
    }
}

static bool same_shape(const load_shape *a, const load_shape *b)
{
    const collided_shape *x = &a->shape, *y = &b->shape;
    bool same = x->type == y->type && x->radius == y->radius && x->deviation == y->deviation &&
                memcmp(x->half, y->half, sizeof x->half) == 0 &&
                memcmp(x->pose.position, y->pose.position, sizeof x->pose.position) == 0 &&
                a->points.count == b->points.count;
    for (int k = 0; k < 4; k++) same = same && fabs(x->pose.orientation[k] - y->pose.orientation[k]) < 1e-15;
    return same && (a->points.count == 0 ||
                       memcmp(a->points.at, b->points.at, 3 * a->points.count * sizeof *a->points.at) == 0);
}

static bool has_rule(const load_body *body, const char *other, const char *words)
{
    for (size_t i = 0; i < body->rule_count; i++)
        if (strcmp(body->rules[i].pattern, other) == 0)
            return body->rules[i].allow && strstr(body->rules[i].reason, words);
    return false;
}

static void the_scene_is_what_was_found(void **state)
{
    (void)state;
    fitted t = {0};
    fixture_begin(&t.f);
    fixture_arm(&t.f, &t.robot);
    fit(&t, 0.02);
    char *text = NULL;
    size_t size = 0;
    FILE *out = open_memstream(&text, &size);
    fit_robot_write(out, &t.fit, 0.02);
    fclose(out);
    scene s;
    if (!scene_parse(&s, &t.f.pool, text, size, "fitted.yaml", &t.f.report)) fail_msg("%s", t.f.report.error);
    free(text);
    assert_int_equal(s.robot_count, 1);
    robot again;
    load_bodies bodies;
    if (!robot_load(&again, &t.f.pool, &s.robots[0].source, &t.f.report)) fail_msg("%s", t.f.report.error);
    double *values = pool_alloc(&t.f.pool, (size_t)again.model.joint_count, sizeof *values);
    robot_default_values(&again, values);
    if (!robot_bodies(&again, collided_pose_identity(), values, COLLIDED_MOVING, &t.f.pool, &bodies, &t.f.report))
        fail_msg("%s", t.f.report.error);
    assert_int_equal(bodies.count, t.fit.link_count);
    for (size_t i = 0; i < bodies.count; i++) {
        const fit_link *l = &t.fit.links[i];
        assert_int_equal(bodies.at[i].shape_count, l->shape_count);
        for (size_t k = 0; k < l->shape_count; k++) assert_true(same_shape(&bodies.at[i].shapes[k], &l->shapes[k]));
    }
    for (size_t i = 0; i < t.fit.pair_count; i++) {
        const fit_pair *p = &t.fit.pairs[i];
        const load_body *a = &bodies.at[p->a], *b = &bodies.at[p->b];
        bool proven = p->answer.verdict == NEVER_PROVEN;
        assert_int_equal(has_rule(a, b->name, "proven: never meet"), proven);
        assert_int_equal(has_rule(b, a->name, "proven: never meet"), proven);
    }
    fixture_end(&t.f);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_arm_is_fitted),
        cmocka_unit_test(any_excess_is_kept),
        cmocka_unit_test(the_scene_is_what_was_found),
        cmocka_unit_test(the_panda_is_fitted),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
