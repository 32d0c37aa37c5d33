/* Makes the samples that the wanted items need, and reads them. */
#include "base/base.h"
#include "ensemble/sample.h"
#include "paper/paper.h"

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
    const paper *p = s->p;
    const double part = now->total > 0 ? (double)now->done / (double)now->total : 1;
    return sp_paper_report_progress(p, sp_paper_ensemble_name(s->e), (p->cost_done + s->cost * part) / p->cost,
                                    p->computed + now->computed, p->failed + now->failed);
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

sp_status sp_paper_ensembles(const sp_paper_options *opt, sp_paper_visit visit, void *user, sp_error *err) {
    const paper p = {.opt = opt};
    sp_status status = SP_OK;
    for (paper_ensemble e = PAPER_SQUARE; e < PAPER_ENSEMBLES && status == SP_OK; e++) {
        sp_scene scene = sp_scene_default();
        const unsigned want = wanted(&p, e);
        if (!want)
            continue;
        status = sp_paper_ensemble_scene(e, opt->samples, opt->protocol, &scene, err);
        scene.want = want;
        if (status == SP_OK)
            status = visit(sp_paper_ensemble_name(e), &scene, user, err);
        sp_scene_free(&scene);
    }
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
