#ifndef SONOPACK_PAPER_H
#define SONOPACK_PAPER_H
/* Published papers computed again: tables and figures beside our own values. One is E. Somfai, J.-N. Roux, J. H.
 * Snoeijer, M. van Hecke, W. van Saarloos, Phys. Rev. E 72, 021301 (2005), cond-mat/0408128; the other, of the tapped
 * column, D. Blackmore, A. Rosato, X. Tricoche, K. Urban, V. Ratnaswamy, J. Mech. Mater. Struct. 6 (2011), is at the
 * end.
 */

#include <sonopack/study/store.h>
#include <sonopack/table.h>
#include <stdbool.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

enum { SP_PAPER_ITEMS = 18 }; /* table1 .. table5, fig1 .. fig12, claims */

/* Name ("table1", "fig12") and caption of an item, 0 <= item < SP_PAPER_ITEMS; NULL for others. */
const char *sp_paper_item_name(int item);
const char *sp_paper_item_title(int item);

typedef struct sp_paper_progress {
    const char *what;             /* what is under way */
    double fraction;              /* of the whole work, by expected costs */
    double seconds, seconds_left; /* wall clock; left NAN at first */
    int64_t computed, failed;     /* samples */
} sp_paper_progress;
/* Called several times a second. Return false to stop: what is finished is in the store. */
typedef bool (*sp_paper_watch)(const sp_paper_progress *progress, void *user);

typedef struct sp_paper_options {
    uint32_t items;  /* bit k: item k; 0: all */
    int32_t samples; /* packings of each pressure; 30 in the paper. Low boxes and those of 1200 grains have as many,
                        2400 grains half, spheres a quarter */
    sp_protocol protocol; /* how packings are compressed */
    int jobs, threads;    /* as in sp_study_options */
    const char *folder;   /* for the report, its figures and tables; NULL: none */
    const char *figures;  /* "svg", "png" or "pdf" */
} sp_paper_options;
sp_paper_options sp_paper_options_default(void); /* all items, 30 samples, one job, no folder, svg */

/* Whether a report may go into a folder: one that is not there yet, empty, or has a report already (SP_EINVAL unless it
 * is an unfinished one, or `replace`). The folder is made. SP_EINVAL, SP_EIO. */
sp_status sp_paper_check_folder(const char *folder, bool replace, sp_error *err);

/* Makes what is missing in the store, then one row a value or claim of the paper: item p quantity paper paper_sd ours
 * err sigma verdict ours_sd samples combined scatter deviation_err rounding relation where note, and the report if
 * there is a folder for it. sigma: the deviation over one standard deviation of the paper; verdict: "agrees" within
 * one, "deviates", or "missing"; combined: the deviation over both standard errors, deviation_err with the rounding of
 * print; claims in words have scatter "claim", a relation, and the verdict "holds", "contradicted" or "undecided". The
 * comments say it all, and count: values within and beyond, chi^2, systematic deviations, claims. SP_EINTERRUPTED when
 * the watch said so. */
sp_status sp_paper_reproduce(sp_store *store, const sp_paper_options *opt, sp_paper_watch watch, void *user,
                             sp_table *out, sp_error *err);

/* ---- the tapped column ------------------------------------------------------------------------------------------ */

enum { SP_PAPER_COLUMN_ITEMS = 6 }; /* errata, fig1, fig2, symbols, chaos, claims */

const char *sp_paper_column_item_name(int item); /* NULL for others */
const char *sp_paper_column_item_title(int item);

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
