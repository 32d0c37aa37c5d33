/* Airy functions. For |x| < 9: Taylor series about the nearest integer, where Ai'' = x Ai gives each coefficient from
 * two others. Beyond: the asymptotic series (Abramowitz and Stegun, 10.4.59 to 10.4.62), whose smallest term is exp(-2
 * zeta) < 1e-15. */
#include "numeric/airy.h"

#include <math.h>
#include <stdbool.h>

enum { EDGE = 9, TERMS = 26, ASYMPTOTIC = 30 };

/* Ai and Ai' at the integers -EDGE .. EDGE, from the power series at 0 with 40 digits. */
static const double at_integer[2 * EDGE + 1][2] = {
    {-0.022133721547341403674, -0.97566398092633159471},   {-0.052705050356386202622, 0.93556093819830655103},
    {0.18428083525050563728, -0.77100816841012654773},     {-0.32914517362982310523, 0.34593548728134289493},
    {0.35076100902411431979, 0.32719281855444313679},      {-0.070265532949289515099, -0.7906285753685813803},
    {-0.37881429367765807435, 0.31458376921659881365},     {0.22740742820168557599, 0.61825902074169104141},
    {0.5355608832923521188, -0.010160567116645209395},     {0.35502805388781723926, -0.25881940379280679841},
    {0.13529241631288141552, -0.15914744129679321279},     {0.034924130423274379135, -0.053090384433653631704},
    {0.0065911393574607191443, -0.011912976705951318474},  {0.00095156385120480187362, -0.0019586409502041789001},
    {0.00010834442813607441735, -0.000247413890868462476}, {9.9476943602528895702e-6, -0.000024765200397034954754},
    {7.4921288639971670808e-7, -2.0081508947387919912e-6}, {4.6922076160992316256e-8, -1.3414392979067865743e-7},
    {2.4711684308724898433e-9, -7.4806413896589464128e-9},
};

static void taylor(double x, double *ai, double *slope) {
    const double centre = round(x), h = x - centre;
    const double *known = at_integer[(int)centre + EDGE];
    double a[TERMS] = {known[0], known[1], 0.5 * centre * known[0]};
    for (int k = 3; k < TERMS; k++)
        a[k] = (centre * a[k - 2] + a[k - 3]) / (k * (k - 1));
    double value = 0, derivative = 0;
    for (int k = TERMS - 1; k > 0; k--) {
        value = value * h + a[k];
        derivative = derivative * h + k * a[k];
    }
    *ai = value * h + a[0];
    *slope = derivative;
}

/* Sums of the terms u_k/zeta^k and v_k/zeta^k with even and with odd k. For the oscillating functions every second term
 * of each changes its sign. */
typedef struct asymptotic {
    double u[2], v[2];
} asymptotic;

static asymptotic sums(double zeta, bool oscillating) {
    asymptotic s = {.u = {1, 0}, .v = {1, 0}};
    double u = 1;
    for (int k = 1; k < ASYMPTOTIC; k++) {
        u *= (6.0 * k - 5) * (6.0 * k - 3) * (6.0 * k - 1) / (216.0 * k * (2.0 * k - 1) * zeta);
        const double sign = oscillating && k % 4 >= 2 ? -1 : 1;
        s.u[k % 2] += sign * u;
        s.v[k % 2] += sign * u * (6.0 * k + 1) / (1 - 6.0 * k);
    }
    return s;
}

void sp_airy(double x, double *ai, double *slope) {
    const double size = fabs(x);
    if (size <= EDGE) {
        taylor(x, ai, slope);
        return;
    }
    const double zeta = 2 * size * sqrt(size) / 3, root = sqrt(sqrt(size));
    const asymptotic s = sums(zeta, x < 0);
    if (x > 0) {
        const double decay = 0.5 * M_2_SQRTPI / 2 * exp(-zeta);
        *ai = decay / root * (s.u[0] - s.u[1]);
        *slope = -decay * root * (s.v[0] - s.v[1]);
        return;
    }
    const double c = cos(zeta - M_PI_4), q = sin(zeta - M_PI_4);
    *ai = 0.5 * M_2_SQRTPI / root * (c * s.u[0] + q * s.u[1]);
    *slope = 0.5 * M_2_SQRTPI * root * (q * s.v[0] - c * s.v[1]);
}
