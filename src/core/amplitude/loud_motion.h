#ifndef SP_AMPLITUDE_LOUD_MOTION_H
#define SP_AMPLITUDE_LOUD_MOTION_H
/* One run of the nonlinear motion: records of forces, marks of contacts, energies. */

#include "signal/sensor.h"

#include <sonopack/amplitude.h>

/* What has happened to a contact, in bits. */
enum { CONTACT_SLID = 1, CONTACT_OPENED = 2, CONTACT_CLOSED = 4 };

#define SP_MOTION_NEAR 0.4

typedef struct motion {
    const sp_packing *packing;
    const sp_network *net; /* with prestress */
    vibration m;
    double radii;           /* gaps up to so many smallest radii are watched */
    double overlap;         /* mean over the carrying contacts */
    uint8_t *seen;          /* [m.count] */
    motion_sensor *sensors; /* [n_sensors] vertical forces on the top wall, and through planes */
    int32_t n_sensors;
    double input; /* energy that the source has given */
    double time;
} motion;

/* SP_EREFUSED without level walls at bottom and top. */
sp_status sp_motion_need_walls(const sp_network *net, sp_error *err);
/* radii: gaps up to so many smallest radii are watched, SP_MOTION_NEAR at least. Planes: heights [n]; with 0 planes the
 * only sensor is the top wall. Free with motion_free, after a failure too. */
sp_status sp_motion_make(const sp_packing *p, const sp_network *net, double radii, int32_t planes, const double *height,
                         motion *out, sp_error *err);
void sp_motion_free(motion *s);

/* Returns to rest and gives the grains the source times the amplitude. Returns the factor. source: [dofs] momenta or
 * displacements. */
double sp_motion_kick(motion *s, const double *source, bool momenta, double amplitude);
/* Returns to rest; the bottom wall is then moved by the steps. */
void sp_motion_rest(motion *s);
/* One step; wall: height of the bottom wall above its place at its end. */
void sp_motion_step(motion *s, double h, double wall);
/* Change of the force of a sensor, upwards. */
double sp_motion_force(const motion *s, int32_t sensor);
/* SP_EFAILED if a grain has moved too far. Then a motion with more radii may follow it, if sp_motion_can_widen. */
bool sp_motion_can_widen(const motion *s);
sp_status sp_motion_check(const motion *s, double amplitude, sp_error *err);

/* Energies now; defect: of now. */
sp_amplitude_energy sp_motion_energy(const motion *s);
void sp_motion_count(const motion *s, sp_amplitude_front *out);

#endif
