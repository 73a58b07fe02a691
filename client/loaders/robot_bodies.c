/* robot_bodies: links to bodies, disabled pairs to rules. The result depends on the files alone. One thread a pool. */
#include "robot.h"
#include "text.h"

#include <string.h>

const char *robot_body_name(const robot *b, int link, pool *p)
{
    return pool_format(p, "%s%s", b->source.prefix ? b->source.prefix : "", b->model.links[link].name);
}

static bool add_rule(const robot *b, load_body *body, int other, const char *reason, pool *p, load_report *r)
{
    if (b->model.links[other].shape_count == 0) return true; /* it has no body */
    if (body->rule_count == LOAD_RULES_MAX)
        return load_fail(r, "%s: link '%s' has more than %d disabled pairs",
            b->source.srdf ? b->source.srdf : b->model.file, body->name, LOAD_RULES_MAX);
    body->rules[body->rule_count++] =
        (collided_rule){.pattern = robot_body_name(b, other, p), .allow = true, .reason = reason};
    return true;
}

/* Each pair stands at both of its bodies: either may be changed or removed on its own. */
static bool rules_of_srdf(const robot *b, int link, load_body *body, pool *p, load_report *r)
{
    for (int i = 0; i < b->semantics.disabled_count; i++) {
        const srdf_disabled *d = &b->semantics.disabled[i];
        if (d->link1 != link && d->link2 != link) continue;
        int other = d->link1 == link ? d->link2 : d->link1;
        if (!add_rule(b, body, other, pool_format(p, "SRDF: %s", d->reason), p, r)) return false;
    }
    return true;
}

static bool rules_of_apart(const robot *b, int link, load_body *body, pool *p, load_report *r)
{
    for (size_t i = 0; i < b->source.apart_count; i++) {
        const robot_apart *d = &b->source.apart[i];
        int one = urdf_find_link(&b->model, d->link1), two = urdf_find_link(&b->model, d->link2);
        if (one != link && two != link) continue;
        if (!add_rule(b, body, one == link ? two : one, d->reason, p, r)) return false;
    }
    return true;
}

/* For each link the next one above it that has a body; -1 = none. */
static int *bodies_above(const urdf *u, pool *p)
{
    int *above = pool_alloc(p, (size_t)u->link_count, sizeof *above);
    above[u->root] = -1;
    for (int i = 0; i < u->joint_count; i++) {
        const urdf_joint *j = &u->joints[u->order[i]];
        above[j->child] = u->links[j->parent].shape_count > 0 ? j->parent : above[j->parent];
    }
    return above;
}

static bool rules_of_joints(const robot *b, int link, const int *above, load_body *body, pool *p, load_report *r)
{
    for (int i = 0; i < b->model.link_count; i++)
        if ((above[i] == link || above[link] == i) && !add_rule(b, body, i, "adjacent in the URDF", p, r)) return false;
    return true;
}

static bool find_meshes(const robot *b, const urdf_link *link, load_body *body, pool *p, load_report *r)
{
    const char *folder = text_folder(p, b->source.urdf);
    const char *where = pool_format(p, "%s:%d", b->model.file, link->line);
    for (size_t i = 0; i < body->shape_count; i++) {
        load_shape *s = &body->shapes[i];
        if (!s->mesh) continue;
        s->mesh = package_resolve(p, s->mesh, folder, b->source.packages, b->source.package_count, where, r);
        if (!s->mesh) return false;
        load_shape_becomes(s, &b->source.meshes);
    }
    return true;
}

static const robot_link_shapes *shapes_instead(const robot *b, const urdf_link *link)
{
    for (size_t i = 0; i < b->source.link_count; i++)
        if (strcmp(b->source.links[i].link, link->name) == 0) return &b->source.links[i];
    return NULL;
}

static bool take_link_shapes(const robot *b, const urdf_link *link, load_body *out, pool *p, load_report *r)
{
    const robot_link_shapes *instead = shapes_instead(b, link);
    const load_shape *from = instead ? instead->shapes : link->shapes;
    out->shape_count = instead ? instead->shape_count : link->shape_count;
    out->shapes = pool_alloc(p, out->shape_count, sizeof *out->shapes);
    memcpy(out->shapes, from, out->shape_count * sizeof *out->shapes);
    return (instead || find_meshes(b, link, out, p, r)) && load_body_meshes(p, out, r);
}

/* Names that the scene gives must be those of links that have a body. */
static bool check_link(const robot *b, const char *name, load_report *r)
{
    int link = urdf_find_link(&b->model, name);
    if (link < 0) return load_fail(r, "the link '%s' is not in %s", name, b->model.file);
    return b->model.links[link].shape_count > 0 ||
           load_fail(r, "%s:%d: the link '%s' has no collision geometry, so it has no body", b->model.file,
               b->model.links[link].line, name);
}

static bool check_source(const robot *b, load_report *r)
{
    for (size_t i = 0; i < b->source.link_count; i++) {
        if (!check_link(b, b->source.links[i].link, r)) return false;
        for (size_t k = 0; k < i; k++)
            if (strcmp(b->source.links[i].link, b->source.links[k].link) == 0)
                return load_fail(r, "shapes of the link '%s' are given twice", b->source.links[i].link);
    }
    for (size_t i = 0; i < b->source.apart_count; i++)
        if (!check_link(b, b->source.apart[i].link1, r) || !check_link(b, b->source.apart[i].link2, r)) return false;
    return true;
}

static bool make_body(const robot *b, int index, const int *above, load_body *out, pool *p, load_report *r)
{
    const urdf_link *link = &b->model.links[index];
    out->name = robot_body_name(b, index, p);
    const char *fault = text_name_fault(out->name);
    if (fault) return load_fail(r, "the name '%s' %s: choose another --prefix", out->name, fault);
    out->group = b->model.name;
    size_t most = (size_t)(b->source.srdf ? b->semantics.disabled_count : b->model.link_count) + b->source.apart_count;
    out->rules = pool_alloc(p, most < LOAD_RULES_MAX ? most : LOAD_RULES_MAX, sizeof *out->rules);
    bool ruled = rules_of_apart(b, index, out, p, r) &&
                 (b->source.srdf ? rules_of_srdf(b, index, out, p, r) : rules_of_joints(b, index, above, out, p, r));
    return ruled && take_link_shapes(b, link, out, p, r);
}

bool robot_bodies(const robot *b, collided_pose base, const double *values, collided_motion motion, pool *p,
    load_bodies *out, load_report *r)
{
    size_t count = robot_body_count(b);
    *out = (load_bodies){pool_alloc(p, count, sizeof *out->at), 0};
    if (!check_source(b, r)) return false;
    collided_pose *poses = pool_alloc(p, count, sizeof *poses);
    robot_body_poses(b, base, values, poses);
    const int *above = bodies_above(&b->model, p);
    for (int i = 0; i < b->model.link_count; i++) {
        if (b->model.links[i].shape_count == 0) continue;
        load_body *body = &out->at[out->count];
        if (!make_body(b, i, above, body, p, r)) return false;
        body->pose = poses[out->count++];
        body->motion = motion;
        body->category = 1;
        body->mask = UINT64_MAX;
    }
    return true;
}
