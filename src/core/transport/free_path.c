/* Mean free paths of coherent waves, their errors, and where waves cease to be waves (Ioffe and Regel). */
#include <math.h>
#include <sonopack/coherent.h>

/* Of k and of alpha, from what the wave does not explain: that of a least-squares fit to fluxes that are independent at
 * planes a diameter apart. The weight of a plane in it is the square of the wave. */
static double fit_error(const sp_coherent_section *s, const sp_coherent_wave *c) {
    const double low = s->y[0], span = s->y[s->planes - 1] - low;
    double sum = 0, first = 0, second = 0;
    for (int32_t b = 0; b < s->planes; b++) {
        const double y = s->y[b] - low, weight = exp(-2 * c->alpha * y);
        sum += weight;
        first += weight * y;
        second += weight * y * y;
    }
    const double variance = second / sum - first * first / (sum * sum), count = fmin(s->planes, 1 + span);
    return sqrt((1 - c->part) / (2 * c->part * count * variance));
}

void sp_coherent_errors(const sp_coherent_section *s, const sp_coherent_wave *wave, double *k_err, double *alpha_err) {
    const double error = fit_error(s, wave);
    *k_err = hypot(wave->k_shift, error);
    *alpha_err = hypot(wave->alpha_shift, error);
}

sp_free_path sp_free_path_of(double k, double k_err, double alpha, double alpha_err) {
    sp_free_path p = {NAN, NAN, 0.5 / (fmax(0, alpha) + 2 * alpha_err), NAN, NAN};
    if (alpha > 2 * alpha_err) {
        p.path = 0.5 / alpha;
        p.path_err = p.path * alpha_err / alpha;
        p.k_path = k * p.path;
        p.k_path_err = p.k_path * hypot(k_err / k, alpha_err / alpha);
    }
    return p;
}

bool sp_ioffe_regel(int32_t n, const double *omega, const sp_free_path *path, double *out, double *error) {
    for (int32_t l = 1; l < n; l++) {
        const sp_free_path one = path[l - 1], two = path[l];
        if (!(one.k_path > M_PI && two.k_path <= M_PI))
            continue;
        const double part = (one.k_path - M_PI) / (one.k_path - two.k_path), step = omega[l] - omega[l - 1];
        *out = omega[l - 1] + part * step;
        *error = hypot((1 - part) * one.k_path_err, part * two.k_path_err) * step / (one.k_path - two.k_path);
        return true;
    }
    return false;
}
