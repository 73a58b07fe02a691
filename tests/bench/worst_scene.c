#include "worst_scene.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define PI 3.14159265358979323846

/* ---- triangles ---- */

typedef struct soup {
    double *points;
    int32_t *corners;
    size_t point_count, triangle_count;
} soup;

static soup soup_of(void)
{
    const size_t most = 2 * WORST_TRIANGLES;
    return (soup){malloc(3 * most * sizeof(double)), malloc(3 * most * sizeof(int32_t)), 0, 0};
}

static int32_t add_point(soup *s, double x, double y, double z)
{
    double *p = s->points + 3 * s->point_count;
    p[0] = x, p[1] = y, p[2] = z;
    return (int32_t)s->point_count++;
}

static void add_triangle(soup *s, int32_t a, int32_t b, int32_t c)
{
    int32_t *t = s->corners + 3 * s->triangle_count++;
    t[0] = a, t[1] = b, t[2] = c;
}

static mesh *mesh_of(soup *s)
{
    mesh *m = NULL;
    mesh_status status = mesh_build(s->points, s->point_count, s->corners, s->triangle_count, &m);
    free(s->points);
    free(s->corners);
    if (status == MESH_OK) return m;
    fprintf(stderr, "a mesh cannot be built: %s\n", mesh_status_text(status));
    exit(1);
}

static shape shape_of_mesh(const mesh *m)
{
    return (shape){.type = SHAPE_MESH, .mesh = m, .hull = m->hull};
}

static void both_mesh(worst_scene *s, soup *from)
{
    s->meshes[0] = mesh_of(from);
    s->a = s->b = shape_of_mesh(s->meshes[0]);
}

/* A grid of n x n cells over [-1, 1]^2, bent by waves and bumps. */
static soup sheet(int n, double waves, double height)
{
    soup s = soup_of();
    for (int i = 0; i <= n; i++)
        for (int k = 0; k <= n; k++) {
            double x = 2.0 * i / n - 1, y = 2.0 * k / n - 1;
            add_point(&s, x, y, height * sin(waves * x) * cos(waves * y));
        }
    for (int i = 0; i < n; i++)
        for (int k = 0; k < n; k++) {
            int32_t a = i * (n + 1) + k, b = a + 1, c = a + n + 1, d = c + 1;
            add_triangle(&s, a, c, d);
            add_triangle(&s, a, d, b);
        }
    return s;
}

/* A closed grid around z: of the radius `bump` more where the waves are high. */
static soup globe(int n, double radius, double waves, double bump)
{
    soup s = soup_of();
    int32_t south = add_point(&s, 0, 0, -radius), north = add_point(&s, 0, 0, radius);
    for (int i = 1; i < n; i++)
        for (int k = 0; k < n; k++) {
            double t = PI * i / n - PI / 2, f = 2 * PI * k / n;
            double r = radius * (1 + bump * sin(waves * t) * cos(floor(waves) * f));
            add_point(&s, r * cos(t) * cos(f), r * cos(t) * sin(f), r * sin(t));
        }
    for (int i = 0; i < n; i++)
        for (int k = 0; k < n; k++) {
            int32_t next = (k + 1) % n, low = 2 + (i - 1) * n, high = 2 + i * n;
            if (i > 0) add_triangle(&s, low + k, low + next, i + 1 < n ? high + k : north);
            if (i + 1 < n) add_triangle(&s, i > 0 ? low + next : south, high + next, high + k);
        }
    return s;
}

static void add_box(soup *s, vec3 lo, vec3 hi)
{
    static const int32_t CORNERS[12][3] = {{0, 2, 3}, {0, 3, 1}, {4, 5, 7}, {4, 7, 6}, {0, 1, 5}, {0, 5, 4}, {2, 6, 7},
        {2, 7, 3}, {0, 4, 6}, {0, 6, 2}, {1, 3, 7}, {1, 7, 5}};
    int32_t first = (int32_t)s->point_count;
    for (int i = 0; i < 8; i++) add_point(s, i & 1 ? hi.x : lo.x, i & 2 ? hi.y : lo.y, i & 4 ? hi.z : lo.z);
    for (int i = 0; i < 12; i++) add_triangle(s, first + CORNERS[i][0], first + CORNERS[i][1], first + CORNERS[i][2]);
}

