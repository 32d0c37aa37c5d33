#ifndef SP_QUANTITIES_H
#define SP_QUANTITIES_H
/* The numbers that the sound of a packing has: marks of the front, moduli, speeds, frequencies. */

#include <sonopack/front.h>
#include <sonopack/signal.h>
#include <sonopack/uncertainty.h>

enum { SP_FRONT_MARKS = 5, SP_MODULI_MOST = 11 };

/* Which of them, for all draws of one packing. */
typedef struct sp_quantities {
    const sp_uncertainty_options *opt;
    bool front, moduli;
    int dim;
    double window; /* last time of the signals */
    int32_t modes;
    int32_t n; /* of all quantities */
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

#endif
