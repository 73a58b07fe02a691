/* dispatch: the table of closed forms, and the general method behind it. Pure; any thread. */
#include "dispatch.h"

#include "narrow/closed/closed.h"
#include "narrow/convex/gjk.h"
#include "narrow/convex/near_features.h"
#include "narrow/convex/polytope_depth.h"
#include "narrow/convex/polytopes.h"
#include "narrow/curved/curved.h"
#include "narrow/curved/pieces.h"
#include "narrow/curved/revolved.h"
#include "narrow/math/scalar.h"

#define GENERAL NULL
#define SPH_REV closed_sphere_revolved
#define ELL_ELL ellipsoid_pair_measure
#define REV_REV revolved_pair_measure
#define CYL_CYL cylinder_pair_measure
#define BOX_REV box_revolved_measure
#define BOX_BOX closed_box_box
#define ANY_HAL closed_any_halfspace
#define HAL_ANY closed_halfspace_any
#define HAL_HAL closed_halfspace_halfspace
#define ORDERED NULL /* pairs come in canonical order; one that got here by reduction takes the general method */

/* clang-format off */
static closed_form *const TABLE[SHAPE_CONVEX_COUNT][SHAPE_CONVEX_COUNT] = {
    /*               sphere   capsule  box      cylinder cone     ellipsd  halfspc  hull */
    /* sphere    */ {BOX_BOX, BOX_BOX, BOX_BOX, SPH_REV, SPH_REV, ELL_ELL, ANY_HAL, GENERAL},
    /* capsule   */ {ORDERED, BOX_BOX, BOX_BOX, CYL_CYL, REV_REV, GENERAL, ANY_HAL, GENERAL},
    /* box       */ {ORDERED, ORDERED, BOX_BOX, BOX_REV, BOX_REV, GENERAL, ANY_HAL, GENERAL},
    /* cylinder  */ {ORDERED, ORDERED, ORDERED, CYL_CYL, REV_REV, GENERAL, ANY_HAL, GENERAL},
    /* cone      */ {ORDERED, ORDERED, ORDERED, ORDERED, REV_REV, GENERAL, ANY_HAL, GENERAL},
    /* ellipsoid */ {ORDERED, ORDERED, ORDERED, ORDERED, ORDERED, ELL_ELL, ANY_HAL, GENERAL},
    /* halfspace */ {ORDERED, ORDERED, ORDERED, ORDERED, ORDERED, ORDERED, HAL_HAL, HAL_ANY},
    /* hull      */ {ORDERED, ORDERED, ORDERED, ORDERED, ORDERED, ORDERED, ORDERED, GENERAL},
};
/* clang-format on */

closed_form *dispatch_closed_form(shape_type a, shape_type b)
{
    return TABLE[a][b];
}

/* Pairs of which GJK decides a verdict sooner, be they separated, in shallow or in deep contact, than their own form
 * has measured them; of two ellipsoids it gets what primitives.c has left. */
#define SOONER true
/* clang-format off */
static const bool GJK_DECIDES[SHAPE_CONVEX_COUNT][SHAPE_CONVEX_COUNT] = {
    [SHAPE_SPHERE]    = {[SHAPE_ELLIPSOID] = SOONER},
    [SHAPE_CAPSULE]   = {[SHAPE_CYLINDER] = SOONER, [SHAPE_CONE] = SOONER},
    [SHAPE_CYLINDER]  = {[SHAPE_CYLINDER] = SOONER, [SHAPE_CONE] = SOONER},
    [SHAPE_CONE]      = {[SHAPE_CONE] = SOONER},
    [SHAPE_ELLIPSOID] = {[SHAPE_ELLIPSOID] = SOONER},
};
/* clang-format on */

bool dispatch_gjk_decides(const unit_pair *p, const narrow_goal *goal)
{
    return goal->near != -INFINITY && GJK_DECIDES[p->a.type][p->b.type];
}

static void depth_by_axes(const unit_pair *p, const gjk_result *start, span *out)
{
    out->iterations = start->span.iterations;
    if (sat_is_quick(p)) {
        box_pair_axes(p, out);
    } else {
        sat_depth(p, out);
        witness_apart(p, out);
    }
    /* axes that all overlap leave no gap; where one does not, GJK's point bounds it from above */
    if (out->lo >= 0) out->hi = max_of(out->lo, start->span.hi);
}

/* Of cores that touch, but for rounding, a search may have met anywhere in a thin one. */
static void find_witnesses(const unit_pair *p, span *out)
{
    if (out->lo <= p->error) witness_deepest(p, out);
}

static void general_finish_depth(const unit_pair *p, const narrow_goal *asked, bool named, span *out)
{
    if (named) near_features_settle(p, asked, out);
    if (!out->nearest.deep) find_witnesses(p, out);
}

/* What is equally deep along many directions at once is not searched for if it is known. */
static bool about_one_axis(const unit_pair *p, const narrow_goal *goal, span *out)
{
    if (!inscribed_promises(p)) return false;
    span s = *out;
    coaxial_depth(p, &s);
    inscribed_depth(p, goal, &s);
    if (!(s.lo < 0) || !narrow_goal_reached(goal, s.lo, s.hi)) return false;
    s.method = NARROW_BY_CLOSED_FORM;
    *out = s;
    return true;
}

static bool is_small(const shape *s)
{
    return s->type != SHAPE_HULL || near_features_scans(s, s);
}

void dispatch_general(
    const unit_pair *p, const narrow_goal *goal, bool only_general, vec3 seed, epa_scratch *scratch, span *out)
{
    const narrow_goal *asked = goal;
    narrow_goal closely = *goal;
    bool named = !only_general && near_features_reach_depths(p, asked), measured = goal->near == -INFINITY;
    /* What names the features must be sure; and between the few facets of small polytopes the search ends on one as
     * soon as within a tolerance. */
    bool roughly = !measured || asked->tolerance > ROUGH_TOLERANCE * p->size;
    bool few = !roughly && !only_general && is_small(&p->a) && is_small(&p->b) && polytope_depth_applies(p);
    if (named || few) closely.tolerance = goal->finest;
    gjk_result start;
    if (!only_general && pieces_apply(p))
        descent_distance(p, goal, seed, &start);
    else
        gjk_distance(p, goal, seed, &start);
    *out = start.span;
    if (start.state == GJK_APART || out->hi <= goal->near) return;
    if (roughly && rough_depth(p, asked, &start, out)) return;
    goal = &closely;
    if (!only_general && sat_is_quick(p)) {
        depth_by_axes(p, &start, out);
        find_witnesses(p, out);
        return;
    }
    if (!only_general && !polytope_depth_applies(p) && about_one_axis(p, goal, out)) {
        general_finish_depth(p, asked, named, out);
        return;
    }
    if (only_general || !polytope_depth_applies(p) || !polytope_depth(p, goal, &start, out))
        epa_depth(p, goal, &start, scratch, out);
    bool closed = out->hi - out->lo <= p->error || narrow_goal_reached(goal, out->lo, out->hi);
    if (!only_general && !closed && sat_applies(p)) depth_by_axes(p, &start, out);
    if (!closed) coaxial_depth(p, out);
    if (!closed && out->lo < 0 && !only_general && !polytope_depth_applies(p)) inscribed_depth(p, goal, out);
    if (!closed) moved_apart_raise(p, out);
    general_finish_depth(p, asked, named, out);
}
