/* fit_search: after a step that helped the same way is tried twice as far. */
#include "fit_search.h"

#include <stdbool.h>

typedef struct state {
    fit_function *f;
    const void *context;
    double *x, value;
    int left;
} state;

static bool step_helps(state *s, int k, double by)
{
    double before = s->x[k];
    s->x[k] += by;
    s->left--;
    double value = s->f(s->context, s->x);
    if (value < s->value) {
        s->value = value;
        return true;
    }
    s->x[k] = before;
    return false;
}

static bool try_axis(state *s, int k, double by)
{
    if (!step_helps(s, k, by) && !step_helps(s, k, by = -by)) return false;
    while (s->left > 0 && step_helps(s, k, by *= 2)) continue;
    return true;
}

double fit_search(
    fit_function *f, const void *context, double *x, const double *steps, int count, double fine, int most)
{
    state s = {f, context, x, f(context, x), most};
    for (double scale = 1; scale > fine && s.left > 0;) {
        bool helped = false;
        for (int k = 0; k < count && s.left > 0; k++) helped |= try_axis(&s, k, scale * steps[k]);
        if (!helped) scale /= 2;
    }
    return s.value;
}
