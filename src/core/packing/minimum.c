/* Smooth packings as minima of the energy: grains at random places in a periodic cell move downhill until they rest, in
 * a cell of fixed size, or in one whose size makes the pressure that is wanted (O'Hern et al., Phys. Rev. E 68, 011306,
 * 2003). The forces are F = 4/3 E12 R12^(2 - a) n^a with an exponent a: harmonic grains for 1, Hertz's for 3/2.
 *
 * The method is FIRE (Bitzek et al., Phys. Rev. Lett. 97, 170201, 2006) in the form of Guenole et al. (Comput. Mater.
 * Sci. 175, 109584, 2020): a motion of unit masses whose velocity is turned towards the force, and which stops where it
 * would go uphill. The logarithm of the cell's edges is one more coordinate. */
#include "packing/minimum.h"

#include "base/base.h"
#include "linalg/arrays.h"
#include "numeric/random.h"
#include "packing/contact.h"
#include "packing/geometry.h"
#include "packing/prepare.h"
#include "packing/types.h"

#include <math.h>
#include <string.h>

enum { LATENCY = 20, REPORT = 1024, TENSOR = MINIMUM_TENSOR };
static const double GROW = 1.1, SHRINK = 0.5, TURN = 0.25, TURN_LESS = 0.99;
/* Fraction of a first, rough minimum where the pressure is given, by dimension. */
static const double DENSE[] = {0, 1, 0.9, 0.7};
static const int64_t STEPS_MOST = 20000000;
static const double ROUGH = 1e-2;    /* acceleration over the pressure in the first minimum */
static const double MOST_FLOW = 0.5; /* shear strain after which a stress counts as one that the grains do not carry */
static const double BARE = 1e-10;    /* the pressure where no grains touch */

/* Of two vectors of the grains and of the cell. */
static double dot(const minimum *m, const double *a, const double *b, const double *a_cell, const double *b_cell) {
    double sum = 0;
    for (int c = 0; c < TENSOR; c++)
        sum += a_cell[c] * b_cell[c];
    for (size_t k = 0; k < 3 * (size_t)m->p.n; k++)
        sum += a[k] * b[k];
    return sum;
}

/* v = (1 - turn) (v + dt f) + turn |v| f/|f|. */
static void push(minimum *m, double dt, double turn) {
    for (size_t k = 0; k < 3 * (size_t)m->p.n; k++)
        m->v[k] += dt * m->f[k];
    for (int c = 0; c < TENSOR; c++)
        m->v_cell[c] += dt * m->f_cell[c];
    const double force = sqrt(dot(m, m->f, m->f, m->f_cell, m->f_cell));
    const double speed = sqrt(dot(m, m->v, m->v, m->v_cell, m->v_cell));
    const double along = force > 0 ? turn * speed / force : 0;
    for (size_t k = 0; k < 3 * (size_t)m->p.n; k++)
        m->v[k] = (1 - turn) * m->v[k] + along * m->f[k];
    for (int c = 0; c < TENSOR; c++)
        m->v_cell[c] = (1 - turn) * m->v_cell[c] + along * m->f_cell[c];
}

static sp_status report(const minimum *m, sp_error *err) {
    const sp_pack_progress progress = {.phase = "equilibration",
                                       .steps = m->steps,
                                       .height = sp_packing_height(&m->p),
                                       .residual = m->residual,
                                       .fraction = NAN};
    if (!m->hooks->watch || m->hooks->watch(&progress, m->hooks->user))
        return SP_OK;
    return sp_fail(err, SP_EINTERRUPTED, "stopped after %lld steps", (long long)m->steps);
}

static sp_status come_apart(const minimum *m, sp_error *err) {
    if (m->strained != 0)
        return sp_fail_key(err, SP_EFAILED, "packing.path.strain",
                           ": at %.6g of it the packing has come apart: the pressure fell below %g E*", m->strained,
                           BARE);
    return sp_fail_key(err, SP_EFAILED, "packing.fraction",
                       " = %g: is too little for a rigid packing: the pressure fell below %g E*", m->spec->fraction,
                       BARE);
}

/* Smooth grains carry little shear: a cell that gives way without end is none. */
static sp_status check_flow(const minimum *m, sp_error *err) {
    double mean = 0, worst = 0;
    for (int a = 0; a < m->p.dim; a++)
        mean += m->flow[a] / m->p.dim;
    for (int c = 0; c < TENSOR && m->cell == CELL_YIELDS; c++)
        worst = fmax(worst, fabs(m->flow[c] - (c < m->p.dim ? mean : 0)));
    if (worst < MOST_FLOW)
        return SP_OK;
    return sp_fail_key(err, SP_EFAILED, "packing.stress",
                       ": the grains do not carry it: they have flowed by a shear strain of %.2g, and hold xx = %.4g, "
                       "yy = %.4g, zz = %.4g, yz = %.4g, xz = %.4g, xy = %.4g: must be nearer to isotropic",
                       worst, m->stress[0], m->stress[1], m->stress[2], m->stress[3], m->stress[4], m->stress[5]);
}

