/* storm_network: TUN devices; one process, one thread. */
#include "storm_network.h"

#include <errno.h>
#include <fcntl.h>
#include <linux/if.h>
#include <linux/if_tun.h>
#include <poll.h>
#include <sched.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/ioctl.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <time.h>
#include <unistd.h>

enum { PACKET_MAX = 2048, HELD_MAX = 4096 };

typedef struct packet {
    int64_t due_ns; /* 0 = free */
    int to;
    size_t size;
    uint8_t bytes[PACKET_MAX];
} packet;

static packet held[HELD_MAX];
static uint64_t state = 1;

static uint64_t roll(uint64_t sides)
{
    state ^= state << 13;
    state ^= state >> 7;
    state ^= state << 17;
    return state % sides;
}

static int64_t now_ns(void)
{
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return (int64_t)t.tv_sec * 1000000000 + t.tv_nsec;
}

/* In the present namespace, with that address. */
static int open_device(const char *address)
{
    struct ifreq request = {.ifr_flags = IFF_TUN | IFF_NO_PI};
    char command[256];
    int fd = open("/dev/net/tun", O_RDWR | O_CLOEXEC | O_NONBLOCK);
    if (fd < 0) return -1;
    strcpy(request.ifr_name, STORM_NET_INTERFACE);
    snprintf(command, sizeof command,
        "PATH=/usr/sbin:/sbin:/usr/bin:/bin; ip link set lo up && ip addr add %s/24 dev " STORM_NET_INTERFACE
        " && ip link set " STORM_NET_INTERFACE
        " up multicast on && ip route replace 224.0.0.0/4 dev " STORM_NET_INTERFACE,
        address);
    if (ioctl(fd, TUNSETIFF, &request) == 0 && system(command) == 0) return fd; /* NOLINT(cert-env33-c): our own line */
    close(fd);
    return -1;
}

static void take(storm_network *n, int from, int to)
{
    uint8_t bytes[PACKET_MAX];
    for (ssize_t size; (size = read(from, bytes, sizeof bytes)) > 0;) {
        int slot = 0;
        while (slot < HELD_MAX && held[slot].due_ns) slot++;
        if (n->cut || (int)roll(100) < n->loss_percent || slot == HELD_MAX) {
            n->lost++;
            continue;
        }
        int64_t delay_ns = n->delay_most_ms ? (int64_t)roll((uint64_t)n->delay_most_ms * 1000000) : 0;
        held[slot] = (packet){.due_ns = now_ns() + delay_ns, .to = to, .size = (size_t)size};
        memcpy(held[slot].bytes, bytes, (size_t)size);
    }
}

/* Hands over what is due; how many ms until the next. */
static int give(storm_network *n)
{
    int64_t now = now_ns(), next = now + 10000000;
    for (int i = 0; i < HELD_MAX; i++) {
        packet *p = &held[i];
        if (!p->due_ns) continue;
        if (p->due_ns > now) {
            if (p->due_ns < next) next = p->due_ns;
            continue;
        }
        if (write(p->to, p->bytes, p->size) == (ssize_t)p->size) n->carried++;
        p->due_ns = 0;
    }
    return (int)((next - now) / 1000000) + 1;
}

static void carry(storm_network *n)
{
    int fds[2] = {open_device("10.9.0.1"), -1};
    if (fds[0] >= 0 && unshare(CLONE_NEWNET) == 0) fds[1] = open_device("10.9.0.2");
    if (fds[1] < 0) printf("skipped: no second host can be made here: %s\n", strerror(errno));
    fflush(stdout);
    n->ready = fds[1] < 0 ? -1 : 1;
    for (int ms = 10; fds[1] >= 0;) {
        struct pollfd p[2] = {{fds[0], POLLIN, 0}, {fds[1], POLLIN, 0}};
        poll(p, 2, ms);
        take(n, fds[0], fds[1]);
        take(n, fds[1], fds[0]);
        ms = give(n);
    }
    _exit(1);
}

pid_t storm_network_start(storm_network **n)
{
    *n = mmap(NULL, sizeof **n, PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0);
    if (*n == MAP_FAILED) return -1;
    fflush(stdout);
    pid_t pid = fork();
    if (pid == 0) {
        prctl(PR_SET_PDEATHSIG, SIGKILL);
        carry(*n);
    }
    while (pid > 0 && !(*n)->ready) usleep(1000);
    return pid > 0 && (*n)->ready > 0 ? pid : -1;
}

bool storm_network_enter(pid_t network)
{
    char path[64];
    snprintf(path, sizeof path, "/proc/%d/ns/net", (int)network);
    int fd = open(path, O_RDONLY | O_CLOEXEC);
    bool entered = fd >= 0 && setns(fd, CLONE_NEWNET) == 0;
    if (fd >= 0) close(fd);
    return entered;
}
