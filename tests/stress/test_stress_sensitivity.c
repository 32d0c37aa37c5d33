/* Derivatives of signals and frequencies by the stiffness of every spring of every hard network, against those of
 * perturbation theory in quadruple precision: their own error bounds hold, or they are refused. */
#include "network/place.h"
#include "stress/exact.h"
#include "stress/networks.h"
#include "stress/record.h"

#include <sonopack/sensitivity.h>

/* A spring's stretches in vectors over the network: along n, and tangential. */
typedef struct stretches {
    int n;
    quad at[4];
} stretches;

static stretches stretch_of(const sp_network *net, const sp_spring *s, const quad *u) {
    sp_rows rows;
    sp_spring unit = *s;
    stretches x = {0};
    unit.kn = unit.kt = 1;
    unit.kp = 0;
    sp_network_rows(net, &unit, &rows);
    x.n = rows.count;
    for (int q = 0; q < rows.count; q++)
        for (int a = 0; a < rows.width; a++)
            x.at[q] += (quad)rows.b[q][a] * u[(a < net->dof ? s->i : s->j) * net->dof + a % net->dof];
    return x;
}

/* The same for a displacement of its far end. */
static stretches stretch_of_gap(const sp_network *net, const sp_spring *s, const double gap[3]) {
    sp_rows rows;
    sp_spring unit = *s;
    stretches x = {0};
    unit.kn = unit.kt = 1;
    unit.kp = 0;
    sp_network_rows(net, &unit, &rows);
    x.n = rows.count;
    for (int q = 0; q < rows.count; q++)
        for (int a = 0; a < 3; a++)
            x.at[q] += (quad)rows.gap[q][a] * gap[a];
    return x;
}

static void add_product(quad out[2], quad factor, const stretches *x, const stretches *y) {
    out[0] += factor * x->at[0] * y->at[0];
    for (int q = 1; q < x->n; q++)
        out[1] += factor * x->at[q] * y->at[q];
}

/* (s(x) - s(y))/(x - y) of the swing; nearly equal numbers: half way, with a step that loses a third of the digits. */
static quad divided(quad x, quad y, quad scale, quad t, int velocity) {
    const quad step = 1e-11L * quad_abs(x) + 1e-24L * scale; /* slow modes of a wide spectrum bend sooner */
    if (quad_abs(x - y) > step)
        return (quad_swing(x, t, velocity) - quad_swing(y, t, velocity)) / (x - y);
    const quad middle = (x + y) / 2;
    return (quad_swing(middle + step, t, velocity) - quad_swing(middle - step, t, velocity)) / (2 * step);
}

typedef struct problem {
    const sp_network *net;
    const exact *x;
    sp_sensitivity_options o;
    sp_place from, to;
    quad *a, *b, *u;  /* [n] weights of the modes; [n][n] displacements of the modes */
    double *gap[2];   /* [springs][3] */
    quad *g, *row[2]; /* [n][n] divided differences; [n] field, adjoint field */
} problem;

static void make(problem *p) {
    const int n = p->x->n;
    const bool velocity = p->o.source != SP_SOURCE_DISPLACEMENT;
    RELEASED double *sent = calloc((size_t)n, sizeof *sent), *seen = calloc((size_t)n, sizeof *seen);
    p->a = calloc((size_t)n, sizeof *p->a);
    p->b = calloc((size_t)n, sizeof *p->b);
    p->u = calloc((size_t)n * (size_t)n, sizeof *p->u);
    p->g = calloc((size_t)n * (size_t)n, sizeof *p->g);
    for (int q = 0; q < 2; q++) {
        p->gap[q] = calloc(3 * (size_t)p->net->n_springs, sizeof **p->gap);
        p->row[q] = calloc((size_t)n, sizeof **p->row);
        sp_place_gaps(p->net, q == 0 ? &p->from : &p->to, q == 0, p->gap[q]);
    }
    assert_ok(sp_network_source_at(p->net, p->o.source, &p->from, sent, &err));
    assert_ok(sp_network_detector_at(p->net, &p->to, seen, &err));
    for (int m = 0; m < n; m++)
        for (int k = 0; k < n; k++) {
            const quad root = quad_sqrt(p->net->mass[k]), e = p->x->e[m * n + k];
            p->u[m * n + k] = e / root;
            p->a[m] += velocity ? e * sent[k] / root : e * sent[k] * root;
            p->b[m] += e * seen[k] / root;
        }
}

static void drop(problem *p) {
    free(p->a);
    free(p->b);
    free(p->u);
    free(p->g);
    for (int q = 0; q < 2; q++) {
        free(p->gap[q]);
        free(p->row[q]);
    }
}

/* What all springs share at one time. */
static void set_time(problem *p, double t) {
    const int n = p->x->n;
    const bool velocity = p->o.source != SP_SOURCE_DISPLACEMENT;
    const quad scale = p->x->lambda[n - 1];
    for (int k = 0; k < n; k++)
        p->row[0][k] = p->row[1][k] = 0;
    for (int m = 0; m < n; m++) {
        const quad s = quad_swing(p->x->lambda[m], t, velocity);
        for (int k = 0; k < n; k++) {
            const quad mass = p->o.source == SP_SOURCE_IMPULSE ? 1 : (quad)p->net->mass[k];
            p->row[0][k] += p->b[m] * s * p->u[m * n + k] * mass; /* what a source sees */
            p->row[1][k] += p->a[m] * s * p->u[m * n + k];
        }
        for (int q = m; q < n; q++)
            p->g[m * n + q] = p->g[q * n + m] = divided(p->x->lambda[m], p->x->lambda[q], scale, t, velocity);
    }
}

