/* A long life: after 10,000 ticks in which everybody moves the trees are nearly as good as fresh ones, and what one
 * moved body costs does not depend on the size of the world. In counted work, not in time. */
#include "broad/state.h"
#include "broad_world.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

typedef struct body {
    vec3 at, step;
    double half;
} body;

static void bounce(double *at, double *step, double side)
{
    *at += *step;
    if (*at < 0 || *at > side) *step = -*step;
}

static void advance(body *b, double side)
{
    bounce(&b->at.x, &b->step.x, side);
    bounce(&b->at.y, &b->step.y, side);
    bounce(&b->at.z, &b->step.z, side);
}

static void put(broad *b, uint32_t id, const body *x)
{
    aabb box = box_at(x->at, vec(x->half, x->half, x->half));
    broad_put(b, &(broad_move){.proxy = id, .box = box, .margin = 0.1 * x->half, .motion = x->step});
}

static body random_body(prng *r, double side)
{
    body b = {.half = prng_between(r, 0.125, 0.5)};
    b.at = vec(prng_between(r, 0, side), prng_between(r, 0, side), prng_between(r, 0, side));
    b.step = random_vec(r, 0.02 * b.half);
    return b;
}

static double sum_of_areas(const tree *t)
{
    double sum = 0;
    ARRAY(uint32_t) ahead = {0};
    array_push(&ahead, (uint32_t)TREE_ROOT);
    while (ahead.count > 0) {
        const tree_node *n = &t->nodes[ahead.at[--ahead.count]];
        if (tree_is_leaf(n)) continue;
        sum += (double)fbox_area(&n->box);
        array_push(&ahead, n->down);
        array_push(&ahead, n->down + 1);
    }
    array_free(&ahead);
    return sum;
}

/* Of a tree built at once from the same boxes. */
static double fresh_area(const broad *b)
{
    tree t;
    tree_init(&t);
    for (uint32_t i = 0; i < b->proxies.count; i++) tree_announce(&t, i, &b->proxies.at[i].fat);
    tree_settle(&t);
    double area = sum_of_areas(&t);
    tree_free(&t);
    return area;
}

enum { BODIES = 300, TICKS = 10000 };

static void after_ten_thousand_ticks_the_tree_is_nearly_as_good_as_fresh(void **state)
{
    (void)state;
    static body bodies[BODIES];
    const double side = 1.3 * cbrt(BODIES);
    prng r = {1};
    broad *b = broad_create(BROAD_TREE, accept_all, NULL);
    for (uint32_t i = 0; i < BODIES; i++) bodies[i] = random_body(&r, side);
    for (int tick = 0; tick < TICKS; tick++) {
        broad_changes changes;
        for (uint32_t i = 0; i < BODIES; i++) {
            advance(&bodies[i], side);
            put(b, i, &bodies[i]);
        }
        broad_update(b, &changes);
        if (tick < TICKS - 100) continue;
        double worse = sum_of_areas(&b->moving) / fresh_area(b);
        if (worse > 1.3) fail_msg("the areas are %g times those of a fresh tree", worse);
    }
    assert_null(broad_validate(b));
    broad_destroy(b);
}

/* ---- work ---- */

static size_t nodes_changed(const tree *t, const tree_node *before)
{
    size_t changed = 0;
    for (uint32_t i = 0; i < t->end; i++) changed += memcmp(&t->nodes[i], &before[i], sizeof before[i]) != 0;
    return changed;
}

static size_t most_nodes_changed(uint32_t count)
{
    const double side = 1.3 * cbrt(count);
    prng r = {count};
    broad *b = broad_create(BROAD_TREE, accept_all, NULL);
    body one = {0};
    for (uint32_t i = 0; i < count; i++) {
        one = random_body(&r, side);
        put(b, i, &one);
    }
    broad_changes changes;
    broad_update(b, &changes);
    size_t most = 0;
    tree_node *before = base_alloc(b->moving.capacity, sizeof *before);
    for (int tick = 0; tick < 400; tick++) {
        memcpy(before, b->moving.nodes, b->moving.end * sizeof *before);
        advance(&one, side);
        put(b, count - 1, &one);
        assert_true(b->pending.count <= 1);
        broad_update(b, &changes);
        size_t changed = nodes_changed(&b->moving, before);
        if (changed > most) most = changed;
    }
    free(before);
    broad_destroy(b);
    return most;
}

static void one_moved_body_changes_few_nodes_in_any_world(void **state)
{
    (void)state;
    size_t small = most_nodes_changed(100), large = most_nodes_changed(30000);
    assert_true(small > 0);
    assert_in_range(large, 1, 120); /* each level of two walks up, and what rotates there */
}

/* ---- all at once ---- */

/* Nodes that a query around each leaf goes through, a leaf. */
static double nodes_walked(const tree *t)
{
    size_t walked = 0;
    ARRAY(uint32_t) ahead = {0};
    for (uint32_t id = 0; id < t->leaf_of.count; id++) {
        array_push(&ahead, (uint32_t)TREE_ROOT);
        while (ahead.count > 0) {
            const tree_node *n = &t->nodes[ahead.at[--ahead.count]];
            walked += fbox_overlap(&n->box, tree_box(t, id));
            if (tree_is_leaf(n) || !fbox_overlap(&n->box, tree_box(t, id))) continue;
            array_push(&ahead, n->down);
            array_push(&ahead, n->down + 1);
        }
    }
    array_free(&ahead);
    return (double)walked / (double)t->leaf_count;
}

/* A step of lock-step takes a row of bodies aside, a little further each time, and then all the way back: their boxes
 * hold the ways. Where each leaf was fitted in by itself, the tall boxes among those that were still flat left a tree
 * in which each query went through many times as many nodes: of 40,000 bodies that was a tick of 300 ms. */
static void a_row_that_moves_as_one_leaves_a_tree_that_is_as_good_as_fresh(void **state)
{
    (void)state;
    enum { ROW = 5000, STEPS = 40, BACK = 9 };
    broad *b = broad_create(BROAD_TREE, accept_all, NULL);
    for (int step = 1; step <= STEPS; step++) {
        broad_changes changes;
        double y = 0.1 * (step % BACK), before = step > 1 ? 0.1 * ((step - 1) % BACK) : y;
        for (uint32_t i = 0; i < ROW; i++) {
            vec3 middle = vec(0.1 * i + 0.025, (y + before) / 2, 0);
            vec3 half = vec(0.05, 0.02 + fabs(y - before) / 2, 0.02);
            broad_put(b, &(broad_move){.proxy = i, .box = box_at(middle, half), .margin = 0.005});
        }
        broad_update(b, &changes);
        assert_null(broad_validate(b));
        double walked = nodes_walked(&b->moving);
        tree fresh;
        tree_init(&fresh);
        for (uint32_t i = 0; i < ROW; i++) tree_announce(&fresh, i, &b->proxies.at[i].fat);
        tree_settle(&fresh);
        double least = nodes_walked(&fresh);
        tree_free(&fresh);
        if (walked > 1.5 * least) fail_msg("step %d: %g nodes a query, where a fresh tree has %g", step, walked, least);
    }
    broad_destroy(b);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_row_that_moves_as_one_leaves_a_tree_that_is_as_good_as_fresh),
        cmocka_unit_test(after_ten_thousand_ticks_the_tree_is_nearly_as_good_as_fresh),
        cmocka_unit_test(one_moved_body_changes_few_nodes_in_any_world),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
