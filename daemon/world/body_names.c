/* body_names: bodies by their names. Tick thread. */
#include "state.h"

#include "base/hash.h"
#include "base/secret.h"

uint64_t body_name_hash(const char *name)
{
    uint64_t h = hash_bytes(secret(), name, strlen(name));
    return h ? h : 1;
}

/* The key under which a name is stored, or the first free one after it. */
static uint64_t name_key(const world *w, const char *name, uint32_t *id)
{
    uint64_t key = body_name_hash(name);
    for (;; key = key + 1 ? key + 1 : 1) {
        *id = pair_map_get(&w->names, key);
        if (*id == PAIR_MAP_NONE || strcmp(w->bodies.at[*id].name, name) == 0) return key;
    }
}

uint32_t world_find_body(const world *w, const char *name)
{
    uint32_t id;
    name_key(w, name, &id);
    return id == PAIR_MAP_NONE ? WORLD_NONE : id;
}

void body_add_name(world *w, uint32_t body)
{
    uint32_t taken;
    uint64_t key = name_key(w, w->bodies.at[body].name, &taken);
    pair_map_put(&w->names, key, body);
}

/* Names that were probed on behind this one move up, so that no probe meets a hole. */
void body_drop_name(world *w, const char *name)
{
    uint32_t id;
    uint64_t key = name_key(w, name, &id);
    pair_map_remove(&w->names, key);
    for (key = key + 1 ? key + 1 : 1;; key = key + 1 ? key + 1 : 1) {
        id = pair_map_remove(&w->names, key);
        if (id == PAIR_MAP_NONE) return;
        body_add_name(w, id);
    }
}