/* n bars or plates along y, one beside the other along x. */
static soup bars(int n, double thick, double height)
{
    soup s = soup_of();
    for (int i = 0; i < n; i++) {
        double x = 2 * (i + 0.5) / n - 1;
        add_box(&s, vec(x - thick / n, -1, -height), vec(x + thick / n, 1, height));
    }
    return s;
}

/* A band wound up: n turns of a spiral, upright. */
static soup spiral(int sides, double turns, double height)
{
    soup s = soup_of();
    for (int i = 0; i <= sides; i++) {
        double f = 2 * PI * turns * i / sides, r = 0.1 + 0.9 * i / sides;
        add_point(&s, r * cos(f), r * sin(f), -height);
        add_point(&s, r * cos(f), r * sin(f), height);
    }
    for (int32_t i = 0; i < sides; i++) {
        add_triangle(&s, 2 * i, 2 * i + 2, 2 * i + 3);
        add_triangle(&s, 2 * i, 2 * i + 3, 2 * i + 1);
    }
    return s;
}

/* n needles that meet in one point. */
static soup fan(int n, double width)
{
    soup s = soup_of();
    int32_t tip = add_point(&s, 0, 0, 0);
    for (int i = 0; i < n; i++) {
        double f = 2 * PI * i / n, g = f + width / n;
        int32_t a = add_point(&s, cos(f), sin(f), 1), b = add_point(&s, cos(g), sin(g), 1);
        add_triangle(&s, tip, a, b);
    }
    return s;
}

static int side_of_sheet(double size, int triangles_a_cell)
{
    return (int)sqrt(size * WORST_TRIANGLES / triangles_a_cell);
}

static double wave(double knob)
{
    return 1 + 200 * knob * knob;
}

/* 0 to 1e-9, ... 1 */
static double small(double knob)
{
    return knob < 0.05 ? 0 : pow(10, 10 * knob - 10);
}

static quat turned(double x, double y, double z)
{
    return quat_unit((quat){1, x, y, z});
}

static void build_sheets(const double *k, double size, worst_scene *s)
{
    soup it = sheet(side_of_sheet(size, 2), wave(k[0]), 0.2 * k[1]);
    both_mesh(s, &it);
}

static void build_globes(const double *k, double size, worst_scene *s)
{
    soup it = globe(side_of_sheet(size, 2), 1, wave(k[0]), 0.2 * k[1]);
    both_mesh(s, &it);
}

static void build_nested_globes(const double *k, double size, worst_scene *s)
{
    int n = side_of_sheet(0.5 * size, 2);
    soup outer = globe(n, 1, 3, 0), inner = globe(n, 1 - small(k[0]), 3, 0);
    s->meshes[0] = mesh_of(&outer);
    s->meshes[1] = mesh_of(&inner);
    s->a = shape_of_mesh(s->meshes[0]);
    s->b = shape_of_mesh(s->meshes[1]);
}

static void build_combs(const double *k, double size, worst_scene *s)
{
    soup it = bars(8 + (int)(size * (8 + 600 * k[0])), 0.1 + 0.8 * k[1], 0.5);
    both_mesh(s, &it);
}

static void build_gratings(const double *k, double size, worst_scene *s)
{
    soup it = bars(8 + (int)(size * (8 + 6000 * k[0])), 0.1 + 0.8 * k[1], 0.001);
    both_mesh(s, &it);
}

static void build_spirals(const double *k, double size, worst_scene *s)
{
    soup it = spiral((int)(size * WORST_TRIANGLES / 2), 1 + 200 * k[0], 0.01 + k[1]);
    both_mesh(s, &it);
}

