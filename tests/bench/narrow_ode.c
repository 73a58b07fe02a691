/* narrow_ode: ODE's colliders, in double precision: contacts only, so of separated pairs it tells just that they are.
 * Each item has two geoms of its own, at their poses: what dCollide then takes is the figure. */
#include "narrow_peer.h"

#include <ode/ode.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <unistd.h>

enum { CONTACTS_MAX = 16 };

typedef struct ode_hull { /* what a convex geom borrows */
    dReal *planes, *points;
    unsigned *polygons;
} ode_hull;

typedef struct ode_self {
    dGeomID *geoms; /* two an item */
    ode_hull *hulls;
    size_t count;
    bool apart;
} ode_self;

static void *allocate(size_t count, size_t size)
{
    void *p = calloc(count, size);
    if (!p) abort();
    return p;
}

/* By itself it writes to stdout, among the figures. */
static void say(int number, const char *format, va_list arguments)
{
    fprintf(stderr, "ode, message %d: ", number);
    vfprintf(stderr, format, arguments); /* NOLINT(clang-diagnostic-format-nonliteral): ODE's own */
    fputc('\n', stderr);
}

static void start_ode(void)
{
    static bool started;
    if (!started && (!dInitODE2(0) || !dAllocateODEDataForThread(dAllocateMaskAll))) abort();
    dSetMessageHandler(say);
    started = true;
}

/* Of hulls that do not hold their origin it says so past its handler, on stdout: that goes to stderr, too. */
static dGeomID create_convex(const narrow_polytope *p, const ode_hull *own)
{
    fflush(stdout);
    int kept = dup(STDOUT_FILENO);
    if (kept < 0 || dup2(STDERR_FILENO, STDOUT_FILENO) < 0) abort();
    dGeomID g =
        dCreateConvex(0, own->planes, (unsigned)p->face_count, own->points, (unsigned)p->vertex_count, own->polygons);
    fflush(stdout);
    if (dup2(kept, STDOUT_FILENO) < 0) abort();
    close(kept);
    return g;
}

static dGeomID hull_geom(const narrow_polytope *p, ode_hull *own)
{
    size_t corners = p->face_first[p->face_count], at = 0;
    own->planes = allocate(4 * p->face_count, sizeof *own->planes);
    own->points = allocate(3 * p->vertex_count, sizeof *own->points);
    own->polygons = allocate(corners + p->face_count, sizeof *own->polygons);
    for (size_t i = 0; i < 4 * p->face_count; i++) own->planes[i] = p->planes[i];
    for (size_t i = 0; i < 3 * p->vertex_count; i++) own->points[i] = p->vertices[i];
    for (size_t f = 0; f < p->face_count; f++) {
        own->polygons[at++] = p->face_first[f + 1] - p->face_first[f];
        for (uint32_t i = p->face_first[f]; i < p->face_first[f + 1]; i++) own->polygons[at++] = p->face_vertices[i];
    }
    return create_convex(p, own);
}

static dGeomID geom_of(const narrow_body *b, ode_hull *own)
{
    const double *h = b->half;
    switch (b->kind) {
    case KIND_SPHERE:
        return dCreateSphere(0, b->radius);
    case KIND_CAPSULE:
        return dCreateCapsule(0, b->radius, 2 * h[2]);
    case KIND_BOX:
        return dCreateBox(0, 2 * h[0], 2 * h[1], 2 * h[2]);
    case KIND_CYLINDER:
        return dCreateCylinder(0, h[0], 2 * h[2]);
    default:
        return hull_geom(b->polytope, own);
    }
}

static void put(dGeomID g, const narrow_place *at)
{
    dReal aabb[6];
    dGeomSetPosition(g, at->p[0], at->p[1], at->p[2]);
    dGeomSetQuaternion(g, at->q);
    dGeomGetAABB(g, aabb); /* computed once, before the clock starts */
}

static void *create(const narrow_item *items, size_t count, const narrow_row *row)
{
    start_ode();
    ode_self *s = allocate(1, sizeof *s);
    *s = (ode_self){allocate(2 * count, sizeof *s->geoms), allocate(2 * count, sizeof *s->hulls), count,
        row->regime == REGIME_SEPARATED};
    for (size_t i = 0; i < count; i++) {
        s->geoms[2 * i] = geom_of(items[i].a, &s->hulls[2 * i]);
        s->geoms[2 * i + 1] = geom_of(items[i].b, &s->hulls[2 * i + 1]);
        put(s->geoms[2 * i], &items[i].at_a);
        put(s->geoms[2 * i + 1], &items[i].at_b);
    }
    return s;
}

static void destroy(void *self)
{
    ode_self *s = self;
    for (size_t i = 0; i < 2 * s->count; i++) {
        dGeomDestroy(s->geoms[i]);
        free(s->hulls[i].planes);
        free(s->hulls[i].points);
        free(s->hulls[i].polygons);
    }
    free(s->geoms);
    free(s->hulls);
    free(s);
}

static void query(void *self, size_t first, size_t count, narrow_answer *out)
{
    const ode_self *s = self;
    for (size_t i = 0; i < count; i++) {
        dContactGeom contacts[CONTACTS_MAX];
        const dGeomID *pair = &s->geoms[2 * (first + i)];
        int found = dCollide(pair[0], pair[1], CONTACTS_MAX, contacts, sizeof *contacts);
        double depth = 0;
        for (int k = 0; k < found; k++) depth = contacts[k].depth > depth ? contacts[k].depth : depth;
        out[i] = (narrow_answer){.overlap = found > 0, .measured = found > 0, .distance = -depth};
    }
}

/* Two cylinders have no collider in the package's build; cones and ellipsoids ODE does not know. */
static bool takes(const narrow_row *row)
{
    bool both_cylinders = row->a == KIND_CYLINDER && row->b == KIND_CYLINDER;
    bool unknown = row->a == KIND_CONE || row->b == KIND_CONE || row->a == KIND_ELLIPSOID || row->b == KIND_ELLIPSOID;
    return !both_cylinders && !unknown && row->a != KIND_MESH && row->b != KIND_MESH && row->b != KIND_COMPOUND;
}

const narrow_peer narrow_ode = {"ode",
    "dCollide, double, 16 contacts, the deepest; its convex pairs and cylinders "
    "by libccd's MPR",
    false, takes, create, query, destroy, "dCollide"};
