/* Draws packings with errors of measurement. Every number is drawn whether it is used or not, so that the same sample
 * of two sizes of an error differs by the size alone. */
#include "inference/uncertain.h"

#include "base/base.h"
#include "base/vector.h"
#include "numeric/random.h"
#include "packing/contact.h"
#include "packing/geometry.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { FIRST_STREAM = 1 << 16 }; /* above the streams of numeric/random.h */

sp_errors sp_errors_default(void) { return (sp_errors){.gap = 0.01, .missing_force = 0.2}; }

sp_status sp_errors_check(const sp_errors *e, sp_error *err) {
    const struct {
        const char *key;
        double value, high;
    } each[] = {{"position", e->position, 1},
                {"radius", e->radius, 0.3},
                {"force", e->force, 2},
                {"stiffness", e->stiffness, 2},
                {"calibration", e->calibration, 2},
                {"false", e->false_part, 1},
                {"missing", e->missing, 1},
                {"gap", e->gap, 1},
                {"missing-force", e->missing_force, 10}};
    if (e->measured != SP_MEASURED_FORCES && e->measured != SP_MEASURED_OVERLAPS)
        return sp_fail_key(err, SP_EINVAL, "from", " = %d: must be forces or overlaps", (int)e->measured);
    for (size_t k = 0; k < sizeof each / sizeof *each; k++)
        if (!(each[k].value >= 0 && each[k].value <= each[k].high))
            return sp_fail_key(err, SP_EINVAL, each[k].key, " = %g: must be 0 .. %g", each[k].value, each[k].high);
    if (e->measured == SP_MEASURED_OVERLAPS && (e->force > 0 || e->missing > 0))
        return sp_fail_key(err, SP_EINVAL, e->force > 0 ? "force" : "missing",
                           ": forces and contacts follow from the overlaps; must be 0 with them");
    return SP_OK;
}

/* ---- pairs that may touch --------------------------------------------------------------------------------------- */

/* Vector from a grain to its partner, which may be a wall; its length is the distance of the centres, or to the wall.
 */
static double between(const sp_packing *p, int32_t i, int32_t j, double d[3]) {
    if (j >= 0) {
        sp_packing_separation(p, i, j, d);
        return length3(d);
    }
    const double distance = sp_packing_wall_distance(p, i, j);
    sp_packing_wall_normal(p, i, j, d);
    for (int a = 0; a < 3; a++)
        d[a] *= distance;
    return distance;
}

static double reach(const sp_packing *p, int32_t i, int32_t j) { return p->r[i] + (j < 0 ? 0 : p->r[j]); }

static sp_status add_near(sp_drawing *d, size_t *capacity, int32_t i, int32_t j, sp_error *err) {
    sp_near *more = sp_grow(d->candidate, (size_t)d->candidates + 1, capacity, sizeof *more);
    if (!more)
        return sp_fail_memory(err, *capacity * sizeof *more);
    d->candidate = more;
    d->candidate[d->candidates++] = (sp_near){i, j};
    return SP_OK;
}

typedef struct near_search {
    sp_drawing *d;
    size_t capacity;
} near_search;

static sp_status visit_near(int32_t i, int32_t j, void *user, sp_error *err) {
    near_search *s = user;
    double d[3];
    const sp_packing *p = s->d->p;
    if (between(p, i, j, d) - reach(p, i, j) > s->d->errors->gap || sp_packing_has_contact(p, i, j))
        return SP_OK;
    return add_near(s->d, &s->capacity, i, j, err);
}

static double mean_force(const sp_packing *p) {
    double sum = 0;
    int32_t carrying = 0;
    for (int32_t c = 0; c < p->n_contacts; c++)
        if (p->contacts[c].fn > 0) {
            sum += p->contacts[c].fn;
            carrying++;
        }
    return carrying > 0 ? sum / carrying : 0;
}

static int by_pair(const void *a, const void *b) {
    const sp_near *x = a, *y = b;
    if (x->i != y->i)
        return x->i < y->i ? -1 : 1;
    return x->j < y->j ? -1 : x->j > y->j;
}

