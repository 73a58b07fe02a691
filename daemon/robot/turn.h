/* turn: sine and cosine of a joint's angle, four side by side, without libm, so that every machine gets the same bits.
 *
 * The angle is reduced by multiples of a right angle in three parts (Cody and Waite), each product of which is exact
 * for up to 2^20 of them; then the polynomials of fdlibm (Sun Microsystems, k_sin.c and k_cos.c), whose error is below
 * one roundoff on [-pi/4, pi/4]. All in all a result is within TURN_ERROR of the truth. Pure; any thread. */
#ifndef COLLIDED_ROBOT_TURN_H
#define COLLIDED_ROBOT_TURN_H

#include "geom/simd.h"

#define TURN_ANGLE_MAX 1e5 /* rad: larger angles are not to be asked */
#define TURN_ERROR 0x1p-51

LANES_INLINE lanes turn_select(lane_mask m, lanes yes, lanes no)
{
    return (lanes)((m & (lane_mask)yes) | (~m & (lane_mask)no));
}

LANES_INLINE void turn_sin_cos(lanes angle, lanes *sine, lanes *cosine)
{
    const double half_pi_1 = 1.57079632673412561417e+00; /* the first 33 bits of pi / 2 */
    const double half_pi_2 = 6.07710050630396597660e-11; /* the next 33 */
    const double half_pi_3 = 2.02226624879595063154e-21; /* and the next */
    const double to_integer = 0x1.8p52;
    lanes shifted = angle * 6.36619772367581382433e-01 + to_integer, turns = shifted - to_integer;
    lane_mask quarter = (lane_mask)shifted;
    lanes r = angle - turns * half_pi_1;
    lanes low = turns * half_pi_2, high = r;
    r = high - low;
    low = ((high - r) - low) - turns * half_pi_3; /* what the subtraction has lost */
    lanes x = r + low, tail = (r - x) + low;
    lanes z = x * x;
    lanes s = 1.58969099521155010221e-10 * z - 2.50507602534068634195e-08;
    s = (s * z + 2.75573137070700676789e-06) * z - 1.98412698298579493134e-04;
    s = s * z + 8.33333333332248946124e-03;
    lanes cube = z * x;
    lanes sin_x = x - ((z * (0.5 * tail - cube * s) - tail) - cube * -1.66666666666666324348e-01);
    lanes c = -1.13596475577881948265e-11 * z + 2.08757232129817482790e-09;
    c = (c * z - 2.75573143513906633035e-07) * z + 2.48015872894767294178e-05;
    c = (c * z - 1.38888888888741095749e-03) * z + 4.16666666666666019037e-02;
    lanes w = 1 - 0.5 * z;
    lanes cos_x = w + (((1 - w) - 0.5 * z) + (z * (z * c) - x * tail));
    lane_mask odd = -(quarter & 1), second = -((quarter >> 1) & 1), third = -(((quarter + 1) >> 1) & 1);
    lanes sin_here = turn_select(odd, cos_x, sin_x), cos_here = turn_select(odd, sin_x, cos_x);
    *sine = turn_select(second, -sin_here, sin_here);
    *cosine = turn_select(third, -cos_here, cos_here);
}

#endif
