// check_fcl: a robot's configuration by FCL, as planners that are built on it ask: the obstacles in a dynamic tree of
// boxes, each shape of a link against that tree, then the pairs of links, until the first contact.
#include "check_peer.h"
#include "fcl_shapes.h"

#include <fcl/broadphase/broadphase_dynamic_AABB_tree.h>
#include <fcl/narrowphase/collision.h>
#include <fcl/narrowphase/collision_object.h>
#include <utility>
#include <vector>

namespace
{

using object = fcl::CollisionObject<double>;

struct link_shape {
    size_t link;
    fcl::Transform3<double> local;
    std::unique_ptr<object> body;
};

std::vector<link_shape> shapes;
std::vector<std::pair<size_t, size_t>> pairs; // of links, then of shapes
std::vector<std::unique_ptr<object>> obstacles;
std::unique_ptr<fcl::DynamicAABBTreeCollisionManager<double>> manager;

void add_link_shape(size_t link, const narrow_body *body, const narrow_place *in_link)
{
    shapes.push_back({link, fcl_transform_of(*in_link), std::make_unique<object>(fcl_shape_of(*body))});
}

void keep_apart(size_t a, size_t b)
{
    for (size_t i = 0; i < shapes.size(); i++)
        for (size_t k = 0; k < shapes.size(); k++)
            if (shapes[i].link == a && shapes[k].link == b) pairs.emplace_back(i, k);
}

void add_obstacle(const narrow_body *body, const narrow_place *at)
{
    obstacles.push_back(std::make_unique<object>(fcl_shape_of(*body), fcl_transform_of(*at)));
    obstacles.back()->computeAABB();
}

void begin_scene()
{
    manager = std::make_unique<fcl::DynamicAABBTreeCollisionManager<double>>();
    for (auto &o : obstacles) manager->registerObject(o.get());
    manager->setup();
}

void end_scene()
{
    manager.reset();
    obstacles.clear();
}

bool touch(object *a, object *b)
{
    fcl::CollisionRequest<double> request(1, false);
    fcl::CollisionResult<double> result;
    return fcl::collide(a, b, request, result) > 0;
}

bool on_pair(object *a, object *b, void *found)
{
    bool *met = static_cast<bool *>(found);
    *met = *met || touch(a, b);
    return *met; // true: no more
}

bool meets(const narrow_place *links)
{
    bool met = false;
    for (auto &s : shapes) {
        s.body->setTransform(fcl_transform_of(links[s.link]) * s.local);
        s.body->computeAABB();
    }
    for (size_t i = 0; i < shapes.size() && !met; i++) manager->collide(shapes[i].body.get(), &met, on_pair);
    for (size_t i = 0; i < pairs.size() && !met; i++) {
        object *a = shapes[pairs[i].first].body.get(), *b = shapes[pairs[i].second].body.get();
        met = a->getAABB().overlap(b->getAABB()) && touch(a, b);
    }
    return met;
}

} // namespace

const check_peer check_fcl = {"fcl", add_link_shape, keep_apart, add_obstacle, begin_scene, end_scene, meets};
