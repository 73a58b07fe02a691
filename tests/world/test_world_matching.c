/* Matching: compiled patterns, sets of them and rule sets against the plain ones; whole worlds of changing
 * subscriptions, bodies, groups and rules against a comparison of all with all; cut into slices, saved and restored in
 * the middle of one; and what 100,000 subscriptions cost. */
#include "base/bytes.h"
#include "plain_filter.h"
#include "scene.h"
#include "world/saved.h"
#include "world/state.h"

#include <stdio.h>
#include <stdlib.h>
#include <time.h>

/* ---- draws ---- */

static uint64_t seed = 0x2545f4914f6cdd1d;

static uint32_t below(uint32_t n)
{
    seed ^= seed << 13;
    seed ^= seed >> 7;
    seed ^= seed << 17;
    return (uint32_t)(seed >> 33) % n;
}

/* Few letters, so that pieces are found often, and found wrongly. */
static void draw_name(char *text, uint32_t most)
{
    uint32_t length = below(most + 1);
    for (uint32_t i = 0; i < length; i++) text[i] = (char)('a' + below(3));
    text[length] = '\0';
}

static void draw_pattern(char *text, uint32_t most)
{
    uint32_t length = below(most + 1), used = 0, stars = below(4), gaps = below(3);
    if (below(4) == 0) used = (uint32_t)sprintf(text, "group:");
    for (uint32_t i = 0; i < length; i++) {
        uint32_t what = below(10);
        text[used++] = what < stars ? '*' : what < stars + gaps ? '?' : (char)('a' + below(3));
    }
    text[used] = '\0';
}

/* ---- patterns ---- */

static bool ready_matches(const char *text, const char *name, const char *group)
{
    pattern p;
    pattern_init(&p, text);
    bool does = pattern_matches(&p, name, group);
    pattern_free(&p);
    return does;
}

static void check_pattern(const char *text, const char *name, const char *group)
{
    if (ready_matches(text, name, group) != filter_matches(text, name, group))
        fail_msg("\"%s\" against \"%s\" of group \"%s\"", text, name, group);
}

static void a_ready_pattern_matches_what_the_plain_one_does(void **state)
{
    (void)state;
    char text[160], name[160], group[160];
    size_t matched = 0;
    for (int i = 0; i < 300000; i++) {
        uint32_t most = i % 3 ? 8 : 127;
        draw_pattern(text, most);
        draw_name(name, most);
        draw_name(group, i % 2 ? 0 : 5);
        check_pattern(text, name, group);
        matched += filter_matches(text, name, group);
    }
    assert_true(matched > 10000);
}

/* Pieces on either side of what is tried at every place, and of a word of bits, with gaps and without. */
static void long_pieces_are_found_where_they_are(void **state)
{
    (void)state;
    char text[400], name[400];
    for (uint32_t length = 1; length <= 160; length++)
        for (int i = 0; i < 40; i++) {
            uint32_t before = below(40), behind = below(40), at = 0;
            for (uint32_t k = 0; k < before + length + behind; k++) name[k] = below(12) ? 'a' : 'b';
            name[before + length + behind] = '\0';
            text[at++] = '*';
            for (uint32_t k = 0; k < length; k++) text[at++] = i % 2 && below(6) == 0 ? '?' : name[before + k];
            if (i % 4 > 1) text[1 + below(length)] = 'b'; /* perhaps nowhere */
            text[at++] = '*';
            text[at] = '\0';
            check_pattern(text, name, "");
        }
}

static double thread_ms(void)
{
    struct timespec t;
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
    return 1e3 * (double)t.tv_sec + 1e-6 * (double)t.tv_nsec;
}

