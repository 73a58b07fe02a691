/* models: see models.h. */
#include "models.h"

#include "clients.h"
#include "commands.h"

#include "base/log.h"
#include "robot/tree.h"
#include "robot/turn.h"
#include "wire/wire_model.h"

#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

struct model {
    robot_tree *tree;
    pose base;
    int32_t bodies[ROBOT_LINKS_MAX]; /* of each link, the client's number; -1 = none */
    size_t body_count;               /* links that are bodies */
    uint32_t size;
    uint8_t bytes[]; /* the extensions of its Body */
};

static pose pose_from_seven(const double at[7])
{
    return (pose){vec(at[0], at[1], at[2]), quat_unit((quat){at[3], at[4], at[5], at[6]})};
}

static robot_joint joint_of(const wire_link *l)
{
    return (robot_joint){.parent = l->parent,
        .type = (robot_joint_type)l->type,
        .origin = {vec(l->origin[0], l->origin[1], l->origin[2]),
            {l->origin[3], l->origin[4], l->origin[5], l->origin[6]}},
        .axis = vec(l->axis[0], l->axis[1], l->axis[2]),
        .lower = l->lower,
        .upper = l->upper,
        .mimic = l->mimic,
        .factor = l->factor,
        .offset = l->offset};
}

wire_reason model_of(wire_u8s extensions, struct model **out, wire_refusal *why)
{
    wire_u8s record;
    wire_model m;
    *out = NULL;
    if (!wire_model_find(extensions, &record)) return WIRE_OK;
    if (wire_model_read(record, &m, why) != WIRE_OK) return why->reason;
    robot_joint joints[WIRE_JOINTS_MAX];
    for (int32_t i = 0; i < m.count; i++) joints[i] = joint_of(&m.links[i]);
    robot_status status;
    size_t where;
    robot_tree *tree = robot_tree_create(joints, (size_t)m.count, &status, &where);
    if (!tree) {
        why->reason = WIRE_BAD_SIZE;
        snprintf(why->text, sizeof why->text, "model: link %zu %s", where, robot_status_text(status));
        return why->reason;
    }
    struct model *made = base_zalloc(1, sizeof *made + extensions.count);
    *made = (struct model){.tree = tree, .base = pose_from_seven(m.base), .size = extensions.count};
    memcpy(made->bytes, extensions.at, extensions.count);
    for (int32_t i = 0; i < m.count; i++) {
        made->bodies[i] = m.links[i].body;
        made->body_count += m.links[i].body >= 0;
    }
    *out = made;
    return WIRE_OK;
}

void model_destroy(struct model *m)
{
    if (m) robot_tree_destroy(m->tree);
    free(m);
}

wire_u8s model_extensions(const struct model *m)
{
    return m ? (wire_u8s){m->size, m->bytes} : (wire_u8s){0, NULL};
}

void models_free(service *s)
{
    array_free(&s->expanded.bodies);
    array_free(&s->expanded.positions);
    array_free(&s->expanded.orientations);
    array_free(&s->expanded.linear);
    array_free(&s->expanded.angular);
    array_free(&s->expanded.teleports);
}

bool models_are_known(session *c, const wire_pose_batch *m)
{
    wire_u8s rest;
    wire_joints j;
    bool known = true;
    if (!wire_joints_find(m->extensions, &rest)) return true;
    while (known && wire_joints_next(&rest, &j)) {
        const owned_body *b = session_body(c, j.body);
        known = b && b->model;
    }
    return known;
}

/* ---- one robot ---- */

typedef struct robot_motion { /* of each link, world */
    pose at[ROBOT_LINKS_MAX];
    vec3 linear[ROBOT_LINKS_MAX], angular[ROBOT_LINKS_MAX];
} robot_motion;

static bool is_within(vec3 v, double most)
{
    return vec_max_abs(v) <= most; /* false for NaN */
}

