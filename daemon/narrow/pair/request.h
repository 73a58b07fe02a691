/* request: the types of what is asked of the narrow phase, of its answer, and of what a pair remembers. All other files
 * of narrow/ may include this header, and it includes none of them. */
#ifndef COLLIDED_NARROW_PAIR_REQUEST_H
#define COLLIDED_NARROW_PAIR_REQUEST_H

#include "geom/hull.h"
#include "geom/shape.h"

typedef enum narrow_fact {
    NARROW_VERDICT = 1,  /* are they closer than `threshold`? stop as soon as the interval says */
    NARROW_DISTANCE = 2, /* hi - lo <= tolerance (gap or depth), or lo > range */
    NARROW_MANIFOLD = 4  /* contact points unless lo > threshold (shapes are closed: touching is contact) */
} narrow_fact;

typedef enum narrow_engine {
    NARROW_ENGINE_AUTO, /* closed forms, then GJK with duality gap, then EPA */
    NARROW_ENGINE_GJK,  /* the general path only, for every pair */
    NARROW_ENGINE_CCD,  /* libccd GJK proposes, our certificate decides; ours takes over where it fails (counted) */
    NARROW_ENGINE_MPR   /* libccd MPR for overlap proposes, as above */
    /* libccd is not asked about half-spaces and meshes: result.method says who answered */
} narrow_engine;

typedef struct narrow_request {
    unsigned facts;   /* of narrow_fact */
    double tolerance; /* m, asked width of [lo, hi]; 0 = as narrow as floating point gives. Beside a verdict the
                         interval is refined until it also decides, or rounding does not let it */
    double range;     /* m; beyond it a lower bound is enough. INFINITY = always measure */
    double threshold; /* m; for NARROW_VERDICT and NARROW_MANIFOLD */
    narrow_engine engine;
    bool brief; /* for the depth of a mesh the first bracket is enough, even if it is wider than `tolerance` */
} narrow_request;

enum { MANIFOLD_POINTS_MAX = 4 };

typedef struct manifold_point {
    vec3 point;       /* midway between the surfaces, in A's frame */
    double distance;  /* m, signed, along the axis; negative = depth there */
    uint64_t feature; /* stable id: of A in the high half, of B in the low half (manifold.h) */
} manifold_point;

typedef struct manifold {
    uint32_t count; /* points[count] and those behind it are not written */
    manifold_point points[MANIFOLD_POINTS_MAX];
} manifold;

typedef enum narrow_status {
    NARROW_CERTAIN, /* the interval is as narrow as asked, or decides what was asked */
    NARROW_WIDE,    /* the interval contains the truth but is wider than asked: arithmetic, iterations or the effort of
                       the query (effort.h) did not suffice, or the request was brief; or the effort ended before all
                       parts of a mesh or compound were searched for contact points */
} narrow_status;

typedef enum narrow_method { /* which method gave the answer; metrics count them */
    NARROW_BY_CLOSED_FORM,
    NARROW_BY_GJK,
    NARROW_BY_EPA,
    NARROW_BY_SAT,
    NARROW_BY_CCD,
    NARROW_BY_MPR,
    NARROW_METHOD_COUNT
} narrow_method;

typedef struct narrow_result {
    double lo, hi;         /* m; lo <= signed distance <= hi, of the shapes at the poses given, each quaternion divided
                              by its norm; of hulls, of all the points they were made of. By doubles: 16 ulp (u = 2^-53)
                              of the reaches plus the distance on both sides; where that is too wide for the request,
                              `refined`; beside a mesh or a half-space 32 ulp, of hulls that overlap, or a hull and a
                              box, up to 48. By formulas: of a ball and a box 24 of the reaches and 28 of the gap; of
                              two capsules 20 of the reaches; of a capsule whose core is
                              in a box 20, else 2 more of the gap; by the first of two boxes 24, that overlap 48, of
                              verdicts of ellipsoids 32. Beside a compound 64 and what its parts have.
                              Touching shapes give lo <= 0 <= hi. Two half-spaces that no
                              translation separates: both -INFINITY; those that are back to back but for
                              4 u count as parallel, and have the distance of the planes. Of shapes with a deviation: of what
                              they stand for, which need not be convex, so that hi is at least the sum of
                              the deviations */
    vec3 axis;             /* unit (but for 16 u), from A towards B. It proves lo: min over B of axis.x - max over A of
                              axis.x >= lo. Moving B along it by -lo (and rounding) separates. Of a mesh or a compound,
                              which are not convex, it proves no positive lo: every triangle or child was looked at or
                              ruled out; and of their overlap only that that move separates them */
    vec3 point_a, point_b; /* on the surfaces (radius included). Separated: |point_b - point_a| proves hi (of a verdict
                              alone, where they touch but for rounding, but for that). Overlapping: the deepest points
                              along axis */
    manifold manifold;     /* with NARROW_MANIFOLD */
    narrow_status status;
    narrow_method method;
    uint32_t iterations;
    uint32_t peer_failures; /* libccd's, when it was the engine */
    bool refined;           /* the bounds were computed again in double-double, because doubles did not suffice */
} narrow_result;

/* The features at which two shapes were nearest, which the next query tries first. A hull's are vertices, ascending. A
 * box has for each axis the side on which the nearest point lies, or that it lies between the sides. A body of
 * revolution has the end, or that the point lies between the ends, and whether it lies inside that end's rim. Counts of
 * 0 mean that no features are known. */
typedef struct narrow_features {
    uint16_t a[3], b[3];
    uint8_t count_a, count_b;
    bool deep; /* of hulls that overlap: the facet of B - A that is nearest to the origin */
} narrow_features;

enum { SHELL_POINTS_MAX = 64, SHELL_FACETS_MAX = 128 };

/* The surface that proved the depth of two overlapping hulls, or of a box and a hull: points of B - A, as vertices of
 * both, and closed triangles over them. narrow_query writes it, and each pair has its own; zeroed means empty. */
typedef struct narrow_shell {
    uint8_t point_count, facet_count;
    uint16_t vertex_a[SHELL_POINTS_MAX], vertex_b[SHELL_POINTS_MAX];
    uint8_t corner[3][SHELL_FACETS_MAX]; /* counter-clockwise from outside */
} narrow_shell;

/* What a pair remembers; zeroed means empty. The axis, the pose and the lower bound are for narrow_motion_bound,
 * narrow_separation and narrow_apart, which prove separation with them; narrow_query writes them. The hints belong to
 * the latter two. narrow_query begins with the triangles, the features and the surface. Triangles and the axis only say
 * where it begins. Features and the surface are proven anew, and then give the bits that a search without them gives
 * (features.h, curved.h): so no answer depends on a cache. */
typedef struct narrow_cache {
    vec3 axis;                       /* in A's frame, unit; zero = none */
    pose b_in_a;                     /* where `lower` was certified */
    double lower;                    /* certified lower bound then */
    uint32_t hint_a, hint_b;         /* support vertices to start from */
    uint32_t triangle_a, triangle_b; /* 1 + those of two meshes that were the nearest; 0 = none, or not a mesh */
    narrow_features nearest;
    narrow_shell
        *shell; /* the caller's memory, for the depths of hulls; NULL: these are found from nothing each time */
} narrow_cache;

/* The caller's memory for searches, one for each thread. */
typedef struct narrow_scratch narrow_scratch;

/* The function that a search over parts of a shape calls for two parts: narrow_query, limited to the effort that the
 * query about the whole shapes has left. */
typedef void narrow_ask(const shape *a, const shape *b, const pose *b_in_a, const narrow_request *request,
    narrow_scratch *scratch, narrow_result *result);

#endif
