/* Checks of configurations and motions through the whole service: an arm of two links beside a post, by anybody's
 * question; rules count, what is stale is undecided, nothing moves, and what is malformed is answered by name. */
#include "cell.h"

#include "wire/wire_extensions.h"
#include "wire/wire_robot.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <time.h>

enum { ARM = 5, PLANNER = 6, UPPER = 0, FORE = 1, POST = 2 };

typedef struct checks {
    cell *cell;
    memory_end *arm, *planner;
    wire_memory *memory;
    int64_t sequence;
    wire_robot_question head;
    wire_joint joints[2];
    wire_message answer;
    wire_checked items[WIRE_CHECK_ITEMS_MAX];
    size_t count;
} checks;

/* A capsule of half length 0.4 and radius 0.05 along x, from the joint on; or an upright post. */
static void send_body(checks *t, int32_t body, const char *name, bool post, const char *ignores)
{
    const double size[3] = {0, 0, post ? 1 : 0.4}, radius = 0.05, zero = 0;
    const double along_x[7] = {0.5, 0, 0, M_SQRT1_2, 0, M_SQRT1_2, 0}, upright[7] = {0, 0, 0, 1, 0, 0, 0};
    const double place[7] = {body == FORE, 0, 0, 1, 0, 0, 0}, there[7] = {1.2, 0.9, 0, 1, 0, 0, 0};
    const uint8_t type = WIRE_SHAPE_CAPSULE, allow = WIRE_RULE_ALLOW;
    const int64_t none = 0;
    const char *reason = "test";
    wire_message m = {.kind = WIRE_BODY,
        .body = {.version = WIRE_VERSION,
            .client = ARM,
            .sequence = ++t->sequence,
            .body = body,
            .name = name,
            .group = "",
            .category = 1,
            .mask = 1,
            .motion = post ? WIRE_MOTION_FIXED : WIRE_MOTION_MOVING,
            .pose = {7, post ? there : place},
            .shape_types = {1, &type},
            .shape_sizes = {3, size},
            .shape_radii = {1, &radius},
            .shape_deviations = {1, &zero},
            .shape_poses = {7, post ? upright : along_x},
            .shape_geometries = {1, &none}}};
    if (ignores) {
        m.body.rule_patterns = (wire_strings){1, &ignores};
        m.body.rule_actions = (wire_u8s){1, &allow};
        m.body.rule_reasons = (wire_strings){1, &reason};
        m.body.rule_paddings = (wire_f64s){1, &zero};
        m.body.rule_margins = (wire_f64s){1, &zero};
    }
    memory_send(t->arm, &m);
}

static void begin(checks *t)
{
    *t = (checks){0};
    config c = cell_config();
    t->cell = cell_start(&c);
    t->arm = cell_client(t->cell);
    t->planner = cell_client(t->cell);
    t->memory = wire_memory_create();
    cell_hello(t->arm, ARM, ++t->sequence, 1000, WIRE_LOST_REMOVE);
    cell_hello(t->planner, PLANNER, ++t->sequence, 1000, WIRE_LOST_REMOVE);
    send_body(t, UPPER, "upper", false, "fore");
    send_body(t, FORE, "fore", false, NULL);
    send_body(t, POST, "post", true, NULL);
    cell_settle(t->arm, t->memory, ARM, ++t->sequence);
    t->head =
        (wire_robot_question){.joint_count = 2, .item_count = 1, .resolution_m = 1e-4, .base = {0, 0, 0, 1, 0, 0, 0}};
    for (int i = 0; i < 2; i++) {
        t->joints[i] = (wire_joint){.parent = i - 1,
            .type = WIRE_JOINT_REVOLUTE,
            .mimic = -1,
            .origin = {i, 0, 0, 1, 0, 0, 0},
            .axis = {0, 0, 1},
            .lower = -3,
            .upper = 3};
        snprintf(t->joints[i].body, sizeof t->joints[i].body, "%s", i ? "fore" : "upper");
    }
}

static void end(checks *t)
{
    memory_disconnect(t->arm);
    memory_disconnect(t->planner);
    wire_memory_destroy(t->memory);
    assert_int_equal(cell_stop(t->cell), 0);
}

