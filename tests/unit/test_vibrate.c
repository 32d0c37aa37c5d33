/* The nonlinear motion about rest: against independent integrations, conserved energy, orders in step and amplitude. */
#include "base/base.h"
#include "carried.h"
#include "packing/vibrate.h"
#include "signals.h"

#include <sonopack/signal.h>

typedef long double extended;

/* A row of balls in long double by Runge and Kutta: force over 4/3 E12 sqrt(R12) is overlap^(3/2), dashpots never make
 * it attract. */
typedef struct row {
    int n;
    extended e, overlap, mass, zeta;
} row;

static extended push(const row *r, extended overlap, extended closing, extended m_eff) {
    if (!(overlap > 0))
        return 0;
    const extended c = 2 * r->zeta * sqrtl(m_eff * 2 * r->e * sqrtl(overlap));
    return fmaxl(0, 4 * r->e / 3 * overlap * sqrtl(overlap) + c * closing);
}

/* Force of contact k, between ball k-1 and ball k. */
static extended contact(const row *r, int k, const extended *u, const extended *v) {
    const extended du = (k > 0 ? u[k - 1] : 0) - (k < r->n ? u[k] : 0),
                   dv = (k > 0 ? v[k - 1] : 0) - (k < r->n ? v[k] : 0);
    return push(r, r->overlap + du, dv, k > 0 && k < r->n ? r->mass / 2 : r->mass);
}

static void rate(const row *r, const extended *y, extended *dy) {
    for (int i = 0; i < r->n; i++) {
        dy[i] = y[r->n + i];
        dy[r->n + i] = (contact(r, i, y, y + r->n) - contact(r, i + 1, y, y + r->n)) / r->mass;
    }
}

static void runge_kutta(const row *r, extended *y, extended h) {
    extended k[4][8], z[8];
    const int size = 2 * r->n;
    rate(r, y, k[0]);
    for (int q = 1; q < 4; q++) {
        for (int a = 0; a < size; a++)
            z[a] = y[a] + h * (q < 3 ? 0.5L : 1) * k[q - 1][a];
        rate(r, z, k[q]);
    }
    for (int a = 0; a < size; a++)
        y[a] += h / 6 * (k[0][a] + 2 * k[1][a] + 2 * k[2][a] + k[3][a]);
}

/* Three balls, knocked so gently that they only leave the harmonic range, and so hard that contacts open and close. */
TEST(test_row) {
    enum { N = 3, POINTS = 41, FINE = 400 };
    const double amplitudes[] = {0.2, 3};
    for (int q = 0; q < 4; q++) {
        FREED(sp_packing) p = chain_packing(N, 1e-4);
        FREED(sp_network) net = carried_network(&p);
        sp_signal_options o = sp_signal_options_default();
        FREED(sp_signal) s = sp_signal_none();
        o.method = SP_SIGNAL_DYNAMICS;
        o.until = 40;
        o.points = POINTS;
        o.amplitude = amplitudes[q % 2];
        o.damping = q < 2 ? 0 : 0.1;
        o.tolerance = 1e-4;
        assert_ok(sp_signal_compute(&p, &net, &o, &s, &err));
        const row r = {N, contact_stiffness(0.5, 0.5), p.contacts[0].overlap, grain_mass(0.5), o.damping};
        const double k = net.springs[0].kn;
        extended y[2 * N] = {0};
        double exact[POINTS];
        bool opened = false;
        y[N] = k * s.amplitude / (double)r.mass;
        for (int l = 0; l < POINTS; l++) {
            for (int step = 0; step < (l > 0 ? FINE : 0); step++) {
                runge_kutta(&r, y, (extended)o.until / (POINTS - 1) / FINE);
                for (int c = 0; c <= N; c++)
                    opened = opened || contact(&r, c, y, y + N) == 0;
            }
            exact[l] = (double)((contact(&r, N, y, y + N) - push(&r, r.overlap, 0, r.mass)) / s.amplitude);
        }
        assert_true(opened == (q % 2 == 1));
        assert_true(difference(POINTS, s.f, exact) <= s.error);
        assert_true(s.error > 0 && s.amplitude > 0 && s.step > 0);
    }
}

/* A ball held between two walls and pushed along them: springs at both, stretched by translation and rotation, slide at
 * mu F_n. Both walls move it alike, so it does not turn: one tangential spring k_t = eta k_n a wall. */
