/* Any numbers as points, and as triangles over them: a hull and a mesh are refused, or what they are is consistent. */
#include "fuzz.h"
#include "take.h"

#include "geom/hull.h"
#include "geom/mesh.h"

enum { POINTS_MAX = 64, TRIANGLES_MAX = 96 };

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    static double points[3 * POINTS_MAX];
    static int32_t corners[3 * TRIANGLES_MAX];
    taking t = {data, size, 1};
    size_t count = take_byte(&t) % (POINTS_MAX + 1), triangles = take_byte(&t) % (TRIANGLES_MAX + 1);
    unsigned flags = take_byte(&t) % 2 ? HULL_ALLOW_FLAT : 0;
    for (size_t i = 0; i < 3 * triangles; i++) corners[i] = (int8_t)take_byte(&t);
    for (size_t i = 0; i < 3 * count; i++) points[i] = take_number(&t);
    hull *h = NULL;
    if (hull_build(points, count, flags, &h) == HULL_OK) {
        const char *why = hull_validate(h);
        if (why) fprintf(stderr, "hull: %s\n", why);
        PROMISE(!why);
        hull_destroy(h);
    }
    mesh *m = NULL;
    if (mesh_build(points, count, corners, triangles, &m) == MESH_OK) {
        char text[512];
        const char *why = mesh_validate(m);
        if (!why) why = hull_validate(m->hull);
        if (why) fprintf(stderr, "mesh: %s\n", why);
        PROMISE(!why);
        mesh_describe(m, text, sizeof text);
        mesh_inside(m, (vec3){points[0], points[1], points[2]});
        mesh_destroy(m);
    }
    return 0;
}
