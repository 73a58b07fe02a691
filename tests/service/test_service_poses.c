/* Poses that come late: by their sequence they are counted, by their stamp they are refused; what begins anew is
 * neither. */
#include "cell.h"
#include "wire/one_shape.h"

#include <unistd.h>

enum { ALICE = 11 };

typedef struct room {
    cell *cell;
    memory_end *alice;
    wire_memory *memory;
    int64_t sequence; /* the last one */
} room;

static int open_room(void **state)
{
    static room r;
    config c = cell_config();
    r = (room){.cell = cell_start(&c), .memory = wire_memory_create(), .sequence = 1};
    r.alice = cell_client(r.cell);
    cell_hello(r.alice, ALICE, r.sequence, 60, WIRE_LOST_KEEP);
    *state = &r;
    return 0;
}

static int close_room(void **state)
{
    room *r = *state;
    memory_disconnect(r->alice);
    int status = cell_stop(r->cell);
    wire_memory_destroy(r->memory);
    return status;
}

/* Both bodies of the client, the first one at x. */
static void send_poses(room *r, int64_t sequence, int64_t stamp_ns, double x, bool first_teleports)
{
    const int32_t bodies[2] = {0, 1};
    const double positions[6] = {x, 0, 0, 50 + x, 0, 0}, orientations[8] = {1, 0, 0, 0, 1, 0, 0, 0};
    const uint8_t teleports[2] = {1, 0};
    wire_message m = {.kind = WIRE_POSE_BATCH,
        .pose_batch = {.version = WIRE_VERSION,
            .client = ALICE,
            .sequence = sequence,
            .stamp_ns = stamp_ns,
            .bodies = {2, bodies},
            .positions = {6, positions},
            .orientations = {8, orientations},
            .teleports = {first_teleports ? 2 : 0, teleports}}};
    memory_send(r->alice, &m);
}

static void announce(room *r)
{
    cell_sphere(r->alice, ALICE, ++r->sequence, 0, "a", 0);
    cell_sphere(r->alice, ALICE, ++r->sequence, 1, "b", 50);
}

/* All that was sent has been applied, in two states that came behind it. */
static int64_t counter(room *r, const char *name)
{
    cell_await(r->alice, r->memory, WIRE_STATUS);
    wire_message m = cell_await(r->alice, r->memory, WIRE_STATUS);
    return cell_counter(&m.status, name);
}

static void poses_stand(room *r, int64_t moves, int64_t old, int64_t late)
{
    assert_int_equal(counter(r, "moves"), moves);
    assert_int_equal(counter(r, "reject_old_pose"), old);
    assert_int_equal(counter(r, "late_poses"), late);
}

static void await_all(room *r, int64_t moves)
{
    for (int k = 0; k < 100; k++)
        if (counter(r, "moves") >= moves) return;
    fail_msg("the poses do not come");
}

/* A newer word with an older stamp is refused by name, and the body keeps its pose. */
static void a_pose_with_an_older_stamp_is_refused(void **state)
{
    room *r = *state;
    announce(r);
    send_poses(r, ++r->sequence, 2000, 1, false);
    await_all(r, 2);
    send_poses(r, ++r->sequence, 1000, 2, false);
    wire_message m = cell_await(r->alice, r->memory, WIRE_REJECT);
    assert_int_equal(m.reject.reason, WIRE_OLD_POSE);
    assert_int_equal(m.reject.kind, WIRE_POSE_BATCH);
    assert_int_equal(m.reject.object, 0);
    assert_non_null(strstr(m.reject.text, "2 of 2 bodies"));
    poses_stand(r, 2, 1, 0);

    send_poses(r, r->sequence, 2000, 3, false); /* its sequence was not used up: the same stamp is not older */
    await_all(r, 4);
    send_poses(r, r->sequence, 1500, 3, false); /* a repeated batch is late, whatever its stamp: told once, not twice */
    poses_stand(r, 4, 1, 2);
}

/* As a client announces a body to which it gave no stamp; or with the stamp of its pose. */
static void announce_at(room *r, int64_t stamp_ns, bool is_now)
{
    one_shape s = one_shape_at(WIRE_SHAPE_SPHERE, 0);
    s.radius[0] = 1;
    for (int32_t i = 0; i < 2; i++) {
        wire_message m = one_shape_body(&s, ALICE, ++r->sequence, i, i ? "b" : "a");
        m.body.stamp_ns = stamp_ns;
        m.body.stamp_is_now = is_now;
        memory_send(r->alice, &m);
    }
}

