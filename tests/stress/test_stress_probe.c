/* Probes of every hard network against quadruple precision: sines and lines, along and across, each within the error
 * that is told, or refused. */
#include "stress/exact.h"
#include "stress/networks.h"
#include "stress/record.h"

#include <sonopack/elastic.h>

static const double PI = 3.14159265358979323846;

static quad area_of(const sp_network *net) {
    return (quad)(net->dim > 1 ? net->box[0] : 1) * (net->dim > 2 ? net->box[1] : 1);
}

/* Whether both walls resist shear. */
static bool grips(const sp_network *net) {
    bool bottom = false, top = false;
    for (int k = net->n_bulk; k < net->n_springs; k++)
        if (net->springs[k].kt > 0)
            *(net->springs[k].j == SP_TOP ? &top : &bottom) = true;
    return bottom && top;
}

/* ---- sines ---------------------------------------------------------------------------------------------------- */

/* What no spring resists is left out of the force, in the metric of the masses. */
static quad exact_sine(const sp_network *net, const exact *x, int waves, int axis) {
    const int up = net->dim - 1, n = x->n;
    const quad height = net->box[up];
    quad sum = 0;
    for (int m = 0; m < n; m++) {
        quad part = 0;
        if (!(x->lambda[m] > x->lambda[n - 1] * 1e-28L))
            continue;
        for (int i = 0; i < net->n; i++) {
            const double r = net->r[i], wave = waves * PI / net->box[up], volume = 4 * PI / 3 * (r * r * r) / 0.5;
            part += x->e[m * n + i * net->dof + axis] * (volume * sin(wave * net->x[3 * i + up])) /
                    quad_sqrt(net->mass[i * net->dof + axis]);
        }
        sum += part * part / x->lambda[m];
    }
    return area_of(net) * height * height * height / (2 * waves * waves * (quad)PI * PI * sum);
}

/* What counts as floppy, though springs do resist it a little, is told in left_out. */
static bool has_nearly_floppy(const exact *x) {
    const quad top = x->lambda[x->n - 1];
    for (int m = 0; m < x->n; m++)
        if (x->lambda[m] > 1e-28L * top && x->lambda[m] < 1e-8L * top)
            return true;
    return false;
}

/* ---- lines ---------------------------------------------------------------------------------------------------- */

/* Displacement between lines: those with an odd number move, by turns up and down. */
static double line_field(double height, int lines, double y) {
    static const double turns[] = {0, 1, 0, -1};
    const double at = y * (lines + 1) / height, k = fmax(0, fmin(lines, floor(at)));
    return turns[(int)k % 4] + (at - k) * (turns[((int)k + 1) % 4] - turns[(int)k % 4]);
}

/* f . K^+ f for a positive K and a force f in its range, by elimination with the largest pivot. Destroys both. */
static quad work_of(int n, quad *k, quad *f) {
    RELEASED bool *done = calloc(n > 0 ? (size_t)n : 0, sizeof *done);
    quad first = 0, work = 0;
    for (int turn = 0; turn < n; turn++) {
        int best = -1;
        for (int i = 0; i < n; i++)
            if (!done[i] && (best < 0 || k[i * n + i] > k[best * n + best]))
                best = i;
        const quad pivot = k[best * n + best];
        first = turn == 0 ? pivot : first;
        if (!(pivot > first * 1e-28L)) /* what is left is floppy */
            break;
        done[best] = true;
        work += f[best] * f[best] / pivot;
        for (int i = 0; i < n; i++) {
            const quad factor = done[i] ? 0 : k[i * n + best] / pivot;
            if (!(quad_abs(factor) > 0))
                continue;
            f[i] -= factor * f[best];
            for (int j = 0; j < n; j++)
                k[i * n + j] -= factor * k[best * n + j];
        }
    }
    return work;
}

static quad exact_lines(const sp_network *net, int lines, int axis) {
    const int n = (int)sp_network_dofs(net), up = net->dim - 1;
    const double height = net->box[up], between = height / (lines + 1);
    quad *k = exact_stiffness(net), *u = calloc((size_t)n, sizeof *u), *f = calloc((size_t)n, sizeof *f), whole = 0;
    int *from = calloc((size_t)n, sizeof *from), left = 0;
    for (int i = 0; i < n; i++) {
        const int grain = i / net->dof, part = i % net->dof;
        const double y = net->x[3 * grain + up], r = net->r[grain];
        const int line = (int)fmax(1, ceil((y - r) / between));
        const bool fixed = part < net->dim && line <= lines && line <= floor((y + r) / between);
        if (fixed && part == axis)
            u[i] = line_field(height, lines, y);
        if (!fixed)
            from[left++] = i;
    }
    for (int i = 0; i < n; i++) {
        for (int j = 0; j < n; j++)
            f[i] += k[i * n + j] * u[j];
        whole += u[i] * f[i];
    }
    for (int i = 0; i < left; i++)
        f[i] = f[from[i]];
    for (int i = 0; i < left; i++)
        for (int j = 0; j < left; j++)
            k[i * left + j] = k[from[i] * n + from[j]];
    whole -= work_of(left, k, f);
    free(k);
    free(u);
    free(f);
    free(from);
    return height * whole / ((quad)(lines + 1) * (lines + 1) * area_of(net));
}

/* The exact modulus of motion along an axis. */
static quad exact_probe(const sp_network *net, const exact *x, const sp_probe *probe, int axis) {
    return probe->kind == SP_PROBE_SINE ? exact_sine(net, x, probe->n, axis) : exact_lines(net, probe->n, axis);
}

static void run_probe(stress_record *r, const char *network, const sp_network *net, const exact *x, sp_probe probe) {
    const bool sine = probe.kind == SP_PROBE_SINE;
    sp_probe_moduli p;
    sp_error err = {0};
    char what[32];
    snprintf(what, sizeof what, "%s %d", sine ? "sine" : "lines", probe.n);
    const sp_status status = sp_moduli_probe(net, 0.5, 1, &probe, NULL, &p, &err);
    if (status != SP_OK) {
        stress_refuse(r, network, "probe", what, status, &err);
        return;
    }
    if (sine && p.left_out > 0 && has_nearly_floppy(x))
        return;
    const quad along = exact_probe(net, x, &probe, net->dim - 1);
    stress_agree(r, network, "probe", what, (double)quad_abs(p.along - along), p.error_along, (double)along);
    if (isnan(p.shear) || (sine && !grips(net))) /* smooth walls are sheared by a cosine */
        return;
    const quad shear = exact_probe(net, x, &probe, 0);
    stress_agree(r, network, "probe, shear", what, (double)quad_abs(p.shear - shear), p.error_shear, (double)shear);
}

TEST(test_hard_networks) {
    stress_record r = stress_open();
    for (int k = 0; k < STRESS_CASES; k++) {
        const stress_case *c = &stress_cases[k];
        FREED(sp_network) net = c->make(c->value, 1);
        FREED(exact) x = exact_solve(&net);
        for (int waves = 1; waves <= 3; waves++)
            run_probe(&r, c->name, &net, &x, (sp_probe){SP_PROBE_SINE, waves});
        for (int lines = 1; lines <= 3; lines += 2)
            run_probe(&r, c->name, &net, &x, (sp_probe){SP_PROBE_LINES, lines});
    }
    stress_close(&r);
    assert_true(r.agreed > 150);
    assert_int_equal(r.wrong, 0);
}

RUN_TESTS_WHERE(STRESS_QUAD, NULL, NULL)
