#ifndef SP_AIRY_H
#define SP_AIRY_H
/* Airy function Ai(x) and its derivative for finite x. Relative errors are 1e-14 for |x| < 9 (of the envelope where the
 * functions oscillate), and (1 + |x|^(3/2)) 2e-16 beyond. */
void sp_airy(double x, double *ai, double *slope);

#endif
