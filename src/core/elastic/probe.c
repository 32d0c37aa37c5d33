/* Apparent moduli on smaller scales, from the elastic energy of a static response (Somfai et al. 2005, Appendix B). In
 * 2D, energies are those of a layer one diameter thick. In 3D, the area of the walls replaces L1 in (B2) and (B3). */
#include "base/base.h"
#include "base/vector.h"
#include "elastic/moduli.h"
#include "elastic/strain.h"
#include "network/apply.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

static const double PI = 3.14159265358979323846;

static double height_of(const sp_network *net, int32_t i) { return net->x[3 * (int64_t)i + net->dim - 1]; }

/* ---- the sine ------------------------------------------------------------------------------------------------- */

/* The body force (B1) on each grain, f0 = 1. */
static void body_force(const sp_equilibrium *e, double phi3s, int n, int axis, double *f) {
    const sp_network *net = e->net;
    const double wave = n * PI / net->box[net->dim - 1];
    const bool cosine = e->slips && axis != net->dim - 1;
    memset(f, 0, (size_t)sp_network_dofs(net) * sizeof *f);
    for (int32_t i = 0; i < net->n; i++) {
        const double r = net->r[i], y = height_of(net, i), volume = 4 * PI / 3 * (r * r * r) / phi3s;
        f[(int64_t)i * net->dof + axis] = volume * (cosine ? cos(wave * y) : sin(wave * y));
    }
}

/* Subtracts the net force, as a uniform acceleration along axis. */
static void drop_net_force(const sp_network *net, int axis, double *f) {
    double force = 0, mass = 0;
    for (int32_t i = 0; i < net->n; i++) {
        force += f[(int64_t)i * net->dof + axis];
        mass += net->mass[(int64_t)i * net->dof + axis];
    }
    for (int32_t i = 0; i < net->n; i++)
        f[(int64_t)i * net->dof + axis] -= force / mass * net->mass[(int64_t)i * net->dof + axis];
}

/* Square of a load in the metric of the inverse masses. */
static double square_of(const sp_network *net, const double *f) {
    double sum = 0;
    for (int64_t k = 0; k < sp_network_dofs(net); k++)
        sum += f[k] * f[k] / net->mass[k];
    return sum;
}

/* The part of the load f that accelerates floppy parts. For small s, s M (K + s M)^-1 f keeps the load on a motion that
 * K does not resist, and almost nothing else. v: [n] scratch. */
static void find_floppy(const sp_equilibrium *e, const double *f, double *floppy, double *v) {
    enum { PASSES = 4 };
    const int64_t n = sp_network_dofs(e->net);
    memcpy(floppy, f, (size_t)n * sizeof *f);
    for (int pass = 0; pass < PASSES; pass++) {
        sp_equilibrium_apply(e, floppy, v);
        for (int64_t k = 0; k < n; k++)
            floppy[k] = e->shift * e->net->mass[k] * v[k];
    }
}

/* Removes from f the part that accelerates floppy parts, and adds it to `removed`. Repetition removes what rounding
 * leaves. work: [2][n]. *share: the removed part of the square of f. */
static void drop_floppy(const sp_equilibrium *e, double *f, double *work, double *removed, double *share) {
    enum { TURNS = 3 };
    const int64_t n = sp_network_dofs(e->net);
    double *floppy = work;
    const double whole = square_of(e->net, f);
    for (int turn = 0; turn < TURNS; turn++) {
        find_floppy(e, f, floppy, work + n);
        if (turn == 0) {
            const double part = square_of(e->net, floppy) / whole;
            if (!(part > 1e-20)) /* rounding errors only: there is nothing floppy to remove */
                break;
            *share = fmax(*share, part);
        }
        for (int64_t k = 0; k < n; k++) {
            f[k] -= floppy[k];
            removed[k] += floppy[k];
        }
    }
}

