/* effort: how much one query may do. It is counted by a table of prices, not by the clock, so that where a search ends
 * is a matter of the shapes and their poses alone: the same on any machine, for any number of workers, live or
 * replayed. A search that ends early reports an interval that holds and is wider than asked (NARROW_WIDE).
 *
 * A unit is a nanosecond of the machine that the prices were measured on, or less. Pure; any thread. */
#ifndef COLLIDED_NARROW_PAIR_EFFORT_H
#define COLLIDED_NARROW_PAIR_EFFORT_H

#include "request.h"

/* Of one query. A query of a pair of meshes or compounds then takes at most 20 ms, with a factor of two to spare for
 * prices that are too low on some input, and for slower machines. */
#define EFFORT_OF_A_QUERY 8000000
/* Of these, for the contact points of a query that asks for them: kept back from the search for the interval, so that a
 * pair whose depth takes all there is still has points. A quarter for each of the four. */
#define EFFORT_OF_POINTS 2000000

/* And for a translation that parts two that overlap; and for the depth of convex hulls. */
#define EFFORT_OF_WAYS_OUT 3000000
#define EFFORT_OF_HULLS 1500000
/* At most, of a search that is not counted (mesh_gap.c): twice as much, for few are as long as they could be. */
#define EFFORT_UNCOUNTED 16000000

enum {
    EFFORT_NODES = 250,       /* two nodes of hierarchies are opened */
    EFFORT_LEAVES = 60,       /* the triangles of two leaves, as far as boxes and levels part them */
    EFFORT_ROW = 80,          /* up to four pairs of triangles, side by side */
    EFFORT_PART_STEP = 40,    /* an iteration for the distance of two triangles */
    EFFORT_CORE_STEP = 120,   /* an iteration for the distance of a convex core and a triangle */
    EFFORT_CORE = 600,        /* all iterations for a core and a triangle together */
    EFFORT_DEEP_PARTS = 3000, /* the depth of two parts */
    EFFORT_NEED = 40,         /* how far two parts overlap along a direction */
    EFFORT_CLIP = 1500,       /* the contact points of two parts */
    EFFORT_INSIDE = 600,     /* a ray from a point through a solid mesh, and a box around components on the way to it */
    EFFORT_BOXES = 60,       /* two boxes of hierarchies of compounds are held against each other */
    EFFORT_PARTS = 400,      /* a query about two convex parts of compounds, at least */
    EFFORT_PARTS_STEP = 120, /* more for each iteration of its search */
    EFFORT_PARTS_VERTICES = 2, /* more for each vertex of a hull (and one in each iteration) */
    EFFORT_FACET = 300,        /* the expanding polytope grows by a point, beside two support points */
    EFFORT_SUPPORT = 20,       /* a support point of a convex part */
    EFFORT_VERTICES = 4,       /* of a hull it costs one more for each so many vertices */
    EFFORT_UNION = 20,         /* a unit of work of union_depth.h */
    EFFORT_LARGE_HULL = 4096   /* vertices: two hulls of fewer in all need not be counted */
};

typedef struct effort {
    int64_t left;
    bool counts; /* false: the search that runs may have begun with what the pair remembers, so that what it does is no
                    matter of shapes and poses alone, and is not counted: then it is bounded by other means */
} effort;

/* False: there is nothing left. What is begun may be finished, so that `left` may be below 0. */
static inline bool effort_spend(effort *e, int64_t units)
{
    e->left -= units;
    return e->left >= 0;
}

/* Part of what is left, at most so much, is not for the next search, but for one that follows it: returns how much.
 * Many parts of one query may ask for this, one after the other: none is given more than there was. */
static inline int64_t effort_keep_back(effort *e, int64_t units)
{
    int64_t kept = !e || e->left <= 0 ? 0 : e->left < units ? e->left : units;
    if (e) e->left -= kept;
    return kept;
}
static inline void effort_give_back(effort *e, int64_t kept)
{
    if (e) e->left = (e->left > 0 ? e->left : 0) + kept;
}

/* How many units of work at that price may be done: at most so many. */
static inline uint32_t effort_grant(const effort *e, uint32_t most, int64_t price)
{
    int64_t left = e && e->left > 0 ? e->left / price : 0;
    return !e || left > most ? most : (uint32_t)left;
}

#endif
