/* verb_film: a recording as one HTML file that shows it from disk: the page of collided-web with the frames of its
 * protocol in it (PROTOCOL.md), gzip, base64. What the rerun tells is put into frames as for a page that draws all of
 * them. */
#include "rerun.h"
#include "verbs.h"

#include "window/frames.h"
#include "window/index.h"

#include <errno.h>
#include <fcntl.h>
#include <inttypes.h>
#include <limits.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sysexits.h>
#include <unistd.h>
#include <zlib.h>

enum { EVENTS_A_FRAME = 1024, PIECE = 65536 };

typedef struct film {
    rerun run;
    frame frame;
    unsigned char *at; /* frames, one behind the other, packed */
    size_t count, capacity;
    z_stream packer;
    uint64_t number;                  /* of the last frame */
    uint64_t scene, posed, contacted; /* changes that were put in */
    uint64_t next_event;
    uint32_t revision;
    double origin[3];
    int64_t contacts_ns;
    size_t unpacked;
} film;

/* ---- frames ---- */

static void pack(film *f, const void *at, size_t size, int flush)
{
    f->packer.next_in = (unsigned char *)at; /* which it does not write to */
    f->packer.avail_in = (unsigned)size;
    do {
        f->at = web_reserve(f->at, &f->capacity, f->count + PIECE, 1);
        f->packer.next_out = f->at + f->count;
        f->packer.avail_out = PIECE;
        (void)deflate(&f->packer, flush);
        f->count += PIECE - f->packer.avail_out;
    } while (f->packer.avail_out == 0);
}

static void put_frame(film *f)
{
    frame_number(&f->frame, ++f->number, 0);
    pack(f, frame_octets(&f->frame), f->frame.count, Z_NO_FLUSH);
    f->unpacked += f->frame.count;
}

static void put_hello(film *f)
{
    const ctl_options *o = &f->run.c->options;
    const char *file = f->run.c->arguments[0], *slash = strrchr(file, '/');
    json_buffer j = {.at = NULL};
    json_buffer_raw(&j, "{\"protocol\":\"collided.web.v1\"");
    json_buffer_name(&j, "release");
    json_buffer_text(&j, collided_version());
    json_buffer_name(&j, "connected");
    json_buffer_flag(&j, false);
    json_buffer_name(&j, "epoch");
    json_buffer_whole(&j, 1);
    json_buffer_name(&j, "uri");
    json_buffer_text(&j, slash ? slash + 1 : file);
    json_buffer_name(&j, "rate_hz");
    json_buffer_number(&j, 1e9 / (double)f->run.period_ns);
    json_buffer_name(&j, "range_m");
    json_buffer_number(&j, o->range_m);
    json_buffer_name(&j, "horizon_s");
    json_buffer_number(&j, o->horizon_s);
    json_buffer_name(&j, "control");
    json_buffer_flag(&j, false);
    json_buffer_name(&j, "recording");
    json_buffer_raw(&j, "null");
    frame_names(&j);
    json_buffer_raw(&j, "}");
    frame_text(&f->frame, FRAME_HELLO, f->run.mirror, j.at);
    put_frame(f);
    free(j.at);
}

/* Whole metres in the middle of what is there, so that f32 is enough near it. */
static void choose_origin(film *f)
{
    const mirror *m = f->run.mirror;
    double lo[3] = {INFINITY, INFINITY, INFINITY}, hi[3] = {-INFINITY, -INFINITY, -INFINITY};
    for (size_t i = 0; i < m->body_count; i++)
        for (int k = 0; k < 3 && m->bodies[i].live; k++) {
            lo[k] = fmin(lo[k], m->bodies[i].pose.position[k]);
            hi[k] = fmax(hi[k], m->bodies[i].pose.position[k]);
        }
    for (int k = 0; k < 3; k++) f->origin[k] = hi[k] >= lo[k] ? round(0.5 * (lo[k] + hi[k])) : 0;
}

static void film_scene(film *f)
{
    mirror *m = f->run.mirror;
    if (f->scene && m->scene <= f->scene) return;
    if (!f->scene) put_hello(f);
    if (!f->scene) choose_origin(f);
    frame_scene(&f->frame, m, f->scene, ++f->revision);
    put_frame(f);
    f->scene = m->changes;
}

static void film_poses(film *f)
{
    mirror *m = f->run.mirror;
    if (f->posed && m->poses <= f->posed) return;
    frame_poses(&f->frame, m, f->posed, f->posed == 0 || f->posed < m->scene_since, f->origin, f->revision);
    put_frame(f);
    f->posed = m->changes;
}

static void film_events(void *context)
{
    film *f = context;
    film_scene(f); /* whose bodies they name */
    while (f->next_event <= f->run.mirror->event_count) {
        f->next_event = frame_events(&f->frame, f->run.mirror, f->next_event, f->next_event, EVENTS_A_FRAME);
        put_frame(f);
    }
}

static void film_contacts(film *f, int64_t stamp_ns, bool now)
{
    mirror *m = f->run.mirror;
    if (f->contacted && m->contacts_change <= f->contacted) return;
    if (!now && f->contacted && stamp_ns - f->contacts_ns < f->run.period_ns) return;
    frame_contacts(&f->frame, m, f->contacted, fmax(f->run.c->options.range_m, 0));
    put_frame(f);
    f->contacted = m->changes;
    f->contacts_ns = stamp_ns;
}

