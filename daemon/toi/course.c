/* course: relative poses along a motion, and the bounds that belong to them. Pure; any thread. */
#include "course.h"

#include "narrow/math/scalar.h"
#include "narrow/narrow.h"
#include "narrow/pair/unit_pair.h"

/* The poses that are composed here: two products of quaternions and two rotated points a shape. */
#define POSE_ULPS 48

static double turning(const motion *m)
{
    return vec_norm(m->angular) * (1 + 8 * UNIT_ROUNDOFF);
}

static double course_reach_of(const shape *s, pose local)
{
    if (s->type == SHAPE_HALFSPACE) return vec_norm(local.p);
    return (vec_norm(local.p) + shape_reach(s) + shape_excess(s)) * (1 + 8 * UNIT_ROUNDOFF);
}

static double core_reach_of(const shape *s, pose local)
{
    shape core = *s;
    core.radius = 0;
    return course_reach_of(&core, local);
}

/* Of the core about the axis through its body's origin. */
static double course_radius_of(const shape *s, pose local, const motion *m)
{
    vec3 axis = quat_rotate(quat_conj(m->start.q), direction_of(m->angular));
    return motion_radius(s, local, axis) + shape_excess(s);
}

/* A plane that turns: the height of a point x over it is n.(x - p), whose second derivative is at most
 * w^2 |x - p| + 2 w |x' - p'| + |x'' - p''|. */
static void bound_plane(course *c, pose plane_local, const motion *plane_body, const shape *other, pose other_local,
    const motion *other_body, double span)
{
    double w = turning(plane_body), v = turning(other_body),
           line = vec_norm(vec_sub(other_body->linear, plane_body->linear));
    double arm = vec_norm(plane_local.p), reach = course_reach_of(other, other_local);
    double apart = vec_norm(vec_sub(other_body->start.p, plane_body->start.p)) + line * span + arm + reach;
    double other_radius = v > 0 ? course_radius_of(other, other_local, other_body) : 0;
    double approach = line + w * arm + v * other_radius;
    c->plane_turn2 = w * w;
    c->plane_extent = arm + reach;
    c->plane_bend = 2 * w * approach + w * w * arm + v * v * other_radius;
    c->bend = c->plane_turn2 * apart + c->plane_bend;
    c->speed = approach + w * apart;
}

static void bound(course *c, double span)
{
    const shape *a = c->a, *b = c->b;
    if (a->type == SHAPE_HALFSPACE)
        bound_plane(c, c->local_a, &c->body_a, b, c->local_b, &c->body_b, span);
    else if (b->type == SHAPE_HALFSPACE)
        bound_plane(c, c->local_b, &c->body_b, a, c->local_a, &c->body_a, span);
    else {
        double wa = turning(&c->body_a), wb = turning(&c->body_b);
        c->radius_a = wa > 0 ? course_radius_of(a, c->local_a, &c->body_a) : 0;
        c->radius_b = wb > 0 ? course_radius_of(b, c->local_b, &c->body_b) : 0;
        c->bend = wa * wa * c->radius_a + wb * wb * c->radius_b;
        c->speed = vec_norm(c->body_b.linear) + wa * c->radius_a + wb * c->radius_b;
    }
    c->bend *= 1 + 64 * UNIT_ROUNDOFF;
    c->speed *= 1 + 64 * UNIT_ROUNDOFF;
}

static double course_slack_of(const course *c, const motion *a, const motion *b, double span)
{
    double ra = c->reach_a, rb = c->reach_b;
    double far = vec_norm(c->body_b.start.p) + span * (vec_norm(a->linear) + vec_norm(b->linear));
    bool plane = c->a->type == SHAPE_HALFSPACE || c->b->type == SHAPE_HALFSPACE;
    double turned = plane ? ra + rb + far : 0; /* where a plane's normal is off, all heights over it are */
    return motion_error(&c->body_a, span, ra + turned) + motion_error(&c->body_b, span, rb + turned) +
           POSE_ULPS * UNIT_ROUNDOFF * (ra + rb + far);
}

/* Most shapes lie in their bodies' own frames. */
static pose shape_pose(const pose *body, const pose *local)
{
    vec3 turned = {local->q.x, local->q.y, local->q.z};
    bool own = vec_greatest(local->p) == 0 && vec_greatest(turned) == 0 && local->q.w == 1;
    return own ? *body : pose_mul(*body, *local);
}

static course_place course_place_of(const course *c, const pose *body_a, const pose *body_b)
{
    pose shape_a = shape_pose(body_a, &c->local_a);
    mat3 world_of_a = quat_matrix(quat_unit(shape_a.q));
    pose relative = pose_relative(shape_a, shape_pose(body_b, &c->local_b));
    relative.q = quat_unit(relative.q);
    return (course_place){relative, world_of_a, shape_a.p};
}

