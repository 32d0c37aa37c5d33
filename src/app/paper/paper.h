#ifndef SP_PAPER_PAPER_H
#define SP_PAPER_PAPER_H
/* State of the work on the paper, and the functions that the items share. */

#include "base/file.h"
#include "base/text.h"
#include "paper/ensemble.h"
#include "paper/reference.h"
#include "paper/verdict.h"

#include "paper/reproduce.h"
#include <sonopack/figure/figure.h>
#include <sonopack/network.h>

enum { PAPER_FIGURES = 6, PAPER_NEEDS = 12 };

/* Finished samples of an ensemble, in the order of the scene's combinations and then seeds. */
typedef struct paper_set {
    int64_t n;
    sp_sample *sample; /* [n] */
} paper_set;

typedef struct paper_section {
    sp_text text; /* sentences about our result, one paragraph per line */
    int figures;
    char file[PAPER_FIGURES][32];     /* file names in the folder */
    char caption[PAPER_FIGURES][240]; /* captions */
} paper_section;

typedef struct paper {
    const sp_paper_options *opt;
    sp_store *store;
    sp_paper_watch watch;
    void *user;
    double begun;           /* wall clock */
    double cost, cost_done; /* CPU seconds expected of all ensembles, and of the finished ones */
    int64_t computed, failed;
    int64_t rows;
    paper_row *row;
    paper_set set[PAPER_ENSEMBLES];
    paper_section section[SP_PAPER_ITEMS];
} paper;

/* User data of a walk over samples for one item. */
typedef struct paper_work {
    paper *p;
    int item;
} paper_work;

/* An ensemble that an item requires. drawn: only for its figures. */
typedef struct paper_need {
    paper_ensemble ensemble;
    unsigned want;
    bool drawn;
} paper_need;

typedef struct paper_item {
    const char *name, *title, *shows; /* shows: the content of the item in the paper */
    sp_status (*make)(paper *p, int item, sp_error *err);
    int needs;
    paper_need need[PAPER_NEEDS];
} paper_item;
extern const paper_item sp_paper_items[SP_PAPER_ITEMS];

bool sp_paper_wants(const paper *p, int item);
/* Reports progress. False if the user stops the run. */
bool sp_paper_report_progress(const paper *p, const char *what, double fraction, int64_t computed, int64_t failed);
/* Reports progress during work on the samples. SP_EINTERRUPTED if the user stops the run. */
sp_status sp_paper_tell(paper *p, const char *what, double fraction, sp_error *err);

/* ---- ensembles -------------------------------------------------------------------------------------------------- */

/* Computes the samples that the wanted items require and the store lacks, and reads them. */
sp_status sp_paper_collect(paper *p, sp_error *err);
/* Values of the samples of an ensemble with this pressure and number of grains (0: any). part: SP_WANT_ flags that a
 * sample must have. *n: number of values. Free *values with sp_free. */
sp_status sp_paper_values(const paper *p, paper_ensemble e, double pressure, int32_t grains, unsigned part,
                          double (*of)(const sp_sample *s), int64_t *n, double **values, sp_error *err);

/* Called with a sample, its packing and its network. A status other than SP_OK ends the walk. */
typedef sp_status (*paper_visit)(const sp_sample *s, const sp_packing *packing, const sp_network *net, void *user,
                                 sp_error *err);
/* Visits samples of an ensemble in the order of their seeds, at most `most` (0: all). */
sp_status sp_paper_walk(paper *p, paper_ensemble e, double pressure, int32_t grains, int64_t most, paper_visit visit,
                        void *user, sp_error *err);

/* ---- figures ---------------------------------------------------------------------------------------------------- */

#define PAPER_TIME_AXIS "time |t|  [|d| (|ρ|/|E|*)^{1/2}]"

/* ---- results ---------------------------------------------------------------------------------------------------- */

/* Judges a row and adds it. */
sp_status sp_paper_add_row(paper *p, paper_row row, sp_error *err);
/* Adds a row for a number that the paper states in words. value: {number, precision of the wording}, ours: {value,
 * standard error}. quantity: printf-style. */
sp_status sp_paper_add_stated(paper *p, int item, double pressure, paper_scatter scatter, const double value[2],
                              const double ours[2], sp_error *err, const char *quantity, ...)
    __attribute__((format(printf, 8, 9)));
/* Adds a sentence about our result; plain text, printf-style. */
void sp_paper_say(paper *p, int item, const char *format, ...) __attribute__((format(printf, 3, 4)));

/* Writes the path FOLDER/NAME.ENDING. */
void sp_paper_path(const paper *p, const char *name, const char *ending, char path[SP_PATH_MAX]);
/* Adds a figure that is already drawn as NAME.(svg, png or pdf). */
void sp_paper_add_figure(paper *p, int item, const char *name, const char *caption);
/* Draws a sheet as NAME and writes the numbers of its curves to NAME.tsv. Does nothing without a folder. */
sp_status sp_paper_draw(paper *p, int item, const char *name, const sp_sheet *sheet, const char *caption,
                        sp_error *err);
sp_status sp_paper_save_table(paper *p, const char *name, sp_table *t, sp_error *err);

sp_status sp_paper_report_begin(paper *p, sp_error *err);
sp_status sp_paper_report(paper *p, sp_error *err);

/* ---- items ------------------------------------------------------------------------------------------------------ */

sp_status sp_paper_make_table(paper *p, int item, sp_error *err);     /* Tables I, II, IV, V */
sp_status sp_paper_make_exponents(paper *p, int item, sp_error *err); /* Table III and its figure */
sp_status sp_paper_make_fig1(paper *p, int item, sp_error *err);
sp_status sp_paper_make_fig2(paper *p, int item, sp_error *err);
sp_status sp_paper_make_fig3(paper *p, int item, sp_error *err);
sp_status sp_paper_make_fig4(paper *p, int item, sp_error *err);
sp_status sp_paper_make_fig5(paper *p, int item, sp_error *err);
sp_status sp_paper_make_fig6(paper *p, int item, sp_error *err);
sp_status sp_paper_make_fig7(paper *p, int item, sp_error *err);
sp_status sp_paper_make_fig8(paper *p, int item, sp_error *err);
sp_status sp_paper_make_fig9(paper *p, int item, sp_error *err);
sp_status sp_paper_make_fig10(paper *p, int item, sp_error *err);
sp_status sp_paper_make_fig11(paper *p, int item, sp_error *err);
sp_status sp_paper_make_fig12(paper *p, int item, sp_error *err);
sp_status sp_paper_make_claims(paper *p, int item, sp_error *err);

#endif
