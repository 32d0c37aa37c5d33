/* Compares modes of a packing with those of a homogeneous elastic strip with the same moduli. */
#include "base/base.h"
#include "linalg/eigen.h"

#include <math.h>
#include <sonopack/spectrum.h>
#include <stdlib.h>
#include <string.h>

/* polynomials for each component: one and a half times as many as 24 half waves need */
enum { BASIS = 48, SIZE = 2 * BASIS, COUNT_MAX = BASIS / 2 };

/* ---- the strip ------------------------------------------------------------------------------------------------ */

/* phi_k = c_k (L_k - L_(k+2)), c_k = 1/sqrt(4 k + 6), vanishes at both walls. The integral of phi_j' phi_k' is 1 for j
 * = k, else 0 (Shen, SIAM J. Sci. Comput. 15, 1489, 1994). */
static double weight(int k) { return 1 / sqrt(4.0 * k + 6); }

/* Integral of phi_j phi_k over -1 .. 1. */
static double mass_of(int j, int k) {
    const int low = j < k ? j : k;
    if (j == k)
        return weight(j) * weight(j) * (2 / (2.0 * j + 1) + 2 / (2.0 * j + 5));
    return abs(j - k) == 2 ? -weight(j) * weight(k) * 2 / (2.0 * low + 5) : 0;
}

/* Integral of phi_j phi_k' over -1 .. 1. */
static double slope_of(int j, int k) {
    if (j == k + 1)
        return -2 * weight(j) * weight(k);
    return k == j + 1 ? 2 * weight(j) * weight(k) : 0;
}

/* Stiffness a and mass b of the strip, by columns, first v then w; C33 is the shear modulus (2D): rho omega^2 v = C11
 * k1^2 v - C33 v'' + k1 (C12 + C33) w', rho omega^2 w = C33 k1^2 w - C22 w'' - k1 (C12 + C33) v'. */
static void strip_matrices(const sp_moduli *m, double phi3s, double k1, double height, double *a, double *b) {
    const double half = 0.5 * height, pull = k1 * (m->c12 + m->c33);
    for (int j = 0; j < BASIS; j++)
        for (int k = 0; k < BASIS; k++) {
            const double mass = half * mass_of(j, k), stiff = j == k ? 1 / half : 0;
            b[k * SIZE + j] = b[(BASIS + k) * SIZE + BASIS + j] = phi3s * mass;
            a[k * SIZE + j] = m->c11 * k1 * k1 * mass + m->c33 * stiff;
            a[(BASIS + k) * SIZE + BASIS + j] = m->c33 * k1 * k1 * mass + m->c22 * stiff;
            a[(BASIS + k) * SIZE + j] = pull * slope_of(j, k);
            a[k * SIZE + BASIS + j] = -pull * slope_of(j, k);
        }
}

/* b becomes L with b = L L^T (lower triangle), and a becomes L^-1 a L^-T; columns of SIZE. */
static void reduce(double *a, double *b) {
    for (int k = 0; k < SIZE; k++) {
        for (int q = 0; q < k; q++)
            for (int j = k; j < SIZE; j++)
                b[k * SIZE + j] -= b[q * SIZE + j] * b[q * SIZE + k];
        const double root = sqrt(b[k * SIZE + k]);
        for (int j = k; j < SIZE; j++)
            b[k * SIZE + j] /= root;
    }
    for (int turn = 0; turn < 2; turn++) { /* multiply by L^-1 and transpose, twice */
        for (int c = 0; c < SIZE; c++)
            for (int k = 0; k < SIZE; k++) {
                a[c * SIZE + k] /= b[k * SIZE + k];
                for (int j = k + 1; j < SIZE; j++)
                    a[c * SIZE + j] -= b[k * SIZE + j] * a[c * SIZE + k];
            }
        for (int c = 0; c < SIZE; c++)
            for (int k = 0; k < c; k++) {
                const double x = a[c * SIZE + k];
                a[c * SIZE + k] = a[k * SIZE + c];
                a[k * SIZE + c] = x;
            }
    }
}

