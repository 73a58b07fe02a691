/* gate: who may come. A browser tells in Host which name its user typed, and in Origin whose page it is: a name that
 * leads here without being one of ours (DNS rebinding), and pages of others, are sent away. */
#include "web.h"

#include <ctype.h>
#include <string.h>
#include <strings.h>

/* The name alone, without its port and the brackets of an address of IPv6. False: it is none. */
static bool bare_name(const char *host, char name[256])
{
    bool bracketed = *host == '[';
    const char *begin = host + bracketed, *end = strchr(begin, bracketed ? ']' : ':');
    if (bracketed && !end) return false;
    size_t length = end ? (size_t)(end - begin) : strlen(begin);
    const char *port = end ? end + bracketed : begin + length;
    if (*port && *port++ != ':') return false;
    for (; *port; port++)
        if (!isdigit((unsigned char)*port)) return false;
    if (length == 0 || length > 255) return false;
    memcpy(name, begin, length);
    name[length] = '\0';
    return true;
}

bool gate_host(const char *host, const web_options *o)
{
    static const char *const OURS[] = {"127.0.0.1", "::1", "localhost"};
    char name[256];
    if (!bare_name(host, name)) return false;
    for (size_t i = 0; i < sizeof OURS / sizeof OURS[0]; i++)
        if (strcasecmp(name, OURS[i]) == 0) return true;
    for (size_t i = 0; i < o->host_count; i++)
        if (strcasecmp(name, o->hosts[i]) == 0) return true;
    return false;
}

bool gate_origin(const char *origin, const char *host, const web_options *o)
{
    static const char SCHEME[] = "http://";
    for (size_t i = 0; i < o->origin_count; i++)
        if (strcasecmp(origin, o->origins[i]) == 0) return true;
    return strncasecmp(origin, SCHEME, sizeof SCHEME - 1) == 0 && strcasecmp(origin + sizeof SCHEME - 1, host) == 0;
}

bool gate_token(const char *token, const web_options *o)
{
    size_t size = strlen(o->token);
    unsigned differs = strlen(token) != size;
    for (size_t i = 0; i < size && token[i]; i++) differs |= (unsigned char)token[i] ^ (unsigned char)o->token[i];
    return size == 0 || !differs;
}
