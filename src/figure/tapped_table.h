#ifndef SP_FIGURE_TAPPED_TABLE_H
#define SP_FIGURE_TAPPED_TABLE_H
/* Reads the tables of `sonopack column` for figures: the kind of output, and its columns as numbers. */

#include "figure/markup.h"

#include <sonopack/figure/figure.h>
#include <sonopack/figure/plot.h>

typedef enum tapped_output {
    TAPPED_TRAJECTORY = 0,
    TAPPED_STROBE,
    TAPPED_LYAPUNOV,
    TAPPED_BIFURCATION,
    TAPPED_COMPARE,
    TAPPED_DENSITY,
    TAPPED_ENERGY
} tapped_output;

typedef struct tapped_table {
    const sp_table *table;
    const char *label;
    bool named; /* the label is the reader's */
    tapped_output output;
    int particles; /* number of columns y1 .. yN; 0: none */
    int abscissa;  /* column t, tap or parameter */
    int floor;     /* column y0; < 0: none */
    int first;     /* column y1 */
    int density;   /* column rho1; < 0: none */
} tapped_table;

/* Returns SP_EINVAL for a table of another kind or with columns missing, SP_EREFUSED for one without rows. */
sp_status sp_tapped_table_read(const sp_plot_table *from, tapped_table *out, sp_error *err);
/* Index of a column of numbers; < 0 if there is none. */
int sp_tapped_table_column(const tapped_table *s, const char *name);
/* Copies a column to `to` [rows], with NAN for infinite values. */
const double *sp_tapped_table_values(const tapped_table *s, int column, double *to);
/* Whether any of the n numbers is finite. */
bool sp_tapped_any_finite(int64_t n, const double *y);
/* Copies the abscissa. Returns SP_EREFUSED if it is not finite or not ascending, or has fewer than two rows. */
sp_status sp_tapped_table_abscissa(const tapped_table *s, double *to, sp_error *err);
/* Value of a comment "key = value" if it is a positive number, else NAN. */
double sp_tapped_table_setting(const tapped_table *s, const char *key);

enum { TAPPED_LABEL = 200 };
/* Writes an axis label: the name with the unit of the column. */
const char *sp_tapped_axis_label(const tapped_table *s, const char *name, int column, char out[TAPPED_LABEL]);
/* Axis label of the varied parameter of a diagram. */
const char *sp_tapped_parameter_label(const tapped_table *s, char out[TAPPED_LABEL]);

/* Description of a table for messages, as "a trajectory". */
const char *sp_tapped_table_kind(tapped_output output);
/* Writes "order (1) violated at 3 of 40 points" if the comments of a diagram warn of it, else "". */
const char *sp_tapped_violation_note(const tapped_table *s, char out[TAPPED_LABEL]);

/* One to four panels below each other, one column of print wide. */
typedef struct tapped_sheet {
    const char *title; /* title of the document, not drawn */
    int panels;
    const sp_panel *panel; /* [panels] */
    double aspect;         /* height of a panel over its width */
    bool whole;            /* ticks of x at whole numbers only */
    const char *note;      /* lines of small print at the bottom, in markup; NULL or "": none */
} tapped_sheet;
sp_status sp_tapped_draw_sheet(const tapped_sheet *source, const char *path, sp_error *err);

/* Draws a figure with memory for `count` numbers. */
typedef sp_status tapped_draw(const tapped_table *s, double *memory, const char *path, sp_error *err);
sp_status sp_tapped_draw_with_memory(tapped_draw *draw, size_t count, const tapped_table *s, const char *path,
                                     sp_error *err);

/* Each draws one figure; the caller has checked the kind of the tables. */
sp_status sp_tapped_draw_trajectory(const tapped_table *s, const char *path, sp_error *err);
sp_status sp_tapped_draw_surfaces(int tables, const tapped_table *s, const char *path, sp_error *err);
sp_status sp_tapped_draw_strobe(const tapped_table *s, const char *path, sp_error *err);
sp_status sp_tapped_draw_compare(const tapped_table *s, const char *path, sp_error *err);
sp_status sp_tapped_draw_density(const tapped_table *s, const char *path, sp_error *err);
sp_status sp_tapped_draw_energy(const tapped_table *s, const char *path, sp_error *err);
/* Either table may be NULL. column: the column of positions in the bifurcation table. */
sp_status sp_tapped_draw_diagram(const tapped_table *bifurcation, int column, const tapped_table *lyapunov,
                                 const char *path, sp_error *err);

#endif
