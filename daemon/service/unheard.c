/* unheard: clients that are alive and publish, and of whom nothing arrives. In an open domain one forged packet (a
 * HEARTBEAT or GAP of RTPS) makes a reader believe that it has had what a writer is yet to send; over LCM whatever is
 * lost is lost. So each client says once a second, by a Receipt of no stream, which PoseBatch was its newest: if that
 * has not come a second later, or if a client that lives (DDS) has stopped saying so, it is unheard. That is counted,
 * logged and named in the health, and the client is told, again and again: the C library then writes anew.
 *
 * What a transport itself found to be lost (sample_lost of DDS, a full queue) makes the health degraded for five
 * seconds, and those whose it may be are told once, so that they write anew what a newer message does not replace.
 *
 * Tick thread. Nothing here enters the world: no event depends on it. */
#include "clients.h"
#include "commands.h"
#include "service.h"
#include "standby.h"

#include "base/log.h"

#include <inttypes.h>
#include <stdio.h>

#define SECOND_NS INT64_C(1000000000)

/* A client that is told makes its writers anew, and each of them is some ten packets: of a crowd that is not heard,
 * since the machine has no time for it, so many a second are told, in turns. All at once kept the machine without time.
 */
enum { REPORTS_EACH_S = 20 };
enum { UNDER_WAY_S = 1, SILENCE_LEAST_S = 3, SILENCE_MOST_S = 10, REPORT_FIRST_S = 1, REPORT_LAST_S = 16 };

void unheard_poses(service *s, const wire_pose_batch *m)
{
    session *c = session_find(s, m->client);
    if (c && m->sequence > c->hearing.newest) c->hearing.newest = m->sequence;
}

/* The first word of a client that we know tells what it published before we did; that is in its bodies. */
void unheard_word(service *s, const wire_receipt *m)
{
    session *c = session_find(s, m->client);
    if (!c) return;
    hearing *h = &c->hearing;
    if (!h->said_ns && m->batch > h->newest) h->newest = m->batch;
    h->said_ns = s->monotonic_ns;
    if (m->batch <= h->newest || h->said > h->newest) return; /* it has come, or an earlier one waits */
    h->said = m->batch;
    h->waits_ns = s->monotonic_ns;
}

/* Once for a series of losses. */
static void log_losses(service *s, wire_kind kind, int64_t client, size_t count)
{
    char of[32] = "";
    if (client) snprintf(of, sizeof of, " of client %016" PRIx64, (uint64_t)client);
    bool is_new = !*s->samples_lost;
    snprintf(s->samples_lost, sizeof s->samples_lost, "messages of kind %s%s were lost on their way to this daemon",
        wire_kind_name(kind), of);
    s->samples_lost_ns = s->monotonic_ns;
    if (!is_new) return;
    log_warning("%s (%zu or more)", s->samples_lost, count);
    s->status_due = true;
}

void unheard_lost(service *s, const struct link *from, wire_kind kind, int64_t client, size_t count)
{
    metric_count(s->count.messages_lost, count);
    if (s->replaying || standby_waits(s)) return;
    log_losses(s, kind, client, count);
    for (size_t i = 0; i < s->sessions.count; i++) {
        session *c = s->sessions.at[i];
        if (c->link != from || (client && c->client != client)) continue;
        c->hearing.lost_poses = kind == WIRE_POSE_BATCH && (!c->hearing.lost || c->hearing.lost_poses);
        c->hearing.lost = true;
    }
}

/* Has a transport lost something, but a short time ago? */
static void forget_losses(service *s)
{
    if (s->monotonic_ns - s->samples_lost_ns > LOSSES_REPORTED_NS) s->samples_lost[0] = '\0';
}

static bool lacks_poses(const service *s, const hearing *h)
{
    return h->said > h->newest && s->monotonic_ns - h->waits_ns > UNDER_WAY_S * SECOND_NS;
}

