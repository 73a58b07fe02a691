/* robot URDF SRDF: what a robot has, by a program that knows nothing but <collided_load.h>. In what C and C++ have in
 * common, so that it is compiled as both. */
#include <collided_load.h>
#include <stdio.h>

int main(int argc, char **argv)
{
    size_t joints, states;
    collided_loaded_robot *robot = argc == 3 ? collided_load_urdf(argv[1], NULL) : NULL;
    if (!robot || collided_load_srdf(robot, argv[2]) != COLLIDED_OK)
        return fprintf(stderr, "robot: %s\n", collided_load_error()), 1;
    (void)collided_loaded_joints(robot, &joints);
    (void)collided_loaded_states(robot, &states);
    printf("%s: %zu bodies, %zu joints, %zu states\n", collided_loaded_name(robot), collided_loaded_body_count(robot),
        joints, states);
    collided_loaded_robot_free(robot);
    return 0;
}
