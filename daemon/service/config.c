/* config: the table of options, and what is made from it. Main thread, at start. */
#include "config.h"

#include "wire/wire_file.h"

#include <errno.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sysexits.h>

#define FIELD(name) offsetof(config, name), sizeof(((config *)0)->name)
/* Of what one participant may have, and send. */
#define OF_ONE(things) things " of one participant, all its clients together"
#define OF_ONE_A_SECOND(things) things " of one participant in a second, all its clients together"
#define OR_SHARE(things) "; 0: its share of max_" things

static const config_option OPTIONS[] = {
    {"links", CONFIG_TEXT, FIELD(links), 0, 0, NULL, "auto", "",
        "transports to listen on, divided by spaces: dds://DOMAIN, lcm://[udpm://GROUP:PORT?ttl=N]; or auto",
        "The word auto stands for dds://0, and lcm:// where this machine can carry it (multicast on loopback, or on "
        "the interface); what is left out is told at the start. DDS is for clients that need delivery to be reliable, "
        "LCM for those that speak it already; both may be open at once, and more than one domain of DDS. memory:// is "
        "for tests. Out of the box everything stays on this machine."},
    {"interface", CONFIG_TEXT, FIELD(interface), 0, 0, NULL, "", "",
        "network interface to open the links to; empty: this machine only",
        "A name (eth0) or an address of this machine. With one, DDS uses multicast on that network and LCM "
        "may have a ttl above 0: anybody there can then reach the daemon, unless security is set up."},
    {"security", CONFIG_TEXT, FIELD(security), 0, 0, NULL, "", "",
        "folder with the daemon's certificate and permissions, made by make_site; empty: what COLLIDED_SECURITY says",
        "DDS then lets in nobody without a certificate of the same site, permits each client what its permissions say, "
        "and authenticates or encrypts every message. Without either there is no security. Clients name their folders "
        "by COLLIDED_SECURITY, too. LCM has no "
        "security: the word auto leaves it out."},
    {"user", CONFIG_TEXT, FIELD(user), 0, 0, NULL, "", "",
        "started as root: the user to become before anything is heard; empty: it stays who it is",
        "Its groups are that user's, too, and there is no way back. Recordings, and the security folder, must be that "
        "user's to write and to read. The systemd unit needs none: it starts the daemon as a user of its own."},
    {"name", CONFIG_TEXT, FIELD(name), 0, 0, NULL, "", "", "name of this daemon in status; empty: host:pid",
        "Shown by collidectl status; it has no other meaning."},
    {"gateway", CONFIG_TEXT, FIELD(gateway), 0, 0, NULL, "", "", "path of collided-lcm; empty: beside this program",
        "LCM is spoken by a process of its own, because a crafted datagram can end a program that uses "
        "liblcm. It is started, watched and started again by the daemon."},
    {"workers", CONFIG_WHOLE, FIELD(workers), 0, 64, NULL, "0", "threads",
        "threads of the narrow phase; 0: one a processor that it may use, at most 8",
        "The events are the same for any number. More than there are cores gain nothing."},
    {"engine", CONFIG_CHOICE, FIELD(engine), 0, 0, "auto|gjk|ccd|mpr", "auto", "",
        "narrow phase: auto (closed forms, GJK, exact depth), gjk (general path only), ccd and mpr (libccd proposes, "
        "our certificate decides)",
        "For experiments and comparisons; every answer is certified whichever is chosen. libccd knows convex shapes "
        "only: pairs with a mesh or a half-space are settled by our own methods, and Status counts them as theirs."},
    {"broad", CONFIG_CHOICE, FIELD(broad), 0, 0, "auto|tree|sweep3|sweep1", "auto", "",
        "broad phase: auto (by the number of shapes), tree (two trees of boxes), sweep3 and sweep1 (sweep and prune on "
        "three axes or one)",
        "The events are the same whichever is chosen. By measurement sweep3 is ahead in small worlds, up to some "
        "hundred shapes, the tree in all others, and sweep1 where everything stands in a row; a sweep becomes slow "
        "in a large world. The log says which one stands, and when auto changes it."},
    {"caches", CONFIG_YES, FIELD(caches), 0, 0, NULL, "yes", "",
        "let cached axes and motion bounds skip separated pairs; the events are the same without",
        "Switch it off to compare, or to find out whether a cache is at fault."},
    {"margin", CONFIG_NUMBER, FIELD(margin), 0, 10, NULL, "0.1", "of a shape's reach", "by how much boxes are fattened",
        "A larger margin means that boxes move less often in the trees, and that more pairs are looked at. It "
        "never changes an answer."},
    {"rate", CONFIG_NUMBER, FIELD(rate), 0, 100000, NULL, "0", "Hz",
        "ticks a second; 0: a tick whenever something came",
        "By default a tick runs as soon as something has come, and none when nothing has. A fixed rate is for "
        "systems that want the load to be even."},
    {"budget_us", CONFIG_NUMBER, FIELD(budget_us), 0, 10000000, NULL, "0", "us",
        "time that a tick may take; 0: as long as it needs",
        "All pairs are bounded first; then those that matter most are refined, until the time is used. What is left "
        "keeps an interval that is wider than asked but holds, is reported as stopped by the budget, counted (undone), "
        "and "
        "goes first in the next tick, which follows at once. Searches for impacts are not cut short."},
    {"slice_us", CONFIG_NUMBER, FIELD(slice_us), 0, 10000000, NULL, "12000", "us",
        "time that finding and deciding pairs, and searching for impacts, may hold a tick; 0: as long as it needs",
        "What is left after it is pending: unknown, counted (pending_pairs, undone), and goes on in the next tick, "
        "which "
        "follows at once, so that queries and other clients wait no longer than that. Clients take turns. What ends "
        "because a subscription closes, or bodies are removed, and snapshots take a quarter of it each at most. A "
        "step is "
        "answered when nothing of it is pending."},
    {"lock_memory", CONFIG_YES, FIELD(lock_memory), 0, 0, NULL, "no", "",
        "keep all memory resident: nothing is paged out",
        "For steady answers on a machine that is short of memory. Needs LimitMEMLOCK=infinity (ulimit -l unlimited); "
        "where that is not granted the daemon does not start, and says so. Stacks of threads count in full."},
    {"fifo_priority", CONFIG_WHOLE, FIELD(fifo_priority), 0, 99, NULL, "0", "",
        "real-time priority (SCHED_FIFO) of all threads; 0: an ordinary program",
        "Above 0 no ordinary program delays a tick, and a daemon that is flooded delays all of them: leave a processor "
        "to the others (cpus). Needs ulimit -r; where that is not granted the daemon does not start, and says so. The "
        "systemd unit forbids it: there CPUSchedulingPolicy=fifo and CPUSchedulingPriority= do the same."},
    {"cpus", CONFIG_TEXT, FIELD(cpus), 0, 0, NULL, "", "", "processors to run on, as in 2,4-7; empty: any",
        "Best those that the kernel keeps free of other work (isolcpus). With workers = 0 there is one worker for each "
        "of them, at most 8. In the systemd unit, CPUAffinity= does the same."},
    {"status_period", CONFIG_NUMBER, FIELD(status_period), 0.05, 60, NULL, "1", "s", "how often Status is published",
        "Status carries health, limits that were reached and all counters; collidectl status shows it."},
    {"settle", CONFIG_NUMBER, FIELD(settle), 0, 3600, NULL, "1", "s",
        "ready once nothing new has been announced for so long since the start; 0: at once",
        "A daemon that was started again has its world from what its clients announce anew, within a second or so. "
        "Until nothing more comes, and no body waits for its geometry, its health is starting, and /ready says so; it "
        "works all the same. After ten times as long it is ready in any case, and the log says what still comes."},
    {"heartbeat", CONFIG_NUMBER, FIELD(heartbeat), 0.01, 3600, NULL, "1", "s",
        "a stream that has had nothing to report for so long says that it is alive",
        "Nothing is reported again that has not changed, so a resting scene is silent but for these. A heartbeat "
        "carries "
        "the "
        "number of the last batch, by which a subscriber finds out that it has lost it, and the oldest stamp that what "
        "it was told rests on."},
    {"step_timeout", CONFIG_NUMBER, FIELD(step_timeout), 0, 3600, NULL, "1", "s",
        "how long clients in lock-step wait for one that has not published its step; 0: for ever",
        "Counted from the first that has published it. Only clients that say that they are in lock-step with others "
        "are waited for."},
    {"step_policy", CONFIG_CHOICE, FIELD(step_policy), 0, 0, "go_on|hold", "go_on", "",
        "what then: go_on (the step is done without it), hold (all wait on); all of them are told",
        "With go_on the missing client is not waited for again until it publishes a step. In either case its lease "
        "ends its membership."},
    {"lease", CONFIG_NUMBER, FIELD(lease), 0.05, 3600, NULL, "2", "s",
        "lease of a client that has not announced its own yet",
        "A client that is silent for so long is lost; what becomes of its bodies is its own choice. Clients "
        "usually announce a lease of their own."},
    {"standby", CONFIG_YES, FIELD(standby), 0, 0, NULL, "no", "",
        "one of a pair: whoever is there first is active, the other computes along and takes over",
        "Give it to both. They find each other over DDS, and need the same release, links and options. The standby "
        "publishes nothing; when the active one is gone it goes on with the same ids and batch numbers, so that "
        "subscribers lose nothing and are told nothing twice. Started again, the other one becomes the standby. Alone, "
        "a daemon waits a second, or five leases, for another one before it is active."},
    {"standby_lease", CONFIG_NUMBER, FIELD(standby_lease), 0.02, 60, NULL, "0.1", "s",
        "of a pair: the standby takes over when the active one has given no sign of life for so long",
        "DDS gives the signs by itself. Short leases fail over fast, and may do so where a busy machine lets the "
        "active "
        "one wait: nothing is lost by that, since it then becomes the standby."},
    {"max_clients", CONFIG_WHOLE, FIELD(max_clients), 1, 100000, NULL, "1200", "clients", "clients at once",
        "What exceeds a limit is refused, answered with the reason, counted, and shown in Status, whose "
        "health is then degraded."},
    {"max_bodies", CONFIG_WHOLE, FIELD(max_bodies), 1, 10000000, NULL, "1000000", "bodies", "bodies in the world",
        "Counts all clients together."},
    {"max_shapes", CONFIG_WHOLE, FIELD(max_shapes), 1, 40000000, NULL, "2000000", "shapes", "shapes in the world",
        "Counts all bodies together; of a compound, it and each of its children."},
    {"max_pairs", CONFIG_WHOLE, FIELD(max_pairs), 1, 1000000000, NULL, "2000000", "pairs",
        "pairs of shapes that are looked at",
        "Many shapes at one place make pairs by the square, of up to 3 KB each. A quarter is kept for owners who have "
        "few. What exceeds is left out, and said: "
        "counted (pairs_left_out), in the undone of each batch, and as degraded health. It comes in as soon as others "
        "have parted. A standby needs the same limit."},
    {"max_subscriptions", CONFIG_WHOLE, FIELD(max_subscriptions), 1, 100000, NULL, "4096", "subscriptions",
        "subscriptions at once",
        "Counts all clients together. A subscription takes about 5 kB where its bodies are in contact, and time for "
        "what is reported on it (script/bench subscriptions): with 100000, a tick in which a tenth of the bodies move "
        "takes longer than it should. Over DDS a stream that its client has named is a writer, too, of 7 kB here and "
        "2.3 kB in each participant that discovers it; those of the C library without a name share writers."},
    {"max_geometries", CONFIG_WHOLE, FIELD(max_geometries), 1, 1000000, NULL, "10000", "geometries",
        "hulls, meshes and height fields in the store",
        "One is stored once however many bodies use it, and is forgotten when nobody does."},
    {"max_soft_vertices", CONFIG_WHOLE, FIELD(max_soft_vertices), 1, 100000000, NULL, "524288", "vertices",
        "vertices of all soft bodies together",
        "Of a soft body each vertex takes about 1 kB, and some 0.1 us of each step. A body counts for 2048 at least."},
    {"max_step_poses", CONFIG_WHOLE, FIELD(max_step_poses), 1, 100000000, NULL, "40000", "poses",
        "poses of a step of lock-step, of all members together",
        "A step is kept until all have published it. Then all is moved in one tick, which takes about a tenth of a "
        "microsecond for each; what follows from it is worked off in as many ticks as it takes (slice_us), but at once "
        "where somebody asks for impacts, which takes about a microsecond for each. A pose of a body of many shapes "
        "counts for several. Each member may have an equal share of them, whatever others have."},
    {"share", CONFIG_WHOLE, FIELD(share), 1, 100, NULL, "75", "%",
        "what one participant may have of each limit, under all its names; the rest stays free for others",
        "Of max_clients, max_bodies, max_shapes, max_subscriptions, max_geometries, max_soft_vertices and max_waiting. "
        "Who comes over DDS is "
        "a participant, whatever clients it names; over LCM nobody can be told apart: there each client has its share, "
        "and all of LCM together, if there are other links. 100: nothing is kept free."},
    {"max_client_bodies", CONFIG_WHOLE, FIELD(max_client_bodies), 0, 10000000, NULL, "0", "bodies",
        OF_ONE("bodies") OR_SHARE("bodies"), "The limits of one client let nobody use up what is there for all."},
    {"max_client_shapes", CONFIG_WHOLE, FIELD(max_client_shapes), 0, 40000000, NULL, "0", "shapes",
        OF_ONE("shapes") OR_SHARE("shapes"), "Counted like max_shapes."},
    {"max_client_subscriptions", CONFIG_WHOLE, FIELD(max_client_subscriptions), 0, 100000, NULL, "0", "subscriptions",
        OF_ONE("subscriptions") OR_SHARE("subscriptions"), "Each has a stream."},
    {"max_client_geometry", CONFIG_WHOLE, FIELD(max_client_geometry), 1, 1048576, NULL, "4096", "MiB",
        OF_ONE("geometry") ": hulls, meshes and height fields",
        "Counts the numbers of what the client announces, shared with others or not, from the first piece on, until it "
        "takes them back."},
    {"max_client_work", CONFIG_WHOLE, FIELD(max_client_work), 1, 1000000, NULL, "750", "ms/s",
        "expected work of the commands and queries of one participant in a second",
        "Each has a price in microseconds, by its triangles, points, shapes, rules and the bodies in the world; four "
        "seconds' worth may be saved up, enough for 100,000 bodies or 100 meshes at once. What exceeds waits, in its "
        "order, while others go on; so does what would make a tick long. Poses have a limit of their own."},
    {"max_query_work", CONFIG_WHOLE, FIELD(max_query_work), 1, 1000000, NULL, "250", "ms/s",
        "expected work of the queries of all who are no clients, in a second",
        "Of which each participant has its share. A query that takes longer than expected is charged what it took."},
    {"max_waiting", CONFIG_WHOLE, FIELD(max_waiting), 1, 65536, NULL, "128", "MiB",
        "commands and queries that wait for max_client_work, of all participants",
        "Of which each has its share. What exceeds is refused, and its sender told."},
    {"max_client_messages", CONFIG_WHOLE, FIELD(max_client_messages), 1, 100000000, NULL, "1000000", "messages/s",
        OF_ONE_A_SECOND("messages"), "Of all kinds; what exceeds is refused, and told at most 100 times a second."},
    {"max_client_poses", CONFIG_WHOLE, FIELD(max_client_poses), 1, 1000000000, NULL, "100000000", "poses/s",
        OF_ONE_A_SECOND("poses"), "A batch that exceeds is refused as a whole."},
    {"memory_limit", CONFIG_WHOLE, FIELD(memory_limit), 0, 1 << 30, NULL, "0", "MiB",
        "memory that the daemon may have resident; 0: half of what the machine, or its cgroup, has",
        "What would need more is refused, answered with this name, counted (memory_refused) and reported as degraded "
        "health, before the kernel would end the daemon; poses of bodies that are there go on. New pairs for which "
        "there is no memory are left out as beyond max_pairs; queues of slow readers are cut short. It is the resident "
        "size that counts, so that libraries and what is being built are in it. A cgroup's limit (MemoryMax= of the "
        "systemd unit) should be twice as large."},
    {"runtime_dir", CONFIG_TEXT, FIELD(runtime_dir), 0, 0, NULL, "", "",
        "folder for a file that tells, after a crash, what was carried out; empty: what RUNTIME_DIRECTORY says",
        "A daemon that finds that the one before was killed over a client's command refuses that command, and nothing "
        "else of that client, for a minute, and for twice as long each time, up to an hour; the log, Status and "
        "collidectl doctor name it. systemd sets RUNTIME_DIRECTORY; without either, nothing is kept. Each daemon needs "
        "a folder of its own, which outlives it."},
    {"record", CONFIG_TEXT, FIELD(record), 0, 0, NULL, "", "",
        "record all commands and events to this file (LCM's log format)",
        "Must not exist yet. Written from the start on; collided --replay runs it again and compares every "
        "tick. One of a pair (standby) records while it is active, from the state that it takes over on, and beside "
        "what is there: to FILE, FILE.1, FILE.2, and so on."},
    {"record_dir", CONFIG_TEXT, FIELD(record_dir), 0, 0, NULL, "", "",
        "folder in which clients may start recordings; empty: they may not",
        "collidectl record NAME then writes NAME into that folder. The systemd unit may write below "
        "/var/lib/collided only."},
    {"record_events", CONFIG_YES, FIELD(record_events), 0, 0, NULL, "yes", "",
        "record also what is reported, so that a replay that differs says what differs",
        "Without, a recording has the commands and a hash of the events: it is replayed alike, and is smaller. In the "
        "demo's robot cell an event takes 220 bytes, and the recording is 3.5 times as large with them."},
    {"record_max_size", CONFIG_WHOLE, FIELD(record_max_size), 1, 1000000000, NULL, "16384", "MiB",
        "size of a recording",
        "One that would be larger ends behind its last whole tick. That is logged, counted (record_failures) and told "
        "as degraded health, as with the limits below and with a disk that refuses or does not keep up."},
    {"record_keep_free", CONFIG_NUMBER, FIELD(record_keep_free), 0, 100, NULL, "2", "%",
        "of the disk that is recorded to: what stays free",
        "A recording that would leave less ends, or does not begin."},
    {"record_max_files", CONFIG_WHOLE, FIELD(record_max_files), 1, 1000000, NULL, "100", "files",
        "recordings in record_dir",
        "Counts what ends in .lcmlog there. With as many, clients may begin no further one."},
    {"record_max_time", CONFIG_NUMBER, FIELD(record_max_time), 0.1, 31536000, NULL, "86400", "s",
        "how long a recording takes that a client has begun",
        "Who has begun a recording may end it, and nobody else: the operator ends any by SIGUSR1. If its client is "
        "gone it ends by this limit, or by one of the others."},
    {"replay", CONFIG_TEXT, FIELD(replay), 0, 0, NULL, "", "",
        "run a recording instead of live links, compare its hashes, and end",
        "No link is opened. The exit status is 0 if every tick is equal to the recording, wherever in a session that "
        "begins. One that begins in the middle holds the daemon's state, which is believed: replay recordings of "
        "people whose programs you would run. What decides which commands are refused and what is reported (engine, "
        "and "
        "limits other than rates) is taken from the recording, where it is not given to the replay."},
    {"replay_speed", CONFIG_NUMBER, FIELD(replay_speed), 0, 1000000, NULL, "0", "times",
        "how fast to replay, as a multiple of the recorded time; 0: as fast as possible",
        "The events are the same at any speed: ticks are given the recorded clock. SIGINT ends it after the tick that "
        "runs, and what came until then is compared."},
    {"replay_pipe", CONFIG_TEXT, FIELD(replay_pipe), 0, 0, NULL, "", "descriptors",
        "serve the replay to a client at the other end of this pipe, and do what standard input says",
        "For collided-web --file, collidectl export and their like, which start this program with two socket pairs "
        "(3,4). Commands and answers: daemon/service/replay_served.h. Needs replay; nothing is compared."},
    {"trade", CONFIG_YES, FIELD(trade), 0, 0, NULL, "no", "",
        "replay at every accuracy side by side, and print what each costs and how far off it is",
        "For collidectl trade, which makes a table, a picture and a recommendation of what this prints. Needs replay; "
        "the recorded subscriptions are asked in each accuracy instead of their own. One worker if workers is 0."},
    {"json", CONFIG_YES, FIELD(json), 0, 0, NULL, "no", "", "print the result of a replay as a JSON object",
        "Only of use with replay."},
    {"metrics_port", CONFIG_WHOLE, FIELD(metrics_port), 0, 65535, NULL, "0", "TCP port",
        "port with figures for Prometheus (/metrics) and for probes (/ready); 0: none",
        "Only this machine can reach it, unless metrics_address says otherwise. Figures are renewed with each Status; "
        "collidectl status shows the same ones."},
    {"metrics_address", CONFIG_TEXT, FIELD(metrics_address), 0, 0, NULL, "127.0.0.1", "",
        "address of this machine, as a number, that metrics_port is on; 0.0.0.0: all of them",
        "Whoever reaches it can read the figures: there is no password and no encryption."},
    {"metrics_hosts", CONFIG_TEXT, FIELD(metrics_hosts), 0, 0, NULL, "", "",
        "names that requests for figures may give as their Host, divided by spaces; *: any",
        "On loopback localhost and its addresses are taken without this, on another metrics_address all addresses and "
        "names without a dot (http://collided:9464). So no page of a stranger's in a browser gets to the figures under "
        "a name of the stranger's. Requests with a foreign Origin are refused in any case."},
    {"log", CONFIG_CHOICE, FIELD(log), 0, 0, "error|warning|notice|info|debug", "notice", "", "least level to log",
        "Lines go to standard error. A flood of like lines is cut to ten a second, and counted."},
    {"journal", CONFIG_YES, FIELD(journal), 0, 0, NULL, "no", "", "mark log lines with their level for the journal",
        "Set by the systemd unit; of no use in a terminal."},
};
enum { OPTION_COUNT = sizeof OPTIONS / sizeof *OPTIONS };

