/* Free rotations of spheres with two contacts. */
#include "network/spins.h"

#include "base/base.h"

#include <math.h>

static void add_point(sp_spin *grain, const double n[3], double arm) {
    if (grain->springs < 2)
        for (int a = 0; a < 3; a++)
            grain->at[grain->springs][a] = arm * n[a];
    grain->springs++;
}

sp_status sp_spins_make(const sp_network *net, sp_spin **out, sp_error *err) {
    *out = NULL;
    if (net->dof < 6)
        return SP_OK;
    sp_spin *spin = sp_alloc((size_t)net->n, sizeof *spin);
    if (!spin)
        return sp_fail_memory(err, (size_t)net->n * sizeof *spin);
    for (int32_t k = 0; k < net->n_springs; k++) {
        const sp_spring *s = &net->springs[k];
        add_point(&spin[s->i], s->n, s->ri);
        if (s->j >= 0)
            add_point(&spin[s->j], s->n, -s->rj);
    }
    *out = spin;
    return SP_OK;
}

bool sp_spin_axis(const sp_spin *grain, double axis[3]) {
    double size = 0, arm = 0;
    for (int a = 0; a < 3; a++) {
        axis[a] = grain->at[1][a] - grain->at[0][a];
        size += axis[a] * axis[a];
        arm += grain->at[0][a] * grain->at[0][a];
    }
    for (int a = 0; a < 3 && size > 0; a++)
        axis[a] /= sqrt(size);
    return grain->springs == 2 && size > 1e-12 * arm;
}