static uint8_t ask_raw(checks *t, const uint8_t *record, size_t size)
{
    wire_message q = {.kind = WIRE_QUERY,
        .query = {.version = WIRE_VERSION,
            .client = PLANNER,
            .sequence = ++t->sequence,
            .kind = WIRE_QUERY_CHECK,
            .name_a = "",
            .name_b = "",
            .extensions = {(uint32_t)size, record}}};
    memory_send(t->planner, &q);
    do {
        t->answer = cell_await(t->planner, t->memory, WIRE_ANSWER); /* those to others come here, too */
    } while (t->answer.answer.client != PLANNER || t->answer.answer.sequence != t->sequence);
    wire_u8s rest = t->answer.answer.extensions;
    wire_extension e;
    t->count = 0;
    while (wire_extension_next(&rest, &e))
        if (e.id == WIRE_EXTENSION_CHECKED) assert_true(wire_checked_read(e.bytes, t->items, &t->count));
    return t->answer.answer.status;
}

static uint8_t ask(checks *t, const double *numbers)
{
    size_t size = wire_robot_size(&t->head, t->joints);
    const uint32_t head[2] = {WIRE_EXTENSION_CHECK, (uint32_t)size};
    uint8_t *record = malloc(sizeof head + size);
    memcpy(record, head, sizeof head);
    wire_robot_write(&t->head, t->joints, numbers, record + sizeof head);
    uint8_t status = ask_raw(t, record, sizeof head + size);
    free(record);
    return status;
}

static const char *name_at(const checks *t, int32_t place)
{
    return place < 0 ? "" : t->answer.answer.names_a.at[place];
}

static void test_answers(void **state)
{
    (void)state;
    checks t;
    begin(&t);
    const double numbers[] = {0, 0, /* */ 0, M_PI_2, /* meets the post, at (1.2, 0.9) */ 0, 1.35};
    t.head.item_count = 3;
    t.head.flags = WIRE_CHECK_MEASURE;
    t.head.tolerance_m = 1e-9;
    assert_int_equal(ask(&t, numbers), WIRE_ANSWER_OK);
    assert_int_equal(t.count, 3);
    assert_int_equal(t.items[0].verdict, WIRE_CHECK_FREE);
    assert_int_equal(t.items[1].verdict, WIRE_CHECK_FREE);
    assert_int_equal(t.items[2].verdict, WIRE_CHECK_MEETS);
    assert_true(t.items[1].lo <= 0.1 + 1e-9 && 0.1 <= t.items[1].hi + 1e-9);
    assert_string_equal(name_at(&t, t.items[2].name_a), "fore");
    assert_string_equal(name_at(&t, t.items[2].name_b), "post");

    const double edge[] = {0, 0, 0, 1.35}; /* from free to touching */
    t.head.item_count = 1;
    t.head.flags = WIRE_CHECK_EDGES | WIRE_CHECK_FIRST;
    assert_int_equal(ask(&t, edge), WIRE_ANSWER_OK);
    assert_int_equal(t.items[0].verdict, WIRE_CHECK_MEETS);
    assert_true(
        t.items[0].first_lo > 0.9 && t.items[0].first_hi < 1 && t.items[0].first_hi - t.items[0].first_lo < 1e-3);
    t.head.margin_m = 0.05;
    double nearer = t.items[0].first_lo;
    assert_int_equal(ask(&t, edge), WIRE_ANSWER_OK);
    assert_true(t.items[0].first_hi < nearer);
    t.head.margin_m = 0;

    const double folded[] = {
        0, 3, 0, -3}; /* the fore link turns through the upper one: a rule allows it; and the post */
    assert_int_equal(ask(&t, folded), WIRE_ANSWER_OK);
    assert_string_equal(name_at(&t, t.items[0].name_b), "post");
    send_body(&t, UPPER, "upper", false, NULL); /* without the rule */
    cell_settle(t.arm, t.memory, ARM, ++t.sequence);
    t.head.flags = 0;
    t.head.item_count = 1;
    const double fold[] = {-1, 2.9};
    assert_int_equal(ask(&t, fold), WIRE_ANSWER_OK);
    assert_int_equal(t.items[0].verdict, WIRE_CHECK_MEETS);
    assert_string_equal(name_at(&t, t.items[0].name_a), "upper");
    assert_string_equal(name_at(&t, t.items[0].name_b), "fore");
    end(&t);
}

