/* Turns rows of text files into contacts, and tangential forces into scalars and back. */
#include "store/exchange.h"

#include "base/base.h"
#include "packing/geometry.h"

#include <math.h>
#include <string.h>

/* ---- the tangential force in 2D -------------------------------------------------------------------------------- */

/* The rounded product. + 0.0 makes a negative zero positive. */
static void plain_product(const double n[3], double scalar, double ft[3]) {
    ft[0] = scalar * -n[1] + 0.0;
    ft[1] = scalar * n[0] + 0.0;
    ft[2] = 0.0;
}

static double steps_from(double x, int steps) {
    for (; steps > 0; steps--)
        x = nextafter(x, INFINITY);
    for (; steps < 0; steps++)
        x = nextafter(x, -INFINITY);
    return x;
}

double sp_tangent_scalar(const double n[3], const double ft[3]) {
    long double along = (long double)ft[0] * -(long double)n[1] + (long double)ft[1] * (long double)n[0];
    long double length2 = (long double)n[0] * (long double)n[0] + (long double)n[1] * (long double)n[1];
    double middle = (double)(along / length2) + 0.0; /* no negative zero */
    static const int steps[] = {0, 1, -1, 2, -2};
    for (size_t k = 0; k < sizeof steps / sizeof *steps; k++) {
        double scalar = steps_from(middle, steps[k]), product[3];
        plain_product(n, scalar, product);
        if (product[0] == ft[0] && product[1] == ft[1])
            return scalar;
    }
    return middle;
}

void sp_tangent_vector(const double n[3], double scalar, double ft[3]) {
    plain_product(n, scalar, ft);
    if (sp_tangent_scalar(n, ft) == scalar)
        return;
    /* Two neighbouring scalars have the same product. Move the vector by an ulp, to one that is no product and is
     * converted to this scalar. */
    double product[3] = {ft[0], ft[1], 0};
    for (int a = -1; a <= 1; a++)
        for (int b = -1; b <= 1; b++) {
            double moved[3] = {steps_from(product[0], a), steps_from(product[1], b), 0};
            if (sp_tangent_scalar(n, moved) == scalar) {
                ft[0] = moved[0];
                ft[1] = moved[1];
                return;
            }
        }
}

/* ---- rows ------------------------------------------------------------------------------------------------------ */

double sp_wrap(double x, double period) {
    if (x >= 0 && x < period)
        return x + 0.0; /* no negative zero */
    double inside = fmod(x, period);
    if (inside < 0)
        inside += period;
    return inside < period ? inside + 0.0 : 0.0;
}

void sp_wrap_grain(const sp_packing *p, double x[3]) {
    double s[3] = {0, 0, 0};
    bool outside = false;
    for (int k = 0; k < p->dim; k++)
        x[k] = p->cell == SP_CELL_PISTON && k < p->dim - 1 ? sp_wrap(x[k], p->box[k]) : x[k] + 0.0;
    if (p->cell != SP_CELL_PERIODIC)
        return;
    sp_packing_fractions(p, x, s);
    for (int k = 0; k < p->dim; k++)
        outside = outside || !(s[k] >= -1e-12 && s[k] <= 1 + 1e-12); /* what sp_packing_check allows */
    if (outside)
        sp_packing_wrap(p, x);
}

static int find_word(const char *const *list, const char *word) {
    for (int k = 0; list[k]; k++)
        if (strcmp(list[k], word) == 0)
            return k;
    return -1;
}

bool sp_cell_read(const char *word, sp_cell *out) {
    const int k = find_word(sp_cell_names, word);
    if (k >= 0)
        *out = (sp_cell)k;
    return k >= 0;
}

bool sp_side_read(const char *word, int32_t *wall) {
    const int k = find_word(sp_side_names, word);
    if (k >= 0)
        *wall = SP_BOTTOM - k;
    return k >= 0;
}

static bool is_wall(const sp_packing *p, int32_t j) { return j < 0 && j >= SP_BACK && sp_packing_has_wall(p, j); }

static sp_status check_row(const sp_packing *p, const sp_contact_row *row, sp_error *err) {
    bool wall_i = is_wall(p, row->i), wall_j = is_wall(p, row->j);
    bool grain_i = row->i >= 0 && row->i < p->n, grain_j = row->j >= 0 && row->j < p->n;
    if (!(grain_i && grain_j && row->i != row->j) && !(grain_i && wall_j) && !(wall_i && grain_j))
        return sp_fail(
            err, SP_EFORMAT,
            "a contact of %d and %d; must be two grains of 0..%d, or a grain and a wall of the cell, which is a %s",
            row->i, row->j, p->n - 1,
            p->cell == SP_CELL_PERIODIC ? "periodic one and has none"
            : p->cell == SP_CELL_BOX    ? "box: -1 bottom, -2 top, -3 left, -4 right, -5 front, -6 back (3D)"
                                        : "piston's: -1 bottom, -2 top");
    double length2 = 0;
    for (int k = 0; k < p->dim; k++)
        length2 += row->n[k] * row->n[k];
    if (!(fabs(sqrt(length2) - 1) <= row->unit_within))
        return sp_fail(err, SP_EFORMAT, "the normal's length is %.12g; must be 1 within %g", sqrt(length2),
                       row->unit_within);
    if (!isfinite(row->overlap) || row->overlap < 0 || !isfinite(row->fn) || row->fn < 0)
        return sp_fail(err, SP_EFORMAT, "overlap %g and Fn %g; must be finite and >= 0", row->overlap, row->fn);
    if (!(row->kn >= 0 && row->kt >= 0) || !isfinite(row->kn) || !isfinite(row->kt) || (row->kt > 0 && !(row->kn > 0)))
        return sp_fail(err, SP_EFORMAT, "kn %g and kt %g; must be finite and >= 0, and kn above 0 where kt is", row->kn,
                       row->kt);
    return SP_OK;
}

sp_status sp_contact_from_row(const sp_packing *p, const sp_contact_row *row, sp_contact *out, sp_error *err) {
    sp_status status = check_row(p, row, err);
    if (status != SP_OK)
        return status;
    sp_contact c = {.i = row->i, .j = row->j, .overlap = row->overlap, .fn = row->fn, .kn = row->kn, .kt = row->kt};
    double length2 = 0;
    for (int k = 0; k < p->dim; k++) {
        c.n[k] = row->n[k] + 0.0;
        length2 += c.n[k] * c.n[k];
    }
    if (fabs(length2 - 1) > 1e-9)
        for (int k = 0; k < p->dim; k++)
            c.n[k] /= sqrt(length2);
    if (row->vector)
        for (int k = 0; k < p->dim; k++)
            c.ft[k] = row->ft3[k] + 0.0;
    else if (p->dim == 2)
        sp_tangent_vector(c.n, row->ft, c.ft);
    if (c.i < 0 || (c.j >= 0 && c.i > c.j)) {
        c.i = row->j;
        c.j = row->i;
        for (int k = 0; k < p->dim; k++) {
            c.n[k] = 0.0 - c.n[k];
            c.ft[k] = 0.0 - c.ft[k];
        }
    }
    *out = c;
    return SP_OK;
}

sp_status sp_finite_numbers(const sp_lines *at, int count, char *const *word, const char *const *name, double *out,
                            sp_error *err) {
    for (int k = 0; k < count; k++)
        if (!sp_word_number(word[k], &out[k]) || !isfinite(out[k]))
            return sp_fail(err, SP_EFORMAT, "%s:%lld: %s is '%.60s'; must be a finite number", at->file,
                           (long long)at->number, name[k], word[k]);
    return SP_OK;
}
