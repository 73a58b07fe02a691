/* wire_fields: every field of every message, once: F(S, member, name, type, limit, rule). The schema and the offsets
 * into idlc's structs are both made from these lists, so that they cannot differ in order. `S` is the struct they stand
 * in, `member` the field's name in wire.h and `name` that in IDL and LCM, where `client` would differ from
 * `Client` in case alone; `type` is a wire_type without its prefix; `limit` is the most numbers, strings, or bytes of a
 * string (0 for single numbers); `rule` is FINITE or, where an infinity has a meaning, INFINITE. A list never changes:
 * see README.md, "How the wire grows". */
#ifndef COLLIDED_WIRE_FIELDS_H
#define COLLIDED_WIRE_FIELDS_H

#define WIRE_FIELDS_client(F, S)                                                                                       \
    F(S, version, version, I32, 0, FINITE)                                                                             \
    F(S, client, client_id, I64, 0, FINITE)                                                                            \
    F(S, sequence, sequence, I64, 0, FINITE)                                                                           \
    F(S, removed, removed, U8, 0, FINITE)                                                                              \
    F(S, on_loss, on_loss, U8, 0, FINITE)                                                                              \
    F(S, lease_ns, lease_ns, I64, 0, FINITE)                                                                           \
    F(S, lock_step, lock_step, I32, 0, FINITE)                                                                         \
    F(S, name, name, STRING, WIRE_NAME_MAX, FINITE)                                                                    \
    F(S, extensions, extensions, U8S, WIRE_EXTENSIONS_MAX, FINITE)

#define WIRE_FIELDS_geometry(F, S)                                                                                     \
    F(S, version, version, I32, 0, FINITE)                                                                             \
    F(S, client, client_id, I64, 0, FINITE)                                                                            \
    F(S, sequence, sequence, I64, 0, FINITE)                                                                           \
    F(S, removed, removed, U8, 0, FINITE)                                                                              \
    F(S, kind, kind, U8, 0, FINITE)                                                                                    \
    F(S, hash, hash, I64, 0, FINITE)                                                                                   \
    F(S, vertex_numbers, vertex_numbers, I32, 0, FINITE)                                                               \
    F(S, index_numbers, index_numbers, I32, 0, FINITE)                                                                 \
    F(S, piece, piece, I32, 0, FINITE)                                                                                 \
    F(S, pieces, pieces, I32, 0, FINITE)                                                                               \
    F(S, vertices, vertices, F64S, WIRE_PIECE_MAX, FINITE)                                                             \
    F(S, indices, indices, I32S, WIRE_PIECE_MAX, FINITE)                                                               \
    F(S, extensions, extensions, U8S, WIRE_EXTENSIONS_MAX, FINITE)

#define WIRE_FIELDS_body(F, S)                                                                                         \
    F(S, version, version, I32, 0, FINITE)                                                                             \
    F(S, client, client_id, I64, 0, FINITE)                                                                            \
    F(S, sequence, sequence, I64, 0, FINITE)                                                                           \
    F(S, body, body_id, I32, 0, FINITE)                                                                                \
    F(S, removed, removed, U8, 0, FINITE)                                                                              \
    F(S, motion, motion, U8, 0, FINITE)                                                                                \
    F(S, ccd, ccd, U8, 0, FINITE)                                                                                      \
    F(S, acceleration_m_s2, acceleration_m_s2, F64, 0, FINITE)                                                         \
    F(S, angular_acceleration_rad_s2, angular_acceleration_rad_s2, F64, 0, FINITE)                                     \
    F(S, name, name, STRING, WIRE_NAME_MAX, FINITE)                                                                    \
    F(S, group, group, STRING, WIRE_NAME_MAX, FINITE)                                                                  \
    F(S, category, category, I64, 0, FINITE)                                                                           \
    F(S, mask, mask, I64, 0, FINITE)                                                                                   \
    F(S, one_way, one_way, U8, 0, FINITE)                                                                              \
    F(S, deadline_ns, deadline_ns, I64, 0, FINITE)                                                                     \
    F(S, stamp_ns, stamp_ns, I64, 0, FINITE)                                                                           \
    F(S, stamp_is_now, stamp_is_now, U8, 0, FINITE)                                                                    \
    F(S, pose, pose, F64S, 7, FINITE)                                                                                  \
    F(S, shape_types, shape_types, U8S, WIRE_SHAPES_MAX, FINITE)                                                       \
    F(S, shape_sizes, shape_sizes, F64S, 3 * WIRE_SHAPES_MAX, FINITE)                                                  \
    F(S, shape_radii, shape_radii, F64S, WIRE_SHAPES_MAX, FINITE)                                                      \
    F(S, shape_deviations, shape_deviations, F64S, WIRE_SHAPES_MAX, FINITE)                                            \
    F(S, shape_poses, shape_poses, F64S, 7 * WIRE_SHAPES_MAX, FINITE)                                                  \
    F(S, shape_geometries, shape_geometries, I64S, WIRE_SHAPES_MAX, FINITE)                                            \
    F(S, rule_patterns, rule_patterns, STRINGS, WIRE_RULES_MAX, FINITE)                                                \
    F(S, rule_actions, rule_actions, U8S, WIRE_RULES_MAX, FINITE)                                                      \
    F(S, rule_reasons, rule_reasons, STRINGS, WIRE_RULES_MAX, FINITE)                                                  \
    F(S, rule_paddings, rule_paddings, F64S, WIRE_RULES_MAX, FINITE)                                                   \
    F(S, rule_margins, rule_margins, F64S, WIRE_RULES_MAX, FINITE)                                                     \
    F(S, extensions, extensions, U8S, WIRE_EXTENSIONS_MAX, FINITE)

