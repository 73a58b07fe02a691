/* Meshes of machine parts. */
#include "cad.h"

#include <math.h>
#include <stdlib.h>

const char *cad_name(cad_kind kind)
{
    static const char *const NAMES[CAD_KIND_COUNT] = {"box", "cylinder", "L", "U", "T", "I", "frame", "tube",
        "plate with a hole", "shaft", "gear", "bracket", "cone"};
    return NAMES[kind];
}

/* ---- outlines ---- */

static double area_of(const double *a, const double *b, const double *c)
{
    return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
}

static bool is_ear(const double (*p)[2], const int *left, int count, int i)
{
    const double *a = p[left[(i + count - 1) % count]], *b = p[left[i]], *c = p[left[(i + 1) % count]];
    if (!(area_of(a, b, c) > 0)) return false;
    for (int k = 0; k < count; k++) {
        const double *q = p[left[k]];
        if (q == a || q == b || q == c) continue;
        if (area_of(a, b, q) >= 0 && area_of(b, c, q) >= 0 && area_of(c, a, q) >= 0) return false;
    }
    return true;
}

/* Ear by ear; point i of the lower cap is i, of the upper `above` + i. */
static void add_caps(soup *s, const double (*p)[2], int count, int above)
{
    int left[CAD_OUTLINE_MAX];
    for (int i = 0; i < count; i++) left[i] = i;
    while (count > 2) {
        int i = 0;
        while (i < count && !is_ear(p, left, count, i)) i++;
        if (i == count) abort();
        int a = left[(i + count - 1) % count], b = left[i], c = left[(i + 1) % count];
        soup_triangle(s, a, c, b);
        soup_triangle(s, above + a, above + b, above + c);
        count--;
        for (int k = i; k < count; k++) left[k] = left[k + 1];
    }
}

soup cad_extruded(const double (*outline)[2], const double (*hole)[2], int count, double half)
{
    soup s = soup_new();
    int loops = hole ? 2 : 1, above = loops * count;
    for (int end = 0; end < 2; end++)
        for (int i = 0; i < loops * count; i++) {
            const double *p = i < count ? outline[i] : hole[i - count];
            soup_point(&s, vec(p[0], p[1], end ? half : -half));
        }
    for (int i = 0; i < count; i++) {
        int j = (i + 1) % count;
        soup_quad(&s, i, j, above + j, above + i);
        if (!hole) continue;
        soup_quad(&s, count + j, count + i, above + count + i, above + count + j);
        soup_quad(&s, i, count + i, count + j, j);
        soup_quad(&s, above + i, above + j, above + count + j, above + count + i);
    }
    if (!hole) add_caps(&s, outline, count, above);
    return s;
}

soup cad_turned(const double (*profile)[2], int count, int around)
{
    soup s = soup_new();
    for (int i = 0; i < count; i++)
        for (int k = 0; k < around; k++) {
            double a = 2 * M_PI * k / around;
            soup_point(&s, vec(profile[i][0] * cos(a), profile[i][0] * sin(a), profile[i][1]));
        }
    int32_t foot = soup_point(&s, vec(0, 0, profile[0][1])), top = soup_point(&s, vec(0, 0, profile[count - 1][1]));
    for (int k = 0; k < around; k++) {
        int j = (k + 1) % around, last = (count - 1) * around;
        soup_triangle(&s, foot, j, k);
        soup_triangle(&s, top, last + k, last + j);
        for (int i = 0; i + 1 < count; i++)
            soup_quad(&s, i * around + k, i * around + j, (i + 1) * around + j, (i + 1) * around + k);
    }
    return s;
}

/* ---- kinds ---- */

static void circle(double (*p)[2], int count, double radius, double turn)
{
    for (int i = 0; i < count; i++) {
        double a = 2 * M_PI * i / count + turn;
        p[i][0] = radius * cos(a);
        p[i][1] = radius * sin(a);
    }
}

/* Points of a rectangle, a multiple of 8 of them, its corners among them. */
static void rectangle(double (*p)[2], int count, double x, double y)
{
    for (int i = 0; i < count; i++) {
        double a = 2 * M_PI * i / count, c = cos(a), s = sin(a), most = fmax(fabs(c), fabs(s));
        p[i][0] = fabs(fabs(c) - fabs(s)) < 1e-12 || fabs(c) > fabs(s) ? copysign(x, c) : x * c / most;
        p[i][1] = fabs(fabs(c) - fabs(s)) < 1e-12 || fabs(s) > fabs(c) ? copysign(y, s) : y * s / most;
    }
}

