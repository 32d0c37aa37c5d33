#ifndef SONOPACK_AMPLITUDE_H
#define SONOPACK_AMPLITUDE_H
/* What becomes of the sound of a packing when it is loud: the nonlinear motion between fixed walls, with Hertz's law,
 * sliding, and contacts that open and close, beside the linear signal (docs/amplitude.md).
 *
 * Amplitudes are those of sp_signal_options: the largest initial displacement of a grain, or velocity over omega_max,
 * over the mean overlap of the carrying contacts. */

#include <sonopack/front.h>
#include <sonopack/network.h>

#ifdef __cplusplus
extern "C" {
#endif

/* A result with its error, an estimate from steps of twice the length and from every second time. */
typedef struct sp_amplitude_number {
    double value, error; /* the number; an estimate of its error */
} sp_amplitude_number;

typedef struct sp_amplitude_options {
    sp_source source;
    double until;     /* last time; 0: sp_signal_window */
    double tolerance; /* largest relative error of the arrival and of the balance of energy; 1e-3 */
} sp_amplitude_options;
SP_API sp_amplitude_options sp_amplitude_options_default(void);

/* The balance of energy at the end of the run [E* d^3]. Energies are beyond those at rest and beyond the work of the
 * forces at rest, which is none in a packing in equilibrium:
 *     kinetic + normal + tangential + slid - released = input. */
typedef struct sp_amplitude_energy {
    double input;   /* of the source */
    double kinetic; /* of translations and rotations */
    double normal;  /* of the normal springs (Hertz) */
    double
        tangential;  /* work of the tangential springs without sliding; Mindlin's springs have no energy of their own */
    double slid;     /* what sliding rubbed away */
    double released; /* what of it the forces at rest have done: sliding lets go of stresses of the packing */
    double defect;   /* largest | left side - right side | / input on the way: the error of the time steps */
} sp_amplitude_energy;

/* The front at the top wall after a pulse of one amplitude at the bottom wall. */
typedef struct sp_amplitude_front {
    double amplitude;          /* that was asked for */
    double factor;             /* of the source: F is the change of the force on the top wall over it */
    double step;               /* time step of the finer run [d/sqrt(E* / rho)] */
    sp_front front;            /* of F */
    sp_amplitude_number t10;   /* arrival, as in sp_front [d/sqrt(E* / rho)] */
    sp_amplitude_number speed; /* t10 of the linear signal over t10: H/t10 over its linear limit */
    sp_amplitude_number peak;  /* largest F of the front over that of the linear signal */
    sp_amplitude_number width; /* t_zero - t10 over that of the linear signal */
    double overpressure;       /* largest change of the force on the top wall over the force at rest */
    double until; /* end of the run, behind the front: the time of the counts and of the energies [d/sqrt(E* / rho)] */
    int32_t carrying;           /* contacts that carry a force at rest; of these */
    int32_t slid, opened, lost; /* slid; were open at some time; are open at the end */
    int32_t closed;             /* gaps that closed at some time */
    sp_amplitude_energy energy; /* at the end of the run */
} sp_amplitude_front;

/* Computes the fronts of `count` amplitudes, and that of the linear signal (all contacts, with prestress, by
 * Chebyshev expansion), which is their limit.
 * SP_EINVAL for an amplitude that is not in 1e-9 .. 1e6: below, rounding errors of the motion exceed the tolerance.
 * SP_EREFUSED for a packing without level walls at bottom and top, without a front, or where the tolerance takes too
 * many steps; SP_EFAILED if a grain moves farther than the search for contacts allows. */
SP_API sp_status sp_amplitude_pulses(const sp_packing *p, const sp_amplitude_options *opt, int32_t count,
                                     const double *amplitude, sp_amplitude_front *out, sp_front *linear, sp_error *err);

/* The front at a plane: the flux of momentum through it, as in SP_PLACE_PLANE. */
typedef struct sp_amplitude_plane {
    double height;                    /* of the contacts that carry the flux (sp_network_plane_height) [d] */
    sp_amplitude_number t10;          /* arrival at the plane, as in sp_front [d/sqrt(E* / rho)] */
    sp_amplitude_number t_peak;       /* time of the largest flux [d/sqrt(E* / rho)] */
    sp_amplitude_number overpressure; /* largest change of the flux of momentum, over the force at rest */
    sp_amplitude_number speed,
        speed_peak; /* from the plane before, by t10; the same by t_peak. NAN at the first plane [sqrt(E* / rho)] */
} sp_amplitude_plane;
/* The fronts of one pulse at planes of these heights, ascending, inside the packing. plane: [n]; pulse: that at the top
 * wall, may be NULL. As sp_amplitude_pulses; SP_EINVAL for a height that no contact crosses, and for two planes that
 * the same contacts cross. */
SP_API sp_status sp_amplitude_planes(const sp_packing *p, const sp_amplitude_options *opt, double amplitude, int32_t n,
                                     const double *height, sp_amplitude_plane *plane, sp_amplitude_front *pulse,
                                     sp_error *err);

/* A burst sin(omega t) (1 - cos(omega t/cycles))/2, 0 < t < 2 pi cycles/omega, of the height of the bottom wall. */
typedef struct sp_amplitude_burst {
    double amplitude; /* height of the wall over the mean overlap of the carrying contacts */
    double omega;     /* [sqrt(E* / rho)/d] */
    int32_t cycles;   /* >= 3 */
} sp_amplitude_burst;

/* Harmonics of the flux of momentum through a plane, over the force at rest: the amplitudes below the envelopes w, w^2
 * and w^3 that a wave of the envelope w = (1 - cos)/2 gives to them. The flux is that of two bursts of opposite sign:
 * half their sum has what is even in the amplitude (mean, second), half their difference what is odd. */
typedef struct sp_amplitude_harmonics {
    double height; /* of the contacts that carry the flux [d] */
    double until;  /* end of the record, before the front comes back from the top wall [d/sqrt(E* / rho)] */
    sp_amplitude_number first, second, third,
        mean;                  /* flux at omega; at 2 omega; at 3 omega; at rest: all over the force at rest */
    sp_amplitude_number phase; /* of the first, falls with height, continuous from plane to plane */
    sp_amplitude_number ratio; /* second/first^2 */
} sp_amplitude_harmonics;

/* What the planes tell together. */
typedef struct sp_amplitude_second {
    sp_amplitude_number k;     /* wave number of the first harmonic [1/d] */
    sp_amplitude_number speed; /* omega/k [sqrt(E* / rho)] */
    sp_amplitude_number slope; /* of second/first^2 against height [1/d] */
    /* Coefficient of u_tt = c^2 u_xx (1 - beta u_x), 4 density speed^3 slope/(omega p). A chain has beta delta0/d =
     * 1/2.
     */
    sp_amplitude_number beta;
    sp_amplitude_energy energy; /* of the burst upwards at its end; input: work of the wall. defect: over the largest */
    double step;                /* time step of the finer run [d/sqrt(E* / rho)] */
} sp_amplitude_second;

/* Sends a burst through the packing. plane: [n], at heights as in sp_amplitude_planes, or with NULL at equal distances
 * up to the highest plane that can be; second may be NULL, and needs 3 planes. Errors have a third part: what a record
 * shorter by a tenth would give. SP_EREFUSED where the burst, or a plane, is so long, or so high, that the front comes
 * back before the burst has passed. */
SP_API sp_status sp_amplitude_bursts(const sp_packing *p, const sp_amplitude_options *opt,
                                     const sp_amplitude_burst *burst, int32_t n, const double *height,
                                     sp_amplitude_harmonics *plane, sp_amplitude_second *second, sp_error *err);

/* A solitary wave of a chain of equal balls (Hertz's law, no walls). Balls are counted along the chain, so lengths
 * along it are numbers of balls; c is the speed of long waves of the chain at rest, delta0 its overlap. */
typedef struct sp_solitary {
    double peak;       /* largest additional overlap over delta0; INFINITY: the chain at rest bears no force */
    double force;      /* largest force over that at rest, (1 + peak)^(3/2) */
    double speed;      /* over c */
    double velocity;   /* largest velocity of a ball over c delta0 */
    double width;      /* where the additional overlap is above half of its peak [balls] */
    double kdv;        /* speed of the long and weak wave over c, sqrt(1 + peak/6); */
    double kdv_width;  /* its width, of sech^2(x sqrt(peak/2)) */
    double nesterenko; /* speed of the long wave of any strength over c (Nesterenko 2001, ch. 1) */
    double speed_at_peak, velocity_at_peak,
        nesterenko_at_peak; /* speed; velocity; nesterenko over what belongs to a chain that rests with the overlap of
                               the peak. They stay finite without force at rest, where the others are INFINITY */
    double error;           /* of speed, velocity and width, relative: an estimate from half the points */
} sp_solitary;
/* Solves the equation of a wave of constant form, V^2 R = tent * (F(R) - F(0)), to rounding errors. SP_EINVAL for a
 * peak that is not in 1e-4 .. 1e9 or INFINITY. */
SP_API sp_status sp_solitary_make(double peak, sp_solitary *out, sp_error *err);
/* Its form: additional overlap over the peak, and velocity of the ball over its largest, at the distances x [n] from
 * the middle of the wave [balls]; the overlap is that of two balls whose middle is at x, the ball is at x. */
SP_API sp_status sp_solitary_form(double peak, int64_t n, const double *x, double *overlap, double *velocity,
                                  sp_error *err);

#ifdef __cplusplus
}
#endif
#endif
