/* robot_cases: the queries about a robot (URDF, SRDF, joint values): distances between its own links and to a box. */
#ifndef COLLIDED_TESTS_CASES_ROBOT_CASES_H
#define COLLIDED_TESTS_CASES_ROBOT_CASES_H

#include <json-c/json.h>
#include <stdbool.h>

/* A query of the robot kind? */
bool robot_query(const char *query);

/* Runs one and prints its line. `robots` = folder with panda/ in it. */
typedef enum robot_verdict { ROBOT_HOLDS, ROBOT_WRONG, ROBOT_SKIPPED } robot_verdict;
robot_verdict robot_case(json_object *object, const char *robots);

/* The state of the SRDF in which two links touch: true if the engine says so, of these two. */
bool robot_state_touches(const char *robots, const char *state, const char *link_a, const char *link_b);

#endif
