/* impact_ours: toi_find, without a cached direction, as for a pair that is asked about for the first time. */
#include "impact_scene.h"
#include "toi/toi.h"

#include <math.h>
#include <stdlib.h>

typedef struct search {
    shape shapes[2];
    toi_mover movers[2];
    toi_request request;
} search;

typedef struct ours {
    search *searches;
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
    o->scratch = aligned_alloc(64, narrow_scratch_size());
    if (!o->searches || !o->scratch) abort();
    for (size_t i = 0; i < count; i++) {
        search *s = &o->searches[i];
        impact_scene_movers(&items[i], s->shapes, s->movers);
        double size = shape_reach(&s->shapes[0]) + shape_reach(&s->shapes[1]);
        s->request = (toi_request){.span = items[i].span, .tolerance = IMPACT_TOLERANCE * size};
    }
    return o;
}

static impact_answer ask(void *self, size_t item)
{
    const ours *o = self;
    const search *s = &o->searches[item];
    toi_result r;
    toi_find(&s->movers[0], &s->movers[1], &s->request, VEC_ZERO, o->scratch, &r);
    return (impact_answer){r.status == TOI_UNDECIDED, r.status != TOI_FREE, r.lo};
}

static void destroy(void *self)
{
    ours *o = self;
    free(o->searches);
    free(o->scratch);
    free(o);
}

const impact_peer impact_ours = {"collided", "toi_find, tolerance 1e-6 of the pair's size, no cached direction", true,
    takes, create, ask, destroy, "toi_find"};
