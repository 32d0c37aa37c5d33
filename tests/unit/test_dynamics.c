/* The motion that makes packings: against brute force, against the network's K, and against what mechanics conserves.
 * The kernel against the plain path is in test_kernel.c. */
#include "test.h"

#include "base/base.h"
#include "packing/contact.h"
#include "packing/dynamics.h"
#include "packing/prepare.h"

#include <sonopack/network.h>

static sp_pack_spec small_spec(int dim, uint64_t seed) {
    sp_pack_spec spec = sp_pack_spec_default();
    spec.dim = dim;
    spec.grains = dim == 2 ? 60 : 100;
    spec.width = dim == 2 ? 8 : 5;
    spec.seed = seed;
    return sp_pack_spec_resolve(&spec);
}

/* Degrees of freedom of a grain, rotations included. */
static int dofs(int dim) { return dim == 2 ? 3 : 6; }

/* The packing without its rattlers, so that every touching pair is a spring. */
static sp_packing make_bare(int dim, uint64_t seed) {
    sp_pack_spec spec = small_spec(dim, seed);
    sp_packing p = sp_packing_none(), bare = sp_packing_none();
    assert_ok(sp_packing_make(&spec, NULL, NULL, &p, &err));
    uint8_t *rattler = sp_alloc((size_t)p.n, 1), *carrying = sp_alloc((size_t)p.n_contacts, 1);
    int32_t *number = sp_alloc((size_t)p.n, sizeof *number), rattlers, n = 0, contacts = 0;
    assert_ok(sp_packing_rattlers(&p, 0, rattler, carrying, &rattlers, &err));
    assert_ok(sp_packing_alloc(&bare, dim, p.n - rattlers, p.n_contacts, &err));
    memcpy(bare.box, p.box, sizeof p.box);
    bare.pressure = p.pressure;
    bare.friction = p.friction;
    for (int32_t i = 0; i < p.n; i++) {
        if (rattler[i])
            continue;
        number[i] = n;
        bare.r[n] = p.r[i];
        memcpy(bare.x + 3 * n, p.x + 3 * i, 3 * sizeof(double));
        n++;
    }
    for (int32_t c = 0; c < p.n_contacts; c++) {
        if (!carrying[c])
            continue;
        sp_contact k = p.contacts[c];
        k.i = number[k.i];
        k.j = k.j >= 0 ? number[k.j] : k.j;
        bare.contacts[contacts++] = k;
    }
    bare.n_contacts = contacts;
    sp_free(number);
    sp_free(carrying);
    sp_free(rattler);
    sp_packing_free(&p);
    return bare;
}

/* How near a contact of the packing is to opening, or an open pair to touching. */
static double smallest_gap(const sp_packing *p) {
    const int up = p->dim - 1;
    double least = INFINITY;
    for (int32_t i = 0; i < p->n; i++) {
        const double *g = p->x + 3 * (size_t)i;
        least = fmin(least, fmin(fabs(g[up] - p->r[i]), fabs(p->box[up] - g[up] - p->r[i])));
        for (int32_t j = i + 1; j < p->n; j++) {
            double square = 0;
            for (int a = 0; a < p->dim; a++) {
                double x = p->x[3 * (size_t)j + (size_t)a] - g[a];
                x -= a < up ? p->box[a] * nearbyint(x / p->box[a]) : 0;
                square += x * x;
            }
            least = fmin(least, fabs(p->r[i] + p->r[j] - sqrt(square)));
        }
    }
    return least;
}

/* A packing whose forces are smooth within a few times 1e-6. */
static sp_packing make_smooth(int dim, uint64_t seed) {
    for (uint64_t k = seed; k < seed + 20; k++) {
        sp_packing p = make_bare(dim, k);
        if (smallest_gap(&p) > 1e-5)
            return p;
        sp_packing_free(&p);
    }
    fail_msg("no packing of 20 without a contact that is about to open");
    return sp_packing_none();
}

