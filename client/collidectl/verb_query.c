/* verb_query: one question, one answer. A row of the table a kind of question. */
#include "json.h"
#include "options.h"
#include "show.h"
#include "verbs.h"

#include "loaders/text.h"

#include <math.h>
#include <stdio.h>
#include <string.h>
#include <sysexits.h>

typedef struct query_kind {
    const char *name;
    int least, most; /* arguments after the name */
    const char *arguments;
    int (*ask)(ctl *c, char **arguments, collided_result *out);
    void (*print)(const collided_hit *h);
} query_kind;

static double tolerance_m(const ctl_options *o)
{
    return o->tolerance_m < 0 ? 1e-6 : o->tolerance_m;
}

/* Arguments are checked before the connection is made, so that bad usage does not need a daemon. */
static int connected(ctl *c)
{
    return ctl_connect_guest(c);
}

/* ---- asking ---- */

static int ask_ray(ctl *c, char **a, collided_result *out)
{
    double origin[3], direction[3];
    if (!options_vector(a[0], origin) || !options_vector(a[1], direction))
        return ctl_fail(EX_USAGE, "query ray: '%s' '%s': must be X,Y,Z and DX,DY,DZ", a[0], a[1]);
    if (direction[0] == 0 && direction[1] == 0 && direction[2] == 0)
        return ctl_fail(EX_USAGE, "query ray: the direction is zero");
    int status = connected(c);
    if (status) return status;
    return ctl_check(c,
        collided_query_ray(c->client, origin, direction, c->options.length_m, c->options.timeout_s, out), "query ray");
}

static int ask_distance(ctl *c, char **a, collided_result *out)
{
    int status = connected(c);
    if (status) return status;
    return ctl_check(c,
        collided_query_distance(c->client, a[0], a[1], tolerance_m(&c->options), c->options.timeout_s, out),
        "query distance");
}

/* A box: its pose and its full sides. */
static int take_box(const char *kind, char **a, collided_pose *pose, double half[3])
{
    double size[3];
    if (!options_pose(a[0], pose)) return ctl_fail(EX_USAGE, "query %s: '%s': must be X,Y,Z[,W,X,Y,Z]", kind, a[0]);
    if (!options_vector(a[1], size) || size[0] < 0 || size[1] < 0 || size[2] < 0)
        return ctl_fail(EX_USAGE, "query %s: '%s': must be SX,SY,SZ, not negative", kind, a[1]);
    for (int i = 0; i < 3; i++) half[i] = size[i] / 2;
    return 0;
}

static int ask_box(ctl *c, char **a, collided_result *out)
{
    collided_pose pose;
    double half[3];
    int status = take_box("box", a, &pose, half);
    if (!status) status = connected(c);
    if (status) return status;
    return ctl_check(c, collided_query_box(c->client, &pose, half, c->options.timeout_s, out), "query box");
}

static int ask_cast(ctl *c, char **a, collided_result *out)
{
    collided_pose pose;
    double half[3], direction[3];
    int status = take_box("cast", a, &pose, half);
    if (status) return status;
    if (!options_vector(a[2], direction)) return ctl_fail(EX_USAGE, "query cast: '%s': must be DX,DY,DZ", a[2]);
    if (direction[0] == 0 && direction[1] == 0 && direction[2] == 0)
        return ctl_fail(EX_USAGE, "query cast: the direction is zero");
    status = connected(c);
    if (status) return status;
    return ctl_check(c,
        collided_query_cast(c->client, &pose, half, direction, c->options.length_m, c->options.timeout_s, out),
        "query cast");
}

/* Where a body would go, by --linear and --angular. */
static int ask_sweep(ctl *c, char **a, collided_result *out)
{
    const ctl_options *o = &c->options;
    if (!o->has_linear && !o->has_angular)
        return ctl_fail(EX_USAGE, "query sweep: say how it would move: --linear X,Y,Z or --angular X,Y,Z");
    int status = connected(c);
    if (status) return status;
    return ctl_check(c,
        collided_query_sweep(c->client, a[0], o->linear, o->angular, o->span_s, tolerance_m(o), o->timeout_s, out),
        "query sweep");
}

/* A point, or else a body's name; and how many are wanted. */
static int ask_nearest(ctl *c, char **a, collided_result *out)
{
    collided_pose pose;
    double most = 1;
    const double point[3] = {0, 0, 0};
    bool at_point = options_pose(a[0], &pose);
    if (a[1] && !(text_number(a[1], &most) && most >= 1 && most <= 4096 && most == floor(most)))
        return ctl_fail(EX_USAGE, "query nearest: '%s': must be a whole number from 1 to 4096", a[1]);
    int status = connected(c);
    if (status) return status;
    return ctl_check(c,
        collided_query_nearest(c->client, at_point ? NULL : a[0], &pose, point, c->options.length_m, (int32_t)most,
            c->options.timeout_s, out),
        "query nearest");
}

static int ask_explain(ctl *c, char **a, collided_result *out)
{
    int status = connected(c);
    if (status) return status;
    return ctl_check(c, collided_query_explain(c->client, a[0], a[1], c->options.timeout_s, out), "query explain");
}

static int ask_bodies(ctl *c, char **a, collided_result *out)
{
    int status = connected(c);
    if (status) return status;
    return ctl_check(c, collided_query_bodies(c->client, a[0] ? a[0] : "*", c->options.timeout_s, out), "query bodies");
}

