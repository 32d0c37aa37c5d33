/* Moduli of parts of a packing: each spring's change of stress, shared among the parts that its branch line crosses. */
#include "base/base.h"
#include "base/vector.h"
#include "elastic/moduli.h"
#include "network/network_cell.h"
#include "packing/geometry.h"

#include <math.h>

/* The parts: equal cells of a grid. Places are in cells, along the lattice vectors. */
typedef struct grid {
    int32_t cells[3];
    double across[3][3]; /* place along axis a = across[a] . x */
    bool around[3];      /* the axis is periodic */
    double volume;       /* of a part [d^3] */
} grid;

/* Sums for the bounds of the errors of the stresses in a part. */
typedef struct bounds {
    double size[STRAINS_3D], affine[STRAINS_3D];
} bounds;

/* ---- the grid ---------------------------------------------------------------------------------------------------- */

static sp_status make_grid(const sp_network *net, double width, grid *g, sp_error *err) {
    double mean = 0, count = 1;
    *g = (grid){.cells = {1, 1, 1}};
    for (int32_t i = 0; i < net->n; i++)
        mean += 2 * net->r[i] / net->n;
    if (net->cell == SP_CELL_RING)
        return sp_cell_need_flat(net->cell, "a grid of parts", err);
    if (net->dim == 1)
        return sp_fail(err, SP_EREFUSED, "local moduli need two or three dimensions, this is a chain");
    if (!(width >= mean))
        return sp_fail(err, SP_EINVAL,
                       "local moduli of parts %.3g d wide: must be at least the mean diameter of the grains, %.3g d",
                       width, mean);
    for (int a = 0; a < net->dim; a++) {
        g->cells[a] = (int32_t)fmax(1, round(net->box[a] / width));
        g->around[a] = sp_network_periodic(net, a);
        sp_network_reciprocal(net, a, g->across[a]);
        for (int b = 0; b < 3; b++)
            g->across[a][b] *= g->cells[a];
        count *= g->cells[a];
    }
    g->volume = sp_network_volume(net) / count;
    return SP_OK;
}

/* Index of the part at a place; what is outside of walls by rounding belongs to the part there. */
static int64_t part_at(const grid *g, const int32_t place[3]) {
    int64_t index = 0;
    for (int a = 2; a >= 0; a--) {
        const int32_t n = g->cells[a], at = place[a];
        index = index * n + (g->around[a] ? (at % n + n) % n : at < 0 ? 0 : at < n ? at : n - 1);
    }
    return index;
}

static void find_centre(const sp_network *net, const grid *g, int64_t index, double x[3]) {
    x[0] = x[1] = x[2] = 0;
    for (int a = 0; a < net->dim; a++) {
        sp_network_move(net, a, ((double)(index % g->cells[a]) + 0.5) / g->cells[a], x);
        index /= g->cells[a];
    }
}

/* ---- sums -------------------------------------------------------------------------------------------------------- */

/* s: [strains] what the spring adds for each strain; share: of its branch line in the part. */
static void add_share(const sp_strain_part *s, double share, int64_t at, sp_local_moduli *m, bounds *sums) {
    double *c = m->c + at * m->strains * m->strains;
    m->contacts[at] += share;
    for (int a = 0; a < m->strains; a++) {
        double most = 0;
        for (int b = 0; b < m->strains; b++) {
            c[a * m->strains + b] += share * s[b].stress[a];
            most = fmax(most, s[b].size[a]);
        }
        sums[at].size[a] += share * most;
        sums[at].affine[a] += share * s[0].affine[a]; /* not its square: the line may come back around the cell */
    }
}

/* Walks along the branch line of a spring, from one face of the grid to the next. */
static void add_spring(const sp_network *net, const grid *g, int32_t k, const sp_strain_part *s, sp_local_moduli *m,
                       bounds *sums) {
    const sp_spring *spring = &net->springs[k];
    double start[3] = {0}, rate[3] = {0}, from = 0;
    int32_t at[3] = {0};
    for (int a = 0; a < net->dim; a++) {
        start[a] = dot3(g->across[a], net->x + 3 * (int64_t)spring->i);
        rate[a] = net->length[k] * dot3(g->across[a], spring->n);
        at[a] = (int32_t)floor(start[a]);
    }
    for (int axis = 0; axis >= 0;) {
        double to = 1;
        axis = -1;
        for (int a = 0; a < net->dim; a++) {
            const double face = rate[a] == 0 ? 1 : (at[a] + (rate[a] > 0) - start[a]) / rate[a];
            if (face < to) {
                to = face;
                axis = a;
            }
        }
        to = fmax(from, to);
        add_share(s, to - from, part_at(g, at), m, sums);
        from = to;
        if (axis >= 0)
            at[axis] += rate[axis] > 0 ? 1 : -1;
    }
}