/* Motion without viscosity and without slip, from the packing's positions, tangential springs slack. */
static dynamics make_stick(const sp_packing *p) {
    sp_pack_spec spec = small_spec(p->dim, 1);
    dynamics d;
    spec.grains = p->n;
    spec.friction = 1e6;
    spec.poisson = p->poisson;
    spec.damping = 0;
    assert_ok(sp_dynamics_make(&spec, p->r, p->x, sp_packing_height(p), &d, &err));
    assert_ok(sp_neighbours_refresh(&d, &err));
    return d;
}

/* Generalised forces (force, torque) after every grain has moved by s u (translations, angles). */
static void forces_after(const sp_packing *p, const double *u, double s, double *out) {
    const int dim = p->dim, dof = dofs(dim);
    dynamics d = make_stick(p);
    for (int32_t i = 0; i < p->n; i++) {
        double *g = dynamics_grain(&d, i);
        for (int a = 0; a < dim; a++) {
            g[a] += s * u[dof * i + a];
            g[d.at.v + a] = s * u[dof * i + a];
        }
        for (int a = dim; a < dof; a++)
            g[d.at.w + a - dim] = g[d.at.r] * s * u[dof * i + a];
    }
    sp_dynamics_forces(&d, 1.0);
    for (int32_t i = 0; i < p->n; i++) {
        double force[3], turn[3];
        sp_dynamics_force_on(&d, i, force, turn);
        for (int a = 0; a < dof; a++)
            out[dof * i + a] = a < dim ? force[a] : p->r[i] * turn[a - dim];
    }
    sp_dynamics_free(&d);
}

/* Largest |K u - central difference of the forces| over the largest |K u|. */
static double jacobian_error(const sp_packing *p, const sp_network *net, const double *u, double h) {
    const int32_t n = dofs(p->dim) * p->n;
    double *plus = sp_alloc((size_t)n, 8), *minus = sp_alloc((size_t)n, 8), *ku = sp_alloc((size_t)n, 8);
    forces_after(p, u, h, plus);
    forces_after(p, u, -h, minus);
    sp_network_apply(net, u, ku);
    double worst = 0, scale = 0;
    for (int32_t k = 0; k < n; k++) {
        worst = fmax(worst, fabs(ku[k] + (plus[k] - minus[k]) / (2 * h)));
        scale = fmax(scale, fabs(ku[k]));
    }
    sp_free(ku);
    sp_free(minus);
    sp_free(plus);
    return worst / scale;
}

static double *some_displacement(int32_t dof, int32_t n) {
    double *u = sp_alloc((size_t)(dof * n), sizeof *u);
    for (int32_t k = 0; k < dof * n; k++)
        u[k] = sin(12.9898 * k + 1.0);
    return u;
}

/* Without prestress the difference is -F_n/r times the transverse part of u_j - u_i, nothing else. */
static void assert_prestress_is_transverse(const sp_packing *p, const sp_network *with, const sp_network *without,
                                           const double *u) {
    const int dim = p->dim, dof = dofs(dim);
    double *a = sp_alloc((size_t)(dof * p->n), 8), *b = sp_alloc((size_t)(dof * p->n), 8);
    sp_network_apply(with, u, a);
    sp_network_apply(without, u, b);
    for (int32_t c = 0; c < p->n_contacts; c++) {
        const sp_contact *k = &p->contacts[c];
        if (k->j < 0)
            continue;
        double r = p->r[k->i] + p->r[k->j] - k->overlap, along = 0;
        for (int x = 0; x < dim; x++)
            along += (u[dof * k->j + x] - u[dof * k->i + x]) * k->n[x];
        for (int x = 0; x < dim; x++) {
            const double across = u[dof * k->j + x] - u[dof * k->i + x] - along * k->n[x];
            b[dof * k->i + x] += k->fn / r * across;
            b[dof * k->j + x] -= k->fn / r * across;
        }
    }
    for (int32_t k = 0; k < dof * p->n; k++)
        assert_close(b[k], a[k], 1e-14);
    sp_free(a);
    sp_free(b);
}

