/* Pairs, forces and the cell of smooth grains. */
#include "packing/minimum.h"

#include "base/base.h"
#include "packing/contact.h"
#include "packing/geometry.h"
#include "packing/prepare.h"
#include "packing/types.h"

#include <math.h>
#include <string.h>

enum { TENSOR = MINIMUM_TENSOR };
static const double PRESSURE_OFF = 1e-9; /* of the pressure */

static sp_status add_pair(int32_t i, int32_t j, void *user, sp_error *err) {
    minimum *m = user;
    const sp_packing *p = &m->p;
    const double *a = p->x + 3 * (size_t)i, *b = p->x + 3 * (size_t)j;
    double d[3], squares = 0;
    sp_packing_separation(p, i, j, d);
    for (int k = 0; k < p->dim; k++)
        squares += d[k] * d[k];
    const double reach = p->r[i] + p->r[j];
    if (squares >= (reach + m->skin) * (reach + m->skin))
        return SP_OK;
    pair *larger = sp_grow(m->pair, (size_t)m->pairs + 1, &m->capacity, sizeof *larger);
    if (!larger)
        return sp_fail_memory(err, ((size_t)m->pairs + 1) * sizeof *larger);
    m->pair = larger;
    pair *q = &m->pair[m->pairs++];
    const double e = sp_types_rule(m->spec, m->type[i], m->type[j]).stiffness;
    *q = (pair){.i = i, .j = j, .e = e * contact_strength(p->r[i], p->r[j], m->spec->law_exponent), .reach = reach};
    for (int k = 0; k < p->dim; k++)
        d[k] -= b[k] - a[k];
    for (int k = p->dim - 1; k >= 0; k--) {
        q->shift[k] = (float)nearbyint(d[k] / p->box[k]);
        d[0] -= k > 0 ? q->shift[k] * p->tilt[k - 1] : 0;
        d[1] -= k > 1 ? q->shift[k] * p->tilt[2] : 0;
    }
    return SP_OK;
}

sp_status sp_minimum_list(minimum *m, sp_error *err) {
    sp_packing_untilt(m->p.dim, m->p.box, m->p.tilt);
    const double narrowest = 2 * (m->spec->diameter_max + m->skin); /* else a pair has two images */
    for (int a = 0; a < m->p.dim; a++)
        if (!(m->p.box[a] > narrowest))
            return sp_fail_key(err, SP_EFAILED, "packing.grains",
                               " = %d: too few for this cell: an edge has become %.3g, must stay above %.3g", m->p.n,
                               m->p.box[a], narrowest);
    for (int32_t i = 0; i < m->p.n; i++)
        sp_packing_wrap(&m->p, m->p.x + 3 * (size_t)i);
    memcpy(m->old, m->p.x, 3 * (size_t)m->p.n * sizeof *m->old);
    m->pairs = 0;
    m->carried = (cell_strain){.grow = {1, 1, 1}};
    return sp_packing_sweep(&m->p, m->skin, add_pair, m, err);
}

static void carry(const cell_strain *s, const double x[3], double to[3]) {
    to[0] = s->grow[0] * x[0] + (s->shear[0] * x[1] + s->shear[1] * x[2]);
    to[1] = s->grow[1] * x[1] + s->shear[2] * x[2];
    to[2] = s->grow[2] * x[2];
}

/* Strains lattice vectors (edge 0, 0, 0), (tilt 0, edge 1, 0), (tilt 1, tilt 2, edge 2), or another strain. */
static void strain(const cell_strain *s, double edge[3], double tilt[3]) {
    tilt[0] = s->grow[0] * tilt[0] + s->shear[0] * edge[1];
    tilt[1] = s->grow[0] * tilt[1] + s->shear[0] * tilt[2] + s->shear[1] * edge[2];
    tilt[2] = s->grow[1] * tilt[2] + s->shear[2] * edge[2];
    for (int a = 0; a < 3; a++)
        edge[a] *= s->grow[a];
}

/* Whether two grains may have come nearer than the list knows: by their own motion, or with the cell. */
static bool is_old(const minimum *m) {
    const double *grow = m->carried.grow, *shear = m->carried.shear;
    const double least = fmin(grow[0], fmin(grow[1], grow[2])),
                 sheared = fabs(shear[0]) + fabs(shear[1]) + fabs(shear[2]);
    const double nearer = (fmax(0, 1 - least) + sheared) * (2 * m->spec->diameter_max + m->skin);
    const double most = 0.5 * (m->skin - nearer);
    for (int32_t i = 0; i < m->p.n; i++) {
        double squares = 0, carried[3];
        carry(&m->carried, m->old + 3 * (size_t)i, carried);
        for (int k = 0; k < m->p.dim; k++) {
            const double moved = m->p.x[3 * (size_t)i + (size_t)k] - carried[k];
            squares += moved * moved;
        }
        if (!(most > 0 && squares < most * most))
            return true;
    }
    return false;
}

sp_status sp_minimum_refresh(minimum *m, sp_error *err) { return is_old(m) ? sp_minimum_list(m, err) : SP_OK; }

