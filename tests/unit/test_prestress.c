/* With prestress the springs are the derivative of the forces while packings form: of the very code that makes them. */
#include "carried.h"

#include "network/apply.h"
#include "network/bound.h"
#include "packing/dynamics.h"
#include "packing/prepare.h"
#include "packing/vibrate.h"

#include <float.h>

/* ---- the derivative of the packing stage's forces ------------------------------------------------------------- */

/* The state of rest of a packing, with its tangential forces, in the packing stage's dynamics: no dashpots, and
 * friction that never yields. */
static dynamics at_rest(const sp_packing *p, bool plain) {
    sp_pack_spec spec = sp_pack_spec_default();
    spec.dim = p->dim;
    spec.grains = p->n;
    spec.width = p->box[0];
    spec.depth = p->dim == 3 ? p->box[1] : 0;
    spec.friction = p->friction;
    spec.poisson = p->poisson;
    spec.reference = plain;
    spec = sp_pack_spec_resolve(&spec);
    dynamics d;
    assert_ok(sp_dynamics_make(&spec, p->r, p->x, sp_packing_height(p), &d, &err));
    d.law.friction = 1e9;
    d.law.damping = 0;
    d.v_max = 0.01; /* lists with pairs that stay open */
    d.dt = 5;
    assert_ok(sp_neighbours_refresh(&d, &err));
    pair_list *list = plain ? &d.outer : &d.inner;
    int found = 0;
    for (int32_t c = 0; c < p->n_contacts; c++) {
        const sp_contact *from = &p->contacts[c];
        if (from->j < 0) {
            for (int a = 0; a < p->dim - 1; a++)
                d.wall_ft[from->j == SP_TOP][from->i * (p->dim - 1) + a] = from->ft[a];
            found++;
        }
        for (int32_t k = 0; k < list->n && from->j >= 0; k++) {
            const bool same = list->i[k] == from->i && list->j[k] == from->j;
            if (!same && !(list->i[k] == from->j && list->j[k] == from->i))
                continue;
            if (p->dim == 2)
                list->ft[k] = from->ft[1] * from->n[0] - from->ft[0] * from->n[1];
            for (int a = 0; a < 3 && p->dim == 3; a++)
                list->ft[k + (int64_t)a * list->capacity] = same ? from->ft[a] : -from->ft[a];
            found++;
        }
    }
    assert_int_equal(found, p->n_contacts);
    return d;
}

/* Forces and torques after a drift by h u in one step of the packing stage. */
static void forces_after(const sp_packing *p, const sp_network *net, bool plain, const double *u, double h, double *f) {
    const int dim = net->dim, dof = net->dof;
    dynamics d = at_rest(p, plain);
    for (int32_t k = 0; k < net->n; k++) {
        double *g = dynamics_grain(&d, net->grain[k]);
        const double *x = u + (int64_t)k * dof, sign = h < 0 ? -1 : 1;
        for (int a = 0; a < dim; a++) {
            g[a] += h * x[a];
            g[d.at.v + a] = sign * x[a];
        }
        for (int a = 0; a < dof - dim; a++)
            g[d.at.w + a] = sign * net->r[k] * x[dim + a];
    }
    sp_dynamics_forces(&d, fabs(h));
    for (int32_t k = 0; k < net->n; k++) {
        double force[3], turn[3];
        sp_dynamics_force_on(&d, net->grain[k], force, turn);
        for (int a = 0; a < dim; a++)
            f[(int64_t)k * dof + a] = force[a];
        for (int a = 0; a < dof - dim; a++)
            f[(int64_t)k * dof + dim + a] = net->r[k] * turn[a];
    }
    sp_dynamics_free(&d);
}

/* The same by the motion about rest, as changes. */
static void changes_after(const sp_packing *p, const sp_network *net, const double *u, double h, double *f) {
    const int dim = net->dim, dof = net->dof;
    vibration m;
    assert_ok(sp_vibration_make(p, 0, &m, &err));
    m.friction = 1e9;
    for (int32_t k = 0; k < net->n; k++)
        for (int a = 0; a < dof; a++) /* in the plane the angle is about z */
            m.u[6 * (int64_t)net->grain[k] + (dim == 2 && a == 2 ? 5 : a)] = h * u[(int64_t)k * dof + a];
    sp_vibration_begin(&m);
    for (int32_t k = 0; k < net->n; k++)
        for (int a = 0; a < dof; a++) {
            const int to = dim == 2 && a == 2 ? 5 : a;
            f[(int64_t)k * dof + a] = m.a[6 * (int64_t)net->grain[k] + to] * net->mass[(int64_t)k * dof + a];
        }
    sp_vibration_free(&m);
}

