#ifndef SP_BULK_H
#define SP_BULK_H
/* The bulk of a packing: what is left without layers at the walls. */

#include <sonopack/packing.h>

typedef struct bulk {
    int dim;
    bool bounded[3];        /* axes with walls */
    double low[3], high[3]; /* its boundaries along these axes [d] */
    double volume;          /* 0 or below: there is none [d^3] */
} bulk;

/* margin: thickness of the layers [d]. Without walls the bulk is the whole cell. */
bulk sp_bulk_of(const sp_packing *p, double margin);
bool sp_bulk_has(const bulk *b, const double x[3]);
/* Fraction of a ball of radius r that is in the bulk. Exact where at most one wall's layer cuts it, to about 1e-3 at
 * edges and corners. */
double sp_bulk_ball(const bulk *b, const double x[3], double r);

#endif
