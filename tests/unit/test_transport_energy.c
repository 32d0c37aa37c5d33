/* Density and flux of energy: what leaves one side of a plane arrives on the other, and waves of lattices carry their
 * energy with the group velocity. */
#include "cells.h"
#include "network/bound.h"
#include "numeric/random.h"
#include "signals.h"

#include <sonopack/transport.h>

typedef struct motion {
    int64_t n;
    double *u, *v;
    sp_energy *e;
} motion;

/* A random motion of the grains within 3 of a height, so that energy flows. */
static motion random_motion(const sp_network *net, double height) {
    motion m = {.n = sp_network_dofs(net)};
    sp_random random = sp_random_make(5, 7);
    m.u = calloc((size_t)m.n, sizeof *m.u);
    m.v = calloc((size_t)m.n, sizeof *m.v);
    m.e = calloc((size_t)net->n, sizeof *m.e);
    assert_true(m.u && m.v && m.e);
    for (int64_t k = 0; k < m.n; k++) {
        const double y = net->x[3 * (k / net->dof) + net->dim - 1];
        m.u[k] = fabs(y - height) < 3 ? sp_random_uniform(&random) - 0.5 : 0;
        m.v[k] = fabs(y - height) < 3 ? sp_random_uniform(&random) - 0.5 : 0;
    }
    return m;
}

static void motion_free(motion *m) {
    free(m->u);
    free(m->v);
    free(m->e);
}

/* Energy of the grains from one height to another, and the first moment of all of it along an axis. */
static double energy_between(const sp_network *net, motion *m, double low, double high, int axis, double *moment) {
    double sum = 0;
    *moment = 0;
    assert_ok(sp_transport_energy(net, m->u, m->v, m->e, &err));
    for (int i = 0; i < net->n; i++) {
        const double y = net->x[3 * i + net->dim - 1], e = sp_energy_sum(&m->e[i]);
        sum += y >= low && y < high ? e : 0;
        *moment += e * net->x[3 * i + axis];
    }
    return sum;
}

TEST(test_sum_is_the_energy) {
    for (int which = 0; which < 4; which++) {
        FREED(sp_packing)
        p = which == 0   ? reference_packing(SOURCE_DIR "/packings/reference/packing_N200_p1e-4.txt")
            : which == 1 ? scattered_packing(3, 3, 0.5, 7)
            : which == 2 ? chain_packing(40, 1e-4)
                         : cells_packing(SP_CELL_PERIODIC, 2, 60, 0.9, NULL, 0, 3);
        FREED(sp_network) net = network_of(&p, which == 3);
        FREED(motion) m = random_motion(&net, 3);
        double moment = 0, kinetic = 0, parts = 0;
        const double sum = energy_between(&net, &m, -1e9, 1e9, 0, &moment);
        for (int64_t k = 0; k < m.n; k++)
            kinetic += 0.5 * net.mass[k] * m.v[k] * m.v[k];
        for (int i = 0; i < net.n; i++)
            parts += m.e[i].along + m.e[i].across + m.e[i].rotation;
        assert_relative(parts, kinetic, 1e-13);
        assert_relative(sum, kinetic + 0.5 * sp_network_energy2(&net, m.u), 1e-12);
    }
}

/* Integrals over time of the fluxes through two planes and of the current, by Gauss's rule of four points in each of
 * `parts` equal intervals; the motion ends at the end. */
static void integrate(const sp_network *net, motion *m, double until, const double height[2], int axis, double out[3]) {
    static const double at[] = {0.069431844202973712, 0.330009478207571868, 0.669990521792428132, 0.930568155797026288};
    static const double weight[] = {0.173927422568726929, 0.326072577431273071, 0.326072577431273071,
                                    0.173927422568726929};
    const int parts = 200;
    const double h = until / parts;
    sp_flux j[2];
    out[0] = out[1] = out[2] = 0;
    for (int q = 0; q < parts; q++)
        for (int l = 0; l < 5; l++) {
            const double from = l > 0 ? at[l - 1] : 0, to = l < 4 ? at[l] : 1;
            double drift = 1, current = 0;
            assert_ok(sp_transport_advance(net, h * (to - from), m->u, m->v, &drift, &err));
            assert_true(drift < 1e-12);
            if (l == 4)
                break;
            assert_ok(sp_transport_flux(net, m->u, m->v, 2, height, j, &err));
            assert_ok(sp_transport_current(net, m->u, m->v, axis, &current, &err));
            out[0] += h * weight[l] * sp_flux_sum(&j[0]);
            out[1] += h * weight[l] * sp_flux_sum(&j[1]);
            out[2] += h * weight[l] * current;
        }
}

