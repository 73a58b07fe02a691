/* roff: see roff.h. Pure functions of text; the output's errors are found by whoever closes it. */
#include "roff.h"

#include <ctype.h>
#include <stdbool.h>
#include <string.h>

/* A hyphen joins two words; any other '-' is a minus sign, which can be copied into a shell. */
static bool is_hyphen(const char *text, const char *at)
{
    return at > text && isalpha((unsigned char)at[-1]) && isalpha((unsigned char)at[1]);
}

static const char *escape(char letter)
{
    switch (letter) {
    case '\\':
        return "\\(rs";
    case '"':
        return "\\(dq";
    case '\'':
        return "\\(aq";
    case '`':
        return "\\(ga";
    case '^':
        return "\\(ha";
    case '~':
        return "\\(ti";
    default:
        return NULL;
    }
}

static void put(FILE *out, const char *text, size_t length)
{
    if (length && *text == '.') fputs("\\&", out);
    for (const char *at = text; at < text + length; at++) {
        const char *escaped = escape(*at);
        if (*at == '-' && !is_hyphen(text, at))
            fputs("\\-", out);
        else if (escaped)
            fputs(escaped, out);
        else
            putc(*at, out);
    }
}

void roff_text(FILE *out, const char *text)
{
    put(out, text, strlen(text));
}

void roff_bold(FILE *out, const char *text)
{
    fputs("\\fB", out);
    roff_text(out, text);
    fputs("\\fR", out);
}

void roff_italic(FILE *out, const char *text)
{
    fputs("\\fI", out);
    roff_text(out, text);
    fputs("\\fR", out);
}

void roff_sentence(FILE *out, const char *text)
{
    size_t length = strlen(text);
    /* A keyword, such as a URI, keeps its small letters. */
    bool word = length && strcspn(text, " ,.;") <= strcspn(text, ":/_-(");
    if (word) {
        putc(toupper((unsigned char)*text), out);
        put(out, text + 1, length - 1);
    } else {
        put(out, text, length);
    }
    fputs(length && strchr(".:", text[length - 1]) ? "\n" : ".\n", out);
}

void roff_paragraphs(FILE *out, const char *text)
{
    bool literal = false;
    for (const char *line = text; *line;) {
        size_t length = strcspn(line, "\n");
        bool indented = strncmp(line, "  ", 2) == 0;
        if (indented != literal) fputs(indented ? ".PP\n.nf\n" : ".fi\n.PP\n", out);
        literal = indented;
        if (length) {
            put(out, line, length);
            putc('\n', out);
        } else if (line[1]) {
            fputs(".PP\n", out);
        }
        line += length + (line[length] == '\n');
    }
    if (literal) fputs(".fi\n", out);
}
