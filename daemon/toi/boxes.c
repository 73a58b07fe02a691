/* toi_boxes: the march of toi.c with the fifteen axes of two boxes in place of distances. Each step takes the axis that
 * keeps them apart longest, as its gap and its rate say, and proves by the chord certificate how far it does. Cores of
 * balls and capsules are boxes, too. Pure; any thread.
 *
 * All is in the course's frame: world axes, the origin of A's body. */
#include "course.h"

#include "narrow/closed/closed.h"
#include "narrow/math/scalar.h"

/* ---- moving boxes ---- */

/* Two boxes along a course: where they are at a time, which of their fifteen axes keeps them apart longest, and
 * whether they overlap. The cores of balls and capsules are boxes, too, without some of their sides. Gaps are between
 * the cores. */

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

/* Squared sine of an angle between two edges that makes no axis: the faces have it. */
#define EDGES_PARALLEL 0x1p-40

/* Below it the two are taken for parallel where an overlap is to be proven. */
#define EDGES_ALIKE 0x1p-48

/* ---- places ---- */

static mat3 mat_mat(mat3 a, mat3 b)
{
    return (mat3){mat_mul(a, b.x), mat_mul(a, b.y), mat_mul(a, b.z)};
}

static void moving_boxes_turn(motion_spin spin, double time, mat3 *axes, vec3 *arm)
{
    if (spin.speed == 0 || time == 0) return;
    mat3 turned = motion_turn(spin, time);
    *axes = mat_mat(turned, *axes);
    if (vec_greatest(*arm) > 0) *arm = mat_mul(turned, *arm);
}

static void moving_boxes_place(const moving_boxes *m, double time, box_place *out)
{
    vec3 arm_b = m->arm_b;
    out->time = time;
    out->a = m->first_a, out->b = m->first_b;
    out->origin_a = m->arm_a;
    moving_boxes_turn(m->c->spin_a, time, &out->a, &out->origin_a);
    moving_boxes_turn(m->c->spin_b, time, &out->b, &arm_b);
    out->body_b = vec_madd(m->c->body_b.start.p, time, m->c->body_b.linear);
    out->origin_b = vec_add(out->body_b, arm_b);
}

static double moving_boxes_reach_along(const mat3 *axes, vec3 half, vec3 axis)
{
    return half.x * fabs(vec_dot(axes->x, axis)) + half.y * fabs(vec_dot(axes->y, axis)) +
           half.z * fabs(vec_dot(axes->z, axis));
}

/* m: the least gap that proves them apart at a time. */
static inline double moving_boxes_apart(const moving_boxes *m, double time)
{
    return m->apart + 0.5 * m->wander * time * time * (1 + 4 * UNIT_ROUNDOFF);
}

/* m, within m->error: along an axis of any length, times that. */
static double moving_boxes_gap(const moving_boxes *m, const box_place *at, vec3 axis)
{
    return vec_dot(axis, vec_sub(at->origin_b, at->origin_a)) - moving_boxes_reach_along(&at->a, m->half_a, axis) -
           moving_boxes_reach_along(&at->b, m->half_b, axis);
}

/* ---- axes ---- */

/* Velocity of B relative to A, at a point of A's axes and from A's origin: line + turn x point. */
typedef struct field {
    double line[3], turn[3];
} field;

static field field_at(const moving_boxes *m, const box_place *at)
{
    vec3 wa = m->c->body_a.angular, wb = m->c->body_b.angular, w = vec_sub(wb, wa);
    vec3 line = vec_add(vec_sub(m->c->body_b.linear, vec_cross(wb, at->body_b)), vec_cross(w, at->origin_a));
    vec3 l = mat_tmul(at->a, line), t = mat_tmul(at->a, w);
    return (field){{l.x, l.y, l.z}, {t.x, t.y, t.z}};
}

/* One of the fifteen, numbered as in box_pair.c: A's faces, B's faces, then edge i of A with edge j of B. */
typedef struct choice {
    int index;
    double gap, rate, until; /* until: s; when what is left of the gap is used up */
} choice;

