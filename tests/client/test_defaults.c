/* Definitions have usable defaults, shapes take full sizes, and a URI that leads nowhere is explained. */
#include "cmocka_c.h"

#include <collided.h>
#include <string.h>

static void shapes_keep_half_of_what_people_measure(void **state)
{
    (void)state;
    collided_shape box = collided_box(0.2, 0.4, 0.6), capsule = collided_capsule(0.1, 1.0),
                   cone = collided_cone(0.3, 2.0);
    assert_true(box.half[0] == 0.1 && box.half[1] == 0.2 && box.half[2] == 0.3 && box.radius == 0.0);
    assert_true(capsule.half[2] == 0.5 && capsule.radius == 0.1);
    assert_true(cone.half[0] == 0.3 && cone.half[1] == 0.3 && cone.half[2] == 1.0);
    assert_true(collided_ellipsoid(1, 2, 3).half[2] == 3.0);
    assert_int_equal(collided_hull((collided_geometry){42}).geometry.hash, 42);
    collided_shape ground = collided_height_field((collided_geometry){43});
    assert_true(ground.type == COLLIDED_HEIGHT_FIELD && ground.geometry.hash == 43 && ground.half[2] == 0.0);
    assert_true(collided_sphere(0.5).pose.orientation[0] == 1.0);
}

static void defaults_are_those_of_the_manual(void **state)
{
    (void)state;
    collided_def def = collided_def_default();
    assert_true(def.lease_s == 2.0 && def.connect_timeout_s == 5.0 && def.on_loss == COLLIDED_REMOVE && !def.interface);
    collided_body_def body = collided_body_def_default();
    assert_int_equal(body.id, COLLIDED_NONE);
    assert_true(body.category == 1 && body.mask == UINT64_MAX && body.pose.orientation[0] == 1.0);
    collided_subscription_def subscription = collided_subscription_def_default();
    assert_true(subscription.facts == COLLIDED_TOUCH && subscription.relative_tolerance == 1e-6 &&
                subscription.tolerance_m == 0 && !strcmp(subscription.select_a, "*"));
}

static void unknown_schemes_are_answered_with_the_known_ones(void **state)
{
    (void)state;
    assert_null(collided_connect("tcp://localhost", NULL));
    assert_non_null(strstr(collided_connect_error(), "dds://"));
    assert_non_null(strstr(collided_connect_error(), "lcm://"));
    assert_null(collided_connect(NULL, NULL));
    assert_true(collided_connect_error()[0] != '\0');
}

static void bad_connection_arguments_are_explained(void **state)
{
    (void)state;
    const char *domains[] = {"dds://", "dds://231", "dds://-1", "dds://1x"};
    for (size_t i = 0; i < 4; i++) {
        assert_null(collided_connect(domains[i], NULL));
        assert_non_null(strstr(collided_connect_error(), "0 to 230"));
    }
    collided_def def = collided_def_default();
    def.lease_s = 0.0;
    assert_null(collided_connect("dds://0", &def));
    assert_non_null(strstr(collided_connect_error(), "lease_s"));
}

static void statuses_have_texts(void **state)
{
    (void)state;
    for (int s = COLLIDED_OK; s <= COLLIDED_UNSUPPORTED; s++)
        assert_true(strcmp(collided_status_text((collided_status)s), "unknown status") != 0);
    assert_string_equal(collided_status_text((collided_status)99), "unknown status");
    assert_true(collided_version()[0] != '\0');
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(shapes_keep_half_of_what_people_measure),
        cmocka_unit_test(defaults_are_those_of_the_manual),
        cmocka_unit_test(unknown_schemes_are_answered_with_the_known_ones),
        cmocka_unit_test(bad_connection_arguments_are_explained),
        cmocka_unit_test(statuses_have_texts),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
