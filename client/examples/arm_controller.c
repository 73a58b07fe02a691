/* arm_controller: moves a six-axis arm from place to place, publishes what its joints are, and listens to how near the
 * vehicle comes. When the vehicle will come nearer than the protective distance, or nobody knows where it is, the arm
 * brakes, holds, and goes on afterwards. It grips its workpiece once the daemon says that the tool touches it; gripped,
 * it rides with the tool.
 * One thread, 100 Hz; callbacks run inside example_poll_until.
 *
 * Not safety-rated: in a real cell this comes on top of certified protective devices. */
#include "example.h"

#include <collided_load.h>
#include <limits.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sysexits.h>
#include <unistd.h>

static const double DEADLINE_S = 0.2; /* twenty poses missing: where the arm is, is then unknown */
static const double RANGE_M = 0.6;    /* the vehicle is listened to from here on */

static const double TABLE_TOP_M = 0.75, TOOL_M = 0.12;
static const double GRIP_GAP_M = 0.0005;       /* between tool and gripped workpiece, as in the SRDF's states */
static const double TOUCH_THRESHOLD_M = 0.001; /* so that gripping and lying count as touching */

/* ---- what is known of the vehicle ---- */

enum { NAME_BYTES = 128 };
typedef struct sighting { /* one pair of shapes that is near, or of which nothing is known */
    int64_t contact;      /* 0: not one pair, but all of the body a */
    char a[NAME_BYTES], b[NAME_BYTES];
    double lo, hi, age_s;
    double left; /* what is left of lo when the arm stands */
} sighting;

typedef struct senses {
    sighting *at;
    size_t count, capacity;
    int touching;  /* contacts of the tool with parts */
    bool informed; /* the first snapshot came: until then nothing near does not mean that nothing is near */
} senses;

static sighting *find(const senses *s, const collided_event *e)
{
    for (size_t i = 0; i < s->count; i++)
        if (s->at[i].contact == e->contact && (e->contact != 0 || strcmp(s->at[i].a, e->name_a) == 0)) return &s->at[i];
    return NULL;
}

static sighting *add(senses *s)
{
    if (s->count == s->capacity) {
        s->capacity = s->capacity ? 2 * s->capacity : 32;
        s->at = realloc(s->at, s->capacity * sizeof *s->at);
        if (!s->at) abort(); /* blind, it must not go on */
    }
    return &s->at[s->count++];
}

static void remember(senses *s, const collided_event *e)
{
    sighting *one = find(s, e);
    if (!one) one = add(s);
    *one = (sighting){.contact = e->contact,
        .lo = e->lo,
        .hi = e->hi,
        .age_s = fmax(e->age_a_s, e->age_b_s),
        .left = example_separation_left(e)};
    (void)snprintf(one->a, sizeof one->a, "%s", e->name_a);
    (void)snprintf(one->b, sizeof one->b, "%s", e->name_b);
}

static void forget(senses *s, const collided_event *e)
{
    sighting *one = find(s, e);
    if (one) *one = s->at[--s->count];
}

/* An unknown pair comes with lo = -infinity, so it needs no rule of its own: it is nearer than any distance. */
static void on_distances(void *context, const collided_batch *batch)
{
    senses *s = context;
    if (batch->snapshot) s->count = 0; /* the whole state follows */
    s->informed = !batch->starved;     /* what it knows is old, until the next one comes */
    for (size_t i = 0; i < batch->event_count; i++) {
        const collided_event *e = &batch->events[i];
        if (e->kind == COLLIDED_FAR || (e->kind == COLLIDED_KNOWN && e->contact == 0))
            forget(s, e);
        else
            remember(s, e);
    }
}

static void on_touches(void *context, const collided_batch *batch)
{
    senses *s = context;
    if (batch->snapshot) s->touching = 0;
    for (size_t i = 0; i < batch->event_count; i++)
        s->touching += (batch->events[i].kind == COLLIDED_BEGIN) - (batch->events[i].kind == COLLIDED_END);
}

/* The pair that leaves least room: not always the nearest one, but one that approaches fast. */
static const sighting *most_pressing(const senses *s)
{
    const sighting *best = NULL;
    for (size_t i = 0; i < s->count; i++)
        if (!best || s->at[i].left < best->left) best = &s->at[i];
    return best;
}

/* ---- the arm ---- */

enum { LINKS = 8, JOINTS = 7, BODIES = LINKS + 1, TOOL = LINKS - 1, WORKPIECE = LINKS }; /* of arm.urdf */

typedef enum action { GO_ON, GRIP, RELEASE } action;
typedef struct step {
    const char *state; /* of the SRDF */
    double seconds;
    action then;
} step;

