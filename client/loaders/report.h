/* report: what a loader has to say: one error that ended it, and warnings on the way. Plain value of the caller; one
 * thread. The first error stands; those that follow from it do not replace it. */
#ifndef COLLIDED_LOADERS_REPORT_H
#define COLLIDED_LOADERS_REPORT_H

#include <stdbool.h>

typedef struct load_report {
    char error[1024]; /* one line, "file:line: what is wrong and what to do"; "" = none */
    unsigned warnings;
    void (*warn)(void *context, const char *text); /* NULL = only counted */
    void (*note)(void *context, const char *text); /* what was made of a mesh; NULL = untold */
    void *context;
} load_report;

/* Always false, so that a loader can end with `return load_fail(...)`. */
__attribute__((format(printf, 2, 3))) bool load_fail(load_report *r, const char *format, ...);
__attribute__((format(printf, 2, 3))) void load_warn(load_report *r, const char *format, ...);
__attribute__((format(printf, 2, 3))) void load_note(load_report *r, const char *format, ...);

#endif
