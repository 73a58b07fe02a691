/* template: a hand-written text with places for what comes from a table. A line that ends in "TABLE name" (behind the
 * comment sign of its language) is replaced by what the section of that name writes. Build time only. */
#ifndef COLLIDED_MANUAL_TEMPLATE_H
#define COLLIDED_MANUAL_TEMPLATE_H

#include <stdio.h>

typedef struct template_section {
    const char *name;
    void (*write)(FILE *out);
} template_section;

/* Reads `from`, writes `to`. 0; or -1 after saying on standard error what is wrong: a file, or a name that `sections`
 * (ended by a NULL name) do not have. */
int template_write(const char *from, const char *to, const template_section *sections);

#endif
