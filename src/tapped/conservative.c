/* The BSR model in conservative form: mass and momentum of a compressible column.
 *
 *     rho_t + (rho u)_z = 0,   (rho u)_t + (rho u^2 + P)_z = -rho g,
 *     P = K (h - s)_+ (1 - e tanh(alpha_v s u_z)),   s = m/rho, the distance of neighbours.
 *
 * This is what (45) intends. From s_t + u s_z = s u_z, a distance opens with the velocity s u_z, so that P is the force
 * (18) of a contact. (The choice h u_z, its value at s = h, makes the lower half of a tall column too viscous. For 80
 * particles the mean difference from the smooth lattice is then 0.017 cm, with s u_z 0.002 cm.) Below s = h the speed
 * of sound along z is c = s sqrt(K/m). Above, the particles do not touch, and there is neither pressure nor sound.
 *
 * The cells have equal lengths and move with the lowest one. A column in flight therefore does not move relative to
 * them, and its edge stays sharp. The floor acts on the edge Y as over half a particle distance, F = 2 K (1 - e sigma)
 * (y0 - Y)_+. In the lattice the whole overlap of the lowest contact lies below particle 1, but in the column only half
 * of it. With a rigid floor all particles would rest N m g/(2K) too high.
 *
 * The fluxes are Rusanov's. The states at the faces are reconstructed from s^2 and u, linearly with minmod slopes.
 * At rest s^2 is linear, so that nothing flows: five particles creep by 0.0001 cm with cells of h/8, and with piecewise
 * constant states by 0.028 cm. In flight gravity acts in two half steps around the rest of the step, so that free fall
 * is exact. */
#include "base/base.h"
#include "tapped/bsr.h"

#include <string.h>

typedef struct fluid {
    const sp_tapped_spec *c;
    double m, h, stiffness, mean; /* mean: density m/h of particles that just touch */
    double dx, edge;              /* length of a cell; lower edge of the first cell */
    double t, mass_error;
    int64_t cells, used;                 /* allocated; in use */
    double *rho, *q, *next_rho, *next_q; /* densities and momenta [cells] */
    double *u, *s;                       /* velocity; distance of neighbours, h where they do not touch */
    double *low, *high, *half_slope;     /* s at the lower and upper face of a cell; half the change of u across it */
    double *pressure, *drag;  /* elastic P at the lower faces; viscous part of P over the velocity difference */
    double *pivot, *velocity; /* of the implicit equations for the velocities */
    double *block;
} fluid;

enum { ARRAYS = 13 };

/* The two densities are relative to m/h. A cell below empty_density is empty and has no velocity of its own. A
 * lowest cell below thin_density is merged into the next. safety is the Courant number: Euler's step with linear
 * reconstruction keeps its order below one half. */
static const double empty_density = 1e-20, thin_density = 1e-4, safety = 0.4;

static sp_status resize(fluid *f, int64_t cells, sp_error *err) {
    if (!(8.0 * ARRAYS * (double)cells < 0.5 * sp_memory_limit()))
        return sp_fail(err, SP_EFAILED, "BSR, t = %.17g s: the column is %.3g cm high, more cells than memory holds",
                       f->t, (double)cells * f->dx);
    double *block = sp_alloc((size_t)cells * ARRAYS, sizeof *block);
    if (!block)
        return sp_fail_memory(err, (size_t)cells * ARRAYS * sizeof *block);
    if (f->block) {
        memcpy(block, f->rho, (size_t)f->used * sizeof *block);
        memcpy(block + cells, f->q, (size_t)f->used * sizeof *block);
    }
    sp_free(f->block);
    double **part[] = {&f->rho,  &f->q,          &f->next_rho, &f->next_q, &f->u,     &f->s,       &f->low,
                       &f->high, &f->half_slope, &f->pressure, &f->drag,   &f->pivot, &f->velocity};
    f->block = block;
    for (size_t k = 0; k < sizeof part / sizeof *part; k++)
        *part[k] = block + (size_t)cells * k;
    f->cells = cells;
    return SP_OK;
}

/* Mass below the height x above the lower edge: of a column that just touches, or of one at rest. There s^2 = (h - N
 * M)^2 + 2 M x balances gravity, M = m g/K. */
static double mass_below(const fluid *f, double x) {
    double n = f->c->particles, sag = f->m * f->c->gravity / f->stiffness, low = f->h - n * sag;
    if (f->c->drop >= 0)
        return f->m * fmin(n, x / f->h);
    double s = sqrt(low * low + 2 * sag * x);
    return f->m * fmin(n, 2 * x / (low + s)); /* (s - low)/M */
}

