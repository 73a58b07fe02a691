/* bench_dial: what accuracy costs. First the tick of a robot cell, whose subscriber asks for all distances within half
 * a metre, from the loosest accuracy to the finest, in turns. Then a crowd of compounds with a budget that is a
 * tenth of what its tick takes: is the budget kept, is a contact missed, how wide are the intervals, tick by tick. One
 * thread, one worker; the clock counts this thread's time only, so that other programs on its core do not. */
#include "bench.h"

#include "base/pace.h"
#include "geom/compound.h"
#include "world/coherence.h"
#include "world/world.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

static const double SECONDS = 10, SECONDS_FULL = 60; /* of simulated time */
static const double RANGE = 0.5;                     /* m: distances within it are asked for */

static int64_t now_ns(void)
{
    struct timespec t;
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
    return (int64_t)t.tv_sec * 1000000000 + t.tv_nsec;
}

static world *create_world(const world_subscription *asked)
{
    world_options o = world_options_default();
    world *w = world_create(&o);
    uint32_t id = WORLD_NONE;
    world_put_subscription(w, &id, asked);
    return w;
}

/* ---- accuracy ---- */

typedef struct notch {
    const char *name;
    world_accuracy accuracy;
    double relative;
} notch;

static const notch NOTCHES[] = {
    {"boxes", WORLD_BY_BOXES, 0}, {"1e-3", WORLD_BY_TOLERANCE, 1e-3},
    {"1e-6", WORLD_BY_TOLERANCE, 1e-6}, /* the default */
    {"1e-9", WORLD_BY_TOLERANCE, 1e-9}, {"1e-12", WORLD_BY_TOLERANCE, 1e-12},
    {"verdict", WORLD_BY_VERDICT, 0}, /* touches only */
};
enum { NOTCH_COUNT = sizeof NOTCHES / sizeof *NOTCHES, DEFAULT_NOTCH = 2 };

typedef struct player {
    world *w;
    uint32_t ids[COHERENCE_BODIES_MAX];
    bench_samples ticks;
    uint64_t told;
    double us, us_p99;
} player;

static void begin(player *p, const coherence_scene *scene, const notch *n, size_t ticks)
{
    world_subscription asked = {.facts = n->accuracy == WORLD_BY_VERDICT ? WORLD_TOUCH : WORLD_TOUCH | WORLD_DISTANCE,
        .select_a = "*",
        .select_b = "*",
        .range = RANGE,
        .relative_tolerance = n->relative,
        .accuracy = n->accuracy};
    *p = (player){.w = create_world(&asked)};
    if (!bench_samples_init(&p->ticks, ticks)) abort();
    scene->create(p->w, p->ids);
}

static void play_tick(player *p, const coherence_scene *scene, int tick)
{
    world_batches out;
    scene->move(p->w, p->ids, tick * scene->step_s);
    int64_t start = now_ns();
    world_tick(p->w, tick, &out);
    bench_samples_add(&p->ticks, now_ns() - start);
    for (size_t i = 0; i < out.count; i++) p->told += out.at[i].count;
}

static void tell_notch(const coherence_scene *scene, const notch *n, const player *p, double default_us, bool json)
{
    world_figures f = world_get_figures(p->w);
    double ticks = (double)f.ticks, pairs = (double)f.pair_ticks / ticks, queries = (double)f.narrow_queries / ticks,
           told = (double)p->told / ticks, ratio = default_us / p->us;
    if (json)
        printf("{\"bench\":\"dial\",\"entry\":\"world_tick\",\"scene\":\"%s\",\"accuracy\":\"%s\",\"us_per_tick\":%.3f,"
               "\"us_p99\":%.3f,"
               "\"times_cheaper\":%.3f,\"pairs\":%.1f,\"queries\":%.2f,\"events\":%.2f,\"manifolds\":%llu}\n",
            scene->name, n->name, p->us, p->us_p99, ratio, pairs, queries, told, (unsigned long long)f.manifolds);
    else
        printf("%-12s %-10s %10.1f %10.1f %10.2f %10.1f %10.1f %10.1f\n", scene->name, n->name, p->us, p->us_p99, ratio,
            pairs, queries, told);
}

enum { TURN = 50 }; /* ticks that one is measured for before it is the next one's turn: each has its caches warm */

