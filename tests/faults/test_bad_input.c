/* Nonsense over real links: refused by name to its sender, counted, and of no effect on anybody else. */
#include "base/prng.h"
#include "raw_dds.h"
#include "rig.h"
#include "wire/one_shape.h"
#include "wire/wire_lcm.h"

#include <arpa/inet.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <unistd.h>

/* ---- the other client, whom nothing must disturb ---- */

typedef struct neighbour {
    pid_t daemon;
    collided *c;
    collided_body part;
    heard heard;
} neighbour;

static void neighbour_open(neighbour *n, const char *uri)
{
    n->daemon = rig_daemon(NULL, NULL);
    n->c = rig_connect(uri, 30, COLLIDED_REMOVE);
    rig_box(n->c, "table", 0);
    n->part = rig_box(n->c, "part", 0.5);
    rig_watch(n->c, &n->heard, "part");
    UNTIL(n->c, RIG_PATIENCE_S, n->heard.touching == 1);
}

static void assert_undisturbed(neighbour *n)
{
    int64_t step = n->heard.step + 1;
    assert_int_equal(n->heard.touching, 1);
    assert_int_equal(n->heard.kinds[COLLIDED_END], 0);
    rig_move(n->c, n->part, 0.6, step);
    UNTIL(n->c, RIG_PATIENCE_S, n->heard.step == step);
    assert_int_equal(n->heard.touching, 1);
    assert_int_equal(n->heard.lost, 0);
    assert_true(rig_alive(n->daemon));
}

/* ---- messages, each with one thing wrong ---- */

enum { BODY = 3 }; /* the raw client's one good body, and its number */
static const one_shape box = {
    .pose = {50, 0, 0, 1}, .size = {0.5, 0.5, 0.5}, .in_body = {0, 0, 0, 1}, .type = {WIRE_SHAPE_BOX}};

static wire_message body_message(const char *name)
{
    return one_shape_body(&box, 0, 0, BODY, name);
}

static wire_message pose_message(void)
{
    static const int32_t bodies[1] = {BODY};
    return (wire_message){.kind = WIRE_POSE_BATCH,
        .pose_batch = {.version = WIRE_VERSION,
            .bodies = {1, bodies},
            .positions = {3, box.pose},
            .orientations = {4, box.pose + 3}}};
}

static wire_message nan_position(void)
{
    static const double bad[3] = {0, NAN, 0};
    wire_message m = pose_message();
    m.pose_batch.positions.at = bad;
    return m;
}

static wire_message nan_velocity(void)
{
    static const double bad[3] = {0, NAN, 0};
    wire_message m = pose_message();
    m.pose_batch.linear = (wire_f64s){3, bad};
    return m;
}

static wire_message faster_than_light(void)
{
    static const double bad[3] = {0, 0, -2e9};
    wire_message m = pose_message();
    m.pose_batch.linear = (wire_f64s){3, bad};
    return m;
}

static wire_message absurd_spin(void)
{
    static const double bad[3] = {2e5, 0, 0};
    wire_message m = pose_message();
    m.pose_batch.angular = (wire_f64s){3, bad};
    return m;
}

static wire_message infinite_acceleration(void)
{
    wire_message m = body_message("raw");
    m.body.acceleration_m_s2 = INFINITY;
    return m;
}

static wire_message unknown_ccd(void)
{
    wire_message m = body_message("raw");
    m.body.ccd = WIRE_CCD_FULL + 1;
    return m;
}

static wire_message no_horizon(void)
{
    return (wire_message){.kind = WIRE_SUBSCRIPTION,
        .subscription = {
            .version = WIRE_VERSION, .facts = WIRE_FACT_PREDICT, .stream = "", .select_a = "*", .select_b = "*"}};
}

static wire_message zero_quaternion(void)
{
    static const double bad[4] = {0, 0, 0, 0};
    wire_message m = pose_message();
    m.pose_batch.orientations.at = bad;
    return m;
}

static wire_message wrong_version(void)
{
    wire_message m = pose_message();
    m.pose_batch.version = WIRE_VERSION + 1;
    return m;
}

static wire_message unknown_body(void)
{
    static const int32_t nobody[1] = {BODY + 1};
    wire_message m = pose_message();
    m.pose_batch.bodies.at = nobody;
    return m;
}

static wire_message too_few_positions(void)
{
    wire_message m = pose_message();
    m.pose_batch.positions.count = 2;
    return m;
}

static wire_message another_ones_name(void)
{
    wire_message m = body_message("part");
    m.body.body = BODY + 2;
    return m;
}