static inline void moving_boxes_offer(choice *best, double left, double gap, double rate, int index)
{
    double until = rate < 0 ? left / -rate : INFINITY;
    if (until > best->until) *best = (choice){index, gap, rate, until};
}

/* The corner of B that is nearest along A's face i, without its component i, and how fast it moves off the face. */
static inline double rate_of_face_a(const box_pair *x, const field *f, int i)
{
    int h = (i + 1) % 3, k = (i + 2) % 3;
    double side = x->t[i] < 0 ? -1 : 1, ph = x->t[h], pk = x->t[k];
    for (int j = 0; j < 3; j++) {
        double b = copysign(x->b[j], side * x->r[i][j]);
        ph -= b * x->r[h][j], pk -= b * x->r[k][j];
    }
    return side * (f->line[i] + f->turn[h] * pk - f->turn[k] * ph);
}

static inline double dot_column(const box_pair *x, const double v[3], int j)
{
    return v[0] * x->r[0][j] + v[1] * x->r[1][j] + v[2] * x->r[2][j];
}

static inline double rate_of_face_b(const box_pair *x, const field *f, int j)
{
    double side = x->u[j] < 0 ? -1 : 1, p[3], v[3];
    for (int i = 0; i < 3; i++) p[i] = copysign(x->a[i], side * x->r[i][j]);
    for (int i = 0; i < 3; i++) {
        int h = (i + 1) % 3, k = (i + 2) % 3;
        v[i] = f->line[i] + f->turn[h] * p[k] - f->turn[k] * p[h];
    }
    return side * dot_column(x, v, j);
}

static inline void offer_faces_of_a(const box_pair *x, const field *f, double apart, choice *best)
{
    for (int i = 0; i < 3; i++) {
        double gap = box_face_of_a(x, i);
        if (gap > apart) moving_boxes_offer(best, gap - apart, gap, rate_of_face_a(x, f, i), i);
    }
}

static inline void offer_faces_of_b(const box_pair *x, const field *f, double apart, choice *best)
{
    for (int j = 0; j < 3; j++) {
        double gap = box_face_of_b(x, j);
        if (gap > apart) moving_boxes_offer(best, gap - apart, gap, rate_of_face_b(x, f, j), FACES_B + j);
    }
}

/* e_i x r_j, from A towards B; it has no component i. */
typedef struct across {
    double h, k;
} across;

static inline across across_of(const box_pair *x, int i, int j)
{
    int h = (i + 1) % 3, k = (i + 2) % 3;
    across n = {-x->r[k][j], x->r[h][j]};
    return n.h * x->t[h] + n.k * x->t[k] < 0 ? (across){-n.h, -n.k} : n;
}

/* Where A's edge is at `along` of its direction; times the length of the axis. */
static inline double rate_of_edge(const box_pair *x, const field *f, int i, across n, double along)
{
    int h = (i + 1) % 3, k = (i + 2) % 3;
    double ph = copysign(x->a[h], n.h), pk = copysign(x->a[k], n.k);
    return n.h * (f->line[h] + f->turn[k] * along - f->turn[i] * pk) +
           n.k * (f->line[k] + f->turn[i] * ph - f->turn[h] * along);
}

/* By the rates of the edges' middles. Rounding is the same however short the axis is: it is taken off before the
 * division. */
static inline void offer_edges(const box_pair *x, const field *f, double apart, double error, choice *best)
{
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++) {
            box_edge_axis e = box_edge_axis_of(x, i, j);
            if (!(e.separation > 0) || !(e.norm2 > EDGES_PARALLEL)) continue;
            double length = sqrt(e.norm2), gap = e.separation - error, left = gap - apart * length;
            if (!(left > 0)) continue;
            moving_boxes_offer(
                best, left, gap / length, rate_of_edge(x, f, i, across_of(x, i, j), 0), EDGES + 3 * i + j);
        }
}