static soup bracket(double x, double y, double z, double thick)
{
    soup s = soup_box(x, y, thick, 1), wall = soup_box(thick, y, z, 1), rib = soup_box(x / 2, thick, z / 2, 1);
    soup_add(&s, &wall, vec(-x + thick, 0, z - thick));
    soup_add(&s, &rib, vec(-x / 2, 0, z / 2 - thick));
    soup_free(&wall);
    soup_free(&rib);
    return s;
}

soup cad_solid(cad_kind kind, dice *d)
{
    double p[CAD_OUTLINE_MAX][2], h[CAD_OUTLINE_MAX][2];
    double x = dice_between(d, 0.5, 1), y = dice_between(d, 0.4, 1), z = dice_between(d, 0.2, 1);
    double t = dice_between(d, 0.15, 0.35), r = dice_between(d, 0.3, 0.8);
    int n = 8 * (int)dice_between(d, 2, 4.99);
    switch (kind) {
    case CAD_BOX:
        return soup_box(x, y, z, 1 + (int)dice_between(d, 0, 2.99));
    case CAD_CYLINDER:
        circle(p, n, r, 0);
        return cad_extruded((const double(*)[2])p, NULL, n, z);
    case CAD_L: {
        const double at[6][2] = {{-x, -y}, {x, -y}, {x, -y + t}, {-x + t, -y + t}, {-x + t, y}, {-x, y}};
        return cad_extruded(at, NULL, 6, z);
    }
    case CAD_U: {
        const double at[8][2] = {
            {-x, -y}, {x, -y}, {x, y}, {x - t, y}, {x - t, -y + t}, {-x + t, -y + t}, {-x + t, y}, {-x, y}};
        return cad_extruded(at, NULL, 8, z);
    }
    case CAD_T: {
        const double w = t / 2;
        const double at[8][2] = {{-w, -y}, {w, -y}, {w, y - t}, {x, y - t}, {x, y}, {-x, y}, {-x, y - t}, {-w, y - t}};
        return cad_extruded(at, NULL, 8, z);
    }
    case CAD_I: {
        const double w = t / 2;
        const double at[12][2] = {{-x, -y}, {x, -y}, {x, -y + t}, {w, -y + t}, {w, y - t}, {x, y - t}, {x, y}, {-x, y},
            {-x, y - t}, {-w, y - t}, {-w, -y + t}, {-x, -y + t}};
        return cad_extruded(at, NULL, 12, z);
    }
    case CAD_FRAME:
        rectangle(p, 8, x, y);
        rectangle(h, 8, x - t, y - t);
        return cad_extruded((const double(*)[2])p, (const double(*)[2])h, 8, z);
    case CAD_TUBE:
        circle(p, n, x, 0);
        circle(h, n, x * dice_between(d, 0.4, 0.8), 0);
        return cad_extruded((const double(*)[2])p, (const double(*)[2])h, n, z);
    case CAD_PLATE_WITH_HOLE:
        rectangle(p, n, x, y);
        circle(h, n, fmin(x, y) * dice_between(d, 0.3, 0.8), 0);
        return cad_extruded((const double(*)[2])p, (const double(*)[2])h, n, t);
    case CAD_SHAFT: {
        const double at[6][2] = {{t, -x}, {t, -x / 3}, {r, -x / 3}, {r, x / 4}, {t / 2, x / 4}, {t / 2, x}};
        return cad_turned(at, 6, n);
    }
    case CAD_GEAR:
        for (int i = 0; i < 2 * n; i++) {
            double a = 2 * M_PI * i / (2 * n), radius = i / 2 % 2 ? x : x - t / 2;
            p[i][0] = radius * cos(a);
            p[i][1] = radius * sin(a);
        }
        return cad_extruded((const double(*)[2])p, NULL, 2 * n, t);
    case CAD_BRACKET:
        return bracket(x, y, z, t / 3);
    default: {
        const double at[2][2] = {{r, -z}, {r / 3, z}};
        return cad_turned(at, 2, n);
    }
    }
}
