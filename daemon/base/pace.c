/* pace: a budget in slices: most of what is left, then most of that, so that what a unit took in this very round counts
 * for what is granted last. */
#include "pace.h"

static const double UNIT_FIRST = 2;    /* ns, before anything is known: rather too much */
static const double UNIT_LEAST = 0.01; /* ns: a clock may stand still */
static const double REST_FIRST = 0.25; /* of the budget */
static const double TARGET = 0.9;      /* of the budget: the last piece of work may take longer than expected */
static const double SLICE = 0.6;       /* of what is left, ... */
static const double LAST_SLICE = 0.12; /* ... unless that is less than this share of the budget */
static const double END = 0.02;        /* of the budget: not worth a slice */
static const double LEARN_UNIT = 0.125, LEARN_MORE_REST = 0.5, LEARN_LESS_REST = 0.1;
static const uint64_t UNITS_TO_LEARN_FROM = 2000;

void pace_init(pace *p, int64_t limit_ns)
{
    *p = (pace){.limit_ns = limit_ns, .unit_ns = UNIT_FIRST, .rest_ns = REST_FIRST * (double)limit_ns};
}

void pace_begin(pace *p, int64_t now_ns)
{
    p->began_ns = p->last_ns = now_ns;
    p->last_done = 0;
    p->granted = false;
}

/* A slice that was held up by others on its core is not what a unit takes. */
static void learn_unit(pace *p, int64_t now_ns, uint64_t done)
{
    uint64_t units = done - p->last_done;
    if (!p->granted || units < UNITS_TO_LEARN_FROM) return;
    double took = (double)(now_ns - p->last_ns) / (double)units;
    if (took > 4 * p->unit_ns) took = 4 * p->unit_ns;
    p->unit_ns += LEARN_UNIT * (took - p->unit_ns);
    if (!(p->unit_ns > UNIT_LEAST)) p->unit_ns = UNIT_LEAST;
}

uint64_t pace_grant(pace *p, int64_t now_ns, uint64_t done)
{
    learn_unit(p, now_ns, done);
    double limit = (double)p->limit_ns, left = TARGET * limit - (double)(now_ns - p->began_ns) - p->rest_ns;
    p->last_ns = now_ns;
    p->last_done = done;
    p->granted = true;
    if (!(left > END * limit)) return done;
    return done + (uint64_t)((left > LAST_SLICE * limit ? SLICE : 1) * left / p->unit_ns);
}

void pace_end(pace *p, int64_t now_ns, uint64_t done)
{
    if (!p->granted) return;
    double rest = (double)(now_ns - p->last_ns) - p->unit_ns * (double)(done - p->last_done);
    double limit = (double)p->limit_ns;
    rest = rest < 0 ? 0 : rest > limit ? limit : rest;
    p->rest_ns += (rest > p->rest_ns ? LEARN_MORE_REST : LEARN_LESS_REST) * (rest - p->rest_ns);
}
