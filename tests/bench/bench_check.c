/* bench_check: configurations and edges of a robot, tried out by world_check as the service calls it: the shared
 * folder's motion problems (the Panda, its meshes as hulls), or, where that is not there, the project's own arm among
 * 20 boxes and cylinders. Edges of 1 rad (the length of the change of all joints) begin at free configurations. Each
 * free edge is sampled densely by the narrow phase's own queries, all pairs: "missed" counts those at which something
 * is met. With FCL (COLLIDED_PEERS) the same states, and the same edges sampled at 32 configurations a radian, as
 * planners sample them; its "missed" are edges that meet something, proven, and that no sample showed.
 * --full: more of all. One thread. */
#include "base/clock.h"
#include "bench.h"
#include "check_peer.h"
#include "loaders/robot.h"
#include "robot_world.h"
#include "world/checks.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

enum { LINKS_MAX = 64, STATES = 512, EDGES = 128, SCENES_MAX = 700, BOXES_MAX = 64 };

typedef struct arm { /* a robot in a world, as world_check wants it */
    pool pool;
    load_report report;
    robot robot;
    load_bodies bodies;
    robot_world geometry;
    world *w;
    robot_joint joints[LINKS_MAX];
    uint32_t ids[LINKS_MAX];
    size_t joint_count, coordinates;
    double lower[LINKS_MAX], upper[LINKS_MAX];
    uint32_t obstacles[BOXES_MAX];
    size_t obstacle_count;
    uint64_t random;
} arm;

typedef struct score {
    const char *kind;
    size_t items, verdicts[4], missed;
    int64_t ns;
} score;

typedef struct scores { /* ours, and a contender's */
    score states, edges, peer_states, peer_edges;
    size_t differ; /* states of which the contender says the opposite of what is proven */
} scores;

static void must(bool good, const char *what)
{
    if (good) return;
    fprintf(stderr, "bench_check: %s\n", what);
    exit(1);
}

static double drawn(arm *a, double lo, double hi)
{
    a->random ^= a->random << 13;
    a->random ^= a->random >> 7;
    a->random ^= a->random << 17;
    return lo + (hi - lo) * (double)(a->random >> 11) * 0x1p-53;
}

static robot_source find_source(bool *shared)
{
    static const load_package package = {
        "moveit_resources_panda_description", BENCH_SHARED "/robots/panda/panda_description"};
    const robot_source panda = {.urdf = BENCH_SHARED "/robots/panda/panda_description/urdf/panda.urdf",
        .srdf = BENCH_SHARED "/robots/panda/panda_moveit_config/config/panda.srdf",
        .packages = &package,
        .package_count = 1};
    *shared = access(panda.urdf, R_OK) == 0;
    return *shared ? panda : (robot_source){.urdf = BENCH_EXAMPLES "/arm.urdf", .srdf = BENCH_EXAMPLES "/arm.srdf"};
}

/* Mimics of mimics do not occur in these two robots. */
static void make_joint(arm *a, size_t place, const int *places, int of)
{
    const urdf *u = &a->robot.model;
    const urdf_joint *j = &u->joints[of];
    static const robot_joint_type types[] = {[URDF_FIXED] = ROBOT_FIXED,
        [URDF_REVOLUTE] = ROBOT_REVOLUTE,
        [URDF_CONTINUOUS] = ROBOT_CONTINUOUS,
        [URDF_PRISMATIC] = ROBOT_PRISMATIC};
    int above = u->links[j->parent].joint;
    a->joints[place] = (robot_joint){.parent = above < 0 ? 0 : places[above],
        .type = types[j->type],
        .origin = robot_world_pose(&j->origin),
        .axis = vec(j->axis[0], j->axis[1], j->axis[2]),
        .lower = j->lower,
        .upper = j->upper,
        .mimic = j->mimic < 0 ? -1 : places[j->mimic],
        .factor = j->mimic_factor,
        .offset = j->mimic_offset};
    if (j->type == URDF_FIXED || j->mimic >= 0) return;
    a->lower[a->coordinates] = j->limited ? j->lower : -3;
    a->upper[a->coordinates++] = j->limited ? j->upper : 3;
}

static uint32_t id_of_link(arm *a, int link)
{
    if (a->robot.model.links[link].shape_count == 0) return WORLD_NONE;
    return world_find_body(a->w, robot_body_name(&a->robot, link, &a->pool));
}

