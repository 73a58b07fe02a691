/* answer_checks: see answer_checks.h. */
#include "answer_checks.h"
#include "wire/wire_extensions.h"
#include "wire/wire_robot.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

typedef struct question { /* as read, and as the world wants it */
    wire_robot_question head;
    wire_joint joints[WIRE_JOINTS_MAX];
    double numbers[WIRE_CHECK_NUMBERS_MAX];
    robot_joint made[WIRE_JOINTS_MAX];
    uint32_t bodies[WIRE_JOINTS_MAX];
    world_check_item items[WIRE_CHECK_ITEMS_MAX];
    wire_checked told[WIRE_CHECK_ITEMS_MAX];
} question;

static bool find_record(const wire_query *q, wire_u8s *record)
{
    wire_u8s rest = q->extensions;
    wire_extension e;
    while (wire_extension_next(&rest, &e))
        if (e.id == WIRE_EXTENSION_CHECK) return *record = e.bytes, true;
    return false;
}

static pose pose_of_numbers(const double p[7])
{
    return (pose){vec(p[0], p[1], p[2]), {p[3], p[4], p[5], p[6]}};
}

static bool find_link_bodies(service *s, question *q, char *text, size_t text_size)
{
    for (int32_t i = 0; i < q->head.joint_count; i++) {
        const wire_joint *j = &q->joints[i];
        q->made[i] = (robot_joint){j->parent, (robot_joint_type)j->type, pose_of_numbers(j->origin),
            vec(j->axis[0], j->axis[1], j->axis[2]), j->lower, j->upper, j->mimic, j->factor, j->offset};
        q->bodies[i] = WORLD_NONE;
        if (!*j->body) continue;
        q->bodies[i] = world_find_body(s->world, j->body);
        if (q->bodies[i] == WORLD_NONE) {
            snprintf(text, text_size, "joint %d: no body is named \"%.127s\"", i, j->body);
            return false;
        }
        for (int32_t k = 0; k < i; k++)
            if (q->bodies[k] == q->bodies[i]) {
                snprintf(text, text_size, "joints %d and %d: \"%.127s\" is the body of both", k, i, j->body);
                return false;
            }
    }
    return true;
}

/* Few bodies meet something: a list of names, each once. */
static int32_t name_place(service *s, check_answer_record *out, uint32_t body)
{
    if (body == WORLD_NONE) return -1;
    const char *name = world_body_name(s->world, body);
    for (uint32_t i = 0; i < out->name_count; i++)
        if (out->names[i] == name) return (int32_t)i;
    out->names[out->name_count] = name;
    return (int32_t)out->name_count++;
}

static void write_answer(service *s, question *q, check_answer_record *out)
{
    size_t count = (size_t)q->head.item_count;
    out->names = base_alloc(2 * count, sizeof *out->names);
    for (size_t i = 0; i < count; i++) {
        const world_check_item *item = &q->items[i];
        q->told[i] = (wire_checked){(uint8_t)item->verdict, item->first_lo, item->first_hi, item->lo, item->hi,
            name_place(s, out, item->body_a), name_place(s, out, item->body_b)};
        out->cut |= item->verdict == CHECK_NOT_DONE;
    }
    const uint32_t head[2] = {WIRE_EXTENSION_CHECKED, (uint32_t)(WIRE_CHECKED_EACH * count)};
    bytes_put(&out->record, head, sizeof head);
    array_reserve(&out->record, sizeof head + head[1]);
    wire_checked_write(q->told, count, out->record.at + sizeof head);
    out->record.count += head[1];
}

bool answer_checks(service *s, const wire_query *q, const world_check_patience *patience, check_answer_record *out,
    char *text, size_t text_size)
{
    *out = (check_answer_record){0};
    wire_u8s record;
    wire_refusal why;
    if (!find_record(q, &record)) {
        snprintf(text, text_size, "a check needs the record %d in its extensions", WIRE_EXTENSION_CHECK);
        return false;
    }
    question *asked = base_alloc(1, sizeof *asked);
    bool good = wire_robot_read(record, &asked->head, asked->joints, asked->numbers, &why) == WIRE_OK;
    if (!good) snprintf(text, text_size, "%s", why.text);
    good = good && find_link_bodies(s, asked, text, text_size);
    const wire_robot_question *h = &asked->head;
    world_check_def def = {.joints = asked->made,
        .bodies = asked->bodies,
        .joint_count = (size_t)h->joint_count,
        .base = pose_of_numbers(h->base),
        .request = {.margin_m = h->margin_m,
            .resolution_m = h->resolution_m,
            .find_first = h->flags & WIRE_CHECK_FIRST,
            .measure = h->flags & WIRE_CHECK_MEASURE,
            .tolerance_m = h->tolerance_m},
        .edges = h->flags & WIRE_CHECK_EDGES,
        .coordinates = asked->numbers,
        .items = (size_t)h->item_count,
        .others_pending = s->pending.count};
    def.base.q = quat_unit(def.base.q);
    good = good && world_check(s->world, &def, patience, asked->items, text, text_size);
    if (good) write_answer(s, asked, out);
    free(asked);
    return good;
}