static void build_fans(const double *k, double size, worst_scene *s)
{
    soup it = fan(8 + (int)(size * k[0] * WORST_TRIANGLES), 1e-3 + 6 * k[1]);
    both_mesh(s, &it);
}

/* Beside one another, a small way and turn away. */
static void place_near(const double *k, worst_scene *s)
{
    s->b_in_a.p = vec(small(k[2]), small(k[3]), small(k[4]));
    s->b_in_a.q = turned(0.1 * small(k[5]), 0.1 * small(k[6]), 0.1 * small(k[7]));
}

static void place_crossed(const double *k, worst_scene *s)
{
    place_near(k, s);
    s->b_in_a.q = quat_unit(quat_mul((quat){1, 0, 0, k[5]}, s->b_in_a.q));
}

/* The tips face each other. */
static void place_tips(const double *k, worst_scene *s)
{
    s->b_in_a.p = vec(0.1 * small(k[2]), 0.1 * small(k[3]), -small(k[4]));
    s->b_in_a.q = (quat){small(k[5]), 1, small(k[6]), 0};
    s->b_in_a.q = quat_unit(s->b_in_a.q);
}

static void place_deep(const double *k, worst_scene *s)
{
    s->b_in_a.p = vec(2 * k[2], k[3], k[4]);
    s->b_in_a.q = turned(k[5], k[6], k[7]);
}

/* ---- a mesh beside one convex shape ---- */

static void build_beside_box(const double *k, double size, worst_scene *s)
{
    build_sheets(k, size, s);
    s->a = (shape){.type = SHAPE_BOX, .half = {1, 1, 0.1}};
}

static void build_beside_cylinder(const double *k, double size, worst_scene *s)
{
    build_globes(k, size, s);
    s->a = (shape){.type = SHAPE_CYLINDER, .half = {0.9, 0.9, 0.9}};
}

static void build_beside_ellipsoid(const double *k, double size, worst_scene *s)
{
    build_globes(k, size, s);
    s->a = (shape){.type = SHAPE_ELLIPSOID, .half = {1, 1, 0.999}};
}

/* ---- hulls ---- */

typedef enum hull_kind { RINGS, DISCS, BALL, LATTICE, CONE, ROOF, LENS, HULL_KINDS } hull_kind;

static double scatter(uint64_t *state)
{
    *state = *state * 6364136223846793005u + 1442695040888963407u;
    return (double)(*state >> 11) * 0x1p-52 - 1;
}

static vec3 hull_point(hull_kind kind, size_t i, size_t n, double noise, uint64_t *state)
{
    double f = 2 * PI * (double)i / (double)n, x = scatter(state), y = scatter(state), way = i & 1 ? 1 : -1;
    size_t side = (size_t)sqrt((double)n), row = i / side, column = i % side;
    switch (kind) {
    case RINGS:
        return vec(cos(f), sin(f), way * (1 + noise * x));
    case DISCS:
        return i < n / 2 ? vec(cos(2 * f), sin(2 * f), way) : vec(0.7 * x, 0.7 * y, way * (1 + noise * x));
    case BALL: {
        double z = 1 - 2 * ((double)i + 0.5) / (double)n, r = sqrt(1 - z * z);
        return vec(r * cos(2.399963 * (double)i), r * sin(2.399963 * (double)i), z);
    }
    case LATTICE:
        return vec((double)row, (double)column, way * (double)side * (1 + noise * x));
    case CONE:
        return i == 0 ? vec(0, 0, 1) : vec(cos(f) * (1 + noise * x), sin(f), 0);
    case ROOF:
        return vec((double)i / (double)n, pow((double)i / (double)n, 2), way);
    default:
        return vec(x, y, (0.001 + noise) * (x * x + y * y));
    }
}

