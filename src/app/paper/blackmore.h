#ifndef SP_PAPER_BLACKMORE_H
#define SP_PAPER_BLACKMORE_H
/* Declarations shared by the files that reproduce the paper on the tapped column. Equation numbers are those of the
 * paper, called [B]. */

#include "base/file.h"
#include "paper/page.h"

#include "paper/reproduce.h"
#include <math.h>
#include <sonopack/figure/figure.h>
#include <sonopack/tapped/tapped.h>

enum { BLACKMORE_ERRATA = 0, BLACKMORE_FIG_1, BLACKMORE_FIG_2, BLACKMORE_SYMBOLS, BLACKMORE_CHAOS, BLACKMORE_CLAIMS };
enum { BLACKMORE_FIGURES = 6 }; /* at most, in a section */

static const double blackmore_pi = 3.14159265358979323846;

/* What the paper claims about our value, relative to its own. */
typedef enum blackmore_relation { BLACKMORE_EQUAL = 0, BLACKMORE_ABOVE, BLACKMORE_BELOW } blackmore_relation;

typedef struct blackmore_row {
    int item;
    const char *equation; /* "(24)", "Fig. 1", "Sect. 3" */
    const char *unit;
    char quantity[80];
    blackmore_relation relation;
    double paper, precision; /* paper: NAN if there is no number; precision: 0 if it is exact */
    double ours, err;        /* err: NAN if no bound is known, 0 for rounding alone */
    bool claim;              /* a statement in words, or a theorem, that holds or not */
    bool misprint;           /* the paper's value is a misprint, ours the correct one */
    bool detail;             /* left out of the report, but not of the table */
    char note[240];
    const char *verdict; /* set by sp_blackmore_set_verdict */
} blackmore_row;
void sp_blackmore_set_verdict(blackmore_row *row);

typedef struct blackmore_section {
    sp_text text; /* one paragraph a line */
    int figures;
    char file[BLACKMORE_FIGURES][40];
    char caption[BLACKMORE_FIGURES][320];
} blackmore_section;

typedef struct blackmore blackmore;
typedef struct blackmore_item {
    const char *name, *title, *shows; /* shows: what the paper has there */
    sp_status (*make)(blackmore *p, sp_error *err);
    double share; /* of the work */
} blackmore_item;

struct blackmore {
    const sp_paper_column_options *opt;
    const blackmore_item *items; /* [SP_PAPER_COLUMN_ITEMS] */
    sp_paper_watch watch;
    void *user;
    double begun;               /* wall clock at the start */
    const char *step;           /* name of the item that is made */
    double item_at, item_share; /* progress of the whole work: at the start of the item, and share of the item */
    int64_t rows;
    size_t capacity;
    blackmore_row *row;
    bool failed; /* a row found no memory */
    blackmore_section section[SP_PAPER_COLUMN_ITEMS];
};

bool sp_blackmore_is_selected(const blackmore *p, int item);
/* Reports the progress of the present item, 0 .. 1. Returns SP_EINTERRUPTED if the watch asks to stop. */
sp_status sp_blackmore_progress(blackmore *p, double done, sp_error *err);

/* The column of Fig. 1: 5 particles at 7.5 Hz or 10 at 9.5 Hz, T = 1 s, four taps. */
sp_tapped_spec sp_blackmore_column(int32_t particles);
/* m g/K, the overlap that supports one particle [cm]. */
double sp_blackmore_overlap(const sp_tapped_spec *c);
/* K h^2/m, the unit of squared speeds [cm^2/s^2]. */
double sp_blackmore_speed2(const sp_tapped_spec *c);
/* Smallest separation in any tap of a report [cm]. */
double sp_blackmore_separation(const sp_tapped_report *report);
/* The coefficients (36) and (38) for sigma = tanh(alpha s): A(+), A(-), B. */
typedef struct blackmore_coefficients {
    double plus, minus, b;
} blackmore_coefficients;
blackmore_coefficients sp_blackmore_coefficients(double r, double alpha);

/* Sets the note of a row, in words for readers. */
void sp_blackmore_note(blackmore_row *row, const char *format, ...) __attribute__((format(printf, 2, 3)));
/* Sets the quantity and verdict of a row and stores the row. Without memory it sets p->failed. */
void sp_blackmore_add(blackmore *p, blackmore_row row, const char *quantity, ...) __attribute__((format(printf, 3, 4)));
/* Adds a paragraph to the section of an item. */
void sp_blackmore_say(blackmore *p, int item, const char *format, ...) __attribute__((format(printf, 3, 4)));

/* These write tables and figures to the folder, if there is one. */
sp_status sp_blackmore_save(blackmore *p, const char *name, sp_table *t, sp_error *err);
/* Draws the tables as figure NAME. labels [tables] may be NULL. */
sp_status sp_blackmore_draw(blackmore *p, int item, const char *name, int tables, const sp_table *const *table,
                            const char *const *labels, const char *caption, sp_error *err);
sp_status sp_blackmore_draw_sheet(blackmore *p, int item, const char *name, const sp_sheet *sheet, const char *caption,
                                  sp_error *err);

/* Makes the table of the rows of an item, or of all for item < 0. */
sp_status sp_blackmore_rows_table(const blackmore *p, int item, sp_table *out, sp_error *err);
sp_status sp_blackmore_report(blackmore *p, sp_error *err);

sp_status sp_blackmore_make_errata(blackmore *p, sp_error *err);
sp_status sp_blackmore_make_fig1(blackmore *p, sp_error *err);
sp_status sp_blackmore_make_fig2(blackmore *p, sp_error *err);
sp_status sp_blackmore_make_symbols(blackmore *p, sp_error *err);
sp_status sp_blackmore_make_chaos(blackmore *p, sp_error *err);
sp_status sp_blackmore_make_claims(blackmore *p, sp_error *err);

#endif