static void add_all(const sp_network *net, const grid *g, const bool *allowed, const double *u, sp_local_moduli *m,
                    bounds *sums) {
    const int64_t n = sp_network_dofs(net);
    for (int32_t k = 0; k < net->n_springs; k++) {
        sp_strain_part s[STRAINS_3D];
        for (int b = 0; b < m->strains; b++)
            sp_strain_part_of(net, k, b, u + b * n, &s[b]);
        add_spring(net, g, k, s, m, sums);
    }
    for (int32_t i = 0; i < net->n; i++) {
        int32_t at[3] = {0};
        for (int a = 0; a < net->dim; a++)
            at[a] = (int32_t)floor(dot3(g->across[a], net->x + 3 * (int64_t)i));
        m->grains[part_at(g, at)]++;
    }
    for (int64_t q = 0; q < (int64_t)m->n * m->strains * m->strains; q++)
        m->c[q] = allowed[q % m->strains] && allowed[q / m->strains % m->strains] ? m->c[q] / g->volume : NAN;
}

/* ---- errors ------------------------------------------------------------------------------------------------------ */

/* The energy norm of the error K^-1 rest of u, with the rounding of the rest. The error of a stress is g . (K^-1 rest)
 * for g = B^T k d, and g . K^-1 g <= d . k d, since what is taken off is a projection: so Cauchy and Schwarz bound the
 * error of every part by one number for the strain. Floppy motions have no energy. Those as soft as the shift of the
 * factor move half as far with it: hence 2. work: [4][n]. */
static double error_norm(sp_equilibrium *e, int strain, const double *u, double *work) {
    const int64_t n = sp_network_dofs(e->net);
    double *f = work, *rest = work + n, *size = work + 2 * n, *back = work + 3 * n, sum[STRAINS_3D];
    const double noise = sp_strain_noise(e->net);
    sp_strain_load(e->net, strain, f);
    sp_equilibrium_residual(e, f, u, rest);
    sp_strain_rounding(e->net, strain, u, size, sum);
    for (int64_t k = 0; k < n; k++)
        rest[k] += copysign(noise * size[k], rest[k]);
    sp_equilibrium_apply(e, rest, back);
    return 2 * sqrt(fmax(0, sp_network_energy2(e->net, back)));
}

static void bound_errors(const sp_network *net, const grid *g, double norm, const bounds *sums, sp_local_moduli *m) {
    for (int32_t q = 0; q < m->n; q++)
        for (int a = 0; a < m->strains; a++)
            m->error[q] = fmax(m->error[q],
                               (sqrt(sums[q].affine[a]) * norm + sp_strain_noise(net) * sums[q].size[a]) / g->volume);
}

/* ---- both -------------------------------------------------------------------------------------------------------- */

/* K and G of the parts: the tensor's averages as of the whole, and the whole's term of the pressure. */
static void find_averages(const sp_network *net, const sp_elasticity *whole, sp_local_moduli *m) {
    const int dim = net->dim, s = m->strains;
    for (int32_t q = -1; q < m->n; q++) {
        const double *c = q < 0 ? m->whole : m->c + (int64_t)q * s * s;
        double own = 0, cross = 0, shears = 0;
        for (int a = 0; a < s; a++)
            for (int b = 0; b < s; b++)
                if (a < dim && b < dim)
                    *(a == b ? &own : &cross) += c[a * s + b];
                else if (a == b)
                    shears += c[a * s + b];
        const double bulk = (own + cross) / (dim * dim);
        const double shear = dim == 2 ? (own - cross + 4 * shears) / 8 : (own - 0.5 * cross + 3 * shears) / 15;
        if (q < 0) {
            m->whole_bulk = whole->bulk - bulk;
            m->whole_shear = whole->shear - shear;
        } else {
            m->bulk[q] = bulk + m->whole_bulk;
            m->shear[q] = shear + m->whole_shear;
        }
    }
    m->whole_bulk = whole->bulk;
    m->whole_shear = whole->shear;
}

