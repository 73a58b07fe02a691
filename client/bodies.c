/* bodies: creating, changing, adopting and removing them. What the wire's own check would refuse is refused here,
 * before anything is sent. The caller's thread, except what the keeper calls under the lock. */
#include "allocate.h"
#include "announce.h"
#include "message.h"
#include "session.h"

#include <stdlib.h>
#include <string.h>

static const char *text(const char *s)
{
    return s ? s : "";
}

static void put_pose(double out[7], const collided_pose *pose)
{
    memcpy(out, pose->position, sizeof pose->position);
    memcpy(out + 3, pose->orientation, sizeof pose->orientation);
}

/* A definition as the wire's arrays. The message borrows from it. */
typedef struct body_arrays {
    double pose[7];
    double *sizes, *radii, *deviations, *poses, *paddings, *margins; /* one block, at sizes */
    int64_t *geometries;
    uint8_t *types, *actions;
    const char **patterns, **reasons;
} body_arrays;

/* Shapes as the wire counts them: a compound, and each of its children behind it. */
static size_t flat_count(const collided_body_def *def)
{
    size_t count = def->shape_count;
    for (size_t i = 0; i < def->shape_count; i++)
        if (def->shapes[i].type == COLLIDED_COMPOUND) count += def->shapes[i].child_count;
    return count;
}

static void put_shape(body_arrays *a, size_t i, const collided_shape *s)
{
    memcpy(a->sizes + 3 * i, s->half, sizeof s->half);
    if (s->type == COLLIDED_COMPOUND) a->sizes[3 * i] = (double)s->child_count;
    a->radii[i] = s->radius;
    a->deviations[i] = s->deviation;
    put_pose(a->poses + 7 * i, &s->pose);
    a->geometries[i] = s->geometry.hash;
    a->types[i] = (uint8_t)s->type;
}

static body_arrays make_arrays(const collided_body_def *def)
{
    size_t n = flat_count(def), r = def->rule_count, at = 0;
    body_arrays a = {.sizes = allocate(12 * n + 2 * r, sizeof *a.sizes),
        .geometries = allocate(n, sizeof *a.geometries),
        .types = allocate(n, 1),
        .actions = allocate(r, 1),
        .patterns = allocate(r, sizeof *a.patterns),
        .reasons = allocate(r, sizeof *a.reasons)};
    a.radii = a.sizes + 3 * n;
    a.deviations = a.radii + n;
    a.poses = a.deviations + n;
    a.paddings = a.poses + 7 * n;
    a.margins = a.paddings + r;
    put_pose(a.pose, &def->pose);
    for (size_t i = 0; i < def->shape_count; i++) {
        const collided_shape *s = &def->shapes[i];
        put_shape(&a, at++, s);
        for (size_t k = 0; s->type == COLLIDED_COMPOUND && k < s->child_count; k++)
            put_shape(&a, at++, &s->children[k]);
    }
    for (size_t i = 0; i < r; i++) {
        a.actions[i] = def->rules[i].allow ? WIRE_RULE_ALLOW : WIRE_RULE_CHECK;
        a.patterns[i] = text(def->rules[i].pattern);
        a.reasons[i] = text(def->rules[i].reason);
        a.paddings[i] = def->rules[i].padding_m;
        a.margins[i] = def->rules[i].margin_m;
    }
    return a;
}

static void free_arrays(body_arrays *a)
{
    free(a->sizes);
    free(a->geometries);
    free(a->types);
    free(a->actions);
    free(a->patterns);
    free(a->reasons);
}

static wire_message body_message(const collided *c, int32_t id, const collided_body_def *def, const body_arrays *a)
{
    uint32_t n = (uint32_t)flat_count(def), r = (uint32_t)def->rule_count;
    return (wire_message){.kind = WIRE_BODY,
        .body = {.version = WIRE_VERSION,
            .client = c->id,
            .sequence = c->sequence + 1,
            .body = id,
            .motion = (uint8_t)def->motion,
            .name = text(def->name),
            .group = text(def->group),
            .category = (int64_t)def->category,
            .mask = (int64_t)def->mask,
            .ccd = (uint8_t)def->ccd,
            .acceleration_m_s2 = def->acceleration_m_s2,
            .angular_acceleration_rad_s2 = def->angular_acceleration_rad_s2,
            .one_way = def->one_way,
            .deadline_ns = session_seconds(def->deadline_s),
            .stamp_ns = def->stamp_ns ? def->stamp_ns : session_now_ns(),
            .stamp_is_now = !def->stamp_ns,
            .pose = {7, a->pose},
            .shape_types = {n, a->types},
            .shape_sizes = {3 * n, a->sizes},
            .shape_radii = {n, a->radii},
            .shape_deviations = {n, a->deviations},
            .shape_poses = {7 * n, a->poses},
            .shape_geometries = {n, a->geometries},
            .rule_patterns = {r, a->patterns},
            .rule_actions = {r, a->actions},
            .rule_reasons = {r, a->reasons},
            .rule_paddings = {r, a->paddings},
            .rule_margins = {r, a->margins}}};
}

