/* verb_fit: simpler shapes for a robot's links, each proven to hold its link and to exceed it by no more than asked,
 * and the pairs of links that are proven never to meet; as a table, and as a scene for 'load'. It needs no daemon. */
#include "json.h"
#include "loaders/fit/fit_robot.h"
#include "verbs.h"

#include <errno.h>
#include <string.h>
#include <sysexits.h>
#include <unistd.h>

/* ---- progress ---- */

typedef struct progress {
    double reported_s; /* when the last line was */
    bool terminal;     /* lines replace each other */
    bool any;
} progress;

static void show_fit_progress(void *context, size_t done, size_t of, const char *what)
{
    progress *p = context;
    double now = ctl_now_s();
    if (now - p->reported_s < (p->terminal ? 0.1 : 2)) return;
    fprintf(stderr, p->terminal ? "\r\033[Kcollidectl: fit: %zu of %zu: %.80s" : "collidectl: fit: %zu of %zu: %s\n",
        done, of, what);
    fflush(stderr);
    p->reported_s = now;
    p->any = true;
}

static void end_progress(const progress *p)
{
    if (p->any && p->terminal) fputs("\r\033[K", stderr);
}

/* ---- for people ---- */

static const char *link_word(const fit_link *l)
{
    return l->shape_count == 1 ? fit_shape_word(&l->shapes[0]) : l->how == FIT_AS_IT_WAS ? "as they were" : "several";
}

static size_t corners(const fit_link *l)
{
    size_t sum = 0;
    for (size_t i = 0; i < l->shape_count; i++) sum += l->shapes[i].points.count;
    return sum;
}

static void print_links(const fit_robot *f)
{
    printf("%-24s %-14s %6s %7s %12s %14s %10s %8s %7s\n", "link", "shape", "shapes", "corners", "volume [l]",
        "excess [mm]", "ns before", "ns", "times");
    for (size_t i = 0; i < f->link_count; i++) {
        const fit_link *l = &f->links[i];
        char volume[32] = "";
        if (l->volume > 0) snprintf(volume, sizeof volume, "%.4g", 1e3 * l->volume);
        printf("%-24s %-14s %6zu %7zu %12s %14.4f %10.0f %8.0f %7.1f\n", l->name, link_word(l), l->shape_count,
            corners(l), volume, 1e3 * l->excess_m, l->ns_before, l->ns, l->ns_before / l->ns);
        if (l->note) printf("  %s: %s\n", l->name, l->note);
    }
}

static void print_pair(const fit_robot *f, const fit_pair *p)
{
    printf("  %-24s %-24s", f->links[p->a].name, f->links[p->b].name);
    if (p->answer.verdict == NEVER_PROVEN)
        printf(" at least %.3g mm apart, %zu boxes", 1e3 * p->answer.clearance_m, p->answer.boxes);
    else
        printf(" %s%s%s", never_verdict_word(p->answer.verdict), *p->answer.at ? " at " : "", p->answer.at);
    if (p->disabled) printf("  (SRDF: %s)", p->disabled);
    putchar('\n');
}

static size_t count_pairs(const fit_robot *f, bool proven, bool disabled)
{
    size_t count = 0;
    for (size_t i = 0; i < f->pair_count; i++)
        count += (f->pairs[i].answer.verdict == NEVER_PROVEN) == proven && !!f->pairs[i].disabled == disabled;
    return count;
}

static void print_some(const fit_robot *f, bool proven, bool disabled)
{
    for (size_t i = 0; i < f->pair_count; i++)
        if ((f->pairs[i].answer.verdict == NEVER_PROVEN) == proven && !!f->pairs[i].disabled == disabled)
            print_pair(f, &f->pairs[i]);
}

static bool is_open(const fit_pair *p)
{
    return p->answer.verdict != NEVER_PROVEN && p->answer.verdict != NEVER_MEET && !p->disabled;
}

/* They are checked, and may never meet all the same. */
static void print_open(const fit_robot *f)
{
    size_t count = 0;
    for (size_t i = 0; i < f->pair_count; i++) count += is_open(&f->pairs[i]);
    if (count > 0) printf("\nneither proven never to meet, nor found to: %zu (they are checked)\n", count);
    for (size_t i = 0; i < f->pair_count; i++)
        if (is_open(&f->pairs[i])) print_pair(f, &f->pairs[i]);
}