static void check_jacobian(int dim) {
    sp_packing p = make_smooth(dim, 7);
    for (int32_t c = 0; c < p.n_contacts; c++) /* the springs of make_stick are slack */
        memset(p.contacts[c].ft, 0, sizeof p.contacts[c].ft);
    sp_network_options with = sp_network_options_default();
    with.threshold = 0;
    with.prestress = true;
    sp_network net = sp_network_none(), plain = sp_network_none();
    assert_ok(sp_network_make(&p, &with, &net, &err));
    assert_int_equal(net.n, p.n);
    assert_int_equal(net.dof, dofs(dim));
    double *u = some_displacement(dofs(dim), p.n);
    double e1 = jacobian_error(&p, &net, u, 1e-6), e2 = jacobian_error(&p, &net, u, 5e-7);
    printf("%dD: Jacobian error %.3g, at half the step %.3g\n", dim, e1, e2);
    assert_true(e2 < 1e-5);
    assert_close(log2(e1 / e2), 2.0, 0.15); /* central differences: h^2 */
    sp_network_options without = with;
    without.prestress = false;
    assert_ok(sp_network_make(&p, &without, &plain, &err));
    assert_prestress_is_transverse(&p, &net, &plain, u);
    sp_free(u);
    sp_network_free(&plain);
    sp_network_free(&net);
    sp_packing_free(&p);
}

TEST(test_stiffness_is_jacobian) {
    check_jacobian(2);
    check_jacobian(3);
}

/* Newton's third law: what the grains give each other sums to nothing but the walls' forces, along every axis. */
static void check_momentum(int dim) {
    const int dof = dofs(dim), up = dim - 1;
    sp_packing p = make_bare(dim, 3);
    double *u = some_displacement(dof, p.n);
    dynamics d = make_stick(&p);
    for (int32_t i = 0; i < p.n; i++) {
        double *g = dynamics_grain(&d, i);
        for (int a = 0; a < dof; a++)
            g[a < dim ? d.at.v + a : d.at.w + a - dim] = 1e-3 * u[dof * i + a];
    }
    d.law.friction = 0.5;
    d.law.damping = 0.8;
    sp_dynamics_forces(&d, 1.0);
    double sum[3] = {0, 0, 0}, walls[3] = {0, 0, 0}, scale = 0;
    for (int32_t i = 0; i < p.n; i++) {
        double force[3], turn[3];
        sp_dynamics_force_on(&d, i, force, turn);
        for (int a = 0; a < dim; a++)
            sum[a] += force[a];
        scale += fabs(force[up]);
    }
    for (int side = 0; side < 2; side++)
        for (int32_t k = 0; k < d.wall[side].n; k++)
            for (int a = 0; a < dim; a++)
                walls[a] += d.rows.row[d.at.row * (d.rows.wall[side] + k) + a];
    for (int a = 0; a < dim; a++)
        assert_close(sum[a], walls[a], 1e-13 * scale);
    assert_close(sum[up], d.wall_force[0] - d.wall_force[1], 1e-13 * scale);
    assert_true(scale > 1e-4);
    sp_dynamics_free(&d);
    sp_free(u);
    sp_packing_free(&p);
}

TEST(test_momentum) {
    check_momentum(2);
    check_momentum(3);
}

/* The gas of a spec, its grains flying about. */
static dynamics make_gas(const sp_pack_spec *spec, double speed) {
    const size_t n = (size_t)spec->grains;
    double *r = sp_alloc(n, 8), *x = sp_alloc(3 * n, 8), height;
    dynamics d;
    sp_radii_draw(spec, r);
    assert_ok(sp_gas_make(spec, r, x, &height, &err));
    assert_ok(sp_dynamics_make(spec, r, x, height, &d, &err));
    for (int32_t i = 0; i < d.n; i++) {
        double *v = dynamics_grain(&d, i) + d.at.v;
        v[0] = speed * sin(3.0 * i);
        v[1] = speed * cos(7.0 * i);
        if (d.dim == 3)
            v[2] = speed * sin(5.0 * i + 1);
    }
    d.v_max = 2 * speed;
    sp_free(x);
    sp_free(r);
    return d;
}

