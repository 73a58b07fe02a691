/* claims COUNT: writes random claims of pairs, and what the library's collided_verify and the kernel of
 * collided_check.h say of each, for test_checker.mjs, which asks verify.wasm the same: answers of the narrow phase as
 * they are, moved by a little in one number, and bent; every eighth pair with a compound. Each claim, in doubles: how
 * many words, the words of checker.c, the status; and of the kernel its status, lo and hi. The words are read back by
 * the checkers compiled here, too. */
#include "cases.h"
#include "check/collided_check.h"
#include "checker.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "geom/hull.h"

#define ALLOWED 1e-9 /* m; as test_checker.mjs has it */
enum { POINTS_MAX = 64, WORDS_MAX = 2 * (14 * 8 + 3 * POINTS_MAX + 7) + 11 };

typedef struct subject {
    collided_shape shape, children[4];
    collided_pose pose;
    double points[3 * POINTS_MAX];
    size_t count;
} subject;

static void put(vec3 from, double to[3])
{
    to[0] = from.x, to[1] = from.y, to[2] = from.z;
}

static collided_shape shape_of(const shape *s)
{
    collided_shape out = {.type = (collided_shape_type)s->type, .radius = s->radius, .pose = collided_pose_identity()};
    put(s->half, out.half);
    return out;
}

static void make_subject(subject *out, const shape *s, pose at)
{
    *out = (subject){.shape = shape_of(s), .pose = {.orientation = {at.q.w, at.q.x, at.q.y, at.q.z}}};
    put(at.p, out->pose.position);
    if (s->type != SHAPE_HULL) return;
    out->count = s->hull->vertex_count;
    for (size_t i = 0; i < out->count; i++) put(vec(s->hull->x[i], s->hull->y[i], s->hull->z[i]), out->points + 3 * i);
}

/* The subject as a compound: of its shape, and of one to three more. */
static void make_compound(random_state *r, subject *s)
{
    size_t count = 2 + (size_t)(random_bits(r) % 3);
    s->children[0] = s->shape;
    for (size_t i = 1; i < count; i++) {
        shape more = random_shape(r, (shape_type)(random_bits(r) % SHAPE_HALFSPACE));
        quat q = random_rotation(r);
        s->children[i] = shape_of(&more);
        for (int k = 0; k < 3; k++) s->children[i].pose.position[k] = random_in(r, -1, 1);
        memcpy(s->children[i].pose.orientation, (double[4]){q.w, q.x, q.y, q.z}, sizeof(double[4]));
    }
    s->shape = (collided_shape){.type = COLLIDED_COMPOUND,
        .pose = collided_pose_identity(),
        .radius = random_unit(r) < 0.5 ? 0 : random_in(r, 0, 0.1),
        .children = s->children,
        .child_count = count};
}

static double *put_words(double *to, const double *from, size_t count)
{
    memcpy(to, from, count * sizeof *to);
    return to + count;
}

static double *put_pose(double *to, const collided_pose *p)
{
    return put_words(put_words(to, p->position, 3), p->orientation, 4);
}

static double *put_shape(double *to, const collided_shape *s, size_t n)
{
    *to++ = s->type;
    to = put_words(to, s->half, 3);
    *to++ = s->radius;
    to = put_pose(to, &s->pose);
    *to++ = s->deviation;
    *to++ = (double)n;
    return to;
}

static double *put_subject(double *to, const subject *s)
{
    to = put_shape(to, &s->shape, s->shape.child_count > 0 ? s->shape.child_count : s->count);
    for (size_t i = 0; i < s->shape.child_count; i++) to = put_shape(to, &s->children[i], 0);
    return put_pose(put_words(to, s->points, 3 * s->count), &s->pose);
}

/* The engine's answer as a claim, left alone, moved by a little, or bent. */
static collided_certificate claim_of(random_state *r, const narrow_result *n, pose at_a)
{
    collided_certificate claim = {.lo = n->lo, .hi = n->hi};
    put(n->axis, claim.axis);
    put(vec_add(n->point_a, at_a.p), claim.point_a);
    put(vec_add(n->point_b, at_a.p), claim.point_b);
    double *numbers[] = {&claim.lo, &claim.hi, claim.axis, claim.axis + 1, claim.axis + 2, claim.point_a,
        claim.point_a + 1, claim.point_a + 2, claim.point_b, claim.point_b + 1, claim.point_b + 2};
    double *one = numbers[random_bits(r) % (sizeof numbers / sizeof *numbers)];
    switch (random_bits(r) % 8) {
    case 0:
    case 1:
    case 2:
        break;
    case 3:
    case 4:
    case 5:
        *one += (random_unit(r) - 0.5) * pow(10, random_in(r, -18, -3));
        break;
    case 6:
        claim.lo = -INFINITY;
        break;
    default:
        *one = random_unit(r) < 0.2 ? NAN : random_in(r, -3, 3);
        break;
    }
    return claim;
}

static collided_check_shape in_kernel(const collided_shape *s, const double *points, size_t count)
{
    collided_check_shape out = {.kind = (int32_t)s->type,
        .radius = s->radius,
        .deviation = s->deviation,
        .points = points,
        .point_count = count};
    memcpy(out.half, s->half, sizeof out.half);
    put_pose(out.pose, &s->pose);
    return out;
}