/* The plain one takes the product of the lengths for each of these: 3 s in all. */
static void hostile_patterns_end_soon(void **state)
{
    (void)state;
    static const char *const PIECES[] = {"aaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaab",
        "a?aaaaaaaaaaaaaaaaaaaaaaaaaa?aaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaab", "aaaaaab", "a*a*a*a*a*a*a*a*a*a*a*ab"};
    char name[128], text[128];
    memset(name, 'a', 127);
    name[127] = '\0';
    for (size_t i = 0; i < sizeof PIECES / sizeof *PIECES; i++) {
        snprintf(text, sizeof text, "*%s*", PIECES[i]);
        double before = thread_ms();
        pattern p;
        pattern_init(&p, text);
        for (int k = 0; k < 100000; k++)
            if (pattern_matches(&p, name, "")) fail();
        pattern_free(&p);
        assert_true(thread_ms() - before < 700); /* 7 us each; 0.1 to 1 in a release build */
    }
}

/* ---- sets ---- */

enum { SET_MOST = 200 };

static void check_set(const pattern_set *s, char (*texts)[160], const bool *in, const char *name, const char *group)
{
    pattern_ids found = {0};
    bool seen[SET_MOST] = {false};
    uint32_t least = PAIR_MAP_NONE;
    size_t tried = pattern_set_find(s, name, group, &found);
    for (size_t i = 0; i < found.count; i++) {
        assert_false(seen[found.at[i]]); /* once */
        seen[found.at[i]] = true;
    }
    for (uint32_t id = SET_MOST; id-- > 0;) {
        bool does = in[id] && filter_matches(texts[id], name, group);
        if (does != seen[id]) fail_msg("\"%s\" against \"%s\" of group \"%s\"", texts[id], name, group);
        if (does) least = id;
    }
    assert_int_equal(pattern_set_first(s, name, group), least);
    assert_true(tried <= pattern_set_price(s));
    array_free(&found);
}

static void a_set_finds_what_its_patterns_match(void **state)
{
    (void)state;
    static char texts[SET_MOST][160];
    char name[160], group[160];
    for (int few = 0; few < 2; few++) {
        pattern_set s;
        bool in[SET_MOST] = {false};
        pattern_set_init(&s, few);
        for (int round = 0; round < 20000; round++) {
            uint32_t id = below(SET_MOST);
            if (in[id]) {
                pattern_set_remove(&s, id);
            } else {
                draw_pattern(texts[id], round % 5 ? 6 : 127);
                pattern_set_add(&s, id, texts[id]);
            }
            in[id] = !in[id];
            if (round % 20) continue;
            draw_name(name, round % 3 ? 6 : 127);
            draw_name(group, 4);
            check_set(&s, texts, in, name, group);
        }
        pattern_set_free(&s);
    }
}

static void names_that_share_nothing_with_a_pattern_are_not_tried_against_it(void **state)
{
    (void)state;
    enum { MANY = 20000 };
    pattern_set s;
    pattern_ids found = {0};
    char text[64];
    pattern_set_init(&s, false);
    for (uint32_t i = 0; i < MANY; i++) {
        snprintf(text, sizeof text, i % 3 == 0 ? "cell%u/*" : i % 3 == 1 ? "*.tool%u" : "cell%u/arm", i);
        pattern_set_add(&s, i, text);
    }
    assert_true(pattern_set_find(&s, "cell300/arm.tool301", "", &found) <= 4);
    assert_int_equal(found.count, 2);
    assert_true(pattern_set_price(&s) < 30);
    array_free(&found);
    pattern_set_free(&s);
}

/* ---- rule sets ---- */

enum { RULES = 30, BODIES = 40 };