/* Poses are by a simulator's clock, or have been on their way. From the first one on stamps order them, and so does a
 * stamp that was given. */
static void when_a_body_was_announced_makes_no_pose_old(void **state)
{
    room *r = *state;
    const int64_t announced_ns = 1000000000;
    announce_at(r, announced_ns, true);
    send_poses(r, ++r->sequence, 2000, 1, false);
    await_all(r, 2);
    send_poses(r, ++r->sequence, 1000, 2, false);
    assert_int_equal(cell_await(r->alice, r->memory, WIRE_REJECT).reject.reason, WIRE_OLD_POSE);
    send_poses(r, ++r->sequence, announced_ns - 1, 3, false);
    poses_stand(r, 4, 1, 0);
    announce_at(r, announced_ns, true); /* anew */
    send_poses(r, ++r->sequence, 3000, 4, false);
    poses_stand(r, 6, 1, 0);
    announce_at(r, announced_ns, false);
    send_poses(r, ++r->sequence, 4000, 5, false);
    assert_int_equal(cell_await(r->alice, r->memory, WIRE_REJECT).reject.reason, WIRE_OLD_POSE);
    poses_stand(r, 6, 2, 0);
}

/* The one that teleports goes back in time, the other one of the batch is refused. */
static void a_teleport_may_go_back_in_time(void **state)
{
    room *r = *state;
    announce(r);
    send_poses(r, ++r->sequence, 2000, 1, false);
    await_all(r, 2);
    send_poses(r, ++r->sequence, 1000, 2, true);
    wire_message m = cell_await(r->alice, r->memory, WIRE_REJECT);
    assert_true(m.reject.reason == WIRE_OLD_POSE && m.reject.object == 1);
    poses_stand(r, 3, 1, 0);
    send_poses(r, ++r->sequence, 1500, 3, false); /* after what it was put back to */
    m = cell_await(r->alice, r->memory, WIRE_REJECT);
    assert_true(m.reject.reason == WIRE_OLD_POSE && m.reject.object == 1);
    poses_stand(r, 4, 2, 0);
}

/* Of one body's two poses in a batch the first counts, refused or not; the other one is told as late. */
static void a_body_stands_in_a_batch_once(void **state)
{
    room *r = *state;
    announce(r);
    send_poses(r, ++r->sequence, 2000, 1, false);
    await_all(r, 2);
    const int32_t bodies[2] = {0, 0};
    const double positions[6] = {2, 0, 0, 3, 0, 0}, orientations[8] = {1, 0, 0, 0, 1, 0, 0, 0};
    const uint8_t teleports[2] = {0, 1};
    wire_message m = {.kind = WIRE_POSE_BATCH,
        .pose_batch = {.version = WIRE_VERSION,
            .client = ALICE,
            .sequence = ++r->sequence,
            .stamp_ns = 1000,
            .bodies = {2, bodies},
            .positions = {6, positions},
            .orientations = {8, orientations},
            .teleports = {2, teleports}}};
    memory_send(r->alice, &m);
    wire_message told = cell_await(r->alice, r->memory, WIRE_REJECT);
    assert_true(told.reject.reason == WIRE_OLD_POSE && told.reject.object == 0);
    poses_stand(r, 2, 1, 1);
}

/* A simulator that begins at 0 again announces its bodies anew: their stamps begin again as well. */
static void a_body_that_is_announced_again_begins_its_time_anew(void **state)
{
    room *r = *state;
    announce(r);
    send_poses(r, ++r->sequence, 2000, 1, false);
    await_all(r, 2);
    announce(r);
    send_poses(r, ++r->sequence, 10, 2, false);
    await_all(r, 4);
    poses_stand(r, 4, 0, 0);
}

