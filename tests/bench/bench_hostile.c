/* bench_hostile: what one client can do to another. Each attack of tests/hostile against a daemon under a watchdog of
 * ten seconds: how long a neighbour's answers and events take meanwhile, the longest tick (and what one took
 * of a processor at most), the daemon's memory, and
 * whether it had to be started anew. Default: sizes that take a few seconds each; --full: the documented maxima. --case
 * NAME: only this one. */
#include "bench.h"

#include "stage.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

static void tell(const bench_options *o, const attack *a, const stage_result *r)
{
    double worst = fmax(r->answer_ms_p99, r->event_ms_p99);
    if (o->json)
        printf("{\"bench\": \"hostile\", \"case\": \"%s\", \"entry\": \"collided\", \"neighbour_ms_p99\": %.3f, "
               "\"answer_ms_p99\": %.3f, \"event_ms_p99\": %.3f, \"machine_ms_p99\": %.3f, \"longest_tick_ms\": %.3f, "
               "\"most_cpu_ms\": %.3f, \"rss_mb\": %ld, \"restarts\": %d, \"wrong\": %llu, \"unanswered\": %llu}\n",
            a->name, worst, r->answer_ms_p99, r->event_ms_p99, r->machine_ms_p99, r->longest_tick_ms, r->most_cpu_ms,
            r->rss_mb, r->restarts, (unsigned long long)r->wrong, (unsigned long long)r->unanswered);
    else
        printf("%-18s %9.1f %9.1f %9.1f %9.1f %8.1f %7ld %5d %5llu %5llu  %s\n", a->name, r->answer_ms_p99,
            r->event_ms_p99, r->machine_ms_p99, r->longest_tick_ms, r->most_cpu_ms, r->rss_mb, r->restarts,
            (unsigned long long)r->wrong, (unsigned long long)r->unanswered, *r->error ? r->error : a->what);
    fflush(stdout);
}

/* Takes "--case NAME" out of the arguments; NULL = it is not among them. */
static const char *take_case(int *argc, char **argv)
{
    for (int i = 1; i + 1 < *argc; i++) {
        if (strcmp(argv[i], "--case") != 0) continue;
        const char *name = argv[i + 1];
        memmove(argv + i, argv + i + 2, (size_t)(*argc - i - 1) * sizeof *argv);
        *argc -= 2;
        return name;
    }
    return NULL;
}

int main(int argc, char **argv)
{
    bench_options o;
    int failures = 0;
    const char *only = take_case(&argc, argv);
    if (!bench_parse(argc, argv, 1, 2, &o)) return 64;
    bool full = o.seconds > 1;
    if (!bench_isolate()) return 77;
    if (!o.json)
        printf("                   answer ms  event ms  sleep ms   tick ms   cpu ms     MiB  anew wrong  none\n"
               "case                     p99       p99       p99   longest     most    most\n");
    for (size_t i = 0; i < attack_count; i++) {
        stage_result r;
        if (only && strcmp(only, attacks[i].name) != 0) continue;
        stage_play(&attacks[i], "dds://61", full, &r);
        tell(&o, &attacks[i], &r);
        failures += *r.error || r.wrong || r.restarts;
    }
    return failures ? 1 : 0;
}
