/* choose: which index a broad phase uses, and the change from one to another: the proxies move, their pairs stay. Tick
 * thread. What auto chooses depends only on what was put and removed, so a replay chooses the same.
 *
 * Measured (Xeon, one core; the three in turn in one process, on the same bodies; ns a moved body of 1 m, mean; all
 * move by 1 to 2 % of their size a tick: in a cube with three neighbours each, counted by fat boxes; in a layer; in a
 * row; heaped up within 2 m):
 *
 *   proxies   cube                     layer                    row                      heap
 *             tree  sweep3  sweep1     tree  sweep3  sweep1     tree  sweep3  sweep1     tree  sweep3  sweep1
 *   64        50    37      41         47    35      35         37    30      24         139   71      95
 *   128       50    35      41         47    37      36         38    33      24         231   101     154
 *   256       55    40      48         49    44      38         39    42      25         458   198     318
 *   384       56    44      54         53    56      42         39    50      25         1407  928     1092
 *   800       57    57      70         52    76      44         41    84      26
 *
 * With a tenth of them moving the sweeps are some 10 % worse against the tree than with all. In script/bench broad
 * (mixed sizes, a cube, one neighbour each) sweep3 takes, by the tree's time:
 *
 *   bodies        100    300    1,000  3,000  10,000
 *   10 % moving   0.76   0.98   1.09   1.35   2.28
 *   all moving    0.69   0.74   0.87   1.19   2.12
 *
 * So: three axes for small worlds, the tree for all others. Small is where no scene loses by more than a tenth. sweep1
 * wins where all stand in a row or layer, which auto does not look for: one wide plate among 384 bodies makes it a
 * third slower than the tree, among 800 more than twice.
 *
 * A hashed grid of loose cells, tried in the same place, took 0.86 and 0.90 of the tree's time at 1,000 and 10,000
 * bodies of like size that all move, 1.0 and 1.2 with 10 and 1 % at 10,000, and cannot take large ones: it has not
 * earned its place. */
#include "state.h"

#include <stdio.h>

/* Proxies; between the two numbers what stands stays, so that no world changes its index back and forth. */
enum { SMALL_MOST = 256, SMALL_AGAIN = 128 };

static const broad_index *index_of(broad_kind kind)
{
    switch (kind) {
    case BROAD_SWEEP3:
        return &broad_sweep3;
    case BROAD_SWEEP1:
        return &broad_sweep1;
    case BROAD_TREE:
    case BROAD_AUTO:
        break;
    }
    return &broad_trees;
}

const broad_index *broad_first_index(broad_kind kind)
{
    return index_of(kind == BROAD_AUTO ? BROAD_SWEEP3 : kind);
}

/* How many there are when the batch has been carried out. */
static size_t count_after(const broad *b)
{
    size_t count = b->proxy_count;
    for (size_t i = 0; i < b->pending.count; i++) {
        const change *c = &b->pending.at[i];
        bool was = b->proxies.at[c->proxy].place != NOWHERE, is = c->put || (was && !c->removed);
        count = count + is - was;
    }
    return count;
}

static void move_into(broad *b, const broad_index *index)
{
    b->index->free(b);
    b->index = index;
    for (uint32_t id = 0; id < b->proxies.count; id++) {
        const proxy *p = &b->proxies.at[id];
        if (p->place == INDEXED) index->put(b, &(change){.proxy = id, .fixed = p->fixed, .fat = p->fat});
    }
    index->settle(b);
}

/* Counts only where the batch can bring the world past a limit. */
void broad_choose_index(broad *b)
{
    if (b->kind != BROAD_AUTO) return;
    if (b->index == &broad_trees) {
        if (b->proxy_count > SMALL_AGAIN + b->pending.count || count_after(b) > SMALL_AGAIN) return;
        move_into(b, &broad_sweep3);
    } else {
        if (b->proxy_count + b->pending.count <= SMALL_MOST || count_after(b) <= SMALL_MOST) return;
        move_into(b, &broad_trees);
    }
}

/* ---- in words ---- */

const char *broad_kind_name(broad_kind kind)
{
    static const char *const names[] = {
        [BROAD_AUTO] = "auto", [BROAD_TREE] = "tree", [BROAD_SWEEP3] = "sweep3", [BROAD_SWEEP1] = "sweep1"};
    return names[kind];
}

broad_kind broad_index_kind(const broad *b)
{
    return b->index->kind;
}

void broad_report_index(const broad *b, char text[96])
{
    const char *name = broad_kind_name(b->index->kind);
    if (b->kind != BROAD_AUTO)
        snprintf(text, 96, "%s (as configured)", name);
    else if (b->index == &broad_trees)
        snprintf(text, 96, "%s (auto: %zu proxies; sweep3 for %d and fewer)", name, b->proxy_count, SMALL_AGAIN);
    else
        snprintf(text, 96, "%s (auto: %zu proxies; tree for more than %d)", name, b->proxy_count, SMALL_MOST);
}
