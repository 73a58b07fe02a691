/* mesh_import: assimp, which sees the file system only through us. One thread. */
#ifndef COLLIDED_LOADERS_MESH_IMPORT_H
#define COLLIDED_LOADERS_MESH_IMPORT_H

#include "report.h"

#include <assimp/scene.h>
#include <stddef.h>

enum { MESH_FILE_MAX = 64 << 20 }; /* bytes */

/* The bytes of the file `path`, decoded; `steps` are assimp's aiProcess_ flags. Other files that it names (the buffers
 * of a glTF, materials) are read, too, if they are regular ones of at most MESH_FILE_MAX bytes; the others are as if
 * they were not there. NULL, and the report; otherwise aiReleaseImport frees it. */
const struct aiScene *mesh_import(const char *path, const char *data, size_t size, unsigned steps, load_report *r);

#endif
