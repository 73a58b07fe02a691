/* Which participant speaks for which client: claims, lives and deaths, as the DDS link tells them. */
#include "link/owners.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>

#include <cmocka.h>

enum { CLAIMS_MAX = 8000 };
enum { P = 100, Q = 200, CLIENT = 7, OTHER = 8 };
enum { P_CLIENT = 101, P_BODY = 102, Q_CLIENT = 201, Q_BODY = 202 };

static owners o;

static int open_owners(void **state)
{
    (void)state;
    owners_init(&o, CLAIMS_MAX);
    owners_come(&o, P_CLIENT, P, true);
    owners_come(&o, P_BODY, P, false);
    owners_come(&o, Q_CLIENT, Q, true);
    owners_come(&o, Q_BODY, Q, false);
    return 0;
}

static int close_owners(void **state)
{
    (void)state;
    owners_free(&o);
    return 0;
}

static void assert_lost(int64_t expected)
{
    int64_t client = 0;
    assert_true(owners_lost(&o, &client));
    assert_int_equal(client, expected);
    assert_false(owners_lost(&o, &client));
}

static void assert_none_lost(void)
{
    int64_t client;
    assert_false(owners_lost(&o, &client));
}

static void the_first_one_speaks_for_a_client(void **state)
{
    (void)state;
    assert_int_equal(owners_admit(&o, P_BODY, CLIENT, false), OWNERS_YES);
    assert_int_equal(owners_admit(&o, Q_BODY, CLIENT, false), OWNERS_NOT_YOURS);
    assert_int_equal(owners_admit(&o, Q_CLIENT, CLIENT, true), OWNERS_NOT_YOURS);
    assert_int_equal(owners_admit(&o, P_CLIENT, CLIENT, true), OWNERS_YES);
    assert_int_equal(owners_admit(&o, Q_CLIENT, OTHER, true), OWNERS_YES);
    assert_int_equal(owners_admit(&o, P_BODY, OTHER, false), OWNERS_NOT_YOURS);
    assert_none_lost();
}

static void whoever_is_gone_is_lost_and_replaced(void **state)
{
    (void)state;
    owners_admit(&o, P_CLIENT, CLIENT, true);
    owners_go(&o, P_CLIENT);
    assert_lost(CLIENT);
    assert_int_equal(owners_admit(&o, Q_BODY, CLIENT, false), OWNERS_YES);
    owners_go(&o, P_BODY);
    assert_none_lost();
    assert_false(owners_knows(&o, P_BODY));
}

static void without_a_sign_of_life_it_is_lost_and_may_come_back(void **state)
{
    (void)state;
    owners_admit(&o, P_CLIENT, CLIENT, true);
    owners_liveliness(&o, P_CLIENT, false);
    assert_lost(CLIENT);
    owners_liveliness(&o, P_CLIENT, true);
    assert_int_equal(owners_admit(&o, P_BODY, CLIENT, false), OWNERS_YES);
    assert_int_equal(owners_admit(&o, Q_BODY, CLIENT, false), OWNERS_NOT_YOURS);
    owners_liveliness(&o, P_CLIENT, false);
    owners_liveliness(&o, P_CLIENT, true); /* both before anybody looked */
    assert_none_lost();
}

static void a_stranger_cannot_hide_a_death(void **state)
{
    (void)state;
    owners_admit(&o, P_CLIENT, CLIENT, true);
    assert_int_equal(owners_admit(&o, Q_CLIENT, CLIENT, true), OWNERS_NOT_YOURS);
    owners_liveliness(&o, P_CLIENT, false);
    assert_lost(CLIENT);
}

static void who_left_in_order_is_not_lost(void **state)
{
    (void)state;
    owners_admit(&o, P_CLIENT, CLIENT, true);
    owners_admit(&o, P_CLIENT, OTHER, true);
    owners_release(&o, CLIENT);
    owners_go(&o, P_CLIENT);
    owners_go(&o, P_BODY);
    assert_lost(OTHER);
    assert_int_equal(owners_admit(&o, Q_BODY, CLIENT, false), OWNERS_YES);
}

static void one_that_announces_nothing_is_forgotten_quietly(void **state)
{
    (void)state;
    owners_go(&o, P_CLIENT);
    owners_come(&o, 301, 300, false);
    assert_int_equal(owners_admit(&o, 301, CLIENT, false), OWNERS_YES);
    assert_int_equal(owners_admit(&o, Q_BODY, CLIENT, false), OWNERS_NOT_YOURS);
    owners_go(&o, 301);
    assert_none_lost();
    assert_int_equal(owners_admit(&o, Q_BODY, CLIENT, false), OWNERS_YES);
}

static void an_unknown_writer_claims_nothing(void **state)
{
    (void)state;
    assert_int_equal(owners_admit(&o, 999, CLIENT, true), OWNERS_YES);
    assert_int_equal(owners_admit(&o, P_BODY, CLIENT, false), OWNERS_YES);
    assert_int_equal(owners_admit(&o, 999, CLIENT, false), OWNERS_NOT_YOURS);
}

