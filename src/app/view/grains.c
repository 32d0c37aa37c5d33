/* Grains and contacts of a packing for the page: places, contacts with their forces, the pressure on each grain. */
#include "view/parts.h"

#include "base/base.h"

#include <math.h>

static const double pi = 3.14159265358979323846;

/* Arrays that one call fills; all are freed together. */
typedef struct arrays {
    float *x, *r, *pressure, *fn, *ft, *wall;
    uint8_t *rattler, *carrying;
    uint16_t *coordination;
    int32_t *contact;
    int8_t *image;
    int64_t walls; /* contacts with walls */
} arrays;

static void free_arrays(arrays *a) {
    void *all[] = {a->x,       a->r,        a->pressure,     a->fn,      a->ft,   a->wall,
                   a->rattler, a->carrying, a->coordination, a->contact, a->image};
    for (size_t k = 0; k < sizeof all / sizeof *all; k++)
        sp_free(all[k]);
}

static sp_status make_arrays(const sp_packing *p, arrays *a, sp_error *err) {
    const size_t n = (size_t)p->n, m = (size_t)p->n_contacts, dim = (size_t)p->dim;
    a->x = sp_alloc(n * dim, sizeof *a->x);
    a->r = sp_alloc(n, sizeof *a->r);
    a->pressure = sp_alloc(n, sizeof *a->pressure);
    a->fn = sp_alloc(m, sizeof *a->fn);
    a->ft = sp_alloc(m, sizeof *a->ft);
    a->wall = sp_alloc(m * dim, sizeof *a->wall);
    a->rattler = sp_alloc(n, 1);
    a->carrying = sp_alloc(m, 1);
    a->coordination = sp_alloc(n, sizeof *a->coordination);
    a->contact = sp_alloc(m, 2 * sizeof *a->contact);
    a->image = sp_alloc(m * dim, 1);
    const bool made = a->x && a->r && a->pressure && a->fn && a->ft && a->wall && a->rattler && a->carrying &&
                      a->coordination && a->contact && a->image;
    return made ? SP_OK : sp_fail_memory(err, n * 30 + m * 40);
}

/* Volume to which the stress of a grain belongs: in 2D of a layer one diameter thick, in 1D of a bar whose section is
 * d^2, as in the pressure on a wall. */
static double volume(int dim, double r) { return dim == 3 ? 4 * pi / 3 * r * r * r : dim == 2 ? pi * r * r : 2 * r; }

static void place_grains(const sp_packing *p, arrays *a) {
    for (int32_t i = 0; i < p->n; i++) {
        for (int k = 0; k < p->dim; k++)
            a->x[(int64_t)i * p->dim + k] = (float)p->x[3 * (int64_t)i + k];
        a->r[i] = (float)p->r[i];
    }
}

/* In which copy of the box the grain j lies that i touches. Along an axis that is not periodic this is 0. In a tilted
 * box a step along an axis leads along the axes before it too. */
static void find_image(const sp_packing *p, const sp_contact *c, int8_t *image) {
    const double length = p->r[c->i] + p->r[c->j] - c->overlap;
    double shift[3] = {0, 0, 0};
    for (int k = 0; k < p->dim; k++)
        shift[k] = p->x[3 * (int64_t)c->i + k] + length * c->n[k] - p->x[3 * (int64_t)c->j + k];
    for (int k = p->dim - 1; k >= 0; k--) {
        image[k] = (int8_t)fmax(-100, fmin(100, round(shift[k] / p->box[k])));
        for (int a = 0; a < k; a++)
            shift[a] -= image[k] * p->tilt[k + a - 1];
    }
}

static void count_end(arrays *a, int32_t i, bool carries) {
    if (carries && a->coordination[i] < UINT16_MAX)
        a->coordination[i]++;
}

