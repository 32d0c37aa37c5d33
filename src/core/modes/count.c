/* Counts the modes below a frequency by the inertia of K - omega^2 M. */
#include "modes/count.h"
#include "base/base.h"

#include <float.h>
#include <math.h>

void sp_scale_by_masses(const sp_network *net, sp_sparse *k) {
    for (int64_t c = 0; c < k->n; c++)
        for (int64_t q = k->p[c]; q < k->p[c + 1]; q++)
            k->x[q] /= sqrt(net->mass[c]) * sqrt(net->mass[k->i[q]]);
}

sp_status sp_network_discs(const sp_network *net, const double *source, const double *detector, bool vectors,
                           sp_discs *out, sp_error *err) {
    sp_sparse a = {0};
    sp_status status = sp_network_assemble_whole(net, &a, err);
    if (status == SP_OK) {
        sp_scale_by_masses(net, &a);
        status = sp_discs_make(&a, source, detector, vectors, out, err);
    }
    sp_sparse_free(&a);
    return status;
}

void sp_counter_free(counter *c) {
    sp_ldl_free(c->ldl);
    *c = (counter){0};
}

sp_status sp_counter_make(const sp_network *net, counter *out, sp_error *err) {
    sp_sparse a = {0};
    const double omega = sp_network_omega_bound(net);
    counter c = {.top = omega * omega};
    int64_t longest = 0;
    sp_status status = sp_network_assemble(net, &a, err);
    if (status != SP_OK)
        return status;
    sp_scale_by_masses(net, &a);
    for (int64_t k = 0; k < a.n; k++)
        longest = a.p[k + 1] - a.p[k] > longest ? a.p[k + 1] - a.p[k] : longest;
    /* An entry is a sum over a few springs, each within a few roundings of a diagonal entry, which is below top. A row
     * of the whole matrix has about twice the entries of a column of its lower triangle. */
    c.noise = DBL_EPSILON * c.top * 16 * sqrt(2 * (double)longest);
    status = sp_ldl_make(&a, net, &c.ldl, err);
    sp_sparse_free(&a);
    if (status == SP_OK)
        *out = c;
    else
        sp_counter_free(&c);
    return status;
}

/* Counts at limit + side x 64, 256, ... x noise, where errors of the factor and of the entries cannot move an
 * eigenvalue across the limit. Moves farther away if a pivot vanishes. */
static sp_status count_beside(const counter *c, double limit, double side, int64_t *count, sp_error *err) {
    enum { TRIES = 12 };
    double off = 64 * c->noise;
    for (int k = 0; k < TRIES; k++, off *= 4) {
        const double sigma = limit + side * off;
        sp_error reason = {0};
        const sp_status status = sp_ldl_factor(c->ldl, sigma, &reason);
        if (status != SP_OK && status != SP_EREFUSED) {
            if (err)
                *err = reason;
            return status;
        }
        if (status == SP_OK && sp_ldl_error(c->ldl) + c->noise < off) {
            *count = sp_ldl_negative(c->ldl);
            return SP_OK;
        }
    }
    return sp_fail(err, SP_EREFUSED, "the modes below omega = %.10g cannot be counted: pivots vanish there",
                   sqrt(limit));
}

sp_status sp_counter_below(const counter *c, double limit, int64_t *least, int64_t *most, sp_error *err) {
    sp_status status = count_beside(c, limit, -1, least, err);
    return status == SP_OK ? count_beside(c, limit, 1, most, err) : status;
}

sp_status sp_need_bounded(const sp_network *net, double until, sp_error *err) {
    counter c = {0};
    int64_t growing = 0;
    if (!net->prestress)
        return SP_OK;
    sp_status status = sp_counter_make(net, &c, err);
    if (status == SP_OK)
        status = count_beside(&c, -1 / (until * until), -1, &growing, err);
    sp_counter_free(&c);
    if (status == SP_OK && growing > 0)
        status =
            sp_fail(err, SP_EREFUSED, "%lld motions grow: the network is unstable (prestress)", (long long)growing);
    return status;
}