static sp_status descend(minimum *m, sp_error *err) {
    const int64_t most = m->spec->max_steps > 0 ? m->spec->max_steps : STEPS_MOST;
    const int64_t begin = m->steps;
    double dt = 0, turn = TURN;
    int64_t downhill = 0;
    for (; m->steps < begin + most; m->steps++) {
        const bool first = m->steps == begin;
        sp_status status = first ? sp_minimum_list(m, err) : sp_minimum_refresh(m, err);
        if (status == SP_OK)
            status = check_flow(m, err);
        if (status == SP_OK && m->steps % REPORT == 0)
            status = report(m, err);
        if (status != SP_OK)
            return status;
        sp_minimum_forces(m);
        /* only a cell whose grains are jammed adapts itself: one that springs open heats them, and they may order */
        if (m->cell == CELL_FIXED && m->residual <= ROUGH * m->pressure)
            m->cell = m->wanted;
        if (m->wanted == CELL_FIXED && m->pressure < BARE)
            return come_apart(m, err);
        if (sp_minimum_at_rest(m))
            return SP_OK;
        const double longest = 0.7 / sqrt(fmax(2 * m->stiffest, 1e-12)); /* omega_max^2 <= 2 max sum k */
        dt = first ? 0.1 * longest : fmin(dt, longest);
        if (dot(m, m->f, m->v, m->f_cell, m->v_cell) > 0) {
            if (++downhill > LATENCY) {
                dt = fmin(GROW * dt, longest);
                turn *= TURN_LESS;
            }
        } else {
            if (m->steps > begin + LATENCY && dt > 0.02 * longest)
                dt *= SHRINK;
            downhill = 0;
            turn = TURN;
            sp_minimum_move(m, -0.5 * dt);
            memset(m->v, 0, 3 * (size_t)m->p.n * sizeof *m->v);
            memset(m->v_cell, 0, sizeof m->v_cell);
        }
        push(m, dt, turn);
        sp_minimum_move(m, dt);
    }
    return sp_fail(err, SP_EFAILED,
                   "not at rest after %lld steps: the largest acceleration is %.3g, must be below %.3g",
                   (long long)most, m->residual, m->spec->tolerance);
}

/* Radii and cell: those of another packing, or of the spec. Returns the volume of the grains. */
static double take_cell(minimum *m) {
    const sp_pack_spec *s = m->spec;
    const sp_packing *from = m->hooks->from;
    const double height = sp_cell_spec_height(s), edges[] = {s->width, s->dim == 3 ? s->depth : height, height};
    double solid = 0;
    if (from)
        memcpy(m->p.r, from->r, (size_t)from->n * sizeof *from->r);
    else
        sp_radii_draw(s, m->p.r);
    for (int32_t i = 0; i < m->p.n; i++)
        solid += s->dim == 2 ? 3.14159265358979323846 * m->p.r[i] * m->p.r[i] : grain_mass(m->p.r[i]);
    memcpy(m->p.box, from ? from->box : edges, (size_t)s->dim * sizeof *edges);
    if (from)
        memcpy(m->p.tilt, from->tilt, sizeof from->tilt);
    return solid;
}

/* The places of another packing, or random ones, in a cell of the fraction that is given, or that is usual. */
static sp_status start(minimum *m, sp_error *err) {
    const sp_pack_spec *s = m->spec;
    const sp_packing *from = m->hooks->from;
    const int dim = s->dim;
    const size_t n = (size_t)s->grains;
    m->type = sp_types_draw(s);
    sp_status status =
        m->type ? sp_packing_alloc(&m->p, dim, s->grains, 0, err) : sp_fail_memory(err, n * sizeof *m->type);
    if (status != SP_OK)
        return status;
    m->p.cell = SP_CELL_PERIODIC;
    const double solid = take_cell(m), fraction = s->fraction > 0 ? s->fraction : DENSE[dim];
    double volume = 1;
    for (int a = 0; a < dim; a++)
        volume *= m->p.box[a];
    const double scale = from && s->fraction == 0 ? 1 : pow(solid / fraction / volume, 1.0 / dim);
    for (int a = 0; a < dim; a++)
        m->p.box[a] *= scale;
    for (int k = 0; k < 3; k++)
        m->p.tilt[k] *= scale;
    sp_random stream = sp_random_make(s->seed, SP_STREAM_GAS);
    for (size_t i = 0; i < n; i++)
        for (size_t a = 0; a < (size_t)dim; a++)
            m->p.x[3 * i + a] = from ? from->x[3 * i + a] * scale : m->p.box[a] * sp_random_uniform(&stream);
    m->skin = 0.3 * s->diameter_min;
    m->unit = dim * sqrt((double)n);
    const sp_array arrays[] = {{&m->v, 3 * n}, {&m->f, 3 * n}, {&m->old, 3 * n}, {&m->stiff, n}, {0}};
    return sp_arrays_make(arrays, &m->memory, err);
}

