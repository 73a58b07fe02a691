/* bench: what benchmarks share: options, order statistics, a network of their own, and daemon processes with the time
 * that they used. One thread. Whatever cannot be measured says so on stderr. */
#ifndef COLLIDED_TESTS_BENCH_BENCH_H
#define COLLIDED_TESTS_BENCH_BENCH_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <sys/types.h>

typedef struct bench_options {
    bool json;      /* one object a line instead of a table */
    double seconds; /* that each row is measured for; --full: longer */
    long bodies;    /* only this number of bodies; 0 = the benchmark's own rows */
} bench_options;

/* False, with the usage on stderr, for what is not an option. */
bool bench_parse(int argc, char **argv, double seconds, double seconds_full, bench_options *out);

int64_t bench_now_ns(void);  /* monotonic */
int64_t bench_wall_ns(void); /* since the Unix epoch, as poses are stamped */
void bench_sleep_until(int64_t monotonic_ns);

/* Durations, to be sorted once all are in. */
typedef struct bench_samples {
    int64_t *at_ns;
    size_t count, capacity;
} bench_samples;
bool bench_samples_init(bench_samples *s, size_t capacity);
void bench_samples_add(bench_samples *s, int64_t ns); /* what exceeds the capacity aborts: the caller counted wrongly */
double bench_percentile_us(bench_samples *s, double share); /* nearest rank; sorts; NAN = there are none */
void bench_samples_free(bench_samples *s);

/* A network namespace with loopback and multicast; false where that is not permitted. Before any thread starts. */
bool bench_isolate(void);

/* A process that ends with this one; -1 = it did not start. `arguments` ends with NULL. */
pid_t bench_start(const char *program, const char *const *arguments);
void bench_end(pid_t pid); /* SIGTERM, and SIGKILL after five seconds */

/* Time of all cores that the process and its present children have used, s; NAN if it is gone. Kernel ticks: 10 ms. */
double bench_cpu_s(pid_t pid);

#endif
