/* The sink keeps counts and the last of each; the rig is one thread. */
#include "harness.h"

#include "base/array.h"
#include "link/link_open.h"

#include <poll.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/eventfd.h>
#include <unistd.h>

enum { POSES_MOST = 1000 };

static wire_message body_message(void)
{
    static const double pose[7] = {1, 2, 3, 1, 0, 0, 0}, size[3] = {0.1, 0.2, 0.3}, radius[1] = {0.01};
    static const double padding[1] = {-0.01}, margin[1] = {0.5};
    static const double shape_pose[7] = {0, 0, 0.5, 1, 0, 0, 0};
    static const uint8_t type[1] = {WIRE_SHAPE_BOX}, action[1] = {WIRE_RULE_ALLOW};
    static const int64_t geometry[1] = {0};
    static const char *const pattern[1] = {"group:table"}, *const reason[1] = {"it stands there"};
    return (wire_message){.kind = WIRE_BODY,
        .body = {.version = WIRE_VERSION,
            .client = CLIENT_ID,
            .sequence = 3,
            .body = 5,
            .name = "part \xc3\xa9",
            .group = "parts",
            .category = 1,
            .mask = -1,
            .one_way = 1,
            .deadline_ns = 1000000,
            .stamp_ns = 17,
            .stamp_is_now = 1,
            .pose = {7, pose},
            .shape_types = {1, type},
            .shape_sizes = {3, size},
            .shape_radii = {1, radius},
            .shape_poses = {7, shape_pose},
            .shape_geometries = {1, geometry},
            .rule_patterns = {1, pattern},
            .rule_actions = {1, action},
            .rule_reasons = {1, reason},
            .rule_paddings = {1, padding},
            .rule_margins = {1, margin}}};
}

static wire_message geometry_message(void)
{
    static const double vertices[12] = {0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1};
    wire_f64s points = {12, vertices};
    return (wire_message){.kind = WIRE_GEOMETRY,
        .geometry = {.version = WIRE_VERSION,
            .client = CLIENT_ID,
            .sequence = 2,
            .kind = WIRE_GEOMETRY_HULL,
            .hash = wire_geometry_hash(WIRE_GEOMETRY_HULL, points, (wire_i32s){0}),
            .vertex_numbers = 12,
            .pieces = 1,
            .vertices = points}};
}

static wire_message vertex_message(void)
{
    static const double vertices[6] = {0, 0, 1, 2, 3, 4};
    return (wire_message){.kind = WIRE_VERTEX_BATCH,
        .vertex_batch = {.version = WIRE_VERSION,
            .client = CLIENT_ID,
            .sequence = 6,
            .stamp_ns = 8,
            .step = 2,
            .body = 5,
            .first_vertex = 4,
            .vertices = {6, vertices}}};
}

wire_message sample_poses(int32_t count, int64_t sequence)
{
    static int32_t bodies[POSES_MOST];
    static double positions[3 * POSES_MOST], orientations[4 * POSES_MOST];
    for (int32_t i = 0; i < count; i++) {
        bodies[i] = i;
        positions[3 * i] = 0.001 * i;
        orientations[4 * i] = 1;
    }
    uint32_t n = (uint32_t)count;
    return (wire_message){.kind = WIRE_POSE_BATCH,
        .pose_batch = {.version = WIRE_VERSION,
            .client = CLIENT_ID,
            .sequence = sequence,
            .stamp_ns = 1000 + sequence,
            .step = sequence,
            .simulation_ns = 10 * sequence,
            .bodies = {n, bodies},
            .positions = {3 * n, positions},
            .orientations = {4 * n, orientations}}};
}

static wire_message answer_message(void)
{
    static const char *const a[1] = {"arm"}, *const b[1] = {"table"};
    static const double lo[1] = {0.1}, hi[1] = {0.2}, axis[3] = {0, 0, 1}, point[3] = {1, 2, 3};
    static const int64_t age[1] = {44};
    static const uint8_t stale[1] = {1};
    return (wire_message){.kind = WIRE_ANSWER,
        .answer = {.version = WIRE_VERSION,
            .client = CLIENT_ID,
            .sequence = 9,
            .epoch = 1,
            .tick = 2,
            .kind = WIRE_QUERY_DISTANCE,
            .text = "so it is",
            .names_a = {1, a},
            .names_b = {1, b},
            .lo = {1, lo},
            .hi = {1, hi},
            .axes = {3, axis},
            .points_a = {3, point},
            .points_b = {3, point},
            .ages_ns = {1, age},
            .stale = {1, stale}}};
}

