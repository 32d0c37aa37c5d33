/* Harmonic driving of every hard network against elimination with exchanges of rows in quadruple precision: undamped,
 * from next to nothing to overdamped, between frequencies and beside them, at the wall and through planes. */
#include "stress/exact.h"
#include "stress/networks.h"
#include "stress/record.h"

#include <sonopack/modes.h>
#include <sonopack/spectrum.h>

typedef struct complex_quad {
    quad re, im;
} complex_quad;

static complex_quad times(complex_quad a, complex_quad b) {
    return (complex_quad){a.re * b.re - a.im * b.im, a.re * b.im + a.im * b.re};
}
static complex_quad over(complex_quad a, complex_quad b) {
    const quad size = b.re * b.re + b.im * b.im;
    return (complex_quad){(a.re * b.re + a.im * b.im) / size, (a.im * b.re - a.re * b.im) / size};
}
static quad square(complex_quad a) { return a.re * a.re + a.im * a.im; }

/* Solves H u = b by Gauss's elimination; u replaces b. Destroys h. */
static void eliminate(int n, complex_quad *h, complex_quad *b) {
    for (int c = 0; c < n; c++) {
        int best = c;
        for (int r = c + 1; r < n; r++)
            best = square(h[r * n + c]) > square(h[best * n + c]) ? r : best;
        for (int k = c; k < n && best != c; k++) {
            const complex_quad swap = h[c * n + k];
            h[c * n + k] = h[best * n + k];
            h[best * n + k] = swap;
        }
        const complex_quad swap = b[c];
        b[c] = b[best];
        b[best] = swap;
        for (int r = c + 1; r < n; r++) {
            if (!(square(h[r * n + c]) > 0))
                continue;
            const complex_quad factor = over(h[r * n + c], h[c * n + c]);
            for (int k = c; k <= n; k++) {
                complex_quad *to = k < n ? &h[r * n + k] : &b[r];
                const complex_quad part = times(factor, k < n ? h[c * n + k] : b[c]);
                to->re -= part.re;
                to->im -= part.im;
            }
        }
    }
    for (int r = n - 1; r >= 0; r--) {
        for (int k = r + 1; k < n; k++) {
            const complex_quad part = times(h[r * n + k], b[k]);
            b[r].re -= part.re;
            b[r].im -= part.im;
        }
        b[r] = over(b[r], h[r * n + r]);
    }
}

/* A network and its dashpots as full matrices, with source, detector and planes. */
typedef struct driven_case {
    const sp_network *net;
    const sp_harmonic *h;
    int n, places;
    double zeta;
    quad *k, *c;
    double *source, *springs, *dashpots; /* [n], [places][n] each */
} driven_case;

static bool make_rows(const sp_network *net, const sp_harmonic *h, double *rows) {
    const int64_t n = sp_network_dofs(net);
    const sp_place wall = sp_place_wall();
    sp_error err = {0};
    bool made = sp_network_detector_at(net, &wall, rows, &err) == SP_OK;
    for (int q = 0; q < h->planes && made; q++) {
        const sp_place plane = {.kind = SP_PLACE_PLANE, .height = h->height[q]};
        made = sp_network_detector_at(net, &plane, rows + (1 + q) * n, &err) == SP_OK;
    }
    return made;
}

static driven_case make_case(const sp_network *net, const sp_harmonic *h, double zeta) {
    driven_case d = {.net = net, .h = h, .n = (int)sp_network_dofs(net), .places = 1 + h->planes, .zeta = zeta};
    const size_t n = (size_t)d.n, many = n * (size_t)d.places;
    const sp_place wall = sp_place_wall();
    d.k = exact_stiffness(net);
    d.source = calloc(n, sizeof *d.source);
    d.springs = calloc(many, sizeof *d.springs);
    d.dashpots = calloc(many, sizeof *d.dashpots);
    assert_ok(sp_network_source_at(net, SP_SOURCE_IMPULSE, &wall, d.source, &err));
    assert_true(make_rows(net, h, d.springs));
    if (zeta > 0) {
        FREED(sp_network) dashpots = sp_network_none();
        assert_ok(sp_network_damping(net, zeta, &dashpots, &err));
        d.c = exact_stiffness(&dashpots);
        assert_true(make_rows(&dashpots, h, d.dashpots));
    }
    return d;
}

static void free_case(driven_case *d) {
    free(d->k);
    free(d->c);
    free(d->source);
    free(d->springs);
    free(d->dashpots);
}

