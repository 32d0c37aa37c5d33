#include "base/base.h"
#include "network/apply.h"
#include "reference.h"

#include <float.h>
#include <sonopack/network.h>

static sp_network network_of(const sp_packing *p, bool prestress, bool sliding_free) {
    return network_with(p, .prestress = prestress, .sliding_free = sliding_free);
}

static double *random_vector(int64_t n) {
    double *u = calloc((size_t)n, sizeof *u);
    for (int64_t k = 0; k < n; k++)
        u[k] = 2.0 * rand() / RAND_MAX - 1;
    return u;
}

/* Every shape of the kernel: 1D, 2D and 3D, with and without rotations. */
enum { SHAPES = 6 };
static sp_packing shape_packing(int shape) {
    switch (shape) {
    case 0: return chain_packing(9, 1e-4);
    case 1: return scattered_packing(2, 6, 0.5, 1);
    case 2: return scattered_packing(2, 6, 0, 2);
    case 3: return scattered_packing(3, 4, 0.5, 3);
    case 4: return scattered_packing(3, 4, 0, 4);
    default: return reference_packing(REFERENCE("packing_N200_p1e-4.txt"));
    }
}

TEST(test_reference_counts) {
    FREED(sp_packing) p = reference_packing(REFERENCE("packing_N200_p1e-4.txt"));
    FREED(sp_network) net = network_of(&p, false, false);
    assert_int_equal(net.rattlers, 25);
    assert_int_equal(net.n, 175);
    assert_int_equal(net.n_all, 200);
    assert_int_equal(net.dof, 3);
    assert_int_equal(sp_network_dofs(&net), 525);
    assert_int_equal(net.n_springs, 295); /* every contact of the file carries */
    assert_int_equal(net.n_springs - net.n_bulk, 31);
    for (int k = 0; k < net.n_springs; k++) {
        const sp_spring *s = &net.springs[k];
        const sp_contact *c = &p.contacts[s->contact];
        assert_int_equal(net.grain[s->i], c->i);
        assert_int_equal(s->j < 0 ? s->j : net.grain[s->j], c->j);
        /* F_n = (2/3) k_n n for Hertz; eta = 1 at nu = 0. The file gives 12 digits. */
        assert_relative(2.0 / 3.0 * s->kn * c->overlap, c->fn, 1e-10);
        assert_true(s->kt == s->kn && s->kp == 0);
        assert_true(s->ri == p.r[c->i] && s->rj == (c->j < 0 ? 0 : p.r[c->j]));
    }
    for (int i = 0; i < net.n; i++) {
        const double r = p.r[net.grain[i]], m = 4.0 / 3.0 * 3.14159265358979323846 * r * r * r;
        assert_relative(net.mass[3 * i], m, 1e-15);
        assert_relative(net.mass[3 * i + 2], 0.4 * m * r * r, 1e-15);
    }
}

/* Against the definition, formed by hand for one pair: k_n = 2 E12 sqrt(R12 n), eta = (1-nu)/(1-nu/2). */
TEST(test_stiffness) {
    FREED(sp_packing) p = scattered_packing(2, 6, 0.5, 1);
    sp_network net = network_of(&p, true, false);
    for (int k = 0; k < net.n_springs; k++) {
        const sp_spring *s = &net.springs[k];
        const double n = p.contacts[s->contact].overlap, r1 = s->ri, r2 = s->rj;
        const double kn = s->j < 0 ? 2 * sqrt(r1 * n) : sqrt(r1 * r2 / (r1 + r2) * n);
        assert_relative(s->kn, kn, 1e-14);
        assert_relative(s->kt, kn * (1 - 0.2) / (1 - 0.1), 1e-14);
        assert_relative(net.length[k], r1 + r2 - n, 1e-15);
        if (s->j < 0)
            assert_true(s->kp == 0);
        else
            assert_relative(s->kp, -2.0 / 3.0 * kn * n / (r1 + r2 - n), 1e-14);
    }
    sp_network_free(&net);
    p.wall = SP_WALL_GRAIN; /* like a fixed grain of the same kind */
    net = network_of(&p, false, false);
    for (int k = net.n_bulk; k < net.n_springs; k++) {
        const sp_spring *s = &net.springs[k];
        assert_relative(s->kn, sqrt(0.5 * s->ri * p.contacts[s->contact].overlap), 1e-14);
    }
    sp_network_free(&net);
}

