/* world: bodies, pairs, subscriptions, the tick. Commands in, events out; no network, no clock, no threads but the
 * pool's.
 *
 * Between two ticks the owner puts, moves and removes bodies and subscriptions; world_tick then finds the pairs that
 * this can have changed, decides each by the cheapest proof, and says what began, persists or ended, in an order that
 * depends on the commands alone: not on the number of workers, not on caches, not on the order in which poses came.
 * One thread calls; queries run between ticks. All ids are dense, the least free one first.
 *
 * The sketch of DESIGN.md passes an array of commands to world_tick; they are calls here, because a batch of 10,000
 * poses would otherwise be copied once more, and because a refusal is then reported where it arises. */
#ifndef COLLIDED_WORLD_WORLD_H
#define COLLIDED_WORLD_WORLD_H

#include "broad/broad.h"
#include "filter_rule.h"
#include "toi/toi.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

typedef struct world world;

enum { WORLD_NONE = UINT32_MAX };

typedef struct world_options {
    unsigned workers; /* threads of the narrow phase, the caller's included */
    narrow_engine engine;
    broad_kind broad; /* how boxes that meet are found; the events are the same */
    bool caches;      /* off: every pair is decided from nothing; the events are the same (a test) */
    double margin;    /* fat boxes grow by this share of the shape's reach, and reach ahead of its motion */
    size_t max_pairs; /* that are looked at; see world_figures.pairs_left_out. 0: as many as there are */
} world_options;
world_options world_options_default(void);

world *world_create(const world_options *options);
void world_destroy(world *w);

/* Of max_pairs, so many may be now; 0: all. It ends no pair, and lets none begin beyond it: what is left out is told as
 * what max_pairs leaves out. For who is short of memory; a replay has to say the same before each tick. */
void world_set_pairs_most(world *w, size_t most);
/* Gives memory back that only more pairs, or more events, would need. Between two ticks; the batches of the last one
 * are gone. It changes no event. */
void world_trim(world *w);

/* Which way of finding them stands since the last tick, never BROAD_AUTO; and in words, with the reason. */
broad_kind world_broad_kind(const world *w);
void world_report_broad(const world *w, char text[96]);

typedef enum world_status { WORLD_OK, WORLD_NAME_TAKEN, WORLD_UNKNOWN_ID } world_status;

/* ---- bodies ---- */

typedef struct world_shape {
    shape shape; /* checked by shape_check; its hulls outlive the body by one tick; a compound is copied */
    pose local;  /* in the body's frame */
} world_shape;

/* Is the motion between two poses swept, for subscriptions in impacts? Of a pair one that is not OFF is enough. */
typedef enum world_ccd { /* numbers as on the wire */
    WORLD_CCD_OFF,
    WORLD_CCD_LINEAR, /* its path, in the orientation that it has at the end */
    WORLD_CCD_FULL    /* its path and its turning */
} world_ccd;

typedef struct world_body { /* copied, but for hulls */
    const char *name;       /* unique */
    const char *group;      /* "" = none */
    bool fixed;             /* not checked against other fixed bodies */
    uint64_t category, mask;
    uint64_t owner; /* whose work its pairs are, see world_set_slice */
    bool in_step;   /* he steps together with others */
    bool one_way;   /* its mask alone decides, whatever the masks of those that it meets say (a hit box) */
    world_ccd ccd;
    double acceleration; /* m/s^2, >= 0: what is predicted of it holds for all motions that accelerate by at most
                            so much, ... */
    double angular_acceleration; /* rad/s^2, >= 0: ... and so much */
    int64_t deadline_ns;         /* 0 = never stale */
    int64_t stamp_ns;            /* of the pose; 0 = unknown */
    bool stamp_is_now;           /* it is that of the announcement: it makes no pose old, whatever clock that is by */
    pose pose;
    const world_shape *shapes;
    size_t shape_count;
    const filter_rule *rules;
    size_t rule_count;
} world_body;

/* A new body (*id == WORLD_NONE), or the new definition of an old one: shapes that stayed the same keep their contacts.
 * Under a new name it is a new body, and *id another one. */
world_status world_put_body(world *w, uint32_t *id, const world_body *def);
/* The newest pose; velocities (m/s, rad/s; then what it does from here on is known) may be NULL (then it is estimated
 * from the last two stamped poses). Only a stamp makes it fresh again after its deadline. */
