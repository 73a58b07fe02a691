/* trade_advice: pure, but for the text. */
#include "show.h"
#include "trade.h"

#include <stdarg.h>
#include <stdio.h>
#include <string.h>

static const double NEARLY_FREE = 1.1;

const trade_row *trade_all(const trade *t)
{
    return t->rows + t->row_count - t->levels;
}

/* Nothing missed is a promise, and said elsewhere where it is broken. */
static bool reports_the_same(const trade_row *r)
{
    return r->missed == 0 && r->false_ones == 0;
}

static const trade_row *choose(const trade *t)
{
    const trade_row *all = trade_all(t), *cheapest = NULL, *use = &all[t->levels - 1];
    for (size_t i = 0; i < t->levels; i++)
        if (reports_the_same(&all[i]) && (!cheapest || all[i].tick_mean_s < cheapest->tick_mean_s)) cheapest = &all[i];
    for (size_t i = 0; cheapest && i < t->levels; i++)
        if (reports_the_same(&all[i]) && all[i].tick_mean_s <= NEARLY_FREE * cheapest->tick_mean_s) use = &all[i];
    return use;
}

/* Appends. */
__attribute__((format(printf, 3, 4))) static void say(char *text, size_t size, const char *format, ...)
{
    size_t length = strlen(text);
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(text + length, size - length, format, arguments);
    va_end(arguments);
}

static void say_finer(const trade_row *use, const trade_row *finer, char *text, size_t size)
{
    say(text, size, "; %s costs %.3g times", finer->accuracy, finer->tick_mean_s / use->tick_mean_s);
    if (reports_the_same(finer)) say(text, size, " and changes no event");
}

static void say_looser(const trade_row *use, const trade_row *looser, char *text, size_t size)
{
    double saved = 100 * (1 - looser->tick_mean_s / use->tick_mean_s);
    char off[32];
    show_length(looser->error_max_m, off, sizeof off);
    if (saved >= 0.5)
        say(text, size, "; %s would save %.0f %%, ", looser->accuracy, saved);
    else
        say(text, size, "; %s saves nothing, ", looser->accuracy);
    if (looser->false_ones > 0)
        say(text, size, "but tells %.0f false event%s", looser->false_ones, looser->false_ones > 1 ? "s" : "");
    else
        say(text, size, "and is off by up to %s", off);
}

/* The next looser one that differs. */
static const trade_row *find_looser(const trade_row *use, const trade_row *all)
{
    for (const trade_row *r = use; r > all;)
        if (!reports_the_same(--r) || r->error_max_m > 2 * use->error_max_m) return r;
    return NULL;
}

static const char *why(const trade_row *use, const trade_row *all, const trade_row *last)
{
    if (use < last) return "the same events as exact";
    return use > all && reports_the_same(use - 1) ? "exact is nearly free here"
                                                  : "nothing looser tells the same events";
}

void trade_advise(const trade *t, trade_advice *out)
{
    const trade_row *all = trade_all(t), *last = &all[t->levels - 1], *use = choose(t);
    const trade_row *looser = find_looser(use, all);
    char off[32], tick[32];
    show_length(use->error_max_m, off, sizeof off);
    show_span(use->tick_mean_s, tick, sizeof tick);
    out->use = use;
    out->reason[0] = '\0';
    say(out->reason, sizeof out->reason, "%s a tick, off by at most %s, %s", tick, off, why(use, all, last));
    if (looser) say_looser(use, looser, out->reason, sizeof out->reason);
    if (use < last) say_finer(use, use + 1, out->reason, sizeof out->reason);
}
