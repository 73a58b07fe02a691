/* http: the head of one request for the page of figures, as far as a server of two pages needs it: what is asked for,
 * and whether it may be answered. Pure. Nothing of a request's body, of upgrades or of tunnels is ever carried out. */
#ifndef COLLIDED_SERVICE_HTTP_H
#define COLLIDED_SERVICE_HTTP_H

#include <stdbool.h>
#include <stddef.h>

enum { HTTP_HEAD_MAX = 8192, HTTP_PATH_MAX = 256 };

typedef struct http_rules { /* whom a request may name as its host: see http_host_fits */
    const char *address;    /* that is listened on, as a number */
    const char *hosts;      /* names more, divided by spaces or commas; "*": any */
} http_rules;

typedef struct http_request {
    unsigned status;  /* 200: it may be answered; else why not, ... */
    const char *says; /* ... in one line */
    bool head;        /* HEAD: without the body */
    bool keeps;       /* the connection may stay for another one */
    char path[HTTP_PATH_MAX];
} http_request;

/* The length of the head that `text` begins with, its empty line included; 0: it is not whole yet. */
size_t http_head_size(const char *text, size_t size);
/* Of a whole head. */
http_request http_read(const char *head, size_t size, const http_rules *rules);
/* May a request name that host (with or without a port)? A page of a stranger's that a browser has open can reach what
 * listens here under a name of the stranger's, which he lets point here: so names are those that are known. On loopback
 * these are localhost and addresses of loopback. On another address they are all addresses, and names without a dot,
 * which are no stranger's: those of containers and machines of the own network. In either case those of `hosts`. */
bool http_host_fits(const char *host, size_t length, const http_rules *rules);

#endif
