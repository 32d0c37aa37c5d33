/* Eight threads at once, each with objects of its own: packings, networks, signals, modes, moduli, spectra and files
 * have the bits that one thread alone gives them (docs/threads.md). */
#include "test.h"

#include <pthread.h>
#include <sonopack/sonopack.h>
#include <sonopack/study/store.h>
#include <stdatomic.h>
#include <unistd.h>

extern void openblas_set_num_threads(int threads) __attribute__((weak));

enum { JOBS = 8, THREADS = 4, ROUNDS = 2 };

/* Every number that a job makes, as bytes. */
typedef struct outcome {
    sp_status status;
    sp_error err;
    char *bytes;
    size_t size;
} outcome;

static void keep(FILE *out, const void *values, size_t count, size_t size) {
    if (values && count > 0)
        fwrite(values, size, count, out);
}

/* ---- the jobs ---------------------------------------------------------------------------------------------------- */

/* Unlike each other: disks and spheres, with friction and without it, of several sizes and pressures. */
static sp_pack_spec spec_of(int job) {
    sp_pack_spec spec = sp_pack_spec_default();
    spec.dim = job % 4 == 3 ? 3 : 2;
    spec.width = spec.dim == 3 ? 5.0 : 8.0;
    spec.grains = 40 + 5 * job;
    spec.pressure = job % 2 ? 1e-4 : 1e-5;
    spec.friction = job % 3 == 2 ? 0.0 : 0.5;
    spec.protocol = SP_PROTOCOL_QUICK;
    spec.seed = (uint64_t)job + 1;
    return spec;
}

static sp_status pack(int job, sp_packing *p, FILE *out, sp_error *err) {
    const sp_pack_spec spec = spec_of(job);
    const sp_status status = sp_packing_make(&spec, NULL, NULL, p, err);
    if (status != SP_OK)
        return status;
    keep(out, p->x, 3 * (size_t)p->n, sizeof *p->x);
    keep(out, p->contacts, (size_t)p->n_contacts, sizeof *p->contacts);
    keep(out, &p->steps, 1, sizeof p->steps);
    return SP_OK;
}

static sp_status signals(const sp_network *net, const sp_packing *p, FILE *out, sp_error *err) {
    static const sp_signal_method methods[] = {SP_SIGNAL_CHEBYSHEV, SP_SIGNAL_DENSE, SP_SIGNAL_VERLET};
    sp_status status = SP_OK;
    for (size_t k = 0; k < sizeof methods / sizeof *methods && status == SP_OK; k++) {
        sp_signal_options ask = sp_signal_options_default();
        FREED(sp_signal) signal = sp_signal_none();
        ask.method = methods[k];
        ask.tolerance = methods[k] == SP_SIGNAL_VERLET ? 1e-3 : 1e-8;
        ask.until = 0.3 * sp_signal_window(sp_packing_height(p), p->pressure);
        ask.points = 200;
        status = sp_signal_make(net, &ask, &signal, err);
        if (status == SP_OK)
            keep(out, signal.f, (size_t)signal.n, sizeof *signal.f);
    }
    return status;
}

static sp_status modes(const sp_network *net, FILE *out, sp_error *err) {
    const sp_modes_options options = sp_modes_options_default();
    const sp_modes_range lowest = sp_modes_range_lowest(10);
    sp_modes_options by_arpack = options;
    by_arpack.solver = SP_SOLVER_ARPACK;
    sp_modes dense = sp_modes_none(), sparse = sp_modes_none(), arpack = sp_modes_none();
    sp_status status = sp_modes_dense(net, &options, &dense, err);
    if (status == SP_OK)
        status = sp_modes_sparse(net, &options, &lowest, &sparse, err);
    if (status == SP_OK) /* its state is static: one search waits for another */
        status = sp_modes_sparse(net, &by_arpack, &lowest, &arpack, err);
    if (status == SP_OK) {
        keep(out, dense.omega, (size_t)dense.n, sizeof *dense.omega);
        keep(out, dense.vectors, (size_t)((dense.n - dense.n_rattler) * dense.dofs), sizeof *dense.vectors);
        keep(out, sparse.omega, (size_t)sparse.n, sizeof *sparse.omega);
        keep(out, arpack.vectors, (size_t)((arpack.n - arpack.n_rattler) * arpack.dofs), sizeof *arpack.vectors);
    }
    sp_modes_free(&arpack);
    sp_modes_free(&dense);
    sp_modes_free(&sparse);
    return status;
}

