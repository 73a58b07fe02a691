/* mesh: reads a mesh file into memory, lets assimp decode it, and gathers the different vertices. One thread; the
 * result does not depend on the order in which the file names its vertices. */
#include "mesh.h"

#include "text.h"

#include <assimp/cimport.h>
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

static bool add_mesh(gathering *g, const struct aiMatrix4x4 *m, unsigned index)
{
    const struct aiMesh *mesh = g->scene->mMeshes[index];
    if (!g->points) { /* the first pass counts */
        g->count += mesh->mNumVertices;
        if (g->count <= MESH_VERTICES_MAX) return true;
        return load_fail(g->report, "%s: has more than %d vertices", g->path, MESH_VERTICES_MAX);
    }
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

static int by_coordinates(const void *left, const void *right)
{
    const double *a = left, *b = right;
    for (int i = 0; i < 3; i++)
        if (a[i] != b[i]) return a[i] < b[i] ? -1 : 1;
    return 0;
}

static size_t sort_and_unite(double *points, size_t count)
{
    qsort(points, count, 3 * sizeof *points, by_coordinates);
    size_t kept = 0;
    for (size_t i = 0; i < count; i++) {
        if (kept && by_coordinates(points + 3 * (kept - 1), points + 3 * i) == 0) continue;
        memmove(points + 3 * kept++, points + 3 * i, 3 * sizeof *points);
    }
    return kept;
}

static bool gather(pool *p, gathering *g, mesh_points *out)
{
    if (!walk(g, g->scene->mRootNode, &identity, 0)) return false;
    if (g->count == 0) return load_fail(g->report, "%s: has no vertices", g->path);
    g->points = pool_alloc(p, g->count, 3 * sizeof *g->points);
    g->count = 0;
    if (!walk(g, g->scene->mRootNode, &identity, 0)) return false;
    out->at = g->points;
    out->count = sort_and_unite(g->points, g->count);
    if (out->count <= MESH_POINTS_MAX) return true;
    return load_fail(g->report, "%s: has %zu different points; a hull takes at most %d: simplify the mesh", g->path,
        out->count, MESH_POINTS_MAX);
}

/* What is behind the last dot of the file's name tells assimp the format. */
static const char *format_of(const char *path)
{
    const char *slash = strrchr(path, '/'), *dot = strrchr(slash ? slash : path, '.');
    return dot ? dot + 1 : "";
}

static bool decode(pool *p, const char *path, const char *data, size_t size, gathering *g, mesh_points *out)
{
    if (size == 0) return load_fail(g->report, "%s: cannot be read as a mesh: the file is empty", path);
    g->scene = aiImportFileFromMemory(data, (unsigned)size, 0, format_of(path));
    if (!g->scene) return load_fail(g->report, "%s: cannot be read as a mesh: %s", path, aiGetErrorString());
    bool ok = g->scene->mRootNode ? gather(p, g, out) : load_fail(g->report, "%s: has no meshes", path);
    aiReleaseImport(g->scene);
    return ok;
}

bool mesh_load(pool *p, const char *path, const double scale[3], mesh_points *out, load_report *r)
{
    pool file = {0};
    size_t size;
    const char *data = text_read_file(&file, path, MESH_FILE_MAX, &size, r);
    gathering g = {.path = path, .scale = scale, .report = r};
    bool ok = data && decode(p, path, data, size, &g, out);
    pool_free(&file);
    return ok;
}
