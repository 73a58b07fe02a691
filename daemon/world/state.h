/* state: the world's own structures, shared by the files of this folder only.
 *
 * Bodies, shapes, subscriptions, pairs and watches lie in arrays under dense ids. A pair exists while the fat boxes of
 * two shapes meet and somebody is interested; a watch exists while a subscription has been told something of a pair
 * that is not over. A removed body stays as a ghost until the next tick has reported its ends and the one after has
 * begun.
 */
#ifndef COLLIDED_WORLD_STATE_H
#define COLLIDED_WORLD_STATE_H

#include "base/array.h"
#include "base/bytes.h"
#include "base/id_pool.h"
#include "base/pair_map.h"
#include "base/workers.h"
#include "broad/broad.h"
#include "match_table.h"
#include "rules.h"
#include "world.h"

#include <stddef.h>
#include <string.h>

typedef struct waypoint { /* where a body was between two ticks */
    pose pose;
    int64_t stamp_ns;
} waypoint;

typedef struct past_motion { /* of a body in a tick that is over; see past.c */
    uint64_t tick;
    pose from, to;
    int64_t from_ns, to_ns;  /* stamps */
    int64_t span_ns, now_ns; /* as body_span_ns; of the tick */
    vec3 angular;            /* as the body's, as is `speed` */
    aabb box;                /* of all shapes on it */
    waypoint *passed;
    size_t passed_count;
    bool moved; /* otherwise it stood there, put or teleported */
    uint8_t speed;
} past_motion;

/* Poses come by the million. What they touch in a world where they change nothing stands in the first three cache
 * lines: where it is, what it may do there, and where it was. */
enum { SPEED_NONE, SPEED_ESTIMATED, SPEED_GIVEN };

/* Four numbers at once. */
typedef float calm_four __attribute__((vector_size(16)));
typedef double calm_wide __attribute__((vector_size(32)));
typedef int32_t calm_bits __attribute__((vector_size(16)));
typedef int64_t calm_masks __attribute__((vector_size(16)));

typedef struct calm_region { /* for a body's position; see calm.c */
    calm_four q;             /* found where it stood so */
    calm_four middle;        /* m, and 0 */
    calm_four half; /* m, rounded inward; and the reach, m: turned from q by a difference of quaternions d, a body
                       has a smaller region, by d times this */
} calm_region;

typedef struct body {
    _Alignas(64) pose pose;
    int64_t stamp_ns;

    _Alignas(64) calm_region region; /* the body is calm as long as it is in there */
    uint64_t glided; /* world.round of the last pose that was not a tick's business; `before` is of the tick before */
    bool used : 1, ghost : 1;
    bool dirty : 1;   /* in world.dirty: its boxes are put again in the next tick */
    bool posed : 1;   /* a pose has come since the last tick: its deadline counts from it */
    bool moved : 1;   /* between `before` and `pose`, by a motion that may be swept */
    bool detours : 1; /* it has teleported or passed something since the last tick */
    bool is_calm : 1; /* as long as it stays in that region, nothing depends on its poses: see calm.c */
    bool behind : 1;  /* it was calm when it moved: its shapes stand where they were, see collider_pose */
    uint8_t speed;    /* SPEED_...; follows these bits: see move.c */
    uint32_t effort;  /* units that it takes to put its boxes anew: see effort.c */

    _Alignas(64) pose before; /* at the tick before its last move, so if it has `moved`: at the last tick; ... */
    int64_t before_ns;        /* ... its stamp */

    _Alignas(64) float fit_lo[3];     /* m: of a calm body of one shape, the fat box, from here ... */
    float fit_hi[3];                  /* ... to here. The shape lies within ... */
    float fit_centre[3], fit_half[3]; /* ... a box in the body's frame, m; ... */
    float fit_least[3]; /* ... turned, this is half as wide, at least, while the fat box is not too fat for it */
    float fit_slack;    /* m: what rounding may do, and by how much the box is widened. INFINITY: it has no such box */

    /* What a tick looks at of each body that it takes, and of each beside it: one cache line. */
    _Alignas(64) uint32_t *shapes;
    uint32_t shape_count;
    uint32_t only_shape; /* where it has one, `shapes` is that: body_make_shapes */
    double widen;   /* m, half of the farthest range that a subscription wants of it, and all of its rules' reach */
    double horizon; /* s: the farthest that a subscription wants predicted of it: its box holds all that it may do */
    uint64_t gathered_tick; /* the tick whose active list its pairs were last put on, all of them */
    uint64_t changed_tick;  /* the tick that it was last put again for: what is decided before it is out of
                               date; see slices.c */
    uint32_t match;         /* its class: see match.h */
    uint32_t pair_count;
    bool fixed;
    bool refilter; /* its filters are put again, too */
    bool held, stale;
    bool impacts; /* a subscription wants its impacts: its box holds its swept motion */
    bool is_due, is_parked;
    bool teleported; /* since the last tick */

    /* And of each that has moved, or whose filter is asked: another. */
    _Alignas(64) int64_t deadline_ns;
    int64_t expiry_ns; /* INT64_MAX: never stale */
    int64_t queued_ns; /* of its entry among the expiries, if it has one; ... */
    uint32_t serial;   /* ... an older one is void */
    bool expiry_queued;
    uint64_t ruled_tick;    /* the tick that its filter last changed for */
    uint64_t teleport_tick; /* likewise, that it teleported for */
    uint64_t label;         /* of world.ruling, of its name and group: what rules say of another is void */
    uint64_t ruling;        /* of world.ruling, of the filter that it has: decisions of another are void */

    char *name, *group;
    uint64_t category, mask;
    filter_rule *rules;
    size_t rule_count;
    double rule_reach; /* m: its rules add at most so much to the thresholds or ranges of its pairs */
    uint32_t rule_set; /* of world.rules: the patterns of these */
    bool one_way, in_step;
    uint8_t ghost_cause;
    bool matched; /* `match` is that of its name and group; ... */
    bool queued;  /* ... or it waits among match.unmatched */

    uint64_t owner;                       /* as it was put */
    uint32_t leaving;                     /* colliders that were its, and leave */
    bool past_listed;                     /* among world.past_bodies */
    bool left_new;                        /* in left_tick: by a search */
    bool past_lost;                       /* its shapes have changed, or it is gone, before all was decided */
    bool kept;                            /* a ghost that may not be reaped yet: it leaves; see leaving.c */
    uint64_t left_since;                  /* the tick that left it first, since it was settled; 0: none */
    bool goes;                            /* it is to be removed, for `ghost_cause`, when its turn comes: removal.c */
    uint32_t weight;                      /* in world.pending */
    uint32_t purse, due_next, due_before; /* while it is due: whose turn it waits for, and behind and before whom */
    ARRAY(waypoint) passed;               /* between `before` and `pose`, while a subscription in impacts is there */
    world_ccd ccd;
    ARRAY(past_motion) past;        /* of ticks that are over, while pairs wait for it: see past.c */
    const past_motion *as_of;       /* of a copy that past_body made; NULL: as it is now */
    uint32_t searches_left;         /* pairs of it whose searches wait; ... */
    uint32_t swept_left;            /* ... that have swept motions among them */
    uint32_t asked_left;            /* pairs of it whose searches wait that its own owner asks for */
    uint64_t searcher;              /* its owner, when the first of those began to */
    uint64_t past_reported;         /* the tick up to which it was reported that some may have been dropped */
    uint64_t pass_tick;             /* a pass over its pairs began in it and is not over; 0: none; see slices.c */
    uint32_t pass_shape, pass_next; /* it goes on with the pair of this shape and that collider */
    bool pass_left;                 /* it has left a pair to another body */
    uint64_t past_since, left_tick; /* the tick up to which nothing is kept any more; in which a pair was left, or 0 */
    vec3 linear, angular;           /* m/s, rad/s: with SPEED_GIVEN; otherwise see body_velocity */
    double acceleration, angular_acceleration;
    double reach, travelled; /* m, of its shapes about its origin; by how much its points have moved, at most, added up
                                over all ticks: kept while somebody asks for bounds, or there is a budget; ... */
    uint32_t soft;           /* its place among soft bodies + 1; 0: it is rigid */
    uint64_t changed_before; /* the tick before changed_tick that it was put again for */
    int64_t announced_ns;    /* stamp of the announcement, where that is not the pose's; 0: it is */
    pose travelled_to;       /* ... up to here; set anew when a budget is */
} body;
_Static_assert(offsetof(body, shapes) % 64 == 0 && offsetof(body, deadline_ns) == offsetof(body, shapes) + 64 &&
                   offsetof(body, name) == offsetof(body, deadline_ns) + 64,
    "a line each");

