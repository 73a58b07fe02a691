/* memory_limit: what the machine grants, what is refused where it is near, and that a tick does not grow beyond it. The
 * daemon runs in this process: memory that the test itself takes counts like its own. */
#include "cell.h"

#include "service/memory.h"

#include <malloc.h>
#include <stdio.h>
#include <stdlib.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
enum { IS_SANITIZED = 1 }; /* what is freed stays for a while, and all is larger */
#else
enum { IS_SANITIZED = 0 };
#endif

enum { ALICE = 11, BOB = 22, MIB = 1 << 20 };

/* ---- what is granted ---- */

static char root[64];

static void write_file(const char *path, const char *text)
{
    char at[256];
    snprintf(at, sizeof at, "%s%s", root, path);
    for (char *slash = strchr(at + 1, '/'); slash; slash = strchr(slash + 1, '/')) {
        *slash = '\0';
        mkdir(at, 0700);
        *slash = '/';
    }
    FILE *f = fopen(at, "we");
    assert_non_null(f);
    fputs(text, f);
    fclose(f);
}

static void clear_root(void)
{
    char command[128];
    snprintf(command, sizeof command, "rm -rf -- %s", root);
    assert_int_equal(system(command), 0); /* NOLINT(cert-env33-c): a name of mkdtemp's */
    assert_int_equal(mkdir(root, 0700), 0);
}

static void the_least_of_machine_and_cgroups_counts(void **state)
{
    (void)state;
    snprintf(root, sizeof root, "/tmp/granted.XXXXXX");
    assert_non_null(mkdtemp(root));
    int64_t machine = memory_granted(root);
    assert_true(machine > 64 * MIB);

    write_file("/proc/self/cgroup", "0::/system.slice/collided.service\n");
    assert_int_equal(memory_granted(root), machine);
    write_file("/sys/fs/cgroup/system.slice/collided.service/memory.max", "max\n");
    assert_int_equal(memory_granted(root), machine);
    write_file("/sys/fs/cgroup/system.slice/collided.service/memory.max", "52428800\n");
    assert_int_equal(memory_granted(root), 52428800);
    write_file("/sys/fs/cgroup/system.slice/memory.max", "41943040\n"); /* of all in there */
    assert_int_equal(memory_granted(root), 41943040);
    write_file(
        "/sys/fs/cgroup/system.slice/collided.service/memory.high", "31457280\n"); /* from here on it is slowed */
    assert_int_equal(memory_granted(root), 31457280);

    clear_root(); /* a container: its own group is the top of what it sees */
    write_file("/proc/self/cgroup", "0::/\n");
    write_file("/sys/fs/cgroup/memory.max", "20971520\n");
    assert_int_equal(memory_granted(root), 20971520);
    write_file("/proc/self/cgroup", "0::/docker/0123456789\n"); /* told by the host's name, which is not there */
    assert_int_equal(memory_granted(root), 20971520);

    clear_root(); /* version 1 */
    write_file("/proc/self/cgroup", "12:cpu,cpuacct:/x\n5:memory:/docker/0123\n1:name=systemd:/x\n");
    write_file("/sys/fs/cgroup/memory/docker/0123/memory.limit_in_bytes", "9223372036854771712\n");
    assert_int_equal(memory_granted(root), machine);
    write_file("/sys/fs/cgroup/memory/docker/0123/memory.limit_in_bytes", "10485760\n");
    assert_int_equal(memory_granted(root), 10485760);
    clear_root();
    assert_int_equal(rmdir(root), 0);
}

/* ---- a room with a limit ---- */

typedef struct room {
    cell *cell;
    memory_end *end;
    wire_memory *memory;
    int64_t sequence;
} room;

static int64_t of_status_file(const char *key)
{
    char line[256];
    long long kb = 0;
    FILE *f = fopen("/proc/self/status", "re");
    assert_non_null(f);
    while (fgets(line, sizeof line, f))
        if (strncmp(line, key, strlen(key)) == 0) kb = strtoll(line + strlen(key) + 1, NULL, 10);
    fclose(f);
    return kb * 1024;
}

static config with_room(long mib)
{
    config c = cell_config();
    malloc_trim(0); /* what tests before have left */
    c.memory_limit = (long)(of_status_file("VmRSS") / MIB) + mib;
    return c;
}