static sp_status moduli(const sp_network *net, FILE *out, sp_error *err) {
    sp_moduli found;
    const sp_status status = sp_moduli_make(net, 0.6, &found, err);
    if (status == SP_OK)
        keep(out, &found, 1, sizeof found);
    return status;
}

static sp_status spectra(const sp_network *net, FILE *out, sp_error *err) {
    static const double omega[] = {0.05, 0.1};
    sp_dos_options ask = sp_dos_options_default();
    sp_harmonic_options drive = sp_harmonic_options_default();
    sp_dos dos = sp_dos_none();
    sp_harmonic harmonic = sp_harmonic_none();
    ask.method = SP_DOS_KPM;
    drive.omega = omega;
    drive.n = sizeof omega / sizeof *omega;
    drive.damping = 0.05;
    sp_status status = sp_dos_make(net, &ask, &dos, err);
    if (status == SP_OK)
        status = sp_harmonic_make(net, &drive, &harmonic, err);
    if (status == SP_OK) {
        keep(out, dos.smooth, (size_t)dos.bins, sizeof *dos.smooth);
        keep(out, harmonic.f, 2 * (size_t)harmonic.n, sizeof *harmonic.f);
    }
    sp_dos_free(&dos);
    sp_harmonic_free(&harmonic);
    return status;
}

/* Through HDF5 and back. The name of the file is this thread's alone. */
static sp_status files(const sp_packing *p, const char *folder, FILE *out, sp_error *err) {
    static atomic_int number;
    char path[300];
    const int own = atomic_fetch_add(&number, 1);
    snprintf(path, sizeof path, "%s/%d.h5", folder, own);
    sp_packing back = sp_packing_none();
    sp_status status = sp_packing_save(p, path, err);
    if (status == SP_OK)
        status = sp_packing_read(path, &back, err);
    if (status == SP_OK)
        keep(out, back.contacts, (size_t)back.n_contacts, sizeof *back.contacts);
    sp_packing_free(&back);
    unlink(path);
    return status;
}

static sp_status all_of(int job, const char *folder, FILE *out, sp_error *err) {
    const sp_network_options options = sp_network_options_default();
    sp_packing p = sp_packing_none();
    sp_network net = sp_network_none();
    sp_status status = pack(job, &p, out, err);
    if (status == SP_OK)
        status = sp_network_make(&p, &options, &net, err);
    if (status == SP_OK)
        status = signals(&net, &p, out, err);
    if (status == SP_OK)
        status = modes(&net, out, err);
    if (status == SP_OK)
        status = moduli(&net, out, err);
    if (status == SP_OK)
        status = spectra(&net, out, err);
    if (status == SP_OK)
        status = files(&p, folder, out, err);
    sp_network_free(&net);
    sp_packing_free(&p);
    return status;
}

/* ---- threads ----------------------------------------------------------------------------------------------------- */

static outcome do_job(int job, const char *folder) {
    outcome o = {.status = SP_ENOMEM};
    FILE *out = open_memstream(&o.bytes, &o.size);
    if (!out)
        return o;
    o.status = all_of(job, folder, out, &o.err);
    if (fclose(out) != 0 && o.status == SP_OK)
        o.status = SP_ENOMEM;
    return o;
}

typedef struct worker {
    pthread_t thread;
    int number;
    const char *folder;
    outcome made[ROUNDS];
} worker;

/* Every job is done by ROUNDS threads, each time beside other jobs. Nothing is asserted here: cmocka's asserts leave
 * the test by a jump, which a thread of its own must not. */
static int job_of(int thread, int round) { return (thread + 3 * round) % JOBS; }