static void measure_accuracy(const coherence_scene *scene, bool json, double seconds)
{
    static player players[NOTCH_COUNT];
    int ticks = (int)(seconds / scene->step_s);
    for (int n = 0; n < NOTCH_COUNT; n++) begin(&players[n], scene, &NOTCHES[n], (size_t)ticks);
    for (int first = 1; first <= ticks; first += TURN)
        for (int n = 0; n < NOTCH_COUNT; n++)
            for (int t = first; t < first + TURN && t <= ticks; t++)
                play_tick(&players[(n + first / TURN) % NOTCH_COUNT], scene, t);
    for (int n = 0; n < NOTCH_COUNT; n++) {
        players[n].us = bench_percentile_us(&players[n].ticks, 0.5);
        players[n].us_p99 = bench_percentile_us(&players[n].ticks, 0.99);
    }
    for (int n = 0; n < NOTCH_COUNT; n++) {
        tell_notch(scene, &NOTCHES[n], &players[n], players[DEFAULT_NOTCH].us, json);
        bench_samples_free(&players[n].ticks);
        world_destroy(players[n].w);
    }
}

/* ---- the budget ---- */

enum { PEOPLE = 80, LANES = 10, A_LANE = PEOPLE / LANES, PARTS = 8, HZ = 100, SERIES = 60, WARM = 50 };
static const double BUDGET_US = 300, APART = 1.25, LANE_WIDTH = 0.55, CROWD_RANGE = 1.4; /* m */

typedef struct crowd { /* one world of people, and what its subscriber knows */
    world *w;
    uint32_t ids[PEOPLE];
    bool touches[PEOPLE][PEOPLE], near[PEOPLE][PEOPLE], sure[PEOPLE][PEOPLE]; /* sure: hi <= 0 */
    float width[PEOPLE][PEOPLE];                                              /* m, as told last */
    pace pace;
    bench_samples ticks;
    uint64_t undone, over;
} crowd;

static double hash01(uint32_t a, uint32_t b) /* splitmix64 of the two, in [0, 1) */
{
    uint64_t z = ((uint64_t)a << 32 | b) * UINT64_C(0x9e3779b97f4a7c15) + UINT64_C(0x9e3779b97f4a7c15);
    z = (z ^ z >> 30) * UINT64_C(0xbf58476d1ce4e5b9);
    z = (z ^ z >> 27) * UINT64_C(0x94d049bb133111eb);
    return (double)((z ^ z >> 31) >> 11) * 0x1p-53;
}

/* As high as a person: boxes and capsules on top of each other. */
static compound *make_person(void)
{
    shape parts[PARTS];
    pose locals[PARTS];
    for (int i = 0; i < PARTS; i++) {
        const shape box = {.type = SHAPE_BOX, .half = vec(0.2, 0.15, 0.85 / PARTS)},
                    capsule = {.type = SHAPE_CAPSULE, .half = vec(0, 0, 0.85 / PARTS), .radius = 0.2};
        parts[i] = i % 2 ? capsule : box;
        locals[i] = (pose){vec(0.05 * cos(i), 0.05 * sin(i), 0.85 * (2 * (i + 0.5) / PARTS - 1)), {1, 0, 0, 0}};
    }
    compound *person;
    if (compound_build(parts, locals, PARTS, &person) != COMPOUND_OK) abort();
    return person;
}

static double wrapped(double x, double length)
{
    return x - length * floor(x / length);
}

static pose walker_pose(uint32_t i, double t)
{
    uint32_t lane = i / A_LANE;
    double way = lane % 2 ? 1 : -1, speed = 0.8 + 0.6 * hash01(lane, 1), phase = 6.28 * hash01(i, 2);
    double sway = 0.16 * sin(1.7 * t + phase), turn = 0.3 * sin(1.3 * t + phase);
    double x = (i % A_LANE + 0.2 * hash01(i, 3)) * APART + way * speed * t;
    quat q = {cos(turn / 2), 0, 0, sin(turn / 2)};
    return (pose){vec(wrapped(x, A_LANE * APART), lane * LANE_WIDTH + sway, 0.9), q};
}

static uint64_t grant(void *context, uint64_t done)
{
    crowd *c = context;
    return pace_grant(&c->pace, now_ns(), done);
}

static void crowd_begin(crowd *c, const compound *person, bool budget, size_t ticks)
{
    world_subscription asked = {.facts = WORLD_TOUCH | WORLD_DISTANCE,
        .select_a = "*",
        .select_b = "*",
        .range = CROWD_RANGE,
        .relative_tolerance = 1e-6};
    memset(c, 0, sizeof *c);
    c->w = create_world(&asked);
    if (!bench_samples_init(&c->ticks, ticks)) abort();
    pace_init(&c->pace, (int64_t)(1e3 * BUDGET_US));
    if (budget) world_set_budget(c->w, grant, c);
    for (uint32_t i = 0; i < PEOPLE; i++) {
        char name[16];
        snprintf(name, sizeof name, "p%u", i);
        world_shape one = {.shape = {.type = SHAPE_COMPOUND, .compound = person}, .local = POSE_IDENTITY};
        world_body def = {.name = name,
            .group = "",
            .category = 1,
            .mask = 1,
            .pose = walker_pose(i, 0),
            .shapes = &one,
            .shape_count = 1};
        c->ids[i] = WORLD_NONE;
        world_put_body(c->w, &c->ids[i], &def);
    }
}

