/* show: numbers for people: lengths in mm below one metre, ages in ms below one second, times in s. Pure. */
#ifndef COLLIDED_COLLIDECTL_SHOW_H
#define COLLIDED_COLLIDECTL_SHOW_H

#include <stddef.h>

void show_interval(double lo_m, double hi_m, char *out, size_t size); /* "[22.134, 22.135] mm" */
void show_bracket(double lo_s, double hi_s, char *out, size_t size);  /* "[0.730000, 0.730001] s" */
void show_age(double age_s, char *out, size_t size);                  /* "3 ms", "-" for -1 */

#endif
