/* Any bytes as heights, text or PNG, with a range and without: refused with one line, or a grid of finite numbers. */
#include "fuzz.h"

#include "loaders/heights.h"

#include <math.h>
#include <string.h>

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    static const double RANGE[2] = {-1, 3};
    for (int picture = 0; picture < 2; picture++) {
        pool p = {0};
        load_report r = {.error = ""};
        heights_grid g = {0};
        char *copy = pool_alloc(&p, size + 1, 1);
        if (size) memcpy(copy, data, size);
        bool good = heights_parse(&p, copy, size, "fuzz", picture ? RANGE : NULL, &g, &r);
        PROMISE(good == !r.error[0] && !strchr(r.error, '\n'));
        PROMISE(!good || (g.rows >= 2 && g.columns >= 2 && g.columns <= HEIGHTS_MAX / g.rows));
        for (size_t i = 0; good && i < g.rows * g.columns; i++) PROMISE(isfinite(g.at[i]));
        pool_free(&p);
    }
    return 0;
}
