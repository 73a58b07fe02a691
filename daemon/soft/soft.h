/* soft: continuous collision of deformable triangle meshes, with themselves, with each other and with rigid meshes: all
 * pairs of a vertex and a face, and of two edges, that meet while each vertex moves along a straight line from its
 * place at the start of a step (t = 0) to its place at the end (t = 1).
 *
 * What is promised. No contact of the numbers that were given is missed: whatever is left out is left out by a proof
 * (boxes rounded outwards, a direction that separates at both ends, a flat star of triangles), and what remains is
 * asked of the elementary tests, which prove as well (elementary.h). What is told beyond the contacts is nearer than
 * rounding can tell, and says so (SOFT_WITHIN). That the vertices move linearly is a convention: certified is the
 * linear way of the numbers given, and a share of it rounded to new numbers is another step. The contacts, their order,
 * all counts of contacts and the safe step are the same for any number of workers, and but for what stands at
 * SOFT_WITHOUT_... with each layer of culling on or off.
 *
 * Units: m, and the step as a share in [0, 1]. All positions are in one frame, whichever; |coordinate| <= SOFT_FAR_M.
 * Threads: a mesh is read only, and may be used by any number of bodies and threads at once. A body and a step belong
 * to one thread at a time; soft_step_run uses the pool that it was given. Ownership: what is given is copied; what is
 * returned belongs to the object that returned it. Errors: what came from outside is checked and answered with a
 * soft_status, and changes nothing; nothing is asserted of it, and no limit is silent. No clock is read: what a step
 * may cost is said, and told, in counts.
 *
 * Method: representative triangles (Curtis, Tamstorf and Manocha 2008): each vertex and edge belongs to one triangle,
 * so that each elementary test is made once, in place of the chromatic decomposition of Govindaraju et al. 2006. Boxes
 * at both ends of the step: two features are apart if one axis separates them at both. Stars: see stars.c. */
#ifndef COLLIDED_SOFT_SOFT_H
#define COLLIDED_SOFT_SOFT_H

#include "base/workers.h"
#include "geom/vec.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#define SOFT_FAR_M 0x1p99 /* coordinates beyond are refused: floats in the boxes have to hold them */

enum {
    SOFT_FEATURES_MAX = 1 << 28, /* vertices, edges, faces, each */
    SOFT_RING_MAX = 8,
    SOFT_BODIES_MAX = 1 << 16, /* of one step */
};

typedef enum soft_status {
    SOFT_OK,           /* done */
    SOFT_MORE,         /* the units of work are used up; the next call goes on */
    SOFT_EMPTY,        /* no vertices or no triangles */
    SOFT_TOO_MANY,     /* vertices, triangles, bodies or pairs beyond the limits above */
    SOFT_OUT_OF_RANGE, /* a triangle names a vertex, or a pair a body, that is not there */
    SOFT_NO_NUMBER,    /* a coordinate is not finite, or beyond SOFT_FAR_M; a length is negative or not finite */
    SOFT_BODY_TWICE,   /* one body stands twice in a step */
    SOFT_OVER_MEMORY,  /* it would take more memory than was allowed */
} soft_status;

const char *soft_status_name(soft_status s);

/* ---- meshes: topology and rest shape, read only ---- */

typedef struct soft_mesh soft_mesh;

typedef struct soft_mesh_def {
    const vec3 *rest; /* m */
    size_t vertex_count;
    const uint32_t (*triangles)[3]; /* (a, b, b) is an edge alone, as of hair and cables; (a, a, a) a vertex alone */
    size_t triangle_count;
    double half_thickness; /* m, unless a body has its own: two surfaces are in contact when nearer than the sum of
                              theirs */
    unsigned ring;         /* features of one body within so many edges of each other are not looked at; 0: only those
                              that share a vertex are not */
    double
        rest_exclusion; /* m: nor those of one body that are nearer than this, or as near, at rest; 0 = no such rule */
    size_t memory_max;  /* bytes that the mesh may take; 0 = no limit */
} soft_mesh_def;

/* NULL, and why in *status, if it cannot be made. Edges are numbered by (lesser, greater) vertex. */
soft_mesh *soft_mesh_create(const soft_mesh_def *def, soft_status *status);
void soft_mesh_destroy(soft_mesh *m); /* after all bodies of it */

size_t soft_mesh_vertex_count(const soft_mesh *m);
size_t soft_mesh_triangle_count(const soft_mesh *m);
size_t soft_mesh_edge_count(const soft_mesh *m);
void soft_mesh_triangle(const soft_mesh *m, uint32_t face, uint32_t corners[3]);
void soft_mesh_edge(const soft_mesh *m, uint32_t edge, uint32_t ends[2]); /* the lesser vertex first */
const vec3 *soft_mesh_rest(const soft_mesh *m);                           /* one a vertex; the mesh's own */
size_t soft_mesh_bytes(const soft_mesh *m);

/* ---- bodies: where the vertices of a mesh are ---- */

typedef struct soft_body soft_body;

soft_body *soft_body_create(const soft_mesh *mesh); /* all at 0 until soft_body_set; the mesh outlives it */
void soft_body_destroy(soft_body *b);
void soft_body_set_thickness(soft_body *b, double half_thickness); /* m, instead of the mesh's */
const soft_mesh *soft_body_mesh(const soft_body *b);
size_t soft_body_bytes(const soft_body *b);

