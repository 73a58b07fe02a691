/* standby_parts: what the files of standby.h share; nobody else includes it. */
#ifndef COLLIDED_SERVICE_STANDBY_PARTS_H
#define COLLIDED_SERVICE_STANDBY_PARTS_H

#include "journal.h"
#include "service.h"
#include "state_parts.h"

/* ---- standby_mute.c: links that hear and do not speak ---- */

typedef struct kept_batch {
    struct link *link;
    size_t offset, size;
} kept_batch;

typedef struct held_message {
    struct link *link;
    size_t offset, size;
    int64_t tick; /* that the standby must have before */
} held_message;

typedef struct held_messages { /* of an active daemon, in the order of their making */
    ARRAY(held_message) list;
    size_t first; /* that is still held */
    bytes_out bytes;
} held_messages;

typedef enum mouth { MOUTH_OPEN, MOUTH_MUTED, MOUTH_HELD } mouth;

typedef struct kept_batches { /* of some time */
    int64_t began_ns;
    ARRAY(kept_batch) list;
    bytes_out bytes;
} kept_batches;

typedef struct muted_link {
    link_ops ops; /* first: the link points to it while it is muted */
    const link_ops *own;
    struct standby *owner;
} muted_link;

/* ---- standby_kept.c: what clients sent to this daemon, until the journal tells it ---- */

typedef struct kept_message {
    struct link *link;
    wire_kind kind; /* WIRE_NOTHING: the client is lost */
    int64_t client, sequence, came_ns;
    int64_t origin; /* whose it is, as its link knew it */
    size_t offset, size;
} kept_message;

typedef struct kept_reader {
    char *stream;
    struct link *link;
    int64_t came_ns;
} kept_reader;

typedef struct known_client {
    int64_t client;
    bool alive; /* our own link has heard it announce itself, and not of its end since; also while we are active */
    int64_t confirmed[WIRE_KIND_COUNT]; /* the highest sequence that the journal has told */
} known_client;

typedef struct kept {
    ARRAY(kept_message) messages;
    bytes_out bytes;
    ARRAY(kept_reader) readers;
    ARRAY(known_client) clients;
    pair_map place_of; /* client -> index */
    bool applied;      /* what is kept is being applied: it tells nothing of who lives now */
} kept;

struct standby {
    struct link *link;              /* that carries the pair */
    peer_announcement announcement; /* our own */
    int64_t began_ns, lease_ns;     /* monotonic */
    int64_t said_ns;                /* our announcement, the last time */
    int64_t round_ns;               /* of the last round */
    int64_t quiet_ns;               /* the active one stood still: it listens until then before it says anything more */
    ARRAY(peer_announcement) peers;
    int64_t seen_epoch; /* the highest of their announcements */

    int64_t active;     /* the sender that we follow; 0: nobody */
    bool in_step;       /* its state has come, and every tick since */
    int64_t asked_ns;   /* for its state */
    int64_t waiting_ns; /* the active one is lost, and another standby has precedence: since then; 0: not */
    bool out_of_step;   /* to be reset as soon as the record is done */
    bool followed;      /* the active one waits for us: only then are we sure to know all that was reported */
    int64_t missed;     /* we stood still for so long that it may wait for us no more: our question whether it does, a
                           number; 0: it does */
    bool left;          /* the active one has left in order */
    int64_t alive_ns;   /* a peer was alive then, the last time */
    int64_t ahead_ns;   /* of the active one's wall clock before our monotonic one, at its last tick */

    int64_t follower;  /* the active one: the standby that is in step, by its sender; 0: none */
    int64_t lost_ns;   /* it gives no sign of life: since then; 0: it does */
    int64_t sure_tick; /* it is sure to know all that was reported when it has this one; ... */
    bool sure;         /* ... it has */
    int64_t doubted;   /* the active one stood still: its standby then, which may have taken over since; 0: none */
    int64_t dropped;   /* one that is not waited for until it joins anew */
    int64_t alone; /* the epoch in which one that was sure was lost: it may have gone on from there, without what was
                      told since; 0: none */
    bool heir;     /* the active one: it goes on from what another one told, and nobody has said otherwise */
    bool state_wanted; /* the active one: somebody asks for its state */
    bytes_out journal; /* of the tick that is being made */
    state_parts state; /* that goes to a standby, in portions */
    size_t touched;    /* bytes of that, while it is about to be put there */
    bytes_out coming;  /* the standby: the portions that have come */
    bytes_out later;   /* ... and the ticks that have come meanwhile, each behind its size */
    wire_memory *memory;