static void the_first_rule_is_that_of_the_plain_list(void **state)
{
    (void)state;
    static char texts[BODIES][RULES][160], names[BODIES][160], groups[BODIES][160];
    filter_rule rules[BODIES][RULES];
    size_t counts[BODIES] = {0};
    uint32_t sets[BODIES] = {0};
    uint64_t rulings[BODIES];
    rule_sets r;
    rules_init(&r);
    for (int i = 0; i < BODIES; i++) {
        draw_name(names[i], 6);
        draw_name(groups[i], 3);
        rulings[i] = (uint64_t)i + 1;
    }
    for (int round = 0; round < 3000; round++) {
        uint32_t at = below(BODIES), like = below(BODIES);
        counts[at] = below(3) ? below(RULES + 1) : counts[like]; /* the same list as another's, sometimes */
        for (size_t k = 0; k < counts[at]; k++) {
            if (counts[at] == counts[like] && at != like && round % 3 == 0)
                memcpy(texts[at][k], texts[like][k], sizeof texts[at][k]);
            else
                draw_pattern(texts[at][k], 5);
            rules[at][k] = (filter_rule){.pattern = texts[at][k]};
        }
        rules_choose(&r, &sets[at], rules[at], counts[at]);
        for (int i = 0; i < BODIES; i++) {
            const filter_rule *first = filter_first(rules[at], counts[at], names[i], groups[i]);
            uint32_t expected = first ? (uint32_t)(first - rules[at]) : (uint32_t)WORLD_NONE;
            assert_int_equal(rules_first(&r, sets[at], rulings[i], names[i], groups[i]), expected);
        }
    }
    for (int i = 0; i < BODIES; i++) rules_choose(&r, &sets[i], NULL, 0);
    assert_int_equal(r.ids.taken, 1); /* none is left */
    rules_free(&r);
}

static void bodies_with_the_same_rules_share_one_set(void **state)
{
    (void)state;
    world *w = scene_world(1, true);
    static const char *const TEXTS[] = {"b1*", "b2*", "*7", "group:x"};
    filter_rule rules[4];
    world_subscription all = scene_all(WORLD_TOUCH, 0);
    scene_subscription(w, &all);
    for (int i = 0; i < 4; i++) rules[i] = (filter_rule){.pattern = TEXTS[i], .allow = true, .reason = ""};
    world_shape ball = {.shape = {.type = SHAPE_SPHERE, .radius = 1}, .local = POSE_IDENTITY};
    for (int i = 0; i < 50; i++) {
        char name[16];
        snprintf(name, sizeof name, "b%d", i);
        world_body def = {.name = name,
            .group = "",
            .category = 1,
            .mask = 1,
            .pose = POSE_IDENTITY,
            .shapes = &ball,
            .shape_count = 1,
            .rules = rules,
            .rule_count = 4};
        uint32_t id = WORLD_NONE;
        assert_int_equal(world_put_body(w, &id, &def), WORLD_OK);
    }
    scene_tick(w, 1);
    assert_int_equal(w->rules.ids.taken, 2); /* and that of no rules */
    assert_int_equal(w->rules.answered, 50); /* names: not 1,225 pairs */
    assert_true(world_get_figures(w).contacts > 100);
    world_destroy(w);
}

/* ---- worlds ---- */

enum { ACTORS = 24, WISHES = 40 };

typedef struct actor {
    uint32_t id;
    char name[16], group[16], texts[3][24];
    filter_rule rules[3];
    size_t rule_count;
} actor;

typedef struct wish {
    uint32_t id;
    char a[24], b[24];
    bool snapshot; /* has come since its terms changed */
} wish;

typedef struct told { /* contacts that stand, as one who hears everything knows them */
    uint32_t subscription;
    char a[16], b[16];
} told;

typedef struct play {
    world *w, *copy; /* copy: restored from what w was saved as, now and then */
    actor actors[ACTORS];
    wish wishes[WISHES];
    ARRAY(told) standing;
    int64_t now;
    int names;
    size_t partly; /* ticks with something undone */
} play;

static size_t find_standing(const play *p, uint32_t subscription, const char *a, const char *b)
{
    for (size_t i = 0; i < p->standing.count; i++) {
        const told *t = &p->standing.at[i];
        bool same = (strcmp(t->a, a) == 0 && strcmp(t->b, b) == 0) || (strcmp(t->a, b) == 0 && strcmp(t->b, a) == 0);
        if (t->subscription == subscription && same) return i;
    }
    return SIZE_MAX;
}

