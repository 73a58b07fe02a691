/* trade_show: one line a row. */
#include "json.h"
#include "show.h"
#include "trade.h"

#include <stdio.h>
#include <string.h>

static void show_counts(const trade *t)
{
    printf("%.0f ticks, %.3g s, %.0f subscription%s; %.0f answers", t->ticks, t->seconds, t->subscriptions,
        t->subscriptions == 1 ? "" : "s", t->answers);
    if (t->measured < t->answers) printf(", of which %.0f were measured", t->measured);
    puts(", each asked at every accuracy");
    if (t->left_out > 0)
        printf("the times of %.0f tick%s in which something was announced are left out\n", t->left_out,
            t->left_out == 1 ? "" : "s");
}

/* "-" where nothing was measured. */
static void show_times(double mean_s, double p99_s, double count, char mean[32], char p99[32])
{
    snprintf(mean, 32, "-");
    snprintf(p99, 32, "-");
    if (!(count > 0)) return;
    show_span(mean_s, mean, 32);
    show_span(p99_s, p99, 32);
}

static void show_errors(const trade_row *r, char worst[32], char mean[32])
{
    snprintf(worst, 32, "-");
    snprintf(mean, 32, "-");
    if (!(r->errors > 0)) return;
    show_length(r->error_max_m, worst, 32);
    show_length(r->error_mean_m, mean, 32);
}

static void show_row(const trade_row *r, bool first)
{
    char mean[32], p99[32], worst[32], error[32];
    show_times(r->time_mean_s, r->time_p99_s, r->measured, mean, p99);
    show_errors(r, worst, error);
    printf("%-22s %-8s %9s %9s %9s %9s %6.0f %6.0f %8.*f", first ? r->pair : "", r->accuracy, mean, p99, worst, error,
        r->missed, r->false_ones, r->bytes_per_s < 99950 ? 1 : 0, r->bytes_per_s / 1000);
    if (r->tick_mean_s > 0) {
        show_times(r->tick_mean_s, r->tick_p99_s, 1, mean, p99);
        printf(" %9s %8s", mean, p99);
    }
    putchar('\n');
}

void trade_show_text(const char *file, const trade *t, const trade_advice *a)
{
    printf("%s: ", file);
    show_counts(t);
    printf("\n%-22s %-8s %9s %9s %9s %9s %6s %6s %8s %9s %8s\n", "pair", "accuracy", "time", "p99", "error", "mean",
        "missed", "false", "kB/s", "tick", "p99");
    for (size_t i = 0; i < t->row_count; i++) show_row(&t->rows[i], i % t->levels == 0);
    printf("\nuse %s: %s\n", a->use->accuracy, a->reason);
}

static void json_row(json *j, const trade_row *r)
{
    json_open(j, NULL, '{');
    json_text(j, "event", "trade");
    json_text(j, "pair", r->pair);
    json_text(j, "accuracy", r->accuracy);
    json_integer(j, "measured", (int64_t)r->measured);
    json_number(j, "ns_mean", 1e9 * r->time_mean_s);
    json_number(j, "ns_p99", 1e9 * r->time_p99_s);
    json_number(j, "error_max", r->error_max_m);
    json_number(j, "error_mean", r->error_mean_m);
    json_integer(j, "outside", (int64_t)r->outside);
    json_integer(j, "events", (int64_t)r->events);
    json_integer(j, "missed", (int64_t)r->missed);
    json_integer(j, "false", (int64_t)r->false_ones);
    json_number(j, "bytes_per_s", r->bytes_per_s);
    if (strcmp(r->pair, "all") == 0) json_number(j, "tick_ns_mean", 1e9 * r->tick_mean_s);
    if (strcmp(r->pair, "all") == 0) json_number(j, "tick_ns_p99", 1e9 * r->tick_p99_s);
    json_close(j, '}');
    json_end_line(j);
}

void trade_show_json(const trade *t, const trade_advice *a, bool pictures, const char *prefix)
{
    char name[4096];
    json j = {.out = stdout};
    for (size_t i = 0; i < t->row_count; i++) json_row(&j, &t->rows[i]);
    json_open(&j, NULL, '{');
    json_text(&j, "event", "recommendation");
    json_text(&j, "use", a->use->accuracy);
    json_text(&j, "reason", a->reason);
    json_integer(&j, "ticks", (int64_t)t->ticks);
    json_integer(&j, "ticks_left_out", (int64_t)t->left_out);
    json_number(&j, "seconds", t->seconds);
    json_integer(&j, "subscriptions", (int64_t)t->subscriptions);
    json_integer(&j, "answers", (int64_t)t->answers);
    json_integer(&j, "measured", (int64_t)t->measured);
    for (int i = 0; pictures && i < 2; i++) {
        snprintf(name, sizeof name, "%s.%s", prefix, i ? "png" : "svg");
        json_text(&j, i ? "png" : "svg", name);
    }
    json_close(&j, '}');
    json_end_line(&j);
}
