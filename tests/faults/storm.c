/* A storm: owners that move, remove and put back bodies, and listeners, over both links, are killed, stopped and let go
 * on at random moments, and so are the daemon and its gateway. All the time each listener holds what it is told against
 * a model (storm_model.h); once it is quiet, all of them, and one that comes fresh, must know the same contacts as a
 * comparison of all bodies with all others. Their wall clock is set back and forth by up to an hour at a time.
 *
 * "storm pair": there are two daemons, each of which may be struck at any time, and who was killed comes back as the
 * standby of the other. "storm network": nobody is struck but the network between two hosts. "storm all": everybody and
 * the network at once, and the daemon is made to record onto a disk that is full at times.
 *
 * 40 s each, but all at once 120 s; 120 s and an hour with COLLIDED_NIGHTLY=1, 7 s with COLLIDED_BRIEF=1, or
 * COLLIDED_STORM_SECONDS. The seed is random
 * and printed; COLLIDED_STORM_SEED sets it. (It sets what is done, and in which order; processes have their own time.)
 */
#include "rig.h"
#include "storm_model.h"
#include "storm_network.h"

#include <errno.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/mount.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>

#define LEASE_S 0.6
#define SETTLE_S 60

enum { SIDE = 12, SHARED_FD = 40 }; /* of the square that bodies are in, in grid steps */

/* The network between two hosts: the daemon and we are on one, all others on the other. NULL: all are on one. */
static storm_network *network;
static const char *interface;

static const char *link_of(int k)
{
    static const char *const far[] = {"dds://62", "lcm://udpm://239.255.76.67:7667?ttl=1"};
    return interface ? far[k % 2] : k % 2 ? RIG_LCM : RIG_DDS;
}

/* ---- owners ---- */

typedef struct owner {
    storm_owner *shared;
    collided *c;
    int number, life;
    bool known; /* the same client, bodies and names in each life */
    uint64_t random;
    int64_t step;
    collided_status status;
    collided_body bodies[STORM_BODIES];
} owner;

static void put(owner *o, int i)
{
    char name[32];
    storm_name(name, o->number, o->life, i);
    double *at = o->shared->place[i];
    for (int k = 0; k < 2; k++) at[k] = STORM_GRID_M * (double)(storm_random(&o->random) % SIDE);
    collided_shape ball = collided_sphere(0.5);
    collided_body_def def = collided_body_def_default();
    if (o->known) def.id = i;
    def.name = name;
    def.pose.position[0] = at[0];
    def.pose.position[1] = at[1];
    def.shapes = &ball;
    def.shape_count = 1;
    o->bodies[i] = collided_create_body(o->c, &def);
    if (o->bodies[i].id == COLLIDED_NONE) abort();
    o->shared->there[i] = true;
}

static void change(owner *o, int i)
{
    uint64_t what = storm_random(&o->random) % 64;
    double *at = o->shared->place[i];
    if (!o->shared->there[i]) {
        if (what < 8) put(o, i);
    } else if (what == 0 && !o->known) {
        collided_remove_body(o->c, o->bodies[i]);
        o->shared->there[i] = false;
    } else if (what < 16) {
        double to = at[what % 2] + (what % 4 < 2 ? STORM_GRID_M : -STORM_GRID_M);
        at[what % 2] = to < 0 ? 0 : to > STORM_GRID_M * SIDE ? STORM_GRID_M * SIDE : to;
    }
}

static void publish(owner *o)
{
    collided_body bodies[STORM_BODIES];
    double positions[3 * STORM_BODIES] = {0}, orientations[4 * STORM_BODIES] = {0};
    size_t n = 0;
    for (int i = 0; i < STORM_BODIES; i++) {
        if (!o->shared->there[i]) continue;
        bodies[n] = o->bodies[i];
        memcpy(positions + 3 * n, o->shared->place[i], sizeof o->shared->place[i]);
        orientations[4 * n++] = 1;
    }
    collided_status status =
        n ? collided_publish(o->c, n, bodies, positions, orientations, NULL, NULL, 0, ++o->step) : COLLIDED_OK;
    if (status != COLLIDED_OK && status != o->status) fprintf(stderr, "o%d: %s\n", o->number, collided_error(o->c));
    o->status = status;
}

static collided *connect_without_waiting(const char *uri, int64_t id, collided_on_loss on_loss)
{
    collided_def def = collided_def_default();
    def.lease_s = LEASE_S;
    def.on_loss = on_loss;
    def.id = id;
    def.connect_timeout_s = 0;
    def.interface = interface;
    collided *c = collided_connect(uri, &def);
    if (!c) {
        fprintf(stderr, "%s: %s\n", uri, collided_connect_error());
        exit(3);
    }
    return c;
}

