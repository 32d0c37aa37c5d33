/* Where the time of a compression goes:
 *     packing_loops [--most GRAINS] [--whole GRAINS] [TSV]
 *
 * phase: whole compressions of `whole` grains (2000), by phase. `serial` is the share of the CPU time that one thread
 * spends outside of the parts that a pool of threads would share, in percent.
 * loop: the loops of a step, and what is done now and then, on packings of up to `most` grains (100 000). They are a
 * small packing beside itself, as often as it takes, stirred a little. A call of `refill` makes new inner lists, of
 * `rebuild` new outer and inner ones, of `inspect` the checks of every 40 steps.
 * bound: `one block` is the pair loop on the same 128 pairs again and again, which are then in the nearest cache: what
 * the arithmetic takes. `copy` is memcpy of as many bytes as the pair and grain loops must read and write in a step.
 *
 * Everything runs on one thread, times are CPU times: of loops and bounds the least of several rounds. */
#include "base/base.h"
#include "base/pool.h"
#include "packing/compression.h"
#include "packing/dynamics.h"
#include "packing/kernel.h"
#include "packing/prepare.h"

#include <math.h>
#include <sonopack/version.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { ROUNDS = 7 };

/* The linker sends all calls of sp_pool_run here, so that the time in them is known. */
void __real_sp_pool_run(sp_pool *pool, sp_pool_work work, void *data);
void __wrap_sp_pool_run(sp_pool *pool, sp_pool_work work, void *data);
static double shared_seconds;

void __wrap_sp_pool_run(sp_pool *pool, sp_pool_work work, void *data) {
    const double start = sp_clock_cpu();
    __real_sp_pool_run(pool, work, data);
    shared_seconds += sp_clock_cpu() - start;
}

/* ---- the table ------------------------------------------------------------------------------------------------- */

typedef struct row {
    const char *kind, *what;
    int dim;
    double friction;
    int32_t grains;
    double contacts, calls, seconds; /* contacts: closed pairs; seconds of all calls */
    double shared;                   /* seconds in parts that threads share; -1: not known */
} row;

static void write_row(FILE *out, const row *r) {
    fprintf(out, "%s\t%d\t%g\t%d\t%s\t%.0f\t%.0f\t%.3f\t%.4g\t%.4g\t", r->kind, r->dim, r->friction, (int)r->grains,
            r->what, r->contacts, r->calls, 1e6 * r->seconds / r->calls, r->grains * r->calls / r->seconds,
            r->contacts * r->calls / r->seconds);
    if (r->shared >= 0)
        fprintf(out, "%.2f\n", 100 * (1 - r->shared / r->seconds));
    else
        fprintf(out, "nan\n");
    fflush(out);
}

/* ---- phases ---------------------------------------------------------------------------------------------------- */

static sp_pack_spec spec_of(int dim, double friction, int32_t grains, double pressure) {
    sp_pack_spec s = sp_pack_spec_default();
    s.dim = dim;
    s.grains = grains;
    s.friction = friction;
    s.pressure = pressure;
    s.seed = 1;
    s.width = dim == 2 ? sqrt(0.96 * grains) : cbrt(0.5 * grains);
    s.tolerance = 1e-3 * pressure;
    return s;
}

enum { PHASES = 3 };
static const char *const PHASE_NAMES[PHASES] = {"flight", "compaction", "equilibration"};

typedef struct phases {
    double seconds[PHASES], shared[PHASES], steps[PHASES];
    double seconds_then, shared_then, steps_then;
} phases;

static bool watch_phase(const sp_pack_progress *progress, void *user) {
    phases *p = user;
    const double seconds = sp_clock_cpu();
    for (int k = 0; k < PHASES; k++)
        if (strcmp(progress->phase, PHASE_NAMES[k]) == 0) {
            p->seconds[k] += seconds - p->seconds_then;
            p->shared[k] += shared_seconds - p->shared_then;
            p->steps[k] += (double)progress->steps - p->steps_then;
        }
    p->seconds_then = sp_clock_cpu();
    p->shared_then = shared_seconds;
    p->steps_then = (double)progress->steps;
    return true;
}

static sp_status time_phases(int dim, double friction, int32_t grains, FILE *out, sp_error *err) {
    const sp_pack_spec spec = spec_of(dim, friction, grains, 1e-4);
    phases p = {.seconds_then = sp_clock_cpu(), .shared_then = shared_seconds};
    const sp_pack_hooks hooks = {.watch = watch_phase, .user = &p};
    sp_packing made = sp_packing_none();
    sp_status status = sp_packing_make_with(&spec, &hooks, &made, err);
    for (int k = 0; k < PHASES && status == SP_OK; k++)
        if (p.steps[k] > 0)
            write_row(out, &(row){"phase", PHASE_NAMES[k], dim, friction, grains, made.n_contacts, p.steps[k],
                                  p.seconds[k], p.shared[k]});
    sp_packing_free(&made);
    return status;
}

/* ---- large packings -------------------------------------------------------------------------------------------- */