#define WIRE_FIELDS_pose_batch(F, S)                                                                                   \
    F(S, version, version, I32, 0, FINITE)                                                                             \
    F(S, client, client_id, I64, 0, FINITE)                                                                            \
    F(S, sequence, sequence, I64, 0, FINITE)                                                                           \
    F(S, stamp_ns, stamp_ns, I64, 0, FINITE)                                                                           \
    F(S, step, step, I64, 0, FINITE)                                                                                   \
    F(S, simulation_ns, simulation_ns, I64, 0, FINITE)                                                                 \
    F(S, bodies, bodies, I32S, WIRE_POSES_MAX, FINITE)                                                                 \
    F(S, positions, positions, F64S, 3 * WIRE_POSES_MAX, FINITE)                                                       \
    F(S, orientations, orientations, F64S, 4 * WIRE_POSES_MAX, FINITE)                                                 \
    F(S, linear, linear, F64S, 3 * WIRE_POSES_MAX, FINITE)                                                             \
    F(S, angular, angular, F64S, 3 * WIRE_POSES_MAX, FINITE)                                                           \
    F(S, teleports, teleports, U8S, WIRE_POSES_MAX, FINITE)                                                            \
    F(S, extensions, extensions, U8S, WIRE_BATCH_EXTENSIONS_MAX, FINITE)

#define WIRE_FIELDS_vertex_batch(F, S)                                                                                 \
    F(S, version, version, I32, 0, FINITE)                                                                             \
    F(S, client, client_id, I64, 0, FINITE)                                                                            \
    F(S, sequence, sequence, I64, 0, FINITE)                                                                           \
    F(S, stamp_ns, stamp_ns, I64, 0, FINITE)                                                                           \
    F(S, step, step, I64, 0, FINITE)                                                                                   \
    F(S, body, body_id, I32, 0, FINITE)                                                                                \
    F(S, shape, shape, I32, 0, FINITE)                                                                                 \
    F(S, first_vertex, first_vertex, I32, 0, FINITE)                                                                   \
    F(S, vertices, vertices, F64S, 3 * WIRE_POSES_MAX, FINITE)                                                         \
    F(S, extensions, extensions, U8S, WIRE_BATCH_EXTENSIONS_MAX, FINITE)

#define WIRE_FIELDS_subscription(F, S)                                                                                 \
    F(S, version, version, I32, 0, FINITE)                                                                             \
    F(S, client, client_id, I64, 0, FINITE)                                                                            \
    F(S, sequence, sequence, I64, 0, FINITE)                                                                           \
    F(S, subscription, subscription_id, I32, 0, FINITE)                                                                \
    F(S, removed, removed, U8, 0, FINITE)                                                                              \
    F(S, facts, facts, I32, 0, FINITE)                                                                                 \
    F(S, stream, stream, STRING, WIRE_NAME_MAX, FINITE)                                                                \
    F(S, select_a, select_a, STRING, WIRE_NAME_MAX, FINITE)                                                            \
    F(S, select_b, select_b, STRING, WIRE_NAME_MAX, FINITE)                                                            \
    F(S, threshold_m, threshold_m, F64, 0, FINITE)                                                                     \
    F(S, range_m, range_m, F64, 0, FINITE)                                                                             \
    F(S, tolerance_m, tolerance_m, F64, 0, FINITE)                                                                     \
    F(S, relative_tolerance, relative_tolerance, F64, 0, FINITE)                                                       \
    F(S, accuracy, accuracy, U8, 0, FINITE)                                                                            \
    F(S, hysteresis_m, hysteresis_m, F64, 0, FINITE)                                                                   \
    F(S, horizon_s, horizon_s, F64, 0, FINITE)                                                                         \
    F(S, rate_hz, rate_hz, F64, 0, FINITE)                                                                             \
    F(S, extensions, extensions, U8S, WIRE_EXTENSIONS_MAX, FINITE)