/* Half of them come back under the id that they had, and find what was held for them. */
static void own(storm_shared *s, int number)
{
    storm_owner *shared = &s->owners[number];
    uint64_t seed = (uint64_t)(shared->starts * STORM_OWNERS + number);
    bool known = storm_known(number);
    owner o = {.shared = shared, .number = number, .life = shared->life, .known = known, .random = storm_random(&seed)};
    o.c = connect_without_waiting(link_of(number), known ? number + 1 : 0, known ? COLLIDED_HOLD : COLLIDED_REMOVE);
    for (int i = 0; i < STORM_BODIES; i++) put(&o, i);
    for (;;) {
        bool quiet = s->quiet;
        for (int i = 0; i < STORM_BODIES && !quiet; i++) change(&o, i);
        publish(&o);
        shared->quiet = quiet;
        for (double end = rig_now_s() + (quiet ? 0.1 : 0.02); rig_now_s() < end;) collided_poll(o.c, 0.01);
    }
}

static void listen_only(storm_shared *s, int number)
{
    collided *c = connect_without_waiting(link_of(number), 0, COLLIDED_REMOVE);
    storm_listen(c, &s->listeners[number]);
    for (;;) collided_poll(c, 0.1);
}

/* ---- whom the storm strikes ---- */

enum { DAEMON = STORM_OWNERS + STORM_LISTENERS, STANDBY, VICTIMS };

static bool paired, combined;
/* What the daemon records onto in a combined storm: a file system of DISK_KIB, with a file in it that takes the room.
 * "": there is none. */
static char disk[64];
enum { DISK_KIB = 1024 };

typedef struct storm {
    storm_shared *shared;
    uint64_t random, seed;
    pid_t pids[VICTIMS];     /* 0 = killed, to be started again */
    double again_s[VICTIMS]; /* when: to be started, or let go on; 0 = it runs */
    pid_t gateway;           /* that stands still until then */
    double gateway_s;
    collided *c[2]; /* of ours: one a link, whom nothing strikes but by others */
    storm_model *models[2];
    char host[16];             /* of the others: the process that has it, or "" */
    _Atomic int64_t *clock_ns; /* the wall clock of all but us is set by so much */
    size_t clock_steps, kills, stops, daemon_kills, gateway_kills, recordings, full_disks;
} storm;

static uint64_t roll(storm *s, uint64_t sides)
{
    return storm_random(&s->random) % sides;
}

static pid_t far_daemon(void)
{
    char links[128];
    snprintf(links, sizeof links, "%s %s", link_of(0), link_of(1));
    const char *const arguments[] = {"collided", "--links", links, "--interface", interface, "--status-period", "0.1",
        "--workers", "1", "--log", "warning", "--heartbeat", "0.2", *disk ? "--record_dir" : NULL, disk, NULL};
    rig_need_network();
    return rig_start(COLLIDED, arguments);
}

static void start(storm *s, int k)
{
    char number[16];
    s->again_s[k] = 0;
    if (k >= DAEMON) {
        s->pids[k] = interface ? far_daemon() : rig_daemon("--heartbeat=0.2", paired ? "--standby=yes" : NULL);
        return;
    }
    bool owns = k < STORM_OWNERS;
    int index = owns ? k : k - STORM_OWNERS;
    if (owns) {
        storm_owner *o = &s->shared->owners[index];
        memset(o->there, 0, sizeof o->there);
        o->quiet = 0;
        o->starts++;
        if (!storm_known(index)) o->life++;
    }
    snprintf(number, sizeof number, "%d", index);
    s->pids[k] = rig_self(owns ? "own" : "listen", number, s->host);
}

/* Not the first one: a daemon whose gateway does not start does not, either. LCM is opened before DDS, whose threads
 * say that it runs. */
static void strike_gateway(storm *s)
{
    int k = paired && roll(s, 2) ? STANDBY : DAEMON;
    bool starts = s->again_s[k] || s->gateway_s || !rig_has_thread(s->pids[k], "tev");
    pid_t gateway = starts ? 0 : rig_child(s->pids[k]);
    if (!gateway) return;
    bool kills = roll(s, 2);
    if (kill(gateway, kills ? SIGKILL : SIGSTOP) != 0) return; /* it has ended meanwhile */
    s->gateway_kills += kills;
    if (kills) return;
    s->gateway = gateway;
    s->gateway_s = rig_now_s() + 1e-3 * (double)roll(s, 1500);
}

