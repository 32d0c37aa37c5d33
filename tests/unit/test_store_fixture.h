#ifndef TEST_STORE_FIXTURE_H
#define TEST_STORE_FIXTURE_H
/* Folders, random packings and comparisons for the tests of the store room. */

#include "test.h"

#include "base/base.h"
#include "packing/geometry.h"

#include <dirent.h>
#include <sonopack/study/store.h>
#include <unistd.h>

/* A small generator of its own: what it draws need only be arbitrary, and the same every time. */
static inline uint64_t fixture_next(uint64_t *state) {
    uint64_t z = (*state += 0x9e3779b97f4a7c15u);
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
    return z ^ (z >> 31);
}

static inline double fixture_uniform(uint64_t *state) { return (double)(fixture_next(state) >> 11) * 0x1p-53; }

static inline char *fixture_folder(void) {
    static char folder[] = "/tmp/sonopack-store-XXXXXX";
    strcpy(folder + strlen(folder) - 6, "XXXXXX");
    assert_non_null(mkdtemp(folder));
    return folder;
}

/* DIR/NAME in one of a few static buffers. */
static inline const char *fixture_path(const char *folder, const char *name) {
    static char path[4][512];
    static int next;
    next = (next + 1) % 4;
    snprintf(path[next], sizeof path[next], "%s/%s", folder, name);
    return path[next];
}

static inline int fixture_count_files(const char *folder) {
    DIR *d = opendir(folder);
    assert_non_null(d);
    int count = 0;
    for (struct dirent *e; (e = readdir(d));)
        count += strcmp(e->d_name, ".") != 0 && strcmp(e->d_name, "..") != 0 &&
                 strcmp(e->d_name, "manifest.tsv") != 0 && strcmp(e->d_name, ".sonopack-lock") != 0;
    closedir(d);
    return count;
}

static inline void fixture_remove(const char *folder) {
    DIR *d = opendir(folder);
    if (!d)
        return;
    for (struct dirent *e; (e = readdir(d));)
        if (strcmp(e->d_name, ".") != 0 && strcmp(e->d_name, "..") != 0)
            unlink(fixture_path(folder, e->d_name));
    closedir(d);
    rmdir(folder);
}

/* The folder of a test: set up before it, removed after it. */
static char *folder;

static inline int make_folder(void **state) {
    (void)state;
    folder = fixture_folder();
    return 0;
}

static inline int remove_folder(void **state) {
    (void)state;
    fixture_remove(folder);
    return 0;
}
#define TEST_IN_FOLDER(name) TEST_BETWEEN(name, make_folder, remove_folder)

static inline void fixture_write(const char *path, const char *text) {
    FILE *f = fopen(path, "wb");
    assert_non_null(f);
    assert_int_equal(fwrite(text, 1, strlen(text), f), strlen(text));
    fclose(f);
}

static inline void fixture_normal(uint64_t *state, int dim, double n[3]) {
    double length2 = 0;
    while (length2 < 0.01 || length2 > 1) {
        length2 = 0;
        for (int k = 0; k < dim; k++) {
            n[k] = 2 * fixture_uniform(state) - 1;
            length2 += n[k] * n[k];
        }
    }
    for (int k = 0; k < dim; k++)
        n[k] /= sqrt(length2);
    if (dim == 1)
        n[0] = n[0] > 0 ? 1 : -1;
}

static inline sp_contact fixture_contact(uint64_t *state, int dim, int32_t i, int32_t j) {
    sp_contact c = {.i = i, .j = j};
    fixture_normal(state, dim, c.n);
    c.overlap = 0.1 * fixture_uniform(state);
    c.fn = 1e-4 * fixture_uniform(state);
    if (dim == 2) {
        double ft = 1e-5 * (fixture_uniform(state) - 0.5);
        c.ft[0] = ft * -c.n[1] + 0.0;
        c.ft[1] = ft * c.n[0] + 0.0;
    } else if (dim == 3) {
        double v[3], along = 0;
        fixture_normal(state, dim, v);
        for (int k = 0; k < 3; k++)
            along += v[k] * c.n[k];
        for (int k = 0; k < 3; k++)
            c.ft[k] = 1e-5 * (v[k] - along * c.n[k]);
    }
    return c;
}

