/* package: package:// without ROS: a list that the user gives, then the folders around the model. One thread a pool. */
#include "package.h"

#include "text.h"

#include <limits.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

static bool is_folder(const char *path)
{
    struct stat info;
    return stat(path, &info) == 0 && S_ISDIR(info.st_mode);
}

/* Up from the model's folder: is there a folder of that name, or are we inside of it? */
static const char *look_around(pool *p, const char *name, const char *folder)
{
    char whole[PATH_MAX];
    if (strchr(name, '/') || strcmp(name, "..") == 0 || strcmp(name, ".") == 0) return NULL;
    if (!realpath(folder, whole)) return NULL;
    for (;;) {
        const char *found = pool_format(p, "%s/%s", whole, name);
        if (is_folder(found)) return found;
        char *slash = strrchr(whole, '/');
        if (!slash || !*whole) return NULL;
        *slash = '\0';
    }
}

const char *package_resolve(pool *p, const char *uri, const char *folder, const load_package *packages, size_t count,
    const char *where, load_report *r)
{
    static const char package_scheme[] = "package://", file_scheme[] = "file://";
    if (strncmp(uri, file_scheme, sizeof file_scheme - 1) == 0)
        return text_beside(p, folder, uri + sizeof file_scheme - 1);
    if (strncmp(uri, package_scheme, sizeof package_scheme - 1) != 0) {
        if (!strstr(uri, "://")) return text_beside(p, folder, uri);
        load_fail(r, "%s: '%s' is neither package:// nor file:// nor a path", where, uri);
        return NULL;
    }
    const char *name = uri + sizeof package_scheme - 1;
    size_t length = strcspn(name, "/");
    const char *plain = pool_format(p, "%.*s", (int)length, name);
    const char *path = NULL;
    for (size_t i = 0; i < count && !path; i++)
        if (strcmp(packages[i].name, plain) == 0) path = packages[i].path;
    if (!path) path = look_around(p, plain, folder);
    if (path) return pool_format(p, "%s%s", path, name + length);
    load_fail(r, "%s: nobody said where the package '%s' is: add --package %s=FOLDER", where, plain, plain);
    return NULL;
}