/* x = L^-T x. */
static void expand(const double *b, double *x) {
    for (int k = SIZE; k-- > 0;) {
        for (int j = k + 1; j < SIZE; j++)
            x[k] -= b[k * SIZE + j] * x[j];
        x[k] /= b[k * SIZE + k];
    }
}

/* All phi_k at s in -1 .. 1. */
static void basis_at(double s, double *phi) {
    double legendre[BASIS + 2] = {1, s};
    for (int k = 2; k < BASIS + 2; k++)
        legendre[k] = ((2 * k - 1) * s * legendre[k - 1] - (k - 1) * legendre[k - 2]) / k;
    for (int k = 0; k < BASIS; k++)
        phi[k] = weight(k) * (legendre[k] - legendre[k + 2]);
}

static double sum_of(const double *coefficients, const double *phi) {
    double sum = 0;
    for (int k = 0; k < BASIS; k++)
        sum += coefficients[k] * phi[k];
    return sum;
}

/* omega^2 of both plane waves of a wave vector, the lower first. */
static void plane_squares(const sp_moduli *m, double phi3s, double k1, double k2, double out[2]) {
    const double a = m->c11 * k1 * k1 + m->c33 * k2 * k2, b = m->c33 * k1 * k1 + m->c22 * k2 * k2;
    const double c = (m->c12 + m->c33) * k1 * k2, middle = 0.5 * (a + b), apart = hypot(0.5 * (a - b), c);
    out[0] = (middle - apart) / phi3s;
    out[1] = (middle + apart) / phi3s;
}

/* Finds the strongest sine component and the nearer of its two plane waves. */
static void name_mode(const sp_moduli *m, double phi3s, const double box[2], sp_strip_mode *out) {
    enum { POINTS = 400 };
    double sine[COUNT_MAX + 2][2] = {{0}}, best = 0, square[2];
    for (int q = 0; q < POINTS; q++) {
        const double at = (q + 0.5) / POINTS;
        double phi[BASIS];
        basis_at(2 * at - 1, phi);
        const double v = sum_of(out->v, phi), w = sum_of(out->w, phi);
        for (int n2 = 1; n2 < COUNT_MAX + 2; n2++) {
            sine[n2][0] += v * sin(n2 * M_PI * at);
            sine[n2][1] += w * sin(n2 * M_PI * at);
        }
    }
    for (int n2 = 1; n2 < COUNT_MAX + 2; n2++) {
        const double size = sine[n2][0] * sine[n2][0] + sine[n2][1] * sine[n2][1];
        if (size > best) {
            best = size;
            out->n2 = n2;
        }
    }
    plane_squares(m, phi3s, 2 * M_PI * out->n1 / box[0], M_PI * out->n2 / box[1], square);
    out->fast = fabs(sqrt(square[1]) - out->omega) < fabs(sqrt(fmax(0, square[0])) - out->omega);
    out->omega_plane = sqrt(fmax(0, square[out->fast]));
}

