/* fake_client: the client library as collidectl sees it, without any daemon: it tells on standard error what it was
 * asked, and answers from a few constants. FAKE_HEALTH is the daemon's health; FAKE_REFUSES names a body that it
 * refuses; with FAKE_INTERRUPTS the user presses Ctrl-C at the first poll. */
#include "collided.h"

#include <inttypes.h>
#include <math.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

struct collided {
    int32_t next;
    bool refused;
    collided_rejected *rejected;
    void *context;
};
static struct collided the_client;

static const char *setting(const char *name)
{
    const char *value = getenv(name);
    return value ? value : "";
}

const char *collided_status_text(collided_status status)
{
    return status == COLLIDED_OK ? "ok" : "failed";
}
const char *collided_version(void)
{
    return "fake";
}
collided_def collided_def_default(void)
{
    return (collided_def){.lease_s = 2};
}
const char *collided_connect_error(void)
{
    return "";
}
const char *collided_error(const collided *c)
{
    return c->refused ? "refused" : "";
}

collided *collided_connect(const char *uri, const collided_def *def)
{
    static const char *const losses[] = {"remove", "hold", "keep"};
    fprintf(stderr, "connect %s as %s, id %" PRId64 ", %s\n", uri, def->name, def->id, losses[def->on_loss]);
    return &the_client;
}

void collided_close(collided *c)
{
    (void)c;
    fputs("close\n", stderr);
}

collided_status collided_poll(collided *c, double timeout_s)
{
    (void)c;
    if (timeout_s > 0) usleep(5000);
    if (*setting("FAKE_INTERRUPTS")) raise(SIGINT);
    return COLLIDED_OK;
}
void collided_flush(collided *c)
{
    (void)c;
}

collided_status collided_sync(collided *c, double timeout_s)
{
    (void)timeout_s;
    return c->refused ? COLLIDED_REJECTED : COLLIDED_OK;
}

void collided_on_rejected(collided *c, collided_rejected *callback, void *context)
{
    c->rejected = callback;
    c->context = context;
}

collided_geometry collided_create_hull(collided *c, const double *points, size_t count)
{
    (void)c, (void)points;
    return (collided_geometry){(int64_t)count};
}

collided_geometry collided_create_mesh(
    collided *c, const double *points, size_t count, const int32_t *triangles, size_t triangle_count)
{
    (void)c, (void)points, (void)triangles;
    return (collided_geometry){(int64_t)(count + triangle_count)};
}

collided_geometry collided_create_height_field(
    collided *c, const double *heights, size_t rows, size_t columns, double spacing_x, double spacing_y, double base)
{
    (void)c;
    fprintf(stderr, "height field %zu x %zu by %g x %g m, %g m at the end, base %g m\n", rows, columns, spacing_x,
        spacing_y, heights[rows * columns - 1], base);
    return (collided_geometry){(int64_t)(rows * columns)};
}

collided_body_def collided_body_def_default(void)
{
    return (collided_body_def){.id = COLLIDED_NONE};
}

collided_body collided_create_body(collided *c, const collided_body_def *def)
{
    collided_body body = {def->id >= 0 ? def->id : c->next++};
    fprintf(stderr, "create %d %s\n", (int)body.id, def->name);
    if (def->ccd || def->acceleration_m_s2 > 0 || def->angular_acceleration_rad_s2 > 0)
        fprintf(stderr, "its ccd is %d, it accelerates by %g and %g\n", (int)def->ccd, def->acceleration_m_s2,
            def->angular_acceleration_rad_s2);
    if (strcmp(def->name, setting("FAKE_REFUSES")) == 0) {
        c->refused = true;
        c->rejected(c->context, &(collided_rejection){"Body", body.id, "name_taken", "it is another client's"});
    }
    return body;
}

collided_body collided_adopt_body(collided *c, int32_t id)
{
    (void)c;
    return (collided_body){id};
}

collided_status collided_remove_body(collided *c, collided_body body)
{
    (void)c;
    fprintf(stderr, "remove %d\n", (int)body.id);
    return COLLIDED_OK;
}

collided_status collided_move(collided *c, collided_body body, collided_pose pose)
{
    return collided_publish(c, 1, &body, pose.position, pose.orientation, NULL, NULL, 0, 0);
}

collided_status collided_publish(collided *c, size_t count, const collided_body *bodies, const double *positions,
    const double *orientations, const double *linear, const double *angular, int64_t stamp_ns, int64_t step)
{
    (void)c, (void)stamp_ns, (void)step;
    fprintf(stderr, "publish %zu\n", count);
    if (linear) fprintf(stderr, "linear %g %g %g\n", linear[0], linear[1], linear[2]);
    if (angular) fprintf(stderr, "angular %g %g %g\n", angular[0], angular[1], angular[2]);
    for (size_t i = 0; i < count; i++)
        fprintf(stderr, "pose %d %.3f %.3f %.3f %.3f\n", (int)bodies[i].id, positions[3 * i], positions[3 * i + 1],
            positions[3 * i + 2], orientations[4 * i]);
    return COLLIDED_OK;
}

