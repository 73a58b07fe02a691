/* soft_rigid: a soft surface beside a rigid shape, each on its way: which of its faces meet it, and when. Tick thread,
 * and the pool, one face at a time.
 *
 * A face is three points, each on a straight line; the shape goes on a screw from its pose at the last tick to its
 * pose. Where the boxes of the two ways are apart nothing is asked. Else conservative advancement (Mirtich and Canny
 * 1995): the certified distance at one time, less the separation, is not used up before the face's fastest corner and
 * the shape's fastest point could have used it. So nothing that meets is missed; what comes nearer than the steps can
 * tell apart is told, as within rounding or undecided. Whole faces are looked at: edges and vertices are parts of them.
 */
#include "soft_state.h"
#include "subscription.h"

#include "geom/round.h"

#include <stdlib.h>

enum { STEPS_MAX = 48, LOOKS_MAX = 8, A_CHUNK = 64 /* faces */, A_QUERY = 60, A_BOX = 1 /* units of 10 ns */ };
static const double NEAR = 1e-9; /* of the sizes: as near as steps go */
enum { FACE_SHAPE = 3 };

typedef struct found { /* by one worker */
    soft_contact contact;
    struct soft_touch touch;
    vec3 point;
} found;
typedef ARRAY(found) founds;

typedef struct task {
    const soft_meeting *m;
    aabb box; /* of the shape's way, wider by the separation */
    motion_spin spin;
    double speed; /* m a step: of any point of the shape */
    void *const *scratch;
    founds of[WORKERS_MAX];
    _Atomic uint64_t units;
    size_t from; /* the first face of this portion */
} task;

typedef struct triangle { /* as a flat hull, for the narrow phase */
    hull hull;
    double x[8], y[8], z[8];
    shape shape;
} triangle;

/* Its corners about `origin`. */
static void place_triangle(triangle *t, const vec3 corner[3], vec3 origin)
{
    double reach = 0, most = 0;
    for (int i = 0; i < 8; i++) {
        vec3 p = vec_sub(corner[i < 3 ? i : 2], origin);
        t->x[i] = p.x, t->y[i] = p.y, t->z[i] = p.z;
        reach = fmax(reach, length_up(p));
        most = fmax(most, vec_max_abs(p));
    }
    t->hull = (hull){.vertex_count = 3,
        .padded_count = 8,
        .x = t->x,
        .y = t->y,
        .z = t->z,
        .reach = reach,
        .max_abs = most,
        .dimension = 2};
    t->shape = (shape){.type = SHAPE_HULL, .hull = &t->hull};
}

static vec3 corner_at(const soft_meeting *m, uint32_t v, double t)
{
    vec3 from = m->vertices.from[v], to = m->vertices.to[v];
    return t == 0 ? from : t == 1 ? to : vec_madd(from, t, vec_sub(to, from));
}

typedef struct asking {
    const task *t;
    uint32_t corners[3];
    double tolerance, slack; /* m; of rounding */
    void *scratch;
    uint64_t units;
    narrow_result r; /* about the shape's origin at that time, from the face to the shape */
    vec3 origin;
} asking;

/* The distance at a time, within a tolerance and certified. */
static void ask_face(asking *a, double time)
{
    const soft_meeting *m = a->t->m;
    pose body = motion_pose(&m->way, time), at = collider_at(body, m->shape);
    vec3 corner[3];
    triangle face;
    for (int i = 0; i < 3; i++) corner[i] = corner_at(m, a->corners[i], time);
    place_triangle(&face, corner, at.p);
    narrow_request request = {.facts = NARROW_DISTANCE | NARROW_VERDICT,
        .tolerance = a->tolerance,
        .range = INFINITY,
        .threshold = m->separation,
        .brief = true};
    a->origin = at.p;
    at.p = VEC_ZERO;
    narrow_query_world(&face.shape, (pose){VEC_ZERO, {1, 0, 0, 0}}, &m->shape->shape, at, &request, a->scratch, &a->r);
    a->r.lo -= a->slack;
    a->r.hi += a->slack;
    a->units += A_QUERY + (uint64_t)(m->shape->apart / 10);
}

/* By when is it met for certain? Looks on from `t`, ever farther. */
static bool meets_by(asking *a, double t, double step, double *by)
{
    for (int i = 0; i < LOOKS_MAX; i++, step *= 4) {
        double at = fmin(t + step, 1);
        ask_face(a, at);
        if (a->r.hi <= a->t->m->separation) return *by = at, true;
        if (at == 1) return false;
    }
    return false;
}

