/* machines: how they are made. */
#include "machines.h"

#include "geom/compound.h"

#include <stdlib.h>

/* ---- solids ---- */

static soup nothing(void)
{
    return (soup){calloc(3 * SOUP_MAX, sizeof(double)), 0, calloc(3 * SOUP_MAX, sizeof(int32_t)), 0};
}

static int32_t point(soup *s, double x, double y, double z)
{
    if (s->point_count >= SOUP_MAX) abort();
    double *to = s->points + 3 * s->point_count;
    to[0] = x, to[1] = y, to[2] = z;
    return (int32_t)s->point_count++;
}

static void triangle(soup *s, int32_t a, int32_t b, int32_t c)
{
    if (s->triangle_count >= SOUP_MAX) abort();
    int32_t *to = s->corners + 3 * s->triangle_count++;
    to[0] = a, to[1] = b, to[2] = c;
}

static void quad(soup *s, int32_t a, int32_t b, int32_t c, int32_t d)
{
    triangle(s, a, b, c);
    triangle(s, a, c, d);
}

static void add_box(soup *s, vec3 at, vec3 half)
{
    soup box = soup_box(half.x, half.y, half.z, 1);
    soup_add(s, &box, at);
    soup_free(&box);
}

/* A prism over a closed outline about the z axis that is seen whole from it: from z = 0 to `height`. */
static void add_prism(soup *s, const double (*outline)[2], int n, double z, double height)
{
    int32_t low = point(s, 0, 0, z), high = point(s, 0, 0, z + height), first = (int32_t)s->point_count;
    for (int k = 0; k < n; k++) {
        point(s, outline[k][0], outline[k][1], z);
        point(s, outline[k][0], outline[k][1], z + height);
    }
    for (int k = 0; k < n; k++) {
        int32_t a = first + 2 * k, b = first + 2 * ((k + 1) % n);
        quad(s, a, b, b + 1, a + 1);
        triangle(s, low, b, a);
        triangle(s, high, a + 1, b + 1);
    }
}

enum { SIDES_MAX = 512 };

static void add_rod(soup *s, double radius, int sides, double z, double height)
{
    double outline[SIDES_MAX][2];
    for (int k = 0; k < sides; k++) {
        outline[k][0] = radius * cos(2 * M_PI * k / sides);
        outline[k][1] = radius * sin(2 * M_PI * k / sides);
    }
    add_prism(s, outline, sides, z, height);
}

/* A tube about z, whose hole holds a circle of radius `inner`. */
static void add_tube(soup *s, double inner, double outer, int sides, double z, double height)
{
    int32_t first = (int32_t)s->point_count;
    for (int k = 0; k < sides; k++) {
        double c = cos(2 * M_PI * k / sides), d = sin(2 * M_PI * k / sides), in = inner / cos(M_PI / sides);
        point(s, in * c, in * d, z);
        point(s, in * c, in * d, z + height);
        point(s, outer * c, outer * d, z);
        point(s, outer * c, outer * d, z + height);
    }
    for (int k = 0; k < sides; k++) {
        int32_t a = first + 4 * k, b = first + 4 * ((k + 1) % sides);
        quad(s, a, a + 1, b + 1, b);
        quad(s, a + 2, b + 2, b + 3, a + 3);
        quad(s, a, b, b + 2, a + 2);
        quad(s, a + 1, a + 3, b + 3, b + 1);
    }
}

/* Teeth about z: each a trapezium. */
static void add_gear(soup *s, int teeth, double root, double tip, double share, double z, double height)
{
    static double outline[SIDES_MAX][2];
    int n = 0;
    for (int k = 0; k < teeth; k++)
        for (int c = 0; c < 4; c++) {
            static const double SIDE[4] = {-1, -0.5, 0.5, 1};
            double angle = 2 * M_PI * (k + SIDE[c] * share) / teeth, r = c == 1 || c == 2 ? tip : root;
            outline[n][0] = r * cos(angle);
            outline[n++][1] = r * sin(angle);
        }
    add_prism(s, (const double(*)[2])outline, n, z, height);
}

