/* A closed site: everything that its members say arrives, whatever others do, and others get nothing in. */
#include "rig.h"
#include "site.h"
#include "strangers.h"

#include <dds/dds.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

static const char *const SECONDS_ROUND = "1";

/* ---- what a daemon writes to standard error ---- */

static int kept_stderr = -1, noise = -1;

/* From here on, what is started writes it to a file without a name. */
static void noise_begin(void)
{
    if (noise >= 0) close(noise);
    noise = memfd_create("noise", MFD_CLOEXEC);
    kept_stderr = dup(STDERR_FILENO);
    dup2(noise, STDERR_FILENO);
}

static void noise_no_more(void)
{
    dup2(kept_stderr, STDERR_FILENO);
    close(kept_stderr);
}

/* Its size until now; the first bytes of it in `text`. */
static long noise_read(char *text, size_t size)
{
    struct stat is;
    ssize_t n = pread(noise, text, size - 1, 0);
    text[n > 0 ? n : 0] = '\0';
    assert_int_equal(fstat(noise, &is), 0);
    return (long)is.st_size;
}

/* ---- a cell at work ---- */

typedef struct cell {
    collided *c;
    collided_body part;
    heard heard;
    int64_t batches; /* of poses */
} cell;

static void cell_open(cell *cell, const char *site)
{
    char daemon[32], robot[32];
    rig_need_network();
    snprintf(daemon, sizeof daemon, "%s/daemon", site ? site : "");
    snprintf(robot, sizeof robot, "%s/robot", site ? site : "");
    if (site) setenv("COLLIDED_SECURITY", site_folder(robot), 1);
    noise_begin();
    rig_daemon(site ? "--security" : NULL, site ? site_folder(daemon) : NULL);
    noise_no_more();
    *cell = (struct cell){.c = rig_connect(RIG_DDS, 10, COLLIDED_REMOVE)};
    unsetenv("COLLIDED_SECURITY"); /* the others, whom this process starts, have their own */
    rig_box(cell->c, "table", 0);
    cell->part = rig_box(cell->c, "part", 0.5);
    rig_watch(cell->c, &cell->heard, "part");
    UNTIL(cell->c, RIG_PATIENCE_S, cell->heard.touching == 1);
}

/* One step and its answer. */
static bool step(cell *cell, double seconds)
{
    int64_t number = ++cell->batches;
    rig_move(cell->c, cell->part, 0.5 + 1e-6 * (double)(number % 1000), number);
    for (double end = rig_now_s() + seconds; cell->heard.step != number && rig_now_s() < end;)
        collided_poll(cell->c, 0.01);
    return cell->heard.step == number;
}

/* ---- tests ---- */

static void everything_arrives_while_packets_are_forged(void **state)
{
    (void)state;
    cell cell;
    char text[256];
    cell_open(&cell, "ours");
    const char *seconds = getenv("COLLIDED_NIGHTLY") ? "20" : SECONDS_ROUND;
    pid_t forger = rig_self("forge", seconds, NULL);
    pid_t plain = rig_self("write", "", seconds);
    pid_t other = rig_self("write", site_folder("theirs/robot"), seconds);
    do {
        assert_true(step(&cell, RIG_PATIENCE_S));
        usleep(500);
    } while (!rig_has_ended(forger) || !rig_has_ended(plain) || !rig_has_ended(other));
    assert_int_equal(rig_wait(forger, 3 * RIG_PATIENCE_S), 0);
    assert_int_equal(rig_wait(plain, 3 * RIG_PATIENCE_S), 0);
    assert_int_equal(rig_wait(other, 3 * RIG_PATIENCE_S), 0);
    assert_int_equal(cell.heard.lost, 0);
    assert_int_equal(cell.heard.touching, 1);
    UNTIL(cell.c, RIG_PATIENCE_S, rig_counter(cell.c, "in_PoseBatch") == cell.batches);
    assert_int_equal(rig_counter(cell.c, "bodies"), 2);
    assert_int_equal(rig_counter(cell.c, "dds_refused"), 0);
    rig_close(cell.c);
    long bytes = noise_read(text, sizeof text);
    printf("%lld batches answered; %ld bytes of log\n", (long long)cell.batches, bytes);
    assert_true(bytes < 64 << 10);
}

