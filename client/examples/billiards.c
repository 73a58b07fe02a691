/* billiards: sixteen balls on a table with four cushions, and a break shot. Balls glide in straight lines from impact
 * to impact, so that the daemon's predicting is exact: the simulation goes from the heap's earliest impact to the
 * next, whenever that is, and has no time step.
 *
 * With losses, rolling slows the balls: a path is then no longer what its velocity predicts. Each body states by how
 * much it may accelerate (collided_body_def.acceleration_m_s2); what is predicted is then a time before which there is
 * certainly no contact. The simulation goes there and asks again; as the balls come nearer the bound comes nearer to
 * the truth, quadratically, until they are within the tolerance. One thread. */
#include "impact_scene.h"

#include <math.h>

enum { BALLS = 16, CUSHIONS = 4, POINTS_MAX = 256 };

const double TABLE_X = 1.27, TABLE_Y = 0.635, BALL_RADIUS = 0.028575;
static const double BALL_MASS = 0.17, BREAK_M_S = 8, RACK_X = 0.635;
static const double RACK_GAP = 1e-4;    /* m: balls are never quite in touch */
static const double ROLLING_M_S2 = 0.1; /* 0.01 g */
static const double BALL_RESTITUTION = 0.95, CUSHION_RESTITUTION = 0.75;
static const double HORIZON_S = 0.5, TOLERANCE_M = 1e-9;
static const double NOW_S = 1e-9;    /* predicted for so soon: it is there */
static const double BESIDE_S = 1e-3; /* two that part within the tolerance: look again after this */

/* ---- the table ---- */

static rigid ball_at(int number, double x, double y)
{
    static const char *const NAMES[BALLS] = {"ball_cue", "ball_1", "ball_2", "ball_3", "ball_4", "ball_5", "ball_6",
        "ball_7", "ball_8", "ball_9", "ball_10", "ball_11", "ball_12", "ball_13", "ball_14", "ball_15"};
    return (rigid){
        .name = NAMES[number], .inverse_mass = 1 / BALL_MASS, .position = {x, y, 0}, .orientation = {1, 0, 0, 0}};
}

static void add_cushion(lockstep *l, const char *name, double x, double y)
{
    static const double THICK = 0.1;
    collided_shape box =
        x != 0 ? collided_box(THICK, 2 * TABLE_Y + 2 * THICK, 0.1) : collided_box(2 * TABLE_X + 2 * THICK, THICK, 0.1);
    rigid body = {.name = name, .orientation = {1, 0, 0, 0}};
    body.position.x = x + copysign(x != 0 ? THICK / 2 : 0, x);
    body.position.y = y + copysign(y != 0 ? THICK / 2 : 0, y);
    lockstep_body(l, body, box, 0);
}

/* The rack is a little uneven, as racks are: each ball stands off its place by up to a third of the gap. */
static void lay_out(lockstep *l, bool real)
{
    double acceleration = real ? ROLLING_M_S2 : 0, pitch = 2 * BALL_RADIUS + RACK_GAP;
    rigid cue = ball_at(0, -RACK_X, 0.02);
    cue.linear = (vector){BREAK_M_S, -0.1, 0};
    lockstep_body(l, cue, collided_sphere(BALL_RADIUS), acceleration);
    unsigned seed = 1;
    for (int row = 0, number = 1; row < 5; row++)
        for (int i = 0; i <= row; i++, number++) {
            double off[2];
            for (int k = 0; k < 2; k++) {
                seed = seed * 1664525u + 1013904223u;
                off[k] = RACK_GAP / 3 * ((double)(seed >> 8) / 16777216.0 - 0.5);
            }
            double x = RACK_X + row * pitch * 0.8660254037844386, y = (i - 0.5 * row) * pitch;
            lockstep_body(l, ball_at(number, x + off[0], y + off[1]), collided_sphere(BALL_RADIUS), acceleration);
        }
    add_cushion(l, "cushion_east", TABLE_X, 0);
    add_cushion(l, "cushion_west", -TABLE_X, 0);
    add_cushion(l, "cushion_north", 0, TABLE_Y);
    add_cushion(l, "cushion_south", 0, -TABLE_Y);
}

/* ---- motion ---- */

static double speed_of(const rigid *b)
{
    return sqrt(vector_dot(b->linear, b->linear));
}

