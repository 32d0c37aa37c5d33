#ifndef TEST_REFERENCE_H
#define TEST_REFERENCE_H
/* The reference packings and signals of packings/reference, read by a reader of their own, and small packings made by
 * hand: so that the rooms of network, modes and signal are tested without those of files and compression. */

#include "packing/contact.h"
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

/* `count` such rows of n balls beside each other, without a spring between them. */
static inline sp_packing chains_packing(int count, int n, double pressure) {
    sp_packing one = chain_packing(n, pressure), p = sp_packing_none();
    assert_ok(sp_packing_alloc(&p, 1, count * n, count * (n + 1), &err));
    for (int c = 0; c < count; c++) {
        memcpy(p.x + 3 * c * n, one.x, 3 * (size_t)n * sizeof *one.x);
        memcpy(p.r + c * n, one.r, (size_t)n * sizeof *one.r);
        for (int k = 0; k <= n; k++) {
            sp_contact *to = &p.contacts[c * (n + 1) + k];
            *to = one.contacts[k];
            to->i += c * n;
            to->j += to->j < 0 ? 0 : c * n;
        }
    }
    memcpy(p.box, one.box, sizeof p.box);
    p.pressure = one.pressure;
    p.wall = one.wall;
    sp_packing_free(&one);
    sp_packing_sort(&p);
    return p;
}

/* Overlapping grains scattered around a square or cubic lattice, cells^dim of them, every overlap a contact: no
 * equilibrium, but all kinds of springs in general position. */
static inline sp_packing scattered_packing(int dim, int cells, double friction, unsigned seed) {
    const double spacing = 0.9;
    const int n = dim == 2 ? cells * cells : cells * cells * cells, up = dim - 1;
    sp_packing p = sp_packing_none();
    int count = 0;
    assert_ok(sp_packing_alloc(&p, dim, n, 16 * n, &err));
    srand(seed);
    for (int a = 0; a < 3; a++)
        p.box[a] = a < dim ? cells * spacing : 1;
    for (int i = 0, rest = 0; i < n; i++) {
        rest = i;
        for (int a = 0; a < dim; a++, rest /= cells)
            p.x[3 * i + a] = spacing * (rest % cells + 0.5 + 0.1 * (rand() / (double)RAND_MAX - 0.5));
        p.r[i] = 0.46 + 0.1 * (rand() / (double)RAND_MAX);
    }
    p.pressure = 1e-4;
    p.friction = friction;
    p.poisson = 0.2;
    for (int i = 0; i < n; i++) {
        for (int j = i + 1; j < n; j++) {
            sp_contact c = {.i = i, .j = j};
            double d[3] = {0}, r = 0;
            for (int a = 0; a < dim; a++) {
                d[a] = p.x[3 * j + a] - p.x[3 * i + a];
                if (a != up)
                    d[a] -= p.box[a] * round(d[a] / p.box[a]);
                r += d[a] * d[a];
            }
            r = sqrt(r);
            c.overlap = p.r[i] + p.r[j] - r;
            if (c.overlap <= 0)
                continue;
            for (int a = 0; a < dim; a++)
                c.n[a] = d[a] / r;
            c.fn = contact_force(contact_stiffness(p.r[i], p.r[j]), c.overlap);
            p.contacts[count++] = c;
        }
        for (int wall = 0; wall < 2; wall++) {
            sp_contact c = {.i = i, .j = wall ? SP_TOP : SP_BOTTOM};
            const double x = p.x[3 * i + up];
            c.overlap = p.r[i] - (wall ? p.box[up] - x : x);
            if (c.overlap <= 0)
                continue;
            c.n[up] = wall ? 1 : -1;
            c.fn = contact_force(contact_wall_stiffness(p.r[i], p.wall), c.overlap);
            p.contacts[count++] = c;
        }
    }
    p.n_contacts = count;
    sp_packing_sort(&p);
    return p;
}

#endif
