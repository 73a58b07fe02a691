/* Every case of the shared case files, static or moving, held against the engine, the oracle and the source's own
 * number.
 *
 * One line a case: expected, lo, hi, width, verdict. The folder is COLLIDED_SHARED (a CMake variable); the environment
 * variable of the same name goes before it. Absent: skipped, and said so. */
#include "case_json.h"
#include "robot_cases.h"
#include "toi_cases.h"

#include <dirent.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

typedef struct tally {
    int holds, wrong, skipped, undecided, disproved;
    double widest_exact, widest_curved; /* relative to the pair's size */
    char widest_exact_id[64], widest_curved_id[64];
} tally;

static tally total;

static const char *shared_folder(void)
{
    const char *folder = getenv("COLLIDED_SHARED");
    return folder ? folder : COLLIDED_SHARED;
}

static void note_width(const judgement *j, const char *id)
{
    double width = (j->result.hi - j->result.lo) / j->size;
    double *widest = j->exact_kind ? &total.widest_exact : &total.widest_curved;
    if (!(width > *widest)) return;
    *widest = width;
    (void)snprintf(j->exact_kind ? total.widest_exact_id : total.widest_curved_id, 64, "%s", id);
}

static void skip_case(const char *id, const char *why)
{
    printf("%-36s skipped: %s\n", id, why);
    total.skipped++;
}

static void run_pair(json_object *object, const char *id, const subject *a, const subject *b)
{
    expectation expected;
    expectation_from_json(&expected, object, a, b);
    judgement j = judge(a, b, &expected);
    double said = expected.measured ? expected.distance : (double)j.truth.lo;
    printf("%-36s %24.17g %24.17g %24.17g %9.2g  %s%s\n", id, said, j.result.lo, j.result.hi, j.result.hi - j.result.lo,
        j.fault       ? "WRONG: "
        : j.disproved ? "holds; an axis disproves the source"
        : j.undecided ? "holds, undecided"
                      : "holds",
        j.fault ? j.fault : "");
    if (j.fault)
        total.wrong++;
    else
        total.holds++;
    total.undecided += j.undecided;
    total.disproved += j.disproved;
    note_width(&j, id);
}

/* A pose with several positions and a rotation about z, then y, in degrees, is a pose for each position. */
static void run_each_position(json_object *object, const char *id, subject *a, const subject *b)
{
    json_object *poses = member(object, "poseA"), *positions = member(poses, "t_each_of");
    double degrees[2] = {0, 0};
    (void)member_numbers(poses, "rotation_zy_deg", degrees, 2);
    double z = degrees[0] * (acos(-1) / 360), y = degrees[1] * (acos(-1) / 360);
    quat q = quat_unit(quat_mul((quat){cos(z), 0, 0, sin(z)}, (quat){cos(y), 0, sin(y), 0}));
    for (size_t i = 0; i < json_object_array_length(positions); i++) {
        double t[3];
        char name[96];
        json_object *position = json_object_array_get_idx(positions, i);
        for (size_t k = 0; k < 3; k++) t[k] = json_object_get_double(json_object_array_get_idx(position, k));
        (void)snprintf(name, sizeof name, "%s/%zu", id, i);
        subject_place(a, (pose){vec(t[0], t[1], t[2]), q});
        run_pair(object, name, a, b);
    }
}

static void run_static(json_object *object, const char *id)
{
    subject a, b;
    json_object *pose_a = member(object, "poseA");
    bool several = member(pose_a, "t_each_of") != NULL;
    const char *why = subject_from_json(&a, member(object, "shapeA|A"), several ? NULL : pose_a);
    if (why) {
        skip_case(id, why);
        return;
    }
    why = subject_from_json(&b, member(object, "shapeB|B"), member(object, "poseB"));
    if (why) {
        skip_case(id, why);
    } else {
        if (several)
            run_each_position(object, id, &a, &b);
        else
            run_pair(object, id, &a, &b);
        subject_free(&b);
    }
    subject_free(&a);
}

static void run_case(json_object *object, const char *robots)
{
    const char *id = member_text(object, "id"), *query = member_text(object, "query");
    static const char *const measured[] = {"signed_distance", "static", "collide", "penetration", "distance"};
    if (toi_query(query)) {
        const char *why;
        bool right = toi_case(object, &why);
        if (why) {
            skip_case(id, why);
            return;
        }
        total.holds += right;
        total.wrong += !right;
        return;
    }
    if (robot_query(query)) {
        robot_verdict verdict = robot_case(object, robots);
        total.holds += verdict == ROBOT_HOLDS;
        total.wrong += verdict == ROBOT_WRONG;
        total.skipped += verdict == ROBOT_SKIPPED;
        return;
    }
    for (size_t i = 0; i < sizeof measured / sizeof *measured; i++)
        if (strcmp(query, measured[i]) == 0) {
            run_static(object, id);
            return;
        }
    skip_case(id, "unknown query");
}

static void run_file(const char *path, const char *robots)
{
    json_object *root = json_object_from_file(path);
    json_object *cases = member(root, "cases");
    if (!json_object_is_type(cases, json_type_array)) {
        printf("%s: no cases in it (%s)\n", path, root ? "another kind of file" : json_util_get_last_err());
        json_object_put(root);
        return;
    }
    printf("\n%s\n%-36s %24s %24s %24s %9s\n", path, "id", "expected", "lo", "hi", "width");
    for (size_t i = 0; i < json_object_array_length(cases); i++) run_case(json_object_array_get_idx(cases, i), robots);
    json_object_put(root);
}

static int is_json(const struct dirent *entry)
{
    const char *end = strrchr(entry->d_name, '.');
    return end && strcmp(end, ".json") == 0;
}

static void every_case_holds(void **state)
{
    (void)state;
    char folder[3072], robots[3072], path[4096];
    (void)snprintf(folder, sizeof folder, "%s/cases", shared_folder());
    (void)snprintf(robots, sizeof robots, "%s/robots", shared_folder());
    struct dirent **entries;
    int count = scandir(folder, &entries, is_json, alphasort);
    if (count <= 0) {
        printf("skipped: %s absent\n", folder);
        skip();
        return;
    }
    for (int i = 0; i < count; i++) {
        (void)snprintf(path, sizeof path, "%s/%s", folder, entries[i]->d_name);
        run_file(path, robots);
        free(entries[i]);
    }
    free(entries);
    printf(
        "\n%d hold (%d undecided within rounding, %d against a source that an axis disproves), %d wrong, %d skipped\n",
        total.holds, total.undecided, total.disproved, total.wrong, total.skipped);
    printf("widest interval, of the pair's size: %.2g exact kinds (%s), %.2g curved (%s)\n", total.widest_exact,
        total.widest_exact_id, total.widest_curved, total.widest_curved_id);
    assert_true(total.holds > 0);
    assert_int_equal(total.wrong, 0);
}

static void transport_state_of_the_panda_touches_itself(void **state)
{
    (void)state;
    char robots[3072];
    (void)snprintf(robots, sizeof robots, "%s/robots", shared_folder());
    DIR *folder = opendir(robots);
    if (!folder) {
        printf("skipped: %s absent\n", robots);
        skip();
        return;
    }
    (void)closedir(folder);
    assert_true(robot_state_touches(robots, "transport", "panda_link5", "panda_link7"));
    assert_false(robot_state_touches(robots, "ready", "panda_link5", "panda_link7"));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_case_holds),
        cmocka_unit_test(transport_state_of_the_panda_touches_itself),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
