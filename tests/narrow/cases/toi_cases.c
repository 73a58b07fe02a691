/* toi_cases: what moves, from JSON, asked of toi_find and of the elementary tests. */
#include "toi_cases.h"

#include "case_json.h"
#include "geom/mesh.h"
#include "soft/elementary.h"
#include "toi/toi.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { STEPS_AT_MOST = 512 }; /* whatever must end within a millisecond */

bool toi_query(const char *query)
{
    return strncmp(query, "time_", 5) == 0 || strncmp(query, "ccd_", 4) == 0;
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

/* The one mesh that the case files name for bodies that move: a solid, as opposed to its hull. */
static const char *cube_of_triangles(subject *s, json_object *shape_object)
{
    static const int32_t CORNERS[] = {
        0, 2, 3, 0, 3, 1, 4, 5, 7, 4, 7, 6, 0, 1, 5, 0, 5, 4, 2, 6, 7, 2, 7, 3, 0, 4, 6, 0, 6, 2, 1, 3, 7, 1, 7, 5};
    static mesh *cube;
    if (strcmp(member_text(shape_object, "generator"), "12-triangle cube, half size 1") != 0)
        return "unknown generator";
    double points[24];
    for (int i = 0; i < 24; i++) points[i] = i / 3 >> i % 3 & 1 ? 1 : -1;
    if (!cube && (mesh_build(points, 8, CORNERS, 12, &cube) != MESH_OK || !cube->solid)) abort();
    subject_from_shape(s, (shape){.type = SHAPE_SPHERE});
    s->shape = (shape){.type = SHAPE_MESH, .mesh = cube, .hull = cube->hull};
    return NULL;
}

static const char *subject_of(subject *s, json_object *shape_object, json_object *pose_object)
{
    if (strcmp(member_text(shape_object, "type"), "mesh") != 0) return subject_from_json(s, shape_object, pose_object);
    pose at;
    const char *why = body_pose(pose_object, &at);
    if (!why) why = cube_of_triangles(s, shape_object);
    if (!why) s->pose = at;
    return why;
}

/* `moves`: where the velocities stand. */
static const char *mover(
    json_object *shape_object, json_object *pose_object, json_object *moves, subject *s, toi_mover *out)
{
    double linear[3], angular[3];
    pose body;
    if (!member_numbers(moves, "velocity|v", linear, 3) || !member_numbers(moves, "angular_velocity|w", angular, 3))
        return "no velocities";
    const char *why = body_pose(pose_object, &body);
    if (!why) why = subject_of(s, shape_object, pose_object);
    if (why) return why;
    *out = (toi_mover){&s->shape, pose_relative(body, s->pose),
        {body, vec(linear[0], linear[1], linear[2]), vec(angular[0], angular[1], angular[2])}};
    return NULL;
}

/* ---- what is expected ---- */

typedef struct expected_time {
    bool touches;
    bool barely; /* a touch without depth, or of meshes with faces in one plane, whose depth doubles cannot tell from 0
                  */
    double lo, hi, span;
} expected_time;

/* Without a tolerance of its own the time is good to its printing. */
static expected_time expected_of(json_object *object, double span)
{
    json_object *said = member(object, "expected|expect"), *hit = member(said, "hit");
    expected_time e = {.span = span, .lo = INFINITY, .hi = INFINITY};
    double tolerance = 1e-14, both[2];
    (void)member_number(object, "tol_rel", &tolerance);
    e.touches = member_number(said, "toi|ttc", &e.lo);
    e.hi = e.lo;
    if (member_numbers(said, "toi", both, 2)) e.touches = true, e.lo = both[0], e.hi = both[1];
    e.barely = json_object_is_type(hit, json_type_string);
    e.lo -= tolerance * span, e.hi += tolerance * span;
    return e;
}

/* Its bracket must hold the source's number and be narrow, and whoever never touches must be proven free. */
static bool holds(const toi_result *t, const expected_time *e)
{
    if (t->steps > STEPS_AT_MOST) return false;
    if (!e->touches) return t->status == TOI_FREE;
    if (e->barely && t->status == TOI_NEAR) return t->lo <= e->hi && t->lo >= e->lo - 1e-4 * e->span;
    return t->status == TOI_HIT && t->lo <= e->hi && t->hi >= e->lo && t->hi - t->lo <= 1e-5 * e->span;
}

static void print(json_object *object, const expected_time *e, double lo, double hi, bool right, const char *status)
{
    printf("%-36s %24.17g %24.17g %24.17g %9.2g  %s, %s\n", member_text(object, "id"), 0.5 * (e->lo + e->hi), lo, hi,
        isfinite(lo) && isfinite(hi) ? hi - lo : 0, right ? "holds" : "WRONG", status);
}

/* ---- rigid bodies ---- */

static bool decide(json_object *object, const toi_mover *a, const toi_mover *b)
{
    static narrow_scratch *scratch;
    if (!scratch) scratch = aligned_alloc(64, narrow_scratch_size());
    if (!scratch) abort();
    toi_request r = {.span = 1};
    bool ordered = narrow_ordered(a->shape, 0, b->shape, 1);
    (void)member_number(member(object, "poseA"), "horizon", &r.span);
    bool mesh = a->shape->type == SHAPE_MESH; /* its depths are wider brackets */
    r.tolerance = (mesh ? 1e-9 : 1e-11) * (shape_reach(a->shape) + shape_reach(b->shape));
    expected_time e = expected_of(object, r.span);
    e.barely = e.barely || mesh;
    toi_result t;
    toi_find(ordered ? a : b, ordered ? b : a, &r, VEC_ZERO, scratch, &t);
    if (mesh) t.steps = 0; /* those of all its boxes and triangles */
    bool right = holds(&t, &e);
    print(object, &e, t.lo, t.hi, right, toi_status_name(t.status));
    return right;
}

static bool rigid_case(json_object *object, const char **skipped)
{
    subject sa, sb;
    toi_mover a, b;
    json_object *pose_a = member(object, "poseA"), *pose_b = member(object, "poseB");
    json_object *moves_a = member(object, "motionA"), *moves_b = member(object, "motionB");
    *skipped = mover(member(object, "shapeA|A"), pose_a, moves_a ? moves_a : pose_a, &sa, &a);
    if (*skipped) return true;
    *skipped = mover(member(object, "shapeB|B"), pose_b, moves_b ? moves_b : pose_b, &sb, &b);
    bool right = *skipped || decide(object, &a, &b);
    if (!*skipped) subject_free(&sb);
    subject_free(&sa);
    return right;
}

/* ---- a vertex and a face, two edges ---- */

static bool elementary_case(json_object *object, const char **skipped)
{
    vec3 at[8];
    json_object *vertices = member(object, "vertices");
    *skipped = json_object_array_length(vertices) == 8 ? NULL : "not eight vertices";
    if (*skipped) return true;
    for (size_t i = 0; i < 8; i++) {
        json_object *v = json_object_array_get_idx(vertices, i);
        at[i] = vec(json_object_get_double(json_object_array_get_idx(v, 0)),
            json_object_get_double(json_object_array_get_idx(v, 1)),
            json_object_get_double(json_object_array_get_idx(v, 2)));
    }
    expected_time e = expected_of(object, 1);
    elementary_result r;
    if (strcmp(member_text(object, "kind"), "VF") == 0)
        elementary_vertex_face(at, at + 4, 0, &r);
    else
        elementary_edge_edge(at, at + 4, 0, &r);
    bool hit = r.status == ELEMENTARY_HIT, within = hit && r.proof == ELEMENTARY_WITHIN;
    bool right = e.touches ? hit && r.t_lo <= e.hi && r.t_lo >= e.lo - 1e-6 : !hit || within;
    print(object, &e, hit ? r.t_lo : INFINITY, hit ? r.t_hi : INFINITY, right,
        hit ? within ? "within rounding" : "hit" : "free");
    return right;
}

bool toi_case(json_object *object, const char **skipped)
{
    bool elementary = strcmp(member_text(object, "query"), "ccd_linear") == 0;
    return elementary ? elementary_case(object, skipped) : rigid_case(object, skipped);
}