double sp_minimum_separation(const minimum *m, const pair *q, double d[3]) {
    const double *a = m->p.x + 3 * (size_t)q->i, *b = m->p.x + 3 * (size_t)q->j;
    const double *tilt = m->p.tilt, rows = q->shift[1], layers = q->shift[2];
    const double leaning[3] = {rows * tilt[0] + layers * tilt[1], layers * tilt[2], 0};
    double squares = 0;
    for (int k = 0; k < m->p.dim; k++) {
        d[k] = b[k] - a[k] + (double)q->shift[k] * m->p.box[k] + leaning[k];
        squares += d[k] * d[k];
    }
    return squares;
}

static void add_stress(minimum *m, double pull, const double d[3]) {
    for (int a = 0; a < m->p.dim; a++) {
        m->stress[a] += pull * d[a] * d[a];
        for (int b = a + 1; b < m->p.dim; b++)
            m->stress[6 - a - b] += pull * d[a] * d[b];
    }
}

/* Forces on the coordinates of the cell. */
static void find_cell_forces(minimum *m, double volume) {
    for (int c = 0; c < TENSOR; c++) {
        m->stress[c] /= volume;
        m->f_cell[c] = m->cell == CELL_YIELDS && m->free[c] ? volume * (m->stress[c] - m->aims[c]) / m->unit : 0;
    }
    if (m->cell == CELL_GROWS)
        m->f_cell[0] = m->p.dim * volume * (m->pressure - m->aim) / m->unit;
}

double sp_minimum_force(const minimum *m, const pair *q, double overlap) {
    return q->e * contact_power(overlap, m->spec->law_exponent);
}

void sp_minimum_forces(minimum *m) {
    const int dim = m->p.dim;
    const double a = m->spec->law_exponent, volume = sp_packing_volume(&m->p);
    double virial = 0, largest = 0, stiffest = 0;
    memset(m->f, 0, 3 * (size_t)m->p.n * sizeof *m->f);
    memset(m->stiff, 0, (size_t)m->p.n * sizeof *m->stiff);
    memset(m->stress, 0, sizeof m->stress);
    for (int64_t q = 0; q < m->pairs; q++) {
        const pair *c = &m->pair[q];
        double d[3];
        const double squares = sp_minimum_separation(m, c, d);
        if (!(squares < c->reach * c->reach && squares > 0))
            continue;
        const double r = sqrt(squares), overlap = c->reach - r;
        const double force = sp_minimum_force(m, c, overlap), k = a * force / overlap;
        double *on_i = m->f + 3 * (size_t)c->i, *on_j = m->f + 3 * (size_t)c->j;
        for (int b = 0; b < dim; b++) {
            on_i[b] -= force / r * d[b];
            on_j[b] += force / r * d[b];
        }
        if (m->cell == CELL_YIELDS)
            add_stress(m, force / r, d);
        virial += force * r;
        m->stiff[c->i] += k;
        m->stiff[c->j] += k;
    }
    for (int32_t i = 0; i < m->p.n; i++) {
        double squares = 0;
        for (int b = 0; b < dim; b++)
            squares += m->f[3 * (size_t)i + (size_t)b] * m->f[3 * (size_t)i + (size_t)b];
        largest = fmax(largest, sqrt(squares) / grain_mass(m->p.r[i]));
        stiffest = fmax(stiffest, m->stiff[i]);
    }
    m->pressure = virial / (dim * volume);
    m->residual = largest;
    m->stiffest = stiffest;
    find_cell_forces(m, volume);
}

void sp_minimum_deform(minimum *m, const cell_strain *s) {
    strain(s, m->p.box, m->p.tilt);
    strain(s, m->carried.grow, m->carried.shear);
    for (size_t i = 0; i < (size_t)m->p.n; i++)
        carry(s, (const double[3]){m->p.x[3 * i], m->p.x[3 * i + 1], m->p.x[3 * i + 2]}, m->p.x + 3 * i);
}

/* x += t v, and the same of the cell. */
void sp_minimum_move(minimum *m, double t) {
    cell_strain s = {.grow = {1, 1, 1}};
    for (int a = 0; a < m->p.dim; a++)
        s.grow[a] = exp(t * m->v_cell[m->cell == CELL_GROWS ? 0 : a] / m->unit);
    for (int k = 0; k < 3; k++)
        s.shear[k] = t * m->v_cell[5 - k] / m->unit;
    for (int c = 0; c < TENSOR; c++)
        m->flow[c] += t * m->v_cell[c] / m->unit;
    for (size_t k = 0; k < 3 * (size_t)m->p.n; k++)
        m->p.x[k] += t * m->v[k];
    sp_minimum_deform(m, &s);
}

bool sp_minimum_at_rest(const minimum *m) {
    const double p = m->cell == CELL_FIXED ? m->pressure : m->aim;
    double off = m->cell == CELL_GROWS ? fabs(m->pressure - p) : 0;
    for (int c = 0; c < TENSOR && m->cell == CELL_YIELDS; c++)
        off = fmax(off, m->free[c] ? fabs(m->stress[c] - m->aims[c]) : 0);
    if (!(m->residual <= m->spec->tolerance && off < PRESSURE_OFF * p && m->cell == m->wanted))
        return false;
    return m->residual <= fmax(1e-6 * p, sp_rounding_acceleration(p, m->spec->law_exponent));
}
