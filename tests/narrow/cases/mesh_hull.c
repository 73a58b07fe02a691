/* mesh_hull: is a mesh the surface of its hull? And the one generated mesh that the case files name. */
#include "mesh_hull.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static bool has_edge(const double *triangles, size_t count, double from, double to)
{
    for (size_t t = 0; t < count; t++)
        for (size_t e = 0; e < 3; e++)
            if (triangles[3 * t + e] == from && triangles[3 * t + (e + 1) % 3] == to) return true;
    return false;
}

static bool closed(const double *triangles, size_t count)
{
    for (size_t t = 0; t < count; t++)
        for (size_t e = 0; e < 3; e++)
            if (!has_edge(triangles, count, triangles[3 * t + (e + 1) % 3], triangles[3 * t + e])) return false;
    return count > 0;
}

static qvec vertex(const double *vertices, double index)
{
    const double *v = vertices + 3 * (size_t)index;
    return qv(v[0], v[1], v[2]);
}

bool mesh_is_convex_solid(const double *vertices, size_t vertex_count, const double *triangles, size_t triangle_count)
{
    for (size_t i = 0; i < 3 * triangle_count; i++)
        if (!(triangles[i] >= 0 && triangles[i] < (double)vertex_count)) return false;
    if (!closed(triangles, triangle_count)) return false;
    int outward = 0; /* which way the first triangles are wound */
    for (size_t t = 0; t < triangle_count; t++) {
        qvec a = vertex(vertices, triangles[3 * t]), b = vertex(vertices, triangles[3 * t + 1]);
        qvec n = q_cross(q_sub(b, a), q_sub(vertex(vertices, triangles[3 * t + 2]), a));
        for (size_t i = 0; i < vertex_count; i++) {
            quad height = q_dot(n, q_sub(vertex(vertices, (double)i), a));
            int side = height > 0 ? 1 : height < 0 ? -1 : 0;
            if (side != 0 && outward == 0) outward = -side;
            if (side != 0 && side == outward) return false;
        }
    }
    return outward != 0;
}

const char *mesh_from_text(subject *s, const char *text)
{
    static int around = 0, rings = 0;
    static const float pi = 3.14159265f;
    double radius = 0;
    if (sscanf(text, "lat-long sphere radius %lf, %d x %d", &radius, &around, &rings) != 3 &&
        sscanf(text, "same, radius %lf", &radius) != 1)
        return "unknown generator";
    if (around < 3 || around > 256 || rings < 2 || rings > 256) return "unknown generator";
    size_t count = 0;
    double *points = calloc(3 * (size_t)around * (size_t)(rings + 1), sizeof *points);
    if (!points) abort();
    for (int ring = 0; ring <= rings; ring++) {
        float polar = pi * (float)ring / (float)rings;
        for (int i = 0; i < (ring == 0 || ring == rings ? 1 : around); i++, count++) {
            float azimuth = 2 * pi * (float)i / (float)around;
            points[3 * count] = radius * (double)(sinf(polar) * cosf(azimuth));
            points[3 * count + 1] = radius * (double)(sinf(polar) * sinf(azimuth));
            points[3 * count + 2] = radius * (double)cosf(polar);
        }
    }
    const char *why = subject_from_points(s, points, count, 0);
    free(points);
    return why;
}
