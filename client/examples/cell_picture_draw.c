/* cell_picture_draw: the scene and the time line as SVG text. Orthographic; each convex shape is its outline, filled by
 * the light that falls on it, from back to front in an order that separating planes decide. One thread; no state. */
#include "cell_picture.h"
#include "loaders/rigid.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static const double WIDTH = 1200, HEIGHT = 900;                         /* px, of the whole */
static const double SCALE = 290, CENTRE_X = 614, CENTRE_Y = 499;        /* px/m; px: where the world's origin is */
static const double LIGHT[3] = {-0.46, -0.34, 0.82};                    /* unit: towards the light */
static const double LANE_LOW = 0.32, LANE_HIGH = 0.88, LANE_END = 1.85; /* m, y and |x|: the painted lane */
static const double PI = 3.14159265358979323846;

/* Unit vectors of the view: to the right, up, and towards the viewer, 27 degrees above the floor and 24 to the left. */
static const double RIGHT[3] = {0.913545, -0.406737, 0};
static const double UP[3] = {0.184655, 0.414743, 0.891007};
static const double TOWARDS[3] = {-0.362405, -0.813979, 0.453990};

static const int COLOURS[PICTURE_KINDS][3] = {{222, 211, 190}, {64, 122, 156}, {226, 143, 92}, {214, 178, 98}};
static const char *const ACCENT = "#c22f4d", *const INK = "#343a40", *const PALE = "#8a8f94";

typedef struct point {
    double x, y;
} point;

enum { CORE = 64, ROUND = 40, OUTLINE = CORE * ROUND };
typedef struct solid { /* a shape = all points within `radius` of the hull of `core` */
    const picture_solid *of;
    double core[CORE][3], centre[3], radius;
    size_t count;
    bool drawn;
} solid;

static double dot(const double a[3], const double b[3])
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

static void cross(const double a[3], const double b[3], double out[3])
{
    out[0] = a[1] * b[2] - a[2] * b[1];
    out[1] = a[2] * b[0] - a[0] * b[2];
    out[2] = a[0] * b[1] - a[1] * b[0];
}

static point project(const double p[3])
{
    return (point){CENTRE_X + SCALE * dot(RIGHT, p), CENTRE_Y - SCALE * dot(UP, p)};
}

/* ---- outlines ---- */

static int by_x(const void *a, const void *b)
{
    const point *p = a, *q = b;
    return p->x != q->x ? (p->x > q->x) - (p->x < q->x) : (p->y > q->y) - (p->y < q->y);
}

