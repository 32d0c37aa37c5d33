#include "base/base.h"
#include "packing/making.h"

#include <math.h>

/* Bytes that making takes at its peak: contacts are sorted in a copy; a piston's grains have lists of neighbours, of
 * which two lie side by side while they are made anew, and the gas has cells. */
static double peak_memory(const sp_pack_spec *s) {
    const double n = s->grains, a = s->diameter_min, b = s->diameter_max;
    if (s->kind != SP_PACK_PISTON)
        return n * (32 + (s->kind == SP_PACK_CHAIN ? 2 : 6) * (double)sizeof(sp_contact));
    const double area = 3.14159265358979323846 / 4 * (a * a + a * b + b * b) / 3;
    return 1500 * n + 4 * (n * area / s->gas_fraction / (b * b) + 2 * s->width / b);
}

static sp_status check_memory(const sp_pack_spec *s, sp_error *err) {
    const double need = peak_memory(s), have = sp_memory_limit();
    if (need <= have)
        return SP_OK;
    return sp_fail(err, SP_ENOMEM, "packing.grains = %d: needs %.3g GB, there are %.3g GB: %.2g grains fit", s->grains,
                   1e-9 * need, 1e-9 * have, s->grains * have / need);
}

sp_status sp_packing_make(const sp_pack_spec *given, sp_pack_watch watch, void *user, sp_packing *out, sp_error *err) {
    sp_status status = sp_pack_spec_check(given, err);
    if (status != SP_OK)
        return status;
    const sp_pack_spec spec = sp_pack_spec_resolve(given);
    status = check_memory(&spec, err);
    if (status != SP_OK)
        return status;
    const double start = sp_clock_cpu();
    sp_packing p = sp_packing_none();
    switch (spec.kind) {
    case SP_PACK_CHAIN: status = sp_chain_make(&spec, &p, err); break;
    case SP_PACK_TRIANGULAR: status = sp_triangular_make(&spec, &p, err); break;
    case SP_PACK_PISTON: status = sp_piston_make(&spec, watch, user, &p, err); break;
    }
    if (status != SP_OK)
        return status;
    p.seconds = sp_clock_cpu() - start;
    *out = p;
    return SP_OK;
}
