/* Packings as text: what is accepted is sound, and survives as HDF5. */
#include "guided.h"

#include <sonopack/study/store.h>
#include <string.h>

int LLVMFuzzerInitialize(int *count, char ***words) { return count == NULL || words == NULL; }

/* Reads what was written, which must be the same packing. */
static void check_written(const sp_packing *p) {
    sp_error err = guided_error();
    sp_packing again;
    const char *path = guided_output(0);
    must(guided_good(sp_packing_save(p, path, &err), &err));
    must(guided_good(sp_packing_read(path, &again, &err), &err));
    must(sp_packing_hash(p) == sp_packing_hash(&again));
    sp_packing_free(&again);
}

static void check_packing(const sp_packing *p) {
    sp_error err = guided_error();
    sp_audit audit;
    must(guided_good(sp_packing_check(p, &err), &err));
    guided_good(sp_packing_audit(p, 1e-4, &audit, &err), &err);
    check_written(p);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
    sp_error err = guided_error();
    sp_packing p;
    if (guided_good(sp_packing_read(guided_file(0, data, size), &p, &err), &err)) {
        check_packing(&p);
        sp_packing_free(&p);
    }
    return 0;
}