static void keep_whole(const sp_network *net, const sp_stiffness *s, sp_elasticity *whole, sp_local_moduli *m) {
    sp_elasticity_from(net, s, whole);
    for (int a = 0; a < m->strains; a++)
        for (int b = 0; b < m->strains; b++) {
            m->whole[a * m->strains + b] = whole->c[a][b];
            m->whole_error = fmax(m->whole_error, whole->error[a][b]);
        }
}

static sp_status fill(sp_equilibrium *e, const grid *g, double *work, bounds *sums, sp_local_moduli *m, sp_error *err) {
    const sp_network *net = e->net;
    const int64_t n = sp_network_dofs(net);
    bool allowed[STRAINS_3D];
    double *u = work + 4 * n, norm = 0;
    sp_stiffness s;
    sp_elasticity whole;
    if (e->spins > 0)
        return sp_fail(err, SP_EREFUSED,
                       "local moduli with prestress and friction: %d spheres with two contacts spin freely, and the "
                       "stress around them is undefined",
                       e->spins);
    sp_status status = sp_stiffness_of(e, work, &s, err);
    if (status != SP_OK)
        return status;
    for (int b = 0; b < m->strains; b++)
        if ((allowed[b] = sp_strain_allowed(net, b, e->grips)))
            norm = fmax(norm, error_norm(e, b, u + b * n, work));
    keep_whole(net, &s, &whole, m);
    add_all(net, g, allowed, u, m, sums);
    bound_errors(net, g, norm, sums, m);
    for (int32_t q = 0; q < m->n; q++)
        find_centre(net, g, q, m->x + 3 * (int64_t)q);
    find_averages(net, &whole, m);
    return SP_OK;
}

sp_local_moduli sp_local_moduli_none(void) { return (sp_local_moduli){0}; }

void sp_local_moduli_free(sp_local_moduli *m) {
    sp_free(m->x); /* all arrays are one block */
    *m = sp_local_moduli_none();
}

static sp_status allocate(const sp_network *net, const grid *g, sp_local_moduli *m, sp_error *err) {
    const int strains = sp_strain_count(net);
    const size_t n = (size_t)g->cells[0] * (size_t)g->cells[1] * (size_t)g->cells[2];
    const size_t tensor = (size_t)(strains * strains), size = n * (8 + tensor) + tensor;
    *m = (sp_local_moduli){.n = (int32_t)n, .strains = strains, .x = sp_alloc(size, sizeof *m->x)};
    if (!m->x)
        return sp_fail_memory(err, size * sizeof *m->x);
    m->c = m->x + 3 * n;
    m->bulk = m->c + n * tensor;
    m->shear = m->bulk + n;
    m->error = m->shear + n;
    m->grains = m->error + n;
    m->contacts = m->grains + n;
    m->whole = m->contacts + n;
    m->edge_x = net->box[0] / g->cells[0];
    m->edge_y = net->box[1] / g->cells[1];
    m->edge_z = net->dim == 3 ? net->box[2] / g->cells[2] : NAN;
    return SP_OK;
}

sp_status sp_local_moduli_make(const sp_network *net, double width, sp_local_moduli *out, sp_error *err) {
    sp_equilibrium e = sp_equilibrium_none();
    sp_local_moduli m = sp_local_moduli_none();
    double *work = NULL;
    bounds *sums = NULL;
    grid g;
    sp_status status = make_grid(net, width, &g, err);
    if (status == SP_OK)
        status = allocate(net, &g, &m, err);
    if (status == SP_OK &&
        (!(work = sp_alloc(sp_stiffness_work(net), sizeof *work)) || !(sums = sp_alloc((size_t)m.n, sizeof *sums))))
        status = sp_fail_memory(err, sp_stiffness_work(net) * sizeof *work);
    if (status == SP_OK)
        status = sp_equilibrium_make(net, &e, err);
    if (status == SP_OK)
        status = fill(&e, &g, work, sums, &m, err);
    sp_equilibrium_free(&e);
    sp_free(sums);
    sp_free(work);
    if (status == SP_OK)
        *out = m;
    else
        sp_local_moduli_free(&m);
    return status;
}
