/* queries: one at a time, matched by client and sequence. A transport that repeats asks again under the same sequence,
 * and the daemon answers again; after a restart of the daemon the new one is asked. The caller's thread. */
#include "allocate.h"
#include "message.h"
#include "observe.h"
#include "session.h"
#include "session_run.h"

#include <stdlib.h>
#include <string.h>

enum { FIRST_REPEAT_MS = 200, LAST_REPEAT_MS = 1000 };

static bool query_settled(const collided *c)
{
    return c->answer || c->query_reject || c->query_epoch != c->epoch;
}

static void send_query(collided *c, wire_message *q)
{
    pthread_mutex_lock(&c->lock);
    if (!c->query)
        c->query = q->query.sequence = ++c->sequence;
    else
        c->counters.repeats++;
    c->query_epoch = c->epoch;
    (void)session_send(c, q); /* counted; asked again below, or the time runs out */
    c->link->ops->flush(c->link);
    pthread_mutex_unlock(&c->lock);
}

static bool has_outcome(collided *c)
{
    pthread_mutex_lock(&c->lock);
    bool outcome = c->answer || c->query_reject;
    pthread_mutex_unlock(&c->lock);
    return outcome;
}

static void wait_for_answer(collided *c, wire_message *q, int64_t deadline_ns)
{
    int64_t wait_ns = FIRST_REPEAT_MS * NS_PER_MS;
    do {
        int64_t until = session_monotonic_ns() + wait_ns;
        send_query(c, q);
        if (!c->link->ops->repeats || until > deadline_ns) until = deadline_ns;
        (void)session_wait(c, until, query_settled);
        if (wait_ns < LAST_REPEAT_MS * NS_PER_MS) wait_ns *= 2;
    } while (!has_outcome(c) && session_monotonic_ns() < deadline_ns);
}

static size_t names_size(wire_strings names)
{
    size_t bytes = 0;
    for (uint32_t i = 0; i < names.count; i++) bytes += strlen(names.at[i]) + 1;
    return bytes;
}

static const char *put_name(char **at, const char *name)
{
    const char *copy = *at;
    *at = stpcpy(*at, name) + 1;
    return copy;
}

/* What an answer may lack (wire_check_events.c) is 0. */
static void copy_vec(double to[3], wire_f64s from, uint32_t i)
{
    if (from.count) memcpy(to, from.at + 3 * (size_t)i, 3 * sizeof *to);
}

static void fill_hit(collided_hit *hit, const wire_answer *a, uint32_t i, char **names)
{
    *hit = (collided_hit){.age_s = -1.0};
    hit->name_a = put_name(names, a->names_a.at[i]);
    hit->name_b = a->names_b.count ? put_name(names, a->names_b.at[i]) : "";
    if (a->lo.count) hit->lo = a->lo.at[i];
    if (a->hi.count) hit->hi = a->hi.at[i];
    copy_vec(hit->axis, a->axes, i);
    copy_vec(hit->point_a, a->points_a, i);
    copy_vec(hit->point_b, a->points_b, i);
    if (a->orientations.count) memcpy(hit->orientation, a->orientations.at + 4 * (size_t)i, sizeof hit->orientation);
    if (a->ages_ns.count && a->ages_ns.at[i] >= 0) hit->age_s = (double)a->ages_ns.at[i] * 1e-9;
    hit->stale = a->stale.count && a->stale.at[i] != 0;
    if (a->achieved.count) hit->achieved = (collided_achieved)a->achieved.at[i];
}

/* The hits and the names that they point to are one block. */
static void fill_result(collided_result *out, const wire_answer *a)
{
    uint32_t count = a->names_a.count;
    size_t hits = count * sizeof *out->hits;
    out->hits = allocate(1, hits + names_size(a->names_a) + names_size(a->names_b));
    out->count = count;
    char *names = (char *)out->hits + hits;
    for (uint32_t i = 0; i < count; i++) fill_hit(&out->hits[i], a, i, &names);
    size_t text = strlen(a->text) + 1;
    out->text = memcpy(allocate(1, text), a->text, text);
    out->truncated = a->status == WIRE_ANSWER_TRUNCATED;
    out->epoch = a->epoch;
    out->tick = a->tick;
}

static collided_status outcome(collided *c, collided_result *out, double timeout_s)
{
    if (c->answer) {
        const wire_answer *a = &c->answer->answer;
        if (a->status == WIRE_ANSWER_UNKNOWN_NAME) return session_fail(c, COLLIDED_UNKNOWN_ID, "%s", a->text);
        if (a->status == WIRE_ANSWER_UNSUPPORTED) return session_fail(c, COLLIDED_UNSUPPORTED, "%s", a->text);
        if (a->status > WIRE_ANSWER_TRUNCATED) /* of a later daemon */
            return session_fail(c, COLLIDED_UNSUPPORTED, "unknown status %u: %s", a->status, a->text);
        fill_result(out, a);
        if (c->answer_wanted) {
            *c->answer_wanted = c->answer;
            c->answer = NULL;
        }
        return COLLIDED_OK;
    }
    if (c->query_reject) {
        const wire_reject *r = &c->query_reject->reject;
        return session_fail(c, COLLIDED_REJECTED, "%s: %s", wire_reason_name((wire_reason)r->reason), r->text);
    }
    return session_fail(c, COLLIDED_TIMEOUT, "no answer within %g s", timeout_s);
}

static void forget_query(collided *c)
{
    pthread_mutex_lock(&c->lock);
    free(c->query_reject);
    c->query_reject = NULL;
    c->query = 0;
    pthread_mutex_unlock(&c->lock);
    free(c->answer);
    c->answer = NULL;
}

