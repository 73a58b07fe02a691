#include "elementary_sets.h"
#include "base/prng.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

uint64_t elementary_random(uint64_t *state)
{
    return prng_bits(state);
}

static double uniform(uint64_t *s) /* -1 .. 1 */
{
    return (double)(elementary_random(s) >> 11) * 0x1p-52 - 1;
}

static uint64_t below(uint64_t *s, uint64_t n)
{
    return elementary_random(s) % n;
}

static vec3 in_cube(uint64_t *s, double size)
{
    double x = size * uniform(s), y = size * uniform(s);
    return vec(x, y, size * uniform(s));
}

static vec3 on_grid(uint64_t *s, int reach)
{
    uint64_t n = 2 * (uint64_t)reach + 1;
    double x = (double)below(s, n) - reach, y = (double)below(s, n) - reach;
    return vec(x, y, (double)below(s, n) - reach);
}

static vec3 *point_of(elementary_query *q, uint64_t i)
{
    return i < 4 ? &q->start[i] : &q->end[i - 4];
}

static void fill(elementary_query *q, uint64_t *s, double size)
{
    for (uint64_t i = 0; i < 8; i++) *point_of(q, i) = in_cube(s, size);
}

static void fill_grid(elementary_query *q, uint64_t *s, int reach)
{
    for (uint64_t i = 0; i < 8; i++) *point_of(q, i) = on_grid(s, reach);
}

/* Moves the first point (VF) or the first edge (EE) so that at t it is where weights u, v put the contact; all numbers
 * are multiples of small powers of two, so that the contact is often exact. */
static void make_contact(elementary_query *q, double t, double u, double v)
{
    vec3 at[4];
    for (int i = 0; i < 4; i++) at[i] = vec_add(vec_scale(q->start[i], 1 - t), vec_scale(q->end[i], t));
    if (q->kind == ELEMENTARY_VF) {
        vec3 foot = vec_madd(vec_madd(at[1], u, vec_sub(at[2], at[1])), v, vec_sub(at[3], at[1]));
        vec3 by = vec_sub(foot, at[0]);
        q->start[0] = vec_add(q->start[0], by), q->end[0] = vec_add(q->end[0], by);
    } else {
        vec3 a = vec_madd(at[0], u, vec_sub(at[1], at[0])), b = vec_madd(at[2], v, vec_sub(at[3], at[2]));
        vec3 by = vec_sub(b, a);
        for (int i = 0; i < 2; i++) q->start[i] = vec_add(q->start[i], by), q->end[i] = vec_add(q->end[i], by);
    }
}

static double eighths(uint64_t *s, uint64_t most)
{
    return (double)below(s, most + 1) / 8;
}

static void build_contact(elementary_query *q, uint64_t *s)
{
    for (uint64_t i = 0; i < 8; i++) *point_of(q, i) = vec_scale(on_grid(s, 64), 0x1p-6);
    double u = eighths(s, q->kind == ELEMENTARY_VF ? 4 : 8), v = eighths(s, q->kind == ELEMENTARY_VF ? 4 : 8);
    make_contact(q, eighths(s, 8), u, v);
}

static void move_a_bit(elementary_query *q, uint64_t *s)
{
    vec3 *p = point_of(q, below(s, 8));
    double *x = below(s, 3) == 0 ? &p->x : below(s, 2) ? &p->y : &p->z;
    *x = nextafter(*x, below(s, 2) ? INFINITY : -INFINITY);
}

static void flatten(elementary_query *q, uint64_t *s)
{
    int mix = (int)below(s, 3); /* z = 0, z = x, z = x + 2 y, exactly; at both ends the same plane, or its copy */
    double shift = (double)below(s, 3) - 1;
    for (uint64_t i = 0; i < 8; i++) {
        vec3 *p = point_of(q, i);
        *p = vec_scale(on_grid(s, below(s, 2) ? 3 : 512), 0x1p-6);
        p->z = (mix > 0) * p->x + (mix > 1) * 2 * p->y + (i >= 4) * shift;
    }
}

