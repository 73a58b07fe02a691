/* check_exact: questions to the narrow phase, in its canonical order, with what pairs remember. A slot of the table of
 * caches belongs to whichever pair came last: a cache changes how long an answer takes, and never the answer. */
#include "check_robot.h"

#include <stdlib.h>
#include <string.h>

check_scratch *check_scratch_create(const check_robot *r)
{
    (void)r;
    check_scratch *s = base_zalloc(1, sizeof *s);
    s->narrow = base_alloc_aligned(64, 1, narrow_scratch_size());
    s->caches = base_zalloc(CHECK_CACHES, sizeof *s->caches);
    return s;
}

void check_scratch_destroy(check_scratch *s)
{
    if (!s) return;
    check_edge_free(s->edge);
    free(s->narrow);
    free(s->caches);
    array_free(&s->marked);
    array_free(&s->sources);
    array_free(&s->found);
    free(s);
}

check_near check_near_begin(check_scratch *scratch, const scene *s)
{
    size_t before = scratch->marked.capacity;
    array_reserve(&scratch->marked, s->def_count + 1);
    if (scratch->marked.capacity > before) memset(scratch->marked.at, 0, scratch->marked.capacity);
    array_reserve(&scratch->sources, s->def_count + 1);
    array_reserve(&scratch->found, s->obstacle_count + 1);
    return (check_near){scratch, s, scratch->sources.at, 0};
}

void check_near_add(check_near *near, unsigned link, vec3 centre, double radius, double within)
{
    check_scratch *w = near->scratch;
    size_t found = scene_near(near->scene, link, centre, radius, within, w->found.at, near->scene->obstacle_count);
    for (size_t i = 0; i < found; i++) {
        uint32_t source = near->scene->obstacles[w->found.at[i]].source;
        if (w->marked.at[source]) continue;
        w->marked.at[source] = 1;
        w->sources.at[near->count++] = source;
    }
}

void check_near_end(check_near *near)
{
    for (size_t i = 0; i < near->count; i++) near->scratch->marked.at[near->sources[i]] = 0;
}

static narrow_cache *cache_of(check_scratch *s, uint64_t key)
{
    check_cache *c = &s->caches[(key * 0x9E3779B97F4A7C15u) >> 54];
    if (c->key != key) {
        memset(c, 0, sizeof *c);
        c->key = key;
    }
    return &c->cache;
}

void check_exact_verdict(const shape *a, pose at_a, const shape *b, pose at_b, double limit, uint64_t key,
    check_scratch *scratch, narrow_result *out)
{
    bool ordered = narrow_ordered(a, 0, b, 1);
    const shape *first = ordered ? a : b, *second = ordered ? b : a;
    pose relative = ordered ? pose_relative(at_a, at_b) : pose_relative(at_b, at_a);
    narrow_cache *cache = cache_of(scratch, key);
    if (narrow_apart(first, second, &relative, limit, cache)) {
        out->lo = cache->lower;
        out->hi = INFINITY;
        return;
    }
    narrow_request request = {.facts = NARROW_VERDICT, .range = INFINITY, .threshold = limit, .brief = true};
    narrow_query(first, second, &relative, &request, cache, scratch->narrow, out);
}

void check_exact_distance(const shape *a, pose at_a, const shape *b, pose at_b, double tolerance, double range,
    uint64_t key, check_scratch *scratch, narrow_result *out)
{
    bool ordered = narrow_ordered(a, 0, b, 1);
    const shape *first = ordered ? a : b, *second = ordered ? b : a;
    pose relative = ordered ? pose_relative(at_a, at_b) : pose_relative(at_b, at_a);
    narrow_request request = {.facts = NARROW_DISTANCE, .tolerance = tolerance, .range = range, .brief = true};
    narrow_query(first, second, &relative, &request, cache_of(scratch, key), scratch->narrow, out);
}
