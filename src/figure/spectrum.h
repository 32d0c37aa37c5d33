#ifndef SP_FIGURE_SPECTRUM_H
#define SP_FIGURE_SPECTRUM_H
/* What figures of spectra share: curves of several tables, and memory for their numbers. */

#include "figure/settings.h"
#include "figure/unit.h"

#include <sonopack/figure/figure.h>

enum { SPECTRA_MOST = 32, SPECTRUM_GROUPS = 3 };

typedef struct spectrum_drawing {
    int tables;
    const sp_plot_table *table;
    double *memory; /* of all arrays */
    size_t used, room;
    sp_curve curve[2 * SPECTRA_MOST + 4 * SPECTRUM_GROUPS];
    int curves;
    char label[SPECTRA_MOST][SETTINGS_LABEL], band[96];
} spectrum_drawing;

/* Checks path and number of tables, and allocates `each' numbers a row and 1024 a table. Call sp_spectrum_end after
 * failure too. */
sp_status sp_spectrum_begin(int tables, const sp_plot_table *table, size_t each, const char *path,
                            spectrum_drawing **out, sp_error *err);
void sp_spectrum_end(spectrum_drawing *d);
/* Room for n numbers. */
double *sp_spectrum_take(spectrum_drawing *d, int64_t n);
/* The legend entry of table j; NULL if there is one table without a name of its own. */
const char *sp_spectrum_name(spectrum_drawing *d, int j);
sp_status sp_spectrum_column(const sp_table *t, const char *name, int *out, sp_error *err);
/* Whether any curve has a point with two finite coordinates; else SP_EREFUSED. columns: for the message. */
sp_status sp_spectrum_check(const spectrum_drawing *d, const char *columns, sp_error *err);

#endif
