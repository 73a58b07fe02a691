/* The C half of the Python package: batches are copied whole, names once each, refusals up to a number. */
#include "native.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

/* Its callbacks, as the library would call them: the test stands in for what native.c hands them to. */
#include "../../client/python/native.c"

static native_inbox inbox;

static void a_batch_is_copied_whole(void **state)
{
    (void)state;
    enum { EVENTS = 300 };
    static collided_event events[EVENTS];
    static char names[EVENTS + 1][32];
    const collided_contact_point points[3] = {{.distance = 1}, {.distance = 2}, {.distance = 3}};
    const collided_impact impact = {
        .lo_s = 1, .hi_s = INFINITY, .start_ns = 5, .pose_b.orientation = {0, 0, 0, 1}, .estimated = true};
    for (int i = 0; i <= EVENTS; i++) (void)snprintf(names[i], sizeof names[i], "body%d", i / 2);
    for (int i = 0; i < EVENTS; i++)
        events[i] = (collided_event){.kind = COLLIDED_BEGIN,
            .cause = "a cause of more than 15",
            .contact = i,
            .name_a = names[i],
            .name_b = names[i + 1],
            .lo = i,
            .axis = {0, 0, i},
            .points = points,
            .point_count = (size_t)i % 4,
            .impact = i % 5 == 0 ? &impact : NULL};
    on_batch(&inbox, &(collided_batch){.batch = 7, .refusal = "old_pose", .events = events, .event_count = EVENTS});
    on_batch(&inbox, &(collided_batch){.batch = 8, .heartbeat = true});
    memset(events, 0xff, sizeof events);
    memset(names, 'x', sizeof names - 1);
    native_batch *b = native_take(&inbox);
    assert_true(b->head.batch == 7 && b->event_count == EVENTS && b->impact_count == EVENTS / 5);
    assert_string_equal(b->refusal, "old_pose");
    const char *by_number[EVENTS];
    int32_t count = 0;
    for (const char *at = b->names; at < b->names + b->names_size; at += strlen(at) + 1) by_number[count++] = at;
    assert_int_equal(count, EVENTS / 2 + 1);
    for (int i = 0; i < EVENTS; i++) {
        const native_event *e = &b->events[i];
        char name[32];
        (void)snprintf(name, sizeof name, "body%d", i / 2);
        assert_string_equal(by_number[e->a], name);
        (void)snprintf(name, sizeof name, "body%d", (i + 1) / 2);
        assert_string_equal(by_number[e->b], name);
        assert_true(e->contact == i && e->lo == i && e->axis[2] == i && e->points == i % 4);
        assert_string_equal(e->cause, "a cause of more");
        for (int k = 0; k < e->points; k++) assert_true(b->points[e->first_point + k].distance == k + 1);
        assert_true((e->impact >= 0) == (i % 5 == 0));
        if (e->impact >= 0) assert_true(b->impacts[e->impact].wxyz_b[3] == 1 && b->impacts[e->impact].estimated);
    }
    native_free(b);
    b = native_take(&inbox);
    assert_true(b->head.heartbeat && !b->event_count && !b->names_size);
    native_free(b);
    assert_null(native_take(&inbox));
    on_batch(&inbox, &(collided_batch){.batch = 9});
    b = native_take(&inbox);
    assert_int_equal(b->head.batch, 9);
    native_free(b);
}

static void refusals_are_kept_in_order_up_to_a_number(void **state)
{
    (void)state;
    native_rejection r;
    for (int round = 0; round < 3; round++) {
        for (int i = 0; i < REJECTIONS_MAX + 10; i++)
            on_rejected(&inbox, &(collided_rejection){.message = "Body", .object = i, .reason = "limit"});
        for (int i = 0; i < REJECTIONS_MAX; i++) {
            assert_true(native_take_rejection(&inbox, &r));
            assert_int_equal(r.object, i);
            assert_string_equal(r.text, "");
        }
        assert_false(native_take_rejection(&inbox, &r));
        assert_int_equal(native_dropped(&inbox), 10);
        assert_int_equal(native_dropped(&inbox), 0);
    }
}

static void quaternions_are_turned_round(void **state)
{
    (void)state;
    const double xyzw[] = {1, 2, 3, 4, 5, 6, 7, 8}, wxyz[] = {4, 1, 2, 3, 8, 5, 6, 7};
    double out[8];
    native_wxyz(out, xyzw, 2);
    assert_memory_equal(out, wxyz, sizeof wxyz);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_batch_is_copied_whole),
        cmocka_unit_test(refusals_are_kept_in_order_up_to_a_number),
        cmocka_unit_test(quaternions_are_turned_round),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
