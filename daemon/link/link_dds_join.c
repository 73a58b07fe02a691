/* link_dds_join: joining a DDS domain: what is asked for, is it possible, and why it was not; and DDS's log, which goes
 * into ours. The tick thread; the log also Cyclone's. */
#include "base/clock.h"
#include "base/log.h"
#include "interface.h"
#include "link_dds_own.h"
#include "wire/dds/wire_dds_leave.h"
#include "wire/dds/wire_dds_qos.h"
#include "wire/dds/wire_dds_security.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sysexits.h>

enum {
    DOMAIN_MAX = 230, /* above, the port numbers run out */
    CONFIG_BYTES = 8192
};

/* Forged packets make Cyclone write 100 MB of log a minute; ours has a limit for each site. */
static void on_log(void *context, const dds_log_data_t *line)
{
    link_dds_complaint *first = context; /* NULL: joined */
    int length = (int)strcspn(line->message, "\n");
    if (first && line->priority & (DDS_LC_FATAL | DDS_LC_ERROR)) {
        if (!*first->text) snprintf(first->text, sizeof first->text, "%.*s", length, line->message);
    } else if (line->priority & (DDS_LC_FATAL | DDS_LC_ERROR))
        log_error("DDS: %.*s", length, line->message);
    else if (line->priority & DDS_LC_WARNING)
        log_warning("DDS: %.*s", length, line->message);
    else
        log_debug("DDS: %.*s", length, line->message);
}

static bool parse_domain(const char *text, dds_domainid_t *domain)
{
    char *end;
    unsigned long number = strtoul(text, &end, 10);
    *domain = (dds_domainid_t)number;
    return strspn(text, "0123456789") == strlen(text) && *end == '\0' && number <= DOMAIN_MAX;
}

uint32_t link_dds_domain(const link_dds *l)
{
    dds_domainid_t domain = 0;
    parse_domain(l->head.options.address, &domain);
    return domain;
}

dds_return_t link_dds_join(link_dds *l, link_dds_complaint *first)
{
    dds_domainid_t domain = 0;
    char config[CONFIG_BYTES];
    parse_domain(l->head.options.address, &domain);
    wire_dds_config(config, sizeof config, l->head.options.interface, WIRE_DDS_DAEMON);
    dds_set_log_sink(on_log, first);
    dds_set_trace_sink(on_log, first);
    dds_entity_t made = dds_create_domain(domain, config);
    if (made < 0 && made != DDS_RETCODE_PRECONDITION_NOT_MET) return made;
    if (made > 0) l->domain = made;
    dds_qos_t *secured = wire_dds_security_qos(l->head.options.security);
    l->participant = dds_create_participant(domain, secured, NULL);
    dds_delete_qos(secured);
    if (l->participant < 0) return l->participant;
    dds_set_log_sink(on_log, NULL);
    dds_set_trace_sink(on_log, NULL);
    return DDS_RETCODE_OK;
}

int64_t link_dds_days_left(link_dds *l)
{
    enum { DAY_S = 86400, WARNED_DAYS = 30 };
    int64_t now_s = clock_wall_ns() / INT64_C(1000000000), days = (l->certificate_end_s - now_s) / DAY_S;
    if (l->certificate_end_s <= now_s) days = 0;
    metric_set(l->certificate_days, (uint64_t)days);
    if (days >= WARNED_DAYS || now_s / DAY_S == l->certificate_day) return days;
    l->certificate_day = now_s / DAY_S;
    log_warning("security = \"%s\": a certificate expires in %lld days: renew it: make_site --renew",
        l->head.options.security, (long long)days);
    return days;
}

void link_dds_leave(link_dds *l)
{
    if (l->participant > 0) dds_delete(l->participant);
    if (!wire_dds_leave(l->domain)) log_warning("%s", WIRE_DDS_LEFT_BEHIND);
    dds_set_log_sink(NULL, NULL);
    dds_set_trace_sink(NULL, NULL);
}

int link_dds_check(const link_options *options, char key[LINK_KEY_MAX], char *why, size_t why_size)
{
    dds_domainid_t domain;
    char config[CONFIG_BYTES];
    if (!parse_domain(options->address, &domain))
        snprintf(
            why, why_size, "dds://%.60s: expected a domain from 0 to %d, as in dds://0", options->address, DOMAIN_MAX);
    else if (!wire_dds_config(config, sizeof config, options->interface, WIRE_DDS_DAEMON))
        snprintf(why, why_size,
            "interface = \"%.60s\" is no name or address, or CYCLONEDDS_URI is too long: let it name a file: "
            "file:///path",
            options->interface);
    else if (!interface_is_there(options->interface, why, why_size))
        return EX_NOHOST;
    else if (options->security && *options->security &&
             !(wire_dds_security_check(options->security, why, why_size) &&
                 wire_dds_security_key_is_private(options->security, why, why_size)))
        return EX_NOINPUT;
    else
        return snprintf(key, LINK_KEY_MAX, "dds %u", domain) > 0 ? EX_OK : EX_SOFTWARE;
    return EX_CONFIG;
}

void link_dds_say_why(
    const link_options *options, const link_dds_complaint *first, dds_return_t joined, char *why, size_t why_size)
{
    if (*options->security &&
        wire_dds_security_explain(options->security, *first->text ? first->text : NULL, why, why_size))
        return;
    const char *said = *first->text ? first->text : joined < 0 ? dds_strretcode(joined) : "no readers and writers";
    const char *mend = "check the interface and CYCLONEDDS_URI";
    if (strstr(said, "participant index"))
        mend = "its UDP ports are all taken: end processes that use the domain (ss -ulp lists them), or use another "
               "one: links = dds://1";
    else if (strstr(said, "available interface") || strstr(said, "multicast-capable"))
        mend = "is it up? do: ip link set lo up (or the interface that was asked for)";
    snprintf(why, why_size, "dds://%s: DDS does not start: %s: %s", options->address, said, mend);
}
