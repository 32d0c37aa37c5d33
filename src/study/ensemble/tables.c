/* Makes the tables of a study: means over samples, and one row for each sample. */
#include "base/base.h"
#include "ensemble/groups.h"
#include "ensemble/speed.h"
#include "numeric/interval.h"
#include "numeric/statistics.h"
#include "table/quantity.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

/* An averaged quantity: its offset in sp_sample, and that of the quantity it is divided by. */
typedef struct quantity {
    char name[24];
    const char *unit;
    size_t offset, over; /* over = 0: not divided */
} quantity;

enum { QUANTITIES_MAX = 16 };

/* Columns before those of the quantities in tables of means, and the columns of each quantity. */
enum { FIRST = 4 };
enum { MEAN = 0, SD, ERROR, LOW, HIGH, COLUMNS };

/* The quantities that tables have, and those in three dimensions alone. */
static const char statics_symbols[] = "Phi2 Phi3 Phi3s zs f0 N_over_p Z2 Z3 F2 F2S s1_over_s2 s12_over_s2 mobilised";
static const char statics_3d_symbols[] = "s32_over_s2";
static const char moduli_symbols[] = "C11 C12 C22 C33 c_l c_t", moduli_3d_symbols[] = "C13 C23 C44 C55 C66",
                  isotropic_symbols[] = "K G";

/* Fills q with the named ones of a result at this offset in a sample. Returns how many they are. */
static int named(const sp_quantity *all, size_t at, const char *symbols, quantity *q) {
    const sp_quantity *of;
    int count = 0;
    while ((of = sp_quantity_next(all, &symbols))) {
        q[count] = (quantity){.unit = of->unit, .offset = at + of->offset};
        snprintf(q[count++].name, sizeof q->name, "%s", of->symbol);
    }
    return count;
}

static int named_statics(const char *symbols, quantity *q) {
    return named(sp_statics_quantities, offsetof(sp_sample, statics), symbols, q);
}

static int named_moduli(const char *symbols, quantity *q) {
    return named(sp_moduli_quantities, offsetof(sp_sample, moduli), symbols, q);
}

static double value_of(const sp_sample *s, const quantity *q) {
    double value, over = 1;
    memcpy(&value, (const char *)s + q->offset, sizeof value);
    if (q->over > 0) {
        memcpy(&over, (const char *)s + q->over, sizeof over);
        if (!(s->have & SP_WANT_MODULI))
            return NAN;
    }
    return value / over;
}

/* A table of means that is being made. */
typedef struct averaged {
    unsigned part;
    int quantities;
    quantity q[QUANTITIES_MAX];
    sp_interval_options interval;
    double *x; /* values of the samples, quantity by quantity */
} averaged;

static sp_status means_columns(int64_t n, const sp_sample *const *s, const averaged *a, sp_table *t, sp_error *err) {
    static const sp_column first[FIRST] = {{"p", "E*", SP_COLUMN_NUMBER},
                                           {"grains", "", SP_COLUMN_INTEGER},
                                           {"samples", "", SP_COLUMN_INTEGER},
                                           {"left_out", "", SP_COLUMN_INTEGER}};
    sp_status status = sp_columns_add(t, FIRST, first, err);
    if (status == SP_OK)
        status = sp_state_columns(n, s, true, t, err);
    static const char *const end[COLUMNS] = {"", "_sd", "_err", "_low", "_high"};
    for (int k = 0; k < COLUMNS * a->quantities && status == SP_OK; k++) {
        const quantity *of = &a->q[k / COLUMNS];
        char name[40];
        snprintf(name, sizeof name, "%.23s%s", of->name, end[k % COLUMNS]);
        status = sp_table_add_column(t, name, of->unit, SP_COLUMN_NUMBER, err);
    }
    return status;
}

/* Explains means that are NAN. A quantity that one sample lacks has no mean: without that sample, the mean would be
 * biased by the choice of samples. */
