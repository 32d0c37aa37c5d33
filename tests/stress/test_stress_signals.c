/* Every method of the signal on every hard network, for short and long times, against quadruple precision: its own
 * error bound holds, or it refuses. */
#include "stress/exact.h"
#include "stress/networks.h"
#include "stress/record.h"

enum { POINTS = 23, PLACES = 2, PAIRS = PLACES * PLACES };

/* What a run is asked for; lengths in 1/Omega. */
typedef struct asked {
    sp_source source;
    double length, tolerance;
} asked;

/* Sources and detectors: the whole walls where they are touched, and single grains. */
static sp_signal_options options_of(const sp_network *net, const asked *a, sp_place from[PLACES], sp_place to[PLACES]) {
    sp_signal_options o = sp_signal_options_default();
    RELEASED double *scratch = calloc((size_t)sp_network_dofs(net), sizeof *scratch);
    sp_error err;
    for (int k = 0; k < PLACES; k++) {
        from[k] = to[k] = sp_place_wall();
        if (k > 0 || sp_network_source_at(net, a->source, &from[k], scratch, &err) != SP_OK)
            from[k] = (sp_place){.kind = SP_PLACE_GRAIN, .grain = net->grain[0]};
        if (k > 0 || sp_network_detector_at(net, &to[k], scratch, &err) != SP_OK)
            to[k] = (sp_place){.kind = SP_PLACE_GRAIN, .grain = net->grain[net->n - 1]};
    }
    o.source = a->source;
    o.until = a->length / net->omega_bound;
    o.points = POINTS;
    o.tolerance = a->tolerance;
    o.sources = o.detectors = PLACES;
    o.from = from;
    o.to = to;
    return o;
}

/* [PAIRS][POINTS] */
static void exact_pairs(const exact *x, const sp_network *net, const sp_signal_options *o, quad *f) {
    const bool velocity = o->source != SP_SOURCE_DISPLACEMENT;
    RELEASED quad *ab = calloc((size_t)x->n, sizeof *ab);
    double *sent = calloc(2 * (size_t)x->n, sizeof *sent), *seen = sent + x->n, t[POINTS];
    for (int l = 0; l < POINTS; l++)
        t[l] = l < POINTS - 1 ? o->until * l / (POINTS - 1) : o->until;
    for (int a = 0; a < PLACES; a++)
        for (int b = 0; b < PLACES; b++) {
            assert_ok(sp_network_source_at(net, o->source, &o->from[a], sent, &err));
            assert_ok(sp_network_detector_at(net, &o->to[b], seen, &err));
            exact_weights(x, net, velocity, sent, seen, ab);
            exact_signal(x, velocity, ab, POINTS, t, f + (a * PLACES + b) * POINTS);
        }
    free(sent);
}

static void compare(stress_record *r, const char *network, const char *what, const sp_signal *s, const quad *f) {
    for (int pair = 0; pair < PAIRS; pair++) {
        quad worst = 0;
        double peak = 0;
        for (int l = 0; l < POINTS; l++) {
            const quad off = quad_abs(s->f[pair * POINTS + l] - f[pair * POINTS + l]);
            worst = off > worst || !(off <= worst) ? off : worst;
            peak = fmax(peak, fabs((double)f[pair * POINTS + l]));
        }
        char label[128];
        snprintf(label, sizeof label, "%s, pair %d", what, pair);
        stress_agree(r, network, sp_signal_method_name(s->method), label, (double)worst, s->errors[pair],
                     peak > 0 ? peak : 1);
    }
}

/* One method. Returns the one that was used, SP_SIGNAL_AUTO where it refused. */
static sp_signal_method run_method(stress_record *r, const char *network, const char *what, const sp_network *net,
                                   const sp_signal_options *o, const quad *f) {
    FREED(sp_signal) s = sp_signal_none();
    sp_error err = {0};
    sp_signal_method used = SP_SIGNAL_AUTO;
    const sp_status status = sp_signal_make(net, o, &s, &err);
    if (status == SP_OK) {
        used = s.method;
        compare(r, network, what, &s, f);
    } else
        stress_refuse(r, network, sp_signal_method_name(o->method), what, status, &err);
    return used;
}

