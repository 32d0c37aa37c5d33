#ifndef SONOPACK_STUDY_H
#define SONOPACK_STUDY_H
/* Studies: the samples of a scene's sweeps, their results, and tables of these results. */

#include <sonopack/elastic.h>
#include <sonopack/front.h>
#include <sonopack/packing.h>
#include <sonopack/signal.h>
#include <sonopack/study/scene.h>
#include <sonopack/table.h>
#include <stdbool.h>

#ifdef __cplusplus
extern "C" {
#endif

/* ---- samples ---------------------------------------------------------------------------------------------------- */

enum { SP_NAME_MAX = 33 };

/* The probes of Tables IV and V of Somfai et al. 2005, in this order. */
typedef enum sp_probe_row { SP_SINE_1 = 0, SP_SINE_2, SP_LINES_1, SP_LINES_3, SP_PROBES } sp_probe_row;

/* How a stored signal was computed. */
typedef struct sp_signal_made {
    int32_t points;
    sp_signal_method method;
    double until;     /* last time [d / sqrt(E* / rho)] */
    double tolerance; /* that was asked for; NAN: unknown */
} sp_signal_made;

/* The network whose frequencies are stored. Rattlers do not belong to it. */
typedef struct sp_spectrum_made {
    int32_t carrying;   /* grains */
    int32_t dof;        /* degrees of freedom of a grain; there are carrying x dof frequencies */
    int32_t zero_modes; /* frequencies that are 0 */
    double omega_max;   /* largest frequency [sqrt(E* / rho)/d] */
} sp_spectrum_made;

/* Results of one sample. The bits SP_WANT_ in `have` tell which parts are filled in. */
typedef struct sp_sample {
    char name[SP_NAME_MAX]; /* hash of what determines the sample: 32 hexadecimal digits (sp_sample_name) */
    int32_t kind;           /* sp_pack_kind; packings of different kinds are never averaged */
    int32_t dim, grains;
    double width, pressure, friction; /* pressure: that of the scene's stage; with a fraction that of the packing */
    double fraction;                  /* packing.fraction; 0: the pressure is given */
    int32_t stage;                    /* packings of history and path up to this one; 0: neither a path nor stages */
    double strain;                    /* where the path is, in multiples of packing.path.strain */
    double mean_stress;               /* with a fraction or a stage: mean normal stress of the packing; 0: none [E*] */
    uint64_t seed;
    uint64_t material; /* hash of the other keys that determine the sample (sp_sample_material); 0: unknown */
    double height;     /* distance from source to detector [d] */
    bool failed;
    char reason[256]; /* why it failed, else "" */
    unsigned have;
    unsigned lacks;        /* parts that could not be made; reason is that of the first */
    uint64_t lacks_signal; /* hash of the signal keys with which SP_WANT_SIGNAL and SP_WANT_PLANES failed */
    sp_front front;
    sp_statics statics;
    sp_moduli moduli;
    sp_probe_moduli probe[SP_PROBES];
    int32_t planes;                      /* those planes of the scene that lie inside the packing */
    double plane[SP_PLANES_MAX];         /* their heights above the bottom wall [d] */
    sp_front plane_front[SP_PLANES_MAX]; /* fronts of the momentum flux through them; NAN where there is no front */
    sp_signal_made signal;
    sp_spectrum_made spectrum;
} sp_sample;

/* Results that are too large for an sp_sample. */
typedef struct sp_sample_arrays {
    sp_signal signal; /* n = 0: none */
    int64_t modes;    /* 0: none */
    double *omega;    /* [modes] frequencies of the network, ascending [sqrt(E* / rho)/d]; zero modes are 0 */
} sp_sample_arrays;
SP_API sp_sample_arrays sp_sample_arrays_none(void);
SP_API void sp_sample_arrays_free(sp_sample_arrays *a);

/* Name of a scene's sample: 128-bit hash of the packing and network keys, the source, and the version of the
 * algorithms. */
SP_API void sp_sample_name(const sp_scene *scene, char name[SP_NAME_MAX]);

/* Hash of the packing and network keys and the source, but not of pressure, fraction, stages, grains, width, friction,
 * seed, packing.content and max_steps. Samples with different hashes are not averaged. 0: no memory. */
SP_API uint64_t sp_sample_material(const sp_scene *scene);

/* The parts of the results that study.want stands for: `scaling' is made of the fronts of `ctof'. */
SP_API unsigned sp_want_parts(unsigned want);
/* The parts of a sample that were made as the scene says: a signal counts only with the same last time, points, method
 * and tolerance, and planes only if there are fronts at all planes of the scene that lie inside the packing. */
SP_API unsigned sp_sample_parts(const sp_scene *scene, const sp_sample *sample);

/* What is known of a sample before any work: something has to be made; everything that the scene wants is there; or the
 * packing, or a part that is wanted, is recorded as failed. */
typedef enum sp_stored { SP_STORED_NOT = 0, SP_STORED_ALL, SP_STORED_FAILED } sp_stored;
/* The same of a sample with stored results, whose parts are those of sp_sample_parts. */
SP_API sp_stored sp_sample_stored(const sp_scene *scene, const sp_sample *sample);

/* The front of a network's signal over the times 0 .. window, on times that are dense enough for it: the front of
 * SP_WANT_CTOF and of `sonopack front'. window <= 0 stands for sp_signal_window. Errors as sp_signal_make and
 * sp_front_find. */
SP_API sp_status sp_network_front(const sp_network *net, sp_source source, double window, sp_front *out, sp_error *err);

/* Makes one sample: the packing unless it is given (n > 0), and every part in `want` that *sample lacks or that was
 * made otherwise than the scene says. Planes that are less than a diameter from a wall are left out. If a part fails
 * the others are made nevertheless; the first reason is returned, and stored in sample->reason. *arrays receives signal
 * and frequencies if they are wanted and missing; with arrays = NULL neither is made. */
SP_API sp_status sp_sample_make(const sp_scene *scene, unsigned want, sp_packing *packing, sp_sample *sample,
                                sp_sample_arrays *arrays, sp_error *err);

/* ---- studies ---------------------------------------------------------------------------------------------------- */

/* Where results come from and go to. A store is one (sp_store_sink). Calls come one at a time. */
typedef struct sp_study_sink {
    void *user;
    /* What is there of the sample of this scene and name. NULL: nothing ever is. */
    sp_stored (*has)(void *user, const sp_scene *scene, const char *name);
    /* Reserves the sample for this process until it is released, so that no other process makes it. *taken = false if
     * another process has reserved it. An error (nothing can be saved) ends the study. NULL: no other process exists.
     */
    sp_status (*claim)(void *user, const char *name, bool *taken, sp_error *err);
    void (*release)(void *user, const char *name);
    /* Loads the packing and the results of that name if they are there; then only what is missing is computed. */
    sp_status (*load)(void *user, const char *name, sp_packing *packing, sp_sample *sample, bool *found, sp_error *err);
    /* Saves a finished sample. packing is NULL for a failed one. arrays may be NULL, and has only what was computed
     * now; a stored signal and stored frequencies of the sample that it does not have are kept. */
    sp_status (*save)(void *user, const sp_scene *scene, const sp_sample *sample, const sp_packing *packing,
                      const sp_sample_arrays *arrays, sp_error *err);
} sp_study_sink;

/* How far a study has come. */
typedef struct sp_study_progress {
    int64_t total, done, computed, failed; /* samples of the study; finished ones, with those that were stored before;
                                              those computed now; those that failed */
    int64_t elsewhere;                     /* samples that other processes have reserved; waited for at the end */
    double seconds, seconds_left;          /* wall clock so far; that is left, NAN at first */
    double cost, cost_done, cost_computed; /* expected work of these samples, in an arbitrary unit; of the finished
                                              ones; of those computed now */
} sp_study_progress;
/* Called about 4 times a second, and at the end, by the thread that called sp_study_run. Returning false stops the
 * study: unfinished packings are dropped, finished samples are kept. */
typedef bool (*sp_study_watch)(const sp_study_progress *progress, void *user);

typedef struct sp_study_options {
    int jobs;               /* samples at a time, each by one thread; >= 1 */
    int shard, shards;      /* this process makes the samples shard-1 (mod shards); 1, 1: all */
    int threads;            /* of each packing, with jobs = 1; 0: one */
    const sp_packing *from; /* the packing of packing.file; NULL: none */
    /* For several processes that share one study: the numbers 0, 1, 2, ... of its samples, each given to one process
     * only; negative when none is left. Called by the threads of this process, one at a time, while the watch may be
     * running. The study ends when the numbers do, however many of them this process received. NULL: this process makes
     * all samples of its shard. */
    int64_t (*take)(void *user);
    void *take_user;
} sp_study_options;

SP_API int64_t sp_study_count(const sp_scene *scene);
/* The scene of sample k, 0 <= k < count, with its swept values and its seed. Every combination gets its first seed
 * before any gets its second. The scene shares the lists of the study. */
SP_API sp_status sp_study_scene(const sp_scene *study, int64_t k, sp_scene *out, sp_error *err);

/* Computes the samples of a study that are not stored yet.
 *
 * A sample whose packing fails is saved as failed, and the study goes on. If only a part of the results fails (no
 * front, a floppy network), the packing and the other parts are saved with the reason, and the sample counts as failed
 * too. Failures are not tried again while the sink remembers them. Samples that another process has reserved are left
 * for the end, and waited for.
 *
 * SP_EINVAL before any work if a combination is no valid scene; SP_EINTERRUPTED if the watch returned false; SP_EIO if
 * the sink failed. *out, unless NULL, is filled in after any status but SP_EINVAL. */
SP_API sp_status sp_study_run(const sp_scene *scene, const sp_study_options *opt, const sp_study_sink *sink,
                              sp_study_watch watch, void *user, sp_study_progress *out, sp_error *err);

/* ---- tables ----------------------------------------------------------------------------------------------------- */

typedef struct sp_table_options {
    double level; /* confidence level of the intervals: 0.95; 0.5 to 0.999 */
} sp_table_options;
SP_API sp_table_options sp_table_options_default(void);
/* Makes a table from samples in any order. opt may be NULL. The tables:
 *
 *   ctof      a row for each pressure: speeds of the front between the lowest and the highest boxes, c_l and c_t
 *   scaling   a row for each height, pressure, friction and width: fronts over distance (sonopack/scaling.h)
 *   planes    the same with a row for each plane, and for each number of grains
 *   statics, moduli, probes   a row for each pressure and size: mean X, then X_sd, X_err, X_low, X_high
 *   ensemble  a row for each sample
 *
 * _sd is the standard deviation of the samples. _err is a standard error: sd / sqrt(n) of a mean, and by bootstrap over
 * samples of a speed. _low .. _high is a confidence interval by studentised bootstrap over samples (docs/physics.md,
 * "Errors and intervals"); NAN with fewer than 2 samples. SP_EREFUSED for samples that may not be averaged, SP_EINVAL
 * for an unknown table or a level out of range. */
SP_API sp_status sp_study_table(const char *table, int64_t n, const sp_sample *samples, const sp_table_options *opt,
                                sp_table *out, sp_error *err);

/* ---- averages of signals ---------------------------------------------------------------------------------------- */

/* Mean and scatter of many signals at each time. Signals are added one by one, and not kept. Start from
 * sp_signal_average_none(). */
typedef struct sp_signal_average {
    int32_t points;
    int64_t count;   /* signals */
    double *t;       /* [points] times of the first signal */
    double *mean;    /* [points] over the signals */
    double *squares; /* [points] sum of the squared deviations from the mean */
} sp_signal_average;
SP_API sp_signal_average sp_signal_average_none(void);
SP_API void sp_signal_average_free(sp_signal_average *s);
/* Adds a signal: values f[points] at the times t[points], points >= 1. By Welford's update (Technometrics 4, 419,
 * 1962), which has no difference of large sums. NAN in f gives NAN in the results. SP_EREFUSED if the times differ from
 * those of the first signal by more than 1e-12 of the last time; then nothing is added. */
SP_API sp_status sp_signal_average_add(sp_signal_average *s, int32_t points, const double *t, const double *f,
                                       sp_error *err);
/* Scatter at time k: root mean square deviation from the mean, with the count in the denominator as in Fig. 4 of Somfai
 * et al. 2005. NAN for a single signal. */
SP_API double sp_signal_average_rms(const sp_signal_average *s, int32_t k);
/* Standard error of the mean at time k, with count - 1 in the denominator. NAN for a single signal. */
SP_API double sp_signal_average_mean_err(const sp_signal_average *s, int32_t k);

/* Fits y ~ x^a to n >= 3 points: the exponent a, its standard error, and the prefactor. y_err[n] are relative weights;
 * NULL: equal weights. SP_EINVAL for values that are not positive. */
SP_API sp_status sp_fit_power(int64_t n, const double *x, const double *y, const double *y_err, double *exponent,
                              double *exponent_err, double *prefactor, sp_error *err);

#ifdef __cplusplus
}
#endif
#endif
