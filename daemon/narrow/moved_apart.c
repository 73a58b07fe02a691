/* moved_apart: B is moved along the axis by twice the overlap that it proves, which leaves a gap; the axis of that gap
 * is known for certain, and it is off from the one that is looked for by as much as the surface bends over so short a
 * way. So the overlap along it is about the square of the overlap before, over the radius of the bend. */
#include "moved_apart.h"

#include "gjk.h"
#include "scalar.h"

enum { ROUNDS_MAX = 8 };

#define ALMOST_NOTHING 0x1p-10 /* of the size: deeper overlaps have other nearest faces */

void moved_apart_raise(const unit_pair *p, span *s)
{
    for (int k = 0; k < ROUNDS_MAX && s->lo < 0 && s->hi - s->lo > p->error; k++) {
        if (-s->lo > ALMOST_NOTHING * p->size) return;
        unit_pair moved = *p;
        moved.b_in_a.t = vec_madd(p->b_in_a.t, max_of(-2 * s->lo, 4 * p->error), s->axis);
        const narrow_goal measure = {p->error, p->error, INFINITY, -INFINITY, -INFINITY, INFINITY, false};
        gjk_result r;
        gjk_distance(&moved, &measure, s->axis, &r);
        s->iterations += r.span.iterations;
        if (r.state != GJK_APART) return;
        double proved = vec_dot(r.span.axis, unit_pair_nearest_along(p, r.span.axis).w);
        if (!(proved > s->lo)) return;
        s->lo = min_of(proved, s->hi);
        s->axis = r.span.axis;
    }
}
