/* check_peer: what the race of robot checks asks of a contender: one robot of rigid links, one scene at a time. One
 * thread; metres, poses in the world. */
#ifndef COLLIDED_TESTS_BENCH_CHECK_PEER_H
#define COLLIDED_TESTS_BENCH_CHECK_PEER_H

#include "narrow_peer.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct check_peer {
    const char *name;
    void (*add_link_shape)(size_t link, const narrow_body *body, const narrow_place *in_link);
    void (*keep_apart)(size_t link_a, size_t link_b);
    void (*add_obstacle)(const narrow_body *body, const narrow_place *at);
    void (*begin_scene)(void);                /* all obstacles are there */
    void (*end_scene)(void);                  /* they go */
    bool (*meets)(const narrow_place *links); /* does the robot meet anything, with its links there? */
} check_peer;

extern const check_peer check_fcl;
extern const check_peer *const check_contenders[]; /* besides our own */
extern const size_t check_contender_count;

#ifdef __cplusplus
}
#endif

#endif