static bool touching(const dynamics *d, int32_t i, int32_t j) {
    const double *g = dynamics_grain(d, i), *h = dynamics_grain(d, j);
    double square = 0;
    for (int a = 0; a < d->dim; a++) {
        double x = h[a] - g[a];
        if (a < d->dim - 1)
            x -= d->period[a] * nearbyint(x / d->period[a]);
        square += x * x;
    }
    return sqrt(square) < g[d->at.r] + h[d->at.r];
}

/* The pairs on which the kernel found forces are those that touch, each once. Returns how many. */
static int32_t assert_pairs_are_complete(const dynamics *d, uint8_t *seen) {
    int32_t count = 0;
    memset(seen, 0, (size_t)d->n * (size_t)d->n);
    for (int32_t k = 0; k < d->inner.n; k++) {
        const int32_t i = d->inner.i[k], j = d->inner.j[k];
        if (d->rows.row[d->at.row * k + 3] > 0) /* sqrt(m_eff k_n) */
            seen[(i < j ? i : j) * d->n + (i < j ? j : i)]++;
    }
    for (int32_t i = 0; i < d->n; i++)
        for (int32_t j = i + 1; j < d->n; j++) {
            assert_int_equal(seen[i * d->n + j], touching(d, i, j));
            count += seen[i * d->n + j];
        }
    return count;
}

static void check_lists(const sp_pack_spec *spec, double dt) {
    dynamics d = make_gas(spec, 0.05);
    uint8_t *seen = sp_alloc((size_t)d.n * (size_t)d.n, 1);
    int32_t contacts = 0;
    d.law.damping = 0; /* the motion goes on */
    d.law.friction = 0;
    d.dt = dt;
    for (int step = 0; step < 2000; step++) {
        assert_ok(sp_neighbours_refresh(&d, &err));
        sp_dynamics_forces(&d, dt);
        contacts += assert_pairs_are_complete(&d, seen);
        sp_dynamics_advance(&d, dt);
    }
    printf("%dD: %d contacts in 2000 steps, %lld outer and %lld inner lists\n", d.dim, contacts, (long long)d.rebuilds,
           (long long)d.refills);
    assert_true(contacts > 500);
    assert_true(d.rebuilds > 3 && d.refills < 1500); /* not in every step */
    sp_free(seen);
    sp_dynamics_free(&d);
}

TEST(test_lists_equal_brute_force) {
    sp_pack_spec spec = small_spec(2, 11);
    check_lists(&spec, 0.1);
    spec = small_spec(3, 11);
    check_lists(&spec, 0.1);
    for (int dim = 2; dim <= 3; dim++) { /* 10:1 */
        spec = small_spec(dim, 12);
        spec.width = 8;
        spec.depth = dim == 3 ? 8 : 0;
        spec.diameter_min = 0.2;
        spec.diameter_max = 2;
        check_lists(&spec, 0.1);
    }
}

/* Without friction and viscosity a collision keeps its energy; leapfrog's error falls with the square of the step. */
static double energy_error(int dim, double dt) {
    sp_pack_spec spec = small_spec(dim, 1);
    spec.grains = 2;
    spec.friction = 0;
    spec.damping = 0;
    const double r[2] = {0.5, 0.5}, planar[6] = {3, 4, 0, 4.2, 4.1, 0}, spatial[6] = {3, 4, 4, 4.1, 4.2, 4.3};
    dynamics d;
    assert_ok(sp_dynamics_make(&spec, r, dim == 2 ? planar : spatial, 8, &d, &err));
    d.pressure = 0;
    double *one = dynamics_grain(&d, 0) + d.at.v, *two = dynamics_grain(&d, 1) + d.at.v;
    one[0] = 0.05;
    two[0] = -0.05;
    d.dt = dt;
    d.v_max = 0.05;
    for (double t = 0; t < 20; t += dt) {
        assert_ok(sp_neighbours_refresh(&d, &err));
        sp_dynamics_forces(&d, dt);
        sp_dynamics_advance(&d, dt);
    }
    double before = 2 * 0.05 * 0.05, after = 0;
    for (int a = 0; a < dim; a++)
        after += one[a] * one[a] + two[a] * two[a];
    assert_true(one[0] < 0); /* it did collide */
    sp_dynamics_free(&d);
    return fabs(after / before - 1);
}

