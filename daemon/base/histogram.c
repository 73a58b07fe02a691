/* histogram: see histogram.h. */
#include "histogram.h"

#include <math.h>

void histogram_add(histogram *h, double number)
{
    if (isnan(number)) return;
    size_t i = 0;
    while (i < h->count && number > h->bounds[i]) i++;
    h->below[i]++;
    if (isfinite(number)) h->sum += number;
}

uint64_t histogram_total(const histogram *h)
{
    uint64_t total = 0;
    for (size_t i = 0; i <= h->count; i++) total += h->below[i];
    return total;
}
