/* The edges of a mesh: how often each is walked in either direction tells whether there is an inside. Any thread.
 *
 * A set of oriented triangles whose edges cancel has a winding number at each point off it (it is a cycle): so edges of
 * four triangles are no obstacle. Where each edge has two triangles but some disagree, they are turned, neighbour by
 * neighbour; a Moebius band cannot be, and stays a surface. */
#include "mesh_steps.h"

#include "base/array.h"

#include <stdlib.h>

typedef struct side { /* of a triangle */
    uint32_t lo, hi;  /* its vertices, the lesser first */
    uint32_t triangle;
    bool forward; /* walked from lo to hi */
} side;

static int compare_edge_sides(const void *left, const void *right)
{
    const side *a = left, *b = right;
    if (a->lo != b->lo) return a->lo < b->lo ? -1 : 1;
    if (a->hi != b->hi) return a->hi < b->hi ? -1 : 1;
    return (a->triangle > b->triangle) - (a->triangle < b->triangle);
}

static side *sorted_sides(const mesh *m)
{
    side *sides = base_alloc(3 * (size_t)m->triangle_count + 1, sizeof *sides);
    for (uint32_t t = 0; t < m->triangle_count; t++) {
        const uint32_t *v = m->triangles[t].v;
        for (uint32_t k = 0; k < 3; k++) {
            uint32_t a = v[k], b = v[(k + 1) % 3];
            sides[3 * t + k] = a < b ? (side){a, b, t, true} : (side){b, a, t, false};
        }
    }
    qsort(sides, 3 * (size_t)m->triangle_count, sizeof *sides, compare_edge_sides);
    return sides;
}

/* The sides from `at` on that lie on one edge. */
static uint32_t edge_sides(const side *sides, uint32_t at, uint32_t total)
{
    uint32_t n = 1;
    while (at + n < total && sides[at + n].lo == sides[at].lo && sides[at + n].hi == sides[at].hi) n++;
    return n;
}

/* Fills the counts of bad edges; true if the sides of every edge cancel. */
static bool count_edges(mesh *m, const side *sides)
{
    uint32_t total = 3 * m->triangle_count;
    bool closed = total > 0;
    m->found.open_edges = m->found.shared_edges = m->found.torn_edges = 0;
    for (uint32_t at = 0, n; at < total; at += n) {
        int balance = 0;
        n = edge_sides(sides, at, total);
        for (uint32_t k = 0; k < n; k++) balance += sides[at + k].forward ? 1 : -1;
        m->found.open_edges += n == 1;
        m->found.shared_edges += n > 2;
        m->found.torn_edges += n == 2 && balance != 0;
        if (balance != 0) closed = false;
    }
    return closed;
}

/* ---- turning ---- */

typedef struct turning {
    uint32_t (*neighbour)[3]; /* of each triangle, in the order of its sides among the sorted */
    bool (*agrees)[3];
    uint8_t *degree;
    int8_t *turn; /* 0: not yet reached; 1: stays; -1: is turned */
    uint32_t *queue;
} turning;

static void join_triangles(turning *w, const side *a, const side *b)
{
    bool agrees = a->forward != b->forward;
    w->agrees[a->triangle][w->degree[a->triangle]] = agrees;
    w->neighbour[a->triangle][w->degree[a->triangle]++] = b->triangle;
    w->agrees[b->triangle][w->degree[b->triangle]] = agrees;
    w->neighbour[b->triangle][w->degree[b->triangle]++] = a->triangle;
}

/* Six times the volume between the triangle and the first vertex of the mesh, in cubes of mesh.unit. */
static double signed_volume(const mesh *m, uint32_t t)
{
    vec3 p[3];
    for (int k = 0; k < 3; k++) p[k] = vec_scale(vec_sub(mesh_corner(m, t, k), m->vertices[0]), 1 / m->unit);
    return vec_dot(p[0], vec_cross(p[1], p[2]));
}

static void turn_over(mesh *m, uint32_t t)
{
    uint32_t *v = m->triangles[t].v, second = v[1];
    v[1] = v[2];
    v[2] = second;
}

/* Makes all that hangs together with `start` agree with it. False if it cannot be. *out: triangles in the queue. */
static bool spread(turning *w, uint32_t start, uint32_t *out)
{
    uint32_t count = 0;
    bool agreed = true;
    w->turn[start] = 1;
    w->queue[count++] = start;
    for (uint32_t i = 0; i < count; i++) {
        uint32_t t = w->queue[i];
        for (int k = 0; k < w->degree[t]; k++) {
            uint32_t other = w->neighbour[t][k];
            int8_t wanted = w->agrees[t][k] ? w->turn[t] : (int8_t)-w->turn[t];
            if (w->turn[other] == 0) {
                w->turn[other] = wanted;
                w->queue[count++] = other;
            } else if (w->turn[other] != wanted) {
                agreed = false;
            }
        }
    }
    *out = count;
    return agreed;
}