/* Its copy changes nothing: LCM repeats what was not acknowledged. */
static void a_copy_of_the_announcement_does_not(void **state)
{
    room *r = *state;
    announce(r);
    int64_t last = r->sequence;
    send_poses(r, ++r->sequence, 2000, 1, false);
    await_all(r, 2);
    cell_sphere(r->alice, ALICE, last - 1, 0, "a", 0);
    cell_sphere(r->alice, ALICE, last, 1, "b", 50);
    send_poses(r, ++r->sequence, 1000, 2, false);
    wire_message m = cell_await(r->alice, r->memory, WIRE_REJECT);
    assert_int_equal(m.reject.reason, WIRE_OLD_POSE);
    poses_stand(r, 2, 1, 0);
}

/* The client comes back under its id, its sequences and stamps go on; then with no stamps, which are never older. */
static void a_client_that_comes_back_goes_on(void **state)
{
    room *r = *state;
    announce(r);
    send_poses(r, ++r->sequence, 2000, 1, false);
    await_all(r, 2);
    memory_disconnect(r->alice);
    r->alice = cell_client(r->cell);
    cell_hello(r->alice, ALICE, ++r->sequence, 60, WIRE_LOST_KEEP);
    send_poses(r, ++r->sequence, 1999, 2, false);
    wire_message m = cell_await(r->alice, r->memory, WIRE_REJECT);
    assert_int_equal(m.reject.reason, WIRE_OLD_POSE);
    send_poses(r, ++r->sequence, 2001, 2, false);
    await_all(r, 4);
    send_poses(r, ++r->sequence, 0, 3, false);
    await_all(r, 6);
    send_poses(r, ++r->sequence, 5, 4, false); /* nothing is known of the age of the one before */
    await_all(r, 8);
    poses_stand(r, 8, 1, 0);
}

/* A new process under the same id, whose clock was set back, and whose announcement was taken before the last poses of
 * the one before: it hears of their number, and goes on from there. */
static void poses_below_those_that_came_are_told_so(void **state)
{
    room *r = *state;
    announce(r);
    send_poses(r, 5000, 0, 1, false);
    await_all(r, 2);
    cell_hello(r->alice, ALICE, ++r->sequence, 60, WIRE_LOST_KEEP);
    cell_await(r->alice, r->memory, WIRE_ACK);
    send_poses(r, ++r->sequence, 0, 2, false);
    wire_message m = cell_await(r->alice, r->memory, WIRE_ACK);
    assert_int_equal(m.ack.sequences.count, 1);
    assert_int_equal(m.ack.sequences.at[0], 5000);
    poses_stand(r, 2, 0, 2);
}

static void send_spaced(room *r, int count)
{
    for (int k = 0; k < count; k++) {
        send_poses(r, ++r->sequence, 0, 0.001 * k, false);
        usleep(2000);
    }
}

/* On the thread that sends them, here; what comes with commands is the tick thread's, and neither loses any. */
static void poses_alone_are_ticked_where_they_arrive(void **state)
{
    room *r = *state;
    announce(r);
    int64_t sent = 0;
    for (; sent < 10000 && !counter(r, "ticks_on_arrival"); sent += 50) send_spaced(r, 50); /* once the start is over */
    assert_true(counter(r, "ticks_on_arrival") > 0);
    for (int k = 0; k < 50; k++, sent++) {
        cell_sphere(r->alice, ALICE, ++r->sequence, 2, "c", 100 + k);
        send_poses(r, ++r->sequence, 0, 0.001 * k, false);
    }
    await_all(r, 2 * sent);
    poses_stand(r, 2 * sent, 0, 0);
}

#define IN_A_ROOM(test) cmocka_unit_test_setup_teardown(test, open_room, close_room)

int main(void)
{
    const struct CMUnitTest tests[] = {
        IN_A_ROOM(a_pose_with_an_older_stamp_is_refused),
        IN_A_ROOM(when_a_body_was_announced_makes_no_pose_old),
        IN_A_ROOM(a_teleport_may_go_back_in_time),
        IN_A_ROOM(a_body_stands_in_a_batch_once),
        IN_A_ROOM(a_body_that_is_announced_again_begins_its_time_anew),
        IN_A_ROOM(a_copy_of_the_announcement_does_not),
        IN_A_ROOM(a_client_that_comes_back_goes_on),
        IN_A_ROOM(poses_below_those_that_came_are_told_so),
        IN_A_ROOM(poses_alone_are_ticked_where_they_arrive),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
