/* poses: publishing them. A pose is volatile and a network has no order between topics, so what belongs to a body that
 * the daemon has not acknowledged is kept, newest wins, and goes out with the acknowledgement. The arrays are handed to
 * the transport as they are: nothing is copied or allocated here in the steady state. */
#include "allocate.h"
#include "announce.h"
#include "session.h"
#include "session_run.h"

#include <assert.h>
#include <string.h>

typedef struct poses {
    size_t count;
    const collided_body *bodies;
    const double *positions, *orientations, *linear, *angular;
    int64_t stamp_ns, step, simulation_ns;
    bool teleport;
    const jointed_poses *joints; /* that they come from; NULL: from none */
} poses;

static_assert(sizeof(collided_body) == sizeof(int32_t), "an array of bodies is sent as an array of their numbers");

/* The batch of the poses from `first` on. */
static wire_message batch_of(const collided *c, const poses *p, size_t first, size_t count)
{
    uint32_t n = (uint32_t)count;
    static const uint8_t ALL[WIRE_POSES_MAX] = {[0 ... WIRE_POSES_MAX - 1] = 1};
    wire_f64s none = {0, NULL};
    return (wire_message){.kind = WIRE_POSE_BATCH,
        .pose_batch = {.version = WIRE_VERSION,
            .client = c->id,
            .sequence = c->sequence + 1,
            .stamp_ns = p->stamp_ns,
            .step = p->step,
            .simulation_ns = p->simulation_ns,
            .bodies = {n, &p->bodies[first].id},
            .positions = {3 * n, p->positions + 3 * first},
            .orientations = {4 * n, p->orientations + 4 * first},
            .linear = p->linear ? (wire_f64s){3 * n, p->linear + 3 * first} : none,
            .angular = p->angular ? (wire_f64s){3 * n, p->angular + 3 * first} : none,
            .teleports = p->teleport ? (wire_u8s){n, ALL} : (wire_u8s){0, NULL}}};
}

static size_t chunk(const collided *c, const poses *p, size_t first)
{
    size_t left = p->count - first, most = c->link->ops->poses_max;
    return left < most ? left : most;
}

/* Records lie all over memory: those that come next are asked for while these are worked on. */
static void fetch_record(const body_record *body)
{
    enum { LINE = 64 };
    if (!body) return;
    for (size_t at = 0; at < sizeof *body; at += LINE) __builtin_prefetch((const char *)body + at, 1);
}

/* Fills c->published. */
static void find_records(collided *c, const poses *p)
{
    enum { AHEAD = 12 };
    if (p->count > c->published_capacity)
        c->published = reserve(c->published, &c->published_capacity, p->count, sizeof *c->published);
    for (size_t i = 0; i < p->count; i++) {
        if (i + AHEAD < p->count) table_fetch(&c->bodies, p->bodies[i + AHEAD].id);
        c->published[i] = table_get(&c->bodies, p->bodies[i].id);
        fetch_record(c->published[i]);
    }
}

static collided_status check_bodies(collided *c, const poses *p)
{
    find_records(c, p);
    for (size_t i = 0; i < p->count; i++) {
        const body_record *body = c->published[i];
        if (!body || body->removed)
            return session_fail(c, COLLIDED_UNKNOWN_ID, "bodies[%zu]: there is no body %d", i, p->bodies[i].id);
        if (body->announced.state == ANNOUNCE_REFUSED)
            return session_fail(c, COLLIDED_REJECTED, "bodies[%zu]: the daemon refused body %d", i, p->bodies[i].id);
    }
    return COLLIDED_OK;
}

static collided_status check_numbers(collided *c, const poses *p)
{
    for (size_t first = 0, n; first < p->count; first += n) {
        n = chunk(c, p, first);
        wire_message m = batch_of(c, p, first, n);
        wire_refusal why;
        if (wire_check(&m, &why) == WIRE_OK) continue;
        return session_fail(c, COLLIDED_BAD_ARGUMENT, "poses from %zu on: %s", first, why.text);
    }
    return COLLIDED_OK;
}

/* The newest pose is remembered for announcements to come. True if it can be sent now. */
static bool remember(collided *c, const poses *p, size_t i)
{
    body_record *body = c->published[i];
    if (p->stamp_ns >= body->stamp_ns || p->teleport) {
        memcpy(body->pose, p->positions + 3 * i, 3 * sizeof(double));
        memcpy(body->pose + 3, p->orientations + 4 * i, 4 * sizeof(double));
        if (p->linear) memcpy(body->velocity, p->linear + 3 * i, 3 * sizeof(double));
        if (p->angular) memcpy(body->velocity + 3, p->angular + 3 * i, 3 * sizeof(double));
        body->has_linear = p->linear != NULL;
        body->has_angular = p->angular != NULL;
        body->stamp_ns = p->stamp_ns;
        body->step = p->step;
        body->simulation_ns = p->simulation_ns;
        body->teleported = body->announced.state != ANNOUNCE_ACKED && (p->teleport || body->teleported);
    }
    return body->announced.state == ANNOUNCE_ACKED;
}