/* The part as a whole is turned so that its volume is positive: which of its triangles were right is not known. */
static void turn_part(mesh *m, turning *w, uint32_t count)
{
    double volume = 0;
    bool mixed = false;
    for (uint32_t i = 0; i < count; i++) {
        volume += w->turn[w->queue[i]] * signed_volume(m, w->queue[i]);
        mixed = mixed || w->turn[w->queue[i]] < 0;
    }
    for (uint32_t i = 0; mixed && i < count; i++) {
        bool turns = (w->turn[w->queue[i]] < 0) != (volume < 0);
        if (turns) turn_over(m, w->queue[i]);
        m->found.turned += turns;
    }
}

static void turn_to_agree(mesh *m, const side *sides)
{
    uint32_t total = 3 * m->triangle_count, count;
    turning w = {base_alloc(m->triangle_count, sizeof *w.neighbour), base_alloc(m->triangle_count, sizeof *w.agrees),
        base_zalloc(m->triangle_count, sizeof *w.degree), base_zalloc(m->triangle_count, sizeof *w.turn),
        base_alloc(m->triangle_count, sizeof *w.queue)};
    for (uint32_t at = 0, n; at < total; at += n) {
        n = edge_sides(sides, at, total);
        if (n == 2) join_triangles(&w, &sides[at], &sides[at + 1]);
    }
    for (uint32_t t = 0; t < m->triangle_count; t++)
        if (w.turn[t] == 0 && spread(&w, t, &count)) turn_part(m, &w, count);
    free(w.neighbour);
    free(w.agrees);
    free(w.degree);
    free(w.turn);
    free(w.queue);
}

static void turn_outward(mesh *m)
{
    double volume = 0;
    for (uint32_t t = 0; t < m->triangle_count; t++) volume += signed_volume(m, t);
    m->found.inside_out = volume < 0;
    for (uint32_t t = 0; volume < 0 && t < m->triangle_count; t++) turn_over(m, t);
}

/* The triangles may have been turned since: a side is known by its vertices. */
static void number_edges(mesh *m, const side *sides)
{
    uint32_t total = 3 * m->triangle_count, edge = 0;
    for (uint32_t at = 0, n; at < total; at += n, edge++) {
        n = edge_sides(sides, at, total);
        for (const side *s = &sides[at]; s < &sides[at + n]; s++) {
            mesh_triangle *t = &m->triangles[s->triangle];
            for (int k = 0; k < 3; k++)
                if (t->v[k] + t->v[(k + 1) % 3] == s->lo + s->hi && (t->v[k] == s->lo || t->v[k] == s->hi))
                    t->edge[k] = edge;
        }
    }
}

static void orient(mesh *m)
{
    side *sides = sorted_sides(m);
    m->solid = count_edges(m, sides);
    if (!m->solid && m->found.torn_edges) {
        turn_to_agree(m, sides);
        free(sides);
        sides = sorted_sides(m);
        m->solid = count_edges(m, sides);
    }
    if (m->solid) turn_outward(m);
    number_edges(m, sides);
    free(sides);
}

/* Do the sides of the first `count` triangles cancel? */
static bool closes(mesh *m, uint32_t count)
{
    uint32_t all = m->triangle_count;
    m->triangle_count = count;
    side *sides = sorted_sides(m);
    bool closed = count_edges(m, sides);
    m->triangle_count = all;
    free(sides);
    return closed;
}

static uint32_t count_up_to(const mesh *m, mesh_form form)
{
    uint32_t count = 0;
    while (count < m->triangle_count && m->triangles[count].form <= (uint32_t)form) count++;
    return count;
}

void mesh_orient(mesh *m)
{
    uint32_t all = m->triangle_count, with_area = count_up_to(m, MESH_AREA), unfolded = count_up_to(m, MESH_NEEDLE);
    bool beside = with_area < unfolded && !closes(m, unfolded) && closes(m, with_area);
    m->triangle_count = beside ? with_area : unfolded;
    orient(m);
    for (uint32_t t = with_area; m->solid && t < m->triangle_count; t++) m->triangles[t].form = MESH_SEAM;
    if (m->triangle_count == all) return;
    m->triangle_count = all;
    side *sides = sorted_sides(m);
    number_edges(m, sides);
    free(sides);
}
