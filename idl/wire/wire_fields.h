/* wire_fields: every field of every message, once: F(S, name, type, limit, rule). The schema and the offsets into
 * idlc's structs are both made from these lists, so that they cannot differ in order. `S` is the struct they stand in,
 * `type` a wire_type without its prefix; `limit` is the most numbers, strings, or bytes of a string (0 for single
 * numbers); `rule` is FINITE or, where an infinity has a meaning, INFINITE. */
#ifndef COLLIDED_WIRE_FIELDS_H
#define COLLIDED_WIRE_FIELDS_H

#define WIRE_FIELDS_client(F, S)                                                                                       \
    F(S, version, I32, 0, FINITE)                                                                                      \
    F(S, client, I64, 0, FINITE)                                                                                       \
    F(S, sequence, I64, 0, FINITE)                                                                                     \
    F(S, removed, U8, 0, FINITE)                                                                                       \
    F(S, on_loss, U8, 0, FINITE)                                                                                       \
    F(S, lease_ns, I64, 0, FINITE)                                                                                     \
    F(S, lock_step, I32, 0, FINITE)                                                                                    \
    F(S, name, STRING, WIRE_NAME_MAX, FINITE)

#define WIRE_FIELDS_geometry(F, S)                                                                                     \
    F(S, version, I32, 0, FINITE)                                                                                      \
    F(S, client, I64, 0, FINITE)                                                                                       \
    F(S, sequence, I64, 0, FINITE)                                                                                     \
    F(S, removed, U8, 0, FINITE)                                                                                       \
    F(S, kind, U8, 0, FINITE)                                                                                          \
    F(S, hash, I64, 0, FINITE)                                                                                         \
    F(S, vertex_numbers, I32, 0, FINITE)                                                                               \
    F(S, index_numbers, I32, 0, FINITE)                                                                                \
    F(S, piece, I32, 0, FINITE)                                                                                        \
    F(S, pieces, I32, 0, FINITE)                                                                                       \
    F(S, vertices, F64S, WIRE_PIECE_MAX, FINITE)                                                                       \
    F(S, indices, I32S, WIRE_PIECE_MAX, FINITE)

#define WIRE_FIELDS_body(F, S)                                                                                         \
    F(S, version, I32, 0, FINITE)                                                                                      \
    F(S, client, I64, 0, FINITE)                                                                                       \
    F(S, sequence, I64, 0, FINITE)                                                                                     \
    F(S, body, I32, 0, FINITE)                                                                                         \
    F(S, removed, U8, 0, FINITE)                                                                                       \
    F(S, motion, U8, 0, FINITE)                                                                                        \
    F(S, ccd, U8, 0, FINITE)                                                                                           \
    F(S, acceleration_m_s2, F64, 0, FINITE)                                                                            \
    F(S, angular_acceleration_rad_s2, F64, 0, FINITE)                                                                  \
    F(S, name, STRING, WIRE_NAME_MAX, FINITE)                                                                          \
    F(S, group, STRING, WIRE_NAME_MAX, FINITE)                                                                         \
    F(S, category, I64, 0, FINITE)                                                                                     \
    F(S, mask, I64, 0, FINITE)                                                                                         \
    F(S, one_way, U8, 0, FINITE)                                                                                       \
    F(S, deadline_ns, I64, 0, FINITE)                                                                                  \
    F(S, stamp_ns, I64, 0, FINITE)                                                                                     \
    F(S, stamp_is_now, U8, 0, FINITE)                                                                                  \
    F(S, pose, F64S, 7, FINITE)                                                                                        \
    F(S, shape_types, U8S, WIRE_SHAPES_MAX, FINITE)                                                                    \
    F(S, shape_sizes, F64S, 3 * WIRE_SHAPES_MAX, FINITE)                                                               \
    F(S, shape_radii, F64S, WIRE_SHAPES_MAX, FINITE)                                                                   \
    F(S, shape_deviations, F64S, WIRE_SHAPES_MAX, FINITE)                                                              \
    F(S, shape_poses, F64S, 7 * WIRE_SHAPES_MAX, FINITE)                                                               \
    F(S, shape_geometries, I64S, WIRE_SHAPES_MAX, FINITE)                                                              \
    F(S, rule_patterns, STRINGS, WIRE_RULES_MAX, FINITE)                                                               \
    F(S, rule_actions, U8S, WIRE_RULES_MAX, FINITE)                                                                    \
    F(S, rule_reasons, STRINGS, WIRE_RULES_MAX, FINITE)                                                                \
    F(S, rule_paddings, F64S, WIRE_RULES_MAX, FINITE)                                                                  \
    F(S, rule_margins, F64S, WIRE_RULES_MAX, FINITE)

