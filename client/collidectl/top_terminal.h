/* top_terminal: a screen of its own on the terminal that standard output is, given back as it was: at the end, when the
 * process is stopped (Ctrl-Z), and after SIGINT, SIGTERM, SIGHUP and SIGQUIT, which only set a flag. One a process. */
#ifndef COLLIDED_COLLIDECTL_TOP_TERMINAL_H
#define COLLIDED_COLLIDECTL_TOP_TERMINAL_H

#include <stdbool.h>
#include <stddef.h>

bool top_terminal_is_there(void); /* standard output is a terminal that moves its cursor */
void top_terminal_enter(void);
void top_terminal_leave(void);
void top_terminal_size(size_t *columns, size_t *rows);
void top_terminal_show(const char *page); /* instead of what is on it, without a flicker */

/* After top_terminal_catch_signals: one of the signals above, or the key q, has come. */
void top_terminal_catch_signals(void);
bool top_terminal_ended(void);
bool top_terminal_paused(void); /* stops, if Ctrl-Z asked for it; true: it did, and goes on: draw anew */

#endif
