/* wire_model: see wire_model.h. Numbers lie as they do in memory: all processors that this runs on are little-endian.
 */
#include "wire_model.h"
#include "wire_rules.h"

#include <math.h>
#include <string.h>

static bool find_robot_record(wire_u8s extensions, uint32_t id, wire_u8s *record)
{
    wire_extension e;
    while (wire_extension_next(&extensions, &e))
        if (e.id == id) return *record = e.bytes, true;
    return false;
}

static uint8_t *append(uint8_t *at, const void *from, size_t size)
{
    if (size) memcpy(at, from, size);
    return at + size;
}

static const uint8_t *fetch(const uint8_t *at, void *to, size_t size)
{
    if (size) memcpy(to, at, size);
    return at + size;
}

static uint8_t *append_head(uint8_t *at, uint32_t id, uint32_t length)
{
    const uint32_t head[2] = {id, length};
    return append(at, head, sizeof head);
}

/* ---- models ---- */

uint32_t wire_model_write(const wire_model *m, uint8_t *out)
{
    uint32_t length = WIRE_MODEL_BASE_OCTETS + WIRE_LINK_OCTETS * (uint32_t)m->count;
    uint8_t *at = append(append_head(out, WIRE_EXTENSION_MODEL, length), m->base, sizeof m->base);
    for (int32_t i = 0; i < m->count; i++) {
        const wire_link *l = &m->links[i];
        const int32_t numbers[4] = {l->parent, l->type, l->mimic, l->body};
        const double rest[4] = {l->lower, l->upper, l->factor, l->offset};
        at = append(
            append(append(append(at, numbers, sizeof numbers), l->origin, sizeof l->origin), l->axis, sizeof l->axis),
            rest, sizeof rest);
    }
    return WIRE_EXTENSION_HEAD + length;
}

bool wire_model_find(wire_u8s extensions, wire_u8s *record)
{
    return find_robot_record(extensions, WIRE_EXTENSION_MODEL, record);
}

static void read_link(const uint8_t *at, wire_link *l)
{
    int32_t numbers[4];
    double rest[4];
    at = fetch(fetch(fetch(at, numbers, sizeof numbers), l->origin, sizeof l->origin), l->axis, sizeof l->axis);
    (void)fetch(at, rest, sizeof rest);
    l->parent = numbers[0], l->type = numbers[1], l->mimic = numbers[2], l->body = numbers[3];
    l->lower = rest[0], l->upper = rest[1], l->factor = rest[2], l->offset = rest[3];
}

static wire_reason check_link(const wire_model *m, int32_t i, wire_refusal *why)
{
    const wire_link *l = &m->links[i];
    if (l->body < -1) FAIL(WIRE_BAD_SIZE, "model: link %d: body %d: -1 or a body's number is allowed", i, l->body);
    for (int32_t k = 0; k < i && l->body >= 0; k++)
        if (m->links[k].body == l->body) FAIL(WIRE_BAD_SIZE, "model: links %d and %d are both body %d", k, i, l->body);
    return WIRE_OK;
}

wire_reason wire_model_read(wire_u8s record, wire_model *out, wire_refusal *why)
{
    uint32_t links = record.count < WIRE_MODEL_BASE_OCTETS ? 0 : record.count - WIRE_MODEL_BASE_OCTETS;
    if (record.count < WIRE_MODEL_BASE_OCTETS || links % WIRE_LINK_OCTETS)
        FAIL(WIRE_MALFORMED, "model: %u octets: %d, and %d a link, are allowed", record.count, WIRE_MODEL_BASE_OCTETS,
            WIRE_LINK_OCTETS);
    links /= WIRE_LINK_OCTETS;
    if (links < 1 || links > WIRE_JOINTS_MAX) FAIL(WIRE_BAD_SIZE, "model: %u links: 1 to %d", links, WIRE_JOINTS_MAX);
    out->count = (int32_t)links;
    const uint8_t *at = fetch(record.at, out->base, sizeof out->base);
    for (int32_t i = 0; i < out->count; i++) {
        read_link(at + (size_t)WIRE_LINK_OCTETS * (size_t)i, &out->links[i]);
        TRY(check_link(out, i, why));
    }
    return check_poses("model's base", (wire_f64s){7, out->base}, why);
}

/* ---- joints ---- */

/* How many numbers follow the head. */
static uint32_t numbers_of(int32_t count, int32_t flags)
{
    bool base = flags & WIRE_JOINTS_GIVE_BASE, rates = flags & WIRE_JOINTS_GIVE_RATES;
    return (base ? 7U : 0U) + (base && rates ? 6U : 0U) + (uint32_t)count * (rates ? 2U : 1U);
}

uint32_t wire_joints_size(const wire_joints *j)
{
    return WIRE_EXTENSION_HEAD + WIRE_JOINTS_HEAD + 8 * numbers_of(j->count, j->flags);
}

