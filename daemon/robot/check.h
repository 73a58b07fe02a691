/* check: is a robot free of a scene, and of itself, in many configurations, and along straight lines between them?
 *
 * What is promised. FREE: no point of a link is within `margin_m` of an obstacle that it is to keep away from, nor of a
 * link that it is to keep away from, in the configuration, or anywhere along the edge: proven. MEETS: some are within
 * it, somewhere: proven by exact shapes. UNDECIDED: neither could be proven: the distance is the margin but for
 * rounding and what obstacles are widened by (scene.h), or the limits below were reached. Balls that contain the links
 * decide most, and lie in neither direction: what they leave open is asked of narrow_query.
 *
 * Along an edge the coordinates move linearly with t from 0 to 1: those of continuous joints as given, not by the
 * shorter way. Method: of a ball with clearances d0 and d1 at two times, whose centre moves by the chord c and bends by
 * no more than a (robot_tree_bend), the stretch of length h between them is free if d0 + d1 > |c| + a h^2 / 4:
 * distances from a set change by no more than the point moves, and the centre is within a h^2 / 8 of its chord. What is
 * not proven so is halved, the earliest stretches no sooner than others. (After Quinlan 1994, and Schwarzer, Saha and
 * Latombe 2005, whose bound has the sum of all joints' speeds in place of the chord.)
 *
 * Threads: a robot and a scene are read only; each thread has a scratch of its own. The answer to an item follows from
 * the item, the robot and the scene alone. Nothing reads a clock. */
#ifndef COLLIDED_ROBOT_CHECK_H
#define COLLIDED_ROBOT_CHECK_H

#include "narrow/narrow.h"
#include "scene.h"
#include "tree.h"

enum {
    CHECK_SHAPES_MAX = 1024,  /* of a robot */
    CHECK_PAIRS_MAX = 1024,   /* of links that are to keep away from each other */
    CHECK_SAMPLES_MAX = 1024, /* configurations that one edge is proven by, at most */
    CHECK_EFFORT_MAX = 8000,  /* questions to the narrow phase about one edge, at most; beyond, it is undecided. One
                                 about a mesh or a compound counts as CHECK_DEAR */
    CHECK_DEAR = 100
};

typedef struct check_shape {
    uint32_t link;
    const shape *shape; /* borrowed: outlives the robot */
    pose pose;          /* in the link's frame */
} check_shape;

typedef struct check_pair {
    uint32_t a, b; /* links, a < b */
} check_pair;

typedef enum check_fault {
    CHECK_FINE,
    CHECK_TOO_MANY_SHAPES,
    CHECK_TOO_MANY_PAIRS,
    CHECK_NO_SUCH_LINK,
    CHECK_ENDLESS_SHAPE, /* a half-space moves with a link */
    CHECK_TOO_LARGE      /* a shape reaches beyond ROBOT_SIZE_MAX */
} check_fault;

typedef struct check_robot check_robot;

/* Borrows the tree. NULL, and why in *fault, if it cannot be made. */
check_robot *check_robot_create(const robot_tree *tree, const check_shape *shapes, size_t shape_count,
    const check_pair *pairs, size_t pair_count, check_fault *fault);
void check_robot_destroy(check_robot *r);
/* m: no point of it is ever farther from the base's origin: what scene_create asks for, but for the margin. */
double check_robot_reach(const check_robot *r);

typedef enum check_verdict { CHECK_FREE, CHECK_MEETS, CHECK_UNDECIDED, CHECK_NOT_DONE } check_verdict;

enum { CHECK_NOBODY = UINT32_MAX };

typedef struct check_request {
    double margin_m;     /* >= 0 */
    double resolution_m; /* an edge's stretch in which nothing moves farther is not halved again; > 0 */
    bool find_first;     /* of an edge that meets: narrow down where it does so first, to `resolution_m` */
    bool measure;        /* of a state: its least distance, too */
    double tolerance_m;  /* to which it is measured */
} check_request;

check_request check_request_default(void);

typedef struct check_result {
    check_verdict verdict;
    double first_lo, first_hi; /* of an edge: free before first_lo, proven; meets at first_hi (MEETS), else 1 */
    double lo, hi;             /* m, measured; a lower bound of -INFINITY and an upper one of INFINITY otherwise */
    uint32_t shape_a;          /* who meets or was last in doubt: a shape of the robot, or CHECK_NOBODY */
    uint32_t shape_b;          /* another one, or CHECK_NOBODY */
    uint32_t obstacle;         /* a definition of the scene, or CHECK_NOBODY */
    uint32_t samples, queries; /* configurations, and questions to the narrow phase */
} check_result;

typedef struct check_scratch check_scratch;
check_scratch *check_scratch_create(const check_robot *r);
void check_scratch_destroy(check_scratch *s);

/* `coordinates`: count times robot_tree_coordinates numbers. */
void check_states(const check_robot *r, const scene *s, const check_request *request, const double *coordinates,
    size_t count, check_scratch *scratch, check_result *results);

/* From one configuration to another. With `times` (room for CHECK_SAMPLES_MAX), the times of the configurations that
 * the proof rests on, ascending, and how many in *time_count. */
void check_edge(const check_robot *r, const scene *s, const check_request *request, const double *from,
    const double *to, check_scratch *scratch, check_result *result, double *times, size_t *time_count);

#endif
