/* Default options and memory of tables of modes. */
#include <sonopack/modes.h>

#include "base/base.h"

#include <math.h>

sp_modes_options sp_modes_options_default(void) {
    return (sp_modes_options){.vectors = true, .source = SP_SOURCE_IMPULSE};
}

sp_modes sp_modes_none(void) { return (sp_modes){.residual = NAN, .orthogonality = NAN}; }

void sp_modes_free(sp_modes *m) {
    sp_free(m->omega); /* all arrays are one block */
    *m = sp_modes_none();
}

sp_modes_range sp_modes_range_all(void) { return (sp_modes_range){.to = HUGE_VAL}; }
sp_modes_range sp_modes_range_lowest(int64_t count) { return (sp_modes_range){.lowest = count, .to = HUGE_VAL}; }
sp_modes_range sp_modes_range_band(double from, double to) { return (sp_modes_range){.from = from, .to = to}; }

sp_damped_modes sp_damped_modes_none(void) { return (sp_damped_modes){0}; }

void sp_damped_modes_free(sp_damped_modes *m) {
    sp_free(m->omega); /* all arrays are one block */
    *m = sp_damped_modes_none();
}
