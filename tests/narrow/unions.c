/* unions: both sides of the same compound. */
#include "unions.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

static narrow_scratch *scratch;

int union_make_scratch(void **state)
{
    (void)state;
    scratch = aligned_alloc(64, narrow_scratch_size());
    return scratch ? 0 : 1;
}

int union_free_scratch(void **state)
{
    (void)state;
    free(scratch);
    return 0;
}

narrow_scratch *union_scratch(void)
{
    return scratch;
}

static void take_parts(union_body *u, const shape *parts, const pose *locals, size_t count, double rounding)
{
    memset(u, 0, sizeof *u);
    u->count = count;
    for (size_t i = 0; i < count; i++) {
        shape s = parts[i];
        s.radius += rounding;
        subject_from_shape(&u->parts[i], s);
        u->parts[i].exact.radius = (quad)parts[i].radius + (quad)rounding;
        u->locals[i] = locals[i];
    }
}

void union_make(union_body *u, const shape *parts, const pose *locals, size_t count, double rounding)
{
    take_parts(u, parts, locals, count, rounding);
    assert_int_equal(compound_build(parts, locals, count, &u->compound), COMPOUND_OK);
    u->shape = (shape){.type = SHAPE_COMPOUND, .radius = rounding, .compound = u->compound};
}

void union_single(union_body *u, shape s)
{
    take_parts(u, &s, &POSE_IDENTITY, 1, 0);
    u->shape = s;
}

shape random_part(dice *d, double least, double most)
{
    static const shape_type TYPES[] = {
        SHAPE_SPHERE, SHAPE_CAPSULE, SHAPE_BOX, SHAPE_CYLINDER, SHAPE_CONE, SHAPE_ELLIPSOID};
    shape s = {.type = TYPES[(int)dice_between(d, 0, 5.999)]};
    vec3 half = dice_vec(d, least, most);
    if (s.type != SHAPE_SPHERE) s.half = half;
    if (s.type == SHAPE_CYLINDER || s.type == SHAPE_CONE) s.half.y = s.half.x;
    if (s.type == SHAPE_CAPSULE) s.half.x = s.half.y = 0;
    if (s.type == SHAPE_SPHERE || s.type == SHAPE_CAPSULE || dice_between(d, 0, 1) < 0.3) s.radius = 0.5 * half.y;
    return s;
}

void union_random(union_body *u, dice *d, size_t count, double rounding)
{
    shape parts[UNION_PARTS_MAX];
    pose locals[UNION_PARTS_MAX];
    for (size_t i = 0; i < count; i++) {
        parts[i] = random_part(d, 0.05, 0.4);
        locals[i].p = dice_vec(d, -0.8, 0.8);
        locals[i].q = dice_quat(d);
    }
    union_make(u, parts, locals, count, rounding);
}

void union_boxes(union_body *u, dice *d, size_t count)
{
    shape parts[UNION_PARTS_MAX];
    pose locals[UNION_PARTS_MAX];
    for (size_t i = 0; i < count; i++) {
        parts[i] = (shape){.type = SHAPE_BOX, .half = dice_vec(d, 0.1, 0.5)};
        locals[i].p = dice_vec(d, -0.7, 0.7);
        locals[i].q = dice_quat(d);
    }
    union_make(u, parts, locals, count, 0);
}

void union_free(union_body *u)
{
    for (size_t i = 0; i < u->count; i++) subject_free(&u->parts[i]);
    compound_destroy(u->compound);
}

static qmat product(const qmat *a, const qmat *b)
{
    return (qmat){q_tmul(*b, a->x), q_tmul(*b, a->y), q_tmul(*b, a->z)};
}

void union_place(union_body *u, pose at, qvec shift)
{
    qmat r = oracle_rotation(at.q.w, at.q.x, at.q.y, at.q.z);
    qvec p = q_add(qv(at.p.x, at.p.y, at.p.z), shift);
    for (size_t i = 0; i < u->count; i++) {
        pose l = u->locals[i];
        qmat local = oracle_rotation(l.q.w, l.q.x, l.q.y, l.q.z);
        u->parts[i].exact.rotation = product(&r, &local);
        u->parts[i].exact.position = q_add(p, q_mul(r, qv(l.p.x, l.p.y, l.p.z)));
    }
}

oracle_truth union_nearest(const union_body *a, const union_body *b)
{
    oracle_truth best = {.lo = INFINITY, .hi = INFINITY};
    for (size_t i = 0; i < a->count; i++)
        for (size_t k = 0; k < b->count; k++) {
            oracle_truth t = oracle_distance(&a->parts[i].exact, &b->parts[k].exact);
            if (t.lo < best.lo) best.lo = t.lo, best.axis = t.axis;
            best.hi = q_min(best.hi, t.hi);
        }
    return best;
}

quad union_apart_by(const union_body *a, const union_body *b)
{
    quad least = INFINITY;
    for (size_t i = 0; i < a->count; i++)
        for (size_t k = 0; k < b->count; k++) {
            const oracle_body *x = &a->parts[i].exact, *y = &b->parts[k].exact;
            least = q_min(least, oracle_separation(x, y, oracle_distance(x, y).axis));
        }
    return least;
}

narrow_result union_ask(const shape *a, const shape *b, pose b_in_a, double tolerance)
{
    const narrow_request request = {.facts = NARROW_DISTANCE, .tolerance = tolerance, .range = INFINITY};
    narrow_result r;
    memset(&r, 0xa5, sizeof r);
    narrow_query(a, b, &b_in_a, &request, NULL, scratch, &r);
    return r;
}