static void describe(const asking *a, uint32_t face, found *f)
{
    const vec3 n = a->r.axis, p = vec_add(a->r.point_a, a->origin);
    f->point = p;
    f->contact.a = face;
    f->contact.kind = FACE_SHAPE;
    f->touch.normal[0] = (float)n.x, f->touch.normal[1] = (float)n.y, f->touch.normal[2] = (float)n.z;
}

static void bary_of(const soft_meeting *m, const uint32_t corners[3], double t, vec3 p, float bary[2])
{
    vec3 a = corner_at(m, corners[0], t), u = vec_sub(corner_at(m, corners[1], t), a),
         v = vec_sub(corner_at(m, corners[2], t), a), d = vec_sub(p, a);
    double uu = vec_dot(u, u), uv = vec_dot(u, v), vv = vec_dot(v, v), du = vec_dot(d, u), dv = vec_dot(d, v);
    double det = uu * vv - uv * uv;
    bary[0] = det > 0 ? (float)((vv * du - uv * dv) / det) : uu > 0 ? (float)(du / uu) : 0;
    bary[1] = det > 0 ? (float)((uu * dv - uv * du) / det) : 0;
}

static float below(double t)
{
    float f = (float)t;
    return (double)f > t ? nextafterf(f, -1) : f;
}
static float above(double t)
{
    float f = (float)t;
    return (double)f < t ? nextafterf(f, 2) : f;
}

static void meet_face(task *t, uint32_t face, const uint32_t corners[3], double scale, founds *to, asking *a)
{
    const soft_meeting *m = t->m;
    double speed = t->speed, time = 0;
    for (int i = 0; i < 3; i++) {
        a->corners[i] = corners[i];
        speed = fmax(speed, t->speed + length_up(vec_sub(m->vertices.to[corners[i]], m->vertices.from[corners[i]])));
    }
    a->tolerance = NEAR * scale;
    a->slack = 0x1p-48 * scale + motion_error(&m->way, 1, isfinite(m->shape->reach) ? m->shape->reach : 0);
    for (int step = 0;; step++) {
        ask_face(a, time);
        double free = a->r.lo - m->separation;
        bool enough = free > 4 * (a->tolerance + a->slack) && step < STEPS_MAX;
        if (!enough) {
            found f = {.contact = {.t_lo = below(time), .t_hi = above(time), .proof = SOFT_CERTAIN}};
            describe(a, face, &f);
            bary_of(m, corners, time, f.point, f.touch.bary);
            double by = time;
            bool met = a->r.hi <= m->separation ||
                       (time < 1 && speed > 0 && meets_by(a, time, fmax(free, a->tolerance) / speed, &by));
            f.contact.proof = met ? SOFT_CERTAIN : step < STEPS_MAX ? SOFT_WITHIN : SOFT_UNDECIDED;
            f.contact.t_hi = met ? above(by) : f.contact.t_lo;
            array_push(to, f);
            return;
        }
        if (!(speed > 0)) return;
        double next = time + free / speed * (1 - 0x1p-40);
        if (!(next < 1)) return;
        time = next;
    }
}

static void meet_faces(void *context, size_t begin, size_t end, unsigned worker)
{
    task *t = context;
    const soft_meeting *m = t->m;
    asking a = {.t = t, .scratch = t->scratch[worker]};
    for (size_t i = t->from + begin; i < t->from + end; i++) {
        uint32_t corners[3];
        soft_mesh_triangle(m->mesh, (uint32_t)i, corners);
        const vec3 *from = m->vertices.from, *to = m->vertices.to;
        vec3 lo = from[corners[0]], hi = lo;
        for (int k = 0; k < 3; k++) {
            lo = vec_min(lo, vec_min(from[corners[k]], to[corners[k]]));
            hi = vec_max(hi, vec_max(from[corners[k]], to[corners[k]]));
        }
        if (!aabb_overlap((aabb){lo, hi}, t->box)) continue;
        double reach = isfinite(m->shape->reach) ? m->shape->reach : 0;
        double scale = reach + fmax(vec_max_abs(lo), vec_max_abs(hi)) + vec_max_abs(m->way.start.p) + m->separation;
        meet_face(t, (uint32_t)i, corners, scale, &t->of[worker], &a);
    }
    t->units += a.units + A_BOX * (end - begin);
}

