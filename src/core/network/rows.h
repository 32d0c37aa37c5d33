#ifndef SP_ROWS_H
#define SP_ROWS_H
/* A spring as rows of B, with energy 1/2 sum_q k_q (row_q . (u_i, u_j))^2. For assembly and imposed strains, where
 * clarity matters; sp_network_apply does the same without forming rows. */

#include <sonopack/network.h>

enum { SP_ROWS_MAX = 7, SP_ROW_DOFS = 12 };

typedef struct sp_rows {
    int count;                                /* number of rows */
    int width;                                /* entries per row: dof of i, then dof of j (absent for walls) */
    double k[SP_ROWS_MAX];                    /* stiffness of each row */
    double b[SP_ROWS_MAX][SP_ROW_DOFS];       /* relative displacement = b . (u_i, u_j) */
    double gap[SP_ROWS_MAX][SP_ROW_DOFS / 4]; /* the same for a translation of j's image or wall alone */
} sp_rows;

void sp_network_rows(const sp_network *net, const sp_spring *spring, sp_rows *rows);

enum { SP_TURNS_MAX = 3 };

/* Contribution of a spring's tangential force at rest to K: the sum over q of left[q] right[q]^T. The gaps are, as
 * above, the coefficients for a translation of j's image or wall alone. */
typedef struct sp_turns {
    int count, width;
    double left[SP_TURNS_MAX][SP_ROW_DOFS], right[SP_TURNS_MAX][SP_ROW_DOFS];
    double left_gap[SP_TURNS_MAX][SP_ROW_DOFS / 4], right_gap[SP_TURNS_MAX][SP_ROW_DOFS / 4];
} sp_turns;

/* Computes the turns of spring k; count = 0 if K is symmetric. */
void sp_network_turns(const sp_network *net, int32_t k, sp_turns *turns);

#endif
