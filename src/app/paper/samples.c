/* Picks samples of an ensemble: their values, their packings and networks. */
#include "base/base.h"
#include "paper/paper.h"

#include <math.h>

static bool fits(const sp_sample *s, double pressure, int32_t grains) {
    return fabs(s->pressure - pressure) < 1e-9 * pressure && (grains == 0 || s->grains == grains);
}

sp_status sp_paper_values(const paper *p, paper_ensemble e, double pressure, int32_t grains, unsigned part,
                          double (*of)(const sp_sample *s), int64_t *n, double **values, sp_error *err) {
    const paper_set *set = &p->set[e];
    double *v = sp_alloc((size_t)set->n, sizeof *v);
    if (!v)
        return sp_fail_memory(err, (size_t)set->n * sizeof *v);
    int64_t count = 0;
    for (int64_t k = 0; k < set->n; k++)
        if (fits(&set->sample[k], pressure, grains) && (set->sample[k].have & part) == part)
            v[count++] = of(&set->sample[k]);
    *n = count;
    *values = v;
    return SP_OK;
}

static sp_status visit_one(paper *p, const sp_sample *s, const sp_network_options *options, paper_visit visit,
                           void *user, sp_error *err) {
    sp_packing packing = sp_packing_none();
    sp_network net = sp_network_none();
    sp_sample stored;
    bool found = false;
    sp_study_sink sink = sp_store_sink(p->store);
    sp_status status = sink.load(sink.user, s->name, &packing, &stored, &found, err);
    if (status == SP_OK && !found)
        status = sp_fail(err, SP_EIO, "sample %s is no longer in the store", s->name);
    if (status == SP_OK)
        status = sp_network_make(&packing, options, &net, err);
    if (status == SP_OK)
        status = visit(s, &packing, &net, user, err);
    sp_network_free(&net);
    sp_packing_free(&packing);
    return status;
}

sp_status sp_paper_walk(paper *p, paper_ensemble e, double pressure, int32_t grains, int64_t most, paper_visit visit,
                        void *user, sp_error *err) {
    const sp_network_options options = sp_network_options_default();
    const paper_set *set = &p->set[e];
    sp_status status = SP_OK;
    int64_t count = 0;
    for (int64_t k = 0; k < set->n && status == SP_OK && (most == 0 || count < most); k++) {
        if (!fits(&set->sample[k], pressure, grains))
            continue;
        count++;
        status = visit_one(p, &set->sample[k], &options, visit, user, err);
    }
    if (status == SP_OK && count == 0)
        status =
            sp_fail(err, SP_EFAILED, "%s at p = %g: no packing could be made", sp_paper_ensemble_name(e), pressure);
    return status;
}