TEST(test_sliding) {
    FREED(sp_packing) p = scattered_packing(2, 6, 0.5, 1);
    for (int k = 0; k < p.n_contacts; k++) { /* a third far from sliding, a third at the limit, a third 2% below */
        sp_contact *c = &p.contacts[k];
        const double ft = c->fn * (k % 3 == 0 ? 0.1 : k % 3 == 1 ? 0.5 : 0.5 * (1 - 2e-2)) * (k % 2 ? 1 : -1);
        c->ft[0] = -ft * c->n[1];
        c->ft[1] = ft * c->n[0];
    }
    FREED(sp_network) stick = network_of(&p, false, false), slip = network_of(&p, false, true);
    int free = 0;
    for (int k = 0; k < slip.n_springs; k++) {
        assert_true((slip.springs[k].kt == 0) == (slip.springs[k].contact % 3 == 1));
        assert_true(stick.springs[k].kt > 0 && slip.springs[k].kn == stick.springs[k].kn);
        free += slip.springs[k].kt == 0;
    }
    assert_true(free > 10);
}

/* Tangential springs feel the velocity of the contact points: u + theta x arm on either side. */
TEST(test_tangential) {
    srand(12);
    for (int shape = 1; shape <= 3; shape += 2) {
        FREED(sp_packing) p = shape_packing(shape);
        FREED(sp_network) net = network_of(&p, false, false);
        const int dim = net.dim, dof = net.dof;
        double *u = random_vector(sp_network_dofs(&net)), energy = 0;
        for (int k = 0; k < net.n_springs; k++) {
            const sp_spring *s = &net.springs[k];
            double slip[3] = {0}, along = 0;
            for (int side = 0; side < 2; side++) {
                const int g = side ? s->j : s->i;
                if (g < 0)
                    continue;
                const double *x = u + g * dof, arm = side ? -s->rj : s->ri, sign = side ? 1 : -1;
                const double spin[3] = {dim == 3 ? x[3] : 0, dim == 3 ? x[4] : 0, dim == 3 ? x[5] : x[2]};
                for (int a = 0; a < 3; a++) {
                    const int b = (a + 1) % 3, c = (a + 2) % 3;
                    const double turned = arm * (spin[b] * s->n[c] - spin[c] * s->n[b]);
                    slip[a] += sign * ((a < dim ? x[a] : 0) + turned);
                }
            }
            for (int a = 0; a < 3; a++)
                along += slip[a] * s->n[a];
            energy += s->kn * along * along;
            for (int a = 0; a < 3; a++)
                energy += s->kt * (slip[a] - along * s->n[a]) * (slip[a] - along * s->n[a]);
        }
        assert_relative(sp_network_energy2(&net, u), energy, 1e-13);
        free(u);
    }
}

/* The assembled matrix, the kernel for one vector and for two, and the energy are the same K. */
TEST(test_assembled) {
    srand(13);
    for (int shape = 0; shape < SHAPES; shape++)
        for (int prestress = 0; prestress < 2; prestress++) {
            FREED(sp_packing) p = shape_packing(shape);
            for (int c = 0; c < p.n_contacts && prestress; c++) /* which make K unsymmetric: test_prestress */
                memset(p.contacts[c].ft, 0, sizeof p.contacts[c].ft);
            FREED(sp_network) net = network_of(&p, prestress, false);
            const int64_t n = sp_network_dofs(&net);
            RELEASED double *u = random_vector(2 * n), *v = random_vector(2 * n);
            double *one = calloc(3 * (size_t)n, sizeof *one), *two = one + n, *whole = one + 2 * n;
            FREED(sp_sparse) k;
            /* aligned as vectors of two */
            double *in = sp_alloc(2 * (size_t)n, sizeof *in), *out = sp_alloc(2 * (size_t)n, sizeof *out);
            assert_ok(sp_network_assemble(&net, &k, &err));
            assert_int_equal(k.n, n);
            double largest = 0;
            for (int64_t c = 0; c < n; c++) {
                assert_int_equal(k.i[k.p[c]], c);
                for (int64_t q = k.p[c]; q < k.p[c + 1]; q++) {
                    assert_true(q == k.p[c] || k.i[q] > k.i[q - 1]);
                    whole[k.i[q]] += k.x[q] * u[c];
                    if (k.i[q] != c)
                        whole[c] += k.x[q] * u[k.i[q]];
                    largest = fmax(largest, fabs(k.x[q]));
                }
            }
            for (int64_t q = 0; q < n; q++) {
                in[2 * q] = u[q];
                in[2 * q + 1] = v[q];
                out[2 * q] = 1; /* is added to */
            }
            sp_network_apply(&net, u, one);
            sp_network_apply(&net, v, two);
            sp_network_add_pair(&net, in, out);
            double uku = 0;
            for (int64_t q = 0; q < n; q++) {
                assert_close(one[q], whole[q], 20 * DBL_EPSILON * largest);
                assert_close(out[2 * q] - 1, one[q], 40 * DBL_EPSILON * fmax(1, largest));
                assert_close(out[2 * q + 1], two[q], 20 * DBL_EPSILON * largest);
                uku += u[q] * one[q];
            }
            assert_relative(sp_network_energy2(&net, u), uku, 1e-13);
            sp_free(in);
            sp_free(out);
            free(one);
        }
}