wire_message sample_events(const char *stream, int64_t batch)
{
    static const uint8_t kind[1] = {WIRE_EVENT_BEGIN}, cause[1] = {WIRE_CAUSE_MOTION}, points[1] = {0};
    static const int64_t contact[1] = {77}, age_a[1] = {5}, age_b[1] = {-1};
    static const char *const a[1] = {"arm"}, *const b[1] = {"table"};
    static const int32_t shape_a[1] = {1}, shape_b[1] = {2};
    static const double lo[1] = {-0.01}, hi[1] = {-0.009}, axis[3] = {0, 0, 1}, point[3] = {1, 2, 3},
                        closing[1] = {0.25};
    return (wire_message){.kind = WIRE_EVENT_BATCH,
        .event_batch = {.version = WIRE_VERSION,
            .client = CLIENT_ID,
            .subscription = 1,
            .epoch = 2,
            .batch = batch,
            .tick = 4,
            .stamp_ns = 5,
            .latest_pose_ns = 6,
            .step = 7,
            .simulation_ns = 70,
            .parts = 1,
            .stream = stream,
            .kinds = {1, kind},
            .causes = {1, cause},
            .contacts = {1, contact},
            .names_a = {1, a},
            .names_b = {1, b},
            .shapes_a = {1, shape_a},
            .shapes_b = {1, shape_b},
            .lo = {1, lo},
            .hi = {1, hi},
            .axes = {3, axis},
            .points_a = {3, point},
            .points_b = {3, point},
            .ages_a_ns = {1, age_a},
            .ages_b_ns = {1, age_b},
            .closings = {1, closing},
            .achieved = {1, points},
            .manifold_counts = {1, points}}};
}

static wire_message status_message(void)
{
    static const char *const names[2] = {"ticks", "drops"};
    static const int64_t values[2] = {12, 0};
    return (wire_message){.kind = WIRE_STATUS,
        .status = {.version = WIRE_VERSION,
            .epoch = 1,
            .health = WIRE_HEALTH_READY,
            .daemon = "host:1",
            .release = "0.1",
            .links = "memory",
            .limits = "",
            .stamp_ns = 3,
            .started_ns = 2,
            .tick = 9,
            .counter_names = {2, names},
            .counter_values = {2, values}}};
}

static wire_message ack_message(void)
{
    static const int64_t sequences[3] = {1, 2, 3};
    return (wire_message){.kind = WIRE_ACK,
        .ack = {.version = WIRE_VERSION, .client = CLIENT_ID, .epoch = 1, .sequences = {3, sequences}}};
}

static wire_message query_message(void)
{
    static const double origin[3] = {1, 2, 3}, direction[3] = {0, 0, -1};
    return (wire_message){.kind = WIRE_QUERY,
        .query = {.version = WIRE_VERSION,
            .client = CLIENT_ID,
            .sequence = 8,
            .kind = WIRE_QUERY_RAY,
            .name_a = "",
            .name_b = "",
            .origin = {3, origin},
            .direction = {3, direction},
            .length_m = 4,
            .most = 1}};
}

static wire_message subscription_message(void)
{
    return (wire_message){.kind = WIRE_SUBSCRIPTION,
        .subscription = {.version = WIRE_VERSION,
            .client = CLIENT_ID,
            .sequence = 7,
            .subscription = 1,
            .facts = WIRE_FACT_TOUCH,
            .stream = "cell",
            .select_a = "*",
            .select_b = "group:parts",
            .range_m = 0.5,
            .tolerance_m = 1e-6,
            .rate_hz = 10}};
}

wire_message sample_message(wire_kind kind)
{
    switch (kind) {
    case WIRE_CLIENT:
        return (wire_message){.kind = WIRE_CLIENT,
            .client = {.version = WIRE_VERSION,
                .client = CLIENT_ID,
                .sequence = 1,
                .on_loss = WIRE_LOST_HOLD,
                .lease_ns = CLIENT_LEASE_MS * INT64_C(1000000),
                .name = "press"}};
    case WIRE_GEOMETRY:
        return geometry_message();
    case WIRE_BODY:
        return body_message();
    case WIRE_POSE_BATCH:
        return sample_poses(3, 4);
    case WIRE_VERTEX_BATCH:
        return vertex_message();
    case WIRE_SUBSCRIPTION:
        return subscription_message();
    case WIRE_QUERY:
        return query_message();
    case WIRE_ANSWER:
        return answer_message();
    case WIRE_EVENT_BATCH:
        return sample_events("cell", 1);
    case WIRE_STATUS:
        return status_message();
    case WIRE_REJECT:
        return (wire_message){.kind = WIRE_REJECT,
            .reject = {.version = WIRE_VERSION,
                .client = CLIENT_ID,
                .sequence = 3,
                .epoch = 1,
                .kind = WIRE_BODY,
                .object = 5,
                .reason = WIRE_NAME_TAKEN,
                .text = "part is taken"}};
    case WIRE_ACK:
        return ack_message();
    default:
        return (wire_message){0};
    }
}

