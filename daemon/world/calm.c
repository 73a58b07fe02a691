/* calm: bodies whose poses change nothing. A body that is in no pair, and of which nobody asks more than who meets it,
 * has a room: as long as its position is in there, the boxes of its shapes are inside the fat ones, and a tick has
 * nothing to do but to see that it is so. Its shapes stay behind: whoever asks for their poses gets them by solid_pose.
 *
 * The room is what the fat boxes leave around the tight ones, each taken where it was looked at last. Where the body
 * has turned since, by the quaternions q and q0, no point at a distance r of its origin has moved by more than
 * 2 |q - q0| r: with the angle a between the two, |q - q0| = 2 sin(a / 4), and the point moves by at most
 * 2 r sin(a / 2) = 4 r sin(a / 4) cos(a / 4). Tick thread. */
#include "state.h"

#include "broad/fbox.h"

/* Rounding of boxes at the one pose and at the other, as a share of all that they are made of: much more than it is. */
static const double ROUNDING = 0x1p-44;

/* The quaternion is kept in floats; each component errs by at most 2^-25, and all together by twice that. */
static const double AS_FLOATS = 2.5 * 0x1p-24;

static bool may_be_calm(const body *b)
{
    return !b->pair_count && !b->impacts && !(b->horizon > 0) && !b->deadline_ns && !b->stale && !b->held;
}

static void narrow_room(const body *b, const broad_room *room, double reach, aabb *all)
{
    const double p[3] = {b->pose.p.x, b->pose.p.y, b->pose.p.z};
    double *lo = &all->lo.x, *hi = &all->hi.x;
    for (int k = 0; k < 3; k++) {
        double slack = ROUNDING * (fabs(p[k]) + reach + b->widen) + AS_FLOATS * reach;
        lo[k] = fmax(lo[k], p[k] - room->down[k] + slack);
        hi[k] = fmin(hi[k], p[k] + room->up[k] - slack);
    }
}

void calm_find(const world *w, body *b)
{
    aabb all = {{-INFINITY, -INFINITY, -INFINITY}, {INFINITY, INFINITY, INFINITY}};
    double reach = 0;
    b->is_calm = false;
    if (!may_be_calm(b)) return;
    for (size_t i = 0; i < b->shape_count; i++) {
        const solid *s = &w->solids.at[b->shapes[i]];
        reach = fmax(reach, s->reach + vec_norm(s->local.p));
    }
    for (size_t i = 0; i < b->shape_count; i++) {
        broad_room room;
        aabb box = aabb_grow(w->solids.at[b->shapes[i]].box, b->widen);
        if (!broad_room_of(w->broad, b->shapes[i], box, &room) || !room.slim) return;
        narrow_room(b, &room, reach, &all);
    }
    fbox inward = fbox_inward(all);
    for (int k = 0; k < 3; k++) {
        b->calm_lo[k] = inward.lo[k];
        b->calm_hi[k] = inward.hi[k];
    }
    const double q[4] = {b->pose.q.w, b->pose.q.x, b->pose.q.y, b->pose.q.z};
    for (int k = 0; k < 4; k++) b->calm_q[k] = (float)q[k];
    b->calm_reach = float_up(2 * (1 + 0x1p-20) * reach);
    b->is_calm = calm_holds(b, &b->pose);
}
