/* check_leases: bodies that nobody keeps up: of clients whose lease ran out, or whose poses are past their deadline. */
#include "commands.h"

#include <stdio.h>
#include <string.h>

enum { ASKED_MOST = 256 }; /* bodies; an answer of so many still fits one datagram */
#define ASK_S 1.0

doctor_finding check_lost(doctor *d)
{
    static const char prefix[] = "lost_client_";
    char words[64] = "", command[COMMAND_MAX];
    long clients = (long)ear_value(d->daemon, "lost_clients"), bodies = (long)ear_value(d->daemon, "lost_bodies");
    if (!clients) return finding_ok("no bodies of lost clients");
    for (size_t i = 0; i < d->daemon->counter_count; i++) {
        const ear_counter *c = &d->daemon->counters[i];
        if (strncmp(c->name, prefix, sizeof prefix - 1) == 0 && c->last > 0)
            snprintf(words, sizeof words, "forget %.16s", c->name + sizeof prefix - 1);
    }
    command_ctl(d, words, command);
    return finding_mend(
        finding_problem("%ld client(s) were lost and left %ld bodies, held or kept: start them again, or "
                        "forget what they left",
            clients, bodies),
        "%s", command);
}

typedef struct stale_bodies {
    unsigned reported, stale;
    char first[WIRE_NAME_MAX + 1];
} stale_bodies;

static void count_stale(void *context, const wire_answer *a)
{
    stale_bodies *s = context;
    s->reported = a->names_a.count;
    for (uint32_t i = 0; i < a->names_a.count && i < a->stale.count; i++) {
        if (!a->stale.at[i]) continue;
        if (!s->stale++) snprintf(s->first, sizeof s->first, "%s", a->names_a.at[i]);
    }
}

doctor_finding check_stale(doctor *d)
{
    stale_bodies s = {0};
    char word[2 * WIRE_NAME_MAX], words[COMMAND_MAX], command[COMMAND_MAX];
    long stale = (long)ear_value(d->daemon, "stale_bodies"), lost = (long)ear_value(d->daemon, "lost_bodies");
    const wire_query all = {.kind = WIRE_QUERY_BODIES, .name_a = "*", .most = ASKED_MOST};
    if (!ear_ask(d->ear, all, ASK_S, count_stale, &s)) return finding_unknown("the daemon answers no query");
    if (s.stale > stale) stale = s.stale;
    if (stale && stale <= lost) return finding_ok("none but the %ld of lost clients", stale);
    if (!stale) return finding_ok("no body is past its deadline");
    snprintf(words, sizeof words, "remove %s", command_word(*s.first ? s.first : "NAME", word, sizeof word));
    command_ctl(d, words, command);
    return finding_mend(
        finding_problem("%ld bodies are past their deadline, so that their pairs are unknown; the first "
                        "is %s: start again who moves it, or remove it",
            stale, s.first),
        "%s", command);
}
