/* load_robot: collided_load.h's robots: a handle over loaders/robot.h that owns all it hands out. Threads are those
 * that collided_load.h promises: the error is of the thread, nothing else is shared. */
#include "load.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static _Thread_local char error_text[1024];

void load_forget_error(void)
{
    error_text[0] = '\0';
}

collided_status load_refuse(collided_status status, const char *text)
{
    snprintf(error_text, sizeof error_text, "%s", text);
    return status;
}

const char *collided_load_error(void)
{
    return error_text;
}

collided_load_def collided_load_def_default(void)
{
    return (collided_load_def){.meshes = "hull"};
}

load_report load_report_to(const collided_load_def *def)
{
    return (load_report){
        .warn = def ? def->warn : NULL, .note = def ? def->note : NULL, .context = def ? def->context : NULL};
}

/* ---- reading ---- */

static bool take_def(collided_loaded_robot *r, const char *path, const collided_load_def *def, robot_source *out)
{
    load_package *packages = pool_alloc(r->memory, def->package_count, sizeof *packages);
    for (size_t i = 0; i < def->package_count; i++) {
        if (!def->packages[i].name || !def->packages[i].path)
            return load_fail(&r->report, "packages: entry %zu has no name or no path", i);
        packages[i] =
            (load_package){pool_copy(r->memory, def->packages[i].name), pool_copy(r->memory, def->packages[i].path)};
    }
    *out = (robot_source){.urdf = pool_copy(r->memory, path),
        .prefix = pool_copy(r->memory, def->prefix),
        .packages = packages,
        .package_count = def->package_count};
    if (def->meshes && !load_meshes_parse(def->meshes, &out->meshes))
        return load_fail(&r->report, "meshes '%s': must be hull, solid, decompose or decompose:N", def->meshes);
    return true;
}

collided_loaded_robot *collided_load_urdf(const char *path, const collided_load_def *def)
{
    const collided_load_def defaults = collided_load_def_default();
    if (!def) def = &defaults;
    load_forget_error();
    collided_loaded_robot *r = calloc(1, sizeof *r);
    if (!r || !path) {
        (void)load_refuse(COLLIDED_BAD_ARGUMENT, r ? "collided_load_urdf: no path" : "out of memory");
        free(r);
        return NULL;
    }
    robot_source source;
    r->memory = &r->pool;
    r->report = load_report_to(def);
    if (take_def(r, path, def, &source) && robot_load(&r->robot, r->memory, &source, &r->report)) {
        load_describe_robot(r);
        return r;
    }
    (void)load_refuse(COLLIDED_BAD_ARGUMENT, r->report.error);
    collided_loaded_robot_free(r);
    return NULL;
}

collided_status collided_load_srdf(collided_loaded_robot *robot, const char *path)
{
    load_forget_error();
    if (!robot || !path) return load_refuse(COLLIDED_BAD_ARGUMENT, "collided_load_srdf: no robot, or no path");
    if (robot->read)
        return load_refuse(
            COLLIDED_BAD_ARGUMENT, "an SRDF is read before the robot's bodies are created, not afterwards");
    srdf before = robot->robot.semantics;
    robot->report.error[0] = '\0';
    if (!robot_load_srdf(&robot->robot, path, &robot->report)) {
        robot->robot.semantics = before;
        return load_refuse(COLLIDED_BAD_ARGUMENT, robot->report.error);
    }
    load_describe_robot(robot);
    return COLLIDED_OK;
}

void collided_loaded_robot_free(collided_loaded_robot *robot)
{
    if (!robot || robot->memory != &robot->pool) return;
    pool_free(&robot->pool);
    free(robot);
}

/* ---- what a robot has ---- */

static const collided_joint_type joint_types[] = {[URDF_FIXED] = COLLIDED_JOINT_FIXED,
    [URDF_REVOLUTE] = COLLIDED_JOINT_REVOLUTE,
    [URDF_CONTINUOUS] = COLLIDED_JOINT_CONTINUOUS,
    [URDF_PRISMATIC] = COLLIDED_JOINT_PRISMATIC};

static void describe_joints(collided_loaded_robot *r)
{
    const urdf *u = &r->robot.model;
    r->joints = pool_alloc(r->memory, (size_t)u->joint_count, sizeof *r->joints);
    for (int i = 0; i < u->joint_count; i++) {
        const urdf_joint *j = &u->joints[i];
        r->joints[i] = (collided_loaded_joint){.name = j->name,
            .type = joint_types[j->type],
            .parent = j->parent,
            .child = j->child,
            .limited = j->limited,
            .lower = j->lower,
            .upper = j->upper,
            .mimics = j->mimic,
            .factor = j->mimic_factor,
            .offset = j->mimic_offset};
    }
}