/* Energy of the grains between fixed walls: velocities in the middle of the steps before and after. */
static double energy_of(const dynamics *d, const double *before) {
    double sum = 0;
    for (int32_t i = 0; i < d->n; i++) {
        const double *g = dynamics_grain(d, i);
        for (int a = 0; a < d->dim; a++) {
            const double v = 0.5 * (g[d->at.v + a] + before[i * d->at.stride + d->at.v + a]);
            sum += 0.5 * v * v / g[d->at.inv_m];
        }
    }
    return sum;
}

static double potential_of(const dynamics *d, const double *g0) {
    const int up = d->dim - 1;
    double sum = 0;
    for (int32_t i = 0; i < d->n; i++) {
        const double *g = g0 + i * d->at.stride, r = g[d->at.r];
        for (int side = 0; side < 2; side++) {
            const double n = r - (side == 0 ? g[up] : d->piston_y - g[up]);
            sum += n > 0 ? 0.4 * n * contact_force(sqrt(r), n) : 0; /* integral of Hertz's law */
        }
        for (int32_t j = i + 1; j < d->n; j++) {
            const double *h = g0 + j * d->at.stride;
            double square = 0;
            for (int a = 0; a < d->dim; a++) {
                double x = h[a] - g[a];
                x -= a < up ? d->period[a] * nearbyint(x / d->period[a]) : 0;
                square += x * x;
            }
            const double n = r + h[d->at.r] - sqrt(square);
            sum += n > 0 ? 0.4 * n * contact_force(contact_stiffness(r, h[d->at.r]), n) : 0;
        }
    }
    return sum;
}

/* Largest relative change of the energy of a gas that flies about for a while. */
static double gas_energy_error(int dim, double dt) {
    sp_pack_spec spec = small_spec(dim, 17);
    spec.grains = 40;
    spec.friction = 0;
    spec.damping = 0;
    spec.piston_mass = 1e30;
    dynamics d = make_gas(&spec, 0.05);
    const size_t size = (size_t)(d.n * d.at.stride) * sizeof(double);
    double *before = sp_alloc(size, 1), first = 0, worst = 0;
    d.dt = dt;
    for (int64_t step = 0; (double)step * dt < 100; step++) {
        assert_ok(sp_neighbours_refresh(&d, &err));
        sp_dynamics_forces(&d, dt);
        memcpy(before, d.g, size);
        sp_dynamics_advance(&d, dt);
        const double energy = energy_of(&d, before) + potential_of(&d, before);
        first = step == 0 ? energy : first;
        worst = fmax(worst, fabs(energy / first - 1));
    }
    sp_free(before);
    sp_dynamics_free(&d);
    return worst;
}

TEST(test_energy) {
    for (int dim = 2; dim <= 3; dim++) {
        assert_true(energy_error(dim, 0.01) < 1e-5);
        assert_true(energy_error(dim, 0.1) < 1e-3);
        const double coarse = gas_energy_error(dim, 0.1), fine = gas_energy_error(dim, 0.05);
        printf("%dD: energy changes by %.3g, at half the step %.3g\n", dim, coarse, fine);
        assert_true(coarse < 1e-2 && fine < 0.4 * coarse);
    }
}

/* ---- a pair that turns as one body --------------------------------------------------------------------------- */

/* v turned about the unit vector e by an angle. */
static void turned(const double e[3], double angle, const double v[3], double out[3]) {
    const double c = cos(angle), s = sin(angle), along = e[0] * v[0] + e[1] * v[1] + e[2] * v[2];
    for (int a = 0; a < 3; a++)
        out[a] =
            c * v[a] + s * (e[(a + 1) % 3] * v[(a + 2) % 3] - e[(a + 2) % 3] * v[(a + 1) % 3]) + (1 - c) * along * e[a];
}

/* Positions of the pair at one time, and the velocities that brought it there. Lever arms are the undeformed radii:
 * a spin Omega (R1 + R2 - n)/(R1 + R2) across the normal is what does not slip, along the normal it is Omega. */
