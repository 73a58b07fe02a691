/* All indices side by side: whatever is done, each brings the same changes, number for number, and holds the same
 * boxes and pairs; and auto changes from one to another where it says, without anybody noticing. */
#include "broad_world.h"

#include <stdlib.h>
#include <string.h>

enum { KINDS = 4, PROXIES = 420, COARSE = 4 };

typedef struct side_by_side {
    broad *broad[KINDS];
    prng random;
    vec3 at[PROXIES], half[PROXIES];
    bool present[PROXIES], fixed[PROXIES];
    unsigned groups[PROXIES];
    bool flat; /* all in one layer, and on a coarse grid: many ends at the same place */
} side_by_side;

static bool share_a_group(void *context, uint32_t a, uint32_t b)
{
    const side_by_side *s = context;
    return (s->groups[a] & s->groups[b]) != 0;
}

static void put(side_by_side *s, uint32_t id, vec3 motion)
{
    aabb box = box_at(s->at[id], s->half[id]);
    if (id % 50 == 7) box.lo.z = -INFINITY;
    for (int k = 0; k < KINDS; k++)
        broad_put(s->broad[k],
            &(broad_move){
                .proxy = id, .fixed = s->fixed[id], .box = box, .margin = id % 3 ? 0.05 : 0, .motion = motion});
    s->present[id] = true;
}

static void place(side_by_side *s, uint32_t id)
{
    s->at[id] = random_vec(&s->random, 5);
    s->half[id] = vec(0.5, 0.5, 0.5);
    if (prng_below(&s->random, 30) == 0) s->half[id] = vec(6, 6, 0.1); /* a plate */
    if (!s->flat) return;
    s->at[id] = vec(prng_below(&s->random, 10 * COARSE) / (double)COARSE, prng_below(&s->random, 10), 0);
}

static void drop(side_by_side *s, uint32_t id)
{
    for (int k = 0; k < KINDS; k++) broad_remove(s->broad[k], id);
    s->present[id] = false;
}

static void change_one(side_by_side *s, uint32_t id)
{
    uint32_t what = prng_below(&s->random, 100);
    vec3 step = s->flat ? vec(0.25, 0, 0) : random_vec(&s->random, 0.3);
    if (!s->present[id] || what < 10) { /* teleport */
        place(s, id);
        put(s, id, VEC_ZERO);
    } else if (what < 80) {
        s->at[id] = vec_add(s->at[id], step);
        put(s, id, what < 40 ? step : VEC_ZERO);
    } else if (what < 84) {
        s->half[id] = vec_scale(s->half[id], prng_between(&s->random, 0.5, 1.5));
        put(s, id, VEC_ZERO);
    } else if (what < 88) {
        s->fixed[id] = !s->fixed[id];
        put(s, id, VEC_ZERO);
    } else if (what < 94) {
        s->groups[id] = 1 + prng_below(&s->random, 7);
        for (int k = 0; k < KINDS; k++) broad_refilter(s->broad[k], id);
    } else {
        drop(s, id);
        if (what < 97) put(s, id, VEC_ZERO);
    }
}

static void assert_same(const broad_changes *one, const broad_changes *other)
{
    assert_int_equal(one->began_count, other->began_count);
    assert_int_equal(one->ended_count, other->ended_count);
    if (one->began_count) assert_memory_equal(one->began, other->began, one->began_count * sizeof *one->began);
    if (one->ended_count) assert_memory_equal(one->ended, other->ended, one->ended_count * sizeof *one->ended);
}

static size_t update_all(side_by_side *s)
{
    broad_changes changes[KINDS];
    for (int k = 0; k < KINDS; k++) {
        broad_update(s->broad[k], &changes[k]);
        assert_same(&changes[0], &changes[k]);
    }
    return changes[0].began_count + changes[0].ended_count;
}

static void validate_all(const side_by_side *s)
{
    for (int k = 0; k < KINDS; k++) {
        const char *broken = broad_validate(s->broad[k]);
        if (broken) fail_msg("%s: %s", broad_kind_name(broad_index_kind(s->broad[k])), broken);
        assert_int_equal(broad_pair_count(s->broad[0]), broad_pair_count(s->broad[k]));
        assert_int_equal(broad_proxy_count(s->broad[0]), broad_proxy_count(s->broad[k]));
    }
}

