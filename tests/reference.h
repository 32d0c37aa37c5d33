#ifndef TEST_REFERENCE_H
#define TEST_REFERENCE_H
/* The reference packings and signals of packings/reference, read by a reader of their own, and small packings made by
 * hand: so that the rooms of network, modes and signal are tested without those of files and compression. */

#include "packing/contact.h"
#include "packing/geometry.h"
#include "test.h"

#include <sonopack/network.h>
#include <sonopack/packing.h>

#define REFERENCE(name) SOURCE_DIR "/packings/reference/" name

static inline sp_packing reference_packing(const char *path) {
    sp_packing p = sp_packing_none();
    FILE *file = fopen(path, "r");
    char line[512];
    int n, pairs, bottom, top;
    double width, height, pressure, mu, nu;
    unsigned long long seed;
    assert_non_null(file);
    assert_non_null(fgets(line, sizeof line, file));
    assert_int_equal(fscanf(file, "N %d Lx %lf Ly %lf p %lf mu %lf nu %lf contacts %d bottom %d top %d seed %llu", &n,
                            &width, &height, &pressure, &mu, &nu, &pairs, &bottom, &top, &seed),
                     10);
    assert_ok(sp_packing_alloc(&p, 2, n, pairs + bottom + top, &err));
    for (int i = 0; i < n; i++)
        assert_int_equal(fscanf(file, "%lf %lf %lf %*d", &p.x[3 * i], &p.x[3 * i + 1], &p.r[i]), 3);
    for (int k = 0; k < p.n_contacts; k++) {
        sp_contact *c = &p.contacts[k];
        double ft;
        assert_int_equal(
            fscanf(file, "%d %d %lf %lf %lf %lf %lf", &c->i, &c->j, &c->n[0], &c->n[1], &c->overlap, &c->fn, &ft), 7);
        c->ft[0] = -ft * c->n[1];
        c->ft[1] = ft * c->n[0];
    }
    fclose(file);
    p.box[0] = width;
    p.box[1] = height;
    p.box[2] = 1;
    p.pressure = pressure;
    p.friction = mu;
    p.poisson = nu;
    p.wall = SP_WALL_RIGID;
    sp_packing_sort(&p);
    return p;
}

static inline sp_network network_by(const sp_packing *p, sp_network_options o) {
    sp_network net = sp_network_none();
    assert_ok(sp_network_make(p, &o, &net, &err));
    return net;
}

static inline sp_network default_network(const sp_packing *p) { return network_by(p, sp_network_options_default()); }

/* The network with options other than the usual ones: network_with(&p, .prestress = true). */
#define network_with(p, ...) network_by(p, (sp_network_options){.threshold = 1e-4, __VA_ARGS__})

/* Normal forces alone: with prestress its stiffness is still symmetric. */
static inline sp_packing without_tangential(sp_packing p) {
    for (int k = 0; k < p.n_contacts; k++)
        memset(p.contacts[k].ft, 0, sizeof p.contacts[k].ft);
    return p;
}

/* Columns t, F_vel, F_imp; returns the number of rows, at most `most`. */
static inline int reference_signal(const char *path, int most, double *t, double *velocity, double *impulse) {
    FILE *file = fopen(path, "r");
    char line[1024];
    int n = 0;
    assert_non_null(file);
    while (n < most && fgets(line, sizeof line, file))
        if (sscanf(line, "%lf %lf %lf", &t[n], &velocity[n], &impulse[n]) == 3)
            n++;
    fclose(file);
    return n;
}

/* n equal balls in a row, all springs equal (Somfai et al. 2005, Appendix C). */
static inline sp_packing chain_packing(int n, double pressure) {
    sp_packing p = sp_packing_none();
    assert_ok(sp_packing_alloc(&p, 1, n, n + 1, &err));
    const double e = contact_stiffness(0.5, 0.5), overlap = contact_overlap(e, pressure);
    for (int i = 0; i < n; i++) {
        p.r[i] = 0.5;
        p.x[3 * i] = 0.5 - overlap + i * (1 - overlap);
    }
    for (int k = 0; k <= n; k++) {
        sp_contact *c = &p.contacts[k];
        *c = (sp_contact){.i = k == 0 ? 0 : k - 1, .j = k == 0 ? SP_BOTTOM : k == n ? SP_TOP : k};
        c->n[0] = k == 0 ? -1 : 1;
        c->overlap = overlap;
        c->fn = contact_force(e, overlap);
    }
    p.box[0] = n - (n + 1) * overlap;
    p.box[1] = p.box[2] = 1;
    p.pressure = pressure;
    p.wall = SP_WALL_GRAIN;
    sp_packing_sort(&p);
    return p;
}

