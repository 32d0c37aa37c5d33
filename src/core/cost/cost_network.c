/* What results of a network will take: signals, modes, moduli, spectra. */
#include "cost/laws.h"
#include "signal/job.h"

#include <math.h>
#include <stddef.h>

static int dof_of(int dim, double friction) {
    const int turning = dim == 2 ? 1 : 3;
    return dim == 1 ? 1 : friction > 0 ? dim + turning : dim;
}

sp_network_size sp_network_size_of(const sp_network *net, double height) {
    return (sp_network_size){.dim = net->dim,
                             .grains = net->n,
                             .dofs = (double)sp_network_dofs(net),
                             .springs = net->n_springs,
                             .height = height,
                             .pressure = net->pressure,
                             .omega = sp_network_omega_bound(net)};
}

sp_network_size sp_network_size_expect(const sp_pack_spec *spec, const sp_packing_forecast *packing) {
    const double grains = spec->grains - packing->rattlers;
    /* measured at 1e-4; contacts stiffen as p^(1/3) */
    const double omega = (spec->dim == 3 ? 1.53 : spec->friction > 0 ? 1.4 : 0.8) * pow(spec->pressure / 1e-4, 1.0 / 6);
    return (sp_network_size){.dim = spec->dim,
                             .grains = grains,
                             .dofs = grains * dof_of(spec->dim, spec->friction),
                             .springs = packing->contacts,
                             .height = packing->height,
                             .pressure = spec->pressure,
                             .omega = omega};
}

static sp_cost one_thread(double seconds, double memory) { return (sp_cost){seconds, seconds, memory}; }

/* ---- signals ---------------------------------------------------------------------------------------------------- */

static sp_signal_method cheapest(const sp_signal_problem *p, const sp_signal_options *o) {
    static const sp_signal_method all[] = {SP_SIGNAL_CHEBYSHEV, SP_SIGNAL_FABER, SP_SIGNAL_DENSE, SP_SIGNAL_SPARSE};
    sp_signal_method best = all[0];
    for (size_t k = 1; k < sizeof all / sizeof *all; k++)
        if (sp_signal_problem_cost(all[k], p, o) < sp_signal_problem_cost(best, p, o))
            best = all[k];
    return best;
}

/* Terms of the expansions: chebyshev half a product each for a single pair; faber measured with damping 0.1. */
static double products_of(sp_signal_method method, double x, double passes) {
    if (method == SP_SIGNAL_CHEBYSHEV)
        return passes > 1 ? passes * (x + 6 * cbrt(x)) / 2 : x / 2 + 6 * cbrt(x) + 3;
    return method == SP_SIGNAL_FABER ? 4.7 * x + 420 : 0;
}

static double seconds_of_signal(sp_signal_method method, const sp_signal_problem *p, const sp_network_size *net,
                                sp_signal_options *o, double products, const sp_machine *machine) {
    switch (method) {
    case SP_SIGNAL_CHEBYSHEV:
        o->front = false;
        return 1e-9 * sp_signal_problem_cost(method, p, o) * machine->slower[SP_KERNEL_PRODUCT];
    case SP_SIGNAL_DENSE: return 1e-9 * sp_signal_problem_cost(method, p, o) * machine->slower[SP_KERNEL_DENSE];
    case SP_SIGNAL_FABER: return sp_law_seconds(SP_WORK_FABER, net->dofs, products, machine);
    case SP_SIGNAL_DYNAMICS:
        return sp_law_seconds(SP_WORK_VIBRATION, net->grains, net->omega * o->until, machine) *
               sqrt(1e-3 / fmax(o->tolerance, 1e-12));
    default: return NAN; /* time steps: their number depends on the rounding of the points */
    }
}

sp_cost sp_cost_signal(const sp_network_size *net, const sp_signal_options *opt, const sp_machine *machine,
                       sp_signal_method *method, double *products) {
    sp_signal_options o = *opt;
    const sp_signal_problem p = {.dofs = net->dofs, .springs = net->springs, .omega = net->omega, .dim = net->dim};
    if (o.until == 0)
        o.until = sp_signal_window(net->height, net->pressure);
    const double sources = o.from && o.sources > 0 ? o.sources : 1,
                 detectors = o.to && o.detectors > 0 ? o.detectors : 1;
    const sp_signal_method chosen = o.method == SP_SIGNAL_AUTO ? cheapest(&p, &o) : o.method;
    const double passes = sources * detectors > 1 ? ceil(fmin(sources, detectors) / 2) : 1;
    const double terms = products_of(chosen, net->omega * o.until, passes);
    double seconds;
    sp_cost modes = {0};
    if (chosen == SP_SIGNAL_SPARSE) { /* a tolerance below some percent needs nearly all modes */
        const sp_modes_options how = {.vectors = true, .solver = SP_SOLVER_LANCZOS, .threads = o.threads};
        const sp_modes_range range = o.modes > 0 ? sp_modes_range_lowest(o.modes) : sp_modes_range_all();
        modes = sp_cost_modes(net, &how, &range, net->dofs, machine);
        seconds = modes.cpu;
    } else {
        seconds = seconds_of_signal(chosen, &p, net, &o, terms, machine);
    }
    if (method)
        *method = chosen;
    if (products)
        *products = terms;
    const double dense = chosen == SP_SIGNAL_DENSE ? 24 * net->dofs * net->dofs : 0;
    return one_thread(seconds,
                      fmax(modes.memory, dense) + 200 * net->dofs + 16.0 * o.points * (1 + sources * detectors));
}

/* ---- modes ------------------------------------------------------------------------------------------------------ */

