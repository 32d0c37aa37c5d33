/* What a store keeps beside its samples: lines of its cache, records of failed samples, states of compressions. The
 * first byte chooses. A line gets the checksum that it needs: damage that the checksum finds reaches no parser. */
#include "store/records.h"
#include "base/base.h"
#include "guided.h"

#include <sonopack/packing.h>
#include <stdlib.h>
#include <string.h>

static sp_pack_spec spec;
static uint8_t *state;
static size_t state_size;

static sp_status keep(const void *bytes, size_t size, void *user, sp_error *err) {
    state = realloc(state, size);
    must(state != NULL && user == NULL && err != NULL);
    memcpy(state, bytes, size);
    state_size = size;
    return SP_OK;
}

static bool stop(const sp_pack_progress *progress, void *user) {
    return user == NULL && (!state || progress->steps < 2000);
}

/* A state belongs to one version of the program, and so is made here. */
int LLVMFuzzerInitialize(int *count, char ***words) {
    const sp_pack_hooks hooks = {.watch = stop, .save = keep};
    sp_error err = guided_error();
    sp_packing p;
    spec = sp_pack_spec_default();
    spec.dim = 2;
    spec.grains = 10;
    spec.width = 5;
    must(count && words);
    if (sp_packing_make_with(&spec, &hooks, &p, &err) == SP_OK)
        sp_packing_free(&p);
    must(state != NULL);
    return 0;
}

static const char name[] = "0123456789abcdef0123456789abcdef";

/* Reads a line, whose text is changed, of the file that it names. */
static bool get_copy(const char *line, size_t size, const struct stat *file, sp_sample *out) {
    char *copy = malloc(size + 1);
    must(copy != NULL);
    memcpy(copy, line, size);
    copy[size] = '\0';
    const bool good = sp_manifest_get(copy, name, false, file, out);
    free(copy);
    return good;
}

static void try_line(const uint8_t *data, size_t size) {
    sp_sample s, again;
    sp_text sealed = {0}, second = {0};
    const struct stat file = {.st_size = 7};
    if (memchr(data, 0, size) || memchr(data, '\n', size))
        return;
    sp_text_add(&sealed, "%s\th5\t7\t0\t", name);
    sp_text_bytes(&sealed, (const char *)data, size);
    sp_text_add(&sealed, "\t");
    const uint64_t sum = sealed.failed ? 0 : sp_hash64(SP_HASH64_BEGIN, sealed.data, sealed.size);
    sp_text_add(&sealed, "%016llx", (unsigned long long)sum);
    must(!sealed.failed);
    if (get_copy(sealed.data, sealed.size, &file, &s)) {
        must(s.dim >= 1 && s.dim <= 3 && s.kind >= 0 && s.grains >= 1 && s.planes <= SP_PLANES_MAX);
        sp_manifest_put(&second, &file, &s);
        must(!second.failed && get_copy(second.data, second.size - 1, &file, &again));
    }
    sp_text_free(&sealed);
    sp_text_free(&second);
}

static void try_failure(const uint8_t *data, size_t size) {
    sp_error err = guided_error();
    sp_sample s, again;
    if (!guided_good(sp_failure_read(guided_file(0, data, size), "name", &s, &err), &err))
        return;
    must(s.failed && s.dim >= 1 && s.dim <= 3 && s.grains >= 1 && s.width > 0 && s.pressure > 0 && s.friction >= 0);
    const char *path = guided_output(0);
    must(guided_good(sp_failure_save(path, &s, &err), &err));
    must(guided_good(sp_failure_read(path, "name", &again, &err), &err));
    must(s.dim == again.dim && s.grains == again.grains && s.seed == again.seed && s.kind == again.kind);
    must(s.width == again.width && s.pressure == again.pressure && s.friction == again.friction);
}

static bool stop_at_once(const sp_pack_progress *progress, void *user) { return progress == NULL || user != NULL; }

/* Replaces bytes, three of the input for each: where, and by what. An odd one at the end cuts the state off. */
static void try_state(const uint8_t *data, size_t size) {
    sp_error err = guided_error();
    int64_t steps = -1;
    uint8_t *copy = malloc(state_size);
    must(copy != NULL);
    memcpy(copy, state, state_size);
    for (size_t k = 0; k + 3 <= size; k += 3)
        copy[((size_t)data[k] << 8 | data[k + 1]) % state_size] = data[k + 2];
    const size_t cut = size % 3 ? data[size - 1] : 0, left = state_size > cut + 64 ? state_size - cut : state_size;
    const uint64_t length = left;
    memcpy(copy + 24, &length, sizeof length);
    const uint64_t sum = sp_hash64_words(SP_HASH64_BEGIN, copy, left - sizeof sum);
    memcpy(copy + left - sizeof sum, &sum, sizeof sum);
    if (sp_pack_is_state(copy, left) && guided_good(sp_pack_state_check(&spec, copy, left, &steps, &err), &err))
        must(steps >= 0);
    const sp_pack_hooks hooks = {.watch = stop_at_once, .state = copy, .state_size = left};
    sp_packing p;
    if (guided_good(sp_packing_make_with(&spec, &hooks, &p, &err), &err))
        sp_packing_free(&p);
    free(copy);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
    static void (*const reader[])(const uint8_t *, size_t) = {try_line, try_failure, try_state};
    if (size > 0)
        reader[data[0] % 3](data + 1, size - 1);
    return 0;
}