static void print_pairs(const fit_robot *f)
{
    size_t both = count_pairs(f, true, true), ours = count_pairs(f, true, false), only = count_pairs(f, false, true);
    printf("\nnever meet, proven: %zu of %zu pairs of links", both + ours, f->pair_count);
    if (f->robot->source.srdf) printf(", %zu of them disabled by the SRDF, too", both);
    puts("");
    print_some(f, true, true);
    print_some(f, true, false);
    if (only > 0) printf("\ndisabled by the SRDF, not proven: %zu (its disabling stands)\n", only);
    print_some(f, false, true);
    print_open(f);
}

static void print_gain(const fit_robot *f)
{
    printf("\nall pairs that are checked, once, by the table of costs: %.1f us before, %.1f us with these shapes",
        1e-3 * f->ns_before, 1e-3 * f->ns_shapes);
    if (f->ns < f->ns_shapes) printf(", %.1f us without those that never meet", 1e-3 * f->ns);
    if (f->ns > 0) printf(": %.1f times cheaper", f->ns_before / f->ns);
    puts("");
}

/* ---- as JSON ---- */

static void link_line(json *j, const fit_link *l)
{
    json_open(j, NULL, '{');
    json_text(j, "link", l->name);
    json_text(j, "shape", link_word(l));
    json_integer(j, "shapes", (int64_t)l->shape_count);
    json_integer(j, "corners", (int64_t)corners(l));
    json_number(j, "volume_m3", l->volume);
    json_number(j, "excess_m", l->excess_m);
    json_number(j, "ns_before", l->ns_before);
    json_number(j, "ns", l->ns);
    if (l->note) json_text(j, "note", l->note);
    json_close(j, '}');
    json_end_line(j);
}

static void pair_line(json *j, const fit_robot *f, const fit_pair *p)
{
    json_open(j, NULL, '{');
    json_text(j, "link1", f->links[p->a].name);
    json_text(j, "link2", f->links[p->b].name);
    json_text(j, "verdict", never_verdict_word(p->answer.verdict));
    json_number(j, "clearance_m", p->answer.clearance_m);
    json_integer(j, "boxes", (int64_t)p->answer.boxes);
    if (*p->answer.at) json_text(j, "at", p->answer.at);
    if (p->disabled) json_text(j, "srdf", p->disabled);
    json_close(j, '}');
    json_end_line(j);
}

static void print_fit_json(const fit_robot *f)
{
    json j = {.out = stdout};
    for (size_t i = 0; i < f->link_count; i++) link_line(&j, &f->links[i]);
    for (size_t i = 0; i < f->pair_count; i++) pair_line(&j, f, &f->pairs[i]);
    json_open(&j, NULL, '{');
    json_text(&j, "robot", f->robot->model.name);
    json_number(&j, "ns_before", f->ns_before);
    json_number(&j, "ns_shapes", f->ns_shapes);
    json_number(&j, "ns", f->ns);
    json_close(&j, '}');
    json_end_line(&j);
}

/* ---- the verb ---- */

static int write_scene(const ctl *c, const fit_robot *f)
{
    const char *path = c->options.output;
    FILE *out = fopen(path, "we");
    if (!out) return ctl_fail(EX_CANTCREAT, "fit: %s: %s", path, strerror(errno));
    fit_robot_write(out, f, c->options.excess_m);
    bool bad = ferror(out) != 0;
    if (fclose(out) != 0 || bad) return ctl_fail(EX_IOERR, "fit: %s: %s", path, strerror(errno));
    return 0;
}

int verb_fit(ctl *c)
{
    const ctl_options *o = &c->options;
    progress reported = {.reported_s = ctl_now_s(), .terminal = isatty(STDERR_FILENO)};
    robot_source source = {.urdf = c->arguments[0],
        .srdf = o->srdf,
        .packages = o->packages,
        .package_count = o->package_count,
        .meshes = {.as = LOAD_MESH_SOLID}};
    if (access(source.urdf, R_OK) != 0) return ctl_fail(EX_NOINPUT, "fit: %s: %s", source.urdf, strerror(errno));
    robot r;
    fit_robot f;
    fit_options options = {.excess_m = o->excess_m, .progress = show_fit_progress, .context = &reported};
    if (!robot_load(&r, &c->pool, &source, &c->report)) return ctl_fail_loading(c);
    bool good = fit_robot_make(&c->pool, &r, &options, &f, &c->report);
    end_progress(&reported);
    if (!good) return ctl_fail_loading(c);
    if (o->json) {
        print_fit_json(&f);
    } else {
        print_links(&f);
        print_pairs(&f);
        print_gain(&f);
    }
    return o->output ? write_scene(c, &f) : 0;
}
