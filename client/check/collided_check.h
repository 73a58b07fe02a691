/* collided_check: a small checker of the certificates of the collision daemon collided(8), for whoever does not want to
 * believe a large one. One file of plain C to be read, of less than 500 lines beside comments, without memory of its
 * own, state or dependencies but sqrt. What each accepted certificate proves, and what it does not, says CERTIFICATE.md
 * (installed beside the manual); which part of the way from there to this code is proven by machine, and from which
 * assumptions, says `script/prove`.
 *
 *     collided_check_shape ball = {.kind = COLLIDED_CHECK_SPHERE, .radius = 0.1, .pose = {0, 0, 0, 1}};
 *     double here[7] = {0, 0, 0, 1}, there[7] = {1, 0, 0, 1};
 *     collided_check_claim claim = {.lo = 0.79, .hi = 0.81, .axis = {1}, .point_a = {0.1}, .point_b = {0.9}};
 *     collided_check_proven proven;
 *     if (collided_check_distance(&ball, here, &ball, there, &claim, 0, &proven) == COLLIDED_CHECK_PROVEN)
 *         ...                                          // proven.lo <= distance <= proven.hi
 *
 * Units: m; times in the unit in which speeds are given. Frames are right-handed. A pose is seven numbers, position x,
 * y, z and a quaternion w, x, y, z, which counts as the rotation of its normalised self; its squared length is within
 * 2^-9 of 1. All arrays are borrowed for the call. Nothing is read beyond the counts that are passed, and no pointer
 * may be NULL except where its count is 0. All functions are pure, may be called by any thread, and never wait.
 * Errors: each function returns a status; any bit pattern of a number is allowed, and what is no proper input (NaN,
 * infinite, beyond 2^400 m, negative sizes, unknown kinds, wrong counts) is refused by one that says which input it is.
 *
 * The arithmetic is that of IEEE 754 doubles, rounding to nearest, without contraction to fused operations, with a
 * correctly rounded sqrt: collided_check_machine tests it. Bounds of what rounding may do are in the code, derived and
 * proven: what is called proven holds for the exact real numbers that the doubles stand for. */
#ifndef COLLIDED_CHECK_H
#define COLLIDED_CHECK_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

typedef enum collided_check_status {
    COLLIDED_CHECK_PROVEN = 0,     /* all that is claimed is proven */
    COLLIDED_CHECK_LO_UNPROVEN,    /* the axis does not prove lo: what it proves is in `proven` */
    COLLIDED_CHECK_HI_UNPROVEN,    /* lo is proven (or not claimed), but the points do not prove hi */
    COLLIDED_CHECK_DEPTH_UNPROVEN, /* lo is proven; hi is negative, and no two points prove a depth. That the shapes
                                      come as near as proven.hi is proven */
    COLLIDED_CHECK_TIME_UNPROVEN,  /* of motions and features: not all of the time is proven to be free */
    COLLIDED_CHECK_BAD_KIND,       /* no kind of shape, or of one that may not stand there */
    COLLIDED_CHECK_BAD_SIZE,       /* a size, radius or deviation is negative, too large or no number */
    COLLIDED_CHECK_BAD_POSE,       /* a position is too large or no number; or a quaternion is not of length 1 */
    COLLIDED_CHECK_BAD_POINTS,   /* a hull without points, with too many, or with one that is too large or no number */
    COLLIDED_CHECK_BAD_CHILDREN, /* a compound without children, or with too many */
    COLLIDED_CHECK_BAD_AXIS,     /* an axis or direction is no number or too far from unit length */
    COLLIDED_CHECK_BAD_CLAIM,    /* lo > hi, or no number; a bound, margin or allowance that is negative or no number */
    COLLIDED_CHECK_BAD_TIMES,    /* too few or too many times, one that is no number, or they do not rise */
    COLLIDED_CHECK_NO_POINTER    /* a pointer is NULL that may not be */
} collided_check_status;

/* The status in words. A constant string; any thread. */
const char *collided_check_status_text(collided_check_status status);

/* Kinds of shapes, with the numbers of collided_shape_type. Meshes and height fields have no such certificate. */
enum {
    COLLIDED_CHECK_SPHERE = 0,    /* the point at the origin: `radius` makes it a ball */
    COLLIDED_CHECK_CAPSULE = 1,   /* the segment |z| <= half[2] */
    COLLIDED_CHECK_BOX = 2,       /* |x| <= half[0], |y| <= half[1], |z| <= half[2] */
    COLLIDED_CHECK_CYLINDER = 3,  /* x^2 + y^2 <= half[0]^2, |z| <= half[2] */
    COLLIDED_CHECK_CONE = 4,      /* for each s of 0 to 1, the disc of radius s half[0] at z = half[2] (1 - 2 s) */
    COLLIDED_CHECK_ELLIPSOID = 5, /* (half[0] x, half[1] y, half[2] z) of all x^2 + y^2 + z^2 <= 1 */
    COLLIDED_CHECK_HALFSPACE = 6, /* z <= 0 */
    COLLIDED_CHECK_HULL = 7,      /* the convex hull of `points` */
    COLLIDED_CHECK_COMPOUND = 10  /* the union of `children` */
};

enum {
    COLLIDED_CHECK_POINTS_MOST = 65536,  /* of a hull */
    COLLIDED_CHECK_CHILDREN_MOST = 255,  /* of a compound */
    COLLIDED_CHECK_TIMES_MOST = 1048576, /* of a motion */
    COLLIDED_CHECK_JOINTS_MOST = 256     /* of a robot */
};

