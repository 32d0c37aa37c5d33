/* Draws peak frequencies of waves against their wave numbers. */
#include "figure/spectrum.h"

#include "base/base.h"

#include <math.h>
#include <string.h>

enum { GROUPS = SPECTRUM_GROUPS };

static const char *const polarizations[GROUPS] = {"longitudinal", "transverse", "rotational"};

typedef struct columns {
    int polarization, k, peak, width; /* width < 0: not in the table */
} columns;

static sp_status find_columns(const sp_table *t, columns *c, sp_error *err) {
    c->polarization = sp_table_find_column(t, "polarization");
    if (c->polarization < 0 || t->column[c->polarization].kind != SP_COLUMN_TEXT)
        return sp_fail(
            err, SP_EINVAL,
            "the table has no words in a column polarization; must be one of `sonopack spectrum dispersion'");
    sp_status status = sp_spectrum_column(t, "k", &c->k, err);
    if (status == SP_OK)
        status = sp_spectrum_column(t, "peak", &c->peak, err);
    c->width = sp_table_find_column(t, "half_width");
    return status;
}

/* The legend names the polarizations; the marks of the second table are open. */
static void add_waves(spectrum_drawing *d, int j, int group, const columns *c) {
    static const sp_mark marks[GROUPS] = {SP_MARK_CIRCLE, SP_MARK_SQUARE, SP_MARK_TRIANGLE};
    const sp_table *t = d->table[j].table;
    double *x = sp_spectrum_take(d, t->rows), *y = sp_spectrum_take(d, t->rows);
    double *low = sp_spectrum_take(d, t->rows), *high = sp_spectrum_take(d, t->rows);
    int64_t n = 0;
    for (int64_t r = 0; r < t->rows; r++) {
        const char *word = t->cells[r * t->columns + c->polarization].text;
        if (!word || strcmp(word, polarizations[group]) != 0)
            continue;
        const double width = c->width < 0 ? NAN : sp_table_number(t, r, c->width);
        x[n] = sp_table_number(t, r, c->k);
        y[n] = sp_table_number(t, r, c->peak);
        low[n] = isnan(width) ? NAN : fmax(y[n] - width, 0);
        high[n] = y[n] + width;
        n++;
    }
    if (n == 0)
        return;
    d->curve[d->curves++] = (sp_curve){.label = j == 0 ? polarizations[group] : NULL,
                                       .n = n,
                                       .x = x,
                                       .y = y,
                                       .bar_low = low,
                                       .bar_high = high,
                                       .ink = group + 1,
                                       .dash = SP_DASH_NONE,
                                       .mark = marks[group],
                                       .open = j > 0};
}

/* Two tables: which has filled marks, and which open ones. */
static void add_keys(spectrum_drawing *d) {
    for (int j = 0; j < d->tables; j++) {
        const char *name = sp_spectrum_name(d, j);
        if (name)
            d->curve[d->curves++] =
                (sp_curve){.label = name, .dash = SP_DASH_NONE, .mark = SP_MARK_CIRCLE, .open = j > 0};
    }
}

static sp_status draw(spectrum_drawing *d, const char *path, sp_error *err) {
    char x[UNIT_MARKUP + 16], y[UNIT_MARKUP + 16];
    const char *k, *omega;
    sp_status status = sp_unit_common(d->tables, d->table, "k", UNIT_WAVE, &k, err);
    if (status == SP_OK)
        status = sp_unit_common(d->tables, d->table, "peak", UNIT_FREQUENCY, &omega, err);
    if (status != SP_OK)
        return status;
    const sp_panel panel = {.x = {.label = sp_unit_label("|k|", k, x, sizeof x), .low = 0, .high = NAN},
                            .y = {.label = sp_unit_label("|\xcf\x89|", omega, y, sizeof y), .low = 0, .high = NAN},
                            .curves = d->curves,
                            .curve = d->curve};
    const sp_sheet sheet = {.title = "Dispersion of waves", .rows = 1, .columns = 1, .panel = &panel, .aspect = 0.78};
    return sp_plot_sheet(&sheet, path, err);
}

sp_status sp_plot_dispersion(int tables, const sp_plot_table *table, const char *path, sp_error *err) {
    spectrum_drawing *d = NULL;
    sp_status status = sp_spectrum_begin(tables, table, 4 * GROUPS, path, &d, err);
    if (status == SP_OK && tables > 2)
        status = sp_fail(err, SP_EINVAL, "%d tables of waves: a figure shows 1 or 2", tables);
    for (int j = 0; j < tables && status == SP_OK; j++) {
        columns c = {0};
        status = find_columns(table[j].table, &c, err);
        for (int g = 0; g < GROUPS && status == SP_OK; g++)
            add_waves(d, j, g, &c);
    }
    if (status == SP_OK)
        status = sp_spectrum_check(d, "a wave number and a peak", err);
    if (status == SP_OK) {
        add_keys(d);
        status = draw(d, path, err);
    }
    sp_spectrum_end(d);
    return status;
}
