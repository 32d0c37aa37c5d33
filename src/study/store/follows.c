/* Compares results of a sample with what follows from its packing, its scene and its other results at little cost. */
#include "base/base.h"
#include "ensemble/sample.h"
#include "store/folder.h"
#include "store/stated.h"

#include <math.h>
#include <stddef.h>
#include <string.h>

/* Layers that the averages of a sample leave out at the walls [d] (ensemble/parts.c). */
static const double bulk_margin = 3;
/* Sums in another order differ by rounding. */
static const double rounding = 1e-9;

/* ---- the scene ------------------------------------------------------------------------------------------------- */

sp_status sp_record_scene(const sp_record *r, const sp_scene *scene, const sp_packing *p, sp_error *err) {
    const sp_sample *s = &r->sample;
    sp_sample own = *s;
    sp_scene resolved = *scene;
    sp_status status = sp_scene_resolve(&resolved, err);
    if (status == SP_OK)
        status = sp_sample_describe(&resolved, &own, err);
    if (status != SP_OK)
        return status;
    if (strcmp(own.name, s->name) != 0)
        return sp_fail_key(err, SP_EFAILED, "/results/sample/scene",
                           " makes the sample %s: another, or one of other algorithms", own.name);
    if (s->seed != own.seed)
        return sp_at_odds(err, "/results/sample/seed", (double)s->seed, (double)own.seed);
    if (s->material != 0 && s->material != own.material) /* 0 in files of earlier versions */
        return sp_fail_key(err, SP_EFAILED, "/results/sample/material", " = %llu: must be %llu",
                           (unsigned long long)s->material, (unsigned long long)own.material);
    const struct {
        const char *field;
        double stored, expected;
    } pair[] = {{"/results/sample/kind", s->kind, own.kind},
                {"/results/sample/dim", s->dim, own.dim},
                {"/results/sample/grains", s->grains, own.grains},
                {"/results/sample/width", s->width, own.width},
                {"/results/sample/pressure", s->pressure, own.pressure},
                {"/results/sample/friction", s->friction, own.friction},
                {"/results/sample/height", s->height, sp_packing_height(p)}};
    for (size_t k = 0; k < sizeof pair / sizeof *pair; k++)
        if (pair[k].stored != pair[k].expected)
            return sp_at_odds(err, pair[k].field, pair[k].stored, pair[k].expected);
    return SP_OK;
}

/* ---- averages of the packing ------------------------------------------------------------------------------------- */

/* Numbers of earlier versions that lack some of today's are read as NAN. */
static sp_status check_statics(const sp_record *r, const sp_packing *p, double threshold, sp_error *err) {
    sp_statics now;
    sp_result result[SP_RESULTS_MAX];
    const int results = sp_results(result);
    sp_status status = sp_statics_make(p, threshold, bulk_margin, &now, err);
    for (int k = 0; status == SP_OK && k < results; k++) {
        double stored, expected;
        if (result[k].want != SP_WANT_STATICS)
            continue;
        const size_t at = result[k].offset - offsetof(sp_sample, statics);
        memcpy(&stored, (const char *)&r->sample.statics + at, sizeof stored);
        memcpy(&expected, (const char *)&now + at, sizeof expected);
        const bool stress = at >= offsetof(sp_statics, s_xx), newer = at >= offsetof(sp_statics, s12_over_s2);
        const double scale = fmax(fabs(expected), stress ? p->pressure : 1);
        if (isnan(stored) ? !isnan(expected) && !newer : !(fabs(stored - expected) <= rounding * scale))
            status = sp_at_odds(err, result[k].field->name.path, stored, expected);
    }
    return status;
}

/* ---- the network ------------------------------------------------------------------------------------------------- */

/* The sums of all squared frequencies and of their squares are those of M^-1/2 K M^-1/2 on the diagonal and of all its
 * squared entries. */
static sp_status check_sums(const sp_network *net, const sp_sample_arrays *a, sp_error *err) {
    double found[2] = {0, 0}, expected[2] = {0, 0};
    sp_sparse k;
    sp_status status = sp_network_assemble(net, &k, err);
    if (status != SP_OK)
        return status;
    for (int64_t j = 0; j < k.n; j++)
        for (int64_t e = k.p[j]; e < k.p[j + 1]; e++) {
            const double x = k.x[e] / sqrt(net->mass[j] * net->mass[k.i[e]]);
            expected[0] += k.i[e] == j ? x : 0;
            expected[1] += (k.i[e] == j ? 1 : 2) * x * x;
        }
    sp_sparse_free(&k);
    for (int64_t m = 0; m < a->modes; m++) {
        const double square = a->omega[m] * a->omega[m];
        found[0] += square;
        found[1] += square * square;
    }
    for (int m = 0; m < 2; m++)
        if (!(fabs(found[m] - expected[m]) <= rounding * expected[m]))
            return sp_fail_key(err, SP_EFAILED, "/results/spectrum/omega",
                               ": the sum of omega^%d is %.12g, and must be %.12g by the stiffness matrix", 2 + 2 * m,
                               found[m], expected[m]);
    return SP_OK;
}