/* All differences in the plane z = (linear in t) x ... at rest in x: the plane turns about the y axis. */
static void turn_plane(elementary_query *q, uint64_t *s)
{
    double slope[2] = {(double)below(s, 5) - 2, (double)below(s, 5) - 2};
    for (int i = 0; i < 4; i++) {
        q->start[i] = on_grid(s, 3), q->end[i] = on_grid(s, 3);
        q->end[i].x = q->start[i].x;
        q->start[i].z = slope[0] * q->start[i].x, q->end[i].z = slope[1] * q->end[i].x;
    }
}

static void make_sliver(elementary_query *q, uint64_t *s)
{
    double thin = ldexp(1, -(int)below(s, 50));
    fill(q, s, 1);
    vec3 along0 = in_cube(s, 1), along1 = below(s, 2) ? along0 : in_cube(s, 1);
    int first = q->kind == ELEMENTARY_VF ? 1 : 0;
    for (int i = first; i < 4; i++) {
        double k = uniform(s);
        vec3 side = vec_scale(in_cube(s, 1), thin);
        q->start[i] = vec_add(vec_scale(along0, k), side);
        q->end[i] = vec_add(vec_scale(along1, k), vec_add(side, vec_scale(in_cube(s, 1), thin)));
    }
    if (below(s, 2)) make_contact(q, eighths(s, 8), 0.25, 0.5);
}

static void shrink(elementary_query *q, uint64_t *s)
{
    if (below(s, 2))
        fill_grid(q, s, 2);
    else
        fill(q, s, 1);
    uint64_t ends = below(s, 3) + 1; /* at the start, at the end, at both */
    int from = q->kind == ELEMENTARY_VF ? 1 : 2 * (int)below(s, 2), to = from + 1;
    if (q->kind == ELEMENTARY_VF && below(s, 3) == 0) to = 3;
    for (int i = from + 1; i <= to; i++) {
        if (ends & 1) q->start[i] = q->start[from];
        if (ends & 2) q->end[i] = q->end[from];
    }
    if (below(s, 2)) make_contact(q, eighths(s, 8), 0.25, 0.5);
}

static void coincide(elementary_query *q, uint64_t *s)
{
    if (below(s, 2))
        fill_grid(q, s, 3);
    else
        fill(q, s, 1);
    int a = q->kind == ELEMENTARY_VF ? 0 : (int)below(s, 2), b = 3;
    switch (below(s, 3)) {
    case 0:
        q->end[b] = q->end[a];
        break;
    case 1:
        q->start[b] = q->start[a];
        break;
    default:
        make_contact(q, eighths(s, 8), q->kind == ELEMENTARY_VF ? 0 : a, 1);
        break;
    }
}

static void shift_far(elementary_query *q, uint64_t *s)
{
    build_contact(q, s);
    vec3 by = vec_scale(in_cube(s, 1), ldexp(1, 20 + (int)below(s, 21)));
    for (uint64_t i = 0; i < 8; i++) *point_of(q, i) = vec_add(*point_of(q, i), by);
}

static void drape(elementary_query *q, uint64_t *s)
{
    int first = q->kind == ELEMENTARY_VF ? 1 : 2; /* of the second sheet's points */
    vec3 drift = in_cube(s, 0.1);
    double apart = 0.02 + 0.1 * fabs(uniform(s));
    for (int i = 0; i < 4; i++) {
        vec3 p = in_cube(s, 0.7);
        p.z = 0.03 * p.z + (i < first ? apart : 0);
        q->start[i] = p;
        q->end[i] = vec_add(p, vec_add(in_cube(s, 0.01), i < first ? drift : VEC_ZERO));
    }
}

/* A contact, and then the first point or edge moved away from it, across the other's plane or along the common normal,
 * with the motion between both ends turned into that plane. */
