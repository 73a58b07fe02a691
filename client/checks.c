/* checks: configurations and motions of a robot, asked in portions that a message holds and that the daemon answers
 * within a few milliseconds; what it had no time for is asked again. The caller's thread. */
#include "allocate.h"
#include "message.h"
#include "observe.h"
#include "session.h"
#include "session_run.h"

#include "wire/wire_extensions.h"
#include "wire/wire_robot.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

typedef struct check_work {
    collided *c;
    wire_robot_question head;
    wire_joint joints[WIRE_JOINTS_MAX];
    const double *numbers;
    size_t each; /* numbers an item */
    collided_checked *out;
    char **names; /* each once; moved into the answer's own block at the end */
    size_t name_count;
    wire_checked items[WIRE_CHECK_ITEMS_MAX];
} check_work;

collided_check_options collided_check_options_default(void)
{
    return (collided_check_options){.resolution_m = 1e-4, .find_first = true, .tolerance_m = 1e-6};
}

static collided_status copy_joints(collided *c, const collided_robot *r, wire_joint *joints)
{
    if (r->joint_count < 1 || r->joint_count > WIRE_JOINTS_MAX)
        return session_fail(
            c, COLLIDED_BAD_ARGUMENT, "a robot has 1 to %d joints, and this one %zu", WIRE_JOINTS_MAX, r->joint_count);
    for (size_t i = 0; i < r->joint_count; i++) {
        const collided_joint *from = &r->joints[i];
        wire_joint *to = &joints[i];
        const char *body = from->body ? from->body : "";
        if (strlen(body) > WIRE_NAME_MAX)
            return session_fail(
                c, COLLIDED_BAD_ARGUMENT, "joint %zu: the name of its body is longer than %d bytes", i, WIRE_NAME_MAX);
        *to = (wire_joint){.parent = from->parent,
            .type = (int32_t)from->type,
            .mimic = from->mimics ? from->mimic : -1,
            .lower = from->lower,
            .upper = from->upper,
            .factor = from->factor,
            .offset = from->offset};
        memcpy(to->origin, from->origin.position, sizeof from->origin.position);
        memcpy(to->origin + 3, from->origin.orientation, sizeof from->origin.orientation);
        memcpy(to->axis, from->axis, sizeof to->axis);
        memcpy(to->body, body, strlen(body) + 1);
    }
    return COLLIDED_OK;
}

/* As many items as a message takes: all of them, or a part. */
static size_t portion(const check_work *w, size_t left)
{
    wire_robot_question none = w->head;
    none.item_count = 0;
    size_t room = WIRE_EXTENSIONS_MAX - WIRE_EXTENSION_HEAD - wire_robot_size(&none, w->joints);
    size_t most = w->each > 0 ? room / (8 * w->each) : WIRE_CHECK_ITEMS_MAX;
    if (w->each > 0 && most > WIRE_CHECK_NUMBERS_MAX / w->each) most = WIRE_CHECK_NUMBERS_MAX / w->each;
    if (most > WIRE_CHECK_ITEMS_MAX) most = WIRE_CHECK_ITEMS_MAX;
    return left < most ? left : most;
}

/* A copy of the name that lives as long as the answer. */
static const char *keep_name(check_work *w, const wire_answer *a, int32_t place)
{
    if (place < 0 || (uint32_t)place >= a->names_a.count) return NULL;
    const char *name = a->names_a.at[place];
    for (size_t i = 0; i < w->name_count; i++)
        if (strcmp(w->names[i], name) == 0) return w->names[i];
    size_t bytes = strlen(name) + 1;
    w->names = reallocate(w->names, w->name_count + 1, sizeof *w->names);
    w->names[w->name_count] = memcpy(allocate(1, bytes), name, bytes);
    return w->names[w->name_count++];
}

/* Fills in the items from `first` on that the answer tells, up to the first one that is not done: how many. */
static collided_status take_answer(check_work *w, const wire_answer *a, size_t first, size_t asked, size_t *done)
{
    wire_u8s rest = a->extensions;
    wire_extension e = {0};
    size_t count = 0;
    while (wire_extension_next(&rest, &e) && e.id != WIRE_EXTENSION_CHECKED) e.id = 0;
    if (e.id != WIRE_EXTENSION_CHECKED || !wire_checked_read(e.bytes, w->items, &count) || count != asked)
        return session_fail(
            w->c, COLLIDED_TRANSPORT, "the answer to a check does not have as many items as were asked");
    for (*done = 0; *done < count && w->items[*done].verdict < WIRE_CHECK_NOT_DONE; ++*done) {
        const wire_checked *item = &w->items[*done];
        w->out->items[first + *done] = (collided_check_item){.verdict = (collided_verdict)item->verdict,
            .first_lo = item->first_lo,
            .first_hi = item->first_hi,
            .lo = item->lo,
            .hi = item->hi,
            .name_a = keep_name(w, a, item->name_a),
            .name_b = keep_name(w, a, item->name_b)};
    }
    w->out->epoch = a->epoch;
    w->out->tick = a->tick;
    if (*a->text) {
        free(w->out->text);
        w->out->text = memcpy(allocate(1, strlen(a->text) + 1), a->text, strlen(a->text) + 1);
    }
    return COLLIDED_OK;
}

