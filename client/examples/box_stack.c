/* box_stack: five boxes fall onto a floor, bounce, and come to rest on each other. Two kinds of contact, apart: impacts
 * (the daemon predicts them; Poisson's restitution), and resting on one another (manifolds of all that is nearer than
 * a margin; impulses that keep a gap, without restitution).
 *
 * Gravity bends paths, and what is predicted is predicted of straight ones. So the motion is cut into short steps, each
 * a straight chord: for a body in free fall from where it is to where the parabola ends, which is exact there, and on
 * the way below the parabola by at most g h^2 / 8 = 21 um; for bodies that touch, with the speed of the step's end.
 * Each chord is published and goes no farther than its earliest impact's lower bound: so no body ever gets into
 * another. (Stated accelerations, as in billiards, would tell of every resting pair that it may meet at once.) One
 * thread. */
#include "impact_scene.h"

#include <math.h>
#include <string.h>

enum { BOXES = 5, STILL_STEPS = 60 };

static const double SIDE_M = 0.2, MASS_KG = 1, GRAVITY_M_S2 = 9.81;
static const double STEP_S = 1.0 / 240;
static const double RESTITUTION = 0.3, FRICTION = 0.5;
static const double MARGIN_M = 1e-3;  /* manifolds are reported from here on */
static const double GAP_M = 1e-4;     /* bodies at rest keep this distance; nearer, they touch */
static const double SLOW_M_S = 0.1;   /* slower impacts do not bounce: two steps of gravity */
static const double MEND = 0.2;       /* of what a gap is too small by, this share is made up in a step */
static const double STILL_M_S = 1e-3; /* and rad/s: at rest, if for STILL_STEPS steps */
static const double DEPTH_BOUND_M = 1e-6;

/* ---- the scene ---- */

static void lay_out(lockstep *l)
{
    static const char *const NAMES[BOXES] = {"box_1", "box_2", "box_3", "box_4", "box_5"};
    static const double OFFSET[BOXES][2] = {{0, 0}, {0.012, -0.004}, {-0.008, 0.01}, {0.005, 0.006}, {-0.01, -0.009}};
    const double inertia = MASS_KG * SIDE_M * SIDE_M / 6;
    for (int i = 0; i < BOXES; i++) {
        rigid box = {.name = NAMES[i],
            .inverse_mass = 1 / MASS_KG,
            .inverse_inertia = 1 / inertia,
            .position = {OFFSET[i][0], OFFSET[i][1], SIDE_M / 2 + 0.1 + i * (SIDE_M + 0.05)},
            .orientation = {1, 0, 0, 0}};
        lockstep_body(l, box, collided_box(SIDE_M, SIDE_M, SIDE_M), 0);
    }
    rigid floor = {.name = "floor", .position = {0, 0, -0.1}, .orientation = {1, 0, 0, 0}};
    lockstep_body(l, floor, collided_box(4, 4, 0.2), 0);
}

/* J, above lying on the floor as one pile. */
static double energy_of(const lockstep *l)
{
    double sum = dynamics_kinetic(l->bodies, l->moving);
    for (size_t i = 0; i < l->moving; i++) sum += MASS_KG * GRAVITY_M_S2 * l->bodies[i].position.z;
    return sum;
}

/* ---- one step ---- */

typedef struct pile {
    lockstep *l;
    scene_result *r;
    touch points[LOCKSTEP_TOUCHES]; /* as they were told; the answer is overwritten by the next */
    size_t count;
    vector chord[LOCKSTEP_BODIES]; /* m/s, of this step */
    rigid before[LOCKSTEP_BODIES]; /* at its beginning */
} pile;

static void take_points(pile *p)
{
    p->count = p->l->touch_count;
    for (size_t i = 0; i < p->count; i++) {
        p->points[i] = p->l->touches[i];
        p->points[i].friction = FRICTION;
    }
}

static bool is_fast(const pile *p, const touch *t)
{
    return dynamics_parting(p->l->bodies, t) < -SLOW_M_S;
}

/* Of two that touch at one point all points count: another may be about to. */
static bool touches_somewhere(const pile *p, const touch *t)
{
    for (size_t i = 0; i < p->count; i++)
        if (p->points[i].a == t->a && p->points[i].b == t->b && p->points[i].gap <= GAP_M) return true;
    return false;
}

/* All that touch take part in an impact: it goes through the pile. */
static void impacts(pile *p)
{
    touch touching[LOCKSTEP_TOUCHES];
    size_t count = 0;
    bool hard = false;
    for (size_t i = 0; i < p->count; i++) {
        if (!touches_somewhere(p, &p->points[i])) continue;
        bool fast = is_fast(p, &p->points[i]);
        touching[count] = p->points[i];
        touching[count++].restitution = fast ? RESTITUTION : 0;
        hard |= fast;
    }
    if (hard) scene_collide(p->r, p->l, touching, count);
}

/* What comes fast is not there yet: it is held by nothing, and its impact is predicted. */
static void drop_fast(pile *p)
{
    touch kept[LOCKSTEP_TOUCHES];
    size_t count = 0;
    for (size_t i = 0; i < p->count; i++)
        if (!is_fast(p, &p->points[i]) || touches_somewhere(p, &p->points[i])) kept[count++] = p->points[i];
    memcpy(p->points, kept, count * sizeof *kept);
    p->count = count;
}