static void test_held_is_undecided(void **state)
{
    (void)state;
    checks t;
    begin(&t);
    const double away[] = {-2, 0};
    assert_int_equal(ask(&t, away), WIRE_ANSWER_OK);
    assert_int_equal(t.items[0].verdict, WIRE_CHECK_FREE);
    memory_end *other = cell_client(t.cell);
    cell_hello(other, 7, 1, 0.2, WIRE_LOST_HOLD); /* lost soon: its body stays, and may be anywhere */
    cell_sphere(other, 7, 2, 0, "wanderer", 50);
    cell_settle(other, t.memory, 7, 3);
    uint8_t verdict = WIRE_CHECK_FREE;
    for (int i = 0; i < 3000 && verdict == WIRE_CHECK_FREE; i++) {
        assert_int_equal(ask(&t, away), WIRE_ANSWER_OK);
        verdict = t.items[0].verdict;
        if (verdict == WIRE_CHECK_FREE) nanosleep(&(struct timespec){0, 10000000}, NULL);
    }
    memory_disconnect(other);
    assert_int_equal(verdict, WIRE_CHECK_UNDECIDED);
    assert_non_null(strstr(t.answer.answer.text, "wanderer"));
    end(&t);
}

static void refused(checks *t, const double *numbers, const char *why)
{
    assert_int_equal(ask(t, numbers), WIRE_ANSWER_UNSUPPORTED);
    if (!strstr(t->answer.answer.text, why)) fail_msg("%s: not \"%s\"", t->answer.answer.text, why);
    assert_int_equal(t->count, 0);
}

#define REFUSED(change, why)                                                                                           \
    do {                                                                                                               \
        checks was = t;                                                                                                \
        change;                                                                                                        \
        refused(&t, numbers, why);                                                                                     \
        t.head = was.head;                                                                                             \
        memcpy(t.joints, was.joints, sizeof t.joints);                                                                 \
    } while (0)

static void test_refused(void **state)
{
    (void)state;
    checks t;
    begin(&t);
    double numbers[4] = {0, 0, 0, 0};
    REFUSED(t.head.joint_count = 0, "joints");
    REFUSED(t.head.item_count = 0, "items");
    REFUSED(t.head.flags = 8, "flags");
    REFUSED(t.head.margin_m = NAN, "margin_m");
    REFUSED(t.head.resolution_m = 0, "resolution_m");
    REFUSED(t.head.base[3] = 0, "orientation");
    REFUSED(t.head.base[0] = INFINITY, "base");
    REFUSED(t.joints[1].parent = 1, "joint 1 has a parent");
    REFUSED(t.joints[1].type = 9, "joint 1 has a type");
    REFUSED(t.joints[1].axis[2] = 0, "joint 1 has an axis");
    REFUSED(t.joints[0].upper = -4, "joint 0 has limits");
    REFUSED(strcpy(t.joints[1].body, "nobody"), "no body is named \"nobody\"");
    REFUSED(strcpy(t.joints[1].body, "upper"), "the body of both");
    numbers[1] = 3.5;
    REFUSED((void)0, "joint 1 is 3.5, and its limits are -3 and 3");
    numbers[1] = NAN;
    REFUSED((void)0, "not finite");
    assert_int_equal(ask_raw(&t, NULL, 0), WIRE_ANSWER_UNSUPPORTED);
    /* Records that end anywhere. */
    numbers[1] = 0;
    size_t size = wire_robot_size(&t.head, t.joints);
    uint8_t *record = malloc(8 + size);
    for (size_t left = 0; left < size; left += left < 60 ? 1 : 7) {
        const uint32_t head[2] = {WIRE_EXTENSION_CHECK, (uint32_t)left};
        memcpy(record, head, sizeof head);
        uint8_t *whole = malloc(size);
        wire_robot_write(&t.head, t.joints, numbers, whole);
        memcpy(record + 8, whole, left);
        free(whole);
        assert_int_equal(ask_raw(&t, record, 8 + left), WIRE_ANSWER_UNSUPPORTED);
    }
    free(record);
    assert_int_equal(ask(&t, numbers), WIRE_ANSWER_OK);
    end(&t);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_answers), cmocka_unit_test(test_held_is_undecided), cmocka_unit_test(test_refused)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
