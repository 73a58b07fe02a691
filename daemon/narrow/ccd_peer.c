/* ccd_peer: what libccd proposes, held against our certificate. Pure; any thread. */
#include "ccd_peer.h"

#include "ccd_bridge.h"

static bool propose(
    const shape *a, const shape *b, const pose *b_in_a, narrow_engine engine, ccd_proposal *out, narrow_method *method)
{
    transform t = pose_transform(*b_in_a);
    if (engine == NARROW_ENGINE_CCD) {
        *method = NARROW_BY_CCD;
        ccd_bridge_gjk(a, b, &t, VEC_ZERO, out);
    } else {
        *method = NARROW_BY_MPR;
        ccd_bridge_mpr(a, b, &t, out);
    }
    return out->answered;
}

ccd_peer_opinion ccd_peer_ask(const unit_pair *p, const shape *a, const shape *b, const pose *b_in_a,
    narrow_engine engine, const narrow_goal *goal, span *out)
{
    ccd_peer_opinion peer = {.asked = false};
    ccd_proposal proposal = {.answered = false};
    if (engine != NARROW_ENGINE_CCD && engine != NARROW_ENGINE_MPR) return peer;
    if (a->type == SHAPE_HALFSPACE || b->type == SHAPE_HALFSPACE) return peer;
    peer.asked = true;
    peer.failed = !propose(a, b, b_in_a, engine, &proposal, &peer.method);
    peer.overlap = proposal.overlap;
    if (peer.failed || peer.overlap || !(vec_norm2(proposal.axis) > 0)) return peer;
    minkowski m = unit_pair_nearest_along(p, proposal.axis);
    double separation = vec_dot(proposal.axis, m.w);
    peer.failed = separation < p->radius - p->error;
    peer.settled = separation > goal->far;
    if (peer.settled) *out = (span){separation, vec_norm(m.w), proposal.axis, m.a, m.b, peer.method, 1, {.count_a = 0}};
    return peer;
}

uint32_t ccd_peer_failures(const ccd_peer_opinion *peer, const unit_pair *p, const span *proved)
{
    if (!peer->asked) return 0;
    bool apart = proved->lo > p->radius + p->error, overlap = proved->hi < p->radius - p->error;
    return peer->failed || (peer->overlap && apart) || (!peer->overlap && overlap);
}

bool ccd_peer_agreed(const ccd_peer_opinion *peer, const narrow_request *request, const narrow_result *result)
{
    if (!peer->asked || peer->failed || result->peer_failures) return false;
    return peer->settled || (request->facts & ~(unsigned)NARROW_VERDICT) == 0;
}
