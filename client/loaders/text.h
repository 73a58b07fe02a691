/* text: files and numbers as text. Numbers are read the same way under every locale. One thread a pool. */
#ifndef COLLIDED_LOADERS_TEXT_H
#define COLLIDED_LOADERS_TEXT_H

#include "pool.h"
#include "report.h"

#include <stdbool.h>
#include <stddef.h>

/* The whole file, with a zero byte behind it; NULL (and the report) when it cannot be read or is larger than `most`. */
char *text_read_file(pool *p, const char *path, size_t most, size_t *size, load_report *r);

/* The whole of `text` is one finite decimal number. */
bool text_number(const char *text, double *out);

/* Reads numbers divided by any of `dividers`; how many there were (of which at most `most` are in `out`), or -1 if
 * there is anything else in `text`. */
int text_numbers(const char *text, const char *dividers, double *out, int most);

/* A name that the wire takes and that means only itself as a pattern: 1 to 127 bytes, no control characters, no '*' or
 * '?', no "group:" in front. What is wrong with it, or NULL. */
const char *text_name_fault(const char *name);

/* A name pattern of collided: '*' stands for any run of characters, '?' for one byte, everything else for itself. */
bool text_matches(const char *pattern, const char *name);

/* The folder of a path ("." if it has none), and a path relative to it made whole. */
char *text_folder(pool *p, const char *path);
char *text_beside(pool *p, const char *folder, const char *path);

#endif