/* From A to B and back again, for ever. */
static const step PROGRAM[] = {
    {"at_a", 0.5, GRIP},
    {"above_a", 0.5, GO_ON},
    {"above_b", 1.2, GO_ON},
    {"at_b", 0.5, RELEASE},
    {"above_b", 0.5, GO_ON},
    {"at_b", 0.5, GRIP},
    {"above_b", 0.5, GO_ON},
    {"above_a", 1.2, GO_ON},
    {"at_a", 0.5, RELEASE},
    {"above_a", 0.5, GO_ON},
};
enum { STEPS = sizeof PROGRAM / sizeof *PROGRAM };

typedef struct arm {
    const example *e;
    collided *c;
    collided_loaded_robot *robot;
    collided_pose base;
    collided_body bodies[BODIES];
    double from[JOINTS], to[JOINTS], values[JOINTS]; /* rad */
    int step;
    double progress; /* of the step, 0 to 1 */
    double speed;    /* share of full speed, 0 to 1 */
    bool stopped;
    unsigned long stops, grips;
} arm;

/* Where the tool holds the workpiece, in the tool's frame. */
static collided_pose in_tool(void)
{
    return (collided_pose){{0, 0, TOOL_M + GRIP_GAP_M + EXAMPLE_WORKPIECE_M / 2}, {1, 0, 0, 0}};
}

static void grip(arm *a)
{
    example_note(a->e, "the tool feels the workpiece: gripped");
    a->grips++;
    const collided_pose held = in_tool();
    (void)example_ok(a->c, collided_attach(a->c, a->bodies[0], a->bodies[WORKPIECE], a->bodies[TOOL], &held),
        "arm_controller: gripping");
}

/* It stays where it is. */
static void let_go(arm *a)
{
    (void)example_ok(
        a->c, collided_detach(a->c, a->bodies[0], a->bodies[WORKPIECE]), "arm_controller: letting the workpiece go");
}

static void aim(arm *a)
{
    memcpy(a->from, a->values, sizeof a->from);
    memcpy(a->to, a->values, sizeof a->to);
    a->progress = 0;
    if (collided_loaded_state_values(a->robot, PROGRAM[a->step].state, a->to)) abort(); /* load() has tried them all */
}

static void finish_step(arm *a)
{
    action then = PROGRAM[a->step].then;
    if (then == GRIP) grip(a);
    if (then == RELEASE) let_go(a);
    a->step = (a->step + 1) % STEPS;
    aim(a);
}

static double toward(double from, double to, double most)
{
    return from + fmin(fmax(to - from, -most), most);
}

/* Speed is a factor on the program's time: braking keeps the arm on its path. The quintic has neither velocity nor
 * acceleration at either end of a step. */
static void advance(arm *a, bool touching, double dt)
{
    a->speed = toward(a->speed, a->stopped ? 0 : 1, dt / EXAMPLE_BRAKING_S);
    a->progress = fmin(1, a->progress + a->speed * dt / PROGRAM[a->step].seconds);
    double p = a->progress, s = p * p * p * (10 + p * (6 * p - 15));
    for (int i = 0; i < JOINTS; i++) a->values[i] = a->from[i] + s * (a->to[i] - a->from[i]);
    if (p < 1 || a->stopped) return;
    if (PROGRAM[a->step].then != GRIP || touching) finish_step(a); /* what it does not feel it waits for */
}

/* ---- the decision ---- */

/* On the certified lower bound, the vehicle may be as near as that and is no nearer, and on how fast they approach: the
 * arm begins to brake early enough to stand where it must. */
static void decide(arm *a, const sighting *s, bool informed)
{
    const sighting nothing = {
        .a = "group:arm", .b = "group:vehicle", .lo = -INFINITY, .hi = INFINITY, .age_s = -1, .left = -INFINITY};
    if (!informed) s = &nothing;
    if (!a->stopped && s && s->left < EXAMPLE_PROTECTIVE_M) {
        a->stopped = true;
        a->stops++;
        example_line(a->e, "stop", s->a, s->b, s->lo, s->hi, s->age_s);
    } else if (a->stopped && (!s || s->left > EXAMPLE_RESUME_M)) {
        a->stopped = false;
        example_note(a->e, "the way is free: the arm goes on");
    }
}

/* ---- connecting ---- */

/* Says why not, if the arm is another one than this program is written for. */
static bool try_states(arm *a)
{
    size_t joints;
    (void)collided_loaded_joints(a->robot, &joints);
    if (joints != JOINTS || collided_loaded_body_count(a->robot) != LINKS)
        return fprintf(stderr, "arm_controller: it is for an arm of %d joints and %d links\n", JOINTS, LINKS), false;
    for (int i = 0; i < STEPS; i++)
        if (collided_loaded_state_values(a->robot, PROGRAM[i].state, a->values))
            return fprintf(stderr, "arm_controller: %s\n", collided_load_error()), false;
    return true;
}

/* The path of a file that lies beside this program. */
static void beside(const char *name, char path[PATH_MAX])
{
    ssize_t length = readlink("/proc/self/exe", path, PATH_MAX - 32);
    while (length > 0 && path[length - 1] != '/') length--;
    (void)snprintf(path + (length > 0 ? length : 0), 32, "%s", name);
}

