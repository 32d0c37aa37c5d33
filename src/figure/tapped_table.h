#ifndef SP_PLOT_COLUMN_TABLE_H
#define SP_PLOT_COLUMN_TABLE_H
/* Tables of `sonopack column': which output one is, and its columns as numbers. */

#include "figure/markup.h"

#include <sonopack/figure/figure.h>
#include <sonopack/figure/plot.h>

typedef enum tapped_plot_output {
    TAPPED_PLOT_TRAJECTORY = 0,
    TAPPED_PLOT_STROBE,
    TAPPED_PLOT_LYAPUNOV,
    TAPPED_PLOT_BIFURCATION,
    TAPPED_PLOT_COMPARE,
    TAPPED_PLOT_DENSITY,
    TAPPED_PLOT_ENERGY
} tapped_plot_output;

typedef struct tapped_plot_table {
    const sp_table *table;
    const char *label;
    tapped_plot_output output;
    int particles; /* columns y1 .. yN; 0: none */
    int abscissa;  /* t, tap or parameter */
    int floor;     /* y0; < 0: none */
    int first;     /* y1 */
    int density;   /* rho1; < 0: none */
} tapped_plot_table;

/* SP_EINVAL for a table of another kind or with columns missing, SP_EREFUSED for one without rows. */
sp_status sp_tapped_plot_find(const sp_plot_table *from, tapped_plot_table *out, sp_error *err);
/* A column of numbers by its name; < 0: there is none. */
int sp_tapped_plot_column(const tapped_plot_table *s, const char *name);
/* Its numbers, NAN where they are infinite; to [rows]. */
const double *sp_tapped_plot_values(const tapped_plot_table *s, int column, double *to);
/* The abscissa; SP_EREFUSED where it is not finite, or does not rise, or where there are fewer than two rows. */
sp_status sp_tapped_plot_times(const tapped_plot_table *s, double *to, sp_error *err);
/* A positive number in a comment "key = value"; NAN: none. */
double sp_tapped_plot_setting(const tapped_plot_table *s, const char *key);

enum { TAPPED_PLOT_LABEL = 200 };
/* A name with the unit of a column behind it. */
const char *sp_tapped_plot_axis(const tapped_plot_table *s, const char *name, int column, char out[TAPPED_PLOT_LABEL]);
/* What the parameter of a diagram is called. */
const char *sp_tapped_plot_parameter(const tapped_plot_table *s, char out[TAPPED_PLOT_LABEL]);

/* What a table is called in a sentence, as "a trajectory". */
const char *sp_tapped_plot_kind(tapped_plot_output output);
/* "order (1) violated at 3 of 40 points" where the comments of a diagram warn of it; else "". */
const char *sp_tapped_plot_violation(const tapped_plot_table *s, char out[TAPPED_PLOT_LABEL]);

/* One to four panels in the width of a column of print, one below the other. */
typedef struct tapped_plot_sheet {
    const char *title; /* of the document, not drawn */
    int panels;
    const sp_panel *panel; /* [panels] */
    double aspect;         /* height of a panel over its width */
    bool whole;            /* ticks of x at whole numbers only */
    const char *note;      /* small print at the foot, markup; NULL or "": none */
} tapped_plot_sheet;
sp_status sp_tapped_draw_sheet(const tapped_plot_sheet *source, const char *path, sp_error *err);

/* Figures; tables of the right outputs. */
sp_status sp_tapped_draw_trajectory(const tapped_plot_table *s, const char *path, sp_error *err);
sp_status sp_tapped_draw_surfaces(int tables, const tapped_plot_table *s, const char *path, sp_error *err);
sp_status sp_tapped_draw_strobe(const tapped_plot_table *s, const char *path, sp_error *err);
sp_status sp_tapped_draw_compare(const tapped_plot_table *s, const char *path, sp_error *err);
sp_status sp_tapped_draw_density(const tapped_plot_table *s, const char *path, sp_error *err);
sp_status sp_tapped_draw_energy(const tapped_plot_table *s, const char *path, sp_error *err);
/* lyapunov or bifurcation may be NULL, column then too; column: of the bifurcation. */
sp_status sp_tapped_draw_diagram(const tapped_plot_table *bifurcation, int column, const tapped_plot_table *lyapunov,
                                 const char *path, sp_error *err);

#endif
