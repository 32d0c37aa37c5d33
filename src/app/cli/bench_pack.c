/* Measures the run time of the compression of packings. */
#include "cli/bench.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

int bench_ascending(const void *a, const void *b) {
    const double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

double bench_median(int n, double *value) {
    qsort(value, (size_t)n, sizeof *value, bench_ascending);
    return n % 2 ? value[n / 2] : 0.5 * (value[n / 2 - 1] + value[n / 2]);
}

static sp_status one_pressure(const sp_pack_spec *spec, sp_table *t, sp_error *err) {
    double seconds[BENCH_SAMPLES], residual = 0;
    char name[64];
    sp_pack_spec s = *spec;
    for (int k = 0; k < BENCH_SAMPLES; k++, s.seed++) {
        sp_packing p;
        sp_status status = sp_packing_make(&s, NULL, NULL, &p, err);
        if (status != SP_OK)
            return status;
        seconds[k] = p.seconds;
        residual = fmax(residual, p.residual / s.pressure);
        sp_packing_free(&p);
    }
    snprintf(name, sizeof name, "pack:%d grains", s.grains);
    return sp_table_add_row(t, err, name, "piston", s.pressure, bench_median(BENCH_SAMPLES, seconds), residual, NAN);
}

sp_status bench_pack(const cli_common *common, const sp_scene *scene, sp_table *t, sp_error *err) {
    static const double pressure[] = {1e-4, 1e-5, 1e-6, 1e-7};
    sp_status status = SP_OK;
    for (size_t k = 0; k < sizeof pressure / sizeof *pressure && status == SP_OK; k++) {
        sp_pack_spec spec = scene->pack;
        spec.pressure = pressure[k];
        cli_note(common, "%d packings of %d grains at %g", BENCH_SAMPLES, spec.grains, spec.pressure);
        status = one_pressure(&spec, t, err);
    }
    return status;
}
