/* Motions of single grains and of rigid parts that stretch no spring. */
#include "network/null_motions.h"

#include "base/base.h"
#include "base/vector.h"
#include "network/network_cell.h"
#include "network/rows.h"

#include <float.h>
#include <math.h>
#include <string.h>

/* ---- null spaces of small matrices --------------------------------------------------------------------------------
 */

enum { MOST = SP_GRAIN_DOFS };

/* The factor R of W = Q R for a matrix W with up to six columns and any number of rows, which are added one by one:
 * R^T R = W^T W, but small singular values are not squared. Givens rotations, and one-sided Jacobi rotations (Hestenes
 * 1958), which find small singular values accurately. */
typedef struct svd {
    int n; /* columns */
    double r[MOST][MOST];
} svd;

/* Adds a row of W, which is overwritten. */
static void svd_add(svd *t, double row[MOST]) {
    for (int c = 0; c < t->n; c++) {
        double *own = t->r[c];
        const double size = hypot(own[c], row[c]);
        if (row[c] == 0)
            continue;
        const double cosine = own[c] / size, sine = row[c] / size;
        for (int k = c; k < t->n; k++) {
            const double a = own[k], b = row[k];
            own[k] = cosine * a + sine * b;
            row[k] = cosine * b - sine * a;
        }
    }
}

/* A lower bound of all singular values. It costs less. */
static double svd_least(const svd *t) {
    double inverse[MOST][MOST] = {{0}}, squares = 0;
    for (int c = 0; c < t->n; c++)
        for (int r = c; r >= 0; r--) {
            double sum = r == c;
            for (int k = r + 1; k <= c; k++)
                sum -= t->r[r][k] * inverse[k][c];
            if (t->r[r][r] == 0)
                return 0;
            inverse[r][c] = sum / t->r[r][r];
            squares += inverse[r][c] * inverse[r][c];
        }
    return isfinite(squares) ? 1 / sqrt(squares) : 0;
}

/* Makes columns p and q of g orthogonal; returns whether they were not. */
static int rotate(int n, double g[MOST][MOST], double v[MOST][MOST], int p, int q, double tiny) {
    double pp = 0, qq = 0, pq = 0;
    for (int k = 0; k < n; k++) {
        pp += g[p][k] * g[p][k];
        qq += g[q][k] * g[q][k];
        pq += g[p][k] * g[q][k];
    }
    if (fabs(pq) <= 4 * DBL_EPSILON * sqrt(pp * qq) || fabs(pq) <= tiny)
        return 0;
    const double tau = (qq - pp) / (2 * pq), tangent = copysign(1, tau) / (fabs(tau) + hypot(1, tau));
    const double cosine = 1 / hypot(1, tangent), sine = cosine * tangent;
    for (int k = 0; k < n; k++) {
        const double a = g[p][k], b = g[q][k], x = v[p][k], y = v[q][k];
        g[p][k] = cosine * a - sine * b;
        g[q][k] = sine * a + cosine * b;
        v[p][k] = cosine * x - sine * y;
        v[q][k] = sine * x + cosine * y;
    }
    return 1;
}

/* Singular values of W and its right singular vectors v[k], in no order. */
static void svd_values(const svd *t, double value[MOST], double v[MOST][MOST]) {
    const int n = t->n;
    double g[MOST][MOST] = {{0}}, squares = 0; /* columns of R v */
    for (int c = 0; c < n; c++)
        for (int k = 0; k < n; k++) {
            g[c][k] = k <= c ? t->r[k][c] : 0;
            v[c][k] = k == c;
            squares += g[c][k] * g[c][k];
        }
    for (int sweep = 0, turned = 1; sweep < 30 && turned; sweep++) {
        turned = 0;
        for (int p = 0; p < n; p++)
            for (int q = p + 1; q < n; q++)
                turned += rotate(n, g, v, p, q, DBL_EPSILON * DBL_EPSILON * squares);
    }
    for (int c = 0; c < n; c++) {
        value[c] = 0;
        for (int k = 0; k < n; k++)
            value[c] += g[c][k] * g[c][k];
        value[c] = sqrt(value[c]);
    }
}

