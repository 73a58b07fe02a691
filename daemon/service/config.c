/* config: the table of options, and what is made from it. Main thread, at start. */
#include "config.h"

#include <errno.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define FIELD(name) offsetof(config, name), sizeof(((config *)0)->name)

static const config_option OPTIONS[] = {
    {"links", CONFIG_TEXT, FIELD(links), 0, 0, NULL, "dds://0 lcm://", "",
        "transports to listen on, by spaces: dds://DOMAIN, lcm://[udpm://GROUP:PORT?ttl=N]"},
    {"interface", CONFIG_TEXT, FIELD(interface), 0, 0, NULL, "", "",
        "network interface to open the links to; empty: this machine only"},
    {"name", CONFIG_TEXT, FIELD(name), 0, 0, NULL, "", "", "name of this daemon in status; empty: host:pid"},
    {"gateway", CONFIG_TEXT, FIELD(gateway), 0, 0, NULL, "", "",
        "path of collided-lcm; empty: beside this program, else by PATH"},
    {"workers", CONFIG_WHOLE, FIELD(workers), 0, 64, NULL, "0", "threads",
        "threads of the narrow phase; 0: one a core, at most 8"},
    {"engine", CONFIG_CHOICE, FIELD(engine), 0, 0, "auto|gjk|ccd|mpr", "auto", "",
        "narrow phase: auto (closed forms, GJK, exact depth), gjk (general path only), ccd and mpr (libccd proposes, "
        "our certificate decides)"},
    {"caches", CONFIG_YES, FIELD(caches), 0, 0, NULL, "yes", "",
        "let cached axes and motion bounds skip separated pairs; the events are the same without"},
    {"margin", CONFIG_NUMBER, FIELD(margin), 0, 10, NULL, "0.1", "of a shape's reach",
        "by how much boxes are fattened"},
    {"rate", CONFIG_NUMBER, FIELD(rate), 0, 100000, NULL, "0", "Hz",
        "ticks a second; 0: a tick whenever something came"},
    {"status_period", CONFIG_NUMBER, FIELD(status_period), 0.05, 60, NULL, "1", "s", "how often Status is published"},
    {"lease", CONFIG_NUMBER, FIELD(lease), 0.05, 3600, NULL, "2", "s",
        "lease of a client that has not announced its own yet"},
    {"max_clients", CONFIG_WHOLE, FIELD(max_clients), 1, 100000, NULL, "1000", "clients", "clients at once"},
    {"max_bodies", CONFIG_WHOLE, FIELD(max_bodies), 1, 10000000, NULL, "1000000", "bodies", "bodies in the world"},
    {"max_shapes", CONFIG_WHOLE, FIELD(max_shapes), 1, 40000000, NULL, "2000000", "shapes", "shapes in the world"},
    {"max_interests", CONFIG_WHOLE, FIELD(max_interests), 1, 4096, NULL, "512", "interests", "interests at once"},
    {"max_geometries", CONFIG_WHOLE, FIELD(max_geometries), 1, 1000000, NULL, "10000", "geometries",
        "hulls in the store"},
    {"record", CONFIG_TEXT, FIELD(record), 0, 0, NULL, "", "", "record all commands to this file (LCM's log format)"},
    {"record_dir", CONFIG_TEXT, FIELD(record_dir), 0, 0, NULL, "", "",
        "folder in which clients may start recordings; empty: they may not"},
    {"replay", CONFIG_TEXT, FIELD(replay), 0, 0, NULL, "", "",
        "run a recording instead of live links, compare its hashes, and end"},
    {"json", CONFIG_YES, FIELD(json), 0, 0, NULL, "no", "", "print the result of a replay as a JSON object"},
    {"log", CONFIG_CHOICE, FIELD(log), 0, 0, "error|warning|notice|info|debug", "notice", "", "least level to log"},
    {"journal", CONFIG_YES, FIELD(journal), 0, 0, NULL, "no", "", "mark log lines with their level for the journal"},
};
enum { OPTION_COUNT = sizeof OPTIONS / sizeof *OPTIONS };

const config_option *config_options(size_t *count)
{
    *count = OPTION_COUNT;
    return OPTIONS;
}

/* ---- values ---- */

static int refuse(char *why, size_t size, const config_option *o, const char *value, const char *allowed)
{
    snprintf(why, size, "%s = \"%.80s\": allowed is %s", o->key, value, allowed);
    return -1;
}

