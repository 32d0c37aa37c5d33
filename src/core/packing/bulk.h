#ifndef SP_BULK_H
#define SP_BULK_H
/* The bulk of a packing: what is left without layers at the walls. */

#include <sonopack/packing.h>

enum { SP_BULK_NODES = 16 };

typedef struct bulk {
    int dim;
    bool bounded[3];                                   /* axes with walls */
    double ring[2];                                    /* between rings: radii of its two circles; else 0 [d] */
    double centre;                                     /* of the circles, on both axes [d] */
    double low[3], high[3];                            /* its boundaries along these axes [d] */
    double volume;                                     /* 0 or below: there is none [d^3] */
    double node[SP_BULK_NODES], weight[SP_BULK_NODES]; /* Gauss's rule, for grains at edges and corners */
} bulk;

/* margin: thickness of the layers [d]. Without walls the bulk is the whole cell. */
bulk sp_bulk_of(const sp_packing *p, double margin);
bool sp_bulk_has(const bulk *b, const double x[3]);
/* Fraction of a ball of radius r that is in the bulk: in closed form where the layers of one axis cut it, at edges,
 * corners and rings by quadrature to rounding. */
double sp_bulk_ball(const bulk *b, const double x[3], double r);

/* Fraction of a disc of radius r within a circle of radius `circle`, whose centre is `away` from its own; of a ball
 * within the cylinder over that circle. node, weight: of sp_gauss_rule. */
double sp_disc_in_circle(double away, double r, double circle);
double sp_ball_in_circle(double away, double r, double circle, const double node[SP_BULK_NODES],
                         const double weight[SP_BULK_NODES]);
/* Unit vector upwards at a point: along the up axis, of a ring along its radius. */
void sp_packing_up(const sp_packing *p, const double x[3], double up[3]);
/* Turns a vector from x and y to the axes of a ring at a contact: across (clockwise) and up. */
void sp_ring_axes(const sp_packing *p, const sp_contact *c, double v[3]);
/* Adds F_a r_b over all carrying contacts, walls included, positive in compression. F is the force of i on j and r
 * points from i to j; polar: on the axes of a ring at each contact. */
void sp_packing_moments(const sp_packing *p, const uint8_t *carrying, bool polar, double sum[3][3]);
/* Place of a contact: on the surface of i, half the overlap deep. */
void sp_contact_point(const sp_packing *p, const sp_contact *c, double x[3]);

#endif
