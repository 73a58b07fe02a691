/* Building hulls: clean the points, find their rank, let qhull name the facets, and assemble the polytope from the
 * input's own coordinates. Any thread. The same set of points gives the same polytope whatever their order: qhull sees
 * them sorted, and vertices, faces and edges are put into a canonical order afterwards. */
#include "hull.h"

#include "base/array.h"
#include "hull_excess.h"
#include "hull_loops.h"
#include "hull_map.h"
#include "hull_merge.h"
#include "hull_support.h"
#include "hull_thin.h"
#include "round.h"
#include "shape.h"

#include <stdlib.h>
#include <string.h>

/* Thinner than this part of its length, a cloud of points has no inside: far above the rounding of the coordinates'
 * differences (about 1e-16), far below what anybody means by a plate. */
static const double FLAT_RATIO = 0x1p-40;

/* Distinct points. qhull merges facets in a time that is the square of their corners: of 2,000 points in two rings 0.1
 * s, of 40,000 it would take 80 s. More are joggled and merged afterwards, in n log n. */
enum { MERGED_BY_QHULL_MAX = 2000 };

enum { PADDING = 8 }; /* vertices; support.c scans that many at once */

/* The distinct points. `at` is relative to the first one, scaled by a power of two to about unit size, so that nothing
 * below depends on where and how large the input is. */
typedef struct cloud {
    uint32_t count;
    uint32_t *source; /* indices of the input */
    vec3 *at;
    vec3 axis[3];     /* orthonormal: towards the farthest point, then the farthest from that line, then the normal */
    double extent[3]; /* the farthest distances along them */
    double size;      /* of the input: its greatest coordinate seen from its first point */
    int dimension;
} cloud;

const char *hull_status_text(hull_status status)
{
    switch (status) {
    case HULL_OK:
        return "ok";
    case HULL_EMPTY:
        return "hull has no points";
    case HULL_TOO_MANY:
        return "hull has too many points";
    case HULL_NOT_FINITE:
        return "hull has a coordinate that is not finite or beyond the limit";
    case HULL_FLAT:
        return "hull is flat: all points lie in a plane";
    case HULL_FAILED:
        return "hull could not be built";
    }
    return "unknown";
}

static hull_status check_points(const double *points, size_t count)
{
    if (count == 0) return HULL_EMPTY;
    if (count > HULL_VERTICES_MAX) return HULL_TOO_MANY;
    for (size_t i = 0; i < 3 * count; i++)
        if (!(fabs(points[i]) <= SHAPE_SIZE_MAX)) return HULL_NOT_FINITE;
    return HULL_OK;
}

static vec3 hull_input_point(const double *points, uint32_t i)
{
    return vec(points[3 * i], points[3 * i + 1], points[3 * i + 2]);
}

static int compare_numbers(double a, double b)
{
    return (a > b) - (a < b);
}

/* By coordinates, then by index: of equal points the first one given stays. */
static int compare_input_points(const void *left, const void *right, void *points)
{
    uint32_t i = *(const uint32_t *)left, j = *(const uint32_t *)right;
    vec3 a = hull_input_point(points, i), b = hull_input_point(points, j);
    int order = compare_numbers(a.x, b.x);
    if (order == 0) order = compare_numbers(a.y, b.y);
    if (order == 0) order = compare_numbers(a.z, b.z);
    return order ? order : (i > j) - (i < j);
}

static void keep_distinct(cloud *c, const double *points, uint32_t count)
{
    c->source = base_alloc(count, sizeof *c->source);
    for (uint32_t i = 0; i < count; i++) c->source[i] = i;
    qsort_r(c->source, count, sizeof *c->source, compare_input_points, (void *)points);
    for (uint32_t i = 0; i < count; i++) {
        vec3 p = hull_input_point(points, c->source[i]);
        bool seen = c->count && vec_equal(p, hull_input_point(points, c->source[c->count - 1]));
        if (!seen) c->source[c->count++] = c->source[i];
    }
}

