/* trade_picture: time against error, a line a pair of shape types, and beside it the tick of the whole session. The
 * colours can be told apart by colour-blind people (Okabe and Ito), and each line has a mark of its own. */
#include "trade.h"

#include <errno.h>
#include <math.h>
#include <stdio.h>
#include <string.h>
#include <sysexits.h>
#include <unistd.h>

enum { LINES_MAX = 8 }; /* more cannot be told apart; the table has them all */

static const double LEAST_ERROR = 1e-18; /* m: what is shown for 0, on axes without one */

/* ---- the data ---- */

/* The cost that a picture shows of a row: of "all" the tick, otherwise the answer. */
static double cost_of(const trade_row *r)
{
    return r->tick_mean_s > 0 ? r->tick_mean_s : r->time_mean_s;
}

/* No other accuracy of the same pair is at least as good in both, and better in one. */
static bool is_on_front(const trade_row *r, const trade_row *block, size_t levels)
{
    for (size_t i = 0; i < levels; i++) {
        const trade_row *o = &block[i];
        bool as_good = cost_of(o) <= cost_of(r) && o->error_max_m <= r->error_max_m;
        if (as_good && (cost_of(o) < cost_of(r) || o->error_max_m < r->error_max_m)) return false;
    }
    return true;
}

static void write_data(FILE *out, const trade *t)
{
    fputs("# pair accuracy measured ns_mean ns_p99 error_max_m error_mean_m missed false bytes_per_s tick_ns_mean "
          "tick_ns_p99 on_front\n",
        out);
    for (size_t i = 0; i < t->row_count; i++) {
        const trade_row *r = &t->rows[i];
        if (i && i % t->levels == 0) fputs("\n\n", out);
        fprintf(out, "%s\t%s\t%.0f\t%.6g\t%.6g\t%.6g\t%.6g\t%.0f\t%.0f\t%.6g\t%.6g\t%.6g\t%d\n", r->pair, r->accuracy,
            r->measured, 1e9 * r->time_mean_s, 1e9 * r->time_p99_s, r->error_max_m, r->error_mean_m, r->missed,
            r->false_ones, r->bytes_per_s, 1e9 * r->tick_mean_s, 1e9 * r->tick_p99_s,
            is_on_front(r, &t->rows[i - i % t->levels], t->levels));
    }
}

/* ---- the script ---- */

/* In gnuplot's single quotes. */
static void write_quoted(FILE *out, const char *prefix, const char *suffix)
{
    putc('\'', out);
    for (const char *c = prefix; *c; c++) fputs(*c == '\'' ? "''" : (char[2]){*c, '\0'}, out);
    fprintf(out, "%s'", suffix);
}

static bool is_shown(const trade *t, size_t block)
{
    const trade_row *r = &t->rows[block * t->levels];
    size_t before = 0;
    if (!r->errors) return false;
    for (size_t k = 0; k < t->row_count / t->levels - 1; k++) {
        const trade_row *o = &t->rows[k * t->levels];
        before += o->errors > r->errors || (o->errors == r->errors && k < block);
    }
    return before < LINES_MAX;
}

static void write_lines(FILE *out, const trade *t, const char *prefix)
{
    static const char *const colours[LINES_MAX] = {
        "#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9", "#000000", "#999999"};
    static const int marks[LINES_MAX] = {7, 5, 9, 13, 11, 4, 6, 8};
    int line = 0;
    fputs("    plot", out);
    for (size_t block = 0; block + 1 < t->row_count / t->levels; block++) {
        if (!is_shown(t, block)) continue;
        fputs(line ? ", \\\n         " : " ", out);
        write_quoted(out, prefix, ".tsv");
        fprintf(out, " index %zu using (on_axis($6)):($13 > 0 ? $4 : NaN) with lines lw 2 lc rgb '%s' notitle, ", block,
            colours[line]);
        fprintf(out, "'' index %zu using (on_axis($6)):4 with points pt %d ps 0.9 lc rgb '%s' title '%s'", block,
            marks[line], colours[line], t->rows[block * t->levels].pair);
        line++;
    }
    fputs(line ? "\n" : " NaN notitle\n", out);
}

