/* check_edge: a straight line in joint space, stretch by stretch. Configurations are computed four side by side; what a
 * stretch is proven by is tried from the cheapest on: the ball around a link, its smaller balls, exact shapes. */
#include "check_robot.h"

#include <stdlib.h>
#include <string.h>

typedef struct edge_sample { /* a configuration on the line */
    double t;
    check_frame *frames; /* of each link that has shapes */
    double *coarse;      /* of each: the clearance of the ball around it, up to edge_link.cap; NAN: not asked */
    double *fine;        /* of each ball; NAN in the first one of a link: not asked */
    double *least;       /* of each link: the least of its balls' */
    double *apart;       /* of each pair: the distance of the centres of the balls around the links */
    double *deep;        /* of each link, then of each pair: of exact shapes; NAN: not asked */
    double *coordinates;
    pose *poses; /* of all links of the tree, once `posed` */
    bool posed;
} edge_sample;

typedef struct edge_link { /* of this edge */
    double bend;           /* robot_levers_bend */
    double cap;            /* m: more clearance than any stretch can need */
} edge_link;

typedef struct edge_pair { /* of this edge */
    double bend, way;      /* robot_levers_bend, robot_levers_way: of the one link, seen from the other */
} edge_pair;

typedef struct edge_piece {
    uint32_t from, to; /* samples */
} edge_piece;

typedef struct edge_work {
    const check_robot *robot; /* for whom the memory is laid out */
    ARRAY(double *) blocks;   /* the memory of samples, which is kept */
    ARRAY(edge_sample) samples;
    edge_link *links;
    edge_pair *pairs;
    double *change;
    ARRAY(edge_piece) pieces, next;
    ARRAY(uint64_t) open, next_open; /* `words` a piece: a bit for each link, then for each pair */
    size_t words;
    /* of the edge at hand */
    const scene *scene;
    const check_request *request;
    check_scratch *scratch;
    check_result *result;
    const double *origin;
    double hit;       /* the earliest time at which something was found to meet; 2 = none */
    uint32_t effort;  /* of CHECK_EFFORT_MAX */
    double undecided; /* the earliest start of a stretch that was given up; 2 = none */
} edge_work;

void check_edge_free(void *edge)
{
    edge_work *e = edge;
    if (!e) return;
    for (size_t i = 0; i < e->blocks.count; i++) free(e->blocks.at[i]);
    array_free(&e->blocks);
    array_free(&e->samples);
    free(e->links);
    free(e->pairs);
    free(e->change);
    array_free(&e->pieces);
    array_free(&e->next);
    array_free(&e->open);
    array_free(&e->next_open);
    free(e);
}

static edge_work *edge_begin(const check_robot *r, check_scratch *scratch)
{
    edge_work *e = scratch->edge;
    if (e && e->robot == r) return e;
    check_edge_free(e);
    scratch->edge = e = base_zalloc(1, sizeof *e);
    e->robot = r;
    e->links = base_alloc(r->links.count + 1, sizeof *e->links);
    e->pairs = base_alloc(r->between.count + 1, sizeof *e->pairs);
    e->change = base_alloc(robot_tree_coordinates(r->tree) + 1, sizeof *e->change);
    e->words = (r->links.count + r->between.count + 63) / 64;
    return e;
}

/* Memory for one more sample: all in one block. */
static edge_sample *new_sample(edge_work *e)
{
    const check_robot *r = e->robot;
    size_t links = r->links.count, pairs = r->between.count, balls = r->x.count, n = robot_tree_coordinates(r->tree);
    size_t frames = sizeof(check_frame) / sizeof(double), poses = sizeof(pose) / sizeof(double);
    size_t all = links * (frames + 3) + balls + 2 * pairs + n + robot_tree_links(r->tree) * poses + 1;
    if (e->samples.count == e->blocks.count) array_push(&e->blocks, base_alloc(all, sizeof(double)));
    double *at = e->blocks.at[e->samples.count];
    edge_sample s = {.frames = (check_frame *)at};
    at += links * frames;
    s.coarse = at, at += links;
    s.least = at, at += links;
    s.deep = at, at += links + pairs;
    s.fine = at, at += balls;
    s.apart = at, at += pairs;
    s.coordinates = at, at += n;
    s.poses = (pose *)at;
    for (size_t i = 0; i < links; i++) s.coarse[i] = s.fine[r->links.at[i].first_ball] = NAN;
    for (size_t i = 0; i < links + pairs; i++) s.deep[i] = NAN;
    array_push(&e->samples, s);
    return &e->samples.at[e->samples.count - 1];
}

