#ifndef PROPERTIES_CLAIMS_H
#define PROPERTIES_CLAIMS_H
/* The count of what was found: every property of every random scene is a check of a claim, whose error is compared with
 * a bound that the program reports or that rounding gives. */
#include "numeric/random.h"
#include "test.h"

#include <sonopack/status.h>

enum { CLAIMS_MOST = 80 };

typedef struct claim {
    const char *name;
    int64_t checks, refused, wrong;
    double closest; /* largest error over its bound */
    uint64_t scene; /* of this */
} claim;

typedef struct claims {
    claim all[CLAIMS_MOST];
    int n;
    uint64_t scene; /* seed of the scene at work */
    const char *words;
} claims;

static inline claim *claims_find(claims *c, const char *name) {
    for (int k = 0; k < c->n; k++)
        if (strcmp(c->all[k].name, name) == 0)
            return &c->all[k];
    assert_true(c->n < CLAIMS_MOST);
    c->all[c->n] = (claim){.name = name};
    return &c->all[c->n++];
}

/* error <= bound; a NAN is wrong. A bound of 0 asks for an error of 0. */
static inline void claims_check(claims *c, const char *name, double error, double bound) {
    claim *k = claims_find(c, name);
    const double ratio = error > 0 ? error / bound : 0;
    k->checks++;
    if (ratio > k->closest) {
        k->closest = ratio;
        k->scene = c->scene;
    }
    if (error <= bound && isfinite(bound))
        return;
    if (k->wrong++ < 5)
        print_message("WRONG: %s: error %.3g, bound %.3g; scene %llu: %s\n", name, error, bound,
                      (unsigned long long)c->scene, c->words);
}

/* A statement that is true or false. */
static inline void claims_true(claims *c, const char *name, bool truth) { claims_check(c, name, truth ? 0 : 1, 0.5); }

/* Whether a call served; what it did not has to be refused, with a reason. */
static inline bool claims_served(claims *c, const char *name, sp_status status, const sp_error *err) {
    claim *k = claims_find(c, name);
    if (status == SP_OK)
        return true;
    k->refused++;
    if (status != SP_EREFUSED || !*err->text) {
        print_message("%s: %s (%s)\n", name, err->text, sp_status_name(status));
        claims_check(c, name, 1, 0);
    }
    if (getenv("SONOPACK_PROPERTIES_REASONS"))
        print_message("refused: %s: scene %llu: %s\n", name, (unsigned long long)c->scene, err->text);
    return false;
}

static inline void claims_close(const claims *c) {
    int64_t checks = 0, refused = 0, wrong = 0;
    print_message("%-34s %9s %8s %6s %9s  %s\n", "claim", "checks", "refused", "wrong", "closest", "scene");
    for (int k = 0; k < c->n; k++) {
        const claim *a = &c->all[k];
        print_message("%-34s %9lld %8lld %6lld %9.2g  %llu\n", a->name, (long long)a->checks, (long long)a->refused,
                      (long long)a->wrong, a->closest, (unsigned long long)a->scene);
        checks += a->checks;
        refused += a->refused;
        wrong += a->wrong;
    }
    print_message("%lld checks, %lld refused, %lld wrong\n", (long long)checks, (long long)refused, (long long)wrong);
    assert_int_equal(wrong, 0);
}

/* ---- which scenes ---------------------------------------------------------------------------------------------- */

static inline uint64_t claims_number(const char *name, uint64_t usual) {
    const char *given = getenv(name);
    return given ? strtoull(given, NULL, 10) : usual;
}

/* Runs a number of scenes: SONOPACK_PROPERTIES_SCENES of them, from the seed SONOPACK_PROPERTIES_SEED on. */
static inline void claims_scenes(claims *c, uint64_t usual, void (*scene)(claims *, sp_random *)) {
    const uint64_t first = claims_number("SONOPACK_PROPERTIES_SEED", 1),
                   count = claims_number("SONOPACK_PROPERTIES_SCENES", usual);
    print_message("scenes %llu to %llu\n", (unsigned long long)first, (unsigned long long)(first + count - 1));
    for (c->scene = first; c->scene < first + count; c->scene++) {
        sp_random draw = sp_random_make(c->scene, 0);
        c->words = "";
        scene(c, &draw);
    }
}

/* Runs the scenes that found something: it must stay mended. */
static inline void claims_known(claims *c, int count, const uint64_t *known, void (*scene)(claims *, sp_random *)) {
    for (int k = 0; k < count; k++) {
        sp_random draw = sp_random_make(c->scene = known[k], 0);
        c->words = "";
        scene(c, &draw);
    }
}

static inline bool chance(sp_random *draw, double p) { return sp_random_uniform(draw) < p; }
static inline double between(sp_random *draw, double low, double high) {
    return low + (high - low) * sp_random_uniform(draw);
}
static inline int whole(sp_random *draw, int low, int high) {
    return low + (int)sp_random_below(draw, (uint64_t)(high - low + 1));
}
static inline double one_of(sp_random *draw, int count, const double *of) {
    return of[sp_random_below(draw, (uint64_t)count)];
}

#endif