const config_option *config_options(size_t *count)
{
    *count = OPTION_COUNT;
    return OPTIONS;
}

/* ---- values ---- */

static int refuse_value(char *why, size_t size, const config_option *o, const char *value, const char *allowed)
{
    snprintf(why, size, "%s = \"%.80s\": allowed is %s", o->key, value, allowed);
    return -1;
}

static int set_number(config *c, const config_option *o, const char *value, char *why, size_t why_size)
{
    char allowed[160], *end;
    errno = 0;
    double number = strtod(value, &end);
    bool whole = o->type == CONFIG_WHOLE;
    snprintf(allowed, sizeof allowed, "a %snumber from %.10g to %.10g%s%s", whole ? "whole " : "", o->least, o->most,
        *o->unit ? " " : "", o->unit);
    bool good = end != value && !*end && !errno && number >= o->least && number <= o->most;
    if (!good || (whole && number != floor(number))) return refuse_value(why, why_size, o, value, allowed);
    if (whole)
        *(long *)((char *)c + o->offset) = (long)number;
    else
        *(double *)((char *)c + o->offset) = number;
    return 0;
}

static int set_yes(config *c, const config_option *o, const char *value, char *why, size_t why_size)
{
    bool yes = !strcmp(value, "yes") || !strcmp(value, "true") || !strcmp(value, "1");
    bool no = !strcmp(value, "no") || !strcmp(value, "false") || !strcmp(value, "0");
    if (!yes && !no) return refuse_value(why, why_size, o, value, "yes or no");
    *(bool *)((char *)c + o->offset) = yes;
    return 0;
}