collided_status collided_teleport(collided *c, size_t count, const collided_body *bodies, const double *positions,
    const double *orientations, const double *linear, const double *angular, int64_t stamp_ns, int64_t step)
{
    fputs("teleport: ", stderr);
    return collided_publish(c, count, bodies, positions, orientations, linear, angular, stamp_ns, step);
}

collided_subscription_def collided_subscription_def_default(void)
{
    return (collided_subscription_def){0};
}

collided_subscription collided_subscribe(collided *c, const collided_subscription_def *def)
{
    (void)c;
    static const collided_contact_point point = {{1, 2, 3}, -0.001, 7};
    const collided_impact met = {0.0425, 0.042500001, INT64_C(1700000000000000000), {{-0.15, 0, 0}, {1, 0, 0, 0}},
        {{0, 0, 0}, {1, 0, 0, 0}}, .estimated = false};
    const collided_impact ahead = {0.73, INFINITY, 5, {.orientation = {1}}, {.orientation = {1}}, .estimated = true};
    const collided_event events[] = {
        {.kind = COLLIDED_BEGIN,
            .cause = "snapshot",
            .contact = 3,
            .name_a = "a \"quoted\"\\",
            .name_b = "\xc3\xa4",
            .lo = -0.001,
            .hi = -0.001,
            .axis = {0, 0, 1},
            .age_a_s = 0.25,
            .age_b_s = -1,
            .points = &point,
            .point_count = 1},
        {.kind = COLLIDED_UNKNOWN, .cause = "stale", .name_a = "c", .name_b = "d", .lo = -INFINITY, .hi = INFINITY},
        {.kind = COLLIDED_EVENT_IMPACT,
            .cause = "motion",
            .contact = 4,
            .name_a = "bullet",
            .name_b = "wall",
            .axis = {1, 0, 0},
            .point_a = {-0.05, 0, 0},
            .closing_m_s = 20,
            .impact = &met},
        {.kind = COLLIDED_EVENT_PREDICTED,
            .cause = "motion",
            .name_a = "arm",
            .name_b = "cart",
            .lo = 0.001,
            .hi = 0.002,
            .impact = &ahead},
        {.kind = COLLIDED_EVENT_AVERTED, .cause = "motion", .name_a = "arm", .name_b = "cart", .lo = 0.1, .hi = 0.2},
    };
    collided_batch batch = {.stream = "s",
        .epoch = 1,
        .batch = 1,
        .lost = 2,
        .snapshot = true,
        .events = events,
        .event_count = sizeof events / sizeof *events};
    fprintf(stderr, "subscribe %u %s %s range %g horizon %g rate %g\n", def->facts, def->select_a, def->select_b,
        def->range_m, def->horizon_s, def->rate_hz);
    def->callback(def->context, &batch);
    batch = (collided_batch){.stream = "s",
        .epoch = 1,
        .batch = 1,
        .stamp_ns = INT64_C(1700000000500000000),
        .step = 7,
        .missing = 2,
        .simulation_ns = 2500000000,
        .heartbeat = true,
        .oldest_pose_ns = INT64_C(1700000000000000000)};
    def->callback(def->context, &batch);
    return (collided_subscription){0};
}

/* Steps of soft bodies are told of by nobody here. */
collided_subscription collided_subscribe_soft(
    collided *c, const collided_subscription_def *def, const collided_soft_def *soft)
{
    (void)soft;
    return collided_subscribe(c, def);
}

/* ---- answers ---- */

static collided_status answer(collided_result *out, const char *asked)
{
    static collided_hit hit = {
        .name_a = "a", .name_b = "b", .lo = 0.022134891, .hi = 0.0221348911, .age_s = -1, .orientation = {1, 0, 0, 0}};
    fprintf(stderr, "query %s\n", asked);
    *out = (collided_result){.hits = &hit, .count = 1};
    return COLLIDED_OK;
}

void collided_result_free(collided_result *result)
{
    *result = (collided_result){0};
}

collided_status collided_query_ray(collided *c, const double origin[3], const double direction[3], double length_m,
    double timeout_s, collided_result *out)
{
    (void)c, (void)origin, (void)direction, (void)length_m, (void)timeout_s;
    return answer(out, "ray");
}

collided_status collided_query_distance(
    collided *c, const char *name_a, const char *name_b, double tolerance_m, double timeout_s, collided_result *out)
{
    (void)c, (void)name_a, (void)name_b, (void)tolerance_m, (void)timeout_s;
    return answer(out, "distance");
}

collided_status collided_query_box(
    collided *c, const collided_pose *pose, const double half[3], double timeout_s, collided_result *out)
{
    (void)c, (void)pose, (void)half, (void)timeout_s;
    return answer(out, "box");
}

collided_status collided_query_cast(collided *c, const collided_pose *pose, const double half[3],
    const double direction[3], double length_m, double timeout_s, collided_result *out)
{
    (void)c, (void)pose, (void)half, (void)direction, (void)length_m, (void)timeout_s;
    return answer(out, "cast");
}

