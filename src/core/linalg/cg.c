/* Preconditioned conjugate gradients. */
#include "linalg/cg.h"

#include "base/base.h"
#include "linalg/vector.h"

#include <stdbool.h>
#include <string.h>

typedef struct cg {
    int64_t n;
    double *rest, *image, *along; /* [n] b - A x, scratch, the direction of the step */
    double work;                  /* rest . M^-1 rest */
} cg;

/* Chooses the next direction. */
static sp_status turn(const cg_problem *p, cg *c, sp_error *err) {
    sp_status status = p->precondition(p->with, c->rest, c->image, err);
    if (status != SP_OK)
        return status;
    const double work = sp_dot(c->n, c->rest, c->image), kept = c->work > 0 ? work / c->work : 0;
    for (int64_t k = 0; k < c->n; k++)
        c->along[k] = c->image[k] + kept * c->along[k];
    c->work = work;
    return SP_OK;
}

/* Makes a step, unless A does not resist it. */
static sp_status step(const cg_problem *p, cg *c, double *x, bool *more, sp_error *err) {
    double threshold = 0;
    sp_status status = p->apply(p->with, c->along, c->image, err);
    if (status != SP_OK)
        return status;
    for (int64_t k = 0; k < c->n; k++)
        threshold += p->zero[k] * c->along[k] * c->along[k];
    const double resisted = sp_dot(c->n, c->along, c->image);
    *more = resisted > threshold;
    for (int64_t k = 0; k < c->n && *more; k++) {
        x[k] += c->work / resisted * c->along[k];
        c->rest[k] -= c->work / resisted * c->image[k];
    }
    return SP_OK;
}

sp_status sp_cg(const cg_problem *p, const double *b, double *x, sp_error *err) {
    const size_t n = (size_t)p->n;
    cg c = {.n = p->n, .rest = sp_alloc(3 * n, sizeof *x)};
    sp_status status = SP_OK;
    bool more = true;
    if (!c.rest)
        return sp_fail_memory(err, 3 * n * sizeof *x);
    c.image = c.rest + n;
    c.along = c.rest + 2 * n;
    memset(x, 0, n * sizeof *x);
    memcpy(c.rest, b, n * sizeof *b);
    for (int k = 0; k < p->steps_max && more && sp_norm(p->n, c.rest) > p->goal && status == SP_OK; k++) {
        status = turn(p, &c, err);
        if (status == SP_OK)
            status = step(p, &c, x, &more, err);
    }
    sp_free(c.rest);
    return status;
}
