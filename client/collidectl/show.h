/* show: numbers for people: lengths in mm below one metre, ages in ms below one second, times in s. Pure. */
#ifndef COLLIDED_COLLIDECTL_SHOW_H
#define COLLIDED_COLLIDECTL_SHOW_H

#include <collided.h>

/* "certain", "within_tolerance", "wide", "stopped_by_budget" */
const char *show_achieved(collided_achieved achieved);

void show_interval(double lo_m, double hi_m, char *out, size_t size); /* "[22.134, 22.135] mm" */
void show_bracket(double lo_s, double hi_s, char *out, size_t size);  /* "[0.730000, 0.730001] s" */
void show_age(double age_s, char *out, size_t size);                  /* "3 ms", "-" for -1 */
void show_length(double m, char *out, size_t size);                   /* "1.23 um"; below a nanometre "4e-15 m" */
void show_span(double s, char *out, size_t size);                     /* "114 ns", "29.6 us", "1.2 ms" */

#endif
