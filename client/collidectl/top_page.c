/* top_page: see top_page.h. Lines are put one after the other; clients and streams share the rows that are left, and
 * say how many they leave out. A character counts as one column. */
#include "top_page.h"

#include "show.h"

#include <inttypes.h>
#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

typedef struct page {
    const top_view *view;
    FILE *out;
    size_t lines;
} page;

typedef enum style { PLAIN, BOLD, REVERSE } style;

/* ---- lines ---- */

/* Bytes of the character at `t`; *shown: it is none that a terminal obeys. */
static size_t character(const char *t, bool *shown)
{
    const unsigned char *b = (const unsigned char *)t;
    size_t length = b[0] < 0xc2 ? 1 : b[0] < 0xe0 ? 2 : b[0] < 0xf0 ? 3 : b[0] < 0xf5 ? 4 : 1;
    for (size_t i = 1; i < length; i++)
        if ((b[i] & 0xc0) != 0x80) length = 1;
    bool control = b[0] < ' ' || b[0] == 127 || (b[0] == 0xc2 && length == 2 && b[1] < 0xa0);
    *shown = !control && (length > 1 || b[0] < 0x80);
    return length;
}

/* Cut to, and with `fill` filled up to, so many columns; 0: as it is. */
static void put_cut(FILE *out, const char *text, size_t columns, bool fill)
{
    size_t used = 0;
    for (const char *t = text; *t && (columns == 0 || used < columns); used++) {
        bool shown;
        size_t length = character(t, &shown);
        if (shown)
            fwrite(t, 1, length, out);
        else
            putc('?', out);
        t += length;
    }
    for (; fill && used < columns; used++) putc(' ', out);
}

static size_t width_of(const char *text)
{
    size_t width = 0;
    bool shown;
    for (const char *t = text; *t; t += character(t, &shown)) width++;
    return width;
}

static void put_line(page *p, style how, const char *text)
{
    const top_view *v = p->view;
    if (v->rows && p->lines == v->rows) return;
    bool styled = v->styled && how != PLAIN;
    if (styled) fputs(how == BOLD ? "\033[1m" : "\033[7m", p->out);
    put_cut(p->out, text, v->columns, styled && how == REVERSE);
    if (styled) fputs("\033[0m", p->out);
    putc('\n', p->out);
    p->lines++;
}

__attribute__((format(printf, 3, 4))) static void line(page *p, style how, const char *format, ...)
{
    char text[2048];
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(text, sizeof text, format, arguments);
    va_end(arguments);
    put_line(p, how, text);
}

/* ---- lists of words that go on in the next line ---- */

enum { TITLE = 10, LIST_LINES = 3 };

typedef struct list {
    page *page;
    char text[1024];
    size_t lines;
    bool left_out; /* there was no room for all */
} list;

static void begin_list(list *l, page *p, const char *title)
{
    *l = (list){.page = p};
    snprintf(l->text, sizeof l->text, "%-*s", TITLE, title);
}

static void add_word(list *l, const char *word)
{
    size_t columns = l->page->view->columns, used = strlen(l->text);
    bool first = used == TITLE;
    if (!first && columns && width_of(l->text) + 2 + width_of(word) > columns) {
        if (l->lines + 1 >= LIST_LINES) {
            l->left_out = true;
            return;
        }
        put_line(l->page, PLAIN, l->text);
        l->lines++;
        snprintf(l->text, sizeof l->text, "%-*s", TITLE, "");
        used = TITLE;
        first = true;
    }
    if (l->left_out) return;
    snprintf(l->text + used, sizeof l->text - used, "%s%s", first ? "" : "  ", word);
}

static void end_list(list *l, const char *if_empty)
{
    size_t used = strlen(l->text), columns = l->page->view->columns;
    if (used == TITLE && l->lines == 0) snprintf(l->text + used, sizeof l->text - used, "%s", if_empty);
    if (l->left_out && columns > 4 && used + 4 > columns) l->text[columns - 4] = '\0';
    used = strlen(l->text);
    if (l->left_out) snprintf(l->text + used, sizeof l->text - used, " ...");
    put_line(l->page, PLAIN, l->text);
}

/* ---- numbers ---- */

static const char *count(double n, char out[16])
{
    if (n < 9999.5)
        snprintf(out, 16, n < 99.95 && n > 0 ? "%.1f" : "%.0f", n);
    else if (n < 9.9995e6)
        snprintf(out, 16, "%.4gk", n / 1e3);
    else
        snprintf(out, 16, "%.4gM", n / 1e6);
    return out;
}

static const char *span(int64_t ns, char out[16])
{
    if (ns <= 0)
        snprintf(out, 16, "-");
    else if (ns < 1000000000)
        show_span(1e-9 * (double)ns, out, 16);
    else
        snprintf(out, 16, "%.1f s", 1e-9 * (double)ns);
    return out;
}

