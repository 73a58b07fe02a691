/* check: a program that knows nothing but <collided_check.h>, and what it is linked with. */
#include <collided_check.h>
#include <stdio.h>

int main(void)
{
    collided_check_shape ball = {.kind = COLLIDED_CHECK_SPHERE, .radius = 0.1, .pose = {0, 0, 0, 1}};
    double here[7] = {0, 0, 0, 1}, there[7] = {1, 0, 0, 1};
    collided_check_claim claim = {.lo = 0.79, .hi = 0.81, .axis = {1}, .point_a = {0.1}, .point_b = {0.9}};
    collided_check_proven proven;
    collided_check_status status = collided_check_distance(&ball, here, &ball, there, &claim, 0, &proven);
    printf("%s: [%.17g, %.17g]\n", collided_check_status_text(status), proven.lo, proven.hi);
    return !(collided_check_machine() && status == COLLIDED_CHECK_PROVEN);
}
