/* verbs: one function and one file a verb. Each returns an exit status of sysexits.h, after saying what went wrong. */
#ifndef COLLIDED_COLLIDECTL_VERBS_H
#define COLLIDED_COLLIDECTL_VERBS_H

#include "ctl.h"

int verb_status(ctl *c);
int verb_top(ctl *c);
int verb_load(ctl *c);
int verb_fit(ctl *c);
int verb_remove(ctl *c);
int verb_move(ctl *c);
int verb_joints(ctl *c);
int verb_check(ctl *c);
int verb_watch(ctl *c);
int verb_query(ctl *c);
const char *verb_query_kind(size_t i); /* what can be asked, for the completion; NULL ends them */
int verb_record(ctl *c);
int verb_replay(ctl *c);
int verb_film(ctl *c);
int verb_export(ctl *c);
int verb_trade(ctl *c);
int verb_doctor(ctl *c);
int verb_forget(ctl *c);
int verb_version(ctl *c);
int verb_help(ctl *c);

#endif
