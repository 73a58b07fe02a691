/* broad_peer: what the race of broad phases asks of each contender. One thread; a contender keeps nothing outside its
 * world. Ids are dense, 0..count-1; all bodies are there from the beginning, and may move at any tick. */
#ifndef COLLIDED_TESTS_BENCH_BROAD_PEER_H
#define COLLIDED_TESTS_BENCH_BROAD_PEER_H

#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/* The tight box. All numbers are multiples of 2^-14 m below 1024 m, and so exact in floats, too. */
typedef struct peer_body {
    double lo[3], hi[3];
    double step[3]; /* m: as it moved in the last tick */
    double reach;   /* m: of the shape from its centre */
} peer_body;

typedef void peer_visit(void *context, uint32_t a, uint32_t b);

typedef struct peer {
    const char *name;
    size_t most; /* bodies that it can hold, or is raced with; 0 = any number */
    /* With all pairs found; `side`: centres are in 0..side on each axis, m. */
    void *(*create)(const peer_body *bodies, size_t count, double side);
    void (*destroy)(void *world);
    /* bodies[i] is the new state of body ids[i]; returns the number of pairs that it has afterwards. All that a user
     * must do each tick, and nothing else: the time of this call is the figure. Ids ascend. */
    size_t (*step)(void *world, const uint32_t *ids, const peer_body *bodies, size_t count);
    void (*pairs)(void *world, peer_visit *visit, void *context); /* as of the last step, each once */
    const char *entry;                                            /* the functions that are timed */
} peer;

/* Ours come first; which others are there is CMake's choice (contenders_all.c, contenders_ours.c). */
extern const peer *const broad_contenders[];
extern const size_t broad_contender_count, broad_ours_count;
extern const peer peer_ours;                                          /* as the world uses it */
extern const peer peer_ours_tree, peer_ours_sweep3, peer_ours_sweep1; /* as it can be configured */
extern const peer peer_ours_empty; /* refuses every pair: what the bodies alone cost */
extern const peer peer_bullet_dbvt, peer_bullet_sweep16, peer_bullet_sweep32;
extern const peer peer_fcl_update, peer_fcl_refit;
extern const peer peer_ode_hash, peer_ode_sweep;

#ifdef __cplusplus
}
#endif

#endif
