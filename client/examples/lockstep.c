/* lockstep: publishing a step, and gathering its answer from two streams. One thread. */
#include "lockstep.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

static const double ANSWER_S = 0.5; /* then the step is published again: over LCM a datagram may be lost */
enum { TRIES = 20 };

static vector vector_of(const double v[3])
{
    return (vector){v[0], v[1], v[2]};
}

/* ---- what is reported ---- */

static int body_named(lockstep *l, const char *name)
{
    for (size_t i = 0; i < l->count; i++)
        if (strcmp(l->bodies[i].name, name) == 0) return (int)i;
    l->lost = true;
    return 0;
}

/* The lower number is A, so that an answer says the same whichever order the daemon has them in. */
static touch touch_of(lockstep *l, const collided_event *e)
{
    touch t = {
        .a = body_named(l, e->name_a), .b = body_named(l, e->name_b), .normal = vector_of(e->axis), .gap = e->lo};
    t.point = vector_scale(0.5, vector_add(vector_of(e->point_a), vector_of(e->point_b)));
    if (t.a < t.b) return t;
    t.normal = vector_scale(-1, t.normal);
    int a = t.a;
    t.a = t.b;
    t.b = a;
    return t;
}

static void on_impacts(void *context, const collided_batch *batch)
{
    lockstep *l = context;
    if (batch->step != l->step || l->answered[0] == l->step) return;
    for (size_t i = 0; i < batch->event_count; i++) {
        const collided_event *e = &batch->events[i];
        if (e->kind != COLLIDED_EVENT_PREDICTED) continue;
        impact_push(&l->heap, (impact){.lo_s = e->impact->lo_s,
                                  .gap_lo = e->lo,
                                  .gap_hi = e->hi,
                                  .closing_m_s = e->closing_m_s,
                                  .at = touch_of(l, e)});
    }
    l->answered[0] = batch->step;
}

/* In the order of the bodies' numbers; points of one manifold stay in the daemon's. */
static void add_touch(lockstep *l, const touch *t)
{
    if (l->touch_count == LOCKSTEP_TOUCHES) {
        l->lost = true;
        return;
    }
    size_t i = l->touch_count++;
    for (; i > 0; i--) {
        const touch *before = &l->touches[i - 1];
        if (before->a < t->a || (before->a == t->a && before->b <= t->b)) break;
        l->touches[i] = *before;
    }
    l->touches[i] = *t;
}

/* Where bodies lie on each other the manifold has up to four points. */
static void add_manifold(lockstep *l, const collided_event *e)
{
    touch t = touch_of(l, e);
    l->deepest_m = fmax(l->deepest_m, -e->lo);
    for (size_t i = 0; i < e->point_count; i++) {
        t.point = vector_of(e->points[i].point);
        t.gap = e->points[i].distance;
        add_touch(l, &t);
    }
    if (!e->point_count) add_touch(l, &t);
}

static void on_touches(void *context, const collided_batch *batch)
{
    lockstep *l = context;
    if (batch->step != l->step || l->answered[1] == l->step) return;
    for (size_t i = 0; i < batch->event_count; i++)
        if (batch->events[i].kind == COLLIDED_BEGIN || batch->events[i].kind == COLLIDED_UPDATE)
            add_manifold(l, &batch->events[i]);
    l->answered[1] = batch->step;
}

/* ---- asking ---- */

static void publish(lockstep *l, const vector *velocities)
{
    double positions[3 * LOCKSTEP_BODIES], orientations[4 * LOCKSTEP_BODIES];
    double linear[3 * LOCKSTEP_BODIES], angular[3 * LOCKSTEP_BODIES];
    for (size_t i = 0; i < l->moving; i++) {
        const rigid *b = &l->bodies[i];
        const vector v = velocities ? velocities[i] : b->linear;
        memcpy(positions + 3 * i, &b->position, 3 * sizeof(double));
        memcpy(orientations + 4 * i, b->orientation, 4 * sizeof(double));
        memcpy(linear + 3 * i, &v, 3 * sizeof(double));
        memcpy(angular + 3 * i, &b->angular, 3 * sizeof(double));
    }
    (void)collided_publish(
        l->client, l->moving, l->handles, positions, orientations, linear, angular, 0, l->step); /* polled below */
}

static bool is_answered(const lockstep *l)
{
    return l->answered[0] == l->step && l->answered[1] == l->step;
}

bool lockstep_ask(lockstep *l, const vector *linear)
{
    l->step++;
    l->heap.count = l->touch_count = 0;
    l->round_trips++;
    for (int k = 0; k < TRIES && !is_answered(l); k++) {
        publish(l, linear);
        int64_t until_ns = example_now_ns() + (int64_t)(1e9 * ANSWER_S), left_ns;
        while (!is_answered(l) && (left_ns = until_ns - example_now_ns()) > 0)
            (void)collided_poll(l->client, 1e-9 * (double)left_ns);
    }
    if (l->lost || l->heap.dropped || !is_answered(l))
        fprintf(stderr, "step %lld: %s %s\n", (long long)l->step,
            is_answered(l) ? "the answer is not usable" : "no answer:", collided_error(l->client));
    return is_answered(l) && !l->lost && !l->heap.dropped;
}

/* ---- setting up ---- */

bool lockstep_connect(lockstep *l, const example *e)
{
    collided_def def = collided_def_default();
    def.name = "impact_simulator";
    l->options = e;
    l->client = example_connect(e, &def);
    return l->client != NULL;
}

void lockstep_body(lockstep *l, rigid body, collided_shape shape, double acceleration_m_s2)
{
    collided_body_def def = collided_body_def_default();
    def.name = body.name;
    def.group = "simulated";
    def.motion = body.inverse_mass > 0 ? COLLIDED_MOVING : COLLIDED_FIXED;
    def.acceleration_m_s2 = acceleration_m_s2;
    memcpy(def.pose.position, &body.position, sizeof def.pose.position);
    memcpy(def.pose.orientation, body.orientation, sizeof def.pose.orientation);
    def.shapes = &shape;
    def.shape_count = 1;
    l->handles[l->count] = collided_create_body(l->client, &def);
    l->bodies[l->count++] = body;
    l->moving += body.inverse_mass > 0;
}

bool lockstep_begin(lockstep *l, const lockstep_terms *terms)
{
    collided_subscription_def def = collided_subscription_def_default();
    def.select_a = def.select_b = "group:simulated";
    def.context = l;
    def.tolerance_m = terms->tolerance_m;
    def.facts = COLLIDED_PREDICT;
    def.horizon_s = terms->horizon_s;
    def.callback = on_impacts;
    bool asked = collided_subscribe(l->client, &def).id != COLLIDED_NONE;
    def.facts = COLLIDED_MANIFOLD;
    def.horizon_s = 0;
    def.threshold_m = terms->margin_m;
    def.callback = on_touches;
    asked = asked && collided_subscribe(l->client, &def).id != COLLIDED_NONE;
    if (!asked) fprintf(stderr, "impact_simulator: %s\n", collided_error(l->client));
    bool good = asked && example_ok(l->client, collided_sync(l->client, 5), "impact_simulator: creating the bodies");
    l->begin_ns = example_now_ns();
    return good;
}
