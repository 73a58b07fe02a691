/* robots: bodies that move by the joints of a model that one of them carries. The model stands in the extensions of
 * that body's announcement; what the joints were last is kept, and goes out again when the daemon has come to know all
 * of the bodies. The caller's thread, except what is called with the lock held. */
#include "allocate.h"
#include "announce.h"
#include "message.h"
#include "session.h"
#include "wire/wire_model.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

typedef struct robot_record {
    int32_t carrier;
    wire_model model;
    struct robot_record *next;
} robot_record;

static int32_t body_named(const collided *c, const char *name)
{
    for (size_t i = 0; name && *name && i < c->bodies.capacity; i++) {
        const body_record *b = c->bodies.slots[i].value;
        if (b && !b->removed && b->announced.message && strcmp(b->announced.message->body.name, name) == 0)
            return b->id;
    }
    return -1;
}

/* With the lock held. */
static collided_status model_from(collided *c, const collided_robot *r, wire_model *out)
{
    if (r->joint_count < 1 || r->joint_count > WIRE_JOINTS_MAX)
        return session_fail(
            c, COLLIDED_BAD_ARGUMENT, "a robot has 1 to %d joints, and this one %zu", WIRE_JOINTS_MAX, r->joint_count);
    out->count = (int32_t)r->joint_count;
    memcpy(out->base, r->base.position, sizeof r->base.position);
    memcpy(out->base + 3, r->base.orientation, sizeof r->base.orientation);
    for (size_t i = 0; i < r->joint_count; i++) {
        const collided_joint *from = &r->joints[i];
        wire_link *to = &out->links[i];
        *to = (wire_link){.parent = from->parent,
            .type = (int32_t)from->type,
            .mimic = from->mimics ? from->mimic : -1,
            .body = body_named(c, from->body),
            .lower = from->lower,
            .upper = from->upper,
            .factor = from->factor,
            .offset = from->offset};
        memcpy(to->origin, from->origin.position, sizeof from->origin.position);
        memcpy(to->origin + 3, from->origin.orientation, sizeof from->origin.orientation);
        memcpy(to->axis, from->axis, sizeof to->axis);
        if (to->body < 0 && from->body && *from->body)
            return session_fail(c, COLLIDED_UNKNOWN_ID, "joint %zu: '%s' is no body of this client", i, from->body);
    }
    return COLLIDED_OK;
}

/* What the daemon would refuse as no tree, as far as the arithmetic here rests on it. */
static collided_status check_tree(collided *c, const wire_model *m)
{
    for (int32_t i = 0; i < m->count; i++) {
        const wire_link *l = &m->links[i];
        bool mimics = l->type != WIRE_JOINT_FIXED && l->mimic >= 0;
        if (l->parent < -1 || l->parent >= i)
            return session_fail(
                c, COLLIDED_BAD_ARGUMENT, "joint %d: its parent is %d, no joint before it", i, l->parent);
        if (l->type < WIRE_JOINT_FIXED || l->type > WIRE_JOINT_PRISMATIC)
            return session_fail(c, COLLIDED_BAD_ARGUMENT, "joint %d: there is no type %d", i, l->type);
        if (l->mimic >= m->count ||
            (mimics && (m->links[l->mimic].type == WIRE_JOINT_FIXED || m->links[l->mimic].mimic >= 0)))
            return session_fail(
                c, COLLIDED_BAD_ARGUMENT, "joint %d: it mimics %d, which does not move by itself", i, l->mimic);
    }
    return COLLIDED_OK;
}

static robot_record *find_robot(const collided *c, int32_t carrier)
{
    robot_record *r = c->robots;
    while (r && r->carrier != carrier) r = r->next;
    return r;
}

void robot_forget(collided *c, int32_t carrier)
{
    for (robot_record **at = &c->robots; *at; at = &(*at)->next) {
        robot_record *r = *at;
        if (r->carrier != carrier) continue;
        *at = r->next;
        free(r);
        return;
    }
}

