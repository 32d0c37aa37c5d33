/* The state of a compression as bytes, so that an interrupted run can be resumed with an identical result.
 *
 * The order of pairs in the neighbour lists determines the order of summation, and so the bits. Therefore the lists are
 * rebuilt from the positions wherever a state may be saved, even if none is. */
#include "base/base.h"
#include "packing/compression.h"
#include "packing/dynamics.h"
#include "packing/prepare.h"

#include <math.h>
#include <sonopack/version.h>
#include <string.h>

static const char magic[8] = {'S', 'N', 'P', 'K', 'S', 'T', 'A', 'T'};
enum { STATE_VERSION = 3, BYTE_ORDER_MARK = 0x01020304 };

/* ---- hashes -------------------------------------------------------------------------------------------------- */

static uint64_t add_number(uint64_t hash, double value) { return sp_hash64_words(hash, &value, sizeof value); }

static uint64_t add_integer(uint64_t hash, uint64_t value) { return sp_hash64_words(hash, &value, sizeof value); }

uint64_t sp_packing_hash(const sp_packing *p) {
    uint64_t hash = add_integer(SP_HASH64_BEGIN, (uint64_t)p->dim);
    hash = add_integer(hash, (uint64_t)p->n);
    hash = add_integer(hash, (uint64_t)p->n_contacts);
    for (int a = 0; a < 3; a++)
        hash = add_number(hash, p->box[a]);
    hash = add_number(hash, p->pressure);
    if (p->cell != SP_CELL_PISTON)
        hash = sp_hash64_words(add_integer(hash, (uint64_t)p->cell), p->tilt, sizeof p->tilt);
    if (p->gravity != 0)
        hash = add_number(hash, p->gravity);
    hash = sp_hash64_words(hash, p->x, 3 * (size_t)p->n * sizeof *p->x);
    hash = sp_hash64_words(hash, p->r, (size_t)p->n * sizeof *p->r);
    for (int32_t c = 0; c < p->n_contacts; c++) {
        const sp_contact *k = &p->contacts[c];
        hash = add_integer(hash, (uint64_t)k->i << 32 | (uint32_t)k->j);
        for (int a = 0; a < 3; a++)
            hash = add_number(hash, k->ft[a] + 0.0);
        if (k->kn > 0)
            hash = add_number(add_number(hash, k->kn), k->kt);
        if (k->mu > 0)
            hash = add_number(hash, k->mu);
    }
    if (p->mass) {
        hash = sp_hash64_words(hash, p->mass, (size_t)p->n * sizeof *p->mass);
        hash = sp_hash64_words(hash, p->inertia, (size_t)p->n * sizeof *p->inertia);
    }
    hash &= INT64_MAX;
    return hash ? hash : 1;
}

static uint64_t add_list(uint64_t hash, const sp_key *key, const sp_pack_spec *s) {
    const double *values;
    int32_t count;
    memcpy(&values, (const char *)s + key->offset, sizeof values);
    memcpy(&count, (const char *)s + key->count, sizeof count);
    hash = add_integer(hash, (uint64_t)count);
    return sp_hash64_words(hash, values, (size_t)count * sizeof *values);
}

/* A state without history belongs to the spec it always belonged to. */
static bool left_out(const sp_key *key, const sp_pack_spec *s) {
    return key->offset == offsetof(sp_pack_spec, tangential) && s->tangential == SP_TANGENTIAL_CONSTANT;
}

/* Hash of everything that determines the packing: all keys of the table, first integers and words, then real numbers,
 * then lists. s is resolved. */
static uint64_t spec_hash(const sp_pack_spec *s) {
    uint64_t hash = sp_hash64_words(SP_HASH64_BEGIN, SONOPACK_VERSION, sizeof SONOPACK_VERSION);
    hash = add_integer(hash, (uint64_t)SONOPACK_ALGORITHM);
    for (const sp_key *key = sp_pack_keys; key->name; key++)
        if (key->type != SP_KEY_REAL && key->type != SP_KEY_REALS && !left_out(key, s))
            hash = add_integer(hash, sp_key_integer(key, s));
    for (const sp_key *key = sp_pack_keys; key->name; key++)
        if (key->type == SP_KEY_REAL)
            hash = add_number(hash, sp_key_value(key, s) + 0.0);
    for (const sp_key *key = sp_pack_keys; key->name; key++)
        if (key->type == SP_KEY_REALS)
            hash = add_list(hash, key, s);
    return hash;
}

