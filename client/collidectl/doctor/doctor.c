/* doctor: the table of checks, in the order in which they are run: first this host, then who can be heard, then the
 * daemon itself. What comes later may rest on what was found before. */
#include "doctor.h"

#include "checks.h"

typedef enum check_needs { NOTHING, A_DAEMON } check_needs;

static const struct {
    const char *name;
    check_needs needs;
    doctor_finding (*run)(doctor *d);
    const char *summary;
} checks[] = {
    {"interface", NOTHING, check_interface, "the network interface is there, up and has an address"},
    {"multicast", NOTHING, check_multicast, "LCM: the interface (loopback) does multicast"},
    {"route", NOTHING, check_route, "LCM: 224.0.0.0/4 leads to that interface"},
    {"buffers", NOTHING, check_buffers, "net.core.rmem_max grants the receive buffers that are asked for"},
    {"participants", NOTHING, check_participants, "DDS: room for more participants of the domain on this host"},
    {"wire", NOTHING, check_wire, "all daemons that are heard speak this version of the wire"},
    {"silence", NOTHING, check_silence, "DDS: participants that announce themselves also tell their endpoints"},
    {"peer", NOTHING, check_peer, "the host that --peer names is up, listens, and no firewall stands between"},
    {"interfaces", NOTHING, check_interfaces, "no daemon on another interface, when there is none here"},
    {"domain", NOTHING, check_domain, "no daemon in another DDS domain, when there is none here"},
    {"daemon", NOTHING, check_daemon, "a daemon is heard"},
    {"single", A_DAEMON, check_single, "only one daemon: two are of equal strength, and both answer"},
    {"release", A_DAEMON, check_release, "the daemon is of the release of this program"},
    {"health", A_DAEMON, check_health, "the daemon is ready, and none of its limits was reached"},
    {"gateway", A_DAEMON, check_gateway, "the daemon's LCM gateway runs, and stays up"},
    {"clock", A_DAEMON, check_clock, "the daemon's clock and ours differ by less than 10 ms"},
    {"lost", A_DAEMON, check_lost, "no bodies of clients whose lease ran out"},
    {"stale", A_DAEMON, check_stale, "no bodies whose poses are past their deadline"},
    {"losses", A_DAEMON, check_losses, "nothing is being refused or dropped"},
};
enum { CHECKS = sizeof checks / sizeof *checks };

const char *doctor_check_name(size_t i, const char **summary)
{
    if (i >= CHECKS) return NULL;
    *summary = checks[i].summary;
    return checks[i].name;
}

int doctor_run(const doctor_options *options)
{
    doctor d = {.over_lcm = false};
    int problems = 0;
    if (!doctor_begin(&d, options)) return -1;
    doctor_listen(&d);
    for (size_t i = 0; i < CHECKS; i++) {
        bool possible = checks[i].needs == NOTHING || d.daemon;
        doctor_finding f = possible ? checks[i].run(&d) : finding_unknown("no daemon");
        problems += f.verdict == DOCTOR_PROBLEM;
        options->found(options->context, checks[i].name, &f);
    }
    ear_close(d.ear);
    return problems;
}
