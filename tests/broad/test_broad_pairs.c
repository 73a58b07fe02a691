/* Pairs against brute force, under random create, move, teleport, resize, remove, refilter and switch between fixed and
 * moving, with a margin and a motion of each proxy's own; 10^6 operations if COLLIDED_NIGHTLY=1, else 10^5. Two
 * oracles: all pairs of tight boxes (none may be missing), and all pairs of stored fat boxes (exactly those). The
 * published changes alone must keep a table of the pairs up to date. */
#include "broad_world.h"

#include <stdlib.h>
#include <string.h>

enum { PROXIES = 70, GROUPS = 4 };

typedef struct model {
    broad *broad;
    prng random;
    double center, scale; /* m: where the world is, and how large */
    bool present[PROXIES], fixed[PROXIES];
    aabb tight[PROXIES];
    double margin[PROXIES];
    vec3 motion[PROXIES];
    unsigned groups[PROXIES]; /* bits; two proxies may pair if they share one */
    bool pair[PROXIES][PROXIES];
    size_t pairs, began, ended;
    bool removed[PROXIES]; /* in this batch */
} model;

static bool share_a_group(void *context, uint32_t a, uint32_t b)
{
    const model *m = context;
    assert_true(a < b);
    return (m->groups[a] & m->groups[b]) != 0;
}

static aabb random_box(model *m)
{
    vec3 half = vec(prng_between(&m->random, 0, 1), prng_between(&m->random, 0, 1), prng_between(&m->random, 0, 1));
    vec3 center = vec_add(vec_scale(random_vec(&m->random, 4), m->scale), vec(m->center, m->center, -m->center));
    aabb box = box_at(center, vec_scale(half, m->scale));
    uint32_t kind = prng_below(&m->random, 40);
    if (kind == 0) box.lo.x = -INFINITY, box.lo.y = -INFINITY, box.hi.x = INFINITY, box.hi.y = INFINITY;
    if (kind <= 1) box.lo.z = -INFINITY; /* a floor, or a post that reaches down without end */
    return box;
}

static void put(model *m, uint32_t id)
{
    broad_move move = {
        .proxy = id, .fixed = m->fixed[id], .box = m->tight[id], .margin = m->margin[id], .motion = m->motion[id]};
    broad_put(m->broad, &move);
    m->present[id] = true;
}

static void create(model *m, uint32_t id)
{
    m->tight[id] = random_box(m);
    m->fixed[id] = prng_below(&m->random, 3) == 0;
    m->margin[id] = prng_below(&m->random, 4) == 0 ? 0 : prng_between(&m->random, 0, 0.5) * m->scale;
    m->motion[id] = VEC_ZERO;
    m->groups[id] = 1 + prng_below(&m->random, (1 << GROUPS) - 1);
    put(m, id);
}

static void drop(model *m, uint32_t id)
{
    broad_remove(m->broad, id);
    m->present[id] = false;
    m->removed[id] = true;
}

static void regroup(model *m, uint32_t id)
{
    m->groups[id] = prng_below(&m->random, 1 << GROUPS);
    broad_refilter(m->broad, id);
}

static void change_one(model *m)
{
    uint32_t id = prng_below(&m->random, PROXIES), what = prng_below(&m->random, 100);
    if (!m->present[id]) {
        if (what < 60) create(m, id);
        if (what > 97) broad_remove(m->broad, id); /* one that is not there: nothing happens */
        return;
    }
    if (what < 45) { /* a small step */
        vec3 step = vec_scale(random_vec(&m->random, 0.2), m->scale);
        m->tight[id].lo = vec_add(m->tight[id].lo, step);
        m->tight[id].hi = vec_add(m->tight[id].hi, step);
        m->motion[id] = prng_below(&m->random, 3) ? step : VEC_ZERO;
        put(m, id);
    } else if (what < 60) { /* teleport and resize */
        m->tight[id] = random_box(m);
        put(m, id);
    } else if (what < 75) {
        drop(m, id);
    } else if (what < 80) { /* under the same id another thing */
        drop(m, id);
        create(m, id);
    } else if (what < 90) {
        regroup(m, id);
    } else if (what < 95) {
        m->fixed[id] = !m->fixed[id];
        put(m, id);
    } else {
        m->margin[id] = prng_between(&m->random, 0, 0.5) * m->scale;
        put(m, id);
    }
}

/* `ended` first, then `began`, as broad.h says. */
static void follow(model *m, const broad_changes *c)
{
    assert_sorted(c->ended, c->ended_count);
    assert_sorted(c->began, c->began_count);
    for (size_t i = 0; i < c->ended_count; i++) {
        bool *pair = &m->pair[c->ended[i].a][c->ended[i].b];
        assert_true(*pair);
        *pair = false;
    }
    for (size_t i = 0; i < c->began_count; i++) {
        bool *pair = &m->pair[c->began[i].a][c->began[i].b];
        assert_false(*pair);
        *pair = true;
    }
    m->pairs += c->began_count - c->ended_count;
    m->began += c->began_count;
    m->ended += c->ended_count;
}

