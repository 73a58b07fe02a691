/* viewer: one page. What it must have (the scene, events, answers) waits in a queue that is bounded; where things are
 * now is put together when the socket takes it, from what has changed since it was sent last, so that a slow page gets
 * fewer states, and no state waits for it. */
#include "web.h"
#include "window/index.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

_Static_assert(FRAME_ROOM >= LWS_PRE, "libwebsockets has room before a frame");

enum { HELLO_S = 5, QUESTIONS_MAX = 64, EVENTS_A_FRAME = 1024 };
enum { CLOSE_TOO_LARGE = 1009, CLOSE_SLOW = 1013, CLOSE_MALFORMED = 4400, CLOSE_TOKEN = 4401, CLOSE_CONTROL = 4403 };
static const double FAR_M = 256; /* from the origin, which then follows the view */

static void end_viewer(viewer *v, int code, const char *why)
{
    if (v->close_code) return;
    v->close_code = code;
    snprintf(v->close_why, sizeof v->close_why, "%s", why);
    lws_callback_on_writable(v->wsi);
}

void viewer_queue(viewer *v, const frame *f)
{
    if (v->close_code) return;
    if (v->waiting + f->count > WEB_CONTROL_BYTES) {
        char why[64];
        snprintf(why, sizeof why, "slow: %zu bytes wait", v->waiting + f->count);
        end_viewer(v, CLOSE_SLOW, why);
        return;
    }
    queued *q = web_allocate(1, sizeof *q);
    q->frame.at = web_reserve(NULL, &q->frame.capacity, FRAME_ROOM + f->count, 1);
    q->frame.count = f->count;
    memcpy(frame_octets(&q->frame), frame_octets(f), f->count);
    if (v->last)
        v->last->next = q;
    else
        v->first = q;
    v->last = q;
    v->waiting += f->count;
    lws_callback_on_writable(v->wsi);
}

static void queue_text(viewer *v, uint8_t kind, char *json)
{
    frame_text(&v->web->scratch, kind, v->web->mirror, json);
    viewer_queue(v, &v->web->scratch);
    free(json);
}

static void queue_scene(viewer *v)
{
    web *w = v->web;
    if (v->scene && v->scene >= w->mirror->scene) return;
    frame_scene(&w->scratch, w->mirror, v->scene, ++v->revision);
    viewer_queue(v, &w->scratch);
    v->scene = w->mirror->changes;
}

static void queue_events(viewer *v)
{
    web *w = v->web;
    while (v->events && !v->close_code && v->next_event <= w->mirror->event_count) {
        v->next_event = frame_events(&w->scratch, w->mirror, v->next_event, v->next_event, EVENTS_A_FRAME);
        viewer_queue(v, &w->scratch);
    }
}

/* All anew, under the daemon's epoch. */
static void begin(viewer *v)
{
    v->epoch = v->web->epoch;
    v->scene = v->posed = v->contacted = 0;
    queue_text(v, FRAME_HELLO, words_hello(v->web));
    queue_scene(v);
    v->status_due = true;
}

/* ---- its time ---- */

static void on_timer(lws_sorted_usec_list_t *timer)
{
    viewer *v = lws_container_of(timer, viewer, timer);
    if (!v->known) {
        end_viewer(v, CLOSE_TOKEN, "no token came");
        return;
    }
    v->due = v->contacts_due = true;
    lws_callback_on_writable(v->wsi);
}

static void set_timer(viewer *v, double seconds)
{
    lws_sul_schedule(v->web->context, 0, &v->timer, on_timer, (lws_usec_t)(1e6 * seconds));
}

void viewer_open(web *w, viewer *v, struct lws *wsi)
{
    *v = (viewer){.web = w, .wsi = wsi, .next = w->viewers, .next_event = 1};
    w->viewers = v;
    w->viewer_count++;
    v->rate_hz = w->options.rate_hz;
    v->range_m = w->options.range_m;
    set_timer(v, HELLO_S);
}

void viewer_close(viewer *v)
{
    web *w = v->web;
    if (!w) return;
    lws_sul_schedule(w->context, 0, &v->timer, NULL, LWS_SET_TIMER_USEC_CANCEL);
    for (viewer **at = &w->viewers; *at; at = &(*at)->next) {
        if (*at != v) continue;
        *at = v->next;
        w->viewer_count--;
        break;
    }
    for (queued *q = v->first, *next; q; q = next) {
        next = q->next;
        frame_free(&q->frame);
        free(q);
    }
    v->web = NULL;
    feed_watch(w);
}