typedef struct collider { /* a shape of a body: the broad phase's proxy under the same id */
    /* In the world, where it was settled last: collider_pose, unless it is in a pair. A line of this and its reach
     * about its own origin: all that most pairs are looked at for; ... */
    _Alignas(64) pose world;
    double reach;
    shape shape; /* ... one for this; ... */
    uint32_t body;
    float apart, overlapping; /* units that it adds to a refinement (work.c) */
    int32_t index : 24;       /* in the body */
    bool at_origin : 1;       /* of the body, and not turned: `local` is the identity */
    bool used : 1, ghost : 1;
    bool kept : 1;   /* as a body's */
    bool shadow : 1; /* of a soft surface: see soft_state.h */
    aabb box;        /* of the shape at `world`, not fat */
    pose local;      /* in the body */
} collider;
_Static_assert(offsetof(collider, shape) == 64 && sizeof(collider) == 320, "five lines");
enum { SHAPES_OF_A_BODY_MOST = (1 << 23) - 1 };

typedef struct ruling {          /* what the filters of two bodies say, as long as both have these */
    uint64_t filter_a, filter_b; /* body.ruling; 0: none is kept */
    double padding, margin;
    bool checked;
    int8_t looks;
} ruling;

typedef struct stamp_search { /* for the oldest stamp of one subscription, in parts: see news.c */
    bool on;
    uint32_t subscription, waits; /* waits: another one that has asked since, + 1; 0: there is none */
    size_t next;                  /* watch */
    int64_t oldest_ns;            /* so far */
} stamp_search;

typedef struct watch { /* one line; what was reported last is beside it, under the same id: see watch.c */
    _Alignas(64) uint32_t pair;
    uint32_t subscription;
    uint32_t pair_next; /* of the same pair, by rising subscription */
    uint32_t subscription_next, subscription_prev;
    uint32_t snap; /* the subscription's snapshot that it is in, or of which it is too late to be one */
    int64_t touch_id, near_id, predicted_id;    /* 0 = not */
    bool used, unknown, dirty, predicted_dirty; /* dirty: an update that the rate held back */
    bool listed;                                /* for drop_void_held */
    bool recovered;                             /* known again in this tick: its state follows, be it new or not */
    bool has_contact, has_predicted;            /* are there a last_contact and a last_predicted? */
} watch;
_Static_assert(sizeof(watch) == 64, "a line");

