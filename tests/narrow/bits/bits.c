/* bits: one line for every two types of shapes, with a hash of all the bits of answers about random pairs of them, and
 * one for a world.
 *
 * It is built with the layers as they are, with the same sources unoptimised, by another compiler and for another
 * processor (other_build); the lines must be the same, and `diff` shows which types differ. Nothing is judged here. */
#include "cases.h"
#include "soft/elementary.h"
#include "solids.h"
#include "toi/toi.h"
#include "where_they_stand.h"
#include "world_bits.h"

#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { PAIRS_EACH = 200, MESHES = 3, MESH_PAIRS_EACH = 36, FLIGHTS_EACH = 2, ELEMENTARY = 400 };

static int part = 1; /* of all those, one in so many */

typedef uint64_t hash;

static const hash EMPTY = UINT64_C(14695981039346656037);

static void mix(hash *h, uint64_t bits)
{
    for (int i = 0; i < 8; i++) *h = (*h ^ (bits >> 8 * i & 255)) * UINT64_C(1099511628211);
}

static void mix_number(hash *h, double x)
{
    uint64_t bits;
    memcpy(&bits, &x, sizeof bits);
    mix(h, bits);
}

static void mix_vec(hash *h, vec3 v)
{
    mix_number(h, v.x);
    mix_number(h, v.y);
    mix_number(h, v.z);
}

static void mix_result(hash *h, const narrow_result *r)
{
    mix_number(h, r->lo);
    mix_number(h, r->hi);
    mix_vec(h, r->axis);
    mix_vec(h, r->point_a);
    mix_vec(h, r->point_b);
    mix(h, (uint64_t)r->status << 40 | (uint64_t)r->method << 32 | r->iterations);
    mix(h, (uint64_t)r->refined << 32 | r->manifold.count);
    for (uint32_t i = 0; i < r->manifold.count; i++) {
        mix_vec(h, r->manifold.points[i].point);
        mix_number(h, r->manifold.points[i].distance);
        mix(h, r->manifold.points[i].feature);
    }
}

/* Everything that can be asked of the pair, by each road. */
static void mix_pair(hash *h, const shape *a, pose pa, const shape *b, pose pb)
{
    static const narrow_request REQUESTS[] = {
        {.facts = NARROW_DISTANCE | NARROW_MANIFOLD, .range = INFINITY},
        {.facts = NARROW_DISTANCE, .tolerance = 1e-6, .range = INFINITY},
        {.facts = NARROW_VERDICT, .threshold = 0.01},
        {.facts = NARROW_DISTANCE, .tolerance = 1e-9, .range = INFINITY, .engine = NARROW_ENGINE_GJK},
    };
    narrow_result r;
    for (size_t i = 0; i < sizeof REQUESTS / sizeof *REQUESTS; i++) {
        narrow_query_world(a, pa, b, pb, &REQUESTS[i], case_scratch(), &r);
        mix_result(h, &r);
    }
    if (!narrow_ordered(a, 0, b, 1)) return;
    pose b_in_a = pose_relative(pa, pb);
    narrow_cache cache = {.lower = 0};
    narrow_query(a, b, &b_in_a, &REQUESTS[1], &cache, case_scratch(), &r);
    mix_result(h, &r);
    mix_number(h, narrow_separation(a, b, &b_in_a, r.axis, &cache.hint_a, &cache.hint_b));
    mix_vec(h, narrow_guess_axis(a, b, &b_in_a));
    cache = (narrow_cache){.lower = 0};
    for (int i = 0; i < 3; i++) { /* where they stand, and a little farther on */
        query_where_they_stand(a, pa, b, pb, &REQUESTS[i % 2 + 1], NULL, &r);
        mix_result(h, &r);
        query_where_they_stand(a, pa, b, pb, &REQUESTS[1], &cache, &r);
        mix_result(h, &r);
        pb.p = vec_madd(pb.p, 0.01, pa.p);
    }
}

/* B flies through where A turns. */
static void mix_flight(hash *h, random_state *r, const shape *a, pose pa, const shape *b, pose pb)
{
    if (!narrow_ordered(a, 0, b, 1)) return;
    pose a_ends = {pa.p, random_rotation(r)}, b_ends = {vec_madd(pb.p, 2, vec_sub(pa.p, pb.p)), random_rotation(r)};
    const toi_mover x = {a, POSE_IDENTITY, motion_between(pa, a_ends, 1)},
                    y = {b, POSE_IDENTITY, motion_between(pb, b_ends, 1)};
    const toi_request request = {.span = 1, .tolerance = 1e-6};
    toi_result out;
    toi_find(&x, &y, &request, VEC_ZERO, case_scratch(), &out);
    mix(h, (uint64_t)out.status << 32 | out.steps);
    mix_number(h, out.lo);
    mix_number(h, out.hi);
    mix_vec(h, out.axis);
    mix_vec(h, out.point_a);
    mix_vec(h, out.point_b);
}

