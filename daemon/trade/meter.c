/* meter: see meter.h. One thread. */
#include "meter.h"

#include "base/array.h"
#include "base/clock.h"

#include <math.h>
#include <stdbool.h>
#include <stdlib.h>

enum { REPEATS = 3, CALIBRATIONS = 1000 };

size_t meter_pair(shape_type a, shape_type b)
{
    if (a >= SHAPE_TYPE_COUNT || b >= SHAPE_TYPE_COUNT) return METER_PAIRS;
    return a < b ? (size_t)a * SHAPE_TYPE_COUNT + b : (size_t)b * SHAPE_TYPE_COUNT + a;
}

meter *meter_create(void)
{
    meter *m = base_zalloc(1, sizeof *m);
    m->clock_ns = INT64_MAX;
    for (int i = 0; i < CALIBRATIONS; i++) {
        int64_t before = clock_monotonic_ns(), took = clock_monotonic_ns() - before;
        if (took < m->clock_ns) m->clock_ns = took;
    }
    return m;
}

void meter_destroy(meter *m)
{
    for (size_t i = 0; i < METER_PAIRS; i++) free(m->cells[i]);
    free(m);
}

/* As quick as it can be: ns. */
static int64_t time_answer(const meter *m, const world *w, size_t i, const trade_level *level, double *lo, double *hi)
{
    int64_t least = INT64_MAX;
    for (int k = 0; k < REPEATS; k++) {
        int64_t before = clock_monotonic_ns();
        level_ask(level, w, i, lo, hi);
        int64_t took = clock_monotonic_ns() - before;
        if (took < least) least = took;
    }
    return least - m->clock_ns;
}

static void count_error(meter_cell *c, double lo, double hi, double least, double most)
{
    double error = fmax(hi - least, most - lo);
    if (lo > most || hi < least) c->outside++;
    c->errors++;
    c->error_max = fmax(c->error_max, error);
    c->error_sum += error;
}

static void measure(meter *m, const world *w, size_t i)
{
    world_answer answer;
    double least, most, lo, hi;
    world_get_answer(w, i, &answer);
    size_t pair = meter_pair(answer.type_a, answer.type_b);
    if (!m->cells[pair]) m->cells[pair] = base_zalloc(TRADE_LEVELS, sizeof **m->cells);
    world_ask_exactly(w, i, &least, &most);
    bool reported = least <= answer.limit && isfinite(least) && isfinite(most); /* two half-spaces have no distance */
    for (size_t k = 0; k < TRADE_LEVELS; k++) {
        size_t level = (m->measured + k) % TRADE_LEVELS; /* none of them is always the first */
        meter_cell *c = &m->cells[pair][level];
        spread_add(&c->times, time_answer(m, w, i, &trade_levels[level], &lo, &hi));
        if (reported) count_error(c, lo, hi, least, most);
    }
    m->measured++;
}

void meter_tick(meter *m, const world *exact)
{
    size_t count = world_answers(exact), step = (count + METER_A_TICK - 1) / METER_A_TICK;
    m->answers += count;
    for (size_t i = step ? m->measured % step : 0; i < count; i += step) measure(m, exact, i);
}
