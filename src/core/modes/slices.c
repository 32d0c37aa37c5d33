/* Finds all eigenpairs between two shifts, slice by slice, and proves that none is missing. */
#include "modes/slices.h"
#include "base/base.h"
#include "linalg/lanczos.h"

#include <float.h>
#include <math.h>
#include <string.h>

enum {
    /* modes per slice: the cost of a basis grows as the square, while each slice costs two factorizations */
    SLICE = 128,
    SLICE_ARPACK = 48, /* its orthogonalization takes one vector after another, and is bound by memory */
    SPARE = 6,         /* additional modes among which a gap for the edge is sought */
    DEPTH_MAX = 60,    /* halvings of the interval */
    LOCKED_MAX = 32
};

static const double LIFT = 1.25; /* where spins go, in units of the upper bound of the spectrum */

void sp_slicer_free(slicer *z) {
    sp_ldl_free(z->ldl);
    sp_free(z->ritz);
    sp_free(z->vector);
    sp_lanczos_free(&z->last);
    sp_null_motions_free(&z->null);
    *z = (slicer){0};
}

/* Adds LIFT top s s^T for each spin s to the lower triangle, in the block of its own grain. */
static void lift_spins(const slicer *z, sp_sparse *a) {
    const int dof = z->net->dof;
    for (int64_t q = 0; q < z->null.spins; q++) {
        const double *s = z->null.spin[q];
        for (int c = 0; c < dof; c++)
            for (int r = c; r < dof; r++)
                a->x[a->p[(int64_t)z->null.grain[q] * dof + c] + r - c] += LIFT * z->top * s[r] * s[c];
    }
}

sp_status sp_slicer_make(const sp_network *net, bool vectors, slicer *out, sp_error *err) {
    const double omega = sp_network_omega_bound(net);
    slicer z = {.net = net, .vectors = vectors, .tolerance = 1e-10, .n = sp_network_dofs(net), .top = omega * omega};
    sp_sparse a = {0};
    sp_status status = sp_null_motions_make(net, &z.null, err);
    /* An entry is a sum of some tens of products of three factors, scaled by two square roots. A spin moves alone as
     * far as A times its vector vanishes. */
    z.noise = 64 * DBL_EPSILON * z.top + 8 * omega * z.null.stretch;
    z.modes = z.n - z.null.spins - z.null.rigid;
    if (status == SP_OK && !(z.ritz = sp_alloc(1, sizeof *z.ritz))) /* where there are no modes, an empty list */
        status = sp_fail_memory(err, sizeof *z.ritz);
    if (status == SP_OK)
        status = sp_network_assemble(net, &a, err);
    for (int64_t c = 0; status == SP_OK && c < a.n; c++)
        for (int64_t k = a.p[c]; k < a.p[c + 1]; k++)
            a.x[k] /= sqrt(net->mass[c] * net->mass[a.i[k]]);
    if (status == SP_OK) {
        lift_spins(&z, &a);
        status = sp_ldl_make(&a, net, &z.ldl, err);
    }
    sp_sparse_free(&a);
    if (status == SP_OK)
        *out = z;
    else
        sp_slicer_free(&z);
    return status;
}

static int64_t slice_size(const slicer *z) { return z->solver == SP_SOLVER_ARPACK ? SLICE_ARPACK : SLICE; }

sp_ritz sp_slicer_null(const slicer *z) {
    const double energy = z->null.stretch * z->null.stretch;
    return (sp_ritz){.error = energy, .residual = sqrt(energy * z->top), .rounding = energy};
}

