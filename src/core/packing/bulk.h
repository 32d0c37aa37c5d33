#ifndef SP_BULK_H
#define SP_BULK_H
/* The bulk of a packing: what is left without layers at the walls. */

#include <sonopack/packing.h>

enum { SP_BULK_NODES = 16 };

typedef struct bulk {
    int dim;
    bool bounded[3];                                   /* axes with walls */
    double low[3], high[3];                            /* its boundaries along these axes [d] */
    double volume;                                     /* 0 or below: there is none [d^3] */
    double node[SP_BULK_NODES], weight[SP_BULK_NODES]; /* Gauss's rule, for grains at edges and corners */
} bulk;

/* margin: thickness of the layers [d]. Without walls the bulk is the whole cell. */
bulk sp_bulk_of(const sp_packing *p, double margin);
bool sp_bulk_has(const bulk *b, const double x[3]);
/* Fraction of a ball of radius r that is in the bulk: in closed form where the layers of one axis cut it, at edges and
 * corners by quadrature to rounding. */
double sp_bulk_ball(const bulk *b, const double x[3], double r);

#endif