static sp_status start(const sp_tapped_spec *c, fluid *f, sp_error *err) {
    double radius = sp_tapped_radius(c, 1), n = c->particles;
    *f = (fluid){.c = c, .m = sp_tapped_mass(c, 1), .h = 2 * radius, .stiffness = sp_tapped_stiffness(c)};
    f->mean = f->m / f->h;
    f->dx = f->h / c->cells;
    f->edge = c->drop >= 0 ? c->drop : -n * f->m * c->gravity / (2 * f->stiffness);
    sp_status status = resize(f, (int64_t)c->particles * c->cells + 64, err);
    double below = 0;
    for (int64_t i = 0; status == SP_OK && below < f->m * n && i < f->cells; i++) {
        double next = mass_below(f, (double)(i + 1) * f->dx);
        f->rho[i] = (next - below) / f->dx;
        f->used = i + 1;
        below = next;
    }
    return status;
}

/* ---- one step --------------------------------------------------------------------------------------------------- */

/* Computes velocities and distances in the cells; returns the longest stable step. */
static double measure_cells(fluid *f) {
    const double root = sqrt(f->stiffness / f->m), bottom = f->q[0] / f->rho[0];
    const double under = sp_tapped_floor_velocity(f->c, f->t);
    double speed = sqrt(f->c->gravity * f->dx);
    for (int64_t i = 0; i < f->used; i++) {
        bool any = f->rho[i] > empty_density * f->mean;
        f->u[i] = any ? f->q[i] / f->rho[i] : bottom;
        f->s[i] = any ? fmin(f->m / f->rho[i], f->h) : f->h;
        double sound = f->s[i] < f->h ? f->s[i] * root : 0;
        speed = fmax(speed, fmax(fabs(f->u[i] - bottom), fabs(f->u[i] - under)) + sound);
    }
    return safety * f->dx / speed;
}

/* A lower bound of the stable step, known before the run: from the speed of sound where particles just touch, the
 * velocity of the floor, and that of the column's fall. */
static double stable_step(const fluid *f) {
    const sp_tapped_spec *c = f->c;
    double speed = f->h * sqrt(f->stiffness / f->m) + 2 * M_PI * c->frequency * c->amplitude +
                   sqrt(2 * c->gravity * fmax(0, c->drop)) + sqrt(c->gravity * f->dx);
    return safety * f->dx / speed;
}

static double minmod(double a, double b) { return a * b <= 0 ? 0 : fabs(a) < fabs(b) ? a : b; }

/* s^2 is linear in a column at rest, and so is its reconstruction here: at rest the faces see no jump. */
static void reconstruct(fluid *f) {
    for (int64_t i = 0; i < f->used; i++) {
        double square = f->s[i] * f->s[i], slope = 0;
        bool below = i > 0 && f->s[i - 1] < f->h, above = i + 1 < f->used && f->s[i + 1] < f->h;
        f->half_slope[i] = 0;
        f->low[i] = f->high[i] = f->s[i];
        if (f->s[i] >= f->h || !(below || above))
            continue;
        double down = below ? square - f->s[i - 1] * f->s[i - 1] : 0;
        double up = above ? f->s[i + 1] * f->s[i + 1] - square : 0;
        if (below && above)
            f->half_slope[i] = minmod(f->u[i] - f->u[i - 1], f->u[i + 1] - f->u[i]) / 2;
        slope = below && above ? minmod(down, up) : down + up;
        f->low[i] = sqrt(fmin(f->h * f->h, fmax(square / 4, square - slope / 2)));
        f->high[i] = sqrt(fmin(f->h * f->h, fmax(square / 4, square + slope / 2)));
    }
}

/* tanh(a x)/x */
static double tanh_ratio(double a, double x) { return fabs(a * x) < 1e-4 ? a : tanh(a * x) / x; }

/* Computes the elastic part of P at the faces. The viscous part, e P tanh(alpha_v s u_z), is kept as a drag
 * coefficient: its ratio to the velocity difference. The same holds for the floor. */
static void set_elastic_pressure(fluid *f, double dt) {
    const sp_tapped_spec *c = f->c;
    const double before = sp_tapped_floor(c, f->t) - f->edge;
    const double opening = f->u[0] - sp_tapped_floor_velocity(c, f->t + dt / 2);
    for (int64_t i = 1; i < f->used; i++) {
        f->pressure[i] = f->stiffness * (f->h - (f->high[i - 1] + f->low[i]) / 2);
        bool both = f->s[i - 1] < f->h && f->s[i] < f->h;
        double rate = c->alpha_v * (f->s[i - 1] + f->s[i]) / (2 * f->dx);
        f->drag[i] = both ? c->e * f->pressure[i] * tanh_ratio(rate, f->u[i] - f->u[i - 1]) : 0;
    }
    f->pressure[0] = 0;
    f->drag[0] = 2 * f->stiffness * fmax(0, before) * c->e * tanh_ratio(c->alpha_v, opening);
}

