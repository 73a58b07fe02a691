/* store_file: the store as one text file, $XDG_STATE_HOME/collidectl/AS (else ~/.local/state/...), replaced as a whole
 * by store_save; one run at a time holds it. */
#ifndef COLLIDED_COLLIDECTL_STORE_FILE_H
#define COLLIDED_COLLIDECTL_STORE_FILE_H

#include "store.h"

/* Reads the file, if there is one, and locks it. 0, or an exit status after saying why not. */
int store_open(store *s, ctl *c);
int store_save(store *s);
void store_close(store *s);

#endif
