/* impact_scene: the moving pairs of the race of continuous collision, with the truth of each. Bodies are those of the
 * race of narrow phases (narrow_scene.h), and rods. Pairs that begin in contact, or of which nobody can say whether
 * they touch, are left out. */
#ifndef COLLIDED_TESTS_BENCH_IMPACT_SCENE_H
#define COLLIDED_TESTS_BENCH_IMPACT_SCENE_H

#include "geom/motion.h"
#include "impact_peer.h"
#include "narrow_scene.h"
#include "toi_truth.h"

/* Of the pair's size: nearer than this is a contact to whoever says so. */
#define IMPACT_TOLERANCE 1e-6

typedef struct impact_kind {
    const char *name;
    const char *pair; /* of narrow_pairs; NULL = rods */
    double turn[2];   /* rad over the span: the least and the most */
    bool grazing;     /* passes by within 1 % of touching, on either side */
    double goal_us;   /* 0 = none */
} impact_kind;
extern const impact_kind impact_kinds[];
extern const size_t impact_kind_count;

typedef struct impact_scene {
    narrow_kind a, b;
    impact_item *items;
    toi_truth *truths;
    size_t count, hits;
    narrow_scene bodies; /* owned */
    narrow_body *rods;   /* owned */
} impact_scene;

impact_scene impact_scene_create(const impact_kind *kind, size_t count);
void impact_scene_destroy(impact_scene *s);

/* As toi_find takes them: in canonical order. `shapes` must outlive them. */
void impact_scene_movers(const impact_item *item, shape shapes[2], toi_mover movers[2]);

#endif
