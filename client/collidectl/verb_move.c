/* verb_move: moves, and removes, bodies that an earlier run created. */
#include "loaders/text.h"
#include "options.h"
#include "store.h"
#include "store_file.h"
#include "verbs.h"

#include <stdio.h>
#include <string.h>
#include <sysexits.h>

/* A pose is not acknowledged: ask for the body behind it, and any refusal has come before the answer. */
static int confirm_body(ctl *c, const char *name)
{
    collided_result result = {0};
    int status = ctl_check(c, collided_query_bodies(c->client, name, c->options.timeout_s, &result), "move");
    if (!status && c->rejected[0])
        status = ctl_fail(EX_DATAERR, "move: the daemon refused: %s", c->rejected);
    else if (!status && result.count == 0)
        status = ctl_fail(EX_DATAERR, "move: the daemon has no body '%s' (was it restarted?): load it again", name);
    collided_result_free(&result);
    return status;
}

static collided_status publish_pose(const ctl *c, collided_body body, const collided_pose *pose)
{
    const ctl_options *o = &c->options;
    const double *linear = o->has_linear ? o->linear : NULL, *angular = o->has_angular ? o->angular : NULL;
    return (o->teleport ? collided_teleport : collided_publish)(
        c->client, 1, &body, pose->position, pose->orientation, linear, angular, 0, 0);
}

static int move(ctl *c, const store *s, collided_pose pose)
{
    const char *name = c->arguments[0];
    int32_t id = store_find(s, name);
    if (id < 0)
        return ctl_fail(EX_DATAERR, "move: '%s' was not loaded as '%s': see 'collidectl query bodies', or give --as",
            name, c->options.as);
    int status = ctl_connect_owner(c);
    if (status) return status;
    collided_body body = collided_adopt_body(c->client, id);
    status = ctl_check(c, publish_pose(c, body, &pose), "move");
    collided_flush(c->client);
    return status ? status : confirm_body(c, name);
}

int verb_move(ctl *c)
{
    collided_pose pose;
    if (!options_pose(c->arguments[1], &pose))
        return ctl_fail(EX_USAGE, "move: '%s': must be X,Y,Z or X,Y,Z,W,X,Y,Z with a unit quaternion", c->arguments[1]);
    store s;
    int status = store_open(&s, c);
    if (status) return status;
    status = move(c, &s, pose);
    ctl_disconnect(c);
    store_close(&s);
    return status;
}

static int remove_matching(ctl *c, store *s)
{
    size_t kept = 0, removed = 0;
    int status = ctl_connect_owner(c);
    for (size_t i = 0; i < s->body_count && !status; i++) {
        if (!text_matches(c->arguments[0], s->bodies[i].name)) {
            s->bodies[kept++] = s->bodies[i];
            continue;
        }
        collided_body body = collided_adopt_body(c->client, s->bodies[i].id);
        status = ctl_check(c, collided_remove_body(c->client, body), "remove");
        if (!status) printf("%s\n", s->bodies[i].name);
        removed++;
    }
    if (!status) status = ctl_check(c, collided_sync(c->client, c->options.timeout_s), "remove");
    if (status) return status;
    s->body_count = kept;
    return removed
               ? store_save(s)
               : ctl_fail(EX_DATAERR, "remove: nothing loaded as '%s' matches '%s'", c->options.as, c->arguments[0]);
}

int verb_remove(ctl *c)
{
    store s;
    int status = store_open(&s, c);
    if (status) return status;
    status = remove_matching(c, &s);
    ctl_disconnect(c);
    store_close(&s);
    return status;
}
