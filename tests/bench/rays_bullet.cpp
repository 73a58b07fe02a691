// rays_bullet: Bullet's collision world as a contender, in double precision, shapes without margin.
#include "rays_peer.h"

#include <btBulletCollisionCommon.h>
#include <cmath>
#include <memory>
#include <vector>

namespace
{

struct world {
    btDefaultCollisionConfiguration configuration;
    btCollisionDispatcher dispatcher{&configuration};
    btDbvtBroadphase broad;
    btCollisionWorld w{&dispatcher, &broad, &configuration};
    std::vector<std::unique_ptr<btCollisionShape>> shapes;
    std::vector<std::unique_ptr<btCollisionObject>> objects;
    ~world()
    {
        for (auto &o : objects) w.removeCollisionObject(o.get());
    }
};

std::unique_ptr<btCollisionShape> shape_of(const rays_body &b)
{
    if (b.kind == RAYS_BALL) return std::make_unique<btSphereShape>(b.radius);
    if (b.kind == RAYS_CAPSULE) return std::make_unique<btCapsuleShapeZ>(b.radius, 2 * b.half[2]);
    auto box = std::make_unique<btBoxShape>(btVector3(b.half[0], b.half[1], b.half[2]));
    box->setMargin(0);
    return box;
}

void *create(const rays_scene *s)
{
    auto *self = new world;
    for (size_t i = 0; i < s->body_count; i++) {
        const rays_body &b = s->bodies[i];
        self->shapes.push_back(shape_of(b));
        self->objects.push_back(std::make_unique<btCollisionObject>());
        btCollisionObject &o = *self->objects.back();
        o.setCollisionShape(self->shapes.back().get());
        o.setWorldTransform(btTransform(
            btQuaternion(b.turned[1], b.turned[2], b.turned[3], b.turned[0]), btVector3(b.at[0], b.at[1], b.at[2])));
        self->w.addCollisionObject(&o);
    }
    self->broad.optimize();
    return self;
}

rays_answer ask(void *context, const rays_ray *r, double length)
{
    auto *self = static_cast<world *>(context);
    btVector3 from(r->from[0], r->from[1], r->from[2]), d(r->direction[0], r->direction[1], r->direction[2]);
    btCollisionWorld::ClosestRayResultCallback hit(from, from + length * d);
    self->w.rayTest(hit.m_rayFromWorld, hit.m_rayToWorld, hit);
    double t = hit.hasHit() ? hit.m_closestHitFraction * length : INFINITY;
    return {t, t};
}

void destroy(void *context)
{
    delete static_cast<world *>(context);
}

} // namespace

const rays_peer rays_bullet = {"bullet", 1e-3, create, ask, destroy, "btCollisionWorld::rayTest"};
