/* Ordered packings in closed form: the chain and the triangular lattice. */
#include "base/base.h"
#include "packing/contact.h"
#include "packing/prepare.h"

#include <math.h>

static void set_globals(sp_packing *p, const sp_pack_spec *spec) {
    p->pressure = spec->pressure;
    p->friction = spec->friction;
    p->poisson = spec->poisson;
    p->seed = spec->seed;
    p->residual = 0;
}

/* Hertz's law assumes overlaps that are small against both grains; beyond these limits there is not even a packing. */
static sp_status crushed(const sp_pack_spec *spec, sp_error *err) {
    return sp_fail(err, SP_EFAILED,
                   "packing.pressure = %g: is too much for these grains: overlaps are not below their radii, or grains "
                   "touch their second neighbours",
                   spec->pressure);
}

/* N balls between two walls that respond like the neighbouring balls, so that equal balls have equal springs (Somfai et
 * al. 2005, Appendix C). Every contact carries p d^2. */
sp_status sp_chain_make(const sp_pack_spec *spec, sp_packing *out, sp_error *err) {
    sp_packing p = sp_packing_none();
    const int32_t n = spec->grains;
    sp_status status = sp_packing_alloc(&p, 1, n, n + 1, err);
    if (status != SP_OK)
        return status;
    set_globals(&p, spec);
    p.wall = SP_WALL_GRAIN;
    sp_radii_draw(spec, p.r);
    const double force = spec->pressure;
    double wall = 0; /* position of the next surface */
    bool too_much = false;
    for (int32_t i = 0; i <= n; i++) {
        sp_contact *c = &p.contacts[i < n ? (i > 0 ? i - 1 : n - 1) : n];
        double e;
        if (i == 0 || i == n) {
            c->i = i == 0 ? 0 : n - 1;
            c->j = i == 0 ? SP_BOTTOM : SP_TOP;
            c->n[0] = i == 0 ? -1 : 1;
            e = contact_wall_stiffness(p.r[c->i], p.wall);
        } else {
            c->i = i - 1;
            c->j = i;
            c->n[0] = 1;
            e = contact_stiffness(p.r[i - 1], p.r[i]);
        }
        c->fn = force;
        c->overlap = contact_overlap(e, force);
        too_much = too_much || !(c->overlap < p.r[c->i]) || (c->j >= 0 && !(c->overlap < p.r[c->j]));
        wall -= c->overlap;
        if (i < n) {
            p.x[3 * (size_t)i] = wall + p.r[i];
            wall += 2 * p.r[i];
        }
    }
    if (too_much) {
        sp_packing_free(&p);
        return crushed(spec, err);
    }
    p.box[0] = wall;
    sp_packing_sort(&p);
    *out = p;
    return SP_OK;
}

/* Overlap n of the lattice's contacts. Under isotropic pressure all contacts carry the same force F. Each piece of wall
 * with the width d - n of a grain, and unit thickness, is held by two of them: sqrt(3) F(n) = p (d - n). Solved by
 * Newton's method. */
static double lattice_overlap(double d, double pressure) {
    const double e = contact_stiffness(0.5 * d, 0.5 * d), load = pressure;
    double overlap = contact_overlap(e, load * d / sqrt(3.0));
    for (int step = 0; step < 50; step++) {
        double excess = sqrt(3.0) * contact_force(e, overlap) - load * (d - overlap);
        double change = -excess / (sqrt(3.0) * contact_normal_stiffness(e, overlap) + load);
        overlap += change;
        if (fabs(change) < 1e-16 * overlap)
            break;
    }
    return overlap;
}

static void add_contact(sp_packing *p, int32_t *count, int32_t i, int32_t j, const double n[2]) {
    bool flip = j >= 0 && j < i;
    sp_contact *c = &p->contacts[(*count)++];
    c->i = flip ? j : i;
    c->j = flip ? i : j;
    c->n[0] = flip ? 0.0 - n[0] : n[0];
    c->n[1] = flip ? 0.0 - n[1] : n[1];
}

/* Adds the contacts of grain m of row k with the walls, the next grain of its row, and the row above. */
static void add_lattice_contacts(sp_packing *p, int32_t *count, int32_t row, int32_t rows, int32_t k, int32_t m) {
    static const double down[] = {0, -1}, up[] = {0, 1}, right[] = {1, 0};
    const double left_up[] = {-0.5, sqrt(0.75)}, right_up[] = {0.5, sqrt(0.75)};
    const int32_t i = k * row + m, next = (m + 1) % row, last = (m + row - 1) % row, above = (k + 1) * row;
    if (k == 0)
        add_contact(p, count, i, SP_BOTTOM, down);
    if (k == rows - 1)
        add_contact(p, count, i, SP_TOP, up);
    add_contact(p, count, i, k * row + next, right);
    if (k == rows - 1)
        return;
    add_contact(p, count, i, above + (k % 2 ? m : last), left_up);
    add_contact(p, count, i, above + (k % 2 ? next : m), right_up);
}

