/* fake: a transport whose other end is the test. What the client sends is kept in order; what the test gives is
 * received by the client. One client at a time. Any thread. */
#ifndef COLLIDED_TESTS_CLIENT_FAKE_H
#define COLLIDED_TESTS_CLIENT_FAKE_H

#include "session.h"

/* Of a daemon that was started later: those that lie closer are of one line (wire_same_line). */
enum { A_LATER_EPOCH = 2 << WIRE_LINE_BITS };

/* For what must come, in seconds, on a machine that has ten other things to do. */
#define FAKE_PATIENCE_S 30.0

typedef struct fake_options {
    bool repeats;      /* as LCM does */
    bool deaf;         /* acknowledges nothing */
    wire_kind ignored; /* not acknowledged */
    int64_t epoch;
} fake_options;

void fake_begin(fake_options options); /* forgets everything */
void fake_set(fake_options options);   /* from here on */
collided *fake_connect(void);          /* with a lease of an hour: no heartbeats; fails the test if it cannot */
collided *fake_try(const collided_def *def, char *why, size_t why_size);

size_t fake_sent(wire_kind kind);
/* The n-th message of that kind, from 0; waits for it, then fails the test. Valid until fake_begin. */
const wire_message *fake_message(wire_kind kind, size_t n);
size_t fake_position(const wire_message *m); /* among everything that was sent */
void fake_pause(int ms);
void fake_settle(void); /* until the keeper has taken what was given; what streams are given, the caller takes */

void fake_give(const wire_message *m);
void fake_ack(const wire_message *sent); /* in the present epoch */
void fake_reject(const wire_message *sent, wire_reason reason, const char *text);
void fake_status(int64_t epoch);
void fake_end(int64_t epoch); /* a Status by which the daemon of that epoch ends */

#endif
