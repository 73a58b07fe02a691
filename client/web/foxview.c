/* foxview: channels and services, what is asked of them, and what is sent. */
#include "foxview.h"

#include "window/index.h"

#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { CLOSE_TOO_LARGE = 1009, CLOSE_OTHER_DAEMON = 1012, CLOSE_SLOW = 1013 };
enum { OP_MESSAGE = 1, OP_SERVICE_CALL = 2, OP_SERVICE_RESPONSE = 3, MESSAGE_HEAD = 13, CALL_HEAD = 13 };
enum { COMPLETE_BODIES = 1000 };
static const int64_t SECOND_NS = 1000000000;
#define FOXVIEW_PATIENCE_S 1.0

static void end_foxview(foxview *v, int code, const char *why)
{
    if (v->close_code) return;
    v->close_code = code;
    snprintf(v->close_why, sizeof v->close_why, "%s", why);
    lws_callback_on_writable(v->wsi);
}

static void queue_octets(foxview *v, const void *head, size_t head_size, const void *at, size_t size, bool binary)
{
    if (v->close_code) return;
    if (v->waiting + head_size + size > FOXVIEW_WAITING_BYTES) {
        end_foxview(v, CLOSE_SLOW, "slow: more than 8 MB wait");
        return;
    }
    fox_message *m = web_allocate(1, sizeof *m + LWS_PRE + head_size + size);
    m->size = head_size + size;
    m->binary = binary;
    if (head_size) memcpy(m->at + LWS_PRE, head, head_size);
    if (size) memcpy(m->at + LWS_PRE + head_size, at, size);
    if (v->last)
        v->last->next = m;
    else
        v->first = m;
    v->last = m;
    v->waiting += m->size;
    lws_callback_on_writable(v->wsi);
}

static void queue_json(foxview *v, json_buffer *j)
{
    queue_octets(v, NULL, 0, j->at, j->count, false);
    free(j->at);
    *j = (json_buffer){.at = NULL};
}

static void put_little(unsigned char *at, uint64_t value, size_t size)
{
    for (size_t i = 0; i < size; i++) at[i] = (unsigned char)(value >> 8 * i);
}

static uint32_t little_u32(const unsigned char *at)
{
    return (uint32_t)at[0] | (uint32_t)at[1] << 8 | (uint32_t)at[2] << 16 | (uint32_t)at[3] << 24;
}

static void queue_message(foxview *v, foxglove_topic topic, int64_t stamp_ns, json_buffer *j)
{
    unsigned char head[MESSAGE_HEAD] = {OP_MESSAGE};
    put_little(head + 1, v->subscriptions[topic], 4);
    put_little(head + 5, (uint64_t)stamp_ns, 8);
    queue_octets(v, head, sizeof head, j->at, j->count, true);
    j->count = 0;
}

/* ---- the greeting ---- */

static void queue_info(foxview *v)
{
    json_buffer j = {.at = NULL};
    json_buffer_print(&j,
        "{\"op\":\"serverInfo\",\"name\":\"collided-web %s\",\"capabilities\":[\"services\"],"
        "\"supportedEncodings\":[\"json\"],\"metadata\":{},\"sessionId\":\"%" PRId64 "\"}",
        collided_version(), v->epoch);
    queue_json(v, &j);
}

static void queue_channels(foxview *v)
{
    json_buffer j = {.at = NULL};
    json_buffer_raw(&j, "{\"op\":\"advertise\",\"channels\":[");
    for (int i = 0; i < FOXGLOVE_TOPICS; i++) {
        const foxglove_channel *c = &foxglove_channels[i];
        json_buffer_print(&j,
            "%s{\"id\":%d,\"topic\":\"%s\",\"encoding\":\"json\",\"schemaName\":\"%s\",\"schema\":", i ? "," : "",
            i + 1, c->topic, c->schema_name);
        json_buffer_text(&j, c->schema);
        json_buffer_raw(&j, ",\"schemaEncoding\":\"jsonschema\"}");
    }
    json_buffer_raw(&j, "]}");
    queue_json(v, &j);
}