/* Authenticated datagrams are longer than others: none may grow beyond what UDP carries. */
static void large_messages_arrive(void **state)
{
    enum { POSES = 20000, TIMES = 20 };
    cell cell;
    cell_open(&cell, *state);
    collided_body *bodies = calloc(POSES, sizeof *bodies);
    double *positions = calloc(3 * (size_t)POSES, sizeof *positions);
    double *orientations = calloc(4 * (size_t)POSES, sizeof *orientations);
    for (int i = 0; i < POSES; i++) {
        bodies[i] = cell.part;
        positions[3 * i] = 0.5;
        orientations[4 * i] = 1;
    }
    for (int i = 1; i <= TIMES; i++) {
        collided_publish(cell.c, POSES, bodies, positions, orientations, NULL, NULL, 0, i);
        collided_flush(cell.c);
        UNTIL(cell.c, RIG_PATIENCE_S, cell.heard.step == i);
    }
    assert_int_equal(cell.heard.lost, 0);
    UNTIL(cell.c, RIG_PATIENCE_S, rig_counter(cell.c, "in_PoseBatch") == TIMES);
    rig_close(cell.c);
    free(bodies);
    free(positions);
    free(orientations);
}

/* What the first test protects from: without certificates the same forger does harm. */
static void without_security_the_forger_does_harm(void **state)
{
    (void)state;
    cell cell;
    char text[256];
    cell_open(&cell, NULL);
    bool harmed = false;
    for (int round = 0; round < 5 && !harmed; round++) { /* a slow machine forges less in a round */
        rig_self("forge", SECONDS_ROUND, NULL);
        for (double end = rig_now_s() + 2.2; !harmed && rig_now_s() < end; usleep(500))
            harmed = !step(&cell, 1) || cell.heard.lost || cell.heard.touching != 1;
    }
    long bytes = noise_read(text, sizeof text);
    printf("harmed: %d; %ld bytes of log\n", harmed, bytes);
    assert_true(harmed);
    assert_true(bytes < 64 << 10); /* nor does it fill the disk */
}

static void strangers_are_refused(void **state)
{
    static const struct {
        const char *name, *line;
        int status;
    } cases[] = {
        {"theirs/robot", NULL, 0},
        {"ours/watcher", NULL, STRANGER_NO_WRITER}, /* as its own library tells it */
        {"ours/robot", "cp $SITES/theirs/robot/cert.pem $SITES/theirs/robot/key.pem .", STRANGER_NO_PARTICIPANT},
        {"ours/watcher", "cp $SITES/ours/robot/permissions.p7s .", STRANGER_NO_PARTICIPANT},
        {"ours/watcher", "cp $SITES/theirs/robot/permissions.p7s .", STRANGER_NO_PARTICIPANT},
        {"ours/robot", "cp $SITES/ours/watcher/key.pem .", 0}, /* an identity that was copied, without its key */
        {"theirs/robot", "cp $SITES/ours/ca/cert.pem identity_ca.cert.pem", STRANGER_NO_PARTICIPANT},
        {"ours/robot", "$OPENSSL x509 -in cert.pem -outform DER -out x && cp x cert.pem", STRANGER_NO_PARTICIPANT},
    };
    enum { CASES = sizeof cases / sizeof cases[0] };
    (void)state;
    cell cell;
    pid_t processes[CASES];
    cell_open(&cell, "ours");
    UNTIL(cell.c, RIG_PATIENCE_S, rig_counter(cell.c, "clients") == 1);
    setenv("OPENSSL", "openssl", 1);
    for (int i = 0; i < CASES; i++) {
        char as[32];
        snprintf(as, sizeof as, "stranger%d", i);
        const char *folder =
            cases[i].line ? site_spoiled(cases[i].name, as, cases[i].line) : site_folder(cases[i].name);
        processes[i] = rig_self("write", folder, SECONDS_ROUND);
    }
    for (int i = 0; i < CASES; i++) {
        int status = rig_wait(processes[i], 3 * RIG_PATIENCE_S);
        if (status != cases[i].status) fail_msg("case %d: status %d, not %d", i, status, cases[i].status);
    }
    assert_int_equal(rig_counter(cell.c, "clients"), 1);
    assert_int_equal(rig_counter(cell.c, "bodies"), 2);
    assert_true(step(&cell, RIG_PATIENCE_S));
    rig_close(cell.c);
}

