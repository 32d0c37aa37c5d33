/* Adds up what the samples of a study will take. */
#include <sonopack/study/forecast.h>

#include "base/base.h"
#include "ensemble/sample.h"

#include <math.h>
#include <string.h>

enum { LOOKED_MOST = 4000 }; /* samples: a name is hashed for each, and a file looked for */

/* Bytes of a sample's file beside those of a packing's, and of the results of one part. */
static const double own_bytes = 4500, part_bytes = 3300;

static const struct {
    unsigned want;
    const char *what;
} parts[SP_FORECAST_PARTS] = {{0, "packings"},
                              {SP_WANT_STATICS, "statics"},
                              {SP_WANT_CTOF, "fronts"},
                              {SP_WANT_PLANES, "planes"},
                              {SP_WANT_SIGNAL, "signals"},
                              {SP_WANT_MODULI, "moduli"},
                              {SP_WANT_PROBES, "probes"},
                              {SP_WANT_SPECTRUM, "frequencies"}};

/* What is expected of one sample. */
typedef struct one {
    sp_cost cost[SP_FORECAST_PARTS];
    double bytes[SP_FORECAST_PARTS];
} one;

/* The front is found from a part of the signal. */
static sp_cost front(const sp_scene *scene, const sp_network_size *net, double planes, const sp_machine *machine) {
    sp_signal_options o = scene->signal;
    o.method = SP_SIGNAL_AUTO;
    o.until = 0;
    sp_cost cost = sp_cost_signal(net, &o, machine, NULL, NULL);
    cost.cpu *= 1 + 0.1 * planes;
    cost.wall = cost.cpu;
    return cost;
}

static sp_cost part_cost(unsigned want, const sp_scene *scene, const sp_network_size *net, const sp_machine *machine) {
    const sp_modes_options frequencies = {.vectors = false, .solver = SP_SOLVER_DENSE};
    const sp_modes_range all = sp_modes_range_all();
    switch (want) {
    case SP_WANT_STATICS: return sp_cost_result(SP_RESULT_STATICS, net, 1, machine);
    case SP_WANT_CTOF: return front(scene, net, 0, machine);
    case SP_WANT_PLANES: return front(scene, net, scene->planes, machine);
    case SP_WANT_SIGNAL: return sp_cost_signal(net, &scene->signal, machine, NULL, NULL);
    case SP_WANT_MODULI: return sp_cost_result(SP_RESULT_MODULI, net, 1, machine);
    case SP_WANT_PROBES: return sp_cost_result(SP_RESULT_PROBES, net, 1, machine);
    default: return sp_cost_modes(net, &frequencies, &all, net->dofs, machine);
    }
}

static double array_bytes(unsigned want, const sp_scene *scene, const sp_network_size *net) {
    return want == SP_WANT_SIGNAL     ? 16.0 * scene->signal.points
           : want == SP_WANT_SPECTRUM ? 8 * net->dofs
           : want == SP_WANT_PLANES   ? 56.0 * scene->planes
                                      : 0;
}

/* The parts that `want` stands for, with those that they need. */
static unsigned with_needs(unsigned want) {
    want = sp_want_parts(want);
    if (want & SP_WANT_PROBES)
        want |= SP_WANT_MODULI;
    if (want & SP_WANT_MODULI)
        want |= SP_WANT_STATICS;
    return want;
}

static one expect_one(const sp_scene *scene, int threads, const sp_machine *machine) {
    const sp_packing_forecast packing = sp_packing_expect(&scene->pack, threads, machine);
    const sp_network_size net = sp_network_size_expect(&scene->pack, &packing);
    const unsigned want = with_needs(scene->want);
    one o = {.cost[0] = packing.cost};
    o.bytes[0] = own_bytes + sp_bytes_packing(scene->pack.dim, scene->pack.grains, packing.contacts);
    const double around = sp_cost_result(SP_RESULT_NETWORK, &net, 1, machine).cpu +
                          sp_cost_result(SP_RESULT_SAMPLE, &net, 1, machine).cpu;
    o.cost[0].cpu += around;
    o.cost[0].wall += around;
    for (int k = 1; k < SP_FORECAST_PARTS && parts[k].what; k++)
        if (want & parts[k].want) {
            o.cost[k] = part_cost(parts[k].want, scene, &net, machine);
            o.bytes[k] = part_bytes + array_bytes(parts[k].want, scene, &net);
        }
    return o;
}

double sp_sample_expect(const sp_scene *scene, const sp_machine *machine) {
    const one o = expect_one(scene, 1, machine);
    double cpu = 0;
    for (int k = 0; k < SP_FORECAST_PARTS; k++)
        cpu += isfinite(o.cost[k].cpu) ? o.cost[k].cpu : 0;
    return cpu;
}

