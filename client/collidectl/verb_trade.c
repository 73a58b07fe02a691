/* verb_trade: what accuracy costs: a recording, or one that the daemon makes now, at every accuracy. */
#include "trade.h"
#include "verbs.h"

#include <errno.h>
#include <stdio.h>
#include <string.h>
#include <sys/stat.h>
#include <sysexits.h>
#include <time.h>
#include <unistd.h>

static const double DEFAULT_S = 10;

static int check_file(const char *file)
{
    struct stat is;
    bool there = access(file, R_OK) == 0 && stat(file, &is) == 0;
    if (there && S_ISREG(is.st_mode)) return 0;
    return ctl_fail(EX_NOINPUT, "trade: %s: %s", file, there ? "not a file" : strerror(errno));
}

static int check_prefix(const char *prefix)
{
    bool good = *prefix && *prefix != '-';
    for (const char *c = prefix; *c; c++) good &= (unsigned char)*c >= ' ' && *c != 127;
    return good ? 0 : ctl_fail(EX_USAGE, "--out '%s': must be the beginning of file names", prefix);
}

/* The file that the daemon has recorded. */
static int record(ctl *c, const char **file)
{
    char name[64];
    double seconds = c->options.seconds > 0 ? c->options.seconds : DEFAULT_S;
    time_t now = time(NULL);
    struct tm t;
    if (!localtime_r(&now, &t) || !strftime(name, sizeof name, "trade-%Y%m%d-%H%M%S", &t))
        snprintf(name, sizeof name, "trade");
    int status = ctl_connect_guest(c);
    if (status) return status;
    collided_result result = {0};
    ctl_catch_signals();
    status = ctl_check(c, collided_record(c->client, name, c->options.timeout_s, &result), "trade: recording");
    if (status) return status;
    *file = pool_copy(&c->pool, result.text ? result.text : name);
    collided_result_free(&result);
    fprintf(stderr, "collidectl: recording %s for %g s\n", *file, seconds);
    status = ctl_poll(c, seconds);
    result = (collided_result){0};
    int ended =
        ctl_check(c, collided_record(c->client, NULL, c->options.timeout_s, &result), "trade: ending the recording");
    collided_result_free(&result);
    ctl_disconnect(c);
    if (status || ended) return status ? status : ended;
    if (access(*file, R_OK) == 0) return 0;
    return ctl_fail(EX_NOINPUT,
        "trade: %s: %s: if it is on the daemon's host, copy it here, then: collidectl trade FILE", *file,
        strerror(errno));
}

/* A promise that is broken is nothing to choose by. */
static int check_promises(const trade *t)
{
    double missed = 0, outside = 0;
    for (size_t i = 0; i < t->levels; i++) {
        missed += trade_all(t)[i].missed;
        outside += trade_all(t)[i].outside;
    }
    if (missed == 0 && outside == 0) return 0;
    return ctl_fail(EX_SOFTWARE,
        "trade: %.0f events missed, %.0f intervals without the truth in them: both must be 0: please report it, with "
        "the recording",
        missed, outside);
}

int verb_trade(ctl *c)
{
    const char *file = c->argument_count ? c->arguments[0] : NULL, *prefix = c->options.out;
    trade t;
    trade_advice a;
    bool made;
    if (file && c->options.seconds > 0)
        return ctl_fail(
            EX_USAGE, "trade: --seconds is for a recording that is not made yet: leave out %s, or it", file);
    int status = check_prefix(prefix);
    if (!status) status = file ? check_file(file) : record(c, &file);
    if (!status) status = trade_run(c, file, &t);
    if (status) return status;
    trade_advise(&t, &a);
    if (!c->options.json) trade_show_text(file, &t, &a);
    status = trade_picture(c, &t, &a, prefix, &made);
    if (c->options.json)
        trade_show_json(&t, &a, made, prefix);
    else if (made)
        printf("picture: %s.svg, %s.png\n", prefix, prefix);
    return status ? status : check_promises(&t);
}
