/* extremes_all: ours at its default and as narrow as arithmetic gives; the peers as they come, and at their finest. */
#include "extremes_guard.h"

const narrow_entry extremes_entries[] = {{&narrow_dial_world, 1e-6, "1e-6", true, true},
    {&narrow_dial_world, 0, "exact", true, true}, {&narrow_fcl, 1e-6, "1e-6", true, true},
    {&narrow_fcl_indep, 1e-6, "1e-6", true, false}, {&narrow_fcl_collide, 1e-6, "1e-6", false, true},
    {&narrow_fcl_indep_collide, 1e-6, "1e-6", false, true}, {&narrow_bullet_pair, 0, "1e-12", true, true},
    {&narrow_bullet_epa, 0, "none", true, true}, {&narrow_bullet_box, 0, "none", true, true},
    {&narrow_ode, 0, "none", true, true}, {&narrow_ccd_gjk, 1e-4, "1e-4", true, true},
    {&narrow_ccd_gjk, 1e-10, "1e-10", false, true}, {&narrow_ccd_mpr, 1e-4, "1e-4", true, true}};
const size_t extremes_entry_count = sizeof extremes_entries / sizeof *extremes_entries;
