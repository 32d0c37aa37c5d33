#ifndef SP_NODES_H
#define SP_NODES_H
/* Linear functionals of the response to a short pulse, and their weights of its moments. */

#include <sonopack/sensitivity.h>

/* sum of weight x the derivative of order `order` of the response at t. */
typedef struct sp_nodes {
    int64_t n;
    size_t capacity;
    struct sp_node {
        double t, weight;
        int order;
    } * at;
} sp_nodes;

void sp_nodes_free(sp_nodes *nodes);
/* Adds weight x the derivative of the signal of a pulse at time t; NULL: of the short one. limit: upper bound of the
 * frequencies, which decides how finely a pulse is divided. */
sp_status sp_nodes_add(sp_nodes *nodes, const sp_pulse *pulse, double limit, double t, int order, double weight,
                       sp_error *err);
/* SP_EINVAL for a pulse that is none of those whose derivatives are known. */
sp_status sp_nodes_check_pulse(const sp_pulse *pulse, sp_error *err);
double sp_nodes_last(const sp_nodes *nodes); /* the last time */

/* Weights C_k of the moments b^T W_k a (velocity) or b^T T_k a for k < *terms, all that matter; c: to be freed. */
typedef struct sp_moment_weights {
    int64_t terms;
    double *c;
    double tail;  /* bound of the sum of |C_k| |b^T P_k a| beyond them, in units of |a||b| */
    double steep; /* the same for derivatives: of |C_k| |dP_k/dX| */
} sp_moment_weights;
/* power: not the weights of the functional, but those of its change with the stiffness of all springs, if F(t) becomes
 * s^power F(t sqrt(s)) when they are multiplied by s: (power + order/2) F^(order) + t/2 F^(order + 1). NULL: as it is.
 */
sp_status sp_nodes_weights(const sp_nodes *nodes, double omega, bool velocity, const double *power,
                           sp_moment_weights *out, sp_error *err);
void sp_moment_weights_free(sp_moment_weights *w);

#endif
