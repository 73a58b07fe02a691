/* rim_features: the features that two bodies are nearest at, and the proof that it is these. Pure; any thread. */
#include "rim_features.h"

#include "descent.h"
#include "near_features.h"
#include "rim_newton.h"

/* Of the size, unless said otherwise. */
static const double SHARE = 0x1p-13;        /* of an edge: how far inside of it a point is */
static const double INSIDE = 0x1p-13;       /* of a face */
static const double CLOSED = 0x1p-48;       /* of bounds */
static const double NAMING_ANGLE = 0x1p-14; /* an axis that is so near to n* names the features */
static const double ON = 0x1p-30;           /* points are on a side to within this */

/* ---- the proof ---- */

static bool is_inside(const rim_part *x, double share)
{
    return x->discs == 1 || (share > SHARE && share < 1 - SHARE);
}

static vec3 in_frame_of_b(const unit_pair *p, vec3 at)
{
    return mat_tmul(p->b_in_a.r, vec_sub(at, p->b_in_a.t));
}

/* From s->n. */
static bool find_stand(const unit_pair *p, const narrow_features *f, rim_stand *s)
{
    rim_part a, b;
    double margin = INSIDE * p->size;
    if (!rim_part_of(&p->a, f->a, f->count_a, &a) || !rim_part_of(&p->b, f->b, f->count_b, &b)) return false;
    rim_part_place(&p->b_in_a, &b);
    if (a.is_face) return rim_stand_on_face(&a, &b, 1, s) && rim_part_contains(&p->a, f->a, s->point_a, margin);
    if (b.is_face)
        return rim_stand_on_face(&b, &a, -1, s) && rim_part_contains(&p->b, f->b, in_frame_of_b(p, s->point_b), margin);
    return rim_stand_between(&a, &b, p->size, s) && is_inside(&a, s->share_a) && is_inside(&b, s->share_b);
}

/* The answer, if `f` (of which nothing is believed) is strict, and Newton's method finds it from there. */
static bool features_span(const unit_pair *p, const narrow_goal *goal, const narrow_features *f, vec3 from, span *out)
{
    rim_stand s;
    s.n = from;
    if (!find_stand(p, f, &s) || !(s.lo >= NEAR_LEAST_DISTANCE * p->size)) return false;
    if (!rim_part_holds(&p->a, f->a, s.n) || !rim_part_holds(&p->b, f->b, mat_tmul(p->b_in_a.r, vec_neg(s.n))))
        return false;
    double hi = max_of(vec_norm(vec_sub(s.point_b, s.point_a)), s.lo);
    if (!(hi - s.lo <= CLOSED * p->size)) return false;
    *out = (span){.lo = s.lo,
        .hi = hi,
        .axis = s.n,
        .point_a = s.point_a,
        .point_b = s.point_b,
        .method = NARROW_BY_CLOSED_FORM,
        .iterations = 1,
        .nearest = *f};
    return hi + 2 * p->error <= goal->far; /* or else a search may have ended beyond it */
}

bool rim_features_recall(
    const unit_pair *p, const narrow_goal *goal, const narrow_features *nearest, vec3 axis, span *out)
{
    return !nearest->deep && features_span(p, goal, nearest, direction_again(axis), out);
}

/* ---- which features? ---- */

/* Of a rough bracket, whose points on a rim are between others, an end may be taken to be flat that is not. */
static bool find_at(const unit_pair *p, const narrow_goal *goal, const span *s, span *out)
{
    narrow_features f = {.count_a = 3, .count_b = 3};
    double near = ON * p->size;
    rim_part_at(&p->a, s->point_a, s->axis, near, f.a);
    rim_part_at(&p->b, in_frame_of_b(p, s->point_b), mat_tmul(p->b_in_a.r, vec_neg(s->axis)), near, f.b);
    if (features_span(p, goal, &f, s->axis, out)) return true;
    bool a = rim_part_make_round(&p->a, f.a), b = rim_part_make_round(&p->b, f.b);
    return (a || b) && features_span(p, goal, &f, s->axis, out);
}

/* The square of the angle between the bracket's axis and n* is at most 2 (hi - lo) / hi. */
static double angle_of(const span *s)
{
    return sqrt(2 * max_of(s->hi - s->lo, 0) / s->hi) + 0x1p-30;
}

/* All that the bracket leaves. Below half of the least margin of directions that is one feature of each at most. */
static bool find_along(const unit_pair *p, const narrow_goal *goal, const span *s, span *out)
{
    narrow_features f = {.count_a = 3, .count_b = 3};
    vec3 back = mat_tmul(p->b_in_a.r, vec_neg(s->axis));
    double off = angle_of(s);
    for (uint32_t i = 0; i < rim_part_count(&p->a); i++) {
        rim_part_numbered(&p->a, i, f.a);
        if (!rim_part_may_be(&p->a, f.a, s->axis, off)) continue;
        for (uint32_t k = 0; k < rim_part_count(&p->b); k++) {
            rim_part_numbered(&p->b, k, f.b);
            if (rim_part_may_be(&p->b, f.b, back, off) && features_span(p, goal, &f, s->axis, out)) return true;
        }
    }
    return false;
}

/* The bracket of a search that goes on for as long as doubles let it. */
static void narrow_down(const unit_pair *p, const narrow_goal *goal, span *s)
{
    narrow_goal exactly = {goal->finest, goal->finest, INFINITY, -INFINITY, INFINITY, INFINITY, false};
    gjk_result r;
    descent_distance(p, &exactly, s->axis, &r);
    if (!(r.span.hi - r.span.lo < s->hi - s->lo)) return;
    r.span.method = s->method;
    r.span.iterations += s->iterations;
    *s = r.span;
}

static bool find(const unit_pair *p, const narrow_goal *goal, span *s, span *out)
{
    if (find_at(p, goal, s, out)) return true;
    if (angle_of(s) > NAMING_ANGLE) {
        narrow_down(p, goal, s);
        if (find_at(p, goal, s, out)) return true;
    }
    return find_along(p, goal, s, out);
}

bool rim_features_at(const unit_pair *p, const narrow_goal *goal, span *s)
{
    span out;
    if (!rim_features_apply(p, goal) || !(s->hi >= NEAR_LEAST_DISTANCE * p->size) || !find_at(p, goal, s, &out))
        return false;
    out.iterations = 1;
    *s = out;
    return true;
}

void rim_features_settle(const unit_pair *p, const narrow_goal *goal, span *s)
{
    span out;
    if (s->nearest.count_a) return;
    if (!(s->hi >= 0.5 * NEAR_LEAST_DISTANCE * p->size) || s->lo > goal->far) return;
    if (find(p, goal, s, &out)) *s = out;
}