static void print(const char *a, const char *b, hash h)
{
    printf("%-10s %-10s %016" PRIx64 "\n", a, b, h);
}

static void convex_pairs(void)
{
    for (int ta = 0; ta < SHAPE_CONVEX_COUNT; ta++)
        for (int tb = ta; tb < SHAPE_CONVEX_COUNT; tb++) {
            hash h = EMPTY;
            for (int i = 0; i < PAIRS_EACH / part; i++) {
                random_state r = {((uint64_t)ta << 40) + ((uint64_t)tb << 32) + (uint64_t)i + 271828};
                shape a = random_shape(&r, (shape_type)ta), b = random_shape(&r, (shape_type)tb);
                pose pa, pb;
                random_poses(&r, &a, &b, (enum regime)(i % REGIME_COUNT), &pa, &pb);
                mix_pair(&h, &a, pa, &b, pb);
                if (i < FLIGHTS_EACH) mix_flight(&h, &r, &a, pa, &b, pb);
            }
            print(shape_type_name((shape_type)ta), shape_type_name((shape_type)tb), h);
        }
}

static void mesh_pairs(void)
{
    soup soups[MESHES] = {soup_icosphere(1, 1), soup_torus(0.8, 0.3, 12, 8), soup_trough()};
    mesh *meshes[MESHES];
    for (int i = 0; i < MESHES; i++) meshes[i] = soup_mesh(&soups[i]);
    for (int type = 0; type <= SHAPE_CONVEX_COUNT; type++) {
        hash h = EMPTY;
        for (int i = 0; i < MESH_PAIRS_EACH / part; i++) {
            random_state r = {((uint64_t)type << 32) + (uint64_t)i + 314159};
            shape b = mesh_shape(meshes[i % MESHES], i % 4 ? 0 : 0.05), a = b;
            if (type < SHAPE_CONVEX_COUNT) a = random_shape(&r, (shape_type)type);
            pose pa, pb;
            random_poses(&r, &a, &b, (enum regime)(i % REGIME_COUNT), &pa, &pb);
            mix_pair(&h, &a, pa, &b, pb);
        }
        print(type < SHAPE_CONVEX_COUNT ? shape_type_name((shape_type)type) : "mesh", "mesh", h);
    }
    for (int i = 0; i < MESHES; i++) {
        mesh_destroy(meshes[i]);
        soup_free(&soups[i]);
    }
}

static void deformable_pairs(void)
{
    hash h[2] = {EMPTY, EMPTY};
    random_state r = {161803};
    for (int i = 0; i < ELEMENTARY / part; i++) {
        vec3 start[4], end[4];
        elementary_result out;
        for (int k = 0; k < 4; k++) start[k] = random_direction(&r);
        for (int k = 0; k < 4; k++) end[k] = random_direction(&r);
        (i % 2 ? elementary_edge_edge : elementary_vertex_face)(start, end, i % 3 ? 0 : 0.01, &out);
        mix(&h[i % 2], (uint64_t)out.status << 40 | (uint64_t)out.proof << 32 | (uint32_t)out.steps);
        mix_number(&h[i % 2], out.t_lo);
        mix_number(&h[i % 2], out.t_hi);
        mix_number(&h[i % 2], out.gap);
    }
    print("vertex", "face", h[0]);
    print("edge", "edge", h[1]);
}

/* `bits FILE [PART]`: into the file; of the random pairs one in PART, at most 36, for where each takes long. */
int main(int count, char **arguments)
{
    if (count >= 2 && !freopen(arguments[1], "w", stdout)) return 1;
    if (count >= 3) part = atoi(arguments[2]);
    if (part < 1 || part > MESH_PAIRS_EACH) return 2;
    cases_create();
    convex_pairs();
    mesh_pairs();
    deformable_pairs();
    print("world", "alone", world_bits(1, part));
    print("world", "shared", world_bits(3, part));
    cases_destroy();
    return ferror(stdout) || fclose(stdout) != 0;
}
