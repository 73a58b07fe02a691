/* sheet: the names that are made up for it, and their memory. */
#include "sheet.h"

#include "base/array.h"

#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>

sheet *sheet_create(void)
{
    sheet *t = base_zalloc(1, sizeof *t);
    t->memory = wire_memory_create();
    return t;
}

void sheet_destroy(sheet *t)
{
    if (!t) return;
    wire_memory_destroy(t->memory);
    free(t);
}

void sheet_begin(sheet *t)
{
    t->count = 0;
    wire_memory_reset(t->memory);
}

void sheet_add_named(sheet *t, int64_t value, const char *format, ...)
{
    va_list arguments, again;
    va_start(arguments, format);
    va_copy(again, arguments);
    size_t size = (size_t)vsnprintf(NULL, 0, format, arguments) + 1;
    char *name = wire_memory_take(t->memory, size);
    vsnprintf(name, size, format, again);
    va_end(again);
    va_end(arguments);
    sheet_add(t, name, value);
}