/* Removes from f what turns the spins that are held. */
static void drop_spins(const sp_equilibrium *e, double *f, double *share) {
    const double whole = square_of(e->net, f);
    double part = 0;
    for (int32_t s = 0; s < e->spins; s++) {
        const equilibrium_spin *spin = &e->spin[s];
        const double *mass = e->net->mass + spin->column;
        double work = 0, inertia = 0;
        for (int a = 0; a < spin->width; a++) {
            work += f[spin->column + a] * spin->motion[a];
            inertia += mass[a] * spin->motion[a] * spin->motion[a];
        }
        for (int a = 0; a < spin->width; a++)
            f[spin->column + a] -= work / inertia * mass[a] * spin->motion[a];
        part += work * work / inertia;
    }
    *share = fmax(*share, part / whole);
}

/* Solves K u = f without motion of floppy parts, which the rest of the load on them would move far: removes their
 * motion from u, and corrects u. work: [3][n]. */
static sp_status solve_sine(sp_equilibrium *e, int n, const double *f, double *u, double *work, sp_error *err) {
    const int64_t dofs = sp_network_dofs(e->net);
    const double load = sp_norm(dofs, f);
    double *momentum = work, *floppy = work + dofs, residual;
    char what[32];
    memset(u, 0, (size_t)dofs * sizeof *u);
    sp_status status = sp_equilibrium_solve(e, f, load, u, &residual, err);
    if (status == SP_OK && e->shift_kind == SHIFT_MASS) {
        for (int64_t k = 0; k < dofs; k++)
            momentum[k] = e->net->mass[k] * u[k];
        find_floppy(e, momentum, floppy, work + 2 * dofs);
        for (int64_t k = 0; k < dofs; k++)
            u[k] -= floppy[k] / e->net->mass[k];
        status = sp_equilibrium_solve(e, f, load, u, &residual, err);
    }
    if (status != SP_OK || residual < 1e-8 * load)
        return status;
    snprintf(what, sizeof what, "probe sine:%d", n);
    return sp_equilibrium_refuse(e, what, load, f, u, err);
}

/* Twice the energy is f . u. Its error is w . (K u - f) to first order, plus rounding, and its change if the spins that
 * are held turn. strain: of the wave, for unit energy. work: [3][n]. */
static sp_status sine_energy(sp_equilibrium *e, const double *f, const double *u, double strain, double *work,
                             double *energy, double *error, sp_error *err) {
    const int64_t n = sp_network_dofs(e->net);
    const double noise = sp_strain_noise(e->net);
    double *rest = work, *size = work + n, off = 0;
    const double *w = u; /* the weights of a residual in f . u: for symmetric K, u itself */
    sp_status status = SP_OK;
    if (e->net->carried) {
        status = sp_equilibrium_weights(e, f, sp_norm(n, f), work + 2 * n, err);
        w = work + 2 * n;
    }
    *energy = 0.5 * sp_dot(n, f, u);
    *error = sp_equilibrium_spin_work(e, sp_equilibrium_spin_rest(e, f, w), strain * *energy, u);
    sp_equilibrium_residual(e, f, u, rest);
    sp_strain_rounding(e->net, -1, u, size, NULL);
    for (int64_t k = 0; k < n; k++)
        off += fabs(w[k]) * (fabs(rest[k]) + noise * (size[k] + fabs(f[k])));
    *error += off;
    return status;
}

/* Finds the grain with most of the energy. */
static void find_concentration(const sp_network *net, const double *f, const double *u, double energy,
                               sp_probe_moduli *out) {
    for (int32_t i = 0; i < net->n; i++) {
        const double share = 0.5 * sp_dot(net->dof, f + (int64_t)i * net->dof, u + (int64_t)i * net->dof) / energy;
        if (share > out->concentrated) {
            out->concentrated = share;
            out->grain = net->grain[i];
        }
    }
}

