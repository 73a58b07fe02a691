/* narrow_peer: what the race of narrow phases asks of each contender. One thread; a contender keeps nothing outside of
 * what it created.
 *
 * A scene is a list of items: two bodies at two world poses. Before the clock starts a contender turns all of them into
 * its own types; timed is what its user does for each query. All lengths in metres, signed distance: positive = gap. */
#ifndef COLLIDED_TESTS_BENCH_NARROW_PEER_H
#define COLLIDED_TESTS_BENCH_NARROW_PEER_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

typedef enum narrow_kind { /* axis of revolution = z */
    KIND_SPHERE,           /* radius */
    KIND_CAPSULE,          /* radius; half[2] of its axis */
    KIND_BOX,
    KIND_CYLINDER, /* half[0] = half[1] = its radius */
    KIND_CONE,     /* apex at +half[2], base of radius half[0] at -half[2] */
    KIND_ELLIPSOID,
    KIND_HULL,
    KIND_MESH,     /* a solid */
    KIND_COMPOUND, /* of boxes */
    KIND_COUNT
} narrow_kind;

typedef struct narrow_polytope {
    size_t vertex_count, face_count;
    double *vertices;        /* x, y, z */
    double *planes;          /* of a hull: unit normal x, y, z, offset */
    uint32_t *face_first;    /* face_count + 1 entries into face_vertices */
    uint32_t *face_vertices; /* counter-clockwise seen from outside */
    const void *built;       /* struct hull or struct mesh, of which all this is a copy */
} narrow_polytope;

struct narrow_parts;
typedef struct narrow_body {
    narrow_kind kind;
    double half[3], radius;
    const narrow_polytope *polytope;  /* KIND_HULL, KIND_MESH */
    const struct narrow_parts *parts; /* KIND_COMPOUND */
} narrow_body;

typedef struct narrow_place {
    double p[3], q[4]; /* w, x, y, z */
} narrow_place;

enum { NARROW_PARTS = 10 };
typedef struct narrow_parts {
    narrow_body body[NARROW_PARTS];
    narrow_place at[NARROW_PARTS]; /* in the compound */
    const void *built;             /* struct compound */
} narrow_parts;

typedef struct narrow_item {
    const narrow_body *a, *b;
    narrow_place at_a, at_b;
    bool begins; /* nothing that is remembered of the item before is of use here */
} narrow_item;

typedef enum narrow_regime { REGIME_SEPARATED, REGIME_SHALLOW, REGIME_DEEP, REGIME_COUNT } narrow_regime;

typedef struct narrow_row {
    narrow_kind a, b;
    narrow_regime regime;
    bool coherent;
    double tolerance; /* m: what the issue calls right for this pair, in metres */
    double own;       /* of a sweep: the contender's own tolerance in place of that of its settings; 0 = that */
} narrow_row;

typedef struct narrow_answer {
    bool failed;     /* no answer, by its own word */
    bool overlap;    /* its verdict */
    bool measured;   /* `distance` is its signed distance */
    bool bounded;    /* it claims that the truth is in [lo, hi] */
    double distance; /* m */
    double lo, hi;
} narrow_answer;

typedef struct narrow_peer {
    const char *name, *settings;
    bool ours;
    bool (*takes)(const narrow_row *row);
    void *(*create)(const narrow_item *items, size_t count, const narrow_row *row);
    void (*query)(void *self, size_t first, size_t count, narrow_answer *out); /* the time of this is the figure */
    void (*destroy)(void *self);
    const char *entry; /* the functions that are timed */
} narrow_peer;

/* Ours come first; which others are there is CMake's choice (narrow_all.c, narrow_alone.c). */
extern const narrow_peer *const narrow_contenders[];
extern const size_t narrow_contender_count;
extern const narrow_peer narrow_ours, narrow_ours_finest, narrow_ours_cached, narrow_ours_again;
extern const narrow_peer narrow_dial, narrow_dial_world, narrow_dial_boxes, narrow_dial_bounds, narrow_dial_cascade,
    narrow_dial_verdict; /* for sweeps */
extern const narrow_peer narrow_loop;
extern const narrow_peer narrow_verify,
    narrow_verify_prepared; /* check answers that they are given: no goal, no ratio */
extern const narrow_peer narrow_ccd_gjk, narrow_ccd_gjk_fine, narrow_ccd_mpr;
extern const narrow_peer narrow_fcl, narrow_fcl_fine, narrow_fcl_collide, narrow_fcl_indep, narrow_fcl_indep_collide;
extern const narrow_peer narrow_bullet_pair, narrow_bullet_epa, narrow_bullet_box;
extern const narrow_peer narrow_ode;

#ifdef __cplusplus
}
#endif

#endif