uint32_t wire_joints_write(const wire_joints *j, uint8_t *out)
{
    bool base = j->flags & WIRE_JOINTS_GIVE_BASE, rates = j->flags & WIRE_JOINTS_GIVE_RATES;
    const int32_t head[3] = {j->body, j->count, j->flags};
    uint32_t size = wire_joints_size(j);
    uint8_t *at = append_head(out, WIRE_EXTENSION_JOINTS, size - WIRE_EXTENSION_HEAD);
    at = append(at, head, sizeof head);
    if (base) at = append(at, j->base, sizeof j->base);
    if (base && rates) at = append(at, j->motion, sizeof j->motion);
    at = append(at, j->values, 8 * (size_t)j->count);
    if (rates) (void)append(at, j->rates, 8 * (size_t)j->count);
    return size;
}

bool wire_joints_find(wire_u8s extensions, wire_u8s *record)
{
    return find_robot_record(extensions, WIRE_EXTENSION_JOINTS, record);
}

bool wire_joints_next(wire_u8s *rest, wire_joints *out)
{
    int32_t head[3];
    if (rest->count < sizeof head) return false;
    const uint8_t *at = fetch(rest->at, head, sizeof head);
    out->body = head[0], out->count = head[1], out->flags = head[2];
    if (out->count < 0 || out->count > WIRE_JOINTS_MAX || out->flags & ~WIRE_JOINTS_FLAGS) return false;
    uint32_t size = WIRE_JOINTS_HEAD + 8 * numbers_of(out->count, out->flags);
    if (size > rest->count) return false;
    bool base = out->flags & WIRE_JOINTS_GIVE_BASE, rates = out->flags & WIRE_JOINTS_GIVE_RATES;
    if (base) at = fetch(at, out->base, sizeof out->base);
    if (base && rates) at = fetch(at, out->motion, sizeof out->motion);
    at = fetch(at, out->values, 8 * (size_t)out->count);
    if (rates) (void)fetch(at, out->rates, 8 * (size_t)out->count);
    *rest = (wire_u8s){rest->count - size, rest->at + size};
    return true;
}

uint32_t wire_joints_poses_most(wire_u8s extensions)
{
    wire_u8s rest;
    wire_joints j;
    uint32_t most = 0;
    if (!extensions.count || !wire_joints_find(extensions, &rest)) return 0;
    while (wire_joints_next(&rest, &j)) most += WIRE_JOINTS_MAX;
    return most;
}

static bool are_finite(const double *numbers, size_t count)
{
    for (size_t i = 0; i < count; i++)
        if (!isfinite(numbers[i])) return false;
    return true;
}

static wire_reason check_joints_of(const wire_joints *j, wire_refusal *why)
{
    bool base = j->flags & WIRE_JOINTS_GIVE_BASE, rates = j->flags & WIRE_JOINTS_GIVE_RATES;
    size_t count = (size_t)j->count;
    if (j->body < 0) FAIL(WIRE_BAD_SIZE, "joints: body %d: a body's number is allowed", j->body);
    if (!are_finite(j->values, count) || (rates && !are_finite(j->rates, count)) ||
        (base && rates && !are_finite(j->motion, 6)))
        FAIL(WIRE_BAD_NUMBER, "joints of body %d: a number is not finite", j->body);
    return base ? check_poses("joints' base", (wire_f64s){7, j->base}, why) : WIRE_OK;
}

wire_reason check_joints(const wire_pose_batch *m, wire_refusal *why)
{
    wire_u8s rest;
    wire_joints j;
    if (!wire_joints_find(m->extensions, &rest)) return WIRE_OK;
    if (m->bodies.count && !m->linear.count != !m->angular.count)
        FAIL(WIRE_MALFORMED, "joints: linear and angular are both there beside them, or neither");
    for (int robots = 0; wire_joints_next(&rest, &j); robots++) {
        TRY(check_joints_of(&j, why));
        if (robots == WIRE_ROBOTS_MAX) FAIL(WIRE_TOO_LARGE, "joints: more than the allowed %d robots", WIRE_ROBOTS_MAX);
        if (m->bodies.count && !(j.flags & WIRE_JOINTS_GIVE_RATES) != !m->linear.count)
            FAIL(WIRE_MALFORMED, "joints of body %d: all of a batch have velocities, or none", j.body);
    }
    if (rest.count) FAIL(WIRE_MALFORMED, "joints: %u octets are no robot's", rest.count);
    return WIRE_OK;
}

wire_reason check_model(const wire_body *m, wire_refusal *why)
{
    wire_u8s record;
    wire_model model;
    return wire_model_find(m->extensions, &record) ? wire_model_read(record, &model, why) : WIRE_OK;
}
