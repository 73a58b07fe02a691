/* consumer URI: a client that knows nothing but <collided.h>: two balls, their distance, and its proof. In what C and
 * C++ have in common, so that it is compiled as both. */
#include <collided.h>
#include <stdio.h>
#include <string.h>

static collided_body create(collided *c, const char *name, const collided_shape *ball, double x)
{
    collided_body_def def = collided_body_def_default();
    def.name = name;
    def.pose.position[0] = x;
    def.shapes = ball;
    def.shape_count = 1;
    return collided_create_body(c, &def);
}

static int fails(const collided *c, const char *what)
{
    fprintf(stderr, "consumer: %s: %s\n", what, c ? collided_error(c) : collided_connect_error());
    return 1;
}

int main(int argc, char **argv)
{
    collided *c = collided_connect(argc > 1 ? argv[1] : "dds://0", NULL);
    if (!c) return fails(c, "connecting");

    const collided_shape ball = collided_sphere(0.5);
    collided_body left = create(c, "left", &ball, 0), right = create(c, "right", &ball, 3);
    if (left.id == COLLIDED_NONE || right.id == COLLIDED_NONE) return fails(c, "creating");
    if (collided_sync(c, 5) != COLLIDED_OK) return fails(c, "announcing");

    collided_result answer;
    if (collided_query_distance(c, "left", "right", 1e-9, 5, &answer) != COLLIDED_OK || answer.count != 1)
        return fails(c, "asking for the distance");
    collided_pose at_left = collided_pose_identity(), at_right = at_left;
    at_right.position[0] = 3;
    collided_certificate claim;
    claim.lo = answer.hits[0].lo;
    claim.hi = answer.hits[0].hi;
    memcpy(claim.axis, answer.hits[0].axis, sizeof claim.axis);
    memcpy(claim.point_a, answer.hits[0].point_a, sizeof claim.point_a);
    memcpy(claim.point_b, answer.hits[0].point_b, sizeof claim.point_b);
    if (claim.lo > 2 || claim.hi < 2 || strcmp(answer.hits[0].name_a, "left") != 0 ||
        collided_verify(&ball, &at_left, NULL, 0, &ball, &at_right, NULL, 0, &claim) != COLLIDED_OK)
        return fails(c, "the answer is not proven");

    printf("collided %s: %.9f .. %.9f m, certified\n", collided_version(), claim.lo, claim.hi);
    collided_result_free(&answer);
    collided_close(c);
    return 0;
}