static void build_points(const double *k, double size, worst_scene *s, hull_kind kind)
{
    size_t n = 16 + (size_t)(size * (WORST_POINTS - 16));
    uint64_t state = 7;
    s->points = malloc(3 * n * sizeof(double));
    s->point_count = n;
    quat q = turned(k[2], k[3], k[4]);
    for (size_t i = 0; i < n; i++) {
        vec3 p = hull_point(kind, i, n, 1e-6 * small(k[1]), &state);
        if (k[5] > 0.1) p = quat_rotate(q, p);
        memcpy(s->points + 3 * i, &p, sizeof p);
    }
}

static void build_rings(const double *k, double size, worst_scene *s)
{
    build_points(k, size, s, RINGS);
}
static void build_discs(const double *k, double size, worst_scene *s)
{
    build_points(k, size, s, DISCS);
}
static void build_ball(const double *k, double size, worst_scene *s)
{
    build_points(k, size, s, BALL);
}
static void build_lattice(const double *k, double size, worst_scene *s)
{
    build_points(k, size, s, LATTICE);
}
static void build_cone(const double *k, double size, worst_scene *s)
{
    build_points(k, size, s, CONE);
}
static void build_roof(const double *k, double size, worst_scene *s)
{
    build_points(k, 0.5 * size, s, ROOF);
}
static void build_lens(const double *k, double size, worst_scene *s)
{
    build_points(k, size, s, LENS);
}

static hull *hull_of(worst_scene *s)
{
    hull *h = NULL;
    hull_status status = hull_build(s->points, s->point_count, 0, &h);
    free(s->points);
    s->points = NULL;
    if (status == HULL_OK) return h;
    fprintf(stderr, "a hull cannot be built: %s\n", hull_status_text(status));
    exit(1);
}

static void build_two_hulls(const double *k, double size, worst_scene *s)
{
    build_points(k, size, s, k[0] < 0.5 ? BALL : RINGS);
    s->hulls[0] = hull_of(s);
    s->a = s->b = (shape){.type = SHAPE_HULL, .hull = s->hulls[0]};
}

/* ---- compounds ---- */

static void both_compound(worst_scene *s, const shape *parts, const pose *at, size_t count)
{
    compound_status status = compound_build(parts, at, count, &s->compounds[0]);
    if (status != COMPOUND_OK) {
        fprintf(stderr, "a compound cannot be built: %s\n", compound_status_text(status));
        exit(1);
    }
    s->a = s->b = (shape){.type = SHAPE_COMPOUND, .compound = s->compounds[0]};
}

/* A cube of parts that overlap each other a little, or lie one upon the other. */
static void build_pile(double size, double loose, size_t most, shape part, worst_scene *s)
{
    size_t count = 8 + (size_t)(size * (double)(most - 8)), side = (size_t)ceil(cbrt((double)count));
    shape *parts = malloc(count * sizeof *parts);
    pose *at = malloc(count * sizeof *at);
    for (size_t i = 0; i < count; i++) {
        vec3 place = vec((double)(i % side), (double)(i / side % side), (double)(i / side / side));
        parts[i] = part;
        at[i] = (pose){vec_scale(place, 0.05 + 2 * loose), turned(0.3 * loose, 0, 0.1 * loose * (double)(i % 7))};
    }
    both_compound(s, parts, at, count);
    free(parts);
    free(at);
}

static void build_boxes(const double *k, double size, worst_scene *s)
{
    build_pile(size, k[0], 255, (shape){.type = SHAPE_BOX, .half = {0.5, 0.5, 0.1 + k[1]}}, s);
}
static void build_many_boxes(const double *k, double size, worst_scene *s)
{
    build_pile(size, k[0], COMPOUND_CHILDREN_MAX, (shape){.type = SHAPE_BOX, .half = {0.5, 0.5, 0.1 + k[1]}}, s);
}
static void build_cylinders(const double *k, double size, worst_scene *s)
{
    build_pile(size, k[0], 255, (shape){.type = SHAPE_CYLINDER, .half = {0.5, 0.5, 0.1 + k[1]}}, s);
}
static void build_hulls(const double *k, double size, worst_scene *s)
{
    build_points(k, 0.02, s, k[1] < 0.5 ? BALL : RINGS);
    s->hulls[0] = hull_of(s);
    build_pile(size, k[0], 255, (shape){.type = SHAPE_HULL, .hull = s->hulls[0]}, s);
}
static void build_compound_and_mesh(const double *k, double size, worst_scene *s)
{
    build_boxes(k, size, s);
    soup it = sheet(side_of_sheet(size, 2), 20, 0.2 * k[1]);
    s->meshes[0] = mesh_of(&it);
    s->a = shape_of_mesh(s->meshes[0]);
}