static double turn(point a, point b, point c)
{
    return (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
}

/* The convex hull of points in the plane, in place (Andrew's monotone chain); returns how many are left. */
static size_t outline(point *p, size_t count)
{
    static point hull[OUTLINE + 2];
    size_t n = 0;
    qsort(p, count, sizeof *p, by_x);
    for (size_t i = 0; i < count; i++) {
        while (n >= 2 && turn(hull[n - 2], hull[n - 1], p[i]) <= 1e-6) n--;
        hull[n++] = p[i];
    }
    for (size_t i = count - 1, lower = n + 1; i-- > 0;) {
        while (n >= lower && turn(hull[n - 2], hull[n - 1], p[i]) <= 1e-6) n--;
        hull[n++] = p[i];
    }
    n -= n > 1;
    memcpy(p, hull, n * sizeof *p);
    return n;
}

static void path(FILE *out, const point *p, size_t count)
{
    fputs("<path d=\"", out);
    for (size_t i = 0; i < count; i++) fprintf(out, "%c%.1f %.1f", i ? 'L' : 'M', p[i].x, p[i].y);
    fputs("Z\" ", out);
}

static void path3(FILE *out, const double (*corners)[3], size_t count)
{
    point p[4];
    for (size_t i = 0; i < count && i < 4; i++) p[i] = project(corners[i]);
    path(out, p, count);
}

/* ---- solids ---- */

static void add_core(solid *s, double x, double y, double z)
{
    const double local[3] = {x, y, z};
    double *p = s->core[s->count++];
    rigid_rotate(s->of->shape.pose.orientation, local, p);
    for (int i = 0; i < 3; i++) p[i] += s->of->shape.pose.position[i];
}

static void make_solid(solid *s, const picture_solid *of)
{
    const double *h = of->shape.half;
    *s = (solid){.of = of, .radius = of->shape.radius};
    memcpy(s->centre, of->shape.pose.position, sizeof s->centre);
    switch (of->shape.type) {
    case COLLIDED_BOX:
        for (int i = 0; i < 8; i++) add_core(s, i & 1 ? h[0] : -h[0], i & 2 ? h[1] : -h[1], i & 4 ? h[2] : -h[2]);
        break;
    case COLLIDED_CYLINDER:
        for (int i = 0; i < CORE; i++) {
            double angle = 4 * PI * i / CORE;
            add_core(s, h[0] * cos(angle), h[1] * sin(angle), i < CORE / 2 ? -h[2] : h[2]);
        }
        break;
    case COLLIDED_HULL:
        for (size_t i = 0; i < of->hull_count && i < CORE; i++)
            add_core(s, of->hull[3 * i], of->hull[3 * i + 1], of->hull[3 * i + 2]);
        break;
    default: /* spheres and capsules; the cell has no others */
        add_core(s, 0, 0, -h[2]);
        add_core(s, 0, 0, h[2]);
    }
}

static double support(const solid *s, const double axis[3])
{
    double most = -INFINITY;
    for (size_t i = 0; i < s->count; i++) most = fmax(most, dot(axis, s->core[i]));
    return most + s->radius * sqrt(dot(axis, axis));
}

static bool apart(const solid *a, const solid *b, const double axis[3]) /* b beyond a along the axis */
{
    const double back[3] = {-axis[0], -axis[1], -axis[2]};
    return support(a, axis) <= -support(b, back) + 1e-6;
}

/* Whether the view keeps the two beside each other, by four directions in its plane. */
static bool beside_in_view(const solid *a, const solid *b)
{
    static const double directions[4][2] = {{1, 0}, {0, 1}, {1, 1}, {1, -1}};
    for (int i = 0; i < 4; i++) {
        double axis[3];
        for (int k = 0; k < 3; k++) axis[k] = directions[i][0] * RIGHT[k] + directions[i][1] * UP[k];
        if (apart(a, b, axis) || apart(b, a, axis)) return true;
    }
    return false;
}

/* Whether `a` may hide a part of `b`: if a plane separates them, it is the one on the viewer's side. */
static bool hides(const solid *a, const solid *b)
{
    if (beside_in_view(a, b)) return false;
    double axes[4][3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
    for (int i = 0; i < 3; i++) axes[3][i] = a->centre[i] - b->centre[i];
    for (int i = 0; i < 4; i++) {
        double facing = dot(axes[i], TOWARDS);
        if (apart(b, a, axes[i])) return facing > 0;
        if (apart(a, b, axes[i])) return facing < 0;
    }
    return dot(a->centre, TOWARDS) > dot(b->centre, TOWARDS);
}

/* The next one to draw: it hides none of those left; in a ring of shapes, which is rare, the farthest. */
static solid *farthest(solid *s, size_t count)
{
    solid *best = NULL;
    for (size_t i = 0; i < count; i++) {
        bool free = !s[i].drawn;
        for (size_t j = 0; free && j < count; j++) free = j == i || s[j].drawn || !hides(&s[i], &s[j]);
        if (free) return &s[i];
        if (!s[i].drawn && (!best || dot(s[i].centre, TOWARDS) < dot(best->centre, TOWARDS))) best = &s[i];
    }
    return best;
}

/* ---- light ---- */

static void colour(FILE *out, const char *name, picture_kind kind, const double normal[3])
{
    double light = 0.70 + 0.42 * dot(normal, LIGHT);
    int c[3];
    for (int i = 0; i < 3; i++) {
        double base = COLOURS[kind][i];
        c[i] = (int)(light > 1 ? base + (255 - base) * fmin(1, 2 * (light - 1)) : base * fmax(light, 0.45));
    }
    fprintf(out, "%s=\"#%02x%02x%02x\" ", name, (unsigned)c[0], (unsigned)c[1], (unsigned)c[2]);
}

static void stops(FILE *out, picture_kind kind, const double side[3], const double front[3])
{
    for (int i = 0; i <= 6; i++) {
        double across = -1 + i / 3.0, depth = sqrt(fmax(0, 1 - across * across)), n[3];
        for (int k = 0; k < 3; k++) n[k] = across * side[k] + depth * front[k];
        fprintf(out, "<stop offset=\"%.3f\" ", i / 6.0);
        colour(out, "stop-color", kind, n);
        fputs("/>", out);
    }
}

/* Light runs across a round shape, from one edge of its outline to the other. A sphere, or a tube seen along its axis,
 * takes it from the light's side to the far side. */
static void gradient(FILE *out, const solid *s, size_t id)
{
    const double z[3] = {0, 0, 1};
    double axis[3], side[3], front[3], radius = s->radius > 0 ? s->radius : s->of->shape.half[0];
    rigid_rotate(s->of->shape.pose.orientation, z, axis);
    cross(TOWARDS, axis, side);
    double length = sqrt(dot(side, side));
    bool ball = s->of->shape.half[2] <= 0 || length < 0.3;
    if (ball) {
        double facing = dot(LIGHT, TOWARDS);
        for (int i = 0; i < 3; i++) side[i] = LIGHT[i] - facing * TOWARDS[i];
        length = sqrt(dot(side, side));
    }
    for (int i = 0; i < 3; i++) side[i] /= length;
    cross(axis, side, front);
    if (ball) memcpy(front, TOWARDS, sizeof front);
    if (dot(front, TOWARDS) < 0)
        for (int i = 0; i < 3; i++) front[i] = -front[i];
    double from[3], to[3];
    for (int i = 0; i < 3; i++) from[i] = s->centre[i] - radius * side[i], to[i] = s->centre[i] + radius * side[i];
    point a = project(from), b = project(to);
    fprintf(out,
        "<linearGradient id=\"g%zu\" gradientUnits=\"userSpaceOnUse\" x1=\"%.1f\" y1=\"%.1f\" x2=\"%.1f\" "
        "y2=\"%.1f\">",
        id, a.x, a.y, b.x, b.y);
    stops(out, s->of->kind, side, front);
    fputs("</linearGradient>\n", out);
}

/* ---- drawing solids ---- */

static void draw_round(FILE *out, const solid *s, size_t id)
{
    static point p[OUTLINE];
    size_t n = 0, around = s->radius > 0 ? ROUND : 1;
    for (size_t i = 0; i < s->count; i++)
        for (size_t k = 0; k < around; k++) {
            point c = project(s->core[i]);
            double angle = 2 * PI * (double)k / ROUND, r = SCALE * s->radius;
            p[n++] = (point){c.x + r * cos(angle), c.y + r * sin(angle)};
        }
    gradient(out, s, id);
    n = outline(p, n);
    path(out, p, n);
    fprintf(out, "fill=\"url(#g%zu)\"/>\n", id);
    if (s->of->shape.type != COLLIDED_CYLINDER) return;
    const double z[3] = {0, 0, 1};
    double axis[3];
    rigid_rotate(s->of->shape.pose.orientation, z, axis);
    bool top = dot(axis, TOWARDS) > 0; /* the end that is seen */
    for (int i = 0; i < 3; i++) axis[i] = top ? axis[i] : -axis[i];
    for (size_t i = 0; i < CORE / 2; i++) p[i] = project(s->core[i + (top ? CORE / 2 : 0)]);
    n = outline(p, CORE / 2);
    path(out, p, n);
    colour(out, "fill", s->of->kind, axis);
    fputs("/>\n", out);
}

/* The face through three of the corners, if it is one, faces the viewer, and these three are its first. */
static void draw_face(FILE *out, const solid *s, const size_t corner[3])
{
    double u[3], v[3], normal[3];
    for (int i = 0; i < 3; i++) u[i] = s->core[corner[1]][i] - s->core[corner[0]][i];
    for (int i = 0; i < 3; i++) v[i] = s->core[corner[2]][i] - s->core[corner[0]][i];
    cross(u, v, normal);
    double length = sqrt(dot(normal, normal)) * (dot(normal, TOWARDS) < 0 ? -1 : 1);
    if (fabs(length) < 1e-9) return;
    for (int i = 0; i < 3; i++) normal[i] /= length;
    if (dot(normal, TOWARDS) < 1e-6) return;
    point p[CORE];
    size_t n = 0;
    for (size_t i = 0; i < s->count; i++) {
        double above = dot(normal, s->core[i]) - dot(normal, s->core[corner[0]]);
        if (above > 1e-6) return;
        if (above < -1e-6) continue;
        if (n < 3 && i != corner[n]) return;
        p[n++] = project(s->core[i]);
    }
    n = outline(p, n);
    path(out, p, n);
    colour(out, "fill", s->of->kind, normal);
    fputs("/>\n", out);
}

static void draw_flat(FILE *out, const solid *s)
{
    for (size_t i = 0; i < s->count; i++)
        for (size_t j = i + 1; j < s->count; j++)
            for (size_t k = j + 1; k < s->count; k++) draw_face(out, s, (size_t[]){i, j, k});
}

/* What the light throws onto the plane z = height. A ball's shadow is taken from points all over it. */
static void shadow(FILE *out, const solid *s, double height)
{
    static point p[OUTLINE];
    size_t n = 0, around = s->radius > 0 ? ROUND : 1;
    if (s->centre[2] < height) return;
    for (size_t i = 0; i < s->count; i++)
        for (size_t k = 0; k < around; k++) {
            double z = 1 - 2 * ((double)k + 0.5) / ROUND, flat = sqrt(1 - z * z), angle = 2.399963 * (double)k;
            const double d[3] = {flat * cos(angle), flat * sin(angle), z};
            double q[3];
            for (int c = 0; c < 3; c++) q[c] = s->core[i][c] + s->radius * d[c];
            double down = (q[2] - height) / LIGHT[2];
            for (int c = 0; c < 3; c++) q[c] -= down * LIGHT[c];
            p[n++] = project(q);
        }
    n = outline(p, n);
    path(out, p, n);
    fputs("/>\n", out);
}

static void shadows(FILE *out, const solid *s, size_t count, const solid *onto)
{
    double height = onto ? onto->centre[2] + onto->of->shape.half[2] : 0;
    if (onto) {
        static const size_t top[4] = {4, 5, 7, 6}; /* corners of a box, as make_solid numbers them */
        point p[4];
        for (int i = 0; i < 4; i++) p[i] = project(onto->core[top[i]]);
        fputs("<clipPath id=\"top\">", out);
        path(out, p, 4);
        fputs("/></clipPath>", out);
    }
    fprintf(out, "<g %sopacity=\"0.17\"><g fill=\"#2b2a33\" filter=\"url(#soft)\">\n",
        onto ? "clip-path=\"url(#top)\" " : "");
    for (size_t i = 0; i < count; i++)
        if (&s[i] != onto) shadow(out, &s[i], height);
    fputs("</g></g>\n", out);
}

static void draw_floor(FILE *out)
{
    const double lane[4][3] = {
        {-LANE_END, LANE_LOW, 0}, {LANE_END, LANE_LOW, 0}, {LANE_END, LANE_HIGH, 0}, {-LANE_END, LANE_HIGH, 0}};
    path3(out, lane, 4);
    fputs("fill=\"#efe7d8\"/>\n<g stroke=\"#e3ddd0\" stroke-width=\"1\">\n", out);
    for (int i = -5; i <= 7; i++) {
        double x = 0.25 * i, y = 0.25 * (i + 1);
        point a = project((double[]){x, -0.75, 0}), b = project((double[]){x, 1.25, 0});
        fprintf(out, "<path d=\"M%.1f %.1fL%.1f %.1f\"/>", a.x, a.y, b.x, b.y);
        if (i < -4 || i > 4) continue;
        a = project((double[]){-1.25, y, 0}), b = project((double[]){1.75, y, 0});
        fprintf(out, "<path d=\"M%.1f %.1fL%.1f %.1f\"/>\n", a.x, a.y, b.x, b.y);
    }
    fputs("</g>\n<g stroke=\"#c9b995\" stroke-width=\"2\" stroke-dasharray=\"14 9\" fill=\"none\">", out);
    for (int i = 0; i < 2; i++) {
        point a = project(lane[i ? 3 : 0]), b = project(lane[i ? 2 : 1]);
        fprintf(out, "<path d=\"M%.1f %.1fL%.1f %.1f\"/>", a.x, a.y, b.x, b.y);
    }
    fputs("</g>\n", out);
}

static void draw_solids(FILE *out, const picture *p)
{
    static solid s[PICTURE_SOLIDS];
    for (size_t i = 0; i < p->solid_count; i++) make_solid(&s[i], &p->solids[i]);
    shadows(out, s, p->solid_count, NULL);
    fputs("<g stroke=\"#2b2a33\" stroke-opacity=\"0.38\" stroke-width=\"0.9\" stroke-linejoin=\"round\">\n", out);
    for (size_t left = p->solid_count; left > 0; left--) {
        solid *next = farthest(s, p->solid_count);
        next->drawn = true;
        bool box = next->of->shape.type == COLLIDED_BOX, flat = box || next->of->shape.type == COLLIDED_HULL;
        if (flat)
            draw_flat(out, next);
        else
            draw_round(out, next, left);
        if (box && next->of->kind == PICTURE_TABLE) shadows(out, s, p->solid_count, next);
    }
    fputs("</g>\n", out);
}

/* ---- words ---- */

typedef struct area {
    double left, top, right, bottom;
} area;

static bool overlap(area a, area b)
{
    return a.left < b.right && b.left < a.right && a.top < b.bottom && b.top < a.bottom;
}

static void text(FILE *out, double x, double y, const char *style, const char *words)
{
    fprintf(out, "<text x=\"%.1f\" y=\"%.1f\" %s>%s</text>\n", x, y, style, words);
}

/* Each label stands above what it names, and moves up, on a fine leader, until it covers none of those before it. */
static void draw_labels(FILE *out, const picture *p, area *taken, size_t count)
{
    for (size_t i = 0; i < p->label_count; i++) {
        point at = project(p->labels[i].at);
        double half = 3.7 * (double)strlen(p->labels[i].name) + 4, y = at.y - 14;
        area mine = {at.x - half, y - 14, at.x + half, y + 4};
        for (size_t k = 0; k < count;)
            if (overlap(mine, taken[k]))
                y -= 4, mine.top -= 4, mine.bottom -= 4, k = 0;
            else
                k++;
        taken[count++] = mine;
        fprintf(
            out, "<path d=\"M%.1f %.1fL%.1f %.1f\" stroke=\"%s\" stroke-width=\"0.8\"/>", at.x, at.y, at.x, y + 5, INK);
        text(out, at.x, y, "class=\"halo\" text-anchor=\"middle\" font-size=\"13\"", p->labels[i].name);
    }
}

/* The highest place on the page that a solid takes between left and right. */
static double skyline(const picture *p, double left, double right)
{
    double top = HEIGHT;
    for (size_t i = 0; i < p->solid_count; i++) {
        solid s;
        make_solid(&s, &p->solids[i]);
        for (size_t k = 0; k < s.count; k++) {
            point c = project(s.core[k]);
            double r = SCALE * s.radius;
            if (c.x + r > left && c.x - r < right) top = fmin(top, c.y - r);
        }
    }
    return top;
}

static void draw_facts(FILE *out, const picture *p)
{
    const picture_gap *g = &p->shown;
    point a = project(g->point_a), b = project(g->point_b);
    fprintf(out, "<path id=\"distance\" d=\"M%.1f %.1fL%.1f %.1f\" stroke=\"%s\" stroke-width=\"2.6\"/>\n", a.x, a.y,
        b.x, b.y, ACCENT);
    for (int i = 0; i < 2; i++)
        fprintf(out, "<circle cx=\"%.1f\" cy=\"%.1f\" r=\"4.2\" fill=\"#fff\" stroke=\"%s\" stroke-width=\"2.2\"/>\n",
            i ? b.x : a.x, i ? b.y : a.y, ACCENT);
    for (size_t i = 0; i < p->contact_count; i++) {
        point c = project(p->contacts[i]);
        fprintf(out,
            "<circle class=\"contact\" cx=\"%.1f\" cy=\"%.1f\" r=\"4.5\" fill=\"%s\" stroke=\"#fff\" "
            "stroke-width=\"1.6\"/>\n",
            c.x, c.y, INK);
    }
    char words[64];
    (void)snprintf(words, sizeof words, "%.3f .. %.3f mm", 1e3 * g->lo, 1e3 * g->hi);
    double x = (a.x + b.x) / 2, y = skyline(p, x - 116, x + 116) - 16;
    area taken[PICTURE_LABELS + 1] = {{x - 116, y - 18, x + 116, y + 8}};
    fprintf(out, "<path d=\"M%.1f %.1fL%.1f %.1f\" stroke=\"%s\" stroke-width=\"0.8\"/>", x, (a.y + b.y) / 2, x, y + 7,
        ACCENT);
    draw_labels(out, p, taken, 1);
    fprintf(out, "<g fill=\"%s\" font-weight=\"600\">", ACCENT);
    text(out, x, y, "class=\"halo\" id=\"interval\" text-anchor=\"middle\" font-size=\"19\"", words);
    fputs("</g>\n", out);
}

static void draw_legend(FILE *out)
{
    fprintf(
        out, "<g transform=\"translate(760 574)\"><path d=\"M0 0h34\" stroke=\"%s\" stroke-width=\"2.6\"/>", ACCENT);
    for (int i = 0; i < 2; i++)
        fprintf(out, "<circle cx=\"%d\" r=\"4\" fill=\"#fff\" stroke=\"%s\" stroke-width=\"2\"/>", 34 * i, ACCENT);
    fprintf(out, "<circle cx=\"17\" cy=\"26\" r=\"4.5\" fill=\"%s\"/>\n", INK);
    text(out, 50, 5, "font-size=\"13\"", "certified distance, lo .. hi, between its two witnesses");
    text(out, 50, 31, "font-size=\"13\"", "contact");
    fputs("</g>\n", out);
}

/* ---- the time line ---- */

static const double LINE_LEFT = 92, LINE_RIGHT = 1160, LINE_TOP = 708, LINE_BOTTOM = 826, LINE_MOST_M = 1.2;

static double line_x(const picture *p, double at_s)
{
    return LINE_LEFT + (LINE_RIGHT - LINE_LEFT) * at_s / p->seconds;
}

static double line_y(double distance_m)
{
    return LINE_BOTTOM - (LINE_BOTTOM - LINE_TOP) * fmin(fmax(distance_m, 0), LINE_MOST_M) / LINE_MOST_M;
}

static void draw_axes(FILE *out, const picture *p)
{
    char words[96];
    fputs("<g stroke=\"#e3ddd0\">", out);
    for (int i = 0; i <= 3; i++) fprintf(out, "<path d=\"M%g %.1fH%g\"/>", LINE_LEFT, line_y(0.4 * i), LINE_RIGHT);
    fprintf(out, "</g><g fill=\"%s\" font-size=\"12\">\n", PALE);
    for (int i = 0; i <= 3; i++) {
        (void)snprintf(words, sizeof words, i == 3 ? "%d mm" : "%d", 400 * i);
        text(out, LINE_LEFT - 10, line_y(0.4 * i) + 4, "text-anchor=\"end\"", words);
    }
    for (int i = 0; i <= (int)p->seconds; i += p->seconds > 10 ? 2 : 1) {
        (void)snprintf(words, sizeof words, "%d s", i);
        text(out, line_x(p, i), LINE_BOTTOM + 38, "text-anchor=\"middle\"", words);
    }
    fputs("</g>\n", out);
    double y = line_y(p->protective_m);
    fprintf(out, "<path d=\"M%g %.1fH%g\" stroke=\"%s\" stroke-dasharray=\"6 5\" stroke-opacity=\"0.7\"/>\n", LINE_LEFT,
        y, LINE_RIGHT, ACCENT);
    text(out, LINE_LEFT, LINE_TOP - 36, "font-size=\"14\" font-weight=\"600\"", "arm to vehicle");
    (void)snprintf(words, sizeof words, "the arm stands still before %.0f mm; nearer, the vehicle comes by itself",
        1e3 * p->protective_m);
    text(out, LINE_LEFT + 118, LINE_TOP - 36, "font-size=\"13\" fill=\"#c22f4d\"", words);
}

/* The band between lo and hi: of the ticks that fall onto one and a half pixels, all that they said. */
static void draw_curve(FILE *out, const picture *p)
{
    const double step = 1.5 * p->seconds / (LINE_RIGHT - LINE_LEFT);
    for (size_t i = 0; i < p->gap_count;) {
        static point lower[2048], upper[2048];
        size_t n = 0;
        double last = p->gaps[i].at_s;
        while (i < p->gap_count && p->gaps[i].at_s - last < 0.3 && n < 2048) {
            double from = p->gaps[i].at_s, lo = INFINITY, hi = -INFINITY;
            for (; i < p->gap_count && p->gaps[i].at_s < from + step; i++) {
                lo = fmin(lo, p->gaps[i].lo), hi = fmax(hi, p->gaps[i].hi), last = p->gaps[i].at_s;
            }
            lower[n] = (point){line_x(p, from), line_y(lo)};
            upper[n++] = (point){line_x(p, from), line_y(hi)};
        }
        fputs("<path class=\"curve\" d=\"", out);
        for (size_t k = 0; k < n; k++) fprintf(out, "%c%.1f %.1f", k ? 'L' : 'M', lower[k].x, lower[k].y);
        for (size_t k = n; k-- > 0;) fprintf(out, "L%.1f %.1f", upper[k].x, upper[k].y);
        fputs("Z\" fill=\"#407a9c\" stroke=\"#407a9c\" stroke-width=\"2\" stroke-linejoin=\"round\"/>\n", out);
    }
}

static void draw_marks(FILE *out, const picture *p)
{
    for (size_t i = 0; i < p->mark_count; i++) {
        const picture_mark *m = &p->marks[i];
        double x = line_x(p, m->at_s), y = LINE_BOTTOM + 14;
        if (m->kind == PICTURE_STOP || m->kind == PICTURE_GO)
            fprintf(out, "<circle cx=\"%.1f\" cy=\"%.1f\" r=\"4.5\" fill=\"%s\" stroke=\"%s\" stroke-width=\"1.8\"/>\n",
                x, line_y(m->lo), m->kind == PICTURE_STOP ? ACCENT : "#fff", ACCENT);
        else
            fprintf(out, "<path d=\"M%.1f %.1fl4 8h-8Z\" fill=\"%s\" stroke=\"%s\" stroke-width=\"1.3\"/>\n", x, y - 4,
                m->kind == PICTURE_BEGIN ? INK : "#fbf9f4", INK);
    }
    double x = line_x(p, p->shown.at_s);
    fprintf(out, "<path d=\"M%.1f %gV%g\" stroke=\"%s\" stroke-width=\"1\" stroke-dasharray=\"2 3\"/>\n", x,
        LINE_TOP - 8, LINE_BOTTOM, INK);
    text(out, x, LINE_TOP - 13, "class=\"halo\" text-anchor=\"middle\" font-size=\"12\"", "this moment");
    fprintf(out,
        "<circle cx=\"806\" cy=\"667\" r=\"4.5\" fill=\"%s\"/><circle cx=\"870\" cy=\"667\" r=\"4\" fill=\"#fff\" "
        "stroke=\"%s\" stroke-width=\"1.8\"/><path d=\"M959 663l4 8h-8Z\" fill=\"%s\" stroke=\"%s\"/><path d=\"M1070 "
        "663l4 8h-8Z\" fill=\"#fbf9f4\" stroke=\"%s\" stroke-width=\"1.3\"/>\n",
        ACCENT, ACCENT, INK, INK, INK);
    text(out, 816, 672, "font-size=\"13\"", "stop");
    text(out, 880, 672, "font-size=\"13\"", "goes on");
    text(out, 969, 672, "font-size=\"13\"", "touch begins");
    text(out, 1080, 672, "font-size=\"13\"", "touch ends");
}

void picture_draw(const picture *p, FILE *out)
{
    fprintf(out,
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 %g %g\" width=\"%g\" height=\"%g\" "
        "font-family=\"Helvetica Neue, Helvetica, Arial, sans-serif\" fill=\"%s\">\n"
        "<title>The robot cell of collided's demo</title>\n<style>.halo{paint-order:stroke;stroke:#fbf9f4;"
        "stroke-width:4px;stroke-linejoin:round}</style>\n<defs><filter id=\"soft\" x=\"-10%%\" y=\"-10%%\" "
        "width=\"120%%\" height=\"120%%\"><feGaussianBlur stdDeviation=\"4\"/></filter></defs>\n"
        "<rect width=\"%g\" height=\"%g\" rx=\"18\" fill=\"#fbf9f4\"/>\n",
        WIDTH, HEIGHT, WIDTH, HEIGHT, INK, WIDTH, HEIGHT);
    draw_floor(out);
    draw_solids(out, p);
    draw_facts(out, p);
    draw_legend(out);
    draw_axes(out, p);
    draw_curve(out, p);
    draw_marks(out, p);
    fputs("</svg>\n", out);
}