/* Begins or ends a recording, which may come to nothing: a daemon that cannot record goes on without. */
static void strike_recording(storm *s)
{
    collided_result answer = {0};
    char name[32];
    snprintf(name, sizeof name, "storm %zu", s->recordings++);
    (void)collided_record(s->c[0], roll(s, 3) ? name : NULL, 0.2, &answer);
    collided_result_free(&answer);
}

/* Full to the last byte, or free of all that is in it, recordings that are being written among it. */
static void strike_disk(storm *s)
{
    char command[256];
    bool fills = roll(s, 2);
    snprintf(command, sizeof command, fills ? "cat /dev/zero > %s/ballast 2>/dev/null" : "rm -f %s/*", disk);
    s->full_disks += fills;
    if (system(command) < 0) abort(); /* NOLINT(cert-env33-c): our own line */
}

/* Up to an hour forward or back; what is stamped by it, numbered by it, or an epoch, goes with it. */
static void strike_clock(storm *s)
{
    *s->clock_ns += (int64_t)(roll(s, 7200) * 1000000000) - INT64_C(3600000000000);
    s->clock_steps++;
}

static void strike(storm *s)
{
    int k = (int)roll(s, VICTIMS + 1);
    if (paired && roll(s, 4) == 0) k = DAEMON + (int)roll(s, 2);
    if (s->clock_ns && roll(s, 12) == 0) strike_clock(s);
    if (*disk && roll(s, 4) == 0) strike_disk(s);
    if (*disk && roll(s, 4) == 0) strike_recording(s);
    if (k == VICTIMS) {
        strike_gateway(s);
        return;
    }
    if (s->again_s[k] || (!paired && (k == STANDBY || (k == DAEMON && roll(s, 2))))) return;
    bool kills = roll(s, 2);
    rig_kill(s->pids[k], kills ? SIGKILL : SIGSTOP);
    s->again_s[k] = rig_now_s() + 1e-3 * (double)roll(s, roll(s, 3) ? 200 : 1500);
    if (kills) s->pids[k] = 0;
    s->kills += kills;
    s->stops += !kills;
    s->daemon_kills += kills && k >= DAEMON;
}

static void let_go_on(storm *s, bool all)
{
    double now = rig_now_s();
    if (s->gateway_s && (all || now >= s->gateway_s)) {
        kill(s->gateway, SIGCONT); /* which may have been ended with its daemon */
        s->gateway_s = 0;
    }
    for (int k = 0; k < VICTIMS; k++) {
        if (!s->again_s[k] || (now < s->again_s[k] && !all)) continue;
        if (s->pids[k])
            rig_kill(s->pids[k], SIGCONT);
        else
            start(s, k);
        s->again_s[k] = 0;
    }
}

static void assert_well(storm *s)
{
    for (int k = 0; k < VICTIMS; k++)
        if (s->pids[k] && !rig_alive(s->pids[k])) fail_msg("process %d of the storm has ended by itself", k);
    for (int k = 0; k < STORM_LISTENERS; k++)
        if (s->shared->listeners[k].faulty) fail_msg("listener %d: %s", k, s->shared->listeners[k].fault);
    for (int k = 0; k < 2; k++)
        if (s->models[k]->faulty) fail_msg("our own, %s: %s", link_of(k), s->models[k]->fault);
}

static void poll_ours(storm *s, double seconds)
{
    for (double end = rig_now_s() + seconds; rig_now_s() < end;)
        for (int k = 0; k < 2; k++) collided_poll(s->c[k], 0.005);
}

/* ---- when it is quiet ---- */

static bool owners_are_quiet(const storm *s)
{
    for (int k = 0; k < STORM_OWNERS; k++)
        if (!s->shared->owners[k].quiet) return false;
    return true;
}

static size_t count_who_knows(storm *s, storm_model *fresh[2], uint64_t truth, bool tells)
{
    size_t knows = 0;
    for (int k = 0; k < STORM_LISTENERS + 4; k++) {
        const storm_model *m = k < STORM_LISTENERS       ? &s->shared->listeners[k]
                               : k < STORM_LISTENERS + 2 ? s->models[k - STORM_LISTENERS]
                                                         : fresh[k - STORM_LISTENERS - 2];
        bool right = m->digest == truth && m->snapshots;
        knows += right;
        if (right || !tells) continue;
        printf("listener %d (%d.. ours, %d.. fresh), epoch %lld, batch %lld, %zu open:\n", k, STORM_LISTENERS,
            STORM_LISTENERS + 2, (long long)m->epoch, (long long)m->batch, m->open_count);
        storm_print_difference(s->shared, m);
    }
    return knows;
}