static bool is_open(const uint64_t *open, size_t i)
{
    return open[i >> 6] >> (i & 63) & 1;
}

LANES_INLINE void whole_centres(const robot_frames *f, vec3 v, lanes out[3])
{
    for (int k = 0; k < 3; k++) out[k] = f->x[k] * v.x + f->y[k] * v.y + f->z[k] * v.z + f->p[k];
}

/* Up to four times: their configurations, and the clearances of the balls around those links that `open` names. */
static void add_samples(edge_work *e, const double *times, int count, const uint64_t *open)
{
    const check_robot *r = e->robot;
    size_t n = robot_tree_coordinates(r->tree);
    lanes t = {0}, values[ROBOT_LINKS_MAX];
    for (int k = 0; k < LANES; k++) t[k] = times[k < count ? k : 0];
    for (size_t c = 0; c < n; c++) values[c] = e->origin[c] + t * e->change[c];
    robot_frames frames[ROBOT_LINKS_MAX];
    robot_tree_forward_lanes(r->tree, values, frames);
    edge_sample *samples[LANES];
    array_reserve(&e->samples, e->samples.count + LANES);
    for (int k = 0; k < count; k++) {
        samples[k] = new_sample(e);
        samples[k]->t = times[k];
        for (size_t c = 0; c < n; c++) samples[k]->coordinates[c] = values[c][k];
        for (size_t i = 0; i < r->links.count; i++)
            samples[k]->frames[i] = frame_of_lane(&frames[r->links.at[i].link], k);
    }
    for (size_t i = 0; i < r->links.count; i++) {
        if (!is_open(open, i)) continue;
        const check_link *l = &r->links.at[i];
        lanes centre[3], radius = (lanes){0} + l->whole.radius, clearance = (lanes){0} + e->links[i].cap;
        whole_centres(&frames[l->link], l->whole.centre, centre);
        scene_clearance(e->scene, l->link, centre, &radius, &clearance);
        for (int k = 0; k < count; k++) samples[k]->coarse[i] = clearance[k];
    }
    for (size_t i = 0; i < r->between.count; i++) {
        if (!is_open(open, r->links.count + i)) continue;
        const check_between *p = &r->between.at[i];
        const check_link *a = &r->links.at[p->a], *b = &r->links.at[p->b];
        lanes from[3], to[3];
        whole_centres(&frames[a->link], a->whole.centre, from);
        whole_centres(&frames[b->link], b->whole.centre, to);
        lanes x = to[0] - from[0], y = to[1] - from[1], z = to[2] - from[2], apart = x * x + y * y + z * z;
        for (int k = 0; k < count; k++) samples[k]->apart[i] = sqrt(apart[k]);
    }
    e->result->samples += (uint32_t)count;
}

static void need_fine(edge_work *e, edge_sample *s, size_t i)
{
    const check_robot *r = e->robot;
    const check_link *l = &r->links.at[i];
    if (!isnan(s->fine[l->first_ball])) return;
    double least = INFINITY;
    for (uint32_t ball = l->first_ball; ball < l->first_ball + l->balls; ball += LANES) {
        lanes centre[3], radius = ball_radii(r, ball), clearance = (lanes){0} + e->links[i].cap;
        ball_centres(r, &s->frames[i], ball, centre);
        scene_clearance(e->scene, l->link, centre, &radius, &clearance);
        for (int k = 0; k < LANES; k++) least = fmin(least, s->fine[ball + (uint32_t)k] = clearance[k]);
    }
    s->least[i] = least;
}