/* A process that stands still is lost when its lease is over; where that is long it is missed before, as it should. */
static bool is_silent(const service *s, const session *c)
{
    int64_t least = SILENCE_LEAST_S * SECOND_NS, most = SILENCE_MOST_S * SECOND_NS;
    int64_t patience = c->lease_ns < least ? least : c->lease_ns > most ? most : c->lease_ns;
    return c->link->ops->has_liveliness && c->hearing.said_ns && s->monotonic_ns - c->hearing.said_ns > patience;
}

/* May one more be told? Those that were not in the last second are made up for. */
static bool may_report(service *s)
{
    int64_t from_ns = s->monotonic_ns - SECOND_NS;
    if (s->unheard_report_ns > s->monotonic_ns) return false;
    if (s->unheard_report_ns > from_ns) from_ns = s->unheard_report_ns;
    s->unheard_report_ns = from_ns + SECOND_NS / REPORTS_EACH_S;
    return true;
}

/* True: it would have been told, were it its turn. */
static bool report_lost_messages(service *s, session *c)
{
    if (!may_report(s)) return true;
    wire_refusal why = {.reason = WIRE_UNHEARD};
    snprintf(why.text, sizeof why.text, "some of its messages may have been lost on their way");
    apply_reject(
        s, c->link, c->hearing.lost_poses ? WIRE_POSE_BATCH : WIRE_RECEIPT, c->client, c->hearing.said, -1, &why);
    c->hearing.lost = c->hearing.lost_poses = false;
    return false;
}

/* The same, of one of which nothing comes. */
static bool report_unheard(service *s, session *c, bool poses)
{
    hearing *h = &c->hearing;
    if (s->monotonic_ns < h->report_ns) return false;
    if (!may_report(s)) return true;
    if (!h->report_wait_s) metric_count(s->count.unheard, 1);
    h->report_wait_s = !h->report_wait_s                      ? REPORT_FIRST_S
                       : 2 * h->report_wait_s < REPORT_LAST_S ? 2 * h->report_wait_s
                                                              : REPORT_LAST_S;
    h->report_ns = s->monotonic_ns + h->report_wait_s * SECOND_NS;
    wire_refusal why = {.reason = WIRE_UNHEARD};
    snprintf(why.text, sizeof why.text, "%s",
        poses ? "its poses do not come: the network loses them, or somebody forges packets"
              : "it is alive, and nothing comes: somebody forges packets, or the network carries one way only");
    apply_reject(s, c->link, poses ? WIRE_POSE_BATCH : WIRE_RECEIPT, c->client, h->said, -1, &why);
    return false;
}

static void describe(service *s, const session *c)
{
    if (*s->unheard) return;
    snprintf(s->unheard, sizeof s->unheard,
        "client %016" PRIx64 " '%.100s' is alive, and what it publishes does not come", (uint64_t)c->client, c->name);
}

void unheard_watch(service *s)
{
    s->clients_unheard = 0;
    s->unheard[0] = '\0';
    forget_losses(s);
    if (s->replaying || standby_waits(s)) return;
    size_t count = s->sessions.count, first = s->unheard_first < count ? s->unheard_first : 0;
    bool turn_is_set = false;
    for (size_t i = 0; i < count; i++) {
        size_t at = (first + i) % count;
        session *c = s->sessions.at[at];
        bool here = !c->lost && !c->left, poses = here && lacks_poses(s, &c->hearing);
        if (poses || (here && is_silent(s, c))) {
            s->clients_unheard++;
            describe(s, c);
            if (report_unheard(s, c, poses) && !turn_is_set) s->unheard_first = at, turn_is_set = true;
        } else if (c->hearing.report_wait_s) {
            c->hearing.report_wait_s = 0;
            if (here) log_notice("client %016" PRIx64 " '%s' is heard again", (uint64_t)c->client, c->name);
        }
        bool waits = here && c->hearing.lost && report_lost_messages(s, c);
        if (waits && !turn_is_set) s->unheard_first = at, turn_is_set = true;
    }
}