static sp_status explain_no_means(const sp_sample *row, int64_t samples, const averaged *a, sp_table *t,
                                  sp_error *err) {
    char list[400] = "";
    size_t used = 0;
    int64_t most = 0;
    for (int k = 0; k < a->quantities; k++) {
        int64_t none = 0;
        if (a->q[k].offset == offsetof(sp_sample, statics.mobilised) && !(row->friction > 0))
            continue; /* without friction, none can be mobilised */
        for (int64_t i = 0; i < samples; i++)
            none += !isfinite(a->x[k * samples + i]);
        most = none > most ? none : most;
        if (none > 0 && used < sizeof list)
            used += (size_t)snprintf(list + used, sizeof list - used, "%s%s", used > 0 ? ", " : "", a->q[k].name);
    }
    if (most == 0)
        return SP_OK;
    return sp_table_add_comment(t, err, "p = %.6g, %d grains: up to %lld of %lld samples have no %s%s", row->pressure,
                                row->grains, (long long)most, (long long)samples, list,
                                a->part == SP_WANT_STATICS  ? " (a box below six diameters has no bulk)"
                                : strcmp(list, "K, G") == 0 ? " (of an older version: the study adds them)"
                                : !(row->friction > 0)      ? " (walls do not grip grains without friction)"
                                                            : "");
}

/* Samples that should have the part and do not. */
static int64_t count_left_out(int64_t n, const sp_sample *const *s, unsigned part) {
    int64_t count = 0;
    for (int64_t k = 0; k < n; k++)
        count += !(s[k]->have & part) && (s[k]->failed || s[k]->lacks & part);
    return count;
}

/* Adds a row: the mean of each quantity over the samples of one pressure and size that have the part, and how many
 * are left out. */
static sp_status add_means(int64_t n, const sp_sample *const *s, const averaged *a, sp_table *t, sp_error *err) {
    const int64_t left_out = count_left_out(n, s, a->part);
    double row[FIRST + SP_STATE_COLUMNS + COLUMNS * QUANTITIES_MAX], error;
    const double p = sp_state_pressure(n, s, &error);
    double *numbers = row + FIRST + sp_state_put(n, s, t, row + FIRST);
    const double *x[QUANTITIES_MAX];
    sp_interval interval[QUANTITIES_MAX];
    int64_t samples = 0;
    for (int64_t i = 0; i < n; i++)
        samples += (s[i]->have & a->part) != 0;
    if (samples == 0 && left_out == 0)
        return SP_OK; /* the part was not asked for */
    memcpy(row, (const double[FIRST]){p, s[0]->grains, (double)samples, (double)left_out}, FIRST * sizeof *row);
    for (int k = 0; k < a->quantities; k++) {
        double *to = a->x + k * samples;
        x[k] = to;
        for (int64_t i = 0; i < n; i++)
            if (s[i]->have & a->part)
                *to++ = value_of(s[i], &a->q[k]);
    }
    sp_status status = sp_intervals_of_means(samples, a->quantities, x, &a->interval, interval, err);
    for (int k = 0; k < a->quantities && status == SP_OK; k++) {
        double *of = numbers + COLUMNS * k;
        of[MEAN] = sp_mean(samples, x[k]);
        of[SD] = sp_sd(samples, x[k]);
        of[ERROR] = sp_standard_error(samples, x[k]);
        of[LOW] = interval[k].low;
        of[HIGH] = interval[k].high;
    }
    if (status == SP_OK)
        status = explain_no_means(s[0], samples, a, t, err);
    return status == SP_OK ? sp_table_add_numbers(t, row, err) : status;
}

