/* soft_rigid: a soft surface beside a rigid shape, each on its way: which of its faces meet it, and when. In portions,
 * as parts of jobs (soft_jobs.c). Tick thread, and the pool, one face at a time.
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

#include <stdatomic.h>
#include <stdlib.h>

enum {
    STEPS_MAX = 48,
    LOOKS_MAX = 8,
    A_DEPTH = 3000, /* more, where they overlap: a depth is found, too */
    A_QUERY = 60,   /* units of 10 ns */
    BOXES = 16384,  /* faces whose boxes are looked at in a portion, ... */
    A_CHUNK = 1024, /* ... so many in one list */
    CHUNKS = BOXES / A_CHUNK,
    PORTION = 200000, /* units that a portion of faces takes about, ... */
    QUERIES = 8,      /* ... which ask so often, mostly; ... */
    FACES_LEAST = 8,  /* ... but so many, or fewer, in any case */
    FACES_MOST = 1024
};
static const double NEAR = 1e-9; /* of the sizes: as near as steps go */
enum { FACE_SHAPE = 3 };

typedef struct found { /* by one worker */
    soft_contact contact;
    struct soft_touch touch;
    vec3 point;
} found;
typedef ARRAY(found) founds;

typedef struct soft_meeting { /* a surface and a shape, and their ways */
    soft_positions vertices;
    const soft_mesh *mesh;
    const collider *shape;
    motion way;        /* of its body, in a span of 1 */
    double separation; /* m, with the half thickness */
} soft_meeting;

