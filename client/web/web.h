/* web: what the files of collided-web share: the options, the server's state, a page's connection. One thread. */
#ifndef COLLIDED_WEB_WEB_H
#define COLLIDED_WEB_WEB_H

#include "request.h"
#include "window/frames.h"
#include "window/mirror.h"
#include "window/playback.h"
#include "window/triangles.h"

#include <libwebsockets.h>

enum {
    WEB_HOSTS = 16,
    WEB_CONNECTIONS = 64,
    WEB_CONTROL_BYTES = 8 << 20, /* of one page that wait: more closes it */
    WEB_UNSEEN = 3               /* frames of poses that a page which tells what it has seen may lack */
};

typedef struct web_options {
    const char *file; /* a recording in place of a daemon; NULL: none */
    const char *connect, *host, *root, *security, *interface, *name;
    int port;
    double rate_hz, range_m, horizon_s, tolerance_m;
    char token[33]; /* "" = none is asked for */
    const char *hosts[WEB_HOSTS], *origins[WEB_HOSTS];
    size_t host_count, origin_count;
    bool allow_control, quiet;
} web_options;

typedef struct site site;

typedef struct queued { /* a frame of the control plane */
    struct queued *next;
    frame frame;
} queued;

typedef struct viewer { /* one page's connection; made by libwebsockets, zeros */
    struct web *web;
    struct lws *wsi;
    struct viewer *next;
    lws_sorted_usec_list_t timer; /* the next state, or the end of the time for a hello */
    bool known, subscribed, poses, contacts, events;
    char text[REQUEST_MAX + 1]; /* a message that comes in pieces */
    size_t text_size;
    queued *first, *last;
    size_t waiting;                   /* octets of these */
    uint64_t number;                  /* of the last frame */
    uint64_t scene, posed, contacted; /* numbers of the changes up to which it was sent these */
    uint32_t revision;
    uint64_t next_event; /* its number, from 1 */
    double rate_hz, range_m, origin[3];
    bool origin_moved, due, contacts_due, status_due, tells_seen;
    uint64_t unseen[WEB_UNSEEN]; /* numbers of frames of poses, the oldest first */
    size_t unseen_count;
    uint64_t skipped_poses, skipped_contacts, skipped; /* states not sent; in all */
    uint64_t states, contact_states;                   /* of the mirror, at the last frame of each */
    int64_t epoch;
    int close_code;
    char close_why[104];
} viewer;

typedef struct web {
    web_options options;
    collided *client;
    int client_fd;
    struct lws *watched[2]; /* the client's descriptor, and the replay's */
    playback replay;        /* of options.file */
    int replay_fd;
    bool seeks, plays; /* asked for by a page, and not begun */
    int64_t seek_ns, told_ns;
    double play_speed;
    mirror *mirror;
    site *site;
    struct lws_context *context;
    viewer *viewers;
    struct foxview *foxviews; /* who speak Foxglove's protocol */
    triangles_kept kept;      /* geometries for these, by the mirror's numbers; */
    uint32_t asked;           /* those below have been asked for */
    size_t viewer_count;      /* of both */
    collided_subscription observation, contacts;
    bool observes, watches;
    uint64_t pose_states, contact_states; /* that came from the daemon */
    bool connected;
    int64_t epoch;
    frame scratch, shared; /* shared: poses, of what follows, for all pages that are in step */
    uint64_t shared_since, shared_to;
    double shared_origin[3];
    bool shared_all;
    lws_sorted_usec_list_t second;
    volatile bool stop;
} web;

/* site.c: the page's files, read when it starts. */
typedef struct site_file {
    const char *type;
    const unsigned char *at; /* LWS_PRE before it are free */
    size_t size;
} site_file;
site *site_read(const char *root); /* NULL: the page that needs no build */
void site_free(site *s);
bool site_find(const site *s, const char *path, site_file *out);

/* gate.c: who may come; pure. */
bool gate_host(const char *host, const web_options *o);
bool gate_origin(const char *origin, const char *host, const web_options *o);
bool gate_token(const char *token, const web_options *o); /* in a time that tells nothing of it */

/* viewer.c */
void viewer_open(web *w, viewer *v, struct lws *wsi);
int viewer_receive(viewer *v, const char *data, size_t size, bool final);
int viewer_write(viewer *v);
void viewer_close(viewer *v);
void viewer_news(web *w);   /* something has come from the daemon */
void viewer_second(web *w); /* once a second */

/* ask.c */
void ask_answer(web *w, viewer *v, const request *q);
void viewer_queue(viewer *v, const frame *f); /* a copy of it, to be sent in its turn */

/* main.c: the client's descriptor and the replay's in libwebsockets' loop, and out of it. */
bool web_watch(web *w);
void web_unwatch(web *w);

/* recorded.c: a recording in place of a daemon. */
int recorded_open(web *w); /* connects; EX_OK, or an exit status after saying why not */
void recorded_control(web *w, const request *q);
void recorded_tend(web *w);
void recorded_close(web *w);

/* words.c: JSON texts, to be freed. */
char *words_hello(const web *w);
char *words_status(web *w, const viewer *v);

/* feed.c: what the daemon tells. */
void feed_watch(web *w); /* subscribes to what somebody looks at, and to nothing else */
void feed_poll(web *w);

#endif
