/* Preconditioned conjugate gradients, and GMRES without restarts, preconditioned from the right. */
#include "linalg/krylov.h"

#include "base/base.h"
#include "base/vector.h"

#include <math.h>
#include <stdbool.h>
#include <string.h>

/* ---- symmetric --------------------------------------------------------------------------------------------------- */

typedef struct cg {
    int64_t n;
    double *rest, *image, *along; /* [n] b - A x, scratch, the direction of the step */
    double work;                  /* rest . M^-1 rest */
} cg;

/* Chooses the next direction. */
static void turn(const krylov_problem *p, cg *c) {
    p->precondition(p->with, c->rest, c->image);
    const double work = sp_dot(c->n, c->rest, c->image), kept = c->work > 0 ? work / c->work : 0;
    for (int64_t k = 0; k < c->n; k++)
        c->along[k] = c->image[k] + kept * c->along[k];
    c->work = work;
}

/* Makes a step; false if A does not resist it. */
static bool step(const krylov_problem *p, const double *zero, cg *c, double *x) {
    double threshold = 0;
    p->apply(p->with, c->along, c->image);
    for (int64_t k = 0; k < c->n; k++)
        threshold += zero[k] * c->along[k] * c->along[k];
    const double resisted = sp_dot(c->n, c->along, c->image);
    if (!(resisted > threshold))
        return false;
    for (int64_t k = 0; k < c->n; k++) {
        x[k] += c->work / resisted * c->along[k];
        c->rest[k] -= c->work / resisted * c->image[k];
    }
    return true;
}

sp_status sp_cg(const krylov_problem *p, const double *zero, const double *b, double *x, sp_error *err) {
    const size_t n = (size_t)p->n;
    cg c = {.n = p->n, .rest = sp_alloc(3 * n, sizeof *x)};
    bool more = true;
    if (!c.rest)
        return sp_fail_memory(err, 3 * n * sizeof *x);
    c.image = c.rest + n;
    c.along = c.rest + 2 * n;
    memset(x, 0, n * sizeof *x);
    memcpy(c.rest, b, n * sizeof *b);
    for (int k = 0; k < p->steps_max && more && sp_norm(p->n, c.rest) > p->goal; k++) {
        turn(p, &c);
        more = step(p, zero, &c, x);
    }
    sp_free(c.rest);
    return SP_OK;
}

/* ---- nonsymmetric ------------------------------------------------------------------------------------------------ */

/* Arnoldi vectors, and the Hessenberg matrix, which Givens rotations reduce to a triangle as it grows. */
typedef struct gmres {
    int64_t n;
    int m;
    double *basis;     /* [m + 1][n] */
    double *h;         /* [m][m + 1], by columns */
    double *c, *s, *g; /* [m], [m], [m + 1] */
    double *work;      /* [n] */
} gmres;

static void scale_to(int64_t n, double by, const double *from, double *to) {
    for (int64_t k = 0; k < n; k++)
        to[k] = by * from[k];
}

/* The next basis vector: A M^-1 times the last one, orthogonalized twice so that it stays orthogonal. */
static void extend(const krylov_problem *p, gmres *q, int j) {
    double *next = q->basis + (int64_t)(j + 1) * q->n, *h = q->h + (size_t)j * ((size_t)q->m + 1);
    p->precondition(p->with, q->basis + (int64_t)j * q->n, q->work);
    p->apply(p->with, q->work, next);
    for (int pass = 0; pass < 2; pass++)
        for (int i = 0; i <= j; i++) {
            const double *v = q->basis + (int64_t)i * q->n, part = sp_dot(q->n, v, next);
            h[i] += part;
            for (int64_t k = 0; k < q->n; k++)
                next[k] -= part * v[k];
        }
    h[j + 1] = sp_norm(q->n, next);
    if (h[j + 1] > 0)
        scale_to(q->n, 1 / h[j + 1], next, next);
}

static void rotate(gmres *q, int j) {
    double *h = q->h + (size_t)j * ((size_t)q->m + 1);
    for (int i = 0; i < j; i++) {
        const double a = h[i], b = h[i + 1];
        h[i] = q->c[i] * a + q->s[i] * b;
        h[i + 1] = q->c[i] * b - q->s[i] * a;
    }
    const double size = hypot(h[j], h[j + 1]);
    q->c[j] = size > 0 ? h[j] / size : 1;
    q->s[j] = size > 0 ? h[j + 1] / size : 0;
    h[j] = size;
    q->g[j + 1] = -q->s[j] * q->g[j];
    q->g[j] *= q->c[j];
}

/* x = M^-1 (basis y), where y solves the triangular system. */
static void combine(const krylov_problem *p, gmres *q, int steps, double *x) {
    for (int j = steps; j-- > 0;) {
        const double *h = q->h + (size_t)j * ((size_t)q->m + 1);
        q->g[j] = h[j] > 0 ? q->g[j] / h[j] : 0;
        for (int i = 0; i < j; i++)
            q->g[i] -= h[i] * q->g[j];
    }
    memset(q->work, 0, (size_t)q->n * sizeof *q->work);
    for (int j = 0; j < steps; j++)
        for (int64_t k = 0; k < q->n; k++)
            q->work[k] += q->g[j] * q->basis[(int64_t)j * q->n + k];
    p->precondition(p->with, q->work, x);
}

sp_status sp_gmres(const krylov_problem *p, const double *b, double *x, double *residual, sp_error *err) {
    const size_t n = (size_t)p->n, m = (size_t)p->steps_max, size = (m + 2) * n + m * (m + 1) + 3 * m + 1;
    const double norm = sp_norm(p->n, b);
    gmres q = {.n = p->n, .m = p->steps_max};
    int steps = 0;
    *residual = 0;
    memset(x, 0, n * sizeof *x);
    if (norm == 0)
        return SP_OK;
    q.basis = sp_alloc(size, sizeof *q.basis);
    if (!q.basis)
        return sp_fail_memory(err, size * sizeof *q.basis);
    q.work = q.basis + (m + 1) * n;
    q.h = q.work + n;
    q.c = q.h + m * (m + 1);
    q.s = q.c + m;
    q.g = q.s + m;
    scale_to(p->n, 1 / norm, b, q.basis);
    q.g[0] = norm;
    while (steps < p->steps_max && fabs(q.g[steps]) > p->goal) {
        extend(p, &q, steps);
        rotate(&q, steps++);
    }
    *residual = fabs(q.g[steps]) / norm;
    combine(p, &q, steps, x);
    sp_free(q.basis);
    return SP_OK;
}
