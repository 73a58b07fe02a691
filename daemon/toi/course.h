/* course: the relative motion of two shapes, prepared for a search: their relative pose at a time, their separation
 * along a direction, and how far any gap can dip between two times. Pure; any thread.
 *
 * The frame has the world's axes and moves with the origin of A's body, so that precision follows the size of the pair
 * and of what it moves relative to each other. */
#ifndef COLLIDED_TOI_COURSE_H
#define COLLIDED_TOI_COURSE_H

#include "narrow/closed/closed.h"
#include "narrow/math/scalar.h"
#include "request.h"

typedef struct course_place { /* the relative pose at a time */
    pose b_in_a;              /* the shapes */
    mat3 world_of_a;          /* the axes of A's shape in the world's */
    vec3 arm;                 /* from the frame's origin to that of A's shape, world axes */
} course_place;

typedef struct course {
    const shape *a, *b;
    pose local_a, local_b;
    motion body_a, body_b; /* in the frame: A's body turns in place */
    double span;           /* s */
    motion_spin spin_a, spin_b;
    bool straight;      /* neither turns */
    course_place first; /* at time 0 */
    vec3 rate;          /* straight: how fast B's position changes in A's frame, m/s */
    double bend;        /* m/s^2: over a time h no gap along a direction dips below its chord by more than
                           bend h^2 / 8 */
    /* Of a plane that turns its bend is plane_turn2 * (how far the bodies' origins are apart + plane_extent) +
     * plane_bend; otherwise plane_turn2 is 0. */
    double plane_turn2, plane_extent, plane_bend;
    double speed;              /* m/s: no two points approach each other faster */
    double radius_a, radius_b; /* m: of the cores about the axes that they turn about */
    double reach_a, reach_b;   /* m: of the shapes from the origins of their bodies; of half-spaces: their frames */
    double core_a, core_b;     /* m: the same of the cores: a radius is the same all round, however a direction turns */
    double slack;              /* m: rounding of all poses up to the end of the span */
} course;

/* Returns false if no bound exists, as for a half-space that turns against another one. */
bool course_init(course *c, const toi_mover *a, const toi_mover *b, double span);

/* course_init in two parts: course_bounds prepares the bounds, course_make_places what course_at and all functions that
 * take a course_place need. */
bool course_bounds(course *c, const toi_mover *a, const toi_mover *b, double span);
void course_make_places(course *c);

course_place course_at(const course *c, double time);

/* The time (s) until which the bounding balls about the bodies' origins are farther apart than `target` plus `wander`.
 * It is INFINITY if they are so for the whole span, and 0 for half-spaces. */
double course_balls_meet(const course *c, double target, double wander);

/* The certified separation along a world direction; with a half-space along its normal. */
double course_separation(const course *c, const course_place *at, vec3 direction);

/* The velocity (m/s, world axes) of the point of B at `point_b` relative to the point of A at `point_a` at a time. Both
 * points are relative to the frame's origin. */
vec3 course_velocity(const course *c, double time, vec3 point_a, vec3 point_b);

/* The greatest dip of a gap along a fixed direction between two times. */
static inline double course_dip(const course *c, double step)
{
    return c->bend * step * step / 8 * (1 + 0x1p-48);
}

/* The step after which `gap` is used up, if it grows at `rate` and that rate falls by `bend`. */
static inline double course_step_until_used(double gap, double rate, double bend)
{
    double slope = sqrt(rate * rate + 2 * bend * gap) - rate; /* >= 0 */
    return slope > 0 ? 2 * gap / slope : INFINITY;
}

/* A direction may be fixed, or turn with one of the bodies. Along the normal of a face that turns with its body the gap
 * closes as the nearest points approach; along a fixed direction the corners of the face rise in addition. */
typedef enum course_frame { COURSE_STILL, COURSE_WITH_A, COURSE_WITH_B, COURSE_FRAMES } course_frame;

/* The greatest distance (m) of the bodies' origins between two times. */
double course_far(const course *c, double from, double to);

/* The bend of gaps along a direction in that frame, from `from` to `to`. */
double course_bend(const course *c, course_frame frame, double from, double to);

/* Carries an axis that belongs to a frame from A's frame at one time to A's frame at another time. */
vec3 course_carry(course_frame frame, const course_place *from, vec3 axis_in_a, const course_place *to);

/* Replaces a turning shape by the volume that it sweeps when it turns for ever: a cylinder about the axis of turning,
 * which does not turn. As long as the cylinder is free, the shape is. A shape that does not turn is kept. *spun is
 * memory of the caller. It returns false if there is no such cylinder. */
bool course_spin(const toi_mover *m, shape *spun, toi_mover *out);

/* ==== closed forms ==== */

/* The time of impact of two balls, and of a ball and a box, that do not turn relative to each other, in closed form.
 * Pure. */

/* ---- two balls, whose centres move along straight lines: a quadratic equation, proven at both ends ---- */

/* Returns true if it has found the answer, which it writes to *out as toi_find does, without the bodies' poses. It
 * returns false for other shapes, for balls that touch at the beginning or graze, and for sizes whose squares are out
 * of the range of doubles. */
bool toi_spheres(const toi_mover *a, const toi_mover *b, const toi_request *request, toi_result *out);

/* ---- a ball and a box ---- */

/* Returns true if *out is the answer, without the bodies' poses. It returns false if a search has to answer: for other
 * shapes, and for a pair that begins in contact, hardly moves, grazes, or touches within rounding only. */
bool toi_ball_box(const toi_mover *a, const toi_mover *b, const toi_request *request, toi_result *out);

/* ==== boxes that move ==== */

/* The time for which two moving balls, capsules or boxes are certainly apart, by separating axes alone. Pure. */

/* Are these a ball, capsule or box and a capsule or box, of sizes whose squares are in the range of doubles? */
bool toi_boxes_apply(const course *c);

/* Searches, from the time `from` on, how long the shapes stay apart. If it returns INFINITY, *out is the answer: FREE,
 * HIT, or NEAR if that is enough (`rough`), with points relative to the start of A's body. Otherwise it returns a time
 * up to which they are apart, from which the search goes on. It needs toi_boxes_apply, and a threshold that is not
 * negative. */
double toi_boxes_march(const course *c, const toi_request *request, double from, bool rough, toi_result *out);

#endif
