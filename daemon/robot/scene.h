/* scene: what a robot may meet, made ready for many questions: obstacles in the frame of the robot's base, each with a
 * ball around it and a simple body (a rounded box or cylinder) that contains it, in groups under balls.
 *
 * Built once for a snapshot, then only read: any number of threads. Ownership: shapes are borrowed and must outlive the
 * scene; all else is copied. All lengths in m. */
#ifndef COLLIDED_ROBOT_SCENE_H
#define COLLIDED_ROBOT_SCENE_H

#include "base/array.h"
#include "geom/shape.h"
#include "geom/simd.h"

enum { SCENE_GROUP = 8 };

typedef struct scene_obstacle_def {
    const shape *shape;
    pose pose;      /* in the base's frame */
    double widen_m; /* how far any point of it may be from where the shape has it: what is proven holds all the same */
    uint64_t ignored[2]; /* a bit for each link of the robot that need not keep away from it */
} scene_obstacle_def;

typedef enum scene_form { SCENE_BOX, SCENE_CYLINDER, SCENE_HALFSPACE } scene_form;

typedef struct scene_obstacle { /* hot: what balls are compared with */
    double centre[3], bound;    /* a ball around it; bound INFINITY: none */
    double rotation[9];         /* columns: axes of the simple body in the base's frame */
    double half[3];             /* a cylinder about z: half[0] the radius. A half-space: z <= 0 */
    double radius;              /* rounding, `widen_m` and what computing may be off by included */
    scene_form form;
    uint32_t source;     /* index of the definition */
    uint64_t ignored[2]; /* as the definition says */
} scene_obstacle;

typedef struct scene_group {
    double centre[3], bound;
    uint32_t first, count;
    uint64_t ignored[2]; /* links that are to keep away from none of them */
} scene_group;

typedef struct scene {
    scene_obstacle_def *defs;
    size_t def_count;
    scene_obstacle *obstacles; /* group by group; those without an end come last, in groups of their own */
    size_t obstacle_count;
    scene_group *groups;
    size_t group_count;
} scene;

/* Obstacles whose boxes do not come within `reach` of the base's origin are left out: nothing of the robot is ever
 * there.
 */
scene *scene_create(const scene_obstacle_def *defs, size_t count, double reach);
void scene_destroy(scene *s);

/* For four balls side by side, all of one link: lowers clearance[k] to the distance of ball k's centre from the nearest
 * obstacle that the link is to keep away from, less radius[k], where that is less than the clearance it came with.
 * Obstacles that are farther than that from all four are passed by. A lower bound but for SCENE_OFF of the lengths that
 * enter: the caller keeps that much more away. */
#define SCENE_OFF 0x1p-44
void scene_clearance(const scene *s, unsigned link, const lanes centre[3], const lanes *radius, lanes *clearance);

/* The obstacles that may be nearer to a ball of the link than `within`: their indices, ascending, at most `most` of
 * them; how many there are. */
size_t scene_near(
    const scene *s, unsigned link, vec3 centre, double radius, double within, uint32_t *found, size_t most);

#endif
