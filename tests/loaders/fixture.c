/* fixture: parsing from strings for the tests of the loaders. */
#include "fixture.h"

#include <stdio.h>
#include <string.h>
#include <unistd.h>

static void keep_warning(void *context, const char *text)
{
    fixture *f = context;
    snprintf(f->warning, sizeof f->warning, "%s", text);
}

void fixture_begin(fixture *f)
{
    *f = (fixture){0};
    f->report.warn = keep_warning;
    f->report.context = f;
}

void fixture_end(fixture *f)
{
    pool_free(&f->pool);
}

bool fixture_urdf(fixture *f, const char *text, urdf *out)
{
    return urdf_parse(out, &f->pool, text, strlen(text), "test.urdf", &f->report);
}

bool fixture_scene(fixture *f, const char *text, scene *out)
{
    return scene_parse(out, &f->pool, text, strlen(text), "test.yaml", &f->report);
}

static void check_refusal(const fixture *f, bool accepted, const char *words)
{
    if (accepted) fail_msg("accepted, instead of an error with: %s", words);
    if (!strstr(f->report.error, words)) fail_msg("the error '%s' lacks: %s", f->report.error, words);
    assert_null(strchr(f->report.error, '\n'));
}

void urdf_is_refused(const char *text, const char *words)
{
    fixture f;
    urdf u;
    fixture_begin(&f);
    bool accepted = fixture_urdf(&f, text, &u);
    check_refusal(&f, accepted, words);
    fixture_end(&f);
}

void scene_is_refused(const char *text, const char *words)
{
    fixture f;
    scene s;
    fixture_begin(&f);
    bool accepted = fixture_scene(&f, text, &s);
    check_refusal(&f, accepted, words);
    fixture_end(&f);
}

bool fixture_panda(fixture *f, robot *out)
{
    static const load_package package = {
        "moveit_resources_panda_description", LOADERS_SHARED "/robots/panda/panda_description"};
    static const robot_source source = {.urdf = LOADERS_SHARED "/robots/panda/panda_description/urdf/panda.urdf",
        .srdf = LOADERS_SHARED "/robots/panda/panda_moveit_config/config/panda.srdf",
        .packages = &package,
        .package_count = 1};
    if (access(source.urdf, R_OK) != 0) {
        print_message("skipped: %s is not there (COLLIDED_SHARED)\n", source.urdf);
        return false;
    }
    if (!robot_load(out, &f->pool, &source, &f->report)) fail_msg("%s", f->report.error);
    return true;
}
