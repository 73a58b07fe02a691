/* Who waits costs a descriptor and nothing else. Whoever hangs up, at any time, is forgotten. */
#include "link_dds_joiners.h"

#include "base/clock.h"
#include "base/log.h"
#include "wire/dds/wire_dds_turn.h"

#include <errno.h>
#include <poll.h>
#include <string.h>
#include <sys/eventfd.h>
#include <unistd.h>

enum { LISTEN_AGAIN_MS = 500 /* the other daemon of a pair may have ended */, BACKLOG = 4096 };
static const int64_t NS_PER_MS = 1000000;

static int open_socket(uint32_t domain)
{
    struct sockaddr_un address;
    socklen_t length = wire_dds_turn_address(domain, &address);
    int fd = socket(AF_UNIX, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0);
    if (fd < 0) return -1;
    if (bind(fd, (struct sockaddr *)&address, length) == 0 && listen(fd, BACKLOG) == 0) return fd;
    close(fd);
    return -1;
}

static void say(int fd, const char *words, size_t count)
{
    ssize_t sent = send(fd, words, count, MSG_NOSIGNAL | MSG_DONTWAIT);
    (void)sent; /* it has hung up: poll tells */
}

static unsigned waiting_of(const joiners *t, uint32_t user)
{
    unsigned n = 0;
    for (unsigned i = 0; i < t->count; i++) n += t->at[i].user == user && !t->at[i].until_ns;
    return n;
}

/* Who is there, and who has asked: of those whose turn it is some are counted twice. */
static unsigned count_all(joiners *t)
{
    unsigned all = 0;
    for (unsigned room = 0; room <= WIRE_DDS_ROOMS; room++) t->present[room] = t->rooms.present(t->rooms.link, room);
    for (unsigned i = 0; i < t->count; i++) t->present[t->at[i].room]++;
    for (unsigned room = 0; room <= WIRE_DDS_ROOMS; room++) all += t->present[room];
    return all;
}

/* Of a few rooms the emptiest; of those behind them only when these are full; when all are, the emptiest of all. */
static unsigned choose_room(joiners *t)
{
    unsigned best = 0;
    if (!t->rooms.may(t->rooms.link) || t->present[0] < JOINERS_BEFORE_ROOMS) return 0;
    for (unsigned room = 1; room <= WIRE_DDS_ROOMS; room++) {
        if ((room - 1) % JOINERS_ROOMS_TOGETHER == 0 && best && t->present[best] < WIRE_DDS_ROOM_CLIENTS) break;
        if (best && t->present[room] >= t->present[best]) continue;
        if (t->rooms.open(t->rooms.link, room)) best = room;
    }
    return best;
}

static void accept_one(joiners *t, int fd, unsigned *all)
{
    struct ucred who = {.uid = UINT32_MAX};
    socklen_t size = sizeof who;
    (void)getsockopt(fd, SOL_SOCKET, SO_PEERCRED, &who, &size);
    bool full = t->count == sizeof t->at / sizeof t->at[0] || waiting_of(t, who.uid) >= JOINERS_WAITING_USER;
    unsigned room = full ? 0 : choose_room(t);
    const char greeting[WIRE_DDS_TURN_GREETING] = {
        full ? WIRE_DDS_TURN_FULL : WIRE_DDS_TURN_WAIT, *all >= WIRE_DDS_CROWD, (char)room};
    say(fd, greeting, sizeof greeting);
    if (full) {
        metric_count(t->refused, 1);
        close(fd);
        return;
    }
    t->at[t->count++] = (joiner){.fd = fd, .user = who.uid, .room = (uint8_t)room};
    t->present[room]++;
    (*all)++;
}

/* At most so many a round, so that turns are given meanwhile. */
static void accept_all(joiners *t)
{
    unsigned all = count_all(t);
    for (unsigned i = 0; i < JOINERS_WAITING; i++) {
        int fd = accept4(t->listen_fd, NULL, NULL, SOCK_NONBLOCK | SOCK_CLOEXEC);
        if (fd < 0) return;
        accept_one(t, fd, &all);
    }
}

