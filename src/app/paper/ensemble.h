#ifndef SP_PAPER_ENSEMBLE_H
#define SP_PAPER_ENSEMBLE_H
/* Ensembles of packings for the tables and figures. */

#include <sonopack/study/study.h>
#include <stdbool.h>

typedef enum paper_ensemble {
    PAPER_SQUARE = 0,   /* 600 grains, width 24, four pressures: Tables I, II, IV, V, Figs. 1, 2, 8 */
    PAPER_LOW,          /* 200 grains: the other height for c_tof */
    PAPER_SHORT,        /* 100 and 400 grains at 1e-4 */
    PAPER_TALL,         /* 1200 grains */
    PAPER_TALLEST,      /* 2400 grains */
    PAPER_SMOOTH,       /* 600 grains without friction */
    PAPER_SPHERES,      /* three dimensions, without friction */
    PAPER_LATTICE,      /* triangular lattices about 8 and 24 high, without and with friction, five pressures */
    PAPER_LATTICE_LONG, /* 20, 46, 92 and 184 rows at 5e-7 */
    PAPER_UNEVEN,       /* lattices 8 and 24 high of balls 1 +- 4.8e-4: P* = 0.1, 1 and 10 */
    PAPER_UNEVEN_LOW,   /* of balls 1 +- 0.005 at 1e-7 and 1e-6: P* = 3e-4 and 3e-3 */
    PAPER_CHAIN_1,      /* chains of unequal balls: diameters 1 +- 0.1 */
    PAPER_CHAIN_2,      /* 1 +- 0.2 */
    PAPER_CHAIN_4,      /* 1 +- 0.4 */
    PAPER_ENSEMBLES
} paper_ensemble;

/* Half width of the distribution of diameters in a chain. */
double sp_paper_chain_spread(paper_ensemble e);
/* The scene of an ensemble if the paper's own ensembles have `samples` samples. protocol: how packings under a piston
 * are compressed. Free with sp_scene_free. */
sp_status sp_paper_ensemble_scene(paper_ensemble e, int32_t samples, sp_protocol protocol, sp_scene *out,
                                  sp_error *err);
/* Approximate cost [CPU seconds]. */
double sp_paper_ensemble_cost(paper_ensemble e, int32_t samples, sp_protocol protocol);
const char *sp_paper_ensemble_name(paper_ensemble e);
/* Value of the scene key packing.protocol. */
const char *sp_paper_protocol_name(sp_protocol protocol);

#endif
