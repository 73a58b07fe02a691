/* heights_png: grey pictures by libpng. Its errors come by longjmp: nothing between setjmp and them owns memory but the
 * pool and libpng itself. */
#include "heights.h"

#include <png.h>
#include <setjmp.h>
#include <string.h>

enum { CHUNK_MAX = 1 << 20 /* bytes of any chunk that is kept: none that we use is near */ };

typedef struct decoder {
    const char *data;
    size_t size, at;
    char fault[160];
    png_structp png;
    png_infop info;
    png_bytep *lines;
    size_t rows, columns;
    int depth; /* bits a sample */
} decoder;

static void fail(png_structp png, png_const_charp text)
{
    decoder *d = png_get_error_ptr(png);
    size_t length = strcspn(text, "\n\r");
    if (length >= sizeof d->fault) length = sizeof d->fault - 1;
    memcpy(d->fault, text, length);
    d->fault[length] = '\0';
    png_longjmp(png, 1);
}

static void pass_over(png_structp png, png_const_charp text)
{
    (void)png;
    (void)text;
}

static void give(png_structp png, png_bytep to, size_t count)
{
    decoder *d = png_get_io_ptr(png);
    if (count > d->size - d->at) png_error(png, "it ends too early");
    memcpy(to, d->data + d->at, count);
    d->at += count;
}

static void read_head(decoder *d)
{
    png_set_read_fn(d->png, d, give);
    png_set_chunk_malloc_max(d->png, CHUNK_MAX);
    png_set_user_limits(d->png, HEIGHTS_MAX, HEIGHTS_MAX);
    png_read_info(d->png, d->info);
    d->columns = png_get_image_width(d->png, d->info);
    d->rows = png_get_image_height(d->png, d->info);
    d->depth = png_get_bit_depth(d->png, d->info);
    if (png_get_color_type(d->png, d->info) != PNG_COLOR_TYPE_GRAY || d->depth < 8)
        png_error(d->png, "it must be grey, of 8 or 16 bits, without alpha");
    if (d->rows > HEIGHTS_MAX / d->columns) png_error(d->png, "it has too many pixels");
}

/* All that libpng may leave by longjmp. */
static bool decode_png(pool *p, decoder *d)
{
    if (setjmp(png_jmpbuf(d->png))) return false;
    read_head(d);
    (void)png_set_interlace_handling(d->png);
    png_read_update_info(d->png, d->info);
    size_t bytes = png_get_rowbytes(d->png, d->info);
    d->lines = pool_alloc(p, d->rows, sizeof *d->lines);
    for (size_t i = 0; i < d->rows; i++) d->lines[i] = pool_alloc(p, bytes, 1);
    png_read_image(d->png, d->lines);
    png_read_end(d->png, NULL);
    return true;
}

static double sample(const decoder *d, size_t line, size_t column)
{
    const png_byte *at = d->lines[line];
    if (d->depth == 8) return at[column] / 255.0;
    return (at[2 * column] * 256 + at[2 * column + 1]) / 65535.0;
}

static void fill_grid(pool *p, const decoder *d, heights_grid *out)
{
    double *to = pool_alloc(p, d->rows * d->columns, sizeof *to);
    *out = (heights_grid){to, d->rows, d->columns};
    for (size_t row = 0; row < d->rows; row++)
        for (size_t column = 0; column < d->columns; column++) *to++ = sample(d, d->rows - 1 - row, column);
}

bool heights_is_png(const char *data, size_t size)
{
    enum { SIGNATURE = 8 };
    return size >= SIGNATURE && png_sig_cmp((png_const_bytep)data, 0, SIGNATURE) == 0;
}

bool heights_parse_png(pool *p, const char *data, size_t size, const char *path, heights_grid *out, load_report *r)
{
    decoder d = {.data = data, .size = size, .fault = "libpng has no memory"};
    pool lines = {0};
    d.png = png_create_read_struct(PNG_LIBPNG_VER_STRING, &d, fail, pass_over);
    d.info = d.png ? png_create_info_struct(d.png) : NULL;
    bool ok = d.info && decode_png(&lines, &d);
    if (ok) fill_grid(p, &d, out);
    if (d.png) png_destroy_read_struct(&d.png, d.info ? &d.info : NULL, NULL);
    pool_free(&lines);
    return ok || load_fail(r, "%s: cannot be read as a PNG: %s", path, d.fault);
}
