/* hull_axes: heights of faces, arcs that are left, pairs of these. Pure; any thread. */
#include "features.h"
#include "geom/hull_map.h"
#include "geom/hull_scan.h"
#include "geom/simd.h"
#include "narrow/math/scalar.h"
#include "polytopes.h"

enum { VERTICES_MAX = HULL_MAP_VERTICES_MAX, FACES_MAX = HULL_MAP_FACES_MAX, SINGLES = HULL_MAP_LANES };

/* Of a height's bits: which vertex it is of. */
enum { INDEX_BITS = VERTICES_MAX - 1, FACE = FACES_MAX - 1 };

/* Of the pair's size, unless said otherwise. */
#define SLACK 0x1p-14                 /* of what is said in single precision */
#define SIDE_SLACK 0x1p-31            /* cosines closer to 0 than this may have the wrong sign */
#define LEAST_CROSS2 0x1p-32          /* of two edges' squares: see try_edges */
static const float MOST_ARC = -1.74F; /* twice the cosine of the longest arc that has a bound */

typedef struct columns {
    double x[VERTICES_MAX], y[VERTICES_MAX], z[VERTICES_MAX];
} columns;

/* One hull's faces under the other's vertices. A height is the word of a float: of positive ones the order is the same,
 * and no negative one is above a positive. */
typedef struct side {
    const hull *h;
    int vertex_count; /* of the other */
    float x[VERTICES_MAX], y[VERTICES_MAX], z[VERTICES_MAX];
    int32_t top[FACES_MAX];
    int32_t height[VERTICES_MAX * FACES_MAX]; /* by vertex, by face */
    int left_count;
    uint8_t left[HULL_MAP_ARCS_MAX];
} side;

typedef struct search {
    const unit_pair *p;
    columns a, b; /* in A's frame */
    side of_a, of_b;
    double depth, second; /* of all that have been tried */
    narrow_features nearest;
} search;

bool hull_axes_apply(const unit_pair *p)
{
    return p->a.type == SHAPE_HULL && p->b.type == SHAPE_HULL && p->a.hull->map && p->b.hull->map;
}

/* ---- heights ---- */

/* B's vertices in A's frame. */
LANES_INLINE void hull_axes_place_b(search *x)
{
    const hull *b = x->p->b.hull;
    const mat3 *r = &x->p->b_in_a.r;
    vec3 t = x->p->b_in_a.t;
    double scale = x->p->scale;
    for (uint32_t i = 0; i < b->vertex_count; i++) {
        double bx = b->x[i] * scale, by = b->y[i] * scale, bz = b->z[i] * scale;
        x->b.x[i] = r->x.x * bx + r->y.x * by + r->z.x * bz + t.x;
        x->b.y[i] = r->x.y * bx + r->y.y * by + r->z.y * bz + t.y;
        x->b.z[i] = r->x.z * bx + r->y.z * by + r->z.z * bz + t.z;
        x->of_a.x[i] = (float)x->b.x[i], x->of_a.y[i] = (float)x->b.y[i], x->of_a.z[i] = (float)x->b.z[i];
    }
    x->of_a.vertex_count = (int)b->vertex_count;
}

/* A's vertices, and where B sees them. */
LANES_INLINE void hull_axes_place_a(search *x)
{
    const hull *a = x->p->a.hull;
    const mat3 *r = &x->p->b_in_a.r;
    vec3 t = x->p->b_in_a.t;
    double scale = x->p->scale;
    for (uint32_t i = 0; i < a->vertex_count; i++) {
        double ax = a->x[i] * scale, ay = a->y[i] * scale, az = a->z[i] * scale;
        double dx = ax - t.x, dy = ay - t.y, dz = az - t.z;
        x->a.x[i] = ax, x->a.y[i] = ay, x->a.z[i] = az;
        x->of_b.x[i] = (float)(r->x.x * dx + r->x.y * dy + r->x.z * dz);
        x->of_b.y[i] = (float)(r->y.x * dx + r->y.y * dy + r->y.z * dz);
        x->of_b.z[i] = (float)(r->z.x * dx + r->z.y * dy + r->z.z * dz);
    }
    x->of_b.vertex_count = (int)a->vertex_count;
}

