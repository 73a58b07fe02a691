/* wire_check_events: the rules of Answer and EventBatch: as many of each array as there are events. Kinds, causes and
 * the like that are not known yet are no fault: a later daemon may say them. Pure; any thread. */
#include "wire_rules.h"

#include <string.h>

static wire_reason check_intervals(wire_f64s lo, wire_f64s hi, wire_refusal *why)
{
    for (uint32_t i = 0; i < lo.count && i < hi.count; i++)
        if (lo.at[i] > hi.at[i]) FAIL(WIRE_BAD_NUMBER, "lo[%u] is %g, above hi %g", i, lo.at[i], hi.at[i]);
    return WIRE_OK;
}

wire_reason check_answer(const wire_answer *m, wire_refusal *why)
{
    uint32_t n = m->names_a.count;
    TRY(check_optional("names_b", m->names_b.count, 1, n, why));
    TRY(check_optional("lo", m->lo.count, 1, n, why));
    TRY(check_count("hi", m->hi.count, 1, m->lo.count, why));
    TRY(check_optional("axes", m->axes.count, 3, n, why));
    TRY(check_optional("points_a", m->points_a.count, 3, n, why));
    TRY(check_optional("points_b", m->points_b.count, 3, n, why));
    TRY(check_optional("orientations", m->orientations.count, 4, n, why));
    TRY(check_optional("ages_ns", m->ages_ns.count, 1, n, why));
    TRY(check_optional("stale", m->stale.count, 1, n, why));
    TRY(check_all_between("stale", m->stale, 0, 1, why));
    TRY(check_optional("achieved", m->achieved.count, 1, n, why));
    return check_intervals(m->lo, m->hi, why);
}

static wire_reason check_event_counts(const wire_event_batch *m, wire_refusal *why)
{
    uint32_t n = m->kinds.count;
    TRY(check_count("causes", m->causes.count, 1, n, why));
    TRY(check_count("contacts", m->contacts.count, 1, n, why));
    TRY(check_count("names_a", m->names_a.count, 1, n, why));
    TRY(check_count("names_b", m->names_b.count, 1, n, why));
    TRY(check_count("shapes_a", m->shapes_a.count, 1, n, why));
    TRY(check_count("shapes_b", m->shapes_b.count, 1, n, why));
    TRY(check_count("lo", m->lo.count, 1, n, why));
    TRY(check_count("hi", m->hi.count, 1, n, why));
    TRY(check_count("axes", m->axes.count, 3, n, why));
    TRY(check_count("points_a", m->points_a.count, 3, n, why));
    TRY(check_count("points_b", m->points_b.count, 3, n, why));
    TRY(check_count("ages_a_ns", m->ages_a_ns.count, 1, n, why));
    TRY(check_count("ages_b_ns", m->ages_b_ns.count, 1, n, why));
    TRY(check_count("closings", m->closings.count, 1, n, why));
    TRY(check_count("achieved", m->achieved.count, 1, n, why));
    return check_count("manifold_counts", m->manifold_counts.count, 1, n, why);
}

static wire_reason check_manifolds(const wire_event_batch *m, wire_refusal *why)
{
    uint32_t points = 0;
    TRY(check_all_between("manifold_counts", m->manifold_counts, 0, 4, why));
    for (uint32_t i = 0; i < m->manifold_counts.count; i++) points += m->manifold_counts.at[i];
    TRY(check_count("manifold_points", m->manifold_points.count, 3, points, why));
    TRY(check_count("manifold_distances", m->manifold_distances.count, 1, points, why));
    return check_count("manifold_features", m->manifold_features.count, 1, points, why);
}

static wire_reason check_impacts(const wire_event_batch *m, wire_refusal *why)
{
    uint32_t n = 0;
    for (uint32_t i = 0; i < m->kinds.count; i++)
        n += m->kinds.at[i] == WIRE_EVENT_IMPACT || m->kinds.at[i] == WIRE_EVENT_PREDICTED;
    TRY(check_count("impact_times", m->impact_times.count, 2, n, why));
    TRY(check_count("impact_starts_ns", m->impact_starts_ns.count, 1, n, why));
    TRY(check_count("impact_poses", m->impact_poses.count, 14, n, why));
    TRY(check_count("impact_estimated", m->impact_estimated.count, 1, n, why));
    TRY(check_all_between("impact_estimated", m->impact_estimated, 0, 1, why));
    return check_poses("impact_poses", m->impact_poses, why);
}

wire_reason check_event_batch(const wire_event_batch *m, wire_refusal *why)
{
    TRY(check_between("batch", m->batch, 1, INT64_MAX, why));
    TRY(check_between("snapshot", m->snapshot, 0, 1, why));
    TRY(check_between("closing", m->closing, 0, 1, why));
    TRY(check_between("undone", m->undone, 0, INT64_MAX, why));
    TRY(check_between("simulation_ns", m->simulation_ns, 0, INT64_MAX, why));
    TRY(check_between("missing", m->missing, -INT32_MAX, INT32_MAX, why));
    TRY(check_between("refused", m->refused, 0, INT32_MAX, why));
    TRY(check_between("heartbeat", m->heartbeat, 0, 1, why));
    if (m->heartbeat) TRY(check_count("kinds", m->kinds.count, 0, 0, why));
    TRY(check_between("parts", m->parts, 1, INT32_MAX, why));
    TRY(check_between("part", m->part, 0, m->parts - 1, why));
    TRY(check_between("behind", m->behind, 0, INT32_MAX, why));
    TRY(check_name("stream", m->stream, why));
    TRY(check_stream(m->stream, why));
    TRY(check_event_counts(m, why));
    TRY(check_all_between("kinds", m->kinds, WIRE_EVENT_BEGIN, UINT8_MAX, why));
    TRY(check_intervals(m->lo, m->hi, why));
    TRY(check_impacts(m, why));
    return check_manifolds(m, why);
}
