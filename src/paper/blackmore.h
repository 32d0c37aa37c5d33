#ifndef SP_PAPER_BLACKMORE_H
#define SP_PAPER_BLACKMORE_H
/* What the files on the paper of the tapped column share. Equation numbers are those of the paper, called [B]. */

#include "paper/page.h"
#include "store/file.h"

#include <math.h>
#include <sonopack/column.h>
#include <sonopack/figure.h>
#include <sonopack/paper.h>

enum { TAPPED_ERRATA = 0, TAPPED_FIG_1, TAPPED_FIG_2, TAPPED_SYMBOLS, TAPPED_CHAOS, TAPPED_CLAIMS, TAPPED_FIGURES = 6 };

/* What the paper says of ours. */
typedef enum tapped_relation { TAPPED_EQUAL = 0, TAPPED_ABOVE, TAPPED_BELOW } tapped_relation;

typedef struct tapped_row {
    int item;
    const char *equation; /* "(24)", "Fig. 1", "Sect. 3" */
    const char *unit;
    char quantity[80];
    tapped_relation relation;
    double paper, precision; /* paper NAN: no number; precision 0: exact */
    double ours, err;        /* err NAN: no bound is known; 0: rounding alone */
    bool claim;              /* in words or a theorem: it holds or not */
    bool misprint;           /* paper is what is wrongly printed, ours what is right */
    bool detail;             /* in the table, not in the report */
    char note[240];
    const char *verdict; /* filled in by tapped_judge */
} tapped_row;
void tapped_judge(tapped_row *row);

typedef struct tapped_section {
    sp_text text; /* a paragraph a line */
    int figures;
    char file[TAPPED_FIGURES][40];
    char caption[TAPPED_FIGURES][320];
} tapped_section;

typedef struct tapped {
    const sp_paper_column_options *opt;
    sp_paper_watch watch;
    void *user;
    double begun;               /* wall clock */
    double item_at, item_share; /* of the item under way in the whole work */
    int64_t rows, capacity;
    tapped_row *row;
    tapped_section section[SP_PAPER_COLUMN_ITEMS];
} tapped;

typedef struct tapped_item {
    const char *name, *title, *shows; /* shows: what the paper has there */
    sp_status (*make)(tapped *p, sp_error *err);
    double share; /* of the work */
} tapped_item;
extern const tapped_item tapped_items[SP_PAPER_COLUMN_ITEMS];

bool tapped_wants(const tapped *p, int item);
/* The share of the present item that is done, told to the watch. SP_EINTERRUPTED if it says stop. */
sp_status tapped_tell(tapped *p, double done, sp_error *err);

/* The column of Fig. 1: 5 particles at 7.5 Hz or 10 at 9.5 Hz, T = 1 s, four taps. */
sp_column_spec tapped_column(int32_t particles);
/* m g/K, the overlap that carries one particle [cm]. */
double tapped_overlap(const sp_column_spec *c);

/* Judges a row and keeps it. note: "" or words for people. */
sp_status tapped_add(tapped *p, tapped_row row, sp_error *err, const char *quantity, ...)
    __attribute__((format(printf, 4, 5)));
void tapped_say(tapped *p, int item, const char *format, ...) __attribute__((format(printf, 3, 4)));

/* Tables and figures go into the folder, where there is one. */
sp_status tapped_save(tapped *p, const char *name, sp_table *t, sp_error *err);
/* Draws tables of the column as NAME. labels: of each, may be NULL. */
sp_status tapped_draw(tapped *p, int item, const char *name, int tables, const sp_table *const *table,
                      const char *const *labels, const char *caption, sp_error *err);
sp_status tapped_draw_sheet(tapped *p, int item, const char *name, const sp_sheet *sheet, const char *caption,
                            sp_error *err);

sp_status tapped_rows_table(int64_t n, const tapped_row *rows, int item, sp_table *out, sp_error *err);
sp_status tapped_report(tapped *p, sp_error *err);

sp_status tapped_make_errata(tapped *p, sp_error *err);
sp_status tapped_make_fig1(tapped *p, sp_error *err);
sp_status tapped_make_fig2(tapped *p, sp_error *err);
sp_status tapped_make_symbols(tapped *p, sp_error *err);
sp_status tapped_make_chaos(tapped *p, sp_error *err);
sp_status tapped_make_claims(tapped *p, sp_error *err);

#endif