LANES_INLINE words greater(words a, words b)
{
    words m = a > b;
    return (m & a) | (~m & b);
}

LANES_INLINE words lesser(words a, words b)
{
    words m = a < b;
    return (m & a) | (~m & b);
}

LANES_INLINE singles hull_axes_load(const float *from)
{
    return *(const singles_anywhere *)from;
}

static inline float float_of(int32_t word)
{
    float x;
    memcpy(&x, &word, sizeof x);
    return x;
}

static inline int32_t word_of(float x)
{
    int32_t word;
    memcpy(&word, &x, sizeof word);
    return word;
}

LANES_INLINE bool any(words w)
{
    return (w[0] | w[1] | w[2] | w[3] | w[4] | w[5] | w[6] | w[7]) != 0;
}

LANES_INLINE int32_t hull_axes_least_of(words w)
{
    int32_t least = w[0];
    for (int k = 1; k < SINGLES; k++) least = w[k] < least ? w[k] : least;
    return least;
}

/* How deep each vertex of the other is below each face, and the deepest. Returns the least of these. */
LANES_INLINE float hull_axes_look(side *s, double scale)
{
    const hull_map *m = s->h->map;
    const float unit = (float)(m->unit * scale);
    const int vertices = s->vertex_count, stride = m->padded_faces;
    words least = (words){0} + INT32_MAX;
    for (int i = 0; i < stride; i += SINGLES) {
        singles nx = hull_axes_load(m->normal_x + i), ny = hull_axes_load(m->normal_y + i),
                nz = hull_axes_load(m->normal_z + i);
        singles offset = hull_axes_load(m->offset + i) * unit;
        words index = {0}, top = (words){0} + INT32_MIN;
        int32_t *to = s->height + i;
        for (int v = 0; v < vertices; v++, to += stride) {
            singles height = offset - (nx * s->x[v] + ny * s->y[v] + nz * s->z[v]);
            words word = ((words)height & ~INDEX_BITS) | index;
            *(words_anywhere *)to = word;
            top = greater(word, top);
            index += 1;
        }
        *(words_anywhere *)(s->top + i) = top;
        least = lesser(top, least);
    }
    return float_of(hull_axes_least_of(least));
}

LANES_INLINE words hull_axes_gather(const int32_t *from, words at)
{
    return (words){
        from[at[0]], from[at[1]], from[at[2]], from[at[3]], from[at[4]], from[at[5]], from[at[6]], from[at[7]]};
}

/* Of eight arcs: -1 where some point may be nearer than `limit`. */
LANES_INLINE words are_left(const side *s, int i, singles limit)
{
    const hull_map *m = s->h->map;
    words arc = *(const words_anywhere *)(m->arc + i), f0 = arc & FACE, f1 = arc >> HULL_ARC_F1 & FACE;
    words top0 = hull_axes_gather(s->top, f0), top1 = hull_axes_gather(s->top, f1);
    words below0 = hull_axes_gather(s->height, (top1 & INDEX_BITS) * m->padded_faces + f0);
    words below1 = hull_axes_gather(s->height, (top0 & INDEX_BITS) * m->padded_faces + f1);
    singles h0 = (singles)top0, h1 = (singles)top1;
    singles twice_cosine = __builtin_convertvector(arc >> HULL_ARC_COSINE, singles) * (1.0F / HULL_ARC_ONE);
    singles p = h0 - (singles)below0, q = h1 - (singles)below1; /* equal where n is along q n0 + p n1 */
    singles there = q * h0 + p * (singles)below1;               /* the height there, times the length of that */
    singles length2 = p * p + q * q + p * q * twice_cosine;
    words above = (h0 >= limit) & (h1 >= limit) & (there >= 0) & (there * there >= limit * limit * length2);
    return ~(above & (twice_cosine >= MOST_ARC));
}

/* The arcs of which some point may be nearer than `limit`. */
LANES_INLINE void prune(side *s, float limit)
{
    int count = 0, arcs = (int)s->h->edge_count;
    for (int i = 0; i < arcs; i += SINGLES) {
        words left = are_left(s, i, (singles){0} + limit);
        for (int k = 0; k < SINGLES; k++) {
            s->left[count] = (uint8_t)(i + k);
            count -= left[k];
        }
        while (count && s->left[count - 1] >= arcs) count--; /* the padding */
    }
    s->left_count = count;
}

