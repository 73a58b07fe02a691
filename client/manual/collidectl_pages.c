/* collidectl_pages: fills a template with the tables of verbs and options of collidectl: its manual page and its
 * completion. Run by the build: collidectl_pages TEMPLATE OUTPUT. Linked with the objects of collidectl but its main.
 */
#include "collidectl/options.h"
#include "collidectl/verbs.h"
#include "roff/roff.h"
#include "roff/template.h"

#include <stdlib.h>
#include <string.h>

/* ---- manual ---- */

static void write_option(FILE *out, const option *o)
{
    fputs(".TP\n", out);
    roff_bold(out, o->name);
    if (o->value) {
        putc(' ', out);
        roff_italic(out, o->value);
    }
    putc('\n', out);
    roff_sentence(out, o->help);
    if (o->kind == NUMBER || o->kind == COUNT)
        fprintf(out, "Value: %s from %g to %g.\n", o->kind == COUNT ? "whole number" : "number", o->least, o->most);
}

static void write_options(FILE *out)
{
    int count;
    const option *o = options_table(&count);
    for (const option *end = o + count; o < end; o++)
        if (!*o->verbs) write_option(out, o);
}

static void write_own_options(FILE *out, const ctl_verb *verb)
{
    int count;
    const option *o = options_table(&count);
    fputs(".RS\n", out);
    for (const option *end = o + count; o < end; o++)
        if (*o->verbs && options_takes(o, verb)) write_option(out, o);
    fputs(".RE\n", out);
}

static void write_verbs(FILE *out)
{
    for (const ctl_verb *v = ctl_verbs; v->name; v++) {
        fputs(".SS ", out);
        roff_bold(out, v->name);
        if (*v->arguments) {
            putc(' ', out);
            roff_italic(out, v->arguments);
        }
        putc('\n', out);
        roff_sentence(out, v->summary);
        if (*v->details) fputs(strncmp(v->details, "  ", 2) == 0 ? "" : ".PP\n", out);
        roff_paragraphs(out, v->details);
        write_own_options(out, v);
    }
}

static void write_exits(FILE *out)
{
    int count;
    const option_exit *e = options_exits(&count);
    for (const option_exit *end = e + count; e < end; e++) {
        fprintf(out, ".TP\n.B %d\n", e->status);
        roff_sentence(out, e->meaning);
    }
}

/* ---- completion ---- */

static void write_verb_words(FILE *out)
{
    for (const ctl_verb *v = ctl_verbs; v->name; v++) fprintf(out, "    %s\n", v->name);
}

/* Per verb, and for no verb, a branch of a case with the options that it takes. */
static void write_option_words(FILE *out)
{
    int count;
    const option *table = options_table(&count);
    const ctl_verb *v = ctl_verbs;
    do {
        const ctl_verb *verb = v->name ? v : NULL;
        fprintf(out, "    %s) echo \"", verb ? verb->name : "\"\"");
        for (const option *o = table; o < table + count; o++)
            if (options_takes(o, verb)) fprintf(out, " %s", o->name);
        fputs("\" ;;\n", out);
    } while (v++->name);
}

static void write_facts(FILE *out)
{
    fputs("    --facts) compgen -W \"", out);
    for (const char *const *f = options_facts; *f; f++) fprintf(out, " %s", *f);
    fputs("\" -- \"$2\" ;;\n", out);
}

static void write_queries(FILE *out)
{
    fputs("    query) compgen -W \"", out);
    for (size_t i = 0; verb_query_kind(i); i++) fprintf(out, " %s", verb_query_kind(i));
    fputs("\" -- \"$2\" ;;\n", out);
}

static void write_files(FILE *out)
{
    int count;
    const option *o = options_table(&count);
    for (const option *end = o + count; o < end; o++) {
        const char *action = !o->value ? "" : !strcmp(o->value, "FILE") ? "f" : !strcmp(o->value, "DIR") ? "d" : "";
        if (*action) fprintf(out, "    %s) compgen -%s -- \"$2\" ;;\n", o->name, action);
    }
}

static void write_flags(FILE *out)
{
    int count;
    const option *o = options_table(&count);
    for (const option *end = o + count; o < end; o++)
        if (o->kind == FLAG) fprintf(out, "    %s) return 1 ;;\n", o->name);
}

int main(int argc, char **argv)
{
    static const template_section sections[] = {{"options", write_options}, {"verbs", write_verbs},
        {"exits", write_exits}, {"verb_words", write_verb_words}, {"option_words", write_option_words},
        {"facts", write_facts}, {"queries", write_queries}, {"files", write_files}, {"flags", write_flags}, {0}};
    if (argc == 3) return template_write(argv[1], argv[2], sections) ? EXIT_FAILURE : EXIT_SUCCESS;
    fputs("usage: collidectl_pages TEMPLATE OUTPUT\n", stderr);
    return EXIT_FAILURE;
}