static int send_run(collided *c, const poses *p, size_t first, size_t count)
{
    if (!count) return 0;
    wire_message m = batch_of(c, p, first, count);
    c->sequence++;
    return session_send(c, &m);
}

/* Runs of bodies that the daemon knows go out as they lie in the caller's arrays; in the steady state that is one. */
static collided_status send_known(collided *c, const poses *p)
{
    int failed = 0;
    size_t first = 0, most = c->link->ops->poses_max;
    for (size_t i = 0; i < p->count; i++) {
        bool known = remember(c, p, i);
        if (known && i - first < most) continue;
        failed |= send_run(c, p, first, i - first);
        first = known ? i : i + 1;
    }
    failed |= send_run(c, p, first, p->count - first);
    return failed ? session_fail(c, COLLIDED_TRANSPORT, "the transport did not take the poses") : COLLIDED_OK;
}

static bool is_acked(const body_record *b)
{
    return b && b->announced.state == ANNOUNCE_ACKED;
}

static bool can_send_joints(const collided *c, const poses *p)
{
    bool can = p->joints && is_acked(table_get(&c->bodies, p->joints->carrier));
    for (size_t i = 0; i < p->count && can; i++) can = is_acked(c->published[i]);
    return can;
}

/* What they come to is remembered as if it had been sent. */
static collided_status send_joints(collided *c, const poses *p)
{
    for (size_t i = 0; i < p->count; i++) (void)remember(c, p, i);
    const wire_message m = {.kind = WIRE_POSE_BATCH,
        .pose_batch = {.version = WIRE_VERSION,
            .client = c->id,
            .sequence = ++c->sequence,
            .stamp_ns = p->stamp_ns,
            .step = p->step,
            .simulation_ns = p->simulation_ns,
            .extensions = {p->joints->extension_count, p->joints->extensions}}};
    if (session_send(c, &m) == 0) return COLLIDED_OK;
    return session_fail(c, COLLIDED_TRANSPORT, "the transport did not take the joints");
}

/* If the wall clock was set back, the newest poses would be older than those before: these go back with it. The daemon
 * does the same. Stamps of a simulator's own time, a day and more from the clock, are left. */
static void follow_clock(collided *c)
{
    static const int64_t STEP_NS = 20 * NS_PER_MS, NEAR_NS = 86400 * NS_PER_S;
    int64_t now = session_now_ns(), ahead = now - session_monotonic_ns(), by = c->wall_ahead_ns - ahead;
    bool back = c->wall_ahead_ns && by > STEP_NS;
    c->wall_ahead_ns = ahead;
    for (size_t i = 0; back && i < c->bodies.capacity; i++) {
        body_record *body = c->bodies.slots[i].value;
        if (!body || body->stamp_ns <= by) continue;
        int64_t after = body->stamp_ns - by;
        if (after > now - NEAR_NS && after < now + NEAR_NS) body->stamp_ns = after;
    }
}

static collided_status publish(collided *c, poses p)
{
    if (p.count && (!p.bodies || !p.positions || !p.orientations))
        return session_fail(c, COLLIDED_BAD_ARGUMENT, "bodies, positions and orientations are needed");
    if (!p.stamp_ns) p.stamp_ns = session_now_ns();
    pthread_mutex_lock(&c->lock);
    follow_clock(c);
    collided_status status = check_bodies(c, &p);
    if (status == COLLIDED_OK) status = check_numbers(c, &p);
    if (status == COLLIDED_OK) status = can_send_joints(c, &p) ? send_joints(c, &p) : send_known(c, &p);
    pthread_mutex_unlock(&c->lock);
    if (p.step && p.step == c->awaited_step) c->step_resumed = true;
    return status;
}

collided_status collided_publish(collided *c, size_t count, const collided_body *bodies, const double *positions,
    const double *orientations, const double *linear, const double *angular, int64_t stamp_ns, int64_t step)
{
    return publish(c, (poses){count, bodies, positions, orientations, linear, angular, stamp_ns, step, c->simulation_ns,
                          .teleport = false});
}

