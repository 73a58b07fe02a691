/* checker: collided_verify for programs that can hand over nothing but numbers, as JavaScript does to WebAssembly: a
 * claim is one array of doubles, decoded here. Compiled to verify.wasm, and natively for the tests. One thread.
 *
 * A claim: shape A, pose of body A, shape B, pose of body B, then lo, hi, axis[3], point_a[3], point_b[3]; metres,
 * world. A pose: position[3], orientation w, x, y, z. A shape: type (of collided_shape_type), half[3], radius, pose[7]
 * in the body, deviation, n; then n children (shapes) of a compound, or n points x, y, z of a hull; n is 0 otherwise.
 */
#include "checker.h"

#include <stdlib.h>

enum { SHAPE_WORDS = 14, POSE_WORDS = 7, CLAIM_WORDS = 11, MOST_CHILDREN = 255, MOST_WORDS = 1 << 22 };

static double *room;
static size_t room_words;

double *checker_room(size_t words)
{
    if (words > MOST_WORDS) return NULL;
    if (words <= room_words) return room;
    double *larger = realloc(room, words * sizeof *larger);
    if (!larger) return NULL;
    room = larger, room_words = words;
    return room;
}

/* What is left to be read. */
typedef struct reader {
    const double *at;
    size_t left;
} reader;

/* The next words; NULL if there are not so many. */
static const double *take(reader *r, size_t words)
{
    if (words > r->left) return NULL;
    const double *at = r->at;
    r->at += words, r->left -= words;
    return at;
}

static collided_pose pose_of(const double *w)
{
    return (collided_pose){{w[0], w[1], w[2]}, {w[3], w[4], w[5], w[6]}};
}

/* One side of the claim. */
typedef struct side {
    collided_shape shape, children[MOST_CHILDREN];
    const double *hull;
    size_t hull_count;
    collided_pose body;
} side;

/* The head of a shape; `n` is what its kind counts. False if it is not there, or its type or count is none. */
static bool take_shape(reader *r, collided_shape *shape, size_t *n)
{
    const double *w = take(r, SHAPE_WORDS);
    if (!w || !(w[0] >= COLLIDED_SPHERE && w[0] <= COLLIDED_COMPOUND) || !(w[13] >= 0 && w[13] <= MOST_WORDS))
        return false;
    *shape = (collided_shape){.type = (collided_shape_type)w[0],
        .half = {w[1], w[2], w[3]},
        .radius = w[4],
        .pose = pose_of(w + 5),
        .deviation = w[12]};
    *n = (size_t)w[13];
    return true;
}

static bool take_children(reader *r, side *s, size_t count)
{
    if (count > MOST_CHILDREN) return false;
    for (size_t i = 0; i < count; i++) {
        size_t none;
        if (!take_shape(r, &s->children[i], &none) || none > 0) return false;
    }
    s->shape.children = s->children, s->shape.child_count = count;
    return true;
}

static bool take_side(reader *r, side *s)
{
    size_t n;
    s->hull = NULL, s->hull_count = 0;
    if (!take_shape(r, &s->shape, &n)) return false;
    if (s->shape.type == COLLIDED_COMPOUND) {
        if (!take_children(r, s, n)) return false;
    } else if (n > 0) {
        s->hull = take(r, 3 * n), s->hull_count = n;
        if (!s->hull) return false;
    }
    const double *body = take(r, POSE_WORDS);
    if (!body) return false;
    s->body = pose_of(body);
    return true;
}

int checker_check(const double *words, size_t count)
{
    static side a, b; /* 60 kB: WebAssembly's stack has no more */
    reader r = {words, count};
    if (!words || !take_side(&r, &a) || !take_side(&r, &b)) return COLLIDED_BAD_ARGUMENT;
    const double *w = take(&r, CLAIM_WORDS);
    if (!w || r.left > 0) return COLLIDED_BAD_ARGUMENT;
    collided_certificate claim = {w[0], w[1], {w[2], w[3], w[4]}, {w[5], w[6], w[7]}, {w[8], w[9], w[10]}};
    return collided_verify(&a.shape, &a.body, a.hull, a.hull_count, &b.shape, &b.body, b.hull, b.hull_count, &claim);
}
