/* Files of modes: round trips bit for bit, one row at a time, and what is refused. The errors of vectors are bounds. */
#include "reference.h"
#include "test_store_fixture.h"

#include <signal.h>
#include <sonopack/study/modes_file.h>
#include <sys/resource.h>

/* A packing, its network, and modes of it. */
typedef struct made {
    sp_packing p;
    sp_network net;
    sp_modes m;
    sp_modes_made how;
} made;

static made make(sp_packing p, sp_modes_range range) {
    made x = {.p = p, .how = {.network = sp_network_options_default(), .source = SP_SOURCE_VELOCITY}};
    const sp_modes_options o = {.vectors = true, .source = x.how.source};
    x.how.network.threshold = 0;
    assert_ok(sp_network_make(&x.p, &x.how.network, &x.net, &err));
    assert_ok(sp_modes_make(&x.net, &o, &range, &x.m, &err));
    return x;
}

static void clear(made *x) {
    sp_modes_free(&x->m);
    sp_network_free(&x->net);
    sp_packing_free(&x->p);
}

static void same(const double *a, const double *b, int64_t n) { assert_memory_equal(a, b, (size_t)n * sizeof *a); }

static void compare(const made *x, const sp_modes_file *f) {
    const sp_modes *m = &x->m, *g = &f->modes;
    assert_true(m->n == g->n && m->n_rattler == g->n_rattler && m->n_zero == g->n_zero && m->dofs == g->dofs);
    assert_true(m->first == g->first && m->on_edge == g->on_edge && m->solver == g->solver &&
                !memcmp(&m->zero, &g->zero, sizeof m->zero));
    same(m->omega, g->omega, m->n);
    same(m->error, g->error, m->n);
    same(m->a, g->a, m->n);
    same(m->b, g->b, m->n);
    same(m->participation, g->participation, m->n);
    same(&m->certified_from, &g->certified_from, 1);
    same(&m->certified_to, &g->certified_to, 1);
    same(&m->residual, &g->residual, 1);
    same(&m->orthogonality, &g->orthogonality, 1);
    assert_true(f->n == x->net.n && f->dim == x->p.dim && f->dof == x->net.dof);
    assert_memory_equal(f->grain, x->net.grain, (size_t)f->n * sizeof *f->grain);
    same(f->mass, x->net.mass, m->dofs);
    assert_true(f->made.source == x->how.source && f->made.network.threshold == 0 && !f->made.network.prestress);
    assert_true(f->packing == sp_packing_hash(&x->p) && !g->vectors);
}

static void round_trip(sp_packing p, sp_modes_range range) {
    made x = make(p, range);
    const char *path = fixture_path(folder, "m.h5");
    const int64_t n = x.m.dofs, rows = x.m.n - x.m.n_rattler;
    FREED(sp_modes_file) f = sp_modes_file_none();
    RELEASED double *e = malloc((size_t)(rows * n + 1) * sizeof *e);
    assert_ok(sp_modes_save(&x.m, &x.p, &x.net, &x.how, path, &err));
    assert_ok(sp_modes_file_read(path, &x.p, &f, &err));
    compare(&x, &f);
    assert_ok(sp_modes_file_vectors(path, &f, f.modes.n_rattler, rows, e, &err));
    same(e, x.m.vectors, rows * n);
    for (int64_t k = 0; k < rows; k += 1 + rows / 7) { /* alone */
        assert_ok(sp_modes_file_vectors(path, &f, f.modes.n_rattler + k, 1, e, &err));
        same(e, x.m.vectors + k * n, n);
    }
    assert_int_equal(fixture_count_files(folder), 1);
    clear(&x);
}

TEST_IN_FOLDER(every_bit_returns) {
    round_trip(chain_packing(30, 1e-4), sp_modes_range_all());
    for (int dim = 2; dim <= 3; dim++) {
        round_trip(scattered_packing(dim, 4, 0.5, 3), sp_modes_range_all());
        round_trip(scattered_packing(dim, 4, 0, 4), sp_modes_range_lowest(9));
    }
    round_trip(reference_packing(SOURCE_DIR "/packings/reference/packing_N200_p1e-4.txt"),
               sp_modes_range_band(0.3, 0.5));
    round_trip(reference_packing(SOURCE_DIR "/packings/reference/packing_N200_p1e-4.txt"), sp_modes_range_band(50, 60));
}

TEST_IN_FOLDER(without_walls) {
    sp_packing p = reference_packing(SOURCE_DIR "/packings/reference/packing_N200_p1e-4.txt");
    while (p.n_contacts > 0 && p.contacts[p.n_contacts - 1].j < 0)
        p.n_contacts--;
    round_trip(p, sp_modes_range_lowest(12)); /* a and b are NAN */
}