collided_status collided_query_sweep(collided *c, const char *name, const double linear[3], const double angular[3],
    double span_s, double tolerance_m, double timeout_s, collided_result *out)
{
    (void)c, (void)tolerance_m, (void)timeout_s;
    fprintf(stderr, "%s goes by %g %g %g, %g %g %g for %g\n", name, linear[0], linear[1], linear[2], angular[0],
        angular[1], angular[2], span_s);
    return answer(out, "sweep");
}

collided_status collided_query_nearest(collided *c, const char *name, const collided_pose *pose, const double half[3],
    double within_m, int32_t most, double timeout_s, collided_result *out)
{
    (void)c, (void)name, (void)pose, (void)half, (void)within_m, (void)most, (void)timeout_s;
    return answer(out, "nearest");
}

collided_status collided_query_explain(
    collided *c, const char *name_a, const char *name_b, double timeout_s, collided_result *out)
{
    (void)c, (void)name_a, (void)name_b, (void)timeout_s;
    return answer(out, "explain");
}

collided_status collided_query_bodies(collided *c, const char *pattern, double timeout_s, collided_result *out)
{
    (void)c, (void)timeout_s;
    return answer(out, pattern);
}

/* ---- a scene of nothing; no verb is tried with it here ---- */

collided_observation_def collided_observation_def_default(void)
{
    return (collided_observation_def){.rate_hz = 30};
}

collided_subscription collided_observe(collided *c, const collided_observation_def *def)
{
    (void)c, (void)def;
    return (collided_subscription){1};
}

collided_status collided_query_geometry(
    collided *c, const char *body, collided_geometry geometry, double timeout_s, collided_geometry_numbers *out)
{
    (void)c, (void)body, (void)geometry, (void)timeout_s, (void)out;
    return COLLIDED_UNKNOWN_ID;
}

int collided_fd(collided *c)
{
    (void)c;
    return -1;
}

void collided_geometry_numbers_free(collided_geometry_numbers *numbers)
{
    (void)numbers;
}

/* ---- checks: all is free ---- */

collided_check_options collided_check_options_default(void)
{
    return (collided_check_options){.resolution_m = 1e-4, .find_first = true, .tolerance_m = 1e-6};
}

static collided_status all_free(size_t count, const char *kind, collided_checked *out)
{
    static collided_check_item items[16];
    fprintf(stderr, "check %zu %s\n", count, kind);
    if (count > 16) return COLLIDED_BAD_ARGUMENT;
    for (size_t i = 0; i < count; i++)
        items[i] = (collided_check_item){.first_lo = 1, .first_hi = 1, .lo = 0.25, .hi = 0.25, .name_a = "arm"};
    *out = (collided_checked){.items = items, .count = count, .text = (char *)""};
    return COLLIDED_OK;
}

collided_status collided_check_states(collided *c, const collided_robot *robot, const collided_check_options *options,
    const double *positions, size_t count, double timeout_s, collided_checked *out)
{
    (void)c, (void)robot, (void)options, (void)positions, (void)timeout_s;
    return all_free(count, "states", out);
}

collided_status collided_check_edges(collided *c, const collided_robot *robot, const collided_check_options *options,
    const double *positions, size_t count, double timeout_s, collided_checked *out)
{
    (void)c, (void)robot, (void)options, (void)positions, (void)timeout_s;
    return all_free(count, "edges", out);
}

void collided_checked_free(collided_checked *checked)
{
    *checked = (collided_checked){0};
}

collided_status collided_record(collided *c, const char *name, double timeout_s, collided_result *out)
{
    (void)c, (void)timeout_s;
    fprintf(stderr, "record %s\n", name ? name : "(end)");
    *out = (collided_result){.text = (char *)"/var/lib/collided/session"};
    return COLLIDED_OK;
}

collided_status collided_get_status(collided *c, double timeout_s, collided_daemon_status *out)
{
    (void)c, (void)timeout_s;
    static const collided_counter counters[] = {{"bodies", 3}, {"narrow_queries", 123456}, {"contacts", 2},
        {"contacts_of_cell", 2}, {"nearest_nm_of_cell", -1500000}, {"soonest_ns_of_cell", 960000000},
        {"contacts_of_far", 0}};
    static int64_t
        calls; /* each answer is a second later than the one before; FAKE_DIES: after so many there is none */
    *out = (collided_daemon_status){.epoch = 0};
    if (++calls > atoll(setting("FAKE_DIES")) && *setting("FAKE_DIES")) return COLLIDED_NO_DAEMON;
    *out = (collided_daemon_status){.epoch = 5,
        .stamp_ns = 1000000000 * calls,
        .health = setting("FAKE_HEALTH"),
        .daemon = "host:1",
        .release = "0.1",
        .links = "dds://0 on lo",
        .limits = "",
        .counters = counters,
        .counter_count = getenv("FAKE_STREAMS") ? sizeof counters / sizeof *counters : 2};
    return COLLIDED_OK;
}