/* Makes room for `count` modes, and puts the null motions in front of them if these are wanted. */
static sp_status reserve(slicer *z, int64_t count, sp_error *err) {
    z->front = z->null_rows ? z->null.spins + z->null.rigid : 0;
    const size_t rows = (size_t)(z->front + count);
    const double bytes = (double)rows * ((double)z->n * (z->vectors ? sizeof(double) : 0) + sizeof(sp_ritz));
    if (bytes > 0.8 * sp_memory_limit())
        return sp_fail(err, SP_EREFUSED, "%lld modes of %lld degrees of freedom take %.3g GB, must be below %.3g",
                       (long long)rows, (long long)z->n, bytes * 1e-9, 0.8e-9 * sp_memory_limit());
    sp_free(z->ritz);
    sp_free(z->vector);
    z->found = 0;
    z->capacity = count;
    z->vector = NULL;
    z->ritz = sp_alloc(rows, sizeof *z->ritz);
    if (z->vectors)
        z->vector = sp_alloc_bare(rows, (size_t)z->n * sizeof *z->vector);
    if (!z->ritz || (z->vectors && !z->vector))
        return sp_fail_memory(err, (size_t)bytes);
    for (int64_t k = 0; k < z->front; k++) {
        z->ritz[k] = sp_slicer_null(z);
        if (z->vectors)
            sp_null_motions_vector(z->net, &z->null, k, z->vector + k * z->n);
    }
    return SP_OK;
}

static sp_status factor(slicer *z, double sigma, slice_edge *out, sp_error *err) {
    z->factors++;
    sp_status status = sp_ldl_factor(z->ldl, sigma, err);
    if (status != SP_OK)
        return status;
    *out = (slice_edge){sigma, sp_ldl_error(z->ldl) + z->noise, sp_ldl_negative(z->ldl)};
    if (sigma > 0)
        out->below -= z->null.rigid; /* which is wrong if the error exceeds sigma; nobody relies on such an edge */
    return SP_OK;
}

/* The solver at the last factor, orthogonal to rigid motions and to spec.locked. */
static sp_status search(slicer *z, sp_lanczos_spec spec, sp_lanczos_pairs *p, sp_error *err) {
    const size_t n = (size_t)z->n, rigid = (size_t)z->null.rigid, others = (size_t)spec.locked_count;
    double *both = NULL;
    if (others == 0)
        spec.locked = z->null.motion;
    else if (rigid > 0) {
        both = sp_alloc(rigid + others, n * sizeof *both);
        if (!both)
            return sp_fail_memory(err, (rigid + others) * n * sizeof *both);
        memcpy(both, z->null.motion, rigid * n * sizeof *both);
        memcpy(both + rigid * n, spec.locked, others * n * sizeof *both);
        spec.locked = both;
    }
    spec.locked_count += z->null.rigid;
    sp_status status = z->solver == SP_SOLVER_ARPACK ? sp_arpack(z->ldl, z->n, &spec, p, err)
                                                     : sp_lanczos(z->ldl, z->n, &spec, p, err);
    sp_free(both);
    if (status == SP_OK)
        z->solves += p->solves;
    return status;
}

sp_status sp_slicer_edge(slicer *z, double low, double high, slice_edge *out, sp_error *err) {
    /* irregular fractions, since pivots of ordered packings vanish at simple ones */
    static const double places[] = {0.5137, 0.3719, 0.6473, 0.2311, 0.7829, 0.1093, 0.9117};
    slice_edge best = {.error = HUGE_VAL};
    sp_error reason = {0};
    for (size_t k = 0; k < sizeof places / sizeof *places && best.error > 0.1 * (high - low); k++) {
        slice_edge e;
        const sp_status status = factor(z, low + places[k] * (high - low), &e, &reason);
        if (status != SP_OK && status != SP_EREFUSED)
            return sp_fail(err, status, "%s", reason.text);
        if (status == SP_OK && e.error < best.error && (e.error < fabs(e.sigma) || z->null.rigid == 0))
            best = e;
    }
    if (!(best.error < 0.5 * (high - low)))
        return sp_fail(err, SP_EREFUSED,
                       "the number of modes below omega^2 = %.6g .. %.6g cannot be certified (the best factor has an "
                       "error of %.3g)",
                       low, high, best.error);
    if (sp_ldl_sigma(z->ldl) != best.sigma) {
        sp_status status = factor(z, best.sigma, &best, err);
        if (status != SP_OK)
            return status;
    }
    *out = best;
    return SP_OK;
}