static bool is_choice(const char *choices, const char *value)
{
    size_t length = strcspn(value, "|");
    if (value[length]) return false;
    for (const char *at = choices; length && at; at = strchr(at, '|')) {
        at += *at == '|';
        if (strncmp(at, value, length) == 0 && (at[length] == '|' || !at[length])) return true;
    }
    return false;
}

static int set_text(config *c, const config_option *o, const char *value, char *why, size_t why_size)
{
    char allowed[96];
    if (o->type == CONFIG_CHOICE && !is_choice(o->choices, value))
        return refuse_value(why, why_size, o, value, o->choices);
    if (strlen(value) >= o->size) {
        snprintf(allowed, sizeof allowed, "at most %zu characters", o->size - 1);
        return refuse_value(why, why_size, o, value, allowed);
    }
    memcpy((char *)c + o->offset, value, strlen(value) + 1);
    return 0;
}

int config_set(config *c, const char *key, const char *value, char *why, size_t why_size)
{
    for (size_t i = 0; i < OPTION_COUNT; i++) {
        const config_option *o = &OPTIONS[i];
        if (strcmp(o->key, key) != 0) continue;
        if (o->type == CONFIG_WHOLE || o->type == CONFIG_NUMBER) return set_number(c, o, value, why, why_size);
        if (o->type == CONFIG_YES) return set_yes(c, o, value, why, why_size);
        return set_text(c, o, value, why, why_size);
    }
    snprintf(why, why_size, "unknown key \"%.80s\"; collided --help lists them", key);
    return -1;
}