/* The packing with its contacts. Those of another law than Hertz's have stiffnesses of their own. */
static sp_status finish(const minimum *m, sp_packing *out, sp_error *err) {
    int32_t count = 0;
    double d[3];
    sp_packing p = sp_packing_none();
    for (int64_t q = 0; q < m->pairs; q++)
        count += sqrt(sp_minimum_separation(m, &m->pair[q], d)) < m->pair[q].reach;
    sp_status status = sp_packing_alloc(&p, m->p.dim, m->p.n, count, err);
    if (status != SP_OK)
        return status;
    memcpy(p.x, m->p.x, 3 * (size_t)p.n * sizeof *p.x);
    memcpy(p.r, m->p.r, (size_t)p.n * sizeof *p.r);
    memcpy(p.box, m->p.box, sizeof p.box);
    memcpy(p.tilt, m->p.tilt, sizeof p.tilt);
    sp_packing_untilt(p.dim, p.box, p.tilt);
    p.cell = SP_CELL_PERIODIC;
    p.pressure = m->pressure;
    p.poisson = m->spec->poisson;
    p.seed = m->spec->seed;
    p.steps = m->steps;
    p.residual = m->residual;
    count = 0;
    for (int64_t q = 0; q < m->pairs; q++) {
        const pair *c = &m->pair[q];
        const double r = sqrt(sp_minimum_separation(m, c, d)), overlap = c->reach - r;
        if (!(overlap > 0))
            continue;
        sp_contact *to = &p.contacts[count++];
        to->i = c->i;
        to->j = c->j;
        for (int b = 0; b < p.dim; b++)
            to->n[b] = d[b] / r;
        to->overlap = overlap;
        to->fn = sp_minimum_force(m, c, overlap);
    }
    for (int32_t i = 0; i < p.n; i++)
        sp_packing_wrap(&p, p.x + 3 * (size_t)i);
    sp_packing_sort(&p);
    status = sp_types_finish(m->spec, m->type, &p, err);
    if (status == SP_OK)
        *out = p;
    else
        sp_packing_free(&p);
    return status;
}

/* Sets what the cell does, and strains it by a step of the path. */
static void begin_stage(minimum *m, int32_t k) {
    const sp_pack_spec *s = m->spec;
    const bool path = k > s->history_count;
    const double to = sp_path_place(s, k), step = to - m->strained;
    double e[TENSOR];
    cell_strain by = {.grow = {1, 1, 1}};
    m->aim = sp_pack_stage_pressure(s, k);
    memset(m->flow, 0, sizeof m->flow);
    sp_stress_target(s, m->aims);
    sp_path_strain(s, e);
    bool some = false;
    for (int c = 0; c < TENSOR; c++) {
        m->aims[c] *= m->aim / s->pressure;
        m->free[c] = sp_tensor_has(s->dim, c) && (path ? sp_path_frees(s, c) : s->stress_count > 0);
        some = some || m->free[c];
    }
    m->wanted = some ? CELL_YIELDS : path || s->fraction > 0 ? CELL_FIXED : CELL_GROWS;
    if (k > 0)
        m->cell = m->wanted;
    for (int a = 0; a < s->dim; a++)
        by.grow[a] = exp(-step * e[a]);
    for (int a = 0; a < 3; a++)
        by.shear[a] = -step * e[5 - a];
    m->strained = to;
    if (path)
        sp_minimum_deform(m, &by);
}

static sp_status report_stage(const minimum *m, int32_t k, sp_error *err) {
    sp_packing p = sp_packing_none();
    if (!m->hooks->stage)
        return SP_OK;
    sp_status status = finish(m, &p, err);
    if (status == SP_OK)
        status = m->hooks->stage(&p, k, m->hooks->user, err);
    sp_packing_free(&p);
    return status;
}

sp_status sp_minimum_make(const sp_pack_spec *spec, const sp_pack_hooks *hooks, sp_packing *out, sp_error *err) {
    minimum m = {.spec = spec, .hooks = hooks, .p = sp_packing_none()};
    const int32_t stages = sp_pack_stages(spec);
    sp_status status = start(&m, err);
    for (int32_t k = 0; k < stages && status == SP_OK; k++) {
        begin_stage(&m, k);
        status = descend(&m, err);
        if (status == SP_OK && k < stages - 1)
            status = report_stage(&m, k, err);
    }
    if (status == SP_OK)
        status = finish(&m, out, err);
    sp_packing_free(&m.p);
    sp_free(m.pair);
    sp_free(m.type);
    sp_free(m.memory);
    return status;
}
