/* toi_cases: the shared cases about moving bodies: when they first touch. */
#ifndef COLLIDED_TESTS_CASES_TOI_CASES_H
#define COLLIDED_TESTS_CASES_TOI_CASES_H

#include <json-c/json.h>
#include <stdbool.h>

/* A query for a time? */
bool toi_query(const char *query);

/* Runs one and prints its line; false = wrong. *skipped: why it could not be run, or NULL. */
bool toi_case(json_object *object, const char **skipped);

#endif
