/* builds: hulls, meshes and height fields are built by threads of their own, at a low priority, so that no content
 * holds the tick. What is built follows from the numbers alone; when it is ready is decided by the clock, so the tick
 * thread makes a recorded command of it (geometry.c).
 *
 * One thread takes what comes, another one only what is short, so that what is short never waits for what is long; both
 * go round the clients that have something waiting. They also free what is large. Without threads (a replay) a build is
 * carried out where it is waited for. All functions are the tick thread's, unless said otherwise. */
#ifndef COLLIDED_SERVICE_BUILDS_H
#define COLLIDED_SERVICE_BUILDS_H

#include "base/array.h"
#include "geom/mesh.h"
#include "soft/soft.h"
#include "wire/wire.h"

#include <stdatomic.h>

/* What a client sent, shared by a geometry and the builds that look at it; it does not change once all has come. */
typedef struct geometry_numbers {
    _Atomic uint32_t refs;
    uint8_t kind; /* WIRE_GEOMETRY_* */
    int64_t hash; /* that its content should have */
    size_t vertex_numbers, index_numbers;
    double *vertices;
    int32_t *indices;
} geometry_numbers;

geometry_numbers *geometry_numbers_create(uint8_t kind, int64_t hash, size_t vertex_numbers, size_t index_numbers);
geometry_numbers *geometry_numbers_keep(geometry_numbers *n); /* any thread, which has it already */
void geometry_numbers_release(geometry_numbers *n);           /* any thread; the last one frees them. NULL: nothing */
bool geometry_numbers_equal(const geometry_numbers *a, const geometry_numbers *b); /* number by number, and the kind */

/* What a build costs, by counts: for prices, limits, and who goes first. */
typedef struct build_cost {
    uint64_t points;    /* of a hull, mesh, or height field */
    uint64_t triangles; /* 0 for a hull */
    uint64_t bytes;     /* of the numbers, and about what is built of them (about 400 bytes a triangle or point) */
    uint64_t units;     /* of work: two a triangle, one a point of a hull; about 5 us each, the worst that may be sent
                           ten times that */
} build_cost;
build_cost build_cost_of(uint8_t kind, size_t vertex_numbers, size_t index_numbers);

typedef struct built { /* what came of it */
    wire_refusal why;  /* WIRE_OK, or why there is nothing of these: */
    hull *hull;
    mesh *mesh;
    soft_mesh *soft;
    int64_t same; /* id of an older geometry that has the very same content: nothing was built; 0: there is none */
} built;

/* Any thread. `out` is the caller's. */
void build_now(const geometry_numbers *n, built *out);

typedef struct older_geometry { /* of the same hash: compared with before anything is built, the first ones first */
    int64_t id;
    geometry_numbers *numbers;
} older_geometry;

typedef struct build build; /* one that is waited for */
typedef struct builds builds;

enum { BUILD_THREADS = 2 }; /* the second one for what is short */

/* Who is told of the builds that begin and end, by the thread of that number that carries them out, with the queue's
 * lock: after builds_destroy has been called nobody is told any more. What the tick thread builds itself is not told.
 */
typedef struct build_watch {
    void (*begins)(void *context, unsigned thread, int64_t client, const char *client_name, const geometry_numbers *n);
    void (*ends)(void *context, unsigned thread);
    void *context;
} build_watch;

/* Wakes the tick thread by the eventfd when something is ready. `threads` false: there are none. */
builds *builds_create(int wake_fd, bool threads);
/* Nothing is begun any more. A build that is under way is waited for for at most a second; then its thread is left to
 * itself, with all that it looks at, and throws away what comes of it. */
void builds_destroy(builds *b);

void builds_report(builds *b, const build_watch *watch); /* from now on */

/* In the name of `client`, which calls itself `client_name` (copied), for geometry `id`. Keeps `n` and those of
 * `older`, of which it takes the array. */
build *builds_add(builds *b, int64_t client, const char *client_name, int64_t id, geometry_numbers *n,
    older_geometry *older, size_t count);
/* Nobody wants it any more: it ends, or is thrown away when it is over. */
void builds_abandon(builds *b, build *of);
bool builds_ready(const builds *b); /* any thread: something is to be taken */
build *builds_take(builds *b);      /* the one that was ready first, of those that nobody waited for; NULL: none is */
int64_t build_of(const build *of);  /* the geometry's id */
/* Waits until it is ready, and calls `alive` (NULL: nothing) ten times a second meanwhile. */
void builds_wait(builds *b, build *of, void (*alive)(void *context), void *context);
void builds_end(builds *b, build *of, built *out); /* it is ready: `out` becomes the caller's, and `of` ends */

/* Frees them, here or by one of the threads, if that may take long. NULLs: nothing. */
void builds_free(builds *b, geometry_numbers *n, hull *h, mesh *m, soft_mesh *f);

typedef struct builds_figures {
    size_t waiting, under_way;
    uint64_t units, bytes; /* of both */
} builds_figures;
builds_figures builds_get_figures(builds *b);

/* For tests: called by the building thread before each build, from now on. NULL: nothing. */
void builds_hold(builds *b, void (*before)(void *context, int64_t id), void *context);

#endif
