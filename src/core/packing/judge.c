#include <math.h>
#include <sonopack/packing.h>
#include <stddef.h>
#include <stdio.h>
#include <string.h>

/* The relative errors of an audit, in the order of reporting. */
static const struct measure {
    size_t offset;
    const char *fault;
} measures[] = {
    {offsetof(sp_audit, geometry_residual), "overlaps do not follow from the positions"},
    {offsetof(sp_audit, law_residual), "normal forces do not follow from the overlaps (Hertz)"},
    {offsetof(sp_audit, force_residual), "forces on a grain do not balance"},
    {offsetof(sp_audit, torque_residual), "torques on a grain do not balance"},
    {offsetof(sp_audit, coulomb_excess), "a tangential force is above friction times the normal force"},
    {offsetof(sp_audit, wall_residual), "the force on a wall is not pressure times area"},
};

double sp_audit_worst(const sp_audit *audit, double tolerance, char *reason, size_t size) {
    double largest = 0;
    *reason = '\0';
    if (audit->missing > 0)
        snprintf(reason, size, "%d pairs overlap that are not listed as contacts: must be 0", audit->missing);
    for (size_t k = 0; k < sizeof measures / sizeof *measures; k++) {
        double value;
        memcpy(&value, (const char *)audit + measures[k].offset, sizeof value);
        if (!(value <= largest))
            largest = isnan(largest) ? largest : value;
        if (!(value <= tolerance) && *reason == '\0')
            snprintf(reason, size, "%s: relative error %.3g, must be at most %.3g", measures[k].fault, value,
                     tolerance);
    }
    return largest;
}