sp_status sp_slicer_bottom(slicer *z, double depth, slice_edge *out, sp_error *err) {
    slice_edge e = {0};
    depth = fmax(depth, 1e-12 * z->top);
    sp_status status = SP_OK;
    for (int k = 0; k < 8; k++, depth *= 10) {
        status = factor(z, -depth, &e, err);
        if (status == SP_OK && e.error < depth / 4)
            break;
        if (status != SP_OK && status != SP_EREFUSED)
            return status;
    }
    if (status == SP_OK && !(e.error < -e.sigma / 4))
        return sp_fail(err, SP_EREFUSED, "no factor of K is accurate enough (error %.3g of omega^2 = %.3g)", e.error,
                       z->top);
    if (status == SP_OK && e.below > 0)
        return sp_fail(err, SP_EREFUSED,
                       "%lld modes have omega^2 below %.3g, which is negative: the network is unstable (prestress)",
                       (long long)e.below, e.sigma + e.error);
    if (status == SP_OK)
        *out = e;
    return status;
}

sp_status sp_slicer_soft(slicer *z, slice_edge *out, sp_error *err) {
    slice_edge e = {.error = HUGE_VAL};
    sp_error reason = {0};
    /* at the first place the factor of a network of some 10^4 grains is accurate enough */
    for (double sigma = 5e-11 * z->top; sigma < 1e-4 * z->top; sigma *= 4) {
        const sp_status status = factor(z, sigma, &e, &reason);
        if (status != SP_OK && status != SP_EREFUSED)
            return sp_fail(err, status, "%s", reason.text);
        if (status == SP_OK && e.error < 0.5 * sigma) {
            *out = e;
            return SP_OK;
        }
        if (status == SP_OK && e.error > sigma)
            sigma = e.error;
    }
    return sp_fail(err, SP_EREFUSED, "the zero modes cannot be counted: no factor of K is accurate enough");
}

slice_edge sp_slicer_top(const slicer *z) {
    return (slice_edge){z->top * (1 + 1e-9) + 4 * z->noise, z->noise, z->modes};
}

double sp_slicer_guess(const slicer *z, double count) {
    return 0.07 * z->top * pow(count / (double)z->n, 2.0 / z->net->dim);
}

/* Refines pairs and appends them to the list. below, above: bounds of the next modes on either side. Null motions are
 * exact eigenvectors, and the pairs are orthogonal to them: their eigenvalues do not count as neighbours. */
static sp_status append(slicer *z, const sp_lanczos_pairs *p, int64_t count, double below, double above,
                        sp_error *err) {
    const int64_t at = z->front + z->found, soft = sp_zeros_near(count, p->value, z->noise, above);
    const sp_refine_set set = {count, p->vector, NULL, z->noise, 1e-6, soft, below, above};
    sp_status status = sp_zeros_part(z->net, soft, p->vector, err);
    if (status == SP_OK)
        status = sp_modes_refine(z->net, &set, z->ritz + at, err);
    if (status != SP_OK)
        return status;
    if (z->vectors)
        memcpy(z->vector + at * z->n, p->vector, (size_t)(count * z->n) * sizeof *p->vector);
    z->found += count;
    return SP_OK;
}

/* Number of vectors of the last slice near its upper edge. Orthogonality to them keeps two slices from finding the same
 * mode. */
static int64_t neighbours(const slicer *z, slice_edge a, double width) {
    int64_t count = 0;
    while (count < z->last.count && count < LOCKED_MAX &&
           z->last.value[z->last.count - 1 - count] > a.sigma - 0.25 * width - 4 * a.error)
        count++;
    return count;
}

