/* Smooth packings as minima of the energy: grains at random places in a periodic cell move downhill until they rest, in
 * a cell of fixed size, or in one whose size makes the pressure that is wanted (O'Hern et al., Phys. Rev. E 68, 011306,
 * 2003). The forces are F = 4/3 E12 R12^(2 - a) n^a with an exponent a: harmonic grains for 1, Hertz's for 3/2.
 *
 * The method is FIRE (Bitzek et al., Phys. Rev. Lett. 97, 170201, 2006) in the form of Guenole et al. (Comput. Mater.
 * Sci. 175, 109584, 2020): a motion of unit masses whose velocity is turned towards the force, and which stops where it
 * would go uphill. The logarithm of the cell's edges is one more coordinate. */
#include "base/base.h"
#include "linalg/arrays.h"
#include "numeric/random.h"
#include "packing/contact.h"
#include "packing/geometry.h"
#include "packing/prepare.h"

#include <math.h>
#include <string.h>

enum { LATENCY = 20, REPORT = 1024 };
static const double GROW = 1.1, SHRINK = 0.5, TURN = 0.25, TURN_LESS = 0.99;
/* Fraction of a first, rough minimum where the pressure is given, by dimension. */
static const double DENSE[] = {0, 1, 0.9, 0.7};
static const int64_t STEPS_MOST = 20000000;
static const double ROUGH = 1e-2;                      /* acceleration over the pressure in the first minimum */
static const double PRESSURE_OFF = 1e-9, BARE = 1e-10; /* of the pressure; the pressure where no grains touch */

typedef struct pair {
    int32_t i, j;
    float shift[3]; /* periods from i to the image of j */
    double e, reach;
} pair;

typedef struct minimum {
    const sp_pack_spec *spec;
    const sp_pack_hooks *hooks;
    sp_packing p; /* the state; between new lists its grains may leave the cell */
    pair *pair;
    size_t capacity;
    int64_t pairs, steps;
    double skin;
    double *memory, *v, *f, *stiff, *old; /* [n][3] velocities, forces, sum of stiffnesses [n], places of the list */
    double grown;                         /* edges over those of the list */
    double unit, v_cell, f_cell;          /* the cell's coordinate is unit times the logarithm of its edges */
    double aim;                           /* pressure of this stage */
    double pressure, residual, stiffest;
    bool fixed; /* the cell keeps its size */
} minimum;

/* n^a without pow where a is a multiple of 1/2, so that these packings are the same on all machines. */
static double power(double x, double a) {
    if (2 * a != floor(2 * a))
        return pow(x, a);
    double product = fmod(a, 1) == 0 ? 1 : sqrt(x);
    for (int k = 0; k < (int)a; k++)
        product *= x;
    return product;
}

/* 4/3 E12 R12^(2 - a) with E12 = 1/2. */
static double strength(const minimum *m, double ri, double rj) {
    const double r = ri * rj / (ri + rj);
    return 2.0 / 3.0 * r * r / power(r, m->spec->law_exponent);
}

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
    *q = (pair){.i = i, .j = j, .e = strength(m, p->r[i], p->r[j]), .reach = reach};
    for (int k = 0; k < p->dim; k++)
        q->shift[k] = (float)nearbyint((d[k] - (b[k] - a[k])) / p->box[k]);
    return SP_OK;
}

static sp_status list_pairs(minimum *m, sp_error *err) {
    for (int32_t i = 0; i < m->p.n; i++)
        sp_packing_wrap(&m->p, m->p.x + 3 * (size_t)i);
    memcpy(m->old, m->p.x, 3 * (size_t)m->p.n * sizeof *m->old);
    m->pairs = 0;
    m->grown = 1;
    return sp_packing_sweep(&m->p, m->skin, add_pair, m, err);
}

/* Whether two grains may have come nearer than the list knows: by their own motion, or with the cell. */
static bool is_old(const minimum *m) {
    const double shrunk = fmax(0, 1 - m->grown) * (2 * m->spec->diameter_max + m->skin);
    const double most = 0.5 * (m->skin - shrunk);
    for (int32_t i = 0; i < m->p.n; i++) {
        double squares = 0;
        for (int k = 0; k < m->p.dim; k++) {
            const double moved = m->p.x[3 * (size_t)i + (size_t)k] - m->grown * m->old[3 * (size_t)i + (size_t)k];
            squares += moved * moved;
        }
        if (!(most > 0 && squares < most * most))
            return true;
    }
    return false;
}

/* The vector from grain i to the image of grain j, and its length. */
static double separation(const minimum *m, const pair *q, double d[3]) {
    const double *a = m->p.x + 3 * (size_t)q->i, *b = m->p.x + 3 * (size_t)q->j;
    double squares = 0;
    for (int k = 0; k < m->p.dim; k++) {
        d[k] = b[k] - a[k] + (double)q->shift[k] * m->p.box[k];
        squares += d[k] * d[k];
    }
    return sqrt(squares);
}

