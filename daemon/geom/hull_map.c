/* hull_map: which hulls have one, and the copy into columns. Any thread. */
#include "hull_map.h"

#include "round.h"

static int padded(uint32_t count)
{
    return (int)(count + HULL_MAP_LANES - 1) / HULL_MAP_LANES * HULL_MAP_LANES;
}

/* Euler: no hull of triangles has more or fewer. */
static uint32_t face_count_of(uint32_t vertex_count)
{
    return 2 * vertex_count - 4;
}

static uint32_t arc_count_of(uint32_t vertex_count)
{
    return 3 * vertex_count - 6;
}

size_t hull_map_room(uint32_t vertex_count)
{
    if (vertex_count < 4 || vertex_count > HULL_MAP_VERTICES_MAX) return 0;
    size_t faces = (size_t)padded(face_count_of(vertex_count)), arcs = (size_t)padded(arc_count_of(vertex_count));
    return sizeof(hull_map) + 4 * faces * sizeof(float) + arcs * sizeof(int32_t);
}

/* Of the numbers that squares and cubes are made of below. */
static bool is_sized(const hull *h)
{
    return h->max_abs > 0x1p-200 && h->max_abs < 0x1p200;
}

/* The stored plane beside that of the exact corners: see hull_map.h. A height errs by 4 u of its terms. */
static bool is_sure(const hull *h, const hull_face *f)
{
    const uint32_t *loop = &h->face_vertices[f->first];
    double lowest = f->offset, longest2 = 0;
    vec3 v[3];
    if (f->count != 3) return false;
    for (int k = 0; k < 3; k++) {
        v[k] = hull_vertex(h, loop[k]);
        lowest = fmin(lowest, vec_dot(f->normal, v[k]));
    }
    for (int k = 0; k < 3; k++) longest2 = fmax(longest2, vec_norm2(vec_sub(v[(k + 1) % 3], v[k])));
    double twice_area = vec_norm(vec_cross(vec_sub(v[1], v[0]), vec_sub(v[2], v[0])));
    double off = f->offset - lowest + 16 * ROUND_U * h->max_abs;
    return off * sqrt(longest2) <= 0.5 * HULL_MAP_ANGLE * twice_area;
}

static bool applies(const hull *h)
{
    uint32_t count = h->vertex_count;
    if (h->face_count == 0 || !hull_map_room(count) || !is_sized(h)) return false;
    for (uint32_t i = 0; i < h->face_count; i++)
        if (!is_sure(h, &h->faces[i])) return false;
    for (uint32_t i = 0; i < h->edge_count; i++)
        if (vec_dot(h->faces[h->edges[i].f0].normal, h->faces[h->edges[i].f1].normal) < HULL_MAP_LEAST_COSINE)
            return false;
    return h->face_count == face_count_of(count) && h->edge_count == arc_count_of(count);
}

static uint32_t least_of(uint32_t i, uint32_t last)
{
    return i < last ? i : last;
}

static void put_faces(const hull *h, hull_map *m)
{
    int exponent;
    frexp(h->max_abs, &exponent);
    m->unit = ldexp(1, exponent);
    for (int i = 0; i < m->padded_faces; i++) {
        const hull_face *f = &h->faces[least_of((uint32_t)i, h->face_count - 1)];
        m->normal_x[i] = (float)f->normal.x;
        m->normal_y[i] = (float)f->normal.y;
        m->normal_z[i] = (float)f->normal.z;
        m->offset[i] = (float)(f->offset / m->unit);
    }
}

static int32_t arc_of(const hull *h, const hull_edge *e)
{
    double twice_cosine = 2 * vec_dot(h->faces[e->f0].normal, h->faces[e->f1].normal);
    uint32_t in_255ths = (uint32_t)(int32_t)fmin(ceil(HULL_ARC_ONE * twice_cosine), 2 * HULL_ARC_ONE);
    return (int32_t)(e->f0 | e->f1 << HULL_ARC_F1 | e->v0 << HULL_ARC_V0 | e->v1 << HULL_ARC_V1 |
                     in_255ths << HULL_ARC_COSINE);
}

static void put_arcs(const hull *h, hull_map *m)
{
    for (int i = 0; i < m->padded_arcs; i++) m->arc[i] = arc_of(h, &h->edges[least_of((uint32_t)i, h->edge_count - 1)]);
}

hull_map *hull_map_build(const hull *h, void *room)
{
    if (!applies(h)) return NULL;
    hull_map *m = room;
    m->padded_faces = padded(h->face_count);
    m->padded_arcs = padded(h->edge_count);
    m->normal_x = (float *)(m + 1);
    m->normal_y = m->normal_x + m->padded_faces;
    m->normal_z = m->normal_y + m->padded_faces;
    m->offset = m->normal_z + m->padded_faces;
    m->arc = (int32_t *)(m->offset + m->padded_faces);
    put_faces(h, m);
    put_arcs(h, m);
    return m;
}
