/* Damped signals of hard networks against the matrix exponential of the first-order form in quadruple precision. */
#include "stress/exact.h"
#include "stress/networks.h"
#include "stress/record.h"

enum { POINTS = 17 };

/* c = a b, [n][n]. */
static void multiply(int n, const quad *a, const quad *b, quad *c) {
    memset(c, 0, (size_t)n * (size_t)n * sizeof *c);
    for (int i = 0; i < n; i++)
        for (int k = 0; k < n; k++) {
            const quad x = a[i * n + k];
            for (int j = 0; (x > 0 || x < 0) && j < n; j++)
                c[i * n + j] += x * b[k * n + j];
        }
}

/* exp(g h) by Taylor's series of the 2^-s-th part, squared s times; g is overwritten. */
static void exponential(int n, quad *g, quad h, quad *out) {
    const size_t size = (size_t)n * (size_t)n;
    quad *term = calloc(2 * size, sizeof *term), *next = term + size, norm = 0;
    int halvings = 0;
    for (int i = 0; i < n; i++) {
        quad sum = 0;
        for (int j = 0; j < n; j++)
            sum += quad_abs(g[i * n + j]);
        norm = sum > norm ? sum : norm;
    }
    for (norm *= h; norm > 0.5L; norm /= 2)
        halvings++;
    for (size_t k = 0; k < size; k++)
        g[k] *= h / (quad)exp2(halvings);
    for (int i = 0; i < n; i++)
        term[i * n + i] = out[i * n + i] = 1;
    for (int k = 1; k < 30; k++) {
        multiply(n, term, g, next);
        for (size_t q = 0; q < size; q++) {
            term[q] = next[q] / k;
            out[q] += term[q];
        }
    }
    for (int k = 0; k < halvings; k++) {
        multiply(n, out, out, next);
        memcpy(out, next, size * sizeof *out);
    }
    free(term);
}

/* (u, v)' = (v, -M^-1 (K u + C v)); F = detector . u + that of the dashpots . v. u is measured in 1/Omega of v, so that
 * the exponential is well scaled. */
static void exact_damped(const sp_network *net, const sp_network *dashpots, bool velocity, double until, quad *f) {
    const int n = (int)sp_network_dofs(net);
    RELEASED quad *k = exact_stiffness(net), *c = exact_stiffness(dashpots);
    quad *g = calloc(8 * (size_t)(n * n), sizeof *g), *step = g + 4 * n * n;
    quad *state = calloc(4 * (size_t)n, sizeof *state), *next = state + 2 * n;
    double *sent = calloc(3 * (size_t)n, sizeof *sent), *seen = sent + n, *felt = sent + 2 * n;
    const quad scale = net->omega_bound;
    assert_ok(sp_network_source(net, velocity ? SP_SOURCE_IMPULSE : SP_SOURCE_DISPLACEMENT, sent, &err));
    assert_ok(sp_network_detector(net, seen, &err));
    assert_ok(sp_network_detector(dashpots, felt, &err));
    for (int i = 0; i < n; i++) {
        g[i * 2 * n + n + i] = scale;
        for (int j = 0; j < n; j++) {
            g[(n + i) * 2 * n + j] = -k[i * n + j] / net->mass[i] / scale;
            g[(n + i) * 2 * n + n + j] = -c[i * n + j] / net->mass[i];
        }
        if (velocity)
            state[n + i] = (quad)sent[i] / net->mass[i];
        else
            state[i] = sent[i] * scale;
    }
    exponential(2 * n, g, (quad)until / (POINTS - 1), step);
    for (int l = 0; l < POINTS; l++) {
        f[l] = 0;
        for (int i = 0; i < n; i++)
            f[l] += seen[i] * state[i] / scale + felt[i] * state[n + i];
        for (int i = 0; i < 2 * n; i++) {
            next[i] = 0;
            for (int j = 0; j < 2 * n; j++)
                next[i] += step[i * 2 * n + j] * state[j];
        }
        memcpy(state, next, 2 * (size_t)n * sizeof *state);
    }
    free(sent);
    free(state);
    free(g);
}

static void run(stress_record *r, const stress_case *c, const sp_network *net, double zeta, double length) {
    sp_signal_options o = sp_signal_options_default();
    FREED(sp_signal) s = sp_signal_none();
    FREED(sp_network) dashpots = sp_network_none();
    sp_error err = {0};
    char what[80];
    snprintf(what, sizeof what, "damping %g, T = %.0e", zeta, length);
    o.damping = zeta;
    o.source = zeta > 0.5 ? SP_SOURCE_DISPLACEMENT : SP_SOURCE_IMPULSE;
    o.until = length / net->omega_bound;
    o.points = POINTS;
    o.tolerance = 1e-6;
    const sp_status status = sp_signal_make(net, &o, &s, &err);
    if (status != SP_OK) {
        stress_refuse(r, c->name, "faber", what, status, &err);
        return;
    }
    quad f[POINTS], worst = 0, peak = 0;
    assert_int_equal(sp_network_damping(net, zeta, &dashpots, &err), SP_OK);
    exact_damped(net, &dashpots, o.source == SP_SOURCE_IMPULSE, o.until, f);
    for (int l = 0; l < POINTS; l++) {
        const quad off = quad_abs(s.f[l] - f[l]), size = quad_abs(f[l]);
        worst = off > worst ? off : worst;
        peak = size > peak ? size : peak;
    }
    stress_agree(r, c->name, sp_signal_method_name(s.method), what, (double)worst, s.errors[0],
                 peak > 0 ? (double)peak : 1);
}

/* Some of the networks: an exponential takes seconds. */
TEST(test_damped) {
    static const char *const names[] = {"chain",           "p = 1e-9", "kt/kn = 1e6",   "stiffness spread 1e6",
                                        "mass spread 1e6", "floppy",   "one grain, 2D", "one grain, 3D"};
    stress_record r = stress_open();
    for (size_t q = 0; q < sizeof names / sizeof *names; q++)
        for (int k = 0; k < STRESS_CASES; k++) {
            if (strcmp(stress_cases[k].name, names[q]) != 0)
                continue;
            stress_cells = 3; /* 27 degrees of freedom */
            FREED(sp_network) net = stress_cases[k].make(stress_cases[k].value, 1);
            run(&r, &stress_cases[k], &net, 0.1, 30);
            run(&r, &stress_cases[k], &net, 1, 200);
            run(&r, &stress_cases[k], &net, 1e-3, 2000);
        }
    stress_close(&r);
    assert_int_equal(r.wrong, 0);
    assert_true(r.agreed >= 18);
}

RUN_TESTS_WHERE(STRESS_QUAD, NULL, NULL)
