/* json: writes JSON into memory that grows. One thread. */
#ifndef COLLIDED_WEB_JSON_H
#define COLLIDED_WEB_JSON_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

typedef struct json { /* zeros = empty */
    char *at;         /* ends with NUL once something was put; freed by the caller */
    size_t count, capacity;
} json;

void json_raw(json *j, const char *text);
void json_text(json *j, const char *text); /* in quotes; octets that are not UTF-8 become U+FFFD */
/* A member's name, with a comma before it where one is due. */
void json_name(json *j, const char *name);
void json_number(json *j, double value); /* 17 digits; what is not finite as a text */
void json_whole(json *j, int64_t value); /* as a text, which keeps 64 bits */
void json_count(json *j, int64_t value); /* as a number; above 2^53 as a text */
void json_flag(json *j, bool value);
void json_numbers(json *j, const double *at, size_t count);

#endif
