/* apply: commands of clients to the world; what cannot be done is refused with its reason, counted, and changes nothing
 * else. Messages have been checked by the link (wire_check): here is only what needs the world. Tick thread. */
#include "clients.h"
#include "commands.h"
#include "geometries.h"
#include "models.h"
#include "service.h"
#include "standby.h"
#include "streams.h"
#include "vertices.h"

#include "base/log.h"
#include "geom/compound.h"

#include <inttypes.h>
#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

void apply_reject(service *s, struct link *to, wire_kind kind, int64_t client, int64_t sequence, int32_t object,
    const wire_refusal *why)
{
    metric_count(s->count.rejects[why->reason], 1);
    log_warning("refused %s %" PRId64 " of client %016" PRIx64 ": %s: %s", wire_kind_name(kind), sequence,
        (uint64_t)client, wire_reason_name(why->reason), why->text);
    if (!limits_report_reject(s, client)) return;
    wire_message m = {.kind = WIRE_REJECT,
        .reject = {WIRE_VERSION, client, sequence, s->epoch, .kind = (uint8_t)kind, .object = object,
            .reason = (uint8_t)why->reason, .text = why->text}};
    to->ops->publish(to, &m);
}

wire_reason apply_refuse(wire_refusal *why, wire_reason reason, const char *format, ...)
{
    va_list args;
    va_start(args, format);
    why->reason = reason;
    vsnprintf(why->text, sizeof why->text, format, args);
    va_end(args);
    return reason;
}

/* In status, for a minute. */
void apply_name_limit(service *s, const char *option)
{
    s->limit_ns = s->monotonic_ns;
    if (strstr(s->limits, option)) return;
    size_t used = strlen(s->limits);
    snprintf(s->limits + used, sizeof s->limits - used, "%s%s", used ? " " : "", option);
}

/* Is the limit reached? Then it is named, here and in status. */
bool apply_limit(service *s, size_t now, long most, const char *option, wire_refusal *why)
{
    if (now < (size_t)most) return false;
    apply_refuse(why, WIRE_LIMIT, "%s = %ld is reached", option, most);
    apply_name_limit(s, option);
    return true;
}

/* ---- bodies ---- */

/* A height field is a mesh to all that comes after. */
static shape_type type_of(uint8_t wire_type)
{
    return wire_type == WIRE_SHAPE_HEIGHT_FIELD ? SHAPE_MESH : (shape_type)wire_type;
}

static bool shape_at(service *s, const wire_body *m, uint32_t i, world_shape *out, wire_refusal *why)
{
    const double *size = m->shape_sizes.at + 3 * (size_t)i, *at = m->shape_poses.at + 7 * (size_t)i;
    uint8_t type = m->shape_types.at[i];
    *out = (world_shape){.shape = {.type = type_of(type),
                             .radius = m->shape_radii.at[i],
                             .deviation = m->shape_deviations.count ? m->shape_deviations.at[i] : 0,
                             .half = vec(size[0], size[1], size[2])},
        .local = {vec(at[0], at[1], at[2]), quat_unit((quat){at[3], at[4], at[5], at[6]})}};
    int64_t hash = m->shape_geometries.at[i];
    if (hash == 0 || geometry_lend(s, geometry_claimed(s, m->client, hash), type, &out->shape)) return true;
    s->carried.lacks = hash;
    apply_refuse(why, WIRE_UNKNOWN_GEOMETRY, "shape_geometries[%u]: %s %016" PRIx64 " has not come", i,
        type == WIRE_SHAPE_HEIGHT_FIELD ? "height field" : shape_type_name(out->shape.type), (uint64_t)hash);
    return false;
}

