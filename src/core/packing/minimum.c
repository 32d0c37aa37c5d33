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

enum { LATENCY = 20, REPORT = 1024, TENSOR = 6 };
static const double GROW = 1.1, SHRINK = 0.5, TURN = 0.25, TURN_LESS = 0.99;
/* Fraction of a first, rough minimum where the pressure is given, by dimension. */
static const double DENSE[] = {0, 1, 0.9, 0.7};
static const int64_t STEPS_MOST = 20000000;
static const double ROUGH = 1e-2;                      /* acceleration over the pressure in the first minimum */
static const double PRESSURE_OFF = 1e-9, BARE = 1e-10; /* of the pressure; the pressure where no grains touch */

/* A homogeneous strain: x -> grow x + shear (xy, xz, yz), which keeps the form of the lattice vectors. */
typedef struct cell_strain {
    double grow[3], shear[3];
} cell_strain;

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
    cell_strain carried;                  /* of the cell since the list was made */
    double unit, v_cell[6], f_cell[6];    /* the cell's coordinates are unit times its strains, xx yy zz yz xz xy */
    double aim, strained;                 /* pressure of this stage; where it is on the path of strain */
    double stress[6], aims[6];            /* of the grains, and of this stage; compression positive */
    double pressure, residual, stiffest;
    enum cell {
        FIXED,
        GROWS,
        YIELDS
    } cell,
        wanted; /* keeps its shape; changes its size alone, by v_cell[0]; gives way
                   to the stresses of free components. wanted: once it is jammed */
    bool free[TENSOR];
} minimum;

/* n^a without pow where a is a multiple of 1/2, so that these packings are the same on all machines. */
static double power(double x, double a) {
    const int halves = (int)(2 * a);
    if (2 * a != halves)
        return pow(x, a);
    double product = halves % 2 == 0 ? 1 : sqrt(x);
    for (int k = 0; k < halves / 2; k++)
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
        d[k] -= b[k] - a[k];
    for (int k = p->dim - 1; k >= 0; k--) {
        q->shift[k] = (float)nearbyint(d[k] / p->box[k]);
        d[0] -= k > 0 ? q->shift[k] * p->tilt[k - 1] : 0;
        d[1] -= k > 1 ? q->shift[k] * p->tilt[2] : 0;
    }
    return SP_OK;
}

static sp_status list_pairs(minimum *m, sp_error *err) {
    sp_packing_untilt(m->p.dim, m->p.box, m->p.tilt);
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

/* The vector from grain i to the image of grain j, and the square of its length. */
static inline double separation(const minimum *m, const pair *q, double d[3]) {
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
        m->f_cell[c] = m->cell == YIELDS && m->free[c] ? volume * (m->stress[c] - m->aims[c]) / m->unit : 0;
    }
    if (m->cell == GROWS)
        m->f_cell[0] = m->p.dim * volume * (m->pressure - m->aim) / m->unit;
}