static int compare_found(const void *x, const void *y)
{
    uint32_t a = ((const found *)x)->contact.a, b = ((const found *)y)->contact.a;
    return (a > b) - (a < b);
}

static void keep_all(task *t, soft_result *out)
{
    founds all = {0};
    for (unsigned i = 0; i < WORKERS_MAX; i++)
        for (size_t k = 0; k < t->of[i].count; k++) array_push(&all, t->of[i].at[k]);
    if (all.count) qsort(all.at, all.count, sizeof *all.at, compare_found);
    out->count = all.count;
    out->contacts = base_alloc(all.count + 1, sizeof *out->contacts);
    out->touches = base_alloc(all.count + 1, sizeof *out->touches);
    out->safe_lo = 1, out->safe_hi = INFINITY;
    for (size_t i = 0; i < all.count; i++) {
        const found *f = &all.at[i];
        double lo = (double)f->contact.t_lo, hi = (double)f->contact.t_hi;
        out->contacts[i] = f->contact, out->touches[i] = f->touch;
        out->face_shape++;
        out->tally.within += f->contact.proof == SOFT_WITHIN;
        out->tally.undecided += f->contact.proof == SOFT_UNDECIDED;
        if (!isfinite(out->safe_hi)) out->safe_hi = 2;
        if (f->contact.proof == SOFT_CERTAIN) out->safe_hi = fmin(out->safe_hi, hi);
        if (lo < out->safe_lo || !out->has_first) {
            out->has_first = true;
            out->first_lo = lo, out->first_hi = hi, out->first_point = f->point;
            out->first_normal = vec((double)f->touch.normal[0], (double)f->touch.normal[1], (double)f->touch.normal[2]);
        }
        out->safe_lo = fmin(out->safe_lo, lo);
    }
    array_free(&all);
}

/* Faces in portions of a fixed size: where it ends, if it takes too much, follows from counts. */
void soft_rigid_meet(world *w, const soft_meeting *m, soft_result *out)
{
    enum { PORTION = 4096 };
    task *t = base_zalloc(1, sizeof *t);
    size_t faces = soft_mesh_triangle_count(m->mesh), done = 0;
    bool turns = vec_norm(m->way.angular) > 0;
    double arm = turns ? m->shape->reach + length_up(m->shape->local.p) : 0;
    t->m = m, t->scratch = w->scratch;
    t->speed = (length_up(m->way.linear) + (turns ? vec_norm(m->way.angular) * arm : 0)) * (1 + 0x1p-40);
    t->box = aabb_grow(motion_bounds(&m->way, &m->shape->shape, m->shape->local, 1), m->separation * (1 + 0x1p-40));
    for (; done < faces && t->units <= m->units; done += PORTION) {
        size_t count = faces - done < PORTION ? faces - done : PORTION;
        t->from = done;
        workers_run(w->workers, count, A_CHUNK, meet_faces, t);
    }
    keep_all(t, out);
    if (done < faces) {
        out->unfinished = true;
        out->safe_lo = 0;
        w->figures.soft_unfinished++;
    }
    for (unsigned i = 0; i < WORKERS_MAX; i++) array_free(&t->of[i]);
    free(t);
}

/* ---- pairs ---- */

static motion way_of_rigid(const world *w, const body *b, bool stands)
{
    (void)w;
    return motion_between(stands ? b->pose : body_before(b), b->pose, 1);
}

static void meet_pair(world *w, const collider *soft, const collider *rigid, const soft_place *p,
    soft_positions vertices, soft_result *r, bool stands)
{
    enum { UNITS_MOST = 400000 /* some 4 ms */, CASES = 4 };
    const body *b = &w->bodies.at[rigid->body];
    double separation = r->separation + p->half_thickness;
    const soft_meeting m = {.vertices = vertices,
        .mesh = soft->shape.soft,
        .shape = rigid,
        .way = way_of_rigid(w, b, stands),
        .separation = separation,
        .units = w->slice == UINT64_MAX ? CASES * UNITS_MOST : UNITS_MOST};
    soft_rigid_meet(w, &m, r);
}