static soup wavy(int n, double height)
{
    soup s = nothing();
    for (int i = 0; i <= n; i++)
        for (int k = 0; k <= n; k++) {
            double x = (double)i / n, y = (double)k / n;
            point(&s, x, y, height * sin(12 * x) * cos(9 * y));
        }
    for (int i = 0; i < n; i++)
        for (int k = 0; k < n; k++) {
            int32_t at = i * (n + 1) + k;
            quad(&s, at, at + n + 1, at + n + 2, at + 1);
        }
    return s;
}

/* Plates across x, one each 10 mm. */
static soup comb(int plates, double from, double half)
{
    soup s = nothing();
    for (int k = 0; k < plates; k++) add_box(&s, vec(from + 0.01 * k, 0, 0), vec(half, 0.1, 0.05));
    return s;
}

static compound *comb_of_boxes(int plates, double from, double half)
{
    shape *boxes = calloc((size_t)plates, sizeof *boxes);
    pose *at = calloc((size_t)plates, sizeof *at);
    compound *c = NULL;
    for (int k = 0; k < plates; k++) {
        boxes[k] = (shape){.type = SHAPE_BOX, .half = {half, 0.1, 0.05}};
        at[k] = (pose){{from + 0.01 * k, 0, 0}, POSE_IDENTITY.q};
    }
    if (compound_build(boxes, at, (size_t)plates, &c) != COMPOUND_OK) abort();
    free(boxes);
    free(at);
    return c;
}

/* Of plates: an open box, whose +y side is open, of inner half extents h. */
static soup tray(vec3 h, double wall)
{
    soup s = nothing();
    add_box(&s, vec(0, -h.y - wall / 2, 0), vec(h.x + wall, wall / 2, h.z + wall));
    for (int side = -1; side <= 1; side += 2) {
        add_box(&s, vec(side * (h.x + wall / 2), 0, 0), vec(wall / 2, h.y, h.z + wall));
        add_box(&s, vec(0, 0, side * (h.z + wall / 2)), vec(h.x, h.y, wall / 2));
    }
    return s;
}

/* A rail along y that is a T seen along it, and the guide about it that leaves `gap` all round. */
static soup rail(double length)
{
    soup s = nothing();
    add_box(&s, vec(0, 0, 0), vec(0.005, length, 0.01));
    add_box(&s, vec(0, 0, 0.015), vec(0.02, length, 0.005));
    return s;
}

static soup guide(double length, double gap)
{
    soup s = nothing();
    for (int side = -1; side <= 1; side += 2) {
        add_box(&s, vec(side * (0.005 + gap + 0.01), 0, 0.01 - gap - 0.005), vec(0.01, length, 0.005));
        add_box(&s, vec(side * (0.02 + gap + 0.005), 0, 0.015), vec(0.005, length, 0.02));
    }
    add_box(&s, vec(0, 0, 0.02 + gap + 0.005), vec(0.02, length, 0.005));
    return s;
}

/* ---- scenes ---- */

static void of_mesh(machine *m, int which, soup s)
{
    m->meshes[which] = soup_mesh(&s);
    m->shapes[which] = mesh_shape(m->meshes[which], 0);
    soup_free(&s);
}

static void of_compound(machine *m, int which, compound *c)
{
    m->compounds[which] = c;
    m->shapes[which] = (shape){.type = SHAPE_COMPOUND, .compound = c};
}

static soup one_rod(double radius, int sides, double z, double height)
{
    soup s = nothing();
    add_rod(&s, radius, sides, z, height);
    return s;
}

static soup one_tube(double inner, int sides, double height)
{
    soup s = nothing();
    add_tube(&s, inner, 1.5 * inner, sides, 0, height);
    return s;
}

static soup closed_tube(double inner, int sides, double height)
{
    soup s = one_tube(inner, sides, height);
    add_box(&s, vec(0, 0, -0.01), vec(2 * inner, 2 * inner, 0.01));
    return s;
}

static soup one_gear(int teeth, double root, double tip, double share)
{
    soup s = nothing();
    add_gear(&s, teeth, root, tip, share, 0, 0.02);
    return s;
}

static soup one_box(vec3 at, vec3 half)
{
    soup s = nothing();
    add_box(&s, at, half);
    return s;
}