/* A program that does not keep to its permissions: its own plug-in would let it write. The daemon keeps to them. */
static void a_subscriber_that_writes_in_spite_of_its_permissions_is_refused(void **state)
{
    (void)state;
    cell cell;
    cell_open(&cell, "ours");
    assert_int_equal(collided_sync(cell.c, RIG_PATIENCE_S), COLLIDED_OK);
    int64_t before = -1, ours = 0; /* two, or more where an answer was slow and they were said again */
    while ((ours = rig_counter(cell.c, "in_Body")) < 2 || ours != before) {
        before = ours;
        THROUGHOUT(cell.c, 0.25, true);
    }
    int status = rig_wait(rig_self("lawless", site_folder("ours/watcher"), SECONDS_ROUND), 3 * RIG_PATIENCE_S);
    assert_int_equal(status, STRANGER_MATCHED); /* it wrote, and takes the daemon for a reader of at least Client */
    assert_int_equal(rig_counter(cell.c, "in_PoseBatch"), 0);
    assert_int_equal(rig_counter(cell.c, "bodies"), 2);
    /* Client it may write: it was there, and was heard. */
    UNTIL(cell.c, RIG_PATIENCE_S, rig_counter(cell.c, "in_Client") > 1);
    assert_int_equal(rig_counter(cell.c, "in_Body"), ours);
    assert_true(step(&cell, RIG_PATIENCE_S));
    rig_close(cell.c);
}

static void count_line(void *context, const dds_log_data_t *line)
{
    *(int *)context += (line->priority & (DDS_LC_ERROR | DDS_LC_FATAL)) != 0;
}

/* In a process of its own, which has a log sink for Cyclone's words: it stays, whether connecting works or not, and the
 * reason is told without it. */
static int keeps_its_log(const char *good, const char *bad)
{
    int errors = 0;
    const char *says = getenv("SAYS");
    collided_def def = collided_def_default();
    def.connect_timeout_s = RIG_PATIENCE_S;
    dds_set_log_sink(count_line, &errors);
    for (int i = 0; i < 2; i++) {
        def.security = good;
        collided *c = collided_connect(RIG_DDS, &def);
        if (!c) return 2;
        collided_close(c);
        def.security = bad;
        errors = 0;
        if (collided_connect(RIG_DDS, &def)) return 3;
        if (!strstr(collided_connect_error(), says)) return 4;
        if (errors == 0) return 5;
    }
    return 0;
}

static void a_programs_own_log_stays(void **state)
{
    static const struct {
        const char *name, *line, *says;
    } cases[] = {
        {"ours/robot", "cp $SITES/theirs/ca/governance.p7s .", "governance.p7s was changed, or is of another site"},
        {"ours/robot", "sed -i s/collided_Body/collided_Bodx/ permissions.p7s", "permissions.p7s were changed"},
        {"ours/robot", "cp $SITES/ours/watcher/permissions.p7s .", "not those of cert.pem"},
        {"ours/robot", "cp $EXPIRED/robot/permissions.p7s .", "permissions.p7s have expired"},
    };
    (void)state;
    cell cell;
    cell_open(&cell, "ours");
    setenv("EXPIRED", site_folder("expired_robot"), 1);
    site_spoiled("ours", "expired_robot", MAKE_SITE " --days 0 --renew . robot && sleep 1.1");
    for (int i = 0; i < 4; i++) {
        char good[512], as[32];
        snprintf(good, sizeof good, "%s", site_folder("ours/robot"));
        snprintf(as, sizeof as, "log%d", i);
        const char *bad = site_spoiled(cases[i].name, as, cases[i].line);
        setenv("SAYS", cases[i].says, 1);
        int status = rig_wait(rig_self("log", good, bad), 3 * RIG_PATIENCE_S);
        if (status != 0) fail_msg("case %d: status %d", i, status);
    }
    rig_close(cell.c);
}

/* It hears the contact, and may not have a body. */
static int subscribe_with(collided *c, heard *h)
{
    rig_watch(c, h, "part");
    for (double end = rig_now_s() + RIG_PATIENCE_S; h->touching != 1 && rig_now_s() < end;) collided_poll(c, 0.01);
    if (h->touching != 1) return 3;
    if (collided_sync(c, RIG_PATIENCE_S) != COLLIDED_OK) return 4;
    rig_box(c, "smuggled", 0);
    if (collided_sync(c, RIG_PATIENCE_S) != COLLIDED_REJECTED) return 5;
    return strstr(collided_error(c), "do not let it write Body") ? 0 : 6;
}