static const char *uptime(const top_status *t, char out[32])
{
    int64_t s = (t->stamp_ns - t->started_ns) / 1000000000;
    if (s < 60)
        snprintf(out, 32, "%" PRId64 " s", s);
    else if (s < 3600)
        snprintf(out, 32, "%" PRId64 " min %" PRId64 " s", s / 60, s % 60);
    else if (s < 86400)
        snprintf(out, 32, "%" PRId64 " h %" PRId64 " min", s / 3600, s / 60 % 60);
    else
        snprintf(out, 32, "%" PRId64 " d %" PRId64 " h", s / 86400, s / 3600 % 24);
    return out;
}

/* ---- the parts ---- */

static void put_health(page *p)
{
    const top_sample *s = p->view->sample;
    char up[32];
    if (p->view->unheard_s > 0) {
        line(p, BOLD, "collided  NOT HEARD for %.0f s: it is looked for; last known:", p->view->unheard_s);
        if (!s->now.epoch) return;
    }
    if (!s->now.epoch) {
        line(p, BOLD, "collided  nothing is known yet");
        return;
    }
    line(p, BOLD, "collided  %s, %s, release %s, up %s", s->now.health, s->now.daemon, s->now.release,
        uptime(&s->now, up));
    line(p, PLAIN, "links     %s", s->now.links);
    line(p, *s->now.limits ? BOLD : PLAIN, "limits    %s", *s->now.limits ? s->now.limits : "none reached");
}

static void put_rates(page *p)
{
    const top_sample *s = p->view->sample;
    char ticks[16], poses[16], events[16], batches[16];
    line(p, PLAIN, "ticks     %s/s, load %.1f %%, poses %s/s, events %s/s, batches %s/s",
        count(top_rate(s, "ticks"), ticks), 100 * top_load(s), count(top_rate(s, "moves"), poses),
        count(top_rate(s, "events_out"), events), count(top_rate(s, "batches_out"), batches));
}

static void put_times_line(page *p, const char *title, const char *const names[4])
{
    char t[4][16];
    for (int i = 0; i < 4; i++) span(top_figure(p->view->sample, names[i]), t[i]);
    line(p, PLAIN, "%-*sp50 %-9s p90 %-9s p99 %-9s most %s", TITLE, title, t[0], t[1], t[2], t[3]);
}

static void put_world(page *p)
{
    static const char *const figures[] = {
        "bodies", "shapes", "pairs", "contacts", "subscriptions", "streams", "geometries"};
    const top_sample *s = p->view->sample;
    list l;
    char word[96];
    begin_list(&l, p, "world");
    for (size_t i = 0; i < sizeof figures / sizeof *figures; i++) {
        snprintf(word, sizeof word, "%" PRId64 " %s", top_figure(s, figures[i]), figures[i]);
        add_word(&l, word);
    }
    if (top_figure(s, "stale_bodies")) {
        snprintf(word, sizeof word, "%" PRId64 " STALE", top_figure(s, "stale_bodies"));
        add_word(&l, word);
    }
    if (top_figure(s, "lost_bodies")) {
        snprintf(word, sizeof word, "%" PRId64 " of LOST clients", top_figure(s, "lost_bodies"));
        add_word(&l, word);
    }
    end_list(&l, "empty");
}

static void put_budget(page *p)
{
    const top_sample *s = p->view->sample;
    char budget[16];
    if (top_figure(s, "budget_ns") == 0)
        line(p, PLAIN, "budget    none: every pair is settled in its tick");
    else
        line(p, PLAIN,
            "budget    %s: %" PRId64 " units done, %" PRId64 " pairs undone (%" PRId64
            " unbounded), %.1f ticks/s left some",
            span(top_figure(s, "budget_ns"), budget), top_figure(s, "work"), top_figure(s, "undone"),
            top_figure(s, "unbounded"), top_rate(s, "undone_ticks"));
}

static void put_pairs(page *p)
{
    const top_sample *s = p->view->sample;
    list l;
    double all = 0;
    size_t at = 0;
    for (top_member m; top_next(s, "pairs_by_", &at, &m);) all += m.rate;
    begin_list(&l, p, "pairs/s");
    at = 0;
    for (top_member m; top_next(s, "pairs_by_", &at, &m);) {
        char word[96], number[16];
        if (!(m.rate > 0)) continue;
        snprintf(word, sizeof word, "%s %s (%.0f %%)", m.rest, count(m.rate, number), 100 * m.rate / all);
        add_word(&l, word);
    }
    end_list(&l, "none");
}