void config_default(config *c)
{
    char why[CONFIG_TEXT_MAX];
    memset(c, 0, sizeof *c);
    for (size_t i = 0; i < OPTION_COUNT; i++) {
        if (config_set(c, OPTIONS[i].key, OPTIONS[i].value, why, sizeof why) == 0) continue;
        fprintf(stderr, "%s\n", why); /* the table contradicts itself */
        abort();
    }
}

/* ---- files ---- */

static char *trim(char *text)
{
    text += strspn(text, " \t\r");
    size_t length = strlen(text);
    while (length && strchr(" \t\r", text[length - 1])) text[--length] = '\0';
    return text;
}

static int set_line(config *c, char *text, char *why, size_t why_size)
{
    char *comment = strchr(text, '#');
    if (comment) *comment = '\0';
    text = trim(text);
    if (!*text) return 0;
    char *equals = strchr(text, '=');
    if (!equals) {
        snprintf(why, why_size, "\"%.80s\" is not of the form: key = value", text);
        return -1;
    }
    *equals = '\0';
    return config_set(c, trim(text), trim(equals + 1), why, why_size);
}

int config_parse(config *c, const char *text, size_t size, const char *path, char *why, size_t why_size)
{
    char line[2 * CONFIG_TEXT_MAX], reason[CONFIG_TEXT_MAX];
    const char *end = text + size;
    for (unsigned number = 1; text < end; number++) {
        const char *stop = memchr(text, '\n', (size_t)(end - text));
        size_t length = (size_t)((stop ? stop : end) - text);
        if (length >= sizeof line || memchr(text, '\0', length)) {
            snprintf(why, why_size, "%s:%u: line too long, or not text", path, number);
            return -1;
        }
        memcpy(line, text, length);
        line[length] = '\0';
        if (set_line(c, line, reason, sizeof reason) != 0) {
            snprintf(why, why_size, "%s:%u: %s", path, number, reason);
            return -1;
        }
        text += length + 1;
    }
    return 0;
}

