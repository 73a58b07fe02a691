/* json_buffer: writes JSON into memory that grows. One thread. */
#ifndef COLLIDED_WINDOW_JSON_BUFFER_H
#define COLLIDED_WINDOW_JSON_BUFFER_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

typedef struct json_buffer { /* zeros = empty */
    char *at;                /* ends with NUL once something was put; freed by the caller */
    size_t count, capacity;
} json_buffer;

void json_buffer_raw(json_buffer *j, const char *text);
__attribute__((format(printf, 2, 3))) void json_buffer_print(json_buffer *j, const char *format, ...); /* <= 1 kB */
void json_buffer_text(json_buffer *j, const char *text); /* in quotes; octets that are not UTF-8 become U+FFFD */
/* A member's name, with a comma before it where one is due. */
void json_buffer_name(json_buffer *j, const char *name);
void json_buffer_number(json_buffer *j, double value); /* 17 digits; what is not finite as a text */
void json_buffer_whole(json_buffer *j, int64_t value); /* as a text, which keeps 64 bits */
void json_buffer_count(json_buffer *j, int64_t value); /* as a number; above 2^53 as a text */
void json_buffer_flag(json_buffer *j, bool value);
void json_buffer_numbers(json_buffer *j, const double *at, size_t count);

#endif