static void arm_begin(arm *a, bool *shared)
{
    static robot_source source; /* the robot borrows it */
    source = find_source(shared);
    *a = (arm){.random = 88172645463325252u};
    must(robot_load(&a->robot, &a->pool, &source, &a->report), a->report.error);
    const urdf *u = &a->robot.model;
    double *values = pool_alloc(&a->pool, (size_t)u->joint_count, sizeof *values);
    robot_default_values(&a->robot, values);
    must(robot_bodies(&a->robot, collided_pose_identity(), values, COLLIDED_MOVING, &a->pool, &a->bodies, &a->report),
        a->report.error);
    world_options o = world_options_default();
    a->w = world_create(&o);
    for (size_t i = 0; i < a->bodies.count; i++) (void)robot_world_put(&a->geometry, a->w, &a->bodies.at[i]);
    int places[LINKS_MAX];
    must(u->link_count <= LINKS_MAX, "the robot has too many links");
    for (int i = 0; i < u->joint_count; i++) places[u->order[i]] = i + 1;
    a->joints[0] = (robot_joint){.parent = -1, .type = ROBOT_FIXED, .origin = POSE_IDENTITY, .mimic = -1};
    a->ids[0] = id_of_link(a, u->root);
    for (int i = 0; i < u->joint_count; i++) {
        make_joint(a, (size_t)i + 1, places, u->order[i]);
        a->ids[i + 1] = id_of_link(a, u->joints[u->order[i]].child);
    }
    a->joint_count = (size_t)u->joint_count + 1;
}

/* ---- the contender: FCL, if it was built in ---- */

static narrow_place place_of(pose p)
{
    return (narrow_place){{p.p.x, p.p.y, p.p.z}, {p.q.w, p.q.x, p.q.y, p.q.z}};
}

static narrow_body peer_body_of(const shape *s)
{
    static const narrow_kind kinds[] = {[SHAPE_SPHERE] = KIND_SPHERE,
        [SHAPE_CAPSULE] = KIND_CAPSULE,
        [SHAPE_BOX] = KIND_BOX,
        [SHAPE_CYLINDER] = KIND_CYLINDER,
        [SHAPE_HULL] = KIND_HULL};
    return (narrow_body){.kind = kinds[s->type], .half = {s->half.x, s->half.y, s->half.z}, .radius = s->radius};
}

static narrow_polytope *peer_hull_of(const hull *h, pool *p)
{
    narrow_polytope *out = pool_alloc(p, 1, sizeof *out);
    *out = (narrow_polytope){.vertex_count = h->vertex_count, .face_count = h->face_count};
    out->vertices = pool_alloc(p, 3 * out->vertex_count, sizeof *out->vertices);
    out->face_first = pool_alloc(p, out->face_count + 1, sizeof *out->face_first);
    for (uint32_t i = 0; i < h->vertex_count; i++) {
        vec3 v = hull_vertex(h, i);
        out->vertices[3 * i] = v.x, out->vertices[3 * i + 1] = v.y, out->vertices[3 * i + 2] = v.z;
    }
    for (uint32_t i = 0; i < h->face_count; i++) out->face_first[i + 1] = out->face_first[i] + h->faces[i].count;
    out->face_vertices = pool_alloc(p, out->face_first[out->face_count], sizeof *out->face_vertices);
    for (uint32_t i = 0; i < h->face_count; i++)
        memcpy(&out->face_vertices[out->face_first[i]], &h->face_vertices[h->faces[i].first],
            h->faces[i].count * sizeof(uint32_t));
    return out;
}

static const check_peer *the_peer(void)
{
    return check_contender_count > 0 ? check_contenders[0] : NULL;
}

static bool are_checked(const arm *a, size_t i, size_t k)
{
    char text[512];
    if (a->ids[i] == WORLD_NONE || a->ids[k] == WORLD_NONE) return false;
    world_explain(a->w, a->ids[i], a->ids[k], 0, text, sizeof text);
    return !strstr(text, "not checked");
}

/* The hulls of robot_world are in the order of the bodies and their shapes. */
static void give_peer_the_robot(arm *a)
{
    size_t hulls = 0;
    for (size_t i = 0; i < a->bodies.count; i++) {
        size_t link = 0;
        while (a->ids[link] == WORLD_NONE || a->ids[link] != world_find_body(a->w, a->bodies.at[i].name)) link++;
        for (size_t k = 0; k < a->bodies.at[i].shape_count; k++) {
            const collided_shape *from = &a->bodies.at[i].shapes[k].shape;
            shape s = {.type = from->type == COLLIDED_HULL ? SHAPE_HULL : (shape_type)from->type,
                .radius = from->radius,
                .half = {from->half[0], from->half[1], from->half[2]}};
            narrow_body body = peer_body_of(&s);
            if (s.type == SHAPE_HULL) body.polytope = peer_hull_of(a->geometry.hulls.at[hulls++], &a->pool);
            narrow_place local = place_of(robot_world_pose(&from->pose));
            the_peer()->add_link_shape(link, &body, &local);
        }
    }
    for (size_t i = 0; i < a->joint_count; i++)
        for (size_t k = i + 1; k < a->joint_count; k++)
            if (are_checked(a, i, k)) the_peer()->keep_apart(i, k);
}