/* The packing beside itself: `times` copies along each horizontal axis. Contacts are left out. */
static sp_status tile(const sp_packing *p, int32_t times, sp_packing *out, sp_error *err) {
    const int32_t depth = p->dim == 3 ? times : 1, copies = times * depth;
    sp_status status = sp_packing_alloc(out, p->dim, copies * p->n, 0, err);
    if (status != SP_OK)
        return status;
    for (int32_t c = 0; c < copies; c++)
        for (int32_t i = 0; i < p->n; i++) {
            double *x = out->x + 3 * ((size_t)c * (size_t)p->n + (size_t)i);
            memcpy(x, p->x + 3 * (size_t)i, 3 * sizeof *x);
            x[0] += c % times * p->box[0];
            x[1] += p->dim == 3 ? c / times * p->box[1] : 0;
            out->r[c * p->n + i] = p->r[i];
        }
    memcpy(out->box, p->box, sizeof p->box);
    out->box[0] *= times;
    out->box[1] *= p->dim == 3 ? times : 1;
    out->pressure = p->pressure;
    out->friction = p->friction;
    out->poisson = p->poisson;
    return SP_OK;
}

static double noise(void) { return (double)rand() / RAND_MAX - 0.5; }

/* Grains that move as slowly as in the middle of the equilibration. */
static void stir(dynamics *d) {
    for (int32_t i = 0; i < d->n; i++)
        for (int a = 0; a < d->dim; a++)
            dynamics_grain(d, i)[d->at.v + a] = 1e-5 * noise();
    d->v_max = 1e-5;
    d->dt = 1;
}

static double closed_pairs(const dynamics *d) {
    double closed = 0;
    for (int32_t k = 0; k < d->inner.n; k++) {
        const double *g = dynamics_grain(d, d->inner.i[k]), *h = dynamics_grain(d, d->inner.j[k]);
        double square = 0;
        for (int a = 0; a < d->dim; a++) {
            const double image = a < d->dim - 1 ? d->inner.image[k + (int64_t)a * d->inner.capacity] : 0;
            const double x = h[a] - g[a] + (image != 0 ? image * d->period[a] : 0);
            square += x * x;
        }
        closed += square < d->inner.reach[k] * d->inner.reach[k];
    }
    return closed;
}

/* ---- loops ----------------------------------------------------------------------------------------------------- */

typedef enum loop { PAIRS, MOVE, FORCES, ADVANCE, REFILL, REBUILD, INSPECT, ONE_BLOCK, COPY, LOOPS } loop;
static const char *const LOOP_NAMES[LOOPS] = {"pairs",   "grains",  "forces",    "advance", "refill",
                                              "rebuild", "inspect", "one block", "copy"};

static void run_pairs(dynamics *d, bool same) {
    for (int32_t first = 0; first < d->inner.padded; first += BLOCK) {
        const int32_t left = d->inner.padded - first;
        (d->dim == 2 ? sp_kernel_pairs_2d : sp_kernel_pairs_3d)(d, 0.1, same ? 0 : first, left < BLOCK ? left : BLOCK);
    }
}

/* Bytes of pairs, rows and grains that one step reads or writes, each once. */
static size_t bytes_of_step(const dynamics *d) {
    const size_t pair = 2 * 4 + 8 * (size_t)(3 + (d->dim - 1) + 2 * d->at.forces) + 4 * 8 * (size_t)d->at.row;
    return (size_t)d->inner.n * pair + (size_t)d->n * 8 * 3 * (size_t)d->at.stride;
}

static sp_status run_loop(dynamics *d, loop which, void *from, void *to, sp_error *err) {
    double residual, imbalance;
    switch (which) {
    case PAIRS: run_pairs(d, false); break;
    case ONE_BLOCK: run_pairs(d, true); break;
    case MOVE: (d->dim == 2 ? sp_kernel_move_2d : sp_kernel_move_3d)(d, 0, 0, d->n); break;
    case FORCES: sp_dynamics_forces(d, 0.1); break;
    case ADVANCE: sp_dynamics_advance(d, 0); break;
    case REFILL: d->inner_travel = INFINITY; return sp_neighbours_refresh(d, err);
    case REBUILD: d->outer_travel = INFINITY; return sp_neighbours_refresh(d, err);
    case INSPECT:
        if (!sp_dynamics_sane(d))
            return sp_fail(err, SP_EFAILED, "the grains went through each other");
        return sp_dynamics_residual(d, &residual, &imbalance, err);
    default:
        memcpy(to, from, bytes_of_step(d) / 2);
        __asm__ volatile("" : : "r"(to) : "memory"); /* or all copies but one would be left out */
    }
    return SP_OK;
}