/* ---- a study ---------------------------------------------------------------------------------------------------- */

/* Adds a sample that is missing, `weight` times. */
static void add_sample(sp_forecast *f, const one *o, bool packed, double weight) {
    double cpu = 0;
    for (int k = packed ? 1 : 0; k < SP_FORECAST_PARTS; k++) {
        sp_forecast_part *part = &f->part[k];
        if (!part->what)
            continue;
        part->count += (int64_t)weight;
        part->cost.cpu += weight * o->cost[k].cpu;
        part->cost.wall += weight * o->cost[k].wall;
        part->cost.memory = fmax(part->cost.memory, o->cost[k].memory);
        part->bytes += weight * o->bytes[k];
        cpu += o->cost[k].cpu;
    }
    f->longest = fmax(f->longest, cpu);
}

static void name_parts(const sp_scene *study, sp_forecast *f) {
    const unsigned want = with_needs(study->want);
    for (int k = 0; k < SP_FORECAST_PARTS; k++)
        f->part[k].what = k == 0 || want & parts[k].want ? parts[k].what : NULL;
}

/* The samples of one combination that are in the shard: every `step`-th is looked for, and counts for that many. */
typedef struct looking {
    const sp_scene *study;
    const sp_study_options *opt;
    const sp_study_sink *sink;
    bool (*packed)(void *user, const char *name);
    void *user;
    const sp_machine *machine;
    int64_t combinations, step;
} looking;

static sp_status look_for(const looking *l, int64_t number, int64_t weight, const one *o, sp_forecast *f,
                          sp_error *err) {
    sp_scene scene;
    char name[SP_NAME_MAX];
    sp_stored stored = SP_STORED_NOT;
    sp_status status = SP_OK;
    bool packed = false;
    if (l->sink && l->sink->has) {
        status = sp_study_sample(l->study, number, &scene, name, err);
        if (status == SP_OK)
            stored = l->sink->has(l->sink->user, &scene, name);
        packed = status == SP_OK && l->packed && l->packed(l->user, name);
    }
    f->looked++;
    f->stored += stored == SP_STORED_ALL ? weight : 0;
    f->failed += stored == SP_STORED_FAILED ? weight : 0;
    if (status == SP_OK && stored == SP_STORED_NOT)
        add_sample(f, o, packed, (double)weight);
    return status;
}

static sp_status look_through(const looking *l, int64_t combination, sp_forecast *f, sp_error *err) {
    sp_scene scene;
    sp_status status = sp_study_scene(l->study, combination, &scene, err);
    if (status != SP_OK)
        return status;
    const one o = expect_one(&scene, l->opt->jobs == 1 ? l->opt->threads : 1, l->machine);
    int64_t mine = 0;
    for (int64_t k = combination, count = l->study->samples; count > 0; count--, k += l->combinations)
        mine += k % l->opt->shards == l->opt->shard - 1;
    f->samples += mine;
    if (!l->sink) {
        add_sample(f, &o, false, (double)mine);
        return SP_OK;
    }
    int64_t place = 0;
    for (int64_t k = combination, count = l->study->samples; count > 0 && status == SP_OK;
         count--, k += l->combinations) {
        if (k % l->opt->shards != l->opt->shard - 1)
            continue;
        const int64_t left = mine - place;
        if (place++ % l->step == 0)
            status = look_for(l, k, left < l->step ? left : l->step, &o, f, err);
    }
    return status;
}

sp_status sp_study_expect(const sp_scene *study, const sp_study_options *opt, const sp_study_sink *sink,
                          bool (*packed)(void *user, const char *name), void *user, const sp_machine *machine,
                          sp_forecast *out, sp_error *err) {
    const int64_t count = sp_study_count(study);
    if (count < 1 || study->samples < 1)
        return sp_fail(err, SP_EINVAL, "study.sweep: a sweep without values, or more than 2^63 samples");
    const looking l = {.study = study,
                       .opt = opt,
                       .sink = sink,
                       .packed = packed,
                       .user = user,
                       .machine = machine,
                       .combinations = count / study->samples,
                       .step = 1 + count / opt->shards / LOOKED_MOST};
    sp_forecast f = {0};
    sp_status status = SP_OK;
    name_parts(study, &f);
    for (int64_t c = 0; c < l.combinations && status == SP_OK; c++)
        status = look_through(&l, c, &f, err);
    if (status == SP_OK)
        *out = f;
    return status;
}
