/* wire_robot: a question about a robot's configurations or motions, and its answer, as records of a Query and an Answer
 * (WIRE_EXTENSION_CHECK, WIRE_EXTENSION_CHECKED). README.md tells their octets. Pure; any thread. */
#ifndef COLLIDED_WIRE_ROBOT_H
#define COLLIDED_WIRE_ROBOT_H

#include "wire.h"

#include <stddef.h>

enum {
    WIRE_JOINTS_MAX = 128,       /* of a robot */
    WIRE_CHECK_ITEMS_MAX = 1024, /* configurations or edges of one question */
    WIRE_CHECK_NUMBERS_MAX = 7168,
    WIRE_CHECKED_EACH = 41 /* octets that an item takes in an answer */
};

enum { WIRE_JOINT_FIXED, WIRE_JOINT_REVOLUTE, WIRE_JOINT_CONTINUOUS, WIRE_JOINT_PRISMATIC };
enum { WIRE_CHECK_FREE, WIRE_CHECK_MEETS, WIRE_CHECK_UNDECIDED, WIRE_CHECK_NOT_DONE };
enum {
    WIRE_CHECK_EDGES = 1,   /* each item is two configurations, and the straight line between them */
    WIRE_CHECK_FIRST = 2,   /* narrow down where an edge meets something first */
    WIRE_CHECK_MEASURE = 4, /* tell the least distance of each configuration */
    WIRE_CHECK_FLAGS = 7
};

/* A link, and the joint that moves it. */
typedef struct wire_joint {
    int32_t parent;            /* a link before this one; -1 = the base */
    int32_t type;              /* WIRE_JOINT_* */
    int32_t mimic;             /* the joint whose value it takes, times factor, plus offset; -1 = none */
    double origin[7], axis[3]; /* position, orientation; in the parent's frame. The axis in the joint's */
    double lower, upper, factor, offset;
    char body[WIRE_NAME_MAX + 1]; /* the link's; "" = none */
} wire_joint;

typedef struct wire_robot_question {
    uint8_t flags; /* WIRE_CHECK_* added up */
    int32_t joint_count, item_count;
    double margin_m, resolution_m, tolerance_m;
    double base[7]; /* position, orientation, world */
} wire_robot_question;

/* How many numbers an item has: the joints that move by themselves, twice for an edge. */
size_t wire_robot_numbers(const wire_robot_question *q, const wire_joint *joints);

/* The octets of the record, to `out` of wire_robot_size of them. */
size_t wire_robot_size(const wire_robot_question *q, const wire_joint *joints);
void wire_robot_write(const wire_robot_question *q, const wire_joint *joints, const double *numbers, uint8_t *out);

/* Reads a record and checks all that can be told without the world: counts, that numbers are finite, flags, lengths.
 * `joints` has room for WIRE_JOINTS_MAX, `numbers` for WIRE_CHECK_NUMBERS_MAX. */
wire_reason wire_robot_read(
    wire_u8s record, wire_robot_question *q, wire_joint *joints, double *numbers, wire_refusal *why);

/* An answer's record: per item a verdict, four numbers, and two places in the answer's names_a (-1 = nobody). */
typedef struct wire_checked {
    uint8_t verdict; /* WIRE_CHECK_* */
    double first_lo, first_hi, lo, hi;
    int32_t name_a, name_b;
} wire_checked;

void wire_checked_write(const wire_checked *items, size_t count, uint8_t *out); /* WIRE_CHECKED_EACH octets each */
/* False: it is no whole number of items. `items` has room for WIRE_CHECK_ITEMS_MAX. */
bool wire_checked_read(wire_u8s record, wire_checked *items, size_t *count);

#endif