static void *work(void *data) {
    worker *w = data;
    for (int round = 0; round < ROUNDS; round++)
        w->made[round] = do_job(job_of(w->number, round), w->folder);
    return NULL;
}

static void compare(const outcome *made, const outcome *alone, int job) {
    if (made->status != SP_OK)
        fail_msg("job %d: %s", job, made->err.text);
    assert_int_equal(made->size, alone->size);
    for (size_t k = 0; k < made->size; k++)
        if (made->bytes[k] != alone->bytes[k])
            fail_msg("job %d: byte %zu of %zu differs", job, k, made->size);
}

TEST(threads_make_what_one_makes) {
    static worker team[THREADS];
    outcome alone[JOBS];
    char folder[] = "/tmp/sonopack-threads-XXXXXX";
    assert_non_null(mkdtemp(folder));
    for (int job = 0; job < JOBS; job++) {
        alone[job] = do_job(job, folder);
        if (alone[job].status != SP_OK)
            fail_msg("job %d alone: %s", job, alone[job].err.text);
        assert_true(alone[job].size > 10000);
    }
    for (int t = 0; t < THREADS; t++) {
        team[t] = (worker){.number = t, .folder = folder};
        assert_int_equal(pthread_create(&team[t].thread, NULL, work, &team[t]), 0);
    }
    for (int t = 0; t < THREADS; t++)
        pthread_join(team[t].thread, NULL);
    for (int t = 0; t < THREADS; t++)
        for (int round = 0; round < ROUNDS; round++) {
            compare(&team[t].made[round], &alone[job_of(t, round)], job_of(t, round));
            free(team[t].made[round].bytes);
        }
    for (int job = 0; job < JOBS; job++)
        free(alone[job].bytes);
    rmdir(folder);
}

/* ---- one network, many readers ----------------------------------------------------------------------------------- */

typedef struct reader {
    pthread_t thread;
    const sp_packing *packing;
    const sp_network *net;
    outcome made;
} reader;

static outcome read_network(const sp_packing *p, const sp_network *net) {
    outcome o = {.status = SP_ENOMEM};
    FILE *out = open_memstream(&o.bytes, &o.size);
    if (!out)
        return o;
    o.status = signals(net, p, out, &o.err);
    if (o.status == SP_OK)
        o.status = modes(net, out, &o.err);
    if (o.status == SP_OK)
        o.status = moduli(net, out, &o.err);
    if (fclose(out) != 0 && o.status == SP_OK)
        o.status = SP_ENOMEM;
    return o;
}

static void *read_it(void *data) {
    reader *r = data;
    r->made = read_network(r->packing, r->net);
    return NULL;
}

TEST(threads_share_a_network) {
    static reader team[THREADS];
    const sp_pack_spec spec = spec_of(0);
    const sp_network_options options = sp_network_options_default();
    FREED(sp_packing) p = sp_packing_none();
    FREED(sp_network) net = sp_network_none();
    assert_ok(sp_packing_make(&spec, NULL, NULL, &p, &err));
    assert_ok(sp_network_make(&p, &options, &net, &err));
    outcome alone = read_network(&p, &net);
    assert_int_equal(alone.status, SP_OK);
    for (int t = 0; t < THREADS; t++) {
        team[t] = (reader){.packing = &p, .net = &net};
        assert_int_equal(pthread_create(&team[t].thread, NULL, read_it, &team[t]), 0);
    }
    for (int t = 0; t < THREADS; t++)
        pthread_join(team[t].thread, NULL);
    for (int t = 0; t < THREADS; t++) {
        compare(&team[t].made, &alone, t);
        free(team[t].made.bytes);
    }
    free(alone.bytes);
}

/* As a host that has threads of its own does: OpenBLAS's would wait for each other (the test takes six times as long),
 * and how many they are decides the last bits of sums. */
static void use_one_blas_thread(void) {
    if (openblas_set_num_threads)
        openblas_set_num_threads(1);
}

int main(void) {
    use_one_blas_thread();
    return _cmocka_run_group_tests("tests", test_all, test_count, NULL, NULL);
}
