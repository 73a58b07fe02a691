/* Any bytes as a recording that is replayed: the service and the world take what is in it, in its ticks, and the replay
 * ends with a status that says how it went. */
#include "fuzz.h"

#include "base/log.h"
#include "service/config.h"
#include "service/server.h"

#include <string.h>
#include <sys/mman.h>
#include <sysexits.h>
#include <unistd.h>

static config settings(int fd)
{
    config c;
    config_default(&c);
    c.workers = 1;
    c.json = true;
    c.max_bodies = c.max_shapes = 256; /* a world that a second can tick */
    snprintf(c.replay, sizeof c.replay, "/proc/self/fd/%d", fd);
    return c;
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    static int fd = -1;
    char why[512];
    if (fd < 0) {
        fd = memfd_create("log", MFD_CLOEXEC);
        log_setup(LOG_ERROR, 0);
        PROMISE(freopen("/dev/null", "w", stdout));
    }
    PROMISE(ftruncate(fd, 0) == 0 && pwrite(fd, data, size, 0) == (ssize_t)size);
    config c = settings(fd);
    server *s = server_create(&c, why, sizeof why);
    if (!s) return 0;
    int status = server_run(s);
    PROMISE(status == EX_OK || status == EX_DATAERR || status == EX_SOFTWARE);
    server_destroy(s);
    return 0;
}
