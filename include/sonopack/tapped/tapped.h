#ifndef SONOPACK_COLUMN_H
#define SONOPACK_COLUMN_H
/* The tapped column of particles (D. Blackmore, A. Rosato, X. Tricoche, K. Urban, V. Ratnaswamy, J. Mech. Mater.
 * Struct. 6, 2011, called [B] here): N balls one above the other on a floor that moves as a half sine at the start of
 * each period, with Walton-Braun contacts, under gravity; as particles, as a long-wave continuum, and by the model that
 * [B] calls BSR. Equation numbers are those of [B]; docs/physics.md has its errata. Units: cm, g, s.
 *
 * Contact i, 0 <= i < N, is between particle i + 1 and what is below it, the floor (0) or particle i. Its overlap is
 * delta_i, its force (18) is K (1 - e sgn w_i) delta_i where delta_i > 0, w_i the velocity at which it opens. Where w_i
 * = 0 the force is whatever keeps it so, within K (1 -+ e) delta_i: the contact sticks (Filippov's solution). */

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
    SP_TAPPED_BSR,         /* density and velocity over the height; see sp_tapped_bsr */
    SP_TAPPED_EQ35,        /* (35) as printed: refused, with what its symbol says */
    SP_TAPPED_EQ37         /* (37) as printed: likewise */
} sp_tapped_model;

/* How the lattice is solved. */
typedef enum sp_tapped_method {
    SP_TAPPED_EVENT = 0, /* exact: from event to event, with sticking */
    SP_TAPPED_SMOOTH,    /* sigma and chi of (30), by an adaptive Runge-Kutta scheme */
    SP_TAPPED_RK4        /* (9) with fixed steps as [B] has it: of first order, and creeps where it should stick */
} sp_tapped_method;

/* Which BSR. */
typedef enum sp_tapped_bsr {
    SP_TAPPED_BSR_CONSERVATIVE = 0, /* (rho, rho u) with a pressure: ours, for one that can carry a column */
    SP_TAPPED_BSR_LITERAL,          /* (45) as printed; the column collapses */
    SP_TAPPED_BSR_SIGNED            /* (45) with sgn(y) in the force and in sigma; collapses, too */
} sp_tapped_bsr;

typedef enum sp_tapped_output {
    SP_TAPPED_TRAJECTORY = 0, /* t y0 y1 .. yN */
    SP_TAPPED_STROBE,         /* tap t y1 .. yN density: at .99T, 1.99T, ... */
    SP_TAPPED_LYAPUNOV,       /* parameter lambda */
    SP_TAPPED_BIFURCATION,    /* parameter tap y1 .. yN */
    SP_TAPPED_ENERGY,         /* tap work dissipated energy residual rest separation ... */
    SP_TAPPED_DENSITY,        /* t y1 .. yN rho1 .. rhoN: density along the column */
    SP_TAPPED_COMPARE         /* t, differences of long-wave and BSR from the lattice */
} sp_tapped_output;

/* What a diagram (Lyapunov, bifurcation) goes through. */
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
    int32_t taps;     /* periods */
    double frequency; /* of the half sine, omega/(2 pi) [Hz] */
    double period;    /* T [s] */
    double amplitude; /* a [cm]; 0: the floor rests */
    double e;         /* 0 .. below 1 */
    double stiffness; /* K [g/s^2]; 0: 2 N m g/r, with the mean of m and the smallest r */
    double gravity;   /* [cm/s^2] */
    double drop;      /* height [cm] from which the column, just touching, falls onto the floor at t = 0; below 0: it
                         starts at rest, (27) */
    int32_t masses, radii; /* how many values the lists have: repeated from the floor upwards */
    const double *mass;    /* [g] */
    const double *radius;  /* [cm] */
    double step;           /* between rows of a trajectory [s]; 0: T/100 */
    double alpha_v;        /* of (30), for velocities [s/cm]; long wave, BSR and smooth lattice */
    double alpha_x;        /* of (30), for lengths [1/cm], smooth lattice; 0: the sharp step */
    double time_step; /* of continua and of RK4 [s]; 0: one that resolves the fastest motion, as far as it is stable */
    double tolerance; /* of the smooth lattice, relative */
    int32_t cells;    /* of continua: grid cells a particle */
    sp_tapped_parameter parameter;
    double from, to;             /* of the parameter */
    int32_t points;              /* of it, equally spaced; 1 and from 0: the spec's own value */
    int32_t transient;           /* taps of a diagram before the first that counts */
    bool (*stopped)(void *user); /* asked many times a second, of a diagram by all its threads; true ends the work with
                                    SP_EINTERRUPTED. NULL: nobody stops it */
    void *user;
} sp_tapped_spec;
/* [B]'s five particles: m = r = 1, a = 1.06, e = 0.09, g = 980.67, K = 2 N m g/r, T = 1 s, f = 7.5 Hz, four taps. */
SP_API sp_tapped_spec sp_tapped_spec_default(void);
/* SP_EINVAL: a value out of range; a tap longer than its period; K below (28), where the column collapses. The text
 * names the key, the value and the bound. */
