/* Fronts of loud pulses at planes, and the solitary waves of chains beside them. */
#include "base/base.h"
#include "cli/amplitude.h"
#include "packing/contact.h"

#include <math.h>

#define TIME  "d/sqrt(E* / rho)"
#define SPEED "sqrt(E* / rho)"

/* Speeds that a chain of equal balls has for the peak of a front; NAN for other packings. */
typedef struct expected {
    double solitary, kdv, nesterenko;
} expected;

static bool is_equal_chain(const sp_packing *p) {
    for (int32_t i = 0; i < p->n; i++)
        if (p->dim != 1 || p->r[i] != p->r[0] || p->contacts[i].fn != p->contacts[0].fn)
            return false;
    return sp_packing_hertzian(p) && p->contacts[0].j >= 0;
}

static sp_status expect(const sp_packing *p, double overpressure, expected *out, sp_error *err) {
    const double peak = pow(1 + overpressure, 2.0 / 3.0) - 1;
    sp_solitary s;
    *out = (expected){NAN, NAN, NAN};
    if (!is_equal_chain(p) || !(peak > 1e-4 && peak < 1e9))
        return SP_OK;
    const double mass = grain_mass(p->r[0]), length = 2 * p->r[0] - p->contacts[0].overlap;
    const double c = sqrt(contact_kn(p, &p->contacts[0]) / mass) * length;
    const sp_status status = sp_solitary_make(peak, &s, err);
    if (status == SP_OK)
        *out = (expected){s.speed * c, s.kdv * c, s.nesterenko * c};
    return status;
}

sp_status amplitude_plane_columns(sp_table *t, sp_error *err) {
    cli_writer w = {.table = t, .err = err};
    cli_columns(&w, SP_COLUMN_TEXT, "file", "", NULL);
    cli_columns(&w, SP_COLUMN_NUMBER, "p", "E*", "amplitude", "", "y", "d", "t10", TIME, "t10_err", TIME, "t_peak",
                TIME, "t_peak_err", TIME, "overpressure", "", "overpressure_err", "", "speed", SPEED, "speed_err",
                SPEED, "speed_peak", SPEED, "speed_peak_err", SPEED, "solitary", SPEED, "kdv", SPEED, "nesterenko",
                SPEED, NULL);
    return w.status;
}

static sp_status add_plane(const cli_file *file, double amplitude, const sp_amplitude_plane *a, sp_table *t,
                           sp_error *err) {
    expected e;
    const sp_status status = expect(&file->packing, a->overpressure.value, &e, err);
    if (status != SP_OK)
        return status;
    return sp_table_add_row(t, err, file->path, file->packing.pressure, amplitude, a->height, a->t10.value,
                            a->t10.error, a->t_peak.value, a->t_peak.error, a->overpressure.value,
                            a->overpressure.error, a->speed.value, a->speed.error, a->speed_peak.value,
                            a->speed_peak.error, e.solitary, e.kdv, e.nesterenko);
}

sp_status amplitude_plane_rows(const cli_file *file, const sp_amplitude_options *o, double amplitude, int32_t planes,
                               sp_table *t, sp_error *err) {
    double *height = sp_alloc((size_t)planes, sizeof *height);
    sp_amplitude_plane *plane = sp_alloc((size_t)planes, sizeof *plane);
    sp_status status = height && plane ? SP_OK : sp_fail_memory(err, (size_t)planes * (sizeof *height + sizeof *plane));
    for (int32_t b = 0; b < planes && status == SP_OK; b++)
        height[b] = sp_packing_height(&file->packing) * (b + 1) / (planes + 1);
    if (status == SP_OK)
        status = sp_amplitude_planes(&file->packing, o, amplitude, planes, height, plane, NULL, err);
    for (int32_t b = 0; b < planes && status == SP_OK; b++)
        status = add_plane(file, amplitude, &plane[b], t, err);
    sp_free(plane);
    sp_free(height);
    return status;
}