static void place_pair(dynamics *d, const double e[3], double angle, double step, double dt) {
    const double n0[3] = {0, 0.6, 0.8}, r1 = dynamics_radius(d, 0), r2 = dynamics_radius(d, 1), apart = r1 + r2 - 0.1;
    double now[3], past[3], along = 0;
    turned(e, angle, n0, now);
    turned(e, angle - step, n0, past);
    for (int a = 0; a < 3; a++)
        along += e[a] * now[a];
    for (int i = 0; i < 2; i++) {
        double *g = dynamics_grain(d, i), arm = i == 0 ? -0.4 * apart : 0.6 * apart;
        for (int a = 0; a < 3; a++) {
            g[a] = 10 + arm * now[a];
            g[d->at.v + a] = arm * (now[a] - past[a]) / dt;
            g[d->at.w + a] = g[d->at.r] * step / dt * (along * now[a] + (e[a] - along * now[a]) * apart / (r1 + r2));
        }
    }
}

/* How far the tangential force is from the one that has turned with the pair by 2 radians about e, over its size. */
static double carried_error(const double e[3], int steps, bool plain) {
    sp_pack_spec spec = small_spec(3, 1);
    const double r[2] = {0.4, 0.6}, x[6] = {10, 10, 10, 10, 10.54, 10.72}, dt = 0.01, step = 2.0 / steps;
    dynamics d;
    spec.grains = 2;
    spec.width = spec.depth = 20;
    spec.reference = plain;
    assert_ok(sp_dynamics_make(&spec, r, x, 20, &d, &err));
    place_pair(&d, e, 0, step, dt);
    assert_ok(sp_neighbours_refresh(&d, &err));
    pair_list *list = plain ? &d.outer : &d.inner;
    assert_int_equal(list->n, 1);
    const bool swapped = list->i[0] == 1;
    const double size = 0.1 * contact_force(contact_stiffness(r[0], r[1]), 0.1);
    const double t0[3] = {0.6 * size, 0.8 * 0.8 * size, -0.8 * 0.6 * size}; /* across (0, 0.6, 0.8) */
    for (int a = 0; a < 3; a++)
        list->ft[a * list->capacity] = swapped ? -t0[a] : t0[a];
    for (int k = 1; k <= steps; k++) {
        place_pair(&d, e, k * step, step, dt);
        sp_dynamics_forces(&d, dt);
    }
    double right[3], error = 0;
    turned(e, 2.0, t0, right);
    for (int a = 0; a < 3; a++)
        error += pow((swapped ? -1 : 1) * list->ft[a * list->capacity] - right[a], 2);
    sp_dynamics_free(&d);
    return sqrt(error) / size;
}

TEST(test_tangential_force_is_carried) {
    const double axes[4][3] = {{0, 0.6, 0.8}, {1, 0, 0}, {0, 0.8, -0.6}, {2.0 / 3, -1.0 / 3, 2.0 / 3}};
    for (int k = 0; k < 4; k++)
        for (int plain = 0; plain <= 1; plain++) {
            const double coarse = carried_error(axes[k], 20000, plain), fine = carried_error(axes[k], 40000, plain);
            printf("axis %d, %s: error %.3g, at half the step %.3g\n", k, plain ? "plain" : "kernel", coarse, fine);
            assert_true(fine < 5e-3);
            assert_true(fine < 0.55 * coarse || fine < 1e-8);
        }
}

TEST(test_allocation_failures) {
    for (int64_t k = 0; k < 120; k++) {
        sp_pack_spec spec = small_spec(k % 2 ? 2 : 3, 2);
        spec.max_steps = 400;
        sp_packing p = sp_packing_none();
        sp_error err = {0};
        sp_alloc_fail_after(k / 2);
        sp_status status = sp_packing_make(&spec, NULL, NULL, &p, &err);
        sp_alloc_fail_after(-1);
        assert_true(status == SP_ENOMEM || status == SP_EFAILED);
        assert_null(p.x);
    }
}

RUN_TESTS(NULL, NULL)