static pose sample_pose(edge_work *e, edge_sample *s, uint32_t shape)
{
    if (!s->posed) robot_tree_forward(e->robot->tree, s->coordinates, s->poses);
    s->posed = true;
    const check_shape *c = &e->robot->shapes.at[shape];
    return pose_mul(s->poses[c->link], c->pose);
}

static void note(edge_work *e, const edge_sample *s, bool meets, uint32_t a, uint32_t b, uint32_t obstacle)
{
    check_result *out = e->result;
    if (!meets || s->t >= e->hit) return;
    e->hit = s->t;
    out->shape_a = e->robot->given.at[a];
    out->shape_b = b == CHECK_NOBODY ? b : e->robot->given.at[b];
    out->obstacle = obstacle;
}

/* Distances are asked for this closely: proofs lose as much, and no more. */
#define DEEP_TOLERANCE_M 1e-5

static double deep_shapes(
    edge_work *e, edge_sample *s, uint32_t a, uint32_t b, uint32_t obstacle, double slack, double within)
{
    const check_robot *r = e->robot;
    bool of_scene = b == CHECK_NOBODY;
    const scene_obstacle_def *def = of_scene ? &e->scene->defs[obstacle] : NULL;
    pose at_a = sample_pose(e, s, a), at_b = of_scene ? def->pose : sample_pose(e, s, b);
    double widen = of_scene ? def->widen_m : 0;
    narrow_result answer;
    const shape *sa = r->shapes.at[a].shape, *sb = of_scene ? def->shape : r->shapes.at[b].shape;
    e->result->queries++;
    e->effort += sa->type >= SHAPE_CONVEX_COUNT || sb->type >= SHAPE_CONVEX_COUNT ? CHECK_DEAR : 1;
    check_exact_distance(r->shapes.at[a].shape, at_a, of_scene ? def->shape : r->shapes.at[b].shape, at_b,
        DEEP_TOLERANCE_M, within + widen, check_key(a, of_scene ? obstacle : b, of_scene), e->scratch, &answer);
    note(e, s, answer.hi <= e->request->margin_m - slack - widen, a, b, obstacle);
    return answer.lo - widen;
}

/* The distance of a link's exact shapes from the scene, up to a few centimetres beyond the margin. */
static void need_deep_link(edge_work *e, edge_sample *s, size_t i)
{
    if (!isnan(s->deep[i])) return;
    const check_robot *r = e->robot;
    const check_link *l = &r->links.at[i];
    double least = e->request->margin_m + l->slack + 2 * l->fatness;
    check_near near = check_near_begin(e->scratch, e->scene);
    for (uint32_t k = l->first_ball; k < l->first_ball + l->balls; k++)
        if (s->fine[k] < least)
            check_near_add(&near, l->link, frame_point(&s->frames[i], vec(r->x.at[k], r->y.at[k], r->z.at[k])),
                r->radius.at[k], least);
    for (size_t k = 0; k < near.count; k++)
        for (uint32_t shape = l->first_shape; shape < l->first_shape + l->shapes; shape++)
            least = fmin(least, deep_shapes(e, s, shape, CHECK_NOBODY, near.sources[k], l->slack, least));
    check_near_end(&near);
    s->deep[i] = least;
}

static void need_deep_pair(edge_work *e, edge_sample *s, size_t pair)
{
    const check_robot *r = e->robot;
    double *deep = &s->deep[r->links.count + pair];
    if (!isnan(*deep)) return;
    const check_between *p = &r->between.at[pair];
    const check_link *a = &r->links.at[p->a], *b = &r->links.at[p->b];
    double least = e->request->margin_m + p->slack + 2 * (a->fatness + b->fatness);
    for (uint32_t i = a->first_shape; i < a->first_shape + a->shapes; i++)
        for (uint32_t k = b->first_shape; k < b->first_shape + b->shapes; k++)
            least = fmin(least, deep_shapes(e, s, i, k, CHECK_NOBODY, p->slack, least));
    *deep = least;
}