static void normalise(cloud *c, const double *points)
{
    vec3 origin = hull_input_point(points, c->source[0]);
    double most = 0;
    c->at = base_alloc(c->count, sizeof *c->at);
    for (uint32_t i = 0; i < c->count; i++) {
        c->at[i] = vec_sub(hull_input_point(points, c->source[i]), origin);
        most = fmax(most, vec_max_abs(c->at[i]));
    }
    int exponent;
    frexp(most, &exponent);
    c->size = most;
    for (uint32_t i = 0; i < c->count; i++)
        c->at[i] = vec(ldexp(c->at[i].x, -exponent), ldexp(c->at[i].y, -exponent), ldexp(c->at[i].z, -exponent));
}

/* What is left of p when its parts along the first `known` axes are taken away; twice, for the rounding of the first.
 */
static vec3 remainder_of(const cloud *c, vec3 p, int known)
{
    for (int pass = 0; pass < 2; pass++)
        for (int k = 0; k < known; k++) p = vec_madd(p, -vec_dot(p, c->axis[k]), c->axis[k]);
    return p;
}

/* The greedy frame: each axis points to what is farthest from the span of those before. */
static void find_rank(cloud *c)
{
    for (int k = 0; k < 3; k++) {
        vec3 farthest = VEC_ZERO;
        for (uint32_t i = 0; i < c->count; i++) {
            vec3 rest = remainder_of(c, c->at[i], k);
            if (vec_norm2(rest) > vec_norm2(farthest)) farthest = rest;
        }
        c->extent[k] = vec_norm(farthest);
        if (!(c->extent[k] > FLAT_RATIO * c->extent[0])) return;
        c->axis[k] = k == 2 ? vec_cross(c->axis[0], c->axis[1]) : vec_unit(farthest);
        c->dimension = k + 1;
    }
}

static cloud *cloud_create(const double *points, uint32_t count)
{
    cloud *c = base_zalloc(1, sizeof *c);
    keep_distinct(c, points, count);
    normalise(c, points);
    find_rank(c);
    return c;
}

static void cloud_destroy(cloud *c)
{
    free(c->source);
    free(c->at);
    free(c);
}

/* An affine map keeps a hull's facets: needles and plates become as wide as long. */
static vec3 *whitened(const cloud *c)
{
    vec3 *out = base_alloc(c->count, sizeof *out);
    for (uint32_t i = 0; i < c->count; i++)
        out[i] = vec(vec_dot(c->axis[0], c->at[i]) / c->extent[0], vec_dot(c->axis[1], c->at[i]) / c->extent[1],
            vec_dot(c->axis[2], c->at[i]) / c->extent[2]);
    return out;
}

/* Numbers the corners of the loops, in the order of the input; returns how many there are. `place` maps a cloud index
 * to its vertex number. */
static uint32_t place_vertices(const cloud *c, const hull_loops *loops, uint32_t *place, uint32_t input_count)
{
    uint32_t *by_source = base_alloc(input_count, sizeof *by_source), count = 0;
    memset(by_source, 0xff, input_count * sizeof *by_source);
    for (uint32_t i = 0; i < loops->corner_count; i++) by_source[c->source[loops->corners[i]]] = loops->corners[i];
    for (uint32_t i = 0; i < input_count; i++)
        if (by_source[i] != UINT32_MAX) place[by_source[i]] = count++;
    free(by_source);
    return count;
}

/* What a query reads of a small hull stands together, in the lines that follow the structure: hull_fetch. */
enum { HEAD = (sizeof(hull) + 63) / 64 * 64 };

static hull *create_with_vertices(uint32_t count)
{
    size_t padded_count = ((size_t)count + PADDING - 1) / PADDING * PADDING;
    size_t bytes = HEAD + 3 * padded_count * sizeof(double) + hull_map_room(count);
    hull *h = base_alloc_lines(1, bytes);
    memset(h, 0, bytes);
    h->vertex_count = count;
    h->padded_count = (uint32_t)padded_count;
    h->x = (double *)((char *)h + HEAD);
    h->y = h->x + padded_count;
    h->z = h->y + padded_count;
    return h;
}

static void set_vertex(hull *h, uint32_t i, vec3 p)
{
    h->x[i] = p.x;
    h->y[i] = p.y;
    h->z[i] = p.z;
}

static void finish_vertices(hull *h)
{
    for (uint32_t i = h->vertex_count; i < h->padded_count; i++) set_vertex(h, i, hull_vertex(h, h->vertex_count - 1));
    for (uint32_t i = 0; i < h->vertex_count; i++) {
        h->max_abs = fmax(h->max_abs, vec_max_abs(hull_vertex(h, i)));
        h->reach = fmax(h->reach, length_up(hull_vertex(h, i)));
    }
    hull_tree_build(h);
}

