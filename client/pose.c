/* pose: products of poses, by the client's own arithmetic. Pure; any thread. */
#include "collided.h"

#include <math.h>

/* v + 2 w (u x v) + 2 u x (u x v), with u the vector part of q */
static void rotate(const double q[4], const double v[3], double out[3])
{
    double t[3] = {2 * (q[2] * v[2] - q[3] * v[1]), 2 * (q[3] * v[0] - q[1] * v[2]), 2 * (q[1] * v[1] - q[2] * v[0])};
    out[0] = v[0] + q[0] * t[0] + (q[2] * t[2] - q[3] * t[1]);
    out[1] = v[1] + q[0] * t[1] + (q[3] * t[0] - q[1] * t[2]);
    out[2] = v[2] + q[0] * t[2] + (q[1] * t[1] - q[2] * t[0]);
}

collided_pose collided_pose_product(collided_pose outer, collided_pose inner)
{
    collided_pose out;
    const double *a = outer.orientation, *b = inner.orientation;
    rotate(a, inner.position, out.position);
    for (int i = 0; i < 3; i++) out.position[i] += outer.position[i];
    double w = a[0] * b[0] - a[1] * b[1] - a[2] * b[2] - a[3] * b[3];
    double x = a[0] * b[1] + a[1] * b[0] + a[2] * b[3] - a[3] * b[2];
    double y = a[0] * b[2] - a[1] * b[3] + a[2] * b[0] + a[3] * b[1];
    double z = a[0] * b[3] + a[1] * b[2] - a[2] * b[1] + a[3] * b[0];
    double norm = sqrt(w * w + x * x + y * y + z * z); /* kept at 1, so that long chains do not drift */
    out.orientation[0] = w / norm, out.orientation[1] = x / norm;
    out.orientation[2] = y / norm, out.orientation[3] = z / norm;
    return out;
}
