/* narrow_all: ours and every peer of the Debian packages. */
#include "narrow_peer.h"

const narrow_peer *const narrow_contenders[] = {&narrow_ours, &narrow_ours_finest, &narrow_ours_cached,
    &narrow_ours_again, &narrow_loop, &narrow_verify, &narrow_verify_prepared, &narrow_fcl, &narrow_fcl_fine,
    &narrow_fcl_collide, &narrow_fcl_indep, &narrow_fcl_indep_collide, &narrow_bullet_pair, &narrow_bullet_epa,
    &narrow_bullet_box, &narrow_ode, &narrow_ccd_gjk, &narrow_ccd_gjk_fine, &narrow_ccd_mpr};
const size_t narrow_contender_count = sizeof narrow_contenders / sizeof *narrow_contenders;
