/* What a page, or whoever takes itself for one, says to collided-web before it is known and after: Host, Origin, token
 * and a message, divided by NUL. Nothing may be read beyond its end, and what is taken is within its limits. */
#include "web.h"

#include <assert.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    static const web_options options = {.hosts = {"cell.example"},
        .host_count = 1,
        .origins = {"http://cell.example:80"},
        .origin_count = 1,
        .token = "0123456789abcdef0123456789abcdef"};
    char *text = malloc(size + 1), why[104];
    if (!text) return 0;
    memcpy(text, data, size);
    text[size] = '\0';
    const char *host = text, *end = text + size;
    const char *origin = host + strlen(host) < end ? host + strlen(host) + 1 : "";
    const char *token = *origin && origin + strlen(origin) < end ? origin + strlen(origin) + 1 : "";
    const char *message = *token && token + strlen(token) < end ? token + strlen(token) + 1 : text;
    if (gate_host(host, &options) && gate_origin(origin, host, &options))
        assert(strncasecmp(origin, "http://", 7) == 0);
    if (gate_token(token, &options)) assert(strcmp(token, options.token) == 0);
    request q;
    if (request_read(message, (size_t)(end - message), &q, why)) {
        assert(q.op > REQUEST_NONE && q.op <= REQUEST_CONTROL);
        assert(strlen(q.a) <= REQUEST_NAME_MAX && strlen(q.b) <= REQUEST_NAME_MAX);
        assert(isnan(q.rate_hz) || q.rate_hz > 0);
        for (int i = 0; i < q.at_count; i++) assert(fabs(q.at[i]) <= 1e12);
    } else {
        assert(strlen(why) < sizeof why);
    }
    free(text);
    return 0;
}