static soup one_grid(int n)
{
    return wavy(n, 0);
}

/* Both are carried along, and turned as one body. */
static void carry(machine *m, vec3 linear, vec3 angular)
{
    toi_mover *a = &m->movers[0], *b = &m->movers[1];
    a->motion.linear = vec_add(a->motion.linear, linear);
    b->motion.linear = vec_add(b->motion.linear, linear);
    a->motion.angular = vec_add(a->motion.angular, angular);
    b->motion.angular = vec_add(b->motion.angular, angular);
}

static void comb_scene(machine *m, int size, int kind)
{
    int plates = 20 * size;
    double half = 0.0025 - 0.0015 * m->shrink; /* 2 mm thick, with 3 mm between two combs */
    if (kind == 3) {
        of_compound(m, 0, comb_of_boxes(plates, 0, half));
        of_compound(m, 1, comb_of_boxes(plates, 0.005, half));
    } else {
        of_mesh(m, 0, comb(plates, 0, half));
        of_mesh(m, 1, comb(plates, 0.005, half));
    }
    m->movers[1].motion.linear = vec(0, 0.15, 0);
    if (kind == 1) m->movers[1].motion.angular = vec(0.3, 0, 0); /* in the plates' planes */
    if (kind == 2)
        m->movers[1].motion.angular = vec(0, 0, 0.001 * m->shrink / size); /* out of them, by less than the gap */
}

static void wavy_scene(machine *m, int size, int kind)
{
    int n = 24 * size;
    of_mesh(m, 0, kind == 3 ? one_grid(n) : wavy(n, 0.05));
    of_mesh(m, 1, kind == 3 ? one_grid(n) : wavy(n, 0.05));
    m->movers[1].motion.start.p = vec(0, 0, 1e-5 * m->shrink);
    m->movers[1].motion.linear = vec(0, 0, 0.2);
    if (kind == 1) m->movers[1].motion.linear = vec(0.02, -0.01, 0.2);
    if (kind == 2) m->movers[1].motion.linear = vec(0, 0, -4e-5 * m->shrink), m->hit = 0.25;
    if (kind == 3) m->movers[1].motion.linear = vec(0.3, 0.1, 0);  /* flat, and shears along */
    if (kind == 4) m->movers[1].motion.angular = vec(0, -0.05, 0); /* opens about the edge x = 0, and lifts */
}

static void door_scene(machine *m, int kind)
{
    of_mesh(m, 0, one_box(vec(0.4, -0.02, 0), vec(0.4, 0.02, 1))); /* it turns about z, in its corner */
    soup frame = one_box(vec(-0.06, -0.02, 0), vec(0.06 - 1e-4 - 0.04, 0.02, 1.1));
    add_box(&frame, vec(0.4, 0.01 + 1e-5 * m->shrink, 0), vec(0.4, 0.01, 1.1)); /* what it shuts against */
    of_mesh(m, 1, frame);
    m->movers[0].motion.angular = vec(0, 0, -1.5);
    if (kind == 1) { /* opened by 1 rad, it shuts, all but for a little at its edge */
        m->movers[0].motion.start.q = quat_unit((quat){cos(0.5), 0, 0, -sin(0.5)});
        m->movers[0].motion.angular = vec(0, 0, 1.25);
        m->hit = (1 + asin(1e-5 * m->shrink / 0.8)) / 1.25;
    }
}

static void piston_scene(machine *m, int size, int kind)
{
    int sides = 24 * size > SIDES_MAX / 2 ? SIDES_MAX / 2 : 24 * size;
    of_mesh(m, 1, kind == 3 ? closed_tube(0.04, sides, 0.2) : one_tube(0.04, sides, 0.2));
    if (kind == 1)
        m->shapes[0] =
            (shape){.type = SHAPE_CYLINDER, .half = {0.04 - 5e-5 * m->shrink, 0.04 - 5e-5 * m->shrink, 0.05}};
    else
        of_mesh(m, 0, one_rod(0.04 - 5e-5 * m->shrink, sides + 5, -0.05, 0.1));
    m->movers[0].motion.start.p = vec(0, 0, 0.06);
    m->movers[0].motion.linear = vec(0, 0, 0.3);
    if (kind == 2) m->movers[0].motion.angular = vec(0, 0, 1);
    if (kind == 3) m->movers[0].motion.linear = vec(0, 0, -0.02), m->hit = 0.5;
    if (kind == 4) m->movers[0].motion.angular = vec(0, 0, 40);
}