/* `moment`: there are walls across the axis, so that the current is the rate of the first moment. */
static void check_balance(const sp_packing *p, bool prestress, int axis, bool moment) {
    FREED(sp_network) net = network_of(p, prestress);
    const double top = net.box[net.dim - 1], planes[2] = {0.3 * top, 0.7 * top};
    FREED(motion) m = random_motion(&net, planes[0]);
    double before_moment = 0, after_moment = 0, flow[3];
    const double before = energy_between(&net, &m, planes[0], planes[1], axis, &before_moment);
    integrate(&net, &m, 40, planes, axis, flow);
    const double after = energy_between(&net, &m, planes[0], planes[1], axis, &after_moment);
    const double all = energy_between(&net, &m, -1e9, 1e9, axis, &after_moment);
    assert_true(fabs(after - before) > 1e-3 * all); /* something flowed */
    assert_close(after - before, flow[0] - flow[1], 1e-9 * all);
    if (moment)
        assert_close(after_moment - before_moment, flow[2], 1e-8 * all);
}

TEST(test_balance) {
    FREED(sp_packing) p = reference_packing(SOURCE_DIR "/packings/reference/packing_N200_p1e-4.txt");
    check_balance(&p, false, 1, true);
    sp_packing_free(&p);
    p = chain_packing(40, 1e-4);
    check_balance(&p, false, 0, true);
    sp_packing_free(&p);
    p = cells_packing(SP_CELL_PERIODIC, 2, 60, 0.9, NULL, 0, 3);
    check_balance(&p, true, 0, false);
    sp_packing_free(&p);
    p = cells_fcc_tilted(6, 1e-3, 0.5);
    check_balance(&p, false, 2, false);
}

/* u = cos(k y - omega t) along y in a square lattice: J/E = d omega/dk, with omega = 2 sqrt(kn/m) sin(k a/2). */
TEST(test_group_velocity) {
    enum { ROWS = 24 };
    FREED(sp_packing) p = cells_square(5, ROWS, 1, 1e-3, 0);
    FREED(sp_network) net = network_of(&p, false);
    const double a = net.length[0], root = sqrt(net.springs[0].kn / net.mass[0]);
    FREED(motion) m = random_motion(&net, 1e9);
    for (int q = 1; q < ROWS / 2; q++) {
        const double k = 2 * M_PI * q / (ROWS * a), omega = 2 * root * sin(0.5 * k * a);
        double current = 0, sideways = 0, moment = 0;
        for (int i = 0; i < net.n; i++) {
            m.u[i * net.dof + 1] = cos(k * net.x[3 * i + 1]);
            m.v[i * net.dof + 1] = omega * sin(k * net.x[3 * i + 1]);
        }
        const double energy = energy_between(&net, &m, -1e9, 1e9, 0, &moment);
        assert_ok(sp_transport_current(&net, m.u, m.v, 1, &current, &err));
        assert_ok(sp_transport_current(&net, m.u, m.v, 0, &sideways, &err));
        assert_relative(current / energy, root * a * cos(0.5 * k * a), 1e-11);
        assert_close(sideways / energy, 0, 1e-12);
    }
    assert_fails(sp_transport_current(&net, m.u, m.v, 2, &(double){0}, &err), SP_EINVAL, "2");
}

/* The displacements after an impulse are those of sp_signal_field. */
TEST(test_advance) {
    FREED(sp_packing) p = reference_packing(SOURCE_DIR "/packings/reference/packing_N200_p1e-4.txt");
    FREED(sp_network) net = network_of(&p, false);
    FREED(motion) m = random_motion(&net, 1e9);
    double *u = calloc((size_t)m.n, sizeof *u), t = 300;
    const sp_field_options spec = {.times = 1, .t = &t};
    assert_ok(sp_network_source(&net, SP_SOURCE_IMPULSE, m.v, &err));
    for (int64_t k = 0; k < m.n; k++)
        m.v[k] /= net.mass[k];
    assert_ok(sp_signal_field(&net, &spec, u, NULL, &err));
    for (int l = 0; l < 3; l++)
        assert_ok(sp_transport_advance(&net, 100, m.u, m.v, NULL, &err));
    assert_true(difference((int)m.n, u, m.u) < 1e-11 * peak_of((int)m.n, u));
    assert_fails(sp_transport_advance(&net, -1, m.u, m.v, NULL, &err), SP_EINVAL, "-1");
    free(u);
}