enum { DOFS = SP_GRAIN_DOFS };

/* A motion stretches no spring if |A^1/2 e| is below this fraction of the largest frequency: rounding. */
static const double SLACK = 1e-12;
/* Rigid motions of a part are dependent if this little is left of one after the others: on a line of grains the
 * rotation about the line is that of its spins. */
static const double DEPENDENT = 1e-6;

/* A set of grains that springs join, directly or through others. */
typedef struct part {
    int32_t grains;
    int64_t first;                  /* its first vector */
    bool wraps;                     /* around the periodic cell, so that it cannot rotate */
    double centre[3];               /* mean place */
    int count;                      /* independent motions as a rigid body */
    double coefficient[DOFS][DOFS]; /* of each: translations, then rotations */
    svd t;
} part;

typedef struct maker {
    const sp_network *net;
    sp_null_motions *out;
    int32_t *root;       /* [n] another grain of the same part, or itself */
    int32_t (*shift)[3]; /* [n] periods by which the grain is to be moved next to that one */
    int32_t *size;       /* [n] grains of a root's part; 0 for others */
    bool *wraps;         /* [n] of roots */
    int32_t *number;     /* [n] part of each grain */
    int64_t *first;      /* [n + 1] first spin of each grain */
    int32_t count;
    part *parts; /* [count] */
} maker;

void sp_null_motions_free(sp_null_motions *z) {
    sp_free(z->grain);
    sp_free(z->spin);
    sp_free(z->motion);
    *z = (sp_null_motions){0};
}

/* ---- motions of one grain --------------------------------------------------------------------------------------- */

/* Adds the stretches of a spring by the motions [columns][dofs] of its two grains; unit: mass-weighted motions. */
static void add_stretches(const sp_network *net, const sp_spring *s, int columns, double (*i)[DOFS], double (*j)[DOFS],
                          svd *t) {
    const int dof = net->dof;
    const double *mi = net->mass + (int64_t)s->i * dof, *mj = s->j >= 0 ? net->mass + (int64_t)s->j * dof : NULL;
    sp_rows rows;
    sp_network_rows(net, s, &rows);
    for (int q = 0; q < rows.count; q++) {
        const double root = sqrt(fabs(rows.k[q]));
        double row[MOST] = {0};
        for (int c = 0; c < columns; c++)
            for (int a = 0; a < dof; a++) {
                row[c] += i ? root * rows.b[q][a] * i[c][a] / sqrt(mi[a]) : 0;
                row[c] += j && mj ? root * rows.b[q][dof + a] * j[c][a] / sqrt(mj[a]) : 0;
            }
        svd_add(t, row);
    }
}

/* Stores the null vectors of a grain; counts only while there is no memory for them. */
static void keep_spins(maker *k, int32_t grain, const svd *t) {
    const double limit = SLACK * sp_network_omega_bound(k->net);
    double value[DOFS], v[DOFS][DOFS] = {{0}}; /* fewer degrees of freedom leave the rest 0 */
    if (svd_least(t) > limit)
        return;
    svd_values(t, value, v);
    for (int c = 0; c < t->n; c++)
        if (value[c] <= limit) {
            if (k->out->spin) {
                k->out->grain[k->out->spins] = grain;
                memcpy(k->out->spin[k->out->spins], v[c], sizeof v[c]);
            }
            k->out->stretch = fmax(k->out->stretch, value[c]);
            k->out->spins++;
        }
}

