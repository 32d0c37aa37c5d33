#include "base/base.h"
#include "packing/making.h"

sp_status sp_packing_make(const sp_pack_spec *given, sp_pack_watch watch, void *user, sp_packing *out, sp_error *err) {
    sp_status status = sp_pack_spec_check(given, err);
    if (status != SP_OK)
        return status;
    const sp_pack_spec spec = sp_pack_spec_resolve(given);
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