static void queue_services(foxview *v)
{
    static const char *const NAMES[FOXVIEW_SERVICES] = {"/collided/explain", "/collided/distance"};
    static const char REQUEST[] = "{\"type\":\"object\",\"title\":\"collided.Pair\",\"properties\":{\"a\":{\"type\":"
                                  "\"string\"},\"b\":{\"type\":\"string\"}},\"required\":[\"a\",\"b\"]}";
    static const char RESPONSE[] =
        "{\"type\":\"object\",\"title\":\"collided.Answer\",\"properties\":{\"status\":{\"type\":\"string\"},\"text\":"
        "{\"type\":\"string\"},\"lo\":{\"type\":\"number\"},\"hi\":{\"type\":\"number\"}},\"required\":[\"status\"]}";
    json_buffer j = {.at = NULL};
    json_buffer_raw(&j, "{\"op\":\"advertiseServices\",\"services\":[");
    for (int i = 0; i < FOXVIEW_SERVICES; i++) {
        json_buffer_print(&j,
            "%s{\"id\":%d,\"name\":\"%s\",\"type\":\"collided.Pair\",\"request\":{\"encoding\":\"json\","
            "\"schemaName\":\"collided.Pair\",\"schemaEncoding\":\"jsonschema\",\"schema\":",
            i ? "," : "", i + 1, NAMES[i]);
        json_buffer_text(&j, REQUEST);
        json_buffer_raw(&j, "},\"response\":{\"encoding\":\"json\",\"schemaName\":\"collided.Answer\","
                            "\"schemaEncoding\":\"jsonschema\",\"schema\":");
        json_buffer_text(&j, RESPONSE);
        json_buffer_raw(&j, "}}");
    }
    json_buffer_raw(&j, "]}");
    queue_json(v, &j);
}

bool foxview_may(struct lws *wsi, const web *w)
{
    char path[256] = "";
    if (lws_hdr_copy(wsi, path, sizeof path, WSI_TOKEN_GET_URI) <= 0 && *w->options.token) return false;
    const char *slash = strrchr(path, '/');
    return gate_token(slash ? slash + 1 : "", &w->options);
}

static void on_foxview_timer(lws_sorted_usec_list_t *timer)
{
    foxview *v = lws_container_of(timer, foxview, timer);
    v->due = true;
    lws_callback_on_writable(v->wsi);
    lws_sul_schedule(v->web->context, 0, &v->timer, on_foxview_timer, (lws_usec_t)(1e6 / v->web->options.rate_hz));
}

void foxview_open(web *w, foxview *v, struct lws *wsi)
{
    *v = (foxview){.web = w, .wsi = wsi, .next = w->foxviews, .epoch = w->epoch};
    w->foxviews = v;
    w->viewer_count++;
    v->next_event = w->mirror->event_count + 1;
    queue_info(v);
    queue_channels(v);
    queue_services(v);
    on_foxview_timer(&v->timer);
}

void foxview_close(foxview *v)
{
    web *w = v->web;
    if (!w) return;
    lws_sul_schedule(w->context, 0, &v->timer, NULL, LWS_SET_TIMER_USEC_CANCEL);
    for (foxview **at = &w->foxviews; *at; at = &(*at)->next) {
        if (*at != v) continue;
        *at = v->next;
        w->viewer_count--;
        break;
    }
    for (fox_message *m = v->first, *next; m; m = next) {
        next = m->next;
        free(m);
    }
    v->web = NULL;
    feed_watch(w);
}

void foxview_needs(const web *w, bool *looks, bool *watches)
{
    for (const foxview *v = w->foxviews; v; v = v->next) {
        for (int i = 0; i < FOXGLOVE_TOPICS; i++) *looks |= v->wants[i]; /* stamps come with the scene */
        *watches |= v->wants[FOXGLOVE_CONTACTS] || v->wants[FOXGLOVE_DISTANCES] || v->wants[FOXGLOVE_EVENTS] ||
                    v->wants[FOXGLOVE_LOG];
    }
}

/* ---- what it says ---- */

typedef struct fox_reading { /* of a JSON text */
    foxview *view;
    char op[32], a[256], b[256];
    bool has_a, has_b, has_id, has_channel, known;
    uint32_t id, channel;
} fox_reading;

static const char *const FOX_PATHS[] = {
    "op", "subscriptions[].id", "subscriptions[].channelId", "subscriptionIds[]", "a", "b"};
enum { PATH_OP = 1, PATH_ID, PATH_CHANNEL, PATH_ENDED, PATH_A, PATH_B };