static sp_status find_spins(maker *k, sp_error *err) {
    static double unit[DOFS][DOFS] = {{1}, {0, 1}, {0, 0, 1}, {0, 0, 0, 1}, {0, 0, 0, 0, 1}, {0, 0, 0, 0, 0, 1}};
    const sp_network *net = k->net;
    svd *t = sp_alloc((size_t)net->n, sizeof *t);
    if (!t)
        return sp_fail_memory(err, (size_t)net->n * sizeof *t);
    for (int32_t i = 0; i < net->n; i++)
        t[i].n = net->dof;
    for (int32_t q = 0; q < net->n_springs; q++) {
        const sp_spring *s = &net->springs[q];
        if (s->i == s->j) {
            add_stretches(net, s, net->dof, unit, unit, &t[s->i]);
            continue;
        }
        add_stretches(net, s, net->dof, unit, NULL, &t[s->i]);
        if (s->j >= 0)
            add_stretches(net, s, net->dof, NULL, unit, &t[s->j]);
    }
    for (int32_t i = 0; i < net->n; i++)
        keep_spins(k, i, &t[i]);
    const size_t spins = (size_t)k->out->spins;
    k->out->grain = sp_alloc(spins, sizeof *k->out->grain);
    k->out->spin = sp_alloc(spins, sizeof *k->out->spin);
    k->out->spins = 0;
    for (int32_t i = 0; i < net->n && k->out->grain && k->out->spin; i++) {
        k->first[i] = k->out->spins;
        if (spins > 0)
            keep_spins(k, i, &t[i]);
        k->first[i + 1] = k->out->spins;
    }
    sp_free(t);
    return k->out->grain && k->out->spin ? SP_OK : sp_fail_memory(err, spins * sizeof *k->out->spin);
}

/* ---- rigid parts ------------------------------------------------------------------------------------------------ */

static int32_t root_of(maker *k, int32_t i) {
    while (k->root[i] != k->root[k->root[i]]) { /* shortens the way, for next time */
        const int32_t up = k->root[i];
        for (int a = 0; a < 3; a++)
            k->shift[i][a] += k->shift[up][a];
        k->root[i] = k->root[up];
    }
    return k->root[i];
}

/* Periods that bring grain i next to its root, along springs. */
static void shift_of(maker *k, int32_t i, int32_t shift[3]) {
    shift[0] = shift[1] = shift[2] = 0;
    for (; k->root[i] != i; i = k->root[i])
        for (int a = 0; a < 3; a++)
            shift[a] += k->shift[i][a];
}

static void join(maker *k, int32_t spring) {
    const sp_spring *s = &k->net->springs[spring];
    int32_t from[3], to[3], step[3];
    sp_network_image(k->net, spring, step);
    const int32_t i = root_of(k, s->i), j = root_of(k, s->j);
    shift_of(k, s->i, from);
    shift_of(k, s->j, to);
    if (i == j) {
        for (int a = 0; a < 3; a++)
            k->wraps[i] = k->wraps[i] || to[a] != from[a] + step[a];
        return;
    }
    const bool under = k->size[i] < k->size[j];
    const int32_t high = under ? j : i, low = under ? i : j;
    k->root[low] = high;
    for (int a = 0; a < 3; a++)
        k->shift[low][a] = (under ? -1 : 1) * (from[a] + step[a] - to[a]);
    k->size[high] += k->size[low];
    k->size[low] = 0;
    k->wraps[high] = k->wraps[high] || k->wraps[low];
}

/* Centre of grain i as seen from its part's root, around the periodic cell. */
static void place_of(maker *k, int32_t i, double x[3]) {
    int32_t shift[3];
    shift_of(k, i, shift);
    for (int a = 0; a < 3; a++)
        x[a] = k->net->x[3 * i + a];
    for (int a = 0; a < k->net->dim; a++)
        sp_network_move(k->net, a, shift[a], x);
}

static int motions_of(const sp_network *net, const part *p) {
    const int turns = net->dim == 3 ? 3 : net->dim == 2 ? 1 : 0;
    return p->grains < 2 ? 0 : net->dim + (p->wraps ? 0 : turns);
}

