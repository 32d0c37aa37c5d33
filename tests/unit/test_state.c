/* The state of a compression as bytes: a making that ends at any time goes on to the same packing, bit for bit. */
#include "test.h"

#include "base/base.h"
#include "packing/prepare.h"

/* Every state that a making saves; it is stopped after the one with this number. */
typedef struct album {
    int count, stop_after; /* stop_after < 0: never */
    unsigned char *state;  /* the last one */
    size_t size;
    int stages;
} album;

static sp_status keep(const void *state, size_t size, void *user, sp_error *err) {
    album *a = user;
    sp_free(a->state);
    a->state = sp_alloc(size, 1);
    assert_non_null(a->state);
    memcpy(a->state, state, size);
    a->size = size;
    return a->count++ == a->stop_after ? sp_fail(err, SP_EINTERRUPTED, "stopped") : SP_OK;
}

static sp_status count_stage(const sp_packing *p, int32_t index, void *user, sp_error *err) {
    album *a = user;
    (void)p;
    (void)err;
    a->stages |= 1 << index;
    return SP_OK;
}

static void assert_same(const sp_packing *p, const sp_packing *q) {
    assert_int_equal(p->n_contacts, q->n_contacts);
    assert_true(sp_packing_hash(p) == sp_packing_hash(q));
    assert_true(p->steps == q->steps && memcmp(&p->residual, &q->residual, sizeof p->residual) == 0);
    assert_memory_equal(p->x, q->x, 3 * (size_t)p->n * sizeof *p->x);
    assert_memory_equal(p->r, q->r, (size_t)p->n * sizeof *p->r);
    assert_memory_equal(p->box, q->box, sizeof p->box);
    assert_memory_equal(p->contacts, q->contacts, (size_t)p->n_contacts * sizeof *p->contacts);
}

/* Stopped at several states, and resumed from there: once, and stopped again and again. */
static void assert_resumes(const char *name, const sp_pack_spec *spec, const sp_packing *from) {
    album all = {.stop_after = -1}, part = {.stop_after = 0};
    FREED(sp_packing) whole = sp_packing_none(), p = sp_packing_none(), plain = sp_packing_none();
    sp_pack_hooks hooks = {.from = from, .user = &all, .stage = count_stage};
    hooks.save = keep;
    assert_ok(sp_packing_make_with(spec, &hooks, &whole, &err));
    print_message("%s: %lld steps, %d states, the last of %zu bytes\n", name, (long long)whole.steps, all.count,
                  all.size);
    assert_true(all.count >= 1);
    if (spec->dim == 3 || spec->history_count > 0) { /* whether states are saved changes nothing */
        hooks.save = NULL;
        assert_ok(sp_packing_make_with(spec, &hooks, &plain, &err));
        assert_same(&whole, &plain);
        hooks.save = keep;
    }
    hooks.user = &part;
    int starts = 0;
    sp_status status = SP_EINTERRUPTED;
    while (status == SP_EINTERRUPTED) {
        sp_error err = {0};
        unsigned char *state = part.state;
        hooks.state = state;
        hooks.state_size = part.size;
        hooks.threads = 1 + starts % 3;
        part.state = NULL;
        part.count = 0;
        status = sp_packing_make_with(spec, &hooks, &p, &err);
        if (status != SP_OK && status != SP_EINTERRUPTED)
            fail_msg("%s: %s", name, err.text);
        sp_free(state);
        starts++;
    }
    assert_int_equal(starts, all.count + 1);
    assert_int_equal(part.stages, all.stages);
    assert_same(&whole, &p);
    sp_free(all.state);
}

static sp_pack_spec small(int dim) {
    sp_pack_spec s = sp_pack_spec_default();
    s.dim = dim;
    s.grains = dim == 2 ? 30 : 40;
    s.width = 5;
    s.pressure = 1e-5;
    s.tolerance = 1e-8;
    s.seed = 11;
    return s;
}

TEST(every_start_goes_on) {
    static const double history[] = {1e-5, 3e-4};
    for (int dim = 2; dim <= 3; dim += SANITIZED_STEP(2)) {
        sp_pack_spec s = small(dim);
        assert_resumes("gas", &s, NULL);
        sp_pack_spec slow = s; /* so slow that states are saved during the homogeneous strain as well */
        slow.protocol = SP_PROTOCOL_AFFINE;
        slow.pressure = 1e-8;
        slow.tolerance = 1e-11;
        assert_resumes("affine", &slow, NULL);
        s.compression = SP_COMPRESSION_ISOTROPIC;
        assert_resumes("isotropic", &s, NULL);
        s.compression = SP_COMPRESSION_PISTON;
        s.history = history;
        s.history_count = dim == 2 ? 2 : 0;
        if (dim == 2)
            assert_resumes("history", &s, NULL);
        s.history_count = 0;
        FREED(sp_packing) from = sp_packing_none();
        assert_ok(sp_packing_make(&s, NULL, NULL, &from, &err));
        sp_pack_spec f = sp_pack_spec_default();
        f.kind = SP_PACK_FILE;
        f.history = history;
        f.history_count = dim == 2 ? 2 : 1;
        f.tolerance = 1e-9;
        assert_resumes("file", &f, &from);
    }
    for (int k = 0; k < 4; k += SANITIZED_STEP(3)) { /* periodic and box, with a stress too */
        static const double stress[] = {1e-5, 1.1e-5, 1e-6};
        sp_pack_spec s = small(2 + k % 2);
        s.cell = k < 2 ? SP_CELL_PERIODIC : SP_CELL_BOX;
        s.grains = k % 2 ? 150 : 60;
        s.width = sp_pack_spec_default().width;
        s.pressure = k == 0 ? sp_pack_spec_default().pressure : 1e-5;
        s.stress = k == 0 ? stress : NULL;
        s.stress_count = k == 0 ? 3 : 0;
        assert_resumes(k < 2 ? "periodic" : "box", &s, NULL);
    }
    for (int k = 0; k < 2; k += SANITIZED_STEP(2)) { /* states on the path and between its steps */
        static const double strain[] = {0, 0.004, 0, 0, 0, 0.001}, turns[] = {1, 0.5};
        sp_pack_spec s = small(2 + k);
        s.cell = SP_CELL_PERIODIC;
        s.grains = k ? 150 : 60;
        s.width = sp_pack_spec_default().width;
        s.strain = strain;
        s.strain_count = k ? 6 : 3;
        s.turns = turns;
        s.turn_count = 2;
        s.strain_steps = 2;
        s.lateral = k ? SP_LATERAL_STRESS : SP_LATERAL_FIXED;
        assert_resumes("path", &s, NULL);
    }
    sp_pack_spec s = small(2);
    s.reference = true;
    s.grains = 30;
    s.tolerance = 1e-7;
    assert_resumes("reference", &s, NULL);
    s = small(2);
    s.kind = SP_PACK_TRIANGULAR;
    s.diameter_min = 0.99;
    s.diameter_max = 1.01;
    s.pressure = 1e-6;
    s.tolerance = 1e-9;
    assert_resumes("lattice", &s, NULL);
}