/* Apparent modulus and its error for one direction. work: [6][n]. */
static sp_status sine_along(sp_equilibrium *e, double phi3s, int n, int axis, double *work, sp_probe_moduli *out,
                            sp_error *err) {
    const sp_network *net = e->net;
    const int64_t dofs = sp_network_dofs(net);
    const double height = net->box[net->dim - 1], most = 0.1;
    double *f = work, *u = work + dofs, *floppy = work + 5 * dofs, energy, error;
    /* (B2): the strain is height/(n PI c) */
    const double stiffness = sp_strain_area(net) * height * height * height / (4.0 * n * n * PI * PI);
    memset(floppy, 0, (size_t)dofs * sizeof *floppy);
    body_force(e, phi3s, n, axis, f);
    if (e->slips && axis != net->dim - 1)
        drop_net_force(net, axis, f);
    if (e->shift_kind == SHIFT_MASS)
        drop_floppy(e, f, work + 2 * dofs, floppy, &out->left_out);
    drop_spins(e, f, &out->left_out);
    if (out->left_out > most)
        return sp_fail(err, SP_EREFUSED,
                       "probe sine:%d: %.2g of the squared body force acts on floppy parts, must be below %g", n,
                       out->left_out, most);
    sp_status status = solve_sine(e, n, f, u, work + 2 * dofs, err);
    if (status == SP_OK)
        status = sine_energy(e, f, u, height / (n * PI * stiffness), work + 2 * dofs, &energy, &error, err);
    if (status != SP_OK)
        return status;
    if (!(energy > 0))
        return sp_fail(err, SP_EREFUSED,
                       "probe sine:%d: the work of the body force is %.3g, must be above 0: the network is unstable", n,
                       2 * energy);
    error += 2 * fabs(sp_dot(dofs, u, floppy)); /* nonzero only for soft motions that are not quite floppy */
    find_concentration(net, f, u, energy, out);
    const double c = stiffness / energy;
    *(axis == net->dim - 1 ? &out->along : &out->shear) = c;
    *(axis == net->dim - 1 ? &out->error_along : &out->error_shear) = c * error / energy;
    return SP_OK;
}

static sp_status sine(sp_equilibrium *e, double phi3s, int n, double *work, sp_probe_moduli *out, sp_error *err) {
    sp_status status = SP_OK;
    if (e->shift_kind == SHIFT_DIAGONAL && !e->net->carried)
        status = sp_equilibrium_shift(e, SHIFT_MASS, 0, err);
    if (e->spins > 0 && !e->weighed)
        status = sp_equilibrium_weigh_spins(e, err);
    if (status == SP_OK)
        status = sine_along(e, phi3s, n, e->net->dim - 1, work, out, err);
    if (status == SP_OK && e->net->dim > 1 && (e->grips || e->slips))
        status = sine_along(e, phi3s, n, 0, work, out, err);
    return status;
}

/* ---- lines ---------------------------------------------------------------------------------------------------- */

/* Displacement of the continuum at height y between n + 2 lines. Of these every fourth from the second is displaced by
 * 1 and every fourth from the fourth by -1. */
static double line_field(double height, int n, double y) {
    static const double turns[] = {0, 1, 0, -1};
    const double at = y * (n + 1) / height;
    const int k = (int)fmax(0, fmin(n, floor(at)));
    return turns[k % 4] + (at - k) * (turns[(k + 1) % 4] - turns[k % 4]);
}

/* fixed[i]: grain i lies on a line between the walls. Each line must cross a grain, and no grain may be crossed by two.
 * The lines at the walls are the walls themselves: displacing the grains in contact with them too gives higher moduli
 * than Table V, by 13% for C33 (the 2D shear modulus) of one line at p = 1e-4. */
static sp_status find_lines(const sp_network *net, int n, uint8_t *fixed, sp_error *err) {
    const double height = net->box[net->dim - 1], between = height / (n + 1);
    uint8_t *met = sp_alloc((size_t)n + 1, 1);
    sp_status status = met ? SP_OK : sp_fail_memory(err, (size_t)n + 1);
    for (int32_t i = 0; i < net->n && status == SP_OK; i++) {
        const double y = height_of(net, i), r = net->r[i];
        const int first = (int)fmax(1, ceil((y - r) / between)), last = (int)fmin(n, floor((y + r) / between));
        if (last > first)
            status = sp_fail(err, SP_EREFUSED,
                             "probe lines:%d: lines are %.3g d apart and two cross grain %d of diameter %.3g, must be "
                             "fewer",
                             n, between, net->grain[i], 2 * r);
        if (last == first)
            fixed[i] = met[first] = 1;
    }
    for (int k = 1; k <= n && status == SP_OK; k++)
        if (!met[k])
            status =
                sp_fail(err, SP_EREFUSED, "probe lines:%d: line %d, at height %.6g d, crosses no grain of the network",
                        n, k, k * between);
    sp_free(met);
    return status;
}

