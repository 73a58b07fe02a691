/* foxglove_events: contacts as a picture, counts and distances as numbers to plot, and events, each as an object and as
 * a line of a log. */
#include "foxglove.h"

#include "foxglove_put.h"

#include <stdio.h>
#include <string.h>

enum { TOUCHING = 1, NEAR = 4, UNKNOWN = 6, PREDICTED = 9, GAP = 255, CONTACTS_DRAWN = 10000 };

static const char *const CAUSES[] = {
    "motion", "removed", "owner_lost", "filter", "shape", "subscription", "shutdown", "stale", "snapshot", "teleport"};

static const char *kind_of(uint8_t kind)
{
    static const char *const KINDS[] = {
        "", "begin", "update", "end", "near", "far", "unknown", "known", "impact", "predicted", "averted"};
    if (kind == GAP) return "gap";
    return kind < sizeof KINDS / sizeof KINDS[0] ? KINDS[kind] : "";
}

static const char *name_of_body(const mirror *m, uint32_t place)
{
    return place < m->body_count ? m->bodies[place].name : "*";
}

/* ---- what holds ---- */

static bool is_drawn(const mirror_contact *c)
{
    bool finite = true;
    for (int i = 0; i < 3; i++) finite &= isfinite(c->point_a[i]) && isfinite(c->point_b[i]);
    return finite && c->kind != UNKNOWN;
}

static foxglove_color contact_color(const mirror_contact *c)
{
    if (c->kind == TOUCHING) return (foxglove_color){0.85, 0.1, 0.1, 1};
    return c->kind == PREDICTED ? (foxglove_color){0.6, 0.2, 0.8, 1} : (foxglove_color){0.95, 0.6, 0.1, 1};
}

static void put_points(json_buffer *j, const mirror *m)
{
    size_t drawn = 0;
    for (size_t i = 0; i < m->contact_count && drawn < CONTACTS_DRAWN; i++) {
        if (!is_drawn(&m->contacts[i])) continue;
        for (int end = 0; end < 2; end++) {
            const double *p = end ? m->contacts[i].point_b : m->contacts[i].point_a;
            json_buffer_print(j, "%s{\"x\":%.9g,\"y\":%.9g,\"z\":%.9g}", drawn || end ? "," : "", p[0], p[1], p[2]);
        }
        drawn++;
    }
}

static void put_colors(json_buffer *j, const mirror *m)
{
    size_t drawn = 0;
    for (size_t i = 0; i < m->contact_count && drawn < CONTACTS_DRAWN; i++) {
        if (!is_drawn(&m->contacts[i])) continue;
        foxglove_color c = contact_color(&m->contacts[i]);
        for (int end = 0; end < 2; end++)
            json_buffer_print(
                j, "%s{\"r\":%g,\"g\":%g,\"b\":%g,\"a\":%g}", drawn || end ? "," : "", c.r, c.g, c.b, c.a);
        drawn++;
    }
}

static void put_ends(json_buffer *j, const mirror *m)
{
    size_t drawn = 0;
    for (size_t i = 0; i < m->contact_count && drawn < CONTACTS_DRAWN; i++) {
        const mirror_contact *c = &m->contacts[i];
        if (!is_drawn(c)) continue;
        for (int end = 0; end < 2; end++) {
            collided_pose p = {{0, 0, 0}, {1, 0, 0, 0}};
            memcpy(p.position, end ? c->point_b : c->point_a, sizeof p.position);
            json_buffer_raw(j, drawn || end ? ",{" : "{");
            foxglove_put_pose(j, &p);
            json_buffer_raw(j, ",\"size\":{\"x\":0.01,\"y\":0.01,\"z\":0.01},");
            foxglove_put_color(j, "color", contact_color(c));
            json_buffer_raw(j, "}");
        }
        drawn++;
    }
}

void foxglove_contacts(json_buffer *j, const mirror *m, int64_t stamp_ns)
{
    const collided_pose here = {{0, 0, 0}, {1, 0, 0, 0}};
    json_buffer_raw(j, "{\"deletions\":[],\"entities\":[{");
    foxglove_put_stamp(j, "timestamp", stamp_ns);
    json_buffer_raw(j, ",\"frame_id\":\"world\",\"id\":\"contacts\",\"lifetime\":{\"sec\":0,\"nsec\":0},"
                       "\"frame_locked\":true,\"metadata\":[],\"arrows\":[],\"cubes\":[],\"spheres\":[");
    put_ends(j, m);
    json_buffer_raw(j, "],\"cylinders\":[],\"lines\":[{\"type\":2,");
    foxglove_put_pose(j, &here);
    json_buffer_raw(j, ",\"thickness\":2,\"scale_invariant\":true,\"points\":[");
    put_points(j, m);
    json_buffer_raw(j, "],");
    foxglove_put_color(j, "color", (foxglove_color){0.95, 0.6, 0.1, 1});
    json_buffer_raw(j, ",\"colors\":[");
    put_colors(j, m);
    json_buffer_raw(j, "],\"indices\":[]}],\"triangles\":[],\"texts\":[],\"models\":[]}]}");
}

