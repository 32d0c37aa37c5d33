#ifndef SP_ROWS_H
#define SP_ROWS_H
/* A spring as rows of B: its energy is 1/2 sum_q k_q (row_q . (u_i, u_j))^2. For assembly and imposed strain, where
 * clarity counts; the kernel of sp_network_apply does the same without forming rows. */

#include <sonopack/network.h>

enum { SP_ROWS_MAX = 7, SP_ROW_DOFS = 12 };

typedef struct sp_rows {
    int count;                                /* rows */
    int width;                                /* entries of a row: dof of i, then dof of j (0 for walls) */
    double k[SP_ROWS_MAX];                    /* stiffness of a row */
    double b[SP_ROWS_MAX][SP_ROW_DOFS];       /* relative displacement = b . (u_i, u_j) */
    double gap[SP_ROWS_MAX][SP_ROW_DOFS / 4]; /* the same for a displacement of j's side alone, as a translation */
} sp_rows;

void sp_network_rows(const sp_network *net, const sp_spring *spring, sp_rows *rows);

#endif