/* Forward kinematics; of the one arm that a run has. */
static void poses_at(const arm *a, const double *q, pose *links)
{
    robot_status status;
    size_t where;
    static robot_tree *tree;
    if (!tree) tree = robot_tree_create(a->joints, a->joint_count, &status, &where);
    robot_tree_forward(tree, q, links);
}

static void links_at(const arm *a, const double *q, narrow_place *out)
{
    pose links[LINKS_MAX];
    poses_at(a, q, links);
    for (size_t i = 0; i < a->joint_count; i++) out[i] = place_of(links[i]);
}

static bool peer_meets(const arm *a, const double *q)
{
    narrow_place links[LINKS_MAX];
    links_at(a, q, links);
    return the_peer()->meets(links);
}

/* The same items, until the first hit of each. */
static void ask_peer(arm *a, bool edges, const double *q, size_t count, const world_check_item *ours, scores *all)
{
    enum { SAMPLES = 32 };
    size_t n = a->coordinates;
    score *s = edges ? &all->peer_edges : &all->peer_states;
    double at[LINKS_MAX];
    int64_t start = clock_thread_ns();
    bool *met = pool_alloc(&a->pool, count, sizeof *met);
    for (size_t i = 0; i < count; i++) {
        if (!edges) met[i] = peer_meets(a, q + i * n);
        for (size_t k = 0; edges && k <= SAMPLES && !met[i]; k++) {
            const double *from = q + 2 * i * n;
            for (size_t j = 0; j < n; j++) at[j] = from[j] + (double)k / SAMPLES * (from[n + j] - from[j]);
            met[i] = peer_meets(a, at);
        }
    }
    s->ns += clock_thread_ns() - start;
    s->items += count;
    for (size_t i = 0; i < count; i++) {
        s->verdicts[met[i] ? CHECK_MEETS : CHECK_FREE]++;
        if (edges) s->missed += !met[i] && ours[i].verdict == CHECK_MEETS;
        if (!edges) all->differ += ours[i].verdict == (met[i] ? CHECK_FREE : CHECK_MEETS);
    }
}

static void put_obstacle(arm *a, shape s, pose at)
{
    narrow_body body = peer_body_of(&s);
    narrow_place place = place_of(at);
    if (the_peer()) the_peer()->add_obstacle(&body, &place);
    char name[32];
    world_shape one = {.shape = s, .local = POSE_IDENTITY};
    snprintf(name, sizeof name, "obstacle %zu", a->obstacle_count);
    world_body def = {.name = name,
        .group = "",
        .category = 1,
        .mask = 1,
        .pose = at,
        .shapes = &one,
        .shape_count = 1,
        .fixed = true};
    uint32_t id = WORLD_NONE;
    must(a->obstacle_count < BOXES_MAX, "a scene has too many bodies");
    world_put_body(a->w, &id, &def);
    a->obstacles[a->obstacle_count++] = id;
}

static void tick(arm *a)
{
    world_batches out;
    static int64_t now;
    world_tick(a->w, ++now, &out);
}

static void clear_scene(arm *a)
{
    for (size_t i = 0; i < a->obstacle_count; i++) world_remove_body(a->w, a->obstacles[i], 0);
    a->obstacle_count = 0;
    if (the_peer()) the_peer()->end_scene();
    tick(a);
}

static void random_scene(arm *a)
{
    for (int i = 0; i < 20; i++) {
        double around = drawn(a, 0, 6.28), far = drawn(a, 0.35, 0.9);
        shape s = {.type = i % 3 ? SHAPE_BOX : SHAPE_CYLINDER,
            .half = {drawn(a, 0.02, 0.08), drawn(a, 0.02, 0.08), drawn(a, 0.02, 0.15)}};
        if (i % 3 == 0) s.half.y = s.half.x;
        put_obstacle(a, s, (pose){{far * cos(around), far * sin(around), drawn(a, 0, 0.9)}, {1, 0, 0, 0}});
    }
}

/* ---- what is asked ---- */