world_status world_move_body(world *w, uint32_t id, pose to, int64_t stamp_ns, const vec3 *linear, const vec3 *angular);
/* It is elsewhere, without a motion there: its contacts end, and those that it has there begin. */
world_status world_teleport_body(
    world *w, uint32_t id, pose to, int64_t stamp_ns, const vec3 *linear, const vec3 *angular);
/* Many at once: what world_move_body, or where it teleports, world_teleport_body does for each, in this order. One that
 * is older than the pose that its body has is left out, unless it teleports, or that pose is more than 2 s newer than
 * the last tick (of a clock that has been set back, or is wrong); so is one of no body. The number of those, and where
 * in `ids` they are (room for `count`). */
typedef struct world_poses {
    const uint32_t *ids, *places; /* the pose of ids[i] is that of number places[i], or without places, i */
    size_t count;
    const double *positions, *orientations; /* m, 3 each; w x y z, 4 each */
    const double *linear, *angular;         /* m/s, rad/s, 3 each; or NULL */
    const uint8_t *teleports;               /* or NULL: none does */
    int64_t stamp_ns;
} world_poses;
size_t world_move_bodies(world *w, const world_poses *poses, uint32_t *left_out);
/* What was moved since the last tick is a step, and may be more than the next one can take: then some of it is left to
 * those that follow, is counted in pending_bodies until then, and is told of, and asked for, as it was. Who answers
 * steps waits until nothing is pending (world_pending_of), and moves nothing more of it before. */
void world_part_moves(world *w);
/* Its contacts end with this cause in the next tick; its id is free after it. */
world_status world_remove_body(world *w, uint32_t id, uint8_t cause);
/* The same of one of very many: with the next ticks, as far as their slices go. Until its turn it stands where it is,
 * counted in pending_bodies, but no more among the bodies and shapes that there are; a body that is put under its name
 * takes its place at once. Whoever put it forgets its id. */
world_status world_remove_soon(world *w, uint32_t id, uint8_t cause);
bool world_some_go(const world *w); /* are there any? Their hulls are still needed */
/* Stale at once and until the next pose, whatever its deadline: its owner is lost. */
world_status world_hold_body(world *w, uint32_t id);

uint32_t world_find_body(const world *w, const char *name); /* WORLD_NONE */
const char *world_body_name(const world *w, uint32_t id);   /* NULL if unknown */
pose world_body_pose(const world *w, uint32_t id);
/* Where it is now, and how it stands: for whoever looks at all of them again and again. False if unknown. */
typedef struct world_glance {
    const pose *pose; /* the world's own */
    bool fixed, stale, held, pending, swept, one_way;
} world_glance;
bool world_glance_at(const world *w, uint32_t id, world_glance *out);
/* Does a pattern ("*", "?", "group:NAME") match a body of that name and group? Walks the pattern: for few questions. */
bool world_pattern_matches(const char *pattern, const char *name, const char *group);
int64_t world_body_stamp_ns(const world *w, uint32_t id);
/* The definition as it is now, with the newest pose; `shapes` has room for shape_count of them (0: ask with NULL).
 * Texts and rules are the world's own, until the next call that changes it. */
world_status world_get_body(const world *w, uint32_t id, world_body *out, world_shape *shapes);
/* Its shapes and the children of its compounds, as world_figures counts them; 0 if unknown. */
size_t world_body_shapes(const world *w, uint32_t id);

/* ---- subscriptions ---- */

typedef enum world_fact {
    WORLD_TOUCH = 1,
    WORLD_DISTANCE = 2,
    WORLD_MANIFOLD = 4,
    WORLD_IMPACT = 8,     /* contacts on the way from one tick to the next, of bodies that choose so (world_ccd) */
    WORLD_PREDICT = 16,   /* contacts to come within the horizon, from velocities */
    WORLD_FEATURES = 128, /* of soft bodies: the features that meet on the way of each step ... */
    WORLD_SAFE_STEP = 256 /* ... and the share of the way that is proven to be free */
} world_fact;

/* How far a pair is looked into for touch, distance and manifold. One that several subscriptions share gets what the
 * finest of them asks. */
