/* Finite strain of the packing itself against the moduli of its springs. */
#include "base/base.h"
#include "making.h"
#include "signals.h"

#include <sonopack/elastic.h>

static sp_finite_strain strained(const sp_packing *p, const sp_network *net, double strain, bool turning) {
    sp_finite_strain_options o = sp_finite_strain_options_default();
    sp_finite_strain out;
    o.strain = strain;
    o.turning = turning;
    assert_ok(sp_moduli_finite_strain(p, net, 0.5, &o, &out, &err));
    assert_true(out.residual < 1e-6);
    return out;
}

static void components(const sp_moduli *m, double c[9]) {
    const double all[] = {m->c11, m->c12, m->c22, m->c33, m->c13, m->c23, m->c44, m->c55, m->c66};
    memcpy(c, all, sizeof all);
}

/* The difference to the moduli of springs falls as the first power of the strain: Hertz's law stiffens, nothing slides.
 * From one strain to a third of it the second power is 3e-3 of the first at most, and the residual 1e-9 of the stress.
 */
static void assert_first_power(const sp_packing *p, bool turning, double strain) {
    FREED(sp_network) net = network_of(p, turning);
    double linear[9], off[2][9];
    sp_moduli m;
    assert_ok(sp_moduli_make(&net, 0.5, &m, &err));
    components(&m, linear);
    for (int k = 0; k < 2; k++) {
        double c[9];
        const sp_finite_strain s = strained(p, &net, k == 0 ? strain : strain / 3, turning);
        assert_true(s.residual < 1e-9 && s.sliding == 0 && s.lost == 0 && s.made == 0);
        components(&s.moduli, c);
        for (int q = 0; q < 9; q++)
            off[k][q] = fabs(c[q] - linear[q]);
        assert_relative(s.moduli.c_l * s.moduli.c_l * 0.5, p->dim == 3 ? s.moduli.c33 : s.moduli.c22, 1e-12);
    }
    for (int q = 0; q < 9; q++)
        if (!isnan(linear[q]) && !isnan(off[0][q])) {
            assert_true(off[0][q] < 0.01 * fabs(linear[2]));
            assert_close(log(off[0][q] / off[1][q]) / log(3), 1, 0.05);
        }
    assert_true(off[0][2] > 1e-7 * linear[2]); /* so that there is something to see */
}

TEST(test_straight) {
    FREED(sp_packing) one = reference_packing(REFERENCE("packing_N200_p1e-4.txt"));
    one.friction = 1e9; /* no contact slides */
    assert_first_power(&one, false, 1e-6);
    sp_pack_spec spec = sp_pack_spec_default();
    spec.grains = 100;
    spec.width = 9;
    spec.pressure = 1e-6;
    spec.tolerance = 1e-10;
    FREED(sp_packing) two = make_packing(&spec);
    two.friction = 1e9;
    assert_first_power(&two, false, 1e-8);
    FREED(sp_packing) space = scattered_packing(3, 4, 1e9, 1);
    assert_first_power(&space, false, 1e-6);
    FREED(sp_packing) chain = chain_packing(20, 1e-4);
    assert_first_power(&chain, false, 1e-6);
}

/* Without friction the springs with prestress are all there is to first order, the turning of the normals included. */
TEST(test_turning) {
    sp_pack_spec spec = sp_pack_spec_default();
    spec.grains = 100;
    spec.width = 9;
    spec.friction = 0;
    spec.tolerance = 1e-10;
    FREED(sp_packing) p = make_packing(&spec);
    assert_first_power(&p, true, 1e-6);
    /* and without prestress they are not */
    FREED(sp_network) net = network_of(&p, false), stiff = network_of(&p, true);
    sp_moduli m, prestressed;
    assert_ok(sp_moduli_make(&net, 0.5, &m, &err));
    assert_ok(sp_moduli_make(&stiff, 0.5, &prestressed, &err));
    const sp_finite_strain s = strained(&p, &net, 1e-8, true);
    assert_true(fabs(s.moduli.c22 - prestressed.c22) < 0.01 * fabs(m.c22 - prestressed.c22));
    assert_true(isnan(s.moduli.c33));
}

/* With friction too, tangential forces that turn with their contacts included. Larger strains make contacts slide, and
 * the packing softer to shear. */
