// peer_fcl: FCL's dynamic tree of exact boxes, refreshed in its two right ways: the moved objects alone (reinserted),
// and all objects at once (refitted in place). Pairs are not kept by FCL: each step walks the tree against itself.
#include "broad_peer.h"

#include <fcl/broadphase/broadphase_dynamic_AABB_tree.h>
#include <fcl/geometry/shape/box.h>
#include <memory>
#include <vector>

namespace
{

using object = fcl::CollisionObject<double>;

struct world {
    std::vector<std::unique_ptr<object>> objects; // the id travels in the user data
    std::vector<object *> moved;
    fcl::DynamicAABBTreeCollisionManager<double> tree;
};

fcl::Vector3<double> centre_of(const peer_body &b)
{
    return {(b.lo[0] + b.hi[0]) / 2, (b.lo[1] + b.hi[1]) / 2, (b.lo[2] + b.hi[2]) / 2};
}

// Without computeAABB the tree would keep the old box.
void place(object &o, const peer_body &b)
{
    o.setTranslation(centre_of(b));
    o.computeAABB();
}

uint32_t id_of(const object *o)
{
    return uint32_t(reinterpret_cast<uintptr_t>(o->getUserData()));
}

bool count_pair(object *, object *, void *context)
{
    ++*static_cast<size_t *>(context);
    return false; // go on
}

size_t count_pairs(world *w)
{
    size_t count = 0;
    w->tree.collide(&count, count_pair);
    return count;
}

void *create(const peer_body *bodies, size_t count, double)
{
    auto *w = new world;
    std::vector<object *> all;
    for (size_t i = 0; i < count; i++) {
        const peer_body &b = bodies[i];
        auto box = std::make_shared<fcl::Box<double>>(b.hi[0] - b.lo[0], b.hi[1] - b.lo[1], b.hi[2] - b.lo[2]);
        w->objects.push_back(std::make_unique<object>(box));
        w->objects.back()->setUserData(reinterpret_cast<void *>(uintptr_t(i)));
        place(*w->objects.back(), b);
        all.push_back(w->objects.back().get());
    }
    w->tree.registerObjects(all);
    w->tree.setup();
    count_pairs(w);
    return w;
}

void destroy(void *context)
{
    delete static_cast<world *>(context);
}

size_t step_update(void *context, const uint32_t *ids, const peer_body *bodies, size_t count)
{
    auto *w = static_cast<world *>(context);
    w->moved.clear();
    for (size_t i = 0; i < count; i++) {
        w->moved.push_back(w->objects[ids[i]].get());
        place(*w->moved.back(), bodies[i]);
    }
    w->tree.update(w->moved);
    return count_pairs(w);
}

size_t step_refit(void *context, const uint32_t *ids, const peer_body *bodies, size_t count)
{
    auto *w = static_cast<world *>(context);
    for (size_t i = 0; i < count; i++) place(*w->objects[ids[i]], bodies[i]);
    w->tree.update();
    return count_pairs(w);
}

struct visitor {
    peer_visit *visit;
    void *context;
};

bool visit_pair(object *a, object *b, void *context)
{
    auto *v = static_cast<visitor *>(context);
    v->visit(v->context, id_of(a), id_of(b));
    return false; // go on
}

void pairs(void *context, peer_visit *visit, void *visit_context)
{
    visitor v = {visit, visit_context};
    static_cast<world *>(context)->tree.collide(&v, visit_pair);
}

} // namespace

const peer peer_fcl_update = {
    "fcl_update", 0, create, destroy, step_update, pairs, "DynamicAABBTreeCollisionManager::update, collide"};
const peer peer_fcl_refit = {
    "fcl_refit", 0, create, destroy, step_refit, pairs, "DynamicAABBTreeCollisionManager::update, collide"};