void robots_free(collided *c)
{
    while (c->robots) robot_forget(c, c->robots->carrier);
}

/* With the lock held. */
static collided_status announce_robot(collided *c, body_record *carrier, const wire_model *model)
{
    enum { ROOM = WIRE_EXTENSION_HEAD + WIRE_MODEL_BASE_OCTETS + WIRE_LINK_OCTETS * WIRE_JOINTS_MAX };
    uint8_t *record = allocate(1, ROOM);
    wire_refusal why = {WIRE_OK, ""};
    body_refresh(carrier);
    wire_message m = *carrier->announced.message;
    m.body.extensions = (wire_u8s){wire_model_write(model, record), record};
    wire_message *copy = wire_check(&m, &why) == WIRE_OK ? message_copy(&m) : NULL;
    free(record);
    if (!copy) return session_fail(c, COLLIDED_BAD_ARGUMENT, "%s", why.text);
    announce(c, &carrier->announced, copy);
    return COLLIDED_OK;
}

collided_status collided_set_robot(collided *c, collided_body carrier, const collided_robot *robot)
{
    wire_model *model = allocate(1, sizeof *model);
    pthread_mutex_lock(&c->lock);
    body_record *body = table_get(&c->bodies, carrier.id);
    bool usable = body && !body->removed && body->announced.message;
    collided_status status =
        usable ? model_from(c, robot, model)
               : session_fail(c, COLLIDED_UNKNOWN_ID, "there is no body %d that this process created", carrier.id);
    if (status == COLLIDED_OK) status = check_tree(c, model);
    if (status == COLLIDED_OK) status = announce_robot(c, body, model);
    if (status == COLLIDED_OK) {
        robot_record *r = allocate(1, sizeof *r);
        robot_forget(c, carrier.id);
        *r = (robot_record){.carrier = carrier.id, .model = *model, .next = c->robots};
        c->robots = r;
    }
    pthread_mutex_unlock(&c->lock);
    free(model);
    return status;
}

/* ---- joints ---- */

static size_t coordinates_of(const wire_model *m)
{
    size_t moving = 0;
    for (int32_t i = 0; i < m->count; i++) moving += m->links[i].type != WIRE_JOINT_FIXED && m->links[i].mimic < 0;
    return moving;
}

static collided_pose pose_at(const double numbers[7])
{
    collided_pose p;
    memcpy(p.position, numbers, sizeof p.position);
    memcpy(p.orientation, numbers + 3, sizeof p.orientation);
    return p;
}

/* From the joint's frame at value 0. */
static collided_pose joint_motion(const wire_link *l, double value)
{
    collided_pose p = {{0, 0, 0}, {1, 0, 0, 0}};
    double length = sqrt(l->axis[0] * l->axis[0] + l->axis[1] * l->axis[1] + l->axis[2] * l->axis[2]);
    bool slides = l->type == WIRE_JOINT_PRISMATIC;
    p.orientation[0] = slides ? 1 : cos(value / 2);
    for (int k = 0; k < 3; k++)
        *(slides ? &p.position[k] : &p.orientation[k + 1]) = l->axis[k] / length * (slides ? value : sin(value / 2));
    return p;
}

/* Where the daemon will put the links, but for rounding: out[link], world. `coordinate`: of each joint that moves by
 * itself, which value it has. */
static void link_poses(const wire_model *m, const wire_joints *j, collided_pose *out)
{
    int32_t coordinate[WIRE_JOINTS_MAX], next = 0;
    for (int32_t i = 0; i < m->count; i++)
        coordinate[i] = m->links[i].type != WIRE_JOINT_FIXED && m->links[i].mimic < 0 ? next++ : -1;
    const collided_pose base = pose_at(j->flags & WIRE_JOINTS_GIVE_BASE ? j->base : m->base);
    for (int32_t i = 0; i < m->count; i++) {
        const wire_link *l = &m->links[i];
        collided_pose here = pose_at(l->origin);
        int32_t of = l->mimic >= 0 ? coordinate[l->mimic] : coordinate[i];
        if (l->type != WIRE_JOINT_FIXED) {
            double value = l->mimic >= 0 ? j->values[of] * l->factor + l->offset : j->values[of];
            here = collided_pose_product(here, joint_motion(l, value));
        }
        out[i] = collided_pose_product(l->parent < 0 ? base : out[l->parent], here);
    }
}

