/* case_json: from JSON to subjects and expectations. */
#include "case_json.h"

#include "mesh_hull.h"

#include <stdlib.h>
#include <string.h>

json_object *member(json_object *object, const char *names)
{
    char name[64];
    for (const char *at = names; *at; at += *at == '|') {
        size_t length = strcspn(at, "|");
        if (length >= sizeof name) abort();
        memcpy(name, at, length);
        name[length] = 0;
        at += length;
        json_object *found;
        if (json_object_object_get_ex(object, name, &found) && found) return found;
    }
    return NULL;
}

static bool is_number(json_object *v)
{
    return json_object_is_type(v, json_type_double) || json_object_is_type(v, json_type_int);
}

bool member_number(json_object *object, const char *names, double *out)
{
    json_object *found = member(object, names);
    if (!is_number(found)) return false;
    *out = json_object_get_double(found);
    return true;
}

static bool numbers(json_object *array, double *out, size_t count)
{
    if (!json_object_is_type(array, json_type_array) || json_object_array_length(array) != count) return false;
    for (size_t i = 0; i < count; i++) {
        if (!is_number(json_object_array_get_idx(array, i))) return false;
        out[i] = json_object_get_double(json_object_array_get_idx(array, i));
    }
    return true;
}

bool member_numbers(json_object *object, const char *names, double *out, size_t count)
{
    return numbers(member(object, names), out, count);
}

const char *member_text(json_object *object, const char *names)
{
    json_object *found = member(object, names);
    return json_object_is_type(found, json_type_string) ? json_object_get_string(found) : "";
}

/* Rows of `width` numbers, as one array of the caller's to free; NULL if it is anything else. */
static double *rows(json_object *array, size_t width, size_t *count)
{
    if (!json_object_is_type(array, json_type_array)) return NULL;
    *count = json_object_array_length(array);
    double *out = calloc(*count * width + 1, sizeof *out);
    if (!out) abort();
    for (size_t i = 0; i < *count; i++)
        if (!numbers(json_object_array_get_idx(array, i), out + i * width, width)) {
            free(out);
            return NULL;
        }
    return out;
}

static const char *from_mesh(subject *s, json_object *object, const double *vertices, size_t vertex_count)
{
    size_t count = 0;
    double *triangles = rows(member(object, "triangles|faces"), 3, &count);
    bool solid = triangles && mesh_is_convex_solid(vertices, vertex_count, triangles, count);
    free(triangles);
    return solid ? subject_from_points(s, vertices, vertex_count, 0) : "mesh: issue 5";
}

/* Hulls, triangles, segments and meshes: whatever is given by its points. */
static const char *from_points(subject *s, json_object *object, const char *type)
{
    if (member(object, "generator")) return mesh_from_text(s, member_text(object, "generator"));
    size_t count = 0;
    double radius = 0, *points = rows(member(object, "points|vertices"), 3, &count);
    if (!points || count == 0) {
        free(points);
        return "no points";
    }
    (void)member_number(object, "rounding|radius|r", &radius);
    const char *why =
        strcmp(type, "mesh") == 0 ? from_mesh(s, object, points, count) : subject_from_points(s, points, count, radius);
    free(points);
    return why;
}

/* Half the length of a capsule's, cylinder's or cone's axis. */
static bool half_length(json_object *object, double *out)
{
    if (member_number(object, "half_len|half_length|half_height", out)) return true;
    if (!member_number(object, "length|height", out)) return false;
    *out /= 2;
    return true;
}

static bool box_halves(json_object *object, double half[3])
{
    if (member_numbers(object, "half|half_extents", half, 3)) return true;
    if (!member_numbers(object, "size", half, 3)) return false;
    for (int i = 0; i < 3; i++) half[i] /= 2;
    return true;
}

