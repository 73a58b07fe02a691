/* foxglove: bodies as entities of a SceneUpdate, and their poses as FrameTransforms. An entity's primitives stand in
 * arrays by kind, so its shapes are looked through once for each kind. */
#include "foxglove.h"

#include "foxglove_put.h"
#include "index.h"

#include <stdio.h>
#include <string.h>

static const collided_pose IDENTITY = {{0, 0, 0}, {1, 0, 0, 0}};
static const double HALF_SPACE_M = 10; /* half the side of the square that stands for it */

typedef enum primitive { CUBES, SPHERES, CYLINDERS, TRIANGLES, PRIMITIVES } primitive;

typedef struct drawing { /* of one body and one kind of primitives */
    json_buffer *j;
    const triangles_kept *kept;
    primitive what;
    foxglove_color color;
    bool follows;
} drawing;

/* ---- poses ---- */

static void rotate_by(const double q[4], const double v[3], double out[3])
{
    const double w = q[0], *u = q + 1;
    double t[3] = {2 * (u[1] * v[2] - u[2] * v[1]), 2 * (u[2] * v[0] - u[0] * v[2]), 2 * (u[0] * v[1] - u[1] * v[0])};
    out[0] = v[0] + w * t[0] + u[1] * t[2] - u[2] * t[1];
    out[1] = v[1] + w * t[1] + u[2] * t[0] - u[0] * t[2];
    out[2] = v[2] + w * t[2] + u[0] * t[1] - u[1] * t[0];
}

/* `b`, which is in a's frame, in the frame that a is in. */
static collided_pose pose_within(const collided_pose *a, const collided_pose *b)
{
    const double *p = a->orientation, *q = b->orientation;
    collided_pose out;
    rotate_by(p, b->position, out.position);
    for (int i = 0; i < 3; i++) out.position[i] += a->position[i];
    out.orientation[0] = p[0] * q[0] - p[1] * q[1] - p[2] * q[2] - p[3] * q[3];
    out.orientation[1] = p[0] * q[1] + p[1] * q[0] + p[2] * q[3] - p[3] * q[2];
    out.orientation[2] = p[0] * q[2] - p[1] * q[3] + p[2] * q[0] + p[3] * q[1];
    out.orientation[3] = p[0] * q[3] + p[1] * q[2] - p[2] * q[1] + p[3] * q[0];
    return out;
}

static collided_pose moved(const collided_pose *p, double x, double y, double z)
{
    const collided_pose by = {{x, y, z}, {1, 0, 0, 0}};
    return pose_within(p, &by);
}

/* ---- primitives ---- */

static void begin_primitive(drawing *d, const collided_pose *p)
{
    json_buffer_raw(d->j, d->follows ? ",{" : "{");
    foxglove_put_pose(d->j, p);
    d->follows = true;
}

static void put_sized(drawing *d, primitive what, const collided_pose *p, double x, double y, double z)
{
    if (d->what != what) return;
    begin_primitive(d, p);
    json_buffer_raw(d->j, ",");
    foxglove_put_vector(d->j, "size", (const double[]){x, y, z});
    if (what == CYLINDERS) json_buffer_raw(d->j, ",\"bottom_scale\":1,\"top_scale\":1");
    json_buffer_raw(d->j, ",");
    foxglove_put_color(d->j, "color", d->color);
    json_buffer_raw(d->j, "}");
}

static void put_cone(drawing *d, const collided_shape *s, const collided_pose *p)
{
    if (d->what != CYLINDERS) return;
    begin_primitive(d, p);
    json_buffer_raw(d->j, ",");
    foxglove_put_vector(d->j, "size", (const double[]){2 * s->half[0], 2 * s->half[1], 2 * s->half[2]});
    json_buffer_raw(d->j, ",\"bottom_scale\":1,\"top_scale\":0,");
    foxglove_put_color(d->j, "color", d->color);
    json_buffer_raw(d->j, "}");
}

static void put_capsule(drawing *d, double radius, double half, const collided_pose *p)
{
    collided_pose ends[2] = {moved(p, 0, 0, half), moved(p, 0, 0, -half)};
    for (int i = 0; i < 2; i++) put_sized(d, SPHERES, &ends[i], 2 * radius, 2 * radius, 2 * radius);
    put_sized(d, CYLINDERS, p, 2 * radius, 2 * radius, 2 * half);
}

/* A rounded box is the union of three boxes and of capsules around its edges. */
static void put_box(drawing *d, const collided_shape *s, const collided_pose *p)
{
    static const double TURN = 0.70710678118654752; /* z to x, or to y */
    static const double ALONG[3][4] = {{TURN, 0, TURN, 0}, {TURN, -TURN, 0, 0}, {1, 0, 0, 0}};
    const double *h = s->half, r = s->radius;
    if (r <= 0) {
        put_sized(d, CUBES, p, 2 * h[0], 2 * h[1], 2 * h[2]);
        return;
    }
    for (int axis = 0; axis < 3; axis++) {
        double more[3] = {0, 0, 0};
        more[axis] = r;
        put_sized(d, CUBES, p, 2 * (h[0] + more[0]), 2 * (h[1] + more[1]), 2 * (h[2] + more[2]));
        for (int corner = 0; corner < 4; corner++) {
            collided_pose edge = IDENTITY;
            memcpy(edge.orientation, ALONG[axis], sizeof edge.orientation);
            edge.position[(axis + 1) % 3] = (corner & 1 ? 1 : -1) * h[(axis + 1) % 3];
            edge.position[(axis + 2) % 3] = (corner & 2 ? 1 : -1) * h[(axis + 2) % 3];
            collided_pose placed = pose_within(p, &edge);
            put_capsule(d, r, h[axis], &placed);
        }
    }
}

