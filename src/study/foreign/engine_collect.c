/* Reads what LAMMPS has made, brings it to our rest, and audits it. */
#include "base/base.h"
#include "base/file.h"
#include "foreign/engine.h"
#include "packing/prepare.h"

#include <math.h>
#include <sonopack/study/import.h>
#include <stdio.h>

/* Above this acceleration over the pressure the grains of LAMMPS still move: it has taken all its steps. */
static const double MOVING = 0.05;
/* Tolerance and threshold of `sonopack check'. */
static const double TOLERANCE = 2e-5, THRESHOLD = 1e-4;

static sp_status read_result(const sp_pack_spec *spec, const char *folder, sp_engine_result *r, sp_error *err) {
    char path[SP_PATH_MAX], *text = NULL;
    size_t size;
    long long steps;
    int used = 0;
    sp_engine_log log;
    sp_status status = sp_engine_look(folder, SP_ENGINE_RESULT, path, err);
    if (status == SP_OK && sp_file_read_text(path, &text, &size, err) != SP_OK)
        return sp_fail(err, SP_EFORMAT, "%s: is missing or cannot be read: LAMMPS did not come to its end", path);
    if (status != SP_OK)
        return status;
    const int count =
        sscanf(text, "steps %lld acceleration %lf top %lf%n", &steps, &r->acceleration, &r->height, &used);
    const bool whole =
        count == 3 && text[used] == '\n' && isfinite(r->acceleration) && isfinite(r->height) && steps > 0;
    sp_free(text);
    if (!whole)
        return sp_fail(err, SP_EFORMAT,
                       "%s: must be a line of steps, acceleration and top, all finite: is it cut, is the disk full?",
                       path);
    r->steps = steps;
    sp_engine_read_log(folder, &log);
    snprintf(r->version, sizeof r->version, "%s", log.version[0] ? log.version : "of an unknown version");
    if (r->acceleration > MOVING * sp_engine_pressure(spec))
        return sp_fail(err, SP_EFAILED,
                       "LAMMPS: not at rest after %lld steps: the largest acceleration is %.3g, must be below %.3g "
                       "(packing.max_steps allows more steps)",
                       steps, r->acceleration, MOVING * sp_engine_pressure(spec));
    return SP_OK;
}

/* A copy of the reason, for a failure with another status. */
static const char *reason_of(const sp_error *err, char text[SP_ERROR_TEXT]) {
    snprintf(text, SP_ERROR_TEXT, "%s", err ? err->text : "");
    return text;
}

static sp_status import(const sp_pack_spec *spec, const char *folder, const sp_engine_result *r, sp_packing *out,
                        sp_error *err) {
    char grains[SP_PATH_MAX], contacts[SP_PATH_MAX], text[SP_ERROR_TEXT];
    sp_import_options o = sp_import_options_default();
    o.form = SP_FORM_LAMMPS_DUMP;
    o.contacts = contacts;
    o.types = "1";
    o.dim = spec->dim;
    o.wall = SP_WALL_RIGID;
    o.width = spec->width;
    o.depth = spec->dim == 3 ? spec->depth : NAN;
    o.bottom = 0;
    o.top = r->height;
    o.pressure = sp_engine_pressure(spec);
    o.friction = spec->friction;
    o.poisson = spec->poisson;
    sp_status status = sp_engine_look(folder, SP_ENGINE_GRAINS, grains, err);
    if (status == SP_OK)
        status = sp_engine_look(folder, SP_ENGINE_CONTACTS, contacts, err);
    if (status != SP_OK)
        return status;
    status = sp_import(grains, &o, out, NULL, err);
    /* no option of the user's is wrong, but a file */
    return status == SP_EINVAL ? sp_fail(err, SP_EFORMAT, "%s", reason_of(err, text)) : status;
}

/* The grains must be those of the spec. LAMMPS leaves out grains that leave the box. */
static sp_status check_grains(const sp_pack_spec *spec, const sp_packing *p, sp_error *err) {
    if (p->n != spec->grains)
        return sp_fail(err, SP_EFORMAT, "%s: %d grains, must be %d of the scene", sp_engine_names[SP_ENGINE_GRAINS],
                       p->n, spec->grains);
    double *r = sp_alloc((size_t)p->n, sizeof *r);
    if (!r)
        return sp_fail_memory(err, (size_t)p->n * sizeof *r);
    sp_radii_draw(spec, r);
    int32_t k = 0;
    while (k < p->n && fabs(r[k] - p->r[k]) <= 1e-14 * r[k])
        k++;
    const double wanted = k < p->n ? r[k] : 0;
    sp_free(r);
    if (k == p->n)
        return SP_OK;
    return sp_fail(err, SP_EFORMAT,
                   "%s: grain %d has the diameter %.17g, must have %.17g: is this of another scene or seed?",
                   sp_engine_names[SP_ENGINE_GRAINS], k, 2 * p->r[k], 2 * wanted);
}