static sp_status solve_slice(slicer *z, slice_edge a, slice_edge b, int64_t wanted, sp_error *err) {
    const double width = b.sigma - a.sigma;
    sp_lanczos_pairs p = {0};
    slice_edge middle;
    /* a soft mode has full relative accuracy only if the shift is nearer to it than it is to zero */
    sp_status status = a.sigma < 0 ? factor(z, a.sigma, &middle, err)
                                   : sp_slicer_edge(z, a.sigma + 0.4 * width, a.sigma + 0.6 * width, &middle, err);
    if (status != SP_OK)
        return status;
    const int64_t locked = neighbours(z, a, width);
    sp_lanczos_spec spec = {.low = a.sigma - a.error,
                            .high = b.sigma + b.error,
                            .wanted = wanted,
                            .tolerance = z->tolerance,
                            .floor = fmax(1e-3 * a.sigma, -a.sigma),
                            .locked_count = locked};
    double below = a.sigma < 0 ? -HUGE_VAL : a.sigma - a.error;
    if (locked > 0) {
        spec.locked = z->last.vector + (z->last.count - locked) * z->n;
        below = fmax(below, z->last.value[z->last.count - 1] + a.error);
    }
    status = search(z, spec, &p, err);
    if (status != SP_OK)
        return status;
    double above = b.sigma - b.error;
    if (p.count > wanted) /* the next mode lies at the edge and belongs to the next slice */
        above = p.value[wanted] - b.error;
    p.count = wanted;
    status = append(z, &p, wanted, below, above, err);
    sp_lanczos_free(&z->last);
    z->last = p;
    return status;
}

static sp_status solve_between(slicer *z, slice_edge a, slice_edge b, int64_t start, int depth, sp_error *err) {
    const int64_t wanted = b.below - start - z->found; /* from the total, since an edge may coincide with a mode */
    if (wanted <= 0)
        return SP_OK;
    const double width = b.sigma - a.sigma, size = fmax(fabs(a.sigma), fabs(b.sigma));
    /* many modes near zero are zero modes, which no edge divides; one too near them makes their errors large */
    const bool zeros = a.sigma < 0 && b.sigma < 1e-8 * z->top;
    if (wanted <= slice_size(z) || depth >= DEPTH_MAX || zeros || width < 1e-7 * size + 64 * (a.error + b.error))
        return solve_slice(z, a, b, wanted, err);
    slice_edge middle;
    sp_status status = sp_slicer_edge(z, a.sigma + 0.4 * width, a.sigma + 0.6 * width, &middle, err);
    if (status == SP_OK && (middle.below < a.below || middle.below > b.below))
        status =
            sp_fail(err, SP_EREFUSED, "%lld modes below omega^2 = %.6g, but %lld below %.6g and %lld below %.6g",
                    (long long)middle.below, middle.sigma, (long long)a.below, a.sigma, (long long)b.below, b.sigma);
    if (status == SP_OK)
        status = solve_between(z, a, middle, start, depth + 1, err);
    return status == SP_OK ? solve_between(z, middle, b, start, depth + 1, err) : status;
}

/* Many modes in pieces, if each piece can be counted. If not, z->found remains 0. */
static sp_status solve_in_pieces(slicer *z, slice_edge a, slice_edge b, sp_error *err) {
    sp_error reason = {0};
    if (!z->divide || b.below - a.below <= SP_SLICER_PIECE)
        return SP_OK;
    const sp_status status = z->divide(z, a, b, &reason);
    return status == SP_OK || status == SP_EREFUSED ? SP_OK : sp_fail(err, status, "%s", reason.text);
}

