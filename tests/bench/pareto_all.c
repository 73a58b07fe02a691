/* pareto_all: ours and every peer of the Debian packages, at the tolerances that each can be given. Bullet's box-box,
 * its EPA and ODE have none (ODE asks libccd at its default); Bullet's pair detector has one that is meant to tell
 * equal points and empty simplices. */
#include "pareto_sweep.h"

#define FOUR(peer, gaps, contacts)                                                                                     \
    {&peer, 1e-3, "1e-3", gaps, contacts}, {&peer, 1e-6, "1e-6", gaps, contacts},                                      \
        {&peer, 1e-9, "1e-9", gaps, contacts},                                                                         \
    {                                                                                                                  \
        &peer, 1e-12, "1e-12", gaps, contacts                                                                          \
    }

const narrow_entry pareto_sweep[] = {PARETO_OURS, FOUR(narrow_fcl, true, true), FOUR(narrow_fcl_indep, true, false),
    FOUR(narrow_fcl_collide, false, true), FOUR(narrow_fcl_indep_collide, false, true),
    FOUR(narrow_bullet_pair, true, true), {&narrow_bullet_epa, 0, "none", true, true},
    {&narrow_bullet_box, 0, "none", true, true}, {&narrow_ode, 0, "none", true, true}, PARETO_CCD};
const size_t pareto_sweep_count = sizeof pareto_sweep / sizeof *pareto_sweep;