/* Ratios to the moduli of global strain (Tables IV and V of Somfai et al. 2005), then the apparent moduli. */
static int probe_quantities(int dim, quantity *q) {
    static const char *const probe[SP_PROBES] = {"sine1", "sine2", "lines1", "lines3"};
    static const char *const modulus[2][2] = {{"C22", "C33"}, {"C33", "C55"}};
    const bool space = dim == 3;
    const size_t global[2] = {space ? offsetof(sp_sample, moduli.c33) : offsetof(sp_sample, moduli.c22),
                              space ? offsetof(sp_sample, moduli.c55) : offsetof(sp_sample, moduli.c33)};
    int count = 0;
    for (int apparent = 0; apparent < 2; apparent++)
        for (int k = 0; k < SP_PROBES; k++)
            for (int shear = 0; shear < 2; shear++) {
                quantity *one = &q[count++];
                *one = (quantity){.unit = apparent ? "E*" : "", .over = apparent ? 0 : global[shear]};
                snprintf(one->name, sizeof one->name, "%s_%s%s", modulus[space][shear], probe[k],
                         apparent ? "" : "_ratio");
                one->offset = offsetof(sp_sample, probe) + (size_t)k * sizeof(sp_probe_moduli) +
                              (shear ? offsetof(sp_probe_moduli, shear) : offsetof(sp_probe_moduli, along));
            }
    return count;
}

/* The quantities of a part. All samples of a table have the same dimension. */
static int quantities_of(unsigned part, int dim, quantity *q) {
    if (part == SP_WANT_PROBES)
        return probe_quantities(dim, q);
    if (part == SP_WANT_STATICS) {
        const int count = named_statics(statics_symbols, q);
        return count + (dim == 3 ? named_statics(statics_3d_symbols, q + count) : 0);
    }
    int count = named_moduli(moduli_symbols, q);
    count += dim == 3 ? named_moduli(moduli_3d_symbols, q + count) : 0;
    return count + named_moduli(isotropic_symbols, q + count);
}

/* Counts samples in which a single loose grain takes most of the energy of a body force. Their modulus is that of its
 * contacts. */
static sp_status explain_probes(int64_t n, const sp_sample *const *s, sp_table *t, sp_error *err) {
    int64_t loose = 0;
    for (int64_t k = 0; k < n; k++)
        loose += s[k]->have & SP_WANT_PROBES &&
                 (s[k]->probe[SP_SINE_1].concentrated > 0.5 || s[k]->probe[SP_SINE_2].concentrated > 0.5);
    sp_status status = sp_table_add_comment(t, err, "_ratio: over the moduli of global strain, sample by sample");
    if (status == SP_OK && loose > 0)
        status = sp_table_add_comment(t, err,
                                      "loose = %lld samples in which one grain takes more than half of the energy of a "
                                      "sine; they are in the means",
                                      (long long)loose);
    return status;
}

static sp_status fill_means(int64_t n, const sp_sample *const *s, unsigned part, double level, sp_table *t,
                            sp_error *err) {
    averaged a = {.part = part, .interval = sp_interval_options_default()};
    a.interval.level = level;
    a.quantities = quantities_of(part, n > 0 ? s[0]->dim : 2, a.q);
    a.x = sp_alloc((size_t)n, (size_t)a.quantities * sizeof *a.x);
    if (!a.x)
        return sp_fail_memory(err, (size_t)n * (size_t)a.quantities * sizeof *a.x);
    sp_status status = means_columns(n, s, &a, t, err);
    for (int64_t begin = 0, end; begin < n && status == SP_OK; begin = end) {
        end = sp_size_end(n, s, begin);
        status = add_means(end - begin, s + begin, &a, t, err);
    }
    if (status == SP_OK)
        status = sp_table_add_comment(t, err,
                                      "means over the samples, one standard deviation of the samples (_sd), the "
                                      "standard error of the mean (_err)");
    if (status == SP_OK)
        status = sp_interval_comment(t, level, "the mean", err);
    if (status == SP_OK && part == SP_WANT_PROBES)
        status = explain_probes(n, s, t, err);
    sp_free(a.x);
    return status;
}