typedef enum world_accuracy { /* numbers as on the wire */
    WORLD_BY_TOLERANCE,
    WORLD_BY_BOXES,  /* bounds without a search, reported anew only when what was reported does not hold any more; no
                        manifold */
    WORLD_BY_VERDICT /* touch: until it is proven, and no narrower; no distance, no manifold */
} world_accuracy;

typedef struct world_subscription {
    unsigned facts;
    const char *select_a, *select_b; /* as filter_rule.pattern; copied */
    double threshold;                /* m; contact = lower bound of the signed distance at or below it: never missed */
    double range;                    /* m; with WORLD_DISTANCE */
    double hysteresis;               /* m, >= 0; a contact ends, and near turns far, only so much farther away */
    double tolerance;                /* m; 0: relative_tolerance says it */
    double relative_tolerance;       /* of the reaches of both shapes together; both 0: as narrow as doubles give */
    world_accuracy accuracy;
    double horizon;    /* s, with WORLD_PREDICT: from the newest pose of a pair on, to
                          which an older one is carried on; until so long after the older one */
    int64_t period_ns; /* updates at most so often; 0 = each tick */
    uint64_t owner; /* whom it tells. His bodies, and nobody else's, are pending (world_pending_of) while a search for
                       impacts waits that it asks for; ... */
    bool in_step;   /* ... he steps together with others: so are theirs */
    bool soft_each; /* with WORLD_FEATURES: each of them, else how many they are */
    uint32_t soft_most; /* of a pair, at most; 0 = all. The others are counted */
} world_subscription;

/* Its next batch is a snapshot. */
world_status world_put_subscription(world *w, uint32_t *id, const world_subscription *def);
/* Ends its contacts in the next tick with this cause, in a closing batch. */
world_status world_remove_subscription(world *w, uint32_t id, uint8_t cause);
void world_want_snapshot(world *w, uint32_t id);
/* The oldest stamp of the poses that what is reported of it now rests on, or an older one that this rested on when the
 * first of these calls was made; 0: none is stamped. Of more than OLDEST_STAMP_PART watches it looks at so many;
 * false: there are more, and the next call goes on with them. One subscription at a time is looked through in parts,
 * the others wait for it. *looked is raised by how many it looked at. */
enum { OLDEST_STAMP_PART = 20000 /* a millisecond or two */ };
bool world_oldest_stamp(world *w, uint32_t id, size_t *looked, int64_t *oldest_ns);
/* What an operator watches of a subscription: what was last reported to it and still holds. */
typedef struct world_brief {
    size_t contacts, unknown; /* pairs that touch; pairs of which nothing can be said */
    double nearest;           /* m: the least lower bound of those that touch or are near; INFINITY: there are none */
    int64_t soonest_ns;       /* when the first of the predicted contacts may be, ns since the Unix epoch; INT64_MAX */
    int64_t oldest_ns;        /* the oldest stamp of the poses that it rests on; 0: none is stamped */
    size_t pairs;             /* that were looked at */
} world_brief;
/* Walks at most `most` pairs of it; false: there are more, and *out is of the first of them. */
bool world_brief_of(const world *w, uint32_t id, size_t most, world_brief *out);
/* In the next tick, updates are reported of all its pairs that are decided, also where nothing differs from what was
 * reported last: for who keeps no state of his own. */
void world_want_all(world *w, uint32_t id);
world_status world_get_subscription(
    const world *w, uint32_t id, world_subscription *out); /* texts are the world's own */

/* ---- the tick ---- */

typedef enum event_kind { /* numbers as on the wire */
    EVENT_BEGIN = 1,
    EVENT_UPDATE,
    EVENT_END,
    EVENT_NEAR,
    EVENT_FAR,
    EVENT_UNKNOWN,
    EVENT_KNOWN,
    EVENT_IMPACT,    /* they met on their way since the last tick */
    EVENT_PREDICTED, /* they will meet; reported again as long as they will */
    EVENT_AVERTED    /* no more */
} event_kind;

typedef enum event_cause { /* numbers as on the wire */
    CAUSE_MOTION,
    CAUSE_REMOVED,
    CAUSE_OWNER_LOST,
    CAUSE_FILTER,
    CAUSE_SHAPE,
    CAUSE_SUBSCRIPTION,
    CAUSE_SHUTDOWN,
    CAUSE_STALE,
    CAUSE_SNAPSHOT,
    CAUSE_TELEPORT
} event_cause;

