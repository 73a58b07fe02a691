/* motion_planner: a sampling planner whose every edge is proven free, in place of being sampled.
 *
 *     motion_planner [--connect URI] [--json] ROBOT.urdf ROBOT.srdf < PROBLEMS
 *
 * Method: RRT-Connect (Kuffner and LaValle, ICRA 2000), with whole rounds of edges in one question
 * (collided_check_edges), then shortcuts. Two trees of free configurations grow from the start and the goal; each round
 * extends one of them towards random configurations, and connects the other one to what was gained, as far as it is
 * free. What is undecided counts as not free. Nothing moves in the daemon's world. The same problems give the same
 * paths.
 *
 * Problems are lines: 'problem NAME'; bodies, 'box SX SY SZ X Y Z W QX QY QZ', 'cylinder LENGTH RADIUS X ...', 'sphere
 * RADIUS X ...' (m, full sides, pose in the frame of the robot's base); 'start' and 'goal', each followed by a state of
 * the SRDF or by NAME VALUE pairs (rad or m; joints that are not named are at their defaults). With --json each problem
 * is an object with its path: configurations, of the joints that move by themselves, in the order of the tree. */
#include "example.h"

#include <collided_load.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sysexits.h>

enum { JOINTS_MAX = 32, BODIES_MAX = 256, VALUES_MAX = 256, SAMPLES = 16, PIECES_MAX = 16, PROBLEMS_MAX = 10000 };
enum { EDGES_MAX = SAMPLES * PIECES_MAX, ROUNDS_MAX = 2000, SHORTCUT_ROUNDS = 12, PATH_MAX_POINTS = 1024 };
static const double STEP = 1.0;       /* rad (m): an edge is not longer, by the length of the change of all joints */
static const double TIMEOUT_S = 60.0; /* of one question, on a busy machine */

typedef double configuration[JOINTS_MAX];

typedef struct tree {
    configuration *at;
    int *parent; /* -1 = the root */
    int count, room;
} tree;

typedef struct planner {
    const example *e;
    collided *c;
    collided_loaded_robot *arm;
    collided_robot robot;
    size_t joints, n; /* values of the URDF; coordinates */
    configuration lower, upper;
    uint64_t random;
    size_t edges_asked, questions;
    collided_body bodies[BODIES_MAX];
    size_t body_count, bodies_ever;
} planner;

static double draw(planner *p) /* 0 to 1 */
{
    p->random ^= p->random << 13;
    p->random ^= p->random >> 7;
    p->random ^= p->random << 17;
    return (double)(p->random >> 11) * 0x1p-53;
}

static double distance(const planner *p, const double *a, const double *b)
{
    double sum = 0;
    for (size_t i = 0; i < p->n; i++) sum += (b[i] - a[i]) * (b[i] - a[i]);
    return sqrt(sum);
}

static void between(const planner *p, const double *a, const double *b, double t, double *out)
{
    for (size_t i = 0; i < p->n; i++) out[i] = t == 1 ? b[i] : a[i] + t * (b[i] - a[i]); /* b itself, to the last bit */
}

/* ---- questions ---- */

/* Which of the edges, from[i] to to[i], are proven free? False: it could not be asked. */
static bool ask(planner *p, configuration *from, configuration *to, size_t count, bool *is_free)
{
    static double numbers[EDGES_MAX * 2 * JOINTS_MAX];
    collided_check_options options = collided_check_options_default();
    collided_checked told;
    options.find_first = false; /* only free or not */
    for (size_t i = 0; i < count; i++) {
        memcpy(numbers + 2 * i * p->n, from[i], p->n * sizeof(double));
        memcpy(numbers + (2 * i + 1) * p->n, to[i], p->n * sizeof(double));
    }
    p->edges_asked += count;
    p->questions++;
    bool good = count == 0 ||
                example_ok(p->c, collided_check_edges(p->c, &p->robot, &options, numbers, count, TIMEOUT_S, &told),
                    "motion_planner: asking for edges");
    for (size_t i = 0; i < count; i++) is_free[i] = good && told.items[i].verdict == COLLIDED_CHECK_FREE;
    if (count) collided_checked_free(&told);
    return good;
}

