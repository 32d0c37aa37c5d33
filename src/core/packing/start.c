/* Initial states of a compression: a gas, an expanded lattice, or a packing. */
#include "base/base.h"
#include "packing/compression.h"
#include "packing/contact.h"
#include "packing/dynamics.h"
#include "packing/prepare.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Unless contacts need a shorter one. Uses a stiffness that the packing certainly reaches: that of one grain that
 * carries p d^2. */
static double first_step(const compression *run) {
    const double p = run->spec->pressure, a = run->spec->law_exponent, e = contact_stiffness(0.5, 0.5);
    const double overlap = a == 1.5 ? contact_overlap(e, p) : pow(p / contact_strength(0.5, 0.5, a), 1 / a);
    return 0.1 * sqrt(run->d.m_min / (a == 1.5 ? contact_normal_stiffness(e, overlap) : a * p / overlap));
}

/* Gas, compaction and creep of 600 grains take 1e5 steps at p = 1e-4 and 3e5 at 1e-7 by the slower protocol, more with
 * the height in grains and with their mass ratio. Cells without a piston need fewer at 1e-4 and more at small
 * pressures: 60 disks in a periodic cell 1e4, 9e5 at 1e-7 and 1.9e7 at 1e-9. After forty times as many steps the
 * packing will not come to rest. */
static int64_t default_max_steps(const compression *run) {
    const sp_pack_spec *spec = run->whole;
    const double diameter = sp_sizes_moment(spec, 1);
    const double power = spec->cell == SP_CELL_PISTON ? -0.3 : -0.5;
    double layers = fmax(1.0, run->start_height / (75.0 * diameter)), slowness = 0;
    for (int32_t stage = 0; stage < sp_pack_stages(spec); stage++)
        slowness += fmax(1, pow(sp_pack_stage_pressure(spec, stage) / 1e-4, power));
    double roughness = pow(spec->diameter_max / spec->diameter_min, 1.5) * 0.1 / spec->time_step;
    const double slow = spec->strain_rate > 0 ? fmax(1, 1e-3 / spec->strain_rate) : 1;
    return (int64_t)fmin(4e6 * layers * slowness * slow * fmax(1, roughness), 1e18);
}

/* ---- order in memory ----------------------------------------------------------------------------------------- */

typedef struct numbered {
    int64_t cell[3];
    int32_t id;
} numbered;

static int by_place(const void *one, const void *two) {
    const numbered *a = one, *b = two;
    for (int k = 0; k < 3; k++)
        if (a->cell[k] != b->cell[k])
            return a->cell[k] < b->cell[k] ? -1 : 1;
    return a->id < b->id ? -1 : 1;
}

/* Orders the grains by layer, row and column of the compressed packing, so that neighbours are close in memory. id[k]
 * is the grain at place k. */
static sp_status number_by_place(const sp_pack_spec *spec, const double *x, double height, int32_t *id, sp_error *err) {
    const int up = spec->dim - 1;
    const double layers = fmax(1, spec->grains / (spec->width * (up == 2 ? spec->depth : 1)));
    numbered *p = sp_alloc((size_t)spec->grains, sizeof *p);
    if (!p)
        return sp_fail_memory(err, (size_t)spec->grains * sizeof *p);
    for (int32_t i = 0; i < spec->grains; i++) {
        const double *at = x + 3 * (size_t)i;
        p[i].id = i;
        p[i].cell[0] = (int64_t)floor(at[up] / height * layers);
        p[i].cell[1] = up == 2 ? (int64_t)floor(at[1]) : 0;
        p[i].cell[2] = (int64_t)floor(at[0] * 1024);
    }
    qsort(p, (size_t)spec->grains, sizeof *p, by_place);
    for (int32_t k = 0; k < spec->grains; k++)
        id[k] = p[k].id;
    sp_free(p);
    return SP_OK;
}

