/* Compounds: how they are announced, what of them is refused before anything is sent, and what verify says of them. */
#include "cmocka_c.h"
#include "fake.h"

#include <math.h>
#include <string.h>

static collided_shape placed(collided_shape s, double x, double y, double z)
{
    s.pose.position[0] = x, s.pose.position[1] = y, s.pose.position[2] = z;
    return s;
}

static collided_body_def def_of(const collided_shape *shapes, size_t count)
{
    collided_body_def def = collided_body_def_default();
    def.name = "part";
    def.shapes = shapes;
    def.shape_count = count;
    return def;
}

static void children_follow_their_compound(void **state)
{
    (void)state;
    fake_begin((fake_options){.epoch = 1});
    collided *c = fake_connect();
    collided_shape children[2] = {placed(collided_sphere(0.1), 1, 2, 3), collided_hull((collided_geometry){77})};
    collided_shape shapes[3] = {collided_box(2, 4, 6), collided_compound(children, 2), collided_capsule(0.1, 0.4)};
    shapes[1].radius = 0.01;
    shapes[1].deviation = 0.002;
    children[1].deviation = 0.001;
    shapes[1].pose.position[0] = 5;
    collided_body_def def = def_of(shapes, 3);
    assert_int_not_equal(collided_create_body(c, &def).id, COLLIDED_NONE);
    memset(children, 0, sizeof children); /* they were copied */
    const wire_body *m = &fake_message(WIRE_BODY, 0)->body;
    static const uint8_t TYPES[] = {
        WIRE_SHAPE_BOX, WIRE_SHAPE_COMPOUND, WIRE_SHAPE_SPHERE, WIRE_SHAPE_HULL, WIRE_SHAPE_CAPSULE};
    assert_int_equal(m->shape_types.count, 5);
    assert_memory_equal(m->shape_types.at, TYPES, sizeof TYPES);
    assert_true(m->shape_sizes.at[3] == 2 && m->shape_sizes.at[4] == 0 && m->shape_sizes.at[14] == 0.2);
    assert_true(m->shape_radii.at[1] == 0.01 && m->shape_radii.at[2] == 0.1);
    assert_true(m->shape_deviations.at[1] == 0.002 && m->shape_deviations.at[3] == 0.001);
    assert_true(m->shape_poses.at[7] == 5 && m->shape_poses.at[14] == 1 && m->shape_poses.at[16] == 3);
    assert_true(m->shape_geometries.at[1] == 0 && m->shape_geometries.at[3] == 77);
    collided_close(c);
}

static void is_refused(collided *c, const collided_shape *shapes, size_t count, const char *words)
{
    collided_body_def def = def_of(shapes, count);
    assert_int_equal(collided_create_body(c, &def).id, COLLIDED_NONE);
    if (!strstr(collided_error(c), words)) fail_msg("%s, not %s", collided_error(c), words);
}

static void what_is_no_compound_is_refused_before_it_is_sent(void **state)
{
    (void)state;
    static collided_shape many[256];
    fake_begin((fake_options){.epoch = 1});
    collided *c = fake_connect();
    for (int i = 0; i < 256; i++) many[i] = collided_sphere(1);
    collided_shape child = collided_sphere(1), empty = collided_compound(&child, 0), none = collided_compound(NULL, 1);
    is_refused(c, &empty, 1, "children");
    is_refused(c, &none, 1, "children");
    collided_shape over = collided_compound(many, 256), two[2] = {collided_compound(many, 255), collided_sphere(1)};
    is_refused(c, &over, 1, "children");
    is_refused(c, two, 2, "shapes");
    child = collided_halfspace();
    collided_shape whole = collided_compound(&child, 1);
    is_refused(c, &whole, 1, "a half-space cannot be the child");
    child = collided_mesh((collided_geometry){5});
    is_refused(c, &whole, 1, "a mesh cannot be the child");
    child = collided_height_field((collided_geometry){5});
    is_refused(c, &whole, 1, "a height field cannot be the child");
    child = collided_compound(many, 1);
    is_refused(c, &whole, 1, "children's type");
    child = collided_sphere(1);
    child.type = (collided_shape_type)(COLLIDED_SOFT + 1);
    is_refused(c, &whole, 1, "children's type");
    collided_shape unknown = child;
    is_refused(c, &unknown, 1, "shapes' type");
    assert_int_equal(fake_sent(WIRE_BODY), 0);
    collided_body_def most = def_of(two, 1);
    assert_int_not_equal(collided_create_body(c, &most).id, COLLIDED_NONE);
    assert_int_equal(fake_message(WIRE_BODY, 0)->body.shape_types.count, 256);
    collided_close(c);
}

/* ---- verify ---- */

/* Two pillars on x = -1 and x = +1, each 0.5 thick, and a ball of radius 0.2. */
typedef struct hollow {
    collided_shape pillars[2], whole, ball;
    collided_pose at, ball_at;
} hollow;

static hollow make_hollow(double x, double y)
{
    hollow h = {.ball = collided_sphere(0.2), .at = collided_pose_identity(), .ball_at = collided_pose_identity()};
    h.pillars[0] = placed(collided_box(0.5, 0.5, 2), -1, 0, 0);
    h.pillars[1] = placed(collided_box(0.5, 0.5, 2), 1, 0, 0);
    h.ball_at.position[0] = x;
    h.ball_at.position[1] = y;
    return h;
}

static collided_status verify(hollow *h, const collided_certificate *claim)
{
    h->whole = collided_compound(h->pillars, 2);
    return collided_verify(&h->ball, &h->ball_at, NULL, 0, &h->whole, &h->at, NULL, 0, claim);
}