typedef struct last_contact { /* what the last event of contact or nearness said, beyond what its pair says */
    double lo, hi;
    vec3 axis, point_a, point_b;
    double closing;
    int64_t age_a_ns, age_b_ns;
    int32_t shape_a, shape_b;
    uint8_t achieved;
    uint8_t points; /* of last_points */
    bool turned;    /* the pair's B is its A */
} last_contact;
_Static_assert(sizeof(last_contact) <= 128, "with its watch three lines");

typedef struct last_points { /* of the manifold of a last_contact */
    manifold_point at[MANIFOLD_POINTS_MAX];
} last_points;

typedef struct standing { /* reported bounds, widened by a slack: they hold while B moves by at most that */
    pose b_in_a;          /* relative to A, since here */
    double slack, lo;     /* m; lo: as reported */
    double travelled;     /* m, of both bodies then */
    uint32_t epoch;       /* of world.epoch: others may want to be told since. 0: none */
    bool floor;           /* by balls about them: bounds are still to be found */
    bool enough;          /* for what was asked: they are bounds alone, or beyond what anybody asks for */
} standing;

/* What is kept of pairs that are bounded or searched: beside them, under the same id, and memory only where there are
 * any. Read by pair_more_of, written by pair_more_make. */
typedef struct pair_more {
    vec3 free_axis; /* a world direction that kept it free along its predicted motion; zero: none is known */
    standing standing;
    vec3 near_a, near_b; /* points of the surfaces, each in its own shape's frame, of the last refinement; ... */
    bool refined;        /* ... if there was one */
    uint8_t barren;      /* searches for one in a row that were in vain: the next one comes so much later */
    uint8_t wait_list;   /* while its search waits, it is in this one of world.waiting, ... */
    uint32_t wait_next, wait_before; /* ... behind and before whom */
    uint32_t search_units;           /* that the dearest of its last searches took; 0: there was none */
    uint32_t swept_from;      /* the subscription with which the searches of the tick behind this one go on: ... */
    uint64_t swept_tick;      /* ... in which its motions were searched last, while some are kept */
    uint64_t predicted_round; /* the tick in which a round of what is predicted began that ... */
    uint32_t predicted_from;  /* ... goes on with this subscription; 0: none is under way */
} pair_more;

typedef struct pair {
    _Alignas(64) uint32_t a; /* colliders, in canonical order: this, ... */
    uint32_t b;              /* ... and this */
    uint32_t first_watch;
    uint32_t asked_epoch;      /* of world.epoch, for which ... */
    double beyond;             /* ... m: proven to be farther apart than this, nobody is told of it; see cascade.c */
    uint64_t active_tick : 56; /* in which it was last put on the active list; of one that has just begun, the one
                                  before: pair_set_active_tick */
    bool used : 1;
    bool ruled : 1, jumped : 1; /* active: since it was so last, a filter of the two has changed; one has teleported */
    bool lingers : 1;           /* its boxes have parted, but somebody was told of it: no event follows from boxes */
    bool is_reported : 1;   /* somebody has been told how it stands: it is decided in full; see pair_note_reported */
    bool at_origins : 1;    /* both colliders are */
    bool has_more : 1;      /* its pair_more is its own */
    uint32_t wanted;        /* index of match.lists, as of ... */
    uint32_t edition;       /* ... match.edition; 0: of none */
    narrow_cache cache;     /* what most pairs are looked at for ends within it, with the second line */
    double padding, margin; /* m: of its pair_terms, as is ... */
    int8_t looks;           /* ... this */
    uint8_t waited;         /* ticks in a row in which the budget left it */
    bool search_waits : 1;  /* some of its searches were put off, ... */
    bool swept_wait : 1;    /* ... of swept motions, too */
    bool asked_by_a : 1, asked_by_b : 1; /* who owns that body, or steps with him, asks for some of these */
    uint32_t payer;                      /* of world.payers: whom it is charged to, unless it lingers */
} pair;
_Static_assert(offsetof(pair, cache) + offsetof(narrow_cache, hint_a) == 128 && sizeof(pair) == 192,
    "two lines for what each tick looks at, and one more");

static inline void pair_set_active_tick(pair *p, uint64_t tick)
{
    p->active_tick = tick & ((UINT64_C(1) << 56) - 1);
}

enum { SETTLED, SETTLES_NEXT, SETTLES_NOW };

typedef struct subscription {
    char *select_a, *select_b;
    unsigned facts;
    double threshold, range, hysteresis, tolerance, relative_tolerance, horizon;
    world_accuracy accuracy;
    uint32_t soft_most;      /* features of a pair; 0: all */
    bool soft_each;          /* features are reported to it one by one */
    uint64_t work;           /* units of the cascade, since it was put */
    size_t undone, reported; /* pairs that the budget left in this tick, and in the last one that was reported */
    int64_t period_ns, next_update_ns;
    uint64_t owner;
    bool in_step;
    uint32_t selection;    /* of match.selections; WORLD_NONE: none */
    uint64_t changed_tick; /* the tick that its terms last changed for */
    uint8_t settling;      /* the pass that looks at all bodies for it is the next one, or under way */
    bool lively, listed;   /* among world.lively, among world.unsettled */
    bool used, closing, snapshot, changed;
    bool all; /* in this tick, updates without news are reported, too */
    uint8_t closing_cause;
    bool images_begin, images_reported; /* in this tick: a snapshot begins; a portion of one, or all of it, is told */
    bool snapping;                      /* one is under way: see snapshot.c; ... */
    uint32_t snap, snap_next;           /* ... the number of it, or of the last one; and the watch that is next */
    uint32_t first_watch, last_watch;   /* of what it was told under its terms as they are; newest first */
    uint32_t first_old, last_old;       /* of what it was told before they changed, or it closed: see closing.c; ... */
    size_t watches, olds;               /* ... so many are, among all */
    int64_t old_serial;                 /* w->serial then */
    ARRAY(uint32_t) held; /* watches with an update held back by the rate, and some that have ended since */
    ARRAY(world_event) events;
    ARRAY(world_event) images; /* of this tick's portion of a snapshot */
} subscription;