typedef enum stage { KERNEL = 0, PLAIN, VIBRATION, STAGES } stage;

/* Largest |(f(h u) - f(-h u))/2h + J u| over the largest |J u|. */
static double jacobian_error(const sp_packing *p, const sp_network *net, stage by, const double *u, double h) {
    const size_t n = (size_t)sp_network_dofs(net);
    double *f = calloc(3 * n, sizeof *f), worst = 0, largest = 0;
    for (int side = 0; side < 2; side++) {
        if (by == VIBRATION)
            changes_after(p, net, u, side ? -h : h, f + (size_t)side * n);
        else
            forces_after(p, net, by == PLAIN, u, side ? -h : h, f + (size_t)side * n);
    }
    sp_network_apply(net, u, f + 2 * n);
    for (size_t k = 0; k < n; k++) {
        worst = fmax(worst, fabs((f[k] - f[n + k]) / (2 * h) + f[2 * n + k]));
        largest = fmax(largest, fabs(f[2 * n + k]));
    }
    free(f);
    return worst / largest;
}

/* In the plane and in space, with walls, tangential forces everywhere, all of it sticking: the error falls as h^2.
 * What tangential forces add is far larger than the error. */
TEST(test_jacobian) {
    for (int dim = 2; dim <= 3; dim++)
        for (int by = 0; by < STAGES; by++) {
            FREED(sp_packing) p = carried_packing(dim, dim == 2 ? 6 : 4, 0.4, 7 + (unsigned)dim);
            FREED(sp_network) net = carried_network(&p);
            assert_non_null(net.carried);
            RELEASED double *u = carried_vector(sp_network_dofs(&net));
            const double h = 4e-4, e1 = jacobian_error(&p, &net, (stage)by, u, h),
                         e2 = jacobian_error(&p, &net, (stage)by, u, h / 2);
            assert_true(e1 < 1e-3);
            assert_close(log2(e1 / e2), 2, 0.1);
            sp_carried *carried = net.carried;
            net.carried = NULL;
            assert_true(jacobian_error(&p, &net, (stage)by, u, h / 2) > 10 * e1);
            net.carried = carried;
        }
}

/* A packing under the piston: forces at rest as they come about, friction that may yield but does not. */
TEST(test_packed) {
    for (int dim = 2; dim <= 3; dim++) {
        sp_pack_spec spec = sp_pack_spec_default();
        FREED(sp_packing) p = sp_packing_none();
        spec.dim = dim;
        spec.grains = dim == 2 ? 60 : 100;
        spec.width = dim == 2 ? 6 : 5;
        spec.pressure = 1e-3;
        spec.seed = 3;
        assert_ok(sp_packing_make(&spec, NULL, NULL, &p, &err));
        FREED(sp_network) net = carried_network(&p);
        RELEASED double *u = carried_vector(sp_network_dofs(&net));
        assert_non_null(net.carried);
        assert_true(jacobian_error(&p, &net, VIBRATION, u, 1e-8) < 1e-5);
    }
}

/* ---- turned as a whole ---------------------------------------------------------------------------------------- */

static void cross(const double a[3], const double b[3], double out[3]) {
    for (int k = 0; k < 3; k++)
        out[k] = a[(k + 1) % 3] * b[(k + 2) % 3] - a[(k + 2) % 3] * b[(k + 1) % 3];
}

/* Drops walls and what reaches through the periodic sides. */
static void cut_free(sp_packing *p) {
    int32_t kept = 0;
    for (int32_t k = 0; k < p->n_contacts; k++) {
        const sp_contact *c = &p->contacts[k];
        bool inside = c->j >= 0;
        for (int a = 0; a < 3 && inside; a++)
            inside = fabs(p->x[3 * c->j + a] - p->x[3 * c->i + a]) < 0.5 * p->box[a];
        if (inside)
            p->contacts[kept++] = *c;
    }
    p->n_contacts = kept;
}

