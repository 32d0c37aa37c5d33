#ifndef SP_TAPPED_MARCH_H
#define SP_TAPPED_MARCH_H
/* The way through the taps that all models with explicit time steps go: from one jump of the floor's velocity to the
 * next, never over one; rows by a side step from the last state, so that what is asked for changes nothing; energies
 * and separations for the report. */

#include "tapped/column.h"

/* The floor within a tap, s after its start, with the left-hand limits at the end of a phase, which (2) and (3) leave
 * open. */
typedef struct sp_tapped_phase {
    double amplitude, omega; /* 0: the floor rests */
} sp_tapped_phase;

static inline double sp_tapped_phase_floor(const sp_tapped_phase *p, double s) {
    return p->amplitude * sin(p->omega * s);
}
static inline double sp_tapped_phase_velocity(const sp_tapped_phase *p, double s) {
    return p->amplitude * p->omega * cos(p->omega * s);
}

/* What a model brings. A state of `size` numbers ends with the work of the floor and the dissipated energy. */
typedef struct sp_tapped_marcher {
    void *model;
    int64_t size;
    sp_tapped_phase *phase; /* of the model, set by the march */
    /* Longest step from a state. */
    double (*longest)(void *model, double s, const double *state);
    /* One step of h from s; the error over the tolerance, above 1: not accepted; 0 where steps are fixed. */
    double (*step)(void *model, double s, double h, const double *from, double *to);
    /* What the error of a step of h says about the next; NULL where steps are fixed. */
    void (*judge)(void *model, double h, double error);
    /* y_1 .. y_N and v_1 .. v_N to y[1], v[1], ... */
    void (*particles)(void *model, const double *state, double *y, double *v);
    double (*energy)(void *model, double floor, const double *state);
    const char *stiff; /* the key that makes steps short */
} sp_tapped_marcher;

/* As sp_tapped_run, from the state given, which is overwritten. */
typedef struct sp_tapped_rows {
    int64_t n;
    const double *t;
    sp_tapped_row row;
    void *user;
} sp_tapped_rows;
sp_status sp_tapped_march(const sp_tapped_spec *c, const sp_tapped_marcher *m, double *state,
                          const sp_tapped_rows *rows, sp_tapped_report *report, sp_error *err);

#endif
