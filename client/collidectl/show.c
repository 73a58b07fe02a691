/* show: the digits are as many as the interval's width deserves, and at least three after the point. */
#include "show.h"

#include <math.h>
#include <stdbool.h>
#include <stdio.h>

static int digits_for(double width)
{
    return width > 0 && isfinite(width) ? (int)fmin(12, fmax(3, 1 - floor(log10(width)))) : 6;
}

void show_bracket(double lo_s, double hi_s, char *out, size_t size)
{
    int digits = digits_for(hi_s - lo_s);
    snprintf(out, size, "[%.*f, %.*f] s", digits, lo_s, digits, hi_s);
}

void show_interval(double lo_m, double hi_m, char *out, size_t size)
{
    bool metres = !(fmax(fabs(lo_m), fabs(hi_m)) < 1);
    double scale = metres ? 1 : 1000;
    int digits = digits_for(scale * (hi_m - lo_m));
    snprintf(out, size, "[%.*f, %.*f] %s", digits, scale * lo_m, digits, scale * hi_m, metres ? "m" : "mm");
}

void show_age(double age_s, char *out, size_t size)
{
    if (age_s < 0)
        snprintf(out, size, "-");
    else if (age_s < 1)
        snprintf(out, size, "%.0f ms", 1000 * age_s);
    else
        snprintf(out, size, "%.1f s", age_s);
}

/* Of a unit: three digits of what is above are at least 1. */
static const double ROUNDS_UP = 0.9995;

void show_length(double m, char *out, size_t size)
{
    static const struct {
        double unit;
        const char *name;
    } units[] = {{1, "m"}, {1e-3, "mm"}, {1e-6, "um"}, {1e-9, "nm"}};
    for (int i = 0; i < 4; i++) {
        if (!(m >= ROUNDS_UP * units[i].unit)) continue;
        snprintf(out, size, "%.3g %s", m / units[i].unit, units[i].name);
        return;
    }
    snprintf(out, size, m > 0 ? "%.1g m" : "0", m);
}

void show_span(double s, char *out, size_t size)
{
    if (s < ROUNDS_UP * 1e-6)
        snprintf(out, size, "%.0f ns", 1e9 * s);
    else if (s < ROUNDS_UP * 1e-3)
        snprintf(out, size, "%.3g us", 1e6 * s);
    else
        snprintf(out, size, "%.3g ms", 1e3 * s);
}

const char *show_achieved(collided_achieved achieved)
{
    static const char *const names[] = {[COLLIDED_CERTAIN] = "certain",
        [COLLIDED_WITHIN] = "within_tolerance",
        [COLLIDED_WIDE] = "wide",
        [COLLIDED_STOPPED] = "stopped_by_budget"};
    return (unsigned)achieved <= COLLIDED_STOPPED ? names[achieved] : "unknown";
}
