/* Building compounds: what is taken, what is refused, the boxes over the children, and bounds of the whole. */
#include "unions.h"

#include "geom/bounds.h"
#include "geom/support.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stdlib.h>

#include <cmocka.h>

static const shape UNIT_BOX = {.type = SHAPE_BOX, .half = {1, 1, 1}};

static compound_status build_one(shape s, pose at)
{
    compound *c;
    compound_status status = compound_build(&s, &at, 1, &c);
    assert_true((status == COMPOUND_OK) == (c != NULL));
    compound_destroy(c);
    return status;
}

static void bad_children_are_refused(void **state)
{
    (void)state;
    compound *c, *nested;
    assert_int_equal(compound_build(&UNIT_BOX, &POSE_IDENTITY, 0, &c), COMPOUND_EMPTY);
    assert_null(c);
    assert_int_equal(build_one(UNIT_BOX, POSE_IDENTITY), COMPOUND_OK);
    assert_int_equal(build_one((shape){.type = SHAPE_HALFSPACE}, POSE_IDENTITY), COMPOUND_BAD_CHILD);
    assert_int_equal(build_one((shape){.type = SHAPE_MESH}, POSE_IDENTITY), COMPOUND_BAD_CHILD);
    assert_int_equal(build_one((shape){.type = (shape_type)9}, POSE_IDENTITY), COMPOUND_BAD_CHILD);
    assert_int_equal(compound_build(&UNIT_BOX, &POSE_IDENTITY, 1, &nested), COMPOUND_OK);
    assert_int_equal(build_one((shape){.type = SHAPE_COMPOUND, .compound = nested}, POSE_IDENTITY), COMPOUND_BAD_CHILD);
    compound_destroy(nested);
    assert_int_equal(build_one((shape){.type = SHAPE_BOX, .half = {-1, 1, 1}}, POSE_IDENTITY), COMPOUND_BAD_SIZE);
    assert_int_equal(build_one((shape){.type = SHAPE_HULL}, POSE_IDENTITY), COMPOUND_BAD_SIZE);
    assert_int_equal(build_one(UNIT_BOX, (pose){{NAN, 0, 0}, {1, 0, 0, 0}}), COMPOUND_BAD_SIZE);
    assert_int_equal(build_one(UNIT_BOX, (pose){{1e151, 0, 0}, {1, 0, 0, 0}}), COMPOUND_BAD_SIZE);
    assert_int_equal(build_one(UNIT_BOX, (pose){VEC_ZERO, {0, 0, 0, 0}}), COMPOUND_BAD_SIZE);
    for (int i = COMPOUND_OK; i <= COMPOUND_BAD_SIZE; i++)
        assert_true(compound_status_text((compound_status)i)[0] != 0);
}

static void as_many_as_the_limit_are_taken_and_no_more(void **state)
{
    (void)state;
    dice d = {1};
    shape *shapes = calloc(COMPOUND_CHILDREN_MAX + 1, sizeof *shapes);
    pose *locals = calloc(COMPOUND_CHILDREN_MAX + 1, sizeof *locals);
    assert_non_null(shapes);
    assert_non_null(locals);
    for (int i = 0; i <= COMPOUND_CHILDREN_MAX; i++) {
        shapes[i] = random_part(&d, 0.1, 1);
        locals[i] = (pose){dice_vec(&d, -50, 50), dice_quat(&d)};
    }
    for (size_t n = 1; n <= COMPOUND_CHILDREN_MAX; n = n * 2 + n % 3) {
        compound *c;
        assert_int_equal(compound_build(shapes, locals, n, &c), COMPOUND_OK);
        assert_null(compound_validate(c));
        assert_int_equal(c->node_count, 2 * n - 1);
        compound_destroy(c);
    }
    compound *most, *same, *other, *over;
    assert_int_equal(compound_build(shapes, locals, COMPOUND_CHILDREN_MAX, &most), COMPOUND_OK);
    assert_int_equal(compound_build(shapes, locals, COMPOUND_CHILDREN_MAX, &same), COMPOUND_OK);
    assert_null(compound_validate(most));
    assert_true(compound_equal(most, same));
    assert_int_equal(compound_build(shapes, locals, COMPOUND_CHILDREN_MAX + 1, &over), COMPOUND_TOO_MANY);
    locals[COMPOUND_CHILDREN_MAX - 1].p.y += 1;
    assert_int_equal(compound_build(shapes, locals, COMPOUND_CHILDREN_MAX, &other), COMPOUND_OK);
    assert_false(compound_equal(most, other));
    compound_destroy(same);
    shapes[0].deviation = 0.5;
    assert_int_equal(compound_build(shapes, locals, COMPOUND_CHILDREN_MAX, &same), COMPOUND_OK);
    assert_false(compound_equal(same, other));
    compound_destroy(most);
    compound_destroy(same);
    compound_destroy(other);
    free(shapes);
    free(locals);
}

