/* Cases that a reader can follow: one property of the broad phase each. */
#include "broad_world.h"

#include <math.h>

static void put_box(broad *b, uint32_t id, bool fixed, aabb box, double margin)
{
    broad_move move = {.proxy = id, .fixed = fixed, .box = box, .margin = margin};
    broad_put(b, &move);
}

static broad_changes update(broad *b)
{
    broad_changes c;
    broad_update(b, &c);
    const char *broken = broad_validate(b);
    if (broken) fail_msg("%s", broken);
    return c;
}

static void assert_changes(broad_changes c, size_t began, size_t ended)
{
    assert_int_equal(c.began_count, began);
    assert_int_equal(c.ended_count, ended);
}

static void coincident_boxes_give_all_pairs(void **state)
{
    (void)state;
    enum { BOXES = 200, PAIRS = BOXES * (BOXES - 1) / 2 };
    broad *b = make_broad(accept_all, NULL);
    for (uint32_t i = 0; i < BOXES; i++) put_box(b, i, false, cube_at(0, 0, 0, 0.5), 0.05);
    broad_changes c = update(b);
    assert_changes(c, PAIRS, 0);
    assert_sorted(c.began, c.began_count);
    assert_int_equal(broad_pair_count(b), PAIRS);
    assert_int_equal(broad_proxy_count(b), BOXES);
    for (uint32_t i = 0; i < BOXES; i++) broad_remove(b, i);
    c = update(b);
    assert_changes(c, 0, PAIRS);
    assert_sorted(c.ended, c.ended_count);
    assert_int_equal(broad_pair_count(b), 0);
    assert_int_equal(broad_proxy_count(b), 0);
    broad_destroy(b);
}

static void a_box_that_stays_in_its_fat_box_changes_nothing(void **state)
{
    (void)state;
    broad *b = make_broad(accept_all, NULL);
    put_box(b, 0, false, cube_at(0, 0, 0, 0.5), 0.1);
    put_box(b, 1, false, cube_at(1.15, 0, 0, 0.5), 0.1);
    assert_changes(update(b), 1, 0);
    broad_stored before, after;
    assert_true(broad_peek(b, 0, &before));
    put_box(b, 0, false, cube_at(-0.09, 0, 0, 0.5), 0.1);
    assert_changes(update(b), 0, 0);
    assert_true(broad_peek(b, 0, &after));
    assert_true(fbox_equal(&before.fat, &after.fat));
    put_box(b, 0, false, cube_at(-0.11, 0, 0, 0.5), 0.1); /* leaves it, and parts */
    assert_changes(update(b), 0, 1);
    broad_destroy(b);
}

static void a_stored_box_is_the_tight_one_and_its_margin(void **state)
{
    (void)state;
    broad *b = make_broad(accept_all, NULL);
    put_box(b, 0, false, cube_at(10, 20, 30, 2), 0.25);
    update(b);
    broad_stored s;
    assert_true(broad_peek(b, 0, &s));
    fbox expected = fbox_outward(cube_at(10, 20, 30, 2.25));
    assert_true(fbox_equal(&s.fat, &expected));
    broad_destroy(b);
}

static void a_box_that_shrank_is_fattened_anew(void **state)
{
    (void)state;
    broad *b = make_broad(accept_all, NULL);
    put_box(b, 0, false, cube_at(0, 0, 0, 10), 0.1); /* swept, or widened by a far-reaching subscription */
    put_box(b, 1, false, cube_at(5, 0, 0, 0.5), 0.1);
    assert_changes(update(b), 1, 0);
    put_box(b, 0, false, cube_at(0, 0, 0, 1), 0.1);
    assert_changes(update(b), 0, 1);
    broad_destroy(b);
}

static void fixed_boxes_do_not_pair_with_each_other(void **state)
{
    (void)state;
    broad *b = make_broad(accept_all, NULL);
    put_box(b, 0, true, cube_at(0, 0, 0, 1), 0);
    put_box(b, 1, true, cube_at(0, 0, 0, 1), 0);
    put_box(b, 2, false, cube_at(0, 0, 0, 1), 0);
    assert_changes(update(b), 2, 0);
    put_box(b, 1, false, cube_at(0, 0, 0, 1), 0); /* starts to move */
    assert_changes(update(b), 1, 0);
    put_box(b, 1, true, cube_at(0, 0, 0, 1), 0);
    put_box(b, 2, true, cube_at(0, 0, 0, 1), 0);
    assert_changes(update(b), 0, 3);
    broad_destroy(b);
}

static aabb floor_below(double z)
{
    return (aabb){{-INFINITY, -INFINITY, -INFINITY}, {INFINITY, INFINITY, z}};
}