/* In a low periodic cell the sweep meets a pair from both sides. */
static void drop_repeated_candidates(sp_drawing *d) {
    int32_t kept = 0;
    if (d->candidates > 0)
        qsort(d->candidate, (size_t)d->candidates, sizeof *d->candidate, by_pair);
    for (int32_t k = 0; k < d->candidates; k++)
        if (kept == 0 || by_pair(&d->candidate[kept - 1], &d->candidate[k]) != 0)
            d->candidate[kept++] = d->candidate[k];
    d->candidates = kept;
}

static void drop_repeated_contacts(sp_packing *q) {
    int32_t kept = 0;
    for (int32_t k = 0; k < q->n_contacts; k++) {
        const sp_contact *last = kept > 0 ? &q->contacts[kept - 1] : NULL;
        if (!last || last->i != q->contacts[k].i || last->j != q->contacts[k].j)
            q->contacts[kept++] = q->contacts[k];
    }
    q->n_contacts = kept;
}

sp_status sp_drawing_make(const sp_packing *p, const sp_errors *errors, sp_drawing *out, sp_error *err) {
    sp_drawing d = {.p = p, .errors = errors, .mean_force = mean_force(p)};
    near_search search = {.d = &d};
    sp_status status = sp_errors_check(errors, err);
    if (status == SP_OK && errors->missing > 0)
        status = sp_packing_sweep(p, errors->gap, visit_near, &search, err);
    drop_repeated_candidates(&d);
    if (status == SP_OK)
        *out = d;
    else
        sp_drawing_free(&d);
    return status;
}

void sp_drawing_free(sp_drawing *d) {
    sp_free(d->candidate);
    d->candidate = NULL;
    d->candidates = 0;
}

/* ---- one draw --------------------------------------------------------------------------------------------------- */

/* A factor of median 1, or of mean 1, whose logarithm has this standard deviation. */
static double factor(const sp_errors *e, sp_random *r, double sd, bool exact) {
    const double z = sp_random_normal(r);
    return exact ? 1 : exp(sd * (z - (e->mean_one ? 0.5 * sd : 0)));
}

sp_status sp_drawing_copy(const sp_packing *p, int32_t room, sp_packing *out, sp_error *err) {
    const size_t n = (size_t)p->n;
    sp_packing q = sp_packing_none();
    sp_status status = sp_packing_alloc(&q, p->dim, p->n, room, err);
    if (status == SP_OK && p->mass)
        status = sp_packing_alloc_masses(&q, err);
    if (status == SP_OK && p->species)
        status = sp_packing_alloc_species(&q, err);
    if (status != SP_OK) {
        sp_packing_free(&q);
        return status;
    }
    *out = *p;
    out->x = memcpy(q.x, p->x, 3 * n * sizeof *q.x);
    out->r = memcpy(q.r, p->r, n * sizeof *q.r);
    out->mass = p->mass ? memcpy(q.mass, p->mass, n * sizeof *q.mass) : NULL;
    out->inertia = p->mass ? memcpy(q.inertia, p->inertia, n * sizeof *q.inertia) : NULL;
    out->species = p->species ? memcpy(q.species, p->species, n * sizeof *q.species) : NULL;
    out->contacts = q.contacts;
    out->n_contacts = 0;
    out->scene = NULL;
    return SP_OK;
}

/* Radii stay above a tenth of their measured value: the normal distribution knows no such limit. */
static void move_grains(const sp_errors *e, bool exact, sp_random *r, sp_packing *q) {
    for (int32_t i = 0; i < q->n; i++) {
        for (int a = 0; a < q->dim; a++) {
            const double z = sp_random_normal(r);
            q->x[3 * (size_t)i + (size_t)a] += exact ? 0 : e->position * z;
        }
        const double z = sp_random_normal(r);
        q->r[i] = exact ? q->r[i] : fmax(q->r[i] + e->radius * z, 0.1 * q->r[i]);
    }
}

