#ifndef SP_FOREIGN_MAT_H
#define SP_FOREIGN_MAT_H
/* MATLAB 5 MAT-files: a header, and then one matrix after another. */

#include "base/text.h"

#include <sonopack/table.h>

/* Failures other than of memory, which sets text->failed, are kept until the end. */
typedef struct sp_mat {
    sp_text *text;
    bool large; /* a variable exceeds the 2 GB of the format */
} sp_mat;

void sp_mat_begin(sp_mat *m, sp_text *text);
void sp_mat_number(sp_mat *m, const char *name, double value);
void sp_mat_text(sp_mat *m, const char *name, const char *text);
/* rows x columns, from a column-major array. */
void sp_mat_matrix(sp_mat *m, const char *name, int64_t rows, int64_t columns, const double *value);
/* A column vector for each numeric column of a table, and a cell array for each of texts: as variables, or as the
 * fields of one struct. Names are made valid for MATLAB. */
void sp_mat_columns(sp_mat *m, const sp_table *t);
void sp_mat_struct(sp_mat *m, const char *name, const sp_table *t);
/* The units of a table's columns as a struct of texts; its comments as a cell array. */
void sp_mat_units(sp_mat *m, const char *name, const sp_table *t);
void sp_mat_comments(sp_mat *m, const char *name, const sp_table *t);

#endif
