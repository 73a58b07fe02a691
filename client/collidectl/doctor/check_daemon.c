/* check_daemon: is there one, of our wire, alone, and of our release? */
#include "commands.h"

#include <stdlib.h>
#include <string.h>

doctor_finding check_wire(doctor *d)
{
    char command[COMMAND_MAX];
    if (!d->ear) return finding_unknown("%s", d->deaf);
    const ear_stranger *s = &d->ear->strangers;
    if (!s->count && !d->daemon) return finding_unknown("no daemon");
    if (!s->count) return finding_ok("version %d, as ours", WIRE_VERSION);
    command_replace(d, command);
    return finding_mend(finding_problem("%s: it and this program are of different releases", s->what), "%s", command);
}

static const char *health_name(uint8_t health)
{
    static const char *const names[] = {"starting", "ready", "degraded", "stopping"};
    return health < 4 ? names[health] : "of unknown health";
}

doctor_finding check_daemon(doctor *d)
{
    char command[COMMAND_MAX];
    const char *cyclone = getenv("CYCLONEDDS_URI");
    if (d->daemon)
        return finding_ok("%s, release %s, %s, by %s", d->daemon->name, d->daemon->release,
            health_name(d->daemon->health), d->daemon->links);
    if (*d->elsewhere) return finding_unknown("not on %s, but elsewhere: %s", d->options.uri, d->elsewhere);
    if (d->stranger) return finding_unknown("one that does not speak our wire");
    if (!d->opened && !d->over_lcm && cyclone && *cyclone)
        return finding_mend(
            finding_problem("%s, and CYCLONEDDS_URI is \"%.200s\"", d->deaf, cyclone), "unset CYCLONEDDS_URI");
    command_start(d, command);
    if (!d->opened) return finding_mend(finding_problem("none can be heard: %s", d->deaf), "%s", command);
    return finding_mend(
        finding_problem("none was heard on %s within %g s", d->options.uri, d->options.timeout_s), "%s", command);
}

/* A hot standby publishes nothing, so it is not among those that are heard; any two that are, are of equal strength. */
doctor_finding check_single(doctor *d)
{
    const ear_daemon *other = NULL;
    size_t count = 0;
    char command[COMMAND_MAX];
    for (size_t i = 0; i < d->ear->daemon_count; i++) {
        const ear_daemon *e = &d->ear->daemons[i];
        if (e->health == WIRE_HEALTH_STOPPING) continue;
        count++;
        if (e != d->daemon) other = e;
    }
    const char *standby = strstr(d->daemon->links, "hot standby: ");
    if (!other && standby) return finding_ok("it is active, with a %s", standby);
    if (!other) return finding_ok("it is alone");
    command_end(other, command);
    return finding_mend(
        finding_problem("%zu daemons of equal strength: clients follow %s, which started last; %s computes and "
                        "publishes the same once more",
            count + d->ear->daemons_passed_over, d->daemon->name, other->name),
        "%s", command);
}

doctor_finding check_release(doctor *d)
{
    char command[COMMAND_MAX];
    if (strcmp(d->daemon->release, d->options.release) == 0) return finding_ok("%s, as ours", d->daemon->release);
    command_restart(d, d->daemon, NULL, 0, command);
    return finding_mend(finding_problem("the daemon is of release %s, this program of %s: was it started before an "
                                        "upgrade?",
                            d->daemon->release, d->options.release),
        "%s", command);
}
