/* native: see native.h. The thread that runs the client's callbacks. */
#include "native.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { REJECTIONS_MAX = 256 };

struct native_inbox {
    native_batch *first, *last;
    native_rejection rejections[REJECTIONS_MAX]; /* a ring */
    size_t first_rejection, rejection_count, dropped, lost;
};

/* ---- names: each once, found by open addressing ---- */

typedef struct name_set {
    char *text;
    size_t size;
    int32_t *slots; /* ordinal + 1; 0 = free */
    size_t *starts; /* by ordinal: where in the text */
    size_t mask;
    int32_t count;
} name_set;

static size_t hash_of(const char *name)
{
    uint64_t hash = UINT64_C(14695981039346656037); /* FNV-1a */
    for (; *name; name++) hash = (hash ^ (unsigned char)*name) * UINT64_C(1099511628211);
    return (size_t)(hash ^ hash >> 32);
}

static int32_t ordinal_of(name_set *set, const char *name)
{
    size_t at = hash_of(name) & set->mask;
    for (; set->slots[at]; at = (at + 1) & set->mask)
        if (strcmp(set->text + set->starts[set->slots[at] - 1], name) == 0) return set->slots[at] - 1;
    size_t length = strlen(name) + 1;
    memcpy(set->text + set->size, name, length);
    set->starts[set->count] = set->size;
    set->size += length;
    set->slots[at] = ++set->count;
    return set->count - 1;
}

/* ---- a batch in one piece ---- */

typedef struct sizes {
    size_t points, impacts, names, slots;
} sizes;

static sizes sizes_of(const collided_batch *b)
{
    sizes s = {0, 0, 1, 2};
    for (size_t i = 0; i < b->event_count; i++) {
        const collided_event *e = &b->events[i];
        s.points += e->point_count;
        s.impacts += e->impact != NULL;
        s.names += strlen(e->name_a) + strlen(e->name_b) + 2;
    }
    while (s.slots < 4 * b->event_count) s.slots *= 2;
    return s;
}

static void copy_pose(double position[3], double wxyz[4], const collided_pose *pose)
{
    memcpy(position, pose->position, sizeof pose->position);
    memcpy(wxyz, pose->orientation, sizeof pose->orientation);
}

static void copy_impact(native_batch *batch, const collided_impact *i)
{
    native_impact *out = &batch->impacts[batch->impact_count++];
    *out = (native_impact){.lo_s = i->lo_s, .hi_s = i->hi_s, .start_ns = i->start_ns, .estimated = i->estimated};
    copy_pose(out->position_a, out->wxyz_a, &i->pose_a);
    copy_pose(out->position_b, out->wxyz_b, &i->pose_b);
}

static void copy_event(native_batch *batch, name_set *names, const collided_event *e)
{
    native_event *out = &batch->events[batch->event_count++];
    *out = (native_event){.contact = e->contact,
        .lo = e->lo,
        .hi = e->hi,
        .age_a_s = e->age_a_s,
        .age_b_s = e->age_b_s,
        .closing_m_s = e->closing_m_s,
        .kind = (int32_t)e->kind,
        .achieved = (int32_t)e->achieved,
        .a = ordinal_of(names, e->name_a),
        .b = ordinal_of(names, e->name_b),
        .shape_a = e->shape_a,
        .shape_b = e->shape_b,
        .first_point = (int32_t)batch->point_count,
        .points = (int32_t)e->point_count,
        .impact = e->impact ? (int32_t)batch->impact_count : -1};
    memcpy(out->axis, e->axis, sizeof out->axis);
    memcpy(out->point_a, e->point_a, sizeof out->point_a);
    memcpy(out->point_b, e->point_b, sizeof out->point_b);
    (void)snprintf(out->cause, sizeof out->cause, "%s", e->cause);
    if (e->point_count) memcpy(batch->points + batch->point_count, e->points, e->point_count * sizeof *e->points);
    batch->point_count += e->point_count;
    if (e->impact) copy_impact(batch, e->impact);
}

