/* The time of a product K u for every kind of network, beside memcpy of the bytes that it must read and write:
 *     products [TSV]
 * The networks are square and cubic lattices of about equal grains with a little disorder, where every grain touches
 * its four or six neighbours, and chains; they have 600, 5000 and 20 000 grains. A product is one step of the
 * recurrence for both of its vectors, with every grain awake, on one thread. What it must read and write (kB): both
 * vectors at two steps, masses and step widths, and the numbers of each spring with the rows of its grains, each number
 * once and without padding. copy_us is memcpy of so many bytes, which reads and writes each of them; half_us is memcpy
 * of half as many, so that reads and writes together are as many. They take turns with the product, several of each in
 * a row; times are CPU times, the least of many runs. */
#include "base/base.h"
#include "packing/contact.h"
#include "signal/recurrence.h"

#include <math.h>
#include <sonopack/version.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { ROUNDS = 60, SIZES = 3 };
static const int32_t CELLS[SIZES][2][3] = {
    {{24, 25, 1}, {10, 10, 6}}, {{50, 100, 1}, {20, 25, 10}}, {{100, 200, 1}, {20, 25, 40}}};

typedef struct kind {
    const char *name;
    int dim;
    double friction;
    bool prestress;
} kind;

static const kind KINDS[] = {{"chain", 1, 0, false},          {"2D, no friction", 2, 0, false},
                             {"2D", 2, 0.5, false},           {"3D, no friction", 3, 0, false},
                             {"3D", 3, 0.5, false},           {"2D, no friction, prestress", 2, 0, true},
                             {"2D, prestress", 2, 0.5, true}, {"3D, no friction, prestress", 3, 0, true},
                             {"3D, prestress", 3, 0.5, true}};

static double noise(void) { return (double)rand() / RAND_MAX - 0.5; }

/* Adds the contact of grain i with the next one along an axis, or with a wall. */
static void touch(sp_packing *p, int32_t i, int32_t j, int axis) {
    sp_contact c = {.i = i, .j = j};
    double size = 0;
    for (int a = 0; a < p->dim && j >= 0; a++) {
        c.n[a] = p->x[3 * j + a] - p->x[3 * i + a];
        c.n[a] -= p->box[a] * round(c.n[a] / p->box[a]) * (a < p->dim - 1);
        size += c.n[a] * c.n[a];
    }
    for (int a = 0; a < p->dim && j >= 0; a++)
        c.n[a] /= sqrt(size);
    if (j < 0)
        c.n[axis] = j == SP_TOP ? 1 : -1;
    c.overlap = j < 0 ? 0.02 : p->r[i] + p->r[j] - sqrt(size);
    c.fn = contact_force(j < 0 ? contact_wall_stiffness(p->r[i], p->wall) : contact_stiffness(p->r[i], p->r[j]),
                         c.overlap);
    for (int a = 0; a < p->dim && p->friction > 0; a++)
        c.ft[a] = 0.1 * c.fn * noise();
    p->contacts[p->n_contacts++] = c;
}

static sp_status lattice(const kind *k, const int32_t *sites, sp_packing *p, sp_error *err) {
    const int32_t n = sites[0] * sites[1] * sites[2];
    const int32_t cells[3] = {k->dim == 1 ? n : sites[0], sites[1], sites[2]};
    sp_status status = sp_packing_alloc(p, k->dim, n, 4 * n, err);
    if (status != SP_OK)
        return status;
    p->n_contacts = 0;
    p->pressure = 1e-4;
    p->friction = k->friction;
    p->poisson = 0.2;
    for (int a = 0; a < 3; a++)
        p->box[a] = a < k->dim ? 0.9 * cells[a] : 1;
    for (int32_t i = 0; i < n; i++) {
        p->r[i] = 0.48 + 0.02 * noise();
        for (int a = 0, rest = i; a < k->dim; rest /= cells[a], a++)
            p->x[3 * i + a] = 0.9 * (rest % cells[a] + 0.5) + 0.02 * noise();
    }
    for (int32_t i = 0; i < n; i++)
        for (int32_t a = 0, stride = 1; a < k->dim; stride *= cells[a], a++) {
            const int32_t at = i / stride % cells[a];
            if (a == k->dim - 1 && at == 0)
                touch(p, i, SP_BOTTOM, a);
            if (at < cells[a] - 1)
                touch(p, i, i + stride, a);
            else
                touch(p, i, a == k->dim - 1 ? SP_TOP : i - at * stride, a);
        }
    sp_packing_sort(p);
    return SP_OK;
}

static double bytes_of(const sp_network *net) {
    const bool friction = net->dof > net->dim;
    const double vectors = 8.0 * net->dof, weights = friction ? 4 : 2;
    const double carried = !net->carried ? 0 : net->dim == 2 ? 1 : 6; /* 2D: one number; 3D: force, 1/r, 1/radii */
    const double spring = (net->dim > 1 ? net->dim : 0) + 2 + friction + net->prestress + carried;
    return 8 * (net->n * (vectors + weights) + net->n_springs * spring);
}

