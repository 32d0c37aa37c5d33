#ifndef SONOPACK_COLUMN_H
#define SONOPACK_COLUMN_H
/* The tapped column: N spheres on top of each other, under gravity, on a floor that moves as a half sine at the start
 * of each period, with Walton-Braun contacts. Source: D. Blackmore, A. Rosato, X. Tricoche, K. Urban, V. Ratnaswamy,
 * J. Mech. Mater. Struct. 6 (2011), called [B]. Equation numbers are those of [B]; docs/physics.md lists its errata.
 * There are three models: the particles ("lattice"), a long-wave continuum, and the BSR equations of [B].
 * Units: cm, g, s.
 *
 * Contact i, 0 <= i < N, lies between particle i + 1 and what is below it: the floor (i = 0) or particle i. It has the
 * overlap delta_i and the opening velocity w_i. Its force (18) is K (1 - e sgn w_i) delta_i where delta_i > 0. At
 * w_i = 0 the contact sticks if a force within K (1 -+ e) delta_i can keep w_i at zero (Filippov's solution). */

#include <sonopack/status.h>
#include <sonopack/table.h>
#include <stdbool.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

typedef enum sp_tapped_model {
    SP_TAPPED_LATTICE = 0, /* particles, (19) */
    SP_TAPPED_LONGWAVE,    /* a well-posed long-wave limit of (19) */
    SP_TAPPED_BSR,         /* density and velocity as functions of height, see sp_tapped_bsr */
    SP_TAPPED_EQ35,        /* (35) as printed: ill posed, refused */
    SP_TAPPED_EQ37         /* (37) as printed: ill posed, refused */
} sp_tapped_model;

/* Solver of the lattice. */
typedef enum sp_tapped_method {
    SP_TAPPED_EVENT = 0, /* exact, from event to event, with sticking */
    SP_TAPPED_SMOOTH,    /* smooth sigma and chi of (30), adaptive Runge-Kutta scheme */
    SP_TAPPED_RK4        /* sigma of (9) with fixed steps, as in [B]: first order, creeps where contacts should stick */
} sp_tapped_method;

/* Variant of the BSR model. */
typedef enum sp_tapped_bsr {
    SP_TAPPED_BSR_CONSERVATIVE = 0, /* mass and momentum with a pressure that carries the column; not in [B] */
    SP_TAPPED_BSR_LITERAL,          /* (45) as printed; the column collapses */
    SP_TAPPED_BSR_SIGNED            /* (45) with sgn(y) in the force and in sigma; the column collapses, too */
} sp_tapped_bsr;

/* Output, with the columns of its table. */
typedef enum sp_tapped_output {
    SP_TAPPED_TRAJECTORY = 0, /* t y0 y1 .. yN */
    SP_TAPPED_STROBE,         /* tap t y1 .. yN density, at .99T, 1.99T, ... */
    SP_TAPPED_LYAPUNOV,       /* parameter lambda error cycle */
    SP_TAPPED_BIFURCATION,    /* parameter tap y1 .. yN */
    SP_TAPPED_ENERGY,         /* tap work dissipated energy residual rest separation ... */
    SP_TAPPED_DENSITY,        /* t y1 .. yN rho1 .. rhoN */
    SP_TAPPED_COMPARE         /* t, differences of long-wave and BSR from the lattice */
} sp_tapped_output;

/* The parameter that a Lyapunov or bifurcation diagram varies. */
typedef enum sp_tapped_parameter {
    SP_TAPPED_BY_AMPLITUDE = 0,
    SP_TAPPED_BY_PERIOD,
    SP_TAPPED_BY_FREQUENCY,
    SP_TAPPED_BY_RESTITUTION /* e */
} sp_tapped_parameter;

