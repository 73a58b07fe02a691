/* check_health: what the daemon says of itself in its Status: health, limits, its gateway, and what it drops. */
#include "commands.h"

#include <stdio.h>
#include <string.h>

#define GROWTH_S 2.5 /* within which a second Status should come, by default at 1 Hz */

/* ---- limits ---- */

static const struct {
    const char *option, *counter;
} limits[] = {{"max_clients", "clients"}, {"max_bodies", "bodies"}, {"max_shapes", "shapes"}, {"max_pairs", "pairs"},
    {"max_subscriptions", "subscriptions"}, {"max_geometries", "geometries"}, {"max_soft_vertices", "soft_vertices"}};

enum { CERTIFICATE_DAYS_WARNED = 30 };

/* Clients of the library join one by one over DDS on loopback. */
static bool crowd_waits(doctor *d, const ear_daemon *e, doctor_finding *out)
{
    enum { CROWD = 64 };
    const ear_counter *waiting = ear_counter_of(e, "dds_turns_waiting"),
                      *gone = ear_counter_of(e, "dds_turns_given_up");
    char command[COMMAND_MAX];
    if (!waiting || !gone || (waiting->last < CROWD && gone->last <= gone->first)) return false;
    command_ctl(d, "status --wait 60", command);
    *out =
        finding_mend(finding_problem("%lld clients wait for their turn to join over DDS (dds_turns_waiting), and %lld "
                                     "have left before they had it (dds_turns_given_up)",
                         (long long)waiting->last, (long long)gone->last),
            "%s   # they come in one by one: start fewer at once, or give them more time (connect_timeout_s)", command);
    return true;
}

doctor_finding check_health(doctor *d)
{
    doctor_finding crowd;
    const ear_daemon *e = d->daemon;
    char command[COMMAND_MAX];
    if (ear_value(e, "suspects") > 0)
        return finding_mend(finding_problem("%s", e->limits),
            "journalctl -u collided -g 'was killed'   # mend what that client sends, or end it");
    const ear_counter *days = ear_counter_of(e, "certificate_days");
    if (e->health == WIRE_HEALTH_READY && days && days->last < CERTIFICATE_DAYS_WARNED)
        return finding_mend(finding_problem("a certificate of the daemon expires in %lld days", (long long)days->last),
            "make_site --renew SITE   # then copy SITE/daemon to the daemon's machine, and restart it");
    if (e->health == WIRE_HEALTH_READY && crowd_waits(d, e, &crowd)) return crowd;
    if (e->health == WIRE_HEALTH_READY) return finding_ok("ready, no limit was reached lately");
    if (e->health != WIRE_HEALTH_DEGRADED) {
        command_ctl(d, "status --wait 30", command);
        return finding_mend(finding_problem("the daemon is starting"), "%s", command);
    }
    if (ear_value(e, "streams_starving") > 0) {
        command_ctl(d, "top", command);
        return finding_mend(finding_problem("degraded: %s", e->limits),
            "%s   # that client polls too rarely: let it poll more often, or ask for less (facts, select, rate_hz)",
            command);
    }
    if (ear_value(e, "clients_unheard") > 0) {
        command_ctl(d, "status", command);
        return finding_mend(finding_problem("degraded: %s", e->limits),
            "%s   # in an open domain anybody can forge packets in its name: close the site (make_site), or find who "
            "sends",
            command);
    }
    doctor_finding f = finding_problem("degraded, limits were reached: %s", e->limits);
    if (strstr(e->limits, "memory_limit")) {
        command_restart(d, e, "memory_limit", 2 * (long)(ear_value(e, "memory_limit_bytes") / (1 << 20)), command);
        return finding_mend(f, "%s   # if this machine has so much; collidectl top tells who has what", command);
    }
    for (size_t i = 0; i < sizeof limits / sizeof *limits; i++) {
        if (!strstr(e->limits, limits[i].option)) continue;
        command_restart(d, e, limits[i].option, 2 * (long)ear_value(e, limits[i].counter) + 1, command);
        return finding_mend(f, "%s", command);
    }
    command_restart(d, e, NULL, 0, command);
    return finding_mend(f, "%s", command);
}

/* ---- the LCM gateway ---- */

