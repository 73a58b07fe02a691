/* datagram_filter: liblcm 1.3.1 believes each datagram's header. A channel without an end is read on into what the
 * buffer held before, and the length of the data then is negative; a fragment whose offset and size wrap around 32 bits
 * is copied over 4 GB of memory. So the kernel looks first, by a classic BPF program (socket(7), SO_ATTACH_FILTER) that
 * needs no privilege. A load beyond the datagram drops it, which is what becomes of all that is cut short.
 *
 * A datagram of LCM, big-endian, behind the 8 bytes of UDP's header:
 *   short      "LC02", number; channel and its NUL; data
 *   fragment   "LC03", number, size of the message, offset of the fragment (u32 each), its number and how many there
 *              are (u16 each); the first one goes on with the channel and its NUL; data */
#include "datagram_filter.h"

#include "pipe/pipe.h"

#include <assert.h>
#include <linux/filter.h>
#include <linux/sock_diag.h>
#include <stddef.h>
#include <sys/socket.h>

enum {
    AT_MAGIC = 8,
    AT_SHORT_CHANNEL = 16,
    AT_SIZE = 16,
    AT_OFFSET = 20,
    AT_NUMBER = 24,
    AT_COUNT = 26,
    AT_FRAGMENT = 28,
    DROP = 0,
    ACCEPT = -1, /* all of its bytes */
    STEPS_MAX = 512,
    STEPS_A_BYTE = 3
};
enum { MAGIC_SHORT = 0x4c433032, MAGIC_FRAGMENT = 0x4c433033 };
enum { CELL_SIZE, CELL_COUNT, CELL_PAYLOAD, CELL_OFFSET }; /* BPF's scratch memory */

typedef struct program {
    struct sock_filter at[STEPS_MAX];
    unsigned short count;
} program;

static void add(program *p, uint16_t code, uint32_t k)
{
    assert(p->count < STEPS_MAX);
    p->at[p->count++] = (struct sock_filter){.code = code, .k = k};
}

/* Goes on where the comparison of A with k (or with X) comes out as `wanted`, and drops the datagram otherwise. */
static void require(program *p, uint16_t comparison, uint32_t k, bool wanted)
{
    add(p, BPF_JMP | comparison, k);
    p->at[p->count - 1].jt = wanted ? 1 : 0;
    p->at[p->count - 1].jf = wanted ? 0 : 1;
    add(p, BPF_RET | BPF_K, DROP);
}

/* A NUL within the longest channel's length, and within the datagram. Ends the program. */
static void require_channel(program *p, uint32_t at)
{
    for (uint32_t i = 0; i <= PIPE_CHANNEL_MAX; i++) {
        add(p, BPF_LD | BPF_B | BPF_ABS, at + i);
        add(p, BPF_JMP | BPF_JEQ | BPF_K, 0);
        p->at[p->count - 1].jf = 1;
        add(p, BPF_RET | BPF_K, (uint32_t)ACCEPT);
    }
    add(p, BPF_RET | BPF_K, DROP);
}

/* The fragment lies within its message, which is no larger than any that is legal; and each but the last holds its
 * share of the message, so that nobody has memory reserved by datagrams that bring nothing. Nothing wraps around: sizes
 * are below 2^24, and 2^16 fragments of 2^16 bytes at most. Ends the program. */
static void require_fragment(program *p)
{
    add(p, BPF_LD | BPF_W | BPF_LEN, 0);
    require(p, BPF_JGE | BPF_K, AT_FRAGMENT, true);
    add(p, BPF_ALU | BPF_SUB | BPF_K, AT_FRAGMENT);
    add(p, BPF_ST, CELL_PAYLOAD);
    add(p, BPF_LD | BPF_W | BPF_ABS, AT_SIZE);
    require(p, BPF_JGT | BPF_K, PIPE_DATA_MAX, false);
    add(p, BPF_ST, CELL_SIZE);
    add(p, BPF_LD | BPF_W | BPF_ABS, AT_OFFSET);
    add(p, BPF_ST, CELL_OFFSET);
    add(p, BPF_LDX | BPF_MEM, CELL_SIZE);
    require(p, BPF_JGT | BPF_X, 0, false); /* offset > size */
    add(p, BPF_LD | BPF_H | BPF_ABS, AT_COUNT);
    add(p, BPF_ST, CELL_COUNT);
    add(p, BPF_LDX | BPF_MEM, CELL_COUNT);
    add(p, BPF_LD | BPF_H | BPF_ABS, AT_NUMBER);
    require(p, BPF_JGE | BPF_X, 0, false); /* number >= count */
    add(p, BPF_ALU | BPF_ADD | BPF_K, 1);  /* NOLINT(misc-redundant-expression): BPF_ADD and BPF_K are both 0 */
    add(p, BPF_JMP | BPF_JEQ | BPF_X, 0);  /* the last one: the end is its share */
    size_t last = (size_t)p->count - 1;
    add(p, BPF_LD | BPF_MEM, CELL_PAYLOAD);
    add(p, BPF_ALU | BPF_MUL | BPF_X, 0);
    add(p, BPF_JMP | BPF_JA, 3);
    p->at[last].jt = (uint8_t)(p->count - last - 1);
    add(p, BPF_LDX | BPF_MEM, CELL_OFFSET);
    add(p, BPF_LD | BPF_MEM, CELL_PAYLOAD);
    add(p, BPF_ALU | BPF_ADD | BPF_X, 0);
    add(p, BPF_LDX | BPF_MEM, CELL_SIZE);
    require(p, BPF_JGE | BPF_X, 0, true);
    add(p, BPF_LD | BPF_H | BPF_ABS, AT_NUMBER);
    add(p, BPF_JMP | BPF_JEQ | BPF_K, 0); /* the first one has a channel */
    p->at[p->count - 1].jt = 1;
    add(p, BPF_RET | BPF_K, (uint32_t)ACCEPT);
    require_channel(p, AT_FRAGMENT);
}

bool datagram_filter_attach(int fd)
{
    enum { SHORT_STEPS = STEPS_A_BYTE * (PIPE_CHANNEL_MAX + 1) + 1 };
    static_assert(SHORT_STEPS <= UINT8_MAX, "a conditional jump goes no further");
    program p = {.count = 0};
    add(&p, BPF_LD | BPF_W | BPF_ABS, AT_MAGIC);
    add(&p, BPF_JMP | BPF_JEQ | BPF_K, MAGIC_SHORT);
    p.at[p.count - 1].jf = SHORT_STEPS;
    require_channel(&p, AT_SHORT_CHANNEL);
    require(&p, BPF_JEQ | BPF_K, MAGIC_FRAGMENT, true);
    require_fragment(&p);
    const struct sock_fprog whole = {.len = p.count, .filter = p.at};
    return setsockopt(fd, SOL_SOCKET, SO_ATTACH_FILTER, &whole, sizeof whole) == 0;
}

uint32_t datagram_drops(int fd)
{
    uint32_t reported[SK_MEMINFO_VARS] = {0};
    socklen_t size = sizeof reported;
    return getsockopt(fd, SOL_SOCKET, SO_MEMINFO, reported, &size) == 0 ? reported[SK_MEMINFO_DROPS] : 0;
}
