// impact_fcl: FCL's conservative advancement through its public continuousCollide(), between poses. Poses hide whole
// turns, so a span in which a body turns by more than 3 rad is asked for in pieces, as its user would have to; their
// poses are computed before the clock starts. A mesh is always its first body: as the second one, FCL 0.7 recurses
// until the stack is full.
#include "fcl_shapes.h"
#include "impact_peer.h"

#include <algorithm>
#include <cstdio>
#include <fcl/narrowphase/continuous_collision.h>
#include <map>
#include <vector>

namespace
{

constexpr double PIECE = 3.0; // rad

struct search {
    const fcl::CollisionGeometry<double> *a, *b;
    std::vector<fcl::Transform3<double>> at_a, at_b; // at the ends of the pieces
    double span;
    bool dies; // it ended in an assertion
};

struct self {
    std::map<const narrow_body *, std::shared_ptr<fcl::CollisionGeometry<double>>> shapes;
    std::vector<search> searches;
    fcl::ContinuousCollisionRequest<double> request;
};

void *create(const impact_item *items, size_t count)
{
    auto *s = new self;
    s->request = fcl::ContinuousCollisionRequest<double>(
        10, 1e-4, fcl::CCDM_LINEAR, fcl::GST_LIBCCD, fcl::CCDC_CONSERVATIVE_ADVANCEMENT);
    for (size_t i = 0; i < count; i++) {
        impact_item it = items[i];
        if (it.b->kind == KIND_MESH) std::swap(it.a, it.b), std::swap(it.move_a, it.move_b);
        for (const narrow_body *b : {it.a, it.b})
            if (!s->shapes.count(b)) s->shapes[b] = fcl_shape_of(*b);
        search q{s->shapes[it.a].get(), s->shapes[it.b].get(), {}, {}, it.span, false};
        size_t pieces = impact_pieces(&it, PIECE);
        for (size_t k = 0; k <= pieces; k++) {
            double time = it.span * double(k) / double(pieces);
            q.at_a.push_back(fcl_transform_of(impact_place(&it.move_a, time)));
            q.at_b.push_back(fcl_transform_of(impact_place(&it.move_b, time)));
        }
        s->searches.push_back(q);
    }
    return s;
}

void destroy(void *context)
{
    auto *s = static_cast<self *>(context);
    auto dead = std::count_if(s->searches.begin(), s->searches.end(), [](const search &q) { return q.dies; });
    if (dead) std::fprintf(stderr, "  fcl: %td queries ended in a failed assertion\n", dead);
    delete s;
}

impact_answer failure()
{
    return {true, false, 0};
}

impact_answer find(const self &s, const search &q)
{
    size_t pieces = q.at_a.size() - 1;
    for (size_t k = 0; k < pieces; k++) {
        fcl::ContinuousCollisionResult<double> result;
        fcl::continuousCollide(q.a, q.at_a[k], q.at_a[k + 1], q.b, q.at_b[k], q.at_b[k + 1], s.request, result);
        if (result.is_collide) return {false, true, q.span * (double(k) + result.time_of_contact) / double(pieces)};
    }
    return {false, false, 0};
}

impact_answer ask(void *context, size_t item)
{
    auto &s = *static_cast<self *>(context);
    search &q = s.searches[item];
    if (q.dies) return failure();
    if (setjmp(fcl_back) != 0) {
        fcl_armed = false;
        q.dies = true;
        return failure();
    }
    fcl_armed = true;
    impact_answer out;
    try {
        out = find(s, q);
    } catch (const std::exception &) {
        out = failure();
    }
    fcl_armed = false;
    return out;
}

bool takes(narrow_kind, narrow_kind)
{
    return true;
}

} // namespace

const impact_peer impact_fcl = {"fcl",
    "continuousCollide(), conservative advancement, libccd's solver, 10 iterations and 1e-4 (its defaults), in pieces "
    "of at most 3 rad",
    false, takes, create, ask, destroy, "fcl::continuousCollide"};
