/* The BSR model as in [B]: (45) with (44) and (46), either as printed or with corrected signs. The particles move with
 * u.
 *
 *     u_t + u u_z = -g - (K/m) int_-h^h Theta(z + y) S [1 - e sigma(S (u(z + y) - u(z)))] (h - |y|) dy,
 *     Theta(x) = exp(-(x - b)^2/(2 c^2))/(p sqrt(2 pi)),   b = 7h, c = 3h.
 *
 * As printed, S = 1 and p = b, so that neighbours above and below both push downwards. With corrected signs S = sgn(y):
 * a neighbour above pushes downwards and one below upwards, and w = S (u(z + y) - u(z)) is the velocity at which the
 * two separate; p = c normalises Theta. The density does not occur in (45), so neither version can build up a pressure.
 * What is left of the opposite forces is the slope of Theta, which does not depend on the column.
 *
 * Both columns fall through the floor. (46) can impose u(0, t) = y0' only where the floor moves into the column
 * (Bardos, le Roux, Nedelec 1979), as in Godunov's flux. A particle below z = 0 has left the field and falls freely. */
#include "base/base.h"
#include "tapped/bsr.h"

enum { HEIGHT_ABOVE = 40 }; /* height of the field above the column, in h; Theta is below 1e-26 of its maximum there */

typedef struct continuum {
    const sp_tapped_spec *c;
    double h, dz;
    double t;
    int32_t reach; /* number of cells in h */
    int64_t cells;
    int64_t inside;   /* number of particles still in the field */
    double *u, *next; /* [cells + 2 reach]: from `reach` cells below the floor to `reach` cells above the field */
    double *theta, *weight, *steady; /* (44) in the same cells; (h - |y|) K/m dy; the integral for e = 0 */
    double *block;
} continuum;

static double theta(const sp_tapped_spec *c, double x) {
    double h = 2 * sp_tapped_radius(c, 1), b = 7 * h, width = 3 * h, off = (x - b) / width;
    double by = c->bsr == SP_TAPPED_BSR_LITERAL ? b : width;
    return exp(-off * off / 2) / (by * sqrt(2 * M_PI));
}

/* ---- the force -------------------------------------------------------------------------------------------------- */

/* Downward force on a particle at z over m g for e = 0, by Simpson's rule on both sides of the kink at y = 0. */
static double force_at(const sp_tapped_spec *c, double z) {
    enum { HALVES = 400 };
    double h = 2 * sp_tapped_radius(c, 1), dy = h / HALVES, sum = 0;
    double below = c->bsr == SP_TAPPED_BSR_LITERAL ? 1 : -1;
    for (int k = 0; k <= HALVES; k++) {
        double y = k * dy, weight = k == 0 || k == HALVES ? 1 : k % 2 ? 4 : 2;
        sum += weight * (h - y) * (theta(c, z + y) + below * theta(c, z - y));
    }
    return sp_tapped_stiffness(c) / (sp_tapped_mass(c, 1) * c->gravity) * sum * dy / 3;
}

/* As printed the force is largest at the maximum of Theta, by symmetry. With corrected signs the maximum lies between
 * there and the tail; the largest upward force above b equals the largest downward force below. */
double sp_tapped_bsr_force(const sp_tapped_spec *c, sp_tapped_bsr which) {
    sp_tapped_spec as = *c;
    as.bsr = which;
    double h = 2 * sp_tapped_radius(c, 1), b = 7 * h, low = b, high = b + 6 * h;
    if (which == SP_TAPPED_BSR_CONSERVATIVE || sp_tapped_check_equal(c, NULL) != SP_OK)
        return NAN;
    if (which == SP_TAPPED_BSR_LITERAL)
        return force_at(&as, b);
    for (int k = 0; k < 60; k++) { /* golden section */
        double left = high - 0.6180339887498949 * (high - low), right = low + 0.6180339887498949 * (high - low);
        if (force_at(&as, left) < force_at(&as, right)) /* upward forces are negative */
            high = right;
        else
            low = left;
    }
    return -force_at(&as, (low + high) / 2);
}

/* ---- the field -------------------------------------------------------------------------------------------------- */

