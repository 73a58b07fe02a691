/* Which points of a contact are kept. Pure; any thread. */
#include "manifold_choice.h"

#include "scalar.h"
#include "unit_pair.h"

#include <string.h>

void manifold_choice_begin(manifold_choice *c, vec3 axis, double same)
{
    *c = (manifold_choice){.same = same, .u = vec_unit_orthogonal(axis)};
    c->v = vec_cross(axis, c->u);
}

static bool is_chosen(const manifold_choice *c, const manifold_point *p)
{
    for (uint32_t i = 0; i < c->chosen.count; i++) {
        vec3 d = vec_sub(p->point, c->chosen.points[i].point);
        if (max_of(fabs(vec_dot(d, c->u)), fabs(vec_dot(d, c->v))) <= c->same) return true;
    }
    return false;
}

static double square_from(const manifold_choice *c, vec3 from, vec3 to)
{
    vec3 d = vec_sub(to, from);
    double x = vec_dot(d, c->u), y = vec_dot(d, c->v);
    return x * x + y * y;
}

static double left_of_line(const manifold_choice *c, vec3 point)
{
    const manifold_point *at = c->chosen.points;
    vec3 d = vec_sub(point, at[0].point), line = vec_sub(at[1].point, at[0].point);
    return vec_dot(line, c->u) * vec_dot(d, c->v) - vec_dot(line, c->v) * vec_dot(d, c->u);
}

/* How much of what is looked for a point has; it must be positive but for the deepest. */
static double score_of(const manifold_choice *c, const manifold_point *p)
{
    const manifold_point *at = c->chosen.points;
    switch (c->pass) {
    case PASS_DEEPEST:
        return -p->distance;
    case PASS_FARTHEST:
        return square_from(c, at[0].point, p->point);
    case PASS_CORNER: /* in place of the first, if it is as deep, and farther from the second */
        if (p->distance > at[0].distance + c->same) return 0;
        return square_from(c, at[1].point, p->point) - square_from(c, at[1].point, at[0].point);
    case PASS_LEFT:
        return left_of_line(c, p->point);
    default:
        return -left_of_line(c, p->point);
    }
}

void manifold_choice_offer(manifold_choice *c, const manifold_point *p)
{
    if (is_chosen(c, p)) return;
    double score = score_of(c, p);
    if (c->pass != PASS_DEEPEST && !(score > 0)) return;
    if (c->found && (score < c->best || (score == c->best && p->feature >= c->point.feature))) return;
    c->found = true;
    c->best = score;
    c->point = *p;
}

bool manifold_choice_next(manifold_choice *c)
{
    bool ends = !c->found && c->pass < PASS_CORNER; /* without a line there are no sides of it */
    if (c->found && c->pass == PASS_CORNER)
        c->chosen.points[0] = c->point;
    else if (c->found)
        c->chosen.points[c->chosen.count++] = c->point;
    c->found = false;
    return !ends && ++c->pass < PASS_COUNT;
}

void manifold_choice_write(const manifold_choice *c, manifold *out)
{
    memset(out, 0, sizeof *out);
    for (uint32_t i = 0; i < c->chosen.count; i++) {
        uint32_t place = out->count++;
        for (; place > 0 && out->points[place - 1].feature > c->chosen.points[i].feature; place--)
            out->points[place] = out->points[place - 1];
        out->points[place] = c->chosen.points[i];
    }
}
