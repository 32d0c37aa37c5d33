/* An ensemble whose results come to a program of one's own, sample by sample, as they are finished.
 *
 * sp_study_run makes every sample of a scene in several threads. What becomes of a sample is the business of a sink:
 * the store (sonopack/study/store.h) writes it to a file, the sink below keeps its results in memory. Its calls come
 * one at a time, whichever thread makes them, so that it needs no lock. A sink may also say what it has already
 * (`has`), and share samples with other processes (`claim`, `release`); this one has nothing and is alone. */
#include <sonopack/sonopack.h>
#include <sonopack/study/study.h>

#include <stdio.h>

static const char scene_text[] = "packing = { width = 10; protocol = \"quick\"; friction = 0.5; };\n"
                                 "study = { samples = 4; want = [\"ctof\"]; sweep = (\n"
                                 "  { key = \"packing.pressure\"; values = [1e-5, 1e-4]; },\n"
                                 "  { key = \"packing.grains\"; values = [60, 180]; } ); };\n";

enum { ROOM = 64 };
typedef struct results {
    int64_t n;
    sp_sample sample[ROOM];
} results;

/* A finished sample. Everything it points to belongs to the study: what is to stay is copied. */
static sp_status take(void *user, const sp_scene *scene, const sp_sample *sample, const sp_packing *packing,
                      const sp_sample_arrays *arrays, sp_error *err) {
    results *r = user;
    (void)scene;
    (void)packing;      /* NULL if it failed: the results then say why */
    (void)arrays;       /* large results, as signals are: none was wanted */
    if (r->n == ROOM) { /* a failure of the sink ends the study, and sp_study_run returns its reason */
        snprintf(err->text, sizeof err->text, "no room for more than %d samples", ROOM);
        return err->status = SP_EFAILED;
    }
    r->sample[r->n++] = *sample;
    if (sample->failed)
        printf("seed %llu failed: %s\n", (unsigned long long)sample->seed, sample->reason);
    else
        printf("p = %g E*, %3d grains, seed %llu: height %5.2f d, the front arrives at %5.1f d/sqrt(E*/rho)\n",
               sample->pressure, (int)sample->grains, (unsigned long long)sample->seed, sample->height,
               sample->front.t10);
    return SP_OK;
}

/* The speed of the front from all samples, a row a pressure, with its bootstrap error. */
static sp_status print_table(const results *r, sp_error *err) {
    sp_table table = sp_table_none();
    sp_status status = sp_study_table("ctof", r->n, r->sample, NULL, &table, err);
    const int p = sp_table_find_column(&table, "p"), c = sp_table_find_column(&table, "c_tof");
    const int error = sp_table_find_column(&table, "c_tof_err");
    for (int64_t row = 0; row < table.rows && status == SP_OK; row++)
        printf("p = %g E*: c_tof = %.4f +- %.4f sqrt(E*/rho)\n", sp_table_number(&table, row, p),
               sp_table_number(&table, row, c), sp_table_number(&table, row, error));
    sp_table_free(&table);
    return status;
}

int main(void) {
    static results r;
    sp_error err = {0};
    sp_scene scene = sp_scene_default();
    const sp_study_sink sink = {.user = &r, .save = take};
    const sp_study_options options = {.jobs = 2, .shard = 1, .shards = 1};
    sp_study_progress progress = {0};
    sp_status status = sp_scene_parse(scene_text, "scene", 0, NULL, &scene, &err);
    if (status == SP_OK)
        status = sp_study_run(&scene, &options, &sink, NULL, NULL, &progress, &err);
    if (status == SP_OK)
        printf("%lld samples, %lld failed, %.1f s\n", (long long)progress.done, (long long)progress.failed,
               progress.seconds);
    if (status == SP_OK)
        status = print_table(&r, &err);
    sp_scene_free(&scene);
    if (status != SP_OK) {
        fprintf(stderr, "%s: %s\n", sp_status_name(status), err.text);
        return 1;
    }
    return progress.failed > 0;
}