static collided_status unmet(collided *c, double timeout_s)
{
    if (session_unheard(c)) return session_fail(c, COLLIDED_NO_DAEMON, "no daemon has been heard for 3 s");
    return session_fail(c, COLLIDED_TIMEOUT, "the daemon does not know this client after %g s", timeout_s);
}

static collided_status ask_into(collided *c, wire_query query, double timeout_s, collided_result *out)
{
    *out = (collided_result){0};
    if (session_from_callback(c)) return COLLIDED_BAD_ARGUMENT;
    query.version = WIRE_VERSION;
    query.client = c->id;
    query.sequence = 1; /* for the check; send_query gives it its own */
    if (!query.name_a) query.name_a = "";
    if (!query.name_b) query.name_b = "";
    wire_message q = {.kind = WIRE_QUERY, .query = query};
    wire_refusal why;
    if (wire_check(&q, &why) != WIRE_OK) return session_fail(c, COLLIDED_BAD_ARGUMENT, "query: %s", why.text);
    int64_t deadline = session_monotonic_ns() + session_seconds(timeout_s);
    collided_flush(c); /* what was published before is answered for */
    if (!session_wait(c, deadline, session_known)) return unmet(c, timeout_s);
    wait_for_answer(c, &q, deadline);
    pthread_mutex_lock(&c->lock);
    collided_status status = outcome(c, out, timeout_s);
    pthread_mutex_unlock(&c->lock);
    forget_query(c);
    return status;
}

collided_status query_answer(collided *c, wire_query query, double timeout_s, wire_message **answer)
{
    collided_result unwanted;
    c->answer_wanted = answer;
    collided_status status = ask_into(c, query, timeout_s, &unwanted);
    c->answer_wanted = NULL;
    collided_result_free(&unwanted);
    return status;
}

/* Who wants to know only whether it went well hands over NULL. */
static collided_status ask_with_timeout(collided *c, wire_query query, double timeout_s, collided_result *out)
{
    collided_result unwanted;
    collided_status status = ask_into(c, query, timeout_s, out ? out : &unwanted);
    if (!out) collided_result_free(&unwanted);
    return status;
}

collided_status collided_query_ray(collided *c, const double origin[3], const double direction[3], double length_m,
    double timeout_s, collided_result *out)
{
    wire_query q = {.kind = WIRE_QUERY_RAY, .origin = {3, origin}, .direction = {3, direction}, .length_m = length_m};
    return ask_with_timeout(c, q, timeout_s, out);
}

collided_status collided_query_distance(
    collided *c, const char *name_a, const char *name_b, double tolerance_m, double timeout_s, collided_result *out)
{
    wire_query q = {.kind = WIRE_QUERY_DISTANCE, .name_a = name_a, .name_b = name_b, .tolerance_m = tolerance_m};
    return ask_with_timeout(c, q, timeout_s, out);
}

collided_status collided_query_box(
    collided *c, const collided_pose *pose, const double half[3], double timeout_s, collided_result *out)
{
    wire_query q = {.kind = WIRE_QUERY_BOX,
        .origin = {3, pose->position},
        .orientation = {4, pose->orientation},
        .half = {3, half}};
    return ask_with_timeout(c, q, timeout_s, out);
}

collided_status collided_query_cast(collided *c, const collided_pose *pose, const double half[3],
    const double direction[3], double length_m, double timeout_s, collided_result *out)
{
    wire_query q = {.kind = WIRE_QUERY_CAST,
        .origin = {3, pose->position},
        .orientation = {4, pose->orientation},
        .half = {3, half},
        .direction = {3, direction},
        .length_m = length_m};
    return ask_with_timeout(c, q, timeout_s, out);
}

collided_status collided_query_sweep(collided *c, const char *name, const double linear[3], const double angular[3],
    double span_s, double tolerance_m, double timeout_s, collided_result *out)
{
    wire_query q = {.kind = WIRE_QUERY_SWEEP, .name_a = name, .tolerance_m = tolerance_m, .span_s = span_s};
    if (linear) q.linear = (wire_f64s){3, linear};
    if (angular) q.angular = (wire_f64s){3, angular};
    return ask_with_timeout(c, q, timeout_s, out);
}

collided_status collided_query_nearest(collided *c, const char *name, const collided_pose *pose, const double half[3],
    double within_m, int32_t most, double timeout_s, collided_result *out)
{
    wire_query q = {.kind = WIRE_QUERY_NEAREST, .name_a = name, .length_m = within_m, .most = most};
    if (!name) {
        q.origin = (wire_f64s){3, pose->position};
        q.orientation = (wire_f64s){4, pose->orientation};
        q.half = (wire_f64s){3, half};
    }
    return ask_with_timeout(c, q, timeout_s, out);
}

collided_status collided_query_explain(
    collided *c, const char *name_a, const char *name_b, double timeout_s, collided_result *out)
{
    return ask_with_timeout(
        c, (wire_query){.kind = WIRE_QUERY_EXPLAIN, .name_a = name_a, .name_b = name_b}, timeout_s, out);
}

collided_status collided_query_bodies(collided *c, const char *pattern, double timeout_s, collided_result *out)
{
    return ask_with_timeout(c, (wire_query){.kind = WIRE_QUERY_BODIES, .name_a = pattern}, timeout_s, out);
}

collided_status collided_record(collided *c, const char *name, double timeout_s, collided_result *out)
{
    return ask_with_timeout(c, (wire_query){.kind = WIRE_QUERY_RECORD, .name_a = name}, timeout_s, out);
}

void collided_result_free(collided_result *result)
{
    free(result->hits);
    free(result->text);
    *result = (collided_result){0};
}