static void subscribe_fox(fox_reading *r)
{
    if (!r->has_id || !r->has_channel) return;
    r->has_id = r->has_channel = false;
    foxview *v = r->view;
    if (!v || r->channel < 1 || r->channel > FOXGLOVE_TOPICS) return;
    foxglove_topic topic = (foxglove_topic)(r->channel - 1);
    v->wants[topic] = true;
    v->subscriptions[topic] = r->id;
    if (topic == FOXGLOVE_SCENE) v->scene = 0, v->scene_ns = 0;
    if (topic == FOXGLOVE_TRANSFORMS) v->posed = 0, v->posed_ns = 0;
    if (topic == FOXGLOVE_CONTACTS || topic == FOXGLOVE_DISTANCES) v->contacts = 0;
    if (topic == FOXGLOVE_EVENTS || topic == FOXGLOVE_LOG) v->next_event = v->web->mirror->event_count + 1;
}

static void unsubscribe_fox(foxview *v, uint32_t id)
{
    for (int i = 0; v && i < FOXGLOVE_TOPICS; i++)
        if (v->wants[i] && v->subscriptions[i] == id) v->wants[i] = false;
}

static void append_text(char *to, size_t room, const struct lejp_ctx *c)
{
    size_t used = strlen(to), n = c->npos < room - 1 - used ? c->npos : room - 1 - used;
    memcpy(to + used, c->buf, n);
    to[used + n] = '\0';
}

static signed char on_fox_json(struct lejp_ctx *c, char reason)
{
    fox_reading *r = c->user;
    bool text = reason == LEJPCB_VAL_STR_CHUNK || reason == LEJPCB_VAL_STR_END;
    if (text && c->path_match == PATH_OP) append_text(r->op, sizeof r->op, c);
    if (text && c->path_match == PATH_A) append_text(r->a, sizeof r->a, c), r->has_a = true;
    if (text && c->path_match == PATH_B) append_text(r->b, sizeof r->b, c), r->has_b = true;
    if (reason != LEJPCB_VAL_NUM_INT) return 0;
    uint32_t n = (uint32_t)strtoul(c->buf, NULL, 10);
    if (c->path_match == PATH_ID) r->id = n, r->has_id = true;
    if (c->path_match == PATH_CHANNEL) r->channel = n, r->has_channel = true;
    if (c->path_match == PATH_ENDED) unsubscribe_fox(r->view, n);
    if (c->path_match == PATH_ID || c->path_match == PATH_CHANNEL) subscribe_fox(r);
    return 0;
}

static bool read_fox(fox_reading *r, const char *text, size_t size)
{
    struct lejp_ctx c;
    lejp_construct(&c, on_fox_json, r, FOX_PATHS, sizeof FOX_PATHS / sizeof FOX_PATHS[0]);
    int end = lejp_parse(&c, (const unsigned char *)text, (int)size);
    lejp_destruct(&c);
    return end >= 0;
}

static void queue_status(foxview *v, const char *message)
{
    json_buffer j = {.at = NULL};
    json_buffer_raw(&j, "{\"op\":\"status\",\"level\":1,\"message\":");
    json_buffer_text(&j, message);
    json_buffer_raw(&j, "}");
    queue_json(v, &j);
}

static void put_finite_member(json_buffer *j, const char *name, double value)
{
    if (value > -1e300 && value < 1e300) json_buffer_print(j, ",\"%s\":%.17g", name, value);
}

static void answer_call(foxview *v, uint32_t service, const fox_reading *r, json_buffer *j)
{
    collided_result answer = {0};
    collided *c = v->web->client;
    collided_status status =
        service == 1 ? collided_query_explain(c, r->a, r->b, FOXVIEW_PATIENCE_S, &answer)
                     : collided_query_distance(c, r->a, r->b, v->web->options.tolerance_m, FOXVIEW_PATIENCE_S, &answer);
    json_buffer_raw(j, "{\"status\":");
    json_buffer_text(j, status == COLLIDED_OK ? "ok" : collided_status_text(status));
    json_buffer_raw(j, ",\"text\":");
    json_buffer_text(j, answer.text ? answer.text : "");
    if (service == 2 && status == COLLIDED_OK && answer.count) {
        put_finite_member(j, "lo", answer.hits[0].lo);
        put_finite_member(j, "hi", answer.hits[0].hi);
    }
    json_buffer_raw(j, "}");
    collided_result_free(&answer);
}

