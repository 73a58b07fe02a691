/* secret: a number that is drawn when the process begins, and that nobody outside can know. Tables whose keys clients
 * choose are ordered by it, so that nobody can choose keys that clash. It must decide nothing that is reported,
 * recorded or compared: another process has another one. Any thread. */
#ifndef COLLIDED_BASE_SECRET_H
#define COLLIDED_BASE_SECRET_H

#include <stdint.h>

uint64_t secret(void); /* never 0; always the same in this process */

#endif