#define WIRE_FIELDS_pose_batch(F, S)                                                                                   \
    F(S, version, I32, 0, FINITE)                                                                                      \
    F(S, client, I64, 0, FINITE)                                                                                       \
    F(S, sequence, I64, 0, FINITE)                                                                                     \
    F(S, stamp_ns, I64, 0, FINITE)                                                                                     \
    F(S, step, I64, 0, FINITE)                                                                                         \
    F(S, simulation_ns, I64, 0, FINITE)                                                                                \
    F(S, bodies, I32S, WIRE_POSES_MAX, FINITE)                                                                         \
    F(S, positions, F64S, 3 * WIRE_POSES_MAX, FINITE)                                                                  \
    F(S, orientations, F64S, 4 * WIRE_POSES_MAX, FINITE)                                                               \
    F(S, linear, F64S, 3 * WIRE_POSES_MAX, FINITE)                                                                     \
    F(S, angular, F64S, 3 * WIRE_POSES_MAX, FINITE)                                                                    \
    F(S, teleports, U8S, WIRE_POSES_MAX, FINITE)

#define WIRE_FIELDS_vertex_batch(F, S)                                                                                 \
    F(S, version, I32, 0, FINITE)                                                                                      \
    F(S, client, I64, 0, FINITE)                                                                                       \
    F(S, sequence, I64, 0, FINITE)                                                                                     \
    F(S, stamp_ns, I64, 0, FINITE)                                                                                     \
    F(S, step, I64, 0, FINITE)                                                                                         \
    F(S, body, I32, 0, FINITE)                                                                                         \
    F(S, shape, I32, 0, FINITE)                                                                                        \
    F(S, first_vertex, I32, 0, FINITE)                                                                                 \
    F(S, vertices, F64S, 3 * WIRE_POSES_MAX, FINITE)

#define WIRE_FIELDS_interest(F, S)                                                                                     \
    F(S, version, I32, 0, FINITE)                                                                                      \
    F(S, client, I64, 0, FINITE)                                                                                       \
    F(S, sequence, I64, 0, FINITE)                                                                                     \
    F(S, interest, I32, 0, FINITE)                                                                                     \
    F(S, removed, U8, 0, FINITE)                                                                                       \
    F(S, facts, I32, 0, FINITE)                                                                                        \
    F(S, stream, STRING, WIRE_NAME_MAX, FINITE)                                                                        \
    F(S, select_a, STRING, WIRE_NAME_MAX, FINITE)                                                                      \
    F(S, select_b, STRING, WIRE_NAME_MAX, FINITE)                                                                      \
    F(S, threshold_m, F64, 0, FINITE)                                                                                  \
    F(S, range_m, F64, 0, FINITE)                                                                                      \
    F(S, tolerance_m, F64, 0, FINITE)                                                                                  \
    F(S, relative_tolerance, F64, 0, FINITE)                                                                           \
    F(S, accuracy, U8, 0, FINITE)                                                                                      \
    F(S, hysteresis_m, F64, 0, FINITE)                                                                                 \
    F(S, horizon_s, F64, 0, FINITE)                                                                                    \
    F(S, rate_hz, F64, 0, FINITE)

#define WIRE_FIELDS_query(F, S)                                                                                        \
    F(S, version, I32, 0, FINITE)                                                                                      \
    F(S, client, I64, 0, FINITE)                                                                                       \
    F(S, sequence, I64, 0, FINITE)                                                                                     \
    F(S, kind, U8, 0, FINITE)                                                                                          \
    F(S, name_a, STRING, WIRE_NAME_MAX, FINITE)                                                                        \
    F(S, name_b, STRING, WIRE_NAME_MAX, FINITE)                                                                        \
    F(S, origin, F64S, 3, FINITE)                                                                                      \
    F(S, orientation, F64S, 4, FINITE)                                                                                 \
    F(S, half, F64S, 3, FINITE)                                                                                        \
    F(S, direction, F64S, 3, FINITE)                                                                                   \
    F(S, length_m, F64, 0, INFINITE)                                                                                   \
    F(S, tolerance_m, F64, 0, FINITE)                                                                                  \
    F(S, most, I32, 0, FINITE)                                                                                         \
    F(S, linear, F64S, 3, FINITE)                                                                                      \
    F(S, angular, F64S, 3, FINITE)                                                                                     \
    F(S, span_s, F64, 0, FINITE)

#define WIRE_FIELDS_receipt(F, S)                                                                                      \
    F(S, version, I32, 0, FINITE)                                                                                      \
    F(S, client, I64, 0, FINITE)                                                                                       \
    F(S, sequence, I64, 0, FINITE)                                                                                     \
    F(S, interest, I32, 0, FINITE)                                                                                     \
    F(S, epoch, I64, 0, FINITE)                                                                                        \
    F(S, batch, I64, 0, FINITE)                                                                                        \
    F(S, tick, I64, 0, FINITE)                                                                                         \
    F(S, part, I32, 0, FINITE)                                                                                         \
    F(S, missing, U8, 0, FINITE)

