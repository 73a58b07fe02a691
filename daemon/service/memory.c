/* memory: how much there may be, how much there is, and who may still grow. */
#include "memory.h"

#include "base/ahead.h"
#include "base/log.h"
#include "clients.h"
#include "commands.h"
#include "geom/hull.h"
#include "geom/mesh.h"
#include "geometries.h"
#include "service.h"
#include "shares.h"
#include "vertices.h"
#include "wire/wire_model.h"

#include <fcntl.h>
#include <inttypes.h>
#include <malloc.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <sys/sysinfo.h>
#include <unistd.h>

static const int64_t MIB = INT64_C(1) << 20;
static const int64_t LOOK_NS = 10000000;            /* a look is good for so long, ... */
static const int64_t LOOK_BYTES = 16 << 20;         /* ... and for so much that is let in */
static const int64_t TRIM_NS = 1000000000;          /* between two: each may take milliseconds; ... */
static const int64_t TRIM_IN_VAIN_NS = 10000000000; /* ... and after one that brought little */
static const int64_t LEAST_LIMIT = 32 << 20;        /* bytes: the daemon itself, its links and their threads */

/* What things take, in bytes, rounded up from what was measured: pairs 1,200 with one subscriber, triangles 360, points
 * of a hull 820. */
static const int64_t PAIR_BYTES = 3072;    /* and its contact, reported to one subscriber */
static const int64_t WATCH_BYTES = 1536;   /* a pair that one more subscriber is told of, and the event */
static const int64_t TRIANGLE_BYTES = 512; /* while a mesh is built; 240 when it is there */
static const int64_t POINT_BYTES = 1024;   /* while a hull is built */
static const int64_t SHAPE_BYTES = 2048, BODY_BYTES = 2048, NAMED_BYTES = 16384, POSE_BYTES = 256;
static const int64_t ROBOT_BYTES = 65536; /* of the largest that a body may carry */
static const int64_t VERTEX_BYTES = 1024; /* of a soft body: its places, boxes, and frames that wait */
static const int64_t ANSWER_BYTES = 2 << 20;

/* ---- what is granted ---- */

static int64_t read_number(const char *path)
{
    char text[32] = "";
    FILE *f = fopen(path, "re");
    if (!f) return INT64_MAX;
    if (!fgets(text, sizeof text, f)) text[0] = '\0';
    fclose(f);
    char *end;
    long long number = strtoll(text, &end, 10);
    return end != text && number > 0 ? number : INT64_MAX; /* "max"; a number too large is LLONG_MAX */
}

static int64_t least(int64_t a, int64_t b)
{
    return a < b ? a : b;
}

/* Of that group and all above it. Where a container does not see its own path, that of the top is its own. */
static int64_t least_on_path(const char *mount, char *path, const char *const *files)
{
    int64_t granted = INT64_MAX;
    for (;;) {
        for (int i = 0; files[i]; i++) {
            char at[1600];
            snprintf(at, sizeof at, "%s%s/%s", mount, path, files[i]);
            granted = least(granted, read_number(at));
        }
        char *last = strrchr(path, '/');
        if (!last) return granted;
        *last = '\0';
    }
}

static bool names_memory(const char *controllers)
{
    const char *at = strstr(controllers, "memory");
    return at && (at == controllers || at[-1] == ',') && (at[6] == '\0' || at[6] == ',');
}

/* A line of /proc/self/cgroup: number, controllers, path. */
static int64_t granted_by_line(const char *root, char *line)
{
    static const char *const FILES_2[] = {"memory.max", "memory.high", NULL};
    static const char *const FILES_1[] = {"memory.limit_in_bytes", NULL};
    char mount[512], *controllers = strchr(line, ':'), *path = controllers ? strchr(controllers + 1, ':') : NULL;
    if (!path) return INT64_MAX;
    *path++ = '\0';
    path[strcspn(path, "\n")] = '\0';
    if (strcmp(path, "/") == 0) *path = '\0';
    bool is_2 = controllers[1] == '\0';
    if (!is_2 && !names_memory(controllers + 1)) return INT64_MAX;
    snprintf(mount, sizeof mount, "%s/sys/fs/cgroup%s", root, is_2 ? "" : "/memory");
    return least_on_path(mount, path, is_2 ? FILES_2 : FILES_1);
}

int64_t memory_granted(const char *root)
{
    char path[512], line[1024];
    struct sysinfo machine;
    int64_t granted = sysinfo(&machine) == 0 ? (int64_t)machine.totalram * machine.mem_unit : INT64_MAX;
    snprintf(path, sizeof path, "%s/proc/self/cgroup", root);
    FILE *f = fopen(path, "re");
    while (f && fgets(line, sizeof line, f)) granted = least(granted, granted_by_line(root, line));
    if (f) fclose(f);
    return granted;
}