/* ---- what goes in and out ------------------------------------------------------------------------------------ */

/* Counts, writes or reads bytes. All three visit the fields in the same order. */
typedef struct stream {
    unsigned char *to;         /* destination, or NULL */
    const unsigned char *from; /* source, or NULL */
    size_t at, size;           /* size: limit for reading */
    bool short_of;             /* an attempt to read beyond size */
} stream;

static void visit(stream *s, void *data, size_t size) {
    if (s->from && (s->short_of || size > s->size - s->at)) {
        s->short_of = true;
        return;
    }
    if (s->from)
        memcpy(data, s->from + s->at, size);
    else if (s->to)
        memcpy(s->to + s->at, data, size);
    s->at += size;
}

typedef struct header {
    char magic[8];
    uint32_t version, order;
    uint64_t spec, size; /* size: of the whole state, including the checksum at its end */
    int64_t steps;
} header;

static void visit_run(stream *s, compression *run) {
    dynamics *d = &run->d;
    double *const numbers[] = {&run->start_height,
                               &run->start_period[0],
                               &run->start_period[1],
                               &run->period_end[0],
                               &run->period_end[1],
                               &run->ramp_time,
                               &run->past,
                               &run->residual,
                               &run->wall_imbalance,
                               &run->lateral_imbalance,
                               &run->first_acceleration,
                               &run->first_residual,
                               &run->full_drag,
                               &run->ease,
                               &run->stall_residual,
                               &run->fraction,
                               &d->period[0],
                               &d->period[1],
                               &d->strain_rate[0],
                               &d->strain_rate[1],
                               &d->area,
                               &d->pressure,
                               &d->law.viscous_limit,
                               &d->law.damping,
                               &d->piston_y,
                               &d->piston_v,
                               &d->wall_force[0],
                               &d->wall_force[1],
                               &d->v_max,
                               &d->rate,
                               &d->k_max,
                               &d->piston_k,
                               &d->drag,
                               &d->dt};
    int32_t phase = (int32_t)run->phase, rest_checks = run->rest_checks;
    for (size_t k = 0; k < sizeof numbers / sizeof *numbers; k++)
        visit(s, numbers[k], sizeof **numbers);
    if (run->whole->cell != SP_CELL_PISTON) {
        visit(s, d->tilt, sizeof d->tilt);
        visit(s, d->strain_rate, sizeof d->strain_rate);
        visit(s, d->shear_rate, sizeof d->shear_rate);
        visit(s, &run->flow, sizeof run->flow);
        visit(s, &run->flow_rate, sizeof run->flow_rate);
        visit(s, &run->strained, sizeof run->strained);
    }
    visit(s, &run->steps, sizeof run->steps);
    visit(s, &run->stall_step, sizeof run->stall_step);
    visit(s, &run->stage, sizeof run->stage);
    visit(s, &d->sparing, sizeof d->sparing);
    visit(s, &d->lag, sizeof d->lag);
    visit(s, &run->lateral_free, sizeof run->lateral_free);
    visit(s, &phase, sizeof phase);
    visit(s, &rest_checks, sizeof rest_checks);
    run->phase = phase >= PHASE_FLIGHT && phase <= PHASE_EQUILIBRATION ? (compression_phase)phase : PHASE_FLIGHT;
    run->rest_checks = rest_checks;
}

/* Writes the pairs with a tangential force; all others are recomputed. */
static void write_pairs(stream *s, const dynamics *d) {
    const pair_list *p = &d->outer;
    const int kept = dynamics_kept(d);
    const size_t place = s->at;
    int32_t count = 0;
    visit(s, &count, sizeof count);
    for (int32_t k = 0; k < p->n; k++) {
        bool stretched = false;
        for (int a = 0; a < kept; a++)
            stretched = stretched || p->ft[k + (int64_t)a * p->capacity] != 0;
        if (!stretched)
            continue;
        count++;
        visit(s, &p->i[k], sizeof *p->i);
        visit(s, &p->j[k], sizeof *p->j);
        for (int a = 0; a < kept; a++)
            visit(s, &p->ft[k + (int64_t)a * p->capacity], sizeof *p->ft);
    }
    if (s->to)
        memcpy(s->to + place, &count, sizeof count);
}

