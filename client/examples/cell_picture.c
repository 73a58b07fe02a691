/* cell_picture: a client that draws what it learns: the robot cell at the moment when the vehicle has come as near to
 * the arm as --at says, with the certified distance and its two witness points, and how that distance went over
 * --seconds. Shows how poses and distances are brought to the same tick. One thread; callbacks run inside
 * collided_poll.
 *
 * client/examples/cell.svg comes from it, in a network namespace (or on a machine) where only the demo
 * runs:
 *     ./collided --links dds://0 & ./vehicle_simulator & ./arm_controller & sleep 1
 *     ./cell_picture --seconds 12 --after 4 --at 330 --out cell.svg */
#include "cell_picture.h"
#include "example.h"
#include "loaders/rigid.h"
#include "loaders/robot.h"

#include <limits.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <sysexits.h>
#include <unistd.h>

static const double RANGE_M = 3; /* the whole lane */
static const double THRESHOLD_M = 0.001, TOLERANCE_M = 1e-5;
static const double ANSWER_S = 2;

typedef struct sighting { /* one pair of shapes, or one contact, as it is now */
    int64_t contact;
    picture_gap gap;
    double left; /* m: what is left of it when the arm stands */
} sighting;

typedef struct sightings {
    sighting *at;
    size_t count, capacity;
} sightings;

typedef struct artist {
    picture picture;
    sightings pairs, contacts;
    size_t gap_capacity, mark_capacity;
    int64_t start_ns;
    bool stopped, has_contacts;
} artist;

/* Room for one more in an array that grows by doubling. */
static void *grow(void *array, size_t count, size_t *capacity, size_t size)
{
    if (count < *capacity) return array;
    *capacity = *capacity ? 2 * *capacity : 256;
    array = realloc(array, *capacity * size);
    if (!array) abort(); /* an example has nothing better to do */
    return array;
}

static double now_s(const artist *a)
{
    return (double)(example_now_ns() - a->start_ns) * 1e-9;
}

static void mark(artist *a, picture_mark_kind kind, double lo)
{
    picture *p = &a->picture;
    p->marks = grow(p->marks, p->mark_count, &a->mark_capacity, sizeof *p->marks);
    p->marks[p->mark_count++] = (picture_mark){now_s(a), kind, lo};
}

/* ---- events ---- */

static void forget(sightings *s, int64_t contact)
{
    for (size_t i = 0; i < s->count; i++)
        if (s->at[i].contact == contact) s->at[i--] = s->at[--s->count];
}

static void remember(sightings *s, const collided_event *e)
{
    forget(s, e->contact);
    s->at = grow(s->at, s->count, &s->capacity, sizeof *s->at);
    sighting *one = &s->at[s->count++];
    *one = (sighting){.contact = e->contact, .gap = {.lo = e->lo, .hi = e->hi}, .left = example_separation_left(e)};
    (void)snprintf(one->gap.a, sizeof one->gap.a, "%s", e->name_a);
    (void)snprintf(one->gap.b, sizeof one->gap.b, "%s", e->name_b);
    memcpy(one->gap.point_a, e->point_a, sizeof e->point_a);
    memcpy(one->gap.point_b, e->point_b, sizeof e->point_b);
}

/* The stops, as the arm decides them: on what is left when it stands. That it stands at the start is no event. */
static void note_stop(artist *a, double lo)
{
    double left = INFINITY;
    for (size_t i = 0; i < a->pairs.count; i++) left = fmin(left, a->pairs.at[i].left);
    if (!a->stopped && left < EXAMPLE_PROTECTIVE_M && a->picture.gap_count > 1) mark(a, PICTURE_STOP, lo);
    if (a->stopped && left > EXAMPLE_RESUME_M) mark(a, PICTURE_GO, lo);
    a->stopped = left < EXAMPLE_PROTECTIVE_M || (a->stopped && left <= EXAMPLE_RESUME_M);
}

/* Unknown pairs have no distance: the curve has a gap there. */
static void on_distances(void *context, const collided_batch *batch)
{
    artist *a = context;
    picture *p = &a->picture;
    if (batch->snapshot) a->pairs.count = 0;
    for (size_t i = 0; i < batch->event_count; i++) {
        const collided_event *e = &batch->events[i];
        if (isfinite(e->lo) && isfinite(e->hi) && e->kind != COLLIDED_FAR)
            remember(&a->pairs, e);
        else
            forget(&a->pairs, e->contact);
    }
    const sighting *nearest = NULL;
    for (size_t i = 0; i < a->pairs.count; i++)
        if (!nearest || a->pairs.at[i].gap.hi < nearest->gap.hi) nearest = &a->pairs.at[i];
    if (!nearest) return;
    p->gaps = grow(p->gaps, p->gap_count, &a->gap_capacity, sizeof *p->gaps);
    picture_gap *g = &p->gaps[p->gap_count++];
    *g = nearest->gap;
    g->at_s = now_s(a);
    g->tick = batch->tick;
    note_stop(a, g->lo);
}