#define WIRE_FIELDS_answer(F, S)                                                                                       \
    F(S, version, I32, 0, FINITE)                                                                                      \
    F(S, client, I64, 0, FINITE)                                                                                       \
    F(S, sequence, I64, 0, FINITE)                                                                                     \
    F(S, epoch, I64, 0, FINITE)                                                                                        \
    F(S, tick, I64, 0, FINITE)                                                                                         \
    F(S, stamp_ns, I64, 0, FINITE)                                                                                     \
    F(S, kind, U8, 0, FINITE)                                                                                          \
    F(S, status, U8, 0, FINITE)                                                                                        \
    F(S, text, STRING, WIRE_TEXT_MAX, FINITE)                                                                          \
    F(S, names_a, STRINGS, WIRE_ANSWERS_MAX, FINITE)                                                                   \
    F(S, names_b, STRINGS, WIRE_ANSWERS_MAX, FINITE)                                                                   \
    F(S, lo, F64S, WIRE_ANSWERS_MAX, INFINITE)                                                                         \
    F(S, hi, F64S, WIRE_ANSWERS_MAX, INFINITE)                                                                         \
    F(S, axes, F64S, 3 * WIRE_ANSWERS_MAX, FINITE)                                                                     \
    F(S, points_a, F64S, 3 * WIRE_ANSWERS_MAX, FINITE)                                                                 \
    F(S, points_b, F64S, 3 * WIRE_ANSWERS_MAX, FINITE)                                                                 \
    F(S, orientations, F64S, 4 * WIRE_ANSWERS_MAX, FINITE)                                                             \
    F(S, ages_ns, I64S, WIRE_ANSWERS_MAX, FINITE)                                                                      \
    F(S, stale, U8S, WIRE_ANSWERS_MAX, FINITE)                                                                         \
    F(S, achieved, U8S, WIRE_ANSWERS_MAX, FINITE)

#define WIRE_FIELDS_event_batch(F, S)                                                                                  \
    F(S, version, I32, 0, FINITE)                                                                                      \
    F(S, client, I64, 0, FINITE)                                                                                       \
    F(S, interest, I32, 0, FINITE)                                                                                     \
    F(S, epoch, I64, 0, FINITE)                                                                                        \
    F(S, batch, I64, 0, FINITE)                                                                                        \
    F(S, tick, I64, 0, FINITE)                                                                                         \
    F(S, stamp_ns, I64, 0, FINITE)                                                                                     \
    F(S, latest_pose_ns, I64, 0, FINITE)                                                                               \
    F(S, step, I64, 0, FINITE)                                                                                         \
    F(S, simulation_ns, I64, 0, FINITE)                                                                                \
    F(S, missing, I32, 0, FINITE)                                                                                      \
    F(S, refused, I32, 0, FINITE)                                                                                      \
    F(S, refusal, U8, 0, FINITE)                                                                                       \
    F(S, undone, I64, 0, FINITE)                                                                                       \
    F(S, heartbeat, U8, 0, FINITE)                                                                                     \
    F(S, oldest_pose_ns, I64, 0, FINITE)                                                                               \
    F(S, snapshot, U8, 0, FINITE)                                                                                      \
    F(S, closing, U8, 0, FINITE)                                                                                       \
    F(S, part, I32, 0, FINITE)                                                                                         \
    F(S, parts, I32, 0, FINITE)                                                                                        \
    F(S, behind, I32, 0, FINITE)                                                                                       \
    F(S, stream, STRING, WIRE_NAME_MAX, FINITE)                                                                        \
    F(S, kinds, U8S, WIRE_EVENTS_MAX, FINITE)                                                                          \
    F(S, causes, U8S, WIRE_EVENTS_MAX, FINITE)                                                                         \
    F(S, contacts, I64S, WIRE_EVENTS_MAX, FINITE)                                                                      \
    F(S, names_a, STRINGS, WIRE_EVENTS_MAX, FINITE)                                                                    \
    F(S, names_b, STRINGS, WIRE_EVENTS_MAX, FINITE)                                                                    \
    F(S, shapes_a, I32S, WIRE_EVENTS_MAX, FINITE)                                                                      \
    F(S, shapes_b, I32S, WIRE_EVENTS_MAX, FINITE)                                                                      \
    F(S, lo, F64S, WIRE_EVENTS_MAX, INFINITE)                                                                          \
    F(S, hi, F64S, WIRE_EVENTS_MAX, INFINITE)                                                                          \
    F(S, axes, F64S, 3 * WIRE_EVENTS_MAX, FINITE)                                                                      \
    F(S, points_a, F64S, 3 * WIRE_EVENTS_MAX, FINITE)                                                                  \
    F(S, points_b, F64S, 3 * WIRE_EVENTS_MAX, FINITE)                                                                  \
    F(S, ages_a_ns, I64S, WIRE_EVENTS_MAX, FINITE)                                                                     \
    F(S, ages_b_ns, I64S, WIRE_EVENTS_MAX, FINITE)                                                                     \
    F(S, closings, F64S, WIRE_EVENTS_MAX, FINITE)                                                                      \
    F(S, achieved, U8S, WIRE_EVENTS_MAX, FINITE)                                                                       \
    F(S, manifold_counts, U8S, WIRE_EVENTS_MAX, FINITE)                                                                \
    F(S, manifold_points, F64S, 12 * WIRE_EVENTS_MAX, FINITE)                                                          \
    F(S, manifold_distances, F64S, 4 * WIRE_EVENTS_MAX, FINITE)                                                        \
    F(S, manifold_features, I64S, 4 * WIRE_EVENTS_MAX, FINITE)                                                         \
    F(S, impact_times, F64S, 2 * WIRE_EVENTS_MAX, INFINITE)                                                            \
    F(S, impact_starts_ns, I64S, WIRE_EVENTS_MAX, FINITE)                                                              \
    F(S, impact_poses, F64S, 14 * WIRE_EVENTS_MAX, FINITE)                                                             \
    F(S, impact_estimated, U8S, WIRE_EVENTS_MAX, FINITE)

