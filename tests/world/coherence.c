/* coherence: a cell of four arms that swing among fixed clutter, and a crowd that walks in a hall. All motion is a
 * function of time alone, so that any two runs of a scene are the same. */
#include "coherence.h"

#include <math.h>
#include <stdio.h>

static double hash01(uint32_t a, uint32_t b) /* splitmix64 of the two, in [0, 1) */
{
    uint64_t z = ((uint64_t)a << 32 | b) * UINT64_C(0x9e3779b97f4a7c15) + UINT64_C(0x9e3779b97f4a7c15);
    z = (z ^ z >> 30) * UINT64_C(0xbf58476d1ce4e5b9);
    z = (z ^ z >> 27) * UINT64_C(0x94d049bb133111eb);
    return (double)((z ^ z >> 31) >> 11) * 0x1p-53;
}

static uint32_t put(world *w, const char *name, uint32_t number, const char *group, bool fixed, shape s, pose at)
{
    char text[32];
    snprintf(text, sizeof text, "%s%u", name, number);
    world_shape one = {.shape = s, .local = POSE_IDENTITY};
    world_body def = {.name = text,
        .group = group,
        .fixed = fixed,
        .category = 1,
        .mask = UINT64_MAX,
        .pose = at,
        .shapes = &one,
        .shape_count = 1};
    uint32_t id = WORLD_NONE;
    world_put_body(w, &id, &def);
    return id;
}

static quat about_z(double angle)
{
    return (quat){cos(angle / 2), 0, 0, sin(angle / 2)};
}
static quat about_y(double angle)
{
    return (quat){cos(angle / 2), 0, sin(angle / 2), 0};
}

/* ---- four arms of six links each, and 120 fixed things around them ---- */

enum { ARMS = 4, LINKS = 6, CLUTTER = 120 };
static const double LINK_LENGTH = 0.35; /* m */

static pose link_pose(uint32_t arm, uint32_t link, double t)
{
    pose at = {vec((arm & 1) * 1.6 - 0.8, (arm >> 1) * 1.6 - 0.8, 0.1), about_z(0.6 * sin(0.5 * t + arm))};
    for (uint32_t i = 0; i <= link; i++) { /* joints of about 1 rad/s */
        double angle = 0.35 + 0.5 * sin((0.6 + 0.15 * i) * t + arm + 2.0 * i);
        at.q = quat_mul(at.q, i % 2 ? about_z(angle) : about_y(angle));
        double along = i < link ? LINK_LENGTH : 0.5 * LINK_LENGTH;
        at.p = vec_add(at.p, quat_rotate(at.q, vec(0, 0, along)));
    }
    return at;
}

static shape link_shape(uint32_t link)
{
    if (link % 3 == 1) return (shape){.type = SHAPE_BOX, .half = vec(0.05, 0.06, 0.13)};
    if (link % 3 == 2) return (shape){.type = SHAPE_CYLINDER, .half = vec(0.05, 0.05, 0.13)};
    return (shape){.type = SHAPE_CAPSULE, .half = vec(0, 0, 0.1), .radius = 0.05};
}

static void create_cell(world *w, uint32_t *ids)
{
    for (uint32_t arm = 0; arm < ARMS; arm++) {
        char group[16];
        snprintf(group, sizeof group, "arm%u", arm);
        for (uint32_t link = 0; link < LINKS; link++)
            ids[arm * LINKS + link] = put(w, group, link, group, false, link_shape(link), link_pose(arm, link, 0));
    }
    for (uint32_t i = 0; i < CLUTTER; i++) {
        pose at = {vec(4 * hash01(i, 0) - 2, 4 * hash01(i, 1) - 2, 1.6 * hash01(i, 2)), about_z(6.28 * hash01(i, 3))};
        vec3 half = vec(0.05 + 0.15 * hash01(i, 4), 0.05 + 0.15 * hash01(i, 5), 0.05 + 0.1 * hash01(i, 6));
        put(w, "thing", i, "", true, (shape){.type = SHAPE_BOX, .half = half}, at);
    }
}

static void move_cell(world *w, const uint32_t *ids, double t)
{
    for (uint32_t arm = 0; arm < ARMS; arm++)
        for (uint32_t link = 0; link < LINKS; link++)
            world_move_body(w, ids[arm * LINKS + link], link_pose(arm, link, t), 0, NULL, NULL);
}

/* ---- 600 people, one a square metre, who walk to and fro in lanes at about 1 m/s and brush past each other ---- */

enum { LANES = 24, A_LANE = 25, PEOPLE = LANES * A_LANE };
static const double APART = 1.25, LANE_WIDTH = 0.8; /* m */

static double wrapped(double x, double length)
{
    return x - length * floor(x / length);
}

/* Who leaves at one end of a lane comes in at the other. */
static pose walker_pose(uint32_t i, double t)
{
    uint32_t lane = i / A_LANE;
    double way = lane % 2 ? 1 : -1, speed = 0.8 + 0.6 * hash01(lane, 1), phase = 6.28 * hash01(i, 2);
    double sway = 0.16 * sin(1.7 * t + phase), swing = 0.16 * 1.7 * cos(1.7 * t + phase);
    double x = (i % A_LANE + 0.2 * hash01(i, 3)) * APART + way * speed * t;
    return (pose){vec(wrapped(x, A_LANE * APART), lane * LANE_WIDTH + sway, 0.9), about_z(atan2(swing, way * speed))};
}

static shape walker_shape(uint32_t i)
{
    if (i % 4 == 3) return (shape){.type = SHAPE_BOX, .half = vec(0.35, 0.25, 0.6)}; /* with a trolley */
    return (shape){.type = SHAPE_CAPSULE, .half = vec(0, 0, 0.6), .radius = 0.25};
}

static void create_crowd(world *w, uint32_t *ids)
{
    for (uint32_t i = 0; i < PEOPLE; i++) ids[i] = put(w, "walker", i, "", false, walker_shape(i), walker_pose(i, 0));
}

static void move_crowd(world *w, const uint32_t *ids, double t)
{
    for (uint32_t i = 0; i < PEOPLE; i++) world_move_body(w, ids[i], walker_pose(i, t), 0, NULL, NULL);
}

const coherence_scene coherence_scenes[COHERENCE_SCENES] = {
    {"robot cell", 0.01, create_cell, move_cell},
    {"crowd", 0.01, create_crowd, move_crowd},
};
