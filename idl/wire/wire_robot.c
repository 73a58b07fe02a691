/* wire_robot: see wire_robot.h. Numbers lie as they do in memory: all processors that this runs on are little-endian.
 */
#include "wire_robot.h"
#include "wire_rules.h"

#include <math.h>
#include <string.h>

enum { HEAD = 1 + 4 + 4 + 8 * (3 + 7), JOINT = 3 * 4 + 8 * (7 + 3 + 4) + 1 /* and the name */ };

typedef struct robot_reader {
    const uint8_t *at;
    size_t left;
    bool broken;
} robot_reader;

static void take(robot_reader *r, void *to, size_t size)
{
    if (size > r->left) {
        r->broken = true;
        memset(to, 0, size);
        return;
    }
    if (size) memcpy(to, r->at, size);
    r->at += size;
    r->left -= size;
}

static uint8_t *give(uint8_t *at, const void *from, size_t size)
{
    if (size) memcpy(at, from, size);
    return at + size;
}

static size_t moving_joints(const wire_joint *joints, int32_t count)
{
    size_t moving = 0;
    for (int32_t i = 0; i < count; i++) moving += joints[i].type != WIRE_JOINT_FIXED && joints[i].mimic < 0;
    return moving;
}

size_t wire_robot_numbers(const wire_robot_question *q, const wire_joint *joints)
{
    return moving_joints(joints, q->joint_count) * (q->flags & WIRE_CHECK_EDGES ? 2 : 1);
}

size_t wire_robot_size(const wire_robot_question *q, const wire_joint *joints)
{
    size_t size = HEAD + (size_t)q->joint_count * JOINT;
    for (int32_t i = 0; i < q->joint_count; i++) size += strlen(joints[i].body);
    return size + 8 * wire_robot_numbers(q, joints) * (size_t)q->item_count;
}

void wire_robot_write(const wire_robot_question *q, const wire_joint *joints, const double *numbers, uint8_t *at)
{
    at = give(at, &q->flags, 1);
    at = give(at, &q->joint_count, 4);
    at = give(at, &q->item_count, 4);
    at = give(at, &q->margin_m, 8);
    at = give(at, &q->resolution_m, 8);
    at = give(at, &q->tolerance_m, 8);
    at = give(at, q->base, sizeof q->base);
    for (int32_t i = 0; i < q->joint_count; i++) {
        const wire_joint *j = &joints[i];
        uint8_t length = (uint8_t)strlen(j->body);
        at = give(at, &j->parent, 4);
        at = give(at, &j->type, 4);
        at = give(at, &j->mimic, 4);
        at = give(at, j->origin, sizeof j->origin);
        at = give(at, j->axis, sizeof j->axis);
        at = give(at, &j->lower, 8);
        at = give(at, &j->upper, 8);
        at = give(at, &j->factor, 8);
        at = give(at, &j->offset, 8);
        at = give(at, &length, 1);
        at = give(at, j->body, length);
    }
    (void)give(at, numbers, 8 * wire_robot_numbers(q, joints) * (size_t)q->item_count);
}

static void read_joint(robot_reader *r, wire_joint *j)
{
    uint8_t length;
    take(r, &j->parent, 4);
    take(r, &j->type, 4);
    take(r, &j->mimic, 4);
    take(r, j->origin, sizeof j->origin);
    take(r, j->axis, sizeof j->axis);
    take(r, &j->lower, 8);
    take(r, &j->upper, 8);
    take(r, &j->factor, 8);
    take(r, &j->offset, 8);
    take(r, &length, 1);
    if (length > WIRE_NAME_MAX) r->broken = true, length = 0;
    take(r, j->body, length);
    j->body[length] = 0;
}

static bool all_finite(const double *numbers, size_t count)
{
    for (size_t i = 0; i < count; i++)
        if (!isfinite(numbers[i])) return false;
    return true;
}