/* A loop that starts at its least vertex, so that equal loops are equal arrays. */
static void write_loop(uint32_t *to, const uint32_t *corners, uint32_t count, const uint32_t *place)
{
    uint32_t start = 0;
    for (uint32_t i = 1; i < count; i++)
        if (place[corners[i]] < place[corners[start]]) start = i;
    for (uint32_t i = 0; i < count; i++) to[i] = place[corners[(start + i) % count]];
}

static int compare_face_corners(const void *left, const void *right, void *vertices)
{
    const hull_face *a = left, *b = right;
    const uint32_t *la = (const uint32_t *)vertices + a->first, *lb = (const uint32_t *)vertices + b->first;
    for (uint32_t i = 0; i < a->count && i < b->count; i++)
        if (la[i] != lb[i]) return la[i] < lb[i] ? -1 : 1;
    return (a->count > b->count) - (a->count < b->count);
}

/* Outward, from the sum over the fan of corner 0. The corners are scaled by a power of two: no overflow, and the same
 * bits at any scale. */
static vec3 face_normal(const hull *h, const hull_face *f)
{
    const uint32_t *loop = &h->face_vertices[f->first];
    vec3 sum = VEC_ZERO;
    int exponent;
    frexp(h->max_abs, &exponent);
    for (uint32_t i = 1; i + 1 < f->count; i++) {
        vec3 corner[3] = {hull_vertex(h, loop[0]), hull_vertex(h, loop[i]), hull_vertex(h, loop[i + 1])};
        for (int k = 0; k < 3; k++)
            corner[k] =
                vec(ldexp(corner[k].x, -exponent), ldexp(corner[k].y, -exponent), ldexp(corner[k].z, -exponent));
        sum = vec_add(sum, triangle_area(corner[0], corner[1], corner[2]));
    }
    return vec_unit(sum);
}

static void finish_face(hull *h, hull_face *f)
{
    f->normal = face_normal(h, f);
    f->offset = vec_dot(f->normal, hull_vertex(h, hull_support(h, f->normal, h->face_vertices[f->first])));
}

static void add_faces(hull *h, const hull_loops *loops, const uint32_t *place)
{
    h->face_count = loops->face_count;
    h->faces = base_zalloc(h->face_count, sizeof *h->faces);
    uint32_t *unsorted = base_alloc(loops->corner_count, sizeof *unsorted);
    for (uint32_t f = 0; f < h->face_count; f++) {
        uint32_t first = loops->first[f], count = loops->first[f + 1] - first;
        h->faces[f].first = first;
        h->faces[f].count = count;
        write_loop(unsorted + first, loops->corners + first, count, place);
    }
    qsort_r(h->faces, h->face_count, sizeof *h->faces, compare_face_corners, unsorted);
    h->face_vertices = base_alloc(loops->corner_count, sizeof *h->face_vertices);
    uint32_t next = 0;
    for (uint32_t f = 0; f < h->face_count; f++) {
        hull_face *face = &h->faces[f];
        memcpy(h->face_vertices + next, unsorted + face->first, face->count * sizeof *unsorted);
        face->first = next;
        next += face->count;
        finish_face(h, face);
    }
    free(unsorted);
}

static int compare_edges(const void *left, const void *right)
{
    const hull_edge *a = left, *b = right;
    if (a->v0 != b->v0) return a->v0 < b->v0 ? -1 : 1;
    return (a->v1 > b->v1) - (a->v1 < b->v1);
}

/* Each side of a loop is half an edge: written with the face on the side that it is on (f0: walks v0 to v1), and none
 * on the other. Sorted, the two halves of an edge are neighbours. */
static hull_edge *half_edges(const hull *h, uint32_t total)
{
    hull_edge *halves = base_alloc(total, sizeof *halves);
    for (uint32_t f = 0; f < h->face_count; f++) {
        const uint32_t *loop = &h->face_vertices[h->faces[f].first], count = h->faces[f].count;
        for (uint32_t i = 0; i < count; i++) {
            uint32_t a = loop[i], b = loop[(i + 1) % count];
            halves[h->faces[f].first + i] = a < b ? (hull_edge){a, b, f, UINT32_MAX} : (hull_edge){b, a, UINT32_MAX, f};
        }
    }
    qsort(halves, total, sizeof *halves, compare_edges);
    return halves;
}