/* What follows the head lies behind it, the names last: all else has the alignment of a double. */
static native_batch *room_for(const collided_batch *b, const sizes *s)
{
    native_batch *batch = malloc(sizeof *batch + b->event_count * sizeof *batch->events +
                                 s->points * sizeof *batch->points + s->impacts * sizeof *batch->impacts + s->names);
    if (!batch) return NULL;
    *batch = (native_batch){.head = *b};
    batch->events = (native_event *)(batch + 1);
    batch->points = (collided_contact_point *)(batch->events + b->event_count);
    batch->impacts = (native_impact *)(batch->points + s->points);
    batch->names = (char *)(batch->impacts + s->impacts);
    return batch;
}

static native_batch *copy_of(const collided_batch *b)
{
    sizes s = sizes_of(b);
    native_batch *batch = room_for(b, &s);
    name_set names = {.slots = calloc(s.slots, sizeof *names.slots),
        .starts = calloc(2 * b->event_count + 1, sizeof *names.starts),
        .mask = s.slots - 1};
    if (batch && names.slots && names.starts) {
        names.text = batch->names;
        for (size_t i = 0; i < b->event_count; i++) copy_event(batch, &names, &b->events[i]);
        batch->names_size = names.size;
        (void)snprintf(batch->refusal, sizeof batch->refusal, "%s", b->refusal ? b->refusal : "");
    } else {
        free(batch);
        batch = NULL;
    }
    free(names.slots);
    free(names.starts);
    return batch;
}

static void on_batch(void *context, const collided_batch *b)
{
    native_inbox *inbox = context;
    native_batch *batch = copy_of(b);
    if (!batch) {
        inbox->lost++;
        return;
    }
    if (inbox->last)
        inbox->last->next = batch;
    else
        inbox->first = batch;
    inbox->last = batch;
}

static void on_rejected(void *context, const collided_rejection *why)
{
    native_inbox *inbox = context;
    if (inbox->rejection_count == REJECTIONS_MAX) {
        inbox->dropped++;
        return;
    }
    native_rejection *r = &inbox->rejections[(inbox->first_rejection + inbox->rejection_count++) % REJECTIONS_MAX];
    r->object = why->object;
    (void)snprintf(r->message, sizeof r->message, "%s", why->message);
    (void)snprintf(r->reason, sizeof r->reason, "%s", why->reason);
    (void)snprintf(r->text, sizeof r->text, "%s", why->text ? why->text : "");
}

/* ---- what Python calls ---- */

native_inbox *native_open(collided *c)
{
    native_inbox *inbox = calloc(1, sizeof *inbox);
    if (inbox) collided_on_rejected(c, on_rejected, inbox);
    return inbox;
}

void native_close(native_inbox *inbox)
{
    for (native_batch *b = native_take(inbox); b; b = native_take(inbox)) native_free(b);
    free(inbox);
}

collided_subscription native_subscribe(native_inbox *inbox, collided *c, const collided_subscription_def *def)
{
    collided_subscription_def ours = *def;
    ours.callback = on_batch;
    ours.context = inbox;
    return collided_subscribe(c, &ours);
}

native_batch *native_take(native_inbox *inbox)
{
    native_batch *batch = inbox->first;
    if (!batch) return NULL;
    inbox->first = batch->next;
    if (!inbox->first) inbox->last = NULL;
    batch->next = NULL;
    return batch;
}

void native_free(native_batch *batch)
{
    free(batch);
}

bool native_take_rejection(native_inbox *inbox, native_rejection *out)
{
    if (!inbox->rejection_count) return false;
    *out = inbox->rejections[inbox->first_rejection];
    inbox->first_rejection = (inbox->first_rejection + 1) % REJECTIONS_MAX;
    inbox->rejection_count--;
    return true;
}

size_t native_dropped(native_inbox *inbox)
{
    size_t dropped = inbox->dropped;
    inbox->dropped = 0;
    return dropped;
}

size_t native_lost(native_inbox *inbox)
{
    size_t lost = inbox->lost;
    inbox->lost = 0;
    return lost;
}

void native_wxyz(double *out, const double *xyzw, size_t count)
{
    for (size_t i = 0; i < count; i++) {
        out[4 * i] = xyzw[4 * i + 3];
        memcpy(out + 4 * i + 1, xyzw + 4 * i, 3 * sizeof(double));
    }
}