typedef struct sp_tapped_spec {
    sp_tapped_model model;
    sp_tapped_method method;
    sp_tapped_bsr bsr;
    sp_tapped_output output;
    int32_t particles;
    int32_t taps;          /* number of periods; 0: the default of the output, see sp_tapped_taps */
    double frequency;      /* of the half sine, omega/(2 pi) [Hz] */
    double period;         /* T [s] */
    double amplitude;      /* a [cm]; 0: the floor rests */
    double e;              /* 0 <= e < 1 */
    double stiffness;      /* K [g/s^2]; 0: 2 N m g/r, with the mean of m and the smallest r */
    double gravity;        /* [cm/s^2] */
    double drop;           /* the column starts at this height above the floor, its particles just touching [cm]; -1: it
                              starts at rest, (27) */
    int32_t masses, radii; /* lengths of the lists, which repeat from the floor upwards */
    const double *mass;    /* [g] */
    const double *radius;  /* [cm] */
    double step;           /* between rows of a trajectory [s]; 0: T/100 */
    double alpha_v;        /* alpha of (30) for velocities [s/cm]; long wave, BSR and smooth lattice */
    double alpha_x;        /* alpha of (30) for lengths [1/cm]; smooth lattice; 0: the sharp step */
    double time_step;      /* of the continua and RK4 [s]; 0: chosen, stable and short enough for the fastest motion */
    double tolerance;      /* relative, of the smooth lattice */
    int32_t cells;         /* grid cells per particle, of the continua */
    sp_tapped_parameter parameter;
    double from, to;             /* range of the parameter */
    int32_t points;              /* equally spaced values of it; 1 with from = 0: the value in this spec */
    int32_t transient;           /* taps of a diagram that are discarded first */
    bool (*stopped)(void *user); /* called many times a second, in diagrams by all threads; returning true ends the run
                                    with SP_EINTERRUPTED. May be NULL */
    void *user;
} sp_tapped_spec;
/* The five particles of [B]: m = r = 1, a = 1.06, e = 0.09, g = 980.67, K = 2 N m g/r, T = 1 s, f = 7.5 Hz, 4 taps. */
SP_API sp_tapped_spec sp_tapped_spec_default(void);
/* Returns SP_EINVAL if a value is out of range, a tap is longer than its period, or K is below (28), where the column
 * collapses. The message names the key, the value and the bound. */
SP_API sp_status sp_tapped_check(const sp_tapped_spec *c, sp_error *err);

/* The values that a run uses, with defaults filled in. particle: 1 .. N. */
SP_API int32_t sp_tapped_taps(const sp_tapped_spec *c);
SP_API double sp_tapped_mass(const sp_tapped_spec *c, int32_t particle);   /* [g] */
SP_API double sp_tapped_radius(const sp_tapped_spec *c, int32_t particle); /* [cm] */
SP_API double sp_tapped_stiffness(const sp_tapped_spec *c);                /* K [g/s^2] */
/* Lower bound of K: at rest no overlap may reach the distance of the centres, (28) [g/s^2]. */
SP_API double sp_tapped_stiffness_bound(const sp_tapped_spec *c);
/* Writes y_1 .. y_N at rest to y [N], the lowest first [cm]: (27), generalised to unequal particles. */
SP_API void sp_tapped_rest(const sp_tapped_spec *c, double *y);
/* Position (2) [cm] and velocity (3) [cm/s] of the floor at t >= 0. At a jump, the velocity after it. */
SP_API double sp_tapped_floor(const sp_tapped_spec *c, double t);
SP_API double sp_tapped_floor_velocity(const sp_tapped_spec *c, double t);
/* Mass of the column over its length y_N + r_N - y_0 [g/cm], for y [N + 1] with the floor first. For a column that
 * just touches this is (42). */
SP_API double sp_tapped_density(const sp_tapped_spec *c, const double *y);

/* Receives one row of a run: positions y [N + 1] and velocities v [N + 1] at t, the floor first. A status other than
 * SP_OK ends the run. */
typedef sp_status (*sp_tapped_row)(double t, const double *y, const double *v, void *user, sp_error *err);

/* Results of one tap, from its start to the start of the next. Energies in erg; by events they are exact to rounding.
 */
typedef struct sp_tapped_tap {
    double work;       /* of the floor, int F0 dy0 [erg] */
    double dissipated; /* sum over contacts of int e K delta |w| dt [erg] */
    double energy;     /* E at the end: kinetic, m g y, and K delta^2/2 [erg] */
    double residual;   /* of the balance E - E_before = work - dissipated, relative to the largest of work, dissipated
                          and |E|/1000 */
    double rest;       /* time after the start of the tap at which everything is at rest [s]; NAN: never */
    double separation; /* smallest y_(i+1) - y_i [cm]; negative: ordering (1) is violated */
    double at;         /* time of that separation [s] */
    int32_t contact;   /* contact of that separation */
} sp_tapped_tap;

typedef struct sp_tapped_report {
    int32_t taps;
    sp_tapped_tap *tap;    /* [taps] */
    double initial_energy; /* [erg] */
    double violated_at;    /* first time at which ordering (1) is violated [s]; NAN: never */
    int32_t violated;      /* contact of that violation; -1: none */
    int64_t events, steps;
    double error;     /* lattice: largest truncation or tolerance, relative; BSR: relative error of the mass */
    double time_step; /* smallest or fixed step [s]; 0: not applicable */
} sp_tapped_report;
SP_API void sp_tapped_report_free(sp_tapped_report *r);

/* Runs the column over all taps with the model of c, and passes rows at the n ascending times t to `row`; the continua
 * give positions at the labels of the particles. row may be NULL if n is 0. report may be NULL; otherwise free it.
 * Errors: SP_EINVAL (also for an unstable time step), SP_EREFUSED for (35) and (37), SP_EINTERRUPTED, SP_EFAILED. */
SP_API sp_status sp_tapped_run(const sp_tapped_spec *c, int64_t n, const double *t, sp_tapped_row row, void *user,
                               sp_tapped_report *report, sp_error *err);
