// impact_bullet: Bullet's btContinuousConvexCollision in double precision, between poses. It takes no step to turn by
// more than pi/4, so a span in which a body turns by more is asked for in pieces; their poses are computed before the
// clock starts. Its hits are at distances up to 1 mm, by a constant in its source. No meshes.
#include "bullet_shapes.h"
#include "impact_peer.h"

#include <BulletCollision/NarrowPhaseCollision/btContinuousConvexCollision.h>
#include <BulletCollision/NarrowPhaseCollision/btGjkEpaPenetrationDepthSolver.h>
#include <BulletCollision/NarrowPhaseCollision/btVoronoiSimplexSolver.h>
#include <map>
#include <vector>

namespace
{

constexpr double PIECE = 0.75; // rad

struct search {
    const btConvexShape *a, *b;
    std::vector<btTransform> at_a, at_b; // at the ends of the pieces
    double span;
};

struct self {
    std::map<const narrow_body *, std::unique_ptr<btConvexShape>> shapes;
    std::vector<search> searches;
    btVoronoiSimplexSolver simplex;
    btGjkEpaPenetrationDepthSolver depth;
};

void *create(const impact_item *items, size_t count)
{
    auto *s = new self;
    for (size_t i = 0; i < count; i++) {
        const impact_item &it = items[i];
        for (const narrow_body *b : {it.a, it.b})
            if (!s->shapes.count(b)) s->shapes[b] = bullet_shape_of(*b);
        search q{s->shapes[it.a].get(), s->shapes[it.b].get(), {}, {}, it.span};
        size_t pieces = impact_pieces(&it, PIECE);
        for (size_t k = 0; k <= pieces; k++) {
            double time = it.span * double(k) / double(pieces);
            q.at_a.push_back(bullet_transform_of(impact_place(&it.move_a, time)));
            q.at_b.push_back(bullet_transform_of(impact_place(&it.move_b, time)));
        }
        s->searches.push_back(q);
    }
    return s;
}

void destroy(void *context)
{
    delete static_cast<self *>(context);
}

impact_answer ask(void *context, size_t item)
{
    auto &s = *static_cast<self *>(context);
    const search &q = s.searches[item];
    size_t pieces = q.at_a.size() - 1;
    btContinuousConvexCollision continuous(q.a, q.b, &s.simplex, &s.depth);
    for (size_t k = 0; k < pieces; k++) {
        btConvexCast::CastResult result;
        if (continuous.calcTimeOfImpact(q.at_a[k], q.at_a[k + 1], q.at_b[k], q.at_b[k + 1], result))
            return {false, true, q.span * (double(k) + result.m_fraction) / double(pieces)};
    }
    return {false, false, 0};
}

bool takes(narrow_kind a, narrow_kind b)
{
    return a != KIND_MESH && b != KIND_MESH;
}

} // namespace

const impact_peer impact_bullet = {"bullet",
    "btContinuousConvexCollision with btGjkEpaPenetrationDepthSolver, double, margin 0, in pieces of at most 0.75 rad",
    false, takes, create, ask, destroy, "btContinuousConvexCollision::calcTimeOfImpact"};
