/* never_meet: boxes of joint values, depth first, the half with the smaller gap first, so that links that can meet are
 * found to soon. One thread; memory is freed when it returns. */
#include "never_meet.h"

#include "fit_gap.h"
#include "loaders/decompose/vec3.h"
#include "loaders/rigid.h"
#include "never_path.h"

#include <stdio.h>

enum { PARTS_MAX = 64, DEPTH_MAX = 512, PLENTY = 16 /* this part of the boxes goes into good clearances */ };
static const double NEAR_M = 1e-5; /* boxes that move them by less are not halved */

typedef struct part {  /* a convex hull of points, rounded */
    const double *own; /* in the link's frame */
    double *at;        /* in the common frame */
    size_t count;
    double radius, most;
} part;

typedef struct side {
    part parts[PARTS_MAX];
    size_t count;
} side;

typedef struct box {
    double middle[NEVER_JOINTS_MAX], half[NEVER_JOINTS_MAX];
    double axis[3]; /* that the box it is of was separated along, at best */
    double gap, moves;
    bool meets; /* in the middle: by points of both, to within rounding */
} box;

typedef struct search {
    never_path path;
    side a, b;
    double reach_a[NEVER_JOINTS_MAX], reach_b[NEVER_JOINTS_MAX]; /* from a point of the joint's axis, for all values */
    double slack;
} search;

/* ---- what the links are ---- */

/* The corners of the core, in its own frame: 0 of what is not polytope, sphere or capsule. */
static size_t core_corners(const load_shape *from, double own[24])
{
    const collided_shape *s = &from->shape;
    size_t count = s->type == COLLIDED_BOX ? 8 : s->type == COLLIDED_CAPSULE ? 2 : s->type == COLLIDED_SPHERE ? 1 : 0;
    for (size_t i = 0; i < count; i++)
        for (int k = 0; k < 3; k++) {
            bool up = count == 8 ? i >> k & 1 : i == 1;
            double half = count == 8 || (count == 2 && k == 2) ? s->half[k] : 0;
            own[3 * i + (size_t)k] = up ? half : -half;
        }
    return count;
}

static bool add_part(pool *p, side *s, const load_shape *from)
{
    double own[24];
    bool hull = from->shape.type == COLLIDED_HULL;
    size_t count = hull ? from->points.count : core_corners(from, own);
    if (s->count == PARTS_MAX || count == 0) return false;
    double *points = pool_alloc(p, count, 3 * sizeof *points);
    for (size_t i = 0; i < count; i++) {
        rigid_rotate(from->shape.pose.orientation, (hull ? from->points.at : own) + 3 * i, points + 3 * i);
        for (int k = 0; k < 3; k++) points[3 * i + (size_t)k] += from->shape.pose.position[k];
    }
    s->parts[s->count++] = (part){
        .own = points, .at = pool_alloc(p, count, 3 * sizeof *points), .count = count, .radius = from->shape.radius};
    return true;
}

static bool add_parts(pool *p, side *s, const load_shape *shapes, size_t count)
{
    for (size_t i = 0; i < count; i++)
        if (!add_part(p, s, &shapes[i])) return false;
    return count > 0;
}

static void place_side(side *s, const collided_pose *pose)
{
    for (size_t n = 0; n < s->count; n++) {
        part *p = &s->parts[n];
        p->most = 0;
        for (size_t i = 0; i < p->count; i++) {
            double *x = p->at + 3 * i;
            rigid_rotate(pose->orientation, p->own + 3 * i, x);
            for (int k = 0; k < 3; k++) {
                x[k] += pose->position[k];
                p->most = fabs(x[k]) > p->most ? fabs(x[k]) : p->most;
            }
        }
    }
}

/* ---- how far things move ---- */

static double from_point(const side *s, const double x[3])
{
    double most = 0;
    for (size_t n = 0; n < s->count; n++)
        for (size_t i = 0; i < s->parts[n].count; i++)
            most = fmax(most, distance3(s->parts[n].at + 3 * i, x) + s->parts[n].radius);
    return most;
}

/* Greatest distance from an axis. */
static double from_axis(const side *s, const double origin[3], const double axis[3])
{
    double most = 0;
    for (size_t n = 0; n < s->count; n++) {
        double most2 = 0;
        for (size_t i = 0; i < s->parts[n].count; i++) {
            double to[3], off[3];
            sub3(s->parts[n].at + 3 * i, origin, to);
            cross3(axis, to, off);
            double away2 = dot3(off, off);
            most2 = away2 > most2 ? away2 : most2;
        }
        most = fmax(most, sqrt(most2) + s->parts[n].radius);
    }
    return most;
}

static bool slides(const search *q, int joint)
{
    return q->path.u->joints[q->path.joints[joint].joint].type == URDF_PRISMATIC;
}