static void print_status(const char *who, collided *c)
{
    collided_daemon_status d;
    if (collided_get_status(c, 2, &d) != COLLIDED_OK)
        printf("%s hears no daemon: %s\n", who, collided_error(c));
    else
        printf("%s hears %s, epoch %lld: %s\n", who, d.daemon, (long long)d.epoch, d.links);
}

static void all_know_the_truth(storm *s)
{
    storm_model *fresh[2];
    collided *c[2];
    for (int k = 0; k < 2; k++) {
        fresh[k] = calloc(1, sizeof *fresh[k]);
        c[k] = connect_without_waiting(link_of(k), 0, COLLIDED_REMOVE);
        storm_listen(c[k], fresh[k]);
    }
    size_t contacts = 0, knows = 0, everybody = STORM_LISTENERS + 4;
    double began = rig_now_s();
    while (knows < everybody && rig_now_s() < began + SETTLE_S) {
        poll_ours(s, 0.02);
        for (int k = 0; k < 2; k++) collided_poll(c[k], 0);
        assert_well(s);
        uint64_t truth = storm_truth(s->shared, &contacts);
        knows = owners_are_quiet(s) ? count_who_knows(s, fresh, truth, false) : 0;
    }
    printf(
        "%zu of %zu listeners know the %zu contacts after %.1f s\n", knows, everybody, contacts, rig_now_s() - began);
    if (knows < everybody) {
        count_who_knows(s, fresh, storm_truth(s->shared, &contacts), true);
        for (int k = 0; k < 2; k++) print_status("ours", s->c[k]);
        for (int k = 0; k < 2; k++) print_status("fresh", c[k]);
        fail_msg("not everybody knows what touches %d s after the storm%s", SETTLE_S,
            owners_are_quiet(s) ? "" : "; not even all owners are quiet");
    }
    for (int k = 0; k < 2; k++) {
        rig_close(c[k]);
        free(fresh[k]->over);
        free(fresh[k]);
    }
}

static double seconds_of_storm(void)
{
    const char *told = getenv("COLLIDED_STORM_SECONDS");
    double usual = combined ? 120 : 40, nightly = combined ? 3600 : 120;
    return told ? strtod(told, NULL) : getenv("COLLIDED_NIGHTLY") ? nightly : getenv("COLLIDED_BRIEF") ? 7 : usual;
}

static storm_shared *map(int fd)
{
    storm_shared *s = mmap(NULL, sizeof *s, PROT_READ | PROT_WRITE, MAP_SHARED, fd, 0);
    return s == MAP_FAILED ? NULL : s;
}

/* Those that are started find it in their environment, and the sanitizers that it is meant. */
static void set_up_clock(storm *s)
{
    char path[64], options[512];
    int fd = memfd_create("wall clock", 0);
    assert_int_equal(ftruncate(fd, sizeof *s->clock_ns), 0);
    s->clock_ns = mmap(NULL, sizeof *s->clock_ns, PROT_READ | PROT_WRITE, MAP_SHARED, fd, 0);
    assert_true(s->clock_ns != MAP_FAILED);
    snprintf(path, sizeof path, "/proc/%d/fd/%d", (int)getpid(), fd);
    const char *asan = getenv("ASAN_OPTIONS");
    snprintf(options, sizeof options, "%s:verify_asan_link_order=0", asan ? asan : "");
    setenv("ASAN_OPTIONS", options, 1);
    setenv("COLLIDED_WALL_CLOCK", path, 1);
    setenv("LD_PRELOAD", WALL_CLOCK, 1);
}

static void set_up(storm *s)
{
    if (!network) set_up_clock(s);
    int fd = memfd_create("storm", 0);
    assert_int_equal(ftruncate(fd, sizeof *s->shared), 0);
    assert_int_equal(dup2(fd, SHARED_FD), SHARED_FD); /* which those that are started find there */
    close(fd);
    s->shared = map(SHARED_FD);
    assert_non_null(s->shared);
    start(s, DAEMON);
    if (paired) start(s, STANDBY);
    for (int k = 0; k < 2; k++) {
        s->models[k] = calloc(1, sizeof *s->models[k]);
        s->c[k] = connect_without_waiting(link_of(k), 0, COLLIDED_REMOVE);
        storm_listen(s->c[k], s->models[k]);
    }
    for (int k = 0; k < DAEMON; k++) start(s, k);
}