/* A number that does not fit the wire's field would arrive as another one: these are told apart here. */
static bool is_type(collided_shape_type type)
{
    return (unsigned)type <= COLLIDED_SOFT;
}

/* What would not arrive as it is. What cannot be a child otherwise, wire_check says. */
static const char *unfit_children(const collided_shape *s)
{
    if (s->type != COLLIDED_COMPOUND) return NULL;
    if (s->child_count == 0 || s->child_count >= WIRE_SHAPES_MAX || !s->children) return "children";
    for (size_t i = 0; i < s->child_count; i++)
        if (!is_type(s->children[i].type) || s->children[i].type >= COLLIDED_COMPOUND) return "children's type";
    return NULL;
}

static const char *unfit_shapes(const collided_body_def *def)
{
    const char *field = NULL;
    for (size_t i = 0; i < def->shape_count && !field; i++)
        field = is_type(def->shapes[i].type) ? unfit_children(&def->shapes[i]) : "shapes' type";
    return !field && flat_count(def) > WIRE_SHAPES_MAX ? "shapes" : field;
}

static const char *unfit(const collided_body_def *def)
{
    if (def->shape_count > WIRE_SHAPES_MAX || (def->shape_count && !def->shapes)) return "shapes";
    if (def->rule_count > WIRE_RULES_MAX || (def->rule_count && !def->rules)) return "rules";
    if ((unsigned)def->motion > COLLIDED_FIXED) return "motion";
    if ((unsigned)def->ccd > COLLIDED_CCD_FULL) return "ccd";
    if (!(def->deadline_s >= 0.0) || def->deadline_s > 1e9) return "deadline_s";
    return unfit_shapes(def);
}

/* The message to announce, or NULL with the error kept. With the lock held. */
static wire_message *checked_body(collided *c, int32_t id, const collided_body_def *def)
{
    const char *field = unfit(def);
    if (field) {
        (void)session_fail(c, COLLIDED_BAD_ARGUMENT, "body '%s': bad %s", text(def->name), field);
        return NULL;
    }
    body_arrays arrays = make_arrays(def);
    wire_message m = body_message(c, id, def, &arrays);
    wire_refusal why;
    wire_message *copy = wire_check(&m, &why) == WIRE_OK ? message_copy(&m) : NULL;
    free_arrays(&arrays);
    if (!copy) (void)session_fail(c, COLLIDED_BAD_ARGUMENT, "body '%s': %s", text(def->name), why.text);
    return copy;
}

static body_record *alive(const collided *c, int32_t id)
{
    body_record *body = table_get(&c->bodies, id);
    return body && !body->removed ? body : NULL;
}

/* ---- memory: records lie side by side, because poses of all of them are published at once ---- */

static void add_block(collided *c)
{
    enum { RECORDS = 256 };
    body_record *block = allocate_aligned(_Alignof(body_record), RECORDS, sizeof *block);
    c->body_blocks = reserve(c->body_blocks, &c->body_block_capacity, c->body_block_count + 1, sizeof *c->body_blocks);
    c->body_blocks[c->body_block_count++] = block;
    for (size_t i = RECORDS; i-- > 0;) body_free(c, &block[i]);
}

static body_record *new_record(collided *c)
{
    if (!c->spare_bodies) add_block(c);
    body_record *body = c->spare_bodies;
    c->spare_bodies = (body_record *)body->announced.next;
    memset(body, 0, sizeof *body);
    return body;
}

void body_free(collided *c, body_record *body)
{
    body->announced.next = (announcement *)c->spare_bodies;
    c->spare_bodies = body;
}

void bodies_free(collided *c)
{
    for (size_t i = 0; i < c->body_block_count; i++) free(c->body_blocks[i]);
    free(c->body_blocks);
}