static wire_message negative_size(void)
{
    static const double bad[3] = {0.5, -0.5, 0.5};
    wire_message m = body_message("raw");
    m.body.shape_sizes.at = bad;
    return m;
}

static wire_message too_many_poses(void)
{
    enum { MANY = WIRE_POSES_MAX + 1 };
    static int32_t bodies[MANY];
    static double positions[3 * MANY], orientations[4 * MANY];
    for (int i = 0; i < MANY; i++) orientations[4 * i] = 1;
    wire_message m = pose_message();
    m.pose_batch.bodies = (wire_i32s){MANY, bodies};
    m.pose_batch.positions = (wire_f64s){3 * MANY, positions};
    m.pose_batch.orientations = (wire_f64s){4 * MANY, orientations};
    return m;
}

static wire_message too_many_shapes(void)
{
    enum { MANY = WIRE_SHAPES_MAX + 1 };
    static uint8_t types[MANY];
    static double sizes[3 * MANY], radii[MANY], poses[7 * MANY];
    static int64_t geometries[MANY];
    for (int i = 0; i < MANY; i++) radii[i] = poses[7 * i + 3] = 1; /* spheres */
    wire_message m = body_message("raw");
    m.body.shape_types = (wire_u8s){MANY, types};
    m.body.shape_sizes = (wire_f64s){3 * MANY, sizes};
    m.body.shape_radii = (wire_f64s){MANY, radii};
    m.body.shape_poses = (wire_f64s){7 * MANY, poses};
    m.body.shape_geometries = (wire_i64s){MANY, geometries};
    return m;
}

static wire_message bad_stream_name(void)
{
    return (wire_message){.kind = WIRE_SUBSCRIPTION,
        .subscription = {
            .version = WIRE_VERSION, .facts = WIRE_FACT_TOUCH, .stream = "a*b", .select_a = "*", .select_b = "*"}};
}

static void each_fault_over_dds_is_named_to_its_sender_and_counted(void **state)
{
    static const struct {
        wire_message (*make)(void);
        wire_reason reason;
    } cases[] = {
        {nan_position, WIRE_BAD_NUMBER},
        {nan_velocity, WIRE_BAD_NUMBER},
        {faster_than_light, WIRE_TOO_LARGE},
        {absurd_spin, WIRE_TOO_LARGE},
        {infinite_acceleration, WIRE_BAD_NUMBER},
        {unknown_ccd, WIRE_MALFORMED},
        {no_horizon, WIRE_BAD_SIZE},
        {zero_quaternion, WIRE_BAD_ROTATION},
        {wrong_version, WIRE_WRONG_VERSION},
        {unknown_body, WIRE_UNKNOWN_BODY},
        {too_few_positions, WIRE_MALFORMED},
        {another_ones_name, WIRE_NAME_TAKEN},
        {negative_size, WIRE_BAD_SIZE},
        {too_many_poses, WIRE_TOO_LARGE},
        {too_many_shapes, WIRE_TOO_LARGE},
        {bad_stream_name, WIRE_BAD_NAME},
    };
    enum { CASES = sizeof cases / sizeof *cases };
    neighbour n = {0};
    raw_dds raw;
    neighbour_open(&n, *state);
    raw_open(&raw);
    wire_message m = {
        .kind = WIRE_CLIENT, .client = {.version = WIRE_VERSION, .lease_ns = INT64_C(10000000000), .name = "raw"}};
    raw_send(&raw, &m);
    m = body_message("raw");
    raw_send(&raw, &m);
    int64_t expected[WIRE_REASON_COUNT] = {0};
    for (int i = 0; i < CASES; i++) {
        m = cases[i].make();
        wire_reason reason = raw_rejected(&raw, raw_send(&raw, &m));
        if (reason != cases[i].reason)
            fail_msg("case %d: %s, not %s", i, wire_reason_name(reason), wire_reason_name(cases[i].reason));
        expected[reason]++;
    }
    for (wire_reason r = WIRE_OK + 1; r < WIRE_REASON_COUNT; r++) {
        char name[64];
        snprintf(name, sizeof name, "reject_%s", wire_reason_name(r));
        UNTIL(n.c, RIG_PATIENCE_S, rig_counter(n.c, name) == expected[r]);
    }
    assert_undisturbed(&n);
    raw_close(&raw);
    rig_close(n.c);
}

/* ---- over LCM: bytes ---- */

/* All that it sends is to be refused. It waits for that now and then: the gateway's buffer is the kernel's default, and
 * what does not fit is lost. */