/* The point of A's edge i that is nearest to the line of B's edge j, from the edge's middle. */
static double moving_boxes_nearest_on_edge(const box_pair *x, int i, int j, across n)
{
    int h = (i + 1) % 3, k = (i + 2) % 3;
    double w[3] = {x->t[0], x->t[1], x->t[2]}, column[3] = {x->r[0][j], x->r[1][j], x->r[2][j]};
    w[h] -= copysign(x->a[h], n.h), w[k] -= copysign(x->a[k], n.k);
    for (int m = 1; m <= 2; m++) {
        int l = (j + m) % 3;
        double b = copysign(x->b[l], n.h * x->r[h][l] + n.k * x->r[k][l]);
        for (int c = 0; c < 3; c++) w[c] -= b * x->r[c][l];
    }
    double cosine = column[i], sine2 = column[h] * column[h] + column[k] * column[k];
    double along_b = w[0] * column[0] + w[1] * column[1] + w[2] * column[2];
    return clamp_to((w[i] - cosine * along_b) / sine2, x->a[i]);
}

static void axes_at(const box_place *at, box_pair *x)
{
    const vec3 a[3] = {at->a.x, at->a.y, at->a.z}, b[3] = {at->b.x, at->b.y, at->b.z};
    vec3 between = vec_sub(at->origin_b, at->origin_a);
    for (int i = 0; i < 3; i++) {
        x->t[i] = vec_dot(a[i], between);
        x->u[i] = vec_dot(b[i], between);
        for (int j = 0; j < 3; j++) x->r[i][j] = vec_dot(a[i], b[j]), x->abs[i][j] = fabs(x->r[i][j]);
    }
}

/* What the choice is in the frame. */
static box_axis taken(const box_pair *x, const field *f, const box_place *at, choice c)
{
    box_axis n = {.gap = c.gap, .rate = c.rate, .length = 1, .index = c.index};
    if (c.index < FACES_B) {
        n.axis = mat_column(&at->a, c.index);
        n.turned = x->t[c.index] < 0;
        if (n.turned) n.axis = vec_neg(n.axis);
    } else if (c.index < EDGES) {
        n.axis = mat_column(&at->b, c.index - FACES_B);
        n.turned = x->u[c.index - FACES_B] < 0;
        if (n.turned) n.axis = vec_neg(n.axis);
    } else {
        int i = (c.index - EDGES) / 3, j = (c.index - EDGES) % 3;
        across e = across_of(x, i, j);
        n.length = sqrt(e.h * e.h + e.k * e.k);
        n.turned = e.h * -x->r[(i + 2) % 3][j] + e.k * x->r[(i + 1) % 3][j] < 0;
        vec3 along =
            vec_add(vec_scale(mat_column(&at->a, (i + 1) % 3), e.h), vec_scale(mat_column(&at->a, (i + 2) % 3), e.k));
        n.axis = vec_scale(along, 1 / n.length);
        n.rate = rate_of_edge(x, f, i, e, moving_boxes_nearest_on_edge(x, i, j, e)) / n.length;
    }
    return n;
}

/* The axis that separates there, and as its gap and its rate say, longest; `out` may hold the one before. False: none
 * does. m->axes are then those of that place. */
static bool moving_boxes_best(moving_boxes *m, const box_place *at, box_axis *out)
{
    double apart = moving_boxes_apart(m, at->time);
    axes_at(at, &m->axes);
    field f = field_at(m, at);
    choice best = {.until = -1, .gap = -INFINITY};
    bool ball = m->c->a->type == SHAPE_SPHERE; /* it has no sides, and none that would turn with it */
    if (!ball) offer_faces_of_a(&m->axes, &f, apart, &best);
    offer_faces_of_b(&m->axes, &f, apart, &best);
    if (!ball) offer_edges(&m->axes, &f, apart, m->error, &best);
    if (best.until < 0) return false;
    double curve = best.index == out->index ? out->curve : 0;
    *out = taken(&m->axes, &f, at, best);
    out->curve = curve;
    return true;
}