sp_status sp_slicer_between(slicer *z, slice_edge a, slice_edge b, bool *certain, sp_error *err) {
    const int64_t wanted = b.below - a.below;
    if (wanted < 0 || !(a.sigma < b.sigma))
        return sp_fail(err, SP_EREFUSED, "%lld modes between omega^2 = %.6g and %.6g: their number cannot be certified",
                       (long long)wanted, a.sigma, b.sigma);
    sp_status status = reserve(z, wanted > 0 ? wanted : 1, err);
    sp_lanczos_free(&z->last);
    if (status == SP_OK)
        status = solve_in_pieces(z, a, b, err);
    if (status == SP_OK && z->found == 0)
        status = solve_between(z, a, b, a.below, 0, err);
    if (status == SP_OK && z->found != wanted)
        status = sp_fail(err, SP_EREFUSED, "%lld modes found between omega^2 = %.6g and %.6g, must be %lld",
                         (long long)z->found, a.sigma, b.sigma, (long long)wanted);
    if (status != SP_OK)
        return status;
    const sp_ritz *found = z->ritz + z->front;
    *certain = true;
    for (int64_t k = 0; k < z->found; k++)
        if (!((a.below == 0 || found[k].lambda - found[k].error > a.sigma + a.error) &&
              found[k].lambda + found[k].error < b.sigma - b.error))
            *certain = false;
    return SP_OK;
}

/* The widest gap after mode number `count` or one of the next SPARE. */
static int64_t widest_gap(const sp_lanczos_pairs *p, int64_t count) {
    int64_t best = count;
    for (int64_t k = count; k + 1 <= p->count - 1 && k <= count + SPARE; k++)
        if (p->value[k] - p->value[k - 1] > p->value[best] - p->value[best - 1])
            best = k;
    return best;
}

/* Any number of modes: finds an edge above enough modes, starting from guess, and solves in slices. */
static sp_status lowest_by_slices(slicer *z, int64_t count, double guess, slice_edge *end, sp_error *err) {
    slice_edge bottom, top = {0};
    bool certain = false;
    sp_status status = sp_slicer_bottom(z, 1e-3 * guess, &bottom, err);
    guess = fmax(guess, 1e5 * z->noise); /* keep well above the zero modes */
    for (int k = 0; k < 60 && status == SP_OK && top.below < count; k++) {
        if (1.01 * guess >= z->top)
            top = sp_slicer_top(z);
        else
            status = sp_slicer_edge(z, guess, 1.01 * guess, &top, err);
        guess *= fmax(1.05, fmin(4, 1.02 * pow((double)count / fmax(1, (double)top.below), 2.0 / z->net->dim)));
    }
    for (int k = 0; k < 6 && status == SP_OK && !certain; k++) {
        status = sp_slicer_between(z, bottom, top, &certain, err);
        if (status == SP_OK && !certain)
            status = sp_slicer_edge(z, 1.01 * top.sigma, 1.02 * top.sigma, &top, err);
    }
    if (status == SP_OK && !certain)
        status = sp_fail(err, SP_EREFUSED, "modes lie too near omega^2 = %.6g to be counted", top.sigma);
    if (status == SP_OK)
        *end = top;
    return status;
}

/* Appends the modes up to a gap after at least `count` of them, if their number below it is certified. */
static sp_status append_up_to_gap(slicer *z, const sp_lanczos_pairs *p, int64_t count, slice_edge *end, bool *proved,
                                  sp_error *err) {
    const int64_t cut = widest_gap(p, count);
    const double low = p->value[cut - 1], high = p->value[cut], gap = high - low;
    sp_status status = SP_OK;
    *proved = gap > 1e-7 * high + 100 * z->noise;
    if (*proved) {
        status = sp_slicer_edge(z, low + 0.25 * gap, high - 0.25 * gap, end, err);
        *proved = status == SP_OK && end->below == cut;
        status = status == SP_EREFUSED ? SP_OK : status;
    }
    if (status == SP_OK && *proved)
        status = reserve(z, cut, err);
    if (status == SP_OK && *proved)
        status = append(z, p, cut, -HUGE_VAL, end->sigma - end->error, err);
    return status;
}

/* Few modes, from one basis at a shift below the spectrum. Falls back to slices, each with a known number of modes, if
 * the count shows that modes are missing (copies of degenerate ones) or if there is no gap for a count. */