/* Rolling takes off speed along the path until the ball rests. */
static void roll(rigid *b, double seconds, double deceleration)
{
    double speed = speed_of(b);
    if (speed == 0) return;
    double left = fmax(speed - deceleration * seconds, 0);
    if (left < 1e-12) left = 0; /* what rounding leaves at the end */
    b->position = vector_add(b->position, vector_scale(0.5 * (speed + left) / speed * seconds, b->linear));
    b->linear = vector_scale(left / speed, b->linear);
}

static void add_rests(lockstep *l, double deceleration)
{
    for (size_t i = 0; deceleration > 0 && i < l->moving; i++) {
        double speed = speed_of(&l->bodies[i]);
        if (speed > 0) impact_push(&l->heap, (impact){.lo_s = speed / deceleration, .at = {.a = (int)i, .b = -1}});
    }
}

/* ---- from event to event ---- */

typedef struct table {
    lockstep *l;
    scene_result *r;
    bool real;
    double span_s, deceleration;
    touch points[POINTS_MAX]; /* of the impacts that happen now */
    size_t count;
} table;

static void add_point(table *t, const impact *e)
{
    touch at = e->at;
    bool cushion = (size_t)at.b >= t->l->moving;
    at.restitution = !t->real ? 1 : cushion ? CUSHION_RESTITUTION : BALL_RESTITUTION;
    at.friction = 0;
    at.normal.z = 0; /* the cloth keeps the balls in its plane */
    double size = sqrt(vector_dot(at.normal, at.normal));
    at.normal = vector_scale(1 / size, at.normal);
    if (t->count == POINTS_MAX)
        t->l->lost = true;
    else
        t->points[t->count++] = at;
}

/* Takes what is next off the heap: a time, and what happens then. What follows from it at the same time is asked anew.
 */
static double next(table *t)
{
    double when = fmin(HORIZON_S, t->span_s - t->r->time_s);
    impact e;
    t->count = 0;
    while (impact_pop(&t->l->heap, &e) && e.lo_s <= when) {
        bool meets = e.at.b >= 0, apart = meets && e.closing_m_s <= 0;
        if (apart && t->real) when = fmin(when, BESIDE_S); /* paths bend: they might come back */
        if (apart) continue;
        if (when > e.lo_s) when = e.lo_s;
        bool proven = !t->real || e.lo_s <= NOW_S; /* with losses the bound must have come to the truth first */
        if (meets && proven) add_point(t, &e);
    }
    return when;
}

/* By the balls' own formula, apart from what the daemon tells. */
static double depth_of(const lockstep *l)
{
    double depth = 0;
    for (size_t i = 0; i < l->moving; i++) {
        vector p = l->bodies[i].position;
        depth = fmax(depth, fmax(fabs(p.x) - TABLE_X, fabs(p.y) - TABLE_Y) + BALL_RADIUS);
        for (size_t k = 0; k < i; k++) {
            vector d = vector_sub(l->bodies[k].position, p);
            depth = fmax(depth, 2 * BALL_RADIUS - sqrt(vector_dot(d, d)));
        }
    }
    return depth;
}

static bool step(table *t)
{
    if (!lockstep_ask(t->l, NULL)) return false;
    add_rests(t->l, t->deceleration);
    double seconds = next(t);
    for (size_t i = 0; i < t->l->moving; i++) roll(&t->l->bodies[i], seconds, t->deceleration);
    t->r->time_s += seconds;
    t->r->advances++;
    t->l->deepest_m = fmax(t->l->deepest_m, depth_of(t->l));
    if (t->count) scene_collide(t->r, t->l, t->points, t->count);
    scene_note_state(t->r, t->l);
    return !t->l->lost;
}

static bool all_rest(const lockstep *l)
{
    return dynamics_kinetic(l->bodies, l->moving) == 0;
}

void scene_billiards(lockstep *l, double span_s, bool real, scene_result *r)
{
    table t = {.l = l, .r = r, .real = real, .span_s = span_s, .deceleration = real ? ROLLING_M_S2 : 0};
    const lockstep_terms terms = {.horizon_s = HORIZON_S, .tolerance_m = real ? 1e-7 : TOLERANCE_M};
    lay_out(l, real);
    r->energy_bound = 1e-12;
    r->momentum_bound = 1e-12;
    r->depth_bound_m = terms.tolerance_m;
    r->elastic = !real;
    r->good = lockstep_begin(l, &terms);
    r->first_j = dynamics_kinetic(l->bodies, l->moving);
    while (r->good && example_running(l->options) && r->time_s < span_s && !all_rest(l)) r->good = step(&t);
    r->last_j = dynamics_kinetic(l->bodies, l->moving);
    r->at_rest = all_rest(l);
}
