/* verb_load: files to bodies. All files are read, and found good, before the daemon hears of the first body; the store
 * is written when the daemon has accepted them. */
#include "loaders/decompose/decompose.h"
#include "loaders/placed.h"
#include "store.h"
#include "store_file.h"
#include "verbs.h"

#include <errno.h>
#include <math.h>
#include <stdio.h>
#include <string.h>
#include <sysexits.h>
#include <unistd.h>

typedef struct loading {
    ctl *c;
    store store;
    load_bodies *sets; /* of the scene, then of each robot */
    size_t set_count;
    placed_robot *robots;
    size_t robot_count;
} loading;

static bool ends_in(const char *text, const char *end)
{
    size_t length = strlen(text), tail = strlen(end);
    return length >= tail && strcmp(text + length - tail, end) == 0;
}

/* ---- reading ---- */

static bool read_urdf(loading *l, const char *path)
{
    ctl *c = l->c;
    const ctl_options *o = &c->options;
    load_meshes meshes = {0};
    if (o->meshes && !load_meshes_parse(o->meshes, &meshes))
        return load_fail(
            &c->report, "load: --meshes '%s': must be " LOAD_MESHES_WORDS, o->meshes, DECOMPOSE_PIECES_MAX);
    scene_robot from = {.source = {.urdf = path,
                            .srdf = o->srdf,
                            .prefix = o->prefix,
                            .packages = o->packages,
                            .package_count = o->package_count,
                            .meshes = meshes},
        .state = o->state,
        .pose = o->pose,
        .motion = o->fixed ? COLLIDED_FIXED : COLLIDED_MOVING};
    l->robots = pool_alloc(&c->pool, 1, sizeof *l->robots);
    if (!placed_robot_load(l->robots, &c->pool, &from, o->joints, &c->report)) return false;
    l->robot_count = l->set_count = 1;
    l->sets = &l->robots->links;
    return true;
}

static bool read_scene(loading *l, const char *path)
{
    ctl *c = l->c;
    placed_scene s;
    if (!placed_scene_load(&s, &c->pool, path, &c->report)) return false;
    l->robots = s.robots;
    l->robot_count = s.robot_count;
    l->sets = pool_alloc(&c->pool, s.robot_count + 1, sizeof *l->sets);
    l->sets[l->set_count++] = s.bodies;
    for (size_t i = 0; i < s.robot_count; i++) l->sets[l->set_count++] = s.robots[i].links;
    return true;
}

static int read_any(loading *l, const char *path)
{
    const ctl_options *o = &l->c->options;
    bool yaml = ends_in(path, ".yaml") || ends_in(path, ".yml");
    if (ends_in(path, ".xacro"))
        return ctl_fail(EX_USAGE,
            "load: '%s' is a xacro file, from which a URDF is made: run 'xacro %s > robot.urdf' (ROS) and load that",
            path, path);
    if (!yaml && !ends_in(path, ".urdf") && !ends_in(path, ".xml"))
        return ctl_fail(EX_USAGE, "load: '%s' is neither .urdf nor .yaml", path);
    if (yaml &&
        (o->srdf || o->prefix || o->state || o->joints || o->package_count || o->posed || o->fixed || o->meshes))
        return ctl_fail(EX_USAGE,
            "load: a scene says itself what --srdf, --package, --prefix, --pose, --state, --joints, "
            "--meshes and --fixed say for a URDF: write it into '%s'",
            path);
    if (access(path, R_OK) != 0) return ctl_fail(EX_NOINPUT, "load: %s: %s", path, strerror(errno));
    bool ok = yaml ? read_scene(l, path) : read_urdf(l, path);
    return ok ? 0 : ctl_fail_loading(l->c);
}

/* ---- telling the daemon ---- */

/* With --stay the bodies are this process's own, under numbers that nobody needs to know later. */
static int announce_bodies(loading *l)
{
    int32_t next = l->store.next_id;
    for (size_t k = 0; k < l->set_count; k++)
        for (size_t i = 0; i < l->sets[k].count; i++) {
            load_body *body = &l->sets[k].at[i];
            body->deadline_s = l->c->options.deadline_s;
            int32_t id = l->c->options.stay ? COLLIDED_NONE : store_id_for(&l->store, body->name, &next);
            if (load_body_announce(l->c->client, body, id).id != COLLIDED_NONE) continue;
            return ctl_fail(EX_DATAERR, "load: body '%s': %s", body->name, collided_error(l->c->client));
        }
    return ctl_check(l->c, collided_sync(l->c->client, l->c->options.timeout_s), "load");
}

static int remember(loading *l)
{
    int32_t next = l->store.next_id;
    for (size_t k = 0; k < l->set_count; k++)
        for (size_t i = 0; i < l->sets[k].count; i++) {
            const char *name = l->sets[k].at[i].name;
            store_put(&l->store, name, store_id_for(&l->store, name, &next));
        }
    for (size_t i = 0; i < l->robot_count; i++)
        store_put_robot(&l->store, &l->robots[i].robot, l->robots[i].base, l->robots[i].values);
    return store_save(&l->store);
}

/* How far its shapes reach beyond what the files have: hulls are convex, robots are not. */
static void print_excess(const load_body *b)
{
    double excess = load_body_excess(b);
    if (excess > 0) printf("  at most %.3g mm beyond its meshes", 1e3 * excess);
    if (isnan(excess)) printf("  not measured: how far its hulls reach beyond its meshes");
}

static void print_created(const loading *l)
{
    size_t bodies = 0;
    for (size_t k = 0; k < l->set_count; k++)
        for (size_t i = 0; i < l->sets[k].count; i++, bodies++) {
            const load_body *b = &l->sets[k].at[i];
            printf("%-32s %-6s %2zu shape%s %3zu rule%s at %9.4f %9.4f %9.4f", b->name,
                b->motion == COLLIDED_FIXED ? "fixed" : "moving", b->shape_count, b->shape_count == 1 ? " " : "s",
                b->rule_count, b->rule_count == 1 ? " " : "s", b->pose.position[0], b->pose.position[1],
                b->pose.position[2]);
            print_excess(b);
            putchar('\n');
        }
    printf("%zu bodies, %zu robots\n", bodies, l->robot_count);
    fflush(stdout);
}

static int create_and_stay(loading *l)
{
    ctl_catch_signals();
    int status = ctl_connect_guest(l->c);
    if (!status) status = announce_bodies(l);
    if (status) return status;
    print_created(l);
    return ctl_poll(l->c, 0);
}

static int create_and_leave(loading *l)
{
    int status = store_open(&l->store, l->c);
    if (status) return status;
    status = ctl_connect_owner(l->c);
    if (!status) status = announce_bodies(l);
    if (!status) status = remember(l);
    if (!status) print_created(l);
    ctl_disconnect(l->c); /* before another run may take over */
    store_close(&l->store);
    return status;
}

int verb_load(ctl *c)
{
    loading l = {.c = c};
    int status = read_any(&l, c->arguments[0]);
    if (status) return status;
    return c->options.stay ? create_and_stay(&l) : create_and_leave(&l);
}
