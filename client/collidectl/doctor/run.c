/* run: the URI and the options, and who is heard on it before the first check. */
#include "run.h"

#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define CALM_S 0.6 /* a second daemon, or one of another wire, is heard within that after the first */

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

void doctor_listen(doctor *d)
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

bool doctor_begin(doctor *d, const doctor_options *options)
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