void load_describe_robot(collided_loaded_robot *r)
{
    const urdf *u = &r->robot.model;
    const srdf *s = &r->robot.semantics;
    if (!r->joints) {
        describe_joints(r);
        r->link_list = pool_alloc(r->memory, (size_t)u->link_count, sizeof *r->link_list);
        for (int i = 0; i < u->link_count; i++)
            r->link_list[i] = (collided_loaded_link){.name = u->links[i].name,
                .body = u->links[i].shape_count > 0 ? robot_body_name(&r->robot, i, r->memory) : NULL,
                .joint = u->links[i].joint};
        load_report untold = {.error = ""};
        r->treed = robot_make_tree(&r->robot, collided_pose_identity(), r->memory, &r->tree, &untold);
    }
    r->states = pool_alloc(r->memory, (size_t)s->state_count, sizeof *r->states);
    for (int i = 0; i < s->state_count; i++)
        r->states[i] = (collided_loaded_state){s->states[i].name, s->states[i].group ? s->states[i].group : ""};
}

const char *collided_loaded_name(const collided_loaded_robot *robot)
{
    return robot->robot.model.name;
}

const collided_loaded_joint *collided_loaded_joints(const collided_loaded_robot *robot, size_t *count)
{
    *count = (size_t)robot->robot.model.joint_count;
    return robot->joints;
}

const collided_loaded_link *collided_loaded_links(const collided_loaded_robot *robot, size_t *count)
{
    *count = (size_t)robot->robot.model.link_count;
    return robot->link_list;
}

const collided_loaded_state *collided_loaded_states(const collided_loaded_robot *robot, size_t *count)
{
    *count = (size_t)robot->robot.semantics.state_count;
    return robot->states;
}

size_t collided_loaded_body_count(const collided_loaded_robot *robot)
{
    return robot_body_count(&robot->robot);
}

/* ---- joint values ---- */

/* A report of its own: several threads may read one robot at once. */
static load_report report_of(const collided_loaded_robot *robot)
{
    load_forget_error();
    return (load_report){.warn = robot->report.warn, .note = robot->report.note, .context = robot->report.context};
}

void collided_loaded_default_values(const collided_loaded_robot *robot, double *values)
{
    robot_default_values(&robot->robot, values);
}

collided_status collided_loaded_state_values(const collided_loaded_robot *robot, const char *state, double *values)
{
    load_report r = report_of(robot);
    if (robot_state(&robot->robot, state, values, &r)) return COLLIDED_OK;
    return load_refuse(COLLIDED_UNKNOWN_ID, r.error);
}

collided_status collided_loaded_set_value(
    const collided_loaded_robot *robot, const char *joint, double value, double *values)
{
    load_report r = report_of(robot);
    if (!isfinite(value))
        load_fail(&r, "joint '%s': its value is not finite", joint);
    else if (robot_set(&robot->robot, joint, value, values, &r))
        return COLLIDED_OK;
    bool unknown = urdf_find_joint(&robot->robot.model, joint) < 0;
    return load_refuse(unknown ? COLLIDED_UNKNOWN_ID : COLLIDED_BAD_ARGUMENT, r.error);
}

void collided_loaded_link_poses(
    const collided_loaded_robot *robot, collided_pose base, const double *values, collided_pose *poses)
{
    robot_forward(&robot->robot, values, poses);
    for (int i = 0; i < robot->robot.model.link_count; i++) poses[i] = collided_pose_product(base, poses[i]);
}

void collided_loaded_body_poses(
    const collided_loaded_robot *robot, collided_pose base, const double *values, collided_pose *poses)
{
    robot_body_poses(&robot->robot, base, values, poses);
}

/* ---- checks ---- */

collided_status collided_loaded_tree(const collided_loaded_robot *robot, collided_pose base, collided_robot *out)
{
    load_forget_error();
    if (!robot->treed) {
        char text[256];
        snprintf(text, sizeof text, "%s: has more links than a check takes", robot->robot.model.name);
        return load_refuse(COLLIDED_UNSUPPORTED, text);
    }
    *out = robot->tree.robot;
    out->base = base;
    return COLLIDED_OK;
}

void collided_loaded_configuration(const collided_loaded_robot *robot, const double *values, double *configuration)
{
    robot_configuration(&robot->tree, values, configuration);
}

void collided_loaded_values(const collided_loaded_robot *robot, const double *configuration, double *values)
{
    for (size_t i = 0; i < robot->tree.coordinates; i++) values[robot->tree.joints[i]] = configuration[i];
}