/* ---- trees ---- */

static int grow(tree *t, const double *q, int parent)
{
    if (t->count == t->room) {
        t->room = t->room ? 2 * t->room : 256;
        t->at = realloc(t->at, (size_t)t->room * sizeof *t->at);
        t->parent = realloc(t->parent, (size_t)t->room * sizeof *t->parent);
        if (!t->at || !t->parent) abort();
    }
    memcpy(t->at[t->count], q, sizeof *t->at);
    t->parent[t->count] = parent;
    return t->count++;
}

static int nearest(const planner *p, const tree *t, const double *q)
{
    int best = 0;
    double least = INFINITY;
    for (int i = 0; i < t->count; i++) {
        double d = distance(p, t->at[i], q);
        if (d < least) least = d, best = i;
    }
    return best;
}

/* One step of a tree towards random configurations: the nodes that it gains are the last ones. */
static bool extend(planner *p, tree *t)
{
    static configuration from[SAMPLES], to[SAMPLES];
    bool is_free[SAMPLES];
    int parents[SAMPLES];
    for (int i = 0; i < SAMPLES; i++) {
        configuration sample = {0};
        for (size_t k = 0; k < p->n; k++) sample[k] = p->lower[k] + draw(p) * (p->upper[k] - p->lower[k]);
        parents[i] = nearest(p, t, sample);
        double d = distance(p, t->at[parents[i]], sample);
        memset(to[i], 0, sizeof to[i]);
        memcpy(from[i], t->at[parents[i]], sizeof from[i]);
        between(p, from[i], sample, d > STEP ? STEP / d : 1, to[i]);
    }
    if (!ask(p, from, to, SAMPLES, is_free)) return false;
    for (int i = 0; i < SAMPLES; i++)
        if (is_free[i]) (void)grow(t, to[i], parents[i]);
    return true;
}

/* From each of the nodes of `other` from `first` on, a chain of edges out of the nearest node of `t`: as far as they
 * are free, they are added. True and the two nodes that meet, if a chain reaches its end. */
static bool connect(planner *p, tree *t, const tree *other, int first, int *mine, int *theirs, bool *good)
{
    static configuration from[EDGES_MAX], to[EDGES_MAX];
    static bool is_free[EDGES_MAX];
    int parents[SAMPLES], pieces[SAMPLES], chains = 0;
    size_t count = 0;
    for (int node = first; node < other->count && chains < SAMPLES; node++, chains++) {
        parents[chains] = nearest(p, t, other->at[node]);
        const double *begin = t->at[parents[chains]];
        double steps = ceil(distance(p, begin, other->at[node]) / STEP);
        pieces[chains] = steps < 1 ? 1 : steps > PIECES_MAX ? PIECES_MAX : (int)steps;
        for (int k = 0; k < pieces[chains]; k++, count++) {
            memset(from[count], 0, sizeof from[count]), memset(to[count], 0, sizeof to[count]);
            between(p, begin, other->at[node], k / steps, from[count]);
            between(p, begin, other->at[node], k + 1 >= steps ? 1 : (k + 1) / steps, to[count]);
        }
    }
    *good = ask(p, from, to, count, is_free);
    count = 0;
    for (int i = 0; i < chains; i++) {
        int last = parents[i], k = 0;
        for (; k < pieces[i] && is_free[count + (size_t)k]; k++) last = grow(t, to[count + (size_t)k], last);
        bool arrived = k == pieces[i] && distance(p, t->at[last], other->at[first + i]) == 0;
        count += (size_t)pieces[i];
        if (arrived) return *mine = last, *theirs = first + i, true;
    }
    return false;
}

/* ---- paths ---- */

typedef struct path {
    configuration at[PATH_MAX_POINTS];
    int count;
} path;