/* ---- what there is ---- */

/* The first two numbers of statm: pages of addresses, pages that are resident. */
static void look(service *s)
{
    memory_gauge *g = s->memory;
    char text[128] = "", *at = text;
    g->looked_ns = s->monotonic_ns;
    g->pairs = (int64_t)world_get_figures(s->world).pairs;
    if (g->statm < 0 || pread(g->statm, text, sizeof text - 1, 0) <= 0) return;
    int64_t page = sysconf(_SC_PAGESIZE), size = strtoll(at, &at, 10) * page;
    g->resident = strtoll(at, &at, 10) * page;
    g->left = least(g->limit - g->resident, g->space == INT64_MAX ? INT64_MAX : g->space - size);
}

static void look_again(service *s)
{
    const memory_gauge *g = s->memory;
    if (s->monotonic_ns - g->looked_ns >= LOOK_NS || g->promised >= LOOK_BYTES) look(s);
}

/* So much is kept for what no command asks for: events, answers, buffers of the links. */
static int64_t reserve(const memory_gauge *g)
{
    return g->limit / 16;
}

/* So much stays free for those who have little: the same share as of other limits. */
static int64_t others_share(const service *s)
{
    int64_t part = s->memory->limit / 100 * (100 - s->config.share);
    return part > reserve(s->memory) ? part : reserve(s->memory);
}

static int64_t room(const memory_gauge *g)
{
    return g->left - g->promised;
}

void memory_open(service *s)
{
    memory_gauge *g = s->memory = base_alloc(1, sizeof *g);
    struct rlimit space;
    *g = (memory_gauge){.statm = -1, .limit = INT64_MAX, .space = INT64_MAX, .left = INT64_MAX};
    if (s->replaying) return;
    int64_t given = s->config.memory_limit * MIB, half = memory_granted("") / 2;
    g->limit = given ? given : half > LEAST_LIMIT ? half : LEAST_LIMIT;
    if (getrlimit(RLIMIT_AS, &space) == 0 && space.rlim_cur < INT64_MAX)
        g->space = (int64_t)space.rlim_cur - (int64_t)space.rlim_cur / 8;
    g->statm = open("/proc/self/statm", O_RDONLY | O_CLOEXEC);
    if (g->statm < 0) log_warning("memory_limit is not kept: /proc/self/statm cannot be read");
    look(s);
    if (g->left <= reserve(g))
        log_warning("memory_limit = %" PRId64 " MiB: %" PRId64
                    " MiB are in use already, so that nothing may be announced",
            g->limit / MIB, g->resident / MIB);
}

void memory_close(service *s)
{
    if (!s->memory) return;
    if (s->memory->statm >= 0) close(s->memory->statm);
    free(s->memory);
    s->memory = NULL;
}

bool memory_is_short(const service *s)
{
    return s->memory->statm >= 0 && room(s->memory) < reserve(s->memory);
}

/* ---- what a command will need ---- */

/* One that is too large is refused by that name (geometry.c), before memory is set aside for it. */
static int64_t need_of_geometry(const wire_geometry *m)
{
    int64_t bytes = geometry_bytes(m->vertex_numbers, m->index_numbers);
    int64_t triangles = m->kind == WIRE_GEOMETRY_MESH           ? m->index_numbers / 3
                        : m->kind == WIRE_GEOMETRY_SOFT         ? m->index_numbers / 3
                        : m->kind == WIRE_GEOMETRY_HEIGHT_FIELD ? 2 * (int64_t)m->vertex_numbers
                                                                : 0;
    int64_t points = triangles ? 0 : m->vertex_numbers / 3;
    if (triangles > MESH_TRIANGLES_MAX + 2 * WIRE_FIELD_HEAD || points > HULL_VERTICES_MAX)
        return geometry_bytes(m->vertices.count, m->indices.count);
    return bytes + TRIANGLE_BYTES * triangles + POINT_BYTES * points;
}

/* Who asks for one name is told of few of the pairs. */
static int64_t need_of_subscription(const service *s, const wire_subscription *m)
{
    bool wide = strpbrk(m->select_a, "*?") || !*m->select_a || strncmp(m->select_a, "group:", 6) == 0;
    return NAMED_BYTES + (wide ? WATCH_BYTES * (int64_t)world_get_figures(s->world).pairs : 0);
}

