/* heights: ground by heights over a grid, from a file: a plain text matrix, or a grey PNG of 8 or 16 bits. One thread a
 * pool.
 *
 * Text: a row a line, its numbers in metres, divided by blanks, tabs, commas or semicolons; the first line is the row
 * with the least y. Lines that are empty or begin with '#' are passed over. Every row has as many numbers.
 *
 * PNG: a picture seen from above, y up: its lowest line of pixels is the row with the least y. Black stands `range[0]`
 * high, white `range[1]`, m; what the file says of gamma and of transparent colours does not count. */
#ifndef COLLIDED_LOADERS_HEIGHTS_H
#define COLLIDED_LOADERS_HEIGHTS_H

#include "pool.h"
#include "report.h"

#include <stdbool.h>
#include <stddef.h>

enum {
    HEIGHTS_FILE_MAX = 64 << 20, /* bytes */
    HEIGHTS_MAX = 1 << 21        /* more have more triangles than the daemon takes in a mesh */
};

typedef struct heights_grid {
    const double *at; /* m, rows x columns, the row with the least y first */
    size_t rows, columns;
} heights_grid;

/* `range`: of a picture, NULL for text. */
bool heights_load(pool *p, const char *path, const double *range, heights_grid *out, load_report *r);

/* The same from memory; data[size] is a zero byte. `path` is for messages. */
bool heights_parse(
    pool *p, char *data, size_t size, const char *path, const double *range, heights_grid *out, load_report *r);

/* heights_png.c: is it a PNG, and its pixels as 0 to 1, the lowest line first. */
bool heights_is_png(const char *data, size_t size);
bool heights_parse_png(pool *p, const char *data, size_t size, const char *path, heights_grid *out, load_report *r);

#endif