static bool load(arm *a)
{
    char urdf[PATH_MAX], srdf[PATH_MAX];
    beside("arm.urdf", urdf), beside("arm.srdf", srdf);
    a->base = (collided_pose){{0, 0, TABLE_TOP_M}, {1, 0, 0, 0}};
    a->robot = collided_load_urdf(urdf, NULL);
    if (!a->robot || collided_load_srdf(a->robot, srdf))
        return fprintf(stderr, "arm_controller: %s\n", collided_load_error()), false;
    if (!try_states(a)) return false;
    a->stopped = true; /* until it is told that the way is free */
    (void)collided_loaded_state_values(a->robot, "above_a", a->values);
    aim(a);
    return true;
}

/* Where it will be gripped first. */
static collided_pose workpiece_at_a(const arm *a)
{
    double values[JOINTS];
    collided_pose poses[LINKS];
    memcpy(values, a->values, sizeof values);
    (void)collided_loaded_state_values(a->robot, "at_a", values);
    collided_loaded_body_poses(a->robot, a->base, values, poses);
    return collided_pose_product(poses[TOOL], in_tool());
}

static bool create_bodies(arm *a, collided *c)
{
    /* Should this process hang, its links are unknown after the deadline, not where they were. */
    const collided_placement at = {.base = a->base, .values = a->values, .deadline_s = DEADLINE_S};
    if (collided_create_loaded(c, a->robot, &at, a->bodies))
        return fprintf(stderr, "arm_controller: %s\n", collided_load_error()), false;
    collided_shape shapes[EXAMPLE_SHAPES];
    collided_body_def workpiece = collided_body_def_default();
    workpiece.name = "workpiece";
    workpiece.group = "part";
    workpiece.pose = workpiece_at_a(a);
    workpiece.shapes = shapes;
    workpiece.shape_count = example_shapes(workpiece.name, shapes);
    a->bodies[WORKPIECE] = collided_create_body(c, &workpiece);
    /* From here on the daemon puts the links where the joints say. */
    collided_robot tree;
    (void)collided_loaded_tree(a->robot, a->base, &tree);
    return example_ok(c, collided_set_robot(c, a->bodies[0], &tree), "arm_controller: announcing the arm");
}

static void subscribe(collided *c, senses *s)
{
    collided_subscription_def distances = collided_subscription_def_default();
    distances.facts = COLLIDED_DISTANCE;
    distances.select_a = "group:arm";
    distances.select_b = "group:vehicle";
    distances.range_m = RANGE_M;
    distances.tolerance_m = 1e-3; /* no finer than the decision needs: cheaper */
    distances.callback = on_distances;
    distances.context = s;
    collided_subscribe(c, &distances);

    collided_subscription_def touches = collided_subscription_def_default();
    touches.select_a = "tool_link";
    touches.select_b = "group:part";
    touches.threshold_m = TOUCH_THRESHOLD_M;
    touches.callback = on_touches;
    touches.context = s;
    collided_subscribe(c, &touches);
}

/* ---- the process ---- */

static collided_status publish(const arm *a, collided *c)
{
    double configuration[JOINTS]; /* of the joints that move */
    collided_robot tree;
    const collided_joint_state state = {.positions = configuration};
    collided_loaded_configuration(a->robot, a->values, configuration);
    (void)collided_loaded_tree(a->robot, a->base, &tree);
    return collided_publish_joints(c, a->bodies[0], &state, collided_robot_coordinates(&tree), 0, 0);
}

static bool run(arm *a, collided *c, const senses *s)
{
    bool good = true;
    collided_status status = COLLIDED_OK;
    for (int64_t next_ns = example_now_ns(); good && example_running(a->e);) {
        decide(a, most_pressing(s), s->informed && status != COLLIDED_NO_DAEMON);
        advance(a, s->touching > 0, EXAMPLE_PERIOD_S);
        good = example_ok(c, publish(a, c), "arm_controller: publishing");
        next_ns += (int64_t)(EXAMPLE_PERIOD_S * 1e9);
        status = example_poll_until(c, next_ns);
    }
    return good;
}

int main(int argc, char **argv)
{
    const example e = example_start(argc, argv);
    arm a = {.e = &e};
    senses s = {.count = 0};
    if (!load(&a)) return EX_DATAERR;
    collided *c = example_connect(&e, NULL);
    if (!c) return EX_UNAVAILABLE;

    a.c = c;
    bool good = create_bodies(&a, c);
    subscribe(c, &s);
    good = good && example_ok(c, collided_sync(c, 5), "arm_controller: creating the arm") && run(&a, c, &s);

    example_note(&e, "the arm gripped %lu times and stopped %lu times", a.grips, a.stops);
    collided_close(c);
    free(s.at);
    collided_loaded_robot_free(a.robot);
    return good ? EX_OK : EX_SOFTWARE;
}