static const char *read_shape(shape *s, json_object *object, const char *type)
{
    static const struct {
        const char *name;
        shape_type type;
    } kinds[] = {{"sphere", SHAPE_SPHERE}, {"capsule", SHAPE_CAPSULE}, {"box", SHAPE_BOX}, {"cylinder", SHAPE_CYLINDER},
        {"cone", SHAPE_CONE}, {"ellipsoid", SHAPE_ELLIPSOID}, {"halfspace", SHAPE_HALFSPACE},
        {"plane", SHAPE_HALFSPACE}};
    size_t kind = 0, kind_count = sizeof kinds / sizeof *kinds;
    while (kind < kind_count && strcmp(kinds[kind].name, type) != 0) kind++;
    if (kind == kind_count) return "unknown shape";
    *s = (shape){.type = kinds[kind].type};
    double half[3] = {0, 0, 0}, radius = 0, length = 0;
    bool has_radius = member_number(object, "radius|r", &radius), has_length = half_length(object, &length),
         good = true;
    switch (s->type) {
    case SHAPE_SPHERE:
        good = has_radius;
        s->radius = radius;
        break;
    case SHAPE_CAPSULE:
        good = has_radius && has_length;
        s->radius = radius;
        s->half.z = length;
        break;
    case SHAPE_CYLINDER:
    case SHAPE_CONE:
        good = has_radius && has_length;
        s->half = vec(radius, radius, length);
        break;
    case SHAPE_BOX:
        good = box_halves(object, half);
        s->half = vec(half[0], half[1], half[2]);
        break;
    case SHAPE_ELLIPSOID:
        good = member_numbers(object, "radii|semi_axes|half", half, 3);
        s->half = vec(half[0], half[1], half[2]);
        break;
    default:
        break;
    }
    if (s->type != SHAPE_SPHERE && s->type != SHAPE_CAPSULE) (void)member_number(object, "rounding", &s->radius);
    return good ? NULL : "sizes missing";
}

/* The matrix whose third column is n (unit), right-handed. */
static void frame_of_normal(const double n[3], double r[9])
{
    int least = fabs(n[0]) <= fabs(n[1]) && fabs(n[0]) <= fabs(n[2]) ? 0 : fabs(n[1]) <= fabs(n[2]) ? 1 : 2;
    vec3 z = vec_unit(vec(n[0], n[1], n[2]));
    vec3 x = vec_unit(vec_cross(vec(least == 0, least == 1, least == 2), z)), y = vec_cross(z, x);
    const double out[9] = {x.x, y.x, z.x, x.y, y.y, z.y, x.z, y.z, z.z};
    memcpy(r, out, sizeof out);
}

/* Where the shape's own frame (axis z, plane z = 0) lies in the frame that the source gives it. */
static bool local_frame(json_object *shape_object, double r[9], double t[3])
{
    static const double along_z[9] = {1, 0, 0, 0, 1, 0, 0, 0, 1}, along_x[9] = {0, 0, 1, 1, 0, 0, 0, 1, 0},
                        along_y[9] = {0, 1, 0, 0, 0, 1, 1, 0, 0};
    const char *axis = member_text(shape_object, "axis");
    memcpy(r, *axis == 'x' ? along_x : *axis == 'y' ? along_y : along_z, sizeof along_z);
    memset(t, 0, 3 * sizeof *t);
    double normal[3], offset = 0;
    (void)member_numbers(shape_object, "offset", t, 3);
    if (member_numbers(shape_object, "normal", normal, 3)) {
        if (normal[0] != 0 || normal[1] != 0 || normal[2] <= 0) frame_of_normal(normal, r);
        (void)member_number(shape_object, "offset", &offset);
        for (int i = 0; i < 3; i++) t[i] = offset * normal[i];
    }
    return !numbers_equal(r, along_z, 9) || t[0] != 0 || t[1] != 0 || t[2] != 0;
}

/* outer = outer * inner, for rotations and positions. */
static void compose(double r[9], double t[3], const double inner_r[9], const double inner_t[3])
{
    double product[9];
    for (int row = 0; row < 3; row++) {
        const double *o = r + 3 * row;
        for (int column = 0; column < 3; column++)
            product[3 * row + column] =
                o[0] * inner_r[column] + o[1] * inner_r[3 + column] + o[2] * inner_r[6 + column];
        t[row] += o[0] * inner_t[0] + o[1] * inner_t[1] + o[2] * inner_t[2];
    }
    memcpy(r, product, sizeof product);
}

static void matrix_of(quat q, double r[9])
{
    mat3 m = quat_matrix(q);
    const double out[9] = {m.x.x, m.y.x, m.z.x, m.x.y, m.y.y, m.z.y, m.x.z, m.y.z, m.z.z};
    memcpy(r, out, sizeof out);
}

static const char *place(subject *s, json_object *shape_object, json_object *pose_object)
{
    double r[9], t[3], q[4], local_r[9], local_t[3];
    bool moved = local_frame(shape_object, local_r, local_t);
    if (!member_numbers(pose_object, "t|p", t, 3)) return "pose without position";
    if (member_numbers(pose_object, "q_wxyz|q", q, 4)) {
        quat given = {q[0], q[1], q[2], q[3]};
        if (fabs(quat_norm2(given) - 1) > 0x1p-51) given = quat_unit(given);
        if (!moved) {
            subject_place(s, (pose){vec(t[0], t[1], t[2]), given});
            return NULL;
        }
        matrix_of(given, r);
    } else if (!member_numbers(pose_object, "R", r, 9)) {
        return "pose without rotation";
    }
    if (moved) compose(r, t, local_r, local_t);
    subject_place_matrix(s, r, vec(t[0], t[1], t[2]));
    return NULL;
}

