/* toi_walk: boxes of two hierarchies along their motions, the earliest first: each pair of boxes is itself a pair of
 * convex shapes that move, so the same search says from when on their parts can meet, and what cannot meet before the
 * first contact that is found is left out. Pure; any thread.
 *
 * A solid can be entered only through its surface, so that after the first moment its triangles are all that counts. */
#include "toi_walk.h"

#include "scalar.h"
#include "toi_parts.h"
#include "toi_sweep.h"

enum { VISITS_MAX = 1 << 17 };      /* pairs of boxes or parts: beyond it TOI_UNDECIDED */
static const double ROUGHLY = 0.02; /* boxes are told apart to within so much of their size */

typedef struct walk {
    const toi_mover *a, *b;
    const toi_request *request;
    narrow_scratch *scratch;
    double until;   /* nothing after it matters: the first proven contact, or the span */
    double skipped; /* from here on may be contacts that were not looked for any more */
    uint32_t visits;
    bool sweeps; /* parts are told apart by toi_sweep.h, otherwise as two shapes that move */
    sweep sweep;
    toi_result *out;
} walk;

static toi_mover mover_of(const toi_mover *whole, const toi_part *p)
{
    return (toi_mover){&p->shape, pose_mul(whole->local, p->local), whole->motion};
}

/* Two parts, in whatever order their types are. */
static void ask(
    const walk *w, const toi_part *a, const toi_part *b, double from, double tolerance, bool rough, toi_result *r)
{
    toi_mover ma = mover_of(w->a, a), mb = mover_of(w->b, b);
    toi_request request = *w->request;
    request.span = w->until;
    request.tolerance = tolerance;
    *r = (toi_result){.status = TOI_FREE, .lo = INFINITY, .hi = INFINITY};
    bool turned = a->shape.type > b->shape.type;
    toi_convex(turned ? &mb : &ma, turned ? &ma : &mb, &request, VEC_ZERO, from, rough, w->scratch, r);
    if (!turned) return;
    vec3 point_a = r->point_b;
    r->axis = vec_neg(r->axis);
    r->point_b = r->point_a;
    r->point_a = point_a;
}

static void keep(walk *w, const toi_result *r)
{
    toi_result *out = w->out;
    double hi = min_of(out->hi, r->hi);
    uint32_t queries = out->queries, steps = out->steps;
    if (r->lo < out->lo) *out = *r;
    out->hi = hi;
    out->queries = queries;
    out->steps = steps;
    w->until = min_of(w->until, w->request->wander > 0 ? out->lo : hi);
}

/* Until when two parts that do not meet before `from` are apart, by the search for convex shapes; leaves are kept. */
static double search(walk *w, const toi_part *a, const toi_part *b, double from)
{
    toi_result r;
    bool leaves = a->is_leaf && b->is_leaf;
    double tolerance = w->request->tolerance;
    if (w->until <= 0) return INFINITY; /* nothing comes before the beginning */
    if (!leaves) tolerance = max_of(tolerance, ROUGHLY * (a->size + b->size));
    ask(w, a, b, from, tolerance, !leaves || w->request->wander > 0, &r);
    w->out->queries += r.queries;
    w->out->steps += r.steps;
    if (r.status == TOI_FREE) return INFINITY;
    if (leaves) keep(w, &r);
    return r.lo;
}

/* Until when they are certainly apart. Leaves of which that is not clear enough are searched when it is their turn. */
static double look(walk *w, const toi_part *a, const toi_part *b, double from, vec3 *hint)
{
    w->visits++;
    if (w->until <= 0) return INFINITY;
    if (!w->sweeps) return search(w, a, b, from);
    w->out->steps++;
    return sweep_entry(&w->sweep, a, b, from, w->until, hint);
}

