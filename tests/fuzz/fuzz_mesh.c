/* Any numbers in a mesh file, STL or OBJ, whose grammar is right: refused with one line, or finite points and triangles
 * over them. That assimp outlives files whose grammar is wrong is its own business: it reads the user's own files, in
 * the user's process. */
#include "fuzz.h"
#include "take.h"

#include "loaders/mesh.h"

#include <stdlib.h>
#include <unistd.h>

enum { THINGS_MAX = 64 };

static void write_stl(FILE *f, taking *t)
{
    uint8_t head[80] = "solid? no, binary";
    uint32_t triangles = take_byte(t) % (THINGS_MAX + 1);
    uint16_t attribute = 0;
    fwrite(head, 1, sizeof head, f);
    fwrite(&triangles, sizeof triangles, 1, f);
    for (uint32_t i = 0; i < triangles; i++) {
        for (int k = 0; k < 12; k++) {
            double taken = take_number(t);
            float number = fabs(taken) < 3e38 ? (float)taken : taken > 0 ? INFINITY : -INFINITY;
            fwrite(&number, sizeof number, 1, f);
        }
        fwrite(&attribute, sizeof attribute, 1, f);
    }
}

static void write_obj(FILE *f, taking *t)
{
    int points = 1 + take_byte(t) % THINGS_MAX, faces = take_byte(t) % THINGS_MAX;
    for (int i = 0; i < points; i++) {
        double x = take_number(t), y = take_number(t), z = take_number(t);
        fprintf(f, "v %.9g %.9g %.9g\n", isfinite(x) ? x : 1e38, isfinite(y) ? y : 0, isfinite(z) ? z : -1e38);
    }
    for (int i = 0; i < faces; i++) {
        fprintf(f, "f");
        for (int k = 2 + take_byte(t) % 4; k-- > 0;) fprintf(f, " %d", 1 + take_byte(t) % points);
        fprintf(f, "\n");
    }
}

static void check_triangles(const mesh_triangles *m)
{
    for (size_t i = 0; i < 3 * m->point_count; i++) PROMISE(isfinite(m->points[i]));
    for (size_t i = 0; i < 3 * m->count; i++) PROMISE(m->corners[i] >= 0 && (size_t)m->corners[i] < m->point_count);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    static char paths[2][64];
    taking t = {data, size, 1};
    if (!*paths[0])
        for (int i = 0; i < 2; i++)
            snprintf(paths[i], sizeof paths[i], "/dev/shm/fuzz_mesh.%d.%s", (int)getpid(), i ? "obj" : "stl");
    int which = take_byte(&t) % 2;
    double scale[3] = {1, 1, 1};
    if (take_byte(&t) % 4 == 0)
        for (int i = 0; i < 3; i++) scale[i] = take_number(&t);
    FILE *f = fopen(paths[which], "wb");
    PROMISE(f);
    which ? write_obj(f, &t) : write_stl(f, &t);
    fclose(f);
    pool p = {0};
    load_report r = {.error = ""};
    mesh_points points;
    mesh_triangles triangles;
    if (mesh_load(&p, paths[which], scale, &points, &r))
        for (size_t i = 0; i < 3 * points.count; i++) PROMISE(isfinite(points.at[i]));
    else
        PROMISE(*r.error && !strchr(r.error, '\n'));
    r.error[0] = '\0';
    if (mesh_load_triangles(&p, paths[which], scale, &triangles, &r))
        check_triangles(&triangles);
    else
        PROMISE(*r.error && !strchr(r.error, '\n'));
    pool_free(&p);
    unlink(paths[which]);
    return 0;
}
