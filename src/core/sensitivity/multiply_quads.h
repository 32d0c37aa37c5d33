/* Products at springs. reverse_rows.c and multiply_wide.c include this file after their definitions of vec, AT_ONCE,
 * number and load, as for network/quad_forces.h, and of swap(x), which exchanges the lanes. */
#include "sensitivity/reverse_rows.h"

enum { SIZE_MAX_OF_SPRING = 6 };

/* Where the sums of springs s and following ones begin. */
static ALWAYS_INLINE vec *sum_at(double *sums, int which, int s) { return (vec *)(sums + 8 * which + 2 * s); }

static ALWAYS_INLINE void add_all(int size, const vec *x, double share, double *sums, int s) {
    int which = 0;
    for (int a = 0; a < size; a++)
        for (int b = a; b < size; b++, which++)
            *sum_at(sums, which, s) += share * (x[a] * swap(x[b]));
}

static ALWAYS_INLINE void add_along(int dim, int rotations, const double *q, const vec *x, double share, double *sums,
                                    int s) {
    vec n[3], along, side[3], across;
    for (int a = 0; a < dim; a++)
        n[a] = number(q, a, s);
    along = n[0] * x[0];
    for (int a = 1; a < dim; a++)
        along += n[a] * x[a];
    *sum_at(sums, 0, s) += share * (along * swap(along));
    if (rotations == 1) {
        side[0] = n[0] * x[1] - n[1] * x[0] - x[2];
        *sum_at(sums, 1, s) += share * (side[0] * swap(side[0]));
    } else if (rotations == 3) {
        for (int a = 0; a < 3; a++) {
            const int b = (a + 1) % 3, c = (a + 2) % 3;
            side[a] = x[a] - along * n[a] - (x[3 + b] * n[c] - x[3 + c] * n[b]);
        }
        across = side[0] * swap(side[0]) + side[1] * swap(side[1]) + side[2] * swap(side[2]);
        *sum_at(sums, 1, s) += share * across;
    }
}

static ALWAYS_INLINE void multiply_kind(int dim, int rotations, bool whole, const multiply_job *job,
                                        const double *restrict u) {
    const int size = dim + rotations, width = whole ? size * (size + 1) / 2 : 2;
    const quad_kind kind = {.dim = dim, .rotations = rotations};
    double *restrict sums = job->sums;
    const double share = job->share;
    for (int64_t k = 0; k < job->count; k++, sums += 8 * width) {
        const double *q = job->quads + k * multiply_quad(dim);
        const quad_rows *i = quad_rows_behind(dim, q), *j = i + 4;
        for (int s = 0; s < 4; s += AT_ONCE) {
            vec x[SIZE_MAX_OF_SPRING];
            load(kind, u, i + s, j + s, x);
            if (whole)
                add_all(size, x, share, sums, s);
            else
                add_along(dim, rotations, q, x, share, sums, s);
        }
    }
}

static ALWAYS_INLINE void multiply_all(bool whole, const multiply_job *job, const double *u) {
    switch (10 * job->dim + job->rotations) {
    case 10:
        if (AT_ONCE == 1)
            multiply_kind(1, 0, whole, job, u);
        break;
    case 20: multiply_kind(2, 0, whole, job, u); break;
    case 21: multiply_kind(2, 1, whole, job, u); break;
    case 30: multiply_kind(3, 0, whole, job, u); break;
    default: multiply_kind(3, 3, whole, job, u); break;
    }
}
