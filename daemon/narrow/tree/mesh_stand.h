/* mesh_stand: how far the patches of nodes of two meshes reach along the axis of a walk, and where those of A are as
 * B's nodes see them; what floats hold of that. For mesh_walk.c. What is known of a node serves
 * each pair that it is in. Pure; any thread. */
#ifndef COLLIDED_NARROW_TREE_MESH_STAND_H
#define COLLIDED_NARROW_TREE_MESH_STAND_H

#include "mesh_place.h"

LANES_INLINE void stand_keep(float to[MESH_WIDTH], mesh_lanes v)
{
    memcpy(to, &v, sizeof v);
}

LANES_INLINE const mesh_stand *stand_of_b(mesh_walk *w, uint32_t node)
{
    mesh_stand *s = &w->stands_b[node % MESH_STANDS];
    if (s->node == node && s->aims == w->aims) return s;
    s->node = node;
    s->aims = w->aims;
    stand_keep(s->level, mesh_lows(w->mb, &w->mb->nodes[node], w->axis_in_b));
    return s;
}

LANES_INLINE const mesh_stand *stand_of_a(mesh_walk *w, uint32_t node)
{
    mesh_stand *s = &w->stands_a[node % MESH_STANDS];
    if (s->node == node && s->aims == w->aims) return s;
    s->node = node;
    s->aims = w->aims;
    stand_keep(s->level,
        lanes_of(w->origin_level) - lanes_of(w->into_b.ratio) * mesh_lows(w->ma, &w->ma->nodes[node], w->axis_in_a));
    return s;
}

/* A coordinate of four centres, in doubles: there terms may cancel. */
LANES_INLINE mesh_lanes faces_centre(const mesh_node *n, double x, double y, double z, double t)
{
    lanes cx = __builtin_convertvector(lanes_load(n->centre[0]), lanes);
    lanes cy = __builtin_convertvector(lanes_load(n->centre[1]), lanes);
    lanes cz = __builtin_convertvector(lanes_load(n->centre[2]), lanes);
    return __builtin_convertvector(cx * x + cy * y + cz * z + t, mesh_lanes);
}

/* Four vectors turned, to[k] the k-th, as a row. Returns the sums of their coordinates' absolute values. */
LANES_INLINE mesh_lanes faces_turned(const mesh_turn *t, float ratio, const float v[3][MESH_WIDTH], mesh_lanes to[4])
{
    const mesh_lanes in[3] = {lanes_load(v[0]), lanes_load(v[1]), lanes_load(v[2])};
    for (int i = 0; i < 3; i++) {
        const float row[3] = {t->column[0][i], t->column[1][i], t->column[2][i]};
        to[i] = lanes_dot(in, row) * lanes_of(ratio);
    }
    to[3] = lanes_of(0);
    mesh_lanes sum = lanes_abs(to[0]) + lanes_abs(to[1]) + lanes_abs(to[2]);
    lanes_turn(to);
    return sum;
}

/* As `face` of mesh_walk.c, four at once. */
LANES_INLINE void faces_set(const mesh_turn *t, const mesh_node *n, mesh_faces *f)
{
    mesh_lanes centre[4] = {faces_centre(n, t->r.x.x, t->r.y.x, t->r.z.x, t->t.x),
        faces_centre(n, t->r.x.y, t->r.y.y, t->r.z.y, t->t.y), faces_centre(n, t->r.x.z, t->r.y.z, t->r.z.z, t->t.z)};
    mesh_lanes side_0[4], side_1[4], normal[4], half = lanes_of(t->ratio) * lanes_load(n->half);
    mesh_lanes reach = lanes_abs(centre[0]) + lanes_abs(centre[1]) + lanes_abs(centre[2]);
    centre[3] = lanes_of(0);
    lanes_turn(centre);
    reach += faces_turned(t, t->ratio, n->side[0], side_0);
    reach += faces_turned(t, t->ratio, n->side[1], side_1);
    reach += faces_turned(t, 1, n->normal, normal) * half;
    mesh_lanes slack = lanes_of(FLOAT_SLACK) * (reach + lanes_of(4));
    for (uint32_t k = 0; k < MESH_WIDTH; k++) {
        mesh_patch_box *o = &f->box[k];
        stand_keep(o->centre, centre[k]);
        stand_keep(o->side[0], side_0[k]);
        stand_keep(o->side[1], side_1[k]);
        stand_keep(o->normal, normal[k]);
        o->half = half[k];
        o->slack = slack[k];
    }
}

LANES_INLINE const mesh_patch_box *faces_of_a(mesh_walk *w, uint32_t node)
{
    uint32_t room = node % MESH_FACES;
    if (w->faced[room] != node) faces_set(&w->into_b, &w->ma->nodes[node], &w->faces_a[room]);
    w->faced[room] = node;
    return w->faces_a[room].box;
}

#endif