/* A free cluster that turns carries its forces and torques with it, but for the slip by undeformed lever arms, which is
 * the overlap times the angle. */
TEST(test_turned) {
    for (int dim = 2; dim <= 3; dim++) {
        FREED(sp_packing) p = carried_packing(dim, dim == 2 ? 5 : 4, 0.4, 31);
        cut_free(&p);
        FREED(sp_network) net = carried_network(&p);
        const int dof = net.dof;
        const int64_t n = sp_network_dofs(&net);
        const double angle[3] = {dim == 3 ? 0.3 : 0, dim == 3 ? -0.7 : 0, 0.5};
        double *u = calloc((size_t)n, sizeof *u), *ju = calloc((size_t)n, sizeof *ju), largest = 0;
        double(*load)[2][3] = calloc((size_t)net.n, sizeof *load), (*slip)[2][3] = calloc((size_t)net.n, sizeof *slip);
        for (int32_t i = 0; i < net.n; i++) {
            double moved[3];
            cross(angle, net.x + 3 * i, moved);
            for (int a = 0; a < dim; a++)
                u[i * dof + a] = moved[a];
            for (int a = 0; a < dof - dim; a++)
                u[i * dof + dim + a] = dim == 2 ? angle[2] : angle[a];
        }
        for (int32_t k = 0; k < net.n_springs; k++) {
            const sp_spring *s = &net.springs[k];
            const sp_contact *c = &p.contacts[s->contact];
            double whole[3], torque[3], s3[3], lever[3];
            cross(angle, s->n, s3);
            for (int a = 0; a < 3; a++) {
                s3[a] *= -c->overlap * s->kt;
                whole[a] = c->ft[a] - c->fn * s->n[a];
            }
            double off = 0;
            for (int a = 0; a < 3; a++)
                off += s3[a] * s->n[a];
            cross(s->n, c->ft, torque);
            cross(s->n, s3, lever);
            for (int a = 0; a < 3; a++) {
                load[s->i][0][a] += whole[a];
                load[s->j][0][a] -= whole[a];
                load[s->i][1][a] += s->ri * torque[a];
                load[s->j][1][a] += s->rj * torque[a];
                slip[s->i][0][a] += s3[a] - off * s->n[a];
                slip[s->j][0][a] -= s3[a] - off * s->n[a];
                slip[s->i][1][a] += s->ri * lever[a];
                slip[s->j][1][a] += s->rj * lever[a];
            }
        }
        sp_network_apply(&net, u, ju);
        for (int64_t k = 0; k < n; k++)
            largest = fmax(largest, fabs(ju[k]));
        for (int32_t i = 0; i < net.n; i++) {
            double turned[2][3];
            for (int q = 0; q < 2; q++)
                cross(angle, load[i][q], turned[q]);
            for (int a = 0; a < dof; a++) {
                const int q = a >= dim, b = q ? (dim == 2 ? 2 : a - dim) : a;
                assert_close(-ju[i * dof + a], turned[q][b] + slip[i][q][b], 1e-12 * largest);
            }
        }
        free(u);
        free(ju);
        free(load);
        free(slip);
    }
}

/* ---- one operator --------------------------------------------------------------------------------------------- */

static double dot(int64_t n, const double *x, const double *y) {
    double sum = 0;
    for (int64_t k = 0; k < n; k++)
        sum += x[k] * y[k];
    return sum;
}