static void descend(walk *w, const toi_part *a, const toi_part *b, double since, vec3 hint)
{
    toi_part children[PART_CHILDREN_MAX];
    double from[PART_CHILDREN_MAX];
    bool of_a = !a->is_leaf && (b->is_leaf || a->size >= b->size);
    int count = toi_part_children(of_a ? a : b, children);
    bool is_last = of_a ? b->is_leaf : a->is_leaf;
    vec3 hints[PART_CHILDREN_MAX];
    for (int k = 0; k < count; k++) {
        hints[k] = hint;
        from[k] = look(w, of_a ? &children[k] : a, of_a ? b : &children[k], since, &hints[k]);
    }
    for (int n = 0; n < count; n++) {
        int first = 0;
        for (int k = 1; k < count; k++)
            if (from[k] < from[first]) first = k;
        double at = from[first];
        const toi_part *part_a = of_a ? &children[first] : a, *part_b = of_a ? b : &children[first];
        from[first] = INFINITY;
        if (at > w->until || at == INFINITY) return;
        if (w->visits > VISITS_MAX)
            w->skipped = min_of(w->skipped, at);
        else if (!is_last || !children[first].is_leaf)
            descend(w, part_a, part_b, at, hints[first]);
        else if (w->sweeps) /* otherwise it was searched when it was looked at */
            (void)search(w, part_a, part_b, at);
    }
}

/* Do they touch at the beginning? A shape may lie inside of a solid without touching a triangle. */
static bool begins_in_contact(walk *w)
{
    pose at_a = pose_mul(w->a->motion.start, w->a->local), at_b = pose_mul(w->b->motion.start, w->b->local);
    narrow_request r = {
        .facts = NARROW_VERDICT, .tolerance = w->request->tolerance, .threshold = w->request->threshold};
    narrow_result n;
    narrow_query_world(w->a->shape, at_a, w->b->shape, at_b, &r, w->scratch, &n);
    w->out->queries++;
    if (n.lo > w->request->threshold) return false;
    *w->out = (toi_result){.status = n.hi <= w->request->threshold ? TOI_HIT : TOI_NEAR,
        .lo = 0,
        .hi = n.hi <= w->request->threshold ? 0 : INFINITY,
        .gap_lo = n.lo,
        .gap_hi = n.hi,
        .axis = n.axis,
        .point_a = vec_add(n.point_a, at_a.p),
        .point_b = vec_add(n.point_b, at_a.p),
        .queries = w->out->queries};
    return true;
}

enum { PROOFS_MAX = 24 };

/* Solids whose faces meet flat overlap without any two triangles that do: the whole shapes prove the contact. */
static void prove_contact(walk *w)
{
    toi_result *out = w->out;
    narrow_request r = {
        .facts = NARROW_VERDICT, .tolerance = w->request->tolerance, .threshold = w->request->threshold};
    double gap = max_of(out->gap_hi - w->request->threshold, 0) + w->request->tolerance, time = out->lo;
    double step = out->closing > 0 ? gap / out->closing : 0x1p-20 * w->request->span;
    for (int k = 0; k < PROOFS_MAX && time < w->request->span; k++, step *= 2) {
        time = min_of(time + step, w->request->span);
        narrow_result n;
        narrow_query_world(w->a->shape, pose_mul(motion_pose(&w->a->motion, time), w->a->local), w->b->shape,
            pose_mul(motion_pose(&w->b->motion, time), w->b->local), &r, w->scratch, &n);
        out->queries++;
        if (n.hi <= w->request->threshold) out->hi = time;
        if (n.hi <= w->request->threshold || n.lo > w->request->threshold) return;
    }
}

void toi_walk(
    const toi_mover *a, const toi_mover *b, const toi_request *request, narrow_scratch *scratch, toi_result *out)
{
    walk w; /* its sweep is large, and makes itself ready */
    w.a = a;
    w.b = b;
    w.request = request;
    w.scratch = scratch;
    w.until = request->span;
    w.skipped = INFINITY;
    w.visits = 0;
    w.out = out;
    toi_part root_a, root_b;
    vec3 hint = VEC_ZERO;
    toi_part_root(a->shape, &root_a);
    toi_part_root(b->shape, &root_b);
    w.sweeps = sweep_init(&w.sweep, a, b, request);
    double from = w.sweeps ? look(&w, &root_a, &root_b, 0, &hint) : 0;
    if (from == 0 && begins_in_contact(&w)) return;
    if (!w.sweeps) from = look(&w, &root_a, &root_b, 0, &hint);
    if (from == INFINITY) return;
    descend(&w, &root_a, &root_b, from, hint);
    if (out->status == TOI_NEAR && out->hi == INFINITY && request->wander == 0) prove_contact(&w);
    if (w.skipped <= out->lo && w.skipped != INFINITY) {
        out->lo = w.skipped;
        out->status = out->hi == INFINITY ? TOI_UNDECIDED : TOI_HIT;
    } else if (out->hi != INFINITY) {
        out->status = TOI_HIT;
    }
}
