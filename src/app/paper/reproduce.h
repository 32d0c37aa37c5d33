#ifndef SONOPACK_PAPER_H
#define SONOPACK_PAPER_H
/* Reproduces two published papers: their tables and figures with our own values. The first is E. Somfai, J.-N. Roux, J.
 * H. Snoeijer, M. van Hecke, W. van Saarloos, Phys. Rev. E 72, 021301 (2005), cond-mat/0408128. The second, on the
 * tapped column, is D. Blackmore, A. Rosato, X. Tricoche, K. Urban, V. Ratnaswamy, J. Mech. Mater. Struct. 6 (2011). */

#include <sonopack/study/store.h>
#include <sonopack/table.h>
#include <stdbool.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

enum { SP_PAPER_ITEMS = 18 }; /* table1 to table5, fig1 to fig12, claims */

/* Name ("table1", "fig12") and caption of an item, 0 <= item < SP_PAPER_ITEMS; otherwise NULL. */
const char *sp_paper_item_name(int item);
const char *sp_paper_item_title(int item);

typedef struct sp_paper_progress {
    const char *what;             /* current step */
    double fraction;              /* of the whole run, by expected cost */
    double seconds, seconds_left; /* wall clock; seconds_left is NAN at first */
    int64_t computed, failed;     /* samples computed and failed */
} sp_paper_progress;
/* Called several times per second. Return false to stop; finished samples stay in the store. */
typedef bool (*sp_paper_watch)(const sp_paper_progress *progress, void *user);

typedef struct sp_paper_options {
    uint32_t items;  /* bit k selects item k; 0: all */
    int32_t samples; /* packings at each pressure; 30 in the paper. Ensembles of low boxes and of 1200 grains have as
                        many, those of 2400 grains half as many, those of spheres a quarter */
    sp_protocol protocol; /* how packings are compressed */
    int jobs, threads;    /* as in sp_study_options */
    const char *folder;   /* folder of the report, its figures and tables; NULL: no report */
    const char *figures;  /* "svg", "png" or "pdf" */
} sp_paper_options;
sp_paper_options sp_paper_options_default(void); /* all items, 30 samples, one job, no folder, svg */

/* Visits the ensembles that the wanted items need, as the scenes of studies. A status other than SP_OK ends it. */
typedef sp_status (*sp_paper_visit)(const char *name, const sp_scene *scene, void *user, sp_error *err);
sp_status sp_paper_ensembles(const sp_paper_options *opt, sp_paper_visit visit, void *user, sp_error *err);
/* Expected CPU seconds of an item when its samples are there; drawn: with its figures. Measured on one machine. */
double sp_paper_item_seconds(int item, bool drawn);

/* Checks that a report can be written to a folder, and makes the folder. It must be new, empty, or have an unfinished
 * report; with `replace`, any report of ours. SP_EINVAL, SP_EIO. */
sp_status sp_paper_check_folder(const char *folder, bool replace, sp_error *err);

/* Computes the samples that the store lacks, then one row for each value or claim of the paper, and the report if there
 * is a folder. Columns: item p quantity paper paper_sd ours err sigma verdict ours_sd samples combined scatter
 * deviation_err rounding relation where note. sigma: the difference in standard deviations of the paper. verdict:
 * "agrees" within one, "deviates", or "missing". combined: the difference in combined standard errors; deviation_err
 * includes the rounding of the printed value. Claims in words have scatter "claim", a relation, and the verdict
 * "holds", "contradicted" or "undecided". Comments explain the columns and give counts: values within and beyond,
 * chi^2, systematic differences, claims. SP_EINTERRUPTED if the watch returned false. */
sp_status sp_paper_reproduce(sp_store *store, const sp_paper_options *opt, sp_paper_watch watch, void *user,
                             sp_table *out, sp_error *err);

/* ---- the tapped column ------------------------------------------------------------------------------------------ */

enum { SP_PAPER_COLUMN_ITEMS = 6 }; /* errata, fig1, fig2, symbols, chaos, claims */

const char *sp_paper_column_item_name(int item); /* NULL for others */

double sp_paper_column_item_seconds(int item, bool drawn); /* as sp_paper_item_seconds */

typedef struct sp_paper_column_options {
    uint32_t items; /* bit k: item k; 0: all */
    int threads;
    const char *folder;  /* for the report, its figures and tables (sp_paper_check_folder); NULL: none */
    const char *figures; /* "svg", "png" or "pdf" */
} sp_paper_column_options;
sp_paper_column_options sp_paper_column_options_default(void); /* all items, one thread, no folder, svg */

/* Everything is computed anew, in seconds. One row a value: item equation quantity unit relation paper precision ours
 * err verdict note. paper: what is printed, or what a printed equation or claim gives (relation: that ours should be
 * equal, above or below); precision: how sharply it is printed. verdict: "agrees", "deviates"; "erratum" where the
 * paper is wrong by its own premises and ours is what is right; "not given" where it has no number; "missing" where we
 * have none; of claims in words "holds", "contradicted", or "undecided" within our error. SP_EINTERRUPTED when the
 * watch said so. */
sp_status sp_paper_column_reproduce(const sp_paper_column_options *opt, sp_paper_watch watch, void *user, sp_table *out,
                                    sp_error *err);

#ifdef __cplusplus
}
#endif
#endif
