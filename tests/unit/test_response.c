/* Static responses: balanced, reciprocal (Maxwell and Betti), of the energy that moduli tell, and refused where nothing
 * holds. */
#include "base/base.h"
#include "elastic/strain.h"
#include "reference.h"

#include <sonopack/elastic.h>

static sp_response response(const sp_network *net, sp_load_kind kind, int32_t at, int32_t axis) {
    const sp_load load = {kind, at, axis};
    sp_response r;
    assert_ok(sp_response_make(net, &load, &r, &err));
    assert_true(r.error > 0 && r.error < 1e-8 && r.work > 0);
    return r;
}

/* K u by the network's own product is a force of 1 on one grain, and no other but its balance over all. */
static void check_balance(const sp_network *net, const sp_response *r, int32_t at, int32_t axis, bool whole) {
    double *ku = sp_alloc((size_t)r->n, sizeof *ku), all = 0, off = 0;
    sp_network_apply(net, r->u, ku);
    for (int32_t i = 0; i < net->n; i++)
        all += whole ? net->mass[(int64_t)i * net->dof] : 0;
    for (int64_t k = 0; k < r->n; k++) {
        const double spread = all > 0 && k % net->dof == axis ? net->mass[k] / all : 0;
        const double rest = ku[k] + spread - (k == (int64_t)at * net->dof + axis);
        off += rest * rest;
    }
    assert_true(sqrt(off) <= r->error * 1.001);
    sp_free(ku);
}

/* Betti: the work of one load on the response to another is the same in both orders. The load of a grain that swells is
 * -R times the sum of the normal forces of its contacts. */
static void check_reciprocal(const sp_network *net, int32_t i, int32_t j) {
    FREED(sp_response) a = response(net, SP_LOAD_FORCE, i, 0), b = response(net, SP_LOAD_FORCE, j, 1);
    const double scale = sqrt(a.work * b.work);
    assert_close(a.u[(int64_t)j * net->dof + 1], b.u[(int64_t)i * net->dof], 1e-8 * scale);
    FREED(sp_response) s = response(net, SP_LOAD_SWELL, j, 0);
    double sum = 0;
    for (int32_t k = 0; k < net->n_springs; k++)
        if (net->springs[k].i == j || net->springs[k].j == j)
            sum -= net->r[j] * a.fn[k];
    assert_close(s.u[(int64_t)i * net->dof], sum, 1e-8 * sqrt(a.work * s.work));
    /* a dipole pushes the ends apart; its response to the force is the change of the distance */
    const sp_spring *c = &net->springs[3];
    FREED(sp_response) d = response(net, SP_LOAD_DIPOLE, 3, 0);
    double apart = 0;
    for (int q = 0; q < net->dim; q++) {
        const double far = c->j >= 0 ? a.u[(int64_t)c->j * net->dof + q] : 0;
        apart += c->n[q] * (far - a.u[(int64_t)c->i * net->dof + q]);
    }
    assert_close(d.u[(int64_t)i * net->dof], apart, 1e-8 * sqrt(a.work * d.work));
    assert_close(d.fn[3], -c->kn * 2 * d.work, 1e-8 * c->kn * d.work);
}

/* What the grains take off the affine modulus, and the stress of all contacts. */
static void check_strains(const sp_network *net) {
    sp_stiffness s;
    assert_ok(sp_stiffness_make(net, &s, &err));
    for (int a = 0; a < sp_strain_count(net); a++) {
        double affine = 0;
        if (isnan(s.c[a][a])) {
            const sp_load load = {SP_LOAD_STRAIN, 0, a};
            sp_response none;
            assert_fails(sp_response_make(net, &load, &none, &err), SP_EREFUSED, "friction");
            continue;
        }
        FREED(sp_response) r = response(net, SP_LOAD_STRAIN, 0, a);
        for (int32_t k = 0; k < net->n_springs; k++) {
            const sp_spring *p = &net->springs[k];
            double gap[3], along = 0, squares = 0;
            sp_strain_displacement(net, a, p->n, net->length[k], gap);
            for (int q = 0; q < 3; q++) {
                along += gap[q] * p->n[q];
                squares += gap[q] * gap[q];
            }
            affine += p->kn * along * along + p->kt * (squares - along * along);
        }
        const double c = (affine - 2 * r.work) / sp_strain_volume(net);
        assert_close(c, s.c[a][a], 2 * s.error[a][a] + 1e-12 * affine / sp_strain_volume(net));
    }
}

TEST(test_responses) {
    for (int q = 0; q < 3; q++) {
        FREED(sp_packing) p = q == 0   ? reference_packing(REFERENCE("packing_N200_p1e-4.txt"))
                              : q == 1 ? scattered_packing(2, 8, 0.5, 1)
                                       : scattered_packing(3, 5, 0.5, 1);
        FREED(sp_network) net = network_with(&p, .sliding_free = false);
        FREED(sp_response) r = response(&net, SP_LOAD_FORCE, 10, 1);
        check_balance(&net, &r, 10, 1, false);
        check_reciprocal(&net, 10, 17);
        check_strains(&net);
    }
}

TEST(test_periodic_and_smooth) {
    for (int friction = 0; friction < 2; friction++) {
        sp_pack_spec s = sp_pack_spec_default();
        FREED(sp_packing) p;
        s.cell = SP_CELL_PERIODIC;
        s.protocol = SP_PROTOCOL_QUICK;
        s.grains = 80;
        s.pressure = 1e-3;
        s.friction = 0.5 * friction;
        assert_ok(sp_packing_make(&s, NULL, NULL, &p, &err));
        FREED(sp_network) net = network_with(&p, .sliding_free = false);
        for (int axis = 0; axis < 2; axis++) {
            FREED(sp_response) r = response(&net, SP_LOAD_FORCE, 5, axis);
            check_balance(&net, &r, 5, axis, true);
            assert_close(r.u[5 * net.dof + axis], 2 * r.work, 1e-8 * r.work);
        }
        check_strains(&net);
    }
}

TEST(test_refusals) {
    FREED(sp_packing) p = reference_packing(REFERENCE("packing_N200_p1e-4.txt"));
    sp_network net = network_with(&p, .sliding_free = false);
    sp_response r = sp_response_none();
    const sp_load bad[] = {{SP_LOAD_FORCE, -1, 0},
                           {SP_LOAD_FORCE, net.n, 0},
                           {SP_LOAD_FORCE, 0, 2},
                           {SP_LOAD_SWELL, net.n, 0},
                           {SP_LOAD_DIPOLE, net.n_springs, 0}};
    for (size_t k = 0; k < sizeof bad / sizeof *bad; k++)
        assert_fails(sp_response_make(&net, &bad[k], &r, &err), SP_EINVAL, "must be");
    const sp_load load = {SP_LOAD_SWELL, 3, 0};
    EACH_ALLOCATION_FAILS(5, sp_response_make(&net, &load, &r, &err), assert_true(!lacks || !r.u),
                          sp_response_free(&r));
    sp_network_free(&net);
    net = network_with(&p, .prestress = true);
    assert_fails(sp_response_make(&net, &load, &r, &err), SP_EREFUSED, "symmetric");
    sp_network_free(&net);
}

RUN_TESTS(NULL, NULL)
