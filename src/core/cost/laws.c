/* Evaluates the fitted laws. */
#include "cost/laws.h"

#include <math.h>

static const struct {
    sp_work work;
    sp_kernel kernel;
    double ns, n, k; /* nanoseconds, powers */
} laws[] = {
#define LAW(work, kernel, ns, a, b) {SP_WORK_##work, SP_KERNEL_##kernel, ns, a, b},
#include "cost/laws.inc"
#undef LAW
};

double sp_law_seconds(sp_work work, double n, double k, const sp_machine *machine) {
    double sum = 0;
    for (size_t r = 0; r < sizeof laws / sizeof *laws; r++)
        if (laws[r].work == work)
            sum += laws[r].ns * pow(n, laws[r].n) * pow(k, laws[r].k) * machine->slower[laws[r].kernel];
    return 1e-9 * sum;
}

sp_cost sp_cost_add(sp_cost a, sp_cost b) {
    return (sp_cost){a.cpu + b.cpu, a.wall + b.wall, fmax(a.memory, b.memory)};
}