TEST_IN_FOLDER(wrong_calls_are_refused) {
    made x = make(scattered_packing(2, 4, 0.5, 3), sp_modes_range_all());
    FREED(sp_packing) other = scattered_packing(2, 4, 0.5, 4);
    FREED(sp_modes_file) f = sp_modes_file_none();
    const char *path = fixture_path(folder, "m.h5");
    RELEASED double *e = malloc((size_t)x.m.dofs * sizeof *e);
    assert_ok(sp_modes_save(&x.m, &x.p, &x.net, &x.how, path, &err));
    assert_fails(sp_modes_file_read(path, &other, &f, &err), SP_EFORMAT, "/modes/packing");
    assert_fails(sp_modes_file_read(fixture_path(folder, "no.h5"), &x.p, &f, &err), SP_EIO, "no.h5");
    assert_ok(sp_modes_file_read(path, &x.p, &f, &err));
    assert_fails(sp_modes_file_vectors(path, &f, f.modes.n, 1, e, &err), SP_EINVAL, "m.h5");
    assert_fails(sp_modes_file_vectors(path, &f, f.modes.n_rattler - 1, 1, e, &err), SP_EINVAL, "m.h5");
    assert_fails(sp_modes_file_vectors(path, &f, f.modes.n_rattler, f.modes.n + 1, e, &err), SP_EINVAL, "m.h5");
    assert_fails(sp_modes_save(&x.m, &x.p, &x.net, &x.how, fixture_path(folder, "no/m.h5"), &err), SP_EIO, "m.h5");
    assert_fails(sp_modes_save(&x.m, &x.p, &x.net, &x.how, "/dev/null", &err), SP_EIO, "/dev/null");
    double *vectors = x.m.vectors;
    x.m.vectors = NULL;
    assert_fails(sp_modes_save(&x.m, &x.p, &x.net, &x.how, path, &err), SP_EINVAL, "vectors");
    x.m.vectors = vectors;
    assert_int_equal(fixture_count_files(folder), 1);
    clear(&x);
}

/* A disk that is full in the middle of the vectors: an error, the old file, and nothing else. */
TEST_IN_FOLDER(full_disk) {
    made x = make(scattered_packing(2, 9, 0.5, 3), sp_modes_range_all());
    const char *path = fixture_path(folder, "m.h5");
    FREED(sp_modes_file) f = sp_modes_file_none();
    struct rlimit before, less;
    assert_ok(sp_modes_save(&x.m, &x.p, &x.net, &x.how, path, &err));
    getrlimit(RLIMIT_FSIZE, &before);
    signal(SIGXFSZ, SIG_IGN);
    for (rlim_t size = 0; size < 8 * (rlim_t)(x.m.dofs * x.m.dofs); size += 50000) {
        less = before;
        less.rlim_cur = size;
        setrlimit(RLIMIT_FSIZE, &less);
        sp_error err = {0};
        const sp_status status = sp_modes_save(&x.m, &x.p, &x.net, &x.how, path, &err);
        setrlimit(RLIMIT_FSIZE, &before);
        assert_int_equal(status, SP_EIO);
        assert_int_equal(fixture_count_files(folder), 1);
    }
    signal(SIGXFSZ, SIG_DFL);
    assert_ok(sp_modes_file_read(path, &x.p, &f, &err));
    compare(&x, &f);
    clear(&x);
}

/* Vectors of the dense solver and of Lanczos differ by no more than both of their errors allow, with either sign. */
TEST(errors_of_vectors_are_bounds) {
    made x = make(scattered_packing(2, 6, 0.5, 5), sp_modes_range_all());
    const sp_modes_options o = {.vectors = true};
    const sp_modes_range range = sp_modes_range_lowest(25);
    FREED(sp_modes) part = sp_modes_none();
    assert_ok(sp_modes_sparse(&x.net, &o, &range, &part, &err));
    int known = 0;
    for (int64_t k = part.n_rattler; k < part.n; k++) {
        const double *e = x.m.vectors + (k - x.m.n_rattler) * x.m.dofs,
                     *f = part.vectors + (k - part.n_rattler) * x.m.dofs;
        const double bound = sp_modes_vector_error(&x.m, &x.net, k) + sp_modes_vector_error(&part, &x.net, k);
        double minus = 0, plus = 0;
        for (int64_t c = 0; c < x.m.dofs; c++) {
            minus += (e[c] - f[c]) * (e[c] - f[c]);
            plus += (e[c] + f[c]) * (e[c] + f[c]);
        }
        assert_true(sqrt(fmin(minus, plus)) <= bound + 1e-14);
        known += bound < 1e-6;
    }
    assert_true(known > 5);
    clear(&x);
}

TEST_IN_FOLDER(lack_of_memory) {
    made x = make(scattered_packing(2, 4, 0.5, 3), sp_modes_range_all());
    const char *path = fixture_path(folder, "m.h5");
    for (long after = 0, done = 0; !done; after++) {
        FREED(sp_modes_file) f = sp_modes_file_none();
        sp_error err = {0};
        sp_alloc_fail_after(after);
        sp_status status = sp_modes_save(&x.m, &x.p, &x.net, &x.how, path, &err);
        if (status == SP_OK)
            status = sp_modes_file_read(path, &x.p, &f, &err);
        sp_alloc_fail_after(-1);
        done = status == SP_OK;
        assert_true(done || (status == SP_ENOMEM && after < 100000));
    }
    clear(&x);
}

RUN_TESTS(NULL, NULL)