static void visit_walls(stream *s, dynamics *d) {
    for (int side = 0; side < d->walls; side++)
        visit(s, d->wall_ft[side], (size_t)d->n * (size_t)(d->dim - 1) * sizeof(double));
    for (int side = 0; side < d->walls && d->at.averaged > 0; side++)
        visit(s, d->wall_u[side], (size_t)d->n * (size_t)d->dim * sizeof(double));
    for (int side = 0; side < d->walls && d->at.past > 0; side++)
        visit(s, d->wall_past[side], (size_t)d->n * (size_t)d->at.past * sizeof(double));
}

static size_t write_all(compression *run, unsigned char *to, size_t size) {
    stream s = {.to = to};
    dynamics *d = &run->d;
    header h = {.version = STATE_VERSION, .order = BYTE_ORDER_MARK, .size = size, .steps = run->steps};
    memcpy(h.magic, magic, sizeof magic);
    h.spec = spec_hash(run->whole);
    visit(&s, &h, sizeof h);
    visit_run(&s, run);
    visit(&s, run->id, (size_t)d->n * sizeof *run->id);
    visit(&s, d->g, (size_t)d->n * (size_t)d->at.stride * sizeof *d->g);
    visit_walls(&s, d);
    write_pairs(&s, d);
    uint64_t sum = to ? sp_hash64_words(SP_HASH64_BEGIN, to, s.at) : 0;
    visit(&s, &sum, sizeof sum);
    return s.at;
}

sp_status sp_state_save(compression *run, sp_error *err) {
    sp_pairs_store_forces(&run->d);
    const size_t size = write_all(run, NULL, 0);
    unsigned char *bytes = sp_alloc(size, 1);
    if (!bytes)
        return sp_fail_memory(err, size);
    write_all(run, bytes, size);
    sp_status status = run->hooks->save(bytes, size, run->hooks->user, err);
    sp_free(bytes);
    return status;
}

/* ---- reading ------------------------------------------------------------------------------------------------- */

static sp_status damaged(sp_error *err, const char *what) {
    return sp_fail(err, SP_EFORMAT, "the state is damaged: %s", what);
}

bool sp_pack_is_state(const void *state, size_t size) {
    return size >= sizeof magic && memcmp(state, magic, sizeof magic) == 0;
}

static sp_status check_header(const sp_pack_spec *spec, const void *state, size_t size, header *out, sp_error *err) {
    header h;
    uint64_t sum;
    if (!sp_pack_is_state(state, size) || size < sizeof h + sizeof sum)
        return sp_fail(err, SP_EFORMAT, "this is not a saved state of a compression");
    memcpy(&h, state, sizeof h);
    if (h.version != STATE_VERSION || h.order != BYTE_ORDER_MARK)
        return sp_fail(err, SP_EFORMAT, "the state was written by another version or another kind of machine");
    if (h.size != size)
        return damaged(err, "its length is wrong");
    memcpy(&sum, (const unsigned char *)state + size - sizeof sum, sizeof sum);
    if (sum != sp_hash64_words(SP_HASH64_BEGIN, state, size - sizeof sum))
        return damaged(err, "its checksum is wrong");
    if (h.steps < 0)
        return damaged(err, "its numbers are impossible");
    if (h.spec != spec_hash(spec))
        return sp_fail(err, SP_EFORMAT, "the state belongs to another packing or another version");
    *out = h;
    return SP_OK;
}

sp_status sp_pack_state_check(const sp_pack_spec *spec, const void *state, size_t size, int64_t *steps, sp_error *err) {
    header h;
    const sp_pack_spec resolved = sp_pack_spec_resolve(spec);
    sp_status status = check_header(&resolved, state, size, &h, err);
    if (status == SP_OK && steps)
        *steps = h.steps;
    return status;
}

