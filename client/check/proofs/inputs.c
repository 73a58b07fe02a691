/* inputs: what Eva (Frama-C) is asked about: the kernel with any bits in all numbers and words, and pointers that are
 * NULL or lead to arrays of exactly so many elements as the counts say, or as their limits allow. 0 alarms: no run-time
 * error, no undefined behaviour, nothing read beyond. Frama-C alone compiles this. */
#include "__fc_builtin.h"
#include "collided_check.h"

enum { CHILDREN = 3, SOME = 5, TIMES = 4, JOINTS = COLLIDED_CHECK_JOINTS_MOST };

/* Points of hulls: 1, SOME and as many as there may be, each in an array of that size. */
static double one_point[3], some_points[3 * SOME], most_points[3 * COLLIDED_CHECK_POINTS_MOST];
static collided_check_shape children[2][CHILDREN], shapes[2];
static double pose_a[7], pose_b[7], numbers[4][JOINTS];
static double times[TIMES], poses[2][7 * TIMES], axes[3 * TIMES];

static void any(void *at, unsigned long size)
{
    Frama_C_make_unknown(at, size);
}

static unsigned long any_count_from(unsigned long least)
{
    return Frama_C_unsigned_long_interval(least, 0xffffffffffffffff);
}

/* Any bits, but for the pointers and counts: those belong together as `way` says. */
enum { CORES = 7 };
static void any_core(collided_check_shape *s, int way)
{
    any(s, sizeof *s);
    s->children = 0;
    s->child_count = any_count_from(0);
    s->kind = way == 0 ? Frama_C_interval(-2147483647 - 1, 6) : way == 1 ? Frama_C_interval(8, 9) : 7;
    if (way == 1 && Frama_C_interval(0, 1)) s->kind = Frama_C_interval(11, 2147483647);
    s->points = way < 3 ? 0 : way == 3 ? one_point : way == 4 ? some_points : most_points;
    s->point_count = way < 3    ? any_count_from(0)
                     : way == 3 ? 1
                     : way == 4 ? SOME
                     : way == 5 ? COLLIDED_CHECK_POINTS_MOST
                                : any_count_from(COLLIDED_CHECK_POINTS_MOST + 1);
}

enum { WAYS = CORES + 4 };
static void any_shape(collided_check_shape *s, collided_check_shape *children, int way)
{
    any_core(s, way < CORES ? way : 0);
    if (way < CORES) return;
    s->kind = COLLIDED_CHECK_COMPOUND;
    s->children = way == CORES ? 0 : children;
    s->child_count = way < CORES + 2 ? any_count_from(COLLIDED_CHECK_CHILDREN_MOST + 1) : CHILDREN;
    /*@ loop unroll CHILDREN; */
    for (int i = 0; i < CHILDREN; i++) any_core(&children[i], way == CORES + 2 ? 0 : way == CORES + 3 ? 3 + i : 2);
}

static void *or_null(void *p)
{
    return Frama_C_interval(0, 3) ? p : 0;
}

static void ask(collided_check_shape *a, collided_check_shape *b)
{
    collided_check_claim claim;
    collided_check_proven proven;
    any(&claim, sizeof claim);
    collided_check_distance(a, or_null(pose_a), b, or_null(pose_b), or_null(&claim), numbers[0][0], &proven);
    collided_check_distance(a, or_null(pose_a), b, or_null(pose_b), or_null(&claim), numbers[0][0], 0);

    double until, speed, bend;
    collided_check_motion motion;
    any(&motion, sizeof motion);
    motion.times = or_null(times), motion.poses_a = or_null(poses[0]), motion.poses_b = or_null(poses[1]);
    motion.axes = or_null(axes);
    motion.count = any_count_from(COLLIDED_CHECK_TIMES_MOST + 1);
    collided_check_motion_free(a, b, or_null(&motion), &until);
    motion.count = TIMES;
    collided_check_motion_free(a, b, or_null(&motion), &until);
    collided_check_motion_free(a, b, or_null(&motion), 0);
    collided_check_twist(a, or_null(numbers[0]), numbers[1], b, numbers[2], or_null(numbers[3]), &speed, &bend);
    collided_check_twist(a, or_null(numbers[0]), numbers[1], b, numbers[2], or_null(numbers[3]), 0, or_null(&bend));
    collided_check_twist(a, or_null(numbers[0]), numbers[1], b, numbers[2], or_null(numbers[3]), &speed, 0);
}

int main(void)
{
    any(one_point, sizeof one_point);
    any(some_points, sizeof some_points);
    any(most_points, sizeof most_points);
    any(pose_a, sizeof pose_a);
    any(pose_b, sizeof pose_b);
    any(numbers, sizeof numbers);
    any(times, sizeof times);
    any(poses, sizeof poses);
    any(axes, sizeof axes);
    /* each way of one shape beside one of the other: both go through the same functions */
    /*@ loop unroll WAYS; */
    for (int way = 0; way < WAYS; way++) {
        any_shape(&shapes[0], children[0], way);
        any_shape(&shapes[1], children[1], WAYS - 1 - way);
        ask(&shapes[0], &shapes[1]);
    }
    ask(0, &shapes[1]);
    ask(&shapes[0], 0);

    double until;
    collided_check_joint_speed(JOINTS, or_null(numbers[0]), or_null(numbers[1]));
    collided_check_joint_speed(any_count_from(JOINTS + 1), numbers[0], numbers[1]);
    collided_check_features features;
    any(&features, sizeof features);
    features.times = or_null(times), features.directions = or_null(axes);
    features.count = TIMES - 1;
    collided_check_features_free(or_null(&features), &until);
    features.count = any_count_from(COLLIDED_CHECK_TIMES_MOST);
    collided_check_features_free(or_null(&features), &until);
    collided_check_features_free(or_null(&features), 0);

    collided_check_machine();
    collided_check_status_text((collided_check_status)Frama_C_interval(-1000, 1000));
    return 0;
}