static void refuse_call(foxview *v, uint32_t service, uint32_t call, const char *why)
{
    json_buffer j = {.at = NULL};
    json_buffer_print(&j, "{\"op\":\"serviceCallFailure\",\"serviceId\":%u,\"callId\":%u,\"message\":", service, call);
    json_buffer_text(&j, why);
    json_buffer_raw(&j, "}");
    queue_json(v, &j);
}

/* opcode, service, call, length of the encoding's name, that, and the request. */
static void take_call(foxview *v, const unsigned char *at, size_t size)
{
    if (size < CALL_HEAD || at[0] != OP_SERVICE_CALL) {
        queue_status(v, "this server takes no such binary message");
        return;
    }
    uint32_t service = little_u32(at + 1), call = little_u32(at + 5), name = little_u32(at + 9);
    fox_reading r = {.view = NULL};
    bool whole = name <= size - CALL_HEAD;
    bool json = whole && name == 4 && memcmp(at + CALL_HEAD, "json", 4) == 0;
    if (service < 1 || service > FOXVIEW_SERVICES || !json) {
        refuse_call(v, service, call, json ? "there is no such service" : "requests are JSON (encoding json)");
        return;
    }
    bool read = read_fox(&r, (const char *)at + CALL_HEAD + name, size - CALL_HEAD - name) && r.has_a && r.has_b;
    if (!read || !v->web->connected) {
        refuse_call(v, service, call, read ? "no daemon is heard" : "a request is {\"a\": NAME, \"b\": NAME}");
        return;
    }
    json_buffer j = {.at = NULL};
    unsigned char head[CALL_HEAD + 4] = {OP_SERVICE_RESPONSE};
    put_little(head + 1, service, 4);
    put_little(head + 5, call, 4);
    put_little(head + 9, 4, 4);
    memcpy(head + CALL_HEAD, (const char[4]){'j', 's', 'o', 'n'}, 4);
    answer_call(v, service, &r, &j);
    queue_octets(v, head, sizeof head, j.at, j.count, true);
    free(j.at);
}

static void take_text_message(foxview *v, const char *text, size_t size)
{
    fox_reading r = {.view = v};
    bool read = read_fox(&r, text, size);
    bool known = strcmp(r.op, "subscribe") == 0 || strcmp(r.op, "unsubscribe") == 0;
    if (!read || !known) queue_status(v, read ? "this server does not know that op" : "that was no JSON");
    feed_watch(v->web);
    v->due = true;
    lws_callback_on_writable(v->wsi);
}

int foxview_receive(foxview *v, const char *data, size_t size, bool final, bool binary)
{
    if (v->close_code) return 0;
    if (v->text_size + size > REQUEST_MAX) {
        end_foxview(v, CLOSE_TOO_LARGE, "a message has at most 4096 bytes");
        return 0;
    }
    memcpy(v->text + v->text_size, data, size);
    v->text_size += size;
    if (!final) return 0;
    size = v->text_size;
    v->text_size = 0;
    if (binary)
        take_call(v, (const unsigned char *)v->text, size);
    else
        take_text_message(v, v->text, size);
    return 0;
}

/* ---- what it is sent ---- */

static void queue_scene_of(foxview *v, json_buffer *j)
{
    const mirror *m = v->web->mirror;
    uint64_t looks = foxglove_looks(m);
    bool changed = m->scene > v->scene || looks != v->looks;
    if (!v->wants[FOXGLOVE_SCENE] || !m->live || !changed) return;
    if (v->scene_ns && m->stamp_ns - v->scene_ns < SECOND_NS) return;
    foxglove_scene(j, m, &v->web->kept, m->stamp_ns);
    queue_message(v, FOXGLOVE_SCENE, m->stamp_ns, j);
    v->scene = m->changes;
    v->looks = looks;
    v->scene_ns = m->stamp_ns;
}

static void queue_transforms_of(foxview *v, json_buffer *j)
{
    const mirror *m = v->web->mirror;
    bool all = m->live <= COMPLETE_BODIES || !v->posed || m->stamp_ns - v->posed_ns >= SECOND_NS;
    if (!v->wants[FOXGLOVE_TRANSFORMS] || m->poses <= v->posed) return;
    if (foxglove_transforms(j, m, all ? 0 : v->posed, m->stamp_ns))
        queue_message(v, FOXGLOVE_TRANSFORMS, m->stamp_ns, j);
    j->count = 0;
    v->posed = m->changes;
    if (all) v->posed_ns = m->stamp_ns;
}

