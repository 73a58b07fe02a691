/* json: see json.h. */
#include "json.h"

#include "index.h"

#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

static void put(json *j, const char *text, size_t size)
{
    j->at = web_reserve(j->at, &j->capacity, j->count + size + 1, 1);
    memcpy(j->at + j->count, text, size);
    j->count += size;
    j->at[j->count] = '\0';
}

void json_raw(json *j, const char *text)
{
    put(j, text, strlen(text));
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

void json_text(json *j, const char *text)
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
            json_raw(j, escaped);
        } else {
            put(j, (const char *)at, size);
            at += size;
        }
    }
    put(j, "\"", 1);
}

void json_name(json *j, const char *name)
{
    char last = j->count ? j->at[j->count - 1] : '{';
    if (last != '{' && last != '[') put(j, ",", 1);
    json_text(j, name);
    put(j, ":", 1);
}

void json_number(json *j, double value)
{
    char digits[40];
    if (isfinite(value))
        snprintf(digits, sizeof digits, "%.17g", value);
    else
        snprintf(digits, sizeof digits, isnan(value) ? "\"nan\"" : value > 0 ? "\"inf\"" : "\"-inf\"");
    json_raw(j, digits);
}

void json_whole(json *j, int64_t value)
{
    char digits[32];
    snprintf(digits, sizeof digits, "\"%" PRId64 "\"", value);
    json_raw(j, digits);
}

void json_count(json *j, int64_t value)
{
    char digits[32];
    snprintf(digits, sizeof digits, "%" PRId64, value);
    if (value > INT64_C(1) << 53 || value < -(INT64_C(1) << 53))
        json_whole(j, value);
    else
        json_raw(j, digits);
}

void json_flag(json *j, bool value)
{
    json_raw(j, value ? "true" : "false");
}

void json_numbers(json *j, const double *at, size_t count)
{
    json_raw(j, "[");
    for (size_t i = 0; i < count; i++) {
        if (i) json_raw(j, ",");
        json_number(j, at[i]);
    }
    json_raw(j, "]");
}
