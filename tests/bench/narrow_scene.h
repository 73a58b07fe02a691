/* narrow_scene: pairs of bodies in one regime: separated, in shallow or in deep contact; independent of each other, or
 * followed along a smooth motion. The same seed gives the same scene. One thread.
 *
 * Sizes are uniform in [0.3, 1] m, orientations and directions uniform, body A anywhere within a metre of the origin.
 * Hulls are of random points on ellipsoids; meshes are bumpy ellipsoids of 5,000 triangles; compounds are of 10 boxes
 * of a third of that size, anywhere within a metre of their origin. B is put where it touches A
 * along a random direction, then: separated by 5 to 50 % of the mean reach, pushed in by 0.1 to 2 % (shallow), or
 * pulled to 10 to 60 % of the way to A (deep). A track turns B by 0.01 rad and its direction by 0.005 rad a frame, at
 * the same gap or push. */
#ifndef COLLIDED_TESTS_BENCH_NARROW_SCENE_H
#define COLLIDED_TESTS_BENCH_NARROW_SCENE_H

#include "geom/shape.h"
#include "narrow_peer.h"

typedef struct narrow_pair {
    const char *name;
    narrow_kind a, b;
    size_t hull_points;
    bool curved; /* iterative, not a polytope or a closed form: right is 1e-6, not 1e-9 */
} narrow_pair;

extern const narrow_pair
    narrow_pairs[]; /* those with meshes come last; these and compounds have no regime but separated */
extern const size_t narrow_pair_count;
extern const char *const narrow_regime_names[REGIME_COUNT];

typedef struct narrow_scene {
    narrow_row row;
    size_t count;
    narrow_item *items;
    narrow_body *bodies;
    size_t body_count;
} narrow_scene;

narrow_scene narrow_scene_create(const narrow_pair *pair, narrow_regime regime, bool coherent, size_t count);

/* What makes a scene extreme: the plain one is {1, 0, 1, 1, NAN, NAN}. */
typedef struct narrow_extreme {
    double scale;    /* all lengths times this */
    double distance; /* m, at last: both bodies this far from the origin, by rounded positions */
    double ratio;    /* B's sizes divided by this; gaps and pushes are then relative to the smaller reach */
    double aspect;   /* thin: one body in two flat, the others needles, by this */
    double amount;   /* gap (separated) or push (shallow) in mean reaches; NAN = as the regime has it */
    double tilt;     /* rad: faces, caps or axes parallel but for this; NAN = any orientation */
} narrow_extreme;

/* Independent configurations, tracks of one. */
narrow_scene narrow_scene_create_extreme(
    const narrow_pair *pair, narrow_regime regime, size_t count, const narrow_extreme *extreme);
void narrow_scene_destroy(narrow_scene *s);

shape narrow_scene_shape(const narrow_body *body);
pose narrow_scene_pose(const narrow_place *at);

#endif
