/* report: formats errors and warnings. Control characters from a file are shown as '?', so that a message stays one
 * line. */
#include "report.h"

#include <stdarg.h>
#include <stdio.h>

static void one_line(char *text)
{
    for (; *text; text++)
        if ((unsigned char)*text < ' ' || *text == 127) *text = '?';
}

bool load_fail(load_report *r, const char *format, ...)
{
    if (r->error[0]) return false;
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(r->error, sizeof r->error, format, arguments);
    va_end(arguments);
    one_line(r->error);
    return false;
}

void load_warn(load_report *r, const char *format, ...)
{
    r->warnings++;
    if (!r->warn) return;
    char text[sizeof r->error];
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(text, sizeof text, format, arguments);
    va_end(arguments);
    one_line(text);
    r->warn(r->context, text);
}

void load_note(load_report *r, const char *format, ...)
{
    if (!r->note) return;
    char text[sizeof r->error];
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(text, sizeof text, format, arguments);
    va_end(arguments);
    one_line(text);
    r->note(r->context, text);
}
