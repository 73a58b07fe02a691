/* feed: what the daemon tells. The scene is observed while some page is open, pairs are watched while some page looks
 * at them; nobody looks: nothing is asked for. */
#include "foxview.h"
#include "web.h"

#include <math.h>
#include <string.h>
#include <time.h>

static void on_scene(void *context, const collided_scene *scene)
{
    web *w = context;
    mirror_scene(w->mirror, scene);
    w->pose_states++;
}

static void on_batch(void *context, const collided_batch *batch)
{
    web *w = context;
    mirror_batch(w->mirror, batch);
    w->contact_states += !batch->heartbeat;
}

static void observe(web *w)
{
    collided_observation_def def = collided_observation_def_default();
    def.rate_hz = w->options.rate_hz;
    def.callback = on_scene;
    def.context = w;
    w->observation = collided_observe(w->client, &def);
    w->observes = w->observation.id != COLLIDED_NONE;
}

static void watch(web *w)
{
    collided_subscription_def def = collided_subscription_def_default();
    def.facts = COLLIDED_TOUCH | COLLIDED_DISTANCE | COLLIDED_IMPACT | COLLIDED_POSES;
    if (w->options.horizon_s > 0) def.facts |= COLLIDED_PREDICT;
    def.range_m = w->options.range_m;
    def.horizon_s = w->options.horizon_s;
    def.tolerance_m = w->options.tolerance_m;
    def.rate_hz = w->options.rate_hz;
    def.callback = on_batch;
    def.context = w;
    w->contacts = collided_subscribe(w->client, &def);
    w->watches = w->contacts.id != COLLIDED_NONE;
}

void feed_watch(web *w)
{
    bool looks = false, watches = false;
    for (const viewer *v = w->viewers; v; v = v->next) {
        looks |= v->known;
        watches |= v->subscribed && (v->contacts || v->events);
    }
    foxview_needs(w, &looks, &watches);
    if (looks && !w->observes) observe(w);
    if (!looks && w->observes) {
        (void)collided_unsubscribe(w->client, w->observation);
        w->observes = false;
        mirror_forget(w->mirror);
    }
    if (watches && !w->watches) watch(w);
    if (!watches && w->watches) {
        (void)collided_unsubscribe(w->client, w->contacts);
        w->watches = false;
        mirror_forget_contacts(w->mirror);
    }
    collided_flush(w->client);
}

static void follow_daemon(web *w)
{
    collided_daemon_status s;
    bool heard = collided_get_status(w->client, 0, &s) == COLLIDED_OK;
    int64_t epoch = heard ? s.epoch : w->epoch;
    bool other = heard && w->epoch && epoch >> 16 != w->epoch >> 16;              /* another line: wire.h */
    if (other && w->mirror->epoch >> 16 != epoch >> 16) mirror_forget(w->mirror); /* its scene has not come yet */
    w->connected = heard;
    w->epoch = epoch;
}

void feed_poll(web *w)
{
    bool before = w->connected;
    bool heard = collided_poll(w->client, 0) == COLLIDED_OK;
    bool other = w->mirror->epoch && w->mirror->epoch >> 16 != w->epoch >> 16; /* it came back before it was missed */
    if (heard != before || !w->epoch || other) follow_daemon(w);
    w->connected = heard && w->epoch;
    collided_flush(w->client);
    viewer_news(w);
    foxview_news(w);
}