#define WIRE_FIELDS_status(F, S)                                                                                       \
    F(S, version, I32, 0, FINITE)                                                                                      \
    F(S, epoch, I64, 0, FINITE)                                                                                        \
    F(S, health, U8, 0, FINITE)                                                                                        \
    F(S, daemon, STRING, WIRE_TEXT_MAX, FINITE)                                                                        \
    F(S, release, STRING, WIRE_TEXT_MAX, FINITE)                                                                       \
    F(S, links, STRING, WIRE_TEXT_MAX, FINITE)                                                                         \
    F(S, limits, STRING, WIRE_TEXT_MAX, FINITE)                                                                        \
    F(S, stamp_ns, I64, 0, FINITE)                                                                                     \
    F(S, started_ns, I64, 0, FINITE)                                                                                   \
    F(S, tick, I64, 0, FINITE)                                                                                         \
    F(S, counter_names, STRINGS, WIRE_COUNTERS_MAX, FINITE)                                                            \
    F(S, counter_values, I64S, WIRE_COUNTERS_MAX, FINITE)

#define WIRE_FIELDS_reject(F, S)                                                                                       \
    F(S, version, I32, 0, FINITE)                                                                                      \
    F(S, client, I64, 0, FINITE)                                                                                       \
    F(S, sequence, I64, 0, FINITE)                                                                                     \
    F(S, epoch, I64, 0, FINITE)                                                                                        \
    F(S, kind, U8, 0, FINITE)                                                                                          \
    F(S, object, I32, 0, FINITE)                                                                                       \
    F(S, reason, U8, 0, FINITE)                                                                                        \
    F(S, text, STRING, WIRE_TEXT_MAX, FINITE)

#define WIRE_FIELDS_ack(F, S)                                                                                          \
    F(S, version, I32, 0, FINITE)                                                                                      \
    F(S, client, I64, 0, FINITE)                                                                                       \
    F(S, epoch, I64, 0, FINITE)                                                                                        \
    F(S, sequences, I64S, WIRE_POSES_MAX, FINITE)

/* M(kind, member of wire_message, name) for every message. */
#define WIRE_MESSAGES(M)                                                                                               \
    M(WIRE_CLIENT, client, Client)                                                                                     \
    M(WIRE_GEOMETRY, geometry, Geometry)                                                                               \
    M(WIRE_BODY, body, Body)                                                                                           \
    M(WIRE_POSE_BATCH, pose_batch, PoseBatch)                                                                          \
    M(WIRE_VERTEX_BATCH, vertex_batch, VertexBatch)                                                                    \
    M(WIRE_INTEREST, interest, Interest)                                                                               \
    M(WIRE_QUERY, query, Query)                                                                                        \
    M(WIRE_RECEIPT, receipt, Receipt)                                                                                  \
    M(WIRE_ANSWER, answer, Answer)                                                                                     \
    M(WIRE_EVENT_BATCH, event_batch, EventBatch)                                                                       \
    M(WIRE_STATUS, status, Status)                                                                                     \
    M(WIRE_REJECT, reject, Reject)                                                                                     \
    M(WIRE_ACK, ack, Ack)

#endif