TEST(what_is_no_state) {
    sp_pack_spec s = small(2), other = small(2);
    album a = {.stop_after = 0};
    sp_packing p = sp_packing_none();
    sp_pack_hooks hooks = {.save = keep, .user = &a};
    int64_t steps = 0;
    assert_fails(sp_packing_make_with(&s, &hooks, &p, &err), SP_EINTERRUPTED, "");
    assert_ok(sp_pack_state_check(&s, a.state, a.size, &steps, &err));
    assert_true(steps > 0);
    other.seed++;
    assert_fails(sp_pack_state_check(&other, a.state, a.size, &steps, &err), SP_EFORMAT, "");
    assert_fails(sp_pack_state_check(&s, a.state, a.size - 1, &steps, &err), SP_EFORMAT, "");
    assert_fails(sp_pack_state_check(&s, a.state, 3, &steps, &err), SP_EFORMAT, "");
    assert_fails(sp_pack_state_check(&s, "sonopack sonopack sonopack sonopack sonopack sonopack", 52, &steps, &err),
                 SP_EFORMAT, "");
    hooks.state = a.state;
    hooks.state_size = a.size;
    hooks.save = NULL;
    other = s;
    other.kind = SP_PACK_CHAIN;
    other.dim = 1;
    assert_fails(sp_packing_make_with(&other, &hooks, &p, &err), SP_EFORMAT, "");
    srand(4);
    for (int k = 0; k < 120; k += SANITIZED_STEP(3)) { /* a bit that has changed, anywhere */
        const size_t at = (size_t)rand() % a.size;
        const unsigned char bit = (unsigned char)(1 << (k % 8));
        a.state[at] ^= bit;
        assert_fails(sp_packing_make_with(&s, &hooks, &p, &err), SP_EFORMAT, "");
        a.state[at] ^= bit;
    }
    sp_free(a.state);
}

/* As state.c adds up bytes: here it makes damage look whole. */
static uint64_t sum_of(const unsigned char *byte, size_t size) {
    uint64_t hash = 0xcbf29ce484222325u;
    while (size > 0) {
        const size_t part = size < 8 ? size : 8;
        uint64_t word = 0;
        memcpy(&word, byte, part);
        hash = (hash ^ word) * 0x100000001b3u;
        hash ^= hash >> 29;
        byte += part;
        size -= part;
    }
    return hash;
}

static bool soon(const sp_pack_progress *progress, void *user) {
    (void)user;
    return progress->steps > 100000000;
}

/* Bytes with a right checksum may still hold anything: any status, no crash. */
TEST(no_bytes_crash_it) {
    sp_pack_spec s = small(2);
    album a = {.stop_after = 0};
    sp_packing p = sp_packing_none();
    sp_pack_hooks hooks = {.save = keep, .user = &a};
    assert_fails(sp_packing_make_with(&s, &hooks, &p, &err), SP_EINTERRUPTED, "");
    unsigned char *bytes = sp_alloc(a.size, 1);
    hooks = (sp_pack_hooks){.watch = soon, .state = bytes};
    srand(5);
    int refused = 0, tries = 200;
    for (int k = 0; k < tries; k++) {
        sp_error err = {0};
        size_t size = a.size, first = 40;
        memcpy(bytes, a.state, size);
        if (k % 4 == 0)
            size = first + 9 + (size_t)rand() % (size - first - 9);
        for (int flips = 1 + rand() % 3; flips > 0; flips--)
            bytes[first + (size_t)rand() % (size - first - 8)] = (unsigned char)rand();
        uint64_t length = size;
        memcpy(bytes + 24, &length, sizeof length);
        const uint64_t sum = sum_of(bytes, size - 8);
        memcpy(bytes + size - 8, &sum, sizeof sum);
        hooks.state_size = size;
        const sp_status status = sp_packing_make_with(&s, &hooks, &p, &err);
        assert_true(status != SP_OK);
        refused += status == SP_EFORMAT;
    }
    print_message("%d of %d refused at once\n", refused, tries);
    assert_true(refused > 25);
    sp_free(bytes);
    sp_free(a.state);
}

RUN_TESTS(NULL, NULL)