/* In a process of its own. It is closed whatever came of it: at the process's end, OpenSSL's would meet Cyclone's
 * threads. */
static int subscribe_only(const char *security)
{
    heard h;
    setenv("COLLIDED_SECURITY", security, 1);
    collided_def def = collided_def_default();
    def.connect_timeout_s = RIG_PATIENCE_S;
    collided *c = collided_connect(RIG_DDS, &def);
    if (!c) return 2;
    int status = subscribe_with(c, &h);
    collided_close(c);
    return status;
}

static void a_subscriber_hears_and_is_told_that_it_may_not_write(void **state)
{
    (void)state;
    cell cell;
    cell_open(&cell, "ours");
    assert_int_equal(rig_wait(rig_self("subscribe", site_folder("ours/watcher"), NULL), 3 * RIG_PATIENCE_S), 0);
    assert_int_equal(rig_counter(cell.c, "bodies"), 2);
    assert_true(step(&cell, RIG_PATIENCE_S));
    rig_close(cell.c);
}

/* What Cyclone DDS says of participants that it heard before the end is none of the daemon's own lines. */
static const char *own_lines(const char *text)
{
    static const char HEARD[] = "warning: DDS: Remote ";
    while (strncmp(text, HEARD, sizeof HEARD - 1) == 0 && strchr(text, '\n')) text = strchr(text, '\n') + 1;
    return text;
}

/* One line, a status, and nothing half-started. */
static void a_folder_that_will_not_do_is_told_in_one_line(void **state)
{
    static const struct {
        const char *name, *line, *says;
        int status;
    } cases[] = {
        {"ours/daemon", "rm key.pem", "key.pem: No such file", 66},
        {"ours/daemon", ": > governance.p7s", "governance.p7s: empty", 66},
        {"ours/daemon", "cp $SITES/theirs/daemon/cert.pem .", "not of the authority", 66},
        {"ours/daemon", "cp ../ours/robot/key.pem .", "not the key of cert.pem", 66},
        {"ours/daemon", "echo nonsense > cert.pem", "cert.pem is no certificate", 66},
        {"ours/daemon", "cp $EXPIRED/daemon/cert.pem .", "cert.pem has expired", 66},
        {"ours/daemon", "cp $EXPIRED/daemon/permissions.p7s .", "permissions.p7s have expired", 69},
        {"ours/daemon", "chmod 644 key.pem", "key.pem can be read or written by others (mode 644): do: chmod 600", 66},
        {"ours/daemon", "chmod 660 key.pem", "key.pem can be read or written by others (mode 660): do: chmod 600", 66},
        {"ours/daemon", "cp $SITES/theirs/daemon/crl.pem .", "crl.pem is not of the authority", 66},
        {"ours/daemon", "echo nonsense > crl.pem", "crl.pem is no list of certificates", 66},
        {"ours/daemon", "rm key.pem && mkfifo key.pem", "key.pem: empty, or not a file", 66},
        {"revoking/watcher", "cp $SITES/revoking/was_watcher/cert.pem $SITES/revoking/was_watcher/key.pem .",
            "cert.pem was revoked", 66},
        {"ours/daemon", "cp ../ours/robot/permissions.p7s .", "not those of cert.pem", 69},
        {"ours/daemon", "cp $SITES/theirs/ca/governance.p7s .", "of another site", 69},
        {"ours/daemon", "sed -i s/collided_Body/collided_Bodx/ permissions.p7s", "were changed", 69},
        {"ours/robot", ":", "do not permit what this program does", 69},
    };
    enum { CASES = sizeof cases / sizeof cases[0] };
    (void)state;
    rig_need_network();
    setenv("EXPIRED", site_folder("expired"), 1);
    site_spoiled("ours", "expired", MAKE_SITE " --days 0 --renew . && sleep 1.1");
    for (int i = 0; i < CASES; i++) {
        char as[32], text[2048];
        snprintf(as, sizeof as, "folder%d", i);
        const char *const arguments[] = {
            "collided", "--links", RIG_DDS, "--security", site_spoiled(cases[i].name, as, cases[i].line), NULL};
        noise_begin();
        int status = rig_wait(rig_start(COLLIDED, arguments), RIG_PATIENCE_S);
        noise_no_more();
        noise_read(text, sizeof text);
        const char *own = own_lines(text), *line_end = strchr(own, '\n');
        bool one_line = line_end && !line_end[1];
        if (status != cases[i].status || !one_line || !strstr(own, cases[i].says))
            fail_msg("case %d: status %d, not %d, says: %s", i, status, cases[i].status, text);
    }
}