typedef struct soft_task {
    soft_meeting meeting;
    const soft_meeting *m;
    aabb box;     /* of the shape's way, wider by the separation */
    double speed; /* m a step: of any point of the shape */
    uint64_t a_query;
    void *const *scratch;
    founds of[WORKERS_MAX];
    ARRAY(uint32_t) near[CHUNKS]; /* of a portion of faces: whose boxes meet that */
    size_t near_first[CHUNKS + 1];
    size_t looked, tested; /* faces whose boxes have been looked at, at all; of the near ones */
    _Atomic uint64_t units;
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
    a->units += a->t->a_query + (a->r.lo <= 0 ? A_DEPTH : 0);
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

static aabb box_of_face(const soft_meeting *m, const uint32_t corners[3])
{
    const vec3 *from = m->vertices.from, *to = m->vertices.to;
    aabb b = {from[corners[0]], from[corners[0]]};
    for (int k = 0; k < 3; k++) {
        b.lo = vec_min(b.lo, vec_min(from[corners[k]], to[corners[k]]));
        b.hi = vec_max(b.hi, vec_max(from[corners[k]], to[corners[k]]));
    }
    return b;
}

static void look_at_boxes(void *context, size_t begin, size_t end, unsigned worker)
{
    (void)worker;
    task *t = context;
    size_t faces = soft_mesh_triangle_count(t->m->mesh);
    for (size_t chunk = begin; chunk < end; chunk++) {
        size_t first = t->looked + chunk * A_CHUNK, last = first + A_CHUNK < faces ? first + A_CHUNK : faces;
        t->near[chunk].count = 0;
        for (size_t i = first; i < last; i++) {
            uint32_t corners[3];
            soft_mesh_triangle(t->m->mesh, (uint32_t)i, corners);
            if (aabb_overlap(box_of_face(t->m, corners), t->box)) array_push(&t->near[chunk], (uint32_t)i);
        }
    }
}

static void meet_faces(void *context, size_t begin, size_t end, unsigned worker)
{
    task *t = context;
    const soft_meeting *m = t->m;
    asking a = {.t = t, .scratch = t->scratch[worker]};
    size_t chunk = 0;
    for (size_t i = t->tested + begin; i < t->tested + end; i++) {
        while (t->near_first[chunk + 1] <= i) chunk++;
        uint32_t face = t->near[chunk].at[i - t->near_first[chunk]], corners[3];
        soft_mesh_triangle(m->mesh, face, corners);
        aabb b = box_of_face(m, corners);
        double reach = isfinite(m->shape->reach) ? m->shape->reach : 0;
        double scale = reach + fmax(vec_max_abs(b.lo), vec_max_abs(b.hi)) + vec_max_abs(m->way.start.p) + m->separation;
        meet_face(t, face, corners, scale, &t->of[worker], &a);
    }
    t->units += a.units;
}

static int compare_found(const void *x, const void *y)
{
    uint32_t a = ((const found *)x)->contact.a, b = ((const found *)y)->contact.a;
    return (a > b) - (a < b);
}

/* The first `most`; all are counted. */
static void keep_all(task *t, size_t most, soft_result *out)
{
    founds all = {0};
    for (unsigned i = 0; i < WORKERS_MAX; i++)
        for (size_t k = 0; k < t->of[i].count; k++) array_push(&all, t->of[i].at[k]);
    if (all.count) qsort(all.at, all.count, sizeof *all.at, compare_found);
    out->count = all.count < most ? all.count : most;
    out->tally.left_out = all.count - out->count;
    out->contacts = base_alloc(out->count + 1, sizeof *out->contacts);
    out->touches = base_alloc(out->count + 1, sizeof *out->touches);
    out->safe_lo = 1, out->safe_hi = INFINITY;
    for (size_t i = 0; i < all.count; i++) {
        const found *f = &all.at[i];
        double lo = (double)f->contact.t_lo, hi = (double)f->contact.t_hi;
        if (i < out->count) out->contacts[i] = f->contact, out->touches[i] = f->touch;
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

/* Of a mesh by its tree, of others by all that they consist of. */
static uint64_t price_of_query(const collider *shape)
{
    double each = shape->shape.type == SHAPE_MESH ? 20000 : (double)shape->apart;
    return A_QUERY + (uint64_t)(each / 10);
}

static task *begin_task(const world *w, const soft_meeting *meeting)
{
    task *t = base_zalloc(1, sizeof *t);
    const soft_meeting *m = t->m = &t->meeting;
    t->meeting = *meeting;
    bool turns = vec_norm(m->way.angular) > 0;
    double arm = turns ? m->shape->reach + length_up(m->shape->local.p) : 0;
    t->scratch = w->scratch;
    t->speed = (length_up(m->way.linear) + (turns ? vec_norm(m->way.angular) * arm : 0)) * (1 + 0x1p-40);
    t->box = aabb_grow(motion_bounds(&m->way, &m->shape->shape, m->shape->local, 1), m->separation * (1 + 0x1p-40));
    t->a_query = price_of_query(m->shape);
    return t;
}

void soft_rigid_drop(task *t)
{
    if (!t) return;
    for (unsigned i = 0; i < WORKERS_MAX; i++) array_free(&t->of[i]);
    for (size_t i = 0; i < CHUNKS; i++) array_free(&t->near[i]);
    free(t);
}

/* False: there is no more to do. */
static bool meet_on(world *w, task *t, uint64_t *units)
{
    size_t faces = soft_mesh_triangle_count(t->m->mesh), near = t->near_first[CHUNKS];
    t->units = 0;
    if (t->tested == near) {
        if (t->looked == faces) return false;
        size_t count = faces - t->looked < BOXES ? faces - t->looked : BOXES;
        size_t chunks = (count + A_CHUNK - 1) / A_CHUNK;
        workers_run(w->workers, chunks, 1, look_at_boxes, t);
        for (size_t i = 0; i < CHUNKS; i++)
            t->near_first[i + 1] = t->near_first[i] + (i < chunks ? t->near[i].count : 0);
        t->looked += count;
        t->tested = 0;
        *units = count;
        return true;
    }
    size_t most = (size_t)(PORTION / (QUERIES * t->a_query + A_DEPTH)), left = near - t->tested;
    most = most < FACES_LEAST ? FACES_LEAST : most > FACES_MOST ? FACES_MOST : most;
    size_t count = left < most ? left : most;
    workers_run(w->workers, count, FACES_LEAST, meet_faces, t);
    t->tested += count;
    *units = t->units;
    return true;
}

/* ---- pairs ---- */

static soft_meeting meeting_of(const world *w, const soft_job *j, const soft_beside *b)
{
    const soft_place *p = j->places.at[0];
    const collider *rigid = &w->colliders.at[b->rigid];
    soft_positions way = {b->goes ? p->from : p->at, p->at};
    if (j->proposed) way = (soft_positions){p->at, j->proposal.at};
    return (soft_meeting){.vertices = way,
        .mesh = p->mesh,
        .shape = rigid,
        .way = b->way,
        .separation = b->separation + p->half_thickness};
}

static void take_result(world *w, soft_job *j, const soft_beside *b, bool unfinished)
{
    const soft_place *p = j->places.at[0];
    const collider *soft = &w->colliders.at[p->collider], *rigid = &w->colliders.at[b->rigid];
    bool first = colliders_in_order(w, soft, rigid);
    int64_t frame = j->proposed ? j->proposal.frame : p->frame;
    soft_result r = {.a = first ? p->collider : b->rigid,
        .b = first ? b->rigid : p->collider,
        .separation = b->separation,
        .proposed = j->proposed,
        .frame_a = first ? frame : 0,
        .frame_b = first ? 0 : frame};
    r.key = pair_key(r.a, r.b);
    size_t kept = 0;
    for (size_t i = 0; i < j->results.count; i++) kept += j->results.at[i].count;
    size_t room = kept < SOFT_CONTACTS_MOST ? SOFT_CONTACTS_MOST - kept : 0;
    keep_all(j->task, b->most < room ? b->most : room, &r);
    if (unfinished || b->is_late) r.unfinished = true, r.safe_lo = 0;
    w->figures.soft_unfinished += unfinished;
    if (!first) { /* as seen from A */
        r.first_normal = vec_neg(r.first_normal);
        for (size_t i = 0; i < r.count; i++)
            for (int k = 0; k < 3; k++) r.touches[i].normal[k] = -r.touches[i].normal[k];
    }
    soft_result_hash(&r);
    array_push(&j->results, r);
}

uint64_t soft_rigid_portion(world *w, soft_job *j, bool give_up)
{
    uint64_t units = 1;
    if (j->beside == j->besides.count) {
        j->stage = SOFT_DONE;
        return units;
    }
    const soft_beside *b = &j->besides.at[j->beside];
    bool gone = b->rigid == WORLD_NONE, more = false;
    if (!gone) {
        if (!j->task) {
            const soft_meeting m = meeting_of(w, j, b);
            j->task = begin_task(w, &m);
        }
        j->task->meeting.shape = &w->colliders.at[b->rigid]; /* colliders may have moved in memory */
        more = !give_up && meet_on(w, j->task, &units);
        if (!more) take_result(w, j, b, give_up);
    }
    if (more) return units;
    soft_rigid_drop(j->task);
    j->task = NULL;
    j->beside++;
    return units;
}

void soft_rigid_forget(world *w, uint32_t collider_id)
{
    for (size_t i = 0; i < w->soft->jobs.count; i++) {
        soft_job *j = w->soft->jobs.at[i];
        for (size_t k = 0; k < j->besides.count; k++)
            if (j->besides.at[k].rigid == collider_id) j->besides.at[k].rigid = WORLD_NONE;
    }
}

/* For each separation that somebody wants of it. */
static void add_besides(world *w, soft_job *j, uint32_t rigid_id, const soft_beside *like)
{
    const body *soft = &w->bodies.at[j->places.at[0]->body], *rigid = &w->bodies.at[w->colliders.at[rigid_id].body];
    pair_terms terms = pair_get_terms(w, soft, rigid);
    size_t before = j->besides.count;
    for (uint32_t id = 0; terms.checked && id < w->subscriptions.count; id++) {
        if (!soft_is_wanted(w, id, soft, rigid)) continue;
        soft_beside b = *like;
        b.separation = soft_separation(&w->subscriptions.at[id], terms.padding);
        b.most = soft_most_of(&w->subscriptions.at[id]);
        size_t k = before;
        while (k < j->besides.count && j->besides.at[k].separation != b.separation) k++;
        if (k == j->besides.count)
            array_push(&j->besides, b);
        else if (b.most > j->besides.at[k].most)
            j->besides.at[k].most = b.most;
    }
}

static soft_job *job_beside(world *w, soft_place *p)
{
    if (p->beside) return p->beside;
    soft_job *j = p->beside = soft_job_create(w);
    array_push(&j->places, p);
    j->stands = j->fresh = true;
    j->stage = SOFT_BESIDE;
    return j;
}

void soft_rigid_ask(world *w, const pair *p, uint64_t since)
{
    bool a_is = collider_is_soft(&w->colliders.at[p->a]);
    uint32_t soft = a_is ? p->a : p->b, rigid = a_is ? p->b : p->a;
    soft_place *at = soft_place_of(w, &w->bodies.at[w->colliders.at[soft].body]);
    if (!at) return;
    const body *b = &w->bodies.at[w->colliders.at[rigid].body];
    bool goes = at->way_tick > since, now = at->way_tick == w->figures.ticks;
    const soft_beside like = {.rigid = rigid,
        .way = motion_between(body_before(b), b->pose, 1),
        .goes = goes,
        .is_late = b->changed_before > since || (goes && !now && b->changed_tick > since)};
    add_besides(w, job_beside(w, at), rigid, &like);
}

typedef struct neighbours {
    const world *w;
    ARRAY(uint32_t) rigid;
} neighbours;

static bool list_rigid(void *context, uint32_t id)
{
    neighbours *b = context;
    const collider *s = &b->w->colliders.at[id];
    if (!collider_is_soft(s) && !s->ghost && !b->w->bodies.at[s->body].ghost) array_push(&b->rigid, id);
    return true;
}

static int compare_rigid_ids(const void *x, const void *y)
{
    uint32_t a = *(const uint32_t *)x, b = *(const uint32_t *)y;
    return (a > b) - (a < b);
}

void soft_rigid_gather(world *w, soft_job *j)
{
    neighbours near = {.w = w};
    const soft_place *p = j->places.at[0];
    double widest = 0;
    for (size_t i = 0; i < w->subscriptions.count; i++)
        if (w->subscriptions.at[i].used) widest = fmax(widest, w->subscriptions.at[i].threshold);
    widest += p->half_thickness + w->bodies.at[p->body].rule_reach;
    aabb way = {vec_min(p->box.lo, j->proposal.box.lo), vec_max(p->box.hi, j->proposal.box.hi)};
    broad_query_box(w->broad, aabb_grow(way, widest * (1 + 0x1p-40)), list_rigid, &near);
    if (near.rigid.count) qsort(near.rigid.at, near.rigid.count, sizeof *near.rigid.at, compare_rigid_ids);
    for (size_t i = 0; i < near.rigid.count; i++) {
        const body *b = &w->bodies.at[w->colliders.at[near.rigid.at[i]].body];
        const soft_beside like = {.rigid = near.rigid.at[i], .way = motion_between(b->pose, b->pose, 1)};
        add_besides(w, j, near.rigid.at[i], &like);
    }
    array_free(&near.rigid);
}
