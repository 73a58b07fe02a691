/* Any bytes as a recording: entries, then its end or an error with an offset. The file is in memory. */
#include "fuzz.h"

#include "wire/wire_log.h"

#include <string.h>
#include <sys/mman.h>
#include <unistd.h>

static void read_all(wire_log_reader *r, size_t size)
{
    wire_log_entry e;
    wire_refusal refusal;
    uint64_t skipped = 0, entries = 0;
    char why[256] = "";
    int got;
    while ((got = wire_log_next(r, &e, &skipped, why, sizeof why)) == 1) {
        PROMISE(++entries <= size / 28); /* a record's head has so many bytes */
        if (e.kind == WIRE_LOG_MESSAGE) PROMISE(wire_check(&e.message, &refusal) == WIRE_OK);
    }
    PROMISE(got == 0 || strncmp(why, "damaged at byte ", 16) == 0);
    PROMISE(entries + skipped <= size / 28);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    static int fd = -1;
    char path[64], why[256];
    if (fd < 0) fd = memfd_create("log", MFD_CLOEXEC);
    snprintf(path, sizeof path, "/proc/self/fd/%d", fd);
    PROMISE(ftruncate(fd, 0) == 0 && pwrite(fd, data, size, 0) == (ssize_t)size);
    wire_log_reader *r = wire_log_open(path, why, sizeof why);
    PROMISE(r);
    read_all(r, size);
    wire_log_end(r);
    return 0;
}
