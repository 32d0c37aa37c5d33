/* Lists the items of the paper: what each shows, which samples it requires, and the function that makes it. */
#include "paper/paper.h"

#include <stddef.h>

enum {
    FRONT = SP_WANT_CTOF,
    STATICS = SP_WANT_STATICS,
    MODULI = SP_WANT_STATICS | SP_WANT_MODULI,
    PROBES = SP_WANT_STATICS | SP_WANT_MODULI | SP_WANT_PROBES
};

#define HEIGHTS(drawn)                                                                                                 \
    {PAPER_SHORT, FRONT, drawn}, {PAPER_LOW, FRONT, drawn}, {PAPER_SQUARE, FRONT, drawn}, {PAPER_TALL, FRONT, drawn},  \
    {                                                                                                                  \
        PAPER_TALLEST, FRONT, drawn                                                                                    \
    }
#define CHAINS(drawn)                                                                                                  \
    {PAPER_CHAIN_1, FRONT, drawn}, {PAPER_CHAIN_2, FRONT, drawn}, { PAPER_CHAIN_4, FRONT, drawn }

const paper_item sp_paper_items[SP_PAPER_ITEMS] = {
    {"table1",
     "Table I. Statics",
     "Solid fractions, contacts per grain, rattlers, forces and fabric of 600 grains at four pressures, bulk values.",
     sp_paper_make_table,
     1,
     {{PAPER_SQUARE, STATICS, false}}},
    {"table2",
     "Table II. Stress ratio and elastic moduli",
     "Horizontal over vertical stress, and the four moduli under strains imposed on the whole cell.",
     sp_paper_make_table,
     1,
     {{PAPER_SQUARE, MODULI, false}}},
    {"table3",
     "Table III. Exponents of amplitude and width",
     "The height of the first peak falls as L^-gamma with the distance, its width grows as L^alpha.",
     sp_paper_make_exponents,
     8,
     {HEIGHTS(false), CHAINS(false)}},
    {"table4",
     "Table IV. Moduli from sine-shaped body forces",
     "Apparent moduli from the energy of the response to a body force sin(n pi y/L), over those of Table II.",
     sp_paper_make_table,
     1,
     {{PAPER_SQUARE, PROBES, false}}},
    {"table5",
     "Table V. Moduli from displaced lines",
     "Apparent moduli from the energy when grains on n + 1 lines are displaced by turns, over those of Table II.",
     sp_paper_make_table,
     1,
     {{PAPER_SQUARE, PROBES, false}}},
    {"fig1",
     "Fig. 1. Networks of forces and of stiffnesses",
     "Forces fluctuate strongly in space, stiffnesses much less; so do their histograms.",
     sp_paper_make_fig1,
     1,
     {{PAPER_SQUARE, STATICS, true}}},
    {"fig2",
     "Fig. 2. Directions of contacts",
     "Contacts with forces above the mean prefer the vertical, the others slightly the horizontal.",
     sp_paper_make_fig2,
     1,
     {{PAPER_SQUARE, STATICS, true}}},
    {"fig3",
     "Fig. 3. Snapshot of the wave at t = 80",
     "Large localised oscillations near the bottom wall, and a smaller homogeneous wave that has almost reached the "
     "top "
     "wall.",
     sp_paper_make_fig3,
     1,
     {{PAPER_SQUARE, STATICS, true}}},
    {"fig4",
     "Fig. 4. Signals",
     "The first cycle is nearly the same for all packings, what follows is not; without friction, and in three "
     "dimensions, it is similar.",
     sp_paper_make_fig4,
     3,
     {{PAPER_SQUARE, STATICS, true}, {PAPER_SMOOTH, FRONT, true}, {PAPER_SPHERES, FRONT, true}}},
    {"fig5",
     "Fig. 5. The coherent part in boxes of several heights",
     "In taller boxes the front arrives later, lower and wider.",
     sp_paper_make_fig5,
     5,
     {HEIGHTS(true)}},
    {"fig6",
     "Fig. 6. Arrival times against distance",
     "Arrival (10% of the first peak), peak and zero crossing grow nearly linearly with the distance; the slope of the "
     "arrival is 1/c_tof, c_tof = 0.25.",
     sp_paper_make_fig6,
     5,
     {HEIGHTS(false)}},
    {"fig7",
     "Fig. 7. Effective exponents of amplitude and width",
     "The local slopes of log A and log W against log L, for packings and for chains.",
     sp_paper_make_fig7,
     8,
     {HEIGHTS(true), CHAINS(true)}},
    {"fig8",
     "Fig. 8. Speeds against pressure",
     "c_tof, and the speeds c_l and c_t of long waves from the moduli, against pressure, beside triangular lattices; "
     "and three experiments, whose points are not available here.",
     sp_paper_make_fig8,
     4,
     {{PAPER_SQUARE, FRONT | MODULI, false},
      {PAPER_LOW, FRONT, false},
      {PAPER_LATTICE, FRONT, false},
      {PAPER_LATTICE_LONG, FRONT, false}}},
    {"fig9",
     "Fig. 9. Eigenfrequencies and transmission of modes",
     "Squared eigenfrequencies of the packing of Fig. 1, beginning with the zero modes of rattlers, and the weight a_n "
     "b_n of each mode in the signal.",
     sp_paper_make_fig9,
     1,
     {{PAPER_SQUARE, STATICS, true}}},
    {"fig10",
     "Fig. 10. Six modes",
     "The first two above zero look like waves of an elastic body, those that carry the signal do not, and high ones "
     "are "
     "localised.",
     sp_paper_make_fig10,
     1,
     {{PAPER_SQUARE, STATICS, true}}},
    {"fig11",
     "Fig. 11. Damping",
     "Viscous contacts change the coherent part little and suppress the random part.",
     sp_paper_make_fig11,
     1,
     {{PAPER_SQUARE, STATICS, true}}},
    {"fig12",
     "Fig. 12. Chains, the triangular lattice, and the Airy front",
     "The front of a chain of identical balls tends to Eq. (16); that of a triangular lattice is close to the chain's.",
     sp_paper_make_fig12,
     1,
     {{PAPER_LATTICE_LONG, FRONT, false}}},
    {"claims",
     "Claims of the text",
     "What the paper says in words, as relations between numbers: each with the place where it says so.",
     sp_paper_make_claims,
     10,
     {HEIGHTS(false),
      {PAPER_SMOOTH, FRONT, false},
      {PAPER_LATTICE, FRONT, false},
      {PAPER_LATTICE_LONG, FRONT, false},
      {PAPER_UNEVEN, FRONT | STATICS, false},
      {PAPER_UNEVEN_LOW, STATICS, false}}},
};

static bool is_item(int item) { return item >= 0 && item < SP_PAPER_ITEMS; }

const char *sp_paper_item_name(int item) { return is_item(item) ? sp_paper_items[item].name : NULL; }
const char *sp_paper_item_title(int item) { return is_item(item) ? sp_paper_items[item].title : NULL; }

/* Seconds without and with figures, measured with two samples of each combination. */
static const double seconds[SP_PAPER_ITEMS][2] = {
    {0.02, 0.03}, {0.02, 0.02}, {0.14, 0.14}, {0.04, 0.05}, {0.02, 0.03}, /* tables */
    {0, 0.07},    {0, 0.04},    {0, 0.04},    {0, 10.5},    {0, 0.1},     {0.04, 0.06},
    {0, 0.12},    {0.07, 0.08}, {0, 1.03},    {0, 1.1},     {0, 2.8},     {0.02, 0.04}, /* figures */
    {1.33, 1.33}};

double sp_paper_item_seconds(int item, bool drawn) { return is_item(item) ? seconds[item][drawn] : 0; }
