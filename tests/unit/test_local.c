/* Moduli of parts of a packing: their mean is the modulus of the whole, all are equal where parts fit a lattice, and
 * contacts slide and open where a scan of the load says. tests/cli/test_moduli.py has them all from numpy. */
#include "base/base.h"
#include "cells.h"
#include "elastic/strain.h"
#include "making.h"

#include <sonopack/elastic.h>

static sp_local_moduli local(const sp_network *net, double width) {
    sp_local_moduli m;
    assert_ok(sp_local_moduli_make(net, width, &m, &err));
    return m;
}

/* Of all components, of K and G, and of what is counted. */
static void check_means(const sp_network *net, double width) {
    FREED(sp_local_moduli) m = local(net, width);
    sp_elasticity whole;
    double grains = 0, contacts = 0, bulk = 0, shear = 0;
    const int s = m.strains;
    assert_ok(sp_elasticity_make(net, NAN, NULL, &whole, &err));
    assert_true(m.n > 3 && s == sp_strain_count(net));
    for (int a = 0; a < s; a++)
        for (int b = 0; b < s; b++) {
            double mean = 0;
            for (int32_t q = 0; q < m.n; q++)
                mean += m.c[((int64_t)q * s + a) * s + b] / m.n;
            assert_true(isnan(mean) == isnan(whole.c[a][b]));
            if (!isnan(mean)) {
                assert_true(m.whole[a * s + b] == whole.c[a][b]);
                assert_close(mean, whole.c[a][b], 1e-12 * whole.c[1][1]);
            }
        }
    for (int32_t q = 0; q < m.n; q++) {
        grains += m.grains[q];
        contacts += m.contacts[q];
        bulk += m.bulk[q] / m.n;
        shear += m.shear[q] / m.n;
        assert_true((m.error[q] > 0 || m.contacts[q] == 0) && m.error[q] < 100 * m.whole_error);
    }
    assert_true(grains == net->n);
    assert_close(contacts, net->n_springs, 1e-11 * net->n_springs);
    assert_close(bulk, m.whole_bulk, 1e-12 * whole.c[1][1]);
    if (!isnan(m.whole_shear))
        assert_close(shear, m.whole_shear, 1e-12 * whole.c[1][1]);
}

TEST(test_means) {
    const double tilt[2][3] = {{0.4}, {0.4, -0.3, 0.45}};
    for (int k = 0; k < 10; k += SANITIZED_STEP(3)) {
        const int dim = k < 5 ? 2 : 3, n = dim == 2 ? 60 : 150;
        const double phi = dim == 2 ? 0.9 : 0.7;
        FREED(sp_packing) p = k % 5 == 0   ? scattered_packing(dim, dim == 2 ? 8 : 5, 0.5, 1)
                              : k % 5 == 1 ? cells_packing(SP_CELL_PERIODIC, dim, n, phi, tilt[dim - 2], 0, 3)
                              : k % 5 == 2 ? cells_packing(SP_CELL_PERIODIC, dim, n, phi, NULL, 0.4, 4)
                              : k % 5 == 3 ? cells_packing(SP_CELL_BOX, dim, n, phi, NULL, 0, 5)
                                           : scattered_packing(dim, dim == 2 ? 8 : 5, 0, 1);
        for (int prestress = 0; prestress < 2; prestress++) {
            FREED(sp_network) net = network_with(&p, .prestress = prestress);
            if (!(prestress && k % 5 % 4 == 0)) /* scattered packings are not at rest */
                for (int part = 0; part < 2; part++)
                    check_means(&net, part ? 1.3 : 2.4);
        }
    }
}

/* With friction and prestress K is not symmetric. Only the spins of spheres with two contacts have no answer. */
TEST(test_carried) {
    sp_packing p = reference_packing(REFERENCE("packing_N200_p1e-4.txt"));
    sp_network net = network_with(&p, .prestress = true);
    assert_true(net.carried != NULL);
    check_means(&net, 3);
    sp_network_free(&net);
    sp_packing_free(&p);
    sp_pack_spec s = spheres(150, 5, 0.3, 1);
    s.protocol = SP_PROTOCOL_QUICK;
    p = make_packing(&s);
    net = network_with(&p, .prestress = true);
    sp_local_moduli m;
    assert_fails(sp_local_moduli_make(&net, 2, &m, &err), SP_EREFUSED, "spin freely");
    sp_network_free(&net);
    sp_packing_free(&p);
}

/* The triangular lattice is cut in its unit cells, also across their corners. */
TEST(test_lattice) {
    FREED(sp_packing) p = cells_triangular(6, 6, 1e-3, 0.5);
    FREED(sp_network) net = network_with(&p, .sliding_free = false);
    FREED(sp_local_moduli) m = local(&net, 2);
    assert_true(m.n == 9);
    double c[9] = {0};
    for (int k = 0; k < 9; k++)
        c[k] = m.c[k];
    for (int32_t q = 0; q < m.n; q++) {
        for (int k = 0; k < 9; k++)
            assert_close(m.c[9 * (int64_t)q + k], c[k], 1e-12 * c[4]);
        assert_close(m.contacts[q], (double)net.n_springs / m.n, 1e-12);
        assert_close(m.bulk[q], m.whole_bulk, 1e-12 * c[4]);
    }
}