static void add_branch(const tree *t, int node, bool from_root, path *out)
{
    int begin = out->count;
    for (; node >= 0 && out->count < PATH_MAX_POINTS; node = t->parent[node])
        memcpy(out->at[out->count++], t->at[node], sizeof out->at[0]);
    for (int i = begin, k = out->count - 1; from_root && i < k; i++, k--) {
        configuration swapped;
        memcpy(swapped, out->at[i], sizeof swapped);
        memcpy(out->at[i], out->at[k], sizeof swapped);
        memcpy(out->at[k], swapped, sizeof swapped);
    }
}

static double path_length(const planner *p, const path *of)
{
    double sum = 0;
    for (int i = 0; i + 1 < of->count; i++) sum += distance(p, of->at[i], of->at[i + 1]);
    return sum;
}

/* Unless it is the point before. */
static void add_point(const planner *p, path *to, const double *q)
{
    if (to->count == 0 || distance(p, to->at[to->count - 1], q) > 0) memcpy(to->at[to->count++], q, sizeof to->at[0]);
}

/* Replaces what lies between two random points by the straight way, where that is free and saves most. The rests of the
 * edges that are cut are parts of edges that are proven. */
static bool shorten(planner *p, path *of)
{
    static configuration from[SAMPLES], to[SAMPLES];
    bool is_free[SAMPLES];
    int begin[SAMPLES], end[SAMPLES], best = -1;
    double most = 1e-3;
    if (of->count < 3) return true;
    for (int i = 0; i < SAMPLES; i++) {
        int a = (int)(draw(p) * (of->count - 1)), b = (int)(draw(p) * (of->count - 1));
        begin[i] = a < b ? a : b, end[i] = a < b ? b : a;
        memset(from[i], 0, sizeof from[i]), memset(to[i], 0, sizeof to[i]);
        between(p, of->at[begin[i]], of->at[begin[i] + 1], i % 2 ? draw(p) : 0, from[i]);
        between(p, of->at[end[i]], of->at[end[i] + 1], i % 2 ? draw(p) : 1, to[i]);
    }
    if (!ask(p, from, to, SAMPLES, is_free)) return false;
    for (int i = 0; i < SAMPLES; i++) {
        if (!is_free[i] || end[i] == begin[i]) continue;
        double old = distance(p, from[i], of->at[begin[i] + 1]) + distance(p, of->at[end[i]], to[i]);
        for (int k = begin[i] + 1; k < end[i]; k++) old += distance(p, of->at[k], of->at[k + 1]);
        double gain = old - distance(p, from[i], to[i]);
        if (gain > most) most = gain, best = i;
    }
    if (best < 0 || of->count + 2 > PATH_MAX_POINTS) return true;
    static path shorter;
    shorter.count = 0;
    for (int k = 0; k <= begin[best]; k++) add_point(p, &shorter, of->at[k]);
    add_point(p, &shorter, from[best]);
    add_point(p, &shorter, to[best]);
    for (int k = end[best] + 1; k < of->count; k++) add_point(p, &shorter, of->at[k]);
    *of = shorter;
    return true;
}

/* All of it once more: in one world, if it is answered by one tick. */
static bool prove(planner *p, path *of)
{
    bool is_free[EDGES_MAX], all = true;
    for (int first = 0; all && first + 1 < of->count; first += EDGES_MAX) {
        int left = of->count - 1 - first, count = left < EDGES_MAX ? left : EDGES_MAX;
        all = ask(p, of->at + first, of->at + first + 1, (size_t)count, is_free);
        for (int i = 0; i < count; i++) all = all && is_free[i];
    }
    return all;
}