/* Moving all grains along the walls costs nothing but the walls' tangential springs; across, their normal ones. */
TEST(test_translation) {
    for (int shape = 1; shape < SHAPES; shape++) {
        FREED(sp_packing) p = shape_packing(shape);
        FREED(sp_network) net = network_of(&p, true, false);
        const int up = net.dim - 1;
        double *u = calloc((size_t)sp_network_dofs(&net), sizeof *u), grip = 0, hold = 0;
        for (int k = net.n_bulk; k < net.n_springs; k++) {
            grip += net.springs[k].kt;
            hold += net.springs[k].kn;
        }
        for (int a = 0; a < net.dim; a++) {
            for (int64_t q = 0; q < sp_network_dofs(&net); q++)
                u[q] = q % net.dof == a;
            assert_relative(sp_network_energy2(&net, u), a == up ? hold : grip, 1e-13);
        }
        assert_true((grip == 0) == (p.friction == 0));
        free(u);
    }
}

/* The bound of the energy's rounding holds against long double, for soft and for rough displacements. */
TEST(test_energy_rounding) {
    srand(14);
    for (int shape = 0; shape < SHAPES; shape++)
        for (int soft = 0; soft < 2; soft++) {
            FREED(sp_packing) p = shape_packing(shape);
            FREED(sp_network) net = network_of(&p, false, false);
            const int64_t n = sp_network_dofs(&net);
            double *u = random_vector(n), rounding;
            for (int64_t q = 0; q < n && soft; q++)
                u[q] = 1 + 1e-7 * u[q]; /* nearly a translation: the stretches cancel */
            long double exact = 0;
            for (int k = 0; k < net.n_springs; k++) {
                const sp_spring *s = &net.springs[k];
                if (net.dof != net.dim)
                    continue;
                long double along = 0;
                for (int a = 0; a < net.dim; a++)
                    along += s->n[a] * ((s->j < 0 ? 0 : (long double)u[s->j * net.dof + a]) - u[s->i * net.dof + a]);
                exact += s->kn * along * along;
            }
            const double energy = sp_network_energy2_bound(&net, u, &rounding);
            assert_true(rounding >= 0 && rounding < 1e-6 * energy);
            if (net.dof == net.dim)
                assert_close(energy, (double)exact, rounding);
            free(u);
        }
}

TEST(test_source_detector) {
    FREED(sp_packing) p = reference_packing(REFERENCE("packing_N200_p1e-4.txt"));
    FREED(sp_network) net = network_of(&p, false, false);
    const int64_t n = sp_network_dofs(&net);
    double *impulse = calloc(4 * (size_t)n, sizeof *impulse), *velocity = impulse + n, *displacement = impulse + 2 * n,
           *seen = impulse + 3 * n, bottom = 0, top = 0;
    assert_ok(sp_network_source(&net, SP_SOURCE_IMPULSE, impulse, &err));
    assert_ok(sp_network_source(&net, SP_SOURCE_VELOCITY, velocity, &err));
    assert_ok(sp_network_source(&net, SP_SOURCE_DISPLACEMENT, displacement, &err));
    assert_ok(sp_network_detector(&net, seen, &err));
    for (int64_t q = 0; q < n; q++) {
        assert_true(velocity[q] == impulse[q] * net.mass[q] && displacement[q] == impulse[q]);
        assert_true(impulse[q] >= 0 && seen[q] >= 0); /* up, both */
        assert_true(q % 3 == 1 || (impulse[q] == 0 && seen[q] == 0));
        bottom += impulse[q];
        top += seen[q];
    }
    for (int k = 0; k < net.n_springs; k++) {
        bottom -= net.springs[k].j == SP_BOTTOM ? net.springs[k].kn : 0;
        top -= net.springs[k].j == SP_TOP ? net.springs[k].kn : 0;
    }
    assert_close(bottom, 0, 1e-14);
    assert_close(top, 0, 1e-14);
    assert_fails(sp_network_source(&net, (sp_source)9, impulse, &err), SP_EINVAL, "source 9");
    int kept = net.n_bulk; /* a network without top */
    for (int k = net.n_bulk; k < net.n_springs; k++)
        if (net.springs[k].j == SP_BOTTOM)
            net.springs[kept++] = net.springs[k];
    net.n_springs = kept;
    assert_fails(sp_network_detector(&net, seen, &err), SP_EREFUSED, "top");
    net.n_springs = net.n_bulk;
    assert_fails(sp_network_source(&net, SP_SOURCE_IMPULSE, seen, &err), SP_EREFUSED, "bottom");
    free(impulse);
}

