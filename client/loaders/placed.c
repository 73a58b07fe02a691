/* placed: see placed.h. All files are read, and found good, before anybody hears of the first body. One thread a pool.
 */
#include "placed.h"

#include "text.h"

static void give_motion(load_bodies *links, const scene_robot *from)
{
    for (size_t i = 0; i < links->count; i++) {
        links->at[i].ccd = from->ccd;
        links->at[i].acceleration_m_s2 = from->acceleration_m_s2;
        links->at[i].angular_acceleration_rad_s2 = from->angular_acceleration_rad_s2;
    }
}

bool placed_robot_load(placed_robot *out, pool *p, const scene_robot *from, const char *joints, load_report *r)
{
    out->base = from->pose;
    if (!robot_load(&out->robot, p, &from->source, r)) return false;
    out->values = pool_alloc(p, (size_t)out->robot.model.joint_count, sizeof *out->values);
    robot_default_values(&out->robot, out->values);
    if (from->state && !robot_state(&out->robot, from->state, out->values, r)) return false;
    for (size_t i = 0; i < from->joint_count; i++)
        if (!robot_set(&out->robot, from->joints[i], from->values[i], out->values, r)) return false;
    if (joints && !robot_set_list(&out->robot, joints, out->values, r)) return false;
    if (!robot_bodies(&out->robot, out->base, out->values, from->motion, p, &out->links, r)) return false;
    give_motion(&out->links, from);
    return true;
}

bool placed_scene_load(placed_scene *out, pool *p, const char *path, load_report *r)
{
    size_t size;
    scene s;
    *out = (placed_scene){0};
    const char *data = text_read_file(p, path, SCENE_SIZE_MAX, &size, r);
    if (!data || !scene_parse(&s, p, data, size, path, r)) return false;
    out->bodies = s.bodies;
    out->robots = pool_alloc(p, s.robot_count, sizeof *out->robots);
    for (size_t i = 0; i < s.bodies.count; i++)
        if (!load_body_meshes(p, &s.bodies.at[i], r)) return false;
    for (size_t i = 0; i < s.robot_count; i++)
        if (!placed_robot_load(&out->robots[out->robot_count++], p, &s.robots[i], NULL, r)) return false;
    return true;
}