/* The worst of the wall and the planes against its bound. */
static void compare(stress_record *r, const char *network, const char *what, const driven_case *d, int l) {
    const int n = d->n;
    const double omega = d->h->omega[l];
    complex_quad *h = calloc((size_t)n * (size_t)n, sizeof *h), *u = calloc((size_t)n, sizeof *u);
    double ratio = -1, error = 0, reported = 1, scale = 0;
    for (int k = 0; k < n * n; k++)
        h[k] = (complex_quad){d->k[k], d->c ? d->c[k] * omega : 0};
    for (int k = 0; k < n; k++) {
        h[k * n + k].re -= (quad)omega * omega * d->net->mass[k];
        u[k].re = d->source[k];
    }
    eliminate(n, h, u);
    for (int q = 0; q < d->places; q++) {
        const int64_t at = (int64_t)l * d->h->planes + q - 1;
        const double *f = q == 0 ? d->h->f + 2 * l : d->h->flux + 2 * at;
        const double bound = q == 0 ? d->h->error[l] : d->h->flux_error[at];
        complex_quad off = {-f[0], -f[1]};
        for (int k = 0; k < n; k++) {
            const complex_quad part =
                times((complex_quad){d->springs[q * n + k], (quad)omega * d->dashpots[q * n + k]}, u[k]);
            off.re += part.re;
            off.im += part.im;
        }
        const double here = (double)quad_sqrt(square(off));
        scale = fmax(scale, hypot(f[0], f[1]));
        if (!(here <= ratio * bound)) {
            ratio = here / bound;
            error = here;
            reported = bound;
        }
    }
    stress_agree(r, network, "harmonic", what, error, reported, scale > 0 ? scale : 1);
    free(h);
    free(u);
}

static void run_one(stress_record *r, const char *network, const sp_network *net, double zeta, double omega,
                    const char *where) {
    sp_harmonic_options o = sp_harmonic_options_default();
    FREED(sp_harmonic) h = sp_harmonic_none();
    sp_error err = {0};
    char what[80];
    snprintf(what, sizeof what, "zeta = %g, %s", zeta, where);
    o.damping = zeta;
    o.n = 1;
    o.omega = &omega;
    o.planes = 3;
    o.tolerance = 1e-3; /* a bound of any size is looked at */
    const sp_status status = sp_harmonic_make(net, &o, &h, &err);
    if (status != SP_OK) {
        stress_refuse(r, network, "harmonic", what, status, &err);
        return;
    }
    driven_case d = make_case(net, &h, zeta);
    compare(r, network, what, &d, 0);
    free_case(&d);
}

/* Frequencies in a gap of the spectrum, beside a mode, far below all and above all. */
static void run(stress_record *r, const stress_case *c, const sp_network *net, const sp_modes *m, uint64_t seed) {
    const int64_t rows = m->n - m->n_zero, at = m->n_zero + rows / 3;
    const double omega = m->omega[at], next = m->omega[at + 1 < m->n ? at + 1 : at], top = m->omega[m->n - 1];
    const struct {
        const char *name;
        double omega;
    } places[] = {{"between modes", 0.55 * omega + 0.45 * next},
                  {"beside a mode, 1e-3", omega * (1 + 1e-3)},
                  {"beside a mode, 1e-7", omega * (1 - 1e-7)},
                  {"on a mode", omega},
                  {"far below", 1e-3 * m->omega[m->n_zero]},
                  {"on the stiffest mode", top},
                  {"above all", 3 * top}};
    const double zetas[] = {1e-6, 1e-3, 0.1, 1};
    enum { PLACES = sizeof places / sizeof *places };
    for (int q = 0; q < PLACES; q++) {
        run_one(r, c->name, net, 0, places[q].omega, places[q].name);
        run_one(r, c->name, net, zetas[((uint64_t)q + seed) % 4], places[q].omega, places[q].name);
    }
}

TEST(test_hard_networks) {
    if (!STRESS_QUAD)
        skip();
    stress_record r = stress_open();
    for (int k = 0; k < STRESS_CASES; k++) {
        const stress_case *c = &stress_cases[k];
        FREED(sp_network) net = c->make(c->value, 1);
        const sp_modes_options o = {.vectors = false};
        FREED(sp_modes) m = sp_modes_none();
        RELEASED double *scratch = calloc((size_t)sp_network_dofs(&net), sizeof *scratch);
        sp_error err = {0};
        const bool walls = sp_network_source(&net, SP_SOURCE_IMPULSE, scratch, &err) == SP_OK &&
                           sp_network_detector(&net, scratch, &err) == SP_OK;
        if (walls && sp_modes_dense(&net, &o, &m, &err) == SP_OK && m.n_zero < m.n)
            run(&r, c, &net, &m, (uint64_t)k);
    }
    stress_close(&r);
    assert_true(r.agreed > 100);
    assert_int_equal(r.wrong, 0);
}

RUN_TESTS(NULL, NULL)
