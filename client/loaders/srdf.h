/* srdf: what a Semantic Robot Description adds to a URDF: named states, pairs of links whose collisions are disabled
 * and why, groups, and the joint to the world. It lives in the caller's pool and is not changed again. */
#ifndef COLLIDED_LOADERS_SRDF_H
#define COLLIDED_LOADERS_SRDF_H

#include "urdf.h"

typedef struct srdf_value {
    int joint; /* of the URDF */
    double value;
} srdf_value;

typedef struct srdf_state {
    const char *name;
    const char *group;
    srdf_value *values;
    int value_count;
} srdf_state;

typedef struct srdf_disabled {
    int link1, link2; /* of the URDF */
    const char *reason;
} srdf_disabled;

/* A group as it is written: names of links and joints, chains from base to tip, other groups. */
typedef enum srdf_member_kind { SRDF_LINK, SRDF_JOINT, SRDF_PASSIVE_JOINT, SRDF_CHAIN, SRDF_GROUP } srdf_member_kind;
typedef struct srdf_member {
    srdf_member_kind kind;
    const char *name; /* of a chain: its base link */
    const char *tip;  /* of a chain: its last link; otherwise NULL */
} srdf_member;
typedef struct srdf_group {
    const char *name;
    srdf_member *members;
    int member_count;
} srdf_group;

typedef struct srdf {
    srdf_state *states;
    int state_count;
    srdf_disabled *disabled;
    int disabled_count;
    srdf_group *groups;
    int group_count;
    const char *virtual_joint;  /* NULL = none */
    const char *virtual_parent; /* the frame that the robot stands in */
} srdf;

/* Names are checked against `u`: a link or joint that it does not have is refused in a state, and passed over with a
 * warning among the disabled pairs (they are often generated for a larger model). */
bool srdf_parse(srdf *out, pool *p, const urdf *u, const char *data, size_t size, const char *file, load_report *r);

#endif