typedef struct joints_room {
    wire_joints joints;
    collided_body bodies[WIRE_JOINTS_MAX];
    double positions[3 * WIRE_JOINTS_MAX], orientations[4 * WIRE_JOINTS_MAX];
    uint8_t record[sizeof(wire_joints)];
} joints_room;

static size_t fill_poses(const wire_model *m, joints_room *room)
{
    collided_pose at[WIRE_JOINTS_MAX];
    size_t count = 0;
    link_poses(m, &room->joints, at);
    for (int32_t i = 0; i < m->count; i++) {
        if (m->links[i].body < 0) continue;
        room->bodies[count] = (collided_body){m->links[i].body};
        memcpy(room->positions + 3 * count, at[i].position, sizeof at[i].position);
        memcpy(room->orientations + 4 * count++, at[i].orientation, sizeof at[i].orientation);
    }
    return count;
}

static void fill_joints(wire_joints *j, const collided_joint_state *state, size_t count)
{
    if (count) memcpy(j->values, state->positions, count * sizeof *j->values);
    if (state->velocities) {
        j->flags |= WIRE_JOINTS_GIVE_RATES;
        if (count) memcpy(j->rates, state->velocities, count * sizeof *j->rates);
    }
    if (state->base) {
        j->flags |= WIRE_JOINTS_GIVE_BASE;
        memcpy(j->base, state->base->position, sizeof state->base->position);
        memcpy(j->base + 3, state->base->orientation, sizeof state->base->orientation);
        if (state->base_linear) memcpy(j->motion, state->base_linear, 3 * sizeof *j->motion);
        if (state->base_angular) memcpy(j->motion + 3, state->base_angular, 3 * sizeof *j->motion);
    }
    if (state->teleport) j->flags |= WIRE_JOINTS_TELEPORT;
}

/* The octets are what wire_check is asked of: the poses that follow from them are checked as poses are. */
static collided_status write_joints(collided *c, joints_room *room, uint32_t *size)
{
    wire_refusal why;
    *size = wire_joints_write(&room->joints, room->record);
    const wire_message m = {.kind = WIRE_POSE_BATCH,
        .pose_batch = {.version = WIRE_VERSION, .client = c->id, .sequence = 1, .extensions = {*size, room->record}}};
    if (wire_check(&m, &why) == WIRE_OK) return COLLIDED_OK;
    return session_fail(c, COLLIDED_BAD_ARGUMENT, "%s", why.text);
}

collided_status collided_publish_joints(
    collided *c, collided_body carrier, const collided_joint_state *state, size_t count, int64_t stamp_ns, int64_t step)
{
    pthread_mutex_lock(&c->lock); /* the keeper looks at no robot, and this thread alone changes them */
    const robot_record *r = find_robot(c, carrier.id);
    pthread_mutex_unlock(&c->lock);
    if (!r) return session_fail(c, COLLIDED_UNKNOWN_ID, "body %d carries no robot: collided_set_robot", carrier.id);
    size_t wanted = coordinates_of(&r->model);
    if (count != wanted || (count && !state->positions))
        return session_fail(c, COLLIDED_BAD_ARGUMENT, "%zu values: the robot has %zu joints that move", count, wanted);
    uint32_t size;
    joints_room *room = allocate(1, sizeof *room);
    room->joints = (wire_joints){.body = carrier.id, .count = (int32_t)count};
    fill_joints(&room->joints, state, count);
    collided_status status = write_joints(c, room, &size);
    if (status == COLLIDED_OK) {
        const jointed_poses j = {fill_poses(&r->model, room), room->bodies, room->positions, room->orientations,
            state->teleport, carrier.id, room->record, size};
        status = poses_publish_joints(c, &j, stamp_ns, step);
    }
    free(room);
    return status;
}

