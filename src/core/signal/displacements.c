/* Displacements of all grains at given times. */
#include "base/base.h"
#include "modes/count.h"
#include "numeric/bessel.h"
#include "signal/pass.h"

#include <float.h>
#include <math.h>
#include <sonopack/signal.h>
#include <string.h>

enum { TERMS_MAX = 20000000, TIMES_MAX = 1000000 };
/* Rounding errors in units of DBL_EPSILON: of one step of the recurrence, and of Omega t. */
#define STEP_ROUNDING  5.0
#define PHASE_ROUNDING 5.0
#define TAIL           1e-17 /* remainder of the series, relative to the norm of the source */

typedef struct field {
    const sp_network *net;
    const sp_field_options *spec;
    bool velocity;
    double omega, norm; /* upper bound of the frequencies; |a|, or |u_0| in the metric of the masses */
    sp_operator op;
    recurrence r;
    sparse_row from;
    int64_t terms;
    double *j;                      /* [times][terms] J_(2k+1) or J_2k, the latter halved at k = 0 */
    double *tail, *steps, *largest; /* [times] remainder; squared rounding errors of steps; squares of the terms */
    double *sum;                    /* [times][(n + 1) row] in the operator's order */
} field;

static void field_free(field *f) {
    sp_recurrence_free(&f->r);
    sp_operator_free(&f->op);
    sp_sparse_row_free(&f->from);
    sp_free(f->j);
    sp_free(f->tail);
    sp_free(f->sum);
}

static sp_status check(const sp_field_options *spec, double omega, double *until, sp_error *err) {
    if (spec->times < 1 || spec->times > TIMES_MAX || !spec->t)
        return sp_fail(err, SP_EINVAL, "%d times, must be 1 .. %d", spec->times, TIMES_MAX);
    *until = 0;
    for (int32_t l = 0; l < spec->times; l++) {
        if (!(spec->t[l] >= 0 && isfinite(spec->t[l])))
            return sp_fail(err, SP_EINVAL, "time %d of the field is %g, must be 0 or above", l + 1, spec->t[l]);
        *until = fmax(*until, spec->t[l]);
    }
    if (0.5 * omega * *until > TERMS_MAX)
        return sp_fail(err, SP_EREFUSED, "time %g needs %.3g matrix products, must be at most %d", *until,
                       0.5 * omega * *until, TERMS_MAX);
    return SP_OK;
}

static sp_status make_source(field *f, sp_error *err) {
    const sp_place wall = sp_place_wall();
    const int64_t n = sp_network_dofs(f->net);
    double *vector = sp_alloc((size_t)n, sizeof *vector);
    sp_status status = vector ? SP_OK : sp_fail_memory(err, (size_t)n * sizeof *vector);
    if (status == SP_OK)
        status = sp_network_source_at(f->net, f->spec->source, f->spec->from ? f->spec->from : &wall, vector, err);
    if (status == SP_OK)
        status = sp_sparse_row_make(n, vector, &f->from, err);
    if (status == SP_OK)
        sp_sparse_row_turn(&f->op, f->velocity ? NULL : f->net->mass, &f->from);
    sp_free(vector);
    return status;
}

/* Bessel functions at all times, and the remainder beyond the last term. */
static sp_status make_weights(field *f, double until, sp_error *err) {
    const size_t times = (size_t)f->spec->times;
    const double spread = sp_expansion_spread(f->net);
    sp_status status = sp_expansion_terms(f->net, until, f->velocity, TAIL, &f->terms, err);
    if (status != SP_OK)
        return status;
    const int64_t orders = sp_bessel_orders(f->omega * until);
    double *all = sp_alloc((size_t)orders, sizeof *all);
    f->j = sp_alloc(times * (size_t)f->terms, sizeof *f->j);
    f->tail = sp_alloc(times, 3 * sizeof *f->tail);
    if (!all || !f->j || !f->tail) {
        sp_free(all);
        return sp_fail_memory(err, times * (size_t)f->terms * sizeof *f->j);
    }
    f->steps = f->tail + times;
    f->largest = f->steps + times;
    for (size_t l = 0; l < times; l++) {
        double *j = f->j + l * (size_t)f->terms;
        sp_bessel_j(f->omega * f->spec->t[l], orders, all);
        for (int64_t k = 0; 2 * k + 1 < orders; k++) {
            const double value = all[2 * k + f->velocity];
            if (k < f->terms)
                j[k] = k == 0 && !f->velocity ? 0.5 * value : value;
            else if (!(spread > 0))
                f->tail[l] += sp_expansion_weight(f->velocity, k) * fabs(value);
        }
        if (spread > 0)
            f->tail[l] = sp_expansion_tail(f->omega * f->spec->t[l], f->velocity, spread, f->terms);
        f->tail[l] += 1e-19; /* orders set to 0 as negligible */
    }
    sp_free(all);
    return SP_OK;
}