int config_read(config *c, const char *path, char *why, size_t why_size)
{
    enum { FILE_MAX = 1 << 20 };
    char fault[256];
    FILE *file = wire_file_open(path, UINT64_MAX, NULL, fault, sizeof fault);
    char *text = file ? malloc(FILE_MAX + 1) : NULL;
    size_t size = text ? fread(text, 1, FILE_MAX + 1, file) : 0;
    bool unread = !text || ferror(file);
    int status = EX_OK;
    if (unread) {
        snprintf(why, why_size, "%s: %s: name a readable file with --config, or leave it out", path,
            file ? strerror(errno) : fault);
        status = EX_NOINPUT;
    } else if (size > FILE_MAX) {
        snprintf(why, why_size, "%s: larger than %d bytes: it cannot be a configuration", path, FILE_MAX);
        status = EX_CONFIG;
    } else if (config_parse(c, text, size, path, why, why_size) != 0) {
        status = EX_CONFIG;
    }
    if (file) fclose(file);
    free(text);
    return -status;
}

/* ---- the command line ---- */

static bool is_yes_option(const char *key)
{
    for (size_t i = 0; i < OPTION_COUNT; i++)
        if (strcmp(OPTIONS[i].key, key) == 0) return OPTIONS[i].type == CONFIG_YES;
    return false;
}

