/* impact_ours: toi_find, without a cached direction, as for a pair that is asked about for the first time. */
#include "impact_scene.h"
#include "narrow/toi.h"

#include <math.h>
#include <stdlib.h>

typedef struct search {
    toi_mover a, b;
    toi_request request;
} search;

typedef struct ours {
    search *searches;
    shape *shapes; /* two a search */
    narrow_scratch *scratch;
} ours;

static bool takes(narrow_kind a, narrow_kind b)
{
    (void)a, (void)b;
    return true;
}

static void *create(const impact_item *items, size_t count)
{
    ours *o = calloc(1, sizeof *o);
    if (!o) abort();
    o->searches = calloc(count, sizeof *o->searches);
    o->shapes = calloc(count, 2 * sizeof *o->shapes);
    o->scratch = aligned_alloc(64, narrow_scratch_size());
    if (!o->searches || !o->shapes || !o->scratch) abort();
    for (size_t i = 0; i < count; i++) {
        shape *a = &o->shapes[2 * i], *b = a + 1;
        *a = narrow_scene_shape(items[i].a);
        *b = narrow_scene_shape(items[i].b);
        toi_mover ma = {a, POSE_IDENTITY, impact_scene_motion(&items[i].move_a)};
        toi_mover mb = {b, POSE_IDENTITY, impact_scene_motion(&items[i].move_b)};
        bool ordered = narrow_ordered(a, 0, b, 1);
        double size = shape_reach(a) + shape_reach(b);
        o->searches[i] = (search){
            ordered ? ma : mb, ordered ? mb : ma, {.span = items[i].span, .tolerance = IMPACT_TOLERANCE * size}};
    }
    return o;
}

static impact_answer ask(void *self, size_t item)
{
    const ours *o = self;
    const search *s = &o->searches[item];
    toi_result r;
    toi_find(&s->a, &s->b, &s->request, VEC_ZERO, o->scratch, &r);
    return (impact_answer){r.status == TOI_UNDECIDED, r.status != TOI_FREE, r.lo};
}

static void destroy(void *self)
{
    ours *o = self;
    free(o->searches);
    free(o->shapes);
    free(o->scratch);
    free(o);
}

const impact_peer impact_ours = {
    "collided", "toi_find, tolerance 1e-6 of the pair's size, no cached direction", true, takes, create, ask, destroy};