typedef struct subscription_counts { /* that ask how pairs stand now, of these for bounds, and for swept motions */
    size_t now, bounds, sweeps;
} subscription_counts;

typedef struct expiry { /* when a body may become stale, unless a pose comes */
    int64_t time_ns;
    uint32_t body, serial;
} expiry;

typedef struct outcome { /* of one active pair in one tick */
    uint8_t stage;
    uint8_t asked;    /* narrow queries */
    bool settled;     /* no result: proven to be beyond everything that anybody asked, or unknown, or as told */
    bool coarse;      /* only bounds are asked for */
    bool stands;      /* standing bounds hold ... */
    bool floor;       /* ... but are none of their own */
    bool left;        /* by the budget */
    bool search_left; /* to a later tick */
    bool wants_shell; /* the pair: see lend_shells in cascade.c */
    uint32_t work;    /* units that its refinement is expected to take, with a budget */
    uint32_t cost;    /* units: of its refinement while it is open, of what was done then */
    uint32_t result;  /* index into world.results otherwise */
} outcome;

typedef struct sweep { /* a search for a time of impact: one pair, one subscription */
    uint32_t active;   /* index into active_pairs */
    uint32_t subscription;
    uint64_t tick;             /* whose swept motions are searched */
    uint32_t spent;            /* of TOI_WORK_MAX, before it begins: the rest is what it is allowed */
    uint64_t most;             /* units that it may take */
    uint32_t queries, steps;   /* that it took, with caches or without */
    bool tried, done, put_off; /* in this tick; to a later one */
    bool predicts;
    bool again; /* asks what the one before it asks */
    bool estimated;
    bool began;  /* in contact: that has been reported */
    bool sought; /* free_axis was, anew */
    vec3 free_axis;
    int64_t start_ns;
    toi_result result;
} sweep;

typedef struct purse { /* of one owner: his bodies that are due, in the order in which they go on */
    uint64_t owner;
    uint32_t first, last;
    uint32_t count; /* 0: it may become another's */
    int64_t credit; /* units that he may still take in this turn; negative: took too much */
} purse;

typedef struct payer { /* an owner, and how many pairs are charged to him; 0: the place is free */
    uint64_t owner;
    uint32_t pairs;
} payer;

/* Of pairs, whose owners may share one. */
enum { SEARCH_LISTS = 64 };
typedef struct search_list {
    uint32_t first, last;
} search_list;

typedef struct leaver { /* so many colliders of this owner leave */
    uint64_t owner;
    size_t count;
} leaver;

typedef struct goer { /* a body that is to be removed, unless its id has become another's: then its label is another */
    uint64_t label;
    uint32_t body;
} goer;

typedef struct goers { /* of one owner, from `first` on; none: it may become another's */
    uint64_t owner;
    size_t first;
    ARRAY(goer) list;
} goers;

typedef struct mover { /* an owner of bodies that have moved, in a tick that does not settle all; see settling.c */
    uint64_t owner, units;
    int64_t credit;
    size_t left; /* of his, to the next tick */
} mover;

typedef ARRAY(uint64_t) concerned_bits; /* by selectors */

typedef struct waiting_pair {
    uint64_t since, key; /* the tick in which it was decided last */
    uint32_t pair;
} waiting_pair;

struct world {
    world_options options;
    workers *workers;
    void *scratch[WORKERS_MAX];
    size_t pairs_most; /* of options.max_pairs, so many may be now; 0: all */
    broad *broad;

    ARRAY(body) bodies; /* each begins a cache line: body_reserve */
    ARRAY(collider) colliders;
    ARRAY(subscription) subscriptions;
    ARRAY(pair) pairs;
    ARRAY(pair_more) pairs_more; /* under the ids of pairs; its count is not kept */
    ARRAY(watch) watches;
    ARRAY(last_contact) last_contacts; /* these three under the ids of watches */
    ARRAY(last_points) last_points;
    ARRAY(world_event) last_predicted;
    id_pool body_ids, collider_ids, subscription_ids, pair_ids, watch_ids;
    pair_map pair_of;            /* key of two colliders -> pair */
    pair_map names;              /* hash of a name -> body; colliding hashes are probed on with the next key */
    match match;                 /* which subscriptions want which bodies */
    rule_sets rules;             /* what the patterns of rules say of names */
    ruling *rulings;             /* by a hash of two bodies, see pair.c; NULL: no body has had rules */
    uint64_t ruling;             /* counts filters, from 1 */
    uint64_t shapes_edition;     /* counts changes of bodies' shapes */
    struct world_checks *checks; /* see checks.c; NULL: nobody has asked */