/* A gap may close until GAP_M is left, and where it is less it opens slowly. */
static double target_of(double gap)
{
    double target = (GAP_M - gap) / STEP_S;
    return target > 0 ? MEND * target : target;
}

/* The chords of the step: gravity for all of it, and what holds against it where bodies touch. */
static void plan(pile *p)
{
    bool touched[LOCKSTEP_BODIES] = {false};
    for (size_t i = 0; i < p->count; i++) touched[p->points[i].a] = touched[p->points[i].b] = true;
    for (size_t i = 0; i < p->l->moving; i++) {
        rigid *b = &p->l->bodies[i];
        p->before[i] = *b;
        b->linear.z -= GRAVITY_M_S2 * STEP_S;
    }
    for (size_t i = 0; i < p->count; i++) {
        touch *t = &p->points[i];
        t->target = target_of(t->gap);
        t->least = t->normal_impulse = 0;
        t->friction_impulse = (vector){0};
    }
    dynamics_relax(p->l->bodies, p->points, p->count);
    for (size_t i = 0; i < p->l->moving; i++) {
        p->chord[i] = p->l->bodies[i].linear;
        if (!touched[i]) p->chord[i].z += 0.5 * GRAVITY_M_S2 * STEP_S;
    }
}

/* m/s: no point of it is faster. */
static double fastest(const pile *p, int body)
{
    if ((size_t)body >= p->l->moving) return 0;
    vector v = p->chord[body], w = p->l->bodies[body].angular;
    return sqrt(vector_dot(v, v)) + sqrt(0.75 * vector_dot(w, w)) * SIDE_M;
}

/* s: how far the chords are free. Two that part where they are nearest are reported as near from the beginning: their
 * points within the margin are held, and the step is short enough for those beyond it. */
static double free_time(pile *p)
{
    double free_s = STEP_S;
    impact e;
    while (impact_pop(&p->l->heap, &e) && e.lo_s < free_s) {
        if (e.closing_m_s > 0) return e.lo_s;
        free_s = fmin(free_s, e.lo_s + MARGIN_M / (fastest(p, e.at.a) + fastest(p, e.at.b)));
    }
    return free_s;
}

static vector between(vector from, vector to, double share)
{
    return vector_add(from, vector_scale(share, vector_sub(to, from)));
}

/* Of a step that an impact cuts short the forces have acted for a share only. */
static void advance(pile *p, double seconds)
{
    double share = seconds / STEP_S;
    for (size_t i = 0; i < p->l->moving; i++) {
        rigid *b = &p->l->bodies[i];
        dynamics_advance(b, p->chord[i], seconds);
        b->linear = between(p->before[i].linear, b->linear, share);
        b->angular = between(p->before[i].angular, b->angular, share);
    }
    p->r->time_s += seconds;
    p->r->advances++;
    scene_note_state(p->r, p->l);
}

/* First where they are: the answer has the manifolds. Where nothing touches, it predicts this step as well; else what
 * they now do is published in its turn. */
static bool step(pile *p)
{
    vector falling[LOCKSTEP_BODIES];
    for (size_t i = 0; i < p->l->moving; i++) {
        falling[i] = p->l->bodies[i].linear;
        falling[i].z -= 0.5 * GRAVITY_M_S2 * STEP_S;
    }
    if (!lockstep_ask(p->l, falling)) return false;
    double energy = energy_of(p->l);
    take_points(p);
    bool any = p->count > 0; /* at rest, or struck: it moves otherwise than was published */
    impacts(p);
    drop_fast(p);
    plan(p);
    if (any && !lockstep_ask(p->l, p->chord)) return false;
    advance(p, free_time(p));
    p->r->energy_gain = fmax(p->r->energy_gain, (energy_of(p->l) - energy) / p->r->first_j);
    return true;
}

static bool is_still(const lockstep *l)
{
    for (size_t i = 0; i < l->moving; i++) {
        const rigid *b = &l->bodies[i];
        if (vector_dot(b->linear, b->linear) > STILL_M_S * STILL_M_S) return false;
        if (vector_dot(b->angular, b->angular) > STILL_M_S * STILL_M_S) return false;
    }
    return true;
}

void scene_stack(lockstep *l, double span_s, scene_result *r)
{
    const lockstep_terms terms = {.horizon_s = STEP_S, .tolerance_m = 1e-6, .margin_m = MARGIN_M};
    static pile p;
    p = (pile){.l = l, .r = r};
    lay_out(l);
    r->energy_bound = 1e-6; /* a gap that is made up lifts what lies on it */
    r->momentum_bound = 1e-9;
    r->depth_bound_m = DEPTH_BOUND_M;
    r->good = lockstep_begin(l, &terms);
    r->first_j = energy_of(l);
    int still = 0;
    while (r->good && example_running(l->options) && r->time_s < span_s && still < STILL_STEPS) {
        r->good = step(&p);
        still = is_still(l) ? still + 1 : 0;
    }
    r->last_j = energy_of(l);
    r->at_rest = still == STILL_STEPS;
}