/* The kernel's status, lo and hi; ends the process where the words lead to another. */
static void ask_kernel(const subject *x, const subject *y, const collided_certificate *c, const double *words,
    size_t count, double told[3])
{
    const subject *both[2] = {x, y};
    collided_check_shape shapes[2], children[2][4];
    double poses[2][7];
    for (int i = 0; i < 2; i++) {
        shapes[i] = in_kernel(&both[i]->shape, both[i]->points, both[i]->count);
        shapes[i].children = children[i], shapes[i].child_count = both[i]->shape.child_count;
        for (size_t k = 0; k < shapes[i].child_count; k++) children[i][k] = in_kernel(&both[i]->children[k], NULL, 0);
        put_pose(poses[i], &both[i]->pose);
    }
    collided_check_claim claim = {.lo = c->lo, .hi = c->hi};
    memcpy(claim.axis, c->axis, sizeof claim.axis);
    memcpy(claim.point_a, c->point_a, sizeof claim.point_a);
    memcpy(claim.point_b, c->point_b, sizeof claim.point_b);
    collided_check_proven p;
    told[0] = collided_check_distance(&shapes[0], poses[0], &shapes[1], poses[1], &claim, ALLOWED, &p);
    told[1] = p.lo, told[2] = p.hi;
    if (checker_kernel(words, count, ALLOWED) == (int)told[0] && memcmp(checker_kernel_proven(), &p, sizeof p) == 0)
        return;
    fprintf(stderr, "claims: to the kernel the words of a claim say another thing than the claim\n");
    exit(1);
}

/* One word becomes anything, or the last are missing: what the checkers say then is told behind the words. They read a
 * copy that ends where the words do, for a sanitizer to see. Returns how many words there are. */
static size_t spoil(random_state *r, double *words, size_t count, double **end)
{
    static const double ODD[] = {NAN, INFINITY, -INFINITY, -1, 0, 0.5, 7, 10, 255, 256, 65537, 4e6, 1e300};
    words[random_bits(r) % count] = ODD[random_bits(r) % (sizeof ODD / sizeof *ODD)];
    if (random_bits(r) % 4 == 0) count -= random_bits(r) % count;
    double *copy = malloc(count * sizeof *copy);
    if (!copy) exit(1);
    memcpy(copy, words, count * sizeof *copy);
    *end = words + count;
    (*end)[0] = checker_check(copy, count);
    (*end)[1] = checker_kernel(copy, count, ALLOWED);
    memcpy(*end + 2, checker_kernel_proven(), 2 * sizeof **end);
    free(copy);
    return count;
}

static void write_claim(random_state *r)
{
    static const double AWAY[] = {0, 0, 100, 1e6};
    shape a = random_shape(r, (shape_type)(random_bits(r) % SHAPE_CONVEX_COUNT));
    shape b = random_shape(r, (shape_type)(random_bits(r) % SHAPE_CONVEX_COUNT));
    pose pa, pb;
    random_poses(r, &a, &b, (enum regime)(random_bits(r) % REGIME_COUNT), &pa, &pb);
    double away = AWAY[random_bits(r) % 4];
    pa.p.x += away, pb.p.x += away;
    narrow_request request = {.facts = NARROW_DISTANCE, .tolerance = 1e-9, .range = INFINITY};
    narrow_result n;
    narrow_query_world(&a, pa, &b, pb, &request, case_scratch(), &n);
    static subject x, y;
    make_subject(&x, &a, pa);
    make_subject(&y, &b, pb);
    if (random_bits(r) % 8 == 0 && a.type != SHAPE_HULL && a.type != SHAPE_HALFSPACE) make_compound(r, &x);
    collided_certificate claim = claim_of(r, &n, pa);
    double words[WORDS_MAX + 5], *end = put_subject(put_subject(words + 1, &x), &y);
    end = put_words(end, (double[2]){claim.lo, claim.hi}, 2);
    end = put_words(put_words(put_words(end, claim.axis, 3), claim.point_a, 3), claim.point_b, 3);
    size_t count = (size_t)(end - words) - 1;
    collided_status status = collided_verify(&x.shape, &x.pose, x.count ? x.points : NULL, x.count, &y.shape, &y.pose,
        y.count ? y.points : NULL, y.count, &claim);
    if (checker_check(words + 1, count) != (int)status) {
        fprintf(stderr, "claims: the words of a claim say another thing than the claim\n");
        exit(1);
    }
    ask_kernel(&x, &y, &claim, words + 1, count, end + 1);
    *end = status;
    if (random_bits(r) % 8 == 0) count = spoil(r, words + 1, count, &end);
    words[0] = (double)count;
    end += 4;
    if (fwrite(words, sizeof *words, (size_t)(end - words), stdout) != (size_t)(end - words)) exit(1);
}

int main(int argc, char **argv)
{
    long count = argc > 1 ? strtol(argv[1], NULL, 10) : 1000;
    random_state r = {20};
    cases_create();
    for (long i = 0; i < count; i++) write_claim(&r);
    cases_destroy();
    return fflush(stdout) == 0 ? 0 : 1;
}
