/* strangers: those who should not get in, each in a process of its own. */
#ifndef COLLIDED_TESTS_SECURITY_STRANGERS_H
#define COLLIDED_TESTS_SECURITY_STRANGERS_H

enum { STRANGER_MATCHED = 3, STRANGER_NO_PARTICIPANT = 4, STRANGER_NO_WRITER = 5, STRANGER_CLIENT = 0x57 };

/* Cyclone's own calls: joins the domain of RIG_DDS with that folder's security ("" = none), and writes Client, Body and
 * PoseBatch as if it were a client, a thousand times a second for `seconds`. 0: no reader was found for them;
 * STRANGER_*. */
int stranger_writes(const char *security, double seconds);

/* The same with an access-control plug-in that does not keep to the folder's permissions. */
int lawless_writes(const char *security, double seconds);

/* Reads raw packets on loopback, and for `seconds` sends forged ones under the participants' own names: claims that
 * samples are gone, that all has come, false data, copies of what was seen, and copies with bits turned. 0: it saw and
 * sent some. */
int forger_runs(double seconds);

#endif