static void find_forces(minimum *m) {
    const int dim = m->p.dim;
    const double a = m->spec->law_exponent, volume = sp_packing_volume(&m->p);
    double virial = 0, largest = 0, stiffest = 0;
    memset(m->f, 0, 3 * (size_t)m->p.n * sizeof *m->f);
    memset(m->stiff, 0, (size_t)m->p.n * sizeof *m->stiff);
    for (int64_t q = 0; q < m->pairs; q++) {
        const pair *c = &m->pair[q];
        double d[3];
        const double r = separation(m, c, d), overlap = c->reach - r;
        if (!(overlap > 0 && r > 0))
            continue;
        const double force = c->e * power(overlap, a), k = a * force / overlap;
        double *on_i = m->f + 3 * (size_t)c->i, *on_j = m->f + 3 * (size_t)c->j;
        for (int b = 0; b < dim; b++) {
            on_i[b] -= force / r * d[b];
            on_j[b] += force / r * d[b];
        }
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
    m->f_cell = m->fixed ? 0 : dim * volume * (m->pressure - m->aim) / m->unit;
}

static double dot(const minimum *m, const double *a, const double *b, double cell) {
    double sum = cell;
    for (size_t k = 0; k < 3 * (size_t)m->p.n; k++)
        sum += a[k] * b[k];
    return sum;
}

/* x += t v. */
static void move(minimum *m, double t) {
    const double grow = exp(t * m->v_cell / m->unit);
    for (int b = 0; b < m->p.dim; b++)
        m->p.box[b] *= grow;
    m->grown *= grow;
    for (size_t k = 0; k < 3 * (size_t)m->p.n; k++)
        m->p.x[k] = grow * (m->p.x[k] + t * m->v[k]);
}

/* v = (1 - turn) (v + dt f) + turn |v| f/|f|. */
static void push(minimum *m, double dt, double turn) {
    for (size_t k = 0; k < 3 * (size_t)m->p.n; k++)
        m->v[k] += dt * m->f[k];
    m->v_cell += dt * m->f_cell;
    const double force = sqrt(dot(m, m->f, m->f, m->f_cell * m->f_cell));
    const double speed = sqrt(dot(m, m->v, m->v, m->v_cell * m->v_cell));
    const double along = force > 0 ? turn * speed / force : 0;
    for (size_t k = 0; k < 3 * (size_t)m->p.n; k++)
        m->v[k] = (1 - turn) * m->v[k] + along * m->f[k];
    m->v_cell = (1 - turn) * m->v_cell + along * m->f_cell;
}

static bool at_rest(const minimum *m) {
    const double p = m->fixed ? m->pressure : m->aim;
    if (m->residual > m->spec->tolerance || !(m->fixed || fabs(m->pressure / p - 1) < PRESSURE_OFF))
        return false;
    return m->residual <= fmax(1e-6 * p, sp_rounding_acceleration(p, m->spec->law_exponent));
}

static sp_status report(const minimum *m, sp_error *err) {
    const sp_pack_progress progress = {.phase = "equilibration",
                                       .steps = m->steps,
                                       .height = sp_packing_height(&m->p),
                                       .residual = m->residual,
                                       .fraction = NAN};
    if (!m->hooks->watch || m->hooks->watch(&progress, m->hooks->user))
        return SP_OK;
    return sp_fail(err, SP_EINTERRUPTED, "stopped after %lld steps", (long long)m->steps);
}

static sp_status descend(minimum *m, sp_error *err) {
    const int64_t most = m->spec->max_steps > 0 ? m->spec->max_steps : STEPS_MOST;
    const int64_t begin = m->steps;
    double dt = 0, turn = TURN;
    int64_t downhill = 0;
    for (; m->steps < begin + most; m->steps++) {
        const bool first = m->steps == begin;
        sp_status status = first || is_old(m) ? list_pairs(m, err) : SP_OK;
        if (status == SP_OK && m->steps % REPORT == 0)
            status = report(m, err);
        if (status != SP_OK)
            return status;
        find_forces(m);
        /* only a cell whose grains are jammed adapts itself: one that springs open heats them, and they may order */
        if (m->fixed && m->residual <= ROUGH * m->pressure)
            m->fixed = m->spec->fraction > 0;
        if (m->spec->fraction > 0 && m->pressure < BARE)
            return sp_fail(err, SP_EFAILED,
                           "packing.fraction = %g: is too little for a rigid packing: the pressure fell below %g E*",
                           m->spec->fraction, BARE);
        if (at_rest(m))
            return SP_OK;
        const double longest = 0.7 / sqrt(fmax(2 * m->stiffest, 1e-12)); /* omega_max^2 <= 2 max sum k */
        dt = first ? 0.1 * longest : fmin(dt, longest);
        if (dot(m, m->f, m->v, m->f_cell * m->v_cell) > 0) {
            if (++downhill > LATENCY) {
                dt = fmin(GROW * dt, longest);
                turn *= TURN_LESS;
            }
        } else {
            if (m->steps > begin + LATENCY && dt > 0.02 * longest)
                dt *= SHRINK;
            downhill = 0;
            turn = TURN;
            move(m, -0.5 * dt);
            memset(m->v, 0, 3 * (size_t)m->p.n * sizeof *m->v);
            m->v_cell = 0;
        }
        push(m, dt, turn);
        move(m, dt);
    }
    return sp_fail(err, SP_EFAILED,
                   "not at rest after %lld steps: the largest acceleration is %.3g, must be below %.3g",
                   (long long)most, m->residual, m->spec->tolerance);
}

/* Random points in a cell of the fraction that is given, or that is usual. */
static sp_status start(minimum *m, sp_error *err) {
    const sp_pack_spec *s = m->spec;
    const int dim = s->dim;
    const size_t n = (size_t)s->grains;
    sp_status status = sp_packing_alloc(&m->p, dim, s->grains, 0, err);
    if (status != SP_OK)
        return status;
    m->p.cell = SP_CELL_PERIODIC;
    sp_radii_draw(s, m->p.r);
    double solid = 0;
    for (size_t i = 0; i < n; i++)
        solid += dim == 2 ? 3.14159265358979323846 * m->p.r[i] * m->p.r[i] : grain_mass(m->p.r[i]);
    const double height = sp_cell_spec_height(s), edges[] = {s->width, dim == 3 ? s->depth : height, height};
    double shape = 1;
    for (int a = 0; a < dim; a++)
        shape *= edges[a];
    const double scale = pow(solid / (s->fraction > 0 ? s->fraction : DENSE[dim]) / shape, 1.0 / dim);
    for (int a = 0; a < dim; a++)
        m->p.box[a] = edges[a] * scale;
    sp_random stream = sp_random_make(s->seed, SP_STREAM_GAS);
    for (size_t i = 0; i < n; i++)
        for (int a = 0; a < dim; a++)
            m->p.x[3 * i + (size_t)a] = m->p.box[a] * sp_random_uniform(&stream);
    m->skin = 0.3 * s->diameter_min;
    m->unit = dim * sqrt((double)n);
    const sp_array arrays[] = {{&m->v, 3 * n}, {&m->f, 3 * n}, {&m->old, 3 * n}, {&m->stiff, n}, {0}};
    return sp_arrays_make(arrays, &m->memory, err);
}

/* The packing with its contacts. Those of another law than Hertz's have stiffnesses of their own. */
static sp_status finish(const minimum *m, sp_packing *out, sp_error *err) {
    const double a = m->spec->law_exponent;
    int32_t count = 0;
    double d[3];
    sp_packing p = sp_packing_none();
    for (int64_t q = 0; q < m->pairs; q++)
        count += separation(m, &m->pair[q], d) < m->pair[q].reach;
    sp_status status = sp_packing_alloc(&p, m->p.dim, m->p.n, count, err);
    if (status != SP_OK)
        return status;
    memcpy(p.x, m->p.x, 3 * (size_t)p.n * sizeof *p.x);
    memcpy(p.r, m->p.r, (size_t)p.n * sizeof *p.r);
    memcpy(p.box, m->p.box, sizeof p.box);
    p.cell = SP_CELL_PERIODIC;
    p.pressure = m->pressure;
    p.poisson = m->spec->poisson;
    p.seed = m->spec->seed;
    p.steps = m->steps;
    p.residual = m->residual;
    count = 0;
    for (int64_t q = 0; q < m->pairs; q++) {
        const pair *c = &m->pair[q];
        const double r = separation(m, c, d), overlap = c->reach - r;
        if (!(overlap > 0))
            continue;
        sp_contact *to = &p.contacts[count++];
        to->i = c->i;
        to->j = c->j;
        for (int b = 0; b < p.dim; b++)
            to->n[b] = d[b] / r;
        to->overlap = overlap;
        to->fn = c->e * power(overlap, a);
        to->kn = a == 1.5 ? 0 : a * to->fn / overlap;
    }
    for (int32_t i = 0; i < p.n; i++)
        sp_packing_wrap(&p, p.x + 3 * (size_t)i);
    sp_packing_sort(&p);
    *out = p;
    return SP_OK;
}

static sp_status report_stage(const minimum *m, int32_t k, sp_error *err) {
    sp_packing p = sp_packing_none();
    if (!m->hooks->stage)
        return SP_OK;
    sp_status status = finish(m, &p, err);
    if (status == SP_OK)
        status = m->hooks->stage(&p, k, m->hooks->user, err);
    sp_packing_free(&p);
    return status;
}

sp_status sp_minimum_make(const sp_pack_spec *spec, const sp_pack_hooks *hooks, sp_packing *out, sp_error *err) {
    minimum m = {.spec = spec, .hooks = hooks, .p = sp_packing_none(), .fixed = true};
    sp_status status = start(&m, err);
    for (int32_t k = 0; k <= spec->history_count && status == SP_OK; k++) {
        m.aim = k < spec->history_count ? spec->history[k] : spec->pressure;
        status = descend(&m, err);
        if (status == SP_OK && k < spec->history_count)
            status = report_stage(&m, k, err);
    }
    if (status == SP_OK)
        status = finish(&m, out, err);
    sp_packing_free(&m.p);
    sp_free(m.pair);
    sp_free(m.memory);
    return status;
}