#define WIRE_FIELDS_query(F, S)                                                                                        \
    F(S, version, version, I32, 0, FINITE)                                                                             \
    F(S, client, client_id, I64, 0, FINITE)                                                                            \
    F(S, sequence, sequence, I64, 0, FINITE)                                                                           \
    F(S, kind, kind, U8, 0, FINITE)                                                                                    \
    F(S, name_a, name_a, STRING, WIRE_NAME_MAX, FINITE)                                                                \
    F(S, name_b, name_b, STRING, WIRE_NAME_MAX, FINITE)                                                                \
    F(S, origin, origin, F64S, 3, FINITE)                                                                              \
    F(S, orientation, orientation, F64S, 4, FINITE)                                                                    \
    F(S, half, half, F64S, 3, FINITE)                                                                                  \
    F(S, direction, direction, F64S, 3, FINITE)                                                                        \
    F(S, length_m, length_m, F64, 0, INFINITE)                                                                         \
    F(S, tolerance_m, tolerance_m, F64, 0, FINITE)                                                                     \
    F(S, most, most, I32, 0, FINITE)                                                                                   \
    F(S, linear, linear, F64S, 3, FINITE)                                                                              \
    F(S, angular, angular, F64S, 3, FINITE)                                                                            \
    F(S, span_s, span_s, F64, 0, FINITE)                                                                               \
    F(S, extensions, extensions, U8S, WIRE_EXTENSIONS_MAX, FINITE)

#define WIRE_FIELDS_receipt(F, S)                                                                                      \
    F(S, version, version, I32, 0, FINITE)                                                                             \
    F(S, client, client_id, I64, 0, FINITE)                                                                            \
    F(S, sequence, sequence, I64, 0, FINITE)                                                                           \
    F(S, subscription, subscription_id, I32, 0, FINITE)                                                                \
    F(S, epoch, epoch, I64, 0, FINITE)                                                                                 \
    F(S, batch, batch, I64, 0, FINITE)                                                                                 \
    F(S, tick, tick, I64, 0, FINITE)                                                                                   \
    F(S, part, part, I32, 0, FINITE)                                                                                   \
    F(S, missing, missing, U8, 0, FINITE)                                                                              \
    F(S, extensions, extensions, U8S, WIRE_EXTENSIONS_MAX, FINITE)

#define WIRE_FIELDS_answer(F, S)                                                                                       \
    F(S, version, version, I32, 0, FINITE)                                                                             \
    F(S, client, client_id, I64, 0, FINITE)                                                                            \
    F(S, sequence, sequence, I64, 0, FINITE)                                                                           \
    F(S, epoch, epoch, I64, 0, FINITE)                                                                                 \
    F(S, tick, tick, I64, 0, FINITE)                                                                                   \
    F(S, stamp_ns, stamp_ns, I64, 0, FINITE)                                                                           \
    F(S, kind, kind, U8, 0, FINITE)                                                                                    \
    F(S, status, outcome, U8, 0, FINITE)                                                                               \
    F(S, text, text, STRING, WIRE_TEXT_MAX, FINITE)                                                                    \
    F(S, names_a, names_a, STRINGS, WIRE_ANSWERS_MAX, FINITE)                                                          \
    F(S, names_b, names_b, STRINGS, WIRE_ANSWERS_MAX, FINITE)                                                          \
    F(S, lo, lo, F64S, WIRE_ANSWERS_MAX, INFINITE)                                                                     \
    F(S, hi, hi, F64S, WIRE_ANSWERS_MAX, INFINITE)                                                                     \
    F(S, axes, axes, F64S, 3 * WIRE_ANSWERS_MAX, FINITE)                                                               \
    F(S, points_a, points_a, F64S, 3 * WIRE_ANSWERS_MAX, FINITE)                                                       \
    F(S, points_b, points_b, F64S, 3 * WIRE_ANSWERS_MAX, FINITE)                                                       \
    F(S, orientations, orientations, F64S, 4 * WIRE_ANSWERS_MAX, FINITE)                                               \
    F(S, ages_ns, ages_ns, I64S, WIRE_ANSWERS_MAX, FINITE)                                                             \
    F(S, stale, stale, U8S, WIRE_ANSWERS_MAX, FINITE)                                                                  \
    F(S, achieved, achieved, U8S, WIRE_ANSWERS_MAX, FINITE)                                                            \
    F(S, extensions, extensions, U8S, WIRE_BATCH_EXTENSIONS_MAX, FINITE)