/* Statics, then moduli. */
static int ensemble_quantities(quantity q[2 * QUANTITIES_MAX], int *statics) {
    *statics = named_statics(statics_symbols, q);
    const int count = *statics + named_moduli(moduli_symbols, q + *statics);
    return count + named_moduli(isotropic_symbols, q + count);
}

static const sp_column ensemble_first[] = {{"p", "E*", SP_COLUMN_NUMBER},
                                           {"grains", "", SP_COLUMN_INTEGER},
                                           {"seed", "", SP_COLUMN_INTEGER},
                                           {"height", "d", SP_COLUMN_NUMBER},
                                           {"t10", "d/sqrt(E* / rho)", SP_COLUMN_NUMBER},
                                           {"t_peak", "d/sqrt(E* / rho)", SP_COLUMN_NUMBER},
                                           {"t_zero", "d/sqrt(E* / rho)", SP_COLUMN_NUMBER},
                                           {"amplitude", "E* d^2", SP_COLUMN_NUMBER},
                                           {"width", "d/sqrt(E* / rho)", SP_COLUMN_NUMBER}},
                       ensemble_last[] = {{"dimension", "", SP_COLUMN_INTEGER}, {"Lx", "d", SP_COLUMN_NUMBER},
                                          {"friction", "", SP_COLUMN_NUMBER},   {"failed", "", SP_COLUMN_INTEGER},
                                          {"reason", "", SP_COLUMN_TEXT},       {"name", "", SP_COLUMN_TEXT}};
enum { ENSEMBLE_FIRST = sizeof ensemble_first / sizeof *ensemble_first };
enum { ENSEMBLE_LAST = sizeof ensemble_last / sizeof *ensemble_last };

static sp_status ensemble_columns(int64_t n, const sp_sample *const *s, sp_table *t, sp_error *err) {
    quantity q[2 * QUANTITIES_MAX];
    int statics;
    const int count = ensemble_quantities(q, &statics);
    sp_status status = sp_columns_add(t, ENSEMBLE_FIRST, ensemble_first, err);
    for (int k = 0; k < count && status == SP_OK; k++)
        status = sp_table_add_column(t, q[k].name, q[k].unit, SP_COLUMN_NUMBER, err);
    if (status == SP_OK)
        status = sp_state_columns(n, s, false, t, err);
    return status == SP_OK ? sp_columns_add(t, ENSEMBLE_LAST, ensemble_last, err) : status;
}

/* Adds a row with all results of a sample; NAN for missing parts. */
static sp_status add_sample(const sp_sample *const *one, sp_table *t, sp_error *err) {
    const sp_sample *s = *one;
    const sp_front none = {NAN, NAN, NAN, NAN, NAN, 0};
    double state[SP_STATE_COLUMNS];
    const sp_front f = s->have & SP_WANT_CTOF ? s->front : none;
    sp_entry row[ENSEMBLE_FIRST + 2 * QUANTITIES_MAX + ENSEMBLE_LAST + SP_STATE_COLUMNS] = {
        {.number = sp_state_pressure(1, one, state)},
        {.integer = s->grains},
        {.integer = (int64_t)s->seed},
        {.number = s->height},
        {.number = f.t10},
        {.number = f.t_peak},
        {.number = f.t_zero},
        {.number = f.amplitude},
        {.number = f.width}};
    quantity q[2 * QUANTITIES_MAX];
    int statics, at = ENSEMBLE_FIRST;
    const int count = ensemble_quantities(q, &statics);
    for (int k = 0; k < count; k++)
        row[at++].number = s->have & (k < statics ? SP_WANT_STATICS : SP_WANT_MODULI) ? value_of(s, &q[k]) : NAN;
    for (int k = 0, last = sp_state_put(1, one, t, state); k < last; k++, at++)
        if (t->column[at].kind == SP_COLUMN_INTEGER)
            row[at].integer = (int64_t)state[k];
        else
            row[at].number = state[k];
    row[at++].integer = s->dim;
    row[at++].number = s->width;
    row[at++].number = s->friction;
    row[at++].integer = s->failed;
    row[at++].text = (char *)(s->reason[0] ? s->reason : "-"); /* of a failed sample or part */
    row[at++].text = (char *)s->name;
    return sp_table_add_cells(t, row, err);
}