/* `copies` of a packing that do not touch: every eigenvalue that many times. */
static inline sp_packing copies_of(sp_packing one, int copies) {
    sp_packing p = sp_packing_none();
    assert_ok(sp_packing_alloc(&p, one.dim, copies * one.n, copies * one.n_contacts, &err));
    for (int c = 0; c < copies; c++) {
        memcpy(p.x + 3 * c * one.n, one.x, 3 * (size_t)one.n * sizeof *one.x);
        memcpy(p.r + c * one.n, one.r, (size_t)one.n * sizeof *one.r);
        for (int k = 0; k < one.n_contacts; k++) {
            sp_contact *to = &p.contacts[c * one.n_contacts + k];
            *to = one.contacts[k];
            to->i += c * one.n;
            to->j += to->j < 0 ? 0 : c * one.n;
        }
    }
    memcpy(p.box, one.box, sizeof p.box);
    p.pressure = one.pressure;
    p.friction = one.friction;
    p.poisson = one.poisson;
    p.wall = one.wall;
    sp_packing_sort(&p);
    sp_packing_free(&one);
    return p;
}

/* `count` rows of n balls beside each other, without a spring between them. */
static inline sp_packing chains_packing(int count, int n, double pressure) {
    return copies_of(chain_packing(n, pressure), count);
}

/* Adds the contacts of all grains that overlap, and the pressure that they have. Few grains: all pairs. */
static inline void add_contacts(sp_packing *p) {
    double trace = 0;
    free(p->contacts);
    p->contacts = calloc((size_t)p->n * 20, sizeof *p->contacts);
    p->n_contacts = 0;
    for (int i = 0; i < p->n; i++)
        for (int j = SP_BACK; j < p->n; j++) {
            sp_contact c = {.i = i, .j = j};
            double d[3] = {0}, r = 0;
            if (j < 0 ? !sp_packing_has_wall(p, j) : j <= i)
                continue;
            if (j < 0)
                d[sp_packing_wall_axis(p, j)] = sp_packing_wall_side(j) * sp_packing_wall_distance(p, i, j);
            else
                sp_packing_separation(p, i, j, d);
            for (int a = 0; a < 3; a++)
                r += d[a] * d[a];
            r = sqrt(r);
            c.overlap = p->r[i] + (j < 0 ? 0 : p->r[j]) - r;
            if (!(c.overlap > 0))
                continue;
            for (int a = 0; a < 3; a++)
                c.n[a] = d[a] / r;
            c.fn = contact_force(contact_stiffness_in(p, i, j), c.overlap);
            trace += c.fn * r;
            assert_true(p->n_contacts < 20 * p->n);
            p->contacts[p->n_contacts++] = c;
        }
    p->pressure = trace / (p->dim * sp_packing_volume(p));
    sp_packing_sort(p);
}

/* Overlapping grains scattered around a square or cubic lattice, cells^dim of them, every overlap a contact: no
 * equilibrium, but all kinds of springs in general position. */
static inline sp_packing scattered_packing(int dim, int cells, double friction, unsigned seed) {
    const double spacing = 0.9;
    const int n = dim == 2 ? cells * cells : cells * cells * cells;
    sp_packing p = sp_packing_none();
    assert_ok(sp_packing_alloc(&p, dim, n, 0, &err));
    srand(seed);
    for (int a = 0; a < 3; a++)
        p.box[a] = a < dim ? cells * spacing : 1;
    for (int i = 0, rest = 0; i < n; i++) {
        rest = i;
        for (int a = 0; a < dim; a++, rest /= cells)
            p.x[3 * i + a] = spacing * (rest % cells + 0.5 + 0.1 * (rand() / (double)RAND_MAX - 0.5));
        p.r[i] = 0.46 + 0.1 * (rand() / (double)RAND_MAX);
    }
    p.friction = friction;
    p.poisson = 0.2;
    add_contacts(&p);
    p.pressure = 1e-4;
    return p;
}

/* A square lattice between walls, all alike: waves to the left and to the right have one frequency, and pivots vanish
 * at simple shifts. Without friction each row slides freely. */
static inline sp_packing square_packing(int across, int up, double friction) {
    const double spacing = 0.95;
    sp_packing p = sp_packing_none();
    assert_ok(sp_packing_alloc(&p, 2, across * up, 0, &err));
    for (int i = 0; i < across * up; i++) {
        p.x[3 * i] = spacing * (i % across);
        p.x[3 * i + 1] = 0.45 + spacing * (i / across);
        p.r[i] = 0.5;
    }
    p.box[0] = spacing * across;
    p.box[1] = spacing * (up - 1) + 0.9;
    p.box[2] = 1;
    p.friction = friction;
    add_contacts(&p);
    p.pressure = 1e-4;
    return p;
}

#endif