/* |A - B| of two rotations given by columns, as an operator: the root of half the sum of all squares. */
static double turned_by(const check_frame *a, const check_frame *b)
{
    double sum = vec_norm2(vec_sub(a->x, b->x)) + vec_norm2(vec_sub(a->y, b->y)) + vec_norm2(vec_sub(a->z, b->z));
    return sqrt(0.5 * sum);
}

LANES_INLINE lanes root(lanes a)
{
    for (int k = 0; k < LANES; k++) a[k] = sqrt(a[k]);
    return a;
}

/* Do all balls of a link pass? */
LANES_INLINE bool balls_pass_any(
    const check_robot *r, const check_link *l, const edge_sample *s0, const edge_sample *s1, size_t i, double beyond)
{
    for (uint32_t ball = l->first_ball; ball < l->first_ball + l->balls; ball += LANES) {
        lanes c0[3], c1[3];
        ball_centres(r, &s0->frames[i], ball, c0);
        ball_centres(r, &s1->frames[i], ball, c1);
        lanes x = c1[0] - c0[0], y = c1[1] - c0[1], z = c1[2] - c0[2];
        lanes sum = *(const lanes_anywhere *)&s0->fine[ball] + *(const lanes_anywhere *)&s1->fine[ball];
        lane_mask free = sum > root(x * x + y * y + z * z) + beyond;
        if (!(free[0] & free[1] & free[2] & free[3])) return false;
    }
    return true;
}

static bool balls_pass_plain(
    const check_robot *r, const check_link *l, const edge_sample *s0, const edge_sample *s1, size_t i, double beyond)
{
    return balls_pass_any(r, l, s0, s1, i, beyond);
}
LANES_WHOLE static bool balls_pass_wide(
    const check_robot *r, const check_link *l, const edge_sample *s0, const edge_sample *s1, size_t i, double beyond)
{
    return balls_pass_any(r, l, s0, s1, i, beyond);
}

static bool prove_link(edge_work *e, edge_sample *s0, edge_sample *s1, size_t i)
{
    const check_link *l = &e->robot->links.at[i];
    double h = s1->t - s0->t, keep = e->request->margin_m + l->slack;
    double beyond = e->links[i].bend * h * h / 4 + 2 * keep;
    vec3 c0 = frame_point(&s0->frames[i], l->whole.centre), c1 = frame_point(&s1->frames[i], l->whole.centre);
    double chord = vec_norm(vec_sub(c1, c0));
    if (s0->coarse[i] + s1->coarse[i] > chord + beyond) return true;
    need_fine(e, s0, i);
    need_fine(e, s1, i);
    if ((lanes_wide() ? balls_pass_wide : balls_pass_plain)(e->robot, l, s0, s1, i, beyond)) return true;
    if (fmin(s0->least[i], s1->least[i]) > keep + 0.5 * l->fatness) return false; /* shorter stretches will do */
    need_deep_link(e, s0, i);
    need_deep_link(e, s1, i);
    double turn = l->extent * turned_by(&s0->frames[i], &s1->frames[i]);
    return s0->deep[i] + s1->deep[i] > chord + turn + beyond;
}

/* A frame seen from another one. */
static check_frame relative_frame(const check_frame *a, const check_frame *b)
{
    mat3 m = {a->x, a->y, a->z};
    return (check_frame){mat_tmul(m, b->x), mat_tmul(m, b->y), mat_tmul(m, b->z), mat_tmul(m, vec_sub(b->p, a->p))};
}

/* The distance of points from segments from u to u + d. */
LANES_INLINE lanes distance_from_segment(const lanes p[3], vec3 u, vec3 d)
{
    lanes x = p[0] - u.x, y = p[1] - u.y, z = p[2] - u.z;
    double length2 = vec_norm2(d);
    lanes s = (x * d.x + y * d.y + z * d.z) * (length2 > 0 ? 1 / length2 : 0);
    for (int k = 0; k < LANES; k++) s[k] = s[k] < 0 ? 0 : s[k] > 1 ? 1 : s[k];
    x -= s * d.x, y -= s * d.y, z -= s * d.z;
    return root(x * x + y * y + z * z);
}

