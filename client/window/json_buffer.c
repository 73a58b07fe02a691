/* json_buffer: see json_buffer.h. */
#include "json_buffer.h"

#include "index.h"

#include <inttypes.h>
#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <string.h>

static void put(json_buffer *j, const char *text, size_t size)
{
    j->at = web_reserve(j->at, &j->capacity, j->count + size + 1, 1);
    memcpy(j->at + j->count, text, size);
    j->count += size;
    j->at[j->count] = '\0';
}

void json_buffer_raw(json_buffer *j, const char *text)
{
    put(j, text, strlen(text));
}

void json_buffer_print(json_buffer *j, const char *format, ...)
{
    char text[1024];
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(text, sizeof text, format, arguments);
    va_end(arguments);
    json_buffer_raw(j, text);
}

/* How many octets of UTF-8 stand there as one character; 0: none do. */
static size_t utf8_size(const unsigned char *at)
{
    size_t size = at[0] < 0x80                    ? 1
                  : at[0] >= 0xC2 && at[0] < 0xE0 ? 2
                  : at[0] >= 0xE0 && at[0] < 0xF0 ? 3
                  : at[0] >= 0xF0 && at[0] < 0xF5 ? 4
                                                  : 0;
    for (size_t i = 1; i < size; i++)
        if ((at[i] & 0xC0) != 0x80) return 0;
    if (size == 3 && ((at[0] == 0xE0 && at[1] < 0xA0) || (at[0] == 0xED && at[1] > 0x9F))) return 0;
    if (size == 4 && ((at[0] == 0xF0 && at[1] < 0x90) || (at[0] == 0xF4 && at[1] > 0x8F))) return 0;
    return size;
}

void json_buffer_text(json_buffer *j, const char *text)
{
    put(j, "\"", 1);
    for (const unsigned char *at = (const unsigned char *)text; *at;) {
        char escaped[8];
        size_t size = utf8_size(at);
        if (size == 0) {
            put(j, "\xEF\xBF\xBD", 3);
            at++;
        } else if (*at < 0x20 || *at == '"' || *at == '\\' || *at == 0x7F) {
            snprintf(escaped, sizeof escaped, "\\u%04x", *at++);
            json_buffer_raw(j, escaped);
        } else {
            put(j, (const char *)at, size);
            at += size;
        }
    }
    put(j, "\"", 1);
}

void json_buffer_name(json_buffer *j, const char *name)
{
    char last = j->count ? j->at[j->count - 1] : '{';
    if (last != '{' && last != '[') put(j, ",", 1);
    json_buffer_text(j, name);
    put(j, ":", 1);
}

void json_buffer_number(json_buffer *j, double value)
{
    char digits[40];
    if (isfinite(value))
        snprintf(digits, sizeof digits, "%.17g", value);
    else
        snprintf(digits, sizeof digits, isnan(value) ? "\"nan\"" : value > 0 ? "\"inf\"" : "\"-inf\"");
    json_buffer_raw(j, digits);
}

void json_buffer_whole(json_buffer *j, int64_t value)
{
    char digits[32];
    snprintf(digits, sizeof digits, "\"%" PRId64 "\"", value);
    json_buffer_raw(j, digits);
}

void json_buffer_count(json_buffer *j, int64_t value)
{
    char digits[32];
    snprintf(digits, sizeof digits, "%" PRId64, value);
    if (value > INT64_C(1) << 53 || value < -(INT64_C(1) << 53))
        json_buffer_whole(j, value);
    else
        json_buffer_raw(j, digits);
}

void json_buffer_flag(json_buffer *j, bool value)
{
    json_buffer_raw(j, value ? "true" : "false");
}

void json_buffer_numbers(json_buffer *j, const double *at, size_t count)
{
    json_buffer_raw(j, "[");
    for (size_t i = 0; i < count; i++) {
        if (i) json_buffer_raw(j, ",");
        json_buffer_number(j, at[i]);
    }
    json_buffer_raw(j, "]");
}
