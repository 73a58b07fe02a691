// narrow_bullet: Bullet in double precision (the -float64 libraries), with margin 0: with its margins a box is rounded
// or grown, and its distances are those of another body. The ellipsoid, which Bullet has not, is given as its user
// would: by its support function.
#include "narrow_peer.h"

#include <BulletCollision/CollisionDispatch/btBoxBoxDetector.h>
#include <BulletCollision/CollisionShapes/btBoxShape.h>
#include <BulletCollision/CollisionShapes/btCapsuleShape.h>
#include <BulletCollision/CollisionShapes/btConeShape.h>
#include <BulletCollision/CollisionShapes/btConvexHullShape.h>
#include <BulletCollision/CollisionShapes/btCylinderShape.h>
#include <BulletCollision/CollisionShapes/btSphereShape.h>
#include <BulletCollision/NarrowPhaseCollision/btGjkEpa2.h>
#include <BulletCollision/NarrowPhaseCollision/btGjkEpaPenetrationDepthSolver.h>
#include <BulletCollision/NarrowPhaseCollision/btGjkPairDetector.h>
#include <BulletCollision/NarrowPhaseCollision/btVoronoiSimplexSolver.h>
#include <map>
#include <memory>
#include <vector>

namespace
{

class ellipsoid : public btConvexInternalShape
{
    btVector3 m_half;

  public:
    explicit ellipsoid(const btVector3 &half) : m_half(half)
    {
        m_shapeType = CUSTOM_CONVEX_SHAPE_TYPE;
        setMargin(0);
    }
    btVector3 localGetSupportingVertexWithoutMargin(const btVector3 &d) const override
    {
        btVector3 w = d * m_half;
        btScalar norm = w.length();
        return norm > 0 ? m_half * w / norm : btVector3(0, 0, 0);
    }
    btVector3 localGetSupportingVertex(const btVector3 &d) const override
    {
        return localGetSupportingVertexWithoutMargin(d);
    }
    void batchedUnitVectorGetSupportingVertexWithoutMargin(const btVector3 *d, btVector3 *out, int count) const override
    {
        for (int i = 0; i < count; i++) out[i] = localGetSupportingVertexWithoutMargin(d[i]);
    }
    void calculateLocalInertia(btScalar, btVector3 &inertia) const override { inertia.setZero(); }
    void getAabb(const btTransform &t, btVector3 &lo, btVector3 &hi) const override
    {
        btVector3 e = t.getBasis().absolute() * m_half;
        lo = t.getOrigin() - e;
        hi = t.getOrigin() + e;
    }
    const char *getName() const override { return "ellipsoid"; }
};

std::unique_ptr<btConvexShape> hull_of(const narrow_polytope &p)
{
    auto h = std::make_unique<btConvexHullShape>();
    for (size_t i = 0; i < p.vertex_count; i++)
        h->addPoint({p.vertices[3 * i], p.vertices[3 * i + 1], p.vertices[3 * i + 2]}, false);
    h->recalcLocalAabb();
    return h;
}

std::unique_ptr<btConvexShape> unrounded(const narrow_body &b)
{
    btVector3 half(b.half[0], b.half[1], b.half[2]);
    switch (b.kind) {
    case KIND_BOX:
        return std::make_unique<btBoxShape>(half);
    case KIND_CYLINDER:
        return std::make_unique<btCylinderShapeZ>(half);
    case KIND_CONE:
        return std::make_unique<btConeShapeZ>(b.half[0], 2 * b.half[2]);
    case KIND_ELLIPSOID:
        return std::make_unique<ellipsoid>(half);
    default:
        return hull_of(*b.polytope);
    }
}

std::unique_ptr<btConvexShape> shape_of(const narrow_body &b)
{
    if (b.kind == KIND_SPHERE) return std::make_unique<btSphereShape>(b.radius);
    if (b.kind == KIND_CAPSULE) return std::make_unique<btCapsuleShapeZ>(b.radius, 2 * b.half[2]);
    auto s = unrounded(b);
    s->setMargin(0);
    return s;
}

btTransform transform_of(const narrow_place &at)
{
    return btTransform(btQuaternion(at.q[1], at.q[2], at.q[3], at.q[0]), {at.p[0], at.p[1], at.p[2]});
}

struct item {
    const btConvexShape *a, *b;
    btDiscreteCollisionDetectorInterface::ClosestPointInput input;
    bool begins;
};

struct self {
    std::map<const narrow_body *, std::unique_ptr<btConvexShape>> shapes;
    std::vector<item> items;
    bool coherent, apart;
    btVector3 axis; // of the pair detector, from the frame before
    btVoronoiSimplexSolver simplex;
    btGjkEpaPenetrationDepthSolver depth;
};

void *create(const narrow_item *items, size_t count, const narrow_row *row)
{
    auto *s = new self;
    s->coherent = row->coherent;
    s->apart = row->regime == REGIME_SEPARATED;
    for (size_t i = 0; i < count; i++) {
        item it;
        for (const narrow_body *b : {items[i].a, items[i].b})
            if (!s->shapes.count(b)) s->shapes[b] = shape_of(*b);
        it.a = s->shapes[items[i].a].get();
        it.b = s->shapes[items[i].b].get();
        it.input.m_transformA = transform_of(items[i].at_a);
        it.input.m_transformB = transform_of(items[i].at_b);
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
    for (size_t i = 0; i < count; i++) {
        const item &it = s->items[first + i];
        deepest found;
        btGjkPairDetector detector(it.a, it.b, &s->simplex, &s->depth);
        if (s->coherent && !it.begins) detector.setCachedSeparatingAxis(s->axis);
        detector.getClosestPoints(it.input, found, nullptr);
        s->axis = detector.getCachedSeparatingAxis();
        out[i] = answer_of(found.any, found.distance);
    }
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
    create, query_pair, destroy};
const narrow_peer narrow_bullet_epa = {"bullet_epa",
    "btGjkEpaSolver2 Distance or Penetration, double, margin 0; coherent: last normal as guess", false, takes_convex,
    create, query_epa, destroy};
const narrow_peer narrow_bullet_box = {
    "bullet_boxbox", "btBoxBoxDetector, double", false, takes_boxes, create, query_box, destroy};
