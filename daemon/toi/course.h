/* course: the motion of two shapes relative to each other, made ready: their relative pose at a time, how apart they
 * are along a direction, and how far any gap can dip between two times. Pure; any thread.
 *
 * The frame has the world's axes and moves with the origin of A's body, so that precision follows the size of the pair
 * and of what it moves relative to each other. */
#ifndef COLLIDED_TOI_COURSE_H
#define COLLIDED_TOI_COURSE_H

#include "narrow/closed/closed.h"
#include "narrow/math/scalar.h"
#include "request.h"

typedef struct course_place { /* where the two are at a time */
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

/* False if no bound exists: a half-space that turns against another. */
bool course_init(course *c, const toi_mover *a, const toi_mover *b, double span);

/* The same in two parts: all but the places, which are for course_at and all that takes a place, and those. */
bool course_bounds(course *c, const toi_mover *a, const toi_mover *b, double span);
void course_make_places(course *c);

course_place course_at(const course *c, double time);

/* s: until then balls about their bodies' origins, which hold them, are more than `target` (and what they may wander)
 * apart; INFINITY: up to the span. 0 for half-spaces. */
double course_balls_meet(const course *c, double target, double wander);

/* How far they are apart along a world direction (with a half-space along its normal): certified. */
double course_separation(const course *c, const course_place *at, vec3 direction);

/* m/s, in the world's axes: how fast a point of B at `point_b` moves relative to one of A at `point_a` (both relative
 * to the frame's origin) at a time. */
vec3 course_velocity(const course *c, double time, vec3 point_a, vec3 point_b);

/* How far a gap along a direction that stands still can dip between two times. */
static inline double course_dip(const course *c, double step)
{
    return c->bend * step * step / 8 * (1 + 0x1p-48);
}

/* The step after which `gap` is used up, when it grows at `rate` and its growth falls by `bend`. */
static inline double course_step_until_used(double gap, double rate, double bend)
{
    double slope = sqrt(rate * rate + 2 * bend * gap) - rate; /* >= 0 */
    return slope > 0 ? 2 * gap / slope : INFINITY;
}

/* A direction may also turn with one of the two: where it is the normal of a face of that one, the gap along it closes
 * as the nearest points approach, while along a direction that stands still the face's corners rise besides. */
typedef enum course_frame { COURSE_STILL, COURSE_WITH_A, COURSE_WITH_B, COURSE_FRAMES } course_frame;

/* m: how far the bodies' origins are apart at most, between two times. */
double course_far(const course *c, double from, double to);

/* The bend of gaps along a direction in that frame, from `from` to `to`. */
double course_bend(const course *c, course_frame frame, double from, double to);

/* An axis of A's frame at one time as it is in A's frame at another, when it belongs to a frame. */
vec3 course_carry(course_frame frame, const course_place *from, vec3 axis_in_a, const course_place *to);

/* A shape as what it sweeps when it turns for ever: a cylinder about the axis of turning, which does not turn; while
 * that is free, so is the shape. One that does not turn stays what it is. `spun`: a shape, the caller's. False: there
 * is none. */
bool course_spin(const toi_mover *m, shape *spun, toi_mover *out);

/* ==== closed forms ==== */

/* The time of impact of two balls, and of a ball and a box, that do not turn towards each other, in
 * closed form. Pure. */

/* ---- two balls, whose centres move along straight lines: a quadratic equation, proven at both ends ---- */

/* True if it settled it: *out as toi_find has it, without the bodies' poses. False for all else, and where they touch
 * at the beginning, graze, or are of a size whose squares leave the range of doubles. */
bool toi_spheres(const toi_mover *a, const toi_mover *b, const toi_request *request, toi_result *out);

/* ---- a ball and a box ---- */

/* True: *out is the answer (toi_find fills in the bodies' poses). False: not such a pair, or one that begins in
 * contact, hardly moves, grazes or touches within rounding only: to be searched. */
bool toi_ball_box(const toi_mover *a, const toi_mover *b, const toi_request *request, toi_result *out);

/* ==== boxes that move ==== */

/* For how long two moving balls, capsules or boxes are certainly apart, by separating axes alone. Pure. */

/* A ball, capsule or box, and a capsule or box, of sizes whose squares are in the range of doubles? */
bool toi_boxes_apply(const course *c);

/* Searches from `from` on, until when they are apart. INFINITY: *out is the answer, FREE as it was, HIT, or NEAR if
 * that is enough (`rough`), with points relative to A's body as it starts. Otherwise a time up to which they are apart,
 * within the tolerance of contact if they are sharp: for the search to go on from. Only if toi_boxes_apply, and for a
 * threshold that is not negative. */
double toi_boxes_march(const course *c, const toi_request *request, double from, bool rough, toi_result *out);

#endif
