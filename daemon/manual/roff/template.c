/* template: see template.h. */
#include "template.h"

#include <errno.h>
#include <stdlib.h>
#include <string.h>

static int fail(const char *path, const char *what)
{
    fprintf(stderr, "%s: %s\n", path, what);
    return -1;
}

static int write_section(FILE *out, const char *name, const char *from, const template_section *sections)
{
    for (const template_section *s = sections; s->name; s++) {
        if (strcmp(s->name, name) != 0) continue;
        s->write(out);
        return 0;
    }
    fprintf(stderr, "%s: no table is called \"%s\"\n", from, name);
    return -1;
}

static int fill(FILE *in, FILE *out, const char *from, const template_section *sections)
{
    static const char mark[] = " TABLE ";
    char *line = NULL;
    size_t room = 0;
    int failed = 0;
    while (!failed && getline(&line, &room, in) >= 0) {
        char *name = strstr(line, mark);
        if (name) {
            name[strcspn(name, "\n")] = '\0';
            failed = write_section(out, name + strlen(mark), from, sections);
        } else {
            fputs(line, out);
        }
    }
    free(line);
    return failed;
}

int template_write(const char *from, const char *to, const template_section *sections)
{
    FILE *in = fopen(from, "r");
    if (!in) return fail(from, strerror(errno));
    FILE *out = fopen(to, "w");
    if (!out) {
        fclose(in);
        return fail(to, strerror(errno));
    }
    int failed = fill(in, out, from, sections);
    if (ferror(in)) failed = fail(from, "cannot be read");
    fclose(in);
    if (fclose(out) != 0) failed = fail(to, "cannot be written");
    return failed;
}
