/* body: the meshes and heights of a body are read here, and meshes become what their shapes ask for. */
#include "body.h"

#include "decompose/decompose.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

bool load_meshes_parse(const char *text, load_meshes *out)
{
    static const char decompose[] = "decompose";
    size_t length = sizeof decompose - 1;
    *out = (load_meshes){.as = LOAD_MESH_HULL};
    if (strcmp(text, "hull") == 0) return true;
    out->as = LOAD_MESH_SOLID;
    if (strcmp(text, "solid") == 0) return true;
    out->as = LOAD_MESH_DECOMPOSE;
    if (strcmp(text, decompose) == 0) return true;
    if (strncmp(text, decompose, length) != 0 || text[length] != ':') return false;
    const char *digits = text + length + 1;
    size_t count = strspn(digits, "0123456789");
    if (count == 0 || count > 3 || digits[count]) return false;
    for (; *digits; digits++) out->pieces = 10 * out->pieces + (size_t)(*digits - '0');
    return out->pieces >= 1 && out->pieces <= DECOMPOSE_PIECES_MAX;
}

void load_shape_becomes(load_shape *s, const load_meshes *meshes)
{
    s->meshes = *meshes;
    s->shape.type = meshes->as == LOAD_MESH_SOLID ? COLLIDED_MESH : COLLIDED_HULL;
}

static void note_decomposition(const load_shape *from, const decomposition *d, load_report *r)
{
    char repaired[128] = "";
    if (d->united || d->dropped)
        snprintf(repaired, sizeof repaired, "; %zu corners united, %zu triangles without area left out", d->united,
            d->dropped);
    load_note(r, "%s: %zu triangles became %zu hull%s, at most %.3g mm beyond the %s%s", from->mesh,
        from->triangles.count, d->count, d->count == 1 ? "" : "s", 1e3 * d->deviation_m,
        d->closed ? "solid" : "open surface", repaired);
}

/* The shape's hulls go to `out`: false if there is no room for them. */
static bool decompose_shape(pool *p, load_shape *s, load_shape *out, size_t room, size_t *count, load_report *r)
{
    decomposition d;
    decompose_options o = {s->meshes.pieces, s->meshes.deviation_m, s->mesh};
    if (!mesh_load_triangles(p, s->mesh, s->scale, &s->triangles, r)) return false;
    if (!decompose_mesh(p, &s->triangles, &o, &d, r)) return false;
    note_decomposition(s, &d, r);
    if (d.count > room)
        return load_fail(
            r, "%s: its %zu hulls are more than the %d shapes that a body may have", s->mesh, d.count, LOAD_SHAPES_MAX);
    for (size_t i = 0; i < d.count; i++) {
        out[i] = *s;
        out[i].mesh = NULL; /* it is read */
        out[i].points = d.hulls[i].points;
        out[i].shape.radius += d.radius;
        out[i].shape.deviation = d.hulls[i].deviation_m;
    }
    *count += d.count;
    return true;
}

static bool load_mesh(pool *p, load_shape *s, load_report *r)
{
    if (!s->mesh) return true;
    bool triangles = s->shape.type == COLLIDED_MESH;
    return triangles ? mesh_load_triangles(p, s->mesh, s->scale, &s->triangles, r)
                     : mesh_load(p, s->mesh, s->scale, &s->points, r);
}

static bool load_files(pool *p, load_shape *s, load_report *r)
{
    load_heights *h = &s->heights;
    if (h->path && !heights_load(p, h->path, h->range, &h->grid, r)) return false;
    if (!load_mesh(p, s, r)) return false;
    for (size_t k = 0; k < s->child_count; k++)
        if (!load_mesh(p, &s->children[k], r)) return false;
    return true;
}

static double shape_excess(pool *p, const load_shape *s)
{
    double excess = s->shape.deviation;
    mesh_triangles triangles;
    decomposition d;
    load_report untold = {.error = ""};
    decompose_options one = {.pieces_max = 1, .name = s->mesh};
    if (s->mesh && s->shape.type == COLLIDED_HULL) {
        if (!mesh_load_triangles(p, s->mesh, s->scale, &triangles, &untold) ||
            !decompose_mesh(p, &triangles, &one, &d, &untold))
            return NAN;
        excess += d.deviation_m;
    }
    for (size_t k = 0; k < s->child_count; k++) {
        double child = shape_excess(p, &s->children[k]) + s->shape.deviation;
        if (!(child <= excess)) excess = child;
    }
    return excess;
}

double load_body_excess(const load_body *body)
{
    double most = 0;
    for (size_t i = 0; i < body->shape_count && !isnan(most); i++) {
        pool work = {0};
        double excess = shape_excess(&work, &body->shapes[i]);
        if (!(excess <= most)) most = excess;
        pool_free(&work);
    }
    return most;
}

/* It and its children. */
static size_t flat_count(const load_shape *s)
{
    return 1 + s->child_count;
}

bool load_body_meshes(pool *p, load_body *body, load_report *r)
{
    load_shape *all = pool_alloc(p, LOAD_SHAPES_MAX, sizeof *all);
    size_t count = 0, used = 0, rest = 0;
    for (size_t i = 0; i < body->shape_count; i++) rest += flat_count(&body->shapes[i]);
    for (size_t i = 0; i < body->shape_count; i++) {
        load_shape *s = &body->shapes[i];
        rest -= flat_count(s);
        bool decomposed = s->mesh && s->meshes.as == LOAD_MESH_DECOMPOSE;
        size_t before = count, room = LOAD_SHAPES_MAX - used - rest;
        if (decomposed ? !decompose_shape(p, s, all + count, room, &count, r) : !load_files(p, s, r)) return false;
        if (!decomposed) all[count++] = *s;
        used += decomposed ? count - before : flat_count(s);
    }
    body->shapes = all;
    body->shape_count = count;
    return true;
}
