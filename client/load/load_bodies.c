/* load_bodies: collided_load.h's bodies and scenes: all files are read, and found good, before the client is given the
 * first body. One thread a handle. */
#include "load.h"

#include <stdlib.h>

collided_status load_create_bodies(collided *c, const load_bodies *from, collided_body *bodies)
{
    for (size_t i = 0; i < from->count; i++) {
        bodies[i] = load_body_announce(c, &from->at[i], COLLIDED_NONE);
        if (bodies[i].id == COLLIDED_NONE) return load_refuse(COLLIDED_BAD_ARGUMENT, collided_error(c));
    }
    return COLLIDED_OK;
}

static void forget_bodies(collided_body *bodies, size_t count)
{
    for (size_t i = 0; i < count; i++) bodies[i].id = COLLIDED_NONE;
}

/* ---- robots ---- */

static bool read_links(collided_loaded_robot *r)
{
    if (r->read) return true;
    pool *p = r->memory;
    double *values = pool_alloc(p, (size_t)r->robot.model.joint_count, sizeof *values);
    r->report.error[0] = '\0';
    r->read = robot_bodies(&r->robot, collided_pose_identity(), values, COLLIDED_MOVING, p, &r->links, &r->report);
    return r->read;
}

static void place_links(collided_loaded_robot *r, const collided_placement *at)
{
    pool work = {0};
    double *values = pool_alloc(&work, (size_t)r->robot.model.joint_count, sizeof *values);
    collided_pose *poses = pool_alloc(&work, r->links.count, sizeof *poses);
    robot_default_values(&r->robot, values);
    robot_body_poses(&r->robot, at->base, at->values ? at->values : values, poses);
    for (size_t i = 0; i < r->links.count; i++) {
        load_body *b = &r->links.at[i];
        b->pose = poses[i];
        b->motion = at->motion;
        b->deadline_s = at->deadline_s;
        b->ccd = at->ccd;
        b->acceleration_m_s2 = at->acceleration_m_s2;
        b->angular_acceleration_rad_s2 = at->angular_acceleration_rad_s2;
    }
    pool_free(&work);
}

collided_status collided_create_loaded(
    collided *c, collided_loaded_robot *robot, const collided_placement *placement, collided_body *bodies)
{
    load_forget_error();
    if (!c || !robot || !placement || !bodies)
        return load_refuse(COLLIDED_BAD_ARGUMENT, "collided_create_loaded: an argument is NULL");
    forget_bodies(bodies, collided_loaded_body_count(robot));
    if (!read_links(robot)) return load_refuse(COLLIDED_BAD_ARGUMENT, robot->report.error);
    place_links(robot, placement);
    return load_create_bodies(c, &robot->links, bodies);
}

/* ---- scenes ---- */

static void describe_scene(collided_loaded_scene *s)
{
    size_t first = s->scene.bodies.count;
    s->robots = pool_alloc(&s->pool, s->scene.robot_count, sizeof *s->robots);
    for (size_t i = 0; i < s->scene.robot_count; i++) {
        const placed_robot *from = &s->scene.robots[i];
        collided_loaded_robot *r = pool_alloc(&s->pool, 1, sizeof *r);
        r->memory = &s->pool;
        r->report = s->report;
        r->robot = from->robot;
        r->links = from->links;
        r->read = true;
        load_describe_robot(r);
        s->robots[i] = (collided_loaded_placed){r, from->base, from->values, first};
        first += from->links.count;
    }
}

collided_loaded_scene *collided_load_scene(const char *path, const collided_load_def *def)
{
    load_forget_error();
    if (!path || (def && (def->prefix || def->package_count || (def->meshes && *def->meshes != 'h')))) {
        (void)load_refuse(
            COLLIDED_BAD_ARGUMENT, path ? "a scene says itself what prefix, packages and meshes say for a URDF"
                                        : "collided_load_scene: no path");
        return NULL;
    }
    collided_loaded_scene *s = calloc(1, sizeof *s);
    if (!s) {
        (void)load_refuse(COLLIDED_BAD_ARGUMENT, "out of memory");
        return NULL;
    }
    s->report = load_report_to(def);
    if (placed_scene_load(&s->scene, &s->pool, path, &s->report)) {
        describe_scene(s);
        return s;
    }
    (void)load_refuse(COLLIDED_BAD_ARGUMENT, s->report.error);
    collided_loaded_scene_free(s);
    return NULL;
}

void collided_loaded_scene_free(collided_loaded_scene *scene)
{
    if (!scene) return;
    pool_free(&scene->pool);
    free(scene);
}

size_t collided_loaded_scene_body_count(const collided_loaded_scene *scene)
{
    size_t count = scene->scene.bodies.count;
    for (size_t i = 0; i < scene->scene.robot_count; i++) count += scene->scene.robots[i].links.count;
    return count;
}

const char *collided_loaded_scene_body_name(const collided_loaded_scene *scene, size_t index)
{
    const load_bodies *from = &scene->scene.bodies;
    for (size_t i = 0; index >= from->count && i < scene->scene.robot_count; i++) {
        index -= from->count;
        from = &scene->scene.robots[i].links;
    }
    return index < from->count ? from->at[index].name : NULL;
}

const collided_loaded_placed *collided_loaded_scene_robots(const collided_loaded_scene *scene, size_t *count)
{
    *count = scene->scene.robot_count;
    return scene->robots;
}

collided_status collided_create_loaded_scene(collided *c, const collided_loaded_scene *scene, collided_body *bodies)
{
    load_forget_error();
    if (!c || !scene || !bodies)
        return load_refuse(COLLIDED_BAD_ARGUMENT, "collided_create_loaded_scene: an argument is NULL");
    forget_bodies(bodies, collided_loaded_scene_body_count(scene));
    collided_status status = load_create_bodies(c, &scene->scene.bodies, bodies);
    size_t first = scene->scene.bodies.count;
    for (size_t i = 0; i < scene->scene.robot_count && status == COLLIDED_OK; i++) {
        status = load_create_bodies(c, &scene->scene.robots[i].links, bodies + first);
        first += scene->scene.robots[i].links.count;
    }
    return status;
}
