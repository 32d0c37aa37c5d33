/* Grains and contacts as tables, and these as CSV. */
#include "base/base.h"
#include "foreign/export.h"
#include "packing/contact.h"

#include <stdarg.h>
#include <stdio.h>
#include <string.h>

static const char *const axis[3] = {"x", "y", "z"};

/* Adds columns until one fails. */
typedef struct adder {
    sp_table *table;
    sp_status status;
    sp_error *err;
} adder;

static void add_column(adder *a, const char *name, const char *unit, sp_column_kind kind) {
    if (a->status == SP_OK)
        a->status = sp_table_add_column(a->table, name, unit, kind, a->err);
}

/* A column for each axis, as in "nx ny". */
static void add_axes(adder *a, const char *stem, int axes, const char *unit) {
    char name[16];
    for (int k = 0; k < axes; k++) {
        snprintf(name, sizeof name, "%s%s", stem, axis[k]);
        add_column(a, name, unit, SP_COLUMN_NUMBER);
    }
}

static double *add_cells(double *row, int count, const double *value) {
    memcpy(row, value, (size_t)count * sizeof *row);
    return row + count;
}

static void add_row(adder *a, const double *row) {
    if (a->status == SP_OK)
        a->status = sp_table_add_numbers(a->table, row, a->err);
}

sp_status sp_export_grains_table(const sp_export_data *e, sp_table *t, sp_error *err) {
    const sp_packing *p = e->packing;
    const sp_export_units *u = e->units;
    const sp_derived *d = e->derived;
    const sp_grain_vectors *v = e->vectors;
    adder a = {.table = t, .err = err};
    add_column(&a, "id", "", SP_COLUMN_INTEGER);
    add_axes(&a, "", p->dim, u->length_name);
    add_column(&a, "radius", u->length_name, SP_COLUMN_NUMBER);
    add_column(&a, "mass", u->mass_name, SP_COLUMN_NUMBER);
    add_column(&a, "contacts", "", SP_COLUMN_INTEGER);
    add_column(&a, "rattler", "", SP_COLUMN_INTEGER);
    add_column(&a, "pressure", u->stress_name, SP_COLUMN_NUMBER);
    add_axes(&a, "u", v ? p->dim : 0, "");
    add_axes(&a, "r", v && v->rotation ? 3 : 0, "");
    for (size_t i = 0; i < (size_t)p->n && a.status == SP_OK; i++) {
        const double counts[2] = {d->contacts[i], d->rattler[i]};
        double row[20], *at = row;
        *at++ = (double)i;
        at = add_cells(at, p->dim, p->x + 3 * i);
        at = add_cells(at, 1, &p->r[i]);
        at = add_cells(at, 1, &d->mass[i]);
        at = add_cells(at, 2, counts);
        at = add_cells(at, 1, &d->pressure[i]);
        if (v)
            at = add_cells(at, p->dim, v->displacement + 3 * i);
        if (v && v->rotation)
            add_cells(at, 3, v->rotation + 3 * i);
        add_row(&a, row);
    }
    return a.status;
}

sp_status sp_export_contacts_table(const sp_export_data *e, sp_table *t, sp_error *err) {
    const sp_packing *p = e->packing;
    const sp_export_units *u = e->units;
    adder a = {.table = t, .err = err};
    add_column(&a, "i", "", SP_COLUMN_INTEGER);
    add_column(&a, "j", "", SP_COLUMN_INTEGER);
    add_axes(&a, "n", p->dim, "");
    add_column(&a, "overlap", u->length_name, SP_COLUMN_NUMBER);
    add_column(&a, "Fn", u->force_name, SP_COLUMN_NUMBER);
    add_axes(&a, "Ft", p->dim, u->force_name);
    add_column(&a, "kn", u->stiffness_name, SP_COLUMN_NUMBER);
    add_column(&a, "kt", u->stiffness_name, SP_COLUMN_NUMBER);
    add_column(&a, "carrying", "", SP_COLUMN_INTEGER);
    for (int32_t c = 0; c < p->n_contacts && a.status == SP_OK; c++) {
        const sp_contact *k = &p->contacts[c];
        double row[20], *at = row;
        *at++ = k->i;
        *at++ = k->j;
        at = add_cells(at, p->dim, k->n);
        *at++ = k->overlap;
        *at++ = k->fn;
        at = add_cells(at, p->dim, k->ft);
        *at++ = contact_kn(p, k);
        *at++ = sp_contact_kt(p, k);
        *at++ = e->derived->carrying[c];
        add_row(&a, row);
    }
    return a.status;
}

static sp_status add_csv(sp_status status, const sp_table *t, sp_text *text, sp_error *err) {
    if (status != SP_OK)
        return status;
    char *csv = sp_table_text(t, SP_CSV);
    if (!csv)
        return sp_fail_memory(err, (size_t)(t->rows * t->columns) * 24);
    sp_text_bytes(text, csv, strlen(csv));
    sp_free(csv);
    return SP_OK;
}

sp_status sp_export_csv(const sp_export_data *e, sp_text text[SP_EXPORT_FILES_MAX], sp_error *err) {
    sp_table t = sp_table_none();
    sp_status status = sp_export_grains_table(e, &t, err);
    status = add_csv(status, &t, &text[0], err);
    sp_table_free(&t);
    t = sp_table_none();
    if (status == SP_OK)
        status = sp_export_contacts_table(e, &t, err);
    status = add_csv(status, &t, &text[1], err);
    sp_table_free(&t);
    return status;
}