/* Assembled as a whole, its symmetric part, applied, transposed, as energy, two at once: the same J. */
TEST(test_assembled) {
    for (int dim = 2; dim <= 3; dim++) {
        FREED(sp_packing) p = carried_packing(dim, dim == 2 ? 6 : 4, 0.4, 41);
        FREED(sp_network) net = carried_network(&p);
        const int64_t n = sp_network_dofs(&net);
        RELEASED double *u = carried_vector(n), *v = carried_vector(n), *x = calloc(5 * (size_t)n, sizeof *x);
        double *ju = x, *jtv = x + n, *whole = x + 2 * n, *back = x + 3 * n, *half = x + 4 * n, largest = 0;
        FREED(sp_sparse) j, s;
        assert_ok(sp_network_assemble_whole(&net, &j, &err));
        assert_ok(sp_network_assemble(&net, &s, &err));
        for (int64_t c = 0; c < n; c++) {
            for (int64_t q = j.p[c]; q < j.p[c + 1]; q++) {
                assert_true(q == j.p[c] || j.i[q] > j.i[q - 1]);
                whole[j.i[q]] += j.x[q] * u[c];
                back[c] += j.x[q] * v[j.i[q]];
                largest = fmax(largest, fabs(j.x[q]));
            }
            for (int64_t q = s.p[c]; q < s.p[c + 1]; q++) {
                half[s.i[q]] += s.x[q] * u[c];
                if (s.i[q] != c)
                    half[c] += s.x[q] * u[s.i[q]];
            }
        }
        sp_network_apply(&net, u, ju);
        sp_network_apply_transposed(&net, v, jtv);
        double rounding, asymmetry = 0;
        const double energy = sp_network_energy2_bound(&net, u, &rounding);
        assert_close(energy, dot(n, u, ju), 1e-13 * (double)n * largest);
        assert_true(rounding > 0 && rounding < 1e-12 * (double)n * largest);
        assert_close(dot(n, v, ju), dot(n, u, jtv), 1e-13 * (double)n * largest);
        for (int64_t k = 0; k < n; k++) {
            assert_close(whole[k], ju[k], 30 * DBL_EPSILON * largest);
            assert_close(back[k], jtv[k], 30 * DBL_EPSILON * largest);
        }
        sp_network_apply_transposed(&net, u, jtv);
        for (int64_t k = 0; k < n; k++) {
            assert_close(half[k], 0.5 * (ju[k] + jtv[k]), 30 * DBL_EPSILON * largest);
            asymmetry = fmax(asymmetry, fabs(ju[k] - jtv[k]));
        }
        assert_true(asymmetry > 1e-3 * largest);
    }
}

/* Power steps with the antisymmetric (sign -1) or symmetric part of M^-1/2 J M^-1/2: its norm, from below. */
static double norm_of(const sp_network *net, double sign) {
    const int64_t n = sp_network_dofs(net);
    double *x = carried_vector(n), *y = calloc(2 * (size_t)n, sizeof *y), *z = y + n, norm = 0;
    for (int step = 0; step < 200; step++) {
        for (int64_t k = 0; k < n; k++)
            x[k] /= sqrt(net->mass[k]);
        sp_network_apply(net, x, y);
        sp_network_apply_transposed(net, x, z);
        for (int64_t k = 0; k < n; k++)
            x[k] = 0.5 * (y[k] + sign * z[k]) / sqrt(net->mass[k]);
        norm = sqrt(dot(n, x, x));
        for (int64_t k = 0; k < n; k++)
            x[k] /= norm;
    }
    free(x);
    free(y);
    return norm;
}

/* The bounds hold and are near; without tangential forces, or without prestress, K is symmetric. */
TEST(test_bounds) {
    for (int dim = 2; dim <= 3; dim++) {
        FREED(sp_packing) p = carried_packing(dim, dim == 2 ? 6 : 4, 0.4, 47);
        sp_network net = carried_network(&p);
        const double skew = norm_of(&net, -1), fastest = sqrt(norm_of(&net, 1));
        double largest = 0;
        assert_ok(sp_network_find_largest(&net, &largest, &err));
        assert_true(largest > fastest * (1 - 1e-10) && largest < fastest * 1.01);
        assert_true(largest < sp_network_omega_bound(&net));
        assert_true(skew <= sp_network_skew(&net) && sp_network_skew(&net) < 3 * skew);
        assert_true(sp_network_soft(&net) > 0);
        sp_error reason = {0};
        assert_int_equal(sp_network_need_symmetry(&net, "this", &reason), SP_EREFUSED);
        assert_true(test_names(reason.text, "this"));
        sp_network_free(&net);
        for (int c = 0; c < p.n_contacts; c++)
            memset(p.contacts[c].ft, 0, sizeof p.contacts[c].ft);
        net = carried_network(&p);
        assert_null(net.carried);
        assert_true(sp_network_skew(&net) == 0 && sp_network_soft(&net) > 0);
        assert_ok(sp_network_need_symmetry(&net, "this", &err));
        sp_network_free(&net);
    }
}

RUN_TESTS(NULL, NULL)