static void put_triangles(drawing *d, const triangles *t, const collided_pose *p)
{
    if (d->what != TRIANGLES || !t || !t->index_count) return;
    begin_primitive(d, p);
    json_buffer_raw(d->j, ",\"points\":[");
    for (size_t i = 0; i < t->point_count; i++)
        json_buffer_print(d->j, "%s{\"x\":%.9g,\"y\":%.9g,\"z\":%.9g}", i ? "," : "", t->points[3 * i],
            t->points[3 * i + 1], t->points[3 * i + 2]);
    json_buffer_raw(d->j, "],");
    foxglove_put_color(d->j, "color", d->color);
    json_buffer_raw(d->j, ",\"colors\":[],\"indices\":[");
    for (size_t i = 0; i < t->index_count; i++) json_buffer_print(d->j, "%s%u", i ? "," : "", t->indices[i]);
    json_buffer_raw(d->j, "]}");
}

static void put_shape(drawing *d, const collided_shape *s, uint32_t geometry, const collided_pose *p)
{
    switch (s->type) {
    case COLLIDED_SPHERE:
        put_sized(d, SPHERES, p, 2 * s->radius, 2 * s->radius, 2 * s->radius);
        return;
    case COLLIDED_CAPSULE:
        put_capsule(d, s->radius, s->half[2], p);
        return;
    case COLLIDED_BOX:
        put_box(d, s, p);
        return;
    case COLLIDED_CYLINDER:
        put_sized(d, CYLINDERS, p, 2 * s->half[0], 2 * s->half[1], 2 * s->half[2]);
        return;
    case COLLIDED_CONE:
        put_cone(d, s, p);
        return;
    case COLLIDED_ELLIPSOID:
        put_sized(d, SPHERES, p, 2 * s->half[0], 2 * s->half[1], 2 * s->half[2]);
        return;
    case COLLIDED_HALFSPACE:
        put_sized(d, CUBES, p, 2 * HALF_SPACE_M, 2 * HALF_SPACE_M, 0.001);
        return;
    case COLLIDED_HULL:
    case COLLIDED_MESH:
    case COLLIDED_HEIGHT_FIELD:
    case COLLIDED_SOFT:
        put_triangles(d, triangles_get(d->kept, geometry), p);
        return;
    default:
        return; /* a compound: its children stand behind it */
    }
}

static void put_primitives(json_buffer *j, const mirror_body *b, const triangles_kept *k, primitive what,
    const char *name, foxglove_color color)
{
    drawing d = {.j = j, .kept = k, .what = what, .color = color};
    json_buffer_print(j, "\"%s\":[", name);
    size_t children = 0;
    collided_pose compound = IDENTITY;
    for (size_t i = 0; i < b->shape_count; i++) {
        const collided_shape *s = &b->shapes[i];
        collided_pose p = children ? pose_within(&compound, &s->pose) : s->pose;
        if (children) children--;
        if (s->type == COLLIDED_COMPOUND) {
            children = s->child_count;
            compound = s->pose;
        }
        put_shape(&d, s, b->geometries[i], &p);
    }
    json_buffer_raw(j, "],");
}

/* ---- entities ---- */

static foxglove_color color_of(const mirror_body *b)
{
    static const foxglove_color COLORS[] = {{0.30, 0.55, 0.85, 1}, {0.90, 0.55, 0.20, 1}, {0.35, 0.70, 0.40, 1},
        {0.70, 0.45, 0.80, 1}, {0.80, 0.70, 0.25, 1}, {0.35, 0.70, 0.75, 1}};
    foxglove_color c = COLORS[index_mix_text(1, b->owner) % (sizeof COLORS / sizeof COLORS[0])];
    if (b->flags & COLLIDED_SEEN_FIXED) c = (foxglove_color){0.6, 0.6, 0.6, 1};
    if (b->flags & (COLLIDED_SEEN_STALE | COLLIDED_SEEN_HELD)) c.a = 0.4;
    return c;
}

static const char *word_of(const mirror_body *b)
{
    if (b->flags & COLLIDED_SEEN_HELD) return "held: its client is lost";
    if (b->flags & COLLIDED_SEEN_STALE) return "stale: its pairs are unknown";
    return b->flags & COLLIDED_SEEN_PENDING ? "pending" : "";
}

static void put_pair(json_buffer *j, const char *key, const char *value, bool follows)
{
    json_buffer_raw(j, follows ? ",{\"key\":" : "{\"key\":");
    json_buffer_text(j, key);
    json_buffer_raw(j, ",\"value\":");
    json_buffer_text(j, value);
    json_buffer_raw(j, "}");
}