TEST(test_sliding) {
    const double radius = 0.5, overlap = 2e-3, mu = 0.3, poisson = 0.2;
    FREED(sp_packing) p = sp_packing_none();
    assert_ok(sp_packing_alloc(&p, 2, 1, 2, &err));
    p.r[0] = radius;
    p.x[0] = 2;
    p.x[1] = radius - overlap;
    p.box[0] = 8;
    p.box[1] = 2 * (radius - overlap);
    p.box[2] = 1;
    p.pressure = contact_force(sqrt(radius), overlap) / 8;
    p.friction = mu;
    p.poisson = poisson;
    for (int k = 0; k < 2; k++) {
        sp_contact *c = &p.contacts[k];
        *c = (sp_contact){
            .i = 0, .j = k ? SP_TOP : SP_BOTTOM, .overlap = overlap, .fn = contact_force(sqrt(radius), overlap)};
        c->n[1] = k ? 1 : -1;
    }
    vibration m;
    assert_ok(sp_vibration_make(&p, 0, &m, &err));
    const double kt = contact_eta(poisson) * contact_normal_stiffness(sqrt(radius), overlap);
    const double limit = mu * p.contacts[0].fn, mass = grain_mass(radius), h = 1e-3;
    double x = 0, v = 3 * limit / sqrt(kt * mass / 2), spring = 0, before = v * v * mass / 2, slid = 0;
    m.v[0] = v;
    sp_vibration_begin(&m);
    for (int step = 0; step < 20000; step++) {
        sp_vibration_step(&m, h);
        for (int fine = 0; fine < 10; fine++) {
            v += -2 * spring / mass * h / 20;
            x += v * h / 10;
            spring += kt * v * h / 10;
            slid += spring > limit    ? 2 * limit * (spring - limit) / kt
                    : spring < -limit ? 2 * limit * (-limit - spring) / kt
                                      : 0;
            spring = fmax(-limit, fmin(limit, spring));
            v += -2 * spring / mass * h / 20;
        }
        assert_close(m.u[0], x, 1e-4 * fabs(x) + 1e-9);
    }
    assert_true(slid > 0.5 * before); /* most of the energy was rubbed away */
    assert_close(m.u[1], 0, 1e-15);
    assert_close(m.u[5], 0, 1e-15);
    assert_close(fabs(m.touch[0].ft[0] - m.touch[1].ft[0]), 0, 1e-15);
    sp_vibration_free(&m);
}

/* Without friction and dashpots energy is conserved: the work of the forces' changes is the potential beyond its
 * tangent at rest. */
static double energy(const vibration *m) {
    double sum = 0;
    for (int i = 0; i < m->n; i++)
        for (int a = 0; a < m->dim; a++)
            sum += 0.5 * m->mass[2 * i] * m->v[6 * i + a] * m->v[6 * i + a];
    for (int k = 0; k < m->count; k++) {
        const touching *t = &m->touch[k];
        const double overlap = pow(t->kn / (2 * t->e), 2), rest = fmax(0, t->overlap);
        double along = 0;
        for (int a = 0; a < 3; a++)
            along += t->n0[a] * ((t->j >= 0 ? m->u[6 * t->j + a] : 0) - m->u[6 * t->i + a]);
        sum += 8.0 / 15 * t->e * (pow(overlap, 2.5) - pow(rest, 2.5)) + t->fn0 * along;
    }
    return sum;
}

TEST(test_energy) {
    for (int dim = 2; dim <= 3; dim++) {
        FREED(sp_packing) p = scattered_packing(dim, dim == 2 ? 5 : 3, 0, 11);
        double worst[2];
        for (int fine = 0; fine < 2; fine++) {
            vibration m;
            assert_ok(sp_vibration_make(&p, 0, &m, &err));
            srand(3);
            for (int i = 0; i < m.n; i++)
                for (int a = 0; a < dim; a++)
                    m.v[6 * i + a] = 0.02 * (rand() / (double)RAND_MAX - 0.5);
            sp_vibration_begin(&m);
            const double before = energy(&m), h = fine ? 0.005 : 0.01;
            worst[fine] = 0;
            for (int step = 0; step < 5 / h; step++) {
                sp_vibration_step(&m, h);
                worst[fine] = fmax(worst[fine], fabs(energy(&m) / before - 1));
            }
            assert_true(sp_vibration_sane(&m));
            sp_vibration_free(&m);
        }
        assert_true(worst[0] < 1e-3 && worst[0] > 0);
        assert_close(log2(worst[0] / worst[1]), 2, 0.3);
    }
}

/* As the amplitude falls, F tends to the linear signal in proportion to it: with K's prestress, and forces along the
 * normals at rest. Friction acts (2D: rotations too), dashpots as well. */
