#ifndef SP_MINIMUM_H
#define SP_MINIMUM_H
/* Smooth grains in a periodic cell on their way to a minimum of the energy: pairs and forces (minimum_forces.c), the
 * way down (minimum.c). */
#include <sonopack/packing.h>

enum { MINIMUM_TENSOR = 6 }; /* xx yy zz yz xz xy */

/* A homogeneous strain: x -> grow x + shear (xy, xz, yz), which keeps the form of the lattice vectors. */
typedef struct cell_strain {
    double grow[3], shear[3];
} cell_strain;

typedef struct pair {
    int32_t i, j;
    float shift[3]; /* periods from i to the image of j */
    double e, reach;
} pair;

/* FIXED: the cell keeps its shape. GROWS: it changes its size alone, by v_cell[0]. YIELDS: free components give way to
 * their stress. */
typedef enum minimum_cell { CELL_FIXED, CELL_GROWS, CELL_YIELDS } minimum_cell;

typedef struct minimum {
    const sp_pack_spec *spec;
    const sp_pack_hooks *hooks;
    int32_t *type; /* [n] materials */
    sp_packing p;  /* the state; between new lists its grains may leave the cell */
    pair *pair;
    size_t capacity;
    int64_t pairs, steps;
    double skin;
    double *memory, *v, *f, *stiff, *old; /* [n][3] velocities, forces, sum of stiffnesses [n], places of the list */
    cell_strain carried;                  /* of the cell since the list was made */
    minimum_cell cell, wanted;            /* wanted: once the grains are jammed */
    double unit;                          /* the cell's coordinates are unit times its strains */
    double v_cell[MINIMUM_TENSOR], f_cell[MINIMUM_TENSOR];
    double stress[MINIMUM_TENSOR],
        aims[MINIMUM_TENSOR]; /* YIELDS: of the grains, and of this stage; compression positive */
    bool free[MINIMUM_TENSOR];
    double flow[MINIMUM_TENSOR]; /* how much the cell has given way in this stage */
    double aim, strained;        /* pressure of this stage; where it is on the path of strain */
    double pressure, residual, stiffest;
} minimum;

/* Lists the pairs that may touch; and the same where the list is too old. */
sp_status sp_minimum_list(minimum *m, sp_error *err);
sp_status sp_minimum_refresh(minimum *m, sp_error *err);
/* The vector from grain i to the image of grain j, and the square of its length. */
double sp_minimum_separation(const minimum *m, const pair *q, double d[3]);
/* The force of a pair at an overlap. */
double sp_minimum_force(const minimum *m, const pair *q, double overlap);
/* Finds forces, stresses, pressure and residual. */
void sp_minimum_forces(minimum *m);
/* Strains the cell and what is in it. */
void sp_minimum_deform(minimum *m, const cell_strain *s);
/* x += t v, and the same of the cell. */
void sp_minimum_move(minimum *m, double t);
bool sp_minimum_at_rest(const minimum *m);

#endif
