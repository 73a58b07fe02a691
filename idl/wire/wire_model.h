/* wire_model: a robot that a body carries, and the values of its joints, as records of a Body and of a PoseBatch.
 * README.md tells their octets. Both must not be passed over: who does not know them would leave the links where they
 * were. Pure; any thread. */
#ifndef COLLIDED_WIRE_MODEL_H
#define COLLIDED_WIRE_MODEL_H

#include "wire_extensions.h"
#include "wire_robot.h"

#define WIRE_EXTENSION_MODEL (WIRE_EXTENSION_REQUIRED | 11)  /* Body */
#define WIRE_EXTENSION_JOINTS (WIRE_EXTENSION_REQUIRED | 12) /* PoseBatch */

enum {
    WIRE_MODEL_BASE_OCTETS = 56, /* before its links */
    WIRE_LINK_OCTETS = 128,
    WIRE_ROBOTS_MAX = 1024,     /* of which a batch has joints */
    WIRE_JOINTS_HEAD = 12,      /* octets before the numbers of one robot */
    WIRE_JOINTS_GIVE_BASE = 1,  /* flags: seven numbers say where the base is, ... */
    WIRE_JOINTS_GIVE_RATES = 2, /* ... and velocities stand behind what they belong to */
    WIRE_JOINTS_TELEPORT = 4,   /* the links did not move there */
    WIRE_JOINTS_FLAGS = 7
};

/* A link, and the joint that moves it. */
typedef struct wire_link {
    int32_t parent;            /* a link before this one; -1 = the base */
    int32_t type;              /* WIRE_JOINT_* */
    int32_t mimic;             /* the joint whose value it takes, times factor, plus offset; -1 = none */
    int32_t body;              /* the client's number of the body that is this link; -1 = none */
    double origin[7], axis[3]; /* position, orientation; in the parent's frame. The axis in the joint's */
    double lower, upper, factor, offset;
} wire_link;

typedef struct wire_model {
    double base[7]; /* position, orientation; world */
    int32_t count;
    wire_link links[WIRE_JOINTS_MAX];
} wire_model;

/* The extensions of a Body with that model alone, to `out` of WIRE_EXTENSION_HEAD + WIRE_MODEL_BASE_OCTETS + count
 * WIRE_LINK_OCTETS. How many octets. */
uint32_t wire_model_write(const wire_model *m, uint8_t *out);
/* Of a Body's extensions. False: they have no model. */
bool wire_model_find(wire_u8s extensions, wire_u8s *record);
/* WIRE_OK, or why not: counts, numbers and bodies; that joints make a tree is told by whoever makes one. */
wire_reason wire_model_read(wire_u8s record, wire_model *out, wire_refusal *why);

/* The values of one robot's joints: those that move and mimic no other, in their order. */
typedef struct wire_joints {
    int32_t body;     /* that carries the model */
    int32_t count;    /* of values */
    int32_t flags;    /* WIRE_JOINTS_* */
    double base[7];   /* with WIRE_JOINTS_GIVE_BASE: position, orientation; world */
    double motion[6]; /* with both: the base's linear and angular velocity, world axes */
    double values[WIRE_JOINTS_MAX], rates[WIRE_JOINTS_MAX]; /* rad or m, and a second */
} wire_joints;

/* The extensions of a PoseBatch with the joints of one robot alone; `out` has room for wire_joints_size octets. */
uint32_t wire_joints_size(const wire_joints *j);
uint32_t wire_joints_write(const wire_joints *j, uint8_t *out);
bool wire_joints_find(wire_u8s extensions, wire_u8s *record);
/* How many poses they may become, by the number of robots alone. */
uint32_t wire_joints_poses_most(wire_u8s extensions);
/* The next robot's, which is taken from the front of `rest`. False: there is none, or not a whole one; then `rest`
 * stays as it is. Its numbers are as they came. */
bool wire_joints_next(wire_u8s *rest, wire_joints *out);

#endif