/* The same feature's axis at another place. False: it does not separate there. */
static bool moving_boxes_follow(moving_boxes *m, const box_place *at, box_axis *n)
{
    box_pair *x = &m->axes;
    axes_at(at, x);
    field f = field_at(m, at);
    choice same = {.index = n->index};
    if (n->index < FACES_B) {
        same.gap = box_face_of_a(x, n->index);
        same.rate = rate_of_face_a(x, &f, n->index);
    } else if (n->index < EDGES) {
        same.gap = box_face_of_b(x, n->index - FACES_B);
        same.rate = rate_of_face_b(x, &f, n->index - FACES_B);
    } else {
        box_edge_axis e = box_edge_axis_of(x, (n->index - EDGES) / 3, (n->index - EDGES) % 3);
        if (!(e.norm2 > EDGES_PARALLEL)) return false;
        same.gap = (e.separation - m->error) / sqrt(e.norm2);
    }
    double curve = n->curve;
    *n = taken(x, &f, at, same);
    n->curve = curve;
    return n->gap > moving_boxes_apart(m, at->time);
}

/* Do the boxes overlap along all fifteen axes by more than rounding? The cross axis of nearly parallel edges is skipped
 * if turning one edge until both are parallel moves no point by more than the slack of the other axes. */
static bool moving_boxes_overlap(const box_pair *x, double error)
{
    double size = 0, room = error;
    for (int i = 0; i < 3; i++) size += x->a[i] + x->b[i] + fabs(x->t[i]);
    double blur = 256 * UNIT_ROUNDOFF * size;
    double most = -INFINITY;
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++) {
            box_edge_axis e = box_edge_axis_of(x, i, j);
            if (e.norm2 < EDGES_ALIKE)
                room = max_of(room, error + 8 * sqrt(e.norm2) * size);
            else
                most = max_of(most, e.separation);
        }
    for (int i = 0; i < 3; i++) most = max_of(most, max_of(box_face_of_a(x, i), box_face_of_b(x, i)));
    return most < -blur - room;
}

static vec3 moving_boxes_clamped(const double p[3], const double half[3])
{
    return vec(clamp_to(p[0], half[0]), clamp_to(p[1], half[1]), clamp_to(p[2], half[2]));
}

static vec3 moving_boxes_out_of(const mat3 *axes, vec3 origin, vec3 point)
{
    return vec_add(origin, mat_mul(*axes, point));
}

/* A corner of the one that is nearest along the axis; the nearest point of the other to it; and back again, because of
 * an edge or a face that is nearest any corner may have been taken. */
static facing facing_face(const box_pair *x, const box_place *at, const box_axis *n)
{
    bool of_a = n->index < FACES_B;
    double p[3], q[3];
    vec3 on_a, on_b;
    if (of_a) {
        double side = x->t[n->index] < 0 ? -1 : 1;
        for (int j = 0; j < 3; j++) q[j] = -copysign(x->b[j], side * x->r[n->index][j]);
    } else {
        int j = n->index - FACES_B;
        double side = x->u[j] < 0 ? -1 : 1;
        for (int i = 0; i < 3; i++) p[i] = copysign(x->a[i], side * x->r[i][j]);
    }
    for (int k = 0; k < 2; k++) {
        if (of_a == (k == 0)) {
            for (int i = 0; i < 3; i++) p[i] = x->t[i] + x->r[i][0] * q[0] + x->r[i][1] * q[1] + x->r[i][2] * q[2];
            vec_to(on_a = moving_boxes_clamped(p, x->a), p);
        } else {
            for (int j = 0; j < 3; j++) q[j] = dot_column(x, p, j) - x->u[j];
            vec_to(on_b = moving_boxes_clamped(q, x->b), q);
        }
    }
    return (facing){moving_boxes_out_of(&at->a, at->origin_a, on_a), moving_boxes_out_of(&at->b, at->origin_b, on_b)};
}