/* Lengths of a lattice of grains of diameter d under pressure. */
typedef struct lattice {
    int32_t row, rows;                     /* grains per row, number of rows */
    double overlap, wall_overlap, spacing; /* of neighbours; at a wall; distance of neighbouring centres */
    double width, height;
} lattice;

static sp_status make_lattice(const sp_pack_spec *spec, double d, lattice *out, sp_error *err) {
    /* as in sp_pack_spec_check, with the mean diameter */
    lattice l = {.row = (int32_t)floor(spec->width / sp_sizes_moment(spec, 1) + 1e-9)};
    l.rows = spec->grains / l.row;
    l.overlap = lattice_overlap(d, spec->pressure);
    l.spacing = d - l.overlap;
    l.wall_overlap = contact_overlap(contact_wall_stiffness(0.5 * d, SP_WALL_RIGID), spec->pressure * l.spacing);
    if (!(sqrt(3.0) * l.spacing > d && l.wall_overlap < 0.5 * d))
        return crushed(spec, err);
    l.width = l.row * l.spacing;
    l.height = 2 * (0.5 * d - l.wall_overlap) + (l.rows - 1) * (sqrt(0.75) * l.spacing);
    *out = l;
    return SP_OK;
}

/* Places the centres, the first row at height `bottom`. */
static void place_rows(const lattice *l, double spacing, double bottom, double *x) {
    for (int32_t k = 0; k < l->rows; k++)
        for (int32_t m = 0; m < l->row; m++) {
            double *at = x + 3 * ((size_t)k * (size_t)l->row + (size_t)m);
            at[0] = (m + (k % 2 ? 0.75 : 0.25)) * spacing;
            at[1] = bottom + k * (sqrt(0.75) * spacing);
            at[2] = 0;
        }
}

/* Rows parallel to the walls, each shifted by half a spacing, with six equal contacts per grain (section V B of the
 * paper). The width of the box follows from the compressed rows. */
sp_status sp_triangular_make(const sp_pack_spec *spec, sp_packing *out, sp_error *err) {
    const double d = spec->diameter_max;
    if (spec->diameter_min != d)
        return sp_fail(err, SP_EINVAL,
                       "packing.diameter_min = %g: must be packing.diameter_max = %g in a perfect lattice",
                       spec->diameter_min, d);
    lattice l;
    sp_packing p = sp_packing_none();
    sp_status status = make_lattice(spec, d, &l, err);
    if (status == SP_OK)
        status = sp_packing_alloc(&p, 2, spec->grains, 3 * l.row * l.rows, err);
    if (status != SP_OK)
        return status;
    set_globals(&p, spec);
    const double e = contact_stiffness(0.5 * d, 0.5 * d), e_wall = contact_wall_stiffness(0.5 * d, p.wall);
    p.box[0] = l.width;
    p.box[1] = l.height;
    place_rows(&l, l.spacing, 0.5 * d - l.wall_overlap, p.x);
    int32_t count = 0;
    for (int32_t k = 0; k < l.rows; k++)
        for (int32_t m = 0; m < l.row; m++) {
            p.r[k * l.row + m] = 0.5 * d;
            add_lattice_contacts(&p, &count, l.row, l.rows, k, m);
        }
    for (int32_t c = 0; c < count; c++) {
        sp_contact *k = &p.contacts[c];
        k->overlap = k->j < 0 ? l.wall_overlap : l.overlap;
        k->fn = contact_force(k->j < 0 ? e_wall : e, k->overlap);
    }
    sp_packing_sort(&p);
    *out = p;
    return SP_OK;
}

sp_status sp_triangular_start(const sp_pack_spec *spec, double *r, double *x, sp_lattice_start *out, sp_error *err) {
    const int32_t n = spec->grains;
    double *drawn = sp_alloc((size_t)n, sizeof *drawn), sum = 0, r_max = 0;
    if (!drawn)
        return sp_fail_memory(err, (size_t)n * sizeof *drawn);
    sp_radii_draw(spec, drawn);
    for (int32_t i = 0; i < n; i++) {
        sum += drawn[i];
        r_max = fmax(r_max, drawn[i]);
    }
    lattice l;
    sp_status status = make_lattice(spec, 2 * sum / n, &l, err);
    if (status == SP_OK) {
        const double apart = 2 * r_max * (1 + 1e-6); /* well above rounding, well below an overlap */
        for (int32_t i = 0; i < n; i++)
            r[i] = drawn[i];
        place_rows(&l, apart, 0.5 * apart, x);
        *out = (sp_lattice_start){.width = l.row * apart,
                                  .height = apart + (l.rows - 1) * (sqrt(0.75) * apart),
                                  .width_end = l.width,
                                  .height_end = l.height};
    }
    sp_free(drawn);
    return status;
}
