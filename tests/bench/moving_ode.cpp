// moving_ode: ODE's hash space, with the level that fits the scene, and its dCollide for each pair, for one contact.
#include "moving_scene.h"

#include <ode/ode.h>
#include <vector>

namespace
{

constexpr int LEVEL = 1; // cells of 2 m: the longest box has 1.6

struct moving_world {
    dSpaceID space;
    std::vector<dGeomID> geoms;
    size_t touching;
};

dGeomID geom_of(dSpaceID space, const moving_body &b)
{
    switch (b.kind) {
    case MOVING_BALL:
        return dCreateSphere(space, b.half[0]);
    case MOVING_BOX:
        return dCreateBox(space, 2 * b.half[0], 2 * b.half[1], 2 * b.half[2]);
    default:
        return dCreateCapsule(space, b.half[0], 2 * b.half[1]);
    }
}

void meet(void *context, dGeomID a, dGeomID b)
{
    dContactGeom one;
    static_cast<moving_world *>(context)->touching += dCollide(a, b, 1 | CONTACTS_UNIMPORTANT, &one, sizeof one) > 0;
}

size_t step(void *context, const moving_scene *s)
{
    auto &w = *static_cast<moving_world *>(context);
    for (size_t i = 0; i < s->count; i++) {
        const double *p = &s->positions[3 * i];
        dGeomSetPosition(w.geoms[i], p[0], p[1], p[2]);
        dGeomSetQuaternion(w.geoms[i], &s->orientations[4 * i]);
    }
    w.touching = 0;
    dSpaceCollide(w.space, &w, meet);
    return w.touching;
}

void *create(const moving_scene *s)
{
    dInitODE2(0);
    dAllocateODEDataForThread(dAllocateMaskAll);
    auto *w = new moving_world{dHashSpaceCreate(nullptr), {}, 0};
    dHashSpaceSetLevels(w->space, LEVEL, LEVEL);
    for (size_t i = 0; i < s->count; i++) w->geoms.push_back(geom_of(w->space, s->bodies[i]));
    return w;
}

void destroy(void *context)
{
    auto *w = static_cast<moving_world *>(context);
    dSpaceDestroy(w->space); // and its geoms
    delete w;
}

} // namespace

extern "C" const moving_peer moving_ode = {
    "ode", 100000, create, destroy, step, "dGeomSetPosition, dSpaceCollide, dCollide"};