static void room_open(room *r, const config *c)
{
    *r = (room){.cell = cell_start(c), .memory = wire_memory_create()};
    r->end = cell_client(r->cell);
    cell_hello(r->end, ALICE, ++r->sequence, 60, WIRE_LOST_REMOVE);
    cell_hello(r->end, BOB, ++r->sequence, 60, WIRE_LOST_REMOVE);
    cell_settle(r->end, r->memory, BOB, ++r->sequence);
}

static void room_close(room *r)
{
    memory_disconnect(r->end);
    assert_int_equal(cell_stop(r->cell), 0);
    wire_memory_destroy(r->memory);
}

static void put(room *r, int32_t body, double x)
{
    char name[32];
    snprintf(name, sizeof name, "b%d", (int)body);
    cell_sphere(r->end, ALICE, ++r->sequence, body, name, x);
}

static void remove_body(room *r, int32_t body)
{
    wire_message m = {.kind = WIRE_BODY,
        .body = {.version = WIRE_VERSION,
            .client = ALICE,
            .sequence = ++r->sequence,
            .body = body,
            .removed = 1,
            .name = "",
            .group = ""}};
    memory_send(r->end, &m);
}

static void expect_refusal(room *r, wire_kind kind)
{
    wire_message m = cell_await(r->end, r->memory, WIRE_REJECT);
    assert_int_equal(m.reject.reason, WIRE_LIMIT);
    assert_int_equal(m.reject.kind, kind);
    if (!strstr(m.reject.text, "memory_limit = ")) fail_msg("\"%s\" does not name memory_limit", m.reject.text);
}

static void send_mesh_piece(room *r)
{
    static const double vertices[9] = {0, 0, 0, 1, 0, 0, 0, 1, 0};
    static const int32_t indices[3] = {0, 1, 2};
    wire_message m = {.kind = WIRE_GEOMETRY,
        .geometry = {.version = WIRE_VERSION,
            .client = ALICE,
            .sequence = ++r->sequence,
            .kind = WIRE_GEOMETRY_MESH,
            .hash = wire_geometry_hash(WIRE_GEOMETRY_MESH, (wire_f64s){9, vertices}, (wire_i32s){3, indices}),
            .vertex_numbers = 9,
            .index_numbers = 3,
            .pieces = 1,
            .vertices = {9, vertices},
            .indices = {3, indices}}};
    memory_send(r->end, &m);
}

static void query(room *r)
{
    wire_message m = {.kind = WIRE_QUERY,
        .query = {.version = WIRE_VERSION,
            .client = BOB,
            .sequence = ++r->sequence,
            .kind = WIRE_QUERY_BODIES,
            .name_a = "*",
            .name_b = ""}};
    memory_send(r->end, &m);
}

static void await_status(room *r, bool degraded, wire_message *m)
{
    do {
        *m = cell_await(r->end, r->memory, WIRE_STATUS);
    } while ((m->status.health == WIRE_HEALTH_DEGRADED) != degraded);
}