TEST(test_small) {
    enum { POINTS = 21 };
    const double amplitudes[] = {1e-1, 1e-2, 1e-3, 1e-4};
    for (int q = 0; q < 5; q++) {
        FREED(sp_packing) p =
            q == 0 ? chain_packing(10, 1e-4) : scattered_packing(q < 3 ? 2 : 3, q < 3 ? 4 : 3, q % 2 ? 0.5 : 0, 5);
        FREED(sp_network) net = carried_network(&p);
        sp_signal_options o = sp_signal_options_default();
        FREED(sp_signal) linear = sp_signal_none();
        double differ[4];
        o.until = q == 0 ? 60 : 2; /* in which no motion of these networks grows */
        o.points = POINTS;
        o.damping = q == 1 || q == 4 ? 0.1 : 0;
        o.method = SP_SIGNAL_FABER;
        o.tolerance = 1e-8;
        assert_ok(sp_signal_make(&net, &o, &linear, &err));
        o.method = SP_SIGNAL_DYNAMICS;
        o.step = q == 0 ? 2e-3 : 5e-4; /* errors of the step: far below the differences */
        for (int k = 0; k < 4; k++) {
            FREED(sp_signal) s = sp_signal_none();
            o.amplitude = amplitudes[k];
            assert_ok(sp_signal_compute(&p, &net, &o, &s, &err));
            differ[k] = difference(POINTS, s.f, linear.f);
        }
        for (int k = 2; k < 4; k++)
            if (fabs(log10(differ[k - 1] / differ[k]) - 1) > 0.1)
                fail_msg("case %d: differences %g %g %g %g", q, differ[0], differ[1], differ[2], differ[3]);
    }
}

/* Sources and detectors of every kind, at an amplitude so small that the linear signals are exact. */
TEST(test_places) {
    enum { POINTS = 11 };
    FREED(sp_packing) p = scattered_packing(2, 6, 0.5, 9);
    FREED(sp_network) net = carried_network(&p);
    const sp_place from[] = {{.kind = SP_PLACE_WALL, .shear = true},
                             {.kind = SP_PLACE_GRAIN, .grain = 14},
                             {.kind = SP_PLACE_PART, .from = 1, .to = 3}};
    const sp_place to[] = {{.kind = SP_PLACE_WALL},
                           {.kind = SP_PLACE_WALL, .shear = true},
                           {.kind = SP_PLACE_PART, .from = 0.5, .to = 3},
                           {.kind = SP_PLACE_PLANE, .height = 2.5},
                           {.kind = SP_PLACE_PLANE, .height = 2.5, .shear = true},
                           {.kind = SP_PLACE_GRAIN, .grain = 15},
                           {.kind = SP_PLACE_GRAIN, .grain = 32}};
    for (int source = 0; source < 3; source++) {
        sp_signal_options o = sp_signal_options_default();
        FREED(sp_signal) linear = sp_signal_none(), s = sp_signal_none();
        o.source = (sp_source)source;
        o.until = 3;
        o.points = POINTS;
        o.from = from;
        o.sources = 3;
        o.to = to;
        o.detectors = 7;
        assert_ok(sp_signal_make(&net, &o, &linear, &err));
        o.method = SP_SIGNAL_DYNAMICS;
        o.amplitude = 1e-7;
        o.step = 2e-3;
        assert_ok(sp_signal_compute(&p, &net, &o, &s, &err));
        double largest = 0;
        for (int q = 0; q < 21 * POINTS; q++)
            largest = fmax(largest, fabs(linear.f[q]));
        for (int q = 0; q < 21; q++) {
            double peak = 0;
            for (int l = 0; l < POINTS; l++)
                peak = fmax(peak, fabs(linear.f[q * POINTS + l]));
            assert_close(difference(POINTS, linear.f + q * POINTS, s.f + q * POINTS), 0, 1e-4 * peak + 1e-9 * largest);
            assert_true(peak > 0);
        }
    }
}

TEST(test_refusals) {
    FREED(sp_packing) p = chain_packing(10, 1e-4), other = chain_packing(11, 1e-4);
    FREED(sp_network) net = carried_network(&p);
    sp_signal s = sp_signal_none();
    sp_signal_options o = sp_signal_options_default();
    o.method = SP_SIGNAL_DYNAMICS;
    o.until = 10;
    o.points = 3;
    assert_fails(sp_signal_make(&net, &o, &s, &err), SP_EINVAL, "sp_signal_compute");
    assert_fails(sp_signal_compute(&other, &net, &o, &s, &err), SP_EINVAL, "11 10");
    for (int k = 0; k < 3; k++) {
        o.amplitude = (double[]){0, -1, NAN}[k];
        assert_fails(sp_signal_compute(&p, &net, &o, &s, &err), SP_EINVAL, "amplitude");
    }
    o.amplitude = 1000;
    o.tolerance = 1e-2;
    assert_fails(sp_signal_compute(&p, &net, &o, &s, &err), SP_EFAILED, "amplitude 1000");
    o.amplitude = 1e-3;
    o.step = 2;
    assert_fails(sp_signal_compute(&p, &net, &o, &s, &err), SP_EINVAL, "step 2");
    o.step = 0;
    o.tolerance = 1e-14;
    o.until = 1000;
    assert_fails(sp_signal_compute(&p, &net, &o, &s, &err), SP_EREFUSED, "steps");
    assert_true(s.f == NULL);
    o.tolerance = 0.05;
    o.until = 10;
    lacks_memory(&p, &net, &o, 10);
}

RUN_TESTS(NULL, NULL)
