#ifndef SP_SENSOR_H
#define SP_SENSOR_H
/* Sources and detectors of the nonlinear motion of a packing. */

#include "packing/vibrate.h"

/* A detector: a sum of changes of contact forces on their first grains, with signs. */
typedef struct motion_sensor {
    int axis;
    int32_t n;
    int32_t *touch;
    double *sign;
} motion_sensor;

/* net: the network of p. Free it after a failure, too. */
sp_status sp_sensor_make(const sp_packing *p, const sp_network *net, const vibration *m, const sp_place *at,
                         motion_sensor *out, sp_error *err);
void sp_sensor_free(motion_sensor *e);
double sp_sensor_read(const vibration *m, const motion_sensor *e);

/* Mean overlap of the contacts that carry the network. */
double sp_mean_overlap(const sp_packing *p, const sp_network *net);
/* Gives the grains at rest the source [dofs] (momenta or displacements) times the factor that it returns: the largest
 * displacement, or velocity over omega_max, of a grain becomes `largest`. */
double sp_vibration_kick(vibration *m, const sp_network *net, const double *source, bool momenta, double largest);

#endif
