/* page: the figures of Status, and the histograms, in Prometheus' text format 0.0.4. Tick thread.
 *
 * What Status calls in_pose_batch is collided_messages_in_total{kind="pose_batch"} here: figures that differ by one
 * word become one family with a label, what only grows ends in _total, and times are seconds. */
#ifndef COLLIDED_SERVICE_PAGE_H
#define COLLIDED_SERVICE_PAGE_H

#include "base/array.h"
#include "base/histogram.h"
#include "base/metrics.h"

typedef ARRAY(char) page_text; /* not ended by a zero */

/* One figure after the other, as they come: those of a family must follow each other. `help` may be NULL where page.c
 * knows the name itself. */
void page_number(page_text *to, const char *name, const char *help, int64_t value);
void page_histogram(page_text *to, const histogram *h);
/* A constant 1 whose labels say what runs. */
void page_build_info(page_text *to, const char *release, const char *daemon);

#endif