/* The upper wall must rest on grains. From a height that a file has made up it would fall for ever. */
static sp_status check_top(const sp_packing *p, double top, sp_error *err) {
    double highest = 0;
    for (int32_t i = 0; i < p->n; i++)
        highest = fmax(highest, p->x[3 * (size_t)i + (size_t)p->dim - 1] + p->r[i]);
    if (fabs(highest - top) <= 0.1)
        return SP_OK;
    return sp_fail(err, SP_EFORMAT, "%s: top %g, but the grains reach up to %g", sp_engine_names[SP_ENGINE_RESULT], top,
                   highest);
}

/* The spec that starts from a packing: what the grains are follows from it. */
static sp_pack_spec resting_spec(const sp_pack_spec *given) {
    const sp_pack_spec usual = sp_pack_spec_default();
    sp_pack_spec s = *given;
    s.kind = SP_PACK_FILE;
    s.dim = usual.dim;
    s.grains = usual.grains;
    s.width = usual.width;
    s.depth = usual.depth;
    s.sizes = usual.sizes;
    s.diameter_min = usual.diameter_min;
    s.diameter_max = usual.diameter_max;
    s.large_fraction = usual.large_fraction;
    s.size_spread = usual.size_spread;
    s.diameters = NULL;
    s.diameter_count = 0;
    s.content = 0;
    s.max_steps = 0;
    return s;
}

static sp_status come_to_rest(const sp_pack_spec *spec, const sp_packing *from, const sp_pack_hooks *given,
                              sp_packing *out, sp_error *err) {
    const sp_pack_spec s = resting_spec(spec);
    char text[SP_ERROR_TEXT];
    const sp_pack_hooks hooks = {.watch = given->watch, .user = given->user, .threads = given->threads, .from = from};
    sp_status status = sp_packing_make_with(&s, &hooks, out, err);
    if (status == SP_EINVAL) /* the user has given none of these values */
        return sp_fail(err, SP_EFAILED, "%s", reason_of(err, text));
    return status == SP_OK || status == SP_EINTERRUPTED ? status : sp_fail_prefix(err, "coming to rest after LAMMPS");
}

static sp_status audit(const sp_packing *p, sp_audit *out, sp_error *err) {
    char reason[200];
    sp_status status = sp_packing_audit(p, THRESHOLD, out, err);
    if (status != SP_OK)
        return status;
    const double worst = sp_audit_worst(out, TOLERANCE, reason, sizeof reason);
    return reason[0] ? sp_fail(err, SP_EFAILED, "the packing at rest fails its audit by %.3g: %s", worst, reason)
                     : SP_OK;
}

sp_status sp_engine_collect(const sp_pack_spec *given, const char *folder, const sp_pack_hooks *hooks, sp_packing *out,
                            sp_engine_result *result, sp_error *err) {
    sp_packing raw = sp_packing_none(), p = sp_packing_none();
    sp_engine_result r = {0};
    sp_status status = sp_engine_check(given, err);
    if (status != SP_OK)
        return status;
    const sp_pack_spec spec = sp_pack_spec_resolve(given);
    sp_locale locale = sp_locale_enter();
    status = read_result(&spec, folder, &r, err);
    if (status == SP_OK)
        status = import(&spec, folder, &r, &raw, err);
    if (status == SP_OK)
        status = check_grains(&spec, &raw, err);
    if (status == SP_OK)
        status = check_top(&raw, r.height, err);
    sp_locale_leave(&locale);
    if (status == SP_OK)
        status = come_to_rest(&spec, &raw, hooks, &p, err);
    if (status == SP_OK)
        status = audit(&p, &r.audit, err);
    sp_packing_free(&raw);
    if (status != SP_OK) {
        sp_packing_free(&p);
        return status;
    }
    p.seed = given->seed;
    p.steps += r.steps;
    *out = p;
    *result = r;
    return SP_OK;
}