/* Poses of what is there go on, and what they bring about is told. */
static void what_would_grow_is_refused_by_name_and_poses_go_on(void **state)
{
    enum { ROOM = 96, BALLAST = 128 };
    (void)state;
    room r;
    wire_message m;
    config c = with_room(ROOM);
    room_open(&r, &c);
    put(&r, 0, 0);
    put(&r, 1, 10);
    cell_touches(r.end, BOB, ++r.sequence, 0);
    cell_settle(r.end, r.memory, BOB, ++r.sequence);

    void *ballast =
        mmap(NULL, (size_t)BALLAST * MIB, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS | MAP_POPULATE, -1, 0);
    assert_ptr_not_equal(ballast, MAP_FAILED);
    usleep(50000); /* a look is good for 10 ms */
    put(&r, 2, 20);
    expect_refusal(&r, WIRE_BODY);
    send_mesh_piece(&r);
    expect_refusal(&r, WIRE_GEOMETRY);
    cell_touches(r.end, ALICE, ++r.sequence, 0);
    expect_refusal(&r, WIRE_SUBSCRIPTION);
    cell_hello(r.end, 33, ++r.sequence, 60, WIRE_LOST_REMOVE);
    expect_refusal(&r, WIRE_CLIENT);
    query(&r);
    expect_refusal(&r, WIRE_QUERY);
    await_status(&r, true, &m);
    assert_non_null(strstr(m.status.limits, "memory_limit"));
    assert_true(cell_counter(&m.status, "memory_refused") >= 5);
    assert_true(cell_counter(&m.status, "reject_limit") >= 5);
    assert_int_equal(cell_counter(&m.status, "memory_limit_bytes"), (int64_t)c.memory_limit * MIB);
    assert_true(cell_counter(&m.status, "memory_resident_bytes") >= (int64_t)BALLAST * MIB);
    cell_pose(r.end, ALICE, ++r.sequence, 1, 0.5); /* they meet */
    do {
        m = cell_await(r.end, r.memory, WIRE_EVENT_BATCH);
    } while (!m.event_batch.kinds.count || m.event_batch.kinds.at[0] != WIRE_EVENT_BEGIN);
    cell_hello(r.end, ALICE, ++r.sequence, 60, WIRE_LOST_REMOVE); /* who is there may say so */
    remove_body(&r, 1);
    do {
        m = cell_await(r.end, r.memory, WIRE_EVENT_BATCH);
    } while (!m.event_batch.kinds.count || m.event_batch.kinds.at[0] != WIRE_EVENT_END);

    munmap(ballast, (size_t)BALLAST * MIB);
    usleep(50000);
    put(&r, 2, 20);
    cell_settle(r.end, r.memory, BOB, ++r.sequence);
    do {
        m = cell_await(r.end, r.memory, WIRE_STATUS);
    } while (cell_counter(&m.status, "bodies") != 2);
    room_close(&r);
}

/* ---- shares ---- */

static bool is_refused(room *r, int64_t client)
{
    wire_message m;
    bool refused = false;
    for (wire_memory_reset(r->memory); memory_receive(r->end, r->memory, &m); wire_memory_reset(r->memory))
        refused |= m.kind == WIRE_REJECT && m.reject.client == client;
    return refused;
}

/* One participant may take what there is, but for a share: another one comes in, and announces a body. */
static void who_has_much_leaves_a_share_to_others(void **state)
{
    enum { ROOM = 160, MOST = 300000, AT_ONCE = 256, CAROL = 77 };
    (void)state;
    room r;
    if (IS_SANITIZED) skip();
    config c = with_room(ROOM);
    room_open(&r, &c);
    int32_t body = 0;
    while (body < MOST && !is_refused(&r, ALICE)) {
        for (int i = 0; i < AT_ONCE; i++, body++) put(&r, body, 5.0 * body);
        usleep(2000);
    }
    assert_true(body < MOST);
    cell_settle(r.end, r.memory, BOB, ++r.sequence);
    memory_end *other = cell_client(r.cell);
    cell_hello(other, CAROL, 1, 60, WIRE_LOST_REMOVE);
    cell_sphere(other, CAROL, 2, 0, "carol", -50);
    cell_settle(other, r.memory, CAROL, 3);
    cell_await(r.end, r.memory, WIRE_STATUS);
    wire_message m = cell_await(r.end, r.memory, WIRE_STATUS);
    assert_int_equal(cell_counter(&m.status, "clients"), 3);
    int64_t resident = cell_counter(&m.status, "memory_resident_bytes"), limit = (int64_t)c.memory_limit * MIB;
    if (resident >= limit / 100 * 90)
        fail_msg("%lld of %lld bytes are resident", (long long)resident, (long long)limit);
    memory_disconnect(other);
    room_close(&r);
}

/* ---- in a tick ---- */

enum { BALLS = 800, ALL = BALLS * (BALLS - 1) / 2 };

/* All in one batch: poses of bodies that are there are always taken. */
static void place(room *r, double step)
{
    static int32_t bodies[BALLS];
    static double positions[3 * BALLS], orientations[4 * BALLS];
    for (int32_t i = 0; i < BALLS; i++) {
        bodies[i] = i;
        positions[3 * i] = step * i;
        orientations[4 * i] = 1;
    }
    wire_message m = {.kind = WIRE_POSE_BATCH,
        .pose_batch = {.version = WIRE_VERSION,
            .client = ALICE,
            .sequence = ++r->sequence,
            .bodies = {BALLS, bodies},
            .positions = {3 * BALLS, positions},
            .orientations = {4 * BALLS, orientations}}};
    memory_send(r->end, &m);
}

