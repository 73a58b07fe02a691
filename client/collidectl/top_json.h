/* top_json: what top shows, for programs. */
#ifndef COLLIDED_COLLIDECTL_TOP_JSON_H
#define COLLIDED_COLLIDECTL_TOP_JSON_H

#include "top_sample.h"

/* One object, one line, to standard output. Rates are between the last two Status. */
void top_json(const top_sample *s, double unheard_s);

#endif