/* Splits the argument at *at into key and value, and moves *at past both. */
static int split_argument(int argc, char **argv, int *at, char key[64], const char **value, char *why, size_t why_size)
{
    const char *text = argv[(*at)++];
    const char *equals = strchr(text, '=');
    size_t length = equals ? (size_t)(equals - text) : strlen(text);
    if (strncmp(text, "--", 2) != 0 || length - 2 >= 63) {
        snprintf(why, why_size, "\"%.80s\" is not an option; collided --help lists them", text);
        return -1;
    }
    memcpy(key, text + 2, length - 2);
    key[length - 2] = '\0';
    for (char *k = key; *k; k++)
        if (*k == '-') *k = '_';
    if (equals) {
        *value = equals + 1;
    } else if (is_yes_option(key) || !strcmp(key, "help") || !strcmp(key, "version")) {
        *value = "yes";
    } else if (*at < argc) {
        *value = argv[(*at)++];
    } else {
        snprintf(why, why_size, "--%s needs a value", key);
        return -1;
    }
    return 0;
}

int config_arguments(config *c, int argc, char **argv, const char **asked, char *why, size_t why_size)
{
    char key[64];
    const char *value;
    for (int pass = 0; pass < 2; pass++) {
        for (int at = 1; at < argc;) {
            if (split_argument(argc, argv, &at, key, &value, why, why_size) != 0) return -EX_USAGE;
            bool is_file = strcmp(key, "config") == 0;
            if (!strcmp(key, "help") || !strcmp(key, "version")) {
                *asked = key[0] == 'h' ? "help" : "version";
                return 1;
            }
            if (is_file != (pass == 0)) continue;
            int failed = is_file ? config_read(c, value, why, why_size) : config_set(c, key, value, why, why_size);
            if (failed) return is_file ? failed : -EX_USAGE;
        }
    }
    return 0;
}

