/* The packings that a run makes one after another: at the pressures of its history, and along a path of strain. */
#include "base/base.h"
#include "packing/prepare.h"

#include <math.h>

enum { STAGES_MOST = 1000000 };

static double turn_of(const sp_pack_spec *s, int32_t k) { return s->turn_count > 0 ? s->turns[k] : 1; }

/* With its sign. */
static double largest_strain(const sp_pack_spec *s) {
    double largest = 0;
    for (int32_t c = 0; c < s->strain_count; c++)
        largest = fabs(s->strain[c]) > fabs(largest) ? s->strain[c] : largest;
    return largest;
}

/* Steps of the path from 0 to 1. */
static double unit_steps(const sp_pack_spec *s) {
    return s->strain_steps > 0 ? s->strain_steps : fmax(1, ceil(fabs(largest_strain(s)) / 1e-3 - 1e-6));
}

/* Steps of one leg of the path, from one turn to the next; the last may be a shorter one. */
static double leg_steps(const sp_pack_spec *s, int32_t leg) {
    const double from = leg > 0 ? turn_of(s, leg - 1) : 0;
    const double length = fabs(turn_of(s, leg) - from);
    return length > 0 ? fmax(1, ceil(length * unit_steps(s) - 1e-6)) : 0;
}

static int32_t legs_of(const sp_pack_spec *s) {
    return s->strain_count == 0 ? 0 : s->turn_count > 0 ? s->turn_count : 1;
}

static double all_steps(const sp_pack_spec *s) {
    double steps = 0;
    for (int32_t leg = 0; leg < legs_of(s); leg++)
        steps += leg_steps(s, leg);
    return steps;
}

int32_t sp_pack_stages(const sp_pack_spec *s) {
    const int32_t all = 1 + s->history_count + (int32_t)fmin(all_steps(s), STAGES_MOST);
    return s->stages > 0 && s->stages < all ? s->stages : all;
}

double sp_pack_stage_pressure(const sp_pack_spec *s, int32_t stage) {
    return stage < s->history_count ? s->history[stage] : s->pressure;
}

double sp_path_place(const sp_pack_spec *s, int32_t stage) {
    double left = stage - s->history_count, from = 0;
    for (int32_t leg = 0; leg < legs_of(s) && left > 0; leg++) {
        const double steps = leg_steps(s, leg), to = turn_of(s, leg);
        if (left < steps)
            return from + copysign(left / unit_steps(s), to - from);
        left -= steps;
        from = to;
    }
    return from;
}

double sp_pack_stage_strain(const sp_pack_spec *s, int32_t stage) {
    return sp_path_place(s, stage) * largest_strain(s);
}

bool sp_path_frees(const sp_pack_spec *s, int component) {
    double strain[6];
    sp_path_strain(s, strain);
    return s->lateral == SP_LATERAL_STRESS && strain[component] == 0;
}

void sp_path_strain(const sp_pack_spec *s, double strain[6]) {
    for (int c = 0; c < 6; c++)
        strain[c] = 0;
    sp_tensor_fill(s->dim, s->strain_count, s->strain, strain);
}

static sp_status check_strain(const sp_pack_spec *s, sp_error *err) {
    const double largest = fabs(largest_strain(s));
    const sp_status status = sp_tensor_check("packing.path.strain", s->dim, s->strain_count, s->strain, err);
    if (status != SP_OK)
        return status;
    for (int c = 0; c < s->strain_count; c++)
        if (s->cell == SP_CELL_BOX && c >= s->dim && s->strain[c] != 0)
            return sp_fail_key(err, SP_EINVAL, "packing.path.strain",
                               ": its shear must be 0 for packing.cell = \"box\", whose walls do not tilt");
    if (largest == 0)
        return sp_fail_key(err, SP_EINVAL, "packing.path.strain", ": at least one component must not be 0");
    if (largest / unit_steps(s) > 0.02 * (1 + 1e-9))
        return sp_fail_key(err, SP_EINVAL, "packing.path.steps",
                           " = %d: steps of a strain of %.3g: must be at least %.0f, for steps of 0.02",
                           s->strain_steps, largest / unit_steps(s), ceil(largest / 0.02));
    if (all_steps(s) > STAGES_MOST)
        return sp_fail_key(err, SP_EINVAL, "packing.path.steps", " = %d: the path has %.3g steps, must have at most %d",
                           s->strain_steps, all_steps(s), STAGES_MOST);
    return SP_OK;
}

sp_status sp_path_check(const sp_pack_spec *s, sp_error *err) {
    if (s->strain_count == 0 && (s->turn_count > 0 || s->lateral != SP_LATERAL_FIXED || s->strain_steps != 0))
        return sp_fail_key(err, SP_EINVAL, "packing.path.strain", ": must be given where packing.path has other keys");
    if (s->strain_count != 0 && (s->cell == SP_CELL_PISTON || s->dim < 2))
        return sp_fail_key(
            err, SP_EINVAL, "packing.path.strain",
            ": must be empty for packing.cell = \"piston\"; must be \"periodic\" or \"box\" to be strained");
    if (s->lateral == SP_LATERAL_STRESS && s->fraction > 0)
        return sp_fail_key(err, SP_EINVAL, "packing.path.lateral",
                           " = \"stress\": must be \"fixed\" where a packing.fraction is given in place of a pressure");
    sp_status status = s->strain_count != 0 ? check_strain(s, err) : SP_OK;
    if (status != SP_OK || s->stages <= 1 + s->history_count + all_steps(s))
        return status;
    return sp_fail_key(err, SP_EINVAL, "packing.stages", " = %d: must be at most %.0f, the packings of the path, or 0",
                       s->stages, 1 + s->history_count + all_steps(s));
}
