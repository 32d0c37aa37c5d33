/* Linear analysis of the printed long-wave equations, which shows why they are refused.
 *
 * Linearise (35), y_tt = -g + (K h^2/m) (A+/3 y_zz - (h/3) (B y_z + e sigma'(0) A+ y_tz) y_zz + h^2 (A-/36 y_zzzz + 2 r
 * sigma'(0) y_z^2 y_zz + ...)), about y = s z + exp(i k z + lambda t). All terms with e vanish, since each contains two
 * of y_zz, y_tz and y_tzz, which are zero in s z. What remains is
 *
 *     lambda^2 = -(K h^2/m) (C k^2 - A- h^2 k^4/36),   C = A+/3 - B h s/3 + 2 r alpha h^2 s^2,
 *
 * with sigma'(0) = alpha. The right-hand side of (37) has the other sign, and so has its lambda^2. Since A- > 0, (35)
 * is elliptic beyond k^2 = 36 C/(A- h^2), with a growth rate proportional to k^2. (37) is elliptic below it; its growth
 * rate is largest at half of that k^2, where lambda = 3 C sqrt(K/(m A-)). No smaller step can cure this, and for (35)
 * the growth is unbounded.
 *
 * A and B are those of (38), with A- = 3/2 + 6 r alpha + 16 r^3 alpha^3 from (36): 6.5 at alpha = 1/h, where the paper
 * prints 13.5.
 *
 * Nor is (35) the expansion that it is meant to be. With phi(X) = X chi(X) and X = 2 r - Dy, (31) reads y_tt = -g +
 * (K/m) times the difference of -phi over two contacts. For (30),
 *
 *     phi = phi(2 r) - (A+/3) Dy + (B/2) Dy^2 - (2 r sigma'''(0)/3) Dy^3 + ...,   sigma'''(0) = -2 alpha^3,
 *
 * so that C = A+/3 - B h s + 2 r sigma'''(0) h^2 s^2: B without the factor 1/3, and a third derivative, as the units
 * require. At alpha = 1/h and s = 1 this is 5/6 + 1 - 2 = -1/6. All three orders are of equal size and the sign is
 * wrong, whereas at the contact, Dy = h, the slope of phi is chi(0) = 1/2. */
#include "base/base.h"
#include "tapped/column.h"

typedef struct printed {
    double plus, minus, b; /* A+, A- of (36), B */
} printed;

static printed coefficients(double r, double alpha) {
    double x = r * alpha;
    return (printed){
        .plus = 1.5 + 6 * x - 16 * x * x * x, .minus = 1.5 + 6 * x + 16 * x * x * x, .b = alpha * (1 - 8 * x * x)};
}

/* C of (35). Its last term, as printed, has the unit cm^2. */
static double leading_coefficient(const printed *a, double r, double alpha, double slope) {
    double h = 2 * r;
    return a->plus / 3 - a->b * h * slope / 3 + 2 * r * alpha * h * h * slope * slope;
}

double sp_tapped_expansion_speed2(const sp_tapped_spec *c, double alpha, double slope) {
    double r = sp_tapped_radius(c, 1), h = 2 * r, x = h * alpha;
    printed a = coefficients(r, alpha);
    return sp_tapped_stiffness(c) * h * h / sp_tapped_mass(c, 1) *
           (a.plus / 3 - a.b * h * slope - 2 * x * x * x * slope * slope);
}

/* The long wave: (1 + h^2 k^2/12) lambda^2 + (K e alpha_v delta h^2/m) k^2 lambda + (K h^2/m) k^2 = 0, delta = h (1 -
 * s). Open contacts, s > 1, have neither stiffness nor damping. */
static sp_tapped_symbol longwave(const sp_tapped_spec *c, double slope, double k) {
    double h = 2 * sp_tapped_radius(c, 1), x = h * h * k * k;
    double frequency2 = slope <= 1 ? sp_tapped_stiffness(c) / sp_tapped_mass(c, 1) * x / (1 + x / 12) : 0;
    double damping = 0.5 * frequency2 * c->e * c->alpha_v * h * fmax(0, 1 - slope);
    double under = frequency2 - damping * damping;
    return (sp_tapped_symbol){.growth = under < 0 ? -frequency2 / (damping + sqrt(-under)) : -damping,
                              .speed2 = fmax(0, under) / (k * k)};
}

sp_status sp_tapped_symbol_at(const sp_tapped_spec *c, sp_tapped_model model, double alpha, double slope, double k,
                              sp_tapped_symbol *out, sp_error *err) {
    if (model != SP_TAPPED_EQ35 && model != SP_TAPPED_EQ37 && model != SP_TAPPED_LONGWAVE)
        return sp_fail(err, SP_EINVAL, "column: model %d has no symbol; must be (35), (37) or the long wave",
                       (int)model);
    if (!(k > 0 && isfinite(k) && alpha > 0 && isfinite(alpha) && isfinite(slope)))
        return sp_fail(
            err, SP_EINVAL,
            "column: wave at k = %g /cm, alpha = %g /cm, slope %g: k and alpha must be positive, all must be finite", k,
            alpha, slope);
    if (model == SP_TAPPED_LONGWAVE) {
        *out = longwave(c, slope, k);
        return SP_OK;
    }
    double r = sp_tapped_radius(c, 1), h = 2 * r;
    printed a = coefficients(r, alpha);
    double speed2 = sp_tapped_stiffness(c) * h * h / sp_tapped_mass(c, 1) *
                    (leading_coefficient(&a, r, alpha, slope) - a.minus * h * h * k * k / 36);
    if (model == SP_TAPPED_EQ37)
        speed2 = -speed2;
    *out = (sp_tapped_symbol){.growth = speed2 < 0 ? k * sqrt(-speed2) : 0, .speed2 = speed2};
    return SP_OK;
}

/* The k of the largest growth of (37), for slope 1 and alpha = 1/h as in [B]. (35) has none; for it, the largest k of
 * the paper's grid. */
static double worst_wavenumber(const sp_tapped_spec *c, double step) {
    double r = sp_tapped_radius(c, 1), h = 2 * r;
    printed a = coefficients(r, 1 / h);
    return c->model == SP_TAPPED_EQ37 ? sqrt(18 * leading_coefficient(&a, r, 1 / h, 1) / a.minus) / h : M_PI / step;
}

sp_status sp_tapped_refuse_printed(const sp_tapped_spec *c, const sp_tapped_rows *rows, sp_tapped_report *report,
                                   sp_error *err) {
    (void)rows, (void)report;
    const double h = 2 * sp_tapped_radius(c, 1), step = 0.01, k = worst_wavenumber(c, step);
    const double speed = h * sqrt(sp_tapped_stiffness(c) / sp_tapped_mass(c, 1));
    sp_tapped_symbol symbol;
    sp_status status = sp_tapped_symbol_at(c, c->model, 1 / h, 1, k, &symbol, err);
    if (status != SP_OK)
        return status;
    return sp_fail(
        err, SP_EREFUSED,
        "column.model = \"%s\": ill posed as printed: waves of k = %.3g /cm grow at %.4g /s%s; steps of 0.01 s and "
        "0.01 cm are a CFL number of %.4g; the expansion that is meant has c^2 = %.3g K h^2/m at the contact, the "
        "lattice 0.5; take \"longwave\"",
        c->model == SP_TAPPED_EQ37 ? "eq37" : "eq35", k, symbol.growth,
        c->model == SP_TAPPED_EQ37 ? ", the most of all" : ", and without bound in k", speed,
        sp_tapped_expansion_speed2(c, 1 / h, 1) / (speed * speed));
}
