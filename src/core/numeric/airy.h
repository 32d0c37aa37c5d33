#ifndef SP_AIRY_H
#define SP_AIRY_H
/* The Airy function Ai(x) and its derivative for all finite x: relative errors of 1e-14 for |x| below 9 (of the
 * envelope where they oscillate), beyond of (1 + |x|^(3/2)) 2e-16. */
void sp_airy(double x, double *ai, double *slope);

#endif
