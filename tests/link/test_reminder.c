/* Heartbeats that are sent while their writers are deleted: both end. */
#include "harness.h"
#include "link/link_dds_reminder.h"

#include "wire/dds/wire_dds.h"
#include "wire/dds/wire_dds_qos.h"

#include <unistd.h>

enum { DOMAIN = 3, WRITERS = REMINDER_MOST, ROUNDS = 20 };

static bool isolated;

typedef struct stage {
    dds_entity_t participant, topic, writers[WRITERS];
    dds_qos_t *qos;
    reminder r;
} stage;

static int open_stage(void **state)
{
    static stage s;
    char config[4096];
    *state = &s;
    if (!isolated) return 0;
    if (!wire_dds_config(config, sizeof config, "", WIRE_DDS_ANYBODY) || dds_create_domain(DOMAIN, config) <= 0)
        return -1;
    s.participant = dds_create_participant(DOMAIN, NULL, NULL);
    s.topic = dds_create_topic(s.participant, wire_dds_descriptor(WIRE_ACK), "a", NULL, NULL);
    s.qos = wire_dds_qos(WIRE_ACK, WIRE_DDS_WRITER, NULL, 0);
    reminder_start(&s.r);
    return s.topic > 0 ? 0 : -1;
}

static int close_stage(void **state)
{
    stage *s = *state;
    if (!isolated) return 0;
    reminder_end(&s->r);
    dds_delete_qos(s->qos);
    return dds_delete(s->participant) == DDS_RETCODE_OK ? 0 : -1;
}

static unsigned left(stage *s, dds_entity_t *reminds)
{
    while (pthread_mutex_trylock(&s->r.lock) != 0) continue; /* who sleeps comes too late */
    unsigned count = s->r.count;
    *reminds = s->r.reminds;
    pthread_mutex_unlock(&s->r.lock);
    return count;
}

/* Each at the moment when it is reminded of. Where that makes Cyclone wait for ever, the alarm ends the test. */
static void writers_are_deleted_while_they_are_reminded_of(void **state)
{
    stage *s = *state;
    if (!isolated) skip();
    alarm(60);
    for (int round = 0; round < ROUNDS; round++) {
        dds_entity_t reminds;
        int deleted = 0;
        for (int i = 0; i < WRITERS; i++) s->writers[i] = dds_create_writer(s->participant, s->topic, s->qos, NULL);
        for (int i = 0; i < WRITERS; i++) reminder_put(&s->r, s->writers[i]);
        while (left(s, &reminds) || reminds) {
            if (!reminds) continue;
            reminder_forget(&s->r, reminds);
            if (dds_delete(reminds) == DDS_RETCODE_OK) deleted++;
        }
        for (int i = 0; i < WRITERS; i++) deleted += dds_delete(s->writers[i]) == DDS_RETCODE_OK;
        assert_int_equal(deleted, WRITERS);
    }
    alarm(0);
}

/* And the others are, and then no more. */
static void what_is_forgotten_is_not_reminded_of(void **state)
{
    stage *s = *state;
    dds_entity_t reminds;
    if (!isolated) skip();
    dds_entity_t one = dds_create_writer(s->participant, s->topic, s->qos, NULL);
    dds_entity_t other = dds_create_writer(s->participant, s->topic, s->qos, NULL);
    reminder_put(&s->r, one);
    reminder_put(&s->r, other);
    reminder_forget(&s->r, other);
    assert_true(left(s, &reminds) <= 1);
    int64_t end = clock_monotonic_ns() + (int64_t)(RIG_PATIENCE_S * 1e9);
    while (left(s, &reminds) && clock_monotonic_ns() < end) {
        assert_true(reminds != other);
        usleep(1000);
    }
    assert_int_equal(left(s, &reminds), 0);
}

int main(void)
{
    isolated = netns_enter();
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(writers_are_deleted_while_they_are_reminded_of),
        cmocka_unit_test(what_is_forgotten_is_not_reminded_of),
    };
    return cmocka_run_group_tests(tests, open_stage, close_stage);
}
