/* check_elsewhere: when there is no daemon where we were told to look, it may be on another interface, in another
 * domain, or where CYCLONEDDS_URI does not lead. Each place is tried by listening there for a moment. */
#include "checks.h"
#include "probe.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { PORT_BASE = 7400, PORT_DOMAIN = 250, PORT_UNICAST = 10, TRIED_MAX = 16 };
#define TRY_S 1.5 /* for a daemon elsewhere: discovery on one host takes a tenth of it */
#define CALM_S 0.2
#define ANSWER_S 0.5 /* of participants to our announcement */

static bool hears_daemon(doctor *d, unsigned domain, const char *interface)
{
    char why[256];
    ear *e = doctor_open_ear(d, domain, interface, why, sizeof why);
    if (!e) return false;
    ear_listen(e, TRY_S, CALM_S);
    const ear_daemon *heard = ear_followed(e);
    if (heard) snprintf(d->elsewhere, sizeof d->elsewhere, "%s", heard->name);
    ear_close(e);
    return heard != NULL;
}

/* Participants hold their ports in pairs, the two of multicast (base, base + 1) or the two of their index (from base +
 * 10): a single one is of somebody else. */
static bool is_used(const facts_ports *ports, unsigned domain)
{
    unsigned base = PORT_BASE + PORT_DOMAIN * domain;
    bool used = facts_port_used(ports, base) && facts_port_used(ports, base + 1);
    for (unsigned p = base + PORT_UNICAST; p < base + PORT_DOMAIN && !used; p += 2)
        used = facts_port_used(ports, p) && facts_port_used(ports, p + 1);
    return used;
}

/* CYCLONEDDS_URI wins over what this program asks of DDS, and may lead it elsewhere. */
static bool heard_without_cyclone_uri(doctor *d)
{
    const char *said = getenv("CYCLONEDDS_URI");
    char *kept = said && *said ? strdup(said) : NULL;
    if (!kept) return false;
    doctor_progress(d, "listening without CYCLONEDDS_URI");
    unsetenv("CYCLONEDDS_URI"); /* DDS is closed: nobody else reads it now */
    bool heard = hears_daemon(d, d->domain, d->options.interface);
    setenv("CYCLONEDDS_URI", kept, 1);
    free(kept);
    return heard;
}

/* Tries the other interfaces; false: no daemon there, and `others` names them. */
static bool heard_on_another(doctor *d, char others[256], facts_interface *where)
{
    facts_interface all[FACTS_INTERFACES_MAX];
    size_t count = facts_interfaces(all), at = 0;
    others[0] = '\0';
    for (size_t i = 0; i < count && at < 256; i++) {
        const facts_interface *f = &all[i];
        bool usable = f->up && f->running && f->address.s_addr && strcmp(f->name, d->interface.name) != 0;
        if (!usable) continue;
        at += (size_t)snprintf(others + at, 256 - at, "%s%s", at ? ", " : "", f->name);
        if (d->daemon) continue;
        doctor_progress(d, "no daemon on %s; listening on %s", d->interface.name, f->name);
        if (!hears_daemon(d, d->domain, f->loopback ? "" : f->name)) continue;
        *where = *f;
        return true;
    }
    return false;
}

/* A process has a domain on one interface at a time: ours is given up for it. */
static bool give_up_ear(doctor *d)
{
    ear *given_up = d->ear;
    if (!given_up) return true;
    d->ear = NULL;
    snprintf(d->deaf, sizeof d->deaf, "no daemon");
    return ear_close(given_up);
}

doctor_finding check_interfaces(doctor *d)
{
    char others[256];
    facts_interface where;
    const char *asked = *d->interface.name ? d->interface.name : d->options.interface;
    if (d->over_lcm) return finding_ok("not needed: LCM goes where the route leads");
    if (d->stranger && !d->daemon) return finding_unknown("not tried: a daemon of another wire is here");
    if (!d->daemon && !give_up_ear(d))
        return finding_unknown("not tried: this host's firewall drops even what DDS sends to %s itself", asked);
    if (!d->daemon && heard_without_cyclone_uri(d))
        return finding_mend(finding_problem("a daemon (%s) is heard only without CYCLONEDDS_URI, which is \"%.200s\"",
                                d->elsewhere, getenv("CYCLONEDDS_URI")),
            "unset CYCLONEDDS_URI");
    if (heard_on_another(d, others, &where)) {
        doctor_finding f =
            finding_problem("a daemon (%s) is on %s, and you asked on %s", d->elsewhere, where.name, asked);
        if (where.loopback) return finding_mend(f, "collidectl doctor   # without --interface");
        return finding_mend(f, "collidectl doctor --interface %s", where.name);
    }
    if (d->daemon) return finding_ok("the daemon is on %s, as we%s%s", asked, *others ? "; also up: " : "", others);
    return finding_ok(
        "no daemon on %s%s", *others ? "other interfaces: " : "other interfaces, as there are none", others);
}

/* Those domains, other than ours, in which there is somebody: on this machine by its ports; on a network by asking. */
static size_t domains_in_use(const doctor *d, unsigned domains[TRIED_MAX])
{
    facts_ports ports;
    bool answers[PROBE_DOMAINS] = {false};
    size_t count = 0;
    bool known = facts_udp_ports(d->options.system_root, &ports);
    if (*d->options.interface) probe_dds_domains(d->interface.address, answers, ANSWER_S);
    for (unsigned i = 0; i < DDS_DOMAINS && count < TRIED_MAX; i++) {
        bool ours = !d->over_lcm && i == d->domain;
        if (!ours && (answers[i] || (known && is_used(&ports, i)))) domains[count++] = i;
    }
    return count;
}

doctor_finding check_domain(doctor *d)
{
    unsigned domains[TRIED_MAX];
    char uri[32];
    if (d->daemon) return finding_ok("the daemon is on %s", d->options.uri);
    if (d->stranger) return finding_unknown("not tried: a daemon of another wire is here");
    if (*d->elsewhere) return finding_unknown("not tried: the daemon is on another interface");
    size_t count = domains_in_use(d, domains);
    for (size_t i = 0; i < count; i++) {
        doctor_progress(d, "somebody is in DDS domain %u; listening there", domains[i]);
        if (!hears_daemon(d, domains[i], d->options.interface)) continue;
        snprintf(uri, sizeof uri, "dds://%u", domains[i]);
        doctor_finding f =
            finding_problem("a daemon (%s) is on %s, and you asked on %s", d->elsewhere, uri, d->options.uri);
        const char *said = getenv("COLLIDED_URI");
        if (strcmp(d->options.uri, said && *said ? said : "dds://0") == 0)
            return finding_mend(f, "export COLLIDED_URI=%s", uri);
        return finding_mend(f, "collidectl doctor --connect %s%s%s", uri, *d->options.interface ? " --interface " : "",
            d->options.interface);
    }
    return finding_ok("no daemon in another domain (%zu tried, where somebody is)", count);
}