/* Its children follow it in the list. */
static bool compound_at(service *s, const wire_body *m, uint32_t i, world_shape *out, wire_refusal *why)
{
    shape children[WIRE_SHAPES_MAX];
    pose locals[WIRE_SHAPES_MAX];
    uint32_t count = (uint32_t)m->shape_sizes.at[3 * (size_t)i];
    for (uint32_t k = 0; k < count; k++) {
        world_shape child;
        if (!shape_at(s, m, i + 1 + k, &child, why)) return false;
        children[k] = child.shape;
        locals[k] = child.local;
    }
    compound *whole;
    compound_status status = compound_build(children, locals, count, &whole);
    if (status != COMPOUND_OK) {
        apply_refuse(why, WIRE_BAD_SIZE, "shape_types[%u]: %s", i, compound_status_text(status));
        return false;
    }
    array_push(&s->compounds, whole);
    out->shape.half = VEC_ZERO; /* what was there counts the children */
    out->shape.compound = whole;
    return true;
}

/* Compounds are kept in s->compounds until the world has copied them: drop_compounds. */
static bool gather_shapes(service *s, const wire_body *m, wire_refusal *why)
{
    s->shapes.count = 0;
    for (uint32_t i = 0; i < m->shape_types.count; i++) {
        world_shape shape;
        if (!shape_at(s, m, i, &shape, why)) return false;
        if (shape.shape.type == SHAPE_COMPOUND) {
            if (!compound_at(s, m, i, &shape, why)) return false;
            i += shape.shape.compound->child_count;
        }
        array_push(&s->shapes, shape);
    }
    return true;
}

static void drop_compounds(service *s)
{
    for (size_t i = 0; i < s->compounds.count; i++) compound_destroy(s->compounds.at[i]);
    s->compounds.count = 0;
}

static void gather_rules(service *s, const wire_body *m)
{
    s->rules.count = 0;
    for (uint32_t i = 0; i < m->rule_patterns.count; i++)
        array_push(&s->rules, ((filter_rule){.pattern = m->rule_patterns.at[i],
                                  .allow = m->rule_actions.at[i] == WIRE_RULE_ALLOW,
                                  .reason = m->rule_reasons.at[i],
                                  .padding = m->rule_paddings.at[i],
                                  .margin = m->rule_margins.at[i]}));
}

static void hold_geometries(service *s, owned_body *b, const wire_body *m)
{
    size_t before = b->geometries.count;
    for (uint32_t i = 0; i < m->shape_types.count; i++) {
        if (m->shape_geometries.at[i] == 0) continue;
        array_push(&b->geometries, geometry_claimed(s, m->client, m->shape_geometries.at[i]));
        geometry_hold(s, b->geometries.at[b->geometries.count - 1]);
    }
    for (size_t i = 0; i < before; i++) geometry_release(s, b->geometries.at[i]);
    b->geometries.count -= before;
    if (b->geometries.count)
        memmove(b->geometries.at, b->geometries.at + before, b->geometries.count * sizeof *b->geometries.at);
}

static bool room_for(service *s, const session *c, const owned_body *b, const wire_body *m, wire_refusal *why)
{
    world_figures now = world_get_figures(s->world);
    bool is_new = !b || b->world_id == WORLD_NONE;
    if (!limits_bodies(s, c, is_new, why) || !limits_shapes(s, c, is_new ? 0 : b->shapes, m->shape_types.count, why))
        return false;
    if (is_new && apply_limit(s, now.bodies, s->config.max_bodies, "max_bodies", why)) return false;
    size_t others = now.shapes - (b ? world_body_shapes(s->world, b->world_id) : 0); /* what it replaces makes room */
    return !apply_limit(s, others + m->shape_types.count - 1, s->config.max_shapes, "max_shapes", why);
}

static size_t weight_of_soft(const service *s)
{
    const shape *one = s->shapes.count ? &s->shapes.at[0].shape : NULL;
    return one && one->type == SHAPE_SOFT ? vertices_weight(soft_mesh_vertex_count(one->soft)) : 0;
}

/* The shapes have been gathered. What it replaces makes room. */
static bool room_for_soft(service *s, const owned_body *b, wire_refusal *why)
{
    size_t more = weight_of_soft(s), others = world_get_figures(s->world).soft_vertices - (b ? b->soft : 0);
    return !more || !apply_limit(s, others + more - 1, s->config.max_soft_vertices, "max_soft_vertices", why);
}