static void crowd_end(crowd *c)
{
    bench_samples_free(&c->ticks);
    world_destroy(c->w);
}

static void crowd_move(crowd *c, double t)
{
    for (uint32_t i = 0; i < PEOPLE; i++) world_move_body(c->w, c->ids[i], walker_pose(i, t), 0, NULL, NULL);
}

static void learn(crowd *c, const world_batch *b)
{
    c->undone = b->undone;
    for (size_t n = 0; n < b->count; n++) {
        const world_event *e = &b->events[n];
        int a = atoi(e->name_a + 1), k = atoi(e->name_b + 1), i = a > k ? a : k, j = a > k ? k : a;
        if (e->kind == EVENT_BEGIN) c->touches[i][j] = true;
        if (e->kind == EVENT_END) c->touches[i][j] = false;
        if (e->kind == EVENT_NEAR) c->near[i][j] = true;
        if (e->kind == EVENT_FAR) c->near[i][j] = false;
        c->sure[i][j] = c->touches[i][j] && e->hi <= 0;
        c->width[i][j] = (float)(e->hi - e->lo);
    }
}

/* The daemon's own round publishes, too; here the time to learn of the events is not counted. */
static void crowd_tick(crowd *c, int tick)
{
    world_batches out;
    int64_t start = now_ns();
    pace_begin(&c->pace, start);
    world_tick(c->w, tick, &out);
    int64_t ended = now_ns();
    pace_end(&c->pace, ended, world_get_figures(c->w).work);
    if (tick > WARM) { /* by then it knows what a unit takes */
        bench_samples_add(&c->ticks, ended - start);
        c->over += (double)(ended - start) > 1.2e3 * BUDGET_US;
    }
    for (size_t i = 0; i < out.count; i++)
        if (!out.at[i].snapshot) learn(c, &out.at[i]);
}

static const double WIDTH_MAX = 2; /* m: an upper bound that is not known is not wider */

static double mean_width(const crowd *c)
{
    double sum = 0;
    size_t count = 0;
    for (int i = 0; i < PEOPLE; i++)
        for (int k = 0; k < i; k++) {
            if (!c->near[i][k]) continue;
            sum += fmin((double)c->width[i][k], WIDTH_MAX);
            count++;
        }
    return count ? sum / (double)count : 0;
}

typedef struct contact { /* proven in the full run */
    int tick, i, k;
} contact;

typedef struct contacts {
    contact *at;
    size_t count, capacity;
} contacts;

static void note_contacts(contacts *list, const crowd *full, int tick)
{
    for (int i = 0; i < PEOPLE; i++)
        for (int k = 0; k < i; k++) {
            if (!full->sure[i][k]) continue;
            if (list->count == list->capacity) {
                list->capacity = list->capacity ? 2 * list->capacity : 1024;
                list->at = realloc(list->at, list->capacity * sizeof *list->at);
                if (!list->at) abort();
            }
            list->at[list->count++] = (contact){tick, i, k};
        }
}

/* Of those of this tick, which `next` is at. */
static size_t count_missed(const crowd *c, const contacts *list, size_t *next, int tick)
{
    size_t missed = 0;
    for (; *next < list->count && list->at[*next].tick == tick; ++*next)
        missed += !c->touches[list->at[*next].i][list->at[*next].k];
    return missed;
}

static void tell_budget(
    const char *scene, crowd *full, crowd *c, size_t contacts, size_t missed, double width, bool json)
{
    double us_full = bench_percentile_us(&full->ticks, 0.5), us = bench_percentile_us(&c->ticks, 0.5),
           p99 = bench_percentile_us(&c->ticks, 0.99);
    world_figures f = world_get_figures(c->w);
    if (json)
        printf(
            "{\"bench\":\"dial\",\"entry\":\"world_tick\",\"scene\":\"%s\",\"budget_us\":%.0f,\"us_per_tick\":%.3f,"
            "\"us_p99\":%.3f,"
            "\"p50_of_budget\":%.4f,\"p99_of_budget\":%.4f,\"ticks_over\":%llu,\"ticks\":%llu,\"us_full\":%.3f,"
            "\"contacts\":%zu,\"missed\":%zu,\"undone\":%llu,\"unbounded\":%llu,\"width_mean\":%.6g,\"pairs\":%.1f}\n",
            scene, BUDGET_US, us, p99, us / BUDGET_US, p99 / BUDGET_US, (unsigned long long)c->over,
            (unsigned long long)f.ticks, us_full, contacts, missed, (unsigned long long)f.undone,
            (unsigned long long)f.unbounded, width, (double)f.pair_ticks / (double)f.ticks);
    else
        printf("%-16s %10.0f %10.1f %10.1f %10.1f %10.3f %10.3f %9zu %8zu %8llu %12.3g\n", scene, BUDGET_US, us_full,
            us, p99, us / BUDGET_US, p99 / BUDGET_US, contacts, missed, (unsigned long long)f.undone, width);
}

