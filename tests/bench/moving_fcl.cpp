// moving_fcl: FCL's dynamic tree of boxes and its collide() for each pair that it finds, asked for one contact.
#include "moving_scene.h"

#include <fcl/broadphase/broadphase_dynamic_AABB_tree.h>
#include <fcl/narrowphase/collision.h>
#include <memory>
#include <vector>

namespace
{

struct moving_world {
    fcl::DynamicAABBTreeCollisionManager<double> manager;
    std::vector<std::unique_ptr<fcl::CollisionObject<double>>> objects;
    size_t touching = 0;
};

std::shared_ptr<fcl::CollisionGeometry<double>> geometry_of(const moving_body &b)
{
    switch (b.kind) {
    case MOVING_BALL:
        return std::make_shared<fcl::Sphere<double>>(b.half[0]);
    case MOVING_BOX:
        return std::make_shared<fcl::Box<double>>(2 * b.half[0], 2 * b.half[1], 2 * b.half[2]);
    default:
        return std::make_shared<fcl::Capsule<double>>(b.half[0], 2 * b.half[1]);
    }
}

void place(fcl::CollisionObject<double> &o, const moving_scene &s, size_t i)
{
    const double *p = &s.positions[3 * i], *q = &s.orientations[4 * i];
    o.setTransform(fcl::Quaternion<double>(q[0], q[1], q[2], q[3]), fcl::Vector3<double>(p[0], p[1], p[2]));
    o.computeAABB();
}

bool meet(fcl::CollisionObject<double> *a, fcl::CollisionObject<double> *b, void *context)
{
    fcl::CollisionRequest<double> request;
    fcl::CollisionResult<double> result;
    fcl::collide(a, b, request, result);
    static_cast<moving_world *>(context)->touching += result.isCollision();
    return false; // go on
}

size_t step(void *context, const moving_scene *s)
{
    auto &w = *static_cast<moving_world *>(context);
    for (size_t i = 0; i < s->count; i++) place(*w.objects[i], *s, i);
    w.manager.update();
    w.touching = 0;
    w.manager.collide(&w, meet);
    return w.touching;
}

void *create(const moving_scene *s)
{
    auto *w = new moving_world;
    for (size_t i = 0; i < s->count; i++) {
        w->objects.emplace_back(new fcl::CollisionObject<double>(geometry_of(s->bodies[i])));
        place(*w->objects[i], *s, i);
        w->manager.registerObject(w->objects[i].get());
    }
    w->manager.setup();
    return w;
}

void destroy(void *context)
{
    delete static_cast<moving_world *>(context);
}

} // namespace

extern "C" const moving_peer moving_fcl = {
    "fcl", 10000, create, destroy, step, "fcl::DynamicAABBTreeCollisionManager::update, collide; fcl::collide"};
