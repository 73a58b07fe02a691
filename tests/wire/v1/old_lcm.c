/* old_lcm: a client of LCM's calls and of what lcm-gen makes of the collided.lcm beside it. See old.h. */
#include "old.h"

#include "collided_Ack.h"
#include "collided_Answer.h"
#include "collided_Body.h"
#include "collided_Client.h"
#include "collided_EventBatch.h"
#include "collided_PoseBatch.h"
#include "collided_Query.h"
#include "collided_Reject.h"
#include "collided_Status.h"
#include "collided_Subscription.h"

#include <inttypes.h>
#include <lcm/lcm.h>

static lcm_t *lcm;

/* ---- hearing ---- */

static void on_ack(const lcm_recv_buf_t *b, const char *channel, const collided_Ack *m, void *context)
{
    (void)b, (void)channel, (void)context;
    heard.extensions += m->extensions_n > 0;
    for (int32_t i = 0; i < m->sequences_n; i++) take_ack(m->sequences[i]);
}

static void on_events(const lcm_recv_buf_t *b, const char *channel, const collided_EventBatch *m, void *context)
{
    (void)b, (void)channel, (void)context;
    heard.extensions += m->extensions_n > 0;
    for (int32_t i = 0; i < m->kinds_n; i++)
        take_event(m->kinds[i], COLLIDED_EVENTBATCH_EVENT_BEGIN, COLLIDED_EVENTBATCH_EVENT_END,
            COLLIDED_EVENTBATCH_EVENT_AVERTED);
}

static void on_answer(const lcm_recv_buf_t *b, const char *channel, const collided_Answer *m, void *context)
{
    (void)b, (void)channel, (void)context;
    if (m->sequence != SAY_QUERY || m->lo_n != 1) return;
    heard.answers++;
    heard.lo = m->lo[0];
    heard.hi = m->hi[0];
}

static void on_reject(const lcm_recv_buf_t *b, const char *channel, const collided_Reject *m, void *context)
{
    (void)b, (void)channel, (void)context;
    heard.rejects += m->sequence == SAY_BAD_BODY && m->reason == COLLIDED_REJECT_REASON_BAD_SIZE &&
                     m->kind == COLLIDED_REJECT_MESSAGE_BODY;
}

static void on_status(const lcm_recv_buf_t *b, const char *channel, const collided_Status *m, void *context)
{
    (void)b, (void)channel, (void)context;
    heard.statuses += m->version == COLLIDED_CLIENT_WIRE_VERSION && m->epoch != 0;
}

static void receive(void)
{
    while (lcm_handle_timeout(lcm, 5) > 0) {
    }
}

/* ---- saying ---- */

static void say_client(bool leaves)
{
    collided_Client m = {.version = COLLIDED_CLIENT_WIRE_VERSION,
        .client_id = OLD_CLIENT,
        .sequence = leaves ? next_sequence++ : SAY_CLIENT,
        .removed = leaves,
        .lease_ns = INT64_C(60000000000),
        .name = "old client"};
    collided_Client_publish(lcm, "collided.in.Client", &m);
}

static void say_body(int32_t id, int64_t sequence, const char *name, double x, double radius)
{
    double pose[7] = {x, 0, 0, 1, 0, 0, 0}, size[3] = {0}, in_body[7] = {0, 0, 0, 1, 0, 0, 0};
    uint8_t type = COLLIDED_BODY_SHAPE_SPHERE;
    int64_t geometry = 0;
    collided_Body m = {.version = COLLIDED_CLIENT_WIRE_VERSION,
        .client_id = OLD_CLIENT,
        .sequence = sequence,
        .body_id = id,
        .name = (char *)(uintptr_t)name,
        .group = "",
        .category = -1,
        .mask = -1,
        .pose_n = 7,
        .pose = pose,
        .shape_types_n = 1,
        .shape_types = &type,
        .shape_sizes_n = 3,
        .shape_sizes = size,
        .shape_radii_n = 1,
        .shape_radii = &radius,
        .shape_poses_n = 7,
        .shape_poses = in_body,
        .shape_geometries_n = 1,
        .shape_geometries = &geometry};
    collided_Body_publish(lcm, "collided.in.Body", &m);
}