/* Who is in a room that this daemon has not opened, since it is new, and looks for it: it wants no turn. */
static bool knocks(joiners *t, const joiner *one)
{
    unsigned char words[2];
    bool knocked = recv(one->fd, words, sizeof words, MSG_DONTWAIT) == sizeof words && words[0] == WIRE_DDS_TURN_KNOCK;
    if (knocked && words[1] >= 1 && words[1] <= WIRE_DDS_ROOMS) (void)t->rooms.open(t->rooms.link, words[1]);
    return knocked;
}

/* A turn that took long says that the machine has no time: it gets as much again before the next turn. */
static void pause_after(joiners *t, const joiner *one, int64_t now)
{
    int64_t took = now - (one->until_ns - JOINERS_MS * NS_PER_MS), quick = JOINERS_QUICK_MS * NS_PER_MS;
    if (took > quick && !one->room) t->pause_until_ns = now + took - quick;
}

static bool is_over(joiners *t, const joiner *one, short events, int64_t now)
{
    if (events && !one->until_ns && !knocks(t, one)) {
        metric_count(t->given_up, 1);
        log_warning(
            "DDS: a client that waited for its turn to join has left, of %u: more come at once than can come in "
            "within their connect_timeout_s",
            t->count);
    }
    bool overdue = !events && one->until_ns && now >= one->until_ns;
    if (overdue) metric_count(t->overdue, 1);
    if (one->until_ns && events) pause_after(t, one, now); /* who is overdue may as well not come at all */
    return events || overdue;                              /* a client has nothing to say: it hung up */
}

/* `polled` holds the places that there were when it was made; those behind have come since. */
static void drop_those_over(joiners *t, const struct pollfd *polled, unsigned polled_count)
{
    int64_t now = clock_monotonic_ns();
    unsigned kept = 0;
    for (unsigned i = 0; i < t->count; i++) {
        if (is_over(t, &t->at[i], i < polled_count ? polled[i].revents : 0, now))
            close(t->at[i].fd);
        else
            t->at[kept++] = t->at[i];
    }
    t->count = kept;
}

typedef struct turns_given {
    unsigned joining;                     /* turns that are not over */
    int64_t alone_ns[WIRE_DDS_ROOMS + 1]; /* until then the last one of a room is to be alone there */
    int64_t over_ns;                      /* when the first one will have taken too long; INT64_MAX: there is none */
} turns_given;

/* Of a crowd each gets a processor late, and two at a time cost all who are there. */
static int64_t alone_ns(const joiners *t, unsigned room)
{
    int64_t ms = 2 * (int64_t)t->count;
    ms = ms < JOINERS_ALONE_MS ? JOINERS_ALONE_MS : ms > JOINERS_ALONE_MOST ? JOINERS_ALONE_MOST : ms;
    return (room ? JOINERS_ALONE_ROOM_MS : ms) * NS_PER_MS;
}

static turns_given look(const joiners *t)
{
    turns_given g = {.alone_ns = {t->pause_until_ns}, .over_ns = INT64_MAX};
    for (unsigned i = 0; i < t->count; i++) {
        const joiner *one = &t->at[i];
        int64_t until = one->until_ns, alone = until - JOINERS_MS * NS_PER_MS + alone_ns(t, one->room);
        if (!until) continue;
        g.joining++;
        if (until < g.over_ns) g.over_ns = until;
        if (alone > g.alone_ns[one->room]) g.alone_ns[one->room] = alone;
    }
    return g;
}

/* Who has waited longest where one may come now, of another user than the last if there is one. */
static joiner *next_of(joiners *t, const turns_given *g, int64_t now)
{
    joiner *first = NULL;
    for (unsigned i = 0; i < t->count; i++) {
        if (t->at[i].until_ns || now < g->alone_ns[t->at[i].room]) continue;
        if (t->at[i].user != t->last_user) return &t->at[i];
        if (!first) first = &t->at[i];
    }
    return first;
}

static bool give_one(joiners *t)
{
    turns_given g = look(t);
    int64_t now = clock_monotonic_ns();
    const char come = WIRE_DDS_TURN_COME;
    joiner *one = g.joining < JOINERS_AT_ONCE ? next_of(t, &g, now) : NULL;
    metric_set(t->waiting, t->count - g.joining - (one != NULL));
    if (!one) return false;
    one->until_ns = now + JOINERS_MS * NS_PER_MS;
    t->last_user = one->user;
    say(one->fd, &come, 1);
    metric_count(t->given, 1);
    return true;
}

static void give(joiners *t)
{
    while (give_one(t)) continue;
}

