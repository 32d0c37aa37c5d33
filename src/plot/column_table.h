#ifndef SP_PLOT_COLUMN_TABLE_H
#define SP_PLOT_COLUMN_TABLE_H
/* Tables of `sonopack column': which output one is, and its columns as numbers. */

#include "plot/markup.h"

#include <sonopack/figure.h>
#include <sonopack/plot.h>

typedef enum stack_output {
    STACK_TRAJECTORY = 0,
    STACK_STROBE,
    STACK_LYAPUNOV,
    STACK_BIFURCATION,
    STACK_COMPARE,
    STACK_DENSITY,
    STACK_ENERGY
} stack_output;

typedef struct stack_table {
    const sp_table *table;
    const char *label;
    stack_output output;
    int particles; /* columns y1 .. yN; 0: none */
    int abscissa;  /* t, tap or parameter */
    int floor;     /* y0; < 0: none */
    int first;     /* y1 */
    int density;   /* rho1; < 0: none */
} stack_table;

/* SP_EINVAL for a table of another kind or with columns missing, SP_EREFUSED for one without rows. */
sp_status stack_find(const sp_plot_table *from, stack_table *out, sp_error *err);
/* A column of numbers by its name; < 0: there is none. */
int stack_column(const stack_table *s, const char *name);
/* Its numbers, NAN where they are infinite; to [rows]. */
const double *stack_values(const stack_table *s, int column, double *to);
/* The abscissa; SP_EREFUSED where it is not finite, or does not rise, or where there are fewer than two rows. */
sp_status stack_times(const stack_table *s, double *to, sp_error *err);
/* A positive number in a comment "key = value"; NAN: none. */
double stack_setting(const stack_table *s, const char *key);

enum { STACK_LABEL = 200 };
/* A name with the unit of a column behind it. */
const char *stack_axis(const stack_table *s, const char *name, int column, char out[STACK_LABEL]);
/* What the parameter of a diagram is called. */
const char *stack_parameter(const stack_table *s, char out[STACK_LABEL]);

/* What a table is called in a sentence, as "a trajectory". */
const char *stack_kind(stack_output output);
/* "order (1) violated at 3 of 40 points" where the comments of a diagram warn of it; else "". */
const char *stack_violation(const stack_table *s, char out[STACK_LABEL]);

/* One to four panels in the width of a column of print, one below the other. */
typedef struct stack_sheet {
    const char *title; /* of the document, not drawn */
    int panels;
    const sp_panel *panel; /* [panels] */
    double aspect;         /* height of a panel over its width */
    bool whole;            /* ticks of x at whole numbers only */
    const char *note;      /* small print at the foot, markup; NULL or "": none */
} stack_sheet;
sp_status stack_draw_sheet(const stack_sheet *source, const char *path, sp_error *err);

/* Figures; tables of the right outputs. */
sp_status stack_draw_trajectory(const stack_table *s, const char *path, sp_error *err);
sp_status stack_draw_surfaces(int tables, const stack_table *s, const char *path, sp_error *err);
sp_status stack_draw_strobe(const stack_table *s, const char *path, sp_error *err);
sp_status stack_draw_compare(const stack_table *s, const char *path, sp_error *err);
sp_status stack_draw_density(const stack_table *s, const char *path, sp_error *err);
sp_status stack_draw_energy(const stack_table *s, const char *path, sp_error *err);
/* lyapunov or bifurcation may be NULL, column then too; column: of the bifurcation. */
sp_status stack_draw_diagram(const stack_table *bifurcation, int column, const stack_table *lyapunov, const char *path,
                             sp_error *err);

#endif
