/* Harmonics of loud bursts. */
#include "base/base.h"
#include "cli/amplitude.h"

#include <math.h>

#define TIME  "d/sqrt(E* / rho)"
#define RATE  "sqrt(E* / rho)/d"
#define SPEED "sqrt(E* / rho)"

enum { PLANES = 10 };

sp_status amplitude_burst_columns(bool planes, sp_table *t, sp_error *err) {
    cli_writer w = {.table = t, .err = err};
    cli_columns(&w, SP_COLUMN_TEXT, "file", "", NULL);
    cli_columns(&w, SP_COLUMN_NUMBER, "p", "E*", "amplitude", "", "omega", RATE, NULL);
    if (planes)
        cli_columns(&w, SP_COLUMN_NUMBER, "y", "d", "F1", "", "F1_err", "", "F2", "", "F2_err", "", "F3", "", "F3_err",
                    "", "F0", "", "F0_err", "", "ratio", "", "ratio_err", "", NULL);
    else
        cli_columns(&w, SP_COLUMN_NUMBER, "k", "1/d", "k_err", "1/d", "speed", SPEED, "speed_err", SPEED, "slope",
                    "1/d", "slope_err", "1/d", "beta", "", "beta_err", "", "beta_delta", "", "beta_delta_err", "",
                    "beta_field", "", "balance", "", "step", TIME, NULL);
    return w.status;
}

static sp_status add_plane(const cli_file *file, const sp_amplitude_burst *b, const sp_amplitude_harmonics *h,
                           sp_table *t, sp_error *err) {
    return sp_table_add_row(t, err, file->path, file->packing.pressure, b->amplitude, b->omega, h->height,
                            h->first.value, h->first.error, h->second.value, h->second.error, h->third.value,
                            h->third.error, h->mean.value, h->mean.error, h->ratio.value, h->ratio.error);
}

/* Mean overlap of the contacts that carry a force. */
static double mean_overlap(const sp_packing *p) {
    double sum = 0;
    int32_t n = 0;
    for (int32_t k = 0; k < p->n_contacts; k++)
        if (p->contacts[k].fn > 0) {
            sum += p->contacts[k].overlap;
            n++;
        }
    return sum / n;
}

/* beta of M ~ p^(1/3): d ln M/d(strain) = M/(3 p), with M = density c^2. */
static double field_beta(const sp_packing *p, double speed) {
    double mass = 0;
    for (int32_t i = 0; i < p->n; i++)
        mass += M_PI * 4 / 3 * p->r[i] * p->r[i] * p->r[i];
    return mass / sp_packing_volume(p) * speed * speed / (3 * p->pressure);
}

static sp_status add_summary(const cli_file *file, const sp_amplitude_burst *b, const sp_amplitude_second *s,
                             sp_table *t, sp_error *err) {
    const double delta = mean_overlap(&file->packing);
    return sp_table_add_row(t, err, file->path, file->packing.pressure, b->amplitude, b->omega, s->k.value, s->k.error,
                            s->speed.value, s->speed.error, s->slope.value, s->slope.error, s->beta.value,
                            s->beta.error, delta * s->beta.value, delta * s->beta.error,
                            field_beta(&file->packing, s->speed.value), s->energy.defect, s->step);
}

sp_status amplitude_burst_rows(const cli_file *file, const sp_amplitude_options *o, const sp_amplitude_burst *burst,
                               int32_t planes, sp_table *t, sp_error *err) {
    const int32_t n = planes > 0 ? planes : PLANES;
    sp_amplitude_harmonics *plane = sp_alloc((size_t)n, sizeof *plane);
    sp_amplitude_second second;
    if (!plane)
        return sp_fail_memory(err, (size_t)n * sizeof *plane);
    sp_status status = sp_amplitude_bursts(&file->packing, o, burst, n, NULL, plane, planes > 0 ? NULL : &second, err);
    for (int32_t b = 0; b < planes && status == SP_OK; b++)
        status = add_plane(file, burst, &plane[b], t, err);
    if (status == SP_OK && planes == 0)
        status = add_summary(file, burst, &second, t, err);
    sp_free(plane);
    return status;
}
