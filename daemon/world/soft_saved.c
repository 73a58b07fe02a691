/* soft_saved: soft bodies and their steps under way, for another daemon that goes on with them. A step goes on where it
 * stood because it stops by counts alone: it is made again up to there. Tick thread. */
#include "soft_state.h"

#include <stdlib.h>

static void put_frame(bytes_out *to, const soft_frame *f, size_t count)
{
    uint8_t is = f->at != NULL;
    bytes_put(to, &is, 1);
    if (!is) return;
    bytes_put(to, f, sizeof *f);
    bytes_put(to, f->at, count * sizeof *f->at);
}

static void get_frame(bytes_in *from, soft_frame *f, size_t count)
{
    uint8_t is = 0;
    soft_drop_frame(f);
    if (!bytes_get(from, &is, 1) || !is) return;
    bytes_get(from, f, sizeof *f);
    f->at = NULL;
    if (from->broken || from->left < count * sizeof *f->at) return;
    f->at = base_alloc(count, sizeof *f->at);
    bytes_get(from, f->at, count * sizeof *f->at);
}

static void put_place(const world *w, bytes_out *to, const soft_place *p)
{
    const uint32_t ids[] = {p->body, p->collider, p->shadow, w->bodies.at[p->body].soft, p->under_way, p->asked};
    bytes_put(to, ids, sizeof ids);
    bytes_put(to, &p->frame, sizeof p->frame);
    bytes_put(to, &p->way_tick, sizeof p->way_tick);
    bytes_put(to, p->from, p->count * sizeof *p->from);
    bytes_put(to, p->at, p->count * sizeof *p->at);
    put_frame(to, &p->next, p->count);
    put_frame(to, &p->after, p->count);
    bytes_put_count(to, p->proposal_count);
    for (size_t i = 0; i < p->proposal_count; i++) put_frame(to, &p->proposals[i], p->count);
}

static uint32_t number_of(const world *w, const soft_place *p)
{
    return w->bodies.at[p->body].soft - 1;
}

static void put_job(const world *w, bytes_out *to, const soft_job *j)
{
    const uint64_t head[] = {j->places.count, j->asks.count, j->ask, j->begun, j->proposed, j->units,
        j->begun ? soft_step_units(j->step) : 0};
    bytes_put(to, head, sizeof head);
    for (size_t i = 0; i < j->places.count; i++) {
        uint32_t n = number_of(w, j->places.at[i]);
        bytes_put(to, &n, sizeof n);
    }
    for (size_t i = 0; i < j->asks.count; i++) {
        const soft_asked *a = &j->asks.at[i];
        const uint64_t what[] = {a->want, a->most, a->pairs.count};
        bytes_put(to, &a->separation, sizeof a->separation);
        bytes_put(to, what, sizeof what);
        bytes_put(to, a->pairs.at, a->pairs.count * sizeof *a->pairs.at);
    }
    if (j->proposed) put_frame(to, &j->proposal, j->places.at[0]->count);
}

void soft_save(const world *w, bytes_out *to)
{
    const struct soft_world *s = w->soft;
    bytes_put_count(to, s->count);
    for (size_t i = 0; i < s->places.count; i++)
        if (s->places.at[i]) put_place(w, to, s->places.at[i]);
    bytes_put_count(to, s->jobs.count);
    for (size_t i = 0; i < s->jobs.count; i++) put_job(w, to, s->jobs.at[i]);
}

