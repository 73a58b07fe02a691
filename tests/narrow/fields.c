/* Height fields for tests, straight from their definition. */
#include "fields.h"

#include <stdlib.h>

static double x_of(const field *f, double column)
{
    return (column - (f->it.columns - 1) / 2.0) * f->it.dx;
}

static double y_of(const field *f, double row)
{
    return (row - (f->it.rows - 1) / 2.0) * f->it.dy;
}

static field *begin(field *f, uint32_t rows, uint32_t columns)
{
    if (rows * columns > FIELD_MAX) abort();
    f->it = (height_field){.rows = rows, .columns = columns, .dx = 1, .dy = 1, .base = 1, .heights = f->heights};
    return f;
}

void field_random(field *f, dice *d, uint32_t rows, uint32_t columns, double lo, double hi)
{
    begin(f, rows, columns);
    f->it.dx = dice_between(d, 0.1, 0.5);
    f->it.dy = dice_between(d, 0.1, 0.5);
    f->it.base = dice_between(d, 0.1, 0.4);
    for (uint32_t i = 0; i < rows * columns; i++) f->heights[i] = dice_between(d, lo, hi);
}

void field_plane(field *f, uint32_t rows, uint32_t columns, double spacing, double a, double b, double c)
{
    begin(f, rows, columns);
    f->it.dx = f->it.dy = spacing;
    for (uint32_t i = 0; i < rows * columns; i++)
        f->heights[i] = a + b * x_of(f, i % columns) + c * y_of(f, (double)(i / columns));
}

mesh *field_mesh(const field *f)
{
    mesh *m;
    if (height_field_build(&f->it, &m) != HEIGHT_FIELD_OK) abort();
    return m;
}

static double height_at(const field *f, uint32_t column, uint32_t row)
{
    return f->heights[row * f->it.columns + column];
}

double field_height(const field *f, double x, double y)
{
    double column = x / f->it.dx + (f->it.columns - 1) / 2.0, row = y / f->it.dy + (f->it.rows - 1) / 2.0;
    uint32_t i = (uint32_t)column, k = (uint32_t)row;
    if (i > f->it.columns - 2) i = f->it.columns - 2;
    if (k > f->it.rows - 2) k = f->it.rows - 2;
    double u = column - i, v = row - k, h = height_at(f, i, k), far = height_at(f, i + 1, k + 1);
    double corner = u >= v ? height_at(f, i + 1, k) : height_at(f, i, k + 1);
    return u >= v ? h + u * (corner - h) + v * (far - corner) : h + v * (corner - h) + u * (far - corner);
}

/* ---- as triangles ---- */

static void add(soup *s, vec3 a, vec3 b, vec3 c)
{
    const vec3 corners[3] = {a, b, c};
    for (int k = 0; k < 3; k++) {
        double *to = s->points + 3 * s->point_count;
        to[0] = corners[k].x, to[1] = corners[k].y, to[2] = corners[k].z;
        s->corners[3 * s->triangle_count + (size_t)k] = (int32_t)s->point_count++;
    }
    s->triangle_count++;
}

static vec3 top(const field *f, uint32_t column, uint32_t row)
{
    return vec(x_of(f, column), y_of(f, row), height_at(f, column, row));
}

static double bottom_of(const field *f)
{
    double lowest = INFINITY;
    for (uint32_t i = 0; i < f->it.rows * f->it.columns; i++) lowest = fmin(lowest, f->heights[i]);
    return lowest - f->it.base;
}

/* The wall below the edge from a to b, which goes counter-clockwise round the field. */
static void add_wall(soup *s, vec3 a, vec3 b, double bottom)
{
    vec3 below_a = vec(a.x, a.y, bottom), below_b = vec(b.x, b.y, bottom);
    add(s, a, below_a, below_b);
    add(s, a, below_b, b);
}

soup field_soup(const field *f)
{
    uint32_t right = f->it.columns - 1, back = f->it.rows - 1;
    size_t most = 2 * (size_t)right * back + 4 * (size_t)(right + back) + 2;
    soup s = {calloc(9 * most, sizeof(double)), 0, calloc(3 * most, sizeof(int32_t)), 0};
    double z = bottom_of(f);
    for (uint32_t row = 0; row < back; row++)
        for (uint32_t column = 0; column < right; column++) {
            vec3 a = top(f, column, row), c = top(f, column + 1, row + 1);
            add(&s, a, top(f, column + 1, row), c);
            add(&s, a, c, top(f, column, row + 1));
        }
    for (uint32_t i = 0; i < right; i++) {
        add_wall(&s, top(f, i, 0), top(f, i + 1, 0), z);
        add_wall(&s, top(f, i + 1, back), top(f, i, back), z);
    }
    for (uint32_t i = 0; i < back; i++) {
        add_wall(&s, top(f, right, i), top(f, right, i + 1), z);
        add_wall(&s, top(f, 0, i + 1), top(f, 0, i), z);
    }
    double x = x_of(f, right), y = y_of(f, back);
    add(&s, vec(-x, -y, z), vec(-x, y, z), vec(x, y, z));
    add(&s, vec(-x, -y, z), vec(x, y, z), vec(x, -y, z));
    return s;
}
