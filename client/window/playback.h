/* playback: a recording as if its daemon ran: starts 'collided --replay FILE' as a child, which is told when to go on,
 * and which a client connects to by the URI of this playback (daemon/service/replay_served.h has the commands). One
 * thread. */
#ifndef COLLIDED_WINDOW_PLAYBACK_H
#define COLLIDED_WINDOW_PLAYBACK_H

#include <stdbool.h>
#include <stdint.h>
#include <sys/types.h>

typedef enum playback_state { PLAYBACK_PAUSED, PLAYBACK_PLAYING, PLAYBACK_SEEKING, PLAYBACK_ENDED } playback_state;

enum { PLAYBACK_PROGRAM_MAX = 4096 };

typedef struct playback {
    pid_t child;
    int commands, answers; /* -1: closed */
    char uri[48];          /* pipe://A,B */
    int pipe[2];           /* A and B; -1: a client owns them */
    char line[512];
    unsigned line_size;
    bool known;                      /* what follows is */
    int64_t begin_ns, end_ns, ticks; /* of the recording */
    char damaged[256];               /* "" = it is whole */
    int64_t at_ns, tick;
    playback_state state;
    double speed;
    unsigned sent, done; /* commands that were given, and carried out */
    bool gone;           /* the child has ended, or says what nobody understands */
} playback;

/* The program collided: beside the program that runs, or else as PATH has it. */
void playback_program(char program[PLAYBACK_PROGRAM_MAX]);

/* `daemon`: the program collided. Waits until the recording has been looked through: the child says on standard error
 * what is wrong with it. False: it has ended (playback_close tells how), or `why` says what failed here. */
bool playback_open(playback *p, const char *daemon, const char *file, long workers, char *why, size_t why_size);

/* For collided_connect, once; the client closes what it stands for. */
const char *playback_take_uri(playback *p);

void playback_play(playback *p, double speed); /* 0: as fast as what it tells is read */
void playback_step(playback *p);               /* one tick; then it pauses */
void playback_pause(playback *p);
void playback_seek(playback *p, int64_t ns); /* forward, as fast as possible; then it pauses */
void playback_poll(playback *p);             /* takes what the child has said; never waits */
bool playback_rests(const playback *p);      /* all commands are carried out, and it is paused or at its end */

/* The child's exit status; 128 + N: signal N ended it. */
int playback_close(playback *p);

#endif