static void say_subscription(void)
{
    collided_Subscription m = {.version = COLLIDED_CLIENT_WIRE_VERSION,
        .client_id = OLD_CLIENT,
        .sequence = SAY_SUBSCRIPTION,
        .subscription_id = OLD_SUBSCRIPTION,
        .facts = COLLIDED_SUBSCRIPTION_FACT_TOUCH,
        .stream = OLD_STREAM,
        .select_a = "old_a",
        .select_b = "old_b"};
    collided_Subscription_publish(lcm, "collided.in.Subscription", &m);
}

static void say_pose(double x)
{
    int32_t body = OLD_BODY_B;
    double at[3] = {x, 0, 0}, turn[4] = {1, 0, 0, 0};
    collided_PoseBatch m = {.version = COLLIDED_CLIENT_WIRE_VERSION,
        .client_id = OLD_CLIENT,
        .sequence = next_sequence++,
        .bodies_n = 1,
        .bodies = &body,
        .positions_n = 3,
        .positions = at,
        .orientations_n = 4,
        .orientations = turn};
    collided_PoseBatch_publish(lcm, "collided.in.PoseBatch", &m);
}

static void say_query(void)
{
    collided_Query m = {.version = COLLIDED_CLIENT_WIRE_VERSION,
        .client_id = OLD_CLIENT,
        .sequence = SAY_QUERY,
        .kind = COLLIDED_QUERY_QUERY_DISTANCE,
        .name_a = "old_a",
        .name_b = "old_b",
        .tolerance_m = 1e-9};
    collided_Query_publish(lcm, "collided.in.Query", &m);
}

int main(void)
{
    char channel[64];
    setvbuf(stdout, NULL, _IOLBF, 0);
    lcm = lcm_create("udpm://239.255.76.67:7667?ttl=0");
    if (!lcm) return 2;
    collided_Status_subscription_t *statuses = collided_Status_subscribe(lcm, "collided.out.Status", on_status, NULL);
    collided_EventBatch_subscription_t *events =
        collided_EventBatch_subscribe(lcm, "collided.out.EventBatch." OLD_STREAM, on_events, NULL);
    snprintf(channel, sizeof channel, "collided.out.Answer.%016" PRIx64, OLD_CLIENT);
    collided_Answer_subscription_t *answers = collided_Answer_subscribe(lcm, channel, on_answer, NULL);
    snprintf(channel, sizeof channel, "collided.out.Reject.%016" PRIx64, OLD_CLIENT);
    collided_Reject_subscription_t *rejects = collided_Reject_subscribe(lcm, channel, on_reject, NULL);
    snprintf(channel, sizeof channel, "collided.out.Ack.%016" PRIx64, OLD_CLIENT);
    collided_Ack_subscription_t *acks = collided_Ack_subscribe(lcm, channel, on_ack, NULL);
    UNTIL((void)0, heard.statuses);
    UNTIL(say_client(false), heard.acks[SAY_CLIENT]);
    UNTIL(say_body(OLD_BODY_A, SAY_BODY_A, "old_a", 0, 0.5), heard.acks[SAY_BODY_A]);
    UNTIL(say_body(OLD_BODY_B, SAY_BODY_B, "old_b", 3, 0.5), heard.acks[SAY_BODY_B]);
    UNTIL(say_subscription(), heard.acks[SAY_SUBSCRIPTION]);
    UNTIL(say_pose(0.9), heard.begins);
    UNTIL(say_query(), heard.answers);
    UNTIL(say_body(OLD_BAD_BODY, SAY_BAD_BODY, "old_bad", 9, -1), heard.rejects);
    UNTIL(say_pose(3), heard.ends);
    say_client(true);
    collided_Status_unsubscribe(lcm, statuses);
    collided_EventBatch_unsubscribe(lcm, events);
    collided_Answer_unsubscribe(lcm, answers);
    collided_Reject_unsubscribe(lcm, rejects);
    collided_Ack_unsubscribe(lcm, acks);
    lcm_destroy(lcm);
    return summary();
}
