/* load: what is behind the handles of collided_load.h, shared by its files. */
#ifndef COLLIDED_LOAD_LOAD_H
#define COLLIDED_LOAD_LOAD_H

#include "collided_load.h"
#include "loaders/placed.h"
#include "loaders/robot_tree.h"

struct collided_loaded_robot {
    pool pool;
    pool *memory; /* its own, or that of its scene */
    load_report report;
    collided_load_told *warn, *note;
    void *context;
    robot robot;
    bool read; /* `links` are there */
    load_bodies links;
    robot_checked tree; /* its base is not looked at */
    bool treed;
    collided_loaded_joint *joints;
    collided_loaded_link *link_list;
    collided_loaded_state *states;
};

struct collided_loaded_scene {
    pool pool;
    load_report report;
    placed_scene scene;
    collided_loaded_placed *robots;
};

/* The error of this thread: none, or a line. */
void load_forget_error(void);
collided_status load_refuse(collided_status status, const char *text);

/* Where a report's warnings and notes go. */
load_report load_report_to(const collided_load_def *def);

/* What the handle tells of a robot that was read; its pool and report are there. */
void load_describe_robot(collided_loaded_robot *r);

/* Hands bodies to the client, `deadline_s` with each that is above 0. */
collided_status load_create_bodies(collided *c, const load_bodies *from, collided_body *bodies);

#endif