/* Up to 30 % are lost, and some overtake others; now and then nothing comes through for up to two seconds. */
static void strike_network(storm *s)
{
    network->loss_percent = (int)roll(s, 31);
    network->delay_most_ms = (int)roll(s, 20);
    network->cut = roll(s, 4) == 0;
    if (network->cut) poll_ours(s, 1e-3 * (double)roll(s, 2000));
}

static void tell(const storm *s)
{
    printf("%zu killed (daemons %zu times), %zu stopped, %zu gateways killed, %zu clock steps\n", s->kills,
        s->daemon_kills, s->stops, s->gateway_kills, s->clock_steps);
    if (*disk) printf("the disk was full %zu times, %zu recordings asked for\n", s->full_disks, s->recordings);
    if (network) printf("%lld packets carried, %lld lost\n", (long long)network->carried, (long long)network->lost);
    for (int k = 0; k < STORM_LISTENERS + 2; k++) {
        const storm_model *m = k < 2 ? s->models[k] : &s->shared->listeners[k - 2];
        printf("%s heard %lld begins in %lld epochs, %lld take-overs, %lld snapshots, %lld ends unheard, %lld batches "
               "lost\n",
            link_of(k), (long long)m->begun, (long long)m->epochs, (long long)m->takeovers, (long long)m->snapshots,
            (long long)m->unheard, (long long)m->lost);
    }
}

static void each_begin_has_its_end_whoever_is_struck(void **state)
{
    storm s = {0};
    snprintf(s.host, sizeof s.host, "%s", (const char *)*state);
    const char *seed = getenv("COLLIDED_STORM_SEED");
    s.random = s.seed = seed ? strtoull(seed, NULL, 10) : (uint64_t)time(NULL) ^ (uint64_t)getpid() << 32;
    double seconds = seconds_of_storm();
    rig_need_network();
    printf("a storm%s of %g s, COLLIDED_STORM_SEED=%llu\n",
        paired     ? " over a pair"
        : combined ? " of all kinds at once"
                   : "",
        seconds, (unsigned long long)s.seed);
    fflush(stdout);
    set_up(&s);
    for (double end = rig_now_s() + seconds; rig_now_s() < end;) {
        poll_ours(&s, 1e-3 * (double)(20 + roll(&s, 300)));
        let_go_on(&s, false);
        assert_well(&s);
        if (network) strike_network(&s);
        if (!network || combined) strike(&s);
    }
    let_go_on(&s, true);
    if (network) network->loss_percent = network->delay_most_ms = network->cut = 0;
    s.shared->quiet = 1;
    all_know_the_truth(&s);
    tell(&s);
    for (int k = 0; k < 2; k++) {
        rig_close(s.c[k]);
        assert_true(s.models[k]->begun > 0);
        free(s.models[k]->over);
        free(s.models[k]);
    }
}

int main(int argc, char **argv)
{
    if (argc == 4) {
        if (*argv[3]) interface = STORM_NET_INTERFACE;
        if (*argv[3] && !storm_network_enter((pid_t)strtol(argv[3], NULL, 10))) return 2;
        storm_shared *s = map(SHARED_FD);
        if (!s) return 2;
        int number = (int)strtol(argv[2], NULL, 10);
        strcmp(argv[1], "own") == 0 ? own(s, number) : listen_only(s, number);
    }
    char host[16] = "";
    combined = argc == 2 && strcmp(argv[1], "all") == 0;
    bool far = combined || (argc == 2 && strcmp(argv[1], "network") == 0);
    paired = argc == 2 && strcmp(argv[1], "pair") == 0;
    pid_t other = rig_isolate() && far ? storm_network_start(&network) : 0;
    if (other < 0) return 0; /* it has said why */
    if (other > 0) {
        interface = STORM_NET_INTERFACE;
        snprintf(host, sizeof host, "%d", (int)other);
    }
    if (combined && !rig_small_disk(disk, DISK_KIB)) printf("so the disk is never full\n");
    const struct CMUnitTest tests[] = {{"each_begin_has_its_end_whoever_is_struck",
        each_begin_has_its_end_whoever_is_struck, NULL, rig_end_all, host}};
    int failed = cmocka_run_group_tests(tests, NULL, NULL);
    if (*disk) umount(disk);
    if (*disk) rmdir(disk);
    return failed;
}