/* ---- impacts: each is one search over the whole motion ---- */

static void set_movers(worst_scene *s, pose start, vec3 linear, vec3 angular, double tolerance)
{
    s->move_a = (toi_mover){&s->a, POSE_IDENTITY, {.start = POSE_IDENTITY}};
    s->move_b = (toi_mover){&s->b, POSE_IDENTITY, {.start = start, .linear = linear, .angular = angular}};
    s->request = (toi_request){.span = 1, .tolerance = tolerance};
}

/* A comb slides in itself, with a gap on either side. */
static void build_sliding_combs(const double *k, double size, worst_scene *s)
{
    soup it = bars(4 + (int)(size * (4 + 100 * k[0])), 0.3 * k[1], 0.5);
    both_mesh(s, &it);
}
static void place_sliding_combs(const double *k, worst_scene *s)
{
    double plates = s->meshes[0]->triangle_count / 12.0;
    set_movers(s, (pose){vec(1 / plates, 0, 0.1 * k[3]), quat_unit((quat){1, 0, 0, 0})}, vec(0, 0.1 + k[2], 0),
        VEC_ZERO, 1e-6);
}

/* Two wavy sheets that lie on each other lift off. */
static void place_lifting(const double *k, worst_scene *s)
{
    set_movers(s, (pose){vec(0, 0, 1e-5 + 0.01 * small(k[3])), quat_unit((quat){1, 0, 0, 0})},
        vec(0.01 * small(k[4]), 0, 0.01 + k[2]), VEC_ZERO, 1e-6);
}
static void build_small_sheets(const double *k, double size, worst_scene *s)
{
    build_sheets(k, 0.05 * size, s);
}

/* Two meshes of 352 triangles turn very fast. */
static void build_turning(const double *k, double size, worst_scene *s)
{
    (void)size;
    soup it = globe(14, 1, wave(0.2 * k[0]), 0.2 * k[1]);
    both_mesh(s, &it);
}
static void place_turning(const double *k, worst_scene *s)
{
    double speed = 100 + 1750 * k[2];
    set_movers(s, (pose){vec(2.05 + 0.2 * k[3], 0, 0), quat_unit((quat){1, 0, 0, 0})}, vec(0.1 * k[4], 0, 0),
        vec(speed * k[5], speed * k[6], speed), 1e-6);
}

/* ---- the table ---- */

