/* Reads what sonopack sensitivity differentiates, and by what. */
#include "base/base.h"
#include "cli/sensitivity.h"

#include <stdlib.h>
#include <string.h>

static const struct {
    const char *word;
    sp_front_quantity front;
} fronts[] = {{"t10", SP_FRONT_T10},
              {"t_peak", SP_FRONT_T_PEAK},
              {"peak", SP_FRONT_PEAK},
              {"t_zero", SP_FRONT_T_ZERO},
              {"width", SP_FRONT_WIDTH}};
static const char *const moduli[SP_MODULUS_COUNT] = {"C11", "C12", "C22", "C33", "C13", "C23",
                                                     "C44", "C55", "C66", "cl",  "ct"};
static const char *const parameters[] = {"kn", "kt", "mass", "radius", "position", "pressure"};

/* The names of the table of moduli, c_l and c_t, serve as well. */
static bool is_modulus(const char *word, int k) {
    const char *const name = moduli[k];
    return strcmp(word, name) == 0 ||
           (name[0] == 'c' && strncmp(word, "c_", 2) == 0 && strcmp(word + 2, name + 1) == 0);
}

static sp_status wrong(const char *word, sp_error *err) {
    return sp_fail(err, SP_EINVAL,
                   "--of %.60s: must be t10, t_peak, peak, t_zero, width, F, omega:N, omega:N-M, c_l, c_t or a modulus "
                   "such as C22",
                   word);
}

/* "N" or "N-M". */
static sp_status read_modes(const char *word, const char *text, sensitivity_quantity *out, sp_error *err) {
    char first[32];
    const size_t length = strcspn(text, "-");
    if (length == 0 || length >= sizeof first)
        return wrong(word, err);
    memcpy(first, text, length);
    first[length] = '\0';
    if (cli_integer("--of omega", first, 0, INT32_MAX, &out->first, err) != SP_OK)
        return SP_EINVAL;
    out->last = out->first;
    if (text[length] == '\0')
        return SP_OK;
    return cli_integer("--of omega", text + length + 1, out->first, INT32_MAX, &out->last, err);
}

sp_status sensitivity_read_quantity(const char *word, sensitivity_quantity *out, sp_error *err) {
    sensitivity_quantity q = {.word = word};
    for (size_t k = 0; k < sizeof fronts / sizeof *fronts; k++)
        if (strcmp(word, fronts[k].word) == 0) {
            q.front = fronts[k].front;
            *out = q;
            return SP_OK;
        }
    for (int k = 0; k < SP_MODULUS_COUNT; k++)
        if (is_modulus(word, k)) {
            q.kind = SENSITIVITY_MODULUS;
            q.modulus = (sp_modulus)k;
            *out = q;
            return SP_OK;
        }
    if (strncmp(word, "omega:", 6) == 0) {
        q.kind = SENSITIVITY_OMEGA;
        const sp_status status = read_modes(word, word + 6, &q, err);
        if (status == SP_OK)
            *out = q;
        return status;
    }
    if (strcmp(word, "F") != 0)
        return wrong(word, err);
    q.kind = SENSITIVITY_SIGNAL;
    *out = q;
    return SP_OK;
}

sp_status sensitivity_read_parameters(const char *word, unsigned *out, sp_error *err) {
    enum { CONTACTS = SP_BY_KN | SP_BY_KT, GRAINS = SP_BY_MASS | SP_BY_RADIUS | SP_BY_POSITION };
    unsigned by = 0;
    for (const char *at = word; *at;) {
        const size_t length = strcspn(at, ",");
        size_t k = 0;
        while (k < 6 && (strlen(parameters[k]) != length || strncmp(at, parameters[k], length) != 0))
            k++;
        if (k == 6)
            return sp_fail(err, SP_EINVAL, "--by %.60s: must be a list of kn, kt, mass, radius, position, pressure",
                           word);
        by |= 1U << k;
        at += length + (at[length] == ',');
    }
    const int tables = ((by & CONTACTS) != 0) + ((by & GRAINS) != 0) + ((by & SP_BY_PRESSURE) != 0);
    if (tables != 1)
        return sp_fail(err, SP_EINVAL,
                       "--by %.60s: contacts (kn, kt), grains (mass, radius, position) and the pressure have tables of "
                       "their own: one of them at a time",
                       word);
    /* Euler's theorem, the check of the table, needs both */
    *out = by & CONTACTS ? by | CONTACTS : by;
    return SP_OK;
}

const char *sensitivity_unit(const sensitivity_quantity *of) {
    switch (of->kind) {
    case SENSITIVITY_FRONT: return of->front == SP_FRONT_PEAK ? "E* d^2" : "d/sqrt(E* / rho)";
    case SENSITIVITY_SIGNAL: return "E* d^2";
    case SENSITIVITY_OMEGA: return "E* / (rho d^2)";
    default: return of->modulus >= SP_MODULUS_CL ? "sqrt(E* / rho)" : "E*";
    }
}
