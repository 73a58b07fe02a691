// peer_bullet: Bullet's three broad phases over one interface of its own (btBroadphaseInterface). Default margins and
// settings; the sweeps without their second tree for rays, which would cost them time and find no pair.
#include "broad_peer.h"

#include <BulletCollision/BroadphaseCollision/btAxisSweep3.h>
#include <BulletCollision/BroadphaseCollision/btDbvtBroadphase.h>
#include <cstdint>
#include <memory>
#include <vector>

namespace
{

constexpr btScalar ROUND_THE_WORLD = 4; // m: more than the largest body

struct world {
    std::unique_ptr<btBroadphaseInterface> broad;
    std::vector<btBroadphaseProxy *> proxies;
    bool proxies_are_ours; // allocated one by one
};

btVector3 vector_of(const double (&v)[3])
{
    return {btScalar(v[0]), btScalar(v[1]), btScalar(v[2])};
}

// The id travels in the owner's pointer.
void *owner_of(size_t id)
{
    return reinterpret_cast<void *>(uintptr_t(id));
}

uint32_t id_of(const btBroadphaseProxy *proxy)
{
    return uint32_t(reinterpret_cast<uintptr_t>(proxy->m_clientObject));
}

void *create(btBroadphaseInterface *broad, const peer_body *bodies, size_t count, bool proxies_are_ours)
{
    auto *w = new world{std::unique_ptr<btBroadphaseInterface>(broad), {}, proxies_are_ours};
    w->proxies.reserve(count);
    for (size_t i = 0; i < count; i++)
        w->proxies.push_back(
            broad->createProxy(vector_of(bodies[i].lo), vector_of(bodies[i].hi), 0, owner_of(i), 1, -1, nullptr));
    broad->calculateOverlappingPairs(nullptr);
    return w;
}

void *create_dbvt(const peer_body *bodies, size_t count, double)
{
    return create(new btDbvtBroadphase, bodies, count, true);
}

template <class Sweep> void *create_sweep(const peer_body *bodies, size_t count, double side)
{
    btVector3 lo(-ROUND_THE_WORLD, -ROUND_THE_WORLD, -ROUND_THE_WORLD);
    btScalar end = btScalar(side) + ROUND_THE_WORLD;
    // one more than there are bodies: both sweeps number their handles from 1
    return create(new Sweep(lo, {end, end, end}, uint32_t(count) + 1, nullptr, true), bodies, count, false);
}

// Not by destroyProxy, which looks through all pairs for each body.
void destroy(void *context)
{
    auto *w = static_cast<world *>(context);
    w->broad.reset();
    if (w->proxies_are_ours)
        for (btBroadphaseProxy *proxy : w->proxies) btAlignedFree(proxy);
    delete w;
}

size_t step(void *context, const uint32_t *ids, const peer_body *bodies, size_t count)
{
    auto *w = static_cast<world *>(context);
    for (size_t i = 0; i < count; i++)
        w->broad->setAabb(w->proxies[ids[i]], vector_of(bodies[i].lo), vector_of(bodies[i].hi), nullptr);
    w->broad->calculateOverlappingPairs(nullptr);
    return size_t(w->broad->getOverlappingPairCache()->getNumOverlappingPairs());
}

void pairs(void *context, peer_visit *visit, void *visit_context)
{
    btOverlappingPairCache *cache = static_cast<world *>(context)->broad->getOverlappingPairCache();
    const btBroadphasePairArray &all = cache->getOverlappingPairArray();
    for (int i = 0; i < all.size(); i++) visit(visit_context, id_of(all[i].m_pProxy0), id_of(all[i].m_pProxy1));
}

} // namespace

const peer peer_bullet_dbvt = {
    "bullet_dbvt", 0, create_dbvt, destroy, step, pairs, "btBroadphaseInterface::setAabb, calculateOverlappingPairs"};
const peer peer_bullet_sweep16 = {"bullet_sweep16", 16384, create_sweep<btAxisSweep3>, destroy, step, pairs,
    "btBroadphaseInterface::setAabb, calculateOverlappingPairs"};
const peer peer_bullet_sweep32 = {"bullet_sweep32", 0, create_sweep<bt32BitAxisSweep3>, destroy, step, pairs,
    "btBroadphaseInterface::setAabb, calculateOverlappingPairs"};
