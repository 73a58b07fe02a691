/* trade: one recording replayed at every accuracy side by side, tick by tick: what each costs, how far its answers are
 * from the truth, and what its subscribers would have been told. */
#ifndef COLLIDED_TRADE_TRADE_H
#define COLLIDED_TRADE_TRADE_H

#include "service/config.h"

/* Replays c->replay, whose file start_check has found. Prints report.h's lines to standard output, reasons to standard
 * error. EX_OK, EX_DATAERR (no recording, damaged, or nothing to compare in it), EX_IOERR. */
int trade_run(const config *c);

#endif
