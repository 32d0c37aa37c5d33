/* Prints how fast waves decay in a chain of balls with random masses. */
#include "cli/chain_localised.h"

#include "base/base.h"

#include <math.h>
#include <sonopack/transport.h>

enum { FREQUENCIES_MAX = 1000 };

static sp_status rows(const chain_localised *of, int32_t n, const double *omega, const double *mass,
                      const double *spring, cli_writer *w) {
    for (int32_t l = 0; l < n && w->status == SP_OK; l++) {
        sp_localisation r;
        w->status = sp_localisation_chain(of->grains, mass, spring, omega[l], &r, w->err);
        const bool seen = w->status == SP_OK && r.gamma > 2 * r.gamma_err;
        const double length = seen ? 1 / r.gamma : NAN;
        if (w->status == SP_OK)
            w->status = sp_table_add_row(w->table, w->err, omega[l], r.gamma, r.gamma_err, length,
                                         length * length * r.gamma_err, 1 / (fmax(0, r.gamma) + 2 * r.gamma_err),
                                         sp_localisation_law(omega[l], 1, of->disorder * of->disorder, 1));
    }
    return w->status;
}

sp_status chain_localised_table(const chain_localised *of, cli_writer *w) {
    double omega[FREQUENCIES_MAX];
    int32_t n = 0;
    const size_t grains = (size_t)of->grains;
    w->status = cli_frequencies(of->at ? of->at : "0.1:1.9:19", FREQUENCIES_MAX, &n, omega, w->err);
    if (w->status != SP_OK)
        return w->status;
    double *mass = sp_alloc(2 * grains + 1, sizeof *mass);
    if (!mass)
        return sp_fail_memory(w->err, (2 * grains + 1) * sizeof *mass);
    double *spring = mass + grains;
    w->status = sp_localisation_masses(of->grains, of->disorder, (uint64_t)of->seed, mass, w->err);
    for (size_t j = 0; j <= grains; j++)
        spring[j] = 1;
    cli_comment(w, "grains = %lld", (long long)of->grains);
    cli_value(w, "disorder", of->disorder);
    cli_columns(w, SP_COLUMN_NUMBER, "omega", "c/l", "gamma", "1/l", "gamma_err", "1/l", "length", "l", "length_err",
                "l", "length_low", "l", "law", "1/l", NULL);
    rows(of, n, omega, mass, spring, w);
    sp_free(mass);
    return w->status;
}