static void a_half_space_pairs_with_what_reaches_into_its_box(void **state)
{
    (void)state;
    broad *b = make_broad(accept_all, NULL);
    put_box(b, 0, true, floor_below(0), 0);
    put_box(b, 1, true, floor_below(-1), 0);
    put_box(b, 2, false, cube_at(1e9, -1e9, 0.5, 1), 0);
    put_box(b, 3, false, cube_at(0, 0, 10, 1), 0);
    put_box(b, 4, true, cube_at(0, 0, 0, 1), 0);
    broad_changes c = update(b);
    assert_changes(c, 1, 0);
    assert_int_equal(c.began[0].a, 0);
    assert_int_equal(c.began[0].b, 2);
    put_box(b, 0, false, floor_below(100), 0); /* the floor starts to move: it meets everything but nobody twice */
    assert_changes(update(b), 3, 0);
    put_box(b, 0, false, cube_at(0, 0, -50, 1), 0); /* a common box from now on */
    assert_changes(update(b), 0, 3);
    broad_stored s;
    assert_true(broad_peek(b, 0, &s));
    assert_false(s.unbounded);
    broad_destroy(b);
}

static void a_whole_space_pairs_with_everything_that_moves(void **state)
{
    (void)state;
    broad *b = make_broad(accept_all, NULL);
    put_box(b, 9, true, floor_below(INFINITY), 1);
    put_box(b, 2, false, floor_below(INFINITY), 1);
    put_box(b, 3, false, cube_at(1e12, 0, 0, 1), 1);
    put_box(b, 4, true, cube_at(0, -1e12, 0, 1), 1);
    assert_changes(update(b), 4, 0); /* 2-3, 2-4, 2-9, 3-9 */
    broad_destroy(b);
}

static void far_away_no_overlap_is_lost(void **state)
{
    (void)state;
    const double far = 1e12;
    broad *b = make_broad(accept_all, NULL);
    put_box(b, 0, false, cube_at(far, -far, far, 0.5), 0.01);
    put_box(b, 1, false, cube_at(far + 0.9, -far, far, 0.5), 0.01);
    put_box(b, 2, false, cube_at(far + 1e6, -far, far, 0.5), 0.01);
    broad_changes c = update(b);
    assert_changes(c, 1, 0);
    assert_int_equal(c.began[0].a, 0);
    assert_int_equal(c.began[0].b, 1);
    broad_destroy(b);
}

static void a_proxy_removed_and_put_again_ends_and_begins(void **state)
{
    (void)state;
    broad *b = make_broad(accept_all, NULL);
    put_box(b, 0, false, cube_at(0, 0, 0, 1), 0);
    put_box(b, 1, false, cube_at(1, 0, 0, 1), 0);
    assert_changes(update(b), 1, 0);
    broad_remove(b, 0);
    put_box(b, 0, false, cube_at(0, 0, 0, 1), 0);
    assert_changes(update(b), 1, 1);
    assert_int_equal(broad_pair_count(b), 1);
    broad_remove(b, 0);
    put_box(b, 0, false, cube_at(0, 0, 0, 1), 0);
    broad_remove(b, 0);
    assert_changes(update(b), 0, 1);
    broad_destroy(b);
}

static void what_never_came_to_an_update_never_was(void **state)
{
    (void)state;
    broad *b = make_broad(accept_all, NULL);
    put_box(b, 0, false, cube_at(0, 0, 0, 1), 0);
    put_box(b, 1, false, cube_at(0, 0, 0, 1), 0);
    broad_remove(b, 1);
    broad_remove(b, 5);
    broad_refilter(b, 7);
    assert_changes(update(b), 0, 0);
    assert_int_equal(broad_proxy_count(b), 1);
    broad_destroy(b);
}

static bool switched_on(void *context, uint32_t a, uint32_t b)
{
    (void)a, (void)b;
    return *(bool *)context;
}

static void a_refilter_begins_and_ends_pairs_of_resting_boxes(void **state)
{
    (void)state;
    bool on = false;
    broad *b = make_broad(switched_on, &on);
    put_box(b, 0, false, cube_at(0, 0, 0, 1), 0);
    put_box(b, 1, true, cube_at(0, 0, 0, 1), 0);
    assert_changes(update(b), 0, 0);
    on = true;
    assert_changes(update(b), 0, 0); /* nobody said that anything changed */
    broad_refilter(b, 1);
    assert_changes(update(b), 1, 0);
    on = false;
    broad_refilter(b, 0);
    broad_refilter(b, 1);
    assert_changes(update(b), 0, 1);
    broad_destroy(b);
}

/* ---- the order of the calls ---- */

enum { CROWD = 150 };

