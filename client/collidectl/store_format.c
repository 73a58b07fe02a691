/* store_format: reads and writes the lines
 *   collidectl 1 | next N | body ID NAME | robot NAME URDF SRDF PREFIX x y z w x y z
 *   package NAME PATH | value JOINT NUMBER         (of the robot above)
 * Numbers have 17 digits, so that they read back as the same bits. */
#include "store_format.h"

#include "loaders/text.h"

#include <inttypes.h>
#include <math.h>
#include <string.h>

enum { FIELDS_MAX = 12 };

/* ---- writing ---- */

static void write_field(FILE *out, const char *text)
{
    putc('\t', out);
    for (const unsigned char *t = (const unsigned char *)text; *t; t++)
        if (*t <= ' ' || *t == '%' || *t == 127)
            fprintf(out, "%%%02X", *t);
        else
            putc(*t, out);
}

static void write_number(FILE *out, double value)
{
    fprintf(out, "\t%.17g", value);
}

static void write_robot(FILE *out, const store_robot *r)
{
    fputs("robot", out);
    write_field(out, r->name);
    write_field(out, r->urdf);
    write_field(out, r->srdf);
    write_field(out, r->prefix);
    for (int i = 0; i < 3; i++) write_number(out, r->base.position[i]);
    for (int i = 0; i < 4; i++) write_number(out, r->base.orientation[i]);
    putc('\n', out);
    for (size_t i = 0; i < r->package_count; i++) {
        fputs("package", out);
        write_field(out, r->packages[i].name);
        write_field(out, r->packages[i].path);
        putc('\n', out);
    }
    for (size_t i = 0; i < r->joint_count; i++) {
        fputs("value", out);
        write_field(out, r->joints[i]);
        write_number(out, r->values[i]);
        putc('\n', out);
    }
}

void store_write(const store *s, FILE *out)
{
    fprintf(out, "collidectl\t1\nnext\t%" PRId32 "\n", s->next_id);
    for (size_t i = 0; i < s->body_count; i++) {
        fprintf(out, "body\t%" PRId32, s->bodies[i].id);
        write_field(out, s->bodies[i].name);
        putc('\n', out);
    }
    for (size_t i = 0; i < s->robot_count; i++) write_robot(out, &s->robots[i]);
}

/* ---- reading ---- */

static int hex_digit(char c)
{
    static const char digits[] = "0123456789ABCDEF";
    const char *at = c ? strchr(digits, c) : NULL;
    return at ? (int)(at - digits) : -1;
}

static bool unescape(char *field)
{
    char *to = field;
    for (const char *from = field; *from; from++) {
        if (*from != '%') {
            *to++ = *from;
            continue;
        }
        int high = hex_digit(from[1]), low = high < 0 ? -1 : hex_digit(from[2]);
        if (low < 0 || high * 16 + low == 0) return false;
        *to++ = (char)(high * 16 + low);
        from += 2;
    }
    *to = '\0';
    return true;
}

static int split(char *line, char *fields[FIELDS_MAX])
{
    int count = 0;
    for (char *rest = line; rest && count < FIELDS_MAX; count++) {
        fields[count] = rest;
        rest = strchr(rest, '\t');
        if (rest) *rest++ = '\0';
        if (!unescape(fields[count])) return -1;
    }
    return count;
}

static bool read_id(const char *text, int32_t *out)
{
    double value;
    if (!text_number(text, &value) || value < 0 || value > INT32_MAX || value != floor(value)) return false;
    *out = (int32_t)value;
    return true;
}

static bool read_robot_line(store *s, char **f)
{
    store_robot r = {.name = pool_copy(s->pool, f[1]),
        .urdf = pool_copy(s->pool, f[2]),
        .srdf = pool_copy(s->pool, f[3]),
        .prefix = pool_copy(s->pool, f[4])};
    for (int i = 0; i < 3; i++)
        if (!text_number(f[5 + i], &r.base.position[i])) return false;
    for (int i = 0; i < 4; i++)
        if (!text_number(f[8 + i], &r.base.orientation[i])) return false;
    s->robots = store_grow(s->pool, s->robots, s->robot_count, &s->robot_room, sizeof *s->robots);
    s->robots[s->robot_count++] = r;
    return true;
}

static bool read_package(store *s, char **f)
{
    store_robot *r = s->robot_count ? &s->robots[s->robot_count - 1] : NULL;
    if (!r || r->package_count == PACKAGES_MAX) return false;
    r->packages[r->package_count++] = (load_package){pool_copy(s->pool, f[1]), pool_copy(s->pool, f[2])};
    return true;
}

static bool read_value(store *s, char **f)
{
    store_robot *r = s->robot_count ? &s->robots[s->robot_count - 1] : NULL;
    double value;
    if (!r || r->joint_count == URDF_LINKS_MAX || !text_number(f[2], &value)) return false;
    if (!r->joints) {
        r->joints = pool_alloc(s->pool, URDF_LINKS_MAX, sizeof *r->joints);
        r->values = pool_alloc(s->pool, URDF_LINKS_MAX, sizeof *r->values);
    }
    r->joints[r->joint_count] = pool_copy(s->pool, f[1]);
    r->values[r->joint_count++] = value;
    return true;
}

bool store_read_line(store *s, char *line)
{
    char *f[FIELDS_MAX];
    int count = split(line, f);
    int32_t id;
    if (count == 2 && strcmp(f[0], "collidectl") == 0) return strcmp(f[1], "1") == 0;
    if (count == 2 && strcmp(f[0], "next") == 0) return read_id(f[1], &s->next_id);
    if (count == 3 && strcmp(f[0], "package") == 0) return read_package(s, f);
    if (count == 3 && strcmp(f[0], "value") == 0) return read_value(s, f);
    if (count == 12 && strcmp(f[0], "robot") == 0) return read_robot_line(s, f);
    if (count != 3 || strcmp(f[0], "body") != 0 || !read_id(f[1], &id)) return false;
    store_put(s, f[2], id);
    return true;
}
