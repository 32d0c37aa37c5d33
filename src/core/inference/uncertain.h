#ifndef SP_UNCERTAIN_H
#define SP_UNCERTAIN_H
/* Parts of the errors of a measured packing: packings drawn with errors, what is measured on them, and the two ways. */

#include <sonopack/sensitivity.h>
#include <sonopack/uncertainty.h>

/* ---- packings with errors of measurement ------------------------------------------------------------------------ */

/* A grain and another one, or a wall, that do not touch as listed but may. */
typedef struct sp_near {
    int32_t i, j;
} sp_near;

/* What all draws of a packing share. */
typedef struct sp_drawing {
    const sp_packing *p;
    const sp_errors *errors;
    int32_t candidates;
    sp_near *candidate; /* [candidates] pairs within the gap that are not listed */
    double mean_force;  /* of the listed contacts above the threshold 0 */
} sp_drawing;

/* Copies grains and walls, without the scene: with space for so many contacts, and none. */
sp_status sp_drawing_copy(const sp_packing *p, int32_t room, sp_packing *out, sp_error *err);
sp_status sp_errors_check(const sp_errors *e, sp_error *err);
/* Does not copy p and errors. */
sp_status sp_drawing_make(const sp_packing *p, const sp_errors *errors, sp_drawing *out, sp_error *err);
void sp_drawing_free(sp_drawing *d);
/* sp_packing_perturb. */
sp_status sp_drawing_draw(const sp_drawing *d, uint64_t seed, int64_t sample, sp_packing *out, sp_error *err);

/* ---- quantities -------------------------------------------------------------------------------------------------- */

enum { SP_FRONT_MARKS = 5 };

/* The numbers that the sound of a packing has: marks of the front, moduli, speeds, frequencies. Which of them, for all
 * draws of one packing. */
typedef struct sp_quantities {
    const sp_uncertainty_options *opt;
    int fronts, moduli; /* number of marks of the front, 0 or SP_FRONT_MARKS, then of moduli, then of modes */
    int32_t modes, n;   /* n: of all quantities */
    sp_modulus modulus[SP_MODULUS_COUNT];
    double window; /* last time of the signals */
} sp_quantities;

sp_quantities sp_quantities_of(const sp_network *net, const sp_uncertainty_options *opt);
void sp_quantity_name(const sp_quantities *q, int32_t k, char name[24], char unit[40]);
/* value [q->n] of a packing; *contacts: its carrying contacts. NAN where a modulus is undefined. */
sp_status sp_quantities_measure(const sp_quantities *q, const sp_packing *p, double *value, int32_t *contacts,
                                sp_error *err);

/* The times on which fronts are looked for: spacing, and points up to the window. */
double sp_inference_spacing(double pressure);
/* The signal between the walls on these times. */
sp_status sp_inference_signal(const sp_network *net, sp_source source, double window, sp_signal *out, sp_error *err);

/* ---- the two ways ------------------------------------------------------------------------------------------------ */

/* First order: fills in first_order, shift and share of out->quantity; NAN where there are no derivatives. p: the
 * packing without errors (of overlaps: with contacts from its positions). */
sp_status sp_uncertain_first_order(const sp_quantities *q, const sp_drawing *d, const sp_packing *p,
                                   sp_uncertainty *out, sp_error *err);
#endif