static void hear(play *p, uint32_t subscription, const world_event *e)
{
    size_t at = find_standing(p, subscription, e->name_a, e->name_b);
    if (e->kind == EVENT_BEGIN) {
        told t = {.subscription = subscription};
        assert_int_equal(at, SIZE_MAX);
        snprintf(t.a, sizeof t.a, "%s", e->name_a);
        snprintf(t.b, sizeof t.b, "%s", e->name_b);
        array_push(&p->standing, t);
    } else if (e->kind == EVENT_END) {
        assert_int_not_equal(at, SIZE_MAX);
        p->standing.at[at] = p->standing.at[--p->standing.count];
    }
}

/* A snapshot says what stands, once all has been matched. */
static void hear_snapshot(play *p, const world_batch *b)
{
    size_t standing = 0, begun = 0;
    assert_int_equal(b->undone, 0);
    for (size_t i = 0; i < p->standing.count; i++) standing += p->standing.at[i].subscription == b->subscription;
    for (size_t i = 0; i < b->count; i++) {
        begun += b->events[i].kind == EVENT_BEGIN;
        assert_int_not_equal(find_standing(p, b->subscription, b->events[i].name_a, b->events[i].name_b), SIZE_MAX);
    }
    assert_int_equal(begun, standing);
    for (int i = 0; i < WISHES; i++)
        if (p->wishes[i].id == b->subscription) p->wishes[i].snapshot = true;
}

static void tick(play *p)
{
    world_batches out, same;
    bool undone = false;
    world_tick(p->w, ++p->now, &out);
    for (size_t i = 0; i < out.count; i++) {
        undone |= out.at[i].undone > 0;
        for (size_t k = 0; !out.at[i].snapshot && k < out.at[i].count; k++)
            hear(p, out.at[i].subscription, &out.at[i].events[k]);
        if (out.at[i].snapshot) hear_snapshot(p, &out.at[i]);
    }
    p->partly += undone;
    if (world_validate(p->w)) fail_msg("%s", world_validate(p->w));
    if (!p->copy) return;
    world_tick(p->copy, p->now, &same);
    assert_int_equal(same.count, out.count);
    assert_true(same.hash == out.hash);
    for (size_t i = 0; i < out.count; i++) {
        assert_int_equal(same.at[i].undone, out.at[i].undone);
        assert_int_equal(same.at[i].snapshot, out.at[i].snapshot);
    }
}

static bool plainly_checked(const actor *a, const actor *b)
{
    const filter_rule *ra = filter_first(a->rules, a->rule_count, b->name, b->group);
    const filter_rule *rb = filter_first(b->rules, b->rule_count, a->name, a->group);
    return (ra && !ra->allow) || (rb && !rb->allow) || (!ra && !rb);
}

static bool plainly_wanted(const wish *i, const actor *a, const actor *b)
{
    return (filter_matches(i->a, a->name, a->group) && filter_matches(i->b, b->name, b->group)) ||
           (filter_matches(i->a, b->name, b->group) && filter_matches(i->b, a->name, a->group));
}

/* All bodies touch each other: what stands is what is wanted and checked. */
static void check_against_all_with_all(play *p)
{
    size_t expected = 0;
    for (int i = 0; i < WISHES; i++) {
        const wish *x = &p->wishes[i];
        if (x->id == WORLD_NONE) continue;
        assert_true(x->snapshot);
        for (int a = 0; a < ACTORS; a++)
            for (int b = a + 1; b < ACTORS; b++) {
                const actor *y = &p->actors[a], *z = &p->actors[b];
                if (y->id == WORLD_NONE || z->id == WORLD_NONE) continue;
                bool should = plainly_wanted(x, y, z) && plainly_checked(y, z);
                if (should != (find_standing(p, x->id, y->name, z->name) != SIZE_MAX))
                    fail_msg("%s and %s for \"%s\" against \"%s\": %s", y->name, z->name, x->a, x->b,
                        should ? "is missing" : "is told");
                expected += should;
            }
    }
    assert_int_equal(p->standing.count, expected);
}