/* Are both ends free? Who is in the way is told. */
static bool ends_are_free(planner *p, const double *start, const double *goal)
{
    static const char *const names[2] = {"start", "goal"};
    double numbers[2 * JOINTS_MAX];
    collided_checked told;
    memcpy(numbers, start, p->n * sizeof *numbers);
    memcpy(numbers + p->n, goal, p->n * sizeof *numbers);
    bool good = example_ok(p->c, collided_check_states(p->c, &p->robot, NULL, numbers, 2, TIMEOUT_S, &told),
        "motion_planner: asking for start and goal");
    for (size_t i = 0; good && i < 2; i++) {
        const collided_check_item *item = &told.items[i];
        if (item->verdict == COLLIDED_CHECK_FREE) continue;
        fprintf(stderr, "motion_planner: the %s is not free: %s, %s%s%s\n", names[i], item->name_a ? item->name_a : "",
            item->name_b ? item->name_b : "", *told.text ? ": " : "", told.text);
        good = false;
    }
    collided_checked_free(&told);
    return good;
}

static bool search(planner *p, const double *start, const double *goal, path *found)
{
    tree trees[2] = {{.at = NULL}, {.at = NULL}};
    int meets[2] = {-1, -1}, turn = 0;
    bool good = true, done = false;
    grow(&trees[0], start, -1);
    grow(&trees[1], goal, -1);
    done = connect(p, &trees[0], &trees[1], 0, &meets[0], &meets[1], &good); /* the straight way, first */
    for (int round = 0; good && !done && round < ROUNDS_MAX && example_running(p->e); round++, turn = 1 - turn) {
        tree *a = &trees[turn], *b = &trees[1 - turn];
        int before = a->count;
        good = extend(p, a);
        if (good && a->count > before) done = connect(p, b, a, before, &meets[1 - turn], &meets[turn], &good);
    }
    found->count = 0;
    if (done) {
        add_branch(&trees[0], meets[0], true, found);
        add_branch(&trees[1], trees[1].parent[meets[1]], false, found); /* they share that node */
    }
    for (int i = 0; i < 2; i++) free(trees[i].at), free(trees[i].parent);
    return done && found->count < PATH_MAX_POINTS;
}

/* ---- problems ---- */

typedef struct problem {
    char name[128];
    bool has_start, has_goal;
    configuration start, goal;
} problem;

static bool complain(const char *what, const char *line)
{
    return fprintf(stderr, "motion_planner: %s: %.100s\n", what, line), false;
}

/* How many numbers the text has, of which `most` are taken; -1: there is something else in it. */
static int take_numbers(const char *text, double *out, int most)
{
    int count = 0;
    for (char *end; text[strspn(text, " \n")]; text = end, count++) {
        double number = strtod(text, &end);
        if (end == text || count == most) return -1;
        out[count] = number;
    }
    return count;
}

static bool add_body(planner *p, collided_shape shape, const double *at)
{
    char name[64];
    collided_body_def def = collided_body_def_default();
    (void)snprintf(name, sizeof name, "obstacle_%zu", ++p->bodies_ever);
    if (p->body_count == BODIES_MAX) return complain("a problem has too many bodies", name);
    memcpy(shape.pose.position, at, sizeof shape.pose.position);
    memcpy(shape.pose.orientation, at + 3, sizeof shape.pose.orientation);
    def.name = name;
    def.motion = COLLIDED_FIXED;
    def.shapes = &shape;
    def.shape_count = 1;
    p->bodies[p->body_count] = collided_create_body(p->c, &def);
    return p->bodies[p->body_count++].id != COLLIDED_NONE || complain(collided_error(p->c), name);
}

static bool take_body(planner *p, const char *line)
{
    double v[10];
    size_t word = strcspn(line, " \n");
    int count = take_numbers(line + word, v, 10);
    bool box = strncmp(line, "box ", 4) == 0, cylinder = strncmp(line, "cylinder ", 9) == 0;
    if (!box && !cylinder && strncmp(line, "sphere ", 7) != 0) return complain("not understood", line);
    int sizes = box ? 3 : cylinder ? 2 : 1;
    if (count != sizes + 7) return complain("a body needs its sizes, a position and a quaternion", line);
    collided_shape shape = box        ? collided_box(v[0], v[1], v[2])
                           : cylinder ? collided_cylinder(v[1], v[0])
                                      : collided_sphere(v[0]);
    return add_body(p, shape, v + sizes);
}