collided_status collided_teleport(collided *c, size_t count, const collided_body *bodies, const double *positions,
    const double *orientations, const double *linear, const double *angular, int64_t stamp_ns, int64_t step)
{
    return publish(c, (poses){count, bodies, positions, orientations, linear, angular, stamp_ns, step, c->simulation_ns,
                          .teleport = true});
}

collided_status poses_publish_joints(collided *c, const jointed_poses *j, int64_t stamp_ns, int64_t step)
{
    return publish(c, (poses){j->count, j->bodies, j->positions, j->orientations, NULL, NULL, stamp_ns, step,
                          c->simulation_ns, .teleport = j->teleport, .joints = j});
}

collided_status collided_move(collided *c, collided_body body, collided_pose pose)
{
    return collided_publish(c, 1, &body, pose.position, pose.orientation, NULL, NULL, 0, 0);
}

void body_acked(collided *c, body_record *body)
{
    bool teleported = body->teleported;
    body->teleported = false;
    if (!body_has_newer_pose(body)) return;
    const collided_body id = {body->id};
    const poses p = {1, &id, body->pose, body->pose + 3, body->has_linear ? body->velocity : NULL,
        body->has_angular ? body->velocity + 3 : NULL, body->stamp_ns, c->lock_step ? 0 : body->step,
        c->lock_step ? 0 : body->simulation_ns, .teleport = teleported,
        .joints = NULL};         /* a step of lock-step may have ended meanwhile */
    (void)send_run(c, &p, 0, 1); /* a failure is counted there */
}

/* In runs that have stamp and velocities in common. Of lock-step none: a step that lacks them is told to its client. */
void poses_send_again(collided *c)
{
    enum { RUN = 256 };
    static const double NONE[6];
    collided_body bodies[RUN];
    double positions[3 * RUN], orientations[4 * RUN], linear[3 * RUN], angular[3 * RUN];
    poses p = {0, bodies, positions, orientations, NULL, NULL, 0, 0, 0, false, NULL};
    for (size_t i = 0; i < c->bodies.capacity && !c->lock_step; i++) {
        const body_record *b = c->bodies.slots[i].value;
        if (!b || b->removed || b->announced.state != ANNOUNCE_ACKED || !body_has_newer_pose(b)) continue;
        bool fits = p.count < RUN && p.count < c->link->ops->poses_max && p.stamp_ns == b->stamp_ns &&
                    p.step == b->step && p.simulation_ns == b->simulation_ns && !p.linear == !b->has_linear &&
                    !p.angular == !b->has_angular;
        if (!fits) {
            (void)send_run(c, &p, 0, p.count);
            p = (poses){0, bodies, positions, orientations, b->has_linear ? linear : NULL,
                b->has_angular ? angular : NULL, b->stamp_ns, b->step, b->simulation_ns, false, NULL};
        }
        bodies[p.count] = (collided_body){b->id};
        memcpy(positions + 3 * p.count, b->pose, 3 * sizeof(double));
        memcpy(orientations + 4 * p.count, b->pose + 3, 4 * sizeof(double));
        memcpy(linear + 3 * p.count, b->has_linear ? b->velocity : NONE, 3 * sizeof(double));
        memcpy(angular + 3 * p.count, b->has_angular ? b->velocity + 3 : NONE, 3 * sizeof(double));
        p.count++;
    }
    (void)send_run(c, &p, 0, p.count);
}

collided_status collided_set_simulation_time(collided *c, int64_t simulation_ns)
{
    if (simulation_ns < 0)
        return session_fail(
            c, COLLIDED_BAD_ARGUMENT, "simulation_ns is %lld: at least 0 is allowed", (long long)simulation_ns);
    c->simulation_ns = simulation_ns;
    return COLLIDED_OK;
}

/* ---- lock-step ---- */

/* With the lock held: its stream tells of each step. None that the daemon refused does. */
static bool reports_of_steps(const subscription_record *i)
{
    return !i->removed && i->each_tick && i->announced.state != ANNOUNCE_REFUSED;
}

static bool step_is_reported(const collided *c)
{
    size_t report = 0, reported = 0;
    for (const subscription_record *i = c->subscriptions; i; i = i->next) {
        report += reports_of_steps(i);
        reported += reports_of_steps(i) && i->step >= c->awaited_step;
    }
    return report && reported == report;
}

/* Nobody to tell of it any more: there is nothing to wait for. */
static bool step_is_over(const collided *c)
{
    bool awaited = false;
    for (const subscription_record *i = c->subscriptions; i; i = i->next)
        awaited = awaited || (reports_of_steps(i) && i->step < c->awaited_step);
    return !awaited || c->step_refused;
}

