/* impact_scene: the scenes of impact_simulator, and what each comes to. Units: m, kg, s. One thread. */
#ifndef COLLIDED_EXAMPLES_IMPACT_SCENE_H
#define COLLIDED_EXAMPLES_IMPACT_SCENE_H

#include "lockstep.h"

#include <stdint.h>
#include <stdio.h>

enum { TRACK_POINTS = 65536 };
typedef struct track_point {
    int body;
    double x, y;
} track_point;

typedef struct scene_result {
    double time_s, first_j, last_j; /* energy at the beginning and at the end */
    double energy_gain;             /* the worst of all impacts or steps, as a share of first_j ... */
    double energy_change;           /* ... and of loss or gain */
    double momentum_change;         /* of impacts without a fixed body, as a share of the momentum of what met */
    double energy_bound, momentum_bound, depth_bound_m;
    bool elastic, at_rest, good;
    long advances, impacts;
    uint64_t hash;       /* FNV-1a over all states at all steps */
    track_point *tracks; /* NULL: nobody wants them; of bodies that move, at each advance */
    size_t track_count;
} scene_result;

/* Each creates its bodies, runs for at most span_s or until all rest, and fills the result. `real`: with losses. */
void scene_billiards(lockstep *l, double span_s, bool real, scene_result *r);
void scene_stack(lockstep *l, double span_s, scene_result *r);

/* What they share: the state after an advance goes into the hash and the tracks; an impact of the given points, with
 * what it does to energy and momentum noted. */
void scene_note_state(scene_result *r, const lockstep *l);
void scene_collide(scene_result *r, lockstep *l, touch *points, size_t count);
bool scene_holds(const scene_result *r, const lockstep *l); /* all bounds */

/* The tracks of balls on their table as an SVG picture. */
void scene_draw(const scene_result *r, const lockstep *l, FILE *out);

/* The table: inner half lengths, and the balls' radius. */
extern const double TABLE_X, TABLE_Y, BALL_RADIUS;

#endif