static double travel(const search *q, int joint)
{
    const never_joint *j = &q->path.joints[joint];
    if (!slides(q, joint)) return 0;
    double lo = j->factor * q->path.lo[j->variable] + j->offset, hi = j->factor * q->path.hi[j->variable] + j->offset;
    return fmax(fabs(lo), fabs(hi));
}

/* Points of axes that turn are fixed in both links that they join, so that their distances along the chain do not
 * change, but for what slides. Placed at values of which each joint's is 0, or some other: the distances hold for all.
 */
static void find_reaches(search *q)
{
    never_place at;
    double middle[NEVER_JOINTS_MAX];
    for (int i = 0; i < q->path.variable_count; i++) middle[i] = (q->path.lo[i] + q->path.hi[i]) / 2;
    never_path_place(&q->path, middle, &at);
    place_side(&q->a, &at.a);
    place_side(&q->b, &at.b);
    int n = q->path.joint_count;
    double slide = 0; /* once for where it is now, once for where it may be */
    for (int i = 0; i < n; i++) slide += 2 * travel(q, i);
    for (int i = 0; i < n; i++) {
        double chain = i == 0 ? from_point(&q->a, at.origin[0]) : q->reach_a[i - 1];
        q->reach_a[i] = chain + (i == 0 ? slide : distance3(at.origin[i - 1], at.origin[i]));
    }
    for (int i = n - 1; i >= 0; i--) {
        double chain = i == n - 1 ? from_point(&q->b, at.origin[n - 1]) : q->reach_b[i + 1];
        q->reach_b[i] = chain + (i == n - 1 ? slide : distance3(at.origin[i + 1], at.origin[i]));
    }
    double longest = n > 0 ? fmax(q->reach_a[n - 1], q->reach_b[0]) : from_point(&q->b, at.a.position);
    q->slack = 0x1p-36 * (longest + from_point(&q->a, at.a.position));
}

/* By how much the box moves a point of one against a point of the other, at most. */
static double moves(const search *q, const box *x, const never_place *at)
{
    int n = q->path.joint_count;
    double sum = 0, half[NEVER_JOINTS_MAX], others_a = 0, others_b = 0;
    for (int i = 0; i < n; i++) {
        half[i] = fabs(q->path.joints[i].factor) * x->half[q->path.joints[i].variable];
        others_b += half[i] * (slides(q, i) ? 1 : q->reach_b[i]);
    }
    for (int i = 0; i < n; i++) {
        double whole_a = half[i] * (slides(q, i) ? 1 : q->reach_a[i]), most = 1;
        others_b -= half[i] * (slides(q, i) ? 1 : q->reach_b[i]);
        if (!slides(q, i)) {
            double a = from_axis(&q->a, at->origin[i], at->axis[i]) + others_a;
            double b = from_axis(&q->b, at->origin[i], at->axis[i]) + fmax(others_b, 0);
            most = fmin(fmin(a, q->reach_a[i]), fmin(b, q->reach_b[i]));
        }
        sum += half[i] * most;
        others_a += whole_a;
    }
    return sum * (1 + 0x1p-40);
}

/* ---- boxes ---- */

/* Of two clouds with `round` around them. Bounds that were cut short may have `round` between them: then they are asked
 * for again, until it is known on which side of it the distance is. */
static void find_gap(
    const search *q, fit_cloud a, fit_cloud b, double round, double enough, const double start[3], fit_gap *out)
{
    fit_gap_find(a, b, start, enough, INFINITY, out);
    if (out->lo > round || out->hi <= round + q->slack) return;
    double axis[3];
    memcpy(axis, out->axis, sizeof axis);
    fit_gap_find(a, b, axis, q->slack, round + q->slack, out);
}

/* The least gap of any two parts, by the known axis where that is enough; and whether any two meet. */
static double gap_of(search *q, double enough, double axis[3], bool *meets)
{
    double least = INFINITY;
    *meets = false;
    for (size_t i = 0; i < q->a.count; i++)
        for (size_t k = 0; k < q->b.count; k++) {
            const part *a = &q->a.parts[i], *b = &q->b.parts[k];
            double round = a->radius + b->radius;
            fit_cloud of_a = {a->at, a->count, a->most}, of_b = {b->at, b->count, b->most};
            double lo = fit_gap_along(of_a, of_b, axis) - round;
            if (lo <= enough) {
                fit_gap gap;
                find_gap(q, of_a, of_b, round, 0.01 * fabs(enough) + q->slack, axis, &gap);
                lo = gap.lo - round;
                *meets |= gap.hi <= round + q->slack;
                if (lo < least) memcpy(axis, gap.axis, sizeof gap.axis);
            }
            least = fmin(least, lo);
        }
    return least - q->slack;
}