static body_record *add_body_record(collided *c, int32_t id)
{
    body_record *body = table_get(&c->bodies, id); /* its removal is still under way: the same id starts anew */
    if (!body) body = new_record(c);
    body->id = id;
    body->removed = false;
    body->stamp_ns = 0;
    table_put(&c->bodies, id, body);
    if (id >= c->next_body) c->next_body = id < INT32_MAX ? id + 1 : INT32_MAX;
    return body;
}

collided_body collided_create_body(collided *c, const collided_body_def *def)
{
    collided_body made = {COLLIDED_NONE};
    pthread_mutex_lock(&c->lock);
    int32_t id = def->id == COLLIDED_NONE ? c->next_body : def->id;
    if (id < 0 || id == INT32_MAX || alive(c, id)) {
        (void)session_fail(
            c, COLLIDED_BAD_ARGUMENT, "body '%s': id %d is taken or not a valid one", text(def->name), id);
    } else {
        wire_message *m = checked_body(c, id, def);
        if (m) announce(c, &add_body_record(c, id)->announced, m);
        if (m) made.id = id;
    }
    pthread_mutex_unlock(&c->lock);
    return made;
}

collided_status collided_change_body(collided *c, collided_body body, const collided_body_def *def)
{
    collided_status status = COLLIDED_OK;
    pthread_mutex_lock(&c->lock);
    body_record *record = alive(c, body.id);
    wire_message *m = record ? checked_body(c, body.id, def) : NULL;
    if (m) {
        const wire_message *old = record->announced.message;
        if (!old || strcmp(old->body.name, m->body.name) != 0) announce_leaves_name(c, &record->announced);
        record->stamp_ns = 0; /* its pose is the definition's */
        robot_forget(c, body.id);
        announce(c, &record->announced, m);
    } else if (record)
        status = COLLIDED_BAD_ARGUMENT;
    else
        status = session_fail(c, COLLIDED_UNKNOWN_ID, "there is no body %d", body.id);
    pthread_mutex_unlock(&c->lock);
    return status;
}

static void remove_record(collided *c, body_record *record)
{
    const wire_message m = {.kind = WIRE_BODY,
        .body = {.version = WIRE_VERSION, .client = c->id, .body = record->id, .removed = 1, .name = "", .group = ""}};
    record->removed = true;
    robot_forget(c, record->id);
    announce_leaves_name(c, &record->announced);
    announce(c, &record->announced, message_copy(&m));
}

collided_status collided_remove_body(collided *c, collided_body body)
{
    pthread_mutex_lock(&c->lock);
    body_record *record = alive(c, body.id);
    if (record) remove_record(c, record);
    pthread_mutex_unlock(&c->lock);
    return record ? COLLIDED_OK : session_fail(c, COLLIDED_UNKNOWN_ID, "there is no body %d", body.id);
}

/* In the order of their creation; adopted ones last. A removal moves nothing in the record that is walked here. */
void bodies_remove_all(collided *c)
{
    for (announcement *a = c->first; a; a = a->next)
        if (a->message->kind == WIRE_BODY && !((body_record *)a)->removed) remove_record(c, (body_record *)a);
    for (size_t i = 0; i < c->bodies.capacity; i++) {
        body_record *record = c->bodies.slots[i].value;
        if (record && !record->removed) remove_record(c, record);
    }
}

collided_body collided_adopt_body(collided *c, int32_t id)
{
    collided_body body = {COLLIDED_NONE};
    pthread_mutex_lock(&c->lock);
    if (id < 0 || id == INT32_MAX || table_get(&c->bodies, id)) {
        (void)session_fail(c, COLLIDED_BAD_ARGUMENT, "id %d is taken or not a valid one", id);
    } else {
        add_body_record(c, id)->announced.state = ANNOUNCE_ACKED;
        body.id = id;
    }
    pthread_mutex_unlock(&c->lock);
    return body;
}

bool body_has_newer_pose(const body_record *body)
{
    const wire_body *m = &body->announced.message->body;
    return body->stamp_ns && (m->stamp_is_now || body->stamp_ns >= m->stamp_ns);
}

void body_refresh(body_record *body)
{
    wire_body *m = &body->announced.message->body;
    if (!body_has_newer_pose(body)) return;
    memcpy((double *)m->pose.at, body->pose, sizeof body->pose); /* in the announcement's own block */
    m->stamp_ns = body->stamp_ns;
    m->stamp_is_now = 0;
}
