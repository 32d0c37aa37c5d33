/* Arrays of derivatives and their errors. */
#include "base/base.h"
#include "sensitivity/gradient.h"

void sp_partials_free(sp_partials *p) {
    sp_free(p->d);
    sp_free(p->error);
    *p = (sp_partials){0};
}

sp_status sp_partials_make(int64_t n, sp_partials *out, sp_error *err) {
    sp_partials p = {n, sp_alloc((size_t)n, sizeof *p.d), sp_alloc((size_t)n, sizeof *p.error)};
    *out = p;
    return p.d && p.error ? SP_OK : sp_fail_memory(err, 2 * (size_t)n * sizeof *p.d);
}