/* The motions of grain i with its part: translations, then rotations about the part's centre. */
static void ride_whole(maker *k, const part *p, int32_t i, double out[DOFS][DOFS]) {
    const sp_network *net = k->net;
    const double *mass = net->mass + (int64_t)i * net->dof;
    double x[3];
    memset(out, 0, DOFS * sizeof *out);
    place_of(k, i, x);
    for (int a = 0; a < 3; a++)
        x[a] -= p->centre[a];
    for (int c = 0; c < motions_of(net, p); c++) {
        double axis[3] = {0, 0, 0}, turn[3] = {0, 0, 0};
        if (c < net->dim)
            out[c][c] = 1;
        else {
            axis[net->dim == 2 ? 2 : c - net->dim] = 1;
            cross3(axis, x, turn);
        }
        for (int a = 0; a < net->dim; a++)
            out[c][a] += turn[a];
        for (int a = net->dim; a < net->dof; a++)
            out[c][a] = net->dim == 2 ? axis[2] : axis[a - net->dim];
        for (int a = 0; a < net->dof; a++)
            out[c][a] *= sqrt(mass[a]);
    }
}

/* The same less its part in the space of the grain's spins. */
static void ride(maker *k, const part *p, int32_t i, double out[DOFS][DOFS]) {
    ride_whole(k, p, i, out);
    for (int64_t q = k->first[i]; q < k->first[i + 1]; q++)
        for (int c = 0; c < DOFS; c++) {
            double share = 0;
            for (int a = 0; a < DOFS; a++)
                share += out[c][a] * k->out->spin[q][a];
            for (int a = 0; a < DOFS; a++)
                out[c][a] -= share * k->out->spin[q][a];
        }
}

/* The same in an orthonormal basis of the part's motions. */
static void ride_basis(maker *k, const part *p, int32_t i, double out[DOFS][DOFS]) {
    double raw[DOFS][DOFS];
    ride(k, p, i, raw);
    memset(out, 0, DOFS * sizeof *out);
    for (int q = 0; q < p->count; q++)
        for (int c = 0; c < DOFS; c++)
            for (int a = 0; a < DOFS; a++)
                out[q][a] += p->coefficient[q][c] * raw[c][a];
}

static void find_centres(maker *k) {
    for (int32_t i = 0; i < k->net->n; i++) {
        part *p = &k->parts[k->number[i]];
        double x[3];
        place_of(k, i, x);
        for (int a = 0; a < 3; a++)
            p->centre[a] += x[a] / p->grains;
    }
}

/* Replaces the motions of a part by those of a basis, given by the triangle of some of their products: the directions
 * with singular values above `least` times the largest, scaled to 1; or, with least < 0, those below `most`,
 * unscaled. */
static void choose(part *p, double least, double most, double *worst) {
    double value[DOFS], v[DOFS][DOFS], before[DOFS][DOFS], top = 0;
    const int count = p->t.n;
    svd_values(&p->t, value, v);
    memcpy(before, p->coefficient, sizeof before);
    memset(p->coefficient, 0, sizeof p->coefficient);
    p->count = 0;
    for (int c = 0; c < count; c++)
        top = fmax(top, value[c]);
    for (int c = 0; c < count; c++) {
        if (least >= 0 ? !(value[c] > least * top) : !(value[c] <= most))
            continue;
        for (int q = 0; q < count; q++)
            for (int a = 0; a < DOFS; a++)
                p->coefficient[p->count][a] += v[c][q] * before[q][a] / (least >= 0 ? value[c] : 1);
        p->count++;
        if (least < 0)
            *worst = fmax(*worst, value[c]);
    }
}

