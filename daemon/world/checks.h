/* checks: configurations and motions of a robot whose links are bodies, tried out against the world as the last tick
 * left it. Nothing is moved, and no subscription hears of it. Tick thread, between ticks.
 *
 * What counts as an obstacle: each body that is no link of the robot and that the filters of a link's body let it meet,
 * as it stands. Rules, groups and masks count between links, too. Stale, held and soft bodies may be anywhere: as long
 * as there is one that a link is to keep away from, nothing is free, and what is not found to meet is undecided. */
#ifndef COLLIDED_WORLD_CHECKS_H
#define COLLIDED_WORLD_CHECKS_H

#include "robot/check.h"
#include "world.h"

typedef struct world_check_def {
    const robot_joint *joints;
    const uint32_t *bodies; /* of each link; WORLD_NONE = it has none */
    size_t joint_count;
    pose base; /* of the robot's base in the world; |q| = 1 but for rounding */
    check_request request;
    bool edges;                /* each item is two configurations, from one to the other; otherwise one */
    const double *coordinates; /* item by item */
    size_t items;
    size_t others_pending; /* bodies that are not in the world yet, since their geometry is being built */
} world_check_def;

typedef struct world_check_item {
    check_verdict verdict;
    double first_lo, first_hi, lo, hi; /* as in check_result */
    uint32_t body_a, body_b;           /* WORLD_NONE = nobody */
} world_check_item;

/* Asked between items: may it go on? */
typedef struct world_check_patience {
    bool (*go_on)(void *context);
    void *context;
} world_check_patience;

/* Writes an item each; those that there was no time for are CHECK_NOT_DONE. False, and why in `text`, if the robot or a
 * configuration is refused; or true and, if bodies are unknown, that in `text`. */
bool world_check(world *w, const world_check_def *def, const world_check_patience *patience, world_check_item *out,
    char *text, size_t text_size);

#endif