/* The shapes have been gathered. The robot becomes the body's. */
static wire_reason put_gathered(service *s, session *c, const wire_body *m, struct model *robot, wire_refusal *why)
{
    owned_body *b = session_body(c, m->body);
    gather_rules(s, m);
    const double *at = m->pose.at;
    uint32_t id = b ? b->world_id : WORLD_NONE;
    pose reported = {vec(at[0], at[1], at[2]), {at[3], at[4], at[5], at[6]}};
    bool newer_pose = b && id != WORLD_NONE && *session_pose_sequence(c, b) > m->sequence;
    world_body def = {.name = m->name,
        .group = m->group,
        .fixed = m->motion == WIRE_MOTION_FIXED,
        .category = (uint64_t)m->category,
        .mask = (uint64_t)m->mask,
        .one_way = m->one_way,
        .in_step = c->lock_step > 0,
        .owner = (uint64_t)c->client,
        .ccd = (world_ccd)m->ccd,
        .acceleration = m->acceleration_m_s2,
        .angular_acceleration = m->angular_acceleration_rad_s2,
        .deadline_ns = m->deadline_ns,
        .stamp_ns = newer_pose ? world_body_stamp_ns(s->world, id) : m->stamp_ns,
        .stamp_is_now = !newer_pose && m->stamp_is_now,
        .pose = newer_pose ? world_body_pose(s->world, id) : reported,
        .shapes = s->shapes.at,
        .shape_count = s->shapes.count,
        .rules = s->rules.at,
        .rule_count = s->rules.count};
    if (world_put_body(s->world, &id, &def) == WORLD_NAME_TAKEN) {
        apply_refuse(why, WIRE_NAME_TAKEN, "name: \"%.100s\" is the name of another body", m->name);
        return why->reason;
    }
    if (!b) b = session_add_body(c, m->body);
    session_count_body(c, b, id, m->shape_types.count);
    model_destroy(b->model);
    b->model = robot;
    b->soft = (uint32_t)weight_of_soft(s);
    c->soft_vertices += b->soft;
    b->sequence = m->sequence;
    if (!newer_pose) *session_pose_sequence(c, b) = m->sequence;
    hold_geometries(s, b, m);
    if (c->lost && !c->left && c->on_loss == WIRE_LOST_HOLD) world_hold_body(s->world, id);
    return WIRE_OK;
}

static wire_reason put_body(service *s, session *c, const wire_body *m, wire_refusal *why)
{
    if (!room_for(s, c, session_body(c, m->body), m, why)) return why->reason;
    struct model *robot;
    if (model_of(m->extensions, &robot, why) != WIRE_OK) return why->reason;
    bool fits = gather_shapes(s, m, why) && room_for_soft(s, session_body(c, m->body), why);
    wire_reason reason = fits ? put_gathered(s, c, m, robot, why) : why->reason;
    if (reason != WIRE_OK) model_destroy(robot);
    drop_compounds(s);
    return reason;
}

static wire_reason remove_body(service *s, session *c, const wire_body *m)
{
    owned_body *b = session_body(c, m->body);
    if (!b) b = session_add_body(c, m->body); /* so that a late copy of its Body does not bring it back */
    if (b->world_id != WORLD_NONE) world_remove_soon(s->world, b->world_id, CAUSE_REMOVED);
    for (size_t i = 0; i < b->geometries.count; i++) geometry_release(s, b->geometries.at[i]);
    b->geometries.count = 0;
    session_count_body(c, b, WORLD_NONE, 0);
    b->sequence = m->sequence;
    return WIRE_OK;
}

/* A copy of one that waits for a build is answered when that is over. */
static wire_reason apply_body(service *s, session *c, const wire_body *m, wire_refusal *why, bool *later)
{
    const owned_body *b = session_body(c, m->body);
    pending_copy copy = pending_is_copy(s, c, m);
    if ((b && m->sequence <= b->sequence) || copy != PENDING_NEWER) {
        metric_count(s->count.duplicates, 1);
        *later = copy == PENDING_SAME;
        return WIRE_OK;
    }
    wire_reason reason = m->removed ? remove_body(s, c, m) : put_body(s, c, m, why);
    if (reason != WIRE_OK) return reason;
    pending_supersede(s, c, m, &s->carried.pose);
    if (!m->removed) poses_give(s, c, session_body(c, m->body), &s->carried.pose);
    return reason;
}

