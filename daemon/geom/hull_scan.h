/* hull_scan: the farthest vertex of a small hull, by looking at all of them, as many side by side as the processor can.
 *
 * The height of a vertex is x dx + y dy + z dz, rounded after each operation and added from the left: in every lane of
 * every width the same bits as the scalar, so that no answer depends on the machine. No fused multiply-add. Pure; any
 * thread. */
#ifndef COLLIDED_GEOM_HULL_SCAN_H
#define COLLIDED_GEOM_HULL_SCAN_H

#include "hull.h"

enum { HULL_SCAN_MAX = 512 }; /* padded vertices: the heights of all stand on the stack */

typedef enum hull_scan_width { HULL_SCAN_PLAIN, HULL_SCAN_AVX2, HULL_SCAN_WIDTHS } hull_scan_width;

/* The least index among the vertices with the greatest computed dot(direction, v), by the widest kernel that this
 * processor has. For hulls of up to HULL_SCAN_MAX padded vertices. */
uint32_t hull_scan(const hull *h, vec3 direction);

/* Writes the vertices whose computed dot(direction, v) is at least `cut`, ascending, but no more than `most` of them;
 * how many there are, or `most` + 1 if more. For the same hulls. */
uint32_t hull_scan_above(const hull *h, vec3 direction, double cut, uint16_t *found, uint32_t most);

/* The greatest computed dot(direction, v) itself: -INFINITY for a direction that is not a number. For hulls of any
 * size. */
double hull_scan_top(const hull *h, vec3 direction);

/* The greatest and the least computed dot(d[k], v) of all vertices, for three directions in one pass. For the same
 * hulls. */
void hull_scan_spans(const hull *h, const vec3 d[3], double top[3], double bottom[3]);

/* The same by one kernel, for tests: only where hull_scan_has says that the processor can. */
bool hull_scan_has(hull_scan_width width);
uint32_t hull_scan_by(hull_scan_width width, const hull *h, vec3 direction);
double hull_scan_top_by(hull_scan_width width, const hull *h, vec3 direction);
uint32_t hull_scan_above_by(
    hull_scan_width width, const hull *h, vec3 direction, double cut, uint16_t *found, uint32_t most);
void hull_scan_spans_by(hull_scan_width width, const hull *h, const vec3 d[3], double top[3], double bottom[3]);

#endif
