/* mesh: reads a mesh file into memory, lets assimp decode it, and gathers the different vertices, or the triangles. One
 * thread; the points of a hull do not depend on the order in which the file names its vertices. */
#include "mesh.h"

#include "mesh_import.h"
#include "text.h"

#include <assimp/cimport.h>
#include <assimp/postprocess.h>
#include <assimp/scene.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { NODE_DEPTH_MAX = 64 };

typedef struct gathering {
    const char *path;
    const struct aiScene *scene;
    const double *scale;
    double *points;
    size_t count; /* points written; while counting: vertices met */
    bool wants_triangles;
    int32_t *corners;
    size_t corner_count; /* likewise */
    load_report *report;
} gathering;

static const struct aiMatrix4x4 identity = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};

static struct aiMatrix4x4 product(const struct aiMatrix4x4 *a, const struct aiMatrix4x4 *b)
{
    struct aiMatrix4x4 out = *a;
    aiMultiplyMatrix4(&out, b);
    return out;
}

static bool add_vertex(gathering *g, const struct aiMatrix4x4 *m, const struct aiVector3D *v)
{
    double x = v->x, y = v->y, z = v->z;
    double *out = g->points + 3 * g->count++;
    out[0] = g->scale[0] * (m->a1 * x + m->a2 * y + m->a3 * z + m->a4);
    out[1] = g->scale[1] * (m->b1 * x + m->b2 * y + m->b3 * z + m->b4);
    out[2] = g->scale[2] * (m->c1 * x + m->c2 * y + m->c3 * z + m->c4);
    for (int i = 0; i < 3; i++) {
        if (!isfinite(out[i])) return load_fail(g->report, "%s: a vertex is not a finite number", g->path);
        out[i] += 0.0; /* -0 becomes 0: one point has one spelling */
    }
    return true;
}

static bool count_mesh(gathering *g, const struct aiMesh *mesh)
{
    g->count += mesh->mNumVertices;
    for (unsigned i = 0; i < mesh->mNumFaces; i++) g->corner_count += mesh->mFaces[i].mNumIndices == 3 ? 3 : 0;
    if (g->count > MESH_VERTICES_MAX)
        return load_fail(g->report, "%s: has more than %d vertices", g->path, MESH_VERTICES_MAX);
    if (g->wants_triangles && 3 * g->count + g->corner_count > MESH_NUMBERS_MAX)
        return load_fail(g->report, "%s: has more than %d numbers: simplify the mesh", g->path, MESH_NUMBERS_MAX);
    return true;
}

/* Points and lines are no triangles. */
static void add_triangles(gathering *g, const struct aiMesh *mesh)
{
    for (unsigned i = 0; i < mesh->mNumFaces; i++) {
        const struct aiFace *face = &mesh->mFaces[i];
        for (unsigned k = 0; face->mNumIndices == 3 && k < 3; k++)
            g->corners[g->corner_count++] = (int32_t)(g->count + face->mIndices[k]);
    }
}

static bool add_mesh(gathering *g, const struct aiMatrix4x4 *m, unsigned index)
{
    const struct aiMesh *mesh = g->scene->mMeshes[index];
    if (!g->points) return count_mesh(g, mesh); /* the first pass counts */
    if (g->wants_triangles) add_triangles(g, mesh);
    for (unsigned i = 0; i < mesh->mNumVertices; i++)
        if (!add_vertex(g, m, &mesh->mVertices[i])) return false;
    return true;
}

static bool walk(gathering *g, const struct aiNode *node, const struct aiMatrix4x4 *above, int depth)
{
    if (depth > NODE_DEPTH_MAX) return load_fail(g->report, "%s: nodes nested deeper than %d", g->path, NODE_DEPTH_MAX);
    struct aiMatrix4x4 m = product(above, &node->mTransformation);
    for (unsigned i = 0; i < node->mNumMeshes; i++)
        if (!add_mesh(g, &m, node->mMeshes[i])) return false;
    for (unsigned i = 0; i < node->mNumChildren; i++)
        if (!walk(g, node->mChildren[i], &m, depth + 1)) return false;
    return true;
}

static int compare_mesh_points(const void *left, const void *right)
{
    const double *a = left, *b = right;
    for (int i = 0; i < 3; i++)
        if (a[i] != b[i]) return a[i] < b[i] ? -1 : 1;
    return 0;
}

static size_t sort_and_unite(double *points, size_t count)
{
    qsort(points, count, 3 * sizeof *points, compare_mesh_points);
    size_t kept = 0;
    for (size_t i = 0; i < count; i++) {
        if (kept && compare_mesh_points(points + 3 * (kept - 1), points + 3 * i) == 0) continue;
        memmove(points + 3 * kept++, points + 3 * i, 3 * sizeof *points);
    }
    return kept;
}

static bool gather(pool *p, gathering *g)
{
    if (!walk(g, g->scene->mRootNode, &identity, 0)) return false;
    if (g->count == 0) return load_fail(g->report, "%s: has no vertices", g->path);
    if (g->wants_triangles && g->corner_count == 0) return load_fail(g->report, "%s: has no triangles", g->path);
    g->points = pool_alloc(p, g->count, 3 * sizeof *g->points);
    if (g->wants_triangles) g->corners = pool_alloc(p, g->corner_count, sizeof *g->corners);
    g->count = g->corner_count = 0;
    return walk(g, g->scene->mRootNode, &identity, 0);
}

static bool thin_out(gathering *g, mesh_points *out)
{
    out->at = g->points;
    out->count = sort_and_unite(g->points, g->count);
    if (out->count <= MESH_POINTS_MAX) return true;
    return load_fail(g->report, "%s: has %zu different points; a hull takes at most %d: simplify the mesh", g->path,
        out->count, MESH_POINTS_MAX);
}

static bool decode_mesh(pool *p, const char *path, const char *data, size_t size, gathering *g)
{
    if (size == 0) return load_fail(g->report, "%s: cannot be read as a mesh: the file is empty", path);
    unsigned steps = g->wants_triangles ? aiProcess_Triangulate : 0;
    g->scene = mesh_import(path, data, size, steps, g->report);
    if (!g->scene) return false;
    bool ok = g->scene->mRootNode ? gather(p, g) : load_fail(g->report, "%s: has no meshes", path);
    aiReleaseImport(g->scene);
    return ok;
}

static bool load(pool *p, gathering *g)
{
    pool file = {0};
    size_t size;
    const char *data = text_read_file(&file, g->path, MESH_FILE_MAX, &size, g->report);
    bool ok = data && decode_mesh(p, g->path, data, size, g);
    pool_free(&file);
    return ok;
}

bool mesh_load(pool *p, const char *path, const double scale[3], mesh_points *out, load_report *r)
{
    gathering g = {.path = path, .scale = scale, .report = r};
    return load(p, &g) && thin_out(&g, out);
}

/* A scale that mirrors turns the triangles inside out: they are turned back. */
bool mesh_load_triangles(pool *p, const char *path, const double scale[3], mesh_triangles *out, load_report *r)
{
    gathering g = {.path = path, .scale = scale, .report = r, .wants_triangles = true};
    if (!load(p, &g)) return false;
    for (size_t i = 0; scale[0] * scale[1] * scale[2] < 0 && i < g.corner_count; i += 3) {
        int32_t second = g.corners[i + 1];
        g.corners[i + 1] = g.corners[i + 2];
        g.corners[i + 2] = second;
    }
    *out = (mesh_triangles){g.points, g.count, g.corners, g.corner_count / 3};
    return true;
}