/* What a burst carries through a plane is what leaves the grains below it; all of it begins near the bottom. */
TEST(test_burst) {
    enum { TIMES = 2001, PLANES = 2 };
    FREED(sp_packing) p = reference_packing(SOURCE_DIR "/packings/reference/packing_N600_p1e-4.txt");
    FREED(sp_network) net = network_of(&p, false);
    double *t = calloc(TIMES, sizeof *t), *below = calloc(TIMES * PLANES, sizeof *below), drift = 1;
    RELEASED sp_flux *flux = calloc(TIMES * PLANES, sizeof *flux);
    const double planes[PLANES] = {8, 16}, h = 0.1;
    assert_true(t && below && flux);
    for (int l = 0; l < TIMES; l++)
        t[l] = h * l;
    sp_burst_options o = {.omega = 0.15, .width = 0.2, .times = TIMES, .t = t, .planes = PLANES, .height = planes};
    assert_ok(sp_burst_make(&net, &o, below, flux, &drift, &err));
    assert_true(drift < 1e-10);
    for (int q = 0; q < PLANES; q++) {
        double flow = 0;
        for (int l = 0; l < TIMES; l++) /* Simpson */
            flow += h / 3 * (l == 0 || l == TIMES - 1 ? 1 : l % 2 ? 4 : 2) * sp_flux_sum(&flux[l * PLANES + q]);
        assert_true(below[q] > 0.3 && below[q] <= 1 + 1e-9);
        assert_true(flow > 0.02);
        assert_close(below[q] - below[(TIMES - 1) * PLANES + q], flow, 1e-6);
    }
    o.t = planes; /* 8, 16 */
    o.times = 2;
    double few[4];
    assert_ok(sp_burst_make(&net, &o, few, flux, NULL, &err));
    assert_close(few[0], below[80 * PLANES], 1e-11);
    assert_close(few[3], below[160 * PLANES + 1], 1e-11);
    o.omega = 90;
    o.width = 0.05;
    assert_fails(sp_burst_make(&net, &o, few, flux, NULL, &err), SP_EREFUSED, "90");
    o.omega = 0;
    assert_fails(sp_burst_make(&net, &o, few, flux, NULL, &err), SP_EINVAL, "0");
    o = (sp_burst_options){
        .omega = 0.4, .width = 0.2, .times = 2, .t = (double[]){4, 3}, .planes = 1, .height = planes};
    assert_fails(sp_burst_make(&net, &o, few, flux, NULL, &err), SP_EINVAL, "3");
    FREED(sp_packing) periodic = cells_square(6, 6, 0, 1e-3, 0.5);
    FREED(sp_network) cell = network_of(&periodic, false);
    o.t = t;
    assert_fails(sp_burst_make(&cell, &o, few, flux, NULL, &err), SP_EREFUSED, "walls");
    free(t);
    free(below);
}

/* Forces at rest that turn with their contacts have no energy. */
TEST(test_no_energy) {
    FREED(sp_packing) p = reference_packing(SOURCE_DIR "/packings/reference/packing_N200_p1e-4.txt");
    FREED(sp_network) net = network_of(&p, true);
    FREED(motion) m = random_motion(&net, 5);
    sp_flux j;
    double x = 0;
    assert_true(net.carried);
    assert_fails(sp_transport_energy(&net, m.u, m.v, m.e, &err), SP_EREFUSED, "");
    assert_fails(sp_transport_flux(&net, m.u, m.v, 1, &x, &j, &err), SP_EREFUSED, "");
    assert_fails(sp_transport_current(&net, m.u, m.v, 0, &x, &err), SP_EREFUSED, "");
    assert_fails(sp_transport_advance(&net, 1, m.u, m.v, NULL, &err), SP_EREFUSED, "");
}

/* A motion whose energy is below 0 grows, and is told like any other that does. */
TEST(test_growth) {
    FREED(sp_packing) p = without_tangential(scattered_packing(2, 4, 0.5, 5));
    FREED(sp_network) net = network_of(&p, true);
    FREED(motion) m = random_motion(&net, 5);
    for (int32_t k = 0; k < net.n_springs; k++)
        net.springs[k].kp *= 1e3;
    for (int64_t k = 0; k < sp_network_dofs(&net); k++)
        m.v[k] = 0;
    assert_ok(sp_network_find_bounds(&net, &err));
    assert_true(sp_network_energy2(&net, m.u) < 0);
    assert_fails(sp_transport_advance(&net, 3, m.u, m.v, NULL, &err), SP_EREFUSED, "unstable");
}

RUN_TESTS(NULL, NULL)