static int set_number(config *c, const config_option *o, const char *value, char *why, size_t why_size)
{
    char allowed[160], *end;
    errno = 0;
    double number = strtod(value, &end);
    bool whole = o->type == CONFIG_WHOLE;
    snprintf(allowed, sizeof allowed, "a %snumber from %.10g to %.10g%s%s", whole ? "whole " : "", o->least, o->most,
        *o->unit ? " " : "", o->unit);
    bool good = end != value && !*end && !errno && number >= o->least && number <= o->most;
    if (!good || (whole && number != floor(number))) return refuse(why, why_size, o, value, allowed);
    if (whole)
        *(long *)((char *)c + o->offset) = (long)number;
    else
        *(double *)((char *)c + o->offset) = number;
    return 0;
}

static int set_yes(config *c, const config_option *o, const char *value, char *why, size_t why_size)
{
    bool yes = !strcmp(value, "yes") || !strcmp(value, "true") || !strcmp(value, "1");
    bool no = !strcmp(value, "no") || !strcmp(value, "false") || !strcmp(value, "0");
    if (!yes && !no) return refuse(why, why_size, o, value, "yes or no");
    *(bool *)((char *)c + o->offset) = yes;
    return 0;
}

static bool is_choice(const char *choices, const char *value)
{
    size_t length = strcspn(value, "|");
    if (value[length]) return false;
    for (const char *at = choices; length && at; at = strchr(at, '|')) {
        at += *at == '|';
        if (strncmp(at, value, length) == 0 && (at[length] == '|' || !at[length])) return true;
    }
    return false;
}

static int set_text(config *c, const config_option *o, const char *value, char *why, size_t why_size)
{
    char allowed[96];
    if (o->type == CONFIG_CHOICE && !is_choice(o->choices, value)) return refuse(why, why_size, o, value, o->choices);
    if (strlen(value) >= o->size) {
        snprintf(allowed, sizeof allowed, "at most %zu characters", o->size - 1);
        return refuse(why, why_size, o, value, allowed);
    }
    memcpy((char *)c + o->offset, value, strlen(value) + 1);
    return 0;
}

int config_set(config *c, const char *key, const char *value, char *why, size_t why_size)
{
    for (size_t i = 0; i < OPTION_COUNT; i++) {
        const config_option *o = &OPTIONS[i];
        if (strcmp(o->key, key) != 0) continue;
        if (o->type == CONFIG_WHOLE || o->type == CONFIG_NUMBER) return set_number(c, o, value, why, why_size);
        if (o->type == CONFIG_YES) return set_yes(c, o, value, why, why_size);
        return set_text(c, o, value, why, why_size);
    }
    snprintf(why, why_size, "unknown key \"%.80s\"; collided --help lists them", key);
    return -1;
}

void config_default(config *c)
{
    char why[CONFIG_TEXT_MAX];
    memset(c, 0, sizeof *c);
    for (size_t i = 0; i < OPTION_COUNT; i++) {
        if (config_set(c, OPTIONS[i].key, OPTIONS[i].value, why, sizeof why) == 0) continue;
        fprintf(stderr, "%s\n", why); /* the table contradicts itself */
        abort();
    }
}

/* ---- files ---- */

static char *trim(char *text)
{
    text += strspn(text, " \t\r");
    size_t length = strlen(text);
    while (length && strchr(" \t\r", text[length - 1])) text[--length] = '\0';
    return text;
}

static int set_line(config *c, char *text, char *why, size_t why_size)
{
    char *comment = strchr(text, '#');
    if (comment) *comment = '\0';
    text = trim(text);
    if (!*text) return 0;
    char *equals = strchr(text, '=');
    if (!equals) {
        snprintf(why, why_size, "\"%.80s\" is not of the form: key = value", text);
        return -1;
    }
    *equals = '\0';
    return config_set(c, trim(text), trim(equals + 1), why, why_size);
}

int config_parse(config *c, const char *text, size_t size, const char *path, char *why, size_t why_size)
{
    char line[2 * CONFIG_TEXT_MAX], reason[CONFIG_TEXT_MAX];
    const char *end = text + size;
    for (unsigned number = 1; text < end; number++) {
        const char *stop = memchr(text, '\n', (size_t)(end - text));
        size_t length = (size_t)((stop ? stop : end) - text);
        if (length >= sizeof line || memchr(text, '\0', length)) {
            snprintf(why, why_size, "%s:%u: line too long, or not text", path, number);
            return -1;
        }
        memcpy(line, text, length);
        line[length] = '\0';
        if (set_line(c, line, reason, sizeof reason) != 0) {
            snprintf(why, why_size, "%s:%u: %s", path, number, reason);
            return -1;
        }
        text += length + 1;
    }
    return 0;
}

