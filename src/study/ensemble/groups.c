/* Sorts samples, and finds groups that may be averaged. */
#include "ensemble/groups.h"

#include "base/base.h"

#include <stdlib.h>
#include <string.h>

#define ORDER(a, b) ((a) < (b) ? -1 : (a) > (b))

static int by_material_and_seed(const sp_sample *a, const sp_sample *b) {
    int order = ORDER(a->pressure, b->pressure);
    order = order ? order : ORDER(a->grains, b->grains);
    order = order ? order : ORDER(a->dim, b->dim);
    order = order ? order : ORDER(a->width, b->width);
    order = order ? order : ORDER(a->friction, b->friction);
    order = order ? order : ORDER(a->kind, b->kind);
    return order ? order : ORDER(a->seed, b->seed);
}

static int in_table(const void *left, const void *right) {
    const sp_sample *a = *(const sp_sample *const *)left, *b = *(const sp_sample *const *)right;
    int order = by_material_and_seed(a, b);
    return order ? order : strcmp(a->name, b->name);
}

static int by_name(const void *left, const void *right) {
    const sp_sample *a = *(const sp_sample *const *)left, *b = *(const sp_sample *const *)right;
    int order = strcmp(a->name, b->name);
    order = order ? order : ORDER(a->failed, b->failed);
    return order ? order : ORDER(b->have, a->have);
}

sp_status sp_samples_sorted(int64_t n, const sp_sample *samples, const sp_sample ***sorted, int64_t *count,
                            sp_error *err) {
    const sp_sample **s = sp_alloc((size_t)n, sizeof(const sp_sample *));
    if (!s)
        return sp_fail_memory(err, (size_t)n * sizeof *s);
    for (int64_t k = 0; k < n; k++)
        s[k] = &samples[k];
    qsort(s, (size_t)n, sizeof *s, by_name);
    int64_t kept = 0;
    for (int64_t k = 0; k < n; k++)
        if (kept == 0 || s[k]->name[0] == '\0' || strcmp(s[k]->name, s[kept - 1]->name) != 0)
            s[kept++] = s[k];
    qsort(s, (size_t)kept, sizeof *s, in_table);
    *sorted = s;
    *count = kept;
    return SP_OK;
}

/* Files of earlier versions have no material, and a failed sample has nothing to average. */
static bool is_known(const sp_sample *s) { return s->material != 0 && !s->failed; }

/* Refuses samples of different materials. Pressure, size, friction and width are not part of the material. */
static sp_status one_material(int64_t n, const sp_sample *const *s, sp_error *err) {
    const sp_sample *first = NULL;
    for (int64_t k = 0; k < n; k++) {
        if (!is_known(s[k]))
            continue;
        if (first && s[k]->material != first->material)
            return sp_fail(err, SP_EREFUSED,
                           "samples %s and %s differ in keys of packing or network, or in signal.source, that have no "
                           "rows here (sizes, protocol, history, poisson, ...) and are not averaged: choose those of "
                           "one scene",
                           first->name, s[k]->name);
        first = s[k];
    }
    return SP_OK;
}

static sp_status same_seed(const sp_sample *a, const sp_sample *b, sp_error *err) {
    return sp_fail(
        err, SP_EREFUSED,
        "samples %s and %s have the same pressure %g, grains %d and seed %llu but come from different scenes: "
        "choose those of one scene",
        a->name, b->name, b->pressure, b->grains, (unsigned long long)b->seed);
}

sp_status sp_samples_alike(int64_t n, const sp_sample *const *s, sp_error *err) {
    for (int64_t k = 1; k < n; k++) {
        const sp_sample *a = s[0], *b = s[k];
        const char *what = ORDER(a->dim, b->dim)             ? "dimension"
                           : ORDER(a->kind, b->kind)         ? "kind"
                           : ORDER(a->width, b->width)       ? "width"
                           : ORDER(a->friction, b->friction) ? "friction"
                                                             : NULL;
        if (what)
            return sp_fail(err, SP_EREFUSED,
                           "samples %s and %s differ in packing.%s (width %g and %g, friction %g and %g) and are not "
                           "averaged: choose those of one width, one friction, or one scene",
                           a->name, b->name, what, a->width, b->width, a->friction, b->friction);
        if (by_material_and_seed(s[k - 1], b) == 0)
            return same_seed(s[k - 1], b, err);
    }
    return one_material(n, s, err);
}

static int by_material(const sp_sample *a, const sp_sample *b) {
    int order = ORDER(a->pressure, b->pressure);
    order = order ? order : ORDER(a->friction, b->friction);
    order = order ? order : ORDER(a->dim, b->dim);
    order = order ? order : ORDER(a->kind, b->kind);
    return order ? order : ORDER(a->width, b->width);
}

static int over_heights(const void *left, const void *right) {
    const sp_sample *a = *(const sp_sample *const *)left, *b = *(const sp_sample *const *)right;
    int order = by_material(a, b);
    order = order ? order : ORDER(a->grains, b->grains);
    order = order ? order : ORDER(a->seed, b->seed);
    return order ? order : strcmp(a->name, b->name);
}

sp_status sp_samples_by_material(int64_t n, const sp_sample **s, sp_error *err) {
    qsort(s, (size_t)n, sizeof *s, over_heights);
    for (int64_t k = 1; k < n; k++)
        if (by_material_and_seed(s[k - 1], s[k]) == 0)
            return same_seed(s[k - 1], s[k], err);
    return one_material(n, s, err);
}

int64_t sp_material_end(int64_t n, const sp_sample *const *s, int64_t begin) {
    int64_t k = begin + 1;
    while (k < n && by_material(s[k], s[begin]) == 0)
        k++;
    return k;
}

int64_t sp_height_end(int64_t n, const sp_sample *const *s, int64_t begin) {
    int64_t k = begin + 1;
    while (k < n && by_material(s[k], s[begin]) == 0 && s[k]->grains == s[begin]->grains)
        k++;
    return k;
}

int64_t sp_pressure_end(int64_t n, const sp_sample *const *s, int64_t begin) {
    int64_t k = begin + 1;
    while (k < n && !ORDER(s[k]->pressure, s[begin]->pressure))
        k++;
    return k;
}

int64_t sp_size_end(int64_t n, const sp_sample *const *s, int64_t begin) {
    int64_t k = begin + 1, end = sp_pressure_end(n, s, begin);
    while (k < end && s[k]->grains == s[begin]->grains)
        k++;
    return k;
}

int64_t sp_samples_failed(int64_t n, const sp_sample *const *s) {
    int64_t failed = 0;
    for (int64_t k = 0; k < n; k++)
        failed += s[k]->failed;
    return failed;
}

int64_t sp_samples_lacking(int64_t n, const sp_sample *const *s, unsigned part) {
    int64_t lacking = 0;
    for (int64_t k = 0; k < n; k++)
        lacking += !s[k]->failed && (s[k]->lacks & ~s[k]->have & part) != 0;
    return lacking;
}