/* The contact of a pair at these positions: normal and overlap. A grain that an error has put behind a wall stays on
 * its inner side. */
static sp_contact at_positions(const sp_packing *q, int32_t i, int32_t j) {
    sp_contact c = {.i = i, .j = j};
    double d[3];
    const double length = between(q, i, j, d);
    c.overlap = reach(q, i, j) - length;
    if (j < 0)
        sp_packing_wall_normal(q, i, j, c.n);
    else
        for (int a = 0; a < 3; a++)
            c.n[a] = length > 0 ? d[a] / length : 0;
    return c;
}

/* A stiffness of its own: the factor times that of the law, or times the one that it has. */
static void multiply_stiffness(const sp_packing *q, sp_contact *c, double times) {
    if (times == 1)
        return;
    const bool own = c->kn > 0;
    const double kn = contact_kn(q, c);
    c->kn = times * kn;
    c->kt = times * (own ? c->kt : contact_eta(q->poisson) * kn);
}

/* The tangential force turns with the normal. */
static void carry_tangential(const sp_contact *from, double scale, sp_contact *c) {
    const double off = dot3(from->ft, c->n);
    for (int a = 0; a < 3; a++)
        c->ft[a] = scale * (from->ft[a] - off * c->n[a]);
}

/* A contact of a measured packing p need not lie where its positions say: pictures do not resolve overlaps, and the
 * force on a wall that a balance needs may be oblique. What the errors change is added to what was measured. */
static sp_contact moved(const sp_packing *p, const sp_packing *q, const sp_contact *from) {
    const sp_contact was = at_positions(p, from->i, from->j);
    sp_contact c = at_positions(q, from->i, from->j);
    c.overlap += from->overlap - was.overlap;
    for (int a = 0; a < 3; a++)
        c.n[a] += from->n[a] - was.n[a];
    const double length = length3(c.n);
    for (int a = 0; a < 3 && length > 0; a++)
        c.n[a] /= length;
    return c;
}

/* The contact c by the force of `from`; the stiffness is its own, as the force has it. */
static void add_by_force(sp_contact c, const sp_contact *from, double force_factor, double times, sp_packing *q) {
    c.kn = from->kn;
    c.kt = from->kt;
    c.fn = force_factor * from->fn;
    if (!(from->kn > 0)) {
        const double e = contact_stiffness_in(q, c.i, c.j);
        c.kn = contact_normal_stiffness(e, contact_overlap(e, c.fn));
        c.kt = contact_eta(q->poisson) * c.kn;
    }
    c.kn *= times;
    c.kt *= times;
    carry_tangential(from, force_factor, &c);
    q->contacts[q->n_contacts++] = c;
}

static void draw_by_forces(const sp_drawing *d, bool exact, double common, sp_random *r, sp_packing *q) {
    const sp_errors *e = d->errors;
    for (int32_t k = 0; k < d->p->n_contacts; k++) {
        const double force = factor(e, r, e->force, exact), times = factor(e, r, e->stiffness, exact);
        if (sp_random_uniform(r) >= e->false_part || exact)
            add_by_force(moved(d->p, q, &d->p->contacts[k]), &d->p->contacts[k], force, common * times, q);
    }
    for (int32_t k = 0; k < d->candidates; k++) {
        const bool carries = sp_random_uniform(r) < e->missing && !exact;
        sp_contact missed = {.i = d->candidate[k].i, .j = d->candidate[k].j};
        missed.fn = e->missing_force * d->mean_force * sp_random_uniform(r);
        if (carries && missed.fn > 0)
            add_by_force(at_positions(q, missed.i, missed.j), &missed, 1, common, q);
    }
}

/* Pairs that overlap at the drawn positions; stiffnesses of their own stay with the pairs that had one. */
typedef struct overlap_search {
    const sp_drawing *d;
    sp_packing *q;
    size_t capacity;
    bool exact;
    double common;
    uint64_t seed;
    uint64_t stream;
} overlap_search;