/* Least time of a call. Several calls in a row, so that a clock's tick is nothing beside them. */
static sp_status time_loop(dynamics *d, loop which, void *from, void *to, row *r, sp_error *err) {
    const int calls = 1 + 100000 / d->n;
    double least = HUGE_VAL, shared = 0;
    sp_status status = SP_OK;
    for (int round = 0; round < ROUNDS && status == SP_OK; round++) {
        const double start = sp_clock_cpu(), shared_then = shared_seconds;
        for (int call = 0; call < calls && status == SP_OK; call++)
            status = run_loop(d, which, from, to, err);
        const double seconds = (sp_clock_cpu() - start) / calls;
        shared = seconds < least ? (shared_seconds - shared_then) / calls : shared;
        least = fmin(least, seconds);
    }
    r->calls = 1;
    r->seconds = least;
    r->shared = which >= FORCES && which <= INSPECT ? shared : -1;
    return status;
}

static sp_status time_loops(const sp_packing *p, FILE *out, sp_error *err) {
    sp_pack_spec spec = sp_pack_spec_default();
    spec.kind = SP_PACK_FILE;
    const sp_pack_hooks hooks = {.from = p};
    compression run = {.hooks = &hooks};
    void *from = NULL, *to = NULL;
    sp_status status = sp_pack_spec_from(&spec, p, err);
    spec.friction = p->friction;
    spec.pressure = p->pressure;
    spec = sp_pack_spec_resolve(&spec);
    run.whole = &spec;
    if (status == SP_OK)
        status = sp_compression_start(&run, err);
    if (status == SP_OK) {
        stir(&run.d);
        run.d.outer_travel = INFINITY;
        status = sp_neighbours_refresh(&run.d, err);
    }
    if (status == SP_OK) {
        from = sp_alloc(bytes_of_step(&run.d), 1);
        to = sp_alloc(bytes_of_step(&run.d), 1);
        status = from && to ? SP_OK : sp_fail_memory(err, 2 * bytes_of_step(&run.d));
    }
    row r = {.dim = p->dim, .friction = p->friction, .grains = p->n};
    if (status == SP_OK) {
        r.contacts = closed_pairs(&run.d);
        memset(from, 1, bytes_of_step(&run.d));
        fprintf(stderr, "%dD, %d grains: %d pairs listed far, %d near, %.0f closed\n", p->dim, (int)p->n,
                (int)run.d.outer.n, (int)run.d.inner.n, r.contacts);
    }
    for (int k = 0; k < LOOPS && status == SP_OK; k++) {
        r.kind = k >= ONE_BLOCK ? "bound" : "loop";
        r.what = LOOP_NAMES[k];
        status = time_loop(&run.d, (loop)k, from, to, &r, err);
        if (status == SP_OK)
            write_row(out, &r);
    }
    sp_free(from);
    sp_free(to);
    sp_compression_free(&run);
    return status;
}

/* Packings of 600 disks or 1000 spheres, and larger ones made of them. */
static sp_status all_sizes(int dim, double friction, int32_t most, FILE *out, sp_error *err) {
    const sp_pack_spec spec = spec_of(dim, friction, dim == 2 ? 600 : 1000, 1e-3);
    static const int32_t TIMES[2][4] = {{1, 5, 17, 167}, {1, 2, 3, 10}};
    sp_packing p = sp_packing_none();
    sp_status status = sp_packing_make(&spec, NULL, NULL, &p, err);
    for (int k = 0; k < 4 && status == SP_OK; k++) {
        const int32_t times = TIMES[dim - 2][k];
        if (p.n * times * (dim == 3 ? times : 1) > most + most / 100)
            break;
        sp_packing large = sp_packing_none();
        status = tile(&p, times, &large, err);
        if (status == SP_OK)
            status = time_loops(&large, out, err);
        sp_packing_free(&large);
    }
    sp_packing_free(&p);
    return status;
}

int main(int argc, char **argv) {
    int32_t most = 100000, whole = 2000;
    int at = 1;
    for (; at + 1 < argc && argv[at][0] == '-'; at += 2)
        *(strcmp(argv[at], "--most") == 0 ? &most : &whole) = atoi(argv[at + 1]);
    FILE *out = at < argc ? fopen(argv[at], "w") : stdout;
    sp_error err = {0};
    sp_status status = SP_OK;
    if (!out)
        return 1;
    fprintf(out, "# sonopack %s\n# units: us [us] grain_steps_per_s [1/s] contacts_per_s [1/s] serial [%%]\n",
            sp_version());
    fprintf(out, "kind\tdim\tmu\tgrains\twhat\tcontacts\tcalls\tus\tgrain_steps_per_s\tcontacts_per_s\tserial\n");
    for (int dim = 2; dim <= 3 && status == SP_OK; dim++)
        for (int rough = 1; rough >= 0 && status == SP_OK; rough--) {
            if (whole > 0)
                status = time_phases(dim, 0.5 * rough, whole, out, &err);
            if (status == SP_OK)
                status = all_sizes(dim, 0.5 * rough, most, out, &err);
        }
    if (status != SP_OK)
        fprintf(stderr, "packing_loops: %s\n", err.text);
    return status == SP_OK && fflush(out) == 0 ? 0 : 1;
}
