/* collided_pages: fills a template with the table of options of the daemon: its manual pages, its default configuration
 * file and its completion. Run by the build: collided_pages TEMPLATE OUTPUT. */
#include "roff/roff.h"
#include "roff/template.h"
#include "service/config.h"

#include <stdlib.h>
#include <string.h>

static bool is_number(const config_option *o)
{
    return o->type == CONFIG_WHOLE || o->type == CONFIG_NUMBER;
}

/* What may stand behind the key, in words. */
static void describe_value(const config_option *o, char *text, size_t size)
{
    static const char *const types[] = {[CONFIG_TEXT] = "text",
        [CONFIG_CHOICE] = "one of ",
        [CONFIG_WHOLE] = "whole number",
        [CONFIG_NUMBER] = "number",
        [CONFIG_YES] = "yes or no"};
    if (is_number(o))
        snprintf(
            text, size, "%s from %.10g to %.10g%s%s", types[o->type], o->least, o->most, *o->unit ? " " : "", o->unit);
    else if (o->type == CONFIG_CHOICE)
        snprintf(text, size, "%s%s", types[o->type], o->choices);
    else if (o->type == CONFIG_TEXT)
        snprintf(text, size, "%s of at most %zu bytes", types[o->type], o->size - 1);
    else
        snprintf(text, size, "%s", types[o->type]);
}

static void write_value(FILE *out, const config_option *o)
{
    char text[256];
    describe_value(o, text, sizeof text);
    fputs(".br\nValue: ", out);
    roff_text(out, text);
    fputs(".\n.br\nDefault: ", out);
    if (*o->value)
        roff_bold(out, o->value);
    else
        fputs("empty", out);
    fputs(".\n", out);
}

/* The name of the value in a synopsis. */
static const char *value_name(const config_option *o)
{
    return is_number(o) ? "N" : o->type == CONFIG_CHOICE ? o->choices : "TEXT";
}

static void write_options(FILE *out)
{
    size_t count;
    const config_option *o = config_options(&count);
    for (const config_option *end = o + count; o < end; o++) {
        fputs(".TP\n\\fB\\-\\-", out);
        roff_text(out, o->key);
        fputs("\\fR", out);
        if (o->type == CONFIG_YES) {
            fputs("[=yes|no]", out);
        } else {
            putc(' ', out);
            roff_italic(out, value_name(o));
        }
        putc('\n', out);
        roff_sentence(out, o->help);
        write_value(out, o);
    }
}

static void write_keys(FILE *out)
{
    size_t count;
    const config_option *o = config_options(&count);
    for (const config_option *end = o + count; o < end; o++) {
        fputs(".TP\n", out);
        roff_bold(out, o->key);
        fputs(" = ", out);
        roff_italic(out, o->type == CONFIG_YES ? "yes|no" : value_name(o));
        putc('\n', out);
        roff_sentence(out, o->help);
        if (*o->details) roff_sentence(out, o->details);
        write_value(out, o);
    }
}

static void write_exits(FILE *out)
{
    size_t count;
    const config_exit *e = config_exits(&count);
    for (const config_exit *end = e + count; e < end; e++) {
        fprintf(out, ".TP\n.B %d\n", e->status);
        roff_sentence(out, e->meaning);
    }
}

/* Comment lines of at most 100 letters. */
static void write_comment(FILE *out, const char *text)
{
    enum { WIDTH = 98 };
    size_t column = 0;
    for (const char *word = text; *word; word += strspn(word, " ")) {
        size_t length = strcspn(word, " ");
        bool fits = column && column + 1 + length <= WIDTH;
        if (column && !fits) putc('\n', out);
        fprintf(out, "%s%.*s", fits ? " " : "# ", (int)length, word);
        column = fits ? column + 1 + length : length;
        word += length;
    }
    putc('\n', out);
}

static void write_defaults(FILE *out)
{
    size_t count;
    const config_option *o = config_options(&count);
    for (const config_option *end = o + count; o < end; o++) {
        char text[256] = "Value: ";
        describe_value(o, text + strlen(text), sizeof text - strlen(text));
        putc('\n', out);
        write_comment(out, o->help);
        if (*o->details) write_comment(out, o->details);
        write_comment(out, text);
        fprintf(out, "#%s =%s%s\n", o->key, *o->value ? " " : "", o->value);
    }
}

/* ---- completion ---- */

static void write_words(FILE *out)
{
    size_t count;
    const config_option *o = config_options(&count);
    for (const config_option *end = o + count; o < end; o++) fprintf(out, "        --%s\n", o->key);
}

static void write_choices(FILE *out)
{
    size_t count;
    const config_option *o = config_options(&count);
    for (const config_option *end = o + count; o < end; o++) {
        const char *choices = o->type == CONFIG_YES ? "yes|no" : o->choices;
        if (!choices) continue;
        fprintf(out, "    --%s) compgen -W \"", o->key);
        for (const char *c = choices; *c; c++) putc(*c == '|' ? ' ' : *c, out);
        fputs("\" -- \"$2\" ;;\n", out);
    }
}

static void write_flags(FILE *out)
{
    size_t count;
    const config_option *o = config_options(&count);
    fputs("    --help | --version", out);
    for (const config_option *end = o + count; o < end; o++)
        if (o->type == CONFIG_YES) fprintf(out, " | --%s", o->key);
    fputs(") return 1 ;;\n", out);
}

int main(int argc, char **argv)
{
    static const template_section sections[] = {{"options", write_options}, {"keys", write_keys},
        {"defaults", write_defaults}, {"exits", write_exits}, {"words", write_words}, {"choices", write_choices},
        {"flags", write_flags}, {0}};
    if (argc == 3) return template_write(argv[1], argv[2], sections) ? EXIT_FAILURE : EXIT_SUCCESS;
    fputs("usage: collided_pages TEMPLATE OUTPUT\n", stderr);
    return EXIT_FAILURE;
}