/* COLLIDED_OK if a subscription can tell when a step is done. */
static collided_status check_hearing(collided *c)
{
    size_t report = 0, refused = 0;
    pthread_mutex_lock(&c->lock);
    for (const subscription_record *i = c->subscriptions; i; i = i->next) {
        report += reports_of_steps(i);
        refused += !i->removed && i->each_tick && i->announced.state == ANNOUNCE_REFUSED;
    }
    pthread_mutex_unlock(&c->lock);
    if (report) return COLLIDED_OK;
    if (refused) return session_fail(c, COLLIDED_REJECTED, "the daemon refused what could tell when a step is done");
    return session_fail(c, COLLIDED_BAD_ARGUMENT, "no subscription of rate_hz 0 could tell when a step is done");
}

void step_answered(collided *c, subscription_record *subscription, const wire_event_batch *b)
{
    if (b->missing < 0) return; /* it was done without us */
    subscription->step = b->step;
    if (b->step != c->awaited_step || !b->refused) return;
    c->step_lacks = b->refused;
    c->step_lacks_why = b->refusal;
}

/* Has it been ended already, with all that was published for it? What was refused has to be sent anew. */
static bool is_ended(const collided *c, int64_t step)
{
    return step == c->awaited_step && !c->step_resumed && !c->step_refused;
}

/* With the lock held. */
static void begin_end_of_step(collided *c, int64_t step)
{
    for (subscription_record *i = c->subscriptions; i; i = i->next) i->step = 0;
    c->awaited_step = step;
    c->step_resumed = false;
    c->step_lacks = 0;
    c->step_sent_ns = 0;
    c->step_begin = c->step_end;
    c->step_end = ++c->sequence;
    c->step_refused = false;
}

/* Once more under the same sequence: a copy ends nothing that came since. Not with each call of who looks often. With
 * the lock held. */
static int send_end_of_step(collided *c)
{
    const int64_t now = session_monotonic_ns(), often_ns = ANNOUNCE_FIRST_DOUBT_MS * NS_PER_MS;
    if (c->step_sent_ns && now - c->step_sent_ns < often_ns) return 0;
    const wire_message m = {.kind = WIRE_POSE_BATCH,
        .pose_batch = {.version = WIRE_VERSION,
            .client = c->id,
            .sequence = c->step_end,
            .step = c->awaited_step,
            .simulation_ns = c->simulation_ns}};
    c->step_sent_ns = now;
    int failed = session_send(c, &m);
    c->link->ops->flush(c->link);
    return failed;
}

/* With the lock held. */
static collided_status outcome_of_step(collided *c, double timeout_s)
{
    long long step = (long long)c->awaited_step;
    if (c->step_refused) return session_fail(c, COLLIDED_REJECTED, "%s", c->step_refusal);
    if (timeout_s > 0 ? !step_is_over(c) : !step_is_reported(c))
        return session_fail(c, COLLIDED_TIMEOUT, "step %lld is not done after %g s", step, timeout_s);
    if (!c->step_lacks) return COLLIDED_OK;
    return session_fail(c, COLLIDED_REJECTED, "step %lld is done, but %d of this client's poses were refused: %s", step,
        c->step_lacks, wire_reason_name((wire_reason)c->step_lacks_why));
}

collided_status collided_step(collided *c, int64_t step, double timeout_s)
{
    if (timeout_s > 0 && session_from_callback(c)) return COLLIDED_BAD_ARGUMENT;
    if (step <= 0) return session_fail(c, COLLIDED_BAD_ARGUMENT, "step is %lld: above 0 is allowed", (long long)step);
    if (!c->lock_step) return session_fail(c, COLLIDED_BAD_ARGUMENT, "this client is not in lock-step: collided_def");
    collided_status status = timeout_s > 0 ? check_hearing(c) : COLLIDED_OK;
    if (status) return status;
    pthread_mutex_lock(&c->lock);
    if (!is_ended(c, step)) begin_end_of_step(c, step);
    int failed = step_is_reported(c) ? 0 : send_end_of_step(c);
    pthread_mutex_unlock(&c->lock);
    if (failed) return session_fail(c, COLLIDED_TRANSPORT, "the transport did not take the end of the step");
    if (!c->in_callback) (void)session_wait(c, session_monotonic_ns() + session_seconds(timeout_s), step_is_over);
    pthread_mutex_lock(&c->lock);
    status = outcome_of_step(c, timeout_s);
    pthread_mutex_unlock(&c->lock);
    /* The daemon may have refused meanwhile what was waited for; a callback may end its own subscription. */
    if (status == COLLIDED_OK && check_hearing(c) == COLLIDED_REJECTED) return COLLIDED_REJECTED;
    return status;
}
