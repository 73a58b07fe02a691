// narrow_fcl: FCL through its public functions (distance, collide) with libccd's solver, and its own solver ("indep"),
// whose guess can be kept from frame to frame.
//
// FCL fails by exceptions, and its package by assertions, too, which would end the whole race. So an assertion that
// fails during a query leads back to it (what FCL held is lost); it counts as failed and is not asked again.
#include "fcl_shapes.h"
#include "narrow_peer.h"

#include <algorithm>
#include <cstdio>
#include <fcl/narrowphase/collision.h>
#include <fcl/narrowphase/distance.h>
#include <map>
#include <memory>
#include <vector>

namespace
{

using geometry = fcl::CollisionGeometry<double>;
using transform = fcl::Transform3<double>;

struct item {
    const geometry *a, *b;
    transform at_a, at_b;
    bool begins;
};

struct self {
    std::map<const narrow_body *, std::shared_ptr<geometry>> shapes;
    std::vector<item> items;
    std::vector<bool> dies; // by item: it ended in an assertion
    bool coherent;
    fcl::DistanceRequest<double> distance;
    fcl::CollisionRequest<double> collision;
};

self *create_asking(
    const narrow_item *items, size_t count, const narrow_row *row, fcl::GJKSolverType solver, double tolerance)
{
    auto *s = new self;
    bool apart = row->regime == REGIME_SEPARATED;
    s->coherent = row->coherent;
    s->distance = fcl::DistanceRequest<double>(false, !apart, 0, 0, tolerance, solver);
    s->collision = fcl::CollisionRequest<double>(8, true, 1, false, true, solver, tolerance);
    s->dies.resize(count);
    for (size_t i = 0; i < count; i++) {
        for (const narrow_body *b : {items[i].a, items[i].b})
            if (!s->shapes.count(b)) s->shapes[b] = fcl_shape_of(*b);
        s->items.push_back({s->shapes[items[i].a].get(), s->shapes[items[i].b].get(), fcl_transform_of(items[i].at_a),
            fcl_transform_of(items[i].at_b), items[i].begins});
    }
    return s;
}

void *create(const narrow_item *items, size_t count, const narrow_row *row)
{
    return create_asking(items, count, row, fcl::GST_LIBCCD, row->own > 0 ? row->own : 1e-6);
}

void *create_fine(const narrow_item *items, size_t count, const narrow_row *row)
{
    return create_asking(items, count, row, fcl::GST_LIBCCD, 1e-12);
}

void *create_indep(const narrow_item *items, size_t count, const narrow_row *row)
{
    return create_asking(items, count, row, fcl::GST_INDEP, row->own > 0 ? row->own : 1e-6);
}

void destroy(void *context)
{
    auto *s = static_cast<self *>(context);
    auto dead = std::count(s->dies.begin(), s->dies.end(), true);
    if (dead) std::fprintf(stderr, "  fcl: %td queries ended in a failed assertion\n", dead);
    delete s;
}

narrow_answer failure()
{
    narrow_answer out = {};
    out.failed = true;
    return out;
}

typedef narrow_answer one(self &s, const item &it);

void query(self &s, size_t first, size_t count, narrow_answer *out, one *ask)
{
    volatile size_t i = 0; // as it was when an assertion failed
    fcl_armed = true;
    if (setjmp(fcl_back) != 0) {
        s.dies[first + i] = true;
        out[i] = failure();
        i = i + 1;
    }
    for (; i < count; i = i + 1) {
        try {
            out[i] = s.dies[first + i] ? failure() : ask(s, s.items[first + i]);
        } catch (const std::exception &) {
            out[i] = failure();
        }
    }
    fcl_armed = false;
}

narrow_answer measure(self &s, const item &it)
{
    fcl::DistanceResult<double> result;
    double d = fcl::distance(it.a, it.at_a, it.b, it.at_b, s.distance, result);
    narrow_answer out = {};
    out.measured = true;
    out.overlap = d <= 0;
    out.distance = d;
    return out;
}

void query_distance(void *context, size_t first, size_t count, narrow_answer *out)
{
    query(*static_cast<self *>(context), first, count, out, measure);
}

narrow_answer collide(self &s, const item &it)
{
    fcl::CollisionResult<double> result;
    s.collision.enable_cached_gjk_guess = s.coherent && !it.begins;
    fcl::collide(it.a, it.at_a, it.b, it.at_b, s.collision, result);
    s.collision.cached_gjk_guess = result.cached_gjk_guess;
    narrow_answer out = {};
    out.overlap = out.measured = result.isCollision();
    double deepest = 0;
    for (size_t k = 0; k < result.numContacts(); k++)
        deepest = std::max(deepest, result.getContact(k).penetration_depth);
    out.distance = -deepest;
    return out;
}

void query_collide(void *context, size_t first, size_t count, narrow_answer *out)
{
    query(*static_cast<self *>(context), first, count, out, collide);
}

bool takes_all(const narrow_row *row)
{
    return row->b != KIND_COMPOUND;
}

bool takes_contact(const narrow_row *row)
{
    return row->regime != REGIME_SEPARATED;
}

bool takes_gaps(const narrow_row *row)
{
    return row->regime == REGIME_SEPARATED && row->b != KIND_COMPOUND;
}

} // namespace

const narrow_peer narrow_fcl = {"fcl", "distance(), libccd's solver, tolerance 1e-6 (default), signed in contact",
    false, takes_all, create, query_distance, destroy, "fcl::distance"};
const narrow_peer narrow_fcl_fine = {"fcl_fine", "distance(), libccd's solver, tolerance 1e-12, signed in contact",
    false, takes_all, create_fine, query_distance, destroy, "fcl::distance"};
const narrow_peer narrow_fcl_collide = {"fcl_collide", "collide(), libccd's solver, tolerance 1e-6, 8 contacts", false,
    takes_contact, create, query_collide, destroy, "fcl::collide"};
const narrow_peer narrow_fcl_indep = {
    "fcl_indep", "distance(), FCL's solver", false, takes_gaps, create_indep, query_distance, destroy, "fcl::distance"};
const narrow_peer narrow_fcl_indep_collide = {"fcl_indep_collide",
    "collide(), FCL's solver, 8 contacts; coherent: cached guess", false, takes_contact, create_indep, query_collide,
    destroy, "fcl::collide"};