static sp_status fill_ensemble(int64_t n, const sp_sample *const *s, sp_table *t, sp_error *err) {
    sp_status status = ensemble_columns(n, s, t, err);
    for (int64_t k = 0; k < n && status == SP_OK; k++)
        status = add_sample(&s[k], t, err);
    return status;
}

sp_table_options sp_table_options_default(void) {
    return (sp_table_options){.level = sp_interval_options_default().level};
}

static sp_status explain_missing(int64_t n, const sp_sample *const *s, unsigned part, sp_table *t, sp_error *err) {
    const int64_t lacking = sp_samples_lacking(n, s, part);
    sp_status status = sp_table_add_comment(t, err, "failed = %lld", (long long)sp_samples_failed(n, s));
    if (status == SP_OK && lacking > 0)
        status = sp_table_add_comment(t, err,
                                      "lacking = %lld samples with a packing, but without what they should have here: "
                                      "reasons in the table ensemble",
                                      (long long)lacking);
    return status;
}

sp_status sp_study_table(const char *table, int64_t n, const sp_sample *samples, const sp_table_options *opt,
                         sp_table *out, sp_error *err) {
    static const char *const names[] = {"ctof", "scaling", "planes", "statics", "moduli", "probes", "ensemble"};
    enum { CTOF, SCALING, PLANES, STATICS, MODULI, PROBED, ENSEMBLE, TABLES };
    static const unsigned parts[] = {SP_WANT_CTOF,   SP_WANT_CTOF, SP_WANT_PLANES, SP_WANT_STATICS, SP_WANT_MODULI,
                                     SP_WANT_PROBES, ~0u};
    int which = 0;
    while (which < TABLES && strcmp(table, names[which]) != 0)
        which++;
    if (which == TABLES)
        return sp_fail(err, SP_EINVAL, "table \"%s\": ctof, scaling, planes, statics, moduli, probes or ensemble",
                       table);
    const double level = opt ? opt->level : sp_table_options_default().level;
    sp_table t = sp_table_none();
    const sp_sample **sorted = NULL;
    int64_t count = 0;
    sp_status status = sp_level_check(level, err);
    if (status == SP_OK)
        status = sp_samples_sorted(n, samples, &sorted, &count, err);
    if (status == SP_OK && (which == SCALING || which == PLANES))
        status = sp_samples_by_material(count, sorted, err);
    else if (status == SP_OK && which != ENSEMBLE)
        status = sp_samples_alike(count, sorted, err);
    if (status != SP_OK)
        goto out;
    switch (which) {
    case CTOF: status = sp_ctof_fill(count, sorted, level, &t, err); break;
    case SCALING:
    case PLANES: status = sp_scaling_fill(count, sorted, which == PLANES, level, &t, err); break;
    case STATICS: status = fill_means(count, sorted, SP_WANT_STATICS, level, &t, err); break;
    case MODULI: status = fill_means(count, sorted, SP_WANT_MODULI, level, &t, err); break;
    case PROBED: status = fill_means(count, sorted, SP_WANT_PROBES, level, &t, err); break;
    default: status = fill_ensemble(count, sorted, &t, err); break;
    }
    if (status == SP_OK && count > 0 && t.rows == 0)
        status = sp_table_add_comment(&t, err, "no row: none of %lld samples has %s", (long long)count,
                                      which == PLANES ? "a front at a plane inside of it" : "such results");
    if (status == SP_OK)
        status = explain_missing(count, sorted, parts[which], &t, err);
    if (status != SP_OK)
        goto out;
    *out = t;
    t = sp_table_none();
out:
    sp_table_free(&t);
    sp_free(sorted);
    return status;
}