static void put_finite(json_buffer *j, const char *name, double value)
{
    if (isfinite(value)) json_buffer_print(j, ",\"%s\":%.17g", name, value);
}

static void put_named(json_buffer *j, const char *name, const char *value)
{
    json_buffer_print(j, ",\"%s\":", name);
    json_buffer_text(j, value);
}

void foxglove_distances(json_buffer *j, const mirror *m, int64_t stamp_ns)
{
    size_t counts[PREDICTED + 1] = {0}, stale = 0;
    const mirror_contact *nearest = NULL, *soonest = NULL;
    for (size_t i = 0; i < m->contact_count; i++) {
        const mirror_contact *c = &m->contacts[i];
        counts[c->kind <= PREDICTED ? c->kind : 0]++;
        if (c->kind == PREDICTED && (!soonest || c->lo_s < soonest->lo_s)) soonest = c;
        bool measured = c->kind == TOUCHING || c->kind == NEAR;
        if (measured && (!nearest || c->lo < nearest->lo)) nearest = c;
    }
    for (size_t i = 0; i < m->body_count; i++)
        stale += m->bodies[i].live && m->bodies[i].flags & (COLLIDED_SEEN_STALE | COLLIDED_SEEN_HELD);
    json_buffer_raw(j, "{");
    foxglove_put_stamp(j, "timestamp", stamp_ns);
    json_buffer_print(j,
        ",\"tick\":%" PRId64 ",\"bodies\":%zu,\"stale\":%zu,\"touching\":%zu,\"near\":%zu,\"unknown\":%zu,"
        "\"predicted\":%zu",
        m->tick, m->live, stale, counts[TOUCHING], counts[NEAR], counts[UNKNOWN], counts[PREDICTED]);
    if (nearest) {
        put_finite(j, "nearest_lo", nearest->lo);
        put_finite(j, "nearest_hi", nearest->hi);
        put_finite(j, "nearest_closing", nearest->closing);
        put_named(j, "nearest_a", name_of_body(m, nearest->a));
        put_named(j, "nearest_b", name_of_body(m, nearest->b));
    }
    if (soonest) {
        put_finite(j, "soonest_s", soonest->lo_s);
        put_named(j, "soonest_a", name_of_body(m, soonest->a));
        put_named(j, "soonest_b", name_of_body(m, soonest->b));
    }
    json_buffer_raw(j, "}");
}

/* ---- events ---- */

void foxglove_event(json_buffer *j, const mirror *m, const mirror_event *e)
{
    json_buffer_raw(j, "{");
    foxglove_put_stamp(j, "timestamp", e->stamp_ns);
    put_named(j, "kind", kind_of(e->kind));
    json_buffer_print(j, ",\"contact\":\"%" PRId64 "\",\"tick\":%" PRId64, e->contact, e->tick);
    if (e->kind != GAP) {
        put_named(j, "a", name_of_body(m, e->a));
        put_named(j, "b", name_of_body(m, e->b));
        put_named(j, "cause", e->cause < sizeof CAUSES / sizeof CAUSES[0] ? CAUSES[e->cause] : "unknown");
        if (e->shape_a != UINT32_MAX) json_buffer_print(j, ",\"shape_a\":%u", e->shape_a);
        if (e->shape_b != UINT32_MAX) json_buffer_print(j, ",\"shape_b\":%u", e->shape_b);
        put_finite(j, "lo", e->lo);
        put_finite(j, "hi", e->hi);
        put_finite(j, "closing", e->closing);
        if (e->age_a >= 0) put_finite(j, "age_a", e->age_a);
        if (e->age_b >= 0) put_finite(j, "age_b", e->age_b);
        put_finite(j, "lo_s", e->lo_s);
        put_finite(j, "hi_s", e->hi_s);
        json_buffer_print(j, ",\"achieved\":%u,\"snapshot\":%s", e->achieved, e->snapshot ? "true" : "false");
    }
    json_buffer_raw(j, "}");
}

void foxglove_event_log(json_buffer *j, const mirror *m, const mirror_event *e)
{
    enum { INFO = 2, WARNING = 3 };
    char text[1024];
    bool warns = e->kind == GAP || e->kind == UNKNOWN || e->kind == 8 || e->kind == PREDICTED;
    if (e->kind == GAP)
        snprintf(text, sizeof text, "gap: %" PRId64 " batches were lost", e->contact);
    else
        snprintf(text, sizeof text, "%s: %s and %s: %g .. %g mm", kind_of(e->kind), name_of_body(m, e->a),
            name_of_body(m, e->b), 1e3 * e->lo, 1e3 * e->hi);
    json_buffer_raw(j, "{");
    foxglove_put_stamp(j, "timestamp", e->stamp_ns);
    json_buffer_print(j, ",\"level\":%d", warns ? WARNING : INFO);
    put_named(j, "message", text);
    json_buffer_raw(j, ",\"name\":\"collided\",\"file\":\"\",\"line\":0}");
}
