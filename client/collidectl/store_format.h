/* store_format: the store as text: a line a record, fields divided by tabs, with %XX for whatever would break that. */
#ifndef COLLIDED_COLLIDECTL_STORE_FORMAT_H
#define COLLIDED_COLLIDECTL_STORE_FORMAT_H

#include "store.h"

#include <stdio.h>

void store_write(const store *s, FILE *out);
/* One line without its newline, which is changed. False: it is damaged. */
bool store_read_line(store *s, char *line);

#endif
