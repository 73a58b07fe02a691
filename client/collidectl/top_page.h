/* top_page: what collidectl top shows, as lines of text for a screen of any size, or for none. Pure. */
#ifndef COLLIDED_COLLIDECTL_TOP_PAGE_H
#define COLLIDED_COLLIDECTL_TOP_PAGE_H

#include "top_sample.h"

typedef struct top_view {
    const top_sample *sample;
    double unheard_s;     /* 0: the daemon is heard; else for how long it has not been */
    bool styled;          /* with ANSI's bold and reverse */
    size_t columns, rows; /* of the screen; 0: no limit */
} top_view;

/* All lines, each ended by a newline; at most `rows`, each at most `columns` wide; owned by the caller. What comes from
 * outside, names and texts, has no control characters here. */
char *top_page(const top_view *v);

#endif