TEST(test_refusals) {
    sp_packing p = chain_packing(5, 1e-4);
    sp_network_options o = sp_network_options_default();
    sp_network net = sp_network_none();
    o.threshold = NAN;
    assert_fails(sp_network_make(&p, &o, &net, &err), SP_EINVAL, "threshold");
    o.threshold = -1;
    assert_fails(sp_network_make(&p, &o, &net, &err), SP_EINVAL, "threshold");
    o.threshold = 10; /* above every force */
    assert_fails(sp_network_make(&p, &o, &net, &err), SP_EREFUSED, "5 10");
    o.threshold = 1e-4;
    const double overlap = p.contacts[2].overlap, bad[] = {0, -1e-3, NAN, INFINITY, 2};
    for (size_t k = 0; k < sizeof bad / sizeof *bad; k++) {
        p.contacts[2].overlap = bad[k];
        assert_fails(sp_network_make(&p, &o, &net, &err), SP_EFORMAT, "2 overlap");
    }
    p.contacts[2].overlap = overlap;
    p.dim = 4;
    assert_fails(sp_network_make(&p, &o, &net, &err), SP_EINVAL, "4");
    p.dim = 1;
    assert_null(net.springs); /* nothing was written */
    p.contacts[0].fn = 0;     /* without one contact the chain falls apart, ball by ball */
    assert_fails(sp_network_make(&p, &o, &net, &err), SP_EREFUSED, "5");
    sp_packing_free(&p);
    sp_network_free(&net);
    p = sp_packing_none();
    p.dim = 2;
    assert_fails(sp_network_make(&p, &o, &net, &err), SP_EREFUSED, "0 0.0001");
}

TEST(test_no_memory) {
    FREED(sp_packing) p = scattered_packing(2, 5, 0.5, 1);
    const sp_network_options o = sp_network_options_default();
    FREED(sp_network) net = sp_network_none();
    FREED(sp_sparse) a = {0};
    EACH_ALLOCATION_FAILS(10, sp_network_make(&p, &o, &net, &err), assert_true(!lacks || !net.springs));
    EACH_ALLOCATION_FAILS(4, sp_network_assemble(&net, &a, &err), assert_true(!lacks || !a.x));
}

/* Two springs between the same grains, as through both sides of a narrow periodic box, add up. */
TEST(test_double_contact) {
    FREED(sp_packing) p = scattered_packing(2, 2, 0.5, 3);
    FREED(sp_network) net = network_of(&p, false, false);
    int pairs = 0;
    FREED(sp_sparse) a, b;
    assert_ok(sp_network_assemble(&net, &a, &err));
    net.springs[0].kn *= 2; /* twice the spring ... */
    net.springs[0].kt *= 2;
    assert_ok(sp_network_assemble(&net, &b, &err));
    net.springs[0].kn /= 2;
    net.springs[0].kt /= 2;
    sp_spring *both = sp_alloc((size_t)net.n_springs + 1, sizeof *both);
    both[0] = net.springs[0]; /* ... or the spring twice */
    memcpy(both + 1, net.springs, (size_t)net.n_springs * sizeof *both);
    sp_free(net.springs);
    net.springs = both;
    net.n_springs++;
    net.n_bulk++;
    FREED(sp_sparse) c;
    assert_ok(sp_network_assemble(&net, &c, &err));
    assert_int_equal(c.p[c.n], a.p[a.n]);
    for (int64_t q = 0; q < c.p[c.n]; q++) {
        assert_int_equal(c.i[q], b.i[q]);
        assert_close(c.x[q], b.x[q], 1e-15);
        pairs += b.x[q] != a.x[q];
    }
    assert_true(pairs > 10);
}

RUN_TESTS(NULL, NULL)