    ARRAY(uint64_t) dirty; /* ids of bodies to be put into the broad phase; u64 because sort_keys sorts these */
    uint64_t effort;       /* of these, units: see effort.c */
    ARRAY(uint64_t) left;  /* of dirty, those that this tick has left to the next one; ... */
    bool reaps_late;       /* some that are to be reaped wait for the next tick */
    bool in_parts;         /* some may be left: a step has moved them */
    uint64_t left_effort;  /* ... units */
    ARRAY(mover) movers;
    ARRAY(uint32_t) mover_at;   /* of each that was dirty */
    uint64_t moves_before;      /* figures.moves, at the last tick */
    size_t wide;                /* bodies that take much more of it than most, see effort.c */
    ARRAY(uint32_t) awake;      /* of these, those that were not calm, in their order: made by body_settle_dirty */
    ARRAY(uint64_t) awake_bits; /* of their colliders: see slices.c */
    ARRAY(uint32_t) glided;     /* those that were, until they came into a pair in this tick */
    ARRAY(uint64_t) sort_scratch;
    ARRAY(waiting_pair) queue;             /* of the body that has its turn: see slices.c */
    ARRAY(uint32_t) changed_subscriptions; /* since the last tick, or closed by it */
    ARRAY(uint32_t) unsettled;             /* subscriptions for which not all bodies have been looked at */
    ARRAY(uint64_t) lively;                /* subscriptions that may have something to report; sort_keys sorts them */
    size_t reported_in_common;             /* what all subscriptions were last told to be undone; see events_collect */
    ARRAY(uint32_t) ghosts;                /* removed since the last tick */
    ARRAY(uint32_t) reap;                  /* removed before it: ids free at the next */
    ARRAY(uint32_t) ghost_colliders, reap_colliders;
    ARRAY(expiry) expiries;             /* a heap, see expiry.c */
    uint64_t ruled_tick, teleport_tick; /* the greatest of the bodies' */
    ARRAY(uint32_t) held_now;           /* bodies held since the last tick */
    ARRAY(uint32_t) stale_now;          /* bodies that became stale in this tick */
    uint64_t stale_units;               /* that it takes to tell so */
    ARRAY(uint64_t) unknown_due;        /* keys of the pairs of which that is still to be reported */
    ARRAY(uint32_t) fresh_now;          /* and those that are known again */
    ARRAY(uint64_t) active;             /* keys of the pairs to be decided, sorted ... */
    ARRAY(uint32_t) active_pairs;       /* ... and their pairs, in that order */
    ARRAY(outcome) outcomes;
    ARRAY(uint32_t) told;       /* of them, those that have a result: for events.c, which reports them */
    ARRAY(uint32_t) open;       /* active pairs that have a result, in its place */
    size_t bounds, bounded;     /* of open: the first ones get bounds; of them those that the budget allows */
    ARRAY(uint64_t) needs;      /* active pairs to be refined, the neediest first: see work.c */
    ARRAY(uint32_t) unfinished; /* pairs that the last tick left */
    bool lets_in;               /* pairs that were left out, ... */
    uint32_t lets_in_next;      /* ... on from this collider's */
    ARRAY(uint32_t) lingering;  /* pairs that linger, and some that do no more */
    size_t lingers;             /* so many do */
    size_t olds;                /* of all subscriptions */
    size_t snapping;            /* subscriptions, after the last tick */
    uint64_t slice;             /* units that finding and deciding pairs may take in a tick; UINT64_MAX: all of them */
    ARRAY(purse) purses;
    uint32_t turn;       /* the purse that goes first */
    ARRAY(payer) payers; /* see payers.c */
    id_pool payer_ids;
    pair_map payer_of;       /* owner -> place */
    uint32_t last_payer;     /* place of the last that was charged */
    size_t due, parked;      /* bodies; those that wait for max_pairs */
    ARRAY(uint32_t) leaving; /* colliders that are gone but for their pairs, in the order in which they go on */
    pair_map leaving_names;  /* hash of a name -> ghosts that leave, and had a name of that hash */
    ARRAY(leaver) leavers;   /* whose they are */
    ARRAY(goers) goers;      /* bodies that are to be removed; ... */
    size_t going;            /* ... so many, ... */
    size_t goer_turn, goer;  /* ... those of this place go first; the place of the last one that was told */
    size_t dear;             /* colliders of which a few pairs may be more than a slice: see slices_is_dear */
    uint64_t pending;        /* pairs, at least, that wait */
    bool sliced;             /* in this tick something was put off, or had been */
    concerned_bits concerned, concerned_found; /* selectors that have a body which is due or parked: see slices.c */
    size_t concern_next;                       /* the body from which on these are found in the next tick */
    world_grant *grant;                        /* NULL: no budget */
    void *grant_context;
    uint64_t capacity;          /* units: what takes more is set aside; see work.c */
    uint64_t next_bound;        /* key of the pair that is bounded first, if not all can be */
    uint32_t epoch;             /* of the subscriptions: counts their changes, from 1 */
    subscription_counts asking; /* by the commands; the tick goes by ... */
    size_t askers;              /* ... these: subscriptions in how pairs stand now; the first one */
    uint32_t first_asker;
    bool bounds_asked; /* by a subscription */
    ARRAY(narrow_result) results;
    ARRAY(sweep) sweeps;         /* in the order of active_pairs, then of subscriptions */
    ARRAY(uint32_t) sweep_order; /* sweeps, as they are made */
    ARRAY(uint64_t) sweep_keys;
    ARRAY(uint32_t) search_again;      /* sweeps that were allowed too little */
    search_list waiting[SEARCH_LISTS]; /* pairs whose searches have been put off: see impact_wait.c */
    uint32_t search_turn;              /* the list that goes first */
    size_t searching, searching_bodies;
    stamp_search stamps;
    ARRAY(leaver) searchers;     /* whose bodies these are */
    size_t ccds;                 /* bodies with a mode of their own */
    ARRAY(uint32_t) past_bodies; /* that keep motions of ticks that are over; ... */
    size_t past_motions;         /* ... so many, all of them */
    uint64_t past_clear;         /* the last tick at whose end nothing was kept */
    size_t sweepers;             /* subscriptions that want impacts, or something predicted */
    bool some_teleported;        /* since the last tick */
    int64_t last_tick_ns;
    ARRAY(world_batch) batches;

