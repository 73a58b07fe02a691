/* wire_file: files that somebody names, opened for reading: regular ones only. A FIFO or a device under that name would
 * be waited for, or never end. Any thread. */
#ifndef COLLIDED_WIRE_FILE_H
#define COLLIDED_WIRE_FILE_H

#include <stddef.h>
#include <stdint.h>
#include <stdio.h>

/* Never waits. NULL, with what is wrong in `fault` (without the path): it is not there, may not be read, is no regular
 * file, or has more than `most` bytes. *size may be NULL. The caller closes it with fclose. */
FILE *wire_file_open(const char *path, uint64_t most, uint64_t *size, char *fault, size_t fault_size);

#endif