/* ---- in doubles ---- */

static void note(search *x, double depth, const narrow_features *f)
{
    if (depth < x->depth) {
        x->second = x->depth;
        x->depth = depth;
        x->nearest = *f;
    } else {
        x->second = min_of(x->second, depth);
    }
}

/* An edge that is left, in A's frame; B's normals are turned round: the axis points from A to B. */
typedef struct edge {
    vec3 point, direction, n0, n1;
    double slack;
    uint16_t v0, v1;
} edge;

static vec3 hull_axes_normal_of(const hull_map *m, int face)
{
    return vec(m->normal_x[face], m->normal_y[face], m->normal_z[face]);
}

static edge hull_axes_edge_of(const unit_pair *p, const side *s, int i, const columns *at)
{
    const hull_map *m = s->h->map;
    int32_t arc = m->arc[i];
    int v0 = arc >> HULL_ARC_V0 & INDEX_BITS, v1 = arc >> HULL_ARC_V1 & INDEX_BITS;
    vec3 from = vec(at->x[v0], at->y[v0], at->z[v0]), to = vec(at->x[v1], at->y[v1], at->z[v1]);
    vec3 along = vec_sub(to, from);
    return (edge){.point = from,
        .direction = along,
        .n0 = hull_axes_normal_of(m, arc & FACE),
        .n1 = hull_axes_normal_of(m, arc >> HULL_ARC_F1 & FACE),
        .slack = SIDE_SLACK * vec_greatest(along) + p->error,
        .v0 = (uint16_t)v0,
        .v1 = (uint16_t)v1};
}

/* Surely on one side of a plane through the origin? */
static inline bool beside(double x, double y, double slack)
{
    return (x > slack && y > slack) || (x < -slack && y < -slack);
}

/* With edges a and b whose ends err by p->error, the axis errs by p->error (1 / |a| + 1 / |b|) / sine, that is by
 * p->error (|a| + |b|) / |a x b|, and the height along it by as much of the size. False where that is too much. */
static bool hull_axes_try_edges(search *x, const edge *a, const edge *b)
{
    vec3 n = vec_cross(a->direction, b->direction);
    double n2 = vec_norm2(n), edges2 = vec_norm2(a->direction) + vec_norm2(b->direction), size = x->p->size;
    if (!(n2 > LEAST_CROSS2 * size * size * edges2)) return false;
    double along_a = vec_dot(n, vec_add(a->n0, a->n1)), along_b = vec_dot(n, vec_add(b->n0, b->n1));
    if (along_a * along_b <= 0) return true; /* at opposite points of the two circles */
    double apart = vec_dot(n, vec_sub(b->point, a->point)) / sqrt(n2);
    narrow_features f = {.count_a = 2, .count_b = 2, .a = {a->v0, a->v1}, .b = {b->v0, b->v1}};
    note(x, along_a < 0 ? apart : -apart, &f);
    return true;
}

static bool try_pairs(search *x)
{
    edge a[HULL_MAP_ARCS_MAX];
    for (int i = 0; i < x->of_a.left_count; i++) a[i] = hull_axes_edge_of(x->p, &x->of_a, x->of_a.left[i], &x->a);
    for (int k = 0; k < x->of_b.left_count; k++) {
        edge b = hull_axes_edge_of(x->p, &x->of_b, x->of_b.left[k], &x->b);
        b.n0 = vec_neg(mat_mul(x->p->b_in_a.r, b.n0));
        b.n1 = vec_neg(mat_mul(x->p->b_in_a.r, b.n1));
        for (int i = 0; i < x->of_a.left_count; i++) {
            if (beside(vec_dot(b.n0, a[i].direction), vec_dot(b.n1, a[i].direction), a[i].slack)) continue;
            if (beside(vec_dot(a[i].n0, b.direction), vec_dot(a[i].n1, b.direction), b.slack)) continue;
            if (!hull_axes_try_edges(x, &a[i], &b)) return false;
        }
    }
    return true;
}