#define WIRE_FIELDS_event_batch(F, S)                                                                                  \
    F(S, version, version, I32, 0, FINITE)                                                                             \
    F(S, client, client_id, I64, 0, FINITE)                                                                            \
    F(S, subscription, subscription_id, I32, 0, FINITE)                                                                \
    F(S, epoch, epoch, I64, 0, FINITE)                                                                                 \
    F(S, batch, batch, I64, 0, FINITE)                                                                                 \
    F(S, tick, tick, I64, 0, FINITE)                                                                                   \
    F(S, stamp_ns, stamp_ns, I64, 0, FINITE)                                                                           \
    F(S, latest_pose_ns, latest_pose_ns, I64, 0, FINITE)                                                               \
    F(S, step, step, I64, 0, FINITE)                                                                                   \
    F(S, simulation_ns, simulation_ns, I64, 0, FINITE)                                                                 \
    F(S, missing, missing, I32, 0, FINITE)                                                                             \
    F(S, refused, refused, I32, 0, FINITE)                                                                             \
    F(S, refusal, refusal, U8, 0, FINITE)                                                                              \
    F(S, undone, undone, I64, 0, FINITE)                                                                               \
    F(S, heartbeat, heartbeat, U8, 0, FINITE)                                                                          \
    F(S, oldest_pose_ns, oldest_pose_ns, I64, 0, FINITE)                                                               \
    F(S, snapshot, snapshot, U8, 0, FINITE)                                                                            \
    F(S, closing, closing, U8, 0, FINITE)                                                                              \
    F(S, part, part, I32, 0, FINITE)                                                                                   \
    F(S, parts, parts, I32, 0, FINITE)                                                                                 \
    F(S, behind, behind, I32, 0, FINITE)                                                                               \
    F(S, stream, stream, STRING, WIRE_NAME_MAX, FINITE)                                                                \
    F(S, kinds, kinds, U8S, WIRE_EVENTS_MAX, FINITE)                                                                   \
    F(S, causes, causes, U8S, WIRE_EVENTS_MAX, FINITE)                                                                 \
    F(S, contacts, contacts, I64S, WIRE_EVENTS_MAX, FINITE)                                                            \
    F(S, names_a, names_a, STRINGS, WIRE_EVENTS_MAX, FINITE)                                                           \
    F(S, names_b, names_b, STRINGS, WIRE_EVENTS_MAX, FINITE)                                                           \
    F(S, shapes_a, shapes_a, I32S, WIRE_EVENTS_MAX, FINITE)                                                            \
    F(S, shapes_b, shapes_b, I32S, WIRE_EVENTS_MAX, FINITE)                                                            \
    F(S, lo, lo, F64S, WIRE_EVENTS_MAX, INFINITE)                                                                      \
    F(S, hi, hi, F64S, WIRE_EVENTS_MAX, INFINITE)                                                                      \
    F(S, axes, axes, F64S, 3 * WIRE_EVENTS_MAX, FINITE)                                                                \
    F(S, points_a, points_a, F64S, 3 * WIRE_EVENTS_MAX, FINITE)                                                        \
    F(S, points_b, points_b, F64S, 3 * WIRE_EVENTS_MAX, FINITE)                                                        \
    F(S, ages_a_ns, ages_a_ns, I64S, WIRE_EVENTS_MAX, FINITE)                                                          \
    F(S, ages_b_ns, ages_b_ns, I64S, WIRE_EVENTS_MAX, FINITE)                                                          \
    F(S, closings, closings, F64S, WIRE_EVENTS_MAX, FINITE)                                                            \
    F(S, achieved, achieved, U8S, WIRE_EVENTS_MAX, FINITE)                                                             \
    F(S, manifold_counts, manifold_counts, U8S, WIRE_EVENTS_MAX, FINITE)                                               \
    F(S, manifold_points, manifold_points, F64S, 12 * WIRE_EVENTS_MAX, FINITE)                                         \
    F(S, manifold_distances, manifold_distances, F64S, 4 * WIRE_EVENTS_MAX, FINITE)                                    \
    F(S, manifold_features, manifold_features, I64S, 4 * WIRE_EVENTS_MAX, FINITE)                                      \
    F(S, impact_times, impact_times, F64S, 2 * WIRE_EVENTS_MAX, INFINITE)                                              \
    F(S, impact_starts_ns, impact_starts_ns, I64S, WIRE_EVENTS_MAX, FINITE)                                            \
    F(S, impact_poses, impact_poses, F64S, 14 * WIRE_EVENTS_MAX, FINITE)                                               \
    F(S, impact_estimated, impact_estimated, U8S, WIRE_EVENTS_MAX, FINITE)                                             \
    F(S, extensions, extensions, U8S, WIRE_BATCH_EXTENSIONS_MAX, FINITE)

