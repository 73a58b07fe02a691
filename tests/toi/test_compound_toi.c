/* The time of impact of compounds: that of the earliest pair of children, asked one by one. */
#include "toi/toi.h"
#include "unions.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>

#include <cmocka.h>

enum { ROUNDS = 120 };

static toi_mover child_of(const union_body *u, size_t i, const motion *m, shape *scratch)
{
    *scratch = u->compound ? u->compound->children[i].shape : u->shape;
    if (u->compound) scratch->radius += u->shape.radius;
    return (toi_mover){scratch, u->compound ? u->compound->children[i].local : POSE_IDENTITY, *m};
}

/* The bracket of the first contact of all pairs of children. */
static void earliest(const union_body *a, const motion *ma, const union_body *b, const motion *mb,
    const toi_request *request, double *lo, double *hi)
{
    *lo = *hi = INFINITY;
    for (size_t i = 0; i < a->count; i++)
        for (size_t k = 0; k < b->count; k++) {
            shape sa, sb;
            toi_mover x = child_of(a, i, ma, &sa), y = child_of(b, k, mb, &sb);
            bool ordered = sa.type <= sb.type;
            toi_result t;
            toi_find(ordered ? &x : &y, ordered ? &y : &x, request, VEC_ZERO, union_scratch(), &t);
            *lo = fmin(*lo, t.lo);
            *hi = fmin(*hi, t.hi);
        }
}

static void hold(const union_body *a, const union_body *b, dice *d, double turn, int *hits)
{
    vec3 from = vec_scale(vec_unit(dice_vec(d, -1, 1)), 6), aim = dice_vec(d, -1, 1);
    motion ma = {
        {from, dice_quat(d)}, vec_scale(vec_sub(aim, from), dice_between(d, 0.6, 1.6)), dice_vec(d, -turn, turn)};
    motion mb = {{VEC_ZERO, dice_quat(d)}, VEC_ZERO, dice_vec(d, -turn, turn)};
    toi_request request = {.span = 1, .tolerance = 1e-6};
    toi_mover x = {&a->shape, POSE_IDENTITY, ma}, y = {&b->shape, POSE_IDENTITY, mb};
    toi_result t;
    double lo, hi;
    toi_find(&x, &y, &request, VEC_ZERO, union_scratch(), &t);
    earliest(a, &ma, b, &mb, &request, &lo, &hi);
    assert_int_not_equal(t.status, TOI_UNDECIDED);
    if (t.lo > hi || lo > t.hi || (t.status == TOI_FREE) != (lo == INFINITY))
        fail_msg("turning by %g: %s [%.17g, %.17g], the children one by one [%.17g, %.17g]", turn,
            toi_status_name(t.status), t.lo, t.hi, lo, hi);
    *hits += t.status == TOI_HIT;
}

static void compounds_meet_when_their_first_children_do(void **state)
{
    (void)state;
    int hits = 0;
    for (int i = 0; i < ROUNDS; i++) {
        dice d = {(uint64_t)i * 104729 + 5};
        union_body a, b;
        union_random(&b, &d, 6, i % 3 ? 0 : 0.05);
        if (i % 2)
            union_random(&a, &d, 4, 0);
        else
            union_single(&a, random_part(&d, 0.1, 0.6));
        hold(&a, &b, &d, i % 4 < 2 ? 0 : 2, &hits);
        union_free(&a);
        union_free(&b);
    }
    assert_true(hits > ROUNDS / 4);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(compounds_meet_when_their_first_children_do)};
    return cmocka_run_group_tests(tests, union_make_scratch, union_free_scratch);
}