static void pass_by(elementary_query *q, uint64_t *s)
{
    fill(q, s, 1);
    int first = q->kind == ELEMENTARY_VF ? 1 : 2;
    for (int i = first; i < 4; i++) q->end[i] = vec_add(q->start[i], in_cube(s, 0.01));
    vec3 n = q->kind == ELEMENTARY_VF ? vec_cross(vec_sub(q->start[2], q->start[1]), vec_sub(q->start[3], q->start[1]))
                                      : vec_cross(vec_sub(q->start[1], q->start[0]), vec_sub(q->start[3], q->start[2]));
    n = vec_unit(n);
    for (int i = 0; i < first; i++) {
        vec3 motion = in_cube(s, 1);
        motion = vec_madd(motion, -vec_dot(motion, n), n);
        q->end[i] = vec_add(q->start[i], i == 0 ? motion : vec_sub(q->end[0], q->start[0]));
    }
    make_contact(q, 0.5, 0.3, 0.3);
    double distance = pow(10, -3 - (double)below(s, 7)) + 0.006;
    for (int i = 0; i < first; i++)
        q->start[i] = vec_madd(q->start[i], distance, n), q->end[i] = vec_madd(q->end[i], distance, n);
}

static vec3 along_axis(uint64_t axis, double length)
{
    return vec(axis == 0 ? length : 0, axis == 1 ? length : 0, axis == 2 ? length : 0);
}

static double eighths_either_way(uint64_t *s, uint64_t most)
{
    return eighths(s, 2 * most) - (double)most / 8;
}

/* A corner of a lattice, and from there along an axis, or an arm of a right angle; or nowhere. */
static void draw_part(elementary_query *q, uint64_t *s, int from, int to)
{
    uint64_t axis = below(s, 3), kind = below(s, 8);
    for (int i = from; i < to; i++) {
        q->start[i] = i == from ? vec_scale(on_grid(s, 8), 0.125) : q->start[from];
        if (i == from || kind == 0) continue;
        uint64_t along = kind == 1 ? axis : (axis + (uint64_t)(i - from)) % 3; /* 1: all in a line */
        q->start[i] = vec_add(q->start[i], along_axis(along, eighths_either_way(s, 8)));
        if (kind == 2) q->start[i] = vec_add(q->start[i], along_axis(below(s, 3), eighths_either_way(s, 8)));
    }
}

static vec3 draw_step(uint64_t *s)
{
    static const double FAST[] = {1, 1, 1, 64};
    if (below(s, 4) == 0) return VEC_ZERO;
    vec3 step = below(s, 3) ? along_axis(below(s, 3), eighths_either_way(s, 16)) : vec_scale(on_grid(s, 8), 0.125);
    return vec_scale(step, FAST[below(s, 4)]);
}

static void disturb(elementary_query *q, uint64_t *s, int first)
{
    static const double NOISE[] = {1e-15, 1e-13, 1e-11, 1e-9, 1e-7, 1e-5, 1e-3};
    vec3 by = along_axis(below(s, 3), NOISE[below(s, 7)] * (below(s, 2) ? 1 : -1));
    bool only_at_the_end = below(s, 2);
    for (int i = 0; i < first; i++) {
        if (!only_at_the_end) q->start[i] = vec_add(q->start[i], by);
        q->end[i] = vec_add(q->end[i], by);
    }
}

static void go_along_axes(elementary_query *q, uint64_t *s)
{
    int first = q->kind == ELEMENTARY_VF ? 1 : 2; /* of the second part's points */
    draw_part(q, s, 0, first);
    draw_part(q, s, first, 4);
    vec3 a = draw_step(s), b = below(s, 3) ? VEC_ZERO : below(s, 2) ? a : draw_step(s);
    for (int i = 0; i < 4; i++) q->end[i] = vec_add(q->start[i], i < first ? a : b);
    if (below(s, 6) == 0) q->end[below(s, 4)] = vec_scale(on_grid(s, 8), 0.125); /* it bends or turns */
    static const double WHEN[] = {0, 0, 0.5, 1, 1};
    double u = eighths(s, q->kind == ELEMENTARY_VF ? 4 : 8), v = eighths(s, q->kind == ELEMENTARY_VF ? 4 : 8);
    if (below(s, 3)) make_contact(q, WHEN[below(s, 5)], below(s, 2) ? u : 0, below(s, 2) ? v : 0);
    if (below(s, 3) == 0) disturb(q, s, first);
}