    int64_t now_ns;
    uint64_t round; /* counts ticks as they begin, from 1: what came before this one has the round before */
    int64_t serial; /* of contacts */
    uint32_t body_serial;
    bool changed, some_glided; /* see world.h */
    bool rematched;            /* since the last tick: some body is in a subscription, or out of one, that it was not */
    uint64_t hash;
    world_figures figures;
    struct soft_world *soft; /* soft_state.h */
};

_Static_assert(offsetof(body, before_ns) == 184, "what a pose touches is three cache lines");
_Static_assert(offsetof(body, fit_slack) == 252, "and one more where its region has to be found anew");

/* body.c */
/* Room for that many in b->shapes, and no more room for them. */
void body_make_shapes(body *b, size_t count);
void body_free_shapes(body *b);
/* A copy of that text, or what stands for none: most bodies have no group. */
void body_set_group(body *b, const char *group);
void body_free_group(body *b);
void body_reserve(world *w, size_t need); /* room for so many in w->bodies */
void body_arrive(world *w, uint32_t id);  /* where it is, it was at the last tick */
void body_reap(world *w);
int64_t body_age_ns(const world *w, const body *b); /* in this tick */
int64_t body_age_at(const body *b, int64_t now_ns);
void body_mark_dirty(world *w, uint32_t id, bool refilter);
/* At the last tick. */
static inline pose body_before(const body *b)
{
    return b->moved ? b->before : b->pose;
}
/* m: how far the last tick that moved it took it, and so the next one may: the fat box reaches ahead by it. */
static inline vec3 body_step(const body *b)
{
    return vec_sub(b->pose.p, b->before.p);
}
void body_velocity(const body *b, vec3 *linear, vec3 *angular); /* given, or estimated from its motion; else zeros */

/* checks.c */
typedef struct world_checks world_checks;
void checks_free(world *w);

/* body_names.c */
void body_add_name(world *w, uint32_t body); /* to be found by it */
void body_drop_name(world *w, const char *name);

uint64_t body_name_hash(const char *name);

/* leaving.c */
void leaving_begin(world *w);                      /* a tick: may all that was removed end in it? */
void leaving_go_on(world *w);                      /* ends what has been put off, as far as a slice goes */
void leaving_ghost(world *w, uint32_t body);       /* it is one now */
void leaving_restored(world *w);                   /* what follows from the list */
bool leaving_holds(const world *w, const body *b); /* it is in no subscription yet: what was called so has yet to end */
size_t leaving_of(const world *w, uint64_t owner);

/* removal.c */
void removal_go_on(world *w);                /* a tick begins: as many as a slice has room for are removed */
void removal_forget(world *w, body *b);      /* it is being removed */
bool removal_hastens(world *w, uint32_t id); /* if that one is to go, it is removed now */
size_t removal_of(const world *w, uint64_t owner);
void removal_free(world *w);
uint64_t removal_units(const body *b); /* that it takes */
void removal_save(const world *w, bytes_out *to);
bool removal_restore(world *w, bytes_in *from);

/* body_shapes.c */
static inline bool pose_same(pose a, pose b)
{
    bool there = a.p.x == b.p.x && a.p.y == b.p.y && a.p.z == b.p.z;
    return there && a.q.w == b.q.w && a.q.x == b.q.x && a.q.y == b.q.y && a.q.z == b.q.z;
}
static inline size_t body_visible_shapes(const body *b) /* without the shadow of a soft one */
{
    return b->shape_count - (b->soft != 0);
}
bool body_same_shapes(const world *w, const body *b, const world_body *def);
void body_add_shapes(world *w, uint32_t id, const world_body *def); /* to one that has none */
void body_drop_shapes(world *w, body *b);
void collider_free(collider *s); /* what it owns */

/* payers.c */
bool payers_allow(const world *w, uint32_t a, uint32_t b); /* may a pair of these colliders begin? */
size_t payers_open(size_t most);                           /* of so many pairs, those that may be anybody's */
size_t payers_kept_for(const world *w, const body *b);     /* pairs beyond the most that are looked for around it */
void payers_charge(world *w, pair *p);
void payers_release(world *w, const pair *p);
void payers_restored(world *w);
const char *payers_validate(const world *w);

/* effort.c */
void effort_measure(world *w, body *b);        /* its shapes are others */
void effort_restored(world *w, const body *b); /* it has them */

/* settling.c */
void settling_choose(world *w);   /* of dirty, sorted, as many stay as this tick has room for, the others are `left` */
void settling_end(world *w);      /* and are dirty in the next one */
void settling_restored(world *w); /* from what bodies say */
size_t settling_of(const world *w, uint64_t owner); /* how many of his this tick has left */

/* collider.c */
/* Where it is when its body is there. */
static inline pose collider_at(pose body_pose, const collider *s)
{
    if (s->shape.type == SHAPE_SOFT) return POSE_IDENTITY; /* each of its vertices is where it is */
    return s->at_origin ? body_pose : pose_mul(body_pose, s->local);
}
void body_settle_dirty(world *w); /* new boxes and filters into the broad phase */
double body_margin(const world *w, const collider *s);
void body_account(
    world *w, uint32_t id); /* it comes into a pair: its shapes are where it is, and it has a swept motion */
void body_settle_shapes(world *w, body *b);            /* those that are behind stand where their body does */
pose collider_pose(const world *w, const collider *s); /* in the world, as the last tick left it */
/* The same as where its body is, and where it is in there: collider_pose rounds by the distance from the world's
 * origin.
 */