/* ---- help ---- */

static const config_exit EXITS[] = {
    {EX_OK, "EX_OK", "ended in order, by SIGTERM or SIGINT, or a replay that is equal to its recording"},
    {EX_USAGE, "EX_USAGE", "unknown option, or a value out of its range, on the command line"},
    {EX_DATAERR, "EX_DATAERR",
        "the recording to replay is damaged, or no recording, or a trade finds nothing in it to compare"},
    {EX_NOINPUT, "EX_NOINPUT", "the configuration file, the recording to replay or the security folder cannot be read"},
    {EX_NOHOST, "EX_NOHOST", "the network interface is not on this machine"},
    {EX_UNAVAILABLE, "EX_UNAVAILABLE", "DDS or LCM does not start: no route, no interface, a port is taken"},
    {EX_SOFTWARE, "EX_SOFTWARE", "a replay differs from its recording"},
    {EX_OSERR, "EX_OSERR", "a limit of the system is too small"},
    {EX_OSFILE, "EX_OSFILE", "a library or the LCM gateway is missing"},
    {EX_CANTCREAT, "EX_CANTCREAT", "the recording or its folder is not there, not to be written, or exists already"},
    {EX_IOERR, "EX_IOERR", "the result of a trade cannot be written"},
    {EX_NOPERM, "EX_NOPERM", "this user may not write the recording, or not become another user"},
    {EX_CONFIG, "EX_CONFIG",
        "the configuration file is broken, or the links or the user are, or a trade has nothing to replay"},
};

