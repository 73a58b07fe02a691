/* narrow: what two shapes are to each other, with proof.
 *
 * Pure functions of (shapes, relative pose, request, cache, scratch): nothing is allocated, logged, timed or kept.
 * Any number of threads, each with its own scratch. Signed distance: positive = gap; negative = minus the least
 * translation that separates (depth); 0 = touching. Everything is in A's frame. */
#ifndef COLLIDED_NARROW_NARROW_H
#define COLLIDED_NARROW_NARROW_H

#include "narrow/pair/request.h"

/* The size in bytes of a narrow_scratch, which the caller allocates, aligned to 64 bytes, one for each thread. */
size_t narrow_scratch_size(void);

/* Answers the request about A and B, always. A and B must be in canonical order (narrow_ordered); b_in_a is the pose
 * of B in A's frame, from pose_relative. */
void narrow_query(const shape *a, const shape *b, const pose *b_in_a, const narrow_request *request,
    narrow_cache *cache, narrow_scratch *scratch, narrow_result *result);

/* The canonical order of a pair: by type, then by the sizes, then by `tie`, which has to be the same in every run. */
bool narrow_ordered(const shape *a, uint64_t tie_a, const shape *b, uint64_t tie_b);

/* Does what narrow_query does for shapes at world poses in any order: it puts them in order, asks, and turns the answer
 * back, so that (A, B) and (B, A) agree bit for bit. The answer is in world axes, with the origin at pose_a.p. */
void narrow_query_world(const shape *a, pose pose_a, const shape *b, pose pose_b, const narrow_request *request,
    narrow_scratch *scratch, narrow_result *result);

/* The certified separation along one unit axis, in A's frame, from A towards B. It takes one support query for each
 * shape, and is a lower bound of the signed distance for any axis. With a half-space the axis used is its normal,
 * whatever the caller passes. */
double narrow_separation(
    const shape *a, const shape *b, const pose *b_in_a, vec3 axis, uint32_t *hint_a, uint32_t *hint_b);

/* Is the signed distance above `limit`? The function tries the cached axis, a guessed one, and up to two to which
 * support points lead; this takes a fraction of a query's time. If it returns true, the axis, the bound and the pose in
 * *cache are the proof. If it returns false, nothing is proven, and only the hints in *cache have changed. */
bool narrow_apart(const shape *a, const shape *b, const pose *b_in_a, double limit, narrow_cache *cache);

/* Finds bounds without a search: `lo` is the separation along that axis, and `hi` the distance of the two support
 * points there, which are the points reported. The status is NARROW_WIDE and the method NARROW_BY_CLOSED_FORM. Neither
 * shape may be a half-space. */
void narrow_bounds(const shape *a, const shape *b, const pose *b_in_a, vec3 axis, narrow_result *result);

/* Guesses an axis along which the shapes may be apart, from their frames and half extents alone: the line from the
 * point of A's extents that is nearest to B's origin, or the line found in the same way from B, whichever is longer.
 * The axis is unit, in A's frame; it is zero if there is no such line. */
vec3 narrow_guess_axis(const shape *a, const shape *b, const pose *b_in_a);

/* An upper bound on how far any point of B has moved relative to A between two relative poses, rounded up:
 * |dp| + 2 |q_v| reach_b, where q_v is the vector part of the rotation between them. It is INFINITY if reach_b is. */
double narrow_motion_bound(const pose *before, const pose *now, double reach_b);

const char *narrow_method_name(narrow_method method);

#endif
