/* fit_link: the cheapest shapes that hold a link and exceed it by at most so much. */
#ifndef COLLIDED_LOADERS_FIT_LINK_H
#define COLLIDED_LOADERS_FIT_LINK_H

#include "fit_shape.h"

typedef enum fit_how {
    FIT_AS_IT_WAS, /* its own simple shapes: nothing cheaper is within the excess */
    FIT_ONE,       /* one shape around all of the link */
    FIT_EACH,      /* at least one of its shapes is replaced, each by itself */
    FIT_PIECES,    /* a concave mesh as several convex shapes */
    FIT_MESH       /* no convex shape found within the excess: the mesh stays */
} fit_how;

typedef struct fit_link {
    const char *name; /* as in the URDF */
    int link;         /* of the URDF */
    fit_how how;
    load_shape *shapes; /* in the link's frame; each shape's deviation is the proven excess */
    size_t shape_count;
    const load_shape *before; /* meshes as triangles */
    size_t before_count;
    double excess_m; /* no point of the shapes is farther than this from the link, proven */
    double volume;   /* m^3, sum of the new shapes' */
    double ns_before, ns;
    const char *note;   /* why nothing was found, or NULL */
    load_shape *convex; /* that together hold the link, for never_meet.h */
    size_t convex_count;
} fit_link;

/* `body`: the link with its meshes read as triangles. Lives in the pool. */
void fit_link_make(pool *p, const load_body *body, double excess_m, fit_link *out);

#endif