/* False if some edge is not shared by exactly two faces that walk it in opposite directions. */
static bool add_edges(hull *h, uint32_t corner_count)
{
    hull_edge *halves = half_edges(h, corner_count);
    bool good = corner_count % 2 == 0;
    h->edge_count = corner_count / 2;
    h->edges = base_alloc(h->edge_count + 1, sizeof *h->edges);
    for (uint32_t e = 0; good && e < h->edge_count; e++) {
        const hull_edge *a = &halves[2 * e], *b = a + 1;
        if (a->f0 == UINT32_MAX) b = a, a = b + 1;
        good = a->v0 == b->v0 && a->v1 == b->v1 && a->f0 != UINT32_MAX && b->f0 == UINT32_MAX;
        h->edges[e] = (hull_edge){a->v0, a->v1, a->f0, b->f1};
    }
    free(halves);
    return good;
}

static int compare_indices(const void *left, const void *right)
{
    uint32_t a = *(const uint32_t *)left, b = *(const uint32_t *)right;
    return (a > b) - (a < b);
}

static void add_neighbours(hull *h)
{
    h->neighbour_first = base_zalloc(h->vertex_count + 1, sizeof *h->neighbour_first);
    h->neighbours = base_alloc(2 * h->edge_count + 1, sizeof *h->neighbours);
    uint32_t *first = h->neighbour_first, *end = base_alloc(h->vertex_count, sizeof *end);
    for (uint32_t e = 0; e < h->edge_count; e++) {
        first[h->edges[e].v0 + 1]++;
        first[h->edges[e].v1 + 1]++;
    }
    for (uint32_t v = 0; v < h->vertex_count; v++) {
        end[v] = first[v];
        first[v + 1] += first[v];
    }
    for (uint32_t e = 0; e < h->edge_count; e++) {
        h->neighbours[end[h->edges[e].v0]++] = h->edges[e].v1;
        h->neighbours[end[h->edges[e].v1]++] = h->edges[e].v0;
    }
    for (uint32_t v = 0; v < h->vertex_count; v++)
        qsort(h->neighbours + first[v], first[v + 1] - first[v], sizeof *h->neighbours, compare_indices);
    free(end);
}

static bool face_is_flat(const hull *h, const hull_face *f, double slack)
{
    for (uint32_t i = 0; i < f->count; i++)
        if (!(vec_dot(f->normal, hull_vertex(h, h->face_vertices[f->first + i])) >= f->offset - slack)) return false;
    return vec_norm2(f->normal) > 0;
}

/* What qhull may have got wrong if facets are too narrow to distinguish. */

static bool is_sound(const hull *h, double extent)
{
    double slack = HULL_PLANE_RATIO * extent + 16 * ROUND_U * h->max_abs + HULL_SUBNORMAL;
    if (h->vertex_count + h->face_count != h->edge_count + 2) return false;
    for (uint32_t v = 0; v < h->vertex_count; v++)
        if (h->neighbour_first[v + 1] - h->neighbour_first[v] < 3) return false;
    for (uint32_t f = 0; f < h->face_count; f++)
        if (!face_is_flat(h, &h->faces[f], slack)) return false;
    return true;
}

static hull *build_solid(const double *points, uint32_t count, const cloud *c, const hull_loops *loops)
{
    uint32_t *place = base_zalloc(c->count, sizeof *place);
    hull *h = create_with_vertices(place_vertices(c, loops, place, count));
    h->dimension = 3;
    for (uint32_t i = 0; i < loops->corner_count; i++) {
        uint32_t corner = loops->corners[i];
        set_vertex(h, place[corner], hull_input_point(points, c->source[corner]));
    }
    finish_vertices(h);
    add_faces(h, loops, place);
    free(place);
    if (add_edges(h, loops->corner_count)) {
        add_neighbours(h);
        if (is_sound(h, c->size)) return h;
    }
    hull_destroy(h);
    return NULL;
}

