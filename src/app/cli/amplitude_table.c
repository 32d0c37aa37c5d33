/* The rows of loud pulses, and their means over packings. */
#include "base/base.h"
#include "cli/amplitude.h"

#include <math.h>

#define TIME "d/sqrt(E* / rho)"

static sp_amplitude_number exact(double value) { return (sp_amplitude_number){value, 0}; }

static sp_amplitude_number t10(const sp_amplitude_front *a) { return a->t10; }
static sp_amplitude_number speed(const sp_amplitude_front *a) { return a->speed; }
static sp_amplitude_number peak(const sp_amplitude_front *a) { return a->peak; }
static sp_amplitude_number width(const sp_amplitude_front *a) { return a->width; }
static sp_amplitude_number overpressure(const sp_amplitude_front *a) {
    return (sp_amplitude_number){a->overpressure, a->overpressure * a->peak.error / a->peak.value};
}
static sp_amplitude_number carrying(const sp_amplitude_front *a) { return exact(a->carrying); }
static sp_amplitude_number slid(const sp_amplitude_front *a) { return exact(a->slid); }
static sp_amplitude_number opened(const sp_amplitude_front *a) { return exact(a->opened); }
static sp_amplitude_number lost(const sp_amplitude_front *a) { return exact(a->lost); }
static sp_amplitude_number closed(const sp_amplitude_front *a) { return exact(a->closed); }
static sp_amplitude_number kinetic(const sp_amplitude_front *a) { return exact(a->energy.kinetic / a->energy.input); }
static sp_amplitude_number normal(const sp_amplitude_front *a) { return exact(a->energy.normal / a->energy.input); }
static sp_amplitude_number tangential(const sp_amplitude_front *a) {
    return exact(a->energy.tangential / a->energy.input);
}
static sp_amplitude_number rubbed(const sp_amplitude_front *a) { return exact(a->energy.slid / a->energy.input); }
static sp_amplitude_number released(const sp_amplitude_front *a) { return exact(a->energy.released / a->energy.input); }
static sp_amplitude_number balance(const sp_amplitude_front *a) { return exact(a->energy.defect); }
static sp_amplitude_number step(const sp_amplitude_front *a) { return exact(a->step); }

const amplitude_quantity amplitude_quantities[AMPLITUDE_QUANTITIES + 1] = {
    {"t10", TIME, "t10_err", t10},
    {"speed_ratio", "", "speed_ratio_err", speed},
    {"peak_ratio", "", "peak_ratio_err", peak},
    {"width_ratio", "", "width_ratio_err", width},
    {"overpressure", "", "overpressure_err", overpressure},
    {"carrying", "", "", carrying},
    {"slid", "", "", slid},
    {"opened", "", "", opened},
    {"lost", "", "", lost},
    {"closed", "", "", closed},
    {"kinetic", "", "", kinetic},
    {"normal", "", "", normal},
    {"tangential", "", "", tangential},
    {"rubbed", "", "", rubbed},
    {"released", "", "", released},
    {"balance", "", "", balance},
    {"step", TIME, "", step},
    {0}};

/* Columns of the quantities; of means all have errors but those of the method. */
static void quantity_columns(cli_writer *w) {
    for (const amplitude_quantity *q = amplitude_quantities; q->name; q++) {
        cli_columns(w, SP_COLUMN_NUMBER, q->name, q->unit, NULL);
        if (q->error[0])
            cli_columns(w, SP_COLUMN_NUMBER, q->error, q->unit, NULL);
    }
}

sp_status amplitude_add_columns(sp_table *t, sp_error *err) {
    cli_writer w = {.table = t, .err = err};
    cli_columns(&w, SP_COLUMN_TEXT, "file", "", NULL);
    cli_columns(&w, SP_COLUMN_NUMBER, "p", "E*", "amplitude", "", NULL);
    quantity_columns(&w);
    return w.status;
}

sp_status amplitude_add_row(const char *path, double pressure, const sp_amplitude_front *a, sp_table *t,
                            sp_error *err) {
    const sp_amplitude_number over = overpressure(a);
    return sp_table_add_row(t, err, path, pressure, a->amplitude, a->t10.value, a->t10.error, a->speed.value,
                            a->speed.error, a->peak.value, a->peak.error, a->width.value, a->width.error, over.value,
                            over.error, (double)a->carrying, (double)a->slid, (double)a->opened, (double)a->lost,
                            (double)a->closed, kinetic(a).value, normal(a).value, tangential(a).value, rubbed(a).value,
                            released(a).value, a->energy.defect, a->step);
}

/* ---- means ------------------------------------------------------------------------------------------------------ */

static amplitude_group *group_of(amplitude_means *m, const sp_packing *p, double amplitude) {
    for (int32_t k = 0; k < m->n; k++) {
        amplitude_group *g = &m->group[k];
        if (g->pressure == p->pressure && g->friction == p->friction && g->dim == p->dim && g->amplitude == amplitude)
            return g;
    }
    amplitude_group *grown = sp_grow(m->group, (size_t)m->n + 1, &m->capacity, sizeof *grown);
    if (!grown)
        return NULL;
    m->group = grown;
    grown[m->n] =
        (amplitude_group){.pressure = p->pressure, .friction = p->friction, .dim = p->dim, .amplitude = amplitude};
    return &grown[m->n++];
}

sp_status amplitude_add_mean(amplitude_means *m, const sp_packing *p, const sp_amplitude_front *pulse, sp_error *err) {
    amplitude_group *g = group_of(m, p, pulse->amplitude);
    if (!g)
        return sp_fail_memory(err, ((size_t)m->n + 1) * sizeof *g);
    g->n++;
    for (int q = 0; q < AMPLITUDE_QUANTITIES; q++) {
        const sp_amplitude_number v = amplitude_quantities[q].of(pulse);
        g->sum[q] += v.value;
        g->squares[q] += v.value * v.value;
        g->errors[q] += v.error;
    }
    return SP_OK;
}

/* The standard error over packings and the mean error of the computation, which they may have in common. NAN for one
 * packing: nothing is known of others. */
static double mean_error(const amplitude_group *g, int q) {
    const double n = (double)g->n, mean = g->sum[q] / n;
    return g->n > 1 ? sqrt(fmax(0, g->squares[q] / n - mean * mean) / (n - 1)) + g->errors[q] / n : NAN;
}

sp_status amplitude_mean_rows(const amplitude_means *m, sp_table *t, sp_error *err) {
    cli_writer w = {.table = t, .err = err};
    cli_columns(&w, SP_COLUMN_INTEGER, "dimension", "", NULL);
    cli_columns(&w, SP_COLUMN_NUMBER, "friction", "", "p", "E*", "amplitude", "", NULL);
    cli_columns(&w, SP_COLUMN_INTEGER, "packings", "", NULL);
    quantity_columns(&w);
    for (int32_t k = 0; k < m->n && w.status == SP_OK; k++) {
        const amplitude_group *g = &m->group[k];
        double row[5 + 2 * AMPLITUDE_QUANTITIES] = {g->dim, g->friction, g->pressure, g->amplitude, (double)g->n};
        int at = 5;
        for (int q = 0; q < AMPLITUDE_QUANTITIES; q++) {
            row[at++] = g->sum[q] / (double)g->n;
            if (amplitude_quantities[q].error[0])
                row[at++] = mean_error(g, q);
        }
        w.status = sp_table_add_numbers(t, row, err);
    }
    return w.status;
}
