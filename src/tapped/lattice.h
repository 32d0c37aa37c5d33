#ifndef SP_TAPPED_LATTICE_H
#define SP_TAPPED_LATTICE_H
/* The lattice (19) between events. The coordinates are the overlaps of the contacts and their opening velocities. A
 * sticking contact then keeps its overlap to the last bit, and w = 0 and delta = 0 hold exactly at events. Sticking
 * contacts join particles into clusters. The contacts between clusters ("movers") obey a linear system, which is
 * advanced by its Taylor series. */

#include "tapped/column.h"

enum { LATTICE_ORDER = 30 }; /* highest power of the Taylor series */
enum { LATTICE_FEW = 4 };    /* up to this number of movers, loops have a constant length */

typedef enum contact_state { CONTACT_OPEN = 0, CONTACT_APPROACHING, CONTACT_SEPARATING, CONTACT_STUCK } contact_state;

typedef struct sp_lattice {
    const sp_tapped_spec *spec;
    int32_t n;
    double k, e, g, weight;
    double a, omega, tap_end, period; /* of the floor; the half sine ends at tap_end */
    double fastest;                   /* upper bound of the angular frequencies with all contacts closed [1/s] */
    double *mass,
        *distance; /* [n]: mass of the particle above the contact; distance of the centres when it just touches */

    double s;                        /* time since the start of the tap */
    bool floor_moves;                /* whether the floor moves */
    double *delta, *w;               /* [n] */
    unsigned char *state, *released; /* released: sticking ended with relative acceleration 0 */
    double *anchor; /* overlap at which the contact's motion last changed direction; the energy dissipated since then is
                       e K/2 |delta^2 - anchor^2| */
    double *slack;  /* how far rounding may put the force of a sticking contact outside its band */
    double dissipated; /* dissipated energy [erg] */

    int32_t movers, closed, lanes;    /* lanes: length of the loops over movers, at least their number */
    int32_t *mover;                   /* [movers + 1]: contacts that do not stick, ascending; then n */
    double *stiffness, *inverse_mass; /* of each mover, and of the cluster above it */
    double *carried;                  /* [n]: mass above a contact within its cluster */

    double truncation; /* largest truncation error of a series, relative to the state */
    int order; /* of the series at s: c[power * stride + mover] for the overlaps, floor[power] for y0'' (plus g in power
                  0) */
    int32_t stride;
    double *c, floor[LATTICE_ORDER + 1];
    double *force, *acceleration, *value, *slope; /* scratch memory, [stride] */

    int tangents; /* number of tangent vectors; each holds overlaps and opening velocities, [tangents][n] */
    double *t_delta, *t_w, *t_c, *before, *after;
    double *block; /* memory of all arrays of numbers */
} sp_lattice;

/* Allocates the memory and sets the constants. The spec must outlive the lattice. Free it after a failure, too. */
sp_status sp_lattice_make(const sp_tapped_spec *c, int tangents, sp_lattice *out, sp_error *err);
void sp_lattice_free(sp_lattice *l);
/* Finds the clusters; to be called after any change of the states. */
void sp_lattice_find_clusters(sp_lattice *l);
/* Expands the motion of the movers for a step of at most h. */
void sp_lattice_expand(sp_lattice *l, double h);
/* Evaluates the series of one mover at tau within the step. */
void sp_lattice_motion(const sp_lattice *l, int32_t mover, double tau, double *overlap, double *opening);
/* Advances overlaps, opening velocities and tangents to tau. The time s is left to the caller. */
void sp_lattice_advance(sp_lattice *l, double tau);
/* Relative accelerations dw/dt of all contacts in the present state, [n]. */
void sp_lattice_rates(sp_lattice *l, double *rate);
/* Acceleration y0'' of the floor at s, and its derivative. */
double sp_lattice_floor_acceleration(const sp_lattice *l);
double sp_lattice_floor_jerk(const sp_lattice *l);

/* ---- events ----------------------------------------------------------------------------------------------------- */

typedef enum event_kind { EVENT_NONE = 0, EVENT_CLOSE, EVENT_OPEN, EVENT_TURN, EVENT_SLIP } event_kind;
typedef struct lattice_event {
    event_kind kind;
    int32_t contact;
    double tau;
} lattice_event;
/* Finds the first event within h. Without one, returns EVENT_NONE and tau = h. */
lattice_event sp_lattice_next_event(sp_lattice *l, double h);
/* First tau in [0, h] at which the polynomial f of degree n crosses zero from below; INFINITY if there is none. Bounds
 * of the second derivative guarantee that it is the first. */
double sp_first_root(const double *f, int n, double h);

/* ---- which contacts stick, and the states of all contacts ------------------------------------------------------- */

/* Decides which contacts stick, in the connected run of contacts with w = 0 and delta > 0 around contact `at`, and in
 * which direction the others start to move. cause: the contact whose force has left its band, or -1. */
void sp_lattice_stick(sp_lattice *l, int32_t at, int32_t cause);

/* Initial state: at rest, or dropped, before the first tap. */
void sp_lattice_start(sp_lattice *l);
/* Sets overlaps and opening velocities [n], and finds the states; reads them. */
void sp_lattice_set(sp_lattice *l, const double *overlap, const double *opening);
void sp_lattice_get(const sp_lattice *l, double *overlap, double *opening);

/* Finds the shortest path through a tube of n nodes at x (ascending) between lo and hi. It starts at
 * (x0, f0) and ends at (x_end, f_end) or, if free, with slope_end. f [n] receives its heights, bend [n] the decrease of
 * its slope at each node, exactly 0 where it is straight. */
typedef struct taut_ends {
    double x0, f0;
    bool free;
    double x_end, f_end, slope_end;
} taut_ends;
void sp_taut_string(int32_t n, const double *x, const double *lo, const double *hi, const taut_ends *ends, double *f,
                    double *bend);

#endif
