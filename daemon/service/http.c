/* http: requests are read by RFC 9112, strictly: whatever is not plainly well-formed is refused. */
#include "http.h"

#include <arpa/inet.h>
#include <ctype.h>
#include <stdio.h>
#include <string.h>
#include <strings.h>

typedef struct text { /* a piece of the head */
    const char *at;
    size_t size;
} text;

static bool is(text t, const char *word)
{
    return t.size == strlen(word) && strncasecmp(t.at, word, t.size) == 0;
}

/* ---- hosts ---- */

/* The name alone: without its port, and without the brackets of an address of IPv6. False: it is none. */
static bool bare_host(text host, char name[HTTP_PATH_MAX])
{
    bool bracketed = host.size && host.at[0] == '[';
    const char *end = memchr(host.at, bracketed ? ']' : ':', host.size);
    if (bracketed && !end) return false;
    const char *begin = host.at + bracketed;
    size_t length = (size_t)((end ? end : host.at + host.size) - begin);
    const char *port = end ? end + bracketed : host.at + host.size, *stop = host.at + host.size;
    if (port < stop && *port++ != ':') return false;
    for (; port < stop; port++)
        if (!isdigit((unsigned char)*port)) return false;
    if (length == 0 || length >= HTTP_PATH_MAX) return false;
    memcpy(name, begin, length);
    name[length] = '\0';
    return strlen(name) == length;
}

typedef enum place { PLACE_NAME, PLACE_LOOPBACK, PLACE_ELSEWHERE } place;

static place place_of(const char *name)
{
    struct in6_addr six;
    struct in_addr four;
    if (inet_pton(AF_INET, name, &four) == 1) return ntohl(four.s_addr) >> 24 == 127 ? PLACE_LOOPBACK : PLACE_ELSEWHERE;
    if (inet_pton(AF_INET6, name, &six) != 1) return PLACE_NAME;
    return IN6_IS_ADDR_LOOPBACK(&six) ? PLACE_LOOPBACK : PLACE_ELSEWHERE;
}

static bool is_listed(const char *name, const char *list)
{
    static const char DIVIDES[] = " ,";
    for (list += strspn(list, DIVIDES); *list; list += strspn(list, DIVIDES)) {
        text word = {list, strcspn(list, DIVIDES)};
        if (is(word, name) || is(word, "*")) return true;
        list += word.size;
    }
    return false;
}

bool http_host_fits(const char *host, size_t length, const http_rules *rules)
{
    char name[HTTP_PATH_MAX];
    if (!bare_host((text){host, length}, name)) return false;
    if (strcasecmp(name, "localhost") == 0 || is_listed(name, rules->hosts)) return true;
    place at = place_of(name);
    if (at == PLACE_LOOPBACK || strcmp(name, rules->address) == 0) return true;
    return place_of(rules->address) == PLACE_ELSEWHERE && (at == PLACE_ELSEWHERE || !strchr(name, '.'));
}

/* ---- the head ---- */

size_t http_head_size(const char *head, size_t size)
{
    const char *end = memmem(head, size, "\r\n\r\n", 4);
    return end ? (size_t)(end - head) + 4 : 0;
}

/* Up to the end of the line, which *rest is moved behind. */
static text next_line(text *rest)
{
    const char *end = memmem(rest->at, rest->size, "\r\n", 2);
    text line = {rest->at, end ? (size_t)(end - rest->at) : rest->size};
    size_t used = line.size + (end ? 2 : 0);
    *rest = (text){rest->at + used, rest->size - used};
    return line;
}

static text next_word(text *line)
{
    const char *end = memchr(line->at, ' ', line->size);
    text word = {line->at, end ? (size_t)(end - line->at) : line->size};
    size_t used = word.size + (end ? 1 : 0);
    *line = (text){line->at + used, line->size - used};
    return word;
}

static void refuse_request(http_request *r, unsigned status, const char *says)
{
    if (r->status != 200) return; /* the first reason counts */
    r->status = status;
    r->says = says;
    r->keeps = false;
}

static bool is_printable(text t)
{
    for (size_t i = 0; i < t.size; i++)
        if ((unsigned char)t.at[i] < 0x20 || (unsigned char)t.at[i] == 0x7f) return false;
    return true;
}