static void open_crowd(room *r, const config *c)
{
    room_open(r, c);
    for (int i = 0; i < BALLS; i++) put(r, i, 10.0 * i);
    cell_touches(r->end, BOB, ++r->sequence, 0);
    cell_settle(r->end, r->memory, BOB, ++r->sequence);
}

/* All at one place, in one tick: without a limit 320,000 pairs and contacts, of 1.2 KB each. */
static void a_tick_does_not_grow_beyond_it(void **state)
{
    (void)state;
    if (IS_SANITIZED) skip();
    room r;
    wire_message m;
    char path[64];
    snprintf(path, sizeof path, "/tmp/memory-%d.lcmlog", (int)getpid());
    config c = with_room(96);
    snprintf(c.record, sizeof c.record, "%s", path);
    c.record_events = false;
    open_crowd(&r, &c);
    place(&r, 0);
    int64_t there = 0, before;
    int same = 0;
    do { /* until no more come, tick by tick; what is left out may not even be counted then */
        m = cell_await(r.end, r.memory, WIRE_STATUS);
        before = there;
        there = cell_counter(&m.status, "pairs");
        same = there > 1000 && there == before ? same + 1 : 0;
    } while (same < 10);
    assert_true(there < ALL && cell_counter(&m.status, "pairs_left_out") > 0);
    await_status(&r, true, &m);
    assert_non_null(strstr(m.status.limits, "memory_limit"));
    assert_null(strstr(m.status.limits, "max_pairs"));
    int64_t most = of_status_file("VmHWM");
    /* Boxes that meet are known to the broad phase, 50 bytes a pair, whether they are looked at or not; and what this
     * test, which shares the process, has not read yet waits in its link, up to 32 MiB. */
    if (most > ((int64_t)c.memory_limit + 32) * MIB + 50 * (int64_t)ALL)
        fail_msg("%ld MiB were resident, %ld are the limit", (long)(most / MIB), c.memory_limit);

    for (int i = 4; i < BALLS; i++) remove_body(&r, i); /* the others come in */
    do {
        m = cell_await(r.end, r.memory, WIRE_STATUS);
    } while (cell_counter(&m.status, "pairs") != 6 || cell_counter(&m.status, "pairs_left_out"));
    room_close(&r);
    assert_int_equal(cell_replay(path, 1, true), 0);
    assert_int_equal(cell_replay(path, 3, false), 0);
    unlink(path);
}

/* What one made grow can be had by others once he is gone. */
static void memory_comes_back(void **state)
{
    (void)state;
    if (IS_SANITIZED) skip();
    room r;
    wire_message m;
    config c = with_room(96);
    open_crowd(&r, &c);
    for (int round = 0; round < 3; round++) {
        place(&r, 0);
        do {
            m = cell_await(r.end, r.memory, WIRE_STATUS);
        } while (!cell_counter(&m.status, "pairs_left_out"));
        place(&r, 10);
        do {
            m = cell_await(r.end, r.memory, WIRE_STATUS);
        } while (cell_counter(&m.status, "pairs"));
        for (int tries = 0;; tries++) { /* memory is given back once a second */
            int64_t refused = cell_counter(&m.status, "memory_refused");
            put(&r, BALLS, -10);
            m = cell_await(r.end, r.memory, WIRE_STATUS);
            m = cell_await(r.end, r.memory, WIRE_STATUS);
            if (cell_counter(&m.status, "memory_refused") == refused) break;
            if (tries > 60) fail_msg("nothing is let in any more");
            usleep(300000);
        }
    }
    room_close(&r);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_least_of_machine_and_cgroups_counts),
        cmocka_unit_test(a_tick_does_not_grow_beyond_it), /* before others: the most that was ever resident counts */
        cmocka_unit_test(what_would_grow_is_refused_by_name_and_poses_go_on),
        cmocka_unit_test(memory_comes_back),
        cmocka_unit_test(who_has_much_leaves_a_share_to_others),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