static void find_excess(hull *h, const double *points, const cloud *c, const hull_loops *loops)
{
    if (c->count == h->vertex_count) return;
    uint8_t *kept = base_zalloc(c->count, 1);
    for (uint32_t i = 0; i < loops->corner_count; i++) kept[loops->corners[i]] = 1;
    vec3 *left = base_alloc(c->count, sizeof *left);
    uint32_t count = 0;
    for (uint32_t i = 0; i < c->count; i++)
        if (!kept[i]) left[count++] = hull_input_point(points, c->source[i]);
    h->excess = hull_excess_of(h, left, count);
    h->reach = add_up(h->reach, h->excess);
    free(left);
    free(kept);
}

/* The lesser excess stays. */
static hull *better_of(hull *a, hull *b)
{
    if (!a || !b) return a ? a : b;
    bool first = a->excess <= b->excess;
    hull_destroy(first ? b : a);
    return first ? a : b;
}

static hull *try_triangles(const double *points, uint32_t count, const cloud *c, const hull_loops *triangles)
{
    static const double TOLERANCES[] = {1e-13, 1e-11};
    hull *best = NULL;
    for (size_t i = 0; i < sizeof TOLERANCES / sizeof *TOLERANCES; i++) {
        hull_loops loops;
        if (!hull_merge(c->at, c->count, triangles, TOLERANCES[i], &loops)) continue;
        hull *h = build_solid(points, count, c, &loops);
        if (h) find_excess(h, points, c, &loops);
        hull_loops_free(&loops);
        best = better_of(best, h);
        if (best && best->excess <= HULL_PLANE_RATIO * c->size) break;
    }
    return best;
}

/* Of each `share` points about one, chosen by their numbers so that no pattern of the input is met, and those that are
 * farthest along the axes. Returns how many. */
static uint32_t choose_points(const vec3 *at, uint32_t count, uint32_t share, uint32_t *chosen)
{
    uint32_t ends[6] = {0}, n = 0;
    for (uint32_t i = 0; i < count; i++)
        for (int k = 0; k < 6; k++) {
            const double here[3] = {at[i].x, at[i].y, at[i].z}, end[3] = {at[ends[k]].x, at[ends[k]].y, at[ends[k]].z};
            if (k < 3 ? here[k] > end[k] : here[k - 3] < end[k - 3]) ends[k] = i;
        }
    for (uint32_t i = 0; i < count; i++) {
        bool keep = i * UINT32_C(2654435761) / (UINT32_MAX / share + 1) == 0;
        for (int k = 0; k < 6; k++) keep |= ends[k] == i;
        if (keep) chosen[n++] = i;
    }
    return n;
}

/* The triangles around the chosen points, joggled: one of each `share`, or such that all are `apart` if that is not 0.
 */
static bool find_triangles(
    const vec3 *white, uint32_t count, uint32_t share, double apart, const char *joggle, hull_loops *triangles)
{
    if (share == 1 && apart == 0) return hull_loops_find(white, count, joggle, triangles);
    uint32_t n, *chosen = base_alloc(count, sizeof *chosen);
    n = apart > 0 ? hull_thin(white, count, apart, chosen) : choose_points(white, count, share, chosen);
    vec3 *at = base_alloc(n, sizeof *at);
    for (uint32_t i = 0; i < n; i++) at[i] = white[chosen[i]];
    bool found = hull_loops_find(at, n, joggle, triangles);
    for (uint32_t i = 0; found && i < triangles->corner_count; i++)
        triangles->corners[i] = chosen[triangles->corners[i]];
    free(at);
    free(chosen);
    return found;
}

/* A hull that leaves points farther outside than this share of its size is none. */
static const double WIDEST_EXCESS = 1e-6;

/* As try_solid, of many points. They are joggled, so that qhull has nothing to merge, by 1e-13 to 1e-11 of their
 * extents (or as much more as it takes); what is in one plane becomes one face by the coordinates that were given,
 * noise in which makes planes thicker. What joggling has hidden is outside by as much: how much, hull.excess says.
 * Points on curves that are bent by less than that are corners again where there are fewer of them; those that crowd
 * together in places, where none are left that are close to each other. */