static void film_news(void *context, int64_t stamp_ns, bool now)
{
    film *f = context;
    film_scene(f);
    film_poses(f);
    film_events(f);
    film_contacts(f, stamp_ns, now);
}

/* A page takes geometry whenever it comes; those of the beginning come behind the scene that announces them. */
static void film_geometry(void *context, uint32_t number, const collided_geometry_numbers *numbers)
{
    film *f = context;
    film_scene(f);
    frame_geometry(&f->frame, f->run.mirror, number, 0, numbers);
    put_frame(f);
}

/* ---- the file ---- */

static char *read_template(const char *path)
{
    size_t size = 0, capacity = 0, n;
    char *text = NULL;
    FILE *in = fopen(path, "rb");
    if (!in) return NULL;
    do {
        text = web_reserve(text, &capacity, size + PIECE + 1, 1);
        n = fread(text + size, 1, PIECE, in);
        size += n;
    } while (n);
    (void)fclose(in);
    text[size] = '\0';
    return text;
}

/* Of the page that collided-web serves: as COLLIDED_WEB_ROOT says, in the build's folder, or installed. */
static char *find_template(ctl *c)
{
    const char *root = getenv("COLLIDED_WEB_ROOT");
    if (root && *root) return read_template(pool_format(&c->pool, "%s/film.html", root));
    char self[PATH_MAX];
    ssize_t length = readlink("/proc/self/exe", self, sizeof self - 1);
    self[length > 0 ? length : 0] = '\0';
    char *slash = strrchr(self, '/');
    if (slash) *slash = '\0';
    char *text = slash ? read_template(pool_format(&c->pool, "%s/../web/page/film.html", self)) : NULL;
    return text ? text : read_template(COLLIDED_WEB_INSTALLED "/film.html");
}

static void write_base64(FILE *out, const unsigned char *at, size_t size)
{
    static const char LETTERS[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    for (size_t i = 0; i < size; i += 3) {
        size_t left = size - i;
        uint32_t n = (uint32_t)at[i] << 16 | (left > 1 ? (uint32_t)at[i + 1] << 8 : 0) | (left > 2 ? at[i + 2] : 0u);
        const char letters[4] = {LETTERS[n >> 18], LETTERS[n >> 12 & 63], left > 1 ? LETTERS[n >> 6 & 63] : '=',
            left > 2 ? LETTERS[n & 63] : '='};
        (void)fwrite(letters, 1, sizeof letters, out);
    }
}

static int write_film(film *f, char *template, const char *path)
{
    static const char MARK[] = "\nFRAMES\n";
    char *mark = strstr(template, MARK);
    if (!mark)
        return ctl_fail(EX_OSFILE, "film: the page of collided-web is of another release: it has no place for frames");
    int fd = open(path, O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
    FILE *out = fd >= 0 ? fdopen(fd, "wb") : NULL;
    if (!out) return ctl_fail(EX_CANTCREAT, "film: %s: %s", path, strerror(errno));
    size_t head = (size_t)(mark - template) + 1;
    (void)fwrite(template, 1, head, out);
    write_base64(out, f->at, f->count);
    (void)fputs(mark + sizeof MARK - 2, out);
    bool failed = ferror(out) != 0;
    failed |= fclose(out) != 0;
    if (failed) {
        int why = errno;
        (void)unlink(path);
        return ctl_fail(EX_IOERR, "film: %s: %s", path, strerror(why));
    }
    printf("%s: %" PRIu64 " frames of %" PRId64 " ticks, %.3f s; %.1f MB, %.1f MB packed\n", path, f->number,
        f->run.replay.ticks, 1e-9 * (double)(f->run.replay.end_ns - f->run.replay.begin_ns), 1e-6 * (double)f->unpacked,
        1e-6 * (double)f->count);
    return rerun_damage(&f->run);
}

int verb_film(ctl *c)
{
    enum { GZIP = 15 + 16, LEVEL = 6, MEMORY = 8 };
    const char *path = c->options.output;
    if (!path) return ctl_fail(EX_USAGE, "film: --output FILE.html names the file to write");
    if (access(path, F_OK) == 0) return ctl_fail(EX_CANTCREAT, "film: %s is there already: name another file", path);
    char *template = find_template(c);
    if (!template)
        return ctl_fail(EX_OSFILE,
            "film: the page of collided-web (film.html) is not there: install collided-web, or name "
            "its folder by COLLIDED_WEB_ROOT");
    film *f = web_allocate(1, sizeof *f);
    f->next_event = 1;
    f->run = (rerun){
        .c = c, .verb = "film", .context = f, .geometry = film_geometry, .news = film_news, .events = film_events};
    (void)deflateInit2(&f->packer, LEVEL, Z_DEFLATED, GZIP, MEMORY, Z_DEFAULT_STRATEGY);
    int status = rerun_open(&f->run);
    if (!status) status = rerun_run(&f->run);
    pack(f, NULL, 0, Z_FINISH);
    if (!status) status = write_film(f, template, path);
    rerun_close(&f->run);
    (void)deflateEnd(&f->packer);
    frame_free(&f->frame);
    free(f->at);
    free(f);
    free(template);
    return status;
}
