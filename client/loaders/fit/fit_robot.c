/* fit_robot: link by link, then pair by pair. */
#include "fit_robot.h"

#include "fit_cost.h"
#include "loaders/rigid.h"

#include <math.h>
#include <string.h>

typedef struct fitting {
    pool *pool;
    const robot *robot;
    const fit_options *options;
    fit_robot *out;
    size_t done, of;
} fitting;

static void tell(fitting *f, const char *what)
{
    if (f->options->progress) f->options->progress(f->options->context, f->done, f->of, what);
    f->done++;
}

static void fit_links(fitting *f, const load_bodies *bodies)
{
    fit_robot *out = f->out;
    for (int link = 0; link < f->robot->model.link_count; link++) {
        if (f->robot->model.links[link].shape_count == 0) continue;
        fit_link *to = &out->links[out->link_count];
        tell(f, f->robot->model.links[link].name);
        fit_link_make(f->pool, &bodies->at[out->link_count++], f->options->excess_m, to);
        to->name = f->robot->model.links[link].name;
        to->link = link;
    }
}

static const char *disabled_by(const robot *r, int a, int b)
{
    for (int i = 0; i < r->semantics.disabled_count; i++) {
        const srdf_disabled *d = &r->semantics.disabled[i];
        if ((d->link1 == a && d->link2 == b) || (d->link1 == b && d->link2 == a)) return d->reason;
    }
    return NULL;
}

static void look_at_pair(fitting *f, int a, int b)
{
    fit_robot *out = f->out;
    const fit_link *one = &out->links[a], *two = &out->links[b];
    fit_pair *pair = &out->pairs[out->pair_count++];
    size_t most = f->options->boxes_max ? f->options->boxes_max : NEVER_BOXES_DEFAULT;
    *pair = (fit_pair){.a = a, .b = b, .disabled = disabled_by(f->robot, one->link, two->link)};
    tell(f, pool_format(f->pool, "%s and %s", one->name, two->name));
    never_meet_find(&f->robot->model, one->link, one->convex, one->convex_count, two->link, two->convex,
        two->convex_count, most, &pair->answer);
    if (pair->disabled) return;
    double before = fit_cost_of_pair(one->before, one->before_count, two->before, two->before_count);
    double now = fit_cost_of_pair(one->shapes, one->shape_count, two->shapes, two->shape_count);
    out->ns_before += before;
    out->ns_shapes += now;
    if (pair->answer.verdict != NEVER_PROVEN) out->ns += now;
}

bool fit_robot_make(pool *p, const robot *r, const fit_options *options, fit_robot *out, load_report *report)
{
    size_t count = robot_body_count(r), pairs = count > 0 ? count * (count - 1) / 2 : 0;
    double *values = pool_alloc(p, (size_t)r->model.joint_count, sizeof *values);
    load_bodies bodies;
    *out = (fit_robot){.robot = r};
    robot_default_values(r, values);
    if (!robot_bodies(r, rigid_identity(), values, COLLIDED_MOVING, p, &bodies, report)) return false;
    out->links = pool_alloc(p, count, sizeof *out->links);
    out->pairs = pool_alloc(p, pairs, sizeof *out->pairs);
    fitting f = {p, r, options, out, 0, count + pairs};
    fit_links(&f, &bodies);
    for (int a = 0; a < (int)count; a++)
        for (int b = a + 1; b < (int)count; b++) look_at_pair(&f, a, b);
    return true;
}
