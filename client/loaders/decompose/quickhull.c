/* quickhull: what qhull prints is thrown away; what it says is checked by whoever asked. */
#include "quickhull.h"

#include <libqhull_r/qhull_ra.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static int compare_hull_points(const void *left, const void *right)
{
    const double *a = left, *b = right;
    for (int k = 0; k < 3; k++)
        if (a[k] != b[k]) return a[k] < b[k] ? -1 : 1;
    return 0;
}

size_t quickhull_sort(double *points, size_t count)
{
    for (size_t i = 0; i < 3 * count; i++) points[i] += 0.0; /* -0 becomes 0 */
    qsort(points, count, 3 * sizeof *points, compare_hull_points);
    size_t kept = 0;
    for (size_t i = 0; i < count; i++) {
        if (kept && compare_hull_points(points + 3 * (kept - 1), points + 3 * i) == 0) continue;
        memmove(points + 3 * kept++, points + 3 * i, 3 * sizeof *points);
    }
    return kept;
}

/* qhull may change the points and the command that it is given. */
bool quickhull_run(pool *p, const double *points, size_t count, const char *command,
    void (*take)(void *context, void *qhull), void *context)
{
    char *messages = NULL, own_command[64];
    size_t size = 0;
    if (count < 4) return false;
    FILE *sink = open_memstream(&messages, &size);
    if (!sink) return false;
    double *own = pool_alloc(p, count, 3 * sizeof *own);
    memcpy(own, points, 3 * count * sizeof *own);
    snprintf(own_command, sizeof own_command, "%s", command);
    qhT *qh = pool_alloc(p, 1, sizeof *qh);
    qh_zero(qh, sink);
    bool good = qh_new_qhull(qh, 3, (int)count, own, False, own_command, NULL, sink) == 0;
    if (good) take(context, qh);
    int long_bytes, long_blocks;
    qh_freeqhull(qh, !qh_ALL);
    qh_memfreeshort(qh, &long_bytes, &long_blocks);
    fclose(sink);
    free(messages);
    return good;
}
