/* toi_pairs: random motions. */
#include "toi_pairs.h"

const toi_manner toi_manners[TOI_MANNERS] = {{"straight", 0, true}, {"turning", 0.7, true}, {"half a turn", 3, true},
    {"spinning", 60, true}, {"passing", 0.3, false}};

static pose random_local(random_state *r, const shape *s)
{
    if (random_unit(r) < 0.5 || s->type == SHAPE_HALFSPACE) return POSE_IDENTITY;
    return (pose){vec_scale(random_direction(r), random_in(r, 0, 1)), random_rotation(r)};
}

static vec3 random_spin(random_state *r, double turn)
{
    return random_unit(r) < 0.25 ? VEC_ZERO : vec_scale(random_direction(r), random_in(r, 0, turn));
}

static void fly(random_state *r, const toi_manner *how, toi_pair *p)
{
    const shape *a = &p->shapes[0], *b = &p->shapes[1];
    double ra = isfinite(shape_reach(a)) ? shape_reach(a) : 1, rb = isfinite(shape_reach(b)) ? shape_reach(b) : 1;
    double clear = random_in(r, 0.6, 2) * (ra + rb), far = 2 * clear;
    vec3 from = vec_scale(random_direction(r), far), aim = vec_scale(random_direction(r), how->aimed ? 0 : clear);
    vec3 common = vec_scale(random_direction(r), random_in(r, 0, 5));
    p->a = (toi_mover){
        a, random_local(r, a), {{random_direction(r), random_rotation(r)}, common, random_spin(r, how->turn)}};
    p->b = (toi_mover){b, random_local(r, b),
        {{vec_add(p->a.motion.start.p, from), random_rotation(r)}, VEC_ZERO, random_spin(r, how->turn)}};
    vec3 through = vec_scale(vec_sub(aim, from), random_in(r, 0.5, 2.5));
    p->b.motion.linear = vec_add(common, through);
    p->size = ra + rb + far;
    p->request = (toi_request){.span = 1, .threshold = 0, .tolerance = 1e-7 * p->size};
}

bool toi_pair_make(uint64_t seed, const toi_manner *how, shape_type a, shape_type b, toi_pair *out)
{
    if (a == SHAPE_HALFSPACE && b == SHAPE_HALFSPACE) return false;
    random_state r = {seed};
    shape first = random_shape(&r, a), second = random_shape(&r, b);
    bool ordered = narrow_ordered(&first, 0, &second, 1);
    out->shapes[0] = ordered ? first : second;
    out->shapes[1] = ordered ? second : first;
    fly(&r, how, out);
    return true;
}

void toi_pair_any(uint64_t seed, const toi_manner *how, toi_pair *out)
{
    random_state r = {seed};
    shape_type a, b;
    do {
        a = (shape_type)(random_bits(&r) % SHAPE_CONVEX_COUNT);
        b = (shape_type)(random_bits(&r) % SHAPE_CONVEX_COUNT);
    } while (!toi_pair_make(random_bits(&r), how, a, b, out));
}

toi_result toi_pair_find(const toi_pair *p)
{
    toi_result t;
    toi_find(&p->a, &p->b, &p->request, VEC_ZERO, case_scratch(), &t);
    return t;
}