static facing facing_edges(const box_pair *x, const box_place *at, const box_axis *n)
{
    int i = (n->index - EDGES) / 3, j = (n->index - EDGES) % 3, h = (i + 1) % 3, k = (i + 2) % 3;
    across e = across_of(x, i, j);
    double a[3], b[3], w[3];
    a[i] = moving_boxes_nearest_on_edge(x, i, j, e), a[h] = copysign(x->a[h], e.h), a[k] = copysign(x->a[k], e.k);
    for (int l = 0; l < 3; l++) {
        w[l] = a[l] - x->t[l];
        b[l] = -copysign(x->b[l], e.h * x->r[h][l] + e.k * x->r[k][l]);
    }
    b[j] = clamp_to(dot_column(x, w, j), x->b[j]);
    return (facing){
        moving_boxes_out_of(&at->a, at->origin_a, vec_from(a)), moving_boxes_out_of(&at->b, at->origin_b, vec_from(b))};
}

/* The points that face each other along an axis that was found at that place. */
static facing moving_boxes_facing(const moving_boxes *m, const box_place *at, const box_axis *n)
{
    return n->index < EDGES ? facing_face(&m->axes, at, n) : facing_edges(&m->axes, at, n);
}

/* Are they certainly in contact there? Of sharp boxes by their overlap, of rounded ones by two points that are near
 * enough. `n`: an axis of which the feature was found shortly before; m->axes are then those of that place. */
static bool moving_boxes_touch(moving_boxes *m, const box_place *at, const box_axis *n)
{
    axes_at(at, &m->axes);
    if (m->reach == 0) return moving_boxes_overlap(&m->axes, m->error);
    facing f = moving_boxes_facing(m, at, n);
    return vec_norm(vec_sub(f.b, f.a)) <= m->reach - m->error;
}

/* Most shapes lie at their bodies' origins. */
static void moving_boxes_start(const motion *body, const pose *local, mat3 *axes, vec3 *arm)
{
    bool off = vec_greatest(local->p) > 0;
    *axes = quat_matrix(quat_unit(quat_mul(body->start.q, local->q)));
    *arm = off ? quat_rotate(body->start.q, local->p) : VEC_ZERO;
}

static void moving_boxes_init(const course *c, const toi_request *request, moving_boxes *m)
{
    const shape *a = c->a, *b = c->b;
    m->c = c;
    m->wander = request->wander;
    m->half_a = shape_core_half(a), m->half_b = shape_core_half(b);
    vec_to(m->half_a, m->axes.a);
    vec_to(m->half_b, m->axes.b);
    moving_boxes_start(&c->body_a, &c->local_a, &m->first_a, &m->arm_a);
    moving_boxes_start(&c->body_b, &c->local_b, &m->first_b, &m->arm_b);
    double far = vec_norm(c->body_b.start.p) + c->span * vec_norm(c->body_b.linear);
    m->reach = request->threshold + a->radius + b->radius;
    m->error = 2 * c->slack + 64 * UNIT_ROUNDOFF * (c->reach_a + c->reach_b + far);
    m->apart = m->reach + m->error;
}

/* ---- toi boxes ---- */

enum { STEPS_MAX = 96, TRIES = 3 };

static const double FOLLOWED = 0.03;  /* of the reaches: with a smaller gap an axis is kept */
static const double DIP_SHARE = 0.75; /* of the gap that a step may use up by its bend */

/* ---- steps ---- */

/* The axis e x r across two edges, which both turn, is as long as the sine of the angle between them. Let f be its
 * product with the difference q of two corners. Then |f"| <= W^2 |q| + 2 W |q'| + |q"|, with W the sum of the angular
 * speeds; and the length, by which what counts as apart is multiplied, exceeds its chord by no more than W^2 h^2 / 8.
 * So a chord of gaps times lengths that stays above the sum proves them apart, however the length changes. */
static double bend_across(const moving_boxes *m, const box_axis *n, double from, double to)
{
    double w = m->c->spin_a.speed + m->c->spin_b.speed, apart = moving_boxes_apart(m, to);
    double far = course_far(m->c, from, to) + m->c->core_a + m->c->core_b;
    return (w * w * (far + apart) + 2 * w * m->c->speed + m->c->bend) / n->length * (1 + 64 * UNIT_ROUNDOFF);
}