/* ---- subscriptions ---- */

static const double LONGEST_PERIOD_NS = 1e18; /* 30 years: a rate of next to nothing must still fit 64 bits */

static wire_reason put_subscription(service *s, session *c, const wire_subscription *m, wire_refusal *why)
{
    owned_subscription *i = session_subscription(c, m->subscription);
    bool is_new = !i || !i->live;
    if (is_new && !limits_subscriptions(s, c, why)) return why->reason;
    if (is_new && apply_limit(s, world_get_figures(s->world).subscriptions, s->config.max_subscriptions,
                      "max_subscriptions", why))
        return why->reason;
    bool scene = m->facts & WIRE_FACT_SCENE; /* which the service tells: of pairs it wants nothing */
    world_subscription def = {.facts = scene ? WORLD_TOUCH : (unsigned)m->facts & ~(unsigned)WIRE_FACT_POSES,
        .select_a = scene ? SCENE_NO_BODY : m->select_a,
        .select_b = scene ? SCENE_NO_BODY : m->select_b,
        .threshold = m->threshold_m,
        .range = m->range_m,
        .hysteresis = m->hysteresis_m,
        .tolerance = m->tolerance_m,
        .relative_tolerance = m->relative_tolerance,
        .accuracy = (world_accuracy)m->accuracy,
        .horizon = m->horizon_s,
        .period_ns = m->rate_hz > 0 ? llround(fmin(1e9 / m->rate_hz, LONGEST_PERIOD_NS)) : 0,
        .owner = (uint64_t)c->client,
        .in_step = c->lock_step > 0};
    wire_soft_interest soft;
    wire_soft_read_interest(m->extensions, &soft);
    def.soft_each = soft.grain == WIRE_SOFT_EACH;
    def.soft_most = (uint32_t)soft.most;
    if (s->amend_subscription) s->amend_subscription(s->amend_context, &def);
    uint32_t id = is_new ? WORLD_NONE : i->world_id;
    if (stream_taken(s, c, m, id, why)) return why->reason; /* before anything has changed */
    world_put_subscription(s->world, &id, &def);
    stream_open(s, c, m, id);
    if (!i) i = session_add_subscription(c, m->subscription);
    c->subscription_count += is_new;
    *i = (owned_subscription){m->subscription, id, m->sequence, true};
    return WIRE_OK;
}

static wire_reason apply_subscription(service *s, session *c, const wire_subscription *m, wire_refusal *why)
{
    owned_subscription *i = session_subscription(c, m->subscription);
    if (i && m->sequence <= i->sequence) {
        metric_count(s->count.duplicates, 1);
        return WIRE_OK;
    }
    if (!m->removed) return put_subscription(s, c, m, why);
    if (!i)
        i = session_add_subscription(
            c, m->subscription); /* so that a late copy of its Subscription does not begin it */
    if (i->live) {
        stream_end(s, i->world_id, CAUSE_SUBSCRIPTION);
        c->subscription_count--;
    }
    i->live = false;
    i->sequence = m->sequence;
    return WIRE_OK;
}

/* ---- clients ---- */

/* An older word than the newest: a late copy, or a new process under the same id whose clock was set back, so that it
 * begins below what its bodies have. The acknowledgement of the newest of all tells it: it goes on from there. */
static void apply_client(service *s, session *c, const wire_client *m)
{
    if (m->sequence < c->sequence) {
        session_ack(c, session_newest_sequence(c));
        return;
    }
    bool is_new = !c->announced;
    c->sequence = m->sequence;
    c->announced = standby_hears(s, m->client);
    c->lost = c->left = false;
    c->lease_ns = m->lease_ns;
    c->on_loss = m->on_loss;
    steps_join(s, c, m->lock_step);
    if (is_new) ready_announced(s);
    if (strcmp(c->name, m->name) != 0) {
        free(c->name);
        c->name = base_strdup(m->name);
    }
    if (is_new)
        log_info("client %016" PRIx64 " \"%s\" is here, by %s", (uint64_t)c->client, c->name, c->link->ops->scheme);
}