/* The exact height of the rounded children, in 113 bits. */
static quad height_of(const union_body *u, qvec direction)
{
    quad top = -INFINITY;
    for (size_t i = 0; i < u->count; i++) {
        const oracle_body *b = &u->parts[i].exact;
        top = q_max(top, q_dot(direction, oracle_support(b, direction)) + b->radius * q_norm(direction));
    }
    return top;
}

static void boxes_heights_and_reach_hold_all_children_and_not_much_more(void **state)
{
    (void)state;
    dice d = {2};
    for (int k = 0; k < 300; k++) {
        union_body u;
        union_random(&u, &d, 1 + (size_t)k % 12, k % 3 ? 0 : 0.1);
        pose at = {dice_vec(&d, -3, 3), dice_quat(&d)};
        union_place(&u, at, qv(0, 0, 0));
        aabb box = shape_bounds(&u.shape, at);
        const double lo[3] = {box.lo.x, box.lo.y, box.lo.z}, hi[3] = {box.hi.x, box.hi.y, box.hi.z};
        for (int i = 0; i < 3; i++) {
            qvec axis = {i == 0, i == 1, i == 2};
            quad top = height_of(&u, axis), foot = -height_of(&u, q_neg(axis));
            assert_true((quad)lo[i] <= foot && top <= (quad)hi[i]);
            assert_true(foot - (quad)lo[i] < 1e-12 && (quad)hi[i] - top < 1e-12);
        }
        union_place(&u, POSE_IDENTITY, qv(0, 0, 0));
        vec3 n = dice_vec(&d, -1, 1);
        qvec exact = qv(n.x, n.y, n.z);
        quad height = height_of(&u, exact), rounding = (quad)u.shape.radius * q_norm(exact);
        double up = support_height_up(&u.shape, n, NULL);
        assert_true((quad)up >= height - rounding && (quad)up < height - rounding + 1e-12);
        vec3 point = support_core(&u.shape, n, NULL);
        assert_true(fabs(vec_dot(n, point) - (double)(height - rounding)) < 1e-12);
        assert_true((quad)shape_reach(&u.shape) * q_norm(exact) >= height);
        union_free(&u);
    }
}

static void a_compound_has_a_name_and_needs_its_children(void **state)
{
    (void)state;
    shape s = {.type = SHAPE_COMPOUND};
    assert_string_equal(shape_type_name(SHAPE_COMPOUND), "compound");
    assert_string_equal(shape_type_name((shape_type)9), "unknown");
    assert_string_equal(shape_check(&s), "children are missing");
    s.type = (shape_type)9;
    assert_string_equal(shape_check(&s), "type of shape is unknown");
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(bad_children_are_refused),
        cmocka_unit_test(as_many_as_the_limit_are_taken_and_no_more),
        cmocka_unit_test(boxes_heights_and_reach_hold_all_children_and_not_much_more),
        cmocka_unit_test(a_compound_has_a_name_and_needs_its_children),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
