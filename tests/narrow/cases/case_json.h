/* case_json: shapes, poses and expectations of the JSON case files, in any of the conventions that the files use.
 *
 * Sizes: `size` and `length` are full, `half` and `half_len` are half; radii are `radius` or `r`. Poses: `R`
 * (row-major) and `t`, or `q_wxyz` and `p`. What cannot be run yet is no failure: the reason is told. */
#ifndef COLLIDED_TESTS_CASES_CASE_JSON_H
#define COLLIDED_TESTS_CASES_CASE_JSON_H

#include "judge.h"

#include <json-c/json.h>

/* Member by any of the names in `names`, separated by '|'; NULL if none is there. */
json_object *member(json_object *object, const char *names);
bool member_number(json_object *object, const char *names, double *out);
bool member_numbers(json_object *object, const char *names, double *out, size_t count); /* exactly count */
const char *member_text(json_object *object, const char *names);                        /* "" if none */

/* NULL, or why there is no such subject; then nothing needs freeing. */
const char *subject_from_json(subject *s, json_object *shape, json_object *pose);

/* The tolerance is the case's `tol_rel` of the smaller body's size, or follows from how the truth was found. */
void expectation_from_json(expectation *e, json_object *object, const subject *a, const subject *b);

#endif
