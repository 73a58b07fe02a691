/* soft_state: soft bodies in the world: where their vertices are, frames that wait, steps under way and what came of
 * those that are done. For the soft_*.c of this folder, and for who asks them. Tick thread.
 *
 * A soft body has two colliders at the same place, the surface and its shadow: the pair of the two is the body's pair
 * with itself, so that it is found, watched, reported and ended like every other; the shadow is in no other pair, and
 * nobody outside of the world hears of it. */
#ifndef COLLIDED_WORLD_SOFT_STATE_H
#define COLLIDED_WORLD_SOFT_STATE_H

#include "state.h"

#include "base/bytes.h"
#include "soft/soft.h"

typedef struct soft_frame { /* places of all vertices, owned */
    vec3 *at;               /* NULL: there is none */
    int64_t frame, stamp_ns;
    bool teleports;
} soft_frame;

enum { SOFT_PROPOSALS_MAX = 8 }; /* of one body that wait */

typedef struct soft_place { /* of one body */
    uint32_t body, collider, shadow;
    const soft_mesh *mesh;
    size_t count; /* vertices */
    double half_thickness;
    vec3 span[2];           /* about its last way, and its half thickness; the shape's */
    vec3 *from, *at;        /* its last way: from where it was to where it is */
    int64_t frame;          /* that it is at; 0: as it was announced */
    uint64_t way_tick;      /* the tick in which it went that way; in others it stands */
    soft_frame next, after; /* that waits, or is under way; that has come since */
    soft_frame proposals[SOFT_PROPOSALS_MAX];
    size_t proposal_count;
    soft_body *engine;
    bool under_way; /* a step with it is */
    bool asked;     /* how it stands is to be found out */
} soft_place;

typedef struct soft_result { /* of one pair in one step, for one separation; canonical order is that of these fields */
    uint64_t tick;           /* in which it was found: kept until its pair is decided, if that is put off; ... */
    bool is_told;            /* ... to subscriptions that ask for steps it is reported once */
    uint64_t key;            /* of the two colliders, in the pair's order */
    uint32_t a, b;           /* them */
    double separation;       /* m, beyond the half thicknesses */
    bool proposed;
    int64_t frame_a, frame_b;
    bool unfinished;
    soft_tally tally;
    uint64_t face_shape;
    double safe_lo, safe_hi;
    soft_contact *contacts; /* owned: by kind, a, b */
    size_t count;
    struct soft_touch { /* where and how they meet, one a contact */
        float normal[3], bary[2];
    } * touches;
    bool has_first; /* of the contact with the least t_lo: */
    vec3 first_point, first_normal;
    double first_lo, first_hi;
} soft_result;

typedef struct soft_positions { /* of all vertices, at the start and the end of a step */
    const vec3 *from, *to;
} soft_positions;

typedef struct soft_asked { /* of a step: pairs of one separation */
    double separation;
    soft_want want;
    size_t most;
    ARRAY(soft_pair) pairs;
} soft_asked;

typedef struct soft_job {
    ARRAY(soft_place *) places;
    ARRAY(soft_body *) bodies; /* of the engine, by place */
    ARRAY(soft_asked) asks;
    size_t ask; /* that is under way */
    bool begun, proposed;
    soft_frame proposal;
    soft_body *proposed_body; /* owned */
    soft_step *step;
    uint64_t units;
    ARRAY(soft_result) results;
} soft_job;

typedef struct soft_told {
    uint32_t subscription;
    world_soft what;
} soft_told;

struct soft_world {
    ARRAY(soft_place *) places;                 /* body.soft - 1 is the index; NULL: free */
    ARRAY(soft_job *) jobs;                     /* under way */
    ARRAY(soft_result) results;                 /* of this tick, and of pairs that wait for their turn */
    ARRAY(soft_told) told;                      /* in this tick, in the order of subscriptions */
    ARRAY(world_soft) batch;                    /* what of it is one subscription's stands together */
    size_t count;                               /* of places */
    size_t waiting;                             /* places that have something to do */
    uint64_t steps, skipped, unfinished, units; /* cumulative: steps done, frames passed over, steps given up */
};

static inline bool collider_is_soft(const collider *s)
{
    return s->shape.type == SHAPE_SOFT;
}
static inline bool pair_is_soft(const world *w, const pair *p)
{
    return collider_is_soft(&w->colliders.at[p->b]) || collider_is_soft(&w->colliders.at[p->a]);
}
static inline soft_place *soft_place_of(const world *w, const body *b)
{
    return b->soft ? w->soft->places.at[b->soft - 1] : NULL;
}

/* soft_bodies.c */
void soft_enter(world *w, uint32_t body, uint32_t collider, uint32_t shadow);               /* its shapes are these */
soft_place *soft_place_create(world *w, uint32_t body, uint32_t collider, uint32_t shadow); /* at rest; in no list */
void soft_leave(world *w, body *b);                                                         /* its shapes go */
void soft_arrive(world *w, soft_place *p);                                                  /* at its next frame */
void soft_drop_frame(soft_frame *f);
void soft_bodies_free(world *w);
void soft_measure(soft_place *p);

/* soft_jobs.c */
void soft_go_on(world *w); /* as far as a tick's part goes: steps that are done by its end move their bodies */
void soft_forget_jobs(world *w, const soft_place *p); /* it goes: steps with it end without a result */
void soft_jobs_free(world *w);
bool soft_is_busy(const world *w);
size_t soft_waiting_of(const world *w, uint64_t owner); /* his bodies with something to do */
/* m; of the pair, for that subscription. */
soft_job *soft_job_create(world *w);                            /* among the jobs */
void soft_job_place(soft_job *j);                               /* its bodies are where its places and frames say */
soft_step_def soft_job_step(const world *w, const soft_job *j); /* of what is asked now */
void soft_take_results(soft_job *j, bool unfinished);
double soft_separation(const subscription *i, double padding);
/* Are they a pair to that subscription, and what are its terms? */
bool soft_is_wanted(const world *w, uint32_t subscription, const body *a, const body *b);

/* soft_saved.c */
void soft_save(const world *w, bytes_out *to);
const char *soft_restore(world *w, bytes_in *from); /* bodies and their colliders are there; NULL, or what is wrong */

/* soft_rigid.c */
/* The way of a soft surface beside a rigid shape on its own. */
typedef struct soft_meeting {
    soft_positions vertices;
    const soft_mesh *mesh;
    const collider *shape;
    motion way;        /* of its body, in a span of 1 */
    double separation; /* m, with the half thickness */
    uint64_t units;    /* that it may take at most, of some 10 ns */
} soft_meeting;
void soft_rigid_meet(world *w, const soft_meeting *m, soft_result *out);
void soft_rigid_pair(
    world *w, const pair *p, uint64_t decided); /* an active one of a soft and a rigid shape: its results, as asked */
void soft_rigid_proposal(world *w, soft_place *p, const soft_frame *proposal);

/* soft_results.c */
void soft_decide(world *w); /* the pairs of soft and rigid among the active ones; asks for the others */
/* Where and how each contact of two soft surfaces is. */
void soft_find_touches(soft_result *r, const soft_mesh *a, soft_positions x, const soft_mesh *b, soft_positions y);
void soft_results_clear(world *w);
void soft_results_free(world *w);
/* Is anything known of this pair in this tick? */
bool soft_is_decided(const world *w, const pair *p);
void soft_fill(const world *w, const pair *p, narrow_result *r);
bool soft_touches(const world *w, const pair *p, double separation, const soft_result **which);
void soft_tell(world *w); /* after the events */
size_t soft_told_to(const world *w, uint32_t subscription, const world_soft **at);

#endif
