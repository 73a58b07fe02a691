/* store: looking things up, and remembering them. One thread. */
#include "store.h"

#include <stdlib.h>
#include <string.h>

void *store_grow(pool *p, void *items, size_t count, size_t *room, size_t size)
{
    if (count < *room) return items;
    *room = *room ? 2 * *room : 16;
    void *more = pool_alloc(p, *room, size);
    if (count) memcpy(more, items, count * size);
    return more;
}

/* ---- bodies ---- */

static size_t place_of(const store *s, const char *name)
{
    size_t i = 0;
    while (i < s->body_count && strcmp(s->bodies[i].name, name) != 0) i++;
    return i;
}

int32_t store_find(const store *s, const char *name)
{
    size_t i = place_of(s, name);
    return i < s->body_count ? s->bodies[i].id : -1;
}

int32_t store_id_for(const store *s, const char *name, int32_t *next)
{
    int32_t id = store_find(s, name);
    return id >= 0 ? id : (*next)++;
}

void store_put(store *s, const char *name, int32_t id)
{
    size_t i = place_of(s, name);
    if (i == s->body_count) {
        s->bodies = store_grow(s->pool, s->bodies, s->body_count, &s->body_room, sizeof *s->bodies);
        s->bodies[s->body_count++].name = pool_copy(s->pool, name);
    }
    s->bodies[i].id = id;
    if (id >= s->next_id) s->next_id = id + 1;
}

/* ---- robots ---- */

store_robot *store_find_robot(const store *s, const char *name)
{
    for (size_t i = 0; i < s->robot_count; i++)
        if (strcmp(s->robots[i].name, name) == 0) return &s->robots[i];
    return NULL;
}

/* A later run may start in another folder. */
static const char *whole(pool *p, const char *path)
{
    char *real = path ? realpath(path, NULL) : NULL;
    const char *copy = pool_copy(p, real ? real : path ? path : "");
    free(real);
    return copy;
}

void store_put_robot(store *s, const robot *r, collided_pose base, const double *values)
{
    const char *prefix = r->source.prefix ? r->source.prefix : "";
    const char *name = pool_format(s->pool, "%s%s", prefix, r->model.name);
    store_robot *to = store_find_robot(s, name);
    if (!to) {
        s->robots = store_grow(s->pool, s->robots, s->robot_count, &s->robot_room, sizeof *s->robots);
        to = &s->robots[s->robot_count++];
    }
    *to = (store_robot){.name = name,
        .urdf = whole(s->pool, r->source.urdf),
        .srdf = whole(s->pool, r->source.srdf),
        .prefix = pool_copy(s->pool, prefix),
        .base = base};
    for (; to->package_count < r->source.package_count && to->package_count < PACKAGES_MAX; to->package_count++)
        to->packages[to->package_count] = (load_package){pool_copy(s->pool, r->source.packages[to->package_count].name),
            whole(s->pool, r->source.packages[to->package_count].path)};
    store_set_values(s, to, r, values);
}

void store_set_values(store *s, store_robot *to, const robot *r, const double *values)
{
    to->joint_count = (size_t)r->model.joint_count;
    to->joints = pool_alloc(s->pool, to->joint_count, sizeof *to->joints);
    to->values = pool_alloc(s->pool, to->joint_count, sizeof *to->values);
    for (size_t i = 0; i < to->joint_count; i++) {
        to->joints[i] = r->model.joints[i].name;
        to->values[i] = values[i];
    }
}