static int writes_as(const char *folder)
{
    return rig_wait(rig_self("write", site_folder(folder), SECONDS_ROUND), 3 * RIG_PATIENCE_S);
}

/* On a busy machine a handshake takes longer than that. */
static bool comes_in(const char *folder)
{
    double end = rig_now_s() + 2 * RIG_PATIENCE_S;
    int status;
    do {
        status = writes_as(folder);
    } while (status == 0 && rig_now_s() < end);
    return status == STRANGER_MATCHED;
}

/* Its folder is what it always was; the daemon has the new list. Two of its certificates were made, and neither is good
 * any more; others come in, and one of the same name that was made anew. */
static void who_was_revoked_is_shut_out(void **state)
{
    (void)state;
    rig_need_network();
    pid_t daemon = rig_daemon("--security", site_folder("revoking_before/daemon"));
    assert_true(comes_in("revoking/was_robot"));
    assert_true(comes_in("revoking/was_robot_first"));
    rig_kill(daemon, SIGTERM);
    assert_int_equal(rig_wait(daemon, RIG_PATIENCE_S), 0);
    rig_daemon("--security", site_folder("revoking/daemon"));
    assert_int_equal(writes_as("revoking/was_robot"), 0);
    assert_int_equal(writes_as("revoking/was_robot_first"), 0);
    assert_true(comes_in("revoking/second"));
    assert_true(comes_in("revoking/robot"));
}

static void a_certificate_that_expires_soon_is_told(void **state)
{
    (void)state;
    cell cell;
    char text[2048];
    cell_open(&cell, "short");
    int64_t days = rig_counter(cell.c, "certificate_days");
    assert_in_range(days, 9, 10);
    noise_read(text, sizeof text);
    if (!strstr(text, "a certificate expires in")) fail_msg("%s", text);
    rig_close(cell.c);
}

static int remove_sites(void **state)
{
    (void)state;
    site_remove();
    return 0;
}

#define TEST(test) cmocka_unit_test_teardown(test, rig_end_all)

int main(int argc, char **argv)
{
    /* Strangers leave without a word: OpenSSL's end would meet Cyclone's threads in the middle of handshakes. */
    if (argc > 2 && strcmp(argv[1], "forge") == 0) return forger_runs(strtod(argv[2], NULL));
    if (argc > 3 && strcmp(argv[1], "write") == 0) _exit(stranger_writes(argv[2], strtod(argv[3], NULL)));
    if (argc > 3 && strcmp(argv[1], "log") == 0) return keeps_its_log(argv[2], argv[3]);
    if (argc > 2 && strcmp(argv[1], "subscribe") == 0) return subscribe_only(argv[2]);
    if (argc > 3 && strcmp(argv[1], "lawless") == 0) _exit(lawless_writes(argv[2], strtod(argv[3], NULL)));
    const struct CMUnitTest tests[] = {
        TEST(everything_arrives_while_packets_are_forged),
        OVER(large_messages_arrive, "ours"),
        OVER(large_messages_arrive, "signed"),
        OVER(large_messages_arrive, "origin"),
        TEST(without_security_the_forger_does_harm),
        TEST(strangers_are_refused),
        TEST(who_was_revoked_is_shut_out),
        TEST(a_certificate_that_expires_soon_is_told),
        TEST(a_subscriber_that_writes_in_spite_of_its_permissions_is_refused),
        TEST(a_subscriber_hears_and_is_told_that_it_may_not_write),
        TEST(a_programs_own_log_stays),
        TEST(a_folder_that_will_not_do_is_told_in_one_line),
    };
    rig_isolate();
    if (!site_make()) return 1;
    return cmocka_run_group_tests(tests, NULL, remove_sites);
}