int config_read(config *c, const char *path, char *why, size_t why_size)
{
    enum { FILE_MAX = 1 << 20 };
    FILE *file = fopen(path, "rb");
    char *text = file ? malloc(FILE_MAX + 1) : NULL;
    if (!text) {
        snprintf(why, why_size, "%s: %s", path, strerror(errno));
        if (file) fclose(file);
        return -1;
    }
    size_t size = fread(text, 1, FILE_MAX + 1, file);
    int failed = ferror(file) || size > FILE_MAX;
    fclose(file);
    if (failed)
        snprintf(why, why_size, "%s: cannot be read, or larger than %d bytes", path, FILE_MAX);
    else
        failed = config_parse(c, text, size, path, why, why_size) != 0;
    free(text);
    return failed ? -1 : 0;
}

/* ---- the command line ---- */

static bool is_yes_option(const char *key)
{
    for (size_t i = 0; i < OPTION_COUNT; i++)
        if (strcmp(OPTIONS[i].key, key) == 0) return OPTIONS[i].type == CONFIG_YES;
    return false;
}

/* Splits the argument at *at into key and value, and moves *at past both. */
static int split_argument(int argc, char **argv, int *at, char key[64], const char **value, char *why, size_t why_size)
{
    const char *text = argv[(*at)++];
    const char *equals = strchr(text, '=');
    size_t length = equals ? (size_t)(equals - text) : strlen(text);
    if (strncmp(text, "--", 2) != 0 || length - 2 >= 63) {
        snprintf(why, why_size, "\"%.80s\" is not an option; collided --help lists them", text);
        return -1;
    }
    memcpy(key, text + 2, length - 2);
    key[length - 2] = '\0';
    for (char *k = key; *k; k++)
        if (*k == '-') *k = '_';
    if (equals) {
        *value = equals + 1;
    } else if (is_yes_option(key) || !strcmp(key, "help") || !strcmp(key, "version")) {
        *value = "yes";
    } else if (*at < argc) {
        *value = argv[(*at)++];
    } else {
        snprintf(why, why_size, "--%s needs a value", key);
        return -1;
    }
    return 0;
}

int config_arguments(config *c, int argc, char **argv, const char **asked, char *why, size_t why_size)
{
    char key[64];
    const char *value;
    for (int pass = 0; pass < 2; pass++) {
        for (int at = 1; at < argc;) {
            if (split_argument(argc, argv, &at, key, &value, why, why_size) != 0) return -1;
            bool is_file = strcmp(key, "config") == 0;
            if (!strcmp(key, "help") || !strcmp(key, "version")) {
                *asked = key[0] == 'h' ? "help" : "version";
                return 1;
            }
            if (is_file != (pass == 0)) continue;
            int failed = is_file ? config_read(c, value, why, why_size) : config_set(c, key, value, why, why_size);
            if (failed) return -1;
        }
    }
    return 0;
}

void config_help(void)
{
    printf("Usage: collided [--config FILE] [--KEY VALUE]...\n\n"
           "A collision daemon: clients publish the poses of their bodies over DDS or LCM, and are told\n"
           "what touches and what is near. Each key may also stand in the file, as: key = value\n\n");
    for (size_t i = 0; i < OPTION_COUNT; i++) {
        const config_option *o = &OPTIONS[i];
        printf("  --%-15s %s\n  %17s ", o->key, o->help, "");
        if (o->type == CONFIG_WHOLE || o->type == CONFIG_NUMBER)
            printf("%.10g to %.10g %s; ", o->least, o->most, o->unit);
        else if (o->type == CONFIG_CHOICE)
            printf("%s; ", o->choices);
        else if (o->type == CONFIG_YES)
            printf("yes or no; ");
        printf("default: %s\n", *o->value ? o->value : "(empty)");
    }
    printf("  --%-15s %s\n  --%-15s %s\n  --%-15s %s\n", "config FILE", "read this file first", "help", "this text",
        "version", "the release and the version of the wire");
}