static const sp_contact *listed(const sp_packing *p, int32_t i, int32_t j) {
    for (int32_t low = 0, high = p->n_contacts; low < high;) {
        const int32_t k = low + (high - low) / 2;
        const sp_contact *c = &p->contacts[k];
        if (c->i == i && c->j == j)
            return c;
        const bool wall = c->j < 0, other = j < 0; /* pairs first, then each wall, by grains */
        const bool before = wall != other ? other
                            : wall        ? c->j > j || (c->j == j && c->i < i)
                                          : c->i < i || (c->i == i && c->j < j);
        if (before)
            low = k + 1;
        else
            high = k;
    }
    return NULL;
}

/* The numbers of a pair depend on the pair alone, as the number of pairs that overlap varies. */
static sp_random stream_of_pair(const overlap_search *s, int32_t i, int32_t j) {
    sp_random r = sp_random_make(s->seed, s->stream);
    r.count = ((uint64_t)1 << 62) + ((uint64_t)i * ((uint64_t)s->q->n + 8) + (uint64_t)(j + 8)) * 8;
    return r;
}

static sp_status visit_overlap(int32_t i, int32_t j, void *user, sp_error *err) {
    overlap_search *s = user;
    sp_packing *q = s->q;
    sp_contact c = at_positions(q, i, j);
    if (!(c.overlap > 0))
        return SP_OK;
    sp_random r = stream_of_pair(s, i, j);
    const double times = factor(s->d->errors, &r, s->d->errors->stiffness, s->exact);
    if (sp_random_uniform(&r) < s->d->errors->false_part && !s->exact)
        return SP_OK;
    sp_contact *more = sp_grow(q->contacts, (size_t)q->n_contacts + 1, &s->capacity, sizeof *more);
    if (!more)
        return sp_fail_memory(err, s->capacity * sizeof *more);
    q->contacts = more;
    const sp_contact *was = listed(s->d->p, i, j);
    c.kn = was ? was->kn : 0;
    c.kt = was ? was->kt : 0;
    c.fn = c.kn > 0 ? c.kn * c.overlap : contact_force(contact_stiffness_in(q, i, j), c.overlap);
    if (was)
        carry_tangential(was, was->fn > 0 ? c.fn / was->fn : 0, &c);
    multiply_stiffness(q, &c, s->common * times);
    q->contacts[q->n_contacts++] = c;
    return SP_OK;
}

sp_status sp_drawing_draw(const sp_drawing *d, uint64_t seed, int64_t sample, sp_packing *out, sp_error *err) {
    const bool exact = sample < 0, overlaps = d->errors->measured == SP_MEASURED_OVERLAPS;
    const uint64_t stream = FIRST_STREAM + (exact ? 0 : (uint64_t)sample);
    sp_random r = sp_random_make(seed, stream);
    const int32_t room = d->p->n_contacts + d->candidates;
    sp_packing q = sp_packing_none();
    sp_status status = sp_drawing_copy(d->p, room, &q, err);
    if (status != SP_OK)
        return status;
    const double common = factor(d->errors, &r, d->errors->calibration, exact);
    move_grains(d->errors, exact, &r, &q);
    if (overlaps) {
        overlap_search search = {d, &q, (size_t)room > 0 ? (size_t)room : 1, exact, common, seed, stream};
        status = sp_packing_sweep(&q, 0, visit_overlap, &search, err);
    } else {
        draw_by_forces(d, exact, common, &r, &q);
    }
    sp_packing_sort(&q);
    drop_repeated_contacts(&q);
    if (status == SP_OK)
        *out = q;
    else
        sp_packing_free(&q);
    return status;
}

sp_status sp_packing_perturb(const sp_packing *p, const sp_errors *errors, uint64_t seed, int64_t sample,
                             sp_packing *out, sp_error *err) {
    sp_drawing d;
    sp_status status = sp_drawing_make(p, errors, &d, err);
    if (status != SP_OK)
        return status;
    status = sp_drawing_draw(&d, seed, sample, out, err);
    sp_drawing_free(&d);
    return status;
}