static void ask(arm *a, bool edges, const double *q, size_t count, world_check_item *items, score *s)
{
    char text[256];
    world_check_def def = {.joints = a->joints,
        .bodies = a->ids,
        .joint_count = a->joint_count,
        .base = POSE_IDENTITY,
        .request = check_request_default(),
        .edges = edges,
        .coordinates = q,
        .items = count};
    def.request.find_first = false;
    world_check_patience forever = {0};
    int64_t start = clock_thread_ns();
    must(world_check(a->w, &def, &forever, items, text, sizeof text), text);
    s->ns += clock_thread_ns() - start;
    s->items += count;
    for (size_t i = 0; i < count; i++) s->verdicts[items[i].verdict]++;
}

/* By all pairs, one by one, with the narrow phase: is anything met there? */
static bool meets(arm *a, const double *q)
{
    pose links[LINKS_MAX];
    poses_at(a, q, links);
    for (size_t i = 0; i < a->joint_count; i++)
        if (a->ids[i] != WORLD_NONE) world_move_body(a->w, a->ids[i], links[i], 0, NULL, NULL);
    tick(a);
    bool met = false;
    for (size_t i = 0; i < a->joint_count && !met; i++) {
        world_hits hits = {0};
        char text[512];
        if (a->ids[i] == WORLD_NONE) continue;
        for (size_t k = 0; k < a->obstacle_count; k++)
            world_query_distance(a->w, a->ids[i], a->obstacles[k], 1e-6, 0, &hits);
        for (size_t k = i + 1; k < a->joint_count; k++) {
            if (a->ids[k] == WORLD_NONE) continue;
            world_explain(a->w, a->ids[i], a->ids[k], 0, text, sizeof text);
            if (!strstr(text, "not checked")) world_query_distance(a->w, a->ids[i], a->ids[k], 1e-6, 0, &hits);
        }
        for (size_t k = 0; k < hits.count; k++) met |= hits.at[k].hi < -1e-9;
        array_free(&hits);
    }
    return met;
}

static void run_scene(arm *a, scores *all, size_t dense)
{
    score *edges = &all->edges;
    size_t n = a->coordinates, free_count = 0;
    double *q = malloc(STATES * n * sizeof *q), *e = malloc(2 * EDGES * n * sizeof *e), *at = malloc(n * sizeof *at);
    world_check_item items[STATES];
    must(q && e && at, "no memory");
    for (size_t i = 0; i < STATES * n; i++) q[i] = drawn(a, a->lower[i % n], a->upper[i % n]);
    if (the_peer()) the_peer()->begin_scene();
    ask(a, false, q, STATES, items, &all->states);
    if (the_peer()) ask_peer(a, false, q, STATES, items, all);
    for (size_t i = 0; i < STATES && free_count < EDGES; i++) {
        if (items[i].verdict != CHECK_FREE) continue;
        double length = 0, *from = e + 2 * free_count * n, *to = from + n;
        for (size_t k = 0; k < n; k++) to[k] = drawn(a, -1, 1), length += to[k] * to[k];
        for (size_t k = 0; k < n; k++) {
            from[k] = q[i * n + k];
            to[k] = fmin(fmax(from[k] + to[k] / sqrt(length), a->lower[k]), a->upper[k]);
        }
        free_count++;
    }
    if (free_count > 0) ask(a, true, e, free_count, items, edges);
    if (free_count > 0 && the_peer()) ask_peer(a, true, e, free_count, items, all);
    for (size_t i = 0; i < free_count && dense > 0; i++) {
        bool met = false;
        for (size_t s = 0; s <= dense && items[i].verdict == CHECK_FREE && !met; s++) {
            double t = (double)s / (double)dense;
            for (size_t k = 0; k < n; k++) at[k] = e[2 * i * n + k] + t * (e[(2 * i + 1) * n + k] - e[2 * i * n + k]);
            met = meets(a, at);
        }
        edges->missed += met;
    }
    free(q);
    free(e);
    free(at);
}

static void tell_score(const arm *a, const char *scenes, const char *contender, const score *s, bool json)
{
    double us = 1e-3 * (double)s->ns / (double)(s->items ? s->items : 1);
    if (json)
        printf("{\"bench\":\"check\",\"entry\":\"world_check\",\"contender\":\"%s\",\"robot\":\"%s\",\"scenes\":"
               "\"%s\",\"kind\":\"%s\","
               "\"items\":%zu,\"us_an_item\":%.3f,\"free\":%zu,\"meets\":%zu,\"undecided\":%zu,\"missed\":%zu}\n",
            contender, a->robot.model.name, scenes, s->kind, s->items, us, s->verdicts[0], s->verdicts[1],
            s->verdicts[2], s->missed);
    else
        printf("%-10s %-10s %-10s %-8s %10zu %12.2f %10zu %10zu %10zu %8zu\n", contender, a->robot.model.name, scenes,
            s->kind, s->items, us, s->verdicts[0], s->verdicts[1], s->verdicts[2], s->missed);
}

