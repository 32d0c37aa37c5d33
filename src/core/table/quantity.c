/* Looks up what the numbers of results are. */
#include "table/quantity.h"

#include <sonopack/elastic.h>
#include <sonopack/packing.h>
#include <stddef.h>
#include <string.h>

#define STATICS(member, symbol, unit, meaning) {symbol, unit, meaning, offsetof(sp_statics, member)},
const sp_quantity sp_statics_quantities[] = {
#include <sonopack/quantities.inc>
    {0}};
#undef STATICS

#define RING_STATICS(member, symbol, unit, meaning) {symbol, unit, meaning, offsetof(sp_ring_statics, member)},
const sp_quantity sp_ring_statics_quantities[] = {
#include <sonopack/quantities.inc>
    {0}};
#undef RING_STATICS

#define MODULI(member, symbol, unit, meaning) {symbol, unit, meaning, offsetof(sp_moduli, member)},
const sp_quantity sp_moduli_quantities[] = {
#include <sonopack/quantities.inc>
    {0}};

const sp_quantity *sp_quantity_next(const sp_quantity *all, const char **symbols) {
    const char *symbol = *symbols + strspn(*symbols, " ");
    const size_t n = strcspn(symbol, " ");
    *symbols = symbol + n;
    while (n > 0 && all->symbol && (strlen(all->symbol) != n || strncmp(all->symbol, symbol, n) != 0))
        all++;
    return n > 0 && all->symbol ? all : NULL;
}

double sp_quantity_value(const sp_quantity *q, const void *of) {
    double value;
    memcpy(&value, (const char *)of + q->offset, sizeof value);
    return value;
}
