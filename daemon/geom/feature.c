/* Faces and edges that face a direction. Pure; any thread. Ids depend on the shape alone: bits of signs for a box's
 * corners, vertex and face indices for a hull, eighths of the rim for discs. */
#include "feature.h"

#include "hull.h"
#include "support.h"

enum {
    DISC_CORNERS = 8,
    ID_TOP = 0, /* of the rims and ends at z > 0 */
    ID_BOTTOM = DISC_CORNERS,
};

static void add_corner(feature *f, vec3 at, uint32_t id)
{
    f->corner[f->count] = at;
    f->corner_id[f->count++] = id;
}

static double *component(vec3 *v, int k)
{
    return k == 0 ? &v->x : k == 1 ? &v->y : &v->z;
}

/* A corner's id has bit k set where coordinate k is positive. */
static void add_box_corner(feature *f, vec3 half, uint32_t signs)
{
    add_corner(f, vec(signs & 1 ? half.x : -half.x, signs & 2 ? half.y : -half.y, signs & 4 ? half.z : -half.z), signs);
}

static void box_face(const shape *s, vec3 d, feature *out)
{
    int k = 0;
    if (fabs(d.y) > fabs(d.x)) k = 1;
    if (fabs(d.z) > fmax(fabs(d.x), fabs(d.y))) k = 2;
    bool up = *component(&d, k) >= 0;
    uint32_t here = up ? 1u << k : 0, u = 1u << (k + 1) % 3, v = 1u << (k + 2) % 3;
    const uint32_t around[4] = {here | u | v, here | v, here, here | u}; /* counter-clockwise about +k */
    for (int i = 0; i < 4; i++) add_box_corner(out, s->half, around[up ? i : 3 - i]);
    *component(&out->normal, k) = up ? 1 : -1;
    out->face_id = 2 * (uint32_t)k + up;
}

static void disc(double r, double z, bool up, feature *out)
{
    const double h = 0x1.6a09e667f3bccp-1; /* sqrt(1/2), rounded down */
    const double rim[DISC_CORNERS][2] = {{1, 0}, {h, h}, {0, 1}, {-h, h}, {-1, 0}, {-h, -h}, {0, -1}, {h, -h}};
    for (uint32_t i = 0; i < DISC_CORNERS; i++) {
        uint32_t k = up ? i : DISC_CORNERS - 1 - i;
        add_corner(out, vec(r * rim[k][0], r * rim[k][1], z), (up ? ID_TOP : ID_BOTTOM) + k);
    }
    out->normal = vec(0, 0, up ? 1 : -1);
    out->face_id = up;
}

static void cylinder_side(const shape *s, vec3 d, feature *out)
{
    vec3 radial = vec_unit(vec(d.x, d.y, 0));
    add_corner(out, vec(s->half.x * radial.x, s->half.x * radial.y, s->half.z), ID_TOP);
    add_corner(out, vec(s->half.x * radial.x, s->half.x * radial.y, -s->half.z), ID_BOTTOM);
    out->face_id = 2;
}

static void cone_side(const shape *s, vec3 d, feature *out)
{
    vec3 radial = vec_unit(vec(d.x, d.y, 0));
    add_corner(out, vec(0, 0, s->half.z), ID_TOP);
    add_corner(out, vec(s->half.x * radial.x, s->half.x * radial.y, -s->half.z), ID_BOTTOM);
    out->face_id = 2;
}

static void capsule_side(const shape *s, feature *out)
{
    add_corner(out, vec(0, 0, s->half.z), ID_TOP);
    add_corner(out, vec(0, 0, -s->half.z), ID_BOTTOM);
    out->face_id = 2;
}

/* The side's normal has the radial part 2 h and the axial part r. */
static bool cone_base_faces(const shape *s, vec3 d)
{
    vec3 side = vec_unit(vec(2 * s->half.z, 0, s->half.x));
    return -d.z >= side.x * sqrt(d.x * d.x + d.y * d.y) + side.z * d.z;
}