/* To change the participant's user data is Cyclone's only way to announce it now. */
static void call(joiners *t)
{
    int64_t now = clock_monotonic_ns(), ms;
    if (now < t->call_ns) return;
    ms = (int64_t)JOINERS_CALL_EACH_MS * t->rooms.present(t->rooms.link, 0);
    ms = ms < JOINERS_CALL_MS ? JOINERS_CALL_MS : ms > JOINERS_CALL_MOST_MS ? JOINERS_CALL_MOST_MS : ms;
    t->call_ns = now + ms * NS_PER_MS;
    t->called++;
    dds_qos_t *qos = dds_create_qos();
    dds_qset_userdata(qos, &t->called, sizeof t->called);
    (void)dds_set_qos(t->participant, qos); /* if it is refused, those 8 s of Cyclone's remain */
    dds_delete_qos(qos);
}

/* Until the next turn is over, the last one need not be alone any more, or a call is due, ms. */
static int wait_ms(const joiners *t)
{
    turns_given g = look(t);
    int64_t first = g.over_ns, now = clock_monotonic_ns();
    for (unsigned i = 0; i < t->count && g.joining < JOINERS_AT_ONCE; i++)
        if (!t->at[i].until_ns && g.alone_ns[t->at[i].room] < first) first = g.alone_ns[t->at[i].room];
    if (t->call_ns < first) first = t->call_ns;
    int64_t ms = first > now ? (first - now) / NS_PER_MS + 1 : 0;
    return t->listen_fd < 0 && ms > LISTEN_AGAIN_MS ? LISTEN_AGAIN_MS : (int)ms;
}

static void *run(void *context)
{
    joiners *t = context;
    struct pollfd fds[2 + sizeof t->at / sizeof t->at[0]];
    do {
        if (t->listen_fd < 0) t->listen_fd = open_socket(t->domain);
        unsigned count = t->count;
        fds[0] = (struct pollfd){.fd = t->stop_fd, .events = POLLIN};
        fds[1] = (struct pollfd){.fd = t->listen_fd, .events = POLLIN};
        for (unsigned i = 0; i < count; i++) fds[2 + i] = (struct pollfd){.fd = t->at[i].fd, .events = POLLIN};
        if (poll(fds, 2 + count, wait_ms(t)) < 0 && errno != EINTR) break;
        if (fds[1].revents) accept_all(t);
        drop_those_over(t, fds + 2, count);
        give(t);
        call(t);
    } while (!fds[0].revents);
    return NULL;
}

void joiners_start(joiners *t, uint32_t domain, dds_entity_t participant, const joiners_rooms *rooms, metrics *m)
{
    *t = (joiners){.rooms = *rooms,
        .domain = domain,
        .participant = participant,
        .stop_fd = eventfd(0, EFD_NONBLOCK | EFD_CLOEXEC),
        .listen_fd = open_socket(domain)};
    t->waiting = metrics_add(m, "dds_turns_waiting", "clients that wait for their turn to join over DDS");
    t->given = metrics_add(m, "dds_turns", "turns to join that were given to clients");
    t->overdue = metrics_add(m, "dds_turns_overdue", "turns to join that took longer than 2 s");
    t->refused = metrics_add(m, "dds_turns_refused", "clients told to ask for a turn again: too many wait");
    t->rooms_open = metrics_add(m, "dds_rooms", "rooms that are open for clients of a crowd");
    t->given_up = metrics_add(m, "dds_turns_given_up", "clients that left while they waited for their turn to join");
    t->runs = t->stop_fd >= 0 && pthread_create(&t->thread, NULL, run, t) == 0;
    if (!t->runs) log_warning("no thread that lets clients join in turns: a crowd that comes at once comes in slowly");
    if (!t->runs && t->listen_fd >= 0) close(t->listen_fd);
    if (!t->runs && t->stop_fd >= 0) close(t->stop_fd);
}

void joiners_end(joiners *t)
{
    const uint64_t one = 1;
    if (!t->runs) return;
    if (write(t->stop_fd, &one, sizeof one) == sizeof one) pthread_join(t->thread, NULL);
    for (unsigned i = 0; i < t->count; i++) close(t->at[i].fd);
    if (t->listen_fd >= 0) close(t->listen_fd);
    close(t->stop_fd);
    t->runs = false;
    t->count = 0;
}