/* Full of arbitrary bits, and of sound structure; physics it has none. */
static inline sp_packing fixture_packing(uint64_t seed, int dim, int32_t n) {
    sp_packing p;
    uint64_t state = seed;
    assert_ok(sp_packing_alloc(&p, dim, n, n - 1 + (n + 1) / 2 + n / 3, &err));
    for (int k = 0; k < dim; k++)
        p.box[k] = 5 + 20 * fixture_uniform(&state);
    for (int32_t i = 0; i < n; i++) {
        p.r[i] = 0.4 + 0.2 * fixture_uniform(&state);
        for (int k = 0; k < dim; k++)
            p.x[3 * i + k] = p.box[k] * fixture_uniform(&state);
    }
    int32_t c = 0;
    for (int32_t i = 0; i + 1 < n; i++)
        p.contacts[c++] = fixture_contact(&state, dim, i, i + 1);
    for (int32_t i = 0; i < n; i += 2)
        p.contacts[c++] = fixture_contact(&state, dim, i, SP_BOTTOM);
    for (int32_t i = 0; i + 2 < n; i += 3)
        p.contacts[c++] = fixture_contact(&state, dim, i, SP_TOP);
    p.n_contacts = c;
    p.pressure = 1e-4 * (1 + fixture_uniform(&state));
    p.friction = fixture_uniform(&state);
    p.poisson = 0.5 * fixture_uniform(&state);
    p.wall = seed % 2 ? SP_WALL_GRAIN : SP_WALL_RIGID;
    p.seed = fixture_next(&state);
    p.steps = (int64_t)(fixture_next(&state) >> 2);
    p.residual = seed % 3 ? fixture_uniform(&state) : NAN;
    p.seconds = fixture_uniform(&state);
    if (seed % 4) {
        p.scene = sp_strdup("packing = { kind = \"piston\"; };\n");
        assert_non_null(p.scene);
    }
    assert_ok(sp_packing_check(&p, &err));
    return p;
}

/* The same in a cell of another kind, with gravity: a tilted periodic one, or one with contacts at all walls. */
static inline sp_packing fixture_cell(uint64_t seed, int dim, int32_t n, sp_cell cell) {
    sp_packing p = fixture_packing(seed, dim, n);
    uint64_t state = ~seed;
    p.cell = cell;
    p.gravity = seed % 3 ? 1e-6 * fixture_uniform(&state) : 0;
    for (int k = 0; cell == SP_CELL_PERIODIC && seed % 5 && k < (dim == 3 ? 3 : dim - 1); k++)
        p.tilt[k] = (fixture_uniform(&state) - 0.5) * p.box[k == 2];
    for (int32_t i = 0; i < n; i++) /* positions were fractions of the edges */
        for (int a = 1; a < dim; a++)
            for (int b = 0; b < a; b++)
                p.x[3 * i + b] += p.x[3 * i + a] / p.box[a] * p.tilt[a == 1 ? 0 : 1 + b];
    for (int32_t i = 0; i < n; i++)
        if (cell == SP_CELL_PERIODIC)
            sp_packing_wrap(&p, p.x + 3 * i);
    int32_t kept = 0;
    for (int32_t c = 0; c < p.n_contacts; c++) {
        const bool bottom = p.contacts[c].j == SP_BOTTOM;
        p.contacts[kept] = p.contacts[c];
        if (cell == SP_CELL_BOX && bottom)
            p.contacts[kept].j = -1 - p.contacts[c].i % (2 * dim);
        kept += p.contacts[c].j >= 0 || (cell == SP_CELL_BOX && bottom);
    }
    p.n_contacts = kept;
    sp_packing_sort(&p);
    assert_ok(sp_packing_check(&p, &err));
    return p;
}

static inline void assert_same_bits(const char *what, const double *a, const double *b, int64_t count) {
    for (int64_t k = 0; k < count; k++)
        if (memcmp(&a[k], &b[k], sizeof *a) != 0)
            fail_msg("%s[%lld]: %.17g and %.17g differ", what, (long long)k, a[k], b[k]);
}

/* Whether the sink has a sample with these parts; its signal as test_store_samples.c makes one. */
static inline bool fixture_has(const sp_study_sink *sink, const char *name, unsigned want) {
    sp_scene scene = sp_scene_default();
    scene.want = want;
    scene.signal.points = 3;
    scene.signal.until = 2;
    return sink->has(sink->user, &scene, name) != SP_STORED_NOT;
}

/* Grains, contacts, box and material, bit for bit: what every form keeps. */
static inline void assert_same_packing(const sp_packing *a, const sp_packing *b) {
    assert_int_equal(a->dim, b->dim);
    assert_int_equal(a->n, b->n);
    assert_int_equal(a->n_contacts, b->n_contacts);
    assert_int_equal(a->wall, b->wall);
    assert_int_equal(a->cell, b->cell);
    assert_same_bits("tilt", a->tilt, b->tilt, 3);
    assert_same_bits("gravity", &a->gravity, &b->gravity, 1);
    assert_true(a->seed == b->seed);
    assert_same_bits("x", a->x, b->x, 3 * a->n);
    assert_same_bits("r", a->r, b->r, a->n);
    assert_same_bits("box", a->box, b->box, 3);
    assert_same_bits("pressure", &a->pressure, &b->pressure, 1);
    assert_same_bits("friction", &a->friction, &b->friction, 1);
    assert_same_bits("poisson", &a->poisson, &b->poisson, 1);
    for (int32_t c = 0; c < a->n_contacts; c++) {
        const sp_contact *p = &a->contacts[c], *q = &b->contacts[c];
        assert_int_equal(p->i, q->i);
        assert_int_equal(p->j, q->j);
        assert_same_bits("n", p->n, q->n, 3);
        assert_same_bits("overlap", &p->overlap, &q->overlap, 1);
        assert_same_bits("fn", &p->fn, &q->fn, 1);
        assert_same_bits("ft", p->ft, q->ft, 3);
    }
}

#endif