doctor_finding check_gateway(doctor *d)
{
    const ear_daemon *e = d->daemon;
    const ear_counter *restarts = ear_counter_of(e, "lcm_gateway_restarts");
    char command[COMMAND_MAX];
    if (!strstr(e->links, "LCM ")) return finding_ok("not needed: the daemon has no LCM link");
    bool down = strstr(e->links, "the gateway is not running") != NULL;
    bool unsteady = restarts && restarts->last > restarts->first;
    long count = restarts ? (long)restarts->last : 0;
    if (!down && !unsteady) return finding_ok("collided-lcm runs; restarts since the start: %ld", count);
    doctor_finding f = down ? finding_problem("collided-lcm does not run; restarts since the start: %ld", count)
                            : finding_problem("collided-lcm does not stay up: %ld restarts, %ld of them just now",
                                  count, (long)(restarts->last - restarts->first));
    doctor_finding network = check_multicast(d);
    if (network.verdict != DOCTOR_PROBLEM) network = check_route(d);
    command_restart(d, e, NULL, 0, command);
    return finding_mend(f, "%s", network.verdict == DOCTOR_PROBLEM ? network.mend : command);
}

/* ---- what is dropped ---- */

static const struct {
    const char *prefix, *mend;
} losses[] = {
    {"reject_", "journalctl -u collided -n 50   # names the client and the field: mend that program"},
    {"late_poses", "journalctl -u collided -n 50   # a client sends under old sequence numbers: mend that program"},
    {"dds_history_full", "collidectl status   # ticks take too long for this flow: see last_tick_ns, raise workers"},
    {"batches_skipped", "collidectl top   # who is behind polls too rarely for what it asks: see limits"},
    {"dds_refused", "journalctl -u collided -n 50   # names the client and the field: mend that program"},
    {"dds_write_failed", "journalctl -u collided -n 50"},
    {"lcm_refused", "journalctl -u collided -n 50   # names the client and the field: mend that program"},
    {"lcm_queue_full", "collidectl status   # ticks take too long for this flow: see last_tick_ns, raise workers"},
    {"lcm_out_dropped", "sysctl -w net.core.wmem_max=4194304"},
    {"record_failures", "df -h   # the disk, or a limit (record_max_size, record_keep_free), ended the recording"},
};
enum { LOSSES = sizeof losses / sizeof *losses };

static const char *mend_of(const char *counter)
{
    for (size_t i = 0; i < LOSSES; i++)
        if (strncmp(counter, losses[i].prefix, strlen(losses[i].prefix)) == 0) return losses[i].mend;
    return NULL;
}

/* Numbers since the start only tell that there was something: what still grows is to be mended. */
doctor_finding check_losses(doctor *d)
{
    const ear_daemon *e = d->daemon;
    char since[256] = "", now[256] = "";
    size_t since_at = 0, now_at = 0;
    const char *mend = NULL;
    unsigned before = e->statuses;
    if (before < 2) doctor_progress(d, "waiting for a second Status, to see what grows");
    for (double end = ear_now_s() + GROWTH_S; e->statuses < 2 && ear_now_s() < end;) ear_listen(d->ear, 0.05, 1);
    double seconds = 1e-9 * (double)(e->last_stamp_ns - e->first_stamp_ns);
    for (size_t i = 0; i < e->counter_count; i++) {
        const ear_counter *c = &e->counters[i];
        const char *its = mend_of(c->name);
        if (!its || c->last <= 0 || strcmp(c->name, "reject_limit") == 0) continue; /* the check of health has that */
        if (since_at < sizeof since)
            since_at +=
                (size_t)snprintf(since + since_at, sizeof since - since_at, " %s %lld", c->name, (long long)c->last);
        if (c->last <= c->first) continue;
        if (!mend) mend = its;
        if (now_at < sizeof now)
            now_at += (size_t)snprintf(
                now + now_at, sizeof now - now_at, " %s +%lld", c->name, (long long)(c->last - c->first));
    }
    if (!*since) return finding_ok("nothing was refused or dropped since the start");
    if (e->statuses < 2) return finding_unknown("since the start:%s; no second Status came, to see what grows", since);
    if (!mend) return finding_ok("nothing in %.1f s; since the start:%s", seconds, since);
    return finding_mend(
        finding_problem("in %.1f s:%s%s%s", seconds, now, *d->ear->reject ? "; the last: " : "", d->ear->reject), "%s",
        mend);
}