static void put_drops(page *p)
{
    const top_sample *s = p->view->sample;
    list l;
    size_t at = 0;
    begin_list(&l, p, "drops");
    for (top_drop d; top_next_drop(s, &at, &d);) {
        char word[96], number[16];
        if (d.rate > 0)
            snprintf(word, sizeof word, "%.60s %" PRId64 " (%s/s)", d.cause, d.total, count(d.rate, number));
        else
            snprintf(word, sizeof word, "%.60s %" PRId64, d.cause, d.total);
        add_word(&l, word);
    }
    end_list(&l, "none since the start");
}

/* A name in so many columns. */
static const char *cell(const char *name, size_t columns, char *out, size_t size)
{
    FILE *to = fmemopen(out, size, "w");
    if (!to) return "";
    put_cut(to, name, columns, true);
    fputc('\0', to);
    fclose(to);
    return out;
}

static size_t name_columns(const page *p, size_t others, size_t widest)
{
    size_t columns = p->view->columns;
    size_t room = !columns ? widest : columns > others + 12 ? columns - others : 12;
    return room < widest ? room : widest;
}

static void put_left_out(page *p, size_t shown, size_t there, size_t in_all)
{
    if (shown < there || there < in_all) line(p, PLAIN, "  and %zu more", (in_all > there ? in_all : there) - shown);
}

static void put_clients_table(page *p, const top_client *clients, size_t there, size_t shown, size_t in_all)
{
    char name[512], poses[16], age[16], silent[16], work[16];
    size_t widest = 6;
    for (size_t i = 0; i < shown; i++) widest = width_of(clients[i].name) > widest ? width_of(clients[i].name) : widest;
    size_t columns = name_columns(p, 59, widest);
    line(p, REVERSE, "%s  %-16s %6s %7s %8s %8s %7s", cell("CLIENT", columns, name, sizeof name), "NUMBER", "BODIES",
        "POSES/S", "POSE AGE", "SILENT", "WORK");
    for (size_t i = 0; i < shown; i++) {
        const top_client *c = &clients[i];
        line(p, PLAIN, "%s  %-16s %6" PRId64 " %7s %8s %8s %7s", cell(c->name, columns, name, sizeof name), c->id,
            c->bodies, count(c->poses, poses), span(c->pose_age_ns, age), span(c->silent_ns, silent),
            count((double)c->work, work));
    }
    put_left_out(p, shown, there, in_all);
}

static void put_streams_table(page *p, const top_stream *streams, size_t there, size_t shown, size_t in_all)
{
    char name[512], events[16], work[16];
    size_t widest = 6;
    for (size_t i = 0; i < shown; i++) widest = width_of(streams[i].name) > widest ? width_of(streams[i].name) : widest;
    size_t columns = name_columns(p, 18, widest);
    line(p, REVERSE, "%s  %8s %7s", cell("STREAM", columns, name, sizeof name), "EVENTS/S", "WORK");
    for (size_t i = 0; i < shown; i++)
        line(p, PLAIN, "%s  %8s %7s", cell(streams[i].name, columns, name, sizeof name),
            count(streams[i].events, events), count((double)streams[i].work, work));
    put_left_out(p, shown, there, in_all);
}

/* Each has a head and may need a line that tells how many are left out; the clients get two thirds of what both want.
 */
static void put_tables(page *p)
{
    const top_sample *s = p->view->sample;
    top_client clients[TOP_ROWS_MAX];
    top_stream streams[TOP_ROWS_MAX];
    size_t client_count = top_clients(s, clients), stream_count = top_streams(s, streams);
    size_t all_clients = (size_t)top_figure(s, "clients"), all_streams = (size_t)top_figure(s, "streams");
    size_t first = client_count, second = stream_count;
    if (p->view->rows) {
        size_t room = p->view->rows > p->lines + 4 ? p->view->rows - p->lines - 4 : 0;
        if (first + second > room) {
            size_t least = room - room / 3;
            second = second < room / 3 ? second : first < least ? room - first : room / 3;
            first = first < room - second ? first : room - second;
        }
    }
    put_clients_table(p, clients, client_count, first, all_clients);
    put_streams_table(p, streams, stream_count, second, all_streams);
}

char *top_page(const top_view *v)
{
    static const char *const latency[4] = {"latency_p50_ns", "latency_p90_ns", "latency_p99_ns", "latency_most_ns"};
    static const char *const tick[4] = {"tick_p50_ns", "tick_p90_ns", "tick_p99_ns", "tick_most_ns"};
    char *text = NULL;
    size_t size;
    page p = {v, open_memstream(&text, &size), 0};
    if (!p.out) return NULL;
    put_health(&p);
    if (v->sample->now.epoch) {
        put_rates(&p);
        put_times_line(&p, "latency", latency);
        put_times_line(&p, "tick", tick);
        put_world(&p);
        put_budget(&p);
        put_pairs(&p);
        put_drops(&p);
        put_tables(&p);
    }
    fclose(p.out);
    return text;
}
