#ifndef SP_CELL_GRID_H
#define SP_CELL_GRID_H
/* Cells that find the grains near a point, in a box with periodic axes; unless told otherwise all but the last.
 *
 * There is one grid for each octave of grain sizes, so that a cell holds a few grains for any range of sizes. A pair
 * belongs to the octave of its smaller grain, which searches the grids of its own octave and of larger grains. */

#include <sonopack/status.h>
#include <stdbool.h>
#include <stdint.h>

enum { SP_OCTAVES = 8, SP_CELLS_NEAR = 27 };

typedef struct cell_grid {
    int64_t n[3], first; /* cells along each axis; index of the first cell in head */
    double width[3];
    bool used;
} cell_grid;

typedef struct cells {
    int dim;
    double r_max;  /* of all grains */
    double box[3]; /* periods, or distances of walls */
    bool periodic[3];
    cell_grid grid[SP_OCTAVES];
    int64_t count, capacity; /* of head: in use, and memory */
    int32_t *head;           /* first grain of each cell; -1: none */
    int32_t *next;           /* [n] next grain in the cell; -1: none */
    int64_t *at;             /* [n] cell of each grain, if it was found by sp_cells_locate */
    int32_t *sorted, *start; /* [n] grains by cell, and [count + 1] the first of each cell in it: of located grains */
} cells;

/* Allocates cells for n grains. SP_ENOMEM. */
sp_status sp_cells_make(int dim, int32_t n, double r_max, cells *out, sp_error *err);
void sp_cells_free(cells *c);
/* Octave of a grain of radius r. */
int sp_cells_octave(const cells *c, double r);
/* Empties the cells and adapts them to c->box, to population[] grains in each octave, and to pairs whose surfaces are
 * closer than the gap. SP_ENOMEM. */
sp_status sp_cells_reset(cells *c, const int64_t population[SP_OCTAVES], double gap, sp_error *err);
/* Enters grain i at x. */
void sp_cells_enter(cells *c, int octave, int32_t i, const double *x);
/* The same in two steps, which threads can share. First the cell of each grain is found. Then the grains of the cells
 * [first, last) are entered, in ascending order within a cell, and sorted. */
void sp_cells_locate(cells *c, int octave, int32_t i, const double *x);
void sp_cells_enter_located(cells *c, int32_t n, int64_t first, int64_t last);
/* Lists the cells of an octave that can hold neighbours of a grain at x, each once. Returns their number. */
int sp_cells_near(const cells *c, int octave, const double *x, int64_t cell[SP_CELLS_NEAR]);

#endif