static wire_reason check_head(const wire_robot_question *q, wire_refusal *why)
{
    if (q->flags & ~WIRE_CHECK_FLAGS) FAIL(WIRE_UNSUPPORTED, "check: flags is %u: 0 to %d", q->flags, WIRE_CHECK_FLAGS);
    if (q->joint_count < 1 || q->joint_count > WIRE_JOINTS_MAX)
        FAIL(WIRE_BAD_SIZE, "check: %d joints: 1 to %d", q->joint_count, WIRE_JOINTS_MAX);
    if (q->item_count < 1 || q->item_count > WIRE_CHECK_ITEMS_MAX)
        FAIL(WIRE_BAD_SIZE, "check: %d items: 1 to %d", q->item_count, WIRE_CHECK_ITEMS_MAX);
    if (!(q->margin_m >= 0 && q->margin_m <= 1e6)) FAIL(WIRE_BAD_SIZE, "check: margin_m is %g: 0 to 1e6", q->margin_m);
    if (!(q->resolution_m >= 1e-9 && q->resolution_m <= 1e6))
        FAIL(WIRE_BAD_SIZE, "check: resolution_m is %g: 1e-9 to 1e6", q->resolution_m);
    if (!(q->tolerance_m >= 0 && q->tolerance_m <= 1e6))
        FAIL(WIRE_BAD_SIZE, "check: tolerance_m is %g: 0 to 1e6", q->tolerance_m);
    if (!all_finite(q->base, 7)) FAIL(WIRE_BAD_NUMBER, "check: the base's pose is not finite");
    double norm2 =
        q->base[3] * q->base[3] + q->base[4] * q->base[4] + q->base[5] * q->base[5] + q->base[6] * q->base[6];
    if (!(fabs(norm2 - 1) <= 2e-6))
        FAIL(WIRE_BAD_ROTATION, "check: the base's orientation has the squared length %g", norm2);
    return WIRE_OK;
}

wire_reason wire_robot_read(
    wire_u8s record, wire_robot_question *q, wire_joint *joints, double *numbers, wire_refusal *why)
{
    robot_reader r = {record.at, record.count, false};
    memset(q, 0, sizeof *q);
    take(&r, &q->flags, 1);
    take(&r, &q->joint_count, 4);
    take(&r, &q->item_count, 4);
    take(&r, &q->margin_m, 8);
    take(&r, &q->resolution_m, 8);
    take(&r, &q->tolerance_m, 8);
    take(&r, q->base, sizeof q->base);
    TRY(check_head(q, why));
    for (int32_t i = 0; i < q->joint_count && !r.broken; i++) read_joint(&r, &joints[i]);
    if (r.broken) FAIL(WIRE_MALFORMED, "check: the record ends within its joints");
    size_t each = wire_robot_numbers(q, joints), count = each * (size_t)q->item_count;
    if (count > WIRE_CHECK_NUMBERS_MAX)
        FAIL(WIRE_TOO_LARGE, "check: %zu numbers: at most %d", count, WIRE_CHECK_NUMBERS_MAX);
    if (r.left != 8 * count)
        FAIL(WIRE_MALFORMED, "check: %zu octets of numbers: %zu for %zu of them", r.left, 8 * count, count);
    take(&r, numbers, 8 * count);
    if (!all_finite(numbers, count)) FAIL(WIRE_BAD_NUMBER, "check: a coordinate is not finite");
    return WIRE_OK;
}

void wire_checked_write(const wire_checked *items, size_t count, uint8_t *at)
{
    for (size_t i = 0; i < count; i++) {
        at = give(at, &items[i].verdict, 1);
        at = give(at, &items[i].first_lo, 8);
        at = give(at, &items[i].first_hi, 8);
        at = give(at, &items[i].lo, 8);
        at = give(at, &items[i].hi, 8);
        at = give(at, &items[i].name_a, 4);
        at = give(at, &items[i].name_b, 4);
    }
}

bool wire_checked_read(wire_u8s record, wire_checked *items, size_t *count)
{
    *count = record.count / WIRE_CHECKED_EACH;
    if (record.count % WIRE_CHECKED_EACH != 0 || *count > WIRE_CHECK_ITEMS_MAX) return false;
    robot_reader r = {record.at, record.count, false};
    for (size_t i = 0; i < *count; i++) {
        take(&r, &items[i].verdict, 1);
        take(&r, &items[i].first_lo, 8);
        take(&r, &items[i].first_hi, 8);
        take(&r, &items[i].lo, 8);
        take(&r, &items[i].hi, 8);
        take(&r, &items[i].name_a, 4);
        take(&r, &items[i].name_b, 4);
    }
    return true;
}