sp_status sp_strip_modes(const sp_moduli *m, double phi3s, const double box[2], int32_t n1, int32_t count,
                         sp_strip_mode *out, sp_error *err) {
    if (count < 1 || count > COUNT_MAX || n1 < 0)
        return sp_fail(err, SP_EINVAL, "%d modes of a strip with n1 = %d, must be 1 .. %d with n1 of 0 or more", count,
                       n1, COUNT_MAX);
    if (!(m->c11 > 0 && m->c22 > 0 && m->c33 > 0 && isfinite(m->c12) && phi3s > 0 && box[0] > 0 && box[1] > 0))
        return sp_fail(err, SP_EINVAL, "strip of C11 = %g, C22 = %g, C33 = %g, Phi3* = %g, must be above 0", m->c11,
                       m->c22, m->c33, phi3s);
    double *a = sp_alloc(2 * SIZE * SIZE + SIZE, sizeof *a);
    if (!a)
        return sp_fail_memory(err, (2 * SIZE * SIZE + SIZE) * sizeof *a);
    double *b = a + SIZE * SIZE, *w = b + SIZE * SIZE;
    strip_matrices(m, phi3s, 2 * M_PI * n1 / box[0], box[1], a, b);
    reduce(a, b);
    sp_status status = sp_eigen_all(SIZE, a, w, err);
    for (int32_t k = 0; k < count && status == SP_OK; k++) {
        double *x = a + k * SIZE;
        out[k] = (sp_strip_mode){.omega = sqrt(fmax(0, w[k])), .n1 = n1};
        expand(b, x);
        memcpy(out[k].v, x, sizeof out[k].v);
        memcpy(out[k].w, x + BASIS, sizeof out[k].w);
        name_mode(m, phi3s, box, &out[k]);
    }
    sp_free(a);
    return status;
}

/* ---- beside the packing --------------------------------------------------------------------------------------- */

sp_continuum sp_continuum_none(void) { return (sp_continuum){0}; }

void sp_continuum_free(sp_continuum *c) {
    sp_free(c->row);
    *c = sp_continuum_none();
}

/* The mode at the centres of the grains, mass weighted, translations only: [2][n][2], the cosine and the sine of v,
 * made orthonormal. For n1 = 0 there is only one. Returns their number. */
static int field_at(const sp_network *net, const sp_strip_mode *mode, double *field) {
    const double k1 = 2 * M_PI * mode->n1 / net->box[0];
    const int64_t n = 2 * (int64_t)net->n;
    for (int32_t i = 0; i < net->n; i++) {
        double phi[BASIS];
        basis_at(2 * net->x[3 * (int64_t)i + 1] / net->box[1] - 1, phi);
        const double v = sum_of(mode->v, phi), w = sum_of(mode->w, phi), at = k1 * net->x[3 * (int64_t)i];
        const double root = sqrt(net->mass[(int64_t)i * net->dof]);
        double *c = field + 2 * (int64_t)i, *s = c + n;
        c[0] = root * v * cos(at);
        c[1] = root * w * (mode->n1 == 0 ? 1 : -sin(at));
        s[0] = root * v * sin(at);
        s[1] = root * w * cos(at);
    }
    const int fields = mode->n1 == 0 ? 1 : 2;
    for (int f = 0; f < fields; f++) {
        double *x = field + f * n, size = 0, shared = 0;
        for (int64_t k = 0; k < n && f == 1; k++)
            shared += x[k] * field[k];
        for (int64_t k = 0; k < n; k++) {
            x[k] -= f == 1 ? shared * field[k] : 0;
            size += x[k] * x[k];
        }
        for (int64_t k = 0; k < n; k++)
            x[k] /= sqrt(size);
    }
    return fields;
}

static double overlap(const sp_network *net, const double *e, int fields, const double *field) {
    double sum = 0;
    for (int f = 0; f < fields; f++) {
        double along = 0;
        for (int32_t i = 0; i < net->n; i++)
            for (int a = 0; a < 2; a++)
                along += e[(int64_t)i * net->dof + a] * field[2 * ((int64_t)f * net->n + i) + a];
        sum += along * along;
    }
    return sum;
}

