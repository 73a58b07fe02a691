/* Meshes for tests. */
#include "solids.h"

#include <stdlib.h>
#include <string.h>

soup soup_new(void)
{
    return (soup){calloc(3 * SOUP_MAX, sizeof(double)), 0, calloc(3 * SOUP_MAX, sizeof(int32_t)), 0};
}

void soup_free(soup *s)
{
    free(s->points);
    free(s->corners);
}

int32_t soup_point(soup *s, vec3 p)
{
    if (s->point_count >= SOUP_MAX) abort();
    double *to = s->points + 3 * s->point_count;
    to[0] = p.x;
    to[1] = p.y;
    to[2] = p.z;
    return (int32_t)s->point_count++;
}

void soup_triangle(soup *s, int32_t a, int32_t b, int32_t c)
{
    if (s->triangle_count >= SOUP_MAX) abort();
    int32_t *to = s->corners + 3 * s->triangle_count++;
    to[0] = a;
    to[1] = b;
    to[2] = c;
}

void soup_quad(soup *s, int32_t a, int32_t b, int32_t c, int32_t d)
{
    soup_triangle(s, a, b, c);
    soup_triangle(s, a, c, d);
}

static vec3 point_of(const soup *s, int32_t i)
{
    return vec(s->points[3 * i], s->points[3 * i + 1], s->points[3 * i + 2]);
}

soup soup_icosphere(double radius, int subdivisions)
{
    static const int32_t FACES[20][3] = {{0, 11, 5}, {0, 5, 1}, {0, 1, 7}, {0, 7, 10}, {0, 10, 11}, {1, 5, 9},
        {5, 11, 4}, {11, 10, 2}, {10, 7, 6}, {7, 1, 8}, {3, 9, 4}, {3, 4, 2}, {3, 2, 6}, {3, 6, 8}, {3, 8, 9},
        {4, 9, 5}, {2, 4, 11}, {6, 2, 10}, {8, 6, 7}, {9, 8, 1}};
    const double g = 1.618033988749895;
    const vec3 corners[12] = {{-1, g, 0}, {1, g, 0}, {-1, -g, 0}, {1, -g, 0}, {0, -1, g}, {0, 1, g}, {0, -1, -g},
        {0, 1, -g}, {g, 0, -1}, {g, 0, 1}, {-g, 0, -1}, {-g, 0, 1}};
    soup s = soup_new();
    for (int i = 0; i < 20; i++) {
        int32_t p[3];
        for (int k = 0; k < 3; k++) p[k] = soup_point(&s, vec_scale(vec_unit(corners[FACES[i][k]]), radius));
        soup_triangle(&s, p[0], p[1], p[2]);
    }
    for (int round = 0; round < subdivisions; round++) {
        soup next = soup_new();
        for (size_t t = 0; t < s.triangle_count; t++) {
            vec3 v[3], m[3];
            for (int k = 0; k < 3; k++) v[k] = point_of(&s, s.corners[3 * t + (size_t)k]);
            for (int k = 0; k < 3; k++) m[k] = vec_scale(vec_unit(vec_add(v[k], v[(k + 1) % 3])), radius);
            const vec3 parts[4][3] = {{v[0], m[0], m[2]}, {m[0], v[1], m[1]}, {m[2], m[1], v[2]}, {m[0], m[1], m[2]}};
            for (int i = 0; i < 4; i++) { /* one after the other: C evaluates arguments in any order */
                int32_t p[3];
                for (int k = 0; k < 3; k++) p[k] = soup_point(&next, parts[i][k]);
                soup_triangle(&next, p[0], p[1], p[2]);
            }
        }
        soup_free(&s);
        s = next;
    }
    return s; /* each triangle has corners of its own: welding is put to work */
}

soup soup_box(double hx, double hy, double hz, int cuts)
{
    soup s = soup_new();
    const vec3 half = {hx, hy, hz};
    for (int face = 0; face < 6; face++) {
        double side = face & 1 ? 1 : -1;
        for (int i = 0; i < cuts; i++) {
            for (int k = 0; k < cuts; k++) {
                int32_t at[4];
                for (int c = 0; c < 4; c++) {
                    double u = 2.0 * (i + (c == 1 || c == 2)) / cuts - 1, v = 2.0 * (k + (c >= 2)) / cuts - 1;
                    double n[3];
                    n[face / 2] = side;
                    n[(face / 2 + 1) % 3] = u;
                    n[(face / 2 + 2) % 3] = v;
                    at[c] = soup_point(&s, vec(n[0] * half.x, n[1] * half.y, n[2] * half.z));
                }
                if (side > 0)
                    soup_quad(&s, at[0], at[1], at[2], at[3]);
                else
                    soup_quad(&s, at[3], at[2], at[1], at[0]);
            }
        }
    }
    return s;
}

