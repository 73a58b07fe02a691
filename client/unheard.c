/* unheard: what we publish does not arrive, although the daemon and we are alive: over LCM the last poses were lost, or
 * over DDS somebody has forged packets in our name, after which a reader takes all that our writer sends for old. We
 * tell the daemon once a second, in a crowd every other, what we published last; if it lacks that, it answers with a
 * Reject, `unheard`. Then we publish the newest poses again, by new writers, in whose name nothing has been forged yet.
 * The keeper's thread, with the lock held. */
#include "message.h"
#include "session.h"

enum {
    WORD_EACH_S = 1,
    WORD_OF_CROWD_S = 2,
    CROWD = 100 /* clients */,
    RENEW_FIRST_S = 1,
    RENEW_LAST_S = 16,
    FORGOTTEN_S = 60
};

/* A Receipt of no stream. */
static void say_what_was_published(collided *c)
{
    wire_message m = {
        .kind = WIRE_RECEIPT, .receipt = {.version = WIRE_VERSION, .client = c->id, .batch = c->newest_poses}};
    message_set_sequence(&m, ++c->sequence);
    (void)session_send(c, &m);
}

static bool has_a_say(const collided *c)
{
    bool may = !c->link->ops->permits || c->link->ops->permits(c->link, WIRE_RECEIPT);
    return may && c->client.state == ANNOUNCE_ACKED && !c->client.message->client.removed;
}

int64_t unheard_tend(collided *c, int64_t now_ns)
{
    if (c->poses_again && c->link->ops->ready(c->link)) {
        c->poses_again = false;
        poses_send_again(c);
    }
    if (!has_a_say(c)) return INT64_MAX;
    if (now_ns >= c->word_ns) {
        c->word_ns = now_ns + (c->crowd < CROWD ? WORD_EACH_S : WORD_OF_CROWD_S) * NS_PER_S;
        say_what_was_published(c);
    }
    return c->word_ns;
}

/* Who has one lost packet mended need not hear of it; who is not heard again and again does, and so does everybody over
 * a transport that loses nothing by itself. */
void unheard_reported(collided *c, const wire_reject *why)
{
    int64_t now = session_monotonic_ns();
    if (!c->unheard_ns || now - c->unheard_ns > FORGOTTEN_S * NS_PER_S) {
        c->renew_wait_s = 0;
        c->renew_ns = now;
    }
    c->counters.unheard++;
    if (c->renew_wait_s || !c->link->ops->repeats) session_keep_rejection(c, why);
    c->unheard_ns = now;
    if (now < c->renew_ns) return;
    c->renew_wait_s = !c->renew_wait_s                     ? RENEW_FIRST_S
                      : 2 * c->renew_wait_s < RENEW_LAST_S ? 2 * c->renew_wait_s
                                                           : RENEW_LAST_S;
    c->renew_ns = now + c->renew_wait_s * NS_PER_S;
    bool all = why->kind == WIRE_RECEIPT; /* nothing of ours comes: announcements do not, either */
    if (c->link->ops->renew) c->link->ops->renew(c->link, all);
    if (all) c->all_again_wanted = true;
    c->poses_again = true;
    c->counters.renewals++;
}