static void put_actor(play *p, actor *a)
{
    world_shape ball = {.shape = {.type = SHAPE_SPHERE, .radius = 10}, .local = POSE_IDENTITY};
    world_body def = {.name = a->name,
        .group = a->group,
        .category = 1,
        .mask = 1,
        .pose = {{0.01 * (double)(a - p->actors), 0, 0}, {1, 0, 0, 0}},
        .shapes = &ball,
        .shape_count = 1,
        .rules = a->rules,
        .rule_count = a->rule_count};
    for (size_t i = 0; i < a->rule_count; i++) {
        a->rules[i].pattern = a->texts[i];
        a->rules[i].reason = "";
    }
    uint32_t same = a->id;
    assert_int_equal(world_put_body(p->w, &a->id, &def), WORLD_OK);
    if (p->copy) assert_int_equal(world_put_body(p->copy, &same, &def), WORLD_OK);
    if (p->copy) assert_int_equal(same, a->id);
}

static void change_actor(play *p)
{
    actor *a = &p->actors[below(ACTORS)];
    if (a->id != WORLD_NONE && below(3) == 0) {
        world_remove_body(p->w, a->id, CAUSE_REMOVED);
        if (p->copy) world_remove_body(p->copy, a->id, CAUSE_REMOVED);
        a->id = WORLD_NONE;
        return;
    }
    if (a->id == WORLD_NONE) { /* ids make names unique, letters make them match */
        draw_name(a->name, 3);
        snprintf(a->name + strlen(a->name), 12, "%d", p->names++);
    }
    if (below(2)) draw_name(a->group, 2);
    if (below(3) == 0) {
        a->rule_count = below(4);
        for (size_t i = 0; i < a->rule_count; i++) {
            draw_pattern(a->texts[i], 4);
            a->rules[i].allow = below(2);
        }
    }
    put_actor(p, a);
}

static void change_wish(play *p)
{
    wish *i = &p->wishes[below(WISHES)];
    if (i->id != WORLD_NONE && below(3) == 0) {
        world_remove_subscription(p->w, i->id, CAUSE_SUBSCRIPTION);
        if (p->copy) world_remove_subscription(p->copy, i->id, CAUSE_SUBSCRIPTION);
        i->id = WORLD_NONE;
        return;
    }
    draw_pattern(i->a, 4);
    if (below(3))
        snprintf(i->b, sizeof i->b, "%s", below(2) ? "*" : p->wishes[below(WISHES)].a);
    else
        draw_pattern(i->b, 4);
    world_subscription def = {.facts = WORLD_TOUCH,
        .select_a = i->a,
        .select_b = i->b,
        .threshold = below(2) ? 0 : 0.5,
        .tolerance = below(2) ? 1e-6 : 0,
        .relative_tolerance = 1e-4};
    uint32_t same = i->id;
    assert_int_equal(world_put_subscription(p->w, &i->id, &def), WORLD_OK);
    if (p->copy) assert_int_equal(world_put_subscription(p->copy, &same, &def), WORLD_OK);
    if (p->copy) assert_int_equal(same, i->id);
    i->snapshot = false;
}

static void copy_world(play *p)
{
    static const world_lender NOBODY = {0};
    bytes_out saved = {0};
    world_save(p->w, &NOBODY, &saved);
    if (p->copy) world_destroy(p->copy);
    p->copy = scene_world(1, true);
    bytes_in from = {.at = saved.at, .left = saved.count};
    const char *wrong = world_restore(p->copy, &NOBODY, &from);
    if (wrong) fail_msg("%s", wrong);
    p->copy->match.steps_a_tick = p->w->match.steps_a_tick;
    array_free(&saved);
}

