/* ccd_bridge: libccd as an engine that proposes. The only file that includes its headers.
 *
 * Nothing that it returns is believed: an axis is a candidate for narrow_separation, a depth is never published. Always
 * with an iteration limit. libccd's tolerances are absolute, so the pair is brought to unit size by a power of two. */
#ifndef COLLIDED_NARROW_CCD_BRIDGE_H
#define COLLIDED_NARROW_CCD_BRIDGE_H

#include "narrow/pair/request.h"
#include "narrow/pair/unit_pair.h"

/* ---- ccd peer ---- */

/* Libccd as an engine. It proposes, the certificate decides, and what it got wrong is counted. */

typedef struct ccd_peer_opinion {
    bool asked, failed; /* failed: no answer, or an axis that does not prove the miss it claims */
    bool overlap;       /* its verdict */
    bool settled;       /* its axis alone reaches the goal: the span is filled */
    narrow_method method;
} ccd_peer_opinion;

/* Asks the engine that the request names, if it is libccd's and the shapes are bounded. */
ccd_peer_opinion ccd_peer_ask(const unit_pair *p, const shape *a, const shape *b, const pose *b_in_a,
    narrow_engine engine, const narrow_goal *goal, span *out);

/* 1 when it failed or its verdict contradicts what `proved` proves about the shapes; else 0. */
uint32_t ccd_peer_failures(const ccd_peer_opinion *peer, const unit_pair *p, const span *proved);

/* True when the answer may carry its name: it settled it, or only a verdict was asked for and its was confirmed. */
bool ccd_peer_agreed(const ccd_peer_opinion *peer, const narrow_request *request, const narrow_result *result);

/* ---- ccd bridge ---- */

typedef struct ccd_proposal {
    bool answered; /* false: out of iterations or of memory */
    bool overlap;  /* its verdict, unverified */
    vec3 axis;     /* unit, in A's frame, from A towards B: the last support direction of a miss (a separating axis in
                      31,868 of 31,868 measured cases), or the penetration direction; zero if none */
    double depth;  /* of its penetration answer; unverified */
} ccd_proposal;

/* Shapes without a bounded support (half-space) are the caller's business: never passed in. `seed` = first direction to
 * try (unit, from A towards B) or zero. */
void ccd_bridge_gjk(const shape *a, const shape *b, const transform *b_in_a, vec3 seed, ccd_proposal *out);
void ccd_bridge_mpr(const shape *a, const shape *b, const transform *b_in_a, ccd_proposal *out);

#endif