/* ---- printing ---- */

static void print_distance(const collided_hit *h)
{
    char interval[96], age[32];
    bool doubtful = h->achieved != COLLIDED_CERTAIN;
    show_interval(h->lo, h->hi, interval, sizeof interval);
    show_age(h->age_s, age, sizeof age);
    printf("%-24s %-24s %26s  age %s%s%s%s\n", h->name_a, h->name_b, interval, age, doubtful ? ", " : "",
        doubtful ? show_achieved(h->achieved) : "", h->stale ? "  unknown: stale" : "");
}

/* lo and hi are times: proven to be apart before the one, and to touch at the other. */
static void print_time(const collided_hit *h)
{
    char bracket[96], age[32];
    show_bracket(h->lo, h->hi, bracket, sizeof bracket);
    show_age(h->age_s, age, sizeof age);
    printf("%-24s in %26s  normal %.6f %.6f %.6f  at %.6f %.6f %.6f  age %s%s\n", h->name_a, bracket, h->axis[0],
        h->axis[1], h->axis[2], h->point_a[0], h->point_a[1], h->point_a[2], age, h->stale ? "  unknown: stale" : "");
}

static void print_body(const collided_hit *h)
{
    const double *p = h->point_a, *q = h->orientation;
    char age[32];
    show_age(h->age_s, age, sizeof age);
    printf("%-32s %10.6f %10.6f %10.6f   %9.6f %9.6f %9.6f %9.6f  age %s%s\n", h->name_a, p[0], p[1], p[2], q[0], q[1],
        q[2], q[3], age, h->stale ? "  stale" : "");
}

static void json_hit(json *j, const collided_hit *h)
{
    json_open(j, NULL, '{');
    json_text(j, "a", h->name_a);
    json_text(j, "b", h->name_b);
    json_number(j, "lo", h->lo);
    json_number(j, "hi", h->hi);
    json_numbers(j, "axis", h->axis, 3);
    json_numbers(j, "point_a", h->point_a, 3);
    json_numbers(j, "point_b", h->point_b, 3);
    json_numbers(j, "orientation", h->orientation, 4);
    json_number(j, "age_s", h->age_s);
    json_bool(j, "stale", h->stale);
    json_text(j, "achieved", show_achieved(h->achieved));
    json_close(j, '}');
}

static void print_query_json(const query_kind *kind, const collided_result *r)
{
    json j = {.out = stdout};
    json_open(&j, NULL, '{');
    json_text(&j, "query", kind->name);
    json_integer(&j, "epoch", r->epoch);
    json_integer(&j, "tick", r->tick);
    json_bool(&j, "truncated", r->truncated);
    json_text(&j, "text", r->text);
    json_open(&j, "hits", '[');
    for (size_t i = 0; i < r->count; i++) json_hit(&j, &r->hits[i]);
    json_close(&j, ']');
    json_close(&j, '}');
    json_end_line(&j);
}

static void print_text(const query_kind *kind, const collided_result *r)
{
    if (r->text && *r->text) printf("%s%s", r->text, r->text[strlen(r->text) - 1] == '\n' ? "" : "\n");
    for (size_t i = 0; i < r->count && kind->print; i++) kind->print(&r->hits[i]);
    if (r->count == 0 && kind->print) puts("none");
    if (r->truncated) puts("... and more: the answer was cut");
}

static const query_kind query_kinds[] = {
    {"ray", 2, 2, "X,Y,Z DX,DY,DZ", ask_ray, print_distance},
    {"distance", 2, 2, "A B", ask_distance, print_distance},
    {"box", 2, 2, "X,Y,Z[,W,X,Y,Z] SX,SY,SZ", ask_box, print_distance},
    {"cast", 3, 3, "X,Y,Z[,W,X,Y,Z] SX,SY,SZ DX,DY,DZ", ask_cast, print_distance},
    {"sweep", 1, 1, "BODY --linear X,Y,Z --angular X,Y,Z [--span S]", ask_sweep, print_time},
    {"nearest", 1, 2, "BODY|X,Y,Z [COUNT]", ask_nearest, print_distance},
    {"explain", 2, 2, "A B", ask_explain, NULL},
    {"bodies", 0, 1, "[PATTERN]", ask_bodies, print_body},
};

enum { QUERY_KINDS = sizeof query_kinds / sizeof *query_kinds };

const char *verb_query_kind(size_t i)
{
    return i < QUERY_KINDS ? query_kinds[i].name : NULL;
}

int verb_query(ctl *c)
{
    const query_kind *kind = NULL;
    for (size_t i = 0; i < QUERY_KINDS; i++)
        if (strcmp(query_kinds[i].name, c->arguments[0]) == 0) kind = &query_kinds[i];
    if (!kind)
        return ctl_fail(EX_USAGE, "query: '%s' is none of ray, distance, box, cast, sweep, nearest, explain, bodies",
            c->arguments[0]);
    int count = c->argument_count - 1;
    if (count < kind->least || count > kind->most)
        return ctl_fail(EX_USAGE, "query: use it as: collidectl query %s %s", kind->name, kind->arguments);
    collided_result result = {0};
    int status = kind->ask(c, c->arguments + 1, &result);
    if (!status && c->options.json)
        print_query_json(kind, &result);
    else if (!status)
        print_text(kind, &result);
    collided_result_free(&result);
    return status;
}
