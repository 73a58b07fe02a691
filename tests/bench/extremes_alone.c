/* extremes_alone: ours, and libccd, which is there anyway. */
#include "extremes_guard.h"

const narrow_entry extremes_entries[] = {{&narrow_dial_world, 1e-6, "1e-6", true, true},
    {&narrow_dial_world, 0, "exact", true, true}, {&narrow_ccd_gjk, 1e-4, "1e-4", true, true},
    {&narrow_ccd_gjk, 1e-10, "1e-10", false, true}, {&narrow_ccd_mpr, 1e-4, "1e-4", true, true}};
const size_t extremes_entry_count = sizeof extremes_entries / sizeof *extremes_entries;
