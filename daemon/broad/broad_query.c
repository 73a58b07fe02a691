/* broad_query: questions to the stored boxes. Any number of threads, between updates. */
#include "broad.h"

#include "broad_peek.h"
#include "state.h"

void broad_each_pair_of(const broad *b, uint32_t id, void (*visit)(void *context, uint32_t other), void *context)
{
    for (uint32_t link = pairs_first(&b->pairs, id); link != PAIRS_NO_LINK; link = pairs_next(&b->pairs, link))
        visit(context, pairs_other(&b->pairs, link));
}

void broad_query_box(const broad *b, aabb box, broad_visit *visit, void *context)
{
    fbox query = fbox_inward(box);
    if (!b->index->query_box(b, &query, visit, context)) return;
    for (size_t i = 0; i < b->unbounded.count; i++) {
        uint32_t id = b->unbounded.at[i];
        if (fbox_overlap(&query, &b->proxies.at[id].fat) && !visit(context, id)) return;
    }
}

/* What has no end first: it is few, and a floor shortens the way. */
void broad_query_cast(const broad *b, aabb box, vec3 direction, double length, broad_ray_visit *visit, void *context)
{
    tree_ray ray = {{box.lo.x, box.lo.y, box.lo.z}, {box.hi.x, box.hi.y, box.hi.z},
        {direction.x, direction.y, direction.z}, length};
    tree_slabs slabs = tree_slabs_of(&ray);
    for (size_t i = 0; i < b->unbounded.count; i++) {
        uint32_t id = b->unbounded.at[i];
        if (tree_slabs_meet(&slabs, &b->proxies.at[id].fat)) tree_slabs_end(&slabs, visit(context, id));
    }
    b->index->query_ray(b, &slabs, visit, context);
}

bool broad_peek(const broad *b, uint32_t id, broad_stored *stored)
{
    if (id >= b->proxies.count || b->proxies.at[id].place == NOWHERE) return false;
    const proxy *p = &b->proxies.at[id];
    *stored = (broad_stored){.fat = p->fat, .fixed = p->fixed, .unbounded = p->place == UNBOUNDED};
    return true;
}
