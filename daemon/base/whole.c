/* whole: when walks are due, and how they fail. */
#include "whole.h"

#include <stdio.h>
#include <stdlib.h>

static bool rests;

void whole_rest(bool rest)
{
    rests = rest;
}

bool whole_is_due(uint64_t phase, size_t size)
{
    enum { AT_FIRST = 16, EVERY = 32, A_PHASE = 50, SMALL = 5000, LARGEST = 50000 };
    if (rests || size > LARGEST) return false;
    return (phase < AT_FIRST && size <= SMALL) || phase % (EVERY + size / A_PHASE) == 0;
}

void whole_holds(const char *fault, const char *of, const char *file, int line)
{
    if (!fault) return;
    fprintf(stderr, "%s:%d: assertion failed: %s: %s\n", file, line, of, fault);
    abort();
}
