// bullet_shapes: Bullet's convex shapes.
#include "bullet_shapes.h"

#include <BulletCollision/CollisionShapes/btBoxShape.h>
#include <BulletCollision/CollisionShapes/btCapsuleShape.h>
#include <BulletCollision/CollisionShapes/btConeShape.h>
#include <BulletCollision/CollisionShapes/btConvexHullShape.h>
#include <BulletCollision/CollisionShapes/btCylinderShape.h>
#include <BulletCollision/CollisionShapes/btSphereShape.h>

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

} // namespace

std::unique_ptr<btConvexShape> bullet_shape_of(const narrow_body &b)
{
    if (b.kind == KIND_SPHERE) return std::make_unique<btSphereShape>(b.radius);
    if (b.kind == KIND_CAPSULE) return std::make_unique<btCapsuleShapeZ>(b.radius, 2 * b.half[2]);
    auto s = unrounded(b);
    s->setMargin(0);
    return s;
}

btTransform bullet_transform_of(const narrow_place &at)
{
    return btTransform(btQuaternion(at.q[1], at.q[2], at.q[3], at.q[0]), {at.p[0], at.p[1], at.p[2]});
}
