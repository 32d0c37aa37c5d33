/* Decides the order in which the samples of a study are made. */
#include "ensemble/order.h"

#include "base/base.h"

#include <sonopack/study/forecast.h>
#include <stdlib.h>

typedef struct ranked {
    int64_t combination;
    double cost;
} ranked;

static int by_falling_cost(const void *a, const void *b) {
    const ranked *p = a, *q = b;
    if (p->cost > q->cost || p->cost < q->cost)
        return p->cost > q->cost ? -1 : 1;
    return p->combination < q->combination ? -1 : p->combination > q->combination;
}

/* CPU seconds of a sample on the machine of the laws: only ratios matter here. */
static double expected_cost(const sp_scene *scene) {
    const sp_machine machine = sp_machine_reference();
    return sp_sample_expect(scene, &machine);
}

static sp_status rank_combinations(const sp_scene *study, sp_order *o, sp_error *err) {
    ranked *all = sp_alloc((size_t)o->combinations, sizeof *all);
    if (!all)
        return sp_fail_memory(err, (size_t)o->combinations * sizeof *all);
    sp_status status = SP_OK;
    for (int64_t c = 0; c < o->combinations && status == SP_OK; c++) {
        sp_scene scene;
        status = sp_study_scene(study, c, &scene, err);
        if (status == SP_OK)
            all[c] = (ranked){c, o->cost[c] = expected_cost(&scene)};
    }
    if (status == SP_OK)
        qsort(all, (size_t)o->combinations, sizeof *all, by_falling_cost);
    for (int64_t c = 0; c < o->combinations; c++)
        o->longest[c] = all[c].combination;
    sp_free(all);
    return status;
}

sp_status sp_order_make(const sp_scene *study, int shard, int shards, sp_order *out, sp_error *err) {
    sp_order o = {.count = sp_study_count(study)};
    o.combinations = o.count / study->samples;
    o.longest = sp_alloc((size_t)o.combinations, sizeof *o.longest);
    o.cost = sp_alloc((size_t)o.combinations, sizeof *o.cost);
    sp_status status = SP_OK;
    if (!o.longest || !o.cost)
        status = sp_fail_memory(err, (size_t)o.combinations * (sizeof *o.longest + sizeof *o.cost));
    if (status == SP_OK)
        status = rank_combinations(study, &o, err);
    if (status != SP_OK) {
        sp_order_free(&o);
        return status;
    }
    for (int64_t k = shard - 1; k < o.count; k += shards) {
        o.shard_count++;
        o.shard_cost += sp_order_cost(&o, k);
    }
    *out = o;
    return SP_OK;
}

void sp_order_free(sp_order *o) {
    sp_free(o->longest);
    sp_free(o->cost);
    *o = (sp_order){0};
}

int64_t sp_order_sample(const sp_order *o, int64_t place, int shard, int shards) {
    const int64_t round = place / o->combinations;
    const int64_t number = round * o->combinations + o->longest[place % o->combinations];
    return number % shards == shard - 1 ? number : -1;
}

double sp_order_cost(const sp_order *o, int64_t number) { return o->cost[number % o->combinations]; }
