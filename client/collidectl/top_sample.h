/* top_sample: copies of two Status of a daemon, one after the other, and what follows from them: figures, and rates
 * between the two (or since the daemon's start, where there is but one). One thread. */
#ifndef COLLIDED_COLLIDECTL_TOP_SAMPLE_H
#define COLLIDED_COLLIDECTL_TOP_SAMPLE_H

#include "collided.h"

typedef struct top_status { /* owned copies; empty: epoch 0 */
    int64_t epoch, tick, stamp_ns, started_ns;
    char *health, *daemon, *release, *links, *limits;
    char **names;
    int64_t *values;
    size_t count;
} top_status;

typedef struct top_sample {
    top_status now, before; /* before: of the same epoch, or empty */
} top_sample;

/* True if it is another Status than the last one; it is then `now`, and what was `now` is `before`. */
bool top_sample_take(top_sample *s, const collided_daemon_status *status);
void top_sample_free(top_sample *s);

double top_seconds(const top_sample *s); /* between the two, or since the start; above 0 */
/* 0 where a Status has no such figure: it may be of another release. */
int64_t top_figure(const top_sample *s, const char *name);
double top_rate(const top_sample *s, const char *name); /* of a counter, 1/s; not negative */
double top_load(const top_sample *s);                   /* share of the time that the tick thread was in ticks */

/* Each figure whose name begins so; *at is 0 at first. NULL: no more. `rest` is what follows the prefix. */
typedef struct top_member {
    const char *rest;
    int64_t value;
    double rate;
} top_member;
bool top_next(const top_sample *s, const char *prefix, size_t *at, top_member *out);

/* What is refused, dropped or lost, by cause: the counters that are not 0. */
typedef struct top_drop {
    const char *cause;
    int64_t total;
    double rate;
} top_drop;
bool top_next_drop(const top_sample *s, size_t *at, top_drop *out);

enum { TOP_ROWS_MAX = 64 }; /* as many as Status names */

typedef struct top_client {
    char id[17];
    const char *name;
    int64_t bodies, work, silent_ns, pose_age_ns; /* pose_age_ns: -1: it has no stamped pose */
    double poses;                                 /* 1/s */
} top_client;
size_t top_clients(const top_sample *s, top_client out[TOP_ROWS_MAX]); /* the costliest first */

typedef struct top_stream {
    const char *name;
    int64_t work;
    double events; /* 1/s */
} top_stream;
size_t top_streams(const top_sample *s, top_stream out[TOP_ROWS_MAX]); /* the costliest first */

#endif
