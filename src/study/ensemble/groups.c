/* Sorts samples, and finds groups that may be averaged. */
#include "ensemble/groups.h"

#include "base/base.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#define ORDER(a, b) ((a) < (b) ? -1 : (a) > (b))

/* Compares samples by these members, one after the other: x fraction, p pressure, where that does not follow from the
 * fraction, t stage, g grains, d dimension, w width, f friction, k kind, s seed, n name. */
static int compare(const sp_sample *a, const sp_sample *b, const char *members) {
    int order = 0;
    for (; *members && order == 0; members++)
        switch (*members) {
        case 'x': order = ORDER(a->fraction, b->fraction); break;
        case 'p': order = a->fraction > 0 ? 0 : ORDER(a->pressure, b->pressure); break;
        case 't': order = ORDER(a->stage, b->stage); break;
        case 'g': order = ORDER(a->grains, b->grains); break;
        case 'd': order = ORDER(a->dim, b->dim); break;
        case 'w': order = ORDER(a->width, b->width); break;
        case 'f': order = ORDER(a->friction, b->friction); break;
        case 'k': order = ORDER(a->kind, b->kind); break;
        case 's': order = ORDER(a->seed, b->seed); break;
        default: order = strcmp(a->name, b->name); break;
        }
    return order;
}

static const char *const material = "xptfdkw"; /* of a row for each height, in the order of the table */
static const char *const same_packing = "xptgdwfks";

static int in_table(const void *left, const void *right) {
    return compare(*(const sp_sample *const *)left, *(const sp_sample *const *)right, "xptgdwfksn");
}

static int over_heights(const void *left, const void *right) {
    return compare(*(const sp_sample *const *)left, *(const sp_sample *const *)right, "xptfdkwgsn");
}

static int by_name(const void *left, const void *right) {
    const sp_sample *a = *(const sp_sample *const *)left, *b = *(const sp_sample *const *)right;
    int order = strcmp(a->name, b->name);
    order = order ? order : ORDER(a->failed, b->failed);
    return order ? order : ORDER(b->have, a->have);
}

sp_status sp_samples_sorted(int64_t n, const sp_sample *samples, const sp_sample ***sorted, int64_t *count,
                            sp_error *err) {
    const sp_sample **s = sp_alloc((size_t)n, sizeof(const sp_sample *));
    if (!s)
        return sp_fail_memory(err, (size_t)n * sizeof *s);
    for (int64_t k = 0; k < n; k++)
        s[k] = &samples[k];
    qsort(s, (size_t)n, sizeof *s, by_name);
    int64_t kept = 0;
    for (int64_t k = 0; k < n; k++)
        if (kept == 0 || s[k]->name[0] == '\0' || strcmp(s[k]->name, s[kept - 1]->name) != 0)
            s[kept++] = s[k];
    qsort(s, (size_t)kept, sizeof *s, in_table);
    *sorted = s;
    *count = kept;
    return SP_OK;
}

/* A failed sample has nothing to average. */
static bool is_known(const sp_sample *s) { return s->material != 0 && !s->failed; }

/* Refuses samples of different materials. Pressure, fraction, stage, size, friction and width are not part of the
 * material. */
static sp_status one_material(int64_t n, const sp_sample *const *s, sp_error *err) {
    const sp_sample *first = NULL;
    for (int64_t k = 0; k < n; k++) {
        if (!is_known(s[k]))
            continue;
        if (first && s[k]->material != first->material)
            return sp_fail(err, SP_EREFUSED,
                           "samples %s and %s differ in keys of packing or network, or in signal.source, that have no "
                           "rows here (sizes, protocol, history, poisson, ...) and are not averaged: choose those of "
                           "one scene",
                           first->name, s[k]->name);
        first = s[k];
    }
    return SP_OK;
}

static sp_status same_seed(const sp_sample *a, const sp_sample *b, sp_error *err) {
    return sp_fail(err, SP_EREFUSED,
                   "samples %s and %s have the same %s %g, grains %d and seed %llu but come from different scenes: "
                   "choose those of one scene",
                   a->name, b->name, b->fraction > 0 ? "fraction" : "pressure",
                   b->fraction > 0 ? b->fraction : b->pressure, b->grains, (unsigned long long)b->seed);
}

sp_status sp_samples_alike(int64_t n, const sp_sample *const *s, sp_error *err) {
    for (int64_t k = 1; k < n; k++) {
        const sp_sample *a = s[0], *b = s[k];
        const char *what = ORDER(a->dim, b->dim)             ? "dimension"
                           : ORDER(a->kind, b->kind)         ? "kind"
                           : ORDER(a->width, b->width)       ? "width"
                           : ORDER(a->friction, b->friction) ? "friction"
                                                             : NULL;
        if (what)
            return sp_fail(err, SP_EREFUSED,
                           "samples %s and %s differ in packing.%s (width %g and %g, friction %g and %g) and are not "
                           "averaged: choose those of one width, one friction, or one scene",
                           a->name, b->name, what, a->width, b->width, a->friction, b->friction);
        if (compare(s[k - 1], b, same_packing) == 0)
            return same_seed(s[k - 1], b, err);
    }
    return one_material(n, s, err);
}

