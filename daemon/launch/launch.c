/* launch: the program that people call. It needs libc alone, loads the program proper, a module that lies beside it,
 * and calls its main: so when a library is missing, somebody is there to say which package brings it back. One thread.
 */
#include <dlfcn.h>
#include <limits.h>
#include <stdio.h>
#include <string.h>
#include <sysexits.h>
#include <unistd.h>

typedef int (*program)(int argc, char **argv);

/* Debian's packages; what is not here came with our own. */
static const struct {
    const char *library, *package;
} PACKAGES[] = {
    {"libddsc.so", "libddsc0debian"},
    {"liblcm.so", "liblcm1"},
    {"libccd.so", "libccd2"},
    {"libqhull_r.so", "libqhull-r8.0"},
    {"libsystemd.so", "libsystemd0"},
    {"libcrypto.so", "libssl3"},
    {"libassimp.so", "libassimp5"},
    {"libcyaml.so", "libcyaml1"},
    {"libpng16.so", "libpng16-16"},
    {"libxml2.so", "libxml2"},
};

static const char *package_of(const char *why)
{
    for (size_t i = 0; i < sizeof PACKAGES / sizeof *PACKAGES; i++)
        if (strstr(why, PACKAGES[i].library)) return PACKAGES[i].package;
    return "collided";
}

/* The module beside this program, wherever a link to it may lie. */
static int module_path(char path[PATH_MAX])
{
    ssize_t length = readlink("/proc/self/exe", path, PATH_MAX - 1);
    if (length <= 0) return -1;
    path[length] = '\0';
    char *end = strrchr(path, '/') + 1;
    int room = PATH_MAX - (int)(end - path);
    return snprintf(end, (size_t)room, "%s.so", LAUNCHED) < room ? 0 : -1;
}

int main(int argc, char **argv)
{
    char path[PATH_MAX];
    if (module_path(path) != 0) {
        fprintf(stderr, LAUNCHED ": /proc/self/exe cannot be read: mount /proc\n");
        return EX_OSFILE;
    }
    void *module = dlopen(path, RTLD_NOW);
    void *entry = module ? dlsym(module, "main") : NULL;
    if (!entry) {
        const char *why = dlerror();
        fprintf(stderr, LAUNCHED ": %s: do: apt-get install --reinstall %s\n", why ? why : path,
            package_of(why ? why : ""));
        return EX_OSFILE;
    }
    program run;
    memcpy(&run, &entry, sizeof run); /* ISO C has no cast from an object's address to a function's */
    return run(argc, argv);
}
