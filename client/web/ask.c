/* ask: questions of a page, put to the daemon and answered one at a time. */
#include "web.h"
#include "window/json_buffer.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#define PATIENCE_S 1.0

static void put_hit(json_buffer *j, const collided_hit *h, bool is_body)
{
    json_buffer_raw(j, "{");
    json_buffer_name(j, "name_a");
    json_buffer_text(j, h->name_a);
    json_buffer_name(j, "name_b");
    json_buffer_text(j, h->name_b);
    json_buffer_name(j, "age_s");
    json_buffer_number(j, h->age_s);
    json_buffer_name(j, "stale");
    json_buffer_flag(j, h->stale);
    if (is_body) {
        json_buffer_name(j, "position");
        json_buffer_numbers(j, h->point_a, 3);
        json_buffer_name(j, "orientation");
        json_buffer_numbers(j, h->orientation, 4);
    } else {
        json_buffer_name(j, "lo");
        json_buffer_number(j, h->lo);
        json_buffer_name(j, "hi");
        json_buffer_number(j, h->hi);
        json_buffer_name(j, "axis");
        json_buffer_numbers(j, h->axis, 3);
        json_buffer_name(j, "point_a");
        json_buffer_numbers(j, h->point_a, 3);
        json_buffer_name(j, "point_b");
        json_buffer_numbers(j, h->point_b, 3);
        json_buffer_name(j, "achieved");
        json_buffer_count(j, h->achieved);
    }
    json_buffer_raw(j, "}");
}

static void answer(web *w, viewer *v, const request *q, const char *status, const collided_result *r)
{
    json_buffer j = {0};
    json_buffer_raw(&j, "{");
    json_buffer_name(&j, "id");
    json_buffer_count(&j, q->id);
    json_buffer_name(&j, "status");
    json_buffer_text(&j, status);
    json_buffer_name(&j, "text");
    json_buffer_text(&j, r && r->text ? r->text : "");
    json_buffer_name(&j, "tick");
    json_buffer_whole(&j, r ? r->tick : 0);
    json_buffer_name(&j, "hits");
    json_buffer_raw(&j, "[");
    bool is_body = strcmp(q->what, "body") == 0, first = true;
    for (size_t i = 0; r && i < r->count; i++) {
        if (is_body && strcmp(r->hits[i].name_a, q->a) != 0) continue; /* a name may look like a pattern */
        if (!first) json_buffer_raw(&j, ",");
        put_hit(&j, &r->hits[i], is_body);
        first = false;
    }
    json_buffer_raw(&j, "]}");
    frame_text(&w->scratch, FRAME_ANSWER, w->mirror, j.at);
    viewer_queue(v, &w->scratch);
    free(j.at);
}

static void answer_geometry(web *w, viewer *v, const request *q)
{
    collided_geometry_numbers numbers = {0};
    collided_status status = COLLIDED_UNKNOWN_ID;
    if (q->number < w->mirror->geometry_count) {
        const mirror_geometry *g = &w->mirror->geometries[q->number];
        collided_geometry hash = {g->hash};
        status = collided_query_geometry(w->client, w->mirror->bodies[g->body].name, hash, PATIENCE_S, &numbers);
    }
    frame_geometry(&w->scratch, w->mirror, (uint32_t)q->number, q->id, status == COLLIDED_OK ? &numbers : NULL);
    viewer_queue(v, &w->scratch);
    collided_geometry_numbers_free(&numbers);
}

void ask_answer(web *w, viewer *v, const request *q)
{
    collided_result r = {0};
    double tolerance = isnan(q->tolerance_m) ? 1e-6 : q->tolerance_m;
    collided_status status = COLLIDED_BAD_ARGUMENT;
    if (!w->connected) {
        answer(w, v, q, collided_status_text(COLLIDED_NO_DAEMON), NULL);
        return;
    }
    if (strcmp(q->what, "geometry") == 0) {
        answer_geometry(w, v, q);
        return;
    }
    if (strcmp(q->what, "explain") == 0) status = collided_query_explain(w->client, q->a, q->b, PATIENCE_S, &r);
    if (strcmp(q->what, "distance") == 0)
        status = collided_query_distance(w->client, q->a, q->b, tolerance, PATIENCE_S, &r);
    if (strcmp(q->what, "body") == 0) status = collided_query_bodies(w->client, q->a, PATIENCE_S, &r);
    answer(w, v, q, status == COLLIDED_OK ? "ok" : collided_status_text(status), &r);
    collided_result_free(&r);
}
