/* gateway_words: what the gateway writes to its standard error, line by line: into the log, which limits how much of it
 * there is; or, while it starts, kept, because its first line says why it does not. The thread that watches it. */
#ifndef COLLIDED_LINK_GATEWAY_WORDS_H
#define COLLIDED_LINK_GATEWAY_WORDS_H

#include <stdbool.h>
#include <stddef.h>

typedef struct gateway_words {
    int fd;          /* -1: none */
    bool keep;       /* the first line is kept, the others are not looked at */
    char first[384]; /* kept; "" = it has said nothing */
    char line[384];  /* what has come of a line */
    size_t used;
} gateway_words;

void gateway_words_begin(gateway_words *w, int fd, bool keep);
bool gateway_words_read(gateway_words *w);   /* what is there now; false: there will be no more */
void gateway_words_report(gateway_words *w); /* it has started: what was kept goes into the log, and all that follows */
void gateway_words_end(gateway_words *w);    /* reads the rest, and closes */

#endif