TEST(test_sliding) {
    FREED(sp_packing) p = reference_packing(REFERENCE("packing_N600_p1e-4.txt"));
    FREED(sp_network) net = network_of(&p, true);
    sp_moduli m;
    assert_ok(sp_moduli_make(&net, 0.5, &m, &err));
    const sp_finite_strain little = strained(&p, &net, 1e-9, true), much = strained(&p, &net, 5e-5, true);
    assert_close(little.moduli.c22 / m.c22, 1, 1e-6);
    assert_close(little.moduli.c33 / m.c33, 1, 1e-6);
    assert_true(much.sliding > little.sliding && much.factors > 0);
    assert_true(much.moduli.c33 < little.moduli.c33);
    const sp_finite_strain other = strained(&p, &net, -5e-5, true); /* extension slides others */
    assert_true(other.sliding > 0 && other.moduli.c22 != much.moduli.c22);
}

/* In space, where tangential forces also turn about the normal: all nine moduli, and first order in the strain. */
TEST(test_space) {
    sp_pack_spec spec = sp_pack_spec_default();
    spec.dim = 3;
    spec.protocol = SP_PROTOCOL_QUICK;
    spec.grains = 130;
    spec.width = 4.8;
    spec.pressure = 1e-3;
    spec.friction = 0.4;
    spec.seed = 2;
    FREED(sp_packing) p = make_packing(&spec);
    FREED(sp_network) net = network_of(&p, true);
    sp_moduli m;
    assert_true(sp_network_skew(&net) > 0);
    assert_ok(sp_moduli_make(&net, 0.5, &m, &err));
    double off[2] = {0, 0};
    for (int k = 0; k < 2; k += SANITIZED_STEP(2)) {
        const sp_finite_strain s = strained(&p, &net, k ? 1e-9 : 1e-8, true);
        const double pairs[][2] = {{s.moduli.c11, m.c11}, {s.moduli.c12, m.c12}, {s.moduli.c22, m.c22},
                                   {s.moduli.c33, m.c33}, {s.moduli.c13, m.c13}, {s.moduli.c23, m.c23},
                                   {s.moduli.c44, m.c44}, {s.moduli.c55, m.c55}, {s.moduli.c66, m.c66}};
        for (int q = 0; q < 9; q++)
            off[k] = fmax(off[k], fabs(pairs[q][0] / pairs[q][1] - 1));
    }
    printf("finite strain against springs: %.2g, at a tenth of it %.2g\n", off[0], off[1]);
    assert_true(off[0] < 1e-4 && off[1] < 0.2 * off[0]);
    assert_true(m.error11 < 1e-4 * m.c11 && m.error44 < 2e-3 * m.c44 && m.residual < 1e-8);
}

static sp_packing small_spheres(int32_t grains, double friction, uint64_t seed) {
    sp_pack_spec spec = spheres(grains, 4.8, friction, seed);
    spec.protocol = SP_PROTOCOL_QUICK;
    return make_packing(&spec);
}

/* Spheres with two contacts spin about the line through them. At the usual tolerance of rest what their forces are off
 * balance drives them by many turns a strain, to which the exact solution of J owes 3.5e-3 of C12 here; the springs'
 * moduli are those of the same packing brought to rest by other means, and their errors cover what spins may do. */
TEST(test_spins) {
    FREED(sp_packing) p = small_spheres(90, 1, 32);
    FREED(sp_network) net = network_of(&p, true);
    sp_moduli m;
    double springs[9], small[9], worst = 0;
    assert_ok(sp_moduli_make(&net, 0.5, &m, &err));
    const double errors[] = {m.error11, m.error12, m.error22, m.error33, m.error13,
                             m.error23, m.error44, m.error55, m.error66};
    const sp_finite_strain s = strained(&p, &net, 1e-8, true);
    assert_int_equal(s.sliding, 0);
    components(&m, springs);
    components(&s.moduli, small);
    for (int q = 0; q < 9; q++) {
        const double off = fabs(springs[q] / small[q] - 1);
        worst = fmax(worst, off);
        assert_true(off < 2e-5);
        assert_true(errors[q] > 1e-7 * springs[q] && errors[q] < 0.02 * springs[q]);
    }
    printf("springs against finite strain where spheres spin: %.2g, C12 %.10g, its error %.2g\n", worst, m.c12,
           m.error12 / m.c12);
}

