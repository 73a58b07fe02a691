/* kernel: collided_check_distance, the kernel of certificates that is proven by machine, for programs that can hand
 * over nothing but numbers. The words of a claim are those of checker.c, but that children of compounds may be hulls,
 * each followed by its points. Part of verify.wasm, and native for the tests. One thread. */
#include "checker.h"

#include "check/collided_check.h"

#include <math.h>
#include <stdbool.h>

enum { SHAPE_WORDS = 14, POSE_WORDS = 7, CLAIM_WORDS = 11, MOST = 1 << 22 };

/* What is left to be read; NULL once something was missing. */
typedef struct words {
    const double *at;
    size_t left;
} words;

static const double *next(words *w, size_t count)
{
    const double *at = w->at;
    w->at = at && count <= w->left ? at + count : NULL;
    w->left -= w->at ? count : w->left;
    return w->at ? at : NULL;
}

/* A shape without its children, of which it has as many as are returned. What is no kind is -1, and what is no count is
 * more than there may be: the kernel says so. */
static size_t next_shape(words *w, collided_check_shape *s)
{
    const double *h = next(w, SHAPE_WORDS);
    *s = (collided_check_shape){.kind = -1};
    if (!h) return 0;
    bool kind = h[0] >= COLLIDED_CHECK_SPHERE && h[0] <= COLLIDED_CHECK_COMPOUND && floor(h[0]) == h[0];
    if (kind) s->kind = (int32_t)h[0];
    for (int i = 0; i < 3; i++) s->half[i] = h[1 + i];
    s->radius = h[4], s->deviation = h[12];
    for (int i = 0; i < POSE_WORDS; i++) s->pose[i] = h[5 + i];
    size_t count = h[13] >= 0 && h[13] <= MOST ? (size_t)h[13] : MOST;
    if (s->kind == COLLIDED_CHECK_HULL) s->point_count = count, s->points = next(w, 3 * count);
    return s->kind == COLLIDED_CHECK_HULL ? 0 : count;
}

typedef struct kernel_side {
    collided_check_shape shape, children[COLLIDED_CHECK_CHILDREN_MOST];
    const double *body;
} kernel_side;

static void next_side(words *w, kernel_side *s)
{
    size_t count = next_shape(w, &s->shape);
    if (s->shape.kind != COLLIDED_CHECK_COMPOUND && count > 0) s->shape.kind = -1;
    s->shape.children = s->children, s->shape.child_count = count;
    for (size_t i = 0; i < count && count <= COLLIDED_CHECK_CHILDREN_MOST; i++)
        if (next_shape(w, &s->children[i]) > 0) s->children[i].kind = -1; /* no compounds in compounds */
    s->body = next(w, POSE_WORDS);
}

static collided_check_proven proven;

const double *checker_kernel_proven(void)
{
    return &proven.lo;
}

int checker_kernel(const double *claimed, size_t count, double allowed_m)
{
    static kernel_side a, b; /* 90 kB: WebAssembly's stack has no more */
    words w = {claimed, count};
    proven = (collided_check_proven){-INFINITY, INFINITY};
    next_side(&w, &a);
    next_side(&w, &b);
    const double *c = next(&w, CLAIM_WORDS);
    if (!c || w.left > 0) return COLLIDED_CHECK_NO_POINTER;
    collided_check_claim claim = {c[0], c[1], {c[2], c[3], c[4]}, {c[5], c[6], c[7]}, {c[8], c[9], c[10]}};
    return collided_check_distance(&a.shape, a.body, &b.shape, b.body, &claim, allowed_m, &proven);
}

int checker_kernel_machine(void)
{
    return collided_check_machine();
}