sp_status sp_samples_by_material(int64_t n, const sp_sample **s, sp_error *err) {
    qsort(s, (size_t)n, sizeof *s, over_heights);
    for (int64_t k = 1; k < n; k++)
        if (compare(s[k - 1], s[k], same_packing) == 0)
            return same_seed(s[k - 1], s[k], err);
    return one_material(n, s, err);
}

/* End of the samples that equal s[begin] in these members. */
static int64_t end_of(int64_t n, const sp_sample *const *s, int64_t begin, const char *members) {
    int64_t k = begin + 1;
    while (k < n && compare(s[k], s[begin], members) == 0)
        k++;
    return k;
}

int64_t sp_pressure_end(int64_t n, const sp_sample *const *s, int64_t begin) { return end_of(n, s, begin, "xpt"); }

int64_t sp_size_end(int64_t n, const sp_sample *const *s, int64_t begin) { return end_of(n, s, begin, "xptg"); }

int64_t sp_material_end(int64_t n, const sp_sample *const *s, int64_t begin) { return end_of(n, s, begin, material); }

int64_t sp_height_end(int64_t n, const sp_sample *const *s, int64_t begin) { return end_of(n, s, begin, "xptfdkwg"); }

int64_t sp_samples_failed(int64_t n, const sp_sample *const *s) {
    int64_t failed = 0;
    for (int64_t k = 0; k < n; k++)
        failed += s[k]->failed;
    return failed;
}

int64_t sp_samples_lacking(int64_t n, const sp_sample *const *s, unsigned part) {
    int64_t lacking = 0;
    for (int64_t k = 0; k < n; k++)
        lacking += !s[k]->failed && (s[k]->lacks & ~s[k]->have & part) != 0;
    return lacking;
}

sp_status sp_columns_add(sp_table *t, int count, const sp_column *column, sp_error *err) {
    sp_status status = SP_OK;
    for (int k = 0; k < count && status == SP_OK; k++)
        status = sp_table_add_column(t, column[k].name, column[k].unit, column[k].kind, err);
    return status;
}

/* ---- fractions and stages -----------------------------------------------------------------------------------------
 */

sp_status sp_state_columns(int64_t n, const sp_sample *const *s, bool means, sp_table *t, sp_error *err) {
    static const sp_column column[] = {{"fraction", "", SP_COLUMN_NUMBER},
                                       {"stage", "", SP_COLUMN_INTEGER},
                                       {"strain", "", SP_COLUMN_NUMBER},
                                       {"p_err", "E*", SP_COLUMN_NUMBER}};
    bool fraction = false, stage = false;
    for (int64_t k = 0; k < n; k++) {
        fraction = fraction || s[k]->fraction > 0;
        stage = stage || s[k]->stage > 0;
    }
    sp_status status = fraction ? sp_columns_add(t, 1, column, err) : SP_OK;
    if (status == SP_OK && stage)
        status = sp_columns_add(t, 2, column + 1, err);
    if (status != SP_OK || !means || !(fraction || stage))
        return status;
    status = sp_columns_add(t, 1, column + 3, err);
    return status == SP_OK
               ? sp_table_add_comment(t, err, "p: mean over the packings, p_err its standard error%s",
                                      stage ? "; strain: of the largest component of packing.path.strain" : "")
               : status;
}

double sp_state_pressure(int64_t n, const sp_sample *const *s, double *error) {
    double sum = 0, squares = 0;
    int64_t count = 0;
    for (int64_t k = 0; k < n; k++)
        if (s[k]->mean_stress > 0) {
            sum += s[k]->mean_stress;
            count++;
        }
    const double mean = sum / (double)count;
    for (int64_t k = 0; k < n; k++)
        if (s[k]->mean_stress > 0)
            squares += (s[k]->mean_stress - mean) * (s[k]->mean_stress - mean);
    *error = count > 1 ? sqrt(squares / (double)(count - 1) / (double)count) : NAN;
    return s[0]->fraction > 0 || s[0]->stage > 0 ? mean : s[0]->pressure;
}

int sp_state_put(int64_t n, const sp_sample *const *s, const sp_table *t, double *row) {
    int used = 0;
    double error;
    sp_state_pressure(n, s, &error);
    if (sp_table_find_column(t, "fraction") >= 0)
        row[used++] = s[0]->fraction;
    if (sp_table_find_column(t, "stage") >= 0) {
        row[used++] = s[0]->stage;
        row[used++] = s[0]->strain;
    }
    if (sp_table_find_column(t, "p_err") >= 0)
        row[used++] = error;
    return used;
}