static void reorder(const int32_t *id, int32_t n, const double *r, const double *x, double *r_new, double *x_new) {
    for (int32_t k = 0; k < n; k++) {
        r_new[k] = r[id[k]];
        memcpy(x_new + 3 * (size_t)k, x + 3 * (size_t)id[k], 3 * sizeof *x);
    }
}

static sp_status place_types(compression *run, const sp_pack_spec *spec, sp_error *err) {
    int32_t *type = sp_types_draw(spec), *placed = sp_alloc((size_t)spec->grains, sizeof *placed);
    sp_status status = type && placed ? SP_OK : sp_fail_memory(err, (size_t)spec->grains * 2 * sizeof *type);
    for (int32_t k = 0; k < spec->grains && status == SP_OK; k++)
        placed[k] = type[run->id[k]];
    if (status == SP_OK)
        sp_dynamics_set_types(&run->d, spec, placed);
    sp_free(placed);
    sp_free(type);
    return status;
}

/* Creates the dynamics of grains at x with radii r, given in packing order, and chooses their order in memory. */
static sp_status place_grains(compression *run, const sp_pack_spec *spec, const double *r, const double *x,
                              double height, sp_error *err) {
    const size_t n = (size_t)spec->grains;
    double *scratch = sp_alloc(4 * n, sizeof *scratch);
    run->id = sp_alloc(n, sizeof *run->id);
    sp_status status = scratch && run->id ? SP_OK : sp_fail_memory(err, n * 36);
    if (status == SP_OK)
        status = number_by_place(spec, x, height, run->id, err);
    if (status == SP_OK) {
        reorder(run->id, spec->grains, r, x, scratch, scratch + n);
        status = sp_dynamics_make(spec, scratch, scratch + n, height, &run->d, err);
    }
    if (status == SP_OK && spec->types.fractions > 0)
        status = place_types(run, spec, err);
    run->start_height = height;
    run->start_period[0] = spec->width;
    run->start_period[1] = spec->depth;
    sp_free(scratch);
    return status;
}

/* ---- starts -------------------------------------------------------------------------------------------------- */

static sp_status start_gas(compression *run, double *r, double *x, sp_error *err) {
    double height = 0;
    sp_radii_draw(run->spec, r);
    const sp_pack_spec gas = sp_cell_spec_gas(run->spec);
    sp_status status = sp_gas_make_watched(&gas, run->hooks, r, x, &height, err);
    return status == SP_OK ? place_grains(run, &gas, r, x, height, err) : status;
}

static sp_status start_lattice(compression *run, double *r, double *x, sp_error *err) {
    sp_lattice_start lattice;
    sp_status status = sp_triangular_start(run->spec, r, x, &lattice, err);
    if (status != SP_OK)
        return status;
    sp_pack_spec blown_up = *run->spec;
    blown_up.width = lattice.width;
    run->period_end[0] = lattice.width_end;
    return place_grains(run, &blown_up, r, x, lattice.height, err);
}

/* Transfers the tangential forces of a packing's contacts to grains that have just been placed. */
static sp_status set_forces(compression *run, const sp_packing *from, sp_error *err) {
    dynamics *d = &run->d;
    int32_t *at = sp_alloc((size_t)d->n, sizeof *at), count = 0;
    pair_force *force = sp_alloc((size_t)from->n_contacts, sizeof *force);
    sp_status status = at && force ? SP_OK : sp_fail_memory(err, (size_t)from->n_contacts * sizeof *force);
    if (status != SP_OK)
        goto out;
    for (int32_t k = 0; k < d->n; k++)
        at[run->id[k]] = k;
    for (int32_t c = 0; c < from->n_contacts; c++) {
        const sp_contact *k = &from->contacts[c];
        if (k->j < 0) {
            const wall_frame frame = dynamics_wall(d, -1 - k->j);
            double *ft = d->wall_ft[-1 - k->j] + (int64_t)(d->dim - 1) * at[k->i];
            for (int a = 0; a < d->dim - 1; a++)
                ft[a] = k->ft[frame.along[a]];
            continue;
        }
        pair_force *f = &force[count++];
        *f = (pair_force){.i = at[k->i], .j = at[k->j], .ft = {k->ft[0], k->ft[1], k->ft[2]}};
        if (d->dim == 2)
            f->ft[0] = k->ft[1] * k->n[0] - k->ft[0] * k->n[1];
    }
    status = sp_pairs_set_forces(d, force, count, err);
out:
    sp_free(force);
    sp_free(at);
    return status;
}