/* Compares all modes of the strip, up to twice the packing's highest frequency, with all modes of the packing. */
static sp_status match(const sp_network *net, double phi3s, const sp_modes *modes, int64_t first, sp_continuum *c,
                       sp_error *err) {
    enum { WAVES_MAX = 1000 };
    const double until = 2 * c->row[c->n - 1].omega;
    double *field = sp_alloc(4 * (size_t)net->n, sizeof *field);
    sp_strip_mode *strip = sp_alloc(COUNT_MAX, sizeof *strip);
    sp_status status = field && strip ? SP_OK : sp_fail_memory(err, 32 * (size_t)net->n + COUNT_MAX * sizeof *strip);
    for (int32_t n1 = 0; n1 < WAVES_MAX && status == SP_OK; n1++) {
        status = sp_strip_modes(&c->moduli, phi3s, net->box, n1, COUNT_MAX, strip, err);
        if (status != SP_OK || strip[0].omega > until)
            break;
        for (int q = 0; q < COUNT_MAX && strip[q].omega <= until; q++) {
            const int fields = field_at(net, &strip[q], field);
            for (int32_t k = 0; k < c->n; k++) {
                sp_continuum_row *row = &c->row[k];
                const double *e = modes->vectors + (first + k - modes->n_rattler) * modes->dofs;
                const double part = overlap(net, e, fields, field);
                if (part > row->overlap) {
                    row->overlap = part;
                    row->n1 = n1;
                    row->n2 = strip[q].n2;
                    row->fast = strip[q].fast;
                    row->omega_plane = strip[q].omega_plane;
                    row->omega_continuum = strip[q].omega;
                }
            }
        }
    }
    sp_free(strip);
    sp_free(field);
    return status;
}

static sp_status check_continuum(const sp_network *net, double phi3s, int32_t lowest, sp_error *err) {
    if (lowest < 1)
        return sp_fail(err, SP_EINVAL, "the %d lowest modes, must be 1 or more", lowest);
    if (net->dim != 2)
        return sp_fail(err, SP_EREFUSED, "continuum modes of a packing in %d dimensions, must be in 2", net->dim);
    if (net->cell != SP_CELL_PISTON)
        return sp_fail(
            err, SP_EREFUSED,
            "continuum modes are those of a strip between two walls with periodic sides: they need a cell of "
            "the kind piston");
    if (!(phi3s > 0))
        return sp_fail(err, SP_EREFUSED,
                       "continuum modes need Phi3*, which is undefined in a packing %.3g d high: too low to leave out "
                       "layers at both walls",
                       net->box[1]);
    return SP_OK;
}

sp_status sp_continuum_make(const sp_network *net, double phi3s, int32_t lowest, sp_modes_solver solver,
                            sp_continuum *out, sp_error *err) {
    const sp_modes_options o = {.vectors = true, .source = SP_SOURCE_IMPULSE, .solver = solver};
    const sp_modes_range range = sp_modes_range_lowest(lowest);
    sp_continuum c = sp_continuum_none();
    sp_modes modes = sp_modes_none();
    sp_status status = check_continuum(net, phi3s, lowest, err);
    if (status == SP_OK)
        status = sp_moduli_make(net, phi3s, &c.moduli, err);
    if (status == SP_OK && isnan(c.moduli.c33))
        status = sp_fail(err, SP_EREFUSED,
                         "continuum modes need walls with friction: without it there is no shear modulus between them");
    if (status == SP_OK)
        status = sp_modes_make(net, &o, &range, &modes, err);
    if (status == SP_OK && modes.n == modes.n_zero)
        status = sp_fail(err, SP_EREFUSED, "all of the %d lowest modes have frequency 0", lowest);
    if (status == SP_OK) {
        c.n = (int32_t)(modes.n - modes.n_zero);
        c.row = sp_alloc((size_t)c.n, sizeof *c.row);
        if (!c.row)
            status = sp_fail_memory(err, (size_t)c.n * sizeof *c.row);
    }
    for (int32_t k = 0; k < c.n && status == SP_OK; k++)
        c.row[k] = (sp_continuum_row){.n = modes.first + modes.n_zero + k, .omega = modes.omega[modes.n_zero + k]};
    if (status == SP_OK)
        status = match(net, phi3s, &modes, modes.n_zero, &c, err);
    sp_modes_free(&modes);
    if (status == SP_OK)
        *out = c;
    else
        sp_continuum_free(&c);
    return status;
}