static void look_at_box(search *q, box *x)
{
    never_place at;
    never_path_place(&q->path, x->middle, &at);
    place_side(&q->a, &at.a);
    place_side(&q->b, &at.b);
    x->moves = moves(q, x, &at);
    x->gap = gap_of(q, x->moves + q->slack, x->axis, &x->meets);
}

/* The variable whose halving helps most. */
static int widest(const search *q, const box *x)
{
    double by[NEVER_JOINTS_MAX] = {0};
    for (int i = 0; i < q->path.joint_count; i++) {
        const never_joint *j = &q->path.joints[i];
        double reach = slides(q, i) ? 1 : fmin(q->reach_a[i], q->reach_b[i]);
        by[j->variable] += fabs(j->factor) * x->half[j->variable] * reach;
    }
    int best = 0;
    for (int k = 1; k < q->path.variable_count; k++)
        if (by[k] > by[best]) best = k;
    return best;
}

static void whole_box(const search *q, box *x)
{
    *x = (box){.axis = {1, 0, 0}};
    for (int i = 0; i < q->path.variable_count; i++) {
        x->middle[i] = (q->path.lo[i] + q->path.hi[i]) / 2;
        x->half[i] = (q->path.hi[i] - q->path.lo[i]) / 2 * (1 + 0x1p-40);
    }
}

static bool settles(const box *x, size_t plenty, never_answer *out)
{
    if (x->gap <= x->moves * (out->boxes < plenty ? 2 : 1)) return false;
    out->clearance_m = fmin(out->clearance_m, x->gap - x->moves);
    return true;
}

static void report_values(const search *q, const box *x, never_answer *out)
{
    static const char more[] = ",...";
    size_t length = 0, room = sizeof out->at - sizeof more;
    for (int i = 0; i < q->path.variable_count; i++) {
        const char *name = q->path.u->joints[q->path.variable_joint[i]].name;
        int n = snprintf(out->at + length, room - length, "%s%s=%.17g", i ? "," : "", name, x->middle[i]);
        if (n < 0 || (size_t)n >= room - length) {
            memcpy(out->at + length, more, sizeof more);
            return;
        }
        length += (size_t)n;
    }
}

static void search_boxes(search *q, size_t boxes_max, never_answer *out)
{
    pool work = {0};
    box *stack = pool_alloc(&work, DEPTH_MAX, sizeof *stack);
    int depth = 0;
    size_t plenty = boxes_max / PLENTY;
    whole_box(q, &stack[0]);
    look_at_box(q, &stack[0]);
    out->boxes = 1;
    depth = settles(&stack[0], plenty, out) ? 0 : 1;
    while (depth > 0 && out->verdict == NEVER_PROVEN) {
        box x = stack[--depth], halves[2];
        if (x.meets)
            out->verdict = NEVER_MEET;
        else if (x.moves < NEAR_M || depth + 2 > DEPTH_MAX)
            out->verdict = NEVER_NEAR;
        else if (out->boxes + 2 > boxes_max)
            out->verdict = NEVER_UNDECIDED;
        if (out->verdict == NEVER_MEET) report_values(q, &x, out);
        if (out->verdict != NEVER_PROVEN) break;
        int k = widest(q, &x);
        bool open[2];
        for (int i = 0; i < 2; i++) {
            halves[i] = x;
            halves[i].half[k] /= 2;
            halves[i].middle[k] += (i ? 1 : -1) * halves[i].half[k];
            look_at_box(q, &halves[i]);
            open[i] = !settles(&halves[i], plenty, out);
        }
        out->boxes += 2;
        int first = halves[0].gap - halves[0].moves > halves[1].gap - halves[1].moves ? 0 : 1; /* looked at last */
        if (open[first]) stack[depth++] = halves[first];
        if (open[!first]) stack[depth++] = halves[!first];
    }
    pool_free(&work);
}

void never_meet_find(const urdf *u, int a, const load_shape *of_a, size_t a_count, int b, const load_shape *of_b,
    size_t b_count, size_t boxes_max, never_answer *out)
{
    pool work = {0};
    search *q = pool_alloc(&work, 1, sizeof *q);
    *out = (never_answer){.verdict = NEVER_PROVEN, .clearance_m = INFINITY};
    bool known = add_parts(&work, &q->a, of_a, a_count) && add_parts(&work, &q->b, of_b, b_count) &&
                 never_path_make(u, a, b, &q->path);
    if (known) {
        find_reaches(q);
        search_boxes(q, boxes_max, out);
    } else {
        out->verdict = NEVER_UNKNOWN;
    }
    if (out->verdict != NEVER_PROVEN) out->clearance_m = 0;
    pool_free(&work);
}

const char *never_verdict_word(never_verdict verdict)
{
    static const char *const words[] = {"never meet", "hulls meet", "too near to tell", "undecided", "not looked at"};
    return words[verdict];
}