static bool joint_is_fixed(const planner *p, const char *name)
{
    size_t count;
    const collided_loaded_joint *all = collided_loaded_joints(p->arm, &count);
    for (size_t i = 0; i < count; i++)
        if (strcmp(all[i].name, name) == 0) return all[i].type == COLLIDED_JOINT_FIXED;
    return false;
}

static bool take_configuration(planner *p, char *words, double *out)
{
    double values[VALUES_MAX];
    char *rest = NULL, *name = strtok_r(words, " \n", &rest), *value = strtok_r(NULL, " \n", &rest);
    collided_loaded_default_values(p->arm, values);
    collided_status status = name && !value ? collided_loaded_state_values(p->arm, name, values) : COLLIDED_OK;
    for (; name && value && !status; name = strtok_r(NULL, " \n", &rest), value = strtok_r(NULL, " \n", &rest)) {
        double number;
        if (take_numbers(value, &number, 1) != 1) return complain("not a number", value);
        if (!joint_is_fixed(p, name)) status = collided_loaded_set_value(p->arm, name, number, values);
    }
    if (status) return complain(collided_load_error(), "start or goal");
    memset(out, 0, sizeof(configuration));
    collided_loaded_configuration(p->arm, values, out);
    return true;
}

/* Up to the next 'problem', whose name is then in `next`. */
static bool read_problem(planner *p, char *next, problem *out)
{
    char line[4096];
    *out = (problem){.has_start = false};
    (void)snprintf(out->name, sizeof out->name, "%s", next);
    *next = 0;
    while (fgets(line, sizeof line, stdin)) {
        if (sscanf(line, "problem %127s", next) == 1) break;
        bool good = true;
        if (strncmp(line, "start ", 6) == 0)
            good = out->has_start = take_configuration(p, line + 6, out->start);
        else if (strncmp(line, "goal ", 5) == 0)
            good = out->has_goal = take_configuration(p, line + 5, out->goal);
        else if (line[strspn(line, " \n")] && *line != '#')
            good = take_body(p, line);
        if (!good) return false;
    }
    return (out->has_start && out->has_goal) || complain("it needs a start and a goal", out->name);
}

/* ---- the process ---- */

static bool prepare(planner *p, const char *urdf, const char *srdf)
{
    static collided_body bodies[JOINTS_MAX * 4];
    const collided_placement at = {.base = collided_pose_identity()};
    p->arm = collided_load_urdf(urdf, NULL);
    if (!p->arm || collided_load_srdf(p->arm, srdf) || collided_loaded_tree(p->arm, at.base, &p->robot))
        return complain(collided_load_error(), urdf);
    (void)collided_loaded_joints(p->arm, &p->joints);
    p->n = collided_robot_coordinates(&p->robot);
    if (p->n > JOINTS_MAX || p->joints > VALUES_MAX || collided_loaded_body_count(p->arm) > JOINTS_MAX * 4)
        return complain("this example is for smaller robots", urdf);
    for (size_t i = 0, k = 0; i < p->robot.joint_count; i++) {
        const collided_joint *j = &p->robot.joints[i];
        if (j->type == COLLIDED_JOINT_FIXED || j->mimics) continue;
        bool endless = j->type == COLLIDED_JOINT_CONTINUOUS;
        p->lower[k] = endless ? -3.14159 : j->lower, p->upper[k] = endless ? 3.14159 : j->upper;
        k++;
    }
    if (collided_create_loaded(p->c, p->arm, &at, bodies)) return complain(collided_load_error(), urdf);
    return example_ok(p->c, collided_sync(p->c, TIMEOUT_S), "motion_planner: creating the robot");
}

