/* Chebyshev maps of motions: filters and steps in time. */
#include "transport/packet.h"

#include "base/base.h"
#include "network/apply.h"
#include "numeric/bessel.h"

#include <math.h>
#include <string.h>

enum { TERMS_MAX = 20000000, BAND_TERMS_MAX = 20000 };

sp_status sp_packet_space_make(const sp_network *net, packet_space *out, sp_error *err) {
    packet_space s = {.net = net, .n = sp_network_dofs(net), .omega = sp_network_omega_bound(net)};
    const size_t size = 2 * (size_t)s.n;
    const sp_status status = sp_network_need_symmetry(net, "the transport of energy", err);
    if (status != SP_OK)
        return status;
    s.t = sp_alloc(size, 4 * sizeof *s.t);
    s.energy = sp_alloc((size_t)net->n, sizeof *s.energy);
    if (!s.t || !s.energy) {
        sp_packet_space_free(&s);
        return sp_fail_memory(err, size * 4 * sizeof *s.t);
    }
    s.step = s.t + size;
    s.force = s.step + size;
    s.sum = s.force + size;
    *out = s;
    return SP_OK;
}

void sp_packet_space_free(packet_space *s) {
    sp_free(s->t);
    sp_free(s->energy);
    *s = (packet_space){0};
}

void sp_packet_map_free(packet_map *m) {
    sp_free(m->same);
    sp_free(m->lift);
    sp_free(m->push);
    *m = (packet_map){0};
}

/* cos(Omega t sin(theta/2)) = J_0 + 2 sum_k J_2k T_k, its derivative in time, and its integral: the sum over k of
 * J_(2k+1) W_k, where W_k = 1 + 2 sum_(m <= k) T_m. */
sp_status sp_packet_map_time(double omega_max, double t, packet_map *out, sp_error *err) {
    const double x = omega_max * t;
    if (!(t >= 0 && isfinite(t)))
        return sp_fail(err, SP_EINVAL, "time %g of a motion: must be 0 or above", t);
    if (!(x < TERMS_MAX))
        return sp_fail(err, SP_EREFUSED, "time %g needs %.3g matrix products, must be at most %d", t, 0.5 * x,
                       TERMS_MAX / 2);
    const int64_t orders = sp_bessel_orders(x) + 2;
    packet_map m = {.terms = (orders - 1) / 2};
    double *j = sp_alloc((size_t)orders, sizeof *j);
    m.same = sp_alloc((size_t)m.terms, sizeof *m.same);
    m.lift = sp_alloc((size_t)m.terms, sizeof *m.lift);
    m.push = sp_alloc((size_t)m.terms, sizeof *m.push);
    if (!j || !m.same || !m.lift || !m.push) {
        sp_free(j);
        sp_packet_map_free(&m);
        return sp_fail_memory(err, (size_t)orders * 4 * sizeof *j);
    }
    sp_bessel_j(x, orders, j);
    double rest = 0;
    for (int64_t k = m.terms - 1; k >= 0; k--) {
        const double twice = k > 0 ? 2 : 1;
        rest += j[2 * k + 1];
        m.same[k] = twice * j[2 * k];
        m.lift[k] = twice * 2 / omega_max * rest;
        m.push[k] = k > 0 ? omega_max * (j[2 * k - 1] - j[2 * k + 1]) : -omega_max * j[1];
    }
    sp_free(j);
    *out = m;
    return SP_OK;
}

static double band(double w, double omega, double width) {
    const double below = (w - omega) / width, above = (w + omega) / width;
    return exp(-0.5 * below * below) + exp(-0.5 * above * above);
}

/* The filter as a function of theta is periodic and smooth, so that the trapezoidal rule gives its coefficients. */
static void band_coefficients(double omega_max, double omega, double width, int64_t points, double *cosine, double *g,
                              packet_map *m) {
    for (int64_t l = 0; l < 4 * points; l++)
        cosine[l] = cos(0.5 * M_PI * (double)l / (double)points);
    for (int64_t l = 0; l < points; l++)
        g[l] = band(omega_max * sin(0.5 * M_PI * ((double)l + 0.5) / (double)points), omega, width);
    for (int64_t k = 0; k < m->terms; k++) {
        double sum = 0;
        for (int64_t l = 0, at = k; l < points; l++, at = (at + 2 * k) % (4 * points))
            sum += g[l] * cosine[at];
        m->same[k] = (k > 0 ? 2 : 1) * sum / (double)points;
    }
}

sp_status sp_packet_map_band(double omega_max, double omega, double width, packet_map *out, sp_error *err) {
    const double terms = 32 + 4 * omega_max / width;
    if (!(terms < BAND_TERMS_MAX))
        return sp_fail(err, SP_EREFUSED, "a band of width %g at %g needs %.3g matrix products, must be at most %d",
                       width, omega, terms, BAND_TERMS_MAX);
    packet_map m = {.terms = (int64_t)terms};
    const int64_t points = 2 * m.terms;
    double *work = sp_alloc((size_t)points, 5 * sizeof *work);
    m.same = sp_alloc((size_t)m.terms, sizeof *m.same);
    if (!work || !m.same) {
        sp_free(work);
        sp_packet_map_free(&m);
        return sp_fail_memory(err, (size_t)points * 5 * sizeof *work);
    }
    band_coefficients(omega_max, omega, width, points, work + points, work, &m);
    sp_free(work);
    *out = m;
    return SP_OK;
}

static void add_term(packet_space *s, const packet_map *m, int64_t k) {
    const double same = m->same[k], lift = m->lift ? m->lift[k] : 0, push = m->push ? m->push[k] : 0;
    double *restrict sum = s->sum;
    const double *restrict t = s->t;
    for (int64_t i = 0; i < s->n; i++) {
        sum[2 * i] += same * t[2 * i] + lift * t[2 * i + 1];
        sum[2 * i + 1] += same * t[2 * i + 1] + push * t[2 * i];
    }
}