/* A face of A over the vertex of B that is deepest below it, or the other way round. */
static void try_face_of_a(search *x, uint32_t i)
{
    const hull *a = x->p->a.hull;
    const hull_face *face = &a->faces[i];
    narrow_features f = {.count_b = 1};
    uint32_t vertex = hull_scan(x->p->b.hull, vec_neg(mat_tmul(x->p->b_in_a.r, face->normal)));
    vec3 lowest = vec(x->b.x[vertex], x->b.y[vertex], x->b.z[vertex]);
    f.count_a = hull_feature(a, a->vertex_count + a->edge_count + i, f.a);
    f.b[0] = (uint16_t)vertex;
    note(x, face->offset * x->p->scale - vec_dot(face->normal, lowest), &f);
}

static void try_face_of_b(search *x, uint32_t i)
{
    const hull *b = x->p->b.hull;
    const hull_face *face = &b->faces[i];
    narrow_features f = {.count_a = 1};
    vec3 n = mat_mul(x->p->b_in_a.r, face->normal);
    uint32_t vertex = hull_scan(x->p->a.hull, vec_neg(n));
    vec3 lowest = vec(x->a.x[vertex], x->a.y[vertex], x->a.z[vertex]);
    f.count_b = hull_feature(b, b->vertex_count + b->edge_count + i, f.b);
    f.a[0] = (uint16_t)vertex;
    note(x, face->offset * x->p->scale + vec_dot(n, vec_sub(x->p->b_in_a.t, lowest)), &f);
}

/* Those that may be the nearest facet, or close to it. */
LANES_INLINE void hull_axes_try_faces(search *x, const side *s, void (*try)(search *x, uint32_t i), float slack)
{
    int count = (int)s->h->face_count;
    for (int i = 0; i < count; i += SINGLES) {
        words low = *(const words_anywhere *)(s->top + i) < word_of((float)x->depth + slack);
        if (!any(low)) continue;
        for (int k = 0; k < SINGLES && i + k < count; k++)
            if (low[k]) try(x, (uint32_t)(i + k));
    }
}

LANES_INLINE bool hull_axes_find(search *x)
{
    const unit_pair *p = x->p;
    float slack = (float)(SLACK * p->size), least = (float)(NEAR_LEAST_DEPTH * p->size);
    hull_axes_place_b(x);
    float depth = hull_axes_look(&x->of_a, p->scale);
    if (!(depth >= least)) return false; /* apart along the face, or too shallow for F to be strict */
    hull_axes_place_a(x);
    depth = (float)min_of(depth, hull_axes_look(&x->of_b, p->scale));
    if (!(depth >= least)) return false;
    prune(&x->of_a, depth + slack);
    prune(&x->of_b, depth + slack);
    x->depth = depth + slack, x->second = INFINITY;
    if (!try_pairs(x)) return false;
    hull_axes_try_faces(x, &x->of_a, try_face_of_a, slack);
    hull_axes_try_faces(x, &x->of_b, try_face_of_b, slack);
    return true;
}

LANES_TWINS(LANES_WIDE, bool, find, hull_axes_find, (search *const x), (x));

/* Most pairs that are apart are so along the line of their origins. */
bool hull_axes_parted(const unit_pair *p)
{
    vec3 away = p->b_in_a.t, away_in_b = mat_tmul(p->b_in_a.r, away);
    vec3 a = hull_vertex(p->a.hull, hull_scan(p->a.hull, away));
    vec3 b = hull_vertex(p->b.hull, hull_scan(p->b.hull, vec_neg(away_in_b)));
    return vec_norm2(away) + p->scale * (vec_dot(away_in_b, b) - vec_dot(away, a)) > 0;
}

bool hull_axes_depth(const unit_pair *p, const narrow_goal *goal, span *out)
{
    search x;
    x.p = p;
    x.of_a.h = p->a.hull, x.of_b.h = p->b.hull;
    x.nearest.count_a = 0;
    if (!LANES_CHOSEN(find)(&x) || !x.nearest.count_a) return false;
    x.nearest.deep = true;
    if (!near_features_span(p, goal, &x.nearest, out)) return false;
    return x.second >= -0.5 * (out->lo + out->hi) + 2 * NEAR_DEPTH_MARGIN * p->size;
}
