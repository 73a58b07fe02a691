/* ready: is the world whole? A daemon that was started again knows nothing: its clients hear of a new epoch, or its
 * readers are discovered, and what it had comes anew, in any order and from clients that it has never heard of. Nobody
 * knows how many there are; so the world counts as whole when nothing that it did not have has come for `settle`, no
 * command waits for a geometry, and none of them is there in part, or being built. Where announcements never end (a
 * simulation that makes bodies all the time) it counts as whole after ten times as long. Tick thread. */
#include "service.h"

#include "base/log.h"

#include <inttypes.h>
#include <stdio.h>

enum { AT_MOST = 10 }; /* times `settle` */

static int64_t settle_ns(const service *s)
{
    return (int64_t)(1e9 * s->config.settle);
}

static size_t parts_of_geometries(const service *s)
{
    size_t count = 0;
    for (size_t i = 0; i < s->geometries.count; i++)
        count += s->geometries.at[i].id && s->geometries.at[i].come < s->geometries.at[i].pieces;
    return count + s->geometries_building;
}

void ready_begin(service *s)
{
    s->began_ns = s->announced_ns = s->monotonic_ns;
    s->whole = settle_ns(s) == 0;
    snprintf(s->settling, sizeof s->settling, "starting: listens for what there was before");
}

void ready_announced(service *s)
{
    s->announced_ns = s->monotonic_ns;
}

static void report_of_settling(const service *s, bool gives_up)
{
    world_figures f = world_get_figures(s->world);
    double after = 1e-9 * (double)(s->monotonic_ns - s->began_ns);
    if (gives_up)
        log_warning("the world does not settle: taken for whole after %.1f s, with %zu bodies of %zu clients; %s",
            after, (size_t)f.bodies, s->sessions.count, s->settling);
    else
        log_notice(
            "the world is whole after %.1f s: %zu bodies of %zu clients", after, (size_t)f.bodies, s->sessions.count);
}

bool ready_check(service *s)
{
    if (s->whole || s->replaying) return s->whole;
    int64_t silent_ns = s->monotonic_ns - s->announced_ns;
    size_t parts = parts_of_geometries(s);
    bool waits = s->pending.count || parts;
    bool gives_up = s->monotonic_ns - s->began_ns >= AT_MOST * settle_ns(s);
    snprintf(s->settling, sizeof s->settling,
        "starting: %zu clients are here; last announcement %.1f s ago, %zu commands wait, %zu geometries in part",
        s->sessions.count, 1e-9 * (double)silent_ns, s->pending.count, parts);
    s->whole = (silent_ns >= settle_ns(s) && !waits) || gives_up;
    if (s->whole) report_of_settling(s, gives_up && (waits || silent_ns < settle_ns(s)));
    return s->whole;
}

int64_t ready_next_ns(const service *s)
{
    if (s->whole) return INT64_MAX;
    int64_t settled = s->announced_ns + settle_ns(s), most = s->began_ns + AT_MOST * settle_ns(s);
    if (settled <= s->monotonic_ns) settled = s->monotonic_ns + 100000000; /* it waits for a geometry: not told when */
    return settled < most ? settled : most;
}
