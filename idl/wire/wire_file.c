/* wire_file: opened without waiting (a FIFO would wait for whoever writes to it, a terminal for its carrier), and then
 * asked what it is: what was asked by name could be another file by now. */
#include "wire_file.h"

#include <errno.h>
#include <fcntl.h>
#include <inttypes.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

static const char *kind_of(mode_t mode)
{
    return S_ISDIR(mode) ? "a directory" : S_ISFIFO(mode) ? "a FIFO" : S_ISSOCK(mode) ? "a socket" : "a device";
}

static FILE *close_failed(int fd)
{
    if (fd >= 0) close(fd);
    return NULL;
}

FILE *wire_file_open(const char *path, uint64_t most, uint64_t *size, char *fault, size_t fault_size)
{
    struct stat is;
    int fd = open(path, O_RDONLY | O_NONBLOCK | O_NOCTTY | O_CLOEXEC);
    FILE *file = NULL;
    if (fd < 0 || fstat(fd, &is) != 0) {
        (void)snprintf(
            fault, fault_size, "%s", errno == ENXIO ? "is not a file, but a socket or a device" : strerror(errno));
        return close_failed(fd);
    }
    if (!S_ISREG(is.st_mode)) {
        (void)snprintf(fault, fault_size, "is not a file, but %s", kind_of(is.st_mode));
        return close_failed(fd);
    }
    if ((uint64_t)is.st_size > most) {
        (void)snprintf(
            fault, fault_size, "has %" PRIu64 " bytes, more than the %" PRIu64 " allowed", (uint64_t)is.st_size, most);
        return close_failed(fd);
    }
    if (!(file = fdopen(fd, "rb"))) {
        (void)snprintf(fault, fault_size, "%s", strerror(errno));
        return close_failed(fd);
    }
    if (size) *size = (uint64_t)is.st_size;
    return file;
}
