/* mesh_stand: how far the patches of nodes of two meshes reach along the axis of a walk. For mesh_walk.c. Pure; any
 * thread. What is known of a node serves each pair that it is in. */
#ifndef COLLIDED_NARROW_MESH_STAND_H
#define COLLIDED_NARROW_MESH_STAND_H

#include "mesh_walk.h"

MESH_INLINE void stand_keep(float to[MESH_WIDTH], mesh_lanes v)
{
    memcpy(to, &v, sizeof v);
}

MESH_INLINE const mesh_stand *stand_of_b(mesh_walk *w, uint32_t node)
{
    mesh_stand *s = &w->stands_b[node % MESH_STANDS];
    if (s->node == node && s->aims == w->aims) return s;
    s->node = node;
    s->aims = w->aims;
    stand_keep(s->level, mesh_lows(w->mb, &w->mb->nodes[node], w->axis_in_b));
    return s;
}

MESH_INLINE const mesh_stand *stand_of_a(mesh_walk *w, uint32_t node)
{
    mesh_stand *s = &w->stands_a[node % MESH_STANDS];
    if (s->node == node && s->aims == w->aims) return s;
    s->node = node;
    s->aims = w->aims;
    stand_keep(s->level,
        lanes_of(w->origin_level) - lanes_of(w->into_b.ratio) * mesh_lows(w->ma, &w->ma->nodes[node], w->axis_in_a));
    return s;
}

#endif
