/* fixture: what the tests of the loaders share: parsing from strings, and expecting an error that says certain words.
 */
#ifndef COLLIDED_TESTS_LOADERS_FIXTURE_H
#define COLLIDED_TESTS_LOADERS_FIXTURE_H

#include <setjmp.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "loaders/robot.h"
#include "loaders/scene.h"

typedef struct fixture {
    pool pool;
    load_report report;
    char warning[1024]; /* the last one */
} fixture;

void fixture_begin(fixture *f);
void fixture_end(fixture *f);
bool fixture_urdf(fixture *f, const char *text, urdf *out);   /* as "test.urdf" */
bool fixture_scene(fixture *f, const char *text, scene *out); /* as "test.yaml" */

/* The text is refused, in one line that has `words` in it. */
void urdf_is_refused(const char *text, const char *words);
void scene_is_refused(const char *text, const char *words);

/* The panda of the shared folder; false, and a printed reason, if it is not there. */
bool fixture_panda(fixture *f, robot *out);

#endif
