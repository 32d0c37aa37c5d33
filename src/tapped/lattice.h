#ifndef SP_TAPPED_LATTICE_H
#define SP_TAPPED_LATTICE_H
/* The lattice (19) between events. Coordinates are the overlaps of the contacts and the velocities at which they open,
 * so that a contact that sticks keeps its overlap to the last bit, and w = 0 and delta = 0 are exact at events.
 * Sticking contacts join particles to clusters; the contacts between clusters ("movers") obey a linear system, which is
 * stepped by its Taylor series. */

#include "tapped/column.h"

enum { LATTICE_ORDER = 30 }; /* highest power of a step's series */
enum { LATTICE_FEW = 4 };    /* movers for which loops have a constant length */

typedef enum contact_state { CONTACT_OPEN = 0, CONTACT_APPROACHING, CONTACT_SEPARATING, CONTACT_STUCK } contact_state;

typedef struct sp_lattice {
    const sp_tapped_spec *spec;
    int32_t n;
    double k, e, g, weight;
    double a, omega, tap_end, period; /* of the floor; the half sine ends at tap_end */
    double fastest;                   /* bound of the frequencies of all contacts closed [1/s] */
    double *mass, *distance;          /* [n]: of the particle above a contact; of the centres where it just touches */

    double s;                        /* time since the start of the tap */
    bool lifted;                     /* the floor moves */
    double *delta, *w;               /* [n] */
    unsigned char *state, *released; /* released: sticking ended with relative acceleration 0 */
    double *anchor; /* overlap where the present way of a closed contact began: its dissipation is e K/2 |delta^2 -
                       that^2| */
    double *slack;  /* how far a sticking contact's force may lie outside of its band: rounding */
    double spent;   /* dissipated [erg] */

    int32_t movers, closed, lanes;    /* lanes: of the loops, at least as many as movers */
    int32_t *mover;                   /* [movers + 1]: contacts that do not stick, ascending; then n */
    double *stiffness, *inverse_mass; /* of movers, and of the clusters above them */
    double *carried;                  /* [n]: mass above a contact inside of its cluster */

    double truncation; /* largest part that a step's series left out, of the state */
    int order; /* of the series at s; c[power * stride + mover] of the overlaps, floor[power] of y0'' (+ g in power 0)
                */
    int32_t stride;
    double *c, floor[LATTICE_ORDER + 1];
    double *force, *pull, *value, *slope; /* scratch, [stride] */

    int tangents; /* vectors that are carried along: of overlaps and of openings, [tangents][n] */
    double *t_delta, *t_w, *t_c, *before, *after;
} sp_lattice;

/* Memory and constants; the spec must outlive it. Free after failure, too. */
sp_status sp_lattice_make(const sp_tapped_spec *c, int tangents, sp_lattice *out, sp_error *err);
void sp_lattice_free(sp_lattice *l);
/* The column at rest or dropped, before its first tap. */
void sp_lattice_start(sp_lattice *l);
/* States of contacts from overlaps and openings alone. */
void sp_lattice_judge(sp_lattice *l);
/* Clusters, after any change of states. */
void sp_lattice_group(sp_lattice *l);
/* Series of the movers for a step up to h. */
void sp_lattice_expand(sp_lattice *l, double h);
/* Overlap and opening of a mover at tau in the step, from the series. */
void sp_lattice_motion(const sp_lattice *l, int32_t mover, double tau, double *overlap, double *opening);
/* Ends the step at tau: overlaps, openings, tangents. Time stays. */
void sp_lattice_advance(sp_lattice *l, double tau);
/* Rates dw/dt of all contacts at the present state, [n]. */
void sp_lattice_rates(sp_lattice *l, double *rate);
/* Acceleration y0'' of the floor at s, and its rate. */
double sp_lattice_floor_acceleration(const sp_lattice *l);
double sp_lattice_floor_jerk(const sp_lattice *l);

/* ---- events ----------------------------------------------------------------------------------------------------- */

typedef enum event_kind { EVENT_NONE = 0, EVENT_CLOSE, EVENT_OPEN, EVENT_TURN, EVENT_SLIP } event_kind;
typedef struct lattice_event {
    event_kind kind;
    int32_t contact;
    double tau;
} lattice_event;
/* The first event of the series within h; none: kind EVENT_NONE and tau = h. */
lattice_event sp_lattice_next_event(sp_lattice *l, double h);
/* First tau in [0, h] where the polynomial of degree n rises through zero, from below; certain to be the first, by
 * bounds of its second derivative. INFINITY: none. */
double sp_first_root(const double *f, int n, double h);

/* ---- sticking --------------------------------------------------------------------------------------------------- */

/* Decides which contacts stick among those with w = 0 and delta > 0 that hang together with contact `at` (between
 * contacts that move), and which way the others go. cause: the contact whose force left its band, or -1. */
void sp_lattice_stick(sp_lattice *l, int32_t at, int32_t cause);
/* The string through a tube of n nodes at x (ascending) between lo and hi, taut from (x0, f0) to the end, where it is
 * at (x_end, f_end) or, free, has slope_end. f [n]: its heights; bend [n]: by how much its slope falls at a node; 0
 * exactly where it is straight. */
typedef struct taut_ends {
    double x0, f0;
    bool free;
    double x_end, f_end, slope_end;
} taut_ends;
void sp_taut_string(int32_t n, const double *x, const double *lo, const double *hi, const taut_ends *ends, double *f,
                    double *bend);

#endif
