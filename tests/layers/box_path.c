/* box_path: pairs of boxes are followed frame by frame, and asked for their distance as a tick asks (world/cascade.c):
 * first the motion bound, then axes, then narrow_query with what the pair remembers. box_path.py counts the functions
 * that this enters, without those of each pair's first frame. The argument 1 asks for distances of boxes; 2 asks for
 * verdicts of balls, capsules and boxes. One thread. */
#include "geom/bounds.h"
#include "narrow/narrow.h"

#include <stdlib.h>

extern void __gcov_reset(void);
extern void __gcov_dump(void);

enum { PAIRS = 1500, FRAMES = 8 };

typedef struct moving {
    shape a, b;
    pose at;
    vec3 step;
    quat turn;
    narrow_cache cache;
} moving;

static uint64_t state = 20261127;

static double draw(double from, double to)
{
    state = state * 6364136223846793005u + 1442695040888963407u;
    return from + (to - from) * (double)(state >> 11) * 0x1p-53;
}

static vec3 draw_vector(double most)
{
    return vec(draw(-most, most), draw(-most, most), draw(-most, most));
}

static quat small_turn(double most)
{
    vec3 v = draw_vector(most);
    return quat_settled((quat){1, v.x, v.y, v.z});
}

static shape draw_shape(shape_type type)
{
    vec3 half = vec(draw(0.1, 1), draw(0.1, 1), draw(0.1, 1));
    if (type == SHAPE_SPHERE) return (shape){.type = type, .radius = half.x};
    if (type == SHAPE_CAPSULE) return (shape){.type = type, .radius = half.x, .half = vec(0, 0, half.z)};
    return (shape){.type = type, .half = half};
}

static void follow(moving *m, const narrow_request *request, narrow_scratch *scratch)
{
    narrow_result r;
    m->at.p = vec_add(m->at.p, m->step);
    m->at.q = quat_settled(quat_mul(m->turn, m->at.q));
    double limit = request->facts & NARROW_DISTANCE ? request->range : request->threshold, reach = shape_reach(&m->b);
    bool remembers = vec_norm2(m->cache.axis) > 0;
    if (remembers && m->cache.lower - narrow_motion_bound(&m->cache.b_in_a, &m->at, reach) > limit) return;
    if (narrow_apart(&m->a, &m->b, &m->at, limit, &m->cache)) return;
    narrow_query(&m->a, &m->b, &m->at, request, &m->cache, scratch, &r);
    if (!(r.lo <= r.hi)) abort();
}

int main(int count, char **arguments)
{
    static const shape_type TYPES[3] = {SHAPE_SPHERE, SHAPE_CAPSULE, SHAPE_BOX};
    static moving pairs[PAIRS];
    bool verdicts = count > 1 && *arguments[1] == '2';
    narrow_scratch *scratch = aligned_alloc(64, narrow_scratch_size());
    narrow_request request = {.facts = NARROW_DISTANCE, .tolerance = 1e-6, .range = 0.5};
    if (verdicts) request = (narrow_request){.facts = NARROW_VERDICT, .tolerance = 1e-6, .range = INFINITY};
    if (!scratch) abort();
    for (int i = 0; i < PAIRS; i++) {
        moving *m = &pairs[i];
        int a = verdicts ? i % 3 : 2, b = verdicts ? i / 3 % 3 : 2;
        m->a = draw_shape(TYPES[a < b ? a : b]), m->b = draw_shape(TYPES[a < b ? b : a]);
        m->at = (pose){draw_vector(1.5), small_turn(1)};
        m->step = draw_vector(0.002), m->turn = small_turn(0.005);
        follow(m, &request, scratch);
    }
    __gcov_reset();
    for (int frame = 1; frame < FRAMES; frame++)
        for (int i = 0; i < PAIRS; i++) follow(&pairs[i], &request, scratch);
    __gcov_dump();
    free(scratch);
    return 0;
}