SP_API sp_status sp_tapped_check(const sp_tapped_spec *c, sp_error *err);

SP_API int32_t sp_tapped_taps(const sp_tapped_spec *c);                    /* c->taps, with the default put in */
SP_API double sp_tapped_mass(const sp_tapped_spec *c, int32_t particle);   /* particle 1 .. N [g] */
SP_API double sp_tapped_radius(const sp_tapped_spec *c, int32_t particle); /* [cm] */
SP_API double sp_tapped_stiffness(const sp_tapped_spec *c);                /* K, with the default put in [g/s^2] */
/* The least K for which no overlap of the resting column reaches the distance of the centres, (28) [g/s^2]. */
SP_API double sp_tapped_stiffness_bound(const sp_tapped_spec *c);
/* y_1 .. y_N at rest, (27) for every k and its like for unequal particles; y [N], y[0] the lowest [cm]. */
SP_API void sp_tapped_rest(const sp_tapped_spec *c, double *y);
/* The floor (2) [cm], and its velocity (3) [cm/s] with that after a jump at the jump. t >= 0. */
SP_API double sp_tapped_floor(const sp_tapped_spec *c, double t);
SP_API double sp_tapped_floor_velocity(const sp_tapped_spec *c, double t);
/* Mass of the column over its length y_N + r_N - y_0 [g/cm]; y as in a row below. (42) for one that just touches. */
SP_API double sp_tapped_density(const sp_tapped_spec *c, const double *y);

/* One row: y [N + 1] and v [N + 1] at t, the floor first. Other statuses than SP_OK end the run. */
typedef sp_status (*sp_tapped_row)(double t, const double *y, const double *v, void *user, sp_error *err);

/* One tap: from its start to the start of the next. Energies in erg; lattice by events: to rounding. */
typedef struct sp_tapped_tap {
    double work;       /* of the floor, int F0 dy0 */
    double dissipated; /* sum over contacts of int e K delta |w| dt */
    double energy;     /* E at the end, kinetic, of gravity (0 at y = 0), and K delta^2/2 */
    double residual;   /* of the balance E - E_before = work - dissipated, over the largest of work, dissipated and
                          |E|/1000 */
    double rest;       /* time after the start of the tap when everything had come to rest; NAN: it had not */
    double separation; /* the smallest y_(i+1) - y_i [cm]; below 0: (1) is violated */
    double at;         /* when that was [s] */
    int32_t contact;   /* and at which */
} sp_tapped_tap;

typedef struct sp_tapped_report {
    int32_t taps;
    sp_tapped_tap *tap;    /* [taps] */
    double initial_energy; /* [erg] */
    double violated_at;    /* first time at which ordering (1) was violated [s]; NAN: never */
    int32_t violated;      /* contact of that violation, -1: none */
    int64_t events, steps;
    double error;     /* largest part of the state that a step leaves out (lattice); of mass (BSR) */
    double time_step; /* that was used, where it is fixed [s] */
} sp_tapped_report;
SP_API void sp_tapped_report_free(sp_tapped_report *r);

/* Runs the column for all its taps with the chosen model, and hands over rows at the n ascending times t (the continua:
 * at the labels of the particles). report may be NULL; else free it. SP_EINVAL (a time
 * step above the stable one too), SP_EREFUSED (equations (35), (37)), SP_EFAILED. */
SP_API sp_status sp_tapped_run(const sp_tapped_spec *c, int64_t n, const double *t, sp_tapped_row row, void *user,
                               sp_tapped_report *report, sp_error *err);