/* Balls of b move along segments in a's frame, but for the bend. The least gap, or less. */
LANES_INLINE double gap_of_pair_any(
    const check_robot *r, const check_link *a, const check_link *b, const check_frame *b0, const check_frame *b1)
{
    double least = INFINITY;
    for (uint32_t i = b->first_ball; i < b->first_ball + b->balls; i++) {
        vec3 v = vec(r->x.at[i], r->y.at[i], r->z.at[i]), u = frame_point(b0, v), d = vec_sub(frame_point(b1, v), u);
        for (uint32_t ball = a->first_ball; ball < a->first_ball + a->balls; ball += LANES) {
            const lanes p[3] = {*(const lanes_anywhere *)&r->x.at[ball], *(const lanes_anywhere *)&r->y.at[ball],
                *(const lanes_anywhere *)&r->z.at[ball]};
            lanes gap = distance_from_segment(p, u, d) - ball_radii(r, ball) - r->radius.at[i];
            for (int k = 0; k < LANES; k++) least = fmin(least, gap[k]);
        }
    }
    return least;
}

static double gap_of_pair_plain(
    const check_robot *r, const check_link *a, const check_link *b, const check_frame *b0, const check_frame *b1)
{
    return gap_of_pair_any(r, a, b, b0, b1);
}
LANES_WHOLE static double gap_of_pair_wide(
    const check_robot *r, const check_link *a, const check_link *b, const check_frame *b0, const check_frame *b1)
{
    return gap_of_pair_any(r, a, b, b0, b1);
}

static bool prove_pair(edge_work *e, edge_sample *s0, edge_sample *s1, size_t pair)
{
    const check_robot *r = e->robot;
    const check_between *p = &r->between.at[pair];
    const check_link *a = &r->links.at[p->a], *b = &r->links.at[p->b];
    double h = s1->t - s0->t, keep = e->request->margin_m + p->slack, bend = e->pairs[pair].bend * h * h / 8;
    double around = a->whole.radius + b->whole.radius + keep;
    if (s0->apart[pair] + s1->apart[pair] > e->pairs[pair].way * h + 2 * around) return true;
    check_frame b0 = relative_frame(&s0->frames[p->a], &s0->frames[p->b]);
    check_frame b1 = relative_frame(&s1->frames[p->a], &s1->frames[p->b]);
    vec3 u = frame_point(&b0, b->whole.centre), d = vec_sub(frame_point(&b1, b->whole.centre), u), c = a->whole.centre;
    const lanes centre[3] = {(lanes){0} + c.x, (lanes){0} + c.y, (lanes){0} + c.z};
    if (distance_from_segment(centre, u, d)[0] > around + bend) return true;
    double gap = (lanes_wide() ? gap_of_pair_wide : gap_of_pair_plain)(r, a, b, &b0, &b1);
    if (gap > keep + bend) return true;
    if (gap > keep + 0.5 * fmin(a->fatness, b->fatness)) return false; /* shorter stretches will do */
    need_deep_pair(e, s0, pair);
    need_deep_pair(e, s1, pair);
    double turn = b->extent * turned_by(&b0, &b1);
    return s0->deep[r->links.count + pair] + s1->deep[r->links.count + pair] > vec_norm(d) + turn + 2 * (keep + bend);
}

/* Tries all that is open of a piece; is anything left? */
static bool prove_piece(edge_work *e, const edge_piece *piece, uint64_t *open)
{
    const check_robot *r = e->robot;
    bool left = false;
    for (size_t w = 0; w < e->words; w++)
        for (uint64_t bits = open[w]; bits; bits &= bits - 1) {
            size_t i = w * 64 + (size_t)__builtin_ctzll(bits);
            edge_sample *s0 = &e->samples.at[piece->from], *s1 = &e->samples.at[piece->to];
            bool proven = i < r->links.count ? prove_link(e, s0, s1, i) : prove_pair(e, s0, s1, i - r->links.count);
            if (proven)
                open[w] &= ~(1ull << (i & 63));
            else
                left = true;
        }
    return left;
}