/* Finds the stable step before anything moves: a step of length zero finds the stiffest grain. */
static sp_status measure_step(compression *run, sp_error *err) {
    dynamics *d = &run->d;
    sp_status status = sp_neighbours_refresh(d, err);
    if (status != SP_OK)
        return status;
    sp_dynamics_forces(d, 0);
    sp_dynamics_advance(d, 0);
    const double rate = d->plain ? sqrt(d->k_max / d->m_min) / 0.04 : d->rate / 0.1; /* stable for any damping */
    d->dt = rate > 0 ? fmin(first_step(run), 1 / rate) : first_step(run);
    return SP_OK;
}

static sp_status start_packing(compression *run, sp_error *err) {
    const sp_packing *from = run->hooks->from;
    sp_status status = place_grains(run, run->spec, from->r, from->x, sp_packing_height(from), err);
    if (status == SP_OK)
        status = set_forces(run, from, err);
    if (status != SP_OK)
        return status;
    run->d.pressure = from->cell == SP_CELL_PISTON ? from->pressure : run->spec->pressure;
    memcpy(run->d.tilt, from->tilt, sizeof from->tilt);
    run->phase = PHASE_COMPACTION;
    run->lateral_free = run->spec->compression == SP_COMPRESSION_ISOTROPIC;
    return measure_step(run, err);
}

/* ---- all together -------------------------------------------------------------------------------------------- */

/* Initial pressure. A faster piston would push grains through each other where it hits them, and small grains between
 * large ones first, because these pass their load on to them. The pressure rises to its full value once the piston
 * rests on the grains. */
static double gentle_pressure(const compression *run) {
    const double small = run->spec->diameter_min / run->d.scale;
    return 1e-3 * run->d.law.softest * fmin(1, 4 * small * small);
}

static sp_status start_new(compression *run, sp_error *err) {
    const size_t n = (size_t)run->spec->grains;
    double *r = sp_alloc(n, sizeof *r), *x = sp_alloc(3 * n, sizeof *x);
    sp_status status = r && x ? SP_OK : sp_fail_memory(err, n * 32);
    if (status != SP_OK)
        goto out;
    switch (run->spec->kind) {
    case SP_PACK_FILE: status = start_packing(run, err); break;
    case SP_PACK_TRIANGULAR: status = start_lattice(run, r, x, err); break;
    default: status = start_gas(run, r, x, err); break;
    }
    if (status == SP_OK && run->spec->kind != SP_PACK_FILE) {
        run->d.dt = first_step(run);
        if (run->d.cell == SP_CELL_PISTON)
            run->d.pressure = fmin(run->d.pressure, gentle_pressure(run));
    }
out:
    sp_free(x);
    sp_free(r);
    return status;
}

sp_status sp_compression_start(compression *run, sp_error *err) {
    const sp_pack_spec *spec = run->whole;
    sp_compression_set_stage(run);
    sp_status status = run->hooks->state ? sp_state_load(run, err) : start_new(run, err);
    if (status == SP_OK)
        sp_compression_squeeze(run);
    if (status == SP_OK && spec->grains >= (spec->dim == 3 ? 3000 : 5000))
        status = sp_pool_make(run->hooks->threads, &run->d.pool, err);
    run->r_min = 0.5 * spec->diameter_min;
    if (status == SP_OK)
        run->max_steps = spec->max_steps ? spec->max_steps : default_max_steps(run);
    return status;
}

void sp_compression_free(compression *run) {
    sp_dynamics_free(&run->d);
    sp_free(run->id);
    run->id = NULL;
}