static void many_come_and_go_and_leave_nothing(void **state)
{
    (void)state;
    enum { MANY = 1000 };
    for (uint64_t i = 0; i < MANY; i++) {
        owners_come(&o, 10000 + i, 20000 + i / 2, i % 2);
        assert_int_equal(owners_admit(&o, 10000 + i, (int64_t)(1 + i / 2), i % 2), OWNERS_YES);
    }
    for (uint64_t i = 0; i < MANY; i += 2)
        assert_int_equal(owners_admit(&o, Q_BODY, (int64_t)(1 + i / 2), false), OWNERS_NOT_YOURS);
    for (uint64_t i = 0; i < MANY; i++) owners_go(&o, 10000 + i * 7 % MANY);
    int64_t client;
    size_t lost = 0;
    while (owners_lost(&o, &client)) lost++;
    assert_int_equal(lost, MANY / 2);
    assert_int_equal(o.writers.count, 4);
    assert_int_equal(o.participants.count, 2);
    assert_int_equal(o.claims.count, 0);
    assert_int_equal(o.writer_of.count + o.participant_of.count + o.claim_of.count, 6);
}

/* Whoever names ever new clients is refused, and those that are there are heard; who leaves makes room. */
static void claims_are_bounded(void **state)
{
    (void)state;
    for (int i = 1; i <= CLAIMS_MAX; i++) assert_int_equal(owners_admit(&o, P_BODY, i, false), OWNERS_YES);
    assert_int_equal(owners_admit(&o, P_BODY, CLAIMS_MAX + 1, false), OWNERS_FULL);
    assert_int_equal(owners_admit(&o, Q_CLIENT, CLAIMS_MAX + 2, true), OWNERS_FULL);
    assert_int_equal(owners_admit(&o, P_CLIENT, CLAIMS_MAX, true), OWNERS_YES);
    assert_int_equal(owners_admit(&o, Q_CLIENT, CLAIMS_MAX, true), OWNERS_NOT_YOURS);
    assert_int_equal(o.claims.count, CLAIMS_MAX);
    owners_release(&o, 1);
    assert_int_equal(owners_admit(&o, Q_CLIENT, CLAIMS_MAX + 2, true), OWNERS_YES);
}

/* One participant has its share of the claims, whatever names it thinks of, and the rest stays free for others. */
static void one_participant_has_its_share(void **state)
{
    (void)state;
    o.each = CLAIMS_MAX - 2;
    for (int i = 1; i <= CLAIMS_MAX - 2; i++) assert_int_equal(owners_admit(&o, P_BODY, i, false), OWNERS_YES);
    assert_int_equal(owners_admit(&o, P_CLIENT, CLAIMS_MAX + 1, true), OWNERS_SHARE);
    assert_int_equal(owners_admit(&o, P_CLIENT, 1, true), OWNERS_YES);
    assert_int_equal(owners_admit(&o, Q_CLIENT, CLAIMS_MAX + 2, true), OWNERS_YES);
    owners_release(&o, 1);
    assert_int_equal(owners_admit(&o, P_CLIENT, CLAIMS_MAX + 1, true), OWNERS_YES);
    assert_int_equal(owners_admit(&o, P_CLIENT, CLAIMS_MAX + 3, true), OWNERS_SHARE);
    assert_int_equal(owners_participant_of(&o, P_BODY), owners_participant_of(&o, P_CLIENT));
    assert_int_equal(owners_participant_of(&o, 999), 0);
}

/* Half of them are lost at once, the first ones, and one that is left leaves while they are told. */
static void many_losses_are_told_once_each(void **state)
{
    (void)state;
    for (int i = 1; i <= CLAIMS_MAX; i++)
        assert_int_equal(owners_admit(&o, i <= CLAIMS_MAX / 2 ? P_CLIENT : Q_CLIENT, i, true), OWNERS_YES);
    owners_liveliness(&o, P_CLIENT, false);
    owners_liveliness(&o, P_CLIENT, true);
    assert_none_lost();
    owners_liveliness(&o, P_CLIENT, false);
    int64_t client;
    int lost = 0;
    while (owners_lost(&o, &client)) {
        assert_in_range(client, 1, CLAIMS_MAX / 2);
        if (lost++ == 7) owners_release(&o, CLAIMS_MAX); /* meanwhile */
    }
    assert_int_equal(lost, CLAIMS_MAX / 2);
    assert_int_equal(o.claims.count, CLAIMS_MAX / 2 - 1);
    assert_none_lost();
}

#define TEST(name) cmocka_unit_test_setup_teardown(name, open_owners, close_owners)

int main(void)
{
    const struct CMUnitTest tests[] = {
        TEST(the_first_one_speaks_for_a_client),
        TEST(whoever_is_gone_is_lost_and_replaced),
        TEST(without_a_sign_of_life_it_is_lost_and_may_come_back),
        TEST(a_stranger_cannot_hide_a_death),
        TEST(who_left_in_order_is_not_lost),
        TEST(one_that_announces_nothing_is_forgotten_quietly),
        TEST(an_unknown_writer_claims_nothing),
        TEST(many_come_and_go_and_leave_nothing),
        TEST(claims_are_bounded),
        TEST(one_participant_has_its_share),
        TEST(many_losses_are_told_once_each),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
