/* spheres: the most frequent pair of all, without the frames, goals and tables of the general road. Pure; any thread.
 * What holds: unit_pair's scale and error, and closed.h's formula, so that both roads give the same bits. */
#include "spheres.h"

#include "scalar.h"
#include "unit_pair.h"

static bool applies(const shape *a, const shape *b, const narrow_request *r)
{
    return a->type == SHAPE_SPHERE && b->type == SHAPE_SPHERE && r->engine == NARROW_ENGINE_AUTO &&
           !(r->facts & NARROW_MANIFOLD);
}

/* Is the interval enough, without more than doubles? */
static bool suffices(const narrow_request *r, double lo, double hi)
{
    bool verdict = r->facts == 0 || (r->facts & NARROW_VERDICT), measure = r->facts & NARROW_DISTANCE;
    bool decided = lo > r->threshold || hi <= r->threshold, measured = hi - lo <= r->tolerance || lo > r->range;
    return (decided || !verdict) && (measured || !measure);
}

bool spheres_answer(
    const shape *a, const shape *b, const pose *b_in_a, const narrow_request *request, narrow_result *out)
{
    if (!applies(a, b, request)) return false;
    double unit, scale;
    unit_of(max_of(max_of(a->radius, b->radius), vec_greatest(b_in_a->p)), &unit, &scale);
    double radius_a = a->radius * scale, radius_b = b->radius * scale, radius = radius_a + radius_b;
    vec3 t = vec_scale(b_in_a->p, scale);
    double norm2 = vec_norm2(t), distance = sqrt(norm2), error = unit_error(radius_a + radius_b + distance);
    double lo = (distance - radius - error) * unit, hi = (distance - radius + error) * unit;
    if (!suffices(request, lo, hi) || !(norm2 > 0x1p-900)) return false;
    vec3 axis = vec_scale(t, 1 / distance);
    out->lo = lo;
    out->hi = hi;
    out->axis = axis;
    out->point_a = vec_scale(axis, radius_a * unit);
    out->point_b = vec_scale(vec_madd(t, -radius_b, axis), unit);
    out->manifold.count = 0;
    out->status = NARROW_CERTAIN;
    out->method = NARROW_BY_CLOSED_FORM;
    out->iterations = 1;
    out->peer_failures = 0;
    out->refined = false;
    return true;
}