/* dF/dk_n and dF/dk_t of a spring. */
static void differentiate(const problem *p, int k, quad out[2]) {
    const int n = p->x->n;
    const sp_spring *s = &p->net->springs[k];
    RELEASED stretches *x = calloc((size_t)n, sizeof *x);
    out[0] = out[1] = 0;
    for (int m = 0; m < n; m++)
        x[m] = stretch_of(p->net, s, p->u + m * n);
    for (int m = 0; m < n; m++)
        for (int q = 0; q < n; q++)
            add_product(out, p->b[m] * p->a[q] * p->g[m * n + q], &x[m], &x[q]);
    for (int q = 0; q < 2; q++) {
        const stretches field = stretch_of(p->net, s, p->row[q]);
        const stretches gap = stretch_of_gap(p->net, s, p->gap[q] + 3 * k);
        add_product(out, -1, &gap, &field);
    }
}

static void run_time(stress_record *r, const char *name, problem *p, double length, int stride) {
    const double t = length / p->net->omega_bound, one = 1;
    const sp_functional j = {1, &t, &one, NULL};
    FREED(sp_gradient) g = sp_gradient_none();
    sp_error reason = {0};
    char what[64];
    snprintf(what, sizeof what, "source %d, T = %g", (int)p->o.source, length);
    const sp_status status = sp_sensitivity_signal(p->net, &p->o, 1, &j, &g, &reason);
    if (status != SP_OK) {
        stress_refuse(r, name, "gradient", what, status, &reason);
        return;
    }
    set_time(p, t);
    for (int k = 0; k < p->net->n_springs; k += stride) {
        quad d[2];
        differentiate(p, k, d);
        stress_agree(r, name, "kn", what, (double)quad_abs(d[0] - g.kn.d[k]), g.kn.error[k],
                     fabs((double)d[0]) + 1e-300);
        if (g.kt.n > 0 && p->net->springs[k].kt > 0)
            stress_agree(r, name, "kt", what, (double)quad_abs(d[1] - g.kt.d[k]), g.kt.error[k],
                         fabs((double)d[1]) + 1e-300);
    }
}

static void run_case(stress_record *r, const stress_case *c, uint64_t seed) {
    FREED(sp_network) net = c->make(c->value, seed);
    FREED(exact) x = exact_solve(&net);
    static const sp_source sources[] = {SP_SOURCE_IMPULSE, SP_SOURCE_DISPLACEMENT, SP_SOURCE_VELOCITY};
    RELEASED double *scratch = calloc((size_t)sp_network_dofs(&net), sizeof *scratch);
    sp_error reason;
    for (int s = 0; s < 3; s++) {
        problem p = {.net = &net, .x = &x, .o = sp_sensitivity_options_default()};
        p.o.source = sources[s];
        p.from = p.to = sp_place_wall();
        if (sp_network_source_at(&net, p.o.source, &p.from, scratch, &reason) != SP_OK)
            p.from = (sp_place){.kind = SP_PLACE_GRAIN, .grain = net.grain[0]};
        if (sp_network_detector_at(&net, &p.to, scratch, &reason) != SP_OK)
            p.to = (sp_place){.kind = SP_PLACE_GRAIN, .grain = net.grain[net.n - 1]};
        p.o.from = &p.from;
        p.o.to = &p.to;
        make(&p);
        run_time(r, c->name, &p, 3, 3);
        run_time(r, c->name, &p, 100, 5);
        if (s == 0)
            run_time(r, c->name, &p, 3000, 9);
        drop(&p);
    }
}

TEST(test_gradients) {
    if (!STRESS_QUAD)
        skip();
    stress_record r = stress_open();
    for (size_t k = 0; k < sizeof stress_cases / sizeof *stress_cases; k++)
        run_case(&r, &stress_cases[k], 1 + k);
    stress_close(&r);
    assert_int_equal(r.wrong, 0);
    assert_true(r.agreed > 1000);
}

/* Chains of one to six grains with stiffnesses and masses over up to 12 decades: no sum of errors is a mean here. */
TEST(test_short_chains) {
    if (!STRESS_QUAD)
        skip();
    stress_record r = stress_open();
    for (uint64_t seed = 1; seed <= 600; seed++) {
        uint64_t rng = stress_seed(seed);
        const int grains = 1 + (int)(6 * stress_random(&rng));
        const double springs = 12 * stress_random(&rng), masses = 12 * stress_random(&rng);
        FREED(sp_network) net = stress_chain(grains, seed);
        for (int32_t k = 0; k < net.n_springs; k++)
            net.springs[k].kn *= pow(10, springs * (stress_random(&rng) - 0.5));
        for (int32_t i = 0; i < net.n; i++)
            stress_set_mass(&net, i, pow(10, masses * (stress_random(&rng) - 0.5)));
        net = stress_changed(net);
        FREED(exact) x = exact_solve(&net);
        problem p = {.net = &net, .x = &x, .o = sp_sensitivity_options_default()};
        p.o.source = (sp_source)(seed % 3);
        p.from = p.to = sp_place_wall();
        p.o.from = &p.from;
        p.o.to = &p.to;
        make(&p);
        for (int k = 0; k < 3; k++)
            run_time(&r, "short chain", &p, pow(10, -1 + 5 * stress_random(&rng)), 1);
        drop(&p);
    }
    stress_close(&r);
    assert_int_equal(r.wrong, 0);
}

RUN_TESTS(NULL, NULL)
