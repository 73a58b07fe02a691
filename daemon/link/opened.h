/* opened: the streams that a link has opened and not yet told the sink of, for links that cannot see their readers. The
 * tick thread. */
#ifndef COLLIDED_LINK_OPENED_H
#define COLLIDED_LINK_OPENED_H

#include "link.h"

#include "base/array.h"

typedef struct opened {
    ARRAY(char *) names;
} opened;

void opened_add(opened *o, const char *stream);
void opened_report(opened *o, struct link *from, const link_sink *sink); /* sink->stream_reader for each, once */
void opened_free(opened *o);

#endif
