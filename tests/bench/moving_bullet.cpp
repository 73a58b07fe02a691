// moving_bullet: Bullet's collision world in single precision, as it is mostly used: its tree, its own pair functions
// and its persistent manifolds, with its default margins. A pair touches if a point of its manifold does.
#include "moving_scene.h"

#include <btBulletCollisionCommon.h>
#include <memory>
#include <vector>

namespace
{

struct moving_world {
    btDefaultCollisionConfiguration configuration;
    btCollisionDispatcher dispatcher{&configuration};
    btDbvtBroadphase broad;
    btCollisionWorld world{&dispatcher, &broad, &configuration};
    std::vector<std::unique_ptr<btCollisionShape>> shapes;
    std::vector<std::unique_ptr<btCollisionObject>> objects;
    ~moving_world()
    {
        for (auto &o : objects) world.removeCollisionObject(o.get());
    }
};

btCollisionShape *shape_of(const moving_body &b)
{
    switch (b.kind) {
    case MOVING_BALL:
        return new btSphereShape(btScalar(b.half[0]));
    case MOVING_BOX:
        return new btBoxShape({btScalar(b.half[0]), btScalar(b.half[1]), btScalar(b.half[2])});
    default:
        return new btCapsuleShapeZ(btScalar(b.half[0]), btScalar(2 * b.half[1]));
    }
}

btTransform transform_of(const moving_scene &s, size_t i)
{
    const double *p = &s.positions[3 * i], *q = &s.orientations[4 * i];
    return btTransform({btScalar(q[1]), btScalar(q[2]), btScalar(q[3]), btScalar(q[0])},
        {btScalar(p[0]), btScalar(p[1]), btScalar(p[2])});
}

size_t step(void *context, const moving_scene *s)
{
    auto &w = *static_cast<moving_world *>(context);
    for (size_t i = 0; i < s->count; i++) w.objects[i]->setWorldTransform(transform_of(*s, i));
    w.world.performDiscreteCollisionDetection();
    size_t touching = 0;
    for (int i = 0; i < w.dispatcher.getNumManifolds(); i++) {
        const btPersistentManifold *m = w.dispatcher.getManifoldByIndexInternal(i);
        bool touches = false;
        for (int k = 0; k < m->getNumContacts(); k++) touches |= m->getContactPoint(k).getDistance() <= 0;
        touching += touches;
    }
    return touching;
}

void *create(const moving_scene *s)
{
    auto *w = new moving_world;
    for (size_t i = 0; i < s->count; i++) {
        w->shapes.emplace_back(shape_of(s->bodies[i]));
        w->objects.emplace_back(new btCollisionObject);
        w->objects[i]->setCollisionShape(w->shapes[i].get());
        w->objects[i]->setWorldTransform(transform_of(*s, i));
        w->world.addCollisionObject(w->objects[i].get());
    }
    step(w, s);
    return w;
}

void destroy(void *context)
{
    delete static_cast<moving_world *>(context);
}

} // namespace

extern "C" const moving_peer moving_bullet = {
    "bullet", 100000, create, destroy, step, "btCollisionWorld::performDiscreteCollisionDetection"};
