/* opened: a list that is filled by stream_open and emptied by receive. The tick thread. */
#include "opened.h"

#include <stdlib.h>

void opened_add(opened *o, const char *stream)
{
    array_push(&o->names, base_strdup(stream));
}

/* The sink may open further streams meanwhile: those are told too. */
void opened_report(opened *o, struct link *from, const link_sink *sink)
{
    for (size_t i = 0; i < o->names.count; i++) {
        char *name = o->names.at[i];
        sink->stream_reader(sink->context, from, name);
        free(name);
    }
    o->names.count = 0;
}

void opened_free(opened *o)
{
    for (size_t i = 0; i < o->names.count; i++) free(o->names.at[i]);
    array_free(&o->names);
}
