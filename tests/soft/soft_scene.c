#include "soft_scene.h"

#include "base/prng.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static void *get(size_t count, size_t size)
{
    void *p = calloc(count ? count : 1, size);
    if (!p) abort();
    return p;
}

static soft_scene room(size_t vertices, size_t triangles)
{
    soft_scene s = {.vertex_count = vertices, .triangle_count = triangles};
    s.start = get(vertices, sizeof *s.start), s.end = get(vertices, sizeof *s.end);
    s.triangles = get(triangles, sizeof *s.triangles);
    return s;
}

void soft_scene_free(soft_scene *s)
{
    free(s->start), free(s->end), free(s->triangles);
    *s = (soft_scene){0};
}

static double quotient(size_t a, size_t b) /* rounded down */
{
    size_t q = a / b;
    return (double)q;
}

/* ---- made ---- */

const char *soft_class_name(soft_class c)
{
    static const char *const NAMES[] = {"crumpled", "folded", "knotted", "sliding", "lattice", "soup"};
    return NAMES[c];
}

/* wide x high squares of two triangles each; `round`: the last column is joined to the first. */
static soft_scene sheet(size_t wide, size_t high, bool round)
{
    size_t columns = round ? wide : wide + 1;
    soft_scene s = room(columns * (high + 1), 2 * wide * high);
    size_t n = 0;
    for (size_t y = 0; y < high; y++)
        for (size_t x = 0; x < wide; x++) {
            uint32_t a = (uint32_t)(y * columns + x), b = (uint32_t)(y * columns + (x + 1) % columns);
            uint32_t c = a + (uint32_t)columns, d = b + (uint32_t)columns;
            memcpy(s.triangles[n++], (uint32_t[3]){a, b, d}, sizeof s.triangles[0]);
            memcpy(s.triangles[n++], (uint32_t[3]){a, d, c}, sizeof s.triangles[0]);
        }
    return s;
}

static vec3 jolt(uint64_t *seed, double by)
{
    double x = prng_in(seed, -by, by), y = prng_in(seed, -by, by), z = prng_in(seed, -by, by);
    return vec(x, y, z);
}

static soft_scene crumpled(uint64_t *seed, size_t side)
{
    soft_scene s = sheet(side, side, false);
    double by = prng_in(seed, 0.4, 1.4);
    for (size_t i = 0; i < s.vertex_count; i++) {
        vec3 at = vec((double)(i % (side + 1)), quotient(i, side + 1), 0);
        s.start[i] = vec_add(at, jolt(seed, by));
        s.end[i] = vec_add(s.start[i], jolt(seed, by));
    }
    return s;
}

static vec3 fold(double x, double y, double angle)
{
    return x < 0 ? vec(x, y, 0) : vec(x * cos(angle), y, x * sin(angle));
}

static soft_scene folded(uint64_t *seed, size_t side)
{
    soft_scene s = sheet(side, side, false);
    double crease = prng_in(seed, 0.3, 0.7) * (double)side, from = prng_in(seed, 1, 2.9), to = prng_in(seed, 2.9, 3.4);
    for (size_t i = 0; i < s.vertex_count; i++) {
        double x = (double)(i % (side + 1)) - crease, y = quotient(i, side + 1);
        s.start[i] = fold(x, y, from), s.end[i] = vec_add(fold(x, y, to), jolt(seed, 1e-3));
    }
    return s;
}

static vec3 on_knot(double t, double tight)
{
    return vec(sin(t) + 2 * sin(2 * t), cos(t) - 2 * cos(2 * t), -tight * sin(3 * t));
}

static soft_scene knotted(uint64_t *seed, size_t side)
{
    size_t wide = 2 * side * side / 6, high = 3;
    soft_scene s = sheet(wide, high, true);
    double turn = prng_in(seed, 0, 6), width = prng_in(seed, 0.2, 0.6), loose = prng_in(seed, 0.5, 1.2);
    for (size_t i = 0; i < s.vertex_count; i++) {
        double t = 6.283185307179586 * (double)(i % wide) / (double)wide, across = quotient(i, wide) / 3 - 0.5;
        vec3 side_way = vec_scale(vec(cos(t + turn), sin(t + turn), 1), width * across);
        s.start[i] = vec_add(on_knot(t, loose), side_way);
        s.end[i] = vec_add(on_knot(t, -0.1), vec_add(side_way, jolt(seed, 0.02)));
    }
    return s;
}

