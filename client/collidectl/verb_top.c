/* verb_top: the daemon as a terminal view, redrawn once a second, or as lines. What it shows is Status; rates are
 * between the last two. A daemon that is not heard any more is said to be so, and looked for until it is back. */
#include "top_json.h"
#include "top_page.h"
#include "top_terminal.h"
#include "verbs.h"

#include <stdio.h>
#include <stdlib.h>
#include <sysexits.h>
#include <time.h>

typedef struct top {
    ctl *ctl;
    top_sample sample;
    double last_seen_s; /* when a Status came last */
    bool unheard, on_terminal;
    size_t columns, rows; /* of what was drawn last */
} top;

static double now_s(void)
{
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

/* Waits a little; true if something new is known: a Status, or that there is none. */
static bool look(top *t)
{
    static const double A_MOMENT_S = 0.1; /* how soon a key, a signal or another size is seen */
    collided_daemon_status status;
    collided_status polled = collided_poll(t->ctl->client, A_MOMENT_S);
    collided_status got = collided_get_status(t->ctl->client, 0, &status);
    bool was_unheard = t->unheard;
    t->unheard = polled == COLLIDED_NO_DAEMON || got == COLLIDED_NO_DAEMON;
    if (got == COLLIDED_OK && top_sample_take(&t->sample, &status)) {
        t->last_seen_s = now_s();
        return true;
    }
    if (polled != COLLIDED_OK) nanosleep(&(struct timespec){0, (long)(1e9 * A_MOMENT_S)}, NULL); /* it did not wait */
    return t->unheard != was_unheard;
}

static double unheard_s(const top *t)
{
    return t->unheard ? now_s() - t->last_seen_s : 0;
}

static void print(const top *t)
{
    const top_view v = {.sample = &t->sample, .unheard_s = unheard_s(t)};
    char *page = t->ctl->options.json ? NULL : top_page(&v);
    if (t->ctl->options.json)
        top_json(&t->sample, v.unheard_s);
    else
        printf("%s%s", page ? page : "", t->ctl->options.once ? "" : "\n");
    fflush(stdout);
    free(page);
}

static void draw(top *t)
{
    top_view v = {.sample = &t->sample, .unheard_s = unheard_s(t), .styled = true};
    top_terminal_size(&v.columns, &v.rows);
    char *page = top_page(&v);
    if (page) top_terminal_show(page);
    free(page);
    t->columns = v.columns;
    t->rows = v.rows;
}

static bool has_other_size(const top *t)
{
    size_t columns, rows;
    top_terminal_size(&columns, &rows);
    return columns != t->columns || rows != t->rows;
}

/* Two Status, so that there are rates; if a second one does not come in time, rates are since the daemon's start. */
static int once(top *t)
{
    double end = now_s() + t->ctl->options.timeout_s;
    while (!t->sample.before.epoch && now_s() < end && !top_terminal_ended()) {
        look(t);
        if (t->unheard) return ctl_check(t->ctl, COLLIDED_NO_DAEMON, "top");
    }
    if (!t->sample.now.epoch) return ctl_check(t->ctl, COLLIDED_TIMEOUT, "top");
    print(t);
    return EX_OK;
}

static void watch(top *t)
{
    double seconds = t->ctl->options.seconds, end = now_s() + seconds, due = 0;
    bool news = true;
    while (!top_terminal_ended() && !(seconds > 0 && now_s() >= end) && !ferror(stdout)) {
        news |= look(t);
        bool anew = t->on_terminal && (top_terminal_paused() || has_other_size(t));
        bool ready = t->on_terminal || t->sample.before.epoch || t->unheard;
        bool asked = news || (t->unheard && t->on_terminal); /* for how long is counted */
        if (!anew && (!asked || !ready || now_s() < due)) continue;
        if (t->on_terminal)
            draw(t);
        else
            print(t);
        news = false;
        due = now_s() + (anew ? 0 : 0.95); /* once a second, as Status comes */
    }
}

int verb_top(ctl *c)
{
    top t = {.ctl = c, .last_seen_s = now_s()};
    int status = ctl_connect_guest(c);
    if (status) return status;
    top_terminal_catch_signals();
    if (c->options.once) {
        status = once(&t);
    } else {
        t.on_terminal = !c->options.json && top_terminal_is_there();
        if (t.on_terminal) top_terminal_enter();
        watch(&t);
        top_terminal_leave();
    }
    top_sample_free(&t.sample);
    return status;
}
