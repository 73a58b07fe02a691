/* text: files and numbers as text. Numbers go through strtod in the "C" locale, whatever the program's own is. */
#include "text.h"

#include "wire/wire_file.h"

#include <errno.h>
#include <locale.h>
#include <math.h>
#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { NAME_MAX_BYTES = 127 /* WIRE_NAME_MAX */, NUMBER_MAX_BYTES = 63 };

static locale_t c_locale;
static void make_c_locale(void)
{
    c_locale = newlocale(LC_ALL_MASK, "C", (locale_t)0);
}

static char *read_whole_file(pool *p, FILE *file, const char *path, size_t *size, load_report *r)
{
    char *data = pool_alloc(p, 1, *size + 1);
    *size = fread(data, 1, *size, file);
    if (ferror(file)) {
        load_fail(r, "%s: %s", path, strerror(errno));
        return NULL;
    }
    return data;
}

char *text_read_file(pool *p, const char *path, size_t most, size_t *size, load_report *r)
{
    char fault[256];
    uint64_t bytes;
    FILE *file = wire_file_open(path, most, &bytes, fault, sizeof fault);
    if (!file) {
        load_fail(r, "%s: %s", path, fault);
        return NULL;
    }
    *size = (size_t)bytes;
    char *data = read_whole_file(p, file, path, size, r);
    fclose(file);
    return data;
}

bool text_number(const char *text, double *out)
{
    static pthread_once_t once = PTHREAD_ONCE_INIT;
    pthread_once(&once, make_c_locale);
    /* strtod also takes "nan", "infinity" and hexadecimal: none of them is a number of a model */
    if (!*text || text[strspn(text, "+-.0123456789eE")]) return false;
    char *end;
    double value = c_locale ? strtod_l(text, &end, c_locale) : strtod(text, &end);
    if (end == text || *end || !isfinite(value)) return false;
    *out = value;
    return true;
}

int text_numbers(const char *text, const char *dividers, double *out, int most)
{
    int count = 0;
    for (text += strspn(text, dividers); *text; text += strspn(text, dividers)) {
        char word[NUMBER_MAX_BYTES + 1];
        size_t length = strcspn(text, dividers);
        if (length > NUMBER_MAX_BYTES) return -1;
        memcpy(word, text, length);
        word[length] = '\0';
        double value;
        if (!text_number(word, &value)) return -1;
        if (count < most) out[count] = value;
        count++;
        text += length;
    }
    return count;
}

const char *text_name_fault(const char *name)
{
    if (!*name) return "is empty";
    if (strlen(name) > NAME_MAX_BYTES) return "has more than 127 bytes";
    if (strpbrk(name, "*?")) return "has a '*' or '?', which are for patterns";
    if (strncmp(name, "group:", 6) == 0) return "begins with 'group:', which is for patterns";
    for (; *name; name++)
        if ((unsigned char)*name < ' ' || *name == 127) return "has a control character";
    return NULL;
}

/* On a mismatch the last '*' takes one more character: no recursion, at most |pattern| |name| steps. */
bool text_matches(const char *pattern, const char *name)
{
    const char *star = NULL, *from = NULL;
    while (*name) {
        if (*pattern == '*') {
            star = ++pattern;
            from = name;
        } else if (*pattern == '?' || *pattern == *name) {
            pattern++;
            name++;
        } else if (star) {
            pattern = star;
            name = ++from;
        } else {
            return false;
        }
    }
    return pattern[strspn(pattern, "*")] == '\0';
}

char *text_folder(pool *p, const char *path)
{
    const char *slash = strrchr(path, '/');
    if (!slash) return pool_copy(p, ".");
    if (slash == path) return pool_copy(p, "/");
    return pool_format(p, "%.*s", (int)(slash - path), path);
}

char *text_beside(pool *p, const char *folder, const char *path)
{
    if (*path == '/' || strcmp(folder, ".") == 0) return pool_copy(p, path);
    return pool_format(p, "%s/%s", folder, path);
}
