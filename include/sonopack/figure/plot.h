#ifndef SONOPACK_PLOT_H
#define SONOPACK_PLOT_H
/* Figures from plain arrays and tables: PNG, SVG or PDF by the ending of the path. */

#include <sonopack/network.h>
#include <sonopack/packing.h>
#include <sonopack/status.h>
#include <sonopack/table.h>
#include <stdbool.h>

#ifdef __cplusplus
extern "C" {
#endif

/* c_tof, c_l and c_t with their error bars against p, log-log, with the power law of c_tof (the table's exponent; from
 * three points on a fitted one if it has none) and the published c_tof = 0.26 (p/1e-4)^(1/6). `ctof` is the table of
 * sp_study_table("ctof"). */
SP_API sp_status sp_plot_ctof(const sp_table *ctof, const char *path, sp_error *err);

/* Run time against error, log-log, one symbol a method, from the table of `sonopack bench` (columns case, method,
 * seconds, error); the methods of rivals, which have a blank in their names, hollow, and the frontier of what is
 * fastest for its error as a line. only: the case; NULL: that of the first row. */
SP_API sp_status sp_plot_pareto(const sp_table *bench, const char *only, const char *path, sp_error *err);

typedef struct sp_plot_trace {
    const char *label;
    int64_t n;
    const double *t, *f;
    double t10, t_peak, t_zero;  /* marks of the first front, NAN: none */
    const char *t_unit, *f_unit; /* of a trace from elsewhere, "" unknown; t_unit NULL: those of sp_signal */
} sp_plot_trace;
/* F(t) of one or several signals. The axes name the units that all of them have. */
SP_API sp_status sp_plot_signal(int traces, const sp_plot_trace *trace, const char *path, sp_error *err);

/* Width of the lines from grain to grain: proportional to the normal force, or to k_n = 2 E12 sqrt(R12 overlap). */
typedef enum sp_plot_links { SP_PLOT_FORCES = 0, SP_PLOT_STIFFNESS } sp_plot_links;
/* A 1D or 2D packing (SP_EREFUSED in 3D): grains, rattlers grey, walls, and the contacts that carry (threshold as in
 * sp_packing_rattlers) as lines; images at the periodic edges. */
SP_API sp_status sp_plot_network(const sp_packing *p, sp_plot_links links, double threshold, const char *path,
                                 sp_error *err);

typedef struct sp_plot_table {
    const char *label; /* in the legend; NULL or "": none */
    const sp_table *table;
} sp_plot_table;
/* Tables of one kind of `sonopack spectrum': density of states (also of a table of modes), spectrum of the signal,
 * harmonic response, or participation ratios, against the frequency. SP_EINVAL for tables that are none of these. */
SP_API sp_status sp_plot_spectrum(int tables, const sp_plot_table *table, const char *path, sp_error *err);
/* Another column of tables of `sonopack spectrum harmonic': alpha, k or speed, with its error. SP_EINVAL for others. */
SP_API sp_status sp_plot_harmonic(int tables, const sp_plot_table *table, const char *column, const char *path,
                                  sp_error *err);
/* Peaks of the spectral functions of waves against the wave number, with their half widths as bars. */
SP_API sp_status sp_plot_dispersion(int tables, const sp_plot_table *table, const char *path, sp_error *err);

/* One mode of a 1D or 2D packing: u [net's dofs] displacements as arrows on the grains, the longest a diameter and a
 * half; grains that turn are tinted, one way or the other. omega and number are for the key below. */
SP_API sp_status sp_plot_mode(const sp_packing *p, const sp_network *net, const double *u, int64_t number, double omega,
                              const char *path, sp_error *err);

/* Displacements of a 1D or 2D packing at time t, u [net's dofs], as sp_signal_field gives them: arrows on the grains. A
 * few grains near the source move many times as far as the wave: arrows are cut at the largest length (and drawn in
 * another colour), the scale is that of the wave, and said below. */
SP_API sp_status sp_plot_snapshot(const sp_packing *p, const sp_network *net, const double *u, double t,
                                  const char *path, sp_error *err);

/* Polar histogram from the table of sp_contact_angles_table, and histograms of normal forces and stiffnesses from that
 * of sp_contact_values_table. */
SP_API sp_status sp_plot_angles(const sp_table *angles, const char *path, sp_error *err);
SP_API sp_status sp_plot_contact_values(const sp_table *values, const char *path, sp_error *err);

/* Arrival, peak and zero times against distance with fitted lines, from tables of `sonopack table scaling', `table
 * planes' or `chain front'; sample: a signal whose inset shows what the three marks are, or NULL. */
SP_API sp_status sp_plot_fronts(int tables, const sp_plot_table *table, const sp_plot_trace *sample, const char *path,
                                sp_error *err);
/* From the same tables: local exponents gamma and alpha against distance, with amplitude and width in insets. */
SP_API sp_status sp_plot_scaling(int tables, const sp_plot_table *table, const char *path, sp_error *err);

/* Mean and root mean square deviation of the signals of an ensemble, and as a band the interval low to high of the mean
 * where the table has one, from tables with columns t, mean and rms. Several tables are called by
 * what their comments say differently (friction, ...), or else by their labels; sp_plot_spectrum calls them so, too. */
SP_API sp_status sp_plot_ensemble(int tables, const sp_plot_table *table, const char *path, sp_error *err);

/* A table of `sonopack modes': omega^2 against the number of the mode, and a b. */
SP_API sp_status sp_plot_modes(const sp_table *modes, const char *path, sp_error *err);

/* Signals at several distances, one above the other: each drawn at its distance, in the scale of its own largest value.
 * Without any distances (all NAN) they stand at 1, 2, ... in their order. */
typedef struct sp_plot_record {
    double distance; /* of the detector from the source [d] */
    int64_t n;
    const double *t, *f;
} sp_plot_record;
SP_API sp_status sp_plot_section(int records, const sp_plot_record *record, const char *path, sp_error *err);

/* Phase speed and attenuation against the wave number, of one or several tables of `sonopack wave', with Rayleigh's
 * law alpha ~ k^(dimension + 1) through the long waves. Points where a logarithmic axis has no place for alpha are left
 * out. */
SP_API sp_status sp_plot_wave(int tables, const sp_plot_table *table, const char *path, sp_error *err);

typedef struct sp_plot_column_options {
    bool surface;       /* of a trajectory or densities: y over particle and time, as of several tables */
    const char *column; /* of a bifurcation: y1, y2, ...; NULL: y1 */
} sp_plot_column_options;
/* Tables of `sonopack column', by their columns: trajectories with the floor and the starts of the taps; several of
 * them, or densities, as surfaces of one scale and view; density and positions after each tap; Lyapunov exponents;
 * bifurcations, as dots, with a table of Lyapunov exponents below; differences of the models; density along the column;
 * energies. options may be NULL. SP_EINVAL for others, and for several that make no figure together. */
SP_API sp_status sp_plot_column(int tables, const sp_plot_table *table, const sp_plot_column_options *options,
                                const char *path, sp_error *err);

#ifdef __cplusplus
}
#endif
#endif
