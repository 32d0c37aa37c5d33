/* Creates packings: completes the spec, checks the memory, and calls the generator. */
#include "base/base.h"
#include "packing/geometry.h"
#include "packing/prepare.h"

#include <math.h>

typedef struct taken {
    const char *name;
    double given, usual, own; /* value in the spec, its default, value of the packing */
} taken;

/* A minimum may begin with any smooth spheres in a periodic cell that have its law. */
static sp_status check_smooth(const sp_pack_spec *spec, const sp_packing *from, sp_error *err) {
    if (from->cell != SP_CELL_PERIODIC || from->friction > 0 || from->mass || from->species)
        return sp_fail(err, SP_EINVAL,
                       "packing.file: cell \"%s\", friction %g%s%s: must be smooth spheres of one material in a "
                       "periodic cell for packing.kind = \"minimum\"",
                       sp_cell_names[from->cell], from->friction, from->mass ? ", masses of its own" : "",
                       from->species ? ", several materials" : "");
    for (int32_t k = 0; k < from->n_contacts; k++) {
        const sp_contact *c = &from->contacts[k];
        const double a = c->kn > 0 ? c->kn * c->overlap / c->fn : 1.5;
        if (!(fabs(a - spec->law_exponent) < 1e-6))
            return sp_fail(err, SP_EINVAL, "packing.law.exponent = %g: must be that of packing.file, %.10g",
                           spec->law_exponent, a);
    }
    return SP_OK;
}

static sp_status check_start(const sp_pack_spec *spec, const sp_packing *from, sp_error *err) {
    if (!from || from->n == 0)
        return sp_fail(err, SP_EINVAL, "packing.file = \"\": must name the packing that %s",
                       spec->content ? "packing.content is of" : "packing.kind = \"file\" begins with");
    sp_status status = sp_packing_check(from, err);
    if (status != SP_OK)
        return status;
    if (spec->kind == SP_PACK_MINIMUM)
        return check_smooth(spec, from, err);
    if (sp_cell_need_flat(from->cell, "packing.file", err) != SP_OK)
        return SP_EINVAL;
    if (from->dim == 1)
        return sp_fail(err, SP_EINVAL,
                       "packing.file: a chain (dimension 1): must have 2 or 3 dimensions; for a chain under another "
                       "pressure use packing.kind = \"chain\"");
    if (from->wall != SP_WALL_RIGID)
        return sp_fail(err, SP_EINVAL,
                       "packing.file: its walls are no rigid planes, which they must be to be compressed by a piston");
    if (!sp_packing_hertzian(from))
        return sp_fail(err, SP_EINVAL,
                       "packing.file: has masses or stiffnesses of its own; must be Hertzian spheres to be compressed");
    if (!(from->pressure >= 1e-10 && from->pressure <= 1e-2))
        return sp_fail(err, SP_EINVAL, "packing.file: its pressure = %g: must be 1e-10 .. 1e-2 E*", from->pressure);
    return SP_OK;
}

static sp_status check_sizes(const sp_pack_spec *spec, sp_error *err) {
    if (spec->sizes != SP_SIZES_UNIFORM || spec->diameter_count > 0)
        return sp_fail(err, SP_EINVAL,
                       "packing.sizes: must not be given with packing.file, whose grains already have sizes");
    return SP_OK;
}

sp_status sp_pack_spec_from(sp_pack_spec *spec, const sp_packing *from, sp_error *err) {
    sp_status status = check_start(spec, from, err);
    if (status == SP_OK)
        status = check_sizes(spec, err);
    if (status != SP_OK)
        return status;
    const sp_pack_spec usual = sp_pack_spec_default();
    double low = INFINITY, high = 0;
    for (int32_t i = 0; i < from->n; i++) {
        low = fmin(low, 2 * from->r[i]);
        high = fmax(high, 2 * from->r[i]);
    }
    const taken all[] = {{"dimension", spec->dim, usual.dim, from->dim},
                         {"grains", spec->grains, usual.grains, from->n},
                         {"width", spec->width, usual.width, from->box[0]},
                         {"cell", (double)spec->cell, (double)usual.cell, (double)from->cell},
                         {"gravity", spec->gravity, usual.gravity, from->gravity},
                         {"depth", spec->depth, usual.depth, from->dim == 3 ? from->box[1] : 0},
                         {"diameter_min", spec->diameter_min, usual.diameter_min, low},
                         {"diameter_max", spec->diameter_max, usual.diameter_max, high}};
    for (size_t k = 0; k < sizeof all / sizeof *all; k++)
        if (all[k].given != all[k].usual && all[k].given != all[k].own)
            return sp_fail(err, SP_EINVAL, "packing.%s = %.10g: must be that of packing.file, %.10g, or not given",
                           all[k].name, all[k].given, all[k].own);
    const uint64_t content = sp_packing_hash(from);
    if (spec->content && spec->content != content)
        return sp_fail(err, SP_EINVAL,
                       "packing.content = %llu: packing.file has changed, its number is %llu: must be this number, "
                       "or 0 for any",
                       (unsigned long long)spec->content, (unsigned long long)content);
    spec->cell = from->cell;
    spec->gravity = from->gravity;
    spec->dim = from->dim;
    spec->grains = from->n;
    spec->width = from->box[0];
    spec->depth = from->dim == 3 ? from->box[1] : 0;
    spec->diameter_min = low;
    spec->diameter_max = high;
    spec->content = content;
    return SP_OK;
}

/* Whether the packing is found by a simulated compression. */
static bool is_compressed(const sp_pack_spec *s) {
    return s->kind == SP_PACK_PISTON || s->kind == SP_PACK_FILE ||
           (s->kind == SP_PACK_TRIANGULAR && s->diameter_min < s->diameter_max);
}

/* Sorting needs a copy of the contacts. Compressed grains have neighbour lists, two of them during a rebuild, and the
 * gas has cells: bytes a grain. Most are in use while the state of a run of minutes is saved: 1060 to 1770 for disks
 * (10^5 and 10^6 under a piston), 1840 to 4800 for spheres. */
static const double DISK_BYTES = 1700, SPHERE_BYTES = 4300;

/* The history of contacts takes 1.67 times the memory (measured in a gas). */
static const double HISTORY = 1.7;

double sp_pack_memory(const sp_pack_spec *s) {
    const double n = s->grains;
    if (s->kind == SP_PACK_MINIMUM) /* lists of pairs, which grow by doubling */
        return n * (s->dim == 3 ? 1600 : 800);
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
    if (spec.kind == SP_PACK_FILE || (spec.kind == SP_PACK_MINIMUM && (hooks->from || spec.content)))
        status = sp_pack_spec_from(&spec, hooks->from, err);
    if (status == SP_OK)
        status = sp_pack_spec_check(&spec, err);
    if (status == SP_OK)
        *out = sp_pack_spec_resolve(&spec);
    return status;
}

static sp_status make_ordered(const sp_pack_spec *spec, const sp_pack_hooks *hooks, sp_packing *out, sp_error *err) {
    if (hooks->state)
        return sp_fail(err, SP_EFORMAT, "a packing that is not compressed has no state to resume from");
    if (spec->kind == SP_PACK_MINIMUM)
        return sp_minimum_make(spec, hooks, out, err);
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
