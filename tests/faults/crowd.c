#include "crowd.h"

#include <stdio.h>
#include <string.h>

static void on_batch(void *context, const collided_batch *b)
{
    int *begun = context;
    for (size_t i = 0; i < b->event_count; i++) *begun += b->events[i].kind == COLLIDED_BEGIN;
}

static bool create_cube(collided *c, const char *name)
{
    collided_shape cube = collided_box(1, 1, 1);
    collided_body_def def = collided_body_def_default();
    def.name = name;
    def.shapes = &cube;
    def.shape_count = 1;
    return collided_create_body(c, &def).id != COLLIDED_NONE;
}

int crowd_be_one(const char *uri, const char *number, const char *interface)
{
    char name[64];
    int begun = 0;
    collided_def def = collided_def_default();
    collided_subscription_def watch = collided_subscription_def_default();
    def.connect_timeout_s = 1000;
    def.interface = interface;
    collided *c = collided_connect(uri, &def);
    if (!c) return fprintf(stderr, "%s: %s\n", number, collided_connect_error()), 1;
    snprintf(name, sizeof name, "first of %s", number);
    watch.select_a = name;
    watch.callback = on_batch;
    watch.context = &begun;
    if (!create_cube(c, name) || collided_subscribe(c, &watch).id == COLLIDED_NONE) return 1;
    while (collided_sync(c, 1) != COLLIDED_OK) continue;
    snprintf(name, sizeof name, "second of %s", number);
    if (!create_cube(c, name)) return 1;
    while (!begun) collided_poll(c, 1);
    snprintf(name, sizeof name, "third of %s", number);
    if (!create_cube(c, name)) return 1;
    for (;;) collided_poll(c, 1);
}

int64_t crowd_counter(collided *watcher, const char *name)
{
    collided_daemon_status s;
    if (collided_get_status(watcher, 0.1, &s) != COLLIDED_OK) return -1;
    for (size_t i = 0; i < s.counter_count; i++)
        if (strcmp(s.counters[i].name, name) == 0) return s.counters[i].value;
    return -1;
}
