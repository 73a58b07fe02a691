/* run: fork, exec, and both outputs through files, so that no pipe can fill up. */
#include "run.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/wait.h>
#include <unistd.h>

enum { WORDS_MAX = 32 };
static char folder[] = "/tmp/collidectl-test-XXXXXX";

int run_make_state(void **state)
{
    (void)state;
    memcpy(strrchr(folder, '-'), "-XXXXXX", sizeof "-XXXXXX");
    if (!mkdtemp(folder)) return -1;
    unsetenv("COLLIDED_URI");
    return setenv("XDG_STATE_HOME", folder, 1);
}

int run_remove_state(void **state)
{
    (void)state;
    char command[64];
    snprintf(command, sizeof command, "rm -rf '%s'", folder);
    return system(command); /* NOLINT(cert-env33-c): the folder is our own */
}

static void take(FILE *file, char *text, size_t size)
{
    rewind(file);
    text[fread(text, 1, size - 1, file)] = '\0';
    fclose(file);
}

void run_program(const char *program, const char *arguments, run *result)
{
    char words[1024], *argv[WORDS_MAX] = {(char *)program}, *rest = words;
    assert_true(strlen(arguments) < sizeof words);
    snprintf(words, sizeof words, "%s", arguments);
    for (int i = 1; i < WORDS_MAX - 1 && (argv[i] = strtok_r(rest, " ", &rest)); i++) {
    }
    FILE *out = tmpfile(), *err = tmpfile();
    assert_true(out && err);
    pid_t child = fork();
    assert_true(child >= 0);
    if (child == 0) {
        dup2(fileno(out), STDOUT_FILENO);
        dup2(fileno(err), STDERR_FILENO);
        execv(program, argv);
        _exit(127);
    }
    int status;
    assert_int_equal(waitpid(child, &status, 0), child);
    result->status = WIFEXITED(status) ? WEXITSTATUS(status) : -1;
    take(out, result->out, sizeof result->out);
    take(err, result->err, sizeof result->err);
}

void expect_failure(const char *program, const char *arguments, int status, const char *words)
{
    static run r;
    run_program(program, arguments, &r);
    const char *newline = strchr(r.err, '\n');
    if (r.status != status) fail_msg("'%s': status %d, not %d: %s", arguments, r.status, status, r.err);
    if (!strstr(r.err, words)) fail_msg("'%s': '%s' lacks: %s", arguments, r.err, words);
    if (!newline || newline[1]) fail_msg("'%s': not one line: %s", arguments, r.err);
}