static double own_bend(const moving_boxes *m, const box_axis *n, double from, double to)
{
    if (n->index >= EDGES) return bend_across(m, n, from, to);
    return course_bend(m->c, n->index < FACES_B ? COURSE_WITH_A : COURSE_WITH_B, from, to);
}

/* What is left of the gap at `to` along the axis of the same feature; across edges: times the ratio of the lengths. */
static double own_spare(const moving_boxes *m, const box_axis *n, const box_place *to)
{
    vec3 axis;
    double length = 1;
    if (n->index >= EDGES) {
        axis = vec_cross(mat_column(&to->a, (n->index - EDGES) / 3), mat_column(&to->b, (n->index - EDGES) % 3));
        length = vec_norm(axis);
    } else {
        axis = n->index < FACES_B ? mat_column(&to->a, n->index) : mat_column(&to->b, n->index - FACES_B);
    }
    double gap = moving_boxes_gap(m, to, n->turned ? vec_neg(axis) : axis) - (n->index >= EDGES ? m->error : 0);
    return (gap - moving_boxes_apart(m, to->time) * length) / n->length;
}

static double dip_of(double bend, double step)
{
    return bend * step * step / 8 * (1 + 0x1p-48);
}

/* What is certainly kept of the gap over a step, and at its end: along the axis that turns with its feature, or along
 * the one that is fixed. */
static double moving_boxes_spare_after(const moving_boxes *m, const box_place *from, box_axis *n, const box_place *to)
{
    double step = to->time - from->time, spare = n->gap - moving_boxes_apart(m, to->time), own = own_spare(m, n, to);
    double kept = min_of(own, spare) - dip_of(own_bend(m, n, from->time, to->time), step);
    n->curve = 2 * (own - spare - n->rate * step) / (step * step);
    if (kept > 0 || m->c->straight) return kept;
    double still =
        min_of(moving_boxes_gap(m, to, n->axis) - moving_boxes_apart(m, to->time), spare) - dip_of(m->c->bend, step);
    return max_of(kept, still);
}

static double moving_boxes_proposed_step(
    const moving_boxes *m, const box_place *at, const box_axis *n, double spare, double aim, double left)
{
    double rate = n->rate - m->wander * at->time;
    double step = min_of(course_step_until_used(spare - aim, rate, m->wander), left);
    if (m->c->straight) return step;
    double bend = own_bend(m, n, at->time, at->time + step);
    step =
        min_of(step, course_step_until_used(spare - aim, rate, max_of(m->wander + 0.25 * bend - 1.01 * n->curve, 0)));
    return min_of(step, sqrt(DIP_SHARE * 8 * spare / bend));
}

/* The next place up to which they are apart. */
static bool moving_boxes_advance(
    const moving_boxes *m, const box_place *at, box_axis *n, double tolerance, box_place *to, uint32_t *steps)
{
    double spare = n->gap - moving_boxes_apart(m, at->time), left = m->c->span - at->time;
    double aim = spare > tolerance ? 0.5 * tolerance : 0.25 * spare;
    double step = moving_boxes_proposed_step(m, at, n, spare, aim, left);
    for (int k = 0; k < TRIES; k++) {
        moving_boxes_place(m, min_of(at->time + step, m->c->span), to);
        ++*steps;
        double after = moving_boxes_spare_after(m, at, n, to);
        if (after > 0) return true;
        step *= min_of(max_of((spare - aim) / (spare - after), 0.125), 0.99);
    }
    double fastest = m->c->speed + m->wander * at->time; /* without any axis: no two points approach faster */
    step = course_step_until_used(spare * (1 - 64 * UNIT_ROUNDOFF), -fastest, m->wander);
    moving_boxes_place(m, min_of(at->time + step, m->c->span), to);
    return to->time > at->time;
}

bool toi_boxes_apply(const course *c)
{
    bool in_range = c->slack > 0x1p-350 && c->slack < 0x1p350; /* it is 2^-47 of the lengths: squares are finite */
    return c->a->type <= SHAPE_BOX && c->b->type <= SHAPE_BOX && c->b->type != SHAPE_SPHERE && in_range;
}

