// narrow_bullet: Bullet through its public detectors; its shapes and their margins: bullet_shapes.h.
#include "bullet_shapes.h"
#include "narrow_peer.h"

#include <BulletCollision/CollisionDispatch/btBoxBoxDetector.h>
#include <BulletCollision/CollisionShapes/btBoxShape.h>
#include <BulletCollision/NarrowPhaseCollision/btGjkEpa2.h>
#include <BulletCollision/NarrowPhaseCollision/btGjkEpaPenetrationDepthSolver.h>
#include <BulletCollision/NarrowPhaseCollision/btGjkPairDetector.h>
#include <BulletCollision/NarrowPhaseCollision/btVoronoiSimplexSolver.h>
#include <map>
#include <memory>
#include <utility>
#include <vector>

extern btScalar gGjkEpaPenetrationTolerance; // of btGjkPairDetector; default 1e-12

namespace
{

struct item {
    const btConvexShape *a, *b;
    btDiscreteCollisionDetectorInterface::ClosestPointInput input;
    bool begins;
};

struct self {
    std::map<const narrow_body *, std::unique_ptr<btConvexShape>> shapes;
    std::vector<item> items;
    bool coherent, apart;
    btScalar tolerance;
    btVector3 axis; // of the pair detector, from the frame before
    btVoronoiSimplexSolver simplex;
    btGjkEpaPenetrationDepthSolver depth;
};

void *create(const narrow_item *items, size_t count, const narrow_row *row)
{
    auto *s = new self;
    s->coherent = row->coherent;
    s->apart = row->regime == REGIME_SEPARATED;
    s->tolerance = row->own > 0 ? row->own : gGjkEpaPenetrationTolerance;
    if (row->own > 0) s->simplex.setEqualVertexThreshold(row->own);
    for (size_t i = 0; i < count; i++) {
        item it;
        for (const narrow_body *b : {items[i].a, items[i].b})
            if (!s->shapes.count(b)) s->shapes[b] = bullet_shape_of(*b);
        it.a = s->shapes[items[i].a].get();
        it.b = s->shapes[items[i].b].get();
        it.input.m_transformA = bullet_transform_of(items[i].at_a);
        it.input.m_transformB = bullet_transform_of(items[i].at_b);
        it.begins = items[i].begins;
        s->items.push_back(it);
    }
    return s;
}

void destroy(void *context)
{
    delete static_cast<self *>(context);
}

// The deepest point, of one or several.
struct deepest : btDiscreteCollisionDetectorInterface::Result {
    bool any = false;
    btScalar distance = 0;
    void setShapeIdentifiersA(int, int) override {}
    void setShapeIdentifiersB(int, int) override {}
    void addContactPoint(const btVector3 &, const btVector3 &, btScalar d) override
    {
        if (!any || d < distance) distance = d;
        any = true;
    }
};

narrow_answer answer_of(bool any, btScalar distance)
{
    narrow_answer out = {};
    out.failed = !any;
    out.measured = any;
    out.overlap = any && distance <= 0;
    out.distance = distance;
    return out;
}

void query_pair(void *context, size_t first, size_t count, narrow_answer *out)
{
    auto *s = static_cast<self *>(context);
    std::swap(gGjkEpaPenetrationTolerance, s->tolerance);
    for (size_t i = 0; i < count; i++) {
        const item &it = s->items[first + i];
        deepest found;
        btGjkPairDetector detector(it.a, it.b, &s->simplex, &s->depth);
        if (s->coherent && !it.begins) detector.setCachedSeparatingAxis(s->axis);
        detector.getClosestPoints(it.input, found, nullptr);
        s->axis = detector.getCachedSeparatingAxis();
        out[i] = answer_of(found.any, found.distance);
    }
    std::swap(gGjkEpaPenetrationTolerance, s->tolerance);
}

void query_epa(void *context, size_t first, size_t count, narrow_answer *out)
{
    auto *s = static_cast<self *>(context);
    for (size_t i = 0; i < count; i++) {
        const item &it = s->items[first + i];
        const btTransform &ta = it.input.m_transformA, &tb = it.input.m_transformB;
        btVector3 guess = s->coherent && !it.begins ? s->axis : tb.getOrigin() - ta.getOrigin();
        btGjkEpaSolver2::sResults r;
        bool answered = s->apart ? btGjkEpaSolver2::Distance(it.a, ta, it.b, tb, guess, r)
                                 : btGjkEpaSolver2::Penetration(it.a, ta, it.b, tb, guess, r);
        if (answered) s->axis = r.normal;
        out[i] = answer_of(answered, r.distance);
    }
}

void query_box(void *context, size_t first, size_t count, narrow_answer *out)
{
    auto *s = static_cast<self *>(context);
    for (size_t i = 0; i < count; i++) {
        const item &it = s->items[first + i];
        deepest found;
        btBoxBoxDetector detector(static_cast<const btBoxShape *>(it.a), static_cast<const btBoxShape *>(it.b));
        detector.getClosestPoints(it.input, found, nullptr);
        out[i] = answer_of(found.any, found.distance);
        out[i].failed = false; // of separated boxes it says nothing: a verdict
    }
}

bool takes_convex(const narrow_row *row)
{
    return row->a != KIND_MESH && row->b != KIND_MESH && row->b != KIND_COMPOUND;
}

bool takes_boxes(const narrow_row *row)
{
    return row->a == KIND_BOX && row->b == KIND_BOX;
}

} // namespace

const narrow_peer narrow_bullet_pair = {"bullet_pair",
    "btGjkPairDetector with btGjkEpaPenetrationDepthSolver, double, margin 0; coherent: last axis", false, takes_convex,
    create, query_pair, destroy, "btGjkPairDetector::getClosestPoints"};
const narrow_peer narrow_bullet_epa = {"bullet_epa",
    "btGjkEpaSolver2 Distance or Penetration, double, margin 0; coherent: last normal as guess", false, takes_convex,
    create, query_epa, destroy, "btGjkEpaSolver2::Distance, btGjkEpaSolver2::Penetration"};
const narrow_peer narrow_bullet_box = {"bullet_boxbox", "btBoxBoxDetector, double", false, takes_boxes, create,
    query_box, destroy, "btBoxBoxDetector::getClosestPoints"};