/* Reads the order and data of the grains, and creates the dynamics. */
static sp_status read_grains(stream *s, compression *run, sp_error *err) {
    const sp_pack_spec *spec = run->whole;
    const grain_layout at = grain_layout_of(spec->dim);
    const size_t n = (size_t)spec->grains, stride = (size_t)at.stride, r_at = (size_t)at.r;
    double *g = sp_alloc(n * stride, sizeof *g), *r = sp_alloc(n, sizeof *r), *x = sp_alloc(3 * n, sizeof *x);
    uint8_t *seen = sp_alloc(n, 1);
    run->id = sp_alloc(n, sizeof *run->id);
    sp_status status = g && r && x && seen && run->id ? SP_OK : sp_fail_memory(err, n * 8 * (stride + 5));
    if (status != SP_OK)
        goto out;
    visit(s, run->id, n * sizeof *run->id);
    visit(s, g, n * stride * sizeof *g);
    for (size_t i = 0; i < n && !s->short_of && status == SP_OK; i++) {
        const int32_t id = run->id[i];
        bool good = id >= 0 && id < spec->grains && !seen[id];
        for (size_t k = 0; k < stride; k++)
            good = good && isfinite(g[stride * i + k]);
        const double type = g[stride * i + (size_t)at.type];
        good = good && g[stride * i + r_at] > 0 && type >= 0 && type < sp_types_count(spec) && type == floor(type);
        if (good)
            seen[id] = 1;
        else
            status = damaged(err, "a grain is invalid");
        r[i] = g[stride * i + r_at];
    }
    if (status == SP_OK && s->short_of)
        status = damaged(err, "grains are missing");
    if (status != SP_OK)
        goto out;
    sp_pack_spec start = *spec;
    start.width = run->start_period[0];
    start.depth = run->start_period[1];
    status = sp_dynamics_make(&start, r, x, run->start_height, &run->d, err);
    if (status != SP_OK)
        goto out;
    memcpy(run->d.g, g, n * stride * sizeof *g);
    sp_dynamics_set_types(&run->d, spec, NULL);
out:
    sp_free(seen);
    sp_free(x);
    sp_free(r);
    sp_free(g);
    return status;
}

static sp_status read_pairs(stream *s, dynamics *d, sp_error *err) {
    int32_t count = 0;
    const int kept = dynamics_kept(d);
    visit(s, &count, sizeof count);
    const size_t one = 2 * sizeof(int32_t) + (size_t)kept * sizeof(double);
    if (s->short_of || count < 0 || (size_t)count > (s->size - s->at) / one)
        return damaged(err, "contacts are missing");
    pair_force *force = sp_alloc((size_t)count, sizeof *force);
    if (!force)
        return sp_fail_memory(err, (size_t)count * sizeof *force);
    bool good = true;
    for (int32_t k = 0; k < count; k++) {
        pair_force *f = &force[k];
        visit(s, &f->i, sizeof f->i);
        visit(s, &f->j, sizeof f->j);
        good = good && f->i >= 0 && f->i < d->n && f->j >= 0 && f->j < d->n && f->i != f->j;
        for (int a = 0; a < kept; a++) {
            visit(s, &f->ft[a], sizeof f->ft[a]);
            good = good && isfinite(f->ft[a]);
        }
    }
    sp_status status = good ? sp_pairs_set_forces(d, force, count, err) : damaged(err, "a contact is invalid");
    sp_free(force);
    return status;
}

/* Whether lengths and counts are possible. */
static bool sane(const compression *run) {
    const dynamics *d = &run->d;
    const double lengths[] = {run->start_height, run->start_period[0], d->period[0], d->area,
                              d->pressure,       d->piston_y,          d->dt};
    bool good = run->steps >= 0 && run->stage >= 0 && run->stage < sp_pack_stages(run->whole);
    for (size_t k = 0; k < sizeof lengths / sizeof *lengths; k++)
        good = good && isfinite(lengths[k]) && lengths[k] > 0;
    return good && (run->whole->dim == 2 || (run->start_period[1] > 0 && d->period[1] > 0 && isfinite(d->period[1])));
}

sp_status sp_state_load(compression *run, sp_error *err) {
    header h;
    sp_status status = check_header(run->whole, run->hooks->state, run->hooks->state_size, &h, err);
    if (status != SP_OK)
        return status;
    stream s = {.from = run->hooks->state, .at = sizeof h, .size = run->hooks->state_size - sizeof(uint64_t)};
    visit_run(&s, run);
    if (s.short_of || !sane(run))
        return damaged(err, "its numbers are impossible");
    status = read_grains(&s, run, err);
    if (status != SP_OK)
        return status;
    visit_run(&(stream){.from = s.from, .at = sizeof h, .size = s.size}, run); /* again, as the dynamics exist now */
    visit_walls(&s, &run->d);
    status = read_pairs(&s, &run->d, err);
    if (status == SP_OK && s.at != s.size)
        status = damaged(err, "there are bytes after its end");
    sp_compression_set_stage(run);
    run->resumed = true;
    return status;
}
