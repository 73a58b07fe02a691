/* trees: the index of two trees (tree.h), one of what moves and one of what is fixed, so that a world that stands costs
 * nothing and fixed proxies are not compared with each other. Tick thread; the queries as broad.h says. */
#include "state.h"

/* Then a leaf seeks a better place in its tree. Measured, with 0, 4, 8 and 1000: 72, 49, 69 and 162 ns a body: a tree
 * that only gives way goes bad, one that is always searched costs more than it saves. */
enum { MOVES_IN_PLACE = 4 };

static tree *tree_of(broad *b, bool fixed)
{
    return fixed ? &b->fixed : &b->moving;
}

static void put(broad *b, const change *c)
{
    b->proxies.at[c->proxy].moves = 0;
    tree_announce(tree_of(b, c->fixed), c->proxy, &c->fat);
}

static void remove_leaf(broad *b, uint32_t id)
{
    tree_remove(tree_of(b, b->proxies.at[id].fixed), id);
}

static void trees_move(broad *b, change *c)
{
    proxy *p = &b->proxies.at[c->proxy];
    tree *t = tree_of(b, p->fixed);
    tree_loosen(t, b->pending.count);
    if (p->fixed == c->fixed && p->moves++ < MOVES_IN_PLACE && fbox_overlap(&p->fat, &c->fat)) {
        tree_move(t, c->proxy, &c->fat);
    } else {
        remove_leaf(b, c->proxy);
        put(b, c);
    }
}

static void trees_settle(broad *b)
{
    tree_settle(&b->moving);
    tree_settle(&b->fixed);
}

static void trees_around(const broad *b, uint32_t id, broad_visit *visit, void *context)
{
    const proxy *p = &b->proxies.at[id];
    if (p->place == INDEXED && !p->fixed)
        tree_query_around(&b->moving, id, visit, context);
    else
        tree_query_box(&b->moving, &p->fat, visit, context);
    if (!p->fixed) tree_query_box(&b->fixed, &p->fat, visit, context);
}

static uint32_t trees_position(const broad *b, uint32_t id)
{
    return b->proxies.at[id].fixed ? b->fixed.leaf_of.at[id] : b->moving.leaf_of.at[id];
}

static bool trees_query_box(const broad *b, const fbox *query, broad_visit *visit, void *context)
{
    return tree_query_box(&b->moving, query, visit, context) && tree_query_box(&b->fixed, query, visit, context);
}

static void trees_query_ray(const broad *b, tree_slabs *slabs, broad_ray_visit *visit, void *context)
{
    const tree *const both[] = {&b->moving, &b->fixed};
    tree_query_ray(both, 2, slabs, visit, context);
}

static void trees_query_nearest(const broad *b, near_search *search)
{
    near_push_tree(search, &b->moving);
    near_push_tree(search, &b->fixed);
}

static const char *trees_validate(const broad *b, size_t *count)
{
    *count = b->moving.leaf_count + b->fixed.leaf_count;
    const char *broken = tree_validate(&b->moving);
    if (!broken) broken = tree_validate(&b->fixed);
    for (uint32_t id = 0; !broken && id < b->proxies.count; id++) {
        const proxy *p = &b->proxies.at[id];
        const tree *t = p->fixed ? &b->fixed : &b->moving;
        if (p->place != INDEXED) continue;
        if (id >= t->leaf_of.count || t->leaf_of.at[id] == TREE_NONE) return "a proxy is missing from its tree";
        if (!fbox_equal(tree_box(t, id), &p->fat)) return "a leaf differs from the proxy's box";
    }
    return broken;
}

static void trees_give_buffers_back(broad *b)
{
    tree_give_buffers_back(&b->moving);
    tree_give_buffers_back(&b->fixed);
}

static void release(broad *b)
{
    tree_free(&b->moving);
    tree_free(&b->fixed);
}

const broad_index broad_trees = {
    .kind = BROAD_TREE,
    .put = put,
    .move = trees_move,
    .remove = remove_leaf,
    .settle = trees_settle,
    .around = trees_around,
    .position = trees_position,
    .query_box = trees_query_box,
    .query_ray = trees_query_ray,
    .query_nearest = trees_query_nearest,
    .validate = trees_validate,
    .give_buffers_back = trees_give_buffers_back,
    .free = release,
};