static void put_metadata(json_buffer *j, const mirror_body *b)
{
    json_buffer_raw(j, "\"metadata\":[");
    put_pair(j, "client", b->owner, false);
    put_pair(j, "group", b->group, true);
    if (*word_of(b)) put_pair(j, "state", word_of(b), true);
    for (size_t i = 0; i < b->shape_count; i++) {
        const collided_shape *s = &b->shapes[i];
        char text[64];
        bool drawn = s->type == COLLIDED_SPHERE || s->type == COLLIDED_CAPSULE || s->type == COLLIDED_BOX;
        if (drawn || !(s->radius > 0)) continue;
        snprintf(text, sizeof text, "shape %zu: %g m, not drawn", i, s->radius);
        put_pair(j, "rounding", text, true);
    }
    json_buffer_raw(j, "],");
}

static void put_frame(json_buffer *j, const char *name, const char *body)
{
    char text[512];
    snprintf(text, sizeof text, "body:%s", body);
    json_buffer_print(j, "\"%s\":", name);
    json_buffer_text(j, text);
}

static void put_texts(json_buffer *j, const mirror_body *b)
{
    char text[512];
    json_buffer_raw(j, "\"texts\":[");
    if (*word_of(b)) {
        snprintf(text, sizeof text, "%s: %s", b->name, word_of(b));
        json_buffer_raw(j, "{");
        foxglove_put_pose(j, &IDENTITY);
        json_buffer_raw(j, ",\"billboard\":true,\"font_size\":14,\"scale_invariant\":true,");
        foxglove_put_color(j, "color", (foxglove_color){0.8, 0.1, 0.1, 1});
        json_buffer_raw(j, ",\"text\":");
        json_buffer_text(j, text);
        json_buffer_raw(j, "}");
    }
    json_buffer_raw(j, "],\"models\":[]}");
}

static void put_entity(json_buffer *j, const mirror_body *b, const triangles_kept *k, int64_t stamp_ns)
{
    foxglove_color color = color_of(b);
    json_buffer_raw(j, "{");
    foxglove_put_stamp(j, "timestamp", stamp_ns);
    json_buffer_raw(j, ",");
    put_frame(j, "frame_id", b->name);
    json_buffer_raw(j, ",\"id\":");
    json_buffer_text(j, b->name);
    json_buffer_raw(j, ",\"lifetime\":{\"sec\":0,\"nsec\":0},\"frame_locked\":true,");
    put_metadata(j, b);
    json_buffer_raw(j, "\"arrows\":[],\"lines\":[],");
    put_primitives(j, b, k, CUBES, "cubes", color);
    put_primitives(j, b, k, SPHERES, "spheres", color);
    put_primitives(j, b, k, CYLINDERS, "cylinders", color);
    put_primitives(j, b, k, TRIANGLES, "triangles", color);
    put_texts(j, b);
}

void foxglove_scene(json_buffer *j, const mirror *m, const triangles_kept *k, int64_t stamp_ns)
{
    bool follows = false;
    json_buffer_raw(j, "{\"deletions\":[{");
    foxglove_put_stamp(j, "timestamp", stamp_ns);
    json_buffer_raw(j, ",\"type\":1,\"id\":\"\"}],\"entities\":[");
    for (size_t i = 0; i < m->body_count; i++) {
        if (!m->bodies[i].live) continue;
        if (follows) json_buffer_raw(j, ",");
        put_entity(j, &m->bodies[i], k, stamp_ns);
        follows = true;
    }
    json_buffer_raw(j, "]}");
}

uint64_t foxglove_looks(const mirror *m)
{
    enum { LOOKS = COLLIDED_SEEN_STALE | COLLIDED_SEEN_HELD | COLLIDED_SEEN_PENDING | COLLIDED_SEEN_FIXED };
    uint64_t h = 1;
    for (size_t i = 0; i < m->body_count; i++)
        if (m->bodies[i].live && m->bodies[i].flags & LOOKS) h = index_mix(index_mix(h, i), m->bodies[i].flags & LOOKS);
    return h;
}

size_t foxglove_transforms(json_buffer *j, const mirror *m, uint64_t since, int64_t stamp_ns)
{
    size_t count = 0;
    json_buffer_raw(j, "{\"transforms\":[");
    for (size_t i = 0; i < m->body_count; i++) {
        const mirror_body *b = &m->bodies[i];
        if (!b->live || b->posed <= since) continue;
        json_buffer_raw(j, count++ ? ",{" : "{");
        foxglove_put_stamp(j, "timestamp", stamp_ns);
        json_buffer_raw(j, ",\"parent_frame_id\":\"world\",");
        put_frame(j, "child_frame_id", b->name);
        json_buffer_raw(j, ",");
        foxglove_put_vector(j, "translation", b->pose.position);
        json_buffer_raw(j, ",");
        foxglove_put_rotation(j, "rotation", b->pose.orientation);
        json_buffer_raw(j, "}");
    }
    json_buffer_raw(j, "]}");
    return count;
}