/* Of two points without a face: the segment between them, as a capsule's. */
static void hull_side(const hull *h, vec3 d, feature *out)
{
    uint32_t best = 0;
    if (h->face_count == 0 && h->vertex_count == 2)
        for (uint32_t i = 0; i < 2; i++) add_corner(out, hull_vertex(h, i), i);
    if (h->face_count == 0) return;
    for (uint32_t f = 1; f < h->face_count; f++)
        if (vec_dot(h->faces[f].normal, d) > vec_dot(h->faces[best].normal, d)) best = f;
    const hull_face *face = &h->faces[best];
    uint32_t count = face->count < FEATURE_CORNERS_MAX ? face->count : FEATURE_CORNERS_MAX;
    for (uint32_t i = 0; i < count; i++) {
        uint32_t vertex = h->face_vertices[face->first + (uint64_t)i * face->count / count];
        add_corner(out, hull_vertex(h, vertex), vertex);
    }
    out->normal = face->normal;
    out->face_id = best;
}

static void clear(feature *out)
{
    out->count = 0;
    out->unbounded = false;
    out->normal = VEC_ZERO;
    out->face_id = 0;
}

void feature_facing(const shape *s, vec3 d, feature *out)
{
    clear(out);
    switch (s->type) {
    case SHAPE_CAPSULE:
        capsule_side(s, out);
        break;
    case SHAPE_BOX:
        box_face(s, d, out);
        break;
    case SHAPE_CYLINDER:
        if (d.z * d.z >= d.x * d.x + d.y * d.y)
            disc(s->half.x, d.z >= 0 ? s->half.z : -s->half.z, d.z >= 0, out);
        else
            cylinder_side(s, d, out);
        break;
    case SHAPE_CONE:
        if (cone_base_faces(s, d))
            disc(s->half.x, -s->half.z, false, out);
        else
            cone_side(s, d, out);
        break;
    case SHAPE_HALFSPACE:
        out->unbounded = true;
        out->normal = vec(0, 0, 1);
        break;
    case SHAPE_HULL:
        hull_side(s->hull, d, out);
        break;
    default:
        break;
    }
}

static bool is_perpendicular(vec3 edge, vec3 d, double sine)
{
    return fabs(vec_dot(edge, d)) <= sine * vec_norm(edge);
}

/* Along the axis of the box that is most nearly perpendicular; of two that are it equally, along the longer. */
static void box_edge(const shape *s, vec3 d, feature *out)
{
    const double along[3] = {fabs(d.x), fabs(d.y), fabs(d.z)}, half[3] = {s->half.x, s->half.y, s->half.z};
    int k = 0;
    for (int i = 1; i < 3; i++)
        if (along[i] < along[k] || (along[i] == along[k] && half[i] > half[k])) k = i;
    uint32_t signs = (d.x >= 0 ? 1u : 0) | (d.y >= 0 ? 2u : 0) | (d.z >= 0 ? 4u : 0);
    add_box_corner(out, s->half, signs | 1u << k);
    add_box_corner(out, s->half, signs & ~(1u << k));
    out->face_id = 6 + (uint32_t)k;
}

/* The edge at the highest vertex that is most nearly perpendicular. */
static void hull_edge_at_top(const hull *h, const shape *s, vec3 d, feature *out)
{
    uint32_t top = 0, best = UINT32_MAX;
    double least = INFINITY;
    support_core(s, d, &top);
    for (uint32_t i = h->neighbour_first[top]; i < h->neighbour_first[top + 1]; i++) {
        double slope = -vec_dot(vec_unit(vec_sub(hull_vertex(h, h->neighbours[i]), hull_vertex(h, top))), d);
        if (slope < least) {
            least = slope;
            best = h->neighbours[i];
        }
    }
    if (best == UINT32_MAX) return;
    uint32_t first = best < top ? best : top, second = best < top ? top : best;
    add_corner(out, hull_vertex(h, first), first);
    add_corner(out, hull_vertex(h, second), second);
    out->face_id = first;
}

bool feature_edge(const shape *s, vec3 d, double sine, feature *out)
{
    clear(out);
    switch (s->type) {
    case SHAPE_CAPSULE:
        capsule_side(s, out);
        break;
    case SHAPE_BOX:
        box_edge(s, d, out);
        break;
    case SHAPE_CYLINDER:
        cylinder_side(s, d, out);
        break;
    case SHAPE_CONE:
        cone_side(s, d, out);
        break;
    case SHAPE_HULL:
        hull_edge_at_top(s->hull, s, d, out);
        break;
    default:
        break;
    }
    return out->count == 2 && is_perpendicular(vec_sub(out->corner[0], out->corner[1]), d, sine);
}
