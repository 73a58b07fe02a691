/* stars: flatness certificates. The triangles around a vertex, while they stay flat enough, cannot meet but where they
 * adjoin: not a vertex of one with another, nor edges of two. For separation 0 only: it says nothing of distances.
 *
 * Proof. Let V be a fixed direction, and every triangle (v, p, q) of the fan around v have N(t) . V > 0 on the whole
 * way. N(t) = (p - v) x (q - v) is quadratic in t, so positive Bernstein coefficients (at the start, mixed, at the end)
 * suffice. Projected along V, each triangle then turns around v by an angle in (0, pi); the sum of the angles of a
 * closed fan is a multiple of 2 pi, and constant, because it is continuous. If it is 2 pi at the start, which one ray
 * from v counts, the fan is star-shaped around v at all times: its projection is injective, and so it does not meet
 * itself. The fan at a border is closed by two triangles over a point that moves linearly, too; they only add to what
 * must be flat. Several fans at one vertex turn by 2 pi each, and are found out by the count.
 *
 * Rounding, u = 2^-53. For |d| <= 1 in each coordinate, and edges e, f with coordinates of at most E and F, each off by
 * u of itself: (e x f) . d is off by less than 40 u E F; 128 u are asked, and 2^-800 for underflow. The ray: a height
 * (p - v) . Y is off by less than 24 u E, Y not being quite orthogonal to V; one within 128 u E of 0 tells nothing, and
 * refuses. */
#include "state.h"

#include "narrow/math/scalar.h"

#include <stdatomic.h>

enum { FAN_MOST = 24 };

typedef struct fan { /* triangles (v, from, to), relative to v */
    vec3 from_start[FAN_MOST + 2], from_end[FAN_MOST + 2], to_start[FAN_MOST + 2], to_end[FAN_MOST + 2];
    uint32_t from[FAN_MOST + 2], to[FAN_MOST + 2];
    int count;
} fan;

static void fan_add(fan *f, const soft_way *v, const soft_way *from, const soft_way *to)
{
    f->from_start[f->count] = vec_sub(from->start, v->start), f->from_end[f->count] = vec_sub(from->end, v->end);
    f->to_start[f->count] = vec_sub(to->start, v->start), f->to_end[f->count] = vec_sub(to->end, v->end);
    f->count++;
}

/* False: more triangles than are looked at, or one without area by its very names. */
static bool fan_gather(const soft_mesh *m, const soft_way *ways, uint32_t vertex, fan *f)
{
    uint32_t first = m->around_first[vertex], count = m->around_first[vertex + 1] - first;
    f->count = 0;
    if (count > FAN_MOST) return false;
    for (uint32_t i = 0; i < count; i++) {
        const uint32_t *t = m->triangles[m->around[first + i]];
        int k = t[0] == vertex ? 0 : t[1] == vertex ? 1 : 2;
        uint32_t from = t[(k + 1) % 3], to = t[(k + 2) % 3];
        if (from == to || from == vertex || to == vertex) return false;
        f->from[f->count] = from, f->to[f->count] = to;
        fan_add(f, &ways[vertex], &ways[from], &ways[to]);
    }
    return true;
}

/* Each vertex around begins one triangle and ends one; or at a border one only begins and one only ends. False: neither
 * (a pinch, a third triangle at an edge, triangles turned over). Loose ends come out as `begin` and `end`. */
static bool fan_ends(const fan *f, uint32_t *begin, uint32_t *end)
{
    *begin = *end = SOFT_NONE;
    for (int i = 0; i < f->count; i++) {
        int ends_here = 0, begins_there = 0, twice = 0;
        for (int k = 0; k < f->count; k++) {
            ends_here += f->to[k] == f->from[i];
            begins_there += f->from[k] == f->to[i];
            twice += k != i && (f->from[k] == f->from[i] || f->to[k] == f->to[i]);
        }
        if (twice || (!ends_here && *begin != SOFT_NONE) || (!begins_there && *end != SOFT_NONE)) return false;
        if (!ends_here) *begin = f->from[i];
        if (!begins_there) *end = f->to[i];
    }
    return true;
}

/* Opposite of the middle of the fan, as seen from v. Any point that moves linearly serves: these two numbers are one.
 */
static soft_way closing_point(const fan *f, const soft_way *v)
{
    vec3 start = VEC_ZERO, end = VEC_ZERO;
    for (int i = 0; i < f->count; i++) {
        start = vec_add(start, vec_add(f->from_start[i], f->to_start[i]));
        end = vec_add(end, vec_add(f->from_end[i], f->to_end[i]));
    }
    double by = -0.5 / f->count;
    return (soft_way){vec_madd(v->start, by, start), vec_madd(v->end, by, end)};
}

static bool fan_close(const soft_way *ways, uint32_t vertex, fan *f)
{
    uint32_t begin, end;
    if (!fan_ends(f, &begin, &end)) return false;
    if (begin == SOFT_NONE || end == SOFT_NONE) return begin == end;
    soft_way c = closing_point(f, &ways[vertex]);
    fan_add(f, &ways[vertex], &ways[end], &c);
    fan_add(f, &ways[vertex], &c, &ways[begin]);
    return true;
}