/* Steps or products that a run may take, and of how many cases one is followed through a million products; dynamics
 * needs a packing that moves. */
#ifdef STRESS_LONG
enum { STRESS_WORK = 1000000, STRESS_MILLION = 1 };
#else
enum { STRESS_WORK = 20000, STRESS_MILLION = 13 };
#endif
static bool worthwhile(sp_signal_method method, const asked *a, int index) {
    switch (method) {
    case SP_SIGNAL_VERLET: return a->tolerance > 1e-7 && pow(a->length, 1.5) / sqrt(a->tolerance) < STRESS_WORK;
    case SP_SIGNAL_LAX_WENDROFF: return pow(a->length, 1.25) / sqrt(sqrt(a->tolerance)) < STRESS_WORK;
    case SP_SIGNAL_FABER: return a->length < STRESS_WORK;
    case SP_SIGNAL_CHEBYSHEV: return a->length < 1e6 || index % STRESS_MILLION == 0;
    case SP_SIGNAL_DYNAMICS: return false;
    default: return true;
    }
}

/* Whether method `auto` served it. */
static bool run(stress_record *r, const char *network, const sp_network *net, const exact *x, const asked *a,
                int index) {
    sp_place from[PLACES], to[PLACES];
    sp_signal_options o = options_of(net, a, from, to);
    quad f[PAIRS * POINTS];
    char what[80];
    exact_pairs(x, net, &o, f);
    snprintf(what, sizeof what, "%s, T = %.0e, tolerance %.0e",
             a->source == SP_SOURCE_DISPLACEMENT ? "displacement" : "impulse", a->length, a->tolerance);
    const sp_signal_method chosen = run_method(r, network, what, net, &o, f);
    for (int method = SP_SIGNAL_AUTO + 1; sp_signal_method_name((sp_signal_method)method); method++) {
        o.method = (sp_signal_method)method;
        if (o.method != chosen && worthwhile(o.method, a, index))
            run_method(r, network, what, net, &o, f);
    }
    return chosen != SP_SIGNAL_AUTO;
}

static void run_case(stress_record *r, const stress_case *c, uint64_t seed, int index, int *unserved) {
    static const asked all[] = {{SP_SOURCE_IMPULSE, 3, 1e-8},    {SP_SOURCE_IMPULSE, 100, 1e-3},
                                {SP_SOURCE_IMPULSE, 100, 1e-10}, {SP_SOURCE_IMPULSE, 1e4, 1e-3},
                                {SP_SOURCE_VELOCITY, 1e3, 1e-6}, {SP_SOURCE_DISPLACEMENT, 100, 1e-6},
                                {SP_SOURCE_IMPULSE, 1e6, 1e-3},  {SP_SOURCE_DISPLACEMENT, 1e6, 1e-2}};
    FREED(sp_network) net = c->make(c->value, seed);
    FREED(exact) x = exact_solve(&net);
    for (size_t q = 0; q < sizeof all / sizeof *all; q++)
        if (!run(r, c->name, &net, &x, &all[q], index + (int)q) && all[q].tolerance >= c->served &&
            all[q].length < 1e5) {
            print_message("%s is not served: T = %g, tolerance %g\n", c->name, all[q].length, all[q].tolerance);
            ++*unserved;
        }
}

TEST(test_signals) {
    stress_record r = stress_open();
    int unserved = 0;
#ifdef STRESS_LONG
    const char *given = getenv("SONOPACK_STRESS_SEED"); /* another sweep */
    const uint64_t first = given ? strtoull(given, NULL, 10) : 2, last = first + 3;
#else
    const uint64_t first = 1, last = 1;
#endif
    for (uint64_t seed = first; seed <= last; seed++) {
        print_message("seed %llu\n", (unsigned long long)seed);
        for (int k = 0; k < STRESS_CASES; k++)
            run_case(&r, &stress_cases[k], seed, k, &unserved);
    }
    stress_close(&r);
    assert_int_equal(r.wrong, 0);
    assert_int_equal(unserved, 0);
}

RUN_TESTS_WHERE(STRESS_QUAD, NULL, NULL)
