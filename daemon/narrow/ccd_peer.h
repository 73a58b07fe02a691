/* ccd_peer: libccd as an engine. It proposes, the certificate decides, and what it got wrong is counted. Pure; any
 * thread.
 */
#ifndef COLLIDED_NARROW_CCD_PEER_H
#define COLLIDED_NARROW_CCD_PEER_H

#include "unit_pair.h"

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

#endif