static sp_status check_spectrum(const sp_record *r, const sp_packing *p, const sp_scene *scene, sp_error *err) {
    const sp_spectrum_made *made = &r->sample.spectrum;
    sp_network net = sp_network_none();
    sp_status status = sp_network_make(p, &scene->network, &net, err);
    if (status == SP_OK && made->carrying != net.n)
        status = sp_at_odds(err, "/results/spectrum/carrying", made->carrying, net.n);
    if (status == SP_OK && made->dof != net.dof)
        status = sp_at_odds(err, "/results/spectrum/dof", made->dof, net.dof);
    if (status == SP_OK && !net.prestress) /* with it, unstable modes count as zero */
        status = check_sums(&net, &r->arrays, err);
    sp_network_free(&net);
    return status;
}

/* Without prestress every strain costs energy. */
static sp_status check_signs(const sp_sample *s, sp_error *err) {
    const sp_moduli *m = &s->moduli;
    const struct {
        const char *field;
        double value;
    } each[] = {{"/results/moduli/c11", m->c11}, {"/results/moduli/c22", m->c22}, {"/results/moduli/c33", m->c33},
                {"/results/moduli/c44", m->c44}, {"/results/moduli/c55", m->c55}, {"/results/moduli/c66", m->c66}};
    for (size_t k = 0; k < sizeof each / sizeof *each; k++)
        if (each[k].value < 0)
            return sp_fail_key(err, SP_EFAILED, each[k].field, " = %g: must not be negative without prestress",
                               each[k].value);
    for (int k = 0; s->have & SP_WANT_PROBES && k < SP_PROBES; k++)
        if (s->probe[k].along < 0 || s->probe[k].shear < 0)
            return sp_fail_key(err, SP_EFAILED, "/results/probes", ": %g and %g must not be negative without prestress",
                               s->probe[k].along, s->probe[k].shear);
    return SP_OK;
}

/* ---- the signal -------------------------------------------------------------------------------------------------- */

static sp_status check_times(const sp_signal *s, sp_error *err) {
    const double until = s->t[s->n - 1];
    for (int32_t k = 0; k < s->n; k++)
        if (!(fabs(s->t[k] - until * k / (s->n - 1)) <= rounding * until))
            return sp_at_odds(err, "/signal/t", s->t[k], until * k / (s->n - 1));
    return SP_OK;
}

/* The front of the stored signal, if this is long and dense enough for it. Between two of its points the marks may lie
 * anywhere. A signal of the nonlinear motion has another front. */
static sp_status check_front(const sp_record *r, sp_error *err) {
    const sp_sample *s = &r->sample;
    const sp_signal *signal = &r->arrays.signal;
    const double window = sp_signal_window(s->height, s->pressure), step = signal->t[1] - signal->t[0];
    sp_front_options rule = sp_front_options_default();
    sp_front found;
    if (!(s->have & SP_WANT_CTOF) || signal->method == SP_SIGNAL_DYNAMICS ||
        signal->t[signal->n - 1] < window * (1 - 1e-6) || step > 3 * sp_front_spacing(s->pressure))
        return SP_OK;
    rule.window = window * (1 + 1e-6);
    sp_status status = sp_front_find(signal->n, signal->t, signal->f, &rule, &found, err);
    if (status != SP_OK)
        return status == SP_ENOMEM ? status
                                   : sp_fail_key(err, SP_EFAILED, "/signal/F",
                                                 ": has no front, and /results "
                                                 "has one");
    if (!(fabs(found.t10 - s->front.t10) <= step))
        return sp_at_odds(err, "/results/front/t10", s->front.t10, found.t10);
    if (!(fabs(found.t_peak - s->front.t_peak) <= step))
        return sp_at_odds(err, "/results/front/t_peak", s->front.t_peak, found.t_peak);
    if (!(fabs(found.amplitude - s->front.amplitude) <= 0.02 * found.amplitude))
        return sp_at_odds(err, "/results/front/amplitude", s->front.amplitude, found.amplitude);
    return SP_OK;
}

sp_status sp_record_follows(const sp_record *r, const sp_scene *scene, const sp_packing *p, sp_error *err) {
    const unsigned have = r->sample.have;
    sp_status status = SP_OK;
    if (have & SP_WANT_STATICS)
        status = check_statics(r, p, scene->network.threshold, err);
    if (status == SP_OK && have & SP_WANT_MODULI && !scene->network.prestress)
        status = check_signs(&r->sample, err);
    if (status == SP_OK && have & SP_WANT_SPECTRUM)
        status = check_spectrum(r, p, scene, err);
    if (status == SP_OK && r->arrays.signal.n > 1)
        status = check_times(&r->arrays.signal, err);
    if (status == SP_OK && r->arrays.signal.n > 1)
        status = check_front(r, err);
    return status;
}