static sp_status make(const sp_tapped_spec *c, continuum *f, sp_error *err) {
    double radius = sp_tapped_radius(c, 1), high = c->particles + fmax(0, c->drop) / (2 * radius);
    double strength = sp_tapped_stiffness(c) / sp_tapped_mass(c, 1);
    *f = (continuum){.c = c, .h = 2 * radius};
    f->reach = c->cells;
    f->dz = f->h / c->cells;
    f->inside = c->particles;
    double cells = ceil((high + HEIGHT_ABOVE) * c->cells), all = cells + 2 * f->reach;
    if (!(8 * 5 * all < 0.5 * sp_memory_limit()))
        return sp_fail(err, SP_EINVAL, "column: BSR needs %.3g cells for this column, more than memory holds", cells);
    f->cells = (int64_t)cells;
    size_t n = (size_t)all;
    double *block = sp_alloc(4 * n + 2 * (size_t)f->reach + 1, sizeof *block);
    if (!block)
        return sp_fail_memory(err, 4 * n * sizeof *block);
    f->block = block;
    f->u = block;
    f->next = block + n;
    f->theta = block + 2 * n;
    f->steady = block + 3 * n;
    f->weight = block + 4 * n;
    for (int64_t j = 0; j < (int64_t)n; j++)
        f->theta[j] = theta(c, ((double)(j - f->reach) + 0.5) * f->dz);
    for (int32_t k = 0; k <= 2 * f->reach; k++)
        f->weight[k] = strength * (f->h - fabs((k - f->reach) * f->dz)) * f->dz;
    for (int64_t j = 0; j < f->cells; j++)
        for (int32_t k = 0; k <= 2 * f->reach; k++) {
            double sign = c->bsr == SP_TAPPED_BSR_LITERAL ? 1 : (k > f->reach) - (k < f->reach);
            f->steady[j] += sign * f->weight[k] * f->theta[j + k];
        }
    return SP_OK;
}

/* tanh(x)/x; most of the run time is dissipated here. */
static double tanh_ratio(double x) { return fabs(x) < 1e-3 ? 1 - x * x / 3 : fabs(x) > 20 ? 1 / fabs(x) : tanh(x) / x; }

/* Change of u in cell j over dt due to the integral, by the trapezoidal rule as in [B]. With e > 0 it draws u towards
 * the velocities of the neighbours, because S sigma(S w) = sigma(w) for both signs. For a large alpha_v this rate is
 * too stiff for an explicit step. The step is therefore implicit in u(z), with the ratio tanh(w)/w taken at its start.
 */
static double velocity_change(const continuum *f, int64_t j, double dt) {
    const double here = f->u[j + f->reach], rate = f->c->e * f->c->alpha_v;
    double sum = 0, drawn = 0;
    if (rate > 0)
        for (int32_t k = 0; k <= 2 * f->reach; k++) {
            double rise = f->u[j + k] - here,
                   draw = rate * f->weight[k] * f->theta[j + k] * tanh_ratio(f->c->alpha_v * rise);
            sum += draw * rise;
            drawn += draw;
        }
    return dt * (sum - f->steady[j]) / (1 + dt * drawn);
}

static double godunov(double left, double right) { /* for the flux u^2/2 */
    double from_left = fmax(left, 0), from_right = fmin(right, 0);
    return fmax(from_left * from_left, from_right * from_right) / 2;
}

/* Values outside the field: below, the floor's velocity as (46) demands; above, free fall. */
static void set_boundaries(continuum *f, double dt) {
    double under = sp_tapped_floor_velocity(f->c, f->t + dt / 2), over = -f->c->gravity * f->t;
    for (int32_t k = 0; k < f->reach; k++) {
        f->u[k] = under;
        f->u[f->cells + f->reach + k] = over;
    }
}

static double stable_step(const continuum *f, double fastest) {
    return 0.45 * f->dz / (fastest + sqrt(f->c->gravity * f->h));
}

static void advance(continuum *f, double dt) {
    const int32_t at = f->reach;
    set_boundaries(f, dt);
    for (int64_t j = 0; j < f->cells; j++) {
        double in = godunov(f->u[j + at - 1], f->u[j + at]), out = godunov(f->u[j + at], f->u[j + at + 1]);
        f->next[j + at] = f->u[j + at] - dt / f->dz * (out - in) - dt * f->c->gravity + velocity_change(f, j, dt);
    }
    double *old = f->u;
    f->u = f->next;
    f->next = old;
}