typedef struct world_impact { /* of EVENT_IMPACT and EVENT_PREDICTED */
    double lo, hi;       /* s since start_ns: apart before lo, proven; touching at hi, proven; INFINITY: not proven */
    int64_t start_ns;    /* IMPACT: of the pose from which the newer of the two came; PREDICTED: of the newest pose */
    pose pose_a, pose_b; /* of the bodies, at lo */
    bool estimated;      /* PREDICTED: a velocity was, from two poses */
} world_impact;

typedef enum world_achieved { /* numbers as on the wire: what an interval is, beside what was asked */
    WORLD_CERTAIN,            /* as narrow as asked; and what is reported (touching, near, or not) is proven */
    WORLD_WITHIN,             /* as narrow as asked; the threshold (range) lies within it */
    WORLD_WIDE,               /* wider than asked: arithmetic, iterations or the effort of a query ended */
    WORLD_STOPPED             /* wider than asked: the budget ended */
} world_achieved;

typedef struct world_event {
    uint8_t kind, cause, achieved;
    int32_t shape_a, shape_b;    /* index in the body; -1: the whole body */
    int64_t contact;             /* id: of the contact, or of the nearness; 0: a whole body is unknown */
    const char *name_a, *name_b; /* "*" for any other body */
    double lo, hi;
    vec3 axis, point_a, point_b; /* world frame */
    int64_t age_a_ns, age_b_ns;  /* -1 = fixed or not stamped */
    double closing;      /* m/s, of the two points along the axis, from the bodies' velocities as far as they are
                            known; positive = they approach; of impacts, at impact.lo */
    pose pose_a, pose_b; /* of the bodies, for which lo, hi, axis and points are; all 0: not kept (of a snapshot, or of
                            what ends), or those of the impact */
    manifold manifold;   /* points in the world frame */
    world_impact impact; /* IMPACT, PREDICTED: lo, hi, axis and points are those at impact.lo */
} world_event;

/* ---- soft bodies (soft/soft.h) ---- */

/* The way of a step is, for each vertex, the straight line from where it is to where the frame says; for a rigid body
 * beside it, the way from its pose at the last tick to its pose. */
typedef enum world_frame_mode { /* numbers as on the wire */
    WORLD_FRAME_MOVES,
    WORLD_FRAME_PROPOSES, /* is that way free? Nothing moves */
    WORLD_FRAME_TELEPORTS
} world_frame_mode;

enum { WORLD_SOFT_LEAST = 2048 }; /* vertices that a soft body counts for in figures, at least */

typedef struct world_range { /* vertices of a frame that follow each other */
    uint32_t first, count;
    const vec3 *at; /* m, world */
} world_range;

typedef struct world_frame {
    int64_t frame, stamp_ns;
    world_frame_mode mode;
    const world_range *ranges; /* a vertex in none of them stays where the newest frame has it */
    size_t range_count;
} world_frame;

typedef enum world_frame_status {
    WORLD_FRAME_TAKEN,
    WORLD_FRAME_NOT_SOFT,  /* no such body, or a rigid one */
    WORLD_FRAME_NO_VERTEX, /* a range goes beyond its vertices */
    WORLD_FRAME_OLD,       /* as new as, or older than, the newest; a teleport may go back */
    WORLD_FRAME_CROWDED    /* too many proposals of it wait */
} world_frame_status;

/* A step is found out over one or more ticks: until it is done the body stands where it was, and what is not done is
 * unknown, never free. Of frames that come meanwhile the newest takes the place of those before (frames_skipped):
 * the way of the next step is then the line from where it is to that one. */
world_frame_status world_put_frame(world *w, uint32_t body, const world_frame *frame);
size_t world_soft_vertices(const world *w, uint32_t body);                       /* 0: it is rigid, or unknown */
const vec3 *world_soft_positions(const world *w, uint32_t body, int64_t *frame); /* NULL: likewise */

typedef struct world_feature {
    uint8_t kind, proof; /* as soft_kind and soft_proof; kind 3: a face, and a rigid shape */
    uint32_t a, b;
    float t_lo, t_hi, normal[3], bary[2];
} world_feature;