/* False, and why: where a link is, or how fast, cannot be told in numbers that poses may have. */
static bool move_robot(const struct model *m, const wire_joints *j, robot_motion *out, wire_refusal *why)
{
    bool rates = j->flags & WIRE_JOINTS_GIVE_RATES, moves_base = rates && j->flags & WIRE_JOINTS_GIVE_BASE;
    pose base = j->flags & WIRE_JOINTS_GIVE_BASE ? pose_from_seven(j->base) : m->base;
    vec3 linear = moves_base ? vec(j->motion[0], j->motion[1], j->motion[2]) : VEC_ZERO,
         angular = moves_base ? vec(j->motion[3], j->motion[4], j->motion[5]) : VEC_ZERO;
    size_t bad = robot_tree_unusable(m->tree, j->values);
    if (bad != SIZE_MAX)
        return apply_refuse(why, WIRE_BAD_NUMBER, "joints of body %d: value %zu is %g: beyond what a joint can turn",
                   j->body, bad, j->values[bad]),
               false;
    robot_tree_forward(m->tree, j->values, out->at);
    if (rates) robot_tree_velocities(m->tree, j->rates, out->at, out->linear, out->angular);
    for (size_t i = 0; i < robot_tree_links(m->tree); i++) {
        if (rates) { /* from the base's frame; the base itself moves */
            vec3 arm = quat_rotate(base.q, out->at[i].p);
            out->linear[i] = vec_add(vec_add(linear, vec_cross(angular, arm)), quat_rotate(base.q, out->linear[i]));
            out->angular[i] = vec_add(angular, quat_rotate(base.q, out->angular[i]));
        }
        out->at[i] = pose_mul(base, out->at[i]);
        out->at[i].q = quat_settled(out->at[i].q);
        if (!is_within(out->at[i].p, WIRE_POSITION_MAX) ||
            (rates && !(is_within(out->linear[i], WIRE_SPEED_MAX) && is_within(out->angular[i], WIRE_SPIN_MAX))))
            return apply_refuse(why, WIRE_BAD_NUMBER, "joints of body %d: link %zu would be too far away, or too fast",
                       j->body, i),
                   false;
    }
    return true;
}

/* A robot may well stand beyond its limits, and where it stands is what counts: that is told, and nothing else. */
static void note_limits(service *s, const session *c, const struct model *m, const wire_joints *j)
{
    size_t beyond = robot_tree_beyond(m->tree, j->values);
    if (beyond == SIZE_MAX) return;
    double lower, upper;
    robot_tree_limits(m->tree, beyond, &lower, &upper);
    metric_count(s->count.joints_beyond, 1);
    if (s->monotonic_ns < s->joints_report_ns) return;
    s->joints_report_ns = s->monotonic_ns + INT64_C(1000000000);
    log_notice("client %016" PRIx64 ": of the robot of body %d value %zu is %g, beyond its limits, %g to %g",
        (uint64_t)c->client, j->body, beyond, j->values[beyond], lower, upper);
}

/* ---- batches ---- */

static const struct model *find_model(session *c, const wire_joints *j, wire_refusal *why)
{
    const owned_body *b = c ? session_body(c, j->body) : NULL;
    if (!b || !b->model) {
        apply_refuse(why, WIRE_UNKNOWN_BODY, "joints of body %d: it carries no robot", j->body);
        return NULL;
    }
    size_t wanted = robot_tree_coordinates(b->model->tree);
    if ((size_t)j->count == wanted) return b->model;
    apply_refuse(why, WIRE_MALFORMED, "joints of body %d: %d values: its robot has %zu joints that move", j->body,
        j->count, wanted);
    return NULL;
}

static void store_vec(double *to, vec3 v)
{
    to[0] = v.x, to[1] = v.y, to[2] = v.z;
}

static void reserve_poses(expanded_poses *e, size_t count)
{
    array_reserve(&e->bodies, count);
    array_reserve(&e->positions, 3 * count);
    array_reserve(&e->orientations, 4 * count);
    array_reserve(&e->linear, 3 * count);
    array_reserve(&e->angular, 3 * count);
    array_reserve(&e->teleports, count);
}

static void append_robot(expanded_poses *e, const struct model *m, const robot_motion *at, bool rates, bool teleport)
{
    reserve_poses(e, e->bodies.count + m->body_count);
    for (size_t i = 0; i < robot_tree_links(m->tree); i++) {
        if (m->bodies[i] < 0) continue;
        size_t k = e->bodies.count++;
        quat q = at->at[i].q;
        double *orientation = e->orientations.at + 4 * k;
        e->bodies.at[k] = m->bodies[i];
        store_vec(e->positions.at + 3 * k, at->at[i].p);
        orientation[0] = q.w, orientation[1] = q.x, orientation[2] = q.y, orientation[3] = q.z;
        if (rates) store_vec(e->linear.at + 3 * k, at->linear[i]);
        if (rates) store_vec(e->angular.at + 3 * k, at->angular[i]);
        e->teleports.at[k] = teleport;
        e->any_teleport |= teleport;
    }
}