/* Weights with which a residual changes the energy u . K u/2, times 2. They come from K u + K^T u at free degrees of
 * freedom, which vanishes at equilibrium for symmetric K. load: [n] scratch. */
static sp_status find_line_weights(sp_equilibrium *e, const double *u, double *load, double *weight, sp_error *err) {
    if (e->net->carried) {
        sp_network_apply_transposed(e->net, u, load);
        return sp_equilibrium_weights(e, load, sp_norm(sp_network_dofs(e->net), load), weight, err);
    }
    memset(weight, 0, (size_t)sp_network_dofs(e->net) * sizeof *weight);
    for (int64_t c = 0; c < e->count; c++)
        weight[e->free_dofs[c]] = u[e->free_dofs[c]];
    return SP_OK;
}

/* Apparent modulus and its error for one direction, with imposed displacements of fixed grains. For symmetric K the
 * energy is minimal at equilibrium, and its error is of second order: half the residual times the error of u, which u
 * bounds. work: [6][n]. */
static sp_status lines_along(sp_equilibrium *e, int n, const uint8_t *fixed, int axis, double *work,
                             sp_probe_moduli *out, sp_error *err) {
    const sp_network *net = e->net;
    const int64_t dofs = sp_network_dofs(net);
    const double height = net->box[net->dim - 1], noise = sp_strain_noise(net);
    double *f = work, *u = work + dofs, *rest = work + 2 * dofs, *size = work + 3 * dofs, *weight = work + 4 * dofs;
    double residual, rounding, off = 0;
    memset(f, 0, 2 * (size_t)dofs * sizeof *f);
    for (int32_t i = 0; i < net->n; i++)
        if (fixed[i])
            u[(int64_t)i * net->dof + axis] = line_field(height, n, height_of(net, i));
    const double load = sp_equilibrium_residual(e, f, u, rest);
    sp_status status = sp_equilibrium_solve(e, f, 0, u, &residual, err);
    if (status != SP_OK)
        return status;
    if (load > 0 && !(residual < 1e-8 * load)) {
        char what[32];
        snprintf(what, sizeof what, "probe lines:%d", n);
        return sp_equilibrium_refuse(e, what, load, f, u, err);
    }
    const double energy = 0.5 * sp_network_energy2_bound(net, u, &rounding);
    status = find_line_weights(e, u, work + 5 * dofs, weight, err);
    if (status != SP_OK)
        return status;
    /* each spin that is held may turn by the strain, which is typical of grains in contact */
    off += sp_equilibrium_spin_work(e, sp_equilibrium_spin_rest(e, work + 5 * dofs, weight), (n + 1) / height, u);
    sp_equilibrium_residual(e, f, u, rest);
    sp_strain_rounding(net, -1, u, size, NULL);
    for (int64_t c = 0; c < e->count; c++) {
        const int64_t k = e->free_dofs[c];
        off += fabs(weight[k]) * (fabs(rest[k]) + noise * size[k]);
    }
    /* (B3), u0 = 1 */
    const double factor = 2 * height / ((n + 1.0) * (n + 1.0) * sp_strain_area(net));
    *(axis == net->dim - 1 ? &out->along : &out->shear) = factor * energy;
    *(axis == net->dim - 1 ? &out->error_along : &out->error_shear) =
        factor * (0.5 * off + 0.5 * rounding + noise * energy);
    return SP_OK;
}

static sp_status lines(const sp_equilibrium *whole, int n, double *work, sp_probe_moduli *out, sp_error *err) {
    const sp_network *net = whole->net;
    const int64_t dofs = sp_network_dofs(net);
    sp_equilibrium e = sp_equilibrium_none();
    uint8_t *grain = sp_alloc((size_t)net->n, 1), *fixed = sp_alloc((size_t)dofs, 1);
    sp_status status = grain && fixed ? SP_OK : sp_fail_memory(err, (size_t)net->n + (size_t)dofs);
    if (status == SP_OK)
        status = find_lines(net, n, grain, err);
    for (int64_t k = 0; k < dofs && status == SP_OK; k++)
        fixed[k] = k % net->dof < net->dim && grain[k / net->dof];
    if (status == SP_OK)
        status = sp_equilibrium_restrict(whole, fixed, &e, err);
    if (status == SP_OK)
        status = lines_along(&e, n, grain, net->dim - 1, work, out, err);
    if (status == SP_OK && net->dim > 1 && whole->grips)
        status = lines_along(&e, n, grain, 0, work, out, err);
    sp_equilibrium_free(&e);
    sp_free(fixed);
    sp_free(grain);
    return status;
}