/* How far the contact is from its limit at this load: mu Fn - |Ft|. */
static double margin(const sp_packing *p, const sp_contact *c, const double *change, double e) {
    double force[3], along = 0, squares = 0;
    for (int a = 0; a < 3; a++)
        force[a] = c->ft[a] - c->fn * c->n[a] + e * change[a];
    for (int a = 0; a < 3; a++)
        along -= force[a] * c->n[a];
    for (int a = 0; a < 3; a++)
        squares += (force[a] + along * c->n[a]) * (force[a] + along * c->n[a]);
    return p->friction * along - sqrt(squares);
}

/* Nothing slides before, on either side, and something changes there. */
static void check_limits(const sp_packing *p, const sp_network *net, sp_load load, int *found) {
    FREED(sp_response) r;
    assert_ok(sp_response_make(net, &load, &r, &err));
    for (int32_t k = 0; k < net->n_springs; k++) {
        const sp_contact *c = &p->contacts[net->springs[k].contact];
        const double *change = r.force + 3 * (int64_t)k;
        double opens, slides, sides = 0;
        sp_response_limits(p, net, &r, k, &opens, &slides);
        assert_close(c->fn + opens * r.fn[k], 0, 1e-12 * c->fn);
        for (int a = 0; a < 3; a++)
            sides += (change[a] + r.fn[k] * c->n[a]) * (change[a] + r.fn[k] * c->n[a]);
        assert_close(sqrt(sides), r.ft[k], 1e-12 * (fabs(r.fn[k]) + r.ft[k]));
        const double reach = isinf(slides) ? 1e3 * fabs(opens) : fabs(slides);
        for (int q = -400; q <= 400; q++)
            assert_true(abs(q) == 400 || margin(p, c, change, reach * q / 400) > 0);
        if (!isinf(slides)) {
            /* at the tip of the cone, through which grains with two contacts go, there are two roots */
            const double tip = fabs(slides) > 0.999 * fabs(opens) ? 1e-7 : 1e-11;
            assert_close(margin(p, c, change, slides), 0, tip * (c->fn + fabs(slides) * (fabs(r.fn[k]) + r.ft[k])));
            assert_true(margin(p, c, change, 1.001 * slides) < 0 && fabs(slides) <= fabs(opens));
            ++*found;
        }
    }
}

/* At the limit, or beyond it by rounding, a contact slides at once; without friction never. */
static void check_mobilised(sp_packing *p, const sp_network *net) {
    const sp_load load = {SP_LOAD_STRAIN, 0, 2};
    sp_contact *c = &p->contacts[net->springs[3].contact];
    FREED(sp_response) r;
    double opens, slides, size = 0;
    assert_ok(sp_response_make(net, &load, &r, &err));
    for (int a = 0; a < 3; a++)
        size += c->ft[a] * c->ft[a];
    for (int a = 0; a < 3; a++)
        c->ft[a] *= p->friction * c->fn / sqrt(size) * (1 + 1e-15);
    sp_response_limits(p, net, &r, 3, &opens, &slides);
    assert_true(slides == 0 && opens != 0);
    p->friction = 0;
    sp_response_limits(p, net, &r, 3, &opens, &slides);
    assert_true(isinf(slides));
}

TEST(test_limits) {
    int found = 0;
    sp_pack_spec s = spheres(150, 5, 0.2, 1);
    s.pressure = 1e-4;
    s.protocol = SP_PROTOCOL_QUICK;
    for (int dim = 2; dim <= 3; dim++) {
        FREED(sp_packing) p = dim == 2 ? reference_packing(REFERENCE("packing_N200_p1e-4.txt")) : make_packing(&s);
        FREED(sp_network) net = network_with(&p, .sliding_free = false);
        check_limits(&p, &net, (sp_load){SP_LOAD_STRAIN, 0, 2}, &found);
        check_limits(&p, &net, (sp_load){SP_LOAD_SWELL, 10, 0}, &found);
        check_limits(&p, &net, (sp_load){SP_LOAD_FORCE, 10, 1}, &found);
        check_mobilised(&p, &net);
    }
    assert_true(found > 1000);
}

TEST(test_refusals) {
    FREED(sp_packing) p = reference_packing(REFERENCE("packing_N200_p1e-4.txt")), chain = chain_packing(9, 1e-4);
    FREED(sp_network) net = network_with(&p, .sliding_free = false), line = network_with(&chain, .sliding_free = false);
    sp_local_moduli m = sp_local_moduli_none();
    assert_fails(sp_local_moduli_make(&net, 0.5, &m, &err), SP_EINVAL, "mean diameter");
    assert_fails(sp_local_moduli_make(&net, NAN, &m, &err), SP_EINVAL, "mean diameter");
    assert_fails(sp_local_moduli_make(&line, 2, &m, &err), SP_EREFUSED, "chain");
    EACH_ALLOCATION_FAILS(5, sp_local_moduli_make(&net, 3, &m, &err), assert_true(!lacks || !m.x),
                          sp_local_moduli_free(&m));
}

RUN_TESTS(NULL, NULL)