#define WIRE_FIELDS_status(F, S)                                                                                       \
    F(S, version, version, I32, 0, FINITE)                                                                             \
    F(S, epoch, epoch, I64, 0, FINITE)                                                                                 \
    F(S, health, health, U8, 0, FINITE)                                                                                \
    F(S, daemon, daemon, STRING, WIRE_TEXT_MAX, FINITE)                                                                \
    F(S, release, release, STRING, WIRE_TEXT_MAX, FINITE)                                                              \
    F(S, links, links, STRING, WIRE_TEXT_MAX, FINITE)                                                                  \
    F(S, limits, limits, STRING, WIRE_TEXT_MAX, FINITE)                                                                \
    F(S, stamp_ns, stamp_ns, I64, 0, FINITE)                                                                           \
    F(S, started_ns, started_ns, I64, 0, FINITE)                                                                       \
    F(S, tick, tick, I64, 0, FINITE)                                                                                   \
    F(S, counter_names, counter_names, STRINGS, WIRE_COUNTERS_MAX, FINITE)                                             \
    F(S, counter_values, counter_values, I64S, WIRE_COUNTERS_MAX, FINITE)                                              \
    F(S, extensions, extensions, U8S, WIRE_EXTENSIONS_MAX, FINITE)

#define WIRE_FIELDS_reject(F, S)                                                                                       \
    F(S, version, version, I32, 0, FINITE)                                                                             \
    F(S, client, client_id, I64, 0, FINITE)                                                                            \
    F(S, sequence, sequence, I64, 0, FINITE)                                                                           \
    F(S, epoch, epoch, I64, 0, FINITE)                                                                                 \
    F(S, kind, kind, U8, 0, FINITE)                                                                                    \
    F(S, object, object_id, I32, 0, FINITE)                                                                            \
    F(S, reason, reason, U8, 0, FINITE)                                                                                \
    F(S, text, text, STRING, WIRE_TEXT_MAX, FINITE)                                                                    \
    F(S, extensions, extensions, U8S, WIRE_EXTENSIONS_MAX, FINITE)

#define WIRE_FIELDS_ack(F, S)                                                                                          \
    F(S, version, version, I32, 0, FINITE)                                                                             \
    F(S, client, client_id, I64, 0, FINITE)                                                                            \
    F(S, epoch, epoch, I64, 0, FINITE)                                                                                 \
    F(S, sequences, sequences, I64S, WIRE_POSES_MAX, FINITE)                                                           \
    F(S, extensions, extensions, U8S, WIRE_EXTENSIONS_MAX, FINITE)

/* M(kind, member of wire_message, name) for every message. */
#define WIRE_MESSAGES(M)                                                                                               \
    M(WIRE_CLIENT, client, Client)                                                                                     \
    M(WIRE_GEOMETRY, geometry, Geometry)                                                                               \
    M(WIRE_BODY, body, Body)                                                                                           \
    M(WIRE_POSE_BATCH, pose_batch, PoseBatch)                                                                          \
    M(WIRE_VERTEX_BATCH, vertex_batch, VertexBatch)                                                                    \
    M(WIRE_SUBSCRIPTION, subscription, Subscription)                                                                   \
    M(WIRE_QUERY, query, Query)                                                                                        \
    M(WIRE_RECEIPT, receipt, Receipt)                                                                                  \
    M(WIRE_ANSWER, answer, Answer)                                                                                     \
    M(WIRE_EVENT_BATCH, event_batch, EventBatch)                                                                       \
    M(WIRE_STATUS, status, Status)                                                                                     \
    M(WIRE_REJECT, reject, Reject)                                                                                     \
    M(WIRE_ACK, ack, Ack)

#endif
