/* check_robot: a robot made ready for checks, and what one thread works with. For check*.c alone. */
#ifndef COLLIDED_ROBOT_CHECK_ROBOT_H
#define COLLIDED_ROBOT_CHECK_ROBOT_H

#include "check.h"
#include "cover.h"

enum { CHECK_CACHES = 1024 };

/* A link that has shapes. Balls are in the turned frame (robot_tree_inner), in fours: places beyond the last ball
 * repeat it. */
typedef struct check_link {
    uint32_t link;
    cover_ball whole;
    uint32_t first_ball, balls; /* in robot.x, y, z, radius; a multiple of four places */
    uint32_t first_shape, shapes;
    double reach;                 /* m: from the link's origin to the farthest point of shapes and balls */
    double extent;                /* m: from the centre of `whole` to the farthest point of shapes and balls */
    double fatness;               /* m: the largest of its balls */
    double slack;                 /* m: what is to be kept beyond the margin for rounding */
    uint32_t first_lever, levers; /* in robot.levers */
} check_link;

/* Two links that are to keep away from each other, and the joints between them. */
typedef struct check_between {
    uint32_t a, b; /* in robot.links: the one with fewer balls is b */
    uint32_t first_joint, joints;
    double slack;
} check_between;

struct check_robot {
    const robot_tree *tree;
    double reach;
    ARRAY(check_shape) shapes; /* link by link */
    ARRAY(uint32_t) given;     /* of each its index among those given */
    ARRAY(check_link) links;
    ARRAY(double) x, y, z, radius;
    ARRAY(check_between) between;
    ARRAY(robot_lever) levers;
};

typedef struct check_cache {
    uint64_t key; /* 0 = empty */
    narrow_cache cache;
} check_cache;

typedef struct check_frame { /* columns of a link's turned frame, and its origin */
    vec3 x, y, z, p;
} check_frame;

struct check_scratch {
    narrow_scratch *narrow;
    check_cache *caches;   /* CHECK_CACHES */
    ARRAY(uint8_t) marked; /* of each definition of the scene: is it in `sources`? */
    ARRAY(uint32_t) sources, found;
    void *edge; /* check_edge.c's */
};

/* Definitions of the scene that a link's balls come near to, each once. One at a time in a scratch. */
typedef struct check_near {
    check_scratch *scratch;
    const scene *scene;
    const uint32_t *sources;
    size_t count;
} check_near;

check_near check_near_begin(check_scratch *scratch, const scene *s);
void check_near_add(check_near *near, unsigned link, vec3 centre, double radius, double within);
void check_near_end(check_near *near);

static inline vec3 frame_point(const check_frame *f, vec3 v)
{
    return vec(f->p.x + (f->x.x * v.x + f->y.x * v.y + f->z.x * v.z),
        f->p.y + (f->x.y * v.x + f->y.y * v.y + f->z.y * v.z), f->p.z + (f->x.z * v.x + f->y.z * v.y + f->z.z * v.z));
}

/* Four balls of a link at a frame: their centres. */
LANES_INLINE void ball_centres(const check_robot *r, const check_frame *f, uint32_t ball, lanes out[3])
{
    const lanes x = *(const lanes_anywhere *)&r->x.at[ball], y = *(const lanes_anywhere *)&r->y.at[ball],
                z = *(const lanes_anywhere *)&r->z.at[ball];
    out[0] = x * f->x.x + y * f->y.x + z * f->z.x + f->p.x;
    out[1] = x * f->x.y + y * f->y.y + z * f->z.y + f->p.y;
    out[2] = x * f->x.z + y * f->y.z + z * f->z.z + f->p.z;
}
LANES_INLINE lanes ball_radii(const check_robot *r, uint32_t ball)
{
    return *(const lanes_anywhere *)&r->radius.at[ball];
}

/* Of one lane of the frames of a link. */
static inline check_frame frame_of_lane(const robot_frames *f, int k)
{
    return (check_frame){vec(f->x[0][k], f->x[1][k], f->x[2][k]), vec(f->y[0][k], f->y[1][k], f->y[2][k]),
        vec(f->z[0][k], f->z[1][k], f->z[2][k]), vec(f->p[0][k], f->p[1][k], f->p[2][k])};
}

/* ---- exact shapes (check_exact.c) ---- */

/* Is the distance of two shapes above `limit`, or not? lo > limit, or hi <= limit, or neither could be told. */
void check_exact_verdict(const shape *a, pose at_a, const shape *b, pose at_b, double limit, uint64_t key,
    check_scratch *scratch, narrow_result *out);
/* To a tolerance, if it is within range. */
void check_exact_distance(const shape *a, pose at_a, const shape *b, pose at_b, double tolerance, double range,
    uint64_t key, check_scratch *scratch, narrow_result *out);
static inline uint64_t check_key(uint32_t shape_a, uint32_t other, bool is_obstacle) /* never 0 */
{
    return 1 + ((uint64_t)other << 12 | shape_a << 1 | is_obstacle);
}

void check_edge_free(void *edge); /* NULL too */

/* The least distance of a configuration: result->lo, hi, and who (check_measure.c). */
void check_measure(const check_robot *r, const scene *s, const check_request *request, const double *coordinates,
    check_scratch *scratch, check_result *result);

#endif