static size_t run_play(size_t steps_a_tick)
{
    play p = {.w = scene_world(1, true)};
    p.w->match.steps_a_tick = steps_a_tick;
    for (int i = 0; i < ACTORS; i++) p.actors[i].id = WORLD_NONE;
    for (int i = 0; i < WISHES; i++) p.wishes[i].id = WORLD_NONE;
    for (int round = 0; round < 600; round++) {
        for (uint32_t k = below(4); k > 0; k--) change_actor(&p);
        for (uint32_t k = below(4); k > 0; k--) change_wish(&p);
        if (round % 50 == 40) p.w->match.tried = 1000000; /* as if many patterns had been tried */
        if (round % 50 == 40 && p.copy) p.copy->match.tried = 1000000;
        tick(&p);
        if (round % 7 == 0) copy_world(&p);
        if (round % 3) continue;
        for (int k = 0; world_changed(p.w); k++) {
            assert_true(k < 1000);
            tick(&p);
        }
        check_against_all_with_all(&p);
    }
    assert_int_equal(p.w->match.unmatched.count, 0);
    world_destroy(p.w);
    world_destroy(p.copy);
    array_free(&p.standing);
    return p.partly;
}

static void what_is_told_is_what_is_wanted_of_all_with_all(void **state)
{
    (void)state;
    run_play(MATCH_STEPS_A_TICK);
}

static void cut_into_slices_it_is_the_same_in_the_end_and_says_so_until_then(void **state)
{
    (void)state;
    assert_true(run_play(100) > 100);
    assert_true(run_play(1) > 200); /* a body a tick */
}

/* ---- many ---- */

static uint32_t want(world *w, const char *a, const char *b)
{
    world_subscription def = {.facts = WORLD_TOUCH, .select_a = a, .select_b = b, .tolerance = 1e-6};
    return scene_subscription(w, &def);
}

static double longest_ms;

static size_t settle(world *w, int64_t *now)
{
    size_t events = 0;
    longest_ms = 0;
    do {
        world_batches out;
        double before = thread_ms(), took;
        world_tick(w, ++*now, &out);
        took = thread_ms() - before;
        longest_ms = took > longest_ms ? took : longest_ms;
        for (size_t i = 0; i < out.count; i++) events += out.at[i].count;
    } while (world_changed(w));
    return events;
}

/* Of 1,000 clients, each with links that touch each other and subscriptions in its own. */
static void a_hundred_thousand_subscriptions_cost_what_they_match(void **state)
{
    (void)state;
    enum { CLIENTS = 1000, LINKS = 3, EACH = 100 };
    world *w = scene_world(1, true);
    int64_t now = 0;
    char a[32], b[32];
    for (int c = 0; c < CLIENTS; c++)
        for (int k = 0; k < LINKS; k++) {
            snprintf(a, sizeof a, "c%d/%d", c, k);
            scene_sphere(w, a, 10.0 * c + k, 0.6);
        }
    for (int i = 0; i < CLIENTS * EACH; i++) {
        snprintf(a, sizeof a, "c%d/*", i % CLIENTS);
        snprintf(b, sizeof b, i / CLIENTS % 2 ? "*" : "c%d/%d", i % CLIENTS, i / CLIENTS % LINKS);
        want(w, a, b);
    }
    /* Two pairs touch at each client; each of its subscriptions with "*" is told of both, the others of those with
     * theirs.
     */
    size_t of_one = 0;
    for (int i = 0; i < EACH; i++) of_one += i % 2 ? 2 : i % LINKS == 1 ? 2 : 1;
    size_t begun = settle(w, &now);
    assert_int_equal(begun, 2 * CLIENTS * of_one); /* as begins, and in snapshots */
    settle(w, &now);
    assert_int_equal(w->lively.count, 0); /* a tick walks none of them */
    assert_true(w->match.lists.count < 4 * CLIENTS);
    scene_move(w, world_find_body(w, "c77/0"), 770.1, 0);
    settle(w, &now);
    assert_true(w->lively.count <= EACH); /* those of its client alone */
    for (uint32_t i = 0; i < CLIENTS * EACH; i++) world_remove_subscription(w, i, CAUSE_SUBSCRIPTION);
    assert_int_equal(settle(w, &now), CLIENTS * of_one); /* each has its end */
    settle(w, &now);
    assert_int_equal(w->match.selectors.count - w->match.selector_ids.taken, w->match.selectors.count); /* all gone */
    assert_int_equal(world_get_figures(w).subscriptions, 0);
    assert_null(world_validate(w));
    world_destroy(w);
}

