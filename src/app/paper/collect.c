/* From the items that are wanted to the samples that they need. */
#include "base/base.h"
#include "ensemble/sample.h"
#include "paper/paper.h"

#include <math.h>
#include <string.h>

/* Results of an ensemble that the wanted items need; 0: none. */
static unsigned wanted(const paper *p, paper_ensemble e) {
    unsigned want = 0;
    for (int item = 0; item < SP_PAPER_ITEMS; item++)
        for (int k = 0; k < sp_paper_items[item].needs && sp_paper_wants(p, item); k++) {
            const paper_need *need = &sp_paper_items[item].need[k];
            if (need->ensemble == e && (p->opt->folder || !need->drawn))
                want |= need->want;
        }
    return want;
}

typedef struct stage {
    paper *p;
    paper_ensemble e;
    double cost;
} stage;

static bool watch(const sp_study_progress *now, void *user) {
    const stage *s = user;
    paper *p = s->p;
    if (!p->watch)
        return true;
    const double part = now->total > 0 ? (double)now->done / (double)now->total : 1;
    sp_paper_progress progress = {.what = sp_paper_ensemble_name(s->e),
                                  .fraction = (p->cost_done + s->cost * part) / p->cost,
                                  .seconds = sp_clock_wall() - p->begun,
                                  .seconds_left = NAN,
                                  .computed = p->computed + now->computed,
                                  .failed = p->failed + now->failed};
    if (progress.fraction > 0.02)
        progress.seconds_left = progress.seconds * (1 - progress.fraction) / progress.fraction;
    return p->watch(&progress, p->user);
}

/* Reads all finished samples of a scene; those that are not there are left out. */
static sp_status read_samples(paper *p, const sp_scene *scene, paper_set *out, sp_error *err) {
    const int64_t count = sp_study_count(scene), combinations = count / scene->samples;
    paper_set set = {.sample = sp_alloc((size_t)count, sizeof *set.sample)};
    if (!set.sample)
        return sp_fail_memory(err, (size_t)count * sizeof *set.sample);
    sp_study_sink sink = sp_store_sink(p->store);
    sp_status status = SP_OK;
    for (int64_t k = 0; k < count && status == SP_OK; k++) {
        sp_scene one;
        sp_packing packing = sp_packing_none();
        char name[SP_NAME_MAX];
        bool found = false;
        status = sp_study_sample(scene, k / scene->samples + k % scene->samples * combinations, &one, name, err);
        if (status == SP_OK)
            status = sink.load(sink.user, name, &packing, &set.sample[set.n], &found, err);
        set.n += status == SP_OK && found;
        sp_packing_free(&packing);
    }
    if (status != SP_OK) {
        sp_free(set.sample);
        return status;
    }
    *out = set;
    return SP_OK;
}

static sp_status collect_one(paper *p, stage *s, unsigned want, sp_error *err) {
    sp_scene scene = sp_scene_default();
    sp_status status = sp_paper_ensemble_scene(s->e, p->opt->samples, p->opt->protocol, &scene, err);
    if (status != SP_OK)
        return status;
    scene.want = want;
    sp_study_sink sink = sp_store_sink(p->store);
    const sp_study_options options = {.jobs = p->opt->jobs, .shard = 1, .shards = 1, .threads = p->opt->threads};
    sp_study_progress done = {0};
    status = sp_study_run(&scene, &options, &sink, watch, s, &done, err);
    p->computed += done.computed;
    p->failed += done.failed;
    if (status == SP_OK)
        status = read_samples(p, &scene, &p->set[s->e], err);
    sp_scene_free(&scene);
    return status;
}

sp_status sp_paper_collect(paper *p, sp_error *err) {
    sp_status status = SP_OK;
    p->cost = 1; /* what is done with the samples */
    for (paper_ensemble e = PAPER_SQUARE; e < PAPER_ENSEMBLES; e++)
        p->cost += wanted(p, e) ? sp_paper_ensemble_cost(e, p->opt->samples, p->opt->protocol) : 0;
    for (paper_ensemble e = PAPER_SQUARE; e < PAPER_ENSEMBLES && status == SP_OK; e++) {
        const unsigned want = wanted(p, e);
        stage s = {.p = p, .e = e, .cost = sp_paper_ensemble_cost(e, p->opt->samples, p->opt->protocol)};
        if (!want)
            continue;
        status = collect_one(p, &s, want, err);
        p->cost_done += s.cost;
    }
    return status;
}

/* ---- samples ---------------------------------------------------------------------------------------------------- */

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
