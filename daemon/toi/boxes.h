/* toi_boxes: for how long two moving balls, capsules or boxes are certainly apart, by separating axes alone. Pure. */
#ifndef COLLIDED_TOI_BOXES_H
#define COLLIDED_TOI_BOXES_H

#include "course.h"
#include "narrow/closed/closed.h"
#include "narrow/math/scalar.h"

/* ---- moving boxes ---- */

/* Two boxes along a course: where they are at a time, which of their fifteen axes keeps them apart longest, and
 * whether they overlap. The cores of balls and capsules are boxes, too, without some of their sides. Pure; any
 * thread. All is in the course's frame: world axes, the origin of A's body. Gaps are between the cores. */

typedef struct moving_boxes {
    const course *c;
    box_pair axes; /* at the place that is looked at */
    vec3 half_a, half_b;
    mat3 first_a, first_b; /* the shapes' axes at time 0 */
    vec3 arm_a, arm_b;     /* from the bodies' origins to the shapes', at time 0 */
    double reach;          /* m: the distance of the cores in contact */
    double error;          /* m: of any gap within the span */
    double apart;          /* m: a gap of the cores above it proves them apart, at time 0 */
    double wander;         /* m/s^2 */
} moving_boxes;

typedef struct box_place { /* at a time */
    double time;
    mat3 a, b;
    vec3 origin_a, origin_b; /* of the shapes */
    vec3 body_b;
} box_place;

typedef struct box_axis { /* one that separates at a place */
    vec3 axis;            /* from A to B, unit, the frame's */
    double gap;           /* m, of the cores */
    double rate;          /* m/s: how fast it grows */
    double length;        /* across two edges: sine of the angle between them; otherwise 1 */
    int index;
    double curve; /* m/s^2: by how much its rate grew in the last step that was tried */
    bool turned;  /* it is minus the normal, or minus the product of the two edges */
} box_axis;

typedef struct facing { /* the points of the two that face each other, the frame's */
    vec3 a, b;
} facing;

/* The axes are numbered as in box_pair.c: A's faces, B's faces, then edge i of A with edge j of B at EDGES + 3 i + j.
 */
enum { FACES_B = 3, EDGES = BOX_FACES };

void moving_boxes_init(const course *c, const toi_request *request, moving_boxes *m);
void moving_boxes_place(const moving_boxes *m, double time, box_place *out);

/* m: the least gap that proves them apart at a time. */
static inline double moving_boxes_apart(const moving_boxes *m, double time)
{
    return m->apart + 0.5 * m->wander * time * time * (1 + 4 * UNIT_ROUNDOFF);
}

/* m, within m->error: along an axis of any length, times that. */
double moving_boxes_gap(const moving_boxes *m, const box_place *at, vec3 axis);

/* The axis that separates there, and as its gap and its rate say, longest; `out` may hold the one before. False: none
 * does. m->axes are then those of that place. */
bool moving_boxes_best(moving_boxes *m, const box_place *at, box_axis *out);

/* The same feature's axis at another place. False: it does not separate there. */
bool moving_boxes_follow(moving_boxes *m, const box_place *at, box_axis *n);

/* The points that face each other along an axis that was found at that place. */
facing moving_boxes_facing(const moving_boxes *m, const box_place *at, const box_axis *n);

/* Are they certainly in contact there? `n`: an axis of which the feature was found shortly before; m->axes are then
 * those of that place. */
bool moving_boxes_touch(moving_boxes *m, const box_place *at, const box_axis *n);

/* ---- toi boxes ---- */

/* A ball, capsule or box, and a capsule or box, of sizes whose squares are in the range of doubles? */
bool toi_boxes_apply(const course *c);

/* Searches from `from` on, until when they are apart. INFINITY: *out is the answer, FREE as it was, HIT, or NEAR if
 * that is enough (`rough`), with points relative to A's body as it starts. Otherwise a time up to which they are apart,
 * within the tolerance of contact if they are sharp: for the search to go on from. Only if toi_boxes_apply, and for a
 * threshold that is not negative. */
double toi_boxes_march(const course *c, const toi_request *request, double from, bool rough, toi_result *out);

#endif
