#ifndef STRESS_RECORD_H
#define STRESS_RECORD_H
/* What was found: every comparison is a row of a table (appended to the file that SONOPACK_STRESS_TABLE names) and goes
 * into the verdict of the test. */

#include "test.h"

#include <sonopack/status.h>

typedef struct stress_record {
    int agreed, refused, wrong;
    FILE *table;
} stress_record;

static inline stress_record stress_open(void) {
    const char *path = getenv("SONOPACK_STRESS_TABLE");
    stress_record r = {.table = path ? fopen(path, "a") : NULL};
    return r;
}

/* error: the true one; reported: the bound; both in units of `scale`. A NAN compares as wrong. */
static inline void stress_agree(stress_record *r, const char *network, const char *method, const char *what,
                                double error, double reported, double scale) {
    const bool good = error <= reported && isfinite(reported);
    r->agreed += good;
    r->wrong += !good;
    if (r->table)
        fprintf(r->table, "%s\t%s\t%s\t%.2e\t%.2e\t%s\n", network, method, what, error / scale, reported / scale,
                good ? "agrees" : "WRONG");
    if (!good)
        print_message("%s, %s, %s: error %.3g, reported %.3g (of %.3g)\n", network, method, what, error, reported,
                      scale);
}

static inline void stress_refuse(stress_record *r, const char *network, const char *method, const char *what,
                                 sp_status status, const sp_error *err) {
    const bool good = status == SP_EREFUSED && err->text[0];
    r->refused += good;
    r->wrong += !good;
    if (r->table)
        fprintf(r->table, "%s\t%s\t%s\tnan\tnan\t%s\n", network, method, what, good ? "refuses" : "FAILS");
    if (!good)
        print_message("%s, %s, %s: %s (%s)\n", network, method, what, err->text, sp_status_name(status));
    if (good && getenv("SONOPACK_STRESS_REASONS"))
        print_message("%s, %s, %s: %s\n", network, method, what, err->text);
}

static inline void stress_close(stress_record *r) {
    if (r->table)
        fclose(r->table);
    print_message("%d agree, %d refused, %d wrong\n", r->agreed, r->refused, r->wrong);
}

#endif
