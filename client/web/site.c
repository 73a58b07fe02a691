/* site: the files of the page. All of them are read when the server starts, from one folder and those below it, so that
 * no request ever names a file of this machine, and the process needs none later. Without a built page there is one
 * that needs no build (plain/). */
#include "web.h"
#include "window/index.h"

#include <dirent.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

enum { SITE_BYTES = 64 << 20, SITE_FILES = 1024, SITE_DEPTH = 4 };

typedef struct file {
    char *path; /* as in a request: "/assets/page.js" */
    unsigned char *at;
    size_t size;
} file;

struct site {
    file *files;
    size_t count, capacity, bytes;
};

/* plain.c, which the build makes of plain/. */
extern const unsigned char plain_html[], plain_js[], plain_css[];
extern const size_t plain_html_size, plain_js_size, plain_css_size;

static const char *type_of(const char *path)
{
    static const struct {
        const char *ending, *type;
    } TYPES[] = {{".html", "text/html; charset=utf-8"}, {".js", "text/javascript; charset=utf-8"},
        {".mjs", "text/javascript; charset=utf-8"}, {".css", "text/css; charset=utf-8"}, {".wasm", "application/wasm"},
        {".svg", "image/svg+xml"}, {".png", "image/png"}, {".json", "application/json"}, {".map", "application/json"},
        {".txt", "text/plain; charset=utf-8"}, {".woff2", "font/woff2"}, {".ico", "image/x-icon"}};
    const char *dot = strrchr(path, '.');
    for (size_t i = 0; dot && i < sizeof TYPES / sizeof TYPES[0]; i++)
        if (strcmp(dot, TYPES[i].ending) == 0) return TYPES[i].type;
    return "application/octet-stream";
}

static void add_file(site *s, const char *path, const void *data, size_t size)
{
    s->files = web_reserve(s->files, &s->capacity, s->count + 1, sizeof *s->files);
    file *f = &s->files[s->count++];
    *f = (file){.path = strdup(path), .at = web_allocate(LWS_PRE + size + 1, 1), .size = size};
    memcpy(f->at + LWS_PRE, data, size);
    s->bytes += size;
}

static void read_file(site *s, const char *where, const char *path, size_t size)
{
    FILE *from = fopen(where, "re");
    unsigned char *data = web_allocate(size + 1, 1);
    if (from && fread(data, 1, size, from) == size) add_file(s, path, data, size);
    if (from) fclose(from);
    free(data);
}

static void read_folder(site *s, const char *folder, const char *path, int depth)
{
    DIR *d = opendir(folder);
    for (const struct dirent *e; d && (e = readdir(d)) && s->count < SITE_FILES;) {
        char where[1024], name[512];
        struct stat is;
        if (e->d_name[0] == '.') continue;
        int a = snprintf(where, sizeof where, "%s/%s", folder, e->d_name);
        int b = snprintf(name, sizeof name, "%s/%s", path, e->d_name);
        if (a >= (int)sizeof where || b >= (int)sizeof name || stat(where, &is) != 0) continue;
        if (S_ISDIR(is.st_mode) && depth < SITE_DEPTH) read_folder(s, where, name, depth + 1);
        if (S_ISREG(is.st_mode) && s->bytes + (size_t)is.st_size <= SITE_BYTES)
            read_file(s, where, name, (size_t)is.st_size);
    }
    if (d) closedir(d);
}

bool site_find(const site *s, const char *path, site_file *out)
{
    if (strcmp(path, "/") == 0) path = "/index.html";
    for (size_t i = 0; i < s->count; i++) {
        if (strcmp(s->files[i].path, path) != 0) continue;
        *out = (site_file){type_of(path), s->files[i].at + LWS_PRE, s->files[i].size};
        return true;
    }
    return false;
}

site *site_read(const char *root)
{
    site *s = web_allocate(1, sizeof *s);
    site_file index;
    if (root && *root) read_folder(s, root, "", 0);
    bool built = site_find(s, "/index.html", &index);
    add_file(s, built ? "/plain/index.html" : "/index.html", plain_html, plain_html_size);
    add_file(s, built ? "/plain/plain.js" : "/plain.js", plain_js, plain_js_size);
    add_file(s, built ? "/plain/plain.css" : "/plain.css", plain_css, plain_css_size);
    return s;
}

void site_free(site *s)
{
    if (!s) return;
    for (size_t i = 0; i < s->count; i++) {
        free(s->files[i].path);
        free(s->files[i].at);
    }
    free(s->files);
    free(s);
}
