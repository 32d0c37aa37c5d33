/* The dashpots of the contacts as a network whose K is the damping matrix C. */
#include "base/base.h"
#include "network/bound.h"

#include <math.h>
#include <string.h>

static void *copy(const void *from, size_t count, size_t size) {
    void *to = sp_alloc(count, size);
    if (to)
        memcpy(to, from, count * size);
    return to;
}

sp_status sp_network_damping(const sp_network *net, double zeta, sp_network *out, sp_error *err) {
    const size_t n = (size_t)net->n, springs = (size_t)net->n_springs;
    sp_network c = *net;
    if (!(zeta > 0 && isfinite(zeta)))
        return sp_fail(err, SP_EINVAL, "damping = %g, must be a fraction of critical damping above 0", zeta);
    c.grain = copy(net->grain, n, sizeof *c.grain);
    c.mass = copy(net->mass, n * (size_t)net->dof, sizeof *c.mass);
    c.x = copy(net->x, 3 * n, sizeof *c.x);
    c.r = copy(net->r, n, sizeof *c.r);
    c.springs = copy(net->springs, springs, sizeof *c.springs);
    c.length = copy(net->length, springs, sizeof *c.length);
    c.carried = NULL;
    sp_status status = SP_OK;
    if (!c.grain || !c.mass || !c.x || !c.r || !c.springs || !c.length)
        status = sp_fail_memory(err, n * (size_t)(net->dof + 5) * sizeof(double) + springs * sizeof *c.springs);
    for (size_t k = 0; k < springs && status == SP_OK; k++) {
        sp_spring *s = &c.springs[k];
        const double mi = net->mass[(int64_t)s->i * net->dof];
        const double mj = s->j >= 0 ? net->mass[(int64_t)s->j * net->dof] : HUGE_VAL;
        const double reduced = s->j >= 0 ? mi / (mi + mj) * mj : mi;
        s->kn = 2 * zeta * sqrt(reduced * s->kn);
        s->kt = 2 * zeta * sqrt(reduced * s->kt);
        s->kp = 0;
    }
    c.prestress = false;
    if (status == SP_OK)
        status = sp_network_find_bounds(&c, err);
    if (status == SP_OK)
        *out = c;
    else
        sp_network_free(&c);
    return status;
}
