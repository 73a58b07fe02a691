/* soft_saved: soft bodies, their steps under way and results that wait, for another daemon that goes on with them. A
 * step goes on where it stood because its portions follow from counts alone: they are made again up to there. Tick
 * thread. */
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
    f->box = soft_box_of(f->at, count);
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

typedef struct job_head {
    uint64_t places, acts, asks, besides, ask, placed, asking, units, units_before, portions;
    uint8_t stage, proposed, stands, gathered;
} job_head;

static void put_job(const world *w, bytes_out *to, const soft_job *j)
{
    bool steps = j->stage > SOFT_ASKING;
    job_head head = {.places = j->places.count, .acts = j->acts.count, .asks = j->asks.count};
    head.besides = j->besides.count, head.ask = j->ask, head.placed = j->placed, head.asking = j->asking;
    head.units = j->units, head.units_before = j->units_before, head.portions = j->portions;
    head.stage = steps ? SOFT_STEPPING : (uint8_t)j->stage;
    head.proposed = j->proposed, head.stands = j->stands, head.gathered = j->gathered;
    bytes_put(to, &head, sizeof head);
    for (size_t i = 0; i < j->places.count; i++) {
        uint32_t n = number_of(w, j->places.at[i]);
        bytes_put(to, &n, sizeof n);
    }
    bytes_put(to, j->acts.at, j->acts.count);
    bytes_put(to, j->besides.at, j->besides.count * sizeof *j->besides.at);
    for (size_t i = 0; i < j->asks.count; i++) {
        const soft_asked *a = &j->asks.at[i];
        const uint64_t what[] = {a->want, a->most, a->pairs.count};
        bytes_put(to, &a->separation, sizeof a->separation);
        bytes_put(to, what, sizeof what);
        bytes_put(to, a->pairs.at, a->pairs.count * sizeof *a->pairs.at);
    }
    if (j->proposed) put_frame(to, &j->proposal, j->places.at[0]->count);
}

static void put_result(bytes_out *to, const soft_result *r)
{
    bytes_put(to, r, sizeof *r);
    bytes_put(to, r->contacts, r->count * sizeof *r->contacts);
    bytes_put(to, r->touches, r->count * sizeof *r->touches);
}