bool course_bounds(course *c, const toi_mover *a, const toi_mover *b, double span)
{
    *c = (course){.a = a->shape, .b = b->shape, .local_a = a->local, .local_b = b->local, .span = span};
    c->body_a = (motion){{VEC_ZERO, a->motion.start.q}, VEC_ZERO, a->motion.angular};
    c->body_b = (motion){{vec_sub(b->motion.start.p, a->motion.start.p), b->motion.start.q},
        vec_sub(b->motion.linear, a->motion.linear), b->motion.angular};
    c->spin_a = motion_spin_of(c->body_a.angular);
    c->spin_b = motion_spin_of(c->body_b.angular);
    c->straight = c->spin_a.speed == 0 && c->spin_b.speed == 0;
    bool planes = a->shape->type == SHAPE_HALFSPACE && b->shape->type == SHAPE_HALFSPACE;
    if (planes && !c->straight) return false;
    c->reach_a = course_reach_of(a->shape, a->local);
    c->reach_b = course_reach_of(b->shape, b->local);
    c->core_a = core_reach_of(a->shape, a->local);
    c->core_b = core_reach_of(b->shape, b->local);
    bound(c, span);
    c->slack = course_slack_of(c, &a->motion, &b->motion, span);
    return true;
}

void course_make_places(course *c)
{
    c->first = course_place_of(c, &c->body_a.start, &c->body_b.start);
    if (c->straight) c->rate = mat_tmul(c->first.world_of_a, c->body_b.linear);
}

bool course_init(course *c, const toi_mover *a, const toi_mover *b, double span)
{
    if (!course_bounds(c, a, b, span)) return false;
    course_make_places(c);
    return true;
}

course_place course_at(const course *c, double time)
{
    if (time == 0) return c->first;
    if (c->straight) {
        course_place at = c->first;
        at.b_in_a.p = vec_madd(at.b_in_a.p, time, c->rate);
        return at;
    }
    pose body_a = {VEC_ZERO, motion_spun(c->spin_a, c->body_a.start.q, time)};
    pose body_b = {
        vec_madd(c->body_b.start.p, time, c->body_b.linear), motion_spun(c->spin_b, c->body_b.start.q, time)};
    return course_place_of(c, &body_a, &body_b);
}

/* The balls' centres go along a line, which passes each other's at |from x velocity| / speed: good to some ulp of the
 * way, however far it is. All rounding together is far less than BALL_SLACK. */
#define BALL_SLACK 0x1p-30

/* Of doubles, for fourth powers. */
static bool course_in_range(double x)
{
    return x > 0x1p-200 && x < 0x1p200;
}

double course_balls_meet(const course *c, double target, double wander)
{
    if (c->a->type == SHAPE_HALFSPACE || c->b->type == SHAPE_HALFSPACE) return 0;
    vec3 from = c->body_b.start.p, velocity = c->body_b.linear;
    bool moves = vec_greatest(velocity) > 0;
    if (!course_in_range(vec_greatest(from)) || (moves && !course_in_range(vec_greatest(velocity)))) return 0;
    double far = vec_norm(from), speed = vec_norm(velocity), reach = c->reach_a + c->reach_b + max_of(target, 0);
    reach += 0.5 * wander * c->span * c->span;
    reach += BALL_SLACK * (reach + far + speed * c->span);
    if (!(far > reach)) return 0;
    double approach = vec_dot(from, velocity), spare = (far - reach) * (far + reach);
    double aside = vec_norm(vec_cross(from, velocity)), grazing = reach * speed;
    if (approach >= 0 || !(aside < grazing)) return INFINITY;
    double square = (grazing - aside) * (grazing + aside);
    double time = spare / (sqrt(square) - approach);
    return time < c->span ? time : INFINITY;
}

double course_separation(const course *c, const course_place *at, vec3 direction)
{
    vec3 axis = direction_again(mat_tmul(at->world_of_a, direction));
    return narrow_separation(c->a, c->b, &at->b_in_a, axis, NULL, NULL);
}

/* In a frame that turns at w about its body's origin, a point x of the other one's core has the acceleration
 * |x'' - 2 w x x' - w x (x' ...)| <= |x''| + 2 w |x'| + w^2 |x|. With x = p + y, p the other body's origin, y turns by
 * v - w there, and has |(v - w) x (v x y) - w x ((v - w) x y)|: what turns as one body has none. */
static double bend_with(
    const motion *frame, const motion *other, double other_radius, double other_core, double far, double line)
{
    double w = turning(frame), v = turning(other);
    double against = vec_norm(vec_sub(other->angular, frame->angular)) * (1 + 8 * UNIT_ROUNDOFF);
    double apiece = w * w * other_core + 2 * w * v * other_radius + v * v * other_radius;
    double together = against * (v * other_radius + w * other_core);
    double bend = w * w * far + 2 * w * line + min_of(apiece, together);
    return bend * (1 + 64 * UNIT_ROUNDOFF);
}