/* T_(k+1) - T_k = T_k - T_(k-1) - (4/Omega^2) M^-1 K T_k, a form that keeps rounding errors small. */
static void next_term(packet_space *s, double factor) {
    const sp_network *net = s->net;
    const double *restrict force = s->force;
    double *restrict t = s->t, *restrict step = s->step;
    memset(s->force, 0, 2 * (size_t)s->n * sizeof *s->force);
    sp_network_add_pair(net, s->t, s->force);
    for (int64_t i = 0; i < s->n; i++) {
        const double part = factor / (s->omega * s->omega * net->mass[i]);
        for (int lane = 0; lane < 2; lane++) {
            step[2 * i + lane] -= part * force[2 * i + lane];
            t[2 * i + lane] += step[2 * i + lane];
        }
    }
}

void sp_packet_apply(packet_space *s, const packet_map *m, double *motion) {
    const size_t bytes = 2 * (size_t)s->n * sizeof *motion;
    memcpy(s->t, motion, bytes);
    memset(s->step, 0, bytes);
    memset(s->sum, 0, bytes);
    for (int64_t k = 0; k < m->terms; k++) {
        add_term(s, m, k);
        if (k + 1 < m->terms)
            next_term(s, k == 0 ? 2 : 4);
    }
    memcpy(motion, s->sum, bytes);
}

double sp_packet_energy(packet_space *s, const double *motion) {
    double sum = 0;
    memset(s->force, 0, 2 * (size_t)s->n * sizeof *s->force);
    sp_network_add_pair(s->net, motion, s->force);
    for (int64_t i = 0; i < s->n; i++)
        sum += s->net->mass[i] * motion[2 * i + 1] * motion[2 * i + 1] + motion[2 * i] * s->force[2 * i];
    return 0.5 * sum;
}

double *sp_packet_parts(packet_space *s, const double *motion) {
    for (int64_t i = 0; i < s->n; i++) {
        s->sum[i] = motion[2 * i];
        s->sum[s->n + i] = motion[2 * i + 1];
    }
    return s->sum;
}

sp_status sp_packet_energies(packet_space *s, const double *motion, sp_error *err) {
    const double *parts = sp_packet_parts(s, motion);
    return sp_transport_energy(s->net, parts, parts + s->n, s->energy, err);
}

sp_status sp_packet_check_drift(double ratio, double *drift, sp_error *err) {
    *drift = fmax(*drift, fabs(ratio - 1));
    return *drift < 1e-6
               ? SP_OK
               : sp_fail(err, SP_EREFUSED, "the energy of the motion changes by %.3g: the network is unstable", *drift);
}

sp_status sp_packet_check_band(const char *what, double omega, double width, sp_error *err) {
    if (!(omega > 0 && isfinite(omega)))
        return sp_fail(err, SP_EINVAL, "%s: frequency %g, must be above 0", what, omega);
    if (!(width >= 1e-3 && width <= 0.5))
        return sp_fail(err, SP_EINVAL, "%s: width %g of the band, must be 0.001 .. 0.5", what, width);
    return SP_OK;
}

sp_status sp_packet_band(const packet_space *s, double omega, double width, packet_map *out, sp_error *err) {
    return sp_packet_map_band(s->omega, omega, M_SQRT2 * width * omega, out, err);
}

sp_status sp_packet_filter(packet_space *s, const packet_map *band, double omega, double *motion, double *energy,
                           sp_error *err) {
    const double before = sp_packet_energy(s, motion);
    sp_packet_apply(s, band, motion);
    const double left = sp_packet_energy(s, motion);
    if (!(left > 1e-12 * before))
        return sp_fail(err, SP_EREFUSED, "no mode has a frequency near %g", omega);
    if (energy)
        *energy = left;
    return SP_OK;
}

sp_status sp_packet_impulse(packet_space *s, double *motion, sp_error *err) {
    const sp_status status = sp_network_source(s->net, SP_SOURCE_IMPULSE, s->sum, err);
    for (int64_t q = 0; q < s->n && status == SP_OK; q++) {
        motion[2 * q] = 0;
        motion[2 * q + 1] = s->sum[q] / s->net->mass[q];
    }
    return status;
}

sp_status sp_transport_advance(const sp_network *net, double t, double *u, double *v, double *drift, sp_error *err) {
    packet_space s = {0};
    packet_map m = {0};
    double *motion = NULL, change = 0;
    sp_status status = sp_packet_space_make(net, &s, err);
    if (status == SP_OK)
        status = sp_packet_map_time(s.omega, t, &m, err);
    if (status == SP_OK && !(motion = sp_alloc(2 * (size_t)s.n, sizeof *motion)))
        status = sp_fail_memory(err, 2 * (size_t)s.n * sizeof *motion);
    for (int64_t i = 0; i < s.n && status == SP_OK; i++) {
        motion[2 * i] = u[i];
        motion[2 * i + 1] = v[i];
    }
    if (status == SP_OK) {
        const double before = sp_packet_energy(&s, motion);
        sp_packet_apply(&s, &m, motion);
        status = sp_packet_check_drift(before != 0 ? sp_packet_energy(&s, motion) / before : 1, &change, err);
    }
    if (status == SP_OK) {
        const double *parts = sp_packet_parts(&s, motion);
        memcpy(u, parts, (size_t)s.n * sizeof *u);
        memcpy(v, parts + s.n, (size_t)s.n * sizeof *v);
        if (drift)
            *drift = change;
    }
    sp_free(motion);
    sp_packet_map_free(&m);
    sp_packet_space_free(&s);
    return status;
}