static void on_touches(void *context, const collided_batch *batch)
{
    artist *a = context;
    bool first = batch->snapshot && !a->has_contacts;
    a->has_contacts = true;
    if (batch->snapshot) a->contacts.count = 0;
    for (size_t i = 0; i < batch->event_count; i++) {
        const collided_event *e = &batch->events[i];
        if (e->kind == COLLIDED_BEGIN || e->kind == COLLIDED_UPDATE) remember(&a->contacts, e);
        if (e->kind == COLLIDED_END) forget(&a->contacts, e->contact);
        if (e->kind == COLLIDED_BEGIN && !batch->snapshot) mark(a, PICTURE_BEGIN, 0);
        if (e->kind == COLLIDED_END && !first) mark(a, PICTURE_END, 0);
    }
}

static bool subscribe(artist *a, collided *c)
{
    collided_subscription_def distances = collided_subscription_def_default(), touches = distances;
    distances.facts = COLLIDED_DISTANCE;
    distances.select_a = "group:arm";
    distances.select_b = "group:vehicle";
    distances.range_m = RANGE_M;
    distances.tolerance_m = TOLERANCE_M;
    distances.callback = on_distances;
    touches.threshold_m = THRESHOLD_M;
    touches.callback = on_touches;
    distances.context = touches.context = a;
    collided_subscribe(c, &distances);
    collided_subscribe(c, &touches);
    return example_ok(c, collided_sync(c, 5), "cell_picture: subscribing");
}

/* ---- the scene ---- */

/* The path of a file that lies beside this program. */
static const char *beside(pool *p, const char *name)
{
    char self[PATH_MAX];
    ssize_t length = readlink("/proc/self/exe", self, sizeof self - 1);
    while (length > 0 && self[length - 1] != '/') length--;
    return pool_format(p, "%.*s%s", (int)(length > 0 ? length : 0), self, name);
}

static void add_solid(picture *p, const collided_pose *body, collided_shape shape, picture_kind kind)
{
    if (p->solid_count == PICTURE_SOLIDS) {
        fprintf(stderr, "cell_picture: more than %d shapes: the rest is not drawn\n", PICTURE_SOLIDS);
        return;
    }
    picture_solid *s = &p->solids[p->solid_count++];
    shape.pose = collided_pose_product(*body, shape.pose);
    *s = (picture_solid){.shape = shape, .kind = kind};
    if (shape.type == COLLIDED_HULL) s->hull = EXAMPLE_WEDGE, s->hull_count = EXAMPLE_WEDGE_POINTS;
}

/* Above the highest of the body's shapes from `first` on. */
static void add_label(picture *p, const char *name, size_t first)
{
    if (first == p->solid_count) return;
    if (p->label_count == PICTURE_LABELS) {
        fprintf(stderr, "cell_picture: more than %d bodies: %s is drawn without its name\n", PICTURE_LABELS, name);
        return;
    }
    picture_label *l = &p->labels[p->label_count++];
    (void)snprintf(l->name, sizeof l->name, "%s", name);
    l->at[2] = -INFINITY;
    for (size_t i = first; i < p->solid_count; i++) {
        const collided_shape *s = &p->solids[i].shape;
        double top = s->pose.position[2] + (s->type == COLLIDED_SPHERE ? s->radius : s->half[2] + s->radius);
        if (top <= l->at[2]) continue;
        memcpy(l->at, s->pose.position, sizeof l->at);
        l->at[2] = top;
    }
}

/* The daemon tells names and poses; shapes are what the cell is made of: the URDF and example_shapes. */
static void add_body(picture *p, const load_bodies *links, const collided_hit *hit)
{
    collided_pose pose;
    memcpy(pose.position, hit->point_a, sizeof pose.position);
    memcpy(pose.orientation, hit->orientation, sizeof pose.orientation);
    size_t first = p->solid_count;
    for (size_t i = 0; i < links->count; i++)
        for (size_t k = 0; strcmp(links->at[i].name, hit->name_a) == 0 && k < links->at[i].shape_count; k++)
            add_solid(p, &pose, links->at[i].shapes[k].shape, PICTURE_ARM);
    if (p->solid_count > first) {
        if (strcmp(hit->name_a, "wrist_1_link") == 0) add_label(p, "arm", first);
        return;
    }
    collided_shape shapes[EXAMPLE_SHAPES];
    size_t count = example_shapes(hit->name_a, shapes);
    picture_kind kind = strcmp(hit->name_a, "table") == 0     ? PICTURE_TABLE
                        : strcmp(hit->name_a, "vehicle") == 0 ? PICTURE_VEHICLE
                                                              : PICTURE_PART;
    for (size_t i = 0; i < count; i++) add_solid(p, &pose, shapes[i], kind);
    add_label(p, hit->name_a, first);
}

/* The distance that was told for the tick of the poses, or for the last one before it: what did not change is not told
 * again. */
static bool choose_gap(picture *p, int64_t tick)
{
    size_t i = p->gap_count;
    while (i > 0 && p->gaps[i - 1].tick > tick) i--;
    if (i == 0) return false;
    p->shown = p->gaps[i - 1];
    return true;
}

