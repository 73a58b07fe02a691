/* Triangles that lie in one plane become one face, in n log n: qhull's own merging takes a time that is the square of
 * the corners of a face. From the largest triangle that is not yet in a face, its plane is followed over common sides:
 * so no face drifts, and slivers, whose planes mean nothing, come into the faces beside them. Any thread; the same
 * triangles give the same faces. */
#include "hull_merge.h"

#include "base/array.h"

#include <stdlib.h>
#include <string.h>

static const uint32_t NONE = UINT32_MAX;

typedef struct side { /* from corner `at` of the triangles to the next one of its triangle */
    uint32_t low, high, at;
} side;

typedef struct ranked {
    double area2;
    uint32_t triangle;
} ranked;

typedef struct merger {
    const vec3 *points;
    const hull_loops *t;
    double tolerance;
    uint32_t *across; /* of each side: the triangle beyond it */
    uint32_t *face;   /* of each triangle */
    uint32_t *queue;
    uint32_t *leads; /* of each point: the corner where the side of this face's outline begins that leaves it */
    uint32_t *uses;  /* of each point: outlines that it is in */
} merger;

static uint32_t next_corner(uint32_t at)
{
    return at % 3 == 2 ? at - 2 : at + 1;
}

static int compare_triangle_sides(const void *left, const void *right)
{
    const side *a = left, *b = right;
    if (a->low != b->low) return a->low < b->low ? -1 : 1;
    if (a->high != b->high) return a->high < b->high ? -1 : 1;
    return (a->at > b->at) - (a->at < b->at);
}

/* False: it is not closed. */
static bool find_across(merger *m)
{
    uint32_t count = m->t->corner_count;
    side *sides = base_alloc(count, sizeof *sides);
    bool closed = count % 2 == 0;
    for (uint32_t i = 0; i < count; i++) {
        uint32_t a = m->t->corners[i], b = m->t->corners[next_corner(i)];
        sides[i] = (side){a < b ? a : b, a < b ? b : a, i};
    }
    qsort(sides, count, sizeof *sides, compare_triangle_sides);
    for (uint32_t i = 0; closed && i < count; i += 2) {
        closed = sides[i].low == sides[i + 1].low && sides[i].high == sides[i + 1].high;
        m->across[sides[i].at] = sides[i + 1].at / 3;
        m->across[sides[i + 1].at] = sides[i].at / 3;
    }
    free(sides);
    return closed;
}

static vec3 corner_of(const merger *m, uint32_t triangle, uint32_t k)
{
    return m->points[m->t->corners[3 * triangle + k]];
}

static vec3 area_of_triangle(const merger *m, uint32_t triangle)
{
    return triangle_area(corner_of(m, triangle, 0), corner_of(m, triangle, 1), corner_of(m, triangle, 2));
}

/* The largest first. */
static int compare_ranks(const void *left, const void *right)
{
    const ranked *a = left, *b = right;
    if (a->area2 != b->area2) return a->area2 > b->area2 ? -1 : 1;
    return (a->triangle > b->triangle) - (a->triangle < b->triangle);
}

static bool is_in_plane(const merger *m, uint32_t triangle, vec3 origin, vec3 normal)
{
    for (uint32_t k = 0; k < 3; k++)
        if (!(fabs(vec_dot(normal, vec_sub(corner_of(m, triangle, k), origin))) <= m->tolerance)) return false;
    return true;
}

static void grow_face(merger *m, uint32_t seed, uint32_t face)
{
    vec3 origin = corner_of(m, seed, 0), normal = vec_unit(area_of_triangle(m, seed));
    uint32_t open = 0;
    m->queue[open++] = seed;
    m->face[seed] = face;
    while (open) {
        uint32_t triangle = m->queue[--open];
        for (uint32_t k = 0; k < 3; k++) {
            uint32_t beyond = m->across[3 * triangle + k];
            if (m->face[beyond] != NONE || !is_in_plane(m, beyond, origin, normal)) continue;
            m->face[beyond] = face;
            m->queue[open++] = beyond;
        }
    }
}