static void place_contacts(const sp_packing *p, arrays *a) {
    for (int32_t c = 0; c < p->n_contacts; c++) {
        const sp_contact *k = &p->contacts[c];
        a->contact[2 * (int64_t)c] = k->i;
        a->contact[2 * (int64_t)c + 1] = k->j;
        a->fn[c] = (float)k->fn;
        a->ft[c] = (float)sqrt(k->ft[0] * k->ft[0] + k->ft[1] * k->ft[1] + k->ft[2] * k->ft[2]);
        count_end(a, k->i, a->carrying[c]);
        if (k->j >= 0) {
            find_image(p, k, a->image + (int64_t)c * p->dim);
            count_end(a, k->j, a->carrying[c]);
            continue;
        }
        for (int d = 0; d < p->dim; d++) /* the contact point */
            a->wall[a->walls * p->dim + d] = (float)(p->x[3 * (int64_t)k->i + d] + (p->r[k->i] - k->overlap) * k->n[d]);
        a->walls++;
    }
}

/* The trace of the stress of each grain over the dimension: sum of F_n R over the contacts, over dim V. */
static sp_status find_pressures(const sp_packing *p, arrays *a, sp_error *err) {
    double *sum = sp_alloc((size_t)p->n, sizeof *sum);
    if (!sum)
        return sp_fail_memory(err, (size_t)p->n * sizeof *sum);
    for (int32_t c = 0; c < p->n_contacts; c++) {
        const sp_contact *k = &p->contacts[c];
        sum[k->i] += k->fn * p->r[k->i];
        if (k->j >= 0)
            sum[k->j] += k->fn * p->r[k->j];
    }
    for (int32_t i = 0; i < p->n; i++)
        a->pressure[i] = (float)(sum[i] / (p->dim * volume(p->dim, p->r[i])));
    sp_free(sum);
    return SP_OK;
}

static void write_arrays(view_json *j, const sp_packing *p, const arrays *a) {
    const int64_t n = p->n, m = p->n_contacts, dim = p->dim;
    view_array(j, "x", VIEW_FLOAT32, (int64_t[4]){n, dim}, a->x);
    view_array(j, "r", VIEW_FLOAT32, (int64_t[4]){n}, a->r);
    view_array(j, "rattler", VIEW_UINT8, (int64_t[4]){n}, a->rattler);
    view_array(j, "coordination", VIEW_UINT16, (int64_t[4]){n}, a->coordination);
    view_array(j, "grain_pressure", VIEW_FLOAT32, (int64_t[4]){n}, a->pressure);
    view_array(j, "contact", VIEW_INT32, (int64_t[4]){m, 2}, a->contact);
    view_array(j, "image", VIEW_INT8, (int64_t[4]){m, dim}, a->image);
    view_array(j, "wall_point", VIEW_FLOAT32, (int64_t[4]){a->walls, dim}, a->wall);
    view_array(j, "fn", VIEW_FLOAT32, (int64_t[4]){m}, a->fn);
    view_array(j, "ft", VIEW_FLOAT32, (int64_t[4]){m}, a->ft);
    view_array(j, "carrying", VIEW_UINT8, (int64_t[4]){m}, a->carrying);
}

sp_status view_add_grains(view_json *j, const sp_packing *p, double threshold, sp_error *err) {
    arrays a = {0};
    int32_t rattlers = 0;
    sp_status status = make_arrays(p, &a, err);
    if (status == SP_OK)
        status = sp_packing_rattlers(p, threshold, a.rattler, a.carrying, &rattlers, err);
    if (status == SP_OK)
        status = find_pressures(p, &a, err);
    if (status == SP_OK) {
        place_grains(p, &a);
        place_contacts(p, &a);
        view_integer(j, "rattlers", rattlers);
        write_arrays(j, p, &a);
    }
    free_arrays(&a);
    return status;
}

void view_add_network(view_json *j, const sp_network *net) {
    view_integer(j, "dof", net->dof);
    view_array(j, "grain", VIEW_INT32, (int64_t[4]){net->n}, net->grain);
}