/* ---- what it says ---- */

static void take_subscribe(viewer *v, const request *q)
{
    const web_options *o = &v->web->options;
    bool first = !v->subscribed;
    v->subscribed = true;
    v->poses = q->poses;
    v->contacts = q->contacts;
    v->events = q->events;
    v->rate_hz = isnan(q->rate_hz) ? o->rate_hz : fmin(q->rate_hz, o->rate_hz);
    v->range_m = isnan(q->range_m) ? o->range_m : fmin(q->range_m, o->range_m);
    v->posed = v->contacted = 0;
    v->due = v->contacts_due = true;
    if (first) set_timer(v, 0.001);
    queue_events(v);
    feed_watch(v->web);
    lws_callback_on_writable(v->wsi);
}

static void take_view(viewer *v, const request *q)
{
    double far = 0;
    for (int i = 0; i < 3; i++) far = fmax(far, fabs(q->at[i] - v->origin[i]));
    if (far <= FAR_M) return;
    for (int i = 0; i < 3; i++) v->origin[i] = round(q->at[i]);
    v->posed = 0;
    v->due = true;
    lws_callback_on_writable(v->wsi);
}

static void take_seen(viewer *v, uint64_t number)
{
    size_t kept = 0;
    for (size_t i = 0; i < v->unseen_count; i++)
        if (v->unseen[i] > number) v->unseen[kept++] = v->unseen[i];
    v->unseen_count = kept;
    v->tells_seen = true;
    if (v->due || v->contacts_due) lws_callback_on_writable(v->wsi);
}

static void take_ask(viewer *v, const request *q)
{
    static const char *const KINDS[] = {"explain", "distance", "body", "geometry"};
    bool known = false;
    for (size_t i = 0; i < sizeof KINDS / sizeof KINDS[0]; i++) known |= strcmp(KINDS[i], q->what) == 0;
    bool geometry = strcmp(q->what, "geometry") == 0, body = strcmp(q->what, "body") == 0;
    unsigned needs = geometry ? REQUEST_HAS_NUMBER : body ? REQUEST_HAS_A : REQUEST_HAS_A | REQUEST_HAS_B;
    needs |= REQUEST_HAS_ID;
    if (!known || (q->has & needs) != needs)
        end_viewer(v, CLOSE_MALFORMED, known ? "ask: a member is missing" : "ask: what is unknown");
    else
        ask_answer(v->web, v, q);
}

static void take_request(viewer *v, const request *q)
{
    if (!v->known) {
        if (q->op != REQUEST_HELLO || !gate_token(q->token, &v->web->options)) {
            end_viewer(v, CLOSE_TOKEN, q->op == REQUEST_HELLO ? "the token is wrong" : "the first message is a hello");
            return;
        }
        v->known = true;
        lws_sul_schedule(v->web->context, 0, &v->timer, NULL, LWS_SET_TIMER_USEC_CANCEL);
        begin(v);
        feed_watch(v->web);
        return;
    }
    switch (q->op) {
    case REQUEST_SUBSCRIBE:
        take_subscribe(v, q);
        break;
    case REQUEST_VIEW:
        take_view(v, q);
        break;
    case REQUEST_SEEN:
        take_seen(v, q->number);
        break;
    case REQUEST_ASK:
        take_ask(v, q);
        break;
    case REQUEST_CONTROL:
        if (v->web->options.file)
            recorded_control(v->web, q);
        else
            end_viewer(v, CLOSE_CONTROL, "this server shows a live daemon: there is nothing to control");
        break;
    default:
        break; /* another hello */
    }
}

int viewer_receive(viewer *v, const char *data, size_t size, bool final)
{
    char why[104];
    request q;
    if (v->close_code) return 0;
    if (v->text_size + size > REQUEST_MAX) {
        end_viewer(v, CLOSE_TOO_LARGE, "a message has at most 4096 bytes");
        return 0;
    }
    memcpy(v->text + v->text_size, data, size);
    v->text_size += size;
    if (!final) return 0;
    size = v->text_size;
    v->text_size = 0;
    if (request_read(v->text, size, &q, why))
        take_request(v, &q);
    else
        end_viewer(v, CLOSE_MALFORMED, why);
    return 0;
}