/* Whether the floor touches the column at the end of the step. */
static bool floor_touches(const fluid *f, double dt) {
    double free = f->u[0] - dt * (f->c->gravity + f->pressure[1] / (f->rho[0] * f->dx));
    return sp_tapped_floor(f->c, f->t + dt) > f->edge + dt * free;
}

/* Solves for the velocities at the end of the step, then adds the viscous part to P and computes P at the floor.
 * Returns the velocity of the edge, which is that of the first cell. The equations are implicit, because an explicit
 * drag would need steps of dx^2 m/(K e alpha_v h^3), a hundredth of what sound needs, and the floor even shorter ones
 * when the first cell is nearly empty. */
static double solve_velocities(fluid *f, double dt, bool touches) {
    const sp_tapped_spec *c = f->c;
    const double under = sp_tapped_floor_velocity(c, f->t + dt / 2), sunk = sp_tapped_floor(c, f->t + dt) - f->edge;
    const double spring = touches ? 2 * f->stiffness : 0;
    if (!touches)
        f->drag[0] = 0;
    for (int64_t i = 0; i < f->used; i++) { /* tridiagonal elimination (Thomas) */
        double above = i + 1 < f->used ? f->drag[i + 1] : 0, inertia = f->rho[i] * f->dx;
        f->pivot[i] = inertia + dt * (f->drag[i] + above);
        f->velocity[i] = inertia * f->u[i] - dt * ((i + 1 < f->used ? f->pressure[i + 1] : 0) - f->pressure[i]);
        if (touches)
            f->velocity[i] -= inertia * c->gravity * dt;
        if (i == 0) {
            f->pivot[i] += dt * dt * spring;
            f->velocity[i] += dt * (spring * sunk + f->drag[0] * under);
        } else if (f->drag[i] > 0) {
            double factor = dt * f->drag[i] / f->pivot[i - 1];
            f->pivot[i] -= factor * dt * f->drag[i];
            f->velocity[i] += factor * f->velocity[i - 1];
        }
    }
    for (int64_t i = f->used - 1; i >= 0; i--) {
        double above = i + 1 < f->used && f->drag[i + 1] > 0 ? dt * f->drag[i + 1] * f->velocity[i + 1] : 0;
        f->velocity[i] = f->pivot[i] > 0 ? (f->velocity[i] + above) / f->pivot[i] : f->u[i];
    }
    for (int64_t i = 1; i < f->used; i++)
        f->pressure[i] -= f->drag[i] * (f->velocity[i] - f->velocity[i - 1]);
    f->pressure[0] = fmax(0, spring * (sunk - dt * f->velocity[0]) - f->drag[0] * (f->velocity[0] - under));
    return f->velocity[0];
}

/* Density and velocity relative to the edge on one side of a face, and the fastest signal there. */
typedef struct face_state {
    double rho, u, fast;
} face_state;
static face_state state_at_face(const fluid *f, int64_t i, double s, double u) {
    bool any = f->rho[i] > empty_density * f->mean, touching = f->s[i] < f->h;
    return (face_state){.rho = touching ? f->m / s : f->rho[i],
                        .u = u,
                        .fast = any ? fabs(u) + (touching ? s * sqrt(f->stiffness / f->m) : 0) : 0};
}

static void transport(fluid *f, double dt, double edge) {
    double mass_in = 0, push_in = f->pressure[0];
    for (int64_t i = 0; i < f->used; i++) {
        double mass_out = 0, push_out = 0;
        if (i + 1 < f->used) {
            face_state l = state_at_face(f, i, f->high[i], f->u[i] + f->half_slope[i] - edge);
            face_state r = state_at_face(f, i + 1, f->low[i + 1], f->u[i + 1] - f->half_slope[i + 1] - edge);
            double fast = fmax(l.fast, r.fast), rise = r.rho * r.u - l.rho * l.u;
            mass_out = (l.rho * l.u + r.rho * r.u - fast * (r.rho - l.rho)) / 2;
            push_out = (l.rho * l.u * l.u + r.rho * r.u * r.u - fast * rise) / 2 + edge * mass_out + f->pressure[i + 1];
        }
        f->next_rho[i] = f->rho[i] - dt / f->dx * (mass_out - mass_in);
        f->next_q[i] = f->rho[i] * f->u[i] - dt / f->dx * (push_out - push_in);
        mass_in = mass_out;
        push_in = push_out;
    }
}