void collider_stand(const world *w, const collider *s, pose *body_pose, pose *local);
pose collider_relative(
    const world *w, const collider *a, const collider *b); /* B's in A's frame, where the bodies are now */
pose collider_settled_relative(const world *w, const collider *a, const collider *b); /* as the last tick left them */
/* m: by how much a distance of two shapes, from their relative pose, may be off beyond what narrow.h allows for: the
 * rounding of where the shapes are on their bodies. 0 where both are at their bodies' origins. */
double collider_relative_error(const world *w, const collider *a, const collider *b);
/* Is A the first of the two in canonical order (narrow_ordered)? Where their shapes are equal, by the names of their
 * bodies, and of one body by the index: ids follow from the order of announcement, on which no answer may depend. */
bool colliders_in_order(const world *w, const collider *a, const collider *b);

/* move.c */
static inline void body_set_pose(body *b, pose to, int64_t stamp_ns)
{
    b->pose = (pose){to.p, quat_settled(to.q)};
    b->stamp_ns = stamp_ns;
    b->posed = true;
}
static inline bool body_is(const world *w, uint32_t id)
{
    return id < w->bodies.count && w->bodies.at[id].used && !w->bodies.at[id].ghost;
}
/* Where swept motions count, or how far each goes, calm bodies take the full update, so that they have one. */
static inline bool may_glide(const world *w)
{
    return !w->sweepers && !w->grant && !w->bounds_asked;
}

/* expiry.c */
enum { SPARE_EXPIRIES = 64 };             /* entries beside two a body: what is more is void, and dropped */
void expiry_set(world *w, uint32_t body); /* a pose has come: its deadline counts anew */
/* Units to tell of a pair that is unknown. */
enum { REPORT_UNKNOWN = 1000 };
void expiry_find(world *w);             /* fills stale_now and fresh_now, in the order of ids */
int64_t expiry_next_ns(const world *w); /* not later than the next one; INT64_MAX: none */

/* pair.c */
bool pair_accept(void *context, uint32_t a, uint32_t b);
typedef struct pair_terms { /* what the filters say of two bodies */
    bool checked;
    int looks;               /* 1: A looks at B alone, -1: B at A, 0: both (one-way bodies) */
    double padding, margin;  /* m, added to threshold and range of every subscription */
    const filter_rule *rule; /* that decided, or NULL */
    const char *why;
} pair_terms;
pair_terms pair_get_terms(const world *w, const body *a, const body *b);
/* Units that it may take to hold the rules of two colliders' bodies against each other, and to say which of the two is
 * the first, where that is more than usual: the same whatever has been found before. A broad_price. */
uint64_t pair_price(void *context, uint32_t a, uint32_t b);
/* The same of a pair, without `rule` and `why`: they are kept with it. */
static inline pair_terms pair_kept_terms(const pair *p)
{
    return (pair_terms){.checked = true, .looks = p->looks, .padding = p->padding, .margin = p->margin};
}
void pair_apply_changes(world *w, const broad_changes *changes);
void pair_collect_active(world *w);
/* For slices.c. The boxes of two shapes have met: their pair, PAIR_MAP_NONE if there is no room for it; have parted:
 * theirs, if it lingers. Puts one on the active list: the units that it takes, 0 if it is there. */
uint32_t pair_meet(world *w, uint32_t a, uint32_t b);
uint32_t pair_part(world *w, uint32_t a, uint32_t b);
uint64_t pair_activate(world *w, uint32_t id);
uint64_t pair_units(const world *w, const pair *p);
size_t pair_left_out(const world *w);
size_t pair_most(const world *w); /* that may be looked at in this tick; SIZE_MAX: all */
/* Have its bodies changed since it was decided? */
static inline bool pair_is_pending(const world *w, const pair *p)
{
    const body *a = &w->bodies.at[w->colliders.at[p->a].body], *b = &w->bodies.at[w->colliders.at[p->b].body];
    return p->active_tick < a->changed_tick || p->active_tick < b->changed_tick;
}

/* slices.c */
void slices_begin(world *w);                                /* a tick: how far the broad phase may go */
void slices_take(world *w, uint64_t spent);                 /* puts the pairs of this tick on the active list */
void slices_concern_body(world *w, uint32_t body);          /* what is undone of it is reported */
void slices_forget(world *w, uint32_t body);                /* it is gone */
bool slices_concern(const world *w, uint32_t subscription); /* is one of its bodies due? */
static inline bool slices_is_dear(const collider *s)
{
    return s->overlapping >= 10000; /* units: a hundredth of a millisecond */
}
void slices_report(world *w);      /* after the tick: what is pending */
void pair_end_unwatched(world *w); /* of those that linger, what is reported to nobody any more */
/* Brings active_pairs, and their keys in w->active, into the order of these. Where the ids of two colliders and
 * of the pair, of so many bits each, fit into one number, none has to be looked up again: the same lists. */
void pair_sort_active(world *w, unsigned of_colliders, unsigned of_pairs);
uint32_t pair_find(const world *w, uint32_t collider_a, uint32_t collider_b);

/* Has its state been reported? Then it is decided in full. */
static inline bool pair_is_reported(const pair *p)
{
    return p->is_reported;
}
void pair_note_reported(world *w, uint32_t pair); /* its watches have changed */
void pair_reserve(world *w, size_t count);
static inline const pair_more *pair_more_of(const world *w, const pair *p)
{
    static const pair_more NONE;
    return p->has_more ? &w->pairs_more.at[p - w->pairs.at] : &NONE;
}
/* To be written. By whoever decides the pair, or the tick thread. */
static inline pair_more *pair_more_make(const world *w, pair *p)
{
    pair_more *m = &w->pairs_more.at[p - w->pairs.at];
    if (!p->has_more) memset(m, 0, sizeof *m);
    p->has_more = true;
    return m;
}
bool pair_is_predicted(const world *w, const pair *p);