/* Its own poses come first. */
static void begin_batch(expanded_poses *e, const wire_pose_batch *m)
{
    size_t n = m->bodies.count;
    reserve_poses(e, n);
    e->bodies.count = n;
    e->any_teleport = m->teleports.count > 0;
    if (!n) return;
    memcpy(e->bodies.at, m->bodies.at, n * sizeof *m->bodies.at);
    memcpy(e->positions.at, m->positions.at, 3 * n * sizeof(double));
    memcpy(e->orientations.at, m->orientations.at, 4 * n * sizeof(double));
    if (m->linear.count) memcpy(e->linear.at, m->linear.at, 3 * n * sizeof(double));
    if (m->angular.count) memcpy(e->angular.at, m->angular.at, 3 * n * sizeof(double));
    for (size_t i = 0; i < n; i++) e->teleports.at[i] = m->teleports.count ? m->teleports.at[i] : 0;
}

static bool append_joints(service *s, session *c, const wire_joints *j, bool rates, wire_refusal *why)
{
    const struct model *m = find_model(c, j, why);
    robot_motion at;
    if (!m) return false;
    if (!(j->flags & WIRE_JOINTS_GIVE_RATES) != !rates)
        return apply_refuse(why, WIRE_MALFORMED, "joints of body %d: all of a batch have velocities, or none", j->body),
               false;
    if (s->expanded.bodies.count + m->body_count > WIRE_POSES_MAX)
        return apply_refuse(why, WIRE_TOO_LARGE, "joints of body %d: more than %d poses", j->body, WIRE_POSES_MAX),
               false;
    if (!move_robot(m, j, &at, why)) return false;
    note_limits(s, c, m, j);
    append_robot(&s->expanded, m, &at, rates, j->flags & WIRE_JOINTS_TELEPORT);
    return true;
}

/* Its step lacks it: in lock-step it is owed, and its end is refused until it has come; of others the answer counts it.
 */
static void count_refused(service *s, session *c, int64_t step, const wire_joints *j, const wire_refusal *why)
{
    if (!c->lock_step) {
        poses_note_step(s, c, step);
        apply_count_refused(c, 1, why->reason);
    } else if (c->owed.count < (size_t)s->config.max_step_poses)
        array_push(&c->owed, ((owed_pose){step, j->body}));
}

void models_expand(service *s, session *c, struct link *from, const wire_pose_batch *m, wire_pose_batch *out)
{
    wire_u8s rest;
    wire_joints j;
    expanded_poses *e = &s->expanded;
    *out = *m;
    if (!wire_joints_find(m->extensions, &rest)) return;
    begin_batch(e, m);
    bool first = !m->bodies.count, rates = m->linear.count > 0;
    while (wire_joints_next(&rest, &j)) {
        wire_refusal why;
        if (first) rates = j.flags & WIRE_JOINTS_GIVE_RATES;
        first = false;
        if (append_joints(s, c, &j, rates, &why)) continue;
        apply_reject(s, from, WIRE_POSE_BATCH, m->client, m->sequence, j.body, &why);
        if (c && m->step) count_refused(s, c, m->step, &j, &why);
    }
    uint32_t n = (uint32_t)e->bodies.count;
    out->extensions = (wire_u8s){0, NULL};
    out->bodies = (wire_i32s){n, e->bodies.at};
    out->positions = (wire_f64s){3 * n, e->positions.at};
    out->orientations = (wire_f64s){4 * n, e->orientations.at};
    out->linear = rates ? (wire_f64s){3 * n, e->linear.at} : (wire_f64s){0, NULL};
    out->angular = rates ? (wire_f64s){3 * n, e->angular.at} : (wire_f64s){0, NULL};
    out->teleports = e->any_teleport ? (wire_u8s){n, e->teleports.at} : (wire_u8s){0, NULL};
}