const worst_case WORST_CASES[] = {
    {"hull of two rings", WORST_BUILD, build_rings, NULL, {0, 0, 0.3, 0.2, 0.5}},
    {"hull of two discs", WORST_BUILD, build_discs, NULL, {0, 0, 0.3, 0.2, 0.5}},
    {"hull of a ball", WORST_BUILD, build_ball, NULL, {0, 0, 0.3, 0.2, 0.5}},
    {"hull of a lattice", WORST_BUILD, build_lattice, NULL, {0, 0, 0.3, 0.2, 0.5}},
    {"hull of a cone", WORST_BUILD, build_cone, NULL, {0, 0, 0.3, 0.2, 0.5}},
    {"hull of a roof", WORST_BUILD, build_roof, NULL, {0, 0, 0.3, 0.2, 0.5}},
    {"hull of a lens", WORST_BUILD, build_lens, NULL, {0, 0, 0.3, 0.2, 0.5}},
    {"two hulls", WORST_QUERY, build_two_hulls, place_near, {0.1, 0}},
    {"sheet on itself", WORST_QUERY, build_sheets, place_near, {0.3, 0.5}},
    {"sheet beside itself", WORST_QUERY, build_sheets, place_near, {0.3, 0.5, 0, 0, 0.8}},
    {"globe on itself", WORST_QUERY, build_globes, place_near, {0.1, 0}},
    {"globe within a globe", WORST_QUERY, build_nested_globes, place_near, {0.8, 0}},
    {"globe deep in a globe", WORST_QUERY, build_globes, place_deep, {0.1, 0.1, 0.3, 0.3, 0.3, 0.1, 0.2, 0.3}},
    {"comb on itself", WORST_QUERY, build_combs, place_near, {0.5, 0.5}},
    {"comb in a comb", WORST_QUERY, build_combs, place_near, {0.5, 0.3, 0.75}},
    {"gratings, crossed", WORST_QUERY, build_gratings, place_crossed, {0.9, 0.5, 0, 0, 0.7, 1}},
    {"spiral in a spiral", WORST_QUERY, build_spirals, place_near, {0.3, 0.3, 0.7}},
    {"needles, tip to tip", WORST_QUERY, build_fans, place_tips, {0.9, 0.5, 0, 0, 0.8}},
    {"box on a sheet", WORST_QUERY, build_beside_box, place_near, {0.1, 0.1}},
    {"cylinder in a globe", WORST_QUERY, build_beside_cylinder, place_near, {0.1, 0.1}},
    {"ellipsoid in a globe", WORST_QUERY, build_beside_ellipsoid, place_near, {0, 0}},
    {"255 boxes on themselves", WORST_QUERY, build_boxes, place_near, {0.4, 0.4}},
    {"4096 boxes on themselves", WORST_QUERY, build_many_boxes, place_near, {0.4, 0.4}},
    {"255 cylinders on themselves", WORST_QUERY, build_cylinders, place_near, {0.4, 0.4}},
    {"255 hulls on themselves", WORST_QUERY, build_hulls, place_near, {0.4, 0.1}},
    {"255 boxes in a sheet", WORST_QUERY, build_compound_and_mesh, place_near, {0.1, 0.4}},
    {"comb slides in itself", WORST_IMPACT, build_sliding_combs, place_sliding_combs, {0.2, 0.5, 0.5, 0}},
    {"wavy sheets lift off", WORST_IMPACT, build_small_sheets, place_lifting, {0.3, 0.5, 0.3, 0, 0}},
    {"globes turn by 1,850 rad", WORST_IMPACT, build_turning, place_turning, {0.3, 0.3, 1, 0.2, 0, 0.1, 0.1}},
};
const size_t WORST_CASE_COUNT = sizeof WORST_CASES / sizeof *WORST_CASES;

void worst_build(const worst_case *c, const double knob[WORST_KNOBS], double size, worst_scene *out)
{
    *out = (worst_scene){.b_in_a = POSE_IDENTITY};
    c->build(knob, size, out);
    worst_place(c, knob, out);
}

void worst_place(const worst_case *c, const double knob[WORST_KNOBS], worst_scene *s)
{
    if (c->place) c->place(knob, s);
}

void worst_free(worst_scene *s)
{
    free(s->points);
    for (int i = 0; i < 2; i++) {
        mesh_destroy(s->meshes[i]);
        compound_destroy(s->compounds[i]);
        hull_destroy(s->hulls[i]);
    }
}

size_t worst_elements(const worst_scene *s)
{
    size_t sum = s->point_count;
    const shape *of[2] = {&s->a, &s->b};
    for (int i = 0; i < 2 && !s->point_count; i++) {
        if (of[i]->mesh) sum += of[i]->mesh->triangle_count;
        if (of[i]->compound) sum += of[i]->compound->child_count;
        if (of[i]->type == SHAPE_HULL) sum += of[i]->hull->vertex_count;
    }
    return sum;
}
