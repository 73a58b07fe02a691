/* request: a message of a page, a JSON object of at most 4,096 octets, read strictly. Pure; any thread. */
#ifndef COLLIDED_WEB_REQUEST_H
#define COLLIDED_WEB_REQUEST_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

enum { REQUEST_MAX = 4096, REQUEST_NAME_MAX = 127, REQUEST_TOKEN_MAX = 64 };

typedef enum request_op {
    REQUEST_NONE,
    REQUEST_HELLO,
    REQUEST_SUBSCRIBE,
    REQUEST_VIEW,
    REQUEST_SEEN,
    REQUEST_ASK,
    REQUEST_CONTROL
} request_op;

typedef struct request {
    request_op op;
    char token[REQUEST_TOKEN_MAX + 1];
    char what[16]; /* of ask and control: "explain", "pause", ... */
    char a[REQUEST_NAME_MAX + 1], b[REQUEST_NAME_MAX + 1];
    uint32_t id;
    uint64_t number;                             /* of a geometry, or of a frame that was seen */
    double rate_hz, range_m, tolerance_m, speed; /* NAN: not said */
    int64_t at_ns;
    double at[3];
    int at_count;
    bool poses, contacts, events; /* default true */
    unsigned has;                 /* bits of REQUEST_HAS_* */
} request;

enum { REQUEST_HAS_ID = 1, REQUEST_HAS_NUMBER = 2, REQUEST_HAS_A = 4, REQUEST_HAS_B = 8, REQUEST_HAS_AT_NS = 16 };

/* False, with a reason of at most 100 octets in `why`. */
bool request_read(const char *text, size_t size, request *out, char why[104]);

#endif