static sp_status lowest_of_one_basis(slicer *z, int64_t count, slice_edge *end, sp_error *err) {
    slice_edge bottom;
    sp_lanczos_pairs p = {0};
    sp_status status = SP_EREFUSED;
    /* from a shift too far below, much softer modes look alike */
    for (double part = 1e-3; part > 1e-12 && status == SP_EREFUSED; part *= 1e-4) {
        status = sp_slicer_bottom(z, part * sp_slicer_guess(z, (double)count), &bottom, err);
        if (status != SP_OK)
            return status;
        const sp_lanczos_spec spec = {.low = bottom.sigma,
                                      .high = HUGE_VAL,
                                      .wanted = count + SPARE,
                                      .tolerance = z->tolerance,
                                      .floor = -bottom.sigma};
        status = search(z, spec, &p, err);
    }
    if (status != SP_OK)
        return status;
    const double next = p.value[p.count - 1];
    bool proved;
    status = append_up_to_gap(z, &p, count, end, &proved, err);
    sp_lanczos_free(&p);
    return status == SP_OK && !proved ? lowest_by_slices(z, count, 1.05 * next, end, err) : status;
}

/* Below this fraction of the upper edge, a shift in the middle gives modes too inexactly. */
static const double MUCH_SOFTER = 1e-5;

/* A shift such that about as many modes as wanted lie within its own distance from it. A factorization costs about as
 * much as ten additional modes, in space as forty. *found stays false if the guesses fail. */
static sp_status find_middle(slicer *z, int64_t count, slice_edge *out, bool *found, sp_error *err) {
    /* of the modes up to twice the shift this part lies below it; less than by Debye's law, for the softest are few */
    const double wanted = (double)(count + SPARE), aim = (z->net->dim == 3 ? 0.29 : 0.4) * wanted;
    double guess = sp_slicer_guess(z, aim), power = 2.0 / z->net->dim;
    slice_edge now = {0};
    *found = false;
    for (int k = 0; k < 5 && guess < z->top && guess > 1e6 * z->noise; k++) {
        const slice_edge before = now;
        const sp_status status = sp_slicer_edge(z, 0.97 * guess, 1.03 * guess, &now, err);
        if (status != SP_OK)
            return status;
        if (before.below > 0 && now.below > 0 && before.below != now.below) /* two counts give the local exponent */
            power = fmin(fmax(log(now.sigma / before.sigma) / log((double)now.below / (double)before.below), 0.05), 3);
        const double ratio = (double)now.below / aim;
        *found = ratio > 0.65 && ratio < 1.3;
        if (*found)
            break;
        guess *= fmax(0.1, fmin(5, pow(1 / fmax(1 / aim, ratio), power)));
    }
    /* zero modes may leave no such shift; the search then tells how many they are */
    *found = *found || (now.below > 0 && (double)now.below <= 2 * wanted);
    *out = now;
    return SP_OK;
}

/* A shift in the middle gives the `soft` first pairs too inexactly: finds them again from a shift below the spectrum,
 * orthogonal to the others. *found: whether there are as many again. */
static sp_status find_soft_again(slicer *z, sp_lanczos_pairs *p, int64_t soft, bool *found, sp_error *err) {
    slice_edge bottom;
    sp_lanczos_pairs q = {0};
    const double cutoff = 0.5 * (p->value[soft - 1] + p->value[soft]);
    sp_status status = sp_slicer_bottom(z, 1e-3 * p->value[p->count - 1], &bottom, err);
    if (status == SP_OK) {
        const sp_lanczos_spec spec = {.low = bottom.sigma,
                                      .high = cutoff,
                                      .wanted = soft,
                                      .tolerance = z->tolerance,
                                      .floor = -bottom.sigma,
                                      .locked_count = p->count - soft,
                                      .locked = p->vector + soft * z->n};
        status = search(z, spec, &q, err);
    }
    *found = status == SP_OK && q.count == soft;
    if (*found) {
        memcpy(p->value, q.value, (size_t)soft * sizeof *q.value);
        memcpy(p->vector, q.vector, (size_t)(soft * z->n) * sizeof *q.vector);
    }
    sp_lanczos_free(&q);
    return status == SP_EREFUSED ? SP_OK : status;
}