/* It took 9 s in one tick. */
static void wildcards_over_many_bodies_hold_no_tick(void **state)
{
    (void)state;
    enum { MANY = 5000, SUBSCRIPTIONS = 400 };
    world *w = scene_world(1, true);
    int64_t now = 0;
    char text[128];
    memset(text, 'a', sizeof text);
    for (int i = 0; i < MANY; i++) {
        snprintf(text + 110, 17, "%d", i);
        scene_sphere(w, text, 3.0 * i, 1);
    }
    settle(w, &now);
    for (int i = 0; i < SUBSCRIPTIONS; i++) {
        memset(text, 'a', 60);
        text[0] = '*';
        snprintf(text + 50, 60, "ab*%d*", i);
        want(w, text, "*");
    }
    settle(w, &now);
    assert_true(longest_ms < 250); /* 5 in a release build */
    double before = thread_ms();
    scene_sphere(w, "one more", -10, 1);
    assert_true(thread_ms() - before < 50);
    world_destroy(w);
}

/* Bodies that are put where thousands of patterns have to be tried wait, and all are told that something is undone. */
static void bodies_that_many_patterns_are_tried_against_wait(void **state)
{
    (void)state;
    enum { PATTERNS = 2000, PUT = 100 };
    world *w = scene_world(1, true);
    int64_t now = 0;
    char text[64];
    for (int i = 0; i < PATTERNS; i++) {
        snprintf(text, sizeof text, "*x%d*", i);
        want(w, text, "*");
    }
    uint32_t all = want(w, "*", "*");
    settle(w, &now);
    for (int i = 0; i < PUT; i++) {
        snprintf(text, sizeof text, "b%d", i);
        scene_sphere(w, text, i, 0.6);
    }
    size_t waiting = w->match.unmatched.count;
    assert_true(waiting > PUT / 2 && waiting < PUT);
    size_t begun = 0;
    bool undone = false;
    w->match.steps_a_tick = 100000;
    for (int k = 0; k < 100 && world_changed(w); k++) {
        world_batches out;
        world_tick(w, ++now, &out);
        assert_true(world_changed(w) == (w->match.unmatched.count > 0));
        for (size_t i = 0; i < out.count; i++) {
            if (out.at[i].subscription != all) continue;
            undone |= out.at[i].undone > 0;
            begun += out.at[i].count;
        }
    }
    assert_true(undone);
    assert_int_equal(begun, PUT - 1);
    assert_int_equal(w->reported_in_common, 0);
    world_destroy(w);
}

/* ---- rules in slices ---- */

enum { RULED = 24, RULES_EACH = 1024 };

/* Hostile names and rules: each name is nearly matched by each pattern, and a third of the bodies allow some others. */
static void put_ruled(world *w, int i, int version)
{
    static char texts[RULES_EACH][128];
    static filter_rule rules[RULES_EACH];
    char name[128];
    memset(name, 'a', 110);
    snprintf(name + 100, 27, "%d_", i);
    for (int k = 0; k < RULES_EACH; k++) {
        memset(texts[k], 'a', 60);
        texts[k][0] = '*';
        if (k == RULES_EACH - 1 && i % 3 == 0)
            snprintf(texts[k] + 1, 60, "a%d_*", (i + version) % RULED);
        else
            snprintf(texts[k] + 50, 60, "ab?*%d.%d*", i, k);
        rules[k] = (filter_rule){.pattern = texts[k], .allow = true, .reason = ""};
    }
    world_shape ball = {.shape = {.type = SHAPE_SPHERE, .radius = 1}, .local = POSE_IDENTITY};
    world_body def = {.name = name,
        .group = "",
        .category = 1,
        .mask = 1,
        .pose = {{version ? 0 : 3.0 * i, 0, 0}, {1, 0, 0, 0}},
        .shapes = &ball,
        .shape_count = 1,
        .rules = rules,
        .rule_count = RULES_EACH};
    uint32_t id = version ? (uint32_t)i : (uint32_t)WORLD_NONE;
    assert_int_equal(world_put_body(w, &id, &def), WORLD_OK);
    assert_int_equal(id, i);
}