static bool reports_false(const trade *t)
{
    double sum = 0;
    for (size_t i = 0; i < t->levels; i++) sum += trade_all(t)[i].false_ones;
    return sum > 0;
}

/* Would their names lie upon each other? */
static bool are_close(const trade_row *a, const trade_row *b, double highest)
{
    double x = log10(fmax(a->error_max_m, LEAST_ERROR) / fmax(b->error_max_m, LEAST_ERROR));
    return fabs(x) < 1 && fabs(a->tick_mean_s - b->tick_mean_s) < 0.06 * highest;
}

/* The names of the accuracies: one for all that lie close to the first of them. */
static void write_names(FILE *out, const trade *t, double highest)
{
    const trade_row *all = trade_all(t);
    bool named[TRADE_LEVELS_MAX] = {false};
    fputs("    unset label\n", out);
    for (size_t i = 0; i < t->levels; i++) {
        if (named[i] || !isfinite(all[i].error_max_m)) continue;
        fprintf(out, "    set label '%s", all[i].accuracy);
        for (size_t k = i + 1; k < t->levels; k++) {
            if (named[k] || !are_close(&all[i], &all[k], highest)) continue;
            fprintf(out, ", %s", all[k].accuracy);
            named[k] = true;
        }
        fprintf(out, "' at on_axis(%.9g),%.9g left rotate by 30 offset 0.6,0.6 font ',10'\n", all[i].error_max_m,
            1e6 * all[i].tick_mean_s);
    }
}

static void write_session(FILE *out, const trade *t, const trade_advice *a, const char *prefix)
{
    size_t block = t->row_count / t->levels - 1;
    fputs("    plot ", out);
    write_quoted(out, prefix, ".tsv");
    fprintf(out, " index %zu using (on_axis($6)):($13 > 0 ? $11 / 1e3 : NaN) with lines lw 2 lc rgb '#0072B2' notitle",
        block);
    fprintf(out,
        ", \\\n         '' index %zu using (on_axis($6)):($11 / 1e3) with points pt 7 ps 1.1 lc rgb '#0072B2' "
        "title 'mean of a tick'",
        block);
    if (reports_false(t))
        fprintf(out,
            ", \\\n         '' index %zu using ($9 > 0 ? on_axis($6) : NaN):($11 / 1e3):(sprintf('%%d false', $9)) "
            "with labels offset 0,-1.2 font ',10' tc rgb '#D55E00' notitle",
            block);
    fprintf(out,
        ", \\\n         '+' using (on_axis(%.9g)):(%.9g) every ::0::0 with points pt 6 ps 2.6 lw 2 lc rgb "
        "'#D55E00' title 'use %s'\n",
        a->use->error_max_m, 1e6 * a->use->tick_mean_s, a->use->accuracy);
}

/* Of the errors and costs that are shown, with some room around them. */
typedef struct frame {
    double x[2], y[2];
} frame;

static void include(frame *f, const trade_row *r)
{
    double error = fmax(r->error_max_m, LEAST_ERROR), cost = cost_of(r);
    if (!isfinite(error)) return;
    f->x[0] = fmin(f->x[0], error);
    f->x[1] = fmax(f->x[1], error);
    f->y[0] = fmin(f->y[0], cost);
    f->y[1] = fmax(f->y[1], cost);
}

static frame frame_of(const trade *t, bool session)
{
    frame f = {{INFINITY, LEAST_ERROR}, {INFINITY, 0}};
    size_t last = t->row_count / t->levels - 1;
    for (size_t i = 0; i < t->row_count; i++)
        if (session == (i / t->levels == last) && (session || is_shown(t, i / t->levels))) include(&f, &t->rows[i]);
    if (!(f.x[0] <= f.x[1])) return (frame){{LEAST_ERROR, 1}, {1e-9, 1e-6}}; /* nothing is shown */
    return (frame){{0.05 * f.x[0], 20 * f.x[1]}, {0.6 * f.y[0], 1.6 * f.y[1]}};
}