static double factor_bytes(const sp_network_size *net) {
    if (net->dim < 3)
        return 1000 * net->dofs * fmax(1, pow(net->dofs / 7000, 0.36));
    return 5400 * net->dofs * pow(net->dofs / 11500, 0.28);
}

/* Right-hand sides of Lanczos for so many modes, with their count and amplitudes. */
static double solves_of(double modes) { return 110 + 2.2 * modes; }

static double seconds_of_slices(const sp_network_size *net, double modes, const sp_machine *machine) {
    if (net->dim < 3)
        return sp_law_seconds(SP_WORK_SOLVES_DISKS, net->dofs, solves_of(modes), machine);
    return sp_law_seconds(SP_WORK_SOLVES_SPHERES, net->dofs, solves_of(modes), machine) +
           sp_law_seconds(SP_WORK_FACTORS_SPHERES, net->dofs, 3 + modes / 200, machine);
}

/* As sp_modes_make decides. */
static bool is_dense(const sp_network_size *net, const sp_modes_options *o, bool all, double modes) {
    const double n = net->dofs, reach = o->vectors ? 2200 : 5500;
    if (o->solver != SP_SOLVER_AUTO)
        return o->solver == SP_SOLVER_DENSE;
    if (all)
        return n <= (o->vectors ? 5000 : net->dim > 2 ? 8000 : 5000);
    return n <= 400 || (n <= SP_MODES_DENSE_MAX && modes * reach > n * n);
}

static sp_cost dense_modes(const sp_network_size *net, bool vectors, const sp_machine *machine) {
    const double n = net->dofs;
    return one_thread(sp_law_seconds(vectors ? SP_WORK_VECTORS : SP_WORK_FREQUENCIES, n, 1, machine),
                      (vectors ? 24 : 12) * n * n + 9e6);
}

sp_cost sp_cost_modes(const sp_network_size *net, const sp_modes_options *o, const sp_modes_range *range,
                      double expected, const sp_machine *machine) {
    const bool all = range->lowest == 0 && range->from == 0 && isinf(range->to);
    const double modes = all ? net->dofs : range->lowest > 0 ? (double)range->lowest : fmin(expected, net->dofs);
    if (is_dense(net, o, all, modes))
        return dense_modes(net, o->vectors, machine);
    const bool pieces = modes > 512 && o->solver != SP_SOLVER_ARPACK; /* which threads share */
    const double threads = pieces && o->threads > 1 ? o->threads : 1;
    const double search = 34 * fmin(modes, 128) + (pieces && o->vectors ? 8 * 512 : 0);
    sp_cost out = {.memory = threads * (factor_bytes(net) + search * net->dofs) + 9e6};
    if (o->vectors)
        out.memory += 8 * modes * net->dofs;
    out.cpu = all && !o->vectors
                  ? sp_law_seconds(net->dim < 3 ? SP_WORK_PIECES_DISKS : SP_WORK_PIECES_SPHERES, net->dofs, 1, machine)
                  : seconds_of_slices(net, modes, machine);
    out.wall = out.cpu / threads;
    return out;
}

/* ---- other results ---------------------------------------------------------------------------------------------- */

sp_cost sp_cost_result(sp_network_result what, const sp_network_size *net, double count, const sp_machine *machine) {
    static const struct {
        sp_work disks, spheres;
        double factors; /* real ones; a complex one takes two */
    } works[SP_RESULTS] = {
        [SP_RESULT_NETWORK] = {SP_WORK_NETWORK, SP_WORK_NETWORK, 0},
        [SP_RESULT_STATICS] = {SP_WORK_STATICS, SP_WORK_STATICS, 0},
        [SP_RESULT_MODULI] = {SP_WORK_MODULI, SP_WORK_MODULI_SPHERES, 1},
        [SP_RESULT_PROBES] = {SP_WORK_MODULI, SP_WORK_MODULI_SPHERES, 1},
        [SP_RESULT_DENSITY] = {SP_WORK_DENSITY, SP_WORK_DENSITY, 0},
        [SP_RESULT_TRANSMISSION] = {SP_WORK_TRANSMISSION, SP_WORK_TRANSMISSION, 0},
        [SP_RESULT_DISPERSION] = {SP_WORK_DISPERSION, SP_WORK_DISPERSION, 0},
        [SP_RESULT_HARMONIC] = {SP_WORK_HARMONIC, SP_WORK_HARMONIC_SPHERES, 2},
        [SP_RESULT_CONTINUUM] = {SP_WORK_CONTINUUM, SP_WORK_CONTINUUM, 1},
        [SP_RESULT_SAMPLE] = {SP_WORK_SAMPLE, SP_WORK_SAMPLE, 0},
    };
    const double seconds =
        sp_law_seconds(net->dim < 3 ? works[what].disks : works[what].spheres, net->dofs, count, machine);
    const double often = what == SP_RESULT_PROBES ? 4 : 1; /* each about as long as the moduli */
    return one_thread(often * seconds, 300 * net->dofs + works[what].factors * factor_bytes(net));
}

/* ---- files ------------------------------------------------------------------------------------------------------ */

double sp_bytes_packing(int dim, double grains, double contacts) {
    const double arrays = grains * (8 * dim + 17) + contacts * (16 * dim + 24);
    return 8755 + arrays + fmin(19500, fmax(0, 0.035 * (arrays - 1.1e5)));
}

double sp_bytes_packing_text(int dim, double grains, double contacts) {
    return 300 + grains * (dim + 1) * 20.0 + contacts * (dim * 20 + 60.0);
}

double sp_bytes_table(double rows, int columns) { return 400 + 20.5 * rows * columns; }
