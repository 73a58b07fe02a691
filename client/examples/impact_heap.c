/* impact_heap: sifting up and down. One thread. */
#include "impact_heap.h"

static bool earlier(const impact *x, const impact *y)
{
    if (x->lo_s != y->lo_s) return x->lo_s < y->lo_s;
    return x->at.a != y->at.a ? x->at.a < y->at.a : x->at.b < y->at.b;
}

static void swap(impact *x, impact *y)
{
    impact was = *x;
    *x = *y;
    *y = was;
}

void impact_push(impact_heap *heap, impact what)
{
    if (heap->count == IMPACTS_MAX) {
        heap->dropped++;
        return;
    }
    size_t i = heap->count++;
    heap->at[i] = what;
    for (; i > 0 && earlier(&heap->at[i], &heap->at[(i - 1) / 2]); i = (i - 1) / 2)
        swap(&heap->at[i], &heap->at[(i - 1) / 2]);
}

bool impact_pop(impact_heap *heap, impact *out)
{
    if (!heap->count) return false;
    *out = heap->at[0];
    heap->at[0] = heap->at[--heap->count];
    for (size_t i = 0, child; (child = 2 * i + 1) < heap->count; i = child) {
        child += child + 1 < heap->count && earlier(&heap->at[child + 1], &heap->at[child]);
        if (!earlier(&heap->at[child], &heap->at[i])) break;
        swap(&heap->at[i], &heap->at[child]);
    }
    return true;
}