/* ---- the end ---- */

static void moving_boxes_report(
    const moving_boxes *m, const box_place *at, const box_axis *n, facing f, toi_result *out)
{
    double radius_a = m->c->a->radius, radius_b = m->c->b->radius, radius = radius_a + radius_b;
    out->lo = at->time;
    out->gap_lo = n->gap - radius - m->error;
    out->gap_hi = vec_norm(vec_sub(f.b, f.a)) - radius + m->error;
    out->axis = n->axis;
    out->point_a = vec_madd(f.a, radius_a, n->axis);
    out->point_b = vec_madd(f.b, -radius_b, n->axis);
    out->closing = -n->rate;
}

/* When they certainly touch, soon after a gap of `gap` is left; INFINITY: not proven. */
static double time_of_touch(moving_boxes *m, const box_place *at, const box_axis *n, double gap)
{
    double step = gap / max_of(-n->rate, 0x1p-10 * m->c->speed);
    for (int k = 0; k < TRIES && at->time + step <= m->c->span; k++) {
        box_place then;
        moving_boxes_place(m, at->time + step, &then);
        if (moving_boxes_touch(m, &then, n)) return then.time;
        step *= 1.5;
    }
    return INFINITY;
}

/* Within the tolerance of contact at `at`, which m->axes say, and the points that face each other along the axis are
 * the nearest: near, if that is all that is asked, or a hit, if it is proven that they touch a little later. */
static bool moving_boxes_settle(
    moving_boxes *m, const box_place *at, const box_axis *n, const toi_request *request, bool rough, toi_result *out)
{
    double tolerance = request->tolerance, left = n->gap - moving_boxes_apart(m, at->time), hi = INFINITY;
    if (!(left <= tolerance) || !(n->rate < 0) || m->c->a->deviation + m->c->b->deviation > 0) return false;
    facing f = moving_boxes_facing(m, at, n);
    double wide = vec_norm(vec_sub(f.b, f.a)) - n->gap;
    if (!(wide <= 0.25 * tolerance) || (rough && !(left + wide <= tolerance))) return false;
    if (!rough) hi = time_of_touch(m, at, n, max_of(n->gap - m->reach, 0) + 0.25 * tolerance);
    if (!rough && (hi == INFINITY || m->wander > 0)) return false;
    moving_boxes_report(m, at, n, f, out);
    out->status = rough ? TOI_NEAR : TOI_HIT;
    out->hi = hi;
    return true;
}

/* Near contact it is not likely that another axis lasts longer; nor at all where neither turns. */
static bool is_worth_following(const moving_boxes *m, const box_axis *n, const box_place *at)
{
    return m->c->straight || n->gap - moving_boxes_apart(m, at->time) < FOLLOWED * (m->c->reach_a + m->c->reach_b);
}

double toi_boxes_march(const course *c, const toi_request *request, double from, bool rough, toi_result *out)
{
    moving_boxes m;
    moving_boxes_init(c, request, &m);
    box_place places[2];
    int now = 0;
    moving_boxes_place(&m, from, &places[now]);
    box_axis n = {.index = -1};
    bool follows = false;
    for (int k = 0; k < STEPS_MAX; k++) {
        const box_place *at = &places[now];
        follows = follows && moving_boxes_follow(&m, at, &n);
        if (follows && moving_boxes_settle(&m, at, &n, request, rough, out)) return INFINITY;
        double spare = n.gap - moving_boxes_apart(&m, at->time);
        if (!follows || !(spare > request->tolerance) || c->straight) {
            if (!moving_boxes_best(&m, at, &n)) break;
            if (moving_boxes_settle(&m, at, &n, request, rough, out)) return INFINITY;
            if (n.gap - moving_boxes_apart(&m, at->time) <= request->tolerance) break;
        }
        follows = is_worth_following(&m, &n, at);
        if (!moving_boxes_advance(&m, at, &n, request->tolerance, &places[!now], &out->steps)) break;
        now = !now;
        if (places[now].time >= c->span) return INFINITY;
    }
    return places[now].time;
}
