/* verify_lanes: four doubles at a time, in what registers the processor has. Which lane holds what does not matter for
 * a greatest value. Any thread. */
#ifndef COLLIDED_CLIENT_VERIFY_LANES_H
#define COLLIDED_CLIENT_VERIFY_LANES_H

enum { LANES = 4 };

typedef double lanes __attribute__((vector_size(32)));
typedef double lanes_anywhere __attribute__((vector_size(32), aligned(8), may_alias));
typedef long long lane_mask __attribute__((vector_size(32)));

#define INLINE __attribute__((always_inline)) static inline

INLINE lanes lanes_of(double x)
{
    return (lanes){x, x, x, x};
}

INLINE lanes lanes_at(const double *p)
{
    return *(const lanes_anywhere *)p;
}

INLINE lanes greater(lanes a, lanes b)
{
    lane_mask m = a > b;
    return (lanes)((m & (lane_mask)a) | (~m & (lane_mask)b));
}

INLINE double greatest_of(lanes m)
{
    double low = m[0] > m[1] ? m[0] : m[1], high = m[2] > m[3] ? m[2] : m[3];
    return low > high ? low : high;
}

#endif