/* Does anything that is open move farther than the resolution? */
static bool is_worth_halving(const edge_work *e, const edge_piece *piece, const uint64_t *open)
{
    const check_robot *r = e->robot;
    double h = e->samples.at[piece->to].t - e->samples.at[piece->from].t;
    for (size_t i = 0; i < r->links.count + r->between.count; i++) {
        if (!is_open(open, i)) continue;
        const check_between *p = i < r->links.count ? NULL : &r->between.at[i - r->links.count];
        const check_link *l = p ? NULL : &r->links.at[i];
        double way =
            robot_levers_way(&r->levers.at[p ? p->first_joint : l->first_lever], p ? p->joints : l->levers, e->change);
        if (way * h > e->request->resolution_m) return true;
    }
    return false;
}

/* Splits what is left of the pieces; those behind what was found to meet are of no interest. */
static void split_pieces(edge_work *e)
{
    e->next.count = 0;
    e->next_open.count = 0;
    size_t kept = 0;
    for (size_t i = 0; i < e->pieces.count; i++) {
        edge_piece piece = e->pieces.at[i];
        uint64_t *open = &e->open.at[i * e->words];
        double from = e->samples.at[piece.from].t;
        if (from >= e->hit) continue;
        if (!is_worth_halving(e, &piece, open) || e->samples.count + kept + LANES >= CHECK_SAMPLES_MAX ||
            e->effort >= CHECK_EFFORT_MAX) {
            e->undecided = fmin(e->undecided, from);
            continue;
        }
        e->pieces.at[kept] = piece;
        memmove(&e->open.at[kept * e->words], open, e->words * sizeof *open);
        kept++;
    }
    /* A few pieces are cut more often than in two: four times cost what one does. */
    int cuts = kept == 1 ? LANES : kept == 2 ? LANES / 2 : 1;
    double times[LANES];
    uint64_t all[(ROBOT_LINKS_MAX + CHECK_PAIRS_MAX + 63) / 64];
    for (size_t first = 0; first < kept;) {
        size_t group = 0;
        int count = 0;
        memset(all, 0, e->words * sizeof *all);
        while (first + group < kept && count + cuts <= LANES) {
            const edge_piece *p = &e->pieces.at[first + group];
            double t0 = e->samples.at[p->from].t, t1 = e->samples.at[p->to].t;
            for (int k = 1; k <= cuts; k++) times[count++] = t0 + (t1 - t0) * k / (cuts + 1);
            for (size_t w = 0; w < e->words; w++) all[w] |= e->open.at[(first + group) * e->words + w];
            group++;
        }
        uint32_t sample = (uint32_t)e->samples.count;
        add_samples(e, times, count, all);
        for (size_t i = first; i < first + group; i++) {
            edge_piece p = e->pieces.at[i];
            for (int k = 0; k <= cuts; k++) {
                edge_piece part = {k == 0 ? p.from : sample + (uint32_t)k - 1, k == cuts ? p.to : sample + (uint32_t)k};
                array_push(&e->next, part);
                for (size_t w = 0; w < e->words; w++) array_push(&e->next_open, e->open.at[i * e->words + w]);
            }
            sample += (uint32_t)cuts;
        }
        first += group;
    }
}

static void swap_pieces(edge_work *e)
{
    void *pieces = e->pieces.at, *open = e->open.at;
    size_t capacity = e->pieces.capacity, open_capacity = e->open.capacity;
    e->pieces.at = e->next.at, e->pieces.count = e->next.count, e->pieces.capacity = e->next.capacity;
    e->open.at = e->next_open.at, e->open.count = e->next_open.count, e->open.capacity = e->next_open.capacity;
    e->next.at = pieces, e->next.capacity = capacity;
    e->next_open.at = open, e->next_open.capacity = open_capacity;
}