static hull *try_many(const double *points, uint32_t count, const cloud *c)
{
    static const struct {
        const char *joggle;
        uint32_t share;
        double apart;
    } ATTEMPTS[] = {{"QJ1e-12", 1, 0}, {"QJ", 1, 0}, {"QJ1e-13", 1, 0}, {"QJ1e-12", 2, 0}, {"QJ1e-12", 4, 0},
        {"QJ1e-12", 8, 0}, {"QJ1e-14", 1, 0x1p-12}, {"QJ1e-14", 1, 0x1p-11}};
    enum { FULL_ATTEMPTS = 3, ATTEMPT_COUNT = sizeof ATTEMPTS / sizeof *ATTEMPTS };
    vec3 *white = whitened(c);
    hull *best = NULL;
    for (size_t i = 0; i < ATTEMPT_COUNT; i++) {
        hull_loops triangles;
        if (!find_triangles(white, c->count, ATTEMPTS[i].share, ATTEMPTS[i].apart, ATTEMPTS[i].joggle, &triangles))
            continue;
        best = better_of(best, try_triangles(points, count, c, &triangles));
        hull_loops_free(&triangles);
        double enough = i + 1 < FULL_ATTEMPTS ? HULL_PLANE_RATIO : WIDEST_EXCESS;
        if (best && best->excess <= enough * c->size) break;
    }
    free(white);
    if (!best || best->excess <= WIDEST_EXCESS * c->size) return best;
    hull_destroy(best);
    return NULL;
}

/* The first attempt that gives a sound polytope is taken. Plainly, qhull merges what rounding cannot tell apart.
 * Needles and plates want whitening. Points that are coplanar only to some noise leave facets without a usable normal:
 * then merging (C-n: facets convex to less than n) goes a little wider, to at most HULL_PLANE_RATIO. At last the points
 * are joggled by about their rounding (QJ), which only ever decides between nearly coplanar facets. */
static hull *try_solid(const double *points, uint32_t count, const cloud *c)
{
    static const struct {
        bool whiten;
        const char *options;
    } attempts[] = {{false, ""}, {true, ""}, {false, "C-1e-13"}, {false, "C-1e-12"}, {false, "C-1e-11"},
        {false, "C-1e-10"}, {true, "C-1e-13"}, {true, "C-1e-12"}, {true, "C-1e-11"}, {true, "C-1e-10"}, {true, "QJ"}};
    vec3 *white = whitened(c);
    hull *h = NULL;
    for (size_t i = 0; !h && i < sizeof attempts / sizeof *attempts; i++) {
        hull_loops loops;
        if (!hull_loops_find(attempts[i].whiten ? white : c->at, c->count, attempts[i].options, &loops)) continue;
        h = build_solid(points, count, c, &loops);
        if (h) find_excess(h, points, c, &loops);
        hull_loops_free(&loops);
    }
    free(white);
    return h;
}

/* Every distinct point stays a vertex: in a plane that holds only to rounding, the outline is no safe judge. */
static hull *build_flat(const double *points, uint32_t count, const cloud *c)
{
    uint8_t *keep = base_zalloc(count, 1);
    for (uint32_t i = 0; i < c->count; i++) keep[c->source[i]] = 1;
    hull *h = create_with_vertices(c->count);
    h->dimension = c->dimension;
    uint32_t next = 0;
    for (uint32_t i = 0; i < count; i++)
        if (keep[i]) set_vertex(h, next++, hull_input_point(points, i));
    free(keep);
    finish_vertices(h);
    add_neighbours(h);
    return h;
}

hull_status hull_build(const double *points, size_t count, unsigned flags, hull **out)
{
    *out = NULL;
    hull_status status = check_points(points, count);
    if (status != HULL_OK) return status;
    cloud *c = cloud_create(points, (uint32_t)count);
    if (c->dimension == 3)
        *out = (c->count > MERGED_BY_QHULL_MAX ? try_many : try_solid)(points, (uint32_t)count, c);
    else if (flags & HULL_ALLOW_FLAT)
        *out = build_flat(points, (uint32_t)count, c);
    bool flat = c->dimension < 3;
    if (*out && !flat) (*out)->map = hull_map_build(*out, (*out)->z + (*out)->padded_count);
    cloud_destroy(c);
    if (*out) return HULL_OK;
    return flat ? HULL_FLAT : HULL_FAILED;
}

void hull_destroy(hull *h)
{
    if (!h) return;
    free(h->faces);
    free(h->face_vertices);
    free(h->edges);
    free(h->neighbour_first);
    free(h->neighbours);
    free(h->nodes);
    free(h->node_vertices);
    free(h);
}
