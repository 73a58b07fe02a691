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
    aabb box;               /* of them */
    int64_t frame, stamp_ns;
    bool teleports;
} soft_frame;

#define SOFT_CONTACTS_MOST ((size_t)1 << 17) /* kept of a step, and told; others are counted */

enum { SOFT_PROPOSALS_MAX = 8 }; /* of one body that wait */

typedef struct soft_place { /* of one body */
    uint32_t body, collider, shadow;
    const soft_mesh *mesh;
    size_t count; /* vertices */
    double half_thickness;
    vec3 span[2];           /* about its last way, and its half thickness; the shape's */
    vec3 *from, *at;        /* its last way: from where it was to where it is; ... */
    aabb box;               /* ... of `at` alone */
    int64_t frame;          /* that it is at; 0: as it was announced */
    uint64_t way_tick;      /* the tick in which it went that way; in others it stands */
    soft_frame next, after; /* that waits, or is under way; that has come since */
    soft_frame proposals[SOFT_PROPOSALS_MAX];
    size_t proposal_count;
    soft_body *engine;
    bool under_way;          /* a step with it is */
    bool asked;              /* how it stands is to be found out */
    bool untold;             /* of its last step somebody has not been told yet: the next one waits for that */
    struct soft_job *beside; /* that finds out what rigid shapes its last way, or the place where it stands, meets: it
                                does not go on before this is done */
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
    uint64_t hash;          /* of its contacts */
    uint32_t next_told;     /* the first subscription that has not been told yet; ... */
    uint32_t older;         /* another one of the same pair + 1; 0: there is none */
    bool only_told;         /* ... it waits for nothing else: its pair may have another one by now */
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

typedef enum soft_stage { /* of a job, in this order; from one ask to the next it steps again */
    SOFT_PLACING,         /* the engine's bodies are where its places and frames say */
    SOFT_ASKING,          /* which pairs are asked about, for whom */
    SOFT_STEPPING,        /* what is asked now is found out */
    SOFT_TAKING,          /* and taken */
    SOFT_BESIDE,          /* pairs with rigid shapes are */
    SOFT_DONE
} soft_stage;

typedef struct soft_beside { /* a pair of the job's first place and a rigid shape */
    uint32_t rigid;          /* collider; WORLD_NONE: it has gone */
    motion way;              /* of its body, in a span of 1 */
    double separation;       /* m, beyond the half thickness */
    size_t most;             /* contacts that are kept */
    bool goes;               /* the surface goes its last way; else it stands */
    bool is_late;            /* not all of the ways since the last time are known */
} soft_beside;

typedef struct soft_job {
    ARRAY(soft_place *) places;
    ARRAY(uint8_t) acts;       /* by place: it goes, or is asked about. Empty: a proposal, or of rigid shapes alone */
    ARRAY(soft_body *) bodies; /* of the engine, by place */
    ARRAY(soft_asked) asks;
    soft_stage stage;
    size_t placed, asking, ask; /* that is under way */
    bool begun, proposed;
    bool unfinished, broken; /* the ask; the whole, which the engine refuses */
    bool stands;             /* it is about rigid shapes alone: nobody arrives at its end; ... */
    bool fresh;              /* ... and its pairs are looked at in this tick */
    bool gathered;           /* what its proposal is held against is known */
    ARRAY(soft_beside) besides;
    size_t beside;          /* that is under way, with: */
    struct soft_task *task; /* NULL: not begun */
    soft_frame proposal;
    soft_body *proposed_body; /* owned */
    soft_step *step;
    uint64_t units, units_before, portions; /* before it began to step; since then */
    ARRAY(soft_result) results;
} soft_job;

typedef struct soft_account { /* of an owner who has jobs */
    uint64_t owner, units;
} soft_account;

typedef struct soft_told {
    uint32_t subscription;
    world_soft what;
} soft_told;

struct soft_world {
    ARRAY(soft_place *) places; /* body.soft - 1 is the index; NULL: free */
    ARRAY(soft_job *) jobs;     /* under way */
    ARRAY(soft_account) accounts;
    uint64_t clear_tick;                        /* the last at whose end nothing had been put off */
    pair_map result_of;                         /* key of a pair -> its newest result, until they are told */
    bool indexed;                               /* something is in there */
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
aabb soft_box_of(const vec3 *at, size_t count);

/* soft_jobs.c */
void soft_go_on(world *w);     /* as far as a tick's part goes: steps that are done by its end move their bodies */
void soft_go_beside(world *w); /* the same, when its pairs are known */
void soft_forget_jobs(world *w, const soft_place *p); /* it goes: steps with it end without a result */
void soft_jobs_free(world *w);
bool soft_is_busy(const world *w);
size_t soft_waiting_of(const world *w, uint64_t owner);        /* his bodies with something to do */
soft_job *soft_job_create(world *w);                           /* among the jobs */
void soft_job_place(soft_job *j, uint32_t i);                  /* its body is where its place and frame say */
uint64_t soft_job_portion(world *w, soft_job *j);              /* the next one; in units of soft_step_run */
size_t soft_most_of(const subscription *i);                    /* features of a pair that it is told */
double soft_separation(const subscription *i, double padding); /* m; of the pair, for that subscription */
/* Are they a pair to that subscription, and what are its terms? */
bool soft_is_wanted(const world *w, uint32_t subscription, const body *a, const body *b);

/* soft_saved.c */
void soft_save(const world *w, bytes_out *to);
const char *soft_restore(world *w, bytes_in *from); /* bodies and their colliders are there; NULL, or what is wrong */

/* soft_rigid.c: pairs of a soft and a rigid shape */
void soft_rigid_ask(world *w, const pair *p, uint64_t since); /* an active one: on its way since that tick */
void soft_rigid_gather(world *w, soft_job *j);                /* what its proposal may meet, as that stands */
uint64_t soft_rigid_portion(world *w, soft_job *j, bool give_up);
void soft_rigid_drop(struct soft_task *t);
void soft_rigid_forget(world *w, uint32_t collider); /* it goes */

/* soft_results.c */
void soft_decide(world *w); /* the pairs of soft and rigid among the active ones; asks for the others */
/* Where and how each contact of two soft surfaces is. */
void soft_find_touches(soft_result *r, const soft_mesh *a, soft_positions x, const soft_mesh *b, soft_positions y);
void soft_result_hash(soft_result *r);
void soft_result_add(world *w, const soft_result *r); /* takes its arrays */
void soft_results_clear(world *w);
void soft_results_free(world *w);
/* Is anything known of this pair in this tick? */
bool soft_is_decided(const world *w, const pair *p);
void soft_fill(const world *w, const pair *p, narrow_result *r);
bool soft_touches(const world *w, const pair *p, double separation, const soft_result **which);
void soft_tell(world *w); /* after the events */
size_t soft_told_to(const world *w, uint32_t subscription, const world_soft **at);

#endif