static sp_status make(field *f, double until, sp_error *err) {
    sp_status status = sp_operator_make(f->net, &f->op, err);
    if (status == SP_OK)
        status = make_source(f, err);
    if (status == SP_OK)
        status = make_weights(f, until, err);
    if (status == SP_OK)
        status = sp_recurrence_make(&f->op, f->net->mass, f->omega, f->spec->threads, &f->r, err);
    if (status != SP_OK)
        return status;
    const size_t size = (size_t)(f->op.n + 1) * (size_t)f->op.row;
    f->sum = sp_alloc((size_t)f->spec->times * size, sizeof *f->sum);
    if (!f->sum)
        return sp_fail_memory(err, (size_t)f->spec->times * size * sizeof *f->sum);
    sp_recurrence_start(&f->r, 0, f->velocity, &f->from);
    f->norm = sqrt(f->r.start[0]);
    return SP_OK;
}

/* Adds term k at all times at which it is not negligible. */
static void add_term(field *f, int64_t k, double squares) {
    const size_t size = (size_t)f->op.n * (size_t)f->op.row, stride = size + (size_t)f->op.row;
    for (int32_t l = 0; l < f->spec->times; l++) {
        const double j = f->j[(size_t)l * (size_t)f->terms + (size_t)k];
        double *restrict sum = f->sum + (size_t)l * stride;
        if (fabs(j) < 1e-30)
            continue;
        for (size_t q = 0; q < size; q++)
            sum[q] += j * f->r.u[q];
        f->steps[l] += j * j * squares * (1 + (double)k);
        f->largest[l] += j * j * squares;
    }
}

/* |W_k a| <= (2 k + 1)|a| and |T_k u| <= |u|. Larger values indicate an imaginary frequency. */
static sp_status follow(field *f, sp_error *err) {
    const double allowed = sp_expansion_growth(sp_expansion_spread(f->net));
    for (int64_t k = 0; k < f->terms; k++) {
        const double squares = sp_recurrence_squares(&f->r)[0];
        const double growth = sp_expansion_weight(f->velocity, k) * allowed * f->norm;
        if (!(squares <= growth * growth))
            return sp_fail(err, SP_EREFUSED, "the motion grows without bound: the network is unstable (prestress)");
        add_term(f, k, squares);
        if (k + 1 < f->terms)
            sp_recurrence_step(&f->r);
    }
    return SP_OK;
}

/* The bounds hold for |M^1/2 u|, hence for a component of u after division by the root of its mass. */
static void finish(const field *f, double *u, double *errors) {
    const sp_operator *op = &f->op;
    const size_t stride = (size_t)(op->n + 1) * (size_t)op->row;
    const int64_t n = sp_network_dofs(f->net);
    const double scale = f->velocity ? 2 / f->omega : 2;
    double lightest = INFINITY;
    for (int64_t dof = 0; dof < n; dof++)
        lightest = fmin(lightest, f->net->mass[dof]);
    for (int32_t l = 0; l < f->spec->times; l++) {
        const double x = f->omega * f->spec->t[l], *sum = f->sum + (size_t)l * stride;
        for (int64_t dof = 0; dof < n; dof++) {
            const int64_t row = op->row_of[dof / op->dof], a = dof % op->dof;
            u[l * n + dof] = scale * sum[sp_operator_at(op, dof)] / op->scale[row * op->dof + a];
        }
        const double left = f->tail[l] + sp_recurrence_dropped(&f->r, f->terms);
        const double rounding = STEP_ROUNDING * sqrt(f->steps[l]) + PHASE_ROUNDING * (1 + x) * sqrt(f->largest[l]);
        if (errors)
            errors[l] = scale * (f->norm * left + DBL_EPSILON * rounding) / sqrt(lightest);
    }
}

sp_status sp_signal_field(const sp_network *net, const sp_field_options *spec, double *u, double *errors,
                          sp_error *err) {
    field f = {.net = net, .spec = spec, .velocity = spec->source != SP_SOURCE_DISPLACEMENT};
    double until = 0;
    f.omega = sp_network_omega_bound(net);
    sp_status status = check(spec, f.omega, &until, err);
    if (status == SP_OK && !net->carried)
        status = sp_need_bounded(net, until, err);
    if (status == SP_OK)
        status = make(&f, until, err);
    if (status == SP_OK)
        status = follow(&f, err);
    if (status == SP_OK)
        finish(&f, u, errors);
    field_free(&f);
    return status;
}