static uint32_t find_faces(merger *m)
{
    uint32_t count = m->t->face_count, faces = 0;
    ranked *ranks = base_alloc(count, sizeof *ranks);
    for (uint32_t i = 0; i < count; i++) ranks[i] = (ranked){vec_norm2(area_of_triangle(m, i)), i};
    qsort(ranks, count, sizeof *ranks, compare_ranks);
    memset(m->face, 0xff, count * sizeof *m->face);
    for (uint32_t i = 0; i < count; i++)
        if (m->face[ranks[i].triangle] == NONE) grow_face(m, ranks[i].triangle, faces++);
    free(ranks);
    return faces;
}

static bool is_outline(const merger *m, uint32_t at)
{
    return m->face[m->across[at]] != m->face[at / 3];
}

typedef struct by_face {
    uint32_t face, at;
} by_face;

static int compare_by_face(const void *left, const void *right)
{
    const by_face *a = left, *b = right;
    if (a->face != b->face) return a->face < b->face ? -1 : 1;
    return (a->at > b->at) - (a->at < b->at);
}

/* The outline of one face, of `count` sides; appended without the corners where only two faces meet. */
static bool add_outline(merger *m, const by_face *sides, uint32_t count, hull_loops *out)
{
    uint32_t begin = out->corner_count, walked = 0, at = sides[0].at;
    for (uint32_t i = 0; i < count; i++) m->leads[m->t->corners[sides[i].at]] = sides[i].at;
    do {
        uint32_t point = m->t->corners[at];
        if (m->leads[point] != at || ++walked > count) return false; /* it meets itself in a corner */
        if (m->uses[point] > 2) out->corners[out->corner_count++] = point;
        at = m->leads[m->t->corners[next_corner(at)]];
    } while (at != sides[0].at);
    out->first[++out->face_count] = out->corner_count;
    return walked == count && out->corner_count - begin >= 3;
}

static bool add_outlines(merger *m, uint32_t faces, hull_loops *out)
{
    uint32_t count = 0;
    by_face *sides = base_alloc(m->t->corner_count + 1, sizeof *sides);
    for (uint32_t i = 0; i < m->t->corner_count; i++) {
        if (!is_outline(m, i)) continue;
        sides[count++] = (by_face){m->face[i / 3], i};
        m->uses[m->t->corners[i]]++;
    }
    qsort(sides, count, sizeof *sides, compare_by_face);
    out->first = base_zalloc(faces + 1, sizeof *out->first);
    out->corners = base_alloc(count + 1, sizeof *out->corners);
    bool good = count > 0;
    for (uint32_t i = 0, end; good && i < count; i = end) {
        for (end = i; end < count && sides[end].face == sides[i].face;) end++;
        good = add_outline(m, sides + i, end - i, out);
    }
    free(sides);
    return good && out->face_count == faces;
}

bool hull_merge(const vec3 *points, uint32_t count, const hull_loops *triangles, double tolerance, hull_loops *out)
{
    memset(out, 0, sizeof *out);
    uint32_t corners = triangles->corner_count, faces = triangles->face_count;
    if (corners != 3 * faces) return false;
    merger m = {.points = points, .t = triangles, .tolerance = tolerance};
    m.across = base_alloc(corners + 1, sizeof *m.across);
    m.face = base_alloc(faces + 1, sizeof *m.face);
    m.queue = base_alloc(faces + 1, sizeof *m.queue);
    m.leads = base_alloc(count, sizeof *m.leads);
    m.uses = base_zalloc(count, sizeof *m.uses);
    memset(m.leads, 0xff, count * sizeof *m.leads);
    bool good = find_across(&m) && add_outlines(&m, find_faces(&m), out);
    free(m.across);
    free(m.face);
    free(m.queue);
    free(m.leads);
    free(m.uses);
    if (!good) hull_loops_free(out);
    return good;
}
