/* verb_joints: the joints of a robot that an earlier run loaded: told, or moved by forward kinematics, all its links in
 * one message. */
#include "json.h"
#include "loaders/text.h"
#include "recall.h"
#include "store_file.h"
#include "verbs.h"

#include <stdio.h>
#include <string.h>
#include <sysexits.h>

static bool change(ctl *c, const robot *r, double *values)
{
    if (c->options.state && !robot_state(r, c->options.state, values, &c->report)) return false;
    for (int i = 1; i < c->argument_count; i++)
        if (!robot_set_list(r, c->arguments[i], values, &c->report)) return false;
    return true;
}

static int publish_links(ctl *c, const store *s, const robot *r, const store_robot *of, const double *values)
{
    size_t count = robot_body_count(r), n = 0;
    collided_body *bodies = pool_alloc(&c->pool, count, sizeof *bodies);
    collided_pose *poses = pool_alloc(&c->pool, count, sizeof *poses);
    double *positions = pool_alloc(&c->pool, count, 3 * sizeof *positions);
    double *orientations = pool_alloc(&c->pool, count, 4 * sizeof *orientations);
    robot_body_poses(r, of->base, values, poses);
    for (int i = 0; i < r->model.link_count; i++) {
        if (r->model.links[i].shape_count == 0) continue;
        const char *name = robot_body_name(r, i, &c->pool);
        int32_t id = store_find(s, name);
        if (id < 0) return ctl_fail(EX_DATAERR, "joints: the link '%s' was removed: load the robot again", name);
        memcpy(positions + 3 * n, poses[n].position, sizeof poses[n].position);
        memcpy(orientations + 4 * n, poses[n].orientation, sizeof poses[n].orientation);
        bodies[n++] = collided_adopt_body(c->client, id);
    }
    collided_status status = collided_publish(c->client, n, bodies, positions, orientations, NULL, NULL, 0, 0);
    collided_flush(c->client);
    return ctl_check(c, status, "joints");
}

/* Poses are not acknowledged: an answer to a question behind them tells that they have arrived, and any refusal came
 * before it. */
static int confirm_robot(ctl *c, const robot *r)
{
    int link = 0;
    while (link + 1 < r->model.link_count && r->model.links[link].shape_count == 0) link++;
    const char *name = robot_body_name(r, link, &c->pool);
    collided_result result = {0};
    int status = ctl_check(c, collided_query_bodies(c->client, name, c->options.timeout_s, &result), "joints");
    if (!status && c->rejected[0])
        status = ctl_fail(EX_DATAERR, "joints: the daemon refused: %s", c->rejected);
    else if (!status && result.count == 0)
        status = ctl_fail(EX_DATAERR, "joints: the daemon has no body '%s' (was it restarted?): load it again", name);
    collided_result_free(&result);
    return status;
}

static int set_joints(ctl *c, store *s)
{
    store_robot *of;
    robot r;
    double *values;
    int status = recall_robot(c, s, "joints", c->arguments[0], &of, &r, &values);
    if (status) return status;
    if (!change(c, &r, values)) return ctl_fail_loading(c);
    status = ctl_connect_owner(c);
    if (!status) status = publish_links(c, s, &r, of, values);
    if (!status) status = confirm_robot(c, &r);
    if (status) return status;
    store_set_values(s, of, &r, values);
    return store_save(s);
}

/* ---- telling ---- */

static void tell_joint_as_json(const robot *r, const urdf_joint *j, double value)
{
    json out = {.out = stdout};
    json_open(&out, NULL, '{');
    json_text(&out, "joint", j->name);
    json_number(&out, "value", value);
    json_text(&out, "unit", j->type == URDF_PRISMATIC ? "m" : "rad");
    if (j->limited) json_number(&out, "lower", j->lower), json_number(&out, "upper", j->upper);
    if (j->mimic >= 0) json_text(&out, "mimics", r->model.joints[j->mimic].name);
    json_close(&out, '}');
    json_end_line(&out);
}

static void tell_joint(const ctl *c, const robot *r, int joint, const double *values)
{
    const urdf_joint *j = &r->model.joints[joint];
    double value = robot_joint_value(r, joint, values);
    if (j->type == URDF_FIXED) return;
    if (c->options.json) {
        tell_joint_as_json(r, j, value);
        return;
    }
    printf("joint  %-32s %12.6f %-3s", j->name, value, j->type == URDF_PRISMATIC ? "m" : "rad");
    if (j->limited) printf("  %.6g .. %.6g", j->lower, j->upper);
    if (!j->limited) printf("  without limits");
    if (j->limited && (value < j->lower || value > j->upper)) printf("  beyond its limits");
    if (j->mimic >= 0) printf("  mimics %s", r->model.joints[j->mimic].name);
    putchar('\n');
}

static void tell_state(const ctl *c, const srdf_state *s)
{
    if (!c->options.json) {
        printf("state  %-32s %s\n", s->name, s->group ? s->group : "");
        return;
    }
    json out = {.out = stdout};
    json_open(&out, NULL, '{');
    json_text(&out, "state", s->name);
    if (s->group) json_text(&out, "group", s->group);
    json_close(&out, '}');
    json_end_line(&out);
}

static int tell_robots(const ctl *c, const store *s)
{
    for (size_t i = 0; i < s->robot_count; i++) {
        if (!c->options.json) {
            puts(s->robots[i].name);
            continue;
        }
        json out = {.out = stdout};
        json_open(&out, NULL, '{');
        json_text(&out, "robot", s->robots[i].name);
        json_text(&out, "urdf", s->robots[i].urdf);
        json_close(&out, '}');
        json_end_line(&out);
    }
    return 0;
}

/* What the last run that moved it left: nobody is asked. */
static int tell_joints(ctl *c, const store *s)
{
    store_robot *of;
    robot r;
    double *values;
    int status = recall_robot(c, s, "joints", c->arguments[0], &of, &r, &values);
    for (int i = 0; !status && i < r.model.joint_count; i++) tell_joint(c, &r, i, values);
    for (int i = 0; !status && i < r.semantics.state_count; i++) tell_state(c, &r.semantics.states[i]);
    return status;
}

int verb_joints(ctl *c)
{
    store s;
    int status = store_open(&s, c);
    if (status) return status;
    if (c->argument_count == 0)
        status = c->options.state
                     ? ctl_fail(EX_USAGE, "joints: say of which robot: collidectl joints ROBOT --state NAME")
                     : tell_robots(c, &s);
    else
        status = c->argument_count > 1 || c->options.state ? set_joints(c, &s) : tell_joints(c, &s);
    ctl_disconnect(c);
    store_close(&s);
    return status;
}