static vec3 mean_normal(const fan *f)
{
    vec3 sum = VEC_ZERO;
    for (int i = 0; i < f->count; i++) {
        sum = vec_add(sum, vec_cross(f->from_start[i], f->to_start[i]));
        sum = vec_add(sum, vec_cross(f->from_end[i], f->to_end[i]));
    }
    return direction_of(sum);
}

static bool faces_along(const fan *f, int i, vec3 d)
{
    vec3 from_start = f->from_start[i], from_end = f->from_end[i], to_start = f->to_start[i], to_end = f->to_end[i];
    double from = max_of(vec_greatest(from_start), vec_greatest(from_end));
    double bound = 0x1p-46 * (from * max_of(vec_greatest(to_start), vec_greatest(to_end))) + 0x1p-800;
    if (!(vec_dot(d, vec_cross(from_start, to_start)) > bound)) return false;
    if (!(vec_dot(d, vec_cross(from_end, to_end)) > bound)) return false;
    vec3 mixed = vec_add(vec_cross(from_start, to_end), vec_cross(from_end, to_start));
    return 0.5 * vec_dot(d, mixed) > bound;
}

/* How often the fan turns around v at the start, seen along d: once means once. -1: rounding does not tell. */
static int turns(const fan *f, vec3 d)
{
    double x = fabs(d.x), y = fabs(d.y), z = fabs(d.z);
    vec3 other = x <= y && x <= z ? vec(1, 0, 0) : y <= z ? vec(0, 1, 0) : vec(0, 0, 1);
    vec3 up = direction_of(vec_cross(d, other));
    int count = 0;
    for (int i = 0; i < f->count; i++) {
        vec3 p = f->from_start[i], q = f->to_start[i];
        double from = vec_dot(up, p), to = vec_dot(up, q);
        if (!(fabs(from) > 0x1p-46 * vec_greatest(p) + 0x1p-800)) return -1;
        if (!(fabs(to) > 0x1p-46 * vec_greatest(q) + 0x1p-800)) return -1;
        count += from < 0 && to > 0;
    }
    return count;
}

bool soft_star_is_flat(const soft_mesh *m, const soft_way *ways, uint32_t vertex)
{
    fan f;
    if (!fan_gather(m, ways, vertex, &f) || !fan_close(ways, vertex, &f)) return false;
    vec3 d = mean_normal(&f);
    for (int i = 0; i < f.count; i++)
        if (!faces_along(&f, i, d)) return false;
    return turns(&f, d) == 1;
}

/* ---- candidates ---- */

static bool flat(const soft_mesh *m, const soft_way *ways, uint32_t vertex, _Atomic uint8_t *known)
{
    uint8_t k = atomic_load_explicit(&known[vertex], memory_order_relaxed);
    if (k == 0) { /* two workers may find it out at once: they find the same */
        k = soft_star_is_flat(m, ways, vertex) ? 1 : 2;
        atomic_store_explicit(&known[vertex], k, memory_order_relaxed);
    }
    return k == 1;
}

static bool touches(const soft_mesh *m, uint32_t triangle, uint32_t vertex)
{
    const uint32_t *t = m->triangles[triangle];
    return t[0] == vertex || t[1] == vertex || t[2] == vertex;
}

/* Is the edge part of the star of the vertex: of a triangle at it? */
static bool edge_in_star(const soft_mesh *m, uint32_t edge, uint32_t vertex)
{
    if (m->edges[edge][0] == vertex || m->edges[edge][1] == vertex) return true;
    const uint32_t *beside = m->beside[edge];
    return (beside[0] != SOFT_NONE && touches(m, beside[0], vertex)) ||
           (beside[1] != SOFT_NONE && touches(m, beside[1], vertex));
}

static bool are_neighbours(const soft_mesh *m, uint32_t a, uint32_t b)
{
    for (uint32_t i = m->around_first[a]; i < m->around_first[a + 1]; i++)
        if (touches(m, m->around[i], b)) return true;
    return false;
}

bool soft_in_flat_star(
    const soft_mesh *m, const soft_way *ways, const soft_candidate *c, soft_kind kind, _Atomic uint8_t *known)
{
    if (kind != SOFT_EDGE_EDGE) {
        for (int i = 1; i < 4; i++)
            if (are_neighbours(m, c->vertex[0], c->vertex[i]) && flat(m, ways, c->vertex[i], known)) return true;
        return false;
    }
    for (int i = 0; i < 4; i++) { /* an end of one, and the other opposite of it */
        uint32_t other = i < 2 ? c->b : c->a;
        if (edge_in_star(m, other, c->vertex[i]) && flat(m, ways, c->vertex[i], known)) return true;
    }
    for (int k = 0; k < 2; k++) { /* or opposite of one vertex, both */
        uint32_t triangle = m->beside[c->a][k];
        if (triangle == SOFT_NONE) continue;
        for (int i = 0; i < 3; i++) {
            uint32_t v = m->triangles[triangle][i];
            if (edge_in_star(m, c->b, v) && flat(m, ways, v, known)) return true;
        }
    }
    return false;
}
