#ifndef SONOPACK_STUDY_H
#define SONOPACK_STUDY_H
/* An ensemble: samples of a scene's sweep, what each needs, and the tables made of their results. */

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

enum { SP_NAME_MAX = 33 };

/* The probes of Tables IV and V, in this order. */
typedef enum sp_probe_row { SP_SINE_1 = 0, SP_SINE_2, SP_LINES_1, SP_LINES_3, SP_PROBES } sp_probe_row;

/* What a stored signal was made with. */
typedef struct sp_signal_made {
    int32_t points;
    sp_signal_method method;
    double until;     /* last time [d / sqrt(E* / rho)] */
    double tolerance; /* asked for; NAN: unknown */
} sp_signal_made;

/* The network whose frequencies are kept: rattlers are left out. */
typedef struct sp_spectrum_made {
    int32_t carrying;   /* its grains */
    int32_t dof;        /* degrees of freedom of a grain: it has carrying x dof frequencies */
    int32_t zero_modes; /* of these at omega = 0 */
    double omega_max;   /* the largest [sqrt(E* / rho)/d] */
} sp_spectrum_made;

/* Results of one sample. `have` says which of the SP_WANT_ parts are filled. */
typedef struct sp_sample {
    char name[SP_NAME_MAX]; /* hash of what made it: 32 hexadecimal digits (sp_sample_name) */
    int32_t kind;           /* sp_pack_kind: packings of unlike kinds are never averaged */
    int32_t dim, grains;
    double width, pressure, friction;
    uint64_t seed;
    uint64_t material; /* hash of all other keys that make it (sp_sample_material); 0: not known */
    double height;     /* source-detector distance [d] */
    bool failed;
    char reason[256]; /* why it failed, else "" */
    unsigned have;
    unsigned lacks;        /* parts that were tried and could not be made; reason: of the first */
    uint64_t lacks_signal; /* hash of the scene's signal keys with which SP_WANT_SIGNAL and SP_WANT_PLANES were tried */
    sp_front front;
    sp_statics statics;
    sp_moduli moduli;
    sp_probe_moduli probe[SP_PROBES];
    int32_t planes;                      /* of the scene's planes those that lie inside the packing */
    double plane[SP_PLANES_MAX];         /* their heights above the bottom wall [d] */
    sp_front plane_front[SP_PLANES_MAX]; /* fronts of the momentum flux through them; NAN where there is none */
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

/* Name of a scene's sample: 128-bit hash of its packing and network keys, the source, and the library's algorithm
 * version. */
SP_API void sp_sample_name(const sp_scene *scene, char name[SP_NAME_MAX]);

/* Hash of a scene's packing and network keys and source, pressure, grains, width, friction, seed, packing.content and
 * max_steps left out: samples that differ in it are not averaged. 0: no memory. */
SP_API uint64_t sp_sample_material(const sp_scene *scene);

/* The results that SP_WANT_ words of a scene stand for: `scaling' is made of the fronts of `ctof'. */
SP_API unsigned sp_want_parts(unsigned want);
/* Of the parts that a sample has those that were made as the scene says: a signal with its last time, points, method
 * and tolerance, and fronts at all of its planes that lie inside. The others are to be made anew. */
SP_API unsigned sp_sample_parts(const sp_scene *scene, const sp_sample *sample);

/* What there is of a sample before any work: something is to be made; all that its scene wants is there; or it is
 * recorded that the packing, or a part that is wanted, could not be made. */
typedef enum sp_stored { SP_STORED_NOT = 0, SP_STORED_ALL, SP_STORED_FAILED } sp_stored;
/* Of a sample with its results as they are kept: its parts count as sp_sample_parts says. */
SP_API sp_stored sp_sample_stored(const sp_scene *scene, const sp_sample *sample);

/* Where results come from and go to; the store implements it, a test may keep them in memory. Calls are serialised. */
typedef struct sp_study_sink {
    void *user;
    /* what is there of the sample of that name, which the scene makes; NULL: nothing ever is */
    sp_stored (*has)(void *user, const sp_scene *scene, const char *name);
    /* Takes the sample for this process until it is released, so that no other makes it as well; *taken = false while
     * another has it. A failure (nothing can be saved) ends the study. NULL: nobody else is there. */
    sp_status (*claim)(void *user, const char *name, bool *taken, sp_error *err);
    void (*release)(void *user, const char *name);
    /* the packing of that name if it is there (then only what is missing is computed): SP_OK and found = true */
    sp_status (*load)(void *user, const char *name, sp_packing *packing, sp_sample *sample, bool *found, sp_error *err);
    /* takes one finished sample; packing NULL for a failed one; of the arrays, which may be NULL, those that were made
     * now: a signal and frequencies that the sample has and that are not among them stay as they are there */
    sp_status (*save)(void *user, const sp_scene *scene, const sp_sample *sample, const sp_packing *packing,
                      const sp_sample_arrays *arrays, sp_error *err);
} sp_study_sink;

typedef struct sp_study_progress {
    int64_t total, done, computed, failed; /* samples; done counts those found in the store too */
    int64_t elsewhere;                     /* samples that other processes have, waited for at the end */
    double seconds, seconds_left;          /* wall clock; left NAN at first */
    double cost, cost_done, cost_computed; /* expected work of these samples, in units of its own */
} sp_study_progress;
/* Called about 4 times a second by the thread that called sp_study_run, and at the end. Return false to stop: packings
 * under way are given up, finished samples are kept. */
typedef bool (*sp_study_watch)(const sp_study_progress *progress, void *user);

typedef struct sp_study_options {
    int jobs;               /* threads, >= 1 */
    int shard, shards;      /* this process takes samples shard-1 (mod shards); 1, 1: all */
    int threads;            /* for one large packing at a time; 0, and with several jobs: one */
    const sp_packing *from; /* what packing.file names; NULL: nothing */
    /* Where several processes share one study: numbers 0, 1, 2, ... of its samples, each to one process only; below 0:
     * none is left. Called by the workers, one at a time, while the watch may be running. A study is then over when the
     * numbers are, whatever this process did of it. NULL: this process counts for itself. */
    int64_t (*take)(void *user);
    void *take_user;
} sp_study_options;

SP_API int64_t sp_study_count(const sp_scene *scene);
/* The scene of sample k, 0 <= k < count: sweep values and seed set. Samples are ordered so that every combination gets
 * its first seed before any gets its second. It shares the study's list of diameters. */
SP_API sp_status sp_study_scene(const sp_scene *study, int64_t k, sp_scene *out, sp_error *err);

/* Computes what is missing. A sample whose packing fails is saved as failed and does not stop the study; where only a
 * part of the results fails (no front, a floppy network), packing and other parts are saved with the reason, and the
 * sample counts as failed too. What failed is not tried again while the sink remembers it. Samples that another process
 * has claimed are left for the end, and waited for. SP_EINVAL before any work when a combination makes no scene;
 * SP_EINTERRUPTED when the watch said so; SP_EIO when the sink failed. *out, if not NULL, is filled in every case but
 * SP_EINVAL. */
SP_API sp_status sp_study_run(const sp_scene *scene, const sp_study_options *opt, const sp_study_sink *sink,
                              sp_study_watch watch, void *user, sp_study_progress *out, sp_error *err);

/* One sample: packing (made unless given: n > 0), and every part in `want` that is missing in *sample, or was made
 * otherwise than the scene says. Planes lie at least a diameter inside of the packing; those of the scene that do not
 * are left out. Where one part
 * fails the others are made all the same: the first reason is returned, and kept in sample->reason. Of *arrays, signal
 * and frequencies are filled where they are wanted and missing; NULL: neither is made. */
SP_API sp_status sp_sample_make(const sp_scene *scene, unsigned want, sp_packing *packing, sp_sample *sample,
                                sp_sample_arrays *arrays, sp_error *err);

/* Tables from samples in any order (they are sorted first): "ctof" (INTERFACE: p samples c_tof c_tof_err c_peak c_zero
 * c_l c_t, from the lowest and the highest boxes of each pressure), "scaling" and "planes" (fronts over
 * distance, see sonopack/scaling.h: a row a height of each pressure, friction and width; a row a plane, of each number
 * of grains besides), "statics", "moduli" and "probes" (each mean X, then X_sd, X_err, X_low, X_high; a row a pressure
 * and size), "ensemble" (one row a sample). _sd is one standard deviation of the samples, _err a standard error (sd /
 * sqrt(n) of means, of speeds by bootstrap over samples), _low to _high an interval of the level asked for, by
 * studentised bootstrap over samples (docs/physics.md, "Errors and intervals"): NAN with fewer than 2 samples. opt
 * NULL: the defaults. SP_EREFUSED for samples that differ in what has no rows, SP_EINVAL for a level out of range. */
typedef struct sp_table_options {
    double level; /* of the intervals: 0.95; 0.5 to 0.999 */
} sp_table_options;
SP_API sp_table_options sp_table_options_default(void);
SP_API sp_status sp_study_table(const char *table, int64_t n, const sp_sample *samples, const sp_table_options *opt,
                                sp_table *out, sp_error *err);

/* Mean and scatter of many signals at each of their times, from one signal at a time: none is kept. Start from
 * sp_signal_average_none(). */
typedef struct sp_signal_average {
    int32_t points;
    int64_t count;   /* signals */
    double *t;       /* [points] times of the first signal */
    double *mean;    /* [points] over the signals */
    double *squares; /* [points] sum of squares of the deviations from the mean */
} sp_signal_average;
SP_API sp_signal_average sp_signal_average_none(void);
SP_API void sp_signal_average_free(sp_signal_average *s);
/* One signal more, points >= 1 values f at the times t, by Welford's update (Technometrics 4, 419, 1962): no
 * difference of large sums. SP_EREFUSED, and nothing added, where the times are not those of the signals before to
 * 1e-12 of the last one. NAN in f is NAN in the results. */
SP_API sp_status sp_signal_average_add(sp_signal_average *s, int32_t points, const double *t, const double *f,
                                       sp_error *err);
/* At time k: the root mean square deviation from the mean (the sum of squares over the count, as Fig. 4 of Somfai et
 * al. 2005 shows it), and the standard error of the mean (with the count - 1). NAN for a single signal. */
SP_API double sp_signal_average_rms(const sp_signal_average *s, int32_t k);
SP_API double sp_signal_average_mean_err(const sp_signal_average *s, int32_t k);

/* Exponent of y ~ x^a with its standard error, from n >= 3 points with errors (relative weights). */
SP_API sp_status sp_fit_power(int64_t n, const double *x, const double *y, const double *y_err, double *exponent,
                              double *exponent_err, double *prefactor, sp_error *err);

#ifdef __cplusplus
}
#endif
#endif