static void apply_gravity(fluid *f, double dt) {
    for (int64_t i = 0; i < f->used; i++)
        f->u[i] -= dt * f->c->gravity;
}

/* Merges a nearly empty lowest cell into the next, so that the edge is that of the matter. */
static void merge_thin_cells(fluid *f) {
    while (f->used > 2 && f->rho[0] < thin_density * f->mean && f->rho[1] > f->rho[0]) {
        f->rho[1] += f->rho[0];
        f->q[1] += f->q[0];
        f->used--;
        f->edge += f->dx;
        memmove(f->rho, f->rho + 1, (size_t)f->used * sizeof *f->rho);
        memmove(f->q, f->q + 1, (size_t)f->used * sizeof *f->q);
    }
}

/* Ensures that the top cell is empty. */
static sp_status ensure_empty_top(fluid *f, sp_error *err) {
    while (f->used < 2 || f->rho[f->used - 1] > empty_density * f->mean) {
        if (f->used == f->cells) {
            sp_status status = resize(f, f->cells + f->cells / 2, err);
            if (status != SP_OK)
                return status;
        }
        f->rho[f->used] = f->q[f->used] = 0;
        f->used++;
    }
    return SP_OK;
}

static void swap(double **a, double **b) {
    double *c = *a;
    *a = *b;
    *b = c;
}

/* Advances the fluid by one step, at most to `until`. */
static sp_status advance(fluid *f, double until, sp_error *err) {
    double dt = measure_cells(f), gravity = f->c->gravity, end;
    if (f->c->time_step > 0)
        dt = fmin(dt, f->c->time_step);
    sp_status status = sp_tapped_bsr_limit_step(f->t, until, &dt, &end, err);
    if (status != SP_OK)
        return status;
    reconstruct(f);
    set_elastic_pressure(f, dt);
    bool touches = floor_touches(f, dt);
    double early = touches ? 0 : dt / 2;
    apply_gravity(f, early);
    double edge = solve_velocities(f, dt, touches);
    transport(f, dt, edge);
    swap(&f->rho, &f->next_rho);
    swap(&f->q, &f->next_q);
    double sum = 0;
    for (int64_t i = 0; i < f->used; i++) {
        f->q[i] -= f->rho[i] * gravity * (dt - early);
        sum += f->rho[i] + f->q[i];
    }
    f->edge += dt * edge;
    status = sp_tapped_bsr_check_finite(sum + f->edge, f->t, err);
    if (status != SP_OK)
        return status;
    f->t = end;
    merge_thin_cells(f);
    return ensure_empty_top(f, err);
}

/* ---- the run ---------------------------------------------------------------------------------------------------- */

/* Puts particle i where the mass below is (i - 1/2) m, and records the error of the total mass. */
static void place(void *model, sp_tapped_frame *out) {
    fluid *f = model;
    double below = 0, all = f->c->particles * f->m;
    int32_t particle = 1;
    out->t = f->t;
    for (int64_t i = 0; i < f->used; i++) {
        double here = f->rho[i] * f->dx;
        for (; particle <= f->c->particles && (particle - 0.5) * f->m <= below + here; particle++) {
            out->y[particle] = f->edge + ((double)i + ((particle - 0.5) * f->m - below) / here) * f->dx;
            out->v[particle] = f->q[i] / f->rho[i];
            out->rho[particle - 1] = f->rho[i];
        }
        below += here;
    }
    f->mass_error = fmax(f->mass_error, fabs(below - all) / all);
}

static sp_status step(void *model, double until, const sp_tapped_frame *from, sp_tapped_frame *to, sp_error *err) {
    (void)from;
    sp_status status = advance(model, until, err);
    if (status == SP_OK)
        place(model, to);
    return status;
}

sp_status sp_tapped_conservative(const sp_tapped_spec *c, const sp_tapped_rows *rows, sp_tapped_report *report,
                                 sp_error *err) {
    fluid f = {0};
    const sp_tapped_bsr_scheme scheme = {&f, place, step};
    sp_status status = sp_tapped_check_equal(c, err);
    if (status == SP_OK)
        status = start(c, &f, err);
    if (status == SP_OK)
        status = ensure_empty_top(&f, err);
    if (status == SP_OK)
        status = sp_tapped_check_time_step(c, stable_step(&f), err);
    if (status == SP_OK)
        status = sp_tapped_bsr_integrate(c, &scheme, rows, report, err);
    report->error = f.mass_error;
    sp_free(f.block);
    return status;
}