/* Starts with the motions themselves, each scaled to 1. */
static void start_basis(maker *k) {
    for (int32_t i = 0; i < k->net->n; i++) { /* sums of squares */
        part *p = &k->parts[k->number[i]];
        double raw[DOFS][DOFS];
        ride_whole(k, p, i, raw);
        for (int c = 0; c < motions_of(k->net, p); c++)
            for (int a = 0; a < DOFS; a++)
                p->coefficient[c][c] += raw[c][a] * raw[c][a];
    }
    for (int32_t i = 0; i < k->count; i++) {
        part *p = &k->parts[i];
        p->t = (svd){.n = p->count = motions_of(k->net, p)};
        for (int c = 0; c < p->count; c++)
            p->coefficient[c][c] = p->coefficient[c][c] > 0 ? 1 / sqrt(p->coefficient[c][c]) : 0;
    }
}

/* Leaves an orthonormal basis of all rigid motions of each part, less its spins. */
static void find_basis(maker *k) {
    start_basis(k);
    for (int32_t i = 0; i < k->net->n; i++) {
        part *p = &k->parts[k->number[i]];
        double own[DOFS][DOFS];
        ride_basis(k, p, i, own);
        for (int a = 0; a < DOFS && p->count > 0; a++) {
            double row[MOST] = {0};
            for (int q = 0; q < p->count; q++)
                row[q] = own[q][a];
            svd_add(&p->t, row);
        }
    }
    for (int32_t i = 0; i < k->count; i++)
        if (k->parts[i].count > 0) {
            choose(&k->parts[i], DEPENDENT, 0, NULL);
            k->parts[i].t = (svd){.n = k->parts[i].count};
        }
}

/* Leaves those that stretch no spring. */
static void find_free(maker *k) {
    const sp_network *net = k->net;
    for (int32_t q = 0; q < net->n_springs; q++) {
        const sp_spring *s = &net->springs[q];
        part *p = &k->parts[k->number[s->i]];
        double i[DOFS][DOFS], j[DOFS][DOFS];
        if (p->count == 0)
            continue;
        ride_basis(k, p, s->i, i);
        if (s->j >= 0)
            ride_basis(k, p, s->j, j);
        add_stretches(net, s, p->count, i, s->j >= 0 ? j : NULL, &p->t);
    }
    for (int32_t i = 0; i < k->count; i++)
        if (k->parts[i].count > 0) {
            choose(&k->parts[i], -1, SLACK * sp_network_omega_bound(net), &k->out->stretch);
            k->out->rigid += k->parts[i].count;
        }
}

static sp_status write_rigid(maker *k, sp_error *err) {
    const sp_network *net = k->net;
    const size_t dofs = (size_t)sp_network_dofs(net), rigid = (size_t)k->out->rigid;
    int64_t next = 0;
    if (rigid == 0)
        return SP_OK;
    k->out->motion = sp_alloc(rigid, dofs * sizeof *k->out->motion);
    if (!k->out->motion)
        return sp_fail_memory(err, rigid * dofs * sizeof *k->out->motion);
    for (int32_t i = 0; i < k->count; i++) {
        k->parts[i].first = next;
        next += k->parts[i].count;
    }
    for (int32_t i = 0; i < net->n; i++) {
        const part *p = &k->parts[k->number[i]];
        double own[DOFS][DOFS];
        if (p->count == 0)
            continue;
        ride_basis(k, p, i, own);
        for (int q = 0; q < p->count; q++)
            memcpy(k->out->motion + (size_t)(p->first + q) * dofs + (size_t)i * (size_t)net->dof, own[q],
                   (size_t)net->dof * sizeof(double));
    }
    return SP_OK;
}