/* Interpolates u linearly at z, and returns its slope u_z. */
static double velocity(const continuum *f, double z, double *slope) {
    double x = z / f->dz - 0.5;
    int64_t j = (int64_t)fmin(fmax(floor(x), 0), (double)f->cells - 2);
    const double *u = f->u + f->reach + j;
    *slope = x < 0 ? 0 : (u[1] - u[0]) / f->dz;
    return u[0] + (fmax(0, x) - (double)j) * (u[1] - u[0]);
}

/* ---- the particles ---------------------------------------------------------------------------------------------- */

static void place_particles(void *model, sp_tapped_frame *at) {
    const continuum *f = model;
    const sp_tapped_spec *c = f->c;
    if (c->drop < 0)
        sp_tapped_rest(c, at->y + 1);
    for (int32_t i = 1; i <= c->particles; i++) {
        if (c->drop >= 0)
            at->y[i] = c->drop + (i - 0.5) * f->h;
        at->v[i] = 0;
        at->rho[i - 1] = sp_tapped_mass(c, 1) / f->h; /* (42) */
    }
    at->t = 0;
}

/* Moves the particles by dy/dt = u(y, t), and their densities by (48) along the path: d rho/dt = -u_z rho. */
static void move_particles(continuum *f, double dt, const sp_tapped_frame *from, sp_tapped_frame *to) {
    const double gravity = f->c->gravity;
    f->inside = 0;
    for (int32_t i = 1; i <= f->c->particles; i++) {
        double slope = 0, y = from->y[i], v = from->v[i], fallen = y + dt * (v - gravity * dt / 2);
        if (y >= 0) { /* Heun's method */
            fallen = y + dt / 2 * (v + velocity(f, y + dt * v, &slope));
            v = velocity(f, fallen, &slope);
            f->inside += fallen >= 0;
        } else {
            v -= gravity * dt;
        }
        to->y[i] = fallen;
        to->v[i] = v;
        to->rho[i - 1] = from->rho[i - 1] * exp(-slope * dt);
    }
    to->t = f->t;
}

static sp_status step(void *model, double until, const sp_tapped_frame *from, sp_tapped_frame *to, sp_error *err) {
    continuum *f = model;
    double fastest = fabs(sp_tapped_floor_velocity(f->c, f->t)), dt = f->c->period / 100, end;
    if (f->inside > 0) {
        for (int64_t j = 0; j < f->cells; j++)
            fastest = fmax(fastest, fabs(f->u[j + f->reach]));
        dt = fmin(dt, stable_step(f, fmax(fastest, f->c->gravity * f->t)));
        if (f->c->time_step > 0)
            dt = fmin(dt, f->c->time_step);
    }
    sp_status status = sp_tapped_bsr_limit_step(f->t, until, &dt, &end, err);
    if (status != SP_OK)
        return status;
    if (f->inside > 0)
        advance(f, dt);
    f->t = end;
    move_particles(f, dt, from, to);
    double sum = 0;
    for (int32_t i = 1; i <= f->c->particles; i++)
        sum += to->y[i] + to->rho[i - 1];
    return sp_tapped_bsr_check_finite(sum, f->t, err);
}

/* ---- the run ---------------------------------------------------------------------------------------------------- */

/* Bounds the step by the velocity of a fall from the top of the column under gravity and the largest force, onto the
 * moving floor. */
static sp_status check(const continuum *f, const sp_tapped_spec *c, sp_error *err) {
    double down = c->gravity * (1 + (1 + c->e) * sp_tapped_bsr_force(c, c->bsr));
    double top = c->particles * f->h + fmax(0, c->drop);
    double bound = stable_step(f, 2 * M_PI * c->frequency * c->amplitude + sqrt(2 * down * top));
    return sp_tapped_check_time_step(c, bound, err);
}

sp_status sp_tapped_literal(const sp_tapped_spec *c, const sp_tapped_rows *rows, sp_tapped_report *report,
                            sp_error *err) {
    continuum f = {.c = c};
    const sp_tapped_bsr_scheme scheme = {&f, place_particles, step};
    sp_status status = sp_tapped_check_equal(c, err);
    if (status == SP_OK)
        status = make(c, &f, err);
    if (status == SP_OK)
        status = check(&f, c, err);
    if (status == SP_OK)
        status = sp_tapped_bsr_integrate(c, &scheme, rows, report, err);
    sp_free(f.block);
    return status;
}