/* Answered at once, because there is no session any more; a copy of it makes none. What came later is of the next
 * process under that id, which may not have said yet that it is there. A number far beyond what came before is no
 * goodbye's, but the time of a disposal (link_dds_take.c), which says nothing of what may come late. */
static void apply_leave(service *s, struct link *from, const wire_client *m)
{
    static const int64_t FAR = 1 << 20;
    session *c = session_find(s, m->client);
    int64_t newest = c ? session_newest_sequence(c) : 0;
    if (c && m->sequence - newest < FAR) {
        c->left_sequence = m->sequence > c->left_sequence ? m->sequence : c->left_sequence;
        session_remember_left(s, m->client, m->sequence);
    }
    if (c && m->sequence < newest) {
        session_leave_before(s, c, m->sequence);
    } else if (c) {
        c->sequence = m->sequence;
        session_leave(s, c);
    }
    wire_message ack = {.kind = WIRE_ACK, .ack = {WIRE_VERSION, m->client, s->epoch, .sequences = {1, &m->sequence}}};
    from->ops->publish(from, &ack);
}

/* It has been long on its way, and what it begins nobody would end. Or it is of a new process under the same id, whose
 * clock was set back: that one is told where to go on from. */
static bool is_of_one_who_left(service *s, struct link *from, const wire_message *m)
{
    int64_t client, sequence;
    int32_t object;
    wire_origin(m, &client, &sequence, &object);
    int64_t left = session_left_at(s, client);
    if (sequence > left) return false;
    metric_count(s->count.duplicates, 1);
    bool done = (m->kind == WIRE_BODY && m->body.removed) || (m->kind == WIRE_SUBSCRIPTION && m->subscription.removed);
    wire_message ack = {
        .kind = WIRE_ACK, .ack = {WIRE_VERSION, client, s->epoch, .sequences = {1, done ? &sequence : &left}}};
    if (done || m->kind == WIRE_CLIENT) from->ops->publish(from, &ack);
    return true;
}

bool apply_command(service *s, struct link *from, const wire_message *m, bool may_wait)
{
    int64_t client, sequence;
    int32_t object;
    bool later = false;
    wire_refusal why = {WIRE_OK, ""};
    wire_origin(m, &client, &sequence, &object);
    if (m->kind == WIRE_CLIENT && m->client.removed) {
        apply_leave(s, from, &m->client);
        return true;
    }
    if (!s->carried.has_waited && is_of_one_who_left(s, from, m)) return true;
    session *c = session_get(s, client, from);
    if (!c) {
        apply_limit(s, s->sessions.count, s->config.max_clients, "max_clients", &why);
        apply_reject(s, from, m->kind, client, sequence, object, &why);
        return true;
    }
    session_remind(s, c, m->kind);
    switch (m->kind) {
    case WIRE_CLIENT:
        apply_client(s, c, &m->client);
        break;
    case WIRE_GEOMETRY:
        ready_announced(s);
        geometry_put(s, c, &m->geometry, &why, &later);
        break;
    case WIRE_BODY:
        ready_announced(s);
        apply_body(s, c, &m->body, &why, &later);
        break;
    case WIRE_SUBSCRIPTION:
        ready_announced(s);
        apply_subscription(s, c, &m->subscription, &why);
        break;
    case WIRE_VERTEX_BATCH:
        if (vertices_put(s, c, &m->vertex_batch, &why) == WIRE_OK) return true; /* its step is its answer */
        break;
    default:
        apply_refuse(&why, WIRE_UNSUPPORTED, "%s is not for the daemon", wire_kind_name(m->kind));
        break;
    }
    if (why.reason == WIRE_UNKNOWN_GEOMETRY && may_wait) return false;
    if (later) return true;
    if (why.reason == WIRE_OK)
        session_ack(c, sequence);
    else /* which may be lost, or not reported, and is reported again when the message comes again */
        apply_reject(s, from, m->kind, client, sequence, object, &why);
    return true;
}