void soft_save(const world *w, bytes_out *to)
{
    const struct soft_world *s = w->soft;
    bytes_put_count(to, s->count);
    for (size_t i = 0; i < s->places.count; i++)
        if (s->places.at[i]) put_place(w, to, s->places.at[i]);
    bytes_put_count(to, s->jobs.count);
    for (size_t i = 0; i < s->jobs.count; i++) put_job(w, to, s->jobs.at[i]);
    bytes_put_count(to, s->results.count);
    for (size_t i = 0; i < s->results.count; i++) put_result(to, &s->results.at[i]);
    bytes_put_count(to, s->accounts.count);
    bytes_put(to, s->accounts.at, s->accounts.count * sizeof *s->accounts.at);
    bytes_put(to, &s->clear_tick, sizeof s->clear_tick);
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

static const char *get_members(bytes_in *from, world *w, soft_job *j, const job_head *h)
{
    for (size_t i = 0; i < h->places; i++) {
        uint32_t n = UINT32_MAX;
        bytes_get(from, &n, sizeof n);
        if (n >= w->soft->places.count || !w->soft->places.at[n]) return "a soft step's body is not there";
        array_push(&j->places, w->soft->places.at[n]);
    }
    if (h->acts > from->left || h->besides > from->left / sizeof *j->besides.at) return "a soft step is cut off";
    array_reserve(&j->acts, (size_t)h->acts + 1), array_reserve(&j->besides, (size_t)h->besides + 1);
    bytes_get(from, j->acts.at, (size_t)h->acts);
    bytes_get(from, j->besides.at, (size_t)h->besides * sizeof *j->besides.at);
    j->acts.count = (size_t)h->acts, j->besides.count = (size_t)h->besides;
    for (size_t i = 0; i < j->besides.count; i++)
        if (j->besides.at[i].rigid != WORLD_NONE && j->besides.at[i].rigid >= w->colliders.count)
            return "a soft step's rigid shape is not there";
    return j->places.count ? NULL : "a soft step is of nothing";
}

/* As far as it was. */
static const char *make_again(world *w, soft_job *j, const job_head *h)
{
    uint64_t unfinished = w->figures.soft_unfinished;
    for (uint32_t i = 0; i < h->placed && i < j->places.count; i++) soft_job_place(j, i);
    j->placed = (size_t)h->placed, j->asking = (size_t)h->asking, j->stage = (soft_stage)h->stage;
    j->units = j->units_before = h->units_before;
    if (h->stands) j->stage = SOFT_BESIDE;
    if (j->stage < SOFT_STEPPING) {
        j->units = h->units;
        bool fits = j->placed <= j->places.count && j->asking < j->places.count && j->acts.count <= j->places.count;
        return fits ? NULL : "a soft step has no such stage";
    }
    while (j->portions < h->portions && j->stage != SOFT_DONE) soft_job_portion(w, j);
    w->figures.soft_unfinished = unfinished;
    return NULL;
}

static const char *get_job(bytes_in *from, world *w)
{
    job_head h;
    if (!bytes_get(from, &h, sizeof h) || h.places > from->left / sizeof(uint32_t)) return "a soft step is cut off";
    soft_job *j = soft_job_create(w);
    j->proposed = h.proposed != 0, j->stands = h.stands != 0, j->gathered = h.gathered != 0;
    const char *wrong = get_members(from, w, j, &h);
    if (wrong) return wrong;
    if (!get_asks(from, j, (size_t)h.asks)) return "a soft step is cut off";
    if (j->proposed) get_frame(from, &j->proposal, j->places.at[0]->count);
    if (from->broken || (j->proposed && !j->proposal.at)) return "a soft step is cut off";
    if (j->stands) j->places.at[0]->beside = j;
    return make_again(w, j, &h);
}

static const char *get_result(bytes_in *from, world *w)
{
    soft_result r;
    if (!bytes_get(from, &r, sizeof r) || r.a >= w->colliders.count || r.b >= w->colliders.count ||
        r.count > from->left / (sizeof *r.contacts + sizeof *r.touches))
        return "a soft result is cut off";
    r.contacts = base_alloc(r.count + 1, sizeof *r.contacts), r.touches = base_alloc(r.count + 1, sizeof *r.touches);
    bytes_get(from, r.contacts, r.count * sizeof *r.contacts);
    bytes_get(from, r.touches, r.count * sizeof *r.touches);
    array_push(&w->soft->results, r);
    return NULL;
}

const char *soft_restore(world *w, bytes_in *from)
{
    const char *wrong = NULL;
    size_t places = bytes_get_count(from, 1);
    for (size_t i = 0; i < places && !wrong; i++) wrong = get_place(from, w);
    size_t jobs = wrong ? 0 : bytes_get_count(from, 1);
    for (size_t i = 0; i < jobs && !wrong; i++) wrong = get_job(from, w);
    size_t results = wrong ? 0 : bytes_get_count(from, sizeof(soft_result));
    for (size_t i = 0; i < results && !wrong; i++) wrong = get_result(from, w);
    if (wrong) return wrong;
    size_t accounts = bytes_get_count(from, sizeof *w->soft->accounts.at);
    array_reserve(&w->soft->accounts, accounts + 1);
    bytes_get(from, w->soft->accounts.at, accounts * sizeof *w->soft->accounts.at);
    w->soft->accounts.count = accounts;
    bytes_get(from, &w->soft->clear_tick, sizeof w->soft->clear_tick);
    return from->broken ? "soft bodies are cut off" : NULL;
}
