/* json: writes one JSON object a line. Strings are escaped, and bytes that are not UTF-8 become U+FFFD; doubles are
 * written with 17 digits, so that they read back as the same bits; those that are not finite are null. One thread. */
#ifndef COLLIDED_COLLIDECTL_JSON_H
#define COLLIDED_COLLIDECTL_JSON_H

#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>

typedef struct json {
    FILE *out;
    bool follows; /* something stands before, so a comma comes first */
} json;

/* `key` NULL: an element of an array, or the line's own object. */
void json_open(json *j, const char *key, char bracket); /* '{' or '[' */
void json_close(json *j, char bracket);                 /* '}' or ']' */
void json_end_line(json *j);
void json_text(json *j, const char *key, const char *value);
void json_number(json *j, const char *key, double value);
void json_numbers(json *j, const char *key, const double *values, int count);
void json_integer(json *j, const char *key, int64_t value);
void json_bool(json *j, const char *key, bool value);

#endif
