/* Creates packings: completes the spec, checks the memory, and calls the generator. */
#include "base/base.h"
#include "packing/prepare.h"

#include <math.h>

/* Whether the packing is found by a simulated compression. */
static bool is_compressed(const sp_pack_spec *s) {
    return s->kind == SP_PACK_PISTON || s->kind == SP_PACK_FILE ||
           (s->kind == SP_PACK_TRIANGULAR && s->diameter_min < s->diameter_max);
}

/* Sorting needs a copy of the contacts. Compressed grains have neighbour lists, two of them during a rebuild, and the
 * gas has cells: bytes a grain, as benchmarks/fit_cost measures them. Measured: disks 1060 to 1430, spheres 1840 to
 * 3580, most with a piston, without friction and on two threads. */
static const double DISK_BYTES = 1400, SPHERE_BYTES = 3200;

/* The history of contacts takes 1.67 times the memory (measured in a gas). */
static const double HISTORY = 1.7;

double sp_pack_memory(const sp_pack_spec *s) {
    const double n = s->grains;
    if (!is_compressed(s))
        return n * (32 + (s->kind == SP_PACK_CHAIN ? 2 : 6) * (double)sizeof(sp_contact));
    const double past = s->tangential == SP_TANGENTIAL_HISTORY && s->friction > 0 ? HISTORY : 1;
    return (s->dim == 3 ? SPHERE_BYTES : DISK_BYTES) * n * past;
}

static sp_status check_memory(const sp_pack_spec *s, sp_error *err) {
    const double need = sp_pack_memory(s), have = sp_memory_limit();
    if (need <= have)
        return SP_OK;
    return sp_fail(err, SP_ENOMEM, "packing.grains = %d: needs %.3g GB, there are %.3g GB: %.2g grains fit", s->grains,
                   1e-9 * need, 1e-9 * have, s->grains * have / need);
}

sp_status sp_packing_make(const sp_pack_spec *spec, sp_pack_watch watch, void *user, sp_packing *out, sp_error *err) {
    const sp_pack_hooks hooks = {.watch = watch, .user = user};
    return sp_packing_make_with(spec, &hooks, out, err);
}

/* Fills in and checks the spec. */
static sp_status complete(const sp_pack_spec *given, const sp_pack_hooks *hooks, sp_pack_spec *out, sp_error *err) {
    sp_pack_spec spec = *given;
    sp_status status = SP_OK;
    if (spec.kind == SP_PACK_FILE)
        status = sp_pack_spec_from(&spec, hooks->from, err);
    if (status == SP_OK)
        status = sp_pack_spec_check(&spec, err);
    if (status == SP_OK)
        *out = sp_pack_spec_resolve(&spec);
    return status;
}

static sp_status make_ordered(const sp_pack_spec *spec, const sp_pack_hooks *hooks, sp_packing *out, sp_error *err) {
    if (hooks->state)
        return sp_fail(err, SP_EFORMAT, "an ordered packing has no state to resume from");
    return spec->kind == SP_PACK_CHAIN ? sp_chain_make(spec, out, err) : sp_triangular_make(spec, out, err);
}

sp_status sp_packing_make_with(const sp_pack_spec *given, const sp_pack_hooks *hooks, sp_packing *out, sp_error *err) {
    static const sp_pack_hooks none = {0};
    sp_pack_spec spec;
    if (!given || !out)
        return sp_fail(err, SP_EINVAL, "no %s is given: must be one", given ? "packing" : "spec");
    hooks = hooks ? hooks : &none;
    sp_status status = complete(given, hooks, &spec, err);
    if (status == SP_OK)
        status = check_memory(&spec, err);
    if (status != SP_OK)
        return status;
    const double start = sp_clock_cpu();
    sp_packing p = sp_packing_none();
    status = is_compressed(&spec) ? sp_piston_make(&spec, hooks, &p, err) : make_ordered(&spec, hooks, &p, err);
    if (status != SP_OK)
        return status;
    p.seconds = sp_clock_cpu() - start;
    *out = p;
    return SP_OK;
}
