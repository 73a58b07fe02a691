/* daemon_lcm: the counterpart over LCM. */
#include "daemon.h"
#include "wire/wire_lcm.h"

#include <lcm/lcm.h>
#include <stdlib.h>

typedef struct lcm_side {
    daemon_state *state;
    lcm_t *lcm;
    wire_memory *memory;
} lcm_side;

static void send_lcm(void *context, const wire_message *m)
{
    lcm_side *side = context;
    size_t size = wire_lcm_size(m);
    char channel[WIRE_CHANNEL_MAX];
    void *data = malloc(size);
    wire_lcm_channel(m, channel);
    if (wire_lcm_encode(m, data, size) == size) (void)lcm_publish(side->lcm, channel, data, (unsigned)size);
    free(data);
}

static void received(const lcm_recv_buf_t *buffer, const char *channel, void *context)
{
    (void)channel;
    lcm_side *side = context;
    wire_message m;
    wire_refusal why;
    wire_memory_reset(side->memory);
    if (wire_lcm_decode(buffer->data, buffer->data_size, side->memory, &m, &why) == WIRE_OK)
        daemon_react(side->state, &m, send_lcm, side);
    else
        atomic_fetch_add(&side->state->malformed, 1);
}

void *daemon_lcm(void *state)
{
    lcm_side side = {
        .state = state, .lcm = lcm_create("udpm://239.255.76.67:7667?ttl=0"), .memory = wire_memory_create()};
    wire_message status = daemon_status();
    if (side.lcm) {
        lcm_subscription_t *s = lcm_subscribe(side.lcm, "collided\\.in\\..*", received, &side);
        (void)lcm_subscription_set_queue_capacity(s, 1000);
        while (!atomic_load(&side.state->stop))
            if (lcm_handle_timeout(side.lcm, 50) == 0) send_lcm(&side, &status);
        lcm_destroy(side.lcm);
    }
    wire_memory_destroy(side.memory);
    return NULL;
}
