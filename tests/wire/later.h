/* later: what collided_later says and reads that this release does not know. */
#ifndef COLLIDED_TESTS_WIRE_LATER_H
#define COLLIDED_TESTS_WIRE_LATER_H

enum { LATER_OUT = 7, LATER_POSE = 8, LATER_REQUIRED = 9, LATER_NOBODYS = 10 }; /* ids of extensions */
#define LATER_POSE_TEXT "8"
enum { LATER_KIND = 42, LATER_CAUSE = 43, LATER_ACHIEVED = 44, LATER_HEALTH = 45 };

#endif
