/* impact_peer: what the race of continuous collision asks of each contender. One thread; a contender keeps nothing
 * outside of what it created.
 *
 * A scene is a list of items: two bodies that move from time 0 to a span, each along a line and about its origin, at
 * constant speeds. Before the clock starts a contender turns all of them into its own types; timed is what its user
 * does for each pair. Units: m, s, m/s, rad/s; world frame. */
#ifndef COLLIDED_TESTS_BENCH_IMPACT_PEER_H
#define COLLIDED_TESTS_BENCH_IMPACT_PEER_H

#include "narrow_peer.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct impact_motion {
    narrow_place start;
    double linear[3], angular[3];
} impact_motion;

typedef struct impact_item {
    const narrow_body *a, *b;
    impact_motion move_a, move_b;
    double span;
} impact_item;

/* Where a body is at a time. */
narrow_place impact_place(const impact_motion *m, double time);

/* Two poses hide whole turns: the least number of equal pieces of the span in each of which neither body turns by more
 * than that angle. */
size_t impact_pieces(const impact_item *item, double angle);

typedef struct impact_answer {
    bool failed; /* no answer, by its own word */
    bool hit;
    double time; /* s; of a hit: when */
} impact_answer;

typedef struct impact_peer {
    const char *name, *settings;
    bool ours;
    bool (*takes)(narrow_kind a, narrow_kind b);
    void *(*create)(const impact_item *items, size_t count);
    impact_answer (*ask)(void *self, size_t item); /* the time of this is the figure */
    void (*destroy)(void *self);
    const char *entry; /* the functions that are timed */
} impact_peer;

/* Ours comes first; which others are there is CMake's choice (impact_all.c, impact_alone.c). */
extern const impact_peer *const impact_contenders[];
extern const size_t impact_contender_count;
extern const impact_peer impact_ours, impact_fcl, impact_bullet;

#ifdef __cplusplus
}
#endif

#endif
