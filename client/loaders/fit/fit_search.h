/* fit_search: looks for the least value of a function of a few numbers, by steps along each (compass search; Kolda,
 * Lewis and Torczon, "Optimization by direct search", 2003). What it finds need not be the least: whoever uses it
 * proves what it found, not that there is no better. Pure; any thread. */
#ifndef COLLIDED_LOADERS_FIT_SEARCH_H
#define COLLIDED_LOADERS_FIT_SEARCH_H

typedef double fit_function(const void *context, const double *x);

/* x: where to begin, and then the best one. Steps begin with `steps` and are halved until they are below `fine` of it,
 * or `most` values have been looked at. Returns the value. */
double fit_search(
    fit_function *f, const void *context, double *x, const double *steps, int count, double fine, int most);

#endif