static void put_crowd(broad *b, const broad_move *moves, const uint32_t *order)
{
    for (uint32_t i = 0; i < CROWD; i++) {
        const broad_move *m = &moves[order[i]];
        if (m->proxy % 11 == 3) broad_remove(b, m->proxy);
        if (m->proxy % 7 != 5) broad_put(b, m);
        if (m->proxy % 13 == 1) broad_refilter(b, m->proxy);
    }
}

static void shuffle(uint32_t *order, prng *r)
{
    for (uint32_t i = CROWD - 1; i > 0; i--) {
        uint32_t k = prng_below(r, i + 1), other = order[k];
        order[k] = order[i];
        order[i] = other;
    }
}

typedef struct sequence {
    uint32_t at[CROWD];
    size_t count;
} sequence;

static bool append(void *context, uint32_t proxy)
{
    sequence *s = context;
    s->at[s->count++] = proxy;
    return true;
}

/* Not only the changes: the trees are the same, so queries answer in the same order. */
static void assert_same_answers(const broad *one, const broad *two)
{
    sequence s1 = {.count = 0}, s2 = {.count = 0};
    broad_query_box(one, cube_at(0, 0, 0, 3), append, &s1);
    broad_query_box(two, cube_at(0, 0, 0, 3), append, &s2);
    assert_true(s1.count > 0);
    assert_int_equal(s1.count, s2.count);
    assert_memory_equal(s1.at, s2.at, s1.count * sizeof *s1.at);
}

static void the_order_of_the_calls_does_not_matter(void **state)
{
    (void)state;
    static broad_move moves[CROWD];
    uint32_t order[CROWD];
    prng r = {1};
    broad *one = make_broad(accept_all, NULL), *two = make_broad(accept_all, NULL);
    for (uint32_t i = 0; i < CROWD; i++) order[i] = i;
    for (int tick = 0; tick < 50; tick++) {
        for (uint32_t i = 0; i < CROWD; i++)
            moves[i] = (broad_move){
                .proxy = i, .fixed = i % 5 == 0, .box = box_at(random_vec(&r, 5), vec(0.5, 0.5, 0.5)), .margin = 0.1};
        put_crowd(one, moves, order);
        broad_changes c1 = update(one);
        shuffle(order, &r);
        put_crowd(two, moves, order);
        broad_changes c2 = update(two);
        assert_changes(c2, c1.began_count, c1.ended_count);
        assert_true(c1.began_count > 0);
        assert_memory_equal(c1.began, c2.began, c1.began_count * sizeof *c1.began);
        if (c1.ended_count) assert_memory_equal(c1.ended, c2.ended, c1.ended_count * sizeof *c1.ended);
        assert_same_answers(one, two);
    }
    broad_destroy(one);
    broad_destroy(two);
}

enum { NUMBERED = 320 };

typedef struct numbers {
    uint32_t of;
    size_t seen, given, wrong;
} numbers;

static void look_at_number(void *context, uint32_t other, uint32_t *number)
{
    numbers *n = context;
    uint32_t lo = n->of < other ? n->of : other, hi = n->of + other - lo;
    n->seen++;
    n->given += *number != BROAD_NO_NUMBER;
    n->wrong += *number != BROAD_NO_NUMBER && *number != NUMBERED * lo + hi;
    *number = NUMBERED * lo + hi;
}

static numbers look_at_numbers(broad *b)
{
    numbers n = {.seen = 0};
    for (n.of = 0; n.of < NUMBERED; n.of++) broad_each_number_of(b, n.of, look_at_number, &n);
    return n;
}

/* Both of its proxies find it, whatever else ends, and when memory is given back; one that meets again has none. */
static void a_pair_keeps_its_number_as_long_as_it_is_one(void **state)
{
    (void)state;
    enum { PAIRS = NUMBERED * (NUMBERED - 1) / 2, LEFT = 40, PAIRS_LEFT = LEFT * (LEFT - 1) / 2 };
    broad *b = make_broad(accept_all, NULL);
    for (uint32_t i = 0; i < NUMBERED; i++) put_box(b, i, false, cube_at(0, 0, 0, 0.5), 0.05);
    assert_changes(update(b), PAIRS, 0);
    numbers n = look_at_numbers(b);
    assert_int_equal(n.seen, 2 * PAIRS);
    assert_int_equal(n.given, PAIRS); /* at the first of the two looks none was there */
    assert_int_equal(n.wrong, 0);
    for (uint32_t i = 0; i < NUMBERED; i++)
        if (i % (NUMBERED / LEFT)) broad_remove(b, i);
    update(b);
    broad_trim(b);
    n = look_at_numbers(b);
    assert_int_equal(n.seen, 2 * PAIRS_LEFT);
    assert_int_equal(n.given, n.seen);
    assert_int_equal(n.wrong, 0);
    put_box(b, 0, false, cube_at(9, 0, 0, 0.5), 0.05);
    assert_changes(update(b), 0, LEFT - 1);
    put_box(b, 0, false, cube_at(0, 0, 0, 0.5), 0.05);
    assert_changes(update(b), LEFT - 1, 0);
    n = look_at_numbers(b);
    assert_int_equal(n.seen - n.given, LEFT - 1);
    assert_int_equal(n.wrong, 0);
    broad_destroy(b);
}