/* A shape: all points within `radius` of what its kind says. Begin with zeros. */
typedef struct collided_check_shape {
    int32_t kind;
    double half[3];
    double radius;    /* >= 0 */
    double deviation; /* >= 0: what the shape stands for is inside of it, and none of its points is farther from that;
                         of a compound: added to that of each child */
    double pose[7];   /* in the body's frame; of a child in the compound's */
    const double *points;                        /* of a hull: x, y, z each */
    size_t point_count;                          /* of a hull: 1 to COLLIDED_CHECK_POINTS_MOST; else not looked at */
    const struct collided_check_shape *children; /* of a compound: no half-spaces, no compounds */
    size_t child_count;                          /* of a compound: 1 to COLLIDED_CHECK_CHILDREN_MOST */
} collided_check_shape;

/* A claim about the signed distance of two shapes, as the wire carries it: see CERTIFICATE.md. */
typedef struct collided_check_claim {
    double lo, hi;  /* lo = -INFINITY: hi alone is claimed; hi = INFINITY: lo alone */
    double axis[3]; /* world, from A to B; not looked at where lo is not claimed, or one is a half-space */
    double point_a[3], point_b[3]; /* world; not looked at where hi is not claimed */
} collided_check_claim;

/* What is proven of the signed distance: -INFINITY and INFINITY where nothing is claimed or proven. */
typedef struct collided_check_proven {
    double lo, hi;
} collided_check_proven;

/* Is a claimed interval of the signed distance of two shapes proven by its axis and its points? pose_a, pose_b: of the
 * bodies. allowed_m: lo may be above what is proven, and hi below it, by less than this; 0 where a claim must hold as
 * it stands. (The daemon rounds its points, which are world coordinates, to doubles: they prove hi only up to about
 * 1e-15 of their coordinates.) *proven is always written, whatever the status. */
collided_check_status collided_check_distance(const collided_check_shape *a, const double pose_a[7],
    const collided_check_shape *b, const double pose_b[7], const collided_check_claim *claim, double allowed_m,
    collided_check_proven *proven);

/* Two bodies that move, looked at at some times: an edge of a roadmap, a way to an impact. Between two times that
 * follow each other, they are farther apart than `margin` if (1) the gaps at both, along their own axes, add up to more
 * than 2 margin + speed x (time between), or (2) the gaps at both along the axis of the first are each above margin +
 * bend x (time between)^2 / 8. Either is enough. */
typedef struct collided_check_motion {
    size_t count;          /* of times: 2 to COLLIDED_CHECK_TIMES_MOST */
    const double *times;   /* `count`, rising */
    const double *poses_a; /* 7 x count: of body A then */
    const double *poses_b; /* 7 x count */
    const double *axes;    /* 3 x count; beside a half-space not looked at */
    double speed;          /* no point of A moves relative to one of B by more than this x the time that it takes;
                              INFINITY: not known. Of a robot: collided_check_joint_speed */
    double bend;           /* no such relative velocity changes by more than this x the time; INFINITY: not known */
    double margin;         /* m */
} collided_check_motion;

/* Is it proven that the two shapes are farther apart than the margin from the first to the last of the times? *until:
 * the time until which it is; the first of them where nothing is, NaN for bad input. */
collided_check_status collided_check_motion_free(
    const collided_check_shape *a, const collided_check_shape *b, const collided_check_motion *motion, double *until);

/* A bound of the speed of the points of a robot's link over an edge, whose time goes from 0 to 1: the sum of |travel| x
 * arm of its joints, rounded up. travel: rad, or m of prismatic joints; arm: how far from the joint's axis the link's
 * points come at most, m, or 1. Infinite for bad input. */
double collided_check_joint_speed(size_t count, const double *travel, const double *arm);

/* Bounds for two bodies that each move at a constant linear (m/s) and angular velocity (rad/s, world axes): speed and
 * bend of collided_check_motion, rounded up. Half-spaces must not turn; a plane that stands still bounds what moves
 * before it. Both infinite for bad input. */
collided_check_status collided_check_twist(const collided_check_shape *a, const double linear_a[3],
    const double angular_a[3], const collided_check_shape *b, const double linear_b[3], const double angular_b[3],
    double *speed, double *bend);

/* Two features of deformable meshes, whose points move straight from `start` (time 0) to `end` (time 1): four points,
 * x, y, z each. Of a vertex and a face: the vertex, and the face's corners; of two edges: the ends of one, and of the
 * other. From times[k] to times[k + 1], directions[k], from the first feature to the second and as near to unit as an
 * axis, is claimed to part them. */
enum { COLLIDED_CHECK_VERTEX_FACE = 0, COLLIDED_CHECK_EDGE_EDGE = 1 };
typedef struct collided_check_features {
    int32_t kind;
    double start[12], end[12];
    double separation;        /* m, >= 0 */
    size_t count;             /* of directions: 1 to COLLIDED_CHECK_TIMES_MOST - 1 */
    const double *times;      /* count + 1, rising, within 0 and 1 */
    const double *directions; /* 3 x count */
} collided_check_features;

/* Is it proven that the features are farther apart than the separation from the first to the last of the times? *until
 * as above. */
collided_check_status collided_check_features_free(const collided_check_features *features, double *until);

/* Does this machine, as this library is built and as this thread's rounding is set, compute as the proofs assume? Once,
 * when a program starts. False: believe nothing here. */
bool collided_check_machine(void);

#ifdef __cplusplus
}
#endif

#endif