static void tell(const arm *a, const char *scenes, const scores *all, bool json)
{
    tell_score(a, scenes, "collided", &all->states, json);
    tell_score(a, scenes, "collided", &all->edges, json);
    if (!the_peer()) return;
    tell_score(a, scenes, the_peer()->name, &all->peer_states, json);
    tell_score(a, scenes, the_peer()->name, &all->peer_edges, json);
    if (all->differ > 0)
        fprintf(stderr, "%s: of %zu states %s says the opposite of what is proven of %zu\n", scenes,
            all->peer_states.items, the_peer()->name, all->differ);
}

/* ---- scenes of motion problems ---- */

static void read_line(arm *a, char *line)
{
    double v[10];
    char kind[16];
    int used = 0, count = 0;
    if (sscanf(line, "%15s%n", kind, &used) != 1) return;
    for (char *at = line + used, *end; count < 10; at = end, count++) {
        v[count] = strtod(at, &end);
        if (end == at) break;
    }
    int sizes = count - 7;
    if (sizes < 1) return;
    pose p = {{v[sizes], v[sizes + 1], v[sizes + 2]},
        quat_unit((quat){v[sizes + 3], v[sizes + 4], v[sizes + 5], v[sizes + 6]})};
    if (strcmp(kind, "box") == 0)
        put_obstacle(a, (shape){.type = SHAPE_BOX, .half = {v[0] / 2, v[1] / 2, v[2] / 2}}, p);
    if (strcmp(kind, "cylinder") == 0)
        put_obstacle(a, (shape){.type = SHAPE_CYLINDER, .half = {v[1], v[1], v[0] / 2}}, p);
    if (strcmp(kind, "sphere") == 0) put_obstacle(a, (shape){.type = SHAPE_SPHERE, .radius = v[0]}, p);
}

static void run_problems(arm *a, scores *all, int most, size_t dense)
{
    char command[512], line[1024];
    snprintf(command, sizeof command,
        "/usr/bin/python3 '%s/check_scenes.py' '%s/cases/motion/panda/problems.tar.bz2' %d", BENCH_SOURCE, BENCH_SHARED,
        most);
    FILE *from = popen(command, "r"); /* NOLINT(cert-env33-c): a script of the project's own */
    must(from, "the problems cannot be read");
    while (fgets(line, sizeof line, from)) {
        if (strncmp(line, "goal", 4) == 0) {
            tick(a);
            run_scene(a, all, dense);
            clear_scene(a);
        } else if (strncmp(line, "start", 5) != 0 && strncmp(line, "problem", 7) != 0) {
            read_line(a, line);
        }
    }
    must(pclose(from) == 0, "the problems cannot be read");
}

int main(int argc, char **argv)
{
    bench_options o;
    static arm a;
    bool shared;
    if (!bench_parse(argc, argv, 10, 100, &o)) return 64;
    arm_begin(&a, &shared);
    if (the_peer()) give_peer_the_robot(&a);
    if (!o.json)
        printf("%-10s %-10s %-10s %-8s %10s %12s %10s %10s %10s %8s\n", "contender", "robot", "scenes", "kind", "items",
            "us an item", "free", "meets", "undecided", "missed");
    scores all = {
        .states.kind = "states", .edges.kind = "edges", .peer_states.kind = "states", .peer_edges.kind = "edges"};
    const scores none = all;
    for (int i = 0; i < (int)fmax(1, o.seconds); i++) {
        random_scene(&a);
        tick(&a);
        run_scene(&a, &all, i > 0 ? 0 : o.seconds < 1 ? 3 : 100);
        clear_scene(&a);
    }
    tell(&a, "random", &all, o.json);
    size_t missed = all.edges.missed;
    if (shared && o.seconds >= 1) {
        all = none;
        run_problems(&a, &all, (int)(o.seconds * 2.1), o.seconds > 50 ? 100 : 20);
        tell(&a, "problems", &all, o.json);
        missed += all.edges.missed;
    } else if (!shared) {
        fprintf(stderr, "the motion problems are not there: random scenes alone\n");
    }
    world_destroy(a.w);
    robot_world_free(&a.geometry);
    pool_free(&a.pool);
    return missed > 0;
}