/* The whole line, in three stretches to begin with. */
static void begin_pieces(edge_work *e)
{
    const check_robot *r = e->robot;
    size_t items = r->links.count + r->between.count;
    e->samples.count = e->pieces.count = e->open.count = 0;
    array_reserve(&e->open, 3 * e->words + 1);
    for (size_t w = 0; w < 3 * e->words; w++) {
        size_t left = items - w % e->words * 64;
        array_push(&e->open, left >= 64 ? UINT64_MAX : (1ull << left) - 1);
    }
    const double times[LANES] = {0, 1.0 / 3, 2.0 / 3, 1};
    add_samples(e, times, LANES, e->open.at);
    for (uint32_t i = 0; i < 3; i++) array_push(&e->pieces, ((edge_piece){i, i + 1}));
}

static void begin_edge(edge_work *e, const double *from, const double *to)
{
    const check_robot *r = e->robot;
    e->origin = from;
    e->hit = e->undecided = 2;
    e->effort = 0;
    for (size_t c = 0; c < robot_tree_coordinates(r->tree); c++) e->change[c] = to[c] - from[c];
    for (size_t i = 0; i < r->links.count; i++) {
        const check_link *l = &r->links.at[i];
        const robot_lever *levers = &r->levers.at[l->first_lever];
        double bend = robot_levers_bend(levers, l->levers, e->change);
        double way = robot_levers_way(levers, l->levers, e->change);
        e->links[i].bend = bend;
        e->links[i].cap = 2 * (e->request->margin_m + l->slack) + way / 3 + bend / 36 + 1e-9 * r->reach;
    }
    for (size_t i = 0; i < r->between.count; i++) {
        const check_between *p = &r->between.at[i];
        const robot_lever *levers = &r->levers.at[p->first_joint];
        e->pairs[i].bend = robot_levers_bend(levers, p->joints, e->change);
        e->pairs[i].way = robot_levers_way(levers, p->joints, e->change);
    }
}

static int compare_times(const void *a, const void *b)
{
    double x = *(const double *)a, y = *(const double *)b;
    return x < y ? -1 : x > y;
}

void check_edge(const check_robot *r, const scene *s, const check_request *request, const double *from,
    const double *to, check_scratch *scratch, check_result *result, double *times, size_t *time_count)
{
    edge_work *e = edge_begin(r, scratch);
    *result = (check_result){CHECK_FREE, 1, 1, -INFINITY, INFINITY, CHECK_NOBODY, CHECK_NOBODY, CHECK_NOBODY, 0, 0};
    e->scene = s, e->request = request, e->scratch = scratch, e->result = result;
    begin_edge(e, from, to);
    begin_pieces(e);
    double first_open = 1;
    while (e->pieces.count > 0) {
        size_t left = 0;
        for (size_t i = 0; i < e->pieces.count; i++) {
            edge_piece piece = e->pieces.at[i];
            if (e->samples.at[piece.from].t >= e->hit) continue;
            if (!prove_piece(e, &piece, &e->open.at[i * e->words])) continue;
            e->pieces.at[left] = piece;
            memmove(&e->open.at[left * e->words], &e->open.at[i * e->words], e->words * sizeof *e->open.at);
            left++;
        }
        e->pieces.count = left;
        first_open = left > 0 ? e->samples.at[e->pieces.at[0].from].t : first_open;
        if (e->hit <= 1 && !request->find_first) break;
        split_pieces(e);
        swap_pieces(e);
    }
    bool met = e->hit <= 1;
    result->verdict = met ? CHECK_MEETS : e->undecided <= 1 ? CHECK_UNDECIDED : CHECK_FREE;
    if (met) result->first_hi = e->hit;
    result->first_lo = fmin(fmin(e->undecided, result->first_hi), e->pieces.count > 0 ? first_open : 1);
    if (times) {
        *time_count = e->samples.count;
        for (size_t i = 0; i < e->samples.count; i++) times[i] = e->samples.at[i].t;
        qsort(times, *time_count, sizeof *times, compare_times);
    }
}
