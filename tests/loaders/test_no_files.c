/* What a name can lead to that is no regular file, or a huge one, for each path that is read: an error that names it,
 * at once. A FIFO that is opened for reading waits for a writer: the alarm ends the program then. */
#include "fixture.h"

#include "loaders/heights.h"
#include "loaders/mesh.h"
#include "loaders/text.h"
#include "wire/wire_log.h"

#include <fcntl.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <unistd.h>

enum { PATIENCE_S = 20 };
static const double one[3] = {1, 1, 1};
static char folder[64];
static int listening;

static const char *in_folder(const char *name)
{
    static char paths[4][128];
    static int next;
    next = (next + 1) % 4;
    snprintf(paths[next], sizeof paths[next], "%s/%s", folder, name);
    return paths[next];
}

static void write_text(const char *name, const char *text)
{
    FILE *f = fopen(in_folder(name), "w");
    assert_non_null(f);
    assert_true(fputs(text, f) >= 0);
    assert_int_equal(fclose(f), 0);
}

static void make_socket(const char *path)
{
    struct sockaddr_un at = {.sun_family = AF_UNIX};
    snprintf(at.sun_path, sizeof at.sun_path, "%s", path);
    listening = socket(AF_UNIX, SOCK_STREAM, 0);
    assert_int_equal(bind(listening, (const struct sockaddr *)&at, sizeof at), 0);
}

static int begin(void **state)
{
    (void)state;
    strcpy(folder, "/tmp/collided-no-files-XXXXXX");
    if (!mkdtemp(folder)) return -1;
    alarm(PATIENCE_S);
    make_socket(in_folder("socket"));
    int huge = open(in_folder("huge"), O_WRONLY | O_CREAT, 0600); /* with a hole: it takes no place */
    bool made = huge >= 0 && ftruncate(huge, INT64_C(3) << 30) == 0 && close(huge) == 0;
    return made && mkfifo(in_folder("fifo"), 0600) == 0 && mkdir(in_folder("sub"), 0700) == 0 ? 0 : -1;
}

static int end(void **state)
{
    (void)state;
    close(listening);
    unlink(in_folder("socket"));
    unlink(in_folder("huge"));
    unlink(in_folder("fifo"));
    unlink(in_folder("mesh.obj"));
    unlink(in_folder("mesh.gltf"));
    rmdir(in_folder("sub"));
    return rmdir(folder);
}

static const struct {
    const char *name, *words;
} CASES[] = {{"fifo", "is not a file, but a FIFO"}, {"sub", "is not a file, but a directory"},
    {"socket", "is not a file, but a socket"}, {"/dev/zero", "is not a file, but a device"},
    {"huge", "has 3221225472 bytes, more than the"}, {"none", "No such file"}};
enum { CASE_COUNT = sizeof CASES / sizeof *CASES, HUGE_CASE = 4 };

static const char *path_of(size_t i)
{
    return *CASES[i].name == '/' ? CASES[i].name : in_folder(CASES[i].name);
}

static void assert_told(const char *error, size_t i)
{
    if (!strstr(error, CASES[i].words) || !strstr(error, CASES[i].name))
        fail_msg("%s: '%s' lacks: %s", CASES[i].name, error, CASES[i].words);
}

static void meshes_heights_and_texts_are_regular_files(void **state)
{
    (void)state;
    for (size_t i = 0; i < CASE_COUNT; i++) {
        for (int way = 0; way < 3; way++) {
            fixture f;
            mesh_points m;
            heights_grid h;
            size_t size;
            fixture_begin(&f);
            if (way == 0) assert_false(mesh_load(&f.pool, path_of(i), one, &m, &f.report));
            if (way == 1) assert_false(heights_load(&f.pool, path_of(i), NULL, &h, &f.report));
            if (way == 2) assert_null(text_read_file(&f.pool, path_of(i), 1 << 20, &size, &f.report));
            assert_told(f.report.error, i);
            fixture_end(&f);
        }
    }
}

/* They are read record by record, and may have any size. */
static void recordings_are_regular_files(void **state)
{
    (void)state;
    for (size_t i = 0; i < CASE_COUNT; i++) {
        char why[512] = "";
        if (i == HUGE_CASE) continue;
        assert_null(wire_log_open(path_of(i), why, sizeof why));
        assert_told(why, i);
    }
}

/* assimp asks for the materials and the buffers that a mesh names. */
static void a_mesh_that_names_a_fifo_does_not_wait_for_it(void **state)
{
    (void)state;
    fixture f;
    mesh_points m;
    fixture_begin(&f);
    write_text("mesh.obj", "mtllib fifo\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
    if (!mesh_load(&f.pool, in_folder("mesh.obj"), one, &m, &f.report)) fail_msg("%s", f.report.error);
    assert_int_equal(m.count, 3);
    fixture_end(&f);
    write_text("mesh.gltf",
        "{\"asset\":{\"version\":\"2.0\"},\"scene\":0,\"scenes\":[{\"nodes\":[0]}],\"nodes\":[{\"mesh\":0}],"
        "\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":0}}]}],"
        "\"buffers\":[{\"uri\":\"fifo\",\"byteLength\":36}],\"bufferViews\":[{\"buffer\":0,\"byteLength\":36}],"
        "\"accessors\":[{\"bufferView\":0,\"componentType\":5126,\"count\":3,\"type\":\"VEC3\"}]}");
    fixture_begin(&f);
    assert_false(mesh_load(&f.pool, in_folder("mesh.gltf"), one, &m, &f.report));
    if (!strstr(f.report.error, "mesh.gltf: cannot be read as a mesh") || !strstr(f.report.error, "but a FIFO"))
        fail_msg("%s", f.report.error);
    fixture_end(&f);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(meshes_heights_and_texts_are_regular_files),
        cmocka_unit_test(recordings_are_regular_files),
        cmocka_unit_test(a_mesh_that_names_a_fifo_does_not_wait_for_it),
    };
    return cmocka_run_group_tests(tests, begin, end);
}
