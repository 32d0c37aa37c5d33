/* Reads numbers, words and lists of frequencies from the arguments of options. */
#include "base/base.h"
#include "cli/cli.h"
#include "scene/field.h"

#include <errno.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* Digits, signs, points and exponents only: strtod would also take "nan", "0x1p3" and leading blanks. */
static bool is_decimal(const char *text) { return *text && text[strspn(text, "0123456789+-.eE")] == '\0'; }

sp_status cli_number(const char *option, const char *text, double low, double high, double *out, sp_error *err) {
    char *end = NULL;
    const double value = is_decimal(text) ? strtod(text, &end) : NAN;
    if (!end || end == text || *end || !isfinite(value) || value < low || value > high)
        return sp_fail(err, SP_EINVAL, "%s %.60s: must be a number %g .. %g", option, text, low, high);
    *out = value;
    return SP_OK;
}

sp_status cli_integer(const char *option, const char *text, int64_t low, int64_t high, int64_t *out, sp_error *err) {
    char *end = NULL;
    errno = 0;
    const long long value = is_decimal(text) ? strtoll(text, &end, 10) : 0;
    if (!end || end == text || *end || errno || value < low || value > high)
        return sp_fail(err, SP_EINVAL, "%s %.60s: must be an integer %lld .. %lld", option, text, (long long)low,
                       (long long)high);
    *out = value;
    return SP_OK;
}

/* The number in the first `length' characters. */
static sp_status part_number(const char *option, const char *text, size_t length, double low, double high, double *out,
                             sp_error *err) {
    char word[64];
    if (length >= sizeof word)
        return sp_fail(err, SP_EINVAL, "%s %.60s: must be a number %g .. %g", option, text, low, high);
    snprintf(word, sizeof word, "%.*s", (int)length, text);
    if (isfinite(high) || strcmp(word, "inf") != 0)
        return cli_number(option, word, low, high, out, err);
    *out = INFINITY;
    return SP_OK;
}

sp_status cli_numbers(const char *option, const char *text, double low, double high, int32_t capacity, int32_t *n,
                      double *out, sp_error *err) {
    for (*n = 0;; text++) {
        const size_t length = strcspn(text, ",");
        if (*n == capacity)
            return sp_fail(err, SP_EINVAL, "%s: more than %d numbers", option, capacity);
        const sp_status status = part_number(option, text, length, low, high, &out[(*n)++], err);
        text += length;
        if (status != SP_OK || *text == '\0')
            return status;
    }
}

sp_status cli_pair(const char *option, const char *text, double low, double high, double out[2], sp_error *err) {
    const char *colon = strchr(text, ':');
    if (!colon)
        return sp_fail(err, SP_EINVAL, "%s %.60s: must be LOW:HIGH", option, text);
    sp_status status = part_number(option, text, (size_t)(colon - text), low, high, &out[0], err);
    CLI_THEN(status, part_number(option, colon + 1, strlen(colon + 1), low, high, &out[1], err));
    if (status == SP_OK && !(out[0] < out[1]))
        status = sp_fail(err, SP_EINVAL, "%s %.60s: LOW must be below HIGH", option, text);
    return status;
}

/* ---- words ------------------------------------------------------------------------------------------------------- */

const char *const cli_source_names[] = {[SP_SOURCE_IMPULSE] = "impulse",
                                        [SP_SOURCE_VELOCITY] = "velocity",
                                        [SP_SOURCE_DISPLACEMENT] = "displacement",
                                        NULL};
const char *const cli_solver_names[] = {[SP_SOLVER_AUTO] = "auto",
                                        [SP_SOLVER_LANCZOS] = "lanczos",
                                        [SP_SOLVER_ARPACK] = "arpack",
                                        [SP_SOLVER_DENSE] = "dense",
                                        NULL};

char *cli_list_words(const char *const *words, char *text, size_t size) {
    size_t used = 0;
    *text = '\0';
    for (int k = 0; words[k] && used < size; k++)
        used += (size_t)snprintf(text + used, size - used, "%s%s",
                                 k == 0         ? ""
                                 : words[k + 1] ? ", "
                                                : " or ",
                                 words[k]);
    return text;
}

static const char *nth_word(int k, const void *words) { return ((const char *const *)words)[k]; }

sp_status cli_choose(const char *option, const char *word, const char *const *words, int *out, sp_error *err) {
    char list[400];
    for (int k = 0; words[k]; k++)
        if (strcmp(word, words[k]) == 0) {
            *out = k;
            return SP_OK;
        }
    const int near = cli_nearest(word, nth_word, words);
    cli_list_words(words, list, sizeof list);
    if (near >= 0)
        return sp_fail(err, SP_EINVAL, "%s %.60s: did you mean %s? must be %s", option, word, words[near], list);
    return sp_fail(err, SP_EINVAL, "%s %.60s: must be %s", option, word, list);
}

int cli_nearest(const char *word, const char *(*name)(int k, const void *user), const void *user) {
    int near = -1, least = 1000;
    for (int k = 0; name(k, user); k++) {
        const int distance = sp_edit_distance(word, name(k, user));
        if (distance < least && sp_is_near(word, distance)) {
            least = distance;
            near = k;
        }
    }
    return near;
}

/* ---- frequencies ------------------------------------------------------------------------------------------------- */

static const double frequency_low = 1e-12, frequency_high = 1e9;

static sp_status wrong_frequencies(const char *text, sp_error *err) {
    return sp_fail(err, SP_EINVAL, "--at %.60s: must be W1,W2,... or LOW:HIGH:N", text);
}

static sp_status parse_range(const char *text, int32_t capacity, int32_t *n, double *omega, sp_error *err) {
    const char *one = strchr(text, ':'), *two = strchr(one + 1, ':');
    char pair[128];
    double range[2];
    int64_t count;
    snprintf(pair, sizeof pair, "%.*s", two ? (int)(two - text) : 0, text);
    if (!two || strlen(pair) < (size_t)(two - text))
        return wrong_frequencies(text, err);
    sp_status status = cli_pair("--at", pair, frequency_low, frequency_high, range, err);
    CLI_THEN(status, cli_integer("--at: N", two + 1, 2, capacity, &count, err));
    if (status != SP_OK)
        return status;
    *n = (int32_t)count;
    for (int32_t l = 0; l < *n; l++)
        omega[l] = l < *n - 1 ? range[0] + (range[1] - range[0]) * l / (*n - 1) : range[1];
    return SP_OK;
}

sp_status cli_frequencies(const char *text, int32_t capacity, int32_t *n, double *omega, sp_error *err) {
    return strchr(text, ':') ? parse_range(text, capacity, n, omega, err)
                             : cli_numbers("--at", text, frequency_low, frequency_high, capacity, n, omega, err);
}
