#ifndef SONOPACK_PLOT_H
#define SONOPACK_PLOT_H
/* Figures of tables, signals and packings. The ending of the path selects PNG, SVG or PDF. All functions return
 * SP_EINVAL for data of the wrong kind, SP_EREFUSED for values that a figure cannot show, and SP_EIO if the file cannot
 * be written. */

#include <sonopack/network.h>
#include <sonopack/packing.h>
#include <sonopack/status.h>
#include <sonopack/table.h>
#include <stdbool.h>

#ifdef __cplusplus
extern "C" {
#endif

typedef struct sp_plot_table {
    const char *label; /* legend entry; NULL or "": none */
    const sp_table *table;
    bool named; /* the label is the reader's: it goes before the settings in which tables differ */
} sp_plot_table;

/* Speeds c_tof, c_l and c_t with error bars against pressure, log-log. The power law of c_tof has the exponent in the
 * metadata of the table, otherwise that of a fit through three or more points. The published c_tof = 0.26
 * (p/1e-4)^(1/6) is drawn where all tables say dimension = 2 and have our units, unless the look says otherwise. ctof:
 * the table of sp_study_table("ctof"). Several tables have one colour each and must have the same units (SP_EINVAL). */
SP_API sp_status sp_plot_ctof(const sp_table *ctof, const char *path, sp_error *err);
SP_API sp_status sp_plot_ctof_tables(int tables, const sp_plot_table *table, const char *path, sp_error *err);

/* Run time against error, log-log, one symbol for each method. A line joins the methods that are fastest at their
 * error. bench: the table of `sonopack bench' (columns case, method, seconds, error). Methods of other programs, which
 * have a blank in their names, have open symbols. only: the case to show; NULL: that of the first row. */
SP_API sp_status sp_plot_pareto(const sp_table *bench, const char *only, const char *path, sp_error *err);

typedef struct sp_plot_trace {
    const char *label;
    int64_t n;
    const double *t, *f;
    double t10, t_peak, t_zero;  /* times of the first front to mark; NAN: none */
    const char *t_unit, *f_unit; /* units of data from elsewhere, "" if unknown; t_unit NULL: the units of sp_signal */
    const char *place;           /* of the detector, after the label: markup as in figure.h; NULL: none */
} sp_plot_trace;
/* Signals F(t). The axes name the units common to all of them; SP_EINVAL if two signals have different known units. */
SP_API sp_status sp_plot_signal(int traces, const sp_plot_trace *trace, const char *path, sp_error *err);

/* Quantity shown by the widths of contact lines: the normal force, or the normal stiffness k_n = 2 E12 sqrt(R12
 * overlap). */
typedef enum sp_plot_links { SP_PLOT_FORCES = 0, SP_PLOT_STIFFNESS } sp_plot_links;
/* A packing: grains, rattlers in grey, walls, and a line for each contact that carries load. Grains at periodic edges
 * have images. In 3 dimensions three views show grains at half their size. threshold: as in sp_packing_rattlers. */
SP_API sp_status sp_plot_network(const sp_packing *p, sp_plot_links links, double threshold, const char *path,
                                 sp_error *err);

/* A packing whose grains are coloured by a table with the column grain and one of: factor (of `sonopack design --rows
 * grains', around 1), probability (of `coda', from 0), by_mass or by_radius (of `sensitivity', around 0). Orange is
 * above, blue below; rattlers are grey. SP_EREFUSED if all grains are alike. */
SP_API sp_status sp_plot_grains(const sp_packing *p, const sp_table *t, double threshold, const char *path,
                                sp_error *err);

/* A packing with its contacts as lines, whose width and colour show what each does to a quantity when it becomes
 * stiffer: the sum of by_kn and by_kt in a table of `sonopack sensitivity', which has the columns contact and one or
 * both of these. Orange: the quantity grows, blue: it shrinks. Widths are those of the sizes, up to the largest one.
 * SP_EREFUSED if all are 0. */
SP_API sp_status sp_plot_sensitivity(const sp_packing *p, const sp_table *t, double threshold, const char *path,
                                     sp_error *err);

/* Tables of `sonopack spectrum' against frequency, all of one kind: density of states (also from a table of modes),
 * spectrum of the signal, harmonic response, or participation ratios. */
SP_API sp_status sp_plot_spectrum(int tables, const sp_plot_table *table, const char *path, sp_error *err);
/* Another column of the tables of `sonopack spectrum harmonic', with its error: "alpha", "k" or "speed". */
SP_API sp_status sp_plot_harmonic(int tables, const sp_plot_table *table, const char *column, const char *path,
                                  sp_error *err);
/* Peak frequencies of the spectral functions against the wave number, with their half widths as bars. */
SP_API sp_status sp_plot_dispersion(int tables, const sp_plot_table *table, const char *path, sp_error *err);

/* One mode of a packing, in 3 dimensions in three views. u: displacements [degrees of freedom of net]. Arrows on the
 * grains show translations; the longest is 1.5 diameters. Tints show rotations. number and omega appear in the key. */
SP_API sp_status sp_plot_mode(const sp_packing *p, const sp_network *net, const double *u, int64_t number, double omega,
                              const char *path, sp_error *err);

/* Displacements of a packing at time t as arrows, in 3 dimensions in three views. u: as from sp_signal_field [degrees
 * of freedom of net]. Grains near the source may move much farther than the wave. Their arrows are cut and have another
 * colour. The key gives the scale. */
SP_API sp_status sp_plot_snapshot(const sp_packing *p, const sp_network *net, const double *u, double t,
                                  const char *path, sp_error *err);

/* Frames of a movie: the same figures in a file each, with one scale for all. Frames that are written stay if a later
 * one fails. */
typedef struct sp_plot_frame {
    double t;
    const double *u; /* displacements [degrees of freedom of net] */
    const char *path;
} sp_plot_frame;
SP_API sp_status sp_plot_snapshot_frames(const sp_packing *p, const sp_network *net, int frames,
                                         const sp_plot_frame *frame, sp_error *err);
/* A period of a mode in equal steps, cos(2 pi k/frames) u in frame k, with grains that move. path: [frames]. */
SP_API sp_status sp_plot_mode_frames(const sp_packing *p, const sp_network *net, const double *u, int64_t number,
                                     double omega, int frames, const char *const *path, sp_error *err);

/* Polar histogram of contact directions from the table of sp_contact_angles_table; histograms of normal forces and
 * stiffnesses from the table of sp_contact_values_table. */
SP_API sp_status sp_plot_angles(const sp_table *angles, const char *path, sp_error *err);
SP_API sp_status sp_plot_contact_values(const sp_table *values, const char *path, sp_error *err);

/* Arrival, peak and zero-crossing times against distance with fitted lines, from tables of `sonopack table scaling',
 * `table planes' or `chain front'. sample: a signal for an inset that explains the three times; NULL: no inset. */
SP_API sp_status sp_plot_fronts(int tables, const sp_plot_table *table, const sp_plot_trace *sample, const char *path,
                                sp_error *err);
/* Local exponents gamma and alpha against distance from the same tables, with amplitude and width in insets. */
SP_API sp_status sp_plot_scaling(int tables, const sp_plot_table *table, const char *path, sp_error *err);

/* Mean and root mean square deviation of the signals of an ensemble, from tables with columns t, mean and rms. Columns
 * low and high, if present, give a band around the mean. The legend identifies several tables by the settings that
 * differ, otherwise by their labels. */
SP_API sp_status sp_plot_ensemble(int tables, const sp_plot_table *table, const char *path, sp_error *err);

/* Squared frequency and weight a b of each mode, from tables of `sonopack modes'. A line would hide what happens
 * between the rows of a short table: it has marks and bars. */
SP_API sp_status sp_plot_modes(const sp_table *modes, const char *path, sp_error *err);
SP_API sp_status sp_plot_modes_tables(int tables, const sp_plot_table *table, const char *path, sp_error *err);

/* Record section: each signal is drawn at its distance, scaled by its largest value; the legend gives the range of
 * these values. If all distances are NAN, the signals are at 1, 2, ... The units are those of the first record. */
typedef struct sp_plot_record {
    double distance; /* distance of the detector from the source [d] */
    int64_t n;
    const double *t, *f;
    const char *t_unit, *f_unit, *distance_unit; /* units of data from elsewhere; NULL: ours; "": unknown */
} sp_plot_record;
SP_API sp_status sp_plot_section(int records, const sp_plot_record *record, const char *path, sp_error *err);

/* Phase speed and attenuation against the wave number from tables of `sonopack wave', with Rayleigh's law alpha ~
 * k^(dimension + 1) fitted to the long waves. Values that a logarithmic axis cannot show are left out. */
SP_API sp_status sp_plot_wave(int tables, const sp_plot_table *table, const char *path, sp_error *err);
/* Diffusivity and mean free path against frequency, with their errors, from tables of `sonopack transport': a panel for
 * each of the columns D and path that any table has. 1 to 6 tables. */
SP_API sp_status sp_plot_transport(int tables, const sp_plot_table *table, const char *path, sp_error *err);

/* Tables of `sonopack amplitude'. Of fronts: their speed over its linear limit, and the shares of contacts that opened
 * and slid, against the amplitude, with a curve for each pressure, friction and dimension. Of bursts at planes: F2/F1^2
 * against the height. SP_EREFUSED for more than 18 curves. */
SP_API sp_status sp_plot_amplitude(int tables, const sp_plot_table *table, const char *path, sp_error *err);

typedef struct sp_plot_column_options {
    bool surface;       /* draw a trajectory or densities as a surface over particle and time, as for several tables */
    const char *column; /* column of a bifurcation table: "y1", "y2", ...; NULL: y1 */
} sp_plot_column_options;
/* Tables of `sonopack column'. Their columns determine the figure: trajectories with the floor and the starts of the
 * taps; several trajectories, or densities, as surfaces with the same scale and view; density and positions after each
 * tap; Lyapunov exponents; bifurcations as dots, with an optional table of Lyapunov exponents below; differences
 * between the models; density along the column; energies. options may be NULL. SP_EINVAL for tables that make no figure
 * together. */
SP_API sp_status sp_plot_column(int tables, const sp_plot_table *table, const sp_plot_column_options *options,
                                const char *path, sp_error *err);

#ifdef __cplusplus
}
#endif
#endif