static void find_forces(minimum *m) {
    const int dim = m->p.dim;
    const double a = m->spec->law_exponent, volume = sp_packing_volume(&m->p);
    double virial = 0, largest = 0, stiffest = 0;
    memset(m->f, 0, 3 * (size_t)m->p.n * sizeof *m->f);
    memset(m->stiff, 0, (size_t)m->p.n * sizeof *m->stiff);
    memset(m->stress, 0, sizeof m->stress);
    for (int64_t q = 0; q < m->pairs; q++) {
        const pair *c = &m->pair[q];
        double d[3];
        const double squares = separation(m, c, d);
        if (!(squares < c->reach * c->reach && squares > 0))
            continue;
        const double r = sqrt(squares), overlap = c->reach - r;
        const double force = c->e * power(overlap, a), k = a * force / overlap;
        double *on_i = m->f + 3 * (size_t)c->i, *on_j = m->f + 3 * (size_t)c->j;
        for (int b = 0; b < dim; b++) {
            on_i[b] -= force / r * d[b];
            on_j[b] += force / r * d[b];
        }
        if (m->cell == YIELDS)
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

/* Of two vectors of the grains and of the cell. */
static double dot(const minimum *m, const double *a, const double *b, const double *a_cell, const double *b_cell) {
    double sum = 0;
    for (int c = 0; c < TENSOR; c++)
        sum += a_cell[c] * b_cell[c];
    for (size_t k = 0; k < 3 * (size_t)m->p.n; k++)
        sum += a[k] * b[k];
    return sum;
}

static void deform(minimum *m, const cell_strain *s) {
    strain(s, m->p.box, m->p.tilt);
    strain(s, m->carried.grow, m->carried.shear);
    for (size_t i = 0; i < (size_t)m->p.n; i++)
        carry(s, (const double[3]){m->p.x[3 * i], m->p.x[3 * i + 1], m->p.x[3 * i + 2]}, m->p.x + 3 * i);
}

/* x += t v, and the same of the cell. */
static void move(minimum *m, double t) {
    cell_strain s = {.grow = {1, 1, 1}};
    for (int a = 0; a < m->p.dim; a++)
        s.grow[a] = exp(t * m->v_cell[m->cell == GROWS ? 0 : a] / m->unit);
    for (int k = 0; k < 3; k++)
        s.shear[k] = t * m->v_cell[5 - k] / m->unit;
    for (size_t k = 0; k < 3 * (size_t)m->p.n; k++)
        m->p.x[k] += t * m->v[k];
    deform(m, &s);
}

/* v = (1 - turn) (v + dt f) + turn |v| f/|f|. */
static void push(minimum *m, double dt, double turn) {
    for (size_t k = 0; k < 3 * (size_t)m->p.n; k++)
        m->v[k] += dt * m->f[k];
    for (int c = 0; c < TENSOR; c++)
        m->v_cell[c] += dt * m->f_cell[c];
    const double force = sqrt(dot(m, m->f, m->f, m->f_cell, m->f_cell));
    const double speed = sqrt(dot(m, m->v, m->v, m->v_cell, m->v_cell));
    const double along = force > 0 ? turn * speed / force : 0;
    for (size_t k = 0; k < 3 * (size_t)m->p.n; k++)
        m->v[k] = (1 - turn) * m->v[k] + along * m->f[k];
    for (int c = 0; c < TENSOR; c++)
        m->v_cell[c] = (1 - turn) * m->v_cell[c] + along * m->f_cell[c];
}

static bool at_rest(const minimum *m) {
    const double p = m->cell == FIXED ? m->pressure : m->aim;
    double off = m->cell == GROWS ? fabs(m->pressure - p) : 0;
    for (int c = 0; c < TENSOR && m->cell == YIELDS; c++)
        off = fmax(off, m->free[c] ? fabs(m->stress[c] - m->aims[c]) : 0);
    if (m->residual > m->spec->tolerance || off >= PRESSURE_OFF * p || m->cell != m->wanted)
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

static sp_status come_apart(const minimum *m, sp_error *err) {
    if (m->strained != 0)
        return sp_fail_key(err, SP_EFAILED, "packing.path.strain",
                           ": at %.6g of it the packing has come apart: the pressure fell below %g E*", m->strained,
                           BARE);
    return sp_fail_key(err, SP_EFAILED, "packing.fraction",
                       " = %g: is too little for a rigid packing: the pressure fell below %g E*", m->spec->fraction,
                       BARE);
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
        if (m->cell == FIXED && m->residual <= ROUGH * m->pressure)
            m->cell = m->wanted;
        if (m->wanted == FIXED && m->pressure < BARE)
            return come_apart(m, err);
        if (at_rest(m))
            return SP_OK;
        const double longest = 0.7 / sqrt(fmax(2 * m->stiffest, 1e-12)); /* omega_max^2 <= 2 max sum k */
        dt = first ? 0.1 * longest : fmin(dt, longest);
        if (dot(m, m->f, m->v, m->f_cell, m->v_cell) > 0) {
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
            memset(m->v_cell, 0, sizeof m->v_cell);
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
        count += sqrt(separation(m, &m->pair[q], d)) < m->pair[q].reach;
    sp_status status = sp_packing_alloc(&p, m->p.dim, m->p.n, count, err);
    if (status != SP_OK)
        return status;
    memcpy(p.x, m->p.x, 3 * (size_t)p.n * sizeof *p.x);
    memcpy(p.r, m->p.r, (size_t)p.n * sizeof *p.r);
    memcpy(p.box, m->p.box, sizeof p.box);
    memcpy(p.tilt, m->p.tilt, sizeof p.tilt);
    sp_packing_untilt(p.dim, p.box, p.tilt);
    p.cell = SP_CELL_PERIODIC;
    p.pressure = m->pressure;
    p.poisson = m->spec->poisson;
    p.seed = m->spec->seed;
    p.steps = m->steps;
    p.residual = m->residual;
    count = 0;
    for (int64_t q = 0; q < m->pairs; q++) {
        const pair *c = &m->pair[q];
        const double r = sqrt(separation(m, c, d)), overlap = c->reach - r;
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

/* Sets what the cell does, and strains it by a step of the path. */
static void begin_stage(minimum *m, int32_t k) {
    const sp_pack_spec *s = m->spec;
    const bool path = k > s->history_count;
    const double to = sp_pack_stage_strain(s, k), step = to - m->strained;
    double e[TENSOR];
    cell_strain by = {.grow = {1, 1, 1}};
    m->aim = sp_pack_stage_pressure(s, k);
    sp_stress_target(s, m->aims);
    sp_path_strain(s, e);
    bool some = false;
    for (int c = 0; c < TENSOR; c++) {
        const bool exists = c < 3 ? c < s->dim : s->dim == 3 || c == 5;
        m->aims[c] *= m->aim / s->pressure;
        m->free[c] = exists && (path ? sp_path_frees(s, c) : s->stress_count > 0);
        some = some || m->free[c];
    }
    m->wanted = some ? YIELDS : path || s->fraction > 0 ? FIXED : GROWS;
    if (k > 0)
        m->cell = m->wanted;
    for (int a = 0; a < s->dim; a++)
        by.grow[a] = exp(-step * e[a]);
    for (int a = 0; a < 3; a++)
        by.shear[a] = -step * e[5 - a];
    m->strained = to;
    if (path)
        deform(m, &by);
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
    minimum m = {.spec = spec, .hooks = hooks, .p = sp_packing_none()};
    const int32_t stages = sp_pack_stages(spec);
    sp_status status = start(&m, err);
    for (int32_t k = 0; k < stages && status == SP_OK; k++) {
        begin_stage(&m, k);
        status = descend(&m, err);
        if (status == SP_OK && k < stages - 1)
            status = report_stage(&m, k, err);
    }
    if (status == SP_OK)
        status = finish(&m, out, err);
    sp_packing_free(&m.p);
    sp_free(m.pair);
    sp_free(m.memory);
    return status;
}
