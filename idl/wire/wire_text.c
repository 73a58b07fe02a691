/* wire_text: refusals, UTF-8 and the FNV-1a hash. Pure; any thread. */
#include "wire_text.h"

#include <stdarg.h>
#include <stdio.h>

wire_reason wire_refuse(wire_refusal *refusal, wire_reason reason, const char *format, ...)
{
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(refusal->text, sizeof refusal->text, format, arguments);
    va_end(arguments);
    refusal->reason = reason;
    return reason;
}

/* Bytes of the character at `p`, or 0 if it is not well-formed (Unicode 15, table 3-7). */
static int utf8_length(const unsigned char *p)
{
    static const struct {
        unsigned char first_lo, first_hi, second_lo, second_hi, length;
    } forms[] = {
        {0xc2, 0xdf, 0x80, 0xbf, 2},
        {0xe0, 0xe0, 0xa0, 0xbf, 3},
        {0xe1, 0xec, 0x80, 0xbf, 3},
        {0xed, 0xed, 0x80, 0x9f, 3},
        {0xee, 0xef, 0x80, 0xbf, 3},
        {0xf0, 0xf0, 0x90, 0xbf, 4},
        {0xf1, 0xf3, 0x80, 0xbf, 4},
        {0xf4, 0xf4, 0x80, 0x8f, 4},
    };
    if (p[0] < 0x80) return 1;
    for (size_t i = 0; i < sizeof forms / sizeof *forms; i++) {
        if (p[0] < forms[i].first_lo || p[0] > forms[i].first_hi) continue;
        if (p[1] < forms[i].second_lo || p[1] > forms[i].second_hi) return 0;
        for (int k = 2; k < forms[i].length; k++)
            if ((p[k] & 0xc0) != 0x80) return 0; /* a NUL too, so that nothing behind the end is read */
        return forms[i].length;
    }
    return 0;
}

bool wire_text_is_utf8(const char *text)
{
    const unsigned char *p = (const unsigned char *)text;
    while (*p) {
        int length = utf8_length(p);
        if (length == 0) return false;
        p += length;
    }
    return true;
}

bool wire_text_has_controls(const char *text)
{
    for (const unsigned char *p = (const unsigned char *)text; *p; p++)
        if (*p < 0x20 || *p == 0x7f || (p[0] == 0xc2 && p[1] < 0xa0)) return true;
    return false;
}

uint64_t wire_fnv1a(uint64_t hash, const void *bytes, size_t size)
{
    const uint8_t *p = bytes;
    for (size_t i = 0; i < size; i++) hash = (hash ^ p[i]) * UINT64_C(0x100000001b3);
    return hash;
}
