/* What figures of spectra share. */
#include "figure/spectrum.h"

#include "base/base.h"
#include "figure/canvas.h"
#include "figure/columns.h"

#include <math.h>

enum { LABEL_MOST = 28 };

sp_status sp_spectrum_begin(int tables, const sp_plot_table *table, size_t each, const char *path,
                            spectrum_drawing **out, sp_error *err) {
    const sp_status status = sp_canvas_check(path, err);
    *out = NULL;
    if (status != SP_OK)
        return status;
    if (tables < 1 || tables > SPECTRA_MOST)
        return sp_fail(err, SP_EINVAL, "%d tables: a figure shows 1 to %d", tables, SPECTRA_MOST);
    spectrum_drawing *d = *out = sp_alloc(1, sizeof *d);
    if (!d)
        return sp_fail_memory(err, sizeof *d);
    d->tables = tables;
    d->table = table;
    for (int j = 0; j < tables; j++)
        d->room += each * (size_t)table[j].table->rows + 1024;
    d->memory = sp_alloc(d->room, sizeof *d->memory);
    return d->memory ? SP_OK : sp_fail_memory(err, d->room * sizeof *d->memory);
}

void sp_spectrum_end(spectrum_drawing *d) {
    if (d)
        sp_free(d->memory);
    sp_free(d);
}

double *sp_spectrum_take(spectrum_drawing *d, int64_t n) {
    double *a = d->memory + d->used;
    d->used += (size_t)n;
    return a;
}

const char *sp_spectrum_name(spectrum_drawing *d, int j) {
    if (d->tables < 2 && !d->table[j].named)
        return NULL;
    sp_settings_label(d->tables, d->table, j, LABEL_MOST, d->label[j]);
    return d->label[j][0] ? d->label[j] : NULL;
}

sp_status sp_spectrum_column(const sp_table *t, const char *name, int *out, sp_error *err) {
    return sp_column_find(t, name, "must be from `sonopack spectrum' without --lines and --profile", out, err);
}

sp_status sp_spectrum_check(const spectrum_drawing *d, const char *columns, sp_error *err) {
    for (int k = 0; k < d->curves; k++)
        for (int64_t l = 0; l < d->curve[k].n; l++)
            if (isfinite(d->curve[k].x[l]) && isfinite(d->curve[k].y[l]))
                return SP_OK;
    return sp_fail(err, SP_EREFUSED, "nothing to draw: no row has %s", columns);
}
