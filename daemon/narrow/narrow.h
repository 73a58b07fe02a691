/* narrow: what two shapes are to each other, with proof.
 *
 * Pure functions of (shapes, relative pose, request, cache, scratch): nothing is allocated, logged, timed or kept.
 * Any number of threads, each with its own scratch. Signed distance: positive = gap; negative = minus the least
 * translation that separates (depth); 0 = touching. Everything is in A's frame. */
#ifndef COLLIDED_NARROW_NARROW_H
#define COLLIDED_NARROW_NARROW_H

#include "narrow/pair/request.h"

/* The caller's memory, one a thread; opaque, of narrow_scratch_size() bytes, to be aligned to 64. */
size_t narrow_scratch_size(void);

/* A and B must be in canonical order (narrow_ordered); B's pose in A's frame from pose_relative. Always answers. */
void narrow_query(const shape *a, const shape *b, const pose *b_in_a, const narrow_request *request,
    narrow_cache *cache, narrow_scratch *scratch, narrow_result *result);

/* The canonical order of a pair: by type, then by the sizes, then by `tie`, which has to be the same in every run. */
bool narrow_ordered(const shape *a, uint64_t tie_a, const shape *b, uint64_t tie_b);

/* As narrow_query for shapes at world poses in any order: orders them, asks, and turns the answer back, so that
 * (A, B) and (B, A) agree bit for bit. The answer is in the frame of world axes with its origin at pose_a.p. */
void narrow_query_world(const shape *a, pose pose_a, const shape *b, pose pose_b, const narrow_request *request,
    narrow_scratch *scratch, narrow_result *result);

/* The certified separation along one axis (unit, in A's frame, from A towards B): one support query a shape. A lower
 * bound of the signed distance for any axis. With a half-space the axis is its normal, whatever is passed. */
double narrow_separation(
    const shape *a, const shape *b, const pose *b_in_a, vec3 axis, uint32_t *hint_a, uint32_t *hint_b);

/* Is the signed distance above `limit`? Proven along the cached axis, a guessed one, or one of two that their support
 * points lead to: a fraction of a query's time. True: the axis, the bound and the pose in *cache are that proof. False
 * says nothing, and of *cache changes the hints alone. */
bool narrow_apart(const shape *a, const shape *b, const pose *b_in_a, double limit, narrow_cache *cache);

/* Bounds without a search: `lo` as narrow_separation along that axis, `hi` from the support points there, which are the
 * points reported. The status is NARROW_WIDE, the method NARROW_BY_CLOSED_FORM. Never with a half-space. */
void narrow_bounds(const shape *a, const shape *b, const pose *b_in_a, vec3 axis, narrow_result *result);

/* An axis along which they are likely to be apart, from their frames and half extents alone: the line from the point of
 * A's extents nearest to B's origin, or the same seen from B, whichever is longer. Unit, in A's frame; zero = no idea.
 */
vec3 narrow_guess_axis(const shape *a, const shape *b, const pose *b_in_a);

/* How far any point of B can have moved relative to A between two relative poses, rounded up:
 * |dp| + 2 |q_v| reach_b, with q_v the vector part of the rotation between them. INFINITY if reach_b is. */
double narrow_motion_bound(const pose *before, const pose *now, double reach_b);

const char *narrow_method_name(narrow_method method);

#endif