static side_by_side *make(uint64_t seed, bool flat)
{
    static side_by_side s;
    memset(&s, 0, sizeof s);
    s.random.state = seed;
    s.flat = flat;
    for (uint32_t i = 0; i < PROXIES; i++) s.groups[i] = 7;
    for (int k = 0; k < KINDS; k++) s.broad[k] = broad_create((broad_kind)k, share_a_group, &s);
    return &s;
}

static void destroy(side_by_side *s)
{
    for (int k = 0; k < KINDS; k++) broad_destroy(s->broad[k]);
}

/* The world grows and shrinks, so that auto changes its mind. */
static void run(uint64_t seed, bool flat)
{
    side_by_side *s = make(seed, flat);
    size_t changes = 0, switches = 0;
    broad_kind stood = broad_index_kind(s->broad[BROAD_AUTO]);
    for (int t = 0; t < 600; t++) {
        bool small = t / 100 % 2 == 0;
        uint32_t ids = small ? 80 : PROXIES, batch = t % 5 == 0 ? ids : 1 + prng_below(&s->random, ids);
        for (uint32_t id = ids; small && id < PROXIES; id++)
            if (s->present[id]) drop(s, id);
        for (uint32_t i = 0; i < batch; i++) change_one(s, prng_below(&s->random, ids));
        changes += update_all(s);
        switches += broad_index_kind(s->broad[BROAD_AUTO]) != stood;
        stood = broad_index_kind(s->broad[BROAD_AUTO]);
        if (t % 10 == 0) validate_all(s);
    }
    assert_true(changes > 10000);
    assert_int_equal(switches, 5);
    destroy(s);
}

static void all_indices_bring_the_same_changes(void **state)
{
    (void)state;
    run(1, false);
    run(2, false);
}

static void and_where_many_ends_are_at_one_place(void **state)
{
    (void)state;
    run(3, true);
    run(4, true);
}

/* Two that exchange their places, and one that goes through another, in one batch. */
static void what_passes_by_in_one_batch_has_not_met(void **state)
{
    (void)state;
    side_by_side *s = make(5, false);
    for (uint32_t i = 0; i < 2; i++) {
        s->at[i] = vec(3.0 * i, 0, 0);
        s->half[i] = vec(0.5, 0.5, 0.5);
        put(s, i, VEC_ZERO);
    }
    assert_int_equal(update_all(s), 0);
    s->at[0].x = 3, s->at[1].x = 0;
    put(s, 0, VEC_ZERO), put(s, 1, VEC_ZERO);
    assert_int_equal(update_all(s), 0);
    s->at[0].x = 10, s->at[1].x = 10.5; /* they meet elsewhere: one change */
    put(s, 1, VEC_ZERO), put(s, 0, VEC_ZERO);
    assert_int_equal(update_all(s), 1);
    s->at[0].x = -4, s->at[1].x = -4.5;
    put(s, 1, VEC_ZERO), put(s, 0, VEC_ZERO);
    assert_int_equal(update_all(s), 0);
    validate_all(s);
    destroy(s);
}

static void fill_to(broad *b, uint32_t from, uint32_t to)
{
    broad_changes changes;
    for (uint32_t id = from; id < to; id++) broad_put(b, &(broad_move){.proxy = id, .box = cube_at(2.0 * id, 0, 0, 1)});
    for (uint32_t id = to; id < from; id++) broad_remove(b, id);
    broad_update(b, &changes);
}

static void auto_changes_where_it_says(void **state)
{
    (void)state;
    char text[96];
    broad *b = broad_create(BROAD_AUTO, accept_all, NULL);
    fill_to(b, 0, 256);
    assert_int_equal(broad_index_kind(b), BROAD_SWEEP3);
    broad_report_index(b, text);
    assert_string_equal(text, "sweep3 (auto: 256 proxies; tree for more than 256)");
    fill_to(b, 256, 257);
    assert_int_equal(broad_index_kind(b), BROAD_TREE);
    fill_to(b, 257, 129);
    assert_int_equal(broad_index_kind(b), BROAD_TREE);
    broad_report_index(b, text);
    assert_string_equal(text, "tree (auto: 129 proxies; sweep3 for 128 and fewer)");
    fill_to(b, 129, 128);
    assert_int_equal(broad_index_kind(b), BROAD_SWEEP3);
    assert_int_equal(broad_pair_count(b), 127);
    assert_null(broad_validate(b));
    broad_destroy(b);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(all_indices_bring_the_same_changes),
        cmocka_unit_test(and_where_many_ends_are_at_one_place),
        cmocka_unit_test(what_passes_by_in_one_batch_has_not_met),
        cmocka_unit_test(auto_changes_where_it_says),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
