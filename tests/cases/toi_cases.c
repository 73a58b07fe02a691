/* toi_cases: bodies that move, from JSON, asked of toi_find. */
#include "toi_cases.h"

#include "case_json.h"
#include "narrow/toi.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { STEPS_AT_MOST = 512 }; /* whatever must end within a millisecond */

bool toi_query(const char *query)
{
    return strncmp(query, "time_", 5) == 0;
}

/* The frame of a body as a subject without offset or axis of its own: a point. */
static const char *body_pose(json_object *pose_object, pose *out)
{
    subject point;
    json_object *shape_object = json_tokener_parse("{\"type\": \"sphere\", \"radius\": 0}");
    const char *why = subject_from_json(&point, shape_object, pose_object);
    json_object_put(shape_object);
    if (why) return why;
    *out = point.pose;
    subject_free(&point);
    return NULL;
}

static const char *mover(json_object *shape_object, json_object *pose_object, subject *s, toi_mover *out)
{
    double linear[3], angular[3];
    pose body;
    const char *why = subject_from_json(s, shape_object, pose_object);
    if (why) return why;
    if (!member_numbers(pose_object, "velocity", linear, 3) ||
        !member_numbers(pose_object, "angular_velocity", angular, 3))
        why = "no velocities";
    else
        why = body_pose(pose_object, &body);
    if (why) {
        subject_free(s);
        return why;
    }
    *out = (toi_mover){&s->shape, pose_relative(body, s->pose),
        {body, vec(linear[0], linear[1], linear[2]), vec(angular[0], angular[1], angular[2])}};
    return NULL;
}

/* Its bracket must hold the source's number and be narrow, and whoever never touches must be proven free. */
static bool holds(const toi_result *t, bool touches, double expected, double span)
{
    if (t->steps > STEPS_AT_MOST) return false;
    if (!touches) return t->status == TOI_FREE;
    double rounding = 1e-14 * span + 1e-14 * expected;
    return t->status == TOI_HIT && t->lo <= expected + rounding && t->hi >= expected - rounding &&
           t->hi - t->lo <= 1e-6 * span;
}

static bool decide(json_object *object, const toi_mover *a, const toi_mover *b)
{
    static narrow_scratch *scratch;
    if (!scratch) scratch = aligned_alloc(64, narrow_scratch_size());
    if (!scratch) abort();
    double expected = INFINITY;
    toi_request r = {.span = 1};
    bool ordered = narrow_ordered(a->shape, 0, b->shape, 1);
    bool touches = member_number(member(object, "expected"), "toi|ttc", &expected);
    (void)member_number(member(object, "poseA"), "horizon", &r.span);
    r.tolerance = 1e-9 * fmin(shape_reach(a->shape) + shape_reach(b->shape), 1e9);
    toi_result t;
    toi_find(ordered ? a : b, ordered ? b : a, &r, VEC_ZERO, scratch, &t);
    bool right = holds(&t, touches, expected, r.span);
    printf("%-36s %24.17g %24.17g %24.17g %9.2g  %s, %s\n", member_text(object, "id"), expected, t.lo, t.hi,
        t.status == TOI_HIT ? t.hi - t.lo : 0, right ? "holds" : "WRONG", toi_status_name(t.status));
    return right;
}

bool toi_case(json_object *object, const char **skipped)
{
    subject sa, sb;
    toi_mover a, b;
    *skipped = mover(member(object, "shapeA|A"), member(object, "poseA"), &sa, &a);
    if (*skipped) return true;
    *skipped = mover(member(object, "shapeB|B"), member(object, "poseB"), &sb, &b);
    bool right = *skipped || decide(object, &a, &b);
    if (!*skipped) subject_free(&sb);
    subject_free(&sa);
    return right;
}