/* ---- what a replay has to have in common with the session ---- */

/* Rates are looked at before a message is recorded. */
static bool is_deciding(const config_option *o)
{
    bool is_rate = !strcmp(o->key, "max_client_messages") || !strcmp(o->key, "max_client_poses") ||
                   !strcmp(o->key, "max_client_work") || !strcmp(o->key, "max_query_work") ||
                   !strcmp(o->key, "max_waiting");
    return !strcmp(o->key, "engine") || (!strncmp(o->key, "max_", 4) && !is_rate);
}

static void write_value(const config *c, const config_option *o, char value[CONFIG_TEXT_MAX])
{
    const char *at = (const char *)c + o->offset;
    if (o->type == CONFIG_WHOLE)
        snprintf(value, CONFIG_TEXT_MAX, "%ld", *(const long *)at);
    else
        snprintf(value, CONFIG_TEXT_MAX, "%s", at);
}

void config_report_deciding(const config *c, char text[CONFIG_DECIDING_MAX])
{
    size_t used = 0;
    text[0] = '\0';
    for (size_t i = 0; i < OPTION_COUNT; i++) {
        char value[CONFIG_TEXT_MAX];
        if (!is_deciding(&OPTIONS[i])) continue;
        write_value(c, &OPTIONS[i], value);
        if (strcmp(value, OPTIONS[i].value) != 0)
            used += (size_t)snprintf(text + used, CONFIG_DECIDING_MAX - used, "%s = %s\n", OPTIONS[i].key, value);
    }
}

int config_take_deciding(config *c, const char *text, size_t size, char *why, size_t why_size)
{
    config reported;
    config_default(&reported);
    if (config_parse(&reported, text, size, "the recording's settings", why, why_size) != 0) return -1;
    for (size_t i = 0; i < OPTION_COUNT; i++) {
        const config_option *o = &OPTIONS[i];
        char here[CONFIG_TEXT_MAX], there[CONFIG_TEXT_MAX];
        if (!is_deciding(o)) continue;
        write_value(c, o, here);
        write_value(&reported, o, there);
        if (strcmp(here, o->value) == 0 && config_set(c, o->key, there, why, why_size) != 0) return -1;
    }
    return 0;
}

const config_exit *config_exits(size_t *count)
{
    *count = sizeof EXITS / sizeof *EXITS;
    return EXITS;
}

void config_help(void)
{
    printf("Usage: collided [--config FILE] [--KEY VALUE]...\n\n"
           "A collision daemon: clients publish the poses of their bodies over DDS or LCM, and are told\n"
           "what touches and what is near. Each key may also stand in the file, as: key = value\n\n");
    for (size_t i = 0; i < OPTION_COUNT; i++) {
        const config_option *o = &OPTIONS[i];
        printf("  --%-21s %s\n  %23s ", o->key, o->help, "");
        if (o->type == CONFIG_WHOLE || o->type == CONFIG_NUMBER)
            printf("%.10g to %.10g %s; ", o->least, o->most, o->unit);
        else if (o->type == CONFIG_CHOICE)
            printf("%s; ", o->choices);
        else if (o->type == CONFIG_YES)
            printf("yes (alone), or no by --%s=no; ", o->key);
        printf("default: %s\n", *o->value ? o->value : "(empty)");
    }
    printf("  --%-21s %s\n  --%-21s %s\n  --%-21s %s\n", "config FILE", "read this file first", "help", "this text",
        "version", "the release and the version of the wire");
    printf("\nExit status, by sysexits.h:\n");
    for (size_t i = 0; i < sizeof EXITS / sizeof *EXITS; i++) printf("  %4d  %s\n", EXITS[i].status, EXITS[i].meaning);
    printf("\nSee also: man collided, man collided.conf\n");
}
