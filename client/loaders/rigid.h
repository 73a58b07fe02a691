/* rigid: the few operations on poses that forward kinematics needs, on the client's own pose type. Plain values, any
 * thread. Quaternions are (w, x, y, z); rpy = fixed axes: first about x, then y, then z (URDF's convention). */
#ifndef COLLIDED_LOADERS_RIGID_H
#define COLLIDED_LOADERS_RIGID_H

#include "collided.h"

#include <math.h>

static inline collided_pose rigid_identity(void)
{
    return (collided_pose){{0, 0, 0}, {1, 0, 0, 0}};
}

static inline void rigid_quaternion_product(const double a[4], const double b[4], double out[4])
{
    double w = a[0] * b[0] - a[1] * b[1] - a[2] * b[2] - a[3] * b[3];
    double x = a[0] * b[1] + a[1] * b[0] + a[2] * b[3] - a[3] * b[2];
    double y = a[0] * b[2] - a[1] * b[3] + a[2] * b[0] + a[3] * b[1];
    double z = a[0] * b[3] + a[1] * b[2] - a[2] * b[1] + a[3] * b[0];
    double norm = sqrt(w * w + x * x + y * y + z * z); /* kept at 1, so that long chains do not drift */
    out[0] = w / norm, out[1] = x / norm, out[2] = y / norm, out[3] = z / norm;
}

/* v + 2 w (u x v) + 2 u x (u x v), with u the vector part */
static inline void rigid_rotate(const double q[4], const double v[3], double out[3])
{
    double tx = 2 * (q[2] * v[2] - q[3] * v[1]);
    double ty = 2 * (q[3] * v[0] - q[1] * v[2]);
    double tz = 2 * (q[1] * v[1] - q[2] * v[0]);
    double x = v[0] + q[0] * tx + (q[2] * tz - q[3] * ty);
    double y = v[1] + q[0] * ty + (q[3] * tx - q[1] * tz);
    double z = v[2] + q[0] * tz + (q[1] * ty - q[2] * tx);
    out[0] = x, out[1] = y, out[2] = z;
}

static inline void rigid_about(const double unit_axis[3], double angle, double out[4])
{
    double s = sin(angle / 2);
    out[0] = cos(angle / 2);
    for (int i = 0; i < 3; i++) out[i + 1] = s * unit_axis[i];
}

static inline void rigid_from_rpy(const double rpy[3], double out[4])
{
    static const double x[3] = {1, 0, 0}, y[3] = {0, 1, 0}, z[3] = {0, 0, 1};
    double qx[4], qy[4], qz[4];
    rigid_about(x, rpy[0], qx);
    rigid_about(y, rpy[1], qy);
    rigid_about(z, rpy[2], qz);
    rigid_quaternion_product(qy, qx, out);
    rigid_quaternion_product(qz, out, out);
}

#endif