static collided_status ask_portion(check_work *w, size_t first, size_t count, double timeout_s, size_t *done)
{
    w->head.item_count = (int32_t)count;
    size_t size = wire_robot_size(&w->head, w->joints);
    const uint32_t head[2] = {WIRE_EXTENSION_CHECK, (uint32_t)size};
    uint8_t *record = allocate(1, WIRE_EXTENSION_HEAD + size);
    memcpy(record, head, sizeof head);
    wire_robot_write(&w->head, w->joints, w->numbers + first * w->each, record + sizeof head);
    wire_query q = {.kind = WIRE_QUERY_CHECK, .extensions = {(uint32_t)(WIRE_EXTENSION_HEAD + size), record}};
    wire_message *answer = NULL;
    collided_status status = query_answer(w->c, q, timeout_s, &answer);
    if (status == COLLIDED_OK) status = take_answer(w, &answer->answer, first, count, done);
    free(answer);
    free(record);
    return status;
}

static collided_status ask_all(check_work *w, double timeout_s)
{
    int64_t deadline = session_monotonic_ns() + session_seconds(timeout_s);
    for (size_t first = 0; first < w->out->count;) {
        size_t done = 0;
        double left_s = 1e-9 * (double)(deadline - session_monotonic_ns());
        collided_status status =
            ask_portion(w, first, portion(w, w->out->count - first), left_s > 0 ? left_s : 0, &done);
        if (status != COLLIDED_OK) return status;
        first += done;
    }
    return COLLIDED_OK;
}

static collided_status check_items(collided *c, const collided_robot *r, const collided_check_options *options,
    uint8_t flags, const double *numbers, size_t count, double timeout_s, collided_checked *out)
{
    *out = (collided_checked){.count = count};
    collided_check_options o = options ? *options : collided_check_options_default();
    check_work *w = allocate(1, sizeof *w);
    *w = (check_work){.c = c, .numbers = numbers, .out = out};
    w->head = (wire_robot_question){.flags = flags,
        .joint_count = (int32_t)r->joint_count,
        .margin_m = o.margin_m,
        .resolution_m = o.resolution_m,
        .tolerance_m = o.tolerance_m};
    if (o.find_first) w->head.flags |= WIRE_CHECK_FIRST;
    if (o.measure) w->head.flags |= WIRE_CHECK_MEASURE;
    memcpy(w->head.base, r->base.position, sizeof r->base.position);
    memcpy(w->head.base + 3, r->base.orientation, sizeof r->base.orientation);
    collided_status status = copy_joints(c, r, w->joints);
    if (status == COLLIDED_OK) {
        w->each = wire_robot_numbers(&w->head, w->joints);
        out->items = allocate(count + 1, sizeof *out->items);
        for (size_t i = 0; i < count; i++) out->items[i] = (collided_check_item){.verdict = COLLIDED_CHECK_NOT_DONE};
        status = ask_all(w, timeout_s);
    }
    out->names = w->names;
    out->name_count = w->name_count;
    free(w);
    if (!out->text) out->text = memcpy(allocate(1, 1), "", 1);
    return status;
}

collided_status collided_check_states(collided *c, const collided_robot *r, const collided_check_options *options,
    const double *positions, size_t count, double timeout_s, collided_checked *out)
{
    return check_items(c, r, options, 0, positions, count, timeout_s, out);
}

collided_status collided_check_edges(collided *c, const collided_robot *r, const collided_check_options *options,
    const double *positions, size_t count, double timeout_s, collided_checked *out)
{
    return check_items(c, r, options, WIRE_CHECK_EDGES, positions, count, timeout_s, out);
}

size_t collided_robot_coordinates(const collided_robot *r)
{
    size_t moving = 0;
    for (size_t i = 0; i < r->joint_count; i++)
        moving += r->joints[i].type != COLLIDED_JOINT_FIXED && !r->joints[i].mimics;
    return moving;
}

void collided_checked_free(collided_checked *checked)
{
    for (size_t i = 0; i < checked->name_count; i++) free(checked->names[i]);
    free(checked->names);
    free(checked->items);
    free(checked->text);
    *checked = (collided_checked){0};
}