/* The way of a step: as many positions as the mesh has vertices, at its start and its end. Refused as a whole. Not
 * while a step with this body is under way. */
soft_status soft_body_set(soft_body *b, const vec3 *start, const vec3 *end);

/* ---- steps ---- */

typedef struct soft_step soft_step;

typedef enum soft_want {
    SOFT_VERDICTS,  /* who meets: brackets may be wide */
    SOFT_BRACKETS,  /* and when: apart before t_lo, and met by t_hi */
    SOFT_SAFE_STEP, /* nothing but safe_step: contacts are not told, and not looked for beyond the first */
} soft_want;

/* Layers of culling that may be left out, for tests and measurements. They change the time only; but where nothing but
 * the safe step is wanted a shorter way may prove free what is within rounding of a contact on the whole of it, so that
 * the safe step is a little greater with SHORTENING than without. */
enum {
    SOFT_WITHOUT_HIERARCHY = 1, /* each cluster against each */
    SOFT_WITHOUT_BOXES = 2,     /* of features */
    SOFT_WITHOUT_DIRECTIONS = 4,
    SOFT_WITHOUT_STARS = 8,
    SOFT_WITHOUT_SHORTENING = 16, /* of the way, once a contact is known, where the safe step is all that is wanted */
};

typedef struct soft_pair { /* of bodies, by their indices in the step; a body with itself: a == b */
    uint32_t a, b;
} soft_pair;

typedef struct soft_step_def {
    soft_body *const *bodies;
    size_t body_count;
    const soft_pair *pairs;
    size_t pair_count;
    double separation; /* m, beyond the half thicknesses */
    soft_want want;
    size_t contacts_max; /* the first ones, by pair, kind, a, b, are kept; the others are counted (left_out) */
    unsigned without;    /* SOFT_WITHOUT_... */
} soft_step_def;

typedef enum soft_kind {
    SOFT_VERTEX_FACE, /* a vertex of the pair's body a, a face of b */
    SOFT_FACE_VERTEX, /* a face of a, a vertex of b; not of a body with itself */
    SOFT_EDGE_EDGE,   /* of a body with itself: the lesser edge first */
} soft_kind;

typedef enum soft_proof {
    SOFT_CERTAIN,   /* they do meet */
    SOFT_WITHIN,    /* as near as rounding can tell */
    SOFT_UNDECIDED, /* nearer than could be decided; not called free */
} soft_proof;

typedef struct soft_contact {
    uint32_t pair, a, b; /* the pair's index in the step; vertex, edge or face */
    float t_lo, t_hi;    /* rounded outwards */
    uint8_t kind, proof; /* soft_kind, soft_proof */
    uint8_t unused[2];   /* 0 */
} soft_contact;

typedef struct soft_tally {          /* of one pair */
    uint64_t vertex_face, edge_edge; /* contacts, of any proof, whether kept or not */
    uint64_t within, undecided;      /* of these */
    uint64_t left_out;               /* of these, not kept for want of room (contacts_max) */
} soft_tally;

typedef struct soft_work { /* counts, of all calls since soft_step_begin; the same for any number of workers */
    uint64_t node_pairs, cluster_pairs;
    uint64_t candidates;            /* pairs of features whose boxes meet, filtered ones left out */
    uint64_t by_direction, by_star; /* of these, proven free so */
    uint64_t tests, steps;          /* elementary tests; planes marched past in them */
} soft_work;

soft_step *soft_step_create(workers *pool); /* which outlives it; NULL: the caller's thread alone */
void soft_step_destroy(soft_step *s);
size_t soft_step_bytes(const soft_step *s);

/* Takes the bodies' ways and begins; what an earlier step held is gone. If it is refused nothing is held. The bodies
 * stay, and are not set, until the step is done or begins anew. */
soft_status soft_step_begin(soft_step *s, const soft_step_def *def);

/* Goes on for about so many units of work (a unit is some 10 ns; 0 = to the end): SOFT_MORE, or SOFT_OK when all is
 * decided. It stops between portions of some milliseconds, 10 at most where all features meet; where, depends on counts
 * alone. The last one sorts the contacts that are kept: 131,072 of them take some 10 ms. */
soft_status soft_step_run(soft_step *s, uint64_t units);

/* What is known by now; while soft_step_run says SOFT_MORE these are only some, and the safe step is 0. */
const soft_contact *soft_step_contacts(const soft_step *s, size_t *count); /* by pair, kind, a, b, once it is done */
const soft_tally *soft_step_tallies(const soft_step *s);                   /* one a pair */
soft_work soft_step_work(const soft_step *s);
uint64_t soft_step_units(const soft_step *s); /* of work, since it began */

/* Nothing meets before *lo, on the common way of all bodies; 1 and *hi = INFINITY: nothing does. By *hi something has
 * met for certain; 2 = not known. After SOFT_VERDICTS *lo may be less than
 * after the others. */
void soft_step_safe(const soft_step *s, double *lo, double *hi);

/* By vertex of one body: until when none of the faces and edges around it meets anything, while all vertices go their
 * ways together; rounded down; 1 = to the end. Only after SOFT_BRACKETS with every contact kept, and once it is done;
 * else all are 0. If one vertex stops earlier than another that is another way, of which this says nothing. */
void soft_step_vertex_times(const soft_step *s, uint32_t body, float *out);

#endif
