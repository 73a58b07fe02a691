/* package: where the files are that a model names. Pure but for looking whether a folder is there. */
#ifndef COLLIDED_LOADERS_PACKAGE_H
#define COLLIDED_LOADERS_PACKAGE_H

#include "pool.h"
#include "report.h"

#include <stddef.h>

typedef struct load_package { /* package://name/... is path/... */
    const char *name, *path;
} load_package;

/* The path of `uri`: package://NAME/REST by the list, else by the nearest folder called NAME that lies beside or above
 * `folder` (the model's own), else by ROS_PACKAGE_PATH and AMENT_PREFIX_PATH as they are in the environment, else REST
 * in `folder` or the one above it; file:///PATH; a plain path, relative to `folder`. NULL, and the report, when it
 * cannot be told. `where` is put in front of the message. */
const char *package_resolve(pool *p, const char *uri, const char *folder, const load_package *packages, size_t count,
    const char *where, load_report *r);

#endif