typedef struct world_soft { /* what a step of a pair came to, for one subscription; A and B as in its events */
    const char *name_a, *name_b;
    int32_t shape_a, shape_b;
    int64_t contact; /* 0: they are in none */
    int64_t frame_a, frame_b;
    bool proposed;
    bool unfinished; /* it took too much work: what was not looked at is not called free */
    uint64_t vertex_face, edge_edge, face_shape, within, undecided;
    uint64_t left_out; /* of these, that are not reported for lack of memory */
    double safe_lo, safe_hi;
    size_t count;         /* of features that are reported: world_soft_feature */
    const void *features; /* the world's own */
    bool turned;
} world_soft;
/* Until the next call that changes the world; i < count. */
world_feature world_soft_feature(const world_soft *of, size_t i);

typedef struct world_batch { /* the events of one subscription in one tick; a snapshot is a batch of its own, behind
                                them */
    uint32_t subscription;
    bool snapshot; /* the whole state as of the tick in which it begins; a large one comes in portions, tick by tick,
                      ... */
    bool goes_on;  /* ... of which this is not the first ... */
    bool more;     /* ... nor the last. It is over, too, if another begins, or the subscription closes */
    bool closing;  /* the subscription is gone */
    const world_event *events;
    size_t count;
    const world_soft *soft; /* steps of soft bodies, so many: */
    size_t soft_count;
    size_t undone; /* pairs of this subscription that the budget left with a wider interval than it asks, and all that
                      are left out: whose they would be is not looked at; and while some of its bodies are pending, all
                      that are */
} world_batch;

typedef struct world_batches { /* in the order of subscription ids; valid until the next call that changes the world */
    const world_batch *at;
    size_t count;
    uint64_t hash; /* of all events since the world was created: equal for equal commands */
} world_batches;

/* A budget. The cascade counts its work in units, by a table of the kinds of pairs: about a nanosecond each, the same
 * on every machine. In each tick it bounds all pairs and then refines one after the other, by need, as far as `grant`
 * says: it is called by the tick thread with the units done so far, 0 first, and returns how many may be done in all;
 * what it returned last again, or less, ends the work. What is left keeps bounds that hold, told as WORLD_STOPPED, and
 * goes first in the next tick, which is due at once. The same grants give the same events, whoever computes them; one
 * that returns the `work` of another run's tick at once stops where that one stopped, however it was granted there.
 * With a budget the memory of earlier ticks is always used, caches or not. Searches for impacts are not cut. NULL
 * (default): no budget. */
typedef uint64_t world_grant(void *context, uint64_t done);
void world_set_budget(world *w, world_grant *grant, void *context);

/* A slice. Finding and deciding pairs takes at most about so many units in a tick (UINT64_MAX, the default: whatever it
 * takes): what is left is pending and goes on in the next tick, which is due at once. Bodies are taken one after the
 * other: their owners in turns, with equal shares in units, an owner's bodies in the order in which they changed. A
 * pair of two bodies that are both pending is the work of the one who has far more of them.
 *
 * What is pending is unknown: what was reported of such a pair before stands, and world_batch.undone counts it for each
 * subscription that it may concern. So it is with pairs whose searches (WORLD_IMPACT, WORLD_PREDICT) have been put off:
 * a swept motion is searched later as it was, a predicted one from the newest poses on. With a slice, one search of
 * meshes or compounds takes some 9 ms at most: what is not decided by then is reported as WORLD_WIDE. The same commands
 * and slices give the same events; where no tick is cut, those of a world without. */
void world_set_slice(world *w, uint64_t units);
/* Did the slice make a difference in the last tick? If not, any larger one gives the same events. */
bool world_was_sliced(const world *w);
/* Bodies of this owner of whose pairs, or of the searches of these, some are pending. */
size_t world_pending_of(const world *w, uint64_t owner);

void world_tick(world *w, int64_t now_ns, world_batches *out);

/* The wall clock was set back by so much, > 0, since the last tick: deadlines, rates and the stamps of poses (those
 * that are within a day of it: others are of another clock) go back with it, and what comes now is newer than what
 * came. */
void world_clock_back(world *w, int64_t by_ns);

/* When the next tick is due although nothing came: a deadline, or an update that the rate held back. INT64_MAX: never.
 */
int64_t world_next_due_ns(const world *w);
/* Units, of about a nanosecond, that it takes the next tick to put anew the boxes of what has changed: by the shapes of
 * these bodies, and by what hulls they have. */