/* Numbers the parts, and gives each grain the number of its own. */
static sp_status find_parts(maker *k, sp_error *err) {
    const sp_network *net = k->net;
    for (int32_t i = 0; i < net->n; i++) {
        k->root[i] = i;
        k->size[i] = 1;
    }
    for (int32_t q = 0; q < net->n_springs; q++)
        if (net->springs[q].j >= 0 && (net->springs[q].kn > 0 || net->springs[q].kt > 0))
            join(k, q);
    for (int32_t i = 0; i < net->n; i++)
        if (k->size[i] > 0)
            k->number[i] = k->count++;
    for (int32_t i = 0; i < net->n; i++)
        k->number[i] = k->number[root_of(k, i)];
    k->parts = sp_alloc((size_t)k->count, sizeof *k->parts);
    if (!k->parts)
        return sp_fail_memory(err, (size_t)k->count * sizeof *k->parts);
    for (int32_t i = 0; i < net->n; i++)
        if (k->size[i] > 0) {
            k->parts[k->number[i]].grains = k->size[i];
            k->parts[k->number[i]].wraps = k->wraps[i];
        }
    return SP_OK;
}

static sp_status find_rigid(maker *k, sp_error *err) {
    sp_status status = find_parts(k, err);
    if (status != SP_OK)
        return status;
    find_centres(k);
    find_basis(k);
    find_free(k);
    return write_rigid(k, err);
}

static void maker_free(maker *k) {
    sp_free(k->root);
    sp_free(k->shift);
    sp_free(k->size);
    sp_free(k->wraps);
    sp_free(k->number);
    sp_free(k->first);
    sp_free(k->parts);
}

sp_status sp_null_motions_make(const sp_network *net, sp_null_motions *out, sp_error *err) {
    const size_t n = (size_t)net->n;
    sp_null_motions z = {0};
    maker k = {.net = net, .out = &z};
    k.root = sp_alloc(n, sizeof *k.root);
    k.shift = sp_alloc(n, sizeof *k.shift);
    k.size = sp_alloc(n, sizeof *k.size);
    k.wraps = sp_alloc(n, sizeof *k.wraps);
    k.number = sp_alloc(n, sizeof *k.number);
    k.first = sp_alloc(n + 1, sizeof *k.first);
    sp_status status = SP_OK;
    if (!k.root || !k.shift || !k.size || !k.wraps || !k.number || !k.first)
        status = sp_fail_memory(err, n * (4 * sizeof *k.root + sizeof *k.first));
    if (status == SP_OK)
        status = find_spins(&k, err);
    if (status == SP_OK)
        status = find_rigid(&k, err);
    maker_free(&k);
    if (status == SP_OK)
        *out = z;
    else
        sp_null_motions_free(&z);
    return status;
}

/* ---- use -------------------------------------------------------------------------------------------------------- */

void sp_null_motions_vector(const sp_network *net, const sp_null_motions *z, int64_t k, double *e) {
    const size_t dofs = (size_t)sp_network_dofs(net), dof = (size_t)net->dof;
    if (k >= z->spins) {
        memcpy(e, z->motion + (size_t)(k - z->spins) * dofs, dofs * sizeof *e);
        return;
    }
    memset(e, 0, dofs * sizeof *e);
    memcpy(e + (size_t)z->grain[k] * dof, z->spin[k], dof * sizeof *e);
}

/* e -= v (v . e); returns v . e. */
static double subtract(int64_t n, const double *v, double *e) {
    double share = 0;
    for (int64_t k = 0; k < n; k++)
        share += v[k] * e[k];
    for (int64_t k = 0; k < n; k++)
        e[k] -= share * v[k];
    return share;
}

double sp_null_motions_remove(const sp_network *net, const sp_null_motions *z, double *e) {
    const int64_t dofs = sp_network_dofs(net);
    double squares = 0;
    for (int pass = 0; pass < 2; pass++) { /* twice: vectors are orthonormal up to rounding */
        for (int64_t k = 0; k < z->spins; k++) {
            const double share = subtract(net->dof, z->spin[k], e + (int64_t)z->grain[k] * net->dof);
            squares += share * share;
        }
        for (int64_t k = 0; k < z->rigid; k++) {
            const double share = subtract(dofs, z->motion + k * dofs, e);
            squares += share * share;
        }
    }
    return sqrt(squares);
}