    muted_link muted[LINKS_MAX];
    mouth mouth;
    held_messages held;
    int64_t journalled_tick;   /* the last one sent, ... */
    int64_t had_tick;          /* ... and the last one that the standby has */
    int64_t had_ns, held_tick; /* when that was so, as of the last round that held something */
    kept_batches batches[2];   /* of the lease that runs, and of the one before */
    int current;
    kept kept;
};

enum { KEPT_BATCH_BYTES = 32 << 20 };

void mute_links(service *s);         /* what is held is dropped */
void hold_links(service *s);         /* nothing goes out before the standby has the tick that it follows from */
void open_links_again(service *s);   /* what is held goes out */
void hold_release(service *s);       /* what the standby has the ticks of */
void mute_publish_again(service *s); /* the batches that were kept; the links speak again */
void mute_free(struct standby *p);

void kept_init(kept *k);
void kept_free(kept *k);
void kept_clear(kept *k);                          /* the journal has told nothing yet; what came stays */
void kept_hear(service *s, const wire_message *m); /* every message, whatever our part, before it is kept */
void kept_hear_loss(service *s, int64_t client);
void kept_message_came(service *s, struct link *from, const wire_message *m);
void kept_lost_came(service *s, struct link *from, int64_t client);
void kept_reader_came(service *s, struct link *from, const char *stream);
void kept_confirm(kept *k, const wire_message *m);
void kept_confirm_lost(kept *k, int64_t client);
void kept_confirm_reader(kept *k, const char *stream);
void kept_sweep(service *s); /* after a tick: what the journal has told goes */
void kept_bound(service *s);
/* Of readers those that came since then, and those of streams that the active one has told nothing. */
void kept_apply(service *s, const link_sink *sink, int64_t recent_ns);
bool kept_is_alive(const kept *k, int64_t client);

/* standby_announcements.c */
void announcement_say(service *s, peer_role role);                     /* our own */
peer_announcement *announcement_of(struct standby *p, int64_t sender); /* NULL: nobody has said that he is that one */
const peer_announcement *announcement_of_active(
    const struct standby *p); /* alive and of our release; of several the one that stays */
bool announcement_is_there(const struct standby *p, peer_role role); /* alive and in that role, of whatever release */
/* Another one that waits like us, and began before us. */
bool announcement_is_before_us(const struct standby *p, peer_role role);
/* Of two active ones: does the first one stay? */
bool announcement_stays(int64_t epoch, int64_t sender, int64_t other_epoch, int64_t other_sender);
int64_t announcement_new_line(const service *s);   /* the epoch of who goes on from nothing */
void announcements_forget_dead(struct standby *p); /* one that is back is told of anew */

/* standby_active.c */
/* Who gives no sign of life, or does not keep up, for so long, is waited for no more. Longer than it takes that one to
 * take over: if both lose each other at the same time, we tell nothing before it is heard of that. */
enum { SLOW_LEASES = 3 };
const peer_announcement *follower_announcement(
    const service *s);          /* in step with us: what we tell is held until it has it; or NULL */
void follower_find(service *s); /* and lose it, if it is none any more */
void follower_drop_slow(service *s);
void follower_has(service *s, int64_t sender, bytes_in *r);    /* JOURNAL_HAVE */
void follower_wishes(service *s, int64_t sender, bytes_in *r); /* JOURNAL_WANT_STATE */
void follower_state_more(service *s);                          /* each round: the next portion, if any is left */

/* standby_replay.c */
void standby_say_have(service *s, int64_t tick);
void standby_replay_tick(service *s, bytes_in *r); /* JOURNAL_TICK */
void standby_keep_tick(service *s, bytes_in *r);   /* the same, before the state has come */
void standby_take_state(service *s, bytes_in *r);  /* JOURNAL_STATE */
void follower_end_state(service *s);               /* whatever of it has not gone */
void standby_forget_state(struct standby *p);      /* what of it has come */

uint8_t standby_place_of(const service *s, const struct link *l); /* among the links of the configuration */

#endif