/* For each separation that somebody wants of it; `stands`: as if the rigid body had not moved. */
static void meet_for_all(world *w, uint32_t soft_id, uint32_t rigid_id, const soft_place *p, soft_positions vertices,
    bool proposed, int64_t frame)
{
    const collider *soft = &w->colliders.at[soft_id], *rigid = &w->colliders.at[rigid_id];
    bool first = colliders_in_order(w, soft, rigid);
    pair_terms terms = pair_get_terms(w, &w->bodies.at[soft->body], &w->bodies.at[rigid->body]);
    size_t before = w->soft->results.count;
    for (uint32_t id = 0; terms.checked && id < w->subscriptions.count; id++) {
        if (!soft_is_wanted(w, id, &w->bodies.at[soft->body], &w->bodies.at[rigid->body])) continue;
        double separation = soft_separation(&w->subscriptions.at[id], terms.padding);
        bool there = false;
        for (size_t k = before; k < w->soft->results.count; k++)
            there |= w->soft->results.at[k].separation == separation;
        if (there) continue;
        soft_result r = {.tick = w->figures.ticks,
            .key = pair_key(first ? soft_id : rigid_id, first ? rigid_id : soft_id),
            .a = first ? soft_id : rigid_id,
            .b = first ? rigid_id : soft_id,
            .separation = separation,
            .proposed = proposed,
            .frame_a = first ? frame : 0,
            .frame_b = first ? 0 : frame};
        meet_pair(w, soft, rigid, p, vertices, &r, proposed);
        if (!first) { /* as seen from A */
            r.first_normal = vec_neg(r.first_normal);
            for (size_t i = 0; i < r.count; i++)
                for (int k = 0; k < 3; k++) r.touches[i].normal[k] = -r.touches[i].normal[k];
        }
        array_push(&w->soft->results, r);
    }
}

void soft_rigid_pair(world *w, const pair *p, uint64_t decided)
{
    bool a_is = collider_is_soft(&w->colliders.at[p->a]);
    uint32_t soft = a_is ? p->a : p->b, rigid = a_is ? p->b : p->a;
    const soft_place *at = soft_place_of(w, &w->bodies.at[w->colliders.at[soft].body]);
    if (!at) return;
    bool goes = at->way_tick > decided, late = goes && at->way_tick != w->figures.ticks;
    size_t before = w->soft->results.count;
    meet_for_all(w, soft, rigid, at, (soft_positions){goes ? at->from : at->at, at->at}, false, at->frame);
    for (size_t i = before; late && i < w->soft->results.count; i++) /* how the rigid one came is not known any more */
        w->soft->results.at[i].unfinished = true, w->soft->results.at[i].safe_lo = 0;
}

typedef struct beside {
    const world *w;
    ARRAY(uint32_t) rigid;
} beside;

static bool list_rigid(void *context, uint32_t id)
{
    beside *b = context;
    const collider *s = &b->w->colliders.at[id];
    if (!collider_is_soft(s) && !s->ghost && !b->w->bodies.at[s->body].ghost) array_push(&b->rigid, id);
    return true;
}

static int compare_rigid_ids(const void *x, const void *y)
{
    uint32_t a = *(const uint32_t *)x, b = *(const uint32_t *)y;
    return (a > b) - (a < b);
}

void soft_rigid_proposal(world *w, soft_place *p, const soft_frame *f)
{
    beside near = {.w = w};
    vec3 lo = p->at[0], hi = lo;
    double widest = 0;
    for (size_t i = 0; i < p->count; i++) {
        lo = vec_min(lo, vec_min(p->at[i], f->at[i]));
        hi = vec_max(hi, vec_max(p->at[i], f->at[i]));
    }
    for (size_t i = 0; i < w->subscriptions.count; i++)
        if (w->subscriptions.at[i].used) widest = fmax(widest, w->subscriptions.at[i].threshold);
    widest += p->half_thickness + w->bodies.at[p->body].rule_reach;
    broad_query_box(w->broad, aabb_grow((aabb){lo, hi}, widest * (1 + 0x1p-40)), list_rigid, &near);
    if (near.rigid.count) qsort(near.rigid.at, near.rigid.count, sizeof *near.rigid.at, compare_rigid_ids);
    for (size_t i = 0; i < near.rigid.count; i++)
        meet_for_all(w, p->collider, near.rigid.at[i], p, (soft_positions){p->at, f->at}, true, f->frame);
    array_free(&near.rigid);
}