static soft_scene sliding(uint64_t *seed, size_t side)
{
    size_t high = side / 2;
    soft_scene one = sheet(side, high, false), s = room(2 * one.vertex_count, 2 * one.triangle_count);
    vec3 by = vec(prng_in(seed, -1, 1), prng_in(seed, -1, 1), 0);
    for (size_t i = 0; i < s.triangle_count; i++)
        for (int k = 0; k < 3; k++)
            s.triangles[i][k] =
                one.triangles[i % one.triangle_count][k] + (i < one.triangle_count ? 0 : (uint32_t)one.vertex_count);
    for (size_t i = 0; i < s.vertex_count; i++) {
        size_t k = i % one.vertex_count;
        vec3 at = vec((double)(k % (side + 1)), quotient(k, side + 1), 0);
        bool upper = i >= one.vertex_count;
        s.start[i] = upper ? vec_add(at, vec(0.3, 0.2, 0.25)) : at;
        s.end[i] = upper ? vec_add(vec_add(at, by), vec(0.3, 0.2, 0)) : at;
        if (upper && *seed % 2) s.start[i].z = 0;
    }
    soft_scene_free(&one);
    return s;
}

static soft_scene lattice(uint64_t *seed, size_t side)
{
    soft_scene s = sheet(side, side, false);
    for (size_t i = 0; i < s.vertex_count; i++) {
        uint64_t r = prng_bits(seed);
        s.start[i] = vec((double)(i % (side + 1)), quotient(i, side + 1), (double)(r & 1));
        s.end[i] =
            vec_add(s.start[i], vec((double)(r >> 1 & 3) - 1, (double)(r >> 3 & 3) - 1, (double)(r >> 5 & 3) - 1));
    }
    return s;
}

static soft_scene soup(uint64_t *seed, size_t side)
{
    size_t n = side * side;
    soft_scene s = room(3 * n, n);
    for (size_t i = 0; i < n; i++) {
        uint32_t v = (uint32_t)(3 * i);
        uint64_t r = prng_bits(seed) % 8;
        memcpy(s.triangles[i], (uint32_t[3]){v, r == 0 ? v : v + 1, r == 0 ? v : r == 1 ? v + 1 : v + 2}, 12);
        vec3 at = jolt(seed, 0.25 * (double)side), way = jolt(seed, 0.5);
        for (int k = 0; k < 3; k++) {
            s.start[3 * i + (size_t)k] = vec_add(at, jolt(seed, 0.5));
            s.end[3 * i + (size_t)k] = vec_add(s.start[3 * i + (size_t)k], vec_add(way, jolt(seed, 0.2)));
        }
    }
    return s;
}

soft_scene soft_scene_make(soft_class c, uint64_t seed, size_t about_triangles)
{
    static soft_scene (*const MAKE[])(uint64_t *, size_t) = {crumpled, folded, knotted, sliding, lattice, soup};
    size_t side = (size_t)(sqrt((double)about_triangles / (c == SOFT_SOUP ? 1 : 2)) + 0.5);
    seed = seed * 64 + (uint64_t)c;
    return MAKE[c](&seed, side);
}

static vec3 waving(double x, double y, double t, double violence)
{
    double calm = 0.04 * sin(5 * x + 2 * t) * cos(4 * y - t);
    vec3 flat = vec(x, y, calm);
    if (violence <= 0) return flat;
    double a = 9 * x + 3 * t, b = 11 * y - 2 * t; /* folds that lie upon each other */
    vec3 fold_way = vec(-0.16 * sin(a) - 0.02 * sin(31 * y + 9 * t), -0.12 * sin(b), 0.12 * cos(a) + 0.1 * cos(b));
    return vec_madd(flat, violence, fold_way);
}

soft_scene soft_scene_cloth(size_t cells, double time, double dt, double violence)
{
    soft_scene s = sheet(cells, cells, false);
    for (size_t i = 0; i < s.vertex_count; i++) {
        double x = (double)(i % (cells + 1)) / (double)cells, y = quotient(i, cells + 1) / (double)cells;
        s.start[i] = waving(x, y, time, violence), s.end[i] = waving(x, y, time + dt, violence);
    }
    return s;
}

/* ---- shared ---- */