/* ---- both ----------------------------------------------------------------------------------------------------- */

static sp_status check_probe(const sp_network *net, double phi3s, const sp_probe *p, sp_error *err) {
    const double height = net->box[net->dim - 1];
    double mean = 0;
    for (int32_t i = 0; i < net->n; i++)
        mean += 2 * net->r[i] / net->n;
    if (p->kind != SP_PROBE_SINE && p->kind != SP_PROBE_LINES)
        return sp_fail(err, SP_EINVAL, "probe of kind %d, must be sine or lines", (int)p->kind);
    if (p->n < 1)
        return sp_fail(err, SP_EINVAL, "probe %s:%d, must be 1 or more", p->kind == SP_PROBE_SINE ? "sine" : "lines",
                       p->n);
    if (p->kind == SP_PROBE_LINES && p->n % 2 == 0)
        return sp_fail(err, SP_EINVAL, "probe lines:%d, must be an odd number of lines between the walls", p->n);
    if (height / (p->kind == SP_PROBE_SINE ? p->n : p->n + 1.0) < mean) {
        const char *name = p->kind == SP_PROBE_SINE ? "sine" : "lines";
        const int fit = (int)(height / mean), most = p->kind == SP_PROBE_SINE ? fit : fit / 2 * 2 - 1;
        char right[40] = "none is coarse enough";
        if (most > 0)
            snprintf(right, sizeof right, "must be at most %s:%d", name, most);
        return sp_fail(err, SP_EREFUSED,
                       "probe %s:%d in a packing %.3g d high is finer than the mean diameter of the grains, %.3g, %s",
                       name, p->n, height, mean, right);
    }
    if (p->kind == SP_PROBE_SINE && !(phi3s > 0))
        return sp_fail(err, SP_EREFUSED,
                       "probe sine:%d needs Phi3*, which is undefined in a packing %.3g d high: too low to leave out "
                       "layers at both walls",
                       p->n, height);
    return SP_OK;
}

sp_status sp_moduli_probe(const sp_network *net, double phi3s, int32_t count, const sp_probe *probe, sp_moduli *global,
                          sp_probe_moduli *out, sp_error *err) {
    const size_t size = 6 * (size_t)sp_network_dofs(net);
    sp_equilibrium e = sp_equilibrium_none();
    sp_moduli m;
    double *work = NULL;
    sp_probe_moduli *result = NULL;
    sp_status status = SP_OK;
    if (count < 0)
        return sp_fail(err, SP_EINVAL, "%d probes, must be 0 or more", count);
    if (net->cell != SP_CELL_PISTON)
        return sp_fail(err, SP_EREFUSED,
                       "a probe is a standing wave between two walls, with periodic sides: it needs a cell of the kind "
                       "piston; the imposed strain serves in every cell");
    for (int32_t k = 0; k < count && status == SP_OK; k++)
        status = check_probe(net, phi3s, &probe[k], err);
    if (status != SP_OK)
        return status;
    work = sp_alloc(size, sizeof *work);
    result = sp_alloc((size_t)count, sizeof *result);
    status = work && result ? sp_equilibrium_make(net, &e, err) : sp_fail_memory(err, size * sizeof *work);
    if (status == SP_OK && global)
        status = sp_moduli_of(&e, phi3s, &m, err);
    for (int32_t k = 0; k < count && status == SP_OK; k++) {
        result[k] = (sp_probe_moduli){.shear = NAN, .error_shear = NAN};
        status = probe[k].kind == SP_PROBE_SINE ? sine(&e, phi3s, probe[k].n, work, &result[k], err)
                                                : lines(&e, probe[k].n, work, &result[k], err);
    }
    if (status == SP_OK && global)
        *global = m;
    if (status == SP_OK && count > 0)
        memcpy(out, result, (size_t)count * sizeof *out);
    sp_equilibrium_free(&e);
    sp_free(result);
    sp_free(work);
    return status;
}