/* Makes the table of c->output. threads: for diagrams; the result does not depend on their number. */
SP_API sp_status sp_tapped_table(const sp_tapped_spec *c, int threads, sp_table *out, sp_error *err);
/* Receives the share of the work that is done, 0 .. 1. Returning false ends the work with SP_EINTERRUPTED. */
typedef bool (*sp_tapped_watch)(double share, void *user);
typedef struct sp_tapped_watcher {
    sp_tapped_watch watch; /* may be NULL */
    void *user;
} sp_tapped_watcher;

/* As sp_tapped_table, with progress reports; only one thread calls the watcher. */
SP_API sp_status sp_tapped_table_watched(const sp_tapped_spec *c, int threads, sp_tapped_watcher watcher, sp_table *out,
                                         sp_error *err);

/* ---- continua --------------------------------------------------------------------------------------------------- */

/* Runs the model of c and passes the densities rho [N] at the particles [g/cm] at n times. Long wave: rho = m/(h y_z).
 * BSR: interpolated. Lattice: mass over half the distances to the neighbours. Errors as for sp_tapped_run. */
typedef sp_status (*sp_tapped_density_row)(double t, const double *y, const double *rho, void *user, sp_error *err);
SP_API sp_status sp_tapped_run_density(const sp_tapped_spec *c, int64_t n, const double *t, sp_tapped_density_row row,
                                       void *user, sp_error *err);

/* Linear waves y ~ exp(i k z + s t) about y_z = slope: growth rate, the largest real part of s [1/s], and squared phase
 * speed [cm^2/s^2]. It shows why the printed equations cannot be run. model: SP_TAPPED_EQ35, SP_TAPPED_EQ37 or
 * SP_TAPPED_LONGWAVE; alpha [1/cm] of (36) and (38), 1/h in [B]; k [1/cm]. Errors: SP_EINVAL. */
typedef struct sp_tapped_symbol {
    double growth, speed2;
} sp_tapped_symbol;
SP_API sp_status sp_tapped_symbol_at(const sp_tapped_spec *c, sp_tapped_model model, double alpha, double slope,
                                     double k, sp_tapped_symbol *out, sp_error *err);
/* c^2 at k = 0 of the expansion that (35) is meant to be, with corrected coefficients [cm^2/s^2]. At slope 1 and alpha
 * = 1/h it is -1/6 K h^2/m, whereas the smooth lattice has +1/2. */
SP_API double sp_tapped_expansion_speed2(const sp_tapped_spec *c, double alpha, double slope);
/* Largest force over all z that the integral of (45) can give, over m g. which: literal or signed; others give NAN. */
SP_API double sp_tapped_bsr_force(const sp_tapped_spec *c, sp_tapped_bsr which);

/* ---- dynamics --------------------------------------------------------------------------------------------------- */

/* State at the start of a tap: overlaps [N] (negative: gaps) [cm] and opening velocities [N] of the contacts [cm/s]. */
typedef struct sp_tapped_state {
    double *overlap, *opening;
} sp_tapped_state;
/* The initial state: at rest, or dropped. Free it. */
SP_API sp_status sp_tapped_state_make(const sp_tapped_spec *c, sp_tapped_state *out, sp_error *err);
SP_API void sp_tapped_state_free(sp_tapped_state *s);
/* The stroboscopic map: advances s by `periods` taps. derivative [2N][2N], row major, is that of (overlaps, openings)
 * with respect to themselves, including the saltations at events; it may be NULL. */
SP_API sp_status sp_tapped_map(const sp_tapped_spec *c, sp_tapped_state *s, int32_t periods, double *derivative,
                               sp_error *err);
/* Writes positions and velocities [N] of a state at the start of a tap. */
SP_API void sp_tapped_positions(const sp_tapped_spec *c, const sp_tapped_state *s, double *y, double *v);
/* Largest Lyapunov exponent per tap, after c->transient taps. If the orbit is then a cycle (of up to 32 taps, for up to
 * 64 particles), it follows from the largest multiplier, to about 1e-8. Otherwise it is a smooth average of the growth
 * of one tangent over c->taps taps (Benettin et al., Meccanica 15, 1980). -INFINITY where tangents vanish. */
typedef struct sp_tapped_exponent {
    double lambda;
    double error;  /* cycle: difference from the next round, and at least 1e-13; else from the average over the first
                      half of the taps, or in chaos the standard error of block means if that is larger */
    int32_t cycle; /* length in taps; 0: none */
    bool violated; /* ordering (1), during the transient or the search for a cycle */
} sp_tapped_exponent;
SP_API sp_status sp_tapped_lyapunov(const sp_tapped_spec *c, sp_tapped_exponent *out, sp_error *err);

#ifdef __cplusplus
}
#endif
#endif