static void drawer_scene(machine *m, int kind)
{
    of_mesh(m, 0, tray(vec(0.2, 0.25, 0.1), 0.01));
    of_mesh(m, 1, one_box(vec(0, 0, 0), vec(0.199, 0.25, 0.099)));
    m->movers[1].motion.start.p = vec(0, 0.001, 0);
    m->movers[1].motion.linear = vec(0, 0.4, 0);
    if (kind == 1) { /* on something that drives and turns: the drawer goes out slowly */
        m->movers[1].motion.linear = vec(-0.0006, 0.0008, 0);
        carry(m, vec(1, 2, 0), vec(0, 0.1, 0.5));
    }
    if (kind == 2) {
        m->movers[1].motion.start.p = vec(0, 0.3, 0);
        m->movers[1].motion.linear = vec(0, -0.4, 0);
        m->hit = 0.75;
    }
}

static void gear_scene(machine *m, int kind)
{
    int teeth = 24; /* module 4 mm, pitch radius 48 mm; thin teeth */
    of_mesh(m, 0, one_gear(teeth, 0.0435, 0.0510, 0.22));
    of_mesh(m, 1, one_gear(teeth, 0.0435, 0.0510, 0.22));
    m->movers[1].motion.start.p = vec(0.096, 0, 0);
    m->movers[1].motion.start.q = (quat){cos(M_PI / 2 + M_PI / 48), 0, 0, sin(M_PI / 2 + M_PI / 48)};
    m->movers[0].motion.angular = vec(0, 0, 1.5);
    m->movers[1].motion.angular = vec(0, 0, -1.5);
    if (kind == 1) m->movers[0].motion.angular = vec(0, 0, 15), m->movers[1].motion.angular = vec(0, 0, -15);
}

static void guide_scene(machine *m, int kind)
{
    of_mesh(m, 0, rail(0.5));
    of_mesh(m, 1, guide(0.05, 5e-5 * m->shrink));
    m->movers[1].motion.linear = vec(0, 0.4, 0);
    if (kind == 1) carry(m, vec(0.5, 0.1, 0.2), VEC_ZERO);
    if (kind == 2)
        m->movers[1].motion.linear = vec(1e-4 * m->shrink, 0.4, 0), m->hit = 0.5; /* it drifts into the side */
}

/* Rods side by side, 10 mm apart, between those of the other one; or a peg in a square hole of boxes. */
static void brush_scene(machine *m, int size, int kind)
{
    int across = 4 * size;
    for (int which = 0; which < 2; which++) {
        soup s = nothing();
        for (int i = 0; i < across * across; i++) {
            soup rod = one_rod(0.0069, 6, 0, 0.1);
            double shift = which ? 0.01 : 0;
            soup_add(&s, &rod, vec(0.02 * (i % across) + shift, 0.02 * (int)(i / across) + shift, 0));
            soup_free(&rod);
        }
        of_mesh(m, which, s);
    }
    m->movers[1].motion.linear = vec(0, 0, 0.15);
    if (kind == 1) carry(m, vec(0, 1, 0), vec(1, 0, 0.2)), m->movers[1].motion.linear = vec(0, 1, 0);
}

/* Five blades in a tube, a tenth of a millimetre from it. */
static void fan_scene(machine *m, int kind)
{
    soup s = nothing();
    const int blades = 5, cuts = 4;
    for (int k = 0; k < blades; k++) {
        soup blade = soup_box(0.0195, 0.0005, 0.01, cuts);
        double c = cos(2 * M_PI * k / blades), d = sin(2 * M_PI * k / blades);
        for (size_t i = 0; i < blade.point_count; i++) {
            double *p = blade.points + 3 * i, x = p[0] + 0.0204 - 2e-5, y = p[1];
            p[0] = c * x - d * y, p[1] = d * x + c * y;
        }
        soup_add(&s, &blade, VEC_ZERO);
        soup_free(&blade);
    }
    of_mesh(m, 0, s);
    of_mesh(m, 1, one_tube(0.04, 48, 0.1));
    m->movers[0].motion = (motion){{{0, 0, 0.05}, POSE_IDENTITY.q}, VEC_ZERO, {0, 0, 1850}};
    if (kind == 1) m->movers[0].motion.linear = vec(0, 0, 0.3);
}

