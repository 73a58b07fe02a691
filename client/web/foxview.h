/* foxview: one viewer that speaks Foxglove's WebSocket protocol (subprotocols foxglove.sdk.v1 and
 * foxglove.websocket.v1, which are alike on the wire), on the same port as the pages. What is lost on the way is lost
 * to nobody: events and log lines wait in a queue that is bounded; scene, poses and contacts are put together when the
 * socket takes them. One thread. */
#ifndef COLLIDED_WEB_FOXVIEW_H
#define COLLIDED_WEB_FOXVIEW_H

#include "web.h"

#include "window/foxglove.h"

enum { FOXVIEW_SERVICES = 2, FOXVIEW_WAITING_BYTES = 8 << 20 };

typedef struct fox_message { /* behind LWS_PRE octets */
    struct fox_message *next;
    size_t size;
    bool binary;
    unsigned char at[];
} fox_message;

typedef struct foxview { /* made by libwebsockets, zeros */
    web *web;
    struct lws *wsi;
    struct foxview *next;
    lws_sorted_usec_list_t timer;
    char text[REQUEST_MAX + 1];
    size_t text_size;
    bool wants[FOXGLOVE_TOPICS], due;
    uint32_t subscriptions[FOXGLOVE_TOPICS]; /* the client's numbers */
    fox_message *first, *last;
    size_t waiting;
    uint64_t scene, looks, posed, contacts, next_event;
    int64_t scene_ns, posed_ns; /* stamps of what was sent last */
    int64_t epoch;
    int close_code;
    char close_why[104];
} foxview;

void foxview_open(web *w, foxview *v, struct lws *wsi);
int foxview_receive(foxview *v, const char *data, size_t size, bool final, bool binary);
int foxview_write(foxview *v);
void foxview_close(foxview *v);
void foxview_news(web *w); /* something has come from the daemon */
/* Has it the token, as the last part of its path? */
bool foxview_may(struct lws *wsi, const web *w);
void foxview_needs(const web *w, bool *looks, bool *watches);

#endif