static void read_first(http_request *r, text line, bool *is_old)
{
    text rest = line, method = next_word(&rest), target = next_word(&rest), version = rest;
    *is_old = version.size == 8 && memcmp(version.at, "HTTP/1.0", 8) == 0;
    bool is_new = version.size == 8 && memcmp(version.at, "HTTP/1.1", 8) == 0;
    bool numbered = version.size >= 5 && memcmp(version.at, "HTTP/", 5) == 0;
    if (!is_printable(line) || !method.size || !target.size || !numbered) refuse_request(r, 400, "this is no request");
    if (!is_new && !*is_old) refuse_request(r, 505, "HTTP/1.0 and HTTP/1.1 are spoken here");
    r->head = method.size == 4 && memcmp(method.at, "HEAD", 4) == 0;
    if (!r->head && !(method.size == 3 && memcmp(method.at, "GET", 3) == 0))
        refuse_request(r, 405, "GET and HEAD are allowed");
    const char *query = memchr(target.at, '?', target.size);
    size_t length = query ? (size_t)(query - target.at) : target.size;
    if (target.size && target.at[0] != '/') refuse_request(r, 400, "a path begins with /");
    if (length >= sizeof r->path) refuse_request(r, 404, "there is no such page");
    if (r->status != 200) return;
    memcpy(r->path, target.at, length);
    r->keeps = is_new;
}

static text trimmed(text t)
{
    while (t.size && (t.at[0] == ' ' || t.at[0] == '\t')) t.at++, t.size--;
    while (t.size && (t.at[t.size - 1] == ' ' || t.at[t.size - 1] == '\t')) t.size--;
    return t;
}

/* A browser says of which page a request is; that of the page itself is fine. */
static bool is_own_origin(text origin, text host)
{
    static const char SCHEME[] = "http://";
    size_t length = sizeof SCHEME - 1;
    return origin.size == length + host.size && strncasecmp(origin.at, SCHEME, length) == 0 &&
           strncasecmp(origin.at + length, host.at, host.size) == 0;
}

static bool lists(text value, const char *word)
{
    while (value.size) {
        const char *comma = memchr(value.at, ',', value.size);
        text one = {value.at, comma ? (size_t)(comma - value.at) : value.size};
        if (is(trimmed(one), word)) return true;
        size_t used = one.size + (comma ? 1 : 0);
        value = (text){value.at + used, value.size - used};
    }
    return false;
}

typedef struct fields {
    text host, origin;
    int hosts; /* lines of Host */
    bool has_origin;
} fields;

static void read_field(http_request *r, text line, fields *f)
{
    const char *colon = memchr(line.at, ':', line.size);
    text name = {line.at, colon ? (size_t)(colon - line.at) : 0};
    if (!name.size || memchr(name.at, ' ', name.size) || memchr(name.at, '\t', name.size)) {
        refuse_request(r, 400, "a header field has a name, a colon and a value");
        return;
    }
    text value = trimmed((text){colon + 1, line.size - name.size - 1});
    if (is(name, "Host")) f->host = value, f->hosts++;
    if (is(name, "Origin")) f->origin = value, f->has_origin = true;
    if (is(name, "Connection") && lists(value, "close")) r->keeps = false;
    if (is(name, "Upgrade") || is(name, "HTTP2-Settings")) refuse_request(r, 400, "there is nothing to upgrade to");
    if (is(name, "Transfer-Encoding") || (is(name, "Content-Length") && !is(value, "0")))
        refuse_request(r, 413, "a request has no body here");
    if (is(name, "Expect")) refuse_request(r, 417, "there is nothing to expect");
}

http_request http_read(const char *head, size_t size, const http_rules *rules)
{
    http_request r = {.status = 200, .says = ""};
    text rest = {head, size};
    fields f = {.hosts = 0};
    bool is_old;
    read_first(&r, next_line(&rest), &is_old);
    for (text line = next_line(&rest); line.size; line = next_line(&rest)) read_field(&r, line, &f);
    if (f.hosts > 1 || (!f.hosts && !is_old)) refuse_request(&r, 400, "a request names one Host");
    if (f.hosts && !http_host_fits(f.host.at, f.host.size, rules))
        refuse_request(
            &r, 421, "this is nobody's page under that Host: the daemon's metrics_hosts lists further names");
    if (f.has_origin && !is_own_origin(f.origin, f.host))
        refuse_request(&r, 403, "this is not for pages of another Origin");
    return r;
}