/* 0: it makes nothing grow. *may_use_reserve: it is not to wait for those that announce. */
static int64_t need_of(service *s, const wire_message *m, bool *may_use_reserve)
{
    *may_use_reserve = false;
    switch (m->kind) {
    case WIRE_CLIENT:
        return m->client.removed ? 0 : NAMED_BYTES;
    case WIRE_GEOMETRY:
        return m->geometry.removed ? 0 : need_of_geometry(&m->geometry);
    case WIRE_BODY:
        return m->body.removed ? 0
                               : BODY_BYTES + SHAPE_BYTES * m->body.shape_types.count + (int64_t)wire_lcm_size(m) +
                                     VERTEX_BYTES * (int64_t)vertices_of_body(s, &m->body) +
                                     (m->body.extensions.count ? ROBOT_BYTES : 0);
    case WIRE_VERTEX_BATCH: /* a frame replaces another one, or waits: what its body may take has been counted, mostly
                             */
        *may_use_reserve = true;
        return (int64_t)wire_lcm_size(m);
    case WIRE_SUBSCRIPTION:
        return m->subscription.removed ? 0 : need_of_subscription(s, &m->subscription);
    case WIRE_POSE_BATCH: /* those of lock-step are kept until their step is complete */
        *may_use_reserve = true;
        return m->pose_batch.step ? POSE_BYTES * (int64_t)(m->pose_batch.bodies.count +
                                                           wire_joints_poses_most(m->pose_batch.extensions))
                                  : 0;
    case WIRE_QUERY:
        *may_use_reserve = true;
        return ANSWER_BYTES;
    default:
        return 0;
    }
}

/* Of a geometry each piece waits for its whole, which is needed once. */
static int64_t promise_of(const wire_message *m, int64_t need)
{
    return m->kind == WIRE_GEOMETRY && m->geometry.piece + 1 < m->geometry.pieces ? (int64_t)wire_lcm_size(m) : need;
}

static void report_short(service *s)
{
    memory_gauge *g = s->memory;
    if (!g->reported)
        log_warning("memory_limit = %" PRId64 " MiB is nearly reached: %" PRId64
                    " MiB are in use, and nothing that would need more is let in",
            g->limit / MIB, g->resident / MIB);
    g->reported = true;
    apply_name_limit(s, "memory_limit");
}

/* A client that is known may always say that it is there. */
static bool is_sign_of_life(service *s, const wire_message *m)
{
    return m->kind == WIRE_CLIENT && session_find(s, m->client.client);
}

/* What it is not to take of what there is. Who has more than stays free for others is not one of those others. */
static int64_t kept_from(service *s, const struct link *from, const wire_message *m, int64_t need)
{
    bool has_much = shares_bytes(s, from, m) + need > others_share(s);
    return has_much ? others_share(s) : reserve(s->memory);
}

bool memory_admit(service *s, const struct link *from, const wire_message *m, wire_refusal *why)
{
    memory_gauge *g = s->memory;
    bool may_use_reserve;
    if (g->statm < 0 || is_sign_of_life(s, m)) return true;
    int64_t need = need_of(s, m, &may_use_reserve);
    if (!need) return true;
    look_again(s);
    if (room(g) - (may_use_reserve ? 0 : kept_from(s, from, m, need)) >= need) {
        g->promised += m->kind == WIRE_QUERY ? 0 : promise_of(m, need);
        return true;
    }
    why->reason = WIRE_LIMIT;
    snprintf(why->text, sizeof why->text,
        "memory_limit = %" PRId64 " MiB is reached: %" PRId64 " MiB are in use, and this may need %" PRId64 " KiB more",
        g->limit / MIB, g->resident / MIB, need / 1024);
    metric_count(s->count.memory_refused, 1);
    report_short(s);
    return false;
}

/* ---- in a tick ---- */

int64_t memory_pairs_most(service *s)
{
    memory_gauge *g = s->memory;
    if (g->statm < 0) return 0;
    look_again(s);
    int64_t spare = g->left - others_share(s), most = g->pairs + (spare > 0 ? spare / PAIR_BYTES : 0);
    return most >= s->config.max_pairs ? 0 : most > 0 ? most : 1;
}

void memory_after_tick(service *s)
{
    s->memory->promised = 0;
}

/* Arrays keep what they have grown to: where that is what makes memory short, it is given back. */
void memory_trim(service *s)
{
    memory_gauge *g = s->memory;
    if (g->statm < 0 || s->monotonic_ns < g->next_trim_ns) return;
    look_again(s);
    bool is_short = g->left < 2 * reserve(g);
    ahead_allow(!is_short);
    if (!is_short) g->reported = false;
    if (!is_short) return;
    int64_t before = g->resident;
    world_trim(s->world);
    malloc_trim(0);
    look(s);
    bool gained = before - g->resident > g->limit / 64;
    g->next_trim_ns = s->monotonic_ns + (gained ? TRIM_NS : TRIM_IN_VAIN_NS);
}