/* Spheres with friction, some contacts of which are at Coulomb's limit at rest: they slide or stick, with a force that
 * follows the normal force and a spring sideways of it. No length is in that law while contacts neither open nor close,
 * so that the moduli are nearly the same for all small strains: some contacts are so near the limit at rest that the
 * larger strain makes them slide. */
TEST(test_spheres) {
    SKIP_SANITIZED();
    int32_t sliding = 0;
    for (uint64_t seed = 7; seed <= 8; seed++) {
        sp_pack_spec spec = sp_pack_spec_default();
        spec.dim = 3;
        spec.protocol = SP_PROTOCOL_QUICK;
        spec.grains = 300;
        spec.width = spec.depth = 6;
        spec.diameter_min = spec.diameter_max = 1;
        spec.friction = 0.5;
        spec.poisson = seed % 2 == 0 ? 0.3 : 0;
        spec.pressure = seed % 4 < 2 ? 1e-4 : 1e-5;
        spec.seed = seed;
        FREED(sp_packing) p = make_packing(&spec);
        FREED(sp_network) net = network_of(&p, false);
        sp_moduli stick;
        double small[9], smaller[9], springs[9];
        assert_ok(sp_moduli_make(&net, 0.5, &stick, &err));
        const sp_finite_strain one = strained(&p, &net, 1e-9, true), two = strained(&p, &net, 1e-11, true);
        components(&one.moduli, small);
        components(&two.moduli, smaller);
        components(&stick, springs);
        for (int q = 0; q < 9; q++) {
            assert_close(small[q], smaller[q], 0.03 * springs[2]);
            assert_close(small[q], springs[q], 0.15 * springs[2]); /* sliding softens */
        }
        print_message("seed %d: %d contacts slide\n", (int)seed, one.sliding);
        sliding += one.sliding;
    }
    print_message("%d contacts slide\n", sliding);
    assert_true(sliding > 8);
}

/* Where contacts begin to slide the packing yields under one strain, says that a smaller one may do, and so it is. */
TEST(test_advice) {
    FREED(sp_packing) p = small_spheres(100, 0.5, 22);
    FREED(sp_network) net = network_of(&p, false);
    sp_finite_strain_options o = sp_finite_strain_options_default();
    sp_finite_strain out;
    o.strain = 2e-4;
    assert_fails(sp_moduli_finite_strain(&p, &net, 0.5, &o, &out, &err), SP_EREFUSED, "strain 0.0002");
    const sp_finite_strain little = strained(&p, &net, 1e-5, true);
    assert_true(little.lost == 0 && little.made == 0 && little.sliding > 0);
}

TEST(test_refusals) {
    sp_packing p = scattered_packing(2, 6, 0.5, 1), q = scattered_packing(2, 5, 0.5, 1);
    sp_network net = network_of(&p, false);
    sp_finite_strain_options o = sp_finite_strain_options_default();
    sp_finite_strain out;
    for (int k = 0; k < 3; k++) {
        o.strain = (const double[]){0, NAN, 0.5}[k];
        assert_fails(sp_moduli_finite_strain(&p, &net, 0.5, &o, &out, &err), SP_EINVAL, "strain");
    }
    o.strain = 1e-6;
    assert_fails(sp_moduli_finite_strain(&q, &net, 0.5, &o, &out, &err), SP_EINVAL, "36 25");
    for (int k = 0;; k++) {
        sp_error error = {0};
        sp_alloc_fail_after(k);
        const sp_status status = sp_moduli_finite_strain(&p, &net, 0.5, &o, &out, &error);
        sp_alloc_fail_after(-1);
        if (status == SP_OK) {
            assert_true(k > 15);
            break;
        }
        assert_int_equal(status, SP_ENOMEM);
    }
    net.n_springs = net.n_bulk;
    assert_fails(sp_moduli_finite_strain(&p, &net, 0.5, &o, &out, &err), SP_EREFUSED, "");
    sp_network_free(&net);
    sp_packing_free(&q);
    sp_packing_free(&p);
    p = reference_packing(REFERENCE("packing_N200_p1e-4.txt"));
    net = network_of(&p, false);
    o.strain = -0.01; /* more than the contacts' overlaps: they open all over */
    assert_fails(sp_moduli_finite_strain(&p, &net, 0.5, &o, &out, &err), SP_EREFUSED, "strain -0.01");
    sp_network_free(&net);
    sp_packing_free(&p);
}

RUN_TESTS(NULL, NULL)