uint64_t world_effort(const world *w);
/* What a pose adds to it: nothing if the body is among them already, or if that changes nothing for it. NULL: what it
 * takes to put the body anew, whatever else is so. */
uint64_t world_effort_of(const world *w, uint32_t body, const pose *to);
bool world_has_wide(const world *w); /* bodies of which each takes several times as much as most do */
/* Are there subscriptions left of which not all has ended that they were told, since a slice did not suffice? */
bool world_is_closing(const world *w);
bool world_changed(
    const world *w); /* since the last tick, something that it has to do with was put, moved or removed */
/* Poses have come since then that change nothing but where their bodies are: a tick has nothing to do with them, but is
 * the next point in time on their ways. */
bool world_glided(const world *w);

/* ---- queries ---- */

typedef struct world_hit {
    uint32_t body_a, body_b; /* WORLD_NONE where there is only one */
    const char *name_a;      /* of body_a, the world's own ... */
    int32_t shape_a;         /* ... and which of its shapes; -1: not one of them */
    double lo, hi;
    vec3 axis, point_a, point_b;
    int64_t age_ns;
    bool stale;
} world_hit;

typedef struct world_hits { /* the caller's, empty; freed with free(at) */
    world_hit *at;
    size_t count, capacity;
    size_t most;     /* of bodies by name: so many are kept, others are counted; 0: any number */
    size_t left_out; /* those that are counted */
    /* Asked again and again during a search: may it go on? NULL: always. If not, the search ends where it is, and says
     * so in `gave_up`: then what was found of all bodies in a box, or by name, is true and not all, and what was found
     * of the nearest, or the first, is no answer. */
    bool (*go_on)(void *context);
    void *go_on_context;
    bool gave_up;
} world_hits;

static inline bool world_may_go_on(world_hits *hits)
{
    if (hits->go_on && !hits->gave_up) hits->gave_up = !hits->go_on(hits->go_on_context);
    return !hits->gave_up;
}

/* The least signed distance of the shapes of two bodies, within `tolerance`. */
void world_query_distance(const world *w, uint32_t a, uint32_t b, double tolerance, int64_t now_ns, world_hits *out);
/* The first body that the ray meets within `length` (may be INFINITY); lo and hi bracket the length of the free part.
 */
void world_query_ray(
    const world *w, vec3 origin, vec3 direction, double length, double tolerance, int64_t now_ns, world_hits *out);
/* The first body that a box meets on its way along `direction`; lo and hi bracket the length of the free part. */
void world_query_cast(const world *w, pose at, vec3 half, vec3 direction, double length, double tolerance,
    int64_t now_ns, world_hits *out);
/* The first body that a body would meet if it moved and turned so (m/s, rad/s, world axes) from where it is for `span`
 * seconds, while all others stand: lo and hi bracket the time, s; hi is infinite where contact is not proven. Those
 * that it touches already count, and those that it may touch do not. |angular| span <= MOTION_ANGLE_MAX. */
void world_query_sweep(const world *w, uint32_t body, vec3 linear, vec3 angular, double span, double tolerance,
    int64_t now_ns, world_hits *out);
/* The `most` nearest bodies within `range` (may be INFINITY) of a box, or of a body, by rising lower bound; touching
 * ones are below 0. Bounds are certified within `tolerance`, so that two nearer to each other than it may change
 * places. Here as in all searches, of equal ones the body whose name comes first is reported: no answer depends on ids.
 */
void world_query_nearest(
    const world *w, pose at, vec3 half, double range, size_t most, double tolerance, int64_t now_ns, world_hits *out);
void world_query_nearest_to(
    const world *w, uint32_t body, double range, size_t most, double tolerance, int64_t now_ns, world_hits *out);
/* Every body that overlaps a box, in the order of names. */
void world_query_box(const world *w, pose at, vec3 half, int64_t now_ns, world_hits *out);
/* Every body whose name matches, in the order of ids: point_a = position. */
void world_query_bodies(const world *w, const char *pattern, int64_t now_ns, world_hits *out);
/* Why is this pair looked at, or not, and what is known of it: lines for people. Returns what snprintf would. */
int world_explain(const world *w, uint32_t a, uint32_t b, int64_t now_ns, char *text, size_t size);
/* The same, as long as `patience`, which gets no hits, lets it go on; then it says how many pairs of shapes are left.
 */
