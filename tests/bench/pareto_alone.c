/* pareto_alone: ours, and libccd, which is there anyway. */
#include "pareto_sweep.h"

const narrow_entry pareto_sweep[] = {PARETO_OURS, PARETO_CCD};
const size_t pareto_sweep_count = sizeof pareto_sweep / sizeof *pareto_sweep;
