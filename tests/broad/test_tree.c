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

/* A few, so that they are inserted; or so many that the tree is built anew. */
static void announce_some(model *m, prng *r)
{
    uint32_t most = prng_below(r, 10) ? 3 : PROXIES;
    for (uint32_t i = 0; i < PROXIES && most > 0; i++) {
        if (m->present[i]) continue;
        m->box[i] = random_fbox(r);
        tree_announce(&m->tree, i, &m->box[i]);
        m->present[i] = true;
        most--;
    }
    tree_settle(&m->tree);
}

/* Most of them in one batch: moved, removed and announced while boxes above do not follow. */
static void change_most(model *m, prng *r)
{
    tree_loosen(&m->tree, PROXIES);
    for (uint32_t i = 0; i < PROXIES; i++) {
        uint32_t what = prng_below(r, 8);
        if (what == 0 && m->present[i]) tree_remove(&m->tree, i);
        if (what == 0) m->present[i] = false;
        if (what < 2 && m->present[i]) continue;
        if (what) m->box[i] = random_fbox(r);
        if (what && m->present[i]) tree_move(&m->tree, i, &m->box[i]);
        if (what > 5 && !m->present[i]) tree_announce(&m->tree, i, &m->box[i]), m->present[i] = true;
    }
    tree_settle(&m->tree);
}

static void random_changes_keep_the_invariants_and_the_answers(void **state)
{
    (void)state;
    static model m;
    tree_init(&m.tree);
    prng r = {1};
    for (int i = 0; i < 20000; i++) {
        uint32_t proxy = prng_below(&r, PROXIES), what = prng_below(&r, 4);
        if (!m.present[proxy] || what > 0) m.box[proxy] = random_fbox(&r);
        if (m.present[proxy] && what == 0) {
            tree_remove(&m.tree, proxy);
            m.present[proxy] = false;
        } else if (m.present[proxy]) {
            tree_move(&m.tree, proxy, &m.box[proxy]);
        } else if (what == 1) {
            tree_insert(&m.tree, proxy, &m.box[proxy]);
            m.present[proxy] = true;
        } else {
            announce_some(&m, &r);
        }
        if (i % 50 == 49) change_most(&m, &r);
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

/* ---- quality: the sum of the areas of all inner nodes, which is what a query costs ---- */

static double sum_of_areas(const tree *t)
{
    ARRAY(uint32_t) ahead = {0};
    double sum = 0;
    array_push(&ahead, (uint32_t)TREE_ROOT);
    while (ahead.count > 0) {
        const tree_node *n = &t->nodes[ahead.at[--ahead.count]];
        if (tree_is_leaf(n)) continue;
        sum += fbox_area(&n->box);
        array_push(&ahead, n->down);
        array_push(&ahead, n->down + 1);
    }
    array_free(&ahead);
    return sum;
}

static double area_when_built(const fbox *boxes, uint32_t count)
{
    tree t;
    tree_init(&t);
    for (uint32_t i = 0; i < count; i++) tree_announce(&t, i, &boxes[i]);
    tree_settle(&t);
    assert_null(tree_validate(&t));
    double area = sum_of_areas(&t);
    tree_free(&t);
    return area;
}

static void a_built_tree_is_as_good_as_one_of_insertions(void **state)
{
    (void)state;
    static fbox boxes[MANY];
    prng r = {2};
    tree t;
    tree_init(&t);
    for (uint32_t i = 0; i < MANY; i++) {
        boxes[i] = fbox_outward(box_at(random_vec(&r, 20), vec(0.5, 0.5, 0.5)));
        tree_insert(&t, i, &boxes[i]);
    }
    assert_true(area_when_built(boxes, MANY) < 1.2 * sum_of_areas(&t));
    assert_true(sum_of_areas(&t) < 1.2 * area_when_built(boxes, MANY));
    tree_free(&t);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(random_changes_keep_the_invariants_and_the_answers),
        cmocka_unit_test(coincident_boxes_do_not_make_a_list),
        cmocka_unit_test(boxes_in_a_row_do_not_make_a_list),
        cmocka_unit_test(nested_boxes_are_all_found),
        cmocka_unit_test(a_built_tree_is_as_good_as_one_of_insertions),
        cmocka_unit_test(a_walk_through_a_very_deep_tree_is_complete),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
