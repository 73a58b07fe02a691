/* The tree alone: its invariants under random change, its queries against brute force, its height on hard input. */
#include "broad/tree.h"
#include "broad_world.h"

#include <stdlib.h>
#include <string.h>

enum { PROXIES = 200 };

typedef struct model {
    tree tree;
    bool present[PROXIES];
    fbox box[PROXIES];
    unsigned char visits[PROXIES];
} model;

static bool count_visit(void *context, uint32_t proxy)
{
    model *m = context;
    m->visits[proxy]++;
    return true;
}

static fbox random_fbox(prng *r)
{
    vec3 half = vec(prng_between(r, 0, 1), prng_between(r, 0, 1), prng_between(r, 0, 1));
    return fbox_outward(box_at(random_vec(r, 5), half));
}

static void check_query(model *m, const fbox *query)
{
    memset(m->visits, 0, sizeof m->visits);
    assert_true(tree_query_box(&m->tree, query, count_visit, m));
    for (uint32_t i = 0; i < PROXIES; i++)
        assert_int_equal(m->visits[i], m->present[i] && fbox_overlap(query, &m->box[i]));
}

static void random_changes_keep_the_invariants_and_the_answers(void **state)
{
    (void)state;
    static model m;
    tree_init(&m.tree);
    prng r = {1};
    for (int i = 0; i < 20000; i++) {
        uint32_t proxy = prng_below(&r, PROXIES);
        if (m.present[proxy]) {
            tree_remove(&m.tree, proxy);
        } else {
            m.box[proxy] = random_fbox(&r);
            tree_insert(&m.tree, proxy, &m.box[proxy]);
        }
        m.present[proxy] = !m.present[proxy];
        if (i % 10) continue;
        const char *broken = tree_validate(&m.tree);
        if (broken) fail_msg("operation %d: %s", i, broken);
        fbox query = random_fbox(&r);
        check_query(&m, &query);
    }
    for (uint32_t i = 0; i < PROXIES; i++)
        if (m.present[i]) tree_remove(&m.tree, i);
    assert_int_equal(m.tree.leaf_count, 0);
    assert_null(tree_validate(&m.tree));
    tree_free(&m.tree);
}

/* Walks up from each leaf. */
static uint32_t height_of(const tree *t)
{
    uint32_t height = 0;
    for (size_t p = 0; p < t->leaf_of.count; p++) {
        uint32_t depth = 0;
        for (uint32_t i = t->leaf_of.at[p]; i != TREE_ROOT; i = t->nodes[i].parent) depth++;
        if (depth > height) height = depth;
    }
    return height;
}

enum { MANY = 4096 }; /* log2 = 12 */

static void coincident_boxes_do_not_make_a_list(void **state)
{
    (void)state;
    tree t;
    tree_init(&t);
    fbox box = fbox_outward(cube_at(1, 2, 3, 0.5));
    for (uint32_t i = 0; i < MANY; i++) tree_insert(&t, i, &box);
    assert_null(tree_validate(&t));
    assert_true(height_of(&t) <= 4 * 12);
    tree_free(&t);
}

static void boxes_in_a_row_do_not_make_a_list(void **state)
{
    (void)state;
    tree t;
    tree_init(&t);
    for (uint32_t i = 0; i < MANY; i++) {
        fbox box = fbox_outward(cube_at(i, 0, 0, 0.4));
        tree_insert(&t, i, &box);
    }
    assert_null(tree_validate(&t));
    assert_true(height_of(&t) <= 4 * 12);
    tree_free(&t);
}

/* Each box twice the size of the one before and around it: the best tree is a list, and walks must survive it. */
static void nested_boxes_are_all_found(void **state)
{
    (void)state;
    enum { SHELLS = 50 };
    static model m;
    memset(&m, 0, sizeof m);
    tree_init(&m.tree);
    for (uint32_t i = 0; i < SHELLS; i++) {
        m.present[i] = true;
        m.box[i] = fbox_outward(cube_at(0, 0, 0, ldexp(1, (int)i)));
        tree_insert(&m.tree, i, &m.box[i]);
    }
    assert_null(tree_validate(&m.tree));
    fbox inmost = fbox_outward(cube_at(0, 0, 0, 0.1)), outer = fbox_outward(cube_at(1e6, 0, 0, 1));
    check_query(&m, &inmost);
    check_query(&m, &outer);
    tree_free(&m.tree);
}

static bool count_all(void *context, uint32_t proxy)
{
    (void)proxy;
    ++*(uint32_t *)context;
    return true;
}

/* A tree that is a list of 5000 nodes, made by hand: deeper than the walk's stack on the C stack. */
static void a_walk_through_a_very_deep_tree_is_complete(void **state)
{
    (void)state;
    enum { LEAVES = 5000 };
    fbox box = fbox_outward(cube_at(0, 0, 0, 1));
    tree t;
    tree_init(&t);
    for (uint32_t i = 0; i < LEAVES; i++) tree_insert(&t, i, &box); /* for the memory */
    for (uint32_t i = 0, at = TREE_ROOT; i + 1 < LEAVES; i++) {
        uint32_t pair = 2 + 2 * i;
        t.nodes[at].down = pair;
        /* Inner node first: its sibling waits on the stack for the whole descent. */
        t.nodes[pair] = (tree_node){box, at, TREE_LEAF | (LEAVES - 1)};
        t.nodes[pair + 1] = (tree_node){box, at, TREE_LEAF | i};
        t.leaf_of.at[i] = pair + 1;
        t.leaf_of.at[LEAVES - 1] = pair;
        at = pair;
    }
    assert_null(tree_validate(&t));
    assert_int_equal(height_of(&t), LEAVES - 1);
    uint32_t visits = 0;
    assert_true(tree_query_box(&t, &box, count_all, &visits));
    assert_int_equal(visits, LEAVES);
    tree_free(&t);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(random_changes_keep_the_invariants_and_the_answers),
        cmocka_unit_test(coincident_boxes_do_not_make_a_list),
        cmocka_unit_test(boxes_in_a_row_do_not_make_a_list),
        cmocka_unit_test(nested_boxes_are_all_found),
        cmocka_unit_test(a_walk_through_a_very_deep_tree_is_complete),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