typedef struct lcm_sender {
    neighbour *beside;
    int fd;
    struct sockaddr_in to;
    uint32_t number;
} lcm_sender;

enum { AT_ONCE = 100 };

static void await_refusals(const lcm_sender *s)
{
    UNTIL(s->beside->c, RIG_PATIENCE_S, rig_counter(s->beside->c, "lcm_refused") == (int64_t)s->number);
}

static lcm_sender lcm_open(neighbour *beside)
{
    lcm_sender s = {.beside = beside,
        .fd = socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0),
        .to = {.sin_family = AF_INET, .sin_port = htons(7667)}};
    inet_pton(AF_INET, "239.255.76.67", &s.to.sin_addr);
    return s;
}

static void lcm_send(lcm_sender *s, const char *channel, const void *data, size_t bytes)
{
    static uint8_t datagram[65507];
    size_t name = strlen(channel) + 1;
    uint32_t head[2] = {htonl(0x4c433032), htonl(s->number++)};
    assert_true(8 + name + bytes <= sizeof datagram);
    memcpy(datagram, head, 8);
    memcpy(datagram + 8, channel, name);
    memcpy(datagram + 8 + name, data, bytes);
    ssize_t sent = sendto(s->fd, datagram, 8 + name + bytes, 0, (const struct sockaddr *)&s->to, sizeof s->to);
    assert_int_equal(sent, 8 + name + bytes);
    if (s->number % AT_ONCE == 0) await_refusals(s);
}

/* Every cut of a good message. */
static void send_truncated(lcm_sender *s, const uint8_t *bytes, size_t size)
{
    for (size_t n = 0; n < size; n++) lcm_send(s, "collided.in.Body", bytes, n);
}

/* The count of bodies of a PoseBatch (at byte 0x34, see idl/README.md) says far more than there is. */
static void send_huge_counts(lcm_sender *s)
{
    static const uint32_t counts[] = {2, 65536, 65537, 0x10000000, 0x7fffffff, 0x80000000, 0xffffffff};
    enum { COUNTS = sizeof counts / sizeof *counts };
    uint8_t bytes[4096];
    wire_message m = pose_message();
    m.pose_batch.client = RAW_CLIENT;
    m.pose_batch.sequence = 1;
    size_t size = wire_lcm_encode(&m, bytes, sizeof bytes);
    for (int i = 0; i < COUNTS; i++) {
        uint32_t count = htonl(counts[i]);
        memcpy(bytes + 0x34, &count, sizeof count);
        lcm_send(s, "collided.in.PoseBatch", bytes, size);
    }
}

/* Under each channel: noise, and noise behind the right fingerprint. */
static void send_noise(lcm_sender *s)
{
    enum { EACH = 30 };
    uint64_t random = 61;
    for (wire_kind k = WIRE_CLIENT; k <= WIRE_QUERY; k++) {
        char channel[64];
        snprintf(channel, sizeof channel, "collided.in.%s", wire_kind_name(k));
        for (int i = 0; i < EACH; i++) {
            uint64_t words[64];
            for (int w = 0; w < 64; w++) words[w] = prng_bits(&random);
            uint64_t fingerprint = (uint64_t)wire_lcm_fingerprint(k);
            if (i % 2) words[0] = __builtin_bswap64(fingerprint);
            lcm_send(s, channel, words, 8 + prng_bits(&random) % (sizeof words - 8));
        }
    }
}

static void malformed_datagrams_are_refused_and_end_nobody(void **state)
{
    neighbour n = {0};
    uint8_t bytes[4096];
    neighbour_open(&n, *state);
    pid_t gateway = rig_child(n.daemon);
    lcm_sender s = lcm_open(&n);
    wire_message m = body_message("raw");
    m.body.client = RAW_CLIENT;
    m.body.sequence = 1;
    send_truncated(&s, bytes, wire_lcm_encode(&m, bytes, sizeof bytes));
    send_huge_counts(&s);
    send_noise(&s);
    await_refusals(&s);
    assert_int_equal(rig_child(n.daemon), gateway);
    assert_int_equal(rig_counter(n.c, "lcm_gateway_restarts"), 0);
    assert_int_equal(rig_counter(n.c, "bodies"), 2);
    assert_undisturbed(&n);
    rig_close(n.c);
    close(s.fd);
}

int main(void)
{
    const struct CMUnitTest tests[] = {OVER(each_fault_over_dds_is_named_to_its_sender_and_counted, RIG_DDS),
        OVER_BOTH(malformed_datagrams_are_refused_and_end_nobody)};
    rig_isolate();
    return cmocka_run_group_tests(tests, NULL, NULL);
}
