/* stream_names: streams by their names: those that are open, and those that end with this tick. Tick thread. */
#include "service.h"
#include "streams.h"

#include "base/hash.h"
#include "base/secret.h"

#include <string.h>

static uint64_t next_key(uint64_t key)
{
    return key + 1 ? key + 1 : 1;
}

/* Where the stream of that name is, or would be: keys that clash are probed on. */
static uint64_t key_of_name(const service *s, const pair_map *names, const char *name, uint32_t *id)
{
    uint64_t key = hash_words(secret(), name, strlen(name));
    for (key = key ? key : 1;; key = next_key(key)) {
        *id = pair_map_get(names, key);
        if (*id == PAIR_MAP_NONE || strcmp(s->streams.at[*id].name, name) == 0) return key;
    }
}

/* Those that were probed on behind it move up. */
static void drop_name(service *s, pair_map *names, uint32_t id)
{
    uint32_t at, moved;
    uint64_t key = key_of_name(s, names, s->streams.at[id].name, &at);
    if (at != id) return;
    pair_map_remove(names, key);
    for (key = next_key(key); (moved = pair_map_remove(names, key)) != PAIR_MAP_NONE; key = next_key(key)) {
        uint64_t home = key_of_name(s, names, s->streams.at[moved].name, &at);
        pair_map_put(names, home, moved);
    }
}

static void add_name(service *s, pair_map *names, uint32_t id)
{
    uint32_t at;
    uint64_t key = key_of_name(s, names, s->streams.at[id].name, &at);
    pair_map_put(names, key, id);
}

void stream_names_add(service *s, uint32_t id)
{
    add_name(s, s->streams.at[id].ending ? &s->ending_streams : &s->open_streams, id);
}

void stream_names_drop(service *s, uint32_t id)
{
    drop_name(s, s->streams.at[id].ending ? &s->ending_streams : &s->open_streams, id);
}

stream *stream_named(service *s, const char *name)
{
    uint32_t id;
    key_of_name(s, &s->open_streams, name, &id);
    return id == PAIR_MAP_NONE ? NULL : &s->streams.at[id];
}

const stream *stream_ending(service *s, const char *name)
{
    uint32_t id;
    key_of_name(s, &s->ending_streams, name, &id);
    return id == PAIR_MAP_NONE ? NULL : &s->streams.at[id];
}