soup soup_torus(double ring, double tube, int around, int across)
{
    soup s = soup_new();
    for (int i = 0; i < around; i++)
        for (int k = 0; k < across; k++) {
            double a = 2 * M_PI * i / around, b = 2 * M_PI * k / across, r = ring + tube * cos(b);
            soup_point(&s, vec(r * cos(a), r * sin(a), tube * sin(b)));
        }
    for (int i = 0; i < around; i++)
        for (int k = 0; k < across; k++) {
            int j = (i + 1) % around, l = (k + 1) % across;
            soup_quad(&s, i * across + k, j * across + k, j * across + l, i * across + l);
        }
    return s;
}

/* A closed outline in x, z, counter-clockwise seen from -y, drawn out along y; its caps are given as triangles. */
soup soup_trough(void)
{
    static const double OUTLINE[8][2] = {
        {-1, -1}, {1, -1}, {1, 1}, {0.75, 1}, {0.75, -0.75}, {-0.75, -0.75}, {-0.75, 1}, {-1, 1}};
    static const int CAPS[6][3] = {{0, 1, 4}, {0, 4, 5}, {1, 2, 3}, {1, 3, 4}, {0, 5, 6}, {0, 6, 7}};
    soup s = soup_new();
    for (int end = 0; end < 2; end++)
        for (int i = 0; i < 8; i++) soup_point(&s, vec(OUTLINE[i][0], end ? 1 : -1, OUTLINE[i][1]));
    for (int i = 0; i < 8; i++) {
        int j = (i + 1) % 8;
        soup_quad(&s, i, 8 + i, 8 + j, j);
        if (i >= 6) continue;
        soup_triangle(&s, CAPS[i][0], CAPS[i][1], CAPS[i][2]);
        soup_triangle(&s, 8 + CAPS[i][0], 8 + CAPS[i][2], 8 + CAPS[i][1]);
    }
    return s;
}

soup soup_plane(double half, int cuts)
{
    soup s = soup_new();
    for (int i = 0; i <= cuts; i++)
        for (int k = 0; k <= cuts; k++)
            soup_point(&s, vec(half * (2.0 * i / cuts - 1), half * (2.0 * k / cuts - 1), 0));
    for (int i = 0; i < cuts; i++)
        for (int k = 0; k < cuts; k++) {
            int at = i * (cuts + 1) + k;
            soup_quad(&s, at, at + cuts + 1, at + cuts + 2, at + 1);
        }
    return s;
}

soup soup_from(const double *points, size_t count, const int32_t *corners, size_t triangle_count)
{
    soup s = soup_new();
    if (count > SOUP_MAX || triangle_count > SOUP_MAX) abort();
    if (count) memcpy(s.points, points, 3 * count * sizeof *points);
    if (triangle_count) memcpy(s.corners, corners, 3 * triangle_count * sizeof *corners);
    s.point_count = count;
    s.triangle_count = triangle_count;
    return s;
}

void soup_turn(soup *s, size_t t)
{
    int32_t second = s->corners[3 * t + 1];
    s->corners[3 * t + 1] = s->corners[3 * t + 2];
    s->corners[3 * t + 2] = second;
}

void soup_drop(soup *s, size_t t)
{
    s->triangle_count--;
    memmove(s->corners + 3 * t, s->corners + 3 * (t + 1), 3 * (s->triangle_count - t) * sizeof *s->corners);
}

void soup_add(soup *s, const soup *other, vec3 at)
{
    int32_t first = (int32_t)s->point_count;
    for (size_t i = 0; i < other->point_count; i++) soup_point(s, vec_add(point_of(other, (int32_t)i), at));
    for (size_t t = 0; t < other->triangle_count; t++)
        soup_triangle(
            s, first + other->corners[3 * t], first + other->corners[3 * t + 1], first + other->corners[3 * t + 2]);
}

mesh *soup_mesh(const soup *s)
{
    mesh *m = NULL;
    if (mesh_build(s->points, s->point_count, s->corners, s->triangle_count, &m) != MESH_OK) abort();
    return m;
}

shape mesh_shape(const mesh *m, double radius)
{
    return (shape){.type = SHAPE_MESH, .radius = radius, .hull = m->hull, .mesh = m};
}

static uint64_t dice_bits(dice *d)
{
    d->state += 0x9e3779b97f4a7c15;
    uint64_t z = d->state;
    z = (z ^ z >> 30) * 0xbf58476d1ce4e5b9;
    z = (z ^ z >> 27) * 0x94d049bb133111eb;
    return z ^ z >> 31;
}

double dice_between(dice *d, double lo, double hi)
{
    return lo + (hi - lo) * (double)(dice_bits(d) >> 11) * 0x1p-53;
}

vec3 dice_vec(dice *d, double lo, double hi)
{
    double x = dice_between(d, lo, hi), y = dice_between(d, lo, hi), z = dice_between(d, lo, hi);
    return vec(x, y, z);
}

quat dice_quat(dice *d)
{
    for (;;) {
        vec3 v = dice_vec(d, -1, 1);
        quat q = {dice_between(d, -1, 1), v.x, v.y, v.z};
        if (quat_norm2(q) > 0.01 && quat_norm2(q) < 1) return quat_unit(q);
    }
}
