/* doctor: the table of checks, in the order in which they are run: first this host, then who can be heard, then the
 * daemon itself. What comes later may rest on what was found before. */
#include "checks.h"

#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

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

#define CALM_S 0.6 /* a second daemon, or one of another wire, is heard within that after the first */

const char *doctor_check_name(size_t i, const char **summary)
{
    if (i >= CHECKS) return NULL;
    *summary = checks[i].summary;
    return checks[i].name;
}

bool doctor_uses_lcm(const doctor *d)
{
    return d->over_lcm || !d->daemon || strstr(d->daemon->links, "LCM ");
}

void doctor_progress(const doctor *d, const char *format, ...)
{
    char text[256];
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(text, sizeof text, format, arguments);
    va_end(arguments);
    if (d->options.progress) d->options.progress(d->options.context, text);
}

ear *doctor_open_ear(const doctor *d, unsigned domain, const char *interface, char *why, size_t why_size)
{
    const ear_options options = {.domain = domain, .address = d->address, .interface = interface, .peer = ""};
    return ear_open_dds(&options, why, why_size);
}

static void listen_first(doctor *d)
{
    const ear_options lcm = {.address = d->address, .interface = d->options.interface, .peer = d->options.peer};
    d->ear = d->over_lcm ? ear_open_lcm(&lcm, d->deaf, sizeof d->deaf)
                         : doctor_open_ear(d, d->domain, d->options.interface, d->deaf, sizeof d->deaf);
    d->opened = d->ear != NULL;
    if (!d->ear) return;
    doctor_progress(d, "listening on %s, for up to %g s", d->options.uri, d->options.timeout_s);
    ear_listen(d->ear, d->options.timeout_s, CALM_S);
    d->daemon = ear_followed(d->ear);
    d->stranger = d->ear->strangers.count > 0;
}

static const char *text_or_empty(const char *text)
{
    return text ? text : "";
}

static bool set_up(doctor *d, const doctor_options *options)
{
    char *end;
    lcm_group group;
    d->options = *options;
    d->options.interface = text_or_empty(options->interface);
    d->options.peer = text_or_empty(options->peer);
    d->options.system_root = text_or_empty(options->system_root);
    d->address = "";
    if (!facts_find_interface(d->options.interface, &d->interface)) d->interface = (facts_interface){.name = ""};
    d->over_lcm = strncmp(options->uri, "lcm://", 6) == 0;
    if (d->over_lcm) {
        d->address = options->uri + 6;
        return facts_lcm_group(d->address, &group);
    }
    if (strncmp(options->uri, "dds://", 6) != 0) return false;
    d->domain = (unsigned)strtoul(options->uri + 6, &end, 10);
    return *end == '\0' && end != options->uri + 6 && options->uri[6] != '-' && d->domain < DDS_DOMAINS;
}

int doctor_run(const doctor_options *options)
{
    doctor d = {.over_lcm = false};
    int problems = 0;
    if (!set_up(&d, options)) return -1;
    listen_first(&d);
    for (size_t i = 0; i < CHECKS; i++) {
        bool possible = checks[i].needs == NOTHING || d.daemon;
        doctor_finding f = possible ? checks[i].run(&d) : finding_unknown("no daemon");
        problems += f.verdict == DOCTOR_PROBLEM;
        options->found(options->context, checks[i].name, &f);
    }
    ear_close(d.ear);
    return problems;
}