const char *subject_from_json(subject *s, json_object *shape_object, json_object *pose_object)
{
    const char *type = member_text(shape_object, "type"), *why;
    static const char *const by_points[] = {"hull", "convex", "mesh", "triangle", "segment", "point", "points"};
    bool has_points = false;
    for (size_t i = 0; i < sizeof by_points / sizeof *by_points; i++) has_points |= strcmp(type, by_points[i]) == 0;
    if (has_points) {
        why = from_points(s, shape_object, type);
    } else {
        shape core;
        why = read_shape(&core, shape_object, type);
        if (!why) subject_from_shape(s, core);
    }
    if (why) return why;
    if (pose_object && (why = place(s, shape_object, pose_object))) subject_free(s);
    return why;
}

static void add_normal(expectation *e, const double n[3], double sign)
{
    if (e->normal_count == EXPECTED_NORMALS_MAX) return; /* six are the most that a case can have: a box's faces */
    for (int i = 0; i < 3; i++) e->normals[e->normal_count][i] = sign * n[i];
    e->normal_count++;
}

static void read_normals(expectation *e, json_object *object, const subject *a)
{
    double n[3];
    if (member_numbers(object, "normal_A_to_B|normal", n, 3)) add_normal(e, n, 1);
    if (member_numbers(object, "normal_world", n, 3)) add_normal(e, n, 1), add_normal(e, n, -1);
    if (member_numbers(object, "normal_from_box", n, 3)) add_normal(e, n, a->shape.type == SHAPE_BOX ? 1 : -1);
    json_object *any = member(object, "normal_any_of");
    if (!json_object_is_type(any, json_type_array)) return; /* or a sentence, which the certificate covers */
    for (size_t i = 0; i < json_object_array_length(any); i++)
        if (numbers(json_object_array_get_idx(any, i), n, 3)) add_normal(e, n, 1);
}

static expected_state read_state(json_object *object, double distance, bool measured)
{
    const char *text = member_text(object, "state");
    json_object *colliding = member(object, "colliding");
    if (strcmp(text, "touching") == 0 || strncmp(member_text(object, "colliding"), "touching", 8) == 0)
        return STATE_TOUCHING;
    if (strcmp(text, "separated") == 0) return STATE_APART;
    if (strcmp(text, "overlapping") == 0) return STATE_OVERLAPPING;
    if (json_object_is_type(colliding, json_type_boolean))
        return json_object_get_boolean(colliding) ? STATE_OVERLAPPING : STATE_APART;
    if (member(object, "as_solids_colliding")) return STATE_OVERLAPPING;
    return !measured || distance == 0 ? STATE_ANY : distance > 0 ? STATE_APART : STATE_OVERLAPPING;
}

static double body_size(const subject *s)
{
    return s->shape.type == SHAPE_HALFSPACE ? INFINITY : shape_reach(&s->shape);
}

void expectation_from_json(expectation *e, json_object *object, const subject *a, const subject *b)
{
    json_object *said = member(object, "expected|expect");
    double depth, tol_rel, smaller = fmin(body_size(a), body_size(b)), larger = fmax(body_size(a), body_size(b));
    *e = (expectation){.measured = false};
    e->measured = member_number(said, "signed_distance|distance", &e->distance);
    if (member_number(said, "depth", &depth)) e->measured = true, e->distance = -depth;
    e->state = read_state(said, e->distance, e->measured);
    /* without a tolerance of its own the value is exact up to its printing, or good to 1e-12 for curved shapes */
    if (!isfinite(larger)) larger = smaller;
    e->tolerance = 1e-15 * fabs(e->distance) + 1e-15 * larger;
    if (strncmp(member_text(said, "how"), "minimised", 9) == 0) e->tolerance = 1e-12 * fmax(larger, fabs(e->distance));
    if (member_number(object, "tol_rel", &tol_rel)) e->tolerance = tol_rel * fmax(smaller, fabs(e->distance));
    if (e->state == STATE_TOUCHING) e->tolerance = fmax(e->tolerance, 1e-12 * smaller);
    read_normals(e, said, a);
}
