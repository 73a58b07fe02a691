/* example: what the examples share and what is no part of their lesson: options, the clock, the end by signal, and
 * lines of output. One thread; the signal handler only sets a flag. */
#ifndef COLLIDED_EXAMPLES_EXAMPLE_H
#define COLLIDED_EXAMPLES_EXAMPLE_H

#include "collided.h"

typedef struct example {
    const char *program;
    const char *connect;   /* URI of the daemon */
    const char *interface; /* as in collided_def */
    const char *link;      /* "dds" or "lcm" */
    bool json;             /* print one object a line */
    int64_t end_ns;        /* of example_now_ns; INT64_MAX = until a signal */
} example;

/* Reads [--connect URI] [--interface NAME] [--seconds N] [--json], and catches SIGINT and SIGTERM. Wrong options end
 * the program. */
example example_start(int argc, char **argv);

/* A client whose rejections are printed to stderr; `def` as in collided_connect. NULL, and a message that tells what to
 * do, if there is no daemon. */
collided *example_connect(const example *e, const collided_def *def);

/* Prints why a call failed, unless it did not: for `if (!example_ok(c, collided_...(c, ...), "...")) ...`. */
bool example_ok(const collided *c, collided_status status, const char *what);

bool example_running(const example *e);
int64_t example_now_ns(void); /* monotonic */

/* Polls, so that callbacks run, until `when_ns`. COLLIDED_NO_DAEMON when none is heard any more. */
collided_status example_poll_until(collided *c, int64_t when_ns);

/* One line: the wall clock, what happened, between whom, how far apart (lo <= distance <= hi, m), and how old the poses
 * were on which that rests. Written at once, so that lines of several processes into one pipe stay whole. */
void example_line(
    const example *e, const char *event, const char *a, const char *b, double lo, double hi, double age_s);

/* For people only: nothing with --json. */
__attribute__((format(printf, 2, 3))) void example_note(const example *e, const char *format, ...);

/* The arm stops so that it stands before the vehicle may be nearer than the first, and goes on when it is certainly
 * farther than the second. */
extern const double EXAMPLE_PROTECTIVE_M, EXAMPLE_RESUME_M;
/* The separation that is left when the arm stands, should the two go on approaching as they do: what is certain now
 * (lo), less the way that they make together while the poses age, until the next period acts on them, and while the arm
 * brakes. m; -infinity if the pair is unknown. Not safety-rated: it trusts the velocities that were published. */
double example_separation_left(const collided_event *e);
extern const double EXAMPLE_PERIOD_S,
    EXAMPLE_BRAKING_S;                   /* of the arm: its control, and from full speed to standstill */
extern const double EXAMPLE_WORKPIECE_M; /* its height */

/* What the cell's bodies but the arm are made of, for who creates them and for who draws them: writes the shapes of the
 * named body, returns how many; 0 = not one of these. The wedge is a hull of EXAMPLE_WEDGE; its geometry is left 0. */
enum { EXAMPLE_SHAPES = 5, EXAMPLE_WEDGE_POINTS = 6 };
extern const double EXAMPLE_WEDGE[3 * EXAMPLE_WEDGE_POINTS];
size_t example_shapes(const char *body, collided_shape shapes[EXAMPLE_SHAPES]);

/* For lines of other kinds: a string in quotes, escaped; a number, null if it is not finite. */
void example_json_text(const char *text);
void example_json_number(double value);

#endif
