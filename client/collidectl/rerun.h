/* rerun: a recording replayed by 'collided --replay', with one more client, who observes all bodies and subscribes to
 * all pairs: what verbs make files of. The replay goes on in steps of half a recorded second, between which the numbers
 * of new geometries are asked for: so the same recording always tells the same. One thread. */
#ifndef COLLIDED_COLLIDECTL_RERUN_H
#define COLLIDED_COLLIDECTL_RERUN_H

#include "ctl.h"

#include "window/mirror.h"
#include "window/playback.h"

typedef struct rerun {
    ctl *c;
    const char *verb; /* for what is said */
    playback replay;
    mirror *mirror;
    uint32_t asked;    /* geometries below this have been asked for */
    int64_t period_ns; /* of --rate */
    bool begun;        /* before, nobody is told: all geometries come first */
    void *context;
    void (*geometry)(void *context, uint32_t number, const collided_geometry_numbers *numbers);
    void (*news)(void *context, int64_t stamp_ns, bool now); /* the mirror has changed; now: nothing is to be put off */
    void (*events)(void *context);                           /* take the mirror's events now: more come */
} rerun;

/* c, verb, context and functions are set. Each: 0, or an exit status after saying why not. */
int rerun_open(rerun *r); /* starts the replay; it stands at the first tick */
int rerun_run(rerun *r);  /* connects, and tells all of it */
void rerun_close(rerun *r);
int rerun_damage(const rerun *r); /* of the recording, which is told; 0: it is whole */

#endif