/* Two rings of 352 triangles that turn by 1,850 rad in all, each about a diameter: one within the other, or linked so
 * that they turn in their own tubes. */
static void ring_scene(machine *m, int kind)
{
    of_mesh(m, 0, soup_torus(1, 0.1, 16, 11));
    of_mesh(m, 1, kind == 1 ? soup_torus(1, 0.1, 16, 11) : soup_torus(kind == 2 ? 0.78 : 0.5, 0.1, 16, 11));
    m->movers[0].motion.angular = kind == 1 ? vec(0, 0, 900) : vec(900, 0, 0);
    m->movers[1].motion.angular = vec(0, 950, 0);
    if (kind == 1) m->movers[1].motion.start = (pose){{1, 0, 0}, {sqrt(0.5), sqrt(0.5), 0, 0}};
}

void machine_make(int scene, int size, double shrink, machine *m)
{
    static const struct {
        const char *name;
        int kind;
    } SCENES[MACHINES] = {{"comb that slides", 0}, {"comb that slides and turns in its planes", 1},
        {"comb that slides and turns out of its planes", 2}, {"comb of boxes that slides", 3},
        {"wavy grid that lifts off", 10}, {"wavy grid that lifts off aslant", 11}, {"wavy grid that comes down", 12},
        {"flat grid that shears along", 13}, {"wavy grid that opens about an edge", 14}, {"door that opens", 20},
        {"door that shuts", 21}, {"piston", 30}, {"piston, a cylinder", 31}, {"piston that turns", 32},
        {"piston that comes to the end", 33}, {"piston that spins", 34}, {"drawer", 40}, {"drawer on a robot", 41},
        {"drawer that shuts", 42}, {"gears", 50}, {"gears, fast", 51}, {"guide", 60}, {"guide that drives", 61},
        {"guide that drifts", 62}, {"brushes that part", 70}, {"brushes, carried and turned", 71},
        {"fan in its housing", 80}, {"fan that leaves its housing", 81}, {"rings that tumble", 90},
        {"rings that spin, linked", 91}, {"rings that tumble closely", 92}};
    int kind = SCENES[scene].kind % 10;
    *m = (machine){
        .name = SCENES[scene].name, .hit = INFINITY, .shrink = shrink, .request = {.span = 1, .tolerance = 1e-6}};
    for (int k = 0; k < 2; k++)
        m->movers[k] = (toi_mover){&m->shapes[k], POSE_IDENTITY, {POSE_IDENTITY, VEC_ZERO, VEC_ZERO}};
    switch (SCENES[scene].kind / 10) {
    case 0:
        comb_scene(m, size, kind);
        break;
    case 1:
        wavy_scene(m, size, kind);
        break;
    case 2:
        door_scene(m, kind);
        break;
    case 3:
        piston_scene(m, size, kind);
        break;
    case 4:
        drawer_scene(m, kind);
        break;
    case 5:
        gear_scene(m, kind);
        break;
    case 6:
        guide_scene(m, kind);
        break;
    case 7:
        brush_scene(m, size, kind);
        break;
    case 8:
        fan_scene(m, kind);
        break;
    default:
        ring_scene(m, kind);
    }
}

void machine_free(machine *m)
{
    for (int k = 0; k < 2; k++) {
        mesh_destroy(m->meshes[k]);
        compound_destroy(m->compounds[k]);
    }
}

toi_result machine_find(const machine *m, narrow_scratch *scratch)
{
    bool ordered = narrow_ordered(&m->shapes[0], 0, &m->shapes[1], 1);
    toi_result t;
    toi_find(&m->movers[!ordered], &m->movers[ordered], &m->request, VEC_ZERO, scratch, &t);
    return t;
}