static double time_of(bool still, int tick)
{
    return still ? 0 : (double)tick / HZ;
}

/* One scene without the budget, and then with it. Still: nobody moves after the first tick. */
static void measure_budget(
    const char *scene, const compound *person, bool still, bool json, int ticks, double series[SERIES])
{
    static crowd full, c;
    contacts proven = {0};
    size_t missed = 0, next = 0;
    double width = 0;
    crowd_begin(&full, person, false, (size_t)ticks);
    crowd_begin(&c, person, true, (size_t)ticks);
    for (int t = 1; t <= ticks; t++) {
        if (!still) crowd_move(&full, time_of(still, t));
        crowd_tick(&full, t);
        note_contacts(&proven, &full, t);
    }
    for (int t = 1; t <= ticks; t++) {
        if (!still) crowd_move(&c, time_of(still, t));
        crowd_tick(&c, t);
        missed += count_missed(&c, &proven, &next, t);
        if (t <= SERIES) series[t - 1] = mean_width(&c);
        if (t > ticks - SERIES) width += mean_width(&c) / SERIES;
    }
    tell_budget(scene, &full, &c, proven.count, missed, width, json);
    free(proven.at);
    crowd_end(&full);
    crowd_end(&c);
}

/* ---- the picture ---- */

static void plot_series(FILE *f, const double *series)
{
    for (int t = 0; t < SERIES; t++) fprintf(f, "%d %.9g\n", t + 1, series[t]);
    fputs("e\n", f);
}

static bool plot(const char *path, const char *terminal, const double *still, const double *moving)
{
    FILE *f = popen("gnuplot", "w"); /* NOLINT(cert-env33-c): a fixed line */
    if (!f) return false;
    fprintf(f,
        "set terminal %s\nset output '%s.%s'\nset xlabel 'tick'\n"
        "set yrange [0:]\nset ylabel 'mean width of the intervals told, m'\nset grid\nset key right top\n"
        "set title 'A budget of %.0f us a tick: %d compounds of %d parts'\n"
        "plot '-' using 1:2 with linespoints title 'all stand still', "
        "'-' using 1:2 with linespoints title 'all walk'\n",
        terminal, path, strncmp(terminal, "svg", 3) == 0 ? "svg" : "png", BUDGET_US, PEOPLE, PARTS);
    plot_series(f, still);
    plot_series(f, moving);
    return pclose(f) == 0;
}

/* --plot FILE is taken out of the arguments. */
static const char *take_plot(int *argc, char **argv)
{
    for (int i = 1; i + 1 < *argc; i++) {
        if (strcmp(argv[i], "--plot") != 0) continue;
        const char *path = argv[i + 1];
        for (int k = i; k + 2 <= *argc; k++) argv[k] = argv[k + 2];
        *argc -= 2;
        return path;
    }
    return NULL;
}

int main(int argc, char **argv)
{
    bench_options o;
    const char *picture = take_plot(&argc, argv);
    static double still[SERIES], moving[SERIES];
    if (!bench_parse(argc, argv, SECONDS, SECONDS_FULL, &o)) return 64;
    if (!o.json)
        printf("%-12s %-10s %10s %10s %10s %10s %10s %10s\n", "scene", "accuracy", "us a tick", "p99", "cheaper",
            "pairs", "queries", "events");
    for (int i = 0; i < COHERENCE_SCENES; i++) measure_accuracy(&coherence_scenes[i], o.json, o.seconds);
    if (!o.json)
        printf("\n%-16s %10s %10s %10s %10s %10s %10s %9s %8s %8s %12s\n", "scene", "budget us", "full us", "us a tick",
            "p99", "p50/budget", "p99/budget", "contacts", "missed", "undone", "mean width m");
    compound *person = make_person();
    measure_budget("crowd, still", person, true, o.json, 2 * SERIES, still);
    measure_budget("crowd, walking", person, false, o.json, (int)fmax(o.seconds * HZ, SERIES), moving);
    compound_destroy(person);
    if (!picture) return 0;
    bool drawn =
        plot(picture, "svg size 800,500", still, moving) && plot(picture, "pngcairo size 800,500", still, moving);
    if (!drawn) fprintf(stderr, "no picture %s: is gnuplot installed (package gnuplot-nox)?\n", picture);
    return drawn ? 0 : 1;
}