/* ---- what a robot carries ---- */

static int32_t link_of_body(const wire_model *m, int32_t body)
{
    int32_t i = 0;
    while (i < m->count && m->links[i].body != body) i++;
    return i < m->count ? i : -1;
}

/* With the lock held. */
static collided_status change_robot(collided *c, robot_record *r, const wire_model *model)
{
    body_record *carrier = table_get(&c->bodies, r->carrier);
    collided_status status = announce_robot(c, carrier, model);
    if (status == COLLIDED_OK) r->model = *model;
    return status;
}

static collided_status attach(
    collided *c, robot_record *r, int32_t part, int32_t link, const collided_pose *in_link, wire_model *model)
{
    const body_record *b = table_get(&c->bodies, part);
    *model = r->model;
    int32_t parent = link_of_body(model, link);
    if (!b || b->removed) return session_fail(c, COLLIDED_UNKNOWN_ID, "there is no body %d", part);
    if (parent < 0) return session_fail(c, COLLIDED_UNKNOWN_ID, "body %d is no link of that robot", link);
    if (link_of_body(model, part) >= 0)
        return session_fail(c, COLLIDED_BAD_ARGUMENT, "body %d is a link of that robot already", part);
    if (model->count == WIRE_JOINTS_MAX)
        return session_fail(c, COLLIDED_BAD_ARGUMENT, "the robot has %d links already", WIRE_JOINTS_MAX);
    wire_link *l = &model->links[model->count++];
    *l = (wire_link){.parent = parent, .type = WIRE_JOINT_FIXED, .mimic = -1, .body = part, .axis = {0, 0, 1}};
    memcpy(l->origin, in_link->position, sizeof in_link->position);
    memcpy(l->origin + 3, in_link->orientation, sizeof in_link->orientation);
    return change_robot(c, r, model);
}

/* It must be at the end of the list, or behind it only what was attached later. */
static collided_status detach(collided *c, robot_record *r, int32_t part, wire_model *model)
{
    *model = r->model;
    int32_t i = link_of_body(model, part);
    if (i < 0 || model->links[i].type != WIRE_JOINT_FIXED)
        return session_fail(c, COLLIDED_UNKNOWN_ID, "body %d is not attached to that robot", part);
    for (int32_t k = i + 1; k < model->count; k++) {
        wire_link *l = &model->links[k];
        if (l->parent == i)
            return session_fail(c, COLLIDED_BAD_ARGUMENT, "link %d of that robot hangs at body %d", k, part);
        l->parent -= l->parent > i;
        l->mimic -= l->mimic > i;
    }
    for (int32_t k = 0; k < i; k++) model->links[k].mimic -= model->links[k].mimic > i;
    model->count--;
    memmove(model->links + i, model->links + i + 1, (size_t)(model->count - i) * sizeof *model->links);
    return change_robot(c, r, model);
}

static collided_status attach_or_detach(
    collided *c, int32_t carrier, int32_t part, int32_t link, const collided_pose *in_link)
{
    wire_model *model = allocate(1, sizeof *model);
    pthread_mutex_lock(&c->lock);
    robot_record *r = find_robot(c, carrier);
    collided_status status = !r        ? session_fail(c, COLLIDED_UNKNOWN_ID, "body %d carries no robot", carrier)
                             : in_link ? attach(c, r, part, link, in_link, model)
                                       : detach(c, r, part, model);
    pthread_mutex_unlock(&c->lock);
    free(model);
    return status;
}

collided_status collided_attach(
    collided *c, collided_body carrier, collided_body part, collided_body link, const collided_pose *in_link)
{
    return attach_or_detach(c, carrier.id, part.id, link.id, in_link);
}

collided_status collided_detach(collided *c, collided_body carrier, collided_body part)
{
    return attach_or_detach(c, carrier.id, part.id, -1, NULL);
}
