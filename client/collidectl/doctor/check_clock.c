/* check_clock: the daemon's wall clock against ours, as NTP does it: an answer is stamped between our question and its
 * coming, so that the offset lies within half of the round trip; the shortest of several bounds it best. */
#include "checks.h"

#include <math.h>
#include <time.h>
#include <unistd.h>

enum { ASKED = 8 };
#define ASK_S 0.5
#define SKEW_MAX_S 0.010 /* one period of poses at 100 Hz: beyond, ages and deadlines are off by a whole pose */

static int64_t wall_ns(void)
{
    struct timespec t;
    clock_gettime(CLOCK_REALTIME, &t);
    return (int64_t)t.tv_sec * 1000000000 + t.tv_nsec;
}

static void keep_stamp(void *context, const wire_answer *answer)
{
    *(int64_t *)context = answer->stamp_ns;
}

doctor_finding check_clock(doctor *d)
{
    int64_t best = INT64_MAX, offset = 0;
    for (int i = 0; i < ASKED; i++) {
        int64_t stamp = 0, sent = wall_ns();
        const wire_query nobody = {.kind = WIRE_QUERY_BODIES, .name_a = "nobody is called this", .most = 1};
        if (!ear_ask(d->ear, nobody, ASK_S, keep_stamp, &stamp)) continue;
        int64_t received = wall_ns(), round = received - sent;
        if (round < 0 || round >= best) continue;
        best = round;
        offset = stamp - (sent + round / 2);
    }
    if (best == INT64_MAX) return finding_unknown("the daemon answers no query within %g s", ASK_S);
    double apart = 1e-9 * (double)offset, unsure = 0.5e-9 * (double)best;
    if (fabs(apart) - unsure <= SKEW_MAX_S)
        return finding_ok("the daemon's clock is %+.3f ms from ours, to within %.3f ms", 1e3 * apart, 1e3 * unsure);
    bool chrony = access("/usr/bin/chronyc", X_OK) == 0;
    return finding_mend(
        finding_problem("the daemon's clock is %+.3f s from ours, to within %.3f s: ages of poses and deadlines are "
                        "wrong by that",
            apart, unsure),
        "%s", chrony ? "chronyc makestep" : "timedatectl set-ntp true");
}