const soft_truth SOFT_TRUTH[SOFT_TRUTHS] = {
    {"cloth-funnel", "227.ply", "228.ply", "227", 27, 107},
    {"rod-twist", "3036.ply", "3037.ply", "3036", 765, 4179},
    {"cloth-ball", "cloth_ball92.ply", "cloth_ball93.ply", "92", 19032, 94822},
};

static FILE *open_shared(const soft_truth *t, const char *file)
{
    char path[4096];
    const char *shared = getenv("COLLIDED_SHARED");
    (void)snprintf(path, sizeof path, "%s/cases/soft/%s/%s", shared ? shared : COLLIDED_SHARED, t->name, file);
    return fopen(path, "rb");
}

static void refuse(const char *what)
{
    (void)fprintf(stderr, "a shared frame is damaged: %s\n", what);
    abort();
}

typedef struct ply {
    FILE *file;
    size_t vertices, faces;
    bool big_endian, doubles;
} ply;

static void read_header(ply *p)
{
    char line[512];
    while (fgets(line, sizeof line, p->file)) {
        if (strncmp(line, "end_header", 10) == 0) return;
        if (strstr(line, "binary_big_endian")) p->big_endian = true;
        if (strncmp(line, "element vertex ", 15) == 0) p->vertices = strtoull(line + 15, NULL, 10);
        if (strncmp(line, "element face ", 13) == 0) p->faces = strtoull(line + 13, NULL, 10);
        if (strncmp(line, "property double x", 17) == 0) p->doubles = true;
    }
    refuse("header");
}

static void read_number(const ply *p, void *to, size_t size)
{
    unsigned char bytes[8], turned[8];
    if (fread(bytes, 1, size, p->file) != size) refuse("too short");
    for (size_t i = 0; i < size; i++) turned[i] = bytes[p->big_endian ? size - 1 - i : i];
    memcpy(to, turned, size);
}

static double read_coordinate(const ply *p)
{
    double x;
    float f;
    if (p->doubles)
        read_number(p, &x, sizeof x);
    else
        read_number(p, &f, sizeof f), x = (double)f;
    return x;
}

static void read_ply(ply *p, vec3 **at, uint32_t (**triangles)[3])
{
    read_header(p);
    *at = get(p->vertices, sizeof **at);
    *triangles = get(p->faces, sizeof **triangles);
    for (size_t i = 0; i < p->vertices; i++) {
        double x = read_coordinate(p), y = read_coordinate(p), z = read_coordinate(p);
        (*at)[i] = vec(x, y, z);
    }
    for (size_t i = 0; i < p->faces; i++) {
        unsigned char corners;
        if (fread(&corners, 1, 1, p->file) != 1 || corners != 3) refuse("not a triangle");
        for (int k = 0; k < 3; k++) read_number(p, &(*triangles)[i][k], sizeof(*triangles)[i][k]);
    }
    (void)fclose(p->file);
}

bool soft_scene_read(const soft_truth *t, soft_scene *out)
{
    ply start = {.file = open_shared(t, t->start)}, end = {.file = open_shared(t, t->end)};
    if (!start.file || !end.file) {
        if (start.file) (void)fclose(start.file);
        if (end.file) (void)fclose(end.file);
        return false;
    }
    uint32_t(*same)[3];
    read_ply(&start, &out->start, &out->triangles);
    read_ply(&end, &out->end, &same);
    out->vertex_count = start.vertices, out->triangle_count = start.faces;
    if (end.vertices != start.vertices || end.faces != start.faces) refuse("two meshes");
    if (memcmp(same, out->triangles, start.faces * sizeof *same) != 0) refuse("two topologies");
    free(same);
    return true;
}

static char *read_text(const soft_truth *t, const char *rest)
{
    char name[128];
    (void)snprintf(name, sizeof name, "%s%s", t->number, rest);
    FILE *f = open_shared(t, name);
    if (!f) refuse(name);
    size_t size = 0, room_for = 1 << 16;
    char *text = malloc(room_for);
    if (!text) abort();
    for (size_t n; (n = fread(text + size, 1, room_for - size - 1, f)) > 0;) {
        size += n;
        if (room_for - size < 2 && !(text = realloc(text, room_for *= 2))) abort();
    }
    (void)fclose(f);
    text[size] = 0;
    return text;
}

typedef struct soft_listed { /* of the pairs of numbers in the lists those that are true */
    uint32_t (*at)[2];
    size_t count;
} soft_listed;

static const char *after(const char *text, const char *set) /* past what is of this set of characters */
{
    return text + strspn(text, set);
}

