/* swept: the motion of a body from one tick to the next, and the predicted one after it. Its swept motion has a leg for
 * each pose that came since the last tick, each straight and turning at a constant rate. Pure readers, but for
 * body_pass; any thread. */
#include "state.h"

static double motion_seconds(int64_t ns)
{
    return 1e-9 * (double)ns;
}

/* By the stamps, or where there are none, by the ticks. */
int64_t body_span_ns(const world *w, const body *b)
{
    if (!b->moved) return 0;
    if (b->as_of) return b->as_of->span_ns;
    int64_t by_stamps = stamps_between(b->before_ns, b->stamp_ns),
            by_ticks = stamps_between(w->last_tick_ns, w->now_ns);
    bool stamped = b->stamp_ns && b->before_ns && by_stamps > 0;
    return stamped ? by_stamps : by_ticks > 0 ? by_ticks : 1000000000;
}

double body_span(const world *w, const body *b)
{
    return motion_seconds(body_span_ns(w, b));
}

/* Two poses hide whole turns: a given angular velocity tells how many. */
static vec3 with_whole_turns(vec3 angular, vec3 given, double span)
{
    static const double TURN = 6.283185307179586;
    vec3 axis = vec_unit(vec_norm2(angular) * span * span > 1e-12 ? angular : given);
    double turns = (vec_dot(given, axis) - vec_dot(angular, axis)) * span / TURN;
    return vec_madd(angular, TURN * floor(turns + 0.5) / span, axis);
}

/* ---- legs ---- */

/* Of a swept motion there may be waypoints: poses that came since the last tick, before the newest one. */
static const pose *waypoint_pose(const body *b, size_t k)
{
    return k == 0 ? &b->before : k <= b->passed.count ? &b->passed.at[k - 1].pose : &b->pose;
}

static int64_t waypoint_ns(const body *b, size_t k)
{
    return k == 0 ? b->before_ns : k <= b->passed.count ? b->passed.at[k - 1].stamp_ns : b->stamp_ns;
}

static size_t legs_of(const body *b)
{
    return b->moved ? b->passed.count + 1 : 1;
}

/* Do the stamps rise all along? Otherwise the legs take the same time each. */
static bool is_stamped(const body *b)
{
    if (!b->before_ns) return false;
    for (size_t k = 0; k < legs_of(b); k++)
        if (waypoint_ns(b, k + 1) <= waypoint_ns(b, k)) return false;
    return true;
}

double body_leg_begins(const body *b, size_t leg)
{
    size_t legs = legs_of(b);
    if (leg == 0 || leg >= legs) return leg == 0 ? 0 : 1;
    if (!is_stamped(b)) return (double)leg / (double)legs;
    return (double)stamps_between(b->before_ns, waypoint_ns(b, leg)) /
           (double)stamps_between(b->before_ns, b->stamp_ns);
}

/* The leg in `span` seconds. */
static motion leg_in(const body *b, size_t leg, double span, bool turns)
{
    if (!b->moved) return (motion){b->pose, VEC_ZERO, VEC_ZERO};
    const pose *from = waypoint_pose(b, leg), *to = waypoint_pose(b, leg + 1);
    motion m = motion_between(*from, *to, span);
    if (!turns) return (motion){{from->p, b->pose.q}, m.linear, VEC_ZERO};
    if (b->speed == SPEED_GIVEN) m.angular = with_whole_turns(m.angular, b->angular, span);
    return m;
}

bool motion_begin_at(motion *m, double late)
{
    if (!(late > 0)) return true;
    if (!(vec_norm(m->angular) * late <= MOTION_ANGLE_MAX)) return false;
    m->start = motion_pose(m, late);
    return true;
}

/* The same motion in another time. */
static motion paced(motion m, double pace)
{
    return (motion){m.start, vec_scale(m.linear, pace), vec_scale(m.angular, pace)};
}

bool body_leg(const world *w, const body *b, size_t leg, double from, double span, motion *m)
{
    double own = body_span(w, b), begins = body_leg_begins(b, leg), share = body_leg_begins(b, leg + 1) - begins;
    *m = paced(leg_in(b, leg, own * share, body_motion_turns(b)), own / span);
    return motion_begin_at(m, (from - begins) * span);
}

void body_pass(world *w, body *b)
{
    if (!b->moved || !w->sweepers) return;
    if (b->passed.count == WAYPOINTS_MAX) {
        for (size_t k = 0; k < WAYPOINTS_MAX / 2; k++) b->passed.at[k] = b->passed.at[2 * k + 1];
        b->passed.count = WAYPOINTS_MAX / 2;
        w->figures.coarse_motions++;
    }
    array_push(&b->passed, ((waypoint){b->pose, b->stamp_ns}));
    b->detours = true;
}

/* ---- predicted motions and boxes ---- */

/* A fixed body stands still, whatever was said of its velocity. */
bool body_has_predicted_motion(const body *b)
{
    return !b->fixed && b->speed != SPEED_NONE;
}

motion body_predicted_motion(const body *b)
{
    motion m = {b->pose, VEC_ZERO, VEC_ZERO};
    if (body_has_predicted_motion(b)) body_velocity(b, &m.linear, &m.angular);
    return m;
}

/* One that has no mode of its own, but meets one that has, moves as it does. */
bool body_motion_turns(const body *b)
{
    return b->ccd != WORLD_CCD_LINEAR;
}

aabb body_motion_bounds(const world *w, const body *b, const collider *s, aabb box)
{
    double span = body_span(w, b);
    if (b->impacts && span > 0) {
        for (size_t k = 0; k < legs_of(b); k++) {
            double share = body_leg_begins(b, k + 1) - body_leg_begins(b, k);
            motion swept = leg_in(b, k, span * share, body_motion_turns(b));
            box = aabb_union(box, motion_bounds(&swept, &s->shape, s->local, span * share));
        }
    }
    return box;
}

aabb body_swept_bounds(const world *w, const body *b, const collider *s, aabb box)
{
    box = past_bounds(b, body_motion_bounds(w, b, s, box));
    if (b->horizon > 0 && !b->fixed) {
        motion predicted = body_predicted_motion(b);
        double reach = s->reach + vec_norm(s->local.p), h = b->horizon;
        double turning =
            b->angular_acceleration > 0 ? b->angular_acceleration * reach : 0; /* no bound: a half-space's */
        double wander = 0.5 * (b->acceleration + turning) * h * h;
        box = aabb_union(box, aabb_grow(motion_bounds(&predicted, &s->shape, s->local, h), wander * (1 + 0x1p-40)));
    }
    return box;
}