static void write_script(FILE *out, const trade *t, const trade_advice *a, const char *prefix)
{
    frame answers = frame_of(t, false), session = frame_of(t, true);
    fprintf(out,
        "# What accuracy costs: 'gnuplot' and this file's name make the pictures again.\n"
        "on_axis(error) = error > %g ? error : %g\n"
        "set datafile separator '\\t'\n"
        "set datafile missing NaN\n"
        "set logscale x\n"
        "set format x '10^{%%L}'\n"
        "set xtics 1e3 nomirror\n"
        "set mxtics default\n"
        "set ytics nomirror\n"
        "set border 3\n"
        "set grid xtics ytics lt 1 lw 1 lc rgb '#cccccc'\n"
        "set xlabel 'worst error of a bound (m)'\n"
        "do for [kind in 'svg png'] {\n"
        "    if (kind eq 'svg') {\n"
        "        set terminal svg size 1100,520 dynamic font 'sans,13' background '#ffffff'\n"
        "    } else {\n"
        "        set terminal pngcairo size 1100,520 font 'sans,10' background '#ffffff'\n"
        "    }\n"
        "    set output ",
        LEAST_ERROR, LEAST_ERROR);
    write_quoted(out, prefix, ".");
    fprintf(out,
        " . kind\n"
        "    set multiplot layout 1,2 margins 0.07,0.98,0.26,0.92 spacing 0.09\n"
        "    set logscale y\n"
        "    set xrange [%.6g:%.6g]\n"
        "    set yrange [%.6g:%.6g]\n"
        "    set title 'Answers, by pair of shapes; a line is a Pareto front'\n"
        "    set ylabel 'mean time of an answer (ns)'\n"
        "    set key at graph 0.5,-0.2 center top horizontal maxcols 3 samplen 1\n",
        answers.x[0], answers.x[1], 1e9 * answers.y[0], 1e9 * answers.y[1]);
    write_lines(out, t, prefix);
    fprintf(out,
        "    unset logscale y\n"
        "    set xrange [%.6g:%.6g]\n"
        "    set yrange [0:%.6g]\n"
        "    set title 'The whole session: deciding and reporting'\n"
        "    set ylabel 'mean of a tick (us)'\n",
        session.x[0], session.x[1], 1e6 * session.y[1]);
    write_names(out, t, session.y[1]);
    write_session(out, t, a, prefix);
    fputs("    unset label\n    unset multiplot\n}\nunset output\n", out);
}

/* ---- the files ---- */

static int fail_writing(const char *path)
{
    return ctl_fail(EX_CANTCREAT, "trade: %s: %s: give another place by --out", path, strerror(errno));
}

static int write_files(const trade *t, const trade_advice *a, const char *prefix, const char *data, const char *script)
{
    FILE *out = fopen(data, "we");
    if (!out) return fail_writing(data);
    write_data(out, t);
    if (fclose(out) != 0) return fail_writing(data);
    out = fopen(script, "we");
    if (!out) return fail_writing(script);
    write_script(out, t, a, prefix);
    return fclose(out) == 0 ? 0 : fail_writing(script);
}

enum { NO_SUCH_PROGRAM = 127 };

static int run_gnuplot(const char *script)
{
    fflush(stdout);
    pid_t child = fork();
    if (child == 0) {
        execlp("gnuplot", "gnuplot", script, (char *)NULL);
        _exit(errno == ENOENT ? NO_SUCH_PROGRAM : 126);
    }
    return child < 0 ? -1 : trade_end_of(child);
}

int trade_picture(ctl *c, const trade *t, const trade_advice *a, const char *prefix, bool *made)
{
    const char *data = pool_format(&c->pool, "%s.tsv", prefix), *script = pool_format(&c->pool, "%s.gnuplot", prefix);
    *made = false;
    int status = write_files(t, a, prefix, data, script);
    if (status) return status;
    status = run_gnuplot(script);
    *made = status == 0;
    if (status == NO_SUCH_PROGRAM) {
        fprintf(stderr,
            "collidectl: trade: no picture, for there is no gnuplot: apt-get install gnuplot-nox, then: gnuplot %s\n",
            script);
        return 0;
    }
    return *made ? 0 : ctl_fail(EX_SOFTWARE, "trade: no picture: 'gnuplot %s' fails", script);
}