static void tell_as_json(const planner *p, const problem *of, const path *found, bool solved, double ms)
{
    printf("{\"problem\":\"%s\",\"solved\":%s,\"ms\":%.2f,\"questions\":%zu,\"edges\":%zu,\"length\":%.3f,\"path\":[",
        of->name, solved ? "true" : "false", ms, p->questions, p->edges_asked, path_length(p, found));
    for (int i = 0; i < found->count; i++)
        for (size_t k = 0; k < p->n; k++)
            printf("%s%.17g%s", k ? "," : i ? ",[" : "[", found->at[i][k], k + 1 == p->n ? "]" : "");
    puts("]}");
}

static void tell(const planner *p, const problem *of, const path *found, bool solved, double ms, double before)
{
    if (p->e->json)
        tell_as_json(p, of, found, solved, ms);
    else if (solved)
        printf("%-40s %9.2f ms, %4zu edges in %2zu questions, path of %2d points, %.2f rad (%.2f before)\n", of->name,
            ms, p->edges_asked, p->questions, found->count, path_length(p, found), before);
    else
        printf("%-40s not solved, %zu edges asked\n", of->name, p->edges_asked);
    fflush(stdout);
}

static bool solve(planner *p, problem *of, double *ms)
{
    static path found;
    bool good = example_ok(p->c, collided_sync(p->c, TIMEOUT_S), "motion_planner: creating the obstacles");
    double before = 0;
    p->random = 0x9e3779b97f4a7c15u;
    p->edges_asked = p->questions = 0;
    int64_t begin = example_now_ns();
    bool solved = good && ends_are_free(p, of->start, of->goal) && search(p, of->start, of->goal, &found);
    if (solved) before = path_length(p, &found);
    for (int i = 0; solved && i < SHORTCUT_ROUNDS; i++) solved = shorten(p, &found);
    solved = solved && prove(p, &found);
    *ms = 1e-6 * (double)(example_now_ns() - begin);
    if (!solved) found.count = 0;
    tell(p, of, &found, solved, *ms, before);
    for (; p->body_count > 0; p->body_count--) (void)collided_remove_body(p->c, p->bodies[p->body_count - 1]);
    return solved;
}

static int by_size(const void *a, const void *b)
{
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

static bool solve_all(planner *p)
{
    static double ms[PROBLEMS_MAX];
    size_t count = 0, solved = 0;
    char next[128] = "";
    char line[256];
    while (!*next && fgets(line, sizeof line, stdin)) (void)sscanf(line, "problem %127s", next);
    while (*next && count < PROBLEMS_MAX && example_running(p->e)) {
        problem one;
        if (!read_problem(p, next, &one)) return false;
        count++;
        solved += solve(p, &one, &ms[solved]);
    }
    qsort(ms, solved, sizeof *ms, by_size);
    double median = solved ? ms[solved / 2] : NAN, p95 = solved ? ms[(size_t)(0.95 * (double)solved)] : NAN;
    if (p->e->json)
        printf("{\"problems\":%zu,\"solved\":%zu,\"median_ms\":%.2f,\"p95_ms\":%.2f}\n", count, solved, median, p95);
    else
        printf("%zu of %zu problems solved, proven; median %.2f ms, p95 %.2f ms\n", solved, count, median, p95);
    return count > 0 && solved == count;
}

int main(int argc, char **argv)
{
    if (argc < 3 || argv[argc - 2][0] == '-')
        return fprintf(stderr, "usage: motion_planner [--connect URI] [--json] ROBOT.urdf ROBOT.srdf < PROBLEMS\n"),
               EX_USAGE;
    const example e = example_start(argc - 2, argv);
    static planner p;
    p.e = &e;
    p.c = example_connect(&e, NULL);
    if (!p.c) return EX_UNAVAILABLE;
    bool good = prepare(&p, argv[argc - 2], argv[argc - 1]) && solve_all(&p);
    collided_close(p.c);
    collided_loaded_robot_free(p.arm);
    return good ? EX_OK : EX_SOFTWARE;
}
