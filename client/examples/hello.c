/* hello: the first client of one's own. A ball swings through a block that stands still; each contact is printed.
 * Build: cc hello.c -lcollided ...; run: collided & hello [URI] */
#include "collided.h"

#include <math.h>
#include <stdio.h>

static void on_events(void *context, const collided_batch *batch)
{
    (void)context;
    for (size_t i = 0; i < batch->event_count; i++) {
        const collided_event *e = &batch->events[i];
        if (e->kind == COLLIDED_BEGIN) printf("%s touches %s\n", e->name_a, e->name_b);
        if (e->kind == COLLIDED_END) printf("%s has left %s\n", e->name_a, e->name_b);
    }
}

static collided_body create(collided *c, const char *name, collided_motion motion, collided_shape shape)
{
    collided_body_def def = collided_body_def_default();
    def.name = name;
    def.motion = motion;
    def.shapes = &shape;
    def.shape_count = 1;
    return collided_create_body(c, &def);
}

int main(int argc, char **argv)
{
    collided *c = collided_connect(argc > 1 ? argv[1] : "dds://0", NULL);
    if (!c) return fprintf(stderr, "hello: %s\n", collided_connect_error()), 1;
    create(c, "block", COLLIDED_FIXED, collided_box(0.2, 0.2, 0.2));
    collided_body ball = create(c, "ball", COLLIDED_MOVING, collided_sphere(0.05));
    collided_subscription_def subscription = collided_subscription_def_default();
    subscription.callback = on_events;
    collided_subscribe(c, &subscription);

    collided_pose pose = collided_pose_identity();
    for (int i = 0; i < 600; i++) {
        pose.position[0] = cos(0.02 * i); /* m: one swing in about three seconds */
        collided_move(c, ball, pose);
        collided_poll(c, 0.01); /* waits for what comes, and runs on_events */
    }
    collided_close(c);
    return 0;
}
