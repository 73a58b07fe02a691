/* body_message: see body_message.h. */
#include "body_message.h"

#include "geometries.h"
#include "models.h"

#include "geom/compound.h"
#include "geom/mesh.h"

static void pose_numbers(double at[7], pose p)
{
    const double numbers[7] = {p.p.x, p.p.y, p.p.z, p.q.w, p.q.x, p.q.y, p.q.z};
    for (int i = 0; i < 7; i++) at[i] = numbers[i];
}

static uint8_t wire_type_of(const shape *s)
{
    bool field = s->type == SHAPE_MESH && s->mesh->rows;
    return field ? WIRE_SHAPE_HEIGHT_FIELD : (uint8_t)s->type;
}

typedef struct shape_writer {
    body_columns *c;
    const service *s;
    const owned_body *b;
    uint32_t count;
    size_t lent; /* of the body's geometries */
} shape_writer;

static void put_shape(shape_writer *w, const shape *s, pose local)
{
    uint32_t i = w->count++;
    body_columns *c = w->c;
    bool lent = s->type == SHAPE_HULL || s->type == SHAPE_MESH || s->type == SHAPE_SOFT,
         whole = s->type == SHAPE_COMPOUND;
    c->types[i] = wire_type_of(s);
    c->sizes[3 * i] = whole ? s->compound->child_count : s->half.x;
    c->sizes[3 * i + 1] = s->half.y;
    c->sizes[3 * i + 2] = s->half.z;
    c->radii[i] = s->radius;
    c->deviations[i] = s->deviation;
    pose_numbers(c->poses + 7 * (size_t)i, local);
    c->geometries[i] = lent ? geometry_at(w->s, w->b->geometries.at[w->lent++])->hash : 0;
}

static void fill_shapes(const service *of, body_columns *c, const world_body *def, const owned_body *b, wire_body *m)
{
    shape_writer w = {c, of, b, 0, 0};
    for (size_t i = 0; i < def->shape_count; i++) {
        const shape *s = &c->shapes[i].shape;
        put_shape(&w, s, c->shapes[i].local);
        for (uint32_t k = 0; s->type == SHAPE_COMPOUND && k < s->compound->child_count; k++)
            put_shape(&w, &s->compound->children[k].shape, s->compound->children[k].local);
    }
    uint32_t n = w.count;
    m->shape_types = (wire_u8s){n, c->types};
    m->shape_sizes = (wire_f64s){3 * n, c->sizes};
    m->shape_radii = (wire_f64s){n, c->radii};
    m->shape_deviations = (wire_f64s){n, c->deviations};
    m->shape_poses = (wire_f64s){7 * n, c->poses};
    m->shape_geometries = (wire_i64s){n, c->geometries};
}

static void fill_rules(body_columns *c, const world_body *def, wire_body *m)
{
    uint32_t n = (uint32_t)def->rule_count;
    for (uint32_t i = 0; i < n; i++) {
        c->patterns[i] = def->rules[i].pattern;
        c->actions[i] = def->rules[i].allow ? WIRE_RULE_ALLOW : WIRE_RULE_CHECK;
        c->reasons[i] = def->rules[i].reason;
        c->paddings[i] = def->rules[i].padding;
        c->margins[i] = def->rules[i].margin;
    }
    m->rule_patterns = (wire_strings){n, c->patterns};
    m->rule_actions = (wire_u8s){n, c->actions};
    m->rule_reasons = (wire_strings){n, c->reasons};
    m->rule_paddings = (wire_f64s){n, c->paddings};
    m->rule_margins = (wire_f64s){n, c->margins};
}

wire_message body_message_of(
    const service *s, int64_t client, const owned_body *b, const world_body *def, body_columns *scratch)
{
    pose_numbers(scratch->pose, def->pose);
    wire_message m = {.kind = WIRE_BODY,
        .body = {.version = WIRE_VERSION,
            .client = client,
            .sequence = b->sequence,
            .body = b->number,
            .motion = def->fixed ? WIRE_MOTION_FIXED : WIRE_MOTION_MOVING,
            .name = def->name,
            .group = def->group,
            .category = (int64_t)def->category,
            .mask = (int64_t)def->mask,
            .one_way = def->one_way,
            .ccd = (uint8_t)def->ccd,
            .acceleration_m_s2 = def->acceleration,
            .angular_acceleration_rad_s2 = def->angular_acceleration,
            .deadline_ns = def->deadline_ns,
            .stamp_ns = def->stamp_ns,
            .stamp_is_now = def->stamp_is_now,
            .pose = {7, scratch->pose},
            .extensions = model_extensions(b->model)}};
    fill_shapes(s, scratch, def, b, &m.body);
    fill_rules(scratch, def, &m.body);
    return m;
}
