/* verb_doctor: runs the doctor's checks and prints a line a check, as each is done. Exit status 0 only if all is well.
 */
#include "json.h"
#include "verbs.h"

#include "doctor/doctor.h"

#include <stdio.h>
#include <sysexits.h>
#include <unistd.h>

static void print_line(void *context, const char *check, const doctor_finding *f)
{
    (void)context;
    printf("%-12s %-11s %s\n", check, doctor_verdict_name(f->verdict), f->seen);
    if (*f->mend) printf("%12s mend: %s\n", "", f->mend);
    fflush(stdout);
}

static void print_finding_json(void *context, const char *check, const doctor_finding *f)
{
    json j = {.out = stdout};
    (void)context;
    json_open(&j, NULL, '{');
    json_text(&j, "check", check);
    json_text(&j, "verdict", doctor_verdict_name(f->verdict));
    json_text(&j, "seen", f->seen);
    json_text(&j, "mend", f->mend);
    json_close(&j, '}');
    json_end_line(&j);
    fflush(stdout);
}

/* For whoever watches; a log has no use for it. */
static void print_progress(void *context, const char *what)
{
    (void)context;
    if (isatty(STDERR_FILENO)) fprintf(stderr, "... %s\n", what);
}

static int list_checks(void)
{
    const char *summary, *name;
    for (size_t i = 0; (name = doctor_check_name(i, &summary)); i++) printf("%-12s %s\n", name, summary);
    return EX_OK;
}

int verb_doctor(ctl *c)
{
    const ctl_options *o = &c->options;
    if (o->list) return list_checks();
    const doctor_options options = {.uri = o->connect,
        .interface = o->interface,
        .peer = o->peer,
        .system_root = o->system_root,
        .release = collided_version(),
        .daemon = ctl_find_daemon(c),
        .timeout_s = o->timeout_s,
        .found = o->json ? print_finding_json : print_line,
        .progress = print_progress};
    int problems = doctor_run(&options);
    if (problems < 0)
        return ctl_fail(EX_USAGE,
            "--connect '%s': must be dds://DOMAIN, of 0 to 230, or lcm://[udpm://ADDRESS:PORT?ttl=N]", o->connect);
    return problems ? EX_UNAVAILABLE : EX_OK;
}