static soft_listed read_lists(const soft_truth *t, soft_kind kind)
{
    char *pairs = read_text(t, kind == SOFT_EDGE_EDGE ? "ee.json" : "vf.json");
    char *truths = read_text(t, kind == SOFT_EDGE_EDGE ? "ee_mma_bool.json" : "vf_mma_bool.json");
    soft_listed list = {.at = get(strlen(pairs) / 5 + 1, sizeof *list.at)};
    const char *p = after(pairs, "[], \n"), *b = after(truths, "[], \n");
    while (*p && *b) {
        char *next;
        list.at[list.count][0] = (uint32_t)strtoul(p, &next, 10);
        p = after(next, "[], \n");
        list.at[list.count][1] = (uint32_t)strtoul(p, &next, 10);
        p = after(next, "[], \n");
        list.count += strncmp(b, "true", 4) == 0;
        b = after(b + strcspn(b, ",]"), "[], \n");
    }
    if (*p || *b) refuse("lists of different lengths");
    free(pairs), free(truths);
    return list;
}

static int compare_keys(const void *a, const void *b)
{
    uint64_t x = *(const uint64_t *)a, y = *(const uint64_t *)b;
    return (x > y) - (x < y);
}

static void require(bool holds)
{
    if (!holds) refuse("a number in a list names no feature");
}

/* The lists number vertices, then edges, then faces; edges in the order of (greater, lesser) vertex, as libigl has
 * them. By that number: ours. */
static uint32_t *edge_numbers(const soft_mesh *m)
{
    size_t n = soft_mesh_edge_count(m);
    uint64_t *keys = calloc(n, sizeof *keys);
    uint32_t *ours = calloc(n, sizeof *ours), ends[2];
    if (!keys || !ours) abort();
    for (uint32_t e = 0; e < n; e++) {
        soft_mesh_edge(m, e, ends);
        keys[e] = (uint64_t)ends[1] << 32 | ends[0];
    }
    uint64_t *sorted = malloc(n * sizeof *sorted);
    if (!sorted) abort();
    memcpy(sorted, keys, n * sizeof *sorted);
    qsort(sorted, n, sizeof *sorted, compare_keys);
    for (uint32_t e = 0; e < n; e++) {
        const uint64_t *at = bsearch(&keys[e], sorted, n, sizeof *sorted, compare_keys);
        ours[at - sorted] = e;
    }
    free(keys), free(sorted);
    return ours;
}

/* Pairs of a list as keys of ours, sorted. */
static uint64_t *keys_of_faces(const soft_mesh *m, const soft_listed *truth)
{
    size_t before = soft_mesh_vertex_count(m) + soft_mesh_edge_count(m);
    uint64_t *keys = get(truth->count + 1, sizeof *keys);
    for (size_t i = 0; i < truth->count; i++) {
        uint32_t v = truth->at[i][0], f = truth->at[i][1];
        if (v > f) v = f, f = truth->at[i][0];
        require(v < soft_mesh_vertex_count(m) && f >= before && f - before < soft_mesh_triangle_count(m));
        keys[i] = (uint64_t)v << 32 | (uint32_t)(f - before);
    }
    qsort(keys, truth->count, sizeof *keys, compare_keys);
    return keys;
}

static uint64_t *keys_of_edges(const soft_mesh *m, const soft_listed *truth)
{
    size_t before = soft_mesh_vertex_count(m);
    uint32_t *number = edge_numbers(m);
    uint64_t *keys = get(truth->count + 1, sizeof *keys);
    for (size_t i = 0; i < truth->count; i++) {
        size_t a = truth->at[i][0] - before, b = truth->at[i][1] - before;
        require(a < soft_mesh_edge_count(m) && b < soft_mesh_edge_count(m));
        uint32_t x = number[a], y = number[b];
        keys[i] = x < y ? (uint64_t)x << 32 | y : (uint64_t)y << 32 | x;
    }
    qsort(keys, truth->count, sizeof *keys, compare_keys);
    free(number);
    return keys;
}

uint64_t *soft_truth_read(const soft_truth *t, const soft_mesh *m, soft_kind kind, size_t *count)
{
    soft_listed list = read_lists(t, kind);
    uint64_t *keys = kind == SOFT_EDGE_EDGE ? keys_of_edges(m, &list) : keys_of_faces(m, &list);
    *count = list.count;
    free(list.at);
    return keys;
}
