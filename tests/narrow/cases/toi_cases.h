/* toi_cases: the shared cases about what moves: when it first touches. */
#ifndef COLLIDED_TESTS_CASES_TOI_CASES_H
#define COLLIDED_TESTS_CASES_TOI_CASES_H

#include <json-c/json.h>
#include <stdbool.h>

/* A query for a time: of rigid bodies, or of a vertex and a face, or two edges, that move along lines? */
bool toi_query(const char *query);

/* Runs one and prints its line; false = wrong. *skipped: why it could not be run, or NULL. */
bool toi_case(json_object *object, const char **skipped);

#endif
