/* package: package:// without ROS: a list that the user gives, then the folders around the model, then where ROS would
 * look, and at last the model's own folder, for a package that was unpacked into it. One thread a pool. */
#include "package.h"

#include "text.h"

#include <dirent.h>
#include <limits.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

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

/* A folder of ROS_PACKAGE_PATH: it holds the package, it is the package, or it holds repositories one of which does. */
static const char *look_in_sources(pool *p, const char *folder, const char *name)
{
    const char *found = pool_format(p, "%s/%s", folder, name);
    if (is_folder(found)) return found;
    const char *last = strrchr(folder, '/');
    if (strcmp(last ? last + 1 : folder, name) == 0 && is_folder(folder)) return folder;
    DIR *repositories = opendir(folder);
    if (!repositories) return NULL;
    const char *first = NULL; /* by name: readdir has no order of its own */
    for (const struct dirent *entry; (entry = readdir(repositories));) {
        if (entry->d_name[0] == '.' || (first && strcmp(entry->d_name, first) > 0)) continue;
        if (is_folder(pool_format(p, "%s/%s/%s", folder, entry->d_name, name))) first = pool_copy(p, entry->d_name);
    }
    closedir(repositories);
    return first ? pool_format(p, "%s/%s/%s", folder, first, name) : NULL;
}

/* A folder of AMENT_PREFIX_PATH. */
static const char *look_in_prefix(pool *p, const char *folder, const char *name)
{
    const char *found = pool_format(p, "%s/share/%s", folder, name);
    return is_folder(found) ? found : NULL;
}

/* The first folder of a list that an environment variable has, divided by ':', in which `look` finds it. */
static const char *look_along(
    pool *p, const char *variable, const char *name, const char *(*look)(pool *p, const char *folder, const char *name))
{
    const char *list = getenv(variable), *found = NULL;
    if (strchr(name, '/') || *name == '.') return NULL;
    for (; list && *list && !found; list += *list == ':') {
        size_t length = strcspn(list, ":");
        char *folder = pool_format(p, "%.*s", (int)length, list);
        while (length > 1 && folder[length - 1] == '/') folder[--length] = '\0';
        if (*folder) found = look(p, folder, name);
        list += strcspn(list, ":");
    }
    return found;
}

/* package://NAME/REST, where REST lies in the model's folder, or in the one above it. */
static const char *look_inside(pool *p, const char *name, const char *folder, const char *rest)
{
    if (*name == '.' || !*rest || strstr(rest, "..")) return NULL;
    const char *here = pool_format(p, "%s%s", folder, rest), *above = pool_format(p, "%s/..%s", folder, rest);
    return access(here, R_OK) == 0 ? here : access(above, R_OK) == 0 ? above : NULL;
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
    if (!path) path = look_along(p, "ROS_PACKAGE_PATH", plain, look_in_sources);
    if (!path) path = look_along(p, "AMENT_PREFIX_PATH", plain, look_in_prefix);
    if (path) return pool_format(p, "%s%s", path, name + length);
    path = look_inside(p, plain, folder, name + length);
    if (path) return path;
    load_fail(r,
        "%s: nobody said where the package '%s' is: add --package %s=FOLDER, or name its folder in ROS_PACKAGE_PATH "
        "or AMENT_PREFIX_PATH",
        where, plain, plain);
    return NULL;
}
