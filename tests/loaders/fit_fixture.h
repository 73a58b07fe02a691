/* fit_fixture: shapes of the loaders as the engine knows them, points on them, and distances of points from them. */
#ifndef COLLIDED_TESTS_FIT_FIXTURE_H
#define COLLIDED_TESTS_FIT_FIXTURE_H

#include "fixture.h"

#include "base/prng.h"
#include "loaders/fit/fit_robot.h"
#include "narrow/narrow.h"

typedef struct solid_set { /* the shapes of one link */
    shape at[64];
    pose local[64];
    hull *hulls[64];
    mesh *meshes[64];
    size_t count;
} solid_set;

size_t fit_count(size_t nightly); /* a fiftieth of it in CI, a thousandth with COLLIDED_BRIEF */
double drawn(prng *r, double lo, double hi);
vec3 drawn_direction(prng *r);

void set_make(solid_set *s, const load_shape *shapes, size_t count);
void set_free(solid_set *s);

/* The upper bound of the least signed distance of the point from any of them; and the lower one. */
double set_away(const solid_set *s, vec3 point);
double set_away_at_least(const solid_set *s, vec3 point);

/* A point on the surface of shape i: that nearest to a point drawn around it. */
vec3 set_surface_point(const solid_set *s, size_t i, prng *r);

/* Least certified distance of two sets, posed. */
double set_distance(const solid_set *a, pose pose_a, const solid_set *b, pose pose_b);

pose pose_from(const collided_pose *p);

/* The project's own arm, with its SRDF; meshes as solids. */
void fixture_arm(fixture *f, robot *out);
/* Of the shared panda; false if it is not there. */
bool fixture_panda_solid(fixture *f, robot *out);

#endif
