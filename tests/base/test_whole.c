/* Asserts: that the builds which promise them have them (COLLIDED_ASSERTS of the preset), that a broken structure ends
 * such a build with a text that names it, and that other builds do not even ask. */
#include "base/whole.h"
#include "cmocka_c.h"

#include <signal.h>
#include <string.h>
#include <sys/wait.h>
#include <unistd.h>

static int asked;

static const char *find_fault(const char *fault)
{
    asked++;
    return fault;
}

static void asserts_are_there_where_the_preset_has_them(void **state)
{
    (void)state;
    ASSERT_WHOLE(true, find_fault(NULL));
    ASSERT_WHOLE(false, find_fault("not asked"));
#ifdef NDEBUG
    assert_false(COLLIDED_ASSERTS);
    assert_int_equal(asked, 0);
#else
    assert_int_equal(asked, 1);
#endif
}

static void what_is_broken_ends_the_process_by_name(void **state)
{
    (void)state;
    char text[512] = "";
    int ends[2], status;
    assert_int_equal(pipe(ends), 0);
    pid_t pid = fork();
    if (pid == 0) {
        signal(SIGABRT, SIG_DFL);
        dup2(ends[1], STDERR_FILENO);
        whole_holds("a leaf was lost", "tree_validate(t)", "tree.c", 7);
        _exit(0);
    }
    close(ends[1]);
    assert_true(read(ends[0], text, sizeof text - 1) > 0);
    close(ends[0]);
    assert_int_equal(waitpid(pid, &status, 0), pid);
    assert_true(WIFSIGNALED(status) && WTERMSIG(status) == SIGABRT);
    assert_non_null(strstr(text, "tree.c:7: assertion failed: tree_validate(t): a leaf was lost"));
}

/* What is spent on walks a phase stays within a bound, however large the structure is. */
static void walks_are_the_rarer_the_longer_they_take(void **state)
{
    (void)state;
    for (uint64_t phase = 0; phase < 16; phase++) assert_true(whole_is_due(phase, 100));
    for (size_t size = 100; size <= 50000; size += 1237) {
        uint64_t walks = 0;
        for (uint64_t phase = 16; phase < 100016; phase++) walks += whole_is_due(phase, size);
        assert_true(walks > 0 && walks * size <= 100000 * 50 + size);
    }
    for (uint64_t phase = 0; phase < 5000; phase++) assert_false(whole_is_due(phase, 50001));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(asserts_are_there_where_the_preset_has_them),
        cmocka_unit_test(what_is_broken_ends_the_process_by_name),
        cmocka_unit_test(walks_are_the_rarer_the_longer_they_take),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