static void wake_all(const sp_operator *op, bool nonsymmetric, recurrence *r) {
    for (int32_t b = 0; b < op->blocks; b++)
        r->awake[b] = 1;
    for (int64_t k = 0; k < 2 * (int64_t)op->n * op->dof; k++)
        r->u[sp_operator_at(op, k / 2) + k % 2] = 1e-3 * (double)(k % 17);
    r->start[0] = r->start[1] = 1;
    r->doubled = !nonsymmetric;
}

static double seconds_of_product(recurrence *r, int steps) {
    double start = 0;
    for (int k = -1; k < steps; k++) {
        start = k == 0 ? sp_clock_cpu() : start;
        sp_recurrence_step(r);
    }
    return (sp_clock_cpu() - start) / steps;
}

static double seconds_of_copy(char *to, const char *from, size_t bytes, int steps) {
    double start = 0;
    for (int k = -1; k < steps; k++) { /* the first one finds the caches as the others left them */
        start = k == 0 ? sp_clock_cpu() : start;
        memcpy(to, from, bytes);
        __asm__ volatile("" : : "r"(to) : "memory"); /* or all copies but one would be left out */
    }
    return (sp_clock_cpu() - start) / steps;
}

typedef struct times {
    double product, copy, half;
} times;

/* Least times in seconds. */
static sp_status measure(recurrence *r, double bytes, times *least, sp_error *err) {
    const size_t size = (size_t)bytes;
    const int steps = 3 + (int)(2e7 / bytes);
    char *from = sp_alloc(size, 1), *to = sp_alloc(size, 1);
    *least = (times){HUGE_VAL, HUGE_VAL, HUGE_VAL};
    if (from)
        memset(from, 1, size);
    for (int round = 0; round < ROUNDS && from && to; round++) {
        least->product = fmin(least->product, seconds_of_product(r, steps));
        least->copy = fmin(least->copy, seconds_of_copy(to, from, size, steps));
        least->half = fmin(least->half, seconds_of_copy(to, from, size / 2, steps));
    }
    const bool ok = from && to;
    sp_free(from);
    sp_free(to);
    return ok ? SP_OK : sp_fail_memory(err, 2 * size);
}

static sp_status one(const kind *k, const int32_t *cells, FILE *out, sp_error *err) {
    const sp_network_options o = {.threshold = 0, .prestress = k->prestress};
    sp_packing p = sp_packing_none();
    sp_network net = sp_network_none();
    sp_operator op = {0};
    recurrence r = {0};
    sp_status status = lattice(k, cells, &p, err);
    if (status == SP_OK)
        status = sp_network_make(&p, &o, &net, err);
    if (status == SP_OK)
        status = sp_operator_make(&net, &op, err);
    if (status == SP_OK)
        status = sp_recurrence_make(&op, net.mass, net.omega_bound, 1, &r, err);
    const double bytes = status == SP_OK ? bytes_of(&net) : 0;
    times t = {0};
    if (status == SP_OK) {
        wake_all(&op, net.carried != NULL, &r);
        status = measure(&r, bytes, &t, err);
    }
    if (status == SP_OK)
        fprintf(out, "%s\t%d\t%d\t%d\t%.0f\t%.2f\t%.2f\t%.2f\t%.2f\t%.2f\n", k->name, net.dof, (int)net.n,
                (int)net.n_springs, 1e-3 * bytes, 1e6 * t.product, 1e6 * t.copy, t.product / t.copy, 1e6 * t.half,
                t.product / t.half);
    fflush(out);
    sp_recurrence_free(&r);
    sp_operator_free(&op);
    sp_network_free(&net);
    sp_packing_free(&p);
    return status;
}

int main(int argc, char **argv) {
    FILE *out = argc > 1 ? fopen(argv[1], "w") : stdout;
    sp_error err = {0};
    sp_status status = SP_OK;
    if (!out)
        return 1;
    fprintf(out, "# sonopack %s\n", sp_version());
    fprintf(out, "kind\tdof\tgrains\tsprings\tkB\tproduct_us\tcopy_us\tratio\thalf_us\thalf_ratio\n");
    for (size_t k = 0; k < sizeof KINDS / sizeof *KINDS && status == SP_OK; k++)
        for (int size = 0; size < SIZES && status == SP_OK; size++)
            status = one(&KINDS[k], CELLS[size][KINDS[k].dim == 3], out, &err);
    if (status != SP_OK)
        fprintf(stderr, "products: %s\n", err.text);
    return status == SP_OK && fflush(out) == 0 ? 0 : 1;
}
