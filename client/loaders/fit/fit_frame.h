/* fit_frame: frames of boxes and capsules. Pure; any thread. */
#ifndef COLLIDED_LOADERS_FIT_FRAME_H
#define COLLIDED_LOADERS_FIT_FRAME_H

#include "loaders/decompose/vec3.h"
#include "loaders/rigid.h"

/* The rotation that takes x, y, z to the rows of `axes` (right-handed, unit). Shepperd, "Quaternion from rotation
 * matrix", 1978. */
static inline void fit_frame_from_axes(const double axes[3][3], double q[4])
{
    double m[3][3], trace = axes[0][0] + axes[1][1] + axes[2][2];
    for (int i = 0; i < 9; i++) m[i / 3][i % 3] = axes[i % 3][i / 3]; /* columns */
    int i = 0;
    for (int k = 1; k < 3; k++)
        if (m[k][k] > m[i][i]) i = k;
    int j = (i + 1) % 3, k = (i + 2) % 3;
    if (trace > m[i][i]) {
        q[0] = 1 + trace, q[1] = m[2][1] - m[1][2], q[2] = m[0][2] - m[2][0], q[3] = m[1][0] - m[0][1];
    } else {
        q[1 + i] = 1 + m[i][i] - m[j][j] - m[k][k];
        q[1 + j] = m[i][j] + m[j][i], q[1 + k] = m[i][k] + m[k][i], q[0] = m[k][j] - m[j][k];
    }
    double norm = sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
    for (int c = 0; c < 4; c++) q[c] /= norm;
}

/* The rows: where the rotation takes x, y and z. */
static inline void fit_frame_axes(const double q[4], double axes[3][3])
{
    for (int i = 0; i < 3; i++) {
        const double unit[3] = {i == 0, i == 1, i == 2};
        rigid_rotate(q, unit, axes[i]);
    }
}

#endif
