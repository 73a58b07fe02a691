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

static double score_of(const manifold_choice *c, const manifold_point *p)
{
    const manifold_point *at = c->chosen.points;
    if (c->pass == 0) return -p->distance;
    vec3 d = vec_sub(p->point, at[0].point);
    double dx = vec_dot(d, c->u), dy = vec_dot(d, c->v);
    if (c->pass == 1) return dx * dx + dy * dy;
    vec3 line = vec_sub(at[1].point, at[0].point);
    double left = vec_dot(line, c->u) * dy - vec_dot(line, c->v) * dx;
    return c->pass == 2 ? left : -left;
}

void manifold_choice_offer(manifold_choice *c, const manifold_point *p)
{
    if (is_chosen(c, p)) return;
    double score = score_of(c, p);
    if (c->pass > 0 && !(score > 0)) return;
    if (c->found && (score < c->best || (score == c->best && p->feature >= c->point.feature))) return;
    c->found = true;
    c->best = score;
    c->point = *p;
}

bool manifold_choice_next(manifold_choice *c)
{
    bool ends = !c->found && c->pass < 2; /* without a line there are no sides of it */
    if (c->found) c->chosen.points[c->chosen.count++] = c->point;
    c->found = false;
    return !ends && ++c->pass < MANIFOLD_POINTS_MAX;
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
