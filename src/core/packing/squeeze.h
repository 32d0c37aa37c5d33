#ifndef SP_SQUEEZE_H
#define SP_SQUEEZE_H
/* Compression of cells without a piston: the cell shrinks around the gas at a small inertial number, and then follows
 * the difference between the stress in the grains and its target. */
#include "packing/compression.h"

/* Sets the strain rates of the cell, every LATERAL_STEPS; called before each step of length dt. */
void sp_squeeze_drive(compression *run, double dt);
/* Largest difference between the stress and its target: of the mean normal stress, or of all components. */
double sp_squeeze_imbalance(const compression *run);
/* Whether the grains carry half of the pressure. */
bool sp_squeeze_carried(const compression *run);
/* SP_EFAILED if the cell flows under its stress without end. */
sp_status sp_squeeze_check(const compression *run, sp_error *err);
/* Fraction of the way from the gas to a packing, by the volume. */
double sp_squeeze_progress(const compression *run);

#endif
