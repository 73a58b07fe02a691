/* json: a writer without memory: each call prints. */
#include "json.h"

#include <inttypes.h>
#include <math.h>

/* Bytes of the UTF-8 character at `s` (RFC 3629: no overlong forms, no surrogates, nothing above U+10FFFF), 0 = none.
 */
static int utf8_length(const unsigned char *s)
{
    int length = s[0] < 0x80 ? 1 : s[0] < 0xc2 ? 0 : s[0] < 0xe0 ? 2 : s[0] < 0xf0 ? 3 : s[0] < 0xf5 ? 4 : 0;
    for (int i = 1; i < length; i++)
        if ((s[i] & 0xc0) != 0x80) return 0;
    if (s[0] == 0xe0 && s[1] < 0xa0) return 0;
    if (s[0] == 0xed && s[1] > 0x9f) return 0;
    if (s[0] == 0xf0 && s[1] < 0x90) return 0;
    if (s[0] == 0xf4 && s[1] > 0x8f) return 0;
    return length;
}

static void print_string(FILE *out, const char *text)
{
    const unsigned char *s = (const unsigned char *)text;
    putc('"', out);
    while (*s) {
        int length = utf8_length(s);
        if (length == 0)
            fputs("\\ufffd", out);
        else if (*s == '"' || *s == '\\')
            fprintf(out, "\\%c", *s);
        else if (*s < ' ' || *s == 127)
            fprintf(out, "\\u%04x", *s);
        else
            fwrite(s, 1, (size_t)length, out);
        s += length ? length : 1;
    }
    putc('"', out);
}

static void begin(json *j, const char *key)
{
    if (j->follows) putc(',', j->out);
    j->follows = true;
    if (!key) return;
    print_string(j->out, key);
    putc(':', j->out);
}

void json_open(json *j, const char *key, char bracket)
{
    begin(j, key);
    putc(bracket, j->out);
    j->follows = false;
}

void json_close(json *j, char bracket)
{
    putc(bracket, j->out);
    j->follows = true;
}

void json_end_line(json *j)
{
    putc('\n', j->out);
    j->follows = false;
}

void json_text(json *j, const char *key, const char *value)
{
    begin(j, key);
    print_string(j->out, value ? value : "");
}

void json_number(json *j, const char *key, double value)
{
    begin(j, key);
    if (isfinite(value))
        fprintf(j->out, "%.17g", value);
    else
        fputs("null", j->out);
}

void json_numbers(json *j, const char *key, const double *values, int count)
{
    json_open(j, key, '[');
    for (int i = 0; i < count; i++) json_number(j, NULL, values[i]);
    json_close(j, ']');
}

void json_integer(json *j, const char *key, int64_t value)
{
    begin(j, key);
    fprintf(j->out, "%" PRId64, value);
}

void json_bool(json *j, const char *key, bool value)
{
    begin(j, key);
    fputs(value ? "true" : "false", j->out);
}