double course_far(const course *c, double from, double to)
{
    double time = 0.5 * (from + to), line = vec_norm(c->body_b.linear);
    return vec_norm(vec_madd(c->body_b.start.p, time, c->body_b.linear)) + line * 0.5 * (to - from);
}

double course_bend(const course *c, course_frame frame, double from, double to)
{
    if (frame == COURSE_STILL && c->plane_turn2 == 0) return c->bend;
    double line = vec_norm(c->body_b.linear), apart = course_far(c, from, to);
    if (frame == COURSE_STILL)
        return (c->plane_turn2 * (apart + c->plane_extent) + c->plane_bend) * (1 + 64 * UNIT_ROUNDOFF);
    return frame == COURSE_WITH_A ? bend_with(&c->body_a, &c->body_b, c->radius_b, c->core_b, apart, line)
                                  : bend_with(&c->body_b, &c->body_a, c->radius_a, c->core_a, apart, line);
}

vec3 course_carry(course_frame frame, const course_place *from, vec3 axis_in_a, const course_place *to)
{
    if (frame == COURSE_WITH_A) return axis_in_a;
    if (frame == COURSE_STILL) return direction_again(mat_tmul(to->world_of_a, mat_mul(from->world_of_a, axis_in_a)));
    mat3 was = quat_matrix(from->b_in_a.q), is = quat_matrix(to->b_in_a.q);
    return direction_again(mat_mul(is, mat_tmul(was, axis_in_a)));
}

vec3 course_velocity(const course *c, double time, vec3 point_a, vec3 point_b)
{
    vec3 origin_b = vec_madd(c->body_b.start.p, time, c->body_b.linear);
    vec3 turn_b = vec_cross(c->body_b.angular, vec_sub(point_b, origin_b));
    vec3 turn_a = vec_cross(c->body_a.angular, point_a);
    return vec_sub(vec_add(c->body_b.linear, turn_b), turn_a);
}

/* ---- spun ---- */

/* The least rotation that takes the z axis, either way, to that of a unit vector: what is spun is the same upside down,
 * and near -z the sum below would be rounding alone. */
static quat quat_to_line(vec3 axis)
{
    if (axis.z < 0) axis = vec_neg(axis);
    vec3 half = direction_of(vec(axis.x, axis.y, axis.z + 1));
    return quat_unit((quat){half.z, -half.y, half.x, 0});
}

/* How far a shape of vertices reaches from the axis through its body's origin, and along it. */
static void spin_vertices(const hull *h, pose local, vec3 axis, double *radius, double *along)
{
    double most = 0, far = 0;
    mat3 turn = quat_matrix(quat_unit(local.q));
    for (uint32_t k = 0; k < h->vertex_count; k++) {
        vec3 v = vec_add(mat_mul(turn, hull_vertex(h, k)), local.p);
        most = max_of(most, vec_norm2(vec_cross(axis, v)));
        far = max_of(far, fabs(vec_dot(axis, v)));
    }
    *radius = sqrt(most);
    *along = far;
}

bool course_spin(const toi_mover *m, shape *spun, toi_mover *out)
{
    const shape *s = m->shape;
    const motion *body = &m->motion;
    *out = (toi_mover){.shape = spun, .local = m->local, .motion = {body->start, body->linear, VEC_ZERO}};
    *spun = *s;
    if (vec_greatest(body->angular) == 0) return true;
    if (s->type == SHAPE_HALFSPACE) return false;
    vec3 axis = direction_of(body->angular), axis_in_body = quat_rotate(quat_conj(body->start.q), axis);
    vec3 in_shape = quat_rotate(quat_conj(m->local.q), axis_in_body);
    vec3 h = s->half;
    bool sized = s->type <= SHAPE_ELLIPSOID;
    double along = sized ? fabs(in_shape.x) * h.x + fabs(in_shape.y) * h.y + fabs(in_shape.z) * h.z : shape_reach(s);
    double off = fabs(vec_dot(m->local.p, axis_in_body));
    double slack = 64 * UNIT_ROUNDOFF * course_reach_of(s, m->local);
    double radius = motion_radius(s, m->local, axis_in_body), length = along + off;
    if (s->hull) spin_vertices(s->hull, m->local, axis_in_body, &radius, &length);
    radius += shape_excess(s) + slack;
    length += shape_excess(s) + slack;
    *spun = (shape){.type = SHAPE_CYLINDER, .radius = s->radius, .half = {radius, radius, length}};
    out->local = (pose){VEC_ZERO, quat_mul(quat_conj(body->start.q), quat_to_line(axis))};
    return true;
}