int world_explain_within(
    const world *w, uint32_t a, uint32_t b, int64_t now_ns, world_hits *patience, char *text, size_t size);

/* ---- figures ---- */

typedef enum world_stage { /* who settled a pair: counted, cumulative */
    STAGE_UNASKED,         /* nobody wants to know how it stands now */
    STAGE_UNKNOWN,
    STAGE_STANDING, /* what was reported of it by bounds still holds */
    STAGE_BOUNDS,   /* bounds without a search: all that was asked, or that the budget allowed */
    STAGE_MOTION_BOUND,
    STAGE_CACHED_AXIS,
    STAGE_CLOSED_FORM,
    STAGE_GJK,
    STAGE_EPA,
    STAGE_SAT,
    STAGE_CCD,
    STAGE_MPR,
    STAGE_COUNT
} world_stage;
const char *world_stage_name(world_stage stage);

typedef struct world_figures {
    size_t bodies, shapes, subscriptions, pairs, contacts, stale_bodies; /* now */
    size_t pairs_left_out; /* now: their boxes meet, but max_pairs are there already. Nobody is told of these pairs
                              until others have ended: then the ones with the least shape ids come first */
    uint64_t ticks, moves, pair_ticks; /* cumulative */
    uint64_t stages[STAGE_COUNT];
    uint64_t narrow_queries; /* full ones */
    uint64_t manifolds, wide, refined,
        peer_failures;                      /* answers: with points, wider than asked, decided beyond doubles */
    uint64_t sweeps, sweep_queries;         /* searches for a time of impact, and the distances and verdicts in them */
    uint64_t sweeps_by_axis;                /* of them, those that an axis proved free, without any distance */
    uint64_t impacts, predicted, undecided; /* found; of all searches, those whose steps ended */
    uint64_t rulings;                       /* pairs of bodies whose rules were held against each other */
    uint64_t dropped_motions; /* bodies of which motions were dropped before they were searched: reported as "*" */
    uint64_t coarse_motions;  /* motions of more poses than are kept: every other one was left out */
    uint64_t events;
    /* The budget. Of the last tick: units done, pairs left for the next one, of them without bounds of their own (what
     * is told of those is what balls about them prove). */
    uint64_t work, undone, unbounded;
    uint64_t undone_ticks; /* cumulative: ticks that left something */
    /* The slices. Now: bodies that are pending, and how many pairs that concerns, at least (what has not been found is
     * not counted; those whose searches have been put off are); units that the last tick took; cumulative: ticks in
     * which the slice made a difference. */
    size_t pending_bodies, pending_pairs;
    size_t parked_bodies; /* that wait for max_pairs */
    uint64_t slice_units, sliced_ticks;
    size_t soft_vertices;             /* of all soft bodies now, each counted for WORLD_SOFT_LEAST at least */
    size_t soft_bodies, soft_waiting; /* now; of them those with a step to do */
    uint64_t soft_steps, frames_skipped, soft_unfinished; /* cumulative */
} world_figures;
world_figures world_get_figures(const world *w);

/* Units of the cascade's work for this subscription since it was put; what a pair takes is split evenly among those
 * that want it. 0 if unknown. */
uint64_t world_subscription_work(const world *w, uint32_t id);

/* ---- what the narrow phase was asked in the last tick (answers.c), for measurements ---- */

typedef struct world_answer {
    shape_type type_a, type_b;
    double size;   /* m: the sum of their reaches; what accuracies are relative to */
    double limit;  /* m: beyond it nothing is reported */
    double lo, hi; /* as it was answered */
} world_answer;

/* Until the next call that changes the world; i below world_answers. */
size_t world_answers(const world *w);
void world_get_answer(const world *w, size_t i, world_answer *out);
/* The same question once more, from nothing, as if all subscriptions in the pair had asked for this accuracy (by
 * tolerance: of `relative` times its size); and as narrow as arithmetic gives, however far the two are apart. By the
 * calling thread; nothing of the world changes. */
void world_ask_again(const world *w, size_t i, world_accuracy accuracy, double relative, double *lo, double *hi);
void world_ask_exactly(const world *w, size_t i, double *lo, double *hi);
/* SHAPE_TYPE_COUNT: there is none. */
shape_type world_shape_type(const world *w, const char *body_name, int32_t index);

/* For tests: the first broken invariant, or NULL. */
const char *world_validate(const world *w);

#endif