/* Whatever ended and began again in one update belongs to a proxy that was removed and put again. */
static void check_no_flicker(const model *m, const broad_changes *c)
{
    size_t e = 0;
    for (size_t i = 0; i < c->began_count; i++) {
        while (e < c->ended_count && pair_less(c->ended[e], c->began[i])) e++;
        bool both = e < c->ended_count && c->ended[e].a == c->began[i].a && c->ended[e].b == c->began[i].b;
        if (both) assert_true(m->removed[c->began[i].a] || m->removed[c->began[i].b]);
    }
}

static void check_boxes(const model *m, broad_stored *stored)
{
    for (uint32_t i = 0; i < PROXIES; i++) {
        assert_int_equal(broad_peek(m->broad, i, &stored[i]), m->present[i]);
        if (!m->present[i]) continue;
        assert_int_equal(stored[i].fixed, m->fixed[i]);
        assert_int_equal(stored[i].unbounded, !vec_finite(m->tight[i].lo) || !vec_finite(m->tight[i].hi));
        assert_true(fbox_contains_aabb(&stored[i].fat, &m->tight[i]));
    }
}

static void check_pairs(model *m)
{
    static broad_stored stored[PROXIES];
    check_boxes(m, stored);
    for (uint32_t a = 0; a < PROXIES; a++)
        for (uint32_t b = a + 1; b < PROXIES; b++) {
            bool eligible = m->present[a] && m->present[b] && !(m->fixed[a] && m->fixed[b]) && share_a_group(m, a, b);
            bool expected = eligible && fbox_overlap(&stored[a].fat, &stored[b].fat);
            bool tight = eligible && aabb_overlap(m->tight[a], m->tight[b]);
            if (m->pair[a][b] != expected || (tight && !m->pair[a][b]))
                fail_msg("pair %u, %u: %d, fat boxes say %d, tight boxes %d", a, b, m->pair[a][b], expected, tight);
        }
    assert_int_equal(broad_pair_count(m->broad), m->pairs);
}

typedef struct others {
    const model *m;
    uint32_t id, count;
} others;

static void check_other(void *context, uint32_t other)
{
    others *o = context;
    assert_true(o->id < other ? o->m->pair[o->id][other] : o->m->pair[other][o->id]);
    o->count++;
}

static void check_pair_lists(const model *m)
{
    uint32_t sum = 0;
    for (uint32_t i = 0; i < PROXIES; i++) {
        others o = {m, i, 0};
        broad_each_pair_of(m->broad, i, check_other, &o);
        sum += o.count;
    }
    assert_int_equal(sum, 2 * m->pairs);
}

static void run(uint64_t seed, double center, double scale, int operations)
{
    static model m;
    memset(&m, 0, sizeof m);
    m.random.state = seed;
    m.center = center;
    m.scale = scale;
    m.broad = make_broad(share_a_group, &m);
    for (int done = 0, update = 0; done < operations; update++) {
        memset(m.removed, 0, sizeof m.removed);
        for (uint32_t batch = 1 + prng_below(&m.random, 30); batch > 0; batch--, done++) change_one(&m);
        broad_changes changes;
        broad_update(m.broad, &changes);
        follow(&m, &changes);
        check_no_flicker(&m, &changes);
        check_pairs(&m);
        if (update % 16) continue;
        check_pair_lists(&m);
        const char *broken = broad_validate(m.broad);
        if (broken) fail_msg("update %d: %s", update, broken);
    }
    assert_true(m.began > (size_t)operations / 10 && m.ended > (size_t)operations / 10);
    broad_destroy(m.broad);
}

static void pairs_equal_brute_force(void **state)
{
    (void)state;
    const char *nightly = getenv("COLLIDED_NIGHTLY");
    run(1, 0, 1, nightly && strcmp(nightly, "1") == 0 ? 1000000 : 100000);
}

static void pairs_equal_brute_force_for_tiny_bodies(void **state)
{
    (void)state;
    run(2, 3, 1e-6, 20000);
}

static void pairs_equal_brute_force_far_from_the_origin(void **state)
{
    (void)state;
    run(3, 1e6, 1, 20000);
    run(4, 1e12, 1e5, 20000); /* floats lie 65,536 m apart here */
    run(5, 1e12, 1, 5000);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(pairs_equal_brute_force),
        cmocka_unit_test(pairs_equal_brute_force_for_tiny_bodies),
        cmocka_unit_test(pairs_equal_brute_force_far_from_the_origin),
    };
    return run_with_each_index(tests);
}
