/* The outline of a height field. A point of the surface that is below a chord between two others of its line (a row or
 * a column, whichever is longer) is no corner of the hull. What is left are the upper chains of the lines, and the
 * corners of the base; where the chains have too many points, they are made coarser. How far points may then be outside
 * is measured, so that what chooses them need not be exact. */
#include "height_field_outline.h"

#include "base/array.h"
#include "round.h"

#include <stdlib.h>

typedef struct lines { /* the field as `count` lines of `length` heights, so that no line is shorter than their number
                        */
    const double *heights;
    uint32_t count, length;
    uint32_t step, stride; /* in heights: from point to point, and from line to line */
} lines;

static lines lines_of(const height_field *f)
{
    if (f->columns >= f->rows) return (lines){f->heights, f->rows, f->columns, 1, f->columns};
    return (lines){f->heights, f->columns, f->rows, f->columns, 1};
}

static uint32_t index_of(const lines *l, uint32_t line, uint32_t point)
{
    return line * l->stride + point * l->step;
}

static double height_on_line(const lines *l, uint32_t line, uint32_t point)
{
    return l->heights[index_of(l, line, point)];
}

/* The chord from a to b, above or below point p between them. */
static double height_of_chord(const lines *l, uint32_t line, uint32_t a, uint32_t b, uint32_t p)
{
    double from = height_on_line(l, line, a), to = height_on_line(l, line, b);
    return from + (to - from) * ((double)(p - a) / (double)(b - a));
}

/* Points of the upper chain of a line, from end to end (Andrew's monotone chain). */
static uint32_t upper_chain(const lines *l, uint32_t line, uint32_t *chain)
{
    uint32_t n = 0;
    for (uint32_t p = 0; p < l->length; p++) {
        while (
            n >= 2 && height_on_line(l, line, chain[n - 1]) <= height_of_chord(l, line, chain[n - 2], p, chain[n - 1]))
            n--;
        chain[n++] = p;
    }
    return n;
}

/* Every second point and the last one. */
static uint32_t drop_every_second(uint32_t *chain, uint32_t n)
{
    uint32_t kept = 0;
    for (uint32_t i = 0; i < n; i++)
        if (i % 2 == 0 || i == n - 1) chain[kept++] = chain[i];
    return kept;
}

/* By how much points of the line stand above its chain. */
static double above_chain(const lines *l, uint32_t line, const uint32_t *chain, uint32_t n)
{
    double most = 0;
    for (uint32_t k = 0; k + 1 < n; k++)
        for (uint32_t p = chain[k] + 1; p < chain[k + 1]; p++)
            most = fmax(most, height_on_line(l, line, p) - height_of_chord(l, line, chain[k], chain[k + 1], p));
    return most;
}

/* The chains of all lines, each halved `halvings` times, written to `to` unless that is NULL. Returns their number. */
static uint32_t put_chains(const lines *l, int halvings, uint32_t *scratch, uint32_t *to, double *excess)
{
    uint32_t total = 0;
    for (uint32_t line = 0; line < l->count; line++) {
        uint32_t n = upper_chain(l, line, scratch);
        for (int i = 0; i < halvings; i++) n = drop_every_second(scratch, n);
        if (to) *excess = fmax(*excess, above_chain(l, line, scratch, n));
        for (uint32_t k = 0; to && k < n; k++) to[total + k] = index_of(l, line, scratch[k]);
        total += n;
    }
    return total;
}

/* Heights err by a few u of the largest; the lines' points are not quite evenly spaced, which steep chords turn into
 * height: by the u of the whole length, in spacings. */
static double rounding_of(const lines *l)
{
    double most = 0;
    for (uint32_t i = 0; i < l->count * l->length; i++) most = fmax(most, fabs(l->heights[i]));
    return 16 * ROUND_U * (double)l->length * most;
}

static mesh_outline whole_field(uint32_t count)
{
    uint32_t *all = base_alloc(count, sizeof *all);
    for (uint32_t i = 0; i < count; i++) all[i] = i;
    return (mesh_outline){all, count, 0};
}

mesh_outline height_field_outline(const height_field *f, uint32_t rim)
{
    uint32_t surface = f->rows * f->columns, right = f->columns - 1, back = f->rows - 1;
    if (surface + rim <= OUTLINE_MAX) return whole_field(surface + rim);
    lines l = lines_of(f);
    uint32_t *scratch = base_alloc(l.length, sizeof *scratch);
    int halvings = 0;
    while (put_chains(&l, halvings, scratch, NULL, NULL) > OUTLINE_MAX - 4) halvings++;
    double excess = 0;
    uint32_t *to = base_alloc(OUTLINE_MAX, sizeof *to);
    uint32_t n = put_chains(&l, halvings, scratch, to, &excess);
    const uint32_t corners[4] = {0, right, right + back, 2 * right + back};
    for (int i = 0; i < 4; i++) to[n++] = surface + corners[i];
    free(scratch);
    return (mesh_outline){to, n, add_up(excess, rounding_of(&l))};
}