static void what_the_hulls_prove_is_proven(void **state)
{
    (void)state;
    hollow h = make_hollow(1, -1);
    collided_certificate claim = {
        .lo = 0.55, .hi = 0.55, .axis = {0, 1, 0}, .point_a = {1, -0.8, 0}, .point_b = {1, -0.25, 0}};
    assert_int_equal(verify(&h, &claim), COLLIDED_OK);
    claim.hi = 0.54, claim.lo = 0.5;
    assert_int_equal(verify(&h, &claim), COLLIDED_REJECTED);
    claim.hi = claim.lo = 0.55, claim.point_b[0] = 0.5; /* between the pillars */
    assert_int_equal(verify(&h, &claim), COLLIDED_REJECTED);
}

/* In the hollow no axis proves anything; a lower bound that the points contradict is refused all the same. */
static void in_a_hollow_only_the_upper_bound_is_proven(void **state)
{
    (void)state;
    hollow h = make_hollow(0.2, 0);
    collided_certificate claim = {
        .lo = 0.35, .hi = 0.35, .axis = {1, 0, 0}, .point_a = {0.4, 0, 0}, .point_b = {0.75, 0, 0}};
    assert_int_equal(verify(&h, &claim), COLLIDED_UNSUPPORTED);
    claim.lo = 0.36, claim.hi = 0.37;
    assert_int_equal(verify(&h, &claim), COLLIDED_REJECTED);
    claim.lo = -INFINITY, claim.hi = 0.35;
    assert_int_equal(verify(&h, &claim), COLLIDED_OK);
    claim.point_b[0] = 0.7;
    assert_int_equal(verify(&h, &claim), COLLIDED_REJECTED);
}

static void rounding_and_turned_children_count(void **state)
{
    (void)state;
    hollow h = make_hollow(0, 0);
    h.pillars[1].pose.orientation[0] = h.pillars[1].pose.orientation[2] = sqrt(0.5); /* about y: it lies along x */
    h.pillars[1].pose.position[0] = 2;
    h.whole = collided_compound(h.pillars, 2);
    h.whole.radius = 0.1;
    h.ball_at.position[0] = 4;
    collided_certificate claim = {
        .lo = 0.7 - 1e-12, .hi = 0.7 + 1e-12, .axis = {-1, 0, 0}, .point_a = {3.8, 0, 0}, .point_b = {3.1, 0, 0}};
    assert_int_equal(collided_verify(&h.ball, &h.ball_at, NULL, 0, &h.whole, &h.at, NULL, 0, &claim), COLLIDED_OK);
    claim.lo = 0.71, claim.hi = 0.72;
    assert_int_equal(
        collided_verify(&h.ball, &h.ball_at, NULL, 0, &h.whole, &h.at, NULL, 0, &claim), COLLIDED_REJECTED);
}

/* The compound's own and that of the child which has the point count; of two children that have it, the lesser. */
static void deviations_of_children_count(void **state)
{
    (void)state;
    hollow h = make_hollow(1, -1);
    h.pillars[0].deviation = 0.5;
    h.pillars[1].deviation = 0.1;
    collided_certificate claim = {
        .lo = 0.55, .hi = 0.66, .axis = {0, 1, 0}, .point_a = {1, -0.8, 0}, .point_b = {1, -0.25, 0}};
    assert_int_equal(verify(&h, &claim), COLLIDED_OK);
    claim.hi = 0.64;
    assert_int_equal(verify(&h, &claim), COLLIDED_REJECTED);
    h.whole = collided_compound(h.pillars, 2);
    h.whole.deviation = 0.2;
    claim.hi = 0.84;
    assert_int_equal(
        collided_verify(&h.ball, &h.ball_at, NULL, 0, &h.whole, &h.at, NULL, 0, &claim), COLLIDED_REJECTED);
    claim.hi = 0.86;
    assert_int_equal(collided_verify(&h.ball, &h.ball_at, NULL, 0, &h.whole, &h.at, NULL, 0, &claim), COLLIDED_OK);
    h.pillars[0].pose.position[0] = 1;
    claim.hi = 0.66;
    assert_int_equal(verify(&h, &claim), COLLIDED_OK);
    h.pillars[1].deviation = 0.5;
    assert_int_equal(verify(&h, &claim), COLLIDED_REJECTED);
}

static void children_that_verify_cannot_place_are_told(void **state)
{
    (void)state;
    hollow h = make_hollow(4, 0);
    collided_certificate claim = {.lo = 0, .hi = 10, .axis = {-1, 0, 0}};
    h.pillars[1] = collided_hull((collided_geometry){5});
    assert_int_equal(verify(&h, &claim), COLLIDED_BAD_ARGUMENT);
    h.pillars[1] = collided_halfspace();
    assert_int_equal(verify(&h, &claim), COLLIDED_BAD_ARGUMENT);
    h.pillars[1] = collided_box(1, -1, 1);
    assert_int_equal(verify(&h, &claim), COLLIDED_BAD_ARGUMENT);
    collided_shape empty = collided_compound(NULL, 0);
    assert_int_equal(
        collided_verify(&h.ball, &h.ball_at, NULL, 0, &empty, &h.at, NULL, 0, &claim), COLLIDED_BAD_ARGUMENT);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(children_follow_their_compound),
        cmocka_unit_test(what_is_no_compound_is_refused_before_it_is_sent),
        cmocka_unit_test(what_the_hulls_prove_is_proven),
        cmocka_unit_test(in_a_hollow_only_the_upper_bound_is_proven),
        cmocka_unit_test(rounding_and_turned_children_count),
        cmocka_unit_test(deviations_of_children_count),
        cmocka_unit_test(children_that_verify_cannot_place_are_told),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