static void queue_contacts_of(foxview *v, json_buffer *j)
{
    const mirror *m = v->web->mirror;
    if (m->contacts_change <= v->contacts) return;
    if (v->wants[FOXGLOVE_CONTACTS]) {
        foxglove_contacts(j, m, m->stamp_ns);
        queue_message(v, FOXGLOVE_CONTACTS, m->stamp_ns, j);
    }
    if (v->wants[FOXGLOVE_DISTANCES]) {
        foxglove_distances(j, m, m->stamp_ns);
        queue_message(v, FOXGLOVE_DISTANCES, m->stamp_ns, j);
    }
    v->contacts = m->changes;
}

/* Events that the mirror has no more are told as a gap. */
static void queue_events_of(foxview *v, json_buffer *j)
{
    const mirror *m = v->web->mirror;
    uint64_t oldest = m->event_count > MIRROR_EVENTS ? m->event_count - MIRROR_EVENTS + 1 : 1;
    if (v->next_event < oldest) {
        queue_status(v, "events were missed: more came at once than are kept");
        v->next_event = oldest;
    }
    for (; !v->close_code && v->next_event <= m->event_count; v->next_event++) {
        const mirror_event *e = &m->events[(v->next_event - 1) % MIRROR_EVENTS];
        if (v->wants[FOXGLOVE_EVENTS]) {
            foxglove_event(j, m, e);
            queue_message(v, FOXGLOVE_EVENTS, e->stamp_ns, j);
        }
        if (v->wants[FOXGLOVE_LOG]) {
            foxglove_event_log(j, m, e);
            queue_message(v, FOXGLOVE_LOG, e->stamp_ns, j);
        }
    }
}

static int send_first(foxview *v)
{
    fox_message *m = v->first;
    v->first = m->next;
    if (!v->first) v->last = NULL;
    v->waiting -= m->size;
    int sent = lws_write(v->wsi, m->at + LWS_PRE, m->size, m->binary ? LWS_WRITE_BINARY : LWS_WRITE_TEXT);
    free(m);
    lws_callback_on_writable(v->wsi);
    return sent < 0 ? -1 : 0;
}

/* States are put together once all that waited is sent, so that a slow viewer gets fewer of them. */
int foxview_write(foxview *v)
{
    if (v->close_code) {
        lws_close_reason(
            v->wsi, (enum lws_close_status)v->close_code, (unsigned char *)v->close_why, strlen(v->close_why));
        return -1;
    }
    if (!v->first && v->due) {
        json_buffer j = {.at = NULL};
        v->due = false;
        queue_scene_of(v, &j);
        queue_transforms_of(v, &j);
        queue_contacts_of(v, &j);
        free(j.at);
    }
    return v->first ? send_first(v) : 0;
}

/* One in a round, since the question waits for its answer. */
static void ask_geometry(web *w)
{
    if (!w->foxviews || !w->connected || w->asked >= w->mirror->geometry_count) return;
    const mirror_geometry *g = &w->mirror->geometries[w->asked];
    collided_geometry_numbers numbers = {0};
    collided_geometry hash = {g->hash};
    const char *body = w->mirror->bodies[g->body].name;
    if (collided_query_geometry(w->client, body, hash, FOXVIEW_PATIENCE_S, &numbers) == COLLIDED_OK)
        triangles_put(&w->kept, w->asked, &numbers);
    collided_geometry_numbers_free(&numbers);
    w->asked++;
    for (foxview *v = w->foxviews; v; v = v->next) v->scene = 0; /* it is drawn now */
}

void foxview_news(web *w)
{
    json_buffer j = {.at = NULL};
    ask_geometry(w);
    for (foxview *v = w->foxviews; v; v = v->next) {
        if (w->epoch && !v->epoch) v->epoch = w->epoch;
        /* Stamps may go back: a new session, which viewers begin anew. */
        if (w->epoch >> 16 != v->epoch >> 16) end_foxview(v, CLOSE_OTHER_DAEMON, "another daemon: connect again");
        queue_events_of(v, &j);
    }
    free(j.at);
}