/* The table of c->output; diagrams with `threads` threads, the same for any number of them. */
SP_API sp_status sp_tapped_table(const sp_tapped_spec *c, int threads, sp_table *out, sp_error *err);
/* The share of the work that is done, 0 .. 1. false stops it: SP_EINTERRUPTED. */
typedef bool (*sp_tapped_watch)(double share, void *user);
typedef struct sp_tapped_watcher {
    sp_tapped_watch watch; /* NULL: nobody watches */
    void *user;
} sp_tapped_watcher;

/* The same under the eyes of somebody who may stop it; one thread watches. */
SP_API sp_status sp_tapped_table_watched(const sp_tapped_spec *c, int threads, sp_tapped_watcher watcher, sp_table *out,
                                         sp_error *err);

/* ---- continua --------------------------------------------------------------------------------------------------- */

/* Density of the continuum at the particles' labels, rho = m/(h y_z) (long wave) or interpolated (BSR), and of the
 * lattice, m over half the distance of the neighbours [g/cm], by the model of c; rho [N] for each of n times. */
typedef sp_status (*sp_tapped_density_row)(double t, const double *y, const double *rho, void *user, sp_error *err);
SP_API sp_status sp_tapped_run_density(const sp_tapped_spec *c, int64_t n, const double *t, sp_tapped_density_row row,
                                       void *user, sp_error *err);

/* Growth rate, the largest real part of s in y ~ exp(i k z + s t) [1/s], and phase speed squared [cm^2/s^2] of the
 * printed equations, linearised about y_z = slope: what makes them impossible to run. model: SP_TAPPED_EQ35,
 * SP_TAPPED_EQ37 or SP_TAPPED_LONGWAVE; alpha [1/cm] of (36), (38): 1/h in [B]. */
typedef struct sp_tapped_symbol {
    double growth, speed2;
} sp_tapped_symbol;
SP_API sp_status sp_tapped_symbol_at(const sp_tapped_spec *c, sp_tapped_model model, double alpha, double slope,
                                     double k, sp_tapped_symbol *out, sp_error *err);
/* c^2 at k = 0 of the expansion that (35) is meant to be, with its own coefficients put right [cm^2/s^2]: -1/6 K h^2/m
 * at slope 1 and alpha = 1/h, where the smooth lattice has +1/2. */
SP_API double sp_tapped_expansion_speed2(const sp_tapped_spec *c, double alpha, double slope);
/* Largest force over all z that the integral of (45) can give, over g: literal or signed. */
SP_API double sp_tapped_bsr_force(const sp_tapped_spec *c, sp_tapped_bsr which);

/* ---- dynamics --------------------------------------------------------------------------------------------------- */

/* State at the start of a tap: overlaps (negative: gaps) [cm] and velocities at which contacts open [cm/s], [N] each.
 */
typedef struct sp_tapped_state {
    double *overlap, *opening;
} sp_tapped_state;
SP_API sp_status sp_tapped_state_make(const sp_tapped_spec *c, sp_tapped_state *out,
                                      sp_error *err); /* at rest, or dropped */
SP_API void sp_tapped_state_free(sp_tapped_state *s);
/* The stroboscopic map: the state after `periods` taps, and its derivative [2N][2N], row major, of (overlaps, openings)
 * by the same, saltations of events included; derivative may be NULL. */
SP_API sp_status sp_tapped_map(const sp_tapped_spec *c, sp_tapped_state *s, int32_t periods, double *derivative,
                               sp_error *err);
/* Positions and velocities [N] of a state at the start of a tap. */
SP_API void sp_tapped_positions(const sp_tapped_spec *c, const sp_tapped_state *s, double *y, double *v);
/* Largest Lyapunov exponent a tap, after c->transient taps. Where the orbit is a cycle by then (up to 32 taps, 64
 * particles), from the largest of its multipliers, right to some 1e-8; else by the growth of one tangent over c->taps
 * taps (Benettin et al., Meccanica 15, 1980) in a smooth average. -INFINITY where tangents vanish. */
typedef struct sp_tapped_exponent {
    double lambda;
    double error;  /* difference from the next time round the cycle, or from the average over the first half; of chaos
                      the standard error by blocks of taps, if that is larger */
    int32_t cycle; /* taps; 0: none */
    bool violated; /* ordering (1), within the transient or the cycle looked for */
} sp_tapped_exponent;
SP_API sp_status sp_tapped_lyapunov(const sp_tapped_spec *c, sp_tapped_exponent *out, sp_error *err);

#ifdef __cplusplus
}
#endif
#endif