/* swept.c */
enum { WAYPOINTS_MAX = 64 }; /* of a body in one tick; beyond it every other one is left out, and counted */
/* ns, saturated: stamps are the clients', and may be anything. */
static inline int64_t stamps_between(int64_t from_ns, int64_t to_ns)
{
    int64_t span;
    if (!__builtin_sub_overflow(to_ns, from_ns, &span)) return span;
    return to_ns > from_ns ? INT64_MAX : INT64_MIN;
}
int64_t body_span_ns(const world *w, const body *b); /* of its motion since the last tick; 0: it did not move */
double body_span(const world *w, const body *b);     /* the same in s */
double body_leg_begins(const body *b, size_t leg); /* as a share of the motion's time; of the one behind the last: 1 */
/* From `late` seconds on. False: it has made too many turns until then to be told where it stands. */
bool motion_begin_at(motion *m, double late);
/* The leg from the share `from` on, which is in it, when the whole motion takes `span` seconds instead of its own.
 * False: as motion_begin_at. */
bool body_leg(const world *w, const body *b, size_t leg, double from, double span, motion *m);
void body_pass(world *w, body *b); /* another pose is coming: the one that it has may become a waypoint */
bool body_motion_turns(const body *b);
bool body_has_predicted_motion(const body *b);
motion body_predicted_motion(const body *b); /* from its pose on */
aabb body_swept_bounds(const world *w, const body *b, const collider *s, aabb box);

aabb body_motion_bounds(
    const world *w, const body *b, const collider *s, aabb box); /* the same without what is predicted */

/* past.c */
static inline int64_t past_start_ns(const past_motion *p)
{
    return stamps_between(p->span_ns, p->to_ns ? p->to_ns : p->now_ns);
}
void past_keep(world *w);                   /* at the end of a tick: what moved in it and is waited for */
void past_stands(world *w, uint32_t body);  /* it is about to be elsewhere, without a motion */
void past_reshape(world *w, uint32_t body); /* its shapes are about to be others, or gone */
aabb past_bounds(const body *b, aabb box);  /* that, and all that it keeps */
uint64_t past_decided(const world *w, const pair *p, const body *a, const body *b); /* the tick up to which it is */
uint64_t past_next(
    const body *a, const body *b, uint64_t after); /* tick of which one keeps a motion; UINT64_MAX: none */
size_t past_waiting(const world *w, const pair *p, const body *a, const body *b); /* so many ticks are not decided */
/* As it was in that tick: itself, or *out. Any thread. */
const body *past_body(const world *w, const body *b, uint64_t tick, body *out);
bool past_apart(const body *a, const body *b, double by); /* proven by the boxes of what past_body gave */
void past_save(const body *b, bytes_out *to);
bool past_restore(world *w, uint32_t body, bytes_in *from);

/* impact.c */
void impact_decide(world *w);

/* impact_turns.c */
/* Makes as many of the searches as the slice has room for, with `search` for some places of sweep_order. */
typedef void impact_batch(world *w, size_t from, size_t to);
void impact_search(world *w, impact_batch *search);
uint64_t impact_units(const world *w, const pair *p); /* that they are expected to take, with kept motions */

/* impact_wait.c */
void impact_wait_init(world *w);
const char *impact_wait_validate(const world *w); /* what is wrong with the lists, or NULL; ... */
const char *impact_wait_restored(world *w);       /* ... the same of those that were read */
uint64_t impact_go_on(world *w);                  /* activates some of those that wait: units */
void impact_settle(world *w);                     /* those that are not done wait */
void impact_forget(world *w, uint32_t pair);      /* it waits no more */
uint32_t impact_list_of(const world *w, const pair *p);
size_t impact_waiting_of(const world *w, uint64_t owner); /* his bodies that have such pairs */

/* impact_axis.c */
/* A world direction that may keep them apart from 0 to the span; zero: none was found. */
vec3 impact_axis(const toi_mover *a, const toi_mover *b, const toi_request *request, void *scratch, uint32_t *queries);

/* news.c */
void news_begins(world *w, uint32_t watch); /* one that was not there before: for world_oldest_stamp */
/* ... of two events of one watch. */
/* The same bits in all but the ages: reported again, it would say nothing. The names are equal but for which is A. */
bool news_same_facts(const world_event *a, const world_event *b);
bool news_same_impact(const world_impact *a, const world_impact *b);

/* events_impact.c */
void events_of_sweeps(world *w);

/* snapshot.c */
void snapshot_take(world *w, uint32_t watch); /* as it stands, before it changes */
static inline void snapshot_before(world *w, uint32_t watch)
{
    const subscription *i = &w->subscriptions.at[w->watches.at[watch].subscription];
    if (i->snapping && w->watches.at[watch].snap != i->snap) snapshot_take(w, watch);
}
void events_snapshots(world *w);

/* What the files of events share is in events.h. watch.c */
enum {
    SPARE_HELD = 64
}; /* updates held back beside two a watch of a subscription: what is more is void, and dropped */
void events_pair_ended(world *w, uint32_t pair, uint8_t cause);
void events_unmatched(world *w);

/* events.c */
void events_of_active(world *w);

/* events_stale.c */
void events_teleported(world *w);
void events_unknown(world *w);
void events_known(world *w);

/* events_due.c */
void events_held_back(world *w);
void events_collect(world *w, world_batches *out);

#endif
