/* heights: text matrices are read here, pictures in heights_png.c. */
#include "heights.h"

#include "text.h"

#include <string.h>

static const char DIVIDERS[] = " \t\r,;";

/* The line's numbers, beyond those in `grid`; false, and the report, when it has another count or something else. */
static bool add_row(heights_grid *grid, double *at, const char *line, int number, const char *path, load_report *r)
{
    size_t have = grid->rows * grid->columns;
    int count = text_numbers(line, DIVIDERS, at + have, (int)(HEIGHTS_MAX - have));
    if (count < 0) return load_fail(r, "%s:%d: there is something that is not a finite number", path, number);
    if (grid->rows == 0) grid->columns = (size_t)count;
    if ((size_t)count != grid->columns)
        return load_fail(r, "%s:%d: has %d numbers, the first row has %zu", path, number, count, grid->columns);
    if (have + grid->columns > HEIGHTS_MAX) return load_fail(r, "%s: has more than %d heights", path, HEIGHTS_MAX);
    grid->rows++;
    return true;
}

static bool is_passed_over(const char *line)
{
    line += strspn(line, DIVIDERS);
    return !*line || *line == '#';
}

/* Two bytes at least stand for a number. */
static double *room_for_heights(pool *p, size_t size)
{
    size_t most = size / 2 + 1;
    return pool_alloc(p, most < HEIGHTS_MAX ? most : HEIGHTS_MAX, sizeof(double));
}

static bool parse_text(pool *p, char *data, size_t size, const char *path, heights_grid *out, load_report *r)
{
    if (memchr(data, '\0', size)) return load_fail(r, "%s: is neither a PNG nor text", path);
    double *at = room_for_heights(p, size);
    int number = 1;
    *out = (heights_grid){.at = at};
    for (char *line = data, *next; line; line = next, number++) {
        next = strchr(line, '\n');
        if (next) *next++ = '\0';
        if (!is_passed_over(line) && !add_row(out, at, line, number, path, r)) return false;
    }
    return true;
}

static bool parse_picture(
    pool *p, const char *data, size_t size, const char *path, const double *range, heights_grid *out, load_report *r)
{
    if (!heights_parse_png(p, data, size, path, out, r)) return false;
    double *at = pool_alloc(p, out->rows * out->columns, sizeof *at);
    for (size_t i = 0; i < out->rows * out->columns; i++) at[i] = range[0] + (range[1] - range[0]) * out->at[i];
    out->at = at;
    return true;
}

bool heights_parse(
    pool *p, char *data, size_t size, const char *path, const double *range, heights_grid *out, load_report *r)
{
    bool picture = heights_is_png(data, size);
    if (picture && !range) return load_fail(r, "%s: a picture needs the key 'range': heights of black and white", path);
    if (!picture && range) return load_fail(r, "%s: the key 'range' is for pictures; this is text, in metres", path);
    bool read = picture ? parse_picture(p, data, size, path, range, out, r) : parse_text(p, data, size, path, out, r);
    if (!read || (out->rows >= 2 && out->columns >= 2)) return read;
    return load_fail(
        r, "%s: has %zu rows and %zu columns: at least 2 of each are needed", path, out->rows, out->columns);
}

bool heights_load(pool *p, const char *path, const double *range, heights_grid *out, load_report *r)
{
    pool file = {0};
    size_t size;
    char *data = text_read_file(&file, path, HEIGHTS_FILE_MAX, &size, r);
    bool ok = data && heights_parse(p, data, size, path, range, out, r);
    pool_free(&file);
    return ok;
}
