/* Packings as text, in one file or as tables of grains and contacts: what is accepted is sound, and survives all forms
 * in which it is written. */
#include "guided.h"

#include <sonopack/study/store.h>
#include <string.h>

int LLVMFuzzerInitialize(int *count, char ***words) { return count == NULL || words == NULL; }

/* Reads what was written to file 3 (two tables: 2 and 3), which must be the same packing. */
static void check_written(const sp_packing *p, bool tables) {
    sp_error err = guided_error();
    sp_packing again;
    const char *first = guided_output(0), *second = guided_output(1);
    if (tables) {
        must(guided_good(sp_packing_save_tables(p, first, second, &err), &err));
        must(guided_good(sp_packing_read_tables(first, second, 0, NULL, &again, &err), &err));
    } else {
        must(guided_good(sp_packing_save(p, second, &err), &err));
        must(guided_good(sp_packing_read(second, &again, &err), &err));
    }
    must(sp_packing_hash(p) == sp_packing_hash(&again));
    sp_packing_free(&again);
}

static void check_packing(const sp_packing *p) {
    sp_error err = guided_error();
    sp_audit audit;
    must(guided_good(sp_packing_check(p, &err), &err));
    guided_good(sp_packing_audit(p, 1e-4, &audit, &err), &err);
    check_written(p, false);
    check_written(p, true);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
    guided_parts in = guided_split(data, size, 3);
    char *key[GUIDED_WORDS];
    sp_error err = guided_error();
    sp_packing p;
    sp_status status;
    if (in.count > 1) {
        const int keys = in.count > 2 ? guided_words(in.part[2], key) : 0;
        const char *grains = guided_file(0, in.part[0], in.size[0]), *contacts = guided_file(1, in.part[1], in.size[1]);
        status = sp_packing_read_tables(grains, contacts, keys, key, &p, &err);
    } else {
        status = sp_packing_read(guided_file(0, data, size), &p, &err);
    }
    if (guided_good(status, &err)) {
        check_packing(&p);
        sp_packing_free(&p);
    }
    guided_free(&in);
    return 0;
}