const char *elementary_class_name(elementary_class c)
{
    static const char *const NAMES[ELEMENTARY_CLASSES] = {"random", "grid", "built", "coplanar", "turning plane",
        "sliver", "zero length", "coincident", "far", "cloth", "near miss", "lattice"};
    return NAMES[c];
}

elementary_query elementary_make(elementary_class c, uint64_t n)
{
    elementary_query q = {.kind = n % 2 ? ELEMENTARY_EE : ELEMENTARY_VF};
    uint64_t state = ((uint64_t)c << 48) + n, *s = &state;
    switch (c) {
    case ELEMENTARY_GRID:
        fill_grid(&q, s, below(s, 2) ? 1 : 3);
        break;
    case ELEMENTARY_BUILT:
        build_contact(&q, s);
        if (below(s, 2)) move_a_bit(&q, s);
        break;
    case ELEMENTARY_COPLANAR:
        flatten(&q, s);
        break;
    case ELEMENTARY_TURNING:
        turn_plane(&q, s);
        break;
    case ELEMENTARY_SLIVER:
        make_sliver(&q, s);
        break;
    case ELEMENTARY_ZERO_LENGTH:
        shrink(&q, s);
        break;
    case ELEMENTARY_COINCIDENT:
        coincide(&q, s);
        break;
    case ELEMENTARY_FAR:
        shift_far(&q, s);
        break;
    case ELEMENTARY_CLOTH:
        drape(&q, s);
        break;
    case ELEMENTARY_NEAR_MISS:
        pass_by(&q, s);
        break;
    case ELEMENTARY_LATTICE:
        go_along_axes(&q, s);
        break;
    default:
        fill(&q, s, 1);
        break;
    }
    return q;
}

/* ---- the shared files ---- */

static void read_line(char *line, elementary_case *c)
{
    char *rest = line, *field = strsep(&rest, ",");
    double x[24];
    c->query.kind = strcmp(field, "VF") == 0 ? ELEMENTARY_VF : ELEMENTARY_EE;
    c->truth.touches = strcmp(strsep(&rest, ","), "1") == 0;
    c->truth.lo = strtod(strsep(&rest, ","), NULL);
    c->truth.hi = strtod(strsep(&rest, ","), NULL);
    (void)strsep(&rest, ","); /* the source */
    for (int i = 0; i < 24; i++) {
        field = rest ? strsep(&rest, ",") : NULL;
        if (!field) abort();
        x[i] = strtod(field, NULL);
    }
    for (int i = 0; i < 8; i++) *point_of(&c->query, (uint64_t)i) = vec(x[3 * i], x[3 * i + 1], x[3 * i + 2]);
}

elementary_case *elementary_read(const char *name, size_t *count)
{
    const char *folder = getenv("COLLIDED_SHARED");
    char path[4096], line[4096];
    (void)snprintf(path, sizeof path, "%s/cases/ccd/%s", folder ? folder : COLLIDED_SHARED, name);
    FILE *file = fopen(path, "r");
    *count = 0;
    if (!file) return NULL;
    size_t capacity = 4096;
    elementary_case *cases = calloc(capacity, sizeof *cases);
    while (cases && fgets(line, sizeof line, file)) {
        if (line[0] != 'V' && line[0] != 'E') continue; /* a comment */
        if (*count == capacity) {
            capacity *= 2;
            cases = realloc(cases, capacity * sizeof *cases);
            if (!cases) abort();
        }
        read_line(line, &cases[(*count)++]);
    }
    (void)fclose(file);
    return cases;
}