static bool portray(artist *a, collided *c, const load_bodies *links)
{
    picture *p = &a->picture;
    collided_result bodies;
    if (!example_ok(c, collided_query_bodies(c, "*", ANSWER_S, &bodies), "cell_picture: asking for the bodies"))
        return false;
    for (size_t i = 0; i < bodies.count; i++) add_body(p, links, &bodies.hits[i]);
    (void)example_poll_until(c, example_now_ns() + 50000000); /* so that the tick's own distances have come too */
    for (size_t i = 0; i < a->contacts.count && i < PICTURE_CONTACTS; i++)
        memcpy(p->contacts[p->contact_count++], a->contacts.at[i].gap.point_a, sizeof p->contacts[0]);
    if (p->contact_count < a->contacts.count)
        fprintf(stderr, "cell_picture: %zu contacts: only %zu are drawn\n", a->contacts.count, p->contact_count);
    bool good = choose_gap(p, bodies.tick);
    collided_result_free(&bodies);
    return good;
}

/* Watches until the end, and draws the moment, `after_s` or later, when lo falls below `at_m`. */
static bool watch(artist *a, collided *c, const example *e, const load_bodies *links, double after_s, double at_m)
{
    bool was_far = false, done = false;
    picture *p = &a->picture;
    a->start_ns = example_now_ns();
    if (!subscribe(a, c)) return false;
    while (example_running(e)) {
        (void)collided_poll(c, 0.02);
        double lo = p->gap_count ? p->gaps[p->gap_count - 1].lo : INFINITY;
        was_far = (was_far && now_s(a) > after_s) || lo > at_m;
        if (done || now_s(a) < after_s || !was_far || !(lo < at_m)) continue;
        if (!portray(a, c, links)) return false;
        done = true;
    }
    p->seconds = now_s(a);
    if (!done)
        fprintf(stderr,
            "cell_picture: the vehicle did not come nearer than %g mm: wait longer (--seconds), or "
            "take more (--at)\n",
            1e3 * at_m);
    return done;
}

/* ---- the process ---- */

/* Takes `name` and its value out of the arguments; what is left is example_start's. */
static const char *take(int *argc, char **argv, const char *name, const char *otherwise)
{
    for (int i = 1; i + 1 < *argc; i++) {
        if (strcmp(argv[i], name) != 0) continue;
        const char *value = argv[i + 1];
        for (int k = i; k + 2 < *argc; k++) argv[k] = argv[k + 2];
        *argc -= 2;
        return value;
    }
    return otherwise;
}

static double number(const char *text)
{
    char *rest;
    double value = strtod(text, &rest);
    if (rest != text && !*rest && value >= 0 && isfinite(value)) return value;
    fprintf(stderr, "cell_picture: --at takes millimetres and --after seconds, not '%s'\n", text);
    exit(EX_USAGE);
}

static bool load_links(pool *memory, load_bodies *links, load_report *r)
{
    const robot_source source = {.urdf = beside(memory, "arm.urdf"), .srdf = beside(memory, "arm.srdf")};
    robot arm;
    if (!robot_load(&arm, memory, &source, r)) return false;
    double *values = pool_alloc(memory, (size_t)arm.model.joint_count, sizeof *values);
    robot_default_values(&arm, values);
    return robot_bodies(&arm, collided_pose_identity(), values, COLLIDED_MOVING, memory, links, r);
}

/* Connects, watches and leaves. */
static int paint(artist *a, const example *e, pool *memory, double after_s, double at_m)
{
    load_bodies links;
    load_report report = {.error = ""};
    if (!load_links(memory, &links, &report)) return fprintf(stderr, "cell_picture: %s\n", report.error), EX_DATAERR;
    collided *c = example_connect(e, NULL);
    bool painted = c && watch(a, c, e, &links, after_s, at_m);
    if (c) collided_close(c);
    return painted ? EX_OK : EX_UNAVAILABLE;
}

static int write_picture(const picture *p, const char *path)
{
    FILE *out = fopen(path, "w");
    if (!out) return fprintf(stderr, "cell_picture: cannot write %s: %m\n", path), EX_CANTCREAT;
    picture_draw(p, out);
    if (fclose(out) == 0) return EX_OK;
    return fprintf(stderr, "cell_picture: writing %s: %m\n", path), EX_IOERR;
}

int main(int argc, char **argv)
{
    const char *path = take(&argc, argv, "--out", "cell.svg");
    double at_m = 1e-3 * number(take(&argc, argv, "--at", "330")); /* mm in, as the lines print them */
    double after_s = number(take(&argc, argv, "--after", "1"));
    example e = example_start(argc, argv);
    if (e.end_ns == INT64_MAX) e.end_ns = example_now_ns() + 12000000000; /* several crossings */
    static artist a;
    a.picture.protective_m = EXAMPLE_PROTECTIVE_M;
    pool memory = {0};
    int status = paint(&a, &e, &memory, after_s, at_m);
    if (status == EX_OK) status = write_picture(&a.picture, path);
    free(a.pairs.at), free(a.contacts.at), free(a.picture.gaps), free(a.picture.marks);
    pool_free(&memory);
    return status;
}