static const char *get_place(bytes_in *from, world *w)
{
    uint32_t ids[6];
    if (!bytes_get(from, ids, sizeof ids)) return "a soft body is cut off";
    bool there = ids[0] < w->bodies.count && ids[1] < w->colliders.count && ids[2] < w->colliders.count &&
                 ids[3] >= 1 && ids[3] <= SOFT_BODIES_MAX && w->colliders.at[ids[1]].shape.soft &&
                 w->colliders.at[ids[2]].shape.soft;
    if (!there) return "a soft body is not there";
    while (w->soft->places.count < ids[3]) array_push(&w->soft->places, NULL);
    soft_place *p = soft_place_create(w, ids[0], ids[1], ids[2]);
    w->soft->places.at[ids[3] - 1] = p;
    w->bodies.at[ids[0]].soft = ids[3];
    w->soft->count++;
    p->under_way = ids[4] != 0, p->asked = ids[5] != 0;
    bytes_get(from, &p->frame, sizeof p->frame);
    bytes_get(from, &p->way_tick, sizeof p->way_tick);
    bytes_get(from, p->from, p->count * sizeof *p->from);
    bytes_get(from, p->at, p->count * sizeof *p->at);
    get_frame(from, &p->next, p->count);
    get_frame(from, &p->after, p->count);
    p->proposal_count = bytes_get_count(from, 1);
    if (p->proposal_count > SOFT_PROPOSALS_MAX) {
        p->proposal_count = 0;
        return "a soft body has too many proposals";
    }
    for (size_t i = 0; i < p->proposal_count; i++) get_frame(from, &p->proposals[i], p->count);
    soft_measure(p);
    return from->broken ? "a soft body is cut off" : NULL;
}

static bool get_asks(bytes_in *from, soft_job *j, size_t count)
{
    for (size_t i = 0; i < count && !from->broken; i++) {
        soft_asked a = {.most = 0};
        uint64_t what[3] = {0};
        bytes_get(from, &a.separation, sizeof a.separation);
        bytes_get(from, what, sizeof what);
        a.want = (soft_want)what[0], a.most = (size_t)what[1];
        if (what[2] > from->left / sizeof *a.pairs.at) return false;
        array_reserve(&a.pairs, (size_t)what[2] + 1);
        bytes_get(from, a.pairs.at, (size_t)what[2] * sizeof *a.pairs.at);
        a.pairs.count = (size_t)what[2];
        for (size_t k = 0; k < a.pairs.count; k++)
            if (a.pairs.at[k].a >= j->places.count || a.pairs.at[k].b >= j->places.count)
                a.pairs.at[k] = (soft_pair){0, 0};
        array_push(&j->asks, a);
    }
    return !from->broken;
}

/* As far as it was. */
static void make_again(world *w, soft_job *j, size_t ask, bool begun, uint64_t units)
{
    for (; j->ask < ask || (begun && j->ask == ask && !j->begun); j->ask += j->ask < ask) {
        const soft_step_def def = soft_job_step(w, j);
        soft_status s = soft_step_begin(j->step, &def);
        bool last = j->ask == ask;
        j->begun = last;
        while (s == SOFT_OK && !(last && soft_step_units(j->step) >= units) && soft_step_run(j->step, 1) == SOFT_MORE) {
        }
        if (last) return;
        soft_take_results(j, false);
    }
}

static const char *get_job(bytes_in *from, world *w)
{
    uint64_t head[7];
    if (!bytes_get(from, head, sizeof head) || head[0] > from->left / sizeof(uint32_t)) return "a soft step is cut off";
    soft_job *j = soft_job_create(w);
    j->proposed = head[4] != 0;
    for (size_t i = 0; i < head[0]; i++) {
        uint32_t n;
        bytes_get(from, &n, sizeof n);
        if (n >= w->soft->places.count || !w->soft->places.at[n]) return "a soft step's body is not there";
        array_push(&j->places, w->soft->places.at[n]);
    }
    if (!j->places.count || !get_asks(from, j, (size_t)head[1])) return "a soft step is cut off";
    if (j->proposed) get_frame(from, &j->proposal, j->places.at[0]->count);
    if (from->broken || (j->proposed && !j->proposal.at) || head[2] > j->asks.count) return "a soft step is cut off";
    soft_job_place(j);
    make_again(w, j, (size_t)head[2], head[3] && head[2] < j->asks.count, head[6]);
    j->units = head[5];
    return NULL;
}

const char *soft_restore(world *w, bytes_in *from)
{
    const char *wrong = NULL;
    size_t places = bytes_get_count(from, 1);
    for (size_t i = 0; i < places && !wrong; i++) wrong = get_place(from, w);
    size_t jobs = wrong ? 0 : bytes_get_count(from, 1);
    for (size_t i = 0; i < jobs && !wrong; i++) wrong = get_job(from, w);
    return wrong;
}