/* ---- what it is sent ---- */

static int send_frame(viewer *v, frame *f, uint64_t skipped)
{
    frame_number(f, ++v->number, (uint32_t)skipped);
    int sent = lws_write(v->wsi, frame_octets(f), f->count, LWS_WRITE_BINARY);
    lws_callback_on_writable(v->wsi);
    return sent < 0 ? -1 : 0;
}

static int send_queued(viewer *v)
{
    queued *q = v->first;
    v->first = q->next;
    if (!v->first) v->last = NULL;
    v->waiting -= q->frame.count;
    int sent = send_frame(v, &q->frame, 0);
    frame_free(&q->frame);
    free(q);
    return sent;
}

static bool same_point(const double a[3], const double b[3])
{
    return a[0] == b[0] && a[1] == b[1] && a[2] == b[2];
}

static bool is_shared(const web *w, const viewer *v, bool all)
{
    return w->shared.count && w->shared_since == v->posed && w->shared_to == w->mirror->changes &&
           w->shared_all == all && same_point(w->shared_origin, v->origin);
}

/* Pages in step lack the same: it is put together once. */
static int send_poses(viewer *v)
{
    web *w = v->web;
    bool all = v->posed == 0 || v->posed < w->mirror->scene_since;
    if (!is_shared(w, v, all)) {
        frame_poses(&w->shared, w->mirror, v->posed, all, v->origin, v->revision);
        w->shared_since = v->posed;
        w->shared_to = w->mirror->changes;
        w->shared_all = all;
        memcpy(w->shared_origin, v->origin, sizeof v->origin);
    }
    memcpy(frame_octets(&w->shared) + 68, &v->revision, sizeof v->revision);
    uint64_t states = w->pose_states - v->states, skipped = v->posed && states > 1 ? states - 1 : 0;
    v->states = w->pose_states;
    v->posed = w->mirror->changes;
    v->skipped += skipped;
    v->due = false;
    if (v->tells_seen) v->unseen[v->unseen_count++] = v->number + 1;
    return send_frame(v, &w->shared, skipped);
}

static int send_contacts(viewer *v)
{
    web *w = v->web;
    frame_contacts(&w->scratch, w->mirror, v->contacted, v->range_m);
    uint64_t states = w->contact_states - v->contact_states, skipped = v->contacted && states > 1 ? states - 1 : 0;
    v->contact_states = w->contact_states;
    v->contacted = w->mirror->changes;
    v->skipped += skipped;
    v->contacts_due = false;
    return send_frame(v, &w->scratch, skipped);
}

static int send_status(viewer *v)
{
    char *json = words_status(v->web, v);
    frame_text(&v->web->scratch, FRAME_STATUS, v->web->mirror, json);
    free(json);
    v->status_due = false;
    return send_frame(v, &v->web->scratch, 0);
}

int viewer_write(viewer *v)
{
    const mirror *m = v->web->mirror;
    if (v->close_code) {
        lws_close_reason(
            v->wsi, (enum lws_close_status)v->close_code, (unsigned char *)v->close_why, strlen(v->close_why));
        return -1;
    }
    if (v->first) return send_queued(v);
    bool draws = v->subscribed && !(v->tells_seen && v->unseen_count == WEB_UNSEEN);
    if (v->status_due) return send_status(v);
    if (draws && v->due && v->poses && (v->posed == 0 || m->poses > v->posed)) {
        set_timer(v, 1.0 / v->rate_hz);
        return send_poses(v);
    }
    if (draws && v->contacts_due && v->contacts && (v->contacted == 0 || m->contacts_change > v->contacted)) {
        set_timer(v, 1.0 / v->rate_hz);
        return send_contacts(v);
    }
    return 0;
}

void viewer_news(web *w)
{
    for (viewer *v = w->viewers; v; v = v->next) {
        if (!v->known || v->close_code) continue;
        if (w->epoch >> 16 != v->epoch >> 16) begin(v);
        queue_scene(v);
        queue_events(v);
        if (v->subscribed && (v->due || v->contacts_due)) lws_callback_on_writable(v->wsi);
    }
}

void viewer_second(web *w)
{
    for (viewer *v = w->viewers; v; v = v->next) {
        v->status_due = v->known;
        if (v->known) lws_callback_on_writable(v->wsi);
    }
}
