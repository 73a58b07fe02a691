/* finding: printf into the two lines. Text of the daemon may be in them: control characters become '?'. */
#include "finding.h"

#include <stdarg.h>
#include <stdio.h>

static void write_line(char line[DOCTOR_TEXT_MAX], const char *format, va_list arguments)
{
    vsnprintf(line, DOCTOR_TEXT_MAX, format, arguments);
    for (char *t = line; *t; t++)
        if ((unsigned char)*t < ' ' || *t == 127) *t = '?';
}

#define FINDING(verdict_, format)                                                                                      \
    doctor_finding f = {.verdict = (verdict_)};                                                                        \
    va_list arguments;                                                                                                 \
    va_start(arguments, format);                                                                                       \
    write_line(f.seen, format, arguments);                                                                             \
    va_end(arguments);                                                                                                 \
    return f

doctor_finding finding_ok(const char *format, ...)
{
    FINDING(DOCTOR_OK, format);
}

doctor_finding finding_unknown(const char *format, ...)
{
    FINDING(DOCTOR_UNKNOWN, format);
}

doctor_finding finding_problem(const char *format, ...)
{
    FINDING(DOCTOR_PROBLEM, format);
}

doctor_finding finding_mend(doctor_finding f, const char *format, ...)
{
    va_list arguments;
    va_start(arguments, format);
    write_line(f.mend, format, arguments);
    va_end(arguments);
    return f;
}

const char *doctor_verdict_name(doctor_verdict verdict)
{
    static const char *const names[] = {
        [DOCTOR_OK] = "ok", [DOCTOR_PROBLEM] = "problem", [DOCTOR_UNKNOWN] = "cannot tell"};
    return names[verdict];
}
