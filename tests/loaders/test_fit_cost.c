/* The table of costs against the page that `script/bench pareto` writes: the same within a third, once both are divided
 * by their means, since the page may come from another machine. */
#include "fit_fixture.h"

#include "loaders/fit/fit_cost.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

/* ns of a separated pair: the first number of the row under that title; 0 if there is none. */
static double page_ns(const char *pair)
{
    char line[512], row[64];
    double ns = 0;
    bool there = false;
    FILE *f = fopen(PARETO_PAGE, "re");
    assert_non_null(f);
    snprintf(row, sizeof row, "| %s |", pair);
    while (ns == 0 && fgets(line, sizeof line, f)) {
        there |= strncmp(line, "## Beside the peers", 19) == 0;
        if (!there || strncmp(line, row, strlen(row)) != 0) continue;
        for (const char *c = line + strlen(row); *c && *c != ':'; c++)
            if (*c >= '0' && *c <= '9') ns = 10 * ns + (*c - '0');
    }
    fclose(f);
    return ns;
}

static void costs_are_those_of_the_page(void **state)
{
    static const struct {
        const char *pair;
        collided_shape_type type;
        size_t size; /* corners or triangles */
    } rows[] = {{"sphere-sphere", COLLIDED_SPHERE, 0}, {"capsule-capsule", COLLIDED_CAPSULE, 0},
        {"box-box", COLLIDED_BOX, 0}, {"cylinder-cylinder", COLLIDED_CYLINDER, 0}, {"cone-box", COLLIDED_CONE, 0},
        {"ellipsoid-ellipsoid", COLLIDED_ELLIPSOID, 0}, {"hull16-hull16", COLLIDED_HULL, 16},
        {"hull64-hull64", COLLIDED_HULL, 64}, {"hull256-hull256", COLLIDED_HULL, 256},
        {"mesh-mesh", COLLIDED_MESH, 5000}};
    enum { ROWS = sizeof rows / sizeof rows[0] };
    (void)state;
    load_shape nothing = {.shape.type = COLLIDED_HALFSPACE};
    double logs[ROWS], mean = 0;
    for (int i = 0; i < ROWS; i++) {
        load_shape s = {.shape.type = rows[i].type, .points.count = rows[i].size, .triangles.count = rows[i].size};
        double page = page_ns(rows[i].pair), kept = fit_cost_of_pair(&nothing, 1, &nothing, 1) - 30; /* of every pair */
        if (page == 0) fail_msg("%s: no such row", rows[i].pair);
        logs[i] = log((fit_cost_ns(&s) - kept) / page);
        mean += logs[i] / ROWS;
    }
    for (int i = 0; i < ROWS; i++)
        if (fabs(logs[i] - mean) > log(4.0 / 3)) fail_msg("%s: %.2f times the page", rows[i].pair, exp(logs[i] - mean));
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(costs_are_those_of_the_page)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