bool same_message(const wire_message *a, const wire_message *b)
{
    size_t size = wire_lcm_size(a);
    if (a->kind != b->kind || size != wire_lcm_size(b)) return false;
    uint8_t *bytes = base_alloc(2 * size, 1);
    wire_lcm_encode(a, bytes, size);
    wire_lcm_encode(b, bytes + size, size);
    bool same = memcmp(bytes, bytes + size, size) == 0;
    free(bytes);
    return same;
}

static bool is_removed(const wire_message *m)
{
    return (m->kind == WIRE_CLIENT && m->client.removed) || (m->kind == WIRE_BODY && m->body.removed) ||
           (m->kind == WIRE_SUBSCRIPTION && m->subscription.removed) ||
           (m->kind == WIRE_GEOMETRY && m->geometry.removed);
}

static void on_message(void *context, struct link *from, const wire_message *m)
{
    (void)from;
    heard *h = context;
    wire_message expected = sample_message(m->kind);
    h->messages[m->kind]++;
    h->differing += !same_message(m, &expected);
    h->removed += is_removed(m);
    if (m->kind != WIRE_POSE_BATCH) return;
    h->disordered += m->pose_batch.sequence <= h->last_sequence;
    h->last_sequence = m->pose_batch.sequence;
}

static void on_refused(
    void *context, struct link *from, wire_kind kind, int64_t client, int64_t sequence, const wire_refusal *why)
{
    (void)from;
    heard *h = context;
    h->refused++;
    h->refused_kind = kind;
    h->refused_client = client;
    h->refused_sequence = sequence;
    h->why = *why;
}

static void on_lost(void *context, struct link *from, int64_t client)
{
    (void)from;
    heard *h = context;
    h->lost++;
    h->lost_client = client;
}

static void on_reader(void *context, struct link *from, const char *stream)
{
    (void)from;
    heard *h = context;
    h->readers++;
    snprintf(h->reader, sizeof h->reader, "%s", stream);
}

void rig_open(rig *r, const char *uri, const char *program)
{
    char why[512] = "";
    *r = (rig){.counters = metrics_create(), .wake_fd = eventfd(0, EFD_NONBLOCK | EFD_CLOEXEC)};
    r->sink = (link_sink){.context = &r->heard,
        .message = on_message,
        .refused = on_refused,
        .client_lost = on_lost,
        .stream_reader = on_reader};
    link_options options = {.wake_fd = r->wake_fd, .counters = r->counters, .interface = "", .program = program};
    r->link = link_open(uri, &options, why, sizeof why);
    if (!r->link) fail_msg("%s", why);
}

void rig_close(rig *r)
{
    link_close(r->link);
    metrics_destroy(r->counters);
    close(r->wake_fd);
}

void rig_receive(rig *r)
{
    r->sink.context = &r->heard;
    r->link->ops->receive(r->link, &r->sink);
}

void rig_publish(rig *r, const wire_message *m)
{
    r->link->ops->publish(r->link, m);
    r->link->ops->flush(r->link);
}

uint64_t rig_counter(const rig *r, const char *name)
{
    for (size_t i = 0; i < metrics_count(r->counters); i++)
        if (strcmp(metrics_at(r->counters, i)->name, name) == 0) return metric_get(metrics_at(r->counters, i));
    fail_msg("no counter %s", name);
    return 0;
}

bool rig_is_woken(rig *r, int timeout_ms)
{
    struct pollfd p = {.fd = r->wake_fd, .events = POLLIN};
    eventfd_t count;
    return poll(&p, 1, timeout_ms) == 1 && eventfd_read(r->wake_fd, &count) == 0;
}

bool rig_wait(rig *r, int64_t end_ns)
{
    rig_is_woken(r, 20);
    return clock_monotonic_ns() > end_ns;
}