/* Cheaper than a shift below the spectrum, since a shift in the middle has wanted modes on both sides. *found stays
 * false if the guesses fail, if many modes are much softer than the rest, or if no gap is found above the modes. *soft:
 * number of modes that are much softer, zero modes among them; unchanged if it was not found. */
static sp_status lowest_around_middle(slicer *z, int64_t count, slice_edge *end, bool *found, int64_t *soft,
                                      sp_error *err) {
    slice_edge middle;
    sp_lanczos_pairs p = {0};
    sp_error reason = {0};
    sp_status status = find_middle(z, count, &middle, found, &reason);
    if (status == SP_OK && !*found)
        return SP_OK;
    *found = false;
    if (status == SP_OK) {
        const sp_lanczos_spec spec = {.low = -HUGE_VAL,
                                      .high = HUGE_VAL,
                                      .wanted = count + SPARE,
                                      .below = middle.below,
                                      .tolerance = z->tolerance,
                                      .floor = 2e-4 * middle.sigma};
        status = search(z, spec, &p, &reason);
    }
    if (status == SP_EREFUSED)
        return SP_OK;
    if (status != SP_OK)
        return sp_fail(err, status, "%s", reason.text);
    int64_t below = 0, softer = 0;
    while (below < p.count && p.value[below] < middle.sigma)
        below++;
    while (softer < below && p.value[softer] <= 2 * MUCH_SOFTER * middle.sigma)
        softer++;
    if (below == middle.below) {
        bool precise = softer == 0;
        *soft = softer;
        if (softer > 0 && p.count > count + softer) /* they may be zero modes, in the places of others */
            status = find_soft_again(z, &p, softer, &precise, err);
        if (status == SP_OK && precise)
            status = append_up_to_gap(z, &p, count + softer, end, found, err);
    }
    sp_lanczos_free(&p);
    return status;
}

sp_status sp_slicer_softest(slicer *z, int64_t count, slice_edge *end, sp_error *err) {
    if (count <= slice_size(z) + slice_size(z) / 2)
        return lowest_of_one_basis(z, count, end, err);
    return lowest_by_slices(z, count, sp_slicer_guess(z, 1.05 * (double)count), end, err);
}

sp_status sp_slicer_zeros(const slicer *z, int64_t *zeros, sp_error *err) {
    return sp_zeros_count(z->net, z->found, z->ritz + z->front, 0, zeros, err);
}

/* Zero modes and modes that may be zero modes, unless the `zeros` first of those found show how many there are. */
static sp_status count_soft(slicer *z, int64_t zeros, int64_t *soft, sp_error *err) {
    slice_edge zero = {.below = zeros};
    const sp_status status = zeros < z->found ? SP_OK : sp_slicer_soft(z, &zero, err);
    *soft = zero.below;
    return status;
}

sp_status sp_slicer_lowest(slicer *z, int64_t count, slice_edge *end, sp_error *err) {
    int64_t soft = 0, zeros = 0, all = 0;
    bool found = false;
    sp_status status = SP_OK;
    if (count <= slice_size(z) + slice_size(z) / 2)
        status = lowest_around_middle(z, count, end, &found, &soft, err);
    if (status != SP_OK || found)
        return status;
    do { /* twice if zero modes take the places of others */
        all = count + soft < z->modes ? count + soft : z->modes;
        status = sp_slicer_softest(z, all, end, err);
        if (status == SP_OK)
            status = sp_slicer_zeros(z, &zeros, err);
        if (status == SP_OK && z->found - zeros < count)
            status = count_soft(z, zeros, &soft, err);
    } while (status == SP_OK && z->found - zeros < count && all < z->modes);
    if (status == SP_OK && z->found - zeros < count)
        return sp_fail(err, SP_EINVAL,
                       "%lld lowest modes, must be 1 .. %lld, the degrees of freedom less the zero modes",
                       (long long)count, (long long)(z->modes - zeros));
    return status;
}
