/* events_impact: what the searches of a tick mean to each subscription: impact; predicted, averted. In the order of the
 * searches, which is that of active pairs and of subscription ids. Tick thread. */
#include "events.h"

static void fill_sweep(const world *w, const sweep *s, world_event *e)
{
    const pair *p = &w->pairs.at[w->active_pairs.at[s->active]];
    const collider *a = &w->colliders.at[p->a], *b = &w->colliders.at[p->b];
    const body *x = &w->bodies.at[a->body], *y = &w->bodies.at[b->body];
    const toi_result *r = &s->result;
    *e = (world_event){.name_a = x->name,
        .name_b = y->name,
        .shape_a = a->index,
        .shape_b = b->index,
        .lo = r->gap_lo,
        .hi = r->gap_hi,
        .axis = r->axis,
        .point_a = r->point_a,
        .point_b = r->point_b,
        .age_a_ns = body_age_ns(w, x),
        .age_b_ns = body_age_ns(w, y),
        .achieved = r->status == TOI_HIT    ? WORLD_CERTAIN
                    : r->status == TOI_NEAR ? WORLD_WITHIN
                                            : WORLD_WIDE,
        .impact = {r->lo, r->hi, s->start_ns, r->body_a, r->body_b, s->estimated},
        .closing = r->closing};
    if (events_is_turned(w, x, y, s->subscription, pair_kept_terms(p).looks)) events_turn_round(e);
}

static void report_impact(world *w, const sweep *s)
{
    if (s->result.status == TOI_FREE || s->began) return;
    world_event e;
    fill_sweep(w, s, &e);
    events_emit(w, s->subscription, &e, EVENT_IMPACT, CAUSE_MOTION, ++w->serial);
    w->figures.impacts++;
}

static void report_averted(world *w, uint32_t id)
{
    watch *v = &w->watches.at[id];
    if (!v->predicted_id) return;
    events_emit(w, v->subscription, &w->last_predicted.at[id], EVENT_AVERTED, CAUSE_MOTION, v->predicted_id);
    v->predicted_id = 0;
    v->predicted_dirty = false;
    if (!watch_id(v)) watch_drop(w, id);
}

/* It is known again before anything else of it is reported. What it touches or is near to was decided this tick. */
static void make_known(world *w, const sweep *s, uint32_t id)
{
    watch *v = &w->watches.at[id];
    if (!v->unknown) return;
    v->unknown = false;
    v->recovered = true;
    const pair *p = &w->pairs.at[v->pair];
    uint32_t result = w->outcomes.at[s->active].result;
    if ((v->touch_id || v->near_id) && result != WORLD_NONE) {
        const subscription *i = &w->subscriptions.at[v->subscription];
        world_event now;
        events_fill(w, p, &w->results.at[result], v->subscription, pair_kept_terms(p).looks, &now);
        now.achieved = events_achieved(&w->results.at[result], &w->outcomes.at[s->active],
            (v->touch_id ? i->threshold : i->range) + i->hysteresis);
        watch_keep_contact(w, id, &now);
    } else if (s->result.status != TOI_FREE) {
        world_event now;
        fill_sweep(w, s, &now);
        watch_keep_predicted(w, id, &now);
    }
    world_event last = watch_last(w, id);
    events_emit(w, v->subscription, &last, EVENT_KNOWN, CAUSE_MOTION, watch_id(v));
}

static void report_predicted(world *w, const sweep *s)
{
    uint32_t pair_id = w->active_pairs.at[s->active], id = watch_find(w, &w->pairs.at[pair_id], s->subscription);
    bool was_unknown = id != WORLD_NONE && w->watches.at[id].unknown;
    if (id != WORLD_NONE) make_known(w, s, id);
    if (s->result.status == TOI_FREE) {
        if (id != WORLD_NONE) report_averted(w, id);
        return;
    }
    if (id == WORLD_NONE) id = watch_add(w, pair_id, s->subscription);
    watch *v = &w->watches.at[id];
    subscription *i = &w->subscriptions.at[s->subscription];
    world_event now;
    fill_sweep(w, s, &now);
    bool is_new = !v->predicted_id;
    const world_event *last = &w->last_predicted.at[id];
    bool news = is_new || was_unknown || !news_same_facts(last, &now) || !news_same_impact(&last->impact, &now.impact);
    watch_keep_predicted(w, id, &now);
    if (is_new) {
        v->predicted_id = ++w->serial;
        w->figures.predicted++;
    }
    if (!news && !v->predicted_dirty && !i->all) return;
    if (is_new || events_may_update(w, i)) {
        v->predicted_dirty = false;
        events_emit(w, s->subscription, &now, EVENT_PREDICTED, CAUSE_MOTION, v->predicted_id);
    } else if (!v->predicted_dirty) {
        v->predicted_dirty = true;
        watch_hold_back(w, id);
    }
}

void events_of_sweeps(world *w)
{
    for (size_t k = 0; k < w->sweeps.count; k++) {
        if (w->sweeps.at[k].put_off) continue;
        if (w->sweeps.at[k].predicts)
            report_predicted(w, &w->sweeps.at[k]);
        else
            report_impact(w, &w->sweeps.at[k]);
    }
}