static world *restored(const world *w)
{
    static const world_lender NOBODY = {0};
    bytes_out saved = {0};
    world_save(w, &NOBODY, &saved);
    world *copy = scene_world(1, true);
    bytes_in from = {.at = saved.at, .left = saved.count};
    const char *wrong = world_restore(copy, &NOBODY, &from);
    if (wrong) fail_msg("%s", wrong);
    array_free(&saved);
    return copy;
}

/* 100 bodies with 1,024 rules each held a tick for 25 s. */
static void rules_are_held_against_names_in_slices(void **state)
{
    (void)state;
    enum { SLICE = 4000000 };
    size_t contacts[2] = {0}, ticks = 0;
    for (int sliced = 0; sliced < 2; sliced++) {
        world *w = scene_world(1, true), *copy = NULL;
        int64_t now = 0;
        if (sliced) world_set_slice(w, SLICE);
        want(w, "*", "*");
        for (int i = 0; i < RULED; i++) put_ruled(w, i, 0);
        settle(w, &now);
        for (int version = 1; version < 4; version++) {
            for (int i = 0; i < RULED; i++) put_ruled(w, i, version);
            bool undone = false;
            longest_ms = 0;
            for (ticks = 0; !ticks || world_changed(w); ticks++) {
                world_batches out, same;
                double before = thread_ms(), took;
                world_tick(w, ++now, &out);
                took = thread_ms() - before;
                longest_ms = took > longest_ms ? took : longest_ms;
                for (size_t i = 0; i < out.count; i++) undone |= out.at[i].undone > 0;
                if (copy) world_tick(copy, now, &same);
                if (copy) assert_true(same.hash == out.hash);
                assert_null(world_validate(w));
                if (sliced && ticks % 3 == 0) {
                    world_destroy(copy);
                    copy = restored(w);
                    world_set_slice(copy, SLICE);
                }
            }
            assert_int_equal(undone, sliced);
            assert_true(!sliced || (ticks > 10 && longest_ms < 150)); /* 4 in a release build */
            world_destroy(copy);
            copy = NULL;
            size_t found = world_get_figures(w).contacts;
            if (version == 3) contacts[sliced] = found;
        }
        world_destroy(w);
    }
    assert_int_equal(contacts[0], contacts[1]);
    assert_true(contacts[0] < RULED * (RULED - 1) / 2 && contacts[0] > RULED * (RULED - 1) / 4);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_ready_pattern_matches_what_the_plain_one_does),
        cmocka_unit_test(long_pieces_are_found_where_they_are),
        cmocka_unit_test(hostile_patterns_end_soon),
        cmocka_unit_test(a_set_finds_what_its_patterns_match),
        cmocka_unit_test(names_that_share_nothing_with_a_pattern_are_not_tried_against_it),
        cmocka_unit_test(the_first_rule_is_that_of_the_plain_list),
        cmocka_unit_test(bodies_with_the_same_rules_share_one_set),
        cmocka_unit_test(what_is_told_is_what_is_wanted_of_all_with_all),
        cmocka_unit_test(cut_into_slices_it_is_the_same_in_the_end_and_says_so_until_then),
        cmocka_unit_test(a_hundred_thousand_subscriptions_cost_what_they_match),
        cmocka_unit_test(wildcards_over_many_bodies_hold_no_tick),
        cmocka_unit_test(bodies_that_many_patterns_are_tried_against_wait),
        cmocka_unit_test(rules_are_held_against_names_in_slices),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