/* ---- a search around very many ---- */

enum { VERY_MANY = 40000, HUB = VERY_MANY, A_PART = 200000 /* units */ };

/* All parts of the search; `ends`: of pairs that part. How many parts there were. */
static size_t search_in_parts(broad *b, bool ends, size_t expected)
{
    size_t parts = 0, changed = 0, fewest = SIZE_MAX;
    uint32_t last = 0;
    for (bool whole = false; !whole; parts++) {
        broad_changes c;
        uint64_t spent;
        whole = broad_search(b, HUB, A_PART, NULL, NULL, &c, &spent);
        const broad_pair *some = ends ? c.ended : c.began;
        size_t count = ends ? c.ended_count : c.began_count;
        assert_int_equal(ends ? c.began_count : c.ended_count, 0);
        for (size_t i = 0; i < count; i++) {
            assert_int_equal(some[i].b, HUB);
            assert_true(changed + i == 0 || some[i].a > last);
            last = some[i].a;
        }
        changed += count;
        if (!whole && count < fewest) fewest = count;
        assert_true(parts < 2000 && spent < A_PART + 4000000);
    }
    assert_int_equal(changed, expected);
    assert_true(fewest >= 64);
    return parts;
}

/* Three in four are near it, one in five of these does not move, as it does itself at last; one is a half-space. */
static void a_search_around_very_many_finds_each_of_them_by_rising_ids(void **state)
{
    (void)state;
    const double inf = INFINITY;
    broad *b = make_broad(accept_all, NULL);
    size_t near = 0, near_moving = 0;
    for (uint32_t i = 0; i < VERY_MANY; i++) {
        bool fixed = i % 5 == 0, is_far = i % 4 == 3, is_plane = i == 77;
        aabb box = cube_at(0.1 * i, is_far ? 1e6 : 0, 0, 0.01);
        if (is_plane) box = (aabb){vec(-inf, -inf, -inf), vec(inf, inf, -1)};
        put_box(b, i, fixed || is_plane, box, 0.001);
        near += !is_far && !is_plane;
        near_moving += !is_far && !is_plane && !fixed;
    }
    update(b);
    broad_set_limit(b, 1000, SIZE_MAX);
    put_box(b, HUB, false, cube_at(0, 0, 0, 0.2 * VERY_MANY), 0.1);
    assert_changes(update(b), 0, 0);
    assert_true(broad_is_unsearched(b, HUB));
    assert_true(search_in_parts(b, false, near + 1) > 2);
    put_box(b, HUB, false, cube_at(0, 0, 4e6, 1), 0.1);
    assert_changes(update(b), 0, 0);
    assert_true(search_in_parts(b, true, near + 1) > 2);
    put_box(b, HUB, true, cube_at(0, 0, 0, 0.2 * VERY_MANY), 0.1);
    update(b);
    assert_true(search_in_parts(b, false, near_moving) > 2);
    broad_destroy(b);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(coincident_boxes_give_all_pairs),
        cmocka_unit_test(a_box_that_stays_in_its_fat_box_changes_nothing),
        cmocka_unit_test(a_stored_box_is_the_tight_one_and_its_margin),
        cmocka_unit_test(a_box_that_shrank_is_fattened_anew),
        cmocka_unit_test(fixed_boxes_do_not_pair_with_each_other),
        cmocka_unit_test(a_half_space_pairs_with_what_reaches_into_its_box),
        cmocka_unit_test(a_whole_space_pairs_with_everything_that_moves),
        cmocka_unit_test(far_away_no_overlap_is_lost),
        cmocka_unit_test(a_proxy_removed_and_put_again_ends_and_begins),
        cmocka_unit_test(what_never_came_to_an_update_never_was),
        cmocka_unit_test(a_refilter_begins_and_ends_pairs_of_resting_boxes),
        cmocka_unit_test(the_order_of_the_calls_does_not_matter),
        cmocka_unit_test(a_pair_keeps_its_number_as_long_as_it_is_one),
        cmocka_unit_test(a_search_around_very_many_finds_each_of_them_by_rising_ids),
    };
    return run_with_each_index(tests);
}
